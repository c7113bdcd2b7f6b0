//! The distinct part of the van Hove function: where the other bodies are after a lag.
//!
//! G_d(r, t) is the mean number of bodies of a group b, by area, at the time t₀ + t at the distance
//! r from the place that a body of a group a had at t₀, without that body itself (Hansen & McDonald
//! 2013, section 7.1). At lag 0 it is ρ g(r), with the pair distribution g and the density ρ of the
//! others; at long lags it is ρ at each distance, since places forget each other. In one group of N
//! bodies in the area A, ρ = (N − 1)/A. With the self part, G_s + G_d is the density of all bodies,
//! whose Fourier transform is F(k, t).

use carom_engine::{Observer, View};
use carom_geometry::PeriodicBox;
use glam::DVec2;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::{
    Group, Histogram,
    cell_list::CellList,
    lags::{Clock, LaggedSample, Lags, PairSums},
    moving_frame::MovingFrame,
    pair_distribution::{CutoffError, check_cutoff},
    van_hove::{DisplacementBins, DisplacementBinsError},
};

/// The first digits of the lags: nearly equal steps of the logarithm. Each costs a search for
/// pairs.
const DIGITS: [u64; 2] = [1, 3];

/// Distinct part of the van Hove function of two groups, or of one with itself, at lags of 0, 1, 3,
/// 10, 30, … spacings; fixed discs and molecules count, walls do not.
///
/// Positions are those of the centres of mass, relative to the centre of mass of all bodies along
/// each axis on which momentum is conserved. After an edit at a sample call `start`, so that the
/// frame moves on with its new velocity. Samples must be one spacing apart. A sample costs about
/// three searches for pairs, as of [`PairDistribution`](crate::PairDistribution), one of them for
/// lag 0. Memory: 24 bytes a body (of each group), 3 times for each decade of lags.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{DisplacementBins, DistinctVanHove, Group};
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 200")?;
/// let mut simulation = Simulation::new(&scene)?;
/// let bins = DisplacementBins { distance: 0.2, bins: 20, spacing: 0.1, longest: 0.3 };
/// let bounds = simulation.view().bounds();
/// let mut distribution = DistinctVanHove::new([Group::All; 2], &bounds, bins)?;
/// for sample in 0..=10 {
///     simulation.observe_until(0.1 * f64::from(sample), &mut distribution)?;
///     distribution.sample(&simulation.view());
/// }
/// // No other disc is nearer than the diameter 0.04 at first; later there is.
/// let curves = distribution.curves();
/// assert_eq!(curves.len(), 3);
/// assert!(curves[0].counts[..4].iter().all(|&count| count == 0));
/// let density = distribution.density().expect("there are samples");
/// assert!((density - 199.0).abs() < 1e-9);
/// assert!((curves[2].densities[3] / density - 1.0).abs() < 0.2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "van Hove function")]
pub struct DistinctVanHove {
    groups: [Group; 2],
    bounds: PeriodicBox,
    /// The bins, without counts.
    bins: Histogram,
    clock: Clock,
    frame: MovingFrame,
    lags: Lags<Configuration, Distances>,
    /// Σ over the samples of the number of ordered pairs / A, and of that of bodies of the first
    /// group.
    density: [f64; 2],
    passed_over: u64,
}

/// The distribution at one lag.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct DistinctCurve {
    /// The lag t (time).
    pub lag: f64,
    /// The number of bodies of the first group, summed over the origins t₀.
    pub bodies: u64,
    /// The number of pairs in each bin.
    pub counts: Vec<u64>,
    /// G_d in each bin (1 / length²).
    pub densities: Vec<f64>,
}

/// A distance, time or number of bins that is out of range.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum DistinctVanHoveError {
    /// A time or the number of bins is out of range.
    #[error(transparent)]
    Bins(#[from] DisplacementBinsError),
    /// The largest distance is not positive, or too long for the box.
    #[error(transparent)]
    Distance(#[from] CutoffError),
}

/// The bodies of both groups at one time.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Configuration {
    first: Members,
    /// `None` for the first group again.
    second: Option<Members>,
}

/// The bodies of a group at one time.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Members {
    ids: Vec<u64>,
    /// In the box (length).
    places: Vec<DVec2>,
}

/// Counts of distances at one lag; `None` at a lag that is left out.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Distances(Option<Counts>);

#[derive(Debug, Clone, Serialize, Deserialize)]
struct Counts {
    bounds: PeriodicBox,
    cutoff: f64,
    distances: Histogram,
    /// Bodies of the first group, summed over the origins.
    bodies: u64,
}

