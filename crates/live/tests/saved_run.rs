//! A run that is edited while it continues, saved, and resumed by `carom run`, against `carom run`
//! throughout: the same state to the bit.

use std::{fs, path::Path, time::Duration};

use carom::{
    EpochTime, Scene,
    engine::{
        BodyKey, ElasticityRule, ElasticitySpec, HeatSpec, MeasureParameter, MeasureSpec,
        MoleculeSpec, RelabelSpec, StageSpec, ThermostatKind, ThermostatSpec, WallSpec,
    },
};
use carom_runs::{
    checkpoint_file,
    interruption::Signals,
    measures::{Results, SingleMeasure, Tracked},
    resumable::{CHECKPOINT, last_state},
    run::{
        self,
        interactive::{CallLimit, InteractiveRun, MEASURED, MeasuredBefore},
    },
};
use clap::Parser;

#[derive(Debug, Parser)]
struct Run {
    #[command(flatten)]
    options: run::RunOptions,
}

/// Runs a scene file and returns the bytes of the state at its end.
fn end_of(scene: &Path, out: &Path, more: &[&str]) -> Vec<u8> {
    let words = [
        "run",
        scene.to_str().unwrap(),
        "--out",
        out.to_str().unwrap(),
        "--no-price",
    ];
    let run = Run::parse_from(words.iter().chain(more));
    run::run(&run.options).unwrap();
    let last = last_state(&out.join(CHECKPOINT)).unwrap();
    assert!(last.is_end);
    checkpoint_file::encode(&last.state).unwrap()
}

const SCENE: &str = r#"
    [box]
    seed = 4
    [[molecule]]
    tags = ["tee"]
    shape = "tee"
    atom_radius = 0.02
    atom_mass = 1.0
    at = [0.5, 0.5]
    [[gas]]
    tags = ["hot"]
    radius = 0.012
    mass = 1.0
    temperature = 1.0
    velocities = "maxwell"
    count = 120
    [[gas]]
    tags = ["cold"]
    radius = 0.012
    mass = 2.0
    temperature = 1.0
    velocities = "maxwell"
    count = 80
    [run]
    sample_interval = 0.1
    observe = ["energy", "temperature:hot"]
    [[stage]]
    until = 0.5
    measure = false
    # Every third action of the first is at the instant of the second, up to rounding.
    thermostat = [
        { tag = "hot", every = 0.01, kind = "maxwell", temperature = 2.0 },
        { tag = "hot", every = 0.03, kind = "maxwell", temperature = 1.0 },
    ]
    [[stage]]
    until = 3.0
    thermostat = [{ tag = "hot", every = 0.02, kind = "maxwell", temperature = 3.0 }]
"#;

fn disc(at: [f64; 2]) -> MoleculeSpec {
    MoleculeSpec {
        tags: vec!["new".to_owned()],
        shape: Some("disc".to_owned()),
        atom_radius: Some(0.01),
        atom_mass: Some(1.0),
        at,
        velocity: [1.0, -0.5],
        ..MoleculeSpec::default()
    }
}

/// A place where a small disc fits.
fn free_place(run: &InteractiveRun) -> [f64; 2] {
    let places = (0..400).map(|k| {
        [
            f64::from(k % 20) * 0.05 + 0.011,
            f64::from(k / 20) * 0.05 + 0.013,
        ]
    });
    let is_free = |place: &[f64; 2]| {
        run.view().bodies().all(|body| {
            let away = body.motion.position - glam::DVec2::from(*place);
            let nearest = away - away.round();
            nearest.length() > 0.011 + body.body.molecule().bounding_radius()
        })
    };
    places.into_iter().find(is_free).expect("the gas is dilute")
}

