//! The exact detector against an oracle in double-double arithmetic on encounters of bodies with
//! straight edges that turn, and this oracle against another with 200 bits.

use carom_detection::{
    Answer, Contact, Exact, Outcome, Part, Touch,
    encounters::{Class, Encounter},
};
use carom_geometry::gap_between;
use carom_kinematics::Orientation;
use carom_testkit::oracle::{
    DoubleDouble, Oracle, OracleVerdict, assert_agreement, assert_guarantee,
};

const SEED: u64 = 20_170;

fn classes() -> impl Iterator<Item = Class> {
    Class::ALL.into_iter().filter(|class| class.has_edges())
}

fn is_of_edge(touch: Touch) -> bool {
    matches!(touch, Touch::EdgeOfA { .. } | Touch::EdgeOfB { .. })
}

#[test]
fn exact_satisfies_its_guarantee_on_all_classes_with_edges() {
    let oracle = Oracle {
        most_intervals: 300_000,
    };
    let [mut judged, mut undecided, mut edges, mut atoms] = [0; 4];
    for class in classes() {
        let count = if class == Class::EdgedFast { 40 } else { 150 };
        let mut deviations = Vec::new();
        for index in 0..count {
            let (answer, judgement) = assert_guarantee(oracle, (class, SEED, index));
            match answer.outcome.contact() {
                Some(contact) if is_of_edge(contact.touch) => edges += 1,
                Some(_) => atoms += 1,
                None => {}
            }
            let Some(judgement) = judgement else {
                undecided += 1;
                continue;
            };
            judged += 1;
            deviations.extend(judgement.deviation);
        }
        deviations.sort_by(f64::total_cmp);
        let median = deviations[deviations.len() / 2];
        eprintln!("{class}: median |Δt| {median:e} natural times");
        assert!(median < 1e-9, "{class}: median |Δt| {median:e}");
    }
    eprintln!("{judged} judged, {undecided} undecided, {edges} edges, {atoms} atoms");
    assert!(
        judged > 2900 && undecided < 20 && edges > 1500 && atoms > 300,
        "{judged}, {undecided}, {edges}, {atoms}"
    );
}

/// The overlap of bodies takes account of edges that cross and of bodies in one another, which the
/// pairs of atoms and edges do not show.
#[test]
fn bodies_do_not_overlap_before_their_contacts() {
    let samples = 100;
    for class in classes() {
        for index in 0..40 {
            let encounter = Encounter::draw(class, SEED + 1, index);
            let end = match encounter.first_contact(&Exact::default()).outcome {
                Outcome::Contact(contact) => contact.time,
                Outcome::FreeUntil(time) => time,
                _ => encounter.horizon,
            };
            let motion = &encounter.motion;
            let [a, b] = &encounter.molecules;
            let rounding = 1e-13 * (encounter.size() + motion.separation.length());
            // A wall or a body may cross another between the samples, and leave it.
            for sample in 0..=samples {
                let time = end * f64::from(sample) / f64::from(samples);
                let [turn_a, turn_b] = [0, 1].map(|body: usize| {
                    let spin = motion.angular_velocity[body];
                    let turned: Orientation = motion.orientation[body].turned(spin, time);
                    turned.cos_sin()
                });
                let separation = motion.separation + motion.velocity * time;
                let gap = gap_between(a, turn_a, b, turn_b, separation);
                let spins = motion.angular_velocity.map(f64::abs);
                let turning = 1e-15 * (spins[0] + spins[1]) * time * encounter.size();
                assert!(
                    gap > -rounding - turning,
                    "{class} {index}: gap {gap:e} at {time:e} of {end:e}"
                );
            }
        }
    }
}

#[test]
fn the_oracle_of_edges_agrees_with_another_at_200_bits() {
    let oracle = Oracle {
        most_intervals: 5_000,
    };
    let mut contacts = 0;
    for class in classes() {
        for index in 0..2 {
            let encounter = Encounter::draw(class, SEED, index);
            let counts = encounter
                .molecules
                .each_ref()
                .map(|body| body.atoms().len());
            if counts[0] * counts[1] > 16 {
                continue;
            }
            let touch = assert_agreement(oracle, &encounter, &format!("{class} {index}"));
            contacts += u32::from(touch.is_some_and(is_of_edge));
        }
    }
    assert!(contacts > 10, "{contacts} contacts compared");
}

/// The corner of a touch with the next number, which does not touch.
fn next_part(touch: Touch, encounter: &Encounter) -> Touch {
    let next = |part, body: usize| match part {
        Part::Atom(index) => {
            let count = encounter.molecules[body].atoms().len() as u32;
            Part::Atom((index + 1) % count)
        }
        Part::BoundingCircle => part,
    };
    match touch {
        Touch::EdgeOfA { edge, part } => Touch::EdgeOfA {
            edge,
            part: next(part, 1),
        },
        Touch::EdgeOfB { edge, part } => Touch::EdgeOfB {
            edge,
            part: next(part, 0),
        },
        Touch::Atoms(..) | Touch::BoundingCircles => touch,
    }
}

#[test]
fn the_oracle_of_edges_distinguishes_wrong_answers_from_right_ones() {
    let oracle = Oracle::default();
    let mut seen = 0;
    for class in [Class::Squares, Class::Capsules, Class::Polygons] {
        for index in 0..30 {
            let encounter = Encounter::draw(class, SEED, index);
            let answer = encounter.first_contact(&Exact::default());
            let Some(contact) = answer.outcome.contact() else {
                continue;
            };
            if !is_of_edge(contact.touch) {
                continue;
            }
            seen += 1;
            let reference = oracle.first_contact::<DoubleDouble>(&encounter);
            let verdict = |outcome| {
                let answer = Answer {
                    outcome,
                    evaluations: 0,
                };
                let judgement = reference.judge(&encounter, &answer);
                judgement.expect("the oracle has an answer").verdict
            };
            let at = |time: f64| Outcome::Contact(Contact { time, ..contact });
            let shift = 1e-6 * encounter.natural_time();
            let (early, late) = (contact.time - shift, contact.time + shift);
            let touch = next_part(contact.touch, &encounter);
            for (outcome, expected) in [
                (at(contact.time), OracleVerdict::Right),
                (at(early), OracleVerdict::Early),
                (at(late), OracleVerdict::Late),
                (Outcome::Free, OracleVerdict::Missed),
                (Outcome::FreeUntil(early), OracleVerdict::FreeUntil),
                (Outcome::FreeUntil(late), OracleVerdict::Missed),
                (
                    Outcome::Contact(Contact { touch, ..contact }),
                    OracleVerdict::Early,
                ),
            ] {
                assert_eq!(verdict(outcome), expected, "{class} {index}: {outcome:?}");
            }
        }
    }
    assert!(seen > 30, "{seen}");
}
