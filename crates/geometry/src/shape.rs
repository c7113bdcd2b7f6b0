//! The named shapes of touching equal discs: disc, dumbbell, rod, cross, tee, ring.

use std::{fmt, str::FromStr};

use glam::DVec2;

use crate::{Atom, GeometryError, check_positive};

/// A rigid union of equal touching discs, by name.
///
/// Its text form is `disc`, `dumbbell`, `rod:N`, `cross`, `tee` or `ring:N`.
///
/// ```
/// use carom_geometry::Shape;
///
/// assert_eq!("rod:16".parse::<Shape>()?, Shape::Rod(16));
/// assert_eq!(Shape::Ring(6).to_string(), "ring:6");
/// # Ok::<(), carom_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Shape {
    /// One atom.
    Disc,
    /// Two touching atoms along x.
    Dumbbell,
    /// N touching atoms in a row along x.
    Rod(usize),
    /// Five atoms: one at the centre, one on each side.
    Cross,
    /// Five atoms: a bar of three along x, and two below its centre along −y (Montanari 2017,
    /// figure 3.1).
    Tee,
    /// N atoms on a circle, each touching the next; the first on the positive x axis.
    Ring(usize),
}

/// The most atoms in one named shape; a larger number is probably a typing error.
const MAX_ATOMS: usize = 4096;

impl Shape {
    /// The names of all shapes in their text form; N stands for a number of atoms.
    pub const NAMES: [&str; 6] = ["disc", "dumbbell", "rod:N", "cross", "tee", "ring:N"];

    /// The atoms of the shape, each of `radius` (length) and `mass`.
    ///
    /// # Errors
    /// [`GeometryError`] if the radius, the mass or the number of atoms is out of range.
    pub fn atoms(self, radius: f64, mass: f64) -> Result<Vec<Atom>, GeometryError> {
        self.check_count()?;
        check_positive("the radius of an atom", radius)?;
        let d = 2.0 * radius;
        let at = |x: f64, y: f64| Atom::new(DVec2::new(x, y), radius, mass);
        match self {
            Self::Disc => Ok(vec![at(0.0, 0.0)?]),
            Self::Dumbbell => row(2, d, at),
            Self::Rod(count) => row(count, d, at),
            Self::Cross => [(0.0, 0.0), (d, 0.0), (0.0, d), (-d, 0.0), (0.0, -d)]
                .map(|(x, y)| at(x, y))
                .into_iter()
                .collect(),
            Self::Tee => [(-d, 0.0), (0.0, 0.0), (d, 0.0), (0.0, -d), (0.0, -2.0 * d)]
                .map(|(x, y)| at(x, y))
                .into_iter()
                .collect(),
            Self::Ring(count) => ring(count, radius, at),
        }
    }

    fn check_count(self) -> Result<(), GeometryError> {
        let (shape, count, least) = match self {
            Self::Rod(count) => ("rod", count, 1),
            Self::Ring(count) => ("ring", count, 3),
            _ => return Ok(()),
        };
        if (least..=MAX_ATOMS).contains(&count) {
            Ok(())
        } else {
            Err(GeometryError::AtomCount {
                shape,
                count,
                least,
            })
        }
    }
}

fn row(
    count: usize,
    spacing: f64,
    at: impl Fn(f64, f64) -> Result<Atom, GeometryError>,
) -> Result<Vec<Atom>, GeometryError> {
    // Half-integers times the spacing: symmetric about the centre to the bit.
    (0..count)
        .map(|i| at((i as f64 - 0.5 * (count - 1) as f64) * spacing, 0.0))
        .collect()
}

fn ring(
    count: usize,
    radius: f64,
    at: impl Fn(f64, f64) -> Result<Atom, GeometryError>,
) -> Result<Vec<Atom>, GeometryError> {
    let step = std::f64::consts::TAU / count as f64;
    let circle = radius / libm::sin(0.5 * step);
    (0..count)
        .map(|i| {
            let (sin, cos) = libm::sincos(step * i as f64);
            at(circle * cos, circle * sin)
        })
        .collect()
}

impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Disc => f.write_str("disc"),
            Self::Dumbbell => f.write_str("dumbbell"),
            Self::Rod(count) => write!(f, "rod:{count}"),
            Self::Cross => f.write_str("cross"),
            Self::Tee => f.write_str("tee"),
            Self::Ring(count) => write!(f, "ring:{count}"),
        }
    }
}

impl FromStr for Shape {
    type Err = GeometryError;

    fn from_str(text: &str) -> Result<Self, GeometryError> {
        let unknown = || GeometryError::UnknownShape(text.to_owned());
        let (name, count) = match text.split_once(':') {
            Some((name, count)) => (name, Some(count.parse().map_err(|_| unknown())?)),
            None => (text, None),
        };
        let shape = match (name, count) {
            ("disc" | "disk", None) => Self::Disc,
            ("dumbbell", None) => Self::Dumbbell,
            ("cross", None) => Self::Cross,
            ("tee", None) => Self::Tee,
            ("rod", Some(count)) => Self::Rod(count),
            ("ring", Some(count)) => Self::Ring(count),
            _ => return Err(unknown()),
        };
        shape.check_count().map(|()| shape)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Molecule;

    #[test]
    fn tee_has_the_expected_mass_properties() {
        // Bar at y = 0, stem at −2a and −4a: centre of mass 1.2 a below the bar, I = 23.3 m a²
        // with each atom a uniform disc.
        let a = 0.005;
        let tee = Molecule::named(Shape::Tee, a, 2.0).unwrap();
        assert!((tee.mass() - 10.0).abs() < 1e-14);
        assert!((tee.atoms()[1].offset().y - 1.2 * a).abs() < 1e-17);
        assert!((tee.moment_of_inertia() - 1.165e-3).abs() < 1e-16);
        // Its farthest atom is the foot of the stem: 2.8 a + a.
        assert!((tee.bounding_radius() - 3.8 * a).abs() < 1e-16);
    }

    #[test]
    fn neighbours_touch() {
        for shape in [
            Shape::Dumbbell,
            Shape::Rod(7),
            Shape::Ring(5),
            Shape::Ring(64),
        ] {
            let atoms = shape.atoms(0.25, 1.0).unwrap();
            for pair in atoms.windows(2) {
                let distance = (pair[0].offset() - pair[1].offset()).length();
                assert!((distance - 0.5).abs() < 1e-13, "{shape}: {distance}");
            }
        }
    }

    #[test]
    fn names_are_read_back() {
        for shape in [
            Shape::Disc,
            Shape::Dumbbell,
            Shape::Rod(3),
            Shape::Cross,
            Shape::Tee,
            Shape::Ring(4),
        ] {
            assert_eq!(shape.to_string().parse::<Shape>().unwrap(), shape);
        }
        for bad in [
            "",
            "T",
            "rod",
            "rod:0",
            "rod:x",
            "ring:2",
            "tee:5",
            "rod:99999999",
        ] {
            assert!(bad.parse::<Shape>().is_err(), "{bad}");
        }
    }
}
