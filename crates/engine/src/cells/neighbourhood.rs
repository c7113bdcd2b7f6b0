//! Neighbourhood lists: for each cell, every disc of the 3 × 3 cells around it, with the image it is seen in.

use std::collections::BTreeMap;

use carom_detection::DISC_LANES;

use super::{
    line::{INDEX_BITS, INDEX_MASK},
    vector::{self, Kernel},
};

/// Slots of a list before it overflows: one cache line.
pub(super) const SLOTS: usize = 16;

/// Set in a cell's mark if its list has overflowed.
const OVERFLOWED: u8 = 0x80;
/// Set in a cell's mark if a covering body is listed there.
const COVERED: u8 = 0x40;
/// Set in a cell's mark if some discs around it are seen through the border of the box.
const AT_BORDER: u8 = 0x20;
const COUNT: u8 = 0x1f;

/// A list in one cache line. Unused slots hold the dummy.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
struct List([u32; SLOTS]);

/// What stands around a cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct Around<'a> {
    pub cell: u32,
    /// Slots not in use hold the dummy.
    pub slots: &'a [u32; SLOTS],
    /// Whether some discs are seen through the border of the box.
    pub at_border: bool,
    mark: u8,
}

impl Around<'_> {
    /// How many slots are in use.
    #[inline]
    pub fn count(&self) -> usize {
        (self.mark & COUNT) as usize
    }

    /// The slots in two halves; the second is worth a look only if more than the first are in use.
    #[inline]
    pub fn halves(&self) -> [&[u32; DISC_LANES]; 2] {
        let (halves, _) = self.slots.as_chunks::<DISC_LANES>();
        [&halves[0], &halves[1]]
    }

    /// The slots that are in use.
    pub fn in_use(&self) -> &[u32] {
        &self.slots[..self.count()]
    }

    /// Whether some discs have found no slot.
    pub fn has_overflowed(&self) -> bool {
        self.mark & OVERFLOWED != 0
    }

    /// Whether a covering body is listed in the cell.
    pub fn is_covered(&self) -> bool {
        self.mark & COVERED != 0
    }
}

/// The lists of all cells of a grid of at least three cells a side.
#[derive(Debug, Clone, Default)]
pub(super) struct Neighbourhoods {
    columns: u32,
    rows: u32,
    lists: Vec<List>,
    /// How many slots are used, and the flags.
    marks: Vec<u8>,
    /// What found no slot: cells with more discs around them than a list holds.
    overflow: BTreeMap<u32, Vec<u32>>,
    dummy: u32,
}

impl Neighbourhoods {
    /// Empty lists; `dummy` is the index that fills unused slots.
    pub fn lay_out(&mut self, columns: u32, rows: u32, dummy: u32) {
        let cells = (columns * rows) as usize;
        (self.columns, self.rows, self.dummy) = (columns, rows, dummy);
        self.lists.clear();
        self.lists.resize(cells, List([dummy; SLOTS]));
        self.marks.clear();
        for cell in 0..cells as u32 {
            let (column, row) = (cell % columns, cell / columns);
            let inside = column > 0 && row > 0 && column + 1 < columns && row + 1 < rows;
            self.marks.push(if inside { 0 } else { AT_BORDER });
        }
        self.overflow.clear();
    }

    pub fn heap_bytes(&self) -> usize {
        let overflow: usize = self.overflow.values().map(|list| list.capacity() * size_of::<u32>()).sum();
        self.lists.capacity() * size_of::<List>() + self.marks.capacity() + overflow
    }

    pub fn index(&self, cell: [u16; 2]) -> u32 {
        u32::from(cell[1]) * self.columns + u32::from(cell[0])
    }

