//! Files of what the measures of a page have found so far: tables, drawings, and the figures.

use std::collections::HashSet;

use anyhow::Result;
use carom_runs::{
    measures::file_name,
    output::csv_table,
    run::interactive::{InteractiveRun, NamedFile},
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

/// A CSV file of each table, the drawings, and a CSV file of all figures; without measures there is
/// no file. Files that would share a name have the number of their measure in it.
///
/// # Errors
/// A table cannot be encoded.
pub fn measured_files(measures: &[MeasuredNow], run: &InteractiveRun) -> Result<Vec<NamedFile>> {
    if measures.is_empty() {
        return Ok(Vec::new());
    }
    let (rules, until) = (rules_in_force(run), run.view().time().to_f64());
    let (mut files, mut rows) = (Vec::new(), Vec::new());
    let mut names = HashSet::from([FIGURES.to_owned()]);
    let mut unique = |name: String, id: u64| {
        if names.insert(name.clone()) {
            return name;
        }
        let name = format!("{id}-{name}");
        names.insert(name.clone());
        name
    };
    for measured in measures {
        let results = measured.results(&rules, run);
        for table in &results.tables {
            let content = csv_table(&table.header(), table.rows())?;
            files.push((unique(file_name(table), measured.id), content));
        }
        for drawing in results.drawings {
            let name = unique(drawing.file, measured.id);
            files.push((name, drawing.svg.into_bytes()));
        }
        let tracked = &measured.tracked;
        rows.extend(results.figures.into_iter().map(|figure| {
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
    }
    files.push((FIGURES.to_owned(), csv_table(&COLUMNS, rows)?));
    Ok(files)
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::{Scene, engine::MeasureSpec};
    use carom_runs::measures::{SingleMeasure, Tracked};

    #[test]
    fn each_table_is_a_file_and_equal_names_have_the_number_of_their_measure() {
        let scene =
            "[[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100";
        let scene = Scene::from_toml(scene).unwrap();
        let mut run = InteractiveRun::new(&scene).unwrap();
        let measured = |id: u64, run: &InteractiveRun| {
            let spec = MeasureSpec {
                kind: "temperature".to_owned(),
                of: Some("gas".to_owned()),
                ..MeasureSpec::default()
            };
            let measure = SingleMeasure::new(&spec, 0.1, &scene, &run.view()).unwrap();
            MeasuredNow {
                id,
                name: "temperature:gas".to_owned(),
                spec,
                begun: 0.0,
                tracked: Tracked::new(measure, &run.view()),
            }
        };
        assert!(measured_files(&[], &run).unwrap().is_empty());
        let mut measures = [measured(1, &run), measured(2, &run)];
        for _ in 0..20 {
            run.advance(measures[0].tracked.time(), &mut ()).unwrap();
            for each in &mut measures {
                each.tracked.sample(&run.view());
            }
        }
        let files = measured_files(&measures, &run).unwrap();
        let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(
            names,
            [
                "temperature-gas.csv",
                "2-temperature-gas.csv",
                "figures.csv"
            ]
        );
        let text = |index: usize| String::from_utf8(files[index].1.clone()).unwrap();
        assert_eq!(text(0), text(1));
        assert_eq!(text(0).lines().count(), 1 + 21);
        let figures = text(2);
        assert!(figures.starts_with("measure,figure,value,standard_error,unit,"));
        assert!(
            figures.contains("temperature:gas,\"kT of the translation, gas\","),
            "{figures}"
        );
    }
}
