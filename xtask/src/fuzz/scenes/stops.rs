//! The stops of a piston, which reflect it with an elasticity and a guard against endless bounces,
//! computed from its acceleration and its spring alone.

use carom_kinematics::EpochTime;
use carom_testkit::oracle::{DoubleDouble, Number as _};

use super::{axis_motion::AxisState, durations::duration};

/// Largest number of reflections in one flight; later ones are left out.
const MAX_REFLECTIONS: u32 = 100_000;

/// The stops of a piston.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PistonStops {
    /// The axis along which the piston moves: 0 for x, 1 for y.
    pub axis: usize,
    /// The least and the largest place on it (length).
    pub ends: [f64; 2],
    /// Elasticity of the stops.
    pub elasticity: f64,
    /// Contact time of the guard, the share of the way between the stops that is too short for
    /// another loss.
    pub contact_time: f64,
}

/// A flight between stops, up to its last reflection.
#[derive(Debug, Clone, Copy)]
pub struct ReflectedFlight {
    /// The state after the last reflection; that of the start without one.
    pub state: AxisState,
    /// Number of reflections.
    pub count: u32,
    /// The lowest speed at a reflection (length per time); infinite without one.
    pub slowest: f64,
    /// Energy lost at stops, over the mass (length² / time²).
    pub lost: f64,
}

impl PistonStops {
    /// The flight from a state until `time`.
    pub fn flight(&self, state: AxisState, time: EpochTime) -> ReflectedFlight {
        let mut flight = ReflectedFlight {
            state,
            count: 0,
            slowest: f64::INFINITY,
            lost: 0.0,
        };
        let [low, high] = self.ends;
        while flight.count < MAX_REFLECTIONS {
            let state = &mut flight.state;
            let [up, down] = [state.time_to(high, 1.0), state.time_to(low, -1.0)];
            let (wait, end) = if up < down { (up, high) } else { (down, low) };
            // A piston that is pressed against its stop stays there.
            let rests = wait == 0.0 && state.velocity == 0.0;
            if rests || duration(state.time, time).value() < wait {
                break;
            }
            let gained = 2.0 * state.mean_acceleration(end) * (end - state.place);
            let speed = (state.velocity * state.velocity + gained).max(0.0).sqrt();
            // The sum of the offset and the wait would be rounded to that of the offset.
            state.time = state.time.new_epoch(0.0).new_epoch(wait);
            state.place = end;
            let after = self.speed_after(state, speed);
            state.velocity = if up < down { -after } else { after };
            if self.elasticity < 1.0 {
                state.last_stop = Some(state.time);
            }
            flight.count += 1;
            flight.slowest = flight.slowest.min(speed).min(after);
            flight.lost += 0.5 * (speed - after) * (speed + after);
        }
        flight
    }

    /// The speed with which a piston leaves the stop at its place that it has reached with this
    /// speed (length per time).
    ///
    /// At the speed of arrival, a shorter way since the last stop than the share `contact_time` of
    /// that between the stops loses nothing, and against a pressing force the piston leaves at
    /// least fast enough to come back after a quarter of that share.
    fn speed_after(&self, state: &AxisState, speed: f64) -> f64 {
        if self.elasticity == 1.0 {
            return speed;
        }
        let [low, high] = self.ends;
        let way = self.contact_time * (high - low);
        let is_soon = |last: EpochTime| duration(last, state.time).value() * speed < way;
        let kept = if state.last_stop.is_some_and(is_soon) {
            speed
        } else {
            self.elasticity * speed
        };
        let outwards = if state.place >= high { 1.0 } else { -1.0 };
        let pressing = (outwards * state.acceleration_here()).max(0.0);
        kept.max((0.5 * way * pressing).sqrt())
    }

    /// Displacement after a state until `time` (length).
    pub fn displacement(&self, state: AxisState, time: EpochTime) -> DoubleDouble {
        let after = self.flight(state, time).state;
        let [from, to] = [state, after].map(|state| DoubleDouble::new(state.place));
        let way = to.minus(&from);
        if self.holds(&after) {
            return way;
        }
        way.plus(&after.displacement(time))
    }

    /// Velocity at `time` after a state (length per time).
    pub fn velocity(&self, state: AxisState, time: EpochTime) -> f64 {
        let after = self.flight(state, time).state;
        if self.holds(&after) {
            return 0.0;
        }
        after.velocity_at(time)
    }

