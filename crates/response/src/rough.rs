//! The impulse of a rough contact: Walton's rule with tangential restitution and friction.
//!
//! Walton and Braun (J. Rheol. 30 (1986) 949) and Foerster et al. (Phys. Fluids 6 (1994) 1108) give
//! the rule for spheres, whose normal and tangential impulses do not affect each other. For bodies
//! of any shape they do, and this is the extension used here. Let g be the velocity of A's surface
//! less that of B's at the point of contact, u = g·n > 0 and g_t = g·t its components along the
//! normal n and the tangent t, and A the matrix by which an impulse J on B changes it,
//! g′ = g − A J:
//!
//! A = (1/m_A + 1/m_B) 1 + p_A p_Aᵀ/I_A + p_B p_Bᵀ/I_B with p = (r × n, r × t)
//!
//! and the arms r from the centres of mass to the point of contact.
//!
//! 1. The normal impulse alone changes the tangential velocity by A_nt/A_nn for each unit of the
//!    normal velocity. At the instant at which the surfaces no longer approach, the tangential
//!    velocity is c = g_t − (A_nt/A_nn) u.
//! 2. A tangential impulse J_t with the normal impulse −(A_nt/A_nn) J_t leaves the normal velocity
//!    as it is, and changes c by −J_t/m_t, with 1/m_t = A_tt − A_nt²/A_nn.
//! 3. The contact that sticks has J_t = (1 + β) m_t c, so that c′ = −β c, and J_n =
//!    (1 + e) u/A_nn − (A_nt/A_nn) J_t, so that u′ = −e u.
//! 4. The energy in the motion of the surfaces is ½ (u²/A_nn + m_t c²), without a mixed term. It
//!    changes by −½ (1 − e²) u²/A_nn − ½ (1 − β²) m_t c²: never up for e ≤ 1, and not at all for
//!    e = 1 and β = ±1. At β = −1 the contact is smooth, and g′ = −g at e = β = 1.
//! 5. The contact slides where |J_t| would exceed μ J_n. Then |J_t| = μ J_n, with the sign of the
//!    contact that sticks; c changes by less, and u′ = −e u still holds.
//!
//! Discs have A_nt = 0 and 1/m_t = 1/m_A + 1/m_B + R_A²/I_A + R_B²/I_B: Walton's rule. With
//! infinite friction J_n may be negative for a molecule whose tangential impulse drives the
//! surfaces together; like teeth, they then hold on to each other for an instant. Any finite μ
//! excludes it.

use carom_kinematics::{Inertia, Motion};
use glam::DVec2;

use crate::{ContactFrame, Elasticity, contact_frame::scaled_inverse_masses};

/// The impulse on B (mass × length / time). `frame` has arms to the point of contact, and its line
/// of centres may have any length but 0: the length cancels, and one that differs between contacts
/// spreads the rounding errors.
pub(crate) fn rough_impulse(
    frame: &ContactFrame,
    bodies: [(&Motion, &Inertia); 2],
    elasticity: Elasticity,
) -> DVec2 {
    let d = frame.line_of_centres;
    let tangent = d.perp();
    let [(motion_a, inertia_a), (motion_b, inertia_b)] = bodies;
    let relative = motion_a.velocity_of(frame.arms[0]) - motion_b.velocity_of(frame.arms[1]);
    let (approach, slip) = (relative.dot(d), relative.dot(tangent));
    // The components of A for the axes d and its perpendicular.
    let inverse_masses = [inertia_a.inverse_mass, inertia_b.inverse_mass];
    let straight = scaled_inverse_masses(d, inverse_masses);
    let turning = |of: fn([f64; 2]) -> f64| {
        let levers = frame
            .arms
            .map(|arm| [arm.perp_dot(d), arm.perp_dot(tangent)]);
        of(levers[0]) * inertia_a.inverse_moment + of(levers[1]) * inertia_b.inverse_moment
    };
    let along_normal = straight + turning(|[n, _]| n * n);
    let along_tangent = straight + turning(|[_, t]| t * t);
    let mixed = turning(|[n, t]| n * t);
    if !(approach > 0.0 && along_normal > 0.0) {
        return DVec2::ZERO;
    }
    let ratio = mixed / along_normal;
    let normal = (1.0 + elasticity.coefficient()) * approach / along_normal;
    let sticking = (1.0 + elasticity.tangential()) * (slip - ratio * approach)
        / (along_tangent - ratio * mixed);
    let sliding = if elasticity.is_smooth() || sticking == 0.0 {
        0.0
    } else {
        slid(sticking, normal, ratio, elasticity.friction())
    };
    let across = sliding + elasticity.kick() / d.length_squared().sqrt();
    (normal - ratio * across) * d + across * tangent
}

