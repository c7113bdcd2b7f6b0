//! Tests of excluded regions against closed forms, lattice counts, and the derivative of the area.

use proptest::prelude::*;

use super::*;
use crate::{Atom, Shape};

fn region(shape: Shape, atom_radius: f64, radius: f64) -> ExcludedRegion {
    ExcludedRegion::new(&Molecule::named(shape, atom_radius, 2.0).unwrap(), radius).unwrap()
}

fn discs(discs: &[(f64, f64, f64)]) -> Result<Molecule, GeometryError> {
    Molecule::new(
        discs
            .iter()
            .map(|&(x, y, radius)| Atom::new(DVec2::new(x, y), radius, 1.0).unwrap()),
    )
}

fn close(found: f64, expected: f64) {
    assert!(
        (found - expected).abs() < 1e-9 * expected.abs().max(1.0),
        "{found} is not {expected}"
    );
}

#[test]
fn a_lone_disc_is_exposed_all_round() {
    let disc = region(Shape::Disc, 0.3, 0.2);
    close(disc.perimeter(), TAU * 0.5);
    close(disc.area(), PI * 0.25);
    // Sinai's billiard: (L² − π s²) / 2s.
    close(disc.mean_free_path(4.0), 4.0 - PI * 0.25);
    assert_eq!(disc.exposure(1.0), 1);
    assert!(disc.unreachable().is_empty() && disc.hidden_arcs().is_empty());
    assert!(disc.contains(DVec2::new(0.0, 0.49)) && !disc.contains(DVec2::new(0.0, 0.51)));
}

/// Two circles of radius s at distance d: each loses an angle of 2 acos(d / 2s), and the lens
/// counts once.
#[test]
fn a_dumbbell_loses_where_its_circles_overlap() {
    let dumbbell = region(Shape::Dumbbell, 0.5, 0.5);
    let lost = 2.0 * 0.5f64.acos();
    close(dumbbell.exposed_angle(0), TAU - lost);
    close(dumbbell.exposed_angle(1), TAU - lost);
    close(dumbbell.perimeter(), 2.0 * (TAU - lost));
    // Lens of two unit circles at distance 1.
    close(dumbbell.area(), TAU - (lost - lost.sin()));
    close(dumbbell.atom_shares()[0], 0.5);
}

/// Closed forms from the triangles of three touching circles; s = 3a.
#[test]
fn tee_of_relative_size_one_half() {
    let tee = region(Shape::Tee, 0.005, 0.01);
    let (third, root) = ((1.0f64 / 3.0).acos(), (2.0f64.sqrt() / 3.0).acos());
    let a = 1.75 * PI - root - third;
    let d = 2.0 * (0.5 * PI - third + 0.25 * PI - root);
    let expected = [a, PI - 2.0 * third, a, d, PI + 2.0 * (0.5 * PI - third)];
    for (atom, angle) in expected.into_iter().enumerate() {
        close(tee.exposed_angle(atom), angle);
        close(
            tee.atom_shares()[atom],
            angle / expected.iter().sum::<f64>(),
        );
    }
    assert!((tee.exposed_angle(0).to_degrees() - 182.5967).abs() < 1e-4);
    assert!((tee.exposed_angle(3).to_degrees() - 5.1935).abs() < 1e-4);
    assert!((tee.perimeter() - 0.164_481_17).abs() < 1e-8);
    assert!((tee.area() - 0.001_803_53).abs() < 1e-8);
    assert!(tee.unreachable().is_empty());
    // Levels between the steps at 19.471°, 70.529°, 109.471°, 160.529°, 196.875°, 199.471°,
    // 253.126°, …
    let levels = [
        (10.0, 2),
        (45.0, 1),
        (90.0, 3),
        (135.0, 1),
        (180.0, 2),
        (198.0, 3),
        (225.0, 2),
        (270.0, 1),
        (315.0, 2),
        (342.0, 3),
        (350.0, 2),
    ];
    for (degrees, count) in levels {
        assert_eq!(tee.exposure(f64::to_radians(degrees)), count, "{degrees}°");
    }
}

