//! The results of a card: its study is swept, or its finished sweep is continued, and the folder is
//! read.

use std::{
    fs,
    path::{Path, PathBuf},
    time::Duration,
};

use anyhow::{Context, Result, anyhow, ensure};
use carom_runs::{
    manifest::REVISION,
    output::{Destination, MANIFEST, Resumption},
    resumable::Choices,
    whole_file::write_whole,
};
use carom_sweeps::{
    expect::ExpectationAnswer,
    several, slurm,
    summary::{PointSummary, SweepSummary},
    sweep::{How, SweepOptions},
};
use serde_json::Value;

use super::cards::Card;

/// Time between two checkpoints of a replica: the most that is lost by an interruption.
const CHECKPOINT_EVERY: Duration = Duration::from_secs(30);

/// The results of one card.
#[derive(Debug)]
pub struct CardResults {
    /// The card.
    pub card: Card,
    /// What its sweep has found; `None` if it ended with an error.
    pub summary: Option<SweepSummary>,
    /// What does not hold, or the error; empty if all holds.
    pub faults: Vec<String>,
    /// Revision of the program that began the sweep.
    pub revision: String,
}

/// How results are made.
#[derive(Debug, Clone, Copy)]
pub struct Making {
    /// Whether the short forms are run.
    pub is_quick: bool,
    /// Whether finished results are made anew.
    pub force: bool,
    /// Number of threads; default: one for each processor.
    pub threads: Option<u16>,
}

impl CardResults {
    /// Sweeps the study of a card into its folder in the site, or continues what is there.
    ///
    /// # Errors
    /// A file cannot be written, or a signal has been received. An error of the sweep itself is
    /// part of the results.
    pub fn make(card: &Card, site: &Path, making: Making) -> Result<Self> {
        let folder = card.results(site, making.is_quick);
        let study = site
            .join("studies")
            .join(&card.study)
            .with_extension("toml");
        write(&study, card.example()?.text)?;
        let revision = begun_by(&folder, making.force)?;
        let ended = several::run(&options(study, &folder, making));
        match ended {
            Err(error) if is_interruption(&error) => Err(error),
            Err(error) => Ok(Self::failed(card, &error, revision)),
            Ok(_) => Ok(Self::read(card, &folder, revision)),
        }
    }

    /// Reads the results of a card from the folder of its sweep.
    pub fn read(card: &Card, folder: &Path, revision: String) -> Self {
        let read = SweepSummary::read(folder).map(|summary| {
            let mut faults = summary.faults();
            if headline(card, &summary).is_none() {
                faults.push(format!(
                    "no judged result has '{}' in its quantity and '{}' in its point",
                    card.quantity, card.point
                ));
            }
            Self {
                card: card.clone(),
                summary: Some(summary),
                faults,
                revision: revision.clone(),
            }
        });
        read.unwrap_or_else(|error| Self::failed(card, &error, revision))
    }

    fn failed(card: &Card, error: &anyhow::Error, revision: String) -> Self {
        Self {
            card: card.clone(),
            summary: None,
            faults: vec![format!("{error:#}")],
            revision,
        }
    }

    /// Whether all that is expected holds.
    pub fn passed(&self) -> bool {
        self.faults.is_empty()
    }

    /// The result that the card shows, with its point.
    pub fn headline(&self) -> Option<(&PointSummary, &ExpectationAnswer)> {
        headline(&self.card, self.summary.as_ref()?)
    }

    /// How many of the judged results are as expected, in words.
    pub fn verdict(&self) -> String {
        let Some(summary) = &self.summary else {
            return "ended with an error".to_owned();
        };
        let all = summary.judged().count();
        let good = summary.judged().filter(|(_, answer)| answer.passed).count();
        if self.passed() {
            format!("{good} of {all} as expected")
        } else {
            format!("FAILED: {good} of {all} as expected")
        }
    }

    /// Processor time in words.
    pub fn processor_time(&self) -> String {
        let seconds = self.summary.as_ref().map_or(0.0, SweepSummary::cpu_seconds);
        match seconds {
            0.0 => "no contacts".to_owned(),
            seconds if seconds < 0.1 => "processor time below 0.1 s".to_owned(),
            seconds if seconds < 10.0 => format!("{seconds:.1} s of processor time"),
            seconds if seconds < 600.0 => format!("{seconds:.0} s of processor time"),
            seconds => format!("{:.0} min of processor time", seconds / 60.0),
        }
    }
}

/// The first judged result whose quantity and point have the words of the card.
fn headline<'a>(
    card: &Card,
    summary: &'a SweepSummary,
) -> Option<(&'a PointSummary, &'a ExpectationAnswer)> {
    summary.judged().find(|(point, answer)| {
        answer.quantity.contains(&card.quantity) && point.label.contains(&card.point)
    })
}

/// Whether a signal ended the sweep.
fn is_interruption(error: &anyhow::Error) -> bool {
    error
        .chain()
        .any(<dyn std::error::Error>::is::<carom_runs::interruption::Interrupted>)
}

fn options(study: PathBuf, folder: &Path, making: Making) -> SweepOptions {
    let destination = Destination {
        out: Some(folder.to_owned()),
        force: making.force,
    };
    let resumption = Resumption {
        destination,
        resume: false,
    };
    SweepOptions {
        studies: vec![study],
        quick: making.is_quick,
        how: How {
            choices: Choices {
                resumption,
                checkpoint_every: CHECKPOINT_EVERY,
            },
            replicas: None,
            threads: making.threads,
            shard: None,
            slurm: slurm::SlurmOptions::default(),
        },
    }
}

/// Writes a file with the folders that it needs.
///
/// # Errors
/// It cannot be written.
pub fn write(path: &Path, text: &str) -> Result<()> {
    let parent = path.parent().context("a file needs a folder")?;
    fs::create_dir_all(parent).with_context(|| format!("cannot create {}", parent.display()))?;
    write_whole(path, text.as_bytes())
}

/// The revision that began the sweep in a folder, kept in a file beside it: continuing a sweep
/// writes its manifest anew, but not its replicas.
fn begun_by(folder: &Path, force: bool) -> Result<String> {
    let mut name = folder
        .file_name()
        .ok_or_else(|| anyhow!("{} has no name", folder.display()))?
        .to_owned();
    name.push(".revision");
    let file = folder.with_file_name(name);
    let own = REVISION.unwrap_or("unknown").to_owned();
    let revision = if force || !folder.is_dir() {
        own
    } else if let Ok(kept) = fs::read_to_string(&file) {
        kept.trim().to_owned()
    } else {
        of_manifest(folder).unwrap_or(own)
    };
    ensure!(!revision.is_empty(), "{} is empty", file.display());
    write(&file, &format!("{revision}\n"))?;
    Ok(revision)
}

fn of_manifest(folder: &Path) -> Option<String> {
    let text = fs::read_to_string(folder.join(MANIFEST)).ok()?;
    let manifest: Value = serde_json::from_str(&text).ok()?;
    manifest["revision"].as_str().map(str::to_owned)
}
