//! The default scheduler: cell lists, one event a body, and a calendar queue.
//!
//! - **Small discs** live in the cells of a grid. A cell is as long as two of them reach. Each cell
//!   has one neighbour list, of all discs in the 3 × 3 cells around it, so a prediction reads one
//!   list and tests eight discs at a time (`discs`, `neighbour_lists`).
//! - **Discs of a dilute gas** live in larger cells, which hold a few discs each and have no
//!   neighbour lists. A disc keeps its earliest contact while crossings come before it (`dilute`,
//!   `cell_occupants`).
//! - **Molecules** live in cells where most bodies that move are molecules, together with any small
//!   discs (`molecules`). Statements below on discs then hold for every body in a cell, with the
//!   bounding radius as its radius.
//! - **Multi-cell bodies** are all others: molecules among discs, large bodies, fixed bodies. Each
//!   is listed in all cells that it can reach (`multi_cell`).
//!
//! # Prediction
//!
//! A body keeps its earliest event only. It is predicted against all its neighbours exactly when
//! (a) its motion changed, (b) it entered a new cell or was listed in new cells, or (c) its event
//! came due as a re-check, or stale because the partner has changed since. No other body is
//! predicted. In a dilute gas, case (b) tests only the discs that became adjacent (`dilute`).
//!
//! # Lemmas
//!
//! No contact is missed. Two bodies are *related* through an image while their cells are adjacent
//! through it (two discs), while the disc's cell lists the multi-cell body, or while two multi-cell
//! bodies are in each other's lists of neighbours. Below, t is the time of the first contact of a
//! related pair under the present motions, before the end of the epoch.
//!
//! 1. **Contact implies relation.** Two bodies that touch are related, as long as neither has
//!    crossed into another cell or left its shell. *Proof.* A cell is as long as two discs reach. A
//!    multi-cell body of bounding radius R is listed in all cells within R + r_max + h of the
//!    centre of its shell (r_max: radius of the largest disc, h: radius of the shell). If it is a
//!    disc, the cells inside it for every position in its shell are left out; they hold no other
//!    centre. Two multi-cell bodies are neighbours within R + R' + h + h'.
//! 2. **A relation begins with a prediction.** It begins when a body enters a cell or is listed
//!    anew, and this body is predicted right after the lists have changed.
//! 3. **The body predicted last has an event at t or before.** *Proof.* Call this body k. Neither
//!    motion has changed since its prediction, because a body whose motion changes is predicted at
//!    that moment and would be the last. By lemma 2 the relation did not begin later either. So the
//!    partner was a candidate of k. The event of k is the earliest of its contacts, its crossing or
//!    the exit from its shell, and its re-checks, whose times ("certified free until") are before
//!    the contact. A candidate is excluded only if its contact certainly does not precede the event
//!    that k keeps, or the end of the epoch (`f32_filter`); the end of the epoch never moves to a
//!    later time. Only a new prediction changes the event of k, and it includes the pair again.
//! 4. **The earliest event is never later than the next contact.** *Proof.* Lemma 3 holds for every
//!    related pair. A contact removes the events of both its bodies from the calendar; both bodies
//!    are predicted before the next event is taken, or a new epoch begins.
//! 5. **No event acts on an outdated motion.** *Proof.* Every change of a motion increments the
//!    body's version, and an event whose partner has another version is stale. The time of a stale
//!    event is a lower bound on the contact times of all candidates of its body, so nothing is lost
//!    if the body is predicted only when the event comes due.
//! 6. **Walls that move.** Lemmas 1 to 5 hold with walls that move. *Proof.* A wall is listed for a
//!    span of time in every cell from which it can be touched in that span, and it is listed anew
//!    at the end of the span, which is an event. Its motion does not change. A body in a cell that
//!    the wall enters is predicted right afterwards; it is the body k of lemma 3.
//! 7. **Pistons.** Lemmas 1 to 5 hold with pistons, walls that contacts push. *Proof.* A piston is
//!    a multi-cell body whose shell is a strip: it is listed in every cell from which it can be
//!    touched while it is no farther from its place there than half a side of a cell. It leaves
//!    the strip, at a time bounded by its top speed, as an event that lists it anew and predicts
//!    it; its stops are events too. So every relation begins with a prediction of one of the two
//!    (lemma 2).
//! 8. **Tethers and wells.** Lemmas 1 to 5 hold for the events of bonds, and of discs in their
//!    wells. *Proof.* Two such bodies are related at all times, in the image that the bond or the
//!    well holds; every prediction of either searches it, up to the event that it keeps.
//! 9. **Shear.** Lemmas 1 to 5 hold for discs in a sheared box, of which those in cells that see no
//!    image through the border are searched like others. *Proof.* The cells shear with the images,
//!    so that neighbours remain neighbours. A disc that leaves the box through the seam gets
//!    another velocity; it has then left the 3 × 3 cells around every disc that sees no image, and
//!    is predicted in its new cell.
//! 10. **One partner may be skipped.** Of two bodies that have just met, the prediction of the
//!     first may leave out the second. *Proof.* The first is not the body of the pair that is
//!     predicted last.
//!
//! # Layers
//!
//! Each file uses those before it in this list only.
//!
//! 1. Data of a body and of a cell: `slot`, `body_record`, `cell_block`, `f32_filter`, `frame`.
//! 2. The kernels of each instruction set: `simd`.
//! 3. Containers: `neighbour_lists`, `cell_occupants`, `calendar` with `prefetch`, `candidates`,
//!    `molecules`, `multi_cell` (its own file and `covered`), `cell_grid`, `pair_classes`.
//! 4. The workspace of a run, of which any number may exist: `state`.
//! 5. Lists of multi-cell bodies: `walls`, `multi_cell::listing`.
//! 6. Predictions: `dispatch`, the searches in `multi_cell`, `discs`, `discs_by_pair`, `dilute`,
//!    `molecule_search`, `partners`, and `prediction`, which selects one of them by the
//!    contents of the cells.
//! 7. The loop over the events: `events`; and `tiles`, which runs parts of the box on their own.
//!
//! # Epochs
//!
//! Every epoch starts from the state of the world alone: positions, lists and events are computed
//! anew. So the state at the end of an epoch determines the rest of the run. The order within lists
//! and bins affects no result and is not stored.

