//! Tiles: rectangles of cells that are run through a window of time on their own, in any order and
//! on any number of threads, with the bits of the global order.
//!
//! Each tile is run from the common state at the start of the window, together with a border of its
//! neighbours' discs. Far out, these are soon wrong: the discs beyond the border are missing.
//! So events of the border are left out once they can no longer influence the tile, and tile and
//! neighbours log all changes in the two rings of cells on each side of their common border. If the
//! logs agree everywhere, every tile is right. If two disagree, both are run again with a wider
//! border, from the old state, which is still there. If this does not help, the window is run event
//! by event.
//!
//! # Lemmas
//!
//! An event *changes* the cells of its discs: those of both discs of a contact; that of the disc of
//! a stale prediction, whose next event alone changes; the cells that a crossing leaves and enters.
//! It *reads* the cells adjacent to these, with the flights, versions and next events of their
//! discs. The *neighbourhood* of a tile is its own cells and the two rings around them, the
//! *history* of a cell the sequence of changes in it. H is the run in the global order.
//!
//! 1. **An event that changes a cell of a tile reads only the neighbourhood.** *Proof.* An event
//!    changes one cell, or two adjacent ones, so all of them lie within one ring. It reads the
//!    cells adjacent to these.
//! 2. **No event that changes a cell of a tile is left out.** *Proof.* It is the event of a disc in
//!    the tile or in the ring around it. Both have the end of the window as their limit, since the
//!    margin is at least one cell and the border at least three (`Workspace::load`). An event that
//!    is left out farther away is a difference like any other: the comparison finds it.
//! 3. **If all logs agree, each tile has in its own cells the history of H.** *Proof.* Assume not.
//!    Take the first event, in the order of time and of bodies, with which in some tile A the
//!    history of a cell c of its neighbourhood differs from that in H: it is in one of the two
//!    only, or has another outcome. If c is in the rings, it belongs to a neighbour B, which has
//!    the same history of c by comparison, so B differs from H in its own cell. So let c be a cell
//!    of A itself. By lemma 1 the event reads the neighbourhood of A only, which agrees with H up
//!    to then: the same discs with the same flights, versions, next events and times of last
//!    contacts, since these are the outcomes of earlier changes, or were given at the start. By
//!    lemma 2 it is not left out. So it happens in both, with the same outcome: a contradiction.
//! 4. **The order of discs is that of all bodies.** A workspace numbers its discs in the order of
//!    their indices among all bodies, so ties are decided alike. A tie that depends on a partner
//!    outside the workspace is left to the global order.
//! 5. **Roundings are those of the whole box.** Flights and cells are kept relative to the box, and
//!    the image in which a disc is seen depends on its cell alone, never on the tile.
//!
//! Nothing is assumed of speeds, distances or equilibrium: they decide how often a tile is run
//! again, never the result. A log holds the changes themselves, not a digest.
//!
//! # Ends of a window
//!
//! A window ends with the epoch, as in the global order. If there are more contacts than the epoch
//! has left, or if a disc becomes so fast that the epoch ends earlier, the window is run again up
//! to that time. Contacts of a disc with two others at one instant, contacts after which the
//! surfaces separate by rounding alone, and errors are left to the global order, which begins from
//! the state at the start of the window. Only events in a tile's own cells count for this: those in
//! its border may be wrong. Of the border count only events at one instant: ties that depend on a
//! partner beyond it, and more contacts than have an end for certain.

mod border_log;
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
    border_log::MOST_RINGS,
    map::{DIRECTIONS, TileMap, opposite},
    resting::{RestingDisc, TileDiscs},
    workspace::{Outcome, Span, Task, Workspace},
};
use super::{
    body_record::BodyRecord,
    grid::CellGrid,
    simd::Available,
    state::{EpochConstants, State},
};
use crate::{
    SchedulerCounters, TileCounters, TileWork, Tiling, World,
    limits::Limits,
    scheduler::StoredMotions,
    window::{ContactEnergy, InelasticContacts, LoggedContact, Window, WindowJob},
};

/// Runs of a window, or of a tile in it, before the window is run event by event.
const MOST_ATTEMPTS: usize = 4;

/// Cells by which the border of a tile is widened when it is run again.
const WIDENING: u32 = 6;

/// Largest log of contacts in a window (bytes). Larger: more memory. Smaller: shorter windows, in
/// which discs are copied more often.
const MOST_LOG_BYTES: f64 = 64.0 * 1024.0 * 1024.0;

