//! Tests of the integrals over bodies of discs, bars and filled rings against closed forms, parry,
//! and sums over lattice points.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use parry2d_f64::{mass_properties::MassProperties, math::Pose};
use proptest::prelude::*;

use super::*;
use crate::{
    covered_area::covered_area,
    union::samples::{
        SQUARE, chain, dumbbell, ell, hollow, plus, polygons, regular, solid, star, unions,
    },
};

fn assert_close(found: f64, expected: f64) {
    assert!(
        (found - expected).abs() <= 2e-14 * expected.abs(),
        "{found} is not {expected}"
    );
}

/// Area, first and second moment about the origin.
#[derive(Default)]
struct Sum(f64, DVec2, f64);

impl Sum {
    fn add(&mut self, part: &MassProperties) {
        let (mass, centre) = (part.mass(), part.local_com);
        self.0 += mass;
        self.1 += mass * centre;
        self.2 += part.principal_inertia() + mass * centre.length_squared();
    }

    /// Adds the sector of a disc between two directions (radians).
    fn add_sector(&mut self, centre: DVec2, radius: f64, [from, to]: [f64; 2]) {
        let area = 0.5 * radius * radius * (to - from);
        let third = radius.powi(3) / 3.0;
        let chord = DVec2::new(to.sin() - from.sin(), from.cos() - to.cos());
        let about_centre = third * chord;
        self.0 += area;
        self.1 += area * centre + about_centre;
        self.2 += area * centre.length_squared()
            + 2.0 * centre.dot(about_centre)
            + 0.5 * radius * radius * area;
    }
}

/// A rounded convex polygon from parry's polygon and rectangles, and the sectors at its corners.
fn rounded(points: &[(f64, f64)], radius: f64) -> Sum {
    let points: Vec<DVec2> = points.iter().map(|&(x, y)| DVec2::new(x, y)).collect();
    let mut sum = Sum::default();
    sum.add(&MassProperties::from_convex_polygon(1.0, &points));
    for (index, &point) in points.iter().enumerate() {
        let next = points[(index + 1) % points.len()];
        let before = points[(index + points.len() - 1) % points.len()];
        let side = next - point;
        let normal = -side.perp().normalize();
        let half = DVec2::new(0.5 * side.length(), 0.5 * radius);
        let place = Pose::new(
            point.midpoint(next) + 0.5 * radius * normal,
            side.to_angle(),
        );
        sum.add(&MassProperties::from_cuboid(1.0, half).transform_by(&place));
        let from = (point - before).to_angle() - FRAC_PI_2;
        let bend = (point - before).angle_to(side);
        sum.add_sector(point, radius, [from, from + bend]);
    }
    sum
}

#[test]
fn rounded_convex_polygons_agree_with_the_sums_of_their_parts() {
    for corners in [3, 4, 5, 7, 12, 64, 256] {
        for radius in [1e-9, 1e-6, 1e-3, 0.1, 1.0] {
            let points = regular(corners);
            let body = solid(&points, radius).placed(0.3, DVec2::new(0.2, -0.7));
            let placed: Vec<_> = body.circles.iter().map(|(at, _)| (at.x, at.y)).collect();
            let found = Properties::new(&body);
            let side = 2.0 * (PI / corners as f64).sin();
            let (perimeter, inner) = (
                corners as f64 * side,
                0.5 * corners as f64 * (TAU / corners as f64).sin(),
            );
            assert_close(
                found.area,
                inner + perimeter * radius + PI * radius * radius,
            );
            assert_close(found.perimeter, perimeter + TAU * radius);
            let Sum(area, first, second) = rounded(&placed, radius);
            assert_close(found.area, area);
            assert!((found.first_moment - first).length() < 2e-14 * area);
            assert_close(found.second_moment, second);
            let expected = DVec2::new(0.2, -0.7);
            assert!((found.centroid() - expected).length() < 2e-14);
        }
    }
}

/// I = m_b (L² + 4ρ²)/12 + m_c (ρ²/2 + L²/4 + 4 L ρ/3π) about the centre. The term of the half
/// discs is 3 L ρ/8 in parry, as for half balls, so only its mass and centre are compared.
#[test]
fn capsules_have_their_moment_of_inertia() {
    for (length, radius) in [(2.0, 0.5), (1.0, 1e-9), (1e-3, 0.7), (300.0, 0.2)] {
        let body = chain(&[(-0.5 * length, 0.0), (0.5 * length, 0.0)], radius);
        let found = Properties::new(&body);
        let (bar, caps) = (2.0 * length * radius, PI * radius * radius);
        assert_close(found.area, bar + caps);
        assert_close(found.perimeter, 2.0 * length + TAU * radius);
        let expected = bar * (length * length + 4.0 * radius * radius) / 12.0
            + caps
                * (0.5 * radius * radius
                    + 0.25 * length * length
                    + 4.0 * length * radius / (3.0 * PI));
        assert_close(found.second_moment, expected);
        let [a, b] = [body.circles[0].0, body.circles[1].0];
        let oracle = MassProperties::from_capsule(1.0, a, b, radius);
        assert_close(found.area, oracle.mass());
        assert!((found.centroid() - oracle.local_com).length() < 1e-14 * (length + radius));
    }
}

