//! The numbers of a run: figures with errors and predictions, checks, and totals.

use serde::{Deserialize, Serialize};

use crate::{Estimate, Stationarity};

/// Number of standard errors from its prediction above which a figure counts as different from it.
/// With at least 30 independent blocks and the error of [`Figure::judged_by_blocks`], chance
/// exceeds it at most once in 2500 figures (Student's t); with blocks whose neighbours have a
/// correlation of 0.3, once in 400. Smaller: about forty figures of one study would give false
/// alarms. Larger: differences would be missed.
pub const THRESHOLD: f64 = 4.0;

/// With fewer blocks, or independent runs, their scatter gives no reliable test. Smaller: chance
/// exceeds [`THRESHOLD`] more often. Larger: runs must be longer for a verdict.
pub const MIN_BLOCKS: usize = 30;

/// A figure that differs by more standard errors from a prediction that it tests is a fault, not
/// chance: with 30 blocks, chance exceeds this once in 600 000 figures (Student's t). Smaller:
/// correct runs would fail. Larger: faults would pass.
const BROKEN: f64 = 6.0;

/// A difference this many standard errors above the threshold is found with probability 0.95
/// (one-sided normal quantile).
pub const SAFELY: f64 = 1.645;

/// A measured figure.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// Name of the quantity.
    pub name: String,
    /// Measured value.
    pub value: f64,
    /// Its standard error, where it is known.
    pub standard_error: Option<f64>,
    /// Unit, in the scene's units of mass, length and time; 1 for a pure number.
    pub unit: String,
    /// Predicted value, if there is one.
    pub prediction: Option<f64>,
    /// Source of the prediction.
    pub source: Option<String>,
    /// Smallest difference from the prediction that would have been found with probability 0.95;
    /// `None` without an error, or if the figure is no test of its prediction.
    pub smallest_difference: Option<f64>,
    /// The number of its sums, see [`BlockMean::quantity`](crate::BlockMean::quantity); `None` for
    /// a figure that is no mean.
    #[serde(skip)]
    pub quantity: Option<usize>,
    /// The number of blocks, or of independent runs, whose scatter gives the error; `None` if it
    /// comes from something else or is not known.
    #[serde(skip)]
    pub blocks: Option<usize>,
    /// Whether the mean changed during its measurement; `None` if that was not judged.
    #[serde(default)]
    pub stationarity: Option<Stationarity>,
    /// Whether the figure tests its prediction, so that it has a smallest difference.
    #[serde(default)]
    pub is_test: bool,
}

impl Figure {
    /// A figure without error and prediction.
    pub fn new(name: impl Into<String>, value: f64, unit: &str) -> Self {
        Self {
            name: name.into(),
            value,
            standard_error: None,
            unit: unit.to_owned(),
            prediction: None,
            source: None,
            smallest_difference: None,
            stationarity: None,
            quantity: None,
            blocks: None,
            is_test: false,
        }
    }

    /// Adds a standard error; one that is not finite is left out.
    #[must_use]
    pub fn error(self, standard_error: impl Into<Option<f64>>) -> Self {
        Self {
            standard_error: standard_error.into().filter(|error| error.is_finite()),
            ..self
        }
    }

    /// Whether the prediction is an approximation: its distance from the value has another cause
    /// than chance, and is not judged.
    pub fn is_approximate(&self) -> bool {
        self.source
            .as_ref()
            .is_some_and(|source| source.starts_with(APPROXIMATION))
    }

    /// Adds a prediction and its source; `None` adds nothing.
    #[must_use]
    pub fn predicted(self, prediction: impl Into<Option<f64>>, source: &str) -> Self {
        match prediction.into() {
            Some(prediction) => Self {
                prediction: Some(prediction),
                source: Some(source.to_owned()),
                ..self
            },
            None => self,
        }
    }

