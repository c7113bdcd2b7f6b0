//! Calendar queue: one event for each body, in a ring of bins of equal time, with only the earliest
//! bin sorted.
//!
//! A bounded calendar queue after G. Paul, J. Comput. Phys. 221, 615 (2007). Bins are numbered
//! along time, and the ring holds a fixed number of them from the next one on. A bin is a circular
//! doubly linked list of bodies, so insertion and removal have no branches. Later events go to an
//! overflow list, scanned once per turn of the ring.

use super::{body_record::BodyRecord, simd};

/// Previous and next body in a circular list.
type Link = [u32; 2];
const PREVIOUS: usize = 0;
const NEXT: usize = 1;

/// Width of a bin in mean intervals between events of the system. Smaller: more empty bins, and a
/// longer overflow list. Larger: more to sort. From 1.5 to 6 the run time is the same, and fewer
/// bins need less memory.
const EVENTS_PER_BIN: f64 = 6.0;

/// Bodies for each bin of the ring. With this length of the ring, one body in twenty is in the
/// overflow list.
const BODIES_PER_BIN: u32 = 2;

/// 2^52: a sum with it has the nearest integer in its last bits. The rounding is monotonic, and
/// nothing else is needed.
const SHIFT: f64 = 4_503_599_627_370_496.0;

/// The events of all bodies in order of time; the times are in the bodies' records.
#[derive(Debug, Clone, Default)]
pub(super) struct Calendar {
    /// A link for each body, then a head for each bin of the ring, then the head of the overflow
    /// list.
    links: Vec<Link>,
    bodies: u32,
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

impl Calendar {
    /// Lays out a ring of empty bins from `start` on, for events at this mean interval (times).
    pub fn lay_out(&mut self, bodies: usize, interval: f64, start: f64) {
        self.bodies = bodies as u32;
        self.ring = (self.bodies / BODIES_PER_BIN).max(1);
        self.links.clear();
        self.links
            .extend((0..=self.bodies + self.ring).map(|head| [head; 2]));
        let bins_per_time = 1.0 / (EVENTS_PER_BIN * interval);
        // Of 0 and of subnormal intervals the reciprocal is infinite: all events are in one bin.
        self.bins_per_time = if bins_per_time.is_finite() {
            bins_per_time
        } else {
            0.0
        };
        self.reset_ring(start);
    }

    pub fn heap_bytes(&self) -> usize {
        self.links.capacity() * size_of::<Link>() + self.open.capacity() * size_of::<(f64, u32)>()
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
        self.unlink(body);
        let bin = self.bin_of(time);
        if bin >= self.next_bin {
            let ahead = bin - self.next_bin;
            let place = (ahead as u32).wrapping_add(self.next_place);
            let place = if place < self.ring {
                place
            } else {
                place.wrapping_sub(self.ring)
            };
            let place = if ahead < u64::from(self.ring) {
                place
            } else {
                self.ring
            };
            self.link(body, self.bodies + place);
        } else {
            self.links[body as usize] = [body; 2];
            self.open.push((time, body));
            let last = self.open.len() - 1;
            insert_sorted(records, &mut self.open, last);
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

    /// The bodies in a bin, by its distance from the next one.
    pub fn bodies_in_bin(&self, bins: u32) -> impl Iterator<Item = u32> {
        let place = self.next_place + bins % self.ring;
        let head = self.bodies
            + if place < self.ring {
                place
            } else {
                place - self.ring
            };
        let after =
            move |body: u32| Some(self.links[body as usize][NEXT]).filter(|&next| next != head);
        std::iter::successors(after(head), move |&body| after(body))
    }

    /// Prefetches the link that is read and written when a body is moved.
    pub fn prefetch(&self, body: u32) {
        simd::prefetch(&self.links, body as usize);
    }

    #[inline(always)]
    fn unlink(&mut self, body: u32) {
        let [previous, next] = self.links[body as usize];
        self.links[previous as usize][NEXT] = next;
        self.links[next as usize][PREVIOUS] = previous;
    }

    #[inline(always)]
    fn link(&mut self, body: u32, head: u32) {
        let first = self.links[head as usize][NEXT];
        self.links[body as usize] = [head, first];
        self.links[head as usize][NEXT] = body;
        self.links[first as usize][PREVIOUS] = body;
    }

    /// Opens the next bin; no event is open before.
    #[inline(always)]
    fn open_bin(&mut self, records: &[BodyRecord]) {
        let head = self.bodies + self.next_place;
        self.next_bin += 1;
        self.next_place += 1;
        if self.next_place == self.ring {
            self.next_place = 0;
        }
        let mut body = self.links[head as usize][NEXT];
        self.links[head as usize] = [head; 2];
        while body != head {
            let next = self.links[body as usize][NEXT];
            self.links[body as usize] = [body; 2];
            self.open.push((records[body as usize].time, body));
            body = next;
        }
        let open = self.open.as_mut_slice();
        for place in 1..open.len() {
            insert_sorted(records, open, place);
        }
    }

    /// Scans the overflow list and inserts its events. If the ring is empty, it starts anew at the
    /// earliest of them. Returns false if this is after `stop` or there is none.
    #[cold]
    #[inline(never)]
    fn scan_overflow_list(&mut self, records: &[BodyRecord], stop: f64) -> bool {
        let head = self.bodies + self.ring;
        let mut overflow = Vec::new();
        let mut body = self.links[head as usize][NEXT];
        let mut soonest = f64::INFINITY;
        while body != head {
            soonest = soonest.min(records[body as usize].time);
            overflow.push(body);
            body = self.links[body as usize][NEXT];
        }
        let is_empty = (self.bodies..head).all(|bin| self.links[bin as usize][NEXT] == bin);
        if is_empty {
            if soonest > stop || soonest == f64::INFINITY {
                return false;
            }
            self.reset_ring(soonest);
        } else {
            self.next_scan = self.next_bin + u64::from(self.ring);
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
        if other_time > time || (other_time == time && is_before(records, body, other)) {
            break;
        }
        open[place] = (other_time, other);
        place -= 1;
    }
    open[place] = (time, body);
}

/// Order of two events at one time: that of the pair inserted earlier comes first.
#[cold]
#[inline(never)]
fn is_before(records: &[BodyRecord], a: u32, b: u32) -> bool {
    let rank = |body: u32| {
        let record = &records[body as usize];
        let other = if record.kind().is_contact() {
            record.partner()
        } else {
            body
        };
        (body.min(other), body.max(other), body)
    };
    rank(a) < rank(b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::body_record::RecordKind;
    use rand::{RngExt, SeedableRng};

    #[test]
    fn events_come_in_order_for_any_width_of_a_bin() {
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
            let mut calendar = Calendar::default();
            calendar.lay_out(records.len(), width, 0.0);
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

    #[test]
    fn a_calendar_without_finite_events_returns_none() {
        let mut calendar = Calendar::default();
        calendar.lay_out(3, 1.0, 0.0);
        let records = vec![BodyRecord::dummy(); 3];
        (0..3).for_each(|body| calendar.schedule(&records, body, f64::INFINITY));
        assert_eq!(calendar.take_soonest(&records, f64::MAX, |_| ()), None);
    }
}
