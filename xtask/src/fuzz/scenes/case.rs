//! A fuzz case: a scene, the durations of its runs, and the edits between them.

use std::collections::BTreeSet;

use carom::engine::{
    Body, BodyKey, EditError, ElasticityRule, ElasticitySpec, GravitySpec, MoleculeSpec,
    PistonSpec, Rotation, Scene, TransparentSpec, View, WallMotionSpec, WallSpec, WellSpec,
};
use carom_methods::AnySimulation;
use serde::{Deserialize, Serialize};

/// A case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SceneCase {
    /// Class of the scene.
    pub class: String,
    /// Seed of the times between events at which all pairs are examined.
    pub seed: u64,
    /// The runs and the edits after them.
    pub stretch: Vec<RunStretch>,
    /// The initial scene.
    pub scene: Scene,
}

/// A run and the edits at its end.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct RunStretch {
    /// Duration (time).
    pub duration: f64,
    /// Edits at its end.
    #[serde(default)]
    pub edits: Vec<CaseEdit>,
}

/// An edit of the system. Bodies are numbered in the order of the system at that time, modulo their
/// number.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CaseEdit {
    /// Adds a molecule.
    Add(Box<MoleculeSpec>),
    /// Adds a wall.
    AddWall(Box<WallSpec>),
    /// Removes a body.
    Remove(usize),
    /// Sets the energy of a body to a multiple of that of the first moving body.
    Energy(usize, f64),
    /// Reverses all velocities.
    Reverse,
    /// Locks the orientation of a body.
    Lock(usize),
    /// Unlocks the orientation of a body.
    Free(usize),
    /// Sets the rules of elasticity.
    Elasticity(ElasticitySpec),
    /// Tags a body.
    Tag(usize, String),
    /// Removes a tag.
    Untag(usize, String),
    /// Sets the pairs of tags that do not see each other.
    Transparent(Vec<TransparentSpec>),
    /// Sets the wells.
    Wells(Vec<WellSpec>),
    /// Sets the drag (1 / time).
    Drag(f64),
    /// Gives a wall a motion. Walls are numbered like bodies.
    MoveWall(usize, Box<WallMotionSpec>),
    /// Sets the gravity (length per time²).
    Gravity([f64; 2]),
    /// Sets the force on a piston (mass × length / time²). Pistons are numbered like bodies.
    Push(usize, f64),
}

impl CaseEdit {
    /// The wall that the edit, which has been made, gives a motion, and the motion; `None` if it
    /// gives none.
    pub fn moved_wall(&self, view: &View<'_>) -> Option<(BodyKey, &WallMotionSpec)> {
        let newest = || view.bodies().last().map(|body| body.body.key());
        match self {
            Self::MoveWall(index, motion) => Some((wall(view, *index), motion)),
            Self::AddWall(spec) => Some((newest()?, spec.motion.as_ref()?)),
            _ => None,
        }
    }

    /// Applies the edit.
    ///
    /// # Errors
    /// The system refuses it.
    pub fn apply(&self, simulation: &mut AnySimulation) -> Result<(), EditError> {
        let key = |index: usize| {
            let view = simulation.view();
            let count = view.len().max(1);
            view.bodies()
                .nth(index % count)
                .map(|body| body.body.key())
                .unwrap_or_default()
        };
        match self {
            Self::Add(spec) => simulation.add(spec).map(|_| ()),
            Self::AddWall(spec) => simulation.add_wall(spec).map(|_| ()),
            Self::Remove(index) => simulation.remove(key(*index)),
            Self::Energy(index, factor) => {
                let energies = simulation
                    .view()
                    .bodies()
                    .map(|body| body.energy())
                    .collect::<Vec<_>>();
                let energy = energies
                    .into_iter()
                    .find(|&energy| energy > 0.0)
                    .unwrap_or(1.0);
                simulation.reset_energy(key(*index), factor * energy)
            }
            Self::Reverse => {
                simulation.reverse();
                Ok(())
            }
            Self::Lock(index) => simulation.set_rotation(key(*index), Rotation::Locked),
            Self::Free(index) => simulation.set_rotation(key(*index), Rotation::Free),
            Self::Elasticity(spec) => simulation.set_elasticity(spec),
            Self::Tag(index, name) => simulation.tag(key(*index), name).map(|_| ()),
            Self::Untag(index, name) => simulation.untag(key(*index), name),
            Self::Transparent(rules) => simulation.edit(|batch| batch.set_transparent(rules)),
            Self::Wells(wells) => simulation.edit(|batch| batch.set_wells(wells)),
            Self::Drag(drag) => simulation.edit(|batch| batch.set_drag(*drag)),
            Self::MoveWall(index, motion) => {
                let key = wall(&simulation.view(), *index);
                simulation.edit(|batch| batch.move_wall(key, motion))
            }
            Self::Gravity(gravity) => simulation.set_gravity(*gravity),
            Self::Push(index, force) => {
                let key = piston(&simulation.view(), *index);
                simulation.edit(|batch| batch.push_piston(key, *force))
            }
        }
    }
}

