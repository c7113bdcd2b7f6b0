//! The manifest of a run: program, compiler, machine, command, random numbers, and time taken.

use std::{env, fs};

use anyhow::{Error, Result};
use carom::{Scene, engine::TileCounters};
use carom_methods::Method;
use serde::Serialize;

use crate::{
    clock::Instant,
    command_line::given,
    output::{Folder, MANIFEST, json},
};

/// Revision of the sources from which the program was built, if that was in a repository.
pub const REVISION: Option<&str> = option_env!("CAROM_REVISION");

/// The compiler that built the program.
pub const RUSTC: &str = env!("CAROM_RUSTC_VERSION");

/// Version of the program, revision of its sources, and the compiler that built it.
pub const BUILD: &str = env!("CAROM_BUILD");

/// `manifest.json`.
#[derive(Debug, Clone, Serialize)]
pub struct Manifest {
    program: &'static str,
    version: &'static str,
    /// Revision of the sources from which the program was built, if that was in a repository.
    revision: Option<&'static str>,
    rustc: &'static str,
    processor: String,
    logical_processors: usize,
    /// The command as given.
    command: Vec<String>,
    /// The command with all options.
    again: String,
    /// Detector and scheduler in words, one for each scene that is not computed by default.
    methods: Vec<String>,
    streams: Vec<Stream>,
    /// The run from which this one starts.
    #[serde(skip_serializing_if = "Option::is_none")]
    parent: Option<serde_json::Value>,
    /// Wall time since the run was started or last resumed (seconds).
    wall_seconds: Option<f64>,
    /// Processor time of the whole run (seconds).
    cpu_seconds: Option<f64>,
    /// Threads of a single run, and counts of its work in tiles since it was started or last
    /// resumed.
    #[serde(skip_serializing_if = "Option::is_none")]
    tiles: Option<TileSummary>,
    /// Files that the run has written so far, with paths relative to the folder.
    #[serde(skip_serializing_if = "Option::is_none")]
    files: Option<Vec<String>>,
    /// The error that ended the run.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
    /// True if the run has ended; if false, the folder holds partial results.
    complete: bool,
    #[serde(skip)]
    begun: Instant,
}

/// Work of a run in tiles.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TileSummary {
    threads: usize,
    windows: u64,
    tiles: u64,
    tiles_repeated: u64,
    contacts: u64,
    contacts_computed: u64,
    windows_in_order: u64,
}

impl TileSummary {
    /// The work of a run on so many threads.
    pub fn new(threads: usize, counters: &TileCounters) -> Self {
        Self {
            threads,
            windows: counters.windows,
            tiles: counters.tiles,
            tiles_repeated: counters.repeated,
            contacts: counters.contacts,
            contacts_computed: counters.computed,
            windows_in_order: counters.refused,
        }
    }
}

/// One stream of random numbers.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Stream {
    purpose: &'static str,
    generator: &'static str,
    seed: u64,
    #[serde(rename = "stream")]
    number: u128,
}

