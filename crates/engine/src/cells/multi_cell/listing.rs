//! Lists multi-cell bodies in the cells that they can reach, and finds their neighbours.

use carom_geometry::PeriodicBox;
use glam::DVec2;

use super::{EarliestEvent, Listed, MultiCellBody};
use crate::{
    cells::{
        body_record::{NO_CELL, RecordKind},
        cell_grid::CellGrid,
        frame::CellFrame,
        state::CellState,
        walls::{cells_of_wall, near_wall},
    },
    world::{
        World,
        wall::{StandingWall, place_during, wall_speed},
    },
};

/// Least radius of a shell, as a share of the shorter side of a cell. Smaller: a body among discs
/// far smaller than a cell leaves its shell so often that a run does not end. Larger: no gain.
const MIN_SHELL: f64 = 1.0 / 128.0;

/// Way of a wall that moves until it is listed anew, in shorter sides of a cell. Smaller: the wall
/// is listed anew more often, and each time this costs a look at all its cells. Larger: bodies
/// predict contacts with walls that are farther away.
const SPAN: f64 = 1.0;

/// Factor on the distances of lists, so that no rounding makes them too short.
const MARGIN: f64 = 1.0 + 1e-12;

impl CellState {
    /// Lists every multi-cell body, at the start of an epoch.
    pub(in crate::cells) fn list_multi_cell_bodies(&mut self, world: &World) {
        let count = self.multi_cell.list.len();
        if count == 0 {
            return;
        }
        let [columns, rows] = self.grid.counts();
        self.multi_cell.covered.lay_out((columns * rows) as usize);
        for index in 0..count {
            let body = self.multi_cell.list[index].body;
            self.records[body as usize].set_cell(NO_CELL);
            self.list_body(world, index, 0.0);
        }
    }

    /// Lists a multi-cell body anew when it has left its shell.
    #[cold]
    pub(in crate::cells) fn leave_shell(&mut self, world: &World, body: u32, now: f64) {
        if let Some(index) = self.multi_cell.get(body) {
            self.list_body(world, index, now);
        }
    }

    /// Lists the walls that move for the spans that began at these times (offsets in the epoch), in
    /// the middle of an epoch.
    pub(in crate::cells) fn resume_spans(
        &mut self,
        world: &World,
        spans: impl Iterator<Item = (u32, f64)>,
    ) {
        for (wall, from) in spans {
            let Some(index) = self.multi_cell.get(wall) else {
                continue;
            };
            self.list_body(world, index, from);
            let until = self.multi_cell.list[index].listed_until;
            self.store_event(wall, &EarliestEvent::before(until, RecordKind::Shell));
        }
    }

    /// Lists a wall that moves anew, and returns the bodies that it may now touch and could not
    /// touch before: those in the cells that it has entered, and its neighbours.
    #[cold]
    pub(in crate::cells) fn move_wall(&mut self, world: &World, wall: u32, now: f64) -> Vec<u32> {
        let Some(index) = self.multi_cell.get(wall) else {
            return Vec::new();
        };
        let before = self.multi_cell.list[index].cells.clone();
        self.list_body(world, index, now);
        let multi_cell_body = &self.multi_cell.list[index];
        let mut bodies: Vec<u32> = Vec::new();
        for cell in cells_entered(&before, &multi_cell_body.cells) {
            bodies.extend(self.bodies_in(cell));
        }
        let neighbours = multi_cell_body.neighbours.iter();
        bodies.extend(neighbours.map(|other| self.multi_cell.list[other.index as usize].body));
        bodies.sort_unstable();
        bodies.dedup();
        bodies
    }

    /// Sets the strip about its present place for which a piston is listed from now on.
    fn set_strip(&mut self, world: &World, index: usize, now: f64) {
        let side = self.grid.side().min_element();
        let multi_cell_body = &mut self.multi_cell.list[index];
        let here = multi_cell_body.motion_at(now);
        let body = &world.bodies[multi_cell_body.body as usize];
        multi_cell_body.wall = StandingWall::new(body, &here);
        multi_cell_body.centre = here.position;
        multi_cell_body.shell = 0.5 * SPAN * side;
    }

