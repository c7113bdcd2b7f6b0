//! Tests of the boundary of unions: it is closed, and it lies between the inside and the outside.

use std::f64::consts::PI;

use proptest::prelude::*;

use super::*;
use crate::union::{
    Bar,
    samples::{
        SQUARE, chain, dumbbell, ell, hollow, lattice_unions, plus, polygons, regular, solid, star,
        unions,
    },
};

/// Points on a piece at shares of its way, each with its outward normal.
fn points(curve: &Curve) -> [(DVec2, DVec2); 3] {
    [0.21, 0.47, 0.83].map(|share| match curve {
        Curve::Arc(arc) => {
            let normal = arc.start + share * arc.angle();
            (arc.point(normal), DVec2::from_angle(normal))
        }
        Curve::Side(side) => {
            let contact = side.contact(share);
            (contact.position(), DVec2::from_angle(contact.normal))
        }
    })
}

/// Distance of a piece from the centre or the axis of its part.
fn radius(curve: &Curve) -> f64 {
    match curve {
        Curve::Arc(arc) => arc.radius,
        Curve::Side(side) => side.radius,
    }
}

/// Panics unless ∮ dr = 0 and the body lies on the inner side of all pieces alone.
fn check(union: &Union, rounding: f64) {
    let pieces = boundary(union);
    let sum: DVec2 = pieces
        .iter()
        .map(|piece| {
            let [start, end] = piece.curve.ends();
            end - start
        })
        .sum();
    assert!(sum.length() < rounding, "open by {sum}: {union:?}");
    let size = union.reach();
    for piece in &pieces {
        let depth = 0.01 * piece.curve.length().min(radius(&piece.curve));
        if depth < 1e-14 * size {
            continue;
        }
        for (point, normal) in points(&piece.curve) {
            assert!(union.holds(point - depth * normal), "{piece:?} {union:?}");
            assert!(
                !union.holds(point + 1e-14 * size * normal),
                "{piece:?} {union:?}"
            );
        }
    }
}

/// Perimeter, and numbers of arcs and sides longer than roundings.
fn measures(union: &Union) -> (f64, usize, usize) {
    let pieces = boundary(union);
    let long = |piece: &&Piece| piece.curve.length() > 1e-13;
    let is_arc = |piece: &&Piece| matches!(piece.curve, Curve::Arc(_));
    let arcs = pieces.iter().filter(long).filter(is_arc).count();
    (
        pieces.iter().map(|piece| piece.curve.length()).sum(),
        arcs,
        pieces.iter().filter(long).count() - arcs,
    )
}

/// Panics unless perimeter and counts are as expected, in many orientations and at many places.
fn check_everywhere(union: &Union, (perimeter, arcs, sides): (f64, usize, usize)) {
    for step in 0..200 {
        let angle = 0.1 * f64::from(step) * PI / 2.0;
        let shift = f64::from(step % 7) * DVec2::new(0.3, -1.1);
        let placed = union.placed(angle, shift);
        let (found, found_arcs, found_sides) = measures(&placed);
        assert_eq!((found_arcs, found_sides), (arcs, sides), "step {step}");
        assert!(
            (found - perimeter).abs() < 1e-12 * perimeter,
            "{found} is not {perimeter} in step {step}"
        );
        check(&placed, 1e-13);
    }
}

#[test]
fn sides_begin_at_the_tangent_points_of_equal_radii() {
    for radius in [1e-9, 1e-6, 0.1, 0.3] {
        check_everywhere(
            &chain(&[(0.0, 0.0), (2.0, 0.0)], radius),
            (4.0 + 2.0 * PI * radius, 2, 2),
        );
        check_everywhere(&solid(&SQUARE, radius), (4.0 + 2.0 * PI * radius, 4, 4));
        let inner = 4.0 - 8.0 * radius;
        check_everywhere(
            &hollow(&SQUARE, radius),
            (4.0 + 2.0 * PI * radius + inner, 4, 8),
        );
    }
}

#[test]
fn sides_begin_at_the_chord_of_larger_discs() {
    for radius in [1e-9f64, 0.01, 0.5, 0.9] {
        let (half, chord) = (radius.asin(), (1.0 - radius * radius).sqrt());
        let expected = 4.0 * (PI - half) + 2.0 * (4.0 - 2.0 * chord);
        check_everywhere(&dumbbell(radius), (expected, 2, 2));
    }
}

/// Corners on straight sides end two sides without an arc between them.
#[test]
fn collinear_edges_meet_without_an_arc() {
    let points = [
        (-0.5, -0.5),
        (0.2, -0.5),
        (0.5, -0.5),
        (0.5, 0.1),
        (0.5, 0.5),
        (-0.1, 0.5),
        (-0.3, 0.5),
        (-0.5, 0.5),
    ];
    for radius in [1e-9, 0.1] {
        check_everywhere(&solid(&points, radius), (4.0 + 2.0 * PI * radius, 4, 8));
    }
    // And in the notch of a chain that is bent by less and less.
    for step in 0..50 {
        let bend = 0.5f64.powi(step);
        check(&chain(&[(-1.0, 0.0), (0.0, 0.0), (1.0, bend)], 0.1), 1e-14);
    }
}

