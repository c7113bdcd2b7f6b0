//! The periodic box: a rectangle whose opposite sides are identified, the upper one possibly
//! shifted.

use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{GeometryError, check_positive};

/// Most rows of images that [`PeriodicBox::nearest_image`] compares on each side. Smaller: in boxes
/// that are wider than twice as many heights and tilted, the image returned may not be the nearest.
const MAX_ROWS: f64 = 64.0;

/// A rectangle [0, Lx) × [0, Ly) with periodic borders; the unit square by default.
///
/// The next box above may be shifted along x by a *tilt* b: images of a point are at multiples of
/// (Lx, 0) and of (b, Ly) from it, as in a gas under shear (Lees & Edwards, J. Phys. C 5 (1972)
/// 1921).
///
/// ```
/// use carom_geometry::PeriodicBox;
/// use glam::DVec2;
///
/// let unit = PeriodicBox::default();
/// let (place, image) = unit.wrap(DVec2::new(1.25, -0.25));
/// assert_eq!((place, image), (DVec2::new(0.25, 0.75), [1, -1]));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[doc(alias = "torus")]
pub struct PeriodicBox {
    sides: DVec2,
    /// Shift along x of the next box above (length). It is stored apart from the box.
    #[serde(skip)]
    tilt: f64,
}

impl Default for PeriodicBox {
    fn default() -> Self {
        Self {
            sides: DVec2::ONE,
            tilt: 0.0,
        }
    }
}

impl PeriodicBox {
    /// A box with the given sides (length).
    ///
    /// # Errors
    /// [`GeometryError::NotPositive`] if a side is not positive and finite.
    pub fn new(sides: DVec2) -> Result<Self, GeometryError> {
        check_positive("a side of the box", sides.x)?;
        check_positive("a side of the box", sides.y)?;
        Ok(Self { sides, tilt: 0.0 })
    }

    /// The box with another tilt: the shift along x of the next box above (length).
    ///
    /// ```
    /// use carom_geometry::PeriodicBox;
    /// use glam::DVec2;
    ///
    /// let sheared = PeriodicBox::default().tilted(0.25);
    /// assert_eq!(sheared.shift([0, 1]), DVec2::new(0.25, 1.0));
    /// let (place, image) = sheared.wrap(DVec2::new(0.5, 1.5));
    /// assert_eq!((place, image), (DVec2::new(0.25, 0.5), [0, 1]));
    /// // Through the upper border the point is nearer than within the box.
    /// let nearest = sheared.nearest_image(DVec2::new(0.25, 0.875));
    /// assert_eq!(nearest, DVec2::new(0.0, -0.125));
    /// ```
    #[must_use]
    pub fn tilted(self, tilt: f64) -> Self {
        Self { tilt, ..self }
    }

    /// Shift along x of the next box above (length); 0 but for a box under shear.
    pub fn tilt(&self) -> f64 {
        self.tilt
    }

    /// The sides (length).
    pub fn sides(&self) -> DVec2 {
        self.sides
    }

    /// Area (length²).
    pub fn area(&self) -> f64 {
        self.sides.x * self.sides.y
    }

    /// Whether the point is in the half-open box; false if a coordinate is not a number.
    #[inline]
    pub fn contains(&self, point: DVec2) -> bool {
        (0.0..self.sides.x).contains(&point.x) && (0.0..self.sides.y).contains(&point.y)
    }

    /// Returns the position in the half-open box, and the number of boxes by which the point was
    /// outside.
    ///
    /// The place with the [`Self::shift`] of the image is the given point, to rounding. The point
    /// must be less than 2^52 boxes away; beyond that the result means nothing.
    #[inline]
    pub fn wrap(&self, point: DVec2) -> (DVec2, [i64; 2]) {
        if self.contains(point) {
            // Where most points are. As below, −0 becomes 0.
            return (point + 0.0, [0, 0]);
        }
        let (y, image_y) = wrap_axis(point.y, self.sides.y);
        let (x, image_x) = wrap_axis(point.x - image_y as f64 * self.tilt, self.sides.x);
        (DVec2::new(x, y), [image_x, image_y])
    }

    /// The shortest of all periodic images of a vector (length).
    ///
    /// ```
    /// use carom_geometry::PeriodicBox;
    /// use glam::DVec2;
    ///
    /// let bounds = PeriodicBox::new(DVec2::new(2.0, 1.0))?;
    /// assert_eq!(bounds.nearest_image(DVec2::new(1.5, -0.25)), DVec2::new(-0.5, -0.25));
    /// # Ok::<(), carom_geometry::GeometryError>(())
    /// ```
    pub fn nearest_image(&self, vector: DVec2) -> DVec2 {
        if self.tilt == 0.0 {
            return vector - self.sides * (vector / self.sides).round();
        }
        let row = (vector.y / self.sides.y).round();
        let in_row = |row: f64| {
            let x = vector.x - row * self.tilt;
            DVec2::new(
                x - self.sides.x * (x / self.sides.x).round(),
                vector.y - row * self.sides.y,
            )
        };
        // No point is farther from the nearest image than half a diagonal, which in flat boxes is
        // several rows.
        let rows = (0.5 * self.sides.length() / self.sides.y)
            .ceil()
            .min(MAX_ROWS);
        (-(rows as i32)..=rows as i32)
            .map(|step| in_row(row + f64::from(step)))
            .min_by(|one, other| one.length_squared().total_cmp(&other.length_squared()))
            .unwrap_or(vector)
    }

