//! Velocities of the molecules of a gas at the start: of equal energy, or from Maxwell's
//! distribution.
//!
//! Maxwell velocities are scaled to a given energy: at equilibrium, a gas of N molecules with f
//! degrees of freedom is uniform on the sphere of its energy in the space of the f momenta, and f
//! normal numbers divided by their length are uniform on the unit sphere.

use carom_kinematics::{Inertia, Orientation};
use glam::DVec2;
use rand::{RngExt, seq::SliceRandom};
use rand_pcg::Pcg64;

use crate::{
    scene::{
        error::SceneError,
        gas_spec::StartVelocities,
        random::{direction, normal_pair},
    },
    start::species::Species,
    world::{World, centre_of_mass::conserved_momentum},
};

/// The momentum that a scene conserves, on which the velocities at the start depend.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ConservedMomentum {
    /// Number of axes along which momentum is conserved.
    components: u32,
    /// Mass of all bodies that move.
    mass: f64,
}

impl ConservedMomentum {
    /// The conserved momentum of a scene with these single bodies and these gases.
    pub fn new(singles: &World, species: &[Species]) -> Self {
        let moving = singles.bodies.iter().filter(|body| !body.is_fixed());
        let mass = moving
            .map(|body| 1.0 / body.inertia().inverse_mass)
            .sum::<f64>();
        Self {
            components: conserved_momentum(singles).bitmask().count_ones(),
            mass: mass + species.iter().map(Species::mass).sum::<f64>(),
        }
    }
}

/// What the velocities of a gas must satisfy.
struct Start<'a> {
    kind: &'a Species,
    /// Mean energy of a molecule (mass × length² / time²).
    energy: f64,
    /// Whether the momentum is 0, unless there is only one molecule.
    without_momentum: bool,
}

/// Velocities of all molecules, and their angular velocities if they turn.
type Drawn = (Vec<DVec2>, Vec<f64>);

impl Species {
    /// Velocities and angular velocities of all molecules, as the scene requests.
    ///
    /// # Errors
    /// [`SceneError`] with the name of the entry if a molecule is too fast or too slow.
    pub fn velocities(
        &self,
        conserved: &ConservedMomentum,
        random: &mut Pcg64,
    ) -> Result<impl Iterator<Item = (DVec2, f64)> + use<>, SceneError> {
        let start = Start::new(self, conserved);
        let (velocities, spins) = match self.spec.velocities {
            StartVelocities::EqualEnergy => start.equal_energies(random)?,
            StartVelocities::Maxwell => start.maxwell(random)?,
        };
        Ok(velocities
            .into_iter()
            .zip(spins.into_iter().chain(std::iter::repeat(0.0))))
    }
}

impl<'a> Start<'a> {
    fn new(kind: &'a Species, conserved: &ConservedMomentum) -> Self {
        // By default no momentum where the whole system would otherwise drift forever.
        let without_momentum = kind.spec.zero_momentum.unwrap_or(conserved.components > 0);
        let mut start = Self {
            kind,
            energy: kind.spec.energy,
            without_momentum,
        };
        if let Some(temperature) = kind.spec.temperature {
            // ½ f kT / N, see `GasSpec::temperature`.
            let mut freedom = kind.degrees_of_freedom();
            if start.removes_mean() {
                let share = kind.mass() / conserved.mass;
                freedom -= f64::from(conserved.components) * share / kind.count as f64;
            }
            start.energy = 0.5 * freedom * temperature;
        }
        start
    }

    /// Whether the velocities depend on each other so that their sum is 0. A single molecule moves.
    fn removes_mean(&self) -> bool {
        self.without_momentum && self.kind.count > 1
    }

    /// Random directions at one speed and, for molecules that turn, one angular velocity either
    /// way.
    fn equal_energies(&self, random: &mut Pcg64) -> Result<Drawn, SceneError> {
        let Self {
            kind,
            energy,
            without_momentum,
        } = *self;
        if !kind.is_equal() {
            return self.equal_energies_of_drawn(random);
        }
        let (speed, spin) = kind.equal_shares(0, energy);
        kind.check_motion(0, speed * DVec2::X, spin)?;
        let mut velocities = if without_momentum {
            opposite_directions(kind.count, random)
        } else {
            (0..kind.count).map(|_| direction(random)).collect()
        };
        for velocity in &mut velocities {
            *velocity *= speed;
        }
        let spins = (0..kind.turning())
            .map(|_| either_way(spin, random))
            .collect();
        Ok((velocities, spins))
    }

