//! The motion with which a body leaves a wall of a given temperature.
//!
//! Let u = (√m v_x, √m v_y, √I ω) be the motion of a body in mass-weighted coordinates, n the unit
//! normal from the wall to the body, r the arm from the centre of mass to the touching atom, and w
//! = (n_x/√m, n_y/√m, r × n/√I). The point of contact moves away from the wall with speed u·w, and
//! |w|² = 1/μ, the inverse reduced mass of the contact.
//!
//! 1. In equilibrium at kT the components of u are normal numbers of variance kT, in any orthogonal
//!    basis. The rate of contacts in a given configuration is the density of u times −u·w, where
//!    u·w is below 0.
//! 2. The body leaves with u′ of density proportional to (u′·w) exp(−|u′|²/2kT), where u′·w is
//!    above 0, whatever u is: along w a number of Rayleigh's distribution, p(s) = (s/kT)
//!    exp(−s²/2kT), and across w normal numbers of variance kT.
//! 3. The rate from u to u′ is then proportional to (−u·w) exp(−|u|²/2kT) (u′·w) exp(−|u′|²/2kT).
//!    It is that from −u′ to −u: detailed balance, for molecules of any shape. For a disc, w =
//!    n/√m, and this is the flux-weighted Maxwell distribution: the cosine law of Knudsen, Ann.
//!    Phys. 353 (1916) 1113.
//!
//! Rotation that contacts never change, of discs and of locked bodies, takes no part.

use carom_kinematics::{Inertia, Motion};
use glam::DVec2;

/// Numbers drawn for one contact with a thermal wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThermalDraw {
    /// Three independent standard normal numbers.
    pub normal: [f64; 3],
    /// A number of Rayleigh's distribution s exp(−s²/2), above 0.
    pub rayleigh: f64,
}

/// Returns the motion of a body after a contact with a fixed wall of temperature kT (mass × length²
/// / time²), at the same place and time.
///
/// `away` is the unit normal from the wall to the body, and `arm` points from the centre of mass to
/// the centre of the touching atom (length). `turns` says whether contacts change the angular
/// velocity of the body; otherwise it stays.
///
/// ```
/// use carom_kinematics::{Inertia, Motion};
/// use carom_response::{ThermalDraw, thermal_motion};
/// use glam::DVec2;
///
/// let disc = Inertia::free(4.0, 0.5);
/// let before = Motion { velocity: DVec2::new(1.0, -2.0), ..Motion::at_rest(DVec2::ZERO) };
/// let draw = ThermalDraw { normal: [0.5, 1.0, 0.0], rayleigh: 2.0 };
/// let after = thermal_motion(&before, &disc, DVec2::ZERO, DVec2::Y, 1.0, &draw, false);
/// // √(kT/m) = 1/2: along the wall the normal number, away from it that of Rayleigh.
/// assert_eq!(after.velocity, DVec2::new(0.25, 1.0));
/// ```
pub fn thermal_motion(
    before: &Motion,
    inertia: &Inertia,
    arm: DVec2,
    away: DVec2,
    temperature: f64,
    draw: &ThermalDraw,
    turns: bool,
) -> Motion {
    let (speed, spin) = (inertia.inverse_mass.sqrt(), inertia.inverse_moment.sqrt());
    let spin = if turns { spin } else { 0.0 };
    // w and its square.
    let (w, w_spin) = (speed * away, spin * arm.perp_dot(away));
    let square = w.length_squared() + w_spin * w_spin;
    let [x, y, z] = draw.normal;
    let drawn = DVec2::new(x, y);
    let drawn_spin = if turns { z } else { 0.0 };
    // Replaces the component of the normal numbers along w by that of Rayleigh.
    let along = drawn.dot(w) + drawn_spin * w_spin;
    let factor = (draw.rayleigh * square.sqrt() - along) / square;
    let thermal = temperature.sqrt();
    Motion {
        velocity: thermal * speed * (drawn + factor * w),
        angular_velocity: if turns {
            thermal * spin * (drawn_spin + factor * w_spin)
        } else {
            before.angular_velocity
        },
        ..*before
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_point_of_contact_leaves_with_the_drawn_speed() {
        let molecule = Inertia::free(2.0, 0.3);
        let away = DVec2::from_angle(0.7);
        let arm = DVec2::new(0.4, -0.9);
        let inverse = 0.5 + arm.perp_dot(away).powi(2) / 0.3;
        for k in 1..100 {
            let angle = f64::from(k);
            let normal = [angle.sin(), (2.0 * angle).cos(), (3.0 * angle).sin()];
            let draw = ThermalDraw {
                normal,
                rayleigh: 0.05 * angle,
            };
            let before = Motion::at_rest(DVec2::ONE);
            let after = thermal_motion(&before, &molecule, arm, away, 3.0, &draw, true);
            let speed = after.velocity_of(arm).dot(away);
            assert!((speed - draw.rayleigh * (3.0 * inverse).sqrt()).abs() < 1e-13);
            // Two directions across w keep their normal numbers: the tangent, and the motion about
            // the point of contact.
            let tangent = away.perp();
            assert!(
                (after.velocity.dot(tangent)
                    - 1.5f64.sqrt() * DVec2::new(normal[0], normal[1]).dot(tangent))
                .abs()
                    < 1e-13
            );
            let locked =
                thermal_motion(&before, &Inertia::locked(2.0), arm, away, 3.0, &draw, false);
            assert!((locked.velocity.dot(away) - draw.rayleigh * 1.5f64.sqrt()).abs() < 1e-13);
            assert_eq!(locked.angular_velocity, 0.0);
        }
    }
}
