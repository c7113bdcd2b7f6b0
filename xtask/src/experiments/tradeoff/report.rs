//! Table and page of the experiment.

use carom_report::page::{Layout, Page};
use carom_tables::Summary;

use super::{
    advice,
    knobs::{FAMILIES, MODEL},
    measures::{Mean, relative},
    rapier::{self, Compared},
    results::{SceneResult, SettingResult, TOLERANCE},
};

/// Columns of the table.
pub const HEADER: [&str; 17] = [
    "scene",
    "knob",
    "setting",
    "time over exact",
    "contacts judged",
    "missed per 1e6",
    "late or early per 1e6",
    "invented per 1e6",
    "wrong per 1e6 at most (95 %)",
    "largest |Δt| of the rest [τ]",
    "overlapping pairs",
    "deepest overlap [diameters]",
    "effective error [sides]",
    "pressure [%]",
    "collision rate [%]",
    "slope of the VACF [%]",
    "share of hits",
];

/// Columns of the two tables into which the page splits it to fit the width.
const PARTS: [&[usize]; 2] = [&[1, 2, 3, 4, 5, 6, 7, 8, 9], &[2, 3, 10, 11, 12, 13, 14, 15, 16]];

fn percent(mean: Option<Mean>) -> String {
    mean.map_or_else(
        || "–".to_owned(),
        |mean| format!("{:+.2} ± {:.2}", 100.0 * mean.value, 100.0 * mean.error),
    )
}

/// Rows for one scene.
pub fn rows(result: &SceneResult) -> Vec<Vec<String>> {
    let exact = &result.found[0].physics;
    let row = |found: &SettingResult| {
        let (tally, physics) = (&found.tally, &found.physics);
        let none = "–".to_owned();
        let mut cells = vec![
            result.named.name.to_owned(),
            FAMILIES[found.setting.family].to_owned(),
            found.setting.name.clone(),
            found.time.map_or_else(|| none.clone(), |time| format!("{time:.3}")),
        ];
        if found.setting.family == MODEL && !found.setting.locked || tally.judged == 0 {
            cells.extend(vec![none.clone(); 6]);
        } else {
            cells.push(tally.judged.to_string());
            let million = |count| format!("{:.0}", tally.million(count));
            cells.extend([tally.missed, tally.off, tally.invented].map(million));
            let bound = if tally.wrong() == 0.0 {
                format!("{:.0}", tally.upper_bound_of_none())
            } else {
                none.clone()
            };
            cells.extend([bound, format!("{:.1e}", tally.largest)]);
        }
        if physics.blocks == 0 {
            cells.extend([none.clone(), none.clone()]);
        } else {
            cells.extend([physics.overlapping.to_string(), format!("{:.1e}", physics.deepest)]);
        }
        cells.push(found.effective.map_or_else(
            || none.clone(),
            |effective| format!("{}{:.0e}", if effective.at_least { "≥ " } else { "" }, effective.value),
        ));
        let means =
            [(physics.pressure, exact.pressure), (physics.rate, exact.rate), (physics.slope, exact.slope)];
        cells.extend(means.map(|(found, exact)| percent(relative(found, exact))));
        let share = physics.share_difference(exact);
        cells.push(share.map_or(none, |mean| format!("{:.4} ± {:.4}", mean.value, mean.error)));
        cells
    };
    result.found.iter().map(row).collect()
}

/// A line for each setting, for the terminal.
pub fn lines(result: &SceneResult) -> Vec<String> {
    let line = |row: Vec<String>| {
        format!(
            "{:<11} {:<16} {:<22} time {:>8}  wrong {:>7} {:>7} {:>7} of {:>8}  overlaps {:>4} {:>8}  effective {:>7}  p {:>15}",
            row[0],
            row[1],
            row[2],
            row[3],
            row[5],
            row[6],
            row[7],
            row[4],
            row[10],
            row[11],
            row[12],
            row[13]
        )
    };
    rows(result).into_iter().map(line).chain(advice::sentences(result)).collect()
}

/// The page.
pub fn page(results: &[SceneResult], compared: &[Compared], summary: &Summary, command: &str) -> Page {
    let mut page = Page::new(
        &summary.title,
        "Each setting that trades accuracy for speed is varied in four scenes: the time saved, the wrong \
         contacts, the depth of overlaps, and the error of the pressure are measured.",
    );
    if !summary.note.is_empty() {
        page.note(&summary.note);
    }
    page.checks(&summary.checks);
    for result in results {
        scene_section(&mut page, result);
    }
    page.heading("Advice on the settings");
    for result in results {
        page.subheading(result.named.name);
        for sentence in advice::sentences(result) {
            page.paragraph(&sentence);
        }
    }
    rapier_section(&mut page, compared);
    method_section(&mut page);
    page.heading("Again");
    page.code(command);
    let charts = results.iter().flat_map(|result| result.charts.iter().map(|(name, _)| name.as_str()));
    page.links(["settings.csv", "summary.json", "manifest.json", "config.toml"].into_iter().chain(charts));
    page
}

