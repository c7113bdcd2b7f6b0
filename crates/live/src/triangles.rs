//! Triangles that fill closed lines, for the graphics processor.

use glam::DVec2;

/// Heights closer than this part of the size of the shape are taken as equal: the two ends of a
/// corner that is too small to be drawn.
const SAME: f64 = 1e-4;

/// Corners of triangles, three by three, that cover what closed polygons enclose by the even-odd
/// rule: holes stay free.
///
/// The plane is cut into strips at the heights of all corners. Within a strip no two sides cross,
/// so every second of the areas between them is inside: a trapezoid, or two triangles.
pub(crate) fn triangles(lines: &[Vec<DVec2>]) -> Vec<DVec2> {
    let mut heights: Vec<f64> = lines.iter().flatten().map(|corner| corner.y).collect();
    heights.sort_by(f64::total_cmp);
    let size = heights.iter().fold(0.0, |most: f64, y| most.max(y.abs()));
    heights.dedup_by(|above, below| *above - *below <= SAME * size);
    // Upwards, so that each side has the same ends in all strips.
    let sides = lines.iter().flat_map(|line| {
        let next = line.iter().cycle().skip(1);
        line.iter().zip(next)
    });
    let mut upwards: Vec<(DVec2, DVec2)> = sides
        .map(|(&from, &to)| {
            if from.y <= to.y {
                (from, to)
            } else {
                (to, from)
            }
        })
        .collect();
    upwards.sort_by(|one, other| one.0.y.total_cmp(&other.0.y));
    let mut found = Vec::new();
    for strip in heights.windows(2) {
        fill(&upwards, [strip[0], strip[1]], &mut found);
    }
    found
}

/// Adds the triangles between two heights.
fn fill(sides: &[(DVec2, DVec2)], [low, high]: [f64; 2], found: &mut Vec<DVec2>) {
    let middle = 0.5 * (low + high);
    let at = |(from, to): (DVec2, DVec2), y: f64| {
        let share = ((y - from.y) / (to.y - from.y)).clamp(0.0, 1.0);
        DVec2::new(from.x + share * (to.x - from.x), y)
    };
    let mut across: Vec<(DVec2, DVec2)> = sides
        .iter()
        .copied()
        .take_while(|(from, _)| from.y < middle)
        .filter(|(_, to)| to.y > middle)
        .collect();
    across.sort_by(|one, other| at(*one, middle).x.total_cmp(&at(*other, middle).x));
    for pair in across.chunks_exact(2) {
        let [a, b] = [at(pair[0], low), at(pair[1], low)];
        let [c, d] = [at(pair[0], high), at(pair[1], high)];
        if b.x > a.x {
            found.extend([a, b, d]);
        }
        if d.x > c.x {
            found.extend([a, d, c]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::{
        Molecule,
        geometry::{Atom, Interior},
    };

    fn area(corners: &[DVec2]) -> f64 {
        let of =
            |corners: &[DVec2]| 0.5 * (corners[1] - corners[0]).perp_dot(corners[2] - corners[0]);
        corners.chunks_exact(3).map(of).sum()
    }

    fn of(molecule: &Molecule) -> Vec<DVec2> {
        let contours = molecule.visible_contours();
        let lines: Vec<_> = contours
            .iter()
            .map(|contour| contour.points(0.05))
            .collect();
        triangles(&lines)
    }

    #[test]
    fn triangles_cover_convex_and_concave_bodies_and_leave_holes() {
        let ell = [
            (0.0, 0.0),
            (3.0, 0.0),
            (3.0, 1.0),
            (1.0, 1.0),
            (1.0, 3.0),
            (0.0, 3.0),
        ];
        let ell = Molecule::polygon(&ell.map(DVec2::from), 1e-6, 1.0).unwrap();
        let triangles = of(&ell);
        assert_eq!(triangles.len(), 4 * 3);
        assert!((area(&triangles) / ell.area() - 1.0).abs() < 1e-5);
        let rim = (0..6).map(|k| DVec2::from_angle(std::f64::consts::FRAC_PI_3 * f64::from(k)));
        let atoms = rim.map(|at| (at, 0.1)).chain([(DVec2::ZERO, 0.3)]);
        let edges: Vec<_> = (0..6).map(|k| ([k, (k + 1) % 6], 0.1)).collect();
        let ring = Molecule::with_edges(
            atoms.map(|(at, radius)| Atom::new(at, radius, 1.0).unwrap()),
            &edges,
            Interior::Hollow,
        )
        .unwrap();
        let capsule = Molecule::capsule(2.0, 0.5, 1.0).unwrap();
        for molecule in [ring, capsule] {
            let found = area(&of(&molecule));
            assert!((found / molecule.area() - 1.0).abs() < 1e-3, "{found}");
        }
    }
}
