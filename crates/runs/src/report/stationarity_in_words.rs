//! Figures that changed during their measurement, in words.

use std::cmp::Reverse;

use carom_tables::{Figure, Stationarity, two_digits, with_error};

use super::tests_in_words::with_place;

/// Beginning of the name of the collision rate, which every run measures.
const OF_EVERY_RUN: &str = "collisions per";

/// A mean of fewer standard errors is 0 as far as is known: a change is no share of it.
const CLEAR: f64 = 3.0;

/// Whether a mean changed during its measurement; `None` if that was not judged, or if its blocks
/// are too short for an error: what a body has not yet forgotten would seem to be a change.
pub fn judged(figure: &Figure) -> Option<Stationarity> {
    figure
        .stationarity
        .filter(|_| figure.standard_error.is_some())
}

/// Whether a figure is one that every run measures, asked for or not.
pub(super) fn is_of_every_run(figure: &Figure) -> bool {
    figure.name.starts_with(OF_EVERY_RUN)
}

/// Whether a mean changes until the end of the measurement: the state decays or is driven, or the
/// run is too short, and no mean describes it.
pub(super) fn never_settles(figures: &[Figure]) -> bool {
    let found = figures.iter().filter_map(judged);
    found
        .filter(|found| !found.is_stationary)
        .any(|found| found.settled_at.is_none())
}

/// The amount of a change: a share of the mean, or a number where the mean is 0 or smaller than the
/// change.
fn amount(figure: &Figure, change: f64) -> String {
    let share = (change / figure.value).abs();
    // A quantity that decays changes by more than its mean.
    if share < 1.0 {
        return format!("{} %", with_error(two_digits(100.0 * share), None));
    }
    let amount = with_error(two_digits(change.abs()), None);
    let unit = match figure.unit.as_str() {
        "1" => String::new(),
        unit => format!(" {unit}"),
    };
    let error = figure.standard_error.unwrap_or(0.0);
    let is_zero = figure.prediction == Some(0.0) || figure.value.abs() <= CLEAR * error;
    if is_zero {
        return format!("{amount}{unit}");
    }
    let times = with_error(two_digits(share), None);
    format!("{amount}{unit}, {times} times its mean,")
}

/// What changed during the measurement, by how much, and from when on it does not; `None` if
/// nothing did. What the scene asks for is named before what every run measures. Each figure has a
/// word for where it belongs, which may be empty.
pub fn stationarity_in_words(figures: &[(&str, &Figure)]) -> Option<String> {
    let mut changing: Vec<(&str, &Figure, Stationarity)> = figures
        .iter()
        .filter_map(|(place, figure)| Some((*place, *figure, judged(figure)?)))
        .filter(|(.., found)| !found.is_stationary)
        .collect();
    let in_errors = |found: &Stationarity| (found.change / found.standard_error).abs();
    changing.sort_by_key(|(_, figure, found)| {
        let deviation = (1e3 * in_errors(found)) as u64;
        (is_of_every_run(figure), Reverse(deviation))
    });
    let (place, figure, found) = changing.first()?;
    let verb = if found.change < 0.0 { "falls" } else { "rises" };
    let amount = amount(figure, found.change);
    let is_own = |figure: &Figure| judged(figure).is_some() && !is_of_every_run(figure);
    let has_own = figures.iter().any(|(_, figure)| is_own(figure));
    let others = match changing.len() - 1 {
        // The gas around may change while no change of what was asked for is found.
        0 if is_of_every_run(figure) && has_own => "; no other figure changes".to_owned(),
        0 => String::new(),
        1 => "; one more figure changes".to_owned(),
        count => format!("; {count} more figures change"),
    };
    let settled: Option<Vec<f64>> = changing
        .iter()
        .map(|(.., found)| found.settled_at)
        .collect();
    let remedy = settled.map_or_else(
        || {
            "They do not settle within the first half: if the state is driven or decays, its series \
             are the result and not its means; else run longer."
                .to_owned()
        },
        |times| {
            let last = two_digits(times.into_iter().fold(0.0, f64::max));
            format!(
                "From t = {last} on no change is found: set run.measure_from to that, or in a run with [[stage]] \
                 end a first stage with `measure = false` there."
            )
        },
    );
    Some(format!(
        "Not stationary: {} {verb} by {amount} during the measurement, {:.0} standard errors{others}. {remedy}",
        with_place(figure, place),
        in_errors(found)
    ))
}

/// With fewer independent samples a figure is named. Smaller: errors that are too small by a third
/// pass without a note. Larger: notes where errors hold.
const MIN_INDEPENDENT: f64 = 8.0;

/// Most figures that a sentence names; more make it unreadable.
const MAX_NAMED: usize = 3;

