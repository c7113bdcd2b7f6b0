//! Elasticity: the ratio of the speed of separation to the speed of approach at a contact.

use thiserror::Error;

/// Coefficient of restitution e: 0 fully inelastic, 1 elastic, above 1 superelastic.
///
/// ```
/// use carom_response::Elasticity;
///
/// assert_eq!(Elasticity::new(0.9)?.coefficient(), 0.9);
/// assert!(Elasticity::new(-0.1).is_err());
/// # Ok::<(), carom_response::ElasticityError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[doc(alias = "coefficient of restitution")]
#[doc(alias = "restitution")]
pub struct Elasticity(f64);

/// A coefficient of restitution that is negative, NaN, or beyond 1e6.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("elasticity must be between 0 and 1e6, but is {0:?}")]
pub struct ElasticityError(pub f64);

impl Elasticity {
    /// No energy is lost or gained.
    pub const ELASTIC: Self = Self(1.0);

    /// Creates an elasticity from a coefficient between 0 and 10⁶.
    ///
    /// # Errors
    /// [`ElasticityError`] with the value, if it is out of range or NaN.
    pub fn new(coefficient: f64) -> Result<Self, ElasticityError> {
        if (0.0..=1e6).contains(&coefficient) {
            Ok(Self(coefficient))
        } else {
            Err(ElasticityError(coefficient))
        }
    }

    /// Returns the coefficient e.
    pub fn coefficient(self) -> f64 {
        self.0
    }
}

impl Default for Elasticity {
    fn default() -> Self {
        Self::ELASTIC
    }
}
