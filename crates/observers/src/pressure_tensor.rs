//! The pressure tensor from the momenta and the virial of the contacts (mass / time²).
//!
//! p_ab A = Σ m v_a v_b + (1 / t) Σ r_a J_b: v relative to the centre of mass, r from the first
//! body's centre of mass to that of the touched image of the second, J the impulse on the second
//! (virial theorem; Allen & Tildesley 2017, section 2.7). Half the trace is the momentum flux of
//! [`Pressure`](crate::Pressure); at equilibrium p_xx = p_yy and p_xy = p_yx = 0 on average.
//!
//! The impulse of two discs is parallel to r, so that p_xy = p_yx. Molecules that turn have
//! r_x J_y − r_y J_x = −Δ(Σ I ω), so that A t (p_xy − p_yx) is the decrease of Σ I ω in the
//! interval; the mean over a long time vanishes. At a straight wall J is normal to the wall, and
//! the component of r along the wall depends on where its centre is: of the off-diagonal
//! components only that with r along the normal has a meaning then (p_xy for a wall along y).
//!
//! Under shear v is relative to the flow too. Then p_xy < 0 for γ > 0, and the viscosity is
//! −(p_xy + p_yx)/2γ.

use carom_engine::{CollisionReport, Observer, View};
use carom_geometry::PeriodicBox;
use glam::DMat2;
use serde::{Deserialize, Serialize};

use crate::{Estimate, open_interval::OpenInterval};

/// Pressure tensor in each interval between samples, of all bodies.
///
/// It has no group: the impulse of a contact between groups belongs to both. Fixed bodies are
/// included as in [`Pressure`](crate::Pressure). An edit within an interval divides it if it is
/// announced by [`Observer::pause`]; the interval begins anew if it is not.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{Pressure, PressureTensor};
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100")?;
/// let mut simulation = Simulation::new(&scene)?;
/// let mut both = (Pressure::default(), PressureTensor::default());
/// both.start(&simulation.view());
/// for sample in 1..=10 {
///     simulation.observe_until(f64::from(sample), &mut both)?;
///     both.sample(&simulation.view());
/// }
/// let (pressure, tensor) = both;
/// for (scalar, point) in pressure.series().iter().zip(tensor.series()) {
///     assert!((0.5 * (point.xx() + point.yy()) / scalar.momentum_flux() - 1.0).abs() < 1e-12);
///     assert!((point.xy() - point.yx()).abs() < 1e-12 * point.xx());
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[doc(alias = "stress")]
pub struct PressureTensor {
    interval: Option<Interval>,
    series: Vec<TensorPoint>,
    /// Σ p t over the intervals, in the order of [`PressureTensor::sums`] (mass / time).
    sums: [f64; 4],
    duration: f64,
    /// Σ |γ| t over the intervals, and Σ −(p_xy + p_yx) t/2 with the sign of γ (1; mass / time).
    sheared: [f64; 2],
}

/// The open interval.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Interval {
    bounds: PeriodicBox,
    /// Shear rate (1/time).
    shear_rate: f64,
    /// Σ m v_a v_b.
    momenta: OpenInterval<DMat2>,
    /// Σ r_a J_b so far.
    virial: DMat2,
}

/// The pressure tensor in the interval that ends at one sample.
///
/// Column b of a matrix has the components x b and y b.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct TensorPoint {
    /// Time of the sample.
    pub time: f64,
    /// Length of the interval (time).
    pub duration: f64,
    /// Kinetic part Σ m v_a v_b / A, the mean of its values at both ends (mass / time²).
    pub kinetic: DMat2,
    /// Contribution of the contacts, Σ r_a J_b / (t A) (mass / time²).
    pub virial: DMat2,
}

impl TensorPoint {
    /// Flux along x of the momentum along x (mass / time²).
    pub fn xx(&self) -> f64 {
        self.kinetic.x_axis.x + self.virial.x_axis.x
    }

    /// Flux along x of the momentum along y (mass / time²).
    pub fn xy(&self) -> f64 {
        self.kinetic.y_axis.x + self.virial.y_axis.x
    }

    /// Flux along y of the momentum along x (mass / time²).
    pub fn yx(&self) -> f64 {
        self.kinetic.x_axis.y + self.virial.x_axis.y
    }

    /// Flux along y of the momentum along y (mass / time²).
    pub fn yy(&self) -> f64 {
        self.kinetic.y_axis.y + self.virial.y_axis.y
    }