#![allow(
    clippy::inline_always,
    reason = "the loop is compiled anew for each instruction set, and calls cost as much as the work"
)]

mod body_record;
mod calendar;
mod candidates;
mod cell_block;
mod cell_grid;
mod cell_occupants;
mod dilute;
mod discs;
mod discs_by_pair;
mod dispatch;
mod events;
mod f32_filter;
mod frame;
mod molecule_search;
mod molecules;
mod multi_cell;
mod neighbour_lists;
mod pair_classes;
mod partners;
mod prediction;
mod prefetch;
mod simd;
mod slot;
mod state;
mod tiles;
mod walls;

use carom_detection::Detection;
use carom_response::Response;

pub use self::simd::Instructions;
use self::{
    cell_grid::{CellContents, CellGrid},
    events::run,
    frame::WholeBox,
    simd::{AvailableInstructions, available},
    state::CellState,
    tiles::Tiles,
};
use crate::{
    grid::{CellsPerSide, Grid},
    heap_scheduler::HeapScheduler,
    scene::error::GridError,
    scheduler::{EventLoop, Scheduler, StoredMotions},
    tiling::{TileCounters, TileUse, TileWork, Tiling},
    window::{RestartState, TimeWindow, WindowJob},
    world::{World, body::Body, counters::SchedulerCounters},
};

/// The default scheduler: cell lists, one event a body, and a calendar queue.
///
/// The source of its module has the design and a proof that no contact is missed. [`HeapScheduler`]
/// runs a box too small for three cells a side, because it searches every image. It also runs a
/// single moving body among fixed ones, for which neighbour lists of moving bodies do not pay.
#[doc(alias = "Cells")]
#[doc(alias = "cell lists")]
#[derive(Debug, Clone)]
pub struct CellScheduler(Layout);

