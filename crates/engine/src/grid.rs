//! A cell list for boxes of any size: the bodies in each cell, and the images through which cells
//! are adjacent.

use carom_kinematics::Motion;
use glam::DVec2;
use smallvec::SmallVec;

use crate::{
    scene::error::GridError,
    world::{
        World,
        shear::Seam,
        wall::{StandingWall, cells_about, folded, place_during},
    },
};

/// Number of cells along each side of the box, for [`HeapScheduler`](crate::HeapScheduler).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CellsPerSide {
    /// The largest safe number, but no more than the number of bodies justifies.
    #[default]
    Automatic,
    /// This number along each side, from 1 to 4096. Refused if two bodies could touch from cells
    /// that are not adjacent.
    Given(u32),
    /// This number (from 1 to 4096), even if two bodies can touch from cells that are not adjacent:
    /// **contacts are then missed**, as in the thesis, which chose the grid by its speed. For
    /// measurements of this effect only.
    Unchecked(u32),
}

/// Most cells along a side.
const MAX_CELLS_PER_SIDE: u32 = 4096;

/// A grid of cells over the box, with the bodies in them. Under shear the cells are parallelograms
/// that shear with the flow (lemma in `world/shear.rs`).
///
/// Two bodies that are no walls can touch only while their centres lie in the same or in adjacent
/// cells, because a cell is at least as long as the largest sum of two bounding radii. With fewer
/// than three cells a side a cell is its own neighbour through the border, so the 3 × 3 cells
/// around a body give every image of every other body that it can touch. Walls have lists of their
/// own, in every cell from which a body can touch them.
#[derive(Debug, Clone, Default)]
pub struct Grid {
    counts: [i32; 2],
    side: DVec2,
    cells: Vec<SmallVec<[u32; 6]>>,
    place: Vec<[i32; 2]>,
    /// The seam of a sheared box, with which the cells shear.
    seam: Option<Seam>,
    /// The walls that a body in each cell may touch, with the images in which they appear; empty if
    /// there are no walls.
    walls: Vec<NearWalls>,
}

/// Walls near a cell, with the images in which they appear there.
type NearWalls = SmallVec<[(u32, [i32; 2]); 2]>;

/// A cell adjacent to another, or the same cell, and the image through which they are adjacent.
#[derive(Debug, Clone, Copy)]
pub struct Neighbour<'a> {
    /// The bodies in it.
    pub bodies: &'a [u32],
    /// Image in which the bodies appear, in boxes.
    pub image: [i32; 2],
}

/// A crossing of a body into the next cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellStep {
    /// 0 for x, 1 for y.
    pub axis: usize,
    /// +1 or −1.
    pub direction: i32,
}

/// Least contact distance of two bodies, as a share of the longer side of the box. The rounding of
/// a position is about 1e-16 of the side, and several times that in the longer epochs of a few
/// bodies. Below this share it would be more than some thousandths or hundredths of the contact
/// distance, and directions of impulses would be as inexact.
pub const MIN_CONTACT_SHARE: f64 = 1e-13;

/// Largest bounding radius of a fixed body, in shorter sides of the box, where nothing moves. A
/// larger one is most likely an error.
const MAX_FIXED: f64 = 16.0;

/// The largest number of cells along a side in which bodies whose centres are `reach` apart lie in
/// adjacent cells (lengths).
fn safe_count(side: f64, reach: f64) -> u32 {
    if reach > 0.0 {
        // The margin keeps the rounding of the quotient, and the bounding radii, which are rounded
        // up, from refusing a cell that is exactly long enough.
        (side / reach * (1.0 + 8.0 * f64::EPSILON)).min(f64::from(MAX_CELLS_PER_SIDE)) as u32
    } else {
        MAX_CELLS_PER_SIDE
    }
}