impl PairSums<Configuration> for Distances {
    fn is_counted(&self) -> bool {
        self.0.is_some()
    }

    fn add(&mut self, before: &Configuration, now: &Configuration) {
        let Some(counts) = &mut self.0 else { return };
        let (centres, others) = (&before.first, now.second.as_ref().unwrap_or(&now.first));
        counts.bodies += centres.ids.len() as u64;
        let cells = CellList::for_cutoff(&others.places, &counts.bounds, counts.cutoff);
        for (&id, &place) in centres.ids.iter().zip(&centres.places) {
            cells.for_each_within(place, counts.cutoff, |other, squared| {
                if others.ids[other] != id {
                    counts.distances.add(squared.sqrt());
                }
            });
        }
    }
}

impl DistinctVanHove {
    /// Distances from bodies of the first group at t₀ to those of the second at t₀ + t, in bins up
    /// to `bins.distance`, with lags up to `bins.longest`.
    ///
    /// # Errors
    /// [`DistinctVanHoveError`] if a length or time is not positive and finite, the distance is not
    /// less than half the shorter side of the box, or the number of bins is 0 or above 10 000.
    pub fn new(
        groups: [Group; 2],
        bounds: &PeriodicBox,
        bins: DisplacementBins,
    ) -> Result<Self, DistinctVanHoveError> {
        let empty = bins.empty()?;
        let cutoff = check_cutoff(bounds, bins.distance)?;
        let of_lag = |spacings: u64| {
            let is_counted = spacings == 0 || DIGITS.contains(&first_digit(spacings));
            Distances(is_counted.then(|| Counts {
                bounds: *bounds,
                cutoff,
                distances: empty.clone(),
                bodies: 0,
            }))
        };
        let (clock, lags) = Lags::with_sums_by(bins.spacing, bins.longest, of_lag)
            .map_err(DisplacementBinsError::from)?;
        Ok(Self {
            groups,
            bounds: *bounds,
            bins: empty,
            clock,
            frame: MovingFrame::default(),
            lags,
            density: [0.0; 2],
            passed_over: 0,
        })
    }