impl SceneCase {
    /// Cases with fewer runs, edits and bodies, or with simpler numbers.
    pub fn simpler(&self) -> Vec<Self> {
        let mut variants = Variants {
            original: self,
            list: Vec::new(),
        };
        variants.remove_runs();
        variants.remove_bodies();
        variants.simplify_rules();
        variants.remove_roughness();
        variants.remove_pairs();
        variants.remove_motions();
        variants.remove_pistons();
        variants.simplify_molecules();
        variants.list
    }
}

/// The wall of a number, modulo their number without pistons; the handle of no body if there is
/// none.
fn wall(view: &View<'_>, index: usize) -> BodyKey {
    numbered(view, index, |body| body.is_wall() && !body.is_piston())
}

/// The piston of a number, modulo their number; the handle of no body if there is none.
pub fn piston(view: &View<'_>, index: usize) -> BodyKey {
    numbered(view, index, Body::is_piston)
}

/// The body of a number among those of a kind, modulo their number.
fn numbered(view: &View<'_>, index: usize, is_meant: impl Fn(&Body) -> bool) -> BodyKey {
    let keys = view.bodies().filter(|body| is_meant(body.body));
    let keys: Vec<BodyKey> = keys.map(|body| body.body.key()).collect();
    keys.get(index % keys.len().max(1))
        .copied()
        .unwrap_or_default()
}

/// Changed copies of a case.
struct Variants<'a> {
    original: &'a SceneCase,
    list: Vec<SceneCase>,
}

