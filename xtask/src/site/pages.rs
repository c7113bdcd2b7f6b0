//! The pages of the site: the gallery, a page for each card, and how the results were validated.

use carom_report::page::{GalleryCard, Layout, Page, PagePart};
use carom_runs::manifest::{REVISION, RUSTC};
use carom_sweeps::expect::{EXPECTATIONS, ExpectationAnswer};
use carom_tables::{named, with_error};

use super::{picture::Pictures, results::CardResults};

/// File names of the pages.
pub const GALLERY: &str = "index.html";
/// The page of validation.
pub const VALIDATION: &str = "validation.html";

/// Parts of the site besides the gallery, with their names: path relative to the site.
pub type SiteParts = Vec<(String, String)>;

/// Beginning of the page of a short form.
const SHORT: &str = "These are the short forms of the studies: their errors are larger than those \
                     of the whole studies.";

/// Links to all parts from a page so many folders below the site.
fn navigation(parts: &SiteParts, own: &str, up: &str) -> Vec<(String, String)> {
    parts
        .iter()
        .filter(|(path, _)| path != own)
        .map(|(path, name)| (format!("{up}{path}"), name.clone()))
        .collect()
}

/// The gallery.
pub fn gallery(
    all: &[(CardResults, Pictures)],
    parts: &SiteParts,
    is_quick: bool,
    command: &str,
) -> String {
    let mut page = Page::new(
        "carom: gallery",
        "Exact, event-driven simulation of two-dimensional gases of rigid molecules. Each card is a \
         study that the program carries: run it yourself by the commands on its page. ± is one \
         standard error.",
    );
    page.navigation(&navigation(parts, GALLERY, ""));
    page.verdict(&sum_in_words(all));
    for (results, _) in all.iter().filter(|(results, _)| !results.passed()) {
        for fault in &results.faults {
            page.error(&format!("{}: {fault}", results.card.study));
        }
    }
    if is_quick {
        page.note(SHORT);
    }
    page.part(PagePart::Answer);
    let cards: Vec<GalleryCard> = all.iter().map(card).collect();
    page.gallery(&cards);
    page.code(command);
    page.html()
}

/// How many studies and results are as expected.
fn sum_in_words(all: &[(CardResults, Pictures)]) -> String {
    let count = all.len();
    let summaries = || {
        all.iter()
            .filter_map(|(results, _)| results.summary.as_ref())
    };
    let judged: usize = summaries().map(|summary| summary.judged().count()).sum();
    let collisions: u64 = summaries().map(|summary| summary.collisions).sum();
    let failed = all.iter().filter(|(results, _)| !results.passed()).count();
    let held = match failed {
        0 => format!("{count} studies, {judged} results: all as expected."),
        _ => format!("FAILED: {failed} of {count} studies do not hold; {judged} results."),
    };
    let seconds: f64 = summaries()
        .map(carom_sweeps::summary::SweepSummary::cpu_seconds)
        .sum();
    let minutes = seconds / 60.0;
    format!("{held} {collisions} exact collisions in {minutes:.0} minutes of processor time.")
}

fn card((results, pictures): &(CardResults, Pictures)) -> GalleryCard {
    let card = &results.card;
    let result = results.headline().map_or_else(
        || ["no result", "", "–", "–"].map(str::to_owned),
        |(point, answer)| {
            let quantity = named(&answer.quantity, &answer.unit);
            let label = if results
                .summary
                .as_ref()
                .is_some_and(|all| all.points.len() > 1)
            {
                point.short_label()
            } else {
                String::new()
            };
            [quantity, label, measured(answer), answer.rounded()]
        },
    );
    GalleryCard {
        title: card.title.clone(),
        link: card.page(),
        sentence: card.sentence.clone(),
        svg: pictures.small(card.picture).to_owned(),
        result,
        source: results.headline().map_or_else(
            || card.source.clone(),
            |(_, answer)| source(answer, &card.source),
        ),
        passed: results.passed(),
        verdict: [results.verdict(), results.processor_time()],
        subjects: card.subjects.clone(),
        words: format!("{} {} {}", card.words, card.study, card.source),
    }
}

