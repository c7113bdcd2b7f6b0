//! Random numbers for the encounters.

use std::f64::consts::TAU;

use carom_kinematics::Orientation;
use glam::DVec2;
use rand::RngExt as _;
use rand_pcg::Pcg64;

use super::Class;

/// The random numbers of one case.
pub(super) struct Draw(Pcg64);

impl Draw {
    /// Each case of each class has its own stream.
    pub(super) fn new(seed: u64, class: Class, index: u64) -> Self {
        let stream = (u128::from(class.number()) << 64) | u128::from(index);
        Self(Pcg64::new(u128::from(seed), stream))
    }

    /// Uniform from `low` to `high`.
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    /// Log-uniform from `low` to `high`.
    pub(super) fn scale(&mut self, low: f64, high: f64) -> f64 {
        libm::exp(self.between(libm::log(low), libm::log(high)))
    }

    /// True with probability `share`.
    pub(super) fn happens(&mut self, share: f64) -> bool {
        self.0.random::<f64>() < share
    }

    /// 1 or −1.
    pub(super) fn sign(&mut self) -> f64 {
        if self.happens(0.5) { 1.0 } else { -1.0 }
    }

    /// One of several values with equal probability.
    pub(super) fn one_of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.0.random_range(0..choices.len())]
    }

    pub(super) fn orientation(&mut self) -> Orientation {
        Orientation::from_turns(self.between(-0.5, 0.5))
    }

    /// A unit vector.
    pub(super) fn direction(&mut self) -> DVec2 {
        self.orientation().cos_sin()
    }

    /// Normally distributed, mean 0 and variance 1 (Box and Muller 1958).
    pub(super) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * libm::log(1.0 - self.0.random::<f64>())).sqrt();
        radius * libm::cos(TAU * self.0.random::<f64>())
    }
}
