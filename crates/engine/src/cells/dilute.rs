//! The loop of a dilute gas of like discs: after a crossing only the three new cells are looked at.
//!
//! Far apart, discs cross many cells between two contacts. So each keeps its soonest contact also while a crossing goes
//! before it, and after the crossing asks only those it could not see before. The rule that nothing is missed stands:
//! the contact kept is the soonest, in this epoch, with all that were related when the disc was last predicted in full;
//! whoever has become related since was asked at the crossing that made it so, or crossed over itself and asked then; whoever
//! has changed its motion since has asked. If the partner of the contact kept has changed since, its time is still a lower
//! bound of all those, and the full prediction is made when it comes up.
//!
//! Most that are seen in the cells are not met, and are sorted out at a filter: see `filter`.

use std::hint::select_unpredictable as select;

use carom_detection::{DISC_LANES, Detection};

use super::{
    State,
    body_record::{INDEX_BITS, INDEX_MASK, Kind},
    simd::{Kernel, goes_before, sooner},
};

impl State {
    /// Finds the soonest event of a disc whose motion has changed, or whose contact came up stale.
    #[inline(always)]
    pub(super) fn predict_among_few<D: Detection, K: Kernel>(
        &mut self,
        kernel: K,
        detection: &D,
        disc: u32,
        now: f64,
    ) -> f64 {
        let around = self.occupants.around(self.records[disc as usize].cell());
        let (soonest, partner) = self.ask_cells(kernel, detection, disc, around, now);
        let version = self.records[partner as usize].version;
        self.settle_among_few(disc, now, now + soonest, partner, version)
    }

    /// Moves a disc into the next cell, and finds its soonest event.
    #[inline(always)]
    pub(super) fn cross_among_few<D: Detection, K: Kernel>(
        &mut self,
        kernel: K,
        detection: &D,
        disc: u32,
        kind: Kind,
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
        self.occupants.enter(kernel, disc, to, self.records[disc as usize].flight);
        let ahead = self.occupants.ahead(to, axis, direction);
        let (soonest, partner) = self.ask_cells(kernel, detection, disc, ahead, now);
        let contact_time = now + soonest;
        let record = &self.records[disc as usize];
        let version = self.records[partner as usize].version;
        let is_sooner = goes_before((contact_time, partner), (record.later(), record.partner()));
        let time = select(is_sooner, contact_time, record.later());
        let partner = select(is_sooner, partner, record.partner());
        let version = select(is_sooner, version, record.partner_version);
        self.settle_among_few(disc, now, time, partner, version)
    }

    /// Takes a disc's new flight over into its roster, if it stands on one.
    #[inline(always)]
    pub(super) fn keep_on_roster<K: Kernel>(&mut self, kernel: K, disc: u32) {
        if self.grid.is_dilute() {
            let record = &self.records[disc as usize];
            self.occupants.set_flight(kernel, disc, record.cell(), record.flight);
        }
    }

    #[inline(always)]
    fn settle_among_few(
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
        let time = if crossing_time < contact_time { crossing_time } else { contact_time };
        let kind = select(meets, Kind::Discs, crossing);
        let record = &mut self.records[disc as usize];
        record.set_event(time, kind, partner, version);
        record.set_later(contact_time);
        time
    }

    /// The soonest contact in this epoch (from now on) with the discs of some cells around a disc's own, and with whom. Of
    /// contacts at one time it is that with the disc inserted first.
    #[inline(always)]
    fn ask_cells<D: Detection, K: Kernel, const N: usize>(
        &self,
        kernel: K,
        detection: &D,
        disc: u32,
        cells: [u32; N],
        now: f64,
    ) -> (f64, u32) {
        let query = self.query(disc, now);
        debug_assert!(query.like.is_some(), "discs of a dilute gas that are not alike");
        let (blocks, units) = (self.occupants.blocks(), self.occupants.units());
        let filter = units.filter(&query.from.flight, now);
        let in_closed_form = detection.decides_discs_in_closed_form();
        let everybody = if in_closed_form && !units.is_disabled() { 0 } else { (1 << DISC_LANES) - 1 };
        let mut soonest = (f64::INFINITY, 0);
        // First who may be met, then when: so the first loop, which is gone through far more often, has all registers.
        let (mut slots, mut count) = ([0; DISC_LANES], 0);
        for cell in cells {
            let filter = filter.through(units, (cell >> INDEX_BITS) as usize);
            for (flights, discs) in blocks.of(cell) {
                let mut near = kernel.near(&filter, flights) | everybody;
                while near != 0 {
                    let other = discs[near.trailing_zeros() as usize % DISC_LANES];
                    slots[count] = other | cell & !INDEX_MASK;
                    count += usize::from(other != disc);
                    near &= near - 1;
                    if count == DISC_LANES {
                        soonest = sooner(soonest, query.look_closer(detection, &slots, true));
                        count = 0;
                    }
                }
            }
        }
        if !in_closed_form {
            slots[count..].fill(self.occupants.dummy());
            return sooner(soonest, query.look_closer(detection, &slots, true));
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
    use crate::{CellScheduler, GasSpec, Instructions, Scene, Simulation, cells::Layout};
    use carom_detection::Exact;
    use carom_response::Impact;

    fn disc(mass: f64, energy: f64) -> GasSpec {
        GasSpec { radius: Some(0.004), mass: Some(mass), energy, count: Some(60), ..GasSpec::default() }
    }

    /// After how many of the contacts a filter told nothing.
    fn blind(gas: Vec<GasSpec>, contacts: usize) -> usize {
        let scene = Scene { gas, ..Scene::default() };
        let mut simulation: Simulation<_, _, CellScheduler> =
            Simulation::with(&scene, Exact::default(), Impact, Instructions::Widest).unwrap();
        let mut is_disabled = || {
            simulation.step(1e3, &mut ()).unwrap();
            let Layout::Grid(state) = &simulation.scheduler.0 else { panic!("no cells") };
            assert!(state.grid.is_dilute());
            state.occupants.units().is_disabled()
        };
        (0..contacts).filter(|_| is_disabled()).count()
    }

    #[test]
    fn a_gas_is_seen_through_unless_some_get_faster_than_anybody_was() {
        assert_eq!(blind(vec![disc(1.0, 1.0)], 3000), 0);
        let kicked = blind(vec![disc(1.0, 1.0), disc(1e-3, 1e-9)], 10_000);
        assert!((100..9_900).contains(&kicked), "{kicked}");
    }
}
