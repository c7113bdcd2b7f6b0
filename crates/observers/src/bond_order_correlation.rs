//! The correlation of the bond-orientational order over the distance, g₆(r).
//!
//! gₙ(r) = Re ⟨ψₙ(i) ψₙ*(j)⟩ over the pairs of bodies at the distance r, with the order ψₙ of
//! [`HexaticOrder`](crate::HexaticOrder). For n = 6 it is 1 in a triangular lattice. Divided by
//! ⟨|ψₙ|²⟩, its value at distance 0, it tends to a constant in a crystal, falls as a power r^−η
//! with η ≤ 1/4 in a hexatic phase, and exponentially in a liquid (Halperin & Nelson 1978). Bodies
//! that share neighbours are correlated, also at independent places: there gₙ falls from ⟨|ψₙ|²⟩ to
//! 0 within the distance of the farthest common neighbours.

use carom_engine::{Observer, View};
use carom_geometry::PeriodicBox;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{
    Group, Histogram,
    cell_list::CellList,
    hexatic_order::{Neighbours, orders},
    pair_distribution::{CutoffError, check_cutoff},
};

/// Correlation of ψₙ of the bodies of a group over their distance; fixed discs and molecules count,
/// walls do not.
///
/// With the k nearest as neighbours, samples with no more than k bodies in the group are omitted.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{BondOrderCorrelation, Group, Neighbours};
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 400")?;
/// let mut simulation = Simulation::new(&scene)?;
/// // The start is a part of a lattice.
/// simulation.run_until(2.0)?;
/// let bounds = simulation.view().bounds();
/// let rule = (6, Neighbours::Nearest(6));
/// let mut correlation = BondOrderCorrelation::new(Group::All, rule, &bounds, 0.4, 8)?;
/// correlation.sample(&simulation.view());
/// // Far from each other bodies of a dilute gas have no common neighbours.
/// let points = correlation.points();
/// assert!(points[7].correlation.expect("pairs").abs() < 0.05);
/// assert!(points[0].correlation > points[7].correlation);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "g6")]
#[doc(alias = "hexatic correlation function")]
pub struct BondOrderCorrelation {
    group: Group,
    /// n and the rule of the neighbours.
    rule: (u32, Neighbours),
    bounds: PeriodicBox,
    cutoff: f64,
    /// Ordered pairs by their distance.
    distances: Histogram,
    /// Σ Re ψₙ(i) ψₙ*(j) in each bin.
    products: Vec<f64>,
    /// Σ |ψₙ|² and the number of bodies over the samples.
    squares: [f64; 2],
    passed_over: u64,
}

/// The correlation in one bin.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct BondOrderPoint {
    /// Centre of the bin (length).
    pub distance: f64,
    /// Number of ordered pairs: each pair counts twice.
    pub pairs: u64,
    /// gₙ, from −1 to 1; `None` without pairs.
    pub correlation: Option<f64>,
}

impl BondOrderCorrelation {
    /// gₙ of a group, with n and the neighbours of `rule`, in `bins` bins from 0 to `cutoff`
    /// (length); `bins` = 0 is taken as 1. Neighbours are bodies of this group only.
    ///
    /// # Errors
    /// [`CutoffError`] if `cutoff` is not positive or not less than half the shorter side of the
    /// box.
    pub fn new(
        group: Group,
        rule: (u32, Neighbours),
        bounds: &PeriodicBox,
        cutoff: f64,
        bins: usize,
    ) -> Result<Self, CutoffError> {
        let cutoff = check_cutoff(bounds, cutoff)?;
        let distances = Histogram::new(0.0, cutoff, bins);
        Ok(Self {
            group,
            rule,
            bounds: *bounds,
            cutoff,
            products: vec![0.0; distances.counts().len()],
            distances,
            squares: [0.0; 2],
            passed_over: 0,
        })
    }

    /// n.
    pub fn symmetry(&self) -> u32 {
        self.rule.0
    }

    /// The rule of the neighbours.
    pub fn neighbours(&self) -> Neighbours {
        self.rule.1
    }

