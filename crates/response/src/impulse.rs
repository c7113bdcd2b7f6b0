//! The impulse of a contact (equation 2.9 of Montanari 2017 where it is smooth) and the motion
//! after it.

#![allow(
    clippy::inline_always,
    reason = "compiled with the instructions of the caller"
)]

use carom_kinematics::{Inertia, Motion, two_product, two_sum};
use glam::DVec2;

use crate::{
    ContactFrame, Elasticity, Response,
    contact_frame::{scaled_approach, scaled_inverse_masses},
    joint_impulses::joint_impulses,
    reflection::reflected,
    rough::rough_impulse,
};

/// Whether d is along the x or the y axis; false for d = 0.
#[inline]
fn is_along_axis(d: DVec2) -> bool {
    // One test instead of two; the product is also 0 by underflow.
    d.x * d.y == 0.0 && (d.x == 0.0) != (d.y == 0.0)
}

/// Returns d rescaled to length 1 if it is along an axis, where that is exact, else by [`spread`].
#[inline]
fn scaled(d: DVec2, g: DVec2) -> DVec2 {
    if is_along_axis(d) {
        d / d.abs().max_element()
    } else {
        spread(d, g)
    }
}

/// Returns d rescaled to a length that differs between contacts.
///
/// Equal discs always touch at the same |d|. With d itself, d·d would take the same few rounded
/// values each time, rounded to one side more often than to the other. The energy would then drift
/// in proportion to the number of collisions, not to its square root. The digits of the relative
/// velocity g spread the length over a factor of 2; those of |g_x| + |g_y| do so symmetrically in
/// the two axes.
#[inline]
pub(crate) fn spread(d: DVec2, g: DVec2) -> DVec2 {
    f64::from_bits(digits(g.x.abs() + g.y.abs()) | 1.0f64.to_bits()) * d
}

/// Returns the 52 stored digits of x, without sign and exponent.
#[inline]
fn digits(x: f64) -> u64 {
    x.to_bits() & ((1 << 52) - 1)
}

/// Returns f (v_A − v_B)/(1/m_A + 1/m_B) for the velocities along an axis of two bodies without
/// lever arms, and f = 1 + e as `factor` (mass × length / time). It is rounded stochastically: up
/// or down, the nearer neighbour more often, so that the expected rounding error is 0.
///
/// Along an axis d·d is 1, and nothing spreads the digits. For two given masses the sum of the
/// inverse masses then has the same rounding error at each contact. The nearest neighbour of the
/// exact quotient is biased too: for masses 1 and 3 the quotient is 3/4 of f (v_A − v_B), so that
/// each fourth result is a tie, always broken to the same side. The digits of the relative velocity
/// determine the rounding: the outcome depends on the arguments alone, and velocities times a power
/// of two, or with opposite signs, give the corresponding impulse to the bit.
///
/// The plain quotient remains for equal masses, which exchange their speeds, and for a fixed
/// partner.
#[cold]
#[inline(never)]
fn quotient_along_axis(factor: f64, [va, vb]: [f64; 2], [a, b]: [f64; 2]) -> f64 {
    let ((relative, relative_rest), (sum, sum_rest)) = (two_sum(va, -vb), two_sum(a, b));
    let share = factor * relative;
    let quotient = share / sum;
    if a == b || a * b == 0.0 {
        return quotient;
    }
    let (product, product_rest) = two_product(quotient, sum);
    let rest = ((share - product) - product_rest) + (factor * relative_rest - quotient * sum_rest);
    let last_place = quotient.abs().next_up() - quotient.abs();
    quotient + (rest / sum + uniform(digits(share)) * last_place)
}