    /// Lists a multi-cell body around its present place.
    fn list_body(&mut self, world: &World, index: usize, now: f64) {
        self.unlist_body(index);
        let bounds = world.bounds();
        let multi_cell_body = &mut self.multi_cell.list[index];
        let body = multi_cell_body.body as usize;
        let (place, image) = bounds.wrap(multi_cell_body.motion.position_at(now));
        if image != [0, 0] && !multi_cell_body.fixed && multi_cell_body.wall.is_none() {
            multi_cell_body.motion.position -= bounds.shift(image);
            self.records[body].set_motion(&multi_cell_body.motion);
            let winding = &mut self.windings[body];
            *winding = [0, 1].map(|axis| winding[axis].wrapping_add(image[axis] as i16));
            self.wrapped.push(body as u32);
        }
        multi_cell_body.centre = place;
        let small = self.grid.largest_small();
        let least = MIN_SHELL * self.grid.side().min_element();
        multi_cell_body.shell = if multi_cell_body.fixed {
            0.0
        } else {
            small
                .min(multi_cell_body.radius.max(0.5 * small))
                .max(least)
        };
        if self.multi_cell.list[index].is_moving_fixed() {
            self.multi_cell.list[index].set_span(world, &self.grid, [now, self.limit]);
        } else if self.multi_cell.list[index].is_piston() {
            self.set_strip(world, index, now);
        }
        self.list_in_cells(index);
        self.find_neighbours(bounds, index);
    }

    fn unlist_body(&mut self, index: usize) {
        let own_index = index as u32;
        let body = self.multi_cell.list[index].body;
        // The vectors are put back below, so that their memory is used again.
        let mut cells = std::mem::take(&mut self.multi_cell.list[index].cells);
        for listed in cells.drain(..) {
            if self.multi_cell.covered.leave(listed.index, body) {
                self.neighbour_lists.set_covered(listed.index, false);
            }
        }
        let mut neighbours = std::mem::take(&mut self.multi_cell.list[index].neighbours);
        for neighbour in neighbours.drain(..) {
            self.multi_cell.list[neighbour.index as usize]
                .neighbours
                .retain(|entry| entry.index != own_index);
        }
        let multi_cell_body = &mut self.multi_cell.list[index];
        (multi_cell_body.cells, multi_cell_body.neighbours) = (cells, neighbours);
    }

    /// Lists a body in all cells that it reaches from its shell.
    fn list_in_cells(&mut self, index: usize) {
        let multi_cell_body = &mut self.multi_cell.list[index];
        let mut cells = std::mem::take(&mut multi_cell_body.cells);
        let mut tiles = std::mem::take(&mut multi_cell_body.tiles);
        tiles.clear();
        add_cells(&self.grid, multi_cell_body, &mut cells);
        if multi_cell_body.wall.is_none() {
            Reach::new(&self.grid, multi_cell_body).add_tiles(&mut tiles);
        }
        multi_cell_body.tiles = tiles;
        self.enter_cells(index, cells);
    }

    /// Lists a body in these cells.
    fn enter_cells(&mut self, index: usize, cells: Vec<Listed>) {
        let body = self.multi_cell.list[index].body;
        for &cell in &cells {
            self.multi_cell.covered.enter(
                cell.index,
                Listed {
                    index: body,
                    image: cell.image,
                },
            );
            self.neighbour_lists.set_covered(cell.index, true);
        }
        self.multi_cell.list[index].cells = cells;
    }

