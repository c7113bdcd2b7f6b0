//! Diffusion coefficients from curves over the lag, with errors from blocks: the slope of a mean
//! square, or of the logarithm of a correlation, where it has become constant, and the integral of
//! an autocorrelation.

use carom_tables::{BlockMean, Estimate, Sums, block_sums::of_quantity, significant};

/// Ratio of the lags at the ends of a piece of a curve. Smaller: noisier slopes. Larger: fewer
/// pieces, and a plateau is found later.
const RATIO: f64 = 2.0;

/// A slope agrees with that of the plateau within so many of its standard errors.
const AGREES: f64 = 2.5;

/// Pieces of a plateau over which the slope is taken, from its begin on; later ones test it. Fewer:
/// larger errors. More: lags of which a run has few independent samples.
const PIECES: usize = 2;

/// A plateau begins where the velocities have lost all but this share of their memory: at shorter
/// lags the displacement is still on its way to diffusion, which noise can hide.
const DECAYED: f64 = 0.05;

/// Lags with fewer pairs are left out: their means are noise.
pub(crate) const MIN_PAIRS: u64 = 30;

/// An autocorrelation is integrated only if it has not fallen below this share of its value at lag
/// 0 at the first lag: a coarser one says nothing about what lies between.
const RESOLVED: f64 = 0.5;

/// Below this logarithm of the ratio of two values their logarithmic mean is taken from its series:
/// the error, log³/360 of the value, is less than the rounding of the quotient.
const SMALL_LOGARITHM: f64 = 1e-3;

/// A curve over the lag.
pub(crate) struct TransportCurve<'a> {
    /// The lags (time), from 0 on.
    pub lags: &'a [f64],
    /// Its means, without an error where blocks are too short.
    pub means: &'a [BlockMean],
    /// The sums of each block of each run.
    pub runs: &'a [Vec<Sums>],
    /// Duration of a block (time), infinite if the abscissa is no lag.
    pub block: f64,
    /// What is taken of each mean.
    pub of: Taken,
}

/// What is taken of each mean of a curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Taken {
    /// The mean itself.
    Itself,
    /// −ln of it, which grows in proportion to the lag where the mean decays exponentially.
    MinusLogarithm,
}

impl Taken {
    /// The value, and its derivative by the mean; `None` where it has none.
    fn of_mean(self, mean: f64) -> Option<[f64; 2]> {
        match self {
            Self::Itself => Some([mean, 1.0]),
            Self::MinusLogarithm => (mean > 0.0).then(|| [-mean.ln(), -1.0 / mean]),
        }
    }
}

/// A number with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TransportValue {
    pub value: f64,
    pub standard_error: f64,
}

/// A slope, and the lags between which it was taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Plateau {
    pub slope: TransportValue,
    pub between: [f64; 2],
    /// Whether the slope is constant between the lags; otherwise it is that of the longest lags.
    pub is_constant: bool,
}

impl Plateau {
    /// The name of the figure of this slope, which is `what`.
    pub fn named(&self, what: &str) -> String {
        let lags = from_to(self.between);
        if self.is_constant {
            format!("{what} at long lags, {lags}")
        } else {
            format!("apparent {what} at long lags, {lags}, no plateau")
        }
    }
}

/// The slope of a curve between two lags.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Slope {
    /// The slope (unit of the curve / time).
    pub value: f64,
    /// Its standard error; `None` if the run has too few blocks.
    pub standard_error: Option<f64>,
    between: [f64; 2],
}

impl Slope {
    /// The name of the figure of this slope, which is `what`.
    pub fn named(&self, what: &str) -> String {
        format!("{what}, from lags {}", from_to(self.between))
    }
}

/// Two lags, for the name of a figure.
fn from_to([begin, end]: [f64; 2]) -> String {
    let [begin, end] = [begin, end].map(|lag| significant(lag, 3));
    format!("{begin} to {end}")
}

/// Blocks that are joined for the errors of lags as long as a block or longer, up to the joined
/// length: their pairs begin before their block. Fewer: errors of shorter lags alone. More: of 32
/// blocks too few are left.
const JOINED_BLOCKS: usize = 4;

/// The number of blocks that are joined for the error at a lag, with the duration of a block
/// (times).
pub(crate) fn joined_at(lag: f64, block: f64) -> usize {
    if lag < block { 1 } else { JOINED_BLOCKS }
}

