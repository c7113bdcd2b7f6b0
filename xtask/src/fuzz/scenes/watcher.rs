//! Observer of a run that compares all reports with independent kinematics.

use std::{borrow::Cow, collections::BTreeMap};

use carom::engine::{BodyKey, BodyView, CollisionReport, Observer, View};
use carom_kinematics::{EpochTime, Motion};

use super::{
    contact::{self, ContactRules, MeasuredContact},
    kinematics::{
        BodyOutline, BodyPair, BodyState, Placed, distance_in_box, dot, length, smallest_gap,
    },
    laws::SceneRules,
};
use crate::fuzz::{
    random::FuzzDraw,
    subject::{Report, exceeds},
};

/// Number of times between two events at which all pairs are examined, in scenes of few bodies.
const MOMENTS: usize = 2;

/// Relative resolution of a time of two floats, with room for some rounding errors.
const RESOLUTION: f64 = f64::EPSILON * f64::EPSILON * 16.0;

/// The clock resolution is insufficient if a body moves this share of the side within it.
const USED_UP: f64 = 1e-14;

/// Outward rounding of a position at a contact, in roundings of the side.
const OUTWARDS: f64 = 4.0;

/// Number of times examined after a contact that may have been missed.
const LOOKS_AHEAD: i32 = 24;

/// Scenes of more bodies are not examined after every event.
const MAX_WATCHED_BODIES: usize = 12;

/// Largest gap at a contact in roundings of the longer side. The engine guarantees sixteen; four
/// times as much covers the rounding of the report, of the box, and of the subsequent computation.
const ROUNDINGS: f64 = 64.0;

/// Rounding error that each epoch may add to a position, in roundings of a side. An isolated body
/// flies eight sides in an epoch. The product v t and its sum with the position each contribute
/// half a rounding of eight sides: eight in total. At the k-th of eight crossings the position, of
/// up to k sides, is rounded by half of 1, 2, 2, 4, 4, 4, 4 and 8: 14.5 more.
const ROUNDINGS_PER_EPOCH: f64 = 22.5;

/// Largest distance of a body in an epoch, in sides, including bodies that are accelerated in it.
const SIDES_PER_EPOCH: f64 = 16.0;

/// Relative rounding of a velocity that a drag may add in each epoch, in roundings: of the reading
/// of the clock, of the share left, and of the product.
const ROUNDINGS_OF_DRAG: f64 = 16.0;

/// With a drag, the velocity in the epoch's clock is up to twice the true one, and the time of an
/// event is converted to that clock and back: so many times the rounding of an offset.
const ROUNDINGS_OF_CLOCK: f64 = 8.0;

/// Last reported state of a body.
#[derive(Debug, Clone)]
struct Tracked {
    outline: BodyOutline,
    state: BodyState,
    /// Epoch of the report.
    epoch: u64,
    fixed: bool,
    tags: Vec<String>,
    mass: f64,
}

/// A contact, for comparison with another scheduler.
#[derive(Debug, Clone)]
pub struct Logged {
    /// Time since the start (time).
    pub time: f64,
    /// Numbers of the bodies.
    pub bodies: [u64; 2],
    /// Atoms in contact.
    pub atoms: [Option<u32>; 2],
    /// Positions before (length).
    pub places: [BodyPair; 2],
    /// Velocities after (length per time).
    pub velocities: [BodyPair; 2],
    /// Approach speed (length per time).
    pub approach: f64,
    /// Sum of the speeds of the bodies and of their rims (length per time).
    pub speed: f64,
    /// Distance between the centres (length).
    pub distance: f64,
}

/// Observer of one run.
#[derive(Debug)]
pub struct Watcher {
    sides: BodyPair,
    bodies: BTreeMap<BodyKey, Tracked>,
    rules: SceneRules,
    /// Time of the last event, or of the start.
    last: EpochTime,
    start: EpochTime,
    draw: FuzzDraw,
    /// Number of epochs that have ended.
    pub epochs: u64,
    /// Energy lost in contacts since the last edit, summed here, and the ledger's value at that
    /// edit.
    lost: f64,
    lost_before: f64,
    largest_energy: f64,
    /// Largest energy and largest entry of the ledger since the start. Edits do not reset it, since
    /// the ledger keeps its rounding errors.
    largest_entry: f64,
    /// Number of energies summed and entered into the ledger since the start.
    entries: f64,
    /// Total momentum at the last edit, and that time.
    momentum: Option<(BodyPair, EpochTime)>,
    contacts: u64,
    /// True if the clock does not resolve the motion of very fast bodies; further checks are not
    /// possible.
    clock_is_used_up: bool,
    /// All contacts.
    pub log: Vec<Logged>,
    /// Findings.
    pub report: Report,
}

