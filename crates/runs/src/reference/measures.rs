//! The quantities that a run can measure: what each covers, and which files, figures and predictions
//! it gives.

use std::collections::BTreeSet;

use anyhow::Result;
use carom::{Observer as _, Scene};
use carom_methods::AnySimulation;
use carom_tables::Role;

use super::table;
use crate::measures::{HardDiscs, KINDS, Kind, Measures, Of, Results, SERIES, file_name};

/// Head of the section.
const HEAD: &str = "
## Names in `run.observe`

`TAG` is the tag of a body or of a group of bodies, and becomes part of the names of the files.
Series are CSV files with a row for each sample, or for each impulse:

";

/// Head of the table of measures.
const MEASURES: &str = "
Measures give CSV files, charts, and figures in `summary.json`, with standard errors. Predictions are
those for a gas of equal elastic discs, or for equilibrium.

";

/// A gas to which all predictions apply; long enough that each measure has results.
const GAS: &str = "
[[gas]]
tags = [\"gas\"]
radius = 0.02
mass = 1.0
energy = 1.0
count = 100

[run]
until = 2.0
sample_interval = 0.1
";

/// A body for the measures of one body.
const BODY: &str = "
[[molecule]]
tags = [\"body\"]
shape = \"tee\"
atom_radius = 0.02
atom_mass = 1.0
at = [0.5, 0.5]
";

/// A wall for the measure of its heat.
const THERMAL_WALL: &str = "
[[wall]]
x = 0.0
temperature = 1.0
";

/// Returns the section of Markdown.
///
/// # Errors
/// A measure cannot be run.
pub fn section() -> Result<String> {
    let mut text = HEAD.to_owned();
    let series: Vec<Vec<String>> =
        SERIES.iter().map(|(name, what)| vec![format!("`{name}`"), (*what).to_owned()]).collect();
    text += &table(&["name", "series"], &series);
    text += MEASURES;
    let rows = KINDS.iter().map(measure).collect::<Result<Vec<_>>>()?;
    text += &table(&["name", "measures", "files", "figures", "predictions"], &rows);
    Ok(text)
}

/// The row of a measure, from a short run.
fn measure(kind: &Kind) -> Result<Vec<String>> {
    let (name, asked, text) = match kind.of {
        Of::Group if kind.name == "wall-heat" => {
            (format!("{}[:TAG]", kind.name), kind.name.to_owned(), format!("{THERMAL_WALL}{GAS}"))
        }
        Of::Group => (format!("{}[:TAG]", kind.name), kind.name.to_owned(), GAS.to_owned()),
        Of::OneBody => (format!("{}:TAG", kind.name), format!("{}:body", kind.name), format!("{BODY}{GAS}")),
        Of::System => (kind.name.to_owned(), kind.name.to_owned(), GAS.to_owned()),
    };
    let results = run(&format!("{text}observe = [\"{asked}\"]\n"))?;
    let written = |name: &str| name.replace("-body", "-TAG").replace(", body", "");
    let files = results.tables.iter().map(|table| format!("`{}`", written(&file_name(table))));
    let figures = results.figures.iter().map(|figure| written(&figure.name));
    let columns = results.tables.iter().flat_map(|table| &table.columns);
    let of_tables = columns.filter_map(|column| match &column.role {
        Role::Prediction { source } => Some(source.clone()),
        _ => None,
    });
    let of_figures = results.figures.iter().filter_map(|figure| figure.source.clone());
    let sources: BTreeSet<String> = of_tables.chain(of_figures).collect();
    Ok(vec![
        format!("`{name}`"),
        kind.summary.to_owned(),
        files.collect::<Vec<_>>().join(", "),
        figures.collect::<Vec<_>>().join("; "),
        sources.into_iter().collect::<Vec<_>>().join("; "),
    ])
}

/// Results of the measures of a scene.
fn run(text: &str) -> Result<Results> {
    let scene = Scene::from_toml(text)?;
    let mut simulation = AnySimulation::new(&scene)?;
    let mut measures = Measures::begin(&scene.run, &simulation.view())?;
    measures.start(&simulation.view());
    measures.sample(&simulation.view());
    let samples = (scene.run.until / scene.run.sample_interval).round() as u32;
    for sample in 1..=samples {
        simulation.observe_until(scene.run.sample_interval * f64::from(sample), &mut measures)?;
        measures.sample(&simulation.view());
    }
    let gas = HardDiscs::of(&simulation.view(), &scene.elasticity);
    Ok(measures.results(&scene, &gas))
}
