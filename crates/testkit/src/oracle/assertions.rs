//! What tests of the detectors assert of one encounter: that an answer keeps the guarantee of the
//! exact detector, and that two oracles agree.

use carom_detection::{
    Answer, Exact, Touch,
    encounters::{Class, Encounter},
};

use super::{BigFloat, DoubleDouble, ExclusionReference, Judgement, Number, Oracle, OracleVerdict};

/// The answer of the exact detector to a case of a class, and the judgement of the oracle; `None`
/// for the judgement if the oracle cannot decide.
///
/// # Panics
/// If the answer is wrong.
pub fn assert_guarantee(
    oracle: Oracle,
    (class, seed, index): (Class, u64, u64),
) -> (Answer, Option<Judgement>) {
    let encounter = Encounter::draw(class, seed, index);
    let answer = encounter.first_contact(&Exact::default());
    let reference = oracle.first_contact::<DoubleDouble>(&encounter);
    let judgement = reference.judge(&encounter, &answer);
    if let Some(judgement) = &judgement {
        let kept = matches!(
            judgement.verdict,
            OracleVerdict::Right | OracleVerdict::Graze | OracleVerdict::FreeUntil
        );
        assert!(
            kept,
            "{class} {index}: {judgement:?}, {answer:?}, {reference:?}, {encounter:?}"
        );
    }
    (answer, judgement)
}

/// The parts of the first deep contact of an encounter, if both oracles find one.
///
/// # Panics
/// If the oracle in double-double arithmetic and that at 200 bits differ.
pub fn assert_agreement(oracle: Oracle, encounter: &Encounter, name: &str) -> Option<Touch> {
    let one = oracle.first_contact::<DoubleDouble>(encounter);
    let other = oracle.first_contact::<BigFloat>(encounter);
    match (&one, &other) {
        (ExclusionReference::Deep(one), ExclusionReference::Deep(other)) => {
            assert_eq!(one.parts, other.parts, "{name}");
            // Angles in double-double arithmetic have an error of 1e-31 radians per radian.
            let scale = encounter.natural_time().max(other.time.value());
            for (one, other) in [(&one.time, &other.time), (&one.touch, &other.touch)] {
                let off = BigFloat::new(one.value()).minus(other).value()
                    + one.minus(&DoubleDouble::new(one.value())).value();
                assert!(
                    off.abs() < 1e-20 * scale,
                    "{name}: off by {off:e} of {scale:e}"
                );
            }
            Some(one.parts)
        }
        (ExclusionReference::Free, ExclusionReference::Free)
        | (ExclusionReference::Unresolved, _)
        | (_, ExclusionReference::Unresolved) => None,
        _ => panic!("{name}: {one:?} and {other:?}"),
    }
}
