//! The loop of the small discs: prediction in lanes, crossings, contacts.

use std::hint::select_unpredictable as select;

use carom_detection::Detection;
use wide::f64x2;

use super::{
    State,
    body_record::{BodyRecord, INDEX_MASK, Kind},
    simd::{Kernel, NeighbourQuery, SoonestSlot, sooner},
};
use crate::{
    World,
    scheduler::{ContactEvent, Parts},
};

impl State {
    /// Asks when a small disc meets its neighbours, and when it leaves its cell.
    #[inline(always)]
    pub(super) fn ask<K: Kernel>(&self, kernel: K, disc: u32, now: f64) -> Asked {
        let from = &self.records[disc as usize];
        let cell = self.neighbour_lists.index(from.cell());
        // Each branch makes its own query: one that both share would be written to memory first. No branch on what
        // they answer: that hangs on the end of the chain.
        let (soonest, covered) = match (self.neighbour_lists.only_eight(cell), self.like) {
            // Said once more, so that it is known where it is compiled.
            (Some((slots, false, is_covered)), like @ Some(_)) => {
                let query = NeighbourQuery { like, ..self.query(disc, now) };
                (kernel.eight::<false>(query, slots).among(slots), is_covered.then_some(cell))
            }
            (Some((slots, true, is_covered)), like @ Some(_)) => {
                let query = NeighbourQuery { like, ..self.query(disc, now) };
                (kernel.eight::<true>(query, slots).among(slots), is_covered.then_some(cell))
            }
            _ => self.ask_any(kernel, disc, now, cell),
        };
        let (crossing_time, crossing) = self.crossing(from, now);
        Asked {
            contact_time: now + soonest.time,
            partner: soonest.slot & INDEX_MASK,
            is_doubtful: soonest.is_doubtful,
            covered,
            crossing_time,
            crossing,
        }
    }

    /// Asks those around a cell, whatever its list is like; and the cell, if it is covered.
    #[inline(always)]
    fn ask_any<K: Kernel>(&self, kernel: K, disc: u32, now: f64, cell: u32) -> (SoonestSlot, Option<u32>) {
        let list = self.neighbour_lists.list_of(cell);
        let soonest = match list.plain() {
            Some((first, second)) => {
                let soonest = kernel.eight::<false>(self.query(disc, now), first).among(first);
                match second {
                    None => soonest,
                    Some(second) => {
                        soonest.or(kernel.eight::<false>(self.query(disc, now), second).among(second))
                    }
                }
            }
            None => kernel.any(&self.query(disc, now), &list),
        };
        (soonest, list.is_covered().then_some(cell))
    }

