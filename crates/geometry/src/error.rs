//! What a caller may do wrong when describing a shape or a box.

use thiserror::Error;

/// A shape or box that cannot exist; the offending value is in the message.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum GeometryError {
    /// A quantity that must be positive is not, or is NaN, infinite or beyond 1e±60.
    #[error("{name} must be positive, finite and between 1e-60 and 1e60, but is {value}")]
    NotPositive {
        /// Which quantity.
        name: &'static str,
        /// The value given.
        value: f64,
    },
    /// A quantity is NaN, infinite or larger than 1e60.
    #[error("{name} must be finite and at most 1e60 in magnitude, but is {value}")]
    OutOfRange {
        /// Which quantity.
        name: &'static str,
        /// The value given.
        value: f64,
    },
    /// A wall where a molecule of discs is needed.
    #[error("a wall is not made of discs: the region it excludes is not bounded by their arcs alone")]
    Wall,
    /// A molecule without atoms.
    #[error("a molecule needs at least one atom")]
    NoAtoms,
    /// Two atoms of one molecule with the same centre.
    #[error("atoms {first} and {second} of the molecule have the same centre")]
    CoincidentAtoms {
        /// Index of the first atom.
        first: usize,
        /// Index of the second atom.
        second: usize,
    },
    /// A shape name that is not known.
    #[error("unknown shape '{0}': known are disc, dumbbell, rod:N, cross, tee, ring:N")]
    UnknownShape(String),
    /// A rod or ring with an impossible number of atoms.
    #[error("a {shape} of {count} atoms cannot be built: it needs {least} to 4096")]
    AtomCount {
        /// Rod or ring.
        shape: &'static str,
        /// The number asked for.
        count: usize,
        /// The least number that makes sense.
        least: usize,
    },
}
