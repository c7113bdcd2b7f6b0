//! The bonds of a body: each is searched with every prediction of it, wherever its partner is.

use super::{body_record::RecordKind, frame::CellFrame, state::CellState};
use crate::world::{World, tethers::BondEnd};

impl<F: CellFrame> CellState<F> {
    /// Finds the events of a body's bonds that precede its present event, and stores the earliest;
    /// `except` is a partner to skip.
    #[inline(never)]
    pub(super) fn search_bonds(&mut self, world: &World, body: u32, now: f64, except: Option<u32>) {
        let ends = world.bonds_of(body);
        if ends.is_empty() {
            return;
        }
        let mut best = self.stored_event(body);
        for &BondEnd { bond, partner } in ends {
            if Some(partner) == except {
                continue;
            }
            self.count_pairs(body, 1);
            let bodies = world.bonds()[bond as usize].bodies;
            let motions = bodies.map(|body| self.motion(body));
            let horizon = best.time.min(self.limit) - now;
            let (outcome, image) =
                world.first_bond_event(bond, [&motions[0], &motions[1]], now, horizon);
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
