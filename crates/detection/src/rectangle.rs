//! Until when discs are certainly beyond a side of the rectangle that holds a turning molecule.
//!
//! Seen by an observer who turns with the molecule (angular velocity ω), a centre that moves with V relative to its centre of
//! mass is at p = R⁻¹ d, with p' = R⁻¹ V − ω J p and p'' = −R⁻¹ (2 ω J V + ω² d), J being the quarter turn. So for the
//! outward normal n of a side that is w from the centre of mass, and a disc of radius r, the distance s = n·p − w − r
//! has for all h ≤ H
//!
//! s(h) ≥ s + s' h − K h²/2,  K = 2 |ω| |V| + ω² (|d| + |V| H),
//!
//! and the disc is apart from the molecule as long as that is positive: the molecule is behind its side. It is one certified
//! step, like those of [`Exact`](crate::Exact), from a bound that is far tighter for rods than their circle is.
//!
//! **Rounding.** d is known to within the error e of the lanes and R to within an angle δ: p is off by e + δ |d|, p' by
//! the error of V and |ω| e + δ (|V| + |ω| |d|). There are less than 32 roundings in s and in s' each, and the sides are
//! off by one. Twice as much is taken off each.

use carom_geometry::Outline;
use carom_kinematics::{HALF_ULP as U, Motion};
use glam::DVec2;

use crate::{DiscLanes, tolerance::STEP_MARGIN};

/// A body that asks for its contacts with others, as it is turned now.
#[derive(Debug, Clone, Copy)]
pub struct Asker<'a> {
    /// Its shape.
    pub outline: Outline<'a>,
    /// (cos θ, sin θ).
    pub rotation: DVec2,
    /// Bound on the error of θ (radians).
    pub rotation_error: f64,
    /// Radians per time.
    pub angular_velocity: f64,
}

impl<'a> Asker<'a> {
    /// A body of this shape and motion at `now` (time).
    #[inline]
    pub fn new(outline: Outline<'a>, motion: &Motion, now: f64) -> Self {
        let angular_velocity = motion.angular_velocity;
        let duration = now - motion.time;
        Self {
            outline,
            rotation: motion.orientation.turned(angular_velocity, duration).cos_sin(),
            // As for a relative motion, and the rounding of cosine and sine.
            rotation_error: U * (4.0 * (angular_velocity * duration).abs() + 8.0),
            angular_velocity,
        }
    }

