//! The closed form of the contact time for one disc against eight others, written for SIMD
//! registers.

use carom_kinematics::{HALF_ULP as U, RelativeMotion};
use glam::DVec2;

use crate::disc::contact_of_passing;

/// The number of lanes: discs in one batch.
pub const DISC_LANES: usize = 8;

/// The relative motions of up to `N` (eight) discs and one query disc at a common time 0, as a
/// structure of arrays. A lane that holds NaN is empty. Lengths and speeds must be in the range of
/// [`Outcome::OutOfRange`](crate::Outcome::OutOfRange); beyond it no time is NaN, but contact times
/// may be wrong.
#[derive(Debug, Clone, Copy)]
pub struct DiscLanes<const N: usize = DISC_LANES> {
    /// Positions relative to the query disc (length), x then y.
    pub separation: [[f64; N]; 2],
    /// Velocities relative to the query disc (length per time), x then y.
    pub velocity: [[f64; N]; 2],
    /// Separation × velocity (length squared per time), which determines the distance of closest
    /// approach. It is constant in free flight, so positions at any common time may be used.
    pub cross: [f64; N],
    /// Sums of the two radii (length).
    pub contact_distance: [f64; N],
    /// Bound on the rounding of the positions (length).
    pub separation_error: f64,
    /// |vx| + |vy| of the query disc (length per time).
    pub speed: f64,
}

impl DiscLanes {
    /// Returns eight empty lanes for a query disc with |vx| + |vy| = `speed` (length per time).
    pub fn empty(separation_error: f64, speed: f64) -> Self {
        Self {
            separation: [[f64::NAN; DISC_LANES]; 2],
            velocity: [[0.0; DISC_LANES]; 2],
            cross: [0.0; DISC_LANES],
            contact_distance: [0.0; DISC_LANES],
            separation_error,
            speed,
        }
    }
}

impl<const N: usize> DiscLanes<N> {
    /// Sets the disc of a lane.
    pub fn set(&mut self, lane: usize, separation: DVec2, velocity: DVec2, contact_distance: f64) {
        self.set_since(lane, separation, velocity, 0.0, contact_distance);
    }

    /// Sets the disc of a lane from its relative position `start` (length) at the time `since`
    /// before now.
    #[inline]
    pub fn set_since(
        &mut self,
        lane: usize,
        start: DVec2,
        velocity: DVec2,
        since: f64,
        contact_distance: f64,
    ) {
        let separation = start + velocity * since;
        (self.separation[0][lane], self.separation[1][lane]) = (separation.x, separation.y);
        (self.velocity[0][lane], self.velocity[1][lane]) = (velocity.x, velocity.y);
        self.cross[lane] = start.x * velocity.y - start.y * velocity.x;
        self.contact_distance[lane] = contact_distance;
    }

    /// The relative motion in a lane; `None` for an empty lane.
    pub fn relative_motion(&self, lane: usize) -> Option<RelativeMotion> {
        let separation = DVec2::new(self.separation[0][lane], self.separation[1][lane]);
        let velocity = DVec2::new(self.velocity[0][lane], self.velocity[1][lane]);
        let motion = RelativeMotion {
            separation_error: self.separation_error,
            velocity_error: self.velocity_error(lane),
            ..RelativeMotion::exactly(separation, velocity)
        };
        (!separation.is_nan()).then_some(motion)
    }

    /// The rounding of the velocities of a lane: the speed of the other disc is at most the sum of
    /// that of the query disc and the relative speed.
    #[inline]
    pub(crate) fn velocity_error(&self, lane: usize) -> f64 {
        2.0 * U * (2.0 * self.speed + (self.velocity[0][lane].abs() + self.velocity[1][lane].abs()))
    }

    /// Returns the contact time with each disc (time from now); infinite if there is no contact.
    ///
    /// The results equal those of the closed form for one pair to the last bit, for registers of
    /// any width.
    #[inline(always)]
    pub fn contact_times(&self) -> [f64; N] {
        let (times, in_contact) = self.closed_form();
        if in_contact {
            self.decided_times()
        } else {
            times
        }
    }

