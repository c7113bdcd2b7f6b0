//! One disc against eight others at once: the closed form of the contact time, written for vector registers.

use carom_kinematics::HALF_ULP as U;
use glam::DVec2;

use crate::disc_contact;

/// How many discs are asked for at once.
pub const DISC_LANES: usize = 8;

/// One disc against up to eight others, as seen from it at a common time 0. A lane with NaN in it has no disc.
#[derive(Debug, Clone, Copy)]
pub struct DiscLanes {
    /// Places of the others relative to the asking disc (length), x then y.
    pub separation: [[f64; DISC_LANES]; 2],
    /// Their velocities relative to it (length per time), x then y.
    pub velocity: [[f64; DISC_LANES]; 2],
    /// Sums of the two radii (length).
    pub contact_distance: [f64; DISC_LANES],
    /// Bound on the rounding of the places (length).
    pub separation_error: f64,
    /// |vx| + |vy| of the asking disc (length per time).
    pub speed: f64,
}

impl DiscLanes {
    /// When each disc is first touched (time from now), infinite for never.
    ///
    /// The same numbers as [`disc_contact`](crate::disc_contact), operation by operation, whatever the width of
    /// the registers. Of the velocities' resolution only a bound is known here: the other disc is no faster than
    /// the asking one and the relative velocity together.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "it must be compiled with the vector instructions of its caller")]
    pub fn contact_times(&self) -> [f64; DISC_LANES] {
        let mut times = [f64::INFINITY; DISC_LANES];
        let mut in_contact = false;
        for (lane, time) in times.iter_mut().enumerate() {
            let (dx, dy) = (self.separation[0][lane], self.separation[1][lane]);
            let (vx, vy) = (self.velocity[0][lane], self.velocity[1][lane]);
            let sigma = self.contact_distance[lane];
            let b = dx * vx + dy * vy;
            let c = (dx * dx + dy * dy) - sigma * sigma;
            let cross = dx * vy - dy * vx;
            let discriminant = sigma * sigma * (vx * vx + vy * vy) - cross * cross;
            let root = if discriminant > 0.0 { discriminant } else { 0.0 }.sqrt();
            let closes = (b < 0.0) & (discriminant > 0.0);
            in_contact |= closes & (c <= 4.0 * sigma * (self.separation_error + 8.0 * U * sigma));
            *time = if closes { c / (root - b) } else { f64::INFINITY };
        }
        if in_contact {
            self.decide_contacts(&mut times);
        }
        times
    }

    /// Decides about pairs that touch to rounding, or overlap, while they seem to close: rare, hence apart.
    #[cold]
    fn decide_contacts(&self, times: &mut [f64; DISC_LANES]) {
        for (lane, time) in times.iter_mut().enumerate() {
            let d = DVec2::new(self.separation[0][lane], self.separation[1][lane]);
            let v = DVec2::new(self.velocity[0][lane], self.velocity[1][lane]);
            let resolved = 2.0 * U * (2.0 * self.speed + (v.x.abs() + v.y.abs()));
            *time = disc_contact(d, v, self.contact_distance[lane], (self.separation_error, resolved));
        }
    }

    /// When each disc enters the circle of the sum of the radii (time from now): 0 if it is inside, infinite if
    /// it never enters. Never too late, as the circle is inflated by the rounding of the places.
    #[inline(always)]
    #[expect(
        clippy::inline_always,
        reason = "it must be compiled with the vector instructions of its caller"
    )]
    pub fn entry_times(&self) -> [f64; DISC_LANES] {
        let mut times = [f64::INFINITY; DISC_LANES];
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
            let root = if discriminant > 0.0 { discriminant } else { 0.0 }.sqrt();
            let enters = (b < 0.0) & (discriminant > 0.0);
            let later = if enters { c / (root - b) * (1.0 - 16.0 * U) } else { f64::INFINITY };
            // Written so that a lane with NaN stays out.
            let inside = c <= 0.0;
            *time = if inside { 0.0 } else { later };
        }
        times
    }
}