    /// Marks the figure as a test of its prediction, if it has one: its mean shows any steady
    /// difference, and its error shrinks with time.
    ///
    /// ```
    /// use carom_tables::Figure;
    ///
    /// let velocity = Figure::new("mean velocity", 0.1, "length/time").error(0.2);
    /// let velocity = velocity.predicted(0.0, "equilibrium").test();
    /// // 4 standard errors are found half of the time, 1.645 more with probability 0.95.
    /// assert!((velocity.smallest_difference.expect("an error") - 0.2 * 5.645).abs() < 1e-15);
    /// ```
    #[must_use]
    pub fn test(self) -> Self {
        Self {
            is_test: self.prediction.is_some(),
            ..self
        }
        .resolved()
    }

    /// The distance from the prediction in standard errors, of a figure that tests it. `None` if
    /// the error is 0: what does not scatter is conserved, and no test.
    pub fn deviation(&self) -> Option<f64> {
        let (prediction, error) = (self.prediction?, self.standard_error?);
        (self.is_test && error > 0.0).then(|| (self.value - prediction).abs() / error)
    }

    /// A check that a tested prediction is not missed by more than chance explains.
    pub fn check(&self) -> Option<Check> {
        let prediction = self.prediction?;
        let name = format!("{}: standard errors from {prediction}", self.name);
        self.deviation()
            .map(|deviation| Check::at_most(&name, deviation, BROKEN))
    }

    /// The figure without the error of a test, if the error comes from fewer than [`MIN_BLOCKS`].
    #[must_use]
    pub fn judged_by(self, blocks: usize) -> Self {
        let is_weak = self.is_test && blocks < MIN_BLOCKS;
        Self {
            standard_error: self.standard_error.filter(|_| !is_weak),
            ..self
        }
        .resolved()
    }

    /// The mean of [x, w] of the blocks of each run, judged by their number like
    /// [`judged_by`](Self::judged_by). The error of a test is at least that of independent blocks.
    ///
    /// An error that counts correlations is sometimes much too small by chance: that of 30 to 63
    /// independent blocks takes them for ones that cancel one another, and chance exceeds four such
    /// errors once in 400 means instead of once in 2500. The larger of both errors is exceeded as
    /// rarely as Student's t. Blocks that do cancel have too large an error: the test then finds
    /// less.
    #[must_use]
    pub fn judged_by_blocks(self, runs: &[Vec<[f64; 2]>]) -> Self {
        let with_weight = runs.iter().flatten().filter(|block| block[1] > 0.0);
        let blocks: Vec<(f64, f64)> = with_weight.map(|&[x, w]| (x, w)).collect();
        let count = blocks.len();
        let independent = Estimate::of_ratio(blocks).map_or(0.0, |found| found.standard_error);
        // An error of 0 is that of a conserved quantity, whose blocks differ by rounding.
        let of_test = |error: f64| {
            if error > 0.0 {
                error.max(independent)
            } else {
                error
            }
        };
        Self {
            standard_error: if self.is_test {
                self.standard_error.map(of_test)
            } else {
                self.standard_error
            },
            blocks: Some(count),
            ..self
        }
        .judged_by(count)
    }

    /// The figure with the smallest difference that belongs to its standard error. Call it after
    /// the error has changed.
    #[must_use]
    pub fn resolved(self) -> Self {
        let error = self.standard_error.filter(|_| self.is_test);
        Self {
            smallest_difference: error.map(|error| (THRESHOLD + SAFELY) * error),
            ..self
        }
    }
}

/// First word of the source of a prediction that is an approximation, before its order.
pub const APPROXIMATION: &str = "approximation";

/// A quantity that must not exceed a bound; otherwise the program ends with exit code 1.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Check {
    /// Name of the quantity.
    pub name: String,
    /// Value found.
    pub found: f64,
    /// Largest allowed value.
    pub allowed: f64,
    /// True if `found` ≤ `allowed`.
    pub passed: bool,
}

impl Check {
    /// A check that `found` is at most `allowed`; NaN fails.
    pub fn at_most(name: &str, found: f64, allowed: f64) -> Self {
        Self {
            name: name.to_owned(),
            found,
            allowed,
            passed: found <= allowed,
        }
    }
}

