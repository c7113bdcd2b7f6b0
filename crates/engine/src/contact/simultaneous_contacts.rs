//! Counter of the contacts of each body at one instant, and its limit.

#![allow(
    clippy::inline_always,
    reason = "compiled with the instructions of the caller"
)]

use std::collections::BTreeMap;

use carom_kinematics::DragClock;
use serde::{Deserialize, Serialize};

use crate::world::body::Body;

/// Contacts of one body at one instant after which a run counts as stalled. A body hit from all
/// sides at one time needs a few; a fully inelastic pile needs ever more.
pub(crate) const MAX_CONTACTS_AT_ONCE: u32 = 1000;

/// Contacts at one instant, for each body with a contact at that instant.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct SimultaneousContacts {
    /// The instant, as an offset in the epoch (time): that of the last contact, or of the last edit
    /// if that is later.
    pub time: f64,
    /// For each body, its contacts that follow another of its own at this instant; bodies that had
    /// one contact have 0, apart from `first`.
    pub counts: BTreeMap<u32, u32>,
    /// The bodies of the first contact at this instant. Entered into `counts` at the end of an
    /// epoch.
    #[serde(skip)]
    first: Option<[u32; 2]>,
}

impl SimultaneousContacts {
    /// Whether a contact of two bodies at `time` (offset in the epoch) follows another contact of
    /// one of them at the same instant. Contacts of other bodies at this instant have no influence.
    #[inline(always)]
    pub fn repeats(&mut self, bodies: [u32; 2], time: f64) -> bool {
        if time > self.time {
            self.time = time;
            self.first = Some(bodies);
            if !self.counts.is_empty() {
                self.counts.clear();
            }
            return false;
        }
        self.enter(bodies)
    }

    /// Enters the bodies of a contact at the present instant; returns whether one of them had a
    /// contact before.
    #[cold]
    #[inline(never)]
    fn enter(&mut self, bodies: [u32; 2]) -> bool {
        self.enter_first();
        let repeats = bodies.iter().any(|body| self.counts.contains_key(body));
        for body in bodies {
            self.counts.entry(body).or_default();
        }
        repeats
    }

    fn enter_first(&mut self) {
        for body in self.first.take().into_iter().flatten() {
            self.counts.entry(body).or_default();
        }
    }

    /// Counts a contact that follows another of one of its bodies at the same instant; returns the
    /// body with too many contacts, if there is one, and their number.
    #[cold]
    #[inline(never)]
    pub fn count(&mut self, indices: [u32; 2], bodies: &[Body]) -> Option<(u32, u32)> {
        indices.into_iter().find_map(|index| {
            let contacts = self.counts.entry(index).or_default();
            *contacts += u32::from(!bodies[index as usize].is_fixed());
            (*contacts > MAX_CONTACTS_AT_ONCE).then_some((index, *contacts))
        })
    }

    /// Moves the origin of time by `offset`, at the end of an epoch.
    pub fn rebase(&mut self, offset: f64, clock: DragClock) {
        self.enter_first();
        self.time = clock.restarted(self.time, offset);
    }

    /// Resets the counts at the start of the epoch, unless this is the same instant.
    pub fn start(&mut self) {
        if self.time < 0.0 {
            *self = Self::default();
        }
    }
}
