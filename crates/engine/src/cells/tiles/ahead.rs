//! A window that has been run beyond the present, so that frequent samples do not cut it.
//!
//! While such a window lasts, [`Tiles`](super::Tiles) holds the state at its start, and the
//! outcomes of all tiles hold the state at its end. Each tile has logged the changes of motions in
//! between: the two bodies of each contact, and each body that crosses the border of the box.
//! Motions change at no other times, so the state at a sample follows from this log.

use carom_kinematics::Motion;

use super::trim;
use crate::{
    cells::{body_record::BodyRecord, frame::TileFrame, state::CellState},
    contact::limits::Limits,
    scheduler::StoredMotions,
    window::{InelasticContacts, RestartState, TimeWindow, WindowJob},
    world::World,
};

/// The flight of a body after a change, and the boxes that it has crossed.
#[derive(Debug, Clone, Copy)]
struct FlightAfter {
    flight: [f64; 4],
    winding: [i16; 2],
}

impl FlightAfter {
    fn new(state: &CellState<TileFrame>, body: u32) -> Self {
        let body = body as usize;
        Self {
            flight: state.records[body].flight,
            winding: state.windings[body],
        }
    }

    fn store(&self, state: &mut StoredMotions<'_>, body: u32, motion: Option<Motion>) {
        let motion = motion.unwrap_or_else(|| BodyRecord::at(self.flight, 0.0).motion());
        state.set_wrapped(body, motion, self.winding);
    }
}

/// A contact in a tile's own cells, and the flights of its bodies after it.
#[derive(Debug, Clone, Copy)]
struct PassedContact {
    /// Offset in the epoch (time).
    time: f64,
    bodies: [u32; 2],
    after: [FlightAfter; 2],
}

/// A body of a tile that crosses the border of the box.
#[derive(Debug, Clone, Copy)]
struct PassedBorder {
    /// Offset in the epoch (time).
    time: f64,
    body: u32,
    /// Number of contacts of the tile before it in this window.
    contacts_before: u32,
    after: FlightAfter,
}

/// All changes of motions in a tile's own cells in a window, in order.
#[derive(Debug, Clone, Default)]
pub(super) struct MotionLog {
    contacts: Vec<PassedContact>,
    borders: Vec<PassedBorder>,
    /// By contact and by crossing of the border; empty if all bodies are discs without spins.
    motions: Vec<[Motion; 2]>,
    motions_at_border: Vec<Motion>,
}

impl MotionLog {
    /// Bytes for each contact.
    pub const fn bytes_for_contact(keeps_motions: bool) -> usize {
        size_of::<PassedContact>()
            + if keeps_motions {
                size_of::<[Motion; 2]>()
            } else {
                0
            }
    }

    pub fn clear(&mut self) {
        self.contacts.clear();
        self.borders.clear();
        self.motions.clear();
        self.motions_at_border.clear();
    }

    /// Gives back memory that later windows of the same length will hardly need.
    pub fn trim(&mut self) {
        trim(&mut self.contacts);
        trim(&mut self.motions);
    }

    pub fn heap_bytes(&self) -> usize {
        self.contacts.capacity() * size_of::<PassedContact>()
            + self.borders.capacity() * size_of::<PassedBorder>()
            + self.motions.capacity() * size_of::<[Motion; 2]>()
            + self.motions_at_border.capacity() * size_of::<Motion>()
    }

    /// Adds a contact at `time` of a pair of bodies of a workspace, after it; `bodies` are their
    /// indices among all.
    #[inline(never)]
    pub fn add_contact(
        &mut self,
        state: &CellState<TileFrame>,
        time: f64,
        pair: [u32; 2],
        bodies: [u32; 2],
    ) {
        let after = pair.map(|body| FlightAfter::new(state, body));
        self.contacts.push(PassedContact {
            time,
            bodies,
            after,
        });
        if let [Some(a), Some(b)] = pair.map(|body| state.molecules.motion(body)) {
            self.motions.push([*a, *b]);
        }
    }

