//! Histograms of velocity components and speeds, ⟨v⁴⟩/⟨v²⟩², and Boltzmann's H of a component.
//!
//! At equilibrium a component is Gaussian with variance kT/m and the speed v has the density (m v /
//! kT) exp(−m v² / 2kT), so that ⟨v⁴⟩/⟨v²⟩² = 2 (Maxwell's distribution in two dimensions). H_x = ∫
//! f(v_x) ln f(v_x) dv_x, from the bins Σ p_k ln(p_k / w), falls to −½ ln(2πe kT/m) (Boltzmann
//! 1872). Speeds are in length / time; H takes f in their inverse.

use std::f64::consts::{E, PI};

use carom_engine::{Observer, View};
use carom_geometry::{GeometryError, check_positive};
use carom_kinematics::Motion;
use carom_tables::block_sums::mean_of_series;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{AdaptiveHistogram, Group, Histogram};

/// The range of the bins for H at one sample, in its thermal speeds √(⟨v²⟩/2); in a Maxwellian gas
/// a
/// share of 1.5 × 10⁻⁸ lies outside.
const THERMAL_SPEEDS: f64 = 6.0;

/// Velocities of the moving bodies over the samples, relative to the centre of mass along each axis
/// on which momentum is conserved (see [`CentreOfMassFrame`](carom_engine::CentreOfMassFrame)).
///
/// At equilibrium the variance of a component is (1/m − 1/M) kT, with M the mass of all moving
/// bodies, or kT/m along an axis on which momentum is not conserved.
///
/// All bodies must have the same mass: use one tag for each kind. Velocities at samples less than
/// about three collisions per body apart are not independent. Samples in which no body moves count
/// with the velocity 0.
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
/// let kurtosis: Vec<f64> = velocities.series().iter().filter_map(|point|
/// point.kurtosis).collect();
/// assert!((kurtosis[0] - 1.0).abs() < 1e-12 && (kurtosis[1] - 2.0).abs() < 0.4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "maxwell")]
pub struct VelocityDistribution {
    group: Group,
    bins: usize,
    /// The range, if it is given (length / time).
    largest: Option<f64>,
    components: [AdaptiveHistogram; 2],
    speeds: AdaptiveHistogram,
    moments: SpeedMoments,
    series: Vec<VelocityPoint>,
}

/// Powers of the speeds, summed over all bodies and samples.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SpeedMoments {
    /// Number of speeds.
    pub count: f64,
    /// Σv² (length² / time²).
    pub squares: f64,
    /// Σv⁴ (length⁴ / time⁴).
    pub fourth_powers: f64,
}

impl SpeedMoments {
    /// ⟨v⁴⟩/⟨v²⟩² of all speeds together; `None` if nothing has moved. It exceeds 2 in a gas whose
    /// temperature changes.
    pub fn kurtosis(&self) -> Option<f64> {
        (self.squares > 0.0)
            .then(|| self.count * (self.fourth_powers / self.squares) / self.squares)
    }
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
    /// if nothing does. `None` for a single body, for which it is 1 whatever its distribution (see
    /// [`SpeedMoments::kurtosis`]), and if nothing moves.
    pub kurtosis: Option<f64>,
    /// H_x and H_y from equal bins, up to the given range or six times √(⟨v²⟩/2) of this sample;
    /// `None` for a single body, or if no component lies in them. With N bodies it is too high by
    /// about K / 2N, K being the number of occupied bins.
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
    /// Bins up to the speed `largest` (length / time): `bins` for the speeds, and twice as many for
    /// each component, which has two signs; `bins` = 0 is taken as 1. What lies outside is counted.
    ///
    /// # Errors
    /// [`GeometryError::NotPositive`] if `largest` is not positive and finite.
    pub fn new(group: Group, largest: f64, bins: usize) -> Result<Self, GeometryError> {
        let largest = check_positive("the largest speed of a histogram", largest)?;
        let component = AdaptiveHistogram::within(-largest, largest, 2 * bins.max(1));
        Ok(Self {
            largest: Some(largest),
            components: [component.clone(), component],
            speeds: AdaptiveHistogram::within(0.0, largest, bins),
            ..Self::adaptive(group, bins)
        })
    }

