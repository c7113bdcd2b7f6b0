//! No two bodies sink into each other: pairs and clusters that start in contact, at any elasticity,
//! for a long time.

use std::f64::consts::TAU;

use crate::support::{disc, named, scene, simulate};
use carom_engine::{
    CollisionReport, MoleculeSpec, Observer, Rotation, RunError, Scene, Scheduler, Side, WallSpec,
};
use carom_geometry::{EdgedShape, Molecule, gap_between};
use carom_kinematics::{EpochTime, Orientation};
use glam::DVec2;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Deepest allowed overlap, in roundings (ε) of the side of the box.
const MAX_DEPTH: f64 = 16.0;

/// A run stops after this many contacts, so that pairs that rattle at elasticity 1 end.
const MAX_CONTACTS: u64 = 20_000;

/// Result of a run.
#[derive(Debug, Clone, Copy, Default)]
struct Depth {
    /// Deepest overlap at any check and at any contact, in roundings of the side.
    deepest: f64,
    contacts: u64,
}

impl Observer for Depth {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        let [a, b] = &report.sides;
        let rotation = |side: &Side<'_>| side.before.orientation.cos_sin();
        // The box is the unit square.
        let image = DVec2::new(report.image[0] as f64, report.image[1] as f64);
        let separation = (b.before.position - a.before.position) + image;
        let gap = gap_between(
            a.body.molecule(),
            rotation(a),
            b.body.molecule(),
            rotation(b),
            separation,
        );
        self.deepest = self.deepest.max(-gap / f64::EPSILON);
        self.contacts += 1;
    }
}

/// Runs a scene in the unit box to `until`, and checks overlaps at times that grow by a factor.
fn depth<S: Scheduler>(scene: &Scene, options: &S::Options, until: f64, most: u64) -> Depth {
    let mut simulation = simulate::<S>(scene, options);
    let mut result = Depth::default();
    let mut time = 1e-9;
    let mut is_over = false;
    while !is_over && result.contacts < most {
        // An epoch has a few contacts per body, so that runs with many contacts end soon after
        // `most`.
        let run = simulation.observe_epoch(EpochTime::from(time), &mut result);
        match run {
            Ok(false) => continue,
            Ok(true) => is_over = time >= until,
            // Without a guard a collapse ends with this error.
            Err(RunError::Stalled { .. }) if scene.elasticity.contact_time == 0.0 => break,
            Err(error) => panic!("{error}\n{}", scene.to_toml()),
        }
        let overlap = simulation.view().overlaps().deepest_length;
        result.deepest = result.deepest.max(overlap / f64::EPSILON);
        time = until.min(2.0 * time);
    }
    result
}

/// Shapes of unions of discs; more often discs.
const OF_DISCS: [&str; 7] = ["disc", "disc", "dumbbell", "tee", "rod:4", "cross", "rod:9"];

/// Shapes with sides, and two others.
const WITH_SIDES: [&str; 8] = [
    "square",
    "capsule:2",
    "triangle",
    "rectangle:8",
    "polygon:5",
    "kite:2,0.5",
    "disc",
    "dumbbell",
];

struct Draw {
    random: Pcg64,
    shapes: &'static [&'static str],
}

