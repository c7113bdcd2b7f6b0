//! How long bond-orientational order lasts: G₆(t) of a body with itself.
//!
//! Gₙ(t) = Re ⟨ψₙ(t₀ + t) ψₙ*(t₀)⟩ over bodies and origins t₀, with the order ψₙ of
//! [`HexaticOrder`](crate::HexaticOrder). At lag 0 it is ⟨|ψₙ|²⟩. For n = 6 it tends to a constant
//! in a crystal, falls as a power of t in a hexatic phase, and exponentially in a liquid (Zahn &
//! Maret, Phys. Rev. Lett. 85 (2000) 3656).

use carom_engine::{Observer, View};
use carom_geometry::GeometryError;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{
    Group,
    hexatic_order::{Neighbours, orders},
    lags::{Clock, LagSum, LaggedSample, Lags, PairSums},
};

/// Correlation of ψₙ of each body of a group with itself after a lag; fixed discs and molecules
/// count, walls do not.
///
/// Neighbours are bodies of this group only. With the k nearest as neighbours, samples with no more
/// than k bodies in the group are omitted. Samples must be one spacing apart.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{BondOrderRelaxation, Group, Neighbours};
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 400")?;
/// let mut simulation = Simulation::new(&scene)?;
/// let rule = (6, Neighbours::Nearest(6));
/// let mut relaxation = BondOrderRelaxation::new(Group::All, rule, 0.02, 0.4)?;
/// for sample in 0..=40 {
///     simulation.observe_until(0.02 * f64::from(sample), &mut relaxation)?;
///     relaxation.sample(&simulation.view());
/// }
/// let points = relaxation.points();
/// // Within a few collisions other bodies are the nearest of a thin gas.
/// let (first, last) = (points[0].correlation, points[points.len() - 1].correlation);
/// assert!(last.abs() < 0.3 * first);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "g6(t)")]
pub struct BondOrderRelaxation {
    group: Group,
    /// n and the rule of the neighbours.
    rule: (u32, Neighbours),
    clock: Clock,
    /// ψₙ of each body, real and imaginary part.
    lags: Lags<DVec2, Products>,
}

/// The correlation at one lag.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct BondOrderLag {
    /// The lag t (time).
    pub lag: f64,
    /// The number of pairs of one body at t₀ and at t₀ + t; they are not independent of each other.
    pub pairs: u64,
    /// Gₙ(t), from −1 to 1.
    pub correlation: f64,
}

/// Σ Re ψₙ(t₀ + t) ψₙ*(t₀).
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct Products(f64);

impl PairSums<DVec2> for Products {
    #[inline]
    fn add(&mut self, before: &DVec2, now: &DVec2) {
        self.0 += before.dot(*now);
    }
}

