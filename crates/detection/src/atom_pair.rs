//! The gap between an atom of A and an atom of B, or between two circles that hold atoms.

use carom_geometry::Circle;
use carom_kinematics::{HALF_ULP as U, Orientation};
use glam::DVec2;

use crate::{
    ErrorBound, Phase, SearchWindow,
    flight::{Flight, Pose},
    gap_search::{Gap, GapFunction},
    safe_step::{Curvature, safe_step},
    search::Search,
    skim,
    skimming::rounding_within,
    tolerance::{FAST_ROTOR, MIN_ATOM_ERRORS, MIN_JERK},
    trace::Recorder,
};

/// Two circles in flight, each fixed in its body, in the notation of
/// [`gap_search`](crate::gap_search).
pub(crate) struct AtomPair<'a> {
    flight: &'a Flight<'a>,
    offsets: [DVec2; 2],
    arms: [f64; 2],
    /// s
    contact_distance: f64,
    /// ω_A² r_A and ω_B² r_B, whose sum is K.
    centripetal: [f64; 2],
    /// K₃
    jerk: f64,
    /// C₃
    gap_jerk: f64,
    /// J
    relative_jerk: f64,
    pub(crate) error: ErrorBound,
}

/// The two circles at one time.
pub(crate) struct PairPose {
    at: Pose,
    /// d
    pub(crate) d: DVec2,
    /// Arms of both circles in their present orientation.
    arms: [DVec2; 2],
}

impl<'a> AtomPair<'a> {
    #[inline]
    pub(crate) fn new(flight: &'a Flight<'a>, circles: [Circle; 2]) -> Self {
        let [spin_a, spin_b] = flight.spin;
        let [a, b] = [
            centripetal(spin_a, circles[0].arm),
            centripetal(spin_b, circles[1].arm),
        ];
        let error = ErrorBound::of_circles(flight.motion, flight.speed, flight.spin, &circles);
        let contact_distance = circles[0].radius + circles[1].radius;
        let jerk = spin_a.abs() * a + spin_b.abs() * b;
        let angle = error.speed() / contact_distance;
        // 3 and 1.1547 with |d| ≥ (1 − 1/64) s; see `MIN_ATOM_ERRORS`.
        let gap_jerk = jerk + angle * (3.05 * (a + b) + 1.2 * angle * error.speed());
        let (slower, apart) = (a.min(b), (spin_b - spin_a).abs());
        Self {
            flight,
            offsets: circles.map(|circle| circle.offset),
            arms: circles.map(|circle| circle.arm),
            contact_distance,
            centripetal: [a, b],
            jerk: or_none(jerk, a + b > 0.0),
            gap_jerk: or_none(gap_jerk, a + b > 0.0),
            relative_jerk: or_none(slower * apart, (slower > 0.0) & (apart > 0.0)),
            error,
        }
    }

    /// The largest distance of the bodies' centres in contact (length).
    pub(crate) fn reach(&self) -> f64 {
        (self.arms[0] + self.arms[1]) + self.contact_distance
    }

    #[inline]
    fn pose_of(&self, at: Pose) -> PairPose {
        let arms = [0, 1].map(|body| at.arm(body, self.offsets[body]));
        PairPose {
            d: at.separation + (arms[1] - arms[0]),
            arms,
            at,
        }
    }

    /// The time, not before `time`, at which bodies too far apart for a contact come within reach;
    /// `None` if they do not up to `limit`.
    #[cold]
    fn comes_within_reach(&self, separation: DVec2, time: f64, limit: f64) -> Option<f64> {
        if separation.dot(self.flight.motion.velocity) >= 0.0 {
            return None;
        }
        skim(self.flight.motion, self.reach(), limit).map(|window| window.begin.max(time))
    }

    /// A time up to which the circles are certified free, by one step from a placement; the time of
    /// the placement if they may touch there.
    #[inline]
    pub(crate) fn contact_time_lower_bounds(&self, at: &Pose) -> f64 {
        let now = self.gap(&self.pose_of(*at));
        let gap = now.value - now.error;
        if gap > 0.0 {
            at.time + safe_step(gap, now.rate - now.rate_error, &now.curvature)
        } else {
            at.time
        }
    }

