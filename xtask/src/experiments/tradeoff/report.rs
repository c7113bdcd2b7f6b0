//! The table and the page of the experiment.

use carom_report::page::{Layout, Page};
use carom_tables::Summary;

use super::{
    advice,
    knobs::{FAMILIES, MODEL},
    measures::{Mean, relative},
    rapier::{self, Compared},
    results::{Found, SceneResult, TOLERANCE},
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

/// Columns of the two tables into which the page divides it, so that they are no wider than it.
const PARTS: [&[usize]; 2] = [&[1, 2, 3, 4, 5, 6, 7, 8, 9], &[2, 3, 10, 11, 12, 13, 14, 15, 16]];

fn percent(mean: Option<Mean>) -> String {
    mean.map_or_else(
        || "–".to_owned(),
        |mean| format!("{:+.2} ± {:.2}", 100.0 * mean.value, 100.0 * mean.error),
    )
}

/// The rows of one scene.
pub fn rows(result: &SceneResult) -> Vec<Vec<String>> {
    let exact = &result.found[0].physics;
    let row = |found: &Found| {
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
        "Each knob that trades accuracy for speed is turned, in four scenes: what is saved, which contacts go wrong, how deep \
         molecules end up in each other, and what becomes of the pressure.",
    );
    if !summary.note.is_empty() {
        page.note(&summary.note);
    }
    page.checks(&summary.checks);
    for result in results {
        page.heading(&format!("{}: {}", result.named.name, result.named.about));
        page.paragraph(&format!(
            "The default takes {:.0} ns of processor time for a collision. Roundings grow by {:.2} e-foldings in one collision \
             of each body; replays last {:.2} τ.",
            result.nanoseconds, result.rate, result.stretch
        ));
        let captions = "One point for each setting; left is fast, low is right. Rings with lines downwards: not larger than \
                        this (none seen, drawn at the 95 % bound; or less than two standard errors). The line joins the \
                        settings that no other beats in both.";
        let pictures: Vec<(&str, &str)> =
            result.charts.iter().map(|(_, svg)| (svg.as_str(), captions)).collect();
        page.pictures(Layout::Full, &pictures);
        let rows = rows(result);
        for columns in PARTS {
            let pick = |row: &[String]| columns.iter().map(|&column| row[column].clone()).collect::<Vec<_>>();
            let header: Vec<&str> = columns.iter().map(|&column| HEADER[column]).collect();
            page.table(&header, &rows.iter().map(|row| pick(row)).collect::<Vec<_>>());
        }
    }
    page.heading("Advice: which knob buys what");
    for result in results {
        page.subheading(result.named.name);
        for sentence in advice::sentences(result) {
            page.paragraph(&sentence);
        }
    }
    page.heading("What one would pick instead: rapier");
    if compared.is_empty() {
        page.paragraph("Not run: the option --rapier compiles rapier2d-f64 and runs it on the same gases.");
    } else {
        page.paragraph(
            "rapier2d-f64 steps through time: restitution 1, no friction, no damping, no gravity, no sleep, continuous collision \
             detection, the unit of length a diameter, everything else by default. As it knows no periodic box, both engines \
             run the gas between walls, from one state. Processor time is that of one thread for the same simulated time. \
             Contacts begun are those that rapier reports, atom by atom, so that they need not be collisions one to one.",
        );
        page.table(&rapier::HEADER, &compared.iter().flat_map(rapier::rows).collect::<Vec<_>>());
    }
    page.heading("How it was measured");
    page.paragraph(
        "Time: processor time of one thread for each collision, over that of the exact default run; all settings in turn, median \
         over rounds of the ratio in each round. τ is the mean time between two collisions of a body.",
    );
    page.paragraph(&format!(
        "Wrong contacts: from states of the exact run, at ends of its epochs and 5 τ apart at least, a stretch of up to 2 τ, shorter where chaos would make errors of roundings, is run twice, exactly and with the setting, and compared \
         contact by contact. One that is not there is missed, one that is off by more than {TOLERANCE:e} τ is late or early, one \
         that the exact run does not have is invented. A body that had a wrong contact is set aside, with all that it meets: \
         what follows from an error is no error of its own. In a coarser model contacts differ by what the model is; of \
         locked rotation the table compares with the exact run of locked molecules."
    ));
    page.paragraph(
        "Overlaps and physics: from one state of the exact run, blocks of 10 τ; overlapping pairs are counted at the end \
         of each, by a look at all near pairs. The pressure is that of the virial of the contacts, the slope that of −ln C over the \
         first 0.1 τ of the velocity autocorrelation C. Differences to the exact run in per cent, with the standard error of \
         both together; of the shares of hits of the atoms, the one that differs most.",
    );
    page.paragraph(
        "Effective error: a run goes forward, all velocities are reversed, and it goes back; the body that ends farthest from \
         where it was, over ever longer ways, extrapolated to no collision at the rate at which chaos multiplies distances \
         (measured with the exact run). Where it is off by a thousandth of a side over the shortest way, that is a lower bound. It is \
         the geometric mean over the states that are begun from, so that rare wrong contacts hardly show; nor does an error \
         that is the same on both ways, such as discs that always meet at a distance a little too large. \
         Samples change no bit of a run, which is tested elsewhere: replays, reversals and physics are run without them.",
    );
    page.paragraph(
        "Grids: ‘× 1’ has cells as long as two bodies reach and is safe; finer ones are not, and are only to be had under the name \
         Unchecked. GoldenSecant is the search of Montanari (2017), chapter 2, repaired: with crop ½ and a tolerance of five \
         epsilon where the name does not say otherwise. It treats discs like any other molecule.",
    );
    page.heading("Again");
    page.code(command);
    let charts = results.iter().flat_map(|result| result.charts.iter().map(|(name, _)| name.as_str()));
    page.links(["settings.csv", "summary.json", "manifest.json", "config.toml"].into_iter().chain(charts));
    page
}
