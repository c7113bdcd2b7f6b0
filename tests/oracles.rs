//! The exact detector against an oracle in double-double arithmetic on encounters of all classes of
//! discs and of walls at rest, and this oracle against another with 200 bits. The test of those
//! with edges that turn is in `crates/testkit`.

use carom_detection::{
    Answer, Contact, Exact, Outcome, Touch,
    encounters::{Class, Encounter},
};
use carom_testkit::oracle::{
    DoubleDouble, ExclusionReference, Number, Oracle, OracleVerdict, assert_agreement,
    assert_guarantee,
};

const SEED: u64 = 20_170;

fn is_of_walls(class: Class) -> bool {
    class.to_string().starts_with("wall")
}

#[test]
fn exact_satisfies_its_guarantee_on_all_classes_of_molecules() {
    let oracle = Oracle {
        most_intervals: 300_000,
    };
    let (mut judged, mut unresolved, mut deviations) = (0, 0, Vec::new());
    let is_of_discs = |class: &Class| !is_of_walls(*class) && !class.has_edges();
    for class in Class::ALL.into_iter().filter(is_of_discs) {
        // The oracle is slow for many atoms.
        let count = if matches!(class, Class::Rods | Class::Blobs) {
            21
        } else {
            100
        };
        for index in 0..count {
            let (_, judgement) = assert_guarantee(oracle, (class, SEED, index));
            let Some(judgement) = judgement else {
                unresolved += 1;
                continue;
            };
            judged += 1;
            if class == Class::Generic {
                deviations.extend(judgement.deviation);
            }
        }
    }
    eprintln!("{judged} judged, {unresolved} unresolved by the oracle");
    assert!(
        judged > 2500 && unresolved < 60,
        "{judged} judged, {unresolved} unresolved"
    );
    deviations.sort_by(f64::total_cmp);
    assert!(
        deviations[deviations.len() / 2] < 1e-15,
        "median |Δt| {:e}",
        deviations[deviations.len() / 2]
    );
}

/// Molecules against walls: faces and end points, tangential motion, any angular velocity, and
/// contacts in quick succession.
#[test]
fn exact_satisfies_its_guarantee_at_walls() {
    let oracle = Oracle {
        most_intervals: 300_000,
    };
    let [mut judged, mut unresolved, mut faces, mut ends] = [0; 4];
    for class in Class::ALL.into_iter().filter(|class| is_of_walls(*class)) {
        let mut deviations = Vec::new();
        let (count, tolerance) = if class == Class::Wall {
            (2000, 1e-15)
        } else {
            (200, 1e-6)
        };
        for index in 0..count {
            let (answer, judgement) = assert_guarantee(oracle, (class, SEED + 1, index));
            match answer.outcome.contact().map(|contact| contact.touch) {
                Some(Touch::EdgeOfA { .. } | Touch::EdgeOfB { .. }) => faces += 1,
                Some(_) => ends += 1,
                None => {}
            }
            let Some(judgement) = judgement else {
                unresolved += 1;
                continue;
            };
            judged += 1;
            deviations.extend(judgement.deviation);
        }
        deviations.sort_by(f64::total_cmp);
        let median = deviations[deviations.len() / 2];
        eprintln!(
            "{class}: {} contacts, median |Δt| {median:e}, worst {:e}",
            deviations.len(),
            deviations[deviations.len() - 1]
        );
        assert!(median < tolerance, "{class}: median |Δt| {median:e}");
    }
    eprintln!("{judged} judged, {unresolved} unresolved by the oracle, {faces} faces, {ends} ends");
    assert!(
        judged > 3700 && unresolved < 40 && faces > 2000 && ends > 300,
        "{judged}, {unresolved}, {faces}, {ends}"
    );
}

