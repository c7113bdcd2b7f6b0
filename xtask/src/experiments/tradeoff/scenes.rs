//! The four scenes: the gas of the thesis, a tee in it, dumbbells, and the dilute gas of the
//! thesis's first test.

use std::f64::consts::PI;

use anyhow::Result;
use carom::{
    Scene,
    engine::{BoxSpec, GasSpec, RunSpec},
};

use crate::experiments::thesis_scene::{self, Case, Size};

/// A scene with its name.
#[derive(Debug, Clone)]
pub struct Named {
    /// Name.
    pub name: &'static str,
    /// Description.
    pub about: &'static str,
    /// The scene.
    pub scene: Scene,
}

/// All scenes.
///
/// # Errors
/// The study of the thesis is invalid.
pub fn all(seed: u64) -> Result<Vec<Named>> {
    let bounds = BoxSpec { seed, ..BoxSpec::default() };
    let run = RunSpec {
        until: 2.0,
        sample_interval: 0.5,
        observe: ["pressure", "velocities"].map(str::to_owned).to_vec(),
        ..RunSpec::default()
    };
    let of =
        |gas: GasSpec| Scene { bounds: bounds.clone(), gas: vec![gas], run: run.clone(), ..Scene::default() };
    let discs = |radius: f64| GasSpec {
        radius: Some(radius),
        mass: Some(1.0),
        energy: 1.0,
        zero_momentum: Some(true),
        ..GasSpec::default()
    };
    let dumbbells = GasSpec {
        shape: Some("dumbbell".to_owned()),
        // 1000 dumbbells of area fraction 0.3.
        atom_radius: Some((0.3 / (2000.0 * PI)).sqrt()),
        atom_mass: Some(0.5),
        energy: 1.5,
        count: Some(1000),
        zero_momentum: Some(true),
        ..GasSpec::default()
    };
    Ok(vec![
        Named {
            name: "thesis-gas",
            about: "discs of radius 0.01, area fraction 0.5",
            scene: of(GasSpec { area_fraction: Some(0.5), ..discs(0.01) }),
        },
        Named {
            name: "tee",
            about: "a tee with atoms of half that radius in the same gas, and a bumper",
            scene: thesis_scene::scene(Case::Standard, Size::Half, seed, 0, run.clone())?,
        },
        Named { name: "dumbbells", about: "1000 dumbbells, area fraction 0.3", scene: of(dumbbells) },
        Named {
            name: "dilute",
            about: "1000 discs of radius 0.001, the first test of Montanari (2017), section 2.3.1",
            scene: of(GasSpec { count: Some(1000), ..discs(0.001) }),
        },
    ])
}