    /// Adds a body of a workspace that has crossed the border of the box at `time`; `body` is its
    /// index among all.
    #[inline(never)]
    pub fn add_border(&mut self, state: &CellState<TileFrame>, time: f64, index: u32, body: u32) {
        let (after, contacts_before) = (FlightAfter::new(state, index), self.contacts.len() as u32);
        self.borders.push(PassedBorder {
            time,
            body,
            contacts_before,
            after,
        });
        self.motions_at_border.extend(state.molecules.motion(index));
    }

    /// Adds the changes from a place on up to a time to a list, in order; returns the place after
    /// them.
    fn list(
        &self,
        tile: u32,
        from: LogPlace,
        until: f64,
        list: &mut Vec<MotionChange>,
    ) -> LogPlace {
        let contacts = &self.contacts[from.contacts..];
        let borders = &self.borders[from.borders..];
        let contacts = &contacts[..contacts.partition_point(|contact| contact.time <= until)];
        let borders = &borders[..borders.partition_point(|border| border.time <= until)];
        let mut borders_left = borders.iter().zip(from.borders..).peekable();
        let of_border = |(border, place): (&PassedBorder, usize)| MotionChange {
            time: border.time,
            tile,
            kind: ChangeKind::Border(place as u32),
        };
        for (contact, place) in contacts.iter().zip(from.contacts..) {
            while let Some(border) =
                borders_left.next_if(|(it, _)| it.contacts_before as usize <= place)
            {
                list.push(of_border(border));
            }
            list.push(MotionChange {
                time: contact.time,
                tile,
                kind: ChangeKind::Contact(place as u32),
            });
        }
        list.extend(borders_left.map(of_border));
        LogPlace {
            contacts: from.contacts + contacts.len(),
            borders: from.borders + borders.len(),
        }
    }

    /// The bodies of a change, one of them twice where there is only one.
    fn bodies(&self, kind: ChangeKind) -> [u32; 2] {
        match kind {
            ChangeKind::Contact(place) => self.contacts[place as usize].bodies,
            ChangeKind::Border(place) => [self.borders[place as usize].body; 2],
        }
    }

    fn store(&self, kind: ChangeKind, state: &mut StoredMotions<'_>) {
        match kind {
            ChangeKind::Contact(place) => {
                let PassedContact { bodies, after, .. } = self.contacts[place as usize];
                let motions = self.motions.get(place as usize);
                for n in 0..2 {
                    after[n].store(state, bodies[n], motions.map(|motions| motions[n]));
                }
            }
            ChangeKind::Border(place) => {
                let PassedBorder { body, after, .. } = self.borders[place as usize];
                after.store(
                    state,
                    body,
                    self.motions_at_border.get(place as usize).copied(),
                );
            }
        }
    }
}

/// A change of motions, by its place in the log of a tile.
#[derive(Debug, Clone, Copy)]
struct MotionChange {
    /// Offset in the epoch (time).
    time: f64,
    tile: u32,
    kind: ChangeKind,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ChangeKind {
    Contact(u32),
    Border(u32),
}

/// Numbers of contacts and of crossings of the border in the log of a tile that have passed.
#[derive(Debug, Clone, Copy, Default)]
struct LogPlace {
    contacts: usize,
    borders: usize,
}

impl MotionChange {
    fn is_contact(&self) -> bool {
        matches!(self.kind, ChangeKind::Contact(_))
    }
}

/// The kind of a job: a window that has been run for one serves only jobs of the same kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct JobKind {
    wants_log: bool,
    all_elastic: bool,
}

impl JobKind {
    fn new<D, R>(job: &WindowJob<'_, D, R>) -> Self {
        Self {
            wants_log: job.wants_log,
            all_elastic: job.all_elastic,
        }
    }
}

/// Counts of a window, and lengths of its lists, up to a time in it.
#[derive(Debug, Clone, Copy, Default)]
struct Passed {
    contacts: u64,
    with_fixed: u64,
    guarded: u64,
    log: usize,
    encounters: usize,
    energies: usize,
}

impl Passed {
    /// Goes on by a part of the window.
    fn add(&mut self, part: &TimeWindow) {
        self.contacts += part.contacts;
        self.with_fixed += part.with_fixed;
        self.guarded += part.inelastic.guarded;
        self.log += part.log.len();
        self.encounters += part.encounters.len();
        self.energies += part.inelastic.energies.len();
    }
}

