//! The motions of molecules, and of discs with spins, in cells: the records do not hold them.

use carom_kinematics::Motion;
use glam::DVec2;

use super::candidates::Candidates;

/// Motions of bodies in cells, which the records do not hold; empty if discs without spins live in
/// the cells.
#[derive(Debug, Clone, Default)]
pub(super) struct Molecules {
    /// By body. Those of multi-cell bodies are not updated.
    pub(super) motions: Vec<Motion>,
    /// Scratch space: neighbours by their slots.
    pub(super) candidates: Candidates<u32>,
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
            *old = Motion {
                position,
                velocity,
                ..old.at(time)
            };
        }
    }
}
