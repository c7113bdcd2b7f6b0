//! All pairs of bodies that are near each other at one time, independently of the lists of the
//! schedulers.

use glam::DVec2;

use crate::world::{World, rounding_bound::rounding_bound, view::BodyView};

/// Calls `look` for each pair of bodies, except walls, that may touch or be within the range of a
/// well, with their indices in ascending order and the shift of the image of the second. It has its
/// own cell list. `bodies` are the views of all bodies at an offset in the epoch (time).
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
    // Rounding may carry a pair in a well beyond its range.
    let largest = world.largest_reach();
    let margin = rounding_bound(sides, largest);
    let reach = largest + margin;
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
                    let bounding = factor * (a.bounding_radius + b.bounding_radius) + margin;
                    if ((b.place - a.place) + shift).length_squared() <= bounding * bounding {
                        let indices = [a, b].map(|body| body.index);
                        look(indices, indices.map(|body| &bodies[body as usize]), shift);
                    }
                }
            }
        }
    }
}

/// A body in the cell list: all that rules out most pairs.
#[derive(Debug, Clone, Copy)]
struct NearBody {
    place: DVec2,
    bounding_radius: f64,
    /// Its index among the bodies.
    index: u32,
}

/// The column or row in the box of one that is at most one beyond the first or last of `count`, and
/// the number of boxes in between. Divisions would take most of the time.
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
