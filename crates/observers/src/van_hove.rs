//! The self part of the van Hove function: how displacements after a lag are distributed.
//!
//! G_s(r, t) is the probability density of the displacement Δ = x(t₀ + t) − x(t₀) of a body at |Δ|
//! = r, averaged over directions, bodies and origins t₀ (Hansen & McDonald 2013, section 7.1): ∫
//! G_s 2π r dr = 1. At equilibrium and long before the first contact it is Gaussian, m/(2π kT t²)
//! exp(−m r² / 2kT t²). Its Fourier transform is F_s(k, t).

use carom_engine::{CollisionReport, Observer, View};
use carom_geometry::{GeometryError, check_positive};
use glam::DVec2;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::{
    Group, Histogram,
    lags::{Clock, LaggedSample, Lags, PairSums},
    moving_frame::MovingFrame,
};

/// Largest number of bins: each lag has its own.
const MAX_BINS: usize = 10_000;

/// Distribution of the displacements of the moving bodies of a group at logarithmic lags.
///
/// Positions are those of the centres of mass without periodic jumps, relative to the centre of
/// mass of all bodies along each axis on which momentum is conserved, and under shear to the flow:
/// it must then receive all contacts. After an edit at a sample call `start`, so that the frame
/// moves on with its new velocity. Samples must be one spacing apart. A body contributes while it
/// exists and belongs to the group.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{DisplacementBins, Group, SelfVanHove};
///
/// // A disc moves along x. The bumper fixes the frame.
/// let disc = r#"
///     [[molecule]]
///     atoms = [{ at = [0, 0], radius = 0.05, mass = 1 }]
///     at = [0.0, 0.0]
///     velocity = [2.0, 0.0]
///     [[bumper]]
///     radius = 0.05
///     at = [0.5, 0.5]
/// "#;
/// let mut simulation = Simulation::new(&Scene::from_toml(disc)?)?;
/// let bins = DisplacementBins { distance: 4.0, bins: 10, spacing: 0.25, longest: 5.0 };
/// let mut distribution = SelfVanHove::new(Group::All, bins)?;
/// for sample in 0..=20 {
///     simulation.observe_until(0.25 * f64::from(sample), &mut distribution)?;
///     distribution.sample(&simulation.view());
/// }
/// // Lag 0.75: it has moved by 1.5, which is in the fourth bin of width 0.4, 18 times.
/// let curve = &distribution.curves()[3];
/// assert_eq!((curve.lag, curve.pairs, curve.counts[3]), (0.75, 18, 18));
/// let ring = std::f64::consts::PI * (1.6f64.powi(2) - 1.2f64.powi(2));
/// assert!((curve.densities[3] - 1.0 / ring).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "van Hove function")]
pub struct SelfVanHove {
    group: Group,
    /// The bins, without counts.
    bins: Histogram,
    clock: Clock,
    frame: MovingFrame,
    lags: Lags<DVec2, Distances>,
}

/// The bins and times of a [`SelfVanHove`] or a [`DistinctVanHove`](crate::DistinctVanHove).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DisplacementBins {
    /// Largest displacement or distance in the bins (length).
    pub distance: f64,
    /// Number of bins of equal width, 1 to 10 000.
    pub bins: usize,
    /// Time between samples.
    pub spacing: f64,
    /// Longest lag (time); below one spacing it is taken as one spacing.
    pub longest: f64,
}

/// The distribution at one lag.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct VanHoveCurve {
    /// The lag t (time).
    pub lag: f64,
    /// The number of pairs of one body at t₀ and at t₀ + t; they are not independent of each other.
    pub pairs: u64,
    /// The number of pairs in each bin; the others have moved farther.
    pub counts: Vec<u64>,
    /// G_s in each bin (1 / length²).
    pub densities: Vec<f64>,
}

