//! Small discs of which some do not see each other, or touch at another distance than the sum of
//! their radii.
//!
//! The candidates are filtered before the search, and the search takes the contact distance of each
//! pair. The scheduler uses this search only where a rule for pairs of tags affects a body, so that
//! other scenes do not pay for it. The contact times are those of `discs` to the bit.

use carom_detection::{DISC_LANES, Detection};
use smallvec::SmallVec;

use super::{
    frame::{CellFrame, Numbering},
    simd::{NeighbourQuery, sooner},
    slot::INDEX_MASK,
    state::CellState,
};
use crate::world::World;

impl<F: CellFrame> CellState<F> {
    /// The factor on the sum of the radii of two bodies at their contact; 0 if they do not see each
    /// other.
    #[inline]
    pub(super) fn pair_factor(&self, world: &World, pair: [u32; 2]) -> f64 {
        world.pair_factor(pair.map(|body| self.bodies.among_all(body)))
    }

    /// Finds the earliest event of a small disc and writes it into its record.
    #[inline(never)]
    pub(super) fn predict_disc_by_pair<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        disc: u32,
        now: f64,
    ) {
        let query = NeighbourQuery {
            pair_constants: None,
            ..self.query(disc, now)
        };
        let list = self.neighbour_lists.list(query.from.cell());
        let covered = list.is_covered().then_some(list.cell);
        let mut soonest = (f64::INFINITY, 0);
        // The factors are those of `World::pair_factor`, looked up once.
        let mut visible = SmallVec::<[(u32, f64); 4 * DISC_LANES]>::new();
        let body = self.bodies.among_all(disc);
        let factors = world
            .pairs
            .factors_outside_wells(&world.bodies[body as usize]);
        let in_wells = world.shells.at(body);
        // One of 64 bits for each partner: most other discs then need no look at the list.
        let bit = |body: u32| 1_u64 << (body % u64::BITS);
        let bits = in_wells
            .iter()
            .fold(0, |bits, entry| bits | bit(entry.partner));
        list.for_each_slots8(|slots| {
            for &slot in slots {
                let other = slot & INDEX_MASK;
                if other == disc || other == self.dummy() {
                    continue;
                }
                let other = self.bodies.among_all(other);
                let factor = if let &[only] = factors {
                    only
                } else {
                    let class = world.bodies[other as usize].kind.tag_class;
                    factors.get(class as usize).copied().unwrap_or(1.0)
                };
                let is_in_well =
                    bits & bit(other) != 0 && in_wells.iter().any(|entry| entry.partner == other);
                if factor > 0.0 && !is_in_well {
                    visible.push((slot, factor));
                }
            }
        });
        for some in visible.chunks(DISC_LANES) {
            let mut slots = [self.dummy(); DISC_LANES];
            for (lane, &(slot, _)) in some.iter().enumerate() {
                slots[lane] = slot;
            }
            let mut lanes = query.lanes(&slots, true);
            for (lane, &(_, factor)) in some.iter().enumerate() {
                lanes.contact_distance[lane] *= factor;
            }
            let times = detection.disc_contacts(&lanes);
            for (&slot, time) in slots.iter().zip(times) {
                soonest = sooner(soonest, (time, slot & INDEX_MASK));
            }
        }
        let crossing = self.crossing(query.from, now);
        self.write_earlier_event(disc, (now + soonest.0, soonest.1), crossing);
        if let Some(cell) = covered {
            self.search_covered_cell(world, detection, disc, cell, now, None);
        }
    }
}
