//! Calendar queue: one event for each body, in a ring of bins of equal time, with only the earliest
//! bin sorted.
//!
//! A bounded calendar queue after G. Paul, J. Comput. Phys. 221, 615 (2007). Bins are numbered
//! along time, and the ring holds a fixed number of them from the next one on. Later events go to
//! an overflow list, scanned once per turn of the ring.
//!
//! Bins have two forms. In a system that fits into the caches a bin is a linked list of bodies
//! ([`Links`]): an event that moves leaves nothing behind. In a larger one it is a cache
//! line with the numbers of bodies ([`Lines`]): an event that moves leaves a dead entry, but costs
//! one cache line in place of five. Both give the events in the same order.

mod lines;
mod links;

use self::{lines::Lines, links::Links};
use super::body_record::BodyRecord;

/// Number of bodies from which on bins are cache lines: there both forms take the same time.
/// Smaller: systems that fit into the caches pay for dead entries. Larger: those that do not wait
/// for links.
const MIN_BODIES_FOR_LINES: usize = 100_000;

#[cfg(test)]
thread_local! {
    /// The same for the calendars that this thread lays out, so that a test can run one scene with
    /// either form.
    pub(in crate::cells) static MIN_BODIES: std::cell::Cell<usize> =
        const { std::cell::Cell::new(MIN_BODIES_FOR_LINES) };
}

#[cfg(test)]
fn min_bodies_for_lines() -> usize {
    MIN_BODIES.get()
}

#[cfg(not(test))]
const fn min_bodies_for_lines() -> usize {
    MIN_BODIES_FOR_LINES
}

/// 2^52: a sum with it has the nearest integer in its last bits. The rounding is monotonic, and
/// nothing else is needed.
const SHIFT: f64 = 4_503_599_627_370_496.0;

/// The form of the bins.
#[derive(Debug, Clone)]
enum Bins {
    Links(Links),
    Lines(Box<Lines>),
}

/// The events of all bodies in order of time; the times are in the bodies' records.
#[derive(Debug, Clone)]
pub(super) struct Calendar {
    bins: Bins,
    /// Number of bins in the ring.
    ring: u32,
    /// Number of the next bin to be opened, and its index in the ring.
    next_bin: u64,
    next_place: u32,
    /// Number of the bin before which the overflow list is scanned; no event in it belongs to an
    /// earlier bin.
    next_scan: u64,
    /// Time at which bin 0 begins.
    start: f64,
    bins_per_time: f64,
    /// Events of the opened bins: time and body, the earliest last. An entry is dead if its body's
    /// record has another time.
    open: Vec<(f64, u32)>,
}

impl Default for Calendar {
    fn default() -> Self {
        Self {
            bins: Bins::Links(Links::default()),
            ring: 0,
            next_bin: 0,
            next_place: 0,
            next_scan: 0,
            start: 0.0,
            bins_per_time: 0.0,
            open: Vec::new(),
        }
    }
}

impl Calendar {
    /// Lays out a ring of empty bins from `start` on, for events at this mean interval (times).
    pub fn lay_out(&mut self, bodies: usize, interval: f64, start: f64) {
        if bodies < min_bodies_for_lines() {
            self.lay_out_links(bodies, interval, start);
        } else {
            self.lay_out_lines(bodies, interval, start);
        }
    }

    fn lay_out_links(&mut self, bodies: usize, interval: f64, start: f64) {
        self.ring = Links::ring(bodies as u32);
        match &mut self.bins {
            Bins::Links(links) => links.lay_out(bodies as u32, self.ring),
            Bins::Lines(_) => {
                let mut links = Links::default();
                links.lay_out(bodies as u32, self.ring);
                self.bins = Bins::Links(links);
            }
        }
        self.set_width(links::EVENTS_PER_BIN * interval);
        self.reset_ring(start);
    }

    fn lay_out_lines(&mut self, bodies: usize, interval: f64, start: f64) {
        self.ring = Lines::ring(bodies as u32);
        match &mut self.bins {
            Bins::Lines(lines) => lines.lay_out(self.ring),
            Bins::Links(_) => {
                let mut lines = Box::<Lines>::default();
                lines.lay_out(self.ring);
                self.bins = Bins::Lines(lines);
            }
        }
        self.set_width(lines::EVENTS_PER_BIN * interval);
        self.reset_ring(start);
    }

