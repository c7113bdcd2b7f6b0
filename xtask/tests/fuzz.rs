//! The fuzzers as commands: a worker survives its cases, and failing cases are written and
//! replayed.

use std::{fs, path::PathBuf, time::Duration};

use carom_runs::interruption::Signals;
use xtask::fuzz::{
    planted::Planted,
    subject::Subject as _,
    worker::{Runner as _, Worker},
};

use crate::support::xtask;

#[test]
fn a_worker_survives_panics_hangs_and_lack_of_memory() {
    let program = PathBuf::from(env!("CARGO_BIN_EXE_xtask"));
    let mut worker = Worker::new(
        program,
        Planted::NAME,
        Duration::from_secs(1),
        Signals::default(),
    );
    for (seed, kind) in [
        (4, None),
        (5, Some("panic")),
        (6, Some("hang")),
        (7, Some("crash")),
        (8, None),
    ] {
        let report = worker
            .run_seed(seed)
            .expect("the worker answers or is restarted");
        assert_eq!(
            report.failure.as_ref().map(|failure| &failure.kind[..]),
            kind,
            "{seed}: {report:?}"
        );
        let report = worker
            .run_file("seed", seed.to_string().as_bytes())
            .expect("likewise");
        assert_eq!(
            report.failure.map(|failure| failure.kind).as_deref(),
            kind,
            "{seed}"
        );
    }
}

#[test]
fn each_fuzzer_counts_what_it_did_and_repeats_it() {
    let out = tempfile::tempdir().unwrap();
    for name in ["scenes", "detection", "files"] {
        let folder = out.path().to_str().unwrap();
        let run = || {
            let output = xtask(&[
                "fuzz",
                name,
                "--minutes",
                "1",
                "--seed",
                "3",
                "--cases",
                "2",
                "--out",
                folder,
            ]);
            let said = String::from_utf8_lossy(&output.stdout).into_owned();
            assert!(matches!(output.status.code(), Some(0 | 1)), "{said}");
            said.lines()
                .find(|line| line.contains("2 cases"))
                .expect("a line with the counts")
                .to_owned()
        };
        let line = run();
        assert!(line.starts_with(&format!("fuzz {name}: 2 cases")), "{line}");
        assert_eq!(run(), line);
    }
}

#[test]
fn bad_options_and_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("case.unknown");
    fs::write(&file, "nothing").unwrap();
    assert_eq!(
        xtask(&["fuzz", "files", "--replay", file.to_str().unwrap()])
            .status
            .code(),
        Some(1)
    );
    assert_eq!(
        xtask(&["fuzz", "files", "--replay", "nowhere.toml"])
            .status
            .code(),
        Some(2)
    );
    assert_eq!(
        xtask(&["fuzz", "scenes", "--minutes", "0"]).status.code(),
        Some(2)
    );
}
