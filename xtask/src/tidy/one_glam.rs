//! Checks that the dependency graph has one version of glam: parry exposes its vectors, and two
//! versions would be two vector types.

use anyhow::{Context, Result};
use toml::{Table, Value};

use super::Fault;

/// Faults of a lock file.
pub fn faults(lock: &str) -> Result<Vec<Fault>> {
    let lock: Table = lock.parse().context("Cargo.lock")?;
    let packages = lock
        .get("package")
        .and_then(Value::as_array)
        .context("Cargo.lock lists no packages")?;
    let text =
        |package: &Value, key: &str| package.get(key).and_then(Value::as_str).map(str::to_owned);
    let versions: Vec<String> = packages
        .iter()
        .filter(|package| text(package, "name").as_deref() == Some("glam"))
        .filter_map(|package| text(package, "version"))
        .collect();
    Ok(match versions.len() {
        1 => Vec::new(),
        count => vec![format!(
            "Cargo.lock: there must be one glam, but there are {count}: {}",
            versions.join(", ")
        )],
    })
}

#[cfg(test)]
mod tests {
    use super::faults;

    fn lock(versions: &[&str]) -> String {
        let package =
            |version: &&str| format!("[[package]]\nname = \"glam\"\nversion = \"{version}\"\n");
        let others = "[[package]]\nname = \"glamx\"\nversion = \"0.3.1\"\n";
        versions.iter().map(package).collect::<String>() + others
    }

    #[test]
    fn exactly_one_version_is_right() {
        assert!(faults(&lock(&["0.33.12"])).unwrap().is_empty());
        assert_eq!(faults(&lock(&["0.33.12", "0.30.0"])).unwrap().len(), 1);
        assert_eq!(faults(&lock(&[])).unwrap().len(), 1);
        assert!(faults("not a lock file").is_err());
    }
}
