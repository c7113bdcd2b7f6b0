//! What `carom` writes to the terminal: results, progress, `--quiet`, `--json` and exit codes.

use std::{
    fs,
    io::{BufRead as _, BufReader, Read as _},
    path::Path,
    process::{Command, Output, Stdio},
};

use serde_json::Value;

const SCENE: &str = "[box]\nseed = 3\n[[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\n\
                     count = 50\n[run]\nuntil = 0.5\nsample_interval = 0.1\nobserve = [\"energy\"]\n";

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_carom"));
    command
        .current_dir(folder)
        .args(arguments)
        .env_remove("NO_COLOR");
    command
}

fn carom(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments)
        .output()
        .expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A folder with the scene.
fn folder() -> tempfile::TempDir {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("scene.toml"), SCENE).unwrap();
    root
}

/// The last line of the standard output, as JSON.
fn object(output: &Output) -> Value {
    let said = text(&output.stdout);
    let last = said
        .lines()
        .last()
        .unwrap_or_else(|| panic!("{}", text(&output.stderr)));
    serde_json::from_str(last).unwrap_or_else(|error| panic!("{error}: {said}"))
}

#[test]
fn progress_without_a_terminal_is_plain_text_on_standard_error() {
    let root = folder();
    let long = [
        "run",
        "scene.toml",
        "--until",
        "1e6",
        "--set",
        "run.sample_interval=1e6",
        "--out",
        "run",
    ];
    let mut run = command(root.path(), &long)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(run.stderr.take().unwrap()).lines();
    // The first line comes after two seconds; on a slow machine it says that the run begins.
    for _ in 0..5 {
        let line = lines.next().unwrap().unwrap();
        assert!(
            line.contains(" %  ") && !line.contains(['\u{1b}', '\r']),
            "{line:?}"
        );
        if line.contains("collisions") {
            break;
        }
    }
    let killed = Command::new("kill")
        .args(["-INT", &run.id().to_string()])
        .status()
        .unwrap();
    assert!(killed.success());
    let mut said = String::new();
    run.stdout
        .take()
        .unwrap()
        .read_to_string(&mut said)
        .unwrap();
    assert_eq!(run.wait().unwrap().code(), Some(130));
    assert_eq!(said, "", "nothing but the result is printed");
    let last: Vec<String> = lines.map(Result::unwrap).collect();
    assert!(
        last.iter()
            .any(|line| line.starts_with("interrupted by SIGINT")),
        "{last:?}"
    );
}

#[test]
fn a_short_run_prints_its_result_and_nothing_else() {
    let root = folder();
    let run = carom(root.path(), &["run", "scene.toml", "--out", "run"]);
    assert_eq!(text(&run.stderr), "");
    let said = text(&run.stdout);
    let lines: Vec<&str> = said.lines().collect();
    let [first, figures @ .., last] = lines.as_slice() else {
        panic!("{said}")
    };
    assert!(
        first.starts_with("Scene scene.toml: ") && *last == "run/report.html",
        "{said}"
    );
    let [figures @ .., note] = figures else {
        panic!("{said}")
    };
    assert!(note.contains("it takes 32 samples"), "{said}");
    assert_eq!(figures.len(), 3, "{said}");
    assert!(
        figures.iter().all(|figure| figure.starts_with("  ")),
        "{said}"
    );
}

#[test]
fn a_quiet_command_keeps_its_result_and_its_errors() {
    let root = folder();
    let run = carom(
        root.path(),
        &["--quiet", "run", "scene.toml", "--out", "run"],
    );
    assert_eq!(
        (text(&run.stderr), run.status.code()),
        (String::new(), Some(0))
    );
    assert!(text(&run.stdout).contains("collisions"));
    let refused = carom(
        root.path(),
        &["run", "scene.toml", "--out", "run", "--quiet"],
    );
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        text(&refused.stderr).contains("error: run is not empty"),
        "{}",
        text(&refused.stderr)
    );
    assert_eq!(text(&refused.stdout), "");
}

