//! Large discs among small ones, whom they meet as these meet each other: by the closed form, eight at a time.

use carom_detection::{DISC_LANES, Detection, disc_contact};
use smallvec::SmallVec;

use super::{Covering, Listed, Pending, Soonest};
use crate::{
    Parts, World,
    cells::{
        State,
        vector::{Kernel, Question},
    },
};

impl State {
    /// Looks for a large disc's contacts with the discs around it, and tells how many they are.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled anew for each set of instructions")]
    pub(super) fn meet_small_discs<D: Detection, K: Kernel>(
        &self,
        detection: &D,
        covering: &Covering,
        now: f64,
        except: Option<u32>,
        best: &mut Soonest,
    ) -> u64 {
        let body = covering.body;
        let question = self.question_of_covering(body, now);
        let by_lists = except.is_none() && detection.decides_discs_in_closed_form();
        let mut pairs = 0;
        for &tile in &covering.tiles {
            let list = self.neighbourhoods.list_of(tile.who);
            if by_lists && tile.image == [0; 2] && !list.at_border {
                let soonest = match list.plain() {
                    Some((slots, None)) => K::eight::<false>(question, slots).among(slots),
                    _ => K::any(&question, &list),
                };
                if !soonest.is_doubtful {
                    pairs += list.count() as u64;
                    let other = Listed { who: soonest.slot, image: [0; 2] };
                    self.offer_disc(body, now + soonest.time, other, best);
                    continue;
                }
            }
            let mut seen = self.seen_from(tile).filter(|other| Some(other.who) != except);
            loop {
                let some: SmallVec<[Listed; DISC_LANES]> = seen.by_ref().take(DISC_LANES).collect();
                if some.is_empty() {
                    break;
                }
                pairs += some.len() as u64;
                let times = detection.disc_contacts(&self.lanes::<DISC_LANES>(body, &some, now));
                for (&other, time) in some.iter().zip(times) {
                    self.offer_disc(body, now + time, other, best);
                }
            }
        }
        pairs
    }

    /// Takes a contact of a large and a small disc if it is sooner (time in the epoch, infinite for none).
    #[inline]
    pub(super) fn offer_disc(&self, body: u32, time: f64, other: Listed, best: &mut Soonest) {
        if time < f64::INFINITY {
            let image = self.path_image([body, other.who], other.image);
            best.offer(time, other.who, Pending { parts: Parts::Discs, image });
        }
    }

    /// What a covering body asks of those in the cells, which may be alike, but not like it.
    #[inline]
    pub(super) fn question_of_covering(&self, body: u32, now: f64) -> Question<'_> {
        Question { like: None, ..self.question(body, now) }
    }

    /// When a disc in a cell meets a large one (time in the epoch), infinite for never.
    pub(super) fn contact_with_large_disc(
        &self,
        world: &World,
        disc: u32,
        large: &Covering,
        image: [i32; 2],
        now: f64,
    ) -> f64 {
        let relative = self.relative_motion(world, [disc, large.body], image, now);
        let sigma = self.lines[disc as usize].radius + large.radius;
        let errors = (relative.separation_error, relative.velocity_error);
        now + disc_contact(relative.separation, relative.velocity, sigma, errors)
    }
}