/// The source of an answer, or that of its card.
fn source(answer: &ExpectationAnswer, of_card: &str) -> String {
    if answer.source.is_empty() {
        of_card.to_owned()
    } else {
        answer.source.clone()
    }
}

fn measured(answer: &ExpectationAnswer) -> String {
    with_error(answer.value, answer.standard_error)
}

/// The page of a card.
pub fn of_card(
    results: &CardResults,
    pictures: &Pictures,
    parts: &SiteParts,
    is_quick: bool,
) -> String {
    let card = &results.card;
    let mut page = Page::new(&card.title, &card.sentence);
    page.navigation(&navigation(parts, "", "../"));
    page.verdict(&format!("{}{}.", first_answer(results), results.verdict()));
    for fault in &results.faults {
        page.error(fault);
    }
    if is_quick {
        page.note(SHORT);
    }
    page.part(PagePart::Answer);
    charts(&mut page, pictures);
    page.part(PagePart::Results);
    facts(&mut page, results);
    table(&mut page, "All results", results);
    files(&mut page, &format!("../{}", card.results_name(is_quick)));
    page.code(&commands(results, is_quick));
    if let Ok(example) = card.example() {
        page.folded(
            "The scene and what is expected of it, in full",
            example.text.trim_end(),
        );
    }
    page.html()
}

/// The first figure of a card and what is expected of it, as the beginning of a sentence; empty
/// without figures.
fn first_answer(results: &CardResults) -> String {
    results.headline().map_or_else(String::new, |(_, answer)| {
        format!(
            "{}: {}, expected {}. ",
            named(&answer.quantity, &answer.unit),
            measured(answer),
            answer.rounded()
        )
    })
}

fn charts(page: &mut Page, pictures: &Pictures) {
    let mut charts: Vec<(&str, &str)> = pictures
        .charts
        .iter()
        .map(|svg| (svg.as_str(), ""))
        .collect();
    if !pictures.start.is_empty() {
        let caption = "The bodies at the start of the first point.";
        charts.push((pictures.start.as_str(), caption));
    }
    page.pictures(Layout::Beside, &charts);
}

/// The list of the files in the folder of the results.
fn files(page: &mut Page, folder: &str) {
    page.files(&[
        (
            format!("{folder}/report.html"),
            "the page of the sweep, with all charts".to_owned(),
        ),
        (
            format!("{folder}/table.csv"),
            "all figures of all points".to_owned(),
        ),
        (
            format!("{folder}/summary.json"),
            "figures, totals and checks".to_owned(),
        ),
        (
            format!("{folder}/study.toml"),
            "the study with the scene and all values".to_owned(),
        ),
        (
            format!("{folder}/manifest.json"),
            "program, compiler, machine and command".to_owned(),
        ),
    ]);
}

/// The commands that run a card again.
fn commands(results: &CardResults, is_quick: bool) -> String {
    let (study, file) = (&results.card.study, results.card.file());
    let quick = if is_quick { " --quick" } else { "" };
    format!("carom example {study} --out {file}\ncarom sweep {file}{quick}")
}

fn facts(page: &mut Page, results: &CardResults) {
    let collisions = results
        .summary
        .as_ref()
        .map_or(0, |summary| summary.collisions);
    page.facts(&[
        ("source of what is expected", results.card.source.clone()),
        ("processor time", results.processor_time()),
        ("collisions", collisions.to_string()),
        ("begun by revision", results.revision.clone()),
    ]);
}

/// All results that are judged or shown, against what is expected.
fn table(page: &mut Page, heading: &str, results: &CardResults) {
    let Some(summary) = &results.summary else {
        return;
    };
    page.heading(heading);
    let answers = summary.points.iter().flat_map(|point| {
        let label = point.short_label();
        point
            .answers
            .iter()
            .map(move |answer| answer.cells(label.clone()))
    });
    page.table(&EXPECTATIONS, &answers.collect::<Vec<_>>());
}

