//! Areas that a disc has in common with a rectangle or with another disc.

use std::f64::consts::PI;

/// The area (length²) of the part of a disc with this radius and the centre (0, 0) whose points
/// have x < `right` and y < `top` (length).
///
/// With h(x) = √(r² − x²), the height of the part above x is h + min(h, `top`), or h + `top` where
/// `top` is negative and above −h; H(x) = ½ (x h + r² asin(x/r)) + π r²/4 is the integral of h
/// from −r.
pub(crate) fn disc_below(radius: f64, right: f64, top: f64) -> f64 {
    let square = radius * radius;
    let right = right.clamp(-radius, radius);
    let top = top.clamp(-radius, radius);
    let half = |x: f64| {
        let height = (square - x * x).max(0.0).sqrt();
        0.5 * (x * height + square * (x / radius).clamp(-1.0, 1.0).asin()) + 0.25 * PI * square
    };
    // The line y = `top` crosses the circle at ±`chord`.
    let chord = (square - top * top).max(0.0).sqrt();
    let inner = right.clamp(-chord, chord);
    let below_line = half(inner) - half(-chord) + top * (inner + chord);
    if top < 0.0 {
        return below_line;
    }
    // Left and right of the chord both halves of the disc count.
    let left = 2.0 * half(right.min(-chord));
    let beyond = 2.0 * (half(right.max(chord)) - half(chord));
    left + below_line + beyond
}

/// The area (length²) common to a disc of this radius with the centre (0, 0) and the rectangle of
/// this half width and half height about the same centre (length).
pub(crate) fn disc_in_centred_rectangle(radius: f64, half: [f64; 2]) -> f64 {
    if radius <= 0.0 {
        return 0.0;
    }
    let [x, y] = half;
    disc_below(radius, x, y) - disc_below(radius, -x, y) - disc_below(radius, x, -y)
        + disc_below(radius, -x, -y)
}

/// The area (length²) common to two discs of these radii with centres at this distance (length).
pub(crate) fn lens(radii: [f64; 2], distance: f64) -> f64 {
    let small = radii[0].min(radii[1]);
    let large = radii[0].max(radii[1]);
    if small <= 0.0 || distance >= small + large {
        return 0.0;
    }
    if distance <= large - small {
        return PI * small * small;
    }
    // The common chord is at this distance from each centre.
    let to_chord =
        |own: f64, other: f64| 0.5 * (distance + (own - other) * (own + other) / distance);
    let segment = |own: f64, other: f64| {
        let chord = to_chord(own, other).clamp(-own, own);
        own * own * (chord / own).acos() - chord * (own * own - chord * chord).max(0.0).sqrt()
    };
    segment(small, large) + segment(large, small)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The share of a fine grid of points that a condition holds for, times the area of the square
    /// from −2 to 2.
    fn counted(holds: impl Fn(f64, f64) -> bool) -> f64 {
        let count = 1200;
        let place = |k: i32| 4.0 * (f64::from(k) + 0.5) / f64::from(count) - 2.0;
        let found = (0..count)
            .flat_map(|i| (0..count).map(move |j| (i, j)))
            .filter(|&(i, j)| holds(place(i), place(j)))
            .count();
        16.0 * found as f64 / f64::from(count * count)
    }

    #[test]
    fn parts_of_a_disc_are_those_of_counted_points() {
        let radius = 1.3;
        for right in [-1.5, -1.2, -0.4, 0.0, 0.7, 1.25, 2.0] {
            for top in [-1.4, -0.9, -0.1, 0.0, 0.3, 1.1, 1.9] {
                let expected =
                    counted(|x, y| x * x + y * y < radius * radius && x < right && y < top);
                let found = disc_below(radius, right, top);
                assert!(
                    (found - expected).abs() < 5e-3,
                    "{right} {top}: {found} {expected}"
                );
            }
        }
        let whole = PI * radius * radius;
        assert!((disc_below(radius, 2.0, 2.0) / whole - 1.0).abs() < 1e-15);
        assert!(
            (disc_in_centred_rectangle(radius, [1.0, 1.0])
                - counted(|x, y| x * x + y * y < radius * radius && x.abs().max(y.abs()) < 1.0))
            .abs()
                < 5e-3
        );
        assert!((disc_in_centred_rectangle(2.0, [1.0, 0.5]) - 2.0).abs() < 1e-14);
    }

    #[test]
    fn lenses_are_those_of_counted_points() {
        for distance in [0.0, 0.3, 0.8, 1.0, 1.6, 1.8] {
            let expected =
                counted(|x, y| x * x + y * y < 1.0 && (x - distance).powi(2) + y * y < 0.49);
            let found = lens([1.0, 0.7], distance);
            assert!(
                (found - expected).abs() < 5e-3,
                "{distance}: {found} {expected}"
            );
        }
        assert_eq!(lens([1.0, 0.0], 0.5), 0.0);
    }
}
