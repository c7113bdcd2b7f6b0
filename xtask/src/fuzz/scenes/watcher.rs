//! Observer of a run that compares all reports with independent kinematics.

use std::{
    borrow::Cow,
    collections::{BTreeMap, BTreeSet},
};

use carom::engine::{BodyKey, BodyView, CollisionReport, Observer, View, WallMotionSpec};
use carom_kinematics::{EpochTime, Motion};
use carom_testkit::oracle::Number as _;

use super::{
    case::{CaseEdit, SceneCase},
    contact::{self, ContactRules, MeasuredContact},
    kinematics::{
        BodyOutline, BodyPair, BodyState, Placed, along, distance_in_box, dot, length, rotated,
        smallest_gap,
    },
    laws::SceneRules,
    oscillation::WallOscillation,
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

/// Rounding that each epoch may add to the phase of an oscillation (radians), in roundings: of the
/// angle, up to 8, of a turn, and of the displacement, from which uniform motion is subtracted.
const ROUNDINGS_OF_PHASE: f64 = 40.0;

/// Rounding of a velocity that a gravity may add in each epoch and contact, in roundings of the
/// speeds in the laboratory and in the falling frame.
const ROUNDINGS_OF_FALL: f64 = 8.0;

/// Distance at which walls may end a run by their meeting, in longer sides.
const CLOSE: f64 = 1e-5;

/// Last reported state of a body; of a wall that oscillates, that at which it began to.
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
    /// Bound on the acceleration of one surface relative to the other, in addition to that of free
    /// bodies that turn (length per time²).
    pub acceleration: f64,
}

/// Observer of one run.
#[derive(Debug)]
pub struct Watcher {
    sides: BodyPair,
    bodies: BTreeMap<BodyKey, Tracked>,
    /// Pairs of fixed bodies that were apart at the last edit, in the order of `bodies`: a run ends
    /// before they meet.
    apart: BTreeSet<[BodyKey; 2]>,
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
    /// Work of walls since the last edit, and the ledger's value then.
    work: f64,
    work_before: f64,
    /// Work of gravity on all bodies from the last edit to the last contact of each, the ledger's
    /// value at that edit, and a bound on the error.
    fallen: f64,
    fallen_before: f64,
    fallen_error: f64,
    /// Bound on the errors of `lost` and `work` from those of the places.
    work_error: f64,
    /// Energy at the last edit.
    energy_before: f64,
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
    pub fn new(view: &View<'_>, rules: &SceneRules, case: &SceneCase) -> Self {
        let mut watcher = Self {
            sides: view.bounds().sides().to_array(),
            bodies: BTreeMap::new(),
            apart: BTreeSet::new(),
            rules: rules.clone(),
            last: view.time(),
            start: view.time(),
            draw: FuzzDraw::new(case.seed),
            epochs: 0,
            lost: 0.0,
            lost_before: 0.0,
            work: 0.0,
            work_before: 0.0,
            fallen: 0.0,
            fallen_before: 0.0,
            fallen_error: 0.0,
            work_error: 0.0,
            energy_before: 0.0,
            largest_energy: 0.0,
            largest_entry: 0.0,
            entries: 16.0,
            momentum: None,
            contacts: 0,
            clock_is_used_up: false,
            log: Vec::new(),
            report: Report::default(),
        };
        // Walls are in the order of the scene.
        let walls = view.bodies().filter(|body| body.body.is_wall());
        let given = walls.zip(&case.scene.wall).filter_map(|(body, spec)| {
            let motion = GivenMotion {
                motion: spec.motion.as_ref()?,
                middle: spec
                    .from
                    .zip(spec.to)
                    .map(|(from, to)| [0, 1].map(|axis| 0.5 * (from[axis] + to[axis]))),
            };
            Some((body.body.key(), motion))
        });
        watcher.start_watching(view, &given.collect());
        watcher
    }

