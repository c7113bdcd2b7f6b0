//! The range of magnitudes for which every product in the other crates is finite.

use crate::GeometryError;

/// Largest allowed magnitude of a length, mass, speed or angular velocity.
///
/// Detection forms products of four such numbers; their fourth power must not overflow.
pub const MAX_MAGNITUDE: f64 = 1e60;

/// Smallest allowed magnitude of a length or mass that must not be zero.
///
/// Its fourth power must not underflow.
pub const MIN_MAGNITUDE: f64 = 1e-60;

/// Returns `value` if it is finite and at most [`MAX_MAGNITUDE`] in magnitude.
///
/// # Errors
/// [`GeometryError::OutOfRange`] with the name and the value.
///
/// ```
/// assert!(carom_geometry::check_length("offset", 0.3).is_ok());
/// assert!(carom_geometry::check_length("offset", f64::NAN).is_err());
/// ```
#[inline]
pub fn check_length(name: &'static str, value: f64) -> Result<f64, GeometryError> {
    if value.is_finite() && value.abs() <= MAX_MAGNITUDE {
        Ok(value)
    } else {
        Err(GeometryError::OutOfRange { name, value })
    }
}

/// Returns `value` if it lies between [`MIN_MAGNITUDE`] and [`MAX_MAGNITUDE`].
///
/// # Errors
/// [`GeometryError::NotPositive`] with the name and the value.
///
/// ```
/// assert!(carom_geometry::check_positive("radius", 0.3).is_ok());
/// assert!(carom_geometry::check_positive("radius", -0.3).is_err());
/// ```
#[inline]
pub fn check_positive(name: &'static str, value: f64) -> Result<f64, GeometryError> {
    if value.is_finite() && (MIN_MAGNITUDE..=MAX_MAGNITUDE).contains(&value) {
        Ok(value)
    } else {
        Err(GeometryError::NotPositive { name, value })
    }
}
