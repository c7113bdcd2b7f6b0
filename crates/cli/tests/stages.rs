//! Scenes in stages: against the same edits by code, against a run with `measure_from`, killed and
//! resumed, and started from another run.

use std::{
    fs,
    path::Path,
    process::{Command, Output, Stdio},
    thread::sleep,
    time::{Duration, Instant},
};

use carom::{
    BodyKey, Scene, Simulation,
    engine::{DrawKey, ElasticitySpec, Rotation, ThermostatRule, ThermostatTarget},
    observers::write_extended_xyz,
};
use serde_json::Value;
use tempfile::TempDir;

/// Two gases, a tee and a bumper with a tag of the hot gas.
const BODIES: &str = r#"
[box]
seed = 9
[[molecule]]
tags = ["tee"]
shape = "tee"
atom_radius = 0.02
atom_mass = 1.0
at = [0.5, 0.5]
angular_velocity = 1.0
[[bumper]]
tags = ["hot"]
radius = 0.05
at = [0.1, 0.1]
[[gas]]
tags = ["hot"]
radius = 0.02
mass = 1.0
energy = 1.0
count = 40
[[gas]]
tags = ["cold"]
radius = 0.02
mass = 1.0
energy = 1.0
count = 40
"#;

fn carom(folder: &Path, arguments: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_carom");
    Command::new(program)
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A folder with a scene that has been run into `out`.
fn run(scene: &str, arguments: &[&str]) -> TempDir {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("scene.toml"), scene).unwrap();
    let output = carom(
        root.path(),
        &[&["run", "scene.toml", "--out", "out"], arguments].concat(),
    );
    assert!(output.status.success(), "{}", text(&output.stderr));
    root
}

fn read(root: &TempDir, name: &str) -> String {
    fs::read_to_string(root.path().join("out").join(name)).unwrap()
}

fn summary(root: &TempDir) -> Value {
    serde_json::from_str(&read(root, "summary.json")).unwrap()
}

/// Value and standard error of a figure.
fn figure(root: &TempDir, name: &str) -> (f64, f64) {
    let summary = summary(root);
    let figures = summary["figures"].as_array().unwrap();
    let found = figures.iter().find(|figure| figure["name"] == name);
    let figure = found.unwrap_or_else(|| panic!("no figure {name}: {figures:#?}"));
    (
        figure["value"].as_f64().unwrap(),
        figure["standard_error"].as_f64().unwrap_or(f64::NAN),
    )
}

/// The last frame of the trajectory.
fn last_frame(root: &TempDir) -> String {
    let frames = read(root, "trajectory.extxyz");
    let lines: Vec<&str> = frames.lines().collect();
    let first = lines
        .iter()
        .rposition(|line| line.starts_with("Lattice"))
        .unwrap()
        - 1;
    lines[first..].join("\n")
}

fn frame(simulation: &Simulation) -> String {
    let mut frame = Vec::new();
    write_extended_xyz(&simulation.view(), &mut frame).unwrap();
    text(&frame).trim_end().to_owned()
}

