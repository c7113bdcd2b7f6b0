//! Error rates and time errors of each detector.

use std::collections::BTreeMap;

use carom_testkit::oracle::{ExclusionReference, Judgement, OracleVerdict};
use serde::{Deserialize, Serialize};

use super::cost::most_evaluations;
use super::{cases::EncounterCase, options::EncounterPlan};
use carom_methods::AnyDetector;

/// A late or early answer with a larger error (natural times) is wrong at any tolerance. An error
/// within the bound on rounding is correct: the times of grazes and fast rotors are not better
/// determined.
pub const FAR_OFF: f64 = 1e-6;

/// The answers of one detector to the cases of one class.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct EncounterTally {
    /// Indices of the searched cases, and the evaluations of each.
    pub searched: Vec<(usize, u32)>,
    /// Judged cases in which there is a contact deeper than 2 E.
    pub contacts: u64,
    /// Number of cases with each verdict.
    pub verdicts: BTreeMap<OracleVerdict, u64>,
    /// |t − t*| in natural times, sorted.
    pub deviations: Vec<f64>,
    /// Number of late and early answers with an error above [`FAR_OFF`].
    far_off: u64,
    /// Total number of evaluations.
    pub evaluations: u64,
    /// Cases that violate a guarantee, by index.
    pub violations: Vec<(usize, Judgement)>,
}

/// One row of the table of answers.
#[derive(Debug, Clone, Serialize)]
pub struct TallyRow {
    class: String,
    detector: &'static str,
    setting: String,
    cases: usize,
    judged: u64,
    contacts: u64,
    right: u64,
    graze_within_2e: u64,
    missed: u64,
    late: u64,
    early: u64,
    #[serde(rename = "false")]
    false_contacts: u64,
    free_until: u64,
    gave_up: u64,
    wrong: f64,
    wrong_upper_95: f64,
    deviation_median: Option<f64>,
    deviation_999: Option<f64>,
    deviation_max: Option<f64>,
    evaluations_per_query: f64,
}

impl EncounterTally {
    /// Runs a detector on the cases in order until the plan's limit on evaluations is reached.
    pub fn new(detector: AnyDetector, cases: &[EncounterCase], plan: &EncounterPlan) -> Self {
        let mut tally = Self::default();
        for (index, case) in cases.iter().enumerate() {
            if most_evaluations(&detector, &case.encounter) > plan.most_evaluations as f64 {
                continue;
            }
            let answer = case.encounter.first_contact(&detector);
            tally.evaluations += u64::from(answer.evaluations);
            tally.searched.push((index, answer.evaluations));
            tally.add(
                index,
                case,
                case.reference().judge(&case.encounter, &answer),
            );
            if tally.evaluations > plan.most_evaluations
                && !matches!(detector, AnyDetector::Exact(_))
            {
                break;
            }
        }
        tally.deviations.sort_by(f64::total_cmp);
        tally
    }

    /// Adds a verdict; `None` if the oracle has no reference.
    pub fn add(&mut self, index: usize, case: &EncounterCase, judgement: Option<Judgement>) {
        let Some(judgement) = judgement else { return };
        self.contacts += u64::from(matches!(case.reference(), ExclusionReference::Deep(_)));
        *self.verdicts.entry(judgement.verdict).or_default() += 1;
        self.deviations.extend(judgement.deviation);
        let beyond_rounding = matches!(
            judgement.verdict,
            OracleVerdict::Late | OracleVerdict::Early
        );
        let far = judgement.deviation.is_some_and(|off| off > FAR_OFF);
        self.far_off += u64::from(beyond_rounding && far);
        if matches!(
            judgement.verdict,
            OracleVerdict::Missed
                | OracleVerdict::Late
                | OracleVerdict::Early
                | OracleVerdict::False
        ) {
            self.violations.push((index, judgement));
        }
    }

    /// Sum over several classes.
    pub fn sum<'a>(tallies: impl IntoIterator<Item = &'a Self>) -> Self {
        let mut sum = Self::default();
        for tally in tallies {
            sum.searched.extend(&tally.searched);
            sum.contacts += tally.contacts;
            for (verdict, count) in &tally.verdicts {
                *sum.verdicts.entry(*verdict).or_default() += count;
            }
            sum.deviations.extend(&tally.deviations);
            sum.far_off += tally.far_off;
            sum.evaluations += tally.evaluations;
            sum.violations.extend(&tally.violations);
        }
        sum.deviations.sort_by(f64::total_cmp);
        sum
    }

    /// Number of cases with this verdict.
    pub fn count(&self, verdict: OracleVerdict) -> u64 {
        self.verdicts.get(&verdict).copied().unwrap_or(0)
    }

    /// Number of cases with a reference.
    pub fn judged(&self) -> u64 {
        self.verdicts.values().sum()
    }

    /// Share of wrong answers: missed, false, given up, or late or early by more than [`FAR_OFF`].
    pub fn wrong(&self) -> f64 {
        let plain = [
            OracleVerdict::Missed,
            OracleVerdict::False,
            OracleVerdict::GaveUp,
        ]
        .map(|verdict| self.count(verdict));
        (plain.iter().sum::<u64>() + self.far_off) as f64 / self.judged().max(1) as f64
    }

    /// Upper end of the 95 % confidence interval of a rate without an observed event: 3/n (Hanley
    /// and Lippman-Hand 1983).
    pub fn upper_bound_of_none(&self) -> f64 {
        3.0 / self.judged().max(1) as f64
    }

    /// Quantile of the time errors (natural times).
    pub fn quantile(&self, share: f64) -> Option<f64> {
        let last = self.deviations.len().checked_sub(1)?;
        Some(self.deviations[((last as f64) * share).ceil() as usize])
    }

    /// Mean number of evaluations of a query.
    pub fn evaluations_per_query(&self) -> f64 {
        self.evaluations as f64 / self.searched.len().max(1) as f64
    }

    /// Row of the table of answers.
    pub fn row(&self, class: &str, detector: &'static str, setting: &str) -> TallyRow {
        TallyRow {
            class: class.to_owned(),
            detector,
            setting: setting.to_owned(),
            cases: self.searched.len(),
            judged: self.judged(),
            contacts: self.contacts,
            right: self.count(OracleVerdict::Right),
            graze_within_2e: self.count(OracleVerdict::Graze),
            missed: self.count(OracleVerdict::Missed),
            late: self.count(OracleVerdict::Late),
            early: self.count(OracleVerdict::Early),
            false_contacts: self.count(OracleVerdict::False),
            free_until: self.count(OracleVerdict::FreeUntil),
            gave_up: self.count(OracleVerdict::GaveUp),
            wrong: self.wrong(),
            wrong_upper_95: self.upper_bound_of_none().max(self.wrong()),
            deviation_median: self.quantile(0.5),
            deviation_999: self.quantile(0.999),
            deviation_max: self.quantile(1.0),
            evaluations_per_query: self.evaluations_per_query(),
        }
    }
}
