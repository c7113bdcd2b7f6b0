//! `carom billiard` with the system of the thesis (Montanari 2017), and its lengths of runs.

use std::path::Path;

use anyhow::{Context, Result};
use carom::{Scene, Shape};
use carom_experiments::billiard;
use carom_sweeps::Study;
use carom_tables::Verdict;
use clap::Args;

/// Options of `cargo xtask experiment billiard`: those of `carom billiard`.
#[derive(Debug, Clone, Args)]
// The flattened options have a group of the same name.
#[group(skip)]
#[command(mut_arg("molecule", |arg| arg.required(false).default_value("tee")))]
pub struct Options {
    /// A short test run, well under two minutes: 4·10⁶ hits (the default)
    #[arg(long, conflicts_with = "paper")]
    pub quick: bool,
    /// The run for publication: 10⁸ hits
    #[arg(long, conflicts_with = "hits")]
    pub paper: bool,
    /// Options of the command.
    #[command(flatten)]
    pub billiard: billiard::Options,
}

/// The study: a disc among the images of a fixed tee.
const STUDY: &str = include_str!("../../studies/billiard.toml");

/// Runs the experiment.
///
/// # Errors
/// Those of [`billiard::run`].
pub fn run(options: &Options) -> Result<Verdict> {
    let mut billiard = options.billiard.clone();
    if billiard.molecule.molecule.parse::<Shape>().is_ok() && billiard.molecule.atom_radius.is_none() {
        billiard.molecule.atom_radius = scene()?.molecule[0].atom_radius;
    }
    if options.paper {
        billiard.hits = 100_000_000;
        return billiard::run(&billiard, "");
    }
    billiard::run(&billiard, "This is a short run. The run for publication, of 10⁸ hits, is --paper.")
}

/// The scene of the study.
fn scene() -> Result<Scene> {
    let study =
        Study::parse(STUDY, Path::new(""), carom_sweeps::Size::default()).context("studies/billiard.toml")?;
    let point = study.points.into_iter().next().context("studies/billiard.toml has no point")?;
    Ok(point.scene)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        options: Options,
    }

    #[test]
    fn the_study_has_the_system_of_the_experiment() {
        let scene = scene().unwrap();
        let tee = &scene.molecule[0];
        let mut options = Line::parse_from(["carom"]).options.billiard;
        options.molecule.atom_radius = tee.atom_radius;
        let flight = options.setup().unwrap().scene(0).unwrap();
        assert_eq!(flight.bounds.sides, scene.bounds.sides);
        assert_eq!(flight.molecule[0].molecule("").unwrap(), tee.molecule("").unwrap());
        assert_eq!((flight.molecule[0].at, flight.molecule[0].fixed), (tee.at, tee.fixed));
        let gas = &scene.gas[0];
        assert_eq!((Some(flight.molecule[1].atoms[0].radius), gas.count), (gas.radius, Some(1)));
    }
}
