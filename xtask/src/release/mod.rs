//! `cargo xtask release`: everything that a release would upload, in one folder, with its checksums
//! and the commands that upload it. Nothing is uploaded.

mod changes;
mod citation;
mod conda;
mod licences;
pub(crate) mod metadata;
mod sbom;

use std::{
    collections::BTreeMap,
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result, ensure};
use carom_runs::print_line;
use carom_tables::Verdict;
use clap::Args;
use sha2::{Digest as _, Sha256};

use crate::repository::{self, Shell};
use metadata::{Metadata, Package};

/// Options of `cargo xtask release`.
#[derive(Debug, Clone, Args)]
pub struct ReleaseOptions {
    /// Folder of the release; it must be new or empty
    #[arg(long, value_name = "FOLDER", default_value = "target/release-files")]
    pub out: PathBuf,
    /// Also from sources that differ from the last commit, as a trial
    #[arg(long)]
    pub allow_dirty: bool,
    /// Also install the program from the packaged crates in an empty folder, which compiles all of
    /// them anew
    #[arg(long)]
    pub install: bool,
}

/// Parts of a release that cannot be made here, in words.
type Skipped = Vec<String>;

/// Writes all files of a release.
///
/// # Errors
/// The sources have changes, the citation files do not fit the version, a package has no licence, a
/// program fails, or a file cannot be written.
pub fn run(options: &ReleaseOptions) -> Result<Verdict> {
    let root = repository::root()?;
    let shell = Shell { root };
    let is_changed = has_changes(shell)?;
    ensure!(
        !is_changed || options.allow_dirty,
        "the sources differ from the last commit: commit them, or make a trial with --allow-dirty"
    );
    let folder = new_folder(&options.out)?;
    let machine = machine(shell)?;
    let metadata = Metadata::read(shell, &machine)?;
    let crates = metadata.published()?;
    let version = &crates.first().context("nothing is published")?.version;
    citation::check(root, version)?;
    let mut skipped = Skipped::new();
    if is_changed {
        skipped.push("a release proper: the sources differ from the last commit".to_owned());
    }
    write_changes(root, version, &folder, &mut skipped)?;
    package(shell, &metadata, &crates, &folder.join("crates"))?;
    let inside = folder.join(format!("carom-{version}-{machine}"));
    binary(shell, &metadata, (version, &machine), &inside, &mut skipped)?;
    let has_wheel = python(shell, &machine, &folder.join("python"), &mut skipped)?;
    if has_wheel {
        let sources = format!("carom-{version}.tar.gz");
        conda::write(
            root,
            version,
            &folder.join("python").join(sources),
            &folder.join("conda"),
        )?;
    }
    write_licences(root, &metadata, version, &folder)?;
    if options.install {
        install(shell, &crates, &folder)?;
        if has_wheel {
            install_wheel(shell, &folder)?;
        }
    } else {
        skipped.push("the installation in an empty folder: --install does it".to_owned());
    }
    let files = checksums(&folder)?;
    let commands = commands(version, &crates, &skipped, &folder);
    write(&folder.join("COMMANDS.md"), &commands)?;
    print_line(&format!("release: {files} files with checksums"));
    for part in &skipped {
        print_line(&format!("release: skipped: {part}"));
    }
    print_line(&format!("release: {}\n\n{commands}", folder.display()));
    Ok(Verdict::Passed)
}

/// Whether the sources differ from the last commit.
fn has_changes(shell: Shell<'_>) -> Result<bool> {
    let changed = shell.output("git", &["status", "--porcelain"])?;
    Ok(!changed.is_empty())
}

/// Creates the folder of the release and returns its absolute path.
///
/// # Errors
/// It is not empty, or cannot be created.
fn new_folder(path: &Path) -> Result<PathBuf> {
    let folder = std::path::absolute(path).context("the current folder is unknown")?;
    let is_new = fs::read_dir(&folder).map_or(true, |mut entries| entries.next().is_none());
    ensure!(
        is_new,
        "{} is not empty: choose another folder with --out, or remove it",
        folder.display()
    );
    create(&folder)?;
    Ok(folder)
}

