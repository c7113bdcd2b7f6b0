//! The fast scheduler in every kind of scene: crowded cells, long runs.

#[path = "support/engine.rs"]
mod support;

use carom_engine::{Cells, Fineness, Instructions, MoleculeSpec, Thesis};
use carom_kinematics::Instant;
use support::{Encounters, disc, named, scene, scenes, simulate};

/// Discs of one diameter in a box a hundred wide, all in one heap: their lists grow long, and nothing is lost.
#[test]
fn crowded_cells_have_long_lists_and_miss_nothing() {
    check_heap(|at, velocity| disc(0.001, 1.0, at, velocity));
}

#[test]
fn cells_crowded_with_molecules_do_so_too() {
    check_heap(|at, velocity| MoleculeSpec { velocity, ..named("dumbbell", 0.0005, 1.0, at) });
}

fn check_heap(body: impl Fn([f64; 2], [f64; 2]) -> MoleculeSpec) {
    let heap = (0..64).map(|k| {
        let (column, row) = (f64::from(k % 8), f64::from(k / 8));
        let at = [0.5 + 0.0021 * column, 0.5 + 0.0021 * row];
        body(at, [0.1 * (row - 3.3), 0.1 * (3.7 - column)])
    });
    let heap = scene(heap.collect());
    let mut cells = simulate::<Cells>(&heap, &Instructions::Widest);
    let mut thesis = simulate::<Thesis>(&heap, &Fineness::Given(1));
    let (mut ours, mut theirs) = (Encounters::since(Instant::ZERO), Encounters::since(Instant::ZERO));
    for _ in 0..100 {
        cells.step(1.0, &mut ours).unwrap();
        thesis.step(1.0, &mut theirs).unwrap();
        cells.check_invariants(0.01).unwrap();
    }
    let partners =
        |contacts: &Encounters| contacts.list.iter().map(|contact| contact.bodies).collect::<Vec<_>>();
    assert_eq!(partners(&ours), partners(&theirs));
}

#[test]
fn a_long_run_has_no_overlap_and_keeps_its_energy() {
    for (name, scene) in scenes() {
        let mut cells = simulate::<Cells>(&scene, &Instructions::Widest);
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
