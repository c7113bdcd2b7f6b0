//! Does a small molecule in a gas of discs receive a net force along its body axes (Montanari 2017,
//! chapter 3)?
//!
//! `carom brownian MOLECULE`: every impulse on the molecule is recorded by direction and by atom;
//! quantities that vanish at equilibrium are tested. The boundary of the region that the molecule
//! excludes is computed from its atoms, and with it the shares of the kicks in a dilute gas. Runs
//! of several molecules and replicas are executed in parallel.

mod analysis;
mod campaign;
mod charts;
mod dilute;
mod distributions;
mod equilibrium;
mod figures;
mod finding;
mod group;
mod measurement;
mod momentum;
mod options;
mod plan;
mod pockets;
mod pooled;
mod report;
mod results;
mod run;
mod setting;
mod snapshots;
mod study_points;
mod surroundings;
mod system;

pub use campaign::Campaign;
pub use carom_runs::measures::kicks::DILUTE;
pub use options::{Options, run};
pub use plan::Plan;
pub use run::run_campaign;
pub use setting::Setting;
pub use study_points::settings_of;
