//! The region that a molecule excludes for the centre of a round probe: its boundary, perimeter and
//! area.
//!
//! The centre of a probe of radius r cannot be nearer than sᵢ = ρᵢ + r to the centre of atom i, nor
//! nearer than that to the line of an edge of radius ρᵢ, nor inside a filled ring of edges. The
//! region is the union of all these points and of the pockets that they enclose, which a probe from
//! outside cannot reach. Its boundary consists of arcs of circles and of straight sides. On an arc,
//! the direction of the contact normal is the angle on the arc; along a side it is constant.
//!
//! At equilibrium an ideal gas hits each piece ds of the boundary with equal probability, and the
//! mean free path of one probe on a torus of area A around a fixed molecule is π (A − A_excluded) /
//! P (Santaló 1976, "Integral geometry and geometric probability"). The free path, the directions
//! of impulses and the share of each part thus follow from the boundary alone.

#[cfg(test)]
mod edge_tests;
mod ellipse;
mod outline;
#[cfg(test)]
mod tests;

pub(crate) use outline::closed_curves;

use std::f64::consts::{PI, TAU};

use glam::DVec2;

use crate::{
    GeometryError, Molecule, boundary::Curve, boundary_point::BoundaryPoint, check_length,
    exposed_arc::ExposedArc, exposed_side::ExposedSide, union::Union,
};

/// The region that a molecule excludes for the centre of a round probe, in the molecule's own
/// frame.
///
/// ```
/// use carom_geometry::{ExcludedRegion, Molecule, Shape};
///
/// // The tee of Montanari (2017) with atoms a quarter of the size of the gas discs: the middle
/// // of its stem cannot be touched.
/// let tee = Molecule::named(Shape::Tee, 0.0025, 2.0)?;
/// let region = ExcludedRegion::new(&tee, 0.01)?;
/// assert_eq!(region.unreachable(), [3]);
/// // From above, the three atoms of the bar can be touched; from below right, wing and foot.
/// assert_eq!(region.exposure(90f64.to_radians()), 3);
/// assert_eq!(region.exposure(-30f64.to_radians()), 2);
/// # Ok::<(), carom_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[doc(alias = "excluded volume")]
pub struct ExcludedRegion {
    circles: Vec<(DVec2, f64)>,
    /// Number of edges of the molecule.
    edges: usize,
    arcs: Vec<ExposedArc>,
    sides: Vec<ExposedSide>,
    hidden_arcs: Vec<ExposedArc>,
    hidden_sides: Vec<ExposedSide>,
}

impl ExcludedRegion {
    /// The region for a round probe of `radius` (length, 0 or more).
    ///
    /// # Errors
    /// [`GeometryError::OutOfRange`] if the radius is negative, NaN, infinite or beyond 1e60;
    /// [`GeometryError::Wall`] for a wall, which is not made of discs, and
    /// [`GeometryError::ExcludedByEllipses`] for several ellipses.
    pub fn new(molecule: &Molecule, radius: f64) -> Result<Self, GeometryError> {
        let name = "the radius of a probe";
        check_length(name, radius)?;
        if radius < 0.0 {
            return Err(GeometryError::OutOfRange {
                name,
                value: radius,
            });
        }
        if molecule.is_wall() {
            return Err(GeometryError::Wall);
        }
        match molecule.ellipses() {
            [] => {}
            [ellipse] => return Ok(Self::of_ellipse(ellipse, radius)),
            _ => return Err(GeometryError::ExcludedByEllipses),
        }
        Ok(Self::of_union(&molecule.union(), radius))
    }

    /// The region that a body excludes for the centre of a round probe of this radius (length, 0 or
    /// more).
    pub(crate) fn of_union(body: &Union, probe_radius: f64) -> Self {
        let union = body.inflated(probe_radius);
        let (outer, hidden) = outline::outline(&union);
        let (arcs, sides) = by_shape(outer);
        let (hidden_arcs, hidden_sides) = by_shape(hidden);
        Self {
            edges: union.bars.len(),
            circles: union.circles,
            arcs,
            sides,
            hidden_arcs,
            hidden_sides,
        }
    }

    /// The arcs that a probe from outside can touch, by atom and then by angle.
    pub fn arcs(&self) -> &[ExposedArc] {
        &self.arcs
    }

