//! What the measures of a page have found so far, as a saved run has it.

use anyhow::Result;
use carom_runs::{
    output::csv_table,
    run::interactive::{InteractiveRun, MeasuredBefore},
};

use crate::report::{MeasuredNow, rules_in_force};

/// The file of all figures.
const FIGURES: &str = "figures.csv";

/// Its columns; `from` and `until` are the times of the first sample and of the save.
const COLUMNS: [&str; 10] = [
    "measure",
    "figure",
    "value",
    "standard_error",
    "unit",
    "prediction",
    "from",
    "until",
    "sample_interval",
    "samples",
];

/// The results of each measure, and a CSV file of all figures; without measures there is no file.
///
/// # Errors
/// The figures cannot be encoded.
pub fn measured_before(measures: &[MeasuredNow], run: &InteractiveRun) -> Result<MeasuredBefore> {
    if measures.is_empty() {
        return Ok(MeasuredBefore::default());
    }
    let (rules, until) = (rules_in_force(run), run.view().time().to_f64());
    let (mut all, mut rows) = (Vec::new(), Vec::new());
    for measured in measures {
        let mut results = measured.results(&rules, run);
        let tracked = &measured.tracked;
        let figures = std::mem::take(&mut results.figures);
        rows.extend(figures.into_iter().map(|figure| {
            (
                measured.name.clone(),
                figure.name,
                figure.value,
                figure.standard_error,
                figure.unit,
                figure.prediction,
                measured.begun,
                until,
                tracked.measure.interval(),
                tracked.samples(),
            )
        }));
        all.push(results);
    }
    let figures = (FIGURES.to_owned(), csv_table(&COLUMNS, rows)?);
    Ok(MeasuredBefore {
        results: all,
        files: vec![figures],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::{Scene, engine::MeasureSpec};
    use carom_runs::measures::{SingleMeasure, Tracked};
    use std::path::Path;

    #[test]
    fn each_table_is_a_file_and_equal_names_have_the_number_of_their_measure() {
        let scene =
            "[[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100";
        let scene = Scene::from_toml(scene).unwrap();
        let mut run = InteractiveRun::new(&scene).unwrap();
        let spec = || MeasureSpec {
            kind: "temperature".to_owned(),
            of: Some("gas".to_owned()),
            ..MeasureSpec::default()
        };
        let measured = |id: u64, run: &InteractiveRun| {
            let measure = SingleMeasure::new(&spec(), 0.1, &scene, &run.view()).unwrap();
            MeasuredNow {
                id,
                name: "temperature:gas".to_owned(),
                spec: spec(),
                begun: 0.0,
                tracked: Tracked::new(measure, &run.view()),
            }
        };
        assert!(measured_before(&[], &run).unwrap().is_empty());
        let mut measures = [measured(1, &run), measured(2, &run)];
        for _ in 0..20 {
            run.advance(measures[0].tracked.time(), &mut ()).unwrap();
            for each in &mut measures {
                each.tracked.sample(&run.view());
            }
        }
        run.set_watched(vec![(spec(), 0.1), (spec(), 0.1)]);
        let measured = measured_before(&measures, &run).unwrap();
        let (_, files) = run.files(Path::new("saved"), &measured).unwrap();
        let inner: Vec<(&str, &[u8])> = files
            .iter()
            .filter_map(|(name, content)| {
                Some((name.strip_prefix("measured-before/")?, content.as_slice()))
            })
            .collect();
        let names: Vec<&str> = inner.iter().map(|(name, _)| *name).collect();
        let expected = [
            "figures.csv",
            "temperature-gas.csv",
            "2-temperature-gas.csv",
            "series",
        ];
        assert_eq!(names, expected);
        let text = |index: usize| String::from_utf8(inner[index].1.to_vec()).unwrap();
        assert_eq!(text(1), text(2));
        assert_eq!(text(1).lines().count(), 1 + 21);
        let figures = text(0);
        assert!(figures.starts_with("measure,figure,value,standard_error,unit,"));
        assert!(
            figures.contains("temperature:gas,\"kT of the translation, gas\","),
            "{figures}"
        );
    }
}
