//! Asking memory for what the next events will need, where a system does not fit into the caches.
//!
//! Events follow each other in time, not in space, so in a large system nearly everything that one touches has to come from
//! far away. But the calendar knows what comes: with each bin that is opened, what those some bins later need is asked
//! for, one step of each chain (bin, body, cell, neighbours) at a time, since an address must be there before it can be
//! followed. These are hints only: they change no number.

use super::{
    State,
    body_record::{BodyRecord, INDEX_MASK},
    calendar::Calendar,
    neighbour_lists::NeighbourLists,
    simd,
};

/// Bodies from which on it pays. Below, all is in the caches, and asking costs 5%.
const LEAST_BODIES: usize = 1 << 15;

/// How many bins ahead each step is done: for the first, second, … body of a bin, which is known when the one before has come.
/// Nearer: memory answers too late. Farther: more is replaced before it is used, and more that comes into these bins later has
/// not been asked for. To be measured anew with the width of a bin.
const NTH_OF_BIN: [u32; MOST_OF_BIN] = [19, 17, 15, 13, 12, 11];
const AROUND: u32 = 9;
const NEIGHBOURS: u32 = 5;

/// Bodies of a bin for which this is done.
const MOST_OF_BIN: usize = 6;

/// To be called before a bin is opened.
#[inline(never)]
pub(super) fn prefetch_next(calendar: &Calendar, records: &[BodyRecord], neighbour_lists: &NeighbourLists) {
    for (nth, bins) in NTH_OF_BIN.into_iter().enumerate() {
        if let Some(body) = calendar.coming(bins).nth(nth) {
            simd::prefetch(records, body as usize);
            calendar.prefetch(body);
        }
    }
    for body in calendar.coming(AROUND).take(MOST_OF_BIN) {
        let record = &records[body as usize];
        neighbour_lists.prefetch(record.cell());
        simd::prefetch(records, record.partner() as usize);
        calendar.prefetch(record.partner());
    }
    for body in calendar.coming(NEIGHBOURS).take(MOST_OF_BIN) {
        let record = &records[body as usize];
        // What covers cells lives in none.
        for slot in neighbour_lists.first(record.cell()).into_iter().flatten() {
            simd::prefetch(records, (slot & INDEX_MASK) as usize);
        }
        neighbour_lists.prefetch(records[record.partner() as usize].cell());
    }
}

impl State {
    /// Whether the system is so large that looking ahead pays.
    pub(super) fn is_large(&self) -> bool {
        self.records.len() >= LEAST_BODIES && !self.grid.is_dilute()
    }
}
