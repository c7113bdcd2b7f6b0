//! A drag of all bodies: the paths and the order of contacts are those without drag, the energy
//! falls as exp(−2 γ t), the ledger closes, and runs are the same in pieces, in tiles and after a
//! resume.

use carom_engine::{
    CellsPerSide, CollisionReport, ElasticityRule, ElasticitySpec, HeapScheduler, Observer,
    Restitution, Scene, Scheduler, Simulation, Tiling, View,
};
use carom_kinematics::{DragClock, EpochTime};
use carom_observers::{Drift, FreePaths, Group};
use glam::DVec2;

use crate::support::{
    bits, bumper, disc, gas, reference_scene, scene, scenes, simulate, test_each_scheduler,
};
use carom_detection::Exact;
use carom_response::Impact;

const DRAG: f64 = 0.8;

/// The contacts of a run: time, bodies and impulse.
#[derive(Debug, Default)]
struct Contacts(Vec<(f64, [u64; 2], DVec2)>);

impl Observer for Contacts {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        let bodies = report.sides.each_ref().map(|side| side.body.id());
        self.0.push((report.time.to_f64(), bodies, report.impulse));
    }
}

/// The first contacts of a run up to `until`.
fn contacts<S: Scheduler>(scene: &Scene, options: &S::Options, until: f64) -> Contacts {
    let mut simulation = simulate::<S>(scene, options);
    let mut contacts = Contacts::default();
    simulation.observe_until(until, &mut contacts).unwrap();
    contacts
}

/// Without drag the same contacts come at the readings of the clock, with impulses that are larger
/// by the slowing. Chaos lets the roundings of both runs grow: the first contacts are compared.
fn check_order<S: Scheduler>(options: &S::Options) {
    let clock = DragClock::new(DRAG);
    let mut compared = 0;
    let mut rough = reference_scene(7);
    rough.elasticity = ElasticitySpec {
        default: 0.9,
        tangential: 0.4,
        friction: Some(0.3),
        ..ElasticitySpec::default()
    };
    for (name, free) in scenes().into_iter().chain([("rough", rough)]) {
        let mut dragged = free.clone();
        dragged.bounds.drag = DRAG;
        let until = 0.15;
        let expected = contacts::<S>(&free, options, clock.reading(until));
        let found = contacts::<S>(&dragged, options, until);
        let count = found.0.len().min(40);
        assert!(expected.0.len() >= count, "{name}: {count}");
        compared += count;
        for (found, expected) in found.0.iter().zip(&expected.0).take(count) {
            assert_eq!(found.1, expected.1, "{name}");
            let reading = clock.reading(found.0);
            assert!((reading - expected.0).abs() < 1e-7 * expected.0, "{name}");
            let impulse = expected.2 * clock.slowing(reading);
            assert!(
                (found.2 - impulse).length() < 1e-5 * (impulse.length() + 1e-3),
                "{name}: {} {impulse}",
                found.2
            );
        }
    }
    assert!(compared > 200, "{compared}");
}

/// The energy of an elastic gas at all times, over many epochs and to the end of all motion.
fn check_energy<S: Scheduler>(options: &S::Options) {
    let mut scene = reference_scene(3);
    scene.bounds.drag = DRAG;
    let mut simulation = simulate::<S>(&scene, options);
    let initial = simulation.view().energy();
    for time in [0.01, 0.3, 1.0, 4.0, 20.0] {
        simulation.run_until(time).unwrap();
        let view = simulation.view();
        assert_eq!(view.time().to_f64(), time);
        let expected = initial * (-2.0 * DRAG * time).exp();
        assert!(
            (view.energy() - expected).abs() < 1e-12 * expected * (1.0 + time),
            "{time}: {} {expected}",
            view.energy()
        );
        let booked = view.ledger().booked();
        assert!((booked - view.energy()).abs() < 1e-12 * initial, "{booked}");
    }
    assert!(simulation.view().counters().collisions > 100);
    // All bodies have stopped long before.
    simulation.run_until(1e4).unwrap();
    assert_eq!(simulation.view().energy(), 0.0);
    assert_eq!(simulation.view().overlaps().pairs, 0);
}

