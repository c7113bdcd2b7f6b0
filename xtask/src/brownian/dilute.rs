//! What a thin gas must show: the exposed arcs, in the shares of kicks by direction and by atom.
//!
//! In an ideal gas at equilibrium the impulse on each piece of the boundary is the same, for a molecule of any mass, free
//! or locked; the number of kicks goes with μ^(−1/2) of the contact's reduced mass μ (kinetic theory of gases).

use super::{
    figures::{Group, impulse_error},
    measurement::SECTORS,
    setup::GAS_RADIUS,
};
use crate::{chi_square::ChiSquare, summary::Check};

/// Share of the box below which a gas is taken for ideal: the first correction, by what two gas discs keep free of each
/// other near the molecule, is of this order.
pub const DILUTE: f64 = 0.01;

/// Directions are taken together, ten degrees at a time.
const GROUPS: usize = 36;

/// Fewer kicks than this in a group of directions on average, and χ² is not that of Gaussian errors.
const LEAST: u64 = 20;

/// Most that −log₁₀ p of a χ² may be: by chance exceeded once in 10 000 runs.
const MOST_LOG_P: f64 = 4.0;

/// Whether the gas covers so little of the box that it is as good as ideal.
pub fn is_dilute(group: &Group<'_>) -> bool {
    group.density() * std::f64::consts::PI * GAS_RADIUS * GAS_RADIUS < DILUTE
}

/// Directions by number and by impulse, and atoms, against the exposed arcs; none in a dense gas or after few kicks.
pub fn checks(group: &Group<'_>) -> Vec<Check> {
    let kicks = &group.kicks;
    if !is_dilute(group) || kicks.hits() < LEAST * GROUPS as u64 {
        return Vec::new();
    }
    let counts = grouped(&kicks.counts.iter().map(|&count| count as f64).collect::<Vec<_>>());
    let counts: Vec<u64> = counts.iter().map(|&count| count as u64).collect();
    let shares = grouped(&group.prediction.count_shares(SECTORS));
    let by_count = ChiSquare::of(&counts, &shares);
    let hits = kicks.hits() as f64;
    let impulse_shares = grouped(&group.prediction.impulse_shares(SECTORS));
    let terms = grouped(&kicks.impulse).into_iter().zip(impulse_shares).zip(&shares).map(
        |((impulse, impulse_share), share)| {
            let expected = kicks.total_impulse() * impulse_share;
            ((impulse - expected) / impulse_error(expected, (hits * share) as u64)).powi(2)
        },
    );
    let by_impulse = ChiSquare { value: terms.sum(), freedom: GROUPS - 1 };
    let by_atom = ChiSquare::of(&kicks.by_atom, &group.prediction.atom_shares());
    let check = |name: &str, of: ChiSquare| Check::at_most(name, -of.p_value().log10(), MOST_LOG_P);
    vec![
        check("kicks by direction against exposed arcs, −log10 p of χ²", by_count),
        check("impulse by direction against exposed arcs, −log10 p of χ²", by_impulse),
        check("kicks by atom against exposed arcs, −log10 p of χ²", by_atom),
    ]
}

fn grouped(values: &[f64]) -> Vec<f64> {
    values.chunks(values.len() / GROUPS).map(|group| group.iter().sum()).collect()
}
