//! Scenes of points at independent, uniform positions, for tests.

use carom_engine::{BumperSpec, Scene};

/// Fixed discs, as good as points, at random positions in a box.
pub(crate) fn random_points(count: usize, sides: [f64; 2], seed: u64) -> Scene {
    // SplitMix64 (Steele, Lea & Flood 2014).
    let mut state = seed << 32;
    let mut uniform = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) >> 11) as f64 * f64::EPSILON * 0.5
    };
    let mut scene = Scene::default();
    scene.bounds.sides = sides;
    let places = (0..count).map(|_| [sides[0] * uniform(), sides[1] * uniform()]);
    scene.bumper = places
        .map(|at| BumperSpec {
            radius: 1e-9,
            at,
            tags: vec![],
        })
        .collect();
    scene
}
