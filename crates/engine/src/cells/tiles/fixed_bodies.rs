//! Walls and fixed bodies, by the cells in which a body may touch them. Contacts never change them,
//! so every tile reads them directly. Walls may move; where bodies fall, all fixed bodies do in the
//! falling frame.

use super::map::TileMap;
use crate::{
    cells::{
        cell_grid::CellGrid,
        multi_cell::{CoveredCells, FixedBodyCells, Listed, cells_entered, cells_of_fixed_body},
    },
    world::World,
};

/// The fixed bodies of the box.
#[derive(Debug, Clone)]
pub(super) struct FixedBodies {
    columns: u32,
    /// Those listed in each cell, by their indices among all bodies.
    cells: CoveredCells,
    /// Those that are listed in cells of several tiles, in ascending order; one that moves may be,
    /// in its next span.
    shared: Vec<u32>,
    /// Those that move, in ascending order.
    moving: Vec<MovingBody>,
}

/// A fixed body that moves, and the cells that list it for a span of time: see `multi_cell`.
#[derive(Debug, Clone)]
struct MovingBody {
    body: u32,
    /// Start of the span (offset in the epoch, time).
    from: f64,
    listed: FixedBodyCells,
}

/// The fixed bodies whose spans end at one instant, and which are listed anew then.
#[derive(Debug, Clone)]
pub(super) struct Relisting {
    /// In ascending order, as in the global order.
    pub bodies: Vec<RelistedBody>,
    /// All fixed bodies afterwards.
    pub after: FixedBodies,
}

/// A fixed body, the cells that list it in two successive spans, and those that it enters, by their
/// indices.
#[derive(Debug, Clone)]
pub(super) struct RelistedBody {
    pub body: u32,
    pub before: Vec<Listed>,
    pub after: Vec<Listed>,
    pub entered: Vec<u32>,
}

impl Relisting {
    pub fn heap_bytes(&self) -> usize {
        let of_body = |body: &RelistedBody| {
            size_of::<RelistedBody>()
                + (body.before.capacity() + body.after.capacity()) * size_of::<Listed>()
                + body.entered.capacity() * size_of::<u32>()
        };
        self.bodies.iter().map(of_body).sum::<usize>() + self.after.heap_bytes()
    }
}

impl FixedBodies {
    /// Lists the fixed bodies of a box in an epoch that ends at `limit`; none if there are none.
    /// One that moves is listed since a given time (offsets in the epoch, time).
    pub fn new(
        world: &World,
        grid: &CellGrid,
        map: &TileMap,
        limit: f64,
        listed_from: impl Fn(u32) -> f64,
    ) -> Option<Self> {
        let bodies = world.bodies().iter().zip(0_u32..);
        let fixed = bodies.filter(|(body, _)| body.is_fixed());
        let mut fixed = fixed.map(|(_, index)| index).peekable();
        fixed.peek()?;
        let [columns, rows] = grid.counts();
        let mut bodies = Self {
            columns,
            cells: CoveredCells::default(),
            shared: Vec::new(),
            moving: Vec::new(),
        };
        bodies.cells.lay_out((columns * rows) as usize);
        for body in fixed {
            let from = listed_from(body);
            let listed = cells_of_fixed_body(grid, world, body, [from, limit]);
            bodies.enter(body, &listed.cells);
            let tile = |cell: u32| map.tile_of([(cell % columns) as u16, (cell / columns) as u16]);
            let first = listed.cells.first().map(|cell| tile(cell.index));
            let moves = listed.until < f64::INFINITY;
            if moves
                || listed
                    .cells
                    .iter()
                    .any(|cell| Some(tile(cell.index)) != first)
            {
                bodies.shared.push(body);
            }
            if moves {
                bodies.moving.push(MovingBody { body, from, listed });
            }
        }
        Some(bodies)
    }

    /// Lists those bodies anew whose spans end at `now`, in an epoch that ends at `limit` (offsets
    /// in it, time).
    pub fn relisted(&self, world: &World, grid: &CellGrid, [now, limit]: [f64; 2]) -> Relisting {
        let mut after = self.clone();
        let mut bodies = Vec::new();
        let mut moving = std::mem::take(&mut after.moving);
        for one in moving.iter_mut().filter(|one| one.listed.until <= now) {
            let listed = cells_of_fixed_body(grid, world, one.body, [now, limit]);
            let before = std::mem::replace(&mut one.listed, listed).cells;
            one.from = now;
            for cell in &before {
                after.cells.leave(cell.index, one.body);
            }
            after.enter(one.body, &one.listed.cells);
            bodies.push(RelistedBody {
                body: one.body,
                entered: cells_entered(&before, &one.listed.cells).collect(),
                before,
                after: one.listed.cells.clone(),
            });
        }
        after.moving = moving;
        Relisting { bodies, after }
    }

    fn enter(&mut self, body: u32, cells: &[Listed]) {
        for cell in cells {
            let seen = Listed {
                index: body,
                image: cell.image,
            };
            self.cells.enter(cell.index, seen);
        }
    }

    /// The index of a cell, as in the lists of cells.
    pub fn index(&self, [column, row]: [u32; 2]) -> u32 {
        row * self.columns + column
    }

    /// Those listed in a cell, with the image in which its bodies appear in their frame.
    pub fn in_cell(&self, cell: [u32; 2]) -> impl Iterator<Item = Listed> {
        let cell = self.index(cell);
        (0..self.cells.count(cell)).map(move |place| self.cells.get(cell, place))
    }

    /// Whether bodies of several tiles may touch a fixed body.
    pub fn is_shared(&self, body: u32) -> bool {
        self.shared.binary_search(&body).is_ok()
    }

    /// Those that move, each with the time since when it is listed (offset in the epoch).
    pub fn spans(&self) -> impl Iterator<Item = (u32, f64)> {
        self.moving.iter().map(|one| (one.body, one.from))
    }

    /// Until when none is listed anew (offset in the epoch, time).
    pub fn listed_until(&self) -> f64 {
        let ends = self.moving.iter().map(|one| one.listed.until);
        ends.fold(f64::INFINITY, f64::min)
    }

    /// The shortest span for which one is listed (time); infinite if none moves.
    pub fn shortest_span(&self) -> f64 {
        let spans = self.moving.iter().map(|one| one.listed.until - one.from);
        spans.fold(f64::INFINITY, f64::min)
    }

    pub fn heap_bytes(&self) -> usize {
        let of_moving = |one: &MovingBody| {
            size_of::<MovingBody>() + one.listed.cells.capacity() * size_of::<Listed>()
        };
        self.cells.heap_bytes()
            + self.moving.iter().map(of_moving).sum::<usize>()
            + self.shared.capacity() * size_of::<u32>()
    }
}
