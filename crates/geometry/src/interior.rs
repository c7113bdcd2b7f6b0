//! The interior of closed lines of edges: what a polygon or a ring encloses.

use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{Atom, Edge, GeometryError, check_length, check_positive};

/// Whether what a closed line of edges encloses belongs to the body.
///
/// Contacts do not depend on it: nothing gets inside a closed line without a contact. The area, the
/// mass of a uniform body, and the overlap of bodies do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Interior {
    /// It belongs to the body: a polygon.
    #[default]
    Solid,
    /// It does not: a ring, in which other bodies may move.
    Hollow,
}

/// The most corners of a polygon; a larger number is probably an error.
pub(crate) const MAX_CORNERS: usize = 1024;

/// The smallest radius of the corners of a polygon, as a share of the largest distance of a corner
/// from the first. At smaller radii the rounding of positions hides on which side of an edge a
/// corner is: the bound on the rounding of a gap is some 10⁻¹⁴ of that size.
pub const MIN_ROUNDING: f64 = 1e-10;

/// The corners of a polygon, if there are at least three, no two sides meet but at their common
/// corner, and `radius` is not too small for its size.
pub(crate) fn simple_polygon(corners: &[DVec2], radius: f64) -> Result<&[DVec2], GeometryError> {
    let refused = |problem: String| Err(GeometryError::Polygon(problem));
    let count = corners.len();
    check_corner_count(count)?;
    for corner in corners {
        check_length("the x of a corner", corner.x)?;
        check_length("the y of a corner", corner.y)?;
    }
    check_positive("the radius of the corners", radius)?;
    let size = corners
        .iter()
        .map(|corner| corner.distance(corners[0]))
        .fold(0.0, f64::max);
    if radius < MIN_ROUNDING * size {
        return refused(format!(
            "needs corners of a radius of at least {MIN_ROUNDING:e} of its size {size:e}, since rounding hides \
             smaller ones, but the radius is {radius:e}"
        ));
    }
    let side = |index: usize| [corners[index], corners[(index + 1) % count]];
    for second in 0..count {
        let [from, to] = side(second);
        let before = corners[(second + count - 1) % count];
        if from == to {
            return refused(format!("has corner {second} twice"));
        }
        if folds_back(before - from, to - from) {
            return refused(format!("folds back on itself at corner {second}"));
        }
    }
    let sides: Vec<_> = (0..count).map(side).collect();
    let is_apart =
        |first: usize, second: usize| first + 1 < second && !(first == 0 && second + 1 == count);
    if let Some([first, second]) = first_meeting(&sides, is_apart) {
        return refused(format!("has sides {first} and {second} that meet"));
    }
    Ok(corners)
}

/// Refuses a number of corners that no polygon has, before time is spent on their places.
///
/// # Errors
/// [`GeometryError::Polygon`] with the number.
pub fn check_corner_count(count: usize) -> Result<(), GeometryError> {
    if (3..=MAX_CORNERS).contains(&count) {
        return Ok(());
    }
    Err(GeometryError::Polygon(format!(
        "needs 3 to {MAX_CORNERS} corners, but has {count}"
    )))
}

/// The first two of these segments, in ascending order, that have a point in common, among those
/// that must be apart.
fn first_meeting(
    segments: &[[DVec2; 2]],
    is_apart: impl Fn(usize, usize) -> bool,
) -> Option<[usize; 2]> {
    (0..segments.len()).find_map(|second| {
        let meets = |&first: &usize| {
            is_apart(first, second) && segments_meet(segments[first], segments[second])
        };
        (0..second).find(meets).map(|first| [first, second])
    })
}

/// Whether two sides from one corner lie on each other.
fn folds_back(one: DVec2, other: DVec2) -> bool {
    one.perp_dot(other) == 0.0 && one.dot(other) > 0.0
}