    /// Bins whose range follows the velocities of all samples, so that none is lost: at least
    /// `bins` for the speeds, and twice as many for each component.
    pub fn adaptive(group: Group, bins: usize) -> Self {
        let bins = bins.max(1);
        let component = AdaptiveHistogram::of_components(bins);
        Self {
            group,
            bins,
            largest: None,
            components: [component.clone(), component],
            speeds: AdaptiveHistogram::of_magnitudes(bins),
            moments: SpeedMoments::default(),
            series: Vec::new(),
        }
    }

    /// Distributions of the x and y components over all samples (length / time).
    pub fn components(&self) -> &[AdaptiveHistogram; 2] {
        &self.components
    }

    /// Distribution of the speeds over all samples (length / time).
    pub fn speeds(&self) -> &AdaptiveHistogram {
        &self.speeds
    }

    /// Moments of the speeds over all samples.
    pub fn moments(&self) -> SpeedMoments {
        self.moments
    }

    /// The samples so far in which the group had bodies that can move.
    pub fn series(&self) -> &[VelocityPoint] {
        &self.series
    }

    /// Mean of ⟨v⁴⟩/⟨v²⟩² over the samples and its standard error; `None` with fewer than two.
    pub fn kurtosis(&self) -> Option<(f64, f64)> {
        let values: Vec<f64> = self
            .series
            .iter()
            .filter_map(|point| point.kurtosis)
            .collect();
        mean_of_series(values)
    }

    /// H_x and H_y of these velocities, whose mean square is `mean_square`.
    fn h(&self, velocities: &[DVec2], mean_square: f64) -> Option<DVec2> {
        let largest = self
            .largest
            .unwrap_or(THERMAL_SPEEDS * (0.5 * mean_square).sqrt());
        if velocities.len() < 2 || largest == 0.0 {
            return None;
        }
        let of = |component: fn(&DVec2) -> f64| {
            let mut histogram = Histogram::new(-largest, largest, 2 * self.bins);
            for velocity in velocities {
                histogram.add(component(velocity));
            }
            h_of(&histogram)
        };
        Some(DVec2::new(
            of(|velocity| velocity.x)?,
            of(|velocity| velocity.y)?,
        ))
    }
}

impl Observer for VelocityDistribution {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn sample(&mut self, view: &View<'_>) {
        let moving = view
            .bodies()
            .filter(|view| view.body.is_free() && self.group.contains(view.body));
        let frame = view.centre_of_mass_frame();
        let relative = |motion: &Motion| motion.velocity - frame.velocity_at(motion.position);
        let velocities: Vec<DVec2> = moving.map(|view| relative(&view.motion)).collect();
        let count = velocities.len() as f64;
        let mean_square = velocities.iter().map(|v| v.length_squared()).sum::<f64>() / count;
        // The mean of an empty group is NaN.
        if mean_square.is_nan() {
            return;
        }
        let [x, y] = &mut self.components;
        for velocity in &velocities {
            x.add(velocity.x);
            y.add(velocity.y);
            self.speeds.add(velocity.length());
            let square = velocity.length_squared();
            self.moments.count += 1.0;
            self.moments.squares += square;
            self.moments.fourth_powers += square * square;
        }
        // Relative to the mean square, which neither over- nor underflows.
        let relative = velocities.iter().map(|v| v.length_squared() / mean_square);
        let kurtosis = relative.map(|square| square * square).sum::<f64>() / count;
        let has_shape = velocities.len() > 1 && mean_square > 0.0;
        self.series.push(VelocityPoint {
            time: view.time().to_f64(),
            bodies: velocities.len(),
            mean_square,
            kurtosis: has_shape.then_some(kurtosis),
            h: self.h(&velocities, mean_square),
        });
    }
}

/// Σ p ln(p / w) over the occupied bins, with p their share of all counts in the bins.
fn h_of(histogram: &Histogram) -> Option<f64> {
    let held: u64 = histogram.counts().iter().sum();
    let term = |&count: &u64| {
        let p = count as f64 / held as f64;
        p * libm::log(p / histogram.width())
    };
    (held > 0).then(|| {
        histogram
            .counts()
            .iter()
            .filter(|&&count| count > 0)
            .map(term)
            .sum()
    })
}
