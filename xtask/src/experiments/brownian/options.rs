//! Options of the experiment, and the resulting plan.

use std::{path::PathBuf, str::FromStr};

use anyhow::{Result, ensure};
use carom::engine::RunSpec;
use carom_runs::{resumable::Choices, sampling_times::sampling_times};
use clap::{Args, ValueEnum};
use serde::Serialize;

use super::dilute::DILUTE;
use crate::experiments::{
    common::{Common, Seed, Threads},
    thesis_scene::{AREA_FRACTION, Case, Size, value_name},
};

/// Options of `cargo xtask experiment brownian`.
#[derive(Debug, Clone, Args)]
#[command(
    mut_arg("quick", |arg| arg.help(
        "A short test run, under two minutes for one case and size: to t = 200, measured from t = 5 (the default)"
    )),
    mut_arg("paper", |arg| arg.help("All eight runs of the thesis: to t = 5000, measured from t = 100"))
)]
pub struct Options {
    /// standard (a tee that rotates freely), control (a disc of equal area and mass), locked-0,
    /// locked-pi (a tee with its orientation locked at 0 or half a turn), or all; default: all with
    /// --paper, otherwise standard
    #[arg(long)]
    pub case: Option<OneOrAll<Case>>,
    /// Radius of the tee's atoms relative to the gas discs: 0.5, 0.25, or all; default: all with
    /// --paper, otherwise 0.5
    #[arg(long)]
    pub size: Option<OneOrAll<Size>>,
    /// Runs of each case and size that differ in their random numbers only
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub replicas: u64,
    /// Start of the measurement (time)
    #[arg(long)]
    pub from: Option<f64>,
    /// End of the run (time)
    #[arg(long)]
    pub until: Option<f64>,
    /// Area fraction of the gas. At small values such as 0.005 the shares of kicks by direction and
    /// by atom follow from the exposed arcs and are checked; below 0.01 runs are longer: to t =
    /// 20000, and 500000 with --paper
    #[arg(long, default_value_t = AREA_FRACTION)]
    pub area_fraction: f64,
    /// Largest number of rows of impulses.csv in each run; the first kicks are kept (0.2 kB each)
    #[arg(long, value_name = "ROWS", default_value_t = 1_000_000)]
    pub impulses: u64,
    /// Seed.
    #[command(flatten)]
    pub random: Seed,
    /// Threads.
    #[command(flatten)]
    pub threads: Threads,
    /// Options of every experiment.
    #[command(flatten)]
    pub common: Common<Choices>,
}

/// One of several choices, or all of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OneOrAll<T> {
    /// One choice.
    One(T),
    /// All choices.
    All,
}

impl<T: ValueEnum> OneOrAll<T> {
    /// The selected choices, in order.
    pub fn list(&self) -> Vec<T> {
        match self {
            Self::One(choice) => vec![choice.clone()],
            Self::All => T::value_variants().to_vec(),
        }
    }

    /// Name of the choice on the command line.
    pub fn name(&self) -> String {
        match self {
            Self::One(choice) => value_name(choice),
            Self::All => "all".to_owned(),
        }
    }
}

impl<T: ValueEnum> FromStr for OneOrAll<T> {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "all" {
            return Ok(Self::All);
        }
        let known = || T::value_variants().iter().map(value_name).collect::<Vec<_>>().join(", ");
        T::from_str(text, false).map(Self::One).map_err(|_| format!("expected one of {}, all", known()))
    }
}

/// Times of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// Start of the measurement (time).
    pub from: f64,
    /// End of the run (time).
    pub until: f64,
    /// Interval between samples (time).
    pub sample_interval: f64,
}

impl Plan {
    /// The `[run]` table for this plan.
    pub fn run(&self) -> RunSpec {
        RunSpec { until: self.until, sample_interval: self.sample_interval, ..RunSpec::default() }
    }

    /// Sampling times during equilibration.
    pub fn settling(&self) -> impl Iterator<Item = f64> + use<> {
        sampling_times(0.0, self.from, self.sample_interval)
    }

    /// Sampling times during the measurement.
    pub fn measuring(&self) -> impl Iterator<Item = f64> + use<> {
        sampling_times(self.from, self.until, self.sample_interval)
    }
}

