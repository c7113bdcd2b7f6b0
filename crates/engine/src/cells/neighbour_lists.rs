//! Neighbour lists of cells: all discs in the 3 × 3 cells around each cell, with the image in which
//! each is seen.

use carom_detection::DISC_LANES;

use super::{
    cell_block::{AT_BORDER, COUNT, COVERED, CellBlock, LINK, LONG, Slots8},
    frame::{CellFrame, WholeBox},
    simd::{self, Kernel, Portable},
    slot::{INDEX_BITS, INDEX_MASK, image_code, image_of, wrap_cell},
};

/// If at least one list in this many would hold more than eight discs, all lists get sixteen slots
/// of their own. Smaller: too many lists are long, and reading a long one takes twice the time.
/// Larger: more memory, and thereby more time in large systems.
const LISTS_FOR_EACH_LONG_ONE: usize = 50;

/// The neighbour lists of all cells of a frame, in a grid of at least three cells a side.
#[derive(Debug, Clone, Default)]
pub(super) struct NeighbourLists<F = WholeBox> {
    frame: F,
    /// Columns and rows of the box.
    columns: u32,
    rows: u32,
    /// Lists in a row of the frame.
    stride: u32,
    /// The own slots of all lists, eight or sixteen each.
    lists: Vec<Slots8>,
    /// Index of the first list, for alignment.
    start: usize,
    is_wide: bool,
    /// For each cell the number of own slots in use, and the flags.
    marks: Vec<u8>,
    /// The further slots of long lists, and the indices of those not in use.
    more: Vec<Slots8>,
    unused: Vec<u32>,
    dummy: u32,
}

impl<F: CellFrame> NeighbourLists<F> {
    /// Empty lists of a frame.
    pub fn new(frame: F) -> Self {
        Self {
            frame,
            ..Self::default()
        }
    }

    pub fn frame(&self) -> &F {
        &self.frame
    }

    /// Sets the frame, before discs are listed.
    pub fn set_frame(&mut self, frame: F) {
        self.frame = frame;
    }

    /// Lists discs anew in their cells; `dummy` is the index in unused slots.
    pub fn list_all(
        &mut self,
        [columns, rows]: [u32; 2],
        dummy: u32,
        discs: impl Iterator<Item = (u32, [u16; 2])> + Clone,
    ) {
        self.lay_out(columns, rows, dummy);
        discs
            .clone()
            .for_each(|(disc, cell)| self.enter(disc, cell));
        let should_be_wide = self.count_long() * LISTS_FOR_EACH_LONG_ONE > self.marks.len();
        if should_be_wide != self.is_wide {
            *self = Self {
                is_wide: should_be_wide,
                ..Self::new(self.frame.clone())
            };
            self.lay_out(columns, rows, dummy);
            discs.for_each(|(disc, cell)| self.enter(disc, cell));
        }
    }

    /// Empties all lists; their width does not change.
    fn lay_out(&mut self, columns: u32, rows: u32, dummy: u32) {
        let size = self.frame.size([columns, rows]);
        let cells = (size[0] * size[1]) as usize;
        (self.columns, self.rows, self.dummy) = (columns, rows, dummy);
        self.stride = size[0];
        self.lists.clear();
        let eights = cells << u32::from(self.is_wide);
        self.lists.reserve_exact(eights + 1);
        // A list of sixteen slots then lies in one cache line; the vector is aligned to half a line
        // only.
        self.start = self.lists.as_ptr().align_offset(64).min(1);
        self.lists
            .resize(self.start + eights, Slots8([dummy; DISC_LANES]));
        self.more.clear();
        self.unused.clear();
        self.marks.clear();
        let is_inside = |cell: u32, count: u32| cell > 0 && cell + 1 < count;
        for row in 0..size[1] {
            let inside = is_inside(self.frame.cell_along([columns, rows], 1, row), rows);
            self.marks.extend((0..size[0]).map(|column| {
                let column = self.frame.cell_along([columns, rows], 0, column);
                if inside && is_inside(column, columns) {
                    0
                } else {
                    AT_BORDER
                }
            }));
        }
    }

    /// Number of lists with more than eight discs.
    fn count_long(&self) -> usize {
        let is_long = |&&mark: &&u8| mark & LONG != 0 || (mark & COUNT) as usize > DISC_LANES;
        self.marks.iter().filter(is_long).count()
    }

    pub fn heap_bytes(&self) -> usize {
        (self.lists.capacity() + self.more.capacity()) * size_of::<Slots8>()
            + self.unused.capacity() * size_of::<u32>()
            + self.marks.capacity()
    }

