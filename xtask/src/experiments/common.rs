//! Options that experiments share: amount of work, seed, threads, and output folder.

use anyhow::Result;
use carom_runs::experiment::threads;
use clap::Args;
use rayon::ThreadPool;

/// Options of every experiment. `D` is the destination: [`carom_runs::output::Destination`], or
/// [`carom_runs::output::Resumption`] and [`carom_runs::resumable::Choices`] for experiments that
/// can be resumed.
///
/// The help of `--quick` and `--paper` is general; an experiment replaces it with `mut_arg`.
#[derive(Debug, Clone, Args)]
pub struct Common<D: Args> {
    /// A short test run, under two minutes (the default)
    #[arg(long, conflicts_with = "paper")]
    pub quick: bool,
    /// The run for publication
    #[arg(long)]
    pub paper: bool,
    /// Output folder and its treatment.
    #[command(flatten)]
    pub destination: D,
}

impl<D: Args> Common<D> {
    /// Returns true for a short test run, which is the default.
    pub fn is_quick(&self) -> bool {
        !self.paper
    }

    /// Returns `paper` for the run for publication, and `quick` for a short test run.
    pub fn select<T>(&self, quick: T, paper: T) -> T {
        if self.is_quick() { quick } else { paper }
    }

    /// The option that selects this amount of work, for the reproduced command.
    pub fn size(&self) -> &'static str {
        self.select("--quick", "--paper")
    }

    /// Beginning of the reproduced command: the name of the experiment and the amount of work.
    pub fn command(&self, experiment: &str) -> String {
        format!("cargo xtask experiment {experiment} {}", self.size())
    }

    /// Note that is printed and shown first: "This is a short run" and `limits`. Empty for the run
    /// for publication.
    pub fn note(&self, limits: &str) -> String {
        self.select(format!("This is a short run{limits}"), String::new())
    }
}

/// Option of experiments with random numbers.
#[derive(Debug, Clone, Copy, Args)]
pub struct Seed {
    /// Seed of all random numbers
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
}

/// Option of experiments that run in parallel.
#[derive(Debug, Clone, Copy, Args)]
pub struct Threads {
    /// Number of threads; default: one for each processor. Results other than wall times do not
    /// depend on it
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
}

impl Threads {
    /// Creates a pool with this number of threads.
    ///
    /// # Errors
    /// The system cannot create the threads.
    pub fn pool(&self) -> Result<ThreadPool> {
        threads(self.threads)
    }
}

/// Options of an experiment with random numbers that runs in parallel.
#[derive(Debug, Clone, Args)]
pub struct ParallelRuns<D: Args> {
    /// Options of every experiment.
    #[command(flatten)]
    pub common: Common<D>,
    /// Seed.
    #[command(flatten)]
    pub random: Seed,
    /// Threads.
    #[command(flatten)]
    pub threads: Threads,
}

impl<D: Args> ParallelRuns<D> {
    /// The command with every option that affects the results.
    pub fn command(&self, experiment: &str) -> String {
        format!(
            "{} --seed {}",
            self.common.command(experiment),
            self.random.seed
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_runs::output::Destination;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        common: Common<Destination>,
    }

    fn common(arguments: &[&str]) -> Common<Destination> {
        Line::try_parse_from([&["experiment"], arguments].concat())
            .unwrap()
            .common
    }

    #[test]
    fn a_run_is_short_unless_it_is_for_publication() {
        for arguments in [&[][..], &["--quick"]] {
            let short = common(arguments);
            assert_eq!(short.command("none"), "cargo xtask experiment none --quick");
            assert_eq!(
                short.note(": few bodies."),
                "This is a short run: few bodies."
            );
            assert_eq!(short.select(1, 2), 1);
        }
        let long = common(&["--paper"]);
        assert_eq!(long.command("none"), "cargo xtask experiment none --paper");
        assert!(long.note(": few bodies.").is_empty());
        assert_eq!(long.select(1, 2), 2);
        assert!(Line::try_parse_from(["experiment", "--quick", "--paper"]).is_err());
    }
}
