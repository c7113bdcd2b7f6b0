//! Pictures of the molecule in its gas: initial state, animation, and final state (Montanari 2017,
//! figures 3.1 to 3.4).

use anyhow::Result;
use carom_report::page::{Layout, Page};
use carom_runs::{animation, output::Folder};

use super::{Plan, charts::Charts, group::Group, snapshots::CLOSE_UP};

/// Adds the molecule, the initial and final state, and the animation to the page.
///
/// # Errors
/// A picture is missing.
pub fn of_one_run(
    page: &mut Page,
    group: &Group<'_>,
    charts: &Charts,
    folder: &Folder,
    plan: &Plan,
) -> Result<()> {
    page.heading("System");
    of_molecule(page, group, charts, folder)?;
    moving(page, folder, plan)?;
    before_and_after(page, folder, plan)
}

/// Adds pictures of the initial and the final state.
///
/// # Errors
/// A picture is missing.
pub fn before_and_after(page: &mut Page, folder: &Folder, plan: &Plan) -> Result<()> {
    let [start, end] = [folder.read("start.svg")?, folder.read("end.svg")?];
    let (first, last) = ("Initial state: a perturbed lattice.", format!("At t = {}.", plan.until));
    page.pictures(Layout::Beside, &[(&start, first), (&end, &last)]);
    Ok(())
}

/// Adds the molecule in its body frame and a close-up of the initial state.
///
/// # Errors
/// A picture is missing.
pub fn of_molecule(page: &mut Page, group: &Group<'_>, charts: &Charts, folder: &Folder) -> Result<()> {
    let frame = "The molecule in its body frame (x′, y′). The line bounds the region that the centre of a \
                 gas disc (dashed) cannot enter; each arc belongs to the touched atom. An atom with a dashed outline \
                 cannot be touched.";
    let placed = format!("{} in the gas, initial state.", capitalised(group.case.words()));
    let close_up = folder.read(CLOSE_UP)?;
    page.pictures(Layout::Beside, &[(&charts.molecule, frame), (&close_up, &placed)]);
    Ok(())
}

/// Adds the animation of a run.
///
/// # Errors
/// It is missing.
pub fn moving(page: &mut Page, folder: &Folder, plan: &Plan) -> Result<()> {
    let caption = format!(
        "The gas and the molecule from the start of the measurement at t = {}: between contacts every body \
         is drawn at its exact position. All digits of the flights are in flights.csv of the run.",
        plan.from
    );
    page.animation(&folder.read(animation::ANIMATION)?, &caption);
    Ok(())
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
