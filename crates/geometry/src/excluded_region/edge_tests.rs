//! Tests of excluded regions of bodies with edges against closed forms and lattice counts.

use proptest::prelude::*;

use super::*;
use crate::{
    BoundaryPart, EdgeSide,
    union::samples::{
        SQUARE, chain, dumbbell, ell, hollow, lattice_unions, regular, solid, unions,
    },
};

fn close(found: f64, expected: f64) {
    assert!(
        (found - expected).abs() < 4e-14 * expected.abs().max(1.0),
        "{found} is not {expected}"
    );
}

/// The excluded region of a square of side 1 is a square with corners rounded by s = ρ + r.
#[test]
fn a_square_is_hit_on_its_sides_and_corners() {
    for (rounding, probe) in [(1e-9, 0.0), (1e-9, 0.25), (0.1, 0.4), (1e-6, 30.0)] {
        let s = rounding + probe;
        let square = ExcludedRegion::of_union(&solid(&SQUARE, rounding), probe);
        let (perimeter, area) = (4.0 + TAU * s, 1.0 + 4.0 * s + PI * s * s);
        close(square.perimeter() / perimeter, 1.0);
        close(square.area() / area, 1.0);
        close(
            square.mean_free_path(1e4) * perimeter / (PI * (1e4 - area)),
            1.0,
        );
        for edge in square.edge_shares() {
            close(edge, 1.0 / perimeter);
        }
        for atom in square.atom_shares() {
            close(atom, 0.25 * TAU * s / perimeter);
        }
        assert_eq!((square.arcs().len(), square.sides().len()), (4, 4));
        assert!(!square.has_pockets() && square.pocket_area() == 0.0);
        assert!(square.contains(DVec2::ZERO) && square.contains(DVec2::new(0.3, -0.49)));
        assert!(!square.contains(DVec2::new(0.3, -0.501 - s)));
    }
}

/// The impulse on a side has one direction, also where that is the limit of two sectors.
#[test]
fn each_side_is_a_peak_in_one_direction() {
    let (rounding, probe) = (1e-9, 0.25);
    let body = solid(&SQUARE, rounding);
    let perimeter = 4.0 + TAU * (rounding + probe);
    let peak = 1.0 / perimeter;
    for sectors in [4, 8, 360, 1000] {
        let background = (1.0 - 4.0 * peak) / f64::from(sectors);
        let place = |degrees: f64| (degrees / 360.0 * f64::from(sectors)).round() as usize;
        let shares = ExcludedRegion::of_union(&body, probe).direction_shares(sectors as usize);
        // Edge 0 is the lower side, so its impulse points up.
        for peaked in [90.0, 180.0, 270.0, 0.0].map(place) {
            close(shares[peaked], peak + background);
        }
        let flat = shares
            .iter()
            .filter(|share| **share < 0.5 * peak + background);
        assert_eq!(flat.count(), sectors as usize - 4);
        close(shares.iter().sum(), 1.0);
    }
    // Turned by 20.5°, the middle of a sector of one degree.
    let turned = body.placed(20.5f64.to_radians(), DVec2::ZERO);
    let shares = ExcludedRegion::of_union(&turned, probe).direction_shares(360);
    for peaked in [20, 110, 200, 290] {
        close(shares[peaked], peak + (1.0 - 4.0 * peak) / 360.0);
    }
    assert!(
        ExcludedRegion::of_union(&body, probe)
            .direction_shares(0)
            .is_empty()
    );
}

#[test]
fn a_side_reports_its_edge_and_its_normal() {
    let capsule = ExcludedRegion::of_union(&chain(&[(-1.0, 0.0), (1.0, 0.0)], 0.1), 0.4);
    let [right, left] = capsule.sides() else {
        panic!("a capsule has two sides");
    };
    assert_eq!((right.side, left.side), (EdgeSide::Right, EdgeSide::Left));
    assert_eq!((right.edge, left.edge), (0, 0));
    close(right.normal, 1.5 * PI);
    close(left.normal, 0.5 * PI);
    assert_eq!(right.start, DVec2::new(-1.0, -0.5));
    assert_eq!(left.start, DVec2::new(1.0, 0.5));
    let contact = left.contact(0.25);
    assert_eq!(contact.part, BoundaryPart::Edge(0));
    assert!((contact.position() - DVec2::new(0.5, 0.5)).length() < 1e-15);
    close(contact.lever(), 0.5);
    close(capsule.perimeter(), 4.0 + PI);
    close(capsule.area(), 2.0 + 0.25 * PI);
    close(capsule.edge_shares()[0], 4.0 / (4.0 + PI));
    close(capsule.exposed_angle(0), PI);
    // The sides do not count: from above, no atom has its normal there alone.
    assert_eq!(capsule.exposure(1.0), 1);
}