/// s = 5a: the inner corner is too narrow for the probe to touch the middle of the stem.
#[test]
fn tee_of_relative_size_one_quarter() {
    let tee = region(Shape::Tee, 0.0025, 0.01);
    let a = PI + 0.6f64.acos() - 0.2f64.acos();
    for (atom, angle) in [a, PI - 2.0 * 0.2f64.acos(), a, 0.0, PI]
        .into_iter()
        .enumerate()
    {
        close(tee.exposed_angle(atom), angle);
    }
    assert!((tee.perimeter() - 0.111_790_09).abs() < 1e-8);
    assert!((tee.area() - 0.000_934_93).abs() < 1e-8);
    assert_eq!(tee.unreachable(), [3]);
    assert!(tee.hidden_arcs().is_empty());
    for (degrees, count) in [
        (40.0, 1),
        (90.0, 3),
        (140.0, 1),
        (200.0, 2),
        (270.0, 1),
        (330.0, 2),
    ] {
        assert_eq!(tee.exposure(f64::to_radians(degrees)), count, "{degrees}°");
    }
}

/// Twelve touching atoms of radius ½ and a probe of radius 0.2: the neighbours of an atom lie at
/// π/2 + π/12 on either side of its outward direction and cover acos(½ / 0.7) around that.
#[test]
fn a_ring_has_a_pocket_that_nothing_reaches() {
    let ring = region(Shape::Ring(12), 0.5, 0.2);
    let (reach, covered) = (0.7, (0.5f64 / 0.7).acos());
    let (outer, inner) = (PI + PI / 6.0 - 2.0 * covered, PI - PI / 6.0 - 2.0 * covered);
    close(ring.perimeter(), 12.0 * reach * outer);
    close(
        ring.hidden_arcs().iter().map(ExposedArc::length).sum(),
        12.0 * reach * inner,
    );
    // The polygon of the centres plus, for each atom, its outer sector and two triangles; inside,
    // less these.
    let polygon = 12.0 * 0.25 / (PI / 12.0).tan();
    let beyond = |angle: f64| 12.0 * (0.5 * reach * reach * angle + 0.5 * reach * covered.sin());
    close(ring.area(), polygon + beyond(outer));
    close(ring.pocket_area(), polygon - beyond(inner));
    assert!(ring.contains(DVec2::ZERO) && !ring.contains(DVec2::new(3.2, 0.0)));
    assert!(ring.unreachable().is_empty(), "every atom has its outside");
    // A probe too large for the hole.
    let filled = region(Shape::Ring(12), 0.5, 1.5);
    assert!(filled.hidden_arcs().is_empty() && filled.pocket_area() == 0.0);
}

/// A disc in the centre of a ring that it does not touch lies in the pocket, and cannot be reached.
#[test]
fn an_island_in_a_pocket_is_unreachable() {
    let mut atoms = Shape::Ring(12).atoms(0.5, 1.0).unwrap();
    atoms.push(Atom::new(DVec2::ZERO, 0.3, 1.0).unwrap());
    let island = ExcludedRegion::new(&Molecule::new(atoms).unwrap(), 0.2).unwrap();
    let ring = region(Shape::Ring(12), 0.5, 0.2);
    assert_eq!(island.unreachable(), [12]);
    close(island.perimeter(), ring.perimeter());
    close(island.area(), ring.area());
    close(island.pocket_area(), ring.pocket_area() - PI * 0.25);
    assert!(island.contains(DVec2::ZERO) && island.contains(DVec2::new(0.6, 0.0)));
}

#[test]
fn parts_that_stand_apart_are_all_reached() {
    let apart =
        ExcludedRegion::new(&discs(&[(0.0, 0.0, 0.5), (5.0, 0.0, 1.0)]).unwrap(), 0.25).unwrap();
    close(apart.perimeter(), TAU * 2.0);
    close(apart.area(), PI * (0.75 * 0.75 + 1.25 * 1.25));
    assert!(!apart.contains(DVec2::ZERO));
}

#[test]
fn an_atom_inside_another_is_unreachable() {
    let region =
        ExcludedRegion::new(&discs(&[(0.0, 0.0, 1.0), (0.3, 0.0, 0.1)]).unwrap(), 0.5).unwrap();
    assert_eq!(region.unreachable(), [1]);
}

