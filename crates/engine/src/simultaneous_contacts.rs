//! Counter of the contacts of each body at one instant, and its limit.

#![allow(clippy::inline_always, reason = "compiled with the instructions of the caller")]

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::Body;

/// Contacts of one body at one instant after which a run counts as stalled. A body hit from all
/// sides at one time needs a few; a fully inelastic pile needs ever more.
pub(crate) const MOST_CONTACTS_AT_ONCE: u32 = 1000;

/// Contacts at one instant, for each body with a contact at that instant.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct SimultaneousContacts {
    /// The instant, as an offset in the epoch (time): that of the last contact, or of the last edit
    /// if that is later.
    pub time: f64,
    pub counts: BTreeMap<u32, u32>,
}

impl SimultaneousContacts {
    /// Whether a contact at `time` (offset in the epoch) follows another at the same instant. If
    /// not, the counts are reset.
    #[inline(always)]
    pub fn repeats(&mut self, time: f64) -> bool {
        if time > self.time {
            self.time = time;
            if !self.counts.is_empty() {
                self.counts.clear();
            }
            return false;
        }
        true
    }

    /// Counts a contact at the same instant as another; returns the body with too many contacts, if
    /// there is one, and their number.
    #[cold]
    #[inline(never)]
    pub fn count(&mut self, indices: [u32; 2], bodies: &[Body]) -> Option<(u32, u32)> {
        indices.into_iter().find_map(|index| {
            let contacts = self.counts.entry(index).or_default();
            *contacts += u32::from(!bodies[index as usize].is_fixed());
            (*contacts > MOST_CONTACTS_AT_ONCE).then_some((index, *contacts))
        })
    }

    /// Moves the origin of time by `offset`.
    pub fn rebase(&mut self, offset: f64) {
        self.time -= offset;
    }

    /// Resets the counts at the start of the epoch, unless this is the same instant.
    pub fn begin(&mut self) {
        if self.time < 0.0 {
            *self = Self::default();
        }
    }
}
