//! The range of a drag of all bodies.

use carom_geometry::MAX_MAGNITUDE;
use carom_kinematics::DragClock;

use crate::scene::{StageSpec, error::SceneError};

/// The clock of a drag γ (1/time) from 0 to 10⁶⁰.
pub(crate) fn drag_clock(entry: &str, drag: f64) -> Result<DragClock, SceneError> {
    // False for NaN.
    if (0.0..=MAX_MAGNITUDE).contains(&drag) {
        return Ok(DragClock::new(drag));
    }
    Err(SceneError::Entry {
        entry: entry.to_owned(),
        problem: format!(
            "a drag must be from 0 to {MAX_MAGNITUDE:e} (1/time), but is {drag}; leave it out for none, and let a \
             thermostat heat bodies"
        ),
    })
}

impl StageSpec {
    /// The clock of the drag from this stage on; `None` if the stage does not change it. `entry`
    /// names the stage in errors.
    ///
    /// # Errors
    /// [`SceneError::Entry`] if the drag is not from 0 to 10⁶⁰.
    pub fn drag_clock(&self, entry: &str) -> Result<Option<DragClock>, SceneError> {
        self.drag
            .map(|drag| drag_clock(&format!("{entry}.drag"), drag))
            .transpose()
    }
}
