//! What can be chosen about the two tests.

use carom_runs::output::Resumption;
use clap::Args;

/// Choices of `cargo xtask experiment spheres` and `pair`.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// A short run to look at, under two minutes: each case for a second of processor time at most (the default)
    #[arg(long, conflicts_with = "paper")]
    pub quick: bool,
    /// The run of the thesis: each case to 100 time units, and on until its times are known to 1 %; for ten minutes of
    /// processor time at most
    #[arg(long)]
    pub paper: bool,
    /// Processor time of each case at most (seconds) instead
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    pub seconds: Option<u32>,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Where to write, over what, and whether to go on
    #[command(flatten)]
    pub resumption: Resumption,
}

impl Options {
    /// Processor time of each case at most (seconds).
    pub fn budget(&self) -> f64 {
        self.seconds.map_or(if self.paper { 600.0 } else { 1.0 }, f64::from)
    }

    /// What is to be known of the run before anything else.
    pub fn note(&self) -> String {
        if self.paper {
            String::new()
        } else {
            "This is a short run, to look at: cases that take long are broken off, and times for 100 time units reckoned \
             from what was done. The run of the thesis is --paper."
                .to_owned()
        }
    }

    /// The command with every choice written out that the results depend on.
    pub fn command(&self, test: &str) -> String {
        let size = if self.paper { "--paper" } else { "--quick" };
        format!("cargo xtask experiment {test} {size} --seconds {} --seed {}", self.budget(), self.seed)
    }
}
