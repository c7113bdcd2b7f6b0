//! The impulse of a smooth contact (equation 2.9 of Montanari 2017) and the motion after it.

#![allow(clippy::inline_always, reason = "compiled with the instructions of the caller")]

use carom_kinematics::{Inertia, Motion};
use glam::DVec2;

use crate::{Elasticity, Response, reflection::reflected};

/// The geometry of a contact: the direction of the normal and the lever arms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactFrame {
    /// Vector from the centre of the touching part of A to that of B, or any other vector along the
    /// normal with a length other than 0.
    pub line_of_centres: DVec2,
    /// Vectors from each centre of mass to the centre of the touching atom (length). The remaining
    /// vector to the point of contact is along the normal and has no moment.
    pub arms: [DVec2; 2],
}

impl ContactFrame {
    /// Unit vector from A to B at the point of contact.
    ///
    /// This uses the square root of the standard library, which compiles to an instruction of the
    /// same generation as the surrounding ones. glam's own uses an older instruction (SSE) in any
    /// case, for which code compiled for AVX waits hundreds of cycles.
    #[inline(always)]
    pub fn normal(&self) -> DVec2 {
        let d = self.line_of_centres;
        let inverse = 1.0 / d.length_squared().sqrt();
        if inverse.is_finite() && inverse > 0.0 { d * inverse } else { DVec2::X }
    }
}

/// Returns d rescaled: to length 1 along an axis, where that is exact, so that bodies that meet
/// along an axis exchange their speeds to the bit at each contact; elsewhere to a length that
/// differs between contacts.
///
/// Equal discs always touch at the same |d|. With d itself, d·d would take the same few rounded
/// values each time, rounded to one side more often than to the other. The energy would then drift
/// in proportion to the number of collisions, not to its square root. The digits of the relative
/// velocity g spread the length over a factor of 2; those of |g_x| + |g_y| do so symmetrically in
/// the two axes.
#[inline]
fn scaled(d: DVec2, g: DVec2) -> DVec2 {
    const DIGITS: u64 = (1 << 52) - 1;
    // One test instead of two; also 0 by underflow.
    let on_axis = d.x * d.y == 0.0 && (d.x == 0.0) != (d.y == 0.0);
    let spread = f64::from_bits((g.x.abs() + g.y.abs()).to_bits() & DIGITS | 1.0f64.to_bits());
    if on_axis { d / d.abs().max_element() } else { spread * d }
}

/// The instantaneous contact of smooth rigid bodies.
///
/// With d along the line of centres and g the velocity of A's surface less that of B's, the impulse
/// is
///
/// J = (1 + e) (g·d) d / (d·d (1/m_A + 1/m_B) + (r_A × d)²/I_A + (r_B × d)²/I_B).
///
/// The length of d cancels. It is not normalised, which would give nearly the same rounding error
/// each time, but rescaled differently at each contact, so that the rounding errors of many
/// contacts add up to a random walk.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Impact;

impl Response for Impact {
    fn impulse(
        &self,
        frame: &ContactFrame,
        bodies: [(&Motion, &Inertia); 2],
        elasticity: Elasticity,
    ) -> DVec2 {
        let [(motion_a, inertia_a), (motion_b, inertia_b)] = bodies;
        let d = scaled(frame.line_of_centres, motion_a.velocity - motion_b.velocity);
        let frame = ContactFrame { line_of_centres: d, ..*frame };
        let approach = scaled_approach(&frame, [motion_a, motion_b]);
        let yielding = scaled_inverse_mass(&frame, [inertia_a, inertia_b]);
        if approach > 0.0 && yielding > 0.0 {
            (1.0 + elasticity.coefficient()) * approach / yielding * d
        } else {
            DVec2::ZERO
        }
    }

