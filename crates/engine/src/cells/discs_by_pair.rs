//! Small discs of which some do not see each other, or touch at another distance than the sum of
//! their radii.
//!
//! The discs around one are sorted by the distance at which it meets them, and searched in lanes.
//! The scheduler uses this search only where a rule for pairs of tags affects a body, so that other
//! scenes do not pay for it. The contact times are those of `discs` to the bit.

use carom_detection::{DISC_LANES, Detection};
use smallvec::SmallVec;

use super::{
    cell_block::CellBlock,
    dispatch::dispatched,
    frame::{CellFrame, Numbering},
    pair_classes::DistanceGroup,
    simd::{Kernel, NeighbourQuery, SoonestSlot, sooner},
    slot::INDEX_MASK,
    state::CellState,
};
use crate::world::{World, wells::InWell};

dispatched!(predict_disc_by_pair(disc: u32, now: f64));

impl<F: CellFrame> CellState<F> {
    /// The factor on the sum of the radii of two bodies at their contact; 0 if they do not see each
    /// other.
    #[inline]
    pub(super) fn pair_factor(&self, world: &World, pair: [u32; 2]) -> f64 {
        world.pair_factor(pair.map(|body| self.bodies.among_all(body)))
    }

    /// Finds the earliest event of a small disc and writes it into its record.
    #[inline(always)]
    pub(super) fn predict_disc_by_pair<D: Detection, K: Kernel>(
        &mut self,
        kernel: K,
        world: &World,
        detection: &D,
        disc: u32,
        now: f64,
    ) {
        let query = self.query(disc, now);
        let list = self.neighbour_lists.list(query.from.cell());
        let covered = list.is_covered().then_some(list.cell);
        let partners = PartnersInWells::new(world.shells.at(self.bodies.among_all(disc)));
        let mut soonest = SoonestSlot::NONE;
        let groups = self.pair_classes.groups_of(disc);
        let groups = groups.filter(|_| !self.asks_detector);
        for group in groups.into_iter().flatten() {
            soonest = soonest.or(self.soonest_at(kernel, &query, &list, group, &partners));
        }
        let contact = if groups.is_none() | soonest.is_ambiguous {
            self.search_pairs(world, detection, (disc, &partners), now)
        } else {
            (soonest.time, soonest.slot & INDEX_MASK)
        };
        let crossing = self.crossing(query.from, now);
        self.write_earlier_event(disc, (now + contact.0, contact.1), crossing);
        if let Some(cell) = covered {
            self.search_covered_cell(world, detection, disc, cell, now, None);
        }
    }

    /// The earliest contact with the discs of a list that are met at one distance, without those in
    /// the well of the disc.
    #[inline(always)]
    fn soonest_at<K: Kernel>(
        &self,
        kernel: K,
        query: &NeighbourQuery<'_>,
        list: &CellBlock<'_>,
        group: &DistanceGroup,
        partners: &PartnersInWells<'_>,
    ) -> SoonestSlot {
        let query = NeighbourQuery {
            pair_constants: group.pair_constants,
            ..*query
        };
        let mut soonest = SoonestSlot::NONE;
        let mut eight = [list.dummy; DISC_LANES];
        let mut count = 0;
        list.for_each_slots8(|slots| {
            for &slot in slots {
                let other = slot & INDEX_MASK;
                eight[count] = slot;
                let is_met = group.has(self.pair_classes.class_of(other))
                    && !partners.has(self.bodies.among_all(other));
                count += usize::from(is_met);
                if count == DISC_LANES {
                    let of_eight = kernel.soonest_of_eight::<true>(query, &eight);
                    soonest = soonest.or(of_eight.in_slots(&eight));
                    count = 0;
                }
            }
        });
        if count > 0 {
            eight[count..].fill(list.dummy);
            let of_eight = kernel.soonest_of_eight::<true>(query, &eight);
            soonest = soonest.or(of_eight.in_slots(&eight));
        }
        soonest
    }

    /// The earliest contact of a small disc, with the distance of each pair by itself and as the
    /// detector finds it: time from now (infinite for none) and partner.
    #[inline(never)]
    fn search_pairs<D: Detection>(
        &self,
        world: &World,
        detection: &D,
        (disc, partners): (u32, &PartnersInWells<'_>),
        now: f64,
    ) -> (f64, u32) {
        let query = NeighbourQuery {
            pair_constants: None,
            ..self.query(disc, now)
        };
        let list = self.neighbour_lists.list(query.from.cell());
        let mut visible = SmallVec::<[(u32, f64); 4 * DISC_LANES]>::new();
        let class = |body: u32| world.bodies[body as usize].kind.tag_class as usize;
        let own_class = class(self.bodies.among_all(disc));
        for slot in list.slots().filter(|slot| slot & INDEX_MASK != disc) {
            let other = self.bodies.among_all(slot & INDEX_MASK);
            let factor = world.pairs.factor_outside_well(own_class, class(other));
            if factor > 0.0 && !partners.has(other) {
                visible.push((slot, factor));
            }
        }
        let mut soonest = (f64::INFINITY, 0);
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
        soonest
    }
}

/// The discs in whose wells one disc is.
struct PartnersInWells<'a> {
    list: &'a [InWell],
    /// One of 64 bits for each: most other discs then need no look at the list.
    bits: u64,
}