    fn components(&self) -> [f64; 4] {
        [self.xx(), self.xy(), self.yx(), self.yy()]
    }
}

impl PressureTensor {
    /// The intervals so far. The first begins at `start`, or at the first sample without one.
    /// Intervals of length 0 are omitted.
    pub fn series(&self) -> &[TensorPoint] {
        &self.series
    }

    /// [Σx, Σw] of p_xx, p_xy, p_yx and p_yy over all intervals so far: x is the component times
    /// the length of the interval, and w is the length (mass / time, and time).
    pub fn sums(&self) -> Vec<[f64; 2]> {
        self.sums.map(|sum| [sum, self.duration]).to_vec()
    }

    /// [Σx, Σw] of the viscosity −(p_xy + p_yx)/2γ over all intervals with a shear so far: x is the
    /// viscosity times w, and w = Σ |γ| t, which is 0 without shear (mass / time; 1).
    pub fn viscosity_sum(&self) -> [f64; 2] {
        [self.sheared[1], self.sheared[0]]
    }

    /// Means of p_xx, p_xy, p_yx and p_yy over the intervals, weighted with their lengths, and
    /// standard errors (mass / time²); `None` with fewer than two intervals.
    ///
    /// The errors hold for intervals long against the time between two collisions of a body.
    pub fn mean(&self) -> Option<[Estimate; 4]> {
        let of = |component: usize| {
            let products = |point: &TensorPoint| {
                (
                    point.components()[component] * point.duration,
                    point.duration,
                )
            };
            Estimate::of_ratio(self.series.iter().map(products))
        };
        Some([of(0)?, of(1)?, of(2)?, of(3)?])
    }

    /// Begins an interval with this value of Σ m v_a v_b.
    fn open_interval(&mut self, view: &View<'_>, now: DMat2) {
        let momenta = OpenInterval::new(view.time(), now);
        self.interval = Some(Interval {
            bounds: view.bounds(),
            shear_rate: view.shear_rate(),
            momenta,
            virial: DMat2::ZERO,
        });
    }
}

impl Observer for PressureTensor {
    fn start(&mut self, view: &View<'_>) {
        let (time, now) = (view.time(), momenta(view));
        let continues = self
            .interval
            .as_mut()
            .is_some_and(|interval| interval.momenta.proceed(time, now));
        if !continues {
            self.open_interval(view, now);
        }
    }

    fn pause(&mut self, view: &View<'_>) {
        if let Some(interval) = &mut self.interval {
            interval.momenta.pause(view.time(), momenta(view));
        }
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        if let Some(interval) = &mut self.interval {
            let separation = report.separation();
            let impulse = report.impulse;
            interval.virial += DMat2::from_cols(separation * impulse.x, separation * impulse.y);
        }
    }

    fn sample(&mut self, view: &View<'_>) {
        let now = momenta(view);
        if let Some(interval) = self.interval {
            let duration = interval.momenta.duration(view.time());
            if duration > 0.0 {
                let area = interval.bounds.area();
                let point = TensorPoint {
                    time: view.time().to_f64(),
                    duration,
                    kinetic: interval.momenta.mean(view.time(), now) * (1.0 / area),
                    virial: interval.virial * (1.0 / (duration * area)),
                };
                for (sum, component) in self.sums.iter_mut().zip(point.components()) {
                    *sum += component * duration;
                }
                self.duration += duration;
                let rate = interval.shear_rate;
                if rate != 0.0 {
                    let stress = -0.5 * rate.signum() * (point.xy() + point.yx());
                    self.sheared[0] += rate.abs() * duration;
                    self.sheared[1] += stress * duration;
                }
                self.series.push(point);
            }
        }
        self.open_interval(view, now);
    }
}

