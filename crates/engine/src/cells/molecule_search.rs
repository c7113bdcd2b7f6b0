//! Molecules in cells: each searches its neighbours in the order of lower bounds on the contact
//! times.
//!
//! A molecule's cell is as long as two bounding circles reach. The broad phase tests eight
//! neighbours at a time, with their bounding circles and the molecule's rectangle, and excludes
//! those that it cannot touch before it leaves its cell. The remaining few are searched in the
//! order of their bounds, each up to the earliest event found so far.

use carom_detection::{DISC_LANES, Detection, DiscLanes, QueryBody};

use super::{
    dispatch::dispatched,
    frame::CellFrame,
    multi_cell::{EarliestEvent, Listed},
    simd::Kernel,
    slot::{INDEX_MASK, image_of},
    state::CellState,
};
use crate::world::World;

dispatched!(predict_molecule(body: u32, now: f64, except: Option<u32>));

impl<F: CellFrame> CellState<F> {
    /// Finds the earliest event of a molecule in a cell: a contact, a re-check, or a crossing.
    #[inline(always)]
    pub(super) fn predict_molecule<D: Detection, K: Kernel>(
        &mut self,
        kernel: K,
        world: &World,
        detection: &D,
        body: u32,
        now: f64,
        except: Option<u32>,
    ) {
        let mut candidates = std::mem::take(&mut self.molecules.candidates);
        candidates.clear();
        let query = self.query(body, now);
        let list = self.neighbour_lists.list(query.from.cell());
        let (crossing_time, crossing) = self.crossing_in_any_cells(body, now);
        let slides = self.seam.is_some() && list.at_border;
        let mut best = EarliestEvent::before(crossing_time, crossing);
        let covered = list.is_covered().then_some(list.cell);
        let outline = self.molecule(world, body).outline();
        let query_body = QueryBody::new(outline, &self.molecules.motions[body as usize], now);
        list.for_each_slots8(|slots| {
            let lanes = if slides {
                self.lanes_of_slots(body, slots, now)
            } else {
                kernel.lanes(&query, slots, list.at_border)
            };
            let times = detection.contact_time_lower_bounds(&query_body, &lanes, best.time - now);
            candidates.sift(
                times,
                |bound| best.is_after(now, bound),
                |lane| {
                    let other = slots[lane] & INDEX_MASK;
                    ((other != body) & (Some(other) != except)).then_some(slots[lane])
                },
            );
        });
        if world.pairs.is_active() {
            candidates.retain(|slot| self.pair_factor(world, [body, slot & INDEX_MASK]) > 0.0);
        }
        // Lowest bound first: most candidates then need no search.
        while let Some(candidate) = candidates.take_least(|slot| slot & INDEX_MASK) {
            if !best.is_after(now, candidate.bound) || now + candidate.bound >= self.limit {
                break;
            }
            let candidate = candidate.map(|slot| Listed {
                index: slot & INDEX_MASK,
                image: image_of(slot),
            });
            self.search(world, detection, body, &candidate, now, &mut best);
        }
        self.molecules.candidates = candidates;
        self.store_event(body, &best);
        if let Some(cell) = covered {
            self.search_covered_cell(world, detection, body, cell, now, except);
        }
    }

    /// The bodies in slots as seen from one, through sides of the box that may slide.
    #[cold]
    fn lanes_of_slots(&self, body: u32, slots: &[u32; DISC_LANES], now: f64) -> DiscLanes {
        let listed = slots.map(|slot| Listed {
            index: slot & INDEX_MASK,
            image: image_of(slot),
        });
        self.lanes(body, &listed, now)
    }
}
