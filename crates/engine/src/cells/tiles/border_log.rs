//! The events near the border of a tile, as it and its neighbours have computed them.

use carom_kinematics::Motion;
use smallvec::SmallVec;

use super::{
    map::{DIRECTIONS, Rectangle, direction_index},
    trim,
};
use crate::cells::{
    body_record::RecordKind,
    frame::{Numbering, TileFrame},
    state::CellState,
};

/// Rings of cells on each side of a border whose events are compared: an event that changes a cell
/// reads the cells within two of it.
pub(super) const RINGS: u32 = 2;

/// Rings that are counted around a tile. A border is narrower.
pub(super) const MAX_RINGS: u32 = u8::MAX as u32;

/// Place of a column or row relative to a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
enum Band {
    Far,
    OutsideBelow,
    InsideBelow,
    Middle,
    InsideAbove,
    OutsideAbove,
}

/// Places of the columns or rows of a window.
#[derive(Debug, Clone, Copy)]
struct Along {
    band: Band,
    /// Distance from the tile in cells, 0 inside.
    ring: u8,
}

/// The places of the cells of a window relative to its tile.
#[derive(Debug, Clone, Default)]
pub(super) struct Places {
    axes: [Vec<Along>; 2],
}

impl Places {
    /// Places in a window that extends a tile by `border` cells and one ring of lists.
    pub fn lay_out(&mut self, own: Rectangle, border: u32) {
        for axis in 0..2 {
            let size = own.size[axis] as i32;
            let first = border as i32 + 1;
            let rings = RINGS as i32;
            let along = (0..size + 2 * first).map(|list| {
                let place = list - first;
                let ring = (-place).max(place - size + 1).max(0);
                let band = match place {
                    _ if ring > rings => Band::Far,
                    _ if place < 0 => Band::OutsideBelow,
                    _ if place < rings => Band::InsideBelow,
                    _ if place >= size => Band::OutsideAbove,
                    _ if place >= size - rings => Band::InsideAbove,
                    _ => Band::Middle,
                };
                Along {
                    band,
                    ring: ring.min(MAX_RINGS as i32) as u8,
                }
            });
            self.axes[axis].clear();
            self.axes[axis].extend(along);
        }
    }

    /// Distance of a cell from the tile, 0 inside.
    #[inline(always)]
    pub fn ring(&self, window: &TileFrame, cell: [u16; 2]) -> usize {
        let [column, row] = window.place(cell);
        usize::from(
            self.axes[0][column as usize]
                .ring
                .max(self.axes[1][row as usize].ring),
        )
    }

    #[inline(always)]
    fn bands(&self, window: &TileFrame, cell: [u16; 2]) -> [Band; 2] {
        let [column, row] = window.place(cell);
        [
            self.axes[0][column as usize].band,
            self.axes[1][row as usize].band,
        ]
    }
}

/// The change of a body by an event, as bits.
#[derive(Debug, Clone)]
pub(super) struct BorderChange(SmallVec<[u64; 20]>);

impl BorderChange {
    /// The change of a body at `time` (offset in the epoch): the body and its version, its new
    /// flight and event, and all else that its later events depend on. `last_contact` is none where
    /// no outcome depends on it.
    pub fn new(
        state: &CellState<TileFrame>,
        body: u32,
        time: f64,
        last_contact: Option<f64>,
    ) -> Self {
        let record = &state.records[body as usize];
        let pair = |low: u32, high: u32| u64::from(low) | u64::from(high) << 32;
        let (kind, partner) = (record.kind(), record.partner());
        // The dummy stands for a partner outside the workspace.
        let partner = state
            .bodies
            .0
            .get(partner as usize)
            .copied()
            .unwrap_or(u32::MAX);
        let mut words = SmallVec::new();
        words.push(pair(state.bodies.among_all(body), record.version));
        words.push(time.to_bits());
        words.extend(record.flight.map(f64::to_bits));
        words.extend(last_contact.map(f64::to_bits));
        words.push(record.time.to_bits());
        words.push(if kind.is_contact() {
            pair(kind as u32 | partner << 4, record.partner_version)
        } else {
            kind as u64
        });
        if kind == RecordKind::MultiCell {
            words.extend(state.multi_cell.pending(body).to_words());
        }
        if let Some(motion) = state.molecules.motion(body) {
            let Motion {
                position,
                velocity,
                orientation,
                angular_velocity,
                time,
            } = *motion;
            let numbers = [
                position.x,
                position.y,
                velocity.x,
                velocity.y,
                orientation.turns(),
            ];
            words.extend(
                numbers
                    .into_iter()
                    .chain([angular_velocity, time])
                    .map(f64::to_bits),
            );
        }
        Self(words)
    }
}

/// The changes of the cells near the border of a tile, in order and as bits, by the neighbour that
/// compares them.
#[derive(Debug, Clone, Default)]
pub(super) struct BorderLog {
    /// In cells of each neighbour.
    outside: [Vec<u64>; DIRECTIONS.len()],
    /// In cells of the tile, near each neighbour.
    inside: [Vec<u64>; DIRECTIONS.len()],
}

impl BorderLog {
    pub fn clear(&mut self) {
        self.outside
            .iter_mut()
            .chain(&mut self.inside)
            .for_each(Vec::clear);
    }

    /// Gives back memory that later windows of the same length will hardly need.
    pub fn trim(&mut self) {
        self.outside
            .iter_mut()
            .chain(&mut self.inside)
            .for_each(trim);
    }

    /// Whether this tile and its neighbour in a direction have computed the same changes in the
    /// cells of this tile that the neighbour compares.
    pub fn agrees(&self, direction: usize, neighbour: &Self, opposite: usize) -> bool {
        self.inside[direction] == neighbour.outside[opposite]
    }

    /// Logs a change of a cell, if the cell is near the border.
    #[inline(always)]
    pub fn note(
        &mut self,
        places: &Places,
        window: &TileFrame,
        cell: [u16; 2],
        change: impl FnOnce() -> BorderChange,
    ) {
        let bands = places.bands(window, cell);
        let [across, up] = bands;
        let is_far_inside = (across, up) == (Band::Middle, Band::Middle);
        if !(is_far_inside | (across == Band::Far) | (up == Band::Far)) {
            self.note_near_border(bands, &change().0);
        }
    }

    #[inline(never)]
    fn note_near_border(&mut self, bands: [Band; 2], change: &[u64]) {
        let outside = bands.map(|band| match band {
            Band::OutsideBelow => -1,
            Band::OutsideAbove => 1,
            _ => 0,
        });
        if outside != [0, 0] {
            self.outside[direction_index(outside)].extend_from_slice(change);
            return;
        }
        let [across, up] = bands.map(|band| match band {
            Band::InsideBelow => -1,
            Band::InsideAbove => 1,
            _ => 0,
        });
        if across != 0 {
            self.inside[direction_index([across, 0])].extend_from_slice(change);
        }
        if up != 0 {
            self.inside[direction_index([0, up])].extend_from_slice(change);
        }
        if across != 0 && up != 0 {
            self.inside[direction_index([across, up])].extend_from_slice(change);
        }
    }

    /// Size of the logs (bytes).
    pub fn bytes(&self) -> usize {
        self.outside
            .iter()
            .chain(&self.inside)
            .map(Vec::len)
            .sum::<usize>()
            * size_of::<u64>()
    }

    pub fn heap_bytes(&self) -> usize {
        let logs = self.outside.iter().chain(&self.inside);
        logs.map(|log| log.capacity() * size_of::<u64>()).sum()
    }
}
