//! Sweeps as processes: killed at random moments, out of space, and two in one folder.

use std::{
    env, fs,
    io::Read as _,
    path::Path,
    process::{Child, Command, Output, Stdio},
    thread,
    time::{Duration, Instant},
};

/// Points and replicas that together take a few seconds on one processor.
const STUDY: &str = r#"
replicas = 6
measure = ["pressure"]
[[vary]]
key = "gas.0.count"
values = [200, 300, 400, 500]
[[scene.gas]]
radius = 0.012
mass = 1.0
temperature = 1.0
velocities = "maxwell"
[scene.box]
seed = 11
[scene.run]
until = 6.0
sample_interval = 0.1
"#;

fn command(folder: &Path, words: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_carom"));
    command.current_dir(folder).args(words.split_whitespace());
    command
}

fn carom(folder: &Path, words: &str) -> Output {
    command(folder, words).output().expect("the program starts")
}

fn start(folder: &Path, words: &str) -> Child {
    let mut command = command(folder, words);
    command
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts")
}

fn success(folder: &Path, words: &str) {
    let output = carom(folder, words);
    assert!(
        output.status.success(),
        "{words}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
}

fn place() -> tempfile::TempDir {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("study.toml"), STUDY).unwrap();
    root
}

/// Uniform numbers from 0 to 1 (Marsaglia, J. Stat. Soft. 8 (2003) 14: xorshift).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// 12 kills; `CAROM_KILLS=50` for more.
#[test]
fn shards_and_merges_killed_at_any_moment_give_the_digits_of_one_process() {
    let kills: u32 = env::var("CAROM_KILLS")
        .ok()
        .and_then(|text| text.parse().ok())
        .unwrap_or(12);
    let root = place();
    let path = root.path();
    let clock = Instant::now();
    success(path, "sweep study.toml --out whole --quiet");
    // A shard has a third of the work; kills come at any time in it, also at its start.
    let longest = clock.elapsed().mul_f64(0.4).max(Duration::from_millis(300));
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    let every = "--checkpoint-every 0.05 --quiet";
    let (mut done, mut killed) = ([false; 3], 0);
    for turn in 0..20 * kills {
        let index = (turn % 3) as usize;
        if killed >= kills && done.iter().all(|done| *done) {
            break;
        }
        let words = format!(
            "sweep study.toml --shard {}/3 --out shard-{index} {every}",
            index + 1
        );
        let mut child = start(path, &words);
        if killed >= kills {
            assert!(child.wait().unwrap().success(), "{}", errors(&mut child));
            done[index] = true;
            continue;
        }
        thread::sleep(longest.mul_f64(random.next().powi(2)));
        child.kill().unwrap();
        killed += u32::from(!child.wait().unwrap().success());
    }
    assert!(
        killed >= kills && done.iter().all(|done| *done),
        "{killed} kills"
    );
    // Merges are killed as well, and begin anew.
    for kill in 0..3 {
        let mut child = start(
            path,
            "merge shard-2 shard-0 shard-1 --out all --force --quiet",
        );
        thread::sleep(Duration::from_millis(20 + 60 * kill));
        child.kill().unwrap();
        child.wait().unwrap();
    }
    success(
        path,
        "merge shard-2 shard-0 shard-1 --out all --force --quiet",
    );
    let [merged, whole] =
        ["all", "whole"].map(|name| fs::read_to_string(path.join(name).join("table.csv")));
    assert_eq!(merged.unwrap(), whole.unwrap());
    assert!(
        fs::read_to_string(path.join("all/report.html"))
            .unwrap()
            .contains("All 4 points are complete")
    );
}

fn errors(child: &mut Child) -> String {
    let mut text = String::new();
    child
        .stderr
        .take()
        .map(|mut stream| stream.read_to_string(&mut text));
    text
}

