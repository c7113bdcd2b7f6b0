//! Tests of equilibrium: quantities that are exactly zero at equilibrium, in units of their
//! standard errors. They show whether the molecule drifts along its body axes or rotates
//! systematically.
//!
//! A bias is reported if it exceeds [`THRESHOLD`] standard errors. The smallest bias that is
//! detected with probability 0.95 follows from the standard error, which decreases in one of two
//! ways:
//!
//! 1. **Diffusing sums.** The error of the mean is proportional to 1/√(time × replicas).
//! 2. **Bounded sums.** In a frame that does not rotate, the impulses sum to the change of
//!    momentum, of variance 2MkT at any time, so the error of the mean is proportional to 1/(time ×
//!    √replicas). The mean vanishes under any steady driving force too, once the molecule moves
//!    steadily. It therefore tests the momentum balance only; the velocity shows a bias. The same
//!    holds for the torque on a rotating molecule, with variance 2IkT, and its angular velocity.
//!
//! A deviation above [`BROKEN`] is a fault of the program and fails the run.

use carom::{
    DirectionHistogram,
    observers::{Block, Drift, Isotropy},
};
use carom_report::page::{Page, with_error};
use carom_tables::Check;
use serde::Serialize;

use super::{
    figures::BROKEN,
    group::Group,
    pooled::{FEWEST_BLOCKS, Pooled},
};
use crate::experiments::thesis_scene::Case;

/// Number of standard errors above which a bias is reported. With at least 30 blocks, chance
/// exceeds it once in 2500 findings (Student's t). Smaller: a campaign of about forty findings
/// would give false alarms. Larger: it would be less sensitive.
const THRESHOLD: f64 = 4.0;

/// A bias this many standard errors above the threshold is detected with probability 0.95
/// (one-sided normal quantile).
const SAFELY: f64 = 1.645;

/// Number of harmonics in the isotropy test of the control.
const HARMONICS: usize = 6;

/// Reason why the mean vanishes.
const FORCE: &str = "equilibrium: the free energy does not depend on the molecule's position";
const TORQUE: &str = "equilibrium: the free energy does not depend on the molecule's orientation";
const VELOCITY: &str = "equilibrium: velocity and orientation are independent";
const MIRROR: &str = "mirror symmetry of the tee";

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

/// Tests of equilibrium for a group of runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Equilibrium {
    /// Number of runs.
    pub replicas: usize,
    /// Duration of the measurement, summed over all runs (time).
    pub duration: f64,
    /// Number of blocks of time in all runs.
    pub blocks: usize,
    /// Duration of a block (time).
    pub block_duration: f64,
    /// Quantities that are zero at equilibrium.
    pub findings: Vec<Finding>,
    /// Isotropy test of the kicks of the control.
    pub isotropy: Option<Isotropy>,
}

