//! Pages written again: the bytes of the run's own page, and pages of incomplete folders.

use std::{fs, path::Path};

use carom_tables::Verdict;
use clap::Parser;

use super::*;
use crate::{merge, run};

/// A gas with curves, predictions, series and a file of contacts.
const GAS: &str = r#"
    [[gas]]
    tags = ["gas"]
    radius = 0.04
    mass = 1.0
    energy = 1.0
    count = 20
    [run]
    until = 1.0
    sample_interval = 0.05
    observe = ["energy", "pressure", "velocities", "correlation", "events", "thermostat"]
    [[stage]]
    until = 0.2
    measure = false
    thermostat = [{ tag = "gas", every = 0.05, kind = "maxwell", temperature = 1.0 }]
    [[stage]]
    until = 1.0
"#;

#[derive(Parser)]
struct Run {
    #[command(flatten)]
    options: run::RunOptions,
}

#[derive(Parser)]
struct Merge {
    #[command(flatten)]
    options: merge::MergeOptions,
}

fn run_in(root: &Path, scene: &str, words: &[&str], out: &str) -> (Result<Verdict>, PathBuf) {
    let [path, out] = ["scene.toml", out].map(|name| root.join(name));
    fs::write(&path, scene).unwrap();
    let words = [
        &[
            "run",
            path.to_str().unwrap(),
            "--out",
            out.to_str().unwrap(),
        ],
        words,
    ]
    .concat();
    (run::run(&Run::parse_from(words).options), out)
}

/// The page that the command writes again, without the old one.
fn again(folder: &Path) -> String {
    let page = folder.join(PAGE);
    let _ = fs::remove_file(&page);
    assert_eq!(
        run(&ReportOptions {
            folders: vec![folder.to_owned()]
        })
        .unwrap(),
        Verdict::Passed
    );
    fs::read_to_string(page).unwrap()
}

fn page(folder: &Path) -> String {
    fs::read_to_string(folder.join(PAGE)).unwrap()
}

#[test]
fn a_page_written_again_has_the_same_bytes() {
    let root = tempfile::tempdir().unwrap();
    let (verdict, one) = run_in(root.path(), GAS, &[], "one");
    assert_eq!(verdict.unwrap(), Verdict::Passed);
    let written = page(&one);
    assert_eq!(again(&one), written);
    for words in [
        "the dynamics is exact",
        "All 2 checks passed",
        "Measured: pressure",
        "events.csv",
        "Stage 1",
    ] {
        assert!(written.contains(words), "{words}");
    }
    let (_, other) = run_in(root.path(), GAS, &["--set", "box.replica=1"], "other");
    let all = root.path().join("all");
    let words = [
        "merge",
        one.to_str().unwrap(),
        other.to_str().unwrap(),
        "--out",
        all.to_str().unwrap(),
    ];
    merge::run(&Merge::parse_from(words).options).unwrap();
    let merged = page(&all);
    assert_eq!(again(&all), merged);
    // Bins that depend on the speeds are drawn too.
    assert!(merged.contains("Distribution of speeds"));
}

#[test]
fn the_page_of_a_run_that_measures_kicks_alone_leads_with_their_rate() {
    let root = tempfile::tempdir().unwrap();
    let scene = "[box]\nsides = [0.8, 0.5]\n[[molecule]]\ntags = [\"probe\"]\nshape = \"tee\"\n\
         atom_radius = 0.02\natom_mass = 1.0\nat = [0.4, 0.25]\n[[bumper]]\nradius = 0.01\nat = [0.1, 0.1]\n\
         [[gas]]\nradius = 0.015\nmass = 1.0\nenergy = 1.0\ncount = 60\n\
         [run]\nuntil = 8.0\nsample_interval = 0.05\nobserve = [\"kicks:probe\"]\nanimation = false\n";
    let (ended, out) = run_in(root.path(), scene, &[], "out");
    ended.unwrap();
    let written = page(&out);
    assert!(
        written.contains("Measured: kicks, probe") && !written.contains("Measured: kT"),
        "{written}"
    );
}

