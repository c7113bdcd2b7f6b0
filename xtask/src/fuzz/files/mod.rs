//! Mutated scene files, encounter files and checkpoints: each is refused by name, or runs without
//! panic, hang, NaN and overlap.

pub mod checkpoints;
pub mod encounter_files;
pub mod mutate;
pub mod scene_files;

use anyhow::{Result, bail};

use super::{
    random::FuzzDraw,
    subject::{Report, Subject},
};

/// The fuzzer of the readers.
#[derive(Debug, Clone, Copy, Default)]
pub struct Mutations;

/// Kind of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileKind {
    /// A scene, in TOML.
    Scene,
    /// Encounters, in CSV.
    Encounters,
    /// A checkpoint file: header, checksum and body.
    Checkpoint,
    /// The body of a checkpoint, which receives a header with the correct checksum.
    Body,
}

impl FileKind {
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
pub struct FileCase {
    /// Its kind.
    pub kind: FileKind,
    /// Its content.
    pub bytes: Vec<u8>,
}

impl Subject for Mutations {
    type Case = FileCase;
    const NAME: &'static str = "files";
    const TIME_LIMIT: u64 = 20;

    fn draw(&self, seed: u64) -> FileCase {
        let draw = &mut FuzzDraw::new(seed);
        let kind = draw.one_of(&[
            FileKind::Scene,
            FileKind::Scene,
            FileKind::Scene,
            FileKind::Encounters,
            FileKind::Checkpoint,
            FileKind::Body,
            FileKind::Body,
        ]);
        let bytes = match kind {
            FileKind::Scene => scene_files::draw(draw),
            FileKind::Encounters => encounter_files::draw(draw),
            FileKind::Checkpoint => checkpoints::draw_file(draw),
            FileKind::Body => checkpoints::draw_body(draw),
        };
        FileCase { kind, bytes }
    }

    fn check(&self, case: &FileCase) -> Report {
        let mut report = Report::default();
        match case.kind {
            FileKind::Scene => scene_files::check(&case.bytes, &mut report),
            FileKind::Encounters => encounter_files::check(&case.bytes, &mut report),
            FileKind::Checkpoint => checkpoints::check_file(&case.bytes, &mut report),
            FileKind::Body => checkpoints::check_body(&case.bytes, &mut report),
        }
        report
    }

    fn simpler(&self, case: &FileCase) -> Vec<FileCase> {
        let text = matches!(case.kind, FileKind::Scene | FileKind::Encounters);
        let smaller = if text {
            mutate::with_less_text(&case.bytes)
        } else {
            vec![]
        };
        smaller
            .into_iter()
            .map(|bytes| FileCase {
                kind: case.kind,
                bytes,
            })
            .collect()
    }

    fn write(&self, case: &FileCase) -> (String, Vec<u8>) {
        (case.kind.ending().to_owned(), case.bytes.clone())
    }

    fn read(&self, ending: &str, bytes: &[u8]) -> Result<FileCase> {
        let kinds = [
            FileKind::Scene,
            FileKind::Encounters,
            FileKind::Checkpoint,
            FileKind::Body,
        ];
        match kinds.into_iter().find(|kind| kind.ending() == ending) {
            Some(kind) => Ok(FileCase {
                kind,
                bytes: bytes.to_vec(),
            }),
            None => bail!("no fuzzed file ends with {ending:?}"),
        }
    }
}

#[cfg(test)]
mod tests;