/// Totals of a run.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Totals {
    /// Contacts.
    pub collisions: u64,
    /// Simulated time.
    pub simulated_time: f64,
    /// Contacts per second of processor time of the thread, in the run phase.
    pub collisions_per_second: f64,
    /// Largest difference of energy and booked energy at a sample, relative to the energy at the
    /// start.
    pub energy_drift: f64,
    /// [`allowed_drift`] of the run, by its contacts and its bodies that move; the largest of
    /// several runs. 0 if the number of bodies is not known, as in records of older versions.
    #[serde(default)]
    pub allowed_drift: f64,
    /// Largest number of overlapping pairs at a sample.
    pub overlapping_pairs: usize,
    /// Deepest overlap at a sample, in units of the smaller diameter; may be rounding error.
    pub max_overlap: f64,
}

impl Totals {
    /// Totals of several runs, which may differ in speed.
    pub fn sum(runs: &[Self]) -> Self {
        let seconds: f64 = runs.iter().map(Self::cpu_seconds).sum();
        let collisions: u64 = runs.iter().map(|run| run.collisions).sum();
        Self {
            collisions,
            simulated_time: runs.iter().map(|run| run.simulated_time).sum(),
            collisions_per_second: if collisions == 0 {
                0.0
            } else {
                collisions as f64 / seconds
            },
            energy_drift: runs.iter().map(|run| run.energy_drift).fold(0.0, f64::max),
            allowed_drift: runs.iter().map(|run| run.allowed_drift).fold(0.0, f64::max),
            overlapping_pairs: runs
                .iter()
                .map(|run| run.overlapping_pairs)
                .max()
                .unwrap_or(0),
            max_overlap: runs.iter().map(|run| run.max_overlap).fold(0.0, f64::max),
        }
    }

    /// Processor time of the run phase, summed over all threads (seconds).
    pub fn cpu_seconds(&self) -> f64 {
        if self.collisions == 0 {
            0.0
        } else {
            self.collisions as f64 / self.collisions_per_second
        }
    }

    /// Checks that no pair overlaps and that energy is conserved.
    pub fn checks(&self) -> Vec<Check> {
        vec![
            Check::at_most(OVERLAPPING_PAIRS, self.overlapping_pairs as f64, 0.0),
            Check::at_most(
                "energy_drift",
                self.energy_drift,
                allowed_drift(self.collisions, None).max(self.allowed_drift),
            ),
        ]
    }
}

/// Largest relative drift of the energy that rounding explains after this number of contacts:
/// 10⁻¹², or 16 ε √n, or 13 ε n/N^(3/2) of N bodies that move, whichever is the most, with
/// ε = 2⁻⁵². Without the number of bodies the last one is left out.
///
/// The rounding errors of n contacts are independent and without bias, so their sum is a random
/// walk. One contact changes the energy of its two bodies by at most 1.5 ε of it (root mean square,
/// measured for discs of many mass ratios). In the worst case these two have all the energy, and 16
/// ε √n is 10 standard deviations. An error of one sign, such as that of a wrong response, grows in
/// proportion to n: one of 10⁻¹⁶ a contact is found from 10⁴ contacts on, where 10 bodies or more
/// move.
///
/// A body whose contacts repeat, such as a lone ball between two walls, makes an equal rounding
/// error δ of its energy at each of them, and the errors add up. With n/N contacts for each body,
/// and an energy of about E/N each, one body has drifted by δ (n/N) (E/N). The errors of different
/// bodies are independent, so that the N drifts add up as √N times one: δ n/N^(3/2) of E.
pub fn allowed_drift(contacts: u64, bodies: Option<u64>) -> f64 {
    let contacts = contacts as f64;
    let of_walk = DRIFT_FACTOR * contacts.sqrt();
    let of_equal = bodies.map_or(0.0, |bodies| {
        let bodies = bodies.max(1) as f64;
        EQUAL_DRIFT_FACTOR * contacts / (bodies * bodies.sqrt())
    });
    MIN_ALLOWED_DRIFT.max(f64::EPSILON * of_walk.max(of_equal))
}

/// Name of the check that no pair overlaps.
pub const OVERLAPPING_PAIRS: &str = "overlapping_pairs";

/// Allowed drift of the energy of short runs. Smaller: sums of the energies of many bodies would
/// fail. Larger: an error in the response could hide.
const MIN_ALLOWED_DRIFT: f64 = 1e-12;

