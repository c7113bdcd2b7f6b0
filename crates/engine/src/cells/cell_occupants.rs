//! The discs in each cell of a dilute gas, with their flights in single precision.
//!
//! Cells are longer here than two discs reach, so that crossings are rarer, and hold a few discs
//! each. A neighbour list of 3 × 3 such cells would be long, and a crossing would change six lists;
//! it changes the occupants of two cells only. Many discs are tested for each contact, so the
//! flights are stored with the occupants, in the form that the filter reads: see `f32_filter`.

use std::hint::select_unpredictable as select;

use carom_detection::DISC_LANES;

use super::{
    f32_filter::{Flights, Units},
    simd::Kernel,
    slot::{INDEX_BITS, INDEX_MASK, image_code, wrap_cell},
};
use crate::world::index_or_none::IndexOrNone;

/// The flights of a block, aligned to cache lines.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
struct Block(Flights);

/// The discs of each cell of a grid of at least three cells a side.
#[derive(Debug, Clone, Default)]
pub(super) struct CellOccupants {
    columns: u32,
    rows: u32,
    /// The three columns around each column and the three rows around each row, as slots: with the
    /// code of the image in which they are seen. Rows are multiplied by the number of columns.
    columns_around: Vec<[u32; 3]>,
    rows_around: Vec<[u32; 3]>,
    /// Blocks of eight discs: one for each cell, then overflow blocks. Structure of arrays: the
    /// flights, which every prediction reads, lie apart from the indices, which it reads for discs
    /// that pass the filter.
    flights: Vec<Block>,
    /// The discs in the eight lanes of a block; free lanes come last and hold the dummy.
    discs: Vec<[u32; DISC_LANES]>,
    /// The next block of the same cell.
    next: Vec<IndexOrNone>,
    /// Blocks not in use.
    free: Vec<u32>,
    dummy: u32,
    units: Units,
}

impl CellOccupants {
    /// Empties all cells, for `discs` discs whose flights are stored in these units; `discs` is the
    /// index of the dummy.
    pub fn lay_out(&mut self, [columns, rows]: [u32; 2], discs: u32, units: Units) {
        if [self.columns, self.rows] != [columns, rows] {
            (self.columns, self.rows) = (columns, rows);
            let around = |count: u32, stride: u32, bits: u32| {
                let at = |index: u32, offset: i32| {
                    let (index, image) = wrap_cell(index as i32 + offset, count as i32);
                    (index as u32 * stride) | (image_code(image) << bits)
                };
                (0..count)
                    .map(|index| [-1, 0, 1].map(|offset| at(index, offset)))
                    .collect()
            };
            self.columns_around = around(columns, 1, INDEX_BITS);
            self.rows_around = around(rows, columns, INDEX_BITS + 2);
        }
        self.dummy = discs;
        self.units = units;
        let cells = (columns * rows) as usize;
        self.flights.clear();
        self.flights.resize(cells, Block::EMPTY);
        self.discs.clear();
        self.discs.resize(cells, [discs; DISC_LANES]);
        self.next.clear();
        self.next.resize(cells, IndexOrNone::NONE);
        self.free.clear();
    }

    pub fn heap_bytes(&self) -> usize {
        self.flights.capacity() * size_of::<Block>()
            + self.discs.capacity() * size_of::<[u32; DISC_LANES]>()
            + (self.columns_around.capacity() + self.rows_around.capacity()) * size_of::<[u32; 3]>()
            + (self.next.capacity() + self.free.capacity()) * size_of::<u32>()
    }

    /// The 3 × 3 cells around a cell, as slots: with the image in which they are seen from it.
    #[inline(always)]
    pub fn around(&self, [column, row]: [u16; 2]) -> [u32; 9] {
        let [left, middle, right] = self.columns_around[column as usize];
        let [below, beside, above] = self.rows_around[row as usize];
        [
            left + below,
            middle + below,
            right + below,
            left + beside,
            middle + beside,
            right + beside,
            left + above,
            middle + above,
            right + above,
        ]
    }

    /// The three cells around `cell` that were not around the one before it, if it was entered
    /// along an axis, upwards or downwards.
    #[inline(always)]
    pub fn ahead(&self, [column, row]: [u16; 2], axis: usize, direction: i32) -> [u32; 3] {
        let (columns, rows) = (
            &self.columns_around[column as usize],
            &self.rows_around[row as usize],
        );
        let (along, [before, beside, after]) = if axis == 0 {
            (columns, rows)
        } else {
            (rows, columns)
        };
        let next = select(direction > 0, along[2], along[0]);
        [next + before, next + beside, next + after]
    }

    /// Index in free lanes.
    pub fn dummy(&self) -> u32 {
        self.dummy
    }

