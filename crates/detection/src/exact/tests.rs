//! Tests of the guarantees of the certified detector, on constructed and on random encounters.

use super::*;
use crate::{Touch, atom_pair::AtomPair, gap_search::GapFunction};
use carom_geometry::{Atom, Circle, MAX_MAGNITUDE, Molecule, Shape};
use carom_kinematics::Orientation;
use glam::DVec2;
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

fn ask(a: &Molecule, b: &Molecule, motion: &RelativeMotion, horizon: f64) -> Answer {
    Exact::default().first_contact(a.outline(), b.outline(), motion, horizon)
}

/// The gap of the touching atoms at the reported contact, in units of E.
fn gap_in_units_of_error(
    a: Outline<'_>,
    b: Outline<'_>,
    motion: &RelativeMotion,
    answer: &Answer,
) -> f64 {
    let contact = answer.outcome.contact().expect("a contact");
    let Touch::Atoms(i, j) = contact.touch else {
        panic!("atoms touch")
    };
    let flight = Flight::new(a, b, motion);
    let circles = [
        Circle::from(&a.atoms[i as usize]),
        Circle::from(&b.atoms[j as usize]),
    ];
    let pair = AtomPair::new(&flight, circles);
    let now = pair.gap(&pair.pose(contact.time));
    now.value / now.error
}

/// Whether two atoms overlap by more than 2 E at `time`.
fn overlap(a: &Atom, b: &Atom, motion: &RelativeMotion, time: f64) -> bool {
    let flight = Flight::new(a.outline(), b.outline(), motion);
    let pair = AtomPair::new(&flight, [a.into(), b.into()]);
    let now = pair.gap(&pair.pose(time));
    now.value < -2.0 * now.error
}

fn named(shape: Shape) -> Molecule {
    Molecule::named(shape, 0.5, 1.0).unwrap()
}

fn grazing_atoms() -> (Atom, Atom) {
    (
        named(Shape::Dumbbell).atoms()[0],
        named(Shape::Tee).atoms()[4],
    )
}

prop_compose! {
    /// An atom of a dumbbell and an atom of a tee at a gap of ±10^-`depth` at `time`, with g' = 0.
    fn grazes()(
        depth in 5..16i32, sign in prop::bool::weighted(0.8), normal in 0.0..TAU, slip in 3.0..6.0f64,
        turns in prop::array::uniform2(-0.5..0.5f64), spin in prop::array::uniform2(-1.0..1.0f64),
        time in 0.05..0.2f64,
    ) -> (RelativeMotion, f64, f64) {
        let (a, b) = grazing_atoms();
        let arm = |atom: &Atom, body: usize| {
            Orientation::from_turns(turns[body]).turned(spin[body], time).cos_sin().rotate(atom.offset())
        };
        let (arm_a, arm_b) = (arm(&a, 0), arm(&b, 1));
        let normal = DVec2::from_angle(normal);
        let depth = if sign { 10f64.powi(-depth) } else { -10f64.powi(-depth) };
        let turning = spin[1] * arm_b.perp() - spin[0] * arm_a.perp();
        let velocity = slip * normal.perp() - turning.dot(normal) * normal - turning.dot(normal.perp()) * normal.perp();
        let d = (1.0 - depth) * normal;
        let motion = RelativeMotion {
            orientation: turns.map(Orientation::from_turns),
            angular_velocity: spin,
            ..RelativeMotion::exactly(d - (arm_b - arm_a) - velocity * time, velocity)
        };
        (motion, time, depth)
    }
}

