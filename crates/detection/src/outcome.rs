//! How a search for a contact can end, each way by its name.

/// What a search found, and what it cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer {
    /// How the search ended.
    pub outcome: Outcome,
    /// How many times the gap of an atom pair was computed.
    pub evaluations: u32,
}

/// How a search for the first contact ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outcome {
    /// They touch.
    Contact(Contact),
    /// They do not touch up to the horizon.
    Free,
    /// The search used up its budget: they certainly do not touch before this time (from now on);
    /// ask again then.
    FreeUntil(f64),
    /// The search used up its rounds without certainty: nothing is known after this time. Detectors that certify
    /// nothing end like this, and every detector where a face turns.
    Unresolved(f64),
    /// A number of the query is NaN, infinite, or of a magnitude whose products overflow or underflow: nothing is known.
    /// In range are lengths and speeds up to 1e70, and speeds of 0 or from 1e-150 on.
    OutOfRange,
}

/// A first contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// When, from now on (time, not negative).
    pub time: f64,
    /// Which parts touch.
    pub touch: Touch,
}

/// Which parts of two bodies touch. Of two that touch at one instant the lesser is named: a face before its ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Touch {
    /// The face of A, and a part of B.
    FaceOfA(Part),
    /// A part of A, and the face of B.
    FaceOfB(Part),
    /// An atom of A and an atom of B, by index.
    Atoms(u32, u32),
    /// The bounding circles, in the model that knows nothing finer.
    BoundingCircles,
}

/// What of a body touches a face.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// An atom, by index, and the face between its ends.
    Atom(u32),
    /// The bounding circle, in the model that knows nothing finer, and the face or an end of it.
    BoundingCircle,
}

impl Touch {
    /// The same contact with the bodies exchanged.
    #[must_use]
    pub fn exchanged(self) -> Self {
        match self {
            Self::Atoms(a, b) => Self::Atoms(b, a),
            Self::BoundingCircles => self,
            Self::FaceOfA(part) => Self::FaceOfB(part),
            Self::FaceOfB(part) => Self::FaceOfA(part),
        }
    }

    /// A part of body number `body` (0 for A, 1 for B) and the face of the other one.
    pub(crate) fn face(body: usize, part: Part) -> Self {
        if body == 0 { Self::FaceOfB(part) } else { Self::FaceOfA(part) }
    }
}

impl Outcome {
    /// The contact, if there is one.
    pub fn contact(self) -> Option<Contact> {
        match self {
            Self::Contact(contact) => Some(contact),
            _ => None,
        }
    }
}
