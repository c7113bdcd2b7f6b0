//! Pistons: walls across the box with a mass, which contacts push along their normal.
//!
//! Between two contacts a piston has a constant acceleration: that of its force, and the component
//! of gravity along its normal. Its [`Motion`] is uniform in a frame that has this acceleration and
//! coincides with the laboratory at the start of the epoch, as that of a free body is uniform in
//! the falling frame ([`crate::world::drives`]). Stops reflect it, at a time in closed form, and
//! may take a share of its energy.
//!
//! With a spring it oscillates about the place at which spring, force and gravity balance. Each
//! change of its motion gives another oscillation; the own frame is what that deviates from uniform
//! motion, continued back to the start of the epoch.
//!
//! # Guard of the stops
//!
//! With an elasticity e < 1 a piston that is pressed against a stop would reach it infinitely often
//! in a finite time, as would one at e = 0 that a heavier body pushes. The guard against inelastic
//! collapse ([`crate::contact::guard`]) has no size for a stop, so the way L = b − a between the
//! stops takes the place of the diameter, and the time in which the piston moves by L is the
//! natural time. With the contact time c in natural times:
//!
//! - a stop that follows the last one within c L/v, with the speed v, has elasticity 1;
//! - with the acceleration g towards the stop, the piston leaves it with at least u = √(c L g/2).
//!
//! **Lemma.** Between two stops that lose energy at least c L/v passes, so that there are finitely
//! many in a finite time, as v is bounded. A piston that leaves with u alone comes back after
//! 2u/g = √(2 c L/g), with the speed u: it goes on bouncing by u²/2g = c L/4, by a finite number of
//! stops, and none of them changes its energy. A slower one is raised to u, which the ledger has as
//! a negative loss.

use std::{f64::consts::TAU, sync::Arc};

use carom_geometry::{MAX_MAGNITUDE, MIN_MAGNITUDE};
use carom_kinematics::{Drive, EpochTime, Inertia, Motion, Orientation};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{
    scene::elasticity_spec::ElasticitySpec,
    world::{
        World,
        body::{Body, BodyKey},
        drives::SAME_PLACE,
    },
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
    /// Stiffness of its spring (mass / time²); 0 without one.
    pub stiffness: f64,
    /// The place on its axis at which the spring is relaxed (length).
    pub relaxed_at: f64,
    /// Share of its speed that it keeps at a stop, from 0 to 1.
    pub stop_elasticity: f64,
    /// The time of its last stop; `None` if stops lose no energy, or before the first one.
    pub last_stop: Option<EpochTime>,
    /// With a spring, its oscillation from the start of the epoch on; that of its last change of
    /// motion. Set at the start of each epoch.
    #[serde(skip)]
    pub swing: Drive,
}