#[test]
fn thermostats_equal_the_same_edits_by_code_to_the_bit() {
    let scene = format!(
        "{BODIES}[run]\nsample_interval = 0.25\nsnapshots = \"extxyz\"\nobserve = [\"energy\", \"thermostat\"]\n\
         [elasticity]\ndefault = 0.95\n[[stage]]\nuntil = 0.5\n\
         thermostat = [{{ tag = \"hot\", every = 0.1, energy = 4.0 }},\n\
         {{ tag = \"cold\", every = 0.25, kind = \"maxwell\", temperature = 0.25 }}]\n"
    );
    let root = run(&scene, &[]);
    let mut simulation = Simulation::new(&Scene::from_toml(&scene).unwrap()).unwrap();
    let [hot, cold] = ["hot", "cold"].map(|name| simulation.find_tag(name).unwrap());
    let mut heats = [0.0; 2];
    for (time, tag, action) in [
        (0.0, hot, 0),
        (0.0, cold, 1),
        (0.1, hot, 2),
        (0.2, hot, 3),
        (0.25, cold, 4),
        (0.1 * 3.0, hot, 5),
        (0.4, hot, 6),
    ] {
        simulation.run_until(time).unwrap();
        let before = simulation.view().energy();
        if tag == hot {
            simulation
                .edit(|batch| batch.reset_energy_of_tag(hot, 4.0))
                .unwrap();
        } else {
            let key = DrawKey {
                seed: 9,
                replica: 0,
                action,
            };
            let rule = ThermostatRule::Maxwell(ThermostatTarget::Temperature(0.25));
            simulation
                .edit(|batch| batch.thermostat(cold, &rule, key))
                .unwrap();
        }
        heats[usize::from(tag == cold)] += simulation.view().energy() - before;
    }
    simulation.run_until(0.5).unwrap();
    assert!(
        last_frame(&root) == frame(&simulation),
        "the last frames differ"
    );
    // The heat by tag, and the ledger: E(0.5) − E(0) = put in − lost.
    let rows = |name: &str, header: &str| -> Vec<Vec<f64>> {
        let table = read(&root, name);
        let mut lines = table.lines();
        assert_eq!(lines.next(), Some(header));
        lines
            .map(|line| {
                line.split(',')
                    .map(|number| number.parse().unwrap())
                    .collect()
            })
            .collect()
    };
    let heat = rows("heat.csv", "time,duration,hot,cold");
    let rows = rows("thermostat.csv", "time,duration,put_in,lost,heat,energy");
    let sum = |column: usize| rows.iter().map(|row| row[column]).sum::<f64>();
    let given = |column: usize| heat.iter().map(|row| row[column]).sum::<f64>();
    let scale = heats[0].abs() + heats[1].abs();
    assert!(
        (given(2) - heats[0]).abs() < 1e-10 * scale && (given(3) - heats[1]).abs() < 1e-10 * scale
    );
    assert!((sum(2) - heats[0] - heats[1]).abs() < 1e-10 * scale);
    assert!(sum(3) > 1.0, "contacts lose energy");
    let start = Simulation::new(&Scene::from_toml(&scene).unwrap())
        .unwrap()
        .view()
        .energy();
    assert!((rows[1][5] - start - sum(2) + sum(3)).abs() < 1e-10 * scale);
}

#[test]
fn edits_at_the_start_of_a_stage_equal_those_by_code_to_the_bit() {
    let scene = format!(
        "{BODIES}[run]\nsample_interval = 0.25\nsnapshots = \"extxyz\"\n[[stage]]\nuntil = 0.3\n[[stage]]\n\
         until = 0.6\nremove = [\"cold\"]\nelasticity = {{ default = 0.9 }}\nlock = [\"tee\"]\n\
         tag = [{{ of = \"hot\", name = \"first\", count = 3 }}]\n\
         set_energy = [{{ tag = \"first\", energy = 5.0 }}]\n[[stage.add]]\nshape = \"dumbbell\"\n\
         atom_radius = 0.001\natom_mass = 1.0\nat = [0.9, 0.9]\nvelocity = [1.0, 0.0]\ntags = [\"new\"]\n\
         [[stage]]\nuntil = 0.8\ntag = [{{ name = \"moving\" }}]\nset_energy = [{{ tag = \"moving\", energy = 2.0 }}]\n"
    );
    let root = run(&scene, &[]);
    let scene = Scene::from_toml(&scene).unwrap();
    let mut simulation = Simulation::new(&scene).unwrap();
    simulation.run_until(0.3).unwrap();
    let keys = |name: &str| -> Vec<BodyKey> {
        let tag = simulation.find_tag(name).unwrap();
        simulation
            .view()
            .tagged(tag)
            .map(|body| body.body.key())
            .collect()
    };
    let (cold, hot, tee) = (keys("cold"), keys("hot"), keys("tee"));
    simulation
        .edit(|batch| {
            cold.iter().try_for_each(|&key| batch.remove(key))?;
            batch.add(&scene.stage[1].add[0])?;
            hot[..3]
                .iter()
                .try_for_each(|&key| batch.tag(key, "first").map(|_| ()))?;
            batch.set_elasticity(&ElasticitySpec {
                default: 0.9,
                ..ElasticitySpec::default()
            })?;
            batch.set_rotation(tee[0], Rotation::Locked)?;
            // The first of the three is the bumper, which has no energy.
            hot[1..3]
                .iter()
                .try_for_each(|&key| batch.reset_energy(key, 5.0))
        })
        .unwrap();
    simulation.run_until(0.6).unwrap();
    assert!(simulation.view().ledger().lost > 0.0);
    let moving = simulation
        .view()
        .bodies()
        .filter(|body| !body.body.is_fixed());
    let moving: Vec<BodyKey> = moving.map(|body| body.body.key()).collect();
    simulation
        .edit(|batch| {
            moving
                .iter()
                .try_for_each(|&key| batch.tag(key, "moving").map(|_| ()))?;
            batch.reset_energy_of_all(2.0)
        })
        .unwrap();
    simulation.run_until(0.8).unwrap();
    assert!(
        last_frame(&root) == frame(&simulation),
        "the last frames differ"
    );
}

