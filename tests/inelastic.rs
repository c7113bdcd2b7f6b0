//! Contacts that lose energy: the guard against inelastic collapse lets all runs continue, and does
//! not affect a cooling gas.

use std::f64::consts::PI;

use crate::support::{
    bits, bumper, disc, frozen, gas, reference_scene, scene, simulate, test_each_scheduler,
    velocity,
};
use carom_engine::{CollisionReport, MoleculeSpec, Observer, RunError, Scene, Scheduler, WallSpec};

/// Sums the energy lost in contacts, and records their elasticities.
#[derive(Default)]
struct Losses {
    total: f64,
    elasticities: Vec<f64>,
}

impl Observer for Losses {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        let change: f64 = report
            .sides
            .iter()
            .map(carom_engine::Side::energy_change)
            .sum();
        let before: f64 = report
            .sides
            .iter()
            .map(|side| carom_kinematics::kinetic_energy(&side.before, side.body.inertia()))
            .sum();
        assert!(change <= 1e-14 * before, "a contact gave {change}");
        self.total -= change;
        self.elasticities.push(report.elasticity.coefficient());
    }
}

test_each_scheduler! {
    a_disc_in_a_gap_below_the_contact_time_keeps_its_speed: check_rattle;
    the_guard_ignores_hits_on_a_body_that_is_hit_continually: check_crowd;
    a_column_that_falls_on_a_bumper_collapses_only_without_the_guard: check_column;
    a_guarded_gas_cools_by_the_law_of_haff: check_cooling;
    molecules_that_turn_never_sink_into_each_other: check_molecules;
    no_contact_times_are_kept_where_no_contact_loses_energy: check_elastic;
    a_guarded_run_does_not_depend_on_samples_or_the_unit_of_time: check_bits;
    contact_times_of_the_guard_follow_their_bodies_through_edits: check_edits;
    contacts_with_a_wall_of_any_length_are_guarded: check_short_walls;
    discs_lose_what_the_rules_for_any_bodies_take: check_discs;
}

/// A gas with a bumper and two kinds of discs, of which one loses no energy with itself. `law` is
/// the coefficient of restitution of all other pairs; the scene ends with `more`.
fn granular_mixture(law: &str, more: &str) -> Scene {
    Scene::from_toml(&format!(
        "[[gas]]\ntags = [\"a\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100\n\
         [[gas]]\ntags = [\"b\"]\nradius = 0.03\nmass = 3.0\nenergy = 1.0\ncount = 60\n\
         [[bumper]]\ntags = [\"f\"]\nradius = 0.08\nat = [0.5, 0.5]\n\
         [elasticity]\ncontact_time = 0.01\n\
         [[elasticity.pair]]\nbetween = [\"a\"]\ncoefficient = {law}\n\
         [[elasticity.pair]]\nbetween = [\"a\", \"b\"]\ncoefficient = {law}\n\
         [[elasticity.pair]]\nbetween = [\"a\", \"f\"]\ncoefficient = {law}\n{more}"
    ))
    .unwrap_or_else(|error| panic!("{error}"))
}

/// All that is reported of contacts.
#[derive(Default, PartialEq, Debug)]
struct Reports(Vec<String>);

impl Observer for Reports {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        let motions = report.sides.map(|side| (side.before, side.after));
        let CollisionReport {
            time,
            point,
            normal,
            impulse,
            elasticity,
            shift,
            ..
        } = report;
        let report = (time, motions, point, normal, impulse, elasticity, shift);
        self.0.push(format!("{report:?}"));
    }
}

