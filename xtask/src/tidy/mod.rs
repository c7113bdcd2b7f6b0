//! `cargo xtask tidy`: checks of the repository beyond those of the compiler.

mod commands;
mod cycles;
mod files;
mod first_lines;
mod layers;
mod licences;
mod links;
mod map;
mod names;
mod one_glam;
mod test_programs;
mod width;
mod words;

use std::path::Path;

use anyhow::{Context, Result};
use carom_runs::print_line;
use carom_tables::Verdict;

use crate::{
    release::{machine, metadata::Metadata},
    repository::{self, Shell},
};

/// Description of a violation.
type Fault = String;

/// Runs all checks on the repository from which the program was built.
///
/// # Errors
/// A file cannot be read.
pub fn run(parse: commands::Parse) -> Result<Verdict> {
    let root = repository::root()?;
    let faults = faults(root, parse)?;
    for fault in &faults {
        print_line(fault);
    }
    if faults.is_empty() {
        print_line(
            "tidy: layers, cycles, first lines, names, width, words, commands and links in Markdown, one glam, \
             licences of dependencies, test programs, map of the crates",
        );
        Ok(Verdict::Passed)
    } else {
        print_line(&format!("tidy: {} faults", faults.len()));
        Ok(Verdict::Failed)
    }
}

/// All faults of a repository.
///
/// # Errors
/// A file cannot be read.
pub fn faults(root: &Path, parse: commands::Parse) -> Result<Vec<Fault>> {
    let mut faults = layers::faults(root)?;
    faults.extend(first_lines::faults(root)?);
    faults.extend(commands::faults(root, parse)?);
    faults.extend(one_glam::faults(&read(&root.join("Cargo.lock"))?)?);
    let shell = Shell { root };
    let metadata = Metadata::read(shell, &machine(shell)?)?;
    faults.extend(licences::faults(
        &metadata,
        &read(&root.join("deny.toml"))?,
    )?);
    faults.extend(links::faults(root)?);
    faults.extend(map::faults(root)?);
    faults.extend(cycles::faults(root)?);
    faults.extend(names::faults(root)?);
    faults.extend(test_programs::faults(root)?);
    faults.extend(width::faults(root)?);
    faults.extend(words::faults(root)?);
    Ok(faults)
}

fn read(path: &Path) -> Result<String> {
    std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))
}

/// Names of the folders in `crates`, each a layer, in alphabetical order.
fn crates(root: &Path) -> Result<Vec<String>> {
    let mut names = Vec::new();
    for entry in std::fs::read_dir(root.join("crates")).context("cannot read the folder crates")? {
        let path = entry?.path();
        if path.join("Cargo.toml").is_file()
            && let Some(name) = path.file_name()
        {
            names.push(name.to_string_lossy().into_owned());
        }
    }
    names.sort();
    Ok(names)
}