    /// gₙ in each bin from the samples so far.
    pub fn points(&self) -> Vec<BondOrderPoint> {
        let counts = self.distances.counts().iter().zip(&self.products);
        counts
            .enumerate()
            .map(|(bin, (&pairs, product))| BondOrderPoint {
                distance: self.distances.centre(bin),
                pairs,
                correlation: (pairs > 0).then(|| product / pairs as f64),
            })
            .collect()
    }

    /// ⟨|ψₙ|²⟩ over bodies and samples, from 0 to 1: gₙ at distance 0; `None` before the first
    /// sample.
    pub fn mean_square(&self) -> Option<f64> {
        let [sum, bodies] = self.squares;
        (bodies > 0.0).then(|| sum / bodies)
    }

    /// [Σx, Σw] over all samples so far: ⟨|ψₙ|²⟩, w the number of bodies, then gₙ in each bin, w
    /// the number of ordered pairs.
    pub fn sums(&self) -> Vec<[f64; 2]> {
        let bins = self.products.iter().zip(self.distances.counts());
        std::iter::once(self.squares)
            .chain(bins.map(|(&product, &pairs)| [product, pairs as f64]))
            .collect()
    }

    /// The number of samples skipped because their box differs from that of the constructor, or
    /// because there were too few bodies.
    pub fn passed_over(&self) -> u64 {
        self.passed_over
    }
}

