//! The scene's own measures with a setting, from a state of the exact run on.

use std::time::Instant;

use anyhow::Result;
use carom::{Observer, Scene};
use carom_runs::{
    measures::{KINDS, Measures, Span, requests},
    price::{Course, CourseState, Reached, Setting},
};
use carom_tables::Figure;

use super::{
    curves::{self, Deviation, TradeCurve, deviations},
    difference::Difference,
};

/// Number of samples of a measurement, at least: fewer give no standard errors.
const SAMPLES: f64 = 64.0;

/// With fewer samples a standard error is not trusted: it comes from too few blocks.
const MIN_SAMPLES: u64 = 24;

/// Number of overlap checks of a measurement.
const CHECKS: f64 = 16.0;

/// Results.
#[derive(Debug, Clone, Default)]
pub struct Physics {
    /// Figures of the measures.
    pub figures: Vec<Figure>,
    /// Curves of the measures, with errors.
    pub curves: Vec<TradeCurve>,
    /// Largest number of overlapping pairs at a check.
    pub overlapping: usize,
    /// Deepest overlap at a check, in units of the smaller diameter.
    pub deepest: f64,
    /// Start and end of the measurement (time); both 0 if there was none.
    pub span: [f64; 2],
    /// Error of a failed run.
    pub broke_off: Option<String>,
    /// The exact run over the same time, if this run has ended before that of the others.
    pub reference: Option<Box<Self>>,
}

impl Physics {
    /// Whether anything was measured.
    pub fn is_measured(&self) -> bool {
        self.span[1] > self.span[0]
    }

    /// Deviations of the curves from those of the exact run over the same time.
    pub fn deviations(&self, exact: &Self) -> Vec<Deviation> {
        deviations(
            &self.curves,
            &self.reference.as_deref().unwrap_or(exact).curves,
        )
    }

    /// The figures beside those of the exact run over the same time, in its order.
    pub fn differences(&self, exact: &Self) -> Vec<Difference> {
        let exact = self.reference.as_deref().unwrap_or(exact);
        let pair = |reference: &Figure| {
            let own = self
                .figures
                .iter()
                .find(|figure| figure.name == reference.name)?;
            let errors = own.standard_error.zip(reference.standard_error);
            Some(Difference {
                name: own.name.clone(),
                unit: own.unit.clone(),
                value: own.value,
                exact: reference.value,
                difference: own.value - reference.value,
                standard_error: errors.map(|(a, b)| a.hypot(b)),
            })
        };
        exact.figures.iter().filter_map(pair).collect()
    }
}

/// The scene with measures that suit a short measurement of this duration (time) from a state on:
/// everything is measured from its start; a shorter interval between samples is a fraction of that
/// of the scene.
pub fn suited(scene: &Scene, duration: f64) -> Scene {
    let mut suited = scene.clone();
    suited.run.measure_from = 0.0.into();
    suited
        .stage
        .iter_mut()
        .for_each(|stage| stage.measure = true);
    let requested = duration / SAMPLES;
    let divisor = (scene.run.sample_interval / requested).ceil().max(1.0);
    suited.run.sample_interval = scene.run.sample_interval / divisor;
    suited.run.check_interval = Some(duration / CHECKS);
    // Files of contacts are for runs.
    let writes = |name: &str| {
        let kind = name.split_once(':').map_or(name, |(kind, _)| kind);
        KINDS
            .iter()
            .any(|known| known.name == kind && known.span == Span::EveryContact)
    };
    suited.run.observe.retain(|name| !writes(name));
    suited.measure.retain(|entry| !writes(&entry.kind));
    let has_pressure = requests(scene)
        .is_ok_and(|requests| requests.iter().any(|request| request.kind.name == PRESSURE));
    if !has_pressure {
        suited.run.observe.push(PRESSURE.to_owned());
    }
    suited
}

/// This measure is added to those of the scene: it shows errors of the contacts at once.
const PRESSURE: &str = "pressure";

