//! The bonds of a body: each is searched with every prediction of it, wherever its partner is.

use carom_detection::TetherOutcome;

use super::{frame::CellFrame, multi_cell::Pending, state::CellState};
use crate::{
    scheduler::TouchingParts,
    world::{World, tethers::BondEnd},
};

impl<F: CellFrame> CellState<F> {
    /// Finds the events of a body's bonds that precede its present event, and stores the earliest;
    /// `except` is a partner to skip.
    #[inline(never)]
    pub(super) fn search_bonds(&mut self, world: &World, body: u32, now: f64, except: Option<u32>) {
        let mut best = self.stored_event(body);
        let mut is_changed = false;
        for &BondEnd { bond, partner } in world.bonds_of(body) {
            if Some(partner) == except {
                continue;
            }
            self.count_pairs(body, 1);
            let bodies = world.bonds()[bond as usize].bodies;
            let motions = bodies.map(|body| self.motion(body));
            let horizon = best.time.min(self.limit) - now;
            let (outcome, image) =
                world.first_bond_event(bond, [&motions[0], &motions[1]], now, horizon);
            match outcome {
                TetherOutcome::Free => {}
                TetherOutcome::Reached(time, bound) => {
                    let time = now + time;
                    if best.is_preceded_by(time, partner) {
                        let seen = image.map(|boxes| boxes as i32);
                        let parts = TouchingParts::Bond(bond, bound);
                        let image = self.path_image(bodies, seen);
                        best.set_contact(time, partner, Pending { parts, image });
                        is_changed = true;
                    }
                }
                TetherOutcome::FreeUntil(time) => {
                    let time = (now + time).max(now.next_up());
                    is_changed |= time < best.time;
                    best.offer_recheck(time);
                }
                // The bond is predicted again in the next epoch, which starts from other numbers.
                TetherOutcome::OutOfRange => self.count_unresolved(body),
            }
        }
        if is_changed {
            self.store_event(body, &best);
        }
    }
}
