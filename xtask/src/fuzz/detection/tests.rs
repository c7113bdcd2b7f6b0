//! Tests of the detection fuzzer: it finds planted faults of a detector.

use carom_detection::{Answer, Contact, Detection, Exact, Outcome};
use carom_geometry::Outline;
use carom_kinematics::RelativeMotion;

use super::*;
use crate::fuzz::{
    campaign,
    random::case_seed,
    worker::{InProcess, Runner as _},
};

/// Fault in some answers of the exact detector.
#[derive(Debug, Clone, Copy)]
enum Fault {
    Lost,
    /// Relative delay.
    Late(f64),
    Early(f64),
    NotANumber,
    Panic,
}

/// The exact detector with a fault in one contact in `one_in`.
#[derive(Debug, Clone)]
struct Faulty {
    fault: Fault,
    one_in: u64,
}

impl Detection for Faulty {
    fn first_contact(
        &self,
        a: Outline<'_>,
        b: Outline<'_>,
        motion: &RelativeMotion,
        horizon: f64,
    ) -> Answer {
        let answer = Exact::default().first_contact(a, b, motion, horizon);
        let Outcome::Contact(contact) = answer.outcome else {
            return answer;
        };
        let key = contact.time.to_bits().wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 20;
        if !key.is_multiple_of(self.one_in) {
            return answer;
        }
        let at = |time: f64| Outcome::Contact(Contact { time, ..contact });
        let outcome = match self.fault {
            Fault::Lost => Outcome::Free,
            Fault::Late(share) => at((contact.time * (1.0 + share)).min(horizon)),
            Fault::Early(share) => at(contact.time * (1.0 - share)),
            Fault::NotANumber => at(f64::NAN),
            Fault::Panic => panic!("planted"),
        };
        Answer { outcome, ..answer }
    }
}

/// The first failure among `cases` cases.
fn first_failure(fault: Fault, one_in: u64, cases: u64) -> Option<(DetectionCase, String)> {
    let subject = Queries {
        detector: Faulty { fault, one_in },
    };
    let mut runner = InProcess(subject.clone());
    (0..cases).find_map(|index| {
        let seed = case_seed(2026, index);
        let failure = runner.run_seed(seed).unwrap().failure?;
        // Known failures without the planted fault are not counted.
        let known = Queries::<Exact>::default()
            .check(&subject.draw(seed))
            .failure;
        known.is_none().then(|| (subject.draw(seed), failure.kind))
    })
}

#[test]
fn one_lost_contact_in_a_thousand_is_found() {
    let (case, kind) = first_failure(Fault::Lost, 1000, 20_000).expect("a lost contact is found");
    assert!(
        ["missed", "exchange", "power of two", "free without proof"].contains(&&kind[..]),
        "{kind}: {case:?}"
    );
}

#[test]
fn contacts_that_are_late_or_early_are_found() {
    for (fault, kinds) in [
        (Fault::Late(1e-9), ["late", "false contact"]),
        (Fault::Early(1e-9), ["early", "false contact"]),
        (Fault::NotANumber, ["time out of range", "NaN"]),
        (Fault::Panic, ["panic", "panic"]),
    ] {
        let (_, kind) = first_failure(fault, 1, 500).expect("found");
        assert!(kinds.contains(&&kind[..]), "{fault:?}: {kind}");
    }
}

#[test]
fn a_failing_query_is_minimised_and_replayed() {
    let subject = Queries {
        detector: Faulty {
            fault: Fault::Late(1e-6),
            one_in: 1,
        },
    };
    let mut runner = InProcess(subject.clone());
    let out = tempfile::tempdir().unwrap();
    let seed = (0..500)
        .map(|index| case_seed(3, index))
        .find(|&seed| {
            runner
                .run_seed(seed)
                .unwrap()
                .failure
                .is_some_and(|failure| failure.kind == "late")
        })
        .expect("a late contact is found");
    campaign::run_only(&subject, &mut runner, seed, out.path()).unwrap();
    let file = out.path().join(format!("detection-{seed}.toml"));
    let findings = campaign::replay::<Queries<Faulty>>(&mut runner, &file).unwrap();
    assert_eq!(findings.failures[0].1.kind, "late");
    // The unmodified detector passes the minimised query.
    let findings =
        campaign::replay::<Queries>(&mut InProcess(Queries::<Exact>::default()), &file).unwrap();
    assert!(findings.failures.is_empty(), "{findings:?}");
}

#[test]
fn cases_are_a_function_of_their_seed_and_keep_their_bits_in_a_file() {
    let subject = Queries::<Exact>::default();
    for seed in 0..200 {
        let case = subject.draw(seed);
        let (ending, bytes) = subject.write(&case);
        let read = subject.read(&ending, &bytes).unwrap();
        // NaN differs from itself; its text does not.
        assert_eq!(subject.write(&read).1, bytes);
        assert_eq!(subject.write(&subject.draw(seed)).1, bytes);
    }
}
