//! The frame (x′, y′) of a body, which turns with it (Montanari 2017, figure 3.4).

use carom_engine::{BodyView, View};
use carom_kinematics::Orientation;
use glam::DVec2;

/// Components along x′ and y′ of a vector in the frame of the box: a rotation by −θ.
pub(crate) fn in_body_frame(vector: DVec2, orientation: Orientation) -> DVec2 {
    let DVec2 { x: cos, y: sin } = orientation.cos_sin();
    DVec2::new(cos, -sin).rotate(vector)
}

/// The axis x′ of a body, a unit vector: of a molecule that is not round its own, of a round one
/// that of its self-propulsion. `None` for walls, and for other round bodies.
pub(crate) fn axis_of(view: &View<'_>, body: &BodyView<'_>) -> Option<DVec2> {
    if body.body.is_wall() {
        return None;
    }
    if body.body.molecule().is_round() {
        return view.axis(body.body.key()).map(Orientation::cos_sin);
    }
    Some(body.motion.orientation.cos_sin())
}
