//! Job scripts for Slurm: an array with one task a shard, and a job that merges the shards.
//!
//! A task ends itself before its time limit: Slurm sends `USR1`, the program writes its
//! checkpoints, and the task is put back into the queue, where it continues. The signal may come
//! early (up to a minute and more, as Slurm looks at its jobs now and then), which only costs a
//! start more.

use std::{
    fs,
    path::{Path, PathBuf},
    str::FromStr,
    time::Duration,
};

use anyhow::{Context, Result, bail};
use carom_runs::{
    output::{Existing, Folder},
    print_line,
    resumable::Choices,
};
use clap::Args;

use crate::study::{Size, Study};

/// The files in the folder of a job.
pub(crate) const INPUT: &str = "input.toml";
const ARRAY: &str = "array.sh";
const MERGE: &str = "merge.sh";
const SUBMIT: &str = "submit.sh";
pub(crate) const LOGS: &str = "logs";
pub(crate) const SHARDS: &str = "shards";
pub(crate) const ALL: &str = "all";

/// The kind of script that an error names.
const SCRIPT: &str = "a Slurm script";

/// Seconds before the time limit at which a task receives its signal: enough to write checkpoints.
const LEAD: u32 = 120;

/// Options of the job scripts.
#[derive(Debug, Clone, Args)]
#[group(id = "slurm_options")]
pub struct SlurmOptions {
    /// Write job scripts for Slurm instead of running: an array of shards and a merge after it
    #[arg(long, conflicts_with_all = ["shard", "threads"])]
    pub slurm: bool,
    /// Number of tasks of the array, each one shard
    #[arg(long, value_name = "N", default_value_t = 16, requires = "slurm",
        value_parser = clap::value_parser!(u32).range(1..))]
    pub array_size: u32,
    /// Time limit of a task, as Slurm writes it: minutes, hours:minutes:seconds or days-hours
    #[arg(
        long,
        value_name = "LIMIT",
        default_value = "1:00:00",
        requires = "slurm"
    )]
    pub time: TimeLimit,
    /// Processors of a task
    #[arg(long, value_name = "N", default_value_t = 1, requires = "slurm",
        value_parser = clap::value_parser!(u16).range(1..))]
    pub cpus: u16,
    /// One more option of sbatch for all jobs, such as --sbatch=--partition=short; may be repeated
    #[arg(long, value_name = "OPTION", requires = "slurm")]
    pub sbatch: Vec<SbatchOption>,
    /// Write scripts that run one shard on each host of a list over ssh, and merge them after it.
    /// The list is a file with one host a line; the hosts share the output folder
    #[arg(long, value_name = "FILE", conflicts_with_all = ["slurm", "shard", "threads"])]
    pub hosts: Option<PathBuf>,
}

impl SlurmOptions {
    /// Whether scripts are written instead of running.
    pub(crate) fn is_requested(&self) -> bool {
        self.slurm || self.hosts.is_some()
    }
}

impl Default for SlurmOptions {
    /// No job scripts; the other values are those of the command line.
    fn default() -> Self {
        Self {
            slurm: false,
            array_size: 16,
            time: TimeLimit("1:00:00".to_owned()),
            cpus: 1,
            sbatch: Vec::new(),
            hosts: None,
        }
    }
}

/// A time limit in a form that Slurm reads: `90`, `90:00`, `1:30:00`, `2-12`, `2-12:30:00`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TimeLimit(String);

impl FromStr for TimeLimit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (days, rest) = text
            .split_once('-')
            .map_or(("0", text), |(days, rest)| (days, rest));
        let parts: Vec<&str> = rest.split(':').collect();
        let is_number =
            |part: &&str| (1..=9).contains(&part.len()) && part.bytes().all(|c| c.is_ascii_digit());
        if is_number(&days) && parts.len() <= 3 && parts.iter().all(is_number) {
            Ok(Self(text.to_owned()))
        } else {
            Err(
                "expected minutes, minutes:seconds, hours:minutes:seconds, days-hours or \
                 days-hours:minutes:seconds"
                    .to_owned(),
            )
        }
    }
}

/// An option of sbatch: one line that begins with two dashes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SbatchOption(String);

impl FromStr for SbatchOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.starts_with("--") && !text.contains(['\n', '\r']) {
            Ok(Self(text.to_owned()))
        } else {
            Err("expected one line that begins with two dashes".to_owned())
        }
    }
}

/// A study whose shards Slurm runs. Its paths are absolute, since Slurm runs copies of the scripts.
#[derive(Debug)]
struct Job {
    program: PathBuf,
    /// Name of the study.
    name: String,
    /// Folder of the scripts, the shards and the merged sweep.
    folder: PathBuf,
    /// Time between two checkpoints.
    checkpoint_every: Duration,
}

