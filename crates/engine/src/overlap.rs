//! The overlap check: every near pair, looked at afresh, without the scheduler's lists.

use carom_geometry::gap_between;
use glam::DVec2;
use std::collections::BTreeMap;

use crate::{BodyView, View};

/// Overlaps below this many roundings of the distances involved are no overlaps.
///
/// A contact lies within sixteen roundings of the side from where the bodies touch exactly (measured over 10⁸ collisions and more:
/// `cargo xtask experiment extremes`); each rebasing of the epoch and the view itself add a few more. The bound 2 E of
/// `carom_detection::Exact` is larger: it supposes that every operation errs by its most, and the same way.
/// Smaller: rounding would be reported as overlap. Larger: nothing is lost until real overlaps (10⁻⁹ of a
/// diameter and more for a missed contact) come near it.
const ROUNDINGS: f64 = 64.0;

/// The overlapping pairs at one time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct OverlapCensus {
    /// How many pairs overlap by more than the rounding bound.
    pub pairs: usize,
    /// The deepest overlap of any pair, in units of the smaller diameter of its touching parts' bodies;
    /// 0 if none overlaps at all. This may be a rounding.
    pub deepest: f64,
    /// The deepest overlap of any pair (length).
    pub deepest_length: f64,
}

/// Counts the overlapping pairs of a view with a cell list made for it alone.
pub(crate) fn census(view: &View<'_>) -> OverlapCensus {
    let bodies: Vec<BodyView<'_>> = view.bodies().collect();
    let sides = view.bounds().sides();
    let reach = view.world.largest_reach();
    // At least one cell, and no more of them than bodies a side: an empty cell costs as much as a full one.
    let count = |side: f64| ((side / reach).min(1.0 + (bodies.len() as f64).sqrt()) as i64).max(1);
    let cells = [count(sides.x), count(sides.y)];
    let cell_of = |place: DVec2| {
        let index = |x: f64, side: f64, n: i64| ((x / side * n as f64) as i64).clamp(0, n - 1);
        [index(place.x, sides.x, cells[0]), index(place.y, sides.y, cells[1])]
    };
    let mut lists: BTreeMap<[i64; 2], Vec<usize>> = BTreeMap::new();
    for (index, body) in bodies.iter().enumerate().filter(|(_, body)| !body.body.is_wall()) {
        lists.entry(cell_of(body.motion.position)).or_default().push(index);
    }
    let mut census = OverlapCensus::default();
    for (cell, members) in &lists {
        for step in 0..9 {
            let (dx, dy) = (step % 3 - 1, step / 3 - 1);
            let neighbour = [cell[0] + dx, cell[1] + dy];
            let image = [neighbour[0].div_euclid(cells[0]), neighbour[1].div_euclid(cells[1])];
            let there = [neighbour[0].rem_euclid(cells[0]), neighbour[1].rem_euclid(cells[1])];
            let Some(others) = lists.get(&there) else { continue };
            let shift = view.bounds().shift(image);
            for &i in members {
                for &j in others.iter().filter(|&&j| j > i) {
                    look(&bodies[i], &bodies[j], shift, sides, &mut census);
                }
            }
        }
    }
    for wall in bodies.iter().filter(|body| body.body.is_wall()) {
        for body in bodies.iter().filter(|body| !body.body.is_fixed()) {
            look_at_images(body, wall, sides, &mut census);
        }
    }
    census
}

/// Looks at a body and every image of a wall that comes near its bounding circle.
fn look_at_images(body: &BodyView<'_>, wall: &BodyView<'_>, sides: DVec2, census: &mut OverlapCensus) {
    let Some([first, second]) = wall.wall() else { return };
    let reach = body.body.reach() + wall.body.reach();
    let extent = 0.5 * (second - first).abs() + reach;
    let separation = wall.motion.position - body.motion.position;
    let (low, high) = ((-(separation + extent) / sides).ceil(), ((extent - separation) / sides).floor());
    for row in low.y as i64..=high.y as i64 {
        for column in low.x as i64..=high.x as i64 {
            look(body, wall, DVec2::new(column as f64, row as f64) * sides, sides, census);
        }
    }
}

fn look(a: &BodyView<'_>, b: &BodyView<'_>, shift: DVec2, sides: DVec2, census: &mut OverlapCensus) {
    if a.body.is_fixed() && b.body.is_fixed() {
        return;
    }
    let separation = (b.motion.position - a.motion.position) + shift;
    let bounding = a.body.molecule().bounding_radius() + b.body.molecule().bounding_radius();
    if separation.length_squared() > bounding * bounding {
        return;
    }
    let reach = a.body.reach() + b.body.reach();
    let rotation = |body: &BodyView<'_>| body.motion.orientation.cos_sin();
    let gap = gap_between(a.body.molecule(), rotation(a), b.body.molecule(), rotation(b), separation);
    if gap >= 0.0 {
        return;
    }
    let smallest = |body: &BodyView<'_>| {
        // A wall has no diameter of its own.
        let atoms = if body.body.is_wall() { &[] } else { body.body.molecule().atoms() };
        atoms.iter().map(|atom| 2.0 * atom.radius()).fold(f64::INFINITY, f64::min)
    };
    census.deepest_length = census.deepest_length.max(-gap);
    census.deepest = census.deepest.max(-gap / smallest(a).min(smallest(b)));
    if -gap > rounding_bound(sides, reach) {
        census.pairs += 1;
    }
}

/// How deep an overlap rounding alone can make (length), in a box of these sides between bodies whose
/// bounding radii add up to `reach`.
pub fn rounding_bound(sides: DVec2, reach: f64) -> f64 {
    ROUNDINGS * f64::EPSILON * (sides.x.max(sides.y) + reach)
}