#[test]
#[expect(clippy::too_many_lines, reason = "one course with many looks")]
fn an_edited_run_is_replayed_and_resumed_to_the_bit() {
    let scene = Scene::from_toml(SCENE).unwrap();
    let mut run = InteractiveRun::new(&scene).unwrap();
    let advance = |run: &mut InteractiveRun, to: f64| {
        // In pieces, as the laboratory does.
        let from = run.view().time().to_f64();
        for piece in 1..=7 {
            let until = from + (to - from) * f64::from(piece) / 7.0;
            run.advance(EpochTime::from(until), &mut ()).unwrap();
        }
    };
    let quiet = StageSpec::default;
    advance(&mut run, 0.313);
    let elasticity = ElasticitySpec {
        default: 0.9,
        pair: vec![ElasticityRule {
            between: vec!["tee".to_owned()],
            ..ElasticityRule::default()
        }],
        ..ElasticitySpec::default()
    };
    let edit = StageSpec {
        elasticity: Some(elasticity),
        ..quiet()
    };
    run.edit(&edit, None, &mut ()).unwrap();
    // At the same instant, and again after single contacts, which happen at no number of a file.
    let edit = StageSpec {
        lock: vec!["tee".to_owned()],
        ..quiet()
    };
    run.edit(&edit, None, &mut ()).unwrap();
    for _ in 0..5 {
        assert!(run.step(1.0, &mut ()).unwrap());
    }
    let edit = StageSpec {
        unlock: vec!["tee".to_owned()],
        ..quiet()
    };
    let start = run.edit(&edit, None, &mut ()).unwrap();
    assert!(start > 0.313);
    // A refused edit changes nothing, not even the number of the next body.
    let before = run.view().len();
    let on_the_tee = run
        .view()
        .body(BodyKey::of_id(0))
        .unwrap()
        .motion
        .position
        .to_array();
    let refused = run.edit(
        &StageSpec {
            add: vec![disc(on_the_tee)],
            ..quiet()
        },
        None,
        &mut (),
    );
    let words = format!("{:#}", refused.unwrap_err());
    assert!(
        words.contains("add[0]") && words.contains("overlap"),
        "{words}"
    );
    let unknown = run.edit(
        &StageSpec {
            remove: vec!["hto".to_owned()],
            ..quiet()
        },
        None,
        &mut (),
    );
    assert!(
        format!("{:#}", unknown.unwrap_err()).contains("hot"),
        "the next tag is suggested"
    );
    // Past the second stage of the scene, onto an instant at which its thermostat acts.
    run.advance(EpochTime::from(0.7), &mut ()).unwrap();
    let place = free_place(&run);
    run.edit(
        &StageSpec {
            add: vec![disc(place)],
            ..quiet()
        },
        None,
        &mut (),
    )
    .unwrap();
    let added = run.view().bodies().last().unwrap().body.id();
    assert_eq!((added, run.view().len()), (201, before + 1));
    let relabel = RelabelSpec {
        body: Some(added),
        name: "chosen".to_owned(),
        ..RelabelSpec::default()
    };
    run.edit(
        &StageSpec {
            tag: vec![relabel],
            ..quiet()
        },
        None,
        &mut (),
    )
    .unwrap();
    advance(&mut run, 1.1);
    let hold = ThermostatSpec {
        tag: "cold".to_owned(),
        every: 0.03,
        kind: ThermostatKind::EnergyReset,
        energy: Some(0.7),
        ..ThermostatSpec::default()
    };
    let heat = HeatSpec {
        tag: "hot".to_owned(),
        kind: ThermostatKind::Maxwell,
        energy: None,
        temperature: Some(0.5),
    };
    run.edit(
        &StageSpec {
            set_energy: vec![heat],
            ..quiet()
        },
        Some(&[hold]),
        &mut (),
    )
    .unwrap();
    advance(&mut run, 1.4);
    run.edit(
        &StageSpec {
            remove: vec!["chosen".to_owned()],
            ..quiet()
        },
        None,
        &mut (),
    )
    .unwrap();
    // A wall where there is room for one.
    let place = free_place(&run);
    let wall = WallSpec {
        from: Some(place),
        to: Some([place[0] + 0.001, place[1]]),
        ..WallSpec::default()
    };
    run.edit(
        &StageSpec {
            add_wall: vec![wall],
            ..quiet()
        },
        None,
        &mut (),
    )
    .unwrap();
    // Without a thermostat, the start of a stage is one rounding step after that of the last.
    run.edit(&quiet(), Some(&[]), &mut ()).unwrap();
    run.edit(&quiet(), None, &mut ()).unwrap();
    run.edit(&quiet(), None, &mut ()).unwrap();
    advance(&mut run, 1.777);

    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("saved");
    let saved = run.save(&folder).unwrap();
    assert!(saved.time >= 1.777 && saved.command.contains("--resume"));
    let config = folder.join("config.toml");
    let copy = root.path().join("copy.toml");
    fs::copy(&config, &copy).unwrap();
    let resumed = end_of(&config, &folder, &["--resume"]);
    let throughout = end_of(&copy, &root.path().join("throughout"), &[]);
    assert!(
        resumed == throughout,
        "a resumed run and the run of its scene have the same bits"
    );
    // The run itself continues with the same bits.
    run.advance(EpochTime::from(3.0), &mut ()).unwrap();
    let last = last_state(&folder.join(CHECKPOINT)).unwrap().state;
    let method = carom_methods::Method::default();
    let there = carom_methods::AnySimulation::resume(&last, &method).unwrap();
    let bits = |view: carom::View<'_>| -> Vec<u64> {
        let of = |body: carom::engine::BodyView<'_>| {
            let motion = body.motion;
            let [x, v] = [motion.position, motion.velocity];
            [x.x, x.y, v.x, v.y, motion.angular_velocity].map(f64::to_bits)
        };
        view.bodies().flat_map(of).collect()
    };
    assert_eq!(run.view().time(), there.view().time());
    assert!(
        bits(run.view()) == bits(there.view()),
        "the run that was saved has continued in the same way"
    );
}

