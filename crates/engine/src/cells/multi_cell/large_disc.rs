//! Contacts of large discs among small ones, with these and each other, by the closed form of two
//! discs, eight at a time.

use carom_detection::{DISC_LANES, Detection};
use smallvec::SmallVec;

use super::{EarliestEvent, Listed, MultiCellBody, Pending};
use crate::{
    cells::{
        frame::CellFrame,
        simd::{Kernel, NeighbourQuery, SoonestSlot},
        state::CellState,
    },
    scheduler::TouchingParts,
    world::World,
};

impl<F: CellFrame> CellState<F> {
    /// Finds the earliest contact of a large disc with the small discs around it and, by the closed
    /// form, with other large discs. Returns the number of pairs tested.
    #[expect(
        clippy::too_many_arguments,
        reason = "a search and what it is given are inlined together"
    )]
    #[inline(always)]
    pub(super) fn search_discs_around<D: Detection, K: Kernel>(
        &self,
        kernel: K,
        world: &World,
        detection: &D,
        multi_cell_body: &MultiCellBody,
        now: f64,
        except: Option<u32>,
        best: &mut EarliestEvent,
    ) -> u64 {
        let body = multi_cell_body.body;
        let query = self.multi_cell_query(body, now);
        let in_closed_form = detection.decides_discs_in_closed_form();
        let by_pair = world.pairs.is_active();
        let by_lists = except.is_none() && in_closed_form && !by_pair;
        let is_plain = |tile: &Listed| {
            by_lists && tile.image == [0; 2] && !self.neighbour_lists.list_of(tile.index).at_border
        };
        let (mut soonest, mut tested) = (SoonestSlot::NONE, 0);
        for tile in multi_cell_body.tiles.iter().filter(|tile| is_plain(tile)) {
            let list = self.neighbour_lists.list_of(tile.index);
            tested += list.count() as u64;
            soonest = soonest.or(match list.plain() {
                Some((slots, None)) => kernel
                    .soonest_of_eight::<false>(query, slots)
                    .in_slots(slots),
                _ => kernel.soonest_of_list(&query, &list),
            });
        }
        if !soonest.is_ambiguous {
            self.offer_disc(
                body,
                now + soonest.time,
                Listed {
                    index: soonest.slot,
                    image: [0; 2],
                },
                best,
            );
        }
        let mut pairs = if soonest.is_ambiguous { 0 } else { tested };
        let one_by_one = multi_cell_body
            .tiles
            .iter()
            .filter(|tile| soonest.is_ambiguous || !is_plain(tile));
        let small = one_by_one.flat_map(|&tile| self.seen_from(tile));
        let large = multi_cell_body.neighbours.iter().filter_map(|neighbour| {
            let other = &self.multi_cell.list[neighbour.index as usize];
            (in_closed_form && other.is_disc_among_discs).then_some(Listed {
                index: other.body,
                image: neighbour.image,
            })
        });
        let mut others = small
            .chain(large)
            .filter(|other| Some(other.index) != except)
            .filter(|other| !by_pair || self.pair_factor(world, [body, other.index]) > 0.0);
        loop {
            let some: SmallVec<[Listed; DISC_LANES]> = others.by_ref().take(DISC_LANES).collect();
            if some.is_empty() {
                return pairs;
            }
            pairs += some.len() as u64;
            let mut lanes = self.lanes::<DISC_LANES>(body, &some, now);
            if by_pair {
                for (lane, other) in some.iter().enumerate() {
                    lanes.contact_distance[lane] *= self.pair_factor(world, [body, other.index]);
                }
            }
            let times = detection.disc_contacts(&lanes);
            for (&other, time) in some.iter().zip(times) {
                self.offer_disc(body, now + time, other, best);
            }
        }
    }

    /// Replaces `best` by a contact of a large disc if this is earlier (`time`: offset in the
    /// epoch, infinite for none).
    #[inline]
    fn offer_disc(&self, body: u32, time: f64, other: Listed, best: &mut EarliestEvent) {
        if time < f64::INFINITY && best.is_preceded_by(time, other.index) {
            let image = self.path_image([body, other.index], other.image);
            best.set_contact(
                time,
                other.index,
                Pending {
                    parts: TouchingParts::Discs,
                    image,
                },
            );
        }
    }

    /// The query of a multi-cell body to those in the cells. Without common constants of a pair:
    /// they hold between small discs only.
    #[inline]
    pub(super) fn multi_cell_query(&self, body: u32, now: f64) -> NeighbourQuery<'_> {
        NeighbourQuery {
            pair_constants: None,
            ..self.query(body, now)
        }
    }

    /// Tests a disc in a cell against a large disc; `factor` is that on the sum of their radii.
    #[inline(always)]
    pub(super) fn test_large_disc(
        &mut self,
        disc: u32,
        large: Listed,
        factor: f64,
        now: f64,
        best: &mut EarliestEvent,
    ) {
        self.count_pairs(disc, 1);
        let mut lanes = self.lanes::<1>(disc, &[large], now);
        lanes.contact_distance[0] *= factor;
        let [time] = lanes.contact_times();
        self.offer_disc(disc, now + time, large, best);
    }
}
