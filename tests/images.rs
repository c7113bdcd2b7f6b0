//! Contacts through given periodic images, and bodies on the borders of the box and of the cells.

use carom_engine::{CellsPerSide, HeapScheduler, MoleculeSpec, Scheduler};
use carom_kinematics::EpochTime;
use glam::DVec2;

use crate::support::{Encounters, disc, scene, simulate, test_each_scheduler};

#[test]
fn a_disc_wider_than_half_the_box_is_hit_through_both_images() {
    for cells in [
        CellsPerSide::Given(1),
        CellsPerSide::Given(2),
        CellsPerSide::Automatic,
    ] {
        check_wide::<HeapScheduler>(&cells);
    }
    check_wide::<carom_engine::CellScheduler>(&carom_engine::Instructions::Widest);
}

fn check_wide<S: Scheduler>(options: &S::Options) {
    // A disc of radius 0.3 and its own image leave a gap of 0.4 on the x axis; a disc of radius 0.1
    // moves back and forth between them, along x or along y.
    for axis in 0..2 {
        let along = |x: f64| if axis == 0 { [x, 0.25] } else { [0.25, x] };
        let motion = |v: f64| if axis == 0 { [v, 0.0] } else { [0.0, v] };
        let wide = MoleculeSpec {
            fixed: true,
            ..disc(0.3, 1.0, along(0.25), [0.0; 2])
        };
        let narrow = disc(0.1, 1.0, along(0.75), motion(1.0));
        let mut simulation = simulate::<S>(&scene(vec![wide, narrow]), options);
        let mut bounces = Encounters::since(EpochTime::ZERO);
        simulation.observe_until(4.05, &mut bounces).unwrap();
        // 0.1 to the first bounce, 0.2 between bounces.
        assert_eq!(bounces.list.len(), 20, "{bounces:?}");
        for (n, bounce) in bounces.list.iter().enumerate() {
            assert!((bounce.time - (0.1 + 0.2 * n as f64)).abs() < 1e-14);
            // The narrow disc stays in the box: the image next to the wide disc's image is its own,
            // one box back.
            let mut image = [0, 0];
            image[axis] = if n % 2 == 0 { -1 } else { 0 };
            assert_eq!(bounce.image, image, "bounce {n}");
        }

        // Both free: the relative motion is the same, at the reduced mass.
        let wide = disc(0.3, 3.0, along(0.25), motion(-0.25));
        let narrow = disc(0.1, 1.0, along(0.75), motion(0.75));
        let mut simulation = simulate::<S>(&scene(vec![wide, narrow]), options);
        let mut bounces = Encounters::since(EpochTime::ZERO);
        simulation.observe_until(4.05, &mut bounces).unwrap();
        assert_eq!(bounces.list.len(), 20);
        for (n, bounce) in bounces.list.iter().enumerate() {
            assert!((bounce.time - (0.1 + 0.2 * n as f64)).abs() < 1e-13);
        }
        assert_eq!(simulation.view().overlaps().pairs, 0);
    }
}

test_each_scheduler! {
    the_nearest_image_is_not_always_the_one_that_is_hit: check_images;
    the_borders_of_cells_do_not_affect_the_motion: check_borders;
}

#[test]
fn the_image_that_is_hit_is_found_with_any_number_of_cells() {
    for cells in 1..=4 {
        check_images::<HeapScheduler>(&CellsPerSide::Given(cells));
    }
}

fn check_images<S: Scheduler>(options: &S::Options) {
    // The target is at rest 0.3 to the left of the other disc, which moves right: its path is 0.7
    // less σ.
    let mut simulation = simulate::<S>(
        &scene(vec![
            disc(0.1, 1.0, [0.5, 0.5], [1.0, 0.0]),
            disc(0.1, 1.0, [0.2, 0.5], [0.0; 2]),
        ]),
        options,
    );
    assert!(simulation.step(10.0, &mut ()).unwrap());
    assert!((simulation.time().to_f64() - 0.5).abs() < 1e-15);

    // Through a corner: along the diagonal, from (0.75, 0.75) to the target at (0.25, 0.25).
    let speed = 0.5f64.sqrt();
    let mut simulation = simulate::<S>(
        &scene(vec![
            disc(0.1, 1.0, [0.75, 0.75], [speed, speed]),
            disc(0.1, 1.0, [0.25, 0.25], [0.0; 2]),
        ]),
        options,
    );
    let mut list = Encounters::since(EpochTime::ZERO);
    simulation.observe_until(0.6, &mut list).unwrap();
    assert_eq!(list.list.len(), 1);
    assert!((list.list[0].time - (0.5f64.sqrt() - 0.2)).abs() < 1e-15);
    // A path through two boxes before the first contact: the target is 2.5 boxes up and 1 to the
    // right.
    let target = DVec2::new(1.0, 2.5);
    let way = target.normalize();
    let mut simulation = simulate::<S>(
        &scene(vec![
            disc(0.01, 1.0, [0.5, 0.25], way.to_array()),
            disc(0.01, 1.0, [0.5, 0.75], [0.0; 2]),
        ]),
        options,
    );
    assert!(simulation.step(10.0, &mut ()).unwrap());
    assert!((simulation.time().to_f64() - (target.length() - 0.02)).abs() < 1e-14);
}

#[test]
fn the_borders_of_any_number_of_cells_do_not_affect_the_motion() {
    for cells in 1..=5 {
        check_borders::<HeapScheduler>(&CellsPerSide::Given(cells));
    }
}

fn check_borders<S: Scheduler>(options: &S::Options) {
    let last = 1.0f64.next_down();
    for x in [
        0.0,
        -0.0,
        0.25,
        1.0 / 3.0,
        0.5,
        0.2,
        0.75,
        last,
        1.0,
        -1e-17,
        -0.25,
        7.5,
    ] {
        // Along the border of cells, in both directions of both axes; the other component is 0 or
        // −0.
        for zero in [0.0, -0.0] {
            for (a, b) in [
                ([x, 0.25], [zero, 1.0]),
                ([x, 0.75], [zero, -1.0]),
                ([0.25, x], [1.0, zero]),
                ([0.75, x], [-1.0, zero]),
            ] {
                let target = if b[0] == 0.0 { [x, 0.5] } else { [0.5, x] };
                let mut simulation = simulate::<S>(
                    &scene(vec![
                        disc(0.05, 1.0, a, b),
                        disc(0.05, 1.0, target, [0.0; 2]),
                    ]),
                    options,
                );
                assert!(simulation.step(10.0, &mut ()).unwrap());
                assert!(
                    (simulation.time().to_f64() - 0.15).abs() < 1e-15,
                    "from {a:?} with {b:?}"
                );
                let view = simulation.view();
                assert_eq!(view.counters().collisions, 1);
                assert!(view.bodies().all(|body| {
                    let place = body.motion.position;
                    (0.0..1.0).contains(&place.x) && (0.0..1.0).contains(&place.y)
                }));
            }
        }
    }
    // Through the corners of cells, along the diagonal, forever.
    let mut simulation = simulate::<S>(
        &scene(vec![disc(0.05, 1.0, [0.0, 0.0], [1.0, 1.0])]),
        options,
    );
    simulation.run_until(100.0).unwrap();
    let body = simulation.view().bodies().next().unwrap();
    assert_eq!(
        body.unwrapped(&simulation.view().bounds()),
        DVec2::splat(100.0)
    );
}
