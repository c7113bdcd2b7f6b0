//! The loop of the small discs: prediction in lanes, crossings, contacts.

use carom_detection::{DISC_LANES, Detection, DiscLanes};

use super::{
    State,
    line::{INDEX_MASK, Kind, Line},
    neighbourhood::{SLOTS, image_of},
};
use crate::{ContactEvent, Parts, World};

impl State {
    /// Finds a small disc's soonest event: a contact with a neighbour, or the next cell.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled anew for each set of instructions")]
    pub(super) fn foresee_disc<D: Detection>(&mut self, world: &World, detection: &D, disc: u32, now: f64) {
        let me = self.lines[disc as usize];
        let cell = self.neighbourhoods.index(me.cell);
        let (crossing_time, crossing) = self.crossing(&me, now);
        let images = self.neighbourhoods.at_border(me.cell).then(|| self.grid.box_sides().to_array());
        let (slots, count) = self.neighbourhoods.slots(cell);
        let mut best = Soonest::default();
        let (first, second) = slots.split_at(DISC_LANES);
        self.ask_eight(&me, first, images, now, &mut best);
        if count > DISC_LANES {
            self.ask_eight(&me, second, images, now, &mut best);
        }
        if !self.neighbourhoods.is_plain(cell) {
            self.ask_overflow(&me, cell, images, now, &mut best);
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
    fn ask_eight(&self, me: &Line, slots: &[u32], images: Option<[f64; 2]>, now: f64, best: &mut Soonest) {
        let mut lanes = DiscLanes {
            separation: [[0.0; DISC_LANES]; 2],
            velocity: [[0.0; DISC_LANES]; 2],
            contact_distance: [0.0; DISC_LANES],
            separation_error: self.separation_error,
            speed: me.velocity[0].abs() + me.velocity[1].abs(),
        };
        for (lane, &slot) in slots[..DISC_LANES].iter().enumerate() {
            let other = &self.lines[(slot & INDEX_MASK) as usize];
            for axis in 0..2 {
                lanes.velocity[axis][lane] = other.velocity[axis] - me.velocity[axis];
                lanes.separation[axis][lane] = other.origin[axis] - me.origin[axis];
            }
            lanes.contact_distance[lane] = other.radius + me.radius;
        }
        for axis in 0..2 {
            for lane in 0..DISC_LANES {
                lanes.separation[axis][lane] += lanes.velocity[axis][lane] * now;
            }
        }
        if let Some(sides) = images {
            for (lane, &slot) in slots[..DISC_LANES].iter().enumerate() {
                let image = image_of(slot);
                for axis in 0..2 {
                    lanes.separation[axis][lane] += f64::from(image[axis]) * sides[axis];
                }
            }
        }
        best.take(&lanes.contact_times(), slots);
    }

    /// Discs that found no slot in the list.
    #[cold]
    fn ask_overflow(&self, me: &Line, cell: u32, images: Option<[f64; 2]>, now: f64, best: &mut Soonest) {
        let dummy = self.lines.len() as u32 - 1;
        for some in self.neighbourhoods.overflow(cell).chunks(DISC_LANES) {
            let mut slots = [dummy; SLOTS];
            slots[..some.len()].copy_from_slice(some);
            self.ask_eight(me, &slots[..DISC_LANES], images, now, best);
        }
    }

    /// When a disc leaves its cell, and where to. A velocity of exactly 0 never does; 0/0 must not be formed.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled anew for each set of instructions")]
    fn crossing(&self, me: &Line, now: f64) -> (f64, Kind) {
        let side = self.grid.side();
        let along = |axis: usize| {
            let (velocity, origin) = (me.velocity[axis], me.origin[axis]);
            let border = f64::from(u32::from(me.cell[axis]) + u32::from(velocity > 0.0)) * side[axis];
            let time = (border - origin) / velocity;
            if velocity == 0.0 { f64::INFINITY } else { time }
        };
        let (x, y) = (along(0), along(1));
        let kind_x = if me.velocity[0] > 0.0 { Kind::Right } else { Kind::Left };
        let kind_y = if me.velocity[1] > 0.0 { Kind::Up } else { Kind::Down };
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
        line.origin[axis] -= f64::from(direction) * self.grid.box_sides()[axis];
        self.windings[disc as usize][axis] += i64::from(direction);
        self.neighbourhoods.enter(disc, line.cell);
    }

    /// The contact of two discs; the image follows from their cells, which are adjacent.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled anew for each set of instructions")]
    pub(super) fn contact_of_discs(&self, bodies: [u32; 2], time: f64) -> ContactEvent {
        let [a, b] = bodies.map(|body| self.lines[body as usize].cell);
        let image = [0, 1].map(|axis| {
            let steps = i32::from(b[axis]) - i32::from(a[axis]);
            i64::from(steps < -1) - i64::from(steps > 1)
        });
        ContactEvent { time, bodies, image, parts: Parts::Discs }
    }
}

/// The soonest contact so far of the disc that asks.
struct Soonest {
    /// From now on.
    time: f64,
    partner: u32,
}

impl Default for Soonest {
    fn default() -> Self {
        Self { time: f64::INFINITY, partner: 0 }
    }
}

impl Soonest {
    /// Takes the soonest of eight; of contacts at one time that with the disc inserted first.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled anew for each set of instructions")]
    fn take(&mut self, times: &[f64; DISC_LANES], slots: &[u32]) {
        let least = |a: f64, b: f64| if b < a { b } else { a };
        let pairs = [0, 1, 2, 3].map(|i| least(times[i], times[i + 4]));
        let soonest = least(least(pairs[0], pairs[2]), least(pairs[1], pairs[3]));
        if soonest > self.time || soonest == f64::INFINITY {
            return;
        }
        let mut equal = 0u32;
        for (lane, &time) in times.iter().enumerate() {
            equal |= u32::from(time == soonest) << lane;
        }
        let mut partner = slots[(equal.trailing_zeros() & 7) as usize] & INDEX_MASK;
        if equal & (equal - 1) != 0 {
            partner = first_of(equal, slots);
        }
        if soonest < self.time || partner < self.partner {
            (self.time, self.partner) = (soonest, partner);
        }
    }
}

/// The disc inserted first among several lanes.
#[cold]
fn first_of(lanes: u32, slots: &[u32]) -> u32 {
    let chosen = slots.iter().enumerate().filter(|(lane, _)| lanes >> lane & 1 == 1);
    chosen.map(|(_, slot)| slot & INDEX_MASK).min().unwrap_or(0)
}
