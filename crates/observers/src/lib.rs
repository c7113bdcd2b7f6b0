//! What is measured while a gas runs: one quantity a file, each an [`Observer`] that looks and never touches.
//!
//! | quantity | observer | told of |
//! | --- | --- | --- |
//! | from which side a body is hit, in its own frame | [`DirectionHistogram`] | contacts |
//! | how hard it is hit along one of its axes | [`ProjectionHistogram`] | contacts |
//! | mean force on a body and its mean velocity, in its own frame | [`RunningAverage`] | contacts, samples |
//! | impulses and torques on a body, how far it goes and turns, in its own frame | [`Drift`] | contacts, samples |
//! | any of the first two and the fourth, block by block of time | [`Blocks`] | contacts, samples |
//! | energy against the books, momentum | [`EnergyLedger`] | samples |
//! | collisions per body and time | [`CollisionRate`] | samples |
//! | pressure from the virial of the contacts, momentum flux | [`Pressure`] | contacts, samples |
//! | energy put in by resets and lost in contacts | [`ThermostatLedger`] | samples |
//! | velocities, and Boltzmann's H | [`VelocityDistribution`] | samples |
//! | mean squared displacement, velocity autocorrelation | [`TimeCorrelation`] | samples |
//! | distances: the pair distribution g(r) | [`PairDistribution`] | samples |
//! | density of a gas at contact along a body's boundary | [`ContactDensity`] | contacts, samples |
//! | every impulse on a body | [`ImpulseLog`] | contacts |
//! | every flight of every body, for a while | [`FlightLog`] | contacts |
//! | overlapping pairs | [`OverlapCheck`] | samples |
//! | anything: closures, by event and by tag | [`Subscriptions`] | contacts, samples |
//!
//! All but the last are plain data, which serde writes down to the bit: a run that is resumed from a checkpoint goes on with
//! what it had seen.
//!
//! What blocks scatter is the statistical error: [`Estimate`] of a mean, [`Isotropy`] of a histogram of directions.
//!
//! What an observer is told of samples only costs a run nothing between them. Two functions turn a sample
//! view into text: [`write_extended_xyz`] and [`picture`]. Observers are put together as a tuple:
//!
//! ```
//! use carom_engine::{Observer, Scene, Simulation};
//! use carom_observers::{CollisionRate, EnergyLedger};
//!
//! let scene = Scene::from_toml("[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100")?;
//! let mut simulation = Simulation::new(&scene)?;
//! let mut observers = (EnergyLedger::default(), CollisionRate::default());
//! observers.start(&simulation.view());
//! for sample in 1..=10 {
//!     simulation.observe_until(0.1 * f64::from(sample), &mut observers)?;
//!     observers.sample(&simulation.view());
//! }
//! let (energy, rate) = observers;
//! assert!(energy.drift() < 1e-13);
//! assert_eq!(rate.series().len(), 10);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`Observer`]: carom_engine::Observer

mod blocks;
mod body_frame;
mod coarse_atoms;
mod collision_rate;
mod contact_density;
mod direction_histogram;
mod drift;
mod energy_ledger;
mod estimate;
mod extended_xyz;
mod flight_log;
mod group;
mod histogram;
mod impulse_log;
mod isotropy;
mod kinds;
mod mean;
mod overlap_check;
mod pair_distribution;
mod picture;
mod pressure;
mod projection_histogram;
mod running_average;
mod subscriptions;
mod tag_filter;
mod thermostat_ledger;
mod time_correlation;
mod velocity_distribution;

pub use blocks::{Additive, Block, Blocks};
pub use coarse_atoms::{MOST_CIRCLES, drawn_circles};
pub use collision_rate::{CollisionRate, RatePoint};
pub use contact_density::{ContactDensity, ContactPoint};
pub use direction_histogram::DirectionHistogram;
pub use drift::Drift;
pub use energy_ledger::{EnergyLedger, LedgerPoint};
pub use estimate::Estimate;
pub use extended_xyz::write_extended_xyz;
pub use flight_log::{Flight, FlightLog};
pub use group::Group;
pub use histogram::Histogram;
pub use impulse_log::{Impulse, ImpulseLog};
pub use isotropy::Isotropy;
pub use kinds::kinds;
pub use overlap_check::OverlapCheck;
pub use pair_distribution::{CutoffError, PairDistribution, PairPoint};
pub use picture::{close_up, colour, picture};
pub use pressure::{Pressure, PressurePoint};
pub use projection_histogram::{Axis, ProjectionHistogram};
pub use running_average::{RunningAverage, RunningPoint};
pub use subscriptions::{EventKind, SubscriptionKey, Subscriptions};
pub use tag_filter::TagFilter;
pub use thermostat_ledger::{ThermostatLedger, ThermostatPoint};
pub use time_correlation::{CorrelationPoint, TimeCorrelation};
pub use velocity_distribution::{VelocityDistribution, VelocityPoint};