impl Watcher {
    /// Starts the observation.
    pub fn new(view: &View<'_>, rules: &SceneRules, seed: u64) -> Self {
        let mut watcher = Self {
            sides: view.bounds().sides().to_array(),
            bodies: BTreeMap::new(),
            rules: rules.clone(),
            last: view.time(),
            start: view.time(),
            draw: FuzzDraw::new(seed),
            epochs: 0,
            lost: 0.0,
            lost_before: 0.0,
            largest_energy: 0.0,
            largest_entry: 0.0,
            entries: 16.0,
            momentum: None,
            contacts: 0,
            clock_is_used_up: false,
            log: Vec::new(),
            report: Report::default(),
        };
        watcher.start_watching(view);
        watcher
    }

    /// Updates the state after each edit: the next may take out the energy that this has put in.
    pub fn edited(&mut self, view: &View<'_>, rules: &SceneRules) {
        self.rules = rules.clone();
        self.start_watching(view);
    }

    fn start_watching(&mut self, view: &View<'_>) {
        self.last = view.time();
        self.lost = 0.0;
        self.lost_before = view.ledger().lost;
        self.largest_energy = view.energy();
        self.keep_largest_entry(view);
        // An edit enters the difference of two sums over all bodies.
        self.entries += 1.0 + view.len() as f64;
        self.contacts = 0;
        let tags = |body: &carom::engine::Body| {
            body.tags()
                .iter()
                .map(|&tag| view.tag_names().name(tag).to_owned())
                .collect()
        };
        self.bodies = view
            .bodies()
            .map(|body| {
                let tracked = Tracked {
                    outline: BodyOutline::new(body.body.molecule()),
                    state: BodyState::new(&body.motion, view.time(), self.rules.drag),
                    epoch: self.epochs,
                    fixed: body.body.is_fixed(),
                    tags: tags(body.body),
                    mass: body.body.molecule().mass(),
                };
                (body.body.key(), tracked)
            })
            .collect();
        let free = self.bodies.values().all(|body| !body.fixed);
        let time = view.time();
        self.momentum = free.then(|| (self.total_momentum(time), time));
    }

    fn keep_largest_entry(&mut self, view: &View<'_>) {
        let ledger = view.ledger();
        let entries = [
            view.energy(),
            ledger.initial,
            ledger.lost,
            ledger.put_in,
            ledger.heat,
            ledger.dragged,
        ];
        self.largest_entry = entries
            .into_iter()
            .map(f64::abs)
            .fold(self.largest_entry, f64::max);
    }

    fn longer_side(&self) -> f64 {
        self.sides[0].max(self.sides[1])
    }

    /// Bound on the position error of a body at `time`, including its arms (length).
    fn error(&self, body: &Tracked, time: EpochTime) -> f64 {
        let epochs = (self.epochs - body.epoch) as f64;
        let dragged = if self.rules.drag == 0.0 {
            0.0
        } else {
            ROUNDINGS_OF_DRAG * (epochs + 1.0)
        };
        // A disc turns without effect on its place.
        let turning = if body.state.spin == 0.0 || body.outline.is_disc() {
            0.0
        } else {
            4.0 + (8.0 + dragged) * body.state.angle_until(time)
        };
        // Times are rounded as offsets in an epoch; a body moves at most this far in it.
        let longest = SIDES_PER_EPOCH * self.longer_side();
        let way =
            |time: EpochTime| (length(body.state.velocity) * time.offset().abs()).min(longest);
        let times = if self.rules.drag == 0.0 {
            1.0
        } else {
            ROUNDINGS_OF_CLOCK
        };
        let clock = times * (way(time) + way(body.state.time));
        // Epochs start at double-double times, which do not resolve the motion of very fast bodies
        // at late times.
        let rim = length(body.state.velocity) + body.state.spin.abs() * body.outline.reach;
        let unresolved = RESOLUTION * time.to_f64().abs() * rim;
        f64::EPSILON
            * (ROUNDINGS_PER_EPOCH * (epochs + 1.0) * self.longer_side()
                + turning * body.outline.reach
                + clock
                + dragged * body.state.path_until(time)
                + OUTWARDS * self.longer_side())
            + unresolved
    }

