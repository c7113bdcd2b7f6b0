//! One ellipse of a molecule, as a scene describes it.

#[cfg(feature = "schema")]
use carom_geometry::{MAX_MAGNITUDE, MIN_MAGNITUDE};

use carom_geometry::{Ellipse, GeometryError};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::scene::two_numbers::{axes, vector};

/// One ellipse of a molecule given by a list of ellipses.
///
/// ```
/// use carom_engine::{EllipseSpec, MoleculeSpec};
///
/// // A cross of two ellipses that touch tip to side.
/// let ellipse = |at, turn| EllipseSpec { at, axes: [0.2, 0.1], turn, mass: 1.0 };
/// let turned = ellipse([0.3, 0.0], std::f64::consts::FRAC_PI_2);
/// let ellipses = vec![ellipse([0.0, 0.0], 0.0), turned];
/// let molecule = MoleculeSpec { ellipses, ..MoleculeSpec::default() }.molecule("molecule[0]")?;
/// assert!((molecule.area() - 2.0 * std::f64::consts::PI * 0.02).abs() < 1e-15);
/// # Ok::<(), carom_engine::SceneError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct EllipseSpec {
    /// Centre of the ellipse, in any frame of the molecule (length).
    #[serde(deserialize_with = "vector")]
    pub at: [f64; 2],
    /// Semi-axes along the direction `turn` and across it (length). The longer one is at most 10⁴
    /// times the shorter one.
    #[serde(deserialize_with = "axes")]
    pub axes: [f64; 2],
    /// Direction of the first semi-axis (radians), counter-clockwise from x. Default: 0.
    #[serde(default)]
    pub turn: f64,
    /// Mass (mass), spread evenly over the ellipse.
    #[cfg_attr(feature = "schema", schemars(range(min = MIN_MAGNITUDE, max = MAX_MAGNITUDE)))]
    pub mass: f64,
}

impl EllipseSpec {
    /// The shape of the ellipse.
    ///
    /// # Errors
    /// [`GeometryError`] if a semi-axis or the ratio of the two is out of range, or the direction
    /// is not finite.
    pub(crate) fn shape(&self) -> Result<Ellipse, GeometryError> {
        let [first, second] = self.axes;
        if !self.turn.is_finite() {
            return Err(GeometryError::OutOfRange {
                name: "the direction of an ellipse",
                value: self.turn,
            });
        }
        let (sin, cos) = libm::sincos(self.turn);
        let along = DVec2::new(cos, sin);
        if first < second {
            Ellipse::new([second, first], along.perp())
        } else {
            Ellipse::new(self.axes, along)
        }
    }
}
