//! The kinds of molecules of the gases of a scene: shape, number, and the speeds that their energy
//! gives them.

use std::sync::Arc;

use carom_geometry::{LARGEST, Molecule, PeriodicBox, check_length};
use carom_kinematics::{Inertia, Motion};
use glam::DVec2;

use crate::{
    GasSpec, Rotation, Scene, SceneError, TagNames, Tags, World,
    body_builder::{geometry, inertia, insert, molecule, tags},
    gas_spec::{MOST_MOLECULES, TWO_ENERGIES},
    limits::refuse_slow,
};

/// The molecules of one gas.
#[derive(Debug, Clone)]
pub(crate) struct Species {
    /// The entry of the scene.
    pub entry: String,
    pub spec: GasSpec,
    pub molecule: Arc<Molecule>,
    pub count: usize,
}

/// The kinds of molecules of the gases of a scene.
pub(crate) fn species(scene: &Scene, bounds: &PeriodicBox) -> Result<Vec<Species>, SceneError> {
    scene.gas.iter().enumerate().map(|(index, spec)| Species::new(spec, index, bounds)).collect()
}

/// A world of the bodies already placed and at most two molecules of each kind, at rest at the
/// origin, and the number of molecules of each kind. The largest and the smallest contact distance
/// do not depend on that number.
pub(crate) fn sample(world: &World, species: &[Species]) -> (World, Vec<usize>) {
    let mut sample = world.clone();
    let counts: Vec<usize> = species.iter().map(|kind| kind.count.min(2)).collect();
    for (kind, &count) in species.iter().zip(&counts) {
        for _ in 0..count {
            let motion = Motion::at_rest(DVec2::ZERO);
            insert(&mut sample, Arc::clone(&kind.molecule), kind.inertia(), Tags::default(), motion);
        }
    }
    (sample, counts)
}

impl Species {
    fn new(spec: &GasSpec, index: usize, bounds: &PeriodicBox) -> Result<Self, SceneError> {
        let entry = format!("gas[{index}]");
        let problem = |problem: &str| SceneError::Entry { entry: entry.clone(), problem: problem.to_owned() };
        let one = |first: Option<f64>, second: Option<f64>, problem_text: &str| match (first, second) {
            (Some(_), Some(_)) => Err(problem(problem_text)),
            _ => Ok(first.or(second)),
        };
        let radius = one(spec.radius, spec.atom_radius, "give either `radius` or `atom_radius`, not both")?;
        let mass = one(spec.mass, spec.atom_mass, "give either `mass` or `atom_mass`, not both")?;
        let shape = if spec.atoms.is_empty() {
            Some(spec.shape.as_deref().unwrap_or("disc"))
        } else {
            spec.shape.as_deref()
        };
        let molecule = molecule(&entry, shape, &spec.atoms, radius, mass)?;
        check_length("energy", spec.energy).map_err(geometry(&entry))?;
        if spec.energy < 0.0 {
            return Err(problem("`energy` must not be negative"));
        }
        if let Some(temperature) = spec.temperature {
            if spec.energy != 0.0 {
                return Err(problem(TWO_ENERGIES));
            }
            if !(0.0..=LARGEST).contains(&temperature) {
                return Err(problem(&format!(
                    "`temperature` must be from 0 to {LARGEST:e} (mass × length² / time²), but is {temperature}"
                )));
            }
        }
        let count = match (spec.area_fraction, spec.count) {
            (None, Some(count)) => count,
            (Some(fraction), None) if (0.0..1.0).contains(&fraction) => {
                let (one, all) = (molecule.area(), bounds.area());
                let count = (fraction * all / one).round() as usize;
                if fraction > 0.0 && count == 0 {
                    return Err(problem(&format!(
                        "`area_fraction` = {fraction} of the box's area {all} is less than half of one \
                         molecule's area {one}: it rounds to 0 molecules"
                    )));
                }
                count
            }
            (Some(_), None) => return Err(problem("`area_fraction` must be at least 0 and below 1")),
            _ => return Err(problem("give either `area_fraction` or `count`")),
        };
        if count > MOST_MOLECULES {
            return Err(problem("there must be at most 2^27 molecules of one kind"));
        }
        let moves = spec.energy > 0.0 || spec.temperature.is_some_and(|temperature| temperature > 0.0);
        if spec.zero_momentum == Some(true) && count == 1 && moves {
            return Err(problem(
                "`zero_momentum` must not be true if `count` is 1: a molecule with `energy` or `temperature` above \
                 0 cannot have momentum 0",
            ));
        }
        let kind = Self { entry, spec: spec.clone(), molecule: Arc::new(molecule), count };
        let freedom = kind.degrees_of_freedom();
        let energy = spec.temperature.map_or(spec.energy, |temperature| 0.5 * freedom * temperature);
        let (speed, spin) = kind.equal_shares(energy);
        kind.check_motion(speed * DVec2::X, spin)?;
        Ok(kind)
    }

    /// Speed and angular velocity of a molecule of this energy, shared equally over its degrees of
    /// freedom (length / time, radians per time).
    pub fn equal_shares(&self, energy: f64) -> (f64, f64) {
        let (share, inertia) = (energy / self.degrees_of_freedom(), self.inertia());
        let speed = (4.0 * share * inertia.inverse_mass).sqrt();
        (speed, if self.turns() { (2.0 * share * inertia.inverse_moment).sqrt() } else { 0.0 })
    }

    /// Refuses a molecule that moves or turns too fast or too slowly to compute with.
    pub fn check_motion(&self, velocity: DVec2, angular_velocity: f64) -> Result<(), SceneError> {
        let [speed, spin] = if self.spec.temperature.is_some() {
            ["the speed that `temperature` gives", "the angular velocity that `temperature` gives"]
        } else {
            ["the speed that `energy` gives", "the angular velocity that `energy` gives"]
        };
        for component in velocity.to_array() {
            check_length(speed, component).map_err(geometry(&self.entry))?;
        }
        check_length(spin, angular_velocity).map_err(geometry(&self.entry))?;
        let motion = Motion { velocity, angular_velocity, ..Motion::at_rest(DVec2::ZERO) };
        refuse_slow(&self.entry, &motion, self.molecule.bounding_radius())
    }

    /// Mass and moment of inertia of one molecule.
    pub fn inertia(&self) -> Inertia {
        inertia(&self.molecule, self.spec.rotation)
    }

    /// Whether contacts change the angular velocity of the molecules.
    pub fn turns(&self) -> bool {
        self.spec.rotation == Rotation::Free && !self.molecule.is_round()
    }

    /// Degrees of freedom of one molecule that contacts change: 2, or 3 if it turns.
    pub fn degrees_of_freedom(&self) -> f64 {
        if self.turns() { 3.0 } else { 2.0 }
    }

    /// Number of molecules that contacts turn: all or none.
    pub fn turning(&self) -> usize {
        if self.turns() { self.count } else { 0 }
    }

    /// Mass of all molecules.
    pub fn mass(&self) -> f64 {
        self.count as f64 / self.inertia().inverse_mass
    }

    /// Area of all molecules (length²).
    pub fn area(&self) -> f64 {
        self.count as f64 * self.molecule.area()
    }

    /// Adds the molecules with these motions to a world.
    pub fn insert(&self, world: &mut World, names: &mut TagNames, motions: impl Iterator<Item = Motion>) {
        let (inertia, tags) = (self.inertia(), tags(names, &self.spec.tags));
        for motion in motions {
            insert(world, Arc::clone(&self.molecule), inertia, tags.clone(), motion);
        }
    }
}
