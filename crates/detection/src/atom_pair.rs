//! One atom of A and one of B, or two circles that hold atoms: their gap, and the search for its first zero.

use carom_geometry::Circle;
use carom_kinematics::HALF_ULP as U;
use glam::DVec2;

use crate::{
    ErrorBound, Window,
    flight::{Flight, Placement},
    recontact::recontact,
    safe_step::{Curvature, safe_step, short_step},
    search::Search,
    skim,
    skimming::rounding_within,
    tolerance::{FAST_ROTOR, LEAST_JERK, SHORT_STEPS, SOON},
};

/// How the search for one atom pair ended.
#[derive(Clone, Copy)]
pub(crate) enum PairOutcome {
    Contact(f64),
    Free,
    OutOfBudget(f64),
    /// Apart up to a time beyond which another pair is to be looked at first.
    Paused(f64),
}

/// Two circles in flight, each fixed in its body.
pub(crate) struct AtomPair<'a> {
    pub(crate) flight: &'a Flight<'a>,
    pub(crate) offsets: [DVec2; 2],
    arms: [f64; 2],
    /// Sum of the radii, s.
    contact_distance: f64,
    /// ω_A² r_A and ω_B² r_B, whose sum is K, the bound on |d''| for all time.
    centripetal: [f64; 2],
    /// |ω_A|³ r_A + |ω_B|³ r_B = K₃
    jerk: f64,
    /// C₃
    gap_jerk: f64,
    /// J
    relative_jerk: f64,
    pub(crate) error: ErrorBound,
}

/// The gap at one moment.
pub(crate) struct Gap {
    /// d
    pub(crate) d: DVec2,
    /// d'
    velocity: DVec2,
    /// d''
    acceleration: DVec2,
    /// a = n·d''
    along_normal: f64,
    /// p = n^⊥·d'
    across: f64,
    /// 1/|d|
    inverse_distance: f64,
    /// g
    pub(crate) value: f64,
    /// g'
    pub(crate) rate: f64,
    /// 1/|g'| for a gap that falls slower than it seems to by E', negative for one that may widen.
    slowness: f64,
    /// E
    pub(crate) error: f64,
    /// E'
    pub(crate) rate_error: f64,
}

