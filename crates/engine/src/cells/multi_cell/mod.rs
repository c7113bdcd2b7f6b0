//! Covering bodies: molecules among discs, whatever is large, fixed bodies, each with a shell and a list of the cells it
//! may touch.
//!
//! A covering body has a *shell*, a circle round the place where it was last listed. It stands in the list of every cell
//! that can hold the centre of a small disc it might touch while its own centre is in the shell: every cell within
//! R + r_largest + h of the shell's centre, but for those wholly within R − h of a disc's. Leaving the shell is an event that lists it anew. Two covering bodies keep
//! each other as neighbours while their shells' centres are within R + R' + h + h'; all with the image through which
//! they see each other. A fixed body has no shell, is listed once, and has no events. Of a wall only the surroundings of
//! its face count, however long it is: see `walls`.

mod covered;
mod large_disc;
mod search;

use carom_geometry::PeriodicBox;
use carom_kinematics::Motion;
use glam::DVec2;

use self::covered::CoveredCells;
pub(super) use self::search::Soonest;
use super::{State, candidates::Candidates, walls::near_wall};
use crate::{Body, World, scheduler::Parts, wall::StandingWall};

/// Column of a record whose body lives in no cell.
const NO_CELL: u16 = u16::MAX;

/// Lists reach this much farther than they need to, so that no rounding makes them shorter.
const MARGIN: f64 = 1.0 + 1e-12;

/// All covering bodies of the system; empty, and never asked, where there are none.
#[derive(Debug, Clone, Default)]
pub(super) struct MultiCellBodies {
    list: Vec<Covering>,
    /// Place in `list` by body.
    index_of: Vec<u32>,
    /// What the contact is that a body's event of kind `Covering` announces, by body.
    pending: Vec<Pending>,
    /// Which of them are listed in a cell, by their bodies.
    covered: CoveredCells,
    /// Whether there are any that are no discs among discs.
    has_molecules: bool,
    around: Surroundings,
}

/// Scratch space: who stands around a covering body.
#[derive(Debug, Clone, Default)]
struct Surroundings {
    /// Bodies that it sees in its own box.
    slots: Vec<u32>,
    /// The others.
    seen: Vec<Listed>,
    candidates: Candidates<Listed>,
}

/// A body, and how many boxes over something in its frame appears (or it does in another's).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Listed {
    /// A covering body's place in the list of covering bodies, or a body's index; a cell.
    pub who: u32,
    pub image: [i32; 2],
}

#[derive(Debug, Clone, Copy)]
struct Pending {
    parts: Parts,
    /// Image of the second body relative to the first along their paths without periodic jumps, as far as 16 bits go.
    image: [i16; 2],
}

#[derive(Debug, Clone)]
pub(super) struct Covering {
    body: u32,
    fixed: bool,
    /// Whether those in the cells meet it as discs meet a disc.
    is_disc_among_discs: bool,
    /// The wall that it is, if it is one.
    wall: Option<StandingWall>,
    /// Bounding radius (length).
    pub radius: f64,
    motion: Motion,
    /// Centre and radius of the shell (length).
    pub centre: DVec2,
    pub shell: f64,
    /// Cells it is listed in, with the image in which their discs appear in its frame.
    cells: Vec<Listed>,
    /// Cells whose neighbourhood lists together hold every disc that can be in `cells`, with the image likewise.
    tiles: Vec<Listed>,
    /// Covering bodies that it might touch, with the image in which they appear in its frame.
    neighbours: Vec<Listed>,
}

impl MultiCellBodies {
    pub fn clear(&mut self) {
        self.list.clear();
        self.index_of.clear();
        self.pending.clear();
        self.has_molecules = false;
    }

    /// Makes room for what the contacts of so many bodies are.
    pub fn expect_contacts(&mut self, bodies: usize) {
        self.pending.resize(bodies, Pending::NOTHING);
    }

    /// Adds a body; `among_molecules` if those in the cells are no discs.
    pub fn add(&mut self, index: u32, body: &Body, motion: &Motion, bodies: usize, among_molecules: bool) {
        self.index_of.resize(bodies, u32::MAX);
        self.expect_contacts(bodies);
        self.index_of[index as usize] = self.list.len() as u32;
        let is_disc_among_discs = body.kind.molecule.is_disc() && !among_molecules;
        self.has_molecules |= !is_disc_among_discs;
        self.list.push(Covering {
            body: index,
            fixed: body.is_fixed(),
            is_disc_among_discs,
            wall: StandingWall::of(body, motion),
            radius: body.kind.molecule.bounding_radius(),
            motion: *motion,
            centre: motion.position,
            shell: 0.0,
            cells: Vec::new(),
            tiles: Vec::new(),
            neighbours: Vec::new(),
        });
    }

