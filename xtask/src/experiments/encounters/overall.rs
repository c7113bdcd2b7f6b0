//! Results of each detector and setting over all classes.

use carom_tables::{
    Figure,
    averages::{geometric_mean, median},
};

use super::{results::EncounterResults, settings::BASELINE, tally::EncounterTally};

/// Names of the detectors, in the order of their colours.
pub const FAMILIES: [&str; 5] = [
    "Exact",
    "GoldenSecant",
    "FixedStep",
    "BoundingCircles",
    "parry",
];

/// A detector at one setting, over all classes.
#[derive(Debug)]
pub struct Overall {
    /// Index in [`FAMILIES`].
    pub family: usize,
    /// Description of the setting.
    pub setting: String,
    /// All its answers.
    pub tally: EncounterTally,
    /// Mean over the classes of the share of wrong answers.
    pub wrong: f64,
    /// Time relative to Exact, geometric mean over the classes.
    pub ratio: Option<f64>,
    /// Number of cases searched.
    pub searched: usize,
}

/// All settings, and parry.
pub fn overall(results: &EncounterResults) -> Vec<Overall> {
    let mut list: Vec<Overall> = results
        .settings
        .iter()
        .enumerate()
        .map(|(index, setting)| {
            let name = setting.detector.name();
            let ratios = results
                .classes
                .iter()
                .filter_map(|class| Some(class.timings[index]?.ratio));
            of_classes(
                name,
                &setting.name,
                results.classes.iter().map(|class| &class.tallies[index]),
                ratios,
            )
        })
        .collect();
    let ratios = results
        .classes
        .iter()
        .filter_map(|class| median(&mut class.parry.ratios.clone()));
    let mut parry = of_classes(
        "parry",
        "nonlinear cast",
        results.classes.iter().map(|class| &class.parry.tally),
        ratios,
    );
    parry.searched = results.classes.iter().map(|class| class.parry.calls).sum();
    list.push(parry);
    list
}

fn of_classes<'a>(
    family: &str,
    setting: &str,
    tallies: impl Iterator<Item = &'a EncounterTally> + Clone,
    ratios: impl Iterator<Item = f64>,
) -> Overall {
    let shares: Vec<f64> = tallies
        .clone()
        .filter(|tally| tally.judged() > 0)
        .map(EncounterTally::wrong)
        .collect();
    let tally = EncounterTally::sum(tallies);
    Overall {
        family: FAMILIES
            .iter()
            .position(|name| *name == family)
            .unwrap_or(0),
        setting: setting.to_owned(),
        searched: tally.searched.len(),
        wrong: shares.iter().sum::<f64>() / shares.len().max(1) as f64,
        tally,
        ratio: geometric_mean(ratios),
    }
}

/// The figures of the summary.
pub fn figures(results: &EncounterResults) -> Vec<Figure> {
    let mut figures = Vec::new();
    for of in overall(results) {
        let name = format!("{}, {}", FAMILIES[of.family], of.setting);
        figures.push(Figure::new(
            format!("cases asked: {name}"),
            of.searched as f64,
            "1",
        ));
        figures.push(Figure::new(
            format!("share of wrong answers: {name}"),
            of.wrong,
            "1",
        ));
        if let Some(ratio) = of.ratio {
            figures.push(Figure::new(format!("time over Exact: {name}"), ratio, "1"));
        }
        if let Some(median) = of.tally.quantile(0.5) {
            figures.push(Figure::new(
                format!("median |t − t*|: {name}"),
                median,
                "natural times",
            ));
        }
    }
    for class in &results.classes {
        if let Some(timing) = class.timings[BASELINE] {
            let name = format!("GoldenSecant over Exact in {}", class.name);
            figures.push(Figure::new(name, timing.ratio, "1"));
        }
    }
    let hung: usize = results.classes.iter().map(|class| class.parry.hung).sum();
    figures.push(Figure::new(
        "calls of parry that did not return within 0.1 s",
        hung as f64,
        "1",
    ));
    figures
}
