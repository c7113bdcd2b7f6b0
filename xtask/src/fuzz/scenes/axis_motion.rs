//! The motion of a piston along its axis between two reflections, with a constant acceleration or
//! on a spring, in double-double precision.
//!
//! With the distance h to a place ahead, the velocity v and the mean ā of the accelerations here
//! and there, a piston on a spring of the angular frequency Ω gets there as follows.
//!
//! 1. The speed there is S = √(v² + 2 ā h): the acceleration is linear in the place.
//! 2. In s = (2/Ω) tan(Ω t/2), x(t) = b + q cos Ωt + (v/Ω) sin Ωt gives h = v s + ½ ā s², as
//!    without a spring.
//! 3. It passes upwards, with the velocity +S, at the root s = 2 h/(v + S) = (S − v)/ā. The half
//!    angle Ω t/2 of the first passage is between 0 and π.

use carom_kinematics::EpochTime;
use carom_testkit::oracle::{DoubleDouble, Number as _};

use super::durations::duration;

/// A spring that pulls a piston to a place on its axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PistonSpring {
    /// Ω², the stiffness over the mass (1 / time²).
    square: DoubleDouble,
    /// Ω (radians per time).
    frequency: DoubleDouble,
    /// The place at which it is relaxed (length).
    relaxed_at: f64,
}

/// The motion of a piston along its axis.
#[derive(Debug, Clone, Copy)]
pub struct AxisState {
    /// The time.
    pub time: EpochTime,
    /// Its place (length).
    pub place: f64,
    /// Its velocity (length per time).
    pub velocity: f64,
    /// The constant part of its acceleration: all of it without a spring (length per time²).
    pub acceleration: f64,
    /// Its spring, if it has one.
    pub spring: Option<PistonSpring>,
    /// When it has last left a stop that is not elastic.
    pub last_stop: Option<EpochTime>,
}

impl PistonSpring {
    /// A spring of a stiffness (mass / time²) on a piston of a mass; `None` without stiffness.
    pub fn new(stiffness: f64, mass: f64, relaxed_at: f64) -> Option<Self> {
        let square = DoubleDouble::new(stiffness).over(&DoubleDouble::new(mass));
        (stiffness > 0.0).then(|| Self {
            square,
            frequency: square.root(),
            relaxed_at,
        })
    }

    /// Ω (radians per time).
    pub fn frequency(&self) -> f64 {
        self.frequency.value()
    }

    /// The acceleration by the spring at a place (length per time²).
    fn pull(&self, place: &DoubleDouble) -> DoubleDouble {
        let stretched = place.minus(&DoubleDouble::new(self.relaxed_at));
        DoubleDouble::new(0.0).minus(&self.square.times(&stretched))
    }

    /// The largest energy of the spring at some places over the mass (length² / time²).
    pub fn largest_energy(&self, places: [f64; 2]) -> f64 {
        let [low, high] = places.map(|place| (place - self.relaxed_at).abs());
        let farthest = self.frequency() * low.max(high);
        0.5 * farthest * farthest
    }

    /// Cosine and sine of the angle by which a swing turns in a share of a duration.
    fn cos_sin(&self, share: f64, duration: &DoubleDouble) -> [DoubleDouble; 2] {
        let angle = self.frequency.times(duration);
        DoubleDouble::cos_sin(0.0, share, &angle)
    }
}

impl AxisState {
    /// The acceleration at a place (length per time²).
    fn acceleration_at(&self, place: &DoubleDouble) -> DoubleDouble {
        let constant = DoubleDouble::new(self.acceleration);
        match &self.spring {
            None => constant,
            Some(spring) => constant.plus(&spring.pull(place)),
        }
    }

    /// The acceleration here (length per time²).
    pub fn acceleration_here(&self) -> f64 {
        self.acceleration_at(&DoubleDouble::new(self.place)).value()
    }

    /// The mean of the accelerations here and at another place, whose product with the way between
    /// them is the change of ½ v² (length per time²).
    pub fn mean_acceleration(&self, end: f64) -> f64 {
        let sum = DoubleDouble::new(self.place).plus(&DoubleDouble::new(end));
        let middle = sum.times(&DoubleDouble::new(0.5));
        self.acceleration_at(&middle).value()
    }

