//! Walls in the cell scheduler: multi-cell bodies listed only near their face.

use glam::DVec2;

use super::{
    multi_cell::{Listed, MultiCellBody},
    state::State,
};
use crate::wall::{StandingWall, folded};

/// Factor on the distance within which a body is near a wall, so that no rounding leaves one out.
const MARGIN: f64 = 1.0 + 1e-9;

impl State {
    /// The cells that can hold the centre of a small disc that touches a wall, with the image in
    /// which their discs appear in the wall's frame.
    ///
    /// A molecule that may touch the wall shares a cell with it: the shortest way between them has
    /// a point that is within the molecule's radius and shell, and on the wall.
    pub(super) fn cells_of_wall(&self, wall: &StandingWall) -> Vec<Listed> {
        let counts = self.grid.counts().map(i64::from);
        let cells = wall.cells_within(self.grid.largest_small(), self.grid.side());
        let listed = cells.into_iter().map(|cell| {
            let ([column, row], image) = folded(cell, counts);
            Listed { index: (row * counts[0] + column) as u32, image }
        });
        listed.collect()
    }
}

/// Whether a multi-cell body, shifted by `shift` (length), may touch a wall while it is in its
/// shell.
pub(super) fn near_wall(wall: &StandingWall, multi_cell_body: &MultiCellBody, shift: DVec2) -> bool {
    wall.gap(multi_cell_body.centre + shift) <= (multi_cell_body.radius + multi_cell_body.shell) * MARGIN
}