    pub fn units(&self) -> &Units {
        &self.units
    }

    /// All blocks, for reading.
    #[inline(always)]
    pub fn blocks(&self) -> OccupantBlocks<'_> {
        // Slices of one length, so that one bounds check serves all three.
        let next = &self.next[..];
        OccupantBlocks {
            flights: &self.flights[..next.len()],
            discs: &self.discs[..next.len()],
            next,
        }
    }

    /// Adds a disc to the occupants of a cell.
    #[inline(always)]
    pub fn enter<K: Kernel>(&mut self, kernel: K, disc: u32, cell: [u16; 2], flight: [f64; 4]) {
        let mut block = self.first_block(cell);
        let mut free = kernel.find(&self.discs[block], self.dummy);
        while free == 0 {
            block = self.block_after(block);
            free = kernel.find(&self.discs[block], self.dummy);
        }
        let lane = lowest(free);
        self.discs[block][lane] = disc;
        self.flights[block].set(lane, self.units.quantize(flight));
    }

    #[inline]
    fn first_block(&self, [column, row]: [u16; 2]) -> usize {
        (u32::from(row) * self.columns + u32::from(column)) as usize
    }

    /// The block after a full one.
    #[cold]
    fn block_after(&mut self, block: usize) -> usize {
        if self.next[block] == IndexOrNone::NONE {
            let free = self.free.pop();
            let added = free.map_or_else(|| self.add_block(), |free| free as usize);
            self.next[block] = IndexOrNone::new(added);
        }
        self.next[block].index()
    }

    /// Adds an empty block, and returns its index.
    fn add_block(&mut self) -> usize {
        if self.flights.len() == self.flights.capacity() {
            // Grows by a sixteenth instead of doubling.
            let more = self.flights.len() / 16 + 1;
            self.flights.reserve_exact(more);
            self.discs.reserve_exact(more);
            self.next.reserve_exact(more);
        }
        self.flights.push(Block::EMPTY);
        self.discs.push([self.dummy; DISC_LANES]);
        self.next.push(IndexOrNone::NONE);
        self.next.len() - 1
    }

    /// Removes a disc from the occupants of a cell.
    #[inline(always)]
    pub fn leave<K: Kernel>(&mut self, kernel: K, disc: u32, cell: [u16; 2]) {
        let (block, lane) = self.place(kernel, disc, cell);
        let discs = &mut self.discs[block];
        // Free lanes come last.
        let last = (kernel
            .find(discs, self.dummy)
            .trailing_zeros()
            .min(DISC_LANES as u32)
            - 1) as usize;
        discs[lane] = discs[last];
        discs[last] = self.dummy;
        let flights = &mut self.flights[block];
        flights.set(lane, flights.0.each_ref().map(|numbers| numbers[last]));
        flights.0[0][last] = f32::NAN;
        if last == 0 && block >= (self.columns * self.rows) as usize {
            self.release(block, cell);
        }
    }

    /// Unlinks an empty block from a cell.
    #[cold]
    fn release(&mut self, block: usize, cell: [u16; 2]) {
        let mut before = self.first_block(cell);
        while self.next[before].index() != block {
            before = self.next[before].index();
        }
        self.next[before] = std::mem::replace(&mut self.next[block], IndexOrNone::NONE);
        self.free.push(block as u32);
    }

    /// Sets the flight of an occupant of a cell.
    #[inline(always)]
    pub fn set_flight<K: Kernel>(
        &mut self,
        kernel: K,
        disc: u32,
        cell: [u16; 2],
        flight: [f64; 4],
    ) {
        let (block, lane) = self.place(kernel, disc, cell);
        self.flights[block].set(lane, self.units.quantize(flight));
    }

    /// Block and lane of an occupant of a cell.
    #[inline(always)]
    fn place<K: Kernel>(&self, kernel: K, disc: u32, cell: [u16; 2]) -> (usize, usize) {
        let mut block = self.first_block(cell);
        let mut found = kernel.find(&self.discs[block], disc);
        while found == 0 {
            block = self.next[block].index();
            found = kernel.find(&self.discs[block], disc);
        }
        (block, lowest(found))
    }
}

/// The blocks of all cells.
#[derive(Clone, Copy)]
pub(super) struct OccupantBlocks<'a> {
    flights: &'a [Block],
    discs: &'a [[u32; DISC_LANES]],
    next: &'a [IndexOrNone],
}

impl<'a> OccupantBlocks<'a> {
    /// The discs of the cell in a slot, with their flights, block by block; free lanes hold the
    /// dummy.
    #[inline(always)]
    pub fn blocks(self, slot: u32) -> impl Iterator<Item = (&'a Flights, &'a [u32; DISC_LANES])> {
        let mut rest = IndexOrNone::new((slot & INDEX_MASK) as usize);
        std::iter::from_fn(move || {
            let block = rest.get()?;
            rest = self.next[block];
            Some((&self.flights[block].0, &self.discs[block]))
        })
    }
}

