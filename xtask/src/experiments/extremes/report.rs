//! The page of the experiment: guarantees, results, and limits.

use anyhow::Result;
use carom_report::{
    page::{Layout, Page},
    plot::{Axis, Chart, Layer, Shape, colour},
};
use carom_tables::Summary;
use carom_testkit::extremes::Engine;

use super::{drift::Drift, limits::Limit, results::Results, trial::Ending};

fn verdict(ending: &Ending) -> String {
    if ending.holds() { "holds".to_owned() } else { ending.seen() }
}

fn number(value: f64) -> String {
    if value.is_nan() { "never".to_owned() } else { format!("{value:.1e}") }
}

/// "up to …, then …"
fn sentence(found: &Limit) -> String {
    match &found.beyond {
        None => format!("up to {}, the end of the search", number(found.holds_up_to)),
        Some((at, ending)) => {
            format!("up to {}, then (at {}) {}", number(found.holds_up_to), number(*at), ending.seen())
        }
    }
}

/// The page.
pub fn page(results: &Results, summary: &Summary, charts: &[(&'static str, String)], command: &str) -> Page {
    let lead = "Extreme scenes, each with the bounds that must hold; parameters increased until a bound \
                fails; and the accuracy of a whole run.";
    let mut page = Page::new(&summary.title, lead);
    if !summary.note.is_empty() {
        page.note(&summary.note);
    }
    page.code(command);
    scene_section(&mut page, results);
    limit_section(&mut page, results);
    reversal_section(&mut page, results);
    drift_section(&mut page, &results.drifts);
    for (_, svg) in charts {
        page.pictures(Layout::Full, &[(svg, "")]);
    }
    page.heading("Checks");
    page.checks(&summary.checks);
    page.heading("Totals of the drift runs");
    page.totals(&summary.totals);
    page.heading("Files");
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

fn scene_section(page: &mut Page, results: &Results) {
    page.heading("Scenes");
    page.paragraph(&format!(
        "Results of the two engines: {} is the default; {} is that of Montanari (2017), for comparison.",
        Engine::Ours.name(),
        Engine::Theses.name()
    ));
    let rows: Vec<Vec<String>> = results
        .scenes
        .iter()
        .map(|(case, [ours, theses])| {
            let scene = format!("{} {}", case.id, case.name);
            vec![scene, case.must.to_owned(), verdict(ours), ours.seen(), verdict(theses)]
        })
        .collect();
    page.table(
        &["scene", "requirement", Engine::Ours.name(), "nearest to its bound", Engine::Theses.name()],
        &rows,
    );
}

fn limit_section(page: &mut Page, results: &Results) {
    page.heading("Limits");
    let rows: Vec<Vec<String>> = results
        .limits
        .iter()
        .map(|(limit, [ours, theses])| {
            let name = format!("{}: {}", limit.parameter, limit.scene);
            vec![name, number(limit.goal), sentence(ours), ours.kinds(), sentence(theses)]
        })
        .collect();
    page.table(&["parameter and scene", "goal", Engine::Ours.name(), "beyond", Engine::Theses.name()], &rows);
    page.paragraph(
        "Beyond a limit a run ends with a named error, or it continues and exceeds a bound that is measured \
         here; larger values are tried up to the end of the search. A panic or a run without end would fail a \
         check.",
    );
}

fn reversal_section(page: &mut Page, results: &Results) {
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
            vec![name, format!("{:.1}", reversal.effective_error), format!("{:.2}", reversal.rate)]
        })
        .collect();
    page.table(
        &["engine and density", "effective error (eps × side)", "e-foldings per collision of a disc"],
        &rows,
    );
}

fn drift_section(page: &mut Page, drifts: &[Drift]) {
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

const COLOURS: [plotters::style::RGBColor; 5] = [
    colour::BLUE,
    colour::VERMILLION,
    colour::GREEN,
    colour::ORANGE,
    plotters::style::RGBColor(204, 121, 167),
];

fn chart(title: &str, [x, y]: [&str; 2], curves: Vec<(String, Vec<(f64, f64)>)>) -> Result<String> {
    let all = || curves.iter().flat_map(|curve| &curve.1);
    let range = |of: fn(&(f64, f64)) -> f64| {
        let low = all().map(of).fold(f64::INFINITY, f64::min);
        let high = all().map(of).fold(f64::NEG_INFINITY, f64::max);
        let margin = (0.03 * (high - low)).max(1e-3);
        (low - margin, high + margin)
    };
    let axis = |label: &str, range| Axis { label: label.to_owned(), range };
    let (x, y) = (axis(x, range(|point| point.0)), axis(y, range(|point| point.1)));
    let layers = curves
        .into_iter()
        .zip(COLOURS.into_iter().cycle())
        .map(|((name, points), colour)| Layer { name, colour, shape: Shape::Line(points) })
        .collect();
    Chart { title: title.to_owned(), x, y, layers }.svg()
}

/// Charts and their file names; none if only scenes were run.
///
/// # Errors
/// A value is not finite.
pub fn charts(results: &Results) -> Result<Vec<(&'static str, String)>> {
    if results.drifts.is_empty() {
        return Ok(Vec::new());
    }
    let reversal = results.reversals[0]
        .iter()
        .map(|reversal| {
            let points = reversal.points.iter().map(|&(n, distance)| (n, distance.log10())).collect();
            (format!("area fraction {}", reversal.fraction), points)
        })
        .collect();
    let drift = results
        .drifts
        .iter()
        .map(|drift| {
            let sound = drift.changes.iter().filter(|change| change.1 > 0.0);
            (drift.name.to_owned(), sound.map(|&(n, change)| (n.log10(), change.log10())).collect())
        })
        .collect();
    Ok(vec![
        (
            "reversal.svg",
            chart(
                "Time reversal",
                [
                    "collisions of each disc on the way forward",
                    "lg of the distance from the initial state (sides)",
                ],
                reversal,
            )?,
        ),
        (
            "drift.svg",
            chart(
                "Change of energy",
                ["lg collisions", "lg of the relative root mean square change"],
                drift,
            )?,
        ),
    ])
}
