//! The division of the cells of the box into tiles: rectangles of cells, each of which is run on
//! its own during a window.

use crate::cells::frame::TileFrame;

/// Directions from a tile to its neighbours, and their opposites at the same place from the end.
pub(super) const DIRECTIONS: [[i32; 2]; 8] = [
    [-1, -1],
    [0, -1],
    [1, -1],
    [-1, 0],
    [1, 0],
    [-1, 1],
    [0, 1],
    [1, 1],
];

/// Index in [`DIRECTIONS`] of a direction that is not zero.
#[inline(always)]
pub(super) fn direction_index([x, y]: [i32; 2]) -> usize {
    let place = (3 * (y + 1) + x + 1) as usize;
    place - usize::from(place > 4)
}

/// Index of the opposite direction.
pub(super) fn opposite(direction: usize) -> usize {
    DIRECTIONS.len() - 1 - direction
}

/// A rectangle of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Rectangle {
    pub first: [u32; 2],
    pub size: [u32; 2],
}

/// At least two tiles along each axis.
#[derive(Debug, Clone)]
pub(super) struct TileMap {
    /// Columns and rows of the box.
    pub counts: [u32; 2],
    /// For each axis the first column or row of each tile, and the number of all.
    starts: [Vec<u32>; 2],
    /// For each axis the tile of each column or row.
    tile_along: [Vec<u16>; 2],
}

impl TileMap {
    /// Tiles of about `side` cells along each axis; none if fewer than two fit along an axis.
    pub fn new(counts: [u32; 2], side: u32) -> Option<Self> {
        let tiles = counts.map(|count| (count + side / 2) / side);
        let starts = [0, 1].map(|axis| {
            let start =
                |tile| u64::from(tile) * u64::from(counts[axis]) / u64::from(tiles[axis].max(1));
            (0..=tiles[axis])
                .map(|tile| start(tile) as u32)
                .collect::<Vec<u32>>()
        });
        let tile_along = starts.each_ref().map(|starts| {
            let cells = starts.windows(2).enumerate();
            cells
                .flat_map(|(tile, ends)| (ends[0]..ends[1]).map(move |_| tile as u16))
                .collect()
        });
        tiles.iter().all(|&tiles| tiles >= 2).then_some(Self {
            counts,
            starts,
            tile_along,
        })
    }

    /// Tiles along each axis.
    fn per_axis(&self) -> [usize; 2] {
        self.starts.each_ref().map(|starts| starts.len() - 1)
    }

    /// Number of tiles.
    pub fn tiles(&self) -> usize {
        let [columns, rows] = self.per_axis();
        columns * rows
    }

    /// The tile of a cell.
    #[inline]
    pub fn tile_of(&self, cell: [u16; 2]) -> usize {
        let [column, row] =
            [0, 1].map(|axis| usize::from(self.tile_along[axis][usize::from(cell[axis])]));
        row * self.per_axis()[0] + column
    }

    /// The cells of a tile.
    pub fn own(&self, tile: usize) -> Rectangle {
        let columns = self.per_axis()[0];
        let place = [tile % columns, tile / columns];
        let first = [0, 1].map(|axis| self.starts[axis][place[axis]]);
        let end = [0, 1].map(|axis| self.starts[axis][place[axis] + 1]);
        Rectangle {
            first,
            size: [end[0] - first[0], end[1] - first[1]],
        }
    }

    /// The neighbour of a tile in a direction, through the border of the box where it is there.
    pub fn neighbour(&self, tile: usize, direction: [i32; 2]) -> usize {
        let counts = self.per_axis();
        let step = |place: usize, axis: usize| {
            (place as i64 + i64::from(direction[axis])).rem_euclid(counts[axis] as i64) as usize
        };
        step(tile / counts[0], 1) * counts[0] + step(tile % counts[0], 0)
    }

    /// The widest border that can be added to every tile so that its window, with one more ring of
    /// lists, covers no cell of the box twice.
    pub fn widest_border(&self) -> u32 {
        let border = |axis: usize| {
            let largest = self.starts[axis]
                .windows(2)
                .map(|ends| ends[1] - ends[0])
                .max()
                .unwrap_or(0);
            ((self.counts[axis] - largest) / 2).saturating_sub(1)
        };
        border(0).min(border(1))
    }

