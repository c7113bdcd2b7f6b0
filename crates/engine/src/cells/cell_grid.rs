//! The grid of the cell scheduler: which bodies live in cells, and the size of the cells.
//!
//! Where most bodies that move are molecules, they live in cells, together with any discs; else
//! only discs do.

use glam::DVec2;

use crate::world::{World, body::Body};

/// A grid of at least three cells a side, each at least as long as two small bodies reach.
#[derive(Debug, Clone)]
pub(super) struct CellGrid {
    counts: [u32; 2],
    /// Sides of a cell, and of the box (length).
    side: DVec2,
    box_sides: DVec2,
    /// Largest bounding radius of a body in a cell (length); bodies above it, and of other kinds,
    /// are multi-cell bodies.
    largest_small: f64,
    /// Largest factor on the sum of two radii at a contact.
    largest_factor: f64,
    contents: CellContents,
    /// Whether the motions of bodies in cells are kept beside their records.
    keeps_motions: bool,
}

/// The contents of the cells. They decide how bodies are listed and predicted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CellContents {
    /// Discs, in cells with neighbour lists.
    Discs,
    /// Equal discs at large distances, in cells of a few discs each.
    DiluteDiscs,
    /// Discs of which some do not see each other, or touch at another distance than the sum of
    /// their radii, in cells with neighbour lists.
    DiscsByPair,
    /// Discs of which some have bonds, in cells with neighbour lists.
    TiedDiscs,
    /// Discs in a sheared box, in cells with neighbour lists.
    ShearedDiscs,
    /// Molecules and any small discs, in cells with neighbour lists.
    Molecules,
}

/// A gas of equal discs is dilute if the mean spacing exceeds this many diameters, that is up to an
/// area fraction of 0.074. Smaller: cells are too long for what they hold. Larger: more crossings
/// between two contacts, and more memory.
const DILUTE: f64 = 3.25;

/// Cells for each disc of a dilute gas. A cell holds four on average, half of a block. More: more
/// crossings, and more empty lanes. Fewer: a cell needs a second block too often.
const CELLS_PER_BODY_WHERE_DILUTE: f64 = 0.25;

/// A body is small up to this many times the median radius. Smaller: bodies of a narrow size
/// distribution become multi-cell bodies. Larger: the few large bodies lengthen all cells, and with
/// them all neighbour lists.
const SMALL_IN_MEDIANS: f64 = 2.0;

/// Most cells for each body, of the area that is free for the small bodies. More: more cells are
/// empty, and crossings of these are wasted.
const MAX_CELLS_PER_BODY: f64 = 2.0;

/// [`MAX_CELLS_PER_BODY`] for systems in which no body moves.
const MAX_CELLS_PER_FIXED_BODY: f64 = 0.75;

/// Share by which cells are longer than two discs reach, so that no rounding makes them too short.
const MARGIN: f64 = 1e-9;

impl CellGrid {
    /// A grid for the bodies of this world; none if the box is shorter than three cells.
    pub fn new(world: &World) -> Option<Self> {
        let sides = world.bounds().sides();
        let moving = || world.bodies().iter().filter(|body| body.is_free());
        let discs = moving().filter(|body| body.kind.molecule.is_disc()).count();
        let by_pair = world.pairs.is_active();
        // The search among molecules takes the radii as they are: discs with a factor on their
        // contact distance live in cells of discs.
        let by_diameter = by_pair && world.pairs.changes_distances() && discs > 0;
        let is_sheared = world.is_sheared();
        if is_sheared && by_diameter {
            return None;
        }
        // Of the searches only that among molecules knows of images that move.
        let are_plain_discs = discs == world.bodies().len() && !by_pair && !world.is_tethered();
        let shears_discs = is_sheared && are_plain_discs;
        let holds_molecules =
            is_sheared && !shears_discs || moving().count() > 2 * discs && !by_diameter;
        let mut radii: Vec<f64> = moving()
            .filter(|body| holds_molecules || body.kind.molecule.is_disc())
            .map(|b| b.molecule().bounding_radius())
            .collect();
        radii.sort_by(f64::total_cmp);
        let largest_small = radii.get(radii.len() / 2).map_or(0.0, |median| {
            let small = radii
                .iter()
                .rev()
                .find(|&&radius| radius <= SMALL_IN_MEDIANS * median);
            small.copied().unwrap_or(*median)
        });
        let largest_small = match radii.last() {
            Some(largest) if is_sheared => *largest,
            _ => largest_small,
        };
        let factor = world.pairs.largest_factor();
        let longest = if largest_small > 0.0 {
            factor * (2.0 * largest_small)
        } else {
            median_reach(world)
        };
        let bodies = world.bodies().len().max(1) as f64;
        let equal_radii = radii.len() == world.bodies().len() && radii.first() == radii.last();
        let spacing = (sides.x * sides.y / bodies).sqrt();
        let are_alike = !by_pair && !world.is_tethered() && !is_sheared;
        let is_dilute = equal_radii && !holds_molecules && are_alike && spacing > DILUTE * longest;
        let cells_per_body = match largest_small > 0.0 {
            true if is_dilute => CELLS_PER_BODY_WHERE_DILUTE,
            true => MAX_CELLS_PER_BODY,
            false => MAX_CELLS_PER_FIXED_BODY,
        };
        let contents = match (holds_molecules, is_dilute) {
            (true, _) => CellContents::Molecules,
            (false, true) => CellContents::DiluteDiscs,
            (false, false) if shears_discs => CellContents::ShearedDiscs,
            (false, false) if by_pair => CellContents::DiscsByPair,
            (false, false) if world.is_tethered() => CellContents::TiedDiscs,
            (false, false) => CellContents::Discs,
        };
        let mut grid = Self {
            counts: [0; 2],
            side: sides,
            box_sides: sides,
            largest_small,
            largest_factor: factor,
            contents,
            keeps_motions: holds_molecules || shears_discs || world.keeps_spins,
        };
        let sparse = (grid.free_area(world) / (cells_per_body * bodies)).sqrt();
        let length = (longest * (1.0 + MARGIN)).max(sparse);
        let count = |side: f64| {
            let fitting = (side / (longest * (1.0 + MARGIN))) as u32;
            ((side / length) as u32)
                .max(3.min(fitting))
                .min(u32::from(u16::MAX))
        };
        grid.counts = [count(sides.x / world.stretch_of_cells()), count(sides.y)];
        grid.side = sides / DVec2::from_array(grid.counts.map(f64::from));
        grid.counts.iter().all(|&count| count >= 3).then_some(grid)
    }