/// ∮ (r × n)² ds of a square: a³/12 for each side, and |c|² (π/4 − ½) s for each corner c.
#[test]
fn lever_arms_vary_along_the_sides() {
    let (rounding, probe) = (0.01, 0.3);
    let square = ExcludedRegion::of_union(&solid(&SQUARE, rounding), probe);
    let squared = |contact: &BoundaryPoint| contact.lever().powi(2);
    let corners = 4.0 * 0.5 * (0.25 * PI - 0.5) * (rounding + probe);
    close(square.integral(squared), 4.0 / 12.0 + corners);
    close(square.by_edge(squared)[2], 1.0 / 12.0);
    close(square.by_atom(squared)[1], 0.25 * corners);
}

#[test]
fn a_triangle_turns_by_a_third_at_each_corner() {
    let triangle = ExcludedRegion::of_union(&solid(&regular(3), 1e-6), 0.5);
    let (side, s) = (3f64.sqrt(), 0.5 + 1e-6);
    close(triangle.perimeter(), 3.0 * side + TAU * s);
    close(triangle.area(), 0.75 * side + 3.0 * side * s + PI * s * s);
    for atom in 0..3 {
        close(triangle.exposed_angle(atom), TAU / 3.0);
    }
}

/// The probe cannot touch the notch of an L of arms of length 1 at (1, 1), nor the arms within s of
/// it. From s = 1 on it touches only their ends, with circles at distance √2.
#[test]
fn the_notch_of_an_l_is_out_of_reach() {
    let small = ExcludedRegion::of_union(&ell(0.1), 0.4);
    assert_eq!(small.unreachable(), [3]);
    close(small.perimeter(), 8.0 - 1.0 + 2.5 * PI * 0.5);
    close(small.area(), 3.0 + 4.0 + (1.25 * PI - 1.0) * 0.25);
    let edges = small.by_edge(|_| 1.0);
    close(edges[2], 0.5);
    close(edges[3], 0.5);
    let large = ExcludedRegion::of_union(&ell(0.1), 1.4);
    assert_eq!(large.unreachable(), [3]);
    assert_eq!((large.arcs().len(), large.sides().len()), (5, 4));
    let lost = (0.5f64.sqrt() / 1.5).acos();
    let arcs = 1.5 * PI + 2.0 * (0.75 * PI - lost);
    close(large.perimeter(), 6.0 + 1.5 * arcs);
    // Between the corners (2, 1) and (1, 2): their triangle with the notch, their sectors beyond
    // the straight arms, and the triangle up to the crossing of the circles.
    let beyond = 0.5 + 0.5f64.sqrt() * (2.25f64 - 0.5).sqrt();
    close(large.area(), 3.0 + 6.0 * 1.5 + beyond + 0.5 * 2.25 * arcs);
    assert!(large.contains(DVec2::splat(1.9)) && !large.contains(DVec2::splat(2.5)));
}

/// A hollow hexagon of side 1 is closed; inside it a probe has a hexagon of apothem √3/2 − s.
#[test]
fn a_hollow_ring_has_a_pocket() {
    let ring = hollow(&regular(6), 0.05);
    let (s, apothem) = (0.25, 0.75f64.sqrt() - 0.25);
    let region = ExcludedRegion::of_union(&ring, 0.2);
    close(region.perimeter(), 6.0 + TAU * s);
    close(region.area(), 1.5 * 3f64.sqrt() + 6.0 * s + PI * s * s);
    close(region.pocket_area(), 12f64.sqrt() * apothem * apothem);
    let inside: f64 = region.hidden_sides().iter().map(ExposedSide::length).sum();
    close(inside, 12.0 * apothem / 3f64.sqrt());
    assert!(region.has_pockets() && region.hidden_arcs().is_empty());
    assert_eq!(region.sides().len(), 6);
    assert!(region.contains(DVec2::ZERO));
    // A probe too large for the hole, and a filled ring.
    assert!(!ExcludedRegion::of_union(&ring, 0.9).has_pockets());
    let filled = ExcludedRegion::of_union(&solid(&regular(6), 0.05), 0.2);
    assert!(!filled.has_pockets() && filled.pocket_area() == 0.0);
    assert_eq!(
        (filled.arcs(), filled.sides()),
        (region.arcs(), region.sides())
    );
    // A disc inside is out of reach.
    let mut island = ring.clone();
    island.circles.push((DVec2::new(0.1, 0.0), 0.1));
    let island = ExcludedRegion::of_union(&island, 0.2);
    assert_eq!(island.unreachable(), [6]);
    close(island.perimeter(), region.perimeter());
    close(island.pocket_area(), region.pocket_area() - PI * 0.09);
}

