//! How the box is divided into tiles that are run on their own, and the counts of this work.

use std::fmt;

/// How the box is divided into tiles of cells, which are run on their own and on several threads.
///
/// No choice changes a bit of the results, and a number out of its range counts as the nearest in
/// it. Tiles are used for discs or molecules of similar size, also among walls and fixed bodies;
/// other scenes, and parts of a run in which tiles do not pay, are run event by event on one
/// thread. See [`TileCounters`] for what was done.
///
/// ```
/// use carom_engine::{Scene, Simulation, Tiling};
///
/// let gas = "[[gas]]\nradius = 0.002\nmass = 1.0\nenergy = 1.0\ncount = 20000";
/// let scene = Scene::from_toml(gas)?;
/// let mut serial = Simulation::new(&scene)?;
/// serial.set_tiling(&Tiling::NONE);
/// serial.run_until(0.02)?;
/// let mut parallel = Simulation::new(&scene)?;
/// parallel.set_tiling(&Tiling { threads: 2, least_bodies: 1, side: 50, ..Tiling::NONE });
/// parallel.run_until(0.02)?;
/// assert!(parallel.tile_counters().windows > 0);
/// let motions = |simulation: &Simulation| -> Vec<_> {
///     simulation.view().bodies().map(|body| body.motion).collect()
/// };
/// assert_eq!(motions(&serial), motions(&parallel));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tiling {
    /// Threads. 0 counts as 1.
    pub threads: usize,
    /// Fewest bodies for which tiles are used, on any number of threads, if only discs move.
    pub least_bodies: usize,
    /// Fewest bodies if molecules move. Each of their contacts takes longer than one of discs.
    pub least_molecules: usize,
    /// Cells along a side of a tile, at least 8; a cell is about as long as two bodies
    /// reach. Fewer: more bodies are run twice, in the borders of tiles. More: a tile outgrows the
    /// cache.
    pub side: u32,
    /// Length of a window in mean free times, from 0.1 to 64. Shorter: bodies are copied more
    /// often. Longer: wider borders.
    pub window: f64,
    /// Cells by which the border of a tile is wider than an influence travels in a window, from 1
    /// to 64. Fewer: more tiles are repeated. More: more bodies are run twice.
    pub margin: u32,
    /// Cells that an influence travels in a mean free time, from 0.1 to 64. Fewer: more tiles are
    /// repeated. More: wider borders.
    pub front: f64,
}

impl Tiling {
    /// No tiles: every contact in order, on one thread.
    pub const NONE: Self = Self {
        threads: 1,
        least_bodies: usize::MAX,
        least_molecules: usize::MAX,
        side: 200,
        window: 4.0,
        margin: 7,
        front: 2.5,
    };

    /// The best division that is known for a number of threads.
    ///
    /// On one thread, tiles pay from the size on at which the bodies outgrow the caches: 0.57, 0.90
    /// and 1.29 times as fast as in order at 150 000, 300 000 and 600 000 discs (`cargo xtask bench
    /// tiles`). On more, they pay earlier: two threads make up for the work that is done twice.
    pub fn with_threads(threads: usize) -> Self {
        let (least_bodies, least_molecules) = match threads {
            0 | 1 => (400_000, 400_000),
            2 | 3 => (150_000, 20_000),
            _ => (30_000, 20_000),
        };
        Self {
            threads,
            least_bodies,
            least_molecules,
            ..Self::NONE
        }
    }

    /// The nearest division that can be used.
    pub(crate) fn within_bounds(&self) -> Self {
        let within = |number: f64, least: f64, most: f64, default: f64| {
            if number.is_nan() {
                default
            } else {
                number.clamp(least, most)
            }
        };
        Self {
            window: within(self.window, 0.1, 64.0, Self::NONE.window),
            front: within(self.front, 0.1, 64.0, Self::NONE.front),
            margin: self.margin.clamp(1, 64),
            ..*self
        }
    }

    /// The side of tiles for a grid: shorter than [`Self::side`] if there were fewer than two along
    /// an axis, or too few for the threads.
    pub(crate) fn side_for(&self, counts: [u32; 2]) -> u32 {
        let threads = self.threads.max(1) as f64;
        let fair = (f64::from(counts[0]) * f64::from(counts[1]) / (2.0 * threads)).sqrt();
        // Two tiles, to the nearest whole number.
        let longest = counts[0].min(counts[1]) / 3 * 2;
        self.side
            .min(fair.min(f64::from(longest)).max(MIN_SIDE) as u32)
            .max(8)
    }
}

