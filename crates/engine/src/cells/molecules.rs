//! Molecules that live in cells, as small discs do: each asks those around it, nearest in time first.
//!
//! A molecule's cell is as long as the bounding circles of two of them reach. Which of its neighbours it may meet before it
//! leaves its cell is told for eight at a time, by their bounding circles and its own rectangle; these few are searched in the
//! order of the bounds so found, each up to the soonest event so far.

use carom_detection::{Detection, QueryBody};
use carom_kinematics::Motion;
use glam::DVec2;

use super::{
    State,
    body_record::INDEX_MASK,
    candidates::Candidates,
    multi_cell::{Listed, Soonest},
    neighbour_lists::image_of,
    simd::{self, Kernel},
};
use crate::World;

/// What the records of molecules do not hold; empty where discs live in the cells.
#[derive(Debug, Clone, Default)]
pub(super) struct Molecules {
    /// By body. Those of covering bodies are not kept up.
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

    /// Takes over the new motion of a body, if the cells hold molecules.
    #[inline]
    pub fn set_motion(&mut self, body: u32, motion: &Motion) {
        if let Some(old) = self.motions.get_mut(body as usize) {
            *old = *motion;
        }
    }

    /// Takes over the new flight of a body whose orientation and spin stay as they are, if the cells hold molecules.
    #[inline]
    pub fn set_flight(&mut self, body: u32, time: f64, position: DVec2, velocity: DVec2) {
        if let Some(old) = self.motions.get_mut(body as usize) {
            *old = Motion { position, velocity, ..old.at(time) };
        }
    }
}

impl State {
    /// Of two bodies that have just met, the one that need not ask for the other, and the other, which asks afterwards.
    ///
    /// Asking a disc in a cell in lanes costs nothing; of two others it is decided by their motions, so that it does not
    /// depend on the order of insertion.
    pub(super) fn skip_partner(&self, [a, b]: [u32; 2]) -> Option<[u32; 2]> {
        if self.multi_cell.is_fixed(a) | self.multi_cell.is_fixed(b) {
            return None;
        }
        let searches = |body| self.grid.holds_molecules() | self.multi_cell.is_covering(body);
        // The same for mirror images of a system.
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

    /// Finds the soonest event of a body that searches among its candidates, and tells when it is; `except` is one that
    /// it need not ask for.
    #[inline(never)]
    pub(super) fn predict_searching<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        body: u32,
        now: f64,
        except: Option<u32>,
    ) -> f64 {
        if self.multi_cell.is_covering(body) {
            simd::predict_multi_cell(self, world, detection, body, now, except);
        } else {
            simd::predict_molecule(self, world, detection, body, now, except);
        }
        self.records[body as usize].time
    }

    /// Finds the soonest event of a molecule that lives in a cell: a contact, a re-check, or the next cell.
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
        let mut best = Soonest::before(crossing_time, crossing);
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
        // The soonest bound first: most need not be searched.
        while let Some(candidate) = candidates.take_least(|slot| slot & INDEX_MASK) {
            if !best.is_after(now, candidate.bound) || now + candidate.bound >= self.limit {
                break;
            }
            let candidate = candidate.map(|slot| Listed { who: slot & INDEX_MASK, image: image_of(slot) });
            self.search(world, detection, body, &candidate, now, &mut best);
        }
        self.molecules.candidates = candidates;
        self.store_event(body, &best);
        if let Some(cell) = covered {
            self.meet_coverings(world, detection, body, cell, now, except);
        }
    }

    /// Brings a molecule's motion back into the box where its record has been, and makes both agree to the bit.
    #[inline]
    pub(super) fn wrap_motion(&mut self, body: u32, axis: usize, direction: i32) {
        if let Some(motion) = self.molecules.motions.get_mut(body as usize) {
            motion.position[axis] -= f64::from(direction) * self.sides[axis];
            self.records[body as usize].set_motion(motion);
        }
    }
}
