//! Advice from the results: for each family of settings its fastest one, with the time saved and
//! the errors.

use super::{
    knobs::{FAMILIES, MODEL},
    measures::{Mean, relative},
    results::{SceneResult, SettingResult},
};

/// Times within this relative difference count as equal, the resolution of medians of short runs.
const EQUAL: f64 = 0.03;

/// Effective errors within this factor count as equal, the resolution of a few starts.
const COARSER: f64 = 30.0;

/// Sentences for one scene.
pub fn sentences(result: &SceneResult) -> Vec<String> {
    let exact = &result.found[0];
    let mut sentences = vec![free_of_error(result)];
    for (family, name) in FAMILIES.iter().enumerate() {
        let own =
            result.found.iter().filter(|found| found.setting.family == family && !found.setting.is_exact());
        let fastest = own.filter_map(|found| Some((found.time?, found))).min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((time, found)) = fastest {
            sentences.push(format!(
                "{name}: the fastest setting without the exact guarantee, {}, {}{}",
                found.setting.name,
                speed(time),
                price(found, exact)
            ));
        }
    }
    sentences
}

/// Sentence on the fastest setting without wrong contacts.
fn free_of_error(result: &SceneResult) -> String {
    let exact = &result.found[0];
    let right = result.found.iter().filter(|found| {
        found.setting.family != MODEL
            && found.tally.judged > 0
            && found.tally.wrong() == 0.0
            && found.physics.overlapping == 0
    });
    let fastest = right.filter_map(|found| Some((found.time?, found))).min_by(|a, b| a.0.total_cmp(&b.0));
    match fastest {
        Some((time, found)) if time < 1.0 - EQUAL => format!(
            "Of the settings without a wrong contact (fewer than {:.0} in a million, 95 %), {} is the \
             fastest: {:.2} times the time of the default.",
            exact.tally.upper_bound_of_none(),
            found.setting.title(),
            time
        ),
        _ => format!(
            "No setting without a wrong contact (fewer than {:.0} in a million, 95 %) is faster than the \
             default by more than {:.0} %: exactness has no cost here.",
            exact.tally.upper_bound_of_none(),
            100.0 * EQUAL
        ),
    }
}

fn speed(time: f64) -> String {
    if time < 1.0 - EQUAL {
        format!("saves {:.0} % of the time", 100.0 * (1.0 - time))
    } else if time <= 1.0 + EQUAL {
        "takes the same time".to_owned()
    } else {
        format!("takes {time:.1} times as long")
    }
}

fn price(found: &SettingResult, exact: &SettingResult) -> String {
    let mut prices = Vec::new();
    if found.setting.family != MODEL && found.tally.wrong() > 0.0 {
        prices.push(format!("{:.0} contacts in a million are wrong", found.tally.wrong()));
    }
    if found.physics.overlapping > 0 {
        prices.push(format!(
            "up to {} pairs overlap, the deepest by {:.1e} of a diameter",
            found.physics.overlapping, found.physics.deepest
        ));
    }
    if let (Some(own), Some(best)) = (found.effective, exact.effective)
        && own.value > COARSER * best.value
    {
        let bound = if own.at_least { "at least " } else { "" };
        prices.push(format!(
            "the effective error is {bound}{:.0e} of a side, not {:.0e}",
            own.value, best.value
        ));
    }
    let seen = |mean: Option<Mean>| mean.filter(|mean| mean.value.abs() > 3.0 * mean.error);
    let physics = [
        ("the pressure", relative(found.physics.pressure, exact.physics.pressure)),
        ("the collision rate", relative(found.physics.rate, exact.physics.rate)),
        ("the slope of the velocity autocorrelation", relative(found.physics.slope, exact.physics.slope)),
    ];
    for (name, mean) in physics {
        if let Some(mean) = seen(mean) {
            prices.push(format!(
                "{name} deviates by {:+.2} % (± {:.2} %)",
                100.0 * mean.value,
                100.0 * mean.error
            ));
        }
    }
    if let Some(mean) = seen(found.physics.share_difference(&exact.physics)) {
        prices.push(format!("a share of hits deviates by {:.3} (± {:.3})", mean.value, mean.error));
    }
    if let Some(error) = &found.physics.broke_off {
        prices.push(format!("the run fails ({error})"));
    }
    if found.physics.blocks == 0 {
        prices.push("the physics was not measured because it takes too long".to_owned());
    }
    if prices.is_empty() {
        ", without a measurable error.".to_owned()
    } else {
        format!("; {}.", prices.join("; "))
    }
}