/// A probe too large to touch a thin bar between large discs sees the discs alone.
#[test]
fn a_thin_bar_may_be_out_of_reach() {
    let thin = dumbbell(0.1);
    let near = ExcludedRegion::of_union(&thin, 0.5);
    let chord = (1.5f64 * 1.5 - 0.6 * 0.6).sqrt();
    close(near.by_edge(|_| 1.0)[0], 2.0 * (4.0 - 2.0 * chord));
    let far = ExcludedRegion::of_union(&thin, 2.0);
    let discs = ExcludedRegion::of_union(&Union::of_discs(thin.circles), 2.0);
    assert!(far.sides().is_empty() && far.edge_shares() == [0.0]);
    close(far.perimeter(), discs.perimeter());
    close(far.area(), discs.area());
}

/// At radius 0, B₂ = A + P²/4π of equal convex bodies; of discs it is half their excluded area
/// π (2R)².
#[test]
fn the_bare_perimeter_gives_the_second_virial_coefficient() {
    let b2 = |body: &Union| {
        let bare = ExcludedRegion::of_union(body, 0.0);
        bare.area() + bare.perimeter().powi(2) / (4.0 * PI)
    };
    close(b2(&Union::of_discs(vec![(DVec2::ZERO, 0.7)])), TAU * 0.49);
    // Needles of length L: L²/π.
    let needle = b2(&chain(&[(0.0, 0.0), (1.0, 0.0)], 1e-9));
    assert!((needle - 1.0 / PI).abs() < 1e-8);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, ..ProptestConfig::default() })]

    /// The numbers of lattice points in the body, and of those in the region, must agree with the
    /// areas.
    #[test]
    fn areas_are_those_of_counted_points(body in unions(), probe in 0.0..0.5f64) {
        let region = ExcludedRegion::of_union(&body, probe);
        let inflated = body.inflated(probe);
        let (half, side) = (inflated.reach(), 200);
        let step = 2.0 * half / f64::from(side);
        let (mut covered, mut filled) = (0, 0);
        let at = |index: i32| (f64::from(index) + 0.5) * step - half;
        for place in 0..side * side {
            let point = DVec2::new(at(place % side), at(place / side));
            let (is_covered, is_filled) = (inflated.holds(point), region.contains(point));
            prop_assert!(is_filled || !is_covered);
            covered += u32::from(is_covered);
            filled += u32::from(is_filled);
        }
        // Errors of one row of cells along the boundary add up as a random walk.
        let hidden = curves(region.hidden_arcs(), region.hidden_sides());
        let length = region.perimeter() + hidden.map(|curve| curve.length()).sum::<f64>();
        let error = 3.0 * step * step * (length / step).sqrt();
        let free = region.pocket_area();
        prop_assert!((f64::from(covered) * step * step - (region.area() - free)).abs() < error);
        prop_assert!((f64::from(filled) * step * step - region.area()).abs() < error);
    }

    /// An ideal gas neither pushes nor turns a body: ∮ n ds = 0 and ∮ r × n ds = 0.
    #[test]
    fn the_mean_force_and_torque_vanish(body in unions(), probe in 0.0..0.5f64) {
        let region = ExcludedRegion::of_union(&body, probe);
        let normal = |contact: &BoundaryPoint| DVec2::from_angle(contact.normal);
        prop_assert!(region.integral(|contact| normal(contact).x).abs() < 1e-11);
        prop_assert!(region.integral(|contact| normal(contact).y).abs() < 1e-11);
        prop_assert!(region.integral(BoundaryPoint::lever).abs() < 1e-11);
        let parts: f64 = region.atom_shares().iter().chain(&region.edge_shares()).sum();
        prop_assert!((parts - 1.0).abs() < 1e-13);
        prop_assert!((region.direction_shares(7).iter().sum::<f64>() - 1.0).abs() < 1e-13);
        prop_assert!((region.integral(|_| 1.0) / region.perimeter() - 1.0).abs() < 1e-13);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, ..ProptestConfig::default() })]

    /// Where many lines coincide or meet in one point, rounding must not decide what is outside.
    #[test]
    fn coincident_lines_are_linked_in_every_orientation(
        body in lattice_unions(),
        probe in prop::sample::select(vec![0.0, 0.1, 0.25, 0.5]),
        angle in 0.0..6.3f64,
    ) {
        let still = ExcludedRegion::of_union(&body, probe);
        let turned = ExcludedRegion::of_union(&body.placed(angle, DVec2::new(0.3, -2.1)), probe);
        prop_assert!((still.perimeter() - turned.perimeter()).abs() < 1e-12);
        prop_assert!((still.area() - turned.area()).abs() < 1e-12);
        prop_assert!((still.pocket_area() - turned.pocket_area()).abs() < 1e-12);
    }
}
