//! A predicted contact of two bodies, and the parts that touch.

use std::cmp::Ordering;

use carom_detection::{Part, TetherBound, Touch};
use carom_geometry::Molecule;

/// The next contact of two bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactEvent {
    /// Offset from the start of the epoch (time).
    pub time: f64,
    /// The two bodies, in the order of [`World::bodies`](crate::World::bodies). Where a piston
    /// reaches a stop, both are the piston ([`Self::stop`]).
    pub bodies: [u32; 2],
    /// The image of the second body that is touched, in boxes relative to the positions of the two
    /// motions.
    pub image: [i64; 2],
    /// The parts that touch.
    pub parts: TouchingParts,
}

impl ContactEvent {
    /// The event that a piston reaches one of its stops at `time` (offset in the epoch).
    pub fn stop(piston: u32, time: f64) -> Self {
        Self {
            time,
            bodies: [piston; 2],
            image: [0; 2],
            parts: TouchingParts::BoundingCircles,
        }
    }

    /// Whether a piston reaches one of its stops.
    #[inline]
    pub fn is_stop(&self) -> bool {
        self.bodies[0] == self.bodies[1]
    }

    /// Orders contacts by time, then by the first body, then by the second body.
    pub fn in_order(&self, other: &Self) -> Ordering {
        self.time
            .total_cmp(&other.time)
            .then(self.bodies.cmp(&other.bodies))
    }
}

/// The parts of two bodies that touch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TouchingParts {
    /// Both bodies are single discs: the arms are zero, and no body turns.
    Discs,
    /// An atom of each, by index.
    Atoms(u32, u32),
    /// Their bounding circles, in a model without atoms.
    BoundingCircles,
    /// An edge of the first body, by index, and a part of the second.
    EdgeOfA {
        /// Index of the edge.
        edge: u32,
        /// The part of the second body.
        part: Part,
    },
    /// A part of the first body, and an edge of the second, by index.
    EdgeOfB {
        /// Index of the edge.
        edge: u32,
        /// The part of the first body.
        part: Part,
    },
    /// No parts: a bond, by its index in [`World::bonds`](crate::World::bonds), reaches a bound.
    Bond(u32, TetherBound),
    /// No parts: two discs reach the range of a step of their well, inwards at the shortest length
    /// of their shell and outwards at the longest.
    Step(TetherBound),
}

impl TouchingParts {
    /// The distance of the centres of the two parts at contact (length); for an edge, from its
    /// line; for an ellipse, from the point of contact.
    pub(crate) fn contact_distance(self, [a, b]: [&Molecule; 2]) -> f64 {
        let radius = |molecule: &Molecule, atom: u32| radius_beyond_arm(molecule, atom);
        let of_edge = |body: &Molecule, edge: u32, other: &Molecule, part| {
            let radius = match part {
                Part::Atom(index) => radius(other, index),
                Part::BoundingCircle => other.bounding_radius(),
            };
            body.edges()[edge as usize].radius() + radius
        };
        match self {
            Self::Discs => radius(a, 0) + radius(b, 0),
            Self::Atoms(i, j) => radius(a, i) + radius(b, j),
            Self::BoundingCircles => a.bounding_radius() + b.bounding_radius(),
            Self::EdgeOfA { edge, part } => of_edge(a, edge, b, part),
            Self::EdgeOfB { edge, part } => of_edge(b, edge, a, part),
            Self::Bond(..) | Self::Step(_) => 0.0,
        }
    }

    /// The distances of the surfaces from the centres of the two touching parts, or from the line
    /// of an edge (length).
    pub(crate) fn reaches(self, [a, b]: [&Molecule; 2]) -> [f64; 2] {
        let (_, first) = self.atoms_and_first_radius(a);
        [first, self.contact_distance([a, b]) - first]
    }

    /// Indices of the touching edges.
    pub(crate) fn edges(self) -> [Option<u32>; 2] {
        match self {
            Self::EdgeOfA { edge, .. } => [Some(edge), None],
            Self::EdgeOfB { edge, .. } => [None, Some(edge)],
            Self::Discs
            | Self::Atoms(..)
            | Self::BoundingCircles
            | Self::Bond(..)
            | Self::Step(_) => [None; 2],
        }
    }

    /// Indices of the touching atoms, and the radius of the touching part of the first body
    /// (length).
    pub(crate) fn atoms_and_first_radius(self, first: &Molecule) -> ([Option<u32>; 2], f64) {
        match self {
            Self::Discs => ([Some(0); 2], first.bounding_radius()),
            Self::Atoms(i, j) => ([Some(i), Some(j)], radius_beyond_arm(first, i)),
            Self::Bond(..) | Self::Step(_) => ([None; 2], 0.0),
            Self::BoundingCircles
            | Self::EdgeOfB {
                part: Part::BoundingCircle,
                ..
            } => ([None; 2], first.bounding_radius()),
            Self::EdgeOfB {
                part: Part::Atom(i),
                ..
            } => ([Some(i), None], radius_beyond_arm(first, i)),
            Self::EdgeOfA { edge, part } => {
                let atom = if let Part::Atom(j) = part {
                    Some(j)
                } else {
                    None
                };
                ([None, atom], first.edges()[edge as usize].radius())
            }
        }
    }
}

/// The distance of the surface of an atom from the end of its arm (length): 0 for an ellipse, whose
/// arm ends at the point of contact.
fn radius_beyond_arm(molecule: &Molecule, atom: u32) -> f64 {
    if molecule.ellipses().is_empty() {
        molecule.atoms()[atom as usize].radius()
    } else {
        0.0
    }
}

impl From<Touch> for TouchingParts {
    fn from(touch: Touch) -> Self {
        match touch {
            Touch::Atoms(i, j) => Self::Atoms(i, j),
            Touch::BoundingCircles => Self::BoundingCircles,
            Touch::EdgeOfA { edge, part } => Self::EdgeOfA { edge, part },
            Touch::EdgeOfB { edge, part } => Self::EdgeOfB { edge, part },
        }
    }
}

impl TouchingParts {
    /// The touching parts as detection names them; `None` for a bond and for a step of a well.
    pub(crate) fn touch(self) -> Option<Touch> {
        Some(match self {
            Self::Discs => Touch::Atoms(0, 0),
            Self::Atoms(i, j) => Touch::Atoms(i, j),
            Self::BoundingCircles => Touch::BoundingCircles,
            Self::EdgeOfA { edge, part } => Touch::EdgeOfA { edge, part },
            Self::EdgeOfB { edge, part } => Touch::EdgeOfB { edge, part },
            Self::Bond(..) | Self::Step(_) => return None,
        })
    }
}