impl Observer for BondOrderCorrelation {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn sample(&mut self, view: &View<'_>) {
        let members = self.group.molecules(view);
        let places: Vec<DVec2> = members.map(|view| view.motion.position).collect();
        let bounds = view.bounds();
        let is_same_box = bounds.sides() == self.bounds.sides();
        let Some(orders) = orders(&places, view, self.rule).filter(|_| is_same_box) else {
            self.passed_over += 1;
            return;
        };
        self.squares[0] += orders.iter().map(|psi| psi.length_squared()).sum::<f64>();
        self.squares[1] += orders.len() as f64;
        let cells = CellList::for_cutoff(&places, &bounds, self.cutoff);
        cells.for_each_pair_within(self.cutoff, |[i, j], squared| {
            let distance = squared.sqrt();
            self.distances.add(distance);
            // Rounding may take a distance just below the cutoff beyond the last bin.
            if let Some(bin) = self.distances.bin_of(distance) {
                self.products[bin] += orders[i].dot(orders[j]);
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        HexaticOrder, PairDistribution,
        test_scenes::{discs_at, random_points, triangular_lattice},
    };
    use carom_engine::{Scene, Simulation};

    const HEXATIC: (u32, Neighbours) = (6, Neighbours::Nearest(6));

    #[test]
    fn a_triangular_lattice_has_one_at_each_distance() {
        let (sides, places) = triangular_lattice(8, 10);
        let scene = discs_at(sides, 0.01, places);
        let simulation = Simulation::new(&scene).unwrap();
        let bounds = simulation.view().bounds();
        for rule in [
            HEXATIC,
            (6, Neighbours::Delaunay),
            (12, Neighbours::Voronoi),
        ] {
            let mut correlation =
                BondOrderCorrelation::new(Group::All, rule, &bounds, 3.7, 37).unwrap();
            correlation.sample(&simulation.view());
            assert!((correlation.mean_square().unwrap() - 1.0).abs() < 1e-9);
            let points = correlation.points();
            // The six nearest, and nothing below.
            assert_eq!(points[..9].iter().map(|point| point.pairs).sum::<u64>(), 0);
            let near: u64 = points[9..11].iter().map(|point| point.pairs).sum();
            assert_eq!(near, 6 * 80);
            for point in points {
                let g = point.correlation.unwrap_or(1.0);
                assert!((g - 1.0).abs() < 1e-9, "{rule:?} {point:?}");
            }
        }
    }

    /// Independent places: the common neighbours of near bodies, and none of far ones.
    #[test]
    fn random_places_share_neighbours_at_small_distances_only() {
        let mut sums = vec![[0.0; 2]; 21];
        let mut far: Vec<f64> = Vec::new();
        for seed in 0..40 {
            let simulation = Simulation::new(&random_points(1000, [1.0, 1.0], seed)).unwrap();
            let bounds = simulation.view().bounds();
            let mut correlation =
                BondOrderCorrelation::new(Group::All, HEXATIC, &bounds, 0.2, 100).unwrap();
            correlation.sample(&simulation.view());
            let found = correlation.sums();
            for (all, sum) in sums.iter_mut().zip(&found) {
                all[0] += sum[0];
                all[1] += sum[1];
            }
            // Six neighbours lie within √(6/1000π) = 0.044 on average, common ones within twice
            // that.
            let beyond = &found[76..];
            let [product, pairs] = beyond
                .iter()
                .fold([0.0; 2], |all, sum| [all[0] + sum[0], all[1] + sum[1]]);
            far.push(product / pairs);
        }
        let mean = |index: usize| sums[index][0] / sums[index][1];
        assert!((mean(0) - 1.0 / 6.0).abs() < 0.003, "{}", mean(0));
        // At distance 0 the neighbours of two bodies are each other, at opposite directions, and
        // five common ones: ψ₆ is equal.
        assert!((mean(1) - 1.0 / 6.0).abs() < 0.04, "{}", mean(1));
        assert!(mean(10) < 0.5 * mean(1) && mean(5) < mean(1));
        let (far, error) = carom_tables::block_sums::mean_of_series(far).unwrap();
        assert!(far.abs() < 4.0 * error && error < 0.002, "{far} ± {error}");
    }

    /// All pairs of a gas, with ψ₆ by the directions to the six nearest of all bodies.
    #[test]
    fn correlations_are_those_of_all_pairs() {
        let scene = "[box]\nsides = [1.0, 1.3]\nseed = 2\n[[gas]]\nradius = 0.03\nmass = 1.0\nenergy = 1.0\ncount = 120\n";
        let mut simulation = Simulation::new(&Scene::from_toml(scene).unwrap()).unwrap();
        let bounds = simulation.view().bounds();
        let mut correlation =
            BondOrderCorrelation::new(Group::All, HEXATIC, &bounds, 0.45, 18).unwrap();
        let mut pairs = PairDistribution::new([Group::All; 2], &bounds, 0.45, 18).unwrap();
        let mut order = HexaticOrder::new(Group::All);
        let mut expected = [[0.0; 2]; 18];
        for sample in 1..=3 {
            simulation.run_until(f64::from(sample)).unwrap();
            let view = simulation.view();
            correlation.sample(&view);
            pairs.sample(&view);
            order.sample(&view);
            let places: Vec<DVec2> = view.bodies().map(|body| body.motion.position).collect();
            let apart = |i: usize, j: usize| bounds.nearest_image(places[j] - places[i]);
            let psi = |i: usize| {
                let others = (0..places.len()).filter(|&j| j != i);
                let mut near: Vec<DVec2> = others.map(|j| apart(i, j)).collect();
                near.sort_by(|one, other| one.length_squared().total_cmp(&other.length_squared()));
                let wave = |d: &DVec2| DVec2::from_angle(6.0 * d.y.atan2(d.x));
                near[..6].iter().map(wave).sum::<DVec2>() / 6.0
            };
            let psi: Vec<DVec2> = (0..places.len()).map(psi).collect();
            for i in 0..places.len() {
                for j in (0..places.len()).filter(|&j| j != i) {
                    let bin = (apart(i, j).length() / 0.025) as usize;
                    if let Some(sum) = expected.get_mut(bin) {
                        sum[0] += psi[i].dot(psi[j]);
                        sum[1] += 1.0;
                    }
                }
            }
        }
        let of_pairs = pairs.points();
        for (bin, point) in correlation.points().iter().enumerate() {
            let [product, count] = expected[bin];
            assert_eq!(
                (point.pairs, point.pairs as f64),
                (of_pairs[bin].pairs, count)
            );
            if count > 0.0 {
                let found = point.correlation.unwrap();
                assert!((found - product / count).abs() < 1e-12, "{point:?}");
            }
        }
        let [_, [squares, samples], _] = order.sums()[..] else {
            panic!("three sums")
        };
        let mean_square = correlation.mean_square().unwrap();
        assert!((mean_square - squares / samples).abs() < 1e-14);
    }
}
