//! The quantities that free flight conserves: momentum, angular momentum, kinetic energy.

use glam::DVec2;

use crate::Motion;

/// The inverse mass and the inverse moment of inertia of a body; both are 0 for a fixed body.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Inertia {
    /// 1 / mass; 0 for a fixed body.
    pub inverse_mass: f64,
    /// 1 / moment of inertia; 0 for a body whose rotation is locked.
    #[doc(alias = "locked rotation")]
    pub inverse_moment: f64,
}

impl Inertia {
    /// A fixed body: the limit of infinite mass.
    #[doc(alias = "bumper")]
    pub const FIXED: Self = Self {
        inverse_mass: 0.0,
        inverse_moment: 0.0,
    };

    /// A body of given mass and moment of inertia.
    pub fn free(mass: f64, moment: f64) -> Self {
        Self {
            inverse_mass: 1.0 / mass,
            inverse_moment: 1.0 / moment,
        }
    }

    /// A body of given mass that cannot turn.
    pub fn locked(mass: f64) -> Self {
        Self {
            inverse_mass: 1.0 / mass,
            inverse_moment: 0.0,
        }
    }

    /// Whether the body cannot move at all.
    pub fn is_fixed(&self) -> bool {
        self.inverse_mass == 0.0
    }
}

/// Kinetic energy ½ m v² + ½ I ω² (mass × length² / time²); 0 for a fixed body.
///
/// ```
/// use carom_kinematics::{Inertia, Motion, kinetic_energy};
/// use glam::DVec2;
///
/// let motion = Motion { velocity: DVec2::new(3.0, 4.0), ..Motion::at_rest(DVec2::ZERO) };
/// assert_eq!(kinetic_energy(&motion, &Inertia::free(2.0, 1.0)), 25.0);
/// ```
pub fn kinetic_energy(motion: &Motion, inertia: &Inertia) -> f64 {
    let share = |speed_squared: f64, inverse: f64| {
        if inverse == 0.0 {
            0.0
        } else {
            0.5 * speed_squared / inverse
        }
    };
    share(motion.velocity.length_squared(), inertia.inverse_mass)
        + share(
            motion.angular_velocity * motion.angular_velocity,
            inertia.inverse_moment,
        )
}

/// Momentum m v (mass × length / time); 0 for a fixed body.
pub fn momentum(motion: &Motion, inertia: &Inertia) -> DVec2 {
    if inertia.is_fixed() {
        DVec2::ZERO
    } else {
        motion.velocity / inertia.inverse_mass
    }
}

/// Angular momentum about `about`, orbital and intrinsic: (x − about) × m v + I ω (mass × length² /
/// time).
pub fn angular_momentum(motion: &Motion, inertia: &Inertia, about: DVec2) -> f64 {
    let own = if inertia.inverse_moment == 0.0 {
        0.0
    } else {
        motion.angular_velocity / inertia.inverse_moment
    };
    (motion.position - about).perp_dot(momentum(motion, inertia)) + own
}