#[test]
fn a_signal_ends_a_sweep_within_a_second_and_two_processes_do_not_share_a_folder() {
    let root = place();
    let path = root.path();
    let long = STUDY.replace("until = 6.0", "until = 1000.0");
    fs::write(path.join("long.toml"), long).unwrap();
    let mut first = start(path, "sweep long.toml --out out");
    let deadline = Instant::now() + Duration::from_secs(30);
    while !path.join("out/points").exists() && Instant::now() < deadline {
        thread::sleep(Duration::from_millis(20));
    }
    let second = carom(path, "sweep long.toml --out out");
    let words = String::from_utf8_lossy(&second.stderr).into_owned();
    assert!(
        !second.status.success() && words.contains("another process writes into out"),
        "{words}"
    );
    let killed = Command::new("kill")
        .args(["-TERM", &first.id().to_string()])
        .status()
        .unwrap();
    assert!(killed.success());
    let status = first.wait().unwrap();
    assert_eq!(status.code(), Some(143), "{}", errors(&mut first));
    // Each replica in progress has a checkpoint.
    let points = fs::read_dir(path.join("out/points"))
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let inner = points.flat_map(|point| {
        fs::read_dir(point)
            .unwrap()
            .map(|entry| entry.unwrap().path())
    });
    assert!(
        inner
            .filter(|folder| folder.join("checkpoint").is_file())
            .count()
            > 0
    );
}

#[test]
fn a_full_disk_ends_a_sweep_with_an_error_and_loses_nothing() {
    let root = place();
    let path = root.path();
    let small = STUDY.replace("until = 6.0", "until = 1.0");
    fs::write(path.join("study.toml"), &small).unwrap();
    success(path, "sweep study.toml --out whole --quiet");
    // Files of at most a kibibyte: the study fits, and no replica does. The signal of the system is
    // ignored, so that the write fails as on a full disk.
    let program = env!("CARGO_BIN_EXE_carom");
    let limited =
        format!("trap '' XFSZ; ulimit -f 1; exec {program} sweep study.toml --out out --quiet");
    let output = Command::new("bash")
        .current_dir(path)
        .args(["-c", &limited])
        .output()
        .unwrap();
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        !output.status.success() && words.contains("cannot write"),
        "{words}"
    );
    assert!(!path.join("out/table.csv").exists());
    success(path, "sweep study.toml --out out --quiet");
    let [again, whole] =
        ["out", "whole"].map(|name| fs::read_to_string(path.join(name).join("table.csv")));
    assert_eq!(again.unwrap(), whole.unwrap());
}

/// Exit code and JSON object of a quiet command.
fn incomplete(folder: &Path, words: &str) -> serde_json::Value {
    let output = carom(folder, &format!("{words} --quiet --json"));
    assert_eq!(
        output.status.code(),
        Some(3),
        "{words}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    let object: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        (&object["verdict"], &object["exit_code"]),
        (&"incomplete".into(), &3.into())
    );
    assert!(!object["notes"].as_array().unwrap().is_empty(), "{object}");
    object
}

fn page(folder: &Path, name: &str) -> String {
    fs::read_to_string(folder.join(name).join("report.html")).unwrap()
}

