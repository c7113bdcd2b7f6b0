//! `carom brownian` and `carom billiard` as a user calls them, for a molecule of unequal atoms and
//! for a body of a scene.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use serde_json::Value;

/// Three atoms of three sizes around a fourth one: no mirror symmetry.
const MOLECULE: &str = "atoms = [\n  { at = [0.0, 0.0], radius = 0.01, mass = 1.0 },\n  \
                        { at = [0.02, 0.0], radius = 0.012, mass = 2.0 },\n  \
                        { at = [-0.01, 0.018], radius = 0.008, mass = 0.5 },\n  \
                        { at = [-0.01, -0.02], radius = 0.014, mass = 3.0 },\n]\n";

const SCENE: &str = "[box]\nsides = [0.8, 0.5]\n[[molecule]]\ntags = [\"probe\"]\nshape = \"ring:5\"\n\
                     atom_radius = 0.01\natom_mass = 1.0\nat = [0.4, 0.25]\n[[wall]]\ny = 0.0\n\
                     [[gas]]\nradius = 0.015\nmass = 1.0\nenergy = 1.0\ncount = 60\n\
                     [run]\nuntil = 2.0\nsample_interval = 0.05\nmeasure_from = 0.5\n";

fn carom(folder: &Path, arguments: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_carom");
    Command::new(program)
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("the program starts")
}

fn passes(folder: &Path, arguments: &[&str]) -> String {
    let output = carom(folder, arguments);
    let said = [output.stdout.as_slice(), &output.stderr].concat();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&said)
    );
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn summary(folder: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(folder.join("summary.json")).unwrap()).unwrap()
}

/// A figure of a point.
fn figure(summary: &Value, point: usize, name: &str) -> Value {
    let figures = summary["points"][point]["figures"]
        .as_array()
        .unwrap()
        .iter();
    let found = figures
        .filter(|figure| figure["name"] == name)
        .collect::<Vec<_>>();
    (*found
        .first()
        .unwrap_or_else(|| panic!("no figure '{name}'")))
    .clone()
}

/// The folder of a point.
fn folder_of(sweep: &Path, summary: &Value, point: usize) -> PathBuf {
    sweep
        .join("points")
        .join(summary["points"][point]["point"].as_str().unwrap())
}

#[test]
fn any_molecule_runs_beside_its_control_and_its_run_can_be_continued() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("fan.toml"), MOLECULE).unwrap();
    let fixed = [
        "brownian",
        "fan.toml",
        "--gas-radius",
        "0.02",
        "--side",
        "0.5",
        "--area-fraction",
        "0.3",
    ];
    let words =
        |more: &[&'static str]| [&fixed[..], &["--from", "0.5", "--until", "33"], more].concat();
    let said = passes(root.path(), &words(&["--out", "once"]));
    assert!(
        said.contains("tested means are as predicted") && said.contains("Brownian motion: fan"),
        "{said}"
    );
    let out = root.path().join("once");
    let whole = summary(&out);
    assert_eq!(whole["points"][0]["label"], "molecule = fan");
    let tests = whole["checks"].as_array().unwrap();
    assert!(
        tests
            .iter()
            .filter(|check| check["name"].as_str().unwrap().contains("errors from 0"))
            .count()
            >= 5
    );
    // The perimeter is longer than that of the control.
    let [fan, control] = [0, 1].map(|point| {
        figure(&whole, point, "perimeter of the excluded region, molecule")["value"]
            .as_f64()
            .unwrap()
    });
    assert!(fan > control);
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(
        page.contains("Brownian motion: fan")
            && page.contains("The control is a disc of the same area")
    );
    assert!(page.contains("class=\"animation\"") && page.contains("polar chart"));
    let drawing =
        fs::read_to_string(folder_of(&out, &whole, 0).join("kicks-body-molecule.svg")).unwrap();
    assert!(drawing.contains(">D</text>"));

    // In two shards; more replicas continue what is there.
    passes(root.path(), &words(&["--shard", "1/2", "--out", "one"]));
    passes(root.path(), &words(&["--shard", "2/2", "--out", "two"]));
    passes(root.path(), &["merge", "one", "two", "--out", "both"]);
    let table =
        |folder: &str| fs::read_to_string(root.path().join(folder).join("table.csv")).unwrap();
    assert_eq!(table("both"), table("once"));
    passes(root.path(), &words(&["--replicas", "2", "--out", "once"]));
    assert_eq!(summary(&out)["replicas_wanted"], 2);

    // Another gas is another study.
    let mut other = words(&["--out", "once"]);
    other[3] = "0.018";
    let refused = carom(root.path(), &other);
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(
        refused.status.code() == Some(2) && said.contains("another study"),
        "{said}"
    );
}