fn scene_section(page: &mut Page, result: &SceneResult) {
    page.heading(&format!("{}: {}", result.named.name, result.named.about));
    page.paragraph(&format!(
        "The default takes {:.0} ns of processor time for each collision. Rounding errors grow by {:.2} \
         e-foldings for each collision of a body; replays last {:.2} τ.",
        result.nanoseconds, result.rate, result.stretch
    ));
    let captions = "One point for each setting; fast settings are left, accurate ones are low. Rings \
                    with downward lines are upper bounds (no event, drawn at the 95 % bound; or less than two standard \
                    errors). The line joins the settings that no other dominates in both.";
    let pictures: Vec<(&str, &str)> = result.charts.iter().map(|(_, svg)| (svg.as_str(), captions)).collect();
    page.pictures(Layout::Full, &pictures);
    let rows = rows(result);
    for columns in PARTS {
        let pick = |row: &[String]| columns.iter().map(|&column| row[column].clone()).collect::<Vec<_>>();
        let header: Vec<&str> = columns.iter().map(|&column| HEADER[column]).collect();
        page.table(&header, &rows.iter().map(|row| pick(row)).collect::<Vec<_>>());
    }
}

fn rapier_section(page: &mut Page, compared: &[Compared]) {
    page.heading("Comparison with rapier");
    if compared.is_empty() {
        page.paragraph("Not run: the option --rapier compiles rapier2d-f64 and runs it on the same gases.");
    } else {
        page.paragraph(
            "rapier2d-f64 uses time steps: restitution 1, no friction, no damping, no gravity, no sleep, \
             continuous collision detection, the unit of length a diameter, other settings at their defaults. \
             It has no periodic box, so both engines run the gas between walls, from one state. Processor \
             time is that of one thread for the same simulated time. Contacts begun are those that rapier \
             reports for single atoms; they need not correspond one to one to collisions.",
        );
        page.table(&rapier::HEADER, &compared.iter().flat_map(rapier::rows).collect::<Vec<_>>());
    }
}

fn method_section(page: &mut Page) {
    page.heading("Methods");
    page.paragraph(
        "Time: processor time of one thread for each collision, relative to the exact default run; all \
         settings in turn, median over rounds of the ratio in each round. τ is the mean time between two \
         collisions of a body.",
    );
    page.paragraph(&format!(
        "Wrong contacts: from states of the exact run at ends of its epochs, at least 5 τ apart, an interval \
         of up to 2 τ is run twice, exactly and with the setting, and compared contact by contact; it is \
         shorter where chaos would amplify rounding to errors. A contact that is absent is missed, one with a \
         time error above {TOLERANCE:e} τ is late or early, one that the exact run does not have is invented. \
         A body with a wrong contact is excluded afterwards, with all bodies that it meets: consequences of \
         an error are not counted. In a coarser model the differences are those of the model; locked rotation \
         is compared with the exact run of locked molecules."
    ));
    page.paragraph(
        "Overlaps and physics: blocks of 10 τ from one state of the exact run; overlapping pairs are counted \
         at the end of each block among all near pairs. The pressure is from the virial of the contacts, the \
         slope is that of −ln C over the first 0.1 τ of the velocity autocorrelation C. Differences from the \
         exact run are in per cent, with the combined standard error; of the shares of hits of the atoms, the \
         largest difference is given.",
    );
    page.paragraph(
        "Effective error: a run goes forward, all velocities are reversed, and it goes back; the distance of \
         the body that ends farthest from its initial position is measured for increasing durations and \
         extrapolated to zero collisions with the growth rate of chaos (measured in the exact run). A \
         distance of a thousandth of a side after the shortest duration gives a lower bound. It is the \
         geometric mean over the initial states, so rare wrong contacts have little effect; an error that is \
         equal on both ways, such as a contact distance that is slightly too large, has none. Samples change \
         no bit of a run, which a separate test verifies: replays, reversals and physics run without them.",
    );
    page.paragraph(
        "Grids: ‘× 1’ has cells as long as two bodies reach and is safe; finer ones are not, and are \
         available only as Unchecked. GoldenSecant is the search of Montanari (2017), chapter 2, with \
         corrections: crop ½ and a tolerance of five epsilon unless the name states otherwise. It treats \
         discs like any other molecule.",
    );
}
