//! Each detector against 450 encounters with a known first contact (`tests/data/README.md`).

use std::{collections::BTreeMap, path::Path};

use crate::support::formulas::Pair;
use carom_detection::{
    Answer, BoundingCircles, Detection, Exact, FixedStep, GoldenSecant, Outcome, Touch,
};
use carom_kinematics::Motion;
use carom_runs::encounters::{self, EncounterRecord, ExpectedAnswer};

fn all() -> Vec<EncounterRecord> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/encounters.csv");
    let all = encounters::read(&file).unwrap();
    assert_eq!(all.len(), 450);
    assert!(
        all.iter()
            .all(|encounter| encounter.expected.is_some() && encounter.window_end.is_some())
    );
    all
}

fn pair(encounter: &EncounterRecord) -> Pair<'_> {
    let [a, b] = &encounter.molecules;
    Pair {
        a,
        b,
        motion: encounter.pair_at(0.0),
    }
}

fn ask(detector: &dyn Detection, pair: &Pair<'_>, horizon: f64) -> Answer {
    detector.first_contact(pair.a.outline(), pair.b.outline(), &pair.motion, horizon)
}

/// The result of comparing an answer with the known one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Verdict {
    Right,
    Missed,
    Late,
    Early,
    False,
    WrongAtoms,
    Unresolved,
}

/// Times are right within the tolerance of the pair at the known contact.
fn verdict(encounter: &EncounterRecord, outcome: Outcome) -> Verdict {
    match (encounter.expected.unwrap(), outcome) {
        (_, Outcome::FreeUntil(_) | Outcome::Unresolved(_) | Outcome::OutOfRange) => {
            Verdict::Unresolved
        }
        (ExpectedAnswer::Free, Outcome::Free) => Verdict::Right,
        (ExpectedAnswer::Free, Outcome::Contact(_)) => Verdict::False,
        (ExpectedAnswer::Contact { .. }, Outcome::Free) => Verdict::Missed,
        (ExpectedAnswer::Contact { time, atoms }, Outcome::Contact(found)) => {
            let atoms = atoms.expect("the file names them");
            let tolerance = pair(encounter).time_tolerance(atoms, time);
            if found.time > time + tolerance {
                Verdict::Late
            } else if found.time < time - tolerance {
                Verdict::Early
            } else if found.touch == Touch::Atoms(atoms.0, atoms.1) {
                Verdict::Right
            } else {
                Verdict::WrongAtoms
            }
        }
    }
}

/// Counts the verdicts of each kind by class; `--nocapture` prints them.
fn tally(name: &str, detector: &dyn Detection) -> BTreeMap<(String, Verdict), usize> {
    let mut counts = BTreeMap::new();
    for encounter in &all() {
        let answer = ask(detector, &pair(encounter), encounter.window_end.unwrap());
        *counts
            .entry((encounter.class.clone(), verdict(encounter, answer.outcome)))
            .or_default() += 1;
    }
    for ((class, verdict), count) in &counts {
        eprintln!("{name:13} {class:12} {verdict:?} {count}");
    }
    counts
}

#[test]
fn exact_finds_each_known_contact_and_no_other() {
    let mut deviations = Vec::new();
    for encounter in &all() {
        let pair = pair(encounter);
        let answer = ask(&Exact::default(), &pair, encounter.window_end.unwrap());
        let verdict = verdict(encounter, answer.outcome);
        assert_eq!(
            verdict,
            Verdict::Right,
            "{} {}: {answer:?}",
            encounter.class,
            encounter.id
        );
        if let (Some(ExpectedAnswer::Contact { time, .. }), Outcome::Contact(found)) =
            (encounter.expected, answer.outcome)
        {
            deviations.push((found.time - time).abs() / pair.natural_time());
        }
    }
    deviations.sort_by(f64::total_cmp);
    let (median, largest) = (
        deviations[deviations.len() / 2],
        deviations[deviations.len() - 1],
    );
    eprintln!("|Δt| in natural times: median {median:.1e}, largest {largest:.1e}");
    assert_eq!(deviations.len(), 350);
    assert!(median < 1e-14);
}

