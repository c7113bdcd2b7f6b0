//! How a simulation computes: detector and scheduler, chosen at run time.
//!
//! Unstable: its public items may change with any version.
//!
//! [`Simulation`](carom_engine::Simulation) chooses them at compile time, so each combination is
//! compiled anew where it is used. [`AnySimulation`] is compiled here once for all combinations
//! that a [`Method`] describes. A call of one of its methods is dynamic; the loop over the events
//! inside is the same code, and runs at the same speed.
//!
//! ```
//! use carom_engine::Scene;
//! use carom_methods::{AnySimulation, Method};
//!
//! let scene = Scene::from_toml(r#"
//!     [[gas]]
//!     radius = 0.02
//!     mass = 1.0
//!     energy = 1.0
//!     count = 50
//!
//!     [method]
//!     detector = "golden-secant"
//!     tolerance = 1e-9
//! "#)?;
//! assert!(!Method::try_from(&scene.method)?.is_exact());
//! let mut simulation = AnySimulation::new(&scene)?;
//! simulation.run_until(1.0)?;
//! assert!(simulation.view().counters().collisions > 10);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod any_detector;
mod any_simulation;
mod method;

pub use any_detector::AnyDetector;
pub use any_simulation::AnySimulation;
pub use method::{Method, MethodError, Order};
