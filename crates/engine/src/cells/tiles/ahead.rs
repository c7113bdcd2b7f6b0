//! A window that has been run beyond the present: frequent samples read their state from it, and do
//! not cut it.
//!
//! While such a window lasts, [`Tiles`](super::Tiles) holds the state at its start, and the
//! outcomes of all tiles hold the state at its end. What happens in between is in the courses of
//! the tiles: the two bodies of each contact, and each body that crosses the border of the box, as
//! they move on. A sample needs no more, since motions change at no other times.

use carom_kinematics::Motion;

use super::trim;
use crate::{
    World,
    cells::{body_record::BodyRecord, frame::TileFrame, state::State},
    limits::Limits,
    scheduler::StoredMotions,
    window::{Earlier, InelasticContacts, Window},
};

/// A body as it moves on: what [`StoredMotions`] needs of a disc.
#[derive(Debug, Clone, Copy)]
struct Onwards {
    flight: [f64; 4],
    winding: [i16; 2],
}

impl Onwards {
    fn of(state: &State<TileFrame>, body: u32) -> Self {
        let body = body as usize;
        Self { flight: state.records[body].flight, winding: state.windings[body] }
    }

    fn store(&self, state: &mut StoredMotions<'_>, body: u32, motion: Option<Motion>) {
        let motion = motion.unwrap_or_else(|| BodyRecord::at(self.flight, 0.0).motion());
        state.set_wrapped(body, motion, self.winding);
    }
}

/// A contact in a tile's own cells, and how its bodies move on.
#[derive(Debug, Clone, Copy)]
struct PassedContact {
    /// Offset in the epoch (time).
    time: f64,
    bodies: [u32; 2],
    onwards: [Onwards; 2],
}

/// A body of a tile that crosses the border of the box.
#[derive(Debug, Clone, Copy)]
struct PassedBorder {
    /// Offset in the epoch (time).
    time: f64,
    body: u32,
    /// Number of contacts of the tile before it in this window.
    contacts_before: u32,
    onwards: Onwards,
}

/// The course of a tile in a window: all changes of motions in its own cells, in order.
#[derive(Debug, Clone, Default)]
pub(super) struct Course {
    contacts: Vec<PassedContact>,
    borders: Vec<PassedBorder>,
    /// By contact and by crossing of the border; empty if all bodies are discs.
    motions: Vec<[Motion; 2]>,
    motions_at_border: Vec<Motion>,
}

