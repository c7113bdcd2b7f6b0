//! Histograms of velocity components and speeds, ⟨v⁴⟩/⟨v²⟩², and Boltzmann's H of a component.
//!
//! At equilibrium a component is Gaussian with variance kT/m and the speed v has the density (m v /
//! kT) exp(−m v² / 2kT), so that ⟨v⁴⟩/⟨v²⟩² = 2 (Maxwell's distribution in two dimensions). H_x = ∫
//! f(v_x) ln f(v_x) dv_x, from the bins Σ p_k ln(p_k / w), falls to −½ ln(2πe kT/m) (Boltzmann
//! 1872). Speeds are in length / time; H takes f in their inverse.

use std::f64::consts::{E, PI};

use carom_engine::{Observer, View};
use carom_geometry::{GeometryError, check_positive};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{Group, Histogram, mean::mean_and_standard_error};

/// The range of bins chosen from the first sample, in thermal speeds √(⟨v²⟩/2); in a Maxwellian gas
/// a share of 1.5 × 10⁻⁸ lies outside.
const THERMAL_SPEEDS: f64 = 6.0;

/// Velocities of the moving bodies over the samples, relative to the centre of mass along each axis
/// on which momentum is conserved (see [`CentreOfMassFrame`](carom_engine::CentreOfMassFrame)).
///
/// At equilibrium the variance of a component is (1/m − 1/M) kT, with M the mass of all moving
/// bodies, or kT/m along an axis on which momentum is not conserved.
///
/// All bodies must have the same mass: use one tag for each kind. Velocities at samples less than
/// about three collisions per body apart are not independent.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{Group, VelocityDistribution};
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 400")?;
/// let mut simulation = Simulation::new(&scene)?;
/// let mut velocities = VelocityDistribution::adaptive(Group::All, 30);
/// velocities.sample(&simulation.view());
/// simulation.observe_until(3.0, &mut velocities)?;
/// velocities.sample(&simulation.view());
/// // They start with equal speeds, and collisions make them Maxwellian.
/// assert!((velocities.series()[0].kurtosis - 1.0).abs() < 1e-12);
/// assert!((velocities.series()[1].kurtosis - 2.0).abs() < 0.4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "maxwell")]
pub struct VelocityDistribution {
    group: Group,
    bins: usize,
    histograms: Option<Histograms>,
    series: Vec<VelocityPoint>,
}

/// Histograms with bins of the same width.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Histograms {
    components: [Histogram; 2],
    speeds: Histogram,
}

/// The velocities at one sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct VelocityPoint {
    /// Time of the sample.
    pub time: f64,
    /// The number of bodies in the group that can move.
    pub bodies: usize,
    /// ⟨v²⟩ (length² / time²).
    pub mean_square: f64,
    /// ⟨v⁴⟩/⟨v²⟩²: 1 for equal speeds, 2 for a Maxwellian gas. For N bodies of one mass and a given
    /// total energy, 2N/(N + 1) if a fixed body breaks the conservation of momentum and 2(N − 1)/N
    /// if nothing does.
    pub kurtosis: f64,
    /// H_x and H_y from the bins; `None` if no component lies in them. With N bodies it is too high
    /// by about K / 2N, K being the number of occupied bins.
    #[doc(alias = "entropy")]
    pub h: Option<DVec2>,
}

impl VelocityPoint {
    /// H of a component of a Maxwellian gas with this ⟨v²⟩: −½ ln(πe ⟨v²⟩).
    pub fn h_at_equilibrium(&self) -> f64 {
        -0.5 * libm::log(PI * E * self.mean_square)
    }
}

impl VelocityDistribution {
    /// Histograms up to the speed `largest` (length / time): `bins` for the speeds, and twice as
    /// many for each component, which has two signs; `bins` = 0 is taken as 1.
    ///
    /// # Errors
    /// [`GeometryError::NotPositive`] if `largest` is not positive and finite.
    pub fn new(group: Group, largest: f64, bins: usize) -> Result<Self, GeometryError> {
        let largest = check_positive("the largest speed of a histogram", largest)?;
        let mut velocities = Self::adaptive(group, bins);
        velocities.histograms = Some(Histograms::new(largest, velocities.bins));
        Ok(velocities)
    }