    /// The distributions so far in ascending order of lag, from lag 0 on; lags without bodies of
    /// the first group are omitted.
    pub fn curves(&self) -> Vec<DistinctCurve> {
        let lags = self.each().filter(|(_, counts)| counts.bodies > 0);
        lags.map(|(lag, counts)| {
            let density = |(bin, &count): (usize, &u64)| {
                count as f64 / self.bins.ring_area(bin) / counts.bodies as f64
            };
            let counted = counts.distances.counts();
            DistinctCurve {
                lag,
                bodies: counts.bodies,
                densities: counted.iter().enumerate().map(density).collect(),
                counts: counted.to_vec(),
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

    /// ρ: G_d of independent places (1 / length²); `None` without bodies of the first group.
    pub fn density(&self) -> Option<f64> {
        let [pairs, bodies] = self.density;
        (bodies > 0.0).then(|| pairs / bodies)
    }

    /// The lags 0, 1, 3, 10, 30, … spacings (time), also those without pairs.
    pub fn lags(&self) -> Vec<f64> {
        self.each().map(|(lag, _)| lag).collect()
    }

    /// [Σx, Σw] over all samples so far, w = 1 for each body of the first group and origin: G_d
    /// (1 / length²) in each bin at the first of the [lags](Self::lags), then at the next.
    pub fn sums(&self) -> Vec<[f64; 2]> {
        let of_lag = |(_, counts): (f64, &Counts)| {
            let of = |(bin, &count): (usize, &u64)| {
                let density = count as f64 / self.bins.ring_area(bin);
                [density, counts.bodies as f64]
            };
            let counted = counts.distances.counts().iter().enumerate();
            counted.map(of).collect::<Vec<[f64; 2]>>()
        };
        self.each().flat_map(of_lag).collect()
    }

    /// The number of samples skipped because their box differs from that of the constructor.
    pub fn passed_over(&self) -> u64 {
        self.passed_over
    }

    /// The number of samples that were not one spacing after the previous sample, to one part in a
    /// million.
    ///
    /// An early sample is skipped. After a late sample no lag crosses the gap; earlier averages are
    /// kept.
    pub fn uneven(&self) -> u64 {
        self.lags.uneven()
    }

    /// The lags that are counted (time).
    fn each(&self) -> impl Iterator<Item = (f64, &Counts)> {
        let lags = self.lags.each(&self.clock);
        lags.filter_map(|(lag, sum)| Some((lag, sum.sums.0.as_ref()?)))
    }

    /// The bodies of a group, with places in the frame of the centre of mass.
    fn members(&self, view: &View<'_>, group: Group) -> Members {
        let members = group.molecules(view);
        let (ids, places) = members
            .map(|view| {
                let place = view.motion.position - self.frame.displacement;
                (view.body.id(), self.bounds.wrap(place).0)
            })
            .unzip();
        Members { ids, places }
    }
}

/// The first decimal digit of a positive number.
fn first_digit(number: u64) -> u64 {
    number / 10_u64.pow(number.max(1).ilog10())
}

impl Observer for DistinctVanHove {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn start(&mut self, view: &View<'_>) {
        self.frame.follow(view);
    }

    fn sample(&mut self, view: &View<'_>) {
        self.frame.follow(view);
        if view.bounds() != self.bounds {
            self.passed_over += 1;
            return;
        }
        if !self.lags.is_due(&self.clock, view.time()) {
            return;
        }
        let [one, other] = self.groups;
        let first = self.members(view, one);
        let second = (one != other).then(|| self.members(view, other));
        let others = second.as_ref().unwrap_or(&first);
        // Both lists are in the order of the bodies.
        let both = first
            .ids
            .iter()
            .filter(|id| others.ids.binary_search(id).is_ok());
        let pairs = first.ids.len() as f64 * others.ids.len() as f64 - both.count() as f64;
        self.density[0] += pairs / self.bounds.area();
        self.density[1] += first.ids.len() as f64;
        let state = Configuration { first, second };
        let now = [LaggedSample { id: 0, state }];
        self.lags.take(&mut self.clock, view.time(), &now);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{PairDistribution, test_scenes::MIXTURE};
    use carom_engine::{Scene, Simulation};

    fn bins(spacing: f64, longest: f64) -> DisplacementBins {
        DisplacementBins {
            distance: 0.37,
            bins: 15,
            spacing,
            longest,
        }
    }

    /// All pairs of bodies of stored frames, in their nearest images.
    #[test]
    fn partial_functions_are_those_of_stored_frames() {
        let mut simulation = Simulation::new(&Scene::from_toml(MIXTURE).unwrap()).unwrap();
        let [a, b] = ["a", "b"].map(|name| Group::from(simulation.find_tag(name).unwrap()));
        let bounds = simulation.view().bounds();
        let drift = simulation.view().centre_of_mass_frame().velocity();
        assert!(drift.length() > 0.1);
        let pairs = [[a, a], [a, b], [b, a], [Group::All, b], [Group::All; 2]];
        let mut functions =
            pairs.map(|pair| DistinctVanHove::new(pair, &bounds, bins(0.02, 1.0)).unwrap());
        let mut frames: Vec<Vec<(u64, DVec2, [bool; 2])>> = Vec::new();
        for sample in 0..45 {
            let time = 0.02 * f64::from(sample);
            simulation.run_until(time).unwrap();
            let view = simulation.view();
            for function in &mut functions {
                function.sample(&view);
            }
            let body = |body: carom_engine::BodyView<'_>| {
                let place = body.motion.position - time * drift;
                let is_in = [a, b].map(|group| group.contains(body.body));
                (body.body.id(), place, is_in)
            };
            frames.push(view.bodies().map(body).collect());
        }
        for (function, pair) in functions.iter().zip(pairs) {
            let is_in = |group: Group, is_in: [bool; 2]| {
                group == Group::All || group == a && is_in[0] || group == b && is_in[1]
            };
            let curves = function.curves();
            let lags: Vec<usize> = curves
                .iter()
                .map(|curve| (curve.lag / 0.02).round() as usize)
                .collect();
            assert_eq!(lags, [0, 1, 3, 10, 30]);
            for (curve, lag) in curves.iter().zip(lags) {
                let stride = 10_usize.pow(lag.max(1).ilog10());
                let mut expected = Histogram::new(0.0, 0.37, 15);
                let mut bodies = 0;
                for origin in (0..frames.len() - lag).step_by(stride) {
                    for &(id, place, groups) in &frames[origin] {
                        if !is_in(pair[0], groups) {
                            continue;
                        }
                        bodies += 1;
                        for &(other, now, groups) in &frames[origin + lag] {
                            if other != id && is_in(pair[1], groups) {
                                expected.add(bounds.nearest_image(now - place).length());
                            }
                        }
                    }
                }
                assert_eq!(curve.bodies, bodies);
                assert_eq!(curve.counts, expected.counts(), "{lag}");
                let area = std::f64::consts::PI * (0.37f64 / 15.0).powi(2) * (25.0 - 16.0);
                let density = curve.counts[4] as f64 / (area * bodies as f64);
                assert!((curve.densities[4] - density).abs() < 1e-12 * density);
            }
            let sums = function.sums();
            assert_eq!(sums.len(), 15 * function.lags().len());
            assert_eq!(sums[20][0] / sums[20][1], curves[1].densities[5]);
            assert_eq!((function.uneven(), function.passed_over()), (0, 0));
        }
        let density = functions[3].density().unwrap();
        assert!((density - (66.0 * 25.0 - 25.0) / 66.0 / 1.3).abs() < 1e-12);
    }

    #[test]
    fn lag_0_is_the_density_times_the_pair_distribution() {
        let scene = MIXTURE.replace("velocity = [3.0, 1.0]", "fixed = true");
        let mut simulation = Simulation::new(&Scene::from_toml(&scene).unwrap()).unwrap();
        let [a, b] = ["a", "b"].map(|name| Group::from(simulation.find_tag(name).unwrap()));
        let bounds = simulation.view().bounds();
        for groups in [[Group::All; 2], [a, b], [b, b]] {
            let mut distinct = DistinctVanHove::new(groups, &bounds, bins(0.1, 0.1)).unwrap();
            let mut pairs = PairDistribution::new(groups, &bounds, 0.37, 15).unwrap();
            for _ in 0..20 {
                let time = simulation.view().time().to_f64();
                simulation.run_until(time + 0.1).unwrap();
                distinct.sample(&simulation.view());
                pairs.sample(&simulation.view());
            }
            let (curve, density) = (&distinct.curves()[0], distinct.density().unwrap());
            for (point, (&count, &found)) in pairs
                .points()
                .iter()
                .zip(curve.counts.iter().zip(&curve.densities))
            {
                assert_eq!(point.pairs, count);
                assert!(
                    (found - density * point.g).abs() < 1e-12 * density,
                    "{point:?}"
                );
            }
            assert!(curve.counts.iter().sum::<u64>() > 0);
        }
    }

    #[test]
    fn the_density_does_not_depend_on_the_distance_after_a_long_time() {
        let scene =
            "[box]\nseed = 5\n[[gas]]\nradius = 0.03\nmass = 1.0\ntemperature = 1.0\ncount = 60";
        let mut simulation = Simulation::new(&Scene::from_toml(scene).unwrap()).unwrap();
        let bounds = simulation.view().bounds();
        let mut distinct = DistinctVanHove::new([Group::All; 2], &bounds, bins(3.0, 9.0)).unwrap();
        for sample in 1..=400 {
            simulation.run_until(3.0 * f64::from(sample)).unwrap();
            distinct.sample(&simulation.view());
        }
        let curves = distinct.curves();
        assert_eq!(distinct.density(), Some(59.0));
        // Nothing is nearer than a diameter at lag 0, all distances are alike later.
        assert_eq!(curves[0].counts[..2], [0; 2]);
        assert!(curves[0].densities[3] > 60.0);
        for curve in &curves[1..] {
            for (&count, density) in curve.counts.iter().zip(&curve.densities) {
                let error = density / (count as f64).sqrt();
                assert!(
                    (density - 59.0).abs() < 4.5 * error,
                    "{}: {density} ± {error}",
                    curve.lag
                );
            }
        }
    }

    #[test]
    fn bins_out_of_range_are_refused_with_their_values() {
        let bounds = PeriodicBox::new(DVec2::new(1.0, 0.7)).unwrap();
        let error = |bins: DisplacementBins| {
            DistinctVanHove::new([Group::All; 2], &bounds, bins)
                .err()
                .map_or_else(String::new, |error| error.to_string())
        };
        let given = DisplacementBins {
            distance: 0.3,
            ..bins(0.1, 1.0)
        };
        assert_eq!(error(given), "");
        let said = error(bins(0.1, 1.0));
        assert!(said.contains("0.37 must be less than half"), "{said}");
        assert!(error(DisplacementBins { bins: 0, ..given }).contains("but is 0"));
        for refused in [0.0, f64::NAN] {
            assert!(
                !error(DisplacementBins {
                    distance: refused,
                    ..given
                })
                .is_empty()
            );
            assert!(
                !error(DisplacementBins {
                    spacing: refused,
                    ..given
                })
                .is_empty()
            );
        }
        assert_eq!([1, 3, 9, 10, 34, 999].map(first_digit), [1, 3, 9, 1, 3, 9]);
    }
}
