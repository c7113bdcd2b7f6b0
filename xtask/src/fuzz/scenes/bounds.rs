//! Bounds on the rounding errors of places, velocities, orientations and gaps.

use carom_kinematics::EpochTime;

use super::{
    kinematics::{BodyOutline, length},
    tracked::TrackedBody,
    watcher::{RESOLUTION, Watcher},
};

/// Outward rounding of a position at a contact, in roundings of the side.
const OUTWARDS: f64 = 4.0;

/// Largest gap at a contact in roundings of the longer side. The engine guarantees sixteen; four
/// times as much covers the rounding of the report, of the box, and of the subsequent computation.
pub(super) const ROUNDINGS: f64 = 64.0;

/// Rounding error that each epoch may add to a position, in roundings of a side. An isolated body
/// flies eight sides in an epoch. The product v t and its sum with the position each contribute
/// half a rounding of eight sides: eight in total. At the k-th of eight crossings the position, of
/// up to k sides, is rounded by half of 1, 2, 2, 4, 4, 4, 4 and 8: 14.5 more.
pub(super) const ROUNDINGS_PER_EPOCH: f64 = 22.5;

/// Largest distance of a body in an epoch, in sides, including bodies that are accelerated in it.
const SIDES_PER_EPOCH: f64 = 16.0;

/// Relative rounding of a velocity that a drag may add in each epoch, in roundings: of the reading
/// of the clock, of the share left, and of the product.
pub(super) const ROUNDINGS_OF_DRAG: f64 = 16.0;

/// With a drag, the velocity in the epoch's clock is up to twice the true one, and the time of an
/// event is converted to that clock and back: so many times the rounding of an offset.
pub(super) const ROUNDINGS_OF_CLOCK: f64 = 8.0;

/// Rounding that each epoch may add to the phase of an oscillation (radians), in roundings: of the
/// angle, up to 8, of a turn, and of the displacement, from which uniform motion is subtracted. The
/// swing of a piston on a spring turns by up to 2 in an epoch, and begins anew at each contact.
pub(super) const ROUNDINGS_OF_PHASE: f64 = 40.0;

/// Rounding of a velocity that a gravity may add in each epoch and contact, in roundings of the
/// speeds in the laboratory and in the falling frame.
pub(super) const ROUNDINGS_OF_FALL: f64 = 8.0;

/// The time for which an error of a velocity changes a place since the last report of a body, which
/// on a spring is at most that of a radian of its swing (time).
fn lasting(body: &TrackedBody, time: EpochTime) -> f64 {
    let since = time.since(body.reported).abs();
    match &body.state.spring {
        None => since,
        Some(spring) => since.min(1.0 / spring.frequency()),
    }
}

/// The number of reflections of a piston since its last report, and its lowest speed at one (length
/// per time).
fn reflections(body: &TrackedBody, time: EpochTime) -> (f64, f64) {
    let (count, slowest) = body.reflections;
    match body.state.reflected(time) {
        None => (count, slowest),
        Some((_, flight)) => (count + f64::from(flight.count), slowest.min(flight.slowest)),
    }
}

/// The highest speed of the whole swing of a piston on a spring (length per time); `None` for other
/// bodies.
fn swing_speed(body: &TrackedBody) -> Option<f64> {
    let (_, state) = body.state.along_axis()?;
    state.swing_speed()
}

impl Watcher {
    pub(super) fn longer_side(&self) -> f64 {
        self.sides[0].max(self.sides[1])
    }

    /// Bound on the position error of a body at `time`, including its arms (length).
    pub(super) fn error(&self, body: &TrackedBody, time: EpochTime) -> f64 {
        let epochs = (self.epochs - body.epoch) as f64;
        let dragged = if self.rules.drag == 0.0 {
            0.0
        } else {
            ROUNDINGS_OF_DRAG * (epochs + 1.0)
        };
        // A disc turns without effect on its place.
        let turning = if body.state.spin == 0.0 || body.outline.is_disc() {
            0.0
        } else {
            4.0 + (8.0 + dragged) * body.state.angle_until(time)
        };
        // Times are rounded as offsets in an epoch; a body moves at most this far in it.
        let longest = SIDES_PER_EPOCH * self.longer_side();
        let speed = body.state.top_speed(time);
        let way = |time: EpochTime| (speed * time.offset().abs()).min(longest);
        let times = if self.rules.drag == 0.0 {
            1.0
        } else {
            ROUNDINGS_OF_CLOCK
        };
        let mut clock = times * (way(time) + way(body.state.time));
        if body.state.table.is_some() {
            clock += 2.0 * speed * self.table_time_error(body) / f64::EPSILON;
        }
        // Epochs start at double-double times, which do not resolve the motion of very fast bodies
        // at late times.
        let rim = speed + body.state.spin.abs() * body.outline.reach;
        let mut unresolved = RESOLUTION * time.to_f64().abs() * rim;
        if body.state.gravity != [0.0; 2] || body.state.spring.is_some() {
            unresolved += self.velocity_error(body, time) * lasting(body, time);
        }
        // Each epoch of an oscillation begins at the place that its phase gives.
        let rounded = match &body.state.oscillation {
            None => {
                let (reflections, _) = reflections(body, time);
                (epochs + 1.0 + 2.0 * reflections) * self.place_rounding(body)
            }
            Some(oscillation) => {
                ROUNDINGS_PER_EPOCH * self.longer_side()
                    + ROUNDINGS_OF_PHASE * (epochs + 1.0) * length(oscillation.amplitude)
            }
        };
        f64::EPSILON
            * (rounded
                + turning * body.outline.reach
                + clock
                + dragged * body.state.path_until(time)
                + OUTWARDS * self.longer_side())
            + unresolved
    }

