//! A tether: two points, one of each of two bodies, whose distance stays between two bounds; and
//! the certified search for the first time at which it reaches one.
//!
//! The shorter bound is searched like the contact of two atoms about the points. The longer one is
//! a contact with the sign turned: the points fly freely inside, and meet where they are farthest.
//!
//! # Lemmas
//! In the notation of [`gap_search`](crate::gap_search): d = X + V t + r_B − r_A leads from the
//! point of A to that of B, whose arms r turn with their bodies. ℓ is the longer bound, and S = ℓ
//! (1 + 2⁻¹⁰).
//!
//! 1. **Gap.** The distance |d| has no derivative at 0; its square has. g = (ℓ² − |d|²)/2ℓ has the
//!    zero of ℓ − |d|, and for |d| ≤ ℓ it is between (ℓ − |d|)/2 and ℓ − |d|.
//! 2. **Derivatives.** g' = −d·d'/ℓ, g'' = −(|d'|² + d·d'')/ℓ and g''' = −(3 d'·d'' + d·d''')/ℓ.
//! 3. **Bounds for all times.** While |d| ≤ S, which holds up to the event and beyond it by more
//!    than rounding, |g''| ≤ (L² + S K)/ℓ and |g'''| ≤ (3 L K + S K₃)/ℓ. For points at the centres
//!    of mass the event is that of [`taut_in`], in closed form.
//! 4. **Fast rotors.** Each point stays within its arm of the centre of mass: d does not reach ℓ
//!    before the distance of the centres reaches ℓ − r_A − r_B, if this is positive.
//! 5. **Growth without cancellation.** g(h) − g(0) = −δ·(2 d(0) + δ)/2ℓ, with δ of Lemma 10 of
//!    `gap_search`.
//! 6. **Rounding.** With the bound E of the vector d ([`ErrorBound`], Lemma 3) and 8 u ℓ for the at
//!    most 7 roundings of g, the error of g = (ℓ − |d|)(ℓ + |d|)/2ℓ is at most (E + 8 u ℓ) max(1,
//!    (ℓ + |d|)/2ℓ). That of d' is at most e = 12 u L + |ω| E + δV, of d'' at most 12 u K + ω² E,
//!    with the larger |ω|. Hence those of g' and g'' are at most (E L + S e)/ℓ and (2 L e + S (12 u
//!    K + ω² E) + K E)/ℓ + 8 u (L² + S K)/ℓ.
//!
//! Lemmas 8 and 9 of `gap_search` then hold with the sign turned. An event has |g| ≤ 2 E. If the
//! points approach at 2 E' or faster after each event, the tether is never longer than ℓ + 5/4 E,
//! however many events it has.

use carom_geometry::{Circle, check_length, check_positive};
use carom_kinematics::{HALF_ULP as U, RelativeMotion};
use glam::DVec2;
use thiserror::Error;

use crate::{
    Contact, ErrorBound, Outcome,
    atom_pair::{AtomPair, centripetal, or_none, swing},
    disc::disc_contact,
    error_bound::one_norm,
    flight::{Flight, Pose},
    gap_search::{Gap, GapFunction},
    range::{Unit, faster, unit_of_radii},
    safe_step::{Curvature, safe_step},
    search::Search,
    tolerance::{FAST_ROTOR, MAX_STEPS, RESTING_DEPTH},
};

/// S/ℓ
const ROOM: f64 = 1.0 + 1.0 / (1 << 10) as f64;

/// Two points, one of each of two bodies, whose distance stays between two bounds.
///
/// ```
/// use carom_detection::{Contact, Tether, TetherBound};
/// use carom_kinematics::RelativeMotion;
/// use glam::DVec2;
///
/// // The centres of two bodies, 0.8 apart, fly apart at the speed 2 on a tether of length 1.
/// let tether = Tether::new([DVec2::ZERO; 2], [0.5, 1.0])?;
/// let apart = RelativeMotion::exactly(DVec2::new(0.8, 0.0), DVec2::new(2.0, 0.0));
/// let Contact { time, touch } = tether.first_event(&apart, 1.0).contact().unwrap();
/// assert!(touch == TetherBound::Longest && (time - 0.1).abs() < 1e-15);
/// // The other way, they come as near as it allows.
/// let together = RelativeMotion::exactly(DVec2::new(0.8, 0.0), DVec2::new(-3.0, 0.0));
/// let Contact { time, touch } = tether.first_event(&together, 1.0).contact().unwrap();
/// assert!(touch == TetherBound::Shortest && (time - 0.1).abs() < 1e-15);
/// # Ok::<(), carom_detection::TetherError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[doc(alias = "bond")]
#[doc(alias = "hinge")]
pub struct Tether {
    circles: [Circle; 2],
    shortest: f64,
    longest: f64,
}