/// Returns a number from −1/2 to 1/2, evenly distributed if `bits` are: the mixing function of the
/// generator SplitMix64.
fn uniform(bits: u64) -> f64 {
    let once = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let twice = (once ^ (once >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((twice ^ (twice >> 31)) >> 11) as f64 / (1u64 << 53) as f64 - 0.5
}

/// The instantaneous contact of rigid bodies, smooth or rough.
///
/// In a smooth contact ([`Elasticity::is_smooth`]), with d along the line of centres and
/// g the velocity of A's surface less that of B's, the impulse
/// is
///
/// J = (1 + e) (g·d) d / (d·d (1/m_A + 1/m_B) + (r_A × d)²/I_A + (r_B × d)²/I_B).
///
/// The length of d cancels. It is not normalised, which would give nearly the same rounding error
/// each time, but rescaled differently at each contact, so that the rounding errors of many
/// contacts add up to a random walk. Along an axis the impulse of bodies without lever arms is
/// rounded stochastically instead, except between equal masses, which exchange their speeds to the
/// bit.
///
/// A rough contact sticks or slides by Walton's rule, with the tangential restitution β and the
/// friction μ of its [`Elasticity`]. With the velocity g_t of A's surface less that of B's along
/// the tangent, two discs have the tangential impulse J_t = (1 + β) m_t g_t with 1/m_t = 1/m_A +
/// 1/m_B + R_A²/I_A + R_B²/I_B, or μ J_n if that is less. For bodies of any shape the same holds
/// with the tangential velocity at the instant at which the surfaces no longer approach, and with
/// the mass m_t for a tangential impulse that leaves the normal velocity as it is; so the surfaces
/// always separate with e times their speed of approach, and e = β = 1 conserves the energy.
/// Several points of contact at one instant are then resolved one by one.
#[doc(alias = "Walton")]
#[doc(alias = "friction")]
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
        let on_axis = is_along_axis(frame.line_of_centres);
        let d = scaled(frame.line_of_centres, motion_a.velocity - motion_b.velocity);
        let frame = ContactFrame {
            line_of_centres: d,
            ..*frame
        };
        if !elasticity.is_smooth() {
            return rough_impulse(&frame, bodies, elasticity);
        }
        let approach = scaled_approach(&frame, [motion_a, motion_b]);
        let turning = scaled_turning(&frame, [inertia_a, inertia_b]);
        let inverse_masses = [inertia_a.inverse_mass, inertia_b.inverse_mass];
        let yielding = scaled_inverse_masses(d, inverse_masses) + turning;
        if !(approach > 0.0 && yielding > 0.0) {
            return DVec2::ZERO;
        }
        let factor = 1.0 + elasticity.coefficient();
        if on_axis && turning == 0.0 {
            let along = [motion_a.velocity.dot(d), motion_b.velocity.dot(d)];
            return quotient_along_axis(factor, along, inverse_masses) * d;
        }
        factor * approach / yielding * d
    }

    #[inline]
    fn impulse_of_discs(
        &self,
        line_of_centres: DVec2,
        [velocity_a, velocity_b]: [DVec2; 2],
        inverse_masses: [f64; 2],
        elasticity: Elasticity,
    ) -> DVec2 {
        let relative = velocity_a - velocity_b;
        let on_axis = is_along_axis(line_of_centres);
        let d = scaled(line_of_centres, relative);
        let approach = relative.dot(d);
        let yielding = scaled_inverse_masses(d, inverse_masses);
        if !(approach > 0.0 && yielding > 0.0) {
            return DVec2::ZERO;
        }
        let factor = 1.0 + elasticity.coefficient();
        if on_axis {
            let along = [velocity_a.dot(d), velocity_b.dot(d)];
            return quotient_along_axis(factor, along, inverse_masses) * d;
        }
        factor * approach / yielding * d
    }

    fn joint_impulses(
        &self,
        frames: &[ContactFrame],
        bodies: [(&Motion, &Inertia); 2],
        elasticity: Elasticity,
    ) -> Option<Vec<DVec2>> {
        if elasticity.is_smooth() {
            joint_impulses(frames, bodies, elasticity)
        } else {
            None
        }
    }

    #[inline]
    fn conserves_energy(&self, elasticity: Elasticity) -> bool {
        elasticity.conserves_energy()
    }

    fn reflected(&self, line_of_centres: DVec2, velocity: DVec2) -> Option<DVec2> {
        let d = scaled(line_of_centres, velocity);
        // The motion is that of A, as in the impulse; the sign of d does not affect the reflection
        // itself.
        Some(if velocity.dot(d) > 0.0 {
            reflected(velocity, d)
        } else {
            velocity
        })
    }
}

/// Reduced mass μ of the contact (mass); 0 if neither body can move.
pub fn reduced_mass(frame: &ContactFrame, inertias: [&Inertia; 2]) -> f64 {
    let inverse = scaled_inverse_mass(frame, inertias);
    if inverse > 0.0 {
        frame.line_of_centres.length_squared() / inverse
    } else {
        0.0
    }
}

/// |d|²/μ
fn scaled_inverse_mass(frame: &ContactFrame, inertias: [&Inertia; 2]) -> f64 {
    let inverse_masses = inertias.map(|inertia| inertia.inverse_mass);
    scaled_inverse_masses(frame.line_of_centres, inverse_masses) + scaled_turning(frame, inertias)
}

