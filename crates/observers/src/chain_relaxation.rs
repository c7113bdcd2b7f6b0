//! How chains move and forget their shape: displacement of their middle, and the correlations of a
//! Rouse mode and of the end-to-end vector.
//!
//! Mode p of a chain of N bodies at r_j, j = 1 … N, is X_p = (1/N) Σ r_j cos(pπ(j − ½)/N): p = 1 is
//! the slowest, that of the end-to-end vector (Verdier, J. Chem. Phys. 45 (1966) 2118; Doi &
//! Edwards, The Theory of Polymer Dynamics, 1986, chapter 4). In the Rouse model ⟨X_p(t)·X_p(0)⟩
//! falls exponentially, at a rate in proportion to sin²(pπ/2N), and the middle diffuses with the
//! diffusion coefficient of a body over N. The end-to-end vector R = r_N − r_1 is a sum over the
//! odd modes: of long chains ⟨R(t)·R(0)⟩/⟨R²⟩ = Σ 8/(p²π²) exp(−p² t/τ₁), p = 1, 3, …, with the
//! relaxation time τ₁ of the slowest.

use std::f64::consts::PI;

use carom_engine::{Observer, View};
use carom_geometry::GeometryError;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{
    Group,
    chains::{Chain, chains_of},
    lags::{Clock, LagSum, LaggedSample, Lags, PairSums},
};

/// Displacement and relaxation of chains without branches. A chain counts if its first end belongs
/// to the group. Samples must be one spacing apart.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{ChainRelaxation, Group};
///
/// let scene = Scene::from_toml(
///     "[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 40\n\
///      chain = { members = 4, tether = { max = 0.04 } }",
/// )?;
/// let mut simulation = Simulation::new(&scene)?;
/// let mut relaxation = ChainRelaxation::new(Group::All, 1, 0.02, 0.4)?;
/// for sample in 0..=40 {
///     simulation.observe_until(0.02 * f64::from(sample), &mut relaxation)?;
///     relaxation.sample(&simulation.view());
/// }
/// let points = relaxation.points();
/// let last = points[points.len() - 1];
/// assert!(last.displacement > 0.0 && last.correlation < points[0].correlation);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "Rouse mode")]
pub struct ChainRelaxation {
    group: Group,
    /// p.
    mode: u32,
    clock: Clock,
    lags: Lags<ChainState, ChainProducts>,
}

/// One chain at one time.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct ChainState {
    /// Its middle, without jumps at the border of the box (length).
    middle: DVec2,
    /// X_p (length).
    mode: DVec2,
    /// The vector from its first end to the last (length).
    end_to_end: DVec2,
}

/// Sums of the squared displacements of the middle, Σ X_p(t₀ + t)·X_p(t₀) and Σ R(t₀ + t)·R(t₀).
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct ChainProducts {
    displacement: f64,
    correlation: f64,
    end_to_end: f64,
}

impl PairSums<ChainState> for ChainProducts {
    #[inline]
    fn add(&mut self, before: &ChainState, now: &ChainState) {
        self.displacement += (now.middle - before.middle).length_squared();
        self.correlation += before.mode.dot(now.mode);
        self.end_to_end += before.end_to_end.dot(now.end_to_end);
    }
}

/// Displacement and correlations at one lag.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ChainLag {
    /// The lag t (time).
    pub lag: f64,
    /// The number of pairs of one chain at t₀ and at t₀ + t; they are not independent of each
    /// other.
    pub pairs: u64,
    /// Mean squared displacement of the middle (length²).
    pub displacement: f64,
    /// ⟨X_p(t₀ + t)·X_p(t₀)⟩ (length²).
    pub correlation: f64,
    /// ⟨R(t₀ + t)·R(t₀)⟩ of the end-to-end vector (length²).
    pub end_to_end: f64,
}