    /// Finds the multi-cell bodies that this one may touch, among those listed in its cells.
    ///
    /// No neighbour is left out: circles of radius R + h around the centres of the two shells
    /// overlap. Neither body reaches into the other, so a point lies in both circles that is no
    /// nearer to the centre of a disc's shell than R − h. The cell of this point lists both.
    fn find_neighbours(&mut self, bounds: &PeriodicBox, index: usize) {
        let multi_cell = &mut self.multi_cell;
        let factor = self.grid.largest_factor();
        let own_index = index as u32;
        let mut neighbours = std::mem::take(&mut multi_cell.list[index].neighbours);
        let multi_cell_body = &multi_cell.list[index];
        for cell in &multi_cell_body.cells {
            for place in 0..multi_cell.covered.count(cell.index) {
                let other = multi_cell.covered.get(cell.index, place);
                let image = [0, 1].map(|axis| cell.image[axis] - other.image[axis]);
                let found = Listed {
                    index: multi_cell.index_of[other.index as usize].index() as u32,
                    image,
                };
                let there = &multi_cell.list[found.index as usize];
                if found.index == own_index
                    || (multi_cell_body.fixed && there.fixed)
                    || (multi_cell_body.wall.is_some() && there.wall.is_some())
                    || neighbours.contains(&found)
                {
                    continue;
                }
                let shift = bounds.shift(image.map(i64::from));
                let near = match (&multi_cell_body.wall, &there.wall) {
                    (Some(wall), _) => near_wall(wall, multi_cell_body.shell, there, shift),
                    (None, Some(wall)) => near_wall(wall, there.shell, multi_cell_body, -shift),
                    (None, None) => {
                        let radii = multi_cell_body.radius + there.radius;
                        let reach = (factor * radii + multi_cell_body.shell + there.shell) * MARGIN;
                        (there.centre + shift - multi_cell_body.centre).length_squared()
                            <= reach * reach
                    }
                };
                if near {
                    neighbours.push(found);
                }
            }
        }
        for neighbour in &neighbours {
            let image = neighbour.image.map(|boxes| -boxes);
            multi_cell.list[neighbour.index as usize]
                .neighbours
                .push(Listed {
                    index: own_index,
                    image,
                });
        }
        multi_cell.list[index].neighbours = neighbours;
    }
}

impl<F: CellFrame> CellState<F> {
    /// The bodies that live in a cell.
    pub(in crate::cells) fn bodies_in(&self, cell: u32) -> impl Iterator<Item = u32> {
        let around = self.neighbour_lists.seen_from(cell);
        around.map(|(body, _)| body).filter(move |&body| {
            let own = self.records[body as usize].cell();
            self.neighbour_lists.index(own) == cell
        })
    }
}

impl MultiCellBody {
    /// Sets the span for which a fixed body that moves is listed from now on, in an epoch that ends
    /// at `limit` (offsets in it, time), and its place in the middle of it.
    fn set_span(&mut self, world: &World, grid: &CellGrid, [now, limit]: [f64; 2]) {
        let side = grid.side().min_element();
        let (body, motion) = (&world.bodies[self.body as usize], &self.motion);
        let drive = self.drive.as_ref();
        let fastest = drive.map_or(0.0, |drive| drive.max_speed(limit));
        let until = now + SPAN * side / (wall_speed(body, motion) + fastest);
        let until = until.max(now.next_up());
        // A drive is bounded by what it does in this epoch.
        let end = match drive {
            Some(_) => until.min(limit).max(now),
            None => until,
        };
        let (middle, way) = place_during(body, motion, drive, [now, end]);
        self.wall = StandingWall::new(body, &middle);
        // Not wrapped into the box, like the motion.
        self.centre = middle.position;
        self.shell = way * MARGIN;
        (self.listed_from, self.listed_until) = (now, until);
    }
}

/// The cells that list a fixed body.
#[derive(Debug, Clone)]
pub(in crate::cells) struct FixedBodyCells {
    /// Each with the image in which its discs appear in the frame of the body.
    pub cells: Vec<Listed>,
    /// End of the span for which they list it (offset in the epoch, time); infinite for a body at
    /// rest.
    pub until: f64,
}

/// The cells that list a fixed body (index among all) from `now` on, in an epoch that ends at
/// `limit` (offsets in it, time).
pub(in crate::cells) fn cells_of_fixed_body(
    grid: &CellGrid,
    world: &World,
    body: u32,
    [now, limit]: [f64; 2],
) -> FixedBodyCells {
    let index = body as usize;
    let motion = &world.motions()[index];
    let mut fixed = MultiCellBody::new(
        body,
        &world.bodies()[index],
        motion,
        world.drive(index).as_ref(),
        grid.holds_molecules(),
    );
    if fixed.is_moving_fixed() {
        fixed.set_span(world, grid, [now, limit]);
    } else {
        fixed.centre = world.bounds().wrap(motion.position).0;
    }
    let mut cells = Vec::new();
    add_cells(grid, &fixed, &mut cells);
    FixedBodyCells {
        cells,
        until: fixed.listed_until,
    }
}

