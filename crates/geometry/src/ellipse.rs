//! An ellipse: an atom that is stretched along one direction.

use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{GeometryError, Support, SupportPoint, check_positive};

/// The ratio of the axes up to which ellipses are accepted: rounding hides the width of thinner
/// ones.
pub const MAX_ASPECT: f64 = 1e4;

/// The shape of an atom that is an ellipse, with semi-axes a ≥ b.
///
/// With c and s, the components of n along the two axes: h = √(a²c² + b²s²), h' = (b² − a²) c s/h
/// and R = a²b²/h³.
///
/// ```
/// use carom_geometry::{Ellipse, Support};
/// use glam::DVec2;
///
/// let ellipse = Ellipse::new([2.0, 1.0], DVec2::X)?;
/// assert_eq!(ellipse.at(DVec2::X).distance, 2.0);
/// assert_eq!(ellipse.at(DVec2::X).curvature_radius, 0.5);
/// # Ok::<(), carom_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written")]
pub struct Ellipse {
    axes: [f64; 2],
    along: DVec2,
}

/// The serialized form of an ellipse, which may be out of range.
#[derive(Deserialize)]
struct Written {
    axes: [f64; 2],
    along: DVec2,
}

impl TryFrom<Written> for Ellipse {
    type Error = GeometryError;

    fn try_from(Written { axes, along }: Written) -> Result<Self, GeometryError> {
        Self::new(axes, along)
    }
}

/// The largest difference of the length of a direction from 1: far more than rounding.
const MAX_LENGTH_ERROR: f64 = 1e-9;

impl Ellipse {
    /// An ellipse with these semi-axes (length, the longer one first) and the direction of the
    /// longer one, a unit vector in the frame of the body.
    ///
    /// # Errors
    /// [`GeometryError`] if a semi-axis is not positive, the first is shorter than the second, or
    /// longer than 10⁴ times the second, or if the direction is no unit vector.
    pub fn new(axes: [f64; 2], along: DVec2) -> Result<Self, GeometryError> {
        check_positive("the longer semi-axis of an ellipse", axes[0])?;
        check_positive("the shorter semi-axis of an ellipse", axes[1])?;
        let ratio = axes[0] / axes[1];
        if !(1.0..=MAX_ASPECT).contains(&ratio) {
            return Err(GeometryError::AspectRatio(ratio));
        }
        let length = along.length();
        if length.is_nan() || (length - 1.0).abs() > MAX_LENGTH_ERROR {
            return Err(GeometryError::NoDirection(length));
        }
        Ok(Self { axes, along })
    }

    /// A disc of this radius (length, may be 0).
    #[inline]
    pub fn round(radius: f64) -> Self {
        Self {
            axes: [radius; 2],
            along: DVec2::X,
        }
    }

    /// The semi-axes a ≥ b (length).
    pub fn axes(&self) -> [f64; 2] {
        self.axes
    }

    /// The direction of the longer axis, in the frame of the body.
    pub fn along(&self) -> DVec2 {
        self.along
    }

    /// πab (length²).
    pub fn area(&self) -> f64 {
        std::f64::consts::PI * self.axes[0] * self.axes[1]
    }

    /// The moment of inertia about the centre of the uniform ellipse of unit mass, (a² + b²)/4
    /// (length²).
    pub fn gyration(&self) -> f64 {
        let [a, b] = self.axes;
        0.25 * (a * a + b * b)
    }

    /// Length of the boundary, 4a E(1 − b²/a²), by the arithmetic-geometric mean.
    pub fn perimeter(&self) -> f64 {
        // Carlson, Numer. Algorithms 10 (1995) 13: P = 2π (a² − Σ 2^(n−1) c_n²)/M(a, b) with
        // c_0² = a² − b².
        let [a, b] = self.axes;
        let (mut x, mut y, mut weight) = (a, b, 0.5);
        let mut sum = weight * (a - b) * (a + b);
        for _ in 0..MAX_MEANS {
            let half = 0.5 * (x - y);
            (x, y) = (0.5 * (x + y), (x * y).sqrt());
            weight *= 2.0;
            sum += weight * half * half;
            if half.abs() <= f64::EPSILON * x {
                break;
            }
        }
        std::f64::consts::TAU * (a * a - sum) / x
    }

    /// This ellipse with all lengths multiplied by `scale`.
    pub(crate) fn scaled(&self, scale: f64) -> Result<Self, GeometryError> {
        Self::new(self.axes.map(|axis| scale * axis), self.along)
    }

