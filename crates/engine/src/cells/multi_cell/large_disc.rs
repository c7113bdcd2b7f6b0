//! Contacts of large discs among small ones, with these and each other, by the closed form of two
//! discs, eight at a time.

use carom_detection::{DISC_LANES, Detection};
use smallvec::SmallVec;

use super::{Covering, Listed, Pending, Soonest};
use crate::{
    cells::{
        State,
        simd::{Kernel, NeighbourQuery, SoonestSlot},
    },
    scheduler::Parts,
};

impl State {
    /// Finds the earliest contact of a large disc with the small discs around it and, by the closed
    /// form, with other large discs. Returns the number of pairs tested.
    #[inline(always)]
    pub(super) fn meet_discs_around<D: Detection, K: Kernel>(
        &self,
        kernel: K,
        detection: &D,
        covering: &Covering,
        now: f64,
        except: Option<u32>,
        best: &mut Soonest,
    ) -> u64 {
        let body = covering.body;
        let query = self.question_of_covering(body, now);
        let by_form = detection.decides_discs_in_closed_form();
        let by_lists = except.is_none() && by_form;
        let is_plain = |tile: &Listed| {
            by_lists && tile.image == [0; 2] && !self.neighbour_lists.list_of(tile.who).at_border
        };
        let (mut soonest, mut asked) = (SoonestSlot::NOBODY, 0);
        for tile in covering.tiles.iter().filter(|tile| is_plain(tile)) {
            let list = self.neighbour_lists.list_of(tile.who);
            asked += list.count() as u64;
            soonest = soonest.or(match list.plain() {
                Some((slots, None)) => kernel.eight::<false>(query, slots).among(slots),
                _ => kernel.any(&query, &list),
            });
        }
        if !soonest.is_doubtful {
            self.offer_disc(body, now + soonest.time, Listed { who: soonest.slot, image: [0; 2] }, best);
        }
        let mut pairs = if soonest.is_doubtful { 0 } else { asked };
        let one_by_one = covering.tiles.iter().filter(|tile| soonest.is_doubtful || !is_plain(tile));
        let small = one_by_one.flat_map(|&tile| self.seen_from(tile));
        let large = covering.neighbours.iter().filter_map(|neighbour| {
            let other = &self.multi_cell.list[neighbour.who as usize];
            (by_form && other.is_disc_among_discs)
                .then_some(Listed { who: other.body, image: neighbour.image })
        });
        let mut others = small.chain(large).filter(|other| Some(other.who) != except);
        loop {
            let some: SmallVec<[Listed; DISC_LANES]> = others.by_ref().take(DISC_LANES).collect();
            if some.is_empty() {
                return pairs;
            }
            pairs += some.len() as u64;
            let times = detection.disc_contacts(&self.lanes::<DISC_LANES>(body, &some, now));
            for (&other, time) in some.iter().zip(times) {
                self.offer_disc(body, now + time, other, best);
            }
        }
    }

    /// Replaces `best` by a contact of a large disc if this is earlier (`time`: offset in the
    /// epoch, infinite for none).
    #[inline]
    fn offer_disc(&self, body: u32, time: f64, other: Listed, best: &mut Soonest) {
        if time < f64::INFINITY && best.is_beaten_by(time, other.who) {
            let image = self.path_image([body, other.who], other.image);
            best.take(time, other.who, Pending { parts: Parts::Discs, image });
        }
    }

    /// The query of a multi-cell body to those in the cells. Without common constants of a pair:
    /// they hold between small discs only.
    #[inline]
    pub(super) fn question_of_covering(&self, body: u32, now: f64) -> NeighbourQuery<'_> {
        NeighbourQuery { like: None, ..self.query(body, now) }
    }

    /// Tests a disc in a cell against a large disc.
    #[inline(always)]
    pub(super) fn ask_large_disc(&mut self, disc: u32, large: Listed, now: f64, best: &mut Soonest) {
        self.done.pairs += 1;
        let [time] = self.lanes::<1>(disc, &[large], now).contact_times();
        self.offer_disc(disc, now + time, large, best);
    }
}