/// The tangential impulse after friction, where one that sticks would be `sticking`, and the normal
/// one is `normal` less `ratio` times the tangential one.
fn slid(sticking: f64, normal: f64, ratio: f64, friction: f64) -> f64 {
    if friction == f64::INFINITY {
        return sticking;
    }
    // |J_t| ≤ μ (J_n − ratio J_t). With a divisor below 0, the normal impulse grows faster than the
    // friction needs: the surfaces wedge, and stick at any speed.
    let divisor = 1.0 + friction * ratio * sticking.signum();
    let most = friction * normal;
    if sticking.abs() * divisor <= most {
        sticking
    } else {
        sticking.signum() * most / divisor
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Impact, Response, apply_impulse};
    use carom_kinematics::{angular_momentum, kinetic_energy, momentum};
    use proptest::prelude::*;

    fn elasticity(e: f64, tangential: f64, friction: f64) -> Elasticity {
        Elasticity::new(e)
            .and_then(|elasticity| elasticity.with_tangential(tangential))
            .and_then(|elasticity| elasticity.with_friction(friction))
            .unwrap()
    }

    /// Two discs of mass 2 and 3 and radius 0.5 and 1 that touch along x, with these velocities and
    /// spins, after their contact.
    fn discs(motions: [([f64; 2], f64); 2], elasticity: Elasticity) -> [Motion; 2] {
        let inertias = [Inertia::free(2.0, 0.25), Inertia::free(3.0, 1.5)];
        let [a, b] = [0, 1].map(|n| Motion {
            velocity: motions[n].0.into(),
            angular_velocity: motions[n].1,
            ..Motion::at_rest([DVec2::ZERO, DVec2::X * 1.5][n])
        });
        let frame = ContactFrame {
            line_of_centres: DVec2::X * 1.5,
            arms: [DVec2::X * 0.5, -DVec2::X],
        };
        let bodies = [(&a, &inertias[0]), (&b, &inertias[1])];
        let impulse = Impact.impulse(&frame, bodies, elasticity);
        [
            apply_impulse(&a, &inertias[0], frame.arms[0], -impulse),
            apply_impulse(&b, &inertias[1], frame.arms[1], impulse),
        ]
    }

    #[test]
    fn discs_that_stick_follow_walton() {
        // 1/m_t = 1/2 + 1/3 + 0.25/0.25 + 1/1.5 = 2.5, and g_t = 1 + 0.5 · 2 − (−1 · 4) = 6.
        let start = [([1.0, 1.0], 2.0), ([0.0, 0.0], 4.0)];
        for (beta, across) in [(-1.0, 0.0), (0.0, 2.4), (0.5, 3.6), (1.0, 4.8)] {
            let [a, b] = discs(start, elasticity(0.5, beta, f64::INFINITY));
            // J_n = 1.5 · 1/(1/2 + 1/3) = 1.8.
            assert!((a.velocity - DVec2::new(1.0 - 0.9, 1.0 - across / 2.0)).length() < 1e-14);
            assert!((b.velocity - DVec2::new(0.6, across / 3.0)).length() < 1e-14);
            assert!((a.angular_velocity - (2.0 - 0.5 * across / 0.25)).abs() < 1e-14);
            assert!((b.angular_velocity - (4.0 - across / 1.5)).abs() < 1e-14);
        }
    }

    #[test]
    fn discs_that_slide_have_the_tangential_impulse_of_coulomb() {
        let start = [([1.0, 1.0], 2.0), ([0.0, 0.0], 4.0)];
        for (friction, across) in [(0.0, 0.0), (0.1, 0.18), (1.0, 1.8), (1.5, 2.4)] {
            let [a, _] = discs(start, elasticity(0.5, 0.0, friction));
            assert!(
                (a.velocity - DVec2::new(0.1, 1.0 - across / 2.0)).length() < 1e-14,
                "{friction}"
            );
        }
    }

    #[test]
    fn a_kick_drives_discs_counter_clockwise_around_each_other() {
        let kicked = Elasticity::ELASTIC.with_kick(0.3).unwrap();
        let [a, b] = discs([([1.0, 0.0], 0.0), ([0.0, 0.0], 0.0)], kicked);
        assert!((a.velocity.y + 0.15).abs() < 1e-15 && (b.velocity.y - 0.1).abs() < 1e-15);
        // The point of contact is the lever: angular momentum goes from the spins to the orbit.
        assert!((a.angular_velocity + 0.6).abs() < 1e-15);
        assert!((b.angular_velocity + 0.2).abs() < 1e-15);
    }

    proptest! {
        #[test]
        fn rough_contacts_of_any_bodies_keep_their_laws(
            masses in (0.1..10.0f64, 0.01..1.0f64, 0.1..10.0f64, 0.01..1.0f64),
            kinds in (0..3u8, 0..3u8),
            arms in ((-1.0..1.0f64, -1.0..1.0f64), (-1.0..1.0f64, -1.0..1.0f64)),
            a in (-1.0..1.0f64, -1.0..1.0f64, -2.0..2.0f64),
            b in (-1.0..1.0f64, -1.0..1.0f64, -2.0..2.0f64),
            angle in 0.0..std::f64::consts::TAU,
            (e, beta, friction) in (0.0..=1.0f64, -1.0..=1.0f64, 0.0..2.0f64),
            exact in 0..4u8,
        ) {
            let inertia = |kind, mass, moment| match kind {
                0 => Inertia::locked(mass),
                1 => Inertia::FIXED,
                _ => Inertia::free(mass, moment),
            };
            let inertias = [inertia(kinds.0, masses.0, masses.1), inertia(kinds.1, masses.2, masses.3)];
            prop_assume!(!(inertias[0].is_fixed() && inertias[1].is_fixed()));
            let motion = |(x, y, spin): (f64, f64, f64), inertia: &Inertia| {
                let moves = |value: f64, inverse: f64| if inverse > 0.0 { value } else { 0.0 };
                let mut motion = Motion::at_rest(DVec2::ZERO);
                motion.velocity = DVec2::new(moves(x, inertia.inverse_mass), moves(y, inertia.inverse_mass));
                motion.angular_velocity = moves(spin, inertia.inverse_moment);
                motion
            };
            let arms: [DVec2; 2] = [arms.0.into(), arms.1.into()];
            let [mut a, mut b] = [motion(a, &inertias[0]), motion(b, &inertias[1])];
            // The point of contact is the origin.
            (a.position, b.position) = (-arms[0], -arms[1]);
            let frame = ContactFrame { line_of_centres: 0.7 * DVec2::from_angle(angle), arms };
            let law = match exact {
                0 => elasticity(1.0, 1.0, f64::INFINITY),
                1 => elasticity(e, beta, f64::INFINITY),
                _ => elasticity(e, beta, friction),
            };
            let normal = frame.normal();
            let surface = |motions: [&Motion; 2]| motions[0].velocity_of(arms[0]) - motions[1].velocity_of(arms[1]);
            let before = surface([&a, &b]);
            let impulse = Impact.impulse(&frame, [(&a, &inertias[0]), (&b, &inertias[1])], law);
            if before.dot(normal) <= 0.0 {
                prop_assert_eq!(impulse, DVec2::ZERO);
                return Ok(());
            }
            let after = [
                apply_impulse(&a, &inertias[0], arms[0], -impulse),
                apply_impulse(&b, &inertias[1], arms[1], impulse),
            ];
            let now = surface([&after[0], &after[1]]);
            let scale = 1.0 + impulse.length() * 100.0;
            prop_assert!((now.dot(normal) + law.coefficient() * before.dot(normal)).abs() < 1e-12 * scale);
            let energy = |motions: [&Motion; 2]| {
                kinetic_energy(motions[0], &inertias[0]) + kinetic_energy(motions[1], &inertias[1])
            };
            let (first, last) = (energy([&a, &b]), energy([&after[0], &after[1]]));
            prop_assert!(last <= first + 1e-12 * (first + last));
            if law.conserves_energy() {
                prop_assert!((last - first).abs() <= 1e-12 * (first + last));
                prop_assert!((now + before).length() < 1e-11 * scale);
            }
            let (across, along) = (impulse.dot(normal.perp()), impulse.dot(normal));
            let holds = law.friction() == f64::INFINITY || across.abs() <= law.friction() * along + 1e-12 * scale;
            prop_assert!(holds, "{} {}", across, along);
            let total = |motions: [&Motion; 2], of: &dyn Fn(&Motion, &Inertia) -> f64| {
                of(motions[0], &inertias[0]) + of(motions[1], &inertias[1])
            };
            if inertias.iter().all(|inertia| inertia.inverse_moment > 0.0) {
                for of in [
                    &|m: &Motion, i: &Inertia| momentum(m, i).x,
                    &|m: &Motion, i: &Inertia| angular_momentum(m, i, DVec2::new(3.0, -2.0)),
                ] as [&dyn Fn(&Motion, &Inertia) -> f64; 2] {
                    let change = total([&after[0], &after[1]], of) - total([&a, &b], of);
                    prop_assert!(change.abs() < 1e-12 * scale);
                }
            }
        }

        #[test]
        fn without_roughness_the_impulse_is_the_smooth_one(
            velocity in (-1.0..1.0f64, -1.0..1.0f64), spin in -2.0..2.0f64, angle in 0.0..std::f64::consts::TAU, e in 0.0..=1.0f64,
        ) {
            let inertia = Inertia::free(2.0, 0.3);
            let mut a = Motion::at_rest(DVec2::ZERO);
            (a.velocity, a.angular_velocity) = (velocity.into(), spin);
            let b = Motion::at_rest(DVec2::X);
            let frame = ContactFrame {
                line_of_centres: DVec2::from_angle(angle),
                arms: [DVec2::new(0.3, 0.4), DVec2::new(-0.2, 0.1)],
            };
            let bodies = [(&a, &inertia), (&b, &inertia)];
            let smooth = Impact.impulse(&frame, bodies, elasticity(e, -1.0, f64::INFINITY));
            let rough = rough_impulse(&frame, bodies, elasticity(e, -1.0, 0.5));
            prop_assert!((smooth - rough).length() < 1e-14);
        }
    }
}