#[derive(Debug, Clone)]
enum Layout {
    Grid(Box<Cells>),
    Fallback(Box<HeapScheduler>),
}

/// The cells of the box, run as a whole or in tiles.
#[derive(Debug, Clone)]
struct Cells {
    whole: CellState,
    /// If the box is divided into tiles.
    tiles: Option<Box<Tiles>>,
    tiling: Tiling,
    /// Whether the tiles hold the present motions, or the whole box does.
    in_tiles: bool,
    /// After a window that was run ahead has been given up: its start, whose state the whole box
    /// holds.
    restart: Option<RestartState>,
    /// Work in tiles of earlier divisions.
    tiles_before: (TileCounters, SchedulerCounters),
    /// Why these bodies cannot be run in tiles.
    refusal: Option<TileUse>,
    bodies: usize,
}

impl Cells {
    fn new(instructions: AvailableInstructions, grid: CellGrid, world: &World) -> Self {
        let is_large = |body: &Body| !body.is_fixed() && grid.is_multi_cell(body);
        let refusal = match grid.contents() {
            CellContents::DiluteDiscs => Some(TileUse::Dilute),
            _ if world.has_wells() => Some(TileUse::Wells),
            _ if world.has_thermal_walls => Some(TileUse::ThermalWalls),
            _ if world.is_sheared() => Some(TileUse::Shear),
            _ if world.is_tethered() => Some(TileUse::Tethers),
            _ if world.has_reactions => Some(TileUse::Reactions),
            _ if world.pistons().next().is_some() => Some(TileUse::Pistons),
            _ if world.bodies().iter().any(is_large) => Some(TileUse::LargeBodies),
            CellContents::Discs
            | CellContents::DiscsByPair
            | CellContents::TiedDiscs
            | CellContents::ShearedDiscs
            | CellContents::Molecules => None,
        };
        Self {
            whole: CellState::new(instructions, grid, WholeBox),
            tiles: None,
            tiling: Tiling::NONE,
            in_tiles: false,
            restart: None,
            tiles_before: Default::default(),
            refusal,
            bodies: world.bodies().len(),
        }
    }

    /// Divides the box anew, between two epochs.
    fn set_tiling(&mut self, tiling: &Tiling) {
        let tiling = &tiling.within_bounds();
        if *tiling == self.tiling {
            return;
        }
        self.tiles_before = (self.tile_counters(), self.counters());
        self.whole.done = SchedulerCounters::default();
        self.tiling = *tiling;
        let requested = matches!(self.tile_use(tiling), TileUse::Tiles(_));
        let tiles = requested
            .then(|| Tiles::new(tiling, self.whole.instructions, &self.whole.grid))
            .flatten();
        self.tiles = tiles.map(Box::new);
    }

    /// The length of a window (time); 0 without tiles.
    fn window_length(&self) -> f64 {
        self.tiles
            .as_ref()
            .map_or(0.0, |tiles| tiles.window_length())
    }

    fn tile_use(&self, tiling: &Tiling) -> TileUse {
        let holds_molecules = self.whole.grid.holds_molecules();
        let least = if holds_molecules {
            tiling.least_molecules
        } else {
            tiling.least_bodies
        };
        match self.refusal {
            Some(refusal) => refusal,
            None if self.bodies < least => TileUse::FewBodies(least),
            None => {
                Tiles::count(tiling, &self.whole.grid).map_or(TileUse::SmallBox, TileUse::Tiles)
            }
        }
    }

    fn begin_epoch<D: Detection>(&mut self, world: &World, detection: &D, limit: f64) {
        self.in_tiles = self.tiles.is_some();
        match &mut self.tiles {
            Some(tiles) => tiles.begin_epoch(world, &self.whole.grid, limit),
            None => self.whole.begin_epoch(world, detection, limit),
        }
    }