proptest! {
    /// An unguarded last Newton step moves a near-tangent contact far into overlap. Accepting a
    /// truncated step reports a contact too early. Both violate the bound on the gap.
    #[test]
    fn grazing_contacts_are_placed_within_rounding((motion, time, depth) in grazes()) {
        let (a, b) = grazing_atoms();
        let answer = Exact::default().first_contact(a.outline(), b.outline(), &motion, 10.0);
        match answer.outcome {
            Outcome::Contact(contact) => {
                prop_assert!(gap_in_units_of_error(a.outline(), b.outline(), &motion, &answer).abs() <= 2.0);
                for part in 0..200 {
                    prop_assert!(!overlap(&a, &b, &motion, contact.time * f64::from(part) / 200.0));
                }
                // Slip of 3 to 6 at distance 1 and accelerations below 3: g'' > 5 at the graze.
                let dip = (depth.max(0.0) * 2.0 / 5.0).sqrt() + 1e-7;
                prop_assert!(depth < 1e-13 || contact.time <= time + dip);
            }
            _ => prop_assert!(depth < 1e-13, "a graze of depth {depth:e} is missed: {answer:?}"),
        }
        prop_assert!(answer.evaluations < 400, "{answer:?}");
    }

    #[test]
    fn exchanged_bodies_and_scaled_velocities_give_the_same_bits(
        size_a in 0..3usize, size_b in 0..3usize, x in 2.0..6.0f64, y in -2.0..2.0f64,
        turns in prop::array::uniform2(-0.5..0.5f64), spin in prop::array::uniform2(-3.0..3.0f64), k in -40..40i32,
    ) {
        let shapes = [Shape::Tee, Shape::Rod(16), Shape::Ring(9)];
        let (a, b) = (named(shapes[size_a]), named(shapes[size_b]));
        let reach = a.bounding_radius() + b.bounding_radius();
        let motion = RelativeMotion {
            orientation: turns.map(Orientation::from_turns),
            angular_velocity: spin.map(|spin| spin / reach),
            ..RelativeMotion::exactly(DVec2::new(x, 0.3 * y) * reach, DVec2::new(-1.0, 0.1))
        };
        let answer = ask(&a, &b, &motion, 100.0);
        let exchanged = ask(&b, &a, &motion.exchanged(), 100.0);
        prop_assert_eq!(exchanged.outcome.contact().map(|c| (c.time, c.touch.exchanged())),
            answer.outcome.contact().map(|c| (c.time, c.touch)));
        let factor = 2f64.powi(k);
        let faster = RelativeMotion {
            velocity: motion.velocity * factor,
            angular_velocity: motion.angular_velocity.map(|spin| spin * factor),
            ..motion
        };
        let scaled = ask(&a, &b, &faster, 100.0 / factor);
        prop_assert_eq!(scaled.evaluations, answer.evaluations);
        prop_assert_eq!(scaled.outcome.contact().map(|c| (c.time * factor, c.touch)),
            answer.outcome.contact().map(|c| (c.time, c.touch)));
    }

    #[test]
    fn searches_of_any_magnitude_end_and_advance(
        places in prop::array::uniform4(wild()), spin in prop::array::uniform2(wild()),
        sizes in prop::array::uniform3(-60.0..60.0f64), turns in prop::array::uniform2(-0.5..0.5f64),
        horizon in prop_oneof![wild().prop_map(f64::abs), Just(f64::INFINITY), Just(0.0)],
        shape in 0..3usize, most_steps in 0..50u32,
    ) {
        let shape = [Shape::Dumbbell, Shape::Tee, Shape::Rod(9)][shape];
        let [a, b] = [sizes[0], sizes[1]].map(|power| Molecule::named(shape, 10f64.powf(power * 0.9), 1.0).unwrap());
        // Half of the pairs start near each other, where contacts occur.
        let near = if sizes[2] > 0.0 { a.bounding_radius().max(b.bounding_radius()) } else { MAX_MAGNITUDE };
        let motion = RelativeMotion {
            orientation: turns.map(Orientation::from_turns),
            angular_velocity: spin,
            ..RelativeMotion::exactly(
                DVec2::new(places[0], places[1]).clamp_length_max(near),
                DVec2::new(places[2], places[3]),
            )
        };
        let answer = Exact { most_steps }.first_contact(a.outline(), b.outline(), &motion, horizon);
        match answer.outcome {
            Outcome::Contact(contact) => prop_assert!((0.0..=horizon).contains(&contact.time), "{contact:?}"),
            Outcome::FreeUntil(time) => prop_assert!(time > 0.0 && time.is_finite()),
            Outcome::Free => {}
            Outcome::Unresolved(_) => prop_assert!(false, "{answer:?}"),
            Outcome::OutOfRange => {
                let rim = a.bounding_radius() * spin[0].abs() + b.bounding_radius() * spin[1].abs();
                prop_assert!(rim > MAX_MAGNITUDE, "{motion:?}");
            }
        }
    }
}

/// A number of any allowed magnitude, or 0.
fn wild() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => (-60.0..60.0f64, any::<bool>())
            .prop_map(|(power, negative)| if negative { -10f64.powf(power) } else { 10f64.powf(power) }),
        1 => Just(0.0),
    ]
}

#[test]
fn matched_spins_at_a_constant_gap_are_passed_in_few_steps() {
    // Two bodies side by side with equal arms and spins: d'' = 0 up to rounding, while K > 0.
    let offset = DVec2::new(1.0, 0.5);
    let atom = Atom::new(offset, 0.5, 1.0).unwrap();
    for (exponent, most) in [(2, 2), (4, 11), (6, 101), (8, 1004)] {
        let motion = RelativeMotion {
            angular_velocity: [TAU; 2],
            ..RelativeMotion::exactly(DVec2::new(1.0 + 10f64.powi(-exponent), 0.0), DVec2::ZERO)
        };
        let answer = Exact::default().first_contact(atom.outline(), atom.outline(), &motion, 1.0);
        assert_eq!(answer.outcome, Outcome::Free);
        // The first steps use the short bound by design.
        let plain = 1 + crate::tolerance::SHORT_STEPS;
        assert!(
            answer.evaluations <= most + plain,
            "gap 1e-{exponent}: {} evaluations",
            answer.evaluations
        );
    }
}