#[test]
fn a_run_without_edits_is_saved_as_the_run_of_its_scene() {
    let scene = Scene::from_toml(
        "[[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100\n\
         [run]\nuntil = 2.0\nsample_interval = 0.5\nobserve = [\"energy\"]\nanimation = true\n",
    )
    .unwrap();
    let mut run = InteractiveRun::new(&scene).unwrap();
    run.advance(EpochTime::from(0.6), &mut ()).unwrap();
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("saved");
    run.save(&folder).unwrap();
    assert!(run.save(&folder).is_err(), "nothing is overwritten");
    let text = fs::read_to_string(folder.join("config.toml")).unwrap();
    let stored = Scene::from_toml(&text).unwrap();
    assert!(stored.stage.is_empty() && stored.run.until == 2.0);
    let original = root.path().join("original.toml");
    fs::write(&original, scene.to_toml()).unwrap();
    let resumed = end_of(&folder.join("config.toml"), &folder, &["--resume"]);
    assert!(resumed == end_of(&original, &root.path().join("original"), &[]));
    // Longer than the scene foresaw.
    run.advance(EpochTime::from(5.0), &mut ()).unwrap();
    run.save(&root.path().join("later")).unwrap();
    let text = fs::read_to_string(root.path().join("later/config.toml")).unwrap();
    assert_eq!(Scene::from_toml(&text).unwrap().run.until.floor(), 7.0);
}

