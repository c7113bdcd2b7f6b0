//! Observer of a run that compares all reports with independent kinematics.

use std::collections::{BTreeMap, BTreeSet};

use carom::engine::{BodyKey, CollisionReport, Observer, PistonSpec, View};
use carom_kinematics::{EpochTime, Motion};

use super::{
    case::{CaseEdit, SceneCase, piston},
    contact::{self, ContactRules, MeasuredContact},
    kinematics::{BodyOutline, BodyPair, BodyState, Placed, along, dot, length},
    laws::SceneRules,
    oscillation::WallOscillation,
    stops::PistonStops,
    table_path::TablePath,
    tracked::{
        GivenMotion, KnownShell, TrackedBody, TrackedBond, TrackedPiston, guard_of_stops,
        outline_for,
    },
};
use crate::fuzz::{random::FuzzDraw, subject::Report};

/// Relative resolution of a time of two floats, with room for some rounding errors.
pub(super) const RESOLUTION: f64 = f64::EPSILON * f64::EPSILON * 16.0;

/// The clock resolution is insufficient if a body moves this share of the side within it.
const USED_UP: f64 = 1e-14;

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
    pub(super) sides: BodyPair,
    pub(super) bodies: BTreeMap<BodyKey, TrackedBody>,
    /// The pistons of the scene; some may have been removed.
    pistons: BTreeMap<BodyKey, TrackedPiston>,
    /// Pairs of fixed bodies and pistons that were apart at the last edit, in the order of
    /// `bodies`: a run ends before walls meet.
    pub(super) apart: BTreeSet<[BodyKey; 2]>,
    pub(super) rules: SceneRules,
    /// Time of the last event, or of the start.
    pub(super) last: EpochTime,
    pub(super) start: EpochTime,
    pub(super) draw: FuzzDraw,
    /// Number of epochs that have ended.
    pub epochs: u64,
    /// Energy lost in contacts since the last edit, summed here, and the ledger's value at that
    /// edit.
    pub(super) lost: f64,
    pub(super) lost_before: f64,
    /// Work of walls since the last edit, and the ledger's value then.
    pub(super) work: f64,
    pub(super) work_before: f64,
    /// Energy gained in wells since the last edit, and the ledger's value then.
    pub(super) gained: f64,
    pub(super) gained_before: f64,
    /// The bonds of the scene; some bodies may have been removed.
    pub(super) bonds: Vec<TrackedBond>,
    /// The shells of the pairs of discs within the ranges of their wells.
    pub(super) shells: BTreeMap<[BodyKey; 2], KnownShell>,
    /// Work of gravity on all bodies from the last edit to the last contact of each, the ledger's
    /// value at that edit, and a bound on the error.
    pub(super) fallen: f64,
    pub(super) fallen_before: f64,
    pub(super) fallen_error: f64,
    /// Bound on the errors of `lost` and `work` from those of the places.
    pub(super) work_error: f64,
    /// Energy at the last edit.
    pub(super) energy_before: f64,
    pub(super) largest_energy: f64,
    /// Largest energy and largest entry of the ledger since the start. Edits do not reset it, since
    /// the ledger keeps its rounding errors.
    pub(super) largest_entry: f64,
    /// Number of energies summed and entered into the ledger since the start.
    pub(super) entries: f64,
    /// Total momentum at the last edit, and that time.
    pub(super) momentum: Option<(BodyPair, EpochTime)>,
    pub(super) contacts: u64,
    /// True if the clock does not resolve the motion of very fast bodies; further checks are not
    /// possible.
    pub(super) clock_is_used_up: bool,
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
            pistons: BTreeMap::new(),
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
            gained: 0.0,
            gained_before: 0.0,
            bonds: Vec::new(),
            shells: BTreeMap::new(),
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
        // Walls are in the order of the scene, and pistons follow them.
        let walls = || view.bodies().filter(|body| body.body.is_wall());
        for (body, spec) in walls().skip(case.scene.wall.len()).zip(&case.scene.piston) {
            let key = body.body.key();
            let stops = view.piston(key).map_or([0.0; 2], |(_, stops)| stops);
            watcher.check_start_of_piston(&body.motion, spec);
            let tracked = TrackedPiston::new(spec, stops, &case.scene.elasticity);
            watcher.pistons.insert(key, tracked);
        }
        let given = walls().zip(&case.scene.wall).filter_map(|(body, spec)| {
            let motion = GivenMotion {
                motion: spec.motion.as_ref()?,
                middle: spec
                    .from
                    .zip(spec.to)
                    .map(|(from, to)| [0, 1].map(|axis| 0.5 * (from[axis] + to[axis]))),
            };
            Some((body.body.key(), motion))
        });
        watcher.take_bonds(view, &case.scene);
        watcher.start_watching(view, &given.collect());
        watcher
    }

    /// Checks that a piston begins with the velocity that it is given.
    fn check_start_of_piston(&mut self, motion: &Motion, spec: &PistonSpec) {
        let axis = usize::from(spec.x.is_none());
        let mut expected = [0.0; 2];
        expected[axis] = spec.velocity;
        let found = motion.velocity.to_array();
        if found != expected {
            self.report.fail(
                "velocity",
                format!("a piston begins with the velocity {found:?}, not {expected:?}"),
            );
        }
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
        if let Some(CaseEdit::Push(index, force)) = edit
            && let Some(piston) = self.pistons.get_mut(&piston(view, *index))
        {
            piston.force = *force;
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
        (self.gained, self.gained_before) = (0.0, ledger.wells);
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
            let piston = self.pistons.get(&key).copied();
            let of_molecule = body.body.molecule().mass();
            let mut tracked = TrackedBody {
                outline: BodyOutline::new(body.body.molecule()),
                state: BodyState::new(&body.motion, view.time(), 0.0),
                epoch: self.epochs,
                fixed: body.body.is_fixed(),
                tags: tags(body.body),
                mass: piston.map_or(of_molecule, |piston| piston.mass),
                reported: view.time(),
                piston,
                reflections: (0.0, f64::INFINITY),
            };
            tracked.state.last_stop = before.get(&key).and_then(|known| known.state.last_stop);
            tracked.state = self.state(&body.motion, view.time(), &tracked);
            if let Some(given) = given.get(&key) {
                tracked.state.oscillation = WallOscillation::new(given.motion, view.time());
                tracked.state.table = TablePath::new(given.motion, view.time());
                self.check_given(&tracked, given, body.body.id());
            } else if let Some(known) = before.get(&key).filter(|known| known.fixed) {
                // No other edit changes the motion of a wall.
                self.compare_velocity(known, &tracked.state, body.body.id());
                if known.has_path() {
                    (tracked.state, tracked.epoch) = (known.state, known.epoch);
                }
            }
            self.bodies.insert(key, tracked);
        }
        self.apart = self.fixed_pairs_apart(view.time());
        self.sort_into_shells(view.time());
        let free = self.bodies.values().all(|body| !body.fixed);
        let time = view.time();
        self.momentum = free.then(|| (self.total_momentum(time), time));
    }

    /// The state at a time of a body, which then has this motion.
    pub(super) fn state(&self, motion: &Motion, time: EpochTime, body: &TrackedBody) -> BodyState {
        let (gravity, drag) = if let Some(piston) = &body.piston {
            (piston.acceleration(self.rules.gravity), 0.0)
        } else if body.fixed {
            ([0.0; 2], 0.0)
        } else {
            (self.rules.gravity, self.rules.drag)
        };
        BodyState {
            gravity,
            stops: body.piston.map(|piston| PistonStops {
                contact_time: guard_of_stops(&self.rules.elasticity),
                ..piston.stops
            }),
            spring: body.piston.and_then(|piston| piston.spring),
            last_stop: body.state.last_stop,
            ..BodyState::new(motion, time, drag)
        }
    }

    /// Returns true if no further checks are needed.
    pub fn is_done(&self) -> bool {
        self.report.failure.is_some() || self.clock_is_used_up
    }

    /// Takes over the states of both bodies after a contact, and the largest energies.
    fn track(&mut self, contact: &CollisionReport<'_>) {
        for side in &contact.sides {
            let Some(known) = self.bodies.get(&side.body.key()) else {
                continue;
            };
            let [fallen, error] = self.fall(known, contact.time);
            let state = self.state(&side.after, contact.time, known);
            self.fallen += fallen;
            self.fallen_error += error;
            // Contacts do not change the path of a wall.
            if let Some(tracked) = self.bodies.get_mut(&side.body.key())
                && !tracked.has_path()
            {
                let (sides, epoch) = (self.sides, self.epochs);
                // Positions are wrapped into the box, as at the start of every epoch.
                let placed = state.at(contact.time, sides);
                tracked.state = BodyState {
                    place: placed.place,
                    ..state
                };
                tracked.epoch = epoch;
                tracked.reported = contact.time;
                tracked.reflections = (0.0, f64::INFINITY);
            }
        }
        let energy =
            |body: &TrackedBody| 0.5 * body.mass * dot(body.state.velocity, body.state.velocity);
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

    /// The speed at which the guard separates two bodies at least of which gravity, or the force on
    /// a piston, accelerates one relative to the other: the share `contact_time` of the speed after
    /// a fall by the diameter of the smaller one (length per time). The acceleration by a spring
    /// does not count.
    fn bounce(&self, contact: &CollisionReport<'_>) -> f64 {
        let [of_first, of_second] = contact.sides.each_ref().map(|side| {
            let known = self.bodies.get(&side.body.key());
            known.map_or([0.0; 2], |body| body.state.gravity)
        });
        let sides = contact.sides.iter();
        let bodies = sides.filter(|side| !side.body.is_wall());
        let radii = bodies.map(|side| side.body.molecule().bounding_radius());
        let diameter = 2.0 * radii.fold(f64::INFINITY, f64::min);
        let fall = length(along(of_second, -1.0, of_first));
        self.rules.elasticity.contact_time * (diameter * fall).sqrt()
    }

    /// Returns true if gravity, a force, a spring or the motion of a wall accelerates one of two
    /// surfaces.
    fn is_accelerated(&self, contact: &CollisionReport<'_>) -> bool {
        self.acceleration(contact, 0.0) > 0.0
    }

    /// Bound on the relative acceleration of two surfaces by gravity, by the force on a piston and
    /// its spring and by the motion of a wall (length per time²).
    fn acceleration(&self, contact: &CollisionReport<'_>, speed: f64) -> f64 {
        let sides = contact.sides.iter();
        let bodies = sides.filter_map(|side| self.bodies.get(&side.body.key()));
        let barriers = bodies.filter(|body| body.is_barrier());
        let of_wall = |wall: &TrackedBody| {
            let spin = wall.state.spin.abs();
            let turning = spin * (2.0 * speed + spin * wall.outline.reach);
            let oscillation = wall.state.oscillation;
            let of_force = wall.state.top_acceleration();
            turning + of_force + oscillation.map_or(0.0, |one| one.top_speed() * one.frequency)
        };
        barriers
            .map(|wall| of_wall(wall) + length(self.rules.gravity))
            .sum()
    }

    /// Checks a collision of two bodies, given with their placements before it and the bounds on
    /// the errors of those (length).
    fn check_collision(
        &mut self,
        contact: &CollisionReport<'_>,
        [a, b]: [&TrackedBody; 2],
        [(at_a, error_a), (at_b, error_b)]: [(Placed, f64); 2],
    ) -> MeasuredContact {
        if self.have_well(contact) {
            self.check_touching_in_well(contact);
        }
        let factor = self.rules.factor(&a.tags, &b.tags);
        let outlines = [a, b].map(|body| outline_for(body, factor));
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
        contact::check(contact, bodies, &rules, &mut self.report)
    }

    /// Adds the energies of a contact to the sums since the last edit, and keeps the largest entry
    /// of the ledger.
    fn add_energies(&mut self, measured: &MeasuredContact) {
        self.lost += measured.lost;
        self.work += measured.work;
        self.work_error += measured.energy_error;
        let entries = [
            self.lost_before + self.lost,
            self.work_before + self.work,
            self.gained_before + self.gained,
        ];
        self.largest_entry = entries
            .into_iter()
            .map(f64::abs)
            .fold(self.largest_entry, f64::max);
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
        if contact.bond.is_none() && self.rules.factor(&a.tags, &b.tags) == 0.0 {
            self.report.fail(
                "transparent",
                format!("bodies that do not see each other touch: {contact:?}"),
            );
            return;
        }
        let measured = if contact.bond.is_some() {
            self.check_bond(contact, [at_a, at_b], error_a + error_b)
        } else if contact.is_step {
            self.check_step(contact)
        } else {
            self.check_collision(contact, [&a, &b], [(at_a, error_a), (at_b, error_b)])
        };
        self.add_energies(&measured);
        self.track(contact);
        self.add_to_log(contact, [at_a.place, at_b.place], &measured);
    }
}
