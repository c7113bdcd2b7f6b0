//! Event handling in a dilute gas of equal discs: after a crossing only the three new cells are
//! searched.
//!
//! Discs cross many cells between two contacts. So each disc keeps its earliest contact while a
//! crossing comes before it, and after the crossing it tests only the discs in the three cells that
//! are newly adjacent.
//!
//! The lemmas of the parent module hold. The contact that a disc keeps is the earliest in this
//! epoch with all discs related to it at its last full prediction. A relation that began later was
//! tested at the crossing that began it, by the disc that crossed. A disc whose motion changed
//! later tested the pair at its own prediction. If the partner of the contact has changed since,
//! the time of the contact is still a lower bound for all these contacts, and the full prediction
//! follows when it comes due.
//!
//! A floating-point filter excludes most discs in the cells: see `f32_filter`.

use std::hint::select_unpredictable as select;

use carom_detection::{DISC_LANES, Detection};

use super::{
    body_record::RecordKind,
    frame::CellFrame,
    simd::{Kernel, goes_before, sooner},
    slot::{INDEX_BITS, INDEX_MASK},
    state::CellState,
};

impl<F: CellFrame> CellState<F> {
    /// Finds the earliest event of a disc whose motion has changed, or whose contact came due
    /// stale.
    #[inline(always)]
    pub(super) fn predict_dilute<D: Detection, K: Kernel>(
        &mut self,
        kernel: K,
        detection: &D,
        disc: u32,
        now: f64,
    ) -> f64 {
        let around = self.occupants.around(self.records[disc as usize].cell());
        let (soonest, partner) = self.soonest_in_cells(kernel, detection, disc, around, now);
        let version = self.records[partner as usize].version;
        self.store_dilute_event(disc, now, now + soonest, partner, version)
    }

    /// Moves a disc into the next cell, and finds its earliest event.
    #[inline(always)]
    pub(super) fn cross_dilute<D: Detection, K: Kernel>(
        &mut self,
        kernel: K,
        detection: &D,
        disc: u32,
        kind: RecordKind,
        now: f64,
    ) -> f64 {
        self.done.crossings += 1;
        let (axis, direction) = kind.direction();
        let record = &mut self.records[disc as usize];
        let from = record.cell();
        if let Some(next) = self.grid.next(record.cell_along(axis), axis, direction) {
            record.set_cell_along(axis, next);
        } else {
            self.wrap_place(disc, axis, direction);
        }
        let to = self.records[disc as usize].cell();
        self.occupants.leave(kernel, disc, from);
        self.occupants
            .enter(kernel, disc, to, self.records[disc as usize].flight);
        let ahead = self.occupants.ahead(to, axis, direction);
        let (soonest, partner) = self.soonest_in_cells(kernel, detection, disc, ahead, now);
        let contact_time = now + soonest;
        let record = &self.records[disc as usize];
        let version = self.records[partner as usize].version;
        let is_sooner = goes_before(
            (contact_time, partner),
            (record.kept_contact_time(), record.partner()),
        );
        let time = select(is_sooner, contact_time, record.kept_contact_time());
        let partner = select(is_sooner, partner, record.partner());
        let version = select(is_sooner, version, record.partner_version);
        self.store_dilute_event(disc, now, time, partner, version)
    }

    #[inline(always)]
    fn store_dilute_event(
        &mut self,
        disc: u32,
        now: f64,
        contact_time: f64,
        partner: u32,
        version: u32,
    ) -> f64 {
        let record = &self.records[disc as usize];
        let (crossing_time, crossing) = self.crossing(record, now);
        let meets = contact_time <= crossing_time;
        let time = if crossing_time < contact_time {
            crossing_time
        } else {
            contact_time
        };
        let kind = select(meets, RecordKind::Discs, crossing);
        let record = &mut self.records[disc as usize];
        record.set_event(time, kind, partner, version);
        record.set_kept_contact_time(contact_time);
        time
    }