    /// What stands around a cell.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "a call costs as much as the work")]
    pub fn list(&self, cell: [u16; 2]) -> Around<'_> {
        self.list_of(self.index(cell))
    }

    /// What stands around the cell of an index.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "a call costs as much as the work")]
    pub fn list_of(&self, cell: u32) -> Around<'_> {
        let mark = self.marks[cell as usize];
        Around { cell, slots: &self.lists[cell as usize].0, at_border: mark & AT_BORDER != 0, mark }
    }

    /// The slots of a cell's list, if there is such a cell.
    pub fn slots(&self, cell: [u16; 2]) -> Option<&[u32; SLOTS]> {
        self.lists.get(self.index(cell) as usize).map(|list| &list.0)
    }

    /// Asks for what stands around a cell, if there is such a cell.
    pub fn expect(&self, cell: [u16; 2]) {
        let cell = self.index(cell) as usize;
        vector::expect(&self.lists, cell);
        vector::expect(&self.marks, cell);
    }

    /// What found no slot in the list of this cell.
    pub fn overflow(&self, cell: u32) -> &[u32] {
        if self.marks[cell as usize] & OVERFLOWED == 0 {
            return &[];
        }
        self.overflow.get(&cell).map_or(&[], Vec::as_slice)
    }

    pub fn set_covered(&mut self, cell: u32, covered: bool) {
        let mark = &mut self.marks[cell as usize];
        *mark = if covered { *mark | COVERED } else { *mark & !COVERED };
    }

    /// Every disc seen from a cell, with its image.
    pub fn seen_from(&self, cell: u32) -> impl Iterator<Item = (u32, [i32; 2])> {
        let count = (self.marks[cell as usize] & COUNT) as usize;
        let seen = self.lists[cell as usize].0[..count].iter().chain(self.overflow(cell));
        seen.map(|&slot| (slot & INDEX_MASK, image_of(slot)))
    }

    /// Lists a disc in the nine cells around its own.
    pub fn enter(&mut self, disc: u32, cell: [u16; 2]) {
        for dy in -1..=1 {
            for dx in -1..=1 {
                self.add(disc, cell, [dx, dy]);
            }
        }
    }

    /// Takes a disc off the nine cells around its own.
    pub fn leave(&mut self, disc: u32, cell: [u16; 2]) {
        for dy in -1..=1 {
            for dx in -1..=1 {
                self.remove(disc, cell, [dx, dy]);
            }
        }
    }

    /// Moves a disc one cell along an axis without crossing the border of the box: three lists lose it behind, three
    /// gain it ahead.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "a call costs as much as the work")]
    pub fn step<K: Kernel>(&mut self, disc: u32, from: [u16; 2], to: [u16; 2], axis: usize, direction: i32) {
        let (start, end) = (self.index(from), self.index(to));
        if (self.marks[start as usize] | self.marks[end as usize]) & AT_BORDER != 0 {
            return self.step_along_border(disc, from, to, axis, direction);
        }
        let strides = [1, self.columns];
        let (ahead, sideways) = (strides[axis], strides[1 - axis]);
        let ahead = if direction > 0 { ahead } else { ahead.wrapping_neg() };
        let (behind, ahead) = (start.wrapping_sub(ahead), end.wrapping_add(ahead));
        self.drop(behind - sideways, disc, K::find);
        self.drop(behind, disc, K::find);
        self.drop(behind + sideways, disc, K::find);
        self.put(ahead - sideways, disc);
        self.put(ahead, disc);
        self.put(ahead + sideways, disc);
    }

    #[inline(never)]
    fn step_along_border(&mut self, disc: u32, from: [u16; 2], to: [u16; 2], axis: usize, direction: i32) {
        for sideways in -1..=1 {
            let mut behind = [sideways; 2];
            behind[axis] = -direction;
            self.remove(disc, from, behind);
            let mut ahead = [sideways; 2];
            ahead[axis] = direction;
            self.add(disc, to, ahead);
        }
    }

    /// Lists a disc of `cell` in the cell at an offset from it.
    fn add(&mut self, disc: u32, cell: [u16; 2], offset: [i32; 2]) {
        let (list, image) = self.neighbour(cell, offset);
        // Seen from over there, the disc stands the other way round the border.
        self.put(list, disc | (image_code(-image[0]) | image_code(-image[1]) << 2) << INDEX_BITS);
    }

    fn remove(&mut self, disc: u32, cell: [u16; 2], offset: [i32; 2]) {
        let (list, _) = self.neighbour(cell, offset);
        // At the border a slot says in which image the disc is seen.
        self.drop(list, disc, |slots, disc| {
            slots.iter().position(|&slot| slot & INDEX_MASK == disc).map_or(0, |place| 1 << place)
        });
    }

    #[inline(always)]
    #[expect(clippy::inline_always, reason = "a call costs as much as the work")]
    fn put(&mut self, list: u32, slot: u32) {
        let mark = &mut self.marks[list as usize];
        let count = (*mark & COUNT) as usize;
        if count < SLOTS {
            self.lists[list as usize].0[count] = slot;
            *mark += 1;
        } else {
            self.put_aside(list, slot);
        }
    }

    #[cold]
    fn put_aside(&mut self, list: u32, slot: u32) {
        self.marks[list as usize] |= OVERFLOWED;
        self.overflow.entry(list).or_default().push(slot);
    }

    /// Takes a disc off a list, where `find` tells in which slots it stands.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "a call costs as much as the work")]
    fn drop(&mut self, list: u32, disc: u32, find: impl Fn(&[u32; SLOTS], u32) -> u32) {
        let slots = &mut self.lists[list as usize].0;
        let mark = &mut self.marks[list as usize];
        let last = ((*mark & COUNT) as usize).wrapping_sub(1) & (SLOTS - 1);
        let place = find(slots, disc).trailing_zeros() as usize;
        if place <= last && *mark & OVERFLOWED == 0 {
            *mark -= 1;
            slots[place] = slots[last];
            slots[last] = self.dummy;
        } else {
            self.remove_overflowed(list, disc, place);
        }
    }

    /// Takes a disc off a list that has overflowed, and fills its slot from the overflow.
    #[cold]
    fn remove_overflowed(&mut self, list: u32, disc: u32, place: usize) {
        let Some(overflow) = self.overflow.get_mut(&list) else { return };
        if let Some(place) = overflow.iter().position(|&slot| slot & INDEX_MASK == disc) {
            overflow.swap_remove(place);
        } else if place < SLOTS
            && let Some(slot) = overflow.pop()
        {
            self.lists[list as usize].0[place] = slot;
        }
        if overflow.is_empty() {
            self.overflow.remove(&list);
            self.marks[list as usize] &= !OVERFLOWED;
        }
    }

    /// A cell at an offset of at most one from another, and how many boxes away it lies.
    fn neighbour(&self, cell: [u16; 2], offset: [i32; 2]) -> (u32, [i32; 2]) {
        let (columns, rows) = (self.columns as i32, self.rows as i32);
        let (column, image_x) = fold(i32::from(cell[0]) + offset[0], columns);
        let (row, image_y) = fold(i32::from(cell[1]) + offset[1], rows);
        ((row * columns + column) as u32, [image_x, image_y])
    }
}

