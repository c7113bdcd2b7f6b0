//! The build of the module.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

use anyhow::{Context, Result, ensure};
use carom_runs::print_line;

use crate::repository::{self, Shell};

/// The target of the compiler.
const TARGET: &str = "wasm32-unknown-unknown";

/// The profile of cargo.
const PROFILE: &str = "web";

/// Registers of 128 bits, which all browsers have had since 2023. Without them the kernels are
/// seven times slower.
const FLAGS: &str = "-C target-feature=+simd128";

/// The result of a build.
#[derive(Debug)]
pub enum Module {
    /// The path of the module.
    Built(PathBuf),
    /// The toolchain lacks this.
    Missing(String),
}

/// Where the standard library of the target comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum StandardLibrary {
    /// It is installed.
    Installed,
    /// It is compiled from its sources.
    FromSource,
}

impl StandardLibrary {
    /// That of the compiler in use; `None` without either.
    fn find(sysroot: &Path) -> Option<Self> {
        let lib = sysroot.join("lib/rustlib");
        if has_core(&lib.join(TARGET).join("lib")) {
            Some(Self::Installed)
        } else if lib.join("src/rust/library/Cargo.lock").exists() {
            Some(Self::FromSource)
        } else {
            None
        }
    }
}

/// Whether a folder holds a compiled core library.
fn has_core(folder: &Path) -> bool {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries
        .map(|entry| entry.file_name())
        .any(|name| name.to_string_lossy().starts_with("libcore-"))
}

/// Builds the module.
///
/// # Errors
/// The compiler cannot be started, or refuses the sources.
pub fn module(root: &Path) -> Result<Module> {
    let sysroot = Shell { root }.output("rustc", &["--print", "sysroot"])?;
    let Some(library) = StandardLibrary::find(Path::new(sysroot.trim())) else {
        return Ok(Module::Missing(format!(
            "the compiler lacks the target {TARGET}; `rustup target add {TARGET}` installs it, \
                 and on Debian 12 the packages rustc-web, cargo-web, rust-web-src and lld-22 do"
        )));
    };
    print_line(match library {
        StandardLibrary::Installed => "web: with the installed standard library of the target",
        StandardLibrary::FromSource => "web: with the standard library compiled from its sources",
    });
    // Other flags must not compile the crates of this machine anew.
    let folder = repository::target_folder()?.join("wasm");
    let mut cargo = Command::new("cargo");
    cargo
        .current_dir(root)
        .env("RUSTFLAGS", FLAGS)
        .env_remove("CARGO_ENCODED_RUSTFLAGS")
        .args(["build", "--quiet", "--package", "carom-web", "--lib"])
        .args(["--profile", PROFILE, "--target", TARGET, "--target-dir"])
        .arg(&folder)
        .stdin(Stdio::null());
    if library == StandardLibrary::FromSource {
        // The option is of the nightly compiler; the variable lets a stable one take it.
        cargo
            .env("RUSTC_BOOTSTRAP", "1")
            .args(["-Z", "build-std=std,panic_abort"]);
    }
    let status = cargo.status().context("cannot start cargo")?;
    ensure!(
        status.success(),
        "the module cannot be built: cargo: {status}"
    );
    let built = folder.join(TARGET).join(PROFILE).join("carom_web.wasm");
    Ok(Module::Built(built))
}

/// The size of a file compressed as servers do it (bytes); `None` without gzip.
///
/// # Errors
/// gzip fails.
pub fn compressed_size(path: &Path) -> Result<Option<u64>> {
    if !repository::has_program("gzip") {
        return Ok(None);
    }
    let output = Command::new("gzip")
        .args(["-9", "--stdout"])
        .arg(path)
        .stdin(Stdio::null())
        .output()
        .context("cannot start gzip")?;
    ensure!(output.status.success(), "gzip: {}", output.status);
    Ok(Some(output.stdout.len() as u64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_installed_library_is_taken_before_its_sources() {
        let root = tempfile::tempdir().unwrap();
        let find = || StandardLibrary::find(root.path());
        let create = |path: &str| {
            let path = root.path().join("lib/rustlib").join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        };
        assert_eq!(find(), None);
        create("src/rust/library/Cargo.lock");
        assert_eq!(find(), Some(StandardLibrary::FromSource));
        create("wasm32-unknown-unknown/lib/libcore-1.rlib");
        assert_eq!(find(), Some(StandardLibrary::Installed));
    }
}