/// On a circle, the arc that one neighbour covers across direction 0 contains the arc of another
/// one just before 0.
#[test]
fn a_cover_that_goes_round_counts_at_the_beginning_too() {
    let region = ExcludedRegion::new(
        &discs(&[(0.0, 0.0, 1.0), (1.0, 0.0, 1.5), (0.9, 0.2, 0.2)]).unwrap(),
        0.0,
    );
    let alone = ExcludedRegion::new(&discs(&[(0.0, 0.0, 1.0), (1.0, 0.0, 1.5)]).unwrap(), 0.0);
    close(region.unwrap().perimeter(), alone.unwrap().perimeter());
}

#[test]
fn walls_and_impossible_probes_are_refused() {
    let wall = Molecule::wall(DVec2::X, 0.1).unwrap();
    assert_eq!(ExcludedRegion::new(&wall, 0.1), Err(GeometryError::Wall));
    for radius in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(ExcludedRegion::new(&Molecule::disc(1.0, 1.0).unwrap(), radius).is_err());
    }
}

/// A free tee of mass 10 in an ideal gas of mass 1, kT = 1: rate and shares from an independent
/// quadrature with the moment of inertia of uniform discs.
#[test]
fn shares_of_contacts_of_a_free_tee() {
    let molecule = Molecule::named(Shape::Tee, 0.005, 2.0).unwrap();
    let inverse_moment = 1.0 / molecule.moment_of_inertia();
    let weight = |contact: &BoundaryPoint| {
        let lever = contact.lever();
        (1.0 + 0.1 + lever * lever * inverse_moment).sqrt()
    };
    let tee = region(Shape::Tee, 0.005, 0.01);
    let rate = tee.integral(weight) / TAU.sqrt();
    assert!((rate - 0.070_917_76).abs() < 1e-8, "{rate}");
    let shares: Vec<f64> = tee
        .by_atom(weight)
        .iter()
        .map(|part| part / tee.integral(weight))
        .collect();
    for (share, expected) in shares
        .iter()
        .zip([0.28947, 0.06018, 0.28947, 0.00807, 0.35280])
    {
        assert!((share - expected).abs() < 5e-6, "{shares:?}");
    }
}

#[test]
fn sectors_add_up_and_lie_opposite_to_the_normal() {
    let tee = region(Shape::Tee, 0.005, 0.01);
    let sectors = tee.by_impulse_direction(360, |_| 1.0);
    close(sectors.iter().sum::<f64>(), tee.perimeter());
    let level = 0.015 * 1f64.to_radians();
    // The flat top of the bar exposes three atoms; impulses there point down, to 270°.
    close(sectors[270] / level, 3.0);
    close(sectors[90] / level, 1.0);
    close(sectors[0] / level, 2.0);
    // Sectors without a step have a whole number of atoms.
    let whole = sectors
        .iter()
        .filter(|part| ((*part / level).round() - *part / level).abs() < 1e-9)
        .count();
    assert_eq!(whole, 360 - 10);
}

/// Area of the union of the discs themselves.
fn union_area(region: &ExcludedRegion) -> f64 {
    region.area() - region.pocket_area()
}