impl Draw {
    fn new(seed: u64, shapes: &'static [&'static str]) -> Self {
        let random = Pcg64::seed_from_u64(seed);
        Self { random, shapes }
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.random.random::<f64>()
    }

    fn one_of<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.random.random_range(0..list.len())]
    }

    fn direction(&mut self) -> DVec2 {
        DVec2::from_angle(self.between(0.0, TAU))
    }

    /// A body of a random kind near the middle of the box.
    fn body(&mut self) -> MoleculeSpec {
        let shape = self.one_of(self.shapes);
        let radius = 0.01 * 10f64.powf(self.between(-1.0, 0.0));
        let mass = 10f64.powf(self.between(-2.0, 2.0));
        let at = [self.between(0.4, 0.6), self.between(0.4, 0.6)];
        let mut body = named(shape, radius, mass, at);
        if shape.parse::<EdgedShape>().is_ok() {
            (body.atom_radius, body.atom_mass) = (None, None);
            (body.size, body.mass) = (Some(2.0 * radius), Some(mass));
        }
        body.orientation = Some(self.between(0.0, TAU));
        let rotates = shape != "disc" && self.random.random::<f64>() < 0.8;
        if rotates {
            body.angular_velocity = self.one_of(&[0.0, 1.0, 80.0]) * self.between(-1.0, 1.0);
        } else if shape != "disc" {
            body.rotation = Rotation::Locked;
        }
        body
    }

    /// The initial gap: none, or one between 10⁻¹⁷ and 10⁻⁹.
    fn gap(&mut self) -> f64 {
        if self.random.random::<f64>() < 0.3 {
            0.0
        } else {
            10f64.powf(self.between(-17.0, -9.0))
        }
    }

    /// Places a body next to another, `gap` away from it in a random direction, with a slow or fast
    /// closing velocity.
    fn put_beside(&mut self, first: &MoleculeSpec, body: &mut MoleculeSpec) {
        let gap = self.gap();
        let towards = self.direction();
        let [a, b] = [first, &*body].map(molecule);
        let rotation = |spec: &MoleculeSpec| {
            Orientation::from_radians(spec.orientation.unwrap_or(0.0)).cos_sin()
        };
        let mut distance = a.bounding_radius() + b.bounding_radius() + gap;
        for _ in 0..200 {
            let now = gap_between(&a, rotation(first), &b, rotation(body), distance * towards);
            distance -= now - gap;
        }
        body.at = (DVec2::from_array(first.at) + distance * towards).to_array();
        let closing = self.one_of(&[0.0, 1e-15, 1e-12, 1e-9, 1e-3, 1.0]) * self.between(-0.2, 1.0);
        let slip = self.one_of(&[0.0, 1e-6, 1.0]) * self.between(-1.0, 1.0);
        let velocity =
            DVec2::from_array(first.velocity) - closing * towards + slip * towards.perp();
        body.velocity = velocity.to_array();
    }

    /// A pair or a small cluster that drifts together or rests, and may start in contact with a
    /// wall.
    fn cluster(&mut self, elasticity: f64) -> Scene {
        let drift = self.one_of(&[0.0, 1.0, 3.0]) * self.direction();
        let mut first = self.body();
        first.velocity = drift.to_array();
        let mut bodies = vec![first];
        for _ in 0..self.one_of(&[1, 1, 1, 2, 3]) {
            let mut body = self.body();
            for _ in 0..100 {
                let index = self.random.random_range(0..bodies.len());
                let beside = bodies[index].clone();
                self.put_beside(&beside, &mut body);
                let is_free = bodies.iter().all(|other| gap_of(other, &body) > -1e-15);
                if is_free {
                    bodies.push(body);
                    break;
                }
            }
        }
        let mut scene = scene(bodies);
        if self.random.random::<f64>() < 0.2 {
            let [x, y] = [self.between(0.0, 0.3), self.between(0.0, 1.0)];
            scene.wall.push(WallSpec {
                x: Some(x),
                ..WallSpec::default()
            });
            scene.wall.push(WallSpec {
                y: Some(0.5 * y),
                ..WallSpec::default()
            });
            for body in &mut scene.molecule {
                body.at = [body.at[0] + 0.1, body.at[1] + 0.25];
            }
            scene.wall[1].y = Some(0.1);
        }
        scene.elasticity.default = elasticity;
        scene
    }
}

fn molecule(spec: &MoleculeSpec) -> Molecule {
    spec.molecule("molecule").unwrap()
}

fn gap_of(a: &MoleculeSpec, b: &MoleculeSpec) -> f64 {
    let rotation =
        |spec: &MoleculeSpec| Orientation::from_radians(spec.orientation.unwrap_or(0.0)).cos_sin();
    let separation = DVec2::from_array(b.at) - DVec2::from_array(a.at);
    gap_between(
        &molecule(a),
        rotation(a),
        &molecule(b),
        rotation(b),
        separation,
    )
}

