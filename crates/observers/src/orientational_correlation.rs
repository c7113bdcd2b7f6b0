//! Orientational correlation and angular velocity autocorrelation of molecules that turn.
//!
//! Cₙ(t) = ⟨cos n(θ(t₀ + t) − θ(t₀))⟩ for n = 1 and 2, and ⟨ω(t₀ + t) ω(t₀)⟩ (1 / time²), over
//! bodies and origins t₀. The engine keeps no number of turns, so that there is no mean squared
//! angle; Cₙ does not need it. n = 2 is the order of molecules that a half turn maps to themselves,
//! such as dumbbells and rods.
//!
//! * Free rotors at equilibrium, and any molecule long before its first contact: ω is Gaussian with
//!   the variance kT/I, so that Cₙ = exp(−n² kT t² / 2I) exactly.
//! * Rotational diffusion, for t long against the decay of ω: Cₙ ∝ exp(−n² D t), with D = ∫₀^∞
//!   ⟨ω(t) ω(0)⟩ dt (in three dimensions l (l + 1) takes the place of n²; Debye 1929).
//! * ⟨ω²⟩ = kT/I at equilibrium (equipartition).

use carom_engine::{BodyView, Observer, View};
use carom_geometry::GeometryError;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{
    Group,
    lags::{Clock, LagSum, LaggedSample, Lags, PairSums},
};

/// Correlations of the orientations and angular velocities of the bodies that can turn.
///
/// Round, locked and fixed bodies do not count: contacts do not turn them. Samples must be one
/// spacing apart. A body contributes while it exists and belongs to the group.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{Group, OrientationCorrelation};
/// use std::f64::consts::TAU;
///
/// // A dumbbell that turns once per unit of time.
/// let scene = Scene::from_toml(r#"
///     [[molecule]]
///     shape = "dumbbell"
///     atom_radius = 0.1
///     atom_mass = 1.0
///     at = [0.5, 0.5]
///     angular_velocity = 6.283185307179586
/// "#)?;
/// let mut simulation = Simulation::new(&scene)?;
/// let mut correlation = OrientationCorrelation::new(Group::All, 0.125, 1.0)?;
/// for sample in 0..=8 {
///     simulation.observe_until(0.125 * f64::from(sample), &mut correlation)?;
///     correlation.sample(&simulation.view());
/// }
/// let points = correlation.points();
/// let eighth = points[1];
/// assert!((eighth.first - 0.5f64.sqrt()).abs() < 1e-12 && eighth.second.abs() < 1e-12);
/// assert!((points[8].first - 1.0).abs() < 1e-12);
/// assert!((points[8].autocorrelation - TAU * TAU).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "rotational correlation")]
pub struct OrientationCorrelation {
    group: Group,
    clock: Clock,
    lags: Lags<State, Sums>,
}

/// The averages at one lag.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct OrientationPoint {
    /// The lag t (time).
    pub lag: f64,
    /// The number of pairs of one body at t₀ and at t₀ + t; they are not independent of each other.
    pub pairs: u64,
    /// C₁ = ⟨cos(θ(t₀ + t) − θ(t₀))⟩, from −1 to 1; 1 at lag 0.
    pub first: f64,
    /// C₂ = ⟨cos 2(θ(t₀ + t) − θ(t₀))⟩, from −1 to 1; 1 at lag 0.
    pub second: f64,
    /// ⟨ω(t₀ + t) ω(t₀)⟩ (1 / time²); ⟨ω²⟩ at lag 0.
    pub autocorrelation: f64,
}

/// One body at one time.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct State {
    /// (cos θ, sin θ).
    direction: DVec2,
    angular_velocity: f64,
}

#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct Sums {
    first: f64,
    second: f64,
    products: f64,
}

impl OrientationCorrelation {
    /// Correlations up to the lag `longest` (time) of samples that are `spacing` (time) apart; a
    /// `longest` below one spacing is taken as one spacing.
    ///
    /// Lags are 0, 1, 2, …, 9, 10, 20, …, 90, 100, … spacings.
    ///
    /// # Errors
    /// [`GeometryError::NotPositive`] if `spacing` or `longest` is not positive and finite.
    pub fn new(group: Group, spacing: f64, longest: f64) -> Result<Self, GeometryError> {
        let (clock, lags) = Lags::new(spacing, longest)?;
        Ok(Self { group, clock, lags })
    }

    /// The averages so far in ascending order of lag, from lag 0 on; lags without pairs are
    /// omitted.
    pub fn points(&self) -> Vec<OrientationPoint> {
        let lags = self.lags.each(&self.clock).filter(|(_, sum)| sum.pairs > 0);
        lags.map(|(lag, sum)| point(lag, sum)).collect()
    }

    /// All lags (time) in ascending order, from lag 0 on, also those without pairs.
    pub fn lags(&self) -> Vec<f64> {
        self.lags.times(&self.clock)
    }

