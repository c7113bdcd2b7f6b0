//! Kicks of a body among a few discs in a periodic box: the ideal gas, with its corrections.
//!
//! In an ideal gas at equilibrium the impulse per length of the boundary is constant for a body of
//! any mass, free or locked; the number of kicks is proportional to μ^(−1/2) of the contact's
//! reduced mass μ (kinetic theory of gases).

use std::f64::consts::{PI, TAU};

use super::{Prediction, fixed_energy::mean_speed, surroundings::Surroundings};

/// Area fraction below which a gas counts as ideal: the first correction, from the mutual exclusion
/// of gas discs near the body, is of this order.
pub const DILUTE: f64 = 0.01;

/// Source of the rates.
pub(super) const SOURCE: &str = "ideal gas, n √(kT / 2π) ∮ μ^(−1/2) ds and n kT P, with the free area of so \
                                 few discs, at fixed energy; accurate to 0.3 %";

/// Predictions for a few discs around the body in a periodic box.
#[derive(Debug, Clone, Copy)]
pub(super) struct FewDiscs {
    /// Density of gas centres at the body's boundary, relative to the mean.
    pub(super) rim: f64,
    /// Kicks of the body (1 / time).
    pub(super) kicks: f64,
}

impl FewDiscs {
    /// Ideal-gas values n √(kT / 2π) ∮ μ^(−1/2) ds and n kT P, with three corrections of the order
    /// of a percent: the centres have the area that body and fixed discs leave; the density at the
    /// boundary is enhanced as at a disc of the same perimeter; and all bodies share one energy, so
    /// that the mean speed is not Maxwell's (see [`mean_speed`]).
    ///
    /// `None` if the gas is not dilute, or has not the whole box.
    pub(super) fn new(
        prediction: &Prediction,
        around: &Surroundings,
        freedom: f64,
    ) -> Option<Self> {
        let (density, area) = (around.density(), around.area);
        let bumpers = around.bumpers.as_ref().filter(|_| around.is_one_gas)?;
        let Prediction {
            boundary: region,
            gas_radius,
            ..
        } = prediction;
        if prediction.area_fraction(density) >= DILUTE {
            return None;
        }
        // The share of the box that is free for the centres.
        let reaches = bumpers.iter().map(|radius| radius + gas_radius);
        let room = reaches.fold(area - region.area(), |free, reach| {
            free - PI * reach * reach
        }) / area;
        let equal_disc = region.perimeter() / TAU - gas_radius;
        let rim = prediction.contact_density_of_disc(equal_disc, density) / room;
        let slowed = mean_speed(2.0 * around.count as f64 + freedom);
        Some(Self {
            rim,
            kicks: rim * slowed * prediction.ideal_rate(density, around.temperature),
        })
    }
}
