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
use carom_report::{
    molecule_picture::name as letter,
    page::{Page, named, with_error},
};
use carom_tables::{Check, THRESHOLD};
use serde::Serialize;

use super::{
    figures::BROKEN,
    finding::{Finding, Shrinking, two_digits},
    group::{Group, MIN_BLOCK},
    pooled::{MIN_BLOCKS, Pooled},
};

/// Number of harmonics in the isotropy test of the control.
const HARMONICS: usize = 6;

/// Reason why the mean vanishes.
const FORCE: &str = "equilibrium: the free energy does not depend on the molecule's position";
const TORQUE: &str = "equilibrium: the free energy does not depend on the molecule's orientation";
const VELOCITY: &str = "equilibrium: velocity and orientation are independent";
const SPIN: &str = "equilibrium: angular velocity and orientation are independent";
const MIRROR: &str = "mirror symmetry of the molecule";

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
    /// Least duration of a block for a verdict: three relaxation times of the molecule (time).
    pub least_block: f64,
    /// Quantities that are zero at equilibrium.
    pub findings: Vec<Finding>,
    /// Isotropy test of the kicks of the control.
    pub isotropy: Option<Isotropy>,
}

impl Equilibrium {
    /// Tests the runs of one molecule.
    pub fn of(group: &Group<'_>) -> Self {
        let blocks = || group.runs.iter().flat_map(|run| run.drift.complete());
        let (count, together) = (blocks().count(), blocks().map(|block| block.duration).sum::<f64>());
        let mut findings = forces(group);
        findings.extend(velocities(group));
        findings.extend(mirror(group));
        if !group.has_long_blocks() {
            findings.iter_mut().for_each(Finding::withdraw);
        }
        Self {
            replicas: group.runs.len(),
            duration: group.duration(),
            blocks: count,
            block_duration: if count == 0 { 0.0 } else { together / count as f64 },
            findings,
            least_block: MIN_BLOCK * group.relaxation_times().into_iter().fold(0.0, f64::max),
            isotropy: group.is_round().then(|| isotropy(group)).flatten(),
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

    /// The verdict on all means in a sentence.
    pub fn sentence(&self) -> String {
        let judged = || self.findings.iter().filter_map(|finding| Some((finding, finding.deviation?.abs())));
        let velocities = || self.findings.iter().filter(|finding| finding.source == VELOCITY);
        let Some((worst, most)) = judged()
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .filter(|_| velocities().all(|finding| finding.deviation.is_some()))
        else {
            return self.why_no_verdict();
        };
        let biased: Vec<String> = judged()
            .filter(|(_, deviation)| *deviation > THRESHOLD)
            .map(|(finding, deviation)| {
                let value = with_error(finding.value, finding.standard_error);
                format!("{} = {value} {}, {deviation:.1} standard errors from 0", finding.name, finding.unit)
            })
            .collect();
        if !biased.is_empty() {
            return format!("A bias: {}.", biased.join("; "));
        }
        let smallest = velocities().filter_map(|finding| finding.smallest_bias).fold(0.0, f64::max);
        let seen = if smallest > 0.0 {
            format!(" A drift of {} length/time would have been found.", two_digits(smallest))
        } else {
            String::new()
        };
        format!(
            "No bias: {} means are 0 at equilibrium, and the largest deviation is {most:.1} standard errors \
             ({}).{seen}",
            judged().count(),
            worst.name
        )
    }

    fn why_no_verdict(&self) -> String {
        if !self.least_block.is_finite() {
            return "No verdict: the gas has not touched the molecule.".to_owned();
        }
        // Twice as many blocks are joined in pairs.
        let block = if self.blocks < MIN_BLOCKS { self.block_duration } else { 0.0 };
        let enough = MIN_BLOCKS as f64 * block.max(2.0 * self.least_block);
        format!(
            "No verdict: the run is too short. It has {} blocks of {} units of time each; the verdict needs \
             {MIN_BLOCKS} of at least {}, that is a measurement of about {}.",
            self.blocks,
            two_digits(self.block_duration),
            two_digits(self.least_block),
            two_digits(enough),
        )
    }

    /// Adds the results to a page.
    pub fn show(&self, page: &mut Page) {
        page.subheading("Quantities that are zero at equilibrium");
        page.paragraph(&format!(
            "{} blocks of {} units of time, from {} {}. A bias is reported if it exceeds {THRESHOLD} \
             standard errors; a bias equal to the smallest detectable one is found with probability 0.95. The \
             impulses on a molecule whose frame does not rotate, and the torque on a rotating one, sum to the \
             change of momentum: their means test the momentum balance only, and the velocity shows whether \
             the molecule is driven.",
            self.blocks,
            with_error(self.block_duration, None),
            self.replicas,
            if self.replicas == 1 { "run" } else { "runs" },
        ));
        let number = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), two_digits);
        let row = |finding: &Finding| {
            let word = match (finding.bias_found, finding.shrinking) {
                (Some(true), _) => "a bias",
                (Some(false), Shrinking::InverseRoot) => "no bias",
                (Some(false), Shrinking::Inverse) => "balanced",
                (None, _) => "too short",
            };
            let law = match finding.shrinking {
                Shrinking::InverseRoot => "1/√(time × replicas)",
                Shrinking::Inverse => "1/(time × √replicas)",
            };
            vec![
                named(&finding.name, finding.unit),
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
    let molecule = group.molecule();
    let (turns, variance) = (group.turns(), 2.0 * group.temperature() * group.runs.len() as f64);
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
    if !group.is_round() {
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
    if group.turns() {
        let spin = Finding::new("angular velocity", "1/time", SPIN);
        findings.push(spin.by_blocks(&per_time(group, Drift::turn)));
    }
    findings
}

/// Mirror symmetry: difference of the shares of kicks on the atoms of both sides.
fn mirror(group: &Group<'_>) -> Option<Finding> {
    let [left, right] = group.mirror.as_ref().filter(|_| !group.is_round())?.sides();
    if left.is_empty() || group.kicks.hits() == 0 {
        return None;
    }
    let pair = |block: &Block<DirectionHistogram>| {
        let hits = |atom: &usize| block.observed.atom_counts().get(*atom).copied().unwrap_or(0) as f64;
        let on = |side: &[usize]| side.iter().map(hits).sum::<f64>();
        (on(&left) - on(&right), block.observed.hits() as f64)
    };
    let pooled = Pooled::of(group.runs, |run| &run.directions, pair);
    let name = |side: &[usize]| side.iter().map(|&atom| letter(atom)).collect::<Vec<_>>().join(", ");
    let name = format!("share of kicks on {} less that on {}", name(&left), name(&right));
    Some(Finding::new(&name, "1", MIRROR).by_blocks(&pooled))
}

fn isotropy(group: &Group<'_>) -> Option<Isotropy> {
    let blocks = || group.runs.iter().flat_map(|run| run.directions.complete());
    let enough = blocks().count() >= MIN_BLOCKS;
    Isotropy::of_counts(blocks().map(|block| block.observed.counts()), HARMONICS).filter(|_| enough)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::brownian::finding::tests::{normal, planted};
    use rand::SeedableRng as _;
    use rand_pcg::Pcg64;

    #[test]
    fn a_large_deviation_from_equilibrium_fails_the_run() {
        let mut random = Pcg64::seed_from_u64(5);
        let result = |findings, isotropy| Equilibrium {
            replicas: 3,
            duration: 960.0,
            blocks: 120,
            block_duration: 8.0,
            least_block: 3.0,
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
    fn the_verdict_names_the_bias_or_what_a_verdict_needs() {
        let mut random = Pcg64::seed_from_u64(6);
        let result = |findings: Vec<Finding>, blocks| Equilibrium {
            replicas: 3,
            duration: 960.0,
            blocks,
            block_duration: 8.0,
            least_block: 3.0,
            findings,
            isotropy: None,
        };
        let sound = planted(0.0, &mut random);
        let driven = planted(10.0 / 960f64.sqrt(), &mut random);
        let sentence = result(vec![sound.clone(), sound.clone()], 120).sentence();
        assert!(sentence.starts_with("No bias: 2 means are 0"), "{sentence}");
        let sentence = result(vec![sound.clone(), driven], 120).sentence();
        assert!(sentence.starts_with("A bias: planted = 0.3"), "{sentence}");
        // 20 blocks of 8 units of time: ten more are needed, and longer ones are not.
        let mut short = sound;
        short.withdraw();
        assert_eq!((short.value != 0.0, short.deviation, short.bias_found), (true, None, None));
        let sentence = result(vec![short.clone()], 20).sentence();
        assert!(sentence.starts_with("No verdict") && sentence.ends_with("about 240."), "{sentence}");
        let untouched = Equilibrium { least_block: f64::INFINITY, ..result(vec![short], 20) };
        assert!(untouched.sentence().contains("not touched"));
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
