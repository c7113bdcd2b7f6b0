//! The cells that a workspace covers: the whole box, or a window around a tile.

use std::fmt::Debug;

/// Maps the cells of the grid to the lists of a workspace.
///
/// Cells keep their column and row in the box in every workspace, so that all roundings are the
/// same; only the place of their lists differs.
pub(super) trait CellFrame: Debug + Clone + Default {
    /// Whether it is the whole box. Large bodies that move, and cells of a dilute gas, exist only
    /// there.
    const IS_WHOLE: bool;

    /// The bodies of a workspace.
    type Bodies: Numbering;

    /// Columns and rows of lists, in a grid of this many columns and rows.
    fn size(&self, counts: [u32; 2]) -> [u32; 2];

    /// The column (axis 0) or row (axis 1) in the box, for a column or row of lists.
    fn cell_along(&self, counts: [u32; 2], axis: usize, list: u32) -> u32;

    /// Index of the list of a cell, where a row has `stride` lists.
    fn index(&self, cell: [u16; 2], stride: u32) -> u32;

    /// Whether the workspace owns a cell: every cell has one owner, which counts the work there.
    fn owns(&self, cell: [u16; 2]) -> bool;
}

/// How a workspace numbers its bodies.
pub(super) trait Numbering: Debug + Clone + Default {
    /// The index among all bodies of one in the workspace.
    fn among_all(&self, body: u32) -> u32;
}

/// All bodies have their own indices.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct AllBodies;

impl Numbering for AllBodies {
    #[inline(always)]
    fn among_all(&self, body: u32) -> u32 {
        body
    }
}

/// Some of the bodies, by their indices among all, in ascending order: ties between events are then
/// decided as among all bodies.
#[derive(Debug, Clone, Default)]
pub(super) struct SomeBodies(pub Vec<u32>);

impl Numbering for SomeBodies {
    #[inline(always)]
    fn among_all(&self, body: u32) -> u32 {
        self.0[body as usize]
    }
}

/// All cells of the box.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct WholeBox;

impl CellFrame for WholeBox {
    const IS_WHOLE: bool = true;

    type Bodies = AllBodies;

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

    #[inline(always)]
    fn owns(&self, _cell: [u16; 2]) -> bool {
        true
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
    /// Columns and rows on each side that other tiles own.
    pub border: u32,
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

    /// All its lists, with column and row of their cells in the box.
    pub fn cells(self) -> impl Iterator<Item = (u32, [u32; 2])> {
        let along = move |axis: usize, list: u32| self.cell_along(self.counts, axis, list);
        (0..self.size[1]).flat_map(move |row| {
            (0..self.size[0]).map(move |column| {
                (
                    row * self.size[0] + column,
                    [along(0, column), along(1, row)],
                )
            })
        })
    }
}

impl CellFrame for TileFrame {
    const IS_WHOLE: bool = false;

    type Bodies = SomeBodies;

    fn size(&self, _counts: [u32; 2]) -> [u32; 2] {
        self.size
    }

    fn cell_along(&self, counts: [u32; 2], axis: usize, list: u32) -> u32 {
        let cell = self.first[axis] + list;
        if cell < counts[axis] {
            cell
        } else {
            cell - counts[axis]
        }
    }

    #[inline(always)]
    fn index(&self, cell: [u16; 2], stride: u32) -> u32 {
        let [column, row] = self.place(cell);
        row * stride + column
    }

    #[inline(always)]
    fn owns(&self, cell: [u16; 2]) -> bool {
        let place = self.place(cell);
        let is_own =
            |axis: usize| place[axis].wrapping_sub(self.border) < self.size[axis] - 2 * self.border;
        is_own(0) & is_own(1)
    }
}
