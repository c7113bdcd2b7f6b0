//! The program `carom` as a user calls it: run, check and detect.

use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

const SCENE: &str = "[box]\nseed = 3\n[[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\n\
                     count = 50\n[[molecule]]\nshape = \"tee\"\natom_radius = 0.01\natom_mass = 1.0\nat = [0.5, 0.5]\n\
                     [run]\nuntil = 0.5\nsample_interval = 0.1\nobserve = [\"energy\"]\n";

pub fn carom(folder: &Path, arguments: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_carom");
    Command::new(program)
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("the program starts")
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn a_scene_is_checked_and_run_and_its_folder_names_the_command() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("scene.toml"), SCENE).unwrap();
    let check = carom(
        root.path(),
        &[
            "check",
            "scene.toml",
            "--verbose",
            "--set",
            "gas.0.count=60",
        ],
    );
    assert!(check.status.success(), "{}", text(&check.stderr));
    let printed = text(&check.stdout);
    assert!(
        printed.starts_with("scene.toml: valid\n") && printed.contains("  60      gas   disc"),
        "{printed}"
    );
    assert!(
        printed.contains("molecule of 5 atoms") && printed.contains("5 samples of energy"),
        "{printed}"
    );
    for words in [
        "Not paid for",
        "size ratio",
        "speed ratio",
        "an estimate: molecules",
        "checkpoint",
    ] {
        assert!(printed.contains(words), "{words}: {printed}");
    }
    // Without that the answers, in ten lines.
    let check = carom(
        root.path(),
        &["check", "scene.toml", "--set", "gas.0.count=60"],
    );
    let printed = text(&check.stdout);
    for words in [
        "mean free time",
        "collisions, ",
        "mean free times",
        "of each body",
        "1/√number",
        "checkpoint",
    ] {
        assert!(printed.contains(words), "{words}: {printed}");
    }
    assert!(printed.lines().count() <= 11, "{printed}");
    assert!(!root.path().join("out").exists(), "a check writes nothing");

    let run = carom(
        root.path(),
        &["run", "scene.toml", "--until", "0.3", "--out", "run"],
    );
    assert!(run.status.success(), "{}", text(&run.stderr));
    let read = |name: &str| fs::read_to_string(root.path().join("run").join(name)).unwrap();
    let manifest: serde_json::Value = serde_json::from_str(&read("manifest.json")).unwrap();
    assert_eq!(manifest["complete"], true);
    assert_eq!(manifest["again"], "carom run run/config.toml");
    let summary: serde_json::Value = serde_json::from_str(&read("summary.json")).unwrap();
    assert_eq!(summary["overlapping_pairs"], 0);
    // A header, the start, and three samples.
    assert_eq!(read("energy.csv").lines().count(), 5);
    assert!(read("report.html").contains("scene.toml"));
}

/// Ten billion bodies are counted, not placed; a run of them is refused at once.
#[cfg(target_os = "linux")]
#[test]
fn more_bodies_than_the_memory_holds_are_refused_before_they_are_placed() {
    let root = tempfile::tempdir().unwrap();
    let gas = "[[gas]]\nradius = 1e-9\nmass = 1.0\nenergy = 1.0\ncount = 100000000\n";
    fs::write(root.path().join("huge.toml"), gas.repeat(100)).unwrap();
    let check = carom(root.path(), &["check", "huge.toml"]);
    assert!(check.status.success(), "{}", text(&check.stderr));
    let printed = text(&check.stdout);
    for words in [
        "10000000000",
        "were not placed",
        "at least 2000 GB",
        "carom run refuses it",
    ] {
        assert!(printed.contains(words), "{words}: {printed}");
    }
    let run = carom(root.path(), &["run", "huge.toml", "--out", "out"]);
    assert_eq!(run.status.code(), Some(2));
    let said = text(&run.stderr);
    assert!(
        said.contains("its 10000000000 bodies need at least 2000000000000 bytes"),
        "{said}"
    );
    assert!(!root.path().join("out").exists());
    fs::write(
        root.path().join("more.toml"),
        gas.replace("100000000", "200000000"),
    )
    .unwrap();
    let refused = carom(root.path(), &["check", "more.toml"]);
    assert!(
        text(&refused.stderr).contains("gas[0]")
            && text(&refused.stderr).contains("but 200000000 are requested")
    );
}