/// Σ m v_a v_b relative to the centre of mass, and to the flow under shear (mass × length² /
/// time²).
fn momenta(view: &View<'_>) -> DMat2 {
    let frame = view.centre_of_mass_frame();
    let moving = view.bodies().filter(|view| view.body.is_free());
    let flux = moving.map(|body| {
        let velocity = body.motion.velocity - frame.velocity_at(body.motion.position);
        let momentum = velocity / body.body.inertia().inverse_mass;
        DMat2::from_cols(velocity * momentum.x, velocity * momentum.y)
    });
    flux.sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Pressure;
    use carom_engine::{Scene, Simulation};

    fn observe(scene: &str, samples: u32, spacing: f64) -> (Pressure, PressureTensor, Simulation) {
        let mut simulation = Simulation::new(&Scene::from_toml(scene).unwrap()).unwrap();
        let mut both = (Pressure::default(), PressureTensor::default());
        both.start(&simulation.view());
        for sample in 1..=samples {
            simulation
                .observe_until(spacing * f64::from(sample), &mut both)
                .unwrap();
            both.sample(&simulation.view());
        }
        (both.0, both.1, simulation)
    }

    const DUMBBELLS: &str = r#"
        [[gas]]
        shape = "dumbbell"
        atom_radius = 0.02
        atom_mass = 1.0
        energy = 1.0
        count = 60
    "#;

    #[test]
    fn half_the_trace_is_the_momentum_flux() {
        let bumper = format!("{DUMBBELLS}\n[[bumper]]\nradius = 0.1\nat = [0.5, 0.5]");
        for scene in [DUMBBELLS, &bumper] {
            let (pressure, tensor, _) = observe(scene, 20, 0.3);
            assert_eq!(tensor.series().len(), 20);
            for (scalar, point) in pressure.series().iter().zip(tensor.series()) {
                assert_eq!(scalar.time, point.time);
                let half_trace = 0.5 * (point.xx() + point.yy());
                assert!((half_trace / scalar.momentum_flux() - 1.0).abs() < 1e-12);
            }
            let flux = pressure
                .series()
                .iter()
                .map(|point| 0.3 * point.momentum_flux())
                .sum::<f64>();
            let sums = tensor.sums();
            assert!((0.5 * (sums[0][0] + sums[3][0]) / flux - 1.0).abs() < 1e-12);
            assert!((sums[0][1] - 6.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_disc_between_two_walls_presses_along_one_axis_only() {
        // It bounces between x = 0.1 and 0.9 with speed 2: Δp = 4 every 0.4 units of time. Along y
        // it moves with the frame of the centre of mass.
        let scene = r"
            [[wall]]
            x = 0.0
            [[molecule]]
            atoms = [{ at = [0, 0], radius = 0.1, mass = 1 }]
            at = [0.5, 0.5]
            velocity = [2.0, 3.0]
        ";
        let (_, tensor, _) = observe(scene, 5, 0.8);
        for point in tensor.series() {
            // Σ m v² = 4, and r_x J_x = 0.1 × 4 at each of two contacts in an interval. 4 + 1
            // is the pressure of a point in a box shorter by the diameter: 4 / 0.8.
            assert!((point.kinetic.x_axis.x - 4.0).abs() < 1e-12);
            assert!(
                (point.virial.x_axis.x - 2.0 * 4.0 * 0.1 / 0.8).abs() < 1e-12,
                "{point:?}"
            );
            assert!((point.xx() - 4.0 / 0.8).abs() < 1e-12);
            assert!(
                point.xy().abs() < 1e-12 && point.yy().abs() < 1e-12,
                "{point:?}"
            );
        }
    }

    #[test]
    fn antisymmetry_is_the_loss_of_spin() {
        let spin = |simulation: &Simulation| -> f64 {
            let bodies = simulation.view().bodies();
            bodies
                .map(|body| body.motion.angular_velocity / body.body.inertia().inverse_moment)
                .sum()
        };
        let before = spin(&Simulation::new(&Scene::from_toml(DUMBBELLS).unwrap()).unwrap());
        let (_, tensor, simulation) = observe(DUMBBELLS, 1, 3.0);
        let sums = tensor.sums();
        let lost = before - spin(&simulation);
        assert!(lost.abs() > 1e-3, "it changes");
        assert!(
            (sums[1][0] - sums[2][0] - lost).abs() < 1e-11,
            "{sums:?} {lost}"
        );
    }

    #[test]
    fn a_gas_at_equilibrium_is_isotropic() {
        let scene =
            "[box]\nseed = 3\n[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 200";
        let (pressure, tensor, _) = observe(scene, 60, 0.5);
        let [xx, xy, yx, yy] = tensor.mean().unwrap();
        let error = xx.standard_error.hypot(yy.standard_error);
        assert!((xx.mean - yy.mean).abs() < 5.0 * error && error < 0.02 * xx.mean);
        assert!(xy.mean.abs() < 5.0 * xy.standard_error && (xy.mean - yx.mean).abs() < 1e-10);
        assert!(pressure.series().len() == tensor.series().len());
    }
}