    /// Points of the boundary at equal steps of the eccentric angle, counter-clockwise, about the
    /// centre.
    pub fn points(&self, count: u32) -> impl Iterator<Item = DVec2> {
        let [a, b] = self.axes;
        let along = self.along;
        (0..count).map(move |step| {
            let angle = std::f64::consts::TAU * f64::from(step) / f64::from(count);
            along.rotate(DVec2::from_angle(angle) * DVec2::new(a, b))
        })
    }
}

impl Ellipse {
    /// Discs along the longer axis that lie in the ellipse and touch its boundary, by the distance
    /// of their centres from its centre (length, in the direction of the longer axis) and radius.
    ///
    /// The centres are in (a² − b²)/a of the centre, with radii b √(1 − x²/(a² − b²)).
    pub fn inscribed_discs(&self, count: u32) -> impl Iterator<Item = (f64, f64)> {
        let [a, b] = self.axes;
        let squared = (a - b) * (a + b);
        let last = squared / a;
        (0..count).map(move |step| {
            let x = last * (2.0 * f64::from(step) / f64::from(count.max(2) - 1) - 1.0);
            let share = if squared > 0.0 { x * x / squared } else { 0.0 };
            (x, b * (1.0 - share).max(0.0).sqrt())
        })
    }
}

/// Most steps of the arithmetic-geometric mean, which doubles its digits in each.
const MAX_MEANS: u32 = 16;

impl Support for Ellipse {
    #[inline]
    fn at(&self, normal: DVec2) -> SupportPoint {
        let [a, b] = self.axes;
        let (c, s) = (self.along.dot(normal), self.along.perp_dot(normal));
        let (x, y) = (a * c, b * s);
        if a == b {
            return SupportPoint {
                distance: a,
                slope: 0.0,
                curvature_radius: a,
            };
        }
        let distance = (x * x + y * y).sqrt();
        let inverse = 1.0 / distance;
        let tip = a * b * inverse;
        SupportPoint {
            distance,
            slope: (b - a) * (b + a) * (c * s) * inverse,
            curvature_radius: tip * tip * inverse,
        }
    }

    #[inline]
    fn reach(&self) -> f64 {
        self.axes[0]
    }

    /// a²/b − b.
    fn max_bend(&self) -> f64 {
        let [a, b] = self.axes;
        if a == b { 0.0 } else { (a - b) * (a + b) / b }
    }

    /// max|R'| + a − b, since h''' = R' − h'. With δ = a² − b², R' = 3 δ a² b² c s/h⁵ is largest
    /// where 3 δ c⁴ − (4 δ + 2 b²) c² + b² = 0.
    fn max_third(&self) -> f64 {
        let [a, b] = self.axes;
        let delta = (a - b) * (a + b);
        if delta == 0.0 {
            return 0.0;
        }
        let half = 2.0 * delta + b * b;
        // The root between 0 and 1, in the form without cancellation.
        let squared = b * b / (half + (half * half - 3.0 * delta * b * b).sqrt());
        let (c, s) = (squared.sqrt(), (1.0 - squared).sqrt());
        let h = (a * a * squared + b * b * s * s).sqrt();
        let tip = a * b / h;
        (3.0 * delta * tip * tip * (c * s) / (h * h * h) + (a - b)) * (1.0 + 1e-12)
    }

    #[inline]
    fn matrix(&self, rotation: DVec2) -> [f64; 3] {
        let [a, b] = self.axes;
        let DVec2 { x, y } = rotation.rotate(self.along);
        let (across, more) = (b * b, (a - b) * (a + b));
        [across + more * x * x, more * x * y, across + more * y * y]
    }

