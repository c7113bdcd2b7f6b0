//! `cargo xtask ci`: everything that must hold before a change lands, in order, until a step fails.

use std::{
    fs::{self, File},
    io::{BufRead as _, BufReader, Write as _},
    path::{Path, PathBuf},
    process::{Command, Stdio},
    time::Instant,
};

use anyhow::{Context, Result};
use carom_runs::print_line;
use carom_tables::Verdict;

use crate::repository;

/// Seed of the fuzzers: cases stay the same. Fresh seeds are for runs by hand.
const FUZZ_SEED: &str = "18";

/// Runs all steps up to the first that fails.
///
/// # Errors
/// A step that cannot be started.
pub fn run() -> Result<Verdict> {
    let root = repository::root()?;
    let folder = repository::target_folder()?.join("ci");
    fs::create_dir_all(&folder).with_context(|| format!("cannot create {}", folder.display()))?;
    let steps = Steps {
        root,
        skipped: folder.join("skipped"),
    };
    File::create(&steps.skipped)
        .with_context(|| format!("cannot write {}", steps.skipped.display()))?;

    // One build serves all steps and the tests, with debug assertions and overflow checks; the
    // commands of the repository are those of this program.
    let program = std::env::current_exe().context("the path of this program is unknown")?;
    let xtask = format!("'{}'", program.display());
    let lines = [
        source_checks(&xtask),
        package_checks(),
        trial_runs(&xtask, &folder),
    ];
    for line in lines.concat() {
        if !steps.passes(&line)? {
            return Ok(Verdict::Failed);
        }
    }
    // The tests of the Python package compare with the command, which this program contains. All
    // tests run, so that one run shows every failure.
    steps.tests(&format!(
        "eval \"$(.ci/tools)\"; failed=0; CAROM_COMMAND=\"{xtask} carom\" .ci/python || failed=1; \
         tests/slurm.sh || failed=1; cargo test --workspace --no-fail-fast && exit $failed"
    ))
}

/// Checks of the sources: format, faults that compilers find, documentation and rules of the
/// repository.
fn source_checks(xtask: &str) -> Vec<String> {
    let mut lines = vec![
        "cargo fmt --all --check".to_owned(),
        "cargo clippy --workspace --all-targets -- -D warnings".to_owned(),
    ];
    for layer in [
        "geometry",
        "kinematics",
        "detection",
        "response",
        "engine",
        "observers",
    ] {
        lines.push(format!("cargo check --quiet --package carom-{layer}"));
    }
    lines.push("RUSTDOCFLAGS='-D warnings' cargo doc --workspace --no-deps".to_owned());
    lines.push(format!("{xtask} tidy"));
    lines.push(format!("{xtask} surface"));
    lines
}

/// Checks of what is published: packages, the book, and licences and sources of dependencies.
fn package_checks() -> Vec<String> {
    vec![
        // What the repository alone needs is never published.
        "cargo package --quiet --workspace --allow-dirty --no-verify \
         --exclude xtask --exclude carom-faults --exclude carom-testkit --exclude carom-web"
            .to_owned(),
        "if command -v mdbook >/dev/null; then mdbook build crates/book; \
         else echo 'skipped: the book: no mdbook' >> \"$CAROM_SKIPPED\"; fi"
            .to_owned(),
        // Advisories need their database from the network; `cargo deny check` by hand has them too.
        "if command -v cargo-deny >/dev/null; then \
         for manifest in Cargo.toml crates/python/Cargo.toml; do \
         cargo deny --offline --manifest-path $manifest check bans licenses sources || exit 1; done; \
         else echo 'skipped: bans and sources of dependencies: no cargo-deny' >> \"$CAROM_SKIPPED\"; fi"
            .to_owned(),
    ]
}

/// Short runs of an experiment and of the fuzzers, with their files in a folder.
fn trial_runs(xtask: &str, folder: &Path) -> Vec<String> {
    let [brownian, fuzz] = ["brownian", "fuzz"].map(|name| folder.join(name).display().to_string());
    let mut lines = vec![format!(
        "{xtask} experiment brownian --quick --force --out '{brownian}'"
    )];
    for fuzzer in ["detection", "scenes", "files", "tiles"] {
        lines.push(format!(
            "{xtask} fuzz {fuzzer} --minutes 1 --seed {FUZZ_SEED} --out '{fuzz}'"
        ));
    }
    lines
}