/// A length, time or number of bins that is out of range.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum DisplacementBinsError {
    /// A length or time is not positive and finite.
    #[error(transparent)]
    NotPositive(#[from] GeometryError),
    /// The number of bins is 0 or too large.
    #[error("the number of bins must be 1 to {MAX_BINS}, but is {bins}")]
    Bins {
        /// The number given.
        bins: usize,
    },
}

/// Counts of displacements at one lag.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Distances(Histogram);

impl PairSums<DVec2> for Distances {
    fn add(&mut self, before: &DVec2, now: &DVec2) {
        self.0.add((*now - *before).length());
    }
}

impl DisplacementBins {
    /// The bins without counts.
    pub(crate) fn empty(&self) -> Result<Histogram, DisplacementBinsError> {
        let distance = check_positive("the largest displacement", self.distance)?;
        if !(1..=MAX_BINS).contains(&self.bins) {
            return Err(DisplacementBinsError::Bins { bins: self.bins });
        }
        Ok(Histogram::new(0.0, distance, self.bins))
    }
}

impl SelfVanHove {
    /// Distributions up to the lag `longest` of samples that are `spacing` apart.
    ///
    /// Lags are 0, 1, 2, …, 9, 10, 20, …, 90, 100, … spacings.
    ///
    /// # Errors
    /// [`DisplacementBinsError`] if a length or time is not positive and finite, or the number of
    /// bins is 0 or above 10 000.
    pub fn new(group: Group, bins: DisplacementBins) -> Result<Self, DisplacementBinsError> {
        let empty = bins.empty()?;
        let (clock, lags) = Lags::with_sums(bins.spacing, bins.longest, &Distances(empty.clone()))?;
        Ok(Self {
            group,
            bins: empty,
            clock,
            frame: MovingFrame::default(),
            lags,
        })
    }

    /// The distributions so far in ascending order of lag, from lag 0 on; lags without pairs are
    /// omitted.
    pub fn curves(&self) -> Vec<VanHoveCurve> {
        let lags = self.lags.each(&self.clock).filter(|(_, sum)| sum.pairs > 0);
        lags.map(|(lag, sum)| {
            let counts = sum.sums.0.counts().to_vec();
            let density = |(bin, &count): (usize, &u64)| count as f64 / self.bins.ring_area(bin);
            VanHoveCurve {
                lag,
                pairs: sum.pairs,
                densities: counts
                    .iter()
                    .enumerate()
                    .map(|bin| density(bin) / sum.pairs as f64)
                    .collect(),
                counts,
            }
        })
        .collect()
    }

    /// Centre of each bin (length).
    pub fn distances(&self) -> Vec<f64> {
        let bins = self.bins.counts().len();
        (0..bins).map(|bin| self.bins.centre(bin)).collect()
    }

    /// Width of the bins (length).
    pub fn width(&self) -> f64 {
        self.bins.width()
    }

    /// All lags (time) in ascending order, from lag 0 on, also those without pairs.
    pub fn lags(&self) -> Vec<f64> {
        self.lags.times(&self.clock)
    }

    /// [Σx, Σw] over all samples so far, w the number of pairs: G_s (1 / length²) in each bin at
    /// the lag of this place in [`lags`](Self::lags); empty beyond the last.
    pub fn sums_at(&self, place: usize) -> Vec<[f64; 2]> {
        let Some((_, sum)) = self.lags.each(&self.clock).nth(place) else {
            return Vec::new();
        };
        let of = |(bin, &count): (usize, &u64)| {
            [count as f64 / self.bins.ring_area(bin), sum.pairs as f64]
        };
        sum.sums.0.counts().iter().enumerate().map(of).collect()
    }

    /// The number of samples that were not one spacing after the previous sample, to one part in a
    /// million.
    ///
    /// An early sample is skipped. After a late sample no lag crosses the gap; earlier averages are
    /// kept.
    pub fn uneven(&self) -> u64 {
        self.lags.uneven()
    }
}

