//! An edge: the part of a body between two of its atoms, a straight or bent wall between its end
//! points, or the border of a half-plane.

use glam::DVec2;

use crate::{Bend, GeometryError, Nearest, check_length, check_positive};

/// A thick edge, fixed in the frame of its body: straight, or bent into an arc of a circle
/// ([`Self::bend`]).
///
/// All points within [`Self::radius`] of the line between its ends belong to it. Both its sides can
/// be touched. Its ends are atoms of the body ([`Self::ends`]) with radii at least as large; a wall
/// across the whole box and a whole circle have no ends, and a half-plane is solid behind its
/// border. Only walls are bent.
///
/// ```
/// use carom_geometry::Molecule;
/// use glam::DVec2;
///
/// // A capsule: two atoms of radius 0.5, and an edge of length 2 between them.
/// let capsule = Molecule::capsule(2.0, 0.5, 1.0)?;
/// let [edge] = capsule.edges() else { panic!("it has one edge") };
/// assert_eq!((edge.ends(), edge.half_length(), edge.radius()), (Some([0, 1]), 1.0, 0.5));
/// assert_eq!(edge.nearest(DVec2::new(0.3, -2.0)).distance, 2.0);
/// # Ok::<(), carom_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[doc(alias = "face")]
#[doc(alias = "segment")]
pub struct Edge {
    ends: Option<[u32; 2]>,
    /// The vector from end to end, from which direction and length follow.
    span: DVec2,
    middle: DVec2,
    along: DVec2,
    half_length: f64,
    reach: f64,
    radius: f64,
    solid_behind: bool,
    bend: Option<Bend>,
}

impl Edge {
    /// An edge through the origin with the given span, from end to end (length), and half thickness
    /// `radius` (length, may be 0), without atoms at its ends.
    pub(crate) fn of_wall(span: DVec2, radius: f64) -> Result<Self, GeometryError> {
        check_length("the x extent of a wall", span.x)?;
        check_length("the y extent of a wall", span.y)?;
        let length = check_positive("the length of a wall", span.length())?;
        if radius != 0.0 {
            check_positive("the radius of a wall", radius)?;
        }
        Ok(Self {
            ends: None,
            span,
            middle: DVec2::ZERO,
            along: span / length,
            half_length: 0.5 * length,
            reach: 0.5 * length,
            radius,
            solid_behind: false,
            bend: None,
        })
    }

    /// An edge of half thickness `radius` (length) between the centres of two atoms, given with
    /// their indices.
    pub(crate) fn between(
        [(first, from), (second, to)]: [(u32, DVec2); 2],
        radius: f64,
    ) -> Result<Self, GeometryError> {
        let span = to - from;
        let length = check_positive("the length of an edge", span.length())?;
        check_positive("the radius of an edge", radius)?;
        // The largest distance from a point of a line is that of an end.
        let reach = from.length().max(to.length()) * (1.0 + 4.0 * f64::EPSILON);
        Ok(Self {
            ends: Some([first, second]),
            span,
            middle: 0.5 * (from + to),
            along: span / length,
            half_length: 0.5 * length,
            reach,
            radius,
            solid_behind: false,
            bend: None,
        })
    }

    /// An arc of half thickness `radius` (length, may be 0), whose circle has its centre at the
    /// origin, without atoms at its ends.
    pub(crate) fn of_bend(bend: Bend, radius: f64) -> Result<Self, GeometryError> {
        if radius != 0.0 {
            check_positive("the radius of a wall", radius)?;
        }
        let of_circle = bend.radius();
        if radius >= of_circle {
            return Err(GeometryError::Bend {
                what: "half the thickness of an arc",
                value: radius,
                range: "below the radius of its circle",
            });
        }
        let [from, to] = bend.ends();
        Ok(Self {
            ends: None,
            span: to - from,
            middle: of_circle * bend.direction(),
            along: -bend.direction().perp(),
            half_length: of_circle * bend.half_angle(),
            reach: of_circle,
            radius,
            solid_behind: false,
            bend: Some(bend),
        })
    }

    /// This edge with its middle at `middle` (length).
    pub(crate) fn with_middle(self, middle: DVec2) -> Self {
        let half = 0.5 * self.span;
        let reach = (middle - half).length().max((middle + half).length());
        Self {
            middle,
            reach: reach * (1.0 + 4.0 * f64::EPSILON),
            ..self
        }
    }

    /// This edge with the first two atoms of its body at its ends.
    pub(crate) fn with_ends(self) -> Self {
        Self {
            ends: Some([0, 1]),
            ..self
        }
    }

    /// The `span` given to [`Self::of_wall`].
    pub(crate) fn span(&self) -> DVec2 {
        self.span
    }

    /// Indices of the atoms at its ends, the second in the direction of [`Self::along`]; `None` for
    /// a wall across the box and a half-plane.
    pub fn ends(&self) -> Option<[u32; 2]> {
        self.ends
    }

    /// Whether it is a straight edge without ends: a wall across the box, whose next image begins
    /// where it ends, or a half-plane.
    pub fn is_line(&self) -> bool {
        self.ends.is_none() && self.bend.is_none()
    }

    /// The middle of the line between the ends, in the frame of the body (length); the origin for a
    /// half-plane and a straight wall without a pivot.
    pub fn middle(&self) -> DVec2 {
        self.middle
    }

    /// The circle of which a bent edge is an arc, about the origin; `None` for a straight edge.
    #[inline]
    pub fn bend(&self) -> Option<&Bend> {
        self.bend.as_ref()
    }

