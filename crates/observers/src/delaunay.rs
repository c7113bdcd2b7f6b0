//! The Delaunay triangulation of positions in a periodic box, with the edges of the Voronoi cells.
//!
//! The box is surrounded by periodic images up to a margin, and the plane is triangulated with
//! adaptive-precision predicates (crate `spade`; J. R. Shewchuk, Discrete Comput. Geom. 18 (1997)
//! 305). The triangles at a body of the box are those of the infinite periodic system if each of
//! their circumcircles lies within the region with images: then no image that was left out is in
//! one. Otherwise the margin is doubled. A circle without a body has a radius of at most half the
//! diagonal of the box, because the images of one body come that near to every point, so that a
//! margin of one diagonal is enough. That holds in a tilted box too: the nearest row of images is
//! at most Ly/2 away along y, and an image in it at most Lx/2 along x.

use carom_geometry::PeriodicBox;
use glam::DVec2;
use spade::{
    DelaunayTriangulation, HasPosition, Point2, Triangulation,
    handles::{DirectedEdgeHandle, FaceHandle, PossiblyOuterTag},
};

use crate::cell_list::folded;

/// The first margin, in mean distances of the bodies.
const FIRST_MARGIN: f64 = 5.0;

/// Bodies whose Voronoi cells share an edge shorter than this share of their distance are no
/// neighbours: the cells meet in a point, as in a square lattice.
const NEGLIGIBLE_EDGE: f64 = 1e-9;

/// Largest number of images per body, and of further ones: 15 for each body fill a square box with
/// the largest margin; more are needed for a few bodies in a long, narrow box.
const IMAGES_PER_BODY: f64 = 16.0;
const MORE_IMAGES: f64 = 1e6;

/// Coordinates below this (mean distances) are taken as 0; `spade` refuses those below 2⁻¹⁴².
const MIN_COORDINATE: f64 = 1e-40;

/// A neighbour of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DelaunayBond {
    /// Index of the neighbour.
    pub(crate) other: usize,
    /// From the body to this image of the neighbour (length).
    pub(crate) displacement: DVec2,
    /// The edge that the Voronoi cells share (length).
    pub(crate) edge: f64,
}

/// A body or one of its images, in units of the mean distance.
struct Site {
    place: DVec2,
    body: usize,
    /// The image, in boxes; [0, 0] for the body itself.
    image: [i32; 2],
}

impl HasPosition for Site {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        Point2::new(self.place.x, self.place.y)
    }
}

type Edge<'a> = DirectedEdgeHandle<'a, Site, (), (), ()>;
type Face<'a> = FaceHandle<'a, PossiblyOuterTag, Site, (), (), ()>;

/// The neighbours of each body, in counterclockwise order; a body at the place of another has none.
///
/// A body can be a neighbour of its own images, and more than once of another. `None` without
/// bodies, and in a box so narrow that the images would be too many.
pub(crate) fn bonds(places: &[DVec2], bounds: &PeriodicBox) -> Option<Vec<Vec<DelaunayBond>>> {
    let bounds = folded(bounds).unwrap_or(bounds.tilted(0.0));
    let sides = bounds.sides();
    let spacing = (bounds.area() / places.len() as f64).sqrt();
    let scaled = sides / spacing;
    let largest = scaled.length() * (1.0 + 1e-6);
    let mut margin = FIRST_MARGIN.min(largest);
    loop {
        let sites = sites(places, &bounds, spacing, margin)?;
        let triangulation = DelaunayTriangulation::<Site>::bulk_load(sites).ok()?;
        let is_largest = margin >= largest;
        let region = [DVec2::splat(-margin), scaled + margin];
        let mut found = vec![Vec::new(); places.len()];
        let is_complete = triangulation
            .vertices()
            .filter(|vertex| vertex.data().image == [0; 2])
            .all(|vertex| {
                let bonds = &mut found[vertex.data().body];
                vertex.out_edges().all(|edge| {
                    let cell_edge = voronoi_edge(edge, (!is_largest).then_some(region));
                    cell_edge.is_some_and(|length| {
                        bonds.extend(bond(edge, length, places, &bounds, spacing));
                        true
                    })
                })
            });
        if is_complete {
            return Some(found);
        }
        if is_largest {
            return None;
        }
        margin = (2.0 * margin).min(largest);
    }
}