/// Writes the licences of all packages, their list as a bill of materials, and the files on how to
/// use and cite the program.
fn write_licences(root: &Path, metadata: &Metadata, version: &str, folder: &Path) -> Result<()> {
    let count = licences::write(metadata, folder)?;
    print_line(&format!("release: licences of {count} packages"));
    let lock = root.join("Cargo.lock");
    let lock =
        fs::read_to_string(&lock).with_context(|| format!("cannot read {}", lock.display()))?;
    let bill = sbom::bill(metadata, "carom-cli", &lock)?;
    write(&folder.join(format!("carom-{version}.cdx.json")), &bill)?;
    for name in [
        "LICENSE-MIT",
        "LICENSE-APACHE",
        "CITATION.cff",
        "codemeta.json",
    ] {
        copy(&root.join(name), &folder.join(name))?;
    }
    Ok(())
}

fn create(folder: &Path) -> Result<()> {
    fs::create_dir_all(folder).with_context(|| format!("cannot create {}", folder.display()))
}

fn write(path: &Path, text: &str) -> Result<()> {
    fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}

fn copy(from: &Path, to: &Path) -> Result<()> {
    fs::copy(from, to)
        .with_context(|| format!("cannot copy {} to {}", from.display(), to.display()))
        .map(drop)
}

/// The changelog's section of this version, as the text of the release.
fn write_changes(root: &Path, version: &str, folder: &Path, skipped: &mut Skipped) -> Result<()> {
    let path = root.join("CHANGELOG.md");
    let text =
        fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
    let (section, is_unreleased) = changes::section(&text, version)?;
    if is_unreleased {
        skipped.push(format!(
            "the date of the release: CHANGELOG.md has [Unreleased] in the place of [{version}]"
        ));
    }
    write(&folder.join("changes.md"), &format!("{section}\n"))
}

/// Packages all crates that are published, without building them.
fn package(shell: Shell<'_>, metadata: &Metadata, crates: &[&Package], out: &Path) -> Result<()> {
    let mut arguments: Vec<String> = ["package", "--no-verify", "--locked", "--offline"]
        .map(str::to_owned)
        .into();
    arguments.extend(["--quiet", "--allow-dirty"].map(str::to_owned));
    for package in crates {
        arguments.extend(["--package".to_owned(), package.name.clone()]);
    }
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    shell.succeed("cargo", &words)?;
    create(out)?;
    for package in crates {
        let name = archive(package);
        copy(
            &metadata.target_directory.join("package").join(&name),
            &out.join(&name),
        )?;
    }
    print_line(&format!("release: {} crates are packaged", crates.len()));
    Ok(())
}

/// The file name of a packaged crate.
fn archive(package: &Package) -> String {
    format!("{}-{}.crate", package.name, package.version)
}

/// The machine for which programs are compiled here, such as `x86_64-unknown-linux-gnu`.
///
/// # Errors
/// The compiler cannot be started, or writes something else.
pub(crate) fn machine(shell: Shell<'_>) -> Result<String> {
    let compiler = shell.output("rustc", &["--version", "--verbose"])?;
    let line = compiler
        .lines()
        .find_map(|line| line.strip_prefix("host: "));
    line.map(str::to_owned)
        .context("rustc does not say for which machine it compiles")
}

/// Version of the C library with which programs for Linux run: that of systems since 2014.
const OLDEST_GLIBC: &str = "2.17";

/// Whether programs for an older C library than that of this machine can be linked here, by zig.
fn has_zig(shell: Shell<'_>, machine: &str) -> bool {
    let is_installed = || {
        repository::has_program("zig")
            || shell
                .output("python3", &["-m", "ziglang", "version"])
                .is_ok()
    };
    machine.ends_with("linux-gnu") && is_installed()
}

