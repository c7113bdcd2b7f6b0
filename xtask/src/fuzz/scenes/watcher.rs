//! Watches a run through its reports alone, and compares all that it sees with kinematics of its
//! own.

use std::collections::BTreeMap;

use carom::engine::{BodyKey, CollisionReport, ElasticitySpec, Observer, View};
use carom_kinematics::{EpochTime, Motion};

use super::{
    contact::{self, Rules},
    kinematics::{Outline, Pair, Placed, State, distance_in_box, dot, length, smallest_gap},
};
use crate::fuzz::{
    random::Draw,
    subject::{Report, exceeds},
};

/// Moments between two events at which all pairs are looked at, in scenes of few bodies.
const MOMENTS: usize = 2;

/// What of a time its two floats resolve, with room for a few roundings.
const RESOLUTION: f64 = f64::EPSILON * f64::EPSILON * 16.0;

/// A clock is used up when a body goes this share of the side in the time that it resolves.
const USED_UP: f64 = 1e-14;

/// Roundings of the side by which a contact may round a place outwards.
const OUTWARDS: f64 = 4.0;

/// Moments after a contact that may have been passed over.
const LOOKS_AHEAD: i32 = 24;

/// In scenes of more bodies than this, not after every event.
const FEW: usize = 12;

/// Roundings of the longer side within which bodies touch at a contact: the promise of the engine
/// is sixteen, and four times as much covers the rounding of the report, of the box, and of what
/// follows it.
const ROUNDINGS: f64 = 64.0;

/// Roundings of a side that each epoch may add to a place. A body that moves alone flies eight
/// sides in an epoch. Half a rounding of eight sides each for the product v t and for its sum with
/// the place make eight. At the k-th of its eight crossings the place, of up to k sides, is rounded
/// by half of 1, 2, 2, 4, 4, 4, 4 and 8, which makes 14.5 more.
const ROUNDINGS_PER_EPOCH: f64 = 22.5;

/// How many sides a body may go in an epoch, one that has become faster in it included.
const SIDES_PER_EPOCH: f64 = 16.0;

/// A body as it was last reported.
#[derive(Debug, Clone)]
struct Tracked {
    outline: Outline,
    state: State,
    /// The epoch in which it was reported.
    epoch: u64,
    fixed: bool,
    tags: Vec<String>,
    mass: f64,
}

/// A contact, to be compared with that of another scheduler.
#[derive(Debug, Clone)]
pub struct Logged {
    /// Since the start (time).
    pub time: f64,
    /// Numbers of the bodies.
    pub bodies: [u64; 2],
    /// Which atoms.
    pub atoms: [Option<u32>; 2],
    /// Places before (length).
    pub places: [Pair; 2],
    /// Velocities after (length per time).
    pub velocities: [Pair; 2],
    /// Speed of approach and speeds of the bodies together (length per time).
    pub approach: f64,
    /// Speeds of the bodies and their rims together (length per time).
    pub speed: f64,
    /// Distance of the centres (length).
    pub distance: f64,
}

/// Watches one run.
#[derive(Debug)]
pub struct Watcher {
    sides: Pair,
    bodies: BTreeMap<BodyKey, Tracked>,
    elasticity: ElasticitySpec,
    /// The time of the last event, or of the start.
    last: EpochTime,
    start: EpochTime,
    draw: Draw,
    /// How many epochs have ended.
    pub epochs: u64,
    /// Energy lost in contacts since the last edit, by own sums, and what the ledger had before.
    lost: f64,
    lost_before: f64,
    largest_energy: f64,
    momentum: Option<Pair>,
    contacts: u64,
    /// Whether bodies have become so fast that the clock does not resolve their flight: nothing
    /// more can be judged.
    clock_is_used_up: bool,
    /// All contacts.
    pub log: Vec<Logged>,
    /// What was found.
    pub report: Report,
}

impl Watcher {
    /// Begins to watch.
    pub fn new(view: &View<'_>, elasticity: &ElasticitySpec, seed: u64) -> Self {
        let mut watcher = Self {
            sides: view.bounds().sides().to_array(),
            bodies: BTreeMap::new(),
            elasticity: elasticity.clone(),
            last: view.time(),
            start: view.time(),
            draw: Draw::new(seed),
            epochs: 0,
            lost: 0.0,
            lost_before: 0.0,
            largest_energy: 0.0,
            momentum: None,
            contacts: 0,
            clock_is_used_up: false,
            log: Vec::new(),
            report: Report::default(),
        };
        watcher.begin(view);
        watcher
    }

