//! The comparison of settings with planted answers: a detector that misses contacts, an exact run
//! against itself, and scenes that cannot be reversed or hold one molecule.

use std::time::{Duration, Instant};

use carom::Scene;
use carom_experiments::trade::{
    advice,
    page::{self, unresolved},
    plan::TradePlan,
    results::{KnobResult, SceneResult},
    run::{Prepared, of_scene},
    states::{Along, chaos},
    table,
};
use carom_runs::{
    price::{Course, build},
    progress::Progress,
};

/// A plan that ends within seconds on any machine that runs tests.
const PLAN: TradePlan = TradePlan {
    rounds: 1,
    turn: 1e-3,
    timing_seconds: 1.0,
    states: 30,
    stretch: 2.0,
    state_seconds: 20.0,
    replay_seconds: 20.0,
    reversal_seconds: 0.05,
    physics_seconds: 20.0,
    physics: 20.0,
};

fn trade(text: &str) -> SceneResult {
    let scene = Scene::from_toml(text).unwrap();
    let later = Instant::now() + Duration::from_mins(10);
    let course = Course::new(&scene, build(&scene, later).unwrap().unwrap()).unwrap();
    let mut along = Along::settle(&scene, course, later).unwrap();
    let states = along.take(&scene, PLAN.states, PLAN.state_seconds).unwrap();
    let chaos = chaos(&scene, &states, Instant::now() + Duration::from_millis(200)).unwrap();
    let prepared = Prepared {
        name: "planted".to_owned(),
        scene: &scene,
        states,
        end: along.end,
        deadline: later,
        chaos,
        notes: along.notes,
    };
    of_scene(prepared, &PLAN, &Progress::new(1.0)).unwrap()
}

fn of<'a>(result: &'a SceneResult, name: &str) -> &'a KnobResult {
    let found = result
        .found
        .iter()
        .find(|found| found.knob.name.starts_with(name));
    found.unwrap_or_else(|| panic!("{name} is not among the settings"))
}

/// The lines that hold for every scene with contacts.
fn holds(result: &SceneResult) {
    let exact = result.exact();
    assert!(exact.tally.judged > 20, "{:?}", exact.tally);
    for found in result
        .found
        .iter()
        .filter(|found| found.knob.setting.is_exact())
    {
        let title = found.knob.title();
        assert_eq!(found.tally.wrong(), 0.0, "{title}: {:?}", found.tally);
        assert_eq!(
            found.tally.overlapping + found.physics.overlapping,
            0,
            "{title}"
        );
        assert!(found.time.is_some(), "{title}: {:?}", found.notes);
    }
    // The exact run against itself.
    assert_eq!(
        (
            exact.tally.largest,
            exact.tally.missed + exact.tally.off + exact.tally.invented
        ),
        (0.0, 0)
    );
    let own = exact.physics.differences(&exact.physics);
    assert!(
        !own.is_empty() && own.iter().all(|one| one.difference == 0.0),
        "{own:?}"
    );
    // The advice repeats cells of the table.
    let cells: Vec<String> = table::short(result).concat();
    for number in advice::advice(result)
        .split_whitespace()
        .filter(|word| word.contains('.') && word.len() > 4)
    {
        let number = number.trim_matches(|c: char| !c.is_ascii_digit());
        let is_number = number.parse::<f64>().is_ok();
        assert!(
            !is_number || cells.iter().any(|cell| cell.contains(number)),
            "{number} is in no cell"
        );
    }
    let summary = page::summary("planted".to_owned(), String::new(), result);
    assert!(
        summary.checks.iter().all(|check| check.passed),
        "{:?}",
        summary.checks
    );
}

#[test]
fn a_detector_that_looks_too_rarely_and_too_fine_a_grid_are_caught() {
    let result = trade(
        "[box]\nseed = 1\n[[gas]]\nradius = 0.05\nmass = 1.0\nenergy = 1.0\ncount = 50\n\
         [run]\nuntil = 20.0\n[method]\ndetector = \"fixed-step\"\nstep = 3.0\n",
    );
    holds(&result);
    let rare = of(&result, "the scene's [method]");
    assert!(rare.tally.missed > 20, "{:?}", rare.tally);
    assert!(
        rare.tally.overlapping > 0 && rare.tally.deepest > 1e-3,
        "{:?}",
        rare.tally
    );
    // Ten cells a side are the finest safe grid.
    assert_eq!(of(&result, "grid × 1 (10)").tally.wrong(), 0.0);
    let fine = of(&result, "grid × 2 (20)");
    assert!(
        fine.tally.missed > 10 && fine.tally.overlapping > 0,
        "{:?}",
        fine.tally
    );
    for name in [
        "HeapScheduler",
        "CellScheduler, portable",
        "epochs of 8",
        "sample each τ",
    ] {
        assert_eq!(of(&result, name).tally.wrong(), 0.0, "{name}");
    }
    let effective = result.exact().effective.unwrap();
    assert!(
        effective.value < 1e-13 && result.irreversible.is_none(),
        "{effective:?}"
    );
    // Discs have no rotation, no crop and no bounding circles other than themselves.
    let left_out: Vec<&str> = result
        .left_out
        .iter()
        .map(|(knob, _)| knob.as_str())
        .collect();
    assert!(
        left_out.contains(&"rotation locked") && left_out.contains(&"bounding circles"),
        "{left_out:?}"
    );
}

#[test]
fn an_inelastic_gas_with_a_thermostat_has_no_effective_error_and_says_why() {
    let result = trade(
        "[box]\nseed = 3\n[elasticity]\ndefault = 0.9\n[[gas]]\ntags = [\"gas\"]\nshape = \"dumbbell\"\n\
         atom_radius = 0.02\natom_mass = 0.5\nenergy = 1.0\ncount = 60\n\
         [run]\nsample_interval = 0.1\nobserve = [\"temperature\", \"thermostat\"]\n\
         [[stage]]\nuntil = 2.0\n\
         thermostat = [{ tag = \"gas\", every = 0.05, kind = \"maxwell\", temperature = 1.0 }]\n",
    );
    holds(&result);
    assert!(result.found.iter().all(|found| found.effective.is_none()));
    let said = unresolved(&result).join("\n");
    assert!(said.contains("elasticity 0.9"), "{said}");
    assert!(
        result
            .exact()
            .physics
            .figures
            .iter()
            .any(|figure| figure.name.contains("kT"))
    );
    let circles = of(&result, "bounding circles");
    assert!(circles.tally.wrong() > 1e5, "{:?}", circles.tally);
    assert!(of(&result, "rotation locked").tally.wrong() > 1e4);
}

#[test]
fn one_molecule_between_walls_is_compared() {
    let result = trade(
        "[box]\nseed = 5\n[[molecule]]\ntags = [\"tee\"]\nshape = \"tee\"\natom_radius = 0.05\natom_mass = 1.0\n\
         at = [0.5, 0.5]\nvelocity = [1.0, 0.3]\nangular_velocity = 2.0\n[[wall]]\nx = 0.0\n[[wall]]\ny = 0.0\n\
         [run]\nuntil = 50.0\n",
    );
    holds(&result);
    assert_eq!(result.moving, 1);
    assert!(of(&result, "bounding circles").tally.judged > 0);
}
