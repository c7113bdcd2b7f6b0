//! The cells that a workspace covers: the whole box, or a window around a tile.

use std::fmt::Debug;

/// Maps the cells of the grid to the lists of a workspace.
///
/// Cells keep their column and row in the box in every workspace, so that all roundings are the
/// same; only the place of their lists differs.
pub(super) trait Frame: Debug + Clone + Default {
    /// Columns and rows of lists, in a grid of this many columns and rows.
    fn size(&self, counts: [u32; 2]) -> [u32; 2];

    /// The column (axis 0) or row (axis 1) in the box, for a column or row of lists.
    fn cell_along(&self, counts: [u32; 2], axis: usize, list: u32) -> u32;

    /// Index of the list of a cell, where a row has `stride` lists.
    fn index(&self, cell: [u16; 2], stride: u32) -> u32;
}

/// All cells of the box.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct WholeBox;

impl Frame for WholeBox {
    fn size(&self, counts: [u32; 2]) -> [u32; 2] {
        counts
    }

    fn cell_along(&self, _counts: [u32; 2], _axis: usize, list: u32) -> u32 {
        list
    }

    #[inline(always)]
    fn index(&self, cell: [u16; 2], stride: u32) -> u32 {
        u32::from(cell[1]) * stride + u32::from(cell[0])
    }
}

/// A rectangle of cells, which may extend over the border of the box but covers no cell twice.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct TileFrame {
    /// Column and row of its first cell.
    pub first: [u32; 2],
    /// Its columns and rows.
    pub size: [u32; 2],
    /// Columns and rows of the box.
    pub counts: [u32; 2],
}

impl TileFrame {
    /// Column and row of a cell, from the first of the window on.
    #[inline(always)]
    pub fn place(&self, cell: [u16; 2]) -> [u32; 2] {
        // Without a branch: of a negative difference the first term wraps to a large number.
        let place = |axis: usize| {
            let place = u32::from(cell[axis]).wrapping_sub(self.first[axis]);
            place.min(place.wrapping_add(self.counts[axis]))
        };
        [place(0), place(1)]
    }
}

impl Frame for TileFrame {
    fn size(&self, _counts: [u32; 2]) -> [u32; 2] {
        self.size
    }

    fn cell_along(&self, counts: [u32; 2], axis: usize, list: u32) -> u32 {
        let cell = self.first[axis] + list;
        if cell < counts[axis] { cell } else { cell - counts[axis] }
    }

    #[inline(always)]
    fn index(&self, cell: [u16; 2], stride: u32) -> u32 {
        let [column, row] = self.place(cell);
        row * stride + column
    }
}
