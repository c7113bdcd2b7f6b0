//! The position of a point relative to an edge.

use glam::DVec2;

/// The position of a point relative to the nearest point of an edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// Distance from the line between the ends (length); negative in the solid behind a half-plane.
    pub distance: f64,
    /// Unit vector from the nearest point of that line to the point; the normal for a point on it.
    pub direction: DVec2,
}