impl Grid {
    /// Number of cells along each side.
    ///
    /// # Errors
    /// [`GridError`] if the number asked for is not safe, or if the box is too small or too large
    /// for the bodies.
    pub fn counts_for(world: &World, cells: CellsPerSide) -> Result<[i32; 2], GridError> {
        let (reach, bodies) = world.farthest_reaching().unwrap_or_default();
        // Cells that shear are longer than two bodies reach.
        let sides = world.bounds().sides();
        let shortened = sides / DVec2::new(world.stretch_of_cells(), 1.0);
        Self::refuse_small_box(world, shortened.min_element(), reach, bodies)?;
        for (index, body) in world.bodies().iter().enumerate() {
            Self::refuse_giant(body.reach(), index, world)?;
        }
        Self::refuse_large_box(world)?;
        let [across, up] = shortened.to_array();
        let largest = safe_count(across.min(up), reach).max(1);
        match cells {
            CellsPerSide::Given(cells) | CellsPerSide::Unchecked(cells)
                if !(1..=MAX_CELLS_PER_SIDE).contains(&cells) =>
            {
                Err(GridError::CellsPerSide(cells))
            }
            CellsPerSide::Given(cells) if cells > largest => Err(GridError::TooFine {
                cells_per_side: cells,
                largest,
                reach,
                bodies,
            }),
            CellsPerSide::Given(cells) | CellsPerSide::Unchecked(cells) => Ok([cells as i32; 2]),
            CellsPerSide::Automatic => {
                // About one and a half cells for each body: fewer lengthen the lists, more add
                // crossings.
                let bodies = world.bodies().len().max(1) as f64;
                let paying = (sides.x * sides.y / (1.5 * bodies)).sqrt();
                let count = |side: f64| {
                    let paying = (side / paying).ceil() as u32;
                    safe_count(side, reach).min(paying).max(1) as i32
                };
                Ok([count(across), count(up)])
            }
        }
    }

    /// Refuses a box in which a molecule could touch its own image, or whose shorter side for cells
    /// is below `reach`, the largest distance at which two `bodies` touch (lengths).
    fn refuse_small_box(
        world: &World,
        for_cells: f64,
        reach: f64,
        bodies: [usize; 2],
    ) -> Result<(), GridError> {
        let side = world.bounds().sides().min_element();
        // The first of the pair is the largest body that moves.
        let own = world.bodies().get(bodies[0]).filter(|body| body.is_free());
        let own_image = own.map_or(0.0, |body| 2.0 * body.molecule().bounding_radius());
        // A molecule of that diameter would always touch its own image. A pair may be exactly as
        // long as the box.
        if own_image >= side {
            return Err(GridError::BoxTooSmall {
                reach: own_image,
                side,
                bodies: [bodies[0]; 2],
            });
        }
        if reach > for_cells {
            return Err(GridError::BoxTooSmall {
                reach,
                side,
                bodies,
            });
        }
        Ok(())
    }

    /// Refuses a body of this reach (length) that covers many images of the box. Where nothing
    /// moves, a body may cover the box, but it is listed in every image of a cell that it covers.
    pub(crate) fn refuse_giant(reach: f64, body: usize, world: &World) -> Result<(), GridError> {
        let side = world.bounds().sides().min_element();
        if reach > MAX_FIXED * side {
            return Err(GridError::BoxTooSmall {
                reach,
                side,
                bodies: [body; 2],
            });
        }
        Ok(())
    }

    /// Refuses a box in which the rounding of positions would be visible in the contacts of the
    /// smallest bodies.
    pub(crate) fn refuse_large_box(world: &World) -> Result<(), GridError> {
        let side = world.bounds().sides().max_element();
        match world.closest_touching() {
            Some((reach, bodies)) if reach < MIN_CONTACT_SHARE * side => {
                Err(GridError::BoxTooLarge {
                    reach,
                    side,
                    bodies,
                })
            }
            _ => Ok(()),
        }
    }

