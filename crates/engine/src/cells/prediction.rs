//! The prediction of a body's next event, by the kind of body.

use carom_detection::Detection;

use super::{
    body_record::RecordKind,
    cell_grid::CellContents,
    discs::predict_sheared_disc,
    discs_by_pair::predict_disc_by_pair,
    dispatch::dispatched,
    frame::CellFrame,
    molecule_search::predict_molecule,
    multi_cell::{EarliestEvent, predict_multi_cell},
    simd::Kernel,
    state::CellState,
};
use crate::world::World;

dispatched!(predict_all(now: f64));

impl<F: CellFrame> CellState<F> {
    #[inline(always)]
    pub(super) fn predict_all<D: Detection, K: Kernel>(
        &mut self,
        kernel: K,
        world: &World,
        detection: &D,
        now: f64,
    ) {
        for body in 0..self.dummy() {
            self.predict(kernel, world, detection, body, now);
        }
    }

    /// Finds a body's earliest event, writes it into the body's record, and returns its time.
    #[inline(always)]
    pub(super) fn predict<D: Detection, K: Kernel>(
        &mut self,
        kernel: K,
        world: &World,
        detection: &D,
        body: u32,
        now: f64,
    ) -> f64 {
        match self.grid.contents() {
            CellContents::Discs if !self.multi_cell.is_multi_cell(body) => {
                let events = self.query_neighbours(kernel, body, now);
                self.store_disc_event(world, detection, body, now, &events)
            }
            CellContents::TiedDiscs if !self.multi_cell.is_multi_cell(body) => {
                let events = self.query_neighbours(kernel, body, now);
                self.store_disc_event(world, detection, body, now, &events);
                self.search_partners(world, body, now, None);
                self.records[body as usize].time
            }
            // All bodies of a dilute gas live in cells.
            CellContents::DiluteDiscs if F::IS_WHOLE => {
                self.predict_dilute(kernel, detection, body, now)
            }
            _ => self.predict_searching(world, detection, body, now, None),
        }
    }

    /// Finds the earliest event of a body that searches candidates, and returns its time; `except`
    /// is a partner to skip.
    #[inline(never)]
    pub(super) fn predict_searching<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        body: u32,
        now: f64,
        except: Option<u32>,
    ) -> f64 {
        if self.multi_cell.is_fixed(body) {
            // Its record has no event from the start of the epoch on, unless it is a wall that
            // moves.
            let until = self.multi_cell.listed_until(body);
            if until < f64::INFINITY {
                self.store_event(body, &EarliestEvent::before(until, RecordKind::Shell));
            }
            return until;
        }
        if self.grid.contents() == CellContents::ShearedDiscs && !self.is_at_border(body) {
            // At the border images move.
            predict_sheared_disc(self, world, detection, body, now);
        } else if F::IS_WHOLE && self.multi_cell.is_multi_cell(body) {
            predict_multi_cell(self, world, detection, body, now, except);
        } else if self.grid.is_by_pair() {
            predict_disc_by_pair(self, world, detection, body, now);
        } else {
            predict_molecule(self, world, detection, body, now, except);
        }
        if world.is_tethered() || world.has_wells() {
            self.search_partners(world, body, now, except);
        }
        self.records[body as usize].time
    }

    /// Of two bodies that have just met, the one whose prediction may skip the partner, and the
    /// partner, which is predicted afterwards.
    ///
    /// None for two discs in cells: their test in lanes costs nothing more. Of two others the
    /// motions decide, so that the choice does not depend on the order of insertion.
    pub(super) fn skip_partner(&self, [a, b]: [u32; 2]) -> Option<[u32; 2]> {
        if self.multi_cell.is_fixed(a) | self.multi_cell.is_fixed(b) {
            return None;
        }
        let searches = |body| self.grid.holds_molecules() | self.multi_cell.is_multi_cell(body);
        // The squared speed is invariant under reflections of the system.
        let speed_squared = |body: u32| self.records[body as usize].velocity().length_squared();
        match (searches(a), searches(b)) {
            (false, false) => None,
            (true, false) => Some([a, b]),
            (false, true) => Some([b, a]),
            _ if speed_squared(a) < speed_squared(b) => Some([a, b]),
            _ if speed_squared(b) < speed_squared(a) => Some([b, a]),
            _ => None,
        }
    }
}
