//! Two processes in one folder: on one machine, where one of them is refused, and as on two
//! machines without a common lock, where neither ends with success beside wrong bytes.

use std::{fs, time::Duration};

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};

use super::{
    campaign::{Attack, report},
    folder,
    preload::Library,
    process::{LIMIT, Process, ProcessEnd},
    targets::{OUT, References, Target, TargetPlace, target},
};
use crate::fuzz::{
    random::{FuzzDraw, case_seed},
    subject::{Failure, Report, Subject, read_toml, write_toml},
};

/// The attack.
#[derive(Debug)]
pub struct Machines {
    /// Undisturbed runs.
    pub references: References,
    /// The library that changes locks.
    pub library: Library,
}

/// Two processes in one folder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MachinesCase {
    scenario: Scenario,
    locks: Locks,
    /// Time between the starts of both, as a share of the duration of an undisturbed run.
    offset: f64,
    /// Moment at which an earlier process was killed, as a share of that duration; for a resumed
    /// run.
    killed: f64,
}

/// What the processes do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Scenario {
    /// Both start one run in a new folder.
    Run,
    /// Both start a run in a new folder, with two seeds.
    Seeds,
    /// Both resume one run.
    Resume,
    /// Both do one sweep.
    Sweep,
    /// Both do one shard.
    Shard,
    /// Both fly one billiard.
    Billiard,
    /// The second merges runs into the folder of the first, which still runs.
    Merge,
}

/// What becomes of file locks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "UPPERCASE")]
enum Locks {
    /// They are those of the system.
    Real,
    /// The system has none: error `ENOLCK`.
    Enolck,
    /// The system has none: error `ENOSYS`.
    Enosys,
    /// Each process gets every lock.
    Granted,
}

impl Locks {
    fn name(self) -> &'static str {
        match self {
            Self::Real => "REAL",
            Self::Enolck => "ENOLCK",
            Self::Enosys => "ENOSYS",
            Self::Granted => "GRANTED",
        }
    }
}

impl Scenario {
    /// What is drawn from. Runs append to their files, which suffers most.
    const DRAWN: [Self; 9] = [
        Self::Run,
        Self::Run,
        Self::Seeds,
        Self::Resume,
        Self::Resume,
        Self::Sweep,
        Self::Shard,
        Self::Billiard,
        Self::Merge,
    ];

    fn target(self) -> Result<&'static Target> {
        target(match self {
            Self::Run | Self::Resume | Self::Merge => "run",
            Self::Seeds => "page",
            Self::Sweep => "sweep",
            Self::Shard => "shard",
            Self::Billiard => "billiard",
        })
    }

    /// Words of the first and of the second process.
    fn words(self) -> Result<[String; 2]> {
        let target = self.target()?;
        Ok(match self {
            Self::Resume => [target.again.to_owned(), target.again.to_owned()],
            Self::Seeds => [
                target.start.to_owned(),
                format!("{} --seed 9", target.start),
            ],
            Self::Merge => [
                target.start.to_owned(),
                "merge run-1 run-2 --out out --force".to_owned(),
            ],
            _ => [target.start.to_owned(), target.start.to_owned()],
        })
    }
}

impl Machines {
    fn attack(&self, case: &MachinesCase) -> Result<Option<Failure>> {
        let scenario = case.scenario;
        let (goal, words) = (scenario.target()?, scenario.words()?);
        let duration = self.references.reference(goal)?.duration;
        let place = self.references.place(goal)?;
        match scenario {
            Scenario::Resume => {
                let mut process = place.start(goal.start, "said")?;
                process.wait_for(duration.mul_f64(case.killed))?;
                process.signal("KILL");
                process.end(LIMIT)?;
            }
            Scenario::Merge => {
                for (number, seed) in [(1, 3), (2, 9)] {
                    place.complete(&format!("run short.toml --seed {seed} --out run-{number}"))?;
                }
            }
            _ => {}
        }
        let ended = self.both(case, &place, &words, duration)?;
        self.judge(case, &place, goal, &ended)
    }

    /// Runs both processes to their ends.
    fn both(
        &self,
        case: &MachinesCase,
        place: &TargetPlace,
        words: &[String; 2],
        duration: Duration,
    ) -> Result<[ProcessEnd; 2]> {
        let start = |words: &str, said: &str| {
            let mut command = place.command(words);
            if case.locks != Locks::Real {
                self.library
                    .change_locks(&mut command, &place.path(""), case.locks.name());
            }
            Process::start(command, place.path(said))
        };
        let mut first = start(&words[0], "said-1")?;
        let offset = duration.mul_f64(case.offset);
        if case.scenario == Scenario::Merge {
            // The folder is that of a run that runs.
            let begun = std::time::Instant::now();
            while !place.path(OUT).join("checkpoint").exists() && begun.elapsed() < LIMIT {
                if first.wait_for(Duration::from_millis(1))?.is_some() {
                    break;
                }
            }
        }
        first.wait_for(offset)?;
        let second = start(&words[1], "said-2")?;
        Ok([first.end(LIMIT)?, second.end(LIMIT)?])
    }