    fn run_window<D: Detection, R: Response>(
        &mut self,
        job: &WindowJob<'_, D, R>,
    ) -> Option<TimeWindow> {
        self.restart = None;
        let tiles = self.tiles.as_mut()?;
        if let Some(window) = tiles.serve(job) {
            return Some(window);
        }
        let may_run = job.may_use_windows && job.detection.decides_discs_in_closed_form();
        if may_run && !tiles.is_ahead() {
            let should_run_ahead = tiles.should_run_ahead(job);
            if should_run_ahead || tiles.is_worthwhile(job.stop - job.from, self.in_tiles) {
                if !self.in_tiles {
                    tiles.take_over(job.world, &self.whole);
                    self.whole.release();
                    self.in_tiles = true;
                }
                // Not the first window of an epoch: if it were given up, its start would be that of
                // the world, which stops have overwritten.
                let runs_ahead = should_run_ahead && !tiles.is_fresh();
                if let Some(window) = tiles.run(job, &self.whole.grid, runs_ahead) {
                    return Some(window);
                }
            }
        }
        if self.in_tiles {
            self.in_tiles = false;
            // The tiles hold an earlier state if they have been run ahead.
            self.restart = tiles.roll_back().filter(|restart| restart.from < job.from);
            if tiles.is_fresh() {
                self.whole
                    .begin_epoch(job.world, job.detection, tiles.limit());
            } else {
                let now = self
                    .restart
                    .as_ref()
                    .map_or(job.from, |restart| restart.from);
                tiles.hand_over(job.world, &mut self.whole, now);
            }
        }
        None
    }

    fn store(&self, state: &mut StoredMotions<'_>) {
        match &self.tiles {
            Some(tiles) if self.in_tiles => tiles.store(state),
            _ => {
                state.set_work_of_shear(self.whole.work_of_shear);
                (0..self.whole.windings.len() as u32)
                    .for_each(|body| self.whole.store_body(state, body));
            }
        }
    }

    fn tile_counters(&self) -> TileCounters {
        self.tiles_before.0
            + self
                .tiles
                .as_ref()
                .map_or_else(TileCounters::default, |tiles| tiles.counters)
    }

    fn counters(&self) -> SchedulerCounters {
        let in_tiles = self
            .tiles
            .as_ref()
            .map_or_else(SchedulerCounters::default, |tiles| tiles.done);
        self.tiles_before.1 + self.whole.done + in_tiles
    }
}

impl Scheduler for CellScheduler {
    type Options = Instructions;

    const CONTACTS_PER_EPOCH: u64 = 64;
    const RUNS_DRIVEN_BODIES: bool = true;
    const RUNS_PISTONS: bool = true;
    const RUNS_SHEAR: bool = true;
    const RUNS_TETHERS: bool = true;
    const RUNS_WELLS: bool = true;

    fn new(instructions: &Instructions, world: &World) -> Result<Self, GridError> {
        // Also rejects a box in which a molecule can touch its own image.
        Grid::counts_for(world, CellsPerSide::Given(1))?;
        let grid = if world.is_billiard() {
            None
        } else {
            CellGrid::new(world)
        };
        let Some(grid) = grid else {
            return HeapScheduler::new(&CellsPerSide::Automatic, world)
                .map(|fallback| Self(Layout::Fallback(Box::new(fallback))));
        };
        Ok(Self(Layout::Grid(Box::new(Cells::new(
            available(*instructions),
            grid,
            world,
        )))))
    }

    fn begin_epoch<D: Detection>(&mut self, world: &World, detection: &D, limit: f64) {
        match &mut self.0 {
            Layout::Grid(cells) => cells.begin_epoch(world, detection, limit),
            Layout::Fallback(fallback) => fallback.begin_epoch(world, detection, limit),
        }
    }

    fn run<L: EventLoop>(&mut self, events: L) -> L::End {
        match &mut self.0 {
            Layout::Grid(cells) => run(&mut cells.whole, events),
            Layout::Fallback(fallback) => events.run(&mut **fallback),
        }
    }

