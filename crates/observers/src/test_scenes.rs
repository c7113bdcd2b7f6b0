//! Scenes of fixed discs at given places, and a mixture, for tests.

use carom_engine::{BumperSpec, Scene};
use glam::DVec2;

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
    let places = (0..count).map(|_| DVec2::new(sides[0] * uniform(), sides[1] * uniform()));
    discs_at(sides, 1e-9, places)
}

/// Fixed discs of a radius at these places in a box.
pub(crate) fn discs_at(
    sides: [f64; 2],
    radius: f64,
    places: impl IntoIterator<Item = DVec2>,
) -> Scene {
    let bumper = |place: DVec2| BumperSpec {
        radius,
        at: place.to_array(),
        tags: vec![],
    };
    let mut scene = Scene::default();
    scene.bounds.sides = sides;
    scene.bumper = places.into_iter().map(bumper).collect();
    scene
}

/// The places of a triangular lattice at distance 1 with an even number of rows, and the sides of
/// its box.
pub(crate) fn triangular_lattice(columns: u32, rows: u32) -> ([f64; 2], Vec<DVec2>) {
    let height = 0.75_f64.sqrt();
    let place = |site: u32| {
        let [x, y] = [f64::from(site % columns), f64::from(site / columns)];
        DVec2::new(x + 0.5 * (y % 2.0) + 0.2, height * y + 0.3)
    };
    let sides = [f64::from(columns), f64::from(rows) * height];
    (sides, (0..columns * rows).map(place).collect())
}

/// Small discs in a sheared box, of the rate 0.5, that move with the flow: later their places are
/// these ones sheared.
pub(crate) fn moving_with_the_flow(sides: [f64; 2], places: &[DVec2]) -> Scene {
    let disc = |place: &DVec2| {
        let at = place.to_array();
        format!(
            "[[molecule]]\natoms = [{{ at = [0, 0], radius = 1e-6, mass = 1 }}]\nat = {at:?}\n\
             velocity = [0.0, 0.0]\n"
        )
    };
    let discs: String = places.iter().map(disc).collect();
    let text = format!("[box]\nsides = {sides:?}\nshear_rate = 0.5\n{discs}");
    Scene::from_toml(&text).unwrap()
}

/// Discs of two tags and a heavy third that drifts.
pub(crate) const MIXTURE: &str = "[box]\nsides = [1.0, 1.3]\nseed = 8\n[[gas]]\nradius = 0.03\nmass = 1.0\nenergy = 1.0\n\
                                  count = 40\ntags = [\"a\"]\n[[gas]]\nradius = 0.02\nmass = 2.0\nenergy = 1.0\ncount = 25\n\
                                  tags = [\"b\"]\n[[molecule]]\nshape = \"disc\"\natom_radius = 0.02\natom_mass = 9.0\n\
                                  at = [0.5, 0.5]\nvelocity = [3.0, 1.0]\n";
