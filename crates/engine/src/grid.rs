//! The cell list: which bodies' centres lie in which cell of a grid, and through which image cells touch.

use glam::DVec2;
use smallvec::SmallVec;

use crate::{
    GridError, World,
    wall::{StandingWall, folded},
};

/// How many cells a side the box is divided into.
#[doc(alias = "fineness")]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CellsPerSide {
    /// As many as are safe, and no more than pay.
    #[default]
    Automatic,
    /// This many along each side; refused if two bodies could touch from cells that are not adjacent.
    Given(u32),
    /// This many, even if two bodies can then touch from cells that are not adjacent: **contacts are missed**, as in the
    /// grid that the thesis chose by its speed. Only for measuring what that costs.
    Unchecked(u32),
}

/// The most cells along a side.
const FINEST: u32 = 4096;

/// A grid of cells over the box, with the bodies in them.
///
/// Walls stand in lists of their own, in every cell from which something can touch them, however long they are. Two other
/// bodies can touch only while their centres lie in the same or in adjacent cells, because a cell is at
/// least as long as the largest sum of two bounding radii. With fewer than three cells a side a cell is its
/// own neighbour through the border, so that the walk over the 3 × 3 cells around a body names every image
/// of every other that it can touch.
#[derive(Debug, Clone, Default)]
pub struct Grid {
    counts: [i32; 2],
    side: DVec2,
    cells: Vec<SmallVec<[u32; 6]>>,
    place: Vec<[i32; 2]>,
    /// Which walls something in a cell may touch, and how many boxes over they appear; empty where there are no walls.
    walls: Vec<NearWalls>,
}

/// Walls near a cell, with the images in which they appear there.
type NearWalls = SmallVec<[(u32, [i32; 2]); 2]>;

/// A cell next to (or the same as) another, and the image through which they touch, in boxes.
#[derive(Debug, Clone, Copy)]
pub struct Neighbour<'a> {
    /// The bodies in it.
    pub bodies: &'a [u32],
    /// How many boxes over they appear.
    pub image: [i32; 2],
}

/// A step of a body into the next cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Step {
    /// 0 for x, 1 for y.
    pub axis: usize,
    /// +1 or −1.
    pub direction: i32,
}

/// The share of the longer side of the box at which two bodies must at least touch. Places are rounded by some 1e-16 of
/// the side, by some times more in the longer epochs of a few bodies: below this share by more than some thousandths or hundredths
/// of that distance, and directions of impulses by as much.
const SMALLEST_SHARE: f64 = 1e-13;

impl Grid {
    /// How many cells each side gets.
    ///
    /// # Errors
    /// [`GridError`] if the fineness asked for is not safe, or no fineness is.
    pub fn counts_for(world: &World, fineness: CellsPerSide) -> Result<[i32; 2], GridError> {
        let sides = world.bounds().sides();
        let side = sides.min_element();
        let (reach, bodies) = world.farthest_reaching().unwrap_or_default();
        // The first of the pair is the largest body that moves.
        let own = world.bodies().get(bodies[0]).filter(|body| !body.is_fixed());
        let own_image = own.map_or(0.0, |body| 2.0 * body.molecule().bounding_radius());
        // A molecule of that diameter touches its own image for ever; a pair may just fit.
        if own_image >= side {
            return Err(GridError::BoxTooSmall { reach: own_image, side, bodies: [bodies[0]; 2] });
        }
        if reach > side {
            return Err(GridError::BoxTooSmall { reach, side, bodies });
        }
        Self::refuse_large_box(world)?;
        // The rounding of the quotient, and the few roundings by which bounding radii are never too small, must not
        // refuse a cell exactly as long as the reach.
        let safe = |side: f64| {
            if reach > 0.0 {
                (side / reach * (1.0 + 8.0 * f64::EPSILON)).min(f64::from(FINEST)) as u32
            } else {
                FINEST
            }
        };
        let largest = safe(side).max(1);
        match fineness {
            CellsPerSide::Given(fineness) | CellsPerSide::Unchecked(fineness)
                if !(1..=FINEST).contains(&fineness) =>
            {
                Err(GridError::CellsPerSide(fineness))
            }
            CellsPerSide::Given(fineness) if fineness > largest => {
                Err(GridError::TooFine { fineness, largest, reach, bodies })
            }
            CellsPerSide::Given(fineness) | CellsPerSide::Unchecked(fineness) => Ok([fineness as i32; 2]),
            CellsPerSide::Automatic => {
                // About one and a half cells for each body: fewer and lists grow, more and crossings do.
                let bodies = world.bodies().len().max(1) as f64;
                let paying = (sides.x * sides.y / (1.5 * bodies)).sqrt();
                let count = |side: f64| safe(side).min((side / paying).ceil() as u32).max(1) as i32;
                Ok([count(sides.x), count(sides.y)])
            }
        }
    }

    /// Refuses a box in which the rounding of places would show in the contacts of the smallest
    /// bodies.
    pub(crate) fn refuse_large_box(world: &World) -> Result<(), GridError> {
        let side = world.bounds().sides().max_element();
        match world.closest_touching() {
            Some((reach, bodies)) if reach < SMALLEST_SHARE * side => {
                Err(GridError::BoxTooLarge { reach, side, bodies })
            }
            _ => Ok(()),
        }
    }

