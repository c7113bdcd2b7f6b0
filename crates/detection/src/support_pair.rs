//! The gap between two convex parts in flight, by their support functions.
//!
//! # Lemmas
//! In the notation of [`gap_search`](crate::gap_search) and of
//! [`FacingParts`](carom_geometry::FacingParts): d(t) leads from the centre of part A to that of
//! part B, r are the arms of these centres, n(φ) is a direction, and f(n, t) = n·d − h_A(n) −
//! h_B(−n), with h_A(n) = h_A(φ − θ_A).
//!
//! 1. **Any direction is a certificate.** f(n(t), t) ≤ g(t) for any n(t). A direction that is not
//!    the best one shortens a step and never loses a contact. Only the claim of a contact needs the
//!    maximum: f_φ²/2F ≤ E/64 is enough, since g exceeds f by that.
//! 2. **Derivatives.** Let n turn at a constant rate Ω. Then f' = n·d' + ω_A h_A' + ω_B h_B' + Ω
//!    f_φ and f'' = a + 2 Ω p − Ω² F, with a = n·d'' − ω_A² h_A'' − ω_B² h_B'' and p = n^⊥·d' + ω_A
//!    h_A'' + ω_B h_B''. *Proof.* d/dt h_A(φ − θ_A) = (Ω − ω_A) h_A'; the terms are sorted by
//!    powers of Ω.
//! 3. **Bounds for all times.** At Ω = 0: f'' ≥ −K₀ with K₀ = K + ω_A² M_A + ω_B² M_B and |f'''| ≤
//!    K₃ + |ω_A|³ H_A + |ω_B|³ H_B, where M bounds h'' and H bounds |h'''|. At any Ω, while |X + V
//!    t| ≤ ϱ: |f'''| ≤ K₃ + 3 |Ω| K + 3 Ω² L + |Ω|³ (ϱ + r_A + r_B) + |Ω − ω_A|³ H_A + |Ω − ω_B|³
//!    H_B, where K, K₃ and L are those of the centres. *Proof.* Lemma 2, differentiated once more.
//! 4. **The best rate** is Ω = p/F: then f'' = a + p²/F = g''. Both this Ω, as the bound `of_gap`,
//!    and Ω = 0, as the bounds `largest` and `along_normal`, are used; f' at the one exceeds f' at
//!    the other by Ω f_φ, which is a part of E'.
//! 5. **Upper bound.** With f_φ' = p − Ω F and |f_φ''| ≤ K + 2 |Ω| L + Ω² (ϱ + r_A + r_B) + (Ω −
//!    ω_A)² H_A + (Ω − ω_B)² H_B, f_φ is known at later times to within a bound s. As long as F is
//!    at least half of its value now, g − f ≤ s²/F. Where that is at most E/64, Lemmas 6 and 7 of
//!    `gap_search` hold.
//! 6. **Orbits.** A part stays within its circle about the centre of its body. The other part may
//!    be stepped against that circle.

use std::cell::Cell;

use carom_geometry::{Circle, Ellipse, FacingParts, FacingTangents, Support, turned};
use carom_kinematics::HALF_ULP as U;
use glam::DVec2;

use crate::{
    ErrorBound,
    flight::{Flight, Pose},
    gap_search::{Gap, GapFunction},
    safe_step::{Curvature, safe_step},
    skim,
    skimming::rounding_within,
    tolerance::FAST_ROTOR,
};

/// A convex part of each body.
pub(crate) struct SupportPair<'a, A, B> {
    flight: &'a Flight<'a>,
    a: &'a A,
    b: &'a B,
    offsets: [DVec2; 2],
    /// r
    arms: [f64; 2],
    /// The largest distance of a point of each part from the centre of its body.
    reaches: [f64; 2],
    /// The bounds on h'' and |h'''|.
    bends: [f64; 2],
    thirds: [f64; 2],
    /// K₀
    largest: f64,
    /// K₃ + |ω_A|³ H_A + |ω_B|³ H_B
    jerk: f64,
    error: ErrorBound,
    /// The direction of the last pose, with its time and the rate at which it turns.
    last: Cell<Option<LastDirection>>,
}

