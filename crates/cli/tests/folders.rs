//! Output folders: one process at a time, nothing of a replaced run, and commands to copy.

use std::{
    ffi::OsStr,
    fs,
    path::Path,
    process::{Child, Command, Output, Stdio},
    thread,
    time::Duration,
};

use serde_json::Value;

const SCENE: &str = "[box]\nseed = 3\n[[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\n\
                     count = 50\n[run]\nuntil = 0.5\nsample_interval = 0.1\nobserve = [\"energy\"]\n";

fn command(folder: &Path, words: &[impl AsRef<OsStr>]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_carom"));
    command
        .current_dir(folder)
        .args(words)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

fn carom(folder: &Path, words: &[impl AsRef<OsStr>]) -> Output {
    command(folder, words).output().expect("the program starts")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn succeeds(folder: &Path, words: &[&str]) {
    let output = carom(folder, words);
    assert!(output.status.success(), "{words:?}: {}", said(&output));
}

fn refused(folder: &Path, words: &[&str], why: &str) {
    let output = carom(folder, words);
    assert!(
        output.status.code() == Some(2) && said(&output).contains(why),
        "{words:?}: {}",
        said(&output)
    );
}

fn folder() -> tempfile::TempDir {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("scene.toml"), SCENE).unwrap();
    root
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

/// A run without end, once it has written a checkpoint.
fn endless(root: &Path, out: &str) -> Child {
    let words = [
        "run",
        "scene.toml",
        "--until",
        "1e6",
        "--set",
        "run.sample_interval=1e3",
        "--out",
        out,
        "--force",
    ];
    // That of an earlier run.
    let _ = fs::remove_file(root.join(out).join("checkpoint"));
    let child = command(root, &words).spawn().unwrap();
    while !root.join(out).join("checkpoint").exists() {
        thread::sleep(Duration::from_millis(5));
    }
    child
}

fn end(mut child: Child) {
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn of_two_runs_that_start_together_in_a_new_folder_one_is_refused() {
    let root = folder();
    for attempt in 0..6 {
        let out = format!("out-{attempt}");
        let runs = ["1", "2"].map(|seed| {
            let words = ["run", "scene.toml", "--seed", seed, "--out", &out];
            (seed, command(root.path(), &words).spawn().unwrap())
        });
        let ended = runs.map(|(seed, run)| (seed, run.wait_with_output().unwrap()));
        let good: Vec<_> = ended
            .iter()
            .filter(|(_, output)| output.status.success())
            .collect();
        assert_eq!(
            good.len(),
            1,
            "{}\n{}",
            said(&ended[0].1),
            said(&ended[1].1)
        );
        for (_, bad) in ended.iter().filter(|(_, output)| !output.status.success()) {
            let words = said(bad);
            assert!(
                words.contains("another process") || words.contains("is not empty"),
                "{words}"
            );
        }
        let manifest = json(&root.path().join(&out).join("manifest.json"));
        assert_eq!(manifest["complete"], true);
        assert_eq!(manifest["streams"][0]["seed"].to_string(), good[0].0);
        let scene = fs::read_to_string(root.path().join(&out).join("config.toml")).unwrap();
        assert!(scene.contains(&format!("seed = {}", good[0].0)), "{scene}");
        assert!(!root.path().join(&out).join(".carom-lock").exists());
        assert!(!root.path().join(&out).join(".carom-files").exists());
    }
}

#[test]
fn a_replaced_run_leaves_nothing_and_files_of_the_user_stay() {
    let root = folder();
    let (path, out) = (root.path(), root.path().join("out"));
    let long = "run.observe=[\"energy\", \"velocities:gas\", \"events:gas\"]";
    let names = || {
        let mut names: Vec<String> = fs::read_dir(&out)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    };
    let short = [
        "run",
        "scene.toml",
        "--set",
        "run.observe=[\"pressure\"]",
        "--out",
        "out",
    ];
    succeeds(path, &short);
    let expected = names();
    succeeds(
        path,
        &[
            "run",
            "scene.toml",
            "--set",
            long,
            "--out",
            "out",
            "--force",
        ],
    );
    fs::write(out.join("energy-notes.csv"), "mine").unwrap();
    fs::write(out.join("letter.txt"), "mine").unwrap();
    succeeds(path, &[&short[..], &["--force"]].concat());
    let mine = ["energy-notes.csv".to_owned(), "letter.txt".to_owned()];
    let left: Vec<String> = names()
        .into_iter()
        .filter(|name| !mine.contains(name))
        .collect();
    assert_eq!(left, expected);
    assert_eq!(names().len(), expected.len() + 2);
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(
        page.contains("pressure") && !page.contains("letter.txt") && !page.contains("energy-notes")
    );
    // The page of the folder is the same when it is written again.
    succeeds(path, &["report", "out"]);
    assert!(fs::read_to_string(out.join("report.html")).unwrap() == page);

    // A run that was killed leaves as little.
    end(endless(path, "out"));
    assert!(out.join("energy.csv").exists());
    succeeds(path, &[&short[..], &["--force"]].concat());
    let left: Vec<String> = names()
        .into_iter()
        .filter(|name| !mine.contains(name))
        .collect();
    assert_eq!(left, expected);
}

#[test]
fn a_merge_neither_replaces_its_sources_nor_disturbs_a_run() {
    let root = folder();
    let path = root.path();
    for seed in ["1", "2"] {
        succeeds(path, &["run", "scene.toml", "--seed", seed, "--out", seed]);
    }
    let before = fs::read(path.join("1/sums")).unwrap();
    refused(
        path,
        &["merge", "1", "2", "--out", "1", "--force"],
        "is one of the folders to merge",
    );
    refused(
        path,
        &["merge", "1", "2", "--out", "2/../1", "--force"],
        "is one of the folders to merge",
    );
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("1", path.join("link")).unwrap();
        refused(
            path,
            &["merge", "1", "2", "--out", "link", "--force"],
            "is one of the folders to merge",
        );
    }
    assert!(fs::read(path.join("1/sums")).unwrap() == before);
    let run = endless(path, "busy");
    let process = format!("process {} on", run.id());
    refused(
        path,
        &["merge", "1", "2", "--out", "busy", "--force"],
        &process,
    );
    refused(
        path,
        &["merge", "1", "busy", "--out", "both"],
        "another process writes into busy",
    );
    refused(
        path,
        &["run", "scene.toml", "--out", "busy", "--force"],
        &process,
    );
    end(run);
    assert!(!path.join("both").exists());
    succeeds(path, &["merge", "1", "2", "--out", "busy", "--force"]);
    assert!(!path.join("busy/checkpoint").exists() && !path.join("busy/energy.csv.part").exists());
    assert_eq!(json(&path.join("busy/manifest.json"))["complete"], true);
}

#[test]
fn commands_to_copy_are_quoted() {
    let root = folder();
    let out = "a b $(touch x)";
    succeeds(root.path(), &["run", "scene.toml", "--out", out]);
    let manifest = json(&root.path().join(out).join("manifest.json"));
    assert_eq!(manifest["again"], "carom run 'a b $(touch x)/config.toml'");
    succeeds(root.path(), &["merge", out, "--out", "m'n"]);
    let manifest = json(&root.path().join("m'n/manifest.json"));
    assert_eq!(
        manifest["again"],
        "carom merge 'a b $(touch x)' --out 'm'\\''n'"
    );
}

#[cfg(target_os = "linux")]
#[test]
fn paths_that_are_not_utf_8_are_paths() {
    use std::os::unix::ffi::OsStrExt as _;
    let root = folder();
    let [scene, out, merged] = [&b"s\xff.toml"[..], b"o\xff", b"m\xff"].map(OsStr::from_bytes);
    fs::copy(root.path().join("scene.toml"), root.path().join(scene)).unwrap();
    let word = |word: &'static str| OsStr::new(word);
    for words in [
        vec![word("run"), scene, word("--out"), out],
        vec![word("run"), scene, word("--out"), out, word("--resume")],
        vec![word("run"), scene],
        vec![word("check"), scene],
        vec![word("report"), out],
        vec![word("merge"), out, word("--out"), merged],
    ] {
        let output = carom(root.path(), &words);
        assert_eq!(
            output.status.code(),
            Some(0),
            "{words:?}: {}",
            said(&output)
        );
    }
    let again = json(&root.path().join(out).join("manifest.json"))["again"].clone();
    assert_eq!(again, "carom run $'o\\377/config.toml'");
}

/// As on a full disk: neither the series nor the page can be written.
#[cfg(target_os = "linux")]
#[test]
fn the_first_cause_of_a_failure_comes_first_and_is_in_the_manifest() {
    let root = folder();
    let out = root.path().join("out");
    fs::create_dir_all(out.join("report.html/full")).unwrap();
    std::os::unix::fs::symlink("/dev/full", out.join("energy.csv")).unwrap();
    let output = carom(
        root.path(),
        &["run", "scene.toml", "--out", "out", "--force"],
    );
    let words = said(&output);
    assert_eq!(output.status.code(), Some(2), "{words}");
    let first = words
        .lines()
        .find(|line| line.starts_with("error: "))
        .unwrap_or(&words);
    assert!(
        first.contains("energy.csv") && first.contains("No space"),
        "{words}"
    );
    let manifest = json(&out.join("manifest.json"));
    assert!(
        manifest["error"].as_str().unwrap().contains("energy.csv"),
        "{manifest}"
    );
    assert_eq!(manifest["complete"], false);
}

/// The program asks nothing of the machine on which it runs about its sources.
#[cfg(unix)]
#[test]
fn the_revision_is_that_of_the_program() {
    use std::os::unix::fs::PermissionsExt as _;
    let root = folder();
    let git = root.path().join("git");
    fs::write(&git, "#!/bin/sh\ntouch called\necho forged\n").unwrap();
    fs::set_permissions(&git, fs::Permissions::from_mode(0o755)).unwrap();
    let output = command(root.path(), &["run", "scene.toml", "--out", "out"])
        .env("PATH", root.path())
        .output();
    assert!(output.unwrap().status.success());
    assert!(!root.path().join("called").exists());
    assert_ne!(
        json(&root.path().join("out/manifest.json"))["revision"],
        "forged"
    );
}
