//! Tiles: rectangles of cells that are run through a window of time on their own, in any order and
//! on any number of threads, with the bits of the global order.
//!
//! Each tile is run from the common state at the start of the window, together with a border of its
//! neighbours' bodies. Far out, these are soon wrong: the bodies beyond the border are missing. So
//! events of the border are left out once they can no longer influence the tile, and tile and
//! neighbours log all changes in the two rings of cells on each side of their common border. If the
//! logs agree everywhere, every tile is right. If two disagree, both are run again with a wider
//! border, from the old state, which is still there. If this does not help, the window is run event
//! by event.
//!
//! Bodies that contacts push live in cells, as discs or as molecules. Walls and fixed bodies are
//! listed in the cells from which they can be touched, and no contact changes their motion: each
//! tile reads them where it needs them. The time of their last contact does change, but no outcome
//! depends on it (`Guard::raise`); the latest of all tiles is kept.
//!
//! A wall that moves is listed for a span of time, as in the global order (`multi_cell`), and so is
//! each fixed body where bodies fall, since all are seen from the falling frame. A window ends no
//! later than the first of these spans. The next one begins with these bodies listed for their next
//! span, one after the other, and with predictions of the bodies in the cells that each enters:
//! what the global order does at that time.
//!
//! # Lemmas
//!
//! An event *changes* the cells of its moving bodies: those of both bodies of a contact, or that of
//! the one that touches a fixed body; that of the body of a stale prediction or of a re-check,
//! whose next event alone changes; the cells that a crossing leaves and enters. It *reads* the
//! cells adjacent to these, with the motions, versions and next events of their bodies, and the
//! fixed bodies listed there. The *neighbourhood* of a tile is its own cells and the two rings
//! around them, the *history* of a cell the sequence of changes in it. H is the run in the global
//! order.
//!
//! 1. **An event that changes a cell of a tile reads only the neighbourhood.** *Proof.* An event
//!    changes one cell, or two adjacent ones, so all of them lie within one ring. It reads the
//!    cells adjacent to these. This holds for a contact of two discs or molecules (they live in
//!    adjacent cells: a cell is as long as two bounding circles reach), for a contact with a wall
//!    or a fixed body, a stale prediction, a re-check, and a crossing.
//! 2. **No event that changes a cell of a tile is left out.** *Proof.* It is the event of a body in
//!    the tile or in the ring around it. Both have the end of the window as their limit, since the
//!    margin is at least one cell and the border at least three (`Workspace::load`). An event that
//!    is left out farther away is a difference like any other: the comparison finds it.
//! 3. **If all logs agree, each tile has in its own cells the history of H.** *Proof.* Assume not.
//!    Take the first event, in the order of time and of bodies, with which in some tile A the
//!    history of a cell c of its neighbourhood differs from that in H: it is in one of the two
//!    only, or has another outcome. If c is in the rings, it belongs to a neighbour B, which has
//!    the same history of c by comparison, so B differs from H in its own cell. So let c be a cell
//!    of A itself. By lemma 1 the event reads the neighbourhood of A only, which agrees with H up
//!    to then: the same bodies with the same motions, versions, next events with their partners,
//!    and times of last contacts, since these are the outcomes of earlier changes (`Change`), or
//!    were given at the start. By lemma 2 it is not left out. So it happens in both, with the same
//!    outcome: a contradiction.
//! 4. **The order of bodies is that of all.** A workspace numbers its bodies in the order of their
//!    indices among all, so ties are decided alike. A tie that depends on a partner outside the
//!    workspace is left to the global order, as are contacts of two tiles with one fixed body at
//!    the same instant.
//! 5. **Roundings are those of the whole box.** Motions and cells are kept relative to the box, and
//!    the image in which a body is seen depends on its cell alone, never on the tile.
//! 6. **A partner that is in no cell around a body has changed since.** *Proof.* The next event of
//!    a body is a contact only if the body is in its present cell until then. Without a change, the
//!    centre of the partner moves on a straight line from one cell of the 3 × 3 around it to
//!    another, so it is in one of them all the time. The version of the prediction is kept while
//!    the partner is away, so the prediction stays stale.
//! 7. **A wall that is not listed in the cell of a body cannot be touched there in the window.**
//!    A prediction of such a contact is of a later span, in which the wall is listed there; until
//!    then it is kept, like that of a partner that is away. *Proof.* The window lies in the span,
//!    and the wall is listed in every cell from which it can be touched in the span.
//! 8. **Fixed bodies are listed anew in the order of all.** *Proof.* They are, in the order of
//!    their indices, and nothing else happens at that instant
//!    (`Tiles::has_events_at_end_of_spans`); if something does, the global order runs this part.
//!
//! Nothing is assumed of speeds, distances or equilibrium: they decide how often a tile is run
//! again, never the result. A log holds the changes themselves, not a digest.
//!
//! # Ends of a window
//!
//! A window ends with the epoch, as in the global order, or with the span of a fixed body that
//! moves. If there are more contacts than the epoch has left, or if a body becomes so fast that the
//! epoch ends earlier, the window is run again up to that time. Contacts of a body with two others
//! at one instant, contacts after which the surfaces separate by rounding alone, and errors are
//! left to the global order, which begins from the state at the start of the window. Only events in
//! a tile's own cells count for this: those in its border may be wrong. Of the border count only
//! events at one instant: ties that depend on a partner beyond it, and more contacts than have an
//! end for certain; and more events of all bodies than can be expected.
//!
//! # Stops within a window
//!
//! Samples often follow one another more closely than windows should be. Then the window is run
//! ahead (`ahead`), with all changes of motions in it, and each stop gets its part of the contacts
//! and changes. This needs the trajectory alone, so no bit depends on it. If the rest of the window
//! is not requested, because of an edit, a single step or another observer, the contacts since its
//! start, which have been recorded already, are run once more in the global order.