impl BondOrderRelaxation {
    /// Gₙ of a group, with n and the neighbours of `rule`, up to the lag `longest` (time) of
    /// samples that are `spacing` (time) apart; a `longest` below one spacing is taken as one
    /// spacing.
    ///
    /// Lags are 0, 1, 2, …, 9, 10, 20, …, 90, 100, … spacings.
    ///
    /// # Errors
    /// [`GeometryError::NotPositive`] if `spacing` or `longest` is not positive and finite.
    pub fn new(
        group: Group,
        rule: (u32, Neighbours),
        spacing: f64,
        longest: f64,
    ) -> Result<Self, GeometryError> {
        let (clock, lags) = Lags::new(spacing, longest)?;
        Ok(Self {
            group,
            rule,
            clock,
            lags,
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

    /// Gₙ so far in ascending order of lag, from lag 0 on; lags without pairs are omitted.
    pub fn points(&self) -> Vec<BondOrderLag> {
        let lags = self.lags.each(&self.clock).filter(|(_, sum)| sum.pairs > 0);
        let point = |(lag, sum): (f64, &LagSum<Products>)| BondOrderLag {
            lag,
            pairs: sum.pairs,
            correlation: sum.sums.0 / sum.pairs as f64,
        };
        lags.map(point).collect()
    }

    /// All lags (time) in ascending order, from lag 0 on, also those without pairs.
    pub fn lags(&self) -> Vec<f64> {
        self.lags.times(&self.clock)
    }

    /// [Σx, Σw] over all samples so far, w the number of pairs: Gₙ at each of the
    /// [lags](Self::lags).
    pub fn sums(&self) -> Vec<[f64; 2]> {
        self.lags.terms([|products: &Products| products.0])
    }

    /// The number of samples that were not one spacing after the previous sample, to one part in a
    /// million. An early sample is skipped. After a late sample no lag crosses the gap.
    pub fn uneven(&self) -> u64 {
        self.lags.uneven()
    }
}

impl Observer for BondOrderRelaxation {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn sample(&mut self, view: &View<'_>) {
        if !self.lags.is_due(&self.clock, view.time()) {
            return;
        }
        let bodies: Vec<_> = self.group.molecules(view).collect();
        let places: Vec<DVec2> = bodies.iter().map(|body| body.motion.position).collect();
        let orders = orders(&places, view, self.rule).unwrap_or_default();
        let now: Vec<LaggedSample<DVec2>> = bodies
            .iter()
            .zip(orders)
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
    use crate::test_scenes::triangular_lattice;
    use carom_engine::{MoleculeSpec, Scene, Simulation};

    const RULE: (u32, Neighbours) = (6, Neighbours::Nearest(6));

    #[test]
    fn a_lattice_that_moves_keeps_its_order() {
        let (sides, places) = triangular_lattice(8, 10);
        let disc = |place: &DVec2| MoleculeSpec {
            shape: Some("disc".to_owned()),
            atom_radius: Some(0.01),
            atom_mass: Some(1.0),
            at: place.to_array(),
            velocity: [0.3, -0.7],
            ..MoleculeSpec::default()
        };
        let mut scene = Scene::default();
        scene.bounds.sides = sides;
        scene.molecule = places.iter().map(disc).collect();
        let mut simulation = Simulation::new(&scene).unwrap();
        let mut relaxation = BondOrderRelaxation::new(Group::All, RULE, 0.1, 1.0).unwrap();
        for sample in 0..=10 {
            simulation.run_until(0.1 * f64::from(sample)).unwrap();
            relaxation.sample(&simulation.view());
        }
        let view = simulation.view();
        let moved = view.bodies().zip(&places).all(|(body, place)| {
            // Some discs have crossed a side of the box.
            (body.motion.position - *place).abs().min_element() > 0.25
        });
        assert!(moved && view.counters().collisions == 0);
        let points = relaxation.points();
        assert_eq!(points.len(), 11);
        assert!(
            points
                .iter()
                .all(|point| point.pairs > 0 && (point.correlation - 1.0).abs() < 1e-9)
        );
    }

    /// Against a sum over stored frames.
    #[test]
    fn the_correlation_is_that_of_stored_frames() {
        let gas = "[[gas]]\nradius = 0.03\nmass = 1.0\nenergy = 1.0\ncount = 60";
        for rule in [RULE, (4, Neighbours::Voronoi)] {
            let mut simulation = Simulation::new(&Scene::from_toml(gas).unwrap()).unwrap();
            let mut relaxation = BondOrderRelaxation::new(Group::All, rule, 0.05, 0.45).unwrap();
            let mut frames = Vec::new();
            for sample in 0..20 {
                simulation.run_until(0.05 * f64::from(sample)).unwrap();
                let view = simulation.view();
                relaxation.sample(&view);
                let places: Vec<DVec2> = view.bodies().map(|body| body.motion.position).collect();
                frames.push(orders(&places, &view, rule).unwrap());
            }
            for (steps, point) in relaxation.points().iter().enumerate().take(10) {
                let origins = frames.len() - steps;
                let pairs = (0..origins).flat_map(|t| frames[t].iter().zip(&frames[t + steps]));
                let sum: f64 = pairs.map(|(before, now)| before.dot(*now)).sum();
                let mean = sum / (60 * origins) as f64;
                assert_eq!(point.pairs, 60 * origins as u64);
                assert!((point.correlation - mean).abs() < 1e-12, "{steps}");
            }
        }
    }
}
