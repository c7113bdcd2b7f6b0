//! What is in a scene: its bodies by kind, its energy, and what its run does.

use carom_tables::with_error;
use std::collections::{BTreeMap, HashMap};

use carom::{
    Scene, View,
    engine::{Body, BodyView, Tag},
};
use serde::Serialize;

use super::aligned::{short, table};
use crate::{run::stop, sampling_times::sampling_count, schedule::stages};

/// More sizes and masses than this in one group, as drawn from a distribution, share a line.
const MAX_KINDS: usize = 8;

/// What is in a scene at its start.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct CheckedContents {
    /// Sides of the box (length).
    sides: [f64; 2],
    seed: u64,
    bodies: Vec<Kind>,
    /// Number of bodies that move, and of those that turn in contacts.
    pub(super) moving: usize,
    pub(super) turning: usize,
    /// The share of the box that all bodies cover: the sum of their areas, of fixed molecules that
    /// may overlap what they are expected to cover.
    pub(super) area_fraction: f64,
    /// What fixed molecules that may overlap are expected to cover, and the sum of their areas, as
    /// shares of the box.
    #[serde(skip_serializing_if = "Option::is_none")]
    overlapping: Option<[f64; 2]>,
    energy: f64,
    /// kT; `None` without thermal motion.
    temperature: Option<f64>,
    momentum: [f64; 2],
    /// End of the run, and its number of samples.
    pub(super) until: f64,
    pub(super) samples: u64,
    observe: Vec<String>,
    /// What ends the run before that, in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    stop: Option<String>,
    stages: Vec<String>,
}

/// Bodies of one kind, or of one group with different sizes and masses.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Kind {
    number: usize,
    tags: Vec<String>,
    shape: String,
    size: String,
    mass: String,
    /// Area of all of them, as a share of the box.
    area_fraction: f64,
    #[serde(skip)]
    first: usize,
}

/// What the bodies on one line have in common: tags, wall or not, numbers of atoms and of edges,
/// fixed or not and moved or not, and locked or not.
type Group<'a> = (&'a [Tag], bool, [usize; 2], [bool; 2], bool);

/// Equal bodies of a group.
struct Equal<'a> {
    first: usize,
    number: usize,
    body: &'a Body,
}

/// The bodies by kind, in the order of the first of each.
fn kinds(view: &View<'_>) -> Vec<Kind> {
    let mut groups: BTreeMap<Group<'_>, HashMap<[u64; 4], Equal<'_>>> = BTreeMap::new();
    for (index, BodyView { body, motion, .. }) in view.bodies().enumerate() {
        let molecule = body.molecule();
        let group = (
            body.tags(),
            body.is_wall(),
            [molecule.atoms().len(), molecule.edges().len()],
            [body.is_fixed(), body.is_fixed() && !motion.is_at_rest()],
            body.is_locked(),
        );
        let kt = body.wall_temperature().unwrap_or(0.0);
        // Other shapes of one bounding radius differ in their area.
        let area = if molecule.is_of_discs() {
            0.0
        } else {
            molecule.area()
        };
        let key = [molecule.bounding_radius(), body.mass(), kt, area].map(f64::to_bits);
        let new = Equal {
            first: index,
            number: 0,
            body,
        };
        groups
            .entry(group)
            .or_default()
            .entry(key)
            .or_insert(new)
            .number += 1;
    }
    let mut kinds: Vec<Kind> = Vec::new();
    for group in groups.into_values() {
        let mut all: Vec<Equal<'_>> = group.into_values().collect();
        // The order of a hash map differs between runs of the program.
        all.sort_by_key(|equal| equal.first);
        let of_line = if all.len() > MAX_KINDS { all.len() } else { 1 };
        kinds.extend(all.chunks(of_line).map(|equal| Kind::new(view, equal)));
    }
    kinds.sort_by_key(|kind| kind.first);
    kinds
}