mod ahead;
mod border_log;
mod fixed_bodies;
mod map;
mod resting;
#[cfg(test)]
mod tests;
mod workspace;

use std::sync::{
    Mutex, PoisonError,
    atomic::{AtomicUsize, Ordering},
};

use carom_detection::Detection;
use carom_response::Response;

use self::{
    ahead::{MotionLog, WindowAhead},
    border_log::MAX_RINGS,
    fixed_bodies::{FixedBodies, Relisting},
    map::{DIRECTIONS, TileMap, opposite},
    resting::{Rest, RestingBody, TileBodies},
    workspace::{TileOutcome, TileSpan, TileTask, Workspace},
};
use super::{
    body_record::BodyRecord,
    cell_grid::CellGrid,
    pair_classes::PairClasses,
    simd::AvailableInstructions,
    state::{CellState, EpochConstants},
};
use crate::{
    contact::{limits::Limits, resolution::ContactPair},
    scheduler::StoredMotions,
    tiling::{TileCounters, TileWork, Tiling},
    window::{
        ContactEnergy, FastContact, InelasticContacts, RestartState, TimeWindow, WindowContact,
        WindowJob,
    },
    world::{World, counters::SchedulerCounters},
};

/// Runs of a window, or of a tile in it, before the window is run event by event.
const MAX_ATTEMPTS: usize = 4;

/// Cells by which the border of a tile is widened when it is run again.
const WIDENING: u32 = 6;

/// Share of [`Tiling::front`] and [`Tiling::margin`] for molecules, which touch at less than the
/// length of a cell. Smaller: more tiles are repeated. Larger: wider borders.
const MOLECULE_SHARE_OF_FRONT: f64 = 0.72;

/// Free paths that an influence travels at least in a mean free time, at the root mean square of
/// the speed: in a thin gas it travels with the fastest bodies. Smaller: more tiles are repeated.
/// Larger: wider borders.
const FREE_PATHS_PER_FREE_TIME: f64 = 3.5;

/// Factor on the speed of influences after a window in which tiles disagreed, and after any other.
/// About one window in eleven is then run twice in part. Closer to 1: more are. Farther: borders
/// are wider than they must be for longer.
const FRONT_GROWTH: f64 = 1.25;
const FRONT_DECAY: f64 = 0.98;

/// Most cells that an influence is taken to travel in a mean free time.
const MAX_FRONT: f64 = 64.0;

/// Largest log of contacts, and of motions if the window is run ahead (bytes). Larger: more memory.
/// Smaller: shorter windows, in which bodies are copied more often.
const MAX_LOG_BYTES: f64 = 64.0 * 1024.0 * 1024.0;

/// Most threads for each processor. More: more memory, and no more speed.
const MAX_THREADS_PER_PROCESSOR: usize = 8;

/// Share of the contacts left in an epoch that a window aims for, so that a short one follows,
/// which is run twice. Larger: more often the long one is run twice.
const SHARE_OF_EPOCH: f64 = 0.99;

/// Shortest stretch that is run in a window, in mean free times. Shorter: copying the bodies costs
/// more than tiles save.
const MIN_STRETCH: f64 = 0.3;

/// Number of close stops in succession after which a window is run ahead; it is raised after such a
/// window has been given up early. Fewer: more windows are run ahead for nothing. More: more
/// stretches are run event by event.
const MIN_PATIENCE: u32 = 1;

/// Stops are close if at least so many of them fall into a window. Fewer: the log of motions costs
/// more than is gained. More: more windows are cut.
const MIN_STOPS_PER_WINDOW: f64 = 2.0;

/// All bodies of the box in tiles, between two windows.
#[derive(Debug, Clone)]
pub(super) struct Tiles {
    map: TileMap,
    tiling: Tiling,
    bodies: Vec<TileBodies>,
    fixed: Option<FixedBodies>,
    /// Those that are listed anew at the start of a window that is not accepted yet.
    relisting: Option<Relisting>,
    holds_molecules: bool,
    /// Bytes of the log of motions for each contact.
    motion_log_bytes: usize,
    outcomes: Vec<TileOutcome>,
    /// The window of the outcomes, if these are later than the present.
    ahead: Option<Box<WindowAhead>>,
    /// Stops in succession that cut a window, and the number after which one is run ahead.
    short_stops: u32,
    patience: u32,
    workspaces: Vec<Workspace>,
    epoch: EpochConstants,
    /// The classes of all bodies.
    pair_classes: PairClasses,
    /// Whether the bodies have no events yet.
    is_fresh: bool,
    /// Measured in the last window: contacts of all bodies, and events of all bodies, per time.
    contact_rate: f64,
    event_rate: f64,
    /// Cells that an influence travels in a mean free time, and cells by which a border is wider:
    /// see [`Tiling::front`] and [`Tiling::margin`]. More after tiles have disagreed.
    front: f64,
    margin: u32,
    /// The least front in this epoch.
    least_front: f64,
    /// Number of bodies that move.
    count: usize,
    /// Whether the rest of the epoch is run event by event.
    is_refused: bool,
    pub(super) counters: TileCounters,
    /// Work of the accepted windows.
    pub(super) done: SchedulerCounters,
}

