//! Short forms of the attacks, and what an attack does with a case that fails.

use std::{fs, process::Output};

use crate::support::xtask;

fn text(output: &Output) -> String {
    let said = [&output.stdout[..], &output.stderr].concat();
    String::from_utf8_lossy(&said).into_owned()
}

/// Runs a part of one kind of attack. The attacks are tests of this program, so one holds for a
/// processor each.
fn check(kind: &str, times: &str) {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().to_str().unwrap();
    let arguments = [
        "attack",
        "--kinds",
        kind,
        "--seed",
        "7",
        "--times",
        times,
        "--threads",
        "1",
        "--out",
        folder,
    ];
    let output = xtask(&arguments);
    let said = text(&output);
    let kept = fs::read_dir(out.path())
        .unwrap()
        .map(|entry| fs::read_to_string(entry.unwrap().path()).unwrap());
    let kept: Vec<String> = kept.collect();
    assert_eq!(output.status.code(), Some(0), "{said}{}", kept.join("\n"));
    // On other systems than Linux some kinds are skipped, and counted as such.
    assert!(
        said.contains(&format!("| {kind}: ")) || said.contains("skipped"),
        "{said}"
    );
}

#[test]
fn signals_at_any_moment_lose_nothing() {
    check("kills", "0.16");
}

#[test]
fn failing_calls_end_a_command_with_an_error_and_a_repeat_gives_the_same_bytes() {
    check("faults", "0.02");
}

#[test]
fn losses_of_power_lose_no_finished_work() {
    check("power", "0.07");
}

#[test]
fn two_processes_in_one_folder_never_succeed_with_wrong_bytes() {
    check("machines", "0.1");
}

#[test]
fn mutated_files_are_refused_or_answered() {
    check("files", "0.01");
}

#[test]
fn a_case_in_a_file_is_replayed_and_its_folder_kept() {
    let root = tempfile::tempdir().unwrap();
    let path = |name: &str| root.path().join(name);
    let case = "world = \"runs\"\nwords = \"check scene.toml\"\nfile = \"scene.toml\"\nhas_checksum = false\n\
                text = \"[box]\\n\"\n";
    fs::write(path("case.toml"), case).unwrap();
    let replayed = path("case.toml");
    let output = xtask(&[
        "attack",
        "--kinds",
        "files",
        "--replay",
        replayed.to_str().unwrap(),
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
    assert!(
        text(&output).contains("| files: check | 1 | 1 | 0 |"),
        "{}",
        text(&output)
    );
    assert_eq!(
        fs::read_to_string(path("case.replayed/scene.toml")).unwrap(),
        "[box]\n"
    );
}

#[test]
fn bad_options_and_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("case.toml");
    fs::write(&file, "nothing").unwrap();
    let file = file.to_str().unwrap();
    for (arguments, words) in [
        (&["--times", "0"][..], "--times must be positive"),
        (&["--replay", file], "name it with --kinds"),
        (&["--replay", file, "--kinds", "kills"], "TOML"),
        (
            &["--replay", "nowhere.toml", "--kinds", "power"],
            "cannot read nowhere.toml",
        ),
    ] {
        let output = xtask(&[&["attack"], arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{}", text(&output));
        assert!(text(&output).contains(words), "{}", text(&output));
    }
}