/// Runs that are stored and resumed at each end of an epoch have the bits of one that is not.
fn check_resume<S: Scheduler>(options: &S::Options) {
    let mut scene = reference_scene(5);
    scene.bounds.drag = DRAG;
    scene.elasticity.default = 0.9;
    let [mut straight, mut stored] = [(); 2].map(|()| simulate::<S>(&scene, options));
    let mut resumed = 0;
    for sample in 1..=16 {
        let time = 0.5 * f64::from(sample);
        straight.run_until(time).unwrap();
        while !stored
            .observe_epoch(EpochTime::from(time), &mut ())
            .unwrap()
        {
            let checkpoint = stored.checkpoint().expect("an epoch has ended");
            let (exact, impact) = (Exact::default(), Impact);
            stored = Simulation::resume_with(&checkpoint, exact, impact, options.clone()).unwrap();
            resumed += 1;
        }
        assert!(bits(&straight.view()) == bits(&stored.view()), "{time}");
        let [one, other] = [&straight, &stored].map(|run| run.view().ledger());
        assert_eq!(one, other);
    }
    assert!(resumed > 3, "{resumed}");
}

test_each_scheduler! {
    drag_changes_no_order_of_contacts: check_order;
    drag_takes_the_energy: check_energy;
    dragged_runs_resume_to_the_bit: check_resume;
}

#[test]
fn a_single_disc_comes_to_rest_after_the_path_v_over_gamma() {
    let mut scene = scene(vec![disc(0.1, 2.0, [0.25, 0.5], [0.6, -0.2])]);
    scene.bounds.drag = 2.0;
    let mut simulation = Simulation::new(&scene).unwrap();
    for time in [0.1, 0.5, 3.0, 100.0_f64] {
        simulation.run_until(time).unwrap();
        let view = simulation.view();
        let body = view.bodies().next().unwrap();
        let share = (1.0 - (-2.0 * time).exp()) / 2.0;
        let place = DVec2::new(0.25, 0.5) + DVec2::new(0.6, -0.2) * share;
        assert!((body.unwrapped(&view.bounds()) - place).length() < 1e-14);
        let velocity = DVec2::new(0.6, -0.2) * (-2.0 * time).exp();
        assert!((body.motion.velocity - velocity).length() < 1e-15);
    }
}

#[test]
fn tiles_have_the_bits_of_one_run_also_where_contacts_lose_energy() {
    for coefficient in [1.0, 0.9] {
        let mut scene = Scene {
            gas: vec![gas("disc", 0.004, 4000)],
            ..Scene::default()
        };
        scene.bounds.drag = DRAG;
        scene.elasticity = ElasticitySpec {
            default: coefficient,
            contact_time: if coefficient < 1.0 { 1e-4 } else { 0.0 },
            ..ElasticitySpec::default()
        };
        let run = |tiling: &Tiling| {
            let mut simulation = Simulation::new(&scene).unwrap();
            simulation.set_tiling(tiling);
            let mut contacts = Contacts::default();
            for sample in 1..=4 {
                let time = 0.05 * f64::from(sample);
                if sample == 2 {
                    simulation.observe_until(time, &mut contacts).unwrap();
                } else {
                    simulation.run_until(time).unwrap();
                }
            }
            let ledger = simulation.view().ledger();
            (bits(&simulation.view()), ledger, contacts.0)
        };
        let tiling = Tiling {
            threads: 2,
            least_bodies: 0,
            ..Tiling::default()
        };
        let [one, other] = [&Tiling::NONE, &tiling].map(run);
        assert!(one.0 == other.0 && one.1 == other.1 && one.2 == other.2);
        assert!(one.2.len() > 500);
    }
}