/// Smooth contacts of two discs have a resolution of their own, except where the coefficient
/// depends on the speed. A table with one value has the same coefficients, and so must give the
/// same bits.
fn check_discs<S: Scheduler>(options: &S::Options) {
    let drag = "[box]\ndrag = 0.1\n";
    let gravity = "[gravity]\nacceleration = [0.0, -1.0]\n[[wall]]\ny = 0.0\n";
    let reaction =
        "[[reaction]]\nbetween = [\"a\", \"b\"]\nbecomes = [\"b\", \"a\"]\nprobability = 0.3\n";
    let cases = [
        (0.9, ""),
        (0.2, ""),
        (0.8, drag),
        (1.0, gravity),
        (0.9, gravity),
        (0.9, reaction),
    ];
    for (coefficient, more) in cases {
        let run = |law: &str| {
            let mut simulation = simulate::<S>(&granular_mixture(law, more), options);
            let mut reports = Reports::default();
            for _ in 0..3000 {
                assert!(simulation.step(1e9, &mut reports).unwrap());
            }
            let view = simulation.view();
            let (counters, ledger) = (*view.counters(), view.ledger());
            (bits(&view), reports, counters, ledger)
        };
        let constant = run(&coefficient.to_string());
        // Above its last speed a table has its last value, without rounding.
        let of_table = run(&format!(
            "{{ speeds = [1e-50, 2e-50], values = [{coefficient}, {coefficient}] }}"
        ));
        let counters = constant.2;
        assert_eq!(counters.guarded_collisions > 0, coefficient < 1.0, "{more}");
        assert_eq!(counters.reactions > 0, more == reaction);
        // Not the reports of all contacts, if they differ.
        assert!(constant == of_table, "{coefficient}, {more}");
    }
}

fn check_rattle<S: Scheduler>(options: &S::Options) {
    // Between two bumpers the disc moves by the gap from contact to contact, and t_c is 10⁻⁴
    // diameters: 10⁻⁵.
    for (gap, guarded) in [(0.9e-5, true), (1.1e-5, false)] {
        let mut narrow = scene(vec![disc(0.05, 1.0, [0.5, 0.5], [1.0, 0.0])]);
        narrow.bumper = vec![
            bumper(0.1, [0.35 - 0.5 * gap, 0.5]),
            bumper(0.1, [0.65 + 0.5 * gap, 0.5]),
        ];
        narrow.elasticity.default = 0.5;
        let mut simulation = simulate::<S>(&narrow, options);
        let mut losses = Losses::default();
        for _ in 0..10 {
            assert!(simulation.step(1.0, &mut losses).unwrap());
        }
        let (view, e) = (simulation.view(), if guarded { 1.0 } else { 0.5 });
        // The first contact has no contact before it.
        let expected: Vec<f64> = [0.5].into_iter().chain([e; 9]).collect();
        assert_eq!(losses.elasticities, expected);
        let speed = if guarded { 0.5 } else { 0.5f64.powi(10) };
        assert_eq!(velocity(&view, 0).x.abs(), speed);
        assert_eq!(
            view.counters().guarded_collisions,
            if guarded { 9 } else { 0 }
        );
        // ½ (1 − e²) u² for each guarded contact.
        let spared = if guarded {
            9.0 * 0.5 * 0.75 * 0.25
        } else {
            0.0
        };
        assert!((view.ledger().spared - spared).abs() < 1e-15);
        assert!((view.energy() - view.ledger().booked()).abs() < 1e-15);
    }
}

fn check_crowd<S: Scheduler>(options: &S::Options) {
    // Discs hit a large one from all sides, 10⁻⁹ apart in time; each of them has had no contact
    // before.
    for fixed in [true, false] {
        let mut list = vec![MoleculeSpec {
            fixed,
            ..disc(0.2, 1e6, [0.5, 0.5], [0.0; 2])
        }];
        for n in 0..8 {
            let towards = glam::DVec2::from_angle(f64::from(n) * PI / 4.0);
            let at = 0.5 + towards * (0.3 + 1e-9 * f64::from(n));
            list.push(disc(0.02, 1.0, at.to_array(), (-towards).to_array()));
        }
        let mut crowd = scene(list);
        crowd.elasticity.default = 0.5;
        let mut simulation = simulate::<S>(&crowd, options);
        let mut losses = Losses::default();
        simulation.observe_until(0.1, &mut losses).unwrap();
        assert_eq!(losses.elasticities, [0.5; 8]);
        assert_eq!(simulation.view().counters().guarded_collisions, 0);
    }
}