/// Why a window is not accepted.
enum Refused {
    /// The tiles do not agree, with the widest border for which the box has room: a shorter window
    /// needs less.
    TooLong,
    /// The global order must run it.
    NeedsOrder,
}

impl Tiles {
    /// The division of a grid; none if there are too few cells.
    fn map(tiling: &Tiling, grid: &CellGrid) -> Option<TileMap> {
        let map = TileMap::new(grid.counts(), tiling.side_for(grid.counts()))?;
        (map.widest_border() >= tiling.within_bounds().margin + 3).then_some(map)
    }

    /// Number of tiles of a grid; none if there are too few cells.
    pub fn count(tiling: &Tiling, grid: &CellGrid) -> Option<usize> {
        Self::map(tiling, grid).map(|map| map.tiles())
    }

    /// Tiles for the bodies of a grid; none if there are too few cells.
    pub fn new(
        tiling: &Tiling,
        instructions: AvailableInstructions,
        grid: &CellGrid,
    ) -> Option<Self> {
        let map = Self::map(tiling, grid)?;
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        let threads = tiling
            .threads
            .clamp(1, map.tiles().min(MAX_THREADS_PER_PROCESSOR * processors));
        Some(Self {
            tiling: tiling.within_bounds(),
            bodies: vec![TileBodies::default(); map.tiles()],
            fixed: None,
            relisting: None,
            holds_molecules: grid.holds_molecules(),
            motion_log_bytes: MotionLog::bytes_for_contact(grid.keeps_motions()),
            outcomes: vec![TileOutcome::default(); map.tiles()],
            ahead: None,
            short_stops: 0,
            patience: MIN_PATIENCE,
            workspaces: vec![Workspace::new(instructions, grid.clone()); threads],
            map,
            epoch: EpochConstants::default(),
            pair_classes: PairClasses::default(),
            is_fresh: true,
            contact_rate: 0.0,
            event_rate: 0.0,
            front: 0.0,
            margin: tiling.within_bounds().margin,
            least_front: 0.0,
            count: 0,
            is_refused: false,
            counters: TileCounters::default(),
            done: SchedulerCounters::default(),
        })
    }

    pub fn heap_bytes(&self) -> usize {
        self.bodies
            .iter()
            .map(TileBodies::heap_bytes)
            .sum::<usize>()
            + self.fixed.as_ref().map_or(0, FixedBodies::heap_bytes)
            + self.pair_classes.heap_bytes()
            + self.relisting.as_ref().map_or(0, Relisting::heap_bytes)
            + self
                .outcomes
                .iter()
                .map(TileOutcome::heap_bytes)
                .sum::<usize>()
            + self.ahead.as_ref().map_or(0, |ahead| ahead.heap_bytes())
            + self
                .workspaces
                .iter()
                .map(Workspace::heap_bytes)
                .sum::<usize>()
    }

    /// Begins an epoch of at most `limit` (time): reads the motions. Events are predicted by the
    /// first window.
    pub fn begin_epoch(&mut self, world: &World, grid: &CellGrid, limit: f64) {
        self.roll_back();
        self.start(world, grid, limit, |_| 0.0);
        self.is_fresh = true;
        let moving = (0..world.bodies.len()).filter(|&body| !world.bodies[body].is_fixed());
        let bodies = moving.map(|body| {
            let motion = &world.motions[body];
            let mut record = BodyRecord::new(motion, 0.0);
            record.set_cell(grid.cell_of(motion.position));
            RestingBody::new(
                &record,
                body as u32,
                world.windings[body].map(|boxes| boxes as i16),
            )
        });
        let motions = if grid.keeps_motions() {
            world.motions()
        } else {
            &[]
        };
        self.distribute(
            bodies,
            Rest {
                motions,
                pending: &[],
            },
        );
    }

    /// Reads what holds for the whole epoch; a wall that moves is listed since a given time (offset
    /// in the epoch).
    fn start(
        &mut self,
        world: &World,
        grid: &CellGrid,
        limit: f64,
        listed_from: impl Fn(u32) -> f64,
    ) {
        self.epoch = EpochConstants::new(world, grid, limit);
        self.pair_classes
            .lay_out(world, grid, self.epoch.separation_error);
        self.fixed = FixedBodies::new(world, grid, &self.map, limit, listed_from);
        self.relisting = None;
        if self.contact_rate == 0.0 {
            self.contact_rate = expected_contact_rate(world);
            self.event_rate = 4.0 * self.contact_rate;
        }
        // Nothing moves.
        self.is_refused = self.contact_rate == 0.0;
        let share = if self.holds_molecules {
            MOLECULE_SHARE_OF_FRONT
        } else {
            1.0
        };
        self.margin = (share * f64::from(self.tiling.margin)).ceil() as u32;
        let (count, mean_square_speed) = moving(world);
        let free_path = (0.5 * count / self.contact_rate) * mean_square_speed.sqrt();
        let in_free_paths = FREE_PATHS_PER_FREE_TIME * free_path / grid.side().min_element();
        self.least_front = (share * self.tiling.front)
            .max(in_free_paths)
            .min(MAX_FRONT);
        self.front = self.front.max(self.least_front);
    }