/// A bound on the length of a tether.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum TetherBound {
    /// The least length.
    Shortest,
    /// The greatest length: the tether is taut.
    Longest,
}

/// A tether that cannot be.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum TetherError {
    /// A bound on the length.
    #[error("`max` must be from 1e-60 to 1e60 (length), but is {0:?}")]
    Longest(f64),
    /// The lower bound.
    #[error("`min` must be at least 0 and less than `max` ({longest:?}), but is {shortest:?}")]
    Shortest {
        /// The lower bound (length).
        shortest: f64,
        /// The upper bound (length).
        longest: f64,
    },
    /// A point.
    #[error("a point of a tether must have coordinates from -1e60 to 1e60, but is {0:?}")]
    Point([f64; 2]),
}

impl Tether {
    /// A tether of points in the frames of the two bodies, from the centres of mass (length), with
    /// a shortest and a longest length. A shortest length of 0 is no bound.
    ///
    /// # Errors
    /// [`TetherError`] for a number out of range.
    #[inline]
    pub fn new(points: [DVec2; 2], [shortest, longest]: [f64; 2]) -> Result<Self, TetherError> {
        if check_positive("max", longest).is_err() {
            return Err(TetherError::Longest(longest));
        }
        if !(0.0..longest).contains(&shortest)
            || (shortest > 0.0 && check_positive("min", shortest).is_err())
        {
            return Err(TetherError::Shortest { shortest, longest });
        }
        for point in points {
            let is_in_range = |x: f64| check_length("point", x).is_ok();
            if !(is_in_range(point.x) && is_in_range(point.y)) {
                return Err(TetherError::Point(point.to_array()));
            }
        }
        let circles = points.map(|offset| Circle {
            offset,
            arm: offset.length(),
            radius: 0.5 * shortest,
        });
        Ok(Self {
            circles,
            shortest,
            longest,
        })
    }

    /// The points in the frames of the two bodies, from their centres of mass (length).
    #[inline]
    pub fn points(&self) -> [DVec2; 2] {
        self.circles.map(|circle| circle.offset)
    }

    /// The shortest and the longest length; the shortest is 0 where there is no such bound.
    #[inline]
    pub fn bounds(&self) -> [f64; 2] {
        [self.shortest, self.longest]
    }

    /// The largest distance of the centres of mass (length).
    pub fn reach(&self) -> f64 {
        self.longest + (self.circles[0].arm + self.circles[1].arm)
    }

    /// The same tether with the two bodies exchanged.
    #[must_use]
    pub fn exchanged(&self) -> Self {
        let [a, b] = self.circles;
        Self {
            circles: [b, a],
            ..*self
        }
    }

    /// The first time from now to `horizon` at which the tether reaches a bound. One that has
    /// reached it, or is beyond it, reaches it now if it goes on in that direction, and not while
    /// it returns.
    pub fn first_event(&self, motion: &RelativeMotion, horizon: f64) -> Outcome<TetherBound> {
        let arms = self.circles.map(|circle| circle.arm);
        match unit_of_radii(arms, motion, horizon) {
            Unit::Ordinary => self.search(motion, horizon.min(f64::MAX)),
            Unit::Scaled(factor) => {
                let horizon = (horizon / factor).min(f64::MAX);
                self.search(&faster(motion, factor), horizon).later(factor)
            }
            Unit::OutOfRange => Outcome::OutOfRange,
        }
    }

    /// A bound on the rounding of the speed at which a tether at one of its bounds approaches it
    /// at time 0 (length per time): E'.
    pub fn resolved_speed(&self, bound: TetherBound, motion: &RelativeMotion) -> f64 {
        let flight = self.flight(motion);
        match bound {
            TetherBound::Longest => {
                let taut = LongestLength::new(&flight, self);
                taut.gap(&taut.pose(0.0)).rate_error
            }
            TetherBound::Shortest => {
                let speed = flight.speed;
                let error = ErrorBound::of_circles(motion, speed, flight.spin, &self.circles);
                error.of_rate(0.0, self.shortest)
            }
        }
    }