impl CheckedContents {
    pub(super) fn new(scene: &Scene, view: &View<'_>) -> Self {
        let (mut moving, mut turning, mut area) = (0, 0, 0.0);
        for BodyView { body, .. } in view.bodies() {
            area += body.molecule().area();
            moving += usize::from(body.is_free());
            turning += usize::from(body.can_turn());
        }
        let box_area = view.bounds().area();
        let summed = overlapping_areas(scene, view) / box_area;
        let overlapping = (summed > 0.0).then(|| [-(-summed).exp_m1(), summed]);
        let run = &scene.run;
        Self {
            sides: view.bounds().sides().into(),
            seed: scene.bounds.seed,
            bodies: kinds(view),
            moving,
            turning,
            area_fraction: area / box_area
                + overlapping.map_or(0.0, |[covered, summed]| covered - summed),
            overlapping,
            energy: view.energy(),
            temperature: view.temperature(),
            momentum: view.momentum().into(),
            until: run.until,
            samples: sampling_count(0.0, run.until, run.sample_interval),
            observe: run.observe.clone(),
            stop: run.stop.as_ref().map(stop::words),
            stages: stages::describe(scene),
        }
    }

    /// Bodies, box and temperature in one line.
    pub(super) fn sentence(&self) -> String {
        let temperature = self
            .temperature
            .map_or_else(String::new, |kt| format!("; kT {}", with_error(kt, None)));
        let turning = if self.turning > 0 {
            format!(", {} turn", self.turning)
        } else {
            String::new()
        };
        format!(
            "{} bodies move{turning}; they cover {} of a box of {} × {}{temperature}",
            self.moving,
            short(self.area_fraction),
            short(self.sides[0]),
            short(self.sides[1])
        )
    }

    /// Several lines of text.
    pub(super) fn text(&self) -> String {
        let head = ["number", "tags", "shape", "size", "mass", "area"].map(str::to_owned);
        let rows = self.bodies.iter().map(Kind::row);
        let temperature = self
            .temperature
            .map_or_else(String::new, |kt| format!(", kT {}", with_error(kt, None)));
        let [x, y] = self.momentum;
        let mut run = format!("to t = {}, {} samples", self.until, self.samples);
        if !self.observe.is_empty() {
            run = format!("{run} of {}", self.observe.join(", "));
        }
        let mut lines = vec![
            [
                "box".to_owned(),
                format!("{} × {}, seed {}", self.sides[0], self.sides[1], self.seed),
            ],
            [
                "bodies".to_owned(),
                format!(
                    "{} move, {} of which turn; they cover {} of the box",
                    self.moving,
                    self.turning,
                    short(self.area_fraction)
                ),
            ],
            [
                "start".to_owned(),
                format!(
                    "energy {}{temperature}, momentum ({x:.3e}, {y:.3e})",
                    with_error(self.energy, None)
                ),
            ],
            ["run".to_owned(), run],
        ];
        if let Some([covered, summed]) = self.overlapping {
            let words = format!(
                "fixed ones that may overlap are expected to cover 1 − exp(−{}) = {} of the box",
                short(summed),
                short(covered)
            );
            lines.insert(2, [String::new(), words]);
        }
        lines.extend(
            self.stop
                .iter()
                .map(|rule| [String::new(), format!("it ends before that {rule}")]),
        );
        let stages = self.stages.iter().enumerate();
        lines.extend(stages.map(|(index, stage)| [format!("stage {}", index + 1), stage.clone()]));
        format!(
            "{}\n\nBodies\n{}",
            table(lines),
            table(std::iter::once(head).chain(rows))
        )
    }
}

/// The sum of the areas of the molecules of fixed gases that may overlap (length²).
fn overlapping_areas(scene: &Scene, view: &View<'_>) -> f64 {
    // Fixed gases follow the single bodies, in their order.
    let mut before = scene.molecule.len() + scene.bumper.len() + scene.wall_count();
    let mut sum = 0.0;
    for gas in scene.gas.iter().filter(|gas| gas.fixed) {
        // Of drawn sizes that cover an area, the expected number.
        let number = gas.count.unwrap_or_else(|| {
            let alone = Scene {
                gas: vec![gas.clone()],
                bounds: scene.bounds.clone(),
                ..Scene::default()
            };
            alone.expected_bodies().unwrap_or(0)
        });
        if gas.overlapping {
            let bodies = view.bodies().skip(before).take(number);
            sum += bodies.map(|body| body.body.molecule().area()).sum::<f64>();
        }
        before += number;
    }
    sum
}

