//! Time of a query relative to the exact detector on the same cases.

use std::{hint::black_box, time::Duration};

use carom_detection::encounters::Encounter;
use carom_tables::averages::median;
use cpu_time::ThreadTime;
use serde::{Deserialize, Serialize};

use super::{cases::EncounterCase, tally::EncounterTally};
use carom_methods::AnyDetector;

/// Largest number of cases timed together, and their approximate evaluations: a batch of
/// milliseconds.
const BATCH: usize = 64;
const BATCH_EVALUATIONS: u64 = 100_000;

/// Queries with more evaluations are not timed.
const MAX_EVALUATIONS: u32 = 10_000_000;

/// Shorter batches are repeated: the clock resolution is some tenths of a microsecond.
const MIN_BATCH: Duration = Duration::from_micros(100);

/// Times of one detector on the cases of one class.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct Timing {
    /// Number of cases.
    pub cases: usize,
    /// Time relative to [`carom_detection::Exact`] in the same round, median over rounds.
    pub ratio: f64,
    /// Median time of a query of Exact (seconds).
    pub exact: f64,
}

/// The cases for the timing of one detector: the first that it searched, up to the size of a batch.
fn batch<'a>(tally: &EncounterTally, cases: &'a [EncounterCase]) -> Vec<&'a Encounter> {
    let mut evaluations = 0;
    let taken = tally
        .searched
        .iter()
        .filter(|(_, cost)| *cost <= MAX_EVALUATIONS)
        .take_while(|(_, cost)| {
            let fits = evaluations < BATCH_EVALUATIONS;
            evaluations += u64::from(*cost);
            fits
        });
    taken
        .take(BATCH)
        .map(|(index, _)| &cases[*index].encounter)
        .collect()
}

/// Times detectors in turn, in several rounds.
pub fn time(
    detectors: &[(AnyDetector, &EncounterTally)],
    cases: &[EncounterCase],
    rounds: usize,
) -> Vec<Option<Timing>> {
    let exact = detectors[0].0;
    let batches: Vec<Vec<&Encounter>> = detectors
        .iter()
        .map(|(_, tally)| batch(tally, cases))
        .collect();
    let repeats: Vec<[u32; 2]> = detectors
        .iter()
        .zip(&batches)
        .map(|((detector, _), batch)| [exact, *detector].map(|detector| repeats(detector, batch)))
        .collect();
    let mut ratios = vec![Vec::new(); detectors.len()];
    let mut seconds = vec![Vec::new(); detectors.len()];
    for _ in 0..rounds {
        for (index, (detector, _)) in detectors.iter().enumerate() {
            let batch = &batches[index];
            if batch.is_empty() {
                continue;
            }
            let [own, other] = [repeats[index][1], repeats[index][0]];
            let base = ask_all(exact, batch, other).as_secs_f64() / f64::from(other);
            let this = ask_all(*detector, batch, own).as_secs_f64() / f64::from(own);
            ratios[index].push(this / base);
            seconds[index].push(base / batch.len() as f64);
        }
    }
    let result = |index: usize| {
        let (ratio, exact) = (median(&mut ratios[index])?, median(&mut seconds[index])?);
        Some(Timing {
            cases: batches[index].len(),
            ratio,
            exact,
        })
    };
    (0..detectors.len()).map(result).collect()
}

fn repeats(detector: AnyDetector, batch: &[&Encounter]) -> u32 {
    if batch.is_empty() {
        return 1;
    }
    let once = ask_all(detector, batch, 1).max(Duration::from_nanos(50));
    (MIN_BATCH.as_secs_f64() / once.as_secs_f64()).ceil() as u32
}

/// Processor time of this thread for `repeats` passes over the batch.
fn ask_all(detector: AnyDetector, batch: &[&Encounter], repeats: u32) -> Duration {
    let begun = ThreadTime::now();
    for _ in 0..repeats {
        for encounter in batch {
            black_box(black_box(encounter).first_contact(&detector));
        }
    }
    begun.elapsed()
}