#[test]
fn a_run_ends_at_a_time_at_which_it_can_be_saved() {
    // As a gas that has lost its energy.
    let scene = Scene::from_toml(
        "[[molecule]]\ntags = [\"gas\"]\nshape = \"disc\"\natom_radius = 0.1\natom_mass = 1.0\nat = [0.5, 0.5]\n\
         [run]\nuntil = 1.0\nsample_interval = 0.1\nobserve = [\"energy\"]\n\
         [[measure]]\nkind = \"correlation\"\nof = \"gas\"\nmax = 0.4\n",
    )
    .unwrap();
    let mut run = InteractiveRun::new(&scene).unwrap();
    run.advance(EpochTime::from(1e30), &mut ()).unwrap();
    let refused = run
        .advance(EpochTime::from(2e30), &mut ())
        .unwrap_err()
        .to_string();
    assert!(refused.contains("latest time, 1e30"), "{refused}");
    let root = tempfile::tempdir().unwrap();
    let saved = run.save(&root.path().join("saved")).unwrap();
    assert!(saved.time >= 1e30, "{}", saved.time);
}

#[test]
fn measures_of_bodies_that_are_gone_are_left_out_of_a_saved_run() {
    let scene = Scene::from_toml(SCENE).unwrap();
    let mut run = InteractiveRun::new(&scene).unwrap();
    run.advance(EpochTime::from(0.7), &mut ()).unwrap();
    let removal = StageSpec {
        remove: vec!["hot".to_owned()],
        ..StageSpec::default()
    };
    run.edit(&removal, Some(&[]), &mut ()).unwrap();
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("saved");
    let saved = run.save(&folder).unwrap();
    assert!(
        saved.left_out.len() == 1 && saved.left_out[0].contains("hot"),
        "{:?}",
        saved.left_out
    );
    let stored =
        Scene::from_toml(&fs::read_to_string(folder.join("config.toml")).unwrap()).unwrap();
    assert_eq!(stored.run.observe, ["energy"]);
    end_of(&folder.join("config.toml"), &folder, &["--resume"]);
}

#[test]
fn a_thermostat_that_acts_for_ever_goes_on_in_a_stage_of_its_own() {
    let scene = Scene::from_toml(
        "[[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 2\n\
         [[stage]]\nuntil = 1.0\n\
         thermostat = [{ tag = \"gas\", every = 1e-6, energy = 1.0 }]\n",
    )
    .unwrap();
    let mut run = InteractiveRun::new(&scene).unwrap();
    run.advance(EpochTime::from(2.0), &mut ()).unwrap();
    assert!(!run.renew(&mut ()).unwrap() && run.stage() == 0);
    run.advance(EpochTime::from(2.6), &mut ()).unwrap();
    assert!(run.renew(&mut ()).unwrap() && run.stage() == 1);
    let root = tempfile::tempdir().unwrap();
    run.save(&root.path().join("saved")).unwrap();
}

#[test]
fn an_edit_at_the_end_of_the_measured_stages_is_made_and_saved() {
    let scene = Scene::from_toml(
        "[[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 20\n\
         [run]\nsample_interval = 0.1\nobserve = [\"energy\"]\nstop = { collisions = 5 }\n\
         [[stage]]\nuntil = 1.0\n[[stage]]\nuntil = 2.0\nmeasure = false\n",
    )
    .unwrap();
    let mut run = InteractiveRun::new(&scene).unwrap();
    // Less than a sample interval is left of the measured stage.
    run.advance(EpochTime::from(0.95), &mut ()).unwrap();
    let heat = HeatSpec {
        tag: "gas".to_owned(),
        kind: ThermostatKind::Maxwell,
        energy: None,
        temperature: Some(2.0),
    };
    run.edit(
        &StageSpec {
            set_energy: vec![heat],
            ..StageSpec::default()
        },
        None,
        &mut (),
    )
    .unwrap();
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("saved");
    let saved = run.save(&folder).unwrap();
    let words = saved.left_out.join("\n");
    assert!(
        words.contains("run.stop") && words.contains("all measures"),
        "{words}"
    );
    // Neither ends after five contacts, as the scene says of a run that no one edits.
    let copy = root.path().join("copy.toml");
    fs::copy(folder.join("config.toml"), &copy).unwrap();
    let resumed = end_of(&folder.join("config.toml"), &folder, &["--resume"]);
    assert!(resumed == end_of(&copy, &root.path().join("throughout"), &[]));
}