/// Those of the cells `now` that were not among those `before`, by their indices.
pub(in crate::cells) fn cells_entered<'a>(
    before: &[Listed],
    now: &'a [Listed],
) -> impl Iterator<Item = u32> + use<'a> {
    let order = |listed: &Listed| (listed.index, listed.image);
    let mut before = before.to_vec();
    before.sort_unstable_by_key(order);
    now.iter()
        .filter(move |cell| before.binary_search_by_key(&order(cell), order).is_err())
        .map(|cell| cell.index)
}

/// Adds the cells that list a body.
fn add_cells(grid: &CellGrid, multi_cell_body: &MultiCellBody, cells: &mut Vec<Listed>) {
    match &multi_cell_body.wall {
        Some(wall) => cells_of_wall(grid, wall, multi_cell_body.shell, cells),
        None => Reach::new(grid, multi_cell_body).add_cells(cells),
    }
}

/// The cells within R + r_max + h of the centre of a body's shell; of a disc not the cells that are
/// inside it for every position in its shell.
struct Reach {
    /// Corners of a rectangle around them: column and row, which may lie outside the box.
    first: [i64; 2],
    last: [i64; 2],
    centre: DVec2,
    /// R + r_max + h (length).
    outer: f64,
    /// No other centre is nearer to the centre of a disc than its rim (length).
    inner: f64,
    side: DVec2,
    counts: [i64; 2],
}

impl Reach {
    fn new(grid: &CellGrid, multi_cell_body: &MultiCellBody) -> Self {
        let &MultiCellBody {
            radius,
            centre,
            shell,
            ..
        } = multi_cell_body;
        let outer = (grid.largest_factor() * (radius + grid.largest_small()) + shell) * MARGIN;
        // Discs that do not see this one, or touch it at a shorter distance, may be inside.
        let inner = if multi_cell_body.is_disc_among_discs && !grid.is_by_pair() {
            (radius - shell).max(0.0)
        } else {
            0.0
        };
        let side = grid.side();
        let cell = |place: DVec2| {
            (place / side)
                .floor()
                .to_array()
                .map(|number| number as i64)
        };
        let counts = grid.counts().map(i64::from);
        Self {
            first: cell(centre - outer),
            last: cell(centre + outer),
            centre,
            outer,
            inner,
            side,
            counts,
        }
    }

    /// Whether a block of cells is near enough for such a centre, and not wholly inside the disc.
    fn reaches(&self, [from, to]: [[i64; 2]; 2]) -> bool {
        let low = DVec2::new(from[0] as f64, from[1] as f64) * self.side;
        let high = DVec2::new(to[0] as f64 + 1.0, to[1] as f64 + 1.0) * self.side;
        let nearest = (low - self.centre).max(self.centre - high).max(DVec2::ZERO);
        let farthest = (self.centre - low).max(high - self.centre);
        nearest.length_squared() <= self.outer * self.outer
            && farthest.length_squared() >= self.inner * self.inner
    }

    fn folded(&self, cell: [i64; 2]) -> Listed {
        let counts = self.counts;
        let [column, row] = [cell[0].rem_euclid(counts[0]), cell[1].rem_euclid(counts[1])];
        let image = [
            cell[0].div_euclid(counts[0]) as i32,
            cell[1].div_euclid(counts[1]) as i32,
        ];
        Listed {
            index: (row * counts[0] + column) as u32,
            image,
        }
    }

    /// Adds the cells.
    fn add_cells(&self, cells: &mut Vec<Listed>) {
        for row in self.first[1]..=self.last[1] {
            for column in self.first[0]..=self.last[0] {
                if self.reaches([[column, row]; 2]) {
                    cells.push(self.folded([column, row]));
                }
            }
        }
    }

    /// Adds cells whose neighbour lists together hold every disc in the cells.
    fn add_tiles(&self, tiles: &mut Vec<Listed>) {
        for row in (self.first[1] + 1..=self.last[1] + 1).step_by(3) {
            for column in (self.first[0] + 1..=self.last[0] + 1).step_by(3) {
                if self.reaches([[column - 1, row - 1], [column + 1, row + 1]]) {
                    tiles.push(self.folded([column, row]));
                }
            }
        }
    }
}