#[test]
fn a_search_that_reaches_its_step_limit_can_be_continued() {
    // d turns with both bodies at constant length: no bound on d'' proves that it never closes.
    let atom = |x: f64| Atom::new(DVec2::new(x, 0.0), 0.5, 1.0).unwrap();
    let (a, b) = (atom(-0.5), atom(0.5 + 1e-9));
    let motion = RelativeMotion {
        angular_velocity: [1.0; 2],
        ..RelativeMotion::exactly(DVec2::ZERO, DVec2::ZERO)
    };
    let mut time = 0.0;
    for _ in 0..10 {
        let later = RelativeMotion {
            orientation: [Orientation::default().turned(1.0, time); 2],
            ..motion
        };
        match (Exact { most_steps: 100 })
            .first_contact(a.outline(), b.outline(), &later, 1.0)
            .outcome
        {
            Outcome::FreeUntil(more) => time += more,
            other => panic!("{other:?}"),
        }
    }
    // 100 steps of at least √(2 · 1e-9 / K), K = 1, per search.
    assert!(time > 10.0 * 99.0 * 4.4e-5, "{time}");
}

#[test]
fn fast_rotors_are_caught_within_half_a_turn() {
    // A dumbbell turns on the spot. A disc flies straight at it and reaches the orbit of the atoms
    // after `turns` turns. One of the two atoms hits it at most half a turn later.
    let (dumbbell, disc) = (named(Shape::Dumbbell), named(Shape::Disc));
    for turns in [1e4, 1e6, 1e8] {
        for phase in 0..20 {
            let spin = TAU * turns;
            let motion = RelativeMotion {
                orientation: [
                    Orientation::from_turns(0.05 * f64::from(phase)),
                    Orientation::default(),
                ],
                angular_velocity: [spin, 0.0],
                ..RelativeMotion::exactly(DVec2::new(2.5, 0.1), DVec2::new(-1.0, 0.0))
            };
            let answer = ask(&dumbbell, &disc, &motion, 10.0);
            let time = answer
                .outcome
                .contact()
                .expect("the dumbbell hits the disc")
                .time;
            let orbit = 2.5 - f64::sqrt(1.5 * 1.5 - 0.01);
            let rounding = 1e-15 * time;
            assert!(
                time >= orbit - rounding && time <= orbit + PI / spin + rounding,
                "{turns:e}: {time}"
            );
            assert!(
                gap_in_units_of_error(dumbbell.outline(), disc.outline(), &motion, &answer).abs()
                    <= 2.0
            );
            // A few roundings of the angle, as a length.
            let flight = Flight::new(dumbbell.outline(), disc.outline(), &motion);
            let circles = [
                Circle::from(&dumbbell.atoms()[0]),
                Circle::from(&disc.atoms()[0]),
            ];
            assert!(
                AtomPair::new(&flight, circles).error.at(time) < 2.0 * f64::EPSILON * spin * time
            );
            assert!(answer.evaluations < 2000, "{turns:e}: {answer:?}");
        }
    }
}

#[test]
fn overlapping_pairs_that_close_are_in_contact_at_once() {
    let (a, b) = (named(Shape::Tee), named(Shape::Cross));
    for depth in [0.0, 1e-17, 1e-16, 1e-15, 1e-9, 1e-3] {
        for (speed, spins) in [
            (1.0, [0.1, -0.2]),
            (-1.0, [0.1, -0.2]),
            (1.0, [0.0; 2]),
            (-1.0, [0.0; 2]),
        ] {
            // The right end of the bar of the tee and the left arm of the cross.
            let d = a.atoms()[2].offset() - b.atoms()[3].offset() + DVec2::new(1.0 - depth, 0.0);
            let motion = RelativeMotion {
                angular_velocity: spins,
                ..RelativeMotion::exactly(d, DVec2::new(-speed, 0.0))
            };
            let outcome = ask(&a, &b, &motion, 0.5).outcome;
            if speed > 0.0 {
                let contact = outcome.contact().expect("closing");
                assert!(contact.time <= 4e-16, "depth {depth:e}: {contact:?}");
                assert_eq!(contact.touch, Touch::Atoms(2, 3));
            } else {
                assert_eq!(outcome, Outcome::Free, "depth {depth:e}, parting");
            }
        }
    }
}