#[test]
fn the_oracle_agrees_with_another_at_200_bits() {
    let oracle = Oracle {
        most_intervals: 20_000,
    };
    let mut contacts = 0;
    for class in Class::ALL.into_iter().filter(|class| !class.has_edges()) {
        for index in 0..2 {
            let encounter = Encounter::draw(class, SEED, index);
            if encounter
                .molecules
                .iter()
                .any(|molecule| molecule.atoms().len() > 5)
            {
                continue;
            }
            let name = format!("{class} {index}");
            contacts += u32::from(assert_agreement(oracle, &encounter, &name).is_some());
        }
    }
    assert!(contacts > 15, "{contacts} contacts compared");
}

/// The same relative motion at half the velocity and angular velocity takes twice as long.
#[test]
fn the_oracle_scales_with_time() {
    let oracle = Oracle::default();
    for index in 0..30 {
        let encounter = Encounter::draw(Class::Generic, SEED, index);
        let mut slower = encounter.clone();
        slower.motion.velocity *= 0.5;
        slower.motion.angular_velocity = encounter.motion.angular_velocity.map(|spin| 0.5 * spin);
        slower.horizon *= 2.0;
        match (
            oracle.first_contact::<DoubleDouble>(&encounter),
            oracle.first_contact::<DoubleDouble>(&slower),
        ) {
            (ExclusionReference::Deep(one), ExclusionReference::Deep(two)) => {
                let off =
                    one.touch.plus(&one.touch).minus(&two.touch).value() / encounter.natural_time();
                assert!(off.abs() < 1e-25, "{index}: {off:e}");
            }
            (ExclusionReference::Free, ExclusionReference::Free) => {}
            other => panic!("{index}: {other:?}"),
        }
    }
}

#[test]
fn the_oracle_distinguishes_wrong_answers_from_right_ones() {
    let oracle = Oracle::default();
    let mut seen = [0; 2];
    for index in 0..60 {
        let encounter = Encounter::draw(Class::Generic, SEED, index);
        let answer = encounter.first_contact(&Exact::default());
        let reference = oracle.first_contact::<DoubleDouble>(&encounter);
        let verdict = |outcome| {
            let answer = Answer {
                outcome,
                evaluations: 0,
            };
            reference
                .judge(&encounter, &answer)
                .expect("the oracle has an answer")
                .verdict
        };
        let Some(contact) = answer.outcome.contact() else {
            let touch = Touch::Atoms(0, 0);
            let invented = Outcome::Contact(Contact {
                time: 0.5 * encounter.horizon,
                touch,
            });
            let pass = verdict(invented);
            assert_eq!(
                (verdict(Outcome::Free), pass),
                (OracleVerdict::Right, OracleVerdict::False),
                "{index}"
            );
            seen[0] += 1;
            continue;
        };
        seen[1] += 1;
        assert_eq!(verdict(Outcome::Free), OracleVerdict::Missed, "{index}");
        assert_eq!(verdict(Outcome::Unresolved(0.0)), OracleVerdict::GaveUp);
        let shift = 1e-6 * encounter.natural_time();
        assert_eq!(
            verdict(Outcome::FreeUntil(contact.time - shift)),
            OracleVerdict::FreeUntil,
            "{index}"
        );
        assert_eq!(
            verdict(Outcome::FreeUntil(contact.time + shift)),
            OracleVerdict::Missed,
            "{index}"
        );
        for (time, expected) in [
            (contact.time - shift, OracleVerdict::Early),
            (contact.time + shift, OracleVerdict::Late),
        ] {
            assert_eq!(
                verdict(Outcome::Contact(Contact { time, ..contact })),
                expected,
                "{index}"
            );
        }
        // The right time, but other atoms, which do not touch.
        let atoms = encounter.molecules[1].atoms().len() as u32;
        if let (Touch::Atoms(i, j), true) = (contact.touch, atoms > 1) {
            let touch = Touch::Atoms(i, (j + 1) % atoms);
            assert_eq!(
                verdict(Outcome::Contact(Contact { touch, ..contact })),
                OracleVerdict::Early,
                "{index}"
            );
        }
    }
    assert!(seen.iter().all(|&count| count > 3), "{seen:?}");
}
