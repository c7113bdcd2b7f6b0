//! One way to compute a scene: detector and scheduler, length of epochs, rotation, and samples.

use anyhow::Result;
use carom::{Checkpoint, engine::Rotation};
use carom_methods::{AnySimulation, Method};

/// A way to compute a scene. The default is that of an exact run.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Setting {
    /// Detector and scheduler.
    pub method: Method,
    /// Contacts of each body in an epoch, instead of the scheduler's own number.
    pub contacts_per_epoch: Option<u64>,
    /// Whether all rotation is locked: another model, whose results differ.
    pub locked: bool,
    /// Time between samples of nothing, in mean times between two collisions of a body; `None` for
    /// no samples. Samples cost time and change no bit of a run.
    pub sample_interval: Option<f64>,
}

impl From<Method> for Setting {
    fn from(method: Method) -> Self {
        Self {
            method,
            ..Self::default()
        }
    }
}

impl Setting {
    /// Returns true if no contact may be wrong: the certified detector, a safe grid, and free
    /// rotation.
    pub fn is_exact(&self) -> bool {
        self.method.is_exact() && !self.locked
    }

    /// The simulation with this setting from a state on.
    ///
    /// # Errors
    /// The bodies do not suit the setting.
    pub fn resume(&self, state: &Checkpoint) -> Result<AnySimulation> {
        let mut simulation = AnySimulation::resume(state, &self.method)?;
        if let Some(contacts) = self.contacts_per_epoch {
            simulation.set_contacts_per_epoch(contacts);
        }
        if self.locked {
            let view = simulation.view();
            let moving = view.bodies().filter(|view| view.body.is_free());
            let keys: Vec<_> = moving.map(|view| view.body.key()).collect();
            simulation.edit(|batch| {
                keys.iter()
                    .try_for_each(|&key| batch.set_rotation(key, Rotation::Locked))
            })?;
        }
        Ok(simulation)
    }
}
