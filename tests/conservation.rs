//! Conservation of momentum, energy and angular momentum at each contact and over whole runs, for
//! any masses, shapes and elasticity, with free and locked bodies.

use crate::support::property::cases;
use crate::support::{named, scene, simulate, test_each_scheduler};
use carom_engine::{
    AtomSpec, Body, CollisionReport, MoleculeSpec, Observer, Rotation, Scene, Scheduler, View,
    rounding_bound,
};
use carom_geometry::PeriodicBox;
use carom_kinematics::{Motion, angular_momentum};
use glam::DVec2;
use proptest::prelude::*;

/// Asserts the laws of a smooth impact at each contact, with formulas independent of the engine.
struct Laws {
    bounds: PeriodicBox,
    elasticity: f64,
    /// Contacts whose elasticity the guard has raised.
    guarded: u64,
    /// ½ (1 − e²) μ u², summed over all contacts.
    lost: f64,
    contacts: usize,
}

impl Laws {
    fn new(view: &View<'_>, elasticity: f64) -> Self {
        Self {
            bounds: view.bounds(),
            elasticity,
            guarded: 0,
            lost: 0.0,
            contacts: 0,
        }
    }
}

/// Speed along `normal` of the point of the body at `point` (length / time).
fn surface_speed(motion: &Motion, point: DVec2, normal: DVec2) -> f64 {
    let arm = point - motion.position;
    normal.dot(motion.velocity + motion.angular_velocity * DVec2::new(-arm.y, arm.x))
}

/// 1/m + (r × n)²/I.
fn inverse_mass_at(body: &Body, motion: &Motion, point: DVec2, normal: DVec2) -> f64 {
    let lever = (point - motion.position).perp_dot(normal);
    body.inertia().inverse_mass + lever * lever * body.inertia().inverse_moment
}

impl Observer for Laws {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.contacts += 1;
        // The image of the second body that is touched.
        let shift = self.bounds.shift(report.image);
        let moved = |motion: Motion| Motion {
            position: motion.position + shift,
            ..motion
        };
        let [a, b] = &report.sides;
        let motions = [[a.before, a.after], [moved(b.before), moved(b.after)]];
        let (point, normal) = (report.point, report.normal);
        assert!((normal.length() - 1.0).abs() < 1e-15);
        for (side, [before, after]) in [a, b].into_iter().zip(&motions) {
            // The point is on the surface of the touching atom.
            let atom = &side.body.molecule().atoms()[side.atom.expect("an atom touches") as usize];
            let centre = before.position + before.orientation.cos_sin().rotate(atom.offset());
            let reach = a.body.molecule().bounding_radius() + b.body.molecule().bounding_radius();
            let bound = rounding_bound(self.bounds.sides(), reach);
            assert!(((point - centre).length() - atom.radius()).abs() < bound);
            assert_eq!(
                (before.position, before.orientation),
                (after.position, after.orientation)
            );
        }

        let approach = |when: usize| {
            surface_speed(&motions[0][when], point, normal)
                - surface_speed(&motions[1][when], point, normal)
        };
        let inverse = inverse_mass_at(a.body, &motions[0][0], point, normal)
            + inverse_mass_at(b.body, &motions[1][0], point, normal);
        let speeds: f64 = motions
            .as_flattened()
            .iter()
            .map(|m| m.velocity.length() + m.angular_velocity.abs() * (point - m.position).length())
            .sum();
        let (u, e) = (approach(0), report.elasticity.coefficient());
        // The guard against collapse raises the elasticity, to 1 at most.
        assert!(e == self.elasticity || (self.elasticity..=1.0).contains(&e));
        self.guarded += u64::from(e != self.elasticity);
        // Surfaces approach at each contact, to rounding.
        assert!(u > -1e-12 * speeds, "u = {u}");
        assert!(
            (approach(1) + e * u).abs() < 1e-12 * speeds,
            "parting at {} after {u}",
            -approach(1)
        );
        let impulse = (1.0 + e) * u.max(0.0) / inverse;
        assert!((report.impulse - impulse * normal).length() < 1e-12 * (speeds / inverse));

        let loss = 0.5 * (1.0 - e * e) * u * u / inverse;
        let change = a.energy_change() + b.energy_change();
        let energies: f64 = [(a.body, a.before), (b.body, b.before)]
            .iter()
            .map(|(body, motion)| carom_kinematics::kinetic_energy(motion, body.inertia()))
            .sum();
        let scale = energies + (1.0 + e) * (1.0 + e) * u * u / inverse;
        assert!(
            (change + loss).abs() < 1e-12 * scale,
            "{change} against {}",
            -loss
        );
        self.lost += loss;