    /// Displacement until `time` without stops (length).
    pub fn displacement(&self, time: EpochTime) -> DoubleDouble {
        let duration = duration(self.time, time);
        let velocity = DoubleDouble::new(self.velocity);
        let Some(spring) = &self.spring else {
            let path = velocity.times(&duration);
            if self.acceleration == 0.0 {
                return path;
            }
            let half = DoubleDouble::new(0.5 * self.acceleration);
            return path.plus(&half.times(&duration).times(&duration));
        };
        // (a/Ω²) (1 − cos Ωt) + (v/Ω) sin Ωt, by the half angle, at which no difference cancels.
        let [cos, sin] = spring.cos_sin(0.5, &duration);
        let here = self.acceleration_at(&DoubleDouble::new(self.place));
        let of_acceleration = here.over(&spring.square).times(&sin);
        let of_velocity = velocity.over(&spring.frequency).times(&cos);
        let sum = of_acceleration.plus(&of_velocity);
        sum.times(&sin).times(&DoubleDouble::new(2.0))
    }

    /// Velocity at `time` without stops (length per time).
    pub fn velocity_at(&self, time: EpochTime) -> f64 {
        let duration = duration(self.time, time);
        let velocity = DoubleDouble::new(self.velocity);
        let Some(spring) = &self.spring else {
            let gained = DoubleDouble::new(self.acceleration).times(&duration);
            return velocity.plus(&gained).value();
        };
        let [cos, sin] = spring.cos_sin(1.0, &duration);
        let here = self.acceleration_at(&DoubleDouble::new(self.place));
        let gained = here.over(&spring.frequency).times(&sin);
        velocity.times(&cos).plus(&gained).value()
    }

    /// The time until the piston first passes a place ahead in a direction, 1 upwards and −1
    /// downwards; 0 if it has passed it by rounding, and infinite if it never does.
    pub fn time_to(&self, end: f64, direction: f64) -> f64 {
        let [distance, velocity, acceleration] =
            [end - self.place, self.velocity, self.mean_acceleration(end)]
                .map(|number| direction * number);
        match &self.spring {
            None => first_passage(distance, velocity, acceleration),
            Some(spring) => {
                let numbers = [distance, velocity, acceleration];
                first_swing(numbers, spring.frequency())
            }
        }
    }

    /// The largest magnitude of the acceleration between two places (length per time²).
    pub fn top_acceleration(&self, ends: [f64; 2]) -> f64 {
        let [low, high] = ends.map(|end| self.acceleration_at(&DoubleDouble::new(end)).value());
        low.abs().max(high.abs())
    }

    /// A bound on the speed between two stops (length per time).
    pub fn top_speed(&self, ends: [f64; 2]) -> f64 {
        // Between its stops a piston gains at most this energy by its acceleration.
        let gained = 2.0 * self.top_acceleration(ends) * (ends[1] - ends[0]);
        let speed = self.velocity.hypot(gained.sqrt());
        speed.min(self.swing_speed().unwrap_or(f64::INFINITY))
    }

    /// The speed of the whole swing at the place of balance, in or beyond the stops (length per
    /// time); `None` without a spring.
    pub fn swing_speed(&self) -> Option<f64> {
        let spring = self.spring.as_ref()?;
        let of_place = self.acceleration_here() / spring.frequency();
        Some(self.velocity.hypot(of_place))
    }

    /// The sum of the magnitudes of the places of which the swing is computed (length): those of
    /// the relaxed spring and of the balance, and the distance of the balance from the farther
    /// stop; `None` without a spring.
    pub fn swing_size(&self, ends: [f64; 2]) -> Option<f64> {
        let spring = self.spring.as_ref()?;
        let accelerations = self.acceleration.abs() + self.top_acceleration(ends);
        Some(spring.relaxed_at.abs() + accelerations / spring.square.value())
    }
}

