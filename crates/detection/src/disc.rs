//! Two discs in flight: the time of contact in closed form.
//!
//! The same formula stands three more times, with the same operations in the same order, so that
//! all give the same bits: for eight discs in `lanes`, and in the engine for each set of
//! instructions in `cells/simd/mod.rs` and `cells/simd/registers.rs`. A change here is a change
//! there; the tests of `lanes` and of `cells/simd` compare them.

use carom_kinematics::HALF_ULP as U;
use glam::DVec2;

use crate::{error_bound::one_norm, tolerance::RESTING_DEPTH};

/// Returns the time of the first contact of two discs in flight (time from now); infinite if there
/// is none.
///
/// With d and v the relative position and velocity and σ the sum of the radii, the contact is at t
/// = c / (−b + √D), with c = d² − σ², b = d·v < 0 and D = σ² v² − (d × v)² > 0 (the form of the
/// quadratic formula without cancellation).
///
/// `errors` are the bounds E on the rounding of d (length) and δv on that of v (length per time).
/// Let τ be the rounding of c that follows from E, and w = (E + 16 u σ)|v|/σ + δv the rounding of
/// the closing speed:
/// * c > τ: the pair is apart, and the formula holds;
/// * |c| ≤ τ: the pair touches. It is in contact if it closes faster than w. A pair that closes
///   more slowly is in contact when c is τ/8 below min(c, 0). A pair deeper than τ/8 is in contact
///   unless it separates;
/// * c < −τ: the pair overlaps by more than rounding. It is in contact if it closes.
///
/// If the discs separate after each contact, beyond the rounding of their velocities, no pair gets
/// deeper than τ/4 plus rounding, because discs that separate on straight lines do not return.
/// Bodies at rest next to each other are never in contact, at any depth.
pub(crate) fn disc_contact(d: DVec2, v: DVec2, sigma: f64, errors: (f64, f64)) -> f64 {
    contact_of_passing(d, v, d.perp_dot(v), sigma, errors)
}

/// The contact time of two discs with d × v given, which is constant in free flight.
pub(crate) fn contact_of_passing(
    d: DVec2,
    v: DVec2,
    cross: f64,
    sigma: f64,
    errors: (f64, f64),
) -> f64 {
    let (separation_error, velocity_error) = errors;
    let b = d.dot(v);
    let c = d.length_squared() - sigma * sigma;
    let v_squared = v.length_squared();
    let discriminant = sigma * sigma * v_squared - cross * cross;
    let error = separation_error + 8.0 * U * sigma;
    let touching = 2.0 * sigma * error;
    // The time at which d² is σ² − `depth`; 0 if it is already less.
    let time_to = |depth: f64| {
        let discriminant = discriminant - depth * v_squared;
        if b < 0.0 && discriminant > 0.0 {
            (c + depth).max(0.0) / (discriminant.sqrt() - b)
        } else {
            f64::INFINITY
        }
    };
    // |v| times the error of the angle of the normal d/σ, and eight roundings.
    let resolved = (error + 8.0 * U * sigma) * one_norm(v) + velocity_error * sigma;
    let resting = RESTING_DEPTH * touching;
    if c.abs() > touching || b < -resolved || resolved == 0.0 {
        time_to(0.0)
    } else if c < -resting {
        if b <= 0.0 { 0.0 } else { f64::INFINITY }
    } else {
        time_to(resting - c.min(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const EXACT: (f64, f64) = (0.0, 0.0);

    #[test]
    fn head_on_is_exact_at_any_speed() {
        for speed in [1e-12, 1.0, 1e12] {
            let time = disc_contact(DVec2::new(3.0, 0.0), DVec2::new(-speed, 0.0), 1.0, EXACT);
            assert!((time * speed - 2.0).abs() <= 4.0 * f64::EPSILON, "{speed}");
        }
    }

    #[test]
    fn grazes_are_decided_to_rounding_at_a_distance() {
        // Miss distance σ (1 ∓ depth) at distance 30 σ: b² − a c loses these digits, the cross
        // product does not.
        for exponent in 4..=14 {
            let depth = 10f64.powi(-exponent);
            let at = |b: f64| disc_contact(DVec2::new(30.0, b), DVec2::new(-1.0, 0.0), 1.0, EXACT);
            let inside = at(1.0 - depth);
            let expected = 30.0 - (1.0 - (1.0 - depth) * (1.0 - depth)).sqrt();
            assert!(
                (inside - expected).abs() < 1e-7,
                "depth {depth}: {inside} against {expected}"
            );
            assert_eq!(at(1.0 + depth), f64::INFINITY, "depth −{depth}");
        }
    }

    #[test]
    fn a_pair_in_contact_collides_only_if_it_closes() {
        for gap in [-f64::EPSILON, 0.0, f64::EPSILON] {
            let d = DVec2::new(1.0 + gap, 0.0);
            assert!(
                disc_contact(d, DVec2::new(-1.0, 0.2), 1.0, EXACT) < 1e-15,
                "closing, gap {gap}"
            );
            assert_eq!(
                disc_contact(d, DVec2::new(1.0, 0.2), 1.0, EXACT),
                f64::INFINITY
            );
            // A sliding pair is in contact if it is deeper than τ/8 = ε, a pair at rest never.
            let sliding = if gap < 0.0 { 0.0 } else { f64::INFINITY };
            assert_eq!(disc_contact(d, DVec2::new(0.0, 0.2), 1.0, EXACT), sliding);
            assert_eq!(disc_contact(d, DVec2::ZERO, 1.0, EXACT), f64::INFINITY);
        }
    }

    proptest! {
        #[test]
        fn at_the_time_of_contact_the_gap_is_zero(
            x in 1.0..30.0f64, y in -3.0..3.0f64, vx in -2.0..2.0f64, vy in -2.0..2.0f64, sigma in 0.1..0.9f64,
        ) {
            let (d, v) = (DVec2::new(x, y), DVec2::new(vx, vy));
            let time = disc_contact(d, v, sigma, EXACT);
            if time.is_finite() {
                let gap = (d + v * time).length() - sigma;
                prop_assert!(gap.abs() < 8.0 * f64::EPSILON * (d.length() + v.length() * time));
                for part in 0..100 {
                    let earlier = time * f64::from(part) / 100.0;
                    prop_assert!((d + v * earlier).length() >= sigma);
                }
            } else {
                for part in 0..1000 {
                    prop_assert!((d + v * (0.05 * f64::from(part))).length() > sigma * (1.0 - 1e-15));
                }
            }
        }
    }
}