    /// Of 0 and of subnormal widths the reciprocal is infinite: all events are in one bin.
    fn set_width(&mut self, width: f64) {
        let bins_per_time = 1.0 / width;
        self.bins_per_time = if bins_per_time.is_finite() {
            bins_per_time
        } else {
            0.0
        };
    }

    pub fn heap_bytes(&self) -> usize {
        let of_bins = match &self.bins {
            Bins::Links(links) => links.heap_bytes(),
            Bins::Lines(lines) => lines.heap_bytes(),
        };
        of_bins + self.open.capacity() * size_of::<(f64, u32)>()
    }

    /// Whether bins are cache lines.
    pub fn has_lines(&self) -> bool {
        matches!(self.bins, Bins::Lines(_))
    }

    fn reset_ring(&mut self, start: f64) {
        self.start = start;
        (self.next_bin, self.next_place) = (0, 0);
        self.next_scan = u64::from(self.ring);
        self.open.clear();
    }

    /// Inserts the event of a body at a time, or moves it there.
    #[inline(always)]
    pub fn schedule(&mut self, records: &[BodyRecord], body: u32, time: f64) {
        let bin = self.bin_of(time);
        let is_later = bin >= self.next_bin;
        let place = self.place_of(bin);
        match &mut self.bins {
            Bins::Links(links) => {
                links.unlink(body);
                if is_later {
                    links.link(body, place);
                } else {
                    links.detach(body);
                }
            }
            Bins::Lines(lines) => {
                if is_later {
                    lines.put(body, place);
                }
            }
        }
        if !is_later {
            self.open.push((time, body));
            let last = self.open.len() - 1;
            insert_sorted(records, &mut self.open, last);
        }
    }

    /// The index in the ring of a bin that is not opened yet, or the length of the ring for one
    /// beyond it.
    #[inline(always)]
    fn place_of(&self, bin: u64) -> u32 {
        let ahead = bin.wrapping_sub(self.next_bin);
        let place = (ahead as u32).wrapping_add(self.next_place);
        let place = if place < self.ring {
            place
        } else {
            place.wrapping_sub(self.ring)
        };
        if ahead < u64::from(self.ring) {
            place
        } else {
            self.ring
        }
    }

    /// The number of the bin of a time.
    #[inline(always)]
    fn bin_of(&self, time: f64) -> u64 {
        let place = (time - self.start) * self.bins_per_time;
        // The comparison sends NaN (infinite time, or zero width) far beyond the ring.
        let place = if place < 0.5 * SHIFT {
            place
        } else {
            0.5 * SHIFT
        };
        let place = if place > 0.0 { place } else { 0.0 };
        (place + SHIFT).to_bits() - SHIFT.to_bits()
    }

    /// Removes and returns the earliest event (time, body), if it is not after `stop`. Calls
    /// `opening` before each bin that is opened.
    #[inline(always)]
    pub fn take_soonest(
        &mut self,
        records: &[BodyRecord],
        stop: f64,
        opening: impl Fn(&Self),
    ) -> Option<(f64, u32)> {
        loop {
            while let Some(&(time, body)) = self.open.last() {
                if records[body as usize].time == time {
                    if time > stop {
                        return None;
                    }
                    self.open.pop();
                    return Some((time, body));
                }
                self.open.pop();
            }
            opening(self);
            if self.next_bin < self.next_scan {
                self.open_bin(records);
            } else if !self.scan_overflow_list(records, stop) {
                return None;
            }
        }
    }

    /// Removes the event of a body from the opened bins if it is the next one. After a contact the
    /// event of the partner usually is.
    #[inline(always)]
    pub fn remove_if_next(&mut self, body: u32) {
        let is_next = self.open.last().is_some_and(|&(_, next)| next == body);
        self.open.truncate(self.open.len() - usize::from(is_next));
    }

    /// The bodies in a bin that is a linked list, by its distance from the next one.
    pub fn bodies_in_list(&self, bins: u32) -> impl Iterator<Item = u32> {
        let place = self.place_ahead(bins);
        let links = match &self.bins {
            Bins::Links(links) => Some(links),
            Bins::Lines(_) => None,
        };
        links.into_iter().flat_map(move |links| links.bodies(place))
    }

    /// The bodies in a bin that is a cache line, by its distance from the next one, with those
    /// whose event has moved.
    pub fn bodies_in_line(&self, bins: u32) -> &[u32] {
        match &self.bins {
            Bins::Links(_) => &[],
            Bins::Lines(lines) => lines.bodies(self.place_ahead(bins)),
        }
    }