/// Most threads for each processor. More: more memory, and no more speed.
const MOST_THREADS_PER_PROCESSOR: usize = 8;

/// Share of the contacts left in an epoch that a window aims for, so that a short one follows,
/// which is run twice. Larger: more often the long one is run twice.
const SHARE_OF_EPOCH: f64 = 0.99;

/// Shortest stretch that is run in a window, in mean free times. Shorter: copying the discs costs
/// more than tiles save.
const SHORTEST: f64 = 0.3;

/// All discs of the box in tiles, between two windows.
#[derive(Debug, Clone)]
pub(super) struct Tiles {
    map: TileMap,
    tiling: Tiling,
    discs: Vec<TileDiscs>,
    outcomes: Vec<Outcome>,
    workspaces: Vec<Workspace>,
    epoch: EpochConstants,
    /// Whether the discs have no events yet.
    is_fresh: bool,
    /// Measured in the last window: contacts of all discs, and events of all discs, per time.
    contact_rate: f64,
    event_rate: f64,
    /// Number of discs.
    count: usize,
    /// Whether the rest of the epoch is run event by event.
    is_refused: bool,
    pub(super) counters: TileCounters,
    /// Work of the accepted windows.
    pub(super) done: SchedulerCounters,
}

/// The tiles do not agree, or need a wider border than the box has room for: the global order must
/// run the window.
struct Refused;

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

    /// Tiles for the discs of a grid; none if there are too few cells.
    pub fn new(tiling: &Tiling, instructions: Available, grid: &CellGrid) -> Option<Self> {
        let map = Self::map(tiling, grid)?;
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        let threads = tiling.threads.clamp(1, map.tiles().min(MOST_THREADS_PER_PROCESSOR * processors));
        Some(Self {
            tiling: tiling.within_bounds(),
            discs: vec![TileDiscs::default(); map.tiles()],
            outcomes: vec![Outcome::default(); map.tiles()],
            workspaces: vec![Workspace::new(instructions, grid.clone()); threads],
            map,
            epoch: EpochConstants::default(),
            is_fresh: true,
            contact_rate: 0.0,
            event_rate: 0.0,
            count: 0,
            is_refused: false,
            counters: TileCounters::default(),
            done: SchedulerCounters::default(),
        })
    }

    pub fn heap_bytes(&self) -> usize {
        self.discs.iter().map(TileDiscs::heap_bytes).sum::<usize>()
            + self.outcomes.iter().map(Outcome::heap_bytes).sum::<usize>()
            + self.workspaces.iter().map(Workspace::heap_bytes).sum::<usize>()
    }

    /// Begins an epoch of at most `limit` (time): reads the motions. Events are predicted by the
    /// first window.
    pub fn begin_epoch(&mut self, world: &World, grid: &CellGrid, limit: f64) {
        self.begin(world, grid, limit);
        self.is_fresh = true;
        let discs = world.motions().iter().zip(world.windings()).zip(0..).map(|((motion, winding), body)| {
            let mut record = BodyRecord::new(motion, 0.0);
            record.set_cell(grid.cell_of(motion.position));
            RestingDisc::new(&record, body, winding.map(|boxes| boxes as i16))
        });
        self.distribute(discs);
    }

    fn begin(&mut self, world: &World, grid: &CellGrid, limit: f64) {
        self.epoch = EpochConstants::new(world, grid, limit);
        if self.contact_rate == 0.0 {
            self.contact_rate = expected_contact_rate(world);
            self.event_rate = 4.0 * self.contact_rate;
        }
        // Nothing moves.
        self.is_refused = self.contact_rate == 0.0;
    }

    /// Takes over from the global order, in the middle of an epoch.
    pub fn take_over(&mut self, world: &World, state: &State) {
        self.begin(world, &state.grid, state.limit);
        self.is_fresh = false;
        self.distribute((0..state.windings.len()).map(|body| {
            let record = &state.records[body];
            let mut disc = RestingDisc::new(record, body as u32, state.windings[body]);
            disc.set_event(record.kind(), record.partner());
            disc
        }));
    }

    /// Hands over to the global order, in the middle of an epoch, at `now` (offset in it, time).
    pub fn hand_over(&self, world: &World, state: &mut State, now: f64) {
        state.lay_out(world, self.epoch.limit);
        for disc in self.discs() {
            let body = disc.body as usize;
            let mut record = disc.record(state.records[body].radius());
            record.set_event(disc.time, disc.kind(), disc.partner(), disc.partner_version);
            state.records[body] = record;
            state.windings[body] = disc.winding;
        }
        state.resume(1.0 / self.event_rate, now);
    }

    /// Distributes discs among the tiles.
    fn distribute(&mut self, discs: impl Iterator<Item = RestingDisc>) {
        self.outcomes.iter_mut().for_each(|outcome| outcome.discs.discs.clear());
        self.count = 0;
        for disc in discs {
            self.outcomes[self.map.tile_of(disc.cell)].discs.discs.push(disc);
            self.count += 1;
        }
        for (tile, (discs, outcome)) in self.discs.iter_mut().zip(&mut self.outcomes).enumerate() {
            let own = self.map.own(tile);
            let unsorted = outcome.discs.discs.iter().copied();
            discs.fill((own.size[0] * own.size[1]) as usize, unsorted, |disc| {
                let place = |axis: usize| u32::from(disc.cell[axis]) - own.first[axis];
                (place(1) * own.size[0] + place(0)) as usize
            });
            outcome.discs.discs.clear();
            outcome.discs.discs.shrink_to(discs.discs.len() + discs.discs.len() / 32);
        }
    }

    /// All discs, tile by tile.
    fn discs(&self) -> impl Iterator<Item = &RestingDisc> + Clone {
        self.discs.iter().flat_map(|tile| &tile.discs)
    }

    pub fn is_fresh(&self) -> bool {
        self.is_fresh
    }

    pub fn limit(&self) -> f64 {
        self.epoch.limit
    }

    /// Stores the motions of all discs.
    pub fn store(&self, state: &mut StoredMotions<'_>) {
        for disc in self.discs() {
            let motion = disc.record(0.0).motion();
            state.set_wrapped(disc.body, motion, disc.winding);
        }
    }

    /// The work of each tile in the last window.
    pub fn work(&self) -> Vec<TileWork> {
        self.outcomes.iter().map(Outcome::work).collect()
    }

    /// Whether a stretch of this length (time) is run in windows, if the previous one was or was
    /// not.
    pub fn is_worthwhile(&self, stretch: f64, was_in_tiles: bool) -> bool {
        if stretch <= 0.0 && was_in_tiles && !self.is_fresh {
            return true;
        }
        let least = if was_in_tiles { SHORTEST } else { 4.0 * SHORTEST };
        !self.is_refused && stretch * self.contact_rate >= 0.5 * least * self.count as f64
    }

    /// Runs a window; none if it must be run event by event.
    pub fn run<D: Detection, R: Response>(&mut self, job: &WindowJob<'_, D, R>) -> Option<Window> {
        if job.stop <= job.from && !self.is_fresh {
            // All events up to this time have been processed.
            let (end, limits) = (job.from, job.limits);
            let (log, inelastic) = (Vec::new(), InelasticContacts::default());
            return Some(Window { end, contacts: 0, last: None, limits, ends_epoch: false, log, inelastic });
        }
        let mut end = self.end_of_window(job);
        if end <= job.from && job.stop > job.from {
            self.is_refused = true;
            return None;
        }
        for _ in 0..MOST_ATTEMPTS {
            if self.run_to(job, end).is_err() {
                break;
            }
            match self.end_of_epoch(job, end) {
                EndOfEpoch::After(limits) => return Some(self.accept(job, end, limits, false)),
                EndOfEpoch::With(limits) => return Some(self.accept(job, end, limits, true)),
                EndOfEpoch::At(earlier) => end = earlier,
                EndOfEpoch::Unclear => break,
            }
            self.counters.cut += 1;
        }
        self.counters.refused += 1;
        self.is_refused = true;
        None
    }

    /// The length of a window that ends neither with the epoch nor with the run (time).
    pub fn window_length(&self) -> f64 {
        0.5 * self.count as f64 / self.contact_rate * self.tiling.window
    }

    fn widest_border(&self) -> u32 {
        self.map.widest_border().min(MOST_RINGS - 1)
    }

    /// End of the next window (offset in the epoch, time).
    fn end_of_window<D, R>(&self, job: &WindowJob<'_, D, R>) -> f64 {
        let discs = self.count as f64;
        let free_time = 0.5 * discs / self.contact_rate;
        // The border of a window must fit between the tiles.
        let widest = f64::from(self.widest_border().saturating_sub(self.tiling.margin + 2));
        let mut length = free_time * self.tiling.window.min(widest / self.tiling.front);
        let logged_bytes = match (job.wants_log, job.all_elastic) {
            (true, _) => size_of::<LoggedContact>(),
            (false, false) => size_of::<ContactEnergy>(),
            (false, true) => 0,
        };
        if logged_bytes > 0 {
            length = length.min(MOST_LOG_BYTES / logged_bytes as f64 / self.contact_rate);
        }
        let left = job.limits.contacts_left() as f64 / self.contact_rate;
        if length > SHARE_OF_EPOCH * left {
            let share = if left > SHORTEST * free_time { SHARE_OF_EPOCH } else { 1.5 };
            length = length.min(share * left + 10.0 / self.contact_rate);
        }
        // No short window before the stop, if the border of a longer one fits.
        let longest = ((1.0 + SHORTEST) * length).min(free_time * widest / self.tiling.front);
        if job.from + longest < job.stop { job.from + length } else { job.stop }
    }

    /// Runs all tiles up to `end` (offset in the epoch, time), until they agree.
    fn run_to<D: Detection, R: Response>(
        &mut self,
        job: &WindowJob<'_, D, R>,
        end: f64,
    ) -> Result<(), Refused> {
        let discs = self.count as f64;
        let free_time = 0.5 * discs / self.contact_rate;
        let left = job.limits.contacts_left() as f64;
        let span = Span {
            from: job.from,
            end,
            time_per_cell: free_time / self.tiling.front,
            event_interval: discs / self.event_rate,
            keeps_times: self.contact_rate * (end - job.from) > 0.9 * left,
        };
        let reach = (self.tiling.front * (end - job.from) / free_time).ceil() as u32;
        let mut selected: Vec<usize> = (0..self.map.tiles()).collect();
        let mut margin = self.tiling.margin;
        for attempt in 0..MOST_ATTEMPTS {
            let border = margin.saturating_add(reach).saturating_add(1);
            if border > self.widest_border() {
                return Err(Refused);
            }
            self.run_tiles(job, &selected, (margin, border), span);
            self.counters.tiles += selected.len() as u64;
            let computed = selected.iter().map(|&tile| self.outcomes[tile].computed);
            self.counters.computed += computed.sum::<u64>();
            self.counters.repeated += if attempt > 0 { selected.len() as u64 } else { 0 };
            if self.outcomes.iter().any(|outcome| outcome.needs_order) {
                return Err(Refused);
            }
            selected = self.tiles_that_disagree();
            if selected.is_empty() {
                return Ok(());
            }
            margin += WIDENING;
        }
        Err(Refused)
    }

    /// Runs some tiles, each on one of the threads.
    fn run_tiles<D: Detection, R: Response>(
        &mut self,
        job: &WindowJob<'_, D, R>,
        selected: &[usize],
        (margin, border): (u32, u32),
        span: Span,
    ) {
        let (map, discs, epoch, is_fresh) = (&self.map, &self.discs, &self.epoch, self.is_fresh);
        let mut wanted = selected.iter().peekable();
        let tasks: Vec<(usize, &mut Outcome)> = self
            .outcomes
            .iter_mut()
            .enumerate()
            .filter(|(tile, _)| wanted.next_if(|&&next| next == *tile).is_some())
            .collect();
        let tasks = Mutex::new(tasks.into_iter());
        let next = || tasks.lock().unwrap_or_else(PoisonError::into_inner).next();
        let work = |workspace: &mut Workspace| {
            while let Some((tile, outcome)) = next() {
                let task = Task { map, discs, tile, margin, border, epoch, is_fresh, span };
                workspace.run(job, task, outcome);
            }
        };
        let Some((first, others)) = self.workspaces.split_first_mut() else { return };
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
                        found.lock().unwrap_or_else(PoisonError::into_inner).extend([tile, neighbour]);
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
        let last = self.outcomes.iter().filter_map(|outcome| outcome.last).map(|(time, _)| time);
        let last = last.fold(f64::NEG_INFINITY, f64::max);
        let at_last =
            self.outcomes.iter().filter(|outcome| outcome.last.is_some_and(|(time, _)| time == last));
        if at_last.map(|outcome| outcome.at_last).sum::<u64>() > 1 {
            // Their bodies must be kept for contacts at the same time after the window.
            return EndOfEpoch::Unclear;
        }
        let mut limits = job.limits;
        let mut fast: Vec<_> = self.outcomes.iter().flat_map(|outcome| &outcome.fast).collect();
        fast.sort_by(|a, b| a.places.time.total_cmp(&b.places.time));
        for contact in fast {
            if contact.places.time > limits.time() {
                break;
            }
            let accepted = limits.accept(job.world, job.names, contact.places, contact.velocities, 0.0);
            if accepted.is_err() || limits.stale_contact().is_some() {
                return EndOfEpoch::Unclear;
            }
        }
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
        let mut times: Vec<f64> = self.outcomes.iter().flat_map(|outcome| &outcome.times).copied().collect();
        if (times.len() as u64) < left {
            // The times were not kept, since so many contacts were not expected.
            return EndOfEpoch::Unclear;
        }
        let (_, &mut time, _) = times.select_nth_unstable_by(left as usize - 1, f64::total_cmp);
        if time < end { EndOfEpoch::At(time) } else { EndOfEpoch::Unclear }
    }

    /// Makes the outcomes the state.
    fn accept<D, R>(
        &mut self,
        job: &WindowJob<'_, D, R>,
        end: f64,
        limits: Limits,
        ends_epoch: bool,
    ) -> Window {
        let sum = |of: fn(&Outcome) -> u64| self.outcomes.iter().map(of).sum::<u64>();
        let contacts = sum(|outcome| outcome.contacts);
        let (crossings, stale) = (sum(|outcome| outcome.crossings), sum(|outcome| outcome.stale));
        self.done.crossings += crossings;
        self.done.stale += stale;
        let length = end - job.from;
        if contacts > 0 && length > 0.0 {
            self.contact_rate = contacts as f64 / length;
            self.event_rate = (2 * contacts + crossings + stale) as f64 / length;
        } else {
            // Longer windows; and none, if they do not help.
            self.contact_rate *= 0.5;
            self.event_rate *= 0.5;
        }
        let last = self.outcomes.iter().filter_map(|outcome| outcome.last).max_by(|a, b| a.0.total_cmp(&b.0));
        let mut log: Vec<LoggedContact> = Vec::new();
        if job.wants_log {
            log.reserve_exact(contacts as usize);
            self.outcomes.iter().for_each(|outcome| log.extend_from_slice(&outcome.log));
            log.sort_unstable_by(|a, b| a.time.total_cmp(&b.time).then(a.bodies.cmp(&b.bodies)));
        }
        let inelastic = self.inelastic_contacts();
        for (discs, outcome) in self.discs.iter_mut().zip(&mut self.outcomes) {
            std::mem::swap(discs, &mut outcome.discs);
        }
        debug_assert_eq!(self.discs().count(), self.count, "a disc is in no tile, or in two");
        self.is_fresh = false;
        self.counters.windows += 1;
        self.counters.contacts += contacts;
        Window { end, contacts, last, limits, ends_epoch, log, inelastic }
    }

    /// The inelastic contacts of all tiles, their energies in order of time.
    fn inelastic_contacts(&self) -> InelasticContacts {
        let mut all = InelasticContacts::default();
        for InelasticContacts { energies, last_contacts, guarded } in
            self.outcomes.iter().map(|outcome| &outcome.inelastic)
        {
            all.energies.extend_from_slice(energies);
            all.last_contacts.extend_from_slice(last_contacts);
            all.guarded += guarded;
        }
        // Stable: the energies of each tile are in order already.
        all.energies.sort_by(|a, b| a.time.total_cmp(&b.time).then(a.bodies.cmp(&b.bodies)));
        all
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

/// The rate of contacts of a gas of these bodies in equilibrium (1/time): √π n σ χ √(kT/m) for each
/// body, with χ of D. Henderson, Mol. Phys. 30, 971 (1975). Only for the length of the first
/// window; 0 at rest.
fn expected_contact_rate(world: &World) -> f64 {
    let bodies = world.bodies().len() as f64;
    let area = world.bounds().area();
    let sum = |of: fn(&crate::Body) -> f64| world.bodies().iter().map(of).sum::<f64>() / bodies;
    let diameter = 2.0 * sum(|body| body.kind.molecule.bounding_radius());
    let filled = (bodies / area * 0.25 * std::f64::consts::PI * diameter * diameter).min(0.9);
    let contact_value = (1.0 - 7.0 / 16.0 * filled) / (1.0 - filled).powi(2);
    let speed_squared =
        world.motions().iter().map(|motion| motion.velocity.length_squared()).sum::<f64>() / bodies;
    let thermal = (0.5 * speed_squared).sqrt();
    let rate = std::f64::consts::PI.sqrt() * bodies / area * diameter * contact_value * thermal * bodies;
    if rate.is_finite() { rate } else { 0.0 }
}