    /// Takes over from the global order, in the middle of an epoch.
    pub fn take_over(&mut self, world: &World, state: &CellState) {
        let listed_from = |body| state.multi_cell.listed_from(body);
        self.start(world, &state.grid, state.limit, listed_from);
        self.is_fresh = false;
        let moving = (0..state.windings.len()).filter(|&body| !world.bodies[body].is_fixed());
        let bodies = moving.map(|body| {
            let record = &state.records[body];
            let mut resting = RestingBody::new(record, body as u32, state.windings[body]);
            resting.set_event(record.kind(), record.partner());
            resting
        });
        let rest = Rest {
            motions: &state.molecules.motions,
            pending: state.multi_cell.all_pending(),
        };
        self.distribute(bodies, rest);
    }

    /// Hands over to the global order, in the middle of an epoch, at `now` (offset in it, time).
    pub fn hand_over(&self, world: &World, state: &mut CellState, now: f64) {
        state.lay_out(world, self.epoch.limit);
        for tile in &self.bodies {
            for (place, resting) in tile.moving.list.iter().enumerate() {
                let body = resting.body as usize;
                let mut record = resting.record(state.records[body].radius());
                record.set_event(
                    resting.time,
                    resting.kind(),
                    resting.partner(),
                    resting.partner_version,
                );
                state.records[body] = record;
                state.windings[body] = resting.winding;
                if let Some(motion) = tile.moving.motions.get(place) {
                    state.molecules.set_motion(resting.body, motion);
                }
                if let Some(pending) = tile.moving.pending.get(place) {
                    state.multi_cell.set_pending(resting.body, *pending);
                }
            }
        }
        let spans = self.fixed.iter().flat_map(FixedBodies::spans);
        state.resume(world, 1.0 / self.event_rate, now, spans);
    }

    /// Distributes bodies among the tiles; `rest` is by their indices among all.
    fn distribute(&mut self, bodies: impl Iterator<Item = RestingBody>, rest: Rest<'_>) {
        self.outcomes
            .iter_mut()
            .for_each(|outcome| outcome.bodies.moving.list.clear());
        self.count = 0;
        for body in bodies {
            self.outcomes[self.map.tile_of(body.cell)]
                .bodies
                .moving
                .list
                .push(body);
            self.count += 1;
        }
        for (tile, (bodies, outcome)) in self.bodies.iter_mut().zip(&mut self.outcomes).enumerate()
        {
            let own = self.map.own(tile);
            let unsorted = outcome
                .bodies
                .moving
                .list
                .iter()
                .map(|body| (*body, body.body));
            bodies.fill(
                (own.size[0] * own.size[1]) as usize,
                unsorted,
                rest,
                |body| {
                    let place = |axis: usize| u32::from(body.cell[axis]) - own.first[axis];
                    (place(1) * own.size[0] + place(0)) as usize
                },
            );
            outcome.bodies.moving.list.clear();
            outcome
                .bodies
                .moving
                .list
                .shrink_to(bodies.moving.list.len() + bodies.moving.list.len() / 32);
        }
    }

    pub fn is_fresh(&self) -> bool {
        self.is_fresh
    }

    pub fn limit(&self) -> f64 {
        self.epoch.limit
    }

    /// Stores the present motions of all bodies.
    pub fn store(&self, state: &mut StoredMotions<'_>) {
        for tile in &self.bodies {
            for (place, body) in tile.moving.list.iter().enumerate() {
                let motion = tile
                    .moving
                    .motions
                    .get(place)
                    .copied()
                    .unwrap_or_else(|| body.record(0.0).motion());
                state.set_wrapped(body.body, motion, body.winding);
            }
        }
        if let Some(ahead) = &self.ahead {
            ahead.store_all(state, |tile| &self.outcomes[tile].motion_log);
        }
    }

    /// Stores the present motions of all bodies, or only those that have changed since the last
    /// call, if the world still holds these.
    pub fn store_changes(&mut self, state: &mut StoredMotions<'_>) {
        match &mut self.ahead {
            Some(ahead) if ahead.is_stored() => {
                ahead.store_changes(state, |tile| &self.outcomes[tile].motion_log);
            }
            _ => self.store(state),
        }
        if let Some(ahead) = &mut self.ahead {
            ahead.note_stored();
        }
    }

    /// The work of each tile in the last window.
    pub fn work(&self) -> Vec<TileWork> {
        self.outcomes.iter().map(TileOutcome::work).collect()
    }

    /// Whether a stretch of this length (time) is run in windows, if the previous one was or was
    /// not.
    pub fn is_worthwhile(&self, stretch: f64, was_in_tiles: bool) -> bool {
        if stretch <= 0.0 && was_in_tiles && !self.is_fresh {
            return true;
        }
        let least = if was_in_tiles {
            MIN_STRETCH
        } else {
            4.0 * MIN_STRETCH
        };
        let span = self
            .fixed
            .as_ref()
            .map_or(f64::INFINITY, FixedBodies::shortest_span);
        let stretch = stretch.min(span);
        !self.is_refused && stretch * self.contact_rate >= 0.5 * least * self.count as f64
    }

    /// Notes a stop; returns whether stops have been so frequent that a window should be run ahead
    /// of this one.
    pub fn should_run_ahead<D, R>(&mut self, job: &WindowJob<'_, D, R>) -> bool {
        let stretch = job.stop - job.from;
        let is_short = stretch > 0.0
            && job.stop < job.limits.time()
            && stretch * MIN_STOPS_PER_WINDOW
                <= self.end_of_window(job, job.limits.time(), true) - job.from;
        self.short_stops = if is_short {
            self.short_stops.saturating_add(1)
        } else {
            0
        };
        self.short_stops > self.patience && !self.is_refused
    }

