//! Atoms as a structure of arrays, for SIMD registers.

use crate::Atom;

/// Up to [`Self::LANES`] atoms of a molecule as a structure of arrays; the last atom fills the
/// unused lanes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AtomRow {
    /// Positions in the frame of the molecule (length), x and y.
    pub offset: [[f64; Self::LANES]; 2],
    /// Radii (length).
    pub radius: [f64; Self::LANES],
    /// Distances from the centre of mass (length).
    pub arm: [f64; Self::LANES],
}

impl AtomRow {
    /// The number of atoms in a row.
    pub const LANES: usize = 4;

    /// The rows of the given atoms.
    pub(crate) fn rows(atoms: &[Atom]) -> impl Iterator<Item = Self> {
        atoms.chunks(Self::LANES).map(|some| {
            let row: [&Atom; Self::LANES] =
                std::array::from_fn(|lane| &some[lane.min(some.len() - 1)]);
            Self {
                offset: [
                    row.map(|atom| atom.offset().x),
                    row.map(|atom| atom.offset().y),
                ],
                radius: row.map(Atom::radius),
                arm: row.map(Atom::arm),
            }
        })
    }
}