/// Shortest side of a tile that is chosen for many threads, in cells.
const MIN_SIDE: f64 = 40.0;

impl Default for Tiling {
    fn default() -> Self {
        Self::with_threads(1)
    }
}

/// Counts of the work in tiles. They depend on [`Tiling`] and on the machine, never the results.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct TileCounters {
    /// Windows that were run in tiles; one that is run ahead of frequent stops counts at its end.
    pub windows: u64,
    /// Runs of a tile.
    pub tiles: u64,
    /// Of these, runs that were repeated with a wider border, because two tiles disagreed.
    pub repeated: u64,
    /// Contacts computed, including those in borders and in repeated runs.
    pub computed: u64,
    /// Contacts of the results.
    pub contacts: u64,
    /// Windows that were run again up to the end of the epoch.
    pub cut: u64,
    /// Windows that were run ahead of frequent stops, and were not requested up to their end.
    pub given_up: u64,
    /// Windows that were run event by event after all, because of contacts at one instant, tiles
    /// that disagreed repeatedly, or bodies that became too fast.
    pub refused: u64,
}

/// The work of one tile in the last window.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct TileWork {
    /// Wall time of its last run (seconds).
    pub seconds: f64,
    /// Contacts in its own cells.
    pub contacts: u64,
    /// Contacts computed, including those in its border.
    pub computed: u64,
    /// Size of the bodies that were copied from other tiles (bytes).
    pub copied_bytes: usize,
    /// Size of the logs that are compared with those of other tiles (bytes).
    pub log_bytes: usize,
}

impl std::ops::Add for TileCounters {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            windows: self.windows + other.windows,
            tiles: self.tiles + other.tiles,
            repeated: self.repeated + other.repeated,
            computed: self.computed + other.computed,
            contacts: self.contacts + other.contacts,
            cut: self.cut + other.cut,
            given_up: self.given_up + other.given_up,
            refused: self.refused + other.refused,
        }
    }
}

/// Whether a system is divided into tiles, and if not, why.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum TileUse {
    /// It is, into so many.
    Tiles(usize),
    /// [`Tiling::NONE`], or fewer bodies than [`Tiling::least_bodies`] or
    /// [`Tiling::least_molecules`].
    FewBodies(usize),
    /// Fewer than two tiles with their borders fit along a side.
    SmallBox,
    /// Bodies larger than a cell move: large discs, or molecules among discs.
    LargeBodies,
    /// A wall has a temperature: each contact with it draws the next number of one sequence.
    ThermalWalls,
    /// Bodies may react at contacts, each of which draws the next number of one sequence.
    Reactions,
    /// A piston moves, a wall that contacts push.
    Pistons,
    /// Images above and below move, so that the cells across the seam slide.
    Shear,
    /// Bodies are tied to each other: a tether acts across borders of tiles.
    Tethers,
    /// Discs have wells, whose steps act across borders of tiles.
    Wells,
    /// A dilute gas, whose discs live in cells of several.
    Dilute,
    /// The detector does not use the closed form for two discs.
    Detector,
    /// The scheduler has no tiles.
    Scheduler,
}

impl fmt::Display for TileUse {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let reason = match self {
            Self::Tiles(tiles) => return write!(f, "{tiles} tiles"),
            Self::FewBodies(usize::MAX) => "not requested",
            Self::FewBodies(least) => return write!(f, "none: they pay from {least} bodies on"),
            Self::SmallBox => "too few cells",
            Self::LargeBodies => "bodies larger than a cell move",
            Self::ThermalWalls => "a wall has a temperature",
            Self::Reactions => "bodies may react at contacts",
            Self::Shear => "the box is sheared",
            Self::Tethers => "bodies are tethered to each other",
            Self::Pistons => "a piston moves",
            Self::Wells => "discs have wells",
            Self::Dilute => "a dilute gas",
            Self::Detector => "a detector without the closed form",
            Self::Scheduler => "a scheduler without tiles, or a box of few cells",
        };
        write!(f, "none: {reason}")
    }
}