/// In a gas of 16 discs of area fraction 0.005 the kicks agree with the exposed arcs, by direction
/// and by atom.
#[test]
fn a_dilute_gas_shows_the_exposed_arcs() {
    let root = tempfile::tempdir().unwrap();
    let words = [
        "brownian",
        "tee",
        "--atom-radius",
        "0.005",
        "--area-fraction",
        "0.005",
        "--seed",
        "3",
    ];
    passes(
        root.path(),
        &[&words[..], &["--control", "off", "--out", "out"]].concat(),
    );
    let summary = summary(&root.path().join("out"));
    for what in [
        "kicks by direction",
        "impulse by direction",
        "kicks by atom",
    ] {
        let chi = figure(
            &summary,
            0,
            &format!("{what}, χ² per degree of freedom, molecule"),
        );
        let [value, error] = ["value", "standard_error"].map(|key| chi[key].as_f64().unwrap());
        assert!((value - 1.0).abs() < 4.5 * error, "{chi}");
    }
    let rate = figure(&summary, 0, "kicks, molecule");
    let [value, error, predicted] =
        ["value", "standard_error", "prediction"].map(|key| rate[key].as_f64().unwrap());
    assert!(
        value > 1.0 && (value - predicted).abs() < 4.0 * error + 0.003 * predicted,
        "{rate}"
    );
}

#[test]
fn a_body_of_a_scene_keeps_its_surroundings() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("channel.toml"), SCENE).unwrap();
    let words = [
        "brownian",
        "channel.toml",
        "--body",
        "probe",
        "--control",
        "off",
        "--out",
        "out",
    ];
    let said = passes(root.path(), &words);
    // Too short for a verdict, which is said with the time that it needs.
    assert!(
        said.contains("since the measurement is too short: it needs about"),
        "{said}"
    );
    let summary = summary(&root.path().join("out"));
    let point = folder_of(&root.path().join("out"), &summary, 0);
    let config: toml::Table = fs::read_to_string(point.join("config.toml"))
        .unwrap()
        .parse()
        .unwrap();
    assert_eq!(config["box"]["sides"][0].as_float(), Some(0.8));
    assert_eq!(config["wall"].as_array().map(Vec::len), Some(1));
    assert_eq!(
        (&summary["simulated_time"], &summary["overlapping_pairs"]),
        (&2.0.into(), &0.into())
    );
}

/// Two gases and a rod beside the probe; no fixed body.
const MIXTURE: &str = "[box]\nsides = [0.6, 0.6]\n[[molecule]]\ntags = [\"probe\"]\nshape = \"tee\"\n\
                       atom_radius = 0.01\natom_mass = 2.0\nat = [0.3, 0.3]\n[[molecule]]\nshape = \"rod:3\"\n\
                       atom_radius = 0.006\natom_mass = 1.0\nat = [0.1, 0.1]\n\
                       [[gas]]\nradius = 0.02\nmass = 3.0\ntemperature = 1.0\ncount = 20\n\
                       [[gas]]\nradius = 0.01\nmass = 1.0\ntemperature = 1.0\ncount = 60\n\
                       [run]\nuntil = 60.0\nsample_interval = 0.1\nmeasure_from = 1.0\n";

/// A gas of drawn sizes between walls.
const DRAWN: &str = "[box]\nsides = [0.6, 0.6]\n[[molecule]]\ntags = [\"probe\"]\nshape = \"ring:8\"\n\
                     atom_radius = 0.01\natom_mass = 1.0\nat = [0.3, 0.3]\n[[wall]]\nx = 0.0\n\
                     [[gas]]\nradius = { uniform = [0.008, 0.016] }\ndensity = 3000.0\ntemperature = 1.0\n\
                     area_fraction = 0.2\n[run]\nuntil = 40.0\nsample_interval = 0.1\nmeasure_from = 1.0\n";

