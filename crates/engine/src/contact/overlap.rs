//! The overlap check: all near pairs of a view, computed independently of the scheduler's lists.

use glam::DVec2;

use crate::world::{
    World,
    body::Body,
    pair_table::{PairTable, gap_with_factor},
    rounding_bound::rounding_bound,
    tethers::BondView,
    view::{BodyView, View},
    wall::StandingWall,
};

/// The overlapping pairs at one time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct OverlapCensus {
    /// Number of pairs that overlap, and of bonds that are beyond their bounds, by more than the
    /// rounding bound.
    pub pairs: usize,
    /// The deepest overlap of any pair, in units of the smaller diameter of the two bodies: that
    /// of the smallest atom, or 4 A/P for a body of area A and perimeter P that has edges; 0 if no
    /// bodies overlap. It may be due to rounding.
    pub deepest: f64,
    /// The deepest overlap of any pair, or the largest excess of a bond (length).
    pub deepest_length: f64,
}

impl View<'_> {
    /// Pairs of bodies that overlap by more than rounding.
    pub fn overlaps(&self) -> OverlapCensus {
        census(self)
    }
}

/// A body in the cell list of the census: all that rules out most pairs.
#[derive(Debug, Clone, Copy)]
struct NearBody {
    place: DVec2,
    bounding_radius: f64,
    /// Its index among the bodies of the view.
    index: u32,
}