    /// Returns true for a piston at rest on a stop, against which it is pressed.
    fn holds(&self, state: &AxisState) -> bool {
        let [low, high] = self.ends;
        let (place, acceleration) = (state.place, state.acceleration_here());
        let is_pressed =
            (place <= low && acceleration < 0.0) || (place >= high && acceleration > 0.0);
        is_pressed && state.velocity == 0.0
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::{super::axis_motion::PistonSpring, *};

    const STOPS: PistonStops = PistonStops {
        axis: 0,
        ends: [0.125, 0.625],
        elasticity: 1.0,
        contact_time: 1e-3,
    };

    fn piston(place: f64, velocity: f64, acceleration: f64) -> AxisState {
        AxisState {
            time: EpochTime::ZERO,
            place,
            velocity,
            acceleration,
            spring: None,
            last_stop: None,
        }
    }

    /// The place at a time.
    fn place_at(from: AxisState, time: f64) -> f64 {
        from.place + STOPS.displacement(from, time.into()).value()
    }

    #[test]
    fn a_piston_without_a_force_goes_to_and_fro() {
        let free = piston(0.25, 0.5, 0.0);
        for step in 0..200 {
            let time = 0.0173 * f64::from(step);
            let phase = (0.125 + 0.5 * time) % 1.0;
            let expected = if phase < 0.5 { phase } else { 1.0 - phase } + 0.125;
            assert!((place_at(free, time) - expected).abs() < 1e-14, "{time}");
        }
        let flight = STOPS.flight(free, 3.0.into());
        assert_eq!((flight.count, flight.slowest), (3, 0.5));
    }

    #[test]
    fn a_stop_of_half_the_elasticity_halves_the_speed() {
        let stops = PistonStops {
            elasticity: 0.5,
            ..STOPS
        };
        // At the upper stop at 0.75, at the lower one at 2.75, each after twice the time.
        let flight = stops.flight(piston(0.25, 0.5, 0.0), 3.0.into());
        assert_eq!((flight.count, flight.state.velocity), (2, 0.125));
        assert_eq!(flight.state.time.to_f64(), 2.75);
        assert_eq!(flight.lost, 0.5 * (0.25 - 1.0 / 64.0));
    }

    #[test]
    fn a_pressed_piston_that_loses_energy_ends_in_short_bounces() {
        let stops = PistonStops {
            elasticity: 0.5,
            ..STOPS
        };
        let pressed = piston(0.25, 0.0, -1.0);
        let flight = stops.flight(pressed, 3.0.into());
        // The least speed is that of bounces as high as a quarter of the guarded way.
        let least = (0.5 * 1e-3 * 0.5f64).sqrt();
        assert!(flight.count > 20 && flight.slowest >= least * (1.0 - 1e-12));
        let height = 0.5 * flight.state.velocity * flight.state.velocity;
        assert!(height <= 1e-3 * 0.5, "{height}");
    }

    #[test]
    fn a_force_lets_a_piston_bounce() {
        // From rest it reaches the stop 1/8 below after half a unit of time.
        let pushed = piston(0.25, 0.0, -1.0);
        for step in 0..200 {
            let time = 0.0173 * f64::from(step);
            let since = (time + 0.5) % 1.0 - 0.5;
            let expected = 0.25 - 0.5 * since * since;
            assert!((place_at(pushed, time) - expected).abs() < 1e-13, "{time}");
        }
    }

    #[test]
    fn a_piston_pressed_against_its_stop_stays() {
        let flight = STOPS.flight(piston(0.125, 0.0, -1.0), 3.0.into());
        assert_eq!((flight.count, flight.state.place), (0, 0.125));
    }
    /// On a spring with Ω = 3 that balances at 0.3 (length).
    fn on_spring(place: f64, velocity: f64) -> AxisState {
        AxisState {
            spring: PistonSpring::new(18.0, 2.0, 0.1),
            ..piston(place, velocity, 1.8)
        }
    }

    #[test]
    fn a_stop_reflects_a_swing() {
        // From the turning point at 0.5 it reaches the stop at 0.2 after a third of a period.
        let stops = PistonStops {
            axis: 0,
            ends: [0.2, 0.625],
            ..STOPS
        };
        let half = 2.0 * PI / 9.0;
        for step in 0..200 {
            let time = 0.0173 * f64::from(step);
            let since = (time + half) % (2.0 * half) - half;
            let place = 0.5 + stops.displacement(on_spring(0.5, 0.0), time.into()).value();
            let expected = 0.3 + 0.2 * (3.0 * since).cos();
            assert!((place - expected).abs() < 1e-13, "{time}");
            let velocity = stops.velocity(on_spring(0.5, 0.0), time.into());
            let expected = -0.6 * (3.0 * since).sin();
            assert!((velocity - expected).abs() < 1e-12, "{time}");
        }
        let flight = stops.flight(on_spring(0.5, 0.0), 3.0.into());
        assert_eq!(flight.count, 2);
        assert!((flight.slowest - 0.6 * (PI / 3.0).sin()).abs() < 1e-14);
    }

    #[test]
    fn a_swing_between_two_stops_keeps_its_energy_and_runs_back() {
        let begin = on_spring(0.25, 2.0);
        for step in 1..100 {
            let time = 0.0371 * f64::from(step);
            let there = AxisState {
                time: time.into(),
                place: place_at(begin, time),
                velocity: STOPS.velocity(begin, time.into()),
                ..begin
            };
            let [before, now] = [&begin, &there].map(|state| state.swing_speed().unwrap());
            assert!((before - now).abs() < 1e-12, "{time}");
            assert!((0.125 - 1e-13..=0.625 + 1e-13).contains(&there.place));
            let back = AxisState {
                velocity: -there.velocity,
                ..there
            };
            let end = EpochTime::from(2.0 * time);
            let place = back.place + STOPS.displacement(back, end).value();
            assert!((place - 0.25).abs() < 1e-11, "{time}: {place}");
        }
    }

    #[test]
    fn a_piston_that_its_spring_presses_against_its_stop_stays() {
        let pressed = AxisState {
            spring: PistonSpring::new(18.0, 2.0, 0.0),
            ..piston(0.125, 0.0, 0.5)
        };
        assert_eq!(STOPS.flight(pressed, 3.0.into()).count, 0);
        assert_eq!(place_at(pressed, 3.0), 0.125);
        assert_eq!(STOPS.velocity(pressed, 3.0.into()), 0.0);
        // Without a pressure it swings from its stop, and returns.
        let free = AxisState {
            acceleration: 1.5,
            ..pressed
        };
        assert!(place_at(free, 1.0) > 0.14);
    }
}
