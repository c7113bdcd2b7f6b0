//! Checks of the tangential impulse of a rough contact: it sticks with c' = −β c, or slides with
//! |J_t| = μ J_n; and the energy that it takes.
//!
//! With w the velocity of the second surface relative to that of the first, n the normal and t the
//! tangent, the matrix A of the velocities that a unit impulse gives (w' = w + A J) has the
//! components A_nn, A_nt and A_tt. The slip c = (A_nt/A_nn) w·n − w·t changes by −J_t/m_t alone,
//! 1/m_t = A_tt − A_nt²/A_nn, whatever the normal impulse is.

use carom::engine::CollisionReport;

use super::{
    kinematics::{BodyPair, NormalSpeeds, TouchedParts, cross, dot, length},
    vectors::U,
};
use crate::fuzz::subject::{Report, exceeds};

/// A rough contact, with what has been measured of it.
pub struct RoughContact<'a> {
    /// The report.
    pub contact: &'a CollisionReport<'a>,
    /// The touching parts, with arms to the point of contact.
    pub touch: &'a TouchedParts,
    /// Velocity of the second surface relative to the first, before and after (length per time).
    pub velocities: [BodyPair; 2],
    /// Speeds along the normal, with a bound on the error of each speed.
    pub speeds: NormalSpeeds,
    /// Bound on the error of the arms (length).
    pub arm_error: f64,
    /// Bound on the error of the normal (radians).
    pub normal_error: f64,
    /// Largest speed of separation that may come in addition to that of the law (length per time).
    pub added: f64,
}

/// The energy that a tangential impulse takes, and a bound on its error (mass × length² / time²).
#[derive(Debug, Clone, Copy, Default)]
pub struct TangentialLoss {
    /// The energy.
    pub lost: f64,
    /// Bound on the error, of the normal part too.
    pub error: f64,
}

/// The matrix A in the axes of a contact.
struct Mobility {
    /// A_nn (1 / mass).
    normal: f64,
    /// A_nt / A_nn.
    ratio: f64,
    /// 1/m_t (1 / mass).
    inverse_mass: f64,
    /// Bound on the error of the ratio.
    ratio_error: f64,
    /// Bounds on the errors of `normal` and of `inverse_mass` (1 / mass).
    errors: [f64; 2],
}

/// Largest velocity that an impulse gives the two surfaces, of which roundings are a share (length
/// per time).
pub fn pushed_speed(contact: &CollisionReport<'_>, touch: &TouchedParts) -> f64 {
    let size = length(contact.impulse.to_array());
    let of_side = |n: usize| {
        let inertia = contact.sides[n].body.inertia();
        inertia.inverse_mass + inertia.inverse_moment * dot(touch.arms[n], touch.arms[n])
    };
    size * (of_side(0) + of_side(1))
}