    /// Updates the state after each edit: the next may take out the energy that this has put in. An
    /// edit that was refused is `None`.
    pub fn edited(&mut self, view: &View<'_>, rules: &SceneRules, edit: Option<&CaseEdit>) {
        self.rules = rules.clone();
        // The edit begins an epoch.
        self.epochs += 1;
        let time = view.time();
        if let Some(CaseEdit::Reverse) = edit {
            for body in self.bodies.values_mut() {
                body.state = body.state.reversed(time);
            }
        }
        let moved = edit.and_then(|edit| edit.moved_wall(view));
        let given = moved.into_iter().map(|(key, motion)| {
            let known = self.bodies.get(&key);
            let middle = known.map(|wall| wall.middle(wall.state.at(time, self.sides)));
            (key, GivenMotion { motion, middle })
        });
        let given = given.collect();
        self.start_watching(view, &given);
    }

    /// Takes over the state of all bodies, of which some are walls that are now given a motion.
    fn start_watching(&mut self, view: &View<'_>, given: &BTreeMap<BodyKey, GivenMotion<'_>>) {
        self.last = view.time();
        let ledger = view.ledger();
        (self.lost, self.work, self.fallen) = (0.0, 0.0, 0.0);
        (self.fallen_error, self.work_error) = (0.0, 0.0);
        (self.lost_before, self.work_before) = (ledger.lost, ledger.work);
        self.fallen_before = ledger.fallen;
        self.energy_before = view.energy();
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
        let before = std::mem::take(&mut self.bodies);
        for body in view.bodies() {
            let key = body.body.key();
            let mut tracked = Tracked {
                outline: BodyOutline::new(body.body.molecule()),
                state: self.state(&body.motion, view.time(), body.body.is_fixed()),
                epoch: self.epochs,
                fixed: body.body.is_fixed(),
                tags: tags(body.body),
                mass: body.body.molecule().mass(),
            };
            if let Some(given) = given.get(&key) {
                tracked.state.oscillation = WallOscillation::new(given.motion, view.time());
                self.check_given(&tracked, given, body.body.id());
            } else if let Some(known) = before.get(&key).filter(|known| known.fixed) {
                // No other edit changes the motion of a wall.
                self.compare_velocity(known, &tracked.state, body.body.id());
                if known.state.oscillation.is_some() {
                    (tracked.state, tracked.epoch) = (known.state, known.epoch);
                }
            }
            self.bodies.insert(key, tracked);
        }
        self.apart = self.fixed_pairs_apart(view.time());
        let free = self.bodies.values().all(|body| !body.fixed);
        let time = view.time();
        self.momentum = free.then(|| (self.total_momentum(time), time));
    }

    /// The pairs of fixed bodies that are apart by more than rounding.
    fn fixed_pairs_apart(&self, time: EpochTime) -> BTreeSet<[BodyKey; 2]> {
        let mut apart = BTreeSet::new();
        if !self.rules.moves_walls {
            return apart;
        }
        let fixed: Vec<_> = self.bodies.iter().filter(|(_, body)| body.fixed).collect();
        for (index, (key, body)) in fixed.iter().enumerate() {
            for (earlier, other) in &fixed[..index] {
                let gap = self.gap_of_fixed([other, body], 0.0, time);
                if gap > self.gap_bound(&other.outline, &body.outline) {
                    apart.insert([**earlier, **key]);
                }
            }
        }
        apart
    }

    /// The smallest gap of two fixed bodies, which may be walls across the box, if walls were
    /// thicker by this (lengths).
    fn gap_of_fixed(&self, pair: [&Tracked; 2], thicker: f64, time: EpochTime) -> f64 {
        let [one, two] = pair.map(|body| body.outline.with_ends().thickened(thicker));
        let [at_one, at_two] = pair.map(|body| body.state.at(time, self.sides));
        smallest_gap((&one, &at_one), (&two, &at_two), self.sides)
    }

    /// Checks that two bodies that have ended the run by their meeting are close to each other: the
    /// detector sees walls of which one turns meet a little before.
    pub fn check_meeting(&mut self, keys: [BodyKey; 2], time: EpochTime) {
        let [Some(a), Some(b)] = keys.map(|key| self.bodies.get(&key)) else {
            self.report.fail("bodies", "walls that meet are unknown");
            return;
        };
        // No gap is computed if the bounding circles do not meet.
        let thicker = CLOSE * self.longer_side();
        let gap = self.gap_of_fixed([a, b], thicker, time);
        if exceeds(gap, 0.0) {
            let detail = format!("they are apart by {gap:e} more than {thicker:e}");
            self.report.fail("walls meet", detail);
        }
    }

