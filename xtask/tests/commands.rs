//! The commands as a user runs them: shortest runs, existing folders, invalid input.

use std::{fs, path::Path};

use serde_json::Value;

use crate::support::xtask;

/// Exit code and terminal output.
fn outcome(arguments: &[&str]) -> (Option<i32>, String) {
    let output = xtask(arguments);
    let said = [output.stdout, output.stderr].concat();
    (
        output.status.code(),
        String::from_utf8_lossy(&said).into_owned(),
    )
}

fn json(folder: &Path, name: &str) -> Value {
    serde_json::from_str(&fs::read_to_string(folder.join(name)).unwrap()).unwrap()
}

/// All files in a folder and below that hold no wall times, by their paths.
fn data(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(&next).unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(folder).unwrap().display().to_string();
            if path.is_dir() {
                folders.push(path);
            } else if !["checkpoint", "manifest.json", "summary.json", "report.html"]
                .iter()
                .any(|clock| name.ends_with(clock))
            {
                files.push((name, fs::read(&path).unwrap()));
            }
        }
    }
    files.sort();
    files
}

fn without_speed(mut summary: Value) -> Value {
    let fields = summary.as_object_mut().unwrap();
    fields.remove("collisions_per_second").expect("the speed");
    // It names the path of the scene.
    fields.remove("title").expect("the title");
    summary
}

#[test]
fn an_animation_can_be_omitted_or_start_late_and_the_report_does_not_grow_with_the_system() {
    let root = tempfile::tempdir().unwrap();
    let scene = root.path().join("gas.toml");
    let run = |count: u32, name: &str, more: &[&str]| {
        let radius = 0.4 / f64::from(count).sqrt();
        let text = format!(
            "[[gas]]\nradius = {radius}\nmass = 1.0\nenergy = 1.0\ncount = {count}\n\
             [run]\nuntil = 2e-3\nsample_interval = 1e-3\nobserve = [\"energy\"]\n"
        );
        fs::write(&scene, text).unwrap();
        let out = root.path().join(name);
        let fixed = [
            "carom",
            "run",
            scene.to_str().unwrap(),
            "--out",
            out.to_str().unwrap(),
        ];
        let (code, said) = outcome(&[&fixed, more].concat());
        assert_eq!(code, Some(0), "{said}");
        let report = fs::read_to_string(out.join("report.html")).unwrap();
        (out, report)
    };
    let (with, report) = run(20_000, "with", &[]);
    assert!(
        report.len() < 2_000_000 && report.contains("class=\"animation\""),
        "{}",
        report.len()
    );
    let (without, plain) = run(20_000, "without", &["--set", "run.animation=false"]);
    assert!(!plain.contains("class=\"animation\"") && !plain.contains("flights.csv"));
    let (late, shown) = run(20_000, "late", &["--set", "run.animation_from=1.5e-3"]);
    assert!(shown.contains("class=\"animation\""));
    assert_eq!(json(&with, "animation.json")["from"], 0.0);
    assert_eq!(json(&late, "animation.json")["from"], 1.5e-3);
    let first = fs::read_to_string(late.join("flights.csv"))
        .unwrap()
        .lines()
        .nth(1)
        .unwrap()
        .to_owned();
    assert!(first.starts_with("0.0015,"), "{first}");
    // The run is the same in all three.
    let kept = |folder: &Path| -> Vec<_> {
        let is_choice =
            |name: &str| ["animation.json", "flights.csv", "config.toml"].contains(&name);
        data(folder)
            .into_iter()
            .filter(|(name, _)| !is_choice(name))
            .collect()
    };
    assert!(kept(&with) == kept(&without) && kept(&with) == kept(&late));
    let (_, small) = run(10_000, "small", &[]);
    let (_, large) = run(80_000, "large", &[]);
    // Ten thousand bodies are shown in full.
    assert!(
        large.len() < small.len(),
        "{} after {}",
        large.len(),
        small.len()
    );
}

#[test]
fn the_same_run_twice_gives_the_same_bytes() {
    let root = tempfile::tempdir().unwrap();
    let [first, second] = ["first", "second"].map(|name| root.path().join(name));
    for folder in [&first, &second] {
        fs::create_dir(folder).unwrap();
        let (code, said) = run(folder, SCENE, &["--seed", "5"]);
        assert_eq!(code, Some(0), "{said}");
    }
    let [first, second] = [first, second].map(|folder| folder.join("out"));
    let files = data(&first);
    assert!(files.iter().any(|(name, _)| name == "pressure.csv"));
    assert_eq!(files, data(&second));
    let summary = json(&first, "summary.json");
    assert_eq!(
        without_speed(summary.clone()),
        without_speed(json(&second, "summary.json"))
    );
    for name in [
        "collisions",
        "simulated_time",
        "collisions_per_second",
        "energy_drift",
        "overlapping_pairs",
        "max_overlap",
    ] {
        assert!(summary[name].is_number(), "{name}");
    }
    assert!(summary["collisions"].as_u64().unwrap() > 20);
    assert_eq!(json(&first, "manifest.json")["complete"], true);
    let page = fs::read_to_string(first.join("report.html")).unwrap();
    assert!(
        page.contains("<svg")
            && page.contains("prefers-color-scheme")
            && !page.contains("src=\"http")
    );
}

