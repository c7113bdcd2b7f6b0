//! The grid misses no contact: for any number of cells per side, and with `CellScheduler`, the
//! collisions are those of all pairs.

use crate::support::{
    Encounters, bumper, frozen, gas, named, reference_scene, scene, scenes, simulate,
};
use carom_engine::{
    CellScheduler, CellsPerSide, HeapScheduler, Instructions, MoleculeSpec, Rotation, Scene,
    Scheduler,
};

/// Collisions per body in one slice, and the number of slices.
///
/// A difference by rounding grows about tenfold with each collision of a body, a hundredfold and
/// more in a dilute gas, so that two exact runs separate after about fifteen collisions, or fewer.
/// Both runs start each slice from the same state, which makes all collisions of the run
/// comparable.
const DENSE: [usize; 2] = [4, 5];
const DILUTE: [usize; 2] = [1, 8];

/// Compares the first collisions of each body with those from all pairs in all images.
fn compare<S: Scheduler>(
    name: &str,
    start: &Scene,
    [per_body, slices]: [usize; 2],
    options: &S::Options,
) {
    let mut start = start.clone();
    for slice in 0..slices {
        let mut under_test = simulate::<S>(&start, options);
        // Both start from the same floating-point numbers: a gas is placed once.
        let wall = start.wall.clone();
        start = Scene {
            wall: wall.clone(),
            ..frozen(&under_test.view())
        };
        under_test = simulate::<S>(&start, options);
        let mut all_pairs = simulate::<HeapScheduler>(&start, &CellsPerSide::Given(1));
        let bodies = start.molecule.len();
        let contacts = per_body * start.molecule.iter().filter(|body| !body.fixed).count() / 2;
        let mut found = Encounters::since(under_test.time());
        let mut expected = Encounters::since(all_pairs.time());
        for _ in 0..contacts {
            assert!(
                under_test.step(1e3, &mut found).unwrap()
                    && all_pairs.step(1e3, &mut expected).unwrap()
            );
        }
        let unit = expected.list.last().expect("there are contacts").time;
        for body in 0..bodies as u64 {
            let pairs: Vec<_> = found.of(body).zip(expected.of(body)).collect();
            // The two lists end at slightly different times: one may contain one contact more.
            assert!(found.of(body).count().abs_diff(expected.of(body).count()) <= 1);
            for (found, expected) in pairs {
                assert_eq!(
                    found.bodies, expected.bodies,
                    "{name}, slice {slice}: {found:?}, {expected:?}"
                );
                assert_eq!(
                    found.atoms, expected.atoms,
                    "{name}, slice {slice}: {found:?}, {expected:?}"
                );
                assert!(
                    (found.time - expected.time).abs() < 1e-6 * unit,
                    "{name}, slice {slice}: {found:?}, {expected:?}"
                );
            }
        }
        let census = under_test.view().overlaps();
        assert_eq!(census.pairs, 0, "{name}, slice {slice}: {census:?}");
        start = Scene {
            wall,
            ..frozen(&under_test.view())
        };
    }
}

fn compare_with_each(name: &str, start: &Scene, finenesses: &[u32]) {
    for &cells in finenesses {
        compare::<HeapScheduler>(
            &format!("{name}, {cells} cells per side"),
            start,
            DENSE,
            &CellsPerSide::Given(cells),
        );
    }
    compare::<HeapScheduler>(
        &format!("{name}, automatic cells per side"),
        start,
        DENSE,
        &CellsPerSide::Automatic,
    );
    compare::<CellScheduler>(
        &format!("{name}, fast"),
        start,
        DENSE,
        &Instructions::Widest,
    );
}

#[test]
fn discs() {
    let start = Scene {
        gas: vec![gas("disc", 0.03, 120)],
        ..Scene::default()
    };
    compare_with_each("discs", &start, &[1, 2, 3, 4, 5, 8, 16]);
}

#[test]
fn a_few_discs_as_large_as_the_grid_allows_miss_no_contact() {
    // The sum of radii is 0.2: five cells per side are as wide as the contact distance, to the bit.
    let start = Scene {
        gas: vec![gas("disc", 0.1, 14)],
        ..Scene::default()
    };
    compare_with_each("large discs", &start, &[1, 2, 3, 4, 5]);
    // Contact distance 0.48: at most two cells per side, and pairs touch through more than one
    // image.
    let start = Scene {
        gas: vec![gas("disc", 0.24, 3), gas("disc", 0.03, 6)],
        ..Scene::default()
    };
    compare_with_each("very large discs", &start, &[1, 2]);
}

#[test]
fn mixtures() {
    let start = Scene {
        gas: vec![gas("disc", 0.09, 6), gas("disc", 0.02, 90)],
        ..Scene::default()
    };
    compare_with_each("mixture", &start, &[1, 2, 3, 4, 5]);
    let mut start = Scene {
        gas: vec![gas("disc", 0.15, 1), gas("disc", 0.015, 150)],
        ..Scene::default()
    };
    start.gas[0].atom_mass = Some(50.0.into());
    compare_with_each("one big disc", &start, &[2, 3]);
}

#[test]
fn dumbbells_and_tees() {
    let start = Scene {
        gas: vec![gas("dumbbell", 0.025, 60)],
        ..Scene::default()
    };
    compare_with_each("dumbbells", &start, &[1, 2, 3, 4, 5, 9]);
    let start = Scene {
        gas: vec![gas("tee", 0.015, 8), gas("disc", 0.02, 80)],
        ..Scene::default()
    };
    compare_with_each("tees", &start, &[1, 2, 3, 5]);
}

#[test]
fn bumpers_and_fixed_and_locked_molecules_miss_no_contact() {
    compare_with_each("reference_scene", &reference_scene(8), &[1, 2, 3, 4, 5]);
    // Bumpers at the corner and on the borders, where all images of them are hit.
    let mut start = scene(vec![MoleculeSpec {
        rotation: Rotation::Locked,
        velocity: [0.7, 0.4],
        ..named("tee", 0.02, 1.0, [0.5, 0.5])
    }]);
    start.bumper = vec![
        bumper(0.1, [0.0, 0.0]),
        bumper(0.05, [0.5, 0.0]),
        bumper(0.05, [0.0, 0.5]),
    ];
    start.gas = vec![gas("disc", 0.02, 60)];
    compare_with_each("corner", &start, &[1, 2, 3, 4, 5]);
}

#[test]
fn a_long_molecule_in_a_narrow_box_misses_no_contact() {
    let mut start = scene(vec![MoleculeSpec {
        angular_velocity: 2.0,
        ..named("rod:12", 0.01, 1.0, [0.5, 0.25])
    }]);
    start.bounds.sides = [1.0, 0.4];
    start.gas = vec![gas("disc", 0.015, 80)];
    compare_with_each("rod", &start, &[1, 2]);
}

#[test]
fn all_kinds_of_scenes_miss_no_contact() {
    for (name, start) in scenes() {
        compare::<HeapScheduler>(
            &format!("{name}, automatic cells per side"),
            &start,
            DILUTE,
            &CellsPerSide::Automatic,
        );
        compare::<CellScheduler>(
            &format!("{name}, fast"),
            &start,
            DILUTE,
            &Instructions::Widest,
        );
    }
}