/// A disc that meets nothing but a bumper: its contacts are all that there are.
#[test]
fn a_contact_with_a_fixed_body_counts_for_the_one_that_moves() {
    let scene = "[box]\nsides = [5.0, 4.0]\n\
                 [[bumper]]\nradius = 0.6\nat = [1.0, 2.0]\n\
                 [[gas]]\nradius = 0.4\nmass = 2.0\ntemperature = 1.0\ncount = 1\n\
                 [run]\nuntil = 6000.0\n";
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("sinai.toml"), scene).unwrap();
    let check = carom(root.path(), &["check", "sinai.toml"]);
    let answer = text(&check.stdout);
    let line = answer.lines().find(|line| line.contains(" of each body"));
    let numbers: Vec<&str> = line
        .unwrap()
        .split(": ")
        .nth(1)
        .unwrap()
        .split(' ')
        .collect();
    assert_eq!(numbers[0], numbers[2], "{answer}");
}

#[test]
fn a_method_that_is_not_exact_is_named_everywhere_and_is_part_of_the_run() {
    let root = tempfile::tempdir().unwrap();
    let scene = format!("{SCENE}[method]\ndetector = \"fixed-step\"\nstep = 0.3\n");
    fs::write(root.path().join("scene.toml"), scene).unwrap();
    let check = carom(root.path(), &["check", "scene.toml", "--verbose"]);
    assert!(
        text(&check.stdout).contains("NOT EXACT"),
        "{}",
        text(&check.stdout)
    );
    assert!(text(&check.stdout).contains("not measured; `carom trade SCENE` measures it"));
    let run = carom(root.path(), &["run", "scene.toml", "--out", "run"]);
    assert!(run.status.success(), "{}", text(&run.stderr));
    let read = |name: &str| fs::read_to_string(root.path().join("run").join(name)).unwrap();
    let words = "overlap tests every 3e-1 natural times";
    for (name, words) in [
        ("report.html", "NOT EXACT"),
        ("manifest.json", words),
        ("summary.json", words),
    ] {
        assert!(read(name).contains(words), "{name}");
    }
    // A run is resumed with its own method only.
    let other = [
        "run",
        "scene.toml",
        "--set",
        "method.step=0.2",
        "--until",
        "0.6",
        "--out",
        "run",
        "--resume",
    ];
    let refused = carom(root.path(), &other);
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        text(&refused.stderr).contains("step = 0.3"),
        "{}",
        text(&refused.stderr)
    );
    for (change, said) in [
        ("method.tolerance=1e-9", "golden-secant"),
        ("method.step=0", "from 1e-15"),
        ("method.detector=magic", "bounding-circles"),
    ] {
        let refused = carom(root.path(), &["check", "scene.toml", "--set", change]);
        assert_eq!(refused.status.code(), Some(2), "{change}");
        assert!(
            text(&refused.stderr).contains(said),
            "{change}: {}",
            text(&refused.stderr)
        );
    }
}

#[test]
fn check_says_that_the_collisions_of_a_driven_run_are_extrapolated() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("scene.toml"), SCENE).unwrap();
    let said = |change: &[&str]| {
        let check = carom(root.path(), &[&["check", "scene.toml"], change].concat());
        assert!(check.status.success(), "{}", text(&check.stderr));
        text(&check.stdout)
    };
    let words = "extrapolated from a trial of the start";
    assert!(!said(&[]).contains(words));
    let inelastic = said(&["--set", "elasticity.default=0.9"]);
    assert!(inelastic.contains(words), "{inelastic}");
}