    /// Takes over what an edit has made.
    pub fn edited(&mut self, view: &View<'_>, elasticity: &ElasticitySpec) {
        self.elasticity = elasticity.clone();
        self.begin(view);
    }

    fn begin(&mut self, view: &View<'_>) {
        self.last = view.time();
        self.lost = 0.0;
        self.lost_before = view.ledger().lost;
        self.largest_energy = view.energy();
        self.contacts = 0;
        let tags = |body: &carom::engine::Body| {
            body.tags().iter().map(|&tag| view.tag_names().name(tag).to_owned()).collect()
        };
        self.bodies = view
            .bodies()
            .map(|body| {
                let tracked = Tracked {
                    outline: Outline::of(body.body.molecule()),
                    state: State::of(&body.motion, view.time()),
                    epoch: self.epochs,
                    fixed: body.body.is_fixed(),
                    tags: tags(body.body),
                    mass: body.body.molecule().mass(),
                };
                (body.body.key(), tracked)
            })
            .collect();
        let free = self.bodies.values().all(|body| !body.fixed);
        self.momentum = free.then(|| self.total_momentum());
    }

    fn longer_side(&self) -> f64 {
        self.sides[0].max(self.sides[1])
    }

    /// Bound on how far the place of a body may be off at `time`, its arms included (length).
    fn error(&self, body: &Tracked, time: EpochTime) -> f64 {
        let epochs = (self.epochs - body.epoch) as f64;
        let turning = if body.state.spin == 0.0 { 0.0 } else { 4.0 + 8.0 * body.state.angle_until(time) };
        // Times are rounded as offsets in an epoch, in which a body goes no farther than this.
        let longest = SIDES_PER_EPOCH * self.longer_side();
        let way = |time: EpochTime| (length(body.state.velocity) * time.offset().abs()).min(longest);
        let clock = way(time) + way(body.state.time);
        // Epochs begin at double-doubles, which do not resolve the flight of bodies that are far
        // too fast for their age.
        let rim = length(body.state.velocity) + body.state.spin.abs() * body.outline.reach;
        let unresolved = RESOLUTION * time.to_f64().abs() * rim;
        f64::EPSILON
            * (ROUNDINGS_PER_EPOCH * (epochs + 1.0) * self.longer_side()
                + turning * body.outline.reach
                + clock
                + OUTWARDS * self.longer_side())
            + unresolved
    }

    fn gap_bound(&self, a: &Outline, b: &Outline) -> f64 {
        ROUNDINGS * f64::EPSILON * (self.longer_side() + a.thickness + b.thickness)
    }

    /// The elasticity of the most specific rule; none where two of equal rank disagree.
    fn rule(&self, a: &Tracked, b: &Tracked) -> f64 {
        let carries = |body: &Tracked, tag: &String| body.tags.contains(tag);
        let of_pair = self.elasticity.pair.iter().find(|rule| match &rule.between[..] {
            [one, other] => (carries(a, one) && carries(b, other)) || (carries(a, other) && carries(b, one)),
            _ => false,
        });
        let of_one = || {
            self.elasticity.pair.iter().find(|rule| match &rule.between[..] {
                [one] => carries(a, one) || carries(b, one),
                _ => false,
            })
        };
        of_pair.or_else(of_one).map_or(self.elasticity.default, |rule| rule.coefficient)
    }

    fn total_momentum(&self) -> Pair {
        let sum =
            |axis: usize| self.bodies.values().map(|body| body.mass * body.state.velocity[axis]).sum::<f64>();
        [sum(0), sum(1)]
    }