    /// Success beside wrong bytes is a failure, and so are two successes where one process must be
    /// refused, and a folder that cannot be finished.
    fn judge(
        &self,
        case: &MachinesCase,
        place: &TargetPlace,
        goal: &Target,
        ended: &[ProcessEnd; 2],
    ) -> Result<Option<Failure>> {
        let failure = |kind: &str, words: String| Ok(Some(Failure::new(kind, words)));
        let ends = format!("{}; {}", ended[0], ended[1]);
        if ended.iter().any(|ended| !ended.is_orderly()) {
            return failure("end", ends);
        }
        let successes: Vec<usize> = (0..2)
            .filter(|&index| ended[index].code == Some(0))
            .collect();
        match (case.scenario, &successes[..]) {
            // One replaces the other without being asked.
            (Scenario::Seeds, [0, 1]) => return failure("both succeed", ends),
            (Scenario::Seeds, [1]) => {
                let own = self.references.place(goal)?;
                own.complete(&format!("{} --seed 9", goal.start))?;
                let [found, expected] =
                    [place, &own].map(|place| folder::contents(&place.path(OUT)));
                if let Some(words) = folder::difference(&found?, &expected?) {
                    return failure("wrong bytes", format!("{words}; {ends}"));
                }
                return Ok(None);
            }
            // The run had ended before the merge began, or the merge wrote into it.
            (Scenario::Merge, [0, 1]) => {
                let is_merged = fs::read_to_string(place.path(OUT).join("manifest.json"))
                    .context("the folder has no manifest")?
                    .contains("merge");
                return if is_merged {
                    Ok(None)
                } else {
                    failure("two writers", ends)
                };
            }
            (Scenario::Merge, [1]) => return failure("the run is destroyed", ends),
            _ => {}
        }
        if successes.is_empty() {
            return self.judge_unfinished(place, goal, &ends);
        }
        match self.references.compare(goal, place)? {
            Some(words) => failure("wrong bytes", format!("{words}; {ends}")),
            None => Ok(None),
        }
    }

    /// What no process has finished need only be refused or finished.
    fn judge_unfinished(
        &self,
        place: &TargetPlace,
        goal: &Target,
        ends: &str,
    ) -> Result<Option<Failure>> {
        let last = place.run(goal.again)?;
        match last.code {
            Some(0) => {
                let fault = self.references.compare(goal, place)?;
                let failure = |words: String| {
                    Failure::new("wrong bytes after a resume", format!("{words}; {ends}"))
                };
                Ok(fault.map(failure))
            }
            Some(2) => Ok(None),
            _ => Ok(Some(Failure::new("end", format!("{ends}; {last}")))),
        }
    }
}

impl Subject for Machines {
    type Case = MachinesCase;
    const COMMAND: &'static str = "attack --kinds";
    const NAME: &'static str = "machines";
    const TIME_LIMIT: u64 = 600;

    fn draw(&self, seed: u64) -> MachinesCase {
        let draw = &mut FuzzDraw::new(seed);
        let scenario = draw.one_of(&Scenario::DRAWN);
        let locks = match scenario {
            // Without locks the second may well replace the first.
            Scenario::Seeds | Scenario::Merge => Locks::Real,
            _ => draw.one_of(&[Locks::Real, Locks::Enolck, Locks::Enosys, Locks::Granted]),
        };
        let killed = draw.between(0.1, 0.7);
        let left = if scenario == Scenario::Resume {
            1.0 - killed
        } else {
            1.0
        };
        // The first moments decide in a new folder.
        let offset = if draw.happens(0.4) {
            draw.between(0.0, 0.05)
        } else {
            draw.between(0.0, left)
        };
        MachinesCase {
            scenario,
            locks,
            offset,
            killed,
        }
    }

    fn check(&self, case: &MachinesCase) -> Report {
        report(self.attack(case))
    }

    fn simpler(&self, _: &MachinesCase) -> Vec<MachinesCase> {
        vec![]
    }

    fn write(&self, case: &MachinesCase) -> (String, Vec<u8>) {
        write_toml(case)
    }

    fn read(&self, ending: &str, bytes: &[u8]) -> Result<MachinesCase> {
        read_toml(ending, bytes)
    }
}

impl Attack for Machines {
    const FULL: u64 = 400;

    fn cases(&self, seed: u64, count: u64) -> Result<Vec<MachinesCase>> {
        Ok((0..count)
            .map(|index| self.draw(case_seed(seed, index)))
            .collect())
    }

    fn row(&self, case: &MachinesCase) -> (String, u64) {
        let locks = if case.locks == Locks::Real {
            "one machine"
        } else {
            "without a lock"
        };
        (format!("{:?}, {locks}", case.scenario).to_lowercase(), 1)
    }
}
