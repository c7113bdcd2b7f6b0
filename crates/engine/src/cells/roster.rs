//! Rosters for a dilute gas: for each cell, the discs in it with their flights.
//!
//! Cells are larger here than two discs reach, so that they are left less often, and hold a few discs each. A list of
//! the 3 × 3 cells around each would be long, and every crossing would change six of them; a roster is changed by two. Many
//! discs are looked at for each contact, so a roster keeps their flights, too, number by number, as vector registers read
//! them.

use carom_detection::DISC_LANES;

use super::{
    line::{INDEX_BITS, INDEX_MASK},
    neighbourhood::{fold, image_code},
};

/// Offsets of the cells around a cell, itself among them.
const OFFSETS: [[i32; 2]; 9] = [[-1, -1], [0, -1], [1, -1], [-1, 0], [0, 0], [1, 0], [-1, 1], [0, 1], [1, 1]];

/// All cells around a cell, by their number there.
pub(super) const AROUND: [usize; 9] = [0, 1, 2, 3, 4, 5, 6, 7, 8];

/// The three cells that come into view along an axis, downwards and upwards, by their number around the cell that was entered.
pub(super) const AHEAD: [[[usize; 3]; 2]; 2] = [[[0, 3, 6], [2, 5, 8]], [[0, 1, 2], [6, 7, 8]]];

/// No block.
const NONE: u32 = u32::MAX;

/// Places at the start of the epoch and velocities, x₀, y₀, vx, vy of eight discs after each other. Where nobody is, x₀ is
/// NaN, and with it all that decides whether somebody comes near: every comparison with it is false.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
struct Flights([[f64; DISC_LANES]; 4]);

/// Who stands in the eight places of a block; those that are free hold the dummy.
#[derive(Debug, Clone, Copy)]
struct Members {
    discs: [u32; DISC_LANES],
    /// How many places are taken.
    count: u32,
}

/// The discs of each cell of a grid of at least three cells a side.
#[derive(Debug, Clone, Default)]
pub(super) struct Rosters {
    columns: u32,
    rows: u32,
    /// The cells around each cell, as slots: with the image in which they are seen from there.
    around: Vec<[u32; OFFSETS.len()]>,
    /// Blocks of eight discs: one for each cell, then those that some cells need besides. What is read of each for each
    /// prediction lies apart from what is not.
    flights: Vec<Flights>,
    members: Vec<Members>,
    /// The block with more discs of the same cell.
    next: Vec<u32>,
    /// Blocks not in use.
    free: Vec<u32>,
    /// In which block each disc stands, times eight, and where in it.
    places: Vec<u32>,
    dummy: u32,
}

impl Rosters {
    /// Empty rosters for so many discs; the next index is that of the dummy.
    pub fn lay_out(&mut self, [columns, rows]: [u32; 2], discs: u32) {
        if [self.columns, self.rows] != [columns, rows] {
            (self.columns, self.rows) = (columns, rows);
            let at = |cell: u32, [x, y]: [i32; 2]| {
                let (column, image_x) = fold((cell % columns) as i32 + x, columns as i32);
                let (row, image_y) = fold((cell / columns) as i32 + y, rows as i32);
                let code = image_code(image_x) | image_code(image_y) << 2;
                (row as u32 * columns + column as u32) | code << INDEX_BITS
            };
            self.around = (0..columns * rows).map(|cell| OFFSETS.map(|offset| at(cell, offset))).collect();
        }
        self.dummy = discs;
        let cells = (columns * rows) as usize;
        self.flights.clear();
        self.flights.resize(cells, Flights::NONE);
        self.members.clear();
        self.members.resize(cells, Members::none(discs));
        self.next.clear();
        self.next.resize(cells, NONE);
        self.free.clear();
        self.places.clear();
        self.places.resize(discs as usize, 0);
    }

    pub fn heap_bytes(&self) -> usize {
        self.flights.capacity() * size_of::<Flights>()
            + self.members.capacity() * size_of::<Members>()
            + self.around.capacity() * size_of::<[u32; OFFSETS.len()]>()
            + (self.next.capacity() + self.free.capacity() + self.places.capacity()) * size_of::<u32>()
    }

    /// The cells around a cell, by their number there, as slots: with the image in which they are seen from it.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "a call costs as much as the work")]
    pub fn around(&self, [column, row]: [u16; 2]) -> &[u32; OFFSETS.len()] {
        &self.around[(u32::from(row) * self.columns + u32::from(column)) as usize]
    }

    /// The blocks of a cell around another.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "a call costs as much as the work")]
    pub fn blocks(&self, slot: u32) -> impl Iterator<Item = u32> {
        let next = |block: &u32| Some(self.next[*block as usize]).filter(|&next| next != NONE);
        std::iter::successors(Some(slot & INDEX_MASK), next)
    }

    /// The flights of a block's discs.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "a call costs as much as the work")]
    pub fn flights(&self, block: u32) -> &[[f64; DISC_LANES]; 4] {
        &self.flights[block as usize].0
    }

    /// The discs of a block; a place that is free holds the dummy.
    pub fn discs(&self, block: u32) -> &[u32; DISC_LANES] {
        &self.members[block as usize].discs
    }

    /// Puts a disc on the roster of a cell.
    #[inline]
    pub fn enter(&mut self, disc: u32, [column, row]: [u16; 2], flight: [f64; 4]) {
        let mut block = u32::from(row) * self.columns + u32::from(column);
        while self.members[block as usize].count as usize == DISC_LANES {
            block = self.block_after(block);
        }
        let members = &mut self.members[block as usize];
        let lane = members.count as usize & (DISC_LANES - 1);
        members.count += 1;
        members.discs[lane] = disc;
        self.flights[block as usize].set(lane, flight);
        self.places[disc as usize] = block * DISC_LANES as u32 + lane as u32;
    }