        if !a.body.is_fixed() && !b.body.is_fixed() {
            let scale: f64 = [a, b]
                .iter()
                .map(|side| side.before.velocity.length() / side.body.inertia().inverse_mass)
                .sum::<f64>()
                + impulse;
            assert!((a.momentum_change() + b.momentum_change()).length() < 1e-14 * scale);
        }
        for ((side, sign), [before, after]) in [(a, -1.0), (b, 1.0)].into_iter().zip(&motions) {
            // Δv = J/m, and the change of L about the body's own centre is the moment of J at the
            // point of contact.
            let (inertia, arm) = (side.body.inertia(), point - before.position);
            let received = sign * report.impulse;
            let scale = before.velocity.length() + received.length() * inertia.inverse_mass;
            let difference = side.velocity_change() - received * inertia.inverse_mass;
            assert!(difference.length() <= 1e-14 * scale);
            if side.body.is_locked() {
                assert_eq!(
                    (
                        side.angular_velocity_change(),
                        side.angular_momentum_change()
                    ),
                    (0.0, 0.0)
                );
                continue;
            }
            let scale = before.angular_velocity.abs() / inertia.inverse_moment
                + arm.length() * received.length();
            let difference = side.angular_momentum_change() - arm.perp_dot(received);
            assert!(difference.abs() <= 1e-13 * scale, "{difference} of {scale}");
            // The impulse has no moment about the point of contact: each body alone conserves L
            // about it.
            let about = |motion: &Motion| angular_momentum(motion, side.body.inertia(), point);
            let arm = (point - before.position).length();
            let scale = arm
                * (before.velocity.length() / side.body.inertia().inverse_mass + impulse)
                + before.angular_velocity.abs() / side.body.inertia().inverse_moment;
            assert!((about(after) - about(before)).abs() < 1e-13 * scale);
        }
    }
}

/// A molecule of any kind whose bounding circle fits one site of a 3 × 3 lattice.
fn molecules() -> impl Strategy<Value = MoleculeSpec> {
    let shape = prop_oneof![
        Just(("disc", 1.0)),
        Just(("dumbbell", 2.0)),
        Just(("tee", 3.8)),
        Just(("cross", 3.0)),
        Just(("rod:4", 4.0)),
        // A large atom and a small one of a different density.
        Just(("", 2.0)),
    ];
    let numbers = (
        0.04..0.15f64,
        -3.0..3.0f64,
        -1.0..1.0f64,
        -1.0..1.0f64,
        -5.0..5.0f64,
        0.0..1.0f64,
        0..5u8,
    );
    (shape, numbers).prop_map(
        |((shape, reach), (size, exponent, vx, vy, spin, turns, mobility))| {
            let (radius, mass) = (size / reach, 10f64.powf(exponent));
            let mut spec = if shape.is_empty() {
                let atom = |x: f64, radius: f64, mass: f64| AtomSpec {
                    at: [x, 0.0],
                    radius,
                    mass,
                };
                let atoms = vec![
                    atom(0.0, 1.2 * radius, mass),
                    atom(1.1 * radius, 0.4 * radius, 3.0 * mass),
                ];
                MoleculeSpec {
                    atoms,
                    ..MoleculeSpec::default()
                }
            } else {
                named(shape, radius, mass, [0.0; 2])
            };
            spec.orientation_turns = Some(turns);
            match mobility {
                0 => spec.fixed = true,
                1 => (spec.rotation, spec.velocity) = (Rotation::Locked, [vx, vy]),
                _ => spec.velocity = [vx, vy],
            }
            if mobility > 1 && shape != "disc" {
                spec.angular_velocity = spin;
            }
            spec
        },
    )
}

fn systems() -> impl Strategy<Value = Scene> {
    prop::collection::vec(molecules(), 2..=9).prop_map(|mut list| {
        for (site, molecule) in list.iter_mut().enumerate() {
            molecule.at = [(site % 3) as f64 / 3.0, (site / 3) as f64 / 3.0];
        }
        scene(list)
    })
}

fn elasticities() -> impl Strategy<Value = f64> {
    prop_oneof![2 => Just(1.0), 1 => 0.0..0.05f64, 1 => 0.0..1.0f64, 1 => 1.0..1.1f64]
}

