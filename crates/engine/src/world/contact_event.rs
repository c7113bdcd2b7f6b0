//! A predicted contact of two bodies, and the parts that touch.

use std::cmp::Ordering;

use carom_detection::{Part, Touch};
use carom_geometry::Molecule;

/// The next contact of two bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactEvent {
    /// Offset from the start of the epoch (time).
    pub time: f64,
    /// The two bodies, in the order of [`World::bodies`](crate::World::bodies).
    pub bodies: [u32; 2],
    /// The image of the second body that is touched, in boxes relative to the positions of the two
    /// motions.
    pub image: [i64; 2],
    /// The parts that touch.
    pub parts: TouchingParts,
}

impl ContactEvent {
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
    /// The face of the first body, which is a wall, and a part of the second.
    FaceOfA(Part),
    /// A part of the first body, and the face of the second, which is a wall.
    FaceOfB(Part),
}

impl TouchingParts {
    /// The distance of the centres of the two parts at contact (length); for a face, the distance
    /// from its plane.
    pub(crate) fn contact_distance(self, [a, b]: [&Molecule; 2]) -> f64 {
        let radius = |molecule: &Molecule, atom: u32| molecule.atoms()[atom as usize].radius();
        let of_face = |wall: &Molecule, other: &Molecule, part| {
            let face = wall.face().map_or(0.0, carom_geometry::Face::radius);
            let radius = match part {
                Part::Atom(index) => radius(other, index),
                Part::BoundingCircle => other.bounding_radius(),
            };
            face + radius
        };
        match self {
            Self::Discs => radius(a, 0) + radius(b, 0),
            Self::Atoms(i, j) => radius(a, i) + radius(b, j),
            Self::BoundingCircles => a.bounding_radius() + b.bounding_radius(),
            Self::FaceOfA(part) => of_face(a, b, part),
            Self::FaceOfB(part) => of_face(b, a, part),
        }
    }

    /// Indices of the touching atoms, and the radius of the touching part of the first body
    /// (length).
    pub(crate) fn atoms_and_first_radius(self, first: &Molecule) -> ([Option<u32>; 2], f64) {
        match self {
            Self::Discs => ([Some(0); 2], first.bounding_radius()),
            Self::Atoms(i, j) => ([Some(i), Some(j)], first.atoms()[i as usize].radius()),
            Self::BoundingCircles | Self::FaceOfB(Part::BoundingCircle) => {
                ([None; 2], first.bounding_radius())
            }
            Self::FaceOfB(Part::Atom(i)) => ([Some(i), None], first.atoms()[i as usize].radius()),
            Self::FaceOfA(part) => {
                let atom = if let Part::Atom(j) = part {
                    Some(j)
                } else {
                    None
                };
                (
                    [None, atom],
                    first.face().map_or(0.0, carom_geometry::Face::radius),
                )
            }
        }
    }
}

impl From<Touch> for TouchingParts {
    fn from(touch: Touch) -> Self {
        match touch {
            Touch::Atoms(i, j) => Self::Atoms(i, j),
            Touch::BoundingCircles => Self::BoundingCircles,
            Touch::FaceOfA(part) => Self::FaceOfA(part),
            Touch::FaceOfB(part) => Self::FaceOfB(part),
        }
    }
}

impl From<TouchingParts> for Touch {
    fn from(parts: TouchingParts) -> Self {
        match parts {
            TouchingParts::Discs => Self::Atoms(0, 0),
            TouchingParts::Atoms(i, j) => Self::Atoms(i, j),
            TouchingParts::BoundingCircles => Self::BoundingCircles,
            TouchingParts::FaceOfA(part) => Self::FaceOfA(part),
            TouchingParts::FaceOfB(part) => Self::FaceOfB(part),
        }
    }
}
