//! The stops of a piston, which reflect it without loss, computed from its acceleration alone.

use carom_kinematics::EpochTime;
use carom_testkit::oracle::Number as _;

use super::durations::duration;

/// Largest number of reflections in one flight; later ones are left out.
const MAX_REFLECTIONS: u32 = 100_000;

/// The stops of a piston.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PistonStops {
    /// The axis along which the piston moves: 0 for x, 1 for y.
    pub axis: usize,
    /// The least and the largest place on it (length).
    pub ends: [f64; 2],
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
    /// Its acceleration (length per time²).
    pub acceleration: f64,
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
}

impl PistonStops {
    /// The flight from a state until `time`.
    pub fn flight(&self, state: AxisState, time: EpochTime) -> ReflectedFlight {
        let mut flight = ReflectedFlight {
            state,
            count: 0,
            slowest: f64::INFINITY,
        };
        let [low, high] = self.ends;
        while flight.count < MAX_REFLECTIONS {
            let state = &mut flight.state;
            let AxisState {
                place,
                velocity,
                acceleration,
                ..
            } = *state;
            let up = first_passage(high - place, velocity, acceleration);
            let down = first_passage(place - low, -velocity, -acceleration);
            let (wait, end) = if up < down { (up, high) } else { (down, low) };
            // A piston that is pressed against its stop stays there.
            let rests = wait == 0.0 && velocity == 0.0;
            if rests || duration(state.time, time).value() < wait {
                break;
            }
            let squared = velocity * velocity + 2.0 * acceleration * (end - place);
            let speed = squared.max(0.0).sqrt();
            state.time = state.time.new_epoch(wait);
            state.place = end;
            state.velocity = if up < down { -speed } else { speed };
            flight.count += 1;
            flight.slowest = flight.slowest.min(speed);
        }
        flight
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

#[cfg(test)]
mod tests {
    use super::*;

    const STOPS: PistonStops = PistonStops {
        axis: 0,
        ends: [0.125, 0.625],
    };

    fn piston(place: f64, velocity: f64, acceleration: f64) -> AxisState {
        AxisState {
            time: EpochTime::ZERO,
            place,
            velocity,
            acceleration,
        }
    }

    /// The place at a time, from the last reflection before it.
    fn place_at(from: AxisState, time: f64) -> f64 {
        let state = STOPS.flight(from, time.into()).state;
        let since = duration(state.time, time.into()).value();
        state.place + since * (state.velocity + 0.5 * state.acceleration * since)
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
}
