//! The run of one tile through a window: its discs and those of a border are copied into a
//! workspace, run, and copied back.

use std::time::Instant;

use carom_detection::Detection;
use carom_response::Response;
use glam::DVec2;

use super::{
    border_log::{BorderLog, Change, Places},
    map::TileMap,
    resting::{RestingDisc, TileDiscs},
};
use crate::{
    TileWork, World,
    cells::{
        body_record::Kind,
        frame::TileFrame,
        grid::CellGrid,
        simd::{Available, Kernel, Work, dispatch},
        state::{EpochConstants, State},
    },
    limits::Limits,
    scheduler::ContactEvent,
    simultaneous_contacts::MOST_CONTACTS_AT_ONCE,
    window::{ContactEnergy, FastContact, InelasticContacts, LoggedContact, WindowJob},
};

/// The window that is run.
#[derive(Debug, Clone, Copy)]
pub(super) struct Span {
    /// Start and end (offsets in the epoch, time).
    pub from: f64,
    pub end: f64,
    /// Time in which an influence travels one cell (time).
    pub time_per_cell: f64,
    /// Mean time between two events of a disc (time).
    pub event_interval: f64,
    /// Whether the times of all contacts are kept.
    pub keeps_times: bool,
}

/// The result of the run of a tile. Counts are those of events in its own cells.
#[derive(Debug, Clone, Default)]
pub(super) struct Outcome {
    pub discs: TileDiscs,
    pub border: BorderLog,
    pub contacts: u64,
    /// Contacts in the border as well.
    pub computed: u64,
    pub crossings: u64,
    pub stale: u64,
    /// Events at exactly the end of the window.
    pub at_end: u64,
    /// Time of the last contact (offset in the epoch), its bodies, and the number of contacts then.
    pub last: Option<(f64, [u32; 2])>,
    pub at_last: u64,
    /// Contacts after which a disc is faster than all were at the start of the window, and than
    /// those of this tile have been since.
    pub fast: Vec<FastContact>,
    pub times: Vec<f64>,
    pub log: Vec<LoggedContact>,
    /// Energies, times of last contacts and number of guarded contacts, if not all are elastic.
    pub inelastic: InelasticContacts,
    /// Whether the global order must decide what happens: two contacts of a disc at one instant, or
    /// a contact after which the surfaces separate by rounding alone.
    pub needs_order: bool,
    /// Wall time of the run (seconds), and discs copied from other tiles.
    pub seconds: f64,
    pub copied: usize,
}

impl Outcome {
    /// The work of the run.
    pub fn work(&self) -> TileWork {
        TileWork {
            seconds: self.seconds,
            contacts: self.contacts,
            computed: self.computed,
            copied_bytes: self.copied * size_of::<RestingDisc>(),
            log_bytes: self.border.bytes(),
        }
    }

    fn clear(&mut self) {
        self.border.clear();
        (self.contacts, self.computed) = (0, 0);
        (self.crossings, self.stale, self.at_end) = (0, 0, 0);
        (self.last, self.at_last) = (None, 0);
        self.fast.clear();
        self.times.clear();
        self.log.clear();
        self.inelastic.clear();
        self.needs_order = false;
    }

    /// Adds a contact in the tile's own cells.
    #[inline(always)]
    fn add<D, R>(
        &mut self,
        job: &WindowJob<'_, D, R>,
        span: &Span,
        past: &mut PastContacts,
        contact: &ContactEvent,
        flights: [[DVec2; 2]; 2],
        impact: &Impact,
    ) {
        let ContactEvent { time, bodies, .. } = *contact;
        self.contacts += 1;
        self.at_end += u64::from(time == span.end);
        self.at_last = if self.last.is_some_and(|(last, _)| last == time) { self.at_last + 1 } else { 1 };
        self.last = Some((time, bodies));
        if !past.limits.within(impact.after) {
            past.limits.raise(impact.after);
            self.fast.push(FastContact::new(contact, [flights[0][0], flights[1][0]], impact.after));
        }
        if span.keeps_times {
            self.times.push(time);
        }
        if job.wants_log {
            self.log.push(LoggedContact::new(contact, flights));
        } else if let Some(energy) = impact.energy {
            self.inelastic.guarded += u64::from(impact.is_guarded);
            self.inelastic.energies.push(energy);
        }
    }