    fn gap_bound(&self, a: &BodyOutline, b: &BodyOutline) -> f64 {
        ROUNDINGS * f64::EPSILON * (self.longer_side() + a.thickness + b.thickness)
    }

    /// Bound on the error of an orientation, as a distance at the rim (length).
    fn turn_error(&self, body: &Tracked, time: EpochTime) -> f64 {
        let place = self.error(body, time);
        if !body.outline.is_disc() {
            return place;
        }
        let epochs = (self.epochs - body.epoch + 1) as f64;
        let offsets = time.offset().abs() + body.state.time.offset().abs();
        let turned = epochs * (8.0 + ROUNDINGS_OF_DRAG) * body.state.angle_until(time);
        let clock = ROUNDINGS_OF_CLOCK * body.state.spin.abs() * offsets;
        place + f64::EPSILON * (8.0 * epochs + turned + clock) * body.outline.reach
    }

    /// The total momentum at a time after all events so far.
    fn total_momentum(&self, time: EpochTime) -> BodyPair {
        let sum = |axis: usize| {
            self.bodies
                .values()
                .map(|body| body.mass * body.state.velocity[axis] * body.state.slowing(time))
                .sum::<f64>()
        };
        [sum(0), sum(1)]
    }

    /// Examines all pairs in all images at one time.
    fn look_at_all(&mut self, time: EpochTime) {
        let placed: Vec<(&Tracked, Placed, f64)> = self
            .bodies
            .values()
            .map(|body| {
                (
                    body,
                    body.state.at(time, self.sides),
                    self.error(body, time),
                )
            })
            .collect();
        let (mut worst, mut deepest) = (0.0f64, None);
        for (index, (a, at_a, error_a)) in placed.iter().enumerate() {
            for (b, at_b, error_b) in &placed[..index] {
                if a.fixed && b.fixed {
                    continue;
                }
                let factor = self.rules.factor(&a.tags, &b.tags);
                if factor == 0.0 {
                    continue;
                }
                let [one, other] = [a, b].map(|body| outline_for(body, factor));
                let gap = smallest_gap((&one, at_a), (&other, at_b), self.sides);
                let bound = self.gap_bound(&one, &other) + error_a + error_b;
                worst = worst.max(-gap / bound);
                if exceeds(-gap, bound) {
                    deepest = Some((gap, bound));
                }
            }
        }
        self.report.count("moments", 1);
        self.report.keep_worst("overlap/bound", worst);
        if let Some((gap, bound)) = deepest {
            let time = time.to_f64();
            self.report.fail(
                "overlap between events",
                format!("gap {gap:e} at {time:e}, allowed {bound:e}"),
            );
        }
    }

    /// Tests whether the engine missed a contact that its brute-force search finds `time` from now,
    /// before the next one at `next`: examines whether bodies overlap in between by more than
    /// rounding. The times of grazing contacts differ by more than the clock resolution.
    pub fn look_ahead(&mut self, now: EpochTime, time: f64, next: f64) {
        for halvings in 0..LOOKS_AHEAD {
            let after = (next - time) * 0.5f64.powi(halvings);
            self.look_at_all(now.after(time + after));
        }
    }

    /// Returns true if no further checks are needed.
    pub fn is_done(&self) -> bool {
        self.report.failure.is_some() || self.clock_is_used_up
    }

