//! Collision response: the impulse between two rigid bodies, and the velocities after it.
//!
//! Stable: its public items follow the policy of versions in the book (*Versions and releases*).
//!
//! Let n be the unit normal from A to B at the contact, r the arms from the centres of mass to the
//! touching atoms, and u = −n·(v_B + ω_B × r_B − v_A − ω_A × r_A) the speed of approach of the two
//! surfaces. An impulse J n on B and −J n on A changes u by −J/μ, where
//!
//! 1/μ = 1/m_A + 1/m_B + (r_A × n)²/I_A + (r_B × n)²/I_B.
//!
//! After a contact of elasticity e the surfaces separate with speed e u, hence **J = (1 + e) μ u**
//! (Montanari 2017, equation 2.9). A body whose rotation is locked has 1/I = 0 (equation 2.12); a
//! fixed body also has 1/m = 0. The energy decreases by ½ (1 − e²) μ u². Momentum is conserved
//! unless a body is fixed; angular momentum about the point of contact is conserved unless a
//! rotation is locked. These are smooth contacts; [`Impact`] also resolves rough ones, whose
//! impulse has a tangential part.
//!
//! ```
//! use carom_kinematics::{Inertia, Motion};
//! use carom_response::{ContactFrame, Elasticity, Impact, Response};
//! use glam::DVec2;
//!
//! // Equal discs in a head-on collision exchange their velocities.
//! let disc = Inertia::free(1.0, 0.5);
//! let a = Motion { velocity: DVec2::X, ..Motion::at_rest(DVec2::ZERO) };
//! let b = Motion::at_rest(DVec2::X);
//! let frame = ContactFrame { line_of_centres: DVec2::X, arms: [DVec2::ZERO; 2] };
//! let impulse = Impact.impulse(&frame, [(&a, &disc), (&b, &disc)], Elasticity::ELASTIC);
//! assert_eq!(impulse, DVec2::X);
//! ```

mod contact_frame;
mod elasticity;
mod impulse;
mod joint_impulses;
mod reflection;
mod rough;
mod step;
mod thermal_wall;

pub use contact_frame::{ContactFrame, approach_speed};
pub use elasticity::{Elasticity, ElasticityError, MAX_COEFFICIENT};
pub use impulse::{Impact, apply_impulse, reduced_mass};
pub use step::impulse_at_step;
pub use thermal_wall::{ThermalDraw, thermal_motion};

use carom_kinematics::{Inertia, Motion};
use glam::DVec2;

/// Computes the impulse of a contact; implement it for another law of collision.
///
/// The result of each method must depend on its arguments and on constants of the response alone.
/// The engine may resolve contacts in any order, in parallel, or more than once, and a resumed run
/// must give the same results: a counter or a random generator in a response violates all three. A
/// response with random elasticities derives them from the bits of the velocities, which differ
/// from contact to contact:
///
/// ```
/// use std::hash::{DefaultHasher, Hash, Hasher};
///
/// use carom_kinematics::{Inertia, Motion};
/// use carom_response::{ContactFrame, Elasticity, Impact, Response};
/// use glam::DVec2;
///
/// /// Elasticities uniformly distributed from e to 1, where e is that of the table.
/// struct RandomRestitution {
///     seed: u64,
/// }
///
/// impl Response for RandomRestitution {
///     fn impulse(
///         &self,
///         frame: &ContactFrame,
///         bodies: [(&Motion, &Inertia); 2],
///         e: Elasticity,
///     ) -> DVec2 {
///         let mut hasher = DefaultHasher::new();
///         self.seed.hash(&mut hasher);
///         let velocities = bodies.map(|(motion, _)| motion.velocity.to_array());
///         velocities.as_flattened().iter().for_each(|v| v.to_bits().hash(&mut hasher));
///         let share = (hasher.finish() >> 11) as f64 / (1u64 << 53) as f64;
///         let coefficient = 1.0 - share * (1.0 - e.coefficient());
///         Impact.impulse(frame, bodies, Elasticity::new(coefficient).expect("from e to 1"))
///     }
/// }
///
/// let disc = Inertia::free(1.0, 0.5);
/// let frame = ContactFrame { line_of_centres: DVec2::X, arms: [DVec2::ZERO; 2] };
/// let impulse = |velocity| {
///     let a = Motion { velocity, ..Motion::at_rest(DVec2::ZERO) };
///     let b = Motion::at_rest(DVec2::X);
///     let response = RandomRestitution { seed: 1 };
///     response.impulse(&frame, [(&a, &disc), (&b, &disc)], Elasticity::new(0.5).unwrap()).x
/// };
/// assert_eq!(impulse(DVec2::X), impulse(DVec2::X));
/// let (one, other) = (impulse(DVec2::X), impulse(DVec2::new(1.0, 0.1)));
/// assert!(one != other && one.min(other) > 0.75 && one.max(other) < 1.0);
/// ```
pub trait Response: Sync {
    /// The impulse on B (mass × length / time); A receives its opposite.
    /// Motions are those at the instant of contact, in the order A, B. `elasticity` is that of the
    /// table of the scene. The engine's guard against inelastic collapse passes a higher one, in
    /// most cases 1, if that of the table is below 1. The guard works only for a response that
    /// conserves the energy at elasticity 1 and loses little near it.
    fn impulse(
        &self,
        frame: &ContactFrame,
        bodies: [(&Motion, &Inertia); 2],
        elasticity: Elasticity,
    ) -> DVec2;

