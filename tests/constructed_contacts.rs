//! Contacts constructed at a known time, and random pairs against brute force: `Exact` finds the
//! first contact and no other.

use crate::support::{formulas::Pair, property::cases};
use carom_detection::{
    Answer, BoundingCircles, Contact, Detection, Exact, FixedStep, GoldenSecant, Outcome, Touch,
};
use carom_geometry::{Atom, Molecule};
use carom_kinematics::{Motion, Orientation, RelativeMotion};
use glam::DVec2;
use proptest::{num, prelude::*};

fn molecules() -> impl Strategy<Value = Molecule> {
    let atoms = prop::collection::vec((-1.0..1.0, -1.0..1.0, 0.02..0.5, 0.1..10.0), 1..6);
    atoms.prop_map(|list| {
        let atom = |(x, y, radius, mass)| Atom::new(DVec2::new(x, y), radius, mass).unwrap();
        Molecule::new(list.into_iter().map(atom)).unwrap()
    })
}

/// A vector of log-uniform length in any direction.
fn vectors(decades: std::ops::Range<f64>) -> impl Strategy<Value = DVec2> {
    (decades, 0.0..std::f64::consts::TAU)
        .prop_map(|(decade, angle)| 10f64.powf(decade) * DVec2::from_angle(angle))
}

fn spins() -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(0.0), 4 => -3.0..3.0f64, 1 => -300.0..300.0f64]
}

fn motions() -> impl Strategy<Value = Motion> {
    (vectors(-3.0..1.0), -0.5..0.5f64, spins()).prop_map(|(velocity, turns, angular_velocity)| {
        Motion {
            velocity,
            orientation: Orientation::from_turns(turns),
            angular_velocity,
            ..Motion::at_rest(DVec2::ZERO)
        }
    })
}

/// Moves B along a line towards the centre of A until the first atoms touch: the distance and the
/// atoms.
fn slide_in(a: &Molecule, b: &Molecule, rotations: [DVec2; 2], from: DVec2) -> (f64, (u32, u32)) {
    let mut farthest = (f64::NEG_INFINITY, (0, 0));
    for (i, atom_a) in a.atoms().iter().enumerate() {
        for (j, atom_b) in b.atoms().iter().enumerate() {
            let shift = rotations[1].rotate(atom_b.offset()) - rotations[0].rotate(atom_a.offset());
            let contact_distance = atom_a.radius() + atom_b.radius();
            let across = from.perp_dot(shift);
            let half_chord = (contact_distance * contact_distance - across * across).sqrt();
            let distance = half_chord - from.dot(shift);
            if distance > farthest.0 {
                farthest = (distance, (i as u32, j as u32));
            }
        }
    }
    farthest
}

fn ask(pair: &Pair<'_>, horizon: f64) -> Answer {
    Exact::default().first_contact(pair.a.outline(), pair.b.outline(), &pair.motion, horizon)
}

/// Checks a reported contact on its own: the atoms touch to 2 E and close, and no atoms touch
/// before.
fn assert_genuine(pair: &Pair<'_>, contact: Contact) {
    let Touch::Atoms(i, j) = contact.touch else {
        panic!("{contact:?} names no atoms")
    };
    let at = pair.approach((i, j), contact.time);
    assert!(
        at.gap.abs() <= 3.0 * pair.error((i, j), contact.time),
        "{contact:?}: {at:?}"
    );
    assert!(at.rate <= 0.0, "{contact:?}: {at:?}");
    pair.assert_nothing_before(contact.time);
}

