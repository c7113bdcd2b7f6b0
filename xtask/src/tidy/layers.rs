//! Checks the dependencies between layers in the manifests.

use std::{collections::BTreeSet, path::Path};

use anyhow::{Context, Result};
use toml::Table;

use super::{Fault, crates, read};

/// Each crate with its allowed dependencies; `carom` is the facade of the six layers. Detection and
/// response do not import each other. Tables and reports do not import the engine.
const ARROWS: [(&str, &[&str]); 17] = [
    ("geometry", &[]),
    ("kinematics", &["geometry"]),
    ("detection", &["geometry", "kinematics"]),
    ("response", &["geometry", "kinematics"]),
    (
        "engine",
        &["geometry", "kinematics", "detection", "response"],
    ),
    (
        "observers",
        &[
            "geometry",
            "kinematics",
            "detection",
            "response",
            "engine",
            "tables",
        ],
    ),
    (
        "methods",
        &["geometry", "kinematics", "detection", "response", "engine"],
    ),
    ("tables", &[]),
    ("report", &["geometry", "tables"]),
    (
        "runs",
        &[
            "carom",
            "geometry",
            "kinematics",
            "detection",
            "methods",
            "tables",
            "report",
        ],
    ),
    ("sweeps", &["carom", "methods", "tables", "report", "runs"]),
    (
        "experiments",
        &[
            "carom",
            "geometry",
            "kinematics",
            "detection",
            "methods",
            "tables",
            "report",
            "runs",
            "sweeps",
        ],
    ),
    ("live", &["carom", "methods", "tables", "runs"]),
    ("web", &["carom", "live", "methods", "runs"]),
    (
        "cli",
        &["carom", "tables", "runs", "experiments", "sweeps", "live"],
    ),
    (
        "python",
        &[
            "carom",
            "detection",
            "methods",
            "tables",
            "report",
            "runs",
            "sweeps",
        ],
    ),
    (
        "testkit",
        &["carom", "geometry", "kinematics", "detection", "methods"],
    ),
];

/// What the tests of a layer may use besides.
const ARROWS_OF_TESTS: [(&str, &[&str]); 2] =
    [("cli", &["report", "testkit"]), ("live", &["testkit"])];

/// Forbidden dependencies in all manifests.
pub fn faults(root: &Path) -> Result<Vec<Fault>> {
    let mut faults = Vec::new();
    for name in crates(root)? {
        let path = format!("crates/{name}/Cargo.toml");
        let manifest: Table = read(&root.join(&path))?
            .parse()
            .with_context(|| path.clone())?;
        faults.extend(of_layer(&name, &manifest));
    }
    let facade: Table = read(&root.join("Cargo.toml"))?
        .parse()
        .context("Cargo.toml")?;
    faults.extend(of_facade(&facade));
    Ok(faults)
}

/// Imports of the facade besides the six layers; its tests may use runs and testkit.
fn of_facade(manifest: &Table) -> Vec<Fault> {
    let layers: Vec<String> = ARROWS[..6]
        .iter()
        .map(|(name, _)| format!("carom-{name}"))
        .collect();
    let is_wrong = |name: &String, is_for_tests: bool| {
        let is_ours = name == "xtask" || name.starts_with("carom-");
        let may_test = is_for_tests && ["carom-runs", "carom-testkit"].contains(&name.as_str());
        is_ours && !layers.contains(name) && !may_test
    };
    let mut without_tests = manifest.clone();
    without_tests.remove("dev-dependencies");
    let all = dependencies(manifest)
        .into_iter()
        .filter(|name| is_wrong(name, true));
    let normal = dependencies(&without_tests)
        .into_iter()
        .filter(|name| is_wrong(name, false));
    let names: BTreeSet<String> = all.chain(normal).collect();
    names
        .into_iter()
        .map(|name| format!("Cargo.toml: the facade must not import {name}"))
        .collect()
}

/// Forbidden dependencies in the manifest of one layer.
fn of_layer(name: &str, manifest: &Table) -> Vec<Fault> {
    let path = format!("crates/{name}/Cargo.toml");
    let Some((_, allowed)) = ARROWS.iter().find(|(layer, _)| *layer == name) else {
        return vec![format!(
            "{path}: this layer is not in the table of dependencies (xtask/src/tidy/layers.rs)"
        )];
    };
    let package = manifest
        .get("package")
        .and_then(|package| package.get("name"))
        .and_then(|name| name.as_str());
    let mut faults = Vec::new();
    if package != Some(&format!("carom-{name}")) {
        faults.push(format!("{path}: the package must be called carom-{name}"));
    }
    let mut without_tests = manifest.clone();
    without_tests.remove("dev-dependencies");
    let needed = dependencies(&without_tests);
    let tested = ARROWS_OF_TESTS
        .iter()
        .find(|(layer, _)| *layer == name)
        .map_or(&[][..], |(_, more)| more);
    for dependency in dependencies(manifest) {
        let wrong = match dependency.strip_prefix("carom-") {
            Some(layer) if !needed.contains(&dependency) && tested.contains(&layer) => false,
            Some(layer) => !allowed.contains(&layer),
            None if dependency == "carom" => !allowed.contains(&"carom"),
            None => dependency == "xtask",
        };
        if wrong {
            faults.push(format!("{path}: {name} must not import {dependency}"));
        }
    }
    faults
}

