//! Tiles give the bits of the global order, for any division of the box, any window, any margin and
//! any number of threads.

use crate::{Counters, GasSpec, Scene, Simulation, TileCounters, Tiling};

/// A gas of discs of mass 1 and energy 1 at this area fraction.
fn gas(count: usize, area_fraction: f64, seed: u64) -> Scene {
    let radius = (area_fraction / (std::f64::consts::PI * count as f64)).sqrt();
    let gas = GasSpec {
        radius: Some(radius),
        mass: Some(1.0),
        energy: 1.0,
        count: Some(count),
        ..GasSpec::default()
    };
    let mut scene = Scene { gas: vec![gas], ..Scene::default() };
    scene.bounds.seed = seed;
    scene
}

/// The time in which a disc of such a gas has about this many contacts.
fn time_of(scene: &Scene, contacts: f64) -> f64 {
    let gas = &scene.gas[0];
    let (radius, count) = (gas.radius.unwrap(), gas.count.unwrap() as f64);
    let filled = count * std::f64::consts::PI * radius * radius;
    let contact_value = (1.0 - 7.0 / 16.0 * filled) / (1.0 - filled).powi(2);
    contacts / (2.0 * radius * count * contact_value * std::f64::consts::PI.sqrt())
}

/// The bits of all motions at some times, and the counters at the end.
fn run(scene: &Scene, tiling: &Tiling, times: &[f64]) -> (Vec<u64>, Counters, TileCounters) {
    let mut simulation = Simulation::new(scene).unwrap();
    simulation.set_tiling(tiling);
    let mut bits = Vec::new();
    for &time in times {
        simulation.run_until(time).unwrap();
        for body in simulation.view().bodies() {
            let motion = body.motion;
            let [[x, y], [vx, vy]] = [motion.position, motion.velocity].map(|vector| vector.to_array());
            bits.extend([x, y, vx, vy].map(f64::to_bits));
            bits.extend(body.winding.map(|boxes| boxes as u64));
        }
    }
    let counters = *simulation.view().counters();
    (bits, counters, simulation.tile_counters())
}

const SMALL: Tiling = Tiling { threads: 1, least_bodies: 1, side: 40, window: 1.0, margin: 6, front: 3.0 };

#[test]
fn tiles_give_the_bits_of_the_global_order() {
    for (count, area_fraction, window) in [(20_000, 0.5, 1.0), (20_000, 0.2, 2.0), (10_000, 0.65, 1.0)] {
        let scene = gas(count, area_fraction, 5);
        let until = time_of(&scene, 100.0);
        let (expected, counters, _) = run(&scene, &Tiling::NONE, &[until]);
        let (found, in_tiles, tiles) = run(&scene, &Tiling { window, ..SMALL }, &[until]);
        println!("{count} {area_fraction}: {tiles:?} {counters:?}");
        assert!(tiles.contacts * 10 > counters.collisions * 9, "{tiles:?}");
        assert_eq!(tiles.refused, 0);
        assert_eq!(in_tiles, counters);
        assert!(found == expected, "bits differ at area fraction {area_fraction}");
    }
}