/// The figures whose samples are correlated for so long that few of them are independent: their
/// errors may be too small. `None` if there are none.
pub fn few_samples_in_words(figures: &[Figure]) -> Option<String> {
    let few = |figure: &&Figure| {
        let found = judged(figure).filter(|_| figure.standard_error != Some(0.0));
        // Of a mean that changes the change is said, which is more.
        found.is_some_and(|found| found.is_stationary && found.independent_blocks < MIN_INDEPENDENT)
    };
    let names: Vec<&str> = figures
        .iter()
        .filter(few)
        .map(|figure| figure.name.as_str())
        .collect();
    let more = names.len().saturating_sub(MAX_NAMED);
    let named = names[..names.len() - more].join(", ");
    let more = match more {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    (!names.is_empty()).then(|| {
        format!(
            "Fewer than {MIN_INDEPENDENT} independent samples of {named}{more}: they change slowly, and their errors may \
             be too small. Run longer."
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(name: &str, value: f64, change: f64, settled_at: Option<f64>) -> Figure {
        let stationarity = Stationarity {
            is_stationary: change == 0.0,
            change,
            standard_error: 0.01,
            settled_at,
            independent_blocks: 32.0,
            correlation_time: None,
        };
        Figure {
            stationarity: Some(stationarity),
            ..Figure::new(name, value, "energy/length²").error(1e-3)
        }
    }

    #[test]
    fn figures_with_a_long_memory_are_named() {
        let slow = |name: &str, blocks: f64| {
            let mut figure = figure(name, 1.0, 0.0, None);
            let found = figure.stationarity.as_mut().unwrap();
            found.independent_blocks = blocks;
            figure.error(0.1)
        };
        let found = few_samples_in_words(&[slow("order", 3.0), slow("pressure", 40.0)]).unwrap();
        assert!(found.starts_with("Fewer than 8 independent samples of order: they change slowly"));
        assert_eq!(few_samples_in_words(&[slow("pressure", 40.0)]), None);
        let many: Vec<Figure> = (0..5).map(|n| slow(&format!("f{n}"), 2.0)).collect();
        assert!(
            few_samples_in_words(&many)
                .unwrap()
                .contains("f0, f1, f2 and 2 more:")
        );
    }

    fn words(figures: &[Figure]) -> Option<String> {
        stationarity_in_words(
            &figures
                .iter()
                .map(|figure| ("", figure))
                .collect::<Vec<_>>(),
        )
    }

    #[test]
    fn the_clearest_change_is_told_with_the_remedy() {
        let [p, z] = [
            figure("pressure", 9.0, -0.234, Some(12.0)),
            figure("Z", 5.0, 0.06, Some(3.0)),
        ];
        assert_eq!(words(&[figure("kT", 1.0, 0.0, None)]), None);
        assert_eq!(
            words(&[z.clone(), p.clone()]).unwrap(),
            "Not stationary: pressure falls by 2.6 % during the measurement, 23 standard errors; one more figure \
             changes. From t = 12 on no change is found: set run.measure_from to that, or in a run with [[stage]] end \
             a first stage with `measure = false` there."
        );
        let driven = words(&[figure("kT", 0.0, 0.5, None), z, p]).unwrap();
        assert!(
            driven.contains("kT rises by 0.5 energy/length²") && driven.contains("2 more"),
            "{driven}"
        );
        assert!(
            driven.ends_with("not its means; else run longer."),
            "{driven}"
        );
        let decaying = words(&[figure("kT", 0.02, -0.5, None)]).unwrap();
        assert!(
            decaying.contains("kT falls by 0.5 energy/length², 25 times its mean, during"),
            "{decaying}"
        );
    }

    #[test]
    fn what_was_asked_for_is_named_before_the_collision_rate_of_every_run() {
        let rate = figure("collisions per body that moves", 9.0, 3.0, None);
        let kicks = figure("kicks, tee", 30.0, 0.1, None);
        let both = words(&[rate.clone(), kicks]).unwrap();
        assert!(
            both.starts_with("Not stationary: kicks, tee rises by 0.33 %")
                && both.contains("; one more figure changes."),
            "{both}"
        );
        let steady = figure("kicks, tee", 30.0, 0.0, None);
        let around = words(&[rate.clone(), steady]).unwrap();
        assert!(
            around.starts_with("Not stationary: collisions per body that moves rises by 33 %")
                && around.contains("; no other figure changes."),
            "{around}"
        );
        assert!(!words(&[rate]).unwrap().contains("no other"));
    }

    #[test]
    fn a_mean_of_zero_or_without_an_error_is_not_said_to_change_by_a_multiple() {
        let mut velocity = figure("velocity along x′, tee", 1e-4, 0.2, None);
        velocity = velocity.predicted(0.0, "equilibrium");
        let said = words(std::slice::from_ref(&velocity)).unwrap();
        assert!(
            said.contains("rises by 0.2 energy/length² during") && !said.contains("times its mean"),
            "{said}"
        );
        // Blocks shorter than the memory of the body give no error, and no verdict on a change.
        velocity.standard_error = None;
        assert_eq!(words(std::slice::from_ref(&velocity)), None);
        assert!(!never_settles(&[velocity]));
    }
}