/// The bodies and their images up to a margin (mean distances); `None` if they are none or too
/// many.
fn sites(places: &[DVec2], bounds: &PeriodicBox, spacing: f64, margin: f64) -> Option<Vec<Site>> {
    let scaled = bounds.sides() / spacing;
    let expected = places.len() as f64 * ((scaled + 2.0 * margin) / scaled).element_product();
    if places.is_empty() || expected > IMAGES_PER_BODY * places.len() as f64 + MORE_IMAGES {
        return None;
    }
    let [mut columns, rows] = whole((margin / scaled).ceil());
    if bounds.tilt() != 0.0 {
        let tilt = f64::from(rows) * (bounds.tilt() / spacing).abs();
        columns = ((margin + tilt) / scaled.x).ceil() as i32;
    }
    let (low, high) = (DVec2::splat(-margin), scaled + margin);
    let mut sites = Vec::new();
    for row in -rows..=rows {
        for column in -columns..=columns {
            let image = [column, row];
            for (body, place) in places.iter().enumerate() {
                let place = (*place + bounds.shift(image.map(i64::from))) / spacing;
                let is_near = place.cmpge(low).all() && place.cmple(high).all();
                if is_near || image == [0; 2] {
                    let place = place.map(|x| if x.abs() < MIN_COORDINATE { 0.0 } else { x });
                    sites.push(Site { place, body, image });
                }
            }
        }
    }
    Some(sites)
}

fn whole(numbers: DVec2) -> [i32; 2] {
    numbers.to_array().map(|number| number as i32)
}

fn shift([column, row]: [i32; 2]) -> DVec2 {
    DVec2::new(f64::from(column), f64::from(row))
}

/// The length of the edge of the Voronoi cells at both ends of an edge of the triangulation (mean
/// distances). `None` if the edge is at the border of the triangulation, or a circumcircle leaves
/// the region.
fn voronoi_edge(edge: Edge<'_>, region: Option<[DVec2; 2]>) -> Option<f64> {
    let centre = |face: Face<'_>| {
        let (centre, squared) = face.as_inner()?.circumcircle();
        let (centre, radius) = (DVec2::new(centre.x, centre.y), squared.sqrt());
        let is_within = region.is_none_or(|[low, high]| {
            (centre - radius).cmpge(low).all() && (centre + radius).cmple(high).all()
        });
        is_within.then_some(centre)
    };
    Some(centre(edge.face())?.distance(centre(edge.rev().face())?))
}

/// The bond along an edge of the triangulation, unless the cells only meet in a point.
fn bond(
    edge: Edge<'_>,
    length: f64,
    places: &[DVec2],
    bounds: &PeriodicBox,
    spacing: f64,
) -> Option<DelaunayBond> {
    let (from, to) = (edge.from(), edge.to());
    let (from, to) = (from.data(), to.data());
    let shift = bounds.shift(to.image.map(i64::from));
    let displacement = places[to.body] - places[from.body] + shift;
    let bond = DelaunayBond {
        other: to.body,
        displacement,
        edge: length * spacing,
    };
    (bond.edge > NEGLIGIBLE_EDGE * displacement.length()).then_some(bond)
}

/// Area of the Voronoi cell with these neighbours (length²): the sum of the triangles on its edges,
/// |displacement| × edge / 4.
pub(crate) fn cell_area(bonds: &[DelaunayBond]) -> f64 {
    bonds
        .iter()
        .map(|bond| 0.25 * bond.displacement.length() * bond.edge)
        .sum()
}

/// Removes the bonds that cross a wall, and returns for each body whether it has lost one: its
/// Voronoi cell is bounded by the wall. `walls` are the end points of each wall.
pub(crate) fn cut_by_walls(
    bonds: &mut [Vec<DelaunayBond>],
    places: &[DVec2],
    walls: &[[DVec2; 2]],
    sides: DVec2,
) -> Vec<bool> {
    if walls.is_empty() {
        return vec![false; bonds.len()];
    }
    let cut = |(bonds, place): (&mut Vec<DelaunayBond>, &DVec2)| {
        let before = bonds.len();
        bonds.retain(|bond| {
            let to = *place + bond.displacement;
            !crosses_a_wall([*place, to], walls, sides)
        });
        bonds.len() < before
    };
    bonds.iter_mut().zip(places).map(cut).collect()
}

/// Whether a segment crosses a wall, given by its end points, or an image of one.
pub(crate) fn crosses_a_wall(segment: [DVec2; 2], walls: &[[DVec2; 2]], sides: DVec2) -> bool {
    walls
        .iter()
        .any(|wall| crosses_an_image(segment, *wall, sides))
}

