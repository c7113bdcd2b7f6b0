//! The run of one tile through a window: its bodies and those of a border are copied into a
//! workspace, run, and copied back.

#[cfg(not(target_arch = "wasm32"))]
use std::time::Instant;

use carom_detection::Detection;
use carom_response::Response;
use glam::DVec2;

use super::{
    ahead::MotionLog,
    border_log::{BorderChange, BorderLog, Places},
    fixed_bodies::{FixedBodies, RelistedBody, Relisting},
    map::TileMap,
    resting::{MovingBodies, Rest, RestingBody, TileBodies},
    trim,
};
use crate::{
    cells::{
        body_record::{BodyRecord, NO_CELL, RecordKind},
        cell_grid::CellGrid,
        frame::{Numbering, TileFrame},
        multi_cell::Listed,
        pair_classes::PairClasses,
        simd::{AvailableInstructions, Kernel, KernelWork, dispatch},
        state::{CellState, EpochConstants},
    },
    contact::{
        limits::{ContactPlaces, Limits},
        resolution::{ContactPair, Resolved},
        simultaneous_contacts::MAX_CONTACTS_AT_ONCE,
    },
    scheduler::{ContactEvent, TouchingParts},
    tiling::TileWork,
    window::{ContactEnergy, FastContact, InelasticContacts, WindowContact, WindowJob},
    world::{World, counters::SchedulerCounters},
};

/// Version of the dummy, which stands for partners outside the workspace: none that a body has.
const VERSION_OF_DUMMY: u32 = u32::MAX;

/// Events of a window for each body of a workspace, after which the global order runs it: bodies of
/// the border may overlap, and then have any number of events. More: it takes longer until this is
/// found. Fewer: windows are refused without need.
const MAX_EVENTS_PER_BODY: u64 = 1000;

/// The window that is run.
#[derive(Debug, Clone, Copy)]
pub(super) struct TileSpan {
    /// Start and end (offsets in the epoch, time).
    pub from: f64,
    pub end: f64,
    /// Time in which an influence travels one cell (time).
    pub time_per_cell: f64,
    /// Mean time between two events of a body (time).
    pub event_interval: f64,
    /// Whether the times of all contacts are kept.
    pub keeps_times: bool,
    /// Whether the courses of the tiles are kept.
    pub logs_motions: bool,
}

/// The result of the run of a tile. Counts are those of events in its own cells.
#[derive(Debug, Clone, Default)]
pub(super) struct TileOutcome {
    pub bodies: TileBodies,
    pub border: BorderLog,
    pub contacts: u64,
    /// Contacts with a fixed body.
    pub with_fixed: u64,
    /// Contacts in the border as well.
    pub computed: u64,
    pub done: SchedulerCounters,
    /// Events at exactly the end of the window.
    pub at_end: u64,
    /// Time of the last contact (offset in the epoch), its bodies, and the number of contacts then.
    pub last: Option<(f64, [u32; 2])>,
    pub at_last: u64,
    /// Contacts after which a body moves or turns faster than all did at the start of the window,
    /// and than those of this tile have since.
    pub fast: Vec<FastContact>,
    pub times: Vec<f64>,
    /// Times of contacts with fixed bodies that other tiles may touch at the same time, with these.
    pub shared: Vec<(f64, u32)>,
    /// The contacts of discs for their reports, and all other contacts.
    pub log: Vec<WindowContact>,
    pub encounters: Vec<ContactPair>,
    pub motion_log: MotionLog,
    /// Energies, times of last contacts and number of guarded contacts, if not all are elastic.
    pub inelastic: InelasticContacts,
    /// Whether the global order must decide what happens: two contacts of a body at one instant, or
    /// a contact after which the surfaces separate by rounding alone; or whether bodies in the
    /// border, which may overlap, have more events than can be expected.
    pub needs_order: bool,
    /// Whether a contact was found at its own instant: it then comes after others of this instant,
    /// whatever their bodies.
    pub is_found_late: bool,
    /// Wall time of the run (seconds), and size of the bodies copied from other tiles (bytes).
    pub seconds: f64,
    pub copied_bytes: usize,
}

impl TileOutcome {
    /// The work of the run.
    pub fn work(&self) -> TileWork {
        TileWork {
            seconds: self.seconds,
            contacts: self.contacts,
            computed: self.computed,
            copied_bytes: self.copied_bytes,
            log_bytes: self.border.bytes(),
        }
    }

