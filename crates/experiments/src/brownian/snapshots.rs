//! Pictures and frames of the system that a run writes as it goes.

use anyhow::Result;
use carom::{
    BodyKey, View,
    observers::{close_up, picture, write_extended_xyz},
};
use carom_runs::{animation, output::Folder};

/// Longer side of a picture of the system (pixels).
const PICTURE: u32 = 720;

/// Side of a close-up, in units of the molecule's diameter, and in pixels.
const CLOSE: (f64, u32) = (7.0, 480);

/// Close-up of the initial state of the molecule.
pub const CLOSE_UP: &str = "start-close-up.svg";

/// Writes the present state: a frame of extended XYZ, and a picture.
pub fn snapshot(view: &View<'_>, name: &str, folder: &Folder) -> Result<()> {
    let mut frame = Vec::new();
    write_extended_xyz(view, &mut frame)?;
    folder.write_lasting(&format!("{name}.extxyz"), frame)?;
    folder.write_lasting(&format!("{name}.svg"), picture(view, PICTURE))
}

/// Writes a picture of the molecule among its neighbours.
pub fn snapshot_of(view: &View<'_>, molecule: BodyKey, folder: &Folder) -> Result<()> {
    let Some(body) = view.body(molecule) else { return Ok(()) };
    let side = CLOSE.0 * 2.0 * body.body.molecule().bounding_radius();
    folder.write_lasting(CLOSE_UP, close_up(view, body.motion.position, side, CLOSE.1))
}

/// Verifies that the files exist that the page of a started run needs.
///
/// # Errors
/// A file is missing.
pub fn check(folder: &Folder, measures: bool) -> Result<()> {
    folder.read("start.svg")?;
    folder.read(CLOSE_UP)?;
    if measures {
        folder.read(animation::ANIMATION)?;
    }
    Ok(())
}