/// A direction in which the parts were nearest.
#[derive(Clone, Copy)]
struct LastDirection {
    time: f64,
    normal: DVec2,
    /// Ω
    turn: f64,
}

/// How much faster than a fast rotor a body is before the orbit of its part is tested. Smaller: the
/// test costs more than the steps that it saves. Larger: more steps for fast rotors.
pub(crate) const MIN_ORBIT: f64 = 2.0;

/// The largest turn of a direction between two poses that is extrapolated (radians).
const MAX_TURN: f64 = 0.5;

/// The gap over the size of the bodies above which a search does without the best direction.
/// Smaller: directions are found better than needed. Larger: searches do not land.
const FAR: f64 = 1e-4;

/// The parts at one time, and the tangents at which they are nearest.
#[derive(Clone, Copy)]
pub(crate) struct SupportPose {
    at: Pose,
    arms: [DVec2; 2],
    pub(crate) facing: FacingTangents,
}

impl<'a, A: Support, B: Support> SupportPair<'a, A, B> {
    /// The pair of these parts, with their centres at these offsets from the centres of mass.
    pub(crate) fn new(flight: &'a Flight<'a>, parts: (&'a A, &'a B), offsets: [DVec2; 2]) -> Self {
        let (a, b) = parts;
        let sizes = [a.reach(), b.reach()];
        let arms = offsets.map(DVec2::length);
        let reaches = [0, 1].map(|body| (arms[body] + sizes[body]) * (1.0 + 4.0 * f64::EPSILON));
        let circles = [0, 1].map(|body| Circle {
            offset: offsets[body],
            // Each point turns about the centre of mass; twice the size covers the roundings of h.
            arm: arms[body] + 2.0 * sizes[body],
            radius: 0.0,
        });
        let spins = flight.spin.map(f64::abs);
        let (bends, thirds) = ([a.max_bend(), b.max_bend()], [a.max_third(), b.max_third()]);
        let sum = |of: &dyn Fn(usize) -> f64| of(0) + of(1);
        Self {
            flight,
            a,
            b,
            offsets,
            arms,
            reaches,
            bends,
            thirds,
            largest: sum(&|n| spins[n] * spins[n] * (arms[n] + bends[n])),
            jerk: sum(&|n| spins[n] * spins[n] * spins[n] * (arms[n] + thirds[n])),
            error: ErrorBound::of_circles(flight.motion, flight.speed, flight.spin, &circles),
            last: Cell::new(None),
        }
    }

    fn reach(&self) -> f64 {
        self.reaches[0] + self.reaches[1]
    }

    fn facing(&self, at: &Pose, d: DVec2) -> FacingTangents {
        let parts = FacingParts {
            a: self.a,
            b: self.b,
            rotations: [0, 1].map(|body| at.arm(body, DVec2::X)),
            d,
        };
        let start = match self.last.get() {
            Some(last) if (last.turn * (at.time - last.time)).abs() < MAX_TURN => {
                turned(last.normal, last.turn * (at.time - last.time))
            }
            _ => parts.towards(),
        };
        parts.farthest_beyond(start, self.error.at(at.time), FAR * self.reach())
    }

    /// Bounds on the errors of h'' and of the rotated arms, by their sums over the bodies: of a and
    /// of p (see Lemma 2) and of F.
    fn second_errors(&self, time: f64, error: f64) -> [f64; 3] {
        let mut errors = [0.0; 3];
        for body in 0..2 {
            let spin = self.flight.spin[body].abs();
            let angle = U * (16.0 + 4.0 * spin * time) + self.flight.motion.orientation_error[body];
            let size = self.reaches[body] + self.bends[body];
            let bend = 32.0 * U * size + self.thirds[body] * angle;
            errors[0] += spin * spin * (bend + 24.0 * U * self.arms[body]);
            errors[1] += spin * bend;
            errors[2] += bend;
        }
        let spin = self.error.spin();
        let rounding = 12.0 * U * self.error.speed();
        [
            errors[0] + spin * spin * error,
            errors[1] + spin * error + rounding + self.flight.motion.velocity_error,
            errors[2] + 2.0 * error,
        ]
    }

