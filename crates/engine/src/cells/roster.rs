//! Rosters for a dilute gas: for each cell, the discs in it.
//!
//! Cells are larger here than two discs reach, so that they are left less often, and hold a few discs each. A list of
//! the 3 × 3 cells around each would be long, and every crossing would change six of them; a roster is changed by two.

use std::collections::BTreeMap;

use carom_detection::DISC_LANES;

use super::{
    line::INDEX_BITS,
    neighbourhood::{SLOTS, fold, image_code},
    vector::Kernel,
};

/// Places of a roster before it overflows.
const PLACES: usize = SLOTS;

/// Offsets of the cells around a cell, itself among them.
pub(super) const AROUND: [[i32; 2]; 9] =
    [[-1, -1], [0, -1], [1, -1], [-1, 0], [0, 0], [1, 0], [-1, 1], [0, 1], [1, 1]];

/// The discs of each cell of a grid of at least three cells a side.
#[derive(Debug, Clone, Default)]
pub(super) struct Rosters {
    columns: u32,
    rows: u32,
    places: Vec<[u32; PLACES]>,
    /// How many places are taken.
    counts: Vec<u8>,
    /// Who found no place.
    overflow: BTreeMap<u32, Vec<u32>>,
    /// Those around the disc that asks: scratch space.
    gathered: Gathered,
    /// The same where a cell around it has overflowed.
    many: Vec<u32>,
}

/// Room for nine full cells, and an eight more.
#[derive(Debug, Clone)]
struct Gathered([u32; AROUND.len() * PLACES + DISC_LANES]);

impl Default for Gathered {
    fn default() -> Self {
        Self([0; AROUND.len() * PLACES + DISC_LANES])
    }
}

impl Rosters {
    pub fn lay_out(&mut self, [columns, rows]: [u32; 2]) {
        let cells = (columns * rows) as usize;
        (self.columns, self.rows) = (columns, rows);
        self.places.clear();
        self.places.resize(cells, [0; PLACES]);
        self.counts.clear();
        self.counts.resize(cells, 0);
        self.overflow.clear();
    }

    pub fn heap_bytes(&self) -> usize {
        let overflow: usize = self.overflow.values().map(|list| list.capacity() * size_of::<u32>()).sum();
        self.places.capacity() * size_of::<[u32; PLACES]>() + self.counts.capacity() + overflow
    }

    fn index(&self, cell: [u16; 2]) -> u32 {
        u32::from(cell[1]) * self.columns + u32::from(cell[0])
    }

    /// Puts a disc on the roster of a cell.
    #[inline]
    pub fn enter(&mut self, disc: u32, cell: [u16; 2]) {
        let cell = self.index(cell);
        let count = &mut self.counts[cell as usize];
        if (*count as usize) < PLACES {
            self.places[cell as usize][*count as usize] = disc;
            *count += 1;
        } else {
            self.overflow.entry(cell).or_default().push(disc);
        }
    }

    /// Takes a disc off the roster of a cell.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled anew for each set of instructions")]
    pub fn leave<K: Kernel>(&mut self, disc: u32, cell: [u16; 2]) {
        let cell = self.index(cell);
        let count = &mut self.counts[cell as usize];
        let places = &mut self.places[cell as usize];
        let last = (*count as usize).wrapping_sub(1) & (PLACES - 1);
        let place = K::find(places, disc).trailing_zeros() as usize;
        if (place <= last) & self.overflow.is_empty() {
            *count -= 1;
            places[place] = places[last];
        } else {
            self.leave_overflowed(disc, cell, place);
        }
    }

    #[cold]
    #[inline(never)]
    fn leave_overflowed(&mut self, disc: u32, cell: u32, place: usize) {
        let count = self.counts[cell as usize] as usize;
        let in_roster = place < count;
        let Some(others) = self.overflow.get_mut(&cell) else {
            if in_roster {
                self.places[cell as usize][place] = self.places[cell as usize][count - 1];
                self.counts[cell as usize] -= 1;
            }
            return;
        };
        if !in_roster {
            others.retain(|&other| other != disc);
        } else if let Some(other) = others.pop() {
            self.places[cell as usize][place] = other;
        }
        if others.is_empty() {
            self.overflow.remove(&cell);
        }
    }