proptest! {
    #![proptest_config(cases(2000))]

    #[test]
    fn a_constructed_contact_is_found(
        a in molecules(), b in molecules(), mut motion_a in motions(), mut motion_b in motions(),
        from in vectors(0.0..1e-9), lead in 0.001..3.0f64,
    ) {
        let rotations = [motion_a.orientation.cos_sin(), motion_b.orientation.cos_sin()];
        let from = from.normalize();
        let (distance, atoms) = slide_in(&a, &b, rotations, from);
        motion_b.position = from * distance;
        let touching = |a_motion: &Motion, b_motion: &Motion, time: f64| Pair {
            a: &a,
            b: &b,
            motion: RelativeMotion::between(a_motion, b_motion, DVec2::ZERO, time),
        };
        // If they separate, the mirrored motion closes.
        if touching(&motion_a, &motion_b, 0.0).approach(atoms, 0.0).rate > 0.0 {
            for motion in [&mut motion_a, &mut motion_b] {
                motion.velocity = -motion.velocity;
                motion.angular_velocity = -motion.angular_velocity;
            }
        }
        let contact = touching(&motion_a, &motion_b, 0.0);
        // Back in time by `lead`, or by less if they would overlap there.
        let mut planted = lead * contact.natural_time();
        let mut pair = touching(&motion_a, &motion_b, -planted);
        for _ in 0..30 {
            if pair.smallest_gap(0.0) > 0.0 {
                break;
            }
            planted *= 0.5;
            pair = touching(&motion_a, &motion_b, -planted);
        }
        // A graze no deeper than the rounding bound may be reported as a miss.
        let at = contact.approach(atoms, 0.0);
        prop_assume!(pair.smallest_gap(0.0) > 0.0);
        prop_assume!(at.rate * at.rate > 16.0 * at.curvature.abs() * pair.error(atoms, planted));

        let answer = ask(&pair, 2.0 * planted);
        let Outcome::Contact(found) = answer.outcome else { panic!("missed at {planted}: {answer:?}") };
        let tolerance = 2.0 * pair.time_tolerance(atoms, planted);
        prop_assert!(found.time <= planted + tolerance, "late: {found:?}, planted at {planted}");
        if found.time >= planted - tolerance {
            prop_assert_eq!(found.touch, Touch::Atoms(atoms.0, atoms.1));
        } else {
            // An earlier contact was found; it must be genuine, and this is possible only if they
            // overlap at some time before the constructed contact.
            prop_assert!(found.time >= 0.0);
            let overlaps = (1..1000).any(|part| {
                let time = found.time + (planted - found.time) * f64::from(part) / 1000.0;
                pair.smallest_gap(time) < 0.0
            });
            prop_assert!(overlaps || found.time == 0.0, "early: {found:?}, planted at {planted}");
        }
        if found.time > 0.0 {
            assert_genuine(&pair, found);
        }
    }

    #[test]
    fn answers_for_random_pairs_agree_with_brute_force(
        a in molecules(), b in molecules(), motion_a in motions(), mut motion_b in motions(),
        place in vectors(0.0..1.5),
    ) {
        motion_b.position = place;
        let pair = Pair { a: &a, b: &b, motion: RelativeMotion::between(&motion_a, &motion_b, DVec2::ZERO, 0.0) };
        prop_assume!(pair.smallest_gap(0.0) > 1e-9);
        let horizon = 5.0 * pair.natural_time();
        match ask(&pair, horizon).outcome {
            Outcome::Contact(contact) => {
                prop_assert!(contact.time <= horizon);
                assert_genuine(&pair, contact);
            }
            Outcome::Free => pair.assert_nothing_before(horizon),
            Outcome::FreeUntil(time) => pair.assert_nothing_before(time),
            other => panic!("certified detectors resolve, but this is {other:?}"),
        }
    }
}

/// Any magnitude within the limits of the library, with a high share of special values.
fn magnitudes() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => (-60.0..60.0f64).prop_map(|decade| 10f64.powf(decade)),
        4 => -2.0..2.0f64,
        1 => Just(1e60),
        1 => Just(1e-60),
        1 => Just(0.0),
        1 => Just(f64::MIN_POSITIVE),
        1 => Just(5e-324),
        1 => (num::f64::NORMAL | num::f64::SUBNORMAL).prop_map(|bits| bits.clamp(-1e60, 1e60)),
    ]
    .prop_flat_map(|magnitude| prop_oneof![Just(magnitude), Just(-magnitude)])
}

fn extreme_molecules() -> impl Strategy<Value = Molecule> {
    let lengths = || magnitudes().prop_map(|x| x.abs().max(1e-60));
    let atoms = prop::collection::vec((magnitudes(), magnitudes(), lengths(), lengths()), 1..4);
    atoms.prop_filter_map("atoms on one spot", |list| {
        let atom = |(x, y, radius, mass)| Atom::new(DVec2::new(x, y), radius, mass).unwrap();
        Molecule::new(list.into_iter().map(atom)).ok()
    })
}

