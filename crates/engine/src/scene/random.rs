//! Random numbers: a stream for each purpose, random directions, and normal numbers.
//!
//! Normal numbers are drawn in pairs by the method of G. E. P. Box and M. E. Muller, Ann. Math.
//! Stat. 29 (1958) 610: a vector of random direction and length √(−2 ln u), with u uniform from 0
//! to 1. The logarithm is that of `libm`, so that all processors give the same bits.

use carom_kinematics::Orientation;
use glam::DVec2;
use rand::{RngExt, distr::Open01};
use rand_pcg::Pcg64;

/// A stream of random numbers; each purpose has its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RandomStream {
    /// Positions and orientations of the molecules.
    Placement = 0,
    /// Velocities at the start.
    Velocities = 1,
    /// Order and directions while molecules grow (see [`Growth`](crate::Growth)).
    Growth = 2,
    /// Sizes and masses of the molecules (see [`Distribution`](crate::Distribution)).
    Sizes = 3,
    /// Velocities with which bodies leave walls that have a temperature (see
    /// [`WallSpec::temperature`](crate::WallSpec::temperature)).
    Walls = 4,
    /// Places and orientations of the molecules of fixed gases.
    Obstacles = 5,
}

impl RandomStream {
    /// Returns the random generator of this stream: PCG-64 with the state `seed` and the stream
    /// number 16 × `replica` + this stream's number.
    pub fn generator(self, seed: u64, replica: u64) -> Pcg64 {
        Pcg64::new(u128::from(seed), 16 * u128::from(replica) + self as u128)
    }
}

/// Two independent numbers of the standard normal distribution, not both 0.
pub(crate) fn normal_pair(random: &mut Pcg64) -> DVec2 {
    rayleigh(random) * direction(random)
}

/// Those of two uniform numbers: the first above 0 and below 1, the second from 0 to 1.
pub(crate) fn normal_pair_of([length, turns]: [f64; 2]) -> DVec2 {
    rayleigh_of(length) * Orientation::from_turns(turns).cos_sin()
}

/// A random direction.
pub(crate) fn direction(random: &mut Pcg64) -> DVec2 {
    Orientation::from_turns(random.random()).cos_sin()
}

/// A number of Rayleigh's distribution x exp(−x²/2), the length of a pair of normal numbers; above
/// 0.
pub(crate) fn rayleigh(random: &mut Pcg64) -> f64 {
    rayleigh_of(random.sample(Open01))
}

/// That of a uniform number above 0 and below 1.
fn rayleigh_of(uniform: f64) -> f64 {
    (-2.0 * libm::log(uniform)).sqrt()
}