    /// The earliest contact in this epoch of a disc with the discs of some cells around its own:
    /// time from now (infinite for none) and partner. Of contacts at one time it is that with the
    /// disc inserted first.
    #[inline(always)]
    fn soonest_in_cells<D: Detection, K: Kernel, const N: usize>(
        &self,
        kernel: K,
        detection: &D,
        disc: u32,
        cells: [u32; N],
        now: f64,
    ) -> (f64, u32) {
        let query = self.query(disc, now);
        debug_assert!(
            query.pair_constants.is_some(),
            "the discs of a dilute gas have different radii"
        );
        let (blocks, units) = (self.occupants.blocks(), self.occupants.units());
        let filter = units.filter(&query.from.flight, now);
        let in_closed_form = detection.decides_discs_in_closed_form();
        let all_lanes = if in_closed_form && !units.is_disabled() {
            0
        } else {
            (1 << DISC_LANES) - 1
        };
        let mut soonest = (f64::INFINITY, 0);
        // The filter comes first and collects candidates, the exact test follows: the filter's
        // loop, which runs far more often, then has all registers.
        let (mut slots, mut count) = ([0; DISC_LANES], 0);
        for cell in cells {
            let filter = filter.for_image(units, (cell >> INDEX_BITS) as usize);
            for (flights, discs) in blocks.blocks(cell) {
                let mut near = kernel.near(&filter, flights) | all_lanes;
                while near != 0 {
                    let other = discs[near.trailing_zeros() as usize % DISC_LANES];
                    slots[count] = other | cell & !INDEX_MASK;
                    count += usize::from(other != disc);
                    near &= near - 1;
                    if count == DISC_LANES {
                        soonest = sooner(
                            soonest,
                            query.resolve_with_detector(detection, &slots, true),
                        );
                        count = 0;
                    }
                }
            }
        }
        if !in_closed_form {
            slots[count..].fill(self.occupants.dummy());
            return sooner(
                soonest,
                query.resolve_with_detector(detection, &slots, true),
            );
        }
        for &slot in &slots[..count] {
            let [time] = query.lanes(&[slot], true).contact_times();
            soonest = sooner(soonest, (time, slot & INDEX_MASK));
        }
        soonest
    }
}

#[cfg(test)]
mod tests {
    use crate::{
        cells::{CellScheduler, Instructions, Layout},
        run::simulation::Simulation,
        scene::{Scene, gas_spec::GasSpec},
    };
    use carom_detection::Exact;
    use carom_response::Impact;

    fn disc(mass: f64, energy: f64) -> GasSpec {
        GasSpec {
            radius: Some(0.004.into()),
            mass: Some(mass.into()),
            energy,
            count: Some(60),
            ..GasSpec::default()
        }
    }

    /// Number of contacts after which the filter is disabled.
    fn disabled_steps(gas: Vec<GasSpec>, contacts: usize) -> usize {
        let scene = Scene {
            gas,
            ..Scene::default()
        };
        let mut simulation: Simulation<_, _, CellScheduler> =
            Simulation::with(&scene, Exact::default(), Impact, Instructions::Widest).unwrap();
        let mut is_disabled = || {
            simulation.step(1e3, &mut ()).unwrap();
            let Layout::Grid(cells) = &simulation.scheduler.0 else {
                panic!("no cells")
            };
            assert!(cells.whole.grid.is_dilute());
            cells.whole.occupants.units().is_disabled()
        };
        (0..contacts).filter(|_| is_disabled()).count()
    }

    #[test]
    fn the_filter_is_disabled_only_after_speeds_beyond_its_unit() {
        assert_eq!(disabled_steps(vec![disc(1.0, 1.0)], 3000), 0);
        let kicked = disabled_steps(vec![disc(1.0, 1.0), disc(1e-3, 1e-9)], 10_000);
        assert!((100..9_900).contains(&kicked), "{kicked}");
    }
}
