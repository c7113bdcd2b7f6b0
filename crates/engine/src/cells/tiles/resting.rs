//! The discs of a tile between two windows.

use crate::cells::{
    body_record::{BodyRecord, Kind},
    frame::TileFrame,
    slot::{INDEX_BITS, INDEX_MASK},
    state::State,
};

/// A disc between two windows, in one cache line.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub(super) struct RestingDisc {
    /// Its flight: see [`BodyRecord::flight`].
    pub flight: [f64; 4],
    /// Time of its event (offset in the epoch).
    pub time: f64,
    /// Kind of the event, and the index of the partner of a contact among all bodies.
    event: u32,
    pub partner_version: u32,
    pub version: u32,
    /// Column and row of its cell.
    pub cell: [u16; 2],
    /// Its index among all bodies.
    pub body: u32,
    /// Boxes left behind, modulo 2¹⁶.
    pub winding: [i16; 2],
}

/// A disc fills one cache line.
const _: () = assert!(size_of::<RestingDisc>() == 64);

impl RestingDisc {
    /// A disc without an event, at the start of an epoch or before its event is copied.
    pub fn new(record: &BodyRecord, body: u32, winding: [i16; 2]) -> Self {
        let &BodyRecord { flight, time, partner_version, version, .. } = record;
        let event = (Kind::Nothing as u32) << INDEX_BITS;
        Self { flight, time, event, partner_version, version, cell: record.cell(), body, winding }
    }

    /// A disc of a workspace. Its bodies have the indices `bodies` among all, and the partners of
    /// their events at the start of the window are `partners`.
    #[inline]
    pub fn of(state: &State<TileFrame>, index: u32, bodies: &[u32], partners: &[u32]) -> Self {
        let record = &state.records[index as usize];
        let body = bodies[index as usize];
        let mut disc = Self::new(record, body, state.windings[index as usize]);
        let partner = if record.kind().is_contact() {
            // The dummy stands for a partner that had changed before the window.
            bodies.get(record.partner() as usize).copied().unwrap_or(partners[index as usize])
        } else {
            0
        };
        disc.set_event(record.kind(), partner);
        disc
    }

    pub fn set_event(&mut self, kind: Kind, partner: u32) {
        self.event = ((kind as u32) << INDEX_BITS) | partner;
    }

    #[inline]
    pub fn kind(&self) -> Kind {
        Kind::from_bits(self.event >> INDEX_BITS)
    }

    /// The index of the partner of a contact among all bodies.
    #[inline]
    pub fn partner(&self) -> u32 {
        self.event & INDEX_MASK
    }

    /// The record of the disc in a workspace, without its event, for a disc of this radius
    /// (length).
    #[inline]
    pub fn record(&self, radius: f64) -> BodyRecord {
        let mut record = BodyRecord::at(self.flight, radius);
        record.version = self.version;
        record.set_cell(self.cell);
        record
    }
}

/// The discs of a tile between two windows, in the order of its cells.
#[derive(Debug, Clone, Default)]
pub(super) struct TileDiscs {
    pub discs: Vec<RestingDisc>,
    /// For each cell of the tile, row by row, its first disc; and the number of all.
    pub starts: Vec<u32>,
}

impl TileDiscs {
    pub fn heap_bytes(&self) -> usize {
        self.discs.capacity() * size_of::<RestingDisc>() + self.starts.capacity() * size_of::<u32>()
    }

    /// The discs in a run of cells.
    pub fn in_cells(&self, first: usize, count: usize) -> &[RestingDisc] {
        &self.discs[self.starts[first] as usize..self.starts[first + count] as usize]
    }

    /// Replaces all discs: those of `discs`, in `cells` cells, whose place in the tile is
    /// `cell_of`.
    pub fn fill(
        &mut self,
        cells: usize,
        discs: impl Iterator<Item = RestingDisc> + Clone,
        cell_of: impl Fn(&RestingDisc) -> usize,
    ) {
        self.starts.clear();
        self.starts.resize(cells + 1, 0);
        for disc in discs.clone() {
            self.starts[cell_of(&disc)] += 1;
        }
        let mut first = 0;
        for start in &mut self.starts {
            first += std::mem::replace(start, first);
        }
        let empty = RestingDisc::new(&BodyRecord::dummy(), 0, [0; 2]);
        self.discs.clear();
        if self.discs.capacity() < first as usize {
            // A little room for more, instead of twice as much.
            self.discs.reserve_exact(first as usize + first as usize / 32);
        }
        self.discs.resize(first as usize, empty);
        for disc in discs {
            let place = &mut self.starts[cell_of(&disc)];
            self.discs[*place as usize] = disc;
            *place += 1;
        }
        // Each start is now that of the next cell.
        self.starts.copy_within(..cells, 1);
        self.starts[0] = 0;
    }
}
