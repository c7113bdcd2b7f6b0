//! Killed, interrupted and extended runs give the same output as uninterrupted ones.

use std::{
    fs,
    path::PathBuf,
    process::{Child, Command, Output, Stdio},
    thread::sleep,
    time::{Duration, Instant},
};

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use tempfile::TempDir;
use xtask::attack::folder::{FileContents, contents, difference};

/// Discs, a rotating tee, a locked cross, a bumper, inelastic contacts by tags; the last sample is
/// off the grid of the others.
const SCENE: &str = r#"
[box]
seed = 3
[[molecule]]
tags = ["tee"]
shape = "tee"
atom_radius = 0.01
atom_mass = 1.0
at = [0.5, 0.5]
[[molecule]]
shape = "cross"
atom_radius = 0.01
atom_mass = 1.0
at = [0.25, 0.5]
rotation = "locked"
[[bumper]]
radius = 0.03
at = [0.1, 0.1]
[[gas]]
tags = ["gas"]
radius = 0.01
mass = 1.0
energy = 1.0
count = 300
[[elasticity.pair]]
between = ["tee", "gas"]
coefficient = 0.99
[run]
until = 60.05
sample_interval = 0.1
observe = ["energy", "collision-rate", "pressure", "overlap", "impulses:tee", "velocities:gas", "correlation:gas",
    "pair-distribution:gas", "contact-density:tee", "thermostat"]
snapshots = "extxyz"
"#;

/// `cargo xtask carom run` of that scene, with checkpoints so frequent that most kills leave one.
const RUN: &[&str] = &[
    "carom",
    "run",
    "scene.toml",
    "--out",
    "out",
    "--checkpoint-every",
    "0.02",
];

/// Tees at a density that no lattice reaches: most of the time is spent on the placement.
const GROWN: &str = r#"
[box]
seed = 3
[start]
relax = 1000
[[gas]]
shape = "tee"
atom_radius = 0.02
atom_mass = 1.0
energy = 1.0
count = 90
[run]
until = 0.5
sample_interval = 0.1
observe = ["energy"]
"#;

/// `cargo xtask carom run` of that scene.
const GROW: &[&str] = &[
    "carom",
    "run",
    "grown.toml",
    "--out",
    "out",
    "--checkpoint-every",
    "0.02",
];

/// A folder with the scene. Paths are relative to it, so that they are equal in all folders.
struct Place(TempDir);

impl Place {
    fn new() -> Self {
        let place = Self(tempfile::tempdir().unwrap());
        place.write("scene.toml", SCENE);
        place.write("grown.toml", GROWN);
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        fs::write(self.path(name), text).unwrap();
    }

    fn command(&self, words: &[&[&str]]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_xtask"));
        command
            .current_dir(self.0.path())
            .args(words.concat())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    }

    fn start(&self, words: &[&[&str]]) -> Child {
        self.command(words).spawn().expect("the program starts")
    }

    /// Exit code and terminal output.
    fn finish(&self, words: &[&[&str]]) -> (Option<i32>, String) {
        said(&self.command(words).output().expect("the program starts"))
    }

    /// Runs to the end without interruption.
    fn complete(self, words: &[&[&str]]) -> Self {
        let (code, said) = self.finish(words);
        assert_eq!(code, Some(0), "{said}");
        self
    }

    /// All output files except the manifests, which describe processes, and the checkpoints;
    /// without speeds.
    fn results(&self) -> FileContents {
        contents(&self.path("out")).unwrap()
    }
}

fn said(output: &Output) -> (Option<i32>, String) {
    let said = [output.stdout.as_slice(), &output.stderr].concat();
    (
        output.status.code(),
        String::from_utf8_lossy(&said).into_owned(),
    )
}

fn assert_same(found: &Place, expected: &Place) {
    assert_eq!(difference(&found.results(), &expected.results()), None);
}

