//! Options of the two tests.

use carom_runs::output::Resumption;
use clap::Args;

/// Options of `cargo xtask experiment spheres` and `pair`.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// A short test run, under two minutes: at most a second of processor time for each case (the
    /// default)
    #[arg(long, conflicts_with = "paper")]
    pub quick: bool,
    /// The run of the thesis: each case to 100 time units and on until its times are known to 1 %,
    /// for at most ten minutes of processor time
    #[arg(long)]
    pub paper: bool,
    /// Largest processor time of each case instead (seconds)
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    pub seconds: Option<u32>,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Output folder and whether to resume there
    #[command(flatten)]
    pub resumption: Resumption,
}

impl Options {
    /// Largest processor time of each case (seconds).
    pub fn budget(&self) -> f64 {
        self.seconds.map_or(if self.paper { 600.0 } else { 1.0 }, f64::from)
    }

    /// Note that is printed and shown first.
    pub fn note(&self) -> String {
        if self.paper {
            String::new()
        } else {
            "This is a short run: slow cases end early, and their times for 100 time units are extrapolated. \
             The run of the thesis is --paper."
                .to_owned()
        }
    }

    /// The command with every option that affects the results.
    pub fn command(&self, test: &str) -> String {
        let size = if self.paper { "--paper" } else { "--quick" };
        format!("cargo xtask experiment {test} {size} --seconds {} --seed {}", self.budget(), self.seed)
    }
}
