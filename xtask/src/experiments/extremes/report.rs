//! The page of the experiment: guarantees, results, and limits.

use std::fmt::Write as _;

use anyhow::Result;
use carom_report::{
    axis::Axis,
    chart::{Chart, Layer, LayerShape},
    ink::Ink,
    page::{Layout, Page, PagePart, checks_in_words},
};
use carom_tables::Summary;
use carom_testkit::extremes::Engine;

use super::{drift::EnergyDrift, limits::FoundLimit, results::ExtremesResults, trial::Ending};

fn verdict(ending: &Ending) -> String {
    if ending.holds() {
        "holds".to_owned()
    } else {
        ending.seen()
    }
}

fn number(value: f64) -> String {
    if value.is_nan() {
        "never".to_owned()
    } else {
        format!("{value:.1e}")
    }
}

/// "up to …, then …"
fn sentence(found: &FoundLimit) -> String {
    match &found.beyond {
        None => format!("up to {}, the end of the search", number(found.holds_up_to)),
        Some((at, ending)) => {
            format!(
                "up to {}, then (at {}) {}",
                number(found.holds_up_to),
                number(*at),
                ending.seen()
            )
        }
    }
}

/// The page.
pub fn page(
    results: &ExtremesResults,
    summary: &Summary,
    charts: &[(&'static str, String)],
    command: &str,
) -> Page {
    let lead = "Extreme scenes, each with the bounds that must hold; parameters increased until a bound \
                fails; and the accuracy of a whole run.";
    let mut page = Page::new(&summary.title, lead);
    if !summary.note.is_empty() {
        page.note(&summary.note);
    }
    page.verdict(&verdict_of_all(results, summary));
    page.part(PagePart::Answer);
    overview(&mut page, results);
    let drawn: Vec<(&str, &str)> = charts.iter().map(|(_, svg)| (svg.as_str(), "")).collect();
    if !drawn.is_empty() {
        page.pictures(Layout::Beside, &drawn);
    }
    page.part(PagePart::Results);
    page.code(command);
    scene_section(&mut page, results);
    limit_section(&mut page, results);
    reversal_section(&mut page, results);
    drift_section(&mut page, &results.drifts);
    page.checks(&summary.checks);
    page.totals(&summary.totals);
    page.links([
        "scenes.csv",
        "findings.csv",
        "edges.csv",
        "reversal.csv",
        "drift.csv",
        "summary.json",
        "manifest.json",
    ]);
    page
}

/// Number of limits that an engine reaches up to their goals.
fn reached(results: &ExtremesResults, engine: usize) -> usize {
    results
        .limits
        .iter()
        .filter(|(search, found)| found[engine].holds_up_to >= search.goal)
        .count()
}

fn verdict_of_all(results: &ExtremesResults, summary: &Summary) -> String {
    let holds = results
        .scenes
        .iter()
        .filter(|(_, endings)| endings[0].holds())
        .count();
    let mut words = format!(
        "All bounds hold in {holds} of {} extreme scenes",
        results.scenes.len()
    );
    if !results.limits.is_empty() {
        let _ = write!(
            words,
            "; {} of {} parameters reach their goal",
            reached(results, 0),
            results.limits.len()
        );
    }
    format!("{words}. {}", checks_in_words(&summary.checks))
}

/// One table of all scenes, limits, reversals and drifts.
fn overview(page: &mut Page, results: &ExtremesResults) {
    let row = |name: &str, cells: [String; 2]| [vec![name.to_owned()], cells.to_vec()].concat();
    let scenes = |engine: usize| {
        let holds = results
            .scenes
            .iter()
            .filter(|(_, endings)| endings[engine].holds())
            .count();
        share(holds, results.scenes.len())
    };
    let limits = |engine: usize| share(reached(results, engine), results.limits.len());
    let errors = |engine: usize| {
        let reversals = results.reversals[engine].iter();
        largest(reversals.map(|reversal| reversal.effective_error))
    };
    let drift = largest(results.drifts.iter().map(|drift| drift.totals.energy_drift));
    let rows = [
        row("scenes in which all bounds hold", [0, 1].map(scenes)),
        row(
            "parameters whose bounds hold up to the goal",
            [0, 1].map(limits),
        ),
        row(
            "largest effective error by reversal (eps × side)",
            [0, 1].map(errors),
        ),
        row("largest energy drift (relative)", [drift, "–".to_owned()]),
    ];
    page.table(
        &["all scenes", Engine::Default.name(), Engine::Thesis.name()],
        &rows,
    );
}

/// The largest value, or a dash if there is none.
fn largest(values: impl Iterator<Item = f64>) -> String {
    match values.reduce(f64::max) {
        None => "–".to_owned(),
        Some(value) if value < 0.01 => format!("{value:.1e}"),
        Some(value) => format!("{value:.2}"),
    }
}

/// A count out of all, or a dash if there are none.
fn share(count: usize, all: usize) -> String {
    if all == 0 {
        "–".to_owned()
    } else {
        format!("{count} of {all}")
    }
}

fn scene_section(page: &mut Page, results: &ExtremesResults) {
    page.heading("Scenes");
    page.paragraph(&format!(
        "Results of the two engines: {} is the default; {} is that of Montanari (2017), for comparison.",
        Engine::Default.name(),
        Engine::Thesis.name()
    ));
    let rows: Vec<Vec<String>> = results
        .scenes
        .iter()
        .map(|(case, [ours, theses])| {
            let scene = format!("{} {}", case.id, case.name);
            vec![
                scene,
                case.must.to_owned(),
                verdict(ours),
                ours.seen(),
                verdict(theses),
            ]
        })
        .collect();
    page.table(
        &[
            "scene",
            "requirement",
            Engine::Default.name(),
            "nearest to its bound",
            Engine::Thesis.name(),
        ],
        &rows,
    );
}

fn limit_section(page: &mut Page, results: &ExtremesResults) {
    page.heading("Limits");
    let rows: Vec<Vec<String>> = results
        .limits
        .iter()
        .map(|(limit, [ours, theses])| {
            let name = format!("{}: {}", limit.parameter, limit.scene);
            vec![
                name,
                number(limit.goal),
                sentence(ours),
                ours.kinds(),
                sentence(theses),
            ]
        })
        .collect();
    page.table(
        &[
            "parameter and scene",
            "goal",
            Engine::Default.name(),
            "beyond",
            Engine::Thesis.name(),
        ],
        &rows,
    );
    page.paragraph(
        "Beyond a limit a run ends with a named error, or it continues and exceeds a bound that is measured \
         here; larger values are tried up to the end of the search. A panic or a run without end would fail a \
         check.",
    );
}

fn reversal_section(page: &mut Page, results: &ExtremesResults) {
    page.heading("Reversal");
    page.paragraph(
        "64 discs run forward, all velocities are reversed, and the discs run back. The distance from the \
         initial state grows exponentially at the Lyapunov rate; extrapolated to zero collisions, it is the \
         effective error of the engine.",
    );
    let rows: Vec<Vec<String>> = results
        .reversals
        .iter()
        .flatten()
        .map(|reversal| {
            let name = format!("{}, area fraction {}", reversal.engine, reversal.fraction);
            vec![
                name,
                format!("{:.1}", reversal.effective_error),
                format!("{:.2}", reversal.rate),
            ]
        })
        .collect();
    page.table(
        &[
            "engine and density",
            "effective error (eps × side)",
            "e-foldings per collision of a disc",
        ],
        &rows,
    );
}

fn drift_section(page: &mut Page, drifts: &[EnergyDrift]) {
    page.heading("Energy drift");
    let rows: Vec<Vec<String>> = drifts
        .iter()
        .map(|drift| {
            let last = drift.points.last().map_or(f64::NAN, |point| point.1);
            vec![
                drift.name.to_owned(),
                drift.totals.collisions.to_string(),
                format!("{last:.1e}"),
                format!("{:.1e}", drift.totals.energy_drift),
                format!("{:.2}", drift.exponent),
                drift.law().to_owned(),
                format!("{:.2}", drift.gaps.deepest),
                format!("{:.2}", drift.gaps.farthest),
            ]
        })
        .collect();
    page.table(
        &[
            "scene",
            "collisions",
            "at the end, relative",
            "largest",
            "exponent",
            "law",
            "deepest contact (eps × side)",
            "farthest contact (eps × side)",
        ],
        &rows,
    );
}

fn chart(title: &str, [x, y]: [&str; 2], curves: Vec<(String, Vec<(f64, f64)>)>) -> Result<String> {
    let all = || curves.iter().flat_map(|curve| &curve.1);
    let range = |of: fn(&(f64, f64)) -> f64| {
        let low = all().map(of).fold(f64::INFINITY, f64::min);
        let high = all().map(of).fold(f64::NEG_INFINITY, f64::max);
        let margin = (0.03 * (high - low)).max(1e-3);
        (low - margin, high + margin)
    };
    let axis = |label: &str, range| Axis::new(label, range);
    let (x, y) = (
        axis(x, range(|point| point.0)),
        axis(y, range(|point| point.1)),
    );
    let count = curves.len();
    let layer = |(index, (name, points))| Layer {
        name,
        ink: Ink::of_curve(index, count),
        shape: LayerShape::Line(points),
    };
    Chart::new(
        title,
        x,
        y,
        curves.into_iter().enumerate().map(layer).collect(),
    )
    .svg()
}

/// Charts and their file names; none if only scenes were run.
///
/// # Errors
/// A value is not finite.
pub fn charts(results: &ExtremesResults) -> Result<Vec<(&'static str, String)>> {
    if results.drifts.is_empty() {
        return Ok(Vec::new());
    }
    let reversal = results.reversals[0]
        .iter()
        .map(|reversal| {
            let points = reversal
                .points
                .iter()
                .map(|&(n, distance)| (n, distance.log10()))
                .collect();
            (format!("area fraction {}", reversal.fraction), points)
        })
        .collect();
    let drift = results
        .drifts
        .iter()
        .map(|drift| {
            let sound = drift.changes.iter().filter(|change| change.1 > 0.0);
            (
                drift.name.to_owned(),
                sound
                    .map(|&(n, change)| (n.log10(), change.log10()))
                    .collect(),
            )
        })
        .collect();
    Ok(vec![
        (
            "reversal.svg",
            chart(
                "Time reversal",
                [
                    "collisions of each disc on the way forward",
                    "lg distance from the start (sides)",
                ],
                reversal,
            )?,
        ),
        (
            "drift.svg",
            chart(
                "Change of energy",
                ["lg collisions", "lg relative change (rms)"],
                drift,
            )?,
        ),
    ])
}