fn molecules() -> impl Strategy<Value = Molecule> {
    let disc = (-2.0..2.0, -2.0..2.0, 0.1..0.8);
    prop::collection::vec(disc, 1..12)
        .prop_filter_map("two atoms in one place", |list| discs(&list).ok())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    /// The numbers of lattice points in the discs, and of those in the region, must agree with the
    /// areas.
    #[test]
    fn areas_are_those_of_counted_points(molecule in molecules(), radius in 0.0..0.6f64) {
        let region = ExcludedRegion::new(&molecule, radius).unwrap();
        let (half, side) = (molecule.bounding_radius() + radius, 240);
        let step = 2.0 * half / f64::from(side);
        let (mut union, mut filled) = (0, 0);
        for place in 0..side * side {
            let at = |index: i32| (f64::from(index) + 0.5) * step - half;
            let point = DVec2::new(at(place % side), at(place / side));
            let near = |atom: &Atom| atom.offset().distance(point) < atom.radius() + radius;
            union += u32::from(molecule.atoms().iter().any(near));
            filled += u32::from(region.contains(point));
        }
        // Errors of one row of cells along the boundary add up as a random walk.
        let length = region.perimeter() + region.hidden_arcs().iter().map(ExposedArc::length).sum::<f64>();
        let error = 3.0 * step * step * (length / step).sqrt();
        prop_assert!((f64::from(union) * step * step - union_area(&region)).abs() < error);
        prop_assert!((f64::from(filled) * step * step - region.area()).abs() < error);
    }

    /// A probe with a radius larger by dr excludes an area larger by P dr.
    #[test]
    fn the_perimeter_is_the_derivative_of_the_area(molecule in molecules(), radius in 0.01..0.6f64) {
        let at = |radius: f64| ExcludedRegion::new(&molecule, radius).unwrap();
        let step = 1e-6;
        let slope = (union_area(&at(radius + step)) - union_area(&at(radius - step))) / (2.0 * step);
        let region = at(radius);
        let length = region.perimeter() + region.hidden_arcs().iter().map(ExposedArc::length).sum::<f64>();
        // Circles that begin or cease to touch within the step change P by the square root of the
        // step.
        prop_assert!((slope / length - 1.0).abs() < 0.01, "{slope} {length}");
    }

    /// Closed lines have ∮ n ds = 0, outside and around pockets; and an arc is not inside any other
    /// disc.
    #[test]
    fn the_outline_is_closed_and_exposed(molecule in molecules(), radius in 0.0..0.6f64) {
        let region = ExcludedRegion::new(&molecule, radius).unwrap();
        for arcs in [region.arcs(), region.hidden_arcs()] {
            let sum: DVec2 = arcs.iter().map(|arc| {
                // ∫ n ds of an arc is its chord rotated by a quarter turn clockwise.
                -(arc.point(arc.end) - arc.point(arc.start)).perp()
            }).sum();
            prop_assert!(sum.length() < 1e-7, "{sum}");
            for arc in arcs {
                let middle = arc.point(0.5 * (arc.start + arc.end));
                for atom in molecule.atoms() {
                    prop_assert!(atom.offset().distance(middle) > atom.radius() + radius - 1e-12);
                }
            }
        }
        for probe in [-1.0, 0.3, 2.5f64] {
            let shares: f64 = region.direction_shares(7).iter().sum();
            prop_assert!((shares - 1.0).abs() < 1e-12);
            let far = DVec2::from_angle(probe) * (molecule.bounding_radius() + radius + 0.01);
            prop_assert!(!region.contains(far));
        }
    }
}

/// FNV-1a over the bits of the boundaries, areas and integrals of 300 unions of random discs.
///
/// Runs of earlier versions follow from these bits; the arithmetic of discs must not change.
#[test]
fn boundaries_of_discs_keep_their_bits() {
    let (mut state, mut digest) = (1u64, 0xcbf2_9ce4_8422_2325_u64);
    let mut random = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut add = |value: f64| {
        for byte in value.to_bits().to_le_bytes() {
            digest = (digest ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    };
    let weight = |contact: &BoundaryPoint| (1.0 + contact.lever().powi(2)).sqrt();
    for case in 0..300 {
        let list: Vec<_> = (0..=case % 12)
            .map(|_| (4.0 * random() - 2.0, 4.0 * random() - 2.0, 0.1 + random()))
            .collect();
        let molecule = discs(&list).unwrap();
        let region = ExcludedRegion::new(&molecule, 0.5 * random()).unwrap();
        for arc in region.arcs().iter().chain(region.hidden_arcs()) {
            add(arc.atom as f64);
            add(arc.start);
            add(arc.end);
        }
        add(molecule.area());
        for value in [region.area(), region.perimeter(), region.integral(weight)] {
            add(value);
        }
        for part in region
            .by_atom(weight)
            .into_iter()
            .chain(region.direction_shares(7))
            .chain(region.atom_shares())
        {
            add(part);
        }
        add(f64::from(u8::from(
            region.contains(DVec2::new(random(), random())),
        )));
    }
    assert_eq!(digest, 0xf7cd_4f0c_944b_e536);
}