impl Course {
    /// Bytes for each contact.
    pub const fn bytes_for_contact(holds_molecules: bool) -> usize {
        size_of::<PassedContact>() + if holds_molecules { size_of::<[Motion; 2]>() } else { 0 }
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
    pub fn add_contact(&mut self, state: &State<TileFrame>, time: f64, pair: [u32; 2], bodies: [u32; 2]) {
        let onwards = pair.map(|body| Onwards::of(state, body));
        self.contacts.push(PassedContact { time, bodies, onwards });
        if let [Some(a), Some(b)] = pair.map(|body| state.molecules.motion(body)) {
            self.motions.push([*a, *b]);
        }
    }

    /// Adds a body of a workspace that has crossed the border of the box at `time`; `body` is its
    /// index among all.
    #[inline(never)]
    pub fn add_border(&mut self, state: &State<TileFrame>, time: f64, index: u32, body: u32) {
        let (onwards, contacts_before) = (Onwards::of(state, index), self.contacts.len() as u32);
        self.borders.push(PassedBorder { time, body, contacts_before, onwards });
        self.motions_at_border.extend(state.molecules.motion(index));
    }

    /// Adds the changes from a place on up to a time to a list, in order; returns the place after
    /// them.
    fn list(&self, tile: u32, from: Place, until: f64, list: &mut Vec<Change>) -> Place {
        let contacts = &self.contacts[from.contacts..];
        let borders = &self.borders[from.borders..];
        let contacts = &contacts[..contacts.partition_point(|contact| contact.time <= until)];
        let borders = &borders[..borders.partition_point(|border| border.time <= until)];
        let mut borders_left = borders.iter().zip(from.borders..).peekable();
        let of_border = |(border, place): (&PassedBorder, usize)| Change {
            time: border.time,
            tile,
            what: What::Border(place as u32),
        };
        for (contact, place) in contacts.iter().zip(from.contacts..) {
            while let Some(border) = borders_left.next_if(|(it, _)| it.contacts_before as usize <= place) {
                list.push(of_border(border));
            }
            list.push(Change { time: contact.time, tile, what: What::Contact(place as u32) });
        }
        list.extend(borders_left.map(of_border));
        Place { contacts: from.contacts + contacts.len(), borders: from.borders + borders.len() }
    }

    /// The bodies of a change, one of them twice where there is only one.
    fn bodies(&self, what: What) -> [u32; 2] {
        match what {
            What::Contact(place) => self.contacts[place as usize].bodies,
            What::Border(place) => [self.borders[place as usize].body; 2],
        }
    }

    fn store(&self, what: What, state: &mut StoredMotions<'_>) {
        match what {
            What::Contact(place) => {
                let PassedContact { bodies, onwards, .. } = self.contacts[place as usize];
                let motions = self.motions.get(place as usize);
                for n in 0..2 {
                    onwards[n].store(state, bodies[n], motions.map(|motions| motions[n]));
                }
            }
            What::Border(place) => {
                let PassedBorder { body, onwards, .. } = self.borders[place as usize];
                onwards.store(state, body, self.motions_at_border.get(place as usize).copied());
            }
        }
    }
}

/// A change of motions, by its place in the course of a tile.
#[derive(Debug, Clone, Copy)]
struct Change {
    /// Offset in the epoch (time).
    time: f64,
    tile: u32,
    what: What,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum What {
    Contact(u32),
    Border(u32),
}

/// Numbers of contacts and of crossings of the border of a tile that have passed.
#[derive(Debug, Clone, Copy, Default)]
struct Place {
    contacts: usize,
    borders: usize,
}

/// What all contacts of a job must have in common for a window to serve it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Manner {
    pub wants_log: bool,
    pub all_elastic: bool,
}

/// A window that has been run ahead.
#[derive(Debug, Clone)]
pub(super) struct Ahead {
    manner: Manner,
    start: Earlier,
    /// The whole window.
    window: Window,
    /// The present (offset in the epoch, time), and what has passed: contacts of all tiles, and
    /// places in the lists of `window` and in each course.
    reached: f64,
    contacts: u64,
    with_fixed: u64,
    logged: usize,
    encounters: usize,
    energies: usize,
    guarded: u64,
    places: Vec<Place>,
    /// Changes that have passed and are not yet in the world, in order; those before are there if
    /// `is_stored`.
    unstored: Vec<Change>,
    is_stored: bool,
}

impl Ahead {
    pub fn new(manner: Manner, start: Earlier, window: Window, tiles: usize) -> Self {
        Self {
            manner,
            reached: start.from,
            start,
            window,
            contacts: 0,
            with_fixed: 0,
            logged: 0,
            encounters: 0,
            energies: 0,
            guarded: 0,
            places: vec![Place::default(); tiles],
            unstored: Vec::new(),
            is_stored: false,
        }
    }

    pub fn heap_bytes(&self) -> usize {
        self.unstored.capacity() * size_of::<Change>() + self.window.heap_bytes()
    }

    /// Whether it serves a job of this manner at `now` (offset in the epoch, time).
    pub fn suits(&self, manner: Manner, now: f64) -> bool {
        manner == self.manner && now == self.reached
    }

    /// The state at its start.
    pub fn into_start(self) -> Earlier {
        self.start
    }

    /// Whether less than half of it has passed.
    pub fn is_in_first_half(&self) -> bool {
        self.reached < 0.5 * (self.start.from + self.window.end)
    }

    pub fn end(&self) -> f64 {
        self.window.end
    }

