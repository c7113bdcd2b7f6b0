//! The command `carom live`: options, the server, and a browser.

use std::{
    env,
    io::{Write as _, stderr},
    net::{IpAddr, Ipv4Addr, SocketAddr},
    path::{Path, PathBuf},
    process::{Command, Stdio},
    time::Duration,
};

use anyhow::{Context, Result};
use carom::Scene;
use carom_runs::{
    command_line::quoted,
    console::{is_json, note, print_line, put},
    interruption::Signals,
    overrides::Override,
    progress::suspend,
    run::{
        SceneFile,
        interactive::{MEASURED, Saved},
    },
};
use carom_tables::Verdict;
use clap::Args;

use crate::server::{SAVE_INTERVAL, Server};

/// Options of `carom live`.
#[derive(Debug, Clone, Args)]
pub struct LiveOptions {
    /// The scene file; without one the page offers a gallery
    #[arg(value_name = "SCENE.toml")]
    pub path: Option<PathBuf>,
    /// Seed of all random numbers, instead of the scene's box.seed
    #[arg(long, requires = "path")]
    pub seed: Option<u64>,
    /// Change an entry, such as gas.0.count=100; may be repeated
    #[arg(long = "set", value_name = "KEY.PATH=VALUE", requires = "path")]
    pub set: Vec<Override>,
    /// Folder of the saved runs, which are numbered; default: out/live-SCENE
    #[arg(long)]
    pub out: Option<PathBuf>,
    /// Port; default: one that is free
    #[arg(long, default_value_t = 0)]
    pub port: u16,
    /// Serve other machines too, on this address of this one: the printed address is all that is
    /// needed to edit the run and to write files into the folder of the saved runs
    #[arg(long, value_name = "ADDRESS")]
    pub listen: Option<IpAddr>,
    /// Seconds between two automatic saves: the most that is lost if the program is killed
    #[arg(long, value_name = "SECONDS", default_value_t = SAVE_INTERVAL.as_secs_f64())]
    pub save_every: f64,
    /// Do not open a browser
    #[arg(long)]
    pub no_open: bool,
}

/// Serves the laboratory until SIGINT, SIGTERM or SIGHUP; then the run is saved.
///
/// # Errors
/// The scene is invalid, the address cannot be used, or the run cannot be saved.
pub fn run(options: &LiveOptions) -> Result<Verdict> {
    let folder = folder(options);
    let interval = Duration::try_from_secs_f64(options.save_every).with_context(|| {
        format!(
            "--save-every must be from 0 seconds on, but is {}",
            options.save_every
        )
    })?;
    let shown = quoted(folder.as_os_str());
    let signals = Signals::while_saving(format!(
        "automatic saves, if there are any, remain in {shown}"
    ))?;
    let scene = options
        .path
        .as_deref()
        .map(|path| read(path, options))
        .transpose()?;
    let address = options.listen.unwrap_or(IpAddr::V4(Ipv4Addr::LOCALHOST));
    let server = Server::bind(SocketAddr::new(address, options.port), &folder, signals)?;
    let server = server.saving_every(interval);
    announce(server.address());
    if !address.is_loopback() {
        print_error_line(
            "Warning: other machines can reach this address, without encryption. With it, a page can edit the \
             run and save it here. `ssh -L` to the loopback address is safer.",
        );
    }
    note(&format!(
        "The run is saved every {} s into {}, and at the end.",
        options.save_every,
        quoted(server.automatic_folder().as_os_str())
    ));
    if !options.no_open {
        open_browser(&server.address_for_once()?);
    }
    let ended = server.serve(scene)?;
    if let Some(saved) = ended.saved {
        print_line(&format!(
            "saved at t = {}; continue with\n  {}",
            saved.time, saved.command
        ));
        for words in remarks(&saved) {
            note(&words);
        }
    }
    Ok(Verdict::Passed)
}

/// What a reader of the saved run must know: from when on it measures, and what it leaves out.
fn remarks(saved: &Saved) -> Vec<String> {
    let measures = saved.measures_from.map(|from| {
        format!(
            "The saved run measures from t = {from} on. What measures of the page have found is in its folder, in \
             {MEASURED}: their series continue, and means and errors begin anew."
        )
    });
    let left_out = saved
        .left_out
        .iter()
        .map(|reason| format!("Left out: {reason}"));
    measures.into_iter().chain(left_out).collect()
}

/// Writes the address of the page: a JSON object is written at the end only, so with `--json` it is
/// the first line of standard error, and in the object under `address`.
fn announce(address: &str) {
    if is_json() {
        put("address", &address);
        print_error_line(address);
    } else {
        print_line(address);
    }
}

/// Writes a line to standard error that the user needs with `--quiet` too.
fn print_error_line(text: &str) {
    suspend(|| {
        // A closed standard error is no reason to end.
        let _ = writeln!(stderr(), "{text}");
    });
}

/// The scene of the command line, with its name.
fn read(path: &Path, options: &LiveOptions) -> Result<(String, Scene)> {
    let file = SceneFile {
        path: path.to_owned(),
        until: None,
        seed: options.seed,
        from: None,
        set: options.set.clone(),
    };
    let name = path
        .file_stem()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned();
    Ok((name, file.read(None)?))
}

fn folder(options: &LiveOptions) -> PathBuf {
    let name = options
        .path
        .as_deref()
        .and_then(Path::file_stem)
        .unwrap_or("gallery".as_ref());
    options
        .out
        .clone()
        .unwrap_or_else(|| Path::new("out").join(format!("live-{}", name.to_string_lossy())))
}

/// Opens the address in a browser, if there is a screen; a failure changes nothing.
fn open_browser(address: &str) {
    let has_screen = ["DISPLAY", "WAYLAND_DISPLAY"]
        .iter()
        .any(|name| env::var_os(name).is_some());
    let mut command = if cfg!(target_os = "macos") {
        Command::new("open")
    } else if cfg!(windows) {
        Command::new("explorer")
    } else if has_screen {
        Command::new("xdg-open")
    } else {
        return;
    };
    command
        .arg(address)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    // It is not waited for: the program may continue as long as the browser does.
    if command.spawn().is_err() {
        note("No browser could be started: open the address in one.");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_saved_run_says_from_when_on_it_measures_and_what_it_leaves_out() {
        let saved = |measures_from: Option<f64>| Saved {
            time: 2.0,
            command: "carom run".to_owned(),
            measures_from,
            left_out: vec!["run.stop: not used".to_owned()],
        };
        let words = remarks(&saved(Some(2.5)));
        assert!(
            words[0].contains("measures from t = 2.5 on") && words[0].contains("measured-before"),
            "{words:?}"
        );
        assert_eq!(words[1], "Left out: run.stop: not used");
        // A run without measures.
        assert_eq!(remarks(&saved(None)).len(), 1);
    }
}
