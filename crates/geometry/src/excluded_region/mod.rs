//! The region that a molecule denies to the centre of a round probe: its boundary, perimeter and area, arc by arc.
//!
//! The centre of a probe of radius r cannot come nearer than sᵢ = ρᵢ + r to the centre of atom i. The region is the union
//! of these discs together with what they enclose, for a probe that comes from outside never gets there. Its boundary
//! consists of arcs of circles; on each the contact normal's direction is the arc's own angle.
//!
//! At equilibrium an ideal gas strikes each piece ds of the boundary alike, and the mean free path of one probe on a torus
//! of area A around a fixed molecule is π (A − A_excluded) / P (Santaló 1976, "Integral geometry and geometric
//! probability"). So the free path, the directions of impulses and the share of each atom follow from the arcs alone.

mod outline;
#[cfg(test)]
mod tests;

use std::f64::consts::{PI, TAU};

use glam::DVec2;

use crate::{GeometryError, Molecule, check_length, exposed_arc::ExposedArc};

/// What a molecule denies to the centre of a round probe, in the molecule's own frame.
///
/// ```
/// use carom_geometry::{ExcludedRegion, Molecule, Shape};
///
/// // The tee of Montanari (2017) with atoms a quarter of the gas discs' size: the middle of its stem is out of reach.
/// let tee = Molecule::named(Shape::Tee, 0.0025, 2.0)?;
/// let region = ExcludedRegion::of(&tee, 0.01)?;
/// assert_eq!(region.unreachable(), [3]);
/// // From straight above, the three atoms of the bar can be touched; from the right below, wing and foot.
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
    /// [`GeometryError::Wall`] of a wall, which is not made of discs.
    pub fn of(molecule: &Molecule, radius: f64) -> Result<Self, GeometryError> {
        let name = "the radius of a probe";
        check_length(name, radius)?;
        if radius < 0.0 {
            return Err(GeometryError::OutOfRange { name, value: radius });
        }
        if molecule.face().is_some() {
            return Err(GeometryError::Wall);
        }
        let atoms = molecule.atoms().iter();
        let circles: Vec<(DVec2, f64)> = atoms.map(|atom| (atom.offset(), atom.radius() + radius)).collect();
        let (arcs, hidden) = outline::outline(&circles);
        Ok(Self { circles, arcs, hidden })
    }

    /// The arcs that a probe from outside can touch, by atom and then by angle.
    pub fn arcs(&self) -> &[ExposedArc] {
        &self.arcs
    }

    /// The arcs around pockets: room for the probe inside the molecule, where none gets from outside.
    pub fn hidden_arcs(&self) -> &[ExposedArc] {
        &self.hidden
    }

    /// Length of the outer boundary.
    pub fn perimeter(&self) -> f64 {
        self.arcs.iter().map(ExposedArc::length).sum()
    }

    /// Area inside the outer boundary, pockets included (length²).
    pub fn area(&self) -> f64 {
        self.arcs.iter().map(ExposedArc::swept_area).sum()
    }

    /// Of [`area`](Self::area), what a probe would have for itself if it were put inside (length²).
    pub fn pocket_area(&self) -> f64 {
        // Around a pocket the arcs run clockwise.
        self.hidden.iter().map(|arc| -arc.swept_area()).sum::<f64>().max(0.0)
    }

    /// Whether the region holds this place of the probe's centre: it would overlap an atom, or is in a pocket.
    pub fn contains(&self, point: DVec2) -> bool {
        self.circles.iter().any(|&(centre, radius)| centre.distance_squared(point) < radius * radius)
            || outline::encircle(&self.arcs, point)
    }

    /// Mean path of one probe between two contacts with this molecule, fixed on a torus of this area (length²):
    /// π (A − A_excluded) / P (length).
    ///
    /// The region must not reach its own images.
    pub fn mean_free_path(&self, area: f64) -> f64 {
        PI * (area - self.area()) / self.perimeter()
    }

    /// Of all directions of the normal, how many expose this atom (radians).
    pub fn exposed_angle(&self, atom: usize) -> f64 {
        self.arcs.iter().filter(|arc| arc.atom == atom).map(ExposedArc::angle).sum()
    }

    /// How many arcs have this direction of the normal (radians): N(φ), the number of atoms that can be touched so,
    /// where no atom has two arcs with one direction.
    pub fn exposure(&self, normal: f64) -> usize {
        let inside = |arc: &&ExposedArc| (normal - arc.start).rem_euclid(TAU) < arc.angle();
        self.arcs.iter().filter(inside).count()
    }

    /// Atoms that a probe from outside can never touch.
    pub fn unreachable(&self) -> Vec<usize> {
        (0..self.circles.len()).filter(|&atom| self.exposed_angle(atom) == 0.0).collect()
    }

    /// ∫ weight ds over the outer boundary, where the weight may depend on the arc and on the direction of the normal
    /// (radians).
    pub fn integral(&self, weight: impl Fn(&ExposedArc, f64) -> f64) -> f64 {
        self.arcs.iter().map(|arc| arc.integral(arc.start, arc.end, &weight)).sum()
    }

    /// ∫ weight ds over the arcs of each atom.
    pub fn by_atom(&self, weight: impl Fn(&ExposedArc, f64) -> f64) -> Vec<f64> {
        let mut sums = vec![0.0; self.circles.len()];
        for arc in &self.arcs {
            sums[arc.atom] += arc.integral(arc.start, arc.end, &weight);
        }
        sums
    }

    /// ∫ weight ds over each of equal sectors of the direction of the impulse on the molecule, which is opposite to the
    /// normal; from direction 0 counter-clockwise.
    pub fn by_impulse_direction(&self, sectors: usize, weight: impl Fn(&ExposedArc, f64) -> f64) -> Vec<f64> {
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

    /// Share of the hits of each atom, if every piece of the boundary is hit alike: of a fixed molecule, or one locked in
    /// its orientation, in an ideal gas.
    pub fn atom_shares(&self) -> Vec<f64> {
        shares(self.by_atom(|_, _| 1.0))
    }

    /// Share of the hits by the direction of the impulse, in equal sectors, if every piece of the boundary is hit alike.
    /// With equal atoms these are whole multiples of one level, but for sectors in which an arc begins or ends.
    pub fn direction_shares(&self, sectors: usize) -> Vec<f64> {
        shares(self.by_impulse_direction(sectors, |_, _| 1.0))
    }
}

/// Parts relative to their sum.
fn shares(parts: Vec<f64>) -> Vec<f64> {
    let whole: f64 = parts.iter().sum();
    parts.into_iter().map(|part| part / whole).collect()
}