    /// [Σx, Σw] over all samples so far, w the number of pairs: C₁ at each of the
    /// [lags](Self::lags), then C₂ at each, then the autocorrelation of ω at each.
    pub fn sums(&self) -> Vec<[f64; 2]> {
        self.lags
            .terms([|sums| sums.first, |sums| sums.second, |sums| sums.products])
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

impl Observer for OrientationCorrelation {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn sample(&mut self, view: &View<'_>) {
        if !self.lags.is_due(&self.clock, view.time()) {
            return;
        }
        let turning = |body: &BodyView<'_>| body.body.can_turn() && self.group.contains(body.body);
        let now: Vec<LaggedSample<State>> = view
            .bodies()
            .filter(turning)
            .map(|body| {
                let direction = body.motion.orientation.cos_sin();
                let state = State {
                    direction,
                    angular_velocity: body.motion.angular_velocity,
                };
                LaggedSample {
                    id: body.body.id(),
                    state,
                }
            })
            .collect();
        self.lags.take(&mut self.clock, view.time(), &now);
    }
}

impl PairSums<State> for Sums {
    fn add(&mut self, before: &State, now: &State) {
        let cos = before.direction.dot(now.direction);
        let sin = before.direction.perp_dot(now.direction);
        self.first += cos;
        // cos 2α = cos² α − sin² α.
        self.second += (cos - sin) * (cos + sin);
        self.products += before.angular_velocity * now.angular_velocity;
    }
}

fn point(lag: f64, sum: &LagSum<Sums>) -> OrientationPoint {
    let pairs = sum.pairs as f64;
    OrientationPoint {
        lag,
        pairs: sum.pairs,
        first: sum.sums.first / pairs,
        second: sum.sums.second / pairs,
        autocorrelation: sum.sums.products / pairs,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_engine::{Scene, Simulation};

    fn observe(scene: &str, samples: u32, spacing: f64, longest: f64) -> OrientationCorrelation {
        let mut simulation = Simulation::new(&Scene::from_toml(scene).unwrap()).unwrap();
        let mut correlation = OrientationCorrelation::new(Group::All, spacing, longest).unwrap();
        for sample in 0..=samples {
            simulation
                .observe_until(spacing * f64::from(sample), &mut ())
                .unwrap();
            correlation.sample(&simulation.view());
        }
        correlation
    }

    #[test]
    fn a_free_rotor_turns_uniformly_and_other_bodies_do_not_count() {
        let scene = r#"
            [[molecule]]
            shape = "dumbbell"
            atom_radius = 0.05
            atom_mass = 1.0
            at = [0.2, 0.2]
            angular_velocity = 0.7
            [[molecule]]
            shape = "dumbbell"
            atom_radius = 0.05
            atom_mass = 1.0
            rotation = "locked"
            at = [0.2, 0.7]
            [[molecule]]
            shape = "disc"
            atom_radius = 0.05
            atom_mass = 1.0
            at = [0.7, 0.7]
            [[bumper]]
            radius = 0.05
            at = [0.7, 0.2]
        "#;
        let correlation = observe(scene, 100, 0.25, 25.0);
        let points = correlation.points();
        assert_eq!(points.len(), 20);
        assert_eq!(points[0].pairs, 101);
        for point in &points {
            let angle = 0.7 * point.lag;
            assert!((point.first - angle.cos()).abs() < 1e-12, "{point:?}");
            assert!(
                (point.second - (2.0 * angle).cos()).abs() < 1e-12,
                "{point:?}"
            );
            assert!((point.autocorrelation - 0.49).abs() < 1e-14, "{point:?}");
        }
        let sums = correlation.sums();
        assert_eq!((correlation.lags().len(), sums.len()), (20, 60));
        assert_eq!(sums[47][0] / sums[47][1], points[7].autocorrelation);
        assert_eq!(sums[23][0] / sums[23][1], points[3].second);
        // Of constant length from the start, also before any pair.
        let empty = OrientationCorrelation::new(Group::All, 0.25, 25.0).unwrap();
        assert_eq!((empty.sums().len(), empty.lags()), (60, correlation.lags()));
        assert!(empty.points().is_empty());
    }

    #[test]
    fn dilute_dumbbells_dephase_as_free_rotors() {
        let scene = Scene::from_toml(
            r#"
            [box]
            seed = 5
            [[gas]]
            shape = "dumbbell"
            atom_radius = 0.001
            atom_mass = 0.5
            energy = 1.0
            count = 300
        "#,
        )
        .unwrap();
        let mut simulation = Simulation::new(&scene).unwrap();
        simulation.run_until(5.0).unwrap();
        let kt = simulation.view().temperature().unwrap();
        let moment = 1.0
            / simulation
                .view()
                .bodies()
                .next()
                .unwrap()
                .body
                .inertia()
                .inverse_moment;
        // One thermal angle of 1 radian, in which about one body in 250 has a contact; 40
        // independent origins each.
        let lag = (moment / kt).sqrt();
        let origins = 40;
        let mut correlation = OrientationCorrelation::new(Group::All, lag, lag).unwrap();
        for _ in 0..origins {
            for _ in 0..2 {
                correlation.sample(&simulation.view());
                let now = simulation.view().time().to_f64();
                simulation.run_until(now + lag).unwrap();
            }
            let now = simulation.view().time().to_f64();
            simulation.run_until(now + 1.0).unwrap();
        }
        assert_eq!(correlation.uneven(), origins - 1);
        let point = correlation.points()[1];
        assert_eq!(point.pairs, 300 * origins);
        for (n, found) in [(1.0, point.first), (2.0, point.second)] {
            let expected = f64::exp(-0.5 * n * n);
            // Variance of cos nα for Gaussian α: (1 + exp(−2n²)) / 2 − exp(−n²).
            let variance = 0.5 * (1.0 + f64::exp(-2.0 * n * n)) - f64::exp(-n * n);
            let error = (variance / point.pairs as f64).sqrt();
            assert!(
                (found - expected).abs() < 5.0 * error,
                "C{n} = {found}, not {expected} ± {error}"
            );
        }
    }
}