impl RoughContact<'_> {
    fn tangent(&self) -> BodyPair {
        let [x, y] = self.touch.normal;
        [-y, x]
    }

    fn mobility(&self) -> Mobility {
        let (n, t) = (self.touch.normal, self.tangent());
        let [mut normal, mut mixed, mut across, mut error] = [0.0; 4];
        for (side, arm) in self.contact.sides.iter().zip(self.touch.arms) {
            let inertia = side.body.inertia();
            let (mass, moment) = (inertia.inverse_mass, inertia.inverse_moment);
            let [along_n, along_t] = [cross(arm, n), cross(arm, t)];
            normal += mass + moment * along_n * along_n;
            mixed += moment * along_n * along_t;
            across += mass + moment * along_t * along_t;
            let size = length(arm);
            let lever_error = self.arm_error + size * (self.normal_error + 8.0 * U);
            error += 8.0 * U * mass + 2.0 * moment * lever_error * (size + lever_error);
        }
        let ratio = mixed / normal;
        Mobility {
            normal,
            ratio,
            inverse_mass: across - ratio * mixed,
            ratio_error: error * (1.0 + ratio.abs()) / normal,
            errors: [error, error * (1.0 + ratio.abs()).powi(2)],
        }
    }

    /// Checks the tangential impulse against the coefficients of the report.
    pub fn check(&self, report: &mut Report) -> TangentialLoss {
        let mobility = self.mobility();
        let Mobility {
            ratio,
            inverse_mass,
            ..
        } = mobility;
        let elasticity = self.contact.elasticity;
        let (beta, kick) = (elasticity.tangential(), elasticity.kick());
        let impulse = self.contact.impulse.to_array();
        let size = length(impulse);
        let impulse_error = size * (self.normal_error + 32.0 * U) + 32.0 * U * kick.abs();
        let slip = |velocity: BodyPair| {
            ratio * dot(velocity, self.touch.normal) - dot(velocity, self.tangent())
        };
        let [before, after] = self.velocities.map(slip);
        let largest = self.velocities.map(length).into_iter().fold(0.0, f64::max);
        let slip_error = (1.0 + ratio.abs()) * self.speeds.error + mobility.ratio_error * largest;
        let across = dot(impulse, self.tangent());
        // Bodies that approach by no more than rounding may have no impulse of the law at all.
        let is_idle = !exceeds(self.speeds.approach, self.speeds.error)
            && !exceeds(across.abs(), impulse_error);
        let sticking_error = (1.0 + beta.abs()) * slip_error
            + kick.abs() * (mobility.errors[1] + 8.0 * U * inverse_mass);
        let off = after + beta * before + kick * inverse_mass;
        let sticks = !exceeds(off.abs(), sticking_error);
        let friction = Friction::new(self, &mobility, impulse_error);
        let least_error =
            (1.0 + beta) * (slip_error + before.abs() * mobility.errors[1] / inverse_mass);
        let sticking = (1.0 + beta) * before / inverse_mass;
        let slides =
            friction.is_at_limit() && !friction.is_more_than(sticking, least_error / inverse_mass);
        if !(is_idle || (sticks && !friction.is_beyond_limit()) || slides) {
            report.fail(
                "tangential",
                format!(
                    "slip {before:e} becomes {after:e}, impulse {across:e} across the normal and \
                     {:e} along it, {elasticity:?}, allowed {sticking_error:e}",
                    dot(impulse, self.touch.normal)
                ),
            );
        }
        if sticks {
            report.keep_worst("slip/bound", off.abs() / sticking_error);
        }
        let kind = match (is_idle, sticks) {
            (true, _) => "idle",
            (false, true) => "stuck",
            (false, false) => "slid",
        };
        report.count(kind, 1);
        self.loss(&mobility, (before, slip_error), (across, impulse_error))
    }

    /// The energy that an impulse across the normal takes from the slip before it.
    fn loss(
        &self,
        mobility: &Mobility,
        (slip, slip_error): (f64, f64),
        (across, impulse_error): (f64, f64),
    ) -> TangentialLoss {
        let back = across * mobility.inverse_mass;
        let of_slip = impulse_error * (slip.abs() + back.abs())
            + across.abs() * (slip_error + across.abs() * mobility.errors[1]);
        // The normal part has the errors of A_nn and of the speeds. Its impulse is that of the
        // report and what the tangential one takes from it.
        let [approach, added] = [self.speeds.approach, self.added];
        let coefficient = 1.0 + self.contact.elasticity.coefficient();
        let of_normal = approach * approach * mobility.errors[0] / mobility.normal
            + added * added
            + approach.abs() * self.speeds.error;
        TangentialLoss {
            lost: across * (slip - 0.5 * back),
            error: 4.0 * (of_slip + coefficient * coefficient * of_normal / mobility.normal),
        }
    }
}

/// The tangential impulse without the kick, and its limit μ J_n.
struct Friction {
    /// J_t (mass × length / time).
    across: f64,
    /// μ J_n (mass × length / time); infinite if the surfaces never slide.
    limit: f64,
    /// Bound on the error of both (mass × length / time).
    error: f64,
}

impl Friction {
    fn new(contact: &RoughContact<'_>, mobility: &Mobility, impulse_error: f64) -> Self {
        let elasticity = contact.contact.elasticity;
        let (friction, kick) = (elasticity.friction(), elasticity.kick());
        let impulse = contact.contact.impulse.to_array();
        // The kick comes after friction, with a normal impulse of its own.
        let normal = dot(impulse, contact.touch.normal) + mobility.ratio * kick;
        let normal_error = impulse_error
            + mobility.ratio_error * (kick.abs() + length(impulse))
            + contact.added / mobility.normal;
        Self {
            across: dot(impulse, contact.tangent()) - kick,
            limit: friction * normal,
            error: impulse_error + friction * normal_error,
        }
    }

    fn is_at_limit(&self) -> bool {
        self.limit.is_finite() && !exceeds((self.across.abs() - self.limit).abs(), self.error)
    }

    fn is_beyond_limit(&self) -> bool {
        self.limit.is_finite() && exceeds(self.across.abs() - self.limit, self.error)
    }

    /// Returns true if the impulse is larger than that which sticks, or has the opposite sign.
    fn is_more_than(&self, sticking: f64, sticking_error: f64) -> bool {
        let along = self.across * sticking.signum();
        let error = self.error + sticking_error;
        exceeds(along - sticking.abs(), error) || exceeds(-along, error)
    }
}