#[test]
fn the_ledger_closes_with_losses_thermal_walls_and_edits() {
    let mut scene = Scene::from_toml(
        "[box]\ndrag = 0.3\n[elasticity]\ndefault = 0.9\n[[wall]]\nx = 0.0\ntemperature = 2.0\n[[gas]]\n\
         tags = [\"gas\"]\nshape = \"dumbbell\"\natom_radius = 0.01\natom_mass = 0.5\nenergy = 1.0\ncount = 150",
    )
    .unwrap();
    scene.elasticity.pair = vec![ElasticityRule {
        between: vec!["gas".to_owned()],
        coefficient: 0.95.into(),
        ..ElasticityRule::default()
    }];
    let mut simulation = Simulation::new(&scene).unwrap();
    for sample in 1..=40 {
        simulation.run_until(0.1 * f64::from(sample)).unwrap();
        if sample == 7 {
            simulation.reset_energy_of_all(0.5).unwrap();
            let energy = simulation.view().energy();
            assert!((energy - 75.0).abs() < 1e-11, "{energy}");
        }
        if sample == 20 {
            simulation.set_drag(1.1).unwrap();
        }
        if sample == 21 {
            let key = simulation.view().bodies().last().unwrap().body.key();
            let before = simulation.view().body(key).unwrap().motion;
            simulation.set_velocity(key, [1.0, 0.0]).unwrap();
            let after = simulation.view().body(key).unwrap().motion;
            // The spin is the true one at this time.
            let change = after.angular_velocity - before.angular_velocity;
            assert!(change.abs() < 1e-14 * before.angular_velocity.abs());
        }
        let view = simulation.view();
        let ledger = view.ledger();
        let error = (ledger.booked() - view.energy()).abs();
        assert!(error < 1e-11 * ledger.initial, "{sample}: {error:e}");
    }
    let ledger = simulation.view().ledger();
    assert!(ledger.dragged > 1.0 && ledger.lost > 1.0 && ledger.heat > 1.0);
}

/// A restitution that depends on the speed, and a kick, act on the true velocities in the middle of
/// an epoch.
#[test]
fn rules_of_contact_see_true_speeds() {
    let law = Restitution::Power {
        power: -0.25,
        at: 0.01,
    };
    let mut scene = scene(vec![disc(0.05, 2.0, [0.3, 0.5], [0.4, 0.0])]);
    scene.bounds.drag = DRAG;
    scene.bumper = vec![bumper(0.05, [0.6, 0.5])];
    scene.bumper[0].tags = vec!["post".to_owned()];
    scene.elasticity.pair = vec![ElasticityRule {
        between: vec!["post".to_owned()],
        coefficient: law,
        kick: 0.1,
        ..ElasticityRule::default()
    }];
    // The disc has lost γ times its path of 0.2 in speed.
    let approach = 0.4 - DRAG * 0.2;
    let mut simulation = Simulation::new(&scene).unwrap();
    let mut contacts = Contacts::default();
    simulation.observe_until(0.8, &mut contacts).unwrap();
    let [(time, _, impulse)] = contacts.0[..] else {
        panic!("{:?}", contacts.0)
    };
    assert!((DragClock::new(DRAG).reading(time) - 0.5).abs() < 1e-14);
    let away = (approach / 0.01).powf(-0.25) * approach;
    assert!((impulse.x.abs() - 2.0 * (approach + away)).abs() < 1e-14);
    assert!((impulse.y.abs() - 0.1).abs() < 1e-14);
    let after = simulation.view().bodies().next().unwrap().motion.velocity;
    let slowing = (-DRAG * (0.8 - time)).exp();
    assert!((after.x + away * slowing).abs() < 1e-14);
    assert!((after.y.abs() - 0.05 * slowing).abs() < 1e-14);
}

/// ½ v_n² of discs that leave the wall; its mean is kT/m.
#[derive(Default)]
struct Leaving(Vec<f64>);
impl Observer for Leaving {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        for side in &report.sides {
            if !side.body.is_fixed() && report.sides.iter().any(|side| side.body.is_wall()) {
                self.0.push(0.5 * side.after.velocity.x.powi(2));
            }
        }
    }
}

/// kT at which the heat of thermal walls balances the drag is that of a gas whose walls see the
/// true temperature: bodies leave the wall with it at any time of an epoch.
#[test]
fn walls_that_have_a_temperature_keep_it_in_the_clock_of_drag() {
    let scene = Scene::from_toml(
        "[box]\nseed = 3\ndrag = 0.5\n[[wall]]\nx = 0.0\ntemperature = 1.5\n[[gas]]\nradius = 0.001\nmass = 1.0\n\
         energy = 1.0\ncount = 100",
    )
    .unwrap();
    let mut leaving = Leaving::default();
    Simulation::new(&scene)
        .unwrap()
        .observe_until(60.0, &mut leaving)
        .unwrap();
    let count = leaving.0.len() as f64;
    let mean = leaving.0.iter().sum::<f64>() / count;
    // ½ v_n²/kT is exponential with mean 1.
    assert!(
        count > 2000.0 && (mean / 1.5 - 1.0).abs() < 4.0 / count.sqrt(),
        "{count} {mean}"
    );
}