    fn clear(&mut self) {
        self.border.clear();
        (self.contacts, self.with_fixed, self.computed) = (0, 0, 0);
        self.done = SchedulerCounters::default();
        self.at_end = 0;
        (self.last, self.at_last) = (None, 0);
        self.fast.clear();
        self.times.clear();
        self.shared.clear();
        self.log.clear();
        self.encounters.clear();
        self.motion_log.clear();
        self.inelastic.clear();
        self.needs_order = false;
        self.is_found_late = false;
    }

    fn trim(&mut self) {
        self.border.trim();
        self.motion_log.trim();
        trim(&mut self.log);
        trim(&mut self.encounters);
    }

    /// Adds a contact in the tile's own cells.
    #[inline(always)]
    fn add(&mut self, span: &TileSpan, past: &mut PastContacts, impact: &Impact) {
        let Impact {
            time,
            bodies,
            places,
            after,
            spin,
            met_fixed,
        } = *impact;
        self.contacts += 1;
        self.with_fixed += u64::from(met_fixed);
        self.at_end += u64::from(time == span.end);
        self.at_last = if self.last.is_some_and(|(last, _)| last == time) {
            self.at_last + 1
        } else {
            1
        };
        self.last = Some((time, bodies));
        if !past.limits.permit(after, spin) {
            past.limits.raise(after, spin);
            let places = ContactPlaces {
                bodies,
                time,
                places,
            };
            self.fast.push(FastContact {
                places,
                velocities: after,
                spin,
            });
        }
        if span.keeps_times {
            self.times.push(time);
        }
    }

    /// Adds the report or the energies of a contact in the tile's own cells that is not one of two
    /// discs in cells where all contacts are elastic.
    fn add_resolved<D, R>(
        &mut self,
        job: &WindowJob<'_, D, R>,
        encounter: &ContactPair,
        resolved: &Resolved,
    ) {
        let ContactEvent { time, bodies, .. } = encounter.contact;
        if job.wants_log {
            self.encounters.push(*encounter);
            return;
        }
        self.inelastic.guarded += u64::from(resolved.spared.is_some());
        if resolved.lost.is_some() || resolved.spared.is_some() || resolved.work != 0.0 {
            self.inelastic.energies.push(ContactEnergy {
                time,
                bodies,
                lost: resolved.lost.unwrap_or(0.0),
                spared: resolved.spared,
                work: resolved.work,
            });
        }
    }

    pub fn heap_bytes(&self) -> usize {
        self.bodies.heap_bytes()
            + self.border.heap_bytes()
            + self.times.capacity() * size_of::<f64>()
            + self.log.capacity() * size_of::<WindowContact>()
            + self.encounters.capacity() * size_of::<ContactPair>()
            + self.shared.capacity() * size_of::<(f64, u32)>()
            + self.fast.capacity() * size_of::<FastContact>()
            + self.motion_log.heap_bytes()
            + self.inelastic.heap_bytes()
    }
}

/// The workspace of a thread.
#[derive(Debug, Clone)]
pub(super) struct Workspace {
    state: CellState<TileFrame>,
    /// For each body the partner of its event at the start of the window, among all bodies.
    partners: Vec<u32>,
    /// The time of the last contact of each body, where there is a guard against inelastic collapse
    /// (offset in the epoch).
    last_contacts: Vec<f64>,
    places: Places,
    /// By the distance of a cell from the tile: the time after which its events have no influence
    /// on the tile.
    useful_until: Vec<f64>,
    /// The moving bodies of the tile and its border, as they are copied.
    loaded: MovingBodies,
    /// The fixed bodies that those of the workspace may touch, by their indices among all.
    fixed: Vec<u32>,
    /// The lists of the workspace in which they are, and their images there.
    covered: Vec<(u32, Listed)>,
    /// If fixed bodies are listed anew at the start of the window: the cells of the workspace, in
    /// ascending order, and their lists.
    lists: Vec<(u32, u32)>,
    /// Each body of the workspace in order: its index among all, and its place in `loaded`; for a
    /// fixed body, its place in `fixed` plus the length of `loaded`.
    order: Vec<u64>,
}