/// A cell index at most one outside its range, brought back, and how many boxes it was out.
pub(super) fn fold(index: i32, count: i32) -> (i32, i32) {
    let image = i32::from(index >= count) - i32::from(index < 0);
    (index - image * count, image)
}

/// 0, 1, 2 for no image, one box up, one box down.
pub(super) fn image_code(image: i32) -> u32 {
    (image & 3) as u32 & if image < 0 { 2 } else { 1 }
}

/// The image in which a slot's disc is seen, in boxes.
pub(super) fn image_of(slot: u32) -> [i32; 2] {
    let decode = |code: u32| (code & 1) as i32 - (code >> 1 & 1) as i32;
    [decode(slot >> INDEX_BITS), decode(slot >> (INDEX_BITS + 2))]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::vector::Portable;
    use proptest::prelude::*;

    proptest! {
        /// Any discs in any cells (all in one, too), moved about: the lists are what they should be.
        #[test]
        fn lists_hold_exactly_the_discs_around(
            columns in 3u16..6, rows in 3u16..6, crowd in any::<bool>(),
            starts in prop::collection::vec((0u16..6, 0u16..6), 1..60),
            moves in prop::collection::vec((0usize..60, 0usize..2, any::<bool>()), 0..200),
        ) {
            let counts = [columns, rows];
            let mut cells: Vec<[u16; 2]> = starts
                .iter()
                .map(|&(x, y)| if crowd { [0, 0] } else { [x % columns, y % rows] })
                .collect();
            let mut lists = Neighbourhoods::default();
            lists.lay_out(u32::from(columns), u32::from(rows), cells.len() as u32);
            for (disc, &cell) in cells.iter().enumerate() {
                lists.enter(disc as u32, cell);
            }
            for (disc, axis, up) in moves {
                let disc = disc % cells.len();
                let direction = if up { 1 } else { -1 };
                let from = cells[disc];
                let (index, image) = fold(i32::from(from[axis]) + direction, i32::from(counts[axis]));
                let mut to = from;
                to[axis] = index as u16;
                if image == 0 {
                    lists.step::<Portable>(disc as u32, from, to, axis, direction);
                } else {
                    lists.leave(disc as u32, from);
                    lists.enter(disc as u32, to);
                }
                cells[disc] = to;
            }
            for row in 0..rows {
                for column in 0..columns {
                    let mut listed: Vec<_> = lists.seen_from(lists.index([column, row])).collect();
                    listed.sort_unstable();
                    let mut expected = Vec::new();
                    for (disc, cell) in cells.iter().enumerate() {
                        for (dx, dy) in (0..9).map(|k| (k % 3 - 1, k / 3 - 1)) {
                            let (x, image_x) = fold(i32::from(column) + dx, i32::from(columns));
                            let (y, image_y) = fold(i32::from(row) + dy, i32::from(rows));
                            if [x, y] == [i32::from(cell[0]), i32::from(cell[1])] {
                                expected.push((disc as u32, [image_x, image_y]));
                            }
                        }
                    }
                    expected.sort_unstable();
                    prop_assert_eq!(listed, expected);
                }
            }
        }
    }
}
