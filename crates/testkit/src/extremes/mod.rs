//! Extreme scenes, each with quantities that must not exceed a bound.
//!
//! Each runs with either [`Engine`], so that the engine of the thesis runs the same cases.

pub mod bodies;
mod borders;
mod construction;
mod crowds;
pub mod engine;
pub mod gases;
pub mod lattice;
mod pairs;
mod rotors;
mod sides;
mod solvable;
mod symmetry;
pub mod watch;

use anyhow::Result;

pub use engine::Engine;

/// Length of the cases that can run for any time.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Number of collisions of each gas.
    pub collisions: u64,
}

/// A quantity that must not exceed a bound.
#[derive(Debug, Clone)]
pub struct ExtremeFinding {
    /// Name of the quantity.
    pub what: String,
    /// Value found; NaN exceeds every bound.
    pub found: f64,
    /// Largest allowed value.
    pub allowed: f64,
}

impl ExtremeFinding {
    /// A quantity and its bound.
    pub fn new(what: impl Into<String>, found: f64, allowed: f64) -> Self {
        Self {
            what: what.into(),
            found,
            allowed,
        }
    }

    /// A number of violations that must be zero.
    pub fn never(what: impl Into<String>, times: usize) -> Self {
        Self::new(what, times as f64, 0.0)
    }

    /// Returns true if the bound holds.
    pub fn holds(&self) -> bool {
        self.found <= self.allowed
    }
}

/// One case.
#[derive(Debug, Clone, Copy)]
pub struct ExtremeCase {
    /// Number after sections 6 and 7 of the list of reference cases; 8 are bodies with sides.
    pub id: &'static str,
    /// The scene.
    pub name: &'static str,
    /// The required outcome in words.
    pub must: &'static str,
    /// Runs it.
    pub run: fn(Engine, Effort) -> Result<Vec<ExtremeFinding>>,
}

/// All cases.
pub fn cases() -> Vec<ExtremeCase> {
    [
        pairs::cases(),
        gases::cases(),
        rotors::cases(),
        sides::cases(),
        crowds::cases(),
        lattice::cases(),
        borders::cases(),
        construction::cases(),
        solvable::cases(),
        symmetry::cases(),
    ]
    .concat()
}
