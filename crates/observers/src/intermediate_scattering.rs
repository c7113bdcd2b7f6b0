//! The intermediate scattering function F(k, t) of the centres of mass.
//!
//! F_ab(k, t) = Re ⟨ρ_a(k, t₀ + t) ρ_b(−k, t₀)⟩ / √(N_a N_b) with the density waves ρ = Σ exp(i
//! k·x) of two groups, or of one with itself (Hansen & McDonald 2013, section 7.4). At lag 0 it is
//! the (partial) structure factor. It is averaged over the wave vectors of the box in the shells
//! nearest to k, and over the origins t₀. With the mass m of equal bodies at equilibrium F(k, t) =
//! S(k) − k² kT t² / 2m at short lags. Independent bodies have F = F_s, the self part, which
//! [`StructuralRelaxation`](crate::StructuralRelaxation) measures.

use carom_engine::{Observer, View};
use carom_geometry::PeriodicBox;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{
    Group,
    lags::{Clock, LaggedSample, Lags, PairSums},
    moving_frame::MovingFrame,
    scattering_scales::{ChosenWaves, ScatteringError, ScatteringScales},
    wave_vectors::sums_of_waves,
};

/// Intermediate scattering function of two groups, or of one with itself.
///
/// Positions are relative to the centre of mass of all bodies along each axis on which momentum is
/// conserved; fixed discs and molecules count, walls do not. After an edit at a sample call
/// `start`, so that the frame moves on with its new velocity. Samples must be one spacing apart.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{Group, IntermediateScattering, ScatteringScales};
/// use std::f64::consts::TAU;
///
/// // A disc moves along x, ten times through the box. The bumper fixes the frame.
/// let scene = Scene::from_toml(r#"
///     [[molecule]]
///     tags = ["disc"]
///     atoms = [{ at = [0, 0], radius = 0.05, mass = 1 }]
///     at = [0.0, 0.0]
///     velocity = [2.0, 0.0]
///     [[bumper]]
///     radius = 0.05
///     at = [0.5, 0.5]
/// "#)?;
/// let mut simulation = Simulation::new(&scene)?;
/// let disc = Group::from(simulation.find_tag("disc").expect("the scene names it"));
/// let scales = ScatteringScales { wave_number: TAU, shells: 1, spacing: 0.05, longest: 5.0 };
/// let bounds = simulation.view().bounds();
/// let mut scattering = IntermediateScattering::new([disc; 2], &bounds, scales)?;
/// for sample in 0..=20 {
///     simulation.observe_until(0.05 * f64::from(sample), &mut scattering)?;
///     scattering.sample(&simulation.view());
/// }
/// // The mean of cos 2πΔ along x and y.
/// let point = scattering.points()[3];
/// assert!((point.scattering - 0.5 * ((0.3 * TAU).cos() + 1.0)).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "dynamic structure factor")]
#[doc(alias = "coherent scattering function")]
pub struct IntermediateScattering {
    groups: [Group; 2],
    chosen: ChosenWaves,
    clock: Clock,
    frame: MovingFrame,
    lags: Lags<[DVec2; 2], Products>,
    passed_over: u64,
}

/// The average at one lag.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ScatteringPoint {
    /// The lag t (time).
    pub lag: f64,
    /// The number of pairs of one wave at t₀ and at t₀ + t; they are not independent of each other.
    pub pairs: u64,
    /// F(k, t).
    pub scattering: f64,
}

/// Σ Re ρ_a(t₀ + t) ρ_b*(t₀) / √(N_a N_b).
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct Products(f64);

impl PairSums<[DVec2; 2]> for Products {
    fn add(&mut self, before: &[DVec2; 2], now: &[DVec2; 2]) {
        self.0 += now[0].dot(before[1]);
    }
}

