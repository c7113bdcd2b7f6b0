//! A test whether a histogram of directions is uniform, from the scatter of its blocks.
//!
//! The harmonics aₖ = Σ c(θ) cos kθ and bₖ = Σ c(θ) sin kθ, k = 1 … K, of the counts c in each of n
//! blocks of time have mean 0 if no direction is preferred. Successive contacts and the harmonics
//! are correlated, so counts do not scatter as √c. Hotelling's T² = n m̄ᵀ S⁻¹ m̄, with the mean m̄
//! and the covariance S of the blocks, estimates the scatter from the data. (n − p) / (p (n − 1))
//! T² follows Fisher's F with p = 2K and n − p degrees of freedom (Hotelling 1931).

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

/// The deviation of a histogram from uniformity, and the probability that it occurs by chance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Isotropy {
    /// The number of harmonics in the test.
    pub harmonics: usize,
    /// The number of blocks.
    pub blocks: usize,
    /// Fisher's F; about 1 if no direction is preferred.
    pub ratio: f64,
    /// Probability of an F at least as large if no direction is preferred.
    pub probability: f64,
}

impl Isotropy {
    /// Tests the counts of equal sectors of the whole turn, block by block, in `harmonics`
    /// harmonics.
    ///
    /// `None` without harmonics, with a number of blocks of at most twice that of the harmonics, or
    /// if the blocks do not scatter.
    ///
    /// ```
    /// use carom_observers::Isotropy;
    ///
    /// // Six blocks of four sectors, the first of which has ten counts too many.
    /// let counts: Vec<Vec<u64>> =
    ///     [[90, 82, 81, 79], [91, 80, 78, 80], [89, 81, 80, 82], [90, 78, 82, 80], [92, 80, 80, 79], [90, 81, 79, 81]]
    ///         .map(Vec::from)
    ///         .into();
    /// let found = Isotropy::of_counts(counts.iter().map(Vec::as_slice), 1).expect("six blocks scatter");
    /// assert!(found.probability < 1e-3);
    /// ```
    pub fn of_counts<'a>(
        blocks: impl IntoIterator<Item = &'a [u64]>,
        harmonics: usize,
    ) -> Option<Self> {
        let vectors: Vec<Vec<f64>> = blocks
            .into_iter()
            .map(|counts| transform(counts, harmonics))
            .collect();
        let (count, size) = (vectors.len(), 2 * harmonics);
        if size == 0 || count <= size {
            return None;
        }
        let mean: Vec<f64> = (0..size)
            .map(|i| vectors.iter().map(|v| v[i]).sum::<f64>() / count as f64)
            .collect();
        let covariance = |i: usize, j: usize| {
            let products = vectors.iter().map(|v| (v[i] - mean[i]) * (v[j] - mean[j]));
            products.sum::<f64>() / (count as f64 - 1.0)
        };
        let matrix: Vec<Vec<f64>> = (0..size)
            .map(|i| (0..size).map(|j| covariance(i, j)).collect())
            .collect();
        let square = count as f64 * inverse_form(matrix, &mean)?;
        let ratio = (count - size) as f64 / (size as f64 * (count as f64 - 1.0)) * square;
        let probability = exceedance(ratio, harmonics, count - size);
        Some(Self {
            harmonics,
            blocks: count,
            ratio,
            probability,
        })
    }
}

/// aₖ and bₖ of one histogram.
fn transform(counts: &[u64], harmonics: usize) -> Vec<f64> {
    let angle = |sector: usize| TAU * (sector as f64 + 0.5) / counts.len() as f64;
    let sum = |of: fn(f64) -> f64, order: usize| -> f64 {
        counts
            .iter()
            .enumerate()
            .map(|(sector, &c)| c as f64 * of(order as f64 * angle(sector)))
            .sum()
    };
    (1..=harmonics)
        .flat_map(|order| [sum(libm::cos, order), sum(libm::sin, order)])
        .collect()
}

/// vᵀ S⁻¹ v by Cholesky's decomposition S = L Lᵀ: the square of L⁻¹ v; `None` if S is not positive
/// definite.
fn inverse_form(mut matrix: Vec<Vec<f64>>, vector: &[f64]) -> Option<f64> {
    let size = vector.len();
    let mut solved = vec![0.0; size];
    for i in 0..size {
        for j in 0..=i {
            let dot: f64 = (0..j).map(|k| matrix[i][k] * matrix[j][k]).sum();
            let rest = matrix[i][j] - dot;
            if i == j {
                // Below this share of the variance the rest is rounding: the harmonic depends on
                // the others.
                if rest.is_nan() || rest <= 1e-12 * matrix[i][i] {
                    return None;
                }
                matrix[i][i] = rest.sqrt();
            } else {
                matrix[i][j] = rest / matrix[j][j];
            }
        }
        let dot: f64 = (0..i).map(|k| matrix[i][k] * solved[k]).sum();
        solved[i] = (vector[i] - dot) / matrix[i][i];
    }
    Some(solved.iter().map(|x| x * x).sum())
}

/// P(F ≥ f) with 2 `half` and `other` degrees of freedom: x^(b) Σ_{j < half} (b)ⱼ (1 − x)ʲ / j!,
/// with b = other / 2 and x = other / (other + 2 half f) (the incomplete beta function with an
/// integer first argument is a finite sum).
fn exceedance(ratio: f64, half: usize, other: usize) -> f64 {
    let (b, first) = (0.5 * other as f64, 2.0 * half as f64);
    let x = other as f64 / (other as f64 + first * ratio);
    let (mut term, mut sum) = (1.0, 0.0);
    for j in 0..half {
        sum += term;
        term *= (b + j as f64) / (j as f64 + 1.0) * (1.0 - x);
    }
    (libm::pow(x, b) * sum).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tables of Fisher's F: the 5 % points for (2, 10), (4, 20) and (12, 30) degrees of freedom
    /// are 4.103, 2.866, 2.092.
    #[test]
    fn five_per_cent_points() {
        for (half, other, point) in [(1, 10, 4.103), (2, 20, 2.866), (6, 30, 2.092)] {
            let found = exceedance(point, half, other);
            assert!((found - 0.05).abs() < 1e-4, "{half} {other}: {found}");
        }
        assert_eq!(exceedance(0.0, 6, 30), 1.0);
    }

    /// S = [[4, 2], [2, 3]] has the inverse [[3, −2], [−2, 4]] / 8.
    #[test]
    fn a_form_by_hand() {
        let matrix = vec![vec![4.0, 2.0], vec![2.0, 3.0]];
        assert!((inverse_form(matrix, &[1.0, 2.0]).unwrap() - 11.0 / 8.0).abs() < 1e-15);
        assert_eq!(
            inverse_form(vec![vec![1.0, 1.0], vec![1.0, 1.0]], &[1.0, 2.0]),
            None
        );
    }

    #[test]
    fn too_few_blocks_give_none() {
        let counts = [[1_u64, 2, 3, 4], [2, 3, 4, 5]];
        assert_eq!(
            Isotropy::of_counts(counts.iter().map(<[u64; 4]>::as_slice), 1),
            None
        );
        let same = [[5_u64; 4]; 9];
        assert_eq!(
            Isotropy::of_counts(same.iter().map(<[u64; 4]>::as_slice), 1),
            None
        );
        assert_eq!(
            Isotropy::of_counts(same.iter().map(<[u64; 4]>::as_slice), 0),
            None
        );
    }
}