    /// Whether the outcomes are later than the present.
    pub fn is_ahead(&self) -> bool {
        self.ahead.is_some()
    }

    /// Gives up a window that has been run ahead; returns the state at its start, which the tiles
    /// hold.
    pub fn roll_back(&mut self) -> Option<RestartState> {
        let ahead = self.ahead.take()?;
        self.relisting = None;
        self.counters.given_up += 1;
        if ahead.is_in_first_half() {
            self.patience = self.patience.saturating_mul(4);
            self.short_stops = 0;
        }
        Some(ahead.into_restart())
    }

    /// Goes on in a window that has been run ahead; none if it cannot serve this job.
    pub fn serve<D, R>(&mut self, job: &WindowJob<'_, D, R>) -> Option<TimeWindow> {
        let mut ahead = self
            .ahead
            .take_if(|ahead| job.may_use_windows && ahead.fits(job))?;
        if job.stop >= ahead.end() {
            self.patience = MIN_PATIENCE;
            self.make_state();
            return Some(ahead.rest());
        }
        // Also contacts at exactly the start of the window.
        let after = if job.from == ahead.from() {
            f64::NEG_INFINITY
        } else {
            job.from
        };
        let log_of = |tile: usize| &self.outcomes[tile].motion_log;
        let limits = self.accept_fast(job, after, job.stop);
        let part = limits.and_then(|limits| ahead.part(job.world, job.stop, limits, log_of));
        self.ahead = Some(ahead);
        if part.is_none() {
            // The order of changes at one instant is left to the global order.
            self.counters.refused += 1;
            self.is_refused = true;
        }
        part
    }

    /// Runs a window; none if it must be run event by event. If it `runs_ahead`, it may end later
    /// than the stop, and is kept.
    pub fn run<D: Detection, R: Response>(
        &mut self,
        job: &WindowJob<'_, D, R>,
        grid: &CellGrid,
        runs_ahead: bool,
    ) -> Option<TimeWindow> {
        if job.stop <= job.from && !self.is_fresh {
            // All events up to this time have been processed.
            return Some(TimeWindow::without_contacts(job.from, job.limits));
        }
        let stop = if runs_ahead {
            job.limits.time()
        } else {
            job.stop
        };
        self.relist_fixed_bodies(job, grid);
        let mut end = self.end_of_window(job, stop, runs_ahead);
        if end <= job.from && job.stop > job.from {
            self.is_refused = true;
            return None;
        }
        for _ in 0..MAX_ATTEMPTS {
            match self.run_to(job, end, runs_ahead) {
                Ok(()) => {}
                Err(Refused::NeedsOrder) => break,
                Err(Refused::TooLong) => {
                    end = 0.5 * (job.from + end);
                    self.counters.cut += 1;
                    continue;
                }
            }
            if self.has_events_at_end_of_spans(end) {
                break;
            }
            match self.end_of_epoch(job, end) {
                EndOfEpoch::After(limits) => return self.accept(job, end, limits, false),
                EndOfEpoch::With(limits) => return self.accept(job, end, limits, true),
                EndOfEpoch::At(earlier) => end = earlier,
                EndOfEpoch::Unclear => break,
            }
            self.counters.cut += 1;
        }
        self.counters.refused += 1;
        self.is_refused = true;
        None
    }

    /// Lists those fixed bodies anew whose spans end with the last window.
    fn relist_fixed_bodies<D, R>(&mut self, job: &WindowJob<'_, D, R>, grid: &CellGrid) {
        let due = self
            .fixed
            .as_ref()
            .filter(|fixed| fixed.listed_until() <= job.from);
        let span = [job.from, self.epoch.limit];
        self.relisting = due.map(|fixed| fixed.relisted(job.world, grid, span));
    }

    /// Whether events of a window to `end` (offset in the epoch, time) are at the instant in which
    /// fixed bodies are listed anew: their order is that of the bodies.
    fn has_events_at_end_of_spans(&self, end: f64) -> bool {
        self.end_of_spans(f64::NEG_INFINITY) == end
            && self.outcomes.iter().any(|outcome| outcome.at_end > 0)
    }

    /// Until when no fixed body is listed anew (offset in the epoch, time); an estimate while the
    /// global order lists them.
    fn end_of_spans(&self, now: f64) -> f64 {
        let after = self.relisting.as_ref().map(|relisting| &relisting.after);
        let Some(fixed) = after.or(self.fixed.as_ref()) else {
            return f64::INFINITY;
        };
        let until = fixed.listed_until();
        if until > now {
            until
        } else {
            now + fixed.shortest_span()
        }
    }

    /// Accepts the outcomes of a window: as the state, or as one that is ahead of the stop.
    fn accept<D, R>(
        &mut self,
        job: &WindowJob<'_, D, R>,
        end: f64,
        limits: Limits,
        ends_epoch: bool,
    ) -> Option<TimeWindow> {
        let window = self.collect(job, end, limits, ends_epoch);
        if end <= job.stop {
            self.make_state();
            return Some(window);
        }
        self.ahead = Some(Box::new(WindowAhead::new(job, window, self.map.tiles())));
        self.serve(job)
    }

    /// The length of a window that ends neither with the epoch nor with the run (time).
    pub fn window_length(&self) -> f64 {
        0.5 * self.count as f64 / self.contact_rate * self.tiling.window
    }