    /// Whether all are discs among discs.
    #[inline]
    pub fn are_large_discs(&self) -> bool {
        !self.has_molecules
    }

    #[inline(always)]
    pub fn is_covering(&self, body: u32) -> bool {
        self.get(body).is_some()
    }

    #[inline(always)]
    pub fn is_fixed(&self, body: u32) -> bool {
        self.get(body).is_some_and(|index| self.list[index].fixed)
    }

    pub fn heap_bytes(&self) -> usize {
        let of = |covering: &Covering| {
            covering.cells.capacity() + covering.tiles.capacity() + covering.neighbours.capacity()
        };
        let listed: usize = self.list.iter().map(of).sum();
        self.list.capacity() * size_of::<Covering>()
            + listed * size_of::<Listed>()
            + self.index_of.capacity() * size_of::<u32>()
            + self.pending.capacity() * size_of::<Pending>()
            + self.covered.heap_bytes()
    }

    /// Takes over the new motion of a body, if it is one of these.
    #[inline]
    pub fn set_motion(&mut self, body: u32, motion: &Motion) {
        if let Some(index) = self.get(body) {
            self.list[index].motion = *motion;
        }
    }

    /// Takes over the new flight of a body whose orientation and spin stay as they are, if it is one of these.
    #[inline]
    pub fn set_flight(&mut self, body: u32, time: f64, position: DVec2, velocity: DVec2) {
        if let Some(index) = self.get(body) {
            let motion = &mut self.list[index].motion;
            *motion = Motion { position, velocity, ..motion.at(time) };
        }
    }

    /// The motion of a body, if it is one of these.
    #[inline]
    pub fn motion(&self, body: u32) -> Option<&Motion> {
        self.get(body).map(|index| &self.list[index].motion)
    }

    #[inline(always)]
    fn get(&self, body: u32) -> Option<usize> {
        self.index_of.get(body as usize).filter(|&&index| index != u32::MAX).map(|&index| index as usize)
    }
}

impl Surroundings {
    fn clear(&mut self) {
        self.slots.clear();
        self.seen.clear();
        self.candidates.clear();
    }
}

impl Pending {
    const NOTHING: Self = Self { parts: Parts::Discs, image: [0; 2] };
}

impl State {
    /// Lists every covering body, at the start of an epoch.
    pub(super) fn list_all(&mut self, world: &World) {
        let count = self.multi_cell.list.len();
        if count == 0 {
            return;
        }
        let [columns, rows] = self.grid.counts();
        self.multi_cell.covered.lay_out((columns * rows) as usize);
        for index in 0..count {
            let body = self.multi_cell.list[index].body;
            self.records[body as usize].set_cell([NO_CELL; 2]);
            self.list(world, index, 0.0);
        }
    }

    /// A covering body has left its shell.
    #[cold]
    pub(super) fn leave_shell(&mut self, world: &World, body: u32, now: f64) {
        if let Some(index) = self.multi_cell.get(body) {
            self.list(world, index, now);
        }
    }

    /// Lists a covering body where it is now.
    fn list(&mut self, world: &World, index: usize, now: f64) {
        self.unlist(index);
        let bounds = world.bounds();
        let covering = &mut self.multi_cell.list[index];
        let body = covering.body as usize;
        let (place, image) = bounds.wrap(covering.motion.position_at(now));
        if image != [0, 0] && !covering.fixed {
            covering.motion.position -= bounds.shift(image);
            self.records[body].set_motion(&covering.motion);
            let winding = &mut self.windings[body];
            *winding = [0, 1].map(|axis| winding[axis].wrapping_add(image[axis] as i16));
            self.wrapped.push(body as u32);
        }
        covering.centre = place;
        let small = self.grid.largest_small();
        covering.shell = if covering.fixed { 0.0 } else { small.min(covering.radius.max(0.5 * small)) };
        self.cover_cells(index);
        self.find_neighbours(bounds, index);
    }

    fn unlist(&mut self, index: usize) {
        let me = index as u32;
        let body = self.multi_cell.list[index].body;
        // Taken out and put back: what is listed again needs no new memory.
        let mut cells = std::mem::take(&mut self.multi_cell.list[index].cells);
        for listed in cells.drain(..) {
            if self.multi_cell.covered.leave(listed.who, body) {
                self.neighbour_lists.set_covered(listed.who, false);
            }
        }
        let mut neighbours = std::mem::take(&mut self.multi_cell.list[index].neighbours);
        for neighbour in neighbours.drain(..) {
            self.multi_cell.list[neighbour.who as usize].neighbours.retain(|entry| entry.who != me);
        }
        let covering = &mut self.multi_cell.list[index];
        (covering.cells, covering.neighbours) = (cells, neighbours);
    }