#[test]
fn a_stage_that_equilibrates_equals_measure_from_to_the_digit() {
    let observe = "sample_interval = 0.1\nobserve = [\"energy\", \"collision-rate\", \"pressure\", \
                   \"velocities:cold\", \"correlation:cold\", \"temperature:hot\", \"free-path\"]\n";
    let short = run(
        &format!("{BODIES}[run]\nuntil = 3.0\nmeasure_from = 1.0\n{observe}"),
        &[],
    );
    let staged = run(
        &format!(
            "{BODIES}[run]\n{observe}[[stage]]\nuntil = 1.0\nmeasure = false\n[[stage]]\nuntil = 3.0\n"
        ),
        &[],
    );
    // A measured stage between others: nothing before or after it counts.
    let between = run(
        &format!(
            "{BODIES}[run]\n{observe}[[stage]]\nuntil = 1.0\nmeasure = false\n[[stage]]\nuntil = 3.0\n[[stage]]\n\
             until = 3.45\nmeasure = false\n"
        ),
        &[],
    );
    let mut compared = 0;
    for entry in fs::read_dir(short.path().join("out")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        if Path::new(&name)
            .extension()
            .is_some_and(|ending| ending == "csv")
        {
            assert_eq!(read(&short, &name), read(&staged, &name), "{name}");
            if !["energy.csv", "flights.csv"].contains(&name.as_str()) {
                assert_eq!(read(&short, &name), read(&between, &name), "{name}");
            }
            compared += 1;
        }
    }
    assert!(compared > 6, "{compared}");
    let of_run = |root: &TempDir| summary(root)["figures"].clone();
    assert_eq!(of_run(&short), of_run(&staged));
}

