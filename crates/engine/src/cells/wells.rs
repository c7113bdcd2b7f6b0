//! The steps of a disc in wells: each is searched with every prediction of it, wherever its partner
//! is.

use super::{body_record::RecordKind, frame::CellFrame, state::CellState};
use crate::world::{World, wells::InWell};

impl<F: CellFrame> CellState<F> {
    /// Finds the steps of a disc in wells that precede its present event, and stores the earliest;
    /// `except` is a partner to skip.
    #[inline(never)]
    pub(super) fn search_steps(&mut self, world: &World, body: u32, now: f64, except: Option<u32>) {
        let entries = world.shells.at(body);
        if entries.is_empty() {
            return;
        }
        let mut best = self.stored_event(body);
        for &InWell { partner, shell } in entries {
            if Some(partner) == except {
                continue;
            }
            self.count_pairs(body, 1);
            let bodies = [body.min(partner), body.max(partner)];
            let motions = bodies.map(|body| self.motion(body));
            let horizon = best.time.min(self.limit) - now;
            let motions = [&motions[0], &motions[1]];
            let (outcome, image) = world.first_step_from(shell, bodies, motions, now, horizon);
            let seen = if bodies[0] == body {
                image
            } else {
                image.map(|boxes| -boxes)
            };
            let seen = seen.map(|boxes| boxes as i32);
            self.offer(body, (partner, seen), outcome, now, &mut best);
        }
        if matches!(best.kind, RecordKind::MultiCell | RecordKind::Recheck) {
            self.store_event(body, &best);
        }
    }
}
