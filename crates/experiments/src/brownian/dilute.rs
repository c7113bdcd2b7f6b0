//! Checks in a dilute gas: the shares of kicks by direction and by atom follow from the exposed
//! arcs.
//!
//! In an ideal gas at equilibrium the impulse per length of the boundary is constant for a molecule
//! of any mass, free or locked; the number of kicks is proportional to μ^(−1/2) of the contact's
//! reduced mass μ (kinetic theory of gases).

use std::f64::consts::{PI, TAU};

use carom_runs::measures::kicks::{DILUTE, Prediction, mean_speed};
use carom_tables::{Check, chi_square::ChiSquare};

use super::{
    group::{Group, impulse_error},
    results::{Kicks, SECTORS},
};

/// Number of groups of directions, ten degrees each.
const GROUPS: usize = 36;

/// Least mean number of kicks in a group of directions for which χ² has Gaussian errors.
const LEAST: u64 = 20;

/// Largest allowed −log₁₀ p of a χ²: chance exceeds it once in 10 000 runs.
const MOST_LOG_P: f64 = 4.0;

/// Returns true if the area fraction of the gas is small enough for the ideal-gas predictions, and
/// nothing but small fixed discs is in the way.
pub fn is_dilute(group: &Group<'_>) -> bool {
    group.setting.is_open() && group.prediction.area_fraction(group.density()) < DILUTE
}

/// Predictions for a few discs around the molecule in a periodic box.
#[derive(Debug, Clone, Copy)]
pub struct FewDiscs {
    /// Density of gas centres at the molecule's boundary, relative to the mean.
    pub rim: f64,
    /// Kicks of the molecule (1 / time).
    pub kicks: f64,
    /// Collisions per moving body (1 / time).
    pub collisions: f64,
}

impl FewDiscs {
    /// Ideal-gas values n √(kT / 2π) ∮ μ^(−1/2) ds and n kT P, with three corrections of the order
    /// of a percent: the centres have the area that molecule and bumpers leave; the density at the
    /// boundary is enhanced as at a disc of the same perimeter; and all bodies share one energy, so
    /// that the mean speed is not Maxwell's (see [`mean_speed`]).
    pub fn of(group: &Group<'_>) -> Self {
        let (density, temperature, area) = (group.density(), group.temperature(), group.setting.area());
        let discs = density * area;
        let Prediction { boundary: region, gas_radius, gas_mass, .. } = &group.prediction;
        let bumpers = || group.setting.scene.bumper.iter().map(|bumper| bumper.radius + gas_radius);
        // The share of the box that is free for the centres.
        let room = bumpers().fold(area - region.area(), |free, reach| free - PI * reach * reach) / area;
        let equal_disc = region.perimeter() / TAU - gas_radius;
        let rim = group.prediction.contact_density_of_disc(equal_disc, density) / room;
        let slowed = mean_speed(2.0 * discs + if group.turns() { 3.0 } else { 2.0 });
        let kicks = rim * slowed * group.prediction.ideal_rate(density, temperature);
        // A disc meets all others; contacts with a bumper count for one moving body only.
        let among_gas = (discs - 1.0) * group.prediction.collision_rate(density, temperature) * slowed;
        let reaches: f64 = bumpers().sum();
        let on_bumpers = density / room * slowed * (temperature / (TAU * gas_mass)).sqrt() * TAU * reaches;
        Self { rim, kicks, collisions: (among_gas + on_bumpers + 2.0 * kicks) / (discs + 1.0) }
    }
}

/// Checks of directions, by number and by impulse, and of atoms against the exposed arcs; none in a
/// dense gas or with few kicks.
pub fn checks(group: &Group<'_>) -> Vec<Check> {
    if is_dilute(group) { against_arcs(&group.kicks, &group.prediction) } else { Vec::new() }
}

fn against_arcs(kicks: &Kicks, prediction: &Prediction) -> Vec<Check> {
    if kicks.hits() < LEAST * GROUPS as u64 {
        return Vec::new();
    }
    let counts = grouped(&kicks.counts.iter().map(|&count| count as f64).collect::<Vec<_>>());
    let counts: Vec<u64> = counts.iter().map(|&count| count as u64).collect();
    let shares = grouped(&prediction.count_shares(SECTORS));
    let by_count = ChiSquare::of(&counts, &shares);
    let hits = kicks.hits() as f64;
    let impulse_shares = grouped(&prediction.impulse_shares(SECTORS));
    let terms = grouped(&kicks.impulse).into_iter().zip(impulse_shares).zip(&shares).map(
        |((impulse, impulse_share), share)| {
            let expected = kicks.total_impulse() * impulse_share;
            ((impulse - expected) / impulse_error(expected, (hits * share) as u64)).powi(2)
        },
    );
    let by_impulse = ChiSquare { value: terms.sum(), freedom: GROUPS - 1 };
    let by_atom = ChiSquare::of(&kicks.by_atom, &prediction.atom_shares());
    [("kicks by direction", by_count), ("impulse by direction", by_impulse), ("kicks by atom", by_atom)]
        .into_iter()
        // A single atom receives all kicks in any case.
        .filter(|(_, chi)| chi.freedom > 0)
        .map(|(what, chi)| {
            let name = format!("{what} against exposed arcs, −log10 p of χ²");
            Check::at_most(&name, -chi.p_value().log10(), MOST_LOG_P)
        })
        .collect()
}

fn grouped(values: &[f64]) -> Vec<f64> {
    values.chunks(values.len() / GROUPS).map(|group| group.iter().sum()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::{Molecule, Shape};

    /// A million kicks, distributed as the exposed arcs predict.
    fn ideal(prediction: &Prediction) -> Kicks {
        let out_of = |total: f64, shares: Vec<f64>| shares.into_iter().map(move |share| total * share);
        Kicks {
            counts: out_of(1e6, prediction.count_shares(SECTORS)).map(|count| count.round() as u64).collect(),
            impulse: out_of(2.5e6, prediction.impulse_shares(SECTORS)).collect(),
            by_atom: out_of(1e6, prediction.atom_shares()).map(|count| count.round() as u64).collect(),
        }
    }

    fn passed(kicks: &Kicks, prediction: &Prediction) -> Vec<bool> {
        against_arcs(kicks, prediction).iter().map(|check| check.passed).collect()
    }

    #[test]
    fn kicks_distributed_as_the_arcs_pass_and_others_fail() {
        let tee = Molecule::named(Shape::Tee, 0.005, 2.0).unwrap();
        for turns in [true, false] {
            let prediction = Prediction::new(&tee, turns, [0.01, 1.0]).unwrap();
            let kicks = ideal(&prediction);
            assert_eq!(passed(&kicks, &prediction), [true; 3]);
            // Rotated by ten degrees; and a wing receives the kicks of the stem's end.
            let mut turned = kicks.clone();
            turned.counts.rotate_right(SECTORS / GROUPS);
            turned.impulse.rotate_right(SECTORS / GROUPS);
            turned.by_atom.swap(0, 4);
            assert_eq!(passed(&turned, &prediction), [false; 3]);
            // One percent more on one wing than on the other: 1800 kicks, where the standard
            // deviation is 600.
            let mut crooked = kicks.clone();
            (crooked.by_atom[0], crooked.by_atom[2]) =
                (kicks.by_atom[0] / 100 * 101, kicks.by_atom[2] / 100 * 99);
            assert_eq!(passed(&crooked, &prediction), [true, true, false]);
            assert_eq!(passed(&Kicks { counts: vec![1; SECTORS], ..kicks }, &prediction), [true; 0]);
        }
    }
}
