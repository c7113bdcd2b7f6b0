//! The software bill of materials of the program: its packages with their sums, licences and
//! dependencies, as CycloneDX 1.5. Maturin writes that of the Python package into the wheel.

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use serde::Deserialize;
use serde_json::{Value, json};

use super::metadata::{Metadata, Package};

/// A lock file, as far as the bill needs it.
#[derive(Debug, Deserialize)]
struct Lock {
    package: Vec<Locked>,
}

#[derive(Debug, Deserialize)]
struct Locked {
    name: String,
    version: String,
    checksum: Option<String>,
}

/// The bill of a program of the workspace, as JSON. `lock` is the text of `Cargo.lock`. It has
/// neither a date nor a serial number, so that the same sources give the same bytes.
///
/// # Errors
/// There is no package of this name, or the lock file cannot be read.
pub fn bill(metadata: &Metadata, program: &str, lock: &str) -> Result<String> {
    let lock: Lock = toml::from_str(lock).context("Cargo.lock")?;
    let sums: BTreeMap<(&str, &str), &str> = lock
        .package
        .iter()
        .filter_map(|package| {
            let sum = package.checksum.as_deref()?;
            Some(((package.name.as_str(), package.version.as_str()), sum))
        })
        .collect();
    let packages = metadata.compiled_into(program)?;
    let (first, others): (Vec<&Package>, Vec<&Package>) =
        packages.iter().partition(|package| package.name == program);
    let first = first
        .first()
        .context("the program is one of its packages")?;
    let libraries: Vec<Value> = others
        .iter()
        .map(|package| component(package, "library", &sums))
        .collect();
    let dependencies: Vec<Value> = packages
        .iter()
        .map(|package| {
            let needed = metadata.dependencies(package);
            let references: Vec<String> = needed.iter().map(|needed| address(needed)).collect();
            json!({ "ref": address(package), "dependsOn": references })
        })
        .collect();
    let bill = json!({
        "$schema": "http://cyclonedx.org/schema/bom-1.5.schema.json",
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": { "component": component(first, "application", &sums) },
        "components": libraries,
        "dependencies": dependencies,
    });
    let text = serde_json::to_string_pretty(&bill).context("a bill is valid JSON")?;
    Ok(text + "\n")
}

/// The address of a package (package URL).
fn address(package: &Package) -> String {
    // Build metadata begins with a plus, which the address must encode.
    let version = package.version.replace('+', "%2B");
    format!("pkg:cargo/{}@{version}", package.name)
}

fn component(package: &Package, kind: &str, sums: &BTreeMap<(&str, &str), &str>) -> Value {
    let mut entry = json!({
        "type": kind,
        "bom-ref": address(package),
        "name": package.name,
        "version": package.version,
        "purl": address(package),
    });
    if let Some(licence) = &package.license {
        // A slash means OR in old manifests.
        let expression = licence.replace('/', " OR ");
        entry["licenses"] = json!([{ "expression": expression }]);
    }
    if let Some(sum) = sums.get(&(package.name.as_str(), package.version.as_str())) {
        entry["hashes"] = json!([{ "alg": "SHA-256", "content": sum }]);
    }
    if let Some(repository) = &package.repository {
        entry["externalReferences"] = json!([{ "type": "vcs", "url": repository }]);
    }
    entry
}

#[cfg(test)]
mod tests {
    use super::*;

    const METADATA: &str = r#"{
        "packages": [
            {"id": "p", "name": "program", "version": "1.0.0", "license": "MIT", "repository": null,
             "manifest_path": "/p", "publish": null, "dependencies": []},
            {"id": "l", "name": "library", "version": "2.0.0+3", "license": "MIT/Zlib",
             "repository": "https://example.org", "manifest_path": "/l", "publish": null,
             "dependencies": []},
            {"id": "t", "name": "test", "version": "1.0.0", "license": "MIT", "repository": null,
             "manifest_path": "/t", "publish": null, "dependencies": []}],
        "workspace_members": ["p"],
        "resolve": {"nodes": [
            {"id": "p", "deps": [{"pkg": "l", "dep_kinds": [{"kind": null}]},
                                 {"pkg": "t", "dep_kinds": [{"kind": "dev"}]}]},
            {"id": "l", "deps": []}, {"id": "t", "deps": []}]},
        "target_directory": "/target"}"#;

    const LOCK: &str = "[[package]]\nname = \"program\"\nversion = \"1.0.0\"\n\n[[package]]\nname = \"library\"\n\
         version = \"2.0.0+3\"\nchecksum = \"ab\"\n";

    #[test]
    fn a_bill_lists_what_is_compiled_with_sums_and_licences() {
        let metadata: Metadata = serde_json::from_str(METADATA).unwrap();
        let text = bill(&metadata, "program", LOCK).unwrap();
        assert_eq!(text, bill(&metadata, "program", LOCK).unwrap());
        let bill: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(
            bill["metadata"]["component"]["purl"],
            "pkg:cargo/program@1.0.0"
        );
        // What tests alone need is not in the program.
        assert_eq!(bill["components"].as_array().unwrap().len(), 1);
        let library = &bill["components"][0];
        assert_eq!(library["purl"], "pkg:cargo/library@2.0.0%2B3");
        assert_eq!(library["licenses"][0]["expression"], "MIT OR Zlib");
        assert_eq!(library["hashes"][0]["content"], "ab");
        assert_eq!(
            bill["dependencies"],
            json!([
                {"ref": "pkg:cargo/library@2.0.0%2B3", "dependsOn": []},
                {"ref": "pkg:cargo/program@1.0.0", "dependsOn": ["pkg:cargo/library@2.0.0%2B3"]},
            ])
        );
        assert!(super::bill(&metadata, "other", LOCK).is_err());
        assert!(super::bill(&metadata, "program", "package = 1").is_err());
    }
}
