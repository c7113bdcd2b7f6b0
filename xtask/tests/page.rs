//! The pages in a browser: no errors, no network access, a moving gas, and complete figures.

use std::{fs, path::Path};

use carom_testkit::chromium;
use serde_json::Value;

use crate::support::xtask_in;

/// Results of the probe in a page.
fn seen(browser: &str, page: &Path) -> Value {
    let html = fs::read_to_string(page).unwrap();
    assert!(
        html.len() < 1_500_000,
        "{} has {} bytes",
        page.display(),
        html.len()
    );
    let path = page.with_file_name("probed.html");
    fs::write(&path, chromium::with_probe(&html, include_str!("probe.js"))).unwrap();
    serde_json::from_str(&chromium::seen(browser, &path, &["--window-size=1200,900"])).unwrap()
}

fn check(seen: &Value, canvases: usize, titles: &[&str]) {
    assert_eq!(seen["faults"], Value::Array(Vec::new()));
    assert_eq!(
        seen["fetched"],
        Value::Array(Vec::new()),
        "the page needs no network"
    );
    let list = |name: &str| seen[name].as_array().unwrap().clone();
    assert_eq!(list("canvases").len(), canvases);
    for canvas in list("canvases") {
        // Background, discs, and their outlines.
        assert!(
            canvas["share"].as_f64().unwrap() > 0.1 && canvas["colours"].as_u64().unwrap() >= 3,
            "{canvas}"
        );
    }
    for name in ["moved", "back", "redrawn"] {
        assert!(
            list(name).iter().all(|is| is == &Value::Bool(true)),
            "{name}: {}",
            seen[name]
        );
    }
    assert!(
        seen["played"].as_f64().unwrap() > 0.0 && seen["paused"] == true,
        "{seen}"
    );
    assert_ne!(seen["night"][0], seen["night"][1]);
    assert_eq!(seen["overflow"], 0, "the page fits its window");
    let figures = list("figures");
    for figure in &figures {
        let side = |name: &str| figure[name].as_f64().unwrap();
        assert!(
            side("width") > 100.0 && side("height") > 100.0 && figure["broken"] == false,
            "{figure}"
        );
    }
    for title in titles {
        let found = figures
            .iter()
            .filter(|figure| figure["text"].as_str().unwrap().contains(title))
            .count();
        assert!(found > 0, "no figure '{title}'");
    }
}

#[test]
fn pages_are_complete_and_the_gas_moves() {
    let test = concat!(module_path!(), "::pages_are_complete_and_the_gas_moves");
    let Some(browser) = chromium::browser(test) else {
        return;
    };
    let root = tempfile::tempdir().unwrap();
    let folder = root.path();
    let charts = [
        "Directions of the impulses",
        "polar chart",
        "velocity along x′",
        "x′",
    ];
    let brownian = [
        "carom",
        "brownian",
        "tee",
        "--atom-radius",
        "0.005",
        "--from",
        "0.2",
        "--until",
        "2",
    ];
    xtask_in(folder, &[&brownian[..], &["--out", "both"]].concat());
    check(&seen(browser, &folder.join("both/report.html")), 2, &charts);

    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/runs/examples/walls.toml");
    xtask_in(
        folder,
        &[
            "carom",
            "run",
            scene.to_str().unwrap(),
            "--until",
            "0.5",
            "--out",
            "run",
        ],
    );
    check(
        &seen(browser, &folder.join("run/report.html")),
        1,
        &["t = 0"],
    );

    // Of a large system a part of the box is shown.
    let gas = "[[gas]]\nradius = 0.002\nmass = 1.0\nenergy = 1.0\ncount = 20000\n[run]\nuntil = 0.01\nsample_interval = 0.01\n";
    fs::write(folder.join("large.toml"), gas).unwrap();
    xtask_in(folder, &["carom", "run", "large.toml", "--out", "large"]);
    check(
        &seen(browser, &folder.join("large/report.html")),
        1,
        &["t = 0"],
    );
}
