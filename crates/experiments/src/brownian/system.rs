//! Pictures of the molecule in its gas: initial state, animation, and final state (Montanari 2017,
//! figures 3.1 to 3.4).

use anyhow::Result;
use carom_report::page::{Layout, Page, Part};
use carom_runs::{animation, output::Folder};

use super::{plan::Plan, snapshots::CLOSE_UP};

/// Adds pictures of the initial and the final state.
///
/// # Errors
/// A picture is missing.
pub fn before_and_after(page: &mut Page, folder: &Folder, plan: &Plan) -> Result<()> {
    let [start, end] = [folder.read(CLOSE_UP)?, folder.read("end.svg")?];
    let (first, last) = ("Initial state, close-up.", format!("At t = {}.", plan.until));
    page.pictures(Layout::Beside, &[(&start, first), (&end, &last)]);
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
    page.part(Part::Motion);
    page.animation(&folder.read(animation::ANIMATION)?, &caption);
    Ok(())
}