/// The clock of a drag runs in epochs of ln 2/γ only until all bodies are at rest.
#[test]
fn a_strong_drag_stops_a_gas_in_few_epochs_and_an_edit_moves_it_again() {
    let mut scene = reference_scene(7);
    scene.bounds.drag = 1e30;
    scene.elasticity.default = 0.9;
    let mut simulation = Simulation::new(&scene).unwrap();
    for time in [0.25, 1.0, 1e6] {
        simulation.run_until(time).unwrap();
        let view = simulation.view();
        assert_eq!((view.time().to_f64(), view.energy()), (time, 0.0));
        let ledger = view.ledger();
        assert!((ledger.dragged - ledger.initial).abs() < 1e-12 * ledger.initial);
    }
    assert!(simulation.view().counters().epochs < 300);
    let key = simulation.view().bodies().last().unwrap().body.key();
    simulation.set_drag(0.5).unwrap();
    simulation.set_velocity(key, [0.3, 0.0]).unwrap();
    let energy = simulation.view().energy();
    // Too short a time for a contact.
    simulation.run_until(1e6 + 1e-3).unwrap();
    let share = simulation.view().energy() / energy;
    assert!((share - (-1e-3_f64).exp()).abs() < 1e-9, "{share}");
}

#[test]
fn observers_follow_the_paths() {
    let clock = DragClock::new(DRAG);
    let of = |drag: f64, until: f64| {
        let mut scene = scene(vec![
            disc(0.05, 1.0, [0.2, 0.5], [1.0, 0.1]),
            disc(0.05, 1.0, [0.7, 0.52], [-0.6, 0.05]),
        ]);
        scene.bounds.drag = drag;
        let mut simulation = Simulation::new(&scene).unwrap();
        let key = simulation.view().bodies().next().unwrap().body.key();
        let mut watched = (FreePaths::adaptive(Group::All, 20), Drift::new(key));
        let start = |view: &View<'_>, watched: &mut (FreePaths, Drift)| watched.start(view);
        start(&simulation.view(), &mut watched);
        for step in 1..=4 {
            let time = until * f64::from(step) / 4.0;
            simulation.observe_until(time, &mut watched).unwrap();
            watched.sample(&simulation.view());
        }
        assert_eq!(watched.0.interrupted(), 0);
        (watched.0.sums(), watched.1.path())
    };
    let until = 1.2;
    let (dragged, path) = of(DRAG, until);
    let (free, free_path) = of(0.0, clock.reading(until));
    assert!(dragged[1] == free[1] && free[1] >= 2.0, "{}", free[1]);
    assert!((dragged[0] - free[0]).abs() < 1e-12);
    assert!((path - free_path).length() < 1e-12);
}

#[test]
fn a_drag_out_of_range_is_refused() {
    for drag in ["-0.1", "inf", "nan", "2e60"] {
        let text = format!(
            "[box]\ndrag = {drag}\n[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 10"
        );
        let refused = Scene::from_toml(&text).and_then(|scene| Simulation::new(&scene).map(drop));
        let words = refused.unwrap_err().to_string();
        assert!(
            words.contains("drag") && words.contains("from 0 to 1e60"),
            "{words}"
        );
    }
    let mut simulation = Simulation::new(&reference_scene(1)).unwrap();
    let before = bits(&simulation.view());
    assert!(simulation.set_drag(-1.0).is_err());
    assert!(bits(&simulation.view()) == before);
}

/// A drag of no effect in the run gives the order of the heap scheduler, too.
#[test]
fn a_tiny_drag_is_no_drag_to_rounding() {
    let mut scene = reference_scene(2);
    let options = CellsPerSide::Automatic;
    let free = contacts::<HeapScheduler>(&scene, &options, 0.2);
    scene.bounds.drag = 1e-12;
    let dragged = contacts::<HeapScheduler>(&scene, &options, 0.2);
    assert_eq!(free.0.len(), dragged.0.len());
    for (one, other) in free.0.iter().zip(&dragged.0).take(50) {
        assert!(one.1 == other.1 && (one.0 - other.0).abs() < 1e-9 * one.0);
    }
}