    fn widest_border(&self) -> u32 {
        self.map.widest_border().min(MAX_RINGS - 1)
    }

    /// End of the next window (offset in the epoch, time), no later than `stop`.
    fn end_of_window<D, R>(&self, job: &WindowJob<'_, D, R>, stop: f64, logs_motions: bool) -> f64 {
        let bodies = self.count as f64;
        let free_time = 0.5 * bodies / self.contact_rate;
        // The border of a window must fit between the tiles.
        let widest = f64::from(self.widest_border().saturating_sub(self.margin + 2));
        let mut length = free_time * self.tiling.window.min(widest / self.front);
        let logged_bytes = match (job.wants_log, job.all_elastic) {
            (true, true) if self.fixed.is_none() && !self.holds_molecules => {
                size_of::<WindowContact>()
            }
            (true, _) => size_of::<ContactPair>(),
            (false, false) => size_of::<ContactEnergy>(),
            (false, true) => 0,
        } + if logs_motions {
            self.motion_log_bytes
        } else {
            0
        };
        if logged_bytes > 0 {
            length = length.min(MAX_LOG_BYTES / logged_bytes as f64 / self.contact_rate);
        }
        let left = job.limits.contacts_left() as f64 / self.contact_rate;
        if length > SHARE_OF_EPOCH * left {
            let share = if left > MIN_STRETCH * free_time {
                SHARE_OF_EPOCH
            } else {
                1.5
            };
            length = length.min(share * left + 10.0 / self.contact_rate);
        }
        let stop = stop.min(self.end_of_spans(job.from));
        // No short window before the stop, if the border of a longer one fits.
        let longest = ((1.0 + MIN_STRETCH) * length).min(free_time * widest / self.front);
        if job.from + longest < stop {
            job.from + length
        } else {
            stop
        }
    }

    /// Runs all tiles up to `end` (offset in the epoch, time), until they agree.
    fn run_to<D: Detection, R: Response>(
        &mut self,
        job: &WindowJob<'_, D, R>,
        end: f64,
        logs_motions: bool,
    ) -> Result<(), Refused> {
        let bodies = self.count as f64;
        let free_time = 0.5 * bodies / self.contact_rate;
        let left = job.limits.contacts_left() as f64;
        let span = TileSpan {
            from: job.from,
            end,
            time_per_cell: free_time / self.front,
            event_interval: bodies / self.event_rate,
            keeps_times: self.contact_rate * (end - job.from) > 0.9 * left,
            logs_motions,
        };
        let reach = (self.front * (end - job.from) / free_time).ceil() as u32;
        let mut selected: Vec<usize> = (0..self.map.tiles()).collect();
        let mut margin = self.margin;
        for attempt in 0..MAX_ATTEMPTS {
            let border = margin.saturating_add(reach).saturating_add(1);
            if border > self.widest_border() {
                return Err(Refused::TooLong);
            }
            self.run_tiles(job, &selected, (margin, border), span);
            self.counters.tiles += selected.len() as u64;
            let computed = selected.iter().map(|&tile| self.outcomes[tile].computed);
            self.counters.computed += computed.sum::<u64>();
            self.counters.repeated += if attempt > 0 {
                selected.len() as u64
            } else {
                0
            };
            if self.outcomes.iter().any(|outcome| outcome.needs_order) {
                return Err(Refused::NeedsOrder);
            }
            selected = self.tiles_that_disagree();
            if selected.is_empty() {
                return Ok(());
            }
            margin += WIDENING;
            self.front = (self.front * FRONT_GROWTH).min(MAX_FRONT);
        }
        Err(Refused::TooLong)
    }

    /// Runs some tiles, each on one of the threads.
    fn run_tiles<D: Detection, R: Response>(
        &mut self,
        job: &WindowJob<'_, D, R>,
        selected: &[usize],
        (margin, border): (u32, u32),
        span: TileSpan,
    ) {
        let (map, bodies) = (&self.map, &self.bodies);
        let (fixed, relisting) = (self.fixed.as_ref(), self.relisting.as_ref());
        let (epoch, pair_classes) = (&self.epoch, &self.pair_classes);
        let is_fresh = self.is_fresh;
        let mut requested = selected.iter().peekable();
        let tasks: Vec<(usize, &mut TileOutcome)> = self
            .outcomes
            .iter_mut()
            .enumerate()
            .filter(|(tile, _)| requested.next_if(|&&next| next == *tile).is_some())
            .collect();
        let tasks = Mutex::new(tasks.into_iter());
        let next = || tasks.lock().unwrap_or_else(PoisonError::into_inner).next();
        let work = |workspace: &mut Workspace| {
            while let Some((tile, outcome)) = next() {
                let task = TileTask {
                    map,
                    bodies,
                    fixed,
                    relisting,
                    tile,
                    margin,
                    border,
                    epoch,
                    pair_classes,
                    is_fresh,
                    span,
                };
                workspace.run(job, task, outcome);
            }
        };
        let Some((first, others)) = self.workspaces.split_first_mut() else {
            return;
        };
        std::thread::scope(|scope| {
            for workspace in others.iter_mut().take(selected.len() - 1) {
                // If the system has no more threads, the others run all tiles.
                let _ = std::thread::Builder::new().spawn_scoped(scope, || work(workspace));
            }
            work(first);
        });
    }