/// Writes the job scripts of a study with this name, with a copy of the study that needs no other
/// file: shards that start later are of the same study, whatever becomes of its file.
///
/// # Errors
/// The folder holds another study, a file cannot be written, or a path has a character that a
/// script cannot quote: a double quote, a backslash, a control character, or one that is not UTF-8.
pub fn write(study: &Study, name: &str, choices: &Choices, options: &SlurmOptions) -> Result<()> {
    let path = choices.resumption.folder(&format!("out/slurm-{name}"));
    let folder = job_folder(study, &path, choices, SCRIPT)?;
    let job = Job {
        program: std::env::current_exe().context("the path of this program is unknown")?,
        name: name.to_owned(),
        folder: fs::canonicalize(&path).with_context(|| path.display().to_string())?,
        checkpoint_every: choices.checkpoint_every,
    };
    folder.write(ARRAY, job.array_script(options)?)?;
    folder.write(MERGE, job.merge_script(options)?)?;
    folder.write(SUBMIT, job.submit_script()?)?;
    let submit = path.join(SUBMIT);
    print_line(&format!(
        "{} shards; `bash {}` puts them into the queue",
        options.array_size,
        submit.display()
    ));
    Ok(())
}

/// The folder of a job of a kind of script, with a copy of the study and a folder for logs.
///
/// # Errors
/// The folder holds another study, a file cannot be written, or a script cannot quote the path.
pub(crate) fn job_folder(
    study: &Study,
    path: &Path,
    choices: &Choices,
    script: &str,
) -> Result<Folder> {
    // Before anything is written.
    let absolute = std::path::absolute(path).with_context(|| path.display().to_string())?;
    quotable(&absolute, script)?;
    let resumption = &choices.resumption;
    let there = path.join(INPUT);
    let is_begun = there.is_file();
    if is_begun && resumption.existing() != Existing::Replace {
        study.refuse_other_subject(&Study::read(&there, Size::default())?).with_context(|| {
            format!(
                "{} holds the shards of another study: choose another folder with --out, or --force",
                path.display()
            )
        })?;
    }
    let folder = Folder::create(
        path,
        if is_begun {
            Existing::Replace
        } else {
            resumption.existing()
        },
    )?;
    // Slurm and the shell do not create the folder of the logs; without it tasks fail and say
    // nothing.
    folder.inner(LOGS)?;
    folder.write_lasting(INPUT, study.text())?;
    Ok(folder)
}

impl Job {
    fn array_script(&self, options: &SlurmOptions) -> Result<String> {
        let shards = [
            ("count", options.array_size.to_string()),
            ("lead", LEAD.to_string()),
            ("study", quoted(&self.folder.join(INPUT), SCRIPT)?),
            (
                "checkpoint_every",
                self.checkpoint_every.as_secs_f64().to_string(),
            ),
        ];
        Ok(filled(
            include_str!("slurm/array.sh"),
            &[&shards[..], &self.common(options)?].concat(),
        ))
    }

    fn merge_script(&self, options: &SlurmOptions) -> Result<String> {
        let all = [("all", quoted(&self.folder.join(ALL), SCRIPT)?)];
        Ok(filled(
            include_str!("slurm/merge.sh"),
            &[&all[..], &self.common(options)?].concat(),
        ))
    }

    fn submit_script(&self) -> Result<String> {
        let [array, merge] = [ARRAY, MERGE].map(|name| quoted(&self.folder.join(name), SCRIPT));
        Ok(filled(
            include_str!("slurm/submit.sh"),
            &[("array", array?), ("merge", merge?)],
        ))
    }

    /// What the jobs have in common.
    fn common(&self, options: &SlurmOptions) -> Result<Vec<(&'static str, String)>> {
        let is_plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
        let more: Vec<String> = options
            .sbatch
            .iter()
            .map(|line| format!("#SBATCH {}", line.0))
            .collect();
        Ok(vec![
            ("name", self.name.chars().map(is_plain).collect()),
            ("cpus", options.cpus.to_string()),
            ("time", options.time.0.clone()),
            // Slurm replaces what follows a per cent sign.
            (
                "logs",
                quotable(&self.folder.join(LOGS), SCRIPT)?.replace('%', "%%"),
            ),
            ("shards", quoted(&self.folder.join(SHARDS), SCRIPT)?),
            ("program", quoted(&self.program, SCRIPT)?),
            ("options", more.join("\n")),
        ])
    }
}

/// A script with a value in the place of each `@name@`. Values are not searched for further names.
pub(crate) fn filled(script: &str, values: &[(&str, String)]) -> String {
    let mut filled = String::with_capacity(script.len());
    let mut rest = script;
    while let Some((before, after)) = rest.split_once('@') {
        filled.push_str(before);
        let found = values.iter().find_map(|(name, value)| {
            let after = after.strip_prefix(name)?.strip_prefix('@')?;
            Some((value, after))
        });
        rest = if let Some((value, after)) = found {
            filled.push_str(value);
            after
        } else {
            filled.push('@');
            after
        };
    }
    filled + rest
}

/// A path as one word of the shell in a kind of script.
pub(crate) fn quoted(path: &Path, script: &str) -> Result<String> {
    Ok(word(quotable(path, script)?))
}