    /// Looks at all pairs in all images at one time.
    fn look_at_all(&mut self, time: EpochTime) {
        let placed: Vec<(&Tracked, Placed, f64)> = self
            .bodies
            .values()
            .map(|body| (body, body.state.at(time, self.sides), self.error(body, time)))
            .collect();
        let (mut worst, mut deepest) = (0.0f64, None);
        for (index, (a, at_a, error_a)) in placed.iter().enumerate() {
            for (b, at_b, error_b) in &placed[..index] {
                if a.fixed && b.fixed {
                    continue;
                }
                let gap = smallest_gap((&a.outline, at_a), (&b.outline, at_b), self.sides);
                let bound = self.gap_bound(&a.outline, &b.outline) + error_a + error_b;
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
            self.report.fail("overlap between events", format!("{gap:e} at {time:e}, allowed is {bound:e}"));
        }
    }

    /// Whether a contact that the engine's own brute force finds `time` from now, before the next
    /// one in `next`, is one: whether bodies overlap between the two by more than roundings. Flat
    /// contacts are found at times that differ by more than those of the clock.
    pub fn look_ahead(&mut self, now: EpochTime, time: f64, next: f64) {
        for halvings in 0..LOOKS_AHEAD {
            let after = (next - time) * 0.5f64.powi(halvings);
            self.look_at_all(now.after(time + after));
        }
    }

    /// Whether nothing more is to be checked.
    pub fn is_done(&self) -> bool {
        self.report.failure.is_some() || self.clock_is_used_up
    }

    /// Looks at all pairs at random moments since the last event.
    fn look_back(&mut self, time: EpochTime) {
        let since = time.since(self.last);
        // To the digits of a double-double, in which epochs are kept.
        if exceeds(-since, RESOLUTION * time.to_f64().abs()) {
            self.report.fail("time", format!("an event is {:e} before the last one", -since));
            return;
        }
        let count = self.bodies.len();
        let looks = count <= FEW || self.draw.happens(FEW as f64 / count as f64 / 2.0);
        if since > 0.0 && looks {
            for _ in 0..MOMENTS {
                let moment = self.last.after(self.draw.between(0.0, 1.0) * since);
                self.look_at_all(moment);
            }
        }
        self.last = time;
    }

    /// Compares the state of the system with the own kinematics, at the end of a stretch.
    pub fn compare(&mut self, view: &View<'_>) {
        if self.is_done() {
            return;
        }
        let time = view.time();
        self.look_back(time);
        self.look_at_all(time);
        for body in view.bodies() {
            let Some(tracked) = self.bodies.get(&body.body.key()) else {
                self.report.fail("bodies", "the view has a body that is not known");
                continue;
            };
            let (found, expected) = (State::of(&body.motion, time), tracked.state);
            let placed = expected.at(time, self.sides);
            let error = self.error(tracked, time);
            let off = distance_in_box(found.place, placed.place, self.sides);
            self.report.keep_worst("place/bound", off / error);
            if exceeds(off, error) {
                self.report
                    .fail("place", format!("{} is off by {off:e}, allowed is {error:e}", body.body.id()));
            }
            if found.velocity != expected.velocity || found.spin != expected.spin {
                self.report
                    .fail("velocity", format!("that of {} has changed between contacts", body.body.id()));
            }
            let rotation = body.motion.orientation.cos_sin().to_array();
            let turned = distance_in_box(rotation, placed.rotation, [8.0; 2]) * tracked.outline.reach;
            // The orientation of a disc means nothing.
            if tracked.outline.atoms.len() > 1 && exceeds(turned, error) {
                self.report.fail("orientation", format!("that of {} is off by {turned:e}", body.body.id()));
            }
        }
        self.compare_sums(view);
    }

    fn compare_sums(&mut self, view: &View<'_>) {
        let ledger = view.ledger();
        let contacts = self.contacts as f64 + 16.0;
        let scale = self.largest_energy.max(view.energy()).max(ledger.initial.abs()).max(ledger.put_in.abs());
        let allowed = 16.0 * f64::EPSILON * contacts * scale;
        let resolved = scale > 1e-280;
        let lost = ledger.lost - self.lost_before;
        if resolved && exceeds((lost - self.lost).abs(), allowed) {
            self.report.fail("ledger", format!("{lost:e} is booked as lost, reports lose {:e}", self.lost));
        }
        if resolved && exceeds((view.energy() - ledger.booked()).abs(), allowed) {
            self.report.fail(
                "ledger",
                format!("the energy is {:e}, the ledger says {:e}", view.energy(), ledger.booked()),
            );
        }
        if let Some(before) = self.momentum {
            let now = self.total_momentum();
            let scale: f64 =
                self.bodies.values().map(|body| body.mass * length(body.state.velocity)).sum::<f64>()
                    + length(before);
            let most = scale.max((2.0 * self.largest_energy * self.total_mass()).sqrt());
            let off = length([now[0] - before[0], now[1] - before[1]]);
            if exceeds(off, 16.0 * f64::EPSILON * contacts * most) {
                self.report.fail("total momentum", format!("it is off by {off:e} of {most:e}"));
            }
        }
    }

    fn total_mass(&self) -> f64 {
        self.bodies.values().map(|body| body.mass).sum()
    }

    /// Compares the motion of a body before a contact with the own kinematics.
    fn compare_before(
        &mut self,
        body: &Tracked,
        side: &carom::engine::Side<'_>,
        time: EpochTime,
    ) -> (Placed, f64) {
        let placed = body.state.at(time, self.sides);
        let error = self.error(body, time);
        let found = State::of(&side.before, time);
        let off = distance_in_box(found.place, placed.place, self.sides);
        let id = side.body.id();
        if exceeds(off, error) {
            self.report.fail("place", format!("{id} is off by {off:e} at a contact, allowed is {error:e}"));
        }
        if found.velocity != body.state.velocity || found.spin != body.state.spin {
            self.report.fail("velocity", format!("that of {id} has changed between contacts"));
        }
        let finite = [side.after.velocity.x, side.after.velocity.y, side.after.angular_velocity];
        if finite.iter().any(|number| !number.is_finite()) {
            self.report.fail("NaN", format!("{id} has the velocities {finite:?}"));
        }
        (placed, error)
    }
}

impl Observer for Watcher {
    fn collision(&mut self, contact: &CollisionReport<'_>) {
        if self.is_done() {
            return;
        }
        let time = contact.time;
        let fastest = contact.sides.iter().map(|side| {
            let reach = side.body.molecule().bounding_radius();
            let speed = |motion: &Motion| motion.velocity.length() + motion.angular_velocity.abs() * reach;
            speed(&side.before).max(speed(&side.after))
        });
        let way = RESOLUTION * time.to_f64().abs() * fastest.fold(0.0, f64::max);
        if way > USED_UP * self.longer_side() {
            self.clock_is_used_up = true;
            self.report.count("clocks used up", 1);
            return;
        }
        self.look_back(time);
        self.contacts += 1;
        let tracked = contact.sides.each_ref().map(|side| self.bodies.get(&side.body.key()).cloned());
        let [Some(a), Some(b)] = tracked else {
            self.report.fail("bodies", "a report names a body that is not known");
            return;
        };
        let [(at_a, error_a), (at_b, error_b)] = [
            self.compare_before(&a, &contact.sides[0], time),
            self.compare_before(&b, &contact.sides[1], time),
        ];
        let elasticity = self.rule(&a, &b);
        let rules = Rules {
            sides: self.sides,
            gap: self.gap_bound(&a.outline, &b.outline),
            elasticity,
            guarded: self.elasticity.contact_time > 0.0,
        };
        let bodies = [
            contact::Body { outline: &a.outline, placed: at_a, error: error_a },
            contact::Body { outline: &b.outline, placed: at_b, error: error_b },
        ];
        let measured = contact::check(contact, bodies, &rules, &mut self.report);
        self.lost += measured.lost;
        for side in &contact.sides {
            if let Some(tracked) = self.bodies.get_mut(&side.body.key()) {
                let (sides, epoch) = (self.sides, self.epochs);
                // Every epoch brings places into the box; so does this.
                let placed = State::of(&side.after, time).at(time, sides);
                tracked.state = State { place: placed.place, ..State::of(&side.after, time) };
                tracked.epoch = epoch;
            }
        }
        let energy = |body: &Tracked| 0.5 * body.mass * dot(body.state.velocity, body.state.velocity);
        let now: f64 = [&contact.sides[0], &contact.sides[1]]
            .into_iter()
            .filter(|side| !side.body.is_fixed())
            .filter_map(|side| self.bodies.get(&side.body.key()))
            .map(energy)
            .sum();
        self.largest_energy = self.largest_energy.max(now);
        self.log.push(Logged {
            time: time.since(self.start),
            bodies: contact.sides.each_ref().map(|side| side.body.id()),
            atoms: contact.sides.each_ref().map(|side| side.atom),
            places: [at_a.place, at_b.place],
            velocities: contact.sides.each_ref().map(|side| side.after.velocity.to_array()),
            approach: measured.approach,
            speed: measured.speed,
            distance: measured.distance,
        });
    }
}