    /// Sorts all bodies into the cells of their positions.
    pub fn fill(&mut self, world: &World, counts: [i32; 2]) {
        let sides = world.bounds().sides();
        self.counts = counts;
        self.side = DVec2::new(sides.x / f64::from(counts[0]), sides.y / f64::from(counts[1]));
        let total = (counts[0] * counts[1]) as usize;
        self.cells.truncate(total);
        self.cells.iter_mut().for_each(SmallVec::clear);
        self.cells.resize_with(total, SmallVec::new);
        self.place.clear();
        for (index, motion) in world.motions().iter().enumerate() {
            let cell = |x: f64, side: f64, count: i32| ((x / side) as i32).clamp(0, count - 1);
            let place = [
                cell(motion.position.x, self.side.x, counts[0]),
                cell(motion.position.y, self.side.y, counts[1]),
            ];
            self.place.push(place);
            if world.bodies()[index].is_wall() {
                continue;
            }
            self.cells[(place[1] * counts[0] + place[0]) as usize].push(index as u32);
        }
        self.list_walls(world);
    }

    /// Lists each wall in every cell that can hold the centre of a body that touches it.
    fn list_walls(&mut self, world: &World) {
        self.walls.clear();
        let reach = world.largest_moving_radius();
        for (index, (body, motion)) in world.bodies().iter().zip(world.motions()).enumerate() {
            let Some(wall) = StandingWall::of(body, motion) else { continue };
            self.walls.resize_with(self.cells.len(), SmallVec::new);
            for cell in wall.cells_within(reach, self.side) {
                let ([column, row], image) = folded(cell, self.counts.map(i64::from));
                let list = &mut self.walls[(row * i64::from(self.counts[0]) + column) as usize];
                // The cell lies `image` boxes over from the wall, hence the wall the other way from the cell.
                list.push((index as u32, image.map(|boxes| -boxes)));
            }
        }
    }

    /// The walls that a body may touch from its cell, with their images.
    pub fn walls(&self, body: u32) -> &[(u32, [i32; 2])] {
        let [column, row] = self.place(body);
        self.walls.get((row * self.counts[0] + column) as usize).map_or(&[], SmallVec::as_slice)
    }

    /// Memory kept on the heap (bytes).
    pub fn heap_bytes(&self) -> usize {
        let spilled: usize = self
            .cells
            .iter()
            .filter(|cell| cell.spilled())
            .map(|cell| cell.capacity() * size_of::<u32>())
            .sum();
        self.cells.capacity() * size_of::<SmallVec<[u32; 6]>>()
            + self.walls.capacity() * size_of::<NearWalls>()
            + self.place.capacity() * size_of::<[i32; 2]>()
            + spilled
    }

    /// The cell of a body, as column and row.
    pub fn place(&self, body: u32) -> [i32; 2] {
        self.place[body as usize]
    }

    /// Lower corner of a cell (length).
    pub fn corner(&self, place: [i32; 2]) -> DVec2 {
        DVec2::new(f64::from(place[0]) * self.side.x, f64::from(place[1]) * self.side.y)
    }

    /// Upper corner of a cell (length).
    pub fn far_corner(&self, place: [i32; 2]) -> DVec2 {
        self.corner([place[0] + 1, place[1] + 1])
    }

    /// The 3 × 3 cells around a body.
    pub fn around(&self, body: u32) -> impl Iterator<Item = Neighbour<'_>> {
        let [x, y] = self.place(body);
        (-1..=1).flat_map(move |dy| (-1..=1).map(move |dx| self.neighbour([x + dx, y + dy])))
    }

    /// The three cells that became adjacent by a step.
    pub fn ahead(&self, body: u32, step: Step) -> impl Iterator<Item = Neighbour<'_>> {
        let mut centre = self.place(body);
        centre[step.axis] += step.direction;
        (-1..=1).map(move |sideways| {
            let mut cell = centre;
            cell[1 - step.axis] += sideways;
            self.neighbour(cell)
        })
    }

    fn neighbour(&self, mut cell: [i32; 2]) -> Neighbour<'_> {
        let mut image = [0; 2];
        for axis in 0..2 {
            if cell[axis] < 0 {
                cell[axis] += self.counts[axis];
                image[axis] = -1;
            } else if cell[axis] >= self.counts[axis] {
                cell[axis] -= self.counts[axis];
                image[axis] = 1;
            }
        }
        Neighbour { bodies: &self.cells[(cell[1] * self.counts[0] + cell[0]) as usize], image }
    }

    /// Moves a body into the next cell; tells how many boxes it has wrapped along the axis.
    pub fn enter(&mut self, body: u32, step: Step) -> i32 {
        let place = &mut self.place[body as usize];
        let old = (place[1] * self.counts[0] + place[0]) as usize;
        let mut wrapped = 0;
        place[step.axis] += step.direction;
        if place[step.axis] < 0 {
            place[step.axis] += self.counts[step.axis];
            wrapped = -1;
        } else if place[step.axis] >= self.counts[step.axis] {
            place[step.axis] -= self.counts[step.axis];
            wrapped = 1;
        }
        let new = (place[1] * self.counts[0] + place[0]) as usize;
        if new != old {
            if let Some(slot) = self.cells[old].iter().position(|&member| member == body) {
                self.cells[old].swap_remove(slot);
            }
            self.cells[new].push(body);
        }
        wrapped
    }
}
