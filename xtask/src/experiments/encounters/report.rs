//! Tables and page of the experiment.

use carom_report::page::{Layout, Page, PagePart, checks_in_words};
use carom_tables::{Summary, averages::median};
use carom_testkit::oracle::OracleVerdict;

use super::{
    charts::EncounterCharts,
    overall::{FAMILIES, Overall, overall},
    results::{ClassResult, EncounterResults},
    settings::BASELINE,
    tally::{EncounterTally, FAR_OFF},
};
use carom_methods::AnyDetector;

fn number(value: Option<f64>) -> String {
    value.map_or_else(
        || "–".to_owned(),
        |value| {
            if value == 0.0 {
                "0".to_owned()
            } else {
                format!("{value:.1e}")
            }
        },
    )
}

fn ratio(value: Option<f64>) -> String {
    match value {
        None => "–".to_owned(),
        Some(value) if value >= 10.0 => format!("{value:.0}"),
        Some(value) => format!("{value:.2}"),
    }
}

/// A count, or its upper bound if it is zero.
fn count(tally: &EncounterTally, verdict: OracleVerdict) -> String {
    match tally.count(verdict) {
        0 if tally.judged() == 0 => "–".to_owned(),
        0 => "0".to_owned(),
        count => count.to_string(),
    }
}

const CLASS_HEADER: [&str; 15] = [
    "class",
    "cases",
    "contacts",
    "missed",
    "late",
    "early",
    "false",
    "at most (95 %)",
    "graze within 2E",
    "free until",
    "gave up",
    "median |Δt|",
    "99.9 %",
    "largest",
    "evaluations",
];

fn class_cells(name: &str, tally: &EncounterTally) -> Vec<String> {
    let wrong = [
        OracleVerdict::Missed,
        OracleVerdict::Late,
        OracleVerdict::Early,
        OracleVerdict::False,
    ];
    let none = wrong.iter().all(|verdict| tally.count(*verdict) == 0);
    let mut cells = vec![
        name.to_owned(),
        tally.judged().to_string(),
        tally.contacts.to_string(),
    ];
    cells.extend(wrong.map(|verdict| count(tally, verdict)));
    cells.push(if none {
        number(Some(tally.upper_bound_of_none()))
    } else {
        "–".to_owned()
    });
    cells.extend(
        [
            OracleVerdict::Graze,
            OracleVerdict::FreeUntil,
            OracleVerdict::GaveUp,
        ]
        .map(|verdict| count(tally, verdict)),
    );
    cells.extend([0.5, 0.999, 1.0].map(|share| number(tally.quantile(share))));
    cells.push(format!("{:.1}", tally.evaluations_per_query()));
    cells
}

fn class_rows(results: &EncounterResults, setting: usize) -> Vec<Vec<String>> {
    let rows = results
        .classes
        .iter()
        .map(|class| class_cells(&class.name, &class.tallies[setting]));
    let all = EncounterTally::sum(results.classes.iter().map(|class| &class.tallies[setting]));
    rows.chain([class_cells("all", &all)]).collect()
}

const OVERALL_HEADER: [&str; 13] = [
    "detector",
    "setting",
    "cases",
    "time over Exact",
    "wrong (mean of classes)",
    "missed",
    "late",
    "early",
    "false",
    "free until",
    "gave up",
    "median |Δt|",
    "99.9 %",
];

fn overall_cells(of: &Overall) -> Vec<String> {
    let wrong = if of.wrong == 0.0 {
        format!("0 (< {:.0e})", of.tally.upper_bound_of_none())
    } else {
        format!("{:.2e}", of.wrong)
    };
    let mut cells = vec![
        FAMILIES[of.family].to_owned(),
        of.setting.clone(),
        of.searched.to_string(),
        ratio(of.ratio),
        wrong,
    ];
    let verdicts = [
        OracleVerdict::Missed,
        OracleVerdict::Late,
        OracleVerdict::Early,
        OracleVerdict::False,
        OracleVerdict::FreeUntil,
        OracleVerdict::GaveUp,
    ];
    cells.extend(verdicts.map(|verdict| count(&of.tally, verdict)));
    cells.extend([0.5, 0.999].map(|share| number(of.tally.quantile(share))));
    cells
}

/// Time relative to Exact, by class, for one setting of each detector.
fn time_rows(results: &EncounterResults) -> Vec<Vec<String>> {
    let step = |step: f64| {
        results.settings.iter().position(
            |setting| matches!(setting.detector, AnyDetector::FixedStep(fixed) if fixed.step == step),
        )
    };
    let columns = [Some(BASELINE), step(1e-2), step(1e-3), step(1e-4)];
    let row = |class: &ClassResult| {
        let at =
            |index: Option<usize>| ratio(index.and_then(|index| Some(class.timings[index]?.ratio)));
        let exact = class.timings[0].map_or_else(
            || "–".to_owned(),
            |timing| format!("{:.0}", timing.exact * 1e9),
        );
        let mut cells = vec![class.name.clone(), class.about.clone(), exact];
        cells.extend(columns.map(at));
        cells.push(at(results.settings.len().checked_sub(1)));
        cells.push(ratio(median(&mut class.parry.ratios.clone())));
        cells.push(format!("{} of {}", class.parry.hung, class.parry.calls));
        cells
    };
    results.classes.iter().map(row).collect()
}

