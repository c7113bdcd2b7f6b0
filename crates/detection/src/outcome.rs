//! The possible results of a search for a contact.

/// The result of a search and its cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer<T = Touch> {
    /// How the search ended.
    pub outcome: Outcome<T>,
    /// The number of evaluations of the gap of an atom pair.
    pub evaluations: u32,
}

/// How a search for the first contact ended. `T` tells what touches: the parts of two bodies, or
/// the bound that a tether reaches ([`TetherBound`](crate::TetherBound)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outcome<T = Touch> {
    /// The bodies touch.
    Contact(Contact<T>),
    /// The bodies do not touch up to the horizon.
    Free,
    /// The search reached its step limit. The bodies certainly do not touch before this time (from
    /// now); search again at that time.
    FreeUntil(f64),
    /// The search reached its limit of rounds without certainty: nothing is certified after this
    /// time. This occurs with detectors that certify nothing, and with every detector if a
    /// half-plane turns.
    Unresolved(f64),
    /// A number of the query is NaN, infinite, or of a magnitude whose products overflow or
    /// underflow; nothing is certified. In range are lengths and speeds up to 1e70, and speeds of 0
    /// or of at least 1e-150.
    OutOfRange,
}

/// A first contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact<T = Touch> {
    /// Time of the contact from now (not negative).
    pub time: f64,
    /// What touches.
    pub touch: T,
}

/// The parts of two bodies that touch. Of two contacts at the same time the lesser in this order is
/// returned: an edge before its ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Touch {
    /// An edge of A, by index, and a part of B.
    EdgeOfA {
        /// Index of the edge.
        edge: u32,
        /// The part of B.
        part: Part,
    },
    /// A part of A, and an edge of B, by index.
    EdgeOfB {
        /// Index of the edge.
        edge: u32,
        /// The part of A.
        part: Part,
    },
    /// An atom of A and an atom of B, by index.
    Atoms(u32, u32),
    /// The bounding circles, in the model that has no finer parts.
    BoundingCircles,
}

/// The part of a body that touches an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// An atom, by index; it touches the edge between its ends.
    Atom(u32),
    /// The bounding circle, in the model that has no finer parts; it touches the edge of a wall or
    /// an end of it.
    BoundingCircle,
}

impl Touch {
    /// This contact with the bodies exchanged.
    #[must_use]
    pub fn exchanged(self) -> Self {
        match self {
            Self::Atoms(a, b) => Self::Atoms(b, a),
            Self::BoundingCircles => self,
            Self::EdgeOfA { edge, part } => Self::EdgeOfB { edge, part },
            Self::EdgeOfB { edge, part } => Self::EdgeOfA { edge, part },
        }
    }

    /// A part of body number `body` (0 for A, 1 for B), and an edge of the other body.
    pub(crate) fn edge(body: usize, edge: u32, part: Part) -> Self {
        if body == 0 {
            Self::EdgeOfB { edge, part }
        } else {
            Self::EdgeOfA { edge, part }
        }
    }
}

impl<T> Outcome<T> {
    /// The contact, if there is one.
    pub fn contact(self) -> Option<Contact<T>> {
        match self {
            Self::Contact(contact) => Some(contact),
            _ => None,
        }
    }

    /// The outcome with another name for what touches.
    ///
    /// ```
    /// use carom_detection::{Contact, Outcome};
    ///
    /// let found = Outcome::Contact(Contact { time: 0.5, touch: 7 });
    /// let named = found.map(|part| format!("part {part}"));
    /// assert_eq!(named.contact().unwrap().touch, "part 7");
    /// ```
    #[inline]
    pub fn map<U>(self, name: impl FnOnce(T) -> U) -> Outcome<U> {
        match self {
            Self::Contact(Contact { time, touch }) => {
                let touch = name(touch);
                Outcome::Contact(Contact { time, touch })
            }
            Self::Free => Outcome::Free,
            Self::FreeUntil(time) => Outcome::FreeUntil(time),
            Self::Unresolved(time) => Outcome::Unresolved(time),
            Self::OutOfRange => Outcome::OutOfRange,
        }
    }

    /// The outcome with its times multiplied by `factor`.
    pub(crate) fn later(self, factor: f64) -> Self {
        match self {
            Self::Contact(contact) => Self::Contact(Contact {
                time: contact.time * factor,
                ..contact
            }),
            Self::FreeUntil(time) => Self::FreeUntil(time * factor),
            Self::Unresolved(time) => Self::Unresolved(time * factor),
            Self::Free | Self::OutOfRange => self,
        }
    }
}
