//! Extreme scenes, each with what must hold in it: numbers that must not exceed a bound.
//!
//! Generic over the [`Engine`], so that the thesis's is asked the same; on the facade alone, so that the tests run them too.

pub mod bodies;
mod borders;
mod construction;
mod crowds;
pub mod engine;
pub mod gases;
pub mod lattice;
mod pairs;
mod rotors;
mod solvable;
mod symmetry;
pub mod watch;

use anyhow::Result;

pub use engine::{Engine, Ours};

/// How much is asked of the cases that can be run for long.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Collisions of each gas.
    pub collisions: u64,
}

/// Something that must not exceed a bound.
#[derive(Debug, Clone)]
pub struct Finding {
    /// What.
    pub what: String,
    /// What was found; NaN is beyond any bound.
    pub found: f64,
    /// The most that is allowed.
    pub allowed: f64,
}

impl Finding {
    /// A figure and its bound.
    pub fn new(what: impl Into<String>, found: f64, allowed: f64) -> Self {
        Self { what: what.into(), found, allowed }
    }

    /// How often something went wrong, which must be never.
    pub fn never(what: impl Into<String>, times: usize) -> Self {
        Self::new(what, times as f64, 0.0)
    }

    /// Whether the bound is kept.
    pub fn holds(&self) -> bool {
        self.found <= self.allowed
    }
}

/// One named case.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// Number, by section 7 and 6 of the list of reference cases.
    pub id: &'static str,
    /// The scene.
    pub name: &'static str,
    /// What must hold, in words.
    pub must: &'static str,
    /// Runs it.
    pub run: fn(Effort) -> Result<Vec<Finding>>,
}

/// All cases, to be run by one engine.
pub fn cases<E: Engine>() -> Vec<Case> {
    [
        pairs::cases::<E>(),
        gases::cases::<E>(),
        rotors::cases::<E>(),
        crowds::cases::<E>(),
        lattice::cases::<E>(),
        borders::cases::<E>(),
        construction::cases::<E>(),
        solvable::cases::<E>(),
        symmetry::cases::<E>(),
    ]
    .concat()
}
