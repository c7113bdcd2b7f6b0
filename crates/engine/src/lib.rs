//! The order of events, and the only place where state changes.
//!
//! Life of one event:
//!
//! ```text
//!   scheduler ── soonest event ──► a crossing: the body enters the next cell and is predicted against it
//!                                  stale (a partner has changed since): predicted anew, or dropped by `HeapScheduler`
//!                                  a re-check: predicted anew
//!                                  a contact ──► response: impulse ──► both bodies' new motion
//!                                       │                                   │
//!                                       ▼                                   ▼
//!                                   observers                detection: first contacts with the neighbours
//! ```
//!
//! Between events nothing is touched: a body is a straight line and a constant spin since its subjective
//! time. [`Simulation`] owns everything; it is generic over the seams (detection, response, scheduler), with
//! defaults.
//!
//! ```
//! use carom_engine::{Scene, Simulation};
//!
//! let scene = Scene::from_toml(r#"
//!     [box]
//!     seed = 42
//!
//!     [[gas]]
//!     tags = ["gas"]
//!     radius = 0.02
//!     mass = 1.0
//!     energy = 1.0
//!     count = 50
//! "#)?;
//! let mut simulation = Simulation::new(&scene)?;
//! simulation.run_until(1.0)?;
//! assert!(simulation.view().counters().collisions > 50);
//! assert!((simulation.view().energy() - 50.0).abs() < 1e-12);
//! assert_eq!(simulation.view().overlaps().pairs, 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod batch;
mod body;
mod build;
mod cells;
mod centre_of_mass;
mod checkpoint;
mod counters;
mod edit;
mod elasticity_table;
mod epoch_loop;
mod error;
mod grid;
mod guard;
mod heap_scheduler;
mod invariants;
mod limits;
mod observer;
mod overlap;
mod placement;
mod report;
mod resolution;
mod sampling;
mod scene;
pub mod scheduler;
mod selection;
mod separation;
mod simulation;
mod simultaneous_contacts;
mod sites;
mod tags;
mod unresolved;
mod view;
mod wall;
mod world;
mod wrapped;

pub use batch::Batch;
pub use body::{Body, BodyKey, BodyName, Rotation, Tag, Tags};
pub use cells::{CellScheduler, Instructions};
pub use centre_of_mass::{CentreOfMassFrame, ThermalEnergy};
pub use checkpoint::{Checkpoint, CheckpointError};
pub use counters::{Counters, Ledger, SchedulerCounters};
pub use elasticity_table::ElasticityTable;
pub use error::{EditError, GridError, RunError, SceneError};
pub use grid::CellsPerSide;
pub use heap_scheduler::HeapScheduler;
pub use invariants::Violation;
pub use limits::LEAST_SPEED;
pub use observer::Observer;
pub use overlap::{OverlapCensus, rounding_bound};
pub use placement::RandomStream;
pub use report::{CollisionReport, Side};
pub use scene::{
    AtomSpec, BoxSpec, BumperSpec, ElasticityRule, ElasticitySpec, GasSpec, MoleculeSpec, RunSpec, Scene,
    WallSpec,
};
pub use scheduler::Scheduler;
pub use simulation::Simulation;
pub use tags::TagNames;
pub use view::{BodyView, View};
pub use world::World;