    fn flight<'a>(&self, motion: &'a RelativeMotion) -> Flight<'a> {
        Flight::of_bodies(self.circles.map(|circle| circle.arm == 0.0), motion)
    }

    /// The first event of points at the centres of mass, in closed form.
    fn straight_event(&self, motion: &RelativeMotion, horizon: f64) -> Outcome<TetherBound> {
        let (d, velocity) = (motion.separation, motion.velocity);
        let errors = |length: f64| {
            let circles = self.circles.map(|circle| Circle {
                radius: 0.5 * length,
                ..circle
            });
            let bound = ErrorBound::of_circles(motion, velocity.length(), [0.0; 2], &circles);
            (bound.at(0.0), motion.velocity_error)
        };
        let taut = taut_in(d, velocity, self.longest, errors(self.longest));
        let mut first = Contact {
            time: taut,
            touch: TetherBound::Longest,
        };
        if self.shortest > 0.0 {
            let near = disc_contact(d, velocity, self.shortest, errors(self.shortest));
            if near < taut {
                first = Contact {
                    time: near,
                    touch: TetherBound::Shortest,
                };
            }
        }
        if first.time <= horizon {
            Outcome::Contact(first)
        } else {
            Outcome::Free
        }
    }

    fn search(&self, motion: &RelativeMotion, horizon: f64) -> Outcome<TetherBound> {
        if self.circles.iter().all(|circle| circle.arm == 0.0) {
            return self.straight_event(motion, horizon);
        }
        let flight = self.flight(motion);
        let mut search = Search::new(horizon, MAX_STEPS, ());
        let taut = LongestLength::new(&flight, self);
        let found = taut.first_contact(0.0, [f64::INFINITY, horizon], &mut 0, &mut search);
        search.record_touch(found, TetherBound::Longest);
        if self.shortest > 0.0 {
            let (atoms, limit) = (AtomPair::new(&flight, self.circles), search.limit());
            let found = atoms.first_contact(0.0, [f64::INFINITY, limit], &mut 0, &mut search);
            search.record_touch(found, TetherBound::Shortest);
        }
        search.answer().outcome
    }
}

/// The time at which two points in uniform motion, d apart with the relative velocity v, are
/// `longest` apart (time from now; infinite if they are at rest to each other).
///
/// With c = ℓ² − d², b = d·v and D = ℓ² v² − (d × v)², it is the later root of |d + v t| = ℓ, which
/// is (√D − b)/v² for b < 0, and c/(√D + b) else. The rounding of c and of the speed at which the
/// points part is that of [`disc_contact`], whose rules hold with the sign turned: a pair that
/// touches is at its bound if it certainly parts, and one that is beyond the bound unless it
/// certainly returns. Points that return meet the bound once more, on the other side.
fn taut_in(d: DVec2, v: DVec2, longest: f64, (error, velocity_error): (f64, f64)) -> f64 {
    let (b, v_squared, cross) = (d.dot(v), v.length_squared(), d.perp_dot(v));
    if v_squared == 0.0 {
        return f64::INFINITY;
    }
    let c = longest * longest - d.length_squared();
    let error = error + 8.0 * U * longest;
    let touching = 2.0 * longest * error;
    // The time at which d² is ℓ² + `depth`.
    let time_to = |depth: f64| {
        let squared = (longest * longest + depth) * v_squared - cross * cross;
        let root = squared.max(0.0).sqrt();
        if b < 0.0 {
            (root - b) / v_squared
        } else if b + root > 0.0 {
            (c + depth).max(0.0) / (b + root)
        } else {
            0.0
        }
    };
    let resolved = (error + 8.0 * U * longest) * one_norm(v) + velocity_error * longest;
    let resting = RESTING_DEPTH * touching;
    if c.abs() > touching || b.abs() > resolved || resolved == 0.0 {
        time_to(0.0)
    } else if c < -resting {
        0.0
    } else {
        time_to(resting - c.min(0.0))
    }
}

/// The room that is left to the longest length of a tether.
struct LongestLength<'a> {
    flight: &'a Flight<'a>,
    offsets: [DVec2; 2],
    arms: [f64; 2],
    /// ℓ
    longest: f64,
    /// K of the arms
    centripetal: f64,
    /// The bound on |g''|.
    largest: f64,
    /// The bound on |g'''|.
    jerk: f64,
    error: ErrorBound,
}

/// The two points at one time.
struct TetherPose {
    at: Pose,
    d: DVec2,
    arms: [DVec2; 2],
}

impl<'a> LongestLength<'a> {
    fn new(flight: &'a Flight<'a>, tether: &Tether) -> Self {
        let longest = tether.longest;
        let circles = tether.circles.map(|circle| Circle {
            radius: 0.5 * longest,
            ..circle
        });
        let error = ErrorBound::of_circles(flight.motion, flight.speed, flight.spin, &circles);
        let arms = circles.map(|circle| circle.arm);
        let of_arms = [0, 1].map(|body| centripetal(flight.spin[body], arms[body]));
        let turning = of_arms[0] + of_arms[1];
        let of_turning = flight.spin[0].abs() * of_arms[0] + flight.spin[1].abs() * of_arms[1];
        let (speed, room) = (error.speed(), ROOM * longest);
        let jerk = (3.0 * speed * turning + room * of_turning) / longest;
        Self {
            flight,
            offsets: circles.map(|circle| circle.offset),
            arms,
            longest,
            centripetal: turning,
            largest: (speed * speed + room * turning) / longest,
            jerk: or_none(jerk, turning > 0.0),
            error,
        }
    }

