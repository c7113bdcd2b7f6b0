//! Walls and fixed bodies, by the cells in which a body may touch them. They never change, so every
//! tile reads them directly.

use super::map::TileMap;
use crate::{
    cells::{
        cell_grid::CellGrid,
        multi_cell::{CoveredCells, Listed, cells_of_fixed_body},
    },
    world::World,
};

/// The fixed bodies of the box.
#[derive(Debug, Clone)]
pub(super) struct FixedBodies {
    columns: u32,
    /// Those listed in each cell, by their indices among all bodies.
    cells: CoveredCells,
    /// Those that are listed in cells of several tiles, in ascending order.
    shared: Vec<u32>,
}

impl FixedBodies {
    /// Lists the fixed bodies of a box; none if there are none.
    pub fn new(world: &World, grid: &CellGrid, map: &TileMap) -> Option<Self> {
        let fixed = || (0..world.bodies().len()).filter(|&body| world.bodies()[body].is_fixed());
        fixed().next()?;
        let [columns, rows] = grid.counts();
        let mut bodies = Self {
            columns,
            cells: CoveredCells::default(),
            shared: Vec::new(),
        };
        bodies.cells.lay_out((columns * rows) as usize);
        for body in fixed() {
            let listed = cells_of_fixed_body(grid, world, body);
            let tile = |cell: u32| map.tile_of([(cell % columns) as u16, (cell / columns) as u16]);
            if listed
                .iter()
                .any(|cell| tile(cell.index) != tile(listed[0].index))
            {
                bodies.shared.push(body as u32);
            }
            for cell in listed {
                bodies.cells.enter(
                    cell.index,
                    Listed {
                        index: body as u32,
                        image: cell.image,
                    },
                );
            }
        }
        Some(bodies)
    }

    /// Those listed in a cell, with the image in which its bodies appear in their frame.
    pub fn in_cell(&self, [column, row]: [u32; 2]) -> impl Iterator<Item = Listed> {
        let cell = row * self.columns + column;
        (0..self.cells.count(cell)).map(move |place| self.cells.get(cell, place))
    }

    /// Whether bodies of several tiles may touch a fixed body.
    pub fn is_shared(&self, body: u32) -> bool {
        self.shared.binary_search(&body).is_ok()
    }

    pub fn heap_bytes(&self) -> usize {
        self.cells.heap_bytes() + self.shared.capacity() * size_of::<u32>()
    }
}
