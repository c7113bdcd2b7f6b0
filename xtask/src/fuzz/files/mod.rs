//! Mutated scene files, encounter files and checkpoints: each is refused by name, or runs without
//! panic, hang, NaN and overlap.

pub mod checkpoints;
pub mod encounter_files;
pub mod mutate;
pub mod scene_files;

use anyhow::{Result, bail};

use super::{
    random::Draw,
    subject::{Report, Subject},
};

/// The fuzzer of the readers.
#[derive(Debug, Clone, Copy, Default)]
pub struct Mutations;

/// Kind of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A scene, in TOML.
    Scene,
    /// Encounters, in CSV.
    Encounters,
    /// A checkpoint file: header, checksum and body.
    Checkpoint,
    /// The body of a checkpoint, which receives a header with the correct checksum.
    Body,
}

impl Kind {
    /// File name extension.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Scene => "toml",
            Self::Encounters => "csv",
            Self::Checkpoint => "checkpoint",
            Self::Body => "body",
        }
    }
}

/// A file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Case {
    /// Its kind.
    pub kind: Kind,
    /// Its content.
    pub bytes: Vec<u8>,
}

impl Subject for Mutations {
    type Case = Case;
    const NAME: &'static str = "files";
    const TIME_LIMIT: u64 = 20;

    fn draw(&self, seed: u64) -> Case {
        let draw = &mut Draw::new(seed);
        let kind = draw.one_of(&[
            Kind::Scene,
            Kind::Scene,
            Kind::Scene,
            Kind::Encounters,
            Kind::Checkpoint,
            Kind::Body,
            Kind::Body,
        ]);
        let bytes = match kind {
            Kind::Scene => scene_files::draw(draw),
            Kind::Encounters => encounter_files::draw(draw),
            Kind::Checkpoint => checkpoints::draw_file(draw),
            Kind::Body => checkpoints::draw_body(draw),
        };
        Case { kind, bytes }
    }

    fn check(&self, case: &Case) -> Report {
        let mut report = Report::default();
        match case.kind {
            Kind::Scene => scene_files::check(&case.bytes, &mut report),
            Kind::Encounters => encounter_files::check(&case.bytes, &mut report),
            Kind::Checkpoint => checkpoints::check_file(&case.bytes, &mut report),
            Kind::Body => checkpoints::check_body(&case.bytes, &mut report),
        }
        report
    }

    fn simpler(&self, case: &Case) -> Vec<Case> {
        let text = matches!(case.kind, Kind::Scene | Kind::Encounters);
        let smaller = if text {
            mutate::with_less_text(&case.bytes)
        } else {
            vec![]
        };
        smaller
            .into_iter()
            .map(|bytes| Case {
                kind: case.kind,
                bytes,
            })
            .collect()
    }

    fn write(&self, case: &Case) -> (String, Vec<u8>) {
        (case.kind.ending().to_owned(), case.bytes.clone())
    }

    fn read(&self, ending: &str, bytes: &[u8]) -> Result<Case> {
        let kinds = [Kind::Scene, Kind::Encounters, Kind::Checkpoint, Kind::Body];
        match kinds.into_iter().find(|kind| kind.ending() == ending) {
            Some(kind) => Ok(Case {
                kind,
                bytes: bytes.to_vec(),
            }),
            None => bail!("no fuzzed file ends with {ending:?}"),
        }
    }
}

#[cfg(test)]
mod tests;
