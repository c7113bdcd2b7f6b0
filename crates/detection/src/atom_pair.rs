//! One atom of A and one of B, or two circles that hold atoms: their gap, and the search for its first zero.

use carom_geometry::Circle;
use carom_kinematics::HALF_ULP as U;
use glam::DVec2;

use crate::{
    ErrorBound, Window,
    flight::{Flight, Placement},
    recontact::recontact,
    safe_step::{Curvature, plain_step, safe_step},
    tolerance::{FAST_ROTOR, PLAIN_STEPS, SOON},
};

/// How the search for one atom pair ended.
#[derive(Clone, Copy)]
pub(crate) enum PairOutcome {
    Contact(f64),
    Free,
    OutOfBudget(f64),
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
    /// 1/|d|
    inverse_distance: f64,
    /// g
    pub(crate) value: f64,
    /// g'
    pub(crate) rate: f64,
    /// E
    pub(crate) error: f64,
    /// E'
    pub(crate) rate_error: f64,
}

impl<'a> AtomPair<'a> {
    #[inline]
    pub(crate) fn new(flight: &'a Flight<'a>, circles: [Circle; 2]) -> Self {
        let centripetal = [0, 1].map(|body| flight.spin[body] * flight.spin[body] * circles[body].arm);
        Self {
            flight,
            offsets: circles.map(|circle| circle.offset),
            arms: circles.map(|circle| circle.arm),
            contact_distance: circles[0].radius + circles[1].radius,
            centripetal,
            error: ErrorBound::of_circles(flight.motion, flight.speed, flight.spin, &circles),
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
        Gap {
            d,
            velocity,
            acceleration: (spin_a * spin_a) * arm_a - (spin_b * spin_b) * arm_b,
            inverse_distance,
            value: distance - self.contact_distance,
            // Where the centres coincide there is no normal, and E' is infinite.
            rate: if distance > 0.0 { d.dot(velocity) * inverse_distance } else { 0.0 },
            error,
            rate_error: constant + over_distance * inverse_distance,
        }
    }

    /// The first contact in the window, which must begin where nothing earlier can be missed.
    pub(crate) fn first_contact(
        &self,
        window: Window,
        most_steps: u32,
        evaluations: &mut u32,
    ) -> PairOutcome {
        let mut time = window.begin;
        for count in 0..most_steps.max(1) {
            let at = self.flight.at(time);
            let now = self.gap(&at);
            *evaluations += 1;
            let step = if now.value > now.error {
                let rate = now.rate - now.rate_error;
                let (step, is_root) = if count < PLAIN_STEPS {
                    (plain_step(now.value, rate, self.centripetal[0] + self.centripetal[1]), true)
                } else {
                    safe_step(now.value, rate, &self.curvature(&now))
                };
                if is_root && let Some(landing) = self.landing(&now, step, now.error) {
                    return contact_within(time + landing, window.end);
                }
                step.max(self.orbit_step(&at))
            } else if self.closes(&now) {
                return contact_within(time + self.polish(&now, now.error), window.end);
            } else if count == 0 && self.comes_back_soon(&now) {
                match recontact(self, &at, &now, window.end, evaluations) {
                    Ok(contact) => return contact_within(contact, window.end),
                    Err(step) => step,
                }
            } else {
                self.touching_step(&now)
            };
            time = (time + step).max(time.next_up());
            if time > window.end {
                return PairOutcome::Free;
            }
        }
        PairOutcome::OutOfBudget(time)
    }

    /// A time up to which the circles are certainly apart, by one step from a placement on; that time itself
    /// if they may touch there.
    #[inline]
    pub(crate) fn apart_until(&self, at: &Placement) -> f64 {
        let now = self.gap(at);
        let gap = now.value - now.error;
        if gap > 0.0 {
            at.time + safe_step(gap, now.rate - now.rate_error, &self.curvature(&now)).0
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
            let step = safe_step(gap, now.rate - now.rate_error, &self.curvature(&now)).0;
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
        let [spin_a, spin_b] = self.flight.spin.map(f64::abs);
        let [a, b] = self.centripetal;
        let largest = a + b;
        // The normal is off by 2 E/|d|, the arms by their share of E, and there are less than 12 roundings.
        let error = largest * (2.0 * now.error * now.inverse_distance + 12.0 * U)
            + (spin_a * spin_a).max(spin_b * spin_b) * now.error;
        Curvature {
            largest,
            along_normal: now.d.dot(now.acceleration) * now.inverse_distance - error,
            jerk: spin_a * a + spin_b * b,
            magnitude: now.acceleration.length() + error,
            relative_jerk: a.min(b) * (self.flight.spin[1] - self.flight.spin[0]).abs(),
        }
    }

    /// K + |d'|²/|d|: bound on the upward curvature of the gap.
    fn upper_curvature(&self, now: &Gap) -> f64 {
        (self.centripetal[0] + self.centripetal[1]) + now.velocity.length_squared() * now.inverse_distance
    }

    /// How far the contact is, if a step to a root of the minorant proves it to be within `error` of there, and the
    /// pair to be closing still.
    ///
    /// With g'' = a + (|d'|² − g'²)/|d| the contact is at the root of g + g' h + g'' h²/2, to third order. As g'' ≤ C, it is
    /// not beyond 2 h if −g' > 5/2 C h, and off by no more than C (2 h)².
    pub(crate) fn landing(&self, now: &Gap, step: f64, error: f64) -> Option<f64> {
        let bend = self.upper_curvature(now) * step;
        let lands = 4.0 * bend * step <= error && now.rate + 2.5 * bend < -now.rate_error;
        lands.then(|| {
            let across = now.velocity.length_squared() - now.rate * now.rate;
            let second = (now.d.dot(now.acceleration) + across) * now.inverse_distance;
            let square_root = (now.rate * now.rate - 2.0 * second * now.value).max(0.0).sqrt();
            2.0 * now.value / (square_root - now.rate)
        })
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
    fn touching_step(&self, now: &Gap) -> f64 {
        let fall = now.value - now.value.min(0.0) + now.error;
        // No gap closes faster than L, even where E' says nothing because the centres coincide.
        let rate = (now.rate - now.rate_error).max(-self.error.speed());
        safe_step(fall, rate, &self.curvature(now)).0
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
            safe_step(gap, rate, &Curvature::at_most(self.centripetal[other])).0
        } else {
            0.0
        }
    }
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
                let window = Window { begin: 0.0, end: 10.0 };
                let PairOutcome::Contact(time) = pair.first_contact(window, 10, &mut 0) else {
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