/// Defines two tests of a slow check, `name::thesis` and `name::cells_widest`.
macro_rules! test_both_schedulers {
    ($($name:ident: $check:ident;)+) => {$(
        mod $name {
            #[test]
            fn thesis() {
                super::$check::<carom_engine::HeapScheduler>(&carom_engine::CellsPerSide::Automatic);
            }

            #[test]
            fn cells_widest() {
                super::$check::<carom_engine::CellScheduler>(&carom_engine::Instructions::Widest);
            }
        }
    )+};
}

test_both_schedulers! {
    discs_that_rest_on_each_other_after_an_inelastic_contact_do_not_sink: check_discs_together;
    dumbbells_with_very_frequent_contacts_do_not_sink: check_chatter;
    pairs_and_clusters_do_not_sink_at_any_elasticity: check_clusters;
    pairs_and_clusters_do_not_sink_without_a_guard: check_unguarded_clusters;
    bodies_with_sides_do_not_sink_at_any_elasticity: check_clusters_with_sides;
    squares_and_capsules_cool_to_nothing_without_sinking: check_cooling_sides;
    a_square_that_rattles_in_a_slot_does_not_sink: check_slot;
}

fn check_discs_together<S: Scheduler>(options: &S::Options) {
    let mut together = scene(vec![
        disc(0.05, 1.0, [0.38, 0.41], [1.24, 0.88]),
        disc(0.05, 1.0, [0.62, 0.59], [0.76, 0.52]),
    ]);
    together.elasticity.default = 0.0;
    let result = depth::<S>(&together, options, 1e6, MAX_CONTACTS);
    assert!(result.deepest <= MAX_DEPTH, "{result:?}");
}

/// Two free dumbbells that start a few roundings apart and at first touch about 10⁸ times per unit
/// of time.
fn check_chatter<S: Scheduler>(options: &S::Options) {
    let dumbbell = |radius, at, turns: f64, velocity, spin| MoleculeSpec {
        orientation: Some(turns * TAU),
        velocity,
        angular_velocity: spin,
        ..named("dumbbell", radius, 0.5, at)
    };
    let chatter = scene(vec![
        dumbbell(
            0.009_922_583_614_975_94,
            [0.678_880_576_565_390_5, 0.783_864_411_701_111_7],
            -0.339_845_217_574_412_7,
            [-0.039_070_746_914_478_635, -0.002_846_296_350_398_488_3],
            7.070_361_268_931_865,
        ),
        dumbbell(
            0.009_946_610_356_961_719,
            [0.702_650_188_703_127_8, 0.792_375_603_730_489_1],
            0.270_643_578_100_760_7,
            [-0.910_750_257_515_886_2, 0.099_528_585_946_979_66],
            -73.004_305_305_640_9,
        ),
    ]);
    let result = depth::<S>(&chatter, options, 1e-2, u64::MAX);
    eprintln!("{result:?}");
    assert!(
        result.contacts > 1000 && result.deepest <= MAX_DEPTH,
        "{result:?}"
    );
}

fn check_clusters<S: Scheduler>(options: &S::Options) {
    for elasticity in [0.0, 1e-3, 0.5, 1.0] {
        check::<S>(options, elasticity, None, &OF_DISCS);
    }
}

fn check_unguarded_clusters<S: Scheduler>(options: &S::Options) {
    for elasticity in [0.0, 1e-3, 0.5] {
        check::<S>(options, elasticity, Some(0.0), &OF_DISCS);
    }
}

fn check_clusters_with_sides<S: Scheduler>(options: &S::Options) {
    for elasticity in [0.0, 0.5, 1.0] {
        check::<S>(options, elasticity, None, &WITH_SIDES);
    }
}

