//! Pressure from the virial of the contacts, with no force law and no wall (mass / time²).
//!
//! p A = K + (1 / 2t) Σ r·J: K the kinetic energy of translation, r from the first body's centre of mass to the
//! second's (of the image that was touched), J the impulse on the second (virial theorem in two dimensions; Allen &
//! Tildesley 2017, section 2.4). For hard discs at equilibrium p A / K = 1 + 2 η χ.

use carom_engine::{CollisionReport, Observer, View};
use carom_geometry::PeriodicBox;
use carom_kinematics::Instant;
use serde::{Deserialize, Serialize};

use crate::mean::mean_and_standard_error;

/// Pressure in each interval between standbys.
///
/// Fixed bodies take part: with them it is the pressure against a change of the box in which their places go with
/// it and their sizes stay.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::Pressure;
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100")?;
/// let mut simulation = Simulation::new(&scene)?;
/// let mut pressure = Pressure::default();
/// pressure.start(&simulation.view());
/// for standby in 1..=10 {
///     simulation.observe_until(f64::from(standby), &mut pressure)?;
///     pressure.standby(&simulation.view());
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

/// The interval that is still open.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Interval {
    began: Instant,
    bounds: PeriodicBox,
    translation: f64,
    /// Σ r·J so far.
    virial: f64,
}

/// Pressure in the interval that ends at one standby.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PressurePoint {
    /// Time of the standby.
    pub time: f64,
    /// Share of the motion, K / A, with K the mean of its values at both ends (mass / time²).
    pub kinetic: f64,
    /// Share of the contacts, Σ r·J / (2 t A) (mass / time²).
    pub virial: f64,
}

impl PressurePoint {
    /// The pressure (mass / time²).
    pub fn pressure(&self) -> f64 {
        self.kinetic + self.virial
    }
}

impl Pressure {
    /// The intervals so far. The first begins at `start`, or at the first standby without one; an interval of no
    /// length is left out.
    pub fn series(&self) -> &[PressurePoint] {
        &self.series
    }

    /// Mean pressure over the intervals and its standard error (mass / time²); `None` with fewer than two.
    ///
    /// Meant for intervals of one length, each long against the time between two collisions of a body.
    pub fn mean(&self) -> Option<(f64, f64)> {
        mean_and_standard_error(self.series.iter().map(PressurePoint::pressure))
    }
}

impl Observer for Pressure {
    fn start(&mut self, view: &View<'_>) {
        let (began, bounds) = (view.time(), *view.bounds());
        self.interval =
            Some(Interval { began, bounds, translation: translational_energy(view), virial: 0.0 });
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        if let Some(interval) = &mut self.interval {
            interval.virial += report.separation(&interval.bounds).dot(report.impulse);
        }
    }

    fn standby(&mut self, view: &View<'_>) {
        if let Some(interval) = self.interval {
            let duration = view.time().since(interval.began);
            if duration > 0.0 {
                let area = interval.bounds.area();
                self.series.push(PressurePoint {
                    time: view.time().to_f64(),
                    kinetic: 0.5 * (interval.translation + translational_energy(view)) / area,
                    virial: interval.virial / (2.0 * duration * area),
                });
            }
        }
        self.start(view);
    }
}

/// Σ ½ m v² over the bodies that move (mass × length² / time²).
fn translational_energy(view: &View<'_>) -> f64 {
    let of = |inverse_mass: f64, speed_squared: f64| {
        if inverse_mass == 0.0 { 0.0 } else { 0.5 * speed_squared / inverse_mass }
    };
    view.bodies()
        .map(|view| of(view.body.inertia().inverse_mass, view.motion.velocity.length_squared()))
        .sum()
}
