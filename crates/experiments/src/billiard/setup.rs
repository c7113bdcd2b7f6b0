//! The system of a billiard, its random starts, and what integral geometry predicts for it.

use std::f64::consts::TAU;

use anyhow::Result;
use carom::{
    Scene,
    engine::{AtomSpec, BoxSpec, MoleculeSpec, RandomStream, Rotation, RunSpec},
    geometry::{ExcludedRegion, ExposedArc},
};
use clap::ValueEnum;
use glam::DVec2;
use rand::RngExt as _;

use super::{BLOCKS, SECTORS, layout::Obstacles};
use crate::molecule_argument::NamedMolecule;

/// The body that moves; all others are fixed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum Mover {
    /// A disc among fixed molecules
    #[default]
    Disc,
    /// The molecule, free to turn, among fixed discs
    Molecule,
    /// The molecule among fixed discs, each flight in one random orientation
    LockedMolecule,
}

/// Molecule, disc, obstacles, and number of hits.
#[derive(Debug, Clone)]
pub struct Setup {
    /// The molecule.
    pub named: NamedMolecule,
    /// Radius of a disc (length).
    pub disc_radius: f64,
    /// The region around the molecule that a disc's centre cannot enter.
    pub region: ExcludedRegion,
    /// What moves.
    pub mover: Mover,
    /// The obstacles in the box.
    pub obstacles: Obstacles,
    /// Expected number of hits of all flights.
    pub hits: f64,
    /// Seed of all random numbers.
    pub seed: u64,
}

/// Approximate number of hits of one flight. Fewer: the initial condition is not forgotten. More:
/// accumulated rounding exceeds the allowed energy drift.
const HITS_OF_FLIGHT: f64 = 250_000.0;

/// That of a mover that turns: the energy of so few degrees of freedom drifts by some 10⁻¹⁵ at each
/// hit.
const HITS_OF_TURNING_FLIGHT: f64 = 50_000.0;

impl Setup {
    /// Whether hits turn the mover. A round molecule never turns.
    pub fn turns(&self) -> bool {
        self.mover == Mover::Molecule && !self.named.molecule.is_round()
    }

    /// Distance from the centre of an obstacle to that of the mover beyond which they cannot touch
    /// (length).
    fn reach(&self) -> f64 {
        reach(&self.named, self.disc_radius)
    }

    /// Whether all atoms have one radius, and every piece of the boundary is hit with equal
    /// probability: the histogram of directions then has integer levels.
    pub fn has_integer_levels(&self) -> bool {
        let atoms = self.named.molecule.atoms();
        !self.turns() && atoms.iter().all(|atom| atom.radius() == atoms[0].radius())
    }

    /// The number of hits on a piece of the boundary is proportional to this: 1 / √(μ/m), with the
    /// reduced mass μ of the contact and the mass m of the mover.
    fn frequency(&self) -> impl Fn(&ExposedArc, f64) -> f64 {
        let molecule = &self.named.molecule;
        let ratio = if self.turns() { molecule.mass() / molecule.moment_of_inertia() } else { 0.0 };
        // The point of contact and the atom's centre have the same lever arm.
        move |arc, normal| {
            let lever = arc.centre.perp_dot(DVec2::from_angle(normal));
            (1.0 + lever * lever * ratio).sqrt()
        }
    }

    /// Mean path between two hits (length); of a mover that turns, the mean time at energy m/2.
    ///
    /// At equilibrium all states of one energy are equally probable. The velocity of the point of
    /// contact along the normal is w cos α, w² = (2 E/m) (1 + m (r × n)²/I), with a random
    /// direction α in the plane of the two velocities, or in the space of these and √(I/m) ω. The
    /// mean of its positive part is w/π, or w/4, so that the number of hits per time is the
    /// integral of that over the boundary, divided by the free area A − A_excluded.
    pub fn mean_interval(&self) -> f64 {
        let area = self.obstacles.area_of_one();
        if self.turns() {
            4.0 * (area - self.region.area()) / self.region.integral(self.frequency())
        } else {
            self.region.mean_free_path(area)
        }
    }

    /// Predicted share of each sector of directions in the hits.
    pub fn direction_shares(&self) -> Vec<f64> {
        shares(self.region.by_impulse_direction(SECTORS, self.frequency()))
    }