/// The tile that a workspace runs.
#[derive(Debug, Clone, Copy)]
pub(super) struct TileTask<'a> {
    pub map: &'a TileMap,
    pub bodies: &'a [TileBodies],
    pub fixed: Option<&'a FixedBodies>,
    /// The fixed bodies that are listed anew at the start of the window.
    pub relisting: Option<&'a Relisting>,
    pub tile: usize,
    /// Cells by which a wrong event must be farther from the tile than its influence travels, and
    /// cells of the border.
    pub margin: u32,
    pub border: u32,
    pub epoch: &'a EpochConstants,
    pub pair_classes: &'a PairClasses,
    /// Whether the bodies have no events yet.
    pub is_fresh: bool,
    pub span: TileSpan,
}

impl Workspace {
    pub fn new(instructions: AvailableInstructions, grid: CellGrid) -> Self {
        Self {
            state: CellState::new(instructions, grid, TileFrame::default()),
            partners: Vec::new(),
            last_contacts: Vec::new(),
            places: Places::default(),
            useful_until: Vec::new(),
            loaded: MovingBodies::default(),
            fixed: Vec::new(),
            covered: Vec::new(),
            lists: Vec::new(),
            order: Vec::new(),
        }
    }

    pub fn heap_bytes(&self) -> usize {
        self.state.heap_bytes()
            + (self.state.bodies.0.capacity() + self.partners.capacity()) * size_of::<u32>()
            + self.last_contacts.capacity() * size_of::<f64>()
            + self.loaded.heap_bytes()
            + self.fixed.capacity() * size_of::<u32>()
            + self.covered.capacity() * size_of::<(u32, Listed)>()
            + self.lists.capacity() * size_of::<(u32, u32)>()
            + self.order.capacity() * size_of::<u64>()
    }

    /// Runs a tile through a window.
    pub fn run<D: Detection, R: Response>(
        &mut self,
        job: &WindowJob<'_, D, R>,
        task: TileTask<'_>,
        outcome: &mut TileOutcome,
    ) {
        #[cfg(not(target_arch = "wasm32"))]
        let begun = Instant::now();
        outcome.clear();
        self.load(job.world, &task);
        outcome.copied_bytes = self.loaded.bytes() - task.bodies[task.tile].moving.bytes();
        dispatch(self.state.instructions, Run(self, job, task, outcome));
        outcome.trim();
        outcome.done = self.state.done;
        self.store(&task, &mut outcome.bodies);
        if !self.last_contacts.is_empty() && !job.wants_log {
            self.store_last_contacts(job.world, outcome);
        }
        // Without a clock of the system, the duration stays 0.
        #[cfg(not(target_arch = "wasm32"))]
        {
            outcome.seconds = begun.elapsed().as_secs_f64();
        }
    }

    /// Copies the bodies of the tile and of its border.
    fn load(&mut self, world: &World, task: &TileTask<'_>) {
        let TileTask {
            map,
            bodies,
            tile,
            margin,
            border,
            span,
            ..
        } = *task;
        debug_assert!(margin >= 1 && border >= 3, "lemma 2 of the module");
        self.places.lay_out(map.own(tile), border);
        self.useful_until.clear();
        self.useful_until
            .extend((0..=border + 1).map(|ring| match ring {
                0 => span.end,
                // Events of the outermost ring would carry a body out of the window.
                _ if ring >= border => f64::NEG_INFINITY,
                _ => span.end - f64::from(ring.saturating_sub(margin)) * span.time_per_cell,
            }));
        self.loaded.clear();
        map.for_each_run(tile, border, |owner, first, count| {
            let places = bodies[owner].in_cells(first, count);
            self.loaded.add(&bodies[owner].moving, places);
        });
        self.state
            .neighbour_lists
            .set_frame(map.window(tile, border));
        self.find_fixed_bodies(task);
        self.order.clear();
        let moving = self.loaded.list.iter().map(|body| body.body);
        let keyed = moving.chain(self.fixed.iter().copied()).zip(0_u64..);
        self.order
            .extend(keyed.map(|(body, place)| u64::from(body) << 32 | place));
        self.order.sort_unstable();
        self.copy_bodies(world, task);
        let count = self.loaded.list.len() as u64;
        let is_moving = |index: usize| self.order[index] & u64::from(u32::MAX) < count;
        self.state.list_discs(is_moving);
        self.list_fixed_bodies(world, task.fixed.is_some());
        if !task.is_fresh {
            self.copy_events();
        }
    }

