//! Where a scene stands between the limits of the numbers.
//!
//! Each quantity grows with the difficulty of the scene. Up to `tested` all bounds hold in each run
//! of `cargo xtask experiment extremes`. Beyond `allowed` the scene is refused, or its run ends
//! with an error that names the limit.

use std::f64::consts::{PI, TAU};

use carom::{
    Scene, View,
    engine::{MAX_SPEED_RATIO, MAX_TURNS, MIN_CONTACT_SHARE, rounding_bound},
    geometry::{MAX_MAGNITUDE, MIN_MAGNITUDE},
};
use serde::Serialize;

/// Goals of the experiment `extremes`: up to here all bounds must hold.
pub mod tested {
    /// Mass of the heaviest body over that of the lightest.
    pub const MASS_RATIO: f64 = 1e12;
    /// Speed of the fastest body over that of the slowest.
    pub const SPEED_RATIO: f64 = 1e6;
    /// Radius of the largest body over that of the smallest.
    pub const SIZE_RATIO: f64 = 1e6;
    /// Turns of a rotor in the natural time of a pair.
    pub const TURNS: f64 = 1e8;
    /// Contact distance over the depth of a graze.
    pub const GRAZE: f64 = 1e14;
    /// Reach of a rotor over the depth of its sweep.
    pub const SWEEP: f64 = 1e13;
    /// Age in natural times.
    pub const AGE: f64 = 1e12;
    /// 1/(A/A₀ − 1) of discs near close packing, A₀ the area of the packed lattice.
    pub const DENSITY: f64 = 1e5;
    /// 1 / contact time of the guard against inelastic collapse.
    pub const CONTACT_TIME: f64 = 1e4;
    /// Atoms of a molecule.
    pub const ATOMS: f64 = 4096.0;
    /// Longer side of the box over the diameter of a disc.
    pub const BOX: f64 = 1e9;
}

/// Command that tests the limits.
const EXTREMES: &str = "cargo xtask experiment extremes";

/// Digits of a time: an epoch begins at a sum of two floats of 53 digits.
const DIGITS_OF_TIME: f64 = 8.1e31;

/// Contact distances over the rounding bound of a box with [`MIN_CONTACT_SHARE`].
const COARSEST_GRAZE: f64 = 0.15;

/// A quantity and its limits.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Limit {
    pub(super) quantity: &'static str,
    pub(super) value: f64,
    /// Largest value that is tested; `None` if only the other limit applies.
    pub(super) tested: Option<f64>,
    /// Largest value with which a scene runs; `None` if nothing ends the run.
    pub(super) allowed: Option<f64>,
    /// Where the limits come from.
    pub(super) origin: &'static str,
}

impl Limit {
    /// Where the value stands.
    pub(super) fn verdict(&self) -> &'static str {
        let within = |limit: Option<f64>| limit.is_none_or(|limit| self.value <= limit);
        match (within(self.tested), within(self.allowed)) {
            (true, true) => "",
            (false, true) => "UNTESTED",
            (_, false) => "BEYOND",
        }
    }
}

/// The extremes of the bodies of a scene.
#[derive(Debug, Clone, Copy)]
struct Extremes {
    /// Radii of the smallest atom or face and of the largest body that is no wall (length).
    radii: [f64; 2],
    /// Masses of bodies that move.
    masses: [f64; 2],
    /// Speeds of centres that move (length per time).
    speeds: [f64; 2],
    /// Fastest rotation (radians per time), and fastest rim or centre (length per time).
    spin: f64,
    rim: f64,
    atoms: usize,
    area: f64,
    is_equal_discs: bool,
}

