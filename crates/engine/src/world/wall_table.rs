//! Walls whose velocity changes at given times: piecewise uniform motions.

use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::world::{World, body::BodyKey};

/// A difference of two times below this share of them is rounding.
const SAME_TIME: f64 = 4.0 * f64::EPSILON;

/// A wall with a table of velocities.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct WallTable {
    /// The wall.
    pub key: BodyKey,
    /// Duration (time) and velocity (length per time) of each piece.
    pub pieces: Vec<(f64, DVec2)>,
    /// Whether the table begins anew at its end; otherwise the wall is then at rest.
    pub repeats: bool,
    /// Number of the next piece.
    pub next: usize,
    /// When it begins (offset in the epoch, time).
    pub begins: f64,
}

impl WallTable {
    /// Whether a simulation can have written it: durations are positive.
    pub fn is_valid(&self) -> bool {
        let durations_are_positive = self
            .pieces
            .iter()
            .all(|(duration, velocity)| *duration > 0.0 && velocity.is_finite());
        let is_over = self.next > self.pieces.len();
        let is_begun = self.begins.is_finite() && (self.begins >= 0.0 || is_over);
        durations_are_positive && is_begun && !self.pieces.is_empty()
    }

    /// When the velocity changes next (offset in the epoch, time); infinite after the last piece.
    fn next_change(&self) -> f64 {
        if self.next > self.pieces.len() {
            f64::INFINITY
        } else {
            self.begins
        }
    }

    /// The velocity of the piece that begins, of which the next one is set; rest after the last.
    fn advance(&mut self) -> DVec2 {
        if self.next == self.pieces.len() && self.repeats {
            self.next = 0;
        }
        let piece = self.pieces.get(self.next);
        self.next += 1;
        piece.map_or(DVec2::ZERO, |&(duration, velocity)| {
            self.begins += duration;
            velocity
        })
    }
}

impl World {
    /// Sets the velocities of walls whose next piece begins at the start of the epoch.
    pub(crate) fn advance_wall_tables(&mut self) {
        let now = self.epoch.to_f64().abs();
        for table in &mut self.wall_tables {
            let found = self
                .bodies
                .binary_search_by_key(&table.key, |body| body.key);
            let Ok(index) = found else { continue };
            while table.next_change() <= SAME_TIME * now {
                self.motions[index].velocity = table.advance();
            }
        }
    }

    /// The next change of the velocity of a wall (offset in the epoch, time); infinite without one.
    pub(crate) fn next_change_of_walls(&self) -> f64 {
        let changes = self.wall_tables.iter().map(WallTable::next_change);
        changes.fold(f64::INFINITY, f64::min)
    }

    /// Replaces the table of a wall.
    pub(crate) fn set_wall_table(&mut self, wall: usize, pieces: Vec<(f64, DVec2)>, repeats: bool) {
        let key = self.bodies[wall].key;
        self.wall_tables.retain(|table| table.key != key);
        if !pieces.is_empty() {
            self.wall_tables.push(WallTable {
                key,
                pieces,
                repeats,
                next: 0,
                begins: 0.0,
            });
        }
    }

    /// Whether any wall moves, or will move by a table.
    pub(crate) fn moves_walls(&self) -> bool {
        self.moving_walls().next().is_some() || !self.wall_tables.is_empty()
    }
}
