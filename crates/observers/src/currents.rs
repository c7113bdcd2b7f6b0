//! The longitudinal and transverse current correlations C_L(k, t) and C_T(k, t).
//!
//! The current j(k, t) = Σ v exp(i k·x) over the bodies of a group has a component j_L along k and
//! a component j_T across it. C_L(k, t) = Re ⟨j_L(k, t₀ + t) j_L*(k, t₀)⟩ / N, and C_T likewise
//! (Hansen & McDonald 2013, section 7.4). They are averaged over the wave vectors of the box in the
//! shells nearest to k, and over the origins t₀. C_L = −k⁻² d²F/dt², and in a fluid C_T decays at
//! small k as exp(−ν k² t) with the kinematic viscosity ν.
//!
//! At equilibrium velocities do not depend on the places, and C(k, 0) of each component is kT times
//! the mean of 1/m. Where momentum is conserved, velocities are those relative to the centre of
//! mass, and C(k, 0) = kT (⟨1/m⟩ − S(k)/M) with the mass M of all bodies. In free flight with equal
//! masses C_T(k, t) = (kT/m) exp(−x/2) and C_L(k, t) = (kT/m) (1 − x) exp(−x/2), x = k² kT t²/m.

use carom_engine::{Observer, View};
use carom_geometry::PeriodicBox;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{
    Group,
    lags::{Clock, LaggedSample, Lags, PairSums},
    moving_frame::MovingFrame,
    scattering_scales::{ChosenWaves, ScatteringError, ScatteringScales},
    wave_vectors::sums_of_weighted_waves,
};

/// Current correlations of the moving bodies of a group at logarithmic lags.
///
/// Positions and velocities are relative to the centre of mass of all bodies along each axis on
/// which momentum is conserved. After an edit at a sample call `start`, so that the frame moves on
/// with its new velocity. Samples must be one spacing apart. Memory: 40 bytes for each wave vector,
/// 9 times for each decade of lags.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{CurrentCorrelation, Group, ScatteringScales};
/// use std::f64::consts::TAU;
///
/// // A disc moves along x. The bumper fixes the frame.
/// let scene = Scene::from_toml(r#"
///     [[molecule]]
///     atoms = [{ at = [0, 0], radius = 0.05, mass = 1 }]
///     at = [0.0, 0.0]
///     velocity = [2.0, 0.0]
///     [[bumper]]
///     radius = 0.05
///     at = [0.5, 0.5]
/// "#)?;
/// let mut simulation = Simulation::new(&scene)?;
/// let scales = ScatteringScales { wave_number: TAU, shells: 1, spacing: 0.05, longest: 5.0 };
/// let bounds = simulation.view().bounds();
/// let mut currents = CurrentCorrelation::new(Group::All, &bounds, scales)?;
/// for sample in 0..=20 {
///     simulation.observe_until(0.05 * f64::from(sample), &mut currents)?;
///     currents.sample(&simulation.view());
/// }
/// // Along the wave vector in x the current is longitudinal and turns with the place, across that
/// // in y it is transverse and constant; the mean of 4 cos 2πΔ and 0, and of 0 and 4.
/// let point = currents.points()[3];
/// assert!((point.longitudinal - 2.0 * (0.3 * TAU).cos()).abs() < 1e-12);
/// assert!((point.transverse - 2.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "transverse current autocorrelation")]
#[doc(alias = "longitudinal current autocorrelation")]
pub struct CurrentCorrelation {
    group: Group,
    chosen: ChosenWaves,
    clock: Clock,
    frame: MovingFrame,
    lags: Lags<Currents, Products>,
    passed_over: u64,
}

/// The averages at one lag.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct CurrentPoint {
    /// The lag t (time).
    pub lag: f64,
    /// The number of pairs of one wave at t₀ and at t₀ + t; they are not independent of each other.
    pub pairs: u64,
    /// C_L(k, t) (length² / time²).
    pub longitudinal: f64,
    /// C_T(k, t) (length² / time²).
    pub transverse: f64,
}

/// The current of one wave vector by √N, real and imaginary part (length / time).
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Currents {
    longitudinal: DVec2,
    transverse: DVec2,
}

/// Σ Re j(t₀ + t) j*(t₀) / N of both components.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct Products {
    longitudinal: f64,
    transverse: f64,
}

