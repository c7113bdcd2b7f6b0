//! Recorded searches: the same answers as unrecorded ones, and certified times without holes.

#![cfg(feature = "encounters")]

use carom_detection::{
    BoundingCircles, Exact, FixedStep, GoldenSecant, Outcome, Parts, SearchStep,
    encounters::{Class, Encounter},
};
use carom_geometry::Molecule;

/// Five pairs of each class.
fn pairs() -> impl Iterator<Item = (String, Encounter)> {
    Class::ALL.into_iter().flat_map(|class| {
        (0..5).map(move |index| {
            (
                format!("{class} {index}"),
                Encounter::draw(class, 32, index),
            )
        })
    })
}

/// Whether the search of all atom pairs is fast and recorded from the begin.
fn has_few_atoms(pair: &Encounter) -> bool {
    pair.molecules
        .iter()
        .map(|molecule| molecule.atoms().len())
        .product::<usize>()
        <= 64
}

#[test]
fn a_recorded_search_gives_the_answer_of_the_detector_to_the_bit() {
    // Fast rotors with edges take other detectors millions of evaluations.
    let is_slow = |name: &str| name.starts_with("edged_fast");
    let pairs = pairs().filter(|(name, pair)| has_few_atoms(pair) && !is_slow(name));
    for (name, pair) in pairs {
        let [a, b] = pair.molecules.each_ref().map(Molecule::outline);
        let (exact, golden) = (Exact::default(), GoldenSecant::default());
        let coarse = FixedStep {
            step: 0.05,
            ..FixedStep::default()
        };
        let traces = [
            (
                exact.trace(a, b, &pair.motion, pair.horizon),
                pair.first_contact(&exact),
            ),
            (
                golden.trace(a, b, &pair.motion, pair.horizon),
                pair.first_contact(&golden),
            ),
            (
                coarse.trace(a, b, &pair.motion, pair.horizon),
                pair.first_contact(&coarse),
            ),
            (
                BoundingCircles.trace(a, b, &pair.motion, pair.horizon),
                pair.first_contact(&BoundingCircles),
            ),
        ];
        for (trace, answer) in traces {
            // Debug prints every bit, and NaN equals itself.
            assert_eq!(
                format!("{:?}", trace.answer),
                format!("{answer:?}"),
                "{name}"
            );
        }
    }
}

#[test]
fn the_last_step_of_the_touching_parts_is_the_contact() {
    let mut contacts = 0;
    for (name, pair) in pairs() {
        let [a, b] = pair.molecules.each_ref().map(Molecule::outline);
        let exact = Exact::default().trace(a, b, &pair.motion, pair.horizon);
        if let Some(contact) = exact.answer.outcome.contact() {
            let last = exact
                .steps
                .iter()
                .rfind(|step| step.parts == Parts::Pair(contact.touch));
            assert_eq!(last.unwrap().free_until, Some(contact.time), "{name}");
            contacts += 1;
        }
        if !has_few_atoms(&pair) {
            continue;
        }
        let golden = GoldenSecant::default().trace(a, b, &pair.motion, pair.horizon);
        if let Some(contact) = golden.answer.outcome.contact() {
            let evaluated = |step: &SearchStep| {
                step.parts == Parts::Pair(contact.touch)
                    && step.time.to_bits() == contact.time.to_bits()
            };
            assert!(golden.steps.iter().any(evaluated), "{name}");
            let segment = golden.segments.last().unwrap();
            assert!(
                (segment.begin..=segment.end).contains(&contact.time),
                "{name}"
            );
        }
    }
    assert!(contacts > 40, "{contacts}");
}

#[test]
fn the_certified_steps_cover_all_time_up_to_the_contact() {
    for (name, pair) in pairs() {
        let [a, b] = pair.molecules.each_ref().map(Molecule::outline);
        let trace = Exact::default().trace(a, b, &pair.motion, pair.horizon);
        let end = match trace.answer.outcome {
            Outcome::Contact(contact) => contact.time,
            Outcome::FreeUntil(time) => time,
            _ => pair.horizon,
        };
        let Some(window) = trace.window else { continue };
        // At most eight atoms of each body.
        let some = |count: usize| (0..count as u32).step_by(count.div_ceil(8).max(1));
        for i in some(a.atoms.len()) {
            for j in some(b.atoms.len()) {
                let mut covered = window.begin;
                let mut steps: Vec<&SearchStep> = trace
                    .steps
                    .iter()
                    .filter(|step| step.parts.contain(i, j))
                    .collect();
                steps.sort_by(|one, other| one.time.total_cmp(&other.time));
                for step in steps {
                    if step.time <= covered {
                        covered = covered.max(step.free_until.unwrap_or(covered));
                    }
                }
                let end = end.min(window.end);
                assert!(
                    covered >= end,
                    "{name}, atoms {i} {j}: hole at {covered} before {end}"
                );
            }
        }
    }
}
