//! The events near the border of a tile, as it and its neighbours have computed them.

use super::map::{DIRECTIONS, Rectangle, direction_index};
use crate::cells::{body_record::BodyRecord, frame::TileFrame};

/// Rings of cells on each side of a border whose events are compared: an event that changes a cell
/// reads the cells within two of it.
pub(super) const RINGS: u32 = 2;

/// Rings that are counted around a tile. A border is narrower.
pub(super) const MOST_RINGS: u32 = u8::MAX as u32;

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
                Along { band, ring: ring.min(MOST_RINGS as i32) as u8 }
            });
            self.axes[axis].clear();
            self.axes[axis].extend(along);
        }
    }

    /// Distance of a cell from the tile, 0 inside.
    #[inline(always)]
    pub fn ring(&self, window: &TileFrame, cell: [u16; 2]) -> usize {
        let [column, row] = window.place(cell);
        usize::from(self.axes[0][column as usize].ring.max(self.axes[1][row as usize].ring))
    }

    #[inline(always)]
    fn bands(&self, window: &TileFrame, cell: [u16; 2]) -> [Band; 2] {
        let [column, row] = window.place(cell);
        [self.axes[0][column as usize].band, self.axes[1][row as usize].band]
    }
}

/// The change of a disc by an event: disc and version, time, new flight, time of the next event and
/// of the last contact, as bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Change([u64; 8]);

impl Change {
    /// `last_contact` is 0 where no outcome depends on it.
    #[inline(always)]
    pub fn new(disc: u32, time: f64, record: &BodyRecord, last_contact: f64) -> Self {
        let [a, b, c, d] = record.flight.map(f64::to_bits);
        let disc = u64::from(disc) | u64::from(record.version) << 32;
        Self([disc, time.to_bits(), a, b, c, d, record.time.to_bits(), last_contact.to_bits()])
    }
}

/// The changes of the cells near the border of a tile, in order, by the neighbour that compares
/// them.
#[derive(Debug, Clone, Default)]
pub(super) struct BorderLog {
    /// In cells of each neighbour.
    outside: [Vec<Change>; DIRECTIONS.len()],
    /// In cells of the tile, near each neighbour.
    inside: [Vec<Change>; DIRECTIONS.len()],
}

impl BorderLog {
    pub fn clear(&mut self) {
        self.outside.iter_mut().chain(&mut self.inside).for_each(Vec::clear);
    }

    /// Whether this tile and its neighbour in a direction have computed the same changes in the
    /// cells of this tile that the neighbour compares.
    pub fn agrees(&self, direction: usize, neighbour: &Self, opposite: usize) -> bool {
        self.inside[direction] == neighbour.outside[opposite]
    }

    /// Logs a change of a cell, if the cell is near the border.
    #[inline(always)]
    pub fn note(&mut self, places: &Places, window: &TileFrame, cell: [u16; 2], change: Change) {
        let [across, up] = places.bands(window, cell);
        if (across, up) != (Band::Middle, Band::Middle) {
            self.note_near_border([across, up], change);
        }
    }

    #[inline(never)]
    fn note_near_border(&mut self, bands: [Band; 2], change: Change) {
        if bands.contains(&Band::Far) {
            return;
        }
        let outside = bands.map(|band| match band {
            Band::OutsideBelow => -1,
            Band::OutsideAbove => 1,
            _ => 0,
        });
        if outside != [0, 0] {
            self.outside[direction_index(outside)].push(change);
            return;
        }
        let [across, up] = bands.map(|band| match band {
            Band::InsideBelow => -1,
            Band::InsideAbove => 1,
            _ => 0,
        });
        if across != 0 {
            self.inside[direction_index([across, 0])].push(change);
        }
        if up != 0 {
            self.inside[direction_index([0, up])].push(change);
        }
        if across != 0 && up != 0 {
            self.inside[direction_index([across, up])].push(change);
        }
    }

    /// Size of the logs (bytes).
    pub fn bytes(&self) -> usize {
        self.outside.iter().chain(&self.inside).map(Vec::len).sum::<usize>() * size_of::<Change>()
    }

    pub fn heap_bytes(&self) -> usize {
        let logs = self.outside.iter().chain(&self.inside);
        logs.map(|log| log.capacity() * size_of::<Change>()).sum()
    }
}