    fn run_window<D: Detection, R: Response>(
        &mut self,
        job: &WindowJob<'_, D, R>,
    ) -> Option<TimeWindow> {
        match &mut self.0 {
            Layout::Grid(cells) => cells.run_window(job),
            Layout::Fallback(_) => None,
        }
    }

    fn is_ahead(&self) -> bool {
        match &self.0 {
            Layout::Grid(cells) => cells.tiles.as_ref().is_some_and(|tiles| tiles.is_ahead()),
            Layout::Fallback(_) => false,
        }
    }

    fn take_restart(&mut self) -> Option<RestartState> {
        match &mut self.0 {
            Layout::Grid(cells) => cells.restart.take(),
            Layout::Fallback(_) => None,
        }
    }

    fn set_tiling(&mut self, tiling: &Tiling) {
        if let Layout::Grid(cells) = &mut self.0 {
            cells.set_tiling(tiling);
        }
    }

    fn tile_use(&self, tiling: &Tiling) -> TileUse {
        match &self.0 {
            Layout::Grid(cells) => cells.tile_use(tiling),
            Layout::Fallback(_) => TileUse::Scheduler,
        }
    }

    fn window_length(&self) -> f64 {
        match &self.0 {
            Layout::Grid(cells) => cells.window_length(),
            Layout::Fallback(_) => 0.0,
        }
    }

    fn tile_work(&self) -> Vec<TileWork> {
        match &self.0 {
            Layout::Grid(cells) => cells
                .tiles
                .as_ref()
                .map_or_else(Vec::new, |tiles| tiles.work()),
            Layout::Fallback(_) => Vec::new(),
        }
    }

    fn tile_counters(&self) -> TileCounters {
        match &self.0 {
            Layout::Grid(cells) => cells.tile_counters(),
            Layout::Fallback(_) => TileCounters::default(),
        }
    }

    fn store(&self, state: &mut StoredMotions<'_>) {
        match &self.0 {
            Layout::Grid(cells) => cells.store(state),
            Layout::Fallback(fallback) => fallback.store(state),
        }
    }

    fn store_changes(&mut self, state: &mut StoredMotions<'_>, contact: &[u32]) {
        match &mut self.0 {
            Layout::Grid(cells) => {
                if let Some(tiles) = cells.tiles.as_mut().filter(|_| cells.in_tiles) {
                    return tiles.store_changes(state);
                }
                let Some(wrapped) = cells.whole.wrapped.take() else {
                    return cells.store(state);
                };
                state.set_work_of_shear(cells.whole.work_of_shear);
                wrapped
                    .iter()
                    .chain(contact)
                    .for_each(|&body| cells.whole.store_body(state, body));
            }
            Layout::Fallback(fallback) => fallback.store_changes(state, contact),
        }
    }

    fn heap_bytes(&self) -> usize {
        match &self.0 {
            Layout::Grid(cells) => {
                cells.whole.heap_bytes()
                    + cells.tiles.as_ref().map_or(0, |tiles| tiles.heap_bytes())
            }
            Layout::Fallback(fallback) => fallback.heap_bytes(),
        }
    }