/// Whether a segment crosses an image of a wall.
fn crosses_an_image(segment: [DVec2; 2], wall: [DVec2; 2], sides: DVec2) -> bool {
    let bounds = |[one, other]: [DVec2; 2]| (one.min(other), one.max(other));
    let ((low, high), (wall_low, wall_high)) = (bounds(segment), bounds(wall));
    let [left, bottom] = whole(((low - wall_high) / sides).ceil());
    let [right, top] = whole(((high - wall_low) / sides).floor());
    let images = (bottom..=top).flat_map(|row| (left..=right).map(move |column| [column, row]));
    images
        .map(|image| wall.map(|end| end + sides * shift(image)))
        .any(|wall| cross(segment, wall))
}

/// Whether two segments meet.
fn cross([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> bool {
    let side = |p: DVec2, q: DVec2, r: DVec2| (q - p).perp_dot(r - p);
    side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::random_points;
    use carom_engine::Simulation;

    fn places(count: usize, sides: [f64; 2], seed: u64) -> (Vec<DVec2>, PeriodicBox) {
        let simulation = Simulation::new(&random_points(count, sides, seed)).unwrap();
        let view = simulation.view();
        let places = view.bodies().map(|body| body.motion.position).collect();
        (places, view.bounds())
    }

    #[test]
    fn the_cells_fill_the_box_and_have_six_neighbours_on_average() {
        for (count, sides) in [
            (1, [1.0, 0.7]),
            (2, [1.0, 0.7]),
            (3, [1.0, 0.7]),
            (7, [1.0, 1.0]),
            (40, [0.1, 7.0]),
            (12, [1.0, 0.003]),
            (500, [1.0, 2.0]),
        ] {
            for seed in 0..5 {
                let (places, bounds) = places(count, sides, seed);
                let bonds = bonds(&places, &bounds).unwrap();
                let total: f64 = bonds.iter().map(|bonds| cell_area(bonds)).sum();
                let sides_of_cells: usize = bonds.iter().map(Vec::len).sum();
                assert!(
                    (total / bounds.area() - 1.0).abs() < 1e-9,
                    "{count} in {sides:?}: {total}"
                );
                // One body in a rectangular box forms a rectangular lattice.
                let expected = if count == 1 { 4 } else { 6 * count };
                assert_eq!(sides_of_cells, expected, "{count} in {sides:?}");
            }
        }
    }

    #[test]
    fn bonds_are_mutual_and_their_circles_are_empty() {
        let (places, bounds) = places(60, [1.0, 0.6], 3);
        let bonds = bonds(&places, &bounds).unwrap();
        for (index, of_one) in bonds.iter().enumerate() {
            for bond in of_one {
                let back = |other: &&DelaunayBond| {
                    other.other == index
                        && (other.displacement + bond.displacement).length() < 1e-12
                };
                let found = bonds[bond.other].iter().find(back).expect("mutual");
                assert!((found.edge - bond.edge).abs() < 1e-9);
            }
            // No body is nearer to the common corner of two neighbouring edges than the body.
            for (k, one) in of_one.iter().enumerate() {
                let next = of_one[(k + 1) % of_one.len()].displacement;
                let one = one.displacement;
                let determinant = 2.0 * one.perp_dot(next);
                let corner = DVec2::new(
                    next.y * one.length_squared() - one.y * next.length_squared(),
                    one.x * next.length_squared() - next.x * one.length_squared(),
                ) / determinant;
                let corner_place = places[index] + corner;
                for place in &places {
                    let apart = *place - corner_place;
                    let nearest = apart - bounds.sides() * (apart / bounds.sides()).round();
                    assert!(nearest.length() > corner.length() * (1.0 - 1e-9));
                }
            }
        }
    }

    #[test]
    fn bodies_in_a_line_at_one_place_and_in_a_square_lattice() {
        let bounds = PeriodicBox::new(DVec2::splat(8.0)).unwrap();
        let line: Vec<DVec2> = (0..8).map(|k| DVec2::new(f64::from(k), 2.0)).collect();
        let found = bonds(&line, &bounds).unwrap();
        assert!(found.iter().all(|bonds| bonds.len() == 4), "{found:?}");
        // The second body at one place has no cell of its own.
        let twice = [DVec2::ONE, DVec2::ONE, DVec2::new(3.0, 4.0)];
        let found = bonds(&twice, &bounds).unwrap();
        assert_eq!(found.iter().filter(|bonds| bonds.is_empty()).count(), 1);
        let lattice: Vec<DVec2> = (0..64)
            .map(|k| DVec2::new(f64::from(k % 8), f64::from(k / 8)))
            .collect();
        let found = bonds(&lattice, &bounds).unwrap();
        let is_square = |bond: &DelaunayBond| {
            (bond.displacement.length() - 1.0).abs() < 1e-12 && (bond.edge - 1.0).abs() < 1e-9
        };
        assert!(
            found
                .iter()
                .all(|bonds| bonds.len() == 4 && bonds.iter().all(is_square))
        );
        assert_eq!(bonds(&[], &bounds), None);
        // A box so narrow that the first margin holds too many images.
        let narrow = PeriodicBox::new(DVec2::new(1e12, 1.0)).unwrap();
        assert_eq!(bonds(&[DVec2::ZERO], &narrow), None);
    }

    /// A tilt by a whole number of lattice distances has the cells of the lattice, and random
    /// bodies have bonds that are mutual, with cells that fill the box.
    #[test]
    fn the_cells_of_a_tilted_box_are_those_of_its_images() {
        let square = PeriodicBox::new(DVec2::splat(8.0)).unwrap();
        let lattice: Vec<DVec2> = (0..64)
            .map(|k| DVec2::new(f64::from(k % 8), f64::from(k / 8)))
            .collect();
        for tilt in [3.0, -4.0, 13.0] {
            for bonds in bonds(&lattice, &square.tilted(tilt)).unwrap() {
                let has_length =
                    |bond: &DelaunayBond| (bond.displacement.length() - 1.0).abs() < 1e-12;
                assert!(bonds.len() == 4 && bonds.iter().all(has_length));
            }
        }
        // Sheared by half a distance in each row, it is a lattice with six neighbours.
        let skewed: Vec<DVec2> = lattice
            .iter()
            .map(|place| square.wrap(*place + DVec2::new(0.5 * place.y, 0.0)).0)
            .collect();
        let found = bonds(&skewed, &square.tilted(4.0)).unwrap();
        for bonds in &found {
            let mut lengths: Vec<f64> = bonds.iter().map(|b| b.displacement.length()).collect();
            lengths.sort_by(f64::total_cmp);
            let expected = [1.0, 1.0, 1.25_f64.sqrt(), 1.25_f64.sqrt()];
            assert!(
                lengths[..4]
                    .iter()
                    .zip(expected)
                    .all(|(a, b)| (a - b).abs() < 1e-12)
            );
            assert_eq!(lengths.len(), 6);
        }
        for (count, sides, tilt) in [
            (50, [1.0, 0.7], 0.4),
            (5, [1.0, 0.2], -0.5),
            (40, [0.1, 7.0], 0.03),
            (1, [1.0, 1.0], 0.37),
        ] {
            let (places, bounds) = places(count, sides, 2);
            let bonds = bonds(&places, &bounds.tilted(tilt)).unwrap();
            let total: f64 = bonds.iter().map(|bonds| cell_area(bonds)).sum();
            assert!((total / bounds.area() - 1.0).abs() < 1e-9, "{count} {tilt}");
            assert_eq!(bonds.iter().map(Vec::len).sum::<usize>(), 6 * count);
            for (index, of_one) in bonds.iter().enumerate() {
                for bond in of_one {
                    let is_back = |other: &DelaunayBond| {
                        other.other == index
                            && (other.displacement + bond.displacement).length() < 1e-12
                    };
                    assert!(bonds[bond.other].iter().any(is_back));
                }
            }
        }
    }

    #[test]
    fn walls_cut_the_bonds_across_them() {
        let bounds = PeriodicBox::new(DVec2::splat(8.0)).unwrap();
        let lattice: Vec<DVec2> = (0..64)
            .map(|k| DVec2::new(f64::from(k % 8) + 0.5, f64::from(k / 8) + 0.5))
            .collect();
        let mut found = bonds(&lattice, &bounds).unwrap();
        let wall = [DVec2::ZERO, DVec2::new(0.0, 8.0)];
        let is_at_wall = cut_by_walls(&mut found, &lattice, &[wall], bounds.sides());
        for (index, bonds) in found.iter().enumerate() {
            let is_outer = [0, 7].contains(&(index % 8));
            assert_eq!(is_at_wall[index], is_outer);
            assert_eq!(bonds.len(), if is_outer { 3 } else { 4 });
        }
    }
}
