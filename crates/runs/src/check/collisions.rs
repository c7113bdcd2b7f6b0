//! The number of collisions that theory expects of a run.
//!
//! Bodies i and j collide at the rate N_i N_j L_ij g_ij √(kT/2πμ) / A. L_ij is the perimeter of
//! the region from which one excludes the centre of the other, 2πσ for discs; μ is their reduced
//! mass. For hard discs this is Enskog's theory, with the contact value g_ij of a mixture. A
//! molecule counts as its convex hull, of mean width d and perimeter πd, and its contacts as if all
//! orientations were equally likely: an estimate. So are the contacts with walls, at which the
//! density is that of the bulk times βp/n.

use std::{
    collections::HashMap,
    f64::consts::{PI, TAU},
};

use carom::{Molecule, Scene, View, engine::BodyView, kinematics::DragClock};
use glam::DVec2;
use serde::Serialize;

use crate::{
    measures::{DiscMixture, ENSKOG},
    schedule::stages,
};

/// Most kinds of bodies between which pairs are summed; more are joined in groups of similar size.
const MAX_KINDS: usize = 48;

/// Directions in which the hull of a molecule is computed.
const DIRECTIONS: usize = 360;

/// Above this area fraction discs freeze, and the theory of the fluid is an estimate.
const DENSEST_FLUID: f64 = 0.65;

/// With fewer collisions of a body the order of the start, such as a lattice, is felt.
const MIN_COLLISIONS: f64 = 10.0;

/// The number of collisions in a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct ExpectedCollisions {
    /// The number; `None` without thermal motion.
    pub(super) number: Option<f64>,
    /// Whether theory predicts it, to a few per cent; else it is an estimate.
    pub(super) is_prediction: bool,
    /// Source, and why it is only an estimate.
    pub(super) source: String,
}

/// Bodies of one kind.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Kind {
    number: f64,
    /// Mean width of the hull (length).
    width: f64,
    /// Covered area of one (length²).
    area: f64,
    /// 1 / mass; 0 if it is fixed.
    inverse_mass: f64,
    /// Mean of (r × n)²/I over the directions of the normal, and over the points of the hull
    /// (1 / mass).
    turning: [f64; 2],
}

impl ExpectedCollisions {
    /// The number of collisions until the end of the run, from the state at its start.
    pub(super) fn new(scene: &Scene, view: &View<'_>) -> Self {
        let kinds = kinds(view);
        let rate = view
            .temperature()
            .filter(|kt| *kt > 0.0)
            .map(|kt| rate(view, &kinds, kt));
        // With drag, all paths end where those without it are at an earlier time.
        let time = DragClock::new(view.drag()).reading(scene.run.until);
        let number = rate.map(|rate| rate * time);
        let mut reasons = reasons(scene, view, &kinds);
        if number.is_some_and(|number| 2.0 * number < MIN_COLLISIONS * view.len() as f64) {
            reasons.push("a short run keeps the order of its start".to_owned());
        }
        let source = match (&reasons[..], kinds.len()) {
            ([], 1) => ENSKOG.to_owned(),
            ([], _) => format!("{ENSKOG}, contact values of a mixture of Santos et al. (1999)"),
            (reasons, _) => format!("an estimate: {}", reasons.join(", ")),
        };
        Self {
            number,
            is_prediction: reasons.is_empty(),
            source,
        }
    }
}

/// Why theory does not predict the number.
fn reasons(scene: &Scene, view: &View<'_>, kinds: &[Kind]) -> Vec<String> {
    let is_elastic = stages::measured_elasticities(scene)
        .into_iter()
        .chain([&scene.elasticity])
        .all(carom::engine::ElasticitySpec::is_elastic);
    let bodies = || view.bodies().map(|view| view.body);
    let is_edited =
        scene.stage.iter().any(|stage| !stage.thermostat.is_empty()) || scene.stage.len() > 1;
    let all = [
        (
            bodies().any(|body| !body.is_wall() && !body.molecule().is_disc()),
            "molecules count as hulls",
        ),
        (
            bodies().any(carom::engine::Body::is_fixed),
            "some bodies are fixed",
        ),
        (!is_elastic, "contacts are not elastic"),
        (
            view.has_pair_rules(),
            "rules for pairs of tags are left out",
        ),
        (is_edited, "stages and thermostats are left out"),
        (
            covered(view, kinds) > DENSEST_FLUID,
            "the gas is denser than 0.65",
        ),
        (view.len() < 20, "there are few bodies"),
    ];
    all.into_iter()
        .filter(|(holds, _)| *holds)
        .map(|(_, words)| words.to_owned())
        .collect()
}