impl Kind {
    /// The row of the table of bodies: number, tags, shape, size, mass, and area.
    fn row(&self) -> [String; 6] {
        let tags = if self.tags.is_empty() {
            "-".to_owned()
        } else {
            self.tags.join(" ")
        };
        [
            self.number.to_string(),
            tags,
            self.shape.clone(),
            self.size.clone(),
            self.mass.clone(),
            short(self.area_fraction),
        ]
    }

    /// Equal bodies, or different ones of one group.
    fn new(view: &View<'_>, all: &[Equal<'_>]) -> Self {
        let body = all[0].body;
        let number = all.iter().map(|one| one.number).sum();
        let area: f64 = all
            .iter()
            .map(|one| one.number as f64 * one.body.molecule().area())
            .sum();
        let atoms = body.molecule().atoms().len();
        let radii = spread(all, |body| body.molecule().bounding_radius());
        let size = match (body.is_wall(), atoms) {
            (true, _) => format!(
                "length {}",
                spread(all, |body| {
                    let edge = body.molecule().wall_edge();
                    edge.map_or(0.0, |edge| 2.0 * (edge.half_length() + edge.radius()))
                })
            ),
            (false, 1) if !body.molecule().ellipses().is_empty() => {
                let width = spread(all, |body| 2.0 * body.molecule().shape_of(0).axes()[1]);
                let length = spread(all, |body| 2.0 * body.molecule().shape_of(0).axes()[0]);
                format!("length {length}, width {width}")
            }
            (false, 1) => format!("radius {radii}"),
            (false, _) if !body.molecule().is_of_discs() => {
                let areas = spread(all, |body| body.molecule().area());
                format!("bounding radius {radii}, area {areas}")
            }
            (false, _) => format!("bounding radius {radii}"),
        };
        let masses = || spread(all, Body::mass);
        let moves = view
            .body(body.key())
            .is_some_and(|found| !found.motion.is_at_rest());
        let fixed = if moves { "moved" } else { "fixed" };
        let mass = match (body.is_fixed(), body.wall_temperature()) {
            (true, Some(kt)) => format!("{fixed}, of temperature kT = {kt}"),
            (true, None) => fixed.to_owned(),
            (false, _) if body.is_locked() && !body.molecule().is_disc() && !body.is_wall() => {
                format!("{}, does not turn", masses())
            }
            (false, _) => masses(),
        };
        Self {
            number,
            tags: body
                .tags()
                .iter()
                .map(|&tag| view.tag_names().name(tag).to_owned())
                .collect(),
            shape: shape_of(body),
            size,
            mass,
            area_fraction: area / view.bounds().area(),
            first: all.iter().map(|one| one.first).min().unwrap_or(0),
        }
    }
}

/// What a body is, in a few words.
fn shape_of(body: &Body) -> String {
    let molecule = body.molecule();
    let (atoms, edges) = (molecule.atoms().len(), molecule.edges());
    if body.is_piston() {
        return "piston".to_owned();
    }
    if body.is_wall() {
        return "wall".to_owned();
    }
    if let Some(corners) = molecule.corners() {
        return format!("polygon of {} corners", corners.len());
    }
    let radii = molecule.atoms().iter().map(carom::Atom::radius);
    match (atoms, edges) {
        (1, _) if !molecule.ellipses().is_empty() => "ellipse".to_owned(),
        (1, _) => "disc".to_owned(),
        (_, []) => format!("molecule of {atoms} atoms"),
        (2, [edge]) if radii.clone().all(|radius| radius == edge.radius()) => "capsule".to_owned(),
        (_, [_]) => format!("molecule of {atoms} atoms and 1 edge"),
        (_, edges) => format!("molecule of {atoms} atoms and {} edges", edges.len()),
    }
}

