//! Rough contacts: each contact keeps Walton's law, discs turn, perfectly rough gases conserve the
//! energy and reach equipartition, and the rates of exchange are those of kinetic theory.

use crate::support::{
    bits, bumper, disc, gas, reference_scene, scene, simulate, test_each_scheduler,
};
use carom_detection::Exact;
use carom_engine::{
    CellScheduler, CollisionReport, DiameterSpec, DrawKey, ElasticityRule, GasSpec, Instructions,
    MoleculeSpec, Observer, Restitution, Rotation, Scene, Scheduler, Side, Simulation,
    ThermostatRule, ThermostatTarget, WallSpec,
};
use carom_kinematics::{Inertia, Motion, angular_momentum, kinetic_energy};
use carom_response::{ContactFrame, Elasticity, Impact, Response};
use glam::{DMat2, DVec2};

/// Asserts the law of a rough contact, with a formula independent of the engine: the matrix A of
/// the velocities that a unit impulse gives the two surfaces.
struct WaltonLaw {
    contacts: u32,
    slid: u32,
    lost: f64,
}

impl Observer for WaltonLaw {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.contacts += 1;
        let (e, elasticity) = (report.elasticity.coefficient(), report.elasticity);
        let [n, t] = [report.normal, report.normal.perp()];
        let arms = report.sides.map(|side| side.arm);
        // Both end at the point of contact, in a box of sides 1.
        let ends = report.sides.map(|side| side.before.position + side.arm);
        let gap = ends[1] - ends[0];
        assert!((gap - gap.round()).length() < 1e-12, "{gap}");
        let mut inverse = DMat2::ZERO;
        for (side, arm) in report.sides.iter().zip(arms) {
            let inertia = side.body.inertia();
            // The point p turns by r × J / I, which moves it by that times the perpendicular of r.
            let column = |axis: DVec2| {
                axis * inertia.inverse_mass
                    + arm.perp() * (arm.perp_dot(axis) * inertia.inverse_moment)
            };
            inverse += DMat2::from_cols(column(DVec2::X), column(DVec2::Y));
        }
        let relative = |of: fn(&Side<'_>) -> Motion| {
            let [a, b] = &report.sides;
            of(a).velocity_of(arms[0]) - of(b).velocity_of(arms[1])
        };
        let (before, after) = (relative(|side| side.before), relative(|side| side.after));
        let [along, across] = [report.impulse.dot(n), report.impulse.dot(t)];
        let scale = before.length() + (inverse * report.impulse).length();
        assert!((after - (before - inverse * report.impulse)).length() < 1e-12 * scale);
        assert!(
            (after.dot(n) + e * before.dot(n)).abs() < 1e-12 * scale,
            "e = {e}"
        );
        let slip = |velocity: DVec2| {
            velocity.dot(t) - n.dot(inverse * t) / n.dot(inverse * n) * velocity.dot(n)
        };
        let sticks = (slip(after) + elasticity.tangential() * slip(before)).abs() < 1e-12 * scale;
        let slides =
            (across.abs() - elasticity.friction() * along).abs() < 1e-12 * report.impulse.length();
        assert!(sticks || slides, "{across} {along}");
        assert!(
            slides
                || across.abs() <= elasticity.friction() * along
                || elasticity.friction() == f64::INFINITY
        );
        self.slid += u32::from(slides && !sticks);
        self.lost -= report.sides.iter().map(Side::energy_change).sum::<f64>();
        // Angular momentum about the point of contact.
        for side in &report.sides {
            let about = |motion: &Motion| {
                angular_momentum(motion, side.body.inertia(), motion.position + side.arm)
            };
            if side.body.inertia().inverse_moment > 0.0 {
                let size = report.impulse.length() * (side.arm.length() + 0.01)
                    + about(&side.before).abs();
                assert!((about(&side.after) - about(&side.before)).abs() < 1e-12 * size);
            }
        }
    }
}

/// The reference scene with walls and these coefficients of all contacts.
fn rough(e: f64, tangential: f64, friction: Option<f64>) -> Scene {
    let mut scene = reference_scene(31);
    scene.elasticity.default = e;
    (scene.elasticity.tangential, scene.elasticity.friction) = (tangential, friction);
    scene.elasticity.contact_time = 0.0;
    scene
}