/// Measures a setting from a state on for a duration (time), or until the deadline. `suited` is the
/// scene with [its measures](suited). A run that fails keeps its results so far.
///
/// # Errors
/// The run cannot start.
pub fn measure(
    suited: &Scene,
    setting: &Setting,
    state: &CourseState,
    duration: f64,
    deadline: Instant,
) -> Result<Physics> {
    let mut course = Course::resume(suited, setting, state)?;
    let mut measures = Measures::new(suited, &course.simulation().view())?;
    measures.start(&course.simulation().view());
    measures.sample(&course.simulation().view());
    let begin = state.time();
    let mut physics = Physics {
        span: [begin, begin],
        ..Physics::default()
    };
    let interval = suited.run.sample_interval;
    let checks = suited.run.check_interval.unwrap_or(duration);
    let mut next_check = begin + checks;
    let samples = (duration / interval * (1.0 + 1e-9)).floor().max(1.0) as u64;
    for sample in 1..=samples {
        let time = begin + interval * sample as f64;
        match course.run_to(time, &mut measures, deadline) {
            Ok(Reached::Target) => {}
            Ok(Reached::Deadline) => break,
            Err(error) => {
                physics.broke_off = Some(format!("{error:#}"));
                break;
            }
        }
        physics.span[1] = time;
        let view = course.simulation().view();
        measures.sample(&view);
        if time >= next_check {
            measures.check(&view);
            next_check = time + checks;
        }
        if Instant::now() >= deadline {
            break;
        }
    }
    if physics.broke_off.is_none() {
        measures.check(&course.simulation().view());
    }
    let results = measures.results(suited, &Err("a short replay".to_owned()));
    let taken = ((physics.span[1] - begin) / interval * (1.0 + 1e-9)) as u64;
    physics.figures = sound_figures(results.figures, taken);
    if taken >= MIN_SAMPLES {
        physics.curves = results.tables.iter().flat_map(curves::of_table).collect();
    }
    physics.overlapping = results.totals.overlapping_pairs;
    physics.deepest = results.totals.max_overlap;
    Ok(physics)
}

/// The figures that are finite; without their errors if too few samples were taken.
fn sound_figures(figures: Vec<Figure>, taken: u64) -> Vec<Figure> {
    let with_sound_error = |figure: Figure| {
        let error = figure.standard_error.filter(|_| taken >= MIN_SAMPLES);
        Figure {
            standard_error: error,
            ..figure
        }
    };
    let is_sound = |figure: &Figure| figure.value.is_finite();
    figures
        .into_iter()
        .filter(is_sound)
        .map(with_sound_error)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_suited_scene_samples_at_a_fraction_of_its_interval_and_writes_no_contacts() {
        let scene = Scene::from_toml(
            "[[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 50\n\
             [run]\nuntil = 40.0\nsample_interval = 0.5\nmeasure_from = 2.0\n\
             observe = [\"velocities:gas\", \"events\"]\n\
             [[measure]]\nkind = \"pair-distribution\"\ninterval = 1.0\n",
        )
        .unwrap();
        let found = suited(&scene, 8.0);
        assert_eq!(found.run.sample_interval, 0.125);
        assert_eq!(found.run.observe, ["velocities:gas", "pressure"]);
        assert_eq!(
            (found.run.measure_from, found.measure.len()),
            (0.0.into(), 1)
        );
        assert!(requests(&found).is_ok());
    }

    #[test]
    fn differences_have_the_combined_error_and_need_both() {
        let of = |value, error: Option<f64>| Physics {
            figures: vec![Figure::new("pressure", value, "p").error(error)],
            ..Physics::default()
        };
        let found = &of(11.0, Some(3.0)).differences(&of(10.0, Some(4.0)))[0];
        assert_eq!(
            (found.difference, found.standard_error, found.in_errors()),
            (1.0, Some(5.0), Some(0.2))
        );
        assert_eq!(
            of(11.0, Some(3.0)).differences(&of(10.0, None))[0].standard_error,
            None
        );
        let percent = of(11.0, Some(0.3)).differences(&of(10.0, Some(0.4)))[0]
            .percent()
            .unwrap();
        assert_eq!(percent, [10.0, 5.0]);
        // No figure of a value that is 0 within its error.
        assert_eq!(found.percent(), None);
    }
}
