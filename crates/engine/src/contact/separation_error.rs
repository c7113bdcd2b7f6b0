//! The rounding of the separation of two bodies, in whichever way a scheduler stores their motions.

use carom_kinematics::HALF_ULP;

use crate::{contact::limits::sides_per_epoch, world::World};

/// Bound on the rounding of the separation of two bodies within an epoch (length).
///
/// The separation is (x − x′) + (v − v′) t + image. Each term is at most two sides long for each
/// side of the box that the fastest body travels in an epoch.
pub fn separation_error(world: &World) -> f64 {
    HALF_ULP * 16.0 * (sides_per_epoch(world) * world.bounds().sides().element_sum())
}
