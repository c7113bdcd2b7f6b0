//! Software prefetching for the next events, in systems that do not fit into the caches.
//!
//! Successive events are far apart in space, so in a large system nearly all memory that an event
//! touches misses the caches. The calendar queue holds the order of the next events. With each bin
//! that is opened, the memory for later bins is prefetched one link of the chain (bin, body, cell,
//! neighbours) at a time, because an address must be loaded before it can be followed. Prefetches
//! change no result.

use super::{
    body_record::BodyRecord, calendar::Calendar, neighbour_lists::NeighbourLists, simd,
    slot::INDEX_MASK,
};

/// Number of bodies from which on prefetching pays. Smaller systems fit into the caches, and
/// prefetching costs 5%.
pub(super) const MIN_BODIES: usize = 1 << 15;

/// Distance in bins of each step, for the first, second, … body of a bin, whose index is known once
/// the link before it is loaded. Smaller: memory answers too late. Larger: more lines are evicted
/// before their use, and more events are inserted into these bins after their prefetch. To be
/// measured again if the width of a bin changes.
const BODY_BINS: [u32; MAX_BODIES] = [19, 17, 15, 13, 12, 11];
const LIST_BINS: u32 = 9;
const NEIGHBOUR_BINS: u32 = 5;

/// Bodies of a bin for which memory is prefetched.
const MAX_BODIES: usize = 6;

/// The same distances where bins are cache lines, which hold fewer events.
const RECORD_LINES: u32 = 24;
const LIST_LINES: u32 = 14;
const NEIGHBOUR_LINES: u32 = 8;

/// Prefetches for the next bins; called before a bin is opened.
#[inline(never)]
pub(super) fn prefetch_next(
    calendar: &Calendar,
    records: &[BodyRecord],
    neighbour_lists: &NeighbourLists,
) {
    if calendar.has_lines() {
        return prefetch_lines(calendar, records, neighbour_lists);
    }
    for (nth, bins) in BODY_BINS.into_iter().enumerate() {
        if let Some(body) = calendar.bodies_in_list(bins).nth(nth) {
            simd::prefetch(records, body as usize);
            calendar.prefetch(body);
        }
    }
    for body in calendar.bodies_in_list(LIST_BINS).take(MAX_BODIES) {
        let record = &records[body as usize];
        neighbour_lists.prefetch(record.cell());
        simd::prefetch(records, record.partner() as usize);
        calendar.prefetch(record.partner());
    }
    for body in calendar.bodies_in_list(NEIGHBOUR_BINS).take(MAX_BODIES) {
        let record = &records[body as usize];
        // A multi-cell body has no cell.
        for slot in neighbour_lists.first(record.cell()).into_iter().flatten() {
            simd::prefetch(records, (slot & INDEX_MASK) as usize);
        }
        neighbour_lists.prefetch(records[record.partner() as usize].cell());
    }
}

/// Prefetches for the next bins that are cache lines. Of bodies whose event has moved, only
/// the record is loaded.
fn prefetch_lines(calendar: &Calendar, records: &[BodyRecord], neighbour_lists: &NeighbourLists) {
    for &body in calendar.bodies_in_line(RECORD_LINES) {
        simd::prefetch(records, body as usize);
    }
    for &body in calendar.bodies_in_line(LIST_LINES) {
        let record = &records[body as usize];
        if calendar.is_in_bin(record.time, LIST_LINES) {
            neighbour_lists.prefetch(record.cell());
            simd::prefetch(records, record.partner() as usize);
        }
    }
    for &body in calendar.bodies_in_line(NEIGHBOUR_LINES) {
        let record = &records[body as usize];
        if !calendar.is_in_bin(record.time, NEIGHBOUR_LINES) {
            continue;
        }
        // A multi-cell body has no cell.
        for slot in neighbour_lists.first(record.cell()).into_iter().flatten() {
            simd::prefetch(records, (slot & INDEX_MASK) as usize);
        }
        neighbour_lists.prefetch(records[record.partner() as usize].cell());
    }
}