/// The value of equal bodies, or the range of different ones, with their mean.
fn spread(all: &[Equal<'_>], of: fn(&Body) -> f64) -> String {
    let (mut least, mut most, mut sum, mut number) = (f64::INFINITY, 0.0f64, 0.0, 0);
    for one in all {
        let value = of(one.body);
        (least, most) = (least.min(value), most.max(value));
        sum += one.number as f64 * value;
        number += one.number;
    }
    if least == most {
        return with_error(least, None);
    }
    format!(
        "{} to {}, mean {}",
        short(least),
        short(most),
        short(sum / number as f64)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_methods::AnySimulation;

    fn contents(text: &str) -> CheckedContents {
        let scene = Scene::from_toml(text).unwrap();
        CheckedContents::new(&scene, &AnySimulation::new(&scene).unwrap().view())
    }

    #[test]
    fn kinds_are_counted_and_their_areas_are_summed() {
        let found = contents(
            "[[gas]]\ntags = [\"gas\"]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 100\n\
             [[molecule]]\nshape = \"tee\"\natom_radius = 0.02\natom_mass = 1.0\nat = [0.5, 0.5]\n\
             [[bumper]]\nradius = 0.05\nat = [0.1, 0.1]\n[run]\nuntil = 2.0\nsample_interval = 0.5\n",
        );
        let gas = found
            .bodies
            .iter()
            .find(|kind| kind.tags == ["gas"])
            .unwrap();
        assert_eq!(
            (gas.number, gas.shape.as_str(), gas.size.as_str()),
            (100, "disc", "radius 0.01")
        );
        assert!((gas.area_fraction - 0.01 * std::f64::consts::PI).abs() < 1e-12);
        assert_eq!((found.moving, found.turning, found.samples), (101, 1, 4));
        // π (100 · 0.01² + 5 · 0.02² + 0.05²)
        assert!((found.area_fraction - 0.0145 * std::f64::consts::PI).abs() < 1e-12);
        let text = found.text();
        assert!(
            text.contains("molecule of 5 atoms") && text.contains("fixed"),
            "{text}"
        );
        assert!(
            text.contains("101 move, 1 of which turn") && text.contains("to t = 2, 4 samples"),
            "{text}"
        );
    }

    #[test]
    fn pistons_are_told_with_their_masses() {
        let found = contents(
            "[[piston]]\nx = 0.25\nmass = 3.0\nstops = [0.2, 0.4]\n\
             [[piston]]\nx = 0.75\nmass = 5.0\nstops = [0.6, 0.8]\n",
        );
        let told = found.bodies.iter().map(|kind| {
            (
                kind.number,
                kind.shape.as_str(),
                kind.size.as_str(),
                kind.mass.as_str(),
            )
        });
        let mut told: Vec<_> = told.collect();
        told.sort_unstable();
        assert_eq!(
            told,
            [
                (1, "piston", "length 1", "3"),
                (1, "piston", "length 1", "5")
            ]
        );
    }

    #[test]
    fn bodies_with_edges_are_named_by_their_shape_with_their_area() {
        let found = contents(
            "[[molecule]]\nshape = \"square\"\nsize = 0.02\nmass = 1.0\nat = [0.2, 0.5]\n\
             [[molecule]]\nshape = \"capsule:2.5\"\nsize = 0.04\nmass = 1.0\nat = [0.5, 0.5]\n\
             [[molecule]]\natoms = [{ at = [0.0, 0.0], radius = 0.02, mass = 1.0 }, \
             { at = [0.1, 0.0], radius = 0.02, mass = 1.0 }]\nedges = [[0, 1]]\nedge_radius = 0.01\n\
             at = [0.8, 0.5]\n",
        );
        let named: Vec<&str> = found
            .bodies
            .iter()
            .map(|kind| kind.shape.as_str())
            .collect();
        assert_eq!(
            named,
            [
                "polygon of 4 corners",
                "capsule",
                "molecule of 2 atoms and 1 edge"
            ]
        );
        assert_eq!(
            found.bodies[0].size,
            "bounding radius 0.0141422, area 0.000400002"
        );
    }

    #[test]
    fn drawn_sizes_share_a_line_with_their_range() {
        let found = contents(
            "[[gas]]\nradius = { uniform = [0.01, 0.02] }\ndensity = 1.0\nenergy = 1.0\narea_fraction = 0.2\n",
        );
        assert_eq!(found.bodies.len(), 1);
        assert!(
            found.bodies[0].size.starts_with("radius 0.01"),
            "{}",
            found.bodies[0].size
        );
        assert!((found.bodies[0].area_fraction - 0.2).abs() < 0.01);
    }
}
