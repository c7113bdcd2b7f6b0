//! The page: first the advice, one table and one picture over all knobs, then everything else.

use anyhow::Result;
use carom_report::page::{Layout, Page, PagePart};
use carom_runs::{output::Folder, price::TOLERANCE};
use carom_tables::{Check, Figure, Summary, Totals, with_error};
use serde::Serialize;

use super::{
    advice, chart,
    knobs::LeftOutKnob,
    results::{SceneResult, TradeRow, rows},
    table,
};

/// Files of the tables.
const SETTINGS: &str = "settings.csv";
const MEASURES: &str = "measures.csv";

/// `summary.json`: figures and checks, and all numbers of all settings.
#[derive(Debug, Clone, Serialize)]
struct File<'a> {
    #[serde(flatten)]
    summary: &'a Summary,
    /// The advice on the scene.
    advice: String,
    /// The settings.
    settings: Vec<TradeRow>,
    /// Knobs that do not apply, with the reason.
    left_out: &'a [LeftOutKnob],
    /// What could not be measured in the time allowed.
    unresolved: Vec<String>,
}

/// Figures and checks of the results.
pub fn summary(title: String, note: String, result: &SceneResult) -> Summary {
    let exact = result.exact();
    let totals = Totals {
        overlapping_pairs: exact.tally.overlapping.max(exact.physics.overlapping),
        max_overlap: exact.tally.deepest.max(exact.physics.deepest),
        collisions: exact.tally.judged,
        simulated_time: exact.physics.span[1] - exact.physics.span[0],
        collisions_per_second: 1e9 / result.nanoseconds,
        ..Totals::default()
    };
    let (checks, figures) = (checks(result).to_vec(), figures(result));
    Summary {
        title,
        note,
        totals,
        checks,
        figures,
        runs: Vec::new(),
    }
}

/// Checks that the exact detector misses no contact and lets no bodies overlap, with every setting
/// that affects speed only.
fn checks(result: &SceneResult) -> [Check; 2] {
    let safe = result
        .found
        .iter()
        .filter(|found| found.knob.setting.is_exact());
    let wrong = safe
        .clone()
        .map(|found| found.tally.wrong())
        .fold(0.0, f64::max);
    let pairs = safe
        .map(|found| found.tally.overlapping.max(found.physics.overlapping))
        .max()
        .unwrap_or(0);
    let name = &result.name;
    [
        Check::at_most(
            &format!("{name}: wrong contacts in a million, exact settings"),
            wrong,
            0.0,
        ),
        Check::at_most(
            &format!("{name}: overlapping pairs, exact settings"),
            pairs as f64,
            0.0,
        ),
    ]
}

fn figures(result: &SceneResult) -> Vec<Figure> {
    let mut figures = Vec::new();
    for found in &result.found {
        let what = format!("{}, {}", result.name, found.knob.title());
        let mut add = |name: &str, value: Option<f64>, unit: &str| {
            figures.extend(value.map(|value| Figure::new(format!("{name}: {what}"), value, unit)));
        };
        let is_judged = found.tally.judged > 0;
        add(
            "wrong contacts in a million",
            is_judged.then(|| found.tally.wrong()),
            "1",
        );
        add("time over Exact", found.time.map(|time| time.median), "1");
        let deepest = found.tally.deepest.max(found.physics.deepest);
        add(
            "deepest overlap",
            (found.tally.intervals > 0).then_some(deepest),
            "diameter",
        );
        add(
            "effective error",
            found.effective.map(|effective| effective.value),
            "side",
        );
    }
    figures
}

/// Writes the charts, the tables and `summary.json`; returns the charts.
///
/// # Errors
/// A file cannot be written.
pub fn write(folder: &Folder, result: &SceneResult, summary: &Summary) -> Result<TradeCharts> {
    let charts = chart::draw(result)?;
    for (name, svg) in &charts {
        folder.write(name, svg)?;
    }
    folder.write_table(SETTINGS, &table::FULL, table::full(result))?;
    folder.write_table(MEASURES, &table::MEASURES, table::measures(result))?;
    let file = File {
        summary,
        advice: advice::advice(result),
        settings: rows(result),
        left_out: &result.left_out,
        unresolved: unresolved(result),
    };
    folder.write_json("summary.json", &file)?;
    Ok(charts)
}

/// File names and SVG of the charts.
pub type TradeCharts = Vec<(String, String)>;

/// What could not be measured, setting by setting.
pub fn unresolved(result: &SceneResult) -> Vec<String> {
    let of_settings = result.found.iter().filter(|found| !found.notes.is_empty());
    let of_settings =
        of_settings.map(|found| format!("{}: {}", found.knob.title(), found.notes.join("; ")));
    let irreversible = result
        .irreversible
        .iter()
        .map(|reason| format!("The column of the effective error is empty: {reason}."));
    let exact = &result.exact().tally;
    let rare = (exact.judged > 0).then(|| {
        format!(
            "Rarer errors are not resolved: where no contact of {} is wrong, fewer than {:.1e} of them are (95 %).",
            exact.judged,
            1e-6 * exact.upper_bound_of_none()
        )
    });
    rare.into_iter()
        .chain(irreversible)
        .chain(result.notes.iter().cloned())
        .chain(of_settings)
        .collect()
}

/// Adds picture and table of all settings, then the details.
pub fn show(page: &mut Page, result: &SceneResult, charts: &TradeCharts) {
    page.part(PagePart::Answer);
    if let Some((_, svg)) = charts.first() {
        page.pictures(Layout::Full, &[(svg, chart::CAPTION)]);
    }
    page.table(&table::SHORT, &table::short(result));
    page.part(PagePart::Results);
    details(page, result, charts);
    methods(page);
}

