//! The scene of each case: a molecule in the middle of the unit square, a bumper, and a gas of area
//! fraction one half.

use carom::{
    Scene,
    engine::{AtomSpec, BoxSpec, BumperSpec, GasSpec, MoleculeSpec, Rotation, RunSpec},
};
use clap::ValueEnum;

/// Radius of the gas discs (length).
pub const GAS_RADIUS: f64 = 0.01;

/// Mass of the gas discs.
pub const GAS_MASS: f64 = 1.0;

/// Energy of each gas disc at the start.
pub const GAS_ENERGY: f64 = 1.0;

/// Area fraction of the gas discs.
pub const AREA_FRACTION: f64 = 0.5;

/// Radius of the fixed disc that breaks the conservation of momentum (length).
pub const BUMPER_RADIUS: f64 = 0.0025;

/// Mass of each of the tee's five atoms.
const ATOM_MASS: f64 = 2.0;

/// The scene of one run. A gas of nonzero momentum would flow as a wind; a small fixed disc stops
/// it (Montanari 2017, section 3.1.1).
pub fn scene(case: Case, size: Size, seed: u64, replica: u64, run: RunSpec) -> Scene {
    Scene {
        bounds: BoxSpec { seed, replica, ..BoxSpec::default() },
        molecule: vec![molecule(case, size)],
        bumper: vec![BumperSpec { tags: vec!["bumper".to_owned()], radius: BUMPER_RADIUS, at: [0.1, 0.1] }],
        gas: vec![GasSpec {
            tags: vec!["gas".to_owned()],
            radius: Some(GAS_RADIUS),
            mass: Some(GAS_MASS),
            energy: GAS_ENERGY,
            area_fraction: Some(AREA_FRACTION),
            ..GasSpec::default()
        }],
        run: RunSpec { observe: ["energy", "collision-rate", "overlap"].map(str::to_owned).to_vec(), ..run },
        ..Scene::default()
    }
}

fn molecule(case: Case, size: Size) -> MoleculeSpec {
    let radius = size.ratio() * GAS_RADIUS;
    let at = [0.5, 0.5];
    if case == Case::Control {
        // Five discs of radius a have the area of one disc of radius √5 a.
        let atom = AtomSpec { at: [0.0; 2], radius: 5f64.sqrt() * radius, mass: 5.0 * ATOM_MASS };
        return MoleculeSpec {
            tags: vec!["disc".to_owned()],
            atoms: vec![atom],
            at,
            ..MoleculeSpec::default()
        };
    }
    MoleculeSpec {
        tags: vec!["tee".to_owned()],
        shape: Some("tee".to_owned()),
        atom_radius: Some(radius),
        atom_mass: Some(ATOM_MASS),
        at,
        orientation_turns: Some(if case == Case::LockedPi { 0.5 } else { 0.0 }),
        rotation: if case.turns() { Rotation::Free } else { Rotation::Locked },
        ..MoleculeSpec::default()
    }
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

    /// Description of the molecule.
    pub fn words(self) -> &'static str {
        match self {
            Self::Standard => "a tee of five discs, rotating freely",
            Self::Control => "a disc of the same area and mass as the tee",
            Self::Locked0 => "a tee of five discs, its orientation locked at 0",
            Self::LockedPi => "a tee of five discs, its orientation locked at half a turn",
        }
    }

    /// Returns true if the molecule can rotate.
    pub fn turns(self) -> bool {
        self == Self::Standard
    }
}

impl Size {
    /// Name of the size on the command line.
    pub fn name(self) -> String {
        value_name(&self)
    }

    /// The ratio.
    pub fn ratio(self) -> f64 {
        match self {
            Self::Half => 0.5,
            Self::Quarter => 0.25,
        }
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
                let scene = scene(case, size, 1, 0, RunSpec::default());
                assert_eq!(Scene::from_toml(&scene.to_toml()).unwrap(), scene);
                let simulation = AnySimulation::new(&scene).unwrap();
                let view = simulation.view();
                let molecule = view.bodies().next().unwrap().body.molecule().clone();
                assert_eq!(molecule.mass(), 10.0);
                let area = 5.0 * std::f64::consts::PI * (size.ratio() * GAS_RADIUS).powi(2);
                assert!((molecule.area() - area).abs() < 1e-15);
                // 0.5 / (π 0.01²) = 1591.5 discs, with the molecule and the bumper.
                assert!((view.len() as i64 - 1594).abs() <= 1);
            }
        }
    }
}