/// Returns (r_A × d)²/I_A + (r_B × d)²/I_B.
fn scaled_turning(frame: &ContactFrame, [a, b]: [&Inertia; 2]) -> f64 {
    let turning = |arm: DVec2, inertia: &Inertia| {
        let lever = arm.perp_dot(frame.line_of_centres);
        lever * lever * inertia.inverse_moment
    };
    turning(frame.arms[0], a) + turning(frame.arms[1], b)
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
    use crate::approach_speed;
    use carom_kinematics::{angular_momentum, kinetic_energy, momentum};
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
        let numbers = (
            -1.0..1.0,
            -1.0..1.0,
            -2.0..2.0,
            -2.0..2.0,
            -5.0..5.0,
            -1.0..1.0,
            -1.0..1.0,
        );
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
                        Motion {
                            angular_velocity: 0.0,
                            ..motion
                        },
                        Inertia::locked(mass),
                        DVec2::new(rx, ry),
                    ),
                    1 => (
                        Motion::at_rest(motion.position),
                        Inertia::FIXED,
                        DVec2::new(rx, ry),
                    ),
                    _ => (motion, Inertia::free(mass, moment), DVec2::new(rx, ry)),
                }
            },
        )
    }

    fn scenes() -> impl Strategy<Value = Scene> {
        (
            bodies(),
            bodies(),
            0.0..std::f64::consts::TAU,
            0.0..1.0,
            0.0..1.0,
        )
            .prop_map(
                |((a, inertia_a, arm_a), (b, inertia_b, arm_b), angle, radius_a, radius_b): (
                    _,
                    _,
                    f64,
                    f64,
                    f64,
                )| {
                    let normal = DVec2::from_angle(angle);
                    let point = a.position + arm_a + radius_a * normal;
                    let b = Motion {
                        position: point + radius_b * normal - arm_b,
                        ..b
                    };
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
        (
            impulse,
            [
                apply_impulse(a, ia, arm_a, -impulse),
                apply_impulse(b, ib, arm_b, impulse),
            ],
        )
    }

    fn total<T: std::iter::Sum>(
        scene: &Scene,
        motions: &[Motion; 2],
        f: impl Fn(&Motion, &Inertia) -> T,
    ) -> T {
        motions
            .iter()
            .zip(&scene.inertias)
            .map(|(m, i)| f(m, i))
            .sum()
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
        let turn = |k: u32, share: f64| {
            DVec2::from_angle(std::f64::consts::TAU * (f64::from(k) * share).fract())
        };
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
                let j = Impact.impulse_of_discs(
                    d,
                    [velocity, DVec2::ZERO],
                    inverse,
                    Elasticity::ELASTIC,
                );
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
        for masses in [
            [60.0, 1.0],
            [1.0, 3.0],
            [3.0, 1.0],
            [1.0, 2.0],
            [5.0, 7.0],
            [1.0, 1e-3],
            [7.0, 1.1],
        ] {
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

    /// Energy gains of the velocities after elastic contacts of two bodies without lever arms, with
    /// the line of centres along `axis`.
    ///
    /// Each gain is exact to far below a last place: the energy is computed with the masses
    /// 1/(1/m), as the motion uses the inverse masses.
    fn gains_along(axis: DVec2, masses: [f64; 2]) -> Vec<f64> {
        let [a, b] = masses.map(|mass| 1.0 / mass);
        let thermal = masses.map(|mass| 1.0 / mass.sqrt());
        // Twice the energy times ab, as a sum of two floats each.
        let square = |v: f64, inverse: f64| {
            let (square, rest) = two_product(v, v);
            let (product, product_rest) = two_product(square, inverse);
            (product, product_rest + rest * inverse)
        };
        let change = |before: f64, after: f64, inverse: f64| {
            let (old, new) = (square(before, inverse), square(after, inverse));
            let (difference, rest) = two_sum(new.0, -old.0);
            (difference, rest + (new.1 - old.1))
        };
        (1..400_000)
            .filter_map(|k| {
                let even = |share: f64| 2.0 * (f64::from(k) * share).fract() - 1.0;
                let [va, vb] = [
                    thermal[0] * even(2f64.sqrt()),
                    thermal[1] * even(3f64.sqrt()),
                ];
                let impulse = Impact.impulse_of_discs(
                    0.3 * axis,
                    [va * axis, vb * axis],
                    [a, b],
                    Elasticity::ELASTIC,
                );
                let j = impulse.dot(axis);
                let (of_a, of_b) = (change(va, va - j * a, b), change(vb, vb + j * b, a));
                (j != 0.0).then_some((of_a.0 + of_b.0) + (of_a.1 + of_b.1))
            })
            .collect()
    }

    #[test]
    fn contacts_along_an_axis_gain_no_energy() {
        let pairs = [
            [1.0, 3.0],
            [3.0, 1.0],
            [1.0, 2.0],
            [60.0, 1.0],
            [5.0, 7.0],
            [1.0, 1e-3],
            [7.0, 1.1],
            [1.0, 7.0],
            [0.1, 0.3],
            [1.0, 100.0],
            [1.0, 1e4],
            [1.0, 1e6],
            [1e8, 1.0],
        ];
        for masses in pairs {
            for axis in [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y] {
                let bias = bias(&gains_along(axis, masses));
                // The impulse itself has no bias. The product with 1/m, which the motion rounds,
                // leaves up to 2·10⁻¹⁸ of the energy, 4 standard errors; a quotient rounded to
                // nearest leaves 30 to 170.
                assert!(
                    bias.abs() < 8.0,
                    "{masses:?} along {axis}: {bias} standard errors"
                );
            }
        }
    }

    #[test]
    fn equal_masses_exchange_their_speeds_along_an_axis_to_the_bit() {
        for (k, axis) in (1..2000).zip([DVec2::X, DVec2::NEG_Y].into_iter().cycle()) {
            let speed = f64::from(k).sqrt();
            for mass in [1.0, 0.25, 8.0] {
                let velocities = [speed * axis, DVec2::ZERO];
                let impulse = Impact.impulse_of_discs(
                    0.3 * axis,
                    velocities,
                    [1.0 / mass; 2],
                    Elasticity::ELASTIC,
                );
                assert_eq!(velocities[0] - impulse / mass, DVec2::ZERO);
                assert_eq!(velocities[1] + impulse / mass, speed * axis);
            }
        }
    }

    #[test]
    fn a_scale_of_two_and_the_opposite_direction_keep_the_digits_along_an_axis() {
        let along = |line: f64, va: f64, vb: f64| {
            let velocities = [DVec2::new(va, 0.2), DVec2::new(vb, -0.1)];
            let line = DVec2::new(line, 0.0);
            Impact.impulse_of_discs(line, velocities, [1.0, 1.0 / 3.0], Elasticity::ELASTIC)
        };
        for k in 1..2000 {
            let (va, vb) = (f64::from(k).sqrt(), -f64::from(k).ln());
            assert_eq!(
                along(0.3, 1024.0 * va, 1024.0 * vb),
                1024.0 * along(0.3, va, vb)
            );
            assert_eq!(along(-0.3, -va, -vb), -along(0.3, va, vb));
        }
    }

    #[test]
    fn bodies_that_turn_gain_no_energy_at_a_wall_along_an_axis() {
        // A dumbbell of mass 3 and moment 7 meets a fixed body at all orientations.
        let inertia = Inertia::free(3.0, 7.0);
        for axis in [DVec2::X, DVec2::Y] {
            let gains: Vec<f64> = (1..400_000)
                .filter_map(|k| {
                    let share = |root: f64| (f64::from(k) * root).fract();
                    let arm = 0.7 * DVec2::from_angle(std::f64::consts::TAU * share(2f64.sqrt()));
                    let motion = Motion {
                        velocity: DVec2::new(share(3f64.sqrt()) - 0.5, share(5f64.sqrt()) - 0.5),
                        angular_velocity: share(7f64.sqrt()) - 0.5,
                        ..Motion::at_rest(DVec2::ZERO)
                    };
                    let wall = Motion::at_rest(DVec2::ZERO);
                    let frame = ContactFrame {
                        line_of_centres: 0.3 * axis,
                        arms: [arm, DVec2::ZERO],
                    };
                    let bodies = [(&motion, &inertia), (&wall, &Inertia::FIXED)];
                    let impulse = Impact.impulse(&frame, bodies, Elasticity::ELASTIC);
                    // −u J + ½ J² (1/m + (r × d)²/I), with u and the lever as the impulse has them.
                    let (j, lever) = (impulse.dot(axis), arm.perp_dot(axis));
                    let approach = motion.velocity.dot(axis) + motion.angular_velocity * lever;
                    let half =
                        0.5 * (inertia.inverse_mass + lever * lever * inertia.inverse_moment);
                    let ((work, work_rest), (square, rest)) =
                        (two_product(approach, j), two_product(j, j));
                    let (gain, gain_rest) = two_product(square, half);
                    (j != 0.0).then_some((gain - work) + (gain_rest - work_rest + rest * half))
                })
                .collect();
            let bias = bias(&gains);
            assert!(bias.abs() < 4.5, "along {axis}: {bias} standard errors");
        }
    }

    #[test]
    fn a_disc_that_hits_the_end_of_a_dumbbell_has_the_known_outcome() {
        // A dumbbell of two unit discs of radius ½ at ±½, at rest, whose one atom is hit by a unit
        // disc with unit speed: J = 2/(1 + 1/2 + a²/I) with a = ½ and I = 3/4, hence 12/11.
        let dumbbell = Inertia::free(2.0, 0.75);
        let disc = Inertia::free(1.0, 0.125);
        let a = Motion::at_rest(DVec2::ZERO);
        let b = Motion {
            velocity: DVec2::NEG_Y,
            ..Motion::at_rest(DVec2::new(0.5, 1.0))
        };
        let frame = ContactFrame {
            line_of_centres: DVec2::Y,
            arms: [DVec2::new(0.5, 0.0), DVec2::ZERO],
        };
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
