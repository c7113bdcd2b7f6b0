//! The impulse of a smooth contact (equation 2.9 of Montanari 2017) and the motion after it.

use carom_kinematics::{Inertia, Motion};
use glam::DVec2;

use crate::{Elasticity, Response, reflection::reflected};

/// Where two bodies touch: the direction of the normal and the lever arms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactFrame {
    /// From the centre of what touches of A to that of B, or any other vector along the normal, of any length but 0.
    pub line_of_centres: DVec2,
    /// From each centre of mass to the centre of the touching atom (length). The rest of the way to
    /// the point of contact runs along the normal and has no moment.
    pub arms: [DVec2; 2],
}

impl ContactFrame {
    /// Unit vector from A to B at the point of contact.
    pub fn normal(&self) -> DVec2 {
        self.line_of_centres.normalize_or(DVec2::X)
    }
}

/// The same direction with length 1 where that is exact: along an axis. Bodies that meet along an axis then exchange
/// their speeds to the bit, however often.
#[inline]
fn exact_on_axes(d: DVec2) -> DVec2 {
    // One look in place of two, which may also be 0 by underflow.
    if d.x * d.y == 0.0 && (d.x == 0.0) != (d.y == 0.0) { d / d.abs().max_element() } else { d }
}

/// The instantaneous contact of smooth rigid bodies.
///
/// With d along the line of centres and g the velocity of A's surface less that of B's, the impulse is
///
/// J = (1 + e) (g·d) d / (d·d (1/m_A + 1/m_B) + (r_A × d)²/I_A + (r_B × d)²/I_B).
///
/// The length of d cancels, and it is not brought to 1: like discs always touch at the same |d|, so the rounding of
/// d/|d| would be nearly the same each time and the energy would drift with the number of collisions, not with its root.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Impact;

impl Response for Impact {
    fn impulse(
        &self,
        frame: &ContactFrame,
        bodies: [(&Motion, &Inertia); 2],
        elasticity: Elasticity,
    ) -> DVec2 {
        let frame = ContactFrame { line_of_centres: exact_on_axes(frame.line_of_centres), ..*frame };
        let d = frame.line_of_centres;
        let [(motion_a, inertia_a), (motion_b, inertia_b)] = bodies;
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
        let d = exact_on_axes(line_of_centres);
        let approach = (velocity_a - velocity_b).dot(d);
        let yielding = d.length_squared() * (inverse_mass_a + inverse_mass_b);
        if approach > 0.0 && yielding > 0.0 {
            (1.0 + elasticity.coefficient()) * approach / yielding * d
        } else {
            DVec2::ZERO
        }
    }

    fn reflected(&self, line_of_centres: DVec2, velocity: DVec2) -> DVec2 {
        let d = exact_on_axes(line_of_centres);
        // From A, as for the impulse: the sign of d plays no part in the reflection itself.
        if velocity.dot(d) > 0.0 { reflected(velocity, d) } else { velocity }
    }
}

/// Speed u at which the two surfaces approach each other along the normal (length per time).
pub fn approach_speed(frame: &ContactFrame, motions: [&Motion; 2]) -> f64 {
    scaled_approach(frame, motions) / frame.line_of_centres.length()
}

/// Reduced mass μ of the contact; 0 if neither body can give way.
pub fn reduced_mass(frame: &ContactFrame, inertias: [&Inertia; 2]) -> f64 {
    let inverse = scaled_inverse_mass(frame, inertias);
    if inverse > 0.0 { frame.line_of_centres.length_squared() / inverse } else { 0.0 }
}

/// u |d|
fn scaled_approach(frame: &ContactFrame, [a, b]: [&Motion; 2]) -> f64 {
    let d = frame.line_of_centres;
    let [arm_a, arm_b] = frame.arms;
    // Each body's spin enters as ω (r × d), which is exactly 0 for a disc.
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
    d.length_squared() * (a.inverse_mass + b.inverse_mass)
        + (turning(frame.arms[0], a) + turning(frame.arms[1], b))
}