#[test]
fn the_interval_between_two_close_contacts_is_accurate() {
    // An atom orbits a point at distance D from a fixed disc, on a circle of radius r. They overlap
    // except within the angle ±ε about the far end. It leaves at −ε and returns after 2 ε.
    let (circle, distance) = (0.5, 1.0);
    for interval in [1e-3, 1e-6, 1e-9, 1e-12] {
        for part in 1..=20 {
            let epsilon = 0.5 * interval * (0.5 + 0.1 * f64::from(part));
            let squared =
                circle * circle + distance * distance + 2.0 * circle * distance * epsilon.cos();
            let rotor = Atom::new(DVec2::new(-circle, 0.0), 0.5, 1.0).unwrap();
            let disc = Atom::new(DVec2::ZERO, squared.sqrt() - 0.5, 1.0).unwrap();
            let motion = RelativeMotion {
                orientation: [
                    Orientation::from_turns(-epsilon / TAU),
                    Orientation::default(),
                ],
                angular_velocity: [1.0, 0.0],
                ..RelativeMotion::exactly(DVec2::new(distance, 0.0), DVec2::ZERO)
            };
            let answer =
                Exact::default().first_contact(rotor.outline(), disc.outline(), &motion, 1.0);
            let back = answer.outcome.contact().expect("the atom returns").time;
            let off = (back / (2.0 * epsilon) - 1.0).abs();
            assert!(
                off < 4e-15 / interval + 1e-13,
                "{interval:e}: off by {off:e} of the interval"
            );
            assert!(answer.evaluations <= 40, "{interval:e}: {answer:?}");
        }
    }
}

/// The contact of two rods of six atoms with all velocities multiplied by a factor: the bits of its
/// time in units of 1/factor, and the parts.
fn slow_rods(factor: f64) -> (u64, Touch) {
    let rod = named(Shape::Rod(6));
    let motion = RelativeMotion {
        angular_velocity: [-0.5 * factor, -2.0 * factor],
        ..RelativeMotion::exactly(DVec2::new(6.25, -1.0), DVec2::new(-factor, 0.0))
    };
    let contact = ask(&rod, &rod, &motion, 20.0 / factor)
        .outcome
        .contact()
        .expect("they meet");
    ((contact.time * factor).to_bits(), contact.touch)
}

#[test]
fn a_contact_of_turning_rods_has_the_same_bits_at_every_speed() {
    // Over most of the allowed range of speeds: |d''|² underflows below 2⁻²⁷⁰.
    for k in (-490..=200).step_by(5) {
        assert_eq!(slow_rods(2f64.powi(k)), slow_rods(1.0), "2^{k}");
    }
}

proptest! {
    #[test]
    fn velocities_times_any_power_of_two_give_the_same_bits(
        counts in prop::array::uniform2(1..10usize), x in 1.1..4.0f64, y in -1.0..1.0f64,
        turns in prop::array::uniform2(-0.5..0.5f64), spin in prop::array::uniform2(-3.0..3.0f64), k in -490..190i32,
    ) {
        let [a, b] = counts.map(|count| named(Shape::Rod(count)));
        let reach = a.bounding_radius() + b.bounding_radius();
        let factor = 2f64.powi(k);
        let motion = |factor: f64| RelativeMotion {
            orientation: turns.map(Orientation::from_turns),
            angular_velocity: spin.map(|spin| spin * factor / reach),
            ..RelativeMotion::exactly(DVec2::new(x, y) * reach, DVec2::new(-1.0, 0.1) * factor)
        };
        let (one, other) = (ask(&a, &b, &motion(1.0), 1e4), ask(&a, &b, &motion(factor), 1e4 / factor));
        prop_assert_eq!(other.evaluations, one.evaluations);
        prop_assert_eq!(other.outcome.contact().map(|c| (c.time * factor, c.touch)),
            one.outcome.contact().map(|c| (c.time, c.touch)));
    }
}

/// In the long unit of time of a slow pair this horizon is 0 to rounding: it still lies before the
/// present.
#[test]
fn a_horizon_before_the_present_finds_no_contact_in_any_unit_of_time() {
    let disc = Molecule::disc(1.0, 1.0).unwrap();
    let wall = Molecule::wall(DVec2::new(1.0, 2.0), 1.0).unwrap();
    let motion = RelativeMotion {
        orientation_error: [1.8, 1.2],
        ..RelativeMotion::exactly(DVec2::new(1e-60, 0.0), DVec2::new(2.2e-20, -2.2e-308))
    };
    for horizon in [-1.7e-307, -1.0] {
        let answer = ask(&wall, &disc, &motion, horizon);
        assert_eq!(answer.outcome, Outcome::Free, "{horizon}");
    }
}
