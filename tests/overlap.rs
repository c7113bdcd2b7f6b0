//! No pair overlaps by more than rounding: a hundred thousand collisions of the tee in its gas.

use crate::support::{bumper, gas, named, scene, simulate};
use carom_engine::{
    CellScheduler, CellsPerSide, CollisionReport, HeapScheduler, Instructions, Observer, Scene,
    Scheduler,
};

/// Counts the collisions of the body inserted first.
#[derive(Default)]
struct OfTheFirst(u64);

impl Observer for OfTheFirst {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.0 += u64::from(report.sides[0].body.id() == 0);
    }
}

/// The gas of Montanari (2017), chapter 3: discs of radius 0.01 that cover half the box, with a tee
/// of atoms of radius 0.005 and mass 2, and a bumper.
fn thesis_scene(side: f64) -> Scene {
    let mut scene = scene(vec![named("tee", 0.005, 2.0, [0.5 * side, 0.5 * side])]);
    scene.bounds.sides = [side, side];
    scene.bumper = vec![bumper(0.0025, [0.25 * side, 0.25 * side])];
    scene.gas = vec![gas("disc", 0.01, 1)];
    (scene.gas[0].count, scene.gas[0].area_fraction) = (None, Some(0.5));
    scene
}

/// Runs until the tee has had `collisions` collisions, and checks the overlaps a hundred times.
fn run_the_tee<S: Scheduler>(scene: &Scene, collisions: u64, options: &S::Options) {
    let mut simulation = simulate::<S>(scene, options);
    let mut tee = OfTheFirst::default();
    let mut time = 0.0;
    let mut deepest = 0.0f64;
    while tee.0 < collisions {
        let goal = tee.0 + collisions.div_ceil(100);
        while tee.0 < goal {
            time += 0.01;
            simulation.observe_until(time, &mut tee).unwrap();
        }
        let census = simulation.view().overlaps();
        assert_eq!(
            census.pairs, 0,
            "after {} collisions of the tee: {census:?}",
            tee.0
        );
        deepest = deepest.max(census.deepest_length);
    }
    // Rounding of positions in the box; a missed contact gives overlaps a hundred million times as
    // deep.
    assert!(
        deepest < 4e-15 * scene.bounds.sides[0].max(0.25),
        "{deepest:e}"
    );
    let view = simulation.view();
    assert!((view.energy() / view.ledger().initial - 1.0).abs() < 1e-11);
    assert_eq!(view.counters().scheduler.unresolved, 0);
}

#[test]
fn no_body_overlaps_the_tee_in_its_gas() {
    // A quarter of the side of the thesis's box, at the same densities: the tee has a larger share
    // of the collisions.
    run_the_tee::<CellScheduler>(&thesis_scene(0.25), 100_000, &Instructions::Widest);
}

#[test]
fn no_body_overlaps_the_tee_in_its_gas_with_the_heap_scheduler() {
    run_the_tee::<HeapScheduler>(&thesis_scene(0.25), 5_000, &CellsPerSide::Automatic);
}

#[test]
fn no_bodies_overlap_in_the_scene_of_the_thesis() {
    // A hundred thousand collisions of all bodies, of which some hundred are the tee's.
    let mut simulation = simulate::<CellScheduler>(&thesis_scene(1.0), &Instructions::Widest);
    assert_eq!(simulation.view().len(), 1592 + 2);
    let mut time = 0.0;
    while simulation.view().counters().collisions < 100_000 {
        time += 0.01;
        simulation.run_until(time).unwrap();
        let census = simulation.view().overlaps();
        assert_eq!(census.pairs, 0, "at {time}: {census:?}");
    }
}

/// Regression test: prefetching used the cell of a body that is listed in no single cell.
#[test]
fn a_molecule_among_so_many_discs_that_cells_are_prefetched_overlaps_none() {
    let mut scene = scene(vec![named("tee", 0.005, 2.0, [0.5, 0.5])]);
    scene.gas = vec![gas("disc", 0.0017, 33_000)];
    let mut simulation = simulate::<CellScheduler>(&scene, &Instructions::Widest);
    let mut tee = OfTheFirst::default();
    let mut time = 0.0;
    while tee.0 < 100 {
        time += 1e-4;
        simulation.observe_until(time, &mut tee).unwrap();
    }
    assert!(simulation.view().counters().collisions > 10_000);
    assert_eq!(simulation.view().overlaps().pairs, 0);
}
