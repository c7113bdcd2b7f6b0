//! Calls of the file system that fail: the program ends with an error, or its bytes are right; a
//! repeat without the fault gives the bytes of an undisturbed run.

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};

use super::{
    campaign::{Attack, report},
    preload::{Journal, Library},
    process::LIMIT,
    process::Process,
    targets::{References, Target, target},
};
use crate::fuzz::{
    random::{FuzzDraw, case_seed},
    subject::{Failure, Report, Subject, read_toml, write_toml},
};

/// The attack.
#[derive(Debug)]
pub struct Faults {
    /// Undisturbed runs.
    pub references: References,
    /// The library that makes calls fail.
    pub library: Library,
}

/// A fault of one call.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FaultCase {
    target: String,
    /// Number of the call, from 1.
    call: u64,
    /// Name of the fault.
    fault: String,
}

/// The faults: see `xtask/faults/src/settings.rs`.
const FAULTS: [&str; 4] = ["EIO", "ENOSPC", "EINTR", "SHORT"];

/// Targets whose calls fail.
const TARGETS: [&str; 6] = [
    "run",
    "page",
    "sweep",
    "merge of sweeps",
    "merge of runs",
    "billiard",
];

/// Number of calls of an undisturbed run that can fail.
///
/// # Errors
/// The run fails.
pub fn calls(library: &Library, references: &References, target: &Target) -> Result<u64> {
    let place = references.place(target)?;
    let mut command = place.command(target.start);
    library.disturb(&mut command, &place.path(""), 0, "");
    let ended = Process::start(command, place.path("said"))?.end(LIMIT)?;
    anyhow::ensure!(
        ended.code == Some(0),
        "carom {} with the library: {ended}",
        target.start
    );
    let calls = Journal::read(&place.path(""))?.calls;
    anyhow::ensure!(
        calls > 0,
        "the library records no call of carom {}",
        target.start
    );
    Ok(calls)
}

impl Faults {
    fn attack(&self, case: &FaultCase) -> Result<Option<Failure>> {
        let target = target(&case.target)?;
        let place = self.references.place(target)?;
        let mut command = place.command(target.start);
        self.library
            .disturb(&mut command, &place.path(""), case.call, &case.fault);
        let ended = Process::start(command, place.path("said"))?.end(LIMIT)?;
        let failure = |words: String| Some(Failure::new(target.name, words));
        match ended.code {
            Some(0) => {
                if let Some(words) = self.references.compare(target, &place)? {
                    return Ok(failure(format!("exit code 0 after {case}, but {words}")));
                }
            }
            Some(2) if ended.said.contains("error: ") => {}
            _ => return Ok(failure(format!("after {case} it ends with {ended}"))),
        }
        let difference = self.references.finish(target, &place)?;
        Ok(difference.and_then(|words| failure(format!("repeated after {case}: {words}"))))
    }
}

impl std::fmt::Display for FaultCase {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{} at call {}", self.fault, self.call)
    }
}

impl Subject for Faults {
    type Case = FaultCase;
    const COMMAND: &'static str = "attack --kinds";
    const NAME: &'static str = "faults";
    const TIME_LIMIT: u64 = 600;

    fn draw(&self, seed: u64) -> FaultCase {
        let draw = &mut FuzzDraw::new(seed);
        let [target, fault] = [&TARGETS[..], &FAULTS].map(|names| draw.one_of(names).to_owned());
        FaultCase {
            target,
            call: draw.integer(1, 200) as u64,
            fault,
        }
    }

    fn check(&self, case: &FaultCase) -> Report {
        report(self.attack(case))
    }

    fn simpler(&self, _: &FaultCase) -> Vec<FaultCase> {
        vec![]
    }

    fn write(&self, case: &FaultCase) -> (String, Vec<u8>) {
        write_toml(case)
    }

    fn read(&self, ending: &str, bytes: &[u8]) -> Result<FaultCase> {
        read_toml(ending, bytes)
    }
}

impl Attack for Faults {
    const FULL: u64 = 6000;

    /// Each call of each target with each fault; of a smaller number, the same number for each
    /// target, at equal distances.
    fn cases(&self, seed: u64, count: u64) -> Result<Vec<FaultCase>> {
        let draw = &mut FuzzDraw::new(case_seed(seed, 0));
        let mut cases = Vec::new();
        for name in TARGETS {
            let calls = calls(&self.library, &self.references, target(name)?)
                .with_context(|| format!("the target '{name}'"))?;
            let all = calls * FAULTS.len() as u64;
            let number = if count < Self::FULL {
                all.min(count / TARGETS.len() as u64)
            } else {
                all
            };
            let (step, offset) = (all as f64 / number as f64, draw.between(0.0, 1.0));
            for place in (0..number).map(|index| ((index as f64 + offset) * step) as u64) {
                let fault = FAULTS[(place % FAULTS.len() as u64) as usize].to_owned();
                cases.push(FaultCase {
                    target: name.to_owned(),
                    call: 1 + place / FAULTS.len() as u64,
                    fault,
                });
            }
        }
        Ok(cases)
    }

    fn row(&self, case: &FaultCase) -> (String, u64) {
        (case.target.clone(), 1)
    }
}