/// The motion of a body after `impulse` (mass × length / time) acted at `arm` from its centre.
pub fn struck(motion: &Motion, inertia: &Inertia, arm: DVec2, impulse: DVec2) -> Motion {
    Motion {
        velocity: motion.velocity + impulse * inertia.inverse_mass,
        angular_velocity: motion.angular_velocity + arm.perp_dot(impulse) * inertia.inverse_moment,
        ..*motion
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_kinematics::{angular_momentum, kinetic_energy, momentum};
    use proptest::prelude::*;

    const UNIT: f64 = 1.0;

    /// Two bodies touching somewhere, with any masses and motions.
    #[derive(Debug, Clone)]
    struct Scene {
        frame: ContactFrame,
        point: DVec2,
        motions: [Motion; 2],
        inertias: [Inertia; 2],
    }

    /// Logarithmically even between 10^−6 and 10^6.
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
        (impulse, [struck(a, ia, arm_a, -impulse), struck(b, ib, arm_b, impulse)])
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
        fn surfaces_part_with_elasticity_times_the_approach(scene in scenes(), e in 0.0..2.0f64) {
            let before = approach_speed(&scene.frame, [&scene.motions[0], &scene.motions[1]]);
            let movable = scene.inertias.iter().any(|i| !i.is_fixed());
            prop_assume!(before > 1e-6 && movable);
            let (_, after) = collide(&scene, e);
            let parting = -approach_speed(&scene.frame, [&after[0], &after[1]]);
            let scale = after.iter().map(|m| m.velocity.length() + m.angular_velocity.abs()).sum::<f64>();
            prop_assert!((parting - e * before).abs() < 1e-13 * (UNIT + scale));
        }

        #[test]
        fn momentum_is_kept(scene in scenes(), e in 0.0..2.0f64) {
            let (impulse, after) = collide(&scene, e);
            prop_assume!(scene.inertias.iter().all(|i| !i.is_fixed()));
            let change = total(&scene, &after, momentum) - total(&scene, &scene.motions, momentum);
            let scale = impulse.length() + total(&scene, &scene.motions, |m, i| momentum(m, i).length());
            prop_assert!(change.length() <= 1e-14 * scale, "{change} of {scale}");
        }

        #[test]
        fn angular_momentum_about_the_contact_is_kept(scene in scenes(), e in 0.0..2.0f64) {
            let (impulse, after) = collide(&scene, e);
            // For each body alone: the impulse has no moment about the point at which it acts.
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
        fn energy_falls_by_half_of_one_less_e_squared_mu_u_squared(scene in scenes(), e in 0.0..2.0f64) {
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
        fn exchanging_the_bodies_turns_the_impulse_round(scene in scenes(), e in 0.0..2.0f64) {
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

    #[test]
    fn disc_on_the_end_of_a_dumbbell() {
        // Dumbbell of two unit discs of radius ½ at ±½, struck at rest through one atom by a unit disc at
        // unit speed: J = 2/(1 + 1/2 + a²/I), a = ½, I = 3/4, hence 12/11.
        let dumbbell = Inertia::free(2.0, 0.75);
        let disc = Inertia::free(1.0, 0.125);
        let a = Motion::at_rest(DVec2::ZERO);
        let b = Motion { velocity: DVec2::NEG_Y, ..Motion::at_rest(DVec2::new(0.5, 1.0)) };
        let frame = ContactFrame { line_of_centres: DVec2::Y, arms: [DVec2::new(0.5, 0.0), DVec2::ZERO] };
        let impulse = Impact.impulse(&frame, [(&a, &dumbbell), (&b, &disc)], Elasticity::ELASTIC);
        assert!((impulse.y - 12.0 / 11.0).abs() < 1e-15);
        let a = struck(&a, &dumbbell, frame.arms[0], -impulse);
        let b = struck(&b, &disc, frame.arms[1], impulse);
        assert!((b.velocity.y - 1.0 / 11.0).abs() < 1e-15);
        assert!((a.velocity.y + 6.0 / 11.0).abs() < 1e-15);
        assert!((a.angular_velocity + 8.0 / 11.0).abs() < 1e-15);
        assert_eq!(b.angular_velocity, 0.0);
    }
}