    /// The part of the window from the present up to `until`, with the limits at its start; none if
    /// the order of its changes depends on more than their times.
    pub fn part<'a>(
        &mut self,
        world: &World,
        until: f64,
        mut limits: Limits,
        course_of: impl Fn(usize) -> &'a Course,
    ) -> Option<Window> {
        let first = self.unstored.len();
        let passed = |(tile, place): (usize, &Place)| {
            course_of(tile).list(tile as u32, *place, until, &mut self.unstored)
        };
        self.places = self.places.iter().enumerate().map(passed).collect();
        let changes = &mut self.unstored[first..];
        // Stable: changes of one tile at the same time stay in order.
        changes.sort_by(|a, b| a.time.total_cmp(&b.time));
        let contacts = changes.iter().filter(|change| matches!(change.what, What::Contact(_)));
        let pairs = contacts.clone().map(|contact| course_of(contact.tile as usize).bodies(contact.what));
        let (count, with_fixed) = pairs.fold((0, 0), |(count, with_fixed), pair| {
            let meets_fixed = pair.into_iter().any(|body| world.bodies[body as usize].is_fixed());
            (count + 1, with_fixed + u64::from(meets_fixed))
        });
        let last = contacts.clone().next_back();
        let at_last = contacts.rev().take_while(|contact| last.is_some_and(|last| last.time == contact.time));
        if at_last.count() > 1 || changes.chunk_by(|a, b| a.time == b.time).any(|now| is_tie(now, &course_of))
        {
            return None;
        }
        let last = last.map(|last| (last.time, course_of(last.tile as usize).bodies(last.what)));
        let has_guard = !world.last_contacts.is_empty() && !self.manner.wants_log;
        let last_contacts = if has_guard { last_contacts(changes, &course_of) } else { Vec::new() };
        let log = part_of(&self.window.log[self.logged..], |contact| contact.time <= until);
        let encounters = &self.window.encounters[self.encounters..];
        let encounters = part_of(encounters, |encounter| encounter.contact.time <= until);
        let energies = &self.window.inelastic.energies[self.energies..];
        let energies = part_of(energies, |energy| energy.time <= until);
        let guarded = energies.iter().filter(|energy| energy.spared.is_some()).count() as u64;
        self.reached = until;
        self.contacts += count;
        self.with_fixed += with_fixed;
        self.logged += log.len();
        self.encounters += encounters.len();
        self.energies += energies.len();
        self.guarded += guarded;
        let inelastic = InelasticContacts { energies, last_contacts, guarded };
        limits.count_contacts(count);
        Some(Window {
            contacts: count,
            last,
            log,
            encounters,
            with_fixed,
            inelastic,
            ..Window::without_contacts(until, limits)
        })
    }

    /// Whether the world holds the state at a moment of this window.
    pub fn is_stored(&self) -> bool {
        self.is_stored
    }

    /// Stores the changes since the world was last brought up to date.
    pub fn store_changes<'a>(
        &mut self,
        state: &mut StoredMotions<'_>,
        course_of: impl Fn(usize) -> &'a Course,
    ) {
        for change in self.unstored.drain(..) {
            course_of(change.tile as usize).store(change.what, state);
        }
    }

    /// Stores all changes that have passed, where the state holds that at the start of the window.
    pub fn store_all<'a>(&self, state: &mut StoredMotions<'_>, course_of: impl Fn(usize) -> &'a Course) {
        let mut changes = Vec::new();
        for tile in 0..self.places.len() {
            course_of(tile).list(tile as u32, Place::default(), self.reached, &mut changes);
        }
        changes.sort_by(|a, b| a.time.total_cmp(&b.time));
        for change in changes {
            course_of(change.tile as usize).store(change.what, state);
        }
    }

    /// Notes that the world holds the present state.
    pub fn note_stored(&mut self) {
        self.is_stored = true;
        self.unstored.clear();
    }

    /// The rest of the window.
    pub fn rest(mut self) -> Window {
        let reached = self.reached;
        let inelastic = &mut self.window.inelastic;
        inelastic.energies.drain(..self.energies);
        inelastic.guarded -= self.guarded;
        Window {
            contacts: self.window.contacts - self.contacts,
            last: self.window.last.filter(|(time, _)| *time > reached),
            log: self.window.log.split_off(self.logged),
            encounters: self.window.encounters.split_off(self.encounters),
            with_fixed: self.window.with_fixed - self.with_fixed,
            ..self.window
        }
    }
}

/// The first elements of a list, for which a condition holds.
fn part_of<T: Copy>(list: &[T], is_in: impl Fn(&T) -> bool) -> Vec<T> {
    list[..list.partition_point(is_in)].to_vec()
}

/// The times of the last contacts of the bodies in these changes, each perhaps after earlier ones.
fn last_contacts<'a>(changes: &[Change], course_of: &impl Fn(usize) -> &'a Course) -> Vec<(u32, f64)> {
    let contacts = changes.iter().filter(|change| matches!(change.what, What::Contact(_)));
    let of =
        |change: &Change| course_of(change.tile as usize).bodies(change.what).map(|body| (body, change.time));
    contacts.flat_map(of).collect()
}

/// Whether a body has changed in two tiles, in one of them perhaps twice, at one time: that of all
/// these changes.
fn is_tie<'a>(changes: &[Change], course_of: &impl Fn(usize) -> &'a Course) -> bool {
    if changes.iter().all(|change| change.tile == changes[0].tile) {
        return false;
    }
    let of =
        |change: &Change| course_of(change.tile as usize).bodies(change.what).map(|body| (body, change.tile));
    let mut bodies: Vec<(u32, u32)> = changes.iter().flat_map(of).collect();
    bodies.sort_unstable();
    bodies.dedup();
    bodies.windows(2).any(|pair| pair[0].0 == pair[1].0)
}
