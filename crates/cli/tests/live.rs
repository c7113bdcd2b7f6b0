//! `carom live` and `carom run` as programs: how signals end them, with little left of what the
//! system grants, and what they print.

#![cfg(all(unix, feature = "live"))]

use std::{
    fs,
    io::{BufRead as _, BufReader, Read as _, Write as _},
    net::TcpStream,
    path::Path,
    process::{Child, Command, Stdio},
    thread::sleep,
    time::{Duration, Instant},
};

const PATIENCE: Duration = Duration::from_mins(1);

const GAS: &str = "[box]\nseed = 3\n[[gas]]\ntags = [\"gas\"]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 300\n\
                   [run]\nuntil = 1e4\nsample_interval = 1.0\nobserve = [\"energy\"]\n";

fn folder() -> tempfile::TempDir {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("gas.toml"), GAS).unwrap();
    root
}

/// Starts the program by a command of the shell in which `"$@"` is the program with its arguments.
fn start(folder: &Path, shell: &str, arguments: &[&str]) -> Child {
    let mut command = Command::new("sh");
    command
        .current_dir(folder)
        .args(["-c", shell, "sh", env!("CARGO_BIN_EXE_carom")])
        .args(arguments);
    command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the shell starts")
}

fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill")
        .args(["-s", name, &child.id().to_string()])
        .status()
        .unwrap();
    assert!(sent.success());
}

/// Starts `carom live` and waits for its address, the first line of its results.
fn live(folder: &Path, shell: &str) -> (Child, String) {
    let mut child = start(
        folder,
        shell,
        &["live", "gas.toml", "--out", "saved", "--no-open"],
    );
    let address = first_line(child.stdout.as_mut().unwrap());
    (child, address)
}

/// The first line, and no byte more.
fn first_line(from: &mut impl std::io::Read) -> String {
    let mut line = Vec::new();
    let mut byte = [0];
    while from.read(&mut byte).unwrap() == 1 && byte != *b"\n" {
        line.push(byte[0]);
    }
    String::from_utf8(line).unwrap()
}

/// Waits for the end; returns the exit code and standard error.
fn end(mut child: Child) -> (Option<i32>, String) {
    let begun = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begun.elapsed() > PATIENCE {
            child.kill().unwrap();
            panic!("the program does not end");
        }
        sleep(Duration::from_millis(10));
    }
    let mut said = String::new();
    child
        .stderr
        .take()
        .unwrap()
        .read_to_string(&mut said)
        .unwrap();
    (child.wait().unwrap().code(), said)
}