    /// Copies the bodies in their order, without their events.
    fn copy_bodies(&mut self, world: &World, task: &TileTask<'_>) {
        let state = &mut self.state;
        state.set_constants(task.epoch);
        state.done = SchedulerCounters::default();
        state.records.clear();
        state.windings.clear();
        state.wrapped.start(0);
        state.molecules.clear();
        state.bodies.0.clear();
        self.partners.clear();
        let holds_molecules = state.grid.holds_molecules();
        // Of discs that meet only each other, the constants of a pair hold the radius.
        let needs_radius = task.epoch.pair_constants.is_none()
            || task.fixed.is_some()
            || holds_molecules
            || state.grid.is_by_pair();
        for &key in &self.order {
            let (body, place) = ((key >> 32) as u32, key as u32 as usize);
            let radius = if needs_radius {
                world.bodies[body as usize].molecule().bounding_radius()
            } else {
                0.0
            };
            state.bodies.0.push(body);
            if let Some(moving) = self.loaded.list.get(place) {
                self.partners.push(moving.partner());
                state.records.push(moving.record(radius));
                state.windings.push(moving.winding);
                state
                    .molecules
                    .motions
                    .extend(self.loaded.motions.get(place));
            } else {
                let motion = world.motions[body as usize];
                self.partners.push(0);
                let mut record = BodyRecord::new(&motion, radius);
                record.set_cell(NO_CELL);
                state.records.push(record);
                state
                    .windings
                    .push(world.windings[body as usize].map(|boxes| boxes as i16));
                state
                    .molecules
                    .motions
                    .extend(state.grid.keeps_motions().then_some(motion));
            }
        }
        let last_contacts = &world.last_contacts;
        self.last_contacts.clear();
        if !last_contacts.is_empty() {
            self.last_contacts.extend(
                state
                    .bodies
                    .0
                    .iter()
                    .map(|&body| last_contacts[body as usize]),
            );
        }
        let bodies = state.bodies.0.iter().copied();
        state.pair_classes.take_part(task.pair_classes, bodies);
        state.push_dummy();
        state.records[self.order.len()].version = VERSION_OF_DUMMY;
    }

    /// Finds the fixed bodies that those of the workspace may touch.
    fn find_fixed_bodies(&mut self, task: &TileTask<'_>) {
        self.fixed.clear();
        self.covered.clear();
        self.lists.clear();
        let Some(fixed) = task.fixed else { return };
        for (list, cell) in self.state.neighbour_lists.frame().cells() {
            self.covered
                .extend(fixed.in_cell(cell).map(|listed| (list, listed)));
            if let Some(Relisting { after, .. }) = task.relisting {
                self.lists.push((after.index(cell), list));
                self.fixed
                    .extend(after.in_cell(cell).map(|listed| listed.index));
            }
        }
        self.lists.sort_unstable();
        self.fixed
            .extend(self.covered.iter().map(|(_, listed)| listed.index));
        self.fixed.sort_unstable();
        self.fixed.dedup();
    }

    /// Lists these in the cells of the workspace.
    fn list_fixed_bodies(&mut self, world: &World, has_fixed: bool) {
        let Self {
            state,
            fixed,
            covered,
            ..
        } = self;
        let bodies = state.bodies.0.len();
        let holds_molecules = state.grid.holds_molecules();
        state.multi_cell.clear();
        if holds_molecules || has_fixed {
            state.multi_cell.expect_contacts(bodies);
        }
        if fixed.is_empty() {
            return;
        }
        let index_of = |bodies: &[u32], body: u32| bodies.binary_search(&body).unwrap_or(0) as u32;
        for &body in &*fixed {
            let index = index_of(&state.bodies.0, body);
            let drive = world.drive(body as usize);
            let (body, motion) = (&world.bodies[body as usize], &world.motions[body as usize]);
            state
                .multi_cell
                .add(index, body, motion, drive.as_ref(), bodies, holds_molecules);
        }
        let window = *state.neighbour_lists.frame();
        state
            .multi_cell
            .covered
            .lay_out((window.size[0] * window.size[1]) as usize);
        for &(list, Listed { index: body, image }) in &*covered {
            let index = index_of(&state.bodies.0, body);
            state
                .multi_cell
                .covered
                .enter(list, Listed { index, image });
            state.neighbour_lists.set_covered(list, true);
        }
    }