fn details(page: &mut Page, result: &SceneResult, charts: &TradeCharts) {
    page.heading(&format!("{}: details", result.name));
    page.paragraph(&format!(
        "{} bodies move. The exact run takes {:.0} ns of processor time for each collision. Errors grow by {:.2} \
         e-foldings for each collision of a body; a replay lasts {:.2} τ, where τ = {} is the mean time between \
         two collisions of a body. {} states from t = {} to {} were taken along the exact run.",
        result.moving,
        result.nanoseconds,
        result.rate,
        result.stretch,
        with_error(result.tau, None),
        result.states,
        with_error(result.span[0], None),
        with_error(result.span[1], None),
    ));
    for sentence in advice::of_families(result) {
        page.paragraph(&sentence);
    }
    show_contacts(page, result);
    show_measures(page, result);
    for (_, svg) in charts.iter().skip(1) {
        page.pictures(Layout::Full, &[(svg, chart::CAPTION)]);
    }
    show_settings(page, result);
}

/// The table of wrong contacts, overlaps and times of all settings.
fn show_contacts(page: &mut Page, result: &SceneResult) {
    page.subheading("Contacts");
    let columns = [2, 3, 6, 7, 8, 9, 10, 11, 12];
    let pick = |row: &[String]| {
        columns
            .iter()
            .map(|&column| row[column].clone())
            .collect::<Vec<_>>()
    };
    let header: Vec<&str> = columns.iter().map(|&column| table::FULL[column]).collect();
    page.table(
        &header,
        &table::full(result)
            .iter()
            .map(|row| pick(row))
            .collect::<Vec<_>>(),
    );
}

/// The scene's own measures with each setting.
fn show_measures(page: &mut Page, result: &SceneResult) {
    page.subheading("Measures of the scene");
    let (header, rows) = table::measure_columns(result);
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    let span = result.exact().physics.span;
    page.paragraph(&format!(
        "From t = {} to {} in the exact run; a slow setting is compared with the exact run over a shorter time. The first row has the values of the \
         exact run, the others the differences from it, with combined standard errors, or ‘too short’ where a run \
         was too short for an error; of a curve, the largest difference of a point in \
         its standard errors.",
        with_error(span[0], None),
        with_error(span[1], None)
    ));
    page.table(&header, &rows);
}

/// How each setting is chosen, what is not resolved, and which knobs do not apply.
fn show_settings(page: &mut Page, result: &SceneResult) {
    page.subheading("How each setting is chosen");
    let rows: Vec<Vec<String>> = result
        .found
        .iter()
        .map(|found| vec![found.knob.title(), found.knob.how()])
        .collect();
    page.table(&["setting", "in the scene"], &rows);
    page.subheading("Not resolved");
    for sentence in unresolved(result) {
        page.paragraph(&sentence);
    }
    if !result.left_out.is_empty() {
        page.subheading("Knobs that do not apply");
        let rows: Vec<Vec<String>> = result
            .left_out
            .iter()
            .map(|(knob, reason)| vec![knob.clone(), reason.clone()])
            .collect();
        page.table(&["knob", "reason"], &rows);
    }
}

fn methods(page: &mut Page) {
    page.heading("Methods");
    page.paragraph(
        "Time: processor time of one thread for each collision, relative to the exact run; both run in turn from \
         one state, and the median over the rounds of the ratio in each round is given. τ is the mean time between \
         two collisions of a body.",
    );
    page.paragraph(&format!(
        "Wrong contacts: from states of the exact run an interval of up to 2 τ is run twice, exactly and with the \
         setting, and compared contact by contact; it is shorter where chaos would amplify rounding to errors. \
         Thermostats and edits act in both. A contact that is absent is missed, one with a time error above \
         {TOLERANCE:e} τ is late or early, one that the exact run does not have is invented. A body with a wrong \
         contact is excluded afterwards, with all bodies that it meets: consequences of an error are not counted. \
         In a coarser model the wrong contacts are those of the model."
    ));
    page.paragraph(
        "Measures: those of the scene, and the pressure, in one run with each setting from the first state. \
         Differences within four standard errors are not named in the first table. Overlapping pairs are counted \
         among all near pairs at the ends of the replays and at times of the measurement.",
    );
    page.paragraph(
        "Effective error: a run goes forward, all velocities are reversed, and it goes back; the distance of the \
         body that ends farthest from its initial position is measured for increasing durations and extrapolated \
         to zero collisions with the growth rate of chaos (measured in the exact run). A distance of a thousandth \
         of a side after the shortest duration gives a lower bound. It is the geometric mean over the initial \
         states, so rare wrong contacts have little effect; an error that is equal on both ways, such as a contact \
         distance that is slightly too large, has none.",
    );
    page.paragraph(
        "Grids: ‘× 1’ has cells as long as two bodies reach and is safe; finer ones are not, and are available \
         only as `unchecked_cells_per_side`. GoldenSecant is the search of Montanari (2017), chapter 2, with \
         corrections: crop ½ and a tolerance of five epsilon unless the name states otherwise. It treats discs \
         like any other molecule.",
    );
}

/// Data files of the results.
pub fn files(charts: &TradeCharts) -> Vec<&str> {
    let fixed = [
        SETTINGS,
        MEASURES,
        "summary.json",
        "manifest.json",
        "config.toml",
    ];
    fixed
        .into_iter()
        .chain(charts.iter().map(|(name, _)| name.as_str()))
        .collect()
}