    /// The state of a body with this motion at a time.
    fn state(&self, motion: &Motion, time: EpochTime, fixed: bool) -> BodyState {
        let (gravity, drag) = if fixed {
            ([0.0; 2], 0.0)
        } else {
            (self.rules.gravity, self.rules.drag)
        };
        BodyState {
            gravity,
            ..BodyState::new(motion, time, drag)
        }
    }

    /// Checks that a wall begins the motion that it has just been given: about the right pivot, and
    /// without a jump.
    fn check_given(&mut self, wall: &Tracked, given: &GivenMotion<'_>, id: u64) {
        let GivenMotion { motion, middle } = given;
        let (state, time) = (&wall.state, wall.state.time);
        let velocity = state
            .oscillation
            .map_or(motion.velocity, |oscillation| oscillation.velocity(time));
        let off = length(along(state.velocity, -1.0, velocity));
        let allowed = if state.oscillation.is_some() {
            self.velocity_error(wall, time)
        } else {
            0.0
        };
        if exceeds(off, allowed) || state.spin != motion.turn {
            self.report.fail(
                "motion of a wall",
                format!("wall {id} has {state:?}, but is given {motion:?}"),
            );
        }
        let Some(middle) = *middle else { return };
        let placed = state.at(time, self.sides);
        let turns = motion.turn != 0.0;
        let pivot = motion.about.filter(|_| turns).unwrap_or(middle);
        let [of_middle, of_pivot] = [(wall.middle(placed), middle), (placed.place, pivot)]
            .map(|(found, expected)| distance_in_box(found, expected, self.sides));
        let allowed = ROUNDINGS * f64::EPSILON * (self.longer_side() + wall.outline.reach);
        if exceeds(of_middle, allowed) || (turns && exceeds(of_pivot, allowed)) {
            self.report.fail(
                "motion of a wall",
                format!(
                    "the middle of wall {id} deviates by {of_middle:e} and its pivot by {of_pivot:e}"
                ),
            );
        }
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
            ledger.work,
            ledger.fallen,
            // Sums of m g·x over all bodies, of which an entry is the difference.
            self.total_mass() * length(self.rules.gravity) * self.longer_side(),
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
        let speed = body.state.top_speed(time);
        let way = |time: EpochTime| (speed * time.offset().abs()).min(longest);
        let times = if self.rules.drag == 0.0 {
            1.0
        } else {
            ROUNDINGS_OF_CLOCK
        };
        let clock = times * (way(time) + way(body.state.time));
        // Epochs start at double-double times, which do not resolve the motion of very fast bodies
        // at late times.
        let rim = speed + body.state.spin.abs() * body.outline.reach;
        let mut unresolved = RESOLUTION * time.to_f64().abs() * rim;
        if body.state.gravity != [0.0; 2] {
            unresolved += self.velocity_error(body, time) * time.since(body.state.time).abs();
        }
        // Each epoch of an oscillation begins at the place that its phase gives.
        let rounded = match &body.state.oscillation {
            None => ROUNDINGS_PER_EPOCH * (epochs + 1.0) * self.longer_side(),
            Some(oscillation) => {
                ROUNDINGS_PER_EPOCH * self.longer_side()
                    + ROUNDINGS_OF_PHASE * (epochs + 1.0) * length(oscillation.amplitude)
            }
        };
        f64::EPSILON
            * (rounded
                + turning * body.outline.reach
                + clock
                + dragged * body.state.path_until(time)
                + OUTWARDS * self.longer_side())
            + unresolved
    }

    /// Bound on the error of a velocity that gravity or an oscillation changes (length per time).
    fn velocity_error(&self, body: &Tracked, time: EpochTime) -> f64 {
        let epochs = (self.epochs - body.epoch + 1) as f64;
        let state = &body.state;
        let (speed, acceleration, roundings) = if let Some(oscillation) = &state.oscillation {
            let speed = oscillation.top_speed();
            (speed, speed * oscillation.frequency, ROUNDINGS_OF_PHASE)
        } else {
            let gravity = length(state.gravity);
            let falling = (gravity * self.longer_side()).sqrt();
            (state.top_speed(time) + falling, gravity, ROUNDINGS_OF_FALL)
        };
        f64::EPSILON * roundings * epochs * speed + RESOLUTION * time.to_f64().abs() * acceleration
    }

