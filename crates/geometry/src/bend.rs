//! An arc of a circle: the line of a curved wall.

use std::f64::consts::{PI, TAU};

use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{GeometryError, Nearest, check_positive};

/// An arc of a circle about the origin, or the whole circle.
///
/// ```
/// use carom_geometry::{Bend, Molecule, gap_between};
/// use glam::DVec2;
/// use std::f64::consts::FRAC_PI_2;
///
/// // The right half of a circle of radius 2.
/// let half = Bend::new(2.0, [-FRAC_PI_2, FRAC_PI_2])?;
/// let wall = Molecule::arc(half, 0.0)?;
/// let disc = Molecule::disc(0.5, 1.0)?;
/// let gap = |x: f64, y: f64| gap_between(&wall, DVec2::X, &disc, DVec2::X, DVec2::new(x, y));
/// // From inside, from outside, and from one of its ends, at (0, 2).
/// assert_eq!((gap(1.0, 0.0), gap(3.0, 0.0), gap(-3.0, 6.0)), (0.5, 0.5, 4.5));
/// # Ok::<(), carom_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written")]
pub struct Bend {
    radius: f64,
    direction: DVec2,
    half_angle: f64,
    one_sided: bool,
    #[serde(skip_serializing)]
    cosine: f64,
    #[serde(skip_serializing)]
    sine: f64,
}

/// The fields of a [`Bend`] from which the others follow.
#[derive(Deserialize)]
struct Written {
    radius: f64,
    direction: DVec2,
    half_angle: f64,
    one_sided: bool,
}

impl TryFrom<Written> for Bend {
    type Error = GeometryError;

    fn try_from(written: Written) -> Result<Self, GeometryError> {
        let bend = Self::about(written.radius, written.direction, written.half_angle)?;
        Ok(Self {
            one_sided: written.one_sided,
            ..bend
        })
    }
}

/// The least angle of an arc, and of the opening of one that is not closed (radians): below it,
/// rounding moves an end along the circle by more than a thousand roundings of its radius.
const MIN_ANGLE: f64 = 2e-3;

impl Bend {
    /// The arc of a circle of this radius (length) from one direction to another (radians),
    /// counter-clockwise. A whole turn gives the circle.
    ///
    /// # Errors
    /// [`GeometryError`] if the radius is not positive, or the second direction is not beyond the
    /// first by 0.002 to 2π − 0.002, or by 2π.
    pub fn new(radius: f64, [from, to]: [f64; 2]) -> Result<Self, GeometryError> {
        let angle = to - from;
        let is_whole = (angle - TAU).abs() <= 8.0 * f64::EPSILON * (from.abs() + to.abs());
        let half = if is_whole { PI } else { 0.5 * angle };
        Self::about(radius, DVec2::from_angle(0.5 * (from + to)), half)
    }

    /// The whole circle.
    ///
    /// # Errors
    /// [`GeometryError`] if the radius is not positive.
    pub fn circle(radius: f64) -> Result<Self, GeometryError> {
        Self::about(radius, DVec2::X, PI)
    }

    /// The arc to either side of a direction (a unit vector), by an angle (radians).
    fn about(radius: f64, direction: DVec2, half_angle: f64) -> Result<Self, GeometryError> {
        check_positive("the radius of an arc", radius)?;
        let is_unit = (direction.length() - 1.0).abs() <= 1e-12;
        let is_open = (0.5 * MIN_ANGLE..=PI - 0.5 * MIN_ANGLE).contains(&half_angle);
        if !(is_unit && (is_open || half_angle == PI)) {
            return Err(GeometryError::Bend {
                what: "the angle of an arc",
                value: 2.0 * half_angle,
                range: "from 0.002 to 2π − 0.002, or 2π",
            });
        }
        let (sine, cosine) = match half_angle {
            PI => (0.0, -1.0),
            angle => (libm::sin(angle), libm::cos(angle)),
        };
        Ok(Self {
            radius,
            direction,
            half_angle,
            one_sided: false,
            cosine,
            sine,
        })
    }

    /// This arc as a part of a closed border, outside which there is no body: only its inner side
    /// is searched, so that bodies with straight sides can meet it. What comes from outside passes.
    #[must_use]
    pub fn one_sided(self) -> Self {
        Self {
            one_sided: true,
            ..self
        }
    }

    /// This arc with its radius multiplied by `scale`.
    pub(crate) fn scaled(self, scale: f64) -> Result<Self, GeometryError> {
        check_positive("the radius of an arc", scale * self.radius)?;
        Ok(Self {
            radius: scale * self.radius,
            ..self
        })
    }

