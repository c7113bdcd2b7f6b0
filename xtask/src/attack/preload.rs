//! The preloaded library `carom-faults`: how it is built, configured, and its record read.

use std::{
    env, fs,
    path::{Path, PathBuf},
    process::Command,
};

use anyhow::{Context, Result, bail, ensure};

use super::targets::OUT;

/// File of the record in the folder of a case.
const JOURNAL: &str = "journal";

/// Folder of what renames have replaced.
const REPLACED: &str = "replaced";

/// The library.
#[derive(Debug, Clone)]
pub struct Library {
    path: PathBuf,
}

/// What a process has done to the files below its folder: see `xtask/faults/src/journal.rs`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum CallStep {
    /// A file was created or emptied.
    Open(PathBuf),
    /// Bytes were written to a file.
    Write(PathBuf),
    /// A file was given a length (bytes).
    Truncate(PathBuf, u64),
    /// The content of a file was flushed to disk, up to this length (bytes).
    Sync(PathBuf, u64),
    /// The entries of a folder were flushed to disk.
    SyncFolder(PathBuf),
    /// A file got another name; the link is what it replaced.
    Rename {
        /// Path before.
        from: PathBuf,
        /// Path after.
        to: PathBuf,
        /// Link to what was there before.
        replaced: Option<PathBuf>,
    },
    /// A file was removed.
    Remove(PathBuf),
    /// A folder was made.
    MakeFolder,
}

/// The record of a process.
#[derive(Debug, Clone, Default)]
pub struct Journal {
    /// Number of calls that could have failed.
    pub calls: u64,
    /// What they did.
    pub steps: Vec<CallStep>,
}

impl Library {
    /// Builds the library beside this program.
    ///
    /// # Errors
    /// It cannot be built. Other systems than Linux have no `LD_PRELOAD`, or other functions behind
    /// their files.
    pub fn build() -> Result<Self> {
        ensure!(
            cfg!(target_os = "linux"),
            "the library of faults is for Linux"
        );
        let program = env::current_exe().context("cannot find this program")?;
        let folder = program.parent().context("this program has no folder")?;
        let target = folder
            .parent()
            .context("this program is not in the folder of a build")?;
        let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let mut command = Command::new(cargo);
        command
            .args([
                "build",
                "--quiet",
                "--package",
                "carom-faults",
                "--manifest-path",
            ])
            .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("faults/Cargo.toml"))
            .arg("--target-dir")
            .arg(target);
        if folder.ends_with("release") {
            command.arg("--release");
        }
        let built = command.output().context("cannot start cargo")?;
        ensure!(
            built.status.success(),
            "cargo build: {}",
            String::from_utf8_lossy(&built.stderr)
        );
        let path = folder.join("libcarom_faults.so");
        ensure!(path.is_file(), "cargo has not built {}", path.display());
        Ok(Self { path })
    }

    /// Lets a command of `carom` that runs in `folder` fail in its call number `call`, by the name
    /// of a fault; 0 for no fault.
    pub fn disturb(&self, command: &mut Command, folder: &Path, call: u64, fault: &str) {
        // A record is of one process.
        let _ = fs::remove_file(folder.join(JOURNAL));
        let _ = fs::remove_dir_all(folder.join(REPLACED));
        let _ = fs::create_dir(folder.join(REPLACED));
        command
            .env("LD_PRELOAD", &self.path)
            .env("CAROM_FAULTS_ROOT", folder.join(OUT))
            .env("CAROM_FAULTS_JOURNAL", folder.join(JOURNAL))
            .env("CAROM_FAULTS_REPLACED", folder.join(REPLACED))
            .env("CAROM_FAULTS_CALL", call.to_string())
            .env("CAROM_FAULTS_FAULT", fault);
    }

    /// Changes the locks of a command that runs in `folder`: `ENOLCK`, `ENOSYS` or `GRANTED`.
    pub fn change_locks(&self, command: &mut Command, folder: &Path, locks: &str) {
        command
            .env("LD_PRELOAD", &self.path)
            .env("CAROM_FAULTS_ROOT", folder.join(OUT))
            .env("CAROM_FAULTS_LOCKS", locks);
    }
}

impl Journal {
    /// The record of the last process in a folder.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(JOURNAL);
        // A process that was killed before its first call has none.
        let text = if path.exists() {
            fs::read_to_string(&path)
        } else {
            Ok(String::new())
        };
        let mut journal = Self::default();
        for line in text
            .with_context(|| format!("cannot read {}", path.display()))?
            .lines()
        {
            let (number, step) = step(line)?;
            journal.calls = journal.calls.max(number);
            journal.steps.push(step);
        }
        Ok(journal)
    }
}

fn step(line: &str) -> Result<(u64, CallStep)> {
    let fields: Vec<&str> = line.split('\t').collect();
    let context = || format!("the record has the line '{line}'");
    let number = fields[0].parse().with_context(context)?;
    let length = |text: &str| text.parse().with_context(context);
    let step = match fields[1..] {
        ["open", path] => CallStep::Open(path.into()),
        ["write", path] => CallStep::Write(path.into()),
        ["truncate", path, bytes] => CallStep::Truncate(path.into(), length(bytes)?),
        ["sync", path, bytes] => CallStep::Sync(path.into(), length(bytes)?),
        ["syncdir", path] => CallStep::SyncFolder(path.into()),
        ["rename", from, to, link] => {
            let replaced = (!link.is_empty()).then(|| link.into());
            CallStep::Rename {
                from: from.into(),
                to: to.into(),
                replaced,
            }
        }
        ["remove", path] => CallStep::Remove(path.into()),
        ["mkdir", _] => CallStep::MakeFolder,
        _ => bail!(context()),
    };
    Ok((number, step))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_record_is_read() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(
            folder.path().join(JOURNAL),
            "1\topen\t/a\n2\twrite\t/a\n4\trename\t/a\t/b\t\n",
        )
        .unwrap();
        let journal = Journal::read(folder.path()).unwrap();
        assert_eq!((journal.calls, journal.steps.len()), (4, 3));
        let rename = CallStep::Rename {
            from: "/a".into(),
            to: "/b".into(),
            replaced: None,
        };
        assert_eq!(journal.steps[2], rename);
        assert!(step("x\topen\t/a").is_err() && step("1\tdance\t/a").is_err());
    }
}
