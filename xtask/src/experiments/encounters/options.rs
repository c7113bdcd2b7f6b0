//! The amount of work of the experiment.

use crate::experiments::common::ParallelRuns;
use carom_runs::output::Resumption;

/// Options of `cargo xtask experiment encounters`.
pub type Options = ParallelRuns<Resumption>;

/// Amount of work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EncounterPlan {
    /// Number of cases of each class.
    pub cases: u64,
    /// Largest number of intervals that the oracle examines in one case.
    pub most_intervals: u64,
    /// A detector searches the cases of a class in order until it has evaluated this many gaps.
    pub most_evaluations: u64,
    /// Rounds of time measurements; the median is reported.
    pub rounds: usize,
    /// Number of cases of each class that parry searches.
    pub parry_cases: usize,
    /// Number of calls of parry without return after which no more are made.
    pub most_hung: usize,
}

impl EncounterPlan {
    /// The amount of work that options ask for.
    pub fn new(options: &Options) -> Self {
        options.common.select(
            EncounterPlan {
                cases: 150,
                most_intervals: 300_000,
                most_evaluations: 1_000_000,
                rounds: 5,
                parry_cases: 8,
                most_hung: 60,
            },
            EncounterPlan {
                cases: 3600,
                most_intervals: 3_000_000,
                most_evaluations: 100_000_000,
                rounds: 15,
                parry_cases: 150,
                most_hung: 1000,
            },
        )
    }
}
