//! Atoms side by side, as vector registers read them.

use crate::Atom;

/// Some atoms of a molecule, number by number; if they are fewer, the last one fills up the row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AtomRow {
    /// Places in the frame of the molecule (length), x and y.
    pub offset: [[f64; Self::LANES]; 2],
    /// Length.
    pub radius: [f64; Self::LANES],
    /// Distances from the centre of mass (length).
    pub arm: [f64; Self::LANES],
}

impl AtomRow {
    /// How many atoms a row holds.
    pub const LANES: usize = 4;

    /// Rows that hold all these atoms.
    pub(crate) fn of(atoms: &[Atom]) -> impl Iterator<Item = Self> {
        atoms.chunks(Self::LANES).map(|some| {
            let row: [&Atom; Self::LANES] = std::array::from_fn(|lane| &some[lane.min(some.len() - 1)]);
            Self {
                offset: [row.map(|atom| atom.offset().x), row.map(|atom| atom.offset().y)],
                radius: row.map(Atom::radius),
                arm: row.map(Atom::arm),
            }
        })
    }
}