fn check_laws<S: Scheduler>(options: &S::Options) {
    let mut walled = rough(0.8, 0.3, Some(0.2));
    walled.bumper.clear();
    walled.molecule.truncate(2);
    walled.wall = vec![
        WallSpec {
            y: Some(0.0),
            ..WallSpec::default()
        },
        WallSpec {
            from: Some([0.45, 0.6]),
            to: Some([0.55, 0.7]),
            radius: 0.01,
            ..WallSpec::default()
        },
    ];
    let squares = Scene::from_toml(
        "[box]\nseed = 5\n[elasticity]\ndefault = 0.9\ntangential = 0.2\nfriction = 0.4\n[[gas]]\n\
         shape = \"square\"\nsize = 0.04\nmass = 1.0\ntemperature = 1.0\ncount = 100\n[[gas]]\nradius = 0.01\n\
         mass = 0.5\ntemperature = 1.0\ncount = 50\n[[wall]]\nx = 0.0",
    )
    .unwrap();
    let mut mixture = rough(0.9, 0.5, Some(0.3));
    mixture.gas.truncate(2);
    (mixture.molecule, mixture.bumper) = (vec![], vec![]);
    for (gas, tag) in mixture.gas.iter_mut().zip(["small", "large"]) {
        gas.tags = vec![tag.to_owned()];
    }
    mixture.diameter = vec![DiameterSpec {
        between: vec!["small".to_owned(), "large".to_owned()],
        factor: 0.7,
    }];
    for (scene, slides) in [
        (rough(0.9, 0.5, None), false),
        (rough(0.9, 0.5, Some(0.3)), true),
        (rough(0.5, -0.5, Some(2.0)), true),
        (rough(1.0, 1.0, None), false),
        (walled, true),
        (squares, true),
        (mixture, true),
    ] {
        let mut simulation = simulate::<S>(&scene, options);
        let mut law = WaltonLaw {
            contacts: 0,
            slid: 0,
            lost: 0.0,
        };
        let initial = simulation.view().energy();
        simulation.observe_until(2.0, &mut law).unwrap();
        let view = simulation.view();
        assert!(law.contacts > 300, "{}", law.contacts);
        assert_eq!(law.slid > 0, slides);
        assert!((view.energy() - (initial - law.lost)).abs() < 1e-12 * initial);
        assert!((view.energy() - view.ledger().booked()).abs() < 1e-12 * initial);
        assert_eq!(view.overlaps().pairs, 0);
    }
}

test_each_scheduler! {
    each_rough_contact_keeps_the_law_of_walton: check_laws;
}

#[test]
fn schedulers_agree_on_a_rough_gas() {
    // Dilute, dense and with large discs: each layout of the cells.
    for (radius, count, others) in [(0.004, 100, 0), (0.02, 200, 0), (0.015, 100, 3)] {
        let mut scene = scene(vec![]);
        scene.gas = vec![gas("disc", radius, count), gas("disc", 0.08, others)];
        scene.elasticity.tangential = 0.5;
        scene.elasticity.default = 0.95;
        let until = 0.2;
        let run = |mut simulation: Simulation<_, _, CellScheduler>| {
            simulation.run_until(until).unwrap();
            let view = simulation.view();
            view.bodies()
                .map(|body| body.motion.angular_velocity)
                .collect::<Vec<f64>>()
        };
        let cells = run(simulate::<CellScheduler>(&scene, &Instructions::Widest));
        let portable = run(simulate::<CellScheduler>(&scene, &Instructions::Portable));
        assert_eq!(cells, portable);
        let mut heap =
            simulate::<carom_engine::HeapScheduler>(&scene, &carom_engine::CellsPerSide::Automatic);
        heap.run_until(0.01).unwrap();
        let mut cells = simulate::<CellScheduler>(&scene, &Instructions::Widest);
        cells.run_until(0.01).unwrap();
        for (one, other) in heap.view().bodies().zip(cells.view().bodies()) {
            let (one, other) = (one.motion, other.motion);
            let scale = 1.0 + one.angular_velocity.abs();
            assert!((one.angular_velocity - other.angular_velocity).abs() < 1e-6 * scale);
            assert!((one.orientation.turns() - other.orientation.turns()).abs() < 1e-6 * scale);
        }
    }
}

