//! Driven bodies: walls that oscillate, and fixed bodies in the frame that falls with the gravity.
//!
//! # Gravity
//! All free bodies have the same acceleration g. In a frame that falls with them they fly
//! uniformly, so that contacts of two free bodies and crossings of cells are those without gravity,
//! and fixed bodies have the acceleration −g. At the start of each epoch the falling frame
//! coincides with the laboratory, so that all motions of a [`World`] are those of the laboratory; τ
//! later a free body at x with the velocity v in the falling frame is at x + ½ g τ² and has the
//! velocity v + g τ. Contacts are resolved in the laboratory, where walls at rest do no work.
//! Pistons have accelerations, and so frames, of their own ([`crate::world::pistons`]).

use carom_detection::{Answer, Detection};
use carom_geometry::{MAX_MAGNITUDE, Outline};
use carom_kinematics::{Drive, DriveDeviation, Motion, RelativeMotion};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::world::{World, heat::exact_sum};

/// The largest change of the phase of an oscillation in an epoch (radians). Smaller: more epochs.
/// Larger: the rounding of places grows in proportion.
const MAX_PHASE: f64 = 8.0;

/// The largest change of the phase of a piston on a spring in an epoch (radians). Smaller: more
/// epochs, each of which predicts all bodies. Larger: its own frame, in which it flies uniformly,
/// moves away, and the rounding of its place grows.
const MAX_SWING: f64 = 2.0;

/// The longest way that the falling frame falls in an epoch, in shorter sides of the box. Smaller:
/// more epochs. Larger: walls are listed in more cells, and places have more rounding.
const MAX_FALL: f64 = 0.25;

/// Two places that differ by less than this share of the box are one.
pub(crate) const SAME_PLACE: f64 = 1e-9;

/// The oscillation of a wall.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct Oscillation {
    /// The oscillation from the start of the epoch on.
    pub drive: Drive,
    /// The place about which it oscillates (length).
    pub centre: DVec2,
}

impl Oscillation {
    /// Whether a simulation in a box with these sides (length) can have written it for a wall with
    /// this motion at the start of an epoch.
    pub fn is_of(&self, motion: &Motion, sides: DVec2) -> bool {
        let drive = &self.drive;
        let amplitude = drive.amplitude();
        let [displacement, velocity] = drive.oscillation_now();
        let boxes = (motion.position - (self.centre + displacement)) / sides;
        let is_there = (boxes - boxes.round()).abs().max_element() <= SAME_PLACE;
        let size = amplitude.length();
        let oscillation = Drive::oscillation(amplitude, drive.frequency(), drive.phase());
        drive.is_finite()
            && *drive == oscillation
            && drive.phase().turns().abs() <= 0.5
            && motion.angular_velocity == 0.0
            && self.centre.is_finite()
            && drive.frequency() > 0.0
            && (size > 0.0 && size < sides.min_element())
            && size * drive.frequency() * drive.frequency() <= MAX_MAGNITUDE
            && is_there
            && motion.velocity == velocity
    }
}

impl World {
    /// Whether some body may be driven.
    #[inline]
    pub(crate) fn is_driven(&self) -> bool {
        !self.oscillations.is_empty() | self.accelerates()
    }

    /// Whether some body that is not fixed is accelerated.
    #[inline]
    pub(crate) fn accelerates(&self) -> bool {
        self.has_gravity() | self.has_forces()
    }

    /// Whether there is a gravity.
    #[inline]
    pub(crate) fn has_gravity(&self) -> bool {
        self.gravity != DVec2::ZERO
    }

    /// The drive of a body in the falling frame, from the start of the epoch on; `None` for most.
    /// The body is an index in the order of [`Self::bodies`].
    #[inline]
    pub fn drive(&self, body: usize) -> Option<Drive> {
        if !self.is_driven() {
            return None;
        }
        if !self.bodies[body].is_fixed() {
            let own = self.own_drive(body).accelerated(-self.gravity);
            return (own != Drive::default()).then_some(own);
        }
        let oscillation = self.oscillation(body);
        if self.has_gravity() {
            return Some(oscillation.unwrap_or_default().accelerated(-self.gravity));
        }
        oscillation
    }