    fn pose_of(&self, at: Pose) -> TetherPose {
        let arms = [0, 1].map(|body| at.arm(body, self.offsets[body]));
        TetherPose {
            d: at.separation + (arms[1] - arms[0]),
            arms,
            at,
        }
    }

    fn velocity(&self, pose: &TetherPose) -> DVec2 {
        let [spin_a, spin_b] = self.flight.spin;
        let [arm_a, arm_b] = pose.arms;
        self.flight.motion.velocity + (spin_b * arm_b.perp() - spin_a * arm_a.perp())
    }

    /// E of g at |d| (Lemma 6).
    fn error_of_gap(&self, time: f64, distance: f64) -> f64 {
        let stretch = (0.5 * (self.longest + distance) / self.longest).max(1.0);
        (self.error.at(time) + 8.0 * U * self.longest) * stretch
    }
}

impl GapFunction for LongestLength<'_> {
    type Pose = TetherPose;

    fn pose(&self, time: f64) -> TetherPose {
        self.pose_of(self.flight.at(time))
    }

    fn gap(&self, pose: &TetherPose) -> Gap {
        let [spin_a, spin_b] = self.flight.spin;
        let [arm_a, arm_b] = pose.arms;
        let (longest, d) = (self.longest, pose.d);
        let velocity = self.velocity(pose);
        let acceleration = (spin_a * spin_a) * arm_a - (spin_b * spin_b) * arm_b;
        let (speed, room) = (self.error.speed(), ROOM * longest);
        let distance = d.length();
        let of_place = self.error.at(pose.at.time);
        let spin = self.error.spin();
        let of_velocity = 12.0 * U * speed + spin * of_place + self.flight.motion.velocity_error;
        let of_acceleration = 12.0 * U * self.centripetal + spin * spin * of_place;
        let rate_error = (of_place * speed + room * of_velocity) / longest;
        let second_error =
            (2.0 * speed * of_velocity + room * of_acceleration + self.centripetal * of_place)
                / longest
                + 8.0 * U * self.largest;
        let rate = -d.dot(velocity) / longest;
        let second = -(velocity.length_squared() + d.dot(acceleration)) / longest;
        Gap {
            value: (longest - distance) * (longest + distance) / (2.0 * longest),
            rate,
            second,
            slowness: 1.0 / (rate_error - rate),
            error: self.error_of_gap(pose.at.time, distance),
            rate_error,
            curvature: Curvature::of_smooth_gap(self.largest, second - second_error, self.jerk),
        }
    }

    fn moved(&self, start: &TetherPose, elapsed: f64) -> Option<(TetherPose, f64)> {
        let swings = [0, 1].map(|body| swing(self.flight.spin[body], elapsed, start.arms[body]));
        let moved = self.flight.motion.velocity * elapsed + (swings[1] - swings[0]);
        let widened = -moved.dot(2.0 * start.d + moved) / (2.0 * self.longest);
        let pose = TetherPose {
            // Only the time of the placement is used, for E.
            at: start.at.with_time(start.at.time + elapsed),
            d: start.d + moved,
            arms: [start.arms[0] + swings[0], start.arms[1] + swings[1]],
        };
        Some((pose, widened))
    }

    fn top_speed(&self) -> f64 {
        ROOM * self.error.speed()
    }

    fn size(&self) -> f64 {
        self.longest
    }

    /// The step until the centres may be so far apart that the points reach ℓ (Lemma 4).
    fn other_step(&self, pose: &TetherPose) -> f64 {
        let rim = [0, 1].map(|body| self.flight.spin[body].abs() * self.arms[body]);
        let room = self.longest - (self.arms[0] + self.arms[1]);
        if rim[0] + rim[1] <= FAST_ROTOR * self.flight.speed || room <= 0.0 {
            return 0.0;
        }
        let (place, velocity) = (pose.at.separation, self.flight.motion.velocity);
        let error = self.error.at(pose.at.time) * (room + self.longest) / room;
        let gap = (room * room - place.length_squared()) / (2.0 * room) - error;
        if gap <= 0.0 {
            return 0.0;
        }
        let speed = self.flight.speed;
        let rounding = 12.0 * U * speed + self.flight.motion.velocity_error;
        let rate_error = (error * speed + self.longest * rounding) / room;
        let rate = -place.dot(velocity) / room - rate_error;
        safe_step(gap, rate, &Curvature::at_most(speed * speed / room))
    }

    fn stays(&self, _: &TetherPose, _: f64) -> bool {
        true
    }

    fn within_reach(&self, time: f64, _: f64) -> Option<f64> {
        Some(time)
    }
}

#[cfg(test)]
mod tests;