    /// The work of gravity on a body since its last report, and a bound on its error (mass ×
    /// length² / time²).
    fn fall(&self, body: &Tracked, time: EpochTime) -> [f64; 2] {
        let gravity = body.state.gravity;
        if gravity == [0.0; 2] {
            return [0.0; 2];
        }
        let way = body.state.displacement(time).map(|way| way.value());
        let error = self.error(body, time) + 4.0 * f64::EPSILON * length(way);
        [dot(gravity, way), length(gravity) * error].map(|work| body.mass * work)
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
        let placed: Vec<(BodyKey, &Tracked, Placed, f64)> = self
            .bodies
            .iter()
            .map(|(key, body)| {
                (
                    *key,
                    body,
                    body.state.at(time, self.sides),
                    self.error(body, time),
                )
            })
            .collect();
        let (mut worst, mut deepest) = (0.0f64, None);
        for (index, (key_a, a, at_a, error_a)) in placed.iter().enumerate() {
            for (key_b, b, at_b, error_b) in &placed[..index] {
                if a.fixed && b.fixed && !self.apart.contains(&[*key_b, *key_a]) {
                    continue;
                }
                let factor = self.rules.factor(&a.tags, &b.tags);
                if factor == 0.0 {
                    continue;
                }
                let [one, other] = [a, b].map(|body| match (a.fixed, b.fixed) {
                    (true, true) => Cow::Owned(body.outline.with_ends()),
                    _ => outline_for(body, factor),
                });
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
            let found = self.state(&body.motion, time, tracked.fixed);
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

    /// Compares velocity and spin with those that follow from the last event: equal for uniform
    /// motion, and to rounding for other motions.
    fn compare_velocity(&mut self, body: &Tracked, found: &BodyState, id: u64) {
        let state = &body.state;
        if self.rules.drag == 0.0 && !state.is_uniform() {
            let expected = state.velocity_at(found.time);
            let off = length(along(found.velocity, -1.0, expected));
            let allowed = self.velocity_error(body, found.time);
            self.report.keep_worst("driven/bound", off / allowed);
            if exceeds(off, allowed) || found.spin != state.spin {
                self.report.fail(
                    "velocity",
                    format!(
                        "velocity {:?} of {id} deviates by {off:e} from {expected:?}, allowed {allowed:e}",
                        found.velocity
                    ),
                );
            }
            return;
        }
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

    /// The number of epochs, each of which adds roundings to all sums if there is a drag or a
    /// gravity.
    fn rounding_epochs(&self) -> f64 {
        if self.rules.drag == 0.0 && self.rules.gravity == [0.0; 2] {
            0.0
        } else {
            self.epochs as f64
        }
    }

    fn compare_sums(&mut self, view: &View<'_>) {
        let ledger = view.ledger();
        self.keep_largest_entry(view);
        let scale = self.largest_entry.max(self.largest_energy);
        let epochs = self.rounding_epochs();
        let allowed = 16.0 * f64::EPSILON * (self.entries + epochs) * scale;
        let resolved = scale > 1e-280;
        let falls = self
            .bodies
            .values()
            .map(|body| self.fall(body, view.time()));
        let [fallen, fallen_error] = falls.fold(
            [self.fallen, self.fallen_error],
            |[sum, errors], [work, error]| [sum + work, errors + error],
        );
        for (name, entry, own, error) in [
            (
                "loss",
                ledger.lost - self.lost_before,
                self.lost,
                self.work_error,
            ),
            (
                "work",
                ledger.work - self.work_before,
                self.work,
                self.work_error,
            ),
            (
                "work of gravity",
                ledger.fallen - self.fallen_before,
                fallen,
                fallen_error,
            ),
        ] {
            if resolved && exceeds((entry - own).abs(), allowed + error) {
                self.report.fail(
                    "ledger",
                    format!("the ledger has a {name} of {entry:e}, the reports of {own:e}"),
                );
            }
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
        // Kinetic energy grows by the work of walls and of gravity, less the losses.
        let given = self.work + fallen - self.lost;
        let off = (own - self.energy_before - given).abs();
        let allowed = allowed + rounding + 2.0 * self.work_error + fallen_error;
        if resolved && self.rules.drag == 0.0 {
            self.report.keep_worst("balance/bound", off / allowed);
            if exceeds(off, allowed) {
                self.report.fail(
                    "balance",
                    format!(
                        "the energy grew from {:e} to {own:e} with {:e} from walls, {fallen:e} from gravity and a loss \
                         of {:e}: {off:e} is missing, allowed {allowed:e}",
                        self.energy_before, self.work, self.lost
                    ),
                );
            }
        }
        self.compare_momentum(view);
    }

    fn compare_momentum(&mut self, view: &View<'_>) {
        let epochs = self.rounding_epochs();
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
        let found = self.state(&side.before, time, body.fixed);
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
            let Some(known) = self.bodies.get(&side.body.key()) else {
                continue;
            };
            let [fallen, error] = self.fall(known, contact.time);
            let state = self.state(&side.after, contact.time, known.fixed);
            self.fallen += fallen;
            self.fallen_error += error;
            // Contacts do not change an oscillation.
            if let Some(tracked) = self.bodies.get_mut(&side.body.key())
                && tracked.state.oscillation.is_none()
            {
                let (sides, epoch) = (self.sides, self.epochs);
                // Positions are wrapped into the box, as at the start of every epoch.
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

    /// The speed at which the guard separates a body at least from a fixed one on which it has
    /// fallen: the share `contact_time` of that after a fall by its radius (length per time).
    fn bounce(&self, contact: &CollisionReport<'_>) -> f64 {
        let sides = || contact.sides.iter();
        if !sides().any(|side| side.body.is_fixed()) {
            return 0.0;
        }
        let bodies = sides().filter(|side| !side.body.is_wall());
        let radii = bodies.map(|side| side.body.molecule().bounding_radius());
        let diameter = 2.0 * radii.fold(f64::INFINITY, f64::min);
        self.rules.elasticity.contact_time * (diameter * length(self.rules.gravity)).sqrt()
    }

    /// Returns true if gravity or the motion of a wall accelerates one of two surfaces.
    fn is_accelerated(&self, contact: &CollisionReport<'_>) -> bool {
        self.acceleration(contact, 0.0) > 0.0
    }

    /// Bound on the relative acceleration of two surfaces by gravity and by the motion of a wall
    /// (length per time²).
    fn acceleration(&self, contact: &CollisionReport<'_>, speed: f64) -> f64 {
        let sides = contact.sides.iter();
        let fixed =
            sides.filter_map(|side| self.bodies.get(&side.body.key()).filter(|body| body.fixed));
        let of_wall = |wall: &Tracked| {
            let spin = wall.state.spin.abs();
            let turning = spin * (2.0 * speed + spin * wall.outline.reach);
            let oscillation = wall.state.oscillation;
            turning + oscillation.map_or(0.0, |one| one.top_speed() * one.frequency)
        };
        fixed
            .map(|wall| of_wall(wall) + length(self.rules.gravity))
            .sum()
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
            acceleration: self.acceleration(contact, measured.speed),
        });
    }
}

/// The motion that a wall is given.
#[derive(Debug, Clone, Copy)]
struct GivenMotion<'a> {
    motion: &'a WallMotionSpec,
    /// The middle of the wall before; `None` if it is not known (length).
    middle: Option<BodyPair>,
}

impl Tracked {
    /// The middle of a wall (length).
    fn middle(&self, placed: Placed) -> BodyPair {
        let middle = self.outline.edges.first().map(|edge| edge.middle);
        along(
            placed.place,
            1.0,
            rotated(middle.unwrap_or_default(), placed.rotation),
        )
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
            bounce: self.bounce(contact),
            accelerated: self.is_accelerated(contact),
        };
        let body = |n: usize, placed: Placed, error: f64| contact::ContactBody {
            outline: &outlines[n],
            placed,
            error,
        };
        let bodies = [body(0, at_a, error_a), body(1, at_b, error_b)];
        let measured = contact::check(contact, bodies, &rules, &mut self.report);
        self.lost += measured.lost;
        self.work += measured.work;
        self.work_error += measured.energy_error;
        self.largest_entry = self
            .largest_entry
            .max((self.lost_before + self.lost).abs())
            .max((self.work_before + self.work).abs());
        self.track(contact);
        self.add_to_log(contact, [at_a.place, at_b.place], &measured);
    }
}
