//! Two discs in flight: the time of contact in closed form.

use carom_kinematics::HALF_ULP as U;
use glam::DVec2;

use crate::{error_bound::one_norm, tolerance::RESTING_DEPTH};

/// When two discs in flight first touch (time from now), infinite if never.
///
/// With d, v relative and σ the sum of the radii the contact is at t = c / (−b + √D), c = d² − σ²,
/// b = d·v < 0, D = σ² v² − (d × v)² > 0 (the form of the quadratic formula that does not cancel).
///
/// `errors` bound the rounding of d (length) and the resolution of v. They decide about a pair that touches or overlaps,
/// with w = (E + 16 u σ)|v|/σ + δv the resolution of the closing speed:
/// * c > τ, with τ what E makes of c: the pair is apart, and the formula above holds;
/// * |c| ≤ τ, touching: in contact if it closes faster than w. A pair that closes more slowly is in contact when it is
///   τ/8 below min(c, 0), and one deeper than τ/8 is in contact unless it parts;
/// * c < −τ, overlapping by more than rounding: in contact if it closes.
///
/// So a pair whose contacts end with the discs parting, beyond the rounding of their velocities, never gets deeper than τ/4
/// beyond rounding: discs that part on straight lines do not come back. Bodies at rest next to each other are never in contact, whatever their depth.
pub(crate) fn disc_contact(d: DVec2, v: DVec2, sigma: f64, errors: (f64, f64)) -> f64 {
    contact_of_passing(d, v, d.perp_dot(v), sigma, errors)
}

/// The same with d × v given, which is constant along the way.
pub(crate) fn contact_of_passing(d: DVec2, v: DVec2, cross: f64, sigma: f64, errors: (f64, f64)) -> f64 {
    let (separation_error, velocity_error) = errors;
    let b = d.dot(v);
    let c = d.length_squared() - sigma * sigma;
    let v_squared = v.length_squared();
    let discriminant = sigma * sigma * v_squared - cross * cross;
    let error = separation_error + 8.0 * U * sigma;
    let touching = 2.0 * sigma * error;
    // When d² is σ² − `depth`; at once where it is less already.
    let time_to = |depth: f64| {
        let discriminant = discriminant - depth * v_squared;
        if b < 0.0 && discriminant > 0.0 {
            (c + depth).max(0.0) / (discriminant.sqrt() - b)
        } else {
            f64::INFINITY
        }
    };
    // |v| times the angle by which the normal d/σ may be off, and eight roundings.
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
        // Miss distance σ (1 ∓ depth) at distance 30 σ: b² − a c loses these, the cross form does not.
        for exponent in 4..=14 {
            let depth = 10f64.powi(-exponent);
            let at = |b: f64| disc_contact(DVec2::new(30.0, b), DVec2::new(-1.0, 0.0), 1.0, EXACT);
            let inside = at(1.0 - depth);
            let expected = 30.0 - (1.0 - (1.0 - depth) * (1.0 - depth)).sqrt();
            assert!((inside - expected).abs() < 1e-7, "depth {depth}: {inside} against {expected}");
            assert_eq!(at(1.0 + depth), f64::INFINITY, "depth −{depth}");
        }
    }

    #[test]
    fn a_pair_in_contact_collides_only_if_it_closes() {
        for gap in [-f64::EPSILON, 0.0, f64::EPSILON] {
            let d = DVec2::new(1.0 + gap, 0.0);
            assert!(disc_contact(d, DVec2::new(-1.0, 0.2), 1.0, EXACT) < 1e-15, "closing, gap {gap}");
            assert_eq!(disc_contact(d, DVec2::new(1.0, 0.2), 1.0, EXACT), f64::INFINITY);
            // One that slides is in contact if it is deeper than τ/8 = ε, one at rest never.
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
