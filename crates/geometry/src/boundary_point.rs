//! A point of the boundary of an excluded region: a contact of a round probe with a body.

use glam::DVec2;

/// The part of a body that a probe touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BoundaryPart {
    /// The atom of this index.
    Atom(usize),
    /// The edge of this index.
    Edge(usize),
}

/// A contact of a round probe with a body, in the frame of the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundaryPoint {
    /// The part that is touched.
    pub part: BoundaryPart,
    /// The point that the contact normal passes through inside the body (length): the centre of the
    /// atom, or the nearest point of the line between the centres of the edge's atoms.
    pub foot: DVec2,
    /// Distance of the probe's centre from the foot (length).
    pub radius: f64,
    /// Direction of the outward normal (radians, counter-clockwise from +x).
    pub normal: f64,
}

impl BoundaryPoint {
    /// The position of the probe's centre (length).
    pub fn position(&self) -> DVec2 {
        self.foot + self.radius * DVec2::from_angle(self.normal)
    }

    /// The lever arm r × n of the contact about the origin of the frame (length). All points on the
    /// line along the normal have the same.
    pub fn lever(&self) -> f64 {
        self.foot.perp_dot(DVec2::from_angle(self.normal))
    }
}