    /// Copies the events of the bodies. A moving partner that is in no cell around a body has
    /// changed since.
    fn copy_events(&mut self) {
        let Self {
            state,
            loaded,
            order,
            ..
        } = self;
        for (index, &key) in order.iter().enumerate() {
            let Some(body) = loaded.list.get(key as u32 as usize) else {
                continue;
            };
            let kind = body.kind();
            let (mut partner, mut version) = (0, 0);
            if kind.is_contact() {
                // The dummy has another version: the prediction is stale. It keeps its own, for a
                // later window in which the partner may be here.
                (partner, version) = (state.dummy(), body.partner_version);
                let cell = state.neighbour_lists.index(body.cell);
                let around = state
                    .neighbour_lists
                    .seen_from(cell)
                    .map(|(index, _)| index);
                let fixed = (0..state.multi_cell.covered_count(cell))
                    .map(|place| state.multi_cell.covered.get(cell, place).index);
                let is_partner =
                    |index: &u32| state.bodies.0.get(*index as usize) == Some(&body.partner());
                if let Some(index) = around.chain(fixed).find(is_partner) {
                    partner = index;
                }
            }
            state.records[index].set_event(body.time, kind, partner, version);
            if let Some(pending) = loaded.pending.get(key as u32 as usize) {
                state.multi_cell.set_pending(index as u32, *pending);
            }
        }
    }

    /// Runs all events up to the end of the window.
    #[inline(always)]
    fn advance<D: Detection, R: Response, K: Kernel>(
        &mut self,
        kernel: K,
        job: &WindowJob<'_, D, R>,
        task: &TileTask<'_>,
        outcome: &mut TileOutcome,
    ) {
        let TileTask { span, is_fresh, .. } = *task;
        let window = *self.state.neighbour_lists.frame();
        let bodies = self.state.dummy();
        if is_fresh {
            self.state
                .predict_all(kernel, job.world, job.detection, span.from);
        } else if let Some(relisting) = task.relisting {
            self.relist_fixed_bodies(kernel, job, relisting, span.from, outcome);
        }
        self.state
            .schedule_all(span.event_interval / f64::from(bodies.max(1)), span.from);
        let mut past = PastContacts {
            limits: job.limits,
            time: f64::NAN,
            bodies: Vec::new(),
            at_once: 0,
        };
        let mut ties = Ties::default();
        let mut events_left = MAX_EVENTS_PER_BODY * (u64::from(bodies) + 100);
        while let Some((now, body)) =
            self.state
                .calendar
                .take_soonest(&self.state.records, span.end, |_| ())
        {
            let record = &self.state.records[body as usize];
            let (kind, cell) = (record.kind(), record.cell());
            let ring = self.places.ring(&window, cell);
            if now > self.useful_until[ring] {
                continue;
            }
            events_left -= 1;
            outcome.needs_order |=
                ties.are_undecided(now, body, record.partner() == bodies) | (events_left == 0);
            if outcome.needs_order {
                // The global order runs the window.
                return;
            }
            if kind.is_contact() {
                let partner = record.partner();
                if self.state.records[partner as usize].version == record.partner_version {
                    self.state.calendar.remove_if_next(partner);
                    let pair = if body < partner {
                        [body, partner]
                    } else {
                        [partner, body]
                    };
                    let contact = if kind == RecordKind::Discs {
                        self.state.contact_of_discs(pair, now)
                    } else {
                        self.state.contact_of_multi_cell_body(body, pair, now)
                    };
                    self.run_contact(kernel, job, task, outcome, &mut past, &contact);
                    continue;
                }
                self.state.count_stale(body);
            } else if kind.is_crossing() {
                self.state.cross(kernel, body, kind);
            } else if kind == RecordKind::Recheck {
                self.state.count_recheck(body);
            }
            outcome.at_end += u64::from(ring == 0 && now == span.end);
            let state = &mut self.state;
            state.predict_and_schedule(kernel, job.world, job.detection, body, now);
            let record = &state.records[body as usize];
            outcome.is_found_late |=
                (ring == 0) & (record.time == now) & record.kind().is_contact();
            let change = || {
                BorderChange::new(
                    state,
                    body,
                    now,
                    self.last_contacts.get(body as usize).copied(),
                )
            };
            outcome.border.note(&self.places, &window, cell, change);
            let cell_after = state.records[body as usize].cell();
            if cell_after != cell {
                outcome
                    .border
                    .note(&self.places, &window, cell_after, change);
                if span.logs_motions && ring == 0 && is_across_border(cell, cell_after) {
                    outcome
                        .motion_log
                        .add_border(state, now, body, state.bodies.among_all(body));
                }
            }
        }
    }