    /// Gathers the discs of the cells at some offsets from one, as slots with the image in which they are seen from it,
    /// filled up to whole eights with `dummy`; and tells whether some are seen through the border of the box.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "a call costs as much as the work")]
    pub fn gather(
        &mut self,
        [column, row]: [u16; 2],
        offsets: &[[i32; 2]],
        dummy: u32,
    ) -> (&[[u32; DISC_LANES]], bool) {
        let (columns, rows) = (self.columns as i32, self.rows as i32);
        let (column, row) = (i32::from(column), i32::from(row));
        let at_border = (column == 0) | (row == 0) | (column + 1 == columns) | (row + 1 == rows);
        let gathered = &mut self.gathered.0;
        let mut count = 0;
        for [x, y] in offsets {
            let (mut there, mut image) = (((row + y) * columns + column + x) as u32, 0);
            if at_border {
                (there, image) = folded([column + x, row + y], [columns, rows]);
            }
            let here = self.counts[there as usize] as usize;
            let (eights, _) = self.places[there as usize].as_chunks::<DISC_LANES>();
            // Eight places are copied at a time, needed or not: a number of turns that changes from cell to cell is what
            // no processor can foresee.
            gathered[count..count + DISC_LANES].copy_from_slice(&eights[0].map(|disc| disc | image));
            if here > DISC_LANES {
                let from = count + DISC_LANES;
                gathered[from..from + DISC_LANES].copy_from_slice(&eights[1].map(|disc| disc | image));
            }
            count += here;
        }
        gathered[count..count + DISC_LANES].fill(dummy);
        if !self.overflow.is_empty() {
            return self.gather_many([column, row], offsets, count, dummy);
        }
        let (eights, _) = self.gathered.0.as_chunks::<DISC_LANES>();
        (&eights[..count.div_ceil(DISC_LANES)], at_border)
    }

    /// Adds those who found no place in their rosters.
    #[cold]
    #[inline(never)]
    fn gather_many(
        &mut self,
        [column, row]: [i32; 2],
        offsets: &[[i32; 2]],
        count: usize,
        dummy: u32,
    ) -> (&[[u32; DISC_LANES]], bool) {
        self.many.clear();
        self.many.extend(&self.gathered.0[..count]);
        for [x, y] in offsets {
            let (there, image) = folded([column + x, row + y], [self.columns as i32, self.rows as i32]);
            let others = self.overflow.get(&there).into_iter().flatten();
            self.many.extend(others.map(|disc| disc | image));
        }
        self.many.resize(self.many.len().next_multiple_of(DISC_LANES), dummy);
        let (eights, _) = self.many.as_chunks::<DISC_LANES>();
        (eights, true)
    }
}

/// A cell at most one outside the grid, brought back: its index, and the image of its discs as a slot has it.
fn folded([column, row]: [i32; 2], [columns, rows]: [i32; 2]) -> (u32, u32) {
    let (column, image_x) = fold(column, columns);
    let (row, image_y) = fold(row, rows);
    ((row * columns + column) as u32, (image_code(image_x) | image_code(image_y) << 2) << INDEX_BITS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::{line::INDEX_MASK, neighbourhood::image_of, vector::Portable};
    use proptest::prelude::*;

    proptest! {
        /// Any discs in any cells (all in one, too), moved about: who is gathered are those around.
        #[test]
        fn rosters_hold_exactly_the_discs_of_each_cell(
            columns in 3u16..6, rows in 3u16..6, crowd in any::<bool>(),
            starts in prop::collection::vec((0u16..6, 0u16..6), 1..80),
            moves in prop::collection::vec((0usize..80, 0u16..6, 0u16..6), 0..100),
        ) {
            let mut cells: Vec<[u16; 2]> =
                starts.iter().map(|&(x, y)| if crowd { [0, 0] } else { [x % columns, y % rows] }).collect();
            let mut rosters = Rosters::default();
            rosters.lay_out([u32::from(columns), u32::from(rows)]);
            for (disc, &cell) in cells.iter().enumerate() {
                rosters.enter(disc as u32, cell);
            }
            for (disc, x, y) in moves {
                let disc = disc % cells.len();
                rosters.leave::<Portable>(disc as u32, cells[disc]);
                cells[disc] = [x % columns, y % rows];
                rosters.enter(disc as u32, cells[disc]);
            }
            let dummy = cells.len() as u32;
            for row in 0..rows {
                for column in 0..columns {
                    let (eights, through_border) = rosters.gather([column, row], &AROUND, dummy);
                    let slots = eights.iter().flatten().filter(|&&slot| slot != dummy);
                    let mut seen: Vec<_> = slots.map(|&slot| (slot & INDEX_MASK, image_of(slot))).collect();
                    seen.sort_unstable();
                    let mut expected = Vec::new();
                    for (disc, cell) in cells.iter().enumerate() {
                        for [dx, dy] in AROUND {
                            let (x, image_x) = fold(i32::from(column) + dx, i32::from(columns));
                            let (y, image_y) = fold(i32::from(row) + dy, i32::from(rows));
                            if [x, y] == [i32::from(cell[0]), i32::from(cell[1])] {
                                expected.push((disc as u32, [image_x, image_y]));
                            }
                        }
                    }
                    expected.sort_unstable();
                    prop_assert!(through_border || seen.iter().all(|&(_, image)| image == [0, 0]));
                    prop_assert_eq!(seen, expected);
                }
            }
        }
    }
}