proptest! {
    #![proptest_config(cases(5000))]

    #[test]
    fn no_input_within_the_limits_makes_a_detector_panic_hang_or_answer_nan(
        a in extreme_molecules(), b in extreme_molecules(),
        (x, y, vx, vy) in (magnitudes(), magnitudes(), magnitudes(), magnitudes()),
        turns in prop::array::uniform2(-0.5..0.5f64), angular_velocity in prop::array::uniform2(magnitudes()),
        horizon in prop_oneof![Just(0.0), Just(1.0), Just(f64::MAX), magnitudes().prop_map(f64::abs)],
    ) {
        let motion = RelativeMotion {
            orientation: turns.map(Orientation::from_turns),
            angular_velocity,
            ..RelativeMotion::exactly(DVec2::new(x, y), DVec2::new(vx, vy))
        };
        check_answers(&a, &b, &motion, horizon)?;
    }

    #[test]
    fn any_bits_give_an_answer_and_numbers_out_of_range_are_reported(
        a in extreme_molecules(), b in extreme_molecules(), wall in 0..4u8,
        bits in prop::array::uniform12(any::<u64>()), good in prop::array::uniform12(magnitudes()),
        bad in prop::collection::vec(0..12usize, 0..3), horizon in any::<u64>().prop_map(f64::from_bits),
    ) {
        // Most numbers are valid, so that in most cases one invalid number is tested alone.
        let number = |index: usize| if bad.contains(&index) { f64::from_bits(bits[index]) } else { good[index] };
        let motion = RelativeMotion {
            separation: DVec2::new(number(0), number(1)),
            velocity: DVec2::new(number(2), number(3)),
            orientation: [number(4), number(5)].map(Orientation::from_turns),
            angular_velocity: [number(6), number(7)],
            separation_error: number(8).abs(),
            velocity_error: number(9).abs(),
            orientation_error: [number(10).abs(), number(11).abs()],
        };
        let wall = Molecule::wall(DVec2::new(1.0, 2.0), f64::from(wall % 2)).ok().filter(|_| wall < 2);
        check_answers(wall.as_ref().unwrap_or(&a), &b, &motion, horizon)?;
    }
}

/// Checks the answers of all detectors: they contain no NaN, and input that is not finite is
/// reported as out of range.
fn check_answers(
    a: &Molecule,
    b: &Molecule,
    motion: &RelativeMotion,
    horizon: f64,
) -> Result<(), TestCaseError> {
    let places = motion.separation.is_finite() && motion.separation_error.is_finite();
    let velocities = motion.velocity.is_finite() && motion.velocity_error.is_finite();
    let angles = motion
        .orientation
        .iter()
        .all(|orientation| orientation.turns().is_finite())
        && motion
            .angular_velocity
            .iter()
            .chain(&motion.orientation_error)
            .all(|number| number.is_finite());
    let is_finite = places && velocities && angles && !horizon.is_nan();
    let exact = Exact { most_steps: 100 };
    let golden_secant = GoldenSecant {
        most_segments: 10,
        ..GoldenSecant::default()
    };
    let fixed_step = FixedStep {
        most_steps: 100,
        ..FixedStep::default()
    };
    let detectors: [&dyn Detection; 4] = [&exact, &golden_secant, &BoundingCircles, &fixed_step];
    let pairs = (a.atoms().len() * b.atoms().len()) as u32;
    // Bound per atom pair: two golden-section searches and a secant search in each of ten segments.
    let most_evaluations = pairs * 10 * 800;
    for (index, detector) in detectors.into_iter().enumerate() {
        let answer = detector.first_contact(a.outline(), b.outline(), motion, horizon);
        prop_assert!(
            is_finite || answer.outcome == Outcome::OutOfRange,
            "detector {index}: {motion:?} {answer:?}"
        );
        prop_assert!(
            answer.evaluations <= most_evaluations,
            "detector {index}: {answer:?}"
        );
        let time = match answer.outcome {
            Outcome::Contact(contact) => {
                prop_assert!(contact.time <= horizon, "detector {index}: {answer:?}");
                contact.time
            }
            Outcome::FreeUntil(time) | Outcome::Unresolved(time) => time,
            Outcome::Free | Outcome::OutOfRange => 0.0,
        };
        prop_assert!(
            time >= 0.0 && time.is_finite(),
            "detector {index}: {answer:?}"
        );
    }
    Ok(())
}
