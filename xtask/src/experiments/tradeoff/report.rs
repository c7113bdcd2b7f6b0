//! The page of the experiment: the four scenes, and rapier.

use carom_experiments::trade::{advice, page, page::Charts, results::SceneResult};
use carom_report::page::{Page, Part};
use carom_tables::Summary;

use super::rapier::{self, Compared};

/// The page.
pub fn page(
    results: &[SceneResult],
    charts: &[Charts],
    compared: &[Compared],
    summary: &Summary,
    command: &str,
) -> Page {
    let mut page = Page::new(
        &summary.title,
        "Each setting that trades accuracy for speed is varied in four scenes: the time saved, the wrong \
         contacts, the depth of overlaps, and the errors of measures.",
    );
    if !summary.note.is_empty() {
        page.note(&summary.note);
    }
    let kept = results.iter().filter(|result| advice::keeps_exact(result)).count();
    page.verdict(&format!(
        "In {kept} of {} scenes the exact run is the fastest of all settings without a wrong contact{}.",
        results.len(),
        if kept < results.len() { "; in the others the advice names a faster one" } else { "" }
    ));
    page.part(Part::Answer);
    let row = |result: &SceneResult| vec![result.name.clone(), advice::advice(result)];
    page.table(&["scene", "advice"], &results.iter().map(row).collect::<Vec<_>>());
    page::show(&mut page, results, charts);
    rapier_section(&mut page, compared);
    page.checks(&summary.checks);
    page.code(command);
    page.links(page::files(charts));
    page
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