    /// Sorts all bodies into the cells of their positions in `motions`, for an epoch that ends at
    /// `limit` (offset in it, time): walls that move are listed for the whole epoch.
    pub fn fill(
        &mut self,
        world: &World,
        (motions, windings): (&mut [Motion], &mut [[i64; 2]]),
        counts: [i32; 2],
        limit: f64,
    ) {
        let sides = world.bounds().sides();
        self.counts = counts;
        self.side = DVec2::new(
            sides.x / f64::from(counts[0]),
            sides.y / f64::from(counts[1]),
        );
        let total = (counts[0] * counts[1]) as usize;
        self.cells.truncate(total);
        self.cells.iter_mut().for_each(SmallVec::clear);
        self.cells.resize_with(total, SmallVec::new);
        self.place.clear();
        self.seam = world.seam_at(0.0);
        for (index, motion) in motions.iter_mut().enumerate() {
            let mut across = motion.position.x;
            if let Some(seam) = &self.seam {
                let boxes;
                (across, boxes) = seam.enter_cells(motion);
                windings[index][0] += boxes;
            }
            let cell = |x: f64, side: f64, count: i32| ((x / side) as i32).clamp(0, count - 1);
            let place = [
                cell(across, self.side.x, counts[0]),
                cell(motion.position.y, self.side.y, counts[1]),
            ];
            self.place.push(place);
            if world.bodies()[index].is_wall() || world.drive(index).is_some() {
                continue;
            }
            self.cells[(place[1] * counts[0] + place[0]) as usize].push(index as u32);
        }
        self.list_walls(world, limit);
    }

    /// The seam of a sheared box.
    pub fn seam(&self) -> Option<&Seam> {
        self.seam.as_ref()
    }

    /// Lists each wall but pistons, and each other fixed body that is driven, in every cell that
    /// can hold the centre of a body that touches it before `limit` (offset in the epoch, time).
    fn list_walls(&mut self, world: &World, limit: f64) {
        self.walls.clear();
        let reach = world.largest_moving_radius();
        for (index, (body, motion)) in world.bodies().iter().zip(world.motions()).enumerate() {
            let drive = world.drive(index);
            if (!body.is_wall() && drive.is_none()) || body.is_piston() {
                continue;
            }
            let (middle, way) = place_during(body, motion, drive.as_ref(), [0.0, limit]);
            let reach = reach + way;
            let cells = if let Some(wall) = StandingWall::new(body, &middle) {
                wall.cells_within(reach, self.side)
            } else {
                let reach = reach + body.molecule().bounding_radius();
                cells_about(middle.position, reach, self.side)
            };
            self.walls.resize_with(self.cells.len(), SmallVec::new);
            for cell in cells {
                let ([column, row], image) = folded(cell, self.counts.map(i64::from));
                let list = &mut self.walls[(row * i64::from(self.counts[0]) + column) as usize];
                // `image` is that of the cell as seen from the wall; the other way it has the
                // opposite sign.
                list.push((index as u32, image.map(|boxes| -boxes)));
            }
        }
    }

    /// The walls that a body may touch from its cell, with their images.
    pub fn walls(&self, body: u32) -> &[(u32, [i32; 2])] {
        let [column, row] = self.place(body);
        self.walls
            .get((row * self.counts[0] + column) as usize)
            .map_or(&[], SmallVec::as_slice)
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
        DVec2::new(
            f64::from(place[0]) * self.side.x,
            f64::from(place[1]) * self.side.y,
        )
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

    /// The three cells that became adjacent by a crossing that the body has just made.
    pub fn ahead(&self, body: u32, step: CellStep) -> impl Iterator<Item = Neighbour<'_>> {
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
        Neighbour {
            bodies: &self.cells[(cell[1] * self.counts[0] + cell[0]) as usize],
            image,
        }
    }

    /// Moves a body into the next cell, and returns the number of boxes by which it is wrapped
    /// along the axis.
    pub fn enter(&mut self, body: u32, step: CellStep) -> i32 {
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