#[test]
fn intervals_with_thermostat_actions_count_all_their_contacts() {
    // Six actions in each interval between samples, and a stage that starts within one.
    let thermostat =
        "thermostat = [{ tag = \"cold\", every = 0.05, kind = \"maxwell\", temperature = 1.0 }]\n";
    let root = run(
        &format!(
            "{BODIES}[run]\nsample_interval = 0.3\nobserve = [\"collision-rate\", \"pressure\", \"pressure-tensor\"]\n\
             [[stage]]\nuntil = 1.0\n{thermostat}[[stage]]\nuntil = 3.0\nremove = [\"tee\"]\n{thermostat}"
        ),
        &[],
    );
    let column = |file: &str, name: &str| -> Vec<f64> {
        let table = read(&root, file);
        let mut lines = table.lines().map(|line| line.split(','));
        let index = lines
            .next()
            .unwrap()
            .position(|heading| heading == name)
            .unwrap();
        lines
            .map(|mut line| line.nth(index).unwrap().parse().unwrap())
            .collect()
    };
    let collisions: f64 = column("collision-rate.csv", "collisions").iter().sum();
    assert_eq!(Some(collisions), summary(&root)["collisions"].as_f64());
    // Both compute the momentum flux, from different sums.
    let (xx, yy) = (
        column("pressure-tensor.csv", "p_xx"),
        column("pressure-tensor.csv", "p_yy"),
    );
    let flux = column("pressure.csv", "momentum_flux");
    assert_eq!((flux.len(), xx.len()), (10, 10));
    for ((xx, yy), flux) in xx.into_iter().zip(yy).zip(flux) {
        assert!(
            (0.5 * (xx + yy) / flux - 1.0).abs() < 1e-12,
            "{xx} {yy} {flux}"
        );
    }
}

/// Results of the run in `folder`, without those of processes and without speeds.
fn results(folder: &Path) -> Vec<(String, String)> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if ["manifest.json", "checkpoint", "start-state"].contains(&name.as_str()) {
            continue;
        }
        // The sums are not text.
        let bytes = fs::read(&path).unwrap();
        let text = String::from_utf8_lossy(&bytes);
        let has_no_speed = |line: &&str| {
            !["collisions_per_second", "per processor second"]
                .iter()
                .any(|speed| line.contains(speed))
        };
        files.push((
            name,
            text.lines()
                .filter(has_no_speed)
                .collect::<Vec<_>>()
                .join("\n"),
        ));
    }
    files.sort();
    files
}

/// Stages with edits, and thermostats that act more often than an epoch lasts.
const STAGES: &str = r#"
[run]
sample_interval = 0.1
snapshot_interval = 0.7
check_interval = 0.3
observe = ["energy", "thermostat", "velocities:hot", "pressure"]
snapshots = "extxyz"
[[stage]]
until = 1.0
measure = false
thermostat = [{ tag = "hot", every = 0.01, kind = "maxwell", temperature = 2.0 }]
[[stage]]
until = 4.0
elasticity = { default = 0.9 }
lock = ["tee"]
tag = [{ of = "cold", name = "half", count = 20 }]
thermostat = [{ tag = "half", every = 0.003, kind = "maxwell", energy = 1.0 },
              { tag = "hot", every = 0.01, temperature = 2.0 }]
[[stage]]
until = 12.05
unlock = ["tee"]
set_velocity = [{ tag = "tee", velocity = [0.5, 0.0], angular_velocity = -1.0 }]
set_energy = [{ tag = "cold", kind = "maxwell", temperature = 1.0 }]
thermostat = [{ tag = "hot", every = 0.007, kind = "maxwell", temperature = 2.0 }]
"#;

/// Rules that set velocities; the axes of discs are kept with the run.
const RULES: &str = r#"
[run]
sample_interval = 0.1
observe = ["energy", "thermostat", "correlation:cold"]
snapshots = "extxyz"
[[stage]]
until = 1.0
thermostat = [{ tag = "cold", every = 0.01, kind = "active", speed = 2.0, rotational_diffusion = 3.0 },
              { tag = "tee", every = 0.02, kind = "active", speed = 1.0, rotational_diffusion = 1.0,
                translational_diffusion = 0.01 }]
[[stage]]
until = 8.0
tag = [{ of = "cold", name = "half", count = 20 }]
thermostat = [{ tag = "half", every = 0.02, kind = "active", speed = 2.0, rotational_diffusion = 3.0 },
              { tag = "tee", every = 0.01, kind = "langevin", friction = 2.0, temperature = 1.0 },
              { tag = "cold", every = 0.07, kind = "rotate" }]
