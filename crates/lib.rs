//! Exact event-driven simulation of two-dimensional gases of rigid molecules.
//!
//! A molecule is a rigid union of discs, its *atoms*. Between contacts it flies straight and turns evenly;
//! contacts are instantaneous. Time goes from one contact to the next, so there is no time step, nothing
//! tunnels, and energy is kept to rounding.
//!
//! ```
//! use carom::{DirectionHistogram, Observer, Scene, Simulation};
//!
//! let scene = Scene::from_toml(r#"
//!     [box]
//!     seed = 42
//!
//!     [[molecule]]
//!     tags = ["tee"]
//!     shape = "tee"
//!     atom_radius = 0.01
//!     atom_mass = 2.0
//!     at = [0.5, 0.5]
//!
//!     [[gas]]
//!     tags = ["gas"]
//!     radius = 0.02
//!     mass = 1.0
//!     energy = 1.0
//!     count = 100
//! "#)?;
//! let mut simulation = Simulation::new(&scene)?;
//! let tee = simulation.view().bodies().next().expect("the scene has bodies").body.key();
//!
//! // From which side is the molecule hit, in its own frame?
//! let mut directions = DirectionHistogram::new(tee, 360);
//! directions.start(&simulation.view());
//! simulation.observe_until(2.0, &mut directions)?;
//! assert!(directions.hits() > 0);
//! assert_eq!(simulation.view().overlaps().pairs, 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The layers are crates of their own, each usable alone; this one puts them under one roof. An arrow means
//! "imports":
//!
//! | module | answers | imports |
//! | --- | --- | --- |
//! | [`geometry`] | what shapes there are | |
//! | [`kinematics`] | where a body is if nothing happens | geometry |
//! | [`detection`] | when two bodies first touch | geometry, kinematics |
//! | [`response`] | what the touch changes | geometry, kinematics |
//! | [`engine`] | in which order it all happens | all above |
//! | [`observers`] | what is measured meanwhile | all above |
//!
//! The names that most programs need stand here as well, without their layer.

pub use carom_geometry as geometry;
pub use carom_kinematics as kinematics;

pub use carom_detection as detection;
pub use carom_response as response;

pub use carom_engine as engine;
pub use carom_observers as observers;

pub use carom_detection::{BoundingCircles, Detection, Exact, FixedStep, GoldenSecant};
pub use carom_engine::{
    BodyKey, CellScheduler, CellsPerSide, Checkpoint, CollisionReport, EditError, HeapScheduler,
    Instructions, Observer, RunError, Scene, SceneError, Scheduler, Simulation, View,
};
pub use carom_geometry::{Atom, Molecule, PeriodicBox, Shape};
pub use carom_kinematics::{EpochTime, Motion, Orientation};
pub use carom_observers::{
    CollisionRate, ContactDensity, DirectionHistogram, EnergyLedger, Group, OverlapCheck, PairDistribution,
    Pressure, ProjectionHistogram, RunningAverage, Subscriptions, ThermostatLedger, TimeCorrelation,
    VelocityDistribution,
};
pub use carom_response::{Elasticity, Impact, Response};

/// Version of the whole, as the manifests of runs name it.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The examples of the README, run with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct ReadmeExamples;