/// Whether `carom run` continues from a folder.
fn resumes(folder: &Path) -> bool {
    let config = folder.join("config.toml");
    let words = [
        "run",
        config.to_str().unwrap(),
        "--out",
        folder.to_str().unwrap(),
        "--resume",
    ];
    let mut run = Command::new(env!("CARGO_BIN_EXE_carom"));
    let run = run
        .args(words)
        .stderr(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    sleep(Duration::from_millis(300));
    signal(&run, "INT");
    end(run).0 == Some(130)
}

#[test]
fn signals_that_follow_on_one_another_do_not_lose_the_run() {
    for (turn, apart) in [0, 0, 2, 5, 10, 15, 20, 25, 30, 40, 50, 50]
        .into_iter()
        .enumerate()
    {
        let root = folder();
        let (child, _) = live(root.path(), "exec \"$@\"");
        sleep(Duration::from_millis(20 * turn as u64));
        signal(&child, "INT");
        sleep(Duration::from_millis(apart));
        // It may have ended by then.
        let _ = Command::new("kill")
            .args(["-s", "INT", &child.id().to_string()])
            .stderr(Stdio::null())
            .status();
        let (code, said) = end(child);
        assert_eq!(code, Some(0), "{apart} ms: {said}");
        assert!(
            root.path().join("saved/1/checkpoint").exists(),
            "{apart} ms: {said}"
        );
    }
}

#[test]
fn a_terminal_that_closes_ends_programs_in_order_and_not_under_nohup() {
    // Also where these tests run under `nohup`, if `env` can undo that.
    let by_default =
        "env --default-signal=HUP true 2>&- && exec env --default-signal=HUP \"$@\"; exec \"$@\"";
    let root = folder();
    let (child, _) = live(root.path(), by_default);
    signal(&child, "HUP");
    let (code, said) = end(child);
    assert_eq!(code, Some(0), "{said}");
    assert!(resumes(&root.path().join("saved/1")));

    let run = [
        "run",
        "gas.toml",
        "--out",
        "run",
        "--checkpoint-every",
        "1000",
    ];
    let started = |shell: &str, arguments: &[&str], name: &str| {
        let child = start(root.path(), shell, arguments);
        let begun = Instant::now();
        while !root.path().join(name).join("checkpoint").exists() {
            assert!(begun.elapsed() < PATIENCE);
            sleep(Duration::from_millis(10));
        }
        child
    };
    let child = started(by_default, &run, "run");
    signal(&child, "HUP");
    let (code, said) = end(child);
    assert_eq!(code, Some(129), "{said}");
    assert!(
        said.contains("interrupted by SIGHUP") && said.contains("--resume"),
        "{said}"
    );
    assert!(resumes(&root.path().join("run")));

    let run = [
        "run",
        "gas.toml",
        "--out",
        "kept",
        "--checkpoint-every",
        "1000",
    ];
    let mut child = started("exec nohup \"$@\"", &run, "kept");
    signal(&child, "HUP");
    sleep(Duration::from_millis(1500));
    assert!(child.try_wait().unwrap().is_none(), "nohup keeps it alive");
    signal(&child, "TERM");
    assert_eq!(end(child).0, Some(143));
}

#[test]
fn a_program_that_is_killed_leaves_its_last_automatic_save() {
    let root = folder();
    let words = [
        "live",
        "gas.toml",
        "--out",
        "saved",
        "--no-open",
        "--save-every",
        "0.1",
    ];
    let mut child = start(root.path(), "exec \"$@\"", &words);
    first_line(child.stdout.as_mut().unwrap());
    let save = root.path().join("saved/auto-1/1");
    let begun = Instant::now();
    while !save.join("checkpoint").exists() {
        assert!(begun.elapsed() < PATIENCE);
        sleep(Duration::from_millis(10));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(resumes(&save));
}

#[test]
fn with_all_descriptors_taken_the_run_is_saved() {
    let root = folder();
    // No connection gets one that saving needs.
    let (child, address) = live(root.path(), "ulimit -n 48; exec \"$@\"");
    let host = address
        .trim_start_matches("http://")
        .split('/')
        .next()
        .unwrap()
        .to_owned();
    let silent: Vec<TcpStream> = (0..100)
        .map(|_| {
            let mut stream = TcpStream::connect(&host).unwrap();
            stream.write_all(b"GET / HTTP/1.1\r\nHost: ").unwrap();
            stream
        })
        .collect();
    sleep(Duration::from_millis(300));
    signal(&child, "INT");
    let (code, said) = end(child);
    assert_eq!(code, Some(0), "{said}");
    drop(silent);
    assert!(resumes(&root.path().join("saved/1")));
    // Too few are refused at the start.
    let refused = start(
        root.path(),
        "ulimit -n 16; exec \"$@\"",
        &["live", "gas.toml", "--no-open"],
    );
    let (code, said) = end(refused);
    assert!(
        code == Some(2) && said.contains("ulimit -n"),
        "{code:?} {said}"
    );
}

#[test]
fn the_address_and_the_warning_of_an_open_one_are_printed_whatever_is_left_out() {
    let root = folder();
    let mut child = start(
        root.path(),
        "exec \"$@\"",
        &["--json", "live", "gas.toml", "--no-open"],
    );
    let mut errors = BufReader::new(child.stderr.take().unwrap());
    let mut address = String::new();
    errors.read_line(&mut address).unwrap();
    assert!(address.starts_with("http://127.0.0.1:"), "{address}");
    signal(&child, "INT");
    let output = child.wait_with_output().unwrap();
    let object: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(object["address"], address.trim_end());
    assert_eq!(object["exit_code"], 0);

    let words = [
        "--quiet",
        "live",
        "gas.toml",
        "--no-open",
        "--listen",
        "0.0.0.0",
    ];
    let mut child = start(root.path(), "exec \"$@\"", &words);
    first_line(child.stdout.as_mut().unwrap());
    signal(&child, "INT");
    let (_, said) = end(child);
    assert!(
        said.contains("Warning: other machines") && !said.contains("saved every"),
        "{said}"
    );
}