    /// Whether an event at a time is in a bin, by its distance from the next one.
    pub fn is_in_bin(&self, time: f64, bins: u32) -> bool {
        self.bin_of(time) == self.next_bin + u64::from(bins)
    }

    fn place_ahead(&self, bins: u32) -> u32 {
        let place = self.next_place + bins % self.ring;
        if place < self.ring {
            place
        } else {
            place - self.ring
        }
    }

    /// Prefetches the link that is read and written when a body is moved.
    pub fn prefetch(&self, body: u32) {
        if let Bins::Links(links) = &self.bins {
            links.prefetch(body);
        }
    }

    /// Opens the next bin; no event is open before.
    #[inline(always)]
    fn open_bin(&mut self, records: &[BodyRecord]) {
        let (bin, place) = (self.next_bin, self.next_place);
        self.next_bin += 1;
        self.next_place += 1;
        if self.next_place == self.ring {
            self.next_place = 0;
        }
        match &mut self.bins {
            Bins::Links(links) => links.empty(place, |body| {
                self.open.push((records[body as usize].time, body));
            }),
            Bins::Lines(_) => self.open_line(records, bin, place),
        }
        let open = self.open.as_mut_slice();
        for place in 1..open.len() {
            insert_sorted(records, open, place);
        }
        if self.has_lines() {
            // An event that has moved within its bin is there twice.
            self.open.dedup();
        }
    }

    /// Opens a bin that is a line: its entries whose event is still there.
    fn open_line(&mut self, records: &[BodyRecord], bin: u64, place: u32) {
        let Bins::Lines(lines) = &mut self.bins else {
            return;
        };
        let open = &mut self.open;
        lines.empty(place, |body| open.push((records[body as usize].time, body)));
        let mut kept = 0;
        for index in 0..self.open.len() {
            let entry = self.open[index];
            self.open[kept] = entry;
            kept += usize::from(self.bin_of(entry.0) == bin);
        }
        self.open.truncate(kept);
    }

    /// Scans the overflow list and inserts its events. If the ring is empty, it starts anew at the
    /// earliest of them. Returns false if this is after `stop` or there is none.
    #[cold]
    #[inline(never)]
    fn scan_overflow_list(&mut self, records: &[BodyRecord], stop: f64) -> bool {
        let is_lasting = |calendar: &Self, body: &u32| {
            // An entry whose event has moved into the ring is dead.
            calendar.bin_of(records[*body as usize].time) >= calendar.next_bin
        };
        let mut overflow: Vec<u32> = match &self.bins {
            Bins::Links(links) => links.bodies(self.ring).collect(),
            Bins::Lines(lines) => {
                let all = lines.overflow().iter().copied();
                all.filter(|body| is_lasting(self, body)).collect()
            }
        };
        let times = overflow.iter().map(|&body| records[body as usize].time);
        let soonest = times.fold(f64::INFINITY, f64::min);
        let is_empty = match &self.bins {
            Bins::Links(links) => links.is_empty(),
            Bins::Lines(lines) => lines.is_empty(),
        };
        if is_empty {
            if soonest > stop || soonest == f64::INFINITY {
                return false;
            }
            self.reset_ring(soonest);
        } else {
            self.next_scan = self.next_bin + u64::from(self.ring);
        }
        if let Bins::Lines(lines) = &mut self.bins {
            lines.clear_overflow();
            overflow.sort_unstable();
            overflow.dedup();
        }
        for body in overflow {
            self.schedule(records, body, records[body as usize].time);
        }
        true
    }
}

/// Insertion sort: moves an entry to its place among those before it, in descending order.
#[inline(always)]
fn insert_sorted(records: &[BodyRecord], open: &mut [(f64, u32)], mut place: usize) {
    let (time, body) = open[place];
    while place > 0 {
        let (other_time, other) = open[place - 1];
        if other_time > time || (other_time == time && is_before(records, body, (time, other))) {
            break;
        }
        open[place] = (other_time, other);
        place -= 1;
    }
    open[place] = (time, body);
}