impl PairSums<Currents> for Products {
    fn add(&mut self, before: &Currents, now: &Currents) {
        self.longitudinal += now.longitudinal.dot(before.longitudinal);
        self.transverse += now.transverse.dot(before.transverse);
    }
}

impl CurrentCorrelation {
    /// C_L and C_T up to the lag `longest` of samples that are `spacing` apart.
    ///
    /// Lags are 0, 1, 2, …, 9, 10, 20, …, 90, 100, … spacings.
    ///
    /// # Errors
    /// [`ScatteringError`] if a number of `scales` is not positive and finite, if there are more
    /// than 1000 shells, or if the box has more than about 10⁷ wave vectors up to k.
    pub fn new(
        group: Group,
        bounds: &PeriodicBox,
        scales: ScatteringScales,
    ) -> Result<Self, ScatteringError> {
        let chosen = ChosenWaves::new(bounds, &scales)?;
        let (clock, lags) = Lags::new(scales.spacing, scales.longest)?;
        Ok(Self {
            group,
            chosen,
            clock,
            frame: MovingFrame::default(),
            lags,
            passed_over: 0,
        })
    }

    /// |k| of each wave vector, in ascending order (1 / length); k and −k count as one.
    pub fn wave_numbers(&self) -> &[f64] {
        &self.chosen.wave_numbers
    }

    /// The averages so far in ascending order of lag, from lag 0 on; lags without pairs are
    /// omitted.
    pub fn points(&self) -> Vec<CurrentPoint> {
        let lags = self.lags.each(&self.clock).filter(|(_, sum)| sum.pairs > 0);
        lags.map(|(lag, sum)| CurrentPoint {
            lag,
            pairs: sum.pairs,
            longitudinal: sum.sums.longitudinal / sum.pairs as f64,
            transverse: sum.sums.transverse / sum.pairs as f64,
        })
        .collect()
    }

    /// All lags (time) in ascending order, from lag 0 on, also those without pairs.
    pub fn lags(&self) -> Vec<f64> {
        self.lags.times(&self.clock)
    }

    /// [Σx, Σw] over all samples so far, w = 1 for one wave vector and origin: C_L at each of the
    /// [lags](Self::lags) (length² / time²), then C_T at each.
    pub fn sums(&self) -> Vec<[f64; 2]> {
        self.lags
            .terms([|sums| sums.longitudinal, |sums| sums.transverse])
    }

    /// The number of samples skipped because their box differs from that of the constructor, or
    /// because no body of the group moved freely.
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

    /// j / √N of each wave vector; `None` for an empty group.
    fn currents(&self, view: &View<'_>) -> Option<Vec<Currents>> {
        let sides = self.chosen.bounds.sides();
        let members = view
            .bodies()
            .filter(|view| view.body.is_free() && self.group.contains(view.body));
        let (places, velocities): (Vec<DVec2>, Vec<DVec2>) = members
            .map(|view| {
                let place = (view.motion.position - self.frame.displacement) / sides;
                (place, view.motion.velocity - self.frame.velocity)
            })
            .unzip();
        let root = (places.len() as f64).sqrt();
        let vectors = &self.chosen.vectors;
        let along_x = sums_of_weighted_waves(&places, vectors, |index| velocities[index].x);
        let along_y = sums_of_weighted_waves(&places, vectors, |index| velocities[index].y);
        let current = |(&[n_x, n_y], (x, y)): (&[i64; 2], (DVec2, DVec2))| {
            let direction = (DVec2::new(n_x as f64, n_y as f64) / sides).normalize() / root;
            Currents {
                longitudinal: direction.x * x + direction.y * y,
                transverse: direction.x * y - direction.y * x,
            }
        };
        let components = along_x.into_iter().zip(along_y);
        (root > 0.0).then(|| vectors.iter().zip(components).map(current).collect())
    }
}

impl Observer for CurrentCorrelation {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn start(&mut self, view: &View<'_>) {
        self.frame.follow(view);
    }

