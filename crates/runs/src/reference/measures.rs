//! The quantities that a run can measure: what each covers, and which files, figures and
//! predictions it gives.

use std::collections::BTreeSet;

use anyhow::Result;
use carom::{Observer as _, Scene};
use carom_methods::AnySimulation;
use carom_tables::{Figure, Role};

use super::table;
use crate::measures::{
    COLLISION_RATE as RATE, HardDiscs, KINDS, MeasureKind, Measures, OF_AXES, Of, Parameter,
    Results, file_name,
};

/// Head of the section.
const HEAD: &str = "
## Names in `run.observe`

`TAG` is the tag of a body or of a group of bodies, and becomes part of the names of the files. The
same names without tag are those of `kind` in `[[measure]]`.

Measures give CSV files, charts, and figures in `summary.json`, with standard errors. Predictions
are those for a gas of equal elastic discs, or for equilibrium.

";

/// Head of the table of parameters.
const PARAMETERS: &str = "
## Parameters of `[[measure]]`

Keys of an entry `[[measure]]` besides `kind`, `of` and `name`. A measure samples
at samples of the run. So `run.sample_interval` is the shortest interval that any measure needs, and
`every` or `interval` makes the others coarser.

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

/// Bodies for the measures of bodies with an axis.
const RODS: &str = "
[[gas]]
shape = \"rod:2\"
atom_radius = 0.01
atom_mass = 1.0
energy = 1.0
count = 40
";

/// A wall for the measure of its heat, and one for that of the pressure on it.
const THERMAL_WALL: &str = "
[[wall]]
x = 0.0
temperature = 1.0
";
const WALL: &str = "
[[wall]]
x = 0.0
";

/// A piston between two parts of the gas, for its measure.
const PISTON: &str = "
[[piston]]
x = 0.5
mass = 10.0
stops = [0.1, 0.9]
";

/// Chains, for their measures.
const CHAINS: &str = "
[[gas]]
radius = 0.01
mass = 1.0
energy = 1.0
count = 16
chain = { members = 4, tether = { max = 0.04 } }
";

/// Discs with a well, for its measure.
const WELL: &str = "
[[well]]
between = [\"sticky\"]
steps = [[1.5, -0.5]]
[[gas]]
tags = [\"sticky\"]
radius = 0.01
mass = 1.0
energy = 1.0
count = 20
";

/// Returns the section of Markdown.
///
/// # Errors
/// A measure cannot be run.
pub fn section() -> Result<String> {
    let mut text = HEAD.to_owned();
    let rows = KINDS.iter().map(measure).collect::<Result<Vec<_>>>()?;
    text += &table(
        &["name", "measures", "files", "figures", "predictions"],
        &rows,
    );
    text += PARAMETERS;
    text += &table(&["key", "kinds", "default", "meaning"], &parameters());
    Ok(text)
}

/// A row for each parameter, with the kinds that have it.
fn parameters() -> Vec<Vec<String>> {
    let mut rows: Vec<(&Parameter, Vec<String>)> = Vec::new();
    for kind in &KINDS {
        for parameter in kind.all_parameters() {
            let name = format!("`{}`", kind.name);
            let same = |row: &&mut (&Parameter, _)| {
                let text = |of: &Parameter| (of.name, of.about, of.default.to_string());
                text(row.0) == text(parameter)
            };
            match rows.iter_mut().find(same) {
                Some((_, kinds)) => kinds.push(name),
                None => rows.push((parameter, vec![name])),
            }
        }
    }
    let row = |(parameter, kinds): (&Parameter, Vec<String>)| {
        let Parameter {
            name,
            about,
            default,
            ..
        } = parameter;
        let takes_samples = KINDS
            .iter()
            .filter(|kind| !kind.span.parameters().is_empty())
            .count();
        let kinds = if kinds.len() == takes_samples {
            "all that take samples".to_owned()
        } else {
            kinds.join(", ")
        };
        vec![
            format!("`{name}`"),
            kinds,
            default.to_string(),
            (*about).to_owned(),
        ]
    };
    rows.into_iter().map(row).collect()
}

/// The row of a measure, from a short run.
fn measure(kind: &MeasureKind) -> Result<Vec<String>> {
    let name = kind.usage();
    let (asked, text) = match kind.of {
        Of::Group if kind.name == "wall-heat" => {
            (kind.name.to_owned(), format!("{THERMAL_WALL}{GAS}"))
        }
        Of::Group if ["wall-pressure", "wall-work"].contains(&kind.name) => {
            (kind.name.to_owned(), format!("{WALL}{GAS}"))
        }
        Of::Group if kind.name == "piston" => (kind.name.to_owned(), format!("{PISTON}{GAS}")),
        Of::Group if kind.name.starts_with("chain") => {
            (kind.name.to_owned(), format!("{CHAINS}{GAS}"))
        }
        Of::System if kind.name == "wells" => (kind.name.to_owned(), format!("{WELL}{GAS}")),
        Of::Group if OF_AXES.contains(&kind.name) => (kind.name.to_owned(), format!("{RODS}{GAS}")),
        Of::OneBody => (format!("{}:body", kind.name), format!("{BODY}{GAS}")),
        Of::Group | Of::TwoGroups | Of::Pair | Of::System => (kind.name.to_owned(), GAS.to_owned()),
    };
    let results = run(&format!("{text}observe = [\"{asked}\"]\n"))?;
    let written = |name: &str| name.replace("-body", "-TAG").replace(", body", "");
    let files = results
        .tables
        .iter()
        .map(file_name)
        .chain(results.files.iter().cloned());
    let files = files.map(|file| format!("`{}`", written(&file)));
    // The collision rate is a figure of every run; it belongs to its own row alone.
    let is_own = |figure: &&Figure| kind.name == "collision-rate" || figure.name != RATE;
    let figures = results
        .figures
        .iter()
        .filter(is_own)
        .map(|figure| written(&figure.name));
    let columns = results.tables.iter().flat_map(|table| &table.columns);
    let of_tables = columns.filter_map(|column| match &column.role {
        Role::Prediction { source } => Some(source.clone()),
        _ => None,
    });
    let of_figures = results
        .figures
        .iter()
        .filter(is_own)
        .filter_map(|figure| figure.source.clone());
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
    let mut measures = Measures::new(&scene, &simulation.view())?;
    measures.start(&simulation.view());
    measures.sample(&simulation.view());
    let samples = (scene.run.until / scene.run.sample_interval).round() as u32;
    for sample in 1..=samples {
        simulation.observe_until(scene.run.sample_interval * f64::from(sample), &mut measures)?;
        measures.sample(&simulation.view());
    }
    let gas = HardDiscs::new(&simulation.view(), &scene.elasticity);
    Ok(measures.results(&scene, &gas))
}