impl Extremes {
    fn new(view: &View<'_>) -> Self {
        let none = [f64::INFINITY, 0.0];
        let widen = |[least, most]: [f64; 2], value: f64| [least.min(value), most.max(value)];
        let mut all = Self {
            radii: none,
            masses: none,
            speeds: none,
            spin: 0.0,
            rim: 0.0,
            atoms: 0,
            area: 0.0,
            is_equal_discs: true,
        };
        for body in view.bodies() {
            let (molecule, motion) = (body.body.molecule(), body.motion);
            if body.body.is_wall() {
                continue;
            }
            let reach = body.body.reach();
            let radii = molecule.atoms().iter().map(carom::Atom::radius);
            // The radius of the corners of a polygon is not its size.
            let smallest = if molecule.is_of_discs() {
                radii.fold(reach, f64::min)
            } else {
                molecule.mean_half_width().min(reach)
            };
            all.radii = widen(widen(all.radii, reach), smallest);
            all.atoms = all.atoms.max(molecule.atoms().len());
            all.area += molecule.area();
            all.is_equal_discs &= molecule.is_disc() && all.radii[0] == all.radii[1];
            if !body.body.is_free() {
                continue;
            }
            all.masses = widen(all.masses, molecule.mass());
            let (speed, spin) = (motion.velocity.length(), motion.angular_velocity.abs());
            if speed > 0.0 {
                all.speeds = widen(all.speeds, speed);
            }
            if !molecule.is_round() {
                all.spin = all.spin.max(spin);
            }
            all.rim = all.rim.max(speed + spin * reach);
        }
        all
    }
}

/// The quantities of a scene that are limited.
pub(super) fn limits(scene: &Scene, view: &View<'_>) -> Vec<Limit> {
    let all = Extremes::new(view);
    let sides = view.bounds().sides();
    if all.radii[1] == 0.0 {
        return Vec::new();
    }
    let mut rows = Vec::from(of_sizes(all.radii, sides));
    rows.extend(of_motions(&all, scene.run.until, sides.min_element()));
    if all.masses[1] > all.masses[0] {
        let ratio = all.masses[1] / all.masses[0];
        rows.push(limit(
            "mass ratio",
            ratio,
            tested::MASS_RATIO,
            MAX_MAGNITUDE / MIN_MAGNITUDE,
            "geometry/src/limits.rs",
        ));
    }
    rows.push(density(&all, view));
    if all.atoms > 1 {
        rows.push(limit(
            "atoms of a molecule",
            all.atoms as f64,
            tested::ATOMS,
            None,
            EXTREMES,
        ));
    }
    if scene.elasticity.least_coefficient() < 1.0 {
        let inverse = 1.0 / scene.elasticity.contact_time;
        rows.push(limit(
            "1 / contact time of the guard",
            inverse,
            tested::CONTACT_TIME,
            None,
            "engine/src/contact/guard.rs",
        ));
    }
    rows
}

/// The limits that follow from the smallest and the largest radius, and from the sides of the box
/// (length).
fn of_sizes([small, large]: [f64; 2], sides: glam::DVec2) -> [Limit; 4] {
    let (side, shorter) = (sides.max_element(), sides.min_element());
    let contact = 2.0 * small;
    [
        limit(
            "size ratio",
            large / small,
            tested::SIZE_RATIO,
            1.0 / MIN_CONTACT_SHARE,
            GRID,
        ),
        limit(
            "box over smallest contact distance",
            side / contact,
            tested::BOX,
            1.0 / MIN_CONTACT_SHARE,
            GRID,
        ),
        limit(
            "largest diameter over shorter side",
            2.0 * large / shorter,
            None,
            1.0,
            GRID,
        ),
        limit(
            "rounding over smallest contact distance (grazes)",
            rounding_bound(sides, 2.0 * large) / contact,
            rounding_bound(glam::DVec2::ONE, 0.0) * tested::BOX,
            COARSEST_GRAZE,
            "engine/src/world/rounding_bound.rs",
        ),
    ]
}

/// The limits that follow from the motions, up to the end of the run (time), in a box whose shorter
/// side is this (length).
fn of_motions(all: &Extremes, until: f64, shorter: f64) -> Vec<Limit> {
    let mut rows = Vec::new();
    let fastest = all.speeds[1].max(all.rim);
    if fastest > 0.0 {
        let natural_times = until * fastest / all.radii[0];
        rows.push(limit(
            "age in natural times",
            natural_times,
            tested::AGE,
            DIGITS_OF_TIME,
            "kinematics/src/epoch_time.rs",
        ));
    }
    if all.speeds[1] > 0.0 {
        let ratio = all.speeds[1] / all.speeds[0];
        rows.push(limit(
            "speed ratio",
            ratio,
            tested::SPEED_RATIO,
            MAX_SPEED_RATIO,
            "engine/src/contact/limits.rs",
        ));
        if all.spin > 0.0 {
            let turns = all.spin / TAU * shorter / all.speeds[0];
            rows.push(limit(
                "turns while the slowest crosses the box",
                turns,
                tested::TURNS,
                MAX_TURNS,
                "engine/src/contact/limits.rs",
            ));
        }
    }
    rows
}