    /// The impulse on B (mass × length / time) of a contact that changes no angular velocity, as of
    /// two smooth discs.
    ///
    /// `line_of_centres` points from A to B, with any length but 0; velocities and inverse masses
    /// are in the order A, B. The result must equal [`Self::impulse`] with arms of length 0. The
    /// engine calls it with elasticity 1 only. The default calls that method; a response may
    /// override it with a faster computation.
    #[inline]
    fn impulse_of_discs(
        &self,
        line_of_centres: DVec2,
        velocities: [DVec2; 2],
        inverse_masses: [f64; 2],
        elasticity: Elasticity,
    ) -> DVec2 {
        let [a, b] = velocities.map(|velocity| Motion {
            velocity,
            ..Motion::at_rest(DVec2::ZERO)
        });
        let [inertia_a, inertia_b] = inverse_masses.map(|inverse_mass| Inertia {
            inverse_mass,
            inverse_moment: 0.0,
        });
        let frame = ContactFrame {
            line_of_centres,
            arms: [DVec2::ZERO; 2],
        };
        self.impulse(&frame, [(&a, &inertia_a), (&b, &inertia_b)], elasticity)
    }

    /// The impulses on B (mass × length / time) where two bodies touch at several points at one
    /// instant, in the order of `frames`; `None` if the points are to be resolved one by one, which
    /// is the default. The engine calls it for two or more points.
    fn joint_impulses(
        &self,
        frames: &[ContactFrame],
        bodies: [(&Motion, &Inertia); 2],
        elasticity: Elasticity,
    ) -> Option<Vec<DVec2>> {
        let _ = (frames, bodies, elasticity);
        None
    }

    /// Whether the impulse of contacts of this elasticity may have a part across the normal. The
    /// engine then passes arms to the point of contact, where the impulse acts, and discs turn. The
    /// default is correct for a response whose impulse is along the normal unless the elasticity
    /// says otherwise.
    #[inline]
    fn is_rough(&self, elasticity: Elasticity) -> bool {
        !elasticity.is_smooth()
    }

    /// Whether contacts of this elasticity conserve the kinetic energy, to rounding. The engine
    /// computes and records the change of energy of all other contacts. The default is `false`,
    /// which is correct for each response.
    #[inline]
    fn conserves_energy(&self, elasticity: Elasticity) -> bool {
        let _ = elasticity;
        false
    }

    /// The velocity of a disc, or of any body that does not turn at the contact, after an elastic
    /// contact with a fixed body, if the response can round it better than the velocity less the
    /// impulse over the mass. The default, `None`, selects the latter.
    ///
    /// `line_of_centres` points from the body to the fixed one and has any length but 0.
    #[inline]
    fn reflected(&self, line_of_centres: DVec2, velocity: DVec2) -> Option<DVec2> {
        let _ = (line_of_centres, velocity);
        None
    }
}