    pub fn heap_bytes(&self) -> usize {
        self.discs.heap_bytes()
            + self.border.heap_bytes()
            + self.times.capacity() * size_of::<f64>()
            + self.log.capacity() * size_of::<LoggedContact>()
            + self.inelastic.energies.capacity() * size_of::<ContactEnergy>()
            + self.inelastic.last_contacts.capacity() * size_of::<(u32, f64)>()
    }
}

/// The workspace of a thread.
#[derive(Debug, Clone)]
pub(super) struct Workspace {
    state: State<TileFrame>,
    /// Index of each disc of the workspace among all bodies, ascending: ties between events are
    /// decided as among all bodies.
    bodies: Vec<u32>,
    /// For each disc the partner of its event at the start of the window, among all bodies.
    partners: Vec<u32>,
    /// The time of the last contact of each disc, where there is a guard against inelastic collapse
    /// (offset in the epoch).
    last_contacts: Vec<f64>,
    places: Places,
    /// By the distance of a cell from the tile: the time after which its events have no influence
    /// on the tile.
    useful_until: Vec<f64>,
    loaded: Vec<RestingDisc>,
    order: Vec<u64>,
}

/// The tile that a workspace runs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Task<'a> {
    pub map: &'a TileMap,
    pub discs: &'a [TileDiscs],
    pub tile: usize,
    /// Cells by which a wrong event must be farther from the tile than its influence travels, and
    /// cells of the border.
    pub margin: u32,
    pub border: u32,
    pub epoch: &'a EpochConstants,
    /// Whether the discs have no events yet.
    pub is_fresh: bool,
    pub span: Span,
}

impl Workspace {
    pub fn new(instructions: Available, grid: CellGrid) -> Self {
        Self {
            state: State::new(instructions, grid, TileFrame::default()),
            bodies: Vec::new(),
            partners: Vec::new(),
            last_contacts: Vec::new(),
            places: Places::default(),
            useful_until: Vec::new(),
            loaded: Vec::new(),
            order: Vec::new(),
        }
    }

    pub fn heap_bytes(&self) -> usize {
        self.state.heap_bytes()
            + (self.bodies.capacity() + self.partners.capacity()) * size_of::<u32>()
            + self.last_contacts.capacity() * size_of::<f64>()
            + self.loaded.capacity() * size_of::<RestingDisc>()
            + self.order.capacity() * size_of::<u64>()
    }

    /// Runs a tile through a window.
    pub fn run<D: Detection, R: Response>(
        &mut self,
        job: &WindowJob<'_, D, R>,
        task: Task<'_>,
        outcome: &mut Outcome,
    ) {
        let begun = Instant::now();
        outcome.clear();
        self.load(job, &task);
        outcome.copied = self.bodies.len() - task.discs[task.tile].discs.len();
        dispatch(self.state.instructions, Run(self, job, task, outcome));
        self.store(&task, &mut outcome.discs);
        if !self.last_contacts.is_empty() && !job.wants_log {
            self.store_last_contacts(job.world, outcome);
        }
        outcome.seconds = begun.elapsed().as_secs_f64();
    }

