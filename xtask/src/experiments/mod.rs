//! The experiments: each answers a question with a folder of files and a page.

pub mod billiard;
pub mod brownian;
pub mod capability_cost;
pub mod common;
pub mod encounters;
pub mod equilibrium;
pub mod errors;
pub mod extremes;
pub mod fixed_energy;
pub mod thesis_scene;
pub mod thesis_tests;
pub mod time_reversal;
pub mod tradeoff;