impl ChainRelaxation {
    /// Mode `mode` of the chains of a group, up to the lag `longest` (time) of samples that are
    /// `spacing` (time) apart; a `longest` below one spacing is taken as one spacing.
    ///
    /// # Errors
    /// [`GeometryError::NotPositive`] if `spacing` or `longest` is not positive and finite.
    pub fn new(group: Group, mode: u32, spacing: f64, longest: f64) -> Result<Self, GeometryError> {
        let (clock, lags) = Lags::new(spacing, longest)?;
        Ok(Self {
            group,
            mode,
            clock,
            lags,
        })
    }

    /// p.
    pub fn mode(&self) -> u32 {
        self.mode
    }

    /// The means so far in ascending order of lag, from lag 0 on; lags without pairs are omitted.
    pub fn points(&self) -> Vec<ChainLag> {
        let lags = self.lags.each(&self.clock).filter(|(_, sum)| sum.pairs > 0);
        let point = |(lag, sum): (f64, &LagSum<ChainProducts>)| ChainLag {
            lag,
            pairs: sum.pairs,
            displacement: sum.sums.displacement / sum.pairs as f64,
            correlation: sum.sums.correlation / sum.pairs as f64,
            end_to_end: sum.sums.end_to_end / sum.pairs as f64,
        };
        lags.map(point).collect()
    }

    /// All lags (time) in ascending order, from lag 0 on, also those without pairs.
    pub fn lags(&self) -> Vec<f64> {
        self.lags.times(&self.clock)
    }

    /// [Σx, Σw] over all samples so far, w the number of pairs: the mean squared displacement at
    /// each of the [lags](Self::lags), then the correlation of the mode at each, then that of the
    /// end-to-end vector.
    pub fn sums(&self) -> Vec<[f64; 2]> {
        self.lags.terms([
            |products: &ChainProducts| products.displacement,
            |products: &ChainProducts| products.correlation,
            |products: &ChainProducts| products.end_to_end,
        ])
    }

    /// The number of samples that were not one spacing after the previous sample, to one part in a
    /// million. An early sample is skipped. After a late sample no lag crosses the gap.
    pub fn uneven(&self) -> u64 {
        self.lags.uneven()
    }

    fn state(&self, chain: &Chain, unwrapped: DVec2) -> ChainState {
        let (count, middle) = (chain.places.len() as f64, chain.middle());
        let angle = f64::from(self.mode) * PI / count;
        let weighted = (0..).zip(&chain.places).map(|(number, place)| {
            // The mode of the middle is 0.
            (*place - middle) * libm::cos(angle * (f64::from(number) + 0.5))
        });
        // The last place was reached from the first along the bonds.
        let [first, last] = [chain.places[0], chain.places[chain.places.len() - 1]];
        ChainState {
            middle: unwrapped + (middle - first),
            mode: weighted.sum::<DVec2>() / count,
            end_to_end: last - first,
        }
    }
}