    /// Histograms up to six times √(⟨v²⟩/2) at the first sample in which the group moves.
    pub fn adaptive(group: Group, bins: usize) -> Self {
        Self { group, bins: bins.max(1), histograms: None, series: Vec::new() }
    }

    /// Histograms of the x and y components over all samples (length / time); `None` before their
    /// range is set.
    pub fn components(&self) -> Option<&[Histogram; 2]> {
        self.histograms.as_ref().map(|histograms| &histograms.components)
    }

    /// Histogram of the speeds over all samples (length / time); `None` before its range is set.
    pub fn speeds(&self) -> Option<&Histogram> {
        self.histograms.as_ref().map(|histograms| &histograms.speeds)
    }

    /// The samples so far; samples in which nothing moves are omitted.
    pub fn series(&self) -> &[VelocityPoint] {
        &self.series
    }

    /// Mean of ⟨v⁴⟩/⟨v²⟩² over the samples and its standard error; `None` with fewer than two.
    pub fn kurtosis(&self) -> Option<(f64, f64)> {
        mean_and_standard_error(self.series.iter().map(|point| point.kurtosis))
    }
}

impl Observer for VelocityDistribution {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn sample(&mut self, view: &View<'_>) {
        let moving = view.bodies().filter(|view| !view.body.is_fixed() && self.group.contains(view.body));
        let drift = view.centre_of_mass_frame().velocity();
        let velocities: Vec<DVec2> = moving.map(|view| view.motion.velocity - drift).collect();
        let count = velocities.len() as f64;
        let mean_square = velocities.iter().map(|v| v.length_squared()).sum::<f64>() / count;
        // The mean of an empty group is NaN.
        if mean_square.is_nan() || mean_square == 0.0 {
            return;
        }
        // Relative to the mean square, which neither over- nor underflows.
        let relative = velocities.iter().map(|v| v.length_squared() / mean_square);
        let kurtosis = relative.map(|square| square * square).sum::<f64>() / count;
        let largest = THERMAL_SPEEDS * (0.5 * mean_square).sqrt();
        let all = self.histograms.get_or_insert_with(|| Histograms::new(largest, self.bins));
        let mut now = all.emptied();
        for &velocity in &velocities {
            now.add(velocity);
        }
        all.absorb(&now);
        let [x, y] = now.components.each_ref().map(h_of);
        self.series.push(VelocityPoint {
            time: view.time().to_f64(),
            bodies: velocities.len(),
            mean_square,
            kurtosis,
            h: x.zip(y).map(DVec2::from),
        });
    }
}

impl Histograms {
    fn new(largest: f64, bins: usize) -> Self {
        let component = Histogram::new(-largest, largest, 2 * bins);
        Self { components: [component.clone(), component], speeds: Histogram::new(0.0, largest, bins) }
    }

    fn emptied(&self) -> Self {
        Self { components: self.components.each_ref().map(Histogram::emptied), speeds: self.speeds.emptied() }
    }

    fn add(&mut self, velocity: DVec2) {
        let [x, y] = &mut self.components;
        x.add(velocity.x);
        y.add(velocity.y);
        self.speeds.add(velocity.length());
    }

    fn absorb(&mut self, other: &Self) {
        for (mine, theirs) in self.components.iter_mut().zip(&other.components) {
            mine.absorb(theirs);
        }
        self.speeds.absorb(&other.speeds);
    }
}

/// Σ p ln(p / w) over the occupied bins, with p their share of all counts in the bins.
fn h_of(histogram: &Histogram) -> Option<f64> {
    let held: u64 = histogram.counts().iter().sum();
    let term = |&count: &u64| {
        let p = count as f64 / held as f64;
        p * libm::log(p / histogram.width())
    };
    (held > 0).then(|| histogram.counts().iter().filter(|&&count| count > 0).map(term).sum())
}
