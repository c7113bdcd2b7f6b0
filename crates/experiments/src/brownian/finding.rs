//! One quantity that is zero at equilibrium: its mean, its error, and whether a bias is found.

use carom_report::page::with_error;
use carom_tables::{SAFELY, THRESHOLD};
use serde::Serialize;

use super::pooled::Pooled;

/// Scaling of the error of a mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shrinking {
    /// 1/√(time × replicas): the sum diffuses.
    InverseRoot,
    /// 1/(time × √replicas): the sum is a difference between final and initial values.
    Inverse,
}

/// A quantity that is zero at equilibrium, and its test.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// Name of the quantity.
    pub name: String,
    /// Its unit, in the scene's units of mass, length and time.
    pub unit: &'static str,
    /// Mean over all runs.
    pub value: f64,
    /// Standard error; `None` with too few blocks.
    pub standard_error: Option<f64>,
    /// Standard error from blocks four times as long; about the same if the blocks are long enough.
    pub standard_error_of_longer_blocks: Option<f64>,
    /// Mean divided by its standard error.
    pub deviation: Option<f64>,
    /// True if a bias is detected.
    pub bias_found: Option<bool>,
    /// Smallest bias that is detected with probability 0.95; `None` if the mean cannot show a bias.
    pub smallest_bias: Option<f64>,
    /// Scaling of the error and the smallest bias.
    pub shrinking: Shrinking,
    /// Reason why it is zero.
    pub source: &'static str,
}

impl Finding {
    /// A quantity without data, with its unit and the reason why it is zero.
    pub fn new(name: &str, unit: &'static str, source: &'static str) -> Self {
        Self {
            name: name.to_owned(),
            unit,
            value: 0.0,
            standard_error: None,
            standard_error_of_longer_blocks: None,
            deviation: None,
            bias_found: None,
            smallest_bias: None,
            shrinking: Shrinking::InverseRoot,
            source,
        }
    }

    /// Test by the scatter of blocks.
    pub fn by_blocks(self, pooled: &Pooled) -> Self {
        let longer = pooled.standard_error_of_longer_blocks();
        let judged = self.judged(pooled.mean(), pooled.standard_error());
        Self { standard_error_of_longer_blocks: longer, ..judged }
    }

    /// Test by the variance of the whole sum, which is independent of time and driving force.
    pub fn bounded(self, pooled: &Pooled, variance: f64) -> Self {
        let judged = self.judged(pooled.mean(), Some(variance.sqrt() / pooled.weight()));
        Self { shrinking: Shrinking::Inverse, smallest_bias: None, ..judged }
    }

    fn judged(self, value: f64, standard_error: Option<f64>) -> Self {
        let deviation = standard_error.map(|error| value / error);
        Self {
            value,
            standard_error,
            deviation,
            bias_found: deviation.map(|deviation| deviation.abs() > THRESHOLD),
            smallest_bias: standard_error.map(|error| (THRESHOLD + SAFELY) * error),
            ..self
        }
    }

    /// Leaves out the error and all that follows from it, because the blocks are too short.
    pub fn withdraw(&mut self) {
        let Self { name, unit, value, shrinking, source, .. } = self;
        *self = Self { value: *value, shrinking: *shrinking, ..Self::new(name, unit, source) };
    }

    /// Smallest detectable bias with `times` as much time or replicas.
    pub fn smallest_bias_after(&self, times: f64) -> Option<f64> {
        self.smallest_bias.map(|bias| bias / times.sqrt())
    }
}

