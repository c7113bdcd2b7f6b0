//! `carom trade` as a user calls it, and the price on the page of a run.

use std::{
    fs,
    path::Path,
    process::{Command, Output, Stdio},
    thread,
    time::{Duration, Instant},
};

const GAS: &str = "[box]\nseed = 3\n[[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\n\
                   count = 100\n[run]\nuntil = 5.0\nsample_interval = 0.5\nobserve = [\"velocities\"]\n";

fn carom(folder: &Path, arguments: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_carom");
    Command::new(program)
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn json(path: &Path) -> serde_json::Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

#[test]
fn a_short_time_gives_a_page_with_its_answer_first_and_says_what_is_not_resolved() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("gas.toml"), GAS).unwrap();
    let clock = Instant::now();
    let run = carom(
        root.path(),
        &["trade", "gas.toml", "--minutes", "0.05", "--out", "out"],
    );
    assert!(
        run.status.success(),
        "{}{}",
        text(&run.stdout),
        text(&run.stderr)
    );
    // Three seconds, on a machine that may be busy.
    assert!(
        clock.elapsed() < Duration::from_secs(30),
        "{:?}",
        clock.elapsed()
    );
    let out = root.path().join("out");
    let summary = json(&out.join("summary.json"));
    let said = summary["advice"].as_str().unwrap().to_owned();
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    let at = |words: &str| {
        page.find(words)
            .unwrap_or_else(|| panic!("{words} is not on the page"))
    };
    assert!(page.contains("carom trade out/config.toml --minutes 0.05"));
    assert!(
        at("contacts none is wrong") < at("<svg") && at("<svg") < at("<table>"),
        "{said}"
    );
    assert!(at("<table>") < at("Not resolved"));
    let rare = summary["unresolved"][0].as_str().unwrap();
    assert!(
        rare.contains("fewer than") && rare.contains("95 %"),
        "{rare}"
    );
    let settings = summary["settings"].as_array().unwrap();
    assert!(settings.len() > 15 && settings[0]["is_exact"] == true);
    assert_eq!(settings[0]["contacts"]["missed"], 0);
    assert_eq!(
        fs::read_to_string(out.join("settings.csv"))
            .unwrap()
            .lines()
            .count(),
        settings.len() + 1
    );
    assert_eq!(json(&out.join("manifest.json"))["complete"], true);
    // The folder repeats itself.
    let again = carom(
        root.path(),
        &[
            "trade",
            "out/config.toml",
            "--minutes",
            "0.03",
            "--out",
            "again",
            "--json",
        ],
    );
    assert!(again.status.success(), "{}", text(&again.stderr));
    let object: serde_json::Value = serde_json::from_slice(&again.stdout).unwrap();
    assert!(
        object["advice"]
            .as_str()
            .unwrap()
            .contains("contacts none is wrong"),
        "{object}"
    );
    assert_eq!(object["settings"].as_array().unwrap().len(), settings.len());
    let full = carom(
        root.path(),
        &["trade", "gas.toml", "--minutes", "0.05", "--out", "out"],
    );
    assert_eq!(
        full.status.code(),
        Some(2),
        "a folder with files is not touched"
    );
}

/// A comparison that a signal ends keeps nothing, and the same command begins anew.
#[cfg(unix)]
#[test]
fn a_signal_ends_it_at_once_and_the_same_command_starts_again() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("gas.toml"), GAS).unwrap();
    let out = root.path().join("out");
    let words = |minutes| {
        [
            "trade",
            "gas.toml",
            "--minutes",
            minutes,
            "--out",
            "out",
            "--json",
        ]
    };
    for (signal, code) in [("INT", 130), ("TERM", 143)] {
        let _ = fs::remove_dir(&out);
        let mut command = Command::new(env!("CARGO_BIN_EXE_carom"));
        command
            .current_dir(root.path())
            .args(words("2"))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        let child = command.spawn().unwrap();
        // The folder is there as soon as the first states are.
        let clock = Instant::now();
        while !out.exists() && clock.elapsed() < Duration::from_mins(1) {
            thread::sleep(Duration::from_millis(20));
        }
        thread::sleep(Duration::from_millis(300));
        let told = Command::new("kill")
            .args(["-s", signal, &child.id().to_string()])
            .status()
            .unwrap();
        assert!(told.success());
        let clock = Instant::now();
        let ended = child.wait_with_output().unwrap();
        // At once, on a machine that may be busy.
        assert!(
            clock.elapsed() < Duration::from_secs(10),
            "{:?}",
            clock.elapsed()
        );
        assert_eq!(ended.status.code(), Some(code));
        let said = text(&ended.stderr);
        let expected =
            format!("interrupted by SIG{signal}; nothing is kept. Start again with\n  carom trade");
        assert!(said.contains(&expected), "{said}");
        let object: serde_json::Value = serde_json::from_slice(&ended.stdout).unwrap();
        assert_eq!(object["exit_code"], code);
        // The file of the lock means nothing without a lock.
        let names = fs::read_dir(&out)
            .unwrap()
            .map(|entry| entry.unwrap().file_name());
        assert_eq!(names.filter(|name| name != ".carom-lock").count(), 0);
    }
    let again = carom(root.path(), &words("0.05"));
    assert!(again.status.success(), "{}", text(&again.stderr));
    assert_eq!(json(&out.join("manifest.json"))["complete"], true);
    assert!(out.join("config.toml").exists());
}

