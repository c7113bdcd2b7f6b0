//! What ends a run before its time: a number of collisions, or the standard error of a figure.
//!
//! The rule depends on the state at samples alone, so that a resumed run ends at the same sample.

use anyhow::{Result, bail, ensure};
use carom::{
    Scene, View,
    engine::{StopSpec, did_you_mean},
};
use carom_tables::{Figure, is_named, without_numbers};

use crate::measures::Measures;

/// Largest number of collisions of a rule; more are a mistake.
const MAX_COLLISIONS: f64 = 1e15;

/// Validates `[run.stop]`.
///
/// # Errors
/// A value is out of range, keys exclude each other, or there is no condition.
pub(crate) fn check(stop: &StopSpec) -> Result<()> {
    let StopSpec {
        collisions,
        figure,
        standard_error,
        relative_error,
    } = stop;
    ensure!(
        collisions.is_some()
            || figure.is_some()
            || standard_error.is_some()
            || relative_error.is_some(),
        "run.stop is empty: give `collisions`, or `figure` with `standard_error` or `relative_error`"
    );
    if let Some(number) = collisions {
        ensure!(
            (1.0..=MAX_COLLISIONS).contains(number),
            "run.stop.collisions must be from 1 to {MAX_COLLISIONS:e}, but is {number}"
        );
    }
    let errors = [
        ("standard_error", standard_error),
        ("relative_error", relative_error),
    ];
    for (key, error) in errors {
        let error = error.unwrap_or(1.0);
        ensure!(
            error.is_finite() && error > 0.0,
            "run.stop.{key} must be positive and finite, but is {error}"
        );
    }
    match (
        figure,
        errors.iter().filter(|(_, error)| error.is_some()).count(),
    ) {
        (None, 0) | (Some(_), 1) => Ok(()),
        (None, _) => bail!("run.stop: an error is given, but no `figure`"),
        (Some(_), 0) => bail!("run.stop.figure needs `standard_error` or `relative_error`"),
        (Some(_), _) => bail!("run.stop: `standard_error` and `relative_error` exclude each other"),
    }
}

/// The rule in words.
pub(crate) fn words(stop: &StopSpec) -> String {
    let collisions = stop
        .collisions
        .map(|number| format!("at {number} collisions"));
    let error = match (stop.standard_error, stop.relative_error) {
        (Some(error), _) => error.to_string(),
        (None, share) => format!("{} of its value", share.unwrap_or(0.0)),
    };
    let precise = stop.figure.as_ref();
    let precise =
        precise.map(|name| format!("when the standard error of {name} is at most {error}"));
    collisions
        .into_iter()
        .chain(precise)
        .collect::<Vec<_>>()
        .join(", or ")
}

/// Whether a run ends at the sample that the measures have just received.
///
/// # Errors
/// The scene names a figure that the run does not have, or that has no error.
pub(crate) fn is_met(scene: &Scene, view: &View<'_>, measures: &Measures) -> Result<bool> {
    let Some(stop) = &scene.run.stop else {
        return Ok(false);
    };
    if stop
        .collisions
        .is_some_and(|number| view.counters().collisions as f64 >= number)
    {
        return Ok(true);
    }
    let Some(name) = &stop.figure else {
        return Ok(false);
    };
    if let Some(figure) = measures.figure_of_whole_blocks(name, scene) {
        return Ok(is_precise(stop, &figure));
    }
    // A curve has a figure only where the data resolve it, and its name has been checked at the
    // start.
    let is_of_curve = without_numbers(name).contains('…');
    if !is_of_curve && measures.complete_a_block() && measures.are_settled() {
        let figures = measures.figures_with_errors(scene);
        if !figures.iter().any(|figure| is_named(figure, name)) {
            bail!(
                "run.stop.figure: the run has no figure '{name}' with a standard error{}; it has {}",
                did_you_mean(name, figures.iter().map(String::as_str)),
                if figures.is_empty() {
                    "none".to_owned()
                } else {
                    figures.join(", ")
                }
            );
        }
    }
    Ok(false)
}