/// Ends the program repeatedly, each time after a random part of a tenth of the duration of the
/// whole run, and resumes it; the last process runs to the end. The output must equal that of an
/// uninterrupted run.
fn check_interrupted(words: &[&str], seed: u64, end: fn(&mut Child)) {
    let begun = Instant::now();
    let straight = Place::new().complete(&[words]);
    let longest = begun.elapsed() / 10;
    let mut random = Pcg64::seed_from_u64(seed);
    let place = Place::new();
    let mut ended = 0;
    for attempt in 0..18 {
        let resume: &[&str] = if attempt == 0 { &[] } else { &["--resume"] };
        let mut child = place.start(&[words, resume]);
        sleep(longest.mul_f64(random.random()));
        if child.try_wait().unwrap().is_none() {
            ended += 1;
        }
        end(&mut child);
        let (code, said) = said(&child.wait_with_output().unwrap());
        assert_ne!(code, Some(2), "{said}");
    }
    assert!(
        ended > 5,
        "the run is long enough to be ended often, but was only {ended} times"
    );
    assert_same(&place.complete(&[words, &["--resume"]]), &straight);
}

fn kill(child: &mut Child) {
    // A process that has just ended cannot be killed.
    let _ = child.kill();
}

#[test]
fn a_scene_killed_at_any_moment_resumes_to_the_bit() {
    check_interrupted(RUN, 1, kill);
}

#[test]
fn a_growth_killed_at_any_moment_resumes_to_the_bit() {
    check_interrupted(GROW, 4, kill);
}