#[test]
fn perfectly_rough_discs_and_dumbbells_conserve_the_energy_and_share_it() {
    for shape in ["disc", "dumbbell"] {
        let mut scene = scene(vec![]);
        scene.gas = vec![GasSpec {
            temperature: Some(1.0),
            energy: 0.0,
            ..gas(shape, 0.015, 200)
        }];
        scene.elasticity.tangential = 1.0;
        let mut simulation = Simulation::new(&scene).unwrap();
        let initial = simulation.view().energy();
        // Maxwell's distribution has begun with 3 degrees of freedom for each.
        assert!((simulation.view().temperature().unwrap() - 1.0).abs() < 1e-12);
        let [mut turning, mut samples] = [0.0; 2];
        for sample in 1..=600 {
            simulation.run_until(0.2 * f64::from(sample)).unwrap();
            let view = simulation.view();
            let frame = view.centre_of_mass_frame();
            let thermal = frame.thermal(view.bodies());
            if sample > 60 {
                turning += 2.0 * thermal.rotation / 200.0;
                samples += 1.0;
            }
        }
        let view = simulation.view();
        let collisions = view.counters().collisions;
        assert!(collisions > 100_000, "{shape}: {collisions}");
        let drift = view.energy() / initial - 1.0;
        assert!(drift.abs() < 1e-12, "{shape}: {drift:e}");
        let turning = turning / samples;
        assert!((turning - 1.0).abs() < 0.02, "{shape}: {turning}");
    }
}

#[test]
fn angular_momentum_is_conserved_in_the_open_plane() {
    let row = |n: u32| MoleculeSpec {
        angular_velocity: f64::from(n) - 3.0,
        ..disc(
            0.05,
            1.0 + f64::from(n % 3),
            [3.0 + 0.12 * f64::from(n), 5.0 + 0.013 * f64::from(n % 4)],
            [1.0 - 0.4 * f64::from(n), 0.1 * f64::from(n % 2)],
        )
    };
    let mut scene = scene((0..6).map(row).collect());
    scene.bounds.sides = [10.0, 10.0];
    (scene.elasticity.default, scene.elasticity.tangential) = (0.9, 0.4);
    scene.elasticity.friction = Some(0.5);
    let mut simulation = Simulation::new(&scene).unwrap();
    let total = |simulation: &Simulation| {
        let about = DVec2::new(2.0, -1.0);
        let bodies = simulation.view();
        let each = bodies
            .bodies()
            .map(|body| angular_momentum(&body.motion, body.body.inertia(), about));
        each.sum::<f64>()
    };
    let before = total(&simulation);
    let spins = |simulation: &Simulation| {
        let view = simulation.view();
        view.bodies()
            .map(|body| body.motion.angular_velocity)
            .collect::<Vec<f64>>()
    };
    let first = spins(&simulation);
    simulation.run_until(1.0).unwrap();
    assert!(simulation.view().counters().collisions >= 5);
    assert_ne!(first, spins(&simulation));
    assert!((total(&simulation) - before).abs() < 1e-12 * before.abs().max(10.0));
}

#[test]
fn a_disc_rolls_along_a_rough_wall_as_the_law_says() {
    // J_n = (1 + e) m u and J_t = (1 + β) m g_t/3 with 1/m_t = (1 + 2)/m for a uniform disc.
    let mut scene = scene(vec![disc(0.1, 2.0, [0.5, 0.5], [1.0, -2.0])]);
    scene.wall = vec![WallSpec {
        y: Some(0.0),
        ..WallSpec::default()
    }];
    scene.elasticity.pair = vec![ElasticityRule {
        between: vec!["floor".to_owned()],
        coefficient: 0.5.into(),
        tangential: 0.25,
        ..ElasticityRule::default()
    }];
    scene.wall[0].tags = vec!["floor".to_owned()];
    for (friction, slip) in [(None, 1.25 / 3.0), (Some(0.1), 0.1 * 1.5 * 2.0)] {
        scene.elasticity.pair[0].friction = friction;
        let mut simulation = Simulation::new(&scene).unwrap();
        simulation.run_until(0.3).unwrap();
        let motion = simulation.view().bodies().next().unwrap().motion;
        assert!((motion.velocity - DVec2::new(1.0 - slip, 1.0)).length() < 1e-13);
        // I ω = −r J_t: it turns clockwise as it moves to the right.
        assert!((motion.angular_velocity + 0.1 * 2.0 * slip / 0.01).abs() < 1e-12);
    }
}

