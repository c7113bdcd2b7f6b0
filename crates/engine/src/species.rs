//! The kinds of molecules of the gases of a scene: shape, number, and the motions that their energy
//! gives them.

use std::sync::Arc;

use carom_geometry::{Molecule, PeriodicBox, check_length};
use carom_kinematics::{Inertia, Motion, Orientation};
use glam::DVec2;
use rand::{RngExt, seq::SliceRandom};
use rand_pcg::Pcg64;

use crate::{
    GasSpec, Rotation, Scene, SceneError, TagNames, Tags, World,
    body_builder::{geometry, inertia, insert, molecule, tags},
    limits::refuse_slow,
};

/// Most molecules of one kind. More exceed the memory and soon the range of their counters.
const MOST_MOLECULES: usize = 1 << 27;

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
        if spec.zero_momentum == Some(true) && count == 1 && spec.energy > 0.0 {
            return Err(problem(
                "`zero_momentum` must not be true if `count` is 1: a molecule with `energy` above 0 cannot have momentum 0",
            ));
        }
        let inertia = inertia(&molecule, spec.rotation);
        let motion = Motion {
            velocity: speed(share(spec, &molecule), &inertia) * DVec2::X,
            angular_velocity: if turns(spec, &molecule) {
                spin(share(spec, &molecule), &inertia)
            } else {
                0.0
            },
            ..Motion::at_rest(DVec2::ZERO)
        };
        check_length("the speed that `energy` gives", motion.velocity.x).map_err(geometry(&entry))?;
        check_length("the angular velocity that `energy` gives", motion.angular_velocity)
            .map_err(geometry(&entry))?;
        if spec.energy > 0.0 {
            refuse_slow(&entry, &motion, molecule.bounding_radius())?;
        }
        Ok(Self { entry, spec: spec.clone(), molecule: Arc::new(molecule), count })
    }

    /// Mass and moment of inertia of one molecule.
    pub fn inertia(&self) -> Inertia {
        inertia(&self.molecule, self.spec.rotation)
    }

    /// Whether contacts change the angular velocity of the molecules.
    pub fn turns(&self) -> bool {
        turns(&self.spec, &self.molecule)
    }

    /// Area of all molecules (length²).
    pub fn area(&self) -> f64 {
        self.count as f64 * self.molecule.area()
    }

    /// Velocities and angular velocities of all molecules, which have the energy of the scene.
    /// `keeps_momentum`: whether momentum is conserved along an axis.
    pub fn velocities<'a>(
        &'a self,
        keeps_momentum: bool,
        random: &'a mut Pcg64,
    ) -> impl Iterator<Item = (DVec2, f64)> + 'a {
        // Opposite pairs by default where the whole system would otherwise drift forever.
        let directions = if self.spec.zero_momentum.unwrap_or(keeps_momentum) {
            opposite_directions(self.count, random)
        } else {
            (0..self.count).map(|_| direction(random)).collect()
        };
        let (turns, share, inertia) = (self.turns(), share(&self.spec, &self.molecule), self.inertia());
        let (speed, spin) = (speed(share, &inertia), if turns { spin(share, &inertia) } else { 0.0 });
        directions
            .into_iter()
            .map(move |direction| (speed * direction, if turns { either_way(spin, random) } else { 0.0 }))
    }

    /// Adds the molecules with these motions to a world.
    pub fn insert(&self, world: &mut World, names: &mut TagNames, motions: impl Iterator<Item = Motion>) {
        let (inertia, tags) = (self.inertia(), tags(names, &self.spec.tags));
        for motion in motions {
            insert(world, Arc::clone(&self.molecule), inertia, tags.clone(), motion);
        }
    }
}

/// A random direction.
pub(crate) fn direction(random: &mut Pcg64) -> DVec2 {
    Orientation::from_turns(random.random()).cos_sin()
}

/// Random directions with sum 0, in random order: opposite pairs, and for an odd number three
/// directions at a third of a turn. A single one has any direction.
pub(crate) fn opposite_directions(count: usize, random: &mut Pcg64) -> Vec<DVec2> {
    let mut directions = Vec::with_capacity(count);
    if count % 2 == 1 && count > 1 {
        let turns: f64 = random.random();
        let thirds = [0.0, 1.0 / 3.0, 2.0 / 3.0];
        directions.extend(thirds.map(|third| Orientation::from_turns(turns + third).cos_sin()));
    }
    while directions.len() + 1 < count {
        let one = direction(random);
        directions.extend([one, -one]);
    }
    if directions.len() < count {
        directions.push(direction(random));
    }
    // Neighbours in the list are neighbours in space; the shuffle separates the pairs.
    directions.shuffle(random);
    directions
}

/// Whether contacts change the angular velocity of the molecules of a gas.
fn turns(spec: &GasSpec, molecule: &Molecule) -> bool {
    spec.rotation == Rotation::Free && !molecule.is_round()
}

/// The energy of each degree of freedom of a molecule (mass × length² / time²).
fn share(spec: &GasSpec, molecule: &Molecule) -> f64 {
    spec.energy / if turns(spec, molecule) { 3.0 } else { 2.0 }
}

/// The speed at which each of the two directions of motion has this energy (length / time).
fn speed(energy: f64, inertia: &Inertia) -> f64 {
    (4.0 * energy * inertia.inverse_mass).sqrt()
}

/// The angular velocity with this energy (radians per time).
fn spin(energy: f64, inertia: &Inertia) -> f64 {
    (2.0 * energy * inertia.inverse_moment).sqrt()
}

/// This angular velocity, or its opposite.
pub(crate) fn either_way(spin: f64, random: &mut Pcg64) -> f64 {
    if random.random() { spin } else { -spin }
}