    /// At equal eccentric angles: the flat sides have most of the boundary.
    fn normal_at(&self, share: f64) -> DVec2 {
        let [a, b] = self.axes;
        let point = DVec2::from_angle(std::f64::consts::TAU * share);
        let normal = DVec2::new(b * point.x, a * point.y).try_normalize();
        self.along.rotate(normal.unwrap_or(point))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FacingParts;
    use proptest::prelude::*;

    fn ellipses() -> impl Strategy<Value = Ellipse> {
        (0.1..2.0f64, 0.0..2.0f64, -3.2..3.2f64).prop_map(|(b, stretch, angle)| {
            Ellipse::new([b * 10f64.powf(stretch), b], DVec2::from_angle(angle)).unwrap()
        })
    }

    proptest! {
        #[test]
        fn derivatives_are_those_of_the_support_function(ellipse in ellipses(), angle in -3.2..3.2f64) {
            let at = |angle: f64| ellipse.at(DVec2::from_angle(angle));
            let (h, here) = (1e-5, at(angle));
            let [before, after] = [at(angle - h), at(angle + h)];
            let [a, b] = ellipse.axes();
            let size = a * (a / b).powi(4);
            let slope = (after.distance - before.distance) / (2.0 * h);
            prop_assert!((slope - here.slope).abs() < 1e-9 * size, "{slope} {}", here.slope);
            let bend = (after.slope - before.slope) / (2.0 * h);
            prop_assert!((bend - here.bend()).abs() < 1e-8 * size);
            let third = (after.bend() - before.bend()) / (2.0 * h);
            prop_assert!(third.abs() < ellipse.max_third() + 1e-8 * size);
            prop_assert!(here.bend() <= ellipse.max_bend() * (1.0 + 1e-12));
            // The point is on the ellipse.
            let place = here.place(DVec2::from_angle(angle));
            let (x, y) = (ellipse.along().dot(place) / a, ellipse.along().perp_dot(place) / b);
            prop_assert!((x * x + y * y - 1.0).abs() < 1e-11 * (a / b));
        }

        /// The bound on the third derivative is reached.
        #[test]
        fn the_bound_on_the_third_derivative_is_tight(ellipse in ellipses()) {
            let [a, b] = ellipse.axes();
            let rate = |step: u32| {
                let angle = std::f64::consts::FRAC_PI_2 * f64::from(step) / 1e5;
                let (s, c) = angle.sin_cos();
                let h = (a * a * c * c + b * b * s * s).sqrt();
                3.0 * (a - b) * (a + b) * (a * b / h).powi(2) * c * s / h.powi(3)
            };
            let most = (0..=100_000).map(rate).fold(0.0, f64::max);
            let bound = ellipse.max_third() - (a - b);
            prop_assert!(most <= bound && most >= bound * (1.0 - 1e-3), "{most} {bound}");
        }

        /// The gap of two ellipses is the least distance of the points of one from the other.
        #[test]
        fn the_gap_is_the_distance_of_the_nearest_points(
            one in ellipses(), other in ellipses(), x in -30.0..30.0f64, y in -30.0..30.0f64, turn in -3.0..3.0f64,
        ) {
            let (d, turned) = (DVec2::new(x, y), DVec2::from_angle(turn));
            let parts = FacingParts { a: &one, b: &other, rotations: [DVec2::X, turned], d };
            let found = parts.farthest(1e-14);
            prop_assume!(found.gap > 0.05);
            let points = |ellipse: &Ellipse| ellipse.points(2000).collect::<Vec<_>>();
            let (of_a, of_b) = (points(&one), points(&other));
            let mut least = f64::INFINITY;
            for p in &of_a {
                for q in of_b.iter().step_by(20) {
                    least = least.min((d + turned.rotate(*q) - *p).length());
                }
            }
            prop_assert!(found.gap <= least * (1.0 + 1e-12));
            let [p, q] = [found.points[0].place(found.normal), found.points[1].place(-found.normal)];
            prop_assert!(((d + q - p) - found.gap * found.normal).length() < 1e-5 * (1.0 + least));
            // The point of the other is given in the frame of the box.
            let disc = Ellipse::round(0.0 );
            let nearest = FacingParts { a: &disc, b: &other, rotations: [DVec2::X, turned], d: d - p };
            let again = nearest.farthest(1e-14);
            prop_assert!((again.gap - found.gap).abs() < 1e-6 * (1.0 + least));
        }

        #[test]
        fn the_perimeter_is_that_of_many_chords(ellipse in ellipses()) {
            let points: Vec<DVec2> = ellipse.points(20_000).collect();
            let chords: f64 = (0..points.len())
                .map(|i| (points[(i + 1) % points.len()] - points[i]).length())
                .sum();
            prop_assert!((chords / ellipse.perimeter() - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn parts_that_overlap_have_the_least_depth() {
        let ellipse = Ellipse::new([3.0, 0.5], DVec2::X).unwrap();
        let disc = Ellipse::round(0.25);
        let parts = FacingParts {
            a: &ellipse,
            b: &disc,
            rotations: [DVec2::X; 2],
            d: DVec2::new(1e-3, 0.0),
        };
        let found = parts.farthest(1e-15);
        assert!((found.gap + 0.75).abs() < 1e-5, "{found:?}");
    }

    #[test]
    fn axes_out_of_range_are_refused() {
        for axes in [[1.0, 2.0], [0.0, 0.0], [1.0, 1e-5], [f64::NAN, 1.0]] {
            assert!(Ellipse::new(axes, DVec2::X).is_err(), "{axes:?}");
        }
        assert!(Ellipse::new([1.0, 1.0], DVec2::X).is_ok());
        for along in [DVec2::ZERO, DVec2::new(-0.156, 1e240), DVec2::NAN] {
            let refused = Ellipse::new([1.0, 1.0], along).unwrap_err();
            assert!(
                matches!(refused, GeometryError::NoDirection(_)),
                "{refused}"
            );
        }
    }
}