/// The standard error of a sum of means, each times a factor, from their sums in each block of each
/// run, so many of which are joined; of a function of means the factors are its derivatives by
/// them. Runs are independent. `None` if a mean is computed from several, or if there are fewer
/// than two blocks.
pub(crate) fn error_of_sum(
    runs: &[Vec<Sums>],
    joined: usize,
    terms: impl IntoIterator<Item = (BlockMean, f64)>,
) -> Option<f64> {
    let mut deviations: Vec<Vec<f64>> = runs.iter().map(|blocks| vec![0.0; blocks.len()]).collect();
    for (mean, factor) in terms {
        let (ratio, quantity) = (mean.value?, mean.quantity?);
        let of_runs: Vec<_> = runs
            .iter()
            .map(|blocks| of_quantity(blocks, quantity))
            .collect();
        let weight: f64 = of_runs.iter().flatten().map(|[_, weight]| weight).sum();
        for (deviations, blocks) in deviations.iter_mut().zip(of_runs) {
            for (deviation, [x, w]) in deviations.iter_mut().zip(blocks) {
                *deviation += factor * (x - ratio * w) / weight;
            }
        }
    }
    let join = |deviations: Vec<f64>| -> Vec<f64> {
        let parts = deviations.chunks(joined);
        parts.map(|part| part.iter().sum()).collect()
    };
    let deviations: Vec<Vec<f64>> = deviations.into_iter().map(join).collect();
    // The error of a sum over the blocks is that of their mean times their number.
    let count = deviations.iter().map(Vec::len).sum::<usize>() as f64;
    let of_run = |deviations: Vec<f64>| {
        let blocks = deviations.into_iter();
        blocks.map(|deviation| [deviation * count, 1.0]).collect()
    };
    let runs: Vec<Vec<[f64; 2]>> = deviations.into_iter().map(of_run).collect();
    let error = Estimate::of_runs(&runs)?.standard_error;
    error.is_finite().then_some(error)
}

/// The standard error of a mean at a lag, in blocks of this duration (times): that of the blocks,
/// or of joined ones where a block holds pairs that begin before it. Still longer lags have none.
pub(crate) fn error_at_lag(
    mean: &BlockMean,
    lag: f64,
    block: f64,
    runs: &[Vec<Sums>],
) -> Option<f64> {
    if lag < block {
        return mean.standard_error;
    }
    let joined = joined_at(lag, block);
    (lag < joined as f64 * block)
        .then(|| error_of_sum(runs, joined, [(*mean, 1.0)]))
        .flatten()
}