/// How the results were validated: the method, a line for each study, and all results.
pub fn validation(
    all: &[(CardResults, Pictures)],
    parts: &SiteParts,
    is_quick: bool,
    command: &str,
) -> String {
    let mut page = Page::new(
        "How results were validated",
        "All figures of the theory set, from the folders that its sweeps have written.",
    );
    page.navigation(&navigation(parts, VALIDATION, ""));
    page.verdict(&sum_in_words(all));
    if is_quick {
        page.note(SHORT);
    }
    page.part(PagePart::Answer);
    for paragraph in METHOD {
        page.paragraph(paragraph);
    }
    page.paragraph(&scatter_in_words(all));
    page.heading("Studies");
    let rows: Vec<Vec<String>> = all.iter().map(|(results, _)| row(results)).collect();
    page.table(
        &[
            "study",
            "result",
            "largest share of the tolerance",
            "collisions",
            "source",
        ],
        &rows,
    );
    page.part(PagePart::Results);
    for (results, _) in all {
        table(&mut page, &results.card.title, results);
    }
    let pages = all
        .iter()
        .map(|(results, _)| (results.card.page(), results.card.title.clone()));
    page.files(&pages.collect::<Vec<_>>());
    let revision = REVISION.unwrap_or("unknown");
    page.code(&format!("{command}\n# revision {revision}, {RUSTC}"));
    page.html()
}

/// What a result must satisfy to be as expected.
const METHOD: [&str; 3] = [
    "Each study has a scene, a seed, and what is expected of its results: an exact value, the \
     formula of a theory, a published value, or a value from another program. A result is as \
     expected if it differs by at most the sum of some standard errors (4 unless the study says \
     otherwise), a relative and an absolute tolerance, which the study states. Bounds must be \
     exceeded by as much.",
    "Standard errors come from blocks of all replicas. Each replica also checks itself: no pair \
     overlaps, energy is conserved up to rounding or booked, and figures that test a prediction \
     of their own measure are judged at 6 standard errors.",
    "A result that is only shown is a theory beyond its range, for the eye; it is not counted.",
];

/// How far results lie from what is expected, in standard errors.
fn scatter_in_words(all: &[(CardResults, Pictures)]) -> String {
    let answers = all
        .iter()
        .filter_map(|(results, _)| results.summary.as_ref())
        .flat_map(carom_sweeps::summary::SweepSummary::judged)
        .filter(|(_, answer)| !answer.is_bound())
        .filter_map(|(_, answer)| {
            Some(answer.difference / answer.standard_error.filter(|error| *error > 0.0)?)
        });
    let deviations: Vec<f64> = answers.map(f64::abs).collect();
    let within = |errors: f64| {
        let count = deviations
            .iter()
            .filter(|deviation| **deviation <= errors)
            .count();
        100.0 * count as f64 / deviations.len().max(1) as f64
    };
    format!(
        "Of {} results with a standard error that are expected to be a value, {:.0} % lie within one \
         standard error of it, {:.0} % within two and {:.0} % within four. Exact expectations alone \
         would give 68, 95 and 100 %; theories that are approximations make it less.",
        deviations.len(),
        within(1.0),
        within(2.0),
        within(4.0),
    )
}

/// A study in the table of all.
fn row(results: &CardResults) -> Vec<String> {
    let summary = results.summary.as_ref();
    let shares = summary.into_iter().flat_map(|summary| {
        summary
            .judged()
            .filter(|(_, answer)| !answer.is_bound() && answer.allowed > 0.0)
            .map(|(_, answer)| (answer.difference / answer.allowed).abs())
    });
    let share = shares
        .reduce(f64::max)
        .map_or_else(|| "–".to_owned(), |share| format!("{share:.2}"));
    vec![
        results.card.study.clone(),
        results.verdict(),
        share,
        summary.map_or_else(|| "–".to_owned(), |summary| summary.collisions.to_string()),
        results.card.source.clone(),
    ]
}