impl Variants<'_> {
    /// Adds a changed copy, unless it equals the original.
    fn with(&mut self, change: impl FnOnce(&mut SceneCase)) {
        let mut case = self.original.clone();
        change(&mut case);
        drop_unknown_pairs(&mut case.scene);
        if case != *self.original {
            self.list.push(case);
        }
    }

    /// Fewer runs and edits.
    fn remove_runs(&mut self) {
        for count in 1..self.original.stretch.len() {
            self.with(|case| case.stretch.truncate(count));
        }
        for index in 0..self.original.stretch.len() {
            self.with(|case| case.stretch[index].edits.clear());
            for edit in 0..self.original.stretch[index].edits.len() {
                self.with(|case| {
                    case.stretch[index].edits.remove(edit);
                });
            }
        }
    }

    /// Fewer molecules, bumpers, walls and gases.
    fn remove_bodies(&mut self) {
        let count = self.original.scene.molecule.len();
        for width in [count / 2, count / 4, 1] {
            for begin in (0..count).step_by(width.max(1)) {
                self.with(|case| {
                    case.scene.molecule.drain(begin..(begin + width).min(count));
                });
            }
        }
        for index in 0..self.original.scene.bumper.len() {
            self.with(|case| {
                case.scene.bumper.remove(index);
            });
        }
        for index in 0..self.original.scene.wall.len() {
            self.with(|case| {
                case.scene.wall.remove(index);
            });
        }
        self.with(|case| case.scene.gas.clear());
        for index in 0..self.original.scene.gas.len() {
            self.with(|case| {
                case.scene.gas[index].count = case.scene.gas[index].count.map(|count| count / 2);
            });
        }
    }

    /// Simpler rules of elasticity, and a shorter last run.
    fn simplify_rules(&mut self) {
        self.with(|case| case.scene.elasticity.pair.clear());
        self.with(|case| {
            case.scene.elasticity.contact_time = ElasticitySpec::default().contact_time;
        });
        self.with(|case| case.scene.elasticity.default = 1.0);
        for factor in [0.1, 0.5, 0.8, 0.95] {
            self.with(|case| {
                if let Some(last) = case.stretch.last_mut() {
                    last.duration = shortened(factor * last.duration, 2);
                }
            });
        }
    }

    /// Fewer and simpler rules of rough contacts, and of restitution by speed.
    fn remove_roughness(&mut self) {
        self.with(|case| {
            let elasticity = &mut case.scene.elasticity;
            let smooth = ElasticityRule::default();
            (elasticity.tangential, elasticity.friction) = (smooth.tangential, smooth.friction);
            for rule in &mut elasticity.pair {
                let (between, coefficient) = (rule.between.clone(), rule.coefficient.clone());
                *rule = ElasticityRule {
                    between,
                    coefficient,
                    ..smooth.clone()
                };
            }
            // Discs without rough contacts have no spin.
            for molecule in &mut case.scene.molecule {
                molecule.angular_velocity = 0.0;
            }
        });
        self.with(|case| case.scene.elasticity.friction = None);
        self.with(|case| case.scene.elasticity.tangential = -1.0);
        self.with(|case| case.scene.elasticity.tangential = 1.0);
        for index in 0..self.original.scene.elasticity.pair.len() {
            self.with(|case| {
                case.scene.elasticity.pair.remove(index);
            });
            self.with(|case| case.scene.elasticity.pair[index].coefficient = 1.0.into());
            self.with(|case| case.scene.elasticity.pair[index].tangential = -1.0);
            self.with(|case| case.scene.elasticity.pair[index].tangential = 1.0);
            self.with(|case| case.scene.elasticity.pair[index].friction = None);
            self.with(|case| case.scene.elasticity.pair[index].kick = 0.0);
        }
    }

    /// Fewer rules for pairs of tags, and no drag.
    fn remove_pairs(&mut self) {
        self.with(|case| case.scene.transparent.clear());
        self.with(|case| case.scene.diameter.clear());
        self.with(|case| case.scene.well.clear());
        self.with(|case| case.scene.bond.clear());
        for index in 0..self.original.scene.bond.len() {
            self.with(|case| {
                case.scene.bond.remove(index);
            });
        }
        for index in 0..self.original.scene.well.len() {
            self.with(|case| {
                case.scene.well.remove(index);
            });
            self.with(|case| case.scene.well[index].steps.truncate(1));
        }
        for index in 0..self.original.scene.transparent.len() {
            self.with(|case| {
                case.scene.transparent.remove(index);
            });
        }
        for index in 0..self.original.scene.diameter.len() {
            self.with(|case| {
                case.scene.diameter.remove(index);
            });
            self.with(|case| {
                case.scene.diameter[index].factor = shortened(case.scene.diameter[index].factor, 1);
            });
        }
        self.with(|case| case.scene.bounds.drag = 0.0);
        self.with(|case| case.scene.bounds.drag = shortened(case.scene.bounds.drag, 1));
    }

    /// Fewer and simpler motions of walls, and no gravity or a simpler one.
    fn remove_motions(&mut self) {
        self.with(|case| case.scene.gravity = GravitySpec::default());
        for axis in 0..2 {
            self.with(|case| case.scene.gravity.acceleration[axis] = 0.0);
            self.with(|case| {
                let component = &mut case.scene.gravity.acceleration[axis];
                *component = shortened(*component, 1);
            });
        }
        for index in 0..self.original.scene.wall.len() {
            self.with(|case| case.scene.wall[index].motion = None);
            let mut with = |change: fn(&mut WallMotionSpec)| {
                self.with(|case| {
                    case.scene.wall[index].motion.as_mut().map(change);
                });
            };
            with(|motion| motion.velocity = [0.0; 2]);
            with(|motion| motion.turn = 0.0);
            with(|motion| motion.about = None);
            with(|motion| motion.phase = 0.0);
            with(|motion| motion.repeat = false);
            with(|motion| {
                motion.times.pop();
                motion.places.pop();
            });
            with(|motion| {
                let places = motion.places.iter_mut().flatten();
                let numbers = motion.times.iter_mut().chain(places);
                numbers.for_each(|number| *number = shortened(*number, 1));
            });
            with(|motion| {
                let pairs = [&mut motion.velocity, &mut motion.amplitude];
                let single = [&mut motion.turn, &mut motion.frequency, &mut motion.phase];
                for number in pairs.into_iter().flatten().chain(single) {
                    *number = shortened(*number, 1);
                }
            });
            with(|motion| motion.about = motion.about.map(|at| at.map(|x| shortened(x, 1))));
        }
    }

    /// Fewer and simpler pistons.
    fn remove_pistons(&mut self) {
        for index in 0..self.original.scene.piston.len() {
            self.with(|case| {
                case.scene.piston.remove(index);
            });
            let mut with = |change: fn(&mut PistonSpec)| {
                self.with(|case| change(&mut case.scene.piston[index]));
            };
            with(|piston| piston.force = 0.0);
            with(|piston| (piston.spring, piston.relaxed_at) = (0.0, None));
            with(|piston| piston.relaxed_at = None);
            with(|piston| piston.velocity = 0.0);
            with(|piston| piston.radius = 0.0);
            with(|piston| piston.stop_elasticity = 1.0);
            with(|piston| piston.tags.clear());
            with(|piston| {
                let numbers = [&mut piston.mass, &mut piston.force, &mut piston.velocity];
                let numbers = numbers.into_iter().chain([&mut piston.spring]);
                let optional = [&mut piston.x, &mut piston.y, &mut piston.relaxed_at];
                let optional = optional.into_iter().flatten();
                let stops = piston.stops.iter_mut().flatten();
                let all = numbers.chain(optional).chain(stops);
                all.chain([&mut piston.radius])
                    .for_each(|number| *number = shortened(*number, 1));
            });
        }
    }

    /// Molecules with simpler numbers and fewer atoms.
    fn simplify_molecules(&mut self) {
        for index in 0..self.original.scene.molecule.len() {
            self.with(|case| case.scene.molecule[index].tags.clear());
            self.with(|case| case.scene.molecule[index].angular_velocity = 0.0);
            self.with(|case| case.scene.molecule[index].velocity = [0.0; 2]);
            self.with(|case| case.scene.molecule[index].orientation_turns = None);
            for digits in [1, 3] {
                self.with(|case| {
                    let molecule = &mut case.scene.molecule[index];
                    for number in [&mut molecule.at, &mut molecule.velocity]
                        .into_iter()
                        .flatten()
                    {
                        *number = shortened(*number, digits);
                    }
                });
                self.with(|case| {
                    let molecule = &mut case.scene.molecule[index];
                    molecule.angular_velocity = shortened(molecule.angular_velocity, digits);
                    molecule.orientation_turns = molecule
                        .orientation_turns
                        .map(|turns| shortened(turns, digits));
                    molecule.atom_radius =
                        molecule.atom_radius.map(|radius| shortened(radius, digits));
                    molecule.atom_mass = molecule.atom_mass.map(|mass| shortened(mass, digits));
                    molecule.size = molecule.size.map(|size| shortened(size, digits));
                });
            }
            for corner in 0..self.original.scene.molecule[index].polygon.len() {
                self.with(|case| {
                    case.scene.molecule[index].polygon.remove(corner);
                });
            }
            for edge in 0..self.original.scene.molecule[index].edges.len() {
                self.with(|case| {
                    case.scene.molecule[index].edges.remove(edge);
                });
            }
            for ellipse in 0..self.original.scene.molecule[index].ellipses.len() {
                self.with(|case| {
                    case.scene.molecule[index].ellipses.remove(ellipse);
                });
            }
            for atom in 0..self.original.scene.molecule[index].atoms.len() {
                self.with(|case| {
                    case.scene.molecule[index].atoms.remove(atom);
                });
            }
        }
    }
}

/// Removes the rules for pairs of tags that no body carries: they have no effect, and the engine
/// refuses them.
pub fn drop_unknown_pairs(scene: &mut Scene) {
    let of_molecules = scene.molecule.iter().map(|spec| &spec.tags);
    let known: BTreeSet<String> = of_molecules
        .chain(scene.bumper.iter().map(|spec| &spec.tags))
        .chain(scene.wall.iter().map(|spec| &spec.tags))
        .chain(scene.piston.iter().map(|spec| &spec.tags))
        .chain(scene.gas.iter().map(|spec| &spec.tags))
        .flatten()
        .cloned()
        .collect();
    let is_known = |between: &[String]| between.iter().all(|tag| known.contains(tag));
    scene.transparent.retain(|rule| is_known(&rule.between));
    scene.diameter.retain(|rule| is_known(&rule.between));
    scene.well.retain(|rule| is_known(&rule.between));
}

/// Rounds `x` to `digits` decimal digits after the first.
fn shortened(x: f64, digits: usize) -> f64 {
    if x == 0.0 || !x.is_finite() {
        return x;
    }
    format!("{x:.digits$e}").parse().unwrap_or(x)
}
