//! The sources and pages of the repository, without build output.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

/// Folders with sources and pages, in addition to the pages at the top.
const FOLDERS: [&str; 4] = ["crates", "xtask", "tests", "benches"];

/// All files in a folder and below with one of these extensions, in alphabetical order.
pub fn with_extensions(folder: &Path, extensions: &[&str]) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        if !folder.is_dir() {
            continue;
        }
        let entries = std::fs::read_dir(&folder)
            .with_context(|| format!("cannot read the folder {}", folder.display()))?;
        for entry in entries {
            let path = entry?.path();
            if path.is_dir() && !path.ends_with("target") {
                folders.push(path);
            } else if path
                .extension()
                .and_then(|extension| extension.to_str())
                .is_some_and(|extension| extensions.contains(&extension))
            {
                found.push(path);
            }
        }
    }
    found.sort();
    Ok(found)
}

/// All Rust sources and Markdown pages, as paths from the root.
pub fn text_files(root: &Path) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for folder in FOLDERS {
        found.extend(with_extensions(&root.join(folder), &["rs", "md"])?);
    }
    for entry in std::fs::read_dir(root).context("cannot read the folder of the repository")? {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "md") {
            found.push(path);
        }
    }
    found.sort();
    Ok(found
        .into_iter()
        .map(|path| from_root(root, path))
        .collect())
}

/// All manifests, scenes, settings of cargo, and scripts, as paths from the root.
pub fn configuration_files(root: &Path) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for folder in FOLDERS {
        found.extend(with_extensions(&root.join(folder), &["toml"])?);
    }
    for folder in ["", ".cargo", ".ci"] {
        let path = root.join(folder);
        if !path.is_dir() {
            continue;
        }
        let entries = std::fs::read_dir(&path)
            .with_context(|| format!("cannot read the folder {}", path.display()))?;
        for entry in entries {
            let path = entry?.path();
            let is_script = folder == ".ci" && path.is_file();
            if is_script
                || path
                    .extension()
                    .is_some_and(|extension| extension == "toml")
            {
                found.push(path);
            }
        }
    }
    found.sort();
    Ok(found
        .into_iter()
        .map(|path| from_root(root, path))
        .collect())
}

fn from_root(root: &Path, path: PathBuf) -> PathBuf {
    path.strip_prefix(root).map(Path::to_owned).unwrap_or(path)
}

/// All Rust sources, as paths from the root.
pub fn sources(root: &Path) -> Result<Vec<PathBuf>> {
    let files = text_files(root)?.into_iter();
    Ok(files
        .filter(|path| path.extension().is_some_and(|extension| extension == "rs"))
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn manifests_scenes_settings_and_scripts_are_found() {
        let root = tempfile::tempdir().unwrap();
        let files = [
            "Cargo.toml",
            "LICENSE",
            ".ci/run",
            ".cargo/config.toml",
            "xtask/scenes/a.toml",
            "xtask/a.rs",
        ];
        for file in files {
            let path = root.path().join(file);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, "").unwrap();
        }
        let found = configuration_files(root.path()).unwrap();
        let expected = [
            ".cargo/config.toml",
            ".ci/run",
            "Cargo.toml",
            "xtask/scenes/a.toml",
        ];
        assert_eq!(found, expected.map(PathBuf::from));
    }
}
