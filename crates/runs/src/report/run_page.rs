//! The page of a run, or of merged runs, from the contents of its folder.

use std::fmt::Write as _;

use anyhow::Result;
use carom::{Scene, engine::MeasureFrom};
use carom_report::page::{DataChart, Page, PagePart};
use carom_tables::{Figure, Summary};

use super::{
    contents::{FolderContents, FolderKind, FolderState, MEASURED_FROM},
    evidence::Charts,
    files,
    verdict::{self, FIXED_BODIES},
};
use crate::{
    animation::FLIGHTS, schedule::stages, units::in_words, visible_region::caption_of,
    whole_box::MAPS,
};

/// A longer scene file is not repeated on the page (bytes).
const MAX_SCENE: usize = 100_000;

/// The page.
///
/// # Errors
/// A table cannot be drawn.
pub(super) fn html(contents: &FolderContents) -> Result<String> {
    let title = contents
        .summary
        .as_ref()
        .map_or_else(|| contents.again.clone(), |all| all.title.clone());
    let mut page = Page::new(&title, &lead(contents));
    page.verdict(&verdict::sentence(contents));
    notes(contents, &mut page);
    let charts = charts(contents)?;
    let mut pictures = system(contents);
    page.part(PagePart::Answer);
    let figures = contents
        .summary
        .as_ref()
        .map_or(&[][..], |summary| &summary.figures);
    let (state, others): (Vec<Figure>, Vec<Figure>) =
        figures.iter().cloned().partition(is_of_state);
    if !state.is_empty() {
        page.heading("State");
        page.figures(&state);
    }
    // Without charts the states of the system are the answer.
    let evidence = [contents.drawings.clone(), charts.evidence].concat();
    let lacking = 2usize.saturating_sub(evidence.len()).min(pictures.len());
    let kept = pictures.split_off(pictures.len() - lacking);
    page.charts(&[evidence, kept].concat());
    if let (Some(animation), Some(scene)) = (&contents.animation, &contents.scene) {
        page.animation(animation, &caption_of_animation(scene));
    }
    page.part(PagePart::Results);
    let summary = contents.summary.as_ref();
    if !others.is_empty() {
        page.heading("Figures");
        page.figures(&others);
    }
    if let Some(price) = &contents.price {
        price.show(&mut page);
    }
    if let [header, rows @ ..] = contents.runs.as_slice() {
        page.heading("Runs");
        let header: Vec<String> = header.iter().map(|name| name.replace('_', " ")).collect();
        page.table(&header.iter().map(String::as_str).collect::<Vec<_>>(), rows);
    }
    page.heading("Curves");
    page.charts(&charts.others);
    page.heading("The system");
    page.charts(&pictures);
    data(contents, &charts.undrawn, &mut page);
    again(contents, &mut page);
    if let Some(summary) = summary {
        checks(contents, summary, &mut page);
    }
    Ok(page.html())
}

/// Whether a figure belongs to the state of the system, which leads the page: temperature,
/// pressure, diffusion, and the rates of collisions and of kicks.
fn is_of_state(figure: &Figure) -> bool {
    let begins = [
        "bodies",
        FIXED_BODIES,
        "temperature kT at the end",
        "pressure",
        "compressibility factor",
        "collisions per body",
        "mean free path",
        MEASURED_FROM,
    ];
    let is_diffusion =
        figure.name.contains("diffusion coefficient") && figure.standard_error.is_some();
    is_diffusion
        || verdict::is_rate_of_kicks(figure)
        || begins
            .iter()
            .any(|begin| figure.name.starts_with(begin) && !figure.name.contains("on the walls"))
}

/// The charts of the tables. With a drawing the answer has three of them, else two.
fn charts(contents: &FolderContents) -> Result<Charts> {
    let figures = contents
        .summary
        .as_ref()
        .map_or(&[][..], |summary| &summary.figures);
    let main =
        verdict::main_figure(figures, contents.scene.as_ref()).map_or("", |figure| &figure.name);
    let count = if contents.drawings.is_empty() { 2 } else { 3 };
    Charts::new(&contents.tables, main, count)
}

/// The drawings of the measures, and the charts that carry the answer.
pub(super) fn evidence(contents: &FolderContents) -> Result<Vec<DataChart>> {
    Ok([contents.drawings.clone(), charts(contents)?.evidence].concat())
}

/// Errors, what is missing, and the note of the run, from the top.
fn notes(contents: &FolderContents, page: &mut Page) {
    let missing = contents.missing.join(", ");
    match &contents.state {
        FolderState::Ended => (),
        FolderState::Failed(error) => page.error(&format!(
            "The run ended with an error: {error}. The page shows what was measured until then."
        )),
        FolderState::Unfinished => page.error(&format!(
            "The run in this folder has not ended. To resume it: {} --resume",
            contents.again
        )),
    }
    contents
        .left_out
        .words()
        .iter()
        .for_each(|words| page.error(words));
    if let Some(units) = &contents.units {
        page.note(&in_words(units));
    }
    if !missing.is_empty() {
        page.note(&format!("Missing from the folder: {missing}."));
    }
    if let Some(Summary { note, .. }) = contents
        .summary
        .as_ref()
        .filter(|summary| !summary.note.is_empty())
    {
        page.note(note);
    }
}