#[test]
fn invalid_input_is_refused_by_name_and_leaves_no_folder() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("gas.toml"), GAS).unwrap();
    for (arguments, said) in [
        (
            &["gas.toml", "--minutes", "0"][..],
            "--minutes must be from 0.01",
        ),
        (&["gas.toml", "--minutes", "nan"], "--minutes"),
        (&["gas.toml", "--from", "other"], "--from has no effect"),
        (&["none.toml"], "cannot read the scene file none.toml"),
        (&["gas.toml", "--set", "gas.0.radius=-1"], "radius"),
        (&["gas.toml", "--set", "method.step=0.1"], "fixed-step"),
        (
            &["gas.toml", "--set", "run.observe=[\"nothing\"]"],
            "nothing",
        ),
        (
            &["gas.toml", "--until", "-1"],
            "run.until must be positive and finite, but is -1",
        ),
        (
            &["gas.toml", "--set", "gas.0.count=1", "--minutes", "0.05"],
            "no contact is possible: number of bodies 1",
        ),
    ] {
        let refused = carom(root.path(), &[&["trade"], arguments].concat());
        assert_eq!(
            refused.status.code(),
            Some(2),
            "{arguments:?}: {}",
            text(&refused.stderr)
        );
        assert!(
            text(&refused.stderr).contains(said),
            "{arguments:?}: {}",
            text(&refused.stderr)
        );
    }
    assert!(!root.path().join("out").exists());
}

#[test]
fn a_run_with_another_method_shows_its_price_and_keeps_its_bits() {
    let root = tempfile::tempdir().unwrap();
    let scene = format!("{GAS}[method]\nscheduler = \"heap\"\nunchecked_cells_per_side = 50\n");
    fs::write(root.path().join("gas.toml"), scene).unwrap();
    for (name, more) in [("with", &[][..]), ("without", &["--no-price"])] {
        let run = carom(
            root.path(),
            &[&["run", "gas.toml", "--out", name], more].concat(),
        );
        assert!(run.status.success(), "{}", text(&run.stderr));
    }
    let read =
        |folder: &str, name: &str| fs::read_to_string(root.path().join(folder).join(name)).unwrap();
    assert!(read("with", "report.html").contains("Price of the method"));
    assert!(!read("without", "report.html").contains("Price of the method"));
    let summary = json(&root.path().join("with/summary.json"));
    let figures = summary["figures"].as_array().unwrap();
    let value = |name: &str| {
        let is_it = |figure: &&serde_json::Value| figure["name"].as_str().unwrap().ends_with(name);
        figures
            .iter()
            .find(is_it)
            .unwrap_or_else(|| panic!("{name}"))["value"]
            .as_f64()
            .unwrap()
    };
    assert!(
        value("missed in a million") > 0.0
            && value("processor time over that of the exact run") > 0.0
    );
    let names = fs::read_dir(root.path().join("with")).unwrap();
    let names = names.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned());
    let is_data = |name: &String| {
        Path::new(name)
            .extension()
            .is_some_and(|end| end == "csv" || end == "svg")
    };
    let data: Vec<String> = names.filter(is_data).collect();
    assert!(data.len() > 2, "{data:?}");
    for name in data {
        assert_eq!(read("with", &name), read("without", &name), "{name}");
    }
}