    /// Radius of the circle (length).
    #[inline]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Unit vector from the centre to the middle of the arc.
    pub fn direction(&self) -> DVec2 {
        self.direction
    }

    /// Half the angle of the arc (radians); π for a circle.
    pub fn half_angle(&self) -> f64 {
        self.half_angle
    }

    /// The cosine of half the angle.
    #[inline]
    pub fn cosine(&self) -> f64 {
        self.cosine
    }

    /// Whether this is a whole circle, which has no ends.
    #[inline]
    pub fn is_circle(&self) -> bool {
        self.half_angle == PI
    }

    /// Whether only its inner side is searched, see [`Self::one_sided`].
    pub fn is_one_sided(&self) -> bool {
        self.one_sided
    }

    /// Its ends, the second counter-clockwise from the middle (length).
    pub fn ends(&self) -> [DVec2; 2] {
        let (forth, aside) = (
            self.cosine * self.direction,
            self.sine * self.direction.perp(),
        );
        [self.radius * (forth - aside), self.radius * (forth + aside)]
    }

    /// Points of the arc from end to end, `pieces` + 1 of equal distance (length).
    pub fn points(&self, pieces: u32) -> impl Iterator<Item = DVec2> {
        let turn = 2.0 * self.half_angle / f64::from(pieces);
        let start = self.radius * self.direction;
        let half = self.half_angle;
        (0..=pieces)
            .map(move |piece| DVec2::from_angle(f64::from(piece) * turn - half).rotate(start))
    }

    /// Whether a point, relative to the centre (length), lies in a direction of the arc, or beyond
    /// its ends by at most `rounding` (length).
    pub fn faces(&self, place: DVec2, rounding: f64) -> bool {
        self.is_circle() || self.direction.dot(place) >= self.cosine * place.length() - rounding
    }

    /// As [`Edge::nearest_to_rounding`](crate::Edge::nearest_to_rounding).
    pub(crate) fn nearest(&self, place: DVec2, rounding: f64) -> Nearest {
        if !self.faces(place, rounding) {
            let [first, second] = self.ends();
            let end = if self.direction.perp_dot(place) < 0.0 {
                first
            } else {
                second
            };
            let from_end = place - end;
            let distance = from_end.length();
            let direction = from_end.try_normalize().unwrap_or(self.direction);
            return Nearest {
                distance,
                direction,
            };
        }
        let from_centre = place.length();
        let outwards = if from_centre > 0.0 {
            place / from_centre
        } else {
            self.direction
        };
        if from_centre < self.radius {
            Nearest {
                distance: self.radius - from_centre,
                direction: -outwards,
            }
        } else {
            Nearest {
                distance: from_centre - self.radius,
                direction: outwards,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// The nearest of many points of the arc is not nearer than that of the formula.
        #[test]
        fn the_distance_is_that_of_the_nearest_point(
            radius in 0.1..3.0f64, from in -7.0..7.0f64, angle in 0.01..6.27f64, x in -4.0..4.0f64, y in -4.0..4.0f64,
        ) {
            let bend = Bend::new(radius, [from, from + angle]).unwrap();
            let place = DVec2::new(x, y);
            let nearest = bend.nearest(place, 0.0);
            let pieces = 2000;
            let found = bend.points(pieces).map(|point| point.distance(place)).fold(f64::INFINITY, f64::min);
            let step = radius * angle / f64::from(pieces);
            prop_assert!(nearest.distance <= found + 1e-12 && found <= nearest.distance + step, "{nearest:?} {found}");
            let foot = place - nearest.distance * nearest.direction;
            prop_assert!((foot.length() - radius).abs() < 1e-12);
        }
    }

    #[test]
    fn a_whole_turn_is_a_circle_and_arcs_without_an_angle_or_an_opening_are_refused() {
        for from in [0.0, 1.0, -3.0, 100.0] {
            assert!(Bend::new(1.0, [from, from + TAU]).unwrap().is_circle());
        }
        for angle in [
            0.0,
            -1.0,
            1e-4,
            TAU - 1e-4,
            TAU + 1e-4,
            7.0,
            f64::NAN,
            f64::INFINITY,
        ] {
            assert!(Bend::new(1.0, [0.0, angle]).is_err(), "{angle}");
        }
        for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Bend::new(radius, [0.0, 1.0]).is_err() && Bend::circle(radius).is_err());
        }
    }
}