/// Names of all packages in the dependencies, dev-dependencies and build dependencies of a
/// manifest, for any system.
fn dependencies(manifest: &Table) -> Vec<String> {
    let kinds = ["dependencies", "dev-dependencies", "build-dependencies"];
    let of = |table: &Table| -> Vec<String> {
        let tables = kinds.iter().filter_map(|kind| table.get(*kind)?.as_table());
        let entries = tables.flat_map(|table| table.iter());
        // `alias = { package = "name" }` imports `name`.
        let name = |(key, value): (&String, &toml::Value)| {
            value
                .get("package")
                .and_then(toml::Value::as_str)
                .unwrap_or(key)
                .to_owned()
        };
        entries.map(name).collect()
    };
    let systems = manifest.get("target").and_then(toml::Value::as_table);
    let of_systems = systems
        .into_iter()
        .flat_map(Table::values)
        .filter_map(toml::Value::as_table)
        .flat_map(of);
    of(manifest).into_iter().chain(of_systems).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults_of(name: &str, dependencies: &str) -> usize {
        let text = format!("[package]\nname = \"carom-{name}\"\n{dependencies}");
        of_layer(name, &text.parse().unwrap()).len()
    }

    #[test]
    fn downward_dependencies_are_allowed() {
        assert_eq!(
            faults_of(
                "engine",
                "[dependencies]\ncarom-detection.workspace = true\nglam = \"0.33\"\n"
            ),
            0
        );
        assert_eq!(
            faults_of(
                "runs",
                "[dependencies]\ncarom.workspace = true\ncarom-report = \"0.1\"\n"
            ),
            0
        );
        assert_eq!(
            faults_of(
                "observers",
                "[dev-dependencies]\ncarom-engine = { path = \"../engine\" }\n"
            ),
            0
        );
    }

    #[test]
    fn the_tests_of_a_layer_may_use_more() {
        assert_eq!(
            faults_of(
                "cli",
                "[dev-dependencies]\ncarom-testkit.workspace = true\n"
            ),
            0
        );
        assert_eq!(
            faults_of("cli", "[dependencies]\ncarom-testkit.workspace = true\n"),
            1
        );
        assert_eq!(
            faults_of(
                "runs",
                "[dev-dependencies]\ncarom-testkit.workspace = true\n"
            ),
            1
        );
    }

    #[test]
    fn upward_and_sideways_dependencies_are_faults() {
        assert_eq!(
            faults_of(
                "geometry",
                "[dependencies]\ncarom-kinematics.workspace = true\n"
            ),
            1
        );
        assert_eq!(
            faults_of(
                "detection",
                "[dependencies]\ncarom-response.workspace = true\n"
            ),
            1
        );
        assert_eq!(
            faults_of(
                "response",
                "[dev-dependencies]\ncarom-detection.workspace = true\n"
            ),
            1
        );
        assert_eq!(
            faults_of(
                "engine",
                "[build-dependencies]\ncarom-observers.workspace = true\n"
            ),
            1
        );
        assert_eq!(
            faults_of(
                "engine",
                "[target.'cfg(unix)'.dependencies]\ncarom-observers.workspace = true\n"
            ),
            1
        );
        assert_eq!(
            faults_of(
                "engine",
                "[dependencies]\nlook = { package = \"carom-observers\" }\n"
            ),
            1
        );
        assert_eq!(
            faults_of("report", "[dependencies]\ncarom-engine.workspace = true\n"),
            1
        );
        assert_eq!(
            faults_of("tables", "[dependencies]\ncarom.workspace = true\n"),
            1
        );
        assert_eq!(
            faults_of(
                "runs",
                "[dev-dependencies]\nxtask = { path = \"../../xtask\" }\n"
            ),
            1
        );
        assert_eq!(
            faults_of(
                "observers",
                "[dependencies]\ncarom.workspace = true\nxtask = \"0\"\n"
            ),
            2
        );
    }

    #[test]
    fn the_facade_imports_the_six_layers_only() {
        let faults = |text: &str| of_facade(&text.parse().unwrap()).len();
        let allowed =
            "[dependencies]\ncarom-engine = \"0.1\"\n[dev-dependencies]\ncarom-testkit = \"0\"\n";
        assert_eq!(faults(allowed), 0);
        assert_eq!(faults("[dependencies]\ncarom-runs = \"0.1\"\n"), 1);
        assert_eq!(faults("[dev-dependencies]\nxtask = \"0\"\n"), 1);
    }

    #[test]
    fn unknown_layers_and_wrong_names_are_faults() {
        assert_eq!(faults_of("plots", ""), 1);
        assert_eq!(
            of_layer("engine", &"[package]\nname = \"engine\"\n".parse().unwrap()).len(),
            1
        );
    }
}
