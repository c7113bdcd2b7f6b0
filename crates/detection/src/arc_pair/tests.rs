//! Contacts with arcs: known times, random bodies against their gap, and grazes.

use carom_geometry::{Atom, Bend, Molecule, Shape, gap_between};
use carom_kinematics::{Orientation, RelativeMotion};
use glam::DVec2;
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::{
    BoundingCircles, Contact, Detection, Exact, Part, Touch,
    first_zero::{Samples, is_first_zero},
    resolved_speed,
};

/// Arcs of any angle, circles, and cavities, of some thickness or none.
fn arcs() -> impl Strategy<Value = Molecule> {
    let angle = prop_oneof![3 => 0.1..6.2f64, 1 => Just(TAU), 1 => Just(PI)];
    (
        0.3..2.0f64,
        -4.0..4.0f64,
        angle,
        prop_oneof![Just(0.0), 0.0..0.1f64],
        any::<bool>(),
    )
        .prop_map(|(radius, from, angle, thickness, is_cavity)| {
            let bend = Bend::new(radius, [from, from + angle]).unwrap();
            // An open arc is passed from outside.
            let bend = if is_cavity && bend.is_circle() {
                bend.one_sided()
            } else {
                bend
            };
            Molecule::arc(bend, thickness).unwrap()
        })
}

fn molecules() -> impl Strategy<Value = Molecule> {
    let atom = (-0.3..0.3f64, -0.3..0.3f64, 0.01..0.2f64);
    prop::collection::vec(atom, 1..4).prop_map(|atoms| {
        let atom = |(n, (x, y, radius))| {
            // No two at one place.
            Atom::new(DVec2::new(x, y + 1e-3 * f64::from(n)), radius, 1.0).unwrap()
        };
        Molecule::new((0..).zip(atoms).map(atom)).unwrap()
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: ProptestConfig::default().cases.max(600), max_global_rejects: 1 << 20, ..ProptestConfig::default() })]

    /// Nothing overlaps before the contact, and at the contact the gap is 0 to rounding.
    #[test]
    fn molecules_touch_an_arc_first_where_their_gap_is_zero(
        arc in arcs(), molecule in molecules(), x in -2.5..2.5f64, y in -2.5..2.5f64,
        velocity in (-1.0..1.0f64, -1.0..1.0f64), turns in prop::array::uniform2(-0.5..0.5f64),
        spin in prop_oneof![Just(0.0), -1.0..1.0f64, -30.0..30.0f64, -1e3..1e3f64],
        spin_of_arc in prop_oneof![3 => Just(0.0), 1 => -2.0..2.0f64],
    ) {
        let spins = [spin, spin_of_arc];
        let motion = RelativeMotion {
            orientation: turns.map(Orientation::from_turns),
            angular_velocity: spins,
            ..RelativeMotion::exactly(DVec2::new(x, y), velocity.into())
        };
        let gap = |t: f64| {
            let [to_a, to_b] = [0, 1].map(|n| motion.orientation[n].turned(spins[n], t).cos_sin());
            gap_between(&molecule, to_a, &arc, to_b, motion.separation + motion.velocity * t)
        };
        prop_assume!(gap(0.0) > 1e-9);
        let bend = *arc.edges()[0].bend().unwrap();
        prop_assume!(!bend.is_one_sided() || x.hypot(y) < bend.radius() - molecule.bounding_radius());
        let answer = Exact::default().first_contact(molecule.outline(), arc.outline(), &motion, 10.0);
        // A fast rotor turns by roundings of its angle.
        let allowed = |_: f64| 1e-13 * (1.0 + spin.abs());
        let samples = Samples { count: 3000, depth: 1e-12 };
        is_first_zero(answer.outcome, 10.0, gap, allowed, &samples)?;
        let exchanged = Exact::default().first_contact(arc.outline(), molecule.outline(), &motion.exchanged(), 10.0);
        match (answer.outcome.contact(), exchanged.outcome.contact()) {
            (Some(one), Some(other)) => prop_assert_eq!((one.time, one.touch), (other.time, other.touch.exchanged())),
            (None, None) => {}
            (one, other) => prop_assert!(false, "{one:?} against {other:?}"),
        }
    }
}

fn contact(arc: &Molecule, disc: &Molecule, place: DVec2, velocity: DVec2) -> Option<Contact> {
    let motion = RelativeMotion::exactly(place, velocity);
    let detector = Exact::default();
    let answer = detector.first_contact(arc.outline(), disc.outline(), &motion, 100.0);
    answer.outcome.contact()
}