    /// Its ends, in the frame of the body (length).
    pub(crate) fn segment(&self) -> [DVec2; 2] {
        if let Some(bend) = &self.bend {
            return bend.ends();
        }
        let half = self.half_length * self.along;
        [self.middle - half, self.middle + half]
    }

    /// Unit vector along the edge, at its middle.
    pub fn along(&self) -> DVec2 {
        self.along
    }

    /// Unit vector normal to the edge at its middle: a quarter turn counter-clockwise from
    /// [`Self::along`]; for a half-plane, out of the solid; for an arc, away from its centre.
    pub fn normal(&self) -> DVec2 {
        self.along.perp()
    }

    /// Extent to either side of the middle, along the edge (length); infinite for a half-plane.
    pub fn half_length(&self) -> f64 {
        self.half_length
    }

    /// Half its thickness (length); 0 for a wall without thickness.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Whether everything behind the edge is solid, as with a half-plane; other edges can be
    /// touched on both sides.
    pub fn is_solid_behind(&self) -> bool {
        self.solid_behind
    }

    /// Distance of its farthest point, without its thickness, from the origin of the body's frame
    /// (length), rounded up.
    pub fn reach(&self) -> f64 {
        self.reach
    }

    /// The position of `place` (in the frame of the edge's body, length) relative to the nearest
    /// point of the edge.
    pub fn nearest(&self, place: DVec2) -> Nearest {
        self.nearest_to_rounding(place, 0.0)
    }

    /// As [`Self::nearest`], but a place beyond an end by at most `rounding` (length) counts as
    /// beside the edge.
    pub fn nearest_to_rounding(&self, place: DVec2, rounding: f64) -> Nearest {
        if let Some(bend) = &self.bend {
            return bend.nearest(place, rounding);
        }
        let place = place - self.middle;
        let (along, across) = (self.along.dot(place), self.normal().dot(place));
        if along.abs() > self.half_length + rounding {
            let from_end = place - (self.half_length * along.signum()) * self.along;
            let distance = from_end.length();
            let direction = if distance > 0.0 {
                from_end / distance
            } else {
                self.normal()
            };
            Nearest {
                distance,
                direction,
            }
        } else if self.solid_behind || across >= 0.0 {
            Nearest {
                distance: across,
                direction: self.normal(),
            }
        } else {
            Nearest {
                distance: -across,
                direction: -self.normal(),
            }
        }
    }
}

/// The half-plane behind a straight line: a body for detection, without a bounding circle.
///
/// ```
/// use carom_geometry::HalfPlane;
/// use glam::DVec2;
///
/// // The ground.
/// let ground = HalfPlane::new(DVec2::Y)?;
/// let [border] = ground.outline().edges() else { panic!("it has nothing else") };
/// assert_eq!(border.nearest(DVec2::new(7.0, 2.0)).distance, 2.0);
/// assert_eq!(border.nearest(DVec2::new(7.0, -2.0)).distance, -2.0);
/// # Ok::<(), carom_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfPlane {
    pub(crate) border: Edge,
}

impl HalfPlane {
    /// The half-plane whose border goes through the origin, with `normal` (any length but 0) out of
    /// it.
    ///
    /// # Errors
    /// [`GeometryError`] if the normal is zero, NaN or infinite.
    pub fn new(normal: DVec2) -> Result<Self, GeometryError> {
        let border = Edge::of_wall(-normal.perp(), 0.0)?;
        Ok(Self {
            border: Edge {
                half_length: f64::INFINITY,
                reach: f64::INFINITY,
                solid_behind: true,
                ..border
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Molecule, gap_between};
    use parry2d_f64::{
        math::Pose,
        query::PointQuery,
        shape::{Ball, Segment},
    };
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn distances_agree_with_parry(
            x in -2.0..2.0f64, y in -2.0..2.0f64, u in 0.1..2.0f64, angle in -3.2..3.2f64, radius in 0.0..0.3f64,
        ) {
            let (span, place) = (u * DVec2::from_angle(angle), DVec2::new(x, y));
            let edge = Edge::of_wall(span, radius).unwrap();
            let oracle = Segment::new(-0.5 * span, 0.5 * span);
            let nearest = edge.nearest(place);
            let pose = Pose::identity();
            prop_assert!((nearest.distance - oracle.distance_to_point(&pose, place, true)).abs() < 1e-14);
            let foot = place - nearest.distance * nearest.direction;
            prop_assert!(oracle.distance_to_point(&pose, foot, true) < 1e-14);
            // Equal to the gap of a disc there.
            let (wall, disc) = (Molecule::wall(span, radius).unwrap(), Molecule::disc(0.1, 1.0).unwrap());
            let gap = gap_between(&disc, DVec2::X, &wall, DVec2::X, -place);
            prop_assert!((gap - (nearest.distance - radius - Ball::new(0.1).radius)).abs() < 1e-14);
            prop_assert_eq!(gap, gap_between(&wall, DVec2::X, &disc, DVec2::X, place));
        }
    }

    #[test]
    fn invalid_walls_are_refused() {
        for (span, radius) in [
            (DVec2::ZERO, 0.0),
            (DVec2::NAN, 0.0),
            (DVec2::INFINITY, 0.0),
            (DVec2::X, -0.1),
            (DVec2::X, f64::NAN),
            (1e-61 * DVec2::X, 0.0),
        ] {
            assert!(
                Molecule::wall(span, radius).is_err(),
                "span {span}, radius {radius}"
            );
            assert!(
                Molecule::wall_without_ends(span, radius).is_err(),
                "span {span}, radius {radius}"
            );
        }
        assert!(HalfPlane::new(DVec2::ZERO).is_err());
        assert!(HalfPlane::new(DVec2::NAN).is_err());
    }
}