/// The page.
pub fn page(
    results: &EncounterResults,
    summary: &Summary,
    charts: &EncounterCharts,
    command: &str,
) -> Page {
    let mut page = Page::new(
        &summary.title,
        "Two molecules move and rotate: when is their first contact? Every detector searches the same pairs, \
         easy ones and all known hard ones, and an oracle with 30 digits judges each answer.",
    );
    if !summary.note.is_empty() {
        page.note(&summary.note);
    }
    page.verdict(&verdict(results, summary));
    page.checks(&summary.checks);
    page.part(PagePart::Answer);
    cost_section(&mut page, results, charts);
    page.part(PagePart::Results);
    class_sections(&mut page, results);
    page.heading("Method of the oracle");
    let unresolved: usize = results.classes.iter().map(|class| class.unresolved).sum();
    page.paragraph(&format!(
        "It excludes intervals of time by a bound on the second derivative of the squared distance, in \
         double-double arithmetic, and bisects the others; it shares no code with any detector. In \
         {unresolved} cases it did not finish within its limit; these are excluded from all other counts.",
    ));
    page.code(command);
    page.links([
        "answers.csv",
        "times.csv",
        "parry.csv",
        "summary.json",
        "manifest.json",
    ]);
    page
}

/// What the exact detector and that of the thesis get wrong.
fn verdict(results: &EncounterResults, summary: &Summary) -> String {
    let words = |setting: usize| {
        let tally =
            EncounterTally::sum(results.classes.iter().map(|class| &class.tallies[setting]));
        let wrong = [
            OracleVerdict::Missed,
            OracleVerdict::Late,
            OracleVerdict::Early,
            OracleVerdict::False,
        ];
        let wrong: u64 = wrong.iter().map(|verdict| tally.count(*verdict)).sum();
        format!("{wrong} of {}", tally.judged())
    };
    let name = |setting: usize| results.settings[setting].detector.name();
    format!(
        "{} is wrong in {} first contacts, {} in {}. {}",
        name(0),
        words(0),
        name(BASELINE),
        words(BASELINE),
        checks_in_words(&summary.checks)
    )
}

fn cost_section(page: &mut Page, results: &EncounterResults, charts: &EncounterCharts) {
    page.subheading("Cost of accuracy, all classes");
    page.table(
        &OVERALL_HEADER,
        &overall(results)
            .iter()
            .map(overall_cells)
            .collect::<Vec<_>>(),
    );
    page.pictures(
        Layout::Full,
        &[
            (
                &charts.wrong,
                "One point for each detector and setting; fast settings are left, correct ones are low. An \
                 answer is wrong if the contact is missed, false, unresolved, or late or early by more than a \
                 millionth of a natural time. Rings with downward lines: no event in n cases, drawn at the \
                 upper 95 % bound 3/n. Undecided: certified free until some time, from which the search has \
                 to continue.",
            ),
            (
                &charts.error,
                "Error of the contact times: a dot at the median, a line up to 99.9 %. The upper ends are \
                 set by grazes and fast rotors, whose contact times double precision does not determine \
                 better.",
            ),
        ],
    );
    page.paragraph(&format!(
        "Time is the processor time of one thread, measured in turn with Exact on the same pairs: the median \
         over rounds, then the geometric mean over the classes. Slow detectors search as many pairs of a \
         class, in order, as fit into a fixed number of evaluations; see the column of cases. A tolerance is \
         a parameter of this experiment only. An error above {FAR_OFF:e} natural times is wrong at any \
         tolerance."
    ));
}

fn class_sections(page: &mut Page, results: &EncounterResults) {
    page.heading("Exact by class");
    page.paragraph(
        "A contact must be reported before the overlap exceeds 2 E, where E is the bound on rounding, and \
         not while the atoms are farther apart than 2 E. Contacts that are not deeper may be reported or \
         omitted: graze within 2E. Times are in natural times of the pair.",
    );
    page.table(&CLASS_HEADER, &class_rows(results, 0));
    page.heading("GoldenSecant by class");
    page.paragraph(
        "Montanari (2017), chapter 2, with corrections: crop ½, tolerance of five epsilon, the earliest of \
         all atom pairs, one new evaluation in each round of the golden section.",
    );
    page.table(&CLASS_HEADER, &class_rows(results, BASELINE));
    page.heading("Time relative to Exact by class");
    let header = [
        "class",
        "description",
        "Exact (ns)",
        "GoldenSecant",
        "FixedStep 1e-2",
        "1e-3",
        "1e-4",
        "BoundingCircles",
        "parry",
        "parry did not return",
    ];
    page.table(&header, &time_rows(results));
    page.heading("parry by class");
    page.paragraph(
        "cast_shapes_nonlinear of parry2d-f64 on the same molecules as compounds of discs, warm calls. A \
         call that does not return within a tenth of a second counts as unresolved. It stops at a small \
         tolerance in distance, so many of its contacts are early or late by the strict rule; above, an error \
         of a millionth of a natural time counts as wrong.",
    );
    let rows = results
        .classes
        .iter()
        .map(|class| class_cells(&class.name, &class.parry.tally));
    page.table(&CLASS_HEADER, &rows.collect::<Vec<_>>());
}