/// Means vanish and equipartition holds in any surroundings; what has no prediction has none.
#[test]
fn mixtures_have_a_verdict_and_no_predictions_of_one_gas() {
    let root = tempfile::tempdir().unwrap();
    for (name, scene) in [("mixture", MIXTURE), ("drawn", DRAWN)] {
        fs::write(root.path().join(format!("{name}.toml")), scene).unwrap();
        let words = [
            "brownian",
            &format!("{name}.toml"),
            "--body",
            "probe",
            "--out",
            name,
        ];
        let said = passes(root.path(), &words);
        assert!(said.contains("tested means are as predicted"), "{said}");
        let summary = summary(&root.path().join(name));
        for point in 0..2 {
            let figures = summary["points"][point]["figures"].as_array().unwrap();
            for figure in figures
                .iter()
                .filter(|figure| !figure["prediction"].is_null())
            {
                let name = figure["name"].as_str().unwrap();
                let is_known = [
                    "kT", "mirror", "velocity", "force", "torque", "isotropy", "share",
                ];
                assert!(is_known.iter().any(|known| name.contains(known)), "{name}");
                let value = |key: &str| figure[key].as_f64();
                if let (true, Some(error)) = (name.contains("kT"), value("standard_error")) {
                    let off = (value("value").unwrap() - value("prediction").unwrap()) / error;
                    assert!(off.abs() < 5.0, "{figure}");
                }
            }
            assert!(
                !folder_of(&root.path().join(name), &summary, point)
                    .join("kicks-contact-density-probe.csv")
                    .exists()
            );
        }
    }
    // The molecule has 10 of 133 masses, and momentum is conserved.
    let whole = summary(&root.path().join("mixture"));
    let kt = figure(&whole, 0, "kT along x′, probe")["prediction"]
        .as_f64()
        .unwrap();
    let of_all = figure(&whole, 0, "temperature kT at the end")["value"]
        .as_f64()
        .unwrap();
    assert!((kt / of_all - (1.0 - 10.0 / 133.0)).abs() < 1e-9, "{kt}");
}

/// A molecule that turns among random discs.
#[test]
fn a_billiard_of_several_layouts_is_as_integral_geometry_predicts() {
    let root = tempfile::tempdir().unwrap();
    let words = [
        "billiard",
        "rod:3",
        "--atom-radius",
        "0.01",
        "--moves",
        "molecule",
        "--layout",
        "random",
    ];
    let said = passes(
        root.path(),
        &[&words[..], &["--hits", "200000", "--out", "out"]].concat(),
    );
    assert!(said.contains("12 of 12 expectations are met"), "{said}");
    let summary = summary(&root.path().join("out"));
    assert_eq!(
        (&summary["points_complete"], &summary["title"]),
        (&4.into(), &"Billiard: rod-3".into())
    );
    let path = figure(&summary, 0, "mean free path, target");
    assert!(
        path["smallest_difference"].is_number()
            && path["source"].as_str().unwrap().contains("Santaló")
    );
}

#[test]
fn invalid_molecules_are_refused_and_nothing_is_written() {
    let root = tempfile::tempdir().unwrap();
    fs::write(
        root.path().join("fan.toml"),
        MOLECULE.replace("0.014", "-0.014"),
    )
    .unwrap();
    fs::write(root.path().join("channel.toml"), SCENE).unwrap();
    for (words, expected) in [
        (&["fan.toml"][..], "-0.014"),
        (&["tee"], "--atom-radius"),
        (
            &["tee", "--atom-radius", "0.1", "--side", "0.5"],
            "--side 0.5",
        ),
        (&["channel.toml"], "--body"),
        (&["nothing.toml"], "nothing.toml"),
        (
            &["tee", "--atom-radius", "-1"],
            "positive, finite and between 1e-60 and 1e60, but is -1",
        ),
        (&["tee", "--atom-radius", "1e300"], "but is 1e300"),
        // Found as the bodies are placed.
        (
            &["tee", "--atom-radius", "0.005", "--side", "1e9"],
            "at most 2^27 molecules",
        ),
    ] {
        let output = carom(
            root.path(),
            &[&["brownian"], words, &["--out", "never"]].concat(),
        );
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(expected), "'{said}' lacks '{expected}'");
        assert!(!root.path().join("never").exists());
    }
    let tiny = [
        "billiard",
        "tee",
        "--atom-radius",
        "0.01",
        "--gas-radius",
        "1e-300",
        "--out",
        "never",
    ];
    let output = carom(root.path(), &tiny);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("but is 1e-300"));
    assert!(!root.path().join("never").exists());
}