/// Builds the program for this machine, with an old C library where that is possible, and checks
/// that it tells this version.
fn binary(
    shell: Shell<'_>,
    metadata: &Metadata,
    (version, machine): (&str, &str),
    inside: &Path,
    skipped: &mut Skipped,
) -> Result<()> {
    let options = [
        "--release",
        "--locked",
        "--offline",
        "--package",
        "carom-cli",
    ];
    let built = if has_zig(shell, machine) && repository::has_program("cargo-zigbuild") {
        let target = format!("{machine}.{OLDEST_GLIBC}");
        let words = [&["zigbuild"][..], &options, &["--target", &target]].concat();
        shell.succeed("cargo", &words)?;
        metadata.target_directory.join(machine).join("release")
    } else {
        if machine.ends_with("linux-gnu") {
            skipped.push(format!(
                "a program for glibc {OLDEST_GLIBC}: it takes zig and cargo-zigbuild; the program needs the C \
                 library of this machine"
            ));
        }
        shell.succeed("cargo", &[&["build"][..], &options].concat())?;
        metadata.target_directory.join("release")
    };
    let name = format!("carom{}", std::env::consts::EXE_SUFFIX);
    create(inside)?;
    let target = inside.join(&name);
    copy(&built.join(&name), &target)?;
    let told = shell.output(&target.to_string_lossy(), &["--version"])?;
    ensure!(
        told.starts_with(&format!("carom {version} ")),
        "{} calls itself {told}, not {version}",
        target.display()
    );
    print_line(&format!("release: {}", told.trim()));
    Ok(())
}

/// Builds wheel and source distribution, if that is possible here; returns whether it was.
fn python(shell: Shell<'_>, machine: &str, out: &Path, skipped: &mut Skipped) -> Result<bool> {
    if !repository::has_program("maturin") {
        skipped.push("wheel and source distribution: maturin is not installed".to_owned());
        return Ok(false);
    }
    // In wheels glibc 2.17 is manylinux2014; maturin refuses a wheel that needs more.
    let old: &[&str] = if has_zig(shell, machine) {
        &["--zig", "--compatibility", "manylinux2014"]
    } else {
        skipped.push(format!(
            "a wheel for glibc {OLDEST_GLIBC}: zig is not installed, so that it is for this machine"
        ));
        &[]
    };
    create(out)?;
    let manifest = ["--manifest-path", "crates/python/Cargo.toml"];
    let target = ["--out", &out.to_string_lossy()].map(str::to_owned);
    let target: Vec<&str> = target.iter().map(String::as_str).collect();
    let build = [&["build", "--release", "--locked"][..], old].concat();
    for words in [&build[..], &["sdist"]] {
        shell.succeed("maturin", &[words, &manifest[..], &target[..]].concat())?;
    }
    Ok(true)
}

/// A first gas, in an environment that has nothing else.
const FIRST_GAS: &str = "import carom\n\
     sim = carom.Simulation({'gas': [{'radius': 0.02, 'mass': 1, 'energy': 1, 'count': 50}]})\n\
     pressure = sim.measure('pressure', every=0.1)\n\
     sim.run(until=2)\n\
     print(carom.__version__, pressure.figures['pressure'])";

/// Installs the wheel in an empty environment and runs a first gas there.
fn install_wheel(shell: Shell<'_>, folder: &Path) -> Result<()> {
    let empty = tempfile::tempdir().context("cannot create an empty folder")?;
    let environment = empty.path().join("environment");
    shell.succeed("python3", &["-m", "venv", &environment.to_string_lossy()])?;
    let program = |name: &str| {
        environment
            .join("bin")
            .join(name)
            .to_string_lossy()
            .into_owned()
    };
    let wheels = fs::read_dir(folder.join("python")).context("no folder of wheels")?;
    let is_wheel = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "whl");
    let mut paths = wheels.flatten().map(|entry| entry.path());
    let wheel = paths.find(is_wheel).context("there is no wheel")?;
    shell.succeed(
        &program("pip"),
        &["install", "--quiet", &wheel.to_string_lossy()],
    )?;
    let told = shell.output(&program("python"), &["-c", FIRST_GAS])?;
    print_line(&format!(
        "release: installed from the wheel: {}",
        told.trim()
    ));
    Ok(())
}

