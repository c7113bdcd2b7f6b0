//! The licences of everything that is compiled into the program: a table, and the texts that the
//! packages carry.

use std::{fmt::Write as _, fs, path::Path};

use anyhow::{Context, Result, ensure};

use super::metadata::{Metadata, Package};

/// Beginnings of the names of files with a licence or a notice.
const NAMES: [&str; 5] = ["license", "licence", "copying", "notice", "unlicense"];

/// Writes `licences.md`, and the texts of the licences in a folder for each package. Returns the
/// number of packages of others.
///
/// # Errors
/// A package states no licence, or a file cannot be read or written.
pub fn write(metadata: &Metadata, folder: &Path) -> Result<usize> {
    let packages = metadata.compiled_into("carom-cli")?;
    let others: Vec<&&Package> = packages
        .iter()
        .filter(|package| !metadata.is_member(package))
        .collect();
    let texts = folder.join("licences");
    let mut table = "# Licences of what is compiled into carom\n\n\
                     | package | version | licence | texts | sources |\n\
                     | --- | --- | --- | --- | --- |\n"
        .to_owned();
    for package in &others {
        let (name, version) = (&package.name, &package.version);
        let licence = package.license.as_deref().unwrap_or_default();
        let count = copy(package, &texts.join(format!("{name}-{version}")))?;
        ensure!(
            !licence.is_empty() || count > 0,
            "the package {name} {version} states no licence: replace it, or clarify with its authors"
        );
        let sources = package.repository.as_deref().unwrap_or("–");
        let _ = writeln!(
            table,
            "| {name} | {version} | {licence} | {count} | {sources} |"
        );
    }
    let path = folder.join("licences.md");
    fs::write(&path, table).with_context(|| format!("cannot write {}", path.display()))?;
    Ok(others.len())
}

/// Copies the files with licences of a package; returns how many it has.
fn copy(package: &Package, target: &Path) -> Result<usize> {
    let source = package
        .manifest_path
        .parent()
        .context("a manifest lies in a folder")?;
    let entries =
        fs::read_dir(source).with_context(|| format!("cannot read {}", source.display()))?;
    let mut count = 0;
    for entry in entries {
        let path = entry
            .with_context(|| format!("cannot read {}", source.display()))?
            .path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if !path.is_file() || !is_licence(&name) {
            continue;
        }
        fs::create_dir_all(target)
            .with_context(|| format!("cannot create {}", target.display()))?;
        fs::copy(&path, target.join(&*name))
            .with_context(|| format!("cannot copy {}", path.display()))?;
        count += 1;
    }
    Ok(count)
}

fn is_licence(name: &str) -> bool {
    let name = name.to_lowercase();
    NAMES.iter().any(|beginning| name.starts_with(beginning))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_with_licences_are_known_by_their_names() {
        assert!(["LICENSE-MIT", "COPYING", "Licence.txt", "NOTICE"].map(is_licence) == [true; 4]);
        assert!(["README.md", "lib.rs", "licenses-are.rs"].map(is_licence) == [false, false, true]);
    }
}
