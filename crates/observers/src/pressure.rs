//! Pressure from the virial of the contacts, without a force law or a wall (mass / time²).
//!
//! p A = N kT + W with W = (1 / 2t) Σ r·J: N moving bodies, kT their temperature relative to the
//! centre of mass, r from the first body's centre of mass to that of the touched image of the
//! second, J the impulse on the second (virial theorem in two dimensions; Allen & Tildesley 2017,
//! section 2.4). This is the pressure of the canonical ensemble at any N: β p A = N + W / kT, for
//! two discs 2 + πσ²/(A − πσ²) exactly. For many hard discs at equilibrium it is N (1 + 2 η χ).
//!
//! The momentum flux (K + W) / A, with K the translational energy relative to the centre of mass,
//! is smaller by kT / A, because momentum conservation removes 2 of the 2N degrees of freedom from
//! K.

use carom_engine::{CollisionReport, Observer, View};
use carom_geometry::PeriodicBox;
use carom_tables::block_sums::mean_of_series;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::open_interval::OpenInterval;

/// Pressure in each interval between samples. An edit within an interval divides it if it is
/// announced by [`Observer::pause`]; the interval begins anew if it is not.
///
/// Fixed bodies are included: the pressure is then that against a change of the box that moves
/// their positions with it and keeps their sizes.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::Pressure;
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100")?;
/// let mut simulation = Simulation::new(&scene)?;
/// let mut pressure = Pressure::default();
/// pressure.start(&simulation.view());
/// for sample in 1..=10 {
///     simulation.observe_until(f64::from(sample), &mut pressure)?;
///     pressure.sample(&simulation.view());
/// }
/// // More than the 100 of an ideal gas: the discs have a size.
/// let (mean, _) = pressure.mean().expect("there are ten intervals");
/// assert!(mean > 100.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Pressure {
    interval: Option<Interval>,
    series: Vec<PressurePoint>,
}

/// The open interval.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Interval {
    bounds: PeriodicBox,
    /// N kT and K.
    thermal: OpenInterval<DVec2>,
    /// Σ r·J so far.
    virial: f64,
}

/// Pressure in the interval that ends at one sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct PressurePoint {
    /// Time of the sample.
    pub time: f64,
    /// Pressure of an ideal gas, N kT / A, with kT the mean of its values at both ends (mass /
    /// time²); 0 if there is no temperature, as for a single disc with conserved momentum.
    pub ideal: f64,
    /// Kinetic part of the momentum flux, K / A, with K the mean of its values at both ends (mass /
    /// time²).
    pub kinetic: f64,
    /// Contribution of the contacts, Σ r·J / (2 t A) (mass / time²).
    pub virial: f64,
}

impl PressurePoint {
    /// The pressure (N kT + W) / A (mass / time²).
    pub fn pressure(&self) -> f64 {
        self.ideal + self.virial
    }

    /// The flux of momentum relative to the centre of mass, (K + W) / A (mass / time²).
    pub fn momentum_flux(&self) -> f64 {
        self.kinetic + self.virial
    }

    /// β p A / N; `None` if there is no temperature, or nothing moves.
    #[doc(alias = "Z")]
    pub fn compressibility_factor(&self) -> Option<f64> {
        (self.ideal > 0.0).then(|| self.pressure() / self.ideal)
    }
}

impl Pressure {
    /// The intervals so far. The first begins at `start`, or at the first sample without one.
    /// Intervals of length 0 are omitted.
    pub fn series(&self) -> &[PressurePoint] {
        &self.series
    }

    /// Mean pressure over the intervals and its standard error from blocks (mass / time²); `None`
    /// with fewer than two intervals. They count equally: it holds for intervals of equal length.
    pub fn mean(&self) -> Option<(f64, f64)> {
        mean_of_series(self.series.iter().map(PressurePoint::pressure))
    }

    /// β p A / N of the mean pressure and temperature over the intervals and its standard error;
    /// `None` with fewer than two, or without a temperature.
    pub fn compressibility_factor(&self) -> Option<(f64, f64)> {
        let mean = |of: fn(&PressurePoint) -> f64| {
            self.series.iter().map(of).sum::<f64>() / self.series.len() as f64
        };
        let ideal = mean(|point| point.ideal);
        let factor = mean(PressurePoint::pressure) / ideal;
        // The ratio to first order in the fluctuations of both.
        let linear =
            |point: &PressurePoint| factor + (point.pressure() - factor * point.ideal) / ideal;
        let found = mean_of_series(self.series.iter().map(linear));
        found.filter(|_| ideal > 0.0)
    }

    /// Begins an interval with these values of N kT and K.
    fn open_interval(&mut self, view: &View<'_>, now: DVec2) {
        let thermal = OpenInterval::new(view.time(), now);
        self.interval = Some(Interval {
            bounds: view.bounds(),
            thermal,
            virial: 0.0,
        });
    }
}

impl Observer for Pressure {
    fn start(&mut self, view: &View<'_>) {
        let (time, now) = (view.time(), thermal(view));
        let continues = self
            .interval
            .as_mut()
            .is_some_and(|interval| interval.thermal.proceed(time, now));
        if !continues {
            self.open_interval(view, now);
        }
    }

    fn pause(&mut self, view: &View<'_>) {
        if let Some(interval) = &mut self.interval {
            interval.thermal.pause(view.time(), thermal(view));
        }
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        if let Some(interval) = &mut self.interval {
            interval.virial += report.separation().dot(report.impulse);
        }
    }

    fn sample(&mut self, view: &View<'_>) {
        let now = thermal(view);
        if let Some(interval) = self.interval {
            let duration = interval.thermal.duration(view.time());
            if duration > 0.0 {
                let area = interval.bounds.area();
                let mean = interval.thermal.mean(view.time(), now);
                self.series.push(PressurePoint {
                    time: view.time().to_f64(),
                    ideal: mean.x / area,
                    kinetic: mean.y / area,
                    virial: interval.virial / (2.0 * duration * area),
                });
            }
        }
        self.open_interval(view, now);
    }
}

/// N kT and the translational energy K, both relative to the centre of mass (mass × length² /
/// time²).
fn thermal(view: &View<'_>) -> DVec2 {
    let thermal = view.centre_of_mass_frame().thermal(view.bodies());
    DVec2::new(
        thermal.bodies as f64 * thermal.temperature().unwrap_or(0.0),
        thermal.translation,
    )
}