    #[inline]
    fn impulse_of_discs(
        &self,
        line_of_centres: DVec2,
        [velocity_a, velocity_b]: [DVec2; 2],
        [inverse_mass_a, inverse_mass_b]: [f64; 2],
        elasticity: Elasticity,
    ) -> DVec2 {
        let relative = velocity_a - velocity_b;
        let d = scaled(line_of_centres, relative);
        let approach = relative.dot(d);
        let yielding = scaled_inverse_masses(d, [inverse_mass_a, inverse_mass_b]);
        if approach > 0.0 && yielding > 0.0 {
            (1.0 + elasticity.coefficient()) * approach / yielding * d
        } else {
            DVec2::ZERO
        }
    }

    #[inline]
    fn conserves_energy(&self, elasticity: Elasticity) -> bool {
        elasticity == Elasticity::ELASTIC
    }

    fn reflected(&self, line_of_centres: DVec2, velocity: DVec2) -> Option<DVec2> {
        let d = scaled(line_of_centres, velocity);
        // The motion is that of A, as in the impulse; the sign of d does not affect the reflection
        // itself.
        Some(if velocity.dot(d) > 0.0 { reflected(velocity, d) } else { velocity })
    }
}

/// Speed u at which the two surfaces approach each other along the normal (length / time); negative
/// if they separate.
pub fn approach_speed(frame: &ContactFrame, motions: [&Motion; 2]) -> f64 {
    scaled_approach(frame, motions) / frame.line_of_centres.length()
}

/// Reduced mass μ of the contact (mass); 0 if neither body can move.
pub fn reduced_mass(frame: &ContactFrame, inertias: [&Inertia; 2]) -> f64 {
    let inverse = scaled_inverse_mass(frame, inertias);
    if inverse > 0.0 { frame.line_of_centres.length_squared() / inverse } else { 0.0 }
}

/// u |d|
fn scaled_approach(frame: &ContactFrame, [a, b]: [&Motion; 2]) -> f64 {
    let d = frame.line_of_centres;
    let [arm_a, arm_b] = frame.arms;
    // The rotation enters as ω (r × d), which is exactly 0 for a disc.
    let translation = (a.velocity - b.velocity).dot(d);
    let rotation = a.angular_velocity * arm_a.perp_dot(d) - b.angular_velocity * arm_b.perp_dot(d);
    translation + rotation
}

/// |d|²/μ
fn scaled_inverse_mass(frame: &ContactFrame, [a, b]: [&Inertia; 2]) -> f64 {
    let d = frame.line_of_centres;
    let turning = |arm: DVec2, inertia: &Inertia| {
        let lever = arm.perp_dot(d);
        lever * lever * inertia.inverse_moment
    };
    scaled_inverse_masses(d, [a.inverse_mass, b.inverse_mass])
        + (turning(frame.arms[0], a) + turning(frame.arms[1], b))
}

/// Returns d·d (1/m_A + 1/m_B).
///
/// The sum of the inverse masses is not computed first, since for two given masses it always has
/// the same rounding error. Neither is d·d/m_A + d·d/m_B, since with 1/m_B = 1/3 the last digits of
/// the two terms depend on each other, so that ties are always rounded to the same side.
#[inline]
fn scaled_inverse_masses(d: DVec2, [a, b]: [f64; 2]) -> f64 {
    let (x, y) = (d.x * d.x, d.y * d.y);
    (x * a + y * b) + (y * a + x * b)
}

