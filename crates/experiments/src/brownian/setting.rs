//! One molecule in its gas: the scene, and what the analysis needs from it.

use std::f64::consts::PI;

use anyhow::{Context, Result, bail, ensure};
use carom::{
    Molecule, Scene,
    engine::{AtomSpec, BoxSpec, BumperSpec, GasSpec, MoleculeSpec, Rotation, RunSpec},
};
use carom_methods::Method;

use super::{momentum::refuse_drift, surroundings::Surroundings};

/// A molecule in its surroundings, of which there may be several runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// Name of its files and folders.
    pub name: String,
    /// Name for titles.
    pub title: String,
    /// Description of the molecule, such as "a tee of five discs, rotating freely".
    pub words: String,
    /// The scene.
    pub scene: Scene,
    /// Index of the molecule among those of the scene.
    pub body: usize,
}

/// A gas of equal discs in a periodic square.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gas {
    /// Radius of the discs (length).
    pub radius: f64,
    /// Area fraction of the discs.
    pub area_fraction: f64,
    /// Side of the square (length).
    pub side: f64,
}

/// Mass of the gas discs.
const GAS_MASS: f64 = 1.0;

/// Energy of each gas disc at the start.
const GAS_ENERGY: f64 = 1.0;

/// Side of the box in radii of the gas discs, as in the thesis.
const SIDE: f64 = 100.0;

/// Least side of the box in the reach of the molecule, its bounding radius and that of a gas disc.
const REACHES: f64 = 10.0;

impl Gas {
    /// The side of the box if none is given (length): 100 radii of the gas discs, as in the thesis,
    /// and at least 10 times the bounding radius of the molecule with a gas disc.
    pub fn usual_side(radius: f64, molecule: &Molecule) -> f64 {
        (SIDE * radius).max(REACHES * (molecule.bounding_radius() + radius))
    }

    /// The scene of a molecule in this gas: the molecule at rest in the middle, and a small fixed
    /// disc. A gas of nonzero momentum would flow as a wind; the fixed disc stops it (Montanari
    /// 2017, section 3.1.1).
    pub fn around(&self, molecule: MoleculeSpec) -> Scene {
        Scene {
            bounds: BoxSpec { sides: [self.side; 2], ..BoxSpec::default() },
            molecule: vec![MoleculeSpec { at: [0.5 * self.side; 2], ..molecule }],
            bumper: vec![BumperSpec {
                tags: vec!["bumper".to_owned()],
                radius: 0.25 * self.radius,
                at: [0.1 * self.side; 2],
            }],
            gas: vec![GasSpec {
                tags: vec!["gas".to_owned()],
                radius: Some(self.radius),
                mass: Some(GAS_MASS),
                energy: GAS_ENERGY,
                area_fraction: Some(self.area_fraction),
                ..GasSpec::default()
            }],
            run: RunSpec {
                observe: ["energy", "collision-rate", "overlap"].map(str::to_owned).to_vec(),
                ..RunSpec::default()
            },
            ..Scene::default()
        }
    }
}

impl Setting {
    /// The method of its runs.
    ///
    /// # Errors
    /// A value of `[method]` is out of range.
    pub fn method(&self) -> Result<Method> {
        Method::try_from(&self.scene.method).context("[method]")
    }

    /// Name of one run, and of its folder if there are several.
    pub fn run_name(&self, replica: u64) -> String {
        format!("{}-{replica}", self.name)
    }

    /// What moves around the molecule.
    ///
    /// # Errors
    /// Nothing else moves, or an entry of the scene is invalid.
    pub fn surroundings(&self) -> Result<Surroundings> {
        Surroundings::of(&self.scene, self.body)
    }

    /// Area of the box (length²).
    pub fn area(&self) -> f64 {
        self.scene.bounds.sides[0] * self.scene.bounds.sides[1]
    }

    /// Whether contacts can turn this molecule.
    pub fn turns(&self, molecule: &Molecule) -> bool {
        self.scene.molecule[self.body].rotation == Rotation::Free && !molecule.is_round()
    }

    /// Whether one gas of equal discs has the whole box, except for the molecule and small fixed
    /// discs: the predictions of rates hold then.
    pub fn is_open(&self) -> bool {
        let is_one_gas = self.surroundings().is_ok_and(|surroundings| surroundings.is_one_gas);
        is_one_gas && self.scene.wall.is_empty() && self.scene.molecule.len() == 1
    }