impl Observer for ChainRelaxation {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn sample(&mut self, view: &View<'_>) {
        if !self.lags.is_due(&self.clock, view.time()) {
            return;
        }
        let bodies: Vec<_> = view.bodies().collect();
        let mut now: Vec<LaggedSample<ChainState>> = chains_of(view, &bodies, self.group)
            .iter()
            .filter(|chain| chain.is_linear)
            .map(|chain| {
                let first = &bodies[chain.first];
                // Bonds may change: a chain is known by both of its ends.
                let last = bodies[chain.last].body.id();
                LaggedSample {
                    id: (first.body.id() << 32) ^ last,
                    state: self.state(chain, first.unwrapped(&view.bounds())),
                }
            })
            .collect();
        now.sort_by_key(|sample| sample.id);
        self.lags.take(&mut self.clock, view.time(), &now);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_engine::{Scene, Simulation};

    /// Three points in a row that fly together.
    fn row(velocity: [f64; 2]) -> Simulation {
        let disc = |x: f64| {
            format!(
                "[[molecule]]\natoms = [{{ at = [0, 0], radius = 1e-3, mass = 1 }}]\nat = [{x}, 0.5]\n\
                 velocity = {velocity:?}\n"
            )
        };
        let discs: String = [0.8, 0.9, 0.0].into_iter().map(disc).collect();
        let bonds = "[[bond]]\npairs = [[0, 1], [1, 2]]\ntether = { max = 0.2 }\n";
        Simulation::new(&Scene::from_toml(&format!("{bonds}{discs}")).unwrap()).unwrap()
    }

    #[test]
    fn a_rigid_row_keeps_its_modes_and_moves_on_without_jumps() {
        for (mode, expected) in [(1, 0.1 * libm::cos(PI / 6.0) * 2.0 / 3.0), (2, 0.0)] {
            let mut simulation = row([3.0, 4.0]);
            let mut relaxation = ChainRelaxation::new(Group::All, mode, 0.1, 1.0).unwrap();
            for sample in 0..=10 {
                simulation.run_until(0.1 * f64::from(sample)).unwrap();
                relaxation.sample(&simulation.view());
            }
            let points = relaxation.points();
            assert_eq!(points.len(), 11);
            for (step, point) in points.iter().enumerate() {
                let way = 0.5 * step as f64;
                assert!((point.displacement - way * way).abs() < 1e-10, "{point:?}");
                assert!(
                    (point.correlation - expected * expected).abs() < 1e-12,
                    "{point:?}"
                );
                assert!((point.end_to_end - 0.04).abs() < 1e-12, "{point:?}");
            }
        }
    }

    /// Until the tether pulls, R(t) = R(0) + v t, also through the border of the box.
    #[test]
    fn the_end_to_end_vector_of_free_ends_is_that_of_free_flight() {
        let disc = |x: f64, velocity: [f64; 2]| {
            format!(
                "[[molecule]]\natoms = [{{ at = [0, 0], radius = 1e-3, mass = 1 }}]\nat = [{x}, 0.5]\n\
                 velocity = {velocity:?}\n"
            )
        };
        // Through the border of the box, apart by 0.1 at a relative velocity of (0.05, −0.2).
        let discs = [disc(0.95, [2.0, 0.1]), disc(0.05, [2.05, -0.1])].concat();
        let bonds = "[[bond]]\npairs = [[0, 1]]\ntether = { max = 0.4 }\n";
        let scene = Scene::from_toml(&format!("{bonds}{discs}")).unwrap();
        let mut simulation = Simulation::new(&scene).unwrap();
        let mut relaxation = ChainRelaxation::new(Group::All, 1, 0.1, 1.0).unwrap();
        let vector = |sample: f64| DVec2::new(0.1, 0.0) + 0.1 * sample * DVec2::new(0.05, -0.2);
        for sample in 0..=10 {
            simulation.run_until(0.1 * f64::from(sample)).unwrap();
            relaxation.sample(&simulation.view());
        }
        for (lag, point) in relaxation.points().iter().enumerate() {
            // All pairs of samples at this lag.
            let products = (0..=10 - lag).map(|start| {
                let [before, now] = [start, start + lag].map(|sample| vector(sample as f64));
                before.dot(now)
            });
            let expected = products.sum::<f64>() / (11 - lag) as f64;
            assert!(
                (point.end_to_end - expected).abs() < 1e-12,
                "{lag} {point:?}"
            );
            // Of two points X₁ = −R/(2√2).
            assert!(
                (point.correlation - expected / 8.0).abs() < 1e-12,
                "{lag} {point:?}"
            );
        }
    }

    #[test]
    fn rings_are_left_out() {
        let ring = "[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 8\n\
            chain = { members = 8, ring = true, tether = { max = 0.04 } }";
        let simulation = Simulation::new(&Scene::from_toml(ring).unwrap()).unwrap();
        let mut relaxation = ChainRelaxation::new(Group::All, 1, 0.1, 1.0).unwrap();
        relaxation.sample(&simulation.view());
        assert!(relaxation.points().is_empty());
    }
}
