//! `cargo xtask web`: the laboratory of `carom live` as static pages, with the engine in
//! WebAssembly, and its comparison with this machine.

mod build;
mod comparison;
mod scenes;

use std::{
    env,
    fs::{self, OpenOptions},
    io::Write as _,
    path::{Path, PathBuf},
};

use anyhow::{Context, Result};
use base64::{Engine as _, engine::general_purpose::STANDARD};
use carom_live::{EXHIBITS, PageEngine, page, thumbnail};
use carom_runs::{console::put, print_line};
use carom_tables::Verdict;
use clap::Args;

use crate::repository;
use build::Module;

/// Largest size of the compressed module (bytes): a page must load within seconds.
const MAX_SIZE: u64 = 3_000_000;

/// The script of the worker.
const WORKER: &str = include_str!("../../../crates/web/src/worker.js");

/// Options of `cargo xtask web`.
#[derive(Debug, Clone, Args)]
pub struct WebOptions {
    /// Folder of the pages
    #[arg(long, value_name = "FOLDER", default_value = "target/web")]
    pub out: PathBuf,
    /// Run scenes in the module, under node, and compare all bits with this machine
    #[arg(long)]
    pub check: bool,
    /// Measure first motion and collisions a second under node, and those of this build
    #[arg(long)]
    pub speed: bool,
}

/// Builds the module and writes the pages; [`Verdict::Failed`] if the module is too large or bits
/// differ. Without the compiler's target, or without node, what is missing is printed, and nothing
/// has failed.
///
/// # Errors
/// The build fails, or a file cannot be written.
pub fn run(options: &WebOptions) -> Result<Verdict> {
    let Some(module) = pages(&options.out)? else {
        return Ok(Verdict::Passed);
    };
    let size = build::compressed_size(&module)?;
    let raw = fs::metadata(&module).context("the module")?.len();
    print_line(&match size {
        Some(size) => format!("web: carom.wasm: {raw} bytes, compressed by gzip {size}"),
        None => format!("web: carom.wasm: {raw} bytes; gzip is not installed"),
    });
    let index = options.out.join("index.html");
    put("page", &index);
    print_line(&format!("web: {}", index.display()));
    if size.unwrap_or(raw) > MAX_SIZE {
        print_line(&format!(
            "web: FAILED: the module has more than {MAX_SIZE} bytes"
        ));
        return Ok(Verdict::Failed);
    }
    if !options.check && !options.speed {
        return Ok(Verdict::Passed);
    }
    if !repository::has_program("node") {
        skip("the comparison of WebAssembly with this machine: node is not installed")?;
        return Ok(Verdict::Passed);
    }
    if options.speed {
        comparison::speed(&module)?;
    }
    if options.check {
        return comparison::bits(&module);
    }
    Ok(Verdict::Passed)
}

/// Builds the module, writes the pages into a folder, and returns the path of the module; prints
/// what is missing and returns `None` if the compiler lacks the target.
///
/// # Errors
/// The build fails, or a file cannot be written.
pub fn pages(out: &Path) -> Result<Option<PathBuf>> {
    match build::module(repository::root()?)? {
        Module::Built(module) => {
            write_pages(out, &module)?;
            Ok(Some(module))
        }
        Module::Missing(what) => {
            skip(&format!("the page without a server: {what}"))?;
            Ok(None)
        }
    }
}

/// Writes the page, its worker, the module, all of them as a script for pages that are opened from
/// a disk, and the small pictures of the gallery.
fn write_pages(out: &Path, module: &Path) -> Result<()> {
    let bytes = fs::read(module).with_context(|| format!("cannot read {}", module.display()))?;
    let local = serde_json::json!({ "worker": WORKER, "module": STANDARD.encode(&bytes) });
    write(&out.join("index.html"), page(PageEngine::Worker).as_bytes())?;
    write(&out.join("worker.js"), WORKER.as_bytes())?;
    write(&out.join("carom.wasm"), &bytes)?;
    let local = format!("window.caromFiles = {local};\n");
    write(&out.join("local.js"), local.as_bytes())?;
    for exhibit in EXHIBITS {
        let path = out.join("thumbnail").join(format!("{}.svg", exhibit.name));
        let picture = thumbnail(exhibit.name)?.context("a scene of the gallery has a picture")?;
        write(&path, picture.as_bytes())?;
    }
    Ok(())
}

/// Writes a file and creates its folder if necessary.
fn write(path: &Path, content: &[u8]) -> Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)
            .with_context(|| format!("cannot create {}", folder.display()))?;
    }
    fs::write(path, content).with_context(|| format!("cannot write {}", path.display()))
}

/// Prints what is skipped, and adds it to the list of a run of all checks.
fn skip(what: &str) -> Result<()> {
    print_line(&format!("web: skipped: {what}"));
    let Some(list) = env::var_os("CAROM_SKIPPED") else {
        return Ok(());
    };
    let mut list = OpenOptions::new()
        .append(true)
        .create(true)
        .open(&list)
        .with_context(|| format!("cannot write {}", list.display()))?;
    writeln!(list, "skipped: {what}").context("the list of what is skipped")
}
