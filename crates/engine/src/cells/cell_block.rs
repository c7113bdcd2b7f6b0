//! The neighbour list of one cell, for reading: eight slots after eight.

use carom_detection::DISC_LANES;

use super::slot::{INDEX_BITS, INDEX_MASK};

/// Number of a list's own slots in use, in the mark of its cell.
pub(super) const COUNT: u8 = 0x1f;
/// Flag of a cell's mark: some discs around it are seen through the border of the box.
pub(super) const AT_BORDER: u8 = 0x20;
/// Flag of a cell's mark: a multi-cell body is listed in the cell.
pub(super) const COVERED: u8 = 0x40;
/// Flag of a cell's mark: the list is longer than its own slots.
pub(super) const LONG: u8 = 0x80;

/// Image code that no slot has: the slot is a link to the next eight.
pub(super) const LINK: u32 = 0xf << INDEX_BITS;

/// Eight slots; those not in use hold the dummy.
///
/// If a list is longer than its own slots, the last of these is a link to eight more, and so on.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
pub(super) struct Slots8(pub [u32; DISC_LANES]);

impl Slots8 {
    /// Index of the next eight slots.
    #[inline]
    pub fn next(&self) -> Option<u32> {
        let last = self.0[DISC_LANES - 1];
        (last >= LINK).then_some(last & INDEX_MASK)
    }
}

/// The neighbour list of a cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct CellBlock<'a> {
    pub cell: u32,
    /// Whether some discs are seen through the border of the box.
    pub at_border: bool,
    pub(super) mark: u8,
    pub(super) first: &'a Slots8,
    /// The second half of sixteen own slots, if more than eight are in use.
    pub(super) second: Option<&'a Slots8>,
    pub(super) more: &'a [Slots8],
    pub(super) dummy: u32,
}

impl<'a> CellBlock<'a> {
    /// The first eight slots, and eight more if these are in use. None if there are still more, or
    /// if some disc is seen through the border of the box.
    #[inline]
    pub fn plain(&self) -> Option<(&'a [u32; DISC_LANES], Option<&'a [u32; DISC_LANES]>)> {
        let is_plain = self.mark & (LONG | AT_BORDER) == 0;
        is_plain.then_some((&self.first.0, self.second.map(|second| &second.0)))
    }

    /// The eight slots after these.
    #[inline]
    fn after(&self, eight: &'a Slots8) -> Option<&'a Slots8> {
        match (eight.next(), self.second) {
            (Some(next), _) => Some(&self.more[next as usize]),
            (None, Some(second)) if std::ptr::eq(eight, self.first) => Some(second),
            _ => None,
        }
    }

    /// Calls `act` with all slots, eight at a time; those not in use hold the dummy.
    #[inline(always)]
    pub fn for_each_slots8(&self, mut act: impl FnMut(&[u32; DISC_LANES])) {
        let mut without_link;
        let mut rest = Some(self.first);
        // A single call, so that the compiler inlines `act`.
        while let Some(eight) = rest {
            rest = self.after(eight);
            let slots = if eight.next().is_some() {
                without_link = eight.0;
                without_link[DISC_LANES - 1] = self.dummy;
                &without_link
            } else {
                &eight.0
            };
            act(slots);
        }
    }

    /// Number of slots in use.
    pub fn count(self) -> usize {
        if self.mark & LONG == 0 {
            (self.mark & COUNT) as usize
        } else {
            self.slots().count()
        }
    }

    /// The slots in use.
    pub fn slots(self) -> impl Iterator<Item = u32> {
        let all = std::iter::successors(Some(self.first), move |eight| self.after(eight));
        let all = all.flat_map(|eight| eight.0);
        all.filter(move |&slot| slot < LINK && slot != self.dummy)
    }

    /// Appends the slots in use.
    #[inline]
    pub fn append_to(self, slots: &mut Vec<u32>) {
        if self.mark & LONG != 0 {
            slots.extend(self.slots());
            return;
        }
        let count = (self.mark & COUNT) as usize;
        slots.extend_from_slice(&self.first.0[..count.min(DISC_LANES)]);
        if let Some(second) = self.second {
            slots.extend_from_slice(&second.0[..count - DISC_LANES]);
        }
    }

    /// Whether a multi-cell body is listed in the cell.
    pub fn is_covered(&self) -> bool {
        self.mark & COVERED != 0
    }
}