#[test]
fn scripts_see_what_a_merge_lacks() {
    let root = place();
    let path = root.path();
    fs::write(
        path.join("study.toml"),
        STUDY.replace("until = 6.0", "until = 0.5"),
    )
    .unwrap();
    success(path, "sweep study.toml --shard 1/2 --out shard --quiet");
    let object = incomplete(path, "merge shard --out part");
    let missing = object["missing"].as_array().unwrap();
    assert!(
        !missing.is_empty() && missing[0]["replicas"].is_array(),
        "{object}"
    );
    assert_eq!(object["damaged"], serde_json::json!([]));
    // Among the results, which --quiet keeps.
    let output = carom(path, "merge shard --out part --force --quiet");
    assert_eq!(output.status.code(), Some(3));
    assert!(String::from_utf8_lossy(&output.stdout).contains("Incomplete: "));

    let scene = "[[gas]]\nradius = 0.03\nmass = 1.0\nenergy = 1.0\ncount = 20\n[run]\nuntil = 0.5\n\
                 sample_interval = 0.05\nobserve = [\"pressure\"]\n";
    fs::write(path.join("scene.toml"), scene).unwrap();
    for replica in 0..3 {
        success(
            path,
            &format!("run scene.toml --set box.replica={replica} --out r{replica} --quiet"),
        );
    }
    success(path, "merge r0 r1 r2 --out all --quiet");
    let sums = fs::read(path.join("r1/sums")).unwrap();
    fs::write(path.join("r1/sums"), &sums[..sums.len() / 2]).unwrap();
    fs::remove_file(path.join("r2/sums")).unwrap();
    let object = incomplete(path, "merge r0 r1 r2 --out some");
    assert_eq!(object["damaged"][0]["file"], "r1/sums");
    assert_eq!(object["missing"][0]["folder"], "r2");
    let head = page(path, "some");
    assert!(
        head.contains("r1/sums: it is truncated") && head.contains("Missing is the run in r2"),
        "{head}"
    );
    success(path, "report some --quiet");
    assert_eq!(page(path, "some"), head);
    let output = carom(path, "merge r1 r2 --out none");
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("nothing to merge"));
}

#[test]
fn a_run_ends_by_its_own_rule_and_its_page_says_so() {
    let root = place();
    let scene = "[[gas]]\nradius = 0.03\nmass = 1.0\nenergy = 1.0\ncount = 50\n[run]\nuntil = 100.0\n\
                 sample_interval = 0.05\nsnapshots = \"extxyz\"\nsnapshot_interval = 0.5\nanimation_from = 90.0\n\
                 [run.stop]\ncollisions = 2000\n";
    fs::write(root.path().join("scene.toml"), scene).unwrap();
    success(root.path(), "check scene.toml");
    success(root.path(), "run scene.toml --out a --quiet");
    let page = fs::read_to_string(root.path().join("a/report.html")).unwrap();
    assert!(page.contains("by the rule in run.stop") && !page.contains("Missing from the folder"));
    let summary = fs::read_to_string(root.path().join("a/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let (collisions, time) = (
        summary["collisions"].as_u64().unwrap(),
        summary["simulated_time"].as_f64().unwrap(),
    );
    assert!(
        (2000..2200).contains(&collisions) && time < 20.0,
        "{collisions} {time}"
    );
    // A run that has ended is not run again, and a later end changes nothing.
    success(root.path(), "run scene.toml --out a --resume --quiet");
    success(
        root.path(),
        "run scene.toml --out a --resume --until 200 --quiet",
    );
    let again = fs::read_to_string(root.path().join("a/summary.json")).unwrap();
    let again: serde_json::Value = serde_json::from_str(&again).unwrap();
    assert_eq!(again["collisions"], summary["collisions"]);
}

#[test]
fn a_study_with_vectors_of_three_numbers_is_refused() {
    let root = place();
    for (from, to) in [
        (
            "key = \"gas.0.count\"\nvalues = [200, 300, 400, 500]",
            "key = \"box.sides\"\nvalues = [[1, 1], [1, 2, 3]]",
        ),
        ("[scene.box]\n", "[scene.box]\nsides = [1, 2, 3]\n"),
    ] {
        fs::write(root.path().join("study.toml"), STUDY.replace(from, to)).unwrap();
        let refused = carom(root.path(), "sweep study.toml --out out");
        let said = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert_eq!(refused.status.code(), Some(2), "{said}");
        assert!(said.contains("sides = [1, 2, 3]"), "{said}");
        assert!(
            said.contains("there must be two numbers [x, y], but there are 3: [1.0, 2.0, 3.0]"),
            "{said}"
        );
        assert!(!root.path().join("out").exists());
    }
}