    /// The shift (length) by `image` boxes.
    pub fn shift(&self, image: [i64; 2]) -> DVec2 {
        DVec2::new(
            image[0] as f64 * self.sides.x + image[1] as f64 * self.tilt,
            image[1] as f64 * self.sides.y,
        )
    }
}

/// Wraps one coordinate into [0, side); −1e-17 must not become `side`.
fn wrap_axis(x: f64, side: f64) -> (f64, i64) {
    let image = (x / side).floor();
    let mut place = x - image * side;
    let mut image = image as i64;
    if place >= side {
        place = 0.0;
        image = image.saturating_add(1);
    } else if place < 0.0 {
        // x / side was rounded up to an integer.
        place += side;
        image = image.saturating_sub(1);
        if place >= side {
            place = 0.0;
            image = image.saturating_add(1);
        }
    }
    (place, image)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn wrap_is_half_open_at_the_edges() {
        let side = 0.7;
        for x in [
            0.0,
            -0.0,
            -1e-17,
            -1e-300,
            side,
            side - f64::EPSILON,
            -side,
            3.0 * side,
            7.0 * side,
        ] {
            let (place, _) = wrap_axis(x, side);
            assert!((0.0..side).contains(&place), "{x} goes to {place}");
        }
        assert_eq!(wrap_axis(-1e-17, 1.0), (0.0, 0));
    }

    #[test]
    fn points_in_the_box_stay_as_they_are() {
        let side = 0.7;
        let shape = PeriodicBox::new(DVec2::splat(side)).unwrap();
        for x in [0.0, -0.0, 1e-300, 0.3, side - f64::EPSILON / 4.0] {
            let (place, image) = shape.wrap(DVec2::splat(x));
            let (along, of_axis) = wrap_axis(x, side);
            assert_eq!(
                (place.x.to_bits(), image[0]),
                (along.to_bits(), of_axis),
                "{x}"
            );
        }
    }

    #[test]
    fn a_box_contains_what_wrapping_does_not_move() {
        let shape = PeriodicBox::new(DVec2::new(0.7, 3.0)).unwrap();
        for x in [
            0.0,
            0.35,
            0.7 - f64::EPSILON / 4.0,
            -1e-17,
            -1e-300,
            0.7,
            1e300,
            -1e300,
            f64::MAX,
        ] {
            let point = DVec2::new(x, 1.0);
            assert_eq!(shape.contains(point), shape.wrap(point).0 == point, "{x}");
        }
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(!shape.contains(DVec2::new(x, 1.0)) && !shape.contains(DVec2::new(0.1, x)));
        }
    }

    proptest! {
        #[test]
        fn wrapping_and_nearest_images_know_the_tilt(
            x in -30.0..30.0f64,
            y in -30.0..30.0f64,
            width in 0.2..5.0f64,
            tilt in -0.5..0.5f64,
        ) {
            let tilted = PeriodicBox::new(DVec2::new(width, 1.0)).unwrap().tilted(tilt * width);
            let point = DVec2::new(x, y);
            let (place, image) = tilted.wrap(point);
            prop_assert!(tilted.contains(place));
            prop_assert!((place + tilted.shift(image) - point).length() < 1e-12);
            let nearest = tilted.nearest_image(point);
            let images = (-40..=40_i64).flat_map(|row| (-4..=4_i64).map(move |column| [column, row]));
            let shortest = images
                .map(|image| (place + tilted.shift(image)).length())
                .fold(f64::INFINITY, f64::min);
            prop_assert!((nearest.length() - shortest).abs() < 1e-12, "{nearest} {shortest}");
        }

        #[test]
        fn wrap_is_in_the_box_and_names_the_image(x in -1e3..1e3f64, y in -1e3..1e3f64, side in 0.01..10.0f64) {
            let shape = PeriodicBox::new(DVec2::new(side, 1.0)).unwrap();
            let (place, image) = shape.wrap(DVec2::new(x, y));
            prop_assert!((0.0..side).contains(&place.x) && (0.0..1.0).contains(&place.y));
            prop_assert!((place + shape.shift(image) - DVec2::new(x, y)).length() < 1e-12 * (1.0 + x.abs()));
        }
    }
}