/// Perfectly rough contacts, whatever the elasticity of the scene.
struct Gears;

impl Response for Gears {
    fn impulse(
        &self,
        frame: &ContactFrame,
        bodies: [(&Motion, &Inertia); 2],
        elasticity: Elasticity,
    ) -> DVec2 {
        let rough = elasticity.with_tangential(1.0).expect("in range");
        Impact.impulse(frame, bodies, rough)
    }

    fn is_rough(&self, _: Elasticity) -> bool {
        true
    }
}

#[test]
fn a_response_of_ones_own_may_be_rough() {
    let row = |n: u32| {
        let at = [
            0.05 + 0.1 * f64::from(n % 10),
            0.05 + 0.1 * f64::from(n / 10),
        ];
        disc(
            0.03,
            1.0,
            at,
            [f64::from(n % 7) - 3.0, f64::from(n % 5) - 2.0],
        )
    };
    let smooth = scene((0..100).map(row).collect());
    let mut table = smooth.clone();
    table.elasticity.tangential = 1.0;
    let options = Instructions::default();
    let mut own: Simulation<Exact, Gears, CellScheduler> =
        Simulation::with(&smooth, Exact::default(), Gears, options).unwrap();
    let mut standard = Simulation::new(&table).unwrap();
    own.run_until(1.0).unwrap();
    standard.run_until(1.0).unwrap();
    assert!(own.view().counters().collisions > 1000);
    assert!(
        own.view()
            .bodies()
            .all(|body| body.motion.angular_velocity != 0.0)
    );
    assert_eq!(bits(&own.view()), bits(&standard.view()));
}

#[test]
fn locked_discs_have_no_spin_and_two_degrees_of_freedom() {
    let mut scene = rough(0.9, 0.5, None);
    scene.gas.truncate(1);
    scene.gas[0].rotation = Rotation::Locked;
    scene.molecule.clear();
    let mut simulation = Simulation::new(&scene).unwrap();
    assert!(simulation.view().bodies().all(|body| !body.body.can_turn()));
    simulation.run_until(0.1).unwrap();
    let view = simulation.view();
    assert!(
        view.bodies()
            .all(|body| body.motion.angular_velocity == 0.0)
    );
    assert!(view.ledger().lost > 0.0);
}

#[test]
fn restitution_follows_the_speed_of_approach() {
    let law = Restitution::Power {
        power: -0.25,
        at: 0.1,
    };
    for speed in [0.05, 0.4, 1.6] {
        let mut scene = scene(vec![disc(0.05, 1.0, [0.3, 0.5], [speed, 0.0])]);
        scene.bumper = vec![bumper(0.05, [0.6, 0.5])];
        scene.bumper[0].tags = vec!["post".to_owned()];
        scene.elasticity.pair = vec![ElasticityRule {
            between: vec!["post".to_owned()],
            coefficient: law.clone(),
            ..ElasticityRule::default()
        }];
        let mut simulation = Simulation::new(&scene).unwrap();
        simulation.run_until(0.25 / speed).unwrap();
        let velocity = simulation.view().bodies().next().unwrap().motion.velocity;
        let expected = speed * (speed / 0.1).powf(-0.25).min(1.0);
        assert!((velocity.x + expected).abs() < 1e-15, "{speed}: {velocity}");
    }
}

/// Angular momentum of the orbits that kicks of 0.01 drive, over the distance of the centres.
struct Orbit(f64);

impl Observer for Orbit {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        assert!((report.impulse.dot(report.normal.perp()) - 0.01).abs() < 1e-14);
        self.0 += report.normal.perp_dot(report.impulse);
    }
}

