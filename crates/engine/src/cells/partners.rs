//! The partners of a body by bonds and wells: each is searched with every prediction of the body,
//! wherever it is.

use carom_detection::Outcome;
use carom_kinematics::Motion;

use super::{
    body_record::RecordKind, frame::CellFrame, multi_cell::EarliestEvent, state::CellState,
};
use crate::{
    scheduler::TouchingParts,
    world::{World, tethers::BondEnd, wells::InWell},
};

impl<F: CellFrame> CellState<F> {
    /// Finds the events of a body's bonds, and its steps in wells, that precede its present event,
    /// and stores the earliest; `except` is a partner to skip.
    #[inline(never)]
    pub(super) fn search_partners(
        &mut self,
        world: &World,
        body: u32,
        now: f64,
        except: Option<u32>,
    ) {
        let (ends, wells) = (world.bonds_of(body), world.shells.at(body));
        if ends.is_empty() && wells.is_empty() {
            return;
        }
        let mut best = self.stored_event(body);
        let own = self.motion(body);
        for &BondEnd { bond, partner } in ends {
            if Some(partner) != except {
                let bodies = world.bonds()[bond as usize].bodies;
                let event = |motions: [&Motion; 2], horizon: f64| {
                    world.first_bond_event(bond, motions, now, horizon)
                };
                self.offer_partner((body, &own), (partner, bodies), event, now, &mut best);
            }
        }
        for &InWell { partner, shell } in wells {
            if Some(partner) != except {
                let bodies = [body.min(partner), body.max(partner)];
                let event = |motions: [&Motion; 2], horizon: f64| {
                    world.first_step_from(shell, bodies, motions, now, horizon)
                };
                self.offer_partner((body, &own), (partner, bodies), event, now, &mut best);
            }
        }
        if matches!(best.kind, RecordKind::MultiCell | RecordKind::Recheck) {
            self.store_event(body, &best);
        }
    }

    /// Replaces the best event of a body, with its motion, by that of it and a partner, if it is
    /// earlier. `bodies` are both in the order of `event`, which searches up to a horizon (time
    /// from now) and returns the image of the second.
    #[inline(always)]
    fn offer_partner(
        &mut self,
        (body, own): (u32, &Motion),
        (partner, bodies): (u32, [u32; 2]),
        event: impl FnOnce([&Motion; 2], f64) -> (Outcome<TouchingParts>, [i64; 2]),
        now: f64,
        best: &mut EarliestEvent,
    ) {
        self.count_pairs(body, 1);
        let other = self.motion(partner);
        let horizon = best.time.min(self.limit) - now;
        let (outcome, seen) = if bodies[0] == body {
            event([own, &other], horizon)
        } else {
            let (outcome, image) = event([&other, own], horizon);
            (outcome, image.map(|boxes| -boxes))
        };
        let seen = seen.map(|boxes| boxes as i32);
        self.offer(body, (partner, seen), outcome, now, best);
    }
}
