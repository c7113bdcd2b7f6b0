//! The named shapes other than unions of discs: capsule, square, rectangle, triangle, polygon,
//! kite, ellipse.

use std::{f64::consts::PI, fmt, str::FromStr};

use glam::DVec2;

use crate::{GeometryError, MAX_ASPECT, Molecule, check_positive, interior::check_corner_count};

/// A body with straight sides, or an ellipse, of uniform density, by name.
///
/// Its text form is `capsule:L`, `square`, `rectangle:A`, `triangle`, `polygon:N`, `kite:A,B` or
/// `ellipse:K`.
///
/// ```
/// use carom_geometry::EdgedShape;
///
/// let shape: EdgedShape = "rectangle:2.5".parse()?;
/// assert_eq!(shape, EdgedShape::Rectangle(2.5));
/// // Sides 0.2 and 0.5.
/// let rectangle = shape.molecule(0.2, 1e-6, 1.0)?;
/// assert!((rectangle.area() - 0.1).abs() < 1e-6);
/// # Ok::<(), carom_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum EdgedShape {
    /// All points within half the size of a line of L sizes along x: the size is the diameter.
    Capsule(f64),
    /// Four equal sides.
    Square,
    /// Sides of A sizes along x and of one size along y.
    Rectangle(f64),
    /// Three equal sides.
    Triangle,
    /// N equal sides and angles.
    Polygon(usize),
    /// Four corners, symmetric about x: at A and −B sizes on the x axis, and at half a size above
    /// and below the origin.
    Kite(f64, f64),
    /// An ellipse whose longer axis, of one size along x, is K times the shorter one.
    Ellipse(f64),
}

/// The radius of the corners of a polygon over its size, if none is given.
pub const DEFAULT_ROUNDING: f64 = 1e-6;

impl EdgedShape {
    /// The names of all shapes in their text form.
    pub const NAMES: [&str; 7] = [
        "capsule:L",
        "square",
        "rectangle:A",
        "triangle",
        "polygon:N",
        "kite:A,B",
        "ellipse:K",
    ];

    /// The shape of this `size` (length) and `mass`, with corners of radius `rounding` sizes.
    ///
    /// All points within that radius of the polygon belong to the body, so that a square of size 1
    /// is 1 + 2 `rounding` across. A capsule and an ellipse ignore `rounding`.
    ///
    /// # Errors
    /// [`GeometryError`] if a number is out of range.
    pub fn molecule(self, size: f64, rounding: f64, mass: f64) -> Result<Molecule, GeometryError> {
        self.check()?;
        check_positive("the size of a shape", size)?;
        check_positive("the mass of a molecule", mass)?;
        if let Self::Capsule(length) = self {
            return Molecule::capsule(length * size, 0.5 * size, mass);
        }
        if let Self::Ellipse(aspect) = self {
            return Molecule::ellipse([0.5 * size, 0.5 * size / aspect], mass);
        }
        check_positive("`rounding`", rounding)?;
        let corners: Vec<DVec2> = self.corners().map(|corner| size * corner).collect();
        Molecule::polygon(&corners, rounding * size, mass)
    }

    /// The corners at size 1, counter-clockwise.
    fn corners(self) -> impl Iterator<Item = DVec2> {
        let at = |corners: &[(f64, f64)]| corners.iter().map(|&(x, y)| DVec2::new(x, y)).collect();
        let corners: Vec<DVec2> = match self {
            // A quarter turn from the next corner to the bit.
            Self::Square => Self::Rectangle(1.0).corners().collect(),
            Self::Rectangle(aspect) => {
                let (x, y) = (0.5 * aspect, 0.5);
                at(&[(-x, -y), (x, -y), (x, y), (-x, y)])
            }
            Self::Kite(ahead, behind) => {
                at(&[(ahead, 0.0), (0.0, 0.5), (-behind, 0.0), (0.0, -0.5)])
            }
            Self::Triangle => Self::Polygon(3).corners().collect(),
            Self::Polygon(count) => {
                let step = 2.0 * PI / count as f64;
                let radius = 0.5 / libm::sin(0.5 * step);
                // The lowest side lies along x.
                let angle = |index: usize| step * (index as f64 + 0.5) - 0.5 * PI;
                let corner = |index| {
                    let (sin, cos) = libm::sincos(angle(index));
                    radius * DVec2::new(cos, sin)
                };
                (0..count).map(corner).collect()
            }
            Self::Capsule(length) => at(&[(-0.5 * length, 0.0), (0.5 * length, 0.0)]),
            Self::Ellipse(_) => Vec::new(),
        };
        corners.into_iter()
    }