/// A window that has been run ahead.
#[derive(Debug, Clone)]
pub(super) struct WindowAhead {
    kind: JobKind,
    start: RestartState,
    /// The whole window.
    window: TimeWindow,
    /// The present (offset in the epoch, time).
    reached: f64,
    /// The parts of the window and of the log of each tile that have passed.
    passed: Passed,
    places: Vec<LogPlace>,
    /// Changes that have passed and are not yet in the world, in order; those before are there if
    /// `is_stored`.
    unstored: Vec<MotionChange>,
    is_stored: bool,
}

impl WindowAhead {
    /// A window that has been run for this job, later than its stop.
    pub fn new<D, R>(job: &WindowJob<'_, D, R>, window: TimeWindow, tiles: usize) -> Self {
        let last_contacts = job.world.last_contacts.clone();
        Self {
            kind: JobKind::new(job),
            reached: job.from,
            start: RestartState {
                from: job.from,
                limits: job.limits,
                last_contacts,
            },
            window,
            passed: Passed::default(),
            places: vec![LogPlace::default(); tiles],
            unstored: Vec::new(),
            is_stored: false,
        }
    }

    pub fn heap_bytes(&self) -> usize {
        self.unstored.capacity() * size_of::<MotionChange>()
            + self.window.heap_bytes()
            + self.start.last_contacts.capacity() * size_of::<f64>()
            + self.places.capacity() * size_of::<LogPlace>()
    }

    /// Whether it can serve a job.
    pub fn fits<D, R>(&self, job: &WindowJob<'_, D, R>) -> bool {
        JobKind::new(job) == self.kind && job.from == self.reached
    }

    /// Its start (offset in the epoch, time).
    pub fn from(&self) -> f64 {
        self.start.from
    }

    /// The state at its start.
    pub fn into_restart(self) -> RestartState {
        self.start
    }

    /// Whether less than half of it has passed.
    pub fn is_in_first_half(&self) -> bool {
        self.reached < 0.5 * (self.start.from + self.window.end)
    }

    pub fn end(&self) -> f64 {
        self.window.end
    }

    /// The part of the window from the present up to `until`. `limits` are those of its start, with
    /// the fast contacts of this part accepted. None if two changes at one time have no clear
    /// order.
    pub fn part<'a>(
        &mut self,
        world: &World,
        until: f64,
        mut limits: Limits,
        log_of: impl Fn(usize) -> &'a MotionLog,
    ) -> Option<TimeWindow> {
        let changes = list_all(&mut self.places, until, &log_of);
        let contacts = changes.iter().filter(|change| change.is_contact());
        let pairs = contacts.clone().map(|contact| bodies(contact, &log_of));
        let (count, with_fixed) = pairs.fold((0, 0), |(count, with_fixed), pair| {
            let meets_fixed = pair
                .into_iter()
                .any(|body| world.bodies[body as usize].is_fixed());
            (count + 1, with_fixed + u64::from(meets_fixed))
        });
        let last = contacts.clone().next_back();
        let at_last = contacts
            .rev()
            .take_while(|contact| last.is_some_and(|last| last.time == contact.time));
        if at_last.count() > 1
            || changes
                .chunk_by(|a, b| a.time == b.time)
                .any(|now| is_tie(now, &log_of))
        {
            return None;
        }
        let last = last.map(|last| (last.time, bodies(last, &log_of)));
        let has_guard = !world.last_contacts.is_empty() && !self.kind.wants_log;
        let last_contacts = if has_guard {
            last_contacts(&changes, &log_of)
        } else {
            Vec::new()
        };
        let Passed {
            log,
            encounters,
            energies,
            ..
        } = self.passed;
        let energies = part_of(&self.window.inelastic.energies[energies..], |energy| {
            energy.time <= until
        });
        let guarded = energies
            .iter()
            .filter(|energy| energy.spared.is_some())
            .count() as u64;
        limits.count_contacts(count);
        let part = TimeWindow {
            contacts: count,
            last,
            log: part_of(&self.window.log[log..], |contact| contact.time <= until),
            encounters: part_of(&self.window.encounters[encounters..], |it| {
                it.contact.time <= until
            }),
            with_fixed,
            inelastic: InelasticContacts {
                energies,
                last_contacts,
                guarded,
            },
            ..TimeWindow::without_contacts(until, limits)
        };
        self.reached = until;
        self.passed.add(&part);
        self.unstored.extend(changes);
        Some(part)
    }

    /// Whether the world holds the state at a moment of this window.
    pub fn is_stored(&self) -> bool {
        self.is_stored
    }

    /// Stores the changes since the world was last brought up to date.
    pub fn store_changes<'a>(
        &self,
        state: &mut StoredMotions<'_>,
        log_of: impl Fn(usize) -> &'a MotionLog,
    ) {
        store(&self.unstored, state, &log_of);
    }

    /// Stores all changes that have passed, where the state holds that at the start of the window.
    pub fn store_all<'a>(
        &self,
        state: &mut StoredMotions<'_>,
        log_of: impl Fn(usize) -> &'a MotionLog,
    ) {
        let mut places = vec![LogPlace::default(); self.places.len()];
        store(
            &list_all(&mut places, self.reached, &log_of),
            state,
            &log_of,
        );
    }

    /// Notes that the world holds the present state.
    pub fn note_stored(&mut self) {
        self.is_stored = true;
        self.unstored.clear();
    }

    /// The rest of the window.
    pub fn rest(mut self) -> TimeWindow {
        let Passed {
            contacts,
            with_fixed,
            guarded,
            log,
            encounters,
            energies,
        } = self.passed;
        let inelastic = &mut self.window.inelastic;
        inelastic.energies.drain(..energies);
        inelastic.guarded -= guarded;
        TimeWindow {
            contacts: self.window.contacts - contacts,
            last: self.window.last.filter(|(time, _)| *time > self.reached),
            log: self.window.log.split_off(log),
            encounters: self.window.encounters.split_off(encounters),
            with_fixed: self.window.with_fixed - with_fixed,
            ..self.window
        }
    }
}