    /// Lists fixed bodies anew at the start of the window, `now`, one after the other, and predicts
    /// the bodies in the cells that each has entered, as the global order does.
    #[inline(never)]
    fn relist_fixed_bodies<D: Detection, R: Response, K: Kernel>(
        &mut self,
        kernel: K,
        job: &WindowJob<'_, D, R>,
        relisting: &Relisting,
        now: f64,
        outcome: &mut TileOutcome,
    ) {
        for RelistedBody {
            body,
            before,
            after,
            entered,
        } in &relisting.bodies
        {
            let Ok(index) = self.state.bodies.0.binary_search(body) else {
                continue;
            };
            for list in before
                .iter()
                .filter_map(|cell| list_of(&self.lists, cell.index))
            {
                if self.state.multi_cell.covered.leave(list, index as u32) {
                    self.state.neighbour_lists.set_covered(list, false);
                }
            }
            for &Listed { index: cell, image } in after {
                if let Some(list) = list_of(&self.lists, cell) {
                    let listed = Listed {
                        index: index as u32,
                        image,
                    };
                    self.state.multi_cell.covered.enter(list, listed);
                    self.state.neighbour_lists.set_covered(list, true);
                }
            }
            let entered = entered.iter();
            let entered = entered.filter_map(|&cell| list_of(&self.lists, cell));
            let mut bodies: Vec<u32> = entered
                .flat_map(|list| self.state.bodies_in(list))
                .collect();
            bodies.sort_unstable();
            bodies.dedup();
            for body in bodies {
                self.predict_at_start(kernel, job, body, now, outcome);
            }
        }
    }

    /// Predicts a body anew at the start of the window, `now`.
    #[inline(always)]
    fn predict_at_start<D: Detection, R: Response, K: Kernel>(
        &mut self,
        kernel: K,
        job: &WindowJob<'_, D, R>,
        body: u32,
        now: f64,
        outcome: &mut TileOutcome,
    ) {
        let window = *self.state.neighbour_lists.frame();
        let state = &mut self.state;
        let time = state.predict(kernel, job.world, job.detection, body, now);
        let record = &state.records[body as usize];
        let (kind, cell) = (record.kind(), record.cell());
        let is_own = self.places.ring(&window, cell) == 0;
        outcome.is_found_late |= is_own & (time == now) & kind.is_contact();
        let last_contact = self.last_contacts.get(body as usize).copied();
        let change = || BorderChange::new(state, body, now, last_contact);
        outcome.border.note(&self.places, &window, cell, change);
    }

