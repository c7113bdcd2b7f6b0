//! `CellScheduler` in all kinds of scenes: crowded cells, long runs.

use crate::support::{Encounters, disc, named, scene, scenes, simulate, test_each_instruction_set};
use carom_engine::{
    CellScheduler, CellsPerSide, HeapScheduler, Instructions, MoleculeSpec, Scheduler,
};
use carom_kinematics::EpochTime;

test_each_instruction_set! {
    /// Discs in one heap, in a box a hundred diameters wide: the lists of the cells grow long, and
    /// no contact is missed.
    crowded_cells_with_long_lists_miss_no_contact: check_heap_of_discs;
    cells_crowded_with_molecules_miss_no_contact: check_heap_of_molecules;
    a_long_run_has_no_overlap_and_conserves_its_energy: check_long_run_of_cells;
}

/// A quarter of the length of the runs with `CellScheduler`, which is several times as fast.
#[test]
fn a_long_run_of_the_heap_scheduler_has_no_overlap_and_conserves_its_energy() {
    check_long_run::<HeapScheduler>(&CellsPerSide::Automatic, 10);
}

fn check_long_run_of_cells(instructions: Instructions) {
    check_long_run::<CellScheduler>(&instructions, 40);
}

fn check_heap_of_discs(instructions: Instructions) {
    check_heap(instructions, |at, velocity| disc(0.001, 1.0, at, velocity));
}

fn check_heap_of_molecules(instructions: Instructions) {
    check_heap(instructions, |at, velocity| MoleculeSpec {
        velocity,
        ..named("dumbbell", 0.0005, 1.0, at)
    });
}

fn check_heap(instructions: Instructions, body: impl Fn([f64; 2], [f64; 2]) -> MoleculeSpec) {
    let heap = (0..64).map(|k| {
        let (column, row) = (f64::from(k % 8), f64::from(k / 8));
        let at = [0.5 + 0.0021 * column, 0.5 + 0.0021 * row];
        body(at, [0.1 * (row - 3.3), 0.1 * (3.7 - column)])
    });
    let heap = scene(heap.collect());
    let mut cells = simulate::<CellScheduler>(&heap, &instructions);
    let mut thesis = simulate::<HeapScheduler>(&heap, &CellsPerSide::Given(1));
    let (mut ours, mut theirs) = (
        Encounters::since(EpochTime::ZERO),
        Encounters::since(EpochTime::ZERO),
    );
    for _ in 0..100 {
        cells.step(1.0, &mut ours).unwrap();
        thesis.step(1.0, &mut theirs).unwrap();
        cells.check_invariants(0.01).unwrap();
    }
    let partners = |contacts: &Encounters| {
        contacts
            .list
            .iter()
            .map(|contact| contact.bodies)
            .collect::<Vec<_>>()
    };
    assert_eq!(partners(&ours), partners(&theirs));
}

fn check_long_run<S: Scheduler>(options: &S::Options, stops: u32) {
    for (name, scene) in scenes() {
        let mut simulation = simulate::<S>(&scene, options);
        let before = simulation.view().energy();
        for stop in 1..=stops {
            simulation.run_until(0.5 * f64::from(stop)).unwrap();
            let overlaps = simulation.view().overlaps();
            assert_eq!(overlaps.pairs, 0, "{name}: {overlaps:?}");
        }
        let drift = (simulation.view().energy() - before).abs() / before;
        assert!(drift < 1e-12, "{name}: {drift:e}");
    }
}
