//! The table and the page of the experiment.

use carom_report::page::Page;
use carom_tables::Summary;

use super::{
    capability::{Capability, Level, Variant},
    results::{Found, Results},
};

/// Columns of the table.
pub const HEADER: [&str; 7] = [
    "variant",
    "what is in it",
    "instructions a collision",
    "instructions over plain",
    "time over plain",
    "bytes a body",
    "ns a collision",
];

fn about(variant: Variant) -> &'static str {
    match variant {
        Variant::Plain(1) => "4000 equal elastic discs, area fraction 0.5",
        Variant::Plain(_) => "the same from another seed: what chance does",
        Variant::With(capability, level) => capability.about(level),
    }
}

fn percent(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), |value| format!("{:+.2} %", 100.0 * value))
}

/// The rows of the table.
pub fn rows(results: &Results) -> Vec<Vec<String>> {
    let row = |found: &Found| {
        vec![
            found.variant.to_string(),
            about(found.variant).to_owned(),
            found.instructions.map_or_else(|| "–".to_owned(), |count| format!("{count:.1}")),
            percent(results.excess(found.variant)),
            format!("{:.3}", found.time_ratio),
            format!("{:.0}", found.bytes_per_body),
            format!("{:.0}", found.nanoseconds),
        ]
    };
    results.found.iter().map(row).collect()
}

/// A line for each variant, for the terminal.
pub fn lines(results: &Results) -> Vec<String> {
    let line = |row: Vec<String>| {
        format!(
            "{:<26} {:>9} {:>10} {:>7} {:>6} {:>6}  {}",
            row[0], row[2], row[3], row[4], row[5], row[6], row[1]
        )
    };
    let header = ["variant", "", "instr.", "over plain", "time", "bytes", "ns"].map(str::to_owned).to_vec();
    std::iter::once(header).chain(rows(results)).map(line).collect()
}

/// What each capability costs in one sentence.
fn sentences(results: &Results) -> Vec<String> {
    let sentence = |capability: Capability| {
        let idle = results.excess(Variant::With(capability, Level::Idle))?;
        let used = results.excess(Variant::With(capability, Level::Used))?;
        let absent = match results.absent(capability).filter(|_| !capability.sources().is_empty()) {
            Some(share) => format!("{:.2} % of the instructions where it is absent", 100.0 * share),
            None => "no source of its own".to_owned(),
        };
        Some(format!(
            "{}: {absent}, {:+.1} % idle ({}), {:+.0} % used ({}).",
            capability.name(),
            100.0 * idle,
            capability.about(Level::Idle),
            100.0 * used,
            capability.about(Level::Used),
        ))
    };
    Capability::ALL.into_iter().filter_map(sentence).collect()
}

/// The page.
pub fn page(results: &Results, summary: &Summary, command: &str) -> Page {
    let mut page = Page::new(
        &summary.title,
        "A gas of equal discs is run with one capability after the other: what does a scene pay for what is not in it, \
         for what is in it and does nothing, and for what is at work?",
    );
    if !summary.note.is_empty() {
        page.note(&summary.note);
    }
    page.checks(&summary.checks);
    page.heading("Costs");
    page.table(&HEADER, &rows(results));
    for sentence in sentences(results) {
        page.paragraph(&sentence);
    }
    page.heading("What the words mean");
    page.paragraph(
        "Absent: the plain gas. To compare a program with itself would show nothing, and there is no build without the \
         capability to compare with. So each instruction of the plain gas is traced to the source line that it comes from, \
         lines that the compiler has moved into other functions included, and those count that come from sources which only \
         this capability needs. Locked rotation and bumpers have no such source: they are values of the inverse mass and the \
         inverse moment of inertia that every body has. A test that stands in a source shared by all is not seen in this way: \
         it is seen as idle if it costs more there.",
    );
    page.paragraph(
        "Idle: the capability is asked for, and there is nothing or next to nothing for it to do; the table says how. Used: it \
         is at work, as the table says; how much that costs depends on how much of it there is.",
    );
    page.paragraph(
        "Instructions: this program under callgrind, to two ends of the run; the difference, over the collisions in \
         between, is free of noise and of the building of the scene. Callgrind knows no AVX-512, so the code for AVX2 is \
         counted on processors that have more. Where a capability changes the trajectory, chance does as well: the second plain \
         gas shows by how much. Time: processor time of one thread, all variants in turn, median over rounds of the ratio to the \
         plain gas in the same round.",
    );
    if !results.needs.is_empty() {
        page.heading("What each layer draws in, taken alone");
        let header =
            ["layer", "layers of carom below", "packages of others", "of these, only when compiling"];
        let row = |needs: &super::dependencies::Needs| {
            let counts = [needs.own, needs.foreign, needs.when_compiling].map(|count| count.to_string());
            std::iter::once(needs.layer.to_owned()).chain(counts).collect::<Vec<_>>()
        };
        page.table(&header, &results.needs.iter().map(row).collect::<Vec<_>>());
    }
    page.heading("Again");
    page.code(command);
    page.links(["costs.csv", "summary.json", "manifest.json", "config.toml"]);
    page
}
