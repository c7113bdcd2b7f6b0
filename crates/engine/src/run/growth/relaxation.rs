//! The relaxation after growth: the molecules, of full size, move with the velocities and masses of
//! the scene, until their positions are those of an equilibrium.

use std::sync::Arc;

use carom_kinematics::{kinetic_energy, momentum};
use glam::{BVec2, DVec2};

use super::{Growth, Stage};
use crate::{
    scene::{error::SceneError, random::RandomStream},
    start::{species::Species, velocities::ConservedMomentum},
    world::{World, body::BodyKind, centre_of_mass::conserved_momentum},
};

/// Collisions a molecule in one step of the relaxation. Fewer: predictions are begun anew too
/// often. More: the caller waits longer for each step.
const RELAXATION_PER_STEP: f64 = 20.0;

/// Collisions a molecule of the relaxation after growth, unless the scene has a number. The
/// pressure of states of most shapes then changes by a few per cent at most.
pub(super) const RELAXATION_AFTER_GROWTH: f64 = 1000.0;

impl Growth {
    /// Gives the molecules the mass and the velocities of the scene.
    ///
    /// # Errors
    /// [`SceneError`] with the name of the entry if a molecule is too fast or too slow.
    pub(super) fn draw_velocities(&mut self) -> Result<(), SceneError> {
        let first = self.contents.singles.world.bodies.len();
        let conserved =
            ConservedMomentum::new(&self.contents.singles.world, &self.contents.species);
        let bounds = &self.scene.bounds;
        let mut random = RandomStream::Velocities.generator(bounds.seed, bounds.replica);
        let World {
            bodies, motions, ..
        } = &mut self.world;
        let mut rest = bodies[first..].iter_mut().zip(&mut motions[first..]);
        for kind in &self.contents.species {
            let velocities = kind.velocities(&conserved, &mut random)?;
            let mut last: Option<Arc<BodyKind>> = None;
            for (index, ((velocity, spin), (body, motion))) in
                velocities.zip(rest.by_ref()).enumerate()
            {
                body.kind = match last.take() {
                    Some(shared) if kind.is_equal() => shared,
                    _ => Arc::new(real_kind(kind, index)),
                };
                last = Some(Arc::clone(&body.kind));
                (motion.velocity, motion.angular_velocity) = (velocity, spin);
            }
        }
        Ok(())
    }

    /// Begins the relaxation, of this length unless the scene has another.
    pub(super) fn start_relaxation(&mut self, default: f64) {
        let all = self.scene.start.relax.unwrap_or(default);
        let (energy, momentum, _) = self.totals();
        self.state.stage = if all > 0.0 && energy > 0.0 {
            Stage::Relaxing {
                done: 0.0,
                all,
                energy,
                momentum,
            }
        } else {
            Stage::Done
        };
    }

    pub(super) fn relax(&mut self) -> Result<(), SceneError> {
        let Stage::Relaxing {
            done,
            all,
            energy,
            momentum,
        } = self.state.stage
        else {
            return Ok(());
        };
        let part = RELAXATION_PER_STEP.min(all - done);
        self.run(part)?;
        let done = done + part;
        self.state.stage = if done < all {
            Stage::Relaxing {
                done,
                all,
                energy,
                momentum,
            }
        } else {
            self.restore_totals(energy, momentum);
            Stage::Done
        };
        Ok(())
    }

    /// Energy, momentum and mass of the gases.
    fn totals(&self) -> (f64, DVec2, f64) {
        let first = self.contents.singles.world.bodies.len();
        let gases = || {
            self.world.bodies[first..]
                .iter()
                .zip(&self.world.motions[first..])
        };
        (
            gases()
                .map(|(body, motion)| kinetic_energy(motion, &body.kind.inertia))
                .sum(),
            gases()
                .map(|(body, motion)| momentum(motion, &body.kind.inertia))
                .sum(),
            gases()
                .map(|(body, _)| 1.0 / body.kind.inertia.inverse_mass)
                .sum(),
        )
    }

    /// The axes along which the scene conserves momentum.
    fn conserved(&self) -> BVec2 {
        conserved_momentum(&self.contents.singles.world)
    }

    /// Gives the gases this energy, and this momentum along each axis on which the scene conserves
    /// it. The relaxation changes the momentum if it holds a molecule that is free in the scene.
    fn restore_totals(&mut self, energy: f64, momentum: DVec2) {
        let (now, moving, mass) = self.totals();
        let only_conserved = |momentum| DVec2::select(self.conserved(), momentum, DVec2::ZERO);
        let (drift, requested) = (
            only_conserved(moving) / mass,
            only_conserved(momentum) / mass,
        );
        let internal = |energy: f64, drift: DVec2| energy - 0.5 * mass * drift.length_squared();
        let factor = (internal(energy, requested) / internal(now, drift)).sqrt();
        // A gas that moves as a whole has no internal energy.
        let factor = if factor.is_finite() { factor } else { 1.0 };
        let first = self.contents.singles.world.bodies.len();
        for motion in &mut self.world.motions[first..] {
            motion.velocity = factor * (motion.velocity - drift) + requested;
            motion.angular_velocity *= factor;
        }
    }
}

/// A molecule of a gas as in the scene, but without tags, unless rules for pairs read them.
pub(super) fn real_kind(kind: &Species, index: usize) -> BodyKind {
    let molecule = Arc::clone(kind.molecule(index));
    BodyKind {
        molecule,
        inertia: kind.inertia(index),
        tags: kind.pair_tags.clone(),
        tag_class: 0,
        has_rough_contacts: false,
        temperature: None,
    }
}