/// Commands that run in the root of the repository.
struct Steps<'a> {
    root: &'a Path,
    /// File to which tests append what they skip.
    skipped: PathBuf,
}

impl Steps<'_> {
    fn shell(&self, line: &str) -> Command {
        let mut command = Command::new("bash");
        command
            .args(["-c", line])
            .current_dir(self.root)
            .env("CAROM_SKIPPED", &self.skipped);
        command
    }

    fn passes(&self, line: &str) -> Result<bool> {
        print_line(&format!("ci: {line}"));
        let begun = Instant::now();
        let status = self
            .shell(line)
            .status()
            .with_context(|| format!("cannot start `{line}`"))?;
        print_line(&format!("ci: {:.0} s", begun.elapsed().as_secs_f64()));
        if !status.success() {
            print_line(&format!("ci: FAILED: `{line}`: {status}"));
        }
        Ok(status.success())
    }

    /// Runs the tests and closes with the sum of all test programs' results, in the format of one
    /// test program.
    fn tests(&self, line: &str) -> Result<Verdict> {
        print_line(&format!("ci: {line}"));
        let begun = Instant::now();
        let mut tests = self
            .shell(line)
            .stdout(Stdio::piped())
            .spawn()
            .with_context(|| format!("cannot start `{line}`"))?;
        let output = tests
            .stdout
            .take()
            .context("the output of the tests is piped")?;
        let mut sum = Sum::default();
        for line in BufReader::new(output).lines() {
            let line = line.context("the output of the tests cannot be read")?;
            sum.add(&line);
            // A closed pipe loses nothing that matters to the result.
            let _ = writeln!(std::io::stdout(), "{line}");
        }
        let status = tests.wait().context("the tests cannot be waited for")?;
        let mut skipped: Vec<String> = fs::read_to_string(&self.skipped)
            .unwrap_or_default()
            .lines()
            .map(str::to_owned)
            .collect();
        skipped.sort();
        skipped.dedup();
        for line in &skipped {
            print_line(line);
        }
        print_line(&format!("ci: {:.0} s", begun.elapsed().as_secs_f64()));
        print_line(&sum.line(status.success(), skipped.len()));
        Ok(if status.success() {
            Verdict::Passed
        } else {
            Verdict::Failed
        })
    }
}

/// Numbers of tests over all test programs.
#[derive(Debug, Default, PartialEq, Eq)]
struct Sum {
    passed: u64,
    failed: u64,
    ignored: u64,
}

impl Sum {
    /// Adds a line `test result: ok. 5 passed; 0 failed; 1 ignored; …`; other lines add nothing.
    fn add(&mut self, line: &str) {
        let Some(result) = line.strip_prefix("test result: ") else {
            return;
        };
        let count = |kind: &str| -> u64 {
            let words: Vec<&str> = result
                .split([' ', ';'])
                .filter(|word| !word.is_empty())
                .collect();
            let at = words.iter().position(|&word| word == kind);
            at.and_then(|at| words[at.checked_sub(1)?].parse().ok())
                .unwrap_or(0)
        };
        self.passed += count("passed");
        self.failed += count("failed");
        self.ignored += count("ignored");
    }

    fn line(&self, success: bool, skipped: usize) -> String {
        let Self {
            passed,
            failed,
            ignored,
        } = self;
        let word = if success { "ok" } else { "FAILED" };
        format!(
            "test result: {word}. {passed} passed; {failed} failed; {ignored} ignored; {skipped} skipped"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_of_test_programs_are_added() {
        let mut sum = Sum::default();
        sum.add(
            "test result: ok. 12 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out; finished in 0.15s",
        );
        sum.add("test result: FAILED. 3 passed; 2 failed; 0 ignored; 0 measured; 0 filtered out");
        sum.add("test a::b ... ok");
        assert_eq!(
            sum,
            Sum {
                passed: 15,
                failed: 2,
                ignored: 1
            }
        );
        assert_eq!(
            sum.line(false, 4),
            "test result: FAILED. 15 passed; 2 failed; 1 ignored; 4 skipped"
        );
    }
}
