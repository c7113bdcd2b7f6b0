//! Passes the version of the compiler and the revision of the sources to this crate, for the
//! manifest of each run, and lists the studies that it carries.

use std::{
    env,
    fmt::Write as _,
    fs, io,
    path::{Path, PathBuf},
    process::Command,
};

fn main() {
    let compiler = env::var("RUSTC").unwrap_or_else(|_| "rustc".into());
    let version = output(&compiler, &["--version"]).unwrap_or_else(|| "unknown".to_owned());
    println!("cargo::rustc-env=CAROM_RUSTC_VERSION={version}");
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=CAROM_REVISION");
    let given = env::var("CAROM_REVISION").ok();
    let revision = given.or_else(revision);
    if let Some(revision) = &revision {
        println!("cargo::rustc-env=CAROM_REVISION={revision}");
    }
    let package = env::var("CARGO_PKG_VERSION").unwrap_or_default();
    let revision = revision.map_or_else(String::new, |revision| format!("revision {revision}, "));
    println!("cargo::rustc-env=CAROM_BUILD={package} ({revision}{version})");
    if let Err(error) = list_studies() {
        println!("cargo::error=the studies in {STUDIES} cannot be listed: {error}");
    }
}

/// Folder of the studies that are compared with theory, relative to this crate.
const STUDIES: &str = "examples/theory";

/// Writes the studies of the folder as an array of examples, in the order of their names, which
/// are their paths: `fields/blast`.
fn list_studies() -> io::Result<()> {
    println!("cargo::rerun-if-changed={STUDIES}");
    let variable = |name: &str| env::var(name).map_err(io::Error::other);
    let folder = PathBuf::from(variable("CARGO_MANIFEST_DIR")?).join(STUDIES);
    let mut names = Vec::new();
    collect_studies(&folder, "", &mut names)?;
    names.sort();
    let mut text = "[\n".to_owned();
    for name in names {
        let path = folder.join(format!("{name}.toml"));
        let path = path
            .to_str()
            .ok_or_else(|| io::Error::other("a path is not UTF-8"))?;
        let _ = writeln!(
            text,
            "    Example {{ name: {name:?}, command: \"sweep\", text: include_str!({path:?}) }},"
        );
    }
    text.push_str("]\n");
    fs::write(PathBuf::from(variable("OUT_DIR")?).join("studies.rs"), text)
}

/// Adds the names of the studies in a folder and those inside it.
fn collect_studies(folder: &Path, prefix: &str, names: &mut Vec<String>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let Some(stem) = path.file_stem().and_then(|stem| stem.to_str()) else {
            continue;
        };
        if path.is_dir() {
            collect_studies(&path, &format!("{prefix}{stem}/"), names)?;
        } else if path.extension().is_some_and(|ending| ending == "toml") {
            names.push(format!("{prefix}{stem}"));
        }
    }
    Ok(())
}

/// Returns what a program writes, if it succeeds and writes anything.
fn output(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    (output.status.success() && !text.trim().is_empty()).then(|| text.trim().to_owned())
}

/// Returns the commit of the workspace, with `-dirty` if files differ from it; `None` outside of a
/// repository of its own, such as in a package from a registry.
fn revision() -> Option<String> {
    let crate_folder = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR")?);
    let root = fs::canonicalize(crate_folder.join("../..")).ok()?;
    let shown = root.to_str()?;
    let git = |arguments: &[&str]| output("git", &[&["-C", shown], arguments].concat());
    let repository = git(&["rev-parse", "--show-toplevel"])?;
    if fs::canonicalize(repository).ok()? != root {
        return None;
    }
    // The first changes with the branch, the second with each commit.
    for name in ["HEAD", "logs/HEAD"] {
        if let Some(path) = git(&["rev-parse", "--git-path", name]) {
            watch(&root.join(path));
        }
    }
    watch_sources(&root);
    git(&["describe", "--always", "--dirty", "--abbrev=40"])
}

/// Runs this script again when a source changes that may make the revision dirty. In a debug build
/// only the sources of this crate count: otherwise each change of any crate would compile this one
/// again.
fn watch_sources(root: &Path) {
    if env::var("PROFILE").is_ok_and(|profile| profile == "debug") {
        watch(&root.join("crates/runs/src"));
        return;
    }
    for name in ["Cargo.toml", "Cargo.lock", "xtask/src"] {
        watch(&root.join(name));
    }
    for entry in fs::read_dir(root.join("crates"))
        .into_iter()
        .flatten()
        .flatten()
    {
        for name in ["Cargo.toml", "build.rs", "src"] {
            watch(&entry.path().join(name));
        }
    }
}

/// Runs this script again when a file or a folder changes. One that is missing would always count
/// as changed.
fn watch(path: &Path) {
    if path.exists() {
        println!("cargo::rerun-if-changed={}", path.display());
    }
}
