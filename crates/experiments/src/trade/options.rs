//! Options of `carom trade`.

use anyhow::{Result, ensure};
use carom_runs::{command_line::command, output::Destination, run::SceneFile};
use clap::Args;

/// Least and largest time allowed (minutes). Less: no setting ends. More is a mistake.
const MINUTES: [f64; 2] = [0.01, 1e4];

/// Options of `carom trade`.
#[derive(Debug, Clone, Args)]
pub struct TradeOptions {
    /// The scene file and changes to it
    #[command(flatten)]
    pub file: SceneFile,
    /// Output folder and its treatment
    #[command(flatten)]
    pub destination: Destination,
    /// Time allowed (minutes); more resolves rarer errors
    #[arg(long, default_value_t = 2.0)]
    pub minutes: f64,
}

impl TradeOptions {
    /// The time allowed (seconds).
    ///
    /// # Errors
    /// It is out of range, or an option of runs is given that has no meaning here.
    pub fn seconds(&self) -> Result<f64> {
        let [least, most] = MINUTES;
        ensure!(
            (least..=most).contains(&self.minutes),
            "--minutes must be from {least} to {most}, but is {:?}",
            self.minutes
        );
        ensure!(
            self.file.from.is_none(),
            "--from has no effect here: `carom trade` starts a scene from its beginning; give the end of that \
             run as [start] from = \"end.extxyz\""
        );
        Ok(60.0 * self.minutes)
    }

    /// Name of the scene: that of its file.
    pub fn name(&self) -> String {
        let name = self
            .file
            .path
            .file_stem()
            .unwrap_or_else(|| "scene".as_ref());
        let is_safe = |c: &char| c.is_alphanumeric() || "-_".contains(*c);
        let name: String = name.to_string_lossy().chars().filter(is_safe).collect();
        if name.is_empty() {
            "scene".to_owned()
        } else {
            name
        }
    }

    /// The output folder if none is given.
    pub fn folder(&self) -> String {
        format!("out/trade-{}", self.name())
    }

    /// The command that repeats the comparison from the scene that its folder holds.
    pub fn command(&self) -> String {
        let folder = self.destination.folder(&self.folder());
        let (scene, minutes) = (folder.join("config.toml"), self.minutes.to_string());
        command([
            "trade".as_ref(),
            scene.as_os_str(),
            "--minutes".as_ref(),
            minutes.as_ref(),
        ])
    }
}