impl Options {
    /// Selected molecules.
    pub fn case(&self) -> OneOrAll<Case> {
        self.case.unwrap_or(self.common.select(OneOrAll::One(Case::Standard), OneOrAll::All))
    }

    /// Selected sizes.
    pub fn size(&self) -> OneOrAll<Size> {
        self.size.unwrap_or(self.common.select(OneOrAll::One(Size::Half), OneOrAll::All))
    }

    /// Times of a run with these options.
    ///
    /// # Errors
    /// A time is not finite, or the measurement would not start after 0 and before the end.
    pub fn plan(&self) -> Result<Plan> {
        let ready = if self.area_fraction < DILUTE {
            // Kicks are rare and cheap.
            let until = self.common.select(20_000.0, 500_000.0);
            Plan { from: 100.0, until, sample_interval: 0.001 * until }
        } else {
            self.common.select(
                Plan { from: 5.0, until: 200.0, sample_interval: 0.5 },
                Plan { from: 100.0, until: 5000.0, sample_interval: 1.0 },
            )
        };
        let plan =
            Plan { from: self.from.unwrap_or(ready.from), until: self.until.unwrap_or(ready.until), ..ready };
        ensure!(
            self.area_fraction > 0.0 && self.area_fraction <= 0.7,
            "--area-fraction {}: it must be above 0 and at most 0.7, near the freezing density",
            self.area_fraction
        );
        ensure!(
            plan.until.is_finite() && plan.until > 0.0,
            "--until {}: it must be positive and finite",
            plan.until
        );
        ensure!(
            plan.from >= 0.0 && plan.from < plan.until,
            "the measurement would start at {} and end at {}: choose --from smaller than --until",
            plan.from,
            plan.until
        );
        Ok(plan)
    }

    /// Note that is printed and shown first.
    pub fn note(&self) -> String {
        self.common.note(" with large statistical errors. The runs of the thesis are --paper.")
    }

    /// Output folder.
    pub fn folder(&self) -> PathBuf {
        let named = format!("out/brownian-{}-{}", self.case().name(), self.size().name());
        self.common.destination.resumption.folder(&named)
    }

    /// The command with every option that affects the results.
    pub fn command(&self, plan: &Plan) -> String {
        format!(
            "cargo xtask experiment brownian --case {} --size {} {} --seed {} --replicas {} \
             --area-fraction {} --from {} --until {} --impulses {}",
            self.case().name(),
            self.size().name(),
            self.common.size(),
            self.random.seed,
            self.replicas,
            self.area_fraction,
            plan.from,
            plan.until,
            self.impulses,
        )
    }

    /// `config.toml` of several runs: the options; each run's folder holds its scene.
    ///
    /// # Errors
    /// A value cannot be written as TOML.
    pub fn configuration(&self, plan: &Plan) -> Result<String> {
        #[derive(Serialize)]
        struct Config {
            experiment: Experiment,
        }
        #[derive(Serialize)]
        struct Experiment {
            name: &'static str,
            case: String,
            size: String,
            seed: u64,
            replicas: u64,
            area_fraction: f64,
            from: f64,
            until: f64,
            sample_interval: f64,
            command: String,
        }
        let experiment = Experiment {
            name: "brownian",
            case: self.case().name(),
            size: self.size().name(),
            seed: self.random.seed,
            replicas: self.replicas,
            area_fraction: self.area_fraction,
            from: plan.from,
            until: plan.until,
            sample_interval: plan.sample_interval,
            command: self.command(plan),
        };
        Ok(toml::to_string_pretty(&Config { experiment })?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_parsed_as_they_are_printed() {
        for text in ["standard", "control", "locked-0", "locked-pi", "all"] {
            assert_eq!(text.parse::<OneOrAll<Case>>().unwrap().name(), text);
        }
        for (text, ratio) in [("0.5", 0.5), ("0.25", 0.25)] {
            assert_eq!(text.parse::<OneOrAll<Size>>().unwrap().list()[0].ratio(), ratio);
        }
        assert_eq!("all".parse::<OneOrAll<Size>>().unwrap().list().len(), 2);
        let refused = "locked".parse::<OneOrAll<Case>>().unwrap_err();
        assert!(refused.contains("locked-pi"), "{refused}");
    }
}