/// An experiment of several studies has a page and a summary of its own, and is continued.
#[test]
fn an_experiment_of_several_studies_answers_for_all_of_them() {
    let root = tempfile::tempdir().unwrap();
    let out = root.path().join("relaxation");
    let again = |more: &[&str]| {
        outcome(
            &[
                &[
                    "experiment",
                    "relaxation",
                    "--quick",
                    "--out",
                    out.to_str().unwrap(),
                ][..],
                more,
            ]
            .concat(),
        )
    };
    let (code, said) = again(&[]);
    assert_eq!(code, Some(0), "{said}");
    let summary = json(&out, "summary.json");
    let studies = summary["studies"].as_array().unwrap();
    let names: Vec<&str> = studies
        .iter()
        .filter_map(|study| study["study"].as_str())
        .collect();
    assert_eq!(names, ["mixing-quick", "relaxation-quick"]);
    for study in studies {
        let answers = study["points"][0]["answers"].as_array().unwrap();
        assert!(
            answers.len() > 4 && answers.iter().all(|answer| answer["passed"] == true),
            "{answers:?}"
        );
    }
    assert_eq!(json(&out, "manifest.json")["complete"], true);
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("All 2 studies passed.") && page.contains("mixing-quick/report.html"));
    let (code, said) = again(&[]);
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(json(&out, "summary.json"), summary, "nothing was run again");
}

#[test]
fn an_existing_folder_is_refused_unless_forced() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("out");
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join("precious.txt"), "mine").unwrap();
    let (code, said) = run(root.path(), SCENE, &[]);
    assert_eq!(code, Some(2));
    assert!(said.contains("--force"), "{said}");
    assert_eq!(
        fs::read_dir(&folder).unwrap().count(),
        1,
        "nothing is written"
    );
    let (code, said) = run(root.path(), SCENE, &["--force"]);
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(
        fs::read_to_string(folder.join("precious.txt")).unwrap(),
        "mine"
    );
}

const SCENE: &str = "[box]\nseed = 3\n\n[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 40\n\n\
                     [run]\nuntil = 0.5\nsample_interval = 0.1\nobserve = [\"energy\", \"collision-rate\", \"pressure\", \"overlap\", \"velocities\"]\n\
                     snapshots = \"extxyz\"\n";

/// Runs a scene given as text, with more arguments, into `folder/out`.
fn run(folder: &Path, scene: &str, more: &[&str]) -> (Option<i32>, String) {
    let (file, out) = (folder.join("scene.toml"), folder.join("out"));
    fs::write(&file, scene).unwrap();
    outcome(
        &[
            &[
                "carom",
                "run",
                file.to_str().unwrap(),
                "--out",
                out.to_str().unwrap(),
            ],
            more,
        ]
        .concat(),
    )
}

#[test]
fn a_scene_can_be_run_again_from_its_written_configuration() {
    let root = tempfile::tempdir().unwrap();
    let (code, said) = run(root.path(), SCENE, &[]);
    assert_eq!(code, Some(0), "{said}");
    let out = root.path().join("out");
    let frames = fs::read_to_string(out.join("trajectory.extxyz")).unwrap();
    assert_eq!(
        frames.matches("Lattice=").count(),
        6,
        "one at the start, five samples"
    );
    assert_eq!(
        fs::read_to_string(out.join("energy.csv"))
            .unwrap()
            .lines()
            .count(),
        1 + 6
    );
    assert_eq!(
        fs::read_to_string(out.join("collision-rate.csv"))
            .unwrap()
            .lines()
            .count(),
        1 + 5
    );

    assert_eq!(
        fs::read_to_string(out.join("pressure.csv"))
            .unwrap()
            .lines()
            .count(),
        1 + 5
    );
    assert_eq!(
        fs::read_to_string(out.join("velocities.csv"))
            .unwrap()
            .lines()
            .count(),
        1 + 6
    );

    let again = root.path().join("again");
    let config = out.join("config.toml");
    let (code, said) = outcome(&[
        "carom",
        "run",
        config.to_str().unwrap(),
        "--out",
        again.to_str().unwrap(),
    ]);
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(data(&out), data(&again));
}

