//! The wave vectors of a scattering function: those of the box nearest to a wave number k.

use carom_geometry::{GeometryError, PeriodicBox, check_positive};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::wave_vectors::nearest_shells;

/// The largest number of shells. The cost of a sample is the number of bodies times that of wave
/// vectors, in a square box two to seven a shell.
const MAX_SHELLS: usize = 1000;

/// The most wave vectors with |n_x| and n_y up to those of k: the search goes through them.
const MAX_VECTORS: f64 = 1e7;

/// The wave number and the times of an [`IntermediateScattering`](crate::IntermediateScattering) or
/// a [`CurrentCorrelation`](crate::CurrentCorrelation).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ScatteringScales {
    /// Wave number k (1 / length).
    pub wave_number: f64,
    /// Number of shells of wave vectors of the box whose length is nearest to k, 1 to 1000.
    pub shells: usize,
    /// Time between samples.
    pub spacing: f64,
    /// Longest lag (time); below one spacing it is taken as one spacing.
    pub longest: f64,
}

/// A wave number, number of shells or time that is out of range.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ScatteringError {
    /// A number is not positive and finite.
    #[error(transparent)]
    NotPositive(#[from] GeometryError),
    /// The number of shells is 0 or too large.
    #[error("the number of shells must be 1 to {MAX_SHELLS}, but is {shells}")]
    Shells {
        /// The number given.
        shells: usize,
    },
    /// The box has too many wave vectors up to k.
    #[error("the wave number k must be at most {most} in this box, but is {wave_number}")]
    TooShort {
        /// The given k (1 / length).
        wave_number: f64,
        /// The largest k (1 / length).
        most: f64,
    },
}

/// The wave vectors in the shells of a box that are nearest to k.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct ChosenWaves {
    pub(crate) bounds: PeriodicBox,
    /// (n_x, n_y), one of each pair k and −k.
    pub(crate) vectors: Vec<[i64; 2]>,
    /// |k| of each vector in ascending order (1 / length).
    pub(crate) wave_numbers: Vec<f64>,
}

impl ChosenWaves {
    /// Validates the wave number and the number of shells, and lists the vectors.
    ///
    /// # Errors
    /// [`ScatteringError`] if k is not positive and finite, if there are more than 1000 shells, or
    /// if the box has more than about 10⁷ wave vectors up to k.
    pub(crate) fn new(
        bounds: &PeriodicBox,
        scales: &ScatteringScales,
    ) -> Result<Self, ScatteringError> {
        let wave_number = check_positive("the wave number k", scales.wave_number)?;
        let shells = scales.shells;
        if !(1..=MAX_SHELLS).contains(&shells) {
            return Err(ScatteringError::Shells { shells });
        }
        // n_x n_y = k² A / (2π)², and n_x alone in a narrow box.
        let sides = bounds.sides() / std::f64::consts::TAU;
        let most = (MAX_VECTORS / (sides.x * sides.y))
            .sqrt()
            .min(MAX_VECTORS / sides.max_element());
        if wave_number > most {
            return Err(ScatteringError::TooShort { wave_number, most });
        }
        let shells = nearest_shells(bounds, wave_number, shells);
        let of_vectors = |number: f64, count: usize| std::iter::repeat_n(number, count);
        Ok(Self {
            bounds: *bounds,
            wave_numbers: shells
                .iter()
                .flat_map(|shell| of_vectors(shell.wave_number, shell.vectors.len()))
                .collect(),
            vectors: shells.into_iter().flat_map(|shell| shell.vectors).collect(),
        })
    }
}