    /// Copies the discs of the tile and of its border.
    fn load<D, R>(&mut self, job: &WindowJob<'_, D, R>, task: &Task<'_>) {
        let Task { map, discs, tile, margin, border, epoch, span, .. } = *task;
        debug_assert!(margin >= 1 && border >= 3, "lemma 2 of the module");
        self.places.lay_out(map.own(tile), border);
        self.useful_until.clear();
        self.useful_until.extend((0..=border + 1).map(|ring| match ring {
            0 => span.end,
            // Events of the outermost ring would carry a disc out of the window.
            _ if ring >= border => f64::NEG_INFINITY,
            _ => span.end - f64::from(ring.saturating_sub(margin)) * span.time_per_cell,
        }));
        self.loaded.clear();
        map.for_each_run(tile, border, |owner, first, count| {
            self.loaded.extend_from_slice(discs[owner].in_cells(first, count));
        });
        self.order.clear();
        let keyed = self.loaded.iter().zip(0_u64..).map(|(disc, place)| u64::from(disc.body) << 32 | place);
        self.order.extend(keyed);
        self.order.sort_unstable();
        let state = &mut self.state;
        state.set_constants(epoch);
        state.records.clear();
        state.windings.clear();
        state.wrapped.begin(0);
        self.bodies.clear();
        self.partners.clear();
        for &key in &self.order {
            let disc = &self.loaded[key as u32 as usize];
            self.partners.push(disc.partner());
            let radius = match epoch.pair_constants {
                Some(_) => 0.0,
                None => job.world.bodies[disc.body as usize].kind.molecule.bounding_radius(),
            };
            state.records.push(disc.record(radius));
            state.windings.push(disc.winding);
            self.bodies.push(disc.body);
        }
        let last_contacts = &job.world.last_contacts;
        self.last_contacts.clear();
        if !last_contacts.is_empty() {
            self.last_contacts.extend(self.bodies.iter().map(|&body| last_contacts[body as usize]));
        }
        state.push_dummy();
        state.neighbour_lists.set_frame(map.window(tile, border));
        state.list_discs(|_| true);
        if !task.is_fresh {
            self.copy_events();
        }
    }

    /// Copies the events of the discs. A partner that is in no cell around a disc has changed
    /// since.
    fn copy_events(&mut self) {
        for (place, &key) in self.order.iter().enumerate() {
            let disc = &self.loaded[key as u32 as usize];
            let kind = disc.kind();
            let (mut partner, mut version) = (0, 0);
            if kind == Kind::Discs {
                // No version of the dummy: the prediction is stale.
                (partner, version) = (self.state.dummy(), 1);
                let cell = self.state.neighbour_lists.index(disc.cell);
                let mut around = self.state.neighbour_lists.seen_from(cell).map(|(index, _)| index);
                if let Some(index) = around.find(|&index| self.bodies[index as usize] == disc.partner()) {
                    (partner, version) = (index, disc.partner_version);
                }
            }
            self.state.records[place].set_event(disc.time, kind, partner, version);
        }
    }

    /// Runs all events up to the end of the window.
    #[inline(always)]
    fn advance<D: Detection, R: Response, K: Kernel>(
        &mut self,
        kernel: K,
        job: &WindowJob<'_, D, R>,
        task: &Task<'_>,
        outcome: &mut Outcome,
    ) {
        let Task { span, is_fresh, .. } = *task;
        let Self { state, bodies, .. } = self;
        let window = *state.neighbour_lists.frame();
        let discs = bodies.len() as u32;
        if is_fresh {
            for disc in 0..discs {
                let events = state.query_neighbours(kernel, disc, span.from);
                state.write_disc_event(job.detection, disc, span.from, &events);
            }
        }
        state.schedule_all(span.event_interval / f64::from(discs.max(1)), span.from);
        let mut past = PastContacts { limits: job.limits, time: f64::NAN, bodies: Vec::new(), at_once: 0 };
        let mut ties = Ties::default();
        while let Some((now, disc)) = self.state.calendar.take_soonest(&self.state.records, span.end, |_| ())
        {
            let record = &self.state.records[disc as usize];
            let (kind, cell) = (record.kind(), record.cell());
            let ring = self.places.ring(&window, cell);
            if now > self.useful_until[ring] {
                continue;
            }
            outcome.needs_order |= ties.are_undecided(now, disc, record.partner() == discs);
            if outcome.needs_order {
                // The global order runs the window.
                return;
            }
            if kind == Kind::Discs {
                let partner = record.partner();
                if self.state.records[partner as usize].version == record.partner_version {
                    self.state.calendar.remove_if_next(partner);
                    let pair = if disc < partner { [disc, partner] } else { [partner, disc] };
                    self.run_contact(kernel, job, &span, outcome, &mut past, (now, pair));
                    continue;
                }
                outcome.stale += u64::from(ring == 0);
            } else if kind.is_crossing() {
                outcome.crossings += u64::from(ring == 0);
                self.state.cross(kernel, disc, kind);
            }
            outcome.at_end += u64::from(ring == 0 && now == span.end);
            let state = &mut self.state;
            let events = state.query_neighbours(kernel, disc, now);
            let next = state.write_disc_event(job.detection, disc, now, &events);
            state.calendar.schedule(&state.records, disc, next);
            let record = &state.records[disc as usize];
            let last_contact = last_contact(&self.last_contacts, disc);
            let change = Change::new(self.bodies[disc as usize], now, record, last_contact);
            outcome.border.note(&self.places, &window, cell, change);
            if record.cell() != cell {
                outcome.border.note(&self.places, &window, record.cell(), change);
            }
        }
    }

