//! Molecules in cells: each searches its neighbours in the order of lower bounds on the contact
//! times.
//!
//! A molecule's cell is as long as two bounding circles reach. The broad phase tests eight
//! neighbours at a time, with their bounding circles and the molecule's rectangle, and excludes
//! those that it cannot touch before it leaves its cell. The remaining few are searched in the
//! order of their bounds, each up to the earliest event found so far.

use carom_detection::{Detection, QueryBody};
use carom_kinematics::Motion;
use glam::DVec2;

use super::{
    State,
    body_record::INDEX_MASK,
    candidates::Candidates,
    multi_cell::{EarliestEvent, Listed},
    neighbour_lists::image_of,
    simd::{self, Kernel},
};
use crate::World;

/// Motions of molecules in cells, which the records do not hold; empty if discs live in the cells.
#[derive(Debug, Clone, Default)]
pub(super) struct Molecules {
    /// By body. Those of multi-cell bodies are not updated.
    motions: Vec<Motion>,
    /// Scratch space: neighbours by their slots.
    candidates: Candidates<u32>,
}

impl Molecules {
    pub fn clear(&mut self) {
        self.motions.clear();
    }

    pub fn take_over(&mut self, motions: &[Motion]) {
        self.motions.extend_from_slice(motions);
    }

    pub fn heap_bytes(&self) -> usize {
        self.motions.capacity() * size_of::<Motion>()
    }

    /// The motion of a body, if the cells hold molecules.
    #[inline]
    pub fn motion(&self, body: u32) -> Option<&Motion> {
        self.motions.get(body as usize)
    }

    /// Sets the motion of a body, if the cells hold molecules.
    #[inline]
    pub fn set_motion(&mut self, body: u32, motion: &Motion) {
        if let Some(old) = self.motions.get_mut(body as usize) {
            *old = *motion;
        }
    }

    /// Sets the position and velocity of a body at a time and keeps its rotation, if the cells hold
    /// molecules.
    #[inline]
    pub fn set_flight(&mut self, body: u32, time: f64, position: DVec2, velocity: DVec2) {
        if let Some(old) = self.motions.get_mut(body as usize) {
            *old = Motion { position, velocity, ..old.at(time) };
        }
    }
}

impl State {
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
        if self.multi_cell.is_multi_cell(body) {
            simd::predict_multi_cell(self, world, detection, body, now, except);
        } else {
            simd::predict_molecule(self, world, detection, body, now, except);
        }
        self.records[body as usize].time
    }

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
        let (crossing_time, crossing) = self.crossing(query.from, now);
        let mut best = EarliestEvent::before(crossing_time, crossing);
        let covered = list.is_covered().then_some(list.cell);
        let outline = world.bodies()[body as usize].kind.molecule.outline();
        let query_body = QueryBody::new(outline, &self.molecules.motions[body as usize], now);
        list.for_each_slots8(|slots| {
            let lanes = kernel.lanes(&query, slots, list.at_border);
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
        // Lowest bound first: most candidates then need no search.
        while let Some(candidate) = candidates.take_least(|slot| slot & INDEX_MASK) {
            if !best.is_after(now, candidate.bound) || now + candidate.bound >= self.limit {
                break;
            }
            let candidate = candidate.map(|slot| Listed { index: slot & INDEX_MASK, image: image_of(slot) });
            self.search(world, detection, body, &candidate, now, &mut best);
        }
        self.molecules.candidates = candidates;
        self.store_event(body, &best);
        if let Some(cell) = covered {
            self.search_covered_cell(world, detection, body, cell, now, except);
        }
    }

    /// Wraps a molecule's motion into the box after its record, so that both agree to the bit.
    #[inline]
    pub(super) fn wrap_motion(&mut self, body: u32, axis: usize, direction: i32) {
        if let Some(motion) = self.molecules.motions.get_mut(body as usize) {
            motion.position[axis] -= f64::from(direction) * self.sides[axis];
            self.records[body as usize].set_motion(motion);
        }
    }
}
