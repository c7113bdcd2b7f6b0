//! Windows: parts of an epoch whose contacts a scheduler finds and resolves at once, on any number
//! of threads, before the engine records them in order of time.

#![allow(
    clippy::inline_always,
    reason = "compiled with the instructions of the caller"
)]

use glam::DVec2;

use crate::{
    contact::{
        limits::{ContactPlaces, Limits},
        resolution::{ContactPair, Rules},
    },
    world::{
        World,
        contact_event::{ContactEvent, TouchingParts},
        tags::TagNames,
    },
};

/// A request to run all contacts of a stretch of the epoch at once.
pub struct WindowJob<'a, D, R> {
    pub(crate) world: &'a World,
    pub(crate) detection: &'a D,
    pub(crate) rules: Rules<'a, R>,
    pub(crate) names: &'a TagNames,
    /// The present time (offset in the epoch).
    pub(crate) from: f64,
    /// Latest end of the window (offset in the epoch, time).
    pub(crate) stop: f64,
    /// The limits of the epoch at `from`.
    pub(crate) limits: Limits,
    /// Time of the last contact so far (offset in the epoch).
    pub(crate) instant: f64,
    /// Whether the run ends at a time. If not, the scheduler prepares for single contacts.
    pub(crate) may_use_windows: bool,
    /// Whether all contacts are elastic, and resolved in the frame in which discs fly uniformly.
    pub(crate) all_elastic: bool,
    /// Whether the contacts are reported.
    pub(crate) wants_log: bool,
}

/// The state from which a scheduler must run contacts that have been recorded once more.
#[derive(Debug, Clone)]
pub struct RestartState {
    /// Its time (offset in the epoch).
    pub(crate) from: f64,
    /// The limits of the epoch then.
    pub(crate) limits: Limits,
    /// The times of the last contacts of all bodies then, where there is a guard against inelastic
    /// collapse: see [`World::last_contacts`].
    pub(crate) last_contacts: Vec<f64>,
}

/// A stretch that has been run.
#[derive(Debug, Clone)]
pub struct TimeWindow {
    /// Its end (offset in the epoch, time).
    pub(crate) end: f64,
    /// Number of contacts.
    pub(crate) contacts: u64,
    /// Time and bodies of the last contact.
    pub(crate) last: Option<(f64, [u32; 2])>,
    /// The limits of the epoch at the end, with the contacts subtracted.
    pub(crate) limits: Limits,
    /// Whether the epoch ends with the last contact.
    pub(crate) ends_epoch: bool,
    /// If the contacts were requested: those of two discs where all are elastic, in order, and all
    /// others, in order.
    pub(crate) log: Vec<WindowContact>,
    pub(crate) encounters: Vec<ContactPair>,
    /// Number of contacts with a fixed body, unless the contacts are logged.
    pub(crate) with_fixed: u64,
    /// Effects of the contacts on the ledger and the guard; empty if `log` is requested, and if all
    /// contacts are elastic and no wall moves.
    pub(crate) inelastic: InelasticContacts,
}

impl TimeWindow {
    /// A stretch without contacts.
    pub(crate) fn without_contacts(end: f64, limits: Limits) -> Self {
        let inelastic = InelasticContacts::default();
        let (log, encounters) = (Vec::new(), Vec::new());
        Self {
            end,
            contacts: 0,
            last: None,
            limits,
            ends_epoch: false,
            log,
            encounters,
            with_fixed: 0,
            inelastic,
        }
    }

    pub(crate) fn heap_bytes(&self) -> usize {
        self.log.capacity() * size_of::<WindowContact>()
            + self.encounters.capacity() * size_of::<ContactPair>()
            + self.inelastic.heap_bytes()
    }
}

/// Energies, times of last contacts and number of guarded contacts of a window whose contacts
/// change the energy.
#[derive(Debug, Clone, Default)]
pub(crate) struct InelasticContacts {
    /// The energies of each contact. In order, so that sums have the same rounding.
    pub energies: Vec<ContactEnergy>,
    /// The time of the last contact of each body that had one, where there is a guard against
    /// inelastic collapse (index in [`World::bodies`], offset in the epoch).
    pub last_contacts: Vec<(u32, f64)>,
    /// Number of contacts that the guard has changed.
    pub guarded: u64,
}

impl InelasticContacts {
    pub fn clear(&mut self) {
        self.energies.clear();
        self.last_contacts.clear();
        self.guarded = 0;
    }

    pub fn heap_bytes(&self) -> usize {
        self.energies.capacity() * size_of::<ContactEnergy>()
            + self.last_contacts.capacity() * size_of::<(u32, f64)>()
    }
}

/// The energies of a contact (mass × length² / time²), for the ledger.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactEnergy {
    pub time: f64,
    pub bodies: [u32; 2],
    /// Energy lost in the contact.
    pub lost: f64,
    /// Energy that it would have lost in addition without the guard; none if that changes nothing.
    pub spared: Option<f64>,
    /// Work of a wall that moves.
    pub work: f64,
}

/// A contact after which a body moves or turns faster than all bodies before.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FastContact {
    pub places: ContactPlaces,
    pub velocities: [DVec2; 2],
    /// Magnitude of the faster angular velocity (1/time).
    pub spin: f64,
}

/// A contact of two discs where all contacts are elastic, for its report.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WindowContact {
    pub time: f64,
    pub bodies: [u32; 2],
    image: [i32; 2],
    /// Positions and velocities just before the contact.
    pub flights: [[DVec2; 2]; 2],
}

impl WindowContact {
    #[inline(always)]
    pub fn new(contact: &ContactEvent, flights: [[DVec2; 2]; 2]) -> Self {
        let ContactEvent {
            time,
            bodies,
            image,
            ..
        } = *contact;
        Self {
            time,
            bodies,
            image: image.map(|boxes| boxes as i32),
            flights,
        }
    }

    /// Whether this contact comes before another: see [`ContactEvent::in_order`].
    pub fn precedes(&self, other: &ContactEvent) -> bool {
        self.event().in_order(other).is_lt()
    }

    pub fn event(&self) -> ContactEvent {
        let &Self {
            time,
            bodies,
            image,
            ..
        } = self;
        ContactEvent {
            time,
            bodies,
            image: image.map(i64::from),
            parts: TouchingParts::Discs,
        }
    }
}
