//! Shear by moving images (Lees and Edwards): the boxes above and below slide along x.
//!
//! With a shear rate γ the images of a body k boxes higher are displaced by k b(t) along x and move
//! by k γ Ly faster, with the tilt b' = γ Ly (A. W. Lees and S. F. Edwards, J. Phys. C 5 (1972)
//! 1921). A body that leaves the box through its upper side enters it again at the lower one,
//! displaced by −b and slower by γ Ly. In the stationary state the mean velocity is the *flow*
//! γ (y − Ly/2) along x.
//!
//! Between contacts every body flies freely: neither contacts nor flights know of the shear, but
//! for the images through which a pair is seen. Kinetic energies are those of the bodies in the
//! box, so that a passage through the seam changes the energy; the ledger books it as the work of
//! the shear.
//!
//! # Cells
//!
//! The grid is at rest in x − a y, with the slope a(t) = b(t)/Ly: in these coordinates images do
//! not move, and the cells are parallelograms that shear with the flow. Within an epoch |a| is at
//! most A = Lx/2Ly + [`MAX_SHEAR_OF_EPOCH`], because the tilt is folded into ±Lx/2 at its start.
//! Two bodies that touch at a distance d differ by at most d along y, and by at most d √(1 + A²)
//! along x − a y; with cells as long as that they are in adjacent ones. A body leaves a
//! parallelogram at a root of a quadratic.

use carom_geometry::PeriodicBox;
use carom_kinematics::{Motion, kinetic_energy};
use glam::DVec2;

use crate::world::{World, body::Body, contact_event::ContactEvent, pistons::first_passage};

/// Largest change of the slope of the cells in an epoch. Smaller: more epochs. Larger: longer
/// cells.
const MAX_SHEAR_OF_EPOCH: f64 = 0.5;

impl World {
    /// The shear rate (1/time); 0 without shear.
    pub fn shear_rate(&self) -> f64 {
        self.shear_rate
    }

    /// Whether the images above and below move or are displaced.
    #[inline]
    pub(crate) fn is_sheared(&self) -> bool {
        self.shear_rate != 0.0 || self.bounds.tilt() != 0.0
    }

    /// Speed of the images in the next box above (length per time).
    #[inline]
    pub(crate) fn speed_of_images(&self) -> f64 {
        self.shear_rate * self.bounds.sides().y
    }

    /// The periodic box at an offset in the epoch (time).
    #[inline]
    pub(crate) fn bounds_at(&self, offset: f64) -> PeriodicBox {
        if self.shear_rate == 0.0 {
            return self.bounds;
        }
        let tilt = self.bounds.tilt() + self.speed_of_images() * offset;
        self.bounds.tilted(tilt)
    }

    /// The shift of the image of the second body that is touched (length).
    #[inline]
    pub(crate) fn shift_of(&self, contact: &ContactEvent) -> DVec2 {
        self.bounds_at(contact.time).shift(contact.image)
    }

    /// Velocity of the bodies of an image relative to those in the box (length per time).
    #[inline]
    pub(crate) fn image_velocity(&self, image: [i64; 2]) -> DVec2 {
        DVec2::new(self.speed_of_images() * image[1] as f64, 0.0)
    }

    /// The mean velocity of a stationary flow at a place in the box (length per time).
    pub(crate) fn flow_at(&self, place: DVec2) -> DVec2 {
        let middle = 0.5 * self.bounds.sides().y;
        DVec2::new(self.shear_rate * (place.y - middle), 0.0)
    }

    /// The seam of a sheared box from an offset in the epoch on (time); `None` without a shear.
    pub(crate) fn seam_at(&self, offset: f64) -> Option<Seam> {
        self.is_sheared().then(|| Seam {
            bounds: self.bounds_at(offset),
            speed: self.speed_of_images(),
        })
    }

    /// The work of the shear that the ledger does not hold yet, at the start of the epoch (mass ×
    /// length² / time²). A scheduler adds that of [`Self::pass_seam`] and stores it by
    /// [`StoredMotions::set_work_of_shear`](crate::scheduler::StoredMotions::set_work_of_shear).
    pub fn work_of_shear(&self) -> f64 {
        self.work_of_shear
    }

    /// The motion of a body after it has left the box through its upper side (`rows` = 1) or its
    /// lower one (−1) and is seen in the box again, and the energy that it gains thereby (mass ×
    /// length² / time²).
    pub fn pass_seam(&self, body: u32, motion: &Motion, rows: i32) -> (Motion, f64) {
        let Some(seam) = self.seam_at(0.0) else {
            let mut after = *motion;
            after.position.y -= f64::from(rows) * self.bounds.sides().y;
            return (after, 0.0);
        };
        let after = seam.brought_back(motion, rows);
        let gained = Self::gained(&self.bodies[body as usize], motion, &after);
        (after, gained)
    }

    /// Wraps a motion at an offset in the epoch into the box; returns the number of boxes by which
    /// it was outside.
    pub(crate) fn wrapped_at(&self, motion: &Motion, offset: f64) -> (Motion, [i64; 2]) {
        let (position, image) = self.bounds_at(offset).wrap(motion.position);
        let mut wrapped = Motion {
            position,
            ..*motion
        };
        if image[1] != 0 {
            wrapped.velocity -= self.image_velocity(image);
        }
        (wrapped, image)
    }

