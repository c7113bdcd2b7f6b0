//! Exact event-driven simulation of two-dimensional gases of rigid molecules.
//!
//! Stable: its public items follow the policy of versions in the book (*Versions and releases*).
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
//! // The directions of the impulses on the molecule, in its own frame.
//! let mut directions = DirectionHistogram::new(tee, 360);
//! directions.start(&simulation.view());
//! simulation.observe_until(2.0, &mut directions)?;
//! assert!(directions.hits() > 0);
//! assert_eq!(simulation.view().overlaps().pairs, 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A molecule is a rigid union of discs, its *atoms*. Between contacts it moves with constant
//! velocity and angular velocity; contacts are instantaneous. The simulation advances from contact
//! to contact, so there is no time step, no tunnelling, and energy is conserved to rounding.
//!
//! Each layer is a separate crate that can be used alone; this crate re-exports them as modules:
//!
//! | module | contents | imports |
//! | --- | --- | --- |
//! | [`geometry`] | shapes: molecules, walls, the periodic box | |
//! | [`kinematics`] | free flight of a body | geometry |
//! | [`detection`] | the time of the first contact of two bodies | geometry, kinematics |
//! | [`response`] | the change of motion at a contact | geometry, kinematics |
//! | [`engine`] | scenes and the event-driven simulation | all above |
//! | [`observers`] | measurements during a run | all above |
//!
//! The most common names are also available at the top level.

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
    BodyFrameDiffusion, BondOrderCorrelation, BondOrderRelaxation, CollisionRate, ContactDensity,
    CurrentCorrelation, DirectionHistogram, Disclinations, DistinctVanHove, EnergyLedger,
    FreePaths, Group, HelfandMoment, HexaticOrder, IntermediateScattering, OrientationCorrelation,
    OrientationalOrder, OverlapCheck, PairDistribution, Pressure, PressureTensor,
    ProjectionHistogram, RunningAverage, SelfVanHove, StructuralRelaxation, StructureFactor,
    StructureFactorMap, Subscriptions, TemperatureByTag, ThermostatLedger, TimeCorrelation,
    VelocityDistribution,
};
pub use carom_response::{Elasticity, Impact, Response};

/// Version of the workspace, as recorded in the manifests of runs.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The examples of the README and of the book, as doctests.
#[cfg(doctest)]
mod listings {
    #[doc = include_str!("../README.md")]
    pub struct Readme;

    #[doc = include_str!("book/src/rust.md")]
    pub struct Rust;

    #[doc = include_str!("book/src/own.md")]
    pub struct Own;
}
