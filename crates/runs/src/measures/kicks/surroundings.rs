//! What surrounds a body at the start of a measurement: one gas of equal discs, for which kinetic
//! theory predicts the kicks, or any mixture, for which it has no prediction here.

use std::f64::consts::PI;

use carom::{
    BodyKey, View,
    engine::{Body, BodyView},
    geometry::ExcludedRegion,
};
use glam::DVec2;
use serde::{Deserialize, Serialize};

/// Above this share of the thermal speed the bodies drift as a whole; a smaller one is rounding.
const RESTS: f64 = 1e-9;

/// The bodies around one body, and the momentum of all.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Surroundings {
    /// Radius of the smallest disc that can touch the body: of a gas disc, or of the smallest atom
    /// of all other bodies that move (length).
    pub(super) probe: f64,
    /// Radius of a disc of the mean area, and mean mass, of the other bodies that move.
    pub(super) mean: [f64; 2],
    /// Their number.
    pub(super) count: usize,
    /// Whether they are equal discs, none of which is in a pocket of the body.
    pub(super) is_one_gas: bool,
    /// Radii of fixed discs (length); `None` if another body or a wall is fixed.
    pub(super) bumpers: Option<Vec<f64>>,
    /// Area of the box (length²).
    pub(super) area: f64,
    /// kT of all bodies (mass × length² / time²).
    pub(super) temperature: f64,
    /// The shares of kT that the body has along x′ and along y′: 1, or less where momentum is
    /// conserved.
    pub(super) thermal_shares: [f64; 2],
    /// Whether the momentum is 0 along each axis on which it is conserved.
    pub(super) rests: bool,
}

impl Surroundings {
    /// The surroundings of a body; `None` if nothing else moves, or if there is no temperature.
    pub(super) fn new(view: &View<'_>, key: BodyKey) -> Option<Self> {
        let body = view.body(key)?;
        let others = || view.bodies().filter(|other| other.body.key() != key);
        let moving = || {
            others()
                .filter(|other| other.body.is_free())
                .map(|other| other.body)
        };
        let first = moving().next()?;
        let count = moving().count();
        let mean = |of: fn(&Body) -> f64| moving().map(of).sum::<f64>() / count as f64;
        let is_equal = |other: &Body| {
            let (one, other) = (first.molecule(), other.molecule());
            other.is_disc()
                && other.bounding_radius() == one.bounding_radius()
                && other.mass() == one.mass()
        };
        let atoms = moving().flat_map(|other| other.molecule().atoms());
        let temperature = view.temperature().filter(|kt| *kt > 0.0)?;
        let frame = view.centre_of_mass_frame();
        let all: f64 = moving().chain([body.body]).map(mass).sum();
        let thermal = (temperature / all).sqrt();
        Some(Self {
            probe: atoms
                .map(carom::geometry::Atom::radius)
                .fold(f64::INFINITY, f64::min),
            mean: [
                (mean(|body| body.molecule().area()) / PI).sqrt(),
                mean(mass),
            ],
            count,
            is_one_gas: moving().all(is_equal)
                && view.bonds().len() == 0
                && !view.has_pair_rules()
                && !has_full_pocket(view, &body, first),
            bumpers: others()
                .filter(|other| other.body.is_fixed())
                .map(bumper)
                .collect(),
            area: view.bounds().area(),
            temperature,
            thermal_shares: thermal_shares(
                &body,
                frame.conserves_momentum(),
                mass(body.body) / all,
            )
            .into(),
            rests: frame.velocity().length() <= RESTS * thermal * (count as f64).sqrt(),
        })
    }

    /// Bodies that move around the body, per area of the box (1 / length²).
    pub(super) fn density(&self) -> f64 {
        self.count as f64 / self.area
    }

    /// Whether one gas of equal discs has the whole box, except for the body and fixed discs: the
    /// predictions of rates hold then.
    pub(super) fn is_open(&self) -> bool {
        self.is_one_gas && self.bumpers.is_some()
    }
}

/// Whether a disc like `disc` is in a pocket of the body, such as the hole of a ring, which it
/// could never leave.
fn has_full_pocket(view: &View<'_>, body: &BodyView<'_>, disc: &Body) -> bool {
    let (molecule, radius) = (body.body.molecule(), disc.molecule().bounding_radius());
    let Ok(region) = ExcludedRegion::new(molecule, radius) else {
        return false;
    };
    if !region.has_pockets() {
        return false;
    }
    // Turns the frame of the box into that of the body.
    let turn = body.motion.orientation.cos_sin() * DVec2::new(1.0, -1.0);
    view.bodies()
        .filter(|other| other.body.is_free() && other.body.key() != body.body.key())
        .any(|other| {
            let apart = view
                .bounds()
                .nearest_image(other.motion.position - body.motion.position);
            region.contains(turn.rotate(apart))
        })
}

fn mass(body: &Body) -> f64 {
    if body.is_fixed() {
        0.0
    } else {
        body.molecule().mass()
    }
}

/// The radius of a fixed disc.
fn bumper(other: BodyView<'_>) -> Option<f64> {
    let molecule = other.body.molecule();
    (!other.body.is_wall() && molecule.is_disc()).then(|| molecule.bounding_radius())
}