    /// The tiles that disagree with a neighbour, in ascending order.
    fn tiles_that_disagree(&self) -> Vec<usize> {
        let (next, found) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
        let compare = || {
            loop {
                let tile = next.fetch_add(1, Ordering::Relaxed);
                if tile >= self.map.tiles() {
                    return;
                }
                for (index, direction) in DIRECTIONS.into_iter().enumerate() {
                    let neighbour = self.map.neighbour(tile, direction);
                    let [here, there] = [tile, neighbour].map(|tile| &self.outcomes[tile].border);
                    if !here.agrees(index, there, opposite(index)) {
                        found
                            .lock()
                            .unwrap_or_else(PoisonError::into_inner)
                            .extend([tile, neighbour]);
                    }
                }
            }
        };
        std::thread::scope(|scope| {
            for _ in 1..self.workspaces.len() {
                let _ = std::thread::Builder::new().spawn_scoped(scope, compare);
            }
            compare();
        });
        let mut tiles = found.into_inner().unwrap_or_else(PoisonError::into_inner);
        tiles.sort_unstable();
        tiles.dedup();
        tiles
    }

    /// Where the epoch ends, relative to a window that has been run to `end`.
    fn end_of_epoch<D, R>(&self, job: &WindowJob<'_, D, R>, end: f64) -> EndOfEpoch {
        let last = self
            .outcomes
            .iter()
            .filter_map(|outcome| outcome.last)
            .map(|(time, _)| time);
        let last = last.fold(f64::NEG_INFINITY, f64::max);
        let at_last = self
            .outcomes
            .iter()
            .filter(|outcome| outcome.last.is_some_and(|(time, _)| time == last));
        if at_last.map(|outcome| outcome.at_last).sum::<u64>() > 1 {
            // Their bodies must be kept for contacts at the same time after the window.
            return EndOfEpoch::Unclear;
        }
        if self.touch_fixed_bodies_at_once()
            || self.outcomes.iter().any(|outcome| outcome.is_found_late)
        {
            return EndOfEpoch::Unclear;
        }
        let Some(mut limits) = self.accept_fast(job, f64::NEG_INFINITY, f64::INFINITY) else {
            return EndOfEpoch::Unclear;
        };
        if limits.time() < end {
            return EndOfEpoch::At(limits.time());
        }
        let contacts: u64 = self.outcomes.iter().map(|outcome| outcome.contacts).sum();
        let left = limits.contacts_left();
        if contacts < left {
            limits.count_contacts(contacts);
            return EndOfEpoch::After(limits);
        }
        let at_end: u64 = self.outcomes.iter().map(|outcome| outcome.at_end).sum();
        if contacts == left && last == end && at_end == 1 {
            // The last contact is at the end, and nothing else happens then.
            limits.count_contacts(contacts);
            return EndOfEpoch::With(limits);
        }
        let mut times: Vec<f64> = self
            .outcomes
            .iter()
            .flat_map(|outcome| &outcome.times)
            .copied()
            .collect();
        if (times.len() as u64) < left {
            // The times were not kept, since so many contacts were not expected.
            return EndOfEpoch::Unclear;
        }
        let (_, &mut time, _) = times.select_nth_unstable_by(left as usize - 1, f64::total_cmp);
        if time < end {
            EndOfEpoch::At(time)
        } else {
            EndOfEpoch::Unclear
        }
    }

    /// The limits of the epoch after the contacts later than `after` and up to `until` that make a
    /// body faster than all before; none if the global order must decide them. Contacts are not
    /// counted.
    fn accept_fast<D, R>(
        &self,
        job: &WindowJob<'_, D, R>,
        after: f64,
        until: f64,
    ) -> Option<Limits> {
        let mut limits = job.limits;
        let fast = self.outcomes.iter().flat_map(|outcome| &outcome.fast);
        let is_asked = |time: f64| time > after && time <= until;
        let mut fast: Vec<_> = fast
            .filter(|contact| is_asked(contact.places.time))
            .collect();
        fast.sort_by(|a, b| a.places.time.total_cmp(&b.places.time));
        for contact in fast {
            if contact.places.time > limits.time() {
                break;
            }
            let FastContact {
                places,
                velocities,
                spin,
            } = *contact;
            limits
                .accept(job.world, job.names, places, velocities, spin)
                .ok()?;
            if limits.stale_contact().is_some() {
                return None;
            }
        }
        Some(limits)
    }

    /// Whether bodies of two tiles touch one fixed body at the same instant.
    fn touch_fixed_bodies_at_once(&self) -> bool {
        let contacts = self.outcomes.iter().flat_map(|outcome| &outcome.shared);
        let mut contacts: Vec<(u32, f64)> = contacts.map(|&(time, body)| (body, time)).collect();
        contacts.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        contacts.windows(2).any(|pair| pair[0] == pair[1])
    }