#[test]
fn several_faults_of_a_scene_are_named_in_one_message() {
    let root = tempfile::tempdir().unwrap();
    let refused = |scene: &str| {
        fs::write(root.path().join("scene.toml"), scene).unwrap();
        let check = carom(root.path(), &["check", "scene.toml"]);
        assert_eq!(check.status.code(), Some(2));
        text(&check.stderr)
    };
    let said = refused(&SCENE.replace("seed", "sed").replace("until", "untill"));
    for words in ["2 entries are invalid", "`seed`?", "`until`?"] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let scene = SCENE.replace("until = 0.5", "until = -1.0");
    let said = refused(&scene.replace("\"energy\"", "\"energi\", \"presure\""));
    for words in [
        "3 entries are invalid",
        "run.until",
        "`energy`?",
        "`pressure`?",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
}

#[test]
fn a_run_is_resumed_with_other_units_of_its_page() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("scene.toml"), SCENE).unwrap();
    let run = ["run", "scene.toml", "--out", "run"];
    assert!(carom(root.path(), &run).status.success());
    let page = || fs::read_to_string(root.path().join("run/report.html")).unwrap();
    assert!(!page().contains("in units of σ"));
    let units = "run.units={length=0.02,mass=1.0,energy=1.0}";
    let resume = ["--resume", "--until", "0.8", "--set", units];
    let resumed = carom(root.path(), &[&run[..], &resume].concat());
    assert!(resumed.status.success(), "{}", text(&resumed.stderr));
    assert!(page().contains("in units of σ = 0.02"));
    // The files keep the units of the scene: those of one run throughout.
    let throughout = ["run", "scene.toml", "--out", "throughout", "--until", "0.8"];
    assert!(carom(root.path(), &throughout).status.success());
    let tables = ["run", "throughout"]
        .map(|folder| fs::read(root.path().join(folder).join("energy.csv")).unwrap());
    assert!(tables[0] == tables[1]);
    // Any other entry is refused, and named.
    let other = ["--resume", "--set", "gas.0.count=51"];
    let refused = carom(root.path(), &[&run[..], &other].concat());
    let said = text(&refused.stderr);
    assert!(
        refused.status.code() == Some(2) && said.contains("gas[0].count = 50 differs from 51"),
        "{said}"
    );
}

#[test]
fn bad_input_has_exit_code_2_and_names_the_entry() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("scene.toml"), SCENE).unwrap();
    fs::write(
        root.path().join("endless.toml"),
        SCENE.replace("until = 0.5", "until = inf"),
    )
    .unwrap();
    for (arguments, word) in [
        (&["check", "missing.toml"][..], "missing.toml"),
        (
            &["check", "scene.toml", "--set", "gas.0.radius=-1"],
            "gas[0]",
        ),
        (
            &["check", "scene.toml", "--set", "run.observe=[\"warmth\"]"],
            "warmth",
        ),
        (&["run", "scene.toml", "--set", "run.until=0"], "run.until"),
        (
            &["run", "scene.toml", "--until", "inf"],
            "run.until must be positive and finite, but is inf",
        ),
        (
            &["run", "scene.toml", "--until=-1"],
            "run.until must be positive and finite, but is -1",
        ),
        (
            &[
                "run",
                "scene.toml",
                "--until",
                "1e308",
                "--set",
                "run.sample_interval=1e307",
            ],
            "run.until must be at most 1e300, but is 1e308",
        ),
        (
            &["live", "endless.toml"],
            "run.until must be positive and finite, but is inf",
        ),
        (
            &["check", "scene.toml", "--set", "box.sides=[1, 2, 3]"],
            "sides = [1, 2, 3]\n  |         ^^^^^^^^^\nthere must be two numbers [x, y], but there are 3: [1.0, 2.0, 3.0]",
        ),
        (
            &["detect", "missing.csv", "--out", "answers.csv"],
            "missing.csv",
        ),
        (&["fly"], "fly"),
    ] {
        let output = carom(root.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(
            text(&output.stderr).contains(word),
            "{arguments:?}: {}",
            text(&output.stderr)
        );
    }
}

#[test]
fn pairs_of_a_file_get_their_first_contacts() {
    let root = tempfile::tempdir().unwrap();
    let cases = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/encounters.csv");
    let output = carom(
        root.path(),
        &["detect", cases.to_str().unwrap(), "--out", "answers.csv"],
    );
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(
        text(&output.stdout).starts_with("450 encounters"),
        "{}",
        text(&output.stdout)
    );
    assert_eq!(
        fs::read_to_string(root.path().join("answers.csv"))
            .unwrap()
            .lines()
            .count(),
        451
    );
}

