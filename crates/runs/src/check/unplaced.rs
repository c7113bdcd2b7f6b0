//! What is known about a scene of so many bodies that they are not placed for a check.

use anyhow::{Context, Result};
use carom::Scene;
use carom_methods::Method;
use serde::Serialize;

use super::aligned::{bytes, table};
use crate::memory::{self, Demand};

/// Most bodies that `carom check` places: those of about 15 seconds.
const MAX_PLACED: usize = 4_000_000;

/// A scene whose bodies are not placed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Unplaced {
    scene: String,
    method: String,
    is_exact: bool,
    /// Number of bodies requested.
    bodies: usize,
    /// Most bodies that are placed.
    most_placed: usize,
    /// Least memory that they need (bytes).
    memory: u64,
    /// Memory that is available (bytes); `None` where the system does not say.
    memory_available: Option<u64>,
    /// What has this memory: the machine, or a limit.
    memory_of: Option<&'static str>,
    /// Whether `carom run` begins.
    fits: bool,
}

impl Unplaced {
    /// A scene of more than [`MAX_PLACED`] bodies; `None` if it has fewer.
    ///
    /// # Errors
    /// The box or a gas of the scene is invalid.
    pub(super) fn new(name: String, scene: &Scene, method: &Method) -> Result<Option<Self>> {
        let demand = Demand::new(scene).with_context(|| format!("scene {name}"))?;
        if demand.bodies <= MAX_PLACED {
            return Ok(None);
        }
        let available = memory::available();
        Ok(Some(Self {
            scene: name,
            method: method.to_string(),
            is_exact: method.is_exact(),
            bodies: demand.bodies,
            most_placed: MAX_PLACED,
            memory: demand.bytes,
            memory_available: available.map(|available| available.bytes),
            memory_of: available.map(|available| available.of),
            fits: demand.fits(available),
        }))
    }

    /// The lines for a terminal.
    pub(super) fn text(&self) -> String {
        let room = match (self.memory_available, self.memory_of) {
            (Some(available), Some(of)) => format!("{of} has {} available", bytes(available)),
            _ => String::new(),
        };
        let end = if self.fits {
            ""
        } else {
            "; carom run refuses it"
        };
        let rows = [
            [
                "bodies".to_owned(),
                self.bodies.to_string(),
                "walls and fixed bodies too".to_owned(),
            ],
            [
                "memory".to_owned(),
                format!("at least {}", bytes(self.memory)),
                format!("{room}{end}"),
            ],
            [
                "method".to_owned(),
                self.method.clone(),
                if self.is_exact { "" } else { "NOT EXACT" }.to_owned(),
            ],
        ];
        format!(
            "{}: its keys are valid; its bodies were not placed, because they are more than {}: collisions, time and \
             limits are unknown\n{}",
            self.scene,
            self.most_placed,
            table(rows)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_scenes_of_many_bodies_are_not_placed() {
        let of = |count: usize| {
            let text =
                format!("[[gas]]\nradius = 1e-5\nmass = 1.0\nenergy = 1.0\ncount = {count}\n");
            let scene = Scene::from_toml(&text).unwrap();
            Unplaced::new("large.toml".to_owned(), &scene, &Method::default()).unwrap()
        };
        assert_eq!(of(MAX_PLACED), None);
        let mut large = of(100_000_000).unwrap();
        (large.memory_available, large.memory_of, large.fits) =
            (Some(16_000_000_000), Some("this machine"), false);
        let text = large.text();
        assert!(
            text.contains("more than 4000000") && text.contains("100000000"),
            "{text}"
        );
        assert!(
            text.contains("at least 20 GB") && text.contains("this machine has 16 GB available"),
            "{text}"
        );
        assert!(text.contains("carom run refuses it"), "{text}");
    }
}