    /// The window of the outcomes.
    fn collect<D, R>(
        &mut self,
        job: &WindowJob<'_, D, R>,
        end: f64,
        limits: Limits,
        ends_epoch: bool,
    ) -> TimeWindow {
        let sum = |of: fn(&TileOutcome) -> u64| self.outcomes.iter().map(of).sum::<u64>();
        let contacts = sum(|outcome| outcome.contacts);
        let with_fixed = sum(|outcome| outcome.with_fixed);
        let done = self.done_in_outcomes();
        let events = 2 * contacts + done.crossings + done.stale + done.rechecks;
        let length = end - job.from;
        if length > 0.0 {
            // A window from a lattice has few contacts, and says little about the next one. Without
            // contacts, longer windows; and none, if they do not help.
            self.contact_rate = (contacts as f64 / length).max(0.5 * self.contact_rate);
            self.event_rate = (events as f64 / length).max(0.5 * self.event_rate);
        }
        self.front = (self.front * FRONT_DECAY).max(self.least_front);
        let last = self
            .outcomes
            .iter()
            .filter_map(|outcome| outcome.last)
            .max_by(|a, b| a.0.total_cmp(&b.0));
        let mut log: Vec<WindowContact> = Vec::new();
        if job.wants_log {
            log.reserve_exact(self.outcomes.iter().map(|outcome| outcome.log.len()).sum());
            self.outcomes
                .iter()
                .for_each(|outcome| log.extend_from_slice(&outcome.log));
            log.sort_unstable_by(|a, b| a.time.total_cmp(&b.time).then(a.bodies.cmp(&b.bodies)));
        }
        let mut encounters: Vec<ContactPair> = Vec::new();
        encounters.reserve_exact(
            self.outcomes
                .iter()
                .map(|outcome| outcome.encounters.len())
                .sum(),
        );
        self.outcomes
            .iter()
            .for_each(|outcome| encounters.extend_from_slice(&outcome.encounters));
        encounters.sort_unstable_by(|a, b| a.contact.in_order(&b.contact));
        let inelastic = self.inelastic_contacts();
        TimeWindow {
            end,
            contacts,
            last,
            limits,
            ends_epoch,
            log,
            encounters,
            with_fixed,
            inelastic,
        }
    }

    /// The work of all tiles in their own cells.
    fn done_in_outcomes(&self) -> SchedulerCounters {
        let done = self.outcomes.iter().map(|outcome| outcome.done);
        done.fold(SchedulerCounters::default(), std::ops::Add::add)
    }

    /// Makes the outcomes the state.
    fn make_state(&mut self) {
        self.done = self.done + self.done_in_outcomes();
        self.counters.windows += 1;
        self.counters.contacts += self
            .outcomes
            .iter()
            .map(|outcome| outcome.contacts)
            .sum::<u64>();
        for (bodies, outcome) in self.bodies.iter_mut().zip(&mut self.outcomes) {
            std::mem::swap(bodies, &mut outcome.bodies);
        }
        let count = self
            .bodies
            .iter()
            .map(|tile| tile.moving.list.len())
            .sum::<usize>();
        debug_assert_eq!(count, self.count, "a body is in no tile, or in two");
        if let Some(relisting) = self.relisting.take() {
            self.fixed = Some(relisting.after);
        }
        self.is_fresh = false;
    }

    /// The inelastic contacts of all tiles, their energies in order of time.
    fn inelastic_contacts(&self) -> InelasticContacts {
        let mut all = InelasticContacts::default();
        for InelasticContacts {
            energies,
            last_contacts,
            guarded,
        } in self.outcomes.iter().map(|outcome| &outcome.inelastic)
        {
            all.energies.extend_from_slice(energies);
            all.last_contacts.extend_from_slice(last_contacts);
            all.guarded += guarded;
        }
        // Stable: the energies of each tile are in order already.
        all.energies
            .sort_by(|a, b| a.time.total_cmp(&b.time).then(a.bodies.cmp(&b.bodies)));
        all
    }
}

/// Gives back most of the memory that a list has and does not use: it has grown by doubling.
fn trim<T>(list: &mut Vec<T>) {
    if list.capacity() > list.len() + list.len() / 4 {
        list.shrink_to(list.len() + list.len() / 8);
    }
}

/// Where an epoch ends, relative to a window.
enum EndOfEpoch {
    /// Later; with the limits at the end of the window.
    After(Limits),
    /// With the last contact of the window.
    With(Limits),
    /// At an earlier time (offset in the epoch).
    At(f64),
    /// The global order must decide it.
    Unclear,
}

/// The rate of contacts of the bodies that move, as a gas in equilibrium (1/time): √π n σ χ √(kT/m)
/// for each body, with χ of D. Henderson, Mol. Phys. 30, 971 (1975). Only for the length of the
/// first window; 0 at rest.
fn expected_contact_rate(world: &World) -> f64 {
    let (count, mean_square_speed) = moving(world);
    let area = world.bounds().area();
    let radii = world.bodies().iter().filter(|body| !body.is_fixed());
    let diameter = 2.0
        * radii
            .map(|body| body.kind.molecule.bounding_radius())
            .sum::<f64>()
        / count;
    let filled = (count / area * 0.25 * std::f64::consts::PI * diameter * diameter).min(0.9);
    let contact_value = (1.0 - 7.0 / 16.0 * filled) / (1.0 - filled).powi(2);
    let thermal = (0.5 * mean_square_speed).sqrt();
    let rate =
        std::f64::consts::PI.sqrt() * count / area * diameter * contact_value * thermal * count;
    if rate.is_finite() { rate } else { 0.0 }
}

/// Number of the bodies that are not fixed, and the mean of their squared speeds
/// (length² / time²).
fn moving(world: &World) -> (f64, f64) {
    let moving = world
        .bodies()
        .iter()
        .zip(world.motions())
        .filter(|(body, _)| !body.is_fixed());
    let (count, squares) = moving.fold((0.0, 0.0), |(count, squares), (_, motion)| {
        (count + 1.0, squares + motion.velocity.length_squared())
    });
    (count, squares / count)
}
