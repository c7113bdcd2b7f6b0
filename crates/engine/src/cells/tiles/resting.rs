//! The moving bodies of a tile between two windows.

use std::ops::Range;

use carom_kinematics::Motion;
use glam::DVec2;

use crate::cells::{
    body_record::{BodyRecord, RecordKind},
    frame::TileFrame,
    multi_cell::Pending,
    slot::{INDEX_BITS, INDEX_MASK},
    state::CellState,
};

/// A body between two windows, in one cache line. It describes a disc completely; of molecules see
/// [`Rest`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub(super) struct RestingBody {
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

/// It fills one cache line.
const _: () = assert!(size_of::<RestingBody>() == 64);

impl RestingBody {
    /// A body without an event, at the start of an epoch or before its event is copied.
    pub fn new(record: &BodyRecord, body: u32, winding: [i16; 2]) -> Self {
        let &BodyRecord {
            flight,
            time,
            partner_version,
            version,
            ..
        } = record;
        let event = (RecordKind::Nothing as u32) << INDEX_BITS;
        Self {
            flight,
            time,
            event,
            partner_version,
            version,
            cell: record.cell(),
            body,
            winding,
        }
    }

    /// A body of a workspace. The partners of the events at the start of the window are `partners`.
    #[inline]
    pub fn from_state(state: &CellState<TileFrame>, index: u32, partners: &[u32]) -> Self {
        let record = &state.records[index as usize];
        let bodies = &state.bodies.0;
        let body = bodies[index as usize];
        let mut resting = Self::new(record, body, state.windings[index as usize]);
        let partner = if record.kind().is_contact() {
            // The dummy stands for a partner that had changed before the window.
            bodies
                .get(record.partner() as usize)
                .copied()
                .unwrap_or(partners[index as usize])
        } else {
            0
        };
        resting.set_event(record.kind(), partner);
        resting
    }

    pub fn set_event(&mut self, kind: RecordKind, partner: u32) {
        self.event = ((kind as u32) << INDEX_BITS) | partner;
    }

    #[inline]
    pub fn kind(&self) -> RecordKind {
        RecordKind::from_bits(self.event >> INDEX_BITS)
    }

    /// The index of the partner of a contact among all bodies.
    #[inline]
    pub fn partner(&self) -> u32 {
        self.event & INDEX_MASK
    }

    /// Its record in a workspace, without its event, for this radius (length).
    #[inline]
    pub fn record(&self, radius: f64) -> BodyRecord {
        let mut record = BodyRecord::at(self.flight, radius);
        record.version = self.version;
        record.set_cell(self.cell);
        record
    }
}

/// What the records of bodies do not hold, by body.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rest<'a> {
    /// The motions of molecules; empty if all are discs.
    pub motions: &'a [Motion],
    /// The contacts that the events stand for; empty if all are contacts of two discs in cells.
    pub pending: &'a [Pending],
}

/// Moving bodies, with what their records do not hold.
#[derive(Debug, Clone, Default)]
pub(super) struct MovingBodies {
    pub list: Vec<RestingBody>,
    /// By place in `list`, or empty: see [`Rest`].
    pub motions: Vec<Motion>,
    pub pending: Vec<Pending>,
}

impl MovingBodies {
    pub fn clear(&mut self) {
        self.list.clear();
        self.motions.clear();
        self.pending.clear();
    }

    /// Adds the bodies in these places of another list.
    pub fn add(&mut self, from: &Self, places: Range<usize>) {
        self.list.extend_from_slice(&from.list[places.clone()]);
        self.motions
            .extend_from_slice(from.motions.get(places.clone()).unwrap_or_default());
        self.pending
            .extend_from_slice(from.pending.get(places).unwrap_or_default());
    }

    /// Size of the bodies (bytes).
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.list) + size_of_val(&*self.motions) + size_of_val(&*self.pending)
    }

    pub fn heap_bytes(&self) -> usize {
        self.list.capacity() * size_of::<RestingBody>()
            + self.motions.capacity() * size_of::<Motion>()
            + self.pending.capacity() * size_of::<Pending>()
    }
}

/// The moving bodies of a tile between two windows, in the order of its cells.
#[derive(Debug, Clone, Default)]
pub(super) struct TileBodies {
    pub moving: MovingBodies,
    /// For each cell of the tile, row by row, its first body; and the number of all.
    starts: Vec<u32>,
}

impl TileBodies {
    pub fn heap_bytes(&self) -> usize {
        self.moving.heap_bytes() + self.starts.capacity() * size_of::<u32>()
    }

    /// The bodies in a run of cells, as places in the list.
    pub fn in_cells(&self, first: usize, count: usize) -> Range<usize> {
        self.starts[first] as usize..self.starts[first + count] as usize
    }

    /// Replaces all bodies: those of `bodies`, each with its index in `rest`, in `cells` cells,
    /// whose place in the tile is `cell_of`.
    pub fn fill(
        &mut self,
        cells: usize,
        bodies: impl Iterator<Item = (RestingBody, u32)> + Clone,
        rest: Rest<'_>,
        cell_of: impl Fn(&RestingBody) -> usize,
    ) {
        self.starts.clear();
        self.starts.resize(cells + 1, 0);
        for (body, _) in bodies.clone() {
            self.starts[cell_of(&body)] += 1;
        }
        let mut first = 0;
        for start in &mut self.starts {
            first += std::mem::replace(start, first);
        }
        let count = first as usize;
        let if_any = |is_empty: bool| if is_empty { 0 } else { count };
        resize(
            &mut self.moving.list,
            count,
            RestingBody::new(&BodyRecord::dummy(), 0, [0; 2]),
        );
        resize(
            &mut self.moving.motions,
            if_any(rest.motions.is_empty()),
            Motion::at_rest(DVec2::ZERO),
        );
        resize(
            &mut self.moving.pending,
            if_any(rest.pending.is_empty()),
            Pending::NOTHING,
        );
        for (body, index) in bodies {
            let start = &mut self.starts[cell_of(&body)];
            let place = *start as usize;
            *start += 1;
            self.moving.list[place] = body;
            if let Some(motion) = rest.motions.get(index as usize) {
                self.moving.motions[place] = *motion;
            }
            if let Some(pending) = rest.pending.get(index as usize) {
                self.moving.pending[place] = *pending;
            }
        }
        // Each start is now that of the next cell.
        self.starts.copy_within(..cells, 1);
        self.starts[0] = 0;
    }
}

/// Makes a list of so many entries, with room for a few more, instead of twice as many.
fn resize<T: Clone>(list: &mut Vec<T>, count: usize, entry: T) {
    list.clear();
    if list.capacity() < count {
        list.reserve_exact(count + count / 32);
    }
    list.resize(count, entry);
}