#[test]
#[expect(clippy::too_many_lines, reason = "one course with many looks")]
fn a_run_starts_from_a_snapshot_and_its_folder_stands_alone() {
    let root = tempfile::tempdir().unwrap();
    let at = |name: &str| root.path().join(name);
    fs::write(
        at("scene.toml"),
        SCENE.replace("[\"energy\"]\n", "[\"energy\"]\nsnapshots = \"extxyz\"\n"),
    )
    .unwrap();
    let run = |arguments: &[&str]| carom(root.path(), arguments);
    assert!(
        run(&["run", "scene.toml", "--out", "first"])
            .status
            .success()
    );
    let frames = fs::read_to_string(at("first/trajectory.extxyz")).unwrap();
    // 50 discs and a tee in each frame.
    let last: Vec<&str> = frames.lines().skip(5 * 57).collect();
    assert_eq!(last.len(), 57);
    fs::create_dir(at("second")).unwrap();
    let scene = format!(
        "[start]\nfrom = \"../first/trajectory.extxyz\"\n{}",
        fs::read_to_string(at("scene.toml")).unwrap()
    );
    fs::write(at("second/scene.toml"), scene).unwrap();
    let ended = run(&["run", "second/scene.toml", "--out", "out"]);
    assert!(ended.status.success(), "{}", text(&ended.stderr));
    let first_frame = |name: &str| -> Vec<Vec<f64>> {
        let text = fs::read_to_string(at(name)).unwrap();
        let rows = text.lines().skip(2).take(55);
        rows.map(|row| {
            row.split_whitespace()
                .skip(1)
                .map(|word| word.parse().unwrap())
                .collect()
        })
        .collect()
    };
    let (before, after) = (
        first_frame("out/start.extxyz"),
        first_frame("out/trajectory.extxyz"),
    );
    // The boxes crossed, in the last three columns, are counted from the start of a run.
    let discs = |rows: &[Vec<f64>]| -> Vec<Vec<f64>> {
        rows[5..].iter().map(|row| row[..17].to_vec()).collect()
    };
    assert_eq!(
        discs(&before),
        discs(&after),
        "the discs of the gas, to the bit"
    );
    for (before, after) in before.iter().zip(&after) {
        // Places and velocities.
        assert!(
            before[..5]
                .iter()
                .zip(&after[..5])
                .all(|(one, other)| (one - other).abs() < 1e-13)
        );
    }
    // The folder holds the frame: the first run is not needed any more, and the run is its own.
    let config = fs::read_to_string(at("out/config.toml")).unwrap();
    assert!(
        config.contains("from = \"start.extxyz\"") && config.contains("checksum = "),
        "{config}"
    );
    fs::rename(at("first"), at("elsewhere")).unwrap();
    fs::rename(at("out"), at("moved")).unwrap();
    let again = run(&["run", "moved/config.toml", "--out", "again"]);
    assert!(again.status.success(), "{}", text(&again.stderr));
    let trajectory = |name: &str| fs::read_to_string(at(name).join("trajectory.extxyz")).unwrap();
    assert_eq!(trajectory("moved"), trajectory("again"));
    let longer = run(&[
        "run",
        "moved/config.toml",
        "--out",
        "moved",
        "--resume",
        "--until",
        "0.8",
    ]);
    assert!(longer.status.success(), "{}", text(&longer.stderr));
    assert!(trajectory("moved").starts_with(&trajectory("again")));
    // An earlier frame, and what is refused.
    let check = |set: &str| {
        run(&[
            "check",
            "second/scene.toml",
            "--set",
            "start.from=../elsewhere/trajectory.extxyz",
            "--set",
            set,
        ])
    };
    assert!(check("start.frame=0").status.success());
    for (set, said) in [
        (
            "start.frame=6",
            "the file has 6 frames, numbered from 0; 6 is out of range",
        ),
        ("start.checksum=1", "but `start.checksum` is 1"),
        (
            "gas.0.count=49",
            "the file has 55 atoms, the bodies of the scene have 54",
        ),
        ("gas.0.radius=0.03", "the radius is 0.02, in the scene 0.03"),
        (
            "box.sides=[2, 1]",
            "the box of the file is 1 × 1, that of the scene 2 × 1",
        ),
        ("start.from=none.extxyz", "cannot read the file"),
        (
            "start.placement=grown",
            "give either `from`, or `placement`, `relax` and `empty_pockets`",
        ),
    ] {
        let refused = check(set);
        assert_eq!(refused.status.code(), Some(2), "{set}");
        assert!(
            text(&refused.stderr).contains(said),
            "{set}: {}",
            text(&refused.stderr)
        );
    }
    // Another start is another run.
    let changed = fs::read_to_string(at("moved/start.extxyz"))
        .unwrap()
        .replacen("Time=0.5", "Time=0.6", 1);
    fs::write(at("other.extxyz"), changed).unwrap();
    let other = [
        "run",
        "second/scene.toml",
        "--set",
        "start.from=../other.extxyz",
        "--out",
        "moved",
        "--resume",
    ];
    let refused = run(&other);
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        text(&refused.stderr).contains("checksum = "),
        "{}",
        text(&refused.stderr)
    );
}