    /// Examines all pairs at random times since the last event.
    fn look_back(&mut self, time: EpochTime) {
        let since = time.since(self.last);
        // To the precision of a double-double, in which epochs are stored.
        let mut resolved = RESOLUTION * time.to_f64().abs();
        if self.rules.drag > 0.0 {
            resolved += ROUNDINGS_OF_CLOCK * f64::EPSILON * time.offset().abs();
        }
        if exceeds(-since, resolved) {
            self.report.fail(
                "time",
                format!("an event is {:e} earlier than the previous one", -since),
            );
            return;
        }
        let count = self.bodies.len();
        let looks = count <= MAX_WATCHED_BODIES
            || self
                .draw
                .happens(MAX_WATCHED_BODIES as f64 / count as f64 / 2.0);
        if since > 0.0 && looks {
            for _ in 0..MOMENTS {
                let moment = self.last.after(self.draw.between(0.0, 1.0) * since);
                self.look_at_all(moment);
            }
        }
        self.last = time;
    }

    /// Compares the state of the system with the independent kinematics at the end of a run.
    pub fn compare(&mut self, view: &View<'_>) {
        if self.is_done() {
            return;
        }
        let time = view.time();
        self.look_back(time);
        self.look_at_all(time);
        for body in view.bodies() {
            let Some(tracked) = self.bodies.get(&body.body.key()) else {
                self.report.fail("bodies", "the view has an unknown body");
                continue;
            };
            let tracked = tracked.clone();
            let drag = self.rules.drag;
            let found = BodyState::new(&body.motion, time, drag);
            let placed = tracked.state.at(time, self.sides);
            let error = self.error(&tracked, time);
            let off = distance_in_box(found.place, placed.place, self.sides);
            self.report.keep_worst("place/bound", off / error);
            if exceeds(off, error) {
                self.report.fail(
                    "place",
                    format!("{} deviates by {off:e}, allowed {error:e}", body.body.id()),
                );
            }
            self.compare_velocity(&tracked, &found, body.body.id());
            let rotation = body.motion.orientation.cos_sin().to_array();
            let turned =
                distance_in_box(rotation, placed.rotation, [8.0; 2]) * tracked.outline.reach;
            // The orientation of a disc without spin is arbitrary.
            let has_orientation = !tracked.outline.is_disc() || tracked.state.spin != 0.0;
            if has_orientation && exceeds(turned, self.turn_error(&tracked, time)) {
                self.report.fail(
                    "orientation",
                    format!("orientation of {} deviates by {turned:e}", body.body.id()),
                );
            }
        }
        self.compare_sums(view);
    }

    /// Compares velocity and spin with those after the last event: equal without drag, and to
    /// rounding with it.
    fn compare_velocity(&mut self, body: &Tracked, found: &BodyState, id: u64) {
        let state = &body.state;
        if self.rules.drag == 0.0 {
            if found.velocity != state.velocity || found.spin != state.spin {
                self.report.fail(
                    "velocity",
                    format!("velocity of {id} changed between contacts"),
                );
            }
            return;
        }
        let (share, decay) = (state.slowing(found.time), state.decay(found.time));
        let epochs = (self.epochs - body.epoch + 1) as f64;
        let relative = f64::EPSILON * (ROUNDINGS_OF_DRAG * epochs + decay);
        // A body stops that would move by less than the rounding of a position.
        let stop = f64::EPSILON * self.longer_side() * self.rules.drag;
        let off = |now: f64, then: f64| (now - share * then).abs();
        let [x, y] = [0, 1].map(|axis| off(found.velocity[axis], state.velocity[axis]));
        let allowed = relative * share * length(state.velocity) + stop;
        let turned = off(found.spin, state.spin);
        let allowed_spin = relative * share * state.spin.abs() + stop / body.outline.reach;
        self.report.keep_worst("dragged/bound", x.max(y) / allowed);
        if exceeds(x.max(y), allowed) || exceeds(turned, allowed_spin) {
            self.report.fail(
                "velocity",
                format!(
                    "velocity {:?} and spin {:e} of {id} are {:?} and {:e} at {share:e} of them",
                    state.velocity, state.spin, found.velocity, found.spin
                ),
            );
        }
    }

    /// The number of epochs, each of which adds roundings to all sums if there is a drag.
    fn epochs_with_drag(&self) -> f64 {
        if self.rules.drag == 0.0 {
            0.0
        } else {
            self.epochs as f64
        }
    }