    /// Energy that a body gains where it is seen with `after` instead of `before`.
    pub(crate) fn gained(body: &Body, before: &Motion, after: &Motion) -> f64 {
        let inertia = body.inertia();
        kinetic_energy(after, inertia) - kinetic_energy(before, inertia)
    }

    /// The longest epoch under shear (time); infinite without.
    pub(crate) fn longest_sheared_epoch(&self) -> f64 {
        MAX_SHEAR_OF_EPOCH / self.shear_rate.abs()
    }

    /// The factor between a distance and the length along x − a y that it may take in the epoch.
    pub(crate) fn stretch_of_cells(&self) -> f64 {
        if !self.is_sheared() {
            return 1.0;
        }
        let sides = self.bounds.sides();
        let slope = 0.5 * sides.x / sides.y + MAX_SHEAR_OF_EPOCH;
        // The margin covers the rounding of places.
        slope.hypot(1.0) * (1.0 + 1e-9)
    }

    /// Replaces the tilt by the equal one within half a box.
    pub(crate) fn fold_tilt(&mut self) {
        let (tilt, side) = (self.bounds.tilt(), self.bounds.sides().x);
        let boxes = (tilt / side).round();
        if boxes == 0.0 {
            return;
        }
        self.bounds = self.bounds.tilted(tilt - boxes * side);
        for winding in &mut self.windings {
            let shift = winding[1].saturating_mul(boxes as i64);
            winding[0] = winding[0].saturating_add(shift);
        }
    }

    /// Adds the flow to the velocities of all bodies.
    pub(crate) fn add_flow(&mut self) {
        for index in 0..self.motions.len() {
            let flow = self.flow_at(self.motions[index].position);
            self.motions[index].velocity += flow;
        }
    }
}

/// The upper and lower side of a sheared box, and the cells that shear with it; times are from the
/// moment on that its tilt is of.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Seam {
    bounds: PeriodicBox,
    /// Speed of the next box above (length per time).
    speed: f64,
}

impl Seam {
    /// The shift of an image at time 0 (length), and its velocity.
    #[inline]
    pub(crate) fn shift(&self, image: [i32; 2]) -> [DVec2; 2] {
        let velocity = DVec2::new(self.speed * f64::from(image[1]), 0.0);
        [self.bounds.shift(image.map(i64::from)), velocity]
    }

    /// The motion in the box of a body that is `rows` boxes above it.
    pub(crate) fn brought_back(&self, motion: &Motion, rows: i32) -> Motion {
        let [shift, velocity] = self.shift([0, rows]);
        Motion {
            position: motion.position - (shift + velocity * motion.time),
            velocity: motion.velocity - velocity,
            ..*motion
        }
    }

    /// Speed of the images (length per time).
    #[inline]
    pub(crate) fn speed(&self) -> f64 {
        self.speed.abs()
    }

    /// x − slope y of a place at time 0 (length).
    #[inline]
    pub(crate) fn across(&self, place: DVec2) -> f64 {
        place.x - self.bounds.tilt() / self.bounds.sides().y * place.y
    }

    /// Takes a motion at time 0 to the image in the parallelogram that the cells cover. Returns
    /// x − slope y there, from 0 to the side (length), and the number of boxes by which it has
    /// moved.
    pub(crate) fn enter_cells(&self, motion: &mut Motion) -> (f64, i64) {
        let side = self.bounds.sides().x;
        let boxes = (self.across(motion.position) / side).floor();
        motion.position.x -= boxes * side;
        (self.across(motion.position).max(0.0), boxes as i64)
    }

    /// The time at which a body leaves its cell, not before `now`, and through which side: the axis
    /// across it (0 for x − slope y, 1 for y) and the direction. `corners` are the lower and the
    /// upper one in these coordinates (length). Infinite if it stays.
    pub(crate) fn next_crossing(
        &self,
        motion: &Motion,
        corners: [DVec2; 2],
        now: f64,
    ) -> (f64, usize, i32) {
        let sides = self.bounds.sides();
        let rate = self.speed / sides.y;
        let slope = self.bounds.tilt() / sides.y + rate * now;
        let place = motion.position_at(now);
        let across = place.x - slope * place.y;
        let velocity = (motion.velocity.x - slope * motion.velocity.y) - rate * place.y;
        let acceleration = -2.0 * (rate * motion.velocity.y);
        let [near, far] = corners;
        let right = now + first_passage(far.x - across, velocity, acceleration);
        let left = now + first_passage(across - near.x, -velocity, -acceleration);
        let sideways = if left < right {
            (left, 0, -1)
        } else {
            (right, 0, 1)
        };
        let (border, direction) = if motion.velocity.y > 0.0 {
            (far.y, 1)
        } else {
            (near.y, -1)
        };
        // A velocity of exactly 0 never crosses; 0/0 and 1/−0 must not be formed.
        if motion.velocity.y == 0.0 {
            return sideways;
        }
        let time = motion.time + (border - motion.position.y) / motion.velocity.y;
        if time < sideways.0 {
            (time.max(now), 1, direction)
        } else {
            sideways
        }
    }
}