/// A column of discs at various heights above each other that falls on a bumper at speed 1.
fn column(count: usize, e: f64, contact_time: f64) -> Scene {
    const RADIUS: f64 = 0.01;
    let height = |n: usize| 0.1 + 0.025 * (n + 1) as f64 + 0.001 * ((n * 7) % 5) as f64;
    let mut column = scene(
        (0..count)
            .map(|n| disc(RADIUS, 1.0, [height(n), 0.5], [-1.0, 0.0]))
            .collect(),
    );
    column.bumper = vec![bumper(RADIUS, [0.1, 0.5])];
    column.bounds.sides = [10.0, 1.0];
    column.elasticity.default = e;
    column.elasticity.contact_time = contact_time;
    column
}

fn check_column<S: Scheduler>(options: &S::Options) {
    for (count, e) in [(6, 0.1), (12, 0.3), (24, 0.1), (12, 0.5), (24, 0.7)] {
        if e < 0.5 {
            let mut bare = simulate::<S>(&column(count, e, 0.0), options);
            assert!(
                matches!(bare.run_until(3.0), Err(RunError::Stalled { .. })),
                "{count} discs, e = {e}"
            );
        }
        let mut guarded = simulate::<S>(&column(count, e, 1e-4), options);
        guarded.run_until(3.0).unwrap();
        let view = guarded.view();
        assert_eq!((view.time().to_f64(), view.overlaps().pairs), (3.0, 0));
        let counters = view.counters();
        assert!(
            (100..10_000).contains(&counters.collisions),
            "{count} discs, e = {e}: {counters:?}"
        );
        assert!((1..counters.collisions).contains(&counters.guarded_collisions));
        // Nearly all of the energy is lost, even with the guard.
        assert!(
            view.energy() < 0.03 * view.ledger().initial,
            "{count} discs, e = {e}: {}",
            view.energy()
        );
    }
}

fn check_cooling<S: Scheduler>(options: &S::Options) {
    // Haff (1983): E = E(0)/(1 + t/τ)². In two dimensions 1/τ = (1 − e²) ω/4 with the rate ω = 2 n
    // σ χ √(π kT/m) of collisions of a disc and χ = (1 − 7φ/16)/(1 − φ)². So few discs stay mixed:
    // vortices need a larger box.
    const COUNT: usize = 200;
    const AREA: f64 = 0.1;
    const E: f64 = 0.9;
    const RUNS: u64 = 8;
    let times = [3.0, 10.0, 30.0];
    let radius = (AREA / (COUNT as f64 * PI)).sqrt();
    let chi = (1.0 - 7.0 * AREA / 16.0) / (1.0 - AREA).powi(2);
    let mut logarithm = [0.0; 3];
    for seed in 0..RUNS {
        let mut cooling = Scene {
            gas: vec![gas("disc", radius, COUNT)],
            ..Scene::default()
        };
        (cooling.gas[0].zero_momentum, cooling.bounds.seed) = (Some(true), seed);
        cooling.elasticity.default = E;
        let mut simulation = simulate::<S>(&cooling, options);
        let tau = |energy: f64| {
            // The total momentum, which is 0, removes two degrees of freedom.
            let temperature = energy / (COUNT - 1) as f64;
            let collisions = 2.0 * COUNT as f64 * 2.0 * radius * chi * (PI * temperature).sqrt();
            4.0 / ((1.0 - E * E) * collisions)
        };
        // All discs start with the same energy.
        let begun = tau(simulation.view().energy());
        simulation.run_until(begun).unwrap();
        let initial = simulation.view().energy();
        let tau = tau(initial);
        for (time, sum) in times.into_iter().zip(&mut logarithm) {
            simulation.run_until(begun + time * tau).unwrap();
            *sum +=
                (simulation.view().energy() / initial * (1.0 + time).powi(2)).ln() / RUNS as f64;
        }
        let view = simulation.view();
        assert!(view.counters().collisions > 30 * COUNT as u64);
        assert!(
            view.counters().guarded_collisions <= 2,
            "{:?}",
            view.counters()
        );
        assert!(view.ledger().spared < 1e-3 * view.ledger().lost);
    }
    // A single run scatters by 5%. Velocities of discs that have met are slightly more correlated
    // than the law assumes, so that the gas cools more slowly, by about 3% in the rate.
    assert!(
        logarithm.iter().all(|error| error.abs() < 0.1),
        "{logarithm:?}"
    );
}