    /// Advances two circles from `window.begin` until their gap is at most `nearness` times the sum
    /// of their radii, and returns that placement; `None` if they are certified free up to the end
    /// of the window. Their contents do not touch before.
    pub(crate) fn approach<R: Recorder>(
        &self,
        window: SearchWindow,
        nearness: f64,
        search: &mut Search<R>,
    ) -> Option<Pose> {
        let mut pose = self.pose(window.begin);
        let near = nearness * self.contact_distance;
        for _ in 0..search.most_steps {
            let now = self.gap(&pose);
            search.evaluations += 1;
            let gap = now.value - now.error;
            // NaN must end the loop.
            if gap <= near || gap.is_nan() {
                break;
            }
            let step = safe_step(gap, now.rate - now.rate_error, &now.curvature);
            let time = pose.at.time + step.max(self.other_step(&pose));
            search
                .recorder
                .step(Phase::Circles, pose.at.time, Some(time));
            if time > window.end {
                return None;
            }
            if time <= pose.at.time {
                break;
            }
            pose = self.pose(time);
        }
        Some(pose.at)
    }

    /// Bound on the rounding of d'': the error of the normal is at most 2 E/|d|, the arms add their
    /// share of E, and there are fewer than 12 roundings.
    #[inline]
    fn acceleration_error(&self, error: f64, inverse_distance: f64) -> f64 {
        let [a, b] = self.centripetal;
        let spin = self.error.spin();
        (a + b) * (2.0 * error * inverse_distance + 12.0 * U) + spin * spin * error
    }

    /// The step to the time at which the atom of `other` may reach the orbit of the atom of `body`.
    #[cold]
    fn orbit_step_of(&self, at: &Pose, body: usize, other: usize) -> f64 {
        let sign = if other == 1 { 1.0 } else { -1.0 };
        let arm = sign * at.arm(other, self.offsets[other]);
        let d = at.separation + arm;
        let velocity = self.flight.motion.velocity + self.flight.spin[other] * arm.perp();
        let (distance, error) = (d.length(), self.error.at(at.time));
        let gap = distance - (self.contact_distance + self.arms[body]) - error;
        if gap > 0.0 {
            let rate = d.dot(velocity) / distance - self.error.of_rate(at.time, distance);
            safe_step(gap, rate, &Curvature::at_most(self.centripetal[other]))
        } else {
            0.0
        }
    }
}

impl GapFunction for AtomPair<'_> {
    type Pose = PairPose;

    #[inline(always)]
    fn pose(&self, time: f64) -> PairPose {
        self.pose_of(self.flight.at(time))
    }

    #[inline]
    fn gap(&self, pose: &PairPose) -> Gap {
        let [spin_a, spin_b] = self.flight.spin;
        let [arm_a, arm_b] = pose.arms;
        let d = pose.d;
        let velocity =
            self.flight.motion.velocity + (spin_b * arm_b.perp() - spin_a * arm_a.perp());
        let acceleration = (spin_a * spin_a) * arm_a - (spin_b * spin_b) * arm_b;
        let distance = d.length();
        let inverse_distance = 1.0 / distance;
        let error = self.error.at(pose.at.time);
        let [constant, over_distance] = self.error.rate_terms(error);
        let rate_error = constant + over_distance * inverse_distance;
        let closing = d.dot(velocity);
        // a = n·d'' and p = n^⊥·d'
        let along_normal = d.dot(acceleration) * inverse_distance;
        let across = d.perp_dot(velocity) * inverse_distance;
        let acceleration_error = self.acceleration_error(error, inverse_distance);
        // The error of p is at most E', like that of n·d'.
        let least_across = (across.abs() - rate_error).max(0.0);
        let nearness = error * inverse_distance + 8.0 * U;
        let least_along_normal = along_normal - acceleration_error;
        let largest = self.centripetal[0] + self.centripetal[1];
        let is_resolved = MIN_ATOM_ERRORS * error <= self.contact_distance;
        Gap {
            value: distance - self.contact_distance,
            // Where the centres coincide there is no normal, and E' is infinite.
            rate: if distance > 0.0 {
                closing * inverse_distance
            } else {
                0.0
            },
            second: along_normal + across * across * inverse_distance,
            slowness: distance / ((constant * distance + over_distance) - closing),
            error,
            rate_error,
            curvature: Curvature {
                largest,
                along_normal: least_along_normal,
                jerk: self.jerk,
                of_gap: least_along_normal
                    + least_across * least_across * inverse_distance * (1.0 - nearness),
                gap_jerk: if is_resolved {
                    self.gap_jerk
                } else {
                    f64::INFINITY
                },
                acceleration,
                acceleration_error,
                relative_jerk: self.relative_jerk,
                upwards: largest + velocity.length_squared() * inverse_distance,
            },
        }
    }

    fn moved(&self, start: &PairPose, elapsed: f64) -> Option<(PairPose, f64)> {
        let swings = [0, 1].map(|body| swing(self.flight.spin[body], elapsed, start.arms[body]));
        let moved = self.flight.motion.velocity * elapsed + (swings[1] - swings[0]);
        let d = start.d + moved;
        let widened = moved.dot(2.0 * start.d + moved) / (d.length() + start.d.length());
        let arms = [start.arms[0] + swings[0], start.arms[1] + swings[1]];
        // Only the time of the placement is used, for E.
        let at = start.at.with_time(start.at.time + elapsed);
        Some((PairPose { at, d, arms }, widened))
    }

    fn top_speed(&self) -> f64 {
        self.error.speed()
    }

    fn size(&self) -> f64 {
        self.contact_distance
    }

    /// The longest step certified by replacing one of the atoms by the disc that holds its orbit,
    /// if its body turns fast.
    #[inline]
    fn other_step(&self, pose: &PairPose) -> f64 {
        let speed = self.flight.speed;
        let rim = [0, 1].map(|body| self.flight.spin[body].abs() * self.arms[body]);
        let mut step = 0.0;
        for (body, other) in [(0, 1), (1, 0)] {
            let angle = self.flight.spin[body].abs() * self.arms[other];
            if angle > FAST_ROTOR * (speed + rim[other]) {
                step = f64::max(step, self.orbit_step_of(&pose.at, body, other));
            }
        }
        step
    }

    #[inline]
    fn stays(&self, _: &PairPose, _: f64) -> bool {
        true
    }

    #[inline]
    fn within_reach(&self, time: f64, limit: f64) -> Option<f64> {
        let reach = self.reach() + rounding_within(self.flight.motion, self.reach());
        // Bodies out of reach of each other either separate for good or still approach.
        let separation = self.flight.separation(time);
        if separation.length_squared() > reach * reach {
            self.comes_within_reach(separation, time, limit)
        } else {
            Some(time)
        }
    }
}