    /// The contact of a pair of discs.
    #[inline(always)]
    fn run_contact<D: Detection, R: Response, K: Kernel>(
        &mut self,
        kernel: K,
        job: &WindowJob<'_, D, R>,
        span: &Span,
        outcome: &mut Outcome,
        past: &mut PastContacts,
        (now, pair): (f64, [u32; 2]),
    ) {
        let cells = pair.map(|disc| self.state.records[disc as usize].cell());
        let indices = pair.map(|disc| self.bodies[disc as usize]);
        let contact = self.state.contact_of_discs(pair, now);
        let contact = ContactEvent { bodies: indices, ..contact };
        let (a, b) = (self.state.flight(pair[0], now), self.state.flight(pair[1], now));
        let impact = if job.all_elastic {
            let inverse_masses = self
                .state
                .inverse_mass
                .map_or_else(|| job.world.inverse_masses(indices), |inverse_mass| [inverse_mass; 2]);
            let resolved = job.rules.resolve_discs(contact.image, [a, b], inverse_masses);
            Impact::elastic([a[0], b[0]], resolved.after)
        } else {
            self.resolve_inelastic(job, &contact, pair, [a, b])
        };
        let Self { state, places, last_contacts, .. } = self;
        let window = *state.neighbour_lists.frame();
        outcome.computed += 1;
        outcome.needs_order |= past.advance_to(now);
        let is_own = cells.map(|cell| places.ring(&window, cell) == 0);
        if is_own[0] | is_own[1] {
            // The tile that owns a disc sees all of its contacts.
            outcome.needs_order |= now <= job.instant || past.repeats(indices) || impact.needs_order;
        }
        if is_own[0] {
            outcome.add(job, span, past, &contact, [a, b], &impact);
        }
        state.set_motion(kernel, pair[0], impact.places[0], impact.after[0], now);
        state.set_motion(kernel, pair[1], impact.places[1], impact.after[1], now);
        // Both queries come before both writes: see `State::predict_two_discs`. Not in a closure,
        // which would be compiled without the kernel's instructions.
        let events =
            [state.query_neighbours(kernel, pair[0], now), state.query_neighbours(kernel, pair[1], now)];
        for n in 0..2 {
            let next = state.write_disc_event(job.detection, pair[n], now, &events[n]);
            state.calendar.schedule(&state.records, pair[n], next);
        }
        for n in 0..2 {
            let record = &state.records[pair[n] as usize];
            let change = Change::new(indices[n], now, record, last_contact(last_contacts, pair[n]));
            outcome.border.note(places, &window, cells[n], change);
        }
    }

    /// Resolves a contact where not all are elastic.
    #[inline(never)]
    fn resolve_inelastic<D, R: Response>(
        &mut self,
        job: &WindowJob<'_, D, R>,
        contact: &ContactEvent,
        pair: [u32; 2],
        flights: [[DVec2; 2]; 2],
    ) -> Impact {
        let last_contacts = (!self.last_contacts.is_empty()).then(|| {
            pair.map(|disc| std::mem::replace(&mut self.last_contacts[disc as usize], contact.time))
        });
        let resolved = job.rules.resolve(&LoggedContact::new(contact, flights).encounter(last_contacts));
        let ContactEvent { time, bodies, .. } = *contact;
        let [lost, spared] = [resolved.lost, resolved.spared].map(|energy| energy.unwrap_or(0.0));
        Impact {
            places: resolved.onwards.map(|motion| motion.position),
            after: resolved.onwards.map(|motion| motion.velocity),
            energy: Some(ContactEnergy { time, bodies, lost, spared }),
            is_guarded: resolved.spared.is_some(),
            needs_order: resolved.is_unresolved,
        }
    }

