//! Pairs of bodies that overlap by more than rounding, searched anew at each sample; there should
//! be none.
//!
//! The depth of a pair is the sum of the radii of the nearest atoms less the distance of their
//! centres (length); it is also given in units of the smaller diameter. The limit of rounding is
//! [`carom_engine::rounding_bound`].

use carom_engine::{Observer, View};
use serde::{Deserialize, Serialize};

/// The largest overlaps of all samples.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::OverlapCheck;
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100")?;
/// let mut simulation = Simulation::new(&scene)?;
/// let mut overlaps = OverlapCheck::default();
/// simulation.run_until(1.0)?;
/// overlaps.sample(&simulation.view());
/// assert_eq!((overlaps.checks(), overlaps.worst_pairs()), (1, 0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct OverlapCheck {
    checks: u64,
    worst_pairs: usize,
    deepest: f64,
    deepest_length: f64,
}

impl OverlapCheck {
    /// The number of samples.
    pub fn checks(&self) -> u64 {
        self.checks
    }

    /// Largest number of overlapping pairs in one sample.
    #[doc(alias = "overlapping_pairs")]
    pub fn worst_pairs(&self) -> usize {
        self.worst_pairs
    }

    /// Deepest overlap, in units of the smaller diameter; it may be due to rounding, without an
    /// overlapping pair.
    #[doc(alias = "max_overlap")]
    pub fn deepest(&self) -> f64 {
        self.deepest
    }

    /// Deepest overlap (length); it may be due to rounding.
    pub fn deepest_length(&self) -> f64 {
        self.deepest_length
    }
}

impl Observer for OverlapCheck {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn sample(&mut self, view: &View<'_>) {
        let census = view.overlaps();
        self.checks += 1;
        self.worst_pairs = self.worst_pairs.max(census.pairs);
        self.deepest = self.deepest.max(census.deepest);
        self.deepest_length = self.deepest_length.max(census.deepest_length);
    }
}
