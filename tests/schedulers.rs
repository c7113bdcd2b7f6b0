//! The two schedulers against each other and against brute force: same contacts, same partners, nothing missed.

use carom_detection::Exact;
use carom_engine::{
    AtomSpec, BumperSpec, Cells, CollisionReport, Fineness, GasSpec, Instructions, MoleculeSpec, Observer,
    Scene, Scheduler, Simulation, Thesis, WallSpec,
};
use carom_response::Impact;

type With<S> = Simulation<Exact, Impact, S>;

fn build<S: Scheduler>(scene: &Scene, options: S::Options) -> With<S> {
    Simulation::with(scene, Exact::default(), Impact, options).expect("the scenes of this file can be built")
}

fn gas(radius: f64, count: usize) -> GasSpec {
    GasSpec { radius: Some(radius), mass: Some(1.0), energy: 1.0, count: Some(count), ..GasSpec::default() }
}

fn molecules(shape: &str, atom_radius: f64, count: usize) -> GasSpec {
    GasSpec {
        shape: Some(shape.to_owned()),
        atom_radius: Some(atom_radius),
        atom_mass: Some(0.5),
        energy: 1.5,
        count: Some(count),
        ..GasSpec::default()
    }
}

fn single(shape: &str, atom_radius: f64) -> MoleculeSpec {
    MoleculeSpec {
        shape: Some(shape.to_owned()),
        atom_radius: Some(atom_radius),
        atom_mass: Some(2.0),
        at: [0.5, 0.5],
        ..MoleculeSpec::default()
    }
}

/// Scenes that between them use every kind of body and every kind of listing.
fn scenes() -> Vec<(&'static str, Scene)> {
    let with = |molecule: Vec<MoleculeSpec>, bumper: Vec<BumperSpec>, gas: Vec<GasSpec>| {
        let mut scene = Scene { molecule, bumper, gas, ..Scene::default() };
        scene.bounds.seed = 20_261_121;
        scene
    };
    let disc = |radius: f64| AtomSpec { at: [0.0; 2], radius, mass: 25.0 };
    let big = MoleculeSpec { atoms: vec![disc(0.15)], at: [0.9, 0.1], ..MoleculeSpec::default() };
    let bumper = |x, y| BumperSpec { radius: 0.02, at: [x, y], tags: vec![] };
    let mut wide = with(vec![], vec![], vec![gas(0.03, 120)]);
    wide.bounds.sides = [2.0, 0.5];
    let line = |x: Option<f64>, y: Option<f64>| WallSpec { x, y, ..WallSpec::default() };
    let flap = |from, to, radius| WallSpec { from: Some(from), to: Some(to), radius, ..WallSpec::default() };
    let walled = |wall: Vec<WallSpec>, scene: Scene| Scene { wall, ..scene };
    let fixed = MoleculeSpec { fixed: true, ..single("cross", 0.04) };
    let fast = MoleculeSpec { angular_velocity: 900.0, velocity: [0.0, 3.0], ..single("rod:8", 0.01) };
    vec![
        ("dense discs", with(vec![], vec![], vec![gas(0.04, 95)])),
        ("dilute discs", with(vec![], vec![], vec![gas(0.004, 100)])),
        ("a wide box", wide),
        ("like sizes", with(vec![], vec![], vec![gas(0.03, 60), gas(0.02, 60)])),
        ("unlike sizes", with(vec![big.clone()], vec![], vec![gas(0.02, 150)])),
        ("bumpers", with(vec![], vec![bumper(0.0, 0.0), bumper(0.3, 0.99)], vec![gas(0.02, 150)])),
        ("a tee in its gas", with(vec![single("tee", 0.01)], vec![bumper(0.1, 0.1)], vec![gas(0.02, 180)])),
        ("tees and discs", with(vec![], vec![], vec![molecules("tee", 0.01, 12), gas(0.02, 120)])),
        ("dumbbells", with(vec![], vec![], vec![molecules("dumbbell", 0.02, 80)])),
        ("a fixed cross, a big disc and a fast rod", {
            let rod = MoleculeSpec { at: [0.2, 0.75], ..fast };
            with(vec![fixed, big, rod], vec![], vec![gas(0.015, 120)])
        }),
        ("three cells a side", with(vec![single("dumbbell", 0.1)], vec![], vec![gas(0.15, 5)])),
        ("too few cells for a grid", with(vec![], vec![], vec![gas(0.2, 4)])),
        (
            "a closed box of discs",
            walled(
                vec![line(Some(0.0), None), line(None, Some(0.3))],
                with(vec![], vec![], vec![gas(0.03, 120)]),
            ),
        ),
        (
            "flaps across the border, tees and discs",
            walled(
                vec![flap([0.8, 0.4], [1.3, 0.7], 0.0), flap([0.1, 0.1], [0.1, -0.3], 0.01)],
                with(vec![], vec![], vec![molecules("tee", 0.01, 12), gas(0.02, 120)]),
            ),
        ),
        (
            "dumbbells between walls",
            walled(
                vec![line(Some(0.7), None), flap([0.0, 0.5], [0.5, 0.5], 0.0)],
                with(vec![], vec![], vec![molecules("dumbbell", 0.02, 60)]),
            ),
        ),
        (
            "a wall in a box of too few cells, longer than it",
            walled(vec![flap([0.1, 0.0], [1.6, 0.2], 0.0)], with(vec![], vec![], vec![gas(0.12, 3)])),
        ),
    ]
}

