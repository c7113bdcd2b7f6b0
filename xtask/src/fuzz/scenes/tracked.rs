//! A body as its last report describes it.

use std::borrow::Cow;

use carom::engine::{BodyView, WallMotionSpec};

use super::kinematics::{BodyOutline, BodyPair, BodyState, Placed, along, dot, rotated};

/// Last reported state of a body; of a wall that oscillates, that at which it began to.
#[derive(Debug, Clone)]
pub(super) struct Tracked {
    pub(super) outline: BodyOutline,
    pub(super) state: BodyState,
    /// Epoch of the report.
    pub(super) epoch: u64,
    pub(super) fixed: bool,
    pub(super) tags: Vec<String>,
    pub(super) mass: f64,
}

/// The motion that a wall is given.
#[derive(Debug, Clone, Copy)]
pub(super) struct GivenMotion<'a> {
    pub(super) motion: &'a WallMotionSpec,
    /// The middle of the wall before; `None` if it is not known (length).
    pub(super) middle: Option<BodyPair>,
}

impl Tracked {
    /// The middle of a wall (length).
    pub(super) fn middle(&self, placed: Placed) -> BodyPair {
        let middle = self.outline.edges.first().map(|edge| edge.middle);
        along(
            placed.place,
            1.0,
            rotated(middle.unwrap_or_default(), placed.rotation),
        )
    }
}

/// Kinetic energy of a body (mass × length² / time²).
pub(super) fn energy(body: &BodyView<'_>) -> f64 {
    let (motion, inertia) = (&body.motion, body.body.inertia());
    let of = |inverse: f64, squared: f64| {
        if inverse > 0.0 {
            0.5 * squared / inverse
        } else {
            0.0
        }
    };
    let velocity = motion.velocity.to_array();
    let spin = motion.angular_velocity;
    of(inertia.inverse_mass, dot(velocity, velocity)) + of(inertia.inverse_moment, spin * spin)
}

/// The outline with which a body touches others that it sees at this factor of the distance.
pub(super) fn outline_for(body: &Tracked, factor: f64) -> Cow<'_, BodyOutline> {
    if factor == 1.0 {
        Cow::Borrowed(&body.outline)
    } else {
        Cow::Owned(body.outline.scaled(factor))
    }
}
