//! The frame of the centre of mass, whose velocity may change at edits.

use carom_engine::{BodyView, View};
use carom_kinematics::{DragClock, EpochTime};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::Group;

/// The displacement of the frame of the centre of mass, integrated from its velocity between
/// samples.
///
/// The position Σ m x / M would jump when a body is added or removed.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub(crate) struct MovingFrame {
    /// The time from which the velocity is valid; `None` before the first sample.
    since: Option<EpochTime>,
    /// (length / time).
    pub(crate) velocity: DVec2,
    /// Since the first sample (length).
    pub(crate) displacement: DVec2,
    /// The clock of the drag since then.
    clock: DragClock,
}

impl MovingFrame {
    /// Advances to the time of the view. The velocity until then is that of the last view, because
    /// only an edit, which takes no time, changes it.
    pub(crate) fn follow(&mut self, view: &View<'_>) {
        if let Some(since) = self.since {
            let duration = view.time().since(since);
            self.displacement += self.clock.reading(duration) * self.velocity;
        }
        self.since = Some(view.time());
        self.clock = DragClock::new(view.drag());
        self.velocity = view.centre_of_mass_frame().velocity();
    }

    /// The moving bodies of a group in ascending order of number, with their places in this frame
    /// without periodic jumps (length).
    pub(crate) fn places<'a>(
        &self,
        view: &'a View<'_>,
        group: Group,
    ) -> impl Iterator<Item = (BodyView<'a>, DVec2)> {
        let displacement = self.displacement;
        view.bodies()
            .filter(move |view| view.body.is_free() && group.contains(view.body))
            .map(move |body| (body, body.unwrapped(&view.bounds()) - displacement))
    }
}
