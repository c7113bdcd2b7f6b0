//! The frame of the centre of mass, whose velocity may change at edits, and under shear the flow.

use carom_engine::{BodyView, CollisionReport, View};
use carom_geometry::PeriodicBox;
use carom_kinematics::{DragClock, EpochTime, Motion};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{Group, flow_displacement::FlowDisplacement};

/// The displacement of the frame of the centre of mass, integrated from its velocity between
/// samples.
///
/// The position Σ m x / M would jump when a body is added or removed.
///
/// Under shear places and velocities are relative to the flow in addition. An observer that has
/// such a frame forwards [`Self::is_flowing`] as `watches_any`, and its contacts to
/// [`Self::collide`]; without a shear it needs no contacts.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct MovingFrame {
    /// The time from which the velocity is valid; `None` before the first sample.
    since: Option<EpochTime>,
    /// (length / time).
    pub(crate) velocity: DVec2,
    /// Since the first sample (length).
    pub(crate) displacement: DVec2,
    /// The clock of the drag since then.
    clock: DragClock,
    /// The flow of a sheared box; `None` if there has been no shear.
    flow: Option<FlowDisplacement>,
}

impl MovingFrame {
    /// Advances to the time of the view. The velocity until then is that of the last view, because
    /// only an edit, which takes no time, changes it; under shear the part along x changes with the
    /// place along y.
    pub(crate) fn follow(&mut self, view: &View<'_>) {
        if let Some(since) = self.since {
            let duration = view.time().since(since);
            self.displacement += self.clock.reading(duration) * self.velocity;
            if let Some(flow) = &self.flow {
                self.displacement.x += flow.change_by_drift(self.velocity.y, duration);
            }
        }
        self.since = Some(view.time());
        self.clock = DragClock::new(view.drag());
        self.velocity = view.centre_of_mass_frame().velocity();
        if view.is_sheared() || self.flow.is_some() {
            self.flow.get_or_insert_default().follow(view);
        }
    }

    /// Whether bodies are in a flow, so that [`Self::collide`] must receive all contacts. It
    /// changes in [`Self::follow`] alone.
    #[inline]
    pub(crate) fn is_flowing(&self) -> bool {
        self.flow.as_ref().is_some_and(FlowDisplacement::is_flowing)
    }

    /// Follows a contact in a flow.
    pub(crate) fn collide(&mut self, report: &CollisionReport<'_>) {
        if let Some(flow) = &mut self.flow {
            flow.collide(report);
        }
    }

    /// The moving bodies of a group in ascending order of number, with their places in this frame
    /// without periodic jumps (length). The view is that of the last [`Self::follow`].
    pub(crate) fn places<'a>(
        &'a self,
        view: &'a View<'_>,
        group: Group,
    ) -> impl Iterator<Item = (BodyView<'a>, DVec2)> {
        let bounds = view.bounds();
        view.bodies()
            .filter(move |view| view.body.is_free() && group.contains(view.body))
            .map(move |body| (body, self.place(&body, &bounds)))
    }

    /// The place of a body in this frame without periodic jumps (length), in the view of the last
    /// [`Self::follow`].
    pub(crate) fn place(&self, body: &BodyView<'_>, bounds: &PeriodicBox) -> DVec2 {
        let mut place = body.unwrapped(bounds) - self.displacement;
        if let Some(flow) = &self.flow {
            place.x -= flow.carried(body.body.id());
        }
        place
    }

    /// The velocity of a motion in the box relative to this frame, under shear also to the flow
    /// (length / time).
    pub(crate) fn relative(&self, motion: &Motion) -> DVec2 {
        let mut velocity = motion.velocity;
        if let Some(flow) = &self.flow {
            velocity.x = flow.relative(motion);
        }
        velocity - self.velocity
    }
}
