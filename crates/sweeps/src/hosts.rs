//! Scripts for a plain list of hosts that share a file system: one shard a host over ssh, and the
//! merge after them.
//!
//! A shard ends with its connection: its script watches the standard input, which the script that
//! starts all shards holds open. An interrupted script therefore leaves no process behind, and a
//! second start never meets the first one.

use std::{
    fs,
    path::{Path, PathBuf},
    time::Duration,
};

use anyhow::{Context, Result, bail, ensure};
use carom_runs::{print_line, resumable::Choices};

use crate::{
    slurm::{self, ALL, INPUT, LOGS, SHARDS, filled},
    study::Study,
};

/// The files in the folder of the scripts, besides those of [`slurm`].
const HOSTS: &str = "hosts";
const SHARD: &str = "shard.sh";
const RUN: &str = "run.sh";

/// The kind of script that an error names.
const SCRIPT: &str = "a shell script";

/// A study whose shards run on hosts. Its paths are absolute, since a connection starts elsewhere.
#[derive(Debug)]
struct HostJob {
    program: PathBuf,
    /// Folder of the scripts, the shards and the merged sweep.
    folder: PathBuf,
    /// Number of shards.
    count: usize,
    /// Time between two checkpoints.
    checkpoint_every: Duration,
}

/// Writes the scripts of a study with this name, with a copy of the study that needs no other file.
///
/// The list has one host a line, as `ssh` reads it; what follows `#` is a comment. There are as
/// many shards as lines, so that a host that occurs twice has two.
///
/// # Errors
/// The list cannot be read or has no host, a line is no host, the folder holds another study, a
/// file cannot be written, or a path has a character that a script cannot quote.
pub(crate) fn write(study: &Study, name: &str, choices: &Choices, list: &Path) -> Result<()> {
    let text =
        fs::read_to_string(list).with_context(|| format!("cannot read {}", list.display()))?;
    let count = hosts(&text)
        .with_context(|| list.display().to_string())?
        .len();
    let path = choices.resumption.folder(&format!("out/hosts-{name}"));
    let folder = slurm::job_folder(study, &path, choices, SCRIPT)?;
    folder.write(HOSTS, text)?;
    let job = HostJob {
        program: std::env::current_exe().context("the path of this program is unknown")?,
        folder: fs::canonicalize(&path).with_context(|| path.display().to_string())?,
        count,
        checkpoint_every: choices.checkpoint_every,
    };
    folder.write(SHARD, job.shard_script()?)?;
    folder.write(RUN, job.run_script()?)?;
    let run = path.join(RUN);
    print_line(&format!(
        "{count} shards; `bash {}` runs them",
        run.display()
    ));
    Ok(())
}

/// The hosts of a list.
fn hosts(text: &str) -> Result<Vec<&str>> {
    let mut found = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let host = line.split('#').next().unwrap_or_default().trim();
        if host.is_empty() {
            continue;
        }
        // A line that begins with a dash would be an option of ssh.
        if host.starts_with('-') || !host.chars().all(|c| c.is_ascii_graphic()) {
            bail!(
                "line {number}: expected a host as ssh reads it, such as user@host, not {host:?}: \
                 ports and keys are entries of ~/.ssh/config"
            );
        }
        found.push(host);
    }
    ensure!(
        !found.is_empty(),
        "expected one host a line, but there is none"
    );
    Ok(found)
}

impl HostJob {
    fn shard_script(&self) -> Result<String> {
        Ok(filled(
            include_str!("hosts/shard.sh"),
            &[
                ("program", quoted(&self.program)?),
                ("study", quoted(&self.folder.join(INPUT))?),
                ("shards", quoted(&self.folder.join(SHARDS))?),
                ("count", self.count.to_string()),
                (
                    "checkpoint_every",
                    self.checkpoint_every.as_secs_f64().to_string(),
                ),
            ],
        ))
    }

    fn run_script(&self) -> Result<String> {
        // The shell of the host reads this word a second time.
        let shard = format!("exec bash {}", quoted(&self.folder.join(SHARD))?);
        Ok(filled(
            include_str!("hosts/run.sh"),
            &[
                ("program", quoted(&self.program)?),
                ("hosts", quoted(&self.folder.join(HOSTS))?),
                ("shard", slurm::word(&shard)),
                ("logs", quoted(&self.folder.join(LOGS))?),
                ("shards", quoted(&self.folder.join(SHARDS))?),
                ("all", quoted(&self.folder.join(ALL))?),
                ("count", self.count.to_string()),
            ],
        ))
    }
}

/// A path as one word of the shell.
fn quoted(path: &Path) -> Result<String> {
    slurm::quoted(path, SCRIPT)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_has_hosts_comments_and_empty_lines() {
        let text = "# cluster\nnode1\n  me@node2  # slow\n\nnode1\r\n";
        assert_eq!(hosts(text).unwrap(), ["node1", "me@node2", "node1"]);
        for (bad, words) in [
            ("", "there is none"),
            ("# node1\n", "there is none"),
            ("a\n-oProxyCommand=x", "line 2: "),
            ("a b", "not \"a b\""),
            ("n\u{f6}de", "line 1: "),
        ] {
            let error = hosts(bad).unwrap_err().to_string();
            assert!(error.contains(words), "{bad}: {error}");
        }
    }

    #[test]
    fn every_place_of_a_script_is_filled() {
        let job = HostJob {
            program: "/opt/a carom".into(),
            folder: "/home/it's/@count@".into(),
            count: 3,
            checkpoint_every: Duration::from_secs(30),
        };
        let (shard, run) = (job.shard_script().unwrap(), job.run_script().unwrap());
        assert!(
            shard.contains(
                r#"'/opt/a carom' --quiet sweep '/home/it'\''s/@count@/input.toml' --shard "$1/3""#
            ),
            "{shard}"
        );
        assert!(
            run.contains(
                r#""$host" 'exec bash '\''/home/it'\''\'\'''\''s/@count@/shard.sh'\'''" $i""#
            ),
            "{run}"
        );
        for script in [shard, run] {
            let rest = script
                .replace("/@count@", "")
                .replace("hosts[@]", "")
                .replace("pids[@]:-", "");
            assert!(!rest.contains('@'), "{rest}");
        }
    }
}
