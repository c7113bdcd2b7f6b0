//! Walls in the cell scheduler: multi-cell bodies listed only near their face.

use glam::DVec2;

use super::{
    cell_grid::CellGrid,
    multi_cell::{Listed, MultiCellBody},
};
use crate::world::wall::{StandingWall, folded};

/// Factor on the distance within which a body is near a wall, so that no rounding leaves one out.
const MARGIN: f64 = 1.0 + 1e-9;

/// Adds the cells that can hold the centre of a small disc that touches a wall, with the image in
/// which their discs appear in the wall's frame.
///
/// A molecule that may touch the wall shares a cell with it: the shortest way between them has a
/// point that is within the molecule's radius and shell, and on the wall.
///
/// No point of the wall is farther than `way` (length) from its place here while it is listed: 0
/// for a wall at rest.
pub(super) fn cells_of_wall(
    grid: &CellGrid,
    wall: &StandingWall,
    way: f64,
    listed: &mut Vec<Listed>,
) {
    let counts = grid.counts().map(i64::from);
    let cells = wall.cells_within(grid.largest_small() + way, grid.side());
    listed.extend(cells.into_iter().map(|cell| {
        let ([column, row], image) = folded(cell, counts);
        Listed {
            index: (row * counts[0] + column) as u32,
            image,
        }
    }));
}

/// Whether a multi-cell body, shifted by `shift` (length), may touch a wall while it is in its
/// shell, and no point of the wall farther than `way` (length) from its place here.
pub(super) fn near_wall(
    wall: &StandingWall,
    way: f64,
    multi_cell_body: &MultiCellBody,
    shift: DVec2,
) -> bool {
    wall.gap(multi_cell_body.centre + shift)
        <= (multi_cell_body.radius + multi_cell_body.shell + way) * MARGIN
}