    /// The drive of a wall that oscillates, in the laboratory.
    pub(crate) fn oscillation(&self, body: usize) -> Option<Drive> {
        let oscillation = self.oscillations.get(body)?.as_ref()?;
        Some(oscillation.drive)
    }

    /// The drive of the second of two bodies relative to the first, from the start of the epoch on;
    /// `None` if the relative motion is uniform. Of two fixed bodies that of one.
    #[inline]
    pub fn relative_drive(&self, bodies: [u32; 2]) -> Option<Drive> {
        if !self.is_driven() {
            return None;
        }
        let [first, second] = bodies.map(|body| self.drive(body as usize));
        match (first, second) {
            (Some(first), Some(second)) => {
                let are_fixed = bodies.map(|body| self.bodies[body as usize].is_fixed());
                // One of two that may meet is a piston, and then the other one does not oscillate.
                Some(if are_fixed == [true; 2] {
                    second
                } else {
                    second.less(&first)
                })
            }
            (first, second) => second.or_else(|| first.map(|drive| -drive)),
        }
    }

    /// The motion in the laboratory at a time (offset in the epoch) of a body with this motion in
    /// the falling frame since an earlier time.
    #[inline]
    pub(crate) fn motion_at(&self, body: u32, motion: &Motion, time: f64) -> Motion {
        if self.is_driven() {
            self.driven_motion_at(body, motion, time)
        } else {
            motion.at(time)
        }
    }

    #[inline(never)]
    fn driven_motion_at(&self, body: u32, motion: &Motion, time: f64) -> Motion {
        let body = body as usize;
        let drive = if self.bodies[body].is_fixed() {
            self.oscillation(body).unwrap_or_default()
        } else {
            self.own_drive(body)
        };
        drive.applied(motion, time)
    }

    /// The motion of a body in its own frame, the falling frame for all but pistons, of one with
    /// this motion in the laboratory, which begins now. A piston on a spring swings on from there.
    pub(crate) fn enter_own_frame(&mut self, body: u32, motion: &Motion) -> Motion {
        if self.has_springs() {
            self.swing_on(body as usize, motion);
        }
        self.in_own_frame(body, motion)
    }

    /// The motion of a body in its own frame now, of one with this motion in the laboratory.
    pub(crate) fn in_own_frame(&self, body: u32, motion: &Motion) -> Motion {
        if !self.accelerates() || self.bodies[body as usize].is_fixed() {
            return *motion;
        }
        let fallen = self.frame_of(body as usize, motion.time);
        Motion {
            position: motion.position - fallen.position,
            velocity: motion.velocity - fallen.velocity,
            ..*motion
        }
    }

    /// Place and velocity of the falling frame at a time (offset in the epoch).
    pub(crate) fn falling_frame(&self, time: f64) -> DriveDeviation {
        Drive::acceleration(self.gravity).deviation(0.0, time)
    }

    /// Place and velocity of the own frame of a body that is not fixed at a time (offset in the
    /// epoch).
    pub(crate) fn frame_of(&self, body: usize, time: f64) -> DriveDeviation {
        self.own_drive(body).deviation(0.0, time)
    }

    /// The highest speed of a wall that oscillates (length per time).
    pub(crate) fn fastest_oscillation(&self) -> f64 {
        let oscillations = self.oscillations.iter().flatten();
        let speeds = oscillations.map(|oscillation| oscillation.drive.max_speed(0.0));
        speeds.fold(0.0, f64::max)
    }

    /// Σ m a·x over all bodies that are not fixed at a time (offset in the epoch), with the
    /// constant parts a of their accelerations and their positions x without periodic jumps, less
    /// the energy of springs: the potential energy with the opposite sign (mass × length² / time²).
    pub(crate) fn negative_potential_energy(&self, time: f64) -> f64 {
        let free = (0..self.bodies.len()).filter(|&body| !self.bodies[body].is_fixed());
        let terms = free.map(|body| {
            let place = self
                .motion_at(body as u32, &self.motions[body], time)
                .position
                + self.bounds.shift(self.windings[body]);
            self.bodies[body].mass() * self.acceleration(body).dot(place)
        });
        let constant = exact_sum(terms);
        if self.has_springs() {
            constant - self.energy_of_springs(time)
        } else {
            constant
        }
    }

