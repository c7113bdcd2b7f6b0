//! Free flight of a group at equilibrium: what bodies do before their first contacts.

use carom::{View, engine::BodyView};
use serde::{Deserialize, Serialize};

use super::Selection;

/// Source of the prediction, which holds until bodies have contacts.
pub(super) const FREE_FLIGHT: &str =
    "approximation, short lags: free flight with the Maxwell distribution";

/// The variances of the velocities of a group at equilibrium.
#[derive(Serialize, Deserialize)]
pub(super) struct Thermal {
    /// kT of the system (mass × length² / time²); `None` without thermal motion.
    temperature: Option<f64>,
    /// The masses of the bodies that move, and the number of bodies with each.
    masses: Vec<(f64, u64)>,
    /// Along x and y: 1/M, with the mass M of all bodies that move, if momentum is conserved; else
    /// 0.
    shared: [f64; 2],
}

impl Thermal {
    /// Of the moving bodies of a selection.
    pub(super) fn new(selection: &Selection<'_>) -> Self {
        let view: &View<'_> = selection.view;
        let mass = |body: &BodyView<'_>| 1.0 / body.body.inertia().inverse_mass;
        let all: f64 = view
            .bodies()
            .filter(|body| body.body.is_free())
            .map(|body| mass(&body))
            .sum();
        let mut of_group: Vec<f64> = selection.moving().map(|body| mass(&body)).collect();
        of_group.sort_by(f64::total_cmp);
        let equal = of_group.chunk_by(|one, other| one == other);
        Self {
            temperature: view.temperature().filter(|kt| *kt > 0.0),
            masses: equal.map(|equal| (equal[0], equal.len() as u64)).collect(),
            shared: view
                .centre_of_mass_frame()
                .conserves_momentum()
                .map(|is_conserved| {
                    if is_conserved && all > 0.0 {
                        1.0 / all
                    } else {
                        0.0
                    }
                }),
        }
    }

    /// F_s(k, t) of free flight, ⟨exp(−k² t² ⟨v_x²⟩ / 2)⟩ over bodies and axes.
    pub(super) fn scattering(&self, wave_number: f64, lag: f64) -> Option<f64> {
        let phase = wave_number * lag;
        self.mean(|[x, y]| {
            let [x, y] = [x, y].map(|variance| (-0.5 * phase * phase * variance).exp());
            0.5 * (x + y)
        })
    }

    /// C_L(k, t) and C_T(k, t) of free flight and independent places, averaged over wave numbers k
    /// (length² / time²). Where the variances along x and y differ, they have their mean.
    pub(super) fn currents(&self, wave_numbers: &[f64], lag: f64) -> Option<[f64; 2]> {
        let of_wave = |variance: f64, wave_number: f64, is_along: bool| {
            let square = (wave_number * lag).powi(2) * variance;
            let along = if is_along { 1.0 - square } else { 1.0 };
            variance * along * (-0.5 * square).exp()
        };
        let component = |is_along: bool| {
            self.mean(|[x, y]| {
                let waves = wave_numbers
                    .iter()
                    .map(|&wave_number| of_wave(0.5 * (x + y), wave_number, is_along));
                waves.sum::<f64>() / wave_numbers.len() as f64
            })
        };
        Some([component(true)?, component(false)?])
    }

    /// G_s(r, t) of free flight (1 / length²), averaged over the ring between two displacements:
    /// the share exp(−r²/2σ²) of the bodies has moved farther than r, with σ² = ⟨v_x²⟩ t². Where
    /// the variances along x and y differ, σ² is their mean.
    pub(super) fn displacements(&self, [low, high]: [f64; 2], lag: f64) -> Option<f64> {
        let area = std::f64::consts::PI * (high - low) * (high + low);
        self.mean(|[x, y]| {
            let variance = 0.5 * (x + y) * lag * lag;
            let [near, far] = [low, high].map(|edge| (-0.5 * edge * edge / variance).exp());
            (near - far) / area
        })
    }

    /// The mean over the bodies of a function of the variances of both components of the velocity
    /// relative to the centre of mass, (1/m − 1/M) kT (length² / time²).
    fn mean(&self, of: impl Fn([f64; 2]) -> f64) -> Option<f64> {
        let temperature = self.temperature?;
        let (mut sum, mut count) = (0.0, 0.0);
        for &(mass, bodies) in &self.masses {
            let variances = self
                .shared
                .map(|shared| temperature * (1.0 / mass - shared).max(0.0));
            sum += bodies as f64 * of(variances);
            count += bodies as f64;
        }
        Some(sum / count).filter(|value| value.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_flight_of_two_masses_is_the_mean_of_their_gaussians() {
        let thermal = Thermal {
            temperature: Some(2.0),
            masses: vec![(1.0, 3), (4.0, 1)],
            shared: [0.0, 0.1],
        };
        let gaussian = |variance: f64| f64::exp(-0.5 * 9.0 * 0.01 * variance);
        let expected =
            (3.0 * (gaussian(2.0) + gaussian(1.8)) + gaussian(0.5) + gaussian(0.3)) / 8.0;
        assert!((thermal.scattering(3.0, 0.1).unwrap() - expected).abs() < 1e-15);
        assert_eq!(thermal.scattering(3.0, 0.0), Some(1.0));
        // A narrow ring, with the density of the mean variances 1.9 and 0.4 at t = 2.
        let density = |variance: f64| {
            f64::exp(-0.5 * 9.0 / (4.0 * variance)) / (std::f64::consts::TAU * 4.0 * variance)
        };
        let expected = 0.25 * (3.0 * density(1.9) + density(0.4));
        let found = thermal.displacements([2.999, 3.001], 2.0).unwrap();
        assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
        let all = std::f64::consts::PI * 1e4 * thermal.displacements([0.0, 1e2], 2.0).unwrap();
        assert!((all - 1.0).abs() < 1e-12);
        assert_eq!(thermal.displacements([0.0, 1.0], 0.0), None);
        // One mass without the conservation of momentum, at x = 1.
        let single = Thermal {
            temperature: Some(2.0),
            masses: vec![(8.0, 3)],
            shared: [0.0; 2],
        };
        let [along, across] = single.currents(&[4.0], 0.5).unwrap();
        assert!(along.abs() < 1e-15 && (across - 0.25 * f64::exp(-0.5)).abs() < 1e-15);
        let equal_times = single.currents(&[4.0, 9.0], 0.0);
        assert_eq!(equal_times, Some([0.25; 2]));
        let none = Thermal {
            masses: vec![],
            ..thermal
        };
        assert_eq!(none.scattering(3.0, 0.1), None);
    }
}