    /// The arcs around pockets: space for the probe inside the molecule that cannot be reached from
    /// outside.
    pub fn hidden_arcs(&self) -> &[ExposedArc] {
        &self.hidden_arcs
    }

    /// The straight sides of edges that a probe from outside can touch, by edge.
    pub fn sides(&self) -> &[ExposedSide] {
        &self.sides
    }

    /// The straight sides of edges around pockets.
    pub fn hidden_sides(&self) -> &[ExposedSide] {
        &self.hidden_sides
    }

    /// Whether the molecule encloses space for the probe, or parts, that cannot be reached from
    /// outside.
    pub fn has_pockets(&self) -> bool {
        !(self.hidden_arcs.is_empty() && self.hidden_sides.is_empty())
    }

    /// Length of the outer boundary. For a probe of radius 0 it is the perimeter of the molecule
    /// itself.
    pub fn perimeter(&self) -> f64 {
        self.outer().map(|curve| curve.length()).sum()
    }

    /// Area inside the outer boundary, including pockets (length²).
    pub fn area(&self) -> f64 {
        self.outer().map(|curve| curve.swept_area()).sum()
    }

    /// The part of [`area`](Self::area) that is free for a probe inside a pocket (length²).
    pub fn pocket_area(&self) -> f64 {
        // Around a pocket the boundary runs clockwise.
        curves(&self.hidden_arcs, &self.hidden_sides)
            .map(|curve| -curve.swept_area())
            .sum::<f64>()
            .max(0.0)
    }

    /// Whether the region contains this position of the probe's centre: it would overlap the
    /// molecule, or lie in a pocket.
    pub fn contains(&self, point: DVec2) -> bool {
        self.circles
            .iter()
            .any(|&(centre, radius)| centre.distance_squared(point) < radius * radius)
            || outline::encircle(self.outer(), point)
    }

    /// Mean path of one probe between two contacts with this molecule, fixed on a torus of this
    /// area (length²): π (A − A_excluded) / P (length).
    ///
    /// The region must not overlap its own images.
    pub fn mean_free_path(&self, area: f64) -> f64 {
        PI * (area - self.area()) / self.perimeter()
    }

    /// The total angle of normals that expose this atom (radians).
    pub fn exposed_angle(&self, atom: usize) -> f64 {
        self.arcs
            .iter()
            .filter(|arc| arc.atom == atom)
            .map(ExposedArc::angle)
            .sum()
    }

    /// The number of arcs with this direction of the normal (radians): N(φ), the number of atoms
    /// that can be touched there, if no atom has two arcs with one direction. Edges do not count:
    /// each side can be touched in one direction only.
    pub fn exposure(&self, normal: f64) -> usize {
        let inside = |arc: &&ExposedArc| (normal - arc.start).rem_euclid(TAU) < arc.angle();
        self.arcs.iter().filter(inside).count()
    }

    /// The atoms that a probe from outside can never touch.
    pub fn unreachable(&self) -> Vec<usize> {
        (0..self.circles.len())
            .filter(|&atom| self.exposed_angle(atom) == 0.0)
            .collect()
    }

    /// ∫ weight ds over the outer boundary; the weight may depend on the place of the contact.
    ///
    /// ```
    /// use carom_geometry::{ExcludedRegion, Molecule, Shape};
    ///
    /// // No ideal gas turns a molecule: the mean lever arm vanishes.
    /// let tee = Molecule::named(Shape::Tee, 0.0025, 2.0)?;
    /// let region = ExcludedRegion::new(&tee, 0.01)?;
    /// assert!(region.integral(|contact| contact.lever()).abs() < 1e-15);
    /// # Ok::<(), carom_geometry::GeometryError>(())
    /// ```
    pub fn integral(&self, weight: impl Fn(&BoundaryPoint) -> f64) -> f64 {
        let over_arcs: f64 = self.arcs.iter().map(|arc| over_arc(arc, &weight)).sum();
        let over_sides: f64 = self.sides.iter().map(|side| side.integral(&weight)).sum();
        over_arcs + over_sides
    }

    /// ∫ weight ds over the arcs of each atom.
    pub fn by_atom(&self, weight: impl Fn(&BoundaryPoint) -> f64) -> Vec<f64> {
        let mut sums = vec![0.0; self.circles.len()];
        for arc in &self.arcs {
            sums[arc.atom] += over_arc(arc, &weight);
        }
        sums
    }

