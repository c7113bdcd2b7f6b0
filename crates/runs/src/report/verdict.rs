//! The answer of a run in words: what was simulated, how, whether all checks passed, and the main
//! figure against its prediction.

use std::fmt::Write as _;

use carom::Scene;
use carom_report::page::checks_in_words;
use carom_tables::{Figure, Summary, named, with_error};

use super::{
    contents::{FolderContents, FolderKind},
    stationarity_in_words::{is_of_every_run, judged, never_settles, stationarity_in_words},
    tests_in_words::tests_in_words,
};
use crate::measures::requests;

/// The first words of a note on a method that is not exact.
pub const NOT_EXACT: &str = "NOT EXACT";

/// Name of the number of bumpers and fixed molecules.
pub const FIXED_BODIES: &str = "fixed bodies";

/// Name of the measure of the kicks on one body, and of the figure of their rate.
const KICKS: &str = "kicks";

/// A value leads a page only if it is this number of times its standard error. Smaller: noise
/// leads. Larger: small quantities never do.
const CLEAR: f64 = 3.0;

/// The verdict of a run or of merged runs.
pub(super) fn sentence(contents: &FolderContents) -> String {
    let Some(summary) = &contents.summary else {
        return "This folder is incomplete: there are no results yet.".to_owned();
    };
    let figures: Vec<_> = summary.figures.iter().map(|figure| ("", figure)).collect();
    let mut parts: Vec<String> = stationarity_in_words(&figures).into_iter().collect();
    parts.push(what(contents, summary));
    parts.push(checks_in_words(&summary.checks));
    if !never_settles(&summary.figures) {
        parts.extend(main_figure(&summary.figures, contents.scene.as_ref()).map(measured));
    }
    parts.extend(tests_in_words(&figures));
    parts.join(" ")
}

/// What was simulated, and whether the method is exact.
fn what(contents: &FolderContents, summary: &Summary) -> String {
    let count = |name| {
        summary
            .figures
            .iter()
            .find(|figure| figure.name == name)
            .map(|figure| figure.value)
    };
    let fixed = count(FIXED_BODIES).unwrap_or(0.0);
    let bodies = count("bodies").map_or_else(String::new, |bodies| {
        let plural = if bodies == 1.0 { "body" } else { "bodies" };
        match fixed {
            0.0 => format!(" of {bodies} {plural}"),
            _ => format!(" of {bodies} {plural}, {fixed} of them fixed,"),
        }
    });
    let totals = &summary.totals;
    let method = if summary.note.contains(NOT_EXACT) {
        NOT_EXACT
    } else {
        "exact"
    };
    let plural = if totals.collisions == 1 { "" } else { "s" };
    let time = with_error(totals.simulated_time, None);
    let span = match contents.kind {
        FolderKind::Run => format!("to t = {time}"),
        FolderKind::Merge | FolderKind::Sweep | FolderKind::Experiment => {
            format!(
                "in {} runs, {time} time units together",
                contents.runs.len().saturating_sub(1)
            )
        }
    };
    format!(
        "{} collision{plural}{bodies} {span}; the dynamics is {method}.",
        totals.collisions
    )
}

/// Whether a figure is the rate of the kicks on a body.
pub(crate) fn is_rate_of_kicks(figure: &Figure) -> bool {
    let label = figure.name.strip_prefix(KICKS);
    label.is_some_and(|label| label.is_empty() || label.starts_with(", "))
}

/// Whether the kicks on bodies are all that a scene asks for, besides checks and files.
fn asks_for_kicks_alone(scene: &Scene) -> bool {
    let requests = requests(scene).unwrap_or_default();
    let mut measured = requests
        .iter()
        .filter(|request| !request.kind.figures.is_empty())
        .peekable();
    measured.peek().is_some() && measured.all(|request| request.kind.name == KICKS)
}

/// The figure that a reader looks for: the first with an error and a prediction; what every run
/// measures, the collision rate, comes after what the scene asks for, and what is only apparent or
/// lost in its error comes last, predicted or not. What is 0 by symmetry is a test of the run and
/// no answer. Of a scene that asks for kicks alone it is their rate: equipartition and the symmetry
/// of the body, which predict other figures, are tests too.
pub(super) fn main_figure<'a>(figures: &'a [Figure], scene: Option<&Scene>) -> Option<&'a Figure> {
    let has_error = |figure: &&Figure| {
        figure.standard_error.is_some_and(|error| error > 0.0) && figure.prediction != Some(0.0)
    };
    if scene.is_some_and(asks_for_kicks_alone) {
        return figures
            .iter()
            .filter(has_error)
            .find(|figure| is_rate_of_kicks(figure));
    }
    let is_own = |figure: &&Figure| !is_of_every_run(figure);
    let predicted = || {
        figures
            .iter()
            .filter(has_error)
            .filter(|figure| figure.prediction.is_some())
    };
    let is_clear = |figure: &&Figure| {
        let error = figure.standard_error.unwrap_or(0.0);
        !figure.name.starts_with("apparent") && figure.value.abs() > CLEAR * error
    };
    let own = || figures.iter().filter(has_error).filter(is_own);
    predicted()
        .filter(is_own)
        .find(is_clear)
        .or_else(|| predicted().find(is_clear))
        .or_else(|| own().find(is_clear))
        .or_else(|| own().next())
}