impl TransportCurve<'_> {
    /// The sum of some of its means by their places, each times a factor.
    pub(crate) fn combination(&self, factors: &[(usize, f64)]) -> Option<TransportValue> {
        let mut value = 0.0;
        let mut terms = Vec::with_capacity(factors.len());
        for &(place, factor) in factors {
            let mean = *self.means.get(place)?;
            let [of_mean, slope] = self.of.of_mean(mean.value?)?;
            value += factor * of_mean;
            terms.push((mean, factor * slope));
        }
        let lags = factors
            .iter()
            .filter_map(|&(place, _)| self.lags.get(place));
        let longest = lags.copied().fold(0.0, f64::max);
        let joined = joined_at(longest, self.block);
        let standard_error = error_of_sum(self.runs, joined, terms)?;
        (value.is_finite() && standard_error > 0.0).then_some(TransportValue {
            value,
            standard_error,
        })
    }

    fn slope(&self, from: usize, to: usize) -> Option<TransportValue> {
        let per_time = 1.0 / (self.lags[to] - self.lags[from]);
        self.combination(&[(to, per_time), (from, -per_time)])
    }

    /// The slope between the lags that are nearest to these (time), by their ratio; `None` if the
    /// curve is too short or too coarse.
    pub(super) fn slope_between(&self, lags: [f64; 2]) -> Option<Slope> {
        let longest = *self.lags.last()?;
        let nearest = |requested: f64| {
            let ratio = |lag: f64| (lag / requested).max(requested / lag);
            let places = 1..self.lags.len();
            places.min_by(|&a, &b| ratio(self.lags[a]).total_cmp(&ratio(self.lags[b])))
        };
        if lags[1] > longest {
            return None;
        }
        let (from, to) = (nearest(lags[0])?, nearest(lags[1])?);
        let value = |place: usize| self.means.get(place)?.value;
        let between = [self.lags[from], self.lags[to]];
        let duration = between[1] - between[0];
        let rise = value(to)? - value(from)?;
        (duration > 0.0).then(|| Slope {
            value: rise / duration,
            standard_error: [from, to]
                .iter()
                .all(|&place| self.means[place].standard_error.is_some())
                .then(|| self.slope(from, to))
                .flatten()
                .map(|slope| slope.standard_error),
            between,
        })
    }

    /// The places of the longest lag with an error, of one at most half as long, and so on.
    fn ends(&self) -> Vec<usize> {
        let mut ends = Vec::new();
        let mut most = f64::INFINITY;
        for place in (1..self.lags.len().min(self.means.len())).rev() {
            let is_known = self.means[place].standard_error.is_some();
            if is_known && self.lags[place] <= most {
                ends.push(place);
                most = self.lags[place] / RATIO;
            }
        }
        ends.reverse();
        ends
    }

    /// The slope of the curve at long lags, over the first two pieces from which on it is constant;
    /// `memory` is the autocorrelation of the velocities at the same lags.
    ///
    /// A run has the fewer independent samples of a lag, the longer that is. So the slope is taken
    /// at the shortest lags of the plateau, and in a longer run its error is smaller.
    ///
    /// `None` if the curve has fewer than two pieces.
    pub(super) fn plateau(&self, memory: &[BlockMean]) -> Option<Plateau> {
        let ends = self.ends();
        let pieces: Vec<TransportValue> = ends
            .windows(2)
            .map(|ends| self.slope(ends[0], ends[1]))
            .collect::<Option<_>>()?;
        let of = |[from, to]: [usize; 2], is_constant: bool| {
            let slope = self.slope(ends[from], ends[to])?;
            let between = [self.lags[ends[from]], self.lags[ends[to]]];
            Some(Plateau {
                slope,
                between,
                is_constant,
            })
        };
        let value = |place: usize| memory.get(place).and_then(|mean| mean.value);
        // One low value alone may be noise.
        let decayed = value(0).and_then(|start| {
            let is_low = |place| value(place).is_some_and(|value| value <= DECAYED * start);
            (0..memory.len()).find(|&place| is_low(place) && is_low(place + 1))
        });
        let is_constant = |from: usize| {
            if decayed.is_none_or(|decayed| ends[from] < decayed) {
                return false;
            }
            let Some(whole) = self.slope(ends[from], ends[from + PIECES]) else {
                return false;
            };
            let agrees = |piece: &TransportValue| {
                (piece.value - whole.value).abs() <= AGREES * piece.standard_error
            };
            pieces[from..].iter().all(agrees)
        };
        let pieces_left = pieces.len().checked_sub(PIECES)?;
        match (0..=pieces_left).find(|&from| is_constant(from)) {
            Some(from) => of([from, from + PIECES], true),
            None => of([pieces.len() - 1, pieces.len()], false),
        }
    }

    /// The integral of the curve from lag 0 to the first lag from which on two values are within
    /// their errors, or to the longest lag with an error, and that lag. `None` if the samples do
    /// not resolve it.
    ///
    /// From there on the integral would gain more of noise than of the curve. The error has the
    /// tail, too, that noise can hide: an exponential of the size C of the last value, or of its
    /// noise, leaves C τ beyond it, with the correlation time τ = ∫ |C(t)| dt / C(0). A tail that
    /// decays more slowly, as 1/t, is not counted.
    ///
    /// Lags are up to twice as long as those before them. So the curve is taken as an exponential
    /// between two of them: the trapezoidal rule makes ∫ exp(−t) too large by 4 % with the lags …,
    /// 1.8, 2, 4, 6, … Values below their standard error have the shape of one as large as that, so
    /// that the rule becomes the trapezoidal one in the noise.
    pub(super) fn integral(&self) -> Option<(TransportValue, f64)> {
        let value = |place: usize| self.means.get(place)?.value;
        let is_resolved = value(1)? >= RESOLVED * value(0)?;
        let last = self
            .means
            .iter()
            .take(self.lags.len())
            .rposition(|mean| mean.standard_error.is_some())?;
        let is_noise = |place: usize| {
            let mean = &self.means[place];
            let size = mean.value.map(f64::abs);
            size.zip(mean.standard_error)
                .is_none_or(|(size, error)| size <= error)
        };
        // One value alone may be a change of sign.
        let are_noise = |place: &usize| is_noise(*place) && is_noise(*place + 1);
        let last = (2..last).find(are_noise).unwrap_or(last);
        if !is_resolved || last < 2 {
            return None;
        }
        let mut factors: Vec<(usize, f64)> = (0..=last).map(|place| (place, 0.0)).collect();
        for place in 0..last {
            let width = self.lags[place + 1] - self.lags[place];
            let shares = match [place, place + 1].map(|place| above_noise(&self.means[place])) {
                [Some(begin), Some(end)] => shares_of_exponential([begin, end]),
                _ => [0.5; 2],
            };
            factors[place].1 += width * shares[0];
            factors[place + 1].1 += width * shares[1];
        }
        let integral = self.combination(&factors)?;
        // Of sizes, since a curve of both signs, as of a bound body, has an integral of about 0.
        let size = |(place, factor): &(usize, f64)| Some(factor * value(*place)?.abs());
        let of_sizes: f64 = factors.iter().map(size).sum::<Option<f64>>()?;
        let correlation_time = of_sizes / value(0)?;
        let tail = correlation_time * value(last)?.abs().max(self.means[last].standard_error?);
        let whole = TransportValue {
            standard_error: integral.standard_error.hypot(tail),
            ..integral
        };
        Some((whole, self.lags[last]))
    }
}