const GRID: &str = "engine/src/grid.rs";

fn limit(
    quantity: &'static str,
    value: f64,
    tested: impl Into<Option<f64>>,
    allowed: impl Into<Option<f64>>,
    origin: &'static str,
) -> Limit {
    Limit {
        quantity,
        value,
        tested: tested.into(),
        allowed: allowed.into(),
        origin,
    }
}

/// The area fraction, up to the packing of equal discs on a triangular lattice, or up to 1.
fn density(all: &Extremes, view: &View<'_>) -> Limit {
    let value = all.area / view.bounds().area();
    if all.is_equal_discs {
        let packed = PI / 12.0f64.sqrt();
        let tested = packed / (1.0 + 1.0 / tested::DENSITY);
        limit(
            "area fraction of equal discs",
            value,
            tested,
            packed,
            "packing π/√12",
        )
    } else {
        limit(
            "area fraction",
            value,
            None,
            1.0,
            "dense starts jam earlier: engine/src/growth",
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_methods::AnySimulation;

    fn rows(text: &str) -> Vec<Limit> {
        let scene = Scene::from_toml(text).unwrap();
        limits(&scene, &AnySimulation::new(&scene).unwrap().view())
    }

    fn value(rows: &[Limit], quantity: &str) -> f64 {
        rows.iter()
            .find(|row| row.quantity == quantity)
            .unwrap()
            .value
    }

    #[test]
    fn ratios_are_those_of_the_extremes() {
        let disc = |radius: f64, mass: f64, at: [f64; 2], speed: f64| {
            format!(
                "[[molecule]]\natoms = [{{ at = [0, 0], radius = {radius}, mass = {mass} }}]\nat = {at:?}\n\
                 velocity = [{speed:?}, 0.0]\n"
            )
        };
        let found = rows(
            &(disc(0.1, 1e3, [0.3, 0.3], 0.5)
                + &disc(0.001, 1.0, [0.6, 0.6], 20.0)
                + "[run]\nuntil = 10.0\n"),
        );
        let near = |quantity: &str, expected: f64| {
            let value = value(&found, quantity);
            assert!(
                (value / expected - 1.0).abs() < 1e-12,
                "{quantity}: {value}, {expected}"
            );
        };
        near("size ratio", 100.0);
        near("mass ratio", 1e3);
        near("speed ratio", 40.0);
        near("box over smallest contact distance", 500.0);
        near("largest diameter over shorter side", 0.2);
        // 10 · 2 · 20 / 0.002
        near("age in natural times", 2e5);
        near("area fraction", PI * 0.010_001);
        assert!(
            found.iter().all(|row| row.verdict().is_empty()),
            "{found:?}"
        );
    }

    #[test]
    fn what_is_untested_or_beyond_is_marked() {
        let row = limit("x", 10.0, 5.0, 100.0, "");
        assert_eq!(row.verdict(), "UNTESTED");
        assert_eq!(
            Limit {
                value: 1000.0,
                ..row.clone()
            }
            .verdict(),
            "BEYOND"
        );
        assert_eq!(
            Limit {
                tested: None,
                allowed: None,
                ..row
            }
            .verdict(),
            ""
        );
        // A turn a microsecond, a box a year.
        let tee = "[[molecule]]\nshape = \"tee\"\natom_radius = 0.02\natom_mass = 1.0\nat = [0.5, 0.5]\n\
                   velocity = [1e-3, 0.0]\nangular_velocity = 6.3e6\n";
        let found = rows(tee);
        let turns = found
            .iter()
            .find(|row| row.quantity.starts_with("turns"))
            .unwrap();
        assert!(
            (turns.value / 1e9 - 1.0).abs() < 0.01 && turns.verdict() == "UNTESTED",
            "{turns:?}"
        );
        assert_eq!(value(&found, "atoms of a molecule"), 5.0);
    }
}