fn check_system<S: Scheduler>(scene: &Scene, elasticity: f64, options: &S::Options) {
    let mut simulation = simulate::<S>(scene, options);
    let start = simulation.view().momentum();
    let mut laws = Laws::new(&simulation.view(), elasticity);
    let mut last = simulation.time();
    for _ in 0..150 {
        if !simulation.step(20.0, &mut laws).unwrap() {
            break;
        }
        assert!(simulation.time() >= last);
        last = simulation.time();
    }
    let view = simulation.view();
    assert_eq!(view.counters().collisions as usize, laws.contacts);
    assert_eq!(view.overlaps().pairs, 0);
    assert_eq!(view.counters().guarded_collisions, laws.guarded);
    let scale = view.ledger().initial + view.energy();
    assert!((view.energy() - (view.ledger().initial - laws.lost)).abs() <= 1e-11 * scale);
    assert!((view.energy() - view.ledger().booked()).abs() <= 1e-11 * scale);
    if view.bodies().all(|body| !body.body.is_fixed()) {
        let sizes: f64 = view
            .bodies()
            .map(|body| body.motion.velocity.length() / body.body.inertia().inverse_mass)
            .sum();
        assert!((view.momentum() - start).length() <= 1e-12 * (sizes + start.length()));
    }
}

proptest! {
    #![proptest_config(cases(96))]

    #[test]
    fn each_contact_and_each_run_satisfy_the_conservation_laws(mut scene in systems(), e in elasticities()) {
        scene.elasticity.default = e;
        check_system::<carom_engine::HeapScheduler>(&scene, e, &carom_engine::CellsPerSide::Automatic);
        check_system::<carom_engine::CellScheduler>(&scene, e, &carom_engine::Instructions::Widest);
    }
}

test_each_scheduler! {
    a_cluster_far_from_the_border_conserves_its_angular_momentum: check_cluster;
    an_inelastic_gas_agrees_with_the_ledger_and_conserves_its_momentum: check_inelastic_gas;
}

/// Nine molecules move towards each other in the middle of a box so large that none reaches its
/// border.
fn check_cluster<S: Scheduler>(options: &S::Options) {
    let mut list = Vec::new();
    for site in 0..9 {
        let shape = ["tee", "dumbbell", "disc"][site % 3];
        let place = DVec2::new((site % 3) as f64 - 1.0, (site / 3) as f64 - 1.0);
        let mut molecule = named(shape, 0.1, 1.0 + site as f64, (place + 100.0).to_array());
        molecule.velocity = (0.3 * place.perp() - place).to_array();
        if shape != "disc" {
            molecule.angular_velocity = 2.0 - site as f64;
        }
        list.push(molecule);
    }
    let mut scene = scene(list);
    scene.bounds.sides = [200.0, 200.0];
    scene.elasticity.default = 0.9;
    let mut simulation = simulate::<S>(&scene, options);
    let about = DVec2::new(100.0, 100.0);
    let total = |view: &View<'_>| -> f64 {
        view.bodies()
            .map(|body| angular_momentum(&body.motion, body.body.inertia(), about))
            .sum()
    };
    let before = total(&simulation.view());
    simulation.run_until(20.0).unwrap();
    let view = simulation.view();
    assert!(
        view.counters().collisions >= 8,
        "{} contacts",
        view.counters().collisions
    );
    assert!(view.bodies().all(|body| body.winding == [0, 0]));
    assert!(
        (total(&view) - before).abs() < 1e-11 * before.abs(),
        "{} after {before}",
        total(&view)
    );
}

fn check_inelastic_gas<S: Scheduler>(options: &S::Options) {
    let mut scene = Scene {
        gas: vec![crate::support::gas("disc", 0.02, 150)],
        ..Scene::default()
    };
    // The gas drifts: a total momentum other than 0 must also be conserved.
    scene.gas[0].zero_momentum = Some(false);
    scene.elasticity.default = 0.9;
    let mut simulation = simulate::<S>(&scene, options);
    let mut laws = Laws::new(&simulation.view(), 0.9);
    let momentum = simulation.view().momentum();
    let mut energy = simulation.view().energy();
    for tick in 1..=20 {
        simulation
            .observe_until(0.1 * f64::from(tick), &mut laws)
            .unwrap();
        let view = simulation.view();
        assert!(view.energy() < energy);
        energy = view.energy();
        assert!((energy - view.ledger().booked()).abs() < 1e-10 * view.ledger().initial);
        assert!((view.ledger().lost - laws.lost).abs() < 1e-10 * laws.lost);
        assert!((view.momentum() - momentum).length() < 1e-11 * momentum.length());
    }
    // Haff (1983): T decreases as exp(−(1 − e²) τ/2) with τ collisions per disc, at least at the
    // beginning.
    let collisions = 2.0 * simulation.view().counters().collisions as f64 / 150.0;
    let expected = (-0.5 * (1.0 - 0.81) * collisions).exp();
    let measured = energy / simulation.view().ledger().initial;
    assert!(collisions > 5.0 && (measured / expected).ln().abs() < 0.15 * expected.ln().abs());
}
