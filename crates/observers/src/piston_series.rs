//! Place, velocity and energy of a piston at each sample.
//!
//! At equilibrium with a gas the mean of M V², twice its kinetic energy, is kT (equipartition: a
//! piston has one degree of freedom), and a piston with the constant force F keeps the gas at the
//! pressure |F|/L, with its length L.

use carom_engine::{BodyKey, Observer, View};
use serde::{Deserialize, Serialize};

/// The piston at each sample.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::PistonSeries;
///
/// let mut simulation = Simulation::new(&Scene::from_toml(
///     "[[piston]]\nx = 0.25\nmass = 3.0\nvelocity = 0.5\nstops = [0.1, 0.9]",
/// )?)?;
/// let piston = simulation.view().bodies().next().unwrap().body.key();
/// let mut series = PistonSeries::new(piston);
/// simulation.run_until(0.5)?;
/// series.sample(&simulation.view());
/// let point = series.series()[0];
/// assert_eq!([point.place, point.velocity, point.energy], [0.5, 0.5, 0.375]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct PistonSeries {
    piston: BodyKey,
    series: Vec<PistonPoint>,
    /// Sums of the place, the velocity and twice the energy over all samples.
    sums: [f64; 3],
}

/// A piston at one sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct PistonPoint {
    /// Time of the sample.
    pub time: f64,
    /// Its place on its axis (length).
    pub place: f64,
    /// Its velocity along its axis (length per time).
    pub velocity: f64,
    /// Its kinetic energy (mass × length² / time²).
    pub energy: f64,
}

impl PistonSeries {
    /// Observes the body of this handle; a body that is no piston gives no samples.
    pub fn new(piston: BodyKey) -> Self {
        Self {
            piston,
            ..Self::default()
        }
    }

    /// The samples so far.
    pub fn series(&self) -> &[PistonPoint] {
        &self.series
    }

    /// [Σx, Σw] of the place, of the velocity and of twice the energy over all samples so far.
    pub fn sums(&self) -> Vec<[f64; 2]> {
        let count = self.series.len() as f64;
        self.sums.map(|sum| [sum, count]).to_vec()
    }
}

impl Observer for PistonSeries {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn sample(&mut self, view: &View<'_>) {
        let Some(piston) = view.body(self.piston) else {
            return;
        };
        let Some(axis) = piston.body.axis_of_piston() else {
            return;
        };
        let point = PistonPoint {
            time: view.time().to_f64(),
            place: piston.motion.position[axis],
            velocity: piston.motion.velocity[axis],
            energy: piston.energy(),
        };
        let now = [point.place, point.velocity, 2.0 * point.energy];
        for (sum, term) in self.sums.iter_mut().zip(now) {
            *sum += term;
        }
        self.series.push(point);
    }
}