impl Piston {
    /// Whether all numbers are in their ranges, in a box with this side along the axis (length).
    pub fn is_valid(&self, side: f64) -> bool {
        let [low, high] = self.stops;
        (MIN_MAGNITUDE..=MAX_MAGNITUDE).contains(&self.mass)
            && is_force(self.force, self.mass)
            && is_force(self.stiffness, self.mass)
            && self.stiffness >= 0.0
            && self.relaxed_at.abs() <= MAX_MAGNITUDE
            && (0.0..=1.0).contains(&self.stop_elasticity)
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

    /// This piston for a clock that is at 0 at a time of the present one.
    pub fn restarted(&self, zero: EpochTime) -> Self {
        Self {
            last_stop: self.last_stop.map(|stop| EpochTime::from(stop.since(zero))),
            ..*self
        }
    }

    /// The angular frequency of a piston on its spring (radians per time); 0 without one.
    pub fn frequency(&self) -> f64 {
        (self.stiffness / self.mass).sqrt()
    }

    /// The place on its axis at which its spring balances a constant acceleration (length, length
    /// per time squared).
    pub fn balance(&self, acceleration: f64) -> f64 {
        self.relaxed_at + acceleration * self.mass / self.stiffness
    }

    /// The acceleration at a place on its axis, with this constant part of it (length, length per
    /// time squared).
    pub fn acceleration_at(&self, place: f64, constant: f64) -> f64 {
        constant + self.stiffness / self.mass * (self.relaxed_at - place)
    }

    /// The velocity after a stop that is reached now with this place and velocity along its axis,
    /// with the constant part of its acceleration and the contact time of the guard (length, length
    /// per time, length per time squared, natural times); see the [module](self).
    fn velocity_after_stop(
        &self,
        [place, velocity]: [f64; 2],
        constant: f64,
        contact_time: f64,
        now: EpochTime,
    ) -> f64 {
        let [low, high] = self.stops;
        let way = contact_time * (high - low);
        let away = if place > 0.5 * (low + high) {
            -1.0
        } else {
            1.0
        };
        let pressing = -away * self.acceleration_at(place, constant);
        let speed = velocity.abs();
        let follows = |last: EpochTime| now.since(last) * speed < way;
        let kept = if self.last_stop.is_some_and(follows) {
            speed
        } else {
            self.stop_elasticity * speed
        };
        away * kept.max((0.5 * way * pressing.max(0.0)).sqrt())
    }

    /// The largest magnitude of its acceleration between its stops, with this constant part of it
    /// (length per time squared).
    fn largest_acceleration(&self, constant: f64) -> f64 {
        if self.stiffness == 0.0 {
            return constant.abs();
        }
        let balance = self.balance(constant);
        let farthest = self.stops.map(|stop| (stop - balance).abs());
        self.stiffness / self.mass * farthest[0].max(farthest[1])
    }

    /// Whether a piston at this place of its axis is at rest on a stop that holds it against this
    /// acceleration (length, length per time, length per time squared).
    pub fn rests_on_stop(&self, place: f64, velocity: f64, acceleration: f64) -> bool {
        let [low, high] = self.stops;
        let is_pressed = place <= low && acceleration < 0.0 || place >= high && acceleration > 0.0;
        velocity == 0.0 && is_pressed
    }

    /// The time until a piston at this place on its axis, with this velocity and constant part of
    /// its acceleration along it, next reaches one of its stops; infinite if it reaches none.
    pub fn time_to_stop(&self, place: f64, velocity: f64, acceleration: f64) -> f64 {
        let [low, high] = self.stops;
        if self.stiffness > 0.0 {
            let (balance, frequency) = (self.balance(acceleration), self.frequency());
            let state = [place - balance, velocity / frequency];
            let up = first_swing(high - balance, state);
            let down = first_swing(balance - low, state.map(|number| -number));
            return up.min(down) / frequency;
        }
        let up = first_passage(high - place, velocity, acceleration);
        let down = first_passage(place - low, -velocity, -acceleration);
        up.min(down)
    }
}

/// Whether a piston of this mass may have this force: none, or one with an acceleration in the
/// range of all magnitudes. (That of a tiny force would vanish, and the swing on its spring be
/// infinite.)
pub(crate) fn is_force(force: f64, mass: f64) -> bool {
    let acceleration = (force / mass).abs();
    force.abs() <= MAX_MAGNITUDE
        && (force == 0.0 || (MIN_MAGNITUDE..=MAX_MAGNITUDE).contains(&acceleration))
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

/// The first angle by which a swing A sin θ, with the displacement A sin θ and the quadrature A cos
/// θ now, has turned when it passes `distance` upwards (lengths, radians); infinite if it never
/// does. It is 0 where that has already been passed and the velocity leads on.
fn first_swing(distance: f64, [displacement, quadrature]: [f64; 2]) -> f64 {
    let leads_on = quadrature > 0.0 || (quadrature == 0.0 && displacement < 0.0);
    if displacement >= distance && leads_on {
        return 0.0;
    }
    let amplitude = libm::hypot(displacement, quadrature);
    // A swing that rounding has carried beyond a stop turns back within it, and meets it at once.
    let is_beyond = displacement > distance;
    if amplitude <= distance.abs() && !(is_beyond && distance < 0.0) {
        return f64::INFINITY;
    }
    // A sin θ = d with a positive cosine.
    let cosine = ((amplitude - distance) * (amplitude + distance)).max(0.0);
    let there = libm::atan2(distance, cosine.sqrt());
    let turned = there - libm::atan2(displacement, quadrature);
    if turned > 0.0 {
        turned
    } else if quadrature > 0.0 && !is_beyond {
        // It moves on, and is there but for rounding.
        0.0
    } else {
        turned + TAU
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

    /// Whether a force or a spring acts on a piston.
    #[inline]
    pub(crate) fn has_forces(&self) -> bool {
        let acts = |piston: &Piston| piston.force != 0.0 || piston.stiffness > 0.0;
        self.pistons.iter().any(acts)
    }

    /// Whether a piston is on a spring.
    #[inline]
    pub(crate) fn has_springs(&self) -> bool {
        self.pistons.iter().any(|piston| piston.stiffness > 0.0)
    }

    /// The constant part of the acceleration of a body that is not fixed, in the laboratory (length
    /// per time squared): all of it but that of a spring.
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

    /// The motion of a body that is not fixed beside uniform motion, in the laboratory, from the
    /// start of the epoch on.
    #[inline]
    pub(crate) fn own_drive(&self, body: usize) -> Drive {
        match self.piston(body) {
            Some(piston) if piston.stiffness > 0.0 => piston.swing,
            _ => Drive::acceleration(self.acceleration(body)),
        }
    }

    /// Lets the oscillation of a piston on a spring go on from this motion in the laboratory, which
    /// begins at its time in the epoch. Nothing changes for any other body.
    pub(crate) fn swing_on(&mut self, body: usize, motion: &Motion) {
        let acceleration = self.acceleration(body);
        let (Some(&piston), Some(axis)) = (self.piston(body), self.bodies[body].axis_across())
        else {
            return;
        };
        if piston.stiffness == 0.0 {
            return;
        }
        let frequency = piston.frequency();
        // A sin θ and A cos θ.
        let displacement = motion.position[axis] - piston.balance(acceleration[axis]);
        let quadrature = motion.velocity[axis] / frequency;
        let amplitude = libm::hypot(displacement, quadrature) * DVec2::AXES[axis];
        let phase = Orientation::from_radians(libm::atan2(displacement, quadrature));
        let swing = Drive::oscillation(amplitude, frequency, phase.turned(frequency, -motion.time));
        self.replace_piston(Piston { swing, ..piston });
    }

    /// Lets all oscillations of pistons on springs begin with the motions at the start of the
    /// epoch.
    pub(crate) fn start_swings(&mut self) {
        let pistons: Vec<usize> = self.pistons().collect();
        for body in pistons {
            let motion = self.motions[body];
            self.swing_on(body, &motion);
        }
    }

    /// The potential energy of all springs at a time (offset in the epoch; mass × length² / time²).
    pub(crate) fn energy_of_springs(&self, time: f64) -> f64 {
        let energies = self.pistons().filter_map(|body| {
            let (piston, axis) = (self.piston(body)?, self.bodies[body].axis_across()?);
            let place = self.motion_at(body as u32, &self.motions[body], time);
            let stretched = place.position[axis] - piston.relaxed_at;
            Some(0.5 * piston.stiffness * stretched * stretched)
        });
        energies.sum()
    }

    /// The largest magnitude of the acceleration of a body that is not fixed, relative to the
    /// laboratory or to the falling frame (length per time squared).
    pub(crate) fn largest_acceleration(&self) -> f64 {
        let gravity = self.gravity.length();
        let of_forces = self.pistons.iter().map(|piston| {
            let constant = piston.force / piston.mass;
            let most = if piston.stiffness == 0.0 {
                constant
            } else {
                constant.abs() + gravity
            };
            let signs = [most, -most];
            let largest = signs.map(|constant| piston.largest_acceleration(constant));
            largest[0].max(largest[1])
        });
        gravity + of_forces.fold(0.0, f64::max)
    }

    /// The highest angular frequency of a piston on a spring (radians per time); 0 without one.
    pub(crate) fn highest_frequency(&self) -> f64 {
        let frequencies = self.pistons.iter().map(Piston::frequency);
        frequencies.fold(0.0, f64::max)
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

    /// The motion with which a piston leaves a stop that it reaches with this motion in the
    /// laboratory, and the energy lost (mass × length² / time²). `guard` is the contact time of the
    /// guard (natural times); 0 stands for its default.
    pub(crate) fn leave_stop(&mut self, body: u32, before: &Motion, guard: f64) -> (Motion, f64) {
        let index = body as usize;
        let (Some(&piston), Some(axis)) = (self.piston(index), self.bodies[index].axis_across())
        else {
            return (*before, 0.0);
        };
        if piston.stop_elasticity == 1.0 {
            let velocity = -before.velocity;
            return (
                Motion {
                    velocity,
                    ..*before
                },
                0.0,
            );
        }
        let contact_time = if guard > 0.0 {
            guard
        } else {
            ElasticitySpec::default().contact_time
        };
        let now = self.time_at(before.time);
        let state = [before.position[axis], before.velocity[axis]];
        let constant = self.acceleration(index)[axis];
        let velocity = piston.velocity_after_stop(state, constant, contact_time, now);
        let last_stop = Some(now);
        self.replace_piston(Piston {
            last_stop,
            ..piston
        });
        let lost = 0.5 * piston.mass * ((state[1] - velocity) * (state[1] + velocity));
        let velocity = DVec2::AXES[axis] * velocity;
        (
            Motion {
                velocity,
                ..*before
            },
            lost,
        )
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

    proptest! {
        /// The displacement at the angle found is that of the stop, and no earlier one is beyond
        /// it.
        #[test]
        fn the_first_swing_is_on_the_stop_and_nothing_before_is_beyond_it(
            amplitude in 0.01..5.0f64, phase in 0.0..TAU, share in -1.2..1.2f64, is_at_stop in 0..4u8,
        ) {
            let distance = share * amplitude;
            let (sin, cos) = libm::sincos(phase);
            let mut state = [amplitude * sin, amplitude * cos];
            if is_at_stop == 0 && share.abs() < 1.0 {
                // Just reflected.
                state = [distance, -amplitude * (1.0 - share * share).sqrt()];
            }
            prop_assume!(state[0] <= distance);
            let angle = first_swing(distance, state);
            let place = |turned: f64| {
                let (sin, cos) = libm::sincos(turned);
                state[0] * cos + state[1] * sin
            };
            let end = if angle.is_finite() {
                prop_assert!((place(angle) - distance).abs() < 1e-12 * amplitude.max(1.0), "{angle}");
                angle
            } else {
                TAU
            };
            for part in 0..200 {
                prop_assert!(place(end * f64::from(part) / 200.0) <= distance + 1e-7 * amplitude);
            }
        }
    }

    #[test]
    fn a_swing_that_rounding_has_carried_to_a_stop_meets_it() {
        // It moves on to the stop, and is there but for rounding.
        let state = [0.3, (0.25f64 - 0.09).sqrt()];
        assert!(first_swing(0.3 - 1e-17, state) < 1e-8);
        assert_eq!(first_swing(0.3 - 1e-9, state), 0.0);
        // Pressed against a stop and carried beyond it by rounding, it meets it where it turns.
        assert!(first_swing(-0.5, [-0.5 + 1e-12, -1e-9]) < 1e-8);
        assert_eq!(first_swing(0.5, [0.3, -0.1]), f64::INFINITY);
        // At rest on the stop: pressed against it by the spring, and pulled away.
        assert_eq!(first_swing(-0.5, [-0.5, 0.0]), 0.0);
        assert_eq!(first_swing(0.5, [0.5, 0.0]), f64::INFINITY);
    }

    #[test]
    fn a_piston_that_leaves_its_stop_comes_back_if_a_force_pushes_it() {
        assert_eq!(first_passage(0.0, -1.0, 0.5), 4.0);
        assert_eq!(first_passage(-1e-17, -1.0, 0.0), f64::INFINITY);
        assert_eq!(first_passage(-1e-17, 1.0, 0.0), 0.0);
        assert_eq!(first_passage(0.0, 0.0, -1.0), f64::INFINITY);
    }
}
