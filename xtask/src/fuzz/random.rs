//! The random numbers of one case: a stream that depends only on its seed.

use std::f64::consts::TAU;

use glam::DVec2;
use rand::RngExt as _;
use rand_pcg::Pcg64;

/// Seeds have 63 bits, so that TOML can represent them.
const SEED_MASK: u64 = u64::MAX >> 1;

/// Seed of case number `index` of a run (SplitMix64; Steele, Lea and Flood 2014).
///
/// ```
/// use xtask::fuzz::random::case_seed;
///
/// assert_ne!(case_seed(1, 0), case_seed(1, 1));
/// assert_ne!(case_seed(1, 0), case_seed(2, 0));
/// ```
pub fn case_seed(run: u64, index: u64) -> u64 {
    let mix = |z: u64| {
        let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    };
    mix(mix(run).wrapping_add(index.wrapping_mul(0x9E37_79B9_7F4A_7C15))) & SEED_MASK
}

/// Random numbers of one case.
#[derive(Debug)]
pub struct FuzzDraw(Pcg64);

impl FuzzDraw {
    /// The stream of a case.
    pub fn new(seed: u64) -> Self {
        Self(Pcg64::new(u128::from(seed), 0x5eed))
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0.random()
    }

    /// Uniform between `low` and `high`.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    /// Uniform in its logarithm between `low` and `high`, both positive.
    pub fn scale(&mut self, low: f64, high: f64) -> f64 {
        libm::exp(self.between(libm::log(low), libm::log(high))).clamp(low, high)
    }

    /// An integer from `low` to `high`, both included.
    pub fn integer(&mut self, low: i64, high: i64) -> i64 {
        self.0.random_range(low..=high)
    }

    /// An index below `count`, which must be positive.
    pub fn index(&mut self, count: usize) -> usize {
        self.0.random_range(0..count)
    }

    /// True with this probability.
    pub fn happens(&mut self, probability: f64) -> bool {
        self.0.random::<f64>() < probability
    }

    /// 1 or −1.
    pub fn sign(&mut self) -> f64 {
        if self.happens(0.5) { 1.0 } else { -1.0 }
    }

    /// One of several values.
    pub fn one_of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.index(choices.len())]
    }

    /// A unit vector.
    pub fn direction(&mut self) -> DVec2 {
        let (sin, cos) = libm::sincos(self.between(0.0, TAU));
        DVec2::new(cos, sin)
    }

    /// Normally distributed with mean 0 and variance 1 (Box and Muller 1958).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * libm::log(1.0 - self.0.random::<f64>())).sqrt();
        radius * libm::cos(TAU * self.0.random::<f64>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stream_depends_only_on_its_seed() {
        let numbers = |seed| {
            let mut draw = FuzzDraw::new(seed);
            [draw.bits(), draw.bits(), draw.normal().to_bits()]
        };
        assert_eq!(numbers(7), numbers(7));
        assert_ne!(numbers(7), numbers(8));
    }

    #[test]
    fn seeds_of_cases_differ_and_fit_into_63_bits() {
        let mut seeds: Vec<u64> = (0..1000).map(|index| case_seed(3, index)).collect();
        assert!(seeds.iter().all(|&seed| i64::try_from(seed).is_ok()));
        seeds.sort_unstable();
        seeds.dedup();
        assert_eq!(seeds.len(), 1000);
    }
}
