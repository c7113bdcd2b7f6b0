//! Table and page of the experiment.

use carom_report::page::{Page, PagePart};
use carom_runs::measures;
use carom_tables::Summary;

use super::{
    capability::{Capability, CapabilityLevel, Variant},
    dependencies::Needs,
    results::{CostResults, VariantResult},
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
        Variant::Plain(_) => "the plain gas with another seed: statistical error",
        Variant::With(capability, level) => capability.about(level),
        Variant::Measure("energy") => "what every run measures: energy, overlaps, collision rate",
        Variant::Measure(name) => measures::KINDS
            .iter()
            .find(|kind| kind.name == name)
            .map_or("", |k| k.summary),
    }
}

fn percent(value: Option<f64>) -> String {
    value.map_or_else(
        || "–".to_owned(),
        |value| format!("{:+.2} %", 100.0 * value),
    )
}

/// Rows of the table.
pub fn rows(results: &CostResults) -> Vec<Vec<String>> {
    let row = |found: &VariantResult| {
        vec![
            found.variant.to_string(),
            about(found.variant).to_owned(),
            found
                .instructions
                .map_or_else(|| "–".to_owned(), |count| format!("{count:.1}")),
            percent(results.excess(found.variant)),
            format!("{:.3}", found.time_ratio),
            format!("{:.0}", found.bytes_per_body),
            format!("{:.0}", found.nanoseconds),
        ]
    };
    results.found.iter().map(row).collect()
}

/// A sentence on the cost of each capability.
fn sentences(results: &CostResults) -> Vec<String> {
    let sentence = |capability: Capability| {
        let idle = results.excess(Variant::With(capability, CapabilityLevel::Idle))?;
        let used = results.excess(Variant::With(capability, CapabilityLevel::Used))?;
        let absent = match results
            .absent(capability)
            .filter(|_| !capability.sources().is_empty())
        {
            Some(share) => format!("{:.2} % of the instructions when absent", 100.0 * share),
            None => "no source of its own".to_owned(),
        };
        Some(format!(
            "{}: {absent}, {:+.1} % idle ({}), {:+.0} % used ({}).",
            capability.name(),
            100.0 * idle,
            capability.about(CapabilityLevel::Idle),
            100.0 * used,
            capability.about(CapabilityLevel::Used),
        ))
    };
    Capability::all().filter_map(sentence).collect()
}

/// The page.
pub fn page(results: &CostResults, summary: &Summary, command: &str) -> Page {
    let mut page = Page::new(
        &summary.title,
        "A gas of equal discs is run with one capability at a time: what is the cost of a capability that is \
         absent from the scene, of one that is present but idle, and of one that is used?",
    );
    if !summary.note.is_empty() {
        page.note(&summary.note);
    }
    page.checks(&summary.checks);
    page.part(PagePart::Answer);
    page.table(&HEADER, &rows(results));
    for sentence in sentences(results) {
        page.paragraph(&sentence);
    }
    page.part(PagePart::Results);
    definition_section(&mut page);
    if !results.needs.is_empty() {
        dependency_section(&mut page, &results.needs);
    }
    page.code(command);
    page.links(["costs.csv", "summary.json", "manifest.json", "config.toml"]);
    page
}

/// What absent, idle and used mean, and how the costs are measured.
fn definition_section(page: &mut Page) {
    page.heading("Definitions");
    page.paragraph(
        "Absent: the plain gas. No build without the capability exists for comparison. Therefore each \
         instruction of the plain gas is attributed to its source line, including inlined code, and those \
         from sources that only this capability needs are counted. Locked rotation and bumpers have no such \
         source: they are values of the inverse mass and the inverse moment of inertia that every body has. A \
         branch in a shared source is not counted here; its cost appears under idle if it is larger there.",
    );
    page.paragraph(
        "Idle: the capability is requested, with no or almost no work to do; see the table. Used: it is \
         active as the table describes; the cost depends on its amount.",
    );
    page.paragraph(
        "Instructions: this program under callgrind, for a short and a long run; the difference divided by \
         the collisions in between is free of noise and of the construction of the scene. Callgrind does not \
         support AVX-512, so on processors with it the code for AVX2 is counted. A capability that changes \
         the trajectory adds statistical error; the second plain gas shows its size. Time: processor time of \
         one thread, all variants in turn, median over rounds of the ratio to the plain gas in the same \
         round.",
    );
    page.paragraph(
        "Measure: a sample about every three collisions of each disc, and a report of every contact where the \
         measure needs it. Each row includes what every run measures; its price is the difference to that row.",
    );
}

/// How many other layers and packages each layer needs.
fn dependency_section(page: &mut Page, needs: &[Needs]) {
    page.heading("Dependencies of each layer when used alone");
    let header = [
        "layer",
        "layers of carom below",
        "other packages",
        "of these, at compile time only",
    ];
    let row = |layer: &Needs| {
        let counts =
            [layer.own, layer.foreign, layer.when_compiling].map(|count| count.to_string());
        std::iter::once(layer.layer.to_owned())
            .chain(counts)
            .collect::<Vec<_>>()
    };
    page.table(&header, &needs.iter().map(row).collect::<Vec<_>>());
}