/// What was run and measured.
fn lead(contents: &FolderContents) -> String {
    if contents.kind == FolderKind::Merge {
        return "Means of all runs, with errors from the blocks of all runs. What is no mean of sums is averaged \
                over the runs, with the error of its scatter among them."
            .to_owned();
    }
    let Some(scene) = &contents.scene else {
        return String::new();
    };
    let run = &scene.run;
    let mut lead = format!(
        "Run from t = 0 to {}, sampled every {}.",
        run.until, run.sample_interval
    );
    let end = contents
        .summary
        .as_ref()
        .map_or(run.until, |summary| summary.totals.simulated_time);
    if run.stop.is_some() && contents.state == FolderState::Ended && end < run.until {
        let _ = write!(lead, " It ended at t = {end}, by the rule in run.stop.");
    }
    match run.measure_from {
        MeasureFrom::Time(time) if time > 0.0 => {
            let _ = write!(lead, " Measured from t = {time} on.");
        }
        MeasureFrom::Time(_) => {}
        MeasureFrom::Auto => {
            if let Some(from) = contents.measured_from {
                let _ = write!(
                    lead,
                    " Measured from t = {from} on, by run.measure_from = \"auto\"."
                );
            }
        }
    }
    for (index, stage) in stages::describe(scene).iter().enumerate() {
        let _ = write!(lead, " Stage {}: {stage}.", index + 1);
    }
    let measured = scene
        .measure
        .iter()
        .map(|entry| entry.name.as_ref().unwrap_or(&entry.kind));
    let observed: Vec<&str> = run
        .observe
        .iter()
        .chain(measured)
        .map(String::as_str)
        .collect();
    if !observed.is_empty() {
        let _ = write!(lead, " Observed: {}.", observed.join(", "));
    }
    lead
}

/// Pictures of the first and the last state, and maps of a large system.
fn system(contents: &FolderContents) -> Vec<DataChart> {
    let end = contents
        .summary
        .as_ref()
        .map_or(f64::NAN, |summary| summary.totals.simulated_time);
    let captions = ["At the start.".to_owned(), format!("At t = {end}.")];
    let pictures = contents
        .pictures
        .iter()
        .zip(captions)
        .zip(["start.svg", "end.svg"]);
    let picture = |((svg, caption), file): ((&Option<String>, String), &str)| {
        let svg = svg.clone()?;
        let caption = format!("{caption}{}", caption_of(&svg));
        Some(DataChart {
            svg,
            caption,
            file: file.to_owned(),
        })
    };
    let maps = contents
        .maps
        .iter()
        .zip(MAPS)
        .filter_map(|(svg, (file, caption))| {
            Some(DataChart {
                svg: svg.clone()?,
                caption: caption.to_owned(),
                file: file.to_owned(),
            })
        });
    pictures.filter_map(picture).chain(maps).collect()
}

fn caption_of_animation(scene: &Scene) -> String {
    let mut caption = format!(
        "From t = {}: the flights of the run between contacts; all digits are in {FLIGHTS}. For another moment, run \
         the scene with --set run.animation_from=T.",
        scene.run.animation_from
    );
    if !scene.stage.is_empty() {
        caption.push_str(" Later stages and thermostats do not act in it.");
    }
    caption
}

fn data(contents: &FolderContents, undrawn: &[String], page: &mut Page) {
    let mut files = files::listed(&contents.names, &contents.tables);
    for (name, content) in &mut files {
        if undrawn.contains(name) {
            content.push_str(" (fewer than two points: no chart)");
        }
    }
    page.files(&files);
}

fn again(contents: &FolderContents, page: &mut Page) {
    page.code(&contents.again);
    if !contents.configuration.is_empty() && contents.configuration.len() <= MAX_SCENE {
        page.folded(
            "The scene with all options, config.toml",
            &contents.configuration,
        );
    }
}

fn checks(contents: &FolderContents, summary: &Summary, page: &mut Page) {
    page.checks(&summary.checks);
    page.totals(&summary.totals);
    let Some(scene) = contents
        .scene
        .as_ref()
        .filter(|_| contents.kind == FolderKind::Run)
    else {
        return;
    };
    let interval = scene
        .run
        .check_interval
        .unwrap_or(scene.run.sample_interval);
    page.part(PagePart::Checks);
    page.paragraph(&format!(
        "Overlaps were searched at the start, every {interval} and at the end."
    ));
}
