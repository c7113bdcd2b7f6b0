//! The stops of a piston, which reflect it without loss, computed from its acceleration alone.

use carom_kinematics::EpochTime;
use carom_testkit::oracle::Number as _;

use super::kinematics::{BodyState, duration};

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

/// A flight between stops, up to its last reflection.
#[derive(Debug, Clone, Copy)]
pub struct ReflectedFlight {
    /// The state after the last reflection; that of the start without one.
    pub state: BodyState,
    /// Number of reflections.
    pub count: u32,
    /// The lowest speed at a reflection (length per time); infinite without one.
    pub slowest: f64,
}

impl ReflectedFlight {
    /// The flight of a piston from a state until `time`; of another body without reflections.
    pub fn until(state: &BodyState, time: EpochTime) -> Self {
        let mut flight = Self {
            state: *state,
            count: 0,
            slowest: f64::INFINITY,
        };
        let Some(PistonStops { axis, ends }) = state.stops else {
            return flight;
        };
        while flight.count < MAX_REFLECTIONS {
            let state = &mut flight.state;
            let (place, velocity) = (state.place[axis], state.velocity[axis]);
            let acceleration = state.gravity[axis];
            let [low, high] = ends;
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
            state.place[axis] = end;
            state.velocity[axis] = if up < down { -speed } else { speed };
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
    use carom_kinematics::Motion;
    use glam::DVec2;

    fn piston(velocity: f64, acceleration: f64) -> BodyState {
        let at_rest = Motion::at_rest(DVec2::new(0.25, 0.5));
        BodyState {
            velocity: [velocity, 0.0],
            gravity: [acceleration, 0.0],
            stops: Some(PistonStops {
                axis: 0,
                ends: [0.125, 0.625],
            }),
            ..BodyState::new(&at_rest, EpochTime::ZERO, 0.0)
        }
    }

    #[test]
    fn a_piston_without_a_force_goes_to_and_fro() {
        let free = piston(0.5, 0.0);
        for step in 0..200 {
            let time = 0.0173 * f64::from(step);
            let phase = (0.125 + 0.5 * time) % 1.0;
            let place = if phase < 0.5 { phase } else { 1.0 - phase } + 0.125;
            let found = free.at(time.into(), [1.0; 2]).place;
            assert!((found[0] - place).abs() < 1e-14, "{time}: {found:?}");
            assert_eq!(found[1], 0.5);
            assert_eq!(free.velocity_at(time.into())[0].abs(), 0.5);
        }
        let flight = ReflectedFlight::until(&free, 3.0.into());
        assert_eq!((flight.count, flight.slowest), (3, 0.5));
    }

    #[test]
    fn a_force_lets_a_piston_bounce() {
        // From rest it reaches the stop 1/8 below after half a unit of time.
        let pushed = piston(0.0, -1.0);
        for step in 0..200 {
            let time = 0.0173 * f64::from(step);
            let since = (time + 0.5) % 1.0 - 0.5;
            let found = pushed.at(time.into(), [1.0; 2]).place[0];
            assert!((found - (0.25 - 0.5 * since * since)).abs() < 1e-13);
        }
        assert_eq!(pushed.velocity_at(0.25.into()), [-0.25, 0.0]);
    }

    #[test]
    fn a_piston_pressed_against_its_stop_stays() {
        let mut pressed = piston(0.0, -1.0);
        pressed.place[0] = 0.125;
        let flight = ReflectedFlight::until(&pressed, 3.0.into());
        assert_eq!(flight.count, 0);
        assert_eq!(pressed.at(3.0.into(), [1.0; 2]).place[0], 0.125);
    }
}
