//! The molecule in its gas, to look at: as it is placed, in motion, at the end (Montanari 2017, figures 3.1 to 3.4).

use anyhow::Result;
use carom_report::page::{Layout, Page};
use carom_runs::{animation, output::Folder};

use super::{Plan, group::Group, report::Charts, snapshots::CLOSE_UP};

/// The molecule, the system before and after, and in motion.
///
/// # Errors
/// A picture is gone.
pub fn of_one_run(
    page: &mut Page,
    group: &Group<'_>,
    charts: &Charts,
    folder: &Folder,
    plan: &Plan,
) -> Result<()> {
    page.heading("The system");
    of_molecule(page, group, charts, folder)?;
    moving(page, folder, plan)?;
    before_and_after(page, folder, plan)
}

/// The whole system as it is placed, and at the end.
///
/// # Errors
/// A picture is gone.
pub fn before_and_after(page: &mut Page, folder: &Folder, plan: &Plan) -> Result<()> {
    let [start, end] = [folder.read("start.svg")?, folder.read("end.svg")?];
    let (first, last) = ("At the start: a lattice, shaken.", format!("At t = {}.", plan.until));
    page.pictures(Layout::Beside, &[(&start, first), (&end, &last)]);
    Ok(())
}

/// The molecule in its frame, and as it is placed.
///
/// # Errors
/// A picture is gone.
pub fn of_molecule(page: &mut Page, group: &Group<'_>, charts: &Charts, folder: &Folder) -> Result<()> {
    let frame = "The molecule in its frame (x′, y′). The centre of a gas disc (dashed) can come as near as the line, no \
                 nearer; each arc belongs to the atom that is touched there. An atom drawn with a broken line can never be touched.";
    let placed = format!("{}, as it is placed among the gas.", capitalised(group.case.words()));
    let close_up = folder.read(CLOSE_UP)?;
    page.pictures(Layout::Beside, &[(&charts.molecule, frame), (&close_up, &placed)]);
    Ok(())
}

/// The moving view of a run.
///
/// # Errors
/// It is gone.
pub fn moving(page: &mut Page, folder: &Folder, plan: &Plan) -> Result<()> {
    let caption = format!(
        "The gas and the molecule as measuring begins, at t = {}: between two contacts every body is drawn exactly where \
         the run had it. The same flights, with all digits, are in flights.csv of the run.",
        plan.from
    );
    page.animation(&folder.read(animation::ANIMATION)?, &caption);
    Ok(())
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