    #[inline(always)]
    pub fn index(&self, cell: [u16; 2]) -> u32 {
        self.frame.index(cell, self.stride)
    }

    /// Index of a cell's first own slots.
    #[inline(always)]
    fn own(&self, cell: u32) -> usize {
        self.start + ((cell as usize) << u32::from(self.is_wide))
    }

    /// The neighbour list of a cell, from its column and row.
    #[inline(always)]
    pub fn list(&self, cell: [u16; 2]) -> CellBlock<'_> {
        self.list_of(self.index(cell))
    }

    /// The neighbour list of a cell, from its index.
    #[inline(always)]
    pub fn list_of(&self, cell: u32) -> CellBlock<'_> {
        let mark = self.marks[cell as usize];
        let first = self.own(cell);
        let has_second = self.is_wide & ((mark & COUNT) as usize > DISC_LANES);
        CellBlock {
            cell,
            at_border: mark & AT_BORDER != 0,
            mark,
            first: &self.lists[first],
            second: has_second.then(|| &self.lists[first + 1]),
            more: &self.more,
            dummy: self.dummy,
        }
    }

    /// The slots around a cell, if no more than eight are in use; whether some are seen through the
    /// border of the box; and whether a multi-cell body is listed in the cell.
    #[inline(always)]
    pub fn only_eight(&self, cell: u32) -> Option<(&[u32; DISC_LANES], bool, bool)> {
        let mark = self.marks[cell as usize];
        // At most eight in use implies that `LONG` is not set.
        let only_eight = mark & !(AT_BORDER | COVERED) <= DISC_LANES as u8;
        only_eight.then(|| {
            (
                &self.lists[self.own(cell)].0,
                mark & AT_BORDER != 0,
                mark & COVERED != 0,
            )
        })
    }

    /// The first eight slots of a cell's list, if there is such a cell.
    pub fn first(&self, cell: [u16; 2]) -> Option<&[u32; DISC_LANES]> {
        self.lists
            .get(self.own(self.index(cell)))
            .map(|list| &list.0)
    }

    /// Prefetches a cell's list, if there is such a cell.
    pub fn prefetch(&self, cell: [u16; 2]) {
        let cell = self.index(cell);
        simd::prefetch(&self.lists, self.own(cell));
        simd::prefetch(&self.marks, cell as usize);
    }

    pub fn set_covered(&mut self, cell: u32, covered: bool) {
        let mark = &mut self.marks[cell as usize];
        *mark = if covered {
            *mark | COVERED
        } else {
            *mark & !COVERED
        };
    }

    /// Every disc in a cell's list, with its image.
    pub fn seen_from(&self, cell: u32) -> impl Iterator<Item = (u32, [i32; 2])> {
        self.list_of(cell)
            .slots()
            .map(|slot| (slot & INDEX_MASK, image_of(slot)))
    }

    /// Lists a disc in the nine cells around its own.
    pub fn enter(&mut self, disc: u32, cell: [u16; 2]) {
        let own = self.index(cell);
        if self.marks[own as usize] & AT_BORDER == 0 {
            let stride = self.stride;
            for row in [own - stride, own, own + stride] {
                for list in [row - 1, row, row + 1] {
                    self.push_slot_to(list, disc);
                }
            }
            return;
        }
        for dy in -1..=1 {
            for dx in -1..=1 {
                self.add(disc, cell, [dx, dy]);
            }
        }
    }

    /// Removes a disc from the nine cells around its own.
    pub fn leave(&mut self, disc: u32, cell: [u16; 2]) {
        for dy in -1..=1 {
            for dx in -1..=1 {
                self.remove(disc, cell, [dx, dy]);
            }
        }
    }

    /// Moves a disc one cell along an axis without crossing the border of the box: three lists
    /// behind lose it, three lists ahead gain it.
    #[inline(always)]
    pub fn step<K: Kernel>(
        &mut self,
        kernel: K,
        disc: u32,
        from: [u16; 2],
        to: [u16; 2],
        axis: usize,
        direction: i32,
    ) {
        let (start, end) = (self.index(from), self.index(to));
        if (self.marks[start as usize] | self.marks[end as usize]) & AT_BORDER != 0 {
            return self.step_along_border(disc, from, to, axis, direction);
        }
        let strides = [1, self.stride];
        let (ahead, sideways) = (strides[axis], strides[1 - axis]);
        let ahead = if direction > 0 {
            ahead
        } else {
            ahead.wrapping_neg()
        };
        let (behind, ahead) = (start.wrapping_sub(ahead), end.wrapping_add(ahead));
        if self.is_wide {
            self.move_inside::<_, 2>(kernel, disc, behind, ahead, sideways);
        } else {
            self.move_inside::<_, 1>(kernel, disc, behind, ahead, sideways);
        }
    }

    #[inline(always)]
    fn move_inside<K: Kernel, const EIGHTS: usize>(
        &mut self,
        kernel: K,
        disc: u32,
        behind: u32,
        ahead: u32,
        sideways: u32,
    ) {
        self.remove_slot::<_, EIGHTS>(kernel, behind - sideways, disc);
        self.remove_slot::<_, EIGHTS>(kernel, behind, disc);
        self.remove_slot::<_, EIGHTS>(kernel, behind + sideways, disc);
        self.push_slot::<EIGHTS>(ahead - sideways, disc);
        self.push_slot::<EIGHTS>(ahead, disc);
        self.push_slot::<EIGHTS>(ahead + sideways, disc);
    }

    #[inline(never)]
    fn step_along_border(
        &mut self,
        disc: u32,
        from: [u16; 2],
        to: [u16; 2],
        axis: usize,
        direction: i32,
    ) {
        let offset = |along: i32, sideways: i32| {
            if axis == 0 {
                [along, sideways]
            } else {
                [sideways, along]
            }
        };
        for sideways in -1..=1 {
            self.remove(disc, from, offset(-direction, sideways));
            self.add(disc, to, offset(direction, sideways));
        }
    }

    /// Lists a disc of `cell` in the cell at an offset from it.
    fn add(&mut self, disc: u32, cell: [u16; 2], offset: [i32; 2]) {
        let (list, slot) = self.seen_at(disc, cell, offset);
        self.push_slot_to(list, slot);
    }

    #[inline(always)]
    fn push_slot_to(&mut self, list: u32, slot: u32) {
        if self.is_wide {
            self.push_slot::<2>(list, slot);
        } else {
            self.push_slot::<1>(list, slot);
        }
    }

    fn remove(&mut self, disc: u32, cell: [u16; 2], offset: [i32; 2]) {
        let (list, slot) = self.seen_at(disc, cell, offset);
        if self.is_wide {
            self.remove_slot::<_, 2>(Portable, list, slot);
        } else {
            self.remove_slot::<_, 1>(Portable, list, slot);
        }
    }

    /// The list of the cell at an offset from `cell`, and the slot in it of a disc of `cell`.
    #[inline(always)]
    fn seen_at(&self, disc: u32, cell: [u16; 2], offset: [i32; 2]) -> (u32, u32) {
        let (list, image) = self.neighbour(cell, offset);
        // The image of the disc as seen from the other cell has the opposite sign.
        (
            list,
            disc | (image_code(-image[0]) | image_code(-image[1]) << 2) << INDEX_BITS,
        )
    }

    #[inline(always)]
    fn push_slot<const EIGHTS: usize>(&mut self, list: u32, slot: u32) {
        let own = self.start + list as usize * EIGHTS;
        let mark = &mut self.marks[list as usize];
        let count = (*mark & COUNT) as usize;
        if count < DISC_LANES * EIGHTS {
            self.lists[own + count / DISC_LANES].0[count % DISC_LANES] = slot;
            *mark += 1;
        } else {
            self.push_slot_to_long(list, slot);
        }
    }

    /// Removes a slot from a list.
    #[inline(always)]
    fn remove_slot<K: Kernel, const EIGHTS: usize>(&mut self, kernel: K, list: u32, slot: u32) {
        let own = &mut self.lists[self.start + list as usize * EIGHTS..][..EIGHTS];
        let mark = &mut self.marks[list as usize];
        let last = ((*mark & COUNT) as usize).wrapping_sub(1);
        let mut places = kernel.find(&own[0].0, slot);
        if EIGHTS == 2 {
            places |= kernel.find(&own[1].0, slot) << DISC_LANES;
        }
        let place = places.trailing_zeros() as usize;
        if *mark & LONG == 0 && last < DISC_LANES * EIGHTS && place <= last {
            *mark -= 1;
            own[place / DISC_LANES].0[place % DISC_LANES] =
                own[last / DISC_LANES].0[last % DISC_LANES];
            own[last / DISC_LANES].0[last % DISC_LANES] = self.dummy;
        } else {
            self.remove_slot_from_long(list, slot);
        }
    }

    /// Appends a slot to a list whose own slots are full.
    #[inline(never)]
    fn push_slot_to_long(&mut self, list: u32, slot: u32) {
        let (last, _) = self.ends(list);
        let dummy = self.dummy;
        let slots = self.slots8_mut(list, last);
        if let Some(free) = slots.iter_mut().find(|free| **free == dummy) {
            *free = slot;
            return;
        }
        let mut both = [dummy; DISC_LANES];
        [both[0], both[1]] = [slots[DISC_LANES - 1], slot];
        let next = self.unused.pop().unwrap_or(self.more.len() as u32);
        if next as usize == self.more.len() {
            if self.more.len() == self.more.capacity() {
                // Grows by a sixteenth instead of doubling.
                self.more.reserve_exact(self.more.len() / 16 + 1);
            }
            self.more.push(Slots8(both));
        } else {
            self.more[next as usize] = Slots8(both);
        }
        self.slots8_mut(list, last)[DISC_LANES - 1] = LINK | next;
        self.marks[list as usize] |= LONG;
    }

    /// Removes a slot from a long list; the last slot takes its place.
    #[inline(never)]
    fn remove_slot_from_long(&mut self, list: u32, slot: u32) {
        let (Some(last), before) = self.ends(list) else {
            debug_assert!(false, "list {list} has no slot {slot:#x}");
            return;
        };
        let dummy = self.dummy;
        let slots = &mut self.more[last as usize].0;
        let used = slots.iter().take_while(|&&slot| slot != dummy).count();
        let moved = std::mem::replace(&mut slots[used - 1], dummy);
        if used == 2 {
            // The last slot of the released eight replaces the link to them.
            let left = slots[0];
            self.unused.push(last);
            self.slots8_mut(list, before)[DISC_LANES - 1] = left;
            if before.is_none() {
                self.marks[list as usize] &= !LONG;
            }
        }
        if moved == slot {
            return;
        }
        let is_it = |other: &&mut u32| **other == slot;
        let own = self.own(list);
        if let Some(place) = self.lists[own].0.iter_mut().find(is_it) {
            *place = moved;
            return;
        }
        let mut at = Some(None);
        while let Some(number) = at {
            let slots = self.slots8_mut(list, number);
            at = Slots8(*slots).next().map(Some);
            if let Some(place) = slots.iter_mut().find(is_it) {
                *place = moved;
                return;
            }
        }
        debug_assert!(false, "list {list} has no slot {slot:#x}");
    }

    /// Indices of the last eight of a list and of those before them; none stands for its own slots.
    fn ends(&self, list: u32) -> (Option<u32>, Option<u32>) {
        let (mut last, mut before) = (None, None);
        let mut eight = &self.lists[self.own(list) + usize::from(self.is_wide)];
        while let Some(next) = eight.next() {
            (last, before) = (Some(next), last);
            eight = &self.more[next as usize];
        }
        (last, before)
    }

    /// The eight slots with this index, or the last eight of a list's own.
    fn slots8_mut(&mut self, list: u32, number: Option<u32>) -> &mut [u32; DISC_LANES] {
        let last_of_own = self.own(list) + usize::from(self.is_wide);
        &mut number
            .map_or(&mut self.lists[last_of_own], |number| {
                &mut self.more[number as usize]
            })
            .0
    }

    /// The cell at an offset of at most one from another, and its image in boxes.
    fn neighbour(&self, cell: [u16; 2], offset: [i32; 2]) -> (u32, [i32; 2]) {
        let (columns, rows) = (self.columns as i32, self.rows as i32);
        let (column, image_x) = wrap_cell(i32::from(cell[0]) + offset[0], columns);
        let (row, image_y) = wrap_cell(i32::from(cell[1]) + offset[1], rows);
        (self.index([column as u16, row as u16]), [image_x, image_y])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::simd::Portable;
    use proptest::prelude::*;

    #[test]
    fn lists_have_sixteen_own_slots_only_where_many_are_long() {
        // One disc in each cell of a grid of 20 × 20 gives nine around each. Then one in four.
        let cells = |every: u16| {
            (0..400_u16)
                .filter(move |n| n % every == 0)
                .map(|n| (u32::from(n), [n % 20, n / 20]))
        };
        let mut lists: NeighbourLists = NeighbourLists::default();
        lists.list_all([20, 20], 400, cells(1));
        assert!(lists.is_wide && lists.more.is_empty());
        assert_eq!(lists.seen_from(lists.index([7, 7])).count(), 9);
        let wide = lists.heap_bytes();
        assert!(
            lists
                .lists
                .as_ptr()
                .wrapping_add(lists.start)
                .align_offset(64)
                == 0,
            "a list lies in one cache line"
        );
        lists.list_all([20, 20], 400, cells(4));
        assert!(
            !lists.is_wide && lists.heap_bytes() * 10 < wide * 6,
            "{} {wide}",
            lists.heap_bytes()
        );
        // Three around each, and more in one cell: with six more, nine lists of 400 hold more than
        // eight; with five none does.
        let crowd = |more| cells(4).chain((0..more).map(|n| (4 * n + 1, [8, 8])));
        lists.list_all([20, 20], 400, crowd(6));
        assert!(lists.is_wide);
        lists.list_all([20, 20], 400, crowd(5));
        assert!(!lists.is_wide);
    }

    proptest! {
        /// Any discs in any cells (all in one, too), moved about: every list equals that of a
        /// search through all discs.
        #[test]
        fn lists_hold_exactly_the_discs_around(
            columns in 3u16..6, rows in 3u16..6, crowd in any::<bool>(), is_wide in any::<bool>(),
            starts in prop::collection::vec((0u16..6, 0u16..6), 1..60),
            moves in prop::collection::vec((0usize..60, 0usize..2, any::<bool>()), 0..200),
        ) {
            let counts = [columns, rows];
            let mut cells: Vec<[u16; 2]> = starts
                .iter()
                .map(|&(x, y)| if crowd { [0, 0] } else { [x % columns, y % rows] })
                .collect();
            let mut lists: NeighbourLists = NeighbourLists { is_wide, ..NeighbourLists::default() };
            lists.lay_out(u32::from(columns), u32::from(rows), cells.len() as u32);
            lists.set_covered(u32::from(columns) + 1, true);
            for (disc, &cell) in cells.iter().enumerate() {
                lists.enter(disc as u32, cell);
            }
            for (disc, axis, up) in moves {
                let disc = disc % cells.len();
                let direction = if up { 1 } else { -1 };
                let from = cells[disc];
                let (index, image) = wrap_cell(i32::from(from[axis]) + direction, i32::from(counts[axis]));
                let mut to = from;
                to[axis] = index as u16;
                if image == 0 {
                    lists.step(Portable, disc as u32, from, to, axis, direction);
                } else {
                    lists.leave(disc as u32, from);
                    lists.enter(disc as u32, to);
                }
                cells[disc] = to;
            }
            for cell in 0..u32::from(columns) * u32::from(rows) {
                let list = lists.list_of(cell);
                let own = if is_wide { 2 } else { 1 } * DISC_LANES;
                prop_assert_eq!(list.count(), list.slots().count());
                prop_assert_eq!(list.mark & LONG != 0, list.count() > own);
                let mut seen: Vec<u32> = Vec::new();
                list.for_each_slots8(|slots| seen.extend(slots.iter().filter(|&&slot| slot != lists.dummy)));
                prop_assert_eq!(&seen, &list.slots().collect::<Vec<_>>());
                let mut appended = Vec::new();
                list.append_to(&mut appended);
                prop_assert_eq!(&appended, &seen);
                let only_eight = list.mark & LONG == 0 && seen.len() <= DISC_LANES;
                let expected = only_eight.then_some((&list.first.0, list.at_border, list.is_covered()));
                prop_assert_eq!(lists.only_eight(cell), expected);
                if let Some((first, second)) = list.plain() {
                    let slots = first.iter().chain(second.into_iter().flatten());
                    prop_assert_eq!(slots.filter(|&&slot| slot != lists.dummy).count(), list.count());
                }
            }
            for row in 0..rows {
                for column in 0..columns {
                    let mut listed: Vec<_> = lists.seen_from(lists.index([column, row])).collect();
                    listed.sort_unstable();
                    let mut expected = Vec::new();
                    for (disc, cell) in cells.iter().enumerate() {
                        for (dx, dy) in (0..9).map(|k| (k % 3 - 1, k / 3 - 1)) {
                            let (x, image_x) = wrap_cell(i32::from(column) + dx, i32::from(columns));
                            let (y, image_y) = wrap_cell(i32::from(row) + dy, i32::from(rows));
                            if [x, y] == [i32::from(cell[0]), i32::from(cell[1])] {
                                expected.push((disc as u32, [image_x, image_y]));
                            }
                        }
                    }
                    expected.sort_unstable();
                    prop_assert_eq!(listed, expected);
                }
            }
            // After all discs have left, every list is empty.
            for (disc, &cell) in cells.iter().enumerate() {
                lists.leave(disc as u32, cell);
            }
            prop_assert!(lists.marks.iter().all(|&mark| mark & (COUNT | LONG) == 0));
            prop_assert!(lists.lists[lists.start..].iter().all(|eight| eight.0 == [lists.dummy; DISC_LANES]));
            prop_assert_eq!(lists.unused.len(), lists.more.len());
        }
    }
}