/// The shares of kT that a body with this part of the mass of all bodies has along x′ and along y′.
///
/// Of N bodies of total mass m whose momentum along an axis is conserved, one of mass M has ⟨M v²⟩
/// = kT (1 − M/m) along it, since its velocity is that relative to the centre of mass of all.
fn thermal_shares(body: &BodyView<'_>, conserved: [bool; 2], part: f64) -> DVec2 {
    let [x, y] = conserved.map(|conserved| if conserved { part } else { 0.0 });
    if body.body.can_turn() {
        // All orientations are equally frequent.
        return DVec2::splat(1.0 - 0.5 * (x + y));
    }
    let along = body.motion.orientation.cos_sin();
    let squares = along * along;
    DVec2::new(
        1.0 - squares.x * x - squares.y * y,
        1.0 - squares.y * x - squares.x * y,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::Scene;
    use carom_methods::AnySimulation;

    const TEE: &str =
        "[[molecule]]\nshape = \"tee\"\natom_radius = 0.02\natom_mass = 1.0\nat = [0.5, 0.5]\n";
    const GAS: &str = "[[gas]]\nradius = 0.03\nmass = 2.0\nenergy = 1.0\ncount = 40\n";

    /// The surroundings of the tee.
    fn of(text: &str) -> Option<Surroundings> {
        let scene = Scene::from_toml(text).unwrap();
        let simulation = AnySimulation::new(&scene).unwrap();
        let view = simulation.view();
        let is_tee = |body: &BodyView<'_>| body.body.molecule().atoms().len() == 5;
        let tee = view.bodies().find(is_tee).unwrap().body.key();
        Surroundings::new(&view, tee)
    }

    #[test]
    fn one_gas_of_equal_discs_is_told_from_mixtures() {
        let one = of(&format!("{TEE}{GAS}")).unwrap();
        assert!(one.is_one_gas && one.is_open() && one.probe == 0.03 && one.count == 40);
        assert!((one.mean[0] - 0.03).abs() < 1e-15 && one.mean[1] == 2.0);
        let two = "[[gas]]\nradius = 0.01\nmass = 0.5\nenergy = 1.0\ncount = 40\n";
        let two = of(&format!("{TEE}{GAS}{two}")).unwrap();
        assert!(!two.is_one_gas && two.probe == 0.01 && two.count == 80);
        assert!((two.mean[0] - 5f64.sqrt() * 0.01).abs() < 1e-15 && two.mean[1] == 1.25);
        let rod = "[[molecule]]\nshape = \"rod:3\"\natom_radius = 0.004\natom_mass = 1.0\nat = [0.1, 0.1]\n";
        let with_rod = of(&format!("{TEE}{rod}{GAS}")).unwrap();
        assert!(!with_rod.is_one_gas && with_rod.probe == 0.004);
        let drawn =
            "[[gas]]\nradius = { uniform = [0.01, 0.03] }\nmass = 1.0\nenergy = 1.0\ncount = 40\n";
        assert!(!of(&format!("{TEE}{drawn}")).unwrap().is_one_gas);
        assert_eq!(of(TEE), None, "nothing else moves");
    }

    #[test]
    fn discs_in_a_pocket_have_no_prediction() {
        let ring = "[[molecule]]\nshape = \"ring:20\"\natom_radius = 0.02\natom_mass = 1.0\nat = [0.5, 0.5]\n";
        let gas = "[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\narea_fraction = 0.2\n";
        let of = |start: &str| {
            let scene = Scene::from_toml(&format!("{start}{ring}{gas}")).unwrap();
            let simulation = AnySimulation::new(&scene).unwrap();
            let view = simulation.view();
            let body = view.bodies().next().unwrap().body.key();
            Surroundings::new(&view, body).unwrap().is_one_gas
        };
        assert_eq!(
            [of(""), of("[start]\nempty_pockets = true\n")],
            [false, true]
        );
    }

    #[test]
    fn fixed_discs_leave_the_box_open_and_other_fixed_bodies_do_not() {
        let bumper = "[[bumper]]\nradius = 0.01\nat = [0.1, 0.1]\n";
        let found = of(&format!("{TEE}{bumper}{GAS}")).unwrap();
        assert_eq!((found.is_open(), found.bumpers), (true, Some(vec![0.01])));
        let wall = "[[wall]]\nx = 0.0\n";
        assert!(!of(&format!("{TEE}{wall}{GAS}")).unwrap().is_open());
    }

    #[test]
    fn the_share_of_kt_follows_the_axes_without_fixed_bodies() {
        // A tee of mass 5 among discs of mass 80.
        let part = 5.0 / 85.0;
        let shares = |extra: &str, more: &str| {
            let found = of(&format!("{TEE}{more}{extra}{GAS}")).unwrap();
            DVec2::from(found.thermal_shares)
        };
        let close = |found: DVec2, expected: [f64; 2]| found.distance(expected.into()) < 1e-15;
        let (bumper, wall) = (
            "[[bumper]]\nradius = 0.01\nat = [0.1, 0.1]\n",
            "[[wall]]\nx = 0.0\n",
        );
        assert!(close(shares(bumper, ""), [1.0; 2]));
        assert!(close(shares("", ""), [1.0 - part; 2]));
        assert!(close(shares(wall, ""), [1.0 - 0.5 * part; 2]));
        assert!(close(
            shares(wall, "rotation = \"locked\"\n"),
            [1.0, 1.0 - part]
        ));
        let turned = "rotation = \"locked\"\norientation_turns = 0.25\n";
        assert!(close(shares(wall, turned), [1.0 - part, 1.0]));
    }

    #[test]
    fn a_drift_of_all_bodies_is_seen_only_where_nothing_stops_it() {
        let wind = format!("{TEE}velocity = [0.0, 1.0]\n");
        assert!(of(&format!("{TEE}{GAS}")).unwrap().rests);
        assert!(!of(&format!("{wind}{GAS}")).unwrap().rests);
        assert!(
            of(&format!(
                "{wind}[[bumper]]\nradius = 0.01\nat = [0.1, 0.1]\n{GAS}"
            ))
            .unwrap()
            .rests
        );
        assert!(
            of(&format!("{wind}[[wall]]\ny = 0.0\n{GAS}"))
                .unwrap()
                .rests
        );
    }
}