/// Two discs on parallel paths that never meet, and the end of the run.
fn parallel_discs(until: f64) -> Scene {
    let disc = |y: f64| {
        format!(
            "[[molecule]]\ntags = [\"gas\"]\nshape = \"disc\"\natom_radius = 0.1\natom_mass = 1.0\nat = [0.5, {y}]\n\
             velocity = [1.0, 0.0]\n"
        )
    };
    let run = format!(
        "[run]\nuntil = {until:e}\nsample_interval = {:e}\n",
        0.1 * until
    );
    Scene::from_toml(&format!("{}{}{run}", disc(0.25), disc(0.75))).unwrap()
}

#[test]
fn a_call_far_from_its_end_returns_within_its_limit_and_goes_on_later() {
    let limit = |longest| CallLimit {
        signals: Signals::default(),
        longest,
    };
    let short = limit(Duration::from_millis(20));
    let mut run = InteractiveRun::new_within(&parallel_discs(1e12), short).unwrap();
    assert!(!run.advance(EpochTime::from(1e12), &mut ()).unwrap());
    assert!(!run.step(1e12, &mut ()).unwrap());
    let time = run.view().time().to_f64();
    assert!(time > 0.0 && time < 1e12, "{time}");
    // A run in such calls has the bits of a run in one.
    let gas =
        Scene::from_toml("[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 400").unwrap();
    let mut cut = InteractiveRun::new_within(&gas, limit(Duration::ZERO)).unwrap();
    let mut whole = InteractiveRun::new(&gas).unwrap();
    let until = EpochTime::from(0.7);
    let mut calls = 1;
    while !cut.advance(until, &mut ()).unwrap() {
        calls += 1;
    }
    assert!(
        whole.advance(until, &mut ()).unwrap() && calls > 5,
        "{calls}"
    );
    assert_eq!(
        whole.view().counters().collisions,
        cut.view().counters().collisions
    );
    let places = |run: &InteractiveRun| -> Vec<u64> {
        run.view()
            .bodies()
            .map(|body| body.motion.position.x.to_bits())
            .collect()
    };
    assert!(places(&whole) == places(&cut));
}

#[test]
fn a_signal_ends_a_call_and_the_run_is_saved_where_it_is() {
    let signals = Signals::default();
    let limit = CallLimit {
        signals: signals.clone(),
        longest: Duration::MAX,
    };
    let mut run = InteractiveRun::new_within(&parallel_discs(1e12), limit).unwrap();
    signals.interrupt();
    assert!(!run.advance(EpochTime::from(1e12), &mut ()).unwrap());
    assert!(!run.step(1e12, &mut ()).unwrap());
    let root = tempfile::tempdir().unwrap();
    let saved = run.save(&root.path().join("saved")).unwrap();
    assert!(saved.time < 1e12);
    assert_eq!(
        fs::read_dir(root.path()).unwrap().count(),
        1,
        "no partial folder is left"
    );
}