impl Manifest {
    /// Writes the manifest of a run that begins now.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write_new(folder: &Folder, again: &str, scenes: &[&Scene]) -> Result<Self> {
        Self::write_from(folder, again, scenes, None)
    }

    /// Writes the manifest of a run that begins now, from the state of another run.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write_from(
        folder: &Folder,
        again: &str,
        scenes: &[&Scene],
        parent: Option<serde_json::Value>,
    ) -> Result<Self> {
        let mut manifest = Self::new(again, scenes, parent);
        manifest.write(folder)?;
        Ok(manifest)
    }

    /// The manifest of a run that begins now and writes nothing until its end.
    pub fn new(again: &str, scenes: &[&Scene], parent: Option<serde_json::Value>) -> Self {
        Self {
            program: "carom",
            version: carom::VERSION,
            revision: REVISION,
            rustc: RUSTC,
            processor: processor(),
            logical_processors: std::thread::available_parallelism().map_or(1, usize::from),
            command: given()
                .map(|word| word.to_string_lossy().into_owned())
                .collect(),
            again: again.to_owned(),
            methods: methods(scenes),
            streams: scenes.iter().flat_map(|scene| streams(scene)).collect(),
            parent,
            wall_seconds: None,
            cpu_seconds: None,
            tiles: None,
            files: None,
            error: None,
            complete: false,
            begun: Instant::now(),
        }
    }

    /// The text of the manifest of a run with these files.
    ///
    /// # Errors
    /// It cannot be encoded.
    pub fn text_with(mut self, files: Vec<String>) -> Result<String> {
        self.files = Some(files);
        json(&self)
    }

    /// Writes the manifest of a part of this run in a folder of its own, which `again` repeats.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write_part(&self, folder: &Folder, again: &str) -> Result<Self> {
        let mut manifest = Self {
            again: again.to_owned(),
            ..self.clone()
        };
        manifest.write(folder)?;
        Ok(manifest)
    }

    /// Records the work in tiles.
    pub fn set_tiles(&mut self, work: TileSummary) {
        self.tiles = Some(work);
    }

    /// Returns true if the folder holds a run that has ended.
    pub fn is_complete(folder: &Folder) -> bool {
        let manifest = folder
            .read(MANIFEST)
            .ok()
            .and_then(|text| serde_json::from_str(&text).ok());
        manifest.is_some_and(|manifest: serde_json::Value| manifest["complete"] == true)
    }

    /// Records that the run has ended, with the processor time of its run phase, summed over all
    /// threads (seconds).
    ///
    /// # Errors
    /// The manifest cannot be written.
    pub fn complete(mut self, folder: &Folder, cpu_seconds: f64) -> Result<()> {
        self.wall_seconds = Some(self.begun.elapsed().as_secs_f64());
        self.cpu_seconds = Some(cpu_seconds);
        self.complete = true;
        self.end(folder)
    }

    /// Records that the run has ended with an error, with the processor time until then (seconds).
    ///
    /// # Errors
    /// The manifest cannot be written.
    pub fn fail(mut self, folder: &Folder, cpu_seconds: f64, error: &Error) -> Result<()> {
        self.wall_seconds = Some(self.begun.elapsed().as_secs_f64());
        self.cpu_seconds = Some(cpu_seconds);
        self.error = Some(format!("{error:#}"));
        self.end(folder)
    }

    fn write(&mut self, folder: &Folder) -> Result<()> {
        folder.file(MANIFEST)?;
        self.files = folder.written();
        if self.files.is_some() {
            // On disk before the list of files is removed.
            folder.write_lasting_json(MANIFEST, self)
        } else {
            folder.write_json(MANIFEST, self)
        }
    }

    /// Writes the manifest for the last time, with all files.
    fn end(mut self, folder: &Folder) -> Result<()> {
        folder.check_holder()?;
        self.write(folder)?;
        if self.files.is_some() {
            folder.end_list()
        } else {
            Ok(())
        }
    }
}

/// The methods that are not the default.
fn methods(scenes: &[&Scene]) -> Vec<String> {
    let methods = scenes
        .iter()
        .filter_map(|scene| Method::try_from(&scene.method).ok());
    methods
        .filter(|method| *method != Method::default())
        .map(|method| method.to_string())
        .collect()
}

/// The streams that a scene draws from: number 16 × replica + purpose, see
/// [`carom::engine::RandomStream`].
fn streams(scene: &Scene) -> [Stream; 5] {
    use carom::engine::RandomStream;
    [
        ("placement", RandomStream::Placement),
        ("velocities", RandomStream::Velocities),
        ("growth", RandomStream::Growth),
        ("sizes", RandomStream::Sizes),
        ("walls", RandomStream::Walls),
    ]
    .map(|(name, purpose)| Stream {
        purpose: name,
        generator: "PCG-64",
        seed: scene.bounds.seed,
        number: 16 * u128::from(scene.bounds.replica) + purpose as u128,
    })
}

/// Name of the processor, where the system provides it.
fn processor() -> String {
    let known = fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        line.split_once(':').map(|(_, name)| name.trim().to_owned())
    });
    known.unwrap_or_else(|| env::consts::ARCH.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::Existing;

    #[test]
    fn a_manifest_is_incomplete_until_the_run_ends() {
        let root = tempfile::tempdir().unwrap();
        let folder = Folder::create(root.path(), Existing::Refuse).unwrap();
        let mut scene = Scene::default();
        (scene.bounds.seed, scene.bounds.replica) = (u64::MAX, 3);
        let read = || -> serde_json::Value {
            serde_json::from_str(&fs::read_to_string(root.path().join(MANIFEST)).unwrap()).unwrap()
        };
        let manifest = Manifest::write_new(&folder, "carom run", &[&scene]).unwrap();
        assert_eq!(read()["complete"], false);
        assert!(!Manifest::is_complete(&folder));
        manifest.complete(&folder, 1.5).unwrap();
        assert!(Manifest::is_complete(&folder));
        let written = read();
        assert_eq!(written["complete"], true);
        assert!(
            BUILD.starts_with(carom::VERSION) && BUILD.contains(RUSTC),
            "{BUILD}"
        );
        assert_eq!(written["streams"][0]["seed"], u64::MAX);
        assert_eq!(written["streams"][1]["stream"], 49);
        assert_eq!(written["cpu_seconds"], 1.5);
        assert!(written["wall_seconds"].as_f64().unwrap() >= 0.0);
    }
}
