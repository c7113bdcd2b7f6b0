//! Short constructors of scenes, and runs as bits and lists of encounters, for the tests of the
//! engine.

pub mod formulas;
pub mod property;

use carom_detection::Exact;
use carom_engine::{
    BumperSpec, CellScheduler, CellsPerSide, CollisionReport, ElasticityRule, GasSpec,
    HeapScheduler, Instructions, MoleculeSpec, Observer, Rotation, Scene, Scheduler, Simulation,
    View, WallSpec,
};
use carom_kinematics::EpochTime;
use carom_response::Impact;
use glam::DVec2;

pub use carom_testkit::extremes::bodies::{bumper, disc, frozen, named};

/// Defines tests of a check, one for each scheduler and instruction set, in a module with the name
/// of the property: `name::thesis`, `name::cells_avx512`, `name::cells_avx2`,
/// `name::cells_portable`.
///
/// The check is a function with the scheduler as its type parameter and its options as argument.
macro_rules! test_each_scheduler {
    ($($(#[$attribute:meta])* $name:ident: $check:ident;)+) => {$(
        $(#[$attribute])*
        mod $name {
            #[test]
            fn thesis() {
                super::$check::<carom_engine::HeapScheduler>(&carom_engine::CellsPerSide::Automatic);
            }

            crate::support::tests_of_instructions!(super::$check::<carom_engine::CellScheduler>);
        }
    )+};
}
pub(crate) use test_each_scheduler;

/// Defines tests of a check, one for each instruction set of
/// [`CellScheduler`](carom_engine::CellScheduler), in a module with the name of the property. The
/// check is a function of the instructions.
macro_rules! test_each_instruction_set {
    ($($(#[$attribute:meta])* $name:ident: $check:ident;)+) => {$(
        $(#[$attribute])*
        mod $name {
            crate::support::tests_of_instructions!(|instructions: &_| super::$check(*instructions));
        }
    )+};
}
pub(crate) use test_each_instruction_set;

/// The tests `cells_avx512`, `cells_avx2` and `cells_portable` of a check.
macro_rules! tests_of_instructions {
    ($check:expr) => {
        crate::support::test_of_instructions!(cells_avx512, Widest, $check);
        crate::support::test_of_instructions!(cells_avx2, Avx2, $check);
        crate::support::test_of_instructions!(cells_portable, Portable, $check);
    };
}
pub(crate) use tests_of_instructions;

/// A test of a check with one instruction set, in a module of the test program.
macro_rules! test_of_instructions {
    ($name:ident, $instructions:ident, $check:expr) => {
        #[test]
        fn $name() {
            let name = concat!(module_path!(), "::", stringify!($name));
            crate::support::if_available(name, carom_engine::Instructions::$instructions, $check);
        }
    };
}
pub(crate) use test_of_instructions;

/// Runs the check `name` if the processor has these instructions; otherwise reports that it is
/// skipped.
pub fn if_available(name: &str, instructions: Instructions, check: impl FnOnce(&Instructions)) {
    let present = instructions.on_this_processor();
    if present == instructions {
        check(&instructions);
    } else {
        carom_testkit::skipped::skipped(
            name,
            format_args!("the best instructions here are {present:?}"),
        );
    }
}

/// A gas of `count` molecules of a named shape, each of total mass 1 and energy 1.
pub fn gas(shape: &str, atom_radius: f64, count: usize) -> GasSpec {
    let atoms = shape
        .parse::<carom_geometry::Shape>()
        .unwrap()
        .atoms(1.0, 1.0)
        .unwrap()
        .len();
    GasSpec {
        shape: Some(shape.to_owned()),
        atom_radius: Some(atom_radius.into()),
        atom_mass: Some((1.0 / atoms as f64).into()),
        energy: 1.0,
        count: Some(count),
        ..GasSpec::default()
    }
}

/// A scene of single molecules in the unit box.
pub fn scene(molecule: Vec<MoleculeSpec>) -> Scene {
    Scene {
        molecule,
        ..Scene::default()
    }
}

/// A scene with all kinds of bodies that the engine treats differently: discs of two sizes,
/// molecules free and locked, fixed discs, a fixed molecule.
pub fn reference_scene(seed: u64) -> Scene {
    let mut scene = scene(vec![
        MoleculeSpec {
            angular_velocity: 3.0,
            velocity: [0.5, -0.25],
            ..named("tee", 0.02, 0.5, [0.25, 0.25])
        },
        MoleculeSpec {
            rotation: Rotation::Locked,
            ..named("cross", 0.02, 0.5, [0.75, 0.25])
        },
        MoleculeSpec {
            fixed: true,
            orientation: Some(0.3),
            ..named("dumbbell", 0.02, 1.0, [0.5, 0.75])
        },
    ]);
    scene.bounds.seed = seed;
    scene.bumper = vec![bumper(0.03, [0.0, 0.0]), bumper(0.05, [0.25, 0.75])];
    scene.gas = vec![
        gas("disc", 0.02, 60),
        gas("disc", 0.04, 8),
        gas("dumbbell", 0.015, 12),
    ];
    scene
}

/// Small scenes that together use all kinds of bodies, and all kinds of lists that a scheduler
/// keeps.
#[expect(clippy::too_many_lines, reason = "one table of scenes")]
pub fn scenes() -> Vec<(&'static str, Scene)> {
    let with = |molecule: Vec<MoleculeSpec>, bumper: Vec<BumperSpec>, gas: Vec<GasSpec>| {
        let mut scene = Scene {
            molecule,
            bumper,
            gas,
            ..Scene::default()
        };
        scene.bounds.seed = 20_261_121;
        scene
    };
    let of_discs = |radius, count| with(vec![], vec![], vec![gas("disc", radius, count)]);
    // Light discs that soon become faster than any body at the start.
    let light = GasSpec {
        atom_mass: Some((1e-3).into()),
        energy: 1e-9,
        ..gas("disc", 0.004, 60)
    };
    let mut kicked = with(vec![], vec![], vec![gas("disc", 0.004, 60), light]);
    kicked.bounds.sides = [1.5, 0.5];
    let middle = |shape: &str, atom_radius| named(shape, atom_radius, 2.0, [0.5, 0.5]);
    let big = disc(0.15, 25.0, [0.9, 0.1], [0.0; 2]);
    let small = |x, y| bumper(0.02, [x, y]);
    let mut wide = of_discs(0.03, 120);
    wide.bounds.sides = [2.0, 0.5];
    let line = |x: Option<f64>, y: Option<f64>| WallSpec {
        x,
        y,
        ..WallSpec::default()
    };
    let flap = |from, to, radius| WallSpec {
        from: Some(from),
        to: Some(to),
        radius,
        ..WallSpec::default()
    };
    let walled = |wall: Vec<WallSpec>, scene: Scene| Scene { wall, ..scene };
    let fixed = MoleculeSpec {
        fixed: true,
        ..middle("cross", 0.04)
    };
    let fast = MoleculeSpec {
        angular_velocity: 900.0,
        velocity: [0.0, 3.0],
        at: [0.2, 0.75],
        ..middle("rod:8", 0.01)
    };
    vec![
        ("dense discs", of_discs(0.04, 95)),
        ("dilute discs", of_discs(0.004, 100)),
        ("dilute light discs among heavy ones in a wide box", kicked),
        ("a wide box", wide),
        (
            "like sizes",
            with(
                vec![],
                vec![],
                vec![gas("disc", 0.03, 60), gas("disc", 0.02, 60)],
            ),
        ),
        (
            "unlike sizes",
            with(vec![big.clone()], vec![], vec![gas("disc", 0.02, 150)]),
        ),
        (
            "bumpers",
            with(
                vec![],
                vec![small(0.0, 0.0), small(0.3, 0.99)],
                vec![gas("disc", 0.02, 150)],
            ),
        ),
        (
            "a tee in its gas",
            with(
                vec![middle("tee", 0.01)],
                vec![small(0.1, 0.1)],
                vec![gas("disc", 0.02, 180)],
            ),
        ),
        (
            "tees and discs",
            with(
                vec![],
                vec![],
                vec![gas("tee", 0.01, 12), gas("disc", 0.02, 120)],
            ),
        ),
        (
            "dumbbells",
            with(vec![], vec![], vec![gas("dumbbell", 0.02, 80)]),
        ),
        (
            "few dumbbells far apart",
            with(vec![], vec![], vec![gas("dumbbell", 0.004, 30)]),
        ),
        (
            "molecules, some discs, a big disc and a long rod",
            with(
                vec![big.clone(), middle("rod:16", 0.01)],
                vec![small(0.0, 0.4), bumper(0.08, [0.2, 0.7])],
                vec![
                    gas("dumbbell", 0.015, 50),
                    gas("tee", 0.01, 15),
                    gas("disc", 0.02, 20),
                ],
            ),
        ),
        (
            "a fixed cross, a big disc and a fast rod",
            with(
                vec![fixed, big, fast],
                vec![],
                vec![gas("disc", 0.015, 120)],
            ),
        ),
        (
            "three cells a side",
            with(
                vec![middle("dumbbell", 0.1)],
                vec![],
                vec![gas("disc", 0.15, 5)],
            ),
        ),
        ("too few cells for a grid", of_discs(0.2, 4)),
        (
            "a closed box of discs",
            walled(
                vec![line(Some(0.0), None), line(None, Some(0.3))],
                of_discs(0.03, 120),
            ),
        ),
        (
            "flaps across the border, tees and discs",
            walled(
                vec![
                    flap([0.8, 0.4], [1.3, 0.7], 0.0),
                    flap([0.1, 0.1], [0.1, -0.3], 0.01),
                ],
                with(
                    vec![],
                    vec![],
                    vec![gas("tee", 0.01, 12), gas("disc", 0.02, 120)],
                ),
            ),
        ),
        (
            "dumbbells between walls",
            walled(
                vec![line(Some(0.7), None), flap([0.0, 0.5], [0.5, 0.5], 0.0)],
                with(vec![], vec![], vec![gas("dumbbell", 0.02, 60)]),
            ),
        ),
        (
            "a wall in a box of too few cells, longer than it",
            walled(vec![flap([0.1, 0.0], [1.6, 0.2], 0.0)], of_discs(0.12, 3)),
        ),
    ]
}

/// A simulation of the scene with a given scheduler.
pub fn simulate<S: Scheduler>(scene: &Scene, options: &S::Options) -> Simulation<Exact, Impact, S> {
    Simulation::with(scene, Exact::default(), Impact, options.clone())
        .expect("the scene can be built")
}

/// Two unit discs on the x axis that meet head-on at time 2, each with speed 1.
pub fn head_on<S: Scheduler>(options: &S::Options) -> Simulation<Exact, Impact, S> {
    let mut scene = scene(vec![
        disc(0.5, 1.0, [7.5, 5.0], [1.0, 0.0]),
        disc(0.5, 1.0, [12.5, 5.0], [-1.0, 0.0]),
    ]);
    scene.molecule[0].tags = vec!["left".to_owned()];
    scene.bounds.sides = [20.0, 10.0];
    simulate::<S>(&scene, options)
}

/// A rule of elasticity.
pub fn rule(between: &[&str], coefficient: f64) -> ElasticityRule {
    ElasticityRule {
        between: between.iter().map(|&tag| tag.to_owned()).collect(),
        coefficient: coefficient.into(),
        ..ElasticityRule::default()
    }
}

/// All numbers of all motions, as bits.
pub fn bits(view: &View<'_>) -> Vec<[u64; 6]> {
    view.bodies()
        .map(|body| {
            let motion = body.motion;
            [
                motion.position.x,
                motion.position.y,
                motion.velocity.x,
                motion.velocity.y,
                motion.orientation.turns(),
                motion.angular_velocity,
            ]
            .map(f64::to_bits)
        })
        .collect()
}

/// Velocity of the body inserted as number `index`.
pub fn velocity(view: &View<'_>, index: usize) -> DVec2 {
    view.bodies()
        .nth(index)
        .expect("the body is there")
        .motion
        .velocity
}

/// One collision, for comparison with one of another run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Encounter {
    /// Time since the start of the list.
    pub time: f64,
    pub bodies: [u64; 2],
    pub atoms: [Option<u32>; 2],
    pub image: [i64; 2],
}

/// Records all collisions.
#[derive(Debug, Clone)]
pub struct Encounters {
    begun: EpochTime,
    pub list: Vec<Encounter>,
}

impl Encounters {
    pub fn since(begun: EpochTime) -> Self {
        Self {
            begun,
            list: Vec::new(),
        }
    }

    pub fn times(&self) -> Vec<f64> {
        self.list.iter().map(|encounter| encounter.time).collect()
    }

    /// The encounters of one body, in order.
    pub fn of(&self, body: u64) -> impl Iterator<Item = &Encounter> {
        self.list
            .iter()
            .filter(move |encounter| encounter.bodies.contains(&body))
    }
}

impl Observer for Encounters {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.list.push(Encounter {
            time: report.time.since(self.begun),
            bodies: [report.sides[0].body.id(), report.sides[1].body.id()],
            atoms: [report.sides[0].atom, report.sides[1].atom],
            image: report.image,
        });
    }
}

/// Asserts that a run in portable code, and one that is resumed at the end of an epoch, have the
/// bits of an ordinary one.
pub fn check_portable_and_resumed(scene: &Scene) {
    let mut cells = Simulation::new(scene).unwrap();
    let mut portable = simulate::<CellScheduler>(scene, &Instructions::Portable);
    // A checkpoint is made at the end of an epoch.
    while cells.time() < EpochTime::from(0.2) {
        cells.observe_epoch(EpochTime::from(1.0), &mut ()).unwrap();
    }
    let stored = cells.checkpoint().expect("the epoch has ended");
    cells.run_until(0.6).unwrap();
    portable.run_until(0.6).unwrap();
    let expected = bits(&cells.view());
    assert_eq!(bits(&portable.view()), expected);
    let mut resumed = Simulation::resume(&stored).unwrap();
    resumed.run_until(0.6).unwrap();
    assert_eq!(bits(&resumed.view()), expected);
}

/// Asserts that both schedulers find the same first contacts. The heap searches each pair from the
/// start, the cells from a lower bound on: times differ by roundings, which contacts amplify.
pub fn check_heap_against_cells(scene: &Scene) {
    let mut cells = Simulation::new(scene).unwrap();
    let mut heap = simulate::<HeapScheduler>(scene, &CellsPerSide::Automatic);
    cells.run_until(0.02).unwrap();
    heap.run_until(0.02).unwrap();
    let collisions = [cells.view(), heap.view()].map(|view| view.counters().collisions);
    assert!(
        collisions[0] > 20 && collisions[0] == collisions[1],
        "{collisions:?}"
    );
    for (one, other) in cells.view().bodies().zip(heap.view().bodies()) {
        let apart = (one.motion.position - other.motion.position).length();
        assert!(apart < 1e-9, "{apart:e}");
    }
}