#[test]
fn an_edit_after_an_action_of_a_rare_thermostat_is_made_at_once_and_replayed_to_the_bit() {
    let scene = Scene::from_toml(
        "[box]\nseed = 6\n[[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 60\n\
         [run]\nuntil = 3.0\nsample_interval = 0.5\nobserve = [\"energy\"]\n",
    )
    .unwrap();
    let rare = ThermostatSpec {
        tag: "gas".to_owned(),
        every: 1e12,
        kind: ThermostatKind::Maxwell,
        temperature: Some(2.0),
        ..ThermostatSpec::default()
    };
    let mut run = InteractiveRun::new(&scene).unwrap();
    run.advance(EpochTime::from(0.4), &mut ()).unwrap();
    run.edit(&StageSpec::default(), Some(&[rare]), &mut ())
        .unwrap();
    // It has acted at 0.4, and next acts at 10¹².
    let energy = run.view().energy();
    let elasticity = ElasticitySpec {
        default: 0.9,
        ..ElasticitySpec::default()
    };
    for _ in 0..3 {
        let edit = StageSpec {
            elasticity: Some(elasticity.clone()),
            ..StageSpec::default()
        };
        let start = run.edit(&edit, None, &mut ()).unwrap();
        assert!(start > 0.4 && start < 0.4 + 1e-12, "{start}");
    }
    assert!(
        run.view().energy() != energy,
        "it acts at the start of each stage"
    );
    run.advance(EpochTime::from(1.1), &mut ()).unwrap();
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("saved");
    run.save(&folder).unwrap();
    let copy = root.path().join("copy.toml");
    fs::copy(folder.join("config.toml"), &copy).unwrap();
    let resumed = end_of(&folder.join("config.toml"), &folder, &["--resume"]);
    assert!(resumed == end_of(&copy, &root.path().join("throughout"), &[]));
}

#[test]
fn the_command_of_a_saved_run_is_quoted_for_a_shell() {
    let root = tempfile::tempdir().unwrap();
    let run = InteractiveRun::new(&parallel_discs(1.0)).unwrap();
    let folder = root.path().join("it's $(here)");
    let saved = run.save(&folder).unwrap();
    assert!(
        saved
            .command
            .contains("it'\\''s $(here)/config.toml' --out '"),
        "{}",
        saved.command
    );
}

/// Measures that are begun while the run continues are measures of the saved run; those of the
/// scene stay single.
#[test]
fn measures_begun_meanwhile_are_measured_by_the_saved_run() {
    let scene = Scene::from_toml(SCENE).unwrap();
    let mut run = InteractiveRun::new(&scene).unwrap();
    run.advance(EpochTime::from(0.7), &mut ()).unwrap();
    let measure = |kind: &str, of: Option<&str>, interval: f64| {
        let of = of.map(str::to_owned);
        (
            MeasureSpec {
                kind: kind.to_owned(),
                of,
                ..MeasureSpec::default()
            },
            interval,
        )
    };
    run.set_watched(vec![
        measure("velocities", Some("hot"), 0.21),
        measure("temperature", Some("hot"), 0.1),
    ]);
    let root = tempfile::tempdir().unwrap();
    let path = root.path().join("1");
    let measured = MeasuredBefore {
        files: vec![("found.csv".to_owned(), b"x\n1\n".to_vec())],
        ..MeasuredBefore::default()
    };
    let saved = run.save_with(&path, &measured).unwrap();
    assert_eq!(saved.left_out, Vec::<String>::new());
    assert_eq!(saved.measures_from, Some(saved.time));
    let scene_file = path.join("config.toml");
    let stored = Scene::from_toml(&fs::read_to_string(&scene_file).unwrap()).unwrap();
    // All keep their intervals: the samples of the run are ten times as many.
    assert!((stored.run.sample_interval - 0.01).abs() < 1e-15);
    assert_eq!(stored.run.check_interval, Some(0.1));
    let kept: Vec<(&str, Option<&str>, &MeasureParameter)> = stored
        .measure
        .iter()
        .map(|spec| {
            (
                spec.kind.as_str(),
                spec.of.as_deref(),
                &spec.parameters["every"],
            )
        })
        .collect();
    let [ten, others] = [10.0, 21.0].map(MeasureParameter::Number);
    assert_eq!(
        kept,
        [
            ("energy", None, &ten),
            ("temperature", Some("hot"), &ten),
            ("velocities", Some("hot"), &others),
        ]
    );
    assert!(stored.run.observe.is_empty());
    // The run that continues leaves alone what was measured before.
    end_of(&scene_file, &path, &["--resume"]);
    let before = path.join(MEASURED).join("found.csv");
    assert_eq!(fs::read(before).unwrap(), measured.files[0].1);
    let rows = fs::read_to_string(path.join("temperature-hot.csv")).unwrap();
    let times: Vec<f64> = rows
        .lines()
        .skip(1)
        .map(|row| row.split(',').next().unwrap().parse().unwrap())
        .collect();
    assert!(times[0] >= saved.time && (times[1] - times[0] - 0.1).abs() < 1e-9);
}

