//! Pistons: walls across the box with a mass, which contacts push along their normal.
//!
//! Between two contacts a piston has a constant acceleration: that of its force, and the component
//! of gravity along its normal. Its [`Motion`] is uniform in a frame that has this acceleration and
//! coincides with the laboratory at the start of the epoch, as that of a free body is uniform in
//! the falling frame ([`crate::world::drives`]). Stops reflect it, at a time in closed form.

use std::sync::Arc;

use carom_geometry::{MAX_MAGNITUDE, MIN_MAGNITUDE};
use carom_kinematics::{Inertia, Motion};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::world::{
    World,
    body::{Body, BodyKey},
    drives::SAME_PLACE,
};

/// The properties of a piston beside those of its wall.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct Piston {
    /// The wall.
    pub key: BodyKey,
    /// Mass.
    pub mass: f64,
    /// Constant force along its axis, upwards if positive (mass × length / time²).
    pub force: f64,
    /// The least and the largest place on its axis (length).
    pub stops: [f64; 2],
}

impl Piston {
    /// Whether all numbers are in their ranges, in a box with this side along the axis (length).
    pub fn is_valid(&self, side: f64) -> bool {
        let [low, high] = self.stops;
        (MIN_MAGNITUDE..=MAX_MAGNITUDE).contains(&self.mass)
            && is_force(self.force, self.mass)
            && 0.0 < low
            && low < high
            && high < side
    }

    /// Whether a simulation can have written it for a wall across the box with this motion along
    /// this axis at the start of an epoch, in a box with this side along it (length).
    pub fn is_of(&self, motion: &Motion, axis: usize, side: f64) -> bool {
        let [low, high] = self.stops;
        let (place, rounding) = (motion.position[axis], SAME_PLACE * side);
        self.is_valid(side)
            && low - rounding <= place
            && place <= high + rounding
            && motion.velocity[1 - axis] == 0.0
    }

    /// Whether a piston at this place of its axis is at rest on a stop that holds it against this
    /// acceleration (length, length per time, length per time squared).
    pub fn rests_on_stop(&self, place: f64, velocity: f64, acceleration: f64) -> bool {
        let [low, high] = self.stops;
        let is_pressed = place <= low && acceleration < 0.0 || place >= high && acceleration > 0.0;
        velocity == 0.0 && is_pressed
    }

    /// The time until a piston at this place on its axis, with this velocity and acceleration along
    /// it, next reaches one of its stops; infinite if it reaches none.
    pub fn time_to_stop(&self, place: f64, velocity: f64, acceleration: f64) -> f64 {
        let [low, high] = self.stops;
        let up = first_passage(high - place, velocity, acceleration);
        let down = first_passage(place - low, -velocity, -acceleration);
        up.min(down)
    }
}

/// Whether a piston of this mass may have this force: its acceleration is 0, or in the range of all
/// magnitudes.
pub(crate) fn is_force(force: f64, mass: f64) -> bool {
    let acceleration = (force / mass).abs();
    force.abs() <= MAX_MAGNITUDE
        && (acceleration == 0.0 || (MIN_MAGNITUDE..=MAX_MAGNITUDE).contains(&acceleration))
}

/// The first time at which d = v t + ½ a t², for a distance d that is not negative but for
/// rounding. It is 0 where that has already been passed and the velocity leads on.
pub(crate) fn first_passage(distance: f64, velocity: f64, acceleration: f64) -> f64 {
    if distance <= 0.0 && (velocity > 0.0 || (velocity == 0.0 && acceleration > 0.0)) {
        return 0.0;
    }
    let square = velocity * velocity + 2.0 * acceleration * distance;
    if velocity > 0.0 {
        if square < 0.0 {
            return f64::INFINITY;
        }
        return 2.0 * distance / (velocity + square.sqrt());
    }
    // It leads away, and comes back if the acceleration does.
    if acceleration > 0.0 {
        (-velocity + square.max(0.0).sqrt()) / acceleration
    } else {
        f64::INFINITY
    }
}

impl World {
    /// The piston that a body is; `None` for most.
    #[inline]
    pub(crate) fn piston(&self, body: usize) -> Option<&Piston> {
        if self.pistons.is_empty() {
            return None;
        }
        let key = self.bodies[body].key();
        self.pistons.iter().find(|piston| piston.key == key)
    }

