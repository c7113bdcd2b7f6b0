//! Velocities of the molecules of a gas at the start: of equal energy, or from Maxwell's
//! distribution.
//!
//! Normal numbers are drawn in pairs by the method of G. E. P. Box and M. E. Muller, Ann. Math.
//! Stat. 29 (1958) 610: a vector of random direction and length √(−2 ln u), with u uniform from 0
//! to 1. The logarithm is that of `libm`, so that all processors give the same bits.
//!
//! Maxwell velocities are scaled to a given energy: at equilibrium, a gas of N molecules with f
//! degrees of freedom is uniform on the sphere of its energy in the space of the f momenta, and f
//! normal numbers divided by their length are uniform on the unit sphere.

use carom_kinematics::Orientation;
use glam::DVec2;
use rand::{RngExt, distr::Open01, seq::SliceRandom};
use rand_pcg::Pcg64;

use crate::{SceneError, StartVelocities, World, centre_of_mass::conserved_momentum, species::Species};

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
        let mass = moving.map(|body| 1.0 / body.inertia().inverse_mass).sum::<f64>();
        Self {
            components: conserved_momentum(singles).bitmask().count_ones(),
            mass: mass + species.iter().map(Species::mass).sum::<f64>(),
        }
    }
}

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
        // By default no momentum where the whole system would otherwise drift forever.
        let opposite = self.spec.zero_momentum.unwrap_or(conserved.components > 0);
        let energy = self.mean_energy(conserved, opposite);
        let (velocities, spins) = match self.spec.velocities {
            StartVelocities::EqualEnergy => self.equal_energies(energy, opposite, random)?,
            StartVelocities::Maxwell => self.maxwell(energy, opposite, random)?,
        };
        // No list of angular velocities for molecules that do not turn.
        let spins = spins.into_iter().chain(std::iter::repeat(0.0));
        Ok(velocities.into_iter().zip(spins))
    }

    /// The mean energy of a molecule: that of the scene, or ½ f kT / N (see
    /// [`GasSpec::temperature`](crate::GasSpec::temperature)).
    fn mean_energy(&self, conserved: &ConservedMomentum, opposite: bool) -> f64 {
        let Some(temperature) = self.spec.temperature else { return self.spec.energy };
        let (count, mut freedom) = (self.count as f64, self.degrees_of_freedom());
        if opposite && self.count > 1 {
            freedom -= f64::from(conserved.components) * (self.mass() / conserved.mass) / count;
        }
        0.5 * freedom * temperature
    }

    /// Random directions at one speed and, for molecules that turn, one angular velocity either
    /// way.
    fn equal_energies(
        &self,
        energy: f64,
        opposite: bool,
        random: &mut Pcg64,
    ) -> Result<(Vec<DVec2>, Vec<f64>), SceneError> {
        let (speed, spin) = self.equal_shares(energy);
        self.check_motion(speed * DVec2::X, spin)?;
        let mut velocities = if opposite {
            opposite_directions(self.count, random)
        } else {
            (0..self.count).map(|_| direction(random)).collect()
        };
        velocities.iter_mut().for_each(|velocity| *velocity *= speed);
        let turning = if self.turns() { self.count } else { 0 };
        Ok((velocities, (0..turning).map(|_| either_way(spin, random)).collect()))
    }

    /// Normal numbers, without their mean if the gas has no momentum, scaled to the energy.
    fn maxwell(
        &self,
        energy: f64,
        opposite: bool,
        random: &mut Pcg64,
    ) -> Result<(Vec<DVec2>, Vec<f64>), SceneError> {
        let count = self.count as f64;
        let mut velocities: Vec<DVec2> = (0..self.count).map(|_| normal_pair(random)).collect();
        let turning = if self.turns() { self.count } else { 0 };
        let mut spins: Vec<f64> = (0..turning).map(|_| normal_pair(random).x).collect();
        if opposite && self.count > 1 {
            let mean = velocities.iter().sum::<DVec2>() / count;
            velocities.iter_mut().for_each(|velocity| *velocity -= mean);
        }
        let squares = velocities.iter().map(|velocity| velocity.length_squared()).sum::<f64>()
            + spins.iter().map(|spin| spin * spin).sum::<f64>();
        // All numbers are 0 if there is no molecule, and by a chance of 2⁻¹⁰⁰ if there are two.
        let twice_energy = 2.0 * energy * count / squares.max(f64::MIN_POSITIVE);
        let inertia = self.inertia();
        let speed = (twice_energy * inertia.inverse_mass).sqrt();
        velocities.iter_mut().for_each(|velocity| *velocity *= speed);
        let spin = (twice_energy * inertia.inverse_moment).sqrt();
        spins.iter_mut().for_each(|one| *one *= spin);
        for (index, &velocity) in velocities.iter().enumerate() {
            self.check_motion(velocity, spins.get(index).copied().unwrap_or(0.0))?;
        }
        Ok((velocities, spins))
    }
}

/// Two independent numbers of the standard normal distribution, not both 0.
fn normal_pair(random: &mut Pcg64) -> DVec2 {
    let length = (-2.0 * libm::log(random.sample(Open01))).sqrt();
    length * direction(random)
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

/// This angular velocity, or its opposite.
pub(crate) fn either_way(spin: f64, random: &mut Pcg64) -> f64 {
    if random.random() { spin } else { -spin }
}