impl Finding {
    fn new(name: &str, unit: &'static str, source: &'static str) -> Self {
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
    fn by_blocks(self, pooled: &Pooled) -> Self {
        let longer = pooled.standard_error_of_longer_blocks();
        let judged = self.judged(pooled.mean(), pooled.standard_error());
        Self { standard_error_of_longer_blocks: longer, ..judged }
    }

    /// Test by the variance of the whole sum, which is independent of time and driving force.
    fn bounded(self, pooled: &Pooled, variance: f64) -> Self {
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

    /// Smallest detectable bias with `times` as much time or replicas.
    pub fn smallest_bias_after(&self, times: f64) -> Option<f64> {
        self.smallest_bias.map(|bias| bias / times.sqrt())
    }
}

impl Equilibrium {
    /// Tests the runs of one case and size.
    pub fn of(group: &Group<'_>) -> Self {
        let blocks = || group.runs.iter().flat_map(|run| run.drift.complete());
        let (count, together) = (blocks().count(), blocks().map(|block| block.duration).sum::<f64>());
        let mut findings = forces(group);
        findings.extend(velocities(group));
        findings.extend(mirror(group));
        Self {
            replicas: group.runs.len(),
            duration: group.duration(),
            blocks: count,
            block_duration: if count == 0 { 0.0 } else { together / count as f64 },
            findings,
            isotropy: (group.case == Case::Control).then(|| isotropy(group)).flatten(),
        }
    }

    /// Checks that no deviation is above [`BROKEN`].
    pub fn checks(&self) -> Vec<Check> {
        let of_finding = |finding: &Finding| {
            let name = format!("{}, standard errors from zero", finding.name);
            finding.deviation.map(|deviation| Check::at_most(&name, deviation.abs(), BROKEN))
        };
        let isotropy = self.isotropy.map(|isotropy| {
            Check::at_most("isotropy of the kicks, −log10 p", -isotropy.probability.log10(), BROKEN)
        });
        self.findings.iter().filter_map(of_finding).chain(isotropy).collect()
    }

    /// Adds the results to a page.
    pub fn show(&self, page: &mut Page) {
        page.subheading("Quantities that are zero at equilibrium");
        page.paragraph(&format!(
            "{} blocks of {} units of time, from {} runs. A bias is reported if it exceeds {THRESHOLD} \
             standard errors; a bias equal to the smallest detectable one is found with probability 0.95. The \
             impulses on a molecule whose frame does not rotate, and the torque on a rotating one, sum to the \
             change of momentum: their means test the momentum balance only, and the velocity shows whether \
             the molecule is driven.",
            self.blocks,
            with_error(self.block_duration, None),
            self.replicas,
        ));
        let number =
            |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |value| format!("{value:.2e}"));
        let row = |finding: &Finding| {
            let word = match (finding.bias_found, finding.shrinking) {
                (Some(true), _) => "a bias",
                (Some(false), Shrinking::InverseRoot) => "no bias",
                (Some(false), Shrinking::Inverse) => "balanced",
                (None, _) => "too few blocks",
            };
            let law = match finding.shrinking {
                Shrinking::InverseRoot => "1/√(time × replicas)",
                Shrinking::Inverse => "1/(time × √replicas)",
            };
            vec![
                format!("{} [{}]", finding.name, finding.unit),
                with_error(finding.value, finding.standard_error),
                finding.deviation.map_or_else(|| "–".to_owned(), |deviation| format!("{deviation:.2}")),
                word.to_owned(),
                number(finding.smallest_bias),
                law.to_owned(),
                number(finding.smallest_bias_after(10.0)),
            ]
        };
        let header = [
            "mean",
            "measured",
            "in standard errors",
            "found",
            "smallest detectable bias",
            "error scales as",
            "smallest bias with 10 times the time or replicas",
        ];
        page.table(&header, &self.findings.iter().map(row).collect::<Vec<_>>());
        if let Some(isotropy) = self.isotropy {
            page.paragraph(&format!(
                "Isotropy of the kicks on the disc: the first {} harmonics of the directions, with the \
                 covariance of {} blocks: Fisher's F = {:.2}, exceeded by chance with probability {:.2}.",
                isotropy.harmonics, isotropy.blocks, isotropy.ratio, isotropy.probability
            ));
        }
    }
}

/// A sum over the molecule's motion, as a rate in time.
fn per_time(group: &Group<'_>, sum: impl Fn(&Drift) -> f64) -> Pooled {
    Pooled::of(group.runs, |run| &run.drift, |block: &Block<Drift>| (sum(&block.observed), block.duration))
}

/// Mean force and torque.
fn forces(group: &Group<'_>) -> Vec<Finding> {
    let molecule = &group.runs[0].molecule;
    let (turns, variance) = (group.case.turns(), 2.0 * group.temperature() * group.runs.len() as f64);
    let judged = |finding: Finding, inertia: Option<f64>, pooled: Pooled| match inertia {
        Some(inertia) => finding.bounded(&pooled, inertia * variance),
        None => finding.by_blocks(&pooled),
    };
    let force = |name| Finding::new(name, "mass·length/time²", FORCE);
    let mass = (!turns).then(|| molecule.mass());
    let mut findings = vec![
        judged(force("force along x′"), mass, per_time(group, |drift| drift.impulse().x)),
        judged(force("force along y′"), mass, per_time(group, |drift| drift.impulse().y)),
    ];
    // A disc receives no torque.
    if group.case != Case::Control {
        let finding = Finding::new("torque", "mass·length²/time²", TORQUE);
        let moment = turns.then(|| molecule.moment_of_inertia());
        findings.push(judged(finding, moment, per_time(group, Drift::angular_impulse)));
    }
    findings
}

/// Mean velocity along the body axes, and mean angular velocity.
fn velocities(group: &Group<'_>) -> Vec<Finding> {
    let along = |name| Finding::new(name, "length/time", VELOCITY);
    let mut findings = vec![
        along("velocity along x′").by_blocks(&per_time(group, |drift| drift.path().x)),
        along("velocity along y′").by_blocks(&per_time(group, |drift| drift.path().y)),
    ];
    if group.case.turns() {
        let spin = Finding::new("angular velocity", "1/time", MIRROR);
        findings.push(spin.by_blocks(&per_time(group, Drift::turn)));
    }
    findings
}

/// Mirror symmetry of the tee: difference of the shares of kicks on its wings.
fn mirror(group: &Group<'_>) -> Option<Finding> {
    let (left, right) = (0, 2);
    if group.case == Case::Control || group.kicks.hits() == 0 {
        return None;
    }
    let pair = |block: &Block<DirectionHistogram>| {
        let hits = |atom: usize| block.observed.atom_counts().get(atom).copied().unwrap_or(0) as f64;
        (hits(left) - hits(right), block.observed.hits() as f64)
    };
    let pooled = Pooled::of(group.runs, |run| &run.directions, pair);
    Some(Finding::new("share of kicks on wing A less that on wing C", "1", MIRROR).by_blocks(&pooled))
}

fn isotropy(group: &Group<'_>) -> Option<Isotropy> {
    let blocks = || group.runs.iter().flat_map(|run| run.directions.complete());
    let enough = blocks().count() >= FEWEST_BLOCKS;
    Isotropy::of_counts(blocks().map(|block| block.observed.counts()), HARMONICS).filter(|_| enough)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt as _, SeedableRng as _};
    use rand_pcg::Pcg64;