/// The motion of a body after `impulse` (mass × length / time) at the point `arm` relative to its
/// centre.
pub fn apply_impulse(motion: &Motion, inertia: &Inertia, arm: DVec2, impulse: DVec2) -> Motion {
    Motion {
        velocity: motion.velocity + impulse * inertia.inverse_mass,
        angular_velocity: motion.angular_velocity + arm.perp_dot(impulse) * inertia.inverse_moment,
        ..*motion
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_kinematics::{angular_momentum, kinetic_energy, momentum, two_product, two_sum};
    use proptest::prelude::*;

    const UNIT: f64 = 1.0;

    /// Two touching bodies with arbitrary masses and motions.
    #[derive(Debug, Clone)]
    struct Scene {
        frame: ContactFrame,
        point: DVec2,
        motions: [Motion; 2],
        inertias: [Inertia; 2],
    }

    /// Logarithmically uniform between 10^−6 and 10^6.
    fn masses() -> impl Strategy<Value = f64> {
        (-6.0..6.0f64).prop_map(|exponent| 10f64.powf(exponent))
    }

    fn bodies() -> impl Strategy<Value = (Motion, Inertia, DVec2)> {
        let numbers = (-1.0..1.0, -1.0..1.0, -2.0..2.0, -2.0..2.0, -5.0..5.0, -1.0..1.0, -1.0..1.0);
        (numbers, masses(), masses(), 0..4u8).prop_map(
            |((x, y, vx, vy, spin, rx, ry), mass, moment, kind): (
                (f64, f64, f64, f64, f64, f64, f64),
                _,
                _,
                _,
            )| {
                let motion = Motion {
                    velocity: DVec2::new(vx, vy),
                    angular_velocity: spin,
                    ..Motion::at_rest(DVec2::new(x, y))
                };
                match kind {
                    0 => (
                        Motion { angular_velocity: 0.0, ..motion },
                        Inertia::locked(mass),
                        DVec2::new(rx, ry),
                    ),
                    1 => (Motion::at_rest(motion.position), Inertia::FIXED, DVec2::new(rx, ry)),
                    _ => (motion, Inertia::free(mass, moment), DVec2::new(rx, ry)),
                }
            },
        )
    }

    fn scenes() -> impl Strategy<Value = Scene> {
        (bodies(), bodies(), 0.0..std::f64::consts::TAU, 0.0..1.0, 0.0..1.0).prop_map(
            |((a, inertia_a, arm_a), (b, inertia_b, arm_b), angle, radius_a, radius_b): (
                _,
                _,
                f64,
                f64,
                f64,
            )| {
                let normal = DVec2::from_angle(angle);
                let point = a.position + arm_a + radius_a * normal;
                let b = Motion { position: point + radius_b * normal - arm_b, ..b };
                Scene {
                    frame: ContactFrame {
                        line_of_centres: normal * (radius_a + radius_b + 0.1),
                        arms: [arm_a, arm_b],
                    },
                    point,
                    motions: [a, b],
                    inertias: [inertia_a, inertia_b],
                }
            },
        )
    }

    fn collide(scene: &Scene, elasticity: f64) -> (DVec2, [Motion; 2]) {
        let [a, b] = &scene.motions;
        let [ia, ib] = &scene.inertias;
        let elasticity = Elasticity::new(elasticity).unwrap();
        let impulse = Impact.impulse(&scene.frame, [(a, ia), (b, ib)], elasticity);
        let [arm_a, arm_b] = scene.frame.arms;
        (impulse, [apply_impulse(a, ia, arm_a, -impulse), apply_impulse(b, ib, arm_b, impulse)])
    }

    fn total<T: std::iter::Sum>(
        scene: &Scene,
        motions: &[Motion; 2],
        f: impl Fn(&Motion, &Inertia) -> T,
    ) -> T {
        motions.iter().zip(&scene.inertias).map(|(m, i)| f(m, i)).sum()
    }

    proptest! {
        #[test]
        fn discs_have_the_impulse_of_bodies_without_arms(scene in scenes(), e in 0.0..2.0f64, on_axis in any::<bool>()) {
            let [a, b] = &scene.motions;
            let line_of_centres = if on_axis { DVec2::new(0.0, -0.3) } else { scene.frame.line_of_centres };
            let frame = ContactFrame { line_of_centres, arms: [DVec2::ZERO; 2] };
            let elasticity = Elasticity::new(e).unwrap();
            let [ia, ib] = &scene.inertias;
            let expected = Impact.impulse(&frame, [(a, ia), (b, ib)], elasticity);
            let masses = [ia.inverse_mass, ib.inverse_mass];
            let short = Impact.impulse_of_discs(line_of_centres, [a.velocity, b.velocity], masses, elasticity);
            prop_assert_eq!(short, expected);
        }

        #[test]
        fn surfaces_separate_with_elasticity_times_the_speed_of_approach(scene in scenes(), e in 0.0..2.0f64) {
            let before = approach_speed(&scene.frame, [&scene.motions[0], &scene.motions[1]]);
            let movable = scene.inertias.iter().any(|i| !i.is_fixed());
            prop_assume!(before > 1e-6 && movable);
            let (_, after) = collide(&scene, e);
            let parting = -approach_speed(&scene.frame, [&after[0], &after[1]]);
            let scale = after.iter().map(|m| m.velocity.length() + m.angular_velocity.abs()).sum::<f64>();
            prop_assert!((parting - e * before).abs() < 1e-13 * (UNIT + scale));
        }

        #[test]
        fn momentum_is_conserved(scene in scenes(), e in 0.0..2.0f64) {
            let (impulse, after) = collide(&scene, e);
            prop_assume!(scene.inertias.iter().all(|i| !i.is_fixed()));
            let change = total(&scene, &after, momentum) - total(&scene, &scene.motions, momentum);
            let scale = impulse.length() + total(&scene, &scene.motions, |m, i| momentum(m, i).length());
            prop_assert!(change.length() <= 1e-14 * scale, "{change} of {scale}");
        }

        #[test]
        fn angular_momentum_about_the_contact_is_conserved(scene in scenes(), e in 0.0..2.0f64) {
            let (impulse, after) = collide(&scene, e);
            // For each body separately: the impulse has no moment about the point of contact.
            for ((inertia, before), after) in scene.inertias.iter().zip(&scene.motions).zip(&after) {
                prop_assume!(inertia.inverse_moment > 0.0);
                let about = |m: &Motion| angular_momentum(m, inertia, scene.point);
                let scale = 4.0 * impulse.length() + about(before).abs()
                    + before.angular_velocity.abs() / inertia.inverse_moment
                    + 4.0 * momentum(before, inertia).length();
                prop_assert!((about(after) - about(before)).abs() <= 1e-14 * scale);
            }
        }

        #[test]
        fn energy_changes_as_the_elasticity_requires(scene in scenes(), e in 0.0..2.0f64) {
            let approach = approach_speed(&scene.frame, [&scene.motions[0], &scene.motions[1]]);
            let mass = reduced_mass(&scene.frame, [&scene.inertias[0], &scene.inertias[1]]);
            let (_, after) = collide(&scene, e);
            let before = total(&scene, &scene.motions, kinetic_energy);
            let change = total(&scene, &after, kinetic_energy) - before;
            let expected = if approach > 0.0 { -0.5 * (1.0 - e * e) * mass * approach * approach } else { 0.0 };
            let scale = before + mass * approach * approach;
            prop_assert!((change - expected).abs() <= 1e-13 * scale, "{change} against {expected}");
        }

        #[test]
        fn exchanging_the_bodies_reverses_the_impulse(scene in scenes(), e in 0.0..2.0f64) {
            let (impulse, _) = collide(&scene, e);
            let [a, b] = scene.motions;
            let mirrored = Scene {
                frame: ContactFrame {
                    line_of_centres: -scene.frame.line_of_centres,
                    arms: [scene.frame.arms[1], scene.frame.arms[0]],
                },
                motions: [b, a],
                inertias: [scene.inertias[1], scene.inertias[0]],
                ..scene
            };
            prop_assert_eq!(collide(&mirrored, e).0, -impulse);
        }
    }

    /// The exact energy gains by impulses between elastic discs that touch at one distance from all
    /// sides.
    fn gains(masses: [f64; 2], distance: f64) -> Vec<f64> {
        let golden = 0.5 * (5.0f64.sqrt() - 1.0);
        let turn =
            |k: u32, share: f64| DVec2::from_angle(std::f64::consts::TAU * (f64::from(k) * share).fract());
        let dot = |a: DVec2, b: DVec2| {
            let ((x, x_rest), (y, y_rest)) = (two_product(a.x, b.x), two_product(a.y, b.y));
            let (sum, rest) = two_sum(x, y);
            (sum, rest + (x_rest + y_rest))
        };
        let inverse = masses.map(|mass| 1.0 / mass);
        (1..400_000)
            .filter_map(|k| {
                let place = DVec2::splat(0.5);
                let d = (place + distance * turn(k, golden)) - place;
                let velocity = (0.5 + (f64::from(k) * 3f64.sqrt()).fract()) * turn(k, 2f64.sqrt());
                let j = Impact.impulse_of_discs(d, [velocity, DVec2::ZERO], inverse, Elasticity::ELASTIC);
                // −g·J + ½ J² (1/m_A + 1/m_B)
                let (approach, square) = (dot(velocity, j), dot(j, j));
                let (sum, sum_rest) = two_sum(0.5 * inverse[0], 0.5 * inverse[1]);
                let (product, product_rest) = two_product(square.0, sum);
                let rest = product_rest + (square.1 * sum + square.0 * sum_rest) - approach.1;
                (j != DVec2::ZERO).then_some((product - approach.0) + rest)
            })
            .collect()
    }

    /// The sum of the gains in standard errors of the sum.
    fn bias(gains: &[f64]) -> f64 {
        gains.iter().sum::<f64>() / gains.iter().map(|gain| gain * gain).sum::<f64>().sqrt()
    }

    #[test]
    fn inverse_masses_whose_sum_is_rounded_gain_no_energy() {
        // Rounded as one sum, 1/60 + 1 is too small by half a unit in the last place, at each
        // contact.
        for masses in [[60.0, 1.0], [1.0, 3.0], [3.0, 1.0], [1.0, 2.0], [5.0, 7.0], [1.0, 1e-3], [7.0, 1.1]] {
            let bias = bias(&gains(masses, 0.04));
            assert!(bias.abs() < 4.0, "{masses:?}: {bias} standard errors");
        }
    }

    #[test]
    fn the_same_distance_at_each_contact_gains_no_energy() {
        for distance in [0.25, 0.3, 0.04, 0.02] {
            let bias = bias(&gains([1.0, 1.0], distance));
            assert!(bias.abs() < 4.0, "{distance}: {bias} standard errors");
        }
    }

    #[test]
    fn a_disc_that_hits_the_end_of_a_dumbbell_has_the_known_outcome() {
        // A dumbbell of two unit discs of radius ½ at ±½, at rest, whose one atom is hit by a unit
        // disc with unit speed: J = 2/(1 + 1/2 + a²/I) with a = ½ and I = 3/4, hence 12/11.
        let dumbbell = Inertia::free(2.0, 0.75);
        let disc = Inertia::free(1.0, 0.125);
        let a = Motion::at_rest(DVec2::ZERO);
        let b = Motion { velocity: DVec2::NEG_Y, ..Motion::at_rest(DVec2::new(0.5, 1.0)) };
        let frame = ContactFrame { line_of_centres: DVec2::Y, arms: [DVec2::new(0.5, 0.0), DVec2::ZERO] };
        let impulse = Impact.impulse(&frame, [(&a, &dumbbell), (&b, &disc)], Elasticity::ELASTIC);
        assert!((impulse.y - 12.0 / 11.0).abs() < 1e-15);
        let a = apply_impulse(&a, &dumbbell, frame.arms[0], -impulse);
        let b = apply_impulse(&b, &disc, frame.arms[1], impulse);
        assert!((b.velocity.y - 1.0 / 11.0).abs() < 1e-15);
        assert!((a.velocity.y + 6.0 / 11.0).abs() < 1e-15);
        assert!((a.angular_velocity + 8.0 / 11.0).abs() < 1e-15);
        assert_eq!(b.angular_velocity, 0.0);
    }
}