    /// The indices of all pistons, in the order of [`Self::bodies`].
    pub fn pistons(&self) -> impl Iterator<Item = usize> {
        let indices = self.pistons.iter();
        indices.filter_map(|piston| self.index(piston.key))
    }

    /// Whether a force acts on a piston.
    #[inline]
    pub(crate) fn has_forces(&self) -> bool {
        self.pistons.iter().any(|piston| piston.force != 0.0)
    }

    /// The acceleration of a body that is not fixed, in the laboratory (length per time squared).
    #[inline]
    pub(crate) fn acceleration(&self, body: usize) -> DVec2 {
        match self.piston(body) {
            None => self.gravity,
            Some(piston) => {
                let axis = self.bodies[body].axis_across().unwrap_or_default();
                let along = self.gravity[axis] + piston.force / piston.mass;
                DVec2::AXES[axis] * along
            }
        }
    }

    /// The largest magnitude of the acceleration of a body that is not fixed, relative to the
    /// laboratory or to the falling frame (length per time squared).
    pub(crate) fn largest_acceleration(&self) -> f64 {
        let of_forces = self.pistons.iter();
        let of_forces = of_forces.map(|piston| (piston.force / piston.mass).abs());
        self.gravity.length() + of_forces.fold(0.0, f64::max)
    }

    /// The time (offset in the epoch) at which a piston with this motion in its own frame next
    /// reaches a stop; infinite for any other body.
    pub fn stop_time(&self, body: u32, motion: &Motion, now: f64) -> f64 {
        let index = body as usize;
        let (Some(piston), Some(axis)) = (self.piston(index), self.bodies[index].axis_across())
        else {
            return f64::INFINITY;
        };
        let here = self.motion_at(body, motion, now);
        let acceleration = self.acceleration(index)[axis];
        now + piston.time_to_stop(here.position[axis], here.velocity[axis], acceleration)
    }

    /// Makes a fixed wall across the box (index in the order of the bodies) a piston, which does
    /// not turn.
    pub(crate) fn free_piston(&mut self, wall: usize, piston: Piston) {
        Arc::make_mut(&mut self.bodies[wall].kind).inertia = Inertia::locked(piston.mass);
        self.pistons.push(piston);
    }

    /// Replaces the properties of a piston of the system.
    pub(crate) fn replace_piston(&mut self, piston: Piston) {
        let mut pistons = self.pistons.iter_mut();
        if let Some(place) = pistons.find(|place| place.key == piston.key) {
            *place = piston;
        }
    }

    /// Keeps the pistons whose walls are in the system.
    pub(crate) fn drop_removed_pistons(&mut self) {
        let bodies = &self.bodies;
        self.pistons
            .retain(|piston| bodies.binary_search_by_key(&piston.key, Body::key).is_ok());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// The place at the time found is that of the stop, and no earlier place is beyond it.
        #[test]
        fn the_first_passage_is_on_the_stop_and_nothing_before_is_beyond_it(
            distance in 0.0..2.0f64, velocity in -3.0..3.0f64, acceleration in -3.0..3.0f64, force in 0..3u8,
        ) {
            let acceleration = if force == 0 { 0.0 } else { acceleration };
            let time = first_passage(distance, velocity, acceleration);
            let place = |t: f64| velocity * t + 0.5 * acceleration * t * t;
            let end = if time.is_finite() {
                let size = 1.0 + velocity.abs() * time + acceleration.abs() * time * time;
                prop_assert!((place(time) - distance).abs() < 1e-12 * size, "{time}");
                time
            } else {
                50.0
            };
            for part in 0..200 {
                prop_assert!(place(end * f64::from(part) / 200.0) <= distance + 1e-12 * (1.0 + end * end));
            }
        }
    }

    #[test]
    fn a_piston_that_leaves_its_stop_comes_back_if_a_force_pushes_it() {
        assert_eq!(first_passage(0.0, -1.0, 0.5), 4.0);
        assert_eq!(first_passage(-1e-17, -1.0, 0.0), f64::INFINITY);
        assert_eq!(first_passage(-1e-17, 1.0, 0.0), 0.0);
        assert_eq!(first_passage(0.0, 0.0, -1.0), f64::INFINITY);
    }
}
