//! The corners of molecules that are polygons.

use glam::DVec2;

use crate::{Molecule, hull::are_of_one_radius};

impl Molecule {
    /// The corners from the centre of mass (length), counter-clockwise, if this is a solid polygon
    /// with round corners of one radius; `None` for all other molecules.
    ///
    /// ```
    /// use carom_geometry::{EdgedShape, Molecule};
    ///
    /// let square = EdgedShape::Square.molecule(2.0, 1e-6, 1.0)?;
    /// let corners = square.corners().expect("it is a polygon");
    /// assert!((corners[2] - glam::DVec2::ONE).length() < 1e-15);
    /// assert_eq!(Molecule::capsule(1.0, 0.5, 1.0)?.corners(), None);
    /// # Ok::<(), carom_geometry::GeometryError>(())
    /// ```
    pub fn corners(&self) -> Option<Vec<DVec2>> {
        let (atoms, edges) = (self.atoms(), self.edges());
        if !are_of_one_radius(atoms, edges) || edges.len() != atoms.len() {
            return None;
        }
        let rings = self.solid_rings();
        let ring = rings.first().filter(|ring| ring.len() == atoms.len())?;
        Some(
            ring.iter()
                .map(|&atom| atoms[atom as usize].offset())
                .collect(),
        )
    }

    /// Half the width of a disc or of a regular polygon, in other shapes a measure of their
    /// thickness: twice the area over the perimeter (length).
    pub fn mean_half_width(&self) -> f64 {
        2.0 * self.area() / self.perimeter()
    }
}

#[cfg(test)]
mod tests {
    use crate::{Interior, Molecule};
    use glam::DVec2;

    #[test]
    fn only_solid_polygons_have_corners() {
        let clockwise = [(0.0, 0.0), (0.0, 1.0), (2.0, 1.0), (2.0, 0.0)].map(DVec2::from);
        let solid = Molecule::polygon(&clockwise, 0.1, 1.0).unwrap();
        let corners = solid.corners().unwrap();
        assert!((corners[1] - corners[0]).perp_dot(corners[2] - corners[1]) > 0.0);
        assert_eq!(corners.len(), 4);
        let edges = |radius| [0, 1, 2, 3].map(|k| ([k, (k + 1) % 4], radius));
        let other = |radius, interior| {
            let atoms = solid.atoms().iter().copied();
            Molecule::with_edges(atoms, &edges(radius), interior).unwrap()
        };
        assert_eq!(other(0.1, Interior::Hollow).corners(), None);
        assert_eq!(other(0.05, Interior::Solid).corners(), None);
        assert_eq!(Molecule::disc(1.0, 1.0).unwrap().corners(), None);
    }

    #[test]
    fn the_half_width_is_the_radius_of_a_disc_and_the_inner_one_of_a_square() {
        let disc = Molecule::disc(0.3, 1.0).unwrap();
        assert!((disc.mean_half_width() - 0.3).abs() < 1e-15);
        let square = crate::EdgedShape::Square.molecule(2.0, 1e-6, 1.0).unwrap();
        assert!((square.mean_half_width() - 1.0).abs() < 1e-5);
    }
}
