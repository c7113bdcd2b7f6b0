//! Do gases reach the equilibrium that theory and published simulations predict?
//!
//! `cargo xtask experiment equilibrium`: scenes with measures, as in any scene file. Hard discs at
//! five densities: pressure, collision rate, contact value, free path and velocities. Three
//! published pressures. A mixture of molecules: equipartition.

mod report;
mod results;
mod run;
mod scenes;

pub use run::run;