#[test]
fn a_kick_of_chiral_discs_drives_their_orbit_and_is_booked() {
    let mut scene = rough(1.0, -1.0, None);
    scene.gas.truncate(1);
    scene.molecule.clear();
    scene.bumper.clear();
    scene.gas[0].tags = vec!["chiral".to_owned()];
    scene.gas[0].rotation = Rotation::Locked;
    scene.elasticity.pair = vec![ElasticityRule {
        between: vec!["chiral".to_owned()],
        kick: 0.01,
        ..ElasticityRule::default()
    }];
    let mut simulation = Simulation::new(&scene).unwrap();
    let (initial, mut orbit) = (simulation.view().energy(), Orbit(0.0));
    simulation.observe_until(2.0, &mut orbit).unwrap();
    let view = simulation.view();
    assert!(
        orbit.0 > 0.5 && view.momentum().length() < 1e-11,
        "{} {}",
        orbit.0,
        view.momentum()
    );
    assert!(view.ledger().lost != 0.0);
    assert!((view.energy() - initial + view.ledger().lost).abs() < 1e-12 * view.energy());
}

/// Changes of the energies of translation and of rotation, summed over contacts.
#[derive(Default)]
struct Exchange {
    contacts: f64,
    moving: f64,
    turning: f64,
}

impl Observer for Exchange {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.contacts += 1.0;
        for side in &report.sides {
            let turning = |motion: &Motion| {
                let still = Motion {
                    velocity: DVec2::ZERO,
                    ..*motion
                };
                kinetic_energy(&still, side.body.inertia())
            };
            let change = turning(&side.after) - turning(&side.before);
            self.turning += change;
            self.moving += side.energy_change() - change;
        }
    }
}

/// dT_tr and dT_rot for each contact of a disc, from Maxwell's distribution with T_tr = 1 and this
/// T_rot, in `windows` windows of 0.02 contacts of a disc.
fn rates(area_fraction: f64, e: f64, beta: f64, t_rot: f64, windows: u64) -> [f64; 2] {
    let mut scene = scene(vec![]);
    scene.gas = vec![GasSpec {
        tags: vec!["gas".to_owned()],
        temperature: Some(1.0),
        energy: 0.0,
        ..gas(
            "disc",
            (area_fraction / 4000.0 / std::f64::consts::PI).sqrt(),
            4000,
        )
    }];
    scene.elasticity.default = e;
    scene.elasticity.tangential = beta;
    let mut simulation = Simulation::new(&scene).unwrap();
    // Mean time between contacts of a disc, for the length of a window.
    simulation.run_until(0.02).unwrap();
    let free_time = 4000.0 * 0.02 / (2.0 * simulation.view().counters().collisions as f64);
    let tag = simulation.find_tag("gas").unwrap();
    let mut sums = Exchange::default();
    let rule = ThermostatRule::Maxwell(ThermostatTarget::Temperature(1.0));
    for window in 0..windows {
        let key = DrawKey {
            seed: 1,
            replica: 0,
            action: window,
        };
        simulation
            .edit(|batch| {
                batch.thermostat(tag, &rule, key)?;
                if t_rot == 0.0 {
                    let keys: Vec<_> = batch.moving().collect();
                    for key in keys {
                        batch.set_angular_velocity(key, 0.0)?;
                    }
                }
                Ok(())
            })
            .unwrap();
        let until = simulation.time().to_f64() + 0.02 * free_time;
        simulation.observe_until(until, &mut sums).unwrap();
    }
    // Two discs for each contact; T_tr is the energy of translation, T_rot twice that of rotation.
    [
        0.5 * sums.moving / sums.contacts,
        sums.turning / sums.contacts,
    ]
}

#[test]
fn rates_of_exchange_are_those_of_kinetic_theory() {
    let q = 0.5;
    for (area_fraction, e, beta, t_rot) in [
        (0.1, 1.0, 0.0, 0.0),
        (0.5, 0.9, 0.5, 1.0),
        (0.5, 0.9, 0.5, 0.0),
        (0.1, 1.0, 0.0, 1.0),
    ] {
        let h = q * (1.0 + beta) / (2.0 * (1.0 + q));
        let expected = [
            -((1.0 - e * e) / 2.0 + h * (1.0 - h)) + h * h / q * t_rot,
            2.0 * (h * h / q - h / q * (1.0 - h / q) * t_rot),
        ];
        let found = rates(area_fraction, e, beta, t_rot, 1000);
        for (found, expected) in found.into_iter().zip(expected) {
            // 1.5 % is statistical, and up to 1 % the change within a window.
            assert!((found / expected - 1.0).abs() < 0.06, "{found} {expected}");
        }
    }
}