fn check_molecules<S: Scheduler>(options: &S::Options) {
    for (shape, atom_radius, count) in [
        ("dumbbell", 0.03, 60),
        ("tee", 0.02, 30),
        ("rod:4", 0.015, 40),
    ] {
        for e in [0.0, 0.05, 0.3, 0.9] {
            let mut dense = Scene {
                gas: vec![gas(shape, atom_radius, count)],
                ..Scene::default()
            };
            dense.gas[0].zero_momentum = Some(true);
            dense.elasticity.default = e;
            let mut simulation = simulate::<S>(&dense, options);
            let mut losses = Losses::default();
            let mut energy = simulation.view().energy();
            for tick in 1..=40 {
                simulation
                    .observe_until(0.25 * f64::from(tick), &mut losses)
                    .unwrap();
                let view = simulation.view();
                assert_eq!(
                    view.overlaps().pairs,
                    0,
                    "{shape}, e = {e}: {:?}",
                    view.overlaps()
                );
                assert!(view.energy() <= energy * (1.0 + 1e-14));
                energy = view.energy();
            }
            let (view, ledger) = (simulation.view(), simulation.view().ledger());
            assert!((energy - ledger.booked()).abs() < 1e-12 * ledger.initial);
            assert!((losses.total - ledger.lost).abs() < 1e-12 * ledger.initial);
            assert!(energy < 0.1 * ledger.initial, "{shape}, e = {e}");
            // Without the guard there would be millions of contacts at the lower two elasticities.
            let collisions = view.counters().collisions;
            assert!(
                collisions < 2000 * count as u64,
                "{shape}, e = {e}: {collisions}"
            );
            assert!(
                ledger.spared < 0.02 * ledger.lost,
                "{shape}, e = {e}: {ledger:?}"
            );
        }
    }
}

fn check_elastic<S: Scheduler>(options: &S::Options) {
    for e in [1.0, 1.05] {
        let run = |contact_time: f64| {
            let mut lively = reference_scene(3);
            lively.elasticity.default = e;
            lively.elasticity.contact_time = contact_time;
            let mut simulation = simulate::<S>(&lively, options);
            simulation.run_until(0.5).unwrap();
            assert_eq!(simulation.view().counters().guarded_collisions, 0);
            bits(&simulation.view())
        };
        assert_eq!(run(0.0), run(1.0));
    }
}

fn check_bits<S: Scheduler>(options: &S::Options) {
    for e in [0.0, 0.05] {
        let mut base = frozen(&simulate::<S>(&reference_scene(2), options).view());
        base.elasticity.default = e;
        let mut whole = simulate::<S>(&base, options);
        whole.run_until(4.0).unwrap();
        assert!(whole.view().counters().guarded_collisions > 0, "e = {e}");

        let mut pieces = simulate::<S>(&base, options);
        for tick in 1..=400 {
            pieces.run_until(0.01 * f64::from(tick)).unwrap();
        }
        assert_eq!(bits(&pieces.view()), bits(&whole.view()));

        for exponent in [-40, -1, 1, 40] {
            let factor = 2f64.powi(exponent);
            let mut scaled = base.clone();
            for molecule in &mut scaled.molecule {
                molecule.velocity = molecule.velocity.map(|v| v * factor);
                molecule.angular_velocity *= factor;
            }
            let mut simulation = simulate::<S>(&scaled, options);
            simulation.run_until(4.0 / factor).unwrap();
            assert_eq!(
                simulation.view().counters(),
                whole.view().counters(),
                "e = {e}, 2^{exponent}"
            );
            for (scaled, one) in simulation.view().bodies().zip(whole.view().bodies()) {
                assert_eq!(scaled.motion.position, one.motion.position);
                assert_eq!(scaled.motion.orientation, one.motion.orientation);
                assert_eq!(scaled.motion.velocity, one.motion.velocity * factor);
            }
        }
    }
}

