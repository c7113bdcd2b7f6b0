//! `run.measure_from = "auto"`: the measurement starts when no mean changes any more, the same in a
//! run that is extended, and no rule of `[run.stop]` ends the run before.

use std::{fs, path::Path, process::Output};

use serde_json::Value;

use crate::commands::{carom, text};

/// A gas that starts on a lattice with equal speeds: its order decays within some ten time units.
const RELAXING: &str = r#"
[[gas]]
radius = 0.5
mass = 1.0
temperature = 1.0
count = 600
area_fraction = 0.6
[run]
until = 40.0
sample_interval = 0.05
measure_from = "auto"
observe = ["pressure", "hexatic-order"]
animation = false
"#;

fn run(root: &Path, words: &[&str]) -> Output {
    let output = carom(root, &[&["run", "scene.toml"][..], words].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    output
}

fn figures(path: &Path) -> Vec<Value> {
    let summary: Value =
        serde_json::from_str(&fs::read_to_string(path.join("summary.json")).unwrap()).unwrap();
    summary["figures"].as_array().unwrap().clone()
}

fn value(figures: &[Value], name: &str) -> f64 {
    let figure = figures.iter().find(|figure| figure["name"] == name);
    figure.unwrap_or_else(|| panic!("no figure {name}"))["value"]
        .as_f64()
        .unwrap()
}

#[test]
fn the_approach_to_equilibrium_is_left_out_and_an_extended_run_is_a_long_one() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("scene.toml"), RELAXING).unwrap();
    run(root.path(), &["--out", "long"]);
    run(root.path(), &["--out", "short", "--until", "7.3"]);
    run(
        root.path(),
        &["--out", "short", "--resume", "--until", "40"],
    );
    let [long, extended] = ["long", "short"].map(|name| figures(&root.path().join(name)));
    assert_eq!(long, extended);
    for file in ["pressure.csv", "hexatic-order.csv", "collision-rate.csv"] {
        let [one, other] = ["long", "short"]
            .map(|name| fs::read(root.path().join(name).join(file)).unwrap_or_default());
        assert_eq!(one, other, "{file}");
    }
    // After 64 samples, or 64 + 128, …
    let from = value(&long, "measured from");
    let judged = [3.2, 9.6, 22.4];
    assert!(
        judged.iter().any(|time| (from - time).abs() < 1e-9),
        "{from}"
    );
    // The file has the whole run, the table of the order what counts.
    let first = |file: &str| {
        let content = fs::read_to_string(root.path().join("long").join(file)).unwrap();
        content
            .lines()
            .nth(1)
            .unwrap()
            .split(',')
            .next()
            .unwrap()
            .parse::<f64>()
            .unwrap()
    };
    assert!(first("pressure.csv") < 0.1 && (first("hexatic-order.csv") - from).abs() < 1e-9);
    let page = fs::read_to_string(root.path().join("long/report.html")).unwrap();
    assert!(
        page.contains(&format!("Measured from t = {from} on")),
        "{from}"
    );
}

#[test]
fn no_rule_ends_the_run_before_its_measurement_has_started() {
    let root = tempfile::tempdir().unwrap();
    let stop = "[run.stop]\nfigure = \"pressure\"\nrelative_error = 0.5\n";
    fs::write(root.path().join("scene.toml"), format!("{RELAXING}{stop}")).unwrap();
    run(root.path(), &["--out", "out"]);
    let summary: Value =
        serde_json::from_str(&fs::read_to_string(root.path().join("out/summary.json")).unwrap())
            .unwrap();
    let [end, from] = [
        summary["simulated_time"].as_f64().unwrap(),
        value(&figures(&root.path().join("out")), "measured from"),
    ];
    // 32 blocks of the measurement proper, and long before the end.
    assert!(
        end >= from + 1.5 && from >= 3.2 && end < 40.0,
        "{from} {end}"
    );
}

#[test]
fn a_run_that_cannot_start_leaves_nothing_of_its_own() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("scene.toml"), RELAXING).unwrap();
    let refused = |words: &[&str]| {
        let output = carom(
            root.path(),
            &[&["run", "scene.toml", "--out", "out"][..], words].concat(),
        );
        assert_eq!(output.status.code(), Some(2), "{}", text(&output.stderr));
        text(&output.stderr)
    };
    refused(&["--set", "run.observe=[\"drift:gas\"]"]);
    assert!(!root.path().join("out").exists());
    // What a user has put there stays, and refuses the run before anything is placed.
    fs::create_dir(root.path().join("out")).unwrap();
    fs::write(root.path().join("out/notes.txt"), "mine").unwrap();
    assert!(refused(&[]).contains("is not empty"));
    assert_eq!(
        fs::read_to_string(root.path().join("out/notes.txt")).unwrap(),
        "mine"
    );
}
