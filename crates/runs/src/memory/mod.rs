//! Memory that the bodies of a scene need, and that which is available.

#[cfg(not(target_arch = "wasm32"))]
mod available;
#[cfg(target_arch = "wasm32")]
mod of_module;

#[cfg(not(target_arch = "wasm32"))]
pub use available::available;
#[cfg(target_arch = "wasm32")]
pub use of_module::available;

use anyhow::{Result, bail};
use carom::Scene;

/// Bytes of a body with its events: 209 to 234 for each of 10⁵ to 10⁶ equal discs in the default
/// scheduler, and more for molecules, for drawn sizes, and as a run begins. Smaller: scenes that
/// cannot fit are begun. Larger: scenes that fit are refused.
const BYTES_PER_BODY: u64 = 200;

/// Memory that is available, and what limits it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AvailableMemory {
    /// Memory that can still be taken (bytes).
    pub bytes: u64,
    /// What has this memory, for messages.
    pub of: &'static str,
}

/// What the bodies of a scene need.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Demand {
    /// Number of bodies.
    pub bodies: usize,
    /// The least memory that they need (bytes).
    pub bytes: u64,
}

impl Demand {
    /// The demand of a scene, without placing its bodies.
    ///
    /// # Errors
    /// The scene is invalid.
    pub fn new(scene: &Scene) -> Result<Self> {
        let bodies = scene.expected_bodies()?;
        Ok(Self {
            bodies,
            bytes: BYTES_PER_BODY.saturating_mul(bodies as u64),
        })
    }

    /// Whether the bodies fit into this memory, as far as that is known.
    pub fn fits(&self, available: Option<AvailableMemory>) -> bool {
        available.is_none_or(|available| self.bytes <= available.bytes)
    }

    /// Refuses bodies that do not fit into this memory.
    ///
    /// # Errors
    /// They do not fit; the message has their number and both memories.
    pub fn refuse_unless_fits(&self, available: Option<AvailableMemory>) -> Result<()> {
        let Self { bodies, bytes } = self;
        let Some(limit) = available.filter(|_| !self.fits(available)) else {
            return Ok(());
        };
        bail!(
            "its {bodies} bodies need at least {bytes} bytes of memory ({}), but {} has {} available: take fewer bodies",
            gigabytes(*bytes),
            limit.of,
            gigabytes(limit.bytes)
        );
    }
}

/// Refuses series of measures that do not fit into this memory at the end of a run.
///
/// # Errors
/// They do not fit; the message has both memories.
pub fn refuse_long_series(bytes: u64, available: Option<AvailableMemory>) -> Result<()> {
    let Some(limit) = available.filter(|available| bytes > available.bytes) else {
        return Ok(());
    };
    bail!(
        "the samples of its measures need at least {bytes} bytes of memory ({}) at the end of the run, but {} has {} \
         available: take a larger `run.sample_interval`",
        gigabytes(bytes),
        limit.of,
        gigabytes(limit.bytes)
    );
}

fn gigabytes(bytes: u64) -> String {
    format!("{:.3} GB", bytes as f64 / 1e9)
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_methods::AnySimulation;

    fn gas(count: usize) -> Scene {
        let text = format!("[[gas]]\nradius = 1e-4\nmass = 1.0\nenergy = 1.0\ncount = {count}\n");
        Scene::from_toml(&text).unwrap()
    }

    #[test]
    fn bodies_that_do_not_fit_are_refused_with_their_number() {
        let demand = Demand::new(&gas(100_000_000)).unwrap();
        assert_eq!((demand.bodies, demand.bytes), (100_000_000, 20_000_000_000));
        let machine = |bytes: u64| {
            Some(AvailableMemory {
                bytes,
                of: "this machine",
            })
        };
        assert!(demand.refuse_unless_fits(machine(20_000_000_000)).is_ok());
        assert!(demand.refuse_unless_fits(None).is_ok());
        let said = demand
            .refuse_unless_fits(machine(16_000_000_000))
            .unwrap_err()
            .to_string();
        let expected = "its 100000000 bodies need at least 20000000000 bytes of memory (20.000 GB), but this machine \
                        has 16.000 GB available";
        assert!(said.starts_with(expected), "{said}");
    }

    #[test]
    fn series_that_do_not_fit_are_refused() {
        let machine = |bytes: u64| {
            Some(AvailableMemory {
                bytes,
                of: "this machine",
            })
        };
        assert!(refuse_long_series(1000, machine(1000)).is_ok());
        assert!(refuse_long_series(u64::MAX, None).is_ok());
        let said = refuse_long_series(2_000_000_000, machine(1_500_000_000))
            .unwrap_err()
            .to_string();
        assert!(
            said.contains("(2.000 GB) at the end of the run, but this machine has 1.500 GB"),
            "{said}"
        );
    }

    /// What is refused must not be more than a simulation takes.
    #[test]
    fn the_demand_is_below_the_memory_of_a_simulation() {
        let scene = gas(100_000);
        let mut simulation = AnySimulation::new(&scene).unwrap();
        simulation.step(1e-6, &mut ()).unwrap();
        let (demand, heap) = (
            Demand::new(&scene).unwrap().bytes as f64,
            simulation.heap_bytes() as f64,
        );
        assert!((0.7..1.0).contains(&(demand / heap)), "{demand} {heap}");
    }
}
