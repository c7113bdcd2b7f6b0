//! Event-driven simulation of rigid molecules: the event loop, and the only code that changes the
//! state.
//!
//! Stable: its public items follow the policy of versions in the book (*Versions and releases*).
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

mod cells;
mod contact;
mod edit;
mod grid;
mod heap_scheduler;
mod run;
mod scene;
pub mod scheduler;
mod start;
mod tiling;
mod window;
mod world;

pub use cells::{CellScheduler, Instructions};
pub use contact::limits::{MAX_SPEED_RATIO, MAX_TURNS};
pub use contact::overlap::OverlapCensus;
pub use edit::batch::Batch;
pub use edit::draw_key::DrawKey;
pub use grid::{CellsPerSide, MIN_CONTACT_SHARE};
pub use heap_scheduler::HeapScheduler;
pub use run::checkpoint::{Checkpoint, CheckpointError};
pub use run::growth::{Growth, GrowthProgress};
pub use run::invariants::Violation;
pub use run::observer::Observer;
pub use run::simulation::Simulation;
pub use scene::atom_spec::AtomSpec;
pub use scene::bond_spec::{BondSpec, ChainSpec, TetherSpec};
pub use scene::container_spec::{CircleSpec, ContainerSpec, MushroomSpec, StadiumSpec};
pub use scene::distribution::{Distribution, Quantity};
pub use scene::elasticity_spec::{ElasticityRule, ElasticitySpec, Restitution};
pub use scene::ellipse_spec::EllipseSpec;
pub use scene::error::{EditError, GridError, RunError, SceneError, StallCause};
pub use scene::gas_spec::{GasSpec, StartVelocities};
pub use scene::gravity::GravitySpec;
pub use scene::kick_momentum::KickMomentum;
pub use scene::least_speed::MIN_SPEED;
pub use scene::max_time::MAX_TIME;
pub use scene::measure_from::MeasureFrom;
pub use scene::measure_spec::{MeasureParameter, MeasureSpec};
pub use scene::method_spec::{
    DetectorName, InstructionsName, MethodSpec, SchedulerName, TilesName,
};
pub use scene::pair_spec::{DiameterSpec, TransparentSpec};
pub use scene::piston_spec::{PistonSpec, PushPistonSpec};
pub use scene::reaction_spec::ReactionSpec;
pub use scene::region::Region;
pub use scene::stage_spec::{HeatSpec, RelabelSpec, ThermostatKind, ThermostatSpec, VelocitySpec};
pub use scene::stop_spec::StopSpec;
pub use scene::thermostat_rule::{LangevinStep, SelfPropulsion, ThermostatRule};
pub use scene::thermostat_target::ThermostatTarget;
pub use scene::units_spec::UnitsSpec;
pub use scene::wall_motion::{MoveWallSpec, WallMotionSpec};
pub use scene::well_spec::WellSpec;
pub use scene::{
    ArcSpec, BoxSpec, BumperSpec, MoleculeSpec, Placement, RunSpec, Scene, StageSpec, StartSpec,
    WallSpec,
};
pub use scheduler::Scheduler;
pub use start::snapshot::frame_of;
pub use tiling::{TileCounters, TileUse, TileWork, Tiling};
pub use world::World;
pub use world::body::{Body, BodyKey, BodyName, Rotation};
pub use world::centre_of_mass::{CentreOfMassFrame, ThermalEnergy};
pub use world::counters::{Counters, Ledger, SchedulerCounters};
pub use world::heat::{HeatByTag, TagHeat, ThermostatCounts};
pub use world::reaction_record::{ReactionCounts, ReactionRecord};
pub use world::report::{CollisionReport, Side};
pub use world::tags::{Tag, TagNames, Tags};
pub use world::tethers::{Bond, BondEnd, BondView};
pub use world::view::{BodyView, View};
pub use world::wells::PairInWell;

// Parts that runs of scenes and tests of accuracy share; no user of the library needs them.
#[doc(hidden)]
pub use scene::random::RandomStream;
#[doc(hidden)]
pub use scene::spelling::did_you_mean;
#[doc(hidden)]
pub use world::rounding_bound::rounding_bound;
