//! Event-driven simulation of rigid molecules: the event loop, and the only code that changes the
//! state.
//!
//! Life of one event:
//!
//! ```text
//! scheduler ── earliest event ─┬─► a crossing: the body enters the next cell; contacts with the
//!                              │     bodies there are predicted
//!                              ├─► stale (the partner has changed): predicted anew, or dropped by
//!                              │     `HeapScheduler`
//!                              ├─► a re-check: predicted anew
//!                              └─► a contact ──► response: impulse ──► new motion of both bodies
//!                                       │                                    │
//!                                       ▼                                    ▼
//!                                   observers          detection: first contacts with neighbours
//! ```
//!
//! Between events a body moves with constant velocity and angular velocity from its subjective
//! time, the time at which its motion last changed; its stored motion does not change.
//! [`Simulation`] owns the whole state. It is generic over detection, response and scheduler, with
//! defaults for all three.
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

mod atom_spec;
mod batch;
mod body;
mod body_builder;
mod build;
mod cells;
mod centre_of_mass;
mod checkpoint;
mod coincident_walls;
mod contact_event;
mod contact_geometry;
mod contents;
mod counters;
mod distribution;
mod drawn_molecules;
mod edit;
mod elasticity_table;
mod epoch_loop;
mod error;
mod expected_bodies;
mod expressions;
mod fitted_box;
mod gas_spec;
mod grid;
mod growth;
mod guard;
mod heap_scheduler;
mod heat;
mod index_or_none;
mod invariants;
mod joint_contact;
mod least_speed;
mod limits;
mod max_time;
mod measure_from;
mod measure_spec;
mod method_spec;
mod observer;
mod overlap;
mod philox;
mod placement;
mod pockets;
mod random;
mod region;
mod report;
mod resolution;
mod rounding_bound;
mod sampling;
mod scene;
mod scene_text;
pub mod scheduler;
mod selection;
mod separation;
mod separation_error;
mod simulation;
mod simultaneous_contacts;
mod single_bodies;
mod sites;
mod snapshot;
mod species;
mod spelling;
mod stage_spec;
mod start_from;
mod stop_spec;
mod tags;
mod thermal_wall;
mod thermostat;
mod thermostat_target;
mod tiling;
mod two_numbers;
mod unresolved;
mod velocities;
mod view;
mod wall;
mod window;
mod window_loop;
mod world;
mod wrapped;

pub use atom_spec::AtomSpec;
pub use batch::Batch;
pub use body::{Body, BodyKey, BodyName, Rotation};
pub use cells::{CellScheduler, Instructions};
pub use centre_of_mass::{CentreOfMassFrame, ThermalEnergy};
pub use checkpoint::{Checkpoint, CheckpointError};
pub use counters::{Counters, Ledger, SchedulerCounters};
pub use distribution::{Distribution, Quantity};
pub(crate) use elasticity_table::ElasticityTable;
pub use error::{EditError, GridError, RunError, SceneError, StallCause};
pub use gas_spec::{GasSpec, StartVelocities};
pub use grid::{CellsPerSide, MIN_CONTACT_SHARE};
pub use growth::{Growth, GrowthProgress};
pub use heap_scheduler::HeapScheduler;
pub use heat::{HeatByTag, TagHeat, ThermostatCounts};
pub use invariants::Violation;
pub use least_speed::MIN_SPEED;
pub use limits::{MAX_SPEED_RATIO, MAX_TURNS};
pub use max_time::MAX_TIME;
pub use measure_from::MeasureFrom;
pub use measure_spec::{MeasureParameter, MeasureSpec};
pub use method_spec::{DetectorName, InstructionsName, MethodSpec, SchedulerName, TilesName};
pub use observer::Observer;
pub use overlap::OverlapCensus;
pub use region::Region;
pub use report::{CollisionReport, Side};
pub use scene::{
    BoxSpec, BumperSpec, ElasticityRule, ElasticitySpec, MoleculeSpec, Placement, RunSpec, Scene,
    StageSpec, StartSpec, WallSpec,
};
pub use scheduler::Scheduler;
pub use simulation::Simulation;
pub use snapshot::frame_of;
pub use stage_spec::{HeatSpec, RelabelSpec, ThermostatKind, ThermostatSpec};
pub use stop_spec::StopSpec;
pub use tags::{Tag, TagNames, Tags};
pub use thermostat::DrawKey;
pub use thermostat_target::ThermostatTarget;
pub use tiling::{TileCounters, TileUse, TileWork, Tiling};
pub use view::{BodyView, View};
pub use world::World;

// Parts that runs of scenes and tests of accuracy share; no user of the library needs them.
#[doc(hidden)]
pub use random::RandomStream;
#[doc(hidden)]
pub use rounding_bound::rounding_bound;
#[doc(hidden)]
pub use spelling::did_you_mean;