    fn check(self) -> Result<Self, GeometryError> {
        let number = |name, value| check_positive(name, value).map(|_| self);
        match self {
            Self::Capsule(length) => number("L of capsule:L, length over diameter,", length),
            Self::Rectangle(aspect) => number("A of rectangle:A, length over width,", aspect),
            Self::Kite(ahead, behind) => {
                number("A of kite:A,B", ahead)?;
                number("B of kite:A,B", behind)
            }
            Self::Polygon(count) => check_corner_count(count).map(|()| self),
            Self::Ellipse(aspect) if (1.0..=MAX_ASPECT).contains(&aspect) => Ok(self),
            Self::Ellipse(aspect) => Err(GeometryError::AspectRatio(aspect)),
            Self::Square | Self::Triangle => Ok(self),
        }
    }
}

impl fmt::Display for EdgedShape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Capsule(length) => write!(f, "capsule:{length}"),
            Self::Square => f.write_str("square"),
            Self::Rectangle(aspect) => write!(f, "rectangle:{aspect}"),
            Self::Triangle => f.write_str("triangle"),
            Self::Polygon(count) => write!(f, "polygon:{count}"),
            Self::Kite(ahead, behind) => write!(f, "kite:{ahead},{behind}"),
            Self::Ellipse(aspect) => write!(f, "ellipse:{aspect}"),
        }
    }
}

impl FromStr for EdgedShape {
    type Err = GeometryError;

    fn from_str(text: &str) -> Result<Self, GeometryError> {
        let unknown = || GeometryError::UnknownShape(text.to_owned());
        let number = |text: &str| text.trim().parse::<f64>().map_err(|_| unknown());
        let (name, numbers) = match text.split_once(':') {
            Some((name, numbers)) => (name, Some(numbers)),
            None => (text, None),
        };
        let shape = match (name, numbers) {
            ("square", None) => Self::Square,
            ("triangle", None) => Self::Triangle,
            ("ellipse", Some(aspect)) => Self::Ellipse(number(aspect)?),
            ("capsule", Some(length)) => Self::Capsule(number(length)?),
            ("rectangle", Some(aspect)) => Self::Rectangle(number(aspect)?),
            ("polygon", Some(count)) => Self::Polygon(count.trim().parse().map_err(|_| unknown())?),
            ("kite", Some(both)) => {
                let (ahead, behind) = both.split_once(',').ok_or_else(unknown)?;
                Self::Kite(number(ahead)?, number(behind)?)
            }
            ("superellipse", _) => return Err(GeometryError::Superellipse(text.to_owned())),
            _ => return Err(unknown()),
        };
        shape.check()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back_and_bad_ones_refused() {
        for shape in [
            EdgedShape::Capsule(2.5),
            EdgedShape::Square,
            EdgedShape::Rectangle(0.1),
            EdgedShape::Triangle,
            EdgedShape::Polygon(16),
            EdgedShape::Kite(1.0, 0.25),
            EdgedShape::Ellipse(2.5),
        ] {
            assert_eq!(shape.to_string().parse::<EdgedShape>().unwrap(), shape);
        }
        for bad in [
            "",
            "Square",
            "square:2",
            "capsule",
            "capsule:0",
            "capsule:-1",
            "capsule:nan",
            "rectangle:x",
            "polygon:2",
            "polygon:1025",
            "polygon:3.5",
            "kite:1",
            "kite:1,0",
            "ellipse",
            "ellipse:0.5",
            "ellipse:20000",
        ] {
            assert!(bad.parse::<EdgedShape>().is_err(), "{bad}");
        }
        for name in ["superellipse", "superellipse:4", "superellipse:2.5,0.5"] {
            let refused = name.parse::<EdgedShape>().unwrap_err();
            assert_eq!(refused, GeometryError::Superellipse(name.to_owned()));
        }
    }

    /// Areas and moments of inertia of the sharp shapes of size 1.
    #[test]
    fn shapes_have_their_areas_and_moments() {
        let of = |name: &str| {
            let shape: EdgedShape = name.parse().unwrap();
            shape.molecule(1.0, 1e-9, 1.0).unwrap()
        };
        for (name, area, moment) in [
            ("square", 1.0, 1.0 / 6.0),
            ("rectangle:3", 3.0, 10.0 / 12.0),
            ("triangle", 0.75f64.sqrt() / 2.0, 1.0 / 12.0),
            ("polygon:6", 1.5 * 3f64.sqrt(), 5.0 / 12.0),
            ("kite:1,1", 1.0, (4.0 + 1.0) / 24.0),
            ("ellipse:2", PI / 8.0, 5.0 / 64.0),
        ] {
            let shape = of(name);
            assert!(
                (shape.area() / area - 1.0).abs() < 1e-8,
                "{name}: {}",
                shape.area()
            );
            let found = shape.moment_of_inertia();
            assert!((found / moment - 1.0).abs() < 1e-8, "{name}: {found}");
        }
        assert_eq!(of("polygon:5").atoms().len(), 5);
        assert_eq!(
            of("capsule:2").bounding_radius(),
            1.5 * (1.0 + 4.0 * f64::EPSILON)
        );
    }
}