#[test]
fn json_is_one_object_with_the_folder_the_verdict_and_the_totals() {
    let root = folder();
    let run = carom(
        root.path(),
        &["run", "scene.toml", "--out", "run", "--json"],
    );
    assert_eq!(
        text(&run.stdout).lines().count(),
        1,
        "{}",
        text(&run.stdout)
    );
    let object = object(&run);
    for (key, value) in [("command", "run"), ("folder", "run"), ("verdict", "passed")] {
        assert_eq!(object[key], value, "{object}");
    }
    assert_eq!(object["exit_code"], 0);
    assert!(
        object["totals"]["collisions"].as_u64().unwrap() > 10,
        "{object}"
    );
    let checks = object["checks"].as_array().unwrap();
    assert!(
        checks.len() == 2 && checks.iter().all(|check| check["passed"] == true),
        "{object}"
    );
    assert!(root.path().join(object["page"].as_str().unwrap()).exists());
}

#[test]
fn every_command_writes_json_with_the_same_keys() {
    let root = folder();
    let cases = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/encounters.csv");
    let cases = cases.to_str().unwrap();
    let snapshots = "run.snapshots=\"extxyz\"";
    assert!(
        carom(
            root.path(),
            &["run", "scene.toml", "--set", snapshots, "--out", "a"]
        )
        .status
        .success()
    );
    assert!(
        carom(
            root.path(),
            &[
                "run",
                "scene.toml",
                "--seed",
                "4",
                "--set",
                snapshots,
                "--out",
                "b"
            ]
        )
        .status
        .success()
    );
    for (arguments, key) in [
        (&["check", "scene.toml"][..], "check"),
        (&["detect", cases, "--out", "answers.csv"], "searches"),
        (&["merge", "a", "b", "--out", "all"], "page"),
        (&["convert", "a/trajectory.extxyz", "a.gsd"], "frames"),
        (&["measures"], "measures"),
        (&["schema"], "schema"),
    ] {
        let output = carom(root.path(), &[arguments, &["--json"]].concat());
        let object = object(&output);
        assert_eq!(object["command"], arguments[0]);
        assert_eq!(
            (&object["verdict"], &object["exit_code"]),
            (&"passed".into(), &0.into()),
            "{object}"
        );
        for key in ["folder", "totals", "checks", key] {
            assert!(object.get(key).is_some(), "{arguments:?} {key}: {object}");
        }
        assert_eq!(text(&output.stderr), "", "{arguments:?}");
    }
}

#[test]
fn a_check_in_json_has_costs_limits_and_estimates() {
    let root = folder();
    let object = object(&carom(
        root.path(),
        &["check", "scene.toml", "--until", "50", "--json"],
    ));
    let check = &object["check"];
    assert_eq!(check["contents"]["bodies"][0]["number"], 50);
    assert_eq!(check["is_exact"], true);
    let named = |list: &str, key: &str, name: &str| {
        let rows = check[list].as_array().unwrap();
        rows.iter()
            .find(|row| row[key] == name)
            .unwrap_or_else(|| panic!("{name}: {check}"))
            .clone()
    };
    assert_eq!(named("costs", "what", "molecules")["is_paid"], false);
    assert!(named("limits", "quantity", "size ratio")["value"] == 1.0);
    let expected = &check["expected"];
    assert!(
        expected["is_prediction"] == true && expected["number"].as_f64().unwrap() > 10.0,
        "{check}"
    );
    assert!(
        check["estimate"]["seconds"].as_f64().unwrap() > 0.0,
        "{check}"
    );
}