fn measured(figure: &Figure) -> String {
    let value = with_error(figure.value, figure.standard_error);
    let changes = judged(figure).is_some_and(|found| !found.is_stationary);
    let measured = if changes {
        "Mean while it changed"
    } else {
        "Measured"
    };
    let mut text = format!("{measured}: {} {value}", named(&figure.name, &figure.unit));
    if let (Some(prediction), Some(error)) = (figure.prediction, figure.standard_error) {
        let away = (figure.value - prediction).abs() / error;
        let prediction = with_error(prediction, None);
        let _ = if figure.is_approximate() {
            write!(text, "; in an approximation {prediction}")
        } else {
            write!(
                text,
                "; predicted {prediction}, {away:.1} standard errors away"
            )
        };
    }
    text.push('.');
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_main_figure_is_one_that_the_scene_asks_for_and_theory_predicts() {
        let rate = Figure::new("collisions per body", 2.0, "1/time")
            .error(0.1)
            .predicted(2.1, "Enskog");
        let pressure = Figure::new("pressure", 7.0, "1")
            .error(0.5)
            .predicted(8.0, "Liu");
        let plain = Figure::new("order", 1.0, "1").error(0.1);
        let name =
            |figures: &[Figure]| main_figure(figures, None).map(|figure| figure.name.clone());
        assert_eq!(
            name(&[rate.clone(), plain.clone(), pressure.clone()]).as_deref(),
            Some("pressure")
        );
        assert_eq!(
            name(&[rate.clone(), plain.clone()]).as_deref(),
            Some("collisions per body")
        );
        let symmetric = Figure::new("mean cos", 0.01, "1")
            .error(0.1)
            .predicted(0.0, "isotropy");
        let apparent = Figure::new("apparent D", 1.0, "1").error(0.01);
        let lost = Figure::new("D", 1.0, "1").error(4.0);
        assert_eq!(
            name(&[apparent, lost, plain.clone()]).as_deref(),
            Some("order")
        );
        assert_eq!(name(&[symmetric, plain.clone()]).as_deref(), Some("order"));
        assert_eq!(name(&[plain]).as_deref(), Some("order"));
        assert_eq!(name(&[Figure::new("bodies", 1.0, "1")]), None);
        assert_eq!(
            measured(&pressure),
            "Measured: pressure 7.00 ± 0.50; predicted 8, 2.0 standard errors away."
        );
        let rough = Figure::new("D", 7.0, "1")
            .error(0.5)
            .predicted(8.0, "approximation, first Sonine");
        assert_eq!(
            measured(&rough),
            "Measured: D 7.00 ± 0.50; in an approximation 8."
        );
    }

    #[test]
    fn the_rate_of_the_kicks_leads_where_they_alone_are_measured() {
        let figures = [
            Figure::new("collisions per body that moves", 2.0, "1/time")
                .error(0.1)
                .predicted(2.1, "Enskog"),
            Figure::new("kicks, tee", 35.0, "1/time").error(0.2),
            Figure::new("kT along x′, tee", 1.0, "energy")
                .error(0.02)
                .predicted(1.0, "equipartition"),
            Figure::new("kicks by atom, χ² per degree of freedom, tee", 1.0, "1").error(0.3),
        ];
        let scene = |observe: &str| {
            let text = format!("[run]\nobserve = [{observe}]");
            Scene::from_toml(&text).unwrap()
        };
        let lead = |figures: &[Figure], observe: &str| {
            main_figure(figures, Some(&scene(observe))).map(|figure| figure.name.clone())
        };
        for observe in ["\"kicks:tee\"", "\"energy\", \"kicks:tee\", \"events\""] {
            let found = lead(&figures, observe);
            assert_eq!(found.as_deref(), Some("kicks, tee"), "{observe}");
        }
        let found = lead(&figures, "\"kicks:tee\", \"temperature:tee\"");
        assert_eq!(found.as_deref(), Some("kT along x′, tee"));
        // Too short for an error of the kicks: the collision rate does not stand for them.
        let short = [
            figures[0].clone(),
            Figure::new("kicks, tee", 35.0, "1/time"),
        ];
        assert_eq!(lead(&short, "\"kicks:tee\""), None);
    }
}