    /// The relative motion at a time (offset in the epoch) of two bodies with these motions in the
    /// falling frame, of which the second is seen in an image (boxes).
    #[inline]
    pub fn relative_motion(
        &self,
        bodies: [u32; 2],
        motions: [&Motion; 2],
        image: [i64; 2],
        time: f64,
    ) -> RelativeMotion {
        let shift = self.bounds_at(time).shift(image);
        let mut uniform = RelativeMotion::between(motions[0], motions[1], shift, time);
        if self.shear_rate != 0.0 {
            uniform.velocity += self.image_velocity(image);
        }
        match self.relative_drive(bodies) {
            None => uniform,
            Some(drive) => uniform.deviated(&drive.deviation(0.0, time)),
        }
    }

    /// The first contact of two bodies that are certified free for `begin` (time) from `now`
    /// (offset in the epoch) on, with their relative motion at that time; times are from then on.
    #[inline]
    pub fn first_contact<D: Detection>(
        &self,
        detection: &D,
        bodies: [u32; 2],
        outlines: [Outline<'_>; 2],
        motion: &RelativeMotion,
        now: f64,
        [begin, horizon]: [f64; 2],
    ) -> Answer {
        match self.relative_drive(bodies) {
            None => {
                let [a, b] = outlines;
                detection.first_contact_after(begin, a, b, motion, horizon)
            }
            Some(drive) => {
                let drive = (&drive, now);
                detection.first_contact_driven(begin, outlines, motion, drive, horizon)
            }
        }
    }

    /// The longest epoch (time) of driven bodies, so that rounding stays small; infinite without
    /// one.
    pub(crate) fn longest_driven_epoch(&self) -> f64 {
        let oscillations = self.oscillations.iter().flatten();
        let fall = 2.0 * MAX_FALL * self.bounds.sides().min_element();
        let of_springs = MAX_SWING / self.highest_frequency();
        oscillations
            .map(|oscillation| MAX_PHASE / oscillation.drive.frequency())
            .fold((fall / self.largest_acceleration()).sqrt(), f64::min)
            .min(of_springs)
    }

    /// Sets or ends the oscillation of a wall (index in the order of [`Self::bodies`]), which is at
    /// the place of the oscillation now, in any image. Its velocity becomes that of the
    /// oscillation.
    pub(crate) fn set_oscillation(&mut self, wall: usize, oscillation: Option<Oscillation>) {
        if self.oscillations.len() <= wall && oscillation.is_some() {
            self.oscillations.resize(self.bodies.len(), None);
        }
        if let Some(place) = self.oscillations.get_mut(wall) {
            *place = oscillation;
        }
        self.clear_ended_oscillations();
        if let Some(Oscillation { drive, .. }) = oscillation {
            self.motions[wall].velocity = drive.oscillation_now()[1];
        }
    }

    /// Empties the list of oscillations if none is left.
    pub(crate) fn clear_ended_oscillations(&mut self) {
        if self.oscillations.iter().all(Option::is_none) {
            self.oscillations.clear();
        }
    }

    /// Lets all oscillations run backwards from the start of the epoch on.
    pub(crate) fn reverse_oscillations(&mut self) {
        for wall in 0..self.oscillations.len() {
            if let Some(oscillation) = self.oscillations[wall] {
                let drive = oscillation.drive.reversed();
                self.set_oscillation(
                    wall,
                    Some(Oscillation {
                        drive,
                        ..oscillation
                    }),
                );
            }
        }
    }

    /// Lets the oscillation of a body begin anew at `offset` in the epoch, and returns its motion
    /// then. It is computed from the place about which the body oscillates, so that no rounding
    /// accumulates.
    pub(crate) fn restart_oscillation(&mut self, body: usize, offset: f64) -> Option<Motion> {
        let motion = *self.motions.get(body)?;
        let sides = self.bounds.sides();
        let Oscillation { drive, centre } = self.oscillations.get_mut(body)?.as_mut()?;
        let there = drive.applied(&motion, offset);
        *drive = drive.restarted(offset);
        let [displacement, velocity] = drive.oscillation_now();
        let place = *centre + displacement;
        // The image of this place that the body has reached.
        let boxes = ((there.position - place) / sides).round();
        Some(Motion {
            position: place + boxes * sides,
            velocity,
            ..there
        })
    }
}