    /// Lists a body in every cell within its radius, the largest small disc's and its shell's of its place; a disc not in those that
    /// are wholly inside it while it is in its shell.
    fn cover_cells(&mut self, index: usize) {
        if let Some(wall) = self.multi_cell.list[index].wall {
            let cells = self.cells_of_wall(&wall);
            self.list_in(index, cells);
            return;
        }
        let side = self.grid.side();
        let counts = self.grid.counts().map(i64::from);
        let covering = &self.multi_cell.list[index];
        let reach = (covering.radius + self.grid.largest_small() + covering.shell) * MARGIN;
        let centre = covering.centre;
        let first = ((centre - reach) / side).floor();
        let last = ((centre + reach) / side).floor();
        // No centre of another comes nearer to a disc than its rim.
        let rim =
            if covering.is_disc_among_discs { (covering.radius - covering.shell).max(0.0) } else { 0.0 };
        // Whether a block of cells is near enough for such a centre, but not wholly inside the disc.
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
            Listed { who: (row * counts[0] + column) as u32, image }
        };
        let (first, last) = ([first.x as i64, first.y as i64], [last.x as i64, last.y as i64]);
        let covering = &mut self.multi_cell.list[index];
        let mut cells = std::mem::take(&mut covering.cells);
        for row in first[1]..=last[1] {
            for column in first[0]..=last[0] {
                if matters([[column, row]; 2]) {
                    cells.push(folded([column, row]));
                }
            }
        }
        let mut tiles = std::mem::take(&mut covering.tiles);
        tiles.clear();
        for row in (first[1] + 1..=last[1] + 1).step_by(3) {
            for column in (first[0] + 1..=last[0] + 1).step_by(3) {
                if matters([[column - 1, row - 1], [column + 1, row + 1]]) {
                    tiles.push(folded([column, row]));
                }
            }
        }
        self.multi_cell.list[index].tiles = tiles;
        self.list_in(index, cells);
    }

    /// Lists a body in these cells.
    fn list_in(&mut self, index: usize, cells: Vec<Listed>) {
        let body = self.multi_cell.list[index].body;
        for &cell in &cells {
            self.multi_cell.covered.enter(cell.who, Listed { who: body, image: cell.image });
            self.neighbour_lists.set_covered(cell.who, true);
        }
        self.multi_cell.list[index].cells = cells;
    }

    /// Finds the covering bodies that this one might touch, among those listed in its cells. Circles of radius R + h round the
    /// centres of two such shells overlap; neither body reaches into the other, so there is a point in both circles that is no
    /// nearer to the centre of a disc's shell than R − h. Its cell is listed for both.
    fn find_neighbours(&mut self, bounds: &PeriodicBox, index: usize) {
        let multi_cell = &mut self.multi_cell;
        let me = index as u32;
        let mut neighbours = std::mem::take(&mut multi_cell.list[index].neighbours);
        let covering = &multi_cell.list[index];
        for cell in &covering.cells {
            for place in 0..multi_cell.covered.count(cell.who) {
                let other = multi_cell.covered.get(cell.who, place);
                let image = [0, 1].map(|axis| cell.image[axis] - other.image[axis]);
                let found = Listed { who: multi_cell.index_of[other.who as usize], image };
                let there = &multi_cell.list[found.who as usize];
                if found.who == me || (covering.fixed && there.fixed) || neighbours.contains(&found) {
                    continue;
                }
                let shift = bounds.shift(image.map(i64::from));
                let near = match (&covering.wall, &there.wall) {
                    (Some(wall), _) => near_wall(wall, there, shift),
                    (None, Some(wall)) => near_wall(wall, covering, -shift),
                    (None, None) => {
                        let reach = (covering.radius + there.radius + covering.shell + there.shell) * MARGIN;
                        (there.centre + shift - covering.centre).length_squared() <= reach * reach
                    }
                };
                if near {
                    neighbours.push(found);
                }
            }
        }
        for neighbour in &neighbours {
            let image = neighbour.image.map(|boxes| -boxes);
            multi_cell.list[neighbour.who as usize].neighbours.push(Listed { who: me, image });
        }
        multi_cell.list[index].neighbours = neighbours;
    }
}