#[test]
fn a_disc_meets_the_inside_the_outside_and_the_ends_of_an_arc_at_the_expected_times() {
    let half = Bend::new(2.0, [-FRAC_PI_2, FRAC_PI_2]).unwrap();
    let arc = Molecule::arc(half, 0.25).unwrap();
    let disc = Molecule::disc(0.25, 1.0).unwrap();
    let of_edge = Touch::EdgeOfA {
        edge: 0,
        part: Part::Atom(0),
    };
    let expected = [
        // From the centre to the right: 2 − 0.5; from the right: 4 − 2.5.
        ((0.0, 0.0), (1.0, 0.0), 1.5, of_edge),
        ((4.0, 0.0), (-1.0, 0.0), 1.5, of_edge),
        // Through the opening from the left.
        ((-4.0, 0.0), (2.0, 0.0), 2.75, of_edge),
        // A chord at the height 0.9: 1.5² = 0.9² + 1.2².
        ((-1.0, 0.9), (1.0, 0.0), 2.2, of_edge),
        // The end at (0, 2), from above.
        ((-1e-9, 5.0), (0.0, -1.0), 2.5, Touch::Atoms(0, 0)),
    ];
    for (place, velocity, time, touch) in expected {
        let found = contact(&arc, &disc, place.into(), velocity.into()).unwrap();
        assert!(
            (found.time - time).abs() < 1e-14,
            "{found:?} against {time}"
        );
        let is_end = matches!(found.touch, Touch::Atoms(..));
        assert_eq!(is_end, matches!(touch, Touch::Atoms(..)), "{found:?}");
    }
    // The left side has no arc.
    assert_eq!(
        contact(&arc, &disc, DVec2::new(-1.0, 0.0), DVec2::NEG_X),
        None
    );
    let circles = BoundingCircles;
    let motion = RelativeMotion::exactly(DVec2::ZERO, DVec2::X);
    let answer = circles.first_contact(arc.outline(), disc.outline(), &motion, 10.0);
    assert!((answer.outcome.contact().unwrap().time - 1.5).abs() < 1e-14);
}

/// A disc that grazes: each chord spans the same angle, and no contact sinks into the wall.
#[test]
fn a_disc_skips_along_the_inside_of_a_circle_on_equal_chords() {
    let circle = Molecule::arc(Bend::circle(1.0).unwrap(), 0.0).unwrap();
    let disc = Molecule::disc(0.25, 1.0).unwrap();
    for graze in [0.3, 1e-3, 1e-6, 1e-9] {
        let mut place = DVec2::new(0.75, 0.0);
        let mut velocity = DVec2::new(-graze, 1.0).normalize();
        let chord = 1.5 * (graze / (1.0 + graze * graze).sqrt());
        for bounce in 0..1000 {
            let found = contact(&circle, &disc, place, velocity).unwrap();
            // The rounding of the place turns each chord by as much over its angle.
            if graze >= 1e-6 {
                let relative = found.time / chord - 1.0;
                assert!(
                    relative.abs() < 1e-12 + 1e-14 / (graze * graze),
                    "{graze} {bounce}: {relative:e}"
                );
            }
            place += velocity * found.time;
            let normal = place.normalize();
            velocity -= 2.0 * velocity.dot(normal) * normal;
            let sunk = place.length() - 0.75;
            assert!(
                sunk.abs() < 64.0 * f64::EPSILON,
                "{graze} {bounce}: {sunk:e}"
            );
        }
    }
}

#[test]
fn the_bound_on_the_closing_speed_at_an_arc_does_not_depend_on_the_order_of_the_bodies() {
    let arc = Molecule::arc(Bend::new(1.0, [-1.0, 1.0]).unwrap(), 0.0).unwrap();
    let dumbbell = Molecule::named(Shape::Dumbbell, 0.1, 1.0).unwrap();
    let motion = RelativeMotion {
        angular_velocity: [0.0, 50.0],
        ..RelativeMotion::exactly(DVec2::new(1.2, 0.0), DVec2::NEG_X)
    };
    let touch = Touch::EdgeOfA {
        edge: 0,
        part: Part::Atom(0),
    };
    let (a, b) = (arc.outline(), dumbbell.outline());
    let bound = resolved_speed(a, b, &motion, touch, DVec2::X);
    let exchanged = resolved_speed(b, a, &motion.exchanged(), touch.exchanged(), DVec2::NEG_X);
    assert_eq!(bound, exchanged);
    // The atom moves at 1 and turns at 5, with errors of some roundings of both.
    assert!(bound > 5.0 * f64::EPSILON && bound < 1e-11, "{bound:e}");
}