    /// What each epoch may add to the rounding of a place, in roundings (length).
    fn place_rounding(&self, body: &TrackedBody) -> f64 {
        let of_side = ROUNDINGS_PER_EPOCH * self.longer_side();
        let Some((stops, state)) = body.state.along_axis() else {
            return of_side;
        };
        let (Some(spring), Some(size)) = (&state.spring, state.swing_size(stops.ends)) else {
            return of_side;
        };
        // A swing that is longer passes its stops after a small part of it.
        let amplitude = state.swing_speed().unwrap_or_default() / spring.frequency();
        let longest = SIDES_PER_EPOCH * self.longer_side();
        of_side + ROUNDINGS_OF_PHASE * (size + amplitude.min(longest))
    }

    /// Bound on the error of a velocity that gravity, a force, a spring or an oscillation changes
    /// (length per time).
    pub(super) fn velocity_error(&self, body: &TrackedBody, time: EpochTime) -> f64 {
        let epochs = (self.epochs - body.epoch + 1) as f64;
        let state = &body.state;
        let (speed, acceleration, roundings) = if let Some(oscillation) = &state.oscillation {
            let speed = oscillation.top_speed();
            (speed, speed * oscillation.frequency, ROUNDINGS_OF_PHASE)
        } else if let Some(speed) = swing_speed(body) {
            (speed, state.top_acceleration(), ROUNDINGS_OF_PHASE)
        } else {
            let gravity = length(state.gravity);
            let falling = (gravity * self.longer_side()).sqrt();
            (state.top_speed(time) + falling, gravity, ROUNDINGS_OF_FALL)
        };
        let (reflections, slowest) = reflections(body, time);
        let steps = epochs + 2.0 * reflections;
        let off = self.place_rounding(body);
        // A place that is off by a rounding changes the speed at a stop by that of the fall.
        let of_stops = if reflections > 0.0 && acceleration > 0.0 {
            reflections * off * acceleration / slowest.max(f64::MIN_POSITIVE)
        } else {
            0.0
        };
        // It also changes the acceleration by a spring.
        let of_spring = state.spring.map_or(0.0, |spring| {
            let frequency = spring.frequency();
            steps * off * frequency * frequency * lasting(body, time)
        });
        f64::EPSILON * (roundings * steps * speed + of_stops + of_spring)
            + RESOLUTION * time.to_f64().abs() * acceleration
    }

    /// Bound on the error of the times at which the velocity of a wall with a table changes (time).
    pub(super) fn table_time_error(&self, wall: &TrackedBody) -> f64 {
        let Some(table) = &wall.state.table else {
            return 0.0;
        };
        let epochs = (self.epochs - wall.epoch + 1) as f64;
        ROUNDINGS_OF_CLOCK * f64::EPSILON * epochs * table.period()
    }

    pub(super) fn gap_bound(&self, a: &BodyOutline, b: &BodyOutline) -> f64 {
        ROUNDINGS * f64::EPSILON * (self.longer_side() + a.thickness + b.thickness)
    }

    /// Bound on the error of an orientation, as a distance at the rim (length).
    pub(super) fn turn_error(&self, body: &TrackedBody, time: EpochTime) -> f64 {
        let place = self.error(body, time);
        if !body.outline.is_disc() {
            return place;
        }
        let epochs = (self.epochs - body.epoch + 1) as f64;
        let offsets = time.offset().abs() + body.state.time.offset().abs();
        let turned = epochs * (8.0 + ROUNDINGS_OF_DRAG) * body.state.angle_until(time);
        let clock = ROUNDINGS_OF_CLOCK * body.state.spin.abs() * offsets;
        place + f64::EPSILON * (8.0 * epochs + turned + clock) * body.outline.reach
    }
}