    /// The closed form, and whether some pair touches to rounding, or overlaps, and does not
    /// separate. Such a pair is rare and needs [`Self::decided_times`].
    #[inline(always)]
    pub fn closed_form(&self) -> ([f64; N], bool) {
        let mut times = [f64::INFINITY; N];
        let mut in_contact = false;
        for (lane, time) in times.iter_mut().enumerate() {
            let (dx, dy) = (self.separation[0][lane], self.separation[1][lane]);
            let (vx, vy) = (self.velocity[0][lane], self.velocity[1][lane]);
            let sigma = self.contact_distance[lane];
            let b = dx * vx + dy * vy;
            let c = (dx * dx + dy * dy) - sigma * sigma;
            let cross = self.cross[lane];
            let discriminant = sigma * sigma * (vx * vx + vy * vy) - cross * cross;
            let root = if discriminant > 0.0 {
                discriminant
            } else {
                0.0
            }
            .sqrt();
            let does_not_part = b <= 0.0;
            let closes = does_not_part & (discriminant > 0.0);
            let touching = 4.0 * sigma * (self.separation_error + 8.0 * U * sigma);
            *time = if closes {
                c / (root - b)
            } else {
                f64::INFINITY
            };
            in_contact |= (does_not_part & (c.abs() <= touching)) | (*time < 0.0) | time.is_nan();
        }
        (times, in_contact)
    }

    /// The contact times including pairs that touch or overlap, which [`Self::closed_form`] leaves
    /// undecided.
    #[cold]
    #[inline(never)]
    pub fn decided_times(&self) -> [f64; N] {
        let mut times = [f64::INFINITY; N];
        for (lane, time) in times.iter_mut().enumerate() {
            let d = DVec2::new(self.separation[0][lane], self.separation[1][lane]);
            let v = DVec2::new(self.velocity[0][lane], self.velocity[1][lane]);
            let errors = (self.separation_error, self.velocity_error(lane));
            let contact =
                contact_of_passing(d, v, self.cross[lane], self.contact_distance[lane], errors);
            // A pair whose numbers overflow may touch at once.
            *time = if contact.is_nan() { 0.0 } else { contact };
        }
        times
    }

    /// The times at which the discs enter the circle of the sum of the radii (time from now): 0
    /// inside it, infinite if never. The times are lower bounds, because the circle is enlarged by
    /// the rounding of the positions.
    #[inline(always)]
    pub fn entry_times(&self) -> [f64; N] {
        let mut times = [f64::INFINITY; N];
        for (lane, time) in times.iter_mut().enumerate() {
            let (dx, dy) = (self.separation[0][lane], self.separation[1][lane]);
            let (vx, vy) = (self.velocity[0][lane], self.velocity[1][lane]);
            let distance = dx.abs() + dy.abs();
            let sigma = self.contact_distance[lane];
            let sigma = sigma + (self.separation_error + 16.0 * U * (distance + sigma));
            let b = dx * vx + dy * vy;
            let c = (dx * dx + dy * dy) - sigma * sigma;
            let cross = dx * vy - dy * vx;
            let discriminant = sigma * sigma * (vx * vx + vy * vy) - cross * cross;
            let root = if discriminant > 0.0 {
                discriminant
            } else {
                0.0
            }
            .sqrt();
            let enters = (b < 0.0) & (discriminant > 0.0);
            let later = if enters {
                c / (root - b) * (1.0 - 16.0 * U)
            } else {
                f64::INFINITY
            };
            // An empty lane (NaN) never enters. A lane whose numbers overflow may enter at once.
            let inside = (c <= 0.0) | later.is_nan();
            *time = if inside { 0.0 } else { later };
        }
        times
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::disc::disc_contact;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_lane_equals_the_closed_form_of_its_pair(
            discs in prop::collection::vec((-2.0..2.0f64, -2.0..2.0f64, -1.0..1.0f64, -1.0..1.0f64, 0.1..1.0f64), 1..9),
            touching in any::<bool>(),
        ) {
            let mut lanes = DiscLanes::empty(1e-16, 1.5);
            for (lane, &(x, y, vx, vy, sigma)) in discs.iter().enumerate() {
                let d = DVec2::new(x, y);
                // Some pairs exactly at contact, where the rounding decides.
                let sigma = if touching && lane % 2 == 0 { d.length() } else { sigma };
                lanes.set(lane, d, DVec2::new(vx, vy), sigma);
            }
            let times = lanes.contact_times();
            for (lane, &time) in times.iter().enumerate() {
                let alone = lanes.relative_motion(lane).map_or(f64::INFINITY, |motion| {
                    let errors = (motion.separation_error, motion.velocity_error);
                    disc_contact(motion.separation, motion.velocity, lanes.contact_distance[lane], errors)
                });
                prop_assert_eq!(time.to_bits(), alone.to_bits(), "lane {}", lane);
            }
        }
    }
}