impl Observer for SelfVanHove {
    #[inline]
    fn watches_any(&self) -> bool {
        self.frame.is_flowing()
    }

    fn start(&mut self, view: &View<'_>) {
        self.frame.follow(view);
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.frame.collide(report);
    }

    fn sample(&mut self, view: &View<'_>) {
        self.frame.follow(view);
        if !self.lags.is_due(&self.clock, view.time()) {
            return;
        }
        let now: Vec<LaggedSample<DVec2>> = self
            .frame
            .places(view, self.group)
            .map(|(body, state)| LaggedSample {
                id: body.body.id(),
                state,
            })
            .collect();
        self.lags.take(&mut self.clock, view.time(), &now);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_engine::{Scene, Simulation};

    /// Bodies that pass through each other, against the integral of the Gaussian over each ring.
    #[test]
    fn a_transparent_gas_is_gaussian() {
        let count = 20_000.0;
        let scene = format!(
            "[box]\nsides = [9.0, 9.0]\nseed = 3\n[[transparent]]\nbetween = [\"gas\"]\n[[gas]]\nradius = 0.001\n\
             mass = 2.0\ntemperature = 3.0\nvelocities = \"maxwell\"\ncount = {count}\ntags = [\"gas\"]\n"
        );
        let mut simulation = Simulation::new(&Scene::from_toml(&scene).unwrap()).unwrap();
        let variance = simulation.view().temperature().unwrap() / 2.0;
        let bins = DisplacementBins {
            distance: 12.0,
            bins: 60,
            spacing: 1.0,
            longest: 3.0,
        };
        let mut distribution = SelfVanHove::new(Group::All, bins).unwrap();
        for sample in 0..=3 {
            simulation.run_until(f64::from(sample)).unwrap();
            distribution.sample(&simulation.view());
        }
        let curves = distribution.curves();
        assert_eq!(curves.len(), 4);
        // At lag 0 all displacements are 0.
        assert_eq!(curves[0].counts[0], 4 * 20_000);
        for curve in &curves[1..] {
            let beyond =
                |edge: f64| f64::exp(-0.5 * edge * edge / (variance * curve.lag * curve.lag));
            for (bin, &density) in curve.densities.iter().enumerate() {
                let edges = [bin as f64, bin as f64 + 1.0].map(|edge| 0.2 * edge);
                let share = beyond(edges[0]) - beyond(edges[1]);
                let area = std::f64::consts::PI * (edges[1] * edges[1] - edges[0] * edges[0]);
                // Velocities are constant: as many independent displacements as bodies.
                let error = (share / count).sqrt() + 1.0 / count;
                assert!(
                    (density * area - share).abs() < 5.0 * error,
                    "{} {bin}: {} {share}",
                    curve.lag,
                    density * area
                );
            }
        }
        let sums = distribution.sums_at(2);
        assert_eq!(sums.len(), 60);
        assert_eq!(sums[7][0] / sums[7][1], curves[2].densities[7]);
        assert!(distribution.sums_at(4).is_empty());
        assert_eq!(distribution.uneven(), 0);
    }

    #[test]
    fn bins_out_of_range_are_refused_with_their_values() {
        let given = DisplacementBins {
            distance: 1.0,
            bins: 10,
            spacing: 0.1,
            longest: 1.0,
        };
        let error = |bins: DisplacementBins| {
            SelfVanHove::new(Group::All, bins)
                .err()
                .map_or_else(String::new, |error| error.to_string())
        };
        assert_eq!(error(given), "");
        for bins in [0, 10_001] {
            let said = error(DisplacementBins { bins, ..given });
            assert!(
                said.contains(&format!("1 to 10000, but is {bins}")),
                "{said}"
            );
        }
        for refused in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let distance = DisplacementBins {
                distance: refused,
                ..given
            };
            let spacing = DisplacementBins {
                spacing: refused,
                ..given
            };
            assert!(!error(distance).is_empty() && !error(spacing).is_empty());
        }
    }
}