/// The results of a measure that a program has taken with a sample every `interval` (time) from
/// now to `until`.
fn measured(run: &mut InteractiveRun, spec: &MeasureSpec, interval: f64, until: f64) -> Results {
    let measure = SingleMeasure::new(spec, interval, run.scene(), &run.view()).unwrap();
    let mut tracked = Tracked::new(measure, &run.view());
    while tracked.time() <= EpochTime::from(until) {
        let time = tracked.time();
        assert!(run.advance(time, &mut tracked.measure).unwrap());
        tracked.sample(&run.view());
    }
    carom_runs::merge::merged(&tracked.measure.record(run.scene(), &run.view(), None))
}

/// A column of a CSV file in a folder.
fn column(folder: &Path, file: &str, name: &str) -> Vec<f64> {
    let text = fs::read_to_string(folder.join(file)).unwrap();
    let mut lines = text.lines();
    let mut names = lines.next().unwrap().split(',');
    let place = names.position(|found| found == name).unwrap();
    let cell = |line: &str| line.split(',').nth(place).unwrap().parse().unwrap();
    lines.map(cell).collect()
}

/// The series of a program have rows before and after the save in one file, whether the run writes
/// it at its end or appends to it. Curves over the lag are those of the resumed run alone.
#[test]
fn series_continue_in_the_resumed_run() {
    let text = SCENE.replace(
        "observe = [\"energy\", \"temperature:hot\"]",
        "observe = []",
    );
    let mut run = InteractiveRun::new(&Scene::from_toml(&text).unwrap()).unwrap();
    run.advance(EpochTime::from(0.63), &mut ()).unwrap();
    let spec = |kind: &str, of: Option<&str>| MeasureSpec {
        kind: kind.to_owned(),
        of: of.map(str::to_owned),
        ..MeasureSpec::default()
    };
    let specs = [
        spec("temperature", Some("hot")),
        spec("pressure", None),
        spec("energy", None),
        spec("correlation", Some("hot")),
    ];
    let mut results = Vec::new();
    let interval = 0.05;
    for (spec, until) in specs.iter().zip([0.9, 1.2, 1.4, 1.5]) {
        results.push(measured(&mut run, spec, interval, until));
    }
    let rows = |results: &Results| results.tables[0].rows().len();
    let [of_temperature, of_pressure, of_energy] = [0, 1, 2].map(|place| rows(&results[place]));
    assert!(of_temperature > 4 && of_pressure > 4 && of_energy > 3);
    run.set_watched(specs.map(|spec| (spec, interval)).to_vec());
    let root = tempfile::tempdir().unwrap();
    let path = root.path().join("1");
    let before = MeasuredBefore {
        results,
        files: Vec::new(),
    };
    let saved = run.save_with(&path, &before).unwrap();
    let copy = root.path().join("copy.toml");
    fs::copy(path.join("config.toml"), &copy).unwrap();
    end_of(&path.join("config.toml"), &path, &["--resume"]);
    for (file, earlier) in [
        ("temperature-hot.csv", of_temperature),
        ("pressure.csv", of_pressure),
        ("energy.csv", of_energy),
    ] {
        let times = column(&path, file, "time");
        let found = times.iter().filter(|time| **time <= saved.time).count();
        assert_eq!(found, earlier, "{file}: {times:?}");
        assert!(times.len() > earlier + 20 && times.is_sorted(), "{file}");
        assert!(times[0] > 0.6 && times[0] < 1.3, "{file}: {times:?}");
    }
    assert!(column(&path, "correlation-hot.csv", "lag").is_sorted());
    let page = fs::read_to_string(path.join("report.html")).unwrap();
    assert!(page.contains("were measured before the run was saved"));
    // After the save the values are those of a run throughout.
    let throughout = root.path().join("throughout");
    end_of(&copy, &throughout, &[]);
    let last = |folder: &Path| {
        let values = column(folder, "temperature-hot.csv", "translation");
        values[values.len() - 20..].to_vec()
    };
    assert_eq!(last(&path), last(&throughout));
    // A run from the beginning in this folder does not take rows that were measured before.
    end_of(&copy, &path, &["--force"]);
    let times = |folder: &Path| column(folder, "temperature-hot.csv", "time");
    assert_eq!(times(&path), times(&throughout));
}