    fn compare_sums(&mut self, view: &View<'_>) {
        let ledger = view.ledger();
        self.keep_largest_entry(view);
        let scale = self.largest_entry.max(self.largest_energy);
        let epochs = self.epochs_with_drag();
        let allowed = 16.0 * f64::EPSILON * (self.entries + epochs) * scale;
        let resolved = scale > 1e-280;
        let lost = ledger.lost - self.lost_before;
        if resolved && exceeds((lost - self.lost).abs(), allowed) {
            self.report.fail(
                "ledger",
                format!(
                    "the ledger has a loss of {lost:e}, the reports of {:e}",
                    self.lost
                ),
            );
        }
        if resolved && exceeds((view.energy() - ledger.booked()).abs(), allowed) {
            self.report.fail(
                "ledger",
                format!(
                    "the energy is {:e}, the ledger has {:e}",
                    view.energy(),
                    ledger.booked()
                ),
            );
        }
        // The motions of the view have been compared one by one.
        let own: f64 = view.bodies().map(|body| energy(&body)).sum();
        let rounding = 16.0 * f64::EPSILON * (16.0 + view.len() as f64) * own;
        if resolved && exceeds((view.energy() - own).abs(), rounding) {
            self.report.fail(
                "energy of the view",
                format!("it is {:e}, that of the bodies {own:e}", view.energy()),
            );
        }
        self.compare_momentum(view);
    }

    fn compare_momentum(&mut self, view: &View<'_>) {
        let epochs = self.epochs_with_drag();
        if let Some((before, start)) = self.momentum {
            let now = self.total_momentum(view.time());
            let left = libm::exp(-self.rules.drag * view.time().since(start));
            let before = before.map(|momentum| left * momentum);
            let scale: f64 = self
                .bodies
                .values()
                .map(|body| body.mass * length(body.state.velocity))
                .sum::<f64>()
                + length(before);
            let contacts = self.contacts as f64 + epochs + 16.0;
            let most = scale.max((2.0 * self.largest_energy * self.total_mass()).sqrt());
            let off = length([now[0] - before[0], now[1] - before[1]]);
            if exceeds(off, 16.0 * f64::EPSILON * contacts * most) {
                self.report.fail(
                    "total momentum",
                    format!("it deviates by {off:e} of {most:e}"),
                );
            }
        }
    }

    fn total_mass(&self) -> f64 {
        self.bodies.values().map(|body| body.mass).sum()
    }

    /// Compares the motion of a body before a contact with the independent kinematics.
    fn compare_before(
        &mut self,
        body: &Tracked,
        side: &carom::engine::Side<'_>,
        time: EpochTime,
    ) -> (Placed, f64) {
        let placed = body.state.at(time, self.sides);
        let error = self.error(body, time);
        let found = BodyState::new(&side.before, time, self.rules.drag);
        let off = distance_in_box(found.place, placed.place, self.sides);
        let id = side.body.id();
        if exceeds(off, error) {
            self.report.fail(
                "place",
                format!("{id} deviates by {off:e} at a contact, allowed {error:e}"),
            );
        }
        self.compare_velocity(body, &found, id);
        let finite = [
            side.after.velocity.x,
            side.after.velocity.y,
            side.after.angular_velocity,
        ];
        if finite.iter().any(|number| !number.is_finite()) {
            self.report
                .fail("NaN", format!("{id} has the velocities {finite:?}"));
        }
        (placed, error)
    }

    /// Takes over the states of both bodies after a contact, and the largest energies.
    fn track(&mut self, contact: &CollisionReport<'_>) {
        for side in &contact.sides {
            if let Some(tracked) = self.bodies.get_mut(&side.body.key()) {
                let (sides, epoch) = (self.sides, self.epochs);
                // Positions are wrapped into the box, as at the start of every epoch.
                let state = BodyState::new(&side.after, contact.time, self.rules.drag);
                let placed = state.at(contact.time, sides);
                tracked.state = BodyState {
                    place: placed.place,
                    ..state
                };
                tracked.epoch = epoch;
            }
        }
        let energy =
            |body: &Tracked| 0.5 * body.mass * dot(body.state.velocity, body.state.velocity);
        let now: f64 = [&contact.sides[0], &contact.sides[1]]
            .into_iter()
            .filter(|side| !side.body.is_fixed())
            .filter_map(|side| self.bodies.get(&side.body.key()))
            .map(energy)
            .sum();
        self.largest_energy = self.largest_energy.max(now);
        self.largest_entry = self.largest_entry.max(now);
    }