/// The kinds of bodies that are no walls.
fn kinds(view: &View<'_>) -> Vec<Kind> {
    let mut found: HashMap<[u64; 5], Kind> = HashMap::new();
    for body in view
        .bodies()
        .map(|view| view.body)
        .filter(|body| !body.is_wall())
    {
        let molecule = body.molecule();
        let inertia = body.inertia();
        let atoms = molecule.atoms().len() as u64;
        let shape = [molecule.bounding_radius(), molecule.area()].map(f64::to_bits);
        let key = [
            atoms,
            shape[0],
            shape[1],
            inertia.inverse_mass.to_bits(),
            inertia.inverse_moment.to_bits(),
        ];
        let new = || Kind::new(molecule, inertia.inverse_mass, inertia.inverse_moment);
        found.entry(key).or_insert_with(new).number += 1.0;
    }
    let mut kinds: Vec<Kind> = found.into_values().collect();
    kinds.sort_by(|a, b| {
        let key = |kind: &Kind| [kind.width, kind.inverse_mass, kind.area, kind.number];
        key(a)
            .partial_cmp(&key(b))
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    let group = kinds.len().div_ceil(MAX_KINDS);
    if group > 1 {
        kinds.chunks(group).map(Kind::mean).collect()
    } else {
        kinds
    }
}

impl Kind {
    fn new(molecule: &Molecule, inverse_mass: f64, inverse_moment: f64) -> Self {
        let area = molecule.area();
        if molecule.is_round() {
            let width = 2.0 * molecule.bounding_radius();
            return Self {
                number: 0.0,
                width,
                area,
                inverse_mass,
                turning: [0.0; 2],
            };
        }
        let step = TAU / DIRECTIONS as f64;
        let normal = |index: usize| DVec2::from_angle(step * index as f64);
        let point = |normal: DVec2| {
            let ends = molecule
                .atoms()
                .iter()
                .map(|atom| atom.offset() + atom.radius() * normal);
            ends.max_by(|a, b| a.dot(normal).total_cmp(&b.dot(normal)))
                .unwrap_or_default()
        };
        let (mut perimeter, mut by_angle, mut by_length) = (0.0, 0.0, 0.0);
        for index in 0..DIRECTIONS {
            let [from, to] = [normal(index), normal(index + 1)].map(point);
            let middle = normal(index).midpoint(normal(index + 1)).normalize();
            let length = from.distance(to);
            let [a, b] = [from, to].map(|place| place.perp_dot(middle));
            perimeter += length;
            // The mean of a square that is linear along the segment.
            by_length += length * (a * a + a * b + b * b) / 3.0;
            by_angle += point(middle).perp_dot(middle).powi(2);
        }
        let turning =
            [by_angle / DIRECTIONS as f64, by_length / perimeter].map(|mean| mean * inverse_moment);
        Self {
            number: 0.0,
            width: perimeter / PI,
            area,
            inverse_mass,
            turning,
        }
    }

    /// Several kinds as one.
    fn mean(kinds: &[Self]) -> Self {
        let number: f64 = kinds.iter().map(|kind| kind.number).sum();
        let mean = |of: fn(&Self) -> f64| {
            kinds.iter().map(|kind| kind.number * of(kind)).sum::<f64>() / number
        };
        Self {
            number,
            width: mean(|kind| kind.width),
            area: mean(|kind| kind.area),
            inverse_mass: mean(|kind| kind.inverse_mass),
            turning: [mean(|kind| kind.turning[0]), mean(|kind| kind.turning[1])],
        }
    }
}

/// The share of the box that bodies other than walls cover.
fn covered(view: &View<'_>, kinds: &[Kind]) -> f64 {
    kinds
        .iter()
        .map(|kind| kind.number * kind.area)
        .sum::<f64>()
        / view.bounds().area()
}

/// Collisions of all bodies per time.
fn rate(view: &View<'_>, kinds: &[Kind], temperature: f64) -> f64 {
    let box_area = view.bounds().area();
    let contact = contact_values(view, kinds);
    let mut rate = 0.0;
    // Σ n_i n_j σ_ij² g_ij, for the pressure.
    let mut virial = 0.0;
    for (i, a) in kinds.iter().enumerate() {
        for (j, b) in kinds.iter().enumerate().skip(i) {
            let pairs = if i == j {
                0.5 * a.number * (a.number - 1.0)
            } else {
                a.number * b.number
            };
            let sigma = 0.5 * (a.width + b.width);
            let g = contact(a, b);
            virial += 2.0 * pairs * sigma * sigma * g / (box_area * box_area);
            let both_fixed = a.inverse_mass == 0.0 && b.inverse_mass == 0.0;
            if pairs > 0.0 && !both_fixed {
                let share = a.width / (a.width + b.width);
                // A point of the hull of one, and any direction of the other.
                let turning = share * (a.turning[1] + b.turning[0])
                    + (1.0 - share) * (a.turning[0] + b.turning[1]);
                let inverse = a.inverse_mass + b.inverse_mass + turning;
                rate += pairs / box_area * sigma * g * (TAU * temperature * inverse).sqrt();
            }
        }
    }
    let density = kinds.iter().map(|kind| kind.number).sum::<f64>() / box_area;
    let excess = if density > 0.0 {
        1.0 + 0.5 * PI * virial / density
    } else {
        1.0
    };
    let hits = |kind: &Kind| {
        let speed = (temperature * (kind.inverse_mass + kind.turning[0]) / TAU).sqrt();
        kind.number / box_area * excess * if kind.inverse_mass > 0.0 { speed } else { 0.0 }
    };
    rate + 2.0 * wall_length(view) * kinds.iter().map(hits).sum::<f64>()
}

/// The contact value of each pair of kinds.
fn contact_values(view: &View<'_>, kinds: &[Kind]) -> impl Fn(&Kind, &Kind) -> f64 + use<> {
    let number: f64 = kinds.iter().map(|kind| kind.number).sum();
    let area = view.bounds().area();
    let widths: f64 = kinds.iter().map(|kind| kind.number * kind.width).sum();
    let covered = covered(view, kinds) * area;
    let mixture = DiscMixture::new(number, widths / number, covered, area);
    move |a, b| mixture.contact_value([a.width, b.width])
}

/// Length of all walls (length); each has two sides.
fn wall_length(view: &View<'_>) -> f64 {
    view.bodies()
        .filter_map(|body| BodyView::wall(&body))
        .map(|[a, b]| a.distance(b))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_methods::AnySimulation;

    /// Expected and found collisions of a scene.
    fn compare(text: &str, until: f64) -> (ExpectedCollisions, f64) {
        let mut scene = Scene::from_toml(text).unwrap();
        scene.run.until = until;
        let mut simulation = AnySimulation::new(&scene).unwrap();
        let expected = ExpectedCollisions::new(&scene, &simulation.view());
        simulation.run_until(until).unwrap();
        let found = simulation.view().counters().collisions as f64;
        let ratio = expected.number.unwrap() / found;
        assert!(found > 1e4, "{found}");
        (expected, ratio)
    }

    const MAXWELL: &str = "mass = 1.0\ntemperature = 1.0\nvelocities = \"maxwell\"\n";

    #[test]
    fn enskog_predicts_the_collisions_of_discs_within_five_per_cent() {
        for (radius, share, until) in [(0.005, 0.05, 6.0), (0.01, 0.3, 2.0), (0.01, 0.6, 1.0)] {
            let gas = format!("[[gas]]\nradius = {radius}\n{MAXWELL}area_fraction = {share}\n");
            let (expected, ratio) = compare(&gas, until);
            assert!(
                expected.is_prediction && expected.source == ENSKOG,
                "{expected:?}"
            );
            assert!((ratio - 1.0).abs() < 0.05, "{share}: {ratio}");
        }
    }

    #[test]
    fn enskog_predicts_the_collisions_of_mixtures_within_five_per_cent() {
        let gas = |radius: &str, mass: f64, share: f64| {
            format!(
                "[[gas]]\nradius = {radius}\nmass = {mass}\ntemperature = 1.0\narea_fraction = {share}\n"
            )
        };
        for (text, until) in [
            (gas("0.02", 4.0, 0.25) + &gas("0.008", 1.0, 0.2), 1.0),
            (gas("0.03", 1.0, 0.02) + &gas("0.006", 9.0, 0.1), 4.0),
            (gas("{ uniform = [0.006, 0.016] }", 1.0, 0.5), 1.0),
        ] {
            let (expected, ratio) = compare(&text, until);
            assert!(
                expected.is_prediction && expected.source.contains("Santos"),
                "{expected:?}"
            );
            assert!((ratio - 1.0).abs() < 0.05, "{text}: {ratio}");
        }
    }

    #[test]
    fn estimates_of_molecules_walls_and_bumpers_say_so_and_are_near() {
        let gas = |shape: &str, share: f64| {
            format!(
                "[[gas]]\nshape = \"{shape}\"\natom_radius = 0.008\natom_mass = 1.0\ntemperature = 1.0\n\
                 area_fraction = {share}\n"
            )
        };
        let discs = format!("[[gas]]\nradius = 0.01\n{MAXWELL}area_fraction = 0.3\n");
        for (text, until, word) in [
            (gas("dumbbell", 0.1), 8.0, "hulls"),
            (gas("dumbbell", 0.5), 2.0, "hulls"),
            (gas("tee", 0.3), 4.0, "hulls"),
            (
                format!("{discs}[[wall]]\nx = 0.0\n[[wall]]\ny = 0.0\n"),
                1.0,
                "fixed",
            ),
            (
                format!("{discs}[[bumper]]\nradius = 0.1\nat = [0.5, 0.5]\n"),
                1.0,
                "fixed",
            ),
        ] {
            let (expected, ratio) = compare(&text, until);
            assert!(
                !expected.is_prediction && expected.source.contains(word),
                "{expected:?}"
            );
            assert!((ratio - 1.0).abs() < 0.3, "{text}: {ratio}");
        }
    }

    #[test]
    fn without_thermal_motion_there_is_no_number() {
        let scene = Scene::from_toml("[[bumper]]\nradius = 0.1\nat = [0.5, 0.5]\n").unwrap();
        let expected = ExpectedCollisions::new(&scene, &AnySimulation::new(&scene).unwrap().view());
        assert_eq!(expected.number, None);
    }
}
