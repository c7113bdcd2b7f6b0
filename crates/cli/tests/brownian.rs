//! `carom brownian` as a user calls it, for a molecule of unequal atoms and for a body of a scene.

use std::{
    fs,
    path::Path,
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
    Command::new(program).current_dir(folder).args(arguments).output().expect("the program starts")
}

fn passes(folder: &Path, arguments: &[&str]) -> String {
    let output = carom(folder, arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn summary(folder: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(folder.join("summary.json")).unwrap()).unwrap()
}

fn figure(summary: &Value, name: &str) -> f64 {
    let figures = summary["figures"].as_array().unwrap().iter();
    let found = figures.filter(|figure| figure["name"] == name).collect::<Vec<_>>();
    found.first().unwrap_or_else(|| panic!("no figure '{name}'"))["value"].as_f64().unwrap()
}

#[test]
fn any_molecule_runs_beside_its_control_and_its_run_can_be_extended() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("fan.toml"), MOLECULE).unwrap();
    let fixed = ["brownian", "fan.toml", "--gas-radius", "0.02", "--side", "0.5", "--area-fraction", "0.3"];
    let words = |more: &[&'static str]| [&fixed[..], &["--from", "0.5"], more].concat();
    let said = passes(root.path(), &words(&["--until", "6", "--out", "once"]));
    assert!(said.contains("fan: ") && said.contains("control: "), "{said}");
    let out = root.path().join("once");
    let whole = summary(&out);
    let verdicts = whole["verdicts"].as_array().unwrap();
    assert_eq!((verdicts[0]["name"].as_str(), verdicts[1]["name"].as_str()), (Some("fan"), Some("control")));
    assert!(verdicts[0]["findings"].as_array().unwrap().len() >= 6);
    // The arcs add up to the perimeter, which is longer than that of the control.
    let arcs = fs::read_to_string(out.join("fan-exposed-arcs.csv")).unwrap();
    let length: f64 =
        arcs.lines().skip(1).map(|row| row.rsplit(',').next().unwrap().parse::<f64>().unwrap()).sum();
    let perimeter = figure(&whole, "fan: perimeter of the excluded region");
    assert!((length / perimeter - 1.0).abs() < 1e-12);
    assert!(perimeter > figure(&whole, "control: perimeter of the excluded region"));
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("Brownian motion: fan") && page.contains("exposed angle"));

    // The same in two parts; another gas is refused by its entry.
    passes(root.path(), &words(&["--until", "3", "--out", "parts"]));
    let mut other = [&words(&["--until", "6", "--out", "parts", "--resume"])[..], &[]].concat();
    other[3] = "0.018";
    let refused = carom(root.path(), &other);
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(
        refused.status.code() == Some(2) && said.contains("its gas[0].radius = 0.02 differs from 0.018"),
        "{said}"
    );
    passes(root.path(), &words(&["--until", "6", "--out", "parts", "--resume"]));
    for file in ["fan-0/atoms.csv", "fan-0/running-average.csv", "control-directions.csv"] {
        let read = |folder: &str| fs::read(root.path().join(folder).join(file)).unwrap();
        assert!(read("once") == read("parts"), "{file}");
    }
}

#[test]
fn a_body_of_a_scene_keeps_its_surroundings() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("channel.toml"), SCENE).unwrap();
    let words = ["brownian", "channel.toml", "--body", "probe", "--control", "off", "--out", "out"];
    passes(root.path(), &words);
    let out = root.path().join("out");
    let config: toml::Table = fs::read_to_string(out.join("config.toml")).unwrap().parse().unwrap();
    assert_eq!(config["box"]["sides"][0].as_float(), Some(0.8));
    assert_eq!(config["wall"].as_array().map(Vec::len), Some(1));
    let summary = summary(&out);
    assert_eq!((&summary["simulated_time"], &summary["overlapping_pairs"]), (&2.0.into(), &0.into()));
    assert_eq!(summary["verdicts"][0]["name"], "probe");
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

/// Means vanish and equipartition holds in any surroundings; what has no prediction has none, and
/// the page says so.
#[test]
fn mixtures_have_a_verdict_and_no_predictions_of_one_gas() {
    let root = tempfile::tempdir().unwrap();
    for (name, scene) in [("mixture", MIXTURE), ("drawn", DRAWN)] {
        fs::write(root.path().join(format!("{name}.toml")), scene).unwrap();
        passes(root.path(), &["brownian", &format!("{name}.toml"), "--body", "probe", "--out", name]);
        let out = root.path().join(name);
        let summary = summary(&out);
        for verdict in summary["verdicts"].as_array().unwrap() {
            assert!(verdict["verdict"].as_str().unwrap().starts_with("No bias"), "{verdict}");
        }
        assert_eq!(summary["verdicts"][1]["name"], "control");
        let figures = summary["figures"].as_array().unwrap();
        let predicted = |figure: &&Value| !figure["prediction"].is_null();
        for figure in figures.iter().filter(predicted) {
            let name = figure["name"].as_str().unwrap();
            let value = |key: &str| figure[key].as_f64();
            assert!(name.contains("kT") || name.contains("mirror"), "{name}");
            if let (true, Some(error)) = (name.contains("kT of"), value("standard_error")) {
                let off = (value("value").unwrap() - value("prediction").unwrap()) / error;
                assert!(off.abs() < 5.0, "{figure}");
            }
        }
        let page = fs::read_to_string(out.join("report.html")).unwrap();
        assert!(page.contains("exist for one gas of equal discs only") && !page.contains("contact-density"));
        assert!(!out.join("probe-contact-density.csv").exists());
    }
    // The molecule has 10 of 133 masses, and momentum is conserved.
    let whole = summary(&root.path().join("mixture"));
    let of = |name: &str| {
        let figures = whole["figures"].as_array().unwrap().iter();
        let mut found = figures.filter(|figure| figure["name"] == name);
        found.next().unwrap()["prediction"].as_f64().unwrap()
    };
    let share = of("probe: kT of the molecule along x′") / figure(&whole, "probe: temperature kT");
    assert!((share - (1.0 - 10.0 / 133.0)).abs() < 1e-12, "{share}");
}

#[test]
fn invalid_molecules_are_refused_and_nothing_is_written() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("fan.toml"), MOLECULE.replace("0.014", "-0.014")).unwrap();
    fs::write(root.path().join("channel.toml"), SCENE).unwrap();
    for (words, expected) in [
        (&["fan.toml"][..], "-0.014"),
        (&["tee"], "--atom-radius"),
        (&["tee", "--atom-radius", "0.1", "--side", "0.5"], "--side 0.5"),
        (&["channel.toml"], "--body"),
        (&["nothing.toml"], "nothing.toml"),
        (&["tee", "--atom-radius", "-1"], "positive, finite and between 1e-60 and 1e60, but is -1"),
        (&["tee", "--atom-radius", "1e300"], "but is 1e300"),
        // Found as the bodies are placed.
        (&["tee", "--atom-radius", "0.005", "--side", "1e9"], "at most 2^27 molecules"),
    ] {
        let output = carom(root.path(), &[&["brownian"], words, &["--out", "never"]].concat());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(expected), "'{said}' lacks '{expected}'");
        assert!(!root.path().join("never").exists());
    }
    let tiny = ["billiard", "tee", "--atom-radius", "0.01", "--gas-radius", "1e-300", "--out", "never"];
    let output = carom(root.path(), &tiny);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("but is 1e-300"));
    assert!(!root.path().join("never").exists());
}
