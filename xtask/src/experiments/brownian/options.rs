//! What can be chosen about the experiment, and the plan that follows from it.

use std::{path::PathBuf, str::FromStr};

use anyhow::{Result, ensure};
use carom::engine::RunSpec;
use carom_runs::{resumable::Choices, sampling_times::sampling_times};
use clap::{Args, ValueEnum};

use super::dilute::DILUTE;
use crate::experiments::thesis_scene::{AREA_FRACTION, Case, Size, value_name};

/// Choices of `cargo xtask experiment brownian`.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// standard (the tee turns freely), control (a disc of equal area and mass), locked-0, locked-pi (the tee's
    /// orientation is locked at 0 or half a turn), or all; with --paper all if not given, otherwise standard
    #[arg(long)]
    pub case: Option<OneOrAll<Case>>,
    /// Radius of the tee's atoms relative to the gas discs: 0.5, 0.25, or all; with --paper all if not given, otherwise 0.5
    #[arg(long)]
    pub size: Option<OneOrAll<Size>>,
    /// A short run to look at, under two minutes for one case and size: to t = 200, measured from 5 (the default)
    #[arg(long, conflicts_with = "paper")]
    pub quick: bool,
    /// The runs of the thesis, all eight of them: to t = 5000, measured from 100
    #[arg(long)]
    pub paper: bool,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Runs of each case and size that differ in their random numbers only
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub replicas: u64,
    /// Runs at once; as many as there are processors if not given. The results do not depend on it
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// When to begin measuring (time)
    #[arg(long)]
    pub from: Option<f64>,
    /// When to end (time)
    #[arg(long)]
    pub until: Option<f64>,
    /// Share of the box that the gas covers. Where it is small, as 0.005, the shares of kicks by direction and by atom
    /// follow from the exposed arcs, and are checked; below 0.01 runs are longer: to t = 20000, and 500000 with --paper
    #[arg(long, default_value_t = AREA_FRACTION)]
    pub area_fraction: f64,
    /// Rows of impulses.csv at most, in each run: every single kick, first those first (0.2 kB each)
    #[arg(long, value_name = "ROWS", default_value_t = 1_000_000)]
    pub impulses: u64,
    /// Folders that are there already, and checkpoints
    #[command(flatten)]
    pub choices: Choices,
}

/// One of some choices, or all of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OneOrAll<T> {
    /// This one.
    One(T),
    /// All.
    All,
}

impl<T: ValueEnum> OneOrAll<T> {
    /// What is chosen, in order.
    pub fn list(&self) -> Vec<T> {
        match self {
            Self::One(choice) => vec![choice.clone()],
            Self::All => T::value_variants().to_vec(),
        }
    }

    /// The choice as it is written.
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
        T::from_str(text, false).map(Self::One).map_err(|_| format!("known are {}, all", known()))
    }
}

/// When what happens in a run, in the scene's unit of time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// Measuring begins.
    pub from: f64,
    /// The run ends.
    pub until: f64,
    /// Between two samples.
    pub sample_interval: f64,
}

impl Plan {
    /// The `[run]` of a scene that ends and is sampled by this plan.
    pub fn run(&self) -> RunSpec {
        RunSpec { until: self.until, sample_interval: self.sample_interval, ..RunSpec::default() }
    }

    /// The samples while the gas settles.
    pub fn settling(&self) -> impl Iterator<Item = f64> + use<> {
        sampling_times(0.0, self.from, self.sample_interval)
    }

    /// The samples while measuring.
    pub fn measuring(&self) -> impl Iterator<Item = f64> + use<> {
        sampling_times(self.from, self.until, self.sample_interval)
    }
}

impl Options {
    /// What is put into the gas.
    pub fn case(&self) -> OneOrAll<Case> {
        self.case.unwrap_or(if self.paper { OneOrAll::All } else { OneOrAll::One(Case::Standard) })
    }

    /// How large it is.
    pub fn size(&self) -> OneOrAll<Size> {
        self.size.unwrap_or(if self.paper { OneOrAll::All } else { OneOrAll::One(Size::Half) })
    }

    /// When what happens.
    ///
    /// # Errors
    /// Times that are not finite, or measuring would not begin after 0 and before the end.
    pub fn plan(&self) -> Result<Plan> {
        let ready = if self.area_fraction < DILUTE {
            // Kicks are rare, and cost little.
            let until = if self.paper { 500_000.0 } else { 20_000.0 };
            Plan { from: 100.0, until, sample_interval: 0.001 * until }
        } else if self.paper {
            Plan { from: 100.0, until: 5000.0, sample_interval: 1.0 }
        } else {
            Plan { from: 5.0, until: 200.0, sample_interval: 0.5 }
        };
        let plan =
            Plan { from: self.from.unwrap_or(ready.from), until: self.until.unwrap_or(ready.until), ..ready };
        ensure!(
            self.area_fraction > 0.0 && self.area_fraction <= 0.7,
            "--area-fraction {}: it must be above 0 and at most 0.7, where discs begin to freeze",
            self.area_fraction
        );
        ensure!(
            plan.until.is_finite() && plan.until > 0.0,
            "--until {}: it must be positive and finite",
            plan.until
        );
        ensure!(
            plan.from >= 0.0 && plan.from < plan.until,
            "measuring would begin at {} and end at {}: choose --from and --until so that it lasts",
            plan.from,
            plan.until
        );
        Ok(plan)
    }

    /// What is to be known of the plan before anything else.
    pub fn note(&self) -> String {
        if self.paper {
            String::new()
        } else {
            "This is a short run, to look at: the statistics are poor. The runs of the thesis are --paper."
                .to_owned()
        }
    }

    /// Folder to write to.
    pub fn folder(&self) -> PathBuf {
        let named = format!("out/brownian-{}-{}", self.case().name(), self.size().name());
        self.choices.resumption.folder(&named)
    }

    /// The command with every choice written out that the results depend on.
    pub fn command(&self, plan: &Plan) -> String {
        format!(
            "cargo xtask experiment brownian --case {} --size {} {} --seed {} --replicas {} \
             --area-fraction {} --from {} --until {} --impulses {}",
            self.case().name(),
            self.size().name(),
            if self.paper { "--paper" } else { "--quick" },
            self.seed,
            self.replicas,
            self.area_fraction,
            plan.from,
            plan.until,
            self.impulses,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_as_they_are_written() {
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