    /// The block after one that is full.
    #[cold]
    fn block_after(&mut self, block: u32) -> u32 {
        if self.next[block as usize] == NONE {
            self.next[block as usize] = self.free.pop().unwrap_or_else(|| {
                if self.flights.len() == self.flights.capacity() {
                    // A few more, not twice as many.
                    let more = self.flights.len() / 16 + 1;
                    self.flights.reserve_exact(more);
                    self.members.reserve_exact(more);
                    self.next.reserve_exact(more);
                }
                self.flights.push(Flights::NONE);
                self.members.push(Members::none(self.dummy));
                self.next.push(NONE);
                self.next.len() as u32 - 1
            });
        }
        self.next[block as usize]
    }

    /// Takes a disc off the roster of a cell.
    #[inline]
    pub fn leave(&mut self, disc: u32, cell: [u16; 2]) {
        let (block, lane) = self.place(disc);
        let members = &mut self.members[block];
        let last = (members.count as usize).wrapping_sub(1) & (DISC_LANES - 1);
        members.count = last as u32;
        let moved = members.discs[last];
        members.discs[lane] = moved;
        members.discs[last] = self.dummy;
        let flights = &mut self.flights[block];
        flights.set(lane, flights.0.each_ref().map(|numbers| numbers[last]));
        flights.0[0][last] = f64::NAN;
        self.places[moved as usize] = (block * DISC_LANES + lane) as u32;
        if last == 0 && block as u32 >= self.columns * self.rows {
            self.release(block as u32, cell);
        }
    }

    /// Takes an empty block out of the roster of a cell.
    #[cold]
    fn release(&mut self, block: u32, [column, row]: [u16; 2]) {
        let first = u32::from(row) * self.columns + u32::from(column);
        let before = self.blocks(first).find(|&before| self.next[before as usize] == block);
        if let Some(before) = before {
            self.next[before as usize] = std::mem::replace(&mut self.next[block as usize], NONE);
            self.free.push(block);
        }
    }

    /// Takes over the flight of a disc, if it stands on a roster.
    #[inline]
    pub fn set_flight(&mut self, disc: u32, flight: [f64; 4]) {
        if (disc as usize) < self.places.len() {
            let (block, lane) = self.place(disc);
            self.flights[block].set(lane, flight);
        }
    }

    #[inline]
    fn place(&self, disc: u32) -> (usize, usize) {
        let place = self.places[disc as usize] as usize;
        (place / DISC_LANES, place % DISC_LANES)
    }
}

impl Flights {
    const NONE: Self = Self([[f64::NAN; DISC_LANES]; 4]);

    #[inline]
    fn set(&mut self, lane: usize, flight: [f64; 4]) {
        for (numbers, number) in self.0.iter_mut().zip(flight) {
            numbers[lane] = number;
        }
    }
}

impl Members {
    fn none(dummy: u32) -> Self {
        Self { discs: [dummy; DISC_LANES], count: 0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::neighbourhood::image_of;
    use proptest::prelude::*;

    proptest! {
        /// Any discs in any cells (all in one, too), moved about: who is found around a cell, and how it flies, is who is
        /// there.
        #[test]
        fn rosters_hold_exactly_the_discs_of_each_cell(
            columns in 3u16..6, rows in 3u16..6, crowd in any::<bool>(),
            starts in prop::collection::vec((0u16..6, 0u16..6), 1..80),
            moves in prop::collection::vec((0usize..80, 0u16..6, 0u16..6, any::<bool>()), 0..200),
        ) {
            let mut cells: Vec<[u16; 2]> =
                starts.iter().map(|&(x, y)| if crowd { [0, 0] } else { [x % columns, y % rows] }).collect();
            let mut flights: Vec<[f64; 4]> = (0..cells.len()).map(|disc| [disc as f64; 4]).collect();
            let mut rosters = Rosters::default();
            let dummy = cells.len() as u32;
            rosters.lay_out([u32::from(columns), u32::from(rows)], dummy);
            for (disc, &cell) in cells.iter().enumerate() {
                rosters.enter(disc as u32, cell, flights[disc]);
            }
            for (disc, x, y, turns) in moves {
                let disc = disc % cells.len();
                if turns {
                    flights[disc] = flights[disc].map(|number| number + 100.0);
                    rosters.set_flight(disc as u32, flights[disc]);
                }
                rosters.leave(disc as u32, cells[disc]);
                cells[disc] = [x % columns, y % rows];
                rosters.enter(disc as u32, cells[disc], flights[disc]);
            }
            for row in 0..rows {
                for column in 0..columns {
                    let mut seen = Vec::new();
                    for &slot in rosters.around([column, row]) {
                        let image = image_of(slot);
                        for block in rosters.blocks(slot) {
                            for (lane, &disc) in rosters.discs(block).iter().enumerate() {
                                let flight = rosters.flights(block).map(|numbers| numbers[lane]);
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
                        for [dx, dy] in OFFSETS {
                            let (x, image_x) = fold(i32::from(column) + dx, i32::from(columns));
                            let (y, image_y) = fold(i32::from(row) + dy, i32::from(rows));
                            if [x, y] == [i32::from(cell[0]), i32::from(cell[1])] {
                                expected.push((disc as u32, [image_x, image_y]));
                            }
                        }
                    }
                    expected.sort_unstable();
                    prop_assert_eq!(seen, expected);
                }
            }
            // What a roster needs besides is given back.
            for (disc, &cell) in cells.iter().enumerate() {
                rosters.leave(disc as u32, cell);
            }
            prop_assert_eq!(rosters.free.len(), rosters.next.len() - usize::from(columns) * usize::from(rows));
        }
    }
}
