//! The loop of the small discs: prediction in lanes, crossings, contacts.

use carom_detection::{DISC_LANES, Detection};

use super::{
    State,
    line::{INDEX_MASK, Kind},
    neighbourhood::image_of,
    vector::{Kernel, Question, Soonest},
};
use crate::{ContactEvent, Parts, World};

impl State {
    /// Finds a small disc's soonest event: a contact with a neighbour, or the next cell.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled anew for each set of instructions")]
    pub(super) fn foresee_disc<D: Detection, K: Kernel>(
        &mut self,
        world: &World,
        detection: &D,
        disc: u32,
        now: f64,
    ) {
        // Field by field: the line was written in pieces a moment ago and cannot be read as a whole yet.
        let line = &self.lines[disc as usize];
        let me = Asking { flight: line.flight, radius: line.radius, cell: line.cell };
        let cell = self.neighbourhoods.index(me.cell);
        let (crossing_time, crossing) = self.crossing(&me, now);
        let images = self.neighbourhoods.at_border(me.cell).then(|| self.grid.box_sides().to_array());
        let (slots, count) = self.neighbourhoods.slots(cell);
        let mut best = Best::default();
        let (halves, _) = slots.as_chunks::<DISC_LANES>();
        self.ask_eight::<D, K>(detection, &me, &halves[0], images, now, &mut best);
        if count > DISC_LANES {
            self.ask_eight::<D, K>(detection, &me, &halves[1], images, now, &mut best);
        }
        if !self.neighbourhoods.is_plain(cell) {
            self.ask_overflow::<D, K>(detection, &me, cell, images, now, &mut best);
        }
        let contact_time = now + best.time;
        let meets = contact_time <= crossing_time;
        let time = if meets { contact_time } else { crossing_time };
        let kind = if meets { Kind::Discs } else { crossing };
        let partner = if meets { best.partner } else { 0 };
        let version = self.lines[partner as usize].version;
        self.lines[disc as usize].set_event(time, kind, partner, version);
        if self.neighbourhoods.is_covered(cell) {
            self.meet_coverings(world, detection, disc, cell, now);
        }
    }

    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled anew for each set of instructions")]
    fn ask_eight<D: Detection, K: Kernel>(
        &self,
        detection: &D,
        me: &Asking,
        slots: &[u32; DISC_LANES],
        images: Option<[f64; 2]>,
        now: f64,
        best: &mut Best,
    ) {
        let line = |lane: usize| &self.lines[(slots[lane] & INDEX_MASK) as usize];
        let question = Question {
            others: [line(0), line(1), line(2), line(3), line(4), line(5), line(6), line(7)],
            from: &me.flight,
            radius: me.radius,
            now,
            separation_error: self.separation_error,
        };
        if images.is_none() && detection.decides_discs_in_closed_form() {
            let soonest = K::soonest(&question);
            if !soonest.in_contact {
                return best.take(&soonest, slots);
            }
        }
        best.take(&look_closer(detection, &question, slots, images), slots);
    }

    /// Discs that found no slot in the list.
    #[cold]
    fn ask_overflow<D: Detection, K: Kernel>(
        &self,
        detection: &D,
        me: &Asking,
        cell: u32,
        images: Option<[f64; 2]>,
        now: f64,
        best: &mut Best,
    ) {
        let dummy = self.lines.len() as u32 - 1;
        for some in self.neighbourhoods.overflow(cell).chunks(DISC_LANES) {
            let mut slots = [dummy; DISC_LANES];
            slots[..some.len()].copy_from_slice(some);
            self.ask_eight::<D, K>(detection, me, &slots, images, now, best);
        }
    }

    /// When a disc leaves its cell, and where to. A velocity of exactly 0 never does; 0/0 must not be formed.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled anew for each set of instructions")]
    fn crossing(&self, me: &Asking, now: f64) -> (f64, Kind) {
        let side = self.grid.side();
        let along = |axis: usize| {
            let (velocity, origin) = (me.flight[axis + 2], me.flight[axis]);
            let border = f64::from(u32::from(me.cell[axis]) + u32::from(velocity > 0.0)) * side[axis];
            let time = (border - origin) / velocity;
            if velocity == 0.0 { f64::INFINITY } else { time }
        };
        let (x, y) = (along(0), along(1));
        let kind_x = if me.flight[2] > 0.0 { Kind::Right } else { Kind::Left };
        let kind_y = if me.flight[3] > 0.0 { Kind::Up } else { Kind::Down };
        let (time, kind) = if x <= y { (x, kind_x) } else { (y, kind_y) };
        (if time > now { time } else { now }, kind)
    }

