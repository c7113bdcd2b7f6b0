//! The distribution of the distances of two bodies: the pair distribution function g(r).
//!
//! g in a bin [r₁, r₂) is the number of ordered pairs (i, j ≠ i) of centres of mass at such
//! distances, i of one group and j of another, divided by (number of all such pairs) π (r₂² − r₁²)
//! / A. It is 1 for independent positions of any number of bodies. (With N² instead of N (N − 1),
//! as in Allen & Tildesley 2017, section 8.2, it is smaller by the factor 1 − 1/N.) For hard discs
//! g is 0 below σ, and χ at contact, with p A = N kT (1 + 2 η χ).

use carom_engine::{Observer, View};
use carom_geometry::{GeometryError, PeriodicBox, check_positive};
use glam::DVec2;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::{Group, Histogram, cell_list::CellList};

/// Pair distribution of the centres of mass of two groups over the samples; fixed bodies count,
/// too, but no walls. Under shear the distances are those in the present, displaced images.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{Group, PairDistribution};
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 200")?;
/// let mut simulation = Simulation::new(&scene)?;
/// let mut pairs = PairDistribution::new([Group::All; 2], &simulation.view().bounds(), 0.2, 20)?;
/// for sample in 1..=5 {
///     simulation.run_until(f64::from(sample))?;
///     pairs.sample(&simulation.view());
/// }
/// // The discs have a diameter of 0.04: g is 0 below it and exceeds 1 at contact.
/// let points = pairs.points();
/// assert!(points[..4].iter().all(|point| point.g == 0.0));
/// assert!(points[4].g > 1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "radial distribution function")]
pub struct PairDistribution {
    groups: [Group; 2],
    bounds: PeriodicBox,
    cutoff: f64,
    distances: Histogram,
    /// Σ over the samples of the number of ordered pairs / A (1 / length²).
    pairs_per_area: f64,
    passed_over: u64,
}

/// The pair distribution in one bin.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct PairPoint {
    /// Centre of the bin (length).
    pub distance: f64,
    /// Number of ordered pairs: a pair with both bodies in both groups counts twice.
    pub pairs: u64,
    /// g.
    pub g: f64,
}

/// An invalid cutoff of a pair distribution: not a length, or too long for the box.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CutoffError {
    /// The cutoff is not positive and finite.
    #[error(transparent)]
    Length(#[from] GeometryError),
    /// Beyond half the shorter side several images of a body count, and a circle exceeds the box.
    #[error("the cutoff {cutoff} must be less than half the shorter side of the box, {half}")]
    BeyondHalf {
        /// The given cutoff (length).
        cutoff: f64,
        /// Half the shorter side (length).
        half: f64,
    },
}

/// The longest distance of pairs in a box, if it is valid (length).
///
/// # Errors
/// [`CutoffError`] if it is not positive or not less than half the shorter side of the box.
pub(crate) fn check_cutoff(bounds: &PeriodicBox, cutoff: f64) -> Result<f64, CutoffError> {
    let cutoff = check_positive("the cutoff of a pair distribution", cutoff)?;
    let half = 0.5 * bounds.sides().min_element();
    if cutoff >= half {
        return Err(CutoffError::BeyondHalf { cutoff, half });
    }
    Ok(cutoff)
}

impl PairDistribution {
    /// Distances from bodies of the first group to those of the second, in `bins` bins from 0 to
    /// `cutoff` (length); `bins` = 0 is taken as 1.
    ///
    /// # Errors
    /// [`CutoffError`] if `cutoff` is not positive or not less than half the shorter side of the
    /// box.
    pub fn new(
        groups: [Group; 2],
        bounds: &PeriodicBox,
        cutoff: f64,
        bins: usize,
    ) -> Result<Self, CutoffError> {
        let cutoff = check_cutoff(bounds, cutoff)?;
        let distances = Histogram::new(0.0, cutoff, bins);
        Ok(Self {
            groups,
            bounds: *bounds,
            cutoff,
            distances,
            pairs_per_area: 0.0,
            passed_over: 0,
        })
    }

    /// g in each bin from the samples so far; empty if there has been no pair.
    pub fn points(&self) -> Vec<PairPoint> {
        if self.pairs_per_area == 0.0 {
            return Vec::new();
        }
        let point = |(bin, &pairs): (usize, &u64)| PairPoint {
            distance: self.distances.centre(bin),
            pairs,
            g: pairs as f64 / (self.pairs_per_area * self.distances.ring_area(bin)),
        };
        self.distances
            .counts()
            .iter()
            .enumerate()
            .map(point)
            .collect()
    }

    /// Σ pairs / (2π r w) and Σ pairs of all distances / A over the samples so far, for each bin: g
    /// is their ratio.
    pub fn sums(&self) -> Vec<[f64; 2]> {
        let of = |(bin, &pairs): (usize, &u64)| {
            [
                pairs as f64 / self.distances.ring_area(bin),
                self.pairs_per_area,
            ]
        };
        self.distances.counts().iter().enumerate().map(of).collect()
    }