/// Order of two events at one time: that of the pair inserted earlier comes first. A dead entry,
/// whose record is that of another event, has no place among them.
#[cold]
#[inline(never)]
fn is_before(records: &[BodyRecord], a: u32, (time, b): (f64, u32)) -> bool {
    let rank = |body: u32| {
        let record = &records[body as usize];
        let other = if record.kind().is_contact() {
            record.partner()
        } else {
            body
        };
        (body.min(other), body.max(other), body)
    };
    records[b as usize].time == time && rank(a) < rank(b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::body_record::RecordKind;
    use rand::{RngExt, SeedableRng};

    /// Lays out a calendar of either form.
    fn laid_out(has_lines: bool, bodies: usize, interval: f64) -> Calendar {
        let mut calendar = Calendar::default();
        if has_lines {
            calendar.lay_out_lines(bodies, interval, 0.0);
        } else {
            calendar.lay_out_links(bodies, interval, 0.0);
        }
        calendar
    }

    #[test]
    fn events_come_in_order_for_any_width_and_form_of_a_bin() {
        for has_lines in [false, true] {
            check_order(has_lines);
        }
    }

    fn check_order(has_lines: bool) {
        for width in [
            0.0,
            5e-324,
            1e-310,
            1e-300,
            1e-6,
            1e-3,
            0.1,
            1e3,
            f64::INFINITY,
        ] {
            let mut random = rand_pcg::Pcg64::seed_from_u64(7);
            let mut records = vec![BodyRecord::dummy(); 50];
            let mut calendar = laid_out(has_lines, records.len(), width);
            for body in 0..records.len() as u32 {
                records[body as usize].set_event(random.random::<f64>(), RecordKind::Nothing, 0, 0);
                calendar.schedule(&records, body, records[body as usize].time);
            }
            let mut now = 0.0;
            for _ in 0..5000 {
                let earliest = records
                    .iter()
                    .map(|record| record.time)
                    .fold(f64::INFINITY, f64::min);
                let (time, body) = calendar.take_soonest(&records, f64::MAX, |_| ()).unwrap();
                assert_eq!(time, earliest, "width {width}");
                assert!(time >= now);
                now = time;
                let later = |random: &mut rand_pcg::Pcg64| now + random.random::<f64>().powi(3);
                // Removes a body's event if it is the next one, or its dead entry is; the body then
                // gets another event.
                let dropped = random.random_range(0..records.len() as u32);
                calendar.remove_if_next(dropped);
                records[dropped as usize].set_event(later(&mut random), RecordKind::Nothing, 0, 0);
                calendar.schedule(&records, dropped, records[dropped as usize].time);
                // The body itself, and another body from any place, at an earlier or later time
                // than before.
                for body in [body, random.random_range(0..records.len() as u32)] {
                    records[body as usize].set_event(later(&mut random), RecordKind::Nothing, 0, 0);
                    calendar.schedule(&records, body, records[body as usize].time);
                }
            }
            assert!(calendar.take_soonest(&records, now - 1.0, |_| ()).is_none());
        }
    }

    /// A dead entry between two events of one time does not change their order.
    #[test]
    fn simultaneous_events_come_in_order_of_their_bodies() {
        for has_lines in [false, true] {
            let mut records = vec![BodyRecord::dummy(); 4];
            let mut calendar = laid_out(has_lines, records.len(), 1.0);
            // Bin 0 is open after the first event.
            let mut schedule = |calendar: &mut Calendar, body: u32, time: f64| {
                records[body as usize].set_event(time, RecordKind::Nothing, 0, 0);
                calendar.schedule(&records, body, time);
                records.clone()
            };
            schedule(&mut calendar, 0, 0.0);
            let records = schedule(&mut calendar, 3, 0.2);
            assert_eq!(calendar.take_soonest(&records, 1.0, |_| ()), Some((0.0, 0)));
            schedule(&mut calendar, 1, 0.1);
            schedule(&mut calendar, 2, 0.1);
            // The entry of body 2 is dead now.
            schedule(&mut calendar, 2, 0.5);
            let records = schedule(&mut calendar, 0, 0.1);
            let taken = [0; 4].map(|_| calendar.take_soonest(&records, 1.0, |_| ()).unwrap().1);
            assert_eq!(taken, [0, 1, 3, 2]);
        }
    }

    #[test]
    fn a_calendar_without_finite_events_returns_none() {
        for has_lines in [false, true] {
            let mut calendar = laid_out(has_lines, 3, 1.0);
            let records = vec![BodyRecord::dummy(); 3];
            for body in 0..3 {
                calendar.schedule(&records, body, f64::INFINITY);
            }
            assert_eq!(calendar.take_soonest(&records, f64::MAX, |_| ()), None);
        }
    }
}