    #[inline(always)]
    pub(super) fn query(&self, disc: u32, now: f64) -> NeighbourQuery<'_> {
        let from = &self.records[disc as usize];
        NeighbourQuery {
            records: &self.records,
            from,
            now,
            separation_error: self.separation_error,
            sides: self.sides,
            like: self.like,
        }
    }

    /// Settles a small disc's soonest event: a contact with a neighbour, or the next cell. Writes it into the disc's record
    /// and tells when it is.
    ///
    /// No branch hangs on the end of the long chain of operations that gives the time, except the rare ones: what comes
    /// next can begin before this has ended.
    #[inline(always)]
    pub(super) fn settle_disc<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        disc: u32,
        now: f64,
        asked: &Asked,
    ) -> f64 {
        let Asked { mut contact_time, mut partner, is_doubtful, covered, crossing_time, crossing } = *asked;
        if is_doubtful | !detection.decides_discs_in_closed_form() {
            let soonest;
            (soonest, partner) = self.look_closer(detection, disc, now);
            contact_time = now + soonest;
        }
        let meets = contact_time <= crossing_time;
        let time = if crossing_time < contact_time { crossing_time } else { contact_time };
        let kind = select(meets, Kind::Discs, crossing);
        let partner = select(meets, partner, 0);
        let version = self.records[partner as usize].version;
        self.records[disc as usize].set_event(time, kind, partner, version);
        if let Some(cell) = covered {
            if self.multi_cell.are_large_discs() && detection.decides_discs_in_closed_form() {
                return self.meet_large_discs(disc, cell, now);
            }
            self.meet_coverings(world, detection, disc, cell, now, None);
            return self.records[disc as usize].time;
        }
        time
    }

    /// The soonest contact, and with whom, where some pair may be in contact already, several discs are touched at once,
    /// or the detector has a way of its own with discs. Of contacts at one time it is that with the disc inserted first.
    #[cold]
    #[inline(never)]
    fn look_closer<D: Detection>(&self, detection: &D, disc: u32, now: f64) -> (f64, u32) {
        let query = self.query(disc, now);
        let list = self.neighbour_lists.list(query.from.cell());
        let mut soonest = (f64::INFINITY, 0);
        list.for_each_slots8(|slots| {
            soonest = sooner(soonest, query.look_closer(detection, slots, list.at_border));
        });
        soonest
    }

    /// When a disc leaves its cell, and where to. A velocity of exactly 0 never does; what 0/0 is must not count.
    #[inline(always)]
    pub(super) fn crossing(&self, me: &BodyRecord, now: f64) -> (f64, Kind) {
        // Both axes at once.
        let pair = |first: usize| f64x2::new([me.flight[first], me.flight[first + 1]]);
        let (origin, velocity) = (pair(0), pair(2));
        let side = f64x2::new(self.grid.side().to_array());
        let cell = f64x2::new(me.cell().map(f64::from));
        let goes_down = velocity.simd_lt(f64x2::ZERO);
        let border = (cell + goes_down.bitselect(f64x2::ZERO, f64x2::ONE)) * side;
        let time = (border - origin) / velocity;
        let [x, y] = velocity.simd_eq(f64x2::ZERO).bitselect(f64x2::splat(f64::INFINITY), time).to_array();
        let axis = u32::from(y < x);
        let kind = Kind::crossing(axis, goes_down.to_bitmask() >> axis & 1);
        let time = if y < x { y } else { x };
        (if time > now { time } else { now }, kind)
    }

    /// Moves a disc into the next cell, wrapping its place at the border of the box.
    #[inline(always)]
    pub(super) fn cross<K: Kernel>(&mut self, kernel: K, disc: u32, kind: Kind) {
        self.done.crossings += 1;
        let (axis, direction) = kind.direction();
        let record = &mut self.records[disc as usize];
        let from = record.cell();
        if let Some(next) = self.grid.next(record.cell_along(axis), axis, direction) {
            record.set_cell_along(axis, next);
            let to = record.cell();
            self.neighbour_lists.step(kernel, disc, from, to, axis, direction);
        } else {
            self.wrap(disc, axis, direction);
        }
    }

    #[cold]
    fn wrap(&mut self, disc: u32, axis: usize, direction: i32) {
        self.neighbour_lists.leave(disc, self.records[disc as usize].cell());
        self.wrap_place(disc, axis, direction);
        self.neighbour_lists.enter(disc, self.records[disc as usize].cell());
    }

    /// Brings a disc that crosses the border of the box back into it on the other side.
    pub(super) fn wrap_place(&mut self, disc: u32, axis: usize, direction: i32) {
        let record = &mut self.records[disc as usize];
        record.flight[axis] -= f64::from(direction) * self.grid.box_sides()[axis];
        record.set_cell_along(axis, if direction > 0 { 0 } else { (self.grid.counts()[axis] - 1) as u16 });
        let winding = &mut self.windings[disc as usize][axis];
        *winding = winding.wrapping_add(direction as i16);
        self.wrapped.push(disc);
        self.wrap_motion(disc, axis, direction);
    }

    /// The contact of two discs; the image follows from their cells, which are adjacent.
    #[inline(always)]
    pub(super) fn contact_of_discs(&self, bodies: [u32; 2], time: f64) -> ContactEvent {
        let (a, b) = (self.records[bodies[0] as usize].cell(), self.records[bodies[1] as usize].cell());
        let steps = [i32::from(b[0]) - i32::from(a[0]), i32::from(b[1]) - i32::from(a[1])];
        let is_next = |steps: i32| ((steps + 1) as u32) < 3;
        let mut image = [0; 2];
        if !(is_next(steps[0]) & is_next(steps[1])) {
            image = steps.map(|steps| i64::from(steps < -1) - i64::from(steps > 1));
        }
        ContactEvent { time, bodies, image, parts: Parts::Discs }
    }
}

/// What a disc was told about its neighbours and its cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct Asked {
    /// When it meets the first of them, infinite for never, and which.
    contact_time: f64,
    partner: u32,
    /// Whether that needs a closer look.
    is_doubtful: bool,
    /// Its cell, if a covering body is listed there.
    covered: Option<u32>,
    crossing_time: f64,
    crossing: Kind,
}