#[test]
fn concave_bodies_have_their_area_and_perimeter() {
    for radius in [1e-9, 1e-6, 0.01, 0.3] {
        let (caps, squared) = (PI * radius * radius, radius * radius);
        // The bars of the L overlap in a square at its notch.
        let found = Properties::new(&ell(radius));
        assert_close(found.area, 3.0 + 8.0 * radius + 1.25 * caps - squared);
        assert_close(found.perimeter, 8.0 - 2.0 * radius + 2.5 * PI * radius);
        let found = Properties::new(&plus(radius));
        assert_close(found.area, 8.0 * radius + 2.0 * caps - 4.0 * squared);
        // A hollow square is that of its outside less that of its inside.
        let found = Properties::new(&hollow(&SQUARE, radius));
        let inside = (1.0 - 2.0 * radius).powi(2);
        let outside = 1.0 + 4.0 * radius + caps;
        assert!((found.area - (outside - inside)).abs() < 1e-15);
        // Half of each disc of a dumbbell and the bar share a strip and a circular segment.
        let found = Properties::new(&dumbbell(radius));
        let shared = radius * (1.0 - squared).sqrt() + radius.asin();
        assert_close(found.area, TAU + 8.0 * radius - 2.0 * shared);
    }
}

/// A star is its triangles about the centre. Its sides end in the notches.
#[test]
fn a_thin_star_has_the_moments_of_its_triangles() {
    let points = star(5, 0.4);
    let body = solid(&points, 1e-9);
    let mut sum = Sum::default();
    for (index, &(x, y)) in points.iter().enumerate() {
        let (u, v) = points[(index + 1) % points.len()];
        let corners = [DVec2::ZERO, DVec2::new(x, y), DVec2::new(u, v)];
        // parry's `from_triangle` takes the moment about the first corner for that about the
        // centre.
        sum.add(&MassProperties::from_convex_polygon(1.0, &corners));
    }
    let found = Properties::new(&body);
    // The rim of 10⁻⁹ adds its length times that.
    let rim = 1e-9 * found.perimeter;
    assert!((found.area - rim - sum.0).abs() < 1e-14);
    assert!((found.second_moment - sum.2).abs() < 1.1 * rim);
    assert!(found.centroid().length() < 1e-15);
}

/// The properties of a body do not depend on its place: A and ∮ ds are the same, and the second
/// moment follows the parallel-axis theorem.
#[test]
fn moved_bodies_keep_their_properties() {
    for body in [
        ell(1e-9),
        ell(0.2),
        plus(0.1),
        dumbbell(0.01),
        solid(&star(7, 0.3), 1e-6),
        hollow(&star(7, 0.9), 0.02),
    ] {
        let still = Properties::new(&body);
        for step in 0..50 {
            let angle = 0.25 * f64::from(step) * FRAC_PI_2;
            let shift = 0.1 * f64::from(step % 9) * DVec2::new(1.0, -2.0);
            let moved = Properties::new(&body.placed(angle, shift));
            let scale = still.perimeter * (1.0 + shift.length_squared());
            assert!((moved.area - still.area).abs() < 1e-14 * scale);
            assert!((moved.perimeter - still.perimeter).abs() < 1e-13 * scale);
            let turned = DVec2::from_angle(angle).rotate(still.first_moment);
            assert!((moved.first_moment - turned - still.area * shift).length() < 1e-14 * scale);
            let expected =
                still.second_moment + 2.0 * shift.dot(turned) + still.area * shift.length_squared();
            assert!((moved.second_moment - expected).abs() < 4e-14 * scale);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, ..ProptestConfig::default() })]

    /// Without bars and rings the area is that of the discs, to the bit.
    #[test]
    fn the_area_of_discs_is_the_covered_area(union in unions()) {
        let discs = Union::of_discs(union.circles);
        prop_assert_eq!(Properties::new(&discs).area, covered_area(&discs.circles));
    }

    /// The rim of a filled polygon adds about its length times the radius of its edges.
    #[test]
    fn thin_rims_add_little_to_the_area_of_their_polygon(polygon in polygons()) {
        prop_assume!(!polygon.rings.is_empty());
        let count = polygon.circles.len();
        let corner = |index: usize| polygon.circles[index % count].0;
        let inner: f64 = (0..count).map(|index| 0.5 * corner(index).perp_dot(corner(index + 1))).sum();
        let found = Properties::new(&polygon);
        let radius = polygon.bars[0].radius;
        let rim = (found.area - inner) / (radius * found.perimeter);
        // Discs at the corners add at most 4π times the square of that radius each.
        let corners = 4.0 * PI * radius * count as f64 / found.perimeter;
        prop_assert!((rim - 1.0).abs() < corners + 2e-15 / radius, "{rim}");
    }

    /// Sums over the points of a lattice.
    #[test]
    fn integrals_are_sums_over_the_body(union in unions()) {
        let found = Properties::new(&union);
        let (half, side) = (union.reach(), 240);
        let step = 2.0 * half / f64::from(side);
        let (mut area, mut first, mut second) = (0.0, DVec2::ZERO, 0.0);
        let place = |index: i32| (f64::from(index) + 0.5) * step - half;
        for x in (0..side).map(place) {
            for point in (0..side).map(|row| DVec2::new(x, place(row))) {
                if union.holds(point) {
                    area += step * step;
                    first += step * step * point;
                    second += step * step * point.length_squared();
                }
            }
        }
        // Errors of one row of cells along the boundary add up as a random walk.
        let error = 3.0 * step * step * (found.perimeter / step).sqrt();
        prop_assert!((found.area - area).abs() < error, "{} {area}", found.area);
        prop_assert!((found.first_moment - first).length() < error * half);
        prop_assert!((found.second_moment - second).abs() < error * half * half);
    }
}