    /// The contact of a pair of bodies, which it names by their indices in the workspace.
    #[inline(always)]
    fn run_contact<D: Detection, R: Response, K: Kernel>(
        &mut self,
        kernel: K,
        job: &WindowJob<'_, D, R>,
        task: &TileTask<'_>,
        outcome: &mut TileOutcome,
        past: &mut PastContacts,
        contact: &ContactEvent,
    ) {
        // All parts by themselves: see `EpochLoop::record_discs`.
        let ContactEvent {
            time: now,
            bodies: pair,
            image: [across, up],
            parts,
        } = *contact;
        let indices = pair.map(|body| self.state.bodies.among_all(body));
        let window = *self.state.neighbour_lists.frame();
        let is_fixed = pair.map(|body| self.state.multi_cell.is_fixed(body));
        let cells = pair.map(|body| self.state.records[body as usize].cell());
        let is_own = [0, 1].map(|n| !is_fixed[n] && self.places.ring(&window, cells[n]) == 0);
        // The owner of the first body that moves counts the contact.
        let counts = if is_fixed[0] { is_own[1] } else { is_own[0] };
        outcome.computed += 1;
        outcome.needs_order |= past.advance_to(now);
        if is_own[0] | is_own[1] {
            // The tile that owns a body sees all of its contacts.
            outcome.needs_order |= now <= job.instant || past.repeats(indices);
        }
        if parts == TouchingParts::Discs && job.all_elastic {
            let state = &mut self.state;
            let inverse_masses = state.inverse_masses(job.world, pair);
            let flights = [state.flight(pair[0], now), state.flight(pair[1], now)];
            let resolved = job
                .rules
                .resolve_discs([across, up], flights, inverse_masses);
            let (places, after) = ([flights[0][0], flights[1][0]], resolved.after);
            if counts {
                let met_fixed = resolved.met_fixed;
                let impact = Impact {
                    time: now,
                    bodies: indices,
                    places,
                    after,
                    spin: 0.0,
                    met_fixed,
                };
                outcome.add(&task.span, past, &impact);
                if job.wants_log {
                    let contact = ContactEvent {
                        time: now,
                        bodies: indices,
                        image: [across, up],
                        parts,
                    };
                    outcome.log.push(WindowContact::new(&contact, flights));
                }
            }
            state.flights_changed(kernel, job.world, job.detection, pair, now, [places, after]);
        } else {
            let contact = ContactEvent {
                time: now,
                bodies: indices,
                image: [across, up],
                parts,
            };
            let encounter = self.encounter(job.world, &contact, pair, [is_own[1], is_own[0]]);
            let resolved = job.rules.resolve(&encounter);
            outcome.needs_order |=
                (is_own[0] | is_own[1]) && (resolved.is_unresolved || resolved.points > 1);
            if counts {
                let impact = Impact::new(job.world, &encounter, &resolved);
                outcome.add(&task.span, past, &impact);
                outcome.add_resolved(job, &encounter, &resolved);
            }
            let mut onwards = resolved.onwards;
            if job.world.accelerates() {
                onwards = [0, 1].map(|n| job.world.in_own_frame(indices[n], &onwards[n]));
            }
            self.state
                .motions_changed(kernel, job.world, job.detection, pair, onwards);
        }
        if counts && task.span.logs_motions {
            outcome
                .motion_log
                .add_contact(&self.state, now, pair, indices);
        }
        for n in 0..2 {
            if is_fixed[n] {
                if counts && task.fixed.is_some_and(|fixed| fixed.is_shared(indices[n])) {
                    outcome.shared.push((now, indices[n]));
                }
            } else {
                let last_contact = self.last_contacts.get(pair[n] as usize).copied();
                let change = || BorderChange::new(&self.state, pair[n], now, last_contact);
                outcome.border.note(&self.places, &window, cells[n], change);
            }
        }
    }

    /// The motions just before a contact of a pair of bodies, and the times of their last contacts,
    /// which become this one. The time of a fixed body is updated only if its partner is in the
    /// tile's own cells (`with_own`, for each of the two).
    #[inline(never)]
    fn encounter(
        &mut self,
        world: &World,
        contact: &ContactEvent,
        pair: [u32; 2],
        with_own: [bool; 2],
    ) -> ContactPair {
        let before = [0, 1].map(|n| {
            let motion = self.state.motion(pair[n]);
            world.motion_at(contact.bodies[n], &motion, contact.time)
        });
        let last_contacts = (!self.last_contacts.is_empty()).then(|| {
            [0, 1].map(|n| {
                let last = &mut self.last_contacts[pair[n] as usize];
                let is_updated = with_own[n] || !self.state.multi_cell.is_fixed(pair[n]);
                std::mem::replace(last, if is_updated { contact.time } else { *last })
            })
        });
        ContactPair {
            contact: *contact,
            before,
            last_contacts,
            repeats: false,
        }
    }

    /// Stores the time of the last contact of each body of the tile, and of each fixed body, that
    /// had one in this window.
    fn store_last_contacts(&self, world: &World, outcome: &mut TileOutcome) {
        let window = self.state.neighbour_lists.frame();
        let of_bodies = self
            .state
            .bodies
            .0
            .iter()
            .zip(&self.last_contacts)
            .zip(&self.state.records);
        let changed = of_bodies.filter(|&((&body, &last), record)| {
            last != world.last_contacts[body as usize]
                && (record.cell() == NO_CELL || self.places.ring(window, record.cell()) == 0)
        });
        outcome
            .inelastic
            .last_contacts
            .extend(changed.map(|((&body, &last), _)| (body, last)));
    }

    /// Copies the bodies that are in the cells of the tile.
    fn store(&self, task: &TileTask<'_>, bodies: &mut TileBodies) {
        let own = task.map.own(task.tile);
        let window = self.state.neighbour_lists.frame();
        let columns = own.size[0];
        let border = task.border + 1;
        let in_tile = (0..self.state.dummy())
            .filter(|&body| {
                let cell = self.state.records[body as usize].cell();
                cell != NO_CELL && self.places.ring(window, cell) == 0
            })
            .map(|body| {
                (
                    RestingBody::from_state(&self.state, body, &self.partners),
                    body,
                )
            });
        let rest = Rest {
            motions: &self.state.molecules.motions,
            pending: self.state.multi_cell.all_pending(),
        };
        bodies.fill((columns * own.size[1]) as usize, in_tile, rest, |body| {
            let [column, row] = window.place(body.cell);
            ((row - border) * columns + column - border) as usize
        });
    }
}

