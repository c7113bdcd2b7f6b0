//! The coefficients of a contact: normal and tangential restitution, friction, and a transverse
//! kick.

use thiserror::Error;

/// Largest coefficient of restitution.
pub const MAX_COEFFICIENT: f64 = 1e6;

/// Largest size of a transverse kick (mass × length / time).
const MAX_KICK: f64 = 1e60;

/// The coefficients of a contact.
///
/// The coefficient of restitution e is 0 for a fully inelastic contact, 1 for an elastic one, and
/// above 1 for a superelastic one. [`Self::new`] gives smooth contacts, which have a normal impulse
/// alone. Rough contacts have a tangential restitution β above −1 too, and sliding ones a
/// coefficient of friction μ: see [`Impact`](crate::Impact).
///
/// ```
/// use carom_response::Elasticity;
///
/// let smooth = Elasticity::new(0.9)?;
/// assert_eq!(smooth.coefficient(), 0.9);
/// assert!(smooth.is_smooth());
/// assert!(Elasticity::new(-0.1).is_err());
///
/// let rough = smooth.with_tangential(0.5)?.with_friction(0.3)?;
/// assert_eq!((rough.tangential(), rough.friction()), (0.5, 0.3));
/// assert!(!rough.is_smooth());
/// assert!(smooth.with_tangential(1.5).is_err());
/// # Ok::<(), carom_response::ElasticityError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[doc(alias = "coefficient of restitution")]
#[doc(alias = "restitution")]
pub struct Elasticity {
    coefficient: f64,
    tangential: f64,
    friction: f64,
    kick: f64,
}

/// A coefficient of a contact that is NaN or out of its range, with its value.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum ElasticityError {
    /// The coefficient of restitution.
    #[error("elasticity must be between 0 and 1e6, but is {0:?}")]
    Coefficient(f64),
    /// The tangential restitution.
    #[error(
        "`tangential` must be from -1 (smooth) to 1 (the tangential velocity is reversed), but is {0:?}"
    )]
    Tangential(f64),
    /// The coefficient of friction.
    #[error(
        "`friction` must be at least 0, but is {0:?}; leave it out for contacts that never slide"
    )]
    Friction(f64),
    /// The transverse kick.
    #[error("`kick` must be from -1e60 to 1e60 (mass × length / time), but is {0:?}")]
    Kick(f64),
}

impl Elasticity {
    /// No energy is lost or gained, and the surfaces are smooth.
    pub const ELASTIC: Self = Self::smooth(1.0);

    const fn smooth(coefficient: f64) -> Self {
        Self {
            coefficient,
            tangential: -1.0,
            friction: f64::INFINITY,
            kick: 0.0,
        }
    }

    /// Creates the elasticity of a smooth contact from a coefficient between 0 and 10⁶.
    ///
    /// # Errors
    /// [`ElasticityError::Coefficient`] with the value, if it is out of range or NaN.
    pub fn new(coefficient: f64) -> Result<Self, ElasticityError> {
        if (0.0..=MAX_COEFFICIENT).contains(&coefficient) {
            Ok(Self::smooth(coefficient))
        } else {
            Err(ElasticityError::Coefficient(coefficient))
        }
    }

    /// The same contact with this coefficient of restitution, between 0 and 10⁶.
    ///
    /// # Errors
    /// [`ElasticityError::Coefficient`] with the value, if it is out of range or NaN.
    pub fn with_coefficient(self, coefficient: f64) -> Result<Self, ElasticityError> {
        let Self { coefficient, .. } = Self::new(coefficient)?;
        Ok(Self {
            coefficient,
            ..self
        })
    }

    /// The same contact with a tangential restitution β: −1 smooth, 0 no tangential velocity after
    /// a contact that sticks, 1 the tangential velocity is reversed.
    ///
    /// # Errors
    /// [`ElasticityError::Tangential`] with the value, if it is beyond ±1 or NaN.
    pub fn with_tangential(self, tangential: f64) -> Result<Self, ElasticityError> {
        if (-1.0..=1.0).contains(&tangential) {
            Ok(Self { tangential, ..self })
        } else {
            Err(ElasticityError::Tangential(tangential))
        }
    }

    /// The same contact with a coefficient of friction μ, at least 0: the surfaces slide where the
    /// tangential impulse would exceed μ times the normal one. Infinite: they never slide.
    ///
    /// # Errors
    /// [`ElasticityError::Friction`] with the value, if it is negative or NaN.
    pub fn with_friction(self, friction: f64) -> Result<Self, ElasticityError> {
        if friction >= 0.0 {
            Ok(Self { friction, ..self })
        } else {
            Err(ElasticityError::Friction(friction))
        }
    }

    /// The same contact with a transverse kick (mass × length / time): an impulse of this size on
    /// each of the two bodies, across the normal, which drives them counter-clockwise around each
    /// other, or clockwise if it is negative.
    ///
    /// # Errors
    /// [`ElasticityError::Kick`] with the value, if it is beyond ±10⁶⁰ or NaN.
    #[doc(alias = "chiral")]
    pub fn with_kick(self, kick: f64) -> Result<Self, ElasticityError> {
        if kick.abs() <= MAX_KICK {
            Ok(Self { kick, ..self })
        } else {
            Err(ElasticityError::Kick(kick))
        }
    }

    /// The same contact with a kick that is larger by a positive factor, for bodies with velocities
    /// in another unit of time.
    #[must_use]
    pub fn with_kick_times(self, factor: f64) -> Self {
        Self {
            kick: self.kick * factor,
            ..self
        }
    }

    /// Returns the coefficient of restitution e.
    pub fn coefficient(self) -> f64 {
        self.coefficient
    }

    /// Returns the tangential restitution β, from −1 to 1.
    pub fn tangential(self) -> f64 {
        self.tangential
    }

    /// Returns the coefficient of friction μ, at least 0; infinite if the surfaces never slide.
    pub fn friction(self) -> f64 {
        self.friction
    }

    /// Returns the transverse kick (mass × length / time).
    pub fn kick(self) -> f64 {
        self.kick
    }

    /// Whether the impulse is along the normal: β is −1 or μ is 0, and there is no kick.
    #[inline]
    pub fn is_smooth(self) -> bool {
        (self.tangential == -1.0 || self.friction == 0.0) && self.kick == 0.0
    }

    /// Whether the contact conserves the energy: e is 1, and the surfaces are smooth or perfectly
    /// rough (β = 1 without sliding and without a kick).
    #[inline]
    pub fn conserves_energy(self) -> bool {
        let is_perfectly_rough =
            self.tangential == 1.0 && self.friction == f64::INFINITY && self.kick == 0.0;
        self.coefficient == 1.0 && (self.is_smooth() || is_perfectly_rough)
    }
}

impl Default for Elasticity {
    fn default() -> Self {
        Self::ELASTIC
    }
}
