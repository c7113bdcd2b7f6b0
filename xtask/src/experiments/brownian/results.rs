//! Results of the runs: what one run measures, and the kicks of several runs.

use carom::{
    ContactDensity, DirectionHistogram, Molecule, ProjectionHistogram,
    observers::{Blocks, Drift, LedgerPoint, RatePoint, RunningPoint},
};
use carom_tables::Totals;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::experiments::thesis_scene::{Case, Size};

/// Sectors of the histogram of directions: one a degree.
pub const SECTORS: usize = 360;

/// Bins of the distribution of Δp along an axis, and its largest Δp (mass × length / time): six
/// standard deviations of the control.
pub const PROJECTION: (usize, f64) = (96, 12.0);

/// Results of one run.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Measurement {
    /// The molecule.
    pub molecule: Molecule,
    /// Kicks by the gas.
    pub kicks: Kicks,
    /// Directions of the kicks by the gas, by block of time.
    pub directions: Blocks<DirectionHistogram>,
    /// Components of the kicks by the gas along x′ and y′, by block.
    pub projections: [Blocks<ProjectionHistogram>; 2],
    /// Density of the gas at contact, times kT, along the boundary of the excluded region, by
    /// block.
    pub contacts: Blocks<ContactDensity>,
    /// Impulse and displacement of the molecule, including kicks by the bumper, by block.
    pub drift: Blocks<Drift>,
    /// Running averages of the force on the molecule, including the bumper.
    pub averages: Vec<RunningPoint>,
    /// Energy over the whole run.
    pub energy: Vec<LedgerPoint>,
    /// Collisions per body during the measurement.
    pub rates: Vec<RatePoint>,
    /// Their mean and its standard error.
    pub rate: Option<(f64, f64)>,
    /// kT of all bodies (mass × length² / time²): twice the total energy divided by the degrees of
    /// freedom, because the bumper breaks the conservation of momentum.
    pub temperature: f64,
    /// Predicted kT: the initial energy with the same degrees of freedom.
    pub booked_temperature: f64,
    /// Gas discs per area of the box.
    pub density: f64,
    /// Duration of the measurement (time).
    pub duration: f64,
    /// Totals of the whole run.
    pub totals: Totals,
}

/// Kicks of the molecule, by direction in its body frame and by atom.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Kicks {
    /// Number of kicks, by direction of the impulse.
    pub counts: Vec<u64>,
    /// Sum of impulse magnitudes, by direction (mass × length / time).
    pub impulse: Vec<f64>,
    /// Number of kicks on each atom.
    pub by_atom: Vec<u64>,
}

impl Kicks {
    /// Sum of the kicks of several runs.
    pub fn sum<'a>(kicks: impl IntoIterator<Item = &'a Self>) -> Option<Self> {
        kicks.into_iter().cloned().reduce(|mut sum, next| {
            sum.counts.iter_mut().zip(next.counts).for_each(|(total, part)| *total += part);
            sum.impulse.iter_mut().zip(next.impulse).for_each(|(total, part)| *total += part);
            sum.by_atom.iter_mut().zip(next.by_atom).for_each(|(total, part)| *total += part);
            sum
        })
    }

    /// Total number of kicks.
    pub fn hits(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// Total impulse magnitude (mass × length / time).
    pub fn total_impulse(&self) -> f64 {
        self.impulse.iter().sum()
    }
}

/// Sums of the kicks between consecutive samples, in the body frame (mass × length / time).
pub fn increments(averages: &[RunningPoint], from: f64) -> Vec<DVec2> {
    let mut before = DVec2::ZERO;
    let next = |point: &RunningPoint| {
        let sum = point.momentum * (point.time - from);
        let increment = sum - before;
        before = sum;
        increment
    };
    averages.iter().map(next).collect()
}

/// Name of the runs of a case and a size.
pub fn group_name(case: Case, size: Size) -> String {
    format!("{}-{}", case.name(), size.name())
}

/// Name of one run, and of its folder if there are several.
pub fn run_name(case: Case, size: Size, replica: u64) -> String {
    format!("{}-{replica}", group_name(case, size))
}

/// Title of the runs of a case and a size.
pub fn title(case: Case, size: Size) -> String {
    format!("Brownian motion: {}, relative size {}", case.name(), size.name())
}