#[test]
fn errors_are_json_too_and_keep_their_exit_codes() {
    let root = folder();
    let heap = "method.scheduler=heap";
    for (arguments, code, word) in [
        (&["run", "missing.toml"][..], 2, "missing.toml"),
        (
            &["check", "scene.toml", "--set", "gas.0.radius=-1"],
            2,
            "gas[0]",
        ),
        (
            &["run", "scene.toml", "--set", "run.until=0", "--set", heap],
            2,
            "run.until",
        ),
        // Speeds grow without bound.
        (
            &[
                "run",
                "scene.toml",
                "--set",
                "elasticity.default=2",
                "--until",
                "1e5",
                "--out",
                "run",
            ],
            1,
            "at time",
        ),
        (
            &[
                "check",
                "scene.toml",
                "--set",
                "elasticity.default=2",
                "--until",
                "1e5",
            ],
            1,
            "at time",
        ),
        (&["fly"], 2, "fly"),
        (&["run", "scene.toml", "--nothing"], 2, "--nothing"),
    ] {
        let output = carom(root.path(), &[arguments, &["--json"]].concat());
        assert_eq!(output.status.code(), Some(code), "{arguments:?}");
        let object = object(&output);
        assert!(object["error"].as_str().unwrap().contains(word), "{object}");
        assert_eq!(object["exit_code"], code);
        assert!(
            text(&output.stderr).contains(word),
            "{}",
            text(&output.stderr)
        );
    }
}

#[test]
fn a_scene_that_cannot_run_is_refused_with_the_words_of_a_run() {
    let root = folder();
    for change in [
        "gas.0.radius=0.2",
        "method.tolerance=1e-9",
        "run.observe=[\"pressure:none\"]",
        "gas.0.energy=1e-160",
        "box.sides=[1e13, 1e13]",
        "elasticity.default=-1",
    ] {
        let said = ["check", "run"].map(|command| {
            let output = carom(root.path(), &[command, "scene.toml", "--set", change]);
            assert_eq!(
                output.status.code(),
                Some(2),
                "{command} {change}: {}",
                text(&output.stdout)
            );
            text(&output.stderr)
        });
        assert!(
            said[0].starts_with("error: ") && said[0] == said[1],
            "{said:?}"
        );
        assert!(!root.path().join("out").exists(), "{change}");
    }
}

#[test]
fn a_closed_pipe_ends_no_command() {
    let root = folder();
    for arguments in [
        &["measures"][..],
        &["schema", "--page"],
        &["--help"],
        &["run", "scene.toml", "--out", "run"],
    ] {
        let mut child = command(root.path(), arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let mut said = String::new();
        child
            .stderr
            .take()
            .unwrap()
            .read_to_string(&mut said)
            .unwrap();
        // A command that takes more than two seconds says so.
        let others: Vec<&str> = said
            .lines()
            .filter(|line| !line.ends_with("so far"))
            .collect();
        assert_eq!(child.wait().unwrap().code(), Some(0), "{arguments:?}");
        assert!(others.is_empty(), "{arguments:?}: {others:?}");
    }
}

#[test]
fn no_color_is_heeded() {
    let root = folder();
    let output = command(root.path(), &["--help"])
        .env("NO_COLOR", "1")
        .output()
        .unwrap();
    assert!(output.status.success());
    let said = text(&output.stdout);
    assert!(
        said.contains("--quiet") && said.contains("--json") && !said.contains('\u{1b}'),
        "{said}"
    );
}

/// Standard output on a full disk.
#[cfg(target_os = "linux")]
#[test]
fn output_that_cannot_be_written_is_an_error() {
    let root = folder();
    for arguments in [
        &["schema"][..],
        &["measures"],
        &["check", "scene.toml"],
        &["run", "scene.toml", "--out", "text"],
        &["run", "scene.toml", "--out", "object", "--json"],
        &["check", "scene.toml", "--json"],
        &["--version"],
        &["--help"],
    ] {
        let full = fs::File::options().write(true).open("/dev/full").unwrap();
        let output = command(root.path(), arguments)
            .stdout(full)
            .output()
            .unwrap();
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(
            said.contains("error: cannot write to standard output: No space left"),
            "{arguments:?}: {said}"
        );
    }
}