/// A value rounded to two digits.
pub fn two_digits(value: f64) -> String {
    with_error(format!("{value:.1e}").parse().unwrap_or(value), None)
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use rand::{RngExt as _, SeedableRng as _};
    use rand_pcg::Pcg64;

    const FORCE: &str = "planted";

    /// Sum of twelve uniform numbers minus 6: variance 1, close to normal up to four standard
    /// deviations.
    pub fn normal(random: &mut Pcg64) -> f64 {
        (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0
    }

    /// Sums over 40 blocks of 8 units of time in each of three runs: a bias, and diffusion of 1 per
    /// time.
    pub fn planted(bias: f64, random: &mut Pcg64) -> Finding {
        let block = |random: &mut Pcg64| (bias * 8.0 + 8f64.sqrt() * normal(random), 8.0);
        let runs = (0..3).map(|_| (0..40).map(|_| block(random)).collect()).collect();
        Finding::new("planted", "1", FORCE).by_blocks(&Pooled::planted(runs))
    }

    fn found(finding: &Finding) -> bool {
        finding.bias_found.expect("there are 120 blocks")
    }

    #[test]
    fn a_planted_bias_is_found_and_none_is_not() {
        let mut random = Pcg64::seed_from_u64(1);
        // The error of the mean is 1/√960. The smallest bias is detected in 95 % of all cases: 380
        // ± 4 of 400.
        let smallest = (THRESHOLD + SAFELY) / 960f64.sqrt();
        for sign in [1.0, -1.0] {
            let count = (0..400).filter(|_| found(&planted(sign * smallest, &mut random))).count();
            assert!((360..398).contains(&count), "{count}");
        }
        // Half of the threshold lies 2 σ below it and is rarely detected; zero is not detected.
        assert_eq!((0..400).filter(|_| found(&planted(0.0, &mut random))).count(), 0);
        let half = 0.5 * THRESHOLD / 960f64.sqrt();
        assert!((0..400).filter(|_| found(&planted(half, &mut random))).count() < 30);
    }

    #[test]
    fn errors_agree_with_the_planted_scatter() {
        let mut random = Pcg64::seed_from_u64(2);
        let findings: Vec<Finding> = (0..400).map(|_| planted(0.0, &mut random)).collect();
        let squares = findings.iter().map(|finding| finding.deviation.unwrap().powi(2)).sum::<f64>() / 400.0;
        // ⟨t²⟩ = 119/117, with a standard error of √(2/400).
        assert!((squares - 1.0).abs() < 0.28, "{squares}");
        let ratio = |finding: &Finding| {
            finding.standard_error_of_longer_blocks.unwrap() / finding.standard_error.unwrap()
        };
        let mean = findings.iter().map(ratio).sum::<f64>() / 400.0;
        assert!((mean - 1.0).abs() < 0.03, "{mean}");
    }

    /// Correlated blocks show a larger error when joined: a random walk of ±1 steps that seldom
    /// changes direction.
    #[test]
    fn correlated_blocks_have_a_larger_error_when_joined() {
        let mut random = Pcg64::seed_from_u64(3);
        let mut value = 1.0;
        let run = (0..4000)
            .map(|_| {
                if random.random::<f64>() < 0.05 {
                    value = -value;
                }
                (value, 1.0)
            })
            .collect();
        let finding = Finding::new("planted", "1", FORCE).by_blocks(&Pooled::planted(vec![run]));
        let [short, long] =
            [finding.standard_error, finding.standard_error_of_longer_blocks].map(Option::unwrap);
        assert!(long > 1.7 * short, "{short} {long}");
    }

    #[test]
    fn a_bounded_sum_is_judged_by_its_own_variance() {
        // P(t) − P(0) of a molecule of mass 10 at kT = 1 over 100 units of time.
        let judge =
            |sum| Finding::new("force", "1", FORCE).bounded(&Pooled::planted(vec![vec![(sum, 100.0)]]), 20.0);
        assert_eq!(judge(3.0).bias_found, Some(false));
        assert_eq!(judge(-5.0 * 20f64.sqrt()).bias_found, Some(true));
        assert!((judge(0.0).standard_error.unwrap() - 0.2f64.sqrt() / 10.0).abs() < 1e-15);
        // A steady drift needs no steady force.
        assert_eq!(judge(0.0).smallest_bias, None);
    }

    #[test]
    fn few_blocks_give_no_result() {
        let run = (0..29).map(|block| (f64::from(block), 1.0)).collect();
        let finding = Finding::new("planted", "1", FORCE).by_blocks(&Pooled::planted(vec![run]));
        assert_eq!((finding.standard_error, finding.bias_found), (None, None));
        assert_eq!(finding.value, 14.0);
    }
}