/// The lowest bit that is set.
#[inline]
fn lowest(places: u32) -> usize {
    places.trailing_zeros() as usize % DISC_LANES
}

impl Block {
    const EMPTY: Self = Self([[f32::NAN; DISC_LANES]; 4]);

    #[inline]
    fn set(&mut self, lane: usize, flight: [f32; 4]) {
        for (numbers, number) in self.0.iter_mut().zip(flight) {
            numbers[lane] = number;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::{simd::Portable, slot::image_of};
    use glam::DVec2;
    use proptest::prelude::*;

    /// Units in which the numbers of the test are exact.
    fn plain_units() -> Units {
        Units::new(0.1, DVec2::ONE, 1.0, [DVec2::new(0.25, 0.0)].into_iter())
    }

    proptest! {
        /// Any discs in any cells (all in one, too), moved about: the occupants around each cell
        /// and their flights are those of a search through all discs.
        #[test]
        fn occupants_are_exactly_the_discs_of_each_cell(
            columns in 3u16..6, rows in 3u16..6, crowd in any::<bool>(),
            starts in prop::collection::vec((0u16..6, 0u16..6), 1..80),
            moves in prop::collection::vec((0usize..80, 0u16..6, 0u16..6, any::<bool>()), 0..200),
        ) {
            let mut cells: Vec<[u16; 2]> =
                starts.iter().map(|&(x, y)| if crowd { [0, 0] } else { [x % columns, y % rows] }).collect();
            let mut flights: Vec<[f64; 4]> = (0..cells.len()).map(|disc| [disc as f64; 4]).collect();
            let mut occupants = CellOccupants::default();
            let dummy = cells.len() as u32;
            occupants.lay_out([u32::from(columns), u32::from(rows)], dummy, plain_units());
            for (disc, &cell) in cells.iter().enumerate() {
                occupants.enter(Portable, disc as u32, cell, flights[disc]);
            }
            for (disc, x, y, turns) in moves {
                let disc = disc % cells.len();
                if turns {
                    flights[disc] = flights[disc].map(|number| number + 100.0);
                    occupants.set_flight(Portable, disc as u32, cells[disc], flights[disc]);
                }
                occupants.leave(Portable, disc as u32, cells[disc]);
                cells[disc] = [x % columns, y % rows];
                occupants.enter(Portable, disc as u32, cells[disc], flights[disc]);
            }
            for row in 0..rows {
                for column in 0..columns {
                    let mut seen = Vec::new();
                    for slot in occupants.around([column, row]) {
                        let image = image_of(slot);
                        for (eight, discs) in occupants.blocks().blocks(slot) {
                            for (lane, &disc) in discs.iter().enumerate() {
                                let flight = eight.map(|numbers| f64::from(numbers[lane]));
                                prop_assert_eq!(flight[0].is_nan(), disc == dummy);
                                if disc != dummy {
                                    prop_assert_eq!(flight, flights[disc as usize]);
                                    seen.push((disc, image));
                                }
                            }
                        }
                    }
                    seen.sort_unstable();
                    let mut expected = Vec::new();
                    for (disc, cell) in cells.iter().enumerate() {
                        for [dx, dy] in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| [dx, dy])) {
                            let (x, image_x) = wrap_cell(i32::from(column) + dx, i32::from(columns));
                            let (y, image_y) = wrap_cell(i32::from(row) + dy, i32::from(rows));
                            if [x, y] == [i32::from(cell[0]), i32::from(cell[1])] {
                                expected.push((disc as u32, [image_x, image_y]));
                            }
                        }
                    }
                    expected.sort_unstable();
                    prop_assert_eq!(seen, expected);
                    // `ahead` returns those of `around` that are new.
                    let around = occupants.around([column, row]);
                    for (axis, direction) in [(0, -1), (0, 1), (1, -1), (1, 1)] {
                        let ahead = |place: usize| {
                            let offset = [place as i32 % 3 - 1, place as i32 / 3 - 1];
                            (offset[axis] == direction).then_some(around[place])
                        };
                        let expected: Vec<u32> = (0..9).filter_map(ahead).collect();
                        prop_assert_eq!(&occupants.ahead([column, row], axis, direction)[..], &expected[..]);
                    }
                }
            }
            // Overflow blocks are released.
            for (disc, &cell) in cells.iter().enumerate() {
                occupants.leave(Portable, disc as u32, cell);
            }
            prop_assert_eq!(occupants.free.len(), occupants.next.len() - usize::from(columns) * usize::from(rows));
        }
    }
}