#[test]
fn sides_end_at_their_crossing_in_a_notch() {
    for radius in [1e-9, 0.1] {
        check_everywhere(&ell(radius), (8.0 - 2.0 * radius + 2.5 * PI * radius, 5, 6));
        check_everywhere(
            &plus(radius),
            (8.0 - 8.0 * radius + 4.0 * PI * radius, 4, 8),
        );
    }
    for (tips, notch) in [(3, 0.3), (5, 0.5), (12, 0.9), (40, 0.97)] {
        for radius in [1e-9, 1e-3] {
            check(&solid(&star(tips, notch), radius), 1e-13);
            check(&hollow(&star(tips, notch), radius), 1e-13);
        }
    }
}

#[test]
fn polygons_of_up_to_256_corners_have_all_their_arcs_and_sides() {
    for corners in [3, 4, 5, 6, 7, 16, 100, 256] {
        let side = 2.0 * (PI / corners as f64).sin();
        for radius in [1e-9, 1e-3] {
            let polygon = solid(&regular(corners), radius);
            let (found, arcs, sides) = measures(&polygon);
            let expected = corners as f64 * side + 2.0 * PI * radius;
            assert!((found / expected - 1.0).abs() < 1e-13, "{corners} {radius}");
            assert_eq!((arcs, sides), (corners, corners));
            check(&polygon, 1e-13);
        }
    }
}

/// Lines and circles that coincide, or touch, count once.
#[test]
fn flush_parts_add_nothing() {
    let radius = 0.1;
    let line = (4.0 + 2.0 * PI * radius, 2, 2);
    let mut capsule = chain(&[(-1.0, 0.0), (1.0, 0.0), (0.25, 0.0)], radius);
    capsule.bars.truncate(1);
    check_everywhere(&capsule, line);
    // The second bar lies within the first one.
    capsule.bars.push(Bar {
        ends: [2, 1],
        radius,
    });
    check_everywhere(&capsule, line);
    // Of sides in one place, those of the first bar count.
    capsule.bars.reverse();
    check_everywhere(&capsule, (line.0, 2, 4));
    // Two bars that overlap, and one bar given twice.
    let mut overlap = chain(&[(-1.0, 0.0), (0.4, 0.0), (-0.3, 0.0), (1.0, 0.0)], radius);
    overlap.bars.remove(1);
    check_everywhere(&overlap, (line.0, 2, 4));
    let mut twice = chain(&[(-1.0, 0.0), (1.0, 0.0)], radius);
    twice.bars.push(twice.bars[0]);
    check_everywhere(&twice, line);
    // A disc of the same radius beside the bar touches it from outside.
    let mut beside = chain(&[(-1.0, 0.0), (1.0, 0.0), (0.25, 0.2)], radius);
    beside.bars.truncate(1);
    check_everywhere(&beside, (line.0 + 2.0 * PI * radius, 3, 2));
}

/// The stem of a T ends on the axis of its bar, or its end disc is flush with the far side.
#[test]
fn the_stem_of_a_t_meets_its_bar() {
    let radius = 0.1;
    for (foot, outer) in [(0.0, 3.8), (-0.1, 3.8), (0.1, 3.8)] {
        let mut tee = chain(&[(-1.0, 0.0), (1.0, 0.0), (0.0, foot), (0.0, 1.0)], radius);
        tee.bars.remove(1);
        let stem = 2.0 * (1.0 - radius);
        let bulge = if foot < 0.0 {
            PI * radius - 2.0 * radius
        } else {
            0.0
        };
        let arcs = if foot < 0.0 { 4 } else { 3 };
        let sides = if foot < 0.0 { 6 } else { 5 };
        check_everywhere(
            &tee,
            (outer + stem + 3.0 * PI * radius + bulge, arcs, sides),
        );
    }
}

#[test]
fn a_disc_in_a_ring_is_exposed_unless_the_ring_is_filled() {
    let ring = hollow(&SQUARE, 0.1);
    let (bare, arcs, sides) = measures(&ring);
    // Apart from the ring, and in touch with two of its bars.
    for place in [0.0, 0.2] {
        let mut island = ring.clone();
        island.circles.push((DVec2::splat(place), 0.2));
        check_everywhere(&island, (bare + 0.4 * PI, arcs + 1, sides));
        island.rings.push(vec![0, 1, 2, 3]);
        check_everywhere(&island, measures(&solid(&SQUARE, 0.1)));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, ..ProptestConfig::default() })]

    #[test]
    fn the_boundary_of_random_unions_is_closed_and_exposed(union in unions()) {
        check(&union, 1e-12);
    }

    #[test]
    fn the_boundary_of_polygons_is_closed_and_exposed(polygon in polygons()) {
        check(&polygon, 1e-13);
    }

    #[test]
    fn thin_parts_have_a_closed_boundary_too(union in unions(), thin in 1e-9..1e-3f64) {
        let thinner = Union {
            bars: union.bars.iter().map(|bar| Bar { radius: thin * bar.radius, ..*bar }).collect(),
            ..union
        };
        check(&thinner, 1e-12);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, ..ProptestConfig::default() })]

    #[test]
    fn parts_that_coincide_leave_no_gap(union in lattice_unions(), angle in 0.0..6.3f64) {
        let area = |union: &Union| boundary(union).iter().map(|piece| piece.curve.swept_area()).sum::<f64>();
        let expected = area(&union);
        for shift in [DVec2::ZERO, DVec2::new(0.3, -7.1)] {
            let placed = union.placed(angle, shift);
            let open: DVec2 = boundary(&placed).iter().map(|piece| {
                let [start, end] = piece.curve.ends();
                end - start
            }).sum();
            prop_assert!(open.length() < 1e-12, "open by {open}");
            prop_assert!((area(&placed) - expected).abs() < 1e-12, "{}", area(&placed) - expected);
        }
    }
}
