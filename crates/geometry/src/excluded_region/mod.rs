//! The region that a molecule excludes for the centre of a round probe: its boundary, perimeter and
//! area.
//!
//! The centre of a probe of radius r cannot be nearer than sᵢ = ρᵢ + r to the centre of atom i. The
//! region is the union of these discs and of the pockets that they enclose, which a probe from
//! outside cannot reach. Its boundary consists of arcs of circles; on each, the direction of the
//! contact normal is the angle on the arc.
//!
//! At equilibrium an ideal gas hits each piece ds of the boundary with equal probability, and the
//! mean free path of one probe on a torus of area A around a fixed molecule is π (A − A_excluded) /
//! P (Santaló 1976, "Integral geometry and geometric probability"). The free path, the directions
//! of impulses and the share of each atom thus follow from the arcs alone.

mod outline;
#[cfg(test)]
mod tests;

use std::f64::consts::{PI, TAU};

use glam::DVec2;

use crate::{GeometryError, Molecule, check_length, exposed_arc::ExposedArc};

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
    arcs: Vec<ExposedArc>,
    hidden: Vec<ExposedArc>,
}

impl ExcludedRegion {
    /// The region for a round probe of `radius` (length, 0 or more).
    ///
    /// # Errors
    /// [`GeometryError::OutOfRange`] if the radius is negative, NaN, infinite or beyond 1e60;
    /// [`GeometryError::Wall`] for a wall, which is not made of discs.
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
        let atoms = molecule.atoms().iter();
        let circles: Vec<(DVec2, f64)> = atoms
            .map(|atom| (atom.offset(), atom.radius() + radius))
            .collect();
        let (arcs, hidden) = outline::outline(&circles);
        Ok(Self {
            circles,
            arcs,
            hidden,
        })
    }

    /// The arcs that a probe from outside can touch, by atom and then by angle.
    pub fn arcs(&self) -> &[ExposedArc] {
        &self.arcs
    }

    /// The arcs around pockets: space for the probe inside the molecule that cannot be reached from
    /// outside.
    pub fn hidden_arcs(&self) -> &[ExposedArc] {
        &self.hidden
    }

    /// Length of the outer boundary.
    pub fn perimeter(&self) -> f64 {
        self.arcs.iter().map(ExposedArc::length).sum()
    }

    /// Area inside the outer boundary, including pockets (length²).
    pub fn area(&self) -> f64 {
        self.arcs.iter().map(ExposedArc::swept_area).sum()
    }

    /// The part of [`area`](Self::area) that is free for a probe inside a pocket (length²).
    pub fn pocket_area(&self) -> f64 {
        // Around a pocket the arcs run clockwise.
        self.hidden
            .iter()
            .map(|arc| -arc.swept_area())
            .sum::<f64>()
            .max(0.0)
    }

    /// Whether the region contains this position of the probe's centre: it would overlap an atom,
    /// or lie in a pocket.
    pub fn contains(&self, point: DVec2) -> bool {
        self.circles
            .iter()
            .any(|&(centre, radius)| centre.distance_squared(point) < radius * radius)
            || outline::encircle(&self.arcs, point)
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
    /// that can be touched there, if no atom has two arcs with one direction.
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

    /// ∫ weight ds over the outer boundary; the weight may depend on the arc and on the direction
    /// of the normal (radians).
    pub fn integral(&self, weight: impl Fn(&ExposedArc, f64) -> f64) -> f64 {
        self.arcs
            .iter()
            .map(|arc| arc.integral(arc.start, arc.end, &weight))
            .sum()
    }

    /// ∫ weight ds over the arcs of each atom.
    pub fn by_atom(&self, weight: impl Fn(&ExposedArc, f64) -> f64) -> Vec<f64> {
        let mut sums = vec![0.0; self.circles.len()];
        for arc in &self.arcs {
            sums[arc.atom] += arc.integral(arc.start, arc.end, &weight);
        }
        sums
    }

    /// ∫ weight ds over equal sectors of the direction of the impulse on the molecule, which is
    /// opposite to the normal; counter-clockwise from direction 0.
    pub fn by_impulse_direction(
        &self,
        sectors: usize,
        weight: impl Fn(&ExposedArc, f64) -> f64,
    ) -> Vec<f64> {
        let mut sums = vec![0.0; sectors];
        for arc in &self.arcs {
            for (sector, from, to) in arc.sectors(sectors, -PI) {
                if let Some(sum) = sums.get_mut(sector) {
                    *sum += arc.integral(from, to, &weight);
                }
            }
        }
        sums
    }

    /// The share of each atom in the contacts if every piece of the boundary is hit with equal
    /// probability: for a molecule in an ideal gas that is fixed, or locked in its orientation.
    pub fn atom_shares(&self) -> Vec<f64> {
        shares(self.by_atom(|_, _| 1.0))
    }

    /// The share of equal sectors of the direction of the impulse in the contacts, if every piece
    /// of the boundary is hit with equal probability. With equal atoms the shares are integer
    /// multiples of one value, except in sectors in which an arc begins or ends.
    pub fn direction_shares(&self, sectors: usize) -> Vec<f64> {
        shares(self.by_impulse_direction(sectors, |_, _| 1.0))
    }
}

/// Parts relative to their sum.
fn shares(parts: Vec<f64>) -> Vec<f64> {
    let whole: f64 = parts.iter().sum();
    parts.into_iter().map(|part| part / whole).collect()
}