impl IntermediateScattering {
    /// F up to the lag `longest` of samples that are `spacing` apart.
    ///
    /// Lags are 0, 1, 2, …, 9, 10, 20, …, 90, 100, … spacings.
    ///
    /// # Errors
    /// [`ScatteringError`] if a number of `scales` is not positive and finite, if there are more
    /// than 1000 shells, or if the box has more than about 10⁷ wave vectors up to k.
    pub fn new(
        groups: [Group; 2],
        bounds: &PeriodicBox,
        scales: ScatteringScales,
    ) -> Result<Self, ScatteringError> {
        let chosen = ChosenWaves::new(bounds, &scales)?;
        let (clock, lags) = Lags::new(scales.spacing, scales.longest)?;
        Ok(Self {
            groups,
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

    /// F so far in ascending order of lag, from lag 0 on; lags without pairs are omitted.
    pub fn points(&self) -> Vec<ScatteringPoint> {
        let lags = self.lags.each(&self.clock).filter(|(_, sum)| sum.pairs > 0);
        lags.map(|(lag, sum)| ScatteringPoint {
            lag,
            pairs: sum.pairs,
            scattering: sum.sums.0 / sum.pairs as f64,
        })
        .collect()
    }

    /// All lags (time) in ascending order, from lag 0 on, also those without pairs.
    pub fn lags(&self) -> Vec<f64> {
        self.lags.times(&self.clock)
    }

    /// [Σx, Σw] at each of the [lags](Self::lags) over all samples so far: x is F of one wave
    /// vector and origin, and w is 1.
    pub fn sums(&self) -> Vec<[f64; 2]> {
        self.lags.terms([|sums| sums.0])
    }

    /// The number of samples skipped because their box differs from that of the constructor, or
    /// because a group was empty.
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

    /// ρ / √N of a group for each wave vector; `None` for an empty group.
    fn waves(&self, view: &View<'_>, group: Group) -> Option<Vec<DVec2>> {
        let sides = self.chosen.bounds.sides();
        let members = group.molecules(view);
        let places: Vec<DVec2> = members
            .map(|view| (view.motion.position - self.frame.displacement) / sides)
            .collect();
        let root = (places.len() as f64).sqrt();
        let mut waves = sums_of_waves(&places, &self.chosen.vectors);
        for wave in &mut waves {
            *wave /= root;
        }
        (root > 0.0).then_some(waves)
    }
}

impl Observer for IntermediateScattering {
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
        let [first, second] = self.groups;
        let waves = self.waves(view, first);
        let others = if first == second {
            waves.clone()
        } else {
            self.waves(view, second)
        };
        let (Some(waves), Some(others)) = (waves, others) else {
            self.passed_over += 1;
            return;
        };
        let now: Vec<LaggedSample<[DVec2; 2]>> = (0..)
            .zip(waves.into_iter().zip(others))
            .map(|(id, (wave, other))| LaggedSample {
                id,
                state: [wave, other],
            })
            .collect();
        self.lags.take(&mut self.clock, view.time(), &now);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_engine::{Scene, Simulation};
    use carom_kinematics::Orientation;

    fn scales(wave_number: f64, shells: usize) -> ScatteringScales {
        ScatteringScales {
            wave_number,
            shells,
            spacing: 0.02,
            longest: 1.0,
        }
    }

    /// Waves of single bodies at stored places, and sums over all pairs of frames.
    #[test]
    fn partial_functions_are_those_of_stored_frames() {
        let scene = "[box]\nsides = [1.0, 1.3]\nseed = 8\n[[gas]]\nradius = 0.03\nmass = 1.0\nenergy = 1.0\n\
                     count = 40\ntags = [\"a\"]\n[[gas]]\nradius = 0.02\nmass = 2.0\nenergy = 1.0\ncount = 25\n\
                     tags = [\"b\"]\n[[molecule]]\nshape = \"disc\"\natom_radius = 0.02\natom_mass = 9.0\n\
                     at = [0.5, 0.5]\nvelocity = [3.0, 1.0]\n";
        let mut simulation = Simulation::new(&Scene::from_toml(scene).unwrap()).unwrap();
        let [a, b] = ["a", "b"].map(|name| Group::from(simulation.find_tag(name).unwrap()));
        let bounds = simulation.view().bounds();
        let drift = simulation.view().centre_of_mass_frame().velocity();
        assert!(drift.length() > 0.1);
        let mut functions = [[a, a], [a, b], [Group::All; 2]]
            .map(|groups| IntermediateScattering::new(groups, &bounds, scales(25.0, 3)).unwrap());
        let vectors = functions[0].chosen.vectors.clone();
        let mut frames: Vec<Vec<[DVec2; 3]>> = Vec::new();
        for sample in 0..60 {
            let time = 0.02 * f64::from(sample);
            simulation.run_until(time).unwrap();
            let view = simulation.view();
            for function in &mut functions {
                function.sample(&view);
            }
            let wave = |&[x, y]: &[i64; 2]| {
                let mut sums = [DVec2::ZERO; 3];
                for body in view.bodies() {
                    let place = (body.motion.position - time * drift) / bounds.sides();
                    let turns = DVec2::new(x as f64, y as f64).dot(place);
                    let wave = Orientation::from_turns(turns).cos_sin();
                    sums[2] += wave;
                    for (sum, group) in sums.iter_mut().zip([a, b]) {
                        if group.contains(body.body) {
                            *sum += wave;
                        }
                    }
                }
                let counts = [40.0, 25.0, 66.0].map(f64::sqrt);
                [0, 1, 2].map(|group| sums[group] / counts[group])
            };
            frames.push(vectors.iter().map(wave).collect());
        }
        for (function, [one, other]) in functions.iter().zip([[0, 0], [0, 1], [2, 2]]) {
            for point in function.points() {
                let lag = (point.lag / 0.02).round() as usize;
                let stride = 10_usize.pow(lag.max(1).ilog10());
                let origins: Vec<usize> = (0..frames.len() - lag).step_by(stride).collect();
                let product = |&origin: &usize| -> f64 {
                    let waves = frames[origin].iter().zip(&frames[origin + lag]);
                    waves.map(|(before, now)| now[one].dot(before[other])).sum()
                };
                let sum: f64 = origins.iter().map(product).sum();
                let pairs = origins.len() * vectors.len();
                assert_eq!(point.pairs, pairs as u64);
                let expected = sum / pairs as f64;
                assert!(
                    (point.scattering - expected).abs() < 1e-12,
                    "{point:?} {expected}"
                );
            }
            assert_eq!(function.sums().len(), function.lags().len());
            assert_eq!((function.uneven(), function.passed_over()), (0, 0));
        }
    }

    #[test]
    fn numbers_out_of_range_are_refused_with_their_values() {
        let bounds = PeriodicBox::new(DVec2::new(1.0, 2.0)).unwrap();
        let error = |scales: ScatteringScales| {
            IntermediateScattering::new([Group::All; 2], &bounds, scales)
                .err()
                .map_or_else(String::new, |error| error.to_string())
        };
        assert_eq!(error(scales(40.0, 3)), "");
        assert!(error(scales(1e5, 3)).contains("but is 100000"));
        for shells in [0, 1001] {
            let said = error(scales(40.0, shells));
            assert!(
                said.contains(&format!("1 to 1000, but is {shells}")),
                "{said}"
            );
        }
        for refused in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(!error(scales(refused, 3)).is_empty());
        }
        let none = Simulation::new(&Scene::default()).unwrap();
        let bounds = none.view().bounds();
        let mut empty =
            IntermediateScattering::new([Group::All; 2], &bounds, scales(40.0, 3)).unwrap();
        empty.sample(&none.view());
        assert_eq!((empty.points().len(), empty.passed_over()), (0, 1));
    }
}