/// Gases of bodies with sides lose all but 10⁻²⁶ of their energy: speeds fall by 10¹³, and with
/// them the speeds at which bodies part, while the rounding of places stays.
fn check_cooling_sides<S: Scheduler>(options: &S::Options) {
    for (shape, size) in [("square", 0.06), ("capsule:2", 0.03)] {
        let cooling = Scene::from_toml(&format!(
            "[[gas]]\nshape = \"{shape}\"\nsize = {size}\nmass = 1.0\nenergy = 1.0\ncount = 60\n\
             zero_momentum = true\n[elasticity]\ndefault = 0.9\n"
        ));
        let mut simulation = simulate::<S>(&cooling.unwrap(), options);
        let mut deepest = 0.0f64;
        let mut time = 0.1;
        while simulation.view().energy() > 1e-26 * simulation.view().ledger().initial {
            simulation.run_until(time).unwrap();
            let overlaps = simulation.view().overlaps();
            assert_eq!(overlaps.pairs, 0, "{shape} at {time:e}: {overlaps:?}");
            deepest = deepest.max(overlaps.deepest_length / f64::EPSILON);
            time *= 2.0;
            assert!(time < 1e20, "{shape}: the gas keeps its energy");
        }
        let (view, ledger) = (simulation.view(), simulation.view().ledger());
        assert!(deepest <= MAX_DEPTH, "{shape}: {deepest}");
        assert!((view.energy() - ledger.booked()).abs() < 1e-13 * ledger.initial);
        let momentum = view.momentum().length();
        // Of 60 bodies that started at a speed of about 1.
        assert!(momentum < 1e-12, "{shape}: {momentum:e}");
        eprintln!(
            "{shape}: {} contacts, {} guarded, {time:e}, {deepest} roundings",
            view.counters().collisions,
            view.counters().guarded_collisions
        );
    }
}

/// A square in a closed slot, wider than the square by a share `gap` of its side, at elasticity 0:
/// it is in lasting contact, in which the guard lets it rattle. `CONTACTS=1e6` sets their number.
fn check_slot<S: Scheduler>(options: &S::Options) {
    let contacts: f64 = std::env::var("CONTACTS").map_or(3e4, |text| text.parse().unwrap());
    for gap in [1e-6, 1e-10] {
        let [half, size] = [0.05 * (1.0 + gap), 0.1 - 2e-7];
        let side = |x: f64, y: f64, x2: f64, y2: f64| WallSpec {
            from: Some([0.5 + x * half, 0.5 + y * half]),
            to: Some([0.5 + x2 * half, 0.5 + y2 * half]),
            ..WallSpec::default()
        };
        let mut slot = scene(vec![MoleculeSpec {
            shape: Some("square".to_owned()),
            size: Some(size),
            mass: Some(1.0),
            at: [0.5, 0.5],
            velocity: [0.3, -1.0],
            angular_velocity: 2.0,
            ..MoleculeSpec::default()
        }]);
        slot.wall = vec![
            side(-1.0, -1.0, 1.0, -1.0),
            side(-1.0, -1.0, -1.0, 1.5),
            side(1.0, -1.0, 1.0, 1.5),
            side(-1.0, 1.0, 1.0, 1.0),
        ];
        slot.elasticity.default = 0.0;
        let result = depth::<S>(&slot, options, 1e30, contacts as u64);
        eprintln!("gap {gap:e}: {result:?}");
        assert!(result.contacts as f64 >= contacts, "{gap}: {result:?}");
        assert!(result.deepest <= MAX_DEPTH, "{gap}: {result:?}");
    }
}

/// Runs random clusters; environment variables set their number and duration: `CASES=10000
/// UNTIL=1e6` takes hours.
fn check<S: Scheduler>(
    options: &S::Options,
    elasticity: f64,
    contact_time: Option<f64>,
    shapes: &'static [&'static str],
) {
    let setting = |name: &str, default: f64| {
        std::env::var(name).map_or(default, |text| text.parse().unwrap())
    };
    let (cases, until) = (setting("CASES", 40.0) as u64, setting("UNTIL", 1e3));
    let mut worst = Depth::default();
    for case in 0..cases {
        let mut scene = Draw::new(case, shapes).cluster(elasticity);
        if let Some(contact_time) = contact_time {
            scene.elasticity.contact_time = contact_time;
        }
        let result = depth::<S>(&scene, options, until, MAX_CONTACTS);
        assert!(
            result.deepest <= MAX_DEPTH,
            "e = {elasticity}, case {case}: {result:?}\n{}",
            scene.to_toml()
        );
        worst.deepest = worst.deepest.max(result.deepest);
        worst.contacts = worst.contacts.max(result.contacts);
    }
    eprintln!("e = {elasticity}, guard {contact_time:?}: {cases} cases, {worst:?}");
}