#[test]
fn a_page_in_reduced_units_says_so_and_files_keep_those_of_the_scene() {
    let root = tempfile::tempdir().unwrap();
    let scene = GAS.replace("energy = 1.0", "temperature = 4.0");
    let words = ["--set", "run.units=\"reduced\""];
    let (_, plain) = run_in(root.path(), &scene, &[], "plain");
    let (_, reduced) = run_in(root.path(), &scene, &words, "reduced");
    let written = page(&reduced);
    // σ = 0.08, ε = 4 and τ = 0.04.
    assert!(
        written.contains("σ = 0.08 (length), m = 1 (mass), ε = 4 (energy) and τ = σ√(m/ε) = 0.04")
    );
    assert!(written.contains("ε/σ²") && !page(&plain).contains("ε/σ²"));
    assert_eq!(again(&reduced), written);
    for file in ["tables.json", "pressure.csv"] {
        let [of_plain, of_reduced] = [&plain, &reduced].map(|folder| fs::read(folder.join(file)));
        assert_eq!(of_plain.unwrap(), of_reduced.unwrap(), "{file}");
    }
    let figures = |folder: &Path| {
        let text = fs::read_to_string(folder.join("summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
        summary["figures"].clone()
    };
    assert_eq!(figures(&plain), figures(&reduced));
}

#[test]
fn a_run_that_ends_with_an_error_leaves_its_page_and_summary() {
    let root = tempfile::tempdir().unwrap();
    let text = GAS
        .split("[[stage]]")
        .next()
        .unwrap()
        .replace("until = 1.0", "until = 1e3");
    let scene = format!("{text}\n[elasticity]\ndefault = 2.0\n");
    let (ended, out) = run_in(root.path(), &scene, &[], "out");
    let error = ended.unwrap_err();
    assert!(
        error
            .chain()
            .any(<dyn std::error::Error>::is::<carom::RunError>),
        "{error:#}"
    );
    let written = page(&out);
    assert!(written.contains("The run ended with an error") && written.contains("pressure"));
    assert_eq!(again(&out), written);
    let read = |name: &str| -> serde_json::Value {
        serde_json::from_str(&fs::read_to_string(out.join(name)).unwrap()).unwrap()
    };
    let (manifest, summary) = (read("manifest.json"), read("summary.json"));
    assert_eq!(manifest["complete"], false);
    assert!(written.contains(&carom_report::page::escape(
        manifest["error"].as_str().unwrap()
    )));
    assert_eq!(
        (
            &summary["checks"][0]["name"],
            &summary["checks"][0]["passed"]
        ),
        (&"time_left".into(), &false.into())
    );
    assert!(
        summary["simulated_time"].as_f64().unwrap() < 1e3
            && summary["collisions"].as_u64().unwrap() > 100
    );
}

#[test]
fn the_page_of_an_incomplete_folder_says_so() {
    let root = tempfile::tempdir().unwrap();
    let (_, out) = run_in(root.path(), GAS, &[], "out");
    let manifest = fs::read_to_string(out.join(MANIFEST)).unwrap();
    fs::write(
        out.join(MANIFEST),
        manifest.replace("\"complete\": true", "\"complete\": false"),
    )
    .unwrap();
    for name in ["summary.json", "tables.json", "end.svg", "animation.json"] {
        fs::remove_file(out.join(name)).unwrap();
        let page = again(&out);
        assert!(
            page.contains("has not ended") && page.contains("Missing") && page.contains(name),
            "{name}"
        );
    }
    let empty = root.path().join("empty");
    fs::create_dir(&empty).unwrap();
    let refused = run(&ReportOptions {
        folders: vec![empty],
    })
    .unwrap_err()
    .to_string();
    assert!(refused.contains("manifest.json"), "{refused}");
}

#[test]
fn the_page_of_an_experiment_keeps_its_content() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path();
    fs::write(
        folder.join(MANIFEST),
        r#"{ "again": "cargo xtask experiment none", "complete": true }"#,
    )
    .unwrap();
    fs::write(
        folder.join("summary.json"),
        r#"{ "title": "An experiment" }"#,
    )
    .unwrap();
    fs::write(folder.join("a.svg"), "<svg><text>a picture</text></svg>").unwrap();
    let plain = again(folder);
    assert!(plain.contains("An experiment") && plain.contains("a picture"));
    let mut page = carom_report::page::Page::new("Own", "Own text");
    page.code("cargo xtask experiment none");
    let own = page.html();
    fs::write(folder.join(PAGE), own.replace("--ground", "--old")).unwrap();
    run(&ReportOptions {
        folders: vec![folder.to_owned()],
    })
    .unwrap();
    assert_eq!(fs::read_to_string(folder.join(PAGE)).unwrap(), own);
}