impl<'a> PartnersInWells<'a> {
    #[inline(always)]
    fn new(list: &'a [InWell]) -> Self {
        let partners = list.iter().map(|entry| Self::bit(entry.partner));
        Self {
            list,
            bits: partners.fold(0, |bits, bit| bits | bit),
        }
    }

    #[inline(always)]
    fn bit(body: u32) -> u64 {
        1 << (body % u64::BITS)
    }

    #[inline(always)]
    fn has(&self, body: u32) -> bool {
        self.bits & Self::bit(body) != 0 && self.list.iter().any(|entry| entry.partner == body)
    }
}

#[cfg(test)]
mod tests {
    use carom_detection::Exact;

    use super::*;
    use crate::{
        CellScheduler, Instructions,
        cells::{body_record::RecordKind, cell_grid::CellGrid, frame::WholeBox, simd::available},
        run::simulation::Simulation,
        scene::Scene,
    };

    fn gas(tag: &str, radius: &str, count: u32) -> String {
        format!(
            "[[gas]]\ntags = [\"{tag}\"]\nradius = {radius}\nmass = 1.0\nenergy = 1.0\ncount = {count}\n"
        )
    }

    /// Predicts all discs of a scene; every contact must be that of the search pair by pair.
    /// Returns the number of discs that were searched in lanes, and that of contacts.
    fn compare(text: &str) -> [usize; 2] {
        let scene = Scene::from_toml(text).unwrap_or_else(|error| panic!("{error}"));
        let simulation =
            Simulation::<Exact, carom_response::Impact, CellScheduler>::new(&scene).unwrap();
        let world = &simulation.world;
        let grid = CellGrid::new(world).expect("the box has three cells a side");
        let mut state = CellState::new(available(Instructions::Widest), grid, WholeBox);
        state.begin_epoch(world, &simulation.detection, 1.0);
        let mut counts = [0; 2];
        for disc in 0..state.dummy() {
            let groups = state.pair_classes.groups_of(disc);
            counts[0] += usize::from(groups.is_some());
            let partners = PartnersInWells::new(world.shells.at(disc));
            let detection = &simulation.detection;
            let (time, partner) = state.search_pairs(world, detection, (disc, &partners), 0.0);
            let record = &state.records[disc as usize];
            if record.kind() == RecordKind::Discs {
                assert_eq!(
                    (record.time, record.partner()),
                    (time, partner),
                    "disc {disc}"
                );
                counts[1] += 1;
            } else {
                assert!(time >= record.time, "disc {disc}");
            }
        }
        counts
    }

    #[test]
    fn contacts_in_lanes_are_those_of_each_pair_by_itself() {
        let unseen = "[[transparent]]\nbetween = [\"a\", \"b\"]\n";
        let wider = "[[diameter]]\nbetween = [\"a\", \"b\"]\nfactor = 1.3\n";
        let wells = "[[well]]\nbetween = [\"a\", \"b\"]\nsteps = [[1.5, -1.0]]\n";
        let like = gas("a", "0.008", 300) + &gas("b", "0.008", 300);
        let unlike = gas("a", "0.008", 300) + &gas("b", "0.012", 200);
        for rule in [unseen, wider, wells] {
            for discs in [&like, &unlike] {
                let [in_lanes, contacts] = compare(&format!("{discs}{rule}"));
                assert!(in_lanes >= 500 && contacts > 10, "{in_lanes}, {contacts}");
            }
        }
    }

    #[test]
    fn discs_of_many_distances_are_searched_pair_by_pair() {
        // Radii that differ within a tag, with a factor on them.
        let sizes = "{ uniform = [0.006, 0.01] }";
        let wider = "[[diameter]]\nbetween = [\"a\", \"b\"]\nfactor = 1.3\n";
        let [in_lanes, contacts] = compare(
            &(gas("a", sizes, 200) + &gas("b", sizes, 200) + &gas("c", sizes, 100) + wider),
        );
        assert_eq!(in_lanes, 100);
        assert!(contacts > 20, "{contacts}");
        // More classes than the tables hold.
        let many: String = (0..20)
            .map(|n| gas(&format!("t{n}"), "0.008", 25))
            .collect();
        let unseen = "[[transparent]]\nbetween = [\"t0\", \"t1\"]\n";
        let [in_lanes, contacts] = compare(&(many + unseen));
        assert_eq!(in_lanes, 0);
        assert!(contacts > 20, "{contacts}");
    }
}