/// The list of a cell among those of a workspace ([`Workspace::lists`]), if it is there.
fn list_of(lists: &[(u32, u32)], cell: u32) -> Option<u32> {
    let place = lists.binary_search_by_key(&cell, |&(cell, _)| cell);
    place.ok().map(|place| lists[place].1)
}

/// Whether a body that crosses from a cell into the next also crosses the border of the box.
#[inline(always)]
fn is_across_border(from: [u16; 2], to: [u16; 2]) -> bool {
    from[0].abs_diff(to[0]) > 1 || from[1].abs_diff(to[1]) > 1
}

/// A contact, as far as the limits of the epoch depend on it.
#[derive(Debug, Clone, Copy)]
struct Impact {
    time: f64,
    bodies: [u32; 2],
    /// Positions of the two in the frame in which they fly uniformly, and velocities after it.
    places: [DVec2; 2],
    after: [DVec2; 2],
    /// Magnitude of the faster angular velocity after it (1/time).
    spin: f64,
    met_fixed: bool,
}

impl Impact {
    fn new(world: &World, encounter: &ContactPair, resolved: &Resolved) -> Self {
        let ContactEvent { time, bodies, .. } = encounter.contact;
        let after = &resolved.after;
        Self {
            time,
            bodies,
            places: [0, 1].map(|n| {
                let before = world.in_own_frame(bodies[n], &encounter.before[n]);
                before.position
            }),
            after: [after[0].velocity, after[1].velocity],
            spin: after[0]
                .angular_velocity
                .abs()
                .max(after[1].angular_velocity.abs()),
            met_fixed: resolved.met_fixed,
        }
    }
}

/// The run of a tile, in the build for an instruction set.
struct Run<'a, 'b, D, R>(
    &'a mut Workspace,
    &'a WindowJob<'b, D, R>,
    TileTask<'a>,
    &'a mut TileOutcome,
);

impl<D: Detection, R: Response> KernelWork for Run<'_, '_, D, R> {
    type Output = ();

    #[inline(always)]
    fn with<K: Kernel>(self, kernel: K) {
        let Run(workspace, job, task, outcome) = self;
        workspace.advance(kernel, job, &task, outcome);
    }
}

/// The contacts of a tile so far, as far as later ones depend on them.
#[derive(Debug)]
struct PastContacts {
    /// The limits of the epoch, with the speed of the fastest body.
    limits: Limits,
    /// The time of the last contact, and the bodies of all contacts of the tile at that time.
    time: f64,
    bodies: Vec<u32>,
    /// Contacts at that time, in the border as well.
    at_once: u32,
}

impl PastContacts {
    /// Goes on to a contact at `now`. Returns whether the tile has had so many contacts at this
    /// instant that there may be no end of them: in the border, bodies may overlap.
    #[inline(always)]
    fn advance_to(&mut self, now: f64) -> bool {
        if now == self.time {
            self.at_once += 1;
        } else {
            (self.time, self.at_once) = (now, 0);
            self.bodies.clear();
        }
        self.at_once > MAX_CONTACTS_AT_ONCE
    }

    /// Whether one of two bodies of the tile has had another contact at this instant.
    #[inline(always)]
    fn repeats(&mut self, bodies: [u32; 2]) -> bool {
        let repeats =
            !self.bodies.is_empty() && bodies.iter().any(|body| self.bodies.contains(body));
        self.bodies.extend(bodies);
        repeats
    }
}

/// Finds events at one time whose order depends on a partner that the workspace does not hold.
#[derive(Debug, Default)]
struct Ties {
    time: f64,
    body: u32,
    is_lost: bool,
}

impl Ties {
    /// Whether the event of a body is at the time of the one before, and the partner of one of them
    /// is not in the workspace.
    #[inline(always)]
    fn are_undecided(&mut self, now: f64, body: u32, is_lost: bool) -> bool {
        let is_tie = (now == self.time) & (body != self.body) & (is_lost | self.is_lost);
        *self = Self {
            time: now,
            body,
            is_lost,
        };
        is_tie
    }
}