/// Unpacks all crates in an empty folder and installs the program from them, so that nothing comes
/// from the repository. Dependencies of others come from the local cache.
fn install(shell: Shell<'_>, crates: &[&Package], folder: &Path) -> Result<()> {
    let empty = tempfile::tempdir().context("cannot create an empty folder")?;
    let inside = Shell { root: empty.path() };
    let mut arguments: Vec<String> = ["install", "--offline", "--root", "installed"]
        .map(str::to_owned)
        .into();
    for package in crates {
        let archive = folder.join("crates").join(archive(package));
        inside.succeed("tar", &["-xzf", &archive.to_string_lossy()])?;
        let unpacked = format!("{}-{}", package.name, package.version);
        let patch = format!("patch.crates-io.{}.path=\"{unpacked}\"", package.name);
        arguments.extend(["--config".to_owned(), patch]);
        if package.name == "carom-cli" {
            arguments.extend(["--path".to_owned(), unpacked]);
        }
    }
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    inside.succeed("cargo", &words)?;
    let program = empty.path().join("installed/bin/carom");
    let told = shell.output(&program.to_string_lossy(), &["--version"])?;
    print_line(&format!(
        "release: installed from the packaged crates: {}",
        told.trim()
    ));
    Ok(())
}

/// The SHA-256 checksum of some bytes, in hexadecimal digits.
fn sum_of(bytes: &[u8]) -> String {
    Sha256::digest(bytes)
        .iter()
        .fold(String::new(), |mut text, byte| {
            let _ = write!(text, "{byte:02x}");
            text
        })
}

/// Writes the SHA-256 checksums of all files in `SHA256SUMS`; returns their number.
fn checksums(folder: &Path) -> Result<usize> {
    let mut sums = BTreeMap::new();
    let mut open = vec![folder.to_owned()];
    while let Some(inner) = open.pop() {
        let context = || format!("cannot read {}", inner.display());
        for entry in fs::read_dir(&inner).with_context(context)? {
            let path = entry.with_context(context)?.path();
            if path.is_dir() {
                open.push(path);
                continue;
            }
            let bytes =
                fs::read(&path).with_context(|| format!("cannot read {}", path.display()))?;
            let name = path
                .strip_prefix(folder)?
                .to_string_lossy()
                .replace('\\', "/");
            sums.insert(name, sum_of(&bytes));
        }
    }
    let lines: String = sums.iter().fold(String::new(), |text, (name, sum)| {
        text + sum + "  " + name + "\n"
    });
    write(&folder.join("SHA256SUMS"), &lines)?;
    Ok(sums.len())
}

/// The commands that an owner with accounts gives to publish this release.
fn commands(version: &str, crates: &[&Package], skipped: &[String], folder: &Path) -> String {
    let names: Vec<String> = crates
        .iter()
        .map(|package| format!("cargo publish --locked --package {}", package.name))
        .collect();
    let missing = skipped
        .iter()
        .fold(String::new(), |text, part| text + "- " + part + "\n");
    let missing = if missing.is_empty() {
        "Nothing was skipped.\n".to_owned()
    } else {
        format!("This folder lacks:\n\n{missing}")
    };
    format!(
        "# Publishing carom {version}\n\n{missing}\n\
         In the repository, at the commit of the release, with accounts:\n\n```sh\n\
         git tag --sign v{version} --message 'carom {version}' && git push origin v{version}\n\
         {}\n\
         maturin upload {}/python/*\n\
         cargo xtask site && rsync --archive --delete target/site/ \"$SITE\"\n```\n\n\
         Then attach this folder to the tag `v{version}` with `changes.md` as its text, and deposit \
         it where it gets a DOI; enter the DOI in `CITATION.cff` and `codemeta.json`.\n",
        names.join("\n"),
        folder.display()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_files_have_checksums_that_other_programs_verify() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("inner")).unwrap();
        fs::write(folder.path().join("inner/empty"), "").unwrap();
        fs::write(folder.path().join("abc"), "abc").unwrap();
        assert_eq!(checksums(folder.path()).unwrap(), 2);
        // The examples of FIPS 180-4.
        assert_eq!(
            fs::read_to_string(folder.path().join("SHA256SUMS")).unwrap(),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad  abc\n\
             e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855  inner/empty\n"
        );
    }
}
