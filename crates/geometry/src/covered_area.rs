//! The area that a union of discs covers.
//!
//! Green's theorem turns the area into an integral along the boundary, A = ½ ∮ (x dy − y dx). The
//! boundary consists of the arcs of each circle that no other disc covers; each arc contributes
//! ½ r [r (φ₂ − φ₁) + x (sin φ₂ − sin φ₁) − y (cos φ₂ − cos φ₁)], with r and (x, y) the radius and
//! the centre of its circle (Avis, Bhattacharya & Imai 1988, Vis. Comput. 3, 323). Every arc runs
//! counter-clockwise about its own centre, so an arc around an enclosed hole subtracts the hole.

use glam::DVec2;

use crate::{boundary::boundary, union::Union};

/// Area of the union of the discs with these centres and radii (length²).
///
/// Rounding errors are a few 10⁻¹⁶ of the total length of the arcs times the distance of the
/// farthest point from the origin. That holds for circles that hardly cross, too, and for arcs of
/// any length: two arcs that meet end at one point to rounding (see [`boundary`](crate::boundary)).
/// Where three circles meet in one point at a small angle, they may be larger by its reciprocal, up
/// to 10⁻⁸.
pub(crate) fn covered_area(circles: &[(DVec2, f64)]) -> f64 {
    boundary(&Union::of_discs(circles.to_vec()))
        .iter()
        .map(|piece| piece.curve.swept_area())
        .sum()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use proptest::prelude::*;

    use super::*;
    use crate::{Atom, Molecule, Shape};

    fn union(discs: &[(f64, f64, f64)]) -> f64 {
        let circles: Vec<(DVec2, f64)> = discs
            .iter()
            .map(|&(x, y, r)| (DVec2::new(x, y), r))
            .collect();
        covered_area(&circles)
    }

    fn assert_close(found: f64, expected: f64) {
        assert!(
            (found - expected).abs() <= 1e-14 * expected,
            "{found} is not {expected}"
        );
    }

    /// Area common to two discs of radii r and s at distance d: two circular segments.
    fn lens(r: f64, s: f64, d: f64) -> f64 {
        let segment = |r: f64, s: f64| {
            let half = ((d * d + r * r - s * s) / (2.0 * d * r)).acos();
            r * r * (half - half.sin() * half.cos())
        };
        segment(r, s) + segment(s, r)
    }

    #[test]
    fn no_disc_covers_nothing_and_one_disc_its_own_area() {
        assert_eq!(union(&[]), 0.0);
        assert_eq!(union(&[(3.0, -4.0, 0.7)]), PI * 0.7 * 0.7);
    }

    #[test]
    fn two_discs_cover_the_sum_of_their_areas_less_their_lens() {
        for (r, s, d) in [
            (1.0, 1.0, 0.2),
            (1.0, 1.0, 1.9),
            (1.0, 0.4, 0.9),
            (2.0, 0.3, 1.75),
        ] {
            let expected = PI * (r * r + s * s) - lens(r, s, d);
            assert_close(union(&[(0.0, 0.0, r), (d, 0.0, s)]), expected);
            assert_close(union(&[(0.6 * d, -0.8 * d, s), (0.0, 0.0, r)]), expected);
        }
    }

    /// Circles that overlap by a few roundings cross at an angle of some 1e-8, of which little is
    /// known. Their lens is of no area, and the boundary must be closed there all the same.
    #[test]
    fn discs_that_hardly_overlap_cover_the_sum_of_their_areas() {
        for (r, s) in [(1.0, 0.3), (0.7, 0.1), (1.0, 1.0 / 3.0), (0.9, 0.89)] {
            for step in 0..40 {
                let d = (r + s) * (1.0 - f64::from(step) * f64::EPSILON);
                let expected = PI * (r * r + s * s);
                assert_close(union(&[(0.0, 0.0, r), (d, 0.0, s)]), expected);
                assert_close(union(&[(0.6 * d, -0.8 * d, s), (0.0, 0.0, r)]), expected);
                // And from inside: a small disc that sticks out by as little.
                let d = (r - s) * (1.0 + f64::from(step) * f64::EPSILON);
                assert_close(union(&[(0.0, 0.0, r), (d, 0.0, s)]), PI * r * r);
            }
        }
    }

    /// Two unit discs cross at (0, 0.8), and a third one covers that point by `depth`: its exposed
    /// arc is 8/3 `depth` long, and of no area. Without it the boundary is open by as much.
    #[test]
    fn arcs_of_any_length_close_the_boundary() {
        let expected = 2.0 * PI - lens(1.0, 1.0, 1.2);
        for step in 0..40 {
            let depth = 1e-14 * f64::from(step);
            assert_close(
                union(&[(-0.6, 0.0, 1.0), (0.6, 0.0, 1.0), (0.0, 0.05 + depth, 0.75)]),
                expected,
            );
        }
    }

    #[test]
    fn a_disc_within_another_adds_nothing() {
        assert_close(union(&[(0.0, 0.0, 1.0), (0.3, 0.2, 0.5)]), PI);
        assert_close(
            union(&[(0.1, 0.0, 0.5), (0.0, 0.0, 1.0), (0.0, 0.0, 0.2)]),
            PI,
        );
        // It touches the larger circle from inside.
        assert_close(union(&[(0.0, 0.0, 1.0), (0.5, 0.0, 0.5)]), PI);
    }

    #[test]
    fn identical_discs_cover_the_area_of_one() {
        for count in 1..6 {
            assert_close(union(&vec![(0.3, 0.4, 0.25); count]), PI * 0.0625);
        }
        let pair = union(&[(0.0, 0.0, 1.0), (0.5, 0.0, 1.0)]);
        let repeated = [
            (0.5, 0.0, 1.0),
            (0.0, 0.0, 1.0),
            (0.5, 0.0, 1.0),
            (0.0, 0.0, 1.0),
        ];
        assert_close(union(&repeated), pair);
    }

    #[test]
    fn touching_and_separate_discs_cover_the_sum_of_their_areas() {
        assert_close(union(&[(0.0, 0.0, 1.0), (1.5, 0.0, 0.5)]), 1.25 * PI);
        assert_close(union(&[(0.0, 0.0, 1.0), (1e6, 0.0, 1.0)]), 2.0 * PI);
        for shape in [Shape::Dumbbell, Shape::Tee] {
            let molecule = Molecule::named(shape, 0.1, 1.0).unwrap();
            assert_close(molecule.area(), molecule.atoms().len() as f64 * PI * 0.01);
        }
    }

    /// Twelve discs with centres on a circle of radius 2 overlap their two neighbours. Their
    /// centres are the corners of a regular 12-gon, whose side is 4 sin 15°; the hole in the
    /// middle is the 12-gon less the sectors and the overlaps inside it.
    #[test]
    fn the_hole_of_a_ring_is_not_covered() {
        let r = 0.7;
        let side = 4.0 * (PI / 12.0).sin();
        let at = |k: usize| {
            let (sin, cos) = (TAU * k as f64 / 12.0).sin_cos();
            (2.0 * cos, 2.0 * sin, r)
        };
        let ring: Vec<_> = (0..12).map(at).collect();
        // Next-nearest neighbours are 2 apart, beyond 2 r.
        let expected = 12.0 * (PI * r * r - lens(r, r, side));
        assert_close(union(&ring), expected);
        // A disc in the hole that touches nothing adds its own area.
        let with_island: Vec<_> = ring.iter().copied().chain([(0.1, 0.0, 0.3)]).collect();
        assert_close(union(&with_island), expected + PI * 0.09);
        // A disc over everything fills the hole.
        let filled: Vec<_> = ring.into_iter().chain([(0.0, 0.0, 2.0 + r)]).collect();
        assert_close(union(&filled), PI * (2.0 + r) * (2.0 + r));
    }

    #[test]
    fn a_molecule_counts_what_fused_atoms_share_once() {
        let atom = |x: f64| Atom::new(DVec2::new(x, 0.0), 1.0, 1.0).unwrap();
        let fused = Molecule::new([atom(5.0), atom(5.2)]).unwrap();
        assert_close(fused.area(), TAU - lens(1.0, 1.0, 0.2));
        let mass_of_both = Molecule::new([atom(5.0), atom(8.0)]).unwrap();
        assert_eq!(fused.mass(), mass_of_both.mass());
    }

    #[test]
    fn a_wall_covers_its_thickness() {
        let span = DVec2::new(3.0, 4.0);
        assert_eq!(Molecule::wall(span, 0.0).unwrap().area(), 0.0);
        assert_close(Molecule::wall(span, 0.1).unwrap().area(), 1.0 + PI * 0.01);
        assert_close(Molecule::wall_without_ends(span, 0.1).unwrap().area(), 1.0);
    }

    proptest! {
        /// Lines parallel to x, 1/500 apart, each covered over a union of intervals.
        #[test]
        fn the_area_is_that_of_its_horizontal_sections(
            discs in prop::collection::vec((-1.0..1.0f64, -1.0..1.0f64, 0.05..0.8f64), 1..9)
        ) {
            let lines = 1000;
            let step = 4.0 / f64::from(lines);
            let sections = (0..lines).map(|line| covered_length(&discs, (f64::from(line) + 0.5) * step - 2.0));
            let expected = step * sections.sum::<f64>();
            // At its top and bottom a disc is 2 √(2 r t) wide at depth t. There the midpoint rule
            // is off by at most 0.21 × 2 √(2 r) step^(3/2); all other errors are of order step².
            let ends: f64 = discs.iter().map(|(_, _, r)| 4.0 * (2.0 * r).sqrt()).sum();
            let error = 0.21 * ends * step.powf(1.5) + discs.len() as f64 * 10.0 * step * step;
            let found = union(&discs);
            prop_assert!((found - expected).abs() < error, "{} is not {}", found, expected);
        }
    }

    /// How much of the line at height `y` is covered.
    fn covered_length(discs: &[(f64, f64, f64)], y: f64) -> f64 {
        let mut intervals: Vec<(f64, f64)> = discs
            .iter()
            .filter(|(_, centre, r)| (y - centre).abs() < *r)
            .map(|&(x, centre, r)| {
                let half = (r * r - (y - centre) * (y - centre)).sqrt();
                (x - half, x + half)
            })
            .collect();
        intervals.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut covered, mut reached) = (0.0, f64::NEG_INFINITY);
        for (from, to) in intervals {
            covered += (to - from.max(reached)).max(0.0);
            reached = reached.max(to);
        }
        covered
    }
}