    /// Moves a disc into the next cell, wrapping its place at the border of the box.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled anew for each set of instructions")]
    pub(super) fn cross(&mut self, disc: u32, kind: Kind) {
        self.done.crossings += 1;
        let (axis, direction) = match kind {
            Kind::Right => (0, 1),
            Kind::Left => (0, -1),
            Kind::Up => (1, 1),
            _ => (1, -1),
        };
        let line = &mut self.lines[disc as usize];
        let from = line.cell;
        let count = self.grid.counts()[axis] as i32;
        let next = i32::from(from[axis]) + direction;
        if (0..count).contains(&next) {
            line.cell[axis] = next as u16;
            self.neighbourhoods.step(disc, from, line.cell, axis, direction);
        } else {
            self.wrap(disc, axis, direction);
        }
    }

    #[cold]
    fn wrap(&mut self, disc: u32, axis: usize, direction: i32) {
        let count = self.grid.counts()[axis];
        let line = &mut self.lines[disc as usize];
        self.neighbourhoods.leave(disc, line.cell);
        line.cell[axis] = if direction > 0 { 0 } else { (count - 1) as u16 };
        line.flight[axis] -= f64::from(direction) * self.grid.box_sides()[axis];
        self.windings[disc as usize][axis] += i64::from(direction);
        self.neighbourhoods.enter(disc, line.cell);
    }

    /// The contact of two discs; the image follows from their cells, which are adjacent.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled anew for each set of instructions")]
    pub(super) fn contact_of_discs(&self, bodies: [u32; 2], time: f64) -> ContactEvent {
        let (a, b) = (self.lines[bodies[0] as usize].cell, self.lines[bodies[1] as usize].cell);
        let mut image = [0; 2];
        for axis in 0..2 {
            let steps = i32::from(b[axis]) - i32::from(a[axis]);
            image[axis] = i64::from(steps < -1) - i64::from(steps > 1);
        }
        ContactEvent { time, bodies, image, parts: Parts::Discs }
    }
}

/// What of a disc's line a prediction needs.
struct Asking {
    flight: [f64; 4],
    radius: f64,
    cell: [u16; 2],
}

/// The answer where some discs are seen through the border of the box, some pair may be in contact already, or the
/// detector has a way of its own with discs.
#[cold]
#[inline(never)]
fn look_closer<D: Detection>(
    detection: &D,
    question: &Question<'_>,
    slots: &[u32; DISC_LANES],
    images: Option<[f64; 2]>,
) -> Soonest {
    let mut lanes = question.lanes();
    if let Some(sides) = images {
        for (lane, &slot) in slots.iter().enumerate() {
            let image = image_of(slot);
            for axis in 0..2 {
                lanes.separation[axis][lane] += f64::from(image[axis]) * sides[axis];
            }
        }
    }
    Soonest::of(&detection.disc_contacts(&lanes))
}

/// The soonest contact so far of the disc that asks.
struct Best {
    /// From now on.
    time: f64,
    partner: u32,
}

impl Default for Best {
    fn default() -> Self {
        Self { time: f64::INFINITY, partner: 0 }
    }
}

impl Best {
    /// Takes the soonest of eight; of contacts at one time that with the disc inserted first.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled anew for each set of instructions")]
    fn take(&mut self, soonest: &Soonest, slots: &[u32; DISC_LANES]) {
        if soonest.time > self.time || soonest.time == f64::INFINITY {
            return;
        }
        let mut partner = slots[(soonest.lanes.trailing_zeros() & 7) as usize] & INDEX_MASK;
        if soonest.lanes & (soonest.lanes - 1) != 0 {
            partner = first_of(soonest.lanes, slots);
        }
        if soonest.time < self.time || partner < self.partner {
            (self.time, self.partner) = (soonest.time, partner);
        }
    }
}

/// The disc inserted first among several lanes.
#[cold]
fn first_of(lanes: u32, slots: &[u32; DISC_LANES]) -> u32 {
    let chosen = slots.iter().enumerate().filter(|(lane, _)| lanes >> lane & 1 == 1);
    chosen.map(|(_, slot)| slot & INDEX_MASK).min().unwrap_or(0)
}
