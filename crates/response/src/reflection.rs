//! The reflection of a disc by a fixed body, with a rounding error of the energy that has no bias.

use carom_kinematics::{two_product, two_sum};
use glam::DVec2;

/// A number as the sum of two floats, the second below the last digit of the first.
type Double = (f64, f64);

/// Largest change of the smaller component of the velocity to correct the energy, as a share of the
/// larger component. Larger: velocities nearly along an axis change direction for an energy that no
/// float there can represent. Smaller: more of them keep the rounding error of the energy.
const MAX_TURNED: f64 = 4.0 * f64::EPSILON;

/// Returns the velocity v − 2 (v·d) d/(d·d) after an elastic contact with a fixed body, with d
/// along the normal.
///
/// A disc meets a fixed partner at the same |d| each time, and v·d has the same largest value
/// |v||d|. So in plain floating-point arithmetic d·d and the quotient would have the same few
/// rounding errors each time, of one sign more often than of the other: the energy would drift in
/// proportion to the number of contacts, not to its square root. Here the quotient is computed in
/// double-double arithmetic and each component is rounded once. Of the floats next to the result,
/// the function returns the one whose square is nearest to v·v.
pub fn reflected(velocity: DVec2, d: DVec2) -> DVec2 {
    let (approach, square) = (dot(velocity, d), dot(d, d));
    let quotient = 2.0 * approach.0 / square.0;
    let (product, product_rest) = two_product(quotient, square.0);
    let remainder =
        ((2.0 * approach.0 - product) - product_rest) + (2.0 * approach.1 - quotient * square.1);
    let quotient_rest = remainder / square.0;
    let component = |v: f64, d: f64| {
        let (product, product_rest) = two_product(quotient, d);
        let (difference, rest) = two_sum(v, -product);
        difference + (rest - (product_rest + quotient_rest * d))
    };
    of_equal_energy(
        DVec2::new(component(velocity.x, d.x), component(velocity.y, d.y)),
        dot(velocity, velocity),
    )
}

/// Returns the velocity next to `rounded` whose square is nearest to `square`.
fn of_equal_energy(rounded: DVec2, square: Double) -> DVec2 {
    let along_x = rounded.x.abs() > rounded.y.abs();
    let (large, small) = if along_x {
        (rounded.x, rounded.y)
    } else {
        (rounded.y, rounded.x)
    };
    let missing = |large: f64, small: f64| {
        let now = dot(DVec2::new(large, small), DVec2::new(large, small));
        (square.0 - now.0) + (square.1 - now.1)
    };
    // The smaller component has the finer last digit: it corrects the remaining energy.
    let candidate = |large: f64| {
        let turned = missing(large, small) / (2.0 * small);
        let small = if turned.abs() <= MAX_TURNED * large.abs() {
            small + turned
        } else {
            small
        };
        (missing(large, small).abs(), large, small)
    };
    let nearer =
        |best: (f64, f64, f64), other: (f64, f64, f64)| if other.0 < best.0 { other } else { best };
    let beside = [large.next_up(), large.next_down()].map(candidate);
    let (_, large, small) = beside.into_iter().fold(candidate(large), nearer);
    if along_x {
        DVec2::new(large, small)
    } else {
        DVec2::new(small, large)
    }
}

/// Returns a·b in double-double arithmetic.
fn dot(a: DVec2, b: DVec2) -> Double {
    let ((x, x_rest), (y, y_rest)) = (two_product(a.x, b.x), two_product(a.y, b.y));
    let (sum, rest) = two_sum(x, y);
    two_sum(sum, rest + (x_rest + y_rest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2Swizzles;

    /// Relative energy gains of contacts at one distance |d| from all sides, at all angles.
    fn gains(radius: f64, reflect: impl Fn(DVec2, DVec2) -> DVec2) -> Vec<f64> {
        let golden = 0.5 * (5.0f64.sqrt() - 1.0);
        let turn = |k: u32, share: f64| {
            DVec2::from_angle(std::f64::consts::TAU * (f64::from(k) * share).fract())
        };
        (1..200_000)
            .filter_map(|k| {
                // Positions in a box of side 1 have the last digit of 1/2.
                let centre = DVec2::splat(0.5);
                let d = centre - (centre - radius * turn(k, golden));
                let velocity = turn(k, 2f64.sqrt());
                (velocity.dot(d) > 0.0).then(|| {
                    let (before, after) = (dot(velocity, velocity), reflect(velocity, d));
                    let after = dot(after, after);
                    (after.0 - before.0) + (after.1 - before.1)
                })
            })
            .collect()
    }

    /// The mean of the gains in standard errors, and their root mean square.
    fn bias(gains: &[f64]) -> (f64, f64) {
        let sum: f64 = gains.iter().sum();
        let squares: f64 = gains.iter().map(|gain| gain * gain).sum();
        (sum / squares.sqrt(), (squares / gains.len() as f64).sqrt())
    }

    #[test]
    fn contacts_at_one_distance_have_no_bias_in_energy() {
        for radius in [0.25, 0.3, 0.2, 0.1 + 0.02] {
            let (mean, spread) = bias(&gains(radius, reflected));
            assert!(mean.abs() < 4.0, "{radius}: {mean} standard errors");
            assert!(spread < 0.125 * f64::EPSILON, "{radius}: {spread:e}");
        }
        // The plain formula has a bias, so that the test can detect it.
        let plain = |v: DVec2, d: DVec2| v - 2.0 * v.dot(d) / d.length_squared() * d;
        assert!(
            bias(&gains(0.25, plain)).0.abs() > 8.0,
            "{}",
            bias(&gains(0.25, plain)).0
        );
    }

    #[test]
    fn it_agrees_with_the_exact_reflection_to_a_few_last_places() {
        for k in 1..10_000 {
            let d = 0.3 * DVec2::from_angle(f64::from(k));
            let velocity = DVec2::from_angle(f64::from(k).sqrt());
            let plain = velocity - 2.0 * velocity.dot(d) / d.length_squared() * d;
            let error = (reflected(velocity, d) - plain).length();
            assert!(error < 8.0 * f64::EPSILON, "{velocity} at {d}: {error:e}");
        }
    }

    #[test]
    fn along_the_axes_it_is_exact_and_symmetric() {
        assert_eq!(
            reflected(DVec2::new(0.3, 0.7), DVec2::new(0.1, 0.0)),
            DVec2::new(-0.3, 0.7)
        );
        assert_eq!(
            reflected(DVec2::new(0.3, 0.7), DVec2::new(0.0, 0.1)),
            DVec2::new(0.3, -0.7)
        );
        assert_eq!(
            reflected(DVec2::new(0.0, 0.7), DVec2::new(0.0, 0.1)),
            DVec2::new(0.0, -0.7)
        );
        let (v, d) = (DVec2::new(0.6, 0.8), DVec2::new(0.23, 0.11));
        let after = reflected(v, d);
        assert_eq!(reflected(v.yx(), d.yx()), after.yx());
        assert_eq!(reflected(-v, d), -after);
        assert_eq!(reflected(v, -d), after);
        assert_eq!(reflected(1024.0 * v, d), 1024.0 * after);
    }
}