fn is_precise(stop: &StopSpec, figure: &Figure) -> bool {
    let Some(error) = figure.standard_error else {
        return false;
    };
    let requested = match (stop.standard_error, stop.relative_error) {
        (Some(requested), _) => requested,
        (None, share) => share.unwrap_or(0.0) * figure.value.abs(),
    };
    // An error of exactly 0 is that of equal values: nothing is known yet.
    error > 0.0 && error <= requested
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{interruption::Signals, run::outcome::in_memory};
    use carom_methods::Method;

    fn refused(stop: &str) -> String {
        let scene = Scene::from_toml(&format!("[run.stop]\n{stop}")).unwrap();
        check(scene.run.stop.as_ref().unwrap())
            .unwrap_err()
            .to_string()
    }

    /// The first blocks are too short for a plateau, so that the figure does not exist yet.
    #[test]
    fn a_run_waits_for_the_figure_of_a_curve() {
        let scene = Scene::from_toml(
            "[[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\ntemperature = 1.0\ncount = 200\n[run]\n\
             until = 200.0\nsample_interval = 0.02\nobserve = [\"correlation:gas\"]\n[run.stop]\n\
             figure = \"diffusion coefficient at long lags, … to …, gas\"\nrelative_error = 0.2\n",
        )
        .unwrap();
        let signals = Signals::watch().unwrap();
        let outcome = in_memory(&scene, &signals).unwrap();
        let figures = &outcome.results.figures;
        let name = scene.run.stop.as_ref().unwrap().figure.as_ref().unwrap();
        let found = figures
            .iter()
            .find(|figure| is_named(&figure.name, name))
            .unwrap();
        assert!(found.standard_error.unwrap() <= 0.2 * found.value);
        let summary = outcome.summary(String::new(), &Method::default());
        assert!(summary.totals.simulated_time < 100.0);
    }

    #[test]
    fn contradictory_rules_are_refused_by_name() {
        for (stop, expected) in [
            ("", "empty"),
            ("collisions = 0.5", "from 1 to 1e15, but is 0.5"),
            ("collisions = nan", "from 1"),
            ("figure = \"pressure\"", "needs `standard_error`"),
            ("standard_error = 0.1", "no `figure`"),
            (
                "figure = \"p\"\nrelative_error = 0.1\nstandard_error = 0.1",
                "exclude",
            ),
            (
                "figure = \"p\"\nrelative_error = -0.1",
                "run.stop.relative_error must be positive",
            ),
        ] {
            let error = refused(stop);
            assert!(error.contains(expected), "{stop}: {error}");
        }
        let unknown = Scene::from_toml("[run.stop]\ncolisions = 5")
            .unwrap_err()
            .to_string();
        assert!(unknown.contains("did you mean `collisions`?"), "{unknown}");
    }

    #[test]
    fn rules_are_named_in_words() {
        let stop = StopSpec {
            collisions: Some(1e6),
            figure: Some("pressure".to_owned()),
            relative_error: Some(0.01),
            ..StopSpec::default()
        };
        let expected = "at 1000000 collisions, or when the standard error of pressure is at most 0.01 of its value";
        assert_eq!(words(&stop), expected);
    }

    #[test]
    fn an_error_is_judged_absolutely_or_as_a_share_of_the_value() {
        let figure = |error: f64| Figure::new("p", -20.0, "1").error(error);
        let absolute = StopSpec {
            standard_error: Some(0.5),
            ..StopSpec::default()
        };
        let relative = StopSpec {
            relative_error: Some(0.025),
            ..StopSpec::default()
        };
        for stop in [absolute, relative] {
            assert!(is_precise(&stop, &figure(0.5)) && !is_precise(&stop, &figure(0.51)));
            assert!(
                !is_precise(&stop, &figure(0.0)) && !is_precise(&stop, &Figure::new("p", 1.0, "1"))
            );
        }
    }
}