#[test]
fn flags_and_set_override_the_file_and_are_written_back() {
    let root = tempfile::tempdir().unwrap();
    let more = [
        "--set",
        "gas.0.count=25",
        "--set",
        "box.sides=[2.0, 1.0]",
        "--seed",
        "9",
        "--until",
        "0.2",
    ];
    let (code, said) = run(root.path(), SCENE, &more);
    assert_eq!(code, Some(0), "{said}");
    let out = root.path().join("out");
    let config: toml::Table = fs::read_to_string(out.join("config.toml"))
        .unwrap()
        .parse()
        .unwrap();
    assert_eq!(config["gas"][0]["count"].as_integer(), Some(25));
    assert_eq!(config["box"]["sides"][0].as_float(), Some(2.0));
    assert_eq!(config["box"]["seed"].as_integer(), Some(9));
    assert_eq!(config["run"]["until"].as_float(), Some(0.2));
    let bodies = &json(&out, "summary.json")["figures"][0];
    assert_eq!(
        (&bodies["name"], &bodies["value"]),
        (&Value::from("bodies"), &Value::from(25.0))
    );
}

#[test]
fn invalid_input_is_refused_by_name() {
    for (scene, more, said) in [
        (
            SCENE.replace("mass = 1.0", "mass = -1.0"),
            &[][..],
            "gas[0]",
        ),
        (SCENE.replace("seed", "sead"), &[], "sead"),
        (SCENE.replace("\"overlap\"", "\"colour\""), &[], "colour"),
        (SCENE.replace("extxyz", "gsd"), &[], "gsd"),
        (SCENE.to_owned(), &["--set", "gas.1.count=3"], "gas"),
        (SCENE.to_owned(), &["--set", "gas.0.count=many"], "count"),
        (SCENE.to_owned(), &["--set", "gas.0.count=-1"], "count"),
        (SCENE.to_owned(), &["--until", "nan"], "run.until"),
        (SCENE.to_owned(), &["--nonsense"], "--nonsense"),
    ] {
        let root = tempfile::tempdir().unwrap();
        let (code, printed) = run(root.path(), &scene, more);
        assert_eq!(code, Some(2), "{said}: {printed}");
        assert!(printed.contains(said), "{said}: {printed}");
        assert!(
            !root.path().join("out").exists(),
            "{said}: nothing is written"
        );
    }
    for wrong in [
        &["experiment", "upside-down"][..],
        &["experiment", "brownian", "--quick", "--paper"],
        &["experiment", "brownian", "--threads", "0"],
        &["carom", "run", "no-such-scene.toml"],
        &["fly"],
    ] {
        assert_eq!(outcome(wrong).0, Some(2), "{wrong:?}");
    }
}

#[test]
fn a_run_that_fails_is_a_failed_check_and_stays_incomplete() {
    let root = tempfile::tempdir().unwrap();
    // Two discs collide head-on repeatedly; each contact doubles their speed, so their speed soon
    // overflows.
    let scene = "[[molecule]]\nshape = \"disc\"\natom_radius = 0.1\natom_mass = 1.0\nat = [0.25, 0.5]\nvelocity = [1, 0]\n\
                 [[molecule]]\nshape = \"disc\"\natom_radius = 0.1\natom_mass = 1.0\nat = [0.75, 0.5]\nvelocity = [-1, 0]\n\
                 [elasticity]\ndefault = 2.0\n[run]\nuntil = 10.0\n";
    let (code, said) = run(root.path(), scene, &[]);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("too fast"), "{said}");
    assert_eq!(
        json(&root.path().join("out"), "manifest.json")["complete"],
        false
    );
}

#[test]
fn detect_finds_first_contacts() {
    let root = tempfile::tempdir().unwrap();
    let (cases, answers) = (
        root.path().join("cases.csv"),
        root.path().join("answers.csv"),
    );
    // Two discs of radius 1/2 at distance 3, approaching at speed 1, touch at t = 2.
    fs::write(
        &cases,
        "class,id,xA,yA,vxA,vyA,thA,wA,atomsA,xB,yB,vxB,vyB,thB,wB,atomsB,window_end\n\
         discs,1,0,0,0,0,0,0,0:0:1:0.5,3,0,-1,0,0,0,0:0:1:0.5,10\n",
    )
    .unwrap();
    for detector in ["exact", "golden-secant", "bounding-circles"] {
        let (code, said) = outcome(&[
            "carom",
            "detect",
            cases.to_str().unwrap(),
            "--detector",
            detector,
            "--out",
            answers.to_str().unwrap(),
        ]);
        assert_eq!(code, Some(0), "{said}");
        let text = fs::read_to_string(&answers).unwrap();
        let cells: Vec<&str> = text.lines().nth(1).unwrap().split(',').collect();
        assert_eq!(cells[2], "contact", "{detector}: {text}");
        assert!(
            (cells[3].parse::<f64>().unwrap() - 2.0).abs() < 1e-12,
            "{detector}: {text}"
        );
    }
    assert_eq!(
        outcome(&[
            "carom",
            "detect",
            cases.to_str().unwrap(),
            "--detector",
            "guess",
            "--out",
            "x"
        ])
        .0,
        Some(2)
    );
}