/// Calls `look` for each pair of bodies that are no walls and whose bounding circles may be as near
/// as two bodies reach each other, with their indices in ascending order and the shift of the image
/// of the second. It has its own cell list. The views are all those of a world at an offset in the
/// epoch (time).
pub(crate) fn each_near_pair<'a>(
    world: &World,
    offset: f64,
    bodies: &mut [BodyView<'a>],
    mut look: impl FnMut([u32; 2], [&BodyView<'a>; 2], DVec2),
) {
    let bounds = world.bounds_at(offset);
    let sides = bounds.sides();
    // Under shear cells are parallelograms, as those of the schedulers.
    let seam = world.seam_at(offset);
    if let Some(seam) = &seam {
        for body in &mut *bodies {
            seam.enter_cells(&mut body.motion);
        }
    }
    let bodies = &*bodies;
    let across = |place: DVec2| seam.map_or(place.x, |seam| seam.across(place));
    let reach = world.largest_reach();
    // At least one cell, and at most about √N per side for N bodies: an empty cell costs as much as
    // a full one.
    let count = |side: f64| ((side / reach).min(1.0 + (bodies.len() as f64).sqrt()) as i64).max(1);
    let columns = count(sides.x / world.stretch_of_cells());
    let rows = count(sides.y);
    let number = |[column, row]: [i64; 2]| (row * columns + column) as usize;
    let cell_of = |place: DVec2| {
        let index = |x: f64, side: f64, n: i64| ((x / side * n as f64) as i64).clamp(0, n - 1);
        number([
            index(across(place), sides.x, columns),
            index(place.y, sides.y, rows),
        ])
    };
    let (listed, starts) = list_by_cell(bodies, number([0, rows]), cell_of);
    let members = |cell: usize| &listed[starts[cell]..starts[cell + 1]];
    let factor = world.pairs.largest_factor();
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        for step in 0..9 {
            let (to_column, boxes_across) = wrapped(column + step % 3 - 1, columns);
            let (to_row, boxes_up) = wrapped(row + step / 3 - 1, rows);
            let there = members(number([to_column, to_row]));
            let shift = bounds.shift([boxes_across, boxes_up]);
            for a in members(number([column, row])) {
                for b in there.iter().filter(|b| b.index > a.index) {
                    let bounding = factor * (a.bounding_radius + b.bounding_radius);
                    if ((b.place - a.place) + shift).length_squared() <= bounding * bounding {
                        let indices = [a, b].map(|body| body.index);
                        look(indices, indices.map(|body| &bodies[body as usize]), shift);
                    }
                }
            }
        }
    }
}

/// Counts the overlapping pairs of a view.
fn census(view: &View<'_>) -> OverlapCensus {
    let sides = view.bounds().sides();
    let mut bodies: Vec<BodyView<'_>> = view.bodies().collect();
    let pairs = &view.world.pairs;
    let mut census = OverlapCensus::default();
    each_near_pair(view.world, view.offset, &mut bodies, |_, [a, b], shift| {
        look(a, b, pairs, shift, sides, &mut census);
    });
    for wall in bodies.iter().filter(|body| body.body.is_wall()) {
        let may_touch = |body: &Body| body.is_free() || (wall.body.is_piston() && !body.is_wall());
        for body in bodies.iter().filter(|body| may_touch(body.body)) {
            look_at_images(body, wall, pairs, sides, &mut census);
        }
    }
    for BondView { bond, length, .. } in view.bonds() {
        let excess = bond.excess(length);
        census.deepest_length = census.deepest_length.max(excess);
        if excess > rounding_bound(sides, bond.tether.reach()) {
            census.pairs += 1;
        }
    }
    census
}

/// The column or row in the box of one that is at most one beyond the first or last of `count`, and
/// the number of boxes in between. Divisions would take most of the time of the census.
fn wrapped(place: i64, count: i64) -> (i64, i64) {
    if place < 0 {
        (place + count, -1)
    } else if place >= count {
        (place - count, 1)
    } else {
        (place, 0)
    }
}

/// The bodies that are not walls, sorted by cell, and for each cell the place of its first body in
/// this list.
fn list_by_cell(
    bodies: &[BodyView<'_>],
    cells: usize,
    cell_of: impl Fn(DVec2) -> usize,
) -> (Vec<NearBody>, Vec<usize>) {
    let not_walls = bodies
        .iter()
        .zip(0..)
        .filter(|(body, _)| !body.body.is_wall());
    let mut next = vec![0; cells + 1];
    for (body, _) in not_walls.clone() {
        next[cell_of(body.motion.position)] += 1;
    }
    let mut count = 0;
    for start in &mut next {
        count += std::mem::replace(start, count);
    }
    let starts = next.clone();
    let mut listed = vec![
        NearBody {
            place: DVec2::ZERO,
            bounding_radius: 0.0,
            index: 0
        };
        count
    ];
    for (body, index) in not_walls {
        let (place, bounding_radius) =
            (body.motion.position, body.body.molecule().bounding_radius());
        let next = &mut next[cell_of(place)];
        listed[*next] = NearBody {
            place,
            bounding_radius,
            index,
        };
        *next += 1;
    }
    (listed, starts)
}

/// Checks a body against each image of a wall that comes near its bounding circle.
fn look_at_images(
    body: &BodyView<'_>,
    wall: &BodyView<'_>,
    pairs: &PairTable,
    sides: DVec2,
    census: &mut OverlapCensus,
) {
    let Some(standing) = StandingWall::new(wall.body, &wall.motion) else {
        return;
    };
    let reach = body.body.reach() + wall.body.reach();
    let [first, last] = standing
        .extent()
        .map(|corner| body.motion.position - corner);
    let (low, high) = (
        ((last - reach) / sides).ceil(),
        ((first + reach) / sides).floor(),
    );
    for row in low.y as i64..=high.y as i64 {
        for column in low.x as i64..=high.x as i64 {
            look(
                body,
                wall,
                pairs,
                DVec2::new(column as f64, row as f64) * sides,
                sides,
                census,
            );
        }
    }
}

fn look(
    a: &BodyView<'_>,
    b: &BodyView<'_>,
    pairs: &PairTable,
    shift: DVec2,
    sides: DVec2,
    census: &mut OverlapCensus,
) {
    if a.body.is_fixed() && b.body.is_fixed() {
        return;
    }
    let factor = pairs.factor(a.body, b.body);
    let separation = (b.motion.position - a.motion.position) + shift;
    let bounding =
        factor * (a.body.molecule().bounding_radius() + b.body.molecule().bounding_radius());
    if factor == 0.0 || separation.length_squared() > bounding * bounding {
        return;
    }
    let reach = a.body.reach() + b.body.reach();
    let rotation = |body: &BodyView<'_>| body.motion.orientation.cos_sin();
    let gap = gap_with_factor(
        factor,
        [a.body.molecule(), b.body.molecule()],
        [rotation(a), rotation(b)],
        separation,
    );
    if gap >= 0.0 {
        return;
    }
    census.deepest_length = census.deepest_length.max(-gap);
    let diameter = [a, b].map(|body| diameter(body.body));
    census.deepest = census.deepest.max(-gap / diameter[0].min(diameter[1]));
    if -gap > rounding_bound(sides, reach) {
        census.pairs += 1;
    }
}

/// The length to which an overlap is compared: the diameter of the smallest atom, or the width of
/// an ellipse; for a body with edges, whose corners may be sharp, the hydraulic diameter 4 A/P;
/// infinite for a wall, which has no diameter of its own.
fn diameter(body: &Body) -> f64 {
    let molecule = body.molecule();
    if body.is_wall() {
        return f64::INFINITY;
    }
    if !molecule.edges().is_empty() {
        return 2.0 * molecule.mean_half_width();
    }
    2.0 * body.smallest_atom()
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use crate::{run::simulation::Simulation, scene::Scene};

    /// The wall lies from 0.05 to 0.45, beyond the border of the box as seen from its pivot.
    #[test]
    fn an_overlap_with_a_wall_far_from_its_pivot_is_found() {
        let scene = Scene::from_toml(
            "[[wall]]\nfrom = [0.05, 0.5]\nto = [0.45, 0.5]\nmotion = { turn = 1.0, about = [0.95, 0.5] }\n\
             [[molecule]]\natoms = [{ at = [0, 0], radius = 0.02, mass = 1.0 }]\nat = [0.4, 0.9]",
        )
        .unwrap();
        let mut simulation = Simulation::new(&scene).unwrap();
        assert_eq!(simulation.view().overlaps().pairs, 0);
        let disc = (simulation.world.bodies.iter())
            .position(|body| !body.is_fixed())
            .unwrap();
        simulation.world.motions[disc].position = DVec2::new(0.4, 0.51);
        let overlaps = simulation.view().overlaps();
        assert_eq!(overlaps.pairs, 1);
        assert!(
            (overlaps.deepest_length - 0.01).abs() < 1e-12,
            "{overlaps:?}"
        );
    }
}