/// Whether two segments have a point in common.
pub(crate) fn segments_meet([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> bool {
    let side = |from: DVec2, to: DVec2, point: DVec2| (to - from).perp_dot(point - from);
    let (c_of_ab, d_of_ab) = (side(a, b, c), side(a, b, d));
    let (a_of_cd, b_of_cd) = (side(c, d, a), side(c, d, b));
    if (c_of_ab, d_of_ab, a_of_cd, b_of_cd) == (0.0, 0.0, 0.0, 0.0) {
        // On one line.
        let along = b - a;
        let [low, high] = [c, d].map(|point| along.dot(point - a) / along.length_squared());
        return low.min(high) <= 1.0 && low.max(high) >= 0.0;
    }
    c_of_ab.signum() * d_of_ab.signum() <= 0.0 && a_of_cd.signum() * b_of_cd.signum() <= 0.0
        || (c_of_ab == 0.0 || d_of_ab == 0.0) && a_of_cd * b_of_cd <= 0.0
        || (a_of_cd == 0.0 || b_of_cd == 0.0) && c_of_ab * d_of_ab <= 0.0
}

/// Edges of one radius from each of `count` atoms to the next, and from the last to the first.
pub(crate) fn closed_line(count: u32, radius: f64) -> Vec<([u32; 2], f64)> {
    (0..count)
        .map(|index| ([index, (index + 1) % count], radius))
        .collect()
}

/// Refuses edges of which it is not clear what they enclose, if that is to be solid: connected
/// edges that close a line and branch, and closed lines that cross themselves.
pub(crate) fn check_lines(
    atoms: &[Atom],
    edges: &[Edge],
    interior: Interior,
) -> Result<(), GeometryError> {
    let refused = |index: usize, problem| {
        let ends = edges[index].ends().unwrap_or_default();
        Err(GeometryError::Edge {
            index,
            ends,
            problem,
        })
    };
    if interior == Interior::Hollow {
        return Ok(());
    }
    let neighbours = neighbours(atoms.len(), edges);
    let mut seen = vec![false; atoms.len()];
    for start in 0..atoms.len() as u32 {
        let line = line_from(start, &neighbours, &mut seen);
        let of_line = |edge: &Edge| edge.ends().is_some_and(|[end, _]| line.contains(&end));
        let numbers: Vec<usize> = (0..edges.len())
            .filter(|&index| of_line(&edges[index]))
            .collect();
        if numbers.is_empty() || numbers.len() < line.len() {
            continue;
        }
        if line
            .iter()
            .any(|&atom| neighbours[atom as usize].len() != 2)
        {
            return refused(
                numbers[0],
                "belongs to a closed line with branches, of which it is not clear what they enclose: give \
                 `hollow = true`",
            );
        }
        let ends = |place: usize| edges[numbers[place]].ends().unwrap_or_default();
        let is_apart = |one: usize, other: usize| {
            let others = ends(other);
            !ends(one).iter().any(|end| others.contains(end))
        };
        let segments: Vec<_> = numbers
            .iter()
            .map(|&index| edges[index].segment())
            .collect();
        if let Some([_, second]) = first_meeting(&segments, is_apart) {
            return refused(numbers[second], "crosses another edge of its closed line");
        }
    }
    Ok(())
}

/// For each atom those with which an edge joins it.
fn neighbours(atoms: usize, edges: &[Edge]) -> Vec<Vec<u32>> {
    let mut neighbours: Vec<Vec<u32>> = vec![Vec::new(); atoms];
    for [first, second] in edges.iter().filter_map(Edge::ends) {
        neighbours[first as usize].push(second);
        neighbours[second as usize].push(first);
    }
    neighbours
}

/// Closed lines of edges whose interior is solid: the indices of their atoms, counter-clockwise.
///
/// A closed line is a connected part in which each atom is at the end of exactly two edges.
pub(crate) fn solid_rings(atoms: &[Atom], edges: &[Edge], interior: Interior) -> Vec<Vec<u32>> {
    if interior == Interior::Hollow {
        return Vec::new();
    }
    let neighbours = neighbours(atoms.len(), edges);
    let mut seen = vec![false; atoms.len()];
    let mut rings = Vec::new();
    for start in 0..atoms.len() as u32 {
        if seen[start as usize] {
            continue;
        }
        let line = line_from(start, &neighbours, &mut seen);
        if line.len() > 2
            && line
                .iter()
                .all(|&atom| neighbours[atom as usize].len() == 2)
        {
            rings.push(counter_clockwise(line, atoms));
        }
    }
    rings
}

/// The atoms connected to `start`, each the neighbour of one before it.
fn line_from(start: u32, neighbours: &[Vec<u32>], seen: &mut [bool]) -> Vec<u32> {
    let (mut line, mut next) = (Vec::new(), vec![start]);
    while let Some(atom) = next.pop() {
        if std::mem::replace(&mut seen[atom as usize], true) {
            continue;
        }
        line.push(atom);
        next.extend(neighbours[atom as usize].iter().rev());
    }
    line
}

fn counter_clockwise(mut line: Vec<u32>, atoms: &[Atom]) -> Vec<u32> {
    let place = |index: usize| atoms[line[index % line.len()] as usize].offset();
    let doubled: f64 = (0..line.len())
        .map(|index| place(index).perp_dot(place(index + 1)))
        .sum();
    if doubled < 0.0 {
        line.reverse();
    }
    line
}

/// Whether a closed line through these points, in order, encloses a point (by the number of its
/// sides that a ray to the right crosses).
pub(crate) fn encloses(line: impl Iterator<Item = [DVec2; 2]>, point: DVec2) -> bool {
    let crosses = |&[from, to]: &[DVec2; 2]| {
        let is_between = (from.y > point.y) != (to.y > point.y);
        is_between && {
            let turn = (to - from).perp_dot(point - from);
            if to.y > from.y {
                turn > 0.0
            } else {
                turn < 0.0
            }
        }
    };
    line.filter(crosses).count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Molecule;

    fn corners(list: &[(f64, f64)]) -> Vec<DVec2> {
        list.iter().copied().map(DVec2::from).collect()
    }

    #[test]
    fn polygons_whose_sides_meet_are_refused_with_the_reason() {
        let refusal = |list: &[(f64, f64)], radius| {
            let refused = Molecule::polygon(&corners(list), radius, 1.0);
            refused.unwrap_err().to_string()
        };
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let bow = [(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)];
        let touching = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 0.0), (0.0, 1.0)];
        let spike = [(0.0, 0.0), (2.0, 0.0), (1.0, 0.0), (1.0, 1.0)];
        for (list, radius, expected) in [
            (&square[..2], 0.1, "needs 3 to 1024 corners, but has 2"),
            (&square[..], 1e-12, "since rounding hides"),
            (&bow[..], 1e-3, "sides 0 and 2 that meet"),
            (&touching[..], 1e-3, "sides 0 and 2 that meet"),
            (&spike[..], 1e-3, "folds back on itself at corner 1"),
            (&square[..], -0.1, "radius of the corners"),
            (
                &[(0.0, 0.0), (f64::NAN, 0.0), (1.0, 1.0)],
                0.1,
                "x of a corner",
            ),
        ] {
            let problem = refusal(list, radius);
            assert!(problem.contains(expected), "{problem} for {expected}");
        }
        assert!(Molecule::polygon(&corners(&square), 1e-6, 1.0).is_ok());
    }

    #[test]
    fn rings_are_closed_lines_in_counter_clockwise_order() {
        let clockwise = corners(&[(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)]);
        let square = Molecule::polygon(&clockwise, 0.01, 1.0).unwrap();
        assert_eq!(square.solid_rings(), [vec![3, 2, 1, 0]]);
        let open = Molecule::with_edges(
            square.atoms().iter().copied(),
            &[([0, 1], 0.01), ([1, 2], 0.01)],
            Interior::Solid,
        );
        assert!(open.unwrap().solid_rings().is_empty());
    }

    #[test]
    fn a_point_is_enclosed_by_a_notched_line_only_inside() {
        let ell = corners(&[
            (0.0, 0.0),
            (3.0, 0.0),
            (3.0, 1.0),
            (1.0, 1.0),
            (1.0, 3.0),
            (0.0, 3.0),
        ]);
        let encloses = |x, y| {
            let sides = (0..6).map(|index| [ell[index], ell[(index + 1) % 6]]);
            encloses(sides, DVec2::new(x, y))
        };
        assert!(encloses(0.5, 2.0) && encloses(2.0, 0.5) && encloses(0.5, 1.0));
        assert!(!encloses(2.0, 2.0) && !encloses(-0.5, 1.0) && !encloses(3.5, 0.5));
    }
}
