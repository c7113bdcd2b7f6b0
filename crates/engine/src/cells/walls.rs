//! Walls in the fast scheduler: covering bodies that are near what is near their face, however long they are.

use glam::DVec2;

use super::{
    State,
    multi_cell::{Covering, Listed},
};
use crate::wall::{StandingWall, folded};

/// Bodies count as near a wall from this much farther away than they need to, so that no rounding leaves one out.
const MARGIN: f64 = 1.0 + 1e-9;

impl State {
    /// The cells that can hold the centre of a small disc that touches a wall, with the image in which their discs appear
    /// in the wall's frame.
    ///
    /// A molecule that may touch it shares a cell with it as well: on the shortest way between them there is a point that
    /// is within the molecule's radius and shell, and on the wall.
    pub(super) fn cells_of_wall(&self, wall: &StandingWall) -> Vec<Listed> {
        let counts = self.grid.counts().map(i64::from);
        let cells = wall.cells_within(self.grid.largest_small(), self.grid.side());
        let listed = cells.into_iter().map(|cell| {
            let ([column, row], image) = folded(cell, counts);
            Listed { who: (row * counts[0] + column) as u32, image }
        });
        listed.collect()
    }
}

/// Whether a covering body, seen `shift` (length) away from its place, may touch a wall while it is in its shell.
pub(super) fn near_wall(wall: &StandingWall, covering: &Covering, shift: DVec2) -> bool {
    wall.gap(covering.centre + shift) <= (covering.radius + covering.shell) * MARGIN
}
