//! The frame (x′, y′) of a body, which turns with it (Montanari 2017, figure 3.4).

use carom_kinematics::Orientation;
use glam::DVec2;

/// Components along x′ and y′ of a vector in the frame of the box: a rotation by −θ.
pub(crate) fn in_body_frame(vector: DVec2, orientation: Orientation) -> DVec2 {
    let DVec2 { x: cos, y: sin } = orientation.cos_sin();
    DVec2::new(cos, -sin).rotate(vector)
}
