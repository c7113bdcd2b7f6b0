//! The advice: what to take and what the largest saving costs, with numbers from the tables.

use super::{
    knobs::FAMILIES,
    results::{KnobResult, SceneResult},
    table::{self, SEEN},
};

/// Times within this relative difference count as equal, however small their errors.
const EQUAL: f64 = 0.03;

/// Relative difference that a single round resolves: it has no scatter of its own.
const SINGLE: f64 = 0.2;

/// The exact run is also timed against itself. A difference is not seen below so many times the
/// deviation of that ratio from 1.
const AGAINST_ITSELF: f64 = 2.0;

/// Effective errors within this factor count as equal, the resolution of a few starts.
const COARSER: f64 = 30.0;

/// Whether a setting is faster than the exact run by more than its time resolves.
fn is_faster(found: &KnobResult, exact: &KnobResult) -> bool {
    found
        .time
        .is_some_and(|time| time.median < 1.0 - resolution(found, exact))
}

/// Relative difference of the times of a setting and of the exact run that is seen.
fn resolution(found: &KnobResult, exact: &KnobResult) -> f64 {
    let scatter = found
        .time
        .and_then(|time| time.standard_error())
        .map_or(SINGLE, |error| SEEN * error);
    let against_itself = exact
        .time
        .map_or(0.0, |time| AGAINST_ITSELF * (time.median - 1.0).abs());
    EQUAL.max(scatter).max(against_itself)
}

/// Whether contacts of a setting were judged, and none was wrong.
fn is_right(found: &KnobResult) -> bool {
    found.tally.judged > 0
        && found.tally.wrong() == 0.0
        && found.physics.overlapping == 0
        && !found.knob.is_model()
}

/// What to do in this scene, in one or two sentences.
pub fn advice(result: &SceneResult) -> String {
    let exact = result.exact();
    if exact.tally.judged == 0 {
        return "No contact was met in the time allowed, so that nothing could be compared: give more \
                --minutes or a scene with contacts."
            .to_owned();
    }
    let seen = || compared(result).filter(|found| is_faster(found, exact));
    let right = fastest(seen().filter(|found| is_right(found)));
    let kept = match right {
        Some((_, found)) => format!(
            "Take ‘{}’ ({}; {}): it takes {} of the time of the exact run, and of its {} contacts none is wrong ({} in a \
             million at 95 %){}.",
            found.knob.name,
            FAMILIES[found.knob.family],
            found.knob.how(),
            table::time(found),
            found.tally.judged,
            table::wrong(found),
            if found.knob.setting.is_exact() {
                ""
            } else {
                "; that it is right is not proved"
            }
        ),
        None => keep(result),
    };
    let wrong = fastest(seen().filter(|found| !is_right(found)));
    let saved = match wrong {
        Some((ratio, found)) if ratio < right.map_or(1.0, |right| right.0) => {
            let family = FAMILIES[found.knob.family];
            let (name, how) = (&found.knob.name, found.knob.how());
            format!(
                "‘{name}’ ({family}; {how}) saves most, at a price: {}.",
                price(found, exact)
            )
        }
        _ if right.is_none() => return kept,
        _ => "No other setting saves more.".to_owned(),
    };
    format!("{kept} {saved}")
}

/// The settings other than the exact run of which both time and contacts were measured.
fn compared(result: &SceneResult) -> impl Iterator<Item = &KnobResult> {
    result.found[1..]
        .iter()
        .filter(|found| found.tally.judged > 0 && found.time.is_some())
}

/// The words on the exact run where no setting without a wrong contact is seen to be faster.
fn keep(result: &SceneResult) -> String {
    let exact = result.exact();
    let contacts = format!(
        "of {} contacts none is wrong ({} in a million at 95 %)",
        exact.tally.judged,
        table::wrong(exact)
    );
    // The most that a setting may save: the lower bound of its time is that far below 1.
    let saved = |found: &KnobResult| {
        let time = found.time.map_or(1.0, |time| time.median);
        (1.0 - (time - resolution(found, exact))).min(1.0)
    };
    let right = compared(result).filter(|found| is_right(found));
    let savings: Vec<f64> = right.map(saved).collect();
    if savings.is_empty() {
        let number = match compared(result).count() {
            0 => "no other setting was compared in the time allowed".to_owned(),
            1 => "the only other setting compared has wrong ones".to_owned(),
            some => format!("none of the {some} other settings compared is free of wrong ones"),
        };
        return format!("Keep the exact run: {contacts}; {number}. More --minutes compare more.");
    }
    let most = savings.iter().copied().fold(EQUAL, f64::max);
    format!(
        "Keep the exact run: {contacts}, and no setting without a wrong contact is faster by more than {:.0} %{}.",
        100.0 * most,
        if most > EQUAL {
            ", as far as the times resolve"
        } else {
            ""
        }
    )
}

fn fastest<'a>(found: impl Iterator<Item = &'a KnobResult>) -> Option<(f64, &'a KnobResult)> {
    found
        .filter_map(|found| Some((found.time?.median, found)))
        .min_by(|a, b| a.0.total_cmp(&b.0))
}

