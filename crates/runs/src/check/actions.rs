//! The cost of the actions of thermostats.

use anyhow::Result;
use carom::Scene;
use carom_methods::AnySimulation;
use serde::Serialize;

use crate::clock::ProcessTime;
use crate::schedule::{What, stage_edits, stages};

/// The cost of the actions of all thermostats.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub(super) struct Actions {
    pub(super) count: u64,
    /// Number of motions set, if the tags keep their bodies.
    pub(super) motions: u64,
    /// Processor time (seconds), including the prediction of all bodies after each action.
    pub(super) seconds: f64,
}

impl Actions {
    /// Measures one action of each thermostat on a copy; `None` without thermostats.
    ///
    /// # Errors
    /// An action is refused, or the run fails after it.
    pub(super) fn new(simulation: &AnySimulation, scene: &Scene) -> Result<Option<Self>> {
        let mut all = Self::default();
        for (stage, counts) in stages::action_counts(scene).iter().enumerate() {
            for (index, &count) in counts.iter().enumerate() {
                let mut copy = simulation.clone();
                let tag = copy.find_tag(&scene.stage[stage].thermostat[index].tag);
                let members = tag.map_or(0, |tag| copy.view().tagged(tag).count());
                let clock = ProcessTime::now();
                stage_edits::change(&mut copy, scene, What::Thermostat { stage, index }, 0)?;
                copy.run_until(copy.time().to_f64())?;
                all.seconds += count as f64 * clock.elapsed().as_secs_f64();
                all.count += count;
                all.motions += count * members as u64;
            }
        }
        Ok((all.count > 0).then_some(all))
    }
}