    /// The number of samples skipped because their box differs from that of the constructor.
    pub fn passed_over(&self) -> u64 {
        self.passed_over
    }
}

impl Observer for PairDistribution {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn sample(&mut self, view: &View<'_>) {
        let bounds = view.bounds();
        if bounds.sides() != self.bounds.sides() {
            self.passed_over += 1;
            return;
        }
        let (places, is_in): (Vec<DVec2>, Vec<[bool; 2]>) = view
            .bodies()
            .filter(|view| !view.body.is_wall())
            .map(|view| {
                let is_in = self.groups.map(|group| group.contains(view.body));
                (view.motion.position, is_in)
            })
            .filter(|(_, is_in)| is_in.contains(&true))
            .unzip();
        let count = |requested: fn(&[bool; 2]) -> bool| {
            is_in.iter().filter(|&is_in| requested(is_in)).count() as f64
        };
        let [first, second] = [count(|is_in| is_in[0]), count(|is_in| is_in[1])];
        let both = count(|is_in| *is_in == [true; 2]);
        self.pairs_per_area += (first * second - both) / bounds.area();
        let cells = CellList::for_cutoff(&places, &bounds, self.cutoff);
        cells.for_each_pair_within(self.cutoff, |[i, j], squared| {
            if is_in[i][0] && is_in[j][1] {
                self.distances.add(squared.sqrt());
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_scenes::{moving_with_the_flow, random_points};
    use carom_engine::Simulation;

    /// Neighbours over the seam of a sheared lattice: a square lattice in a flow has, at the slope
    /// a, pairs at the displacements (p + a q, q). At a = 1 it is the square lattice again.
    #[test]
    fn a_lattice_in_a_flow_has_its_neighbours_over_the_seam() {
        let site = |site: u32| DVec2::new(f64::from(site % 6), f64::from(site / 6)) + 0.2;
        let places: Vec<DVec2> = (0..36).map(site).collect();
        let scene = moving_with_the_flow([6.0; 2], &places);
        let mut simulation = Simulation::new(&scene).unwrap();
        let bounds = simulation.view().bounds();
        for (time, slope) in [
            (0.0, 0.0_f64),
            (0.6, 0.3),
            (1.0, 0.5),
            (2.0, 1.0),
            (5.2, 2.6),
        ] {
            simulation.run_until(time).unwrap();
            let mut pairs = PairDistribution::new([Group::All; 2], &bounds, 2.97, 33).unwrap();
            pairs.sample(&simulation.view());
            let mut expected = vec![0; 33];
            for p in -20..=20 {
                for q in -2..=2 {
                    let (p, q) = (f64::from(p), f64::from(q));
                    let distance = DVec2::new(p + slope * q, q).length();
                    if distance > 0.5 && distance < 2.97 {
                        expected[(distance / 0.09) as usize] += 36;
                    }
                }
            }
            let found: Vec<u64> = pairs.points().iter().map(|point| point.pairs).collect();
            assert_eq!(found, expected, "{time}");
            assert_eq!(pairs.passed_over(), 0);
        }
    }

    #[test]
    fn pairs_in_a_flow_are_those_of_all_images() {
        let scene = random_points(60, [1.0, 1.5], 9);
        let places: Vec<DVec2> = scene.bumper.iter().map(|disc| disc.at.into()).collect();
        let scene = moving_with_the_flow([1.0, 1.5], &places);
        let mut simulation = Simulation::new(&scene).unwrap();
        let bounds = simulation.view().bounds();
        let mut pairs = PairDistribution::new([Group::All; 2], &bounds, 0.49, 20).unwrap();
        let mut expected = Histogram::new(0.0, 0.49, 20);
        for time in [0.0, 0.7, 1.9, 4.4] {
            simulation.run_until(time).unwrap();
            let view = simulation.view();
            pairs.sample(&view);
            let places: Vec<DVec2> = view.bodies().map(|body| body.motion.position).collect();
            for (i, one) in places.iter().enumerate() {
                for other in places.iter().enumerate().filter(|&(j, _)| j != i) {
                    for image in (-3..=3).flat_map(|x| (-2..=2).map(move |y| [x, y])) {
                        let apart = *other.1 + view.bounds().shift(image) - *one;
                        if apart.length() < 0.49 {
                            expected.add(apart.length());
                        }
                    }
                }
            }
        }
        let found: Vec<u64> = pairs.points().iter().map(|point| point.pairs).collect();
        assert_eq!(found, expected.counts());
        // 60 · 59 pairs in each of four samples, in an area of 1.5.
        assert!((pairs.sums()[0][1] - 4.0 * 60.0 * 59.0 / 1.5).abs() < 1e-9);
    }
}
