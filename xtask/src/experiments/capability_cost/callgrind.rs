//! Instruction counts of a run from callgrind, by source file; they have no noise.

use std::{collections::BTreeMap, fs, path::Path, process::Command};

use anyhow::{Context, Result, ensure};

use super::{COMMAND, capability::Variant};

/// Instruction counts by two source files: that of the function and that of the line, which differ
/// if the compiler has inlined one function into another.
pub type Profile = BTreeMap<[String; 2], u64>;

/// One run under callgrind.
#[derive(Debug)]
pub struct Counted {
    /// Instructions by source file.
    pub profile: Profile,
    /// Number of collisions.
    pub collisions: u64,
}

/// Returns true if the program `valgrind` is installed.
pub fn is_installed() -> bool {
    Command::new("valgrind")
        .arg("--version")
        .output()
        .is_ok_and(|output| output.status.success())
}

/// Runs this program under callgrind.
///
/// # Errors
/// It cannot be started, it fails, or its output cannot be read.
pub fn count(variant: Variant, intervals: u32, folder: &Path) -> Result<Counted> {
    let program = std::env::current_exe().context("cannot find this program")?;
    let file = folder.join(format!(
        "callgrind.{}.{intervals}",
        variant.to_string().replace(' ', "-")
    ));
    let output = Command::new("valgrind")
        .arg("--tool=callgrind")
        .arg("--dump-line=yes")
        .arg(format!("--callgrind-out-file={}", file.display()))
        .arg(program)
        .arg(COMMAND)
        .arg(variant.to_string())
        .arg(intervals.to_string())
        .output()
        .context("cannot start valgrind")?;
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    ensure!(
        output.status.success(),
        "'{variant}' under callgrind: {errors}"
    );
    let collisions = String::from_utf8_lossy(&output.stdout)
        .trim()
        .parse()
        .context("the worker did not print a number of collisions")?;
    let text =
        fs::read_to_string(&file).with_context(|| format!("cannot read {}", file.display()))?;
    fs::remove_file(&file).ok();
    Ok(Counted {
        profile: parse(&text),
        collisions,
    })
}

/// Parses callgrind's output (Valgrind manual, "Callgrind Format Specification"): `fl`, `fi` and
/// `fe` name sources, by number after the first mention; the line after `calls` is the inclusive
/// cost of the callee, which is counted elsewhere.
pub fn parse(text: &str) -> Profile {
    let mut names: BTreeMap<&str, &str> = BTreeMap::new();
    let mut profile: BTreeMap<[&str; 2], u64> = BTreeMap::new();
    let (mut function, mut own) = ("", "");
    let mut called = false;
    for line in text.lines() {
        if let Some((key, value)) = line.split_once('=') {
            let mut name = || {
                let (number, name) = value.split_once(' ').unwrap_or((value, ""));
                if !name.is_empty() {
                    names.insert(number, name);
                }
                names.get(number).copied().unwrap_or(number)
            };
            match key {
                "fl" => {
                    function = name();
                    own = function;
                }
                "fi" | "fe" => own = name(),
                // Source of the callee; its name may be defined here.
                "cfi" | "cfl" => {
                    name();
                }
                "calls" => called = true,
                _ => {}
            }
        } else if line.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '*')) {
            let cost = line
                .split(' ')
                .nth(1)
                .and_then(|cost| cost.parse::<u64>().ok());
            if !std::mem::take(&mut called) {
                *profile.entry([function, own]).or_default() += cost.unwrap_or(0);
            }
        }
    }
    profile
        .into_iter()
        .map(|(key, cost)| (key.map(str::to_owned), cost))
        .collect()
}

/// Total number of instructions.
pub fn total(profile: &Profile) -> u64 {
    profile.values().sum()
}

/// Number of instructions whose function or line is in one of these sources.
pub fn of_sources(profile: &Profile, sources: &[&str]) -> u64 {
    let is_one = |path: &String| sources.iter().any(|source| path.ends_with(source));
    profile
        .iter()
        .filter(|(paths, _)| paths.iter().any(is_one))
        .map(|(_, cost)| cost)
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const OUTPUT: &str = "events: Ir\nfl=(1) /c/engine/src/discs.rs\nfn=(1) advance\n10 100\n+2 20\nfi=(2) /c/engine/src/world/wall.rs\n\
                          7 5\nfe=(1)\n12 3\ncfi=(3) /c/detection/src/exact.rs\ncfn=(2) ask\ncalls=4 90\n* 4000\n-1 2\n\n\
                          fl=(3)\nfn=(2)\n90 4000\nfi=(4) /rust/core/f64.rs\n1 70\nsummary: 4200\ntotals: 4200\n";

    #[test]
    fn each_instruction_counts_once_for_its_own_source() {
        let profile = parse(OUTPUT);
        assert_eq!(total(&profile), 100 + 20 + 5 + 3 + 2 + 4000 + 70);
        assert_eq!(of_sources(&profile, &["engine/src/world/wall.rs"]), 5);
        // Including inlined code.
        assert_eq!(of_sources(&profile, &["detection/src/exact.rs"]), 4070);
        assert_eq!(of_sources(&profile, &[]), 0);
    }
}