fn check_edits<S: Scheduler>(options: &S::Options) {
    // A disc rattles in a gap of 0.9 t_c; a disc inserted before it is removed; another is added.
    let mut narrow = scene(vec![
        disc(0.01, 1.0, [0.1, 0.1], [0.0; 2]),
        disc(0.05, 1.0, [0.5, 0.5], [1.0, 0.0]),
    ]);
    narrow.bumper = vec![
        bumper(0.1, [0.35 - 0.45e-5, 0.5]),
        bumper(0.1, [0.65 + 0.45e-5, 0.5]),
    ];
    narrow.elasticity.default = 0.5;
    let mut simulation = simulate::<S>(&narrow, options);
    let mut losses = Losses::default();
    let mut step = |simulation: &mut carom_engine::Simulation<_, _, S>| {
        assert!(simulation.step(1.0, &mut losses).unwrap());
        *losses.elasticities.last().unwrap()
    };
    assert_eq!([step(&mut simulation), step(&mut simulation)], [0.5, 1.0]);
    let first = simulation.view().bodies().next().unwrap().body.key();
    simulation.remove(first).unwrap();
    assert_eq!(step(&mut simulation), 1.0);
    simulation
        .add(&disc(0.01, 1.0, [0.9, 0.9], [0.0; 2]))
        .unwrap();
    assert_eq!(step(&mut simulation), 1.0);
    // Where no contact loses energy, no times are kept: the first contact after that has no contact
    // before it.
    let mut spec = narrow.elasticity.clone();
    spec.default = 1.0;
    simulation.set_elasticity(&spec).unwrap();
    assert_eq!(step(&mut simulation), 1.0);
    spec.default = 0.5;
    simulation.set_elasticity(&spec).unwrap();
    assert_eq!([step(&mut simulation), step(&mut simulation)], [0.5, 1.0]);
}

/// Counts contacts with a fixed body that lose no energy.
#[derive(Default)]
struct RaisedAtFixed(u32);

impl Observer for RaisedAtFixed {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        let is_fixed = report.sides.iter().any(|side| side.body.is_fixed());
        self.0 += u32::from(is_fixed && report.elasticity.coefficient() == 1.0);
    }
}

fn check_short_walls<S: Scheduler>(options: &S::Options) {
    // A light disc between a wall and a heavy disc that presses on it: without a guard there are
    // contacts without end.
    let vice = |length: f64, contact_time: f64| {
        let mut vice = scene(vec![
            disc(0.05, 1e-2, [0.3, 0.0], [0.0; 2]),
            disc(0.1, 1e2, [0.6, 0.0], [-1.0, 0.0]),
        ]);
        let ends = [[0.1, -0.5 * length], [0.1, 0.5 * length]].map(Some);
        vice.wall = vec![WallSpec {
            from: ends[0],
            to: ends[1],
            ..WallSpec::default()
        }];
        vice.elasticity.default = 0.05;
        vice.elasticity.contact_time = contact_time;
        let (mut simulation, mut with_wall) =
            (simulate::<S>(&vice, options), RaisedAtFixed::default());
        (simulation.observe_until(1.0, &mut with_wall), with_wall.0)
    };
    for length in [0.5, 1e-3, 1e-20, 1e-50] {
        // From the end of a short wall the disc may slip aside.
        let (ended, _) = vice(length, 0.0);
        assert!(
            matches!(ended, Err(RunError::Stalled { .. })) || length < 1e-10,
            "{length:e}: {ended:?}"
        );
        let (ended, guarded) = vice(length, 1e-4);
        assert!(
            ended.is_ok() && guarded > 10,
            "{length:e}: {ended:?} {guarded}"
        );
    }
}
