//! The eight runs of Montanari 2017, chapter 3, as settings of `carom brownian`: a tee-shaped
//! molecule of two sizes, free and locked, and its control disc.

use std::str::FromStr;

use anyhow::{Result, ensure};
use carom_experiments::{
    brownian::{Campaign, DILUTE, Plan, Setting, run_campaign},
    common::{Common, Seed, Threads},
};
use carom_runs::resumable::Choices;
use carom_tables::Verdict;
use clap::{Args, ValueEnum};
use serde::Serialize;

use super::thesis_scene::{AREA_FRACTION, Case, Size, setting, value_name};

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

/// Runs the experiment and writes its folder.
///
/// # Errors
/// An option is invalid, the folder is not empty, or a run fails.
pub fn run(options: &Options) -> Result<Verdict> {
    run_campaign(&options.campaign()?)
}

impl Options {
    /// Selected molecules.
    fn case(&self) -> OneOrAll<Case> {
        self.case.unwrap_or(self.common.select(OneOrAll::One(Case::Standard), OneOrAll::All))
    }

    /// Selected sizes.
    fn size(&self) -> OneOrAll<Size> {
        self.size.unwrap_or(self.common.select(OneOrAll::One(Size::Half), OneOrAll::All))
    }

    /// Times of a run with these options.
    ///
    /// # Errors
    /// An option is out of range.
    fn plan(&self) -> Result<Plan> {
        ensure!(
            self.area_fraction > 0.0 && self.area_fraction <= 0.7,
            "--area-fraction {}: it must be above 0 and at most 0.7, near the freezing density",
            self.area_fraction
        );
        let ready = if self.area_fraction < DILUTE {
            self.common
                .select(Plan::DILUTE, Plan { until: 500_000.0, sample_interval: 500.0, ..Plan::DILUTE })
        } else {
            self.common.select(Plan::DENSE, Plan { from: 100.0, until: 5000.0, sample_interval: 1.0 })
        };
        ready.with(self.from, self.until)
    }

    /// The molecules, in the order of their cases and sizes.
    fn settings(&self) -> Result<Vec<Setting>> {
        let sizes = self.size().list();
        let of_case = |case: Case| sizes.iter().map(move |&size| setting(case, size));
        let settings: Result<Vec<Setting>> = self.case().list().into_iter().flat_map(of_case).collect();
        let mut settings = settings?;
        for setting in &mut settings {
            setting.scene.gas[0].area_fraction = Some(self.area_fraction);
        }
        Ok(settings)
    }

    fn campaign(&self) -> Result<Campaign<'_>> {
        let plan = self.plan()?;
        let settings = self.settings()?;
        Ok(Campaign {
            title: format!("Brownian motion: {} runs", settings.len() as u64 * self.replicas),
            settings,
            replicas: self.replicas,
            seed: self.random.seed,
            plan,
            impulses: self.impulses,
            choices: &self.common.destination,
            usual_folder: format!("out/brownian-{}-{}", self.case().name(), self.size().name()),
            threads: self.threads,
            program: "cargo xtask experiment brownian",
            command: self.command(&plan),
            note: self.common.note(" with large statistical errors. The runs of the thesis are --paper."),
            configuration: self.configuration(&plan)?,
        })
    }

    /// The command with every option that affects the results.
    fn command(&self, plan: &Plan) -> String {
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
    fn configuration(&self, plan: &Plan) -> Result<String> {
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
        for text in ["0.5", "0.25"] {
            assert_eq!(text.parse::<OneOrAll<Size>>().unwrap().list()[0].name(), text);
        }
        assert_eq!("all".parse::<OneOrAll<Size>>().unwrap().list().len(), 2);
        let refused = "locked".parse::<OneOrAll<Case>>().unwrap_err();
        assert!(refused.contains("locked-pi"), "{refused}");
    }
}
