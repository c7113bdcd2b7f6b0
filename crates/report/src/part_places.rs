//! Places for the names of atoms and edges in a picture of a body.

use carom_geometry::{Edge, Molecule};
use glam::DVec2;

/// Angle between two points of a round part of the boundary (radians); only which side of the
/// boundary a name is on depends on it.
const STEP: f64 = 0.2;

/// Finds places near thin parts of a body.
pub(crate) struct PartPlaces<'a> {
    molecule: &'a Molecule,
    /// Closed polygons along the boundary.
    boundary: Vec<Vec<DVec2>>,
    /// Distance of a name from a thin part (length).
    away: f64,
}

impl<'a> PartPlaces<'a> {
    pub(crate) fn new(molecule: &'a Molecule, away: f64) -> Self {
        let contours = molecule.visible_contours();
        Self {
            molecule,
            boundary: contours
                .iter()
                .map(|contour| contour.points(STEP))
                .collect(),
            away,
        }
    }

    /// Beside an atom, inside the body if there is room.
    pub(crate) fn beside_atom(&self, atom: usize) -> DVec2 {
        let atoms = self.molecule.atoms();
        let at = atoms[atom].offset();
        let ends = self.molecule.edges().iter().filter_map(Edge::ends);
        // From the atom along each of its edges.
        let along = ends.filter_map(|[first, second]| {
            let [first, second] = [first, second].map(|end| end as usize);
            let other = match atom {
                _ if atom == first => second,
                _ if atom == second => first,
                _ => return None,
            };
            (atoms[other].offset() - at).try_normalize()
        });
        let between = along.sum::<DVec2>().normalize_or_zero();
        self.inside(at, between)
    }

    /// Beside an edge, inside the body if there is room.
    pub(crate) fn beside_edge(&self, edge: usize) -> DVec2 {
        let edge = &self.molecule.edges()[edge];
        self.inside(on_edge(edge), edge.normal())
    }

    /// The place in this direction or the opposite one that is in the body; else towards the centre
    /// of mass.
    fn inside(&self, at: DVec2, direction: DVec2) -> DVec2 {
        let towards = |direction: DVec2| at + self.away * direction;
        let both = [direction, -direction].map(towards);
        both.into_iter()
            .find(|&place| self.holds(place))
            .unwrap_or_else(|| towards(-at.normalize_or_zero()))
    }

    /// Whether a point is in the body (even-odd rule).
    fn holds(&self, point: DVec2) -> bool {
        let crosses = |from: DVec2, to: DVec2| {
            (from.y > point.y) != (to.y > point.y) && {
                let share = (point.y - from.y) / (to.y - from.y);
                from.x + share * (to.x - from.x) > point.x
            }
        };
        let crossings = self.boundary.iter().map(|line| {
            let next = line.iter().cycle().skip(1);
            line.iter()
                .zip(next)
                .filter(|(from, to)| crosses(**from, **to))
                .count()
        });
        crossings.sum::<usize>() % 2 == 1
    }
}

/// A place on the line of an edge for its name: off the middle, through which an axis may pass.
pub(crate) fn on_edge(edge: &Edge) -> DVec2 {
    edge.middle() + 0.25 * edge.half_length() * edge.along()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_inside_a_notched_body() {
        let corners = [
            (0.0, 0.0),
            (3.0, 0.0),
            (3.0, 1.0),
            (1.0, 1.0),
            (1.0, 3.0),
            (0.0, 3.0),
        ];
        let ell = Molecule::polygon(&corners.map(DVec2::from), 1e-6, 1.0).unwrap();
        let places = PartPlaces::new(&ell, 0.2);
        // Relative to the first corner.
        let origin = ell.atoms()[0].offset();
        let of_atoms: Vec<DVec2> = (0..6)
            .map(|atom| places.beside_atom(atom) - origin)
            .collect();
        let of_edges: Vec<DVec2> = (0..6)
            .map(|edge| places.beside_edge(edge) - origin)
            .collect();
        for place in of_atoms.iter().chain(&of_edges) {
            assert!(places.holds(*place + origin), "{place}");
        }
        assert!(of_atoms[3].x < 1.0 && of_atoms[3].y < 1.0);
        assert!((of_edges[2] - DVec2::new(1.75, 0.8)).length() < 1e-12);
    }
}