    /// Stores the time of the last contact of each disc of the tile that had one in this window.
    fn store_last_contacts(&self, world: &World, outcome: &mut Outcome) {
        let window = self.state.neighbour_lists.frame();
        let of_discs = self.bodies.iter().zip(&self.last_contacts).zip(&self.state.records);
        let changed = of_discs.filter(|&((&body, &last), record)| {
            last != world.last_contacts[body as usize] && self.places.ring(window, record.cell()) == 0
        });
        outcome.inelastic.last_contacts.extend(changed.map(|((&body, &last), _)| (body, last)));
    }

    /// Copies the discs that are in the cells of the tile.
    fn store(&self, task: &Task<'_>, discs: &mut TileDiscs) {
        let own = task.map.own(task.tile);
        let window = self.state.neighbour_lists.frame();
        let columns = own.size[0];
        let border = task.border + 1;
        let in_tile = (0..self.bodies.len() as u32)
            .filter(|&disc| self.places.ring(window, self.state.records[disc as usize].cell()) == 0)
            .map(|disc| RestingDisc::of(&self.state, disc, &self.bodies, &self.partners));
        discs.fill((columns * own.size[1]) as usize, in_tile, |disc| {
            let [column, row] = window.place(disc.cell);
            ((row - border) * columns + column - border) as usize
        });
    }
}

/// The outcome of a contact of two discs.
#[derive(Debug, Clone, Copy)]
struct Impact {
    /// Positions and velocities with which the run goes on.
    places: [DVec2; 2],
    after: [DVec2; 2],
    /// Its energies, where not all contacts are elastic.
    energy: Option<ContactEnergy>,
    /// Whether the guard against inelastic collapse has changed it.
    is_guarded: bool,
    /// Whether the surfaces separate by rounding alone.
    needs_order: bool,
}

impl Impact {
    #[inline(always)]
    fn elastic(places: [DVec2; 2], after: [DVec2; 2]) -> Self {
        Self { places, after, energy: None, is_guarded: false, needs_order: false }
    }
}

/// The time of the last contact of a disc; 0 without a guard, where no outcome depends on it.
#[inline(always)]
fn last_contact(last_contacts: &[f64], disc: u32) -> f64 {
    last_contacts.get(disc as usize).copied().unwrap_or(0.0)
}

/// The run of a tile, in the build for an instruction set.
struct Run<'a, 'b, D, R>(&'a mut Workspace, &'a WindowJob<'b, D, R>, Task<'a>, &'a mut Outcome);

impl<D: Detection, R: Response> Work for Run<'_, '_, D, R> {
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
    /// The limits of the epoch, with the speed of the fastest disc.
    limits: Limits,
    /// The time of the last contact, and the bodies of all contacts of the tile at that time.
    time: f64,
    bodies: Vec<u32>,
    /// Contacts at that time, in the border as well.
    at_once: u32,
}

impl PastContacts {
    /// Goes on to a contact at `now`. Returns whether the tile has had so many contacts at this
    /// instant that there may be no end of them: in the border, discs may overlap.
    #[inline(always)]
    fn advance_to(&mut self, now: f64) -> bool {
        if now == self.time {
            self.at_once += 1;
        } else {
            (self.time, self.at_once) = (now, 0);
            self.bodies.clear();
        }
        self.at_once > MOST_CONTACTS_AT_ONCE
    }

    /// Whether one of two bodies of the tile has had another contact at this instant.
    #[inline(always)]
    fn repeats(&mut self, bodies: [u32; 2]) -> bool {
        let repeats = !self.bodies.is_empty() && bodies.iter().any(|body| self.bodies.contains(body));
        self.bodies.extend(bodies);
        repeats
    }
}

/// Finds events at one time whose order depends on a partner that the workspace does not hold.
#[derive(Debug, Default)]
struct Ties {
    time: f64,
    disc: u32,
    is_lost: bool,
}

impl Ties {
    /// Whether the event of a disc is at the time of the one before, and the partner of one of them
    /// is not in the workspace.
    #[inline(always)]
    fn are_undecided(&mut self, now: f64, disc: u32, is_lost: bool) -> bool {
        let is_tie = (now == self.time) & (disc != self.disc) & (is_lost | self.is_lost);
        *self = Self { time: now, disc, is_lost };
        is_tie
    }
}