#[cfg(unix)]
#[test]
fn an_interrupted_growth_is_stored_and_another_scene_cannot_continue_it() {
    let place = Place::new();
    let child = place.start(&[GROW]);
    while !place.path("out/growth").exists() {
        sleep(Duration::from_millis(2));
    }
    let told = Command::new("kill")
        .args(["-s", "INT", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(told.success());
    let (code, said) = said(&child.wait_with_output().unwrap());
    assert!(code == Some(130) && said.contains("--resume"), "{said}");
    assert!(!place.path("out/checkpoint").exists());
    let (code, said) = place.finish(&[GROW, &["--seed", "5", "--resume"]]);
    assert!(code == Some(2) && said.contains("another run"), "{said}");
    let place = place.complete(&[GROW, &["--resume"]]);
    assert!(!place.path("out/growth").exists());
    assert_same(&place, &Place::new().complete(&[GROW]));
}

#[test]
fn an_animation_that_starts_late_is_recorded_whenever_the_run_is_killed() {
    check_interrupted(
        &[
            RUN,
            &["--until", "20.05", "--set", "run.animation_from=10.02"],
        ]
        .concat(),
        3,
        kill,
    );
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_writes_a_checkpoint_and_prints_the_command_to_resume() {
    let straight = Place::new().complete(&[RUN]);
    for (signal, code) in [("TERM", 143), ("INT", 130)] {
        let place = Place::new();
        // The interval is so long that only the first checkpoint and that of the signal are taken.
        let seldom: &[&[&str]] = &[&[
            "carom",
            "run",
            "scene.toml",
            "--out",
            "out",
            "--checkpoint-every",
            "1000",
        ]];
        let child = place.start(seldom);
        let grown =
            || fs::metadata(place.path("out/energy.csv")).is_ok_and(|file| file.len() > 2000);
        while !grown() {
            sleep(Duration::from_millis(2));
        }
        let told = Command::new("kill")
            .args(["-s", signal, &child.id().to_string()])
            .status()
            .unwrap();
        assert!(told.success());
        let (found, said) = said(&child.wait_with_output().unwrap());
        assert_eq!(found, Some(code), "{said}");
        assert!(said.contains(&format!("SIG{signal}")), "{said}");
        assert!(
            said.contains(
                "cargo xtask carom run scene.toml --out out --checkpoint-every 1000 --resume"
            ),
            "{said}"
        );
        // The checkpoint is from after the signal, not from the beginning.
        let (code, said) = place.finish(&[RUN, &["--until", "0.1", "--resume"]]);
        assert!(
            code == Some(2) && said.contains("the checkpoint is at"),
            "{said}"
        );
        let place = place.complete(&[RUN, &["--resume"]]);
        assert_same(&place, &straight);
    }
}

/// So many molecules that an epoch takes some seconds, longer than the run, with samples on the
/// way.
const LONG_EPOCH: &str = r#"
[box]
seed = 3
[[gas]]
shape = "tee"
atom_radius = 0.0007
atom_mass = 1.0
energy = 1.0
count = 12000
[run]
until = 0.25
sample_interval = 0.0025
observe = ["energy"]
"#;

#[cfg(unix)]
#[test]
fn a_signal_within_an_epoch_ends_the_run_within_a_second_and_keeps_the_last_checkpoint() {
    let run: &[&str] = &[
        "carom",
        "run",
        "long.toml",
        "--out",
        "out",
        "--checkpoint-every",
        "0",
    ];
    let place = || {
        let place = Place::new();
        place.write("long.toml", LONG_EPOCH);
        place
    };
    let straight = place().complete(&[run]);
    for (signal, code) in [("TERM", 143), ("INT", 130)] {
        let place = place();
        let child = place.start(&[run]);
        let length = |name: &str| fs::metadata(place.path(name)).map_or(0, |file| file.len());
        while length("out/checkpoint") == 0 {
            sleep(Duration::from_millis(2));
        }
        // The first checkpoint has the point at time 0; others follow in the first epoch.
        let first = fs::read_to_string(place.path("out/energy.csv")).unwrap();
        assert_eq!(first.lines().count(), 2, "{first}");
        while length("out/energy.csv") < first.len() as u64 + 100 {
            sleep(Duration::from_millis(2));
        }
        let checkpoint = fs::read(place.path("out/checkpoint")).unwrap();
        let asked = Instant::now();
        let told = Command::new("kill")
            .args(["-s", signal, &child.id().to_string()])
            .status()
            .unwrap();
        assert!(told.success());
        let (found, said) = said(&child.wait_with_output().unwrap());
        assert!(
            asked.elapsed() < Duration::from_secs(1),
            "{:?}",
            asked.elapsed()
        );
        assert_eq!(found, Some(code), "{said}");
        assert!(
            said.contains(&format!("SIG{signal} before the next checkpoint")),
            "{said}"
        );
        assert!(
            said.contains(
                "cargo xtask carom run long.toml --out out --checkpoint-every 0 --resume"
            ),
            "{said}"
        );
        // The epoch has not ended: the checkpoint is the first, and the files have the lengths in
        // it.
        assert!(fs::read(place.path("out/checkpoint")).unwrap() == checkpoint);
        assert_eq!(
            fs::read_to_string(place.path("out/energy.csv")).unwrap(),
            first
        );
        assert_same(&place.complete(&[run, &["--resume"]]), &straight);
    }
}

#[test]
fn an_extended_run_equals_one_run_of_the_full_length() {
    let until = |time| [RUN, &["--until", time]].concat();
    let straight = Place::new().complete(&[&until("4.25")]);
    let place = Place::new().complete(&[&until("2.03")]);
    let short = place.results();
    // Resumed to the same end: nothing is run.
    let place = place.complete(&[&until("2.03"), &["--resume"]]);
    assert!(place.results() == short);
    assert_same(&place.complete(&[&until("4.25"), &["--resume"]]), &straight);
}

/// Checkpoints with replaced numbers and a matching checksum.
#[test]
fn checkpoints_with_forged_checksums_are_refused_or_run_but_never_hang() {
    let short = [RUN, &["--until", "0.5"]].concat();
    let place = Place::new().complete(&[&short]);
    let sound = fs::read(place.path("out/checkpoint")).unwrap();
    let files: Vec<_> = fs::read_dir(place.path("out"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    let files: Vec<_> = files
        .into_iter()
        .map(|path| (fs::read(&path).unwrap(), path))
        .collect();
    let mut random = Pcg64::seed_from_u64(11);
    let numbers = [
        0.0,
        f64::NAN,
        f64::INFINITY,
        1e300,
        1e61,
        1e20,
        -1.0,
        1e-6,
        1e-75,
        1e-160,
        5e-324,
    ];
    let mut refused = 0;
    for case in 0..80 {
        for (bytes, path) in &files {
            fs::write(path, bytes).unwrap();
        }
        let mut forged = sound.clone();
        // Positions and velocities come first, then the observers, which are most of a checkpoint.
        let end = if case % 2 == 0 {
            forged.len() / 5
        } else {
            forged.len() - 8
        };
        // A share of the file: a field that is added elsewhere moves it by a few bytes only.
        let at = 32 + (random.random::<f64>() * (end - 32) as f64) as usize;
        let number = numbers[random.random_range(0..numbers.len())];
        forged[at..at + 8].copy_from_slice(&number.to_le_bytes());
        let mut checksum = crc32fast::Hasher::new();
        checksum.update(&forged[..28]);
        checksum.update(&forged[32..]);
        forged[28..32].copy_from_slice(&checksum.finalize().to_le_bytes());
        fs::write(place.path("out/checkpoint"), &forged).unwrap();
        let mut child = place.start(&[RUN, &["--until", "0.6", "--resume"]]);
        let begun = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().unwrap() {
                break status;
            }
            if begun.elapsed() > Duration::from_secs(30) {
                child.kill().unwrap();
                panic!("it hangs with {number} at byte {at}");
            }
            sleep(Duration::from_millis(2));
        };
        let code = status.code();
        assert!(
            matches!(code, Some(0..=2)),
            "{code:?} with {number} at byte {at}"
        );
        refused += u32::from(code == Some(2));
    }
    assert!((10..55).contains(&refused), "{refused}");
}

#[test]
fn invalid_checkpoints_are_refused_by_name_and_not_modified() {
    let short = [RUN, &["--until", "0.5"]].concat();
    let place = Place::new().complete(&[&short]);
    let (path, resume) = (place.path("out/checkpoint"), ["--resume"]);
    let sound = fs::read(&path).unwrap();
    let spoilt = |spoil: fn(&mut Vec<u8>)| {
        let mut bytes = sound.clone();
        spoil(&mut bytes);
        bytes
    };
    let results = place.results();
    for (bytes, why) in [
        (spoilt(|bytes| bytes.truncate(bytes.len() / 2)), "truncated"),
        (spoilt(|bytes| bytes.truncate(20)), "truncated"),
        (spoilt(|bytes| *bytes.last_mut().unwrap() ^= 1), "damaged"),
        (spoilt(|bytes| bytes[100] ^= 64), "damaged"),
        (spoilt(|bytes| bytes[16] = 200), "newer program"),
        (spoilt(|bytes| bytes[16] = 0), "older program"),
        (b"{ \"time\": 1.0 }".to_vec(), "not a checkpoint of carom"),
        (Vec::new(), "not a checkpoint of carom"),
    ] {
        fs::write(&path, &bytes).unwrap();
        let (code, said) = place.finish(&[&short, &resume]);
        assert_eq!(code, Some(2), "{why}: {said}");
        assert!(
            said.contains(why) && said.contains("out/checkpoint"),
            "{why}: {said}"
        );
        assert!(
            fs::read(&path).unwrap() == bytes,
            "{why}: it is not modified"
        );
    }
    fs::write(&path, &sound).unwrap();
    for (words, why) in [
        ([RUN, &["--until", "0.4"]].concat(), "--until 0.5"),
        (
            [RUN, &["--until", "0.5", "--seed", "4"]].concat(),
            "its box.seed = 3 differs from 4",
        ),
        (
            [RUN, &["--until", "0.5", "--set", "gas.0.count=299"]].concat(),
            "its gas[0].count = 300 differs from 299",
        ),
        ([&short[..], &["--force"]].concat(), "cannot be used with"),
    ] {
        let (code, said) = place.finish(&[&words, &resume]);
        assert_eq!(code, Some(2), "{why}: {said}");
        assert!(said.contains(why), "{why}: {said}");
    }
    assert!(place.results() == results, "nothing is changed");

    // Without --force or --resume nothing is overwritten.
    let (code, said) = place.finish(&[&short]);
    assert_eq!(code, Some(2), "{said}");
    assert!(
        said.contains("--resume") && said.contains("--force"),
        "{said}"
    );
    assert!(place.results() == results);

    // A series shorter than at its checkpoint.
    place.write("out/energy.csv", "time\n");
    let (code, said) = place.finish(&[RUN, &["--until", "0.7"], &resume]);
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("energy.csv"), "{said}");

    // A folder without a run.
    let foreign = Place::new();
    fs::create_dir(foreign.path("out")).unwrap();
    foreign.write("out/letter.txt", "Dear Maxwell");
    let (code, said) = foreign.finish(&[RUN, &resume]);
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("holds no run"), "{said}");
    assert_eq!(fs::read_dir(foreign.path("out")).unwrap().count(), 1);

    // A folder in use by another process.
    let endless = [
        "carom",
        "run",
        "scene.toml",
        "--out",
        "busy",
        "--until",
        "1e6",
        "--set",
        "run.sample_interval=1e3",
    ];
    let mut child = foreign.start(&[&endless]);
    while !foreign.path("busy/checkpoint").exists() {
        sleep(Duration::from_millis(2));
    }
    let (code, said) = foreign.finish(&[&endless, &resume]);
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("another process"), "{said}");
}