    /// ∫ weight ds over both sides of each edge.
    pub fn by_edge(&self, weight: impl Fn(&BoundaryPoint) -> f64) -> Vec<f64> {
        let mut sums = vec![0.0; self.edges];
        for side in &self.sides {
            sums[side.edge] += side.integral(&weight);
        }
        sums
    }

    /// ∫ weight ds over equal sectors of the direction of the impulse on the molecule, which is
    /// opposite to the normal; counter-clockwise from direction 0.
    ///
    /// All impulses on a side of an edge have one direction. If that is the limit of two sectors,
    /// to rounding, they count in the one that begins there.
    pub fn by_impulse_direction(
        &self,
        sectors: usize,
        weight: impl Fn(&BoundaryPoint) -> f64,
    ) -> Vec<f64> {
        let mut sums = vec![0.0; sectors];
        for arc in &self.arcs {
            for (sector, from, to) in arc.sectors(sectors, -PI) {
                if let Some(sum) = sums.get_mut(sector) {
                    *sum += arc.integral(from, to, &weight);
                }
            }
        }
        for side in &self.sides {
            if let Some(sum) = sums.get_mut(sector_of(side.normal + PI, sectors)) {
                *sum += side.integral(&weight);
            }
        }
        sums
    }

    /// The share of each atom in the contacts if every piece of the boundary is hit with equal
    /// probability: for a molecule in an ideal gas that is fixed, or locked in its orientation.
    /// Together with the [shares of the edges](Self::edge_shares) they add up to 1.
    pub fn atom_shares(&self) -> Vec<f64> {
        let [atoms, _] = self.shares_of_parts();
        atoms
    }

    /// The share of each edge in the contacts if every piece of the boundary is hit with equal
    /// probability.
    pub fn edge_shares(&self) -> Vec<f64> {
        let [_, edges] = self.shares_of_parts();
        edges
    }

    /// The share of equal sectors of the direction of the impulse in the contacts, if every piece
    /// of the boundary is hit with equal probability. With equal atoms and no edges the shares are
    /// integer multiples of one value, except in sectors in which an arc begins or ends.
    pub fn direction_shares(&self, sectors: usize) -> Vec<f64> {
        let parts = self.by_impulse_direction(sectors, |_| 1.0);
        relative_to(parts.iter().sum(), parts)
    }

    fn shares_of_parts(&self) -> [Vec<f64>; 2] {
        let parts = [self.by_atom(|_| 1.0), self.by_edge(|_| 1.0)];
        let whole = parts.iter().map(|parts| parts.iter().sum::<f64>()).sum();
        parts.map(|parts| relative_to(whole, parts))
    }

    /// The outer boundary.
    fn outer(&self) -> impl Iterator<Item = Curve> {
        curves(&self.arcs, &self.sides)
    }
}

/// ∫ weight ds over a whole arc.
fn over_arc(arc: &ExposedArc, weight: &impl Fn(&BoundaryPoint) -> f64) -> f64 {
    arc.integral(arc.start, arc.end, weight)
}

/// A direction so near below the limit of two sectors (turns) counts to the one that begins there:
/// all contacts of a flat side have one direction, which is such a limit to rounding for many
/// shapes.
pub const DIRECTION_ROUNDING: f64 = 1e-9;

/// The sector of `count` equal ones of the whole turn that contains a direction (radians).
fn sector_of(direction: f64, count: usize) -> usize {
    let turns = direction.rem_euclid(TAU) / TAU + DIRECTION_ROUNDING;
    (turns * count as f64) as usize % count.max(1)
}

/// Arcs and then sides.
fn curves(arcs: &[ExposedArc], sides: &[ExposedSide]) -> impl Iterator<Item = Curve> {
    let arcs = arcs.iter().copied().map(Curve::Arc);
    arcs.chain(sides.iter().copied().map(Curve::Side))
}

/// Separates arcs from sides.
fn by_shape(curves: Vec<Curve>) -> (Vec<ExposedArc>, Vec<ExposedSide>) {
    let (mut arcs, mut sides) = (Vec::new(), Vec::new());
    for curve in curves {
        match curve {
            Curve::Arc(arc) => arcs.push(arc),
            Curve::Side(side) => sides.push(side),
        }
    }
    (arcs, sides)
}

/// Parts relative to their whole.
fn relative_to(whole: f64, parts: Vec<f64>) -> Vec<f64> {
    parts.into_iter().map(|part| part / whole).collect()
}
