//! An atom: a disc with a mass, at a fixed position in the frame of its molecule.

use glam::DVec2;
use parry2d_f64::shape::Ball;
use serde::{Deserialize, Serialize};

use crate::{GeometryError, check_length, check_positive};

/// A uniform disc of given mass, at an offset from the origin of its molecule's frame.
///
/// ```
/// use carom_geometry::Atom;
/// use glam::DVec2;
///
/// let atom = Atom::new(DVec2::new(0.3, 0.4), 0.1, 2.0)?;
/// assert_eq!(atom.arm(), 0.5);
/// # Ok::<(), carom_geometry::GeometryError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(into = "PlainAtom", try_from = "PlainAtom")]
#[doc(alias = "disc")]
pub struct Atom {
    ball: Ball,
    offset: DVec2,
    arm: f64,
    mass: f64,
}

/// The serialized form of an atom, from which all other fields follow.
#[derive(Serialize, Deserialize)]
struct PlainAtom {
    offset: DVec2,
    radius: f64,
    mass: f64,
}

impl From<Atom> for PlainAtom {
    fn from(atom: Atom) -> Self {
        Self {
            offset: atom.offset,
            radius: atom.radius(),
            mass: atom.mass,
        }
    }
}

impl TryFrom<PlainAtom> for Atom {
    type Error = GeometryError;

    fn try_from(plain: PlainAtom) -> Result<Self, GeometryError> {
        Self::new(plain.offset, plain.radius, plain.mass)
    }
}

impl Atom {
    /// An atom at `offset` (length) with `radius` (length) and `mass`.
    ///
    /// # Errors
    /// [`GeometryError`] if radius or mass is not positive, or a number is NaN, infinite or
    /// beyond 1e60.
    pub fn new(offset: DVec2, radius: f64, mass: f64) -> Result<Self, GeometryError> {
        check_length("the x offset of an atom", offset.x)?;
        check_length("the y offset of an atom", offset.y)?;
        check_positive("the radius of an atom", radius)?;
        check_positive("the mass of an atom", mass)?;
        Ok(Self {
            ball: Ball::new(radius),
            offset,
            arm: offset.length(),
            mass,
        })
    }

    /// The end point of a wall: a disc of radius 0 or more, of infinite mass.
    pub(crate) fn end_of_wall(offset: DVec2, radius: f64) -> Self {
        Self {
            ball: Ball::new(radius),
            offset,
            arm: offset.length(),
            mass: f64::INFINITY,
        }
    }

    /// Position of the centre in the molecule's frame (length).
    pub fn offset(&self) -> DVec2 {
        self.offset
    }

    /// Distance of the centre from the origin of the molecule's frame (length).
    #[doc(alias = "lever arm")]
    pub fn arm(&self) -> f64 {
        self.arm
    }

    /// Radius (length); 0 for the end point of a wall.
    pub fn radius(&self) -> f64 {
        self.ball.radius
    }

    /// Mass.
    pub fn mass(&self) -> f64 {
        self.mass
    }

    /// The shape for queries by parry.
    pub fn ball(&self) -> &Ball {
        &self.ball
    }

    pub(crate) fn moved_by(self, shift: DVec2) -> Self {
        let offset = self.offset + shift;
        Self {
            offset,
            arm: offset.length(),
            ..self
        }
    }
}

/// Distance from the origin to the farthest point of the atom, never rounded down.
pub(crate) fn reach(atom: &Atom) -> f64 {
    if atom.arm == 0.0 {
        atom.radius()
    } else {
        (atom.arm + atom.radius()) * (1.0 + 4.0 * f64::EPSILON)
    }
}
