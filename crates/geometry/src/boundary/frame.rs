//! The frame of a bar: x along it from its first end, y to the left.

use glam::DVec2;

use crate::{exposed_side::EdgeSide, union::Union};

/// A bar with its frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    pub index: usize,
    /// Indices of the circles at the ends, and their centres (length).
    pub ends: [usize; 2],
    pub centres: [DVec2; 2],
    /// From the first centre to the second (length), its direction, and its length.
    pub span: DVec2,
    pub along: DVec2,
    pub length: f64,
    /// Half the width (length).
    pub radius: f64,
}

/// A circle in the frame of a bar.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlacedCircle {
    pub centre: DVec2,
    pub radius: f64,
    /// Uncertainty of the centre (length): a circle that crosses a line by less touches it.
    pub slack: f64,
}

impl Frame {
    /// The frames of all bars of a union; bars between two circles in one place are empty.
    pub fn all(union: &Union) -> Vec<Self> {
        let frame = |index: usize| {
            let bar = union.bars[index];
            let ends = bar.ends.map(|end| end as usize);
            let centres = ends.map(|end| union.circles[end].0);
            let span = centres[1] - centres[0];
            Self {
                index,
                ends,
                centres,
                span,
                along: span.normalize_or_zero(),
                length: span.length(),
                radius: bar.radius,
            }
        };
        (0..union.bars.len())
            .map(frame)
            .filter(|frame| frame.length > 0.0)
            .collect()
    }

    /// A circle of the union in this frame. Those at the ends are there without rounding, so that
    /// a bar as wide as its end disc meets it in a tangent.
    pub fn place(&self, circle: usize, (centre, radius): (DVec2, f64)) -> PlacedCircle {
        let place = |centre, slack| PlacedCircle {
            centre,
            radius,
            slack,
        };
        if circle == self.ends[0] {
            return place(DVec2::ZERO, 0.0);
        }
        if circle == self.ends[1] {
            return place(DVec2::new(self.length, 0.0), 0.0);
        }
        let from_start = centre - self.centres[0];
        let size = centre.length() + self.centres[0].length() + self.length + self.radius + radius;
        place(
            DVec2::new(self.along.dot(from_start), self.along.perp_dot(from_start)),
            8.0 * f64::EPSILON * size,
        )
    }

    /// The point of a side at `x` along the bar (length).
    pub fn point(&self, side: EdgeSide, x: f64) -> DVec2 {
        let foot = if x == self.length {
            self.centres[1]
        } else {
            self.centres[0] + x * self.along
        };
        foot + self.radius * self.outward(side)
    }

    /// The outward normal of a side.
    pub fn outward(&self, side: EdgeSide) -> DVec2 {
        sign(side) * self.along.perp()
    }
}

impl PlacedCircle {
    /// Half the chord that a line at this signed distance from the centre cuts out of the disc
    /// (length); `None` if it does not cross the circle.
    ///
    /// The arcs and the sides both take it from here, so they end at one point to rounding.
    pub fn half_chord(&self, distance: f64) -> Option<f64> {
        let (radius, slack) = (self.radius, self.slack);
        (distance.abs() < radius - slack)
            .then(|| ((radius + distance) * (radius - distance)).sqrt())
    }
}

/// +1 on the left, where y is positive, and −1 on the right.
pub(super) fn sign(side: EdgeSide) -> f64 {
    match side {
        EdgeSide::Left => 1.0,
        EdgeSide::Right => -1.0,
    }
}
