//! The scenes of the thesis: the points of the study `xtask/studies/brownian.toml`.

use std::path::Path;

use anyhow::{Context, Result};
use carom::{
    Scene,
    engine::{BoxSpec, RunSpec},
};
use carom_experiments::brownian::{Setting, settings_of};
use carom_sweeps::Study;
use clap::ValueEnum;

/// Area fraction of the gas discs.
pub const AREA_FRACTION: f64 = 0.5;

/// The study: the molecules in the middle of the unit square, a small fixed disc, and a gas
/// (Montanari 2017, section 3.1.1).
const STUDY: &str = include_str!("../../studies/brownian.toml");

/// A molecule of the thesis in its gas.
///
/// # Errors
/// The study is invalid.
pub fn setting(case: Case, size: Size) -> Result<Setting> {
    let study = Study::parse(STUDY, Path::new(""), carom_sweeps::Size::default())?;
    let name = format!("{}-{}", case.name(), size.name());
    let settings = settings_of(&study, |_| Ok(0))?;
    let found = settings.into_iter().find(|setting| setting.name == name);
    found.with_context(|| format!("the study of the thesis has no point {name}"))
}

/// The scene of one run.
///
/// # Errors
/// The study is invalid.
pub fn scene(case: Case, size: Size, seed: u64, replica: u64, run: RunSpec) -> Result<Scene> {
    let scene = setting(case, size)?.scene;
    Ok(Scene {
        bounds: BoxSpec { seed, replica, ..scene.bounds },
        run: RunSpec { observe: scene.run.observe, ..run },
        ..scene
    })
}

/// The molecule in the gas.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Case {
    /// A tee that rotates freely.
    Standard,
    /// A disc of the same area and mass.
    Control,
    /// A tee with its orientation locked at 0.
    #[value(name = "locked-0")]
    Locked0,
    /// A tee with its orientation locked at half a turn.
    LockedPi,
}

/// Radius of the molecule's atoms relative to the gas discs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Size {
    /// One half.
    #[value(name = "0.5")]
    Half,
    /// One quarter.
    #[value(name = "0.25")]
    Quarter,
}

impl Case {
    /// Name of the case on the command line.
    pub fn name(self) -> String {
        value_name(&self)
    }
}

impl Size {
    /// Name of the size on the command line.
    pub fn name(self) -> String {
        value_name(&self)
    }
}

/// Name of a choice on the command line.
pub fn value_name<T: ValueEnum>(choice: &T) -> String {
    choice.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_methods::AnySimulation;

    #[test]
    fn every_case_is_a_valid_scene_of_the_same_mass_and_area() {
        for case in [Case::Standard, Case::Control, Case::Locked0, Case::LockedPi] {
            for size in [Size::Half, Size::Quarter] {
                let scene = scene(case, size, 1, 0, RunSpec::default()).unwrap();
                assert_eq!(Scene::from_toml(&scene.to_toml()).unwrap(), scene);
                let simulation = AnySimulation::new(&scene).unwrap();
                let view = simulation.view();
                let molecule = view.bodies().next().unwrap().body.molecule().clone();
                assert_eq!(molecule.mass(), 10.0);
                let ratio: f64 = size.name().parse().unwrap();
                let area = 5.0 * std::f64::consts::PI * (0.01 * ratio).powi(2);
                assert!((molecule.area() - area).abs() < 1e-15);
                // 0.5 / (π 0.01²) = 1591.5 discs, with the molecule and the bumper.
                assert!((view.len() as i64 - 1594).abs() <= 1);
            }
        }
    }
}