/// Allowed drift in units of ε √n. Smaller: some runs would fail by chance. Larger: an error of one
/// sign is found later.
const DRIFT_FACTOR: f64 = 16.0;

/// Allowed drift in units of ε n/N^(3/2): 4 times the 7·10⁻¹⁶ = 3.2 ε a contact that was measured
/// for a lone ball in a box, and under gravity. Smaller: a lone body could fail, by other numbers.
/// Larger: an error of one sign in systems of few bodies could hide.
const EQUAL_DRIFT_FACTOR: f64 = 13.0;

/// `summary.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// Name of the run.
    pub title: String,
    /// First note to the reader, for instance that the run is short.
    pub note: String,
    /// Totals, at the top level.
    #[serde(flatten)]
    pub totals: Totals,
    /// Checks.
    pub checks: Vec<Check>,
    /// Figures.
    pub figures: Vec<Figure>,
    /// The runs of a campaign.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub runs: Vec<OneRun>,
}

/// One run of a campaign.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OneRun {
    /// Name of its folder.
    pub name: String,
    /// Contacts.
    pub collisions: u64,
    /// Processor time of the run phase (seconds).
    pub cpu_seconds: f64,
}

impl OneRun {
    /// A run with the name of its folder and its totals.
    pub fn new(name: String, totals: &Totals) -> Self {
        Self {
            name,
            collisions: totals.collisions,
            cpu_seconds: totals.cpu_seconds(),
        }
    }
}

/// Whether no figure changed during its measurement; `None` if none was judged.
pub fn are_stationary<'a>(figures: impl IntoIterator<Item = &'a Figure>) -> Option<bool> {
    let judged = figures.into_iter().filter_map(|figure| figure.stationarity);
    judged
        .map(|found| found.is_stationary)
        .reduce(|all, one| all && one)
}

/// A summary with what follows from its figures, as it is written to `summary.json`.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct SummaryFile<'a> {
    #[serde(flatten)]
    summary: &'a Summary,
    /// See [`are_stationary`].
    stationary: Option<bool>,
}

impl<'a> SummaryFile<'a> {
    /// The file of a summary.
    pub fn new(summary: &'a Summary) -> Self {
        Self {
            summary,
            stationary: are_stationary(&summary.figures),
        }
    }
}

impl Summary {
    /// [`Verdict::Passed`] if all checks passed.
    pub fn verdict(&self) -> Verdict {
        if self.checks.iter().all(|check| check.passed) {
            Verdict::Passed
        } else {
            Verdict::Failed
        }
    }
}

/// Result of all checks, which gives the exit code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Exit code 0.
    Passed,
    /// Exit code 1.
    Failed,
    /// Exit code 3: all checks passed, but parts of the data are missing.
    Incomplete,
}

