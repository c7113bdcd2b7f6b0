//! Reactions that remove or replace bodies: an edit between the contact and the next event.

use carom_detection::Detection;
use carom_kinematics::{Motion, Orientation};
use carom_response::Response;
use glam::DVec2;

use crate::{
    contact::reaction_table::{
        PendingReaction, Product, ReactantFate, ReactionOutcome, is_same_mass,
    },
    edit::batch::Batch,
    run::simulation::Simulation,
    scene::{
        MoleculeSpec,
        error::{EditError, RunError, SceneError},
    },
    scheduler::Scheduler,
    world::body::{Body, Rotation},
};

impl<D: Detection, R: Response, S: Scheduler> Simulation<D, R, S> {
    /// Carries out the reaction of the last contact, with which the epoch has ended.
    ///
    /// # Errors
    /// [`RunError::Reaction`] if the system would not be valid without the two bodies, or with the
    /// product. A product without room is no error: the bodies remain.
    pub(crate) fn carry_out_reaction(&mut self) -> Result<(), RunError> {
        let Some(pending) = self.reactions.pending.take() else {
            return Ok(());
        };
        let before = self.ledger.put_in;
        let edited = self.edit(|batch| match &pending.outcome {
            ReactionOutcome::Each(fates) => batch.apply_fates(&pending, *fates),
            ReactionOutcome::Product(product) => batch.replace_pair(&pending, product),
        });
        let (change, time) = (self.ledger.put_in - before, self.time());
        let record = &mut self.reactions.records[pending.record];
        match edited {
            Ok(()) => {
                record.counts.reactions += 1;
                record.counts.energy += change;
                self.counters.reactions += 1;
                Ok(())
            }
            Err(EditError::Scene(SceneError::Overlap { .. })) => {
                record.counts.blocked += 1;
                Ok(())
            }
            Err(reason) => Err(RunError::Reaction {
                time,
                reaction: record.spec.equation(),
                reason: Box::new(reason),
            }),
        }
    }
}

impl Batch {
    /// Removes each of two bodies, or replaces its tag.
    fn apply_fates(
        &mut self,
        pending: &PendingReaction,
        fates: [ReactantFate; 2],
    ) -> Result<(), EditError> {
        for ((key, from), fate) in pending.bodies.into_iter().zip(pending.tags).zip(fates) {
            match fate {
                ReactantFate::Nothing => self.remove(key)?,
                ReactantFate::Tag(to) => self.replace_tag(key, from, to)?,
            }
        }
        Ok(())
    }

    /// Replaces two bodies by a molecule with their centre of mass, momentum and angular momentum.
    fn replace_pair(
        &mut self,
        pending: &PendingReaction,
        product: &Product,
    ) -> Result<(), EditError> {
        self.start_to_move();
        let [a, b] = [
            self.index(pending.bodies[0])?,
            self.index(pending.bodies[1])?,
        ];
        let bodies = [a, b].map(|index| &self.world.bodies[index]);
        let motions = [a, b].map(|index| self.world.motions[index]);
        let masses = bodies.map(Body::mass);
        if !is_same_mass(product.mass, masses[0] + masses[1]) {
            let problem = format!(
                "the mass of `into` must be that of the two bodies which it replaces, {}, but is {}",
                masses[0] + masses[1],
                product.mass
            );
            return Err(SceneError::of_entry("reaction", problem).into());
        }
        let spin = angular_momentum(bodies, motions, masses, pending.separation);
        let spec = placed(product, motions, masses, pending.separation);
        for key in pending.bodies {
            self.remove(key)?;
        }
        let key = self.add(&spec)?;
        let index = self.index(key)?;
        let turns =
            spec.rotation == Rotation::Free && !self.world.bodies[index].molecule().is_disc();
        if turns {
            let moment = self.world.bodies[index].inertia().inverse_moment;
            self.set_angular_velocity(key, spin * moment)?;
        }
        Ok(())
    }
}

/// The angular momentum of two bodies about their common centre of mass (mass × length² / time).
fn angular_momentum(
    bodies: [&Body; 2],
    [a, b]: [Motion; 2],
    masses: [f64; 2],
    separation: DVec2,
) -> f64 {
    let reduced = masses[0] * masses[1] / (masses[0] + masses[1]);
    let own = |body: &Body, motion: &Motion| {
        if body.is_locked() {
            0.0
        } else {
            motion.angular_velocity / body.inertia().inverse_moment
        }
    };
    reduced * separation.perp_dot(b.velocity - a.velocity) + own(bodies[0], &a) + own(bodies[1], &b)
}

/// The product at the centre of mass of two bodies, with their momentum and turned to the line of
/// their centres.
fn placed(
    product: &Product,
    [a, b]: [Motion; 2],
    masses: [f64; 2],
    separation: DVec2,
) -> MoleculeSpec {
    let share = masses[1] / (masses[0] + masses[1]);
    let along = Orientation::from_radians(libm::atan2(separation.y, separation.x)).turns();
    let spec = &product.spec;
    let own = spec.orientation_turns.unwrap_or_else(|| {
        spec.orientation
            .map_or(0.0, |radians| Orientation::from_radians(radians).turns())
    });
    let momentum = masses[0] * a.velocity + masses[1] * b.velocity;
    MoleculeSpec {
        at: (a.position + share * separation).to_array(),
        velocity: (momentum / product.mass).to_array(),
        orientation: None,
        orientation_turns: Some(along + own),
        ..spec.clone()
    }
}