    /// Refuses a scene without equilibrium, or in which nothing moves around the molecule.
    ///
    /// # Errors
    /// An entry of the scene does not fit; the message names it.
    pub fn check(&self) -> Result<()> {
        let scene = &self.scene;
        self.method()?;
        ensure!(
            !scene.molecule[self.body].fixed,
            "molecule[{}]: a fixed molecule has no Brownian motion",
            self.body
        );
        self.surroundings()?;
        refuse_drift(scene)?;
        let rules = scene.elasticity.pair.iter().map(|rule| rule.coefficient);
        ensure!(
            rules.chain([scene.elasticity.default]).all(|coefficient| coefficient == 1.0),
            "elasticity: it must be 1, because the means vanish at equilibrium only"
        );
        let heated = scene.wall.iter().position(|wall| wall.temperature.is_some());
        if let Some(index) = heated {
            bail!("wall[{index}]: `temperature` is not available here, because energy must be conserved");
        }
        ensure!(scene.stage.is_empty(), "stage: stages are not available here; use carom run");
        ensure!(scene.run.stop.is_none(), "run.stop: it is not available here; use carom run");
        ensure!(scene.start.from.is_none(), "start.from: it is not available here; use carom run");
        Ok(())
    }

    /// The control of this setting: a disc of the area and mass of the molecule in its place.
    #[must_use]
    pub fn control(&self, molecule: &Molecule) -> Self {
        let mut scene = self.scene.clone();
        let entry = &mut scene.molecule[self.body];
        let disc = AtomSpec { at: [0.0; 2], radius: (molecule.area() / PI).sqrt(), mass: molecule.mass() };
        *entry = MoleculeSpec {
            tags: entry.tags.clone(),
            atoms: vec![disc],
            at: entry.at,
            velocity: entry.velocity,
            ..MoleculeSpec::default()
        };
        Self {
            name: "control".to_owned(),
            title: "control disc".to_owned(),
            words: format!("a disc of the same area and mass as {}", self.title),
            scene,
            body: self.body,
        }
    }
}

/// Description of a molecule.
pub fn words(molecule: &Molecule, spec: &MoleculeSpec) -> String {
    let atoms = match molecule.atoms().len() {
        1 => "a disc".to_owned(),
        count => format!("{count} discs"),
    };
    let shape = spec.shape.as_ref().filter(|_| molecule.atoms().len() > 1);
    let shape = shape.map_or(atoms.clone(), |shape| format!("{shape}, {atoms}"));
    let mass = format!("of mass {}", carom_report::page::with_error(molecule.mass(), None));
    if molecule.is_round() {
        return format!("{shape} {mass}");
    }
    let degrees = spec.orientation.map(f64::to_degrees).or(spec.orientation_turns.map(|turns| 360.0 * turns));
    match spec.rotation {
        Rotation::Free => format!("{shape} {mass}, rotating freely"),
        Rotation::Locked => format!("{shape} {mass}, locked at {}°", degrees.unwrap_or(0.0)),
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// The tee of the thesis in its gas, free or locked, or its control disc; atoms are half as
    /// large as the gas discs.
    pub fn tee(rotation: Rotation) -> Setting {
        let spec = MoleculeSpec {
            shape: Some("tee".to_owned()),
            atom_radius: Some(0.005),
            atom_mass: Some(2.0),
            rotation,
            ..MoleculeSpec::default()
        };
        let gas = Gas { radius: 0.01, area_fraction: 0.5, side: 1.0 };
        let name = "tee".to_owned();
        Setting { title: name.clone(), words: name.clone(), name, scene: gas.around(spec), body: 0 }
    }

    /// The molecule of a setting.
    pub fn molecule(setting: &Setting) -> Molecule {
        setting.scene.molecule[setting.body].molecule("molecule").unwrap()
    }

    #[test]
    fn the_control_is_a_disc_of_equal_area_and_mass() {
        let tee = tee(Rotation::Free);
        let original = molecule(&tee);
        let control = tee.control(&original);
        let disc = molecule(&control);
        assert!(disc.is_disc() && control.check().is_ok());
        assert!((disc.area() / original.area() - 1.0).abs() < 1e-14 && disc.mass() == original.mass());
        assert!(tee.turns(&original) && !control.turns(&disc));
    }

    #[test]
    fn a_scene_without_equilibrium_is_refused_by_name() {
        type Change = fn(&mut Scene);
        let cases: [(Change, &str); 7] = [
            (|scene| scene.molecule[0].fixed = true, "molecule[0]"),
            (|scene| scene.gas.clear(), "nothing moves"),
            (|scene| scene.gas[0].radius = None, "gas[0]"),
            (|scene| scene.elasticity.default = 0.9, "elasticity"),
            (|scene| scene.stage.push(carom::engine::StageSpec::default()), "stage"),
            (|scene| scene.start.from = Some("x".to_owned()), "start.from"),
            (|scene| scene.run.stop = Some(carom::engine::StopSpec::default()), "run.stop"),
        ];
        for (change, expected) in cases {
            let mut setting = tee(Rotation::Free);
            change(&mut setting.scene);
            let error = setting.check().unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
