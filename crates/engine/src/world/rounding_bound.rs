//! The overlap that rounding alone can cause.

use glam::DVec2;

/// Overlaps below this many roundings of the distances involved are not reported.
///
/// A contact is computed within sixteen roundings of the side from the exact contact (measured over
/// more than 10⁸ collisions: `cargo xtask experiment extremes`); each new epoch and the view itself
/// add a few more. The bound 2 E of `carom_detection::Exact` is larger: it assumes that each
/// operation has its largest error, all of one sign. Smaller: rounding would be reported as
/// overlap. Larger: harmless until real overlaps (10⁻⁹ of a diameter and more for a missed contact)
/// come near it.
const ROUNDINGS: f64 = 64.0;

/// The deepest overlap by rounding alone (length), in a box of these sides, between bodies whose
/// bounding radii add up to `reach`.
pub fn rounding_bound(sides: DVec2, reach: f64) -> f64 {
    ROUNDINGS * f64::EPSILON * (sides.x.max(sides.y) + reach)
}
