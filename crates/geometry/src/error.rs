//! Errors in the description of a shape or a box.

use thiserror::Error;

/// An invalid shape or box; the message holds the offending value.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum GeometryError {
    /// A quantity that must be positive is not, or is NaN, infinite or beyond 1e±60.
    #[error("{name} must be positive, finite and between 1e-60 and 1e60, but is {value:?}")]
    NotPositive {
        /// Name of the quantity.
        name: &'static str,
        /// The value given.
        value: f64,
    },
    /// A quantity is NaN, infinite or larger than 1e60.
    #[error("{name} must be finite and at most 1e60 in magnitude, but is {value:?}")]
    OutOfRange {
        /// Name of the quantity.
        name: &'static str,
        /// The value given.
        value: f64,
    },
    /// An ellipse whose axes have another ratio than detection resolves.
    #[error(
        "the longer axis of an ellipse must be 1 to 10000 times the shorter one, but is {0:?} times as long"
    )]
    AspectRatio(f64),
    /// A direction of an ellipse that is no unit vector.
    #[error("the direction of an ellipse must have the length 1, but has {0:?}")]
    NoDirection(f64),
    /// Two ellipses of one molecule that overlap.
    #[error(
        "parts {first} and {second} of a molecule with ellipses overlap by {depth:?}: they may touch, but not \
         overlap, because the area of their union is not known; move them apart"
    )]
    EllipsesOverlap {
        /// Index of the first ellipse.
        first: usize,
        /// Index of the second ellipse.
        second: usize,
        /// Depth of the overlap (length).
        depth: f64,
    },
    /// An arc with a number out of range.
    #[error("{what} must be {range}, but is {value:?}")]
    Bend {
        /// Which number.
        what: &'static str,
        /// Its value (length or radians).
        value: f64,
        /// The allowed range.
        range: &'static str,
    },
    /// A wall where a molecule of discs is needed.
    #[error("the excluded region of a wall is not available: use a molecule of discs")]
    Wall,
    /// Several ellipses where the boundary of their union is needed.
    #[error("the excluded region of several ellipses is not available: use one, or other shapes")]
    ExcludedByEllipses,
    /// A molecule without atoms.
    #[error("a molecule needs at least one atom")]
    NoAtoms,
    /// An edge that no two atoms can have.
    #[error("edge {index}, between atoms {} and {}, {problem}", .ends[0], .ends[1])]
    Edge {
        /// Index of the edge.
        index: usize,
        /// The atoms that it names.
        ends: [u32; 2],
        /// What is wrong.
        problem: &'static str,
    },
    /// A list of corners that is no polygon.
    #[error("the polygon {0}")]
    Polygon(String),
    /// Two atoms of one molecule with the same centre.
    #[error("atoms {first} and {second} of the molecule have the same centre")]
    CoincidentAtoms {
        /// Index of the first atom.
        first: usize,
        /// Index of the second atom.
        second: usize,
    },
    /// An unknown name of a shape.
    #[error(
        "unknown shape '{0}': use disc, dumbbell, rod:N, cross, tee, ring:N, capsule:L, square, rectangle:A, \
         triangle, polygon:N, kite:A,B or ellipse:K"
    )]
    UnknownShape(String),
    /// A superellipse, whose contacts are not certified.
    #[error(
        "'{0}' is not available: on its axes the radius of curvature of a superellipse is \
         infinite (exponents above 2) or 0 (below 2), and the bounds on the derivatives of the \
         support function that certify contacts fail there; use ellipse:K, or `polygon` with \
         corners on the superellipse"
    )]
    Superellipse(String),
    /// A rod or ring with an invalid number of atoms.
    #[error("a {shape} must have {least} to 4096 atoms, but has {count}")]
    AtomCount {
        /// Rod or ring.
        shape: &'static str,
        /// The number given.
        count: usize,
        /// The smallest valid number.
        least: usize,
    },
}