    /// d'
    fn velocity(&self, pose: &SupportPose) -> DVec2 {
        let spins = self.flight.spin;
        self.flight.motion.velocity
            + (spins[1] * pose.arms[1].perp() - spins[0] * pose.arms[0].perp())
    }

    /// p and the best rate Ω (Lemmas 2 and 4); 0 for overlapping parts without a best direction.
    fn best_turn(&self, pose: &SupportPose) -> (f64, f64) {
        let spins = self.flight.spin;
        let points = &pose.facing.points;
        let tangent = pose.facing.normal.perp();
        let p = tangent.dot(self.velocity(pose))
            + (spins[0] * points[0].bend() + spins[1] * points[1].bend());
        let stiffness = pose.facing.stiffness();
        let turn = if stiffness > 0.0 { p / stiffness } else { 0.0 };
        (p, turn)
    }

    /// The step against the circle in which a part of `body` stays (Lemma 6).
    #[cold]
    fn orbit_step_of(&self, pose: &SupportPose, body: usize) -> f64 {
        let (other, sign) = (1 - body, if body == 0 { 1.0 } else { -1.0 });
        let rotation = pose.at.arm(other, DVec2::X);
        // From the centre of mass of `body` to the part of the other.
        let arm = pose.arms[other];
        let d = sign * pose.at.separation + arm;
        let circle = Ellipse::round(self.reaches[body]);
        let error = self.error.at(pose.at.time);
        let spin = self.flight.spin[other];
        let (rotations, normal_gap) = ([DVec2::X, rotation], |found: FacingTangents| {
            let velocity = sign * self.flight.motion.velocity + spin * arm.perp();
            let rate = found.normal.dot(velocity) + spin * found.points[1].slope;
            (found.gap - error, rate)
        });
        let (gap, rate) = if other == 1 {
            let (a, b) = (&circle, self.b);
            let parts = FacingParts { a, b, rotations, d };
            normal_gap(parts.across(parts.towards()))
        } else {
            let (a, b) = (&circle, self.a);
            let parts = FacingParts { a, b, rotations, d };
            normal_gap(parts.across(parts.towards()))
        };
        if gap > 0.0 {
            let rate_error = self.error.rate_terms(error)[0];
            let most = spin * spin * (self.arms[other] + self.bends[other]);
            safe_step(gap, rate - rate_error, &Curvature::at_most(most))
        } else {
            0.0
        }
    }
}