/// A text as one word of the shell.
pub(crate) fn word(text: &str) -> String {
    format!("'{}'", text.replace('\'', r"'\''"))
}

/// The text of a path that both the shell and the directives of sbatch read as it is. sbatch has no
/// escape for the characters that are refused.
pub(crate) fn quotable<'a>(path: &'a Path, script: &str) -> Result<&'a str> {
    let text = path
        .to_str()
        .with_context(|| format!("the path {} is not valid UTF-8", path.display()))?;
    match text
        .chars()
        .find(|&c| matches!(c, '"' | '\\') || c.is_control())
    {
        None => Ok(text),
        Some(refused) => bail!(
            "the path {text:?} has the character {refused:?}, which {script} cannot quote: choose \
             another folder with --out, without double quotes, backslashes and control characters"
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_limits_are_those_of_slurm() {
        for good in ["90", "90:00", "1:30:00", "2-12", "2-12:30", "2-12:30:00"] {
            assert!(good.parse::<TimeLimit>().is_ok(), "{good}");
        }
        for bad in [
            "",
            "-1",
            "1h",
            "1:2:3:4",
            "1-",
            "1\n#SBATCH --mail",
            "99999999999",
        ] {
            assert!(bad.parse::<TimeLimit>().is_err(), "{bad}");
        }
        assert!("--partition=a".parse::<SbatchOption>().is_ok());
        assert!("--a\nrm -r /".parse::<SbatchOption>().is_err());
    }

    #[test]
    fn every_place_of_a_script_is_filled() {
        let job = Job {
            program: "/opt/a carom".into(),
            name: "gas 1".to_owned(),
            folder: "/home/me/100%".into(),
            checkpoint_every: Duration::from_secs(30),
        };
        let partition: SbatchOption = "--partition=short".parse().unwrap();
        let time = "2:00:00".parse().unwrap();
        let options = SlurmOptions {
            slurm: true,
            array_size: 8,
            time,
            cpus: 2,
            sbatch: vec![partition],
            hosts: None,
        };
        let array = job.array_script(&options).unwrap();
        for line in [
            "#SBATCH --job-name=gas-1",
            "#SBATCH --array=1-8",
            "#SBATCH --signal=B:USR1@120",
            "#SBATCH --output=\"/home/me/100%%/logs/shard-%a.log\"",
            "#SBATCH --partition=short",
        ] {
            assert!(array.lines().any(|other| other == line), "{line}: {array}");
        }
        assert!(array.contains(
            "'/opt/a carom' --quiet sweep '/home/me/100%/input.toml' --shard \"$shard/8\""
        ));
        for script in [
            array.replace("USR1@120", ""),
            job.merge_script(&options).unwrap(),
            job.submit_script().unwrap(),
        ] {
            assert!(!script.contains('@'), "{script}");
        }
    }

    #[test]
    fn paths_are_one_word_of_the_shell() {
        let word = quoted(Path::new("/a b/it's $HOME"), SCRIPT).unwrap();
        assert_eq!(word, r"'/a b/it'\''s $HOME'");
        for safe in ["/a;b", "/`c`", "/100%", "/é", "/a@b"] {
            assert_eq!(
                quoted(Path::new(safe), SCRIPT).unwrap(),
                format!("'{safe}'")
            );
        }
    }

    #[test]
    fn paths_that_no_script_can_quote_are_refused_with_the_character() {
        for (path, character) in [
            ("/a\"b", r#"'"'"#),
            ("/a\\b", r"'\\'"),
            ("/a\n#SBATCH --wrap=true", r"'\n'"),
            ("/a\rb", r"'\r'"),
            ("/a\tb", r"'\t'"),
            ("/a\u{1b}b", r"'\u{1b}'"),
        ] {
            let error = quoted(Path::new(path), SCRIPT).unwrap_err().to_string();
            assert!(
                error.contains(&format!("the character {character},")),
                "{path:?}: {error}"
            );
            assert!(!error.contains('\n') && error.contains("--out"), "{error}");
        }
    }

    #[test]
    fn a_folder_with_the_name_of_a_place_of_the_script_is_kept() {
        let job = Job {
            program: "/opt/@study@".into(),
            name: "gas".to_owned(),
            folder: "/home/@options@/@count@".into(),
            checkpoint_every: Duration::from_secs(30),
        };
        let options = SlurmOptions {
            slurm: true,
            array_size: 3,
            ..SlurmOptions::default()
        };
        let array = job.array_script(&options).unwrap();
        assert!(
            array.contains("'/opt/@study@' --quiet sweep '/home/@options@/@count@/input.toml'"),
            "{array}"
        );
        assert!(
            array.contains("#SBATCH --output=\"/home/@options@/@count@/logs/shard-%a.log\""),
            "{array}"
        );
        assert!(
            job.submit_script()
                .unwrap()
                .contains("'/home/@options@/@count@/array.sh'")
        );
    }
}