    fn sample(&mut self, view: &View<'_>) {
        self.frame.follow(view);
        if view.bounds() != self.chosen.bounds {
            self.passed_over += 1;
            return;
        }
        if !self.lags.is_due(&self.clock, view.time()) {
            return;
        }
        let Some(currents) = self.currents(view) else {
            self.passed_over += 1;
            return;
        };
        let now: Vec<LaggedSample<Currents>> = (0..)
            .zip(currents)
            .map(|(id, state)| LaggedSample { id, state })
            .collect();
        self.lags.take(&mut self.clock, view.time(), &now);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{StructureFactor, test_scenes::MIXTURE};
    use carom_engine::{Scene, Simulation};
    use carom_kinematics::Orientation;
    use std::f64::consts::TAU;

    fn scales(wave_number: f64, spacing: f64, longest: f64) -> ScatteringScales {
        ScatteringScales {
            wave_number,
            shells: 2,
            spacing,
            longest,
        }
    }

    /// Currents of single bodies at stored places, and sums over all pairs of frames.
    #[test]
    fn correlations_are_those_of_stored_frames() {
        let mut simulation = Simulation::new(&Scene::from_toml(MIXTURE).unwrap()).unwrap();
        let group = Group::from(simulation.find_tag("a").unwrap());
        let bounds = simulation.view().bounds();
        let drift = simulation.view().centre_of_mass_frame().velocity();
        assert!(drift.length() > 0.1);
        let mut correlation =
            CurrentCorrelation::new(group, &bounds, scales(25.0, 0.02, 1.0)).unwrap();
        let vectors = correlation.chosen.vectors.clone();
        let mut frames: Vec<Vec<[DVec2; 2]>> = Vec::new();
        for sample in 0..60 {
            let time = 0.02 * f64::from(sample);
            simulation.run_until(time).unwrap();
            let view = simulation.view();
            correlation.sample(&view);
            let currents = |&[x, y]: &[i64; 2]| {
                let along = (DVec2::new(x as f64, y as f64) / bounds.sides()).normalize();
                let mut sums = [DVec2::ZERO; 2];
                for body in view.bodies().filter(|body| group.contains(body.body)) {
                    let place = (body.motion.position - time * drift) / bounds.sides();
                    let turns = DVec2::new(x as f64, y as f64).dot(place);
                    let wave = Orientation::from_turns(turns).cos_sin() / 40f64.sqrt();
                    let velocity = body.motion.velocity - drift;
                    sums[0] += along.dot(velocity) * wave;
                    sums[1] += along.perp_dot(velocity) * wave;
                }
                sums
            };
            frames.push(vectors.iter().map(currents).collect());
        }
        for point in correlation.points() {
            let lag = (point.lag / 0.02).round() as usize;
            let stride = 10_usize.pow(lag.max(1).ilog10());
            let origins: Vec<usize> = (0..frames.len() - lag).step_by(stride).collect();
            let pairs = origins.len() * vectors.len();
            assert_eq!(point.pairs, pairs as u64);
            for (component, found) in [point.longitudinal, point.transverse].iter().enumerate() {
                let product = |&origin: &usize| -> f64 {
                    let currents = frames[origin].iter().zip(&frames[origin + lag]);
                    currents
                        .map(|(before, now)| now[component].dot(before[component]))
                        .sum()
                };
                let expected = origins.iter().map(product).sum::<f64>() / pairs as f64;
                assert!((found - expected).abs() < 1e-12, "{point:?} {expected}");
            }
        }
        assert_eq!(correlation.sums().len(), 2 * correlation.lags().len());
        assert_eq!((correlation.uneven(), correlation.passed_over()), (0, 0));
    }

    /// Bodies that pass through each other, from new places and velocities for each origin.
    #[test]
    fn a_transparent_gas_has_the_currents_of_free_flight() {
        let (mass, replicas) = (2.0, 300);
        let wave_number = 3.0 * TAU;
        let mut products: Vec<Vec<[f64; 2]>> = Vec::new();
        let mut variance = 0.0;
        for seed in 0..replicas {
            let scene = format!(
                "[box]\nseed = {seed}\n[[transparent]]\nbetween = [\"gas\"]\n[[gas]]\nradius = 0.0001\n\
                 mass = {mass:?}\ntemperature = 3.0\nvelocities = \"maxwell\"\ncount = 100\ntags = [\"gas\"]\n"
            );
            let mut simulation = Simulation::new(&Scene::from_toml(&scene).unwrap()).unwrap();
            variance += simulation.view().temperature().unwrap() / mass / f64::from(replicas);
            let bounds = simulation.view().bounds();
            let mut correlation =
                CurrentCorrelation::new(Group::All, &bounds, scales(wave_number, 0.02, 0.08))
                    .unwrap();
            for sample in 0..=4 {
                simulation.run_until(0.02 * f64::from(sample)).unwrap();
                correlation.sample(&simulation.view());
            }
            let points = correlation.points();
            assert_eq!(points.len(), 5);
            let both = points
                .iter()
                .map(|point| [point.longitudinal, point.transverse]);
            products.push(both.collect());
        }
        // All energy is fixed, but not the number of waves: |n|² = 9 and 8 or 10.
        let scene = Scene::default();
        let bounds = Simulation::new(&scene).unwrap().view().bounds();
        let chosen = ChosenWaves::new(&bounds, &scales(wave_number, 0.02, 0.08)).unwrap();
        for lag in 0..5 {
            let time = 0.02 * lag as f64;
            // The mean momentum is 0: 1/m is less by 1/M for independent places.
            let mut expected = [0.0; 2];
            for k in &chosen.wave_numbers {
                let x = k * k * variance * time * time;
                let of_one = 0.99 * variance * (-0.5 * x).exp();
                expected[0] += of_one * (1.0 - x) / chosen.wave_numbers.len() as f64;
                expected[1] += of_one / chosen.wave_numbers.len() as f64;
            }
            for component in 0..2 {
                let values = products.iter().map(|points| points[lag][component]);
                let count = f64::from(replicas);
                let mean = values.clone().sum::<f64>() / count;
                let square = values.map(|value| (value - mean).powi(2)).sum::<f64>();
                let error = (square / count / (count - 1.0)).sqrt();
                assert!(
                    (mean - expected[component]).abs() < 4.0 * error,
                    "{lag} {component}: {mean} ± {error}, not {}",
                    expected[component]
                );
                assert!(error < 0.05 * variance, "{error}");
            }
        }
    }

    /// A dense gas at equilibrium, whose S(k) is far from 1.
    #[test]
    fn equal_times_have_the_equipartition_of_a_system_without_momentum() {
        let scene = "[box]\nseed = 4\n[[gas]]\nradius = 0.07\nmass = 1.0\ntemperature = 1.0\ncount = 30\n\
                     [[gas]]\nradius = 0.05\nmass = 3.0\ntemperature = 1.0\ncount = 10\ntags = [\"heavy\"]\n";
        let mut simulation = Simulation::new(&Scene::from_toml(scene).unwrap()).unwrap();
        let heavy = Group::from(simulation.find_tag("heavy").unwrap());
        let temperature = simulation.view().temperature().unwrap();
        let bounds = simulation.view().bounds();
        for (group, inverse_mass) in [(heavy, 1.0 / 3.0), (Group::All, (30.0 + 10.0 / 3.0) / 40.0)]
        {
            let scales = ScatteringScales {
                shells: 1,
                ..scales(TAU, 0.1, 0.1)
            };
            let mut correlation = CurrentCorrelation::new(group, &bounds, scales).unwrap();
            let mut structure = StructureFactor::new([group; 2], &bounds, 1).unwrap();
            let mut blocks: Vec<[f64; 2]> = Vec::new();
            let mut before = [0.0; 2];
            let begin = simulation.view().time().to_f64();
            for sample in 1..=4000 {
                simulation
                    .run_until(begin + 0.1 * f64::from(sample))
                    .unwrap();
                correlation.sample(&simulation.view());
                structure.sample(&simulation.view());
                if sample % 100 == 0 {
                    let sums = correlation.sums();
                    let now = [sums[0][0], sums[correlation.lags().len()][0]];
                    blocks.push([0, 1].map(|part| (now[part] - before[part]) / 200.0));
                    before = now;
                }
            }
            let s = structure.points()[0].s;
            let expected = temperature * (inverse_mass - s / 60.0);
            for part in 0..2 {
                let values = blocks.iter().map(|block| block[part]);
                let (mean, error) = carom_tables::block_sums::mean_of_series(values).unwrap();
                assert!(
                    (mean - expected).abs() < 4.0 * error && error < 0.04 * expected,
                    "{part}: {mean} ± {error}, not {expected}"
                );
            }
        }
    }
}