/// For each family of settings without the exact guarantee, its fastest one.
pub fn of_families(result: &SceneResult) -> Vec<String> {
    let exact = result.exact();
    let of_family = |(family, name): (usize, &&str)| {
        let own = result.found.iter().filter(|found| {
            found.knob.family == family && !found.knob.setting.is_exact() && found.tally.judged > 0
        });
        let (_, found) = fastest(own)?;
        Some(format!(
            "{name}: the fastest setting is {}: {}.",
            found.knob.name,
            price(found, exact)
        ))
    };
    FAMILIES.iter().enumerate().filter_map(of_family).collect()
}

/// Time and errors of a setting.
fn price(found: &KnobResult, exact: &KnobResult) -> String {
    let mut prices = vec![
        format!("{} of the time of the exact run", table::time(found)),
        format!("{} contacts in a million wrong", table::wrong(found)),
    ];
    let overlapping = found.tally.overlapping.max(found.physics.overlapping);
    if overlapping > 0 {
        prices.push(format!(
            "overlaps up to {} of a diameter",
            table::deepest(found)
        ));
    }
    if let (Some(own), Some(best)) = (found.effective, exact.effective)
        && own.value > COARSER * best.value
    {
        let errors = [table::effective(found), table::effective(exact)];
        prices.push(format!(
            "an effective error of {} of a side, not {}",
            errors[0], errors[1]
        ));
    }
    if let Some(worst) = table::worst(found, exact) {
        prices.push(format!(
            "{} off by {}",
            worst.name,
            table::difference(&worst)
        ));
    }
    prices.join(", ")
}

#[cfg(test)]
mod tests {
    use carom_runs::price::{ReplayTally, TimeRatio};

    use super::*;
    use crate::trade::knobs::{self, Knob};

    /// The exact run and the portable instructions, with the times of their rounds.
    fn result(exact: &[f64], portable: &[f64]) -> SceneResult {
        let tally = ReplayTally {
            intervals: 10,
            judged: 1000,
            ..ReplayTally::default()
        };
        let found = |knob: Knob, rounds: &[f64]| KnobResult {
            time: TimeRatio::new(rounds.to_vec()),
            tally,
            ..KnobResult::new(knob)
        };
        let portable_knob = Knob {
            name: "portable".to_owned(),
            family: 4,
            ..knobs::exact()
        };
        SceneResult {
            name: "planted".to_owned(),
            moving: 10,
            nanoseconds: 100.0,
            rate: 1.0,
            stretch: 1.0,
            tau: 1.0,
            span: [0.0, 1.0],
            states: 10,
            irreversible: None,
            left_out: Vec::new(),
            notes: Vec::new(),
            found: vec![found(knobs::exact(), exact), found(portable_knob, portable)],
        }
    }

    #[test]
    fn a_setting_is_advised_only_if_it_is_faster_by_more_than_the_errors_of_the_times() {
        let quiet = [0.999, 1.0, 1.001];
        for (exact, portable, is_advised) in [
            (&quiet, &[0.79, 0.80, 0.81][..], true),
            // Too small a difference.
            (&quiet, &[0.979, 0.98, 0.981], false),
            // Scattered rounds.
            (&quiet, &[0.8, 0.95, 1.2], false),
            // The exact run against itself shows as much.
            (&[0.88, 0.89, 0.90], &[0.90, 0.91, 0.92], false),
            // A single round: a small difference, and a large one.
            (&quiet, &[0.9], false),
            (&quiet, &[0.5], true),
        ] {
            let result = result(exact, portable);
            let advice = advice(&result);
            assert_eq!(
                advice.starts_with("Take ‘portable’"),
                is_advised,
                "{portable:?}: {advice}"
            );
        }
    }

    /// A slow setting whose time is uncertain by more than that of the exact run is still slow.
    #[test]
    fn the_saving_that_is_not_excluded_is_that_of_the_lower_bound_of_a_time() {
        let slow = advice(&result(&[0.999, 1.0, 1.001], &[10.0, 12.0, 14.0]));
        assert!(slow.ends_with("is faster by more than 3 %."), "{slow}");
        let unsure = advice(&result(&[0.999, 1.0, 1.001], &[0.88, 0.98, 1.08]));
        let percent = unsure
            .split("by more than ")
            .nth(1)
            .and_then(|rest| rest.split(' ').next());
        let percent: f64 = percent.unwrap().parse().unwrap();
        assert!(
            (5.0..=40.0).contains(&percent) && unsure.contains("as far as"),
            "{unsure}"
        );
        let hopeless = advice(&result(&[0.999, 1.0, 1.001], &[0.2, 1.0, 30.0]));
        assert!(
            hopeless.contains("by more than 100 %, as far as"),
            "{hopeless}"
        );
    }

    #[test]
    fn nothing_is_claimed_of_settings_that_were_not_compared() {
        let none = advice(&result(&[], &[]));
        assert!(
            none.contains("of 1000 contacts none is wrong")
                && none.contains("no other setting was compared"),
            "{none}"
        );
        assert!(
            !none.contains("faster") && !none.contains("No other setting saves more"),
            "{none}"
        );
    }
}