    /// Predicted share of each atom in the hits.
    pub fn atom_shares(&self) -> Vec<f64> {
        shares(self.region.by_atom(self.frequency()))
    }

    /// Number of independent flights; it does not depend on the machine.
    pub fn flights(&self) -> u64 {
        let hits = if self.turns() { HITS_OF_TURNING_FLIGHT } else { HITS_OF_FLIGHT };
        (self.hits / hits).ceil().max(2.0) as u64
    }

    /// Duration of a flight at energy m/2, which is speed 1 without rotation (time).
    pub fn duration(&self) -> f64 {
        self.hits * self.mean_interval() / self.flights() as f64
    }

    /// The scene of one replica: fixed obstacles, and last the mover at a random position with a
    /// random velocity.
    ///
    /// # Errors
    /// No free position was found.
    pub fn scene(&self, replica: u64) -> Result<Scene> {
        let mut random = RandomStream::Placement.generator(self.seed, replica);
        let turned = if self.mover == Mover::Disc { 0.0 } else { TAU * random.random::<f64>() };
        let places = self.obstacles.places(self.reach(), &mut random)?;
        // Turns a vector from an obstacle to the mover into one from the molecule to a disc, in the
        // molecule's frame.
        let turn = if self.mover == Mover::Disc { DVec2::X } else { -DVec2::from_angle(-turned) };
        let is_free = |at: &DVec2| {
            let frame = |place: &DVec2| turn.rotate(self.obstacles.nearest(*at - *place));
            !places.iter().any(|place| self.region.contains(frame(place)))
        };
        let at = self.obstacles.free_place(&mut random, is_free)?;
        let (velocity, angular_velocity) = self.velocity(replica);
        let target = MoleculeSpec { tags: vec!["target".to_owned()], ..self.named.spec.clone() };
        let disc = MoleculeSpec {
            tags: vec!["disc".to_owned()],
            atoms: vec![AtomSpec { at: [0.0; 2], radius: self.disc_radius, mass: 1.0 }],
            ..MoleculeSpec::default()
        };
        let (fixed, mover) = if self.mover == Mover::Disc { (target, disc) } else { (disc, target) };
        let fixed = |place: DVec2| MoleculeSpec { at: place.into(), fixed: true, ..fixed.clone() };
        let mover = MoleculeSpec {
            at: at.into(),
            orientation: (self.mover != Mover::Disc).then_some(turned),
            velocity: velocity.into(),
            angular_velocity,
            rotation: if self.mover == Mover::LockedMolecule { Rotation::Locked } else { Rotation::Free },
            ..mover
        };
        let until = self.duration();
        Ok(Scene {
            bounds: BoxSpec { sides: self.obstacles.sides().into(), seed: self.seed, replica },
            molecule: places.into_iter().map(fixed).chain([mover]).collect(),
            run: RunSpec { until, sample_interval: until / BLOCKS as f64, ..RunSpec::default() },
            ..Scene::default()
        })
    }

    /// Velocity and angular velocity of the mover at energy m/2, in a random direction of the
    /// plane, or of the space of v and √(I/m) ω.
    fn velocity(&self, replica: u64) -> (DVec2, f64) {
        let mut random = RandomStream::Velocities.generator(self.seed, replica);
        let direction = DVec2::from_angle(TAU * random.random::<f64>());
        if !self.turns() {
            return (direction, 0.0);
        }
        let molecule = &self.named.molecule;
        // The projection of a random point of the sphere on an axis is uniform (Archimedes).
        let height = 2.0 * random.random::<f64>() - 1.0;
        let spin = height * (molecule.mass() / molecule.moment_of_inertia()).sqrt();
        ((1.0 - height * height).sqrt() * direction, spin)
    }
}

/// Sum of the radii of molecule and disc (length).
pub fn reach(named: &NamedMolecule, disc_radius: f64) -> f64 {
    named.molecule.bounding_radius() + disc_radius
}

/// Parts relative to their sum.
fn shares(parts: Vec<f64>) -> Vec<f64> {
    let whole: f64 = parts.iter().sum();
    parts.into_iter().map(|part| part / whole).collect()
}