/// Who touched whom, with which atoms, and when.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Touched {
    time: f64,
    bodies: [u64; 2],
    atoms: [Option<u32>; 2],
}

#[derive(Default)]
struct Contacts(Vec<Touched>);

impl Observer for Contacts {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        let [a, b] = &report.sides;
        self.0.push(Touched {
            time: report.time.to_f64(),
            bodies: [a.body.id(), b.body.id()],
            atoms: [a.atom, b.atom],
        });
    }
}

/// Chaos multiplies a rounding by the free path over the diameter at each collision of a body (ten in a dense gas, a
/// hundred and more in a dilute one), so two exact programs part after a few: the contacts are compared over one for each
/// body, from several different starts.
#[test]
fn both_schedulers_find_the_same_contacts() {
    for (name, mut scene) in scenes() {
        for seed in 0..8 {
            scene.bounds.seed = seed;
            let mut cells: With<Cells> = build(&scene, Instructions::default());
            let mut thesis: With<Thesis> = build(&scene, Fineness::Automatic);
            let wanted = cells.view().len() / 2;
            let (mut ours, mut theirs) = (Contacts::default(), Contacts::default());
            while ours.0.len() < wanted && cells.step(1e3, &mut ours).unwrap() {}
            while theirs.0.len() < wanted && thesis.step(1e3, &mut theirs).unwrap() {}
            assert_eq!(ours.0.len(), wanted, "{name}");
            for (k, (a, b)) in ours.0.iter().zip(&theirs.0).enumerate() {
                assert_eq!(Touched { time: b.time, ..*a }, *b, "{name}, seed {seed}: contact {k}");
                assert!((a.time - b.time).abs() < 1e-6 * b.time, "{name}, seed {seed}: contact {k}");
            }
        }
    }
}

#[test]
fn nothing_is_missed_by_brute_force() {
    for (name, scene) in scenes() {
        let mut cells: With<Cells> = build(&scene, Instructions::default());
        for _ in 0..60 {
            cells.check_invariants(0.05).unwrap_or_else(|violation| panic!("{name}: {violation}"));
            for _ in 0..7 {
                cells.step(1e3, &mut ()).unwrap();
            }
        }
    }
}

fn bits<S: Scheduler>(simulation: &With<S>) -> Vec<u64> {
    let numbers = simulation.view().bodies().flat_map(|view| {
        let motion = view.motion;
        let angle = motion.orientation.turns();
        [
            motion.position.x,
            motion.position.y,
            motion.velocity.x,
            motion.velocity.y,
            angle,
            motion.angular_velocity,
        ]
    });
    numbers.map(f64::to_bits).collect()
}

#[test]
fn vector_instructions_and_portable_code_give_the_same_bits() {
    for (name, scene) in scenes() {
        let mut widest: With<Cells> = build(&scene, Instructions::Widest);
        let mut portable: With<Cells> = build(&scene, Instructions::Portable);
        widest.run_until(2.0).unwrap();
        portable.run_until(2.0).unwrap();
        assert_eq!(bits(&widest), bits(&portable), "{name}");
    }
}

#[test]
fn looking_on_the_way_changes_no_bit() {
    for (name, scene) in scenes() {
        let mut straight: With<Cells> = build(&scene, Instructions::default());
        let mut stopping: With<Cells> = build(&scene, Instructions::default());
        straight.run_until(1.5).unwrap();
        for stop in 1..=97 {
            stopping.observe_until(1.5 * f64::from(stop) / 97.0, &mut Contacts::default()).unwrap();
            let _ = stopping.view().energy();
        }
        assert_eq!(bits(&straight), bits(&stopping), "{name}");
    }
}

/// Discs of one diameter in a box a hundred wide, all in one heap: their lists overflow, and nothing is lost.
#[test]
fn crowded_cells_overflow_and_miss_nothing() {
    let mut scene = Scene::default();
    for k in 0..64 {
        let (column, row) = (f64::from(k % 8), f64::from(k / 8));
        let disc = AtomSpec { at: [0.0; 2], radius: 0.001, mass: 1.0 };
        scene.molecule.push(MoleculeSpec {
            atoms: vec![disc],
            at: [0.5 + 0.0021 * column, 0.5 + 0.0021 * row],
            velocity: [0.1 * (row - 3.3), 0.1 * (3.7 - column)],
            ..MoleculeSpec::default()
        });
    }
    let mut cells: With<Cells> = build(&scene, Instructions::default());
    let mut thesis: With<Thesis> = build(&scene, Fineness::Given(1));
    let (mut ours, mut theirs) = (Contacts::default(), Contacts::default());
    for _ in 0..100 {
        cells.step(1.0, &mut ours).unwrap();
        thesis.step(1.0, &mut theirs).unwrap();
        cells.check_invariants(0.01).unwrap();
    }
    let partners = |contacts: &Contacts| contacts.0.iter().map(|contact| contact.bodies).collect::<Vec<_>>();
    assert_eq!(partners(&ours), partners(&theirs));
}

#[test]
fn a_long_run_has_no_overlap_and_keeps_its_energy() {
    for (name, scene) in scenes() {
        let mut cells: With<Cells> = build(&scene, Instructions::default());
        let before = cells.view().energy();
        for stop in 1..=40 {
            cells.run_until(0.5 * f64::from(stop)).unwrap();
            let overlaps = cells.view().overlaps();
            assert_eq!(overlaps.pairs, 0, "{name}: {overlaps:?}");
        }
        let drift = (cells.view().energy() - before).abs() / before;
        assert!(drift < 1e-12, "{name}: {drift:e}");
    }
}
