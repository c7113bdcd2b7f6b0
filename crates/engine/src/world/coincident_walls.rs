//! Walls in the same place with different temperatures, whose contacts would have no defined
//! temperature.

use carom_geometry::{Edge, Molecule, PeriodicBox};
use glam::DVec2;

use crate::world::{World, rounding_bound::rounding_bound};

/// The first wall of the world that lies in the same place as a new one, in any image of the box,
/// and has another temperature.
///
/// Walls across the box at 0 and at its side are such a pair: the box is periodic, so that both are
/// one line. Which of the two a body meets would be decided by rounding.
pub(crate) fn coincident_wall(
    world: &World,
    wall: &Molecule,
    centre: DVec2,
    temperature: Option<f64>,
) -> Option<usize> {
    let edge = wall.wall_edge()?;
    let (centre, _) = world.bounds.wrap(centre);
    let is_same = |&index: &usize| {
        let (body, place) = (&world.bodies[index], world.motions[index].position);
        let other = body.molecule().wall_edge();
        // One that has turned lies elsewhere at almost any time.
        let other = other.filter(|_| world.motions[index].orientation.turns() == 0.0);
        body.wall_temperature() != temperature
            && other.is_some_and(|other| lie_together(edge, other, place - centre, &world.bounds))
    };
    (0..world.bodies.len()).find(is_same)
}

/// Whether two walls of the same thickness share a part of some length, if their centres differ by
/// `offset` (length) or by that and any number of boxes.
fn lie_together(one: &Edge, other: &Edge, offset: DVec2, bounds: &PeriodicBox) -> bool {
    if one.bend().is_some() || other.bend().is_some() {
        let apart = bounds.nearest_image(offset).length();
        return one.bend() == other.bend() && apart <= rounding_bound(bounds.sides(), one.reach());
    }
    let (sides, lengths) = (
        bounds.sides(),
        [one, other].map(|edge| 2.0 * edge.half_length()),
    );
    let tolerance = rounding_bound(sides, lengths[0].max(lengths[1]));
    let tilt = one.along().perp_dot(other.along()).abs() * lengths[0].min(lengths[1]);
    if (one.radius() - other.radius()).abs() > tolerance || tilt > tolerance {
        return false;
    }
    // Halves of the extents, so far from each other that walls in the images still meet.
    let reach = one.half_length() * one.along().abs() + other.half_length() * other.along().abs();
    let [columns, rows] = [0, 1].map(|axis| {
        let index = |place: f64| (place / sides[axis]).round() as i64;
        index(-offset[axis] - reach[axis])..=index(-offset[axis] + reach[axis])
    });
    let shares_a_part = |place: DVec2| {
        let apart = one.along().perp_dot(place).abs();
        let along = one.along().dot(place).abs();
        apart <= tolerance && along < 0.5 * (lengths[0] + lengths[1]) - tolerance
    };
    columns
        .flat_map(|column| rows.clone().map(move |row| [column, row]))
        .any(|image| {
            let image = DVec2::new(image[0] as f64, image[1] as f64);
            shares_a_part(offset + image * sides)
        })
}