    /// When each of some bodies may touch this one at the soonest (time from now), as far as their circles and its
    /// rectangle tell: infinite for never. Steps beyond `horizon` say no more than that it is not before.
    #[inline(always)]
    #[expect(
        clippy::inline_always,
        reason = "it must be compiled with the vector instructions of its caller"
    )]
    pub(crate) fn apart_until<const N: usize>(&self, lanes: &DiscLanes<N>, horizon: f64) -> [f64; N] {
        let mut times = lanes.entry_times();
        let Some([low, high]) = self.outline.rectangle() else { return times };
        let (cos, sin) = (self.rotation.x, self.rotation.y);
        let spin = self.angular_velocity;
        for (lane, time) in times.iter_mut().enumerate() {
            let (dx, dy) = (lanes.separation[0][lane], lanes.separation[1][lane]);
            let (vx, vy) = (lanes.velocity[0][lane], lanes.velocity[1][lane]);
            let reach = lanes.contact_distance[lane];
            let radius = reach - self.outline.bounding_radius;
            let (px, py) = (cos * dx + sin * dy, cos * dy - sin * dx);
            let (ux, uy) = ((cos * vx + sin * vy) + spin * py, (cos * vy - sin * vx) - spin * px);
            let distance = dx.abs() + dy.abs();
            let speed = vx.abs() + vy.abs();
            let error =
                lanes.separation_error + self.rotation_error * distance + 64.0 * U * (distance + reach);
            let rate_error = lanes.velocity_error(lane)
                + spin.abs() * lanes.separation_error
                + (self.rotation_error + 64.0 * U) * (speed + spin.abs() * distance);
            let bend = 2.0 * spin.abs() * speed + spin * spin * (distance + speed * horizon);
            let step = |behind: f64, beyond: f64, rate: f64| {
                let is_beyond = beyond > behind;
                let gap = (if is_beyond { beyond } else { behind }) - radius - error;
                let rate = (if is_beyond { rate } else { -rate }) - rate_error;
                let gap = if gap > 0.0 { gap } else { 0.0 };
                let root = (rate * rate + 2.0 * bend * gap).sqrt() * (1.0 + STEP_MARGIN);
                2.0 * gap / (root - rate) * (1.0 - STEP_MARGIN)
            };
            // What is no number is not later.
            let across = step(low.y - py, py - high.y, uy);
            *time = if across > *time { across } else { *time };
            let along = step(low.x - px, px - high.x, ux);
            *time = if along > *time { along } else { *time };
        }
        times
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Detection, Exact};
    use carom_geometry::{Molecule, Shape};
    use carom_kinematics::{Orientation, RelativeMotion};
    use proptest::prelude::*;

    proptest! {
        /// The contact that is found is never before the bound, and the bound is worth something.
        #[test]
        fn no_contact_is_before_the_bound(
            count in 2usize..20, turns in -0.5..0.5f64, spin in -3.0..3.0f64, since in 0.0..10.0f64,
            places in prop::array::uniform8((-8.0..8.0f64, -8.0..8.0f64, -2.0..2.0f64, -2.0..2.0f64)),
            horizon in 0.1..4.0f64,
        ) {
            let rod = Molecule::named(Shape::Rod(count), 0.25, 1.0).unwrap();
            let disc = Molecule::disc(0.5, 1.0).unwrap();
            let motion = Motion {
                orientation: Orientation::from_turns(turns),
                angular_velocity: spin,
                ..Motion::at_rest(DVec2::ZERO)
            };
            let asker = Asker::new(rod.outline(), &motion, since);
            let mut lanes = DiscLanes::empty(0.0, 0.0);
            for (lane, (x, y, vx, vy)) in places.into_iter().enumerate() {
                lanes.set(lane, DVec2::new(x, y), DVec2::new(vx, vy), rod.bounding_radius() + 0.5);
            }
            let bounds = Exact::default().apart_until(&asker, &lanes, horizon);
            let entries = lanes.entry_times();
            for (lane, (x, y, vx, vy)) in places.into_iter().enumerate() {
                let pair = RelativeMotion {
                    orientation: [motion.orientation.turned(spin, since), Orientation::default()],
                    angular_velocity: [spin, 0.0],
                    ..RelativeMotion::exactly(DVec2::new(x, y), DVec2::new(vx, vy))
                };
                prop_assert!(bounds[lane] >= entries[lane]);
                let found = Exact::default().first_contact(rod.outline(), disc.outline(), &pair, horizon);
                if let Some(contact) = found.outcome.contact() {
                    prop_assert!(contact.time >= bounds[lane].min(horizon), "{contact:?} {}", bounds[lane]);
                }
            }
        }
    }

    #[test]
    fn a_disc_beside_a_resting_rod_is_apart_until_it_comes_to_its_side() {
        let rod = Molecule::named(Shape::Rod(50), 0.25, 1.0).unwrap();
        let asker = Asker::new(rod.outline(), &Motion::at_rest(DVec2::ZERO), 0.0);
        let mut lanes = DiscLanes::empty(0.0, 0.0);
        lanes.set(0, DVec2::new(3.0, 2.75), DVec2::new(0.3, -1.0), rod.bounding_radius() + 0.5);
        assert_eq!(lanes.entry_times()[0], 0.0);
        let bound = Exact::default().apart_until(&asker, &lanes, 10.0)[0];
        assert!((bound - 2.0).abs() < 1e-12, "{bound}");
    }
}