impl<A: Support, B: Support> GapFunction for SupportPair<'_, A, B> {
    type Pose = SupportPose;

    fn pose(&self, time: f64) -> SupportPose {
        let at = self.flight.at(time);
        let arms = [0, 1].map(|body| at.arm(body, self.offsets[body]));
        let d = at.separation + (arms[1] - arms[0]);
        SupportPose {
            at,
            arms,
            facing: self.facing(&at, d),
        }
    }

    fn gap(&self, pose: &SupportPose) -> Gap {
        let spins = self.flight.spin;
        let FacingTangents {
            normal,
            gap,
            slope,
            points,
        } = pose.facing;
        let velocity = self.velocity(pose);
        let acceleration =
            (spins[0] * spins[0]) * pose.arms[0] - (spins[1] * spins[1]) * pose.arms[1];
        let sum = |of: &dyn Fn(usize) -> f64| of(0) + of(1);
        let bends = points.map(|point| point.bend());
        let error = self.error.at(pose.at.time);
        let [a_error, p_error, stiffness_error] = self.second_errors(pose.at.time, error);
        let a = normal.dot(acceleration) - sum(&|n| spins[n] * spins[n] * bends[n]);
        let stiffness = pose.facing.stiffness();
        let (p, turn) = self.best_turn(pose);
        self.last.set(Some(LastDirection {
            time: pose.at.time,
            normal,
            turn,
        }));
        let fast = turn.abs();
        let second = a + turn * (2.0 * p - turn * stiffness);
        let second_error = a_error
            + fast * (2.0 * p_error + fast * stiffness_error)
            + 8.0 * U * (a.abs() + fast * p.abs());
        let rate = normal.dot(velocity) + sum(&|n| spins[n] * points[n].slope) + turn * slope;
        let rate_error = self.error.rate_terms(error)[0]
            + fast * (slope.abs() + 4.0 * error)
            + sum(&|n| spins[n].abs()) * error;
        let [k, k3] = [2, 3].map(|power| sum(&|n| spins[n].abs().powi(power) * self.arms[n]));
        let distance = self.reach() + (self.arms[0] + self.arms[1]) + error;
        // |h''| is at most M, or the size of the part where R is small.
        let most_bend = |n: usize| self.bends[n].max(self.reaches[n]);
        let upwards = k
            + sum(&|n| spins[n] * spins[n] * most_bend(n))
            + 2.0 * fast * (self.error.speed() + sum(&|n| spins[n].abs() * most_bend(n)));
        let gap_jerk = k3
            + fast * (3.0 * k + fast * (3.0 * self.error.speed() + fast * distance))
            + sum(&|n| (turn - spins[n]).abs().powi(3) * self.thirds[n]);
        Gap {
            value: gap,
            rate,
            second,
            slowness: 1.0 / (rate_error - rate),
            error,
            rate_error,
            curvature: Curvature {
                along_normal: a - a_error,
                jerk: self.jerk,
                of_gap: second - second_error,
                gap_jerk,
                upwards,
                ..Curvature::at_most(self.largest)
            },
        }
    }

    fn top_speed(&self) -> f64 {
        self.error.speed()
    }

    fn size(&self) -> f64 {
        self.reach()
    }

    fn other_step(&self, pose: &SupportPose) -> f64 {
        let mut longest: f64 = 0.0;
        for body in 0..2 {
            let spin = self.flight.spin[body].abs();
            if spin * self.reaches[body] > MIN_ORBIT * FAST_ROTOR * self.flight.speed {
                longest = longest.max(self.orbit_step_of(pose, body));
            }
        }
        longest
    }

    /// Whether f of the direction that turns is also an upper bound on the gap, to within E/64
    /// (Lemma 5).
    fn stays(&self, pose: &SupportPose, duration: f64) -> bool {
        let stiffness = pose.facing.stiffness();
        let error = self.error.at(pose.at.time);
        let [_, p_error, stiffness_error] = self.second_errors(pose.at.time, error);
        if stiffness <= 4.0 * stiffness_error {
            return false;
        }
        let (p, turn) = self.best_turn(pose);
        let fast = turn.abs();
        let sum = |of: &dyn Fn(usize) -> f64| of(0) + of(1);
        let apart = |n: usize| (turn - self.flight.spin[n]).abs();
        let speed = self.error.speed();
        let distance = self.reach() + (self.arms[0] + self.arms[1]) + error;
        let k = sum(&|n| self.flight.spin[n].powi(2) * self.arms[n]);
        let bend = k
            + fast * (2.0 * speed + fast * distance)
            + sum(&|n| apart(n) * apart(n) * self.thirds[n]);
        let softens = speed + sum(&|n| apart(n) * (self.thirds[n] + self.reaches[n]));
        let drift = p_error + fast * stiffness_error + (p - turn * stiffness).abs();
        let slope = pose.facing.slope.abs() + duration * (drift + 0.5 * bend * duration);
        2.0 * duration * softens <= stiffness && 64.0 * slope * slope <= error * stiffness
    }

    fn within_reach(&self, time: f64, limit: f64) -> Option<f64> {
        let separation = self.flight.separation(time);
        let reach = self.reach() + rounding_within(self.flight.motion, self.reach());
        if separation.length_squared() <= reach * reach {
            return Some(time);
        }
        if separation.dot(self.flight.motion.velocity) >= 0.0 {
            return None;
        }
        skim(self.flight.motion, self.reach(), limit).map(|window| window.begin.max(time))
    }
}