    fn counters(&self) -> SchedulerCounters {
        match &self.0 {
            Layout::Grid(cells) => cells.counters(),
            Layout::Fallback(fallback) => fallback.counters(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        run::simulation::Simulation,
        scene::{MoleculeSpec, Scene, atom_spec::AtomSpec},
    };
    use carom_detection::Exact;
    use carom_response::Impact;
    use rand::{RngExt, SeedableRng};

    /// 576 discs in a square lattice of the unit box.
    fn lattice(velocity: impl FnMut(usize) -> [f64; 2]) -> Scene {
        const SIDE: usize = 24;
        let step = 1.0 / SIDE as f64;
        let mut velocity = velocity;
        let disc = |k: usize| MoleculeSpec {
            atoms: vec![AtomSpec {
                at: [0.0; 2],
                radius: 0.4 * step,
                mass: 1.0,
            }],
            at: [
                ((k % SIDE) as f64 + 0.25) * step,
                ((k / SIDE) as f64 + 0.25) * step,
            ],
            velocity: velocity(k),
            ..MoleculeSpec::default()
        };
        Scene {
            molecule: (0..SIDE * SIDE).map(disc).collect(),
            ..Scene::default()
        }
    }

    #[test]
    fn runs_have_the_same_bits_with_either_form_of_the_bins() {
        let mut random = rand_pcg::Pcg64::seed_from_u64(3);
        let gas = lattice(|_| [0; 2].map(|_| random.random_range(-1.0..1.0)));
        // Neighbours meet head-on in pairs, all at one time.
        let simultaneous = lattice(|k| [if k % 2 == 0 { 1.0 } else { -1.0 }, 0.0]);
        for (scene, until) in [(gas, 2.0), (simultaneous, 0.3)] {
            let run = |min_bodies: fn(usize) -> usize| {
                calendar::MIN_BODIES.set(min_bodies(0));
                let mut simulation =
                    Simulation::<Exact, Impact, CellScheduler>::new(&scene).unwrap();
                for stop in 1..=20 {
                    calendar::MIN_BODIES.set(min_bodies(stop));
                    simulation.run_until(until * stop as f64 / 20.0).unwrap();
                }
                calendar::MIN_BODIES.set(usize::MAX);
                let view = simulation.view();
                let motions: Vec<[u64; 4]> = view
                    .bodies()
                    .map(|body| {
                        let (at, velocity) = (body.motion.position, body.motion.velocity);
                        [at.x, at.y, velocity.x, velocity.y].map(f64::to_bits)
                    })
                    .collect();
                (view.counters().collisions, motions)
            };
            let links = run(|_| usize::MAX);
            assert!(links.0 > 2000, "{} collisions", links.0);
            assert_eq!(links, run(|_| 0));
            // The form changes from one stop to the next.
            assert_eq!(
                links,
                run(|stop| if stop % 2 == 0 { 0 } else { usize::MAX })
            );
        }
    }

    #[test]
    fn bins_are_as_wide_for_a_lattice_on_borders_of_cells_as_for_any() {
        // All discs on a border leave a cell at time 0, which has no relation to their later
        // events. An interval estimated from these times would be 0, and all events would be in one
        // bin.
        const SIDE: usize = 64;
        let interval = |shift: f64| {
            let step = 1.0 / SIDE as f64;
            let disc = |k: usize| {
                // Directions spread evenly over a quarter turn, by the golden ratio.
                let angle =
                    std::f64::consts::FRAC_PI_2 * ((k as f64 * 0.618_033_988_749_895) % 1.0);
                MoleculeSpec {
                    atoms: vec![AtomSpec {
                        at: [0.0; 2],
                        radius: 0.45 * step,
                        mass: 1.0,
                    }],
                    at: [
                        ((k % SIDE) as f64 + shift) * step,
                        ((k / SIDE) as f64 + shift) * step,
                    ],
                    velocity: [-angle.cos(), -angle.sin()],
                    ..MoleculeSpec::default()
                }
            };
            let scene = Scene {
                molecule: (0..SIDE * SIDE).map(disc).collect(),
                ..Scene::default()
            };
            let mut simulation = Simulation::<Exact, Impact, CellScheduler>::new(&scene).unwrap();
            simulation
                .scheduler
                .begin_epoch(&simulation.world, &simulation.detection, 1.0);
            match &simulation.scheduler.0 {
                Layout::Grid(cells) => cells.whole.mean_interval(),
                Layout::Fallback(_) => panic!("64 discs a side have a grid"),
            }
        };
        let (inside, on_borders) = (interval(0.37), interval(0.0));
        let ratio = on_borders / inside;
        assert!(
            ratio > 0.05 && ratio < 20.0,
            "{on_borders} against {inside}"
        );
    }
}