/// A mean, at least its standard error; `None` without a positive error.
fn above_noise(mean: &BlockMean) -> Option<f64> {
    let error = mean.standard_error.filter(|&error| error > 0.0)?;
    Some(mean.value?.max(error))
}

/// The derivatives by a and b of their logarithmic mean (a − b)/ln(a/b), that of the exponential
/// from a to b; both are positive. The mean is the sum of both, each times its value.
fn shares_of_exponential([a, b]: [f64; 2]) -> [f64; 2] {
    let log = (a / b).ln();
    if log.abs() < SMALL_LOGARITHM {
        return [0.5 - log / 12.0, 0.5 + log / 12.0];
    }
    // ∂/∂a = 1/ln(a/b) − (a − b)/(a ln²(a/b)), and b with a exchanged.
    let mean = (a - b) / log;
    [(1.0 - mean / a) / log, (mean / b - 1.0) / log]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A curve with these values at these lags in 40 blocks of a hundred pairs, which scatter by
    /// this share.
    fn measured(
        lags: &[f64],
        curve: impl Fn(f64) -> f64,
        scatter: f64,
    ) -> (Vec<BlockMean>, Vec<Sums>) {
        let noise = |block: usize, place: usize| {
            let turn = ((block * 37 + place * 11) % 40) as f64 / 40.0;
            (2.0 * std::f64::consts::PI * turn).sin() * scatter
        };
        let of_block = |block: usize| -> Sums {
            lags.iter()
                .enumerate()
                .map(|(place, &lag)| [100.0 * curve(lag) * (1.0 + noise(block, place)), 100.0])
                .collect()
        };
        let blocks: Vec<Sums> = (0..40).map(of_block).collect();
        let total: Sums = (0..lags.len())
            .map(|place| {
                blocks
                    .iter()
                    .fold([0.0; 2], |[x, w], b| [x + b[place][0], w + b[place][1]])
            })
            .collect();
        (
            carom_tables::block_sums::means(&total, std::slice::from_ref(&blocks)),
            blocks,
        )
    }

    /// A curve of one run whose lags are all shorter than a block.
    fn of_one_run<'a>(
        lags: &'a [f64],
        means: &'a [BlockMean],
        blocks: &'a Vec<Sums>,
        of: Taken,
    ) -> TransportCurve<'a> {
        TransportCurve {
            lags,
            means,
            runs: std::slice::from_ref(blocks),
            block: f64::INFINITY,
            of,
        }
    }

    fn lags() -> Vec<f64> {
        (0..10)
            .chain((1..10).map(|n| 10 * n))
            .map(f64::from)
            .collect()
    }

    /// A Langevin particle: 4D (t − τ (1 − exp(−t/τ))).
    #[test]
    fn the_plateau_of_a_langevin_particle_is_found_and_its_start_lies_in_the_diffusive_range() {
        let square = |t: f64| 4.0 * 0.3 * (t - 2.0 * (1.0 - (-t / 2.0).exp()));
        let lags = lags();
        let (memory, _) = measured(&lags, |t| (-t / 2.0).exp(), 1e-3);
        let (means, blocks) = measured(&lags, square, 1e-3);
        let curve = of_one_run(&lags, &means, &blocks, Taken::Itself);
        let found = curve.plateau(&memory).unwrap();
        assert!(found.is_constant && found.between[0] >= 5.0, "{found:?}");
        // At the first lags of the plateau, not at the longest.
        let ratio = found.between[1] / found.between[0];
        assert!((4.0..5.0).contains(&ratio), "{found:?}");
        let TransportValue {
            value,
            standard_error,
        } = found.slope;
        assert!(
            (0.25 * value - 0.3).abs() < 0.003 && standard_error < 0.02,
            "{found:?}"
        );
        // A curve on its way to diffusion has none, also where its slopes are too noisy to tell.
        let [(short, of_short), (noisy, of_noisy)] =
            [1e-3, 0.3].map(|scatter| measured(&lags[..5], square, scatter));
        for (means, blocks) in [(&short, &of_short), (&noisy, &of_noisy)] {
            let curve = of_one_run(&lags[..5], means, blocks, Taken::Itself);
            assert!(!curve.plateau(&memory).unwrap().is_constant);
        }
        // Nor has a ballistic one, whatever the memory of the velocities.
        let (means, blocks) = measured(&lags, |t| t * t, 1e-3);
        let (lost, _) = measured(&lags, |t| if t > 0.0 { 0.0 } else { 1.0 }, 1e-3);
        let curve = of_one_run(&lags, &means, &blocks, Taken::Itself);
        assert!(!curve.plateau(&lost).unwrap().is_constant);
        let curve = of_one_run(&lags[..2], &means[..2], &blocks, Taken::Itself);
        assert_eq!(curve.plateau(&memory), None);
    }

    /// ⟨cos Δθ⟩ = exp(−D t), as of a body that has forgotten its angular velocity.
    #[test]
    fn the_logarithm_of_an_exponential_has_its_rate_as_plateau() {
        let lags = lags();
        let (memory, _) = measured(&lags, |t| (-t / 2.0).exp(), 1e-3);
        let (means, blocks) = measured(&lags, |t| (-0.02 * t).exp(), 1e-3);
        let curve = of_one_run(&lags, &means, &blocks, Taken::MinusLogarithm);
        let Plateau {
            slope, is_constant, ..
        } = curve.plateau(&memory).unwrap();
        assert!(
            is_constant && (slope.value - 0.02).abs() < 2e-4,
            "{slope:?}"
        );
        assert!(
            slope.standard_error > 0.0 && slope.standard_error < 1e-3,
            "{slope:?}"
        );
        let (negative, blocks) = measured(&lags, |t| 0.5 - t, 1e-3);
        let curve = of_one_run(&lags, &negative, &blocks, Taken::MinusLogarithm);
        assert_eq!(curve.plateau(&memory), None);
    }

    #[test]
    fn the_integral_over_logarithmic_lags_has_no_bias() {
        let lags = lags();
        // The trapezoidal rule gives 6.07.
        for time in [6.0, 15.0] {
            let (means, blocks) = measured(&lags, |t| (-t / time).exp(), 1e-3);
            let curve = of_one_run(&lags, &means, &blocks, Taken::Itself);
            let (found, _) = curve.integral().unwrap();
            let expected = time * (1.0 - (-90.0 / time).exp());
            assert!(
                (found.value / expected - 1.0).abs() < 2e-4,
                "{found:?} {expected}"
            );
        }
        for [a, b] in [[1.0, 0.3], [0.3, 1.0], [1.0, 0.9995], [2.0, 2.0]] {
            let [of_a, of_b] = shares_of_exponential([a, b]);
            let mean = if a == b { a } else { (a - b) / (a / b).ln() };
            assert!((of_a * a + of_b * b - mean).abs() < 1e-12, "{a} {b}");
        }
    }

    #[test]
    fn the_integral_of_an_exponential_is_its_time_and_coarse_samples_have_none() {
        let lags = lags();
        let of = |time: f64| {
            let (means, blocks) = measured(&lags, |t| (-t / time).exp(), 1e-3);
            of_one_run(&lags, &means, &blocks, Taken::Itself).integral()
        };
        let (found, until) = of(6.0).unwrap();
        assert!(
            (found.value - 6.0).abs() < 0.3 && until == 90.0,
            "{found:?}"
        );
        assert!(of(0.5).is_none());
    }

    /// Uniform numbers from 0 to 1 from a mixing of bits (Appleby, MurmurHash3).
    fn noise(step: u32) -> f64 {
        let mut bits = step.wrapping_mul(0x9e37_79b9);
        for factor in [0x85eb_ca6b_u32, 0xc2b2_ae35] {
            bits = (bits ^ (bits >> 15)).wrapping_mul(factor);
        }
        f64::from(bits ^ (bits >> 16)) / 2f64.powi(32)
    }

    /// The integrals, with their errors, of a curve that is measured in so many replicas of 40
    /// blocks, with white noise of 0.003 of its value at lag 0 in the means.
    fn integrals(curve: impl Fn(f64) -> f64, replicas: u32) -> Vec<TransportValue> {
        let lags = lags();
        // A uniform number has the variance 1/12.
        let scatter = 0.003 * (40.0 * 12.0_f64).sqrt();
        let of_replica = |replica: u32| {
            let of_block = |block: u32| -> Sums {
                let value = |(place, &lag): (u32, &f64)| {
                    let number = (replica * 40 + block) * 64 + place;
                    [curve(lag) + scatter * (noise(number) - 0.5), 1.0]
                };
                (0..).zip(&lags).map(value).collect()
            };
            let blocks: Vec<Sums> = (0..40).map(of_block).collect();
            let sum = |place: usize| {
                blocks
                    .iter()
                    .fold([0.0; 2], |[x, w], b| [x + b[place][0], w + b[place][1]])
            };
            let total: Sums = (0..lags.len()).map(sum).collect();
            let means = carom_tables::block_sums::means(&total, std::slice::from_ref(&blocks));
            let curve = of_one_run(&lags, &means, &blocks, Taken::Itself);
            curve.integral().expect("a resolved curve").0
        };
        (0..replicas).map(of_replica).collect()
    }

    /// ⟨error²⟩ of the integral of exp(−t/5) over its scatter: 1, but for the tail that noise
    /// hides.
    #[test]
    fn the_error_of_an_integral_is_the_scatter_of_replicas() {
        let found = integrals(|t| (-t / 5.0).exp(), 100);
        let mean = |of: &dyn Fn(&TransportValue) -> f64| found.iter().map(of).sum::<f64>() / 100.0;
        let centre = mean(&|one| one.value);
        let scatter = mean(&|one| (one.value - centre).powi(2));
        let ratio = mean(&|one| one.standard_error.powi(2)) / scatter;
        // The scatter has a relative error of √(2/99) = 0.14.
        assert!((0.7..1.6).contains(&ratio), "{ratio}");
        assert!(
            (centre - 5.0).abs() < 4.0 * (scatter / 100.0).sqrt(),
            "{centre} {scatter}"
        );
    }

    /// Curves that have not decayed at the last lag, 90: exp(−t/45) lacks 45 e⁻² of its integral,
    /// and the velocity of a critically damped oscillator, (1 − t/30) exp(−t/30), lacks −90 e⁻³ of
    /// its integral 0.
    #[test]
    fn the_error_of_an_integral_has_the_size_of_the_tail_that_is_left() {
        for found in integrals(|t| (-t / 45.0).exp(), 10) {
            let share = found.standard_error / (45.0 * (-2.0_f64).exp());
            assert!((0.8..1.1).contains(&share), "{found:?}");
        }
        for found in integrals(|t| (1.0 - t / 30.0) * (-t / 30.0).exp(), 10) {
            let share = found.standard_error / (90.0 * (-3.0_f64).exp());
            assert!((0.3..1.1).contains(&share), "{found:?}");
        }
    }

    /// Blocks of a mean over pairs that begin up to four blocks before: neighbours share pairs, so
    /// that single blocks give half of the error of joined ones.
    #[test]
    fn joined_blocks_have_the_error_of_pairs_that_overlap() {
        let sum: Vec<f64> = (0..64u32)
            .map(|block| (block..block + 4).map(noise).sum())
            .collect();
        let blocks: Vec<Sums> = sum.iter().map(|&x| vec![[x, 1.0]]).collect();
        let mean = BlockMean {
            value: Some(sum.iter().sum::<f64>() / 64.0),
            standard_error: None,
            quantity: Some(0),
        };
        let joined = error_of_sum(std::slice::from_ref(&blocks), JOINED_BLOCKS, [(mean, 1.0)])
            .expect("16 joined blocks");
        // The sum of four numbers of variance 1/12, of which a mean over 64 blocks has 16.
        let expected = (4.0 * 4.0 / 12.0 / 64.0_f64).sqrt();
        assert!(
            (0.6..1.6).contains(&(joined / expected)),
            "{joined} {expected}"
        );
    }
}
