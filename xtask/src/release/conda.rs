//! The recipe of the conda package, with the sum of the source distribution.

use std::{fs, path::Path};

use anyhow::{Context, Result, ensure};

use super::{copy, create, sum_of, write as write_file};

/// The folder of the recipe in the repository, and the recipe in it.
const FOLDER: &str = "conda";
const RECIPE: &str = "recipe.yaml";

/// The program that tests the package.
const TEST: &str = "first_gas.py";

/// Writes the recipe and its test to a folder, for the source distribution `sources`.
///
/// # Errors
/// The recipe has another version, or no place for a sum, or a file cannot be read or written.
pub fn write(root: &Path, version: &str, sources: &Path, out: &Path) -> Result<()> {
    let path = root.join(FOLDER).join(RECIPE);
    let text =
        fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
    let bytes = fs::read(sources).with_context(|| format!("cannot read {}", sources.display()))?;
    let recipe =
        with_sum(&text, version, &sum_of(&bytes)).with_context(|| format!("{}", path.display()))?;
    create(out)?;
    write_file(&out.join(RECIPE), &recipe)?;
    copy(&root.join(FOLDER).join(TEST), &out.join(TEST))
}

/// A recipe with this sum in the place of its zeros.
fn with_sum(recipe: &str, version: &str, sum: &str) -> Result<String> {
    let line = format!("  version: \"{version}\"\n");
    ensure!(
        recipe.contains(&line),
        "the recipe must have the version {version}: set `context.version`"
    );
    let zeros = "0".repeat(sum.len());
    ensure!(
        recipe.matches(&zeros).count() == 1,
        "the recipe must have one sum of {} zeros, which the sum of the source distribution replaces",
        sum.len()
    );
    Ok(recipe.replace(&zeros, sum))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::repository;

    #[test]
    fn the_recipe_has_the_version_of_the_workspace_and_takes_a_sum() {
        let root = repository::root().unwrap();
        let out = tempfile::tempdir().unwrap();
        let sources = out.path().join("sources.tar.gz");
        fs::write(&sources, "abc").unwrap();
        let folder = out.path().join("conda");
        write(root, carom::VERSION, &sources, &folder).unwrap();
        let recipe = fs::read_to_string(folder.join(RECIPE)).unwrap();
        // An example of FIPS 180-4.
        let sum = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert!(recipe.contains(&format!("sha256: \"{sum}\"")), "{recipe}");
        assert!(folder.join(TEST).is_file());
        let error = format!("{:#}", write(root, "9.9.9", &sources, &folder).unwrap_err());
        assert!(error.contains("must have the version 9.9.9"), "{error}");
        assert!(with_sum("  version: \"1.0.0\"\n", "1.0.0", sum).is_err());
    }
}