    /// Random directions, for molecules of different masses. Opposite pairs would not cancel: the
    /// velocity of the centre of mass is subtracted, and all are multiplied by the factor that
    /// restores the energy.
    fn equal_energies_of_drawn(&self, random: &mut Pcg64) -> Result<Drawn, SceneError> {
        let Self { kind, energy, .. } = *self;
        let shares: Vec<(f64, f64)> = (0..kind.count)
            .map(|index| kind.equal_shares(index, energy))
            .collect();
        let velocities = shares
            .iter()
            .map(|(speed, _)| *speed * direction(random))
            .collect();
        let turning = &shares[..kind.turning()];
        let spins = turning
            .iter()
            .map(|&(_, spin)| either_way(spin, random))
            .collect();
        self.without_drift((velocities, spins))
    }

    /// Normal numbers with variances 1/m and 1/I, for molecules of different masses.
    fn maxwell_of_drawn(&self, random: &mut Pcg64) -> Result<Drawn, SceneError> {
        let kind = self.kind;
        let velocity = |index: usize| normal_pair(random) * kind.inertia(index).inverse_mass.sqrt();
        let velocities = (0..kind.count).map(velocity).collect();
        let spin = |index: usize| normal_pair(random).x * kind.inertia(index).inverse_moment.sqrt();
        let spins = (0..kind.turning()).map(spin).collect();
        self.without_drift((velocities, spins))
    }

    /// These velocities, relative to the centre of mass if the gas has no momentum, multiplied by
    /// one factor that gives them the energy of the gas.
    fn without_drift(&self, (mut velocities, mut spins): Drawn) -> Result<Drawn, SceneError> {
        let kind = self.kind;
        let inertia: Vec<Inertia> = (0..kind.count).map(|index| kind.inertia(index)).collect();
        if self.removes_mean() {
            let momentum: DVec2 = velocities
                .iter()
                .zip(&inertia)
                .map(|(&v, i)| v / i.inverse_mass)
                .sum();
            let drift = momentum / kind.mass();
            for velocity in &mut velocities {
                *velocity -= drift;
            }
        }
        let moving: f64 = velocities
            .iter()
            .zip(&inertia)
            .map(|(v, i)| v.length_squared() / i.inverse_mass)
            .sum();
        let turning: f64 = spins
            .iter()
            .zip(&inertia)
            .map(|(spin, i)| spin * spin / i.inverse_moment)
            .sum();
        let twice_energy = 2.0 * self.energy * kind.count as f64;
        // All numbers are 0 without energy.
        let factor = (twice_energy / (moving + turning).max(f64::MIN_POSITIVE)).sqrt();
        for velocity in &mut velocities {
            *velocity *= factor;
        }
        for spin in &mut spins {
            *spin *= factor;
        }
        let all_spins = spins.iter().chain(std::iter::repeat(&0.0));
        for (index, (&velocity, &spin)) in velocities.iter().zip(all_spins).enumerate() {
            kind.check_motion(index, velocity, spin)?;
        }
        Ok((velocities, spins))
    }

    /// Normal numbers, without the mean of the velocities if the gas has no momentum, scaled to the
    /// energy.
    fn maxwell(&self, random: &mut Pcg64) -> Result<Drawn, SceneError> {
        let (kind, count) = (self.kind, self.kind.count as f64);
        if !kind.is_equal() {
            return self.maxwell_of_drawn(random);
        }
        let mut velocities: Vec<DVec2> = (0..kind.count).map(|_| normal_pair(random)).collect();
        let mut spins: Vec<f64> = (0..kind.turning()).map(|_| normal_pair(random).x).collect();
        if self.removes_mean() {
            let mean = velocities.iter().sum::<DVec2>() / count;
            for velocity in &mut velocities {
                *velocity -= mean;
            }
        }
        let squares = velocities
            .iter()
            .map(|velocity| velocity.length_squared())
            .sum::<f64>()
            + spins.iter().map(|spin| spin * spin).sum::<f64>();
        // All numbers are 0 if there is no molecule, and by a chance of 2⁻¹⁰⁰ if there are two.
        let twice_energy = 2.0 * self.energy * count / squares.max(f64::MIN_POSITIVE);
        let inertia = kind.inertia(0);
        let speed = (twice_energy * inertia.inverse_mass).sqrt();
        for velocity in &mut velocities {
            *velocity *= speed;
        }
        let spin = (twice_energy * inertia.inverse_moment).sqrt();
        for number in &mut spins {
            *number *= spin;
        }
        for (&velocity, &spin) in velocities
            .iter()
            .zip(spins.iter().chain(std::iter::repeat(&0.0)))
        {
            kind.check_motion(0, velocity, spin)?;
        }
        Ok((velocities, spins))
    }
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

/// This angular velocity, or its opposite.
pub(crate) fn either_way(spin: f64, random: &mut Pcg64) -> f64 {
    if random.random() { spin } else { -spin }
}
