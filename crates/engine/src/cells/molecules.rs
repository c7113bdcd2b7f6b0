//! Molecules that live in cells, as small discs do: each asks those around it, nearest in time first.
//!
//! A molecule's cell is as long as the bounding circles of two of them reach. Which of its neighbours it may meet before it
//! leaves its cell is told for eight at a time, by their bounding circles and its own rectangle; these few are searched in the
//! order of the bounds so found, each up to the soonest event so far.

use carom_detection::{Asker, Detection};
use carom_kinematics::Motion;
use glam::DVec2;

use super::{
    State,
    candidates::Candidates,
    covering::{Listed, Soonest},
    line::INDEX_MASK,
    neighbourhood::image_of,
    vector::{self, Kernel},
};
use crate::World;

/// What the lines of molecules do not hold; empty where discs live in the cells.
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
    pub(super) fn excused(&self, [a, b]: [u32; 2]) -> Option<[u32; 2]> {
        if self.coverings.is_fixed(a) | self.coverings.is_fixed(b) {
            return None;
        }
        let searches = |body| self.grid.holds_molecules() | self.coverings.is_covering(body);
        // The same for mirror images of a system.
        let speed_squared = |body: u32| self.lines[body as usize].velocity().length_squared();
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
    pub(super) fn foresee_searching<D: Detection>(
        &mut self,
        world: &World,
        detection: &D,
        body: u32,
        now: f64,
        except: Option<u32>,
    ) -> f64 {
        if self.coverings.is_covering(body) {
            vector::foresee_covering(self, world, detection, body, now, except);
        } else {
            vector::foresee_molecule(self, world, detection, body, now, except);
        }
        self.lines[body as usize].time
    }

    /// Finds the soonest event of a molecule that lives in a cell: a contact, a re-check, or the next cell.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled anew for each set of instructions")]
    pub(super) fn foresee_molecule<D: Detection, K: Kernel>(
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
        let question = self.question(body, now);
        let list = self.neighbourhoods.list(question.from.cell());
        let (crossing_time, crossing) = self.crossing(question.from, now);
        let mut best = Soonest::before(crossing_time, crossing);
        let covered = list.is_covered().then_some(list.cell);
        let outline = world.bodies()[body as usize].kind.molecule.outline();
        let asker = Asker::new(outline, &self.molecules.motions[body as usize], now);
        list.for_each_eight(|slots| {
            let lanes = kernel.lanes(&question, slots, list.at_border);
            let times = detection.apart_until(&asker, &lanes, best.time - now);
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
        self.settle(body, &best);
        if let Some(cell) = covered {
            self.meet_coverings(world, detection, body, cell, now, except);
        }
    }

    /// Brings a molecule's motion back into the box where its line has been, and makes both agree to the bit.
    #[inline]
    pub(super) fn wrap_motion(&mut self, body: u32, axis: usize, direction: i32) {
        if let Some(motion) = self.molecules.motions.get_mut(body as usize) {
            motion.position[axis] -= f64::from(direction) * self.sides[axis];
            self.lines[body as usize].set_motion(motion);
        }
    }
}
