//! Lists multi-cell bodies in the cells that they can reach, and finds their neighbours.

use carom_geometry::PeriodicBox;
use glam::DVec2;

use super::Listed;
use crate::{
    World,
    cells::{state::State, walls::near_wall},
};

/// Column of the record of a body that lives in no cell.
const NO_CELL: u16 = u16::MAX;

/// Least radius of a shell, as a share of the shorter side of a cell. Smaller: a body among discs
/// far smaller than a cell leaves its shell so often that a run does not end. Larger: no gain.
const LEAST_SHELL: f64 = 1.0 / 128.0;

/// Factor on the distances of lists, so that no rounding makes them too short.
const MARGIN: f64 = 1.0 + 1e-12;

impl State {
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
            self.records[body as usize].set_cell([NO_CELL; 2]);
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

    /// Lists a multi-cell body around its present place.
    fn list_body(&mut self, world: &World, index: usize, now: f64) {
        self.unlist_body(index);
        let bounds = world.bounds();
        let multi_cell_body = &mut self.multi_cell.list[index];
        let body = multi_cell_body.body as usize;
        let (place, image) = bounds.wrap(multi_cell_body.motion.position_at(now));
        if image != [0, 0] && !multi_cell_body.fixed {
            multi_cell_body.motion.position -= bounds.shift(image);
            self.records[body].set_motion(&multi_cell_body.motion);
            let winding = &mut self.windings[body];
            *winding = [0, 1].map(|axis| winding[axis].wrapping_add(image[axis] as i16));
            self.wrapped.push(body as u32);
        }
        multi_cell_body.centre = place;
        let small = self.grid.largest_small();
        let least = LEAST_SHELL * self.grid.side().min_element();
        multi_cell_body.shell = if multi_cell_body.fixed {
            0.0
        } else {
            small.min(multi_cell_body.radius.max(0.5 * small)).max(least)
        };
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

    /// Lists a body in every cell within R + r_max + h of its shell's centre; a disc not in the
    /// cells that are inside it for every position in its shell.
    fn list_in_cells(&mut self, index: usize) {
        if let Some(wall) = self.multi_cell.list[index].wall {
            let cells = self.cells_of_wall(&wall);
            self.enter_cells(index, cells);
            return;
        }
        let side = self.grid.side();
        let counts = self.grid.counts().map(i64::from);
        let multi_cell_body = &self.multi_cell.list[index];
        let reach = (multi_cell_body.radius + self.grid.largest_small() + multi_cell_body.shell) * MARGIN;
        let centre = multi_cell_body.centre;
        let first = ((centre - reach) / side).floor();
        let last = ((centre + reach) / side).floor();
        // No other centre is nearer to the centre of a disc than its rim.
        let rim = if multi_cell_body.is_disc_among_discs {
            (multi_cell_body.radius - multi_cell_body.shell).max(0.0)
        } else {
            0.0
        };
        // Whether a block of cells is near enough for such a centre, and not wholly inside the
        // disc.
        let matters = |[from, to]: [[i64; 2]; 2]| {
            let low = DVec2::new(from[0] as f64, from[1] as f64) * side;
            let high = DVec2::new(to[0] as f64 + 1.0, to[1] as f64 + 1.0) * side;
            let nearest = (low - centre).max(centre - high).max(DVec2::ZERO);
            let farthest = (centre - low).max(high - centre);
            nearest.length_squared() <= reach * reach && farthest.length_squared() >= rim * rim
        };
        let folded = |cell: [i64; 2]| {
            let [column, row] = [cell[0].rem_euclid(counts[0]), cell[1].rem_euclid(counts[1])];
            let image = [cell[0].div_euclid(counts[0]) as i32, cell[1].div_euclid(counts[1]) as i32];
            Listed { index: (row * counts[0] + column) as u32, image }
        };
        let (first, last) = ([first.x as i64, first.y as i64], [last.x as i64, last.y as i64]);
        let multi_cell_body = &mut self.multi_cell.list[index];
        let mut cells = std::mem::take(&mut multi_cell_body.cells);
        for row in first[1]..=last[1] {
            for column in first[0]..=last[0] {
                if matters([[column, row]; 2]) {
                    cells.push(folded([column, row]));
                }
            }
        }
        let mut tiles = std::mem::take(&mut multi_cell_body.tiles);
        tiles.clear();
        for row in (first[1] + 1..=last[1] + 1).step_by(3) {
            for column in (first[0] + 1..=last[0] + 1).step_by(3) {
                if matters([[column - 1, row - 1], [column + 1, row + 1]]) {
                    tiles.push(folded([column, row]));
                }
            }
        }
        self.multi_cell.list[index].tiles = tiles;
        self.enter_cells(index, cells);
    }

    /// Lists a body in these cells.
    fn enter_cells(&mut self, index: usize, cells: Vec<Listed>) {
        let body = self.multi_cell.list[index].body;
        for &cell in &cells {
            self.multi_cell.covered.enter(cell.index, Listed { index: body, image: cell.image });
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
        let own_index = index as u32;
        let mut neighbours = std::mem::take(&mut multi_cell.list[index].neighbours);
        let multi_cell_body = &multi_cell.list[index];
        for cell in &multi_cell_body.cells {
            for place in 0..multi_cell.covered.count(cell.index) {
                let other = multi_cell.covered.get(cell.index, place);
                let image = [0, 1].map(|axis| cell.image[axis] - other.image[axis]);
                let found = Listed { index: multi_cell.index_of[other.index as usize].index() as u32, image };
                let there = &multi_cell.list[found.index as usize];
                if found.index == own_index
                    || (multi_cell_body.fixed && there.fixed)
                    || neighbours.contains(&found)
                {
                    continue;
                }
                let shift = bounds.shift(image.map(i64::from));
                let near = match (&multi_cell_body.wall, &there.wall) {
                    (Some(wall), _) => near_wall(wall, there, shift),
                    (None, Some(wall)) => near_wall(wall, multi_cell_body, -shift),
                    (None, None) => {
                        let reach =
                            (multi_cell_body.radius + there.radius + multi_cell_body.shell + there.shell)
                                * MARGIN;
                        (there.centre + shift - multi_cell_body.centre).length_squared() <= reach * reach
                    }
                };
                if near {
                    neighbours.push(found);
                }
            }
        }
        for neighbour in &neighbours {
            let image = neighbour.image.map(|boxes| -boxes);
            multi_cell.list[neighbour.index as usize].neighbours.push(Listed { index: own_index, image });
        }
        multi_cell.list[index].neighbours = neighbours;
    }
}