    /// Area that is free for the bodies in cells, at least half of the box (length²): cells inside
    /// multi-cell bodies are empty. The whole area where no body lives in a cell.
    fn free_area(&self, world: &World) -> f64 {
        let area = world.bounds().area();
        let multi_cell_bodies = world
            .bodies()
            .iter()
            .filter(|body| self.largest_small > 0.0 && self.is_multi_cell(body));
        (area
            - multi_cell_bodies
                .map(|body| body.molecule().area())
                .sum::<f64>())
        .max(0.5 * area)
    }

    #[inline]
    pub fn contents(&self) -> CellContents {
        self.contents
    }

    /// Whether this is a gas of equal discs at large distances, in cells of a few discs each.
    pub fn is_dilute(&self) -> bool {
        self.contents == CellContents::DiluteDiscs
    }

    /// Whether molecules live in cells.
    pub fn holds_molecules(&self) -> bool {
        self.contents == CellContents::Molecules
    }

    /// Whether the motions of bodies in cells are kept beside their records: those of molecules,
    /// and of discs with spins.
    pub fn keeps_motions(&self) -> bool {
        self.keeps_motions
    }

    pub fn counts(&self) -> [u32; 2] {
        self.counts
    }

    /// The next cell along an axis, upwards or downwards; none at the border of the box.
    #[inline]
    pub fn next(&self, number: u16, axis: usize, direction: i32) -> Option<u16> {
        let next = (i32::from(number) + direction) as u32;
        (next < self.counts[axis]).then_some(next as u16)
    }

    /// Sides of a cell (length).
    pub fn side(&self) -> DVec2 {
        self.side
    }

    /// Sides of the box (length).
    pub fn box_sides(&self) -> DVec2 {
        self.box_sides
    }

    /// Bounding radius of the largest body that may live in a cell (length).
    pub fn largest_small(&self) -> f64 {
        self.largest_small
    }

    /// Largest factor on the sum of two radii at a contact, at least 1.
    pub fn largest_factor(&self) -> f64 {
        self.largest_factor
    }

    /// Whether rules apply to pairs of the discs in the cells.
    pub fn is_by_pair(&self) -> bool {
        self.contents == CellContents::DiscsByPair
    }

    /// Whether a body is a multi-cell body.
    pub fn is_multi_cell(&self, body: &Body) -> bool {
        let may_be_small =
            body.is_free() && (self.holds_molecules() || body.kind.molecule.is_disc());
        !may_be_small || body.kind.molecule.bounding_radius() > self.largest_small
    }

    /// Bounding radius of the bodies in cells, if all have the same (length).
    pub fn common_radius(&self, world: &World) -> Option<f64> {
        self.common_value(world, |body| body.molecule().bounding_radius())
    }

    /// Inverse mass of the bodies in cells, if all have the same (1/mass).
    pub fn common_inverse_mass(&self, world: &World) -> Option<f64> {
        self.common_value(world, |body| body.inertia().inverse_mass)
    }

    /// The value of `of` for the bodies in cells, if all have the same.
    fn common_value(&self, world: &World, of: impl Fn(&Body) -> f64) -> Option<f64> {
        let mut numbers = world
            .bodies()
            .iter()
            .filter(|body| !self.is_multi_cell(body))
            .map(of);
        let first = numbers.next()?;
        numbers.all(|number| number == first).then_some(first)
    }

    pub fn cell_of(&self, place: DVec2) -> [u16; 2] {
        let cell = |x: f64, side: f64, count: u32| ((x / side) as u32).min(count - 1) as u16;
        [
            cell(place.x, self.side.x, self.counts[0]),
            cell(place.y, self.side.y, self.counts[1]),
        ]
    }
}

/// Median bounding diameter of all bodies but walls, for a system in which no body moves (length).
fn median_reach(world: &World) -> f64 {
    let bodies = world.bodies().iter().filter(|body| !body.is_wall());
    let mut radii: Vec<f64> = bodies
        .map(|body| body.kind.molecule.bounding_radius())
        .collect();
    radii.sort_by(f64::total_cmp);
    radii
        .get(radii.len() / 2)
        .map_or(0.0, |median| 2.0 * median)
}