impl Verdict {
    /// The word for it in JSON and on pages.
    pub fn word(self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::Failed => "failed",
            Self::Incomplete => "incomplete",
        }
    }

    /// The verdict on data of which parts are missing: a failed check counts more.
    #[must_use]
    pub fn of_incomplete(self) -> Self {
        if self == Self::Passed {
            Self::Incomplete
        } else {
            self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::block_sums::tests::{Random, normal};

    #[test]
    fn a_value_equal_to_the_bound_passes_and_nan_fails() {
        assert!(Check::at_most("x", 0.0, 0.0).passed);
        assert!(Check::at_most("x", 1e-12, 1e-12).passed);
        assert!(!Check::at_most("x", 1.000_001e-12, 1e-12).passed);
        assert!(!Check::at_most("x", f64::NAN, 1e-12).passed);
    }

    #[test]
    fn a_tested_prediction_fails_six_errors_away_and_only_with_enough_blocks() {
        let velocity = |value: f64| {
            Figure::new("v", value, "1")
                .error(0.1)
                .predicted(0.0, "symmetry")
        };
        let passes = |figure: Figure| figure.check().map(|check| check.passed);
        assert_eq!(
            [0.5, 0.61, f64::NAN].map(|v| passes(velocity(v).test())),
            [Some(true), Some(false), Some(false)]
        );
        assert_eq!(passes(velocity(0.9)), None, "no test");
        let weak = velocity(0.9).test().judged_by(MIN_BLOCKS - 1);
        assert!(
            weak.is_test && weak.standard_error.is_none() && weak.smallest_difference.is_none()
        );
        assert_eq!(
            (
                passes(weak),
                passes(velocity(0.9).test().judged_by(MIN_BLOCKS))
            ),
            (None, Some(false))
        );
        assert!(velocity(0.9).judged_by(2).standard_error.is_some());
    }

    #[test]
    fn tests_of_independent_blocks_give_no_more_false_alarms_than_student_s_t() {
        let mut random = Random(0x9E37_79B9_7F4A_7C15);
        let [mut alarms, mut of_correlated] = [0; 2];
        for _ in 0..20_000 {
            let run: Vec<[f64; 2]> = (0..MIN_BLOCKS)
                .map(|_| [normal(&mut random), 1.0])
                .collect();
            let runs = [run];
            let found = Estimate::of_runs(&runs).unwrap();
            let figure = Figure::new("v", found.mean, "1")
                .error(found.standard_error)
                .predicted(0.0, "symmetry")
                .test();
            let is_alarm = |figure: &Figure| figure.deviation().unwrap() > THRESHOLD;
            of_correlated += u32::from(is_alarm(&figure));
            let judged = figure.judged_by_blocks(&runs);
            assert_eq!(judged.blocks, Some(MIN_BLOCKS));
            alarms += u32::from(is_alarm(&judged));
        }
        // Once in 2500 is 8 times; 4.5 times are expected.
        assert!(alarms <= 15, "{alarms}");
        assert!(of_correlated > 25, "{of_correlated}");
    }

    #[test]
    fn blocks_without_weight_are_none_and_a_conserved_quantity_stays_without_error() {
        let figure = |error: f64| {
            Figure::new("v", 1.0, "1")
                .error(error)
                .predicted(0.0, "symmetry")
                .test()
        };
        let block = |n: usize| [1.0 + 0.1 * (n % 3) as f64, 1.0];
        let mut run: Vec<[f64; 2]> = (0..MIN_BLOCKS).map(block).collect();
        let runs = [run.clone()];
        assert_eq!(
            figure(0.0).judged_by_blocks(&runs).standard_error,
            Some(0.0)
        );
        assert_eq!(
            figure(9.0).judged_by_blocks(&runs).standard_error,
            Some(9.0)
        );
        let independent = Estimate::of_ratio(run.iter().map(|&[x, w]| (x, w))).unwrap();
        let least = figure(1e-9).judged_by_blocks(&runs);
        assert_eq!(least.standard_error, Some(independent.standard_error));
        assert_eq!(least.clone().resolved(), least);
        // One block fewer, as in a run in which nothing happened for that long.
        run[3] = [0.0, 0.0];
        let few = figure(0.1).judged_by_blocks(&[run]);
        assert_eq!(
            (few.standard_error, few.blocks),
            (None, Some(MIN_BLOCKS - 1))
        );
        // What is no test keeps its error.
        let plain = Figure::new("v", 1.0, "1").error(1e-9);
        assert_eq!(plain.judged_by_blocks(&runs).standard_error, Some(1e-9));
    }

    #[test]
    fn the_allowed_drift_grows_as_a_random_walk() {
        assert_eq!([0, 1, 50_000].map(|n| allowed_drift(n, None)), [1e-12; 3]);
        assert_eq!(
            allowed_drift(1 << 40, None),
            16.0 * f64::EPSILON * f64::from(1 << 20)
        );
        let passes = |collisions, energy_drift| {
            let totals = Totals {
                collisions,
                energy_drift,
                ..Totals::default()
            };
            totals.checks().iter().all(|check| check.passed)
        };
        assert!(passes(400_000_000, 1e-11) && !passes(400_000, 1e-11));
        assert!(!passes(1_000_000, 8e-17 * 1e6), "a drift of one sign");
        assert!(!passes(u64::MAX, f64::NAN));
    }

    #[test]
    fn equal_errors_of_few_bodies_may_add_up_and_those_of_many_are_a_random_walk() {
        // A lone ball, as measured: 7·10⁻¹² after 10⁴ bounces.
        let drift = |contacts: u64| 7e-16 * contacts as f64;
        for contacts in [10_000, 1_000_000, 100_000_000] {
            let allowed = allowed_drift(contacts, Some(1));
            assert!(drift(contacts) > allowed_drift(contacts, None));
            assert!(drift(contacts) < allowed && allowed < 5.0 * drift(contacts));
        }
        // Four balls: half the relative drift at the same number of contacts for each.
        assert_eq!(
            allowed_drift(4 << 30, Some(4)),
            0.5 * allowed_drift(1 << 30, Some(1))
        );
        // 10⁴ discs: the random walk, up to 10¹² contacts.
        let of_gas = |contacts| allowed_drift(contacts, Some(10_000));
        assert_eq!(of_gas(1 << 36), allowed_drift(1 << 36, None));
        // No body moves, so nothing touches.
        assert_eq!(allowed_drift(0, Some(0)), 1e-12);
    }

    #[test]
    fn runs_of_few_bodies_are_judged_by_their_number_and_older_records_without_it() {
        let one = Totals {
            collisions: 1_000_000,
            energy_drift: 7e-10,
            allowed_drift: allowed_drift(1_000_000, Some(1)),
            ..Totals::default()
        };
        let passes = |totals: Totals| totals.checks().iter().all(|check| check.passed);
        assert!(passes(one));
        let all = Totals::sum(&[one; 32]);
        assert!(passes(all));
        // More runs allow no run a larger drift of one sign.
        let broken = Totals {
            energy_drift: 4e-9,
            ..one
        };
        assert!(!passes(Totals::sum(&[broken; 32])));
        let mut old = serde_json::to_value(one).unwrap();
        old.as_object_mut().unwrap().remove("allowed_drift");
        let old: Totals = serde_json::from_value(old).unwrap();
        assert_eq!((old.collisions, old.allowed_drift), (1_000_000, 0.0));
        assert!(!passes(old), "the former rule");
    }

    #[test]
    fn totals_of_runs_add_times_and_take_the_worst_errors() {
        let run = |collisions, rate, pairs| Totals {
            collisions,
            simulated_time: 2.0,
            collisions_per_second: rate,
            energy_drift: rate * 1e-20,
            allowed_drift: rate,
            overlapping_pairs: pairs,
            max_overlap: 0.0,
        };
        // 100 in 1 s and 100 in 4 s.
        let totals = Totals::sum(&[run(100, 100.0, 0), run(100, 25.0, 3)]);
        assert_eq!(totals.collisions_per_second, 40.0);
        assert_eq!(
            (
                totals.collisions,
                totals.simulated_time,
                totals.overlapping_pairs
            ),
            (200, 4.0, 3)
        );
        assert_eq!(totals.energy_drift, 100.0 * 1e-20);
        assert_eq!(totals.allowed_drift, 100.0);
        assert!(totals.checks().iter().any(|check| !check.passed));
        assert_eq!(Totals::sum(&[]).collisions_per_second, 0.0);
    }

    #[test]
    fn totals_are_at_the_top_level_of_the_file() {
        let summary = Summary {
            title: "t".to_owned(),
            note: String::new(),
            totals: Totals {
                collisions: 7,
                ..Totals::default()
            },
            checks: Vec::new(),
            figures: vec![
                Figure::new("kT", 1.0, "energy")
                    .error(0.5)
                    .predicted(1.0, "equipartition"),
            ],
            runs: Vec::new(),
        };
        let json = serde_json::to_value(&summary).unwrap();
        assert_eq!(json["collisions"], 7);
        assert_eq!(json["overlapping_pairs"], 0);
        assert_eq!(json["figures"][0]["standard_error"], 0.5);
        assert_eq!(Verdict::Passed.of_incomplete(), Verdict::Incomplete);
        assert_eq!(Verdict::Failed.of_incomplete(), Verdict::Failed);
        assert_eq!(summary.verdict(), Verdict::Passed);
    }
}