[[stage]]
until = 12.05
elasticity = { default = 0.9 }
thermostat = [{ tag = "cold", every = 0.01, kind = "kick", momentum = 0.1 },
              { tag = "tee", every = 0.03, kind = "kick", momentum = [0.1, -0.1] }]
"#;

/// Kills and resumes a run at random moments; returns how often it was killed.
fn killed(folder: &Path, words: &[&str], longest: Duration) -> usize {
    let (mut killed, mut random) = (0, 12_345_u64);
    for attempt in 0..10 {
        let resume: &[&str] = if attempt == 0 { &[] } else { &["--resume"] };
        let mut child = Command::new(env!("CARGO_BIN_EXE_carom"))
            .current_dir(folder)
            .args([words, resume].concat())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        // xorshift (Marsaglia, J. Stat. Soft. 8 (2003) 14).
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        sleep(longest.mul_f64((random >> 11) as f64 / (1u64 << 53) as f64));
        killed += usize::from(child.try_wait().unwrap().is_none());
        let _ = child.kill();
        let output = child.wait_with_output().unwrap();
        assert_ne!(output.status.code(), Some(2), "{}", text(&output.stderr));
    }
    let output = carom(folder, &[words, &["--resume"]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    killed
}

const RUN: [&str; 6] = [
    "run",
    "scene.toml",
    "--out",
    "out",
    "--checkpoint-every",
    "0.01",
];

/// The folder of a run of a scene that was killed again and again, which ended with the results of
/// one that was not.
fn killed_and_resumed(scene: &str) -> TempDir {
    let begun = Instant::now();
    let straight = run(scene, &[]);
    let duration = begun.elapsed();
    let place = tempfile::tempdir().unwrap();
    fs::write(place.path().join("scene.toml"), scene).unwrap();
    let times = killed(place.path(), &RUN, duration / 6);
    assert!(times > 3, "{times}");
    assert_eq!(
        results(&place.path().join("out")),
        results(&straight.path().join("out"))
    );
    place
}

#[test]
fn a_run_in_stages_killed_at_any_moment_resumes_to_the_bit_and_can_be_extended() {
    let scene = format!("{BODIES}{STAGES}");
    let place = killed_and_resumed(&scene);

    let longer = run(&scene, &["--until", "13"]);
    let extended = carom(
        place.path(),
        &[&RUN[..], &["--until", "13", "--resume"]].concat(),
    );
    assert!(extended.status.success(), "{}", text(&extended.stderr));
    assert_eq!(
        results(&place.path().join("out")),
        results(&longer.path().join("out"))
    );
    // A run is resumed with its own stages only.
    let other = [
        &RUN[..],
        &["--until", "14", "--resume", "--set", "stage.0.until=0.9"],
    ]
    .concat();
    let refused = carom(place.path(), &other);
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        text(&refused.stderr).contains("another run"),
        "{}",
        text(&refused.stderr)
    );
}

#[test]
fn a_run_with_rules_of_velocities_killed_at_any_moment_resumes_to_the_bit() {
    killed_and_resumed(&format!("{BODIES}{RULES}"));
}

#[test]
fn maxwell_thermostats_bring_gases_to_their_temperature() {
    let gas = "[box]\nseed = 4\n[[gas]]\ntags = [\"gas\"]\nradius = 0.008\nmass = 3.0\nenergy = 1.0\ncount = 300\n\
               [[gas]]\ntags = [\"rods\"]\nshape = \"rod:3\"\natom_radius = 0.006\natom_mass = 1.0\nenergy = 1.0\n\
               count = 60\n";
    // Without a thermostat, the inelastic gas would lose most of its energy in this time.
    for elasticity in [1.0, 0.98] {
        let scene = format!(
            "{gas}elasticity.default = {elasticity}\n[run]\nsample_interval = 0.02\n\
             observe = [\"temperature:gas\", \"temperature:rods\", \"energy\"]\n[[stage]]\nuntil = 0.4\nmeasure = false\n\
             thermostat = [{{ tag = \"gas\", every = 0.005, kind = \"maxwell\", temperature = 2.5 }}]\n[[stage]]\n\
             until = 6.0\nthermostat = [{{ tag = \"gas\", every = 0.005, kind = \"maxwell\", temperature = 2.5 }}]\n"
        )
        .replace("elasticity.default", "[elasticity]\ndefault");
        let root = run(&scene, &[]);
        let (kt, error) = figure(&root, "kT of the translation, gas");
        assert!(
            error < 0.01 * kt && (kt - 2.5).abs() < 4.0 * error,
            "{kt} ± {error} at e = {elasticity}"
        );
        if elasticity == 1.0 {
            // The rods get it from the gas by contacts.
            for name in ["kT of the translation, rods", "kT of the rotation, rods"] {
                let (kt, error) = figure(&root, name);
                assert!(
                    error < 0.1 * kt && (kt - 2.5).abs() < 4.0 * error,
                    "{name}: {kt} ± {error}"
                );
            }
        }
        for check in summary(&root)["checks"].as_array().unwrap() {
            assert_eq!(check["passed"], true, "{check}");
        }
    }
}

/// Asserts that a scene with these keys is refused in these words and leaves no folder.
fn assert_refused(added: &str, said: &str) {
    let root = tempfile::tempdir().unwrap();
    // Keys of [run] stand before the tables.
    let (run, tables) = added
        .split_once('\n')
        .filter(|_| added.starts_with("run."))
        .unwrap_or(("", added));
    fs::write(
        root.path().join("scene.toml"),
        format!("{run}\n{BODIES}{tables}"),
    )
    .unwrap();
    for command in [
        &["check", "scene.toml"][..],
        &["run", "scene.toml", "--out", "out"],
    ] {
        let output = carom(root.path(), command);
        let found = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{added}: {found}");
        assert!(found.contains(said), "{added}: {found}");
    }
    assert!(!root.path().join("out").exists(), "{added}");
}

#[test]
fn contradictory_and_unknown_keys_are_refused_by_name() {
    let stage = "[[stage]]\nuntil = 1.0\n";
    for (added, said) in [
        (
            "run.until = 2.0\n[[stage]]\nuntil = 1.0\n",
            "run: `until` = 2 differs",
        ),
        (
            "run.measure_from = 0.5\n[[stage]]\nuntil = 3.0\n",
            "run.measure_from cannot be given with [[stage]]",
        ),
        (
            "[[stage]]\nuntil = 1.0\n[[stage]]\nuntil = 0.5\n",
            "stage[1]: `until` must be finite and later",
        ),
        ("[[stage]]\nname = \"x\"\n", "stage[0]: `until` is missing"),
        (&format!("{stage}heat = 1\n"), "unknown field `heat`"),
        (
            &format!("{stage}lock = [\"tee\"]\nunlock = [\"tee\"]\n"),
            "in `lock` and in `unlock`",
        ),
        (&format!("{stage}lock = [\"hot\"]\n"), "stage[0].lock[0]"),
        (
            &format!("{stage}lock = [\"warm\"]\n"),
            "stage[0].lock: no body carries the tag \"warm\"",
        ),
        (
            &format!("{stage}set_energy = [{{ tag = \"hot\" }}]\n"),
            "stage[0].set_energy[0]: give either",
        ),
        (
            &format!(
                "{stage}thermostat = [{{ tag = \"hot\", every = 0.1, energy = 1, temperature = 1 }}]\n"
            ),
            "stage[0].thermostat[0]: give either",
        ),
        (
            &format!("{stage}thermostat = [{{ tag = \"hot\", every = 0.0, energy = 1 }}]\n"),
            "thermostat[0].every",
        ),
        (
            &format!("{stage}thermostat = [{{ tag = \"hot\", every = 0.1, energy = -1 }}]\n"),
            "above 0",
        ),
        (
            &format!("{stage}thermostat = [{{ tag = \"hot\", energy = 1 }}]\n"),
            "`every` is missing",
        ),
        (
            &format!("{stage}elasticity = {{ default = -1 }}\n"),
            "stage[0].elasticity",
        ),
        (
            &format!(
                "{stage}[[stage]]\nuntil = 2.0\n[[stage.add]]\nshape = \"tee\"\nat = [0, 0]\n"
            ),
            "stage[1].add[0]",
        ),
        (
            &format!("{stage}[[stage]]\nuntil = 2.0\nmeasure = false\n[[stage]]\nuntil = 3.0\n"),
            "stage[2]: stages that are measured must follow",
        ),
        ("run.snapshot_interval = 0.5\n", "run.snapshots is not"),
        ("run.check_interval = 0.0\n", "run.check_interval"),
    ] {
        assert_refused(added, said);
    }
}

#[test]
fn velocities_that_cannot_be_set_are_refused_by_name() {
    let stage = "[[stage]]\nuntil = 1.0\n";
    for (added, said) in [
        (
            format!(
                "{stage}set_energy = [{{ tag = \"cold\", kind = \"active\", energy = 1.0 }}]\n"
            ),
            "stage[0].set_energy[0]: kind = \"active\" acts at regular times",
        ),
        (
            format!("{stage}thermostat = [{{ tag = \"hot\", every = 0.1, kind = \"rotate\" }}]\n"),
            "stage[0].thermostat[0]: body 1 (tag hot) is fixed",
        ),
        (
            format!("{stage}set_velocity = [{{ tag = \"hot\", velocity = [1, 0] }}]\n"),
            "stage[0].set_velocity[0]: body 1 (tag hot) is fixed",
        ),
        (
            format!("{stage}set_velocity = [{{ tag = \"cold\", angular_velocity = 1 }}]\n"),
            "cannot turn, since it is locked or a single disc",
        ),
        (
            format!("{stage}set_velocity = [{{ velocity = [1, 0] }}]\n"),
            "stage[0].set_velocity[0]: give either `tag` or `body`",
        ),
        (
            format!("{stage}set_velocity = [{{ tag = \"cold\", velocity = [1e61, 0] }}]\n"),
            "stage[0].set_velocity[0]: body",
        ),
    ] {
        assert_refused(&added, said);
    }
}

/// Contents that the new scene leaves out are those of the other run; its rules are its own.
#[test]
fn a_run_from_another_takes_bonds_and_leaves_wells() {
    let first = "[box]\nseed = 2\n\
                 [[container]]\ncircle = { at = [0.5, 0.5], radius = 0.45 }\n\
                 [[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 40\n\
                 chain = { members = 4, tether = { max = 0.06 } }\n\
                 [[well]]\nbetween = [\"gas\"]\nsteps = [[1.5, -1.0]]\n\
                 [[stage]]\nuntil = 0.5\n\
                 [[stage]]\nuntil = 1.0\nwell = [{ between = [\"gas\"], steps = [[1.2, 2.0]] }]\n\
                 [run]\nuntil = 1.0\nsample_interval = 0.5\n";
    let root = run(first, &[]);
    let well = "[[well]]\nbetween = [\"gas\"]\nsteps = [[1.3, -0.25]]\n";
    let end = "[run]\nuntil = 0.5\nsample_interval = 0.5\nobserve = [\"wells\"]\n";
    for (name, wells) in [("with", well), ("without", "")] {
        fs::write(root.path().join("second.toml"), format!("{wells}{end}")).unwrap();
        let words = ["run", "second.toml", "--from", "out", "--out", name];
        let output = carom(root.path(), &words);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let read = |file: &str| fs::read_to_string(root.path().join(name).join(file)).unwrap();
        // All energies are multiples of the depth of the new well.
        let series = read("wells.csv");
        for line in series.lines().skip(1) {
            let energy: f64 = line.split(',').nth(1).unwrap().parse().unwrap();
            let fits = energy <= 0.0 && (4.0 * energy).fract() == 0.0;
            assert!(
                fits && (energy == 0.0) == wells.is_empty(),
                "{name}: {series}"
            );
        }
        let config = read("config.toml");
        let has = |words: &str| config.contains(words);
        assert!(has("chain") && has("container"), "{config}");
        assert_eq!(has("steps = "), !wells.is_empty(), "{config}");
    }
}

#[test]
fn a_run_starts_from_the_end_of_another_and_resumes_without_it() {
    let gas = "[box]\nseed = 2\n[[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100\n";
    let first = format!("{gas}[run]\nuntil = 1.0\nsample_interval = 0.5\nsnapshots = \"extxyz\"\n");
    let root = run(&first, &[]);
    let second = "[elasticity]\ndefault = 0.9\n[run]\nuntil = 6.0\nsample_interval = 0.05\nsnapshots = \"extxyz\"\n\
                  observe = [\"energy\", \"velocities:gas\"]\n";
    fs::write(root.path().join("second.toml"), second).unwrap();
    let words = [
        "run",
        "second.toml",
        "--from",
        "out",
        "--out",
        "next",
        "--checkpoint-every",
        "0.01",
    ];
    let begun = Instant::now();
    let output = carom(root.path(), &words);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let duration = begun.elapsed();
    let read = |name: &str| fs::read_to_string(root.path().join(name)).unwrap();
    // It starts where the other has ended, at time 0.
    let start: Vec<String> = read("next/trajectory.extxyz")
        .lines()
        .take(102)
        .map(str::to_owned)
        .collect();
    let end = last_frame(&root).replace("Time=1.0", "Time=0.0");
    assert_eq!(start.join("\n"), end);
    let manifest: Value = serde_json::from_str(&read("next/manifest.json")).unwrap();
    assert_eq!(manifest["parent"]["folder"], "out");
    assert_eq!(manifest["parent"]["is_end"], true);
    assert_eq!(manifest["parent"]["scene_crc32"].as_str().unwrap().len(), 8);
    assert!(read("next/report.html").contains("Starts from the end of the run in out"));
    let check = carom(
        root.path(),
        &["check", "second.toml", "--verbose", "--from", "out"],
    );
    assert!(
        text(&check.stdout).contains("  100     gas   disc"),
        "{}",
        text(&check.stdout)
    );

    // Another folder of the same run, killed and resumed, at last without the first run.
    let place = tempfile::tempdir().unwrap();
    fs::write(place.path().join("second.toml"), second).unwrap();
    fs::create_dir(place.path().join("out")).unwrap();
    fs::copy(
        root.path().join("out/checkpoint"),
        place.path().join("out/checkpoint"),
    )
    .unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_carom"))
        .current_dir(place.path())
        .args(words)
        .spawn()
        .unwrap();
    while !place.path().join("next/energy.csv").exists() {
        sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    fs::remove_dir_all(place.path().join("out")).unwrap();
    killed(
        place.path(),
        &["run", "second.toml", "--out", "next"],
        duration / 5,
    );
    assert_eq!(
        results(&place.path().join("next")),
        results(&root.path().join("next"))
    );

    for (change, said) in [
        ("gas.0.count=7", "`gas` differs"),
        ("box.sides=[2,1]", "`box.sides` differs"),
    ] {
        fs::write(root.path().join("other.toml"), format!("{gas}{second}")).unwrap();
        let refused = carom(
            root.path(),
            &["check", "other.toml", "--from", "out", "--set", change],
        );
        assert_eq!(refused.status.code(), Some(2));
        assert!(
            text(&refused.stderr).contains(said),
            "{}",
            text(&refused.stderr)
        );
    }
    let refused = carom(
        root.path(),
        &["run", "second.toml", "--from", "nowhere", "--out", "third"],
    );
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("cannot start from the run in nowhere"));
}