/// The changes in the logs of all tiles from these places on up to a time, in order; moves the
/// places behind them.
fn list_all<'a>(
    places: &mut [LogPlace],
    until: f64,
    log_of: &impl Fn(usize) -> &'a MotionLog,
) -> Vec<MotionChange> {
    let mut changes = Vec::new();
    for (tile, place) in places.iter_mut().enumerate() {
        *place = log_of(tile).list(tile as u32, *place, until, &mut changes);
    }
    // Stable: changes of one tile at the same time stay in order.
    changes.sort_by(|a, b| a.time.total_cmp(&b.time));
    changes
}

fn store<'a>(
    changes: &[MotionChange],
    state: &mut StoredMotions<'_>,
    log_of: &impl Fn(usize) -> &'a MotionLog,
) {
    for change in changes {
        log_of(change.tile as usize).store(change.kind, state);
    }
}

/// The bodies of a change: see [`MotionLog::bodies`].
fn bodies<'a>(change: &MotionChange, log_of: &impl Fn(usize) -> &'a MotionLog) -> [u32; 2] {
    log_of(change.tile as usize).bodies(change.kind)
}

/// The first elements of a list, for which a condition holds.
fn part_of<T: Copy>(list: &[T], is_in: impl Fn(&T) -> bool) -> Vec<T> {
    list[..list.partition_point(is_in)].to_vec()
}

/// The bodies of the contacts among these changes, with their times, in order: of several times of
/// a body, the last counts.
fn last_contacts<'a>(
    changes: &[MotionChange],
    log_of: &impl Fn(usize) -> &'a MotionLog,
) -> Vec<(u32, f64)> {
    let contacts = changes.iter().filter(|change| change.is_contact());
    contacts
        .flat_map(|contact| bodies(contact, log_of).map(|body| (body, contact.time)))
        .collect()
}

/// Whether a body has changes in the logs of two tiles at one time, which is that of all these
/// changes.
fn is_tie<'a>(changes: &[MotionChange], log_of: &impl Fn(usize) -> &'a MotionLog) -> bool {
    if changes.iter().all(|change| change.tile == changes[0].tile) {
        return false;
    }
    let of = |change: &MotionChange| bodies(change, log_of).map(|body| (body, change.tile));
    let mut in_tiles: Vec<(u32, u32)> = changes.iter().flat_map(of).collect();
    in_tiles.sort_unstable();
    in_tiles.dedup();
    in_tiles.windows(2).any(|pair| pair[0].0 == pair[1].0)
}