/// A measure of the scene that is also begun with another sample interval gets a name of its own.
#[test]
fn a_measure_of_the_scene_with_another_interval_is_saved_beside_it() {
    let scene = Scene::from_toml(SCENE).unwrap();
    let mut run = InteractiveRun::new(&scene).unwrap();
    run.advance(EpochTime::from(0.7), &mut ()).unwrap();
    let spec = MeasureSpec {
        kind: "temperature".to_owned(),
        of: Some("hot".to_owned()),
        ..MeasureSpec::default()
    };
    run.set_watched(vec![(spec.clone(), 0.02), (spec.clone(), 0.1), (spec, 0.2)]);
    let root = tempfile::tempdir().unwrap();
    let path = root.path().join("1");
    assert_eq!(run.save(&path).unwrap().left_out, Vec::<String>::new());
    let saved = Scene::from_toml(&fs::read_to_string(path.join("config.toml")).unwrap()).unwrap();
    let named: Vec<(Option<&str>, &MeasureParameter)> = saved
        .measure
        .iter()
        .filter(|spec| spec.kind == "temperature")
        .map(|spec| (spec.name.as_deref(), &spec.parameters["every"]))
        .collect();
    let [one, five, ten] = [1.0, 5.0, 10.0].map(MeasureParameter::Number);
    assert_eq!(
        named,
        [
            (None, &five),
            (Some("hot-live-1"), &one),
            (Some("hot-live-2"), &ten)
        ]
    );
    // An interval that is no multiple of a thousandth of that of the scene is rounded, in words.
    let fine = MeasureSpec {
        kind: "pressure".to_owned(),
        ..MeasureSpec::default()
    };
    run.set_watched(vec![(fine, 0.07 + 1e-6)]);
    let left_out = run.save(&root.path().join("2")).unwrap().left_out;
    assert!(
        left_out.len() == 1 && left_out[0].contains("pressure: its sample interval"),
        "{left_out:?}"
    );
}

/// The speed of a resumed run is that of both parts together.
#[test]
fn a_resumed_run_counts_the_processor_time_before_it_was_saved() {
    let text = "[box]\nseed = 2\n[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 400\n\
                [run]\nuntil = 8.0\nsample_interval = 1.0\nanimation = false\n";
    let mut run = InteractiveRun::new(&Scene::from_toml(text).unwrap()).unwrap();
    run.advance(EpochTime::from(7.8), &mut ()).unwrap();
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("saved");
    run.save(&folder).unwrap();
    let copy = root.path().join("copy.toml");
    fs::copy(folder.join("config.toml"), &copy).unwrap();
    end_of(&folder.join("config.toml"), &folder, &["--resume"]);
    let throughout = root.path().join("throughout");
    end_of(&copy, &throughout, &[]);
    let speed = |folder: &Path| {
        let text = fs::read_to_string(folder.join("summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
        summary["collisions_per_second"].as_f64().unwrap()
    };
    let ratio = speed(&folder) / speed(&throughout);
    assert!((0.2..5.0).contains(&ratio), "{ratio}");
}
