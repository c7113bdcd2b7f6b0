//! Results of the runs: what one run measures, and the kicks of several runs.

use carom::{
    ContactDensity, DirectionHistogram, Molecule, ProjectionHistogram,
    observers::{Blocks, Drift, LedgerPoint, RatePoint, RunningPoint},
};
use carom_tables::Totals;
use glam::DVec2;
use serde::{Deserialize, Serialize};

/// Sectors of the histogram of directions: one a degree.
pub const SECTORS: usize = 360;

/// Bins of the distribution of Δp along an axis.
pub const PROJECTION_BINS: usize = 96;

/// Half the range of the distribution of Δp, in standard deviations of the Δp of a disc.
const DEVIATIONS: f64 = 6.0;

/// Ends of ranges: 10 to any power times one of these.
const ROUND: [f64; 11] = [1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0];

/// Largest Δp of the distribution (mass × length / time): six standard deviations √(4μkT) of a disc
/// of the molecule's mass, rounded up.
pub fn projection_range(mass: f64, gas_mass: f64, temperature: f64) -> f64 {
    let wanted = DEVIATIONS * (4.0 * temperature * mass * gas_mass / (mass + gas_mass)).sqrt();
    let decade = 10f64.powi(wanted.log10().floor() as i32);
    ROUND.map(|round| round * decade).into_iter().find(|&end| end >= wanted).unwrap_or(wanted)
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_round_and_hold_six_standard_deviations() {
        // The thesis's control: √(4 · 10/11) = 1.907.
        assert_eq!(projection_range(10.0, 1.0, 1.0), 12.0);
        for exponent in -60..60 {
            let kt = 1.37f64.powi(exponent);
            let wanted = 6.0 * (4.0 * kt * 2.0 / 3.0).sqrt();
            let range = projection_range(2.0, 1.0, kt);
            assert!((1.0..1.34).contains(&(range / wanted)), "{range} for {wanted}");
        }
    }
}
