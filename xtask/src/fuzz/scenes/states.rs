//! The comparison of places, velocities and orientations with the independent kinematics.

use carom::engine::{Side, View};
use carom_kinematics::EpochTime;

use super::{
    bounds::{ROUNDINGS, ROUNDINGS_OF_DRAG},
    kinematics::{BodyPair, BodyState, Placed, along, distance_in_box, length},
    stops::PistonStops,
    tracked::{GivenMotion, TrackedBody},
    watcher::Watcher,
};
use crate::fuzz::subject::exceeds;

impl Watcher {
    /// Checks that a wall begins the motion that it has just been given: about the right pivot, and
    /// without a jump.
    pub(super) fn check_given(&mut self, wall: &TrackedBody, given: &GivenMotion<'_>, id: u64) {
        let GivenMotion { motion, middle } = given;
        let (state, time) = (&wall.state, wall.state.time);
        let velocity = match (&state.oscillation, &state.table) {
            (Some(oscillation), _) => oscillation.velocity(time),
            (_, Some(table)) => table.velocity(time),
            _ => motion.velocity,
        };
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
                    "the middle of wall {id} deviates by {of_middle:e} and its pivot by \
                     {of_pivot:e}"
                ),
            );
        }
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
            let found = self.state(&body.motion, time, &tracked);
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
        self.compare_shells(view);
        self.compare_sums(view);
    }

    /// The velocity of a body at a time, or that shortly before or after at which it changes, of
    /// which the nearest to the one found counts (length per time).
    fn velocity_near(&self, body: &TrackedBody, found: &BodyState) -> BodyPair {
        let (state, time) = (&body.state, found.time);
        let expected = state.velocity_at(time);
        let mut others = Vec::new();
        if let Some(table) = &state.table {
            let off = self.table_time_error(body) + 2.0 * f64::EPSILON * time.offset().abs();
            others.extend([-off, off].map(|off| table.velocity(time.after(off))));
        }
        if let Some(PistonStops {
            axis,
            ends,
            elasticity,
            ..
        }) = state.stops
        {
            let place = state.at(time, self.sides).place[axis];
            let error = 2.0 * self.error(body, time);
            if ends.iter().any(|end| (place - end).abs() <= error) {
                // Just before the stop, or just after it.
                others
                    .extend([elasticity, 1.0, 1.0 / elasticity].map(|e| expected.map(|v| -e * v)));
            }
        }
        let off = |velocity: &BodyPair| length(along(found.velocity, -1.0, *velocity));
        let nearest = |nearest: BodyPair, other: BodyPair| {
            if off(&other) < off(&nearest) {
                other
            } else {
                nearest
            }
        };
        others.into_iter().fold(expected, nearest)
    }

    /// Compares velocity and spin with those that follow from the last event: equal for uniform
    /// motion, and to rounding for other motions.
    pub(super) fn compare_velocity(&mut self, body: &TrackedBody, found: &BodyState, id: u64) {
        let state = &body.state;
        if self.rules.drag == 0.0 && !state.is_uniform() {
            let expected = self.velocity_near(body, found);
            let off = length(along(found.velocity, -1.0, expected));
            let allowed = self.velocity_error(body, found.time);
            // Of a piston at rest both are 0.
            if off > 0.0 {
                self.report.keep_worst("driven/bound", off / allowed);
            }
            if exceeds(off, allowed) || found.spin != state.spin {
                self.report.fail(
                    "velocity",
                    format!(
                        "velocity {:?} of {id} deviates by {off:e} from {expected:?}, allowed \
                         {allowed:e}",
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

    /// Compares the motion of a body before a contact with the independent kinematics.
    pub(super) fn compare_before(
        &mut self,
        body: &TrackedBody,
        side: &Side<'_>,
        time: EpochTime,
    ) -> (Placed, f64) {
        let placed = body.state.at(time, self.sides);
        let error = self.error(body, time);
        let found = self.state(&side.before, time, body);
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
}