/// ω² r, or the smallest normal float if the product underflows and is not 0, so that it stays an
/// upper bound.
#[inline]
pub(crate) fn centripetal(spin: f64, arm: f64) -> f64 {
    let value = spin * spin * arm;
    if (value < f64::MIN_POSITIVE) & (spin != 0.0) & (arm > 0.0) {
        f64::MIN_POSITIVE
    } else {
        value
    }
}

/// A bound that is a product of three velocities; infinite (no bound) where it is positive but has
/// lost digits to underflow.
#[inline]
pub(crate) fn or_none(bound: f64, is_positive: bool) -> f64 {
    if is_positive & (bound < MIN_JERK) {
        f64::INFINITY
    } else {
        bound
    }
}

/// (R(ω h) − 1) r without cancellation.
pub(crate) fn swing(spin: f64, elapsed: f64, arm: DVec2) -> DVec2 {
    let sine = |rate: f64| Orientation::default().turned(rate, elapsed).cos_sin().y;
    let half = sine(0.5 * spin);
    sine(spin) * arm.perp() - (2.0 * half * half) * arm
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search::PairOutcome;
    use carom_geometry::Atom;
    use carom_kinematics::RelativeMotion;

    #[test]
    fn the_last_correction_never_leaves_the_rounding_bound() {
        // A gap of 0.9 E between atoms that slip past each other and close barely faster than E'. A
        // correction by −g/g' would be a tenth of the time to slip by a diameter, and the contact
        // would be wrong.
        let atom = Atom::new(DVec2::ZERO, 0.5, 1.0).unwrap();
        let still = RelativeMotion::exactly(DVec2::new(0.0, 1.0), DVec2::X);
        let bound = ErrorBound::new(&still, &atom, &atom);
        for slip in [0.0, 1e-6, 1.0] {
            for closing in [2.0 * bound.of_rate(0.0, 1.0), 1e-9, 1e-3, 1.0] {
                let d = DVec2::new(0.0, 1.0 + 0.9 * bound.at(0.0));
                let motion = RelativeMotion::exactly(d, DVec2::new(slip, -closing));
                let flight = Flight::new(atom.outline(), atom.outline(), &motion);
                let pair = AtomPair::new(&flight, [(&atom).into(), (&atom).into()]);
                let mut search: Search<()> = Search::new(10.0, 10, ());
                let PairOutcome::Contact(time) =
                    pair.first_contact(0.0, [10.0; 2], &mut 0, &mut search)
                else {
                    panic!("slip {slip}, closing {closing}")
                };
                let now = pair.gap(&pair.pose(time));
                assert!(
                    now.value.abs() <= 2.0 * now.error,
                    "slip {slip}, closing {closing}: gap {}",
                    now.value
                );
            }
        }
    }
}