    /// Returns true if the clock does not resolve the motion of the faster body.
    fn uses_up_clock(&self, contact: &CollisionReport<'_>) -> bool {
        let fastest = contact.sides.iter().map(|side| {
            let reach = side.body.molecule().bounding_radius();
            let speed =
                |motion: &Motion| motion.velocity.length() + motion.angular_velocity.abs() * reach;
            speed(&side.before).max(speed(&side.after))
        });
        let way = RESOLUTION * contact.time.to_f64().abs() * fastest.fold(0.0, f64::max);
        way > USED_UP * self.longer_side()
    }

    /// Adds a contact to the log, for comparison with another scheduler.
    fn add_to_log(
        &mut self,
        contact: &CollisionReport<'_>,
        places: [BodyPair; 2],
        measured: &MeasuredContact,
    ) {
        self.log.push(Logged {
            time: contact.time.since(self.start),
            bodies: contact.sides.each_ref().map(|side| side.body.id()),
            atoms: contact.sides.each_ref().map(|side| side.atom),
            places,
            velocities: contact
                .sides
                .each_ref()
                .map(|side| side.after.velocity.to_array()),
            approach: measured.approach,
            speed: measured.speed,
            distance: measured.distance,
        });
    }
}

/// Kinetic energy of a body (mass × length² / time²).
fn energy(body: &BodyView<'_>) -> f64 {
    let (motion, inertia) = (&body.motion, body.body.inertia());
    let of = |inverse: f64, squared: f64| {
        if inverse > 0.0 {
            0.5 * squared / inverse
        } else {
            0.0
        }
    };
    let velocity = motion.velocity.to_array();
    let spin = motion.angular_velocity;
    of(inertia.inverse_mass, dot(velocity, velocity)) + of(inertia.inverse_moment, spin * spin)
}

/// The outline with which a body touches others that it sees at this factor of the distance.
fn outline_for(body: &Tracked, factor: f64) -> Cow<'_, BodyOutline> {
    if factor == 1.0 {
        Cow::Borrowed(&body.outline)
    } else {
        Cow::Owned(body.outline.scaled(factor))
    }
}

impl Observer for Watcher {
    fn collision(&mut self, contact: &CollisionReport<'_>) {
        if self.is_done() {
            return;
        }
        let time = contact.time;
        if self.uses_up_clock(contact) {
            self.clock_is_used_up = true;
            self.report.count("clocks used up", 1);
            return;
        }
        self.look_back(time);
        self.contacts += 1;
        self.entries += 1.0;
        let tracked = contact
            .sides
            .each_ref()
            .map(|side| self.bodies.get(&side.body.key()).cloned());
        let [Some(a), Some(b)] = tracked else {
            self.report.fail("bodies", "a report names an unknown body");
            return;
        };
        let [(at_a, error_a), (at_b, error_b)] = [
            self.compare_before(&a, &contact.sides[0], time),
            self.compare_before(&b, &contact.sides[1], time),
        ];
        let factor = self.rules.factor(&a.tags, &b.tags);
        if factor == 0.0 {
            self.report.fail(
                "transparent",
                format!("bodies that do not see each other touch: {contact:?}"),
            );
            return;
        }
        let outlines = [&a, &b].map(|body| outline_for(body, factor));
        let law = self.rules.law(&a.tags, &b.tags);
        let rules = ContactRules {
            sides: self.sides,
            gap: self.gap_bound(&outlines[0], &outlines[1]),
            law: &law,
            guarded: self.rules.elasticity.contact_time > 0.0,
        };
        let body = |n: usize, placed: Placed, error: f64| contact::ContactBody {
            outline: &outlines[n],
            placed,
            error,
        };
        let bodies = [body(0, at_a, error_a), body(1, at_b, error_b)];
        let measured = contact::check(contact, bodies, &rules, &mut self.report);
        self.lost += measured.lost;
        self.largest_entry = self.largest_entry.max((self.lost_before + self.lost).abs());
        self.track(contact);
        self.add_to_log(contact, [at_a.place, at_b.place], &measured);
    }
}