    /// Sum of twelve uniform numbers minus 6: variance 1, close to normal up to four standard
    /// deviations.
    fn normal(random: &mut Pcg64) -> f64 {
        (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0
    }

    /// Sums over 40 blocks of 8 units of time in each of three runs: a bias, and diffusion of 1 per
    /// time.
    fn planted(bias: f64, random: &mut Pcg64) -> Finding {
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
    fn a_large_deviation_from_equilibrium_fails_the_run() {
        let mut random = Pcg64::seed_from_u64(5);
        let result = |findings, isotropy| Equilibrium {
            replicas: 3,
            duration: 960.0,
            blocks: 120,
            block_duration: 8.0,
            findings,
            isotropy,
        };
        let passed =
            |result: &Equilibrium| result.checks().iter().map(|check| check.passed).collect::<Vec<_>>();
        let sound = [planted(0.0, &mut random), planted(0.0, &mut random)];
        let even = directions(0.0, &mut random);
        assert_eq!(passed(&result(sound.to_vec(), Some(even))), [true; 3]);
        // Ten standard errors of the mean, and twenty of a harmonic.
        let driven = planted(10.0 / 960f64.sqrt(), &mut random);
        let uneven = directions(0.028, &mut random);
        assert_eq!(passed(&result(vec![driven], Some(uneven))), [false; 2]);
    }

    #[test]
    fn few_blocks_give_no_result() {
        let run = (0..29).map(|block| (f64::from(block), 1.0)).collect();
        let finding = Finding::new("planted", "1", FORCE).by_blocks(&Pooled::planted(vec![run]));
        assert_eq!((finding.standard_error, finding.bias_found), (None, None));
        assert_eq!(finding.value, 14.0);
    }

    /// 50 blocks of 20 000 kicks each; the share `excess` of directions prefers +x, and block sizes
    /// vary.
    fn directions(excess: f64, random: &mut Pcg64) -> Isotropy {
        let blocks: Vec<Vec<u64>> = (0..50)
            .map(|_| {
                let level = 55.0 * (1.0 + 0.02 * normal(random));
                let sector = |index: usize| {
                    let angle = std::f64::consts::TAU * (index as f64 + 0.5) / 360.0;
                    let mean = level * (1.0 + excess * angle.cos());
                    (mean + mean.sqrt() * normal(random)).round() as u64
                };
                (0..360).map(sector).collect()
            })
            .collect();
        Isotropy::of_counts(blocks.iter().map(Vec::as_slice), HARMONICS).expect("blocks scatter")
    }

    #[test]
    fn a_planted_anisotropy_is_detected_and_isotropy_is_not_rejected() {
        let mut random = Pcg64::seed_from_u64(4);
        // p-values are uniform: a tenth is below 0.1.
        let low = (0..100).filter(|_| directions(0.0, &mut random).probability < 0.1).count();
        assert!((2..=20).contains(&low), "{low}");
        // A share ε of a million kicks gives √(10⁶/2) ε standard errors of the harmonic: 10 for
        // 0.014.
        assert!(directions(0.014, &mut random).probability < 1e-4);
    }
}