/// The least time t with d = v t + ½ a t², for a distance d ahead; 0 if it has been passed by
/// rounding, and infinite if there is none.
fn first_passage(distance: f64, velocity: f64, acceleration: f64) -> f64 {
    let leads_on = velocity > 0.0 || (velocity == 0.0 && acceleration > 0.0);
    if distance <= 0.0 && leads_on {
        return 0.0;
    }
    let squared = velocity * velocity + 2.0 * acceleration * distance;
    if velocity > 0.0 && squared >= 0.0 {
        2.0 * distance / (velocity + squared.sqrt())
    } else if velocity <= 0.0 && acceleration > 0.0 {
        (squared.max(0.0).sqrt() - velocity) / acceleration
    } else {
        f64::INFINITY
    }
}

/// The least time after which a piston on a spring passes a distance ahead, with its velocity and
/// the mean of the accelerations here and there; 0 if it has passed it by rounding, and infinite if
/// it never does.
fn first_swing([distance, velocity, acceleration]: [f64; 3], frequency: f64) -> f64 {
    let leads_on = velocity > 0.0 || (velocity == 0.0 && acceleration > 0.0);
    if distance <= 0.0 && leads_on {
        return 0.0;
    }
    let squared = velocity * velocity + 2.0 * acceleration * distance;
    if squared < 0.0 && distance > 0.0 {
        return f64::INFINITY;
    }
    let speed = squared.max(0.0).sqrt();
    let half = if velocity > 0.0 {
        libm::atan2(frequency * distance, velocity + speed)
    } else {
        libm::atan2(frequency * (speed - velocity), 2.0 * acceleration)
    };
    2.0 * half / frequency
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;
    use crate::fuzz::random::FuzzDraw;

    /// On a spring with Ω = 3.
    fn on_spring(place: f64, velocity: f64, acceleration: f64, relaxed_at: f64) -> AxisState {
        AxisState {
            time: EpochTime::from(2.0),
            place,
            velocity,
            acceleration,
            spring: PistonSpring::new(18.0, 2.0, relaxed_at),
            last_stop: None,
        }
    }

    /// A random piston on a spring, about places and speeds of size 1.
    fn any(draw: &mut FuzzDraw) -> AxisState {
        let [place, velocity, acceleration] = [(); 3].map(|()| draw.normal());
        let square = draw.scale(1e-4, 1e2);
        AxisState {
            time: EpochTime::from(1e6),
            place,
            velocity: draw.one_of(&[0.0, 1.0, 1.0]) * velocity,
            acceleration,
            spring: PistonSpring::new(square, 1.0, draw.normal()),
            last_stop: None,
        }
    }

    fn place_after(state: &AxisState, time: f64) -> f64 {
        state.place + state.displacement(state.time.after(time)).value()
    }

    #[test]
    fn a_piston_swings_about_its_balance() {
        // The force moves the balance from 0.1 to 0.3.
        let state = on_spring(0.5, 0.0, 1.8, 0.1);
        for step in 0..200 {
            let time = 0.0173 * f64::from(step);
            let there = state.time.after(time);
            let expected = 0.3 + 0.2 * (3.0 * time).cos();
            assert!((place_after(&state, time) - expected).abs() < 1e-14);
            let expected = -0.6 * (3.0 * time).sin();
            assert!((state.velocity_at(there) - expected).abs() < 1e-14);
        }
        assert!((place_after(&state, TAU / 3.0) - 0.5).abs() < 1e-15);
        assert!((state.swing_speed().unwrap() - 0.6).abs() < 1e-15);
        // The acceleration is 2.7 at 0, and −5.4 at 0.9.
        assert!((state.top_acceleration([0.0, 0.9]) - 5.4).abs() < 1e-14);
        assert!((state.top_speed([0.0, 0.9]) - 0.6).abs() < 1e-15);
    }

    #[test]
    fn a_swing_keeps_its_energy() {
        let draw = &mut FuzzDraw::new(3);
        for _ in 0..200 {
            let state = any(draw);
            let time = draw.scale(1e-3, 30.0);
            let there = state.time.after(time);
            let (way, speed) = (state.displacement(there).value(), state.velocity_at(there));
            let work = way * state.mean_acceleration(state.place + way);
            let gained = 0.5 * (speed * speed - state.velocity * state.velocity);
            let size = 1.0 + speed * speed + state.velocity * state.velocity;
            let scale = size + way.abs() * state.top_acceleration([state.place, state.place + way]);
            assert!((work - gained).abs() < 1e-13 * scale, "{work} {gained}");
            assert!(speed.abs() <= state.swing_speed().unwrap() * (1.0 + 1e-12));
        }
    }

    #[test]
    fn a_swing_runs_back() {
        let draw = &mut FuzzDraw::new(4);
        for _ in 0..200 {
            let state = any(draw);
            let time = draw.scale(1e-3, 10.0);
            let there = state.time.after(time);
            let back = AxisState {
                time: there,
                place: place_after(&state, time),
                velocity: -state.velocity_at(there),
                ..state
            };
            let scale = 1.0 + state.swing_speed().unwrap() * (1.0 + time);
            assert!((place_after(&back, time) - state.place).abs() < 1e-14 * scale);
            let velocity = back.velocity_at(there.after(time));
            assert!((velocity + state.velocity).abs() < 1e-13 * scale);
        }
    }

    #[test]
    fn a_swing_passes_a_place_at_the_time_found_and_not_before() {
        let draw = &mut FuzzDraw::new(5);
        let mut passed = 0;
        for _ in 0..500 {
            let state = any(draw);
            let direction = draw.sign();
            let end = state.place + direction * draw.scale(1e-3, 2.0);
            let time = state.time_to(end, direction);
            let period = TAU / state.spring.unwrap().frequency();
            let beyond = |time: f64| direction * (place_after(&state, time) - end);
            if time < f64::INFINITY {
                passed += 1;
                assert!(time < period * (1.0 + 1e-12));
                let size = 1.0 + state.swing_speed().unwrap() * time;
                assert!(beyond(time).abs() < 1e-13 * size, "{state:?} {end}");
                assert!(direction * state.velocity_at(state.time.after(time)) > -1e-6 * size);
            }
            for step in 0..100 {
                let before = time.min(period) * f64::from(step) / 100.0;
                assert!(beyond(before) < 1e-10, "{state:?} {end} {before}");
            }
        }
        assert!(passed > 100, "{passed}");
    }

    #[test]
    fn a_piston_leaves_a_stop_and_returns() {
        // A third of a period from the stop to the turning point, and as much back.
        let leaving = on_spring(0.2, 0.6 * (PI / 3.0).sin(), 0.0, 0.3);
        assert!((leaving.time_to(0.2, -1.0) - 4.0 * PI / 9.0).abs() < 1e-14);
        // At rest on its stop it is pressed against it, or returns after a period.
        assert_eq!(on_spring(0.2, 0.0, 0.0, 0.1).time_to(0.2, -1.0), 0.0);
        let period = on_spring(0.2, 0.0, 0.0, 0.3).time_to(0.2, -1.0);
        assert!((period - TAU / 3.0).abs() < 1e-14);
        // At rest at its balance it stays.
        let balanced = on_spring(0.3, 0.0, 0.0, 0.3);
        assert_eq!(balanced.time_to(0.4, 1.0), f64::INFINITY);
    }

    #[test]
    fn a_soft_spring_acts_as_a_constant_force() {
        let state = |stiffness: f64| AxisState {
            time: EpochTime::ZERO,
            place: 0.25,
            velocity: -0.5,
            acceleration: 0.75,
            spring: PistonSpring::new(stiffness, 1.0, 0.0),
            last_stop: None,
        };
        let (soft, free) = (state(1e-24), state(0.0));
        let of_soft = soft.displacement(3.0.into()).value();
        assert!((of_soft - free.displacement(3.0.into()).value()).abs() < 1e-15);
        assert!((soft.velocity_at(3.0.into()) - free.velocity_at(3.0.into())).abs() < 1e-15);
        for (end, direction) in [(0.375, 1.0), (0.125, -1.0)] {
            let [one, other] = [&soft, &free].map(|state| state.time_to(end, direction));
            assert!((one - other).abs() < 1e-14 * other, "{one} {other}");
        }
    }
}