#[test]
fn golden_secant_finds_each_known_contact() {
    // It has no certificate, but 45 grazes of depth 1e-9 and more are wide enough for its
    // golden-section search.
    let counts = tally("golden-secant", &GoldenSecant::default());
    assert_eq!(counts.len(), 10);
    assert!(
        counts
            .iter()
            .all(|((_, verdict), count)| *verdict == Verdict::Right && *count == 45)
    );
}

#[test]
fn fixed_steps_miss_grazes_and_bounding_circles_are_early() {
    let fixed = tally("fixed-step", &FixedStep::default());
    assert!(fixed[&("grazing".to_owned(), Verdict::Missed)] > 0);
    assert_eq!(fixed[&("generic".to_owned(), Verdict::Right)], 45);
    assert!(
        fixed
            .keys()
            .all(|(_, verdict)| matches!(verdict, Verdict::Right | Verdict::Missed))
    );
    let circles = tally("circles", &BoundingCircles);
    // All 41 contacts of `generic` are early, and 4 pairs whose circles meet never touch.
    assert_eq!(circles[&("generic".to_owned(), Verdict::Early)], 41);
    assert_eq!(circles[&("generic".to_owned(), Verdict::False)], 4);
}

fn detectors() -> [(&'static str, Box<dyn Detection>); 4] {
    [
        ("exact", Box::new(Exact::default())),
        ("golden-secant", Box::new(GoldenSecant::default())),
        ("bounding-circles", Box::new(BoundingCircles)),
        (
            "fixed-step",
            Box::new(FixedStep {
                step: 1e-2,
                ..FixedStep::default()
            }),
        ),
    ]
}

#[test]
fn exchanging_the_bodies_changes_no_bit() {
    let all = all();
    for (name, detector) in detectors() {
        for encounter in &all {
            let horizon = encounter.window_end.unwrap();
            let pair = pair(encounter);
            let exchanged = Pair {
                a: pair.b,
                b: pair.a,
                motion: pair.motion.exchanged(),
            };
            let mut other = ask(&*detector, &exchanged, horizon).outcome;
            if let Outcome::Contact(contact) = &mut other {
                contact.touch = contact.touch.exchanged();
            }
            let one = ask(&*detector, &pair, horizon).outcome;
            assert_eq!(one, other, "{name}, {} {}", encounter.class, encounter.id);
        }
    }
}

#[test]
fn velocities_times_a_power_of_two_give_the_same_bits() {
    let all = all();
    for (name, detector) in detectors() {
        for encounter in &all {
            let horizon = encounter.window_end.unwrap();
            let answer = ask(&*detector, &pair(encounter), horizon);
            for factor in [2f64.powi(20), 2f64.powi(-20)] {
                let mut faster = encounter.clone();
                faster.motions = encounter.motions.map(|motion| Motion {
                    velocity: motion.velocity * factor,
                    angular_velocity: motion.angular_velocity * factor,
                    ..motion
                });
                let mut scaled = ask(&*detector, &pair(&faster), horizon / factor);
                if let Outcome::Contact(contact) = &mut scaled.outcome {
                    contact.time *= factor;
                }
                assert_eq!(
                    answer, scaled,
                    "{name} × {factor}, {} {}",
                    encounter.class, encounter.id
                );
            }
        }
    }
}

/// Bodies of atoms, edges and ellipses with known first contacts, to the double at which each was
/// computed in binary128 by another program: `class,id` of all that differ by more than 1e-9 of the
/// window.
#[test]
fn bodies_with_edges_and_ellipses_meet_at_the_known_times() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/encounters-shapes.csv");
    let all = encounters::read(&file).unwrap();
    assert_eq!(all.len(), 587);
    let is_wrong = |encounter: &&EncounterRecord| {
        let window = encounter.window_end.unwrap();
        let found = ask(&Exact::default(), &pair(encounter), window).outcome;
        match (encounter.expected.unwrap(), found) {
            (ExpectedAnswer::Free, Outcome::Free) => false,
            (ExpectedAnswer::Contact { time, .. }, Outcome::Contact(found)) => {
                (found.time - time).abs() > 1e-9 * window
            }
            _ => true,
        }
    };
    let wrong: Vec<String> = all
        .iter()
        .filter(is_wrong)
        .map(|encounter| format!("{}/{}", encounter.class, encounter.id))
        .collect();
    assert!(wrong.is_empty(), "{wrong:?}");
}
