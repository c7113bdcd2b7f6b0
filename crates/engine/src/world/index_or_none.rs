//! The place of an entry in a list, or none, in four bytes.

/// An index below 2³² − 1, or none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct IndexOrNone(u32);

impl IndexOrNone {
    pub const NONE: Self = Self(u32::MAX);

    #[inline]
    pub fn new(index: usize) -> Self {
        debug_assert!(
            index < u32::MAX as usize,
            "{index} exceeds the range of an index"
        );
        Self(index as u32)
    }

    #[inline]
    pub fn get(self) -> Option<usize> {
        (self != Self::NONE).then_some(self.0 as usize)
    }

    /// The index of one that is not none; for none, an index beyond every list.
    #[inline]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}