impl<'a> AtomPair<'a> {
    #[inline]
    pub(crate) fn new(flight: &'a Flight<'a>, circles: [Circle; 2]) -> Self {
        let [spin_a, spin_b] = flight.spin;
        let (a, b) = (spin_a * spin_a * circles[0].arm, spin_b * spin_b * circles[1].arm);
        let error = ErrorBound::of_circles(flight.motion, flight.speed, flight.spin, &circles);
        let contact_distance = circles[0].radius + circles[1].radius;
        let jerk = spin_a.abs() * a + spin_b.abs() * b;
        let angle = error.speed() / contact_distance;
        let gap_jerk = jerk + angle * (3.0 * (a + b) + 1.2 * angle * error.speed());
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

    /// The farthest that the bodies' centres can be apart in contact (length).
    pub(crate) fn reach(&self) -> f64 {
        (self.arms[0] + self.arms[1]) + self.contact_distance
    }

    #[inline]
    pub(crate) fn gap(&self, at: &Placement) -> Gap {
        let [arm_a, arm_b] = [0, 1].map(|body| at.arm(body, self.offsets[body]));
        let d = at.separation + (arm_b - arm_a);
        self.gap_from(d, [arm_a, arm_b], at.time)
    }

    #[inline]
    pub(crate) fn gap_from(&self, d: DVec2, [arm_a, arm_b]: [DVec2; 2], time: f64) -> Gap {
        let [spin_a, spin_b] = self.flight.spin;
        let velocity = self.flight.motion.velocity + (spin_b * arm_b.perp() - spin_a * arm_a.perp());
        let distance = d.length();
        let inverse_distance = 1.0 / distance;
        let error = self.error.at(time);
        let [constant, over_distance] = self.error.rate_terms(error);
        let closing = d.dot(velocity);
        let acceleration = (spin_a * spin_a) * arm_a - (spin_b * spin_b) * arm_b;
        Gap {
            d,
            velocity,
            acceleration,
            along_normal: d.dot(acceleration) * inverse_distance,
            across: d.perp_dot(velocity) * inverse_distance,
            inverse_distance,
            value: distance - self.contact_distance,
            // Where the centres coincide there is no normal, and E' is infinite.
            rate: if distance > 0.0 { closing * inverse_distance } else { 0.0 },
            slowness: distance / ((constant * distance + over_distance) - closing),
            error,
            rate_error: constant + over_distance * inverse_distance,
        }
    }

    /// The first contact after `begin`, before which there must be none, and up to `limit`; paused beyond `pause`. `steps`
    /// counts the steps of the pair, over all pauses.
    #[inline]
    pub(crate) fn first_contact(
        &self,
        begin: f64,
        [pause, limit]: [f64; 2],
        steps: &mut u32,
        search: &mut Search,
    ) -> PairOutcome {
        let reach = self.reach() + rounding_within(self.flight.motion, self.reach());
        let mut time = begin;
        loop {
            // Out of each other's reach, they part for good or are only coming.
            let separation = self.flight.separation(time);
            if separation.length_squared() > reach * reach {
                match self.comes_within_reach(separation, time, limit) {
                    Some(entry) => time = entry,
                    None => return PairOutcome::Free,
                }
            }
            let at = self.flight.at(time);
            let now = self.gap(&at);
            search.evaluations += 1;
            *steps += 1;
            let curvature = self.curvature(&now);
            let step = if now.value > now.error {
                if let Some(landing) = now.landing(&curvature, now.error) {
                    return contact_within(time + landing, limit);
                }
                let rate = now.rate - now.rate_error;
                let step = if *steps <= SHORT_STEPS {
                    short_step(now.value, rate, now.slowness, &curvature)
                } else {
                    safe_step(now.value, rate, &curvature)
                };
                let orbit_step = self.orbit_step(&at);
                if orbit_step > step { orbit_step } else { step }
            } else if self.closes(&now) {
                return contact_within(time + self.polish(&now, now.error), limit);
            } else if *steps == 1 && self.comes_back_soon(&now) {
                match recontact(self, &at, &now, limit, &mut search.evaluations) {
                    Ok(contact) => return contact_within(contact, limit),
                    Err(step) => step,
                }
            } else {
                self.touching_step(&now, &curvature)
            };
            let next = time + step;
            time = if next > time { next } else { time.next_up() };
            if time > limit {
                return PairOutcome::Free;
            }
            if *steps >= search.most_steps {
                return PairOutcome::OutOfBudget(time);
            }
            // A falling gap is followed to its end: that is mostly the answer.
            if time > pause && now.rate >= 0.0 {
                return PairOutcome::Paused(time);
            }
        }
    }

    /// When bodies whose centres are too far apart for a contact come near enough, if they do; no sooner than `time`.
    #[cold]
    fn comes_within_reach(&self, separation: DVec2, time: f64, limit: f64) -> Option<f64> {
        if separation.dot(self.flight.motion.velocity) >= 0.0 {
            return None;
        }
        skim(self.flight.motion, self.reach(), limit).map(|window| window.begin.max(time))
    }

    /// A time up to which the circles are certainly apart, by one step from a placement on; that time itself
    /// if they may touch there.
    #[inline]
    pub(crate) fn apart_until(&self, at: &Placement) -> f64 {
        let now = self.gap(at);
        let gap = now.value - now.error;
        if gap > 0.0 {
            at.time + safe_step(gap, now.rate - now.rate_error, &self.curvature(&now))
        } else {
            at.time
        }
    }

    /// Follows two circles from `window.begin` until they are within `nearness` of their radii or until they are
    /// apart up to the end of the window, whichever is first. Nothing that they hold touches before.
    pub(crate) fn approach(
        &self,
        window: Window,
        nearness: f64,
        most_steps: u32,
        evaluations: &mut u32,
    ) -> Option<Placement> {
        let mut at = self.flight.at(window.begin);
        let near = nearness * self.contact_distance;
        for _ in 0..most_steps {
            let now = self.gap(&at);
            *evaluations += 1;
            let gap = now.value - now.error;
            // What is no number must end the walk.
            if gap <= near || gap.is_nan() {
                break;
            }
            let step = safe_step(gap, now.rate - now.rate_error, &self.curvature(&now));
            let time = at.time + step.max(self.orbit_step(&at));
            if time > window.end {
                return None;
            }
            if time <= at.time {
                break;
            }
            at = self.flight.at(time);
        }
        Some(at)
    }

    /// How fast the gap can bend downwards from now on.
    #[inline]
    pub(crate) fn curvature(&self, now: &Gap) -> Curvature {
        let [a, b] = self.centripetal;
        let largest = a + b;
        let error = self.acceleration_error(now);
        // p = n^⊥·d' is off by no more than E', like n·d'.
        let across = (now.across.abs() - now.rate_error).max(0.0);
        let nearness = now.error * now.inverse_distance + 8.0 * U;
        let along_normal = now.along_normal - error;
        Curvature {
            largest,
            along_normal,
            jerk: self.jerk,
            of_gap: along_normal + across * across * now.inverse_distance * (1.0 - nearness),
            gap_jerk: self.gap_jerk,
            acceleration_squared: now.acceleration.length_squared(),
            acceleration_error: error,
            relative_jerk: self.relative_jerk,
        }
    }

    /// Bound on the rounding of d'': the normal is off by 2 E/|d|, the arms by their share of E, and there are less than
    /// 12 roundings.
    #[inline]
    fn acceleration_error(&self, now: &Gap) -> f64 {
        let [a, b] = self.centripetal;
        let spin = self.error.spin();
        (a + b) * (2.0 * now.error * now.inverse_distance + 12.0 * U) + spin * spin * now.error
    }

    /// K + |d'|²/|d|: bound on the upward curvature of the gap.
    fn upper_curvature(&self, now: &Gap) -> f64 {
        (self.centripetal[0] + self.centripetal[1]) + now.velocity.length_squared() * now.inverse_distance
    }

    /// Whether a pair within E of contact, or overlapping, is in contact rather than leaving or touching.
    fn closes(&self, now: &Gap) -> bool {
        let resolved = self.flight.motion.velocity_error;
        now.rate < -if now.value < -now.error { resolved } else { now.rate_error }
    }

    /// The last Newton correction towards g = 0, where it provably lands within `error` of it.
    pub(crate) fn polish(&self, now: &Gap, error: f64) -> f64 {
        let correction = -now.value / now.rate;
        let safe = now.value > 0.0 && self.upper_curvature(now) * correction * correction <= error;
        if safe { correction } else { 0.0 }
    }

    /// Step of a pair that leaves or touches: to where the bound from below reaches min(g, 0) − E.
    fn touching_step(&self, now: &Gap, curvature: &Curvature) -> f64 {
        let fall = now.value - now.value.min(0.0) + now.error;
        // No gap closes faster than L, even where E' says nothing because the centres coincide.
        let rate = (now.rate - now.rate_error).max(-self.error.speed());
        safe_step(fall, rate, curvature)
    }

    /// Whether a pair that parts may be back before it has gone far enough for the plain gap to tell.
    fn comes_back_soon(&self, now: &Gap) -> bool {
        let away = now.rate - now.rate_error;
        let curvature = self.centripetal[0] + self.centripetal[1];
        now.value >= -now.error
            && away > 0.0
            && 2.0 * away * self.error.speed() < SOON * curvature * self.contact_distance
    }

    /// The largest step certified by taking one of the atoms for the whole circle that it runs on, if its body
    /// turns fast.
    #[inline]
    fn orbit_step(&self, at: &Placement) -> f64 {
        let speed = self.flight.speed;
        let rim = [0, 1].map(|body| self.flight.spin[body].abs() * self.arms[body]);
        let mut step = 0.0;
        for (body, other) in [(0, 1), (1, 0)] {
            let angle = self.flight.spin[body].abs() * self.arms[other];
            if angle > FAST_ROTOR * (speed + rim[other]) {
                step = f64::max(step, self.orbit_step_of(at, body, other));
            }
        }
        step
    }

    /// The step to where the atom of `other` may reach the orbit of the atom of `body`.
    #[cold]
    fn orbit_step_of(&self, at: &Placement, body: usize, other: usize) -> f64 {
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

impl Gap {
    /// How far the contact is, if that can be told to within `error` from here, and the pair is closing still when it
    /// comes: at the root of g + g' h + g'' h²/2.
    #[inline]
    pub(crate) fn landing(&self, curvature: &Curvature, error: f64) -> Option<f64> {
        // Mostly it is far too far, which this tells without a square root.
        let straight = self.value * self.slowness;
        if curvature.gap_jerk * straight * straight * straight > error {
            return None;
        }
        let second = self.along_normal + self.across * self.across * self.inverse_distance;
        let slope = (self.rate * self.rate - 2.0 * second * self.value).sqrt();
        let landing = 2.0 * self.value / (slope - self.rate);
        let third = curvature.gap_jerk * landing * landing;
        // E' and h E''; g'' lies as far above its lower bound as its upper bound does above it.
        let rate_error = self.rate_error + 2.0 * (second - curvature.of_gap) * landing;
        let lands = 4.0 * landing * third.max(rate_error) <= error
            && self.rate < 0.0
            && slope > 2.0 * rate_error + third;
        lands.then_some(landing)
    }
}

/// A bound that is a product of three velocities, or no bound (infinite) where that is not 0 but too small for a number.
#[inline]
fn or_none(bound: f64, is_positive: bool) -> f64 {
    if is_positive & (bound < LEAST_JERK) { f64::INFINITY } else { bound }
}

fn contact_within(time: f64, limit: f64) -> PairOutcome {
    if time <= limit { PairOutcome::Contact(time) } else { PairOutcome::Free }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_geometry::Atom;
    use carom_kinematics::RelativeMotion;

    #[test]
    fn the_last_correction_never_leaves_the_rounding_bound() {
        // Nine tenths of E apart, slipping past each other, and closing barely faster than E': −g/g' would be a
        // tenth of the time to slip by a diameter, and put the contact where there is none.
        let atom = Atom::new(DVec2::ZERO, 0.5, 1.0).unwrap();
        let still = RelativeMotion::exactly(DVec2::new(0.0, 1.0), DVec2::X);
        let bound = ErrorBound::new(&still, &atom, &atom);
        for slip in [0.0, 1e-6, 1.0] {
            for closing in [2.0 * bound.of_rate(0.0, 1.0), 1e-9, 1e-3, 1.0] {
                let d = DVec2::new(0.0, 1.0 + 0.9 * bound.at(0.0));
                let motion = RelativeMotion::exactly(d, DVec2::new(slip, -closing));
                let flight = Flight::new(atom.outline(), atom.outline(), &motion);
                let pair = AtomPair::new(&flight, [(&atom).into(), (&atom).into()]);
                let mut search = Search::new(10.0, 10);
                let PairOutcome::Contact(time) = pair.first_contact(0.0, [10.0; 2], &mut 0, &mut search)
                else {
                    panic!("slip {slip}, closing {closing}")
                };
                let now = pair.gap(&flight.at(time));
                assert!(
                    now.value.abs() <= 2.0 * now.error,
                    "slip {slip}, closing {closing}: gap {}",
                    now.value
                );
            }
        }
    }
}