    /// The window of a tile with a border of so many cells, and one ring of lists around it.
    pub fn window(&self, tile: usize, border: u32) -> TileFrame {
        let own = self.own(tile);
        let first = |axis: usize| {
            (own.first[axis] + self.counts[axis] - (border + 1) % self.counts[axis])
                % self.counts[axis]
        };
        let size = own.size.map(|size| size + 2 * (border + 1));
        TileFrame {
            first: [first(0), first(1)],
            size,
            counts: self.counts,
            border: border + 1,
        }
    }

    /// Calls `visit` with the runs of cells of one row of tiles that make up a tile and a border of
    /// so many cells: the tile that owns the run, the place of the run among its cells, and its
    /// length.
    pub fn for_each_run(
        &self,
        tile: usize,
        border: u32,
        mut visit: impl FnMut(usize, usize, usize),
    ) {
        let own = self.own(tile);
        let [columns, rows] = self.counts;
        let row_of_tiles = self.per_axis()[0];
        for row in 0..own.size[1] + 2 * border {
            let row = (own.first[1] + row + rows - border) % rows;
            let tile_row = usize::from(self.tile_along[1][row as usize]);
            let mut left = own.size[0] + 2 * border;
            let mut column = (own.first[0] + columns - border) % columns;
            while left > 0 {
                let tile_column = usize::from(self.tile_along[0][column as usize]);
                let [first, end] = [0, 1].map(|ends| self.starts[0][tile_column + ends]);
                let length = left.min(end - column);
                let row_in_tile = row - self.starts[1][tile_row];
                let place = row_in_tile * (end - first) + column - first;
                visit(
                    tile_row * row_of_tiles + tile_column,
                    place as usize,
                    length as usize,
                );
                left -= length;
                column = if column + length == columns {
                    0
                } else {
                    column + length
                };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::frame::CellFrame;
    use proptest::prelude::*;

    #[test]
    fn opposite_directions_have_opposite_indices() {
        for (index, direction) in DIRECTIONS.into_iter().enumerate() {
            assert_eq!(direction_index(direction), index);
            assert_eq!(DIRECTIONS[opposite(index)], direction.map(|step| -step));
        }
    }

    proptest! {
        /// Every cell belongs to one tile, and the runs of a window visit each of its cells once,
        /// in the order of its lists.
        #[test]
        fn windows_cover_their_cells_once(
            columns in 20u32..60, rows in 20u32..60, side in 5u32..20, border in 0u32..12,
        ) {
            let Some(map) = TileMap::new([columns, rows], side) else { return Ok(()) };
            let border = border.min(map.widest_border());
            let mut seen = vec![0; (columns * rows) as usize];
            for tile in 0..map.tiles() {
                let own = map.own(tile);
                let mut cells = Vec::new();
                map.for_each_run(tile, border, |owner, place, length| {
                    let area = map.own(owner);
                    for place in place as u32..(place + length) as u32 {
                        let cell = [
                            area.first[0] + place % area.size[0],
                            area.first[1] + place / area.size[0],
                        ];
                        assert_eq!(map.tile_of(cell.map(|number| number as u16)), owner);
                        if owner == tile {
                            seen[(cell[1] * columns + cell[0]) as usize] += 1;
                        }
                        cells.push(cell.map(|number| number as u16));
                    }
                });
                let window = map.window(tile, border);
                let size = own.size.map(|size| size + 2 * border);
                prop_assert_eq!(window.size, size.map(|size| size + 2));
                for (place, &cell) in cells.iter().enumerate() {
                    let place = [place as u32 % size[0] + 1, place as u32 / size[0] + 1];
                    prop_assert_eq!(window.place(cell), place);
                    prop_assert_eq!(window.index(cell, window.size[0]), place[1] * window.size[0] + place[0]);
                    for axis in 0..2 {
                        let along = window.cell_along(map.counts, axis, place[axis]);
                        prop_assert_eq!(along, u32::from(cell[axis]));
                    }
                }
                for (index, direction) in DIRECTIONS.into_iter().enumerate() {
                    let neighbour = map.neighbour(tile, direction);
                    prop_assert_eq!(map.neighbour(neighbour, DIRECTIONS[opposite(index)]), tile);
                }
            }
            prop_assert!(seen.iter().all(|&times| times == 1));
        }
    }
}
