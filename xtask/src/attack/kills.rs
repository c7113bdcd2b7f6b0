//! Signals at random moments: after any of them a run continues to the bytes of an undisturbed one.

use std::time::Duration;

use anyhow::Result;
use serde::{Deserialize, Serialize};

use super::{
    campaign::{Attack, report},
    process::LIMIT,
    targets::{References, Target, TargetPlace, target},
};
use crate::fuzz::{
    random::{FuzzDraw, case_seed},
    subject::{Failure, Report, Subject, read_toml, write_toml},
};

/// The attack.
#[derive(Debug, Default)]
pub struct Kills {
    /// Undisturbed runs.
    pub references: References,
}

/// A target that is disturbed some times, and then runs to its end.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct KillCase {
    target: String,
    strokes: Vec<Stroke>,
}

/// Signals to one process.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Stroke {
    /// Names of the signals.
    signals: Vec<String>,
    /// Moment of the first, as a share of the duration of the undisturbed run.
    moment: f64,
    /// Time between two signals (seconds).
    pause: f64,
}

/// What is sent, and with which weight.
const SIGNALS: [(&[&str], u32); 8] = [
    (&["KILL"], 8),
    (&["TERM"], 1),
    (&["INT"], 1),
    (&["INT", "INT"], 2),
    (&["HUP"], 2),
    (&["STOP", "CONT"], 1),
    (&["STOP", "KILL"], 1),
    (&["TERM", "KILL"], 2),
];

/// Targets with their weights.
const WEIGHTS: [(&str, u32); 10] = [
    ("run", 20),
    ("sweep", 20),
    ("shard", 6),
    ("merge of sweeps", 8),
    ("merge of runs", 8),
    ("tiles", 2),
    ("growth", 4),
    ("billiard", 4),
    ("brownian", 3),
    ("trade", 1),
];

/// One of several values with weights.
pub fn weighted<T: Copy>(draw: &mut FuzzDraw, choices: &[(T, u32)]) -> T {
    let sum: u32 = choices.iter().map(|(_, weight)| weight).sum();
    let mut left = draw.index(sum as usize) as u32;
    for (choice, weight) in choices {
        if left < *weight {
            return *choice;
        }
        left -= weight;
    }
    choices[0].0
}

impl KillCase {
    fn draw(draw: &mut FuzzDraw) -> Self {
        let target = weighted(draw, &WEIGHTS).to_owned();
        let stroke = |draw: &mut FuzzDraw| {
            let moment = draw.between(0.0, 1.0);
            Stroke {
                signals: weighted(draw, &SIGNALS)
                    .iter()
                    .map(|&name| name.to_owned())
                    .collect(),
                // Beginnings are short, and as much happens in them.
                moment: if draw.happens(0.3) {
                    0.2 * moment
                } else {
                    1.05 * moment
                },
                pause: draw.between(0.0, 0.05),
            }
        };
        let strokes = (0..draw.integer(1, 5)).map(|_| stroke(draw)).collect();
        Self { target, strokes }
    }
}

impl Kills {
    fn attack(&self, case: &KillCase) -> Result<Option<Failure>> {
        let target = target(&case.target)?;
        let duration = self.references.reference(target)?.duration;
        let place = self.references.place(target)?;
        for (index, stroke) in case.strokes.iter().enumerate() {
            let words = if index == 0 {
                target.start
            } else {
                target.again
            };
            if let Some(failure) = strike(&place, target, words, stroke, duration)? {
                return Ok(Some(failure));
            }
        }
        let difference = self.references.finish(target, &place)?;
        Ok(difference.map(|words| Failure::new(target.name, words)))
    }
}

/// Disturbs one process. A failure is an end that is not orderly.
fn strike(
    place: &TargetPlace,
    target: &Target,
    words: &str,
    stroke: &Stroke,
    duration: Duration,
) -> Result<Option<Failure>> {
    let mut process = place.start(words, "said")?;
    let mut pause = duration.mul_f64(stroke.moment);
    for signal in &stroke.signals {
        if process.wait_for(pause)?.is_some() {
            break;
        }
        process.signal(signal);
        pause = Duration::from_secs_f64(stroke.pause);
    }
    let ended = process.end(LIMIT)?;
    // A target that has nothing to resume is started anew by the last process.
    let failure = || {
        Failure::new(
            target.name,
            format!("after {:?} it ends with {ended}", stroke.signals),
        )
    };
    Ok((!ended.is_orderly() || ended.code == Some(1)).then(failure))
}

impl Subject for Kills {
    type Case = KillCase;
    const COMMAND: &'static str = "attack --kinds";
    const NAME: &'static str = "kills";
    const TIME_LIMIT: u64 = 600;

    fn draw(&self, seed: u64) -> KillCase {
        KillCase::draw(&mut FuzzDraw::new(seed))
    }

    fn check(&self, case: &KillCase) -> Report {
        report(self.attack(case))
    }

    fn simpler(&self, case: &KillCase) -> Vec<KillCase> {
        let without = |index: usize| {
            let mut less = case.clone();
            less.strokes.remove(index);
            less
        };
        if case.strokes.len() < 2 {
            vec![]
        } else {
            (0..case.strokes.len()).map(without).collect()
        }
    }

    fn write(&self, case: &KillCase) -> (String, Vec<u8>) {
        write_toml(case)
    }

    fn read(&self, ending: &str, bytes: &[u8]) -> Result<KillCase> {
        read_toml(ending, bytes)
    }
}

impl Attack for Kills {
    const FULL: u64 = 630;

    fn cases(&self, seed: u64, count: u64) -> Result<Vec<KillCase>> {
        let mut cases: Vec<KillCase> = Vec::new();
        let mut strokes = 0;
        for index in 0..count {
            if strokes >= count {
                break;
            }
            let case = self.draw(case_seed(seed, index));
            strokes += case.strokes.len() as u64;
            cases.push(case);
        }
        Ok(cases)
    }

    fn row(&self, case: &KillCase) -> (String, u64) {
        (case.target.clone(), case.strokes.len() as u64)
    }
}
