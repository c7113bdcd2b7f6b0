//! The impulse of two discs at a step of their potential energy.

use glam::DVec2;

use crate::{contact_frame::scaled_inverse_masses, impulse::spread};

/// The impulse on disc B as the two pass a step at which they gain a kinetic energy `gain`, which
/// may be negative (mass × length² / time²); `None` if their energy along the line of centres does
/// not suffice for the step.
///
/// `towards` is along the line of centres: from A to B where the two approach, from B to A where
/// they part. Its length does not matter. Along it, the velocity of A less that of B has a
/// component u ≥ 0, which becomes √(u² + 2 ΔE/μ) (B. J. Alder and T. E. Wainwright, J. Chem. Phys.
/// 31 (1959) 459).
///
/// As in [`Impact`](crate::Impact), the line is rescaled to another length at each step: a pair is
/// always at the same distance there, so that the rounding of its unit vector would be the same
/// each time, and the energy would drift in proportion to the number of steps.
///
/// ```
/// use carom_response::impulse_at_step;
/// use glam::DVec2;
///
/// // Two discs of mass 1 approach at the speed 1, and gain 2 at the border of a well: √(1 + 8) = 3.
/// let into = |gain| impulse_at_step(DVec2::X, [DVec2::X, DVec2::ZERO], [1.0, 1.0], gain);
/// assert!((into(2.0).unwrap() - DVec2::new(-1.0, 0.0)).length() < 1e-15);
/// // A shoulder of 2 is too high for them.
/// assert_eq!(into(-2.0), None);
/// ```
pub fn impulse_at_step(
    towards: DVec2,
    [velocity_a, velocity_b]: [DVec2; 2],
    inverse_masses: [f64; 2],
    gain: f64,
) -> Option<DVec2> {
    let relative = velocity_a - velocity_b;
    // Along an axis, too: the sum of the inverse masses must not be rounded alike each time.
    let d = spread(towards, relative);
    let approach = relative.dot(d).max(0.0);
    let squared = approach * approach + 2.0 * gain * scaled_inverse_masses(d, inverse_masses);
    // The difference of the two speeds, without cancellation.
    (squared > 0.0).then(|| -2.0 * gain / (approach + squared.sqrt()) * d)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn velocity() -> impl Strategy<Value = DVec2> {
        (-1.0..1.0, -1.0..1.0).prop_map(|(x, y)| DVec2::new(x, y))
    }

    proptest! {
        /// The kinetic energy grows by the gain, and the velocity across the line stays.
        #[test]
        fn a_step_gives_its_energy_along_the_line(
            velocities in [velocity(), velocity()],
            masses in [0.1..10.0, 0.1..10.0],
            gain in -1.0..1.0,
            turns in 0.0..1.0,
            length in 1e-3..1e3,
        ) {
            let line = length * DVec2::from_angle(turns * std::f64::consts::TAU);
            let relative = velocities[0] - velocities[1];
            let line = if relative.dot(line) < 0.0 { -line } else { line };
            let inverse = masses.map(|mass: f64| 1.0 / mass);
            let u = relative.dot(line.normalize());
            let enough: f64 = 0.5 * u * u / (inverse[0] + inverse[1]) + gain;
            prop_assume!(enough.abs() > 1e-6);
            let Some(impulse) = impulse_at_step(line, velocities, inverse, gain) else {
                prop_assert!(enough < 0.0);
                return Ok(());
            };
            prop_assert!(enough > 0.0);
            let after = [velocities[0] - inverse[0] * impulse, velocities[1] + inverse[1] * impulse];
            let energy = |of: [DVec2; 2]| {
                0.5 * (masses[0] * of[0].length_squared() + masses[1] * of[1].length_squared())
            };
            let change = energy(after) - energy(velocities);
            prop_assert!((change - gain).abs() < 1e-12, "{change} for {gain}");
            prop_assert!(impulse.perp_dot(line).abs() <= 1e-14 * impulse.length() * length);
            prop_assert!((after[0] - after[1]).dot(line) > 0.0);
        }
    }
}
