//! A straight face: the part of a wall between its end points, or the border of a half-plane.

use glam::DVec2;

use crate::{GeometryError, check_length, check_positive};

/// A straight face through the origin of its body's frame.
///
/// The face of a wall reflects on both sides; a half-plane is solid behind its face. All points
/// within [`Self::radius`] of the face belong to it, so that a wall may have a thickness, with
/// rounded ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Face {
    /// The vector from end to end, from which all other fields follow.
    span: DVec2,
    along: DVec2,
    half_length: f64,
    radius: f64,
    solid_behind: bool,
}

/// The position of a point relative to the nearest point of a face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// Distance from the face (length); negative in the solid behind it.
    pub distance: f64,
    /// Unit vector from the nearest point of the face to the point; the normal for a point on the
    /// face.
    pub direction: DVec2,
}

impl Face {
    /// The face of a wall with the given span, from end to end (length), and half thickness
    /// `radius` (length, may be 0).
    pub(crate) fn of_wall(span: DVec2, radius: f64) -> Result<Self, GeometryError> {
        check_length("the x extent of a wall", span.x)?;
        check_length("the y extent of a wall", span.y)?;
        let length = check_positive("the length of a wall", span.length())?;
        if radius != 0.0 {
            check_positive("the radius of a wall", radius)?;
        }
        Ok(Self {
            span,
            along: span / length,
            half_length: 0.5 * length,
            radius,
            solid_behind: false,
        })
    }

    /// The `span` given to [`Self::of_wall`].
    pub(crate) fn span(&self) -> DVec2 {
        self.span
    }

    /// Unit vector along the face.
    pub fn along(&self) -> DVec2 {
        self.along
    }

    /// Unit vector normal to the face: a quarter turn counter-clockwise from [`Self::along`], out
    /// of the solid.
    pub fn normal(&self) -> DVec2 {
        self.along.perp()
    }

    /// Extent to either side of the origin (length); infinite for a half-plane.
    pub fn half_length(&self) -> f64 {
        self.half_length
    }

    /// Half its thickness (length); 0 for a face without thickness.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Whether everything behind the face is solid, as with a half-plane; a wall reflects on both
    /// sides.
    pub fn is_solid_behind(&self) -> bool {
        self.solid_behind
    }

    /// The position of `place` (in the frame of the face's body, length) relative to the nearest
    /// point of the face.
    pub fn nearest(&self, place: DVec2) -> Nearest {
        self.nearest_to_rounding(place, 0.0)
    }

    /// As [`Self::nearest`], but a place beyond an end by at most `rounding` (length) counts as
    /// beside the face.
    pub fn nearest_to_rounding(&self, place: DVec2, rounding: f64) -> Nearest {
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
/// let face = ground.outline().face().expect("it has nothing else");
/// assert_eq!(face.nearest(DVec2::new(7.0, 2.0)).distance, 2.0);
/// assert_eq!(face.nearest(DVec2::new(7.0, -2.0)).distance, -2.0);
/// # Ok::<(), carom_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfPlane {
    pub(crate) face: Face,
}

impl HalfPlane {
    /// The half-plane whose border goes through the origin, with `normal` (any length but 0) out of
    /// it.
    ///
    /// # Errors
    /// [`GeometryError`] if the normal is zero, NaN or infinite.
    pub fn new(normal: DVec2) -> Result<Self, GeometryError> {
        let face = Face::of_wall(-normal.perp(), 0.0)?;
        Ok(Self {
            face: Face {
                half_length: f64::INFINITY,
                solid_behind: true,
                ..face
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
            let face = Face::of_wall(span, radius).unwrap();
            let oracle = Segment::new(-0.5 * span, 0.5 * span);
            let nearest = face.nearest(place);
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
