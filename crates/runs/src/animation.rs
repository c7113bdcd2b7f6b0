//! Animation of a run: the flights of the bodies between contacts, recorded for a while and packed
//! for a page.
//!
//! A copy of the simulation runs ahead and is recorded, so the run itself neither waits nor stores
//! anything. The copy makes the same contacts, to the bit. The flights are written as a table with
//! all digits and as JSON for the page. The JSON stores each number as one of `LEVELS` + 1
//! equidistant levels in three characters; in the box this is at most a hundredth of a pixel.
//!
//! The size does not grow with the system: of a large system a part is shown, see
//! `visible_region.rs`. The animation ends before any unrecorded body can
//! enter the picture.

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use carom::{
    CollisionReport, Observer, View,
    engine::{Body, BodyView},
    observers::{
        FlightLog, LoggedFlight, colour, coloured_kinds, drawn_bonds, drawn_circles,
        packed_contours,
    },
};
use carom_geometry::Edge;
use carom_methods::AnySimulation;
use glam::DVec2;
use serde::Serialize;

use crate::{output::Folder, visible_region::VisibleRegion};

/// Name of the packed animation.
pub const ANIMATION: &str = "animation.json";

/// Name of the table of flights.
pub const FLIGHTS: &str = "flights.csv";

const HEADER: [&str; 8] = [
    "time",
    "body",
    "x",
    "y",
    "velocity_x",
    "velocity_y",
    "angle",
    "angular_velocity",
];

/// Largest number of recorded flights. More: a longer animation and a larger page; these take about
/// 0.6 MB.
const CAPACITY: usize = 32_000;

/// The animation ends after this many contacts of the whole system. More: a longer animation of a
/// large system, and about a second more before the run for each million.
const MAX_CONTACTS: usize = 500_000;

/// Intervals of the path of a wall, which is drawn as a straight line in each. More: larger pages.
/// Fewer: walls that turn or are hit often are drawn beside their place.
const PATH_INTERVALS: usize = 1000;

/// Number of levels for a number between 0 and 1; even, so that the middle is a level.
const LEVELS: f64 = 262_142.0;

/// Digits of a number to the base 64, as `animation.js` decodes them.
const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// Data of the animation on a page.
#[derive(Debug, Serialize)]
struct Animation {
    sides: [f64; 2],
    /// Lower left corner, width and height of the visible part of the box; absent for all of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    window: Option<[f64; 4]>,
    from: f64,
    until: f64,
    /// Drag of all bodies (1/time); absent if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    drag: Option<f64>,
    /// Acceleration of the free bodies; absent if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    gravity: Option<[f64; 2]>,
    /// Under shear the shift along x of the next box above at the start (length), and its speed;
    /// absent without.
    #[serde(skip_serializing_if = "Option::is_none")]
    shear: Option<[f64; 2]>,
    /// Largest velocity component.
    fastest: f64,
    /// Largest angular velocity.
    fastest_spin: f64,
    shapes: Vec<Shape>,
    /// Index of each body's shape in the list of shapes.
    bodies: Vec<usize>,
    /// A body that the page can show enlarged.
    watched: Option<usize>,
    /// Ends of each wall at the start, and half its thickness (length); of one that oscillates also
    /// amplitude, angular frequency and phase.
    walls: Vec<Vec<f64>>,
    /// The paths of the walls and pistons that move in any other way.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    wall_paths: Vec<WallPath>,
    /// Bonds at the start: the numbers of the two bodies, and the points of each in its frame
    /// (length).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    bonds: Vec<([u32; 2], [f64; 4])>,
    /// For each flight: the body's number as three digits; then time, position and velocity; then,
    /// unless the body is a disc, orientation in turns and angular velocity.
    flights: String,
}

/// How a wall or a piston moves.
#[derive(Debug, Serialize)]
struct WallPath {
    /// Its index in the list of walls.
    wall: usize,
    /// Its ends at equidistant times, from the start to the end of the animation (length).
    ends: Vec<[f64; 4]>,
}

/// The appearance that several bodies share.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Shape {
    name: String,
    colour: &'static str,
    fixed: bool,
    /// Position in the body frame, and radius (length).
    atoms: Vec<[f64; 3]>,
    /// Of a body with straight edges, the closed lines that are drawn in place of the atoms, see
    /// [`packed_contours`].
    #[serde(skip_serializing_if = "Vec::is_empty")]
    lines: Vec<Vec<Vec<f64>>>,
}

impl Shape {
    /// The appearance of a body of this kind, see [`coloured_kinds`].
    fn new(body: &Body, kind: usize, view: &View<'_>) -> Self {
        let tags: Vec<&str> = body
            .tags()
            .iter()
            .map(|&tag| view.tag_names().name(tag))
            .collect();
        let circles = drawn_circles(body.molecule()).into_iter();
        Self {
            name: tags.join(", "),
            colour: colour(body, kind),
            fixed: body.is_fixed(),
            atoms: circles
                .map(|(centre, radius)| [centre.x, centre.y, radius])
                .collect(),
            lines: packed_contours(body.molecule(), 1.0),
        }
    }

    fn turns(&self) -> bool {
        self.atoms.len() > 1 && !self.fixed
    }

    /// Whether the atoms are those of another shape times a factor, to the precision of a picture.
    fn is_scaled(&self, other: &Self) -> bool {
        let size = |shape: &Self| {
            shape
                .atoms
                .iter()
                .flatten()
                .fold(0.0, |most: f64, x| most.max(x.abs()))
        };
        let factor = size(self) / size(other);
        let is_near =
            |(one, other): (&f64, &f64)| (one - factor * other).abs() <= 1e-6 * size(self);
        self.atoms.len() == other.atoms.len()
            && self.lines.is_empty() == other.lines.is_empty()
            && self
                .atoms
                .iter()
                .flatten()
                .zip(other.atoms.iter().flatten())
                .all(is_near)
    }
}

/// The animation ends when a body of mean speed has crossed the box this many times.
const CROSSINGS: f64 = 4.0;

/// Records the animation from the present state and writes it. Its length does not depend on the
/// end of the run, so an extended run has the same animation.
///
/// # Errors
/// A file cannot be written.
pub fn record(simulation: &AnySimulation, folder: &Folder) -> Result<()> {
    let (log, animation) = recorded(simulation);
    let rows = log.flights().iter().map(|flight| {
        let LoggedFlight {
            position, velocity, ..
        } = flight;
        let place = [position.x, position.y, velocity.x, velocity.y];
        (
            flight.time,
            flight.body,
            place,
            flight.angle,
            flight.angular_velocity,
        )
    });
    folder.write_lasting_table(FLIGHTS, &HEADER, rows)?;
    folder.write_lasting(ANIMATION, encoded(&animation)?)
}

/// Returns the animation from the present state on as JSON, for
/// [`Page::animation`](carom_report::page::Page::animation). It changes nothing.
///
/// # Errors
/// It cannot be encoded.
pub fn json(simulation: &AnySimulation) -> Result<String> {
    encoded(&recorded(simulation).1)
}

fn encoded(animation: &Animation) -> Result<String> {
    serde_json::to_string(animation).context("the animation cannot be encoded as JSON")
}

/// Records a copy of the simulation that runs ahead.
fn recorded(simulation: &AnySimulation) -> (FlightLog, Animation) {
    let view = simulation.view();
    let part = VisibleRegion::new(&view);
    let log = match &part {
        Some(part) => FlightLog::among(CAPACITY, part.bodies.iter().copied()),
        None => FlightLog::new(CAPACITY),
    };
    let speeds = view.bodies().map(|body| body.motion.velocity.length());
    let mut watching = (log, Fastest(speeds.fold(0.0, f64::max)));
    watching.start(&view);
    let margin = part.as_ref().map_or(f64::INFINITY, |part| part.margin);
    let from = view.time().to_f64();
    let mut until = end(&view).min(from + margin / watching.1.0);
    let mut twin = simulation.clone();
    let mut contacts = 0;
    // A failure of the copy is ignored: the run itself reports it.
    while matches!(twin.step(until, &mut watching), Ok(true)) {
        contacts += 1;
        let now = twin.time().to_f64();
        if watching.0.is_full() || contacts == MAX_CONTACTS {
            until = now;
            break;
        }
        // No speed so far exceeds this one: no unrecorded body can be in view before this time.
        until = until.min(from + margin / watching.1.0).max(now);
    }
    drop(twin);
    let log = watching.0;
    let paths = wall_paths(simulation, part.as_ref(), until);
    let animation = Animation::new(&view, part.as_ref(), log.flights(), (until, paths));
    (log, animation)
}

/// Largest speed of any body so far (length / time).
struct Fastest(f64);

impl Observer for Fastest {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        for side in &report.sides {
            self.0 = self.0.max(side.after.velocity.length());
        }
    }
}

/// Latest end of an animation that begins now (time).
fn end(view: &View<'_>) -> f64 {
    let moving = || view.bodies().filter(|body| body.body.is_free());
    let mean = moving()
        .map(|body| body.motion.velocity.length())
        .sum::<f64>()
        / moving().count().max(1) as f64;
    let stretch = CROSSINGS * view.bounds().sides().max_element() / mean;
    // Without motion the duration is arbitrary.
    view.time().to_f64() + if stretch.is_finite() { stretch } else { 1.0 }
}

impl Animation {
    fn new(
        view: &View<'_>,
        part: Option<&VisibleRegion>,
        flights: &[LoggedFlight],
        (until, paths): (f64, Vec<WallPath>),
    ) -> Self {
        let mut shapes: Vec<Shape> = Vec::new();
        let (mut bodies, mut number_of) = (Vec::new(), BTreeMap::new());
        let shown = |body: &Body| !body.is_wall() && part.is_none_or(|part| part.has(body));
        for (body, kind) in view
            .bodies()
            .zip(coloured_kinds(view))
            .filter(|(body, _)| shown(body.body))
        {
            let shape = Shape::new(body.body, kind, view);
            let number = shapes
                .iter()
                .position(|known| *known == shape)
                .unwrap_or(shapes.len());
            if number == shapes.len() {
                shapes.push(shape);
            }
            number_of.insert(body.body.id(), bodies.len());
            bodies.push(number);
        }
        let sides = view.bounds().sides();
        let largest = |quantity: fn(&LoggedFlight) -> f64| {
            flights
                .iter()
                .map(quantity)
                .fold(f64::MIN_POSITIVE, f64::max)
        };
        let mut animation = Self {
            sides: sides.to_array(),
            window: part.map(VisibleRegion::window),
            from: view.time().to_f64(),
            until,
            drag: Some(view.drag()).filter(|drag| *drag > 0.0),
            gravity: Some(view.gravity().to_array()).filter(|gravity| *gravity != [0.0; 2]),
            shear: view
                .is_sheared()
                .then(|| [view.bounds().tilt(), view.shear_rate() * sides.y]),
            fastest: largest(|flight| flight.velocity.abs().max_element()),
            fastest_spin: largest(|flight| flight.angular_velocity.abs()),
            watched: watched(&shapes, &bodies),
            shapes,
            bodies,
            walls: walls(view, part),
            wall_paths: paths,
            bonds: drawn_bonds(view, |name| {
                number_of.get(&name).map(|number| *number as u32)
            }),
            flights: String::new(),
        };
        for flight in flights {
            // Walls have no number.
            let Some(&number) = number_of.get(&flight.body) else {
                continue;
            };
            animation.pack(
                flight,
                number,
                view.bounds().wrap(flight.position).0 / sides,
            );
        }
        animation
    }

    fn pack(&mut self, flight: &LoggedFlight, number: usize, place: DVec2) {
        let signed = |value: f64, largest: f64| 0.5 * (value / largest + 1.0);
        let time = (flight.time - self.from) / (self.until - self.from);
        let velocity = flight
            .velocity
            .to_array()
            .map(|component| signed(component, self.fastest));
        let turn = flight.angle / std::f64::consts::TAU;
        let spin = [
            turn - turn.floor(),
            signed(flight.angular_velocity, self.fastest_spin),
        ];
        let turning = if self.shapes[self.bodies[number]].turns() {
            &spin[..]
        } else {
            &[]
        };
        push(&mut self.flights, number as u32);
        for value in [time, place.x, place.y]
            .iter()
            .chain(&velocity)
            .chain(turning)
        {
            push(
                &mut self.flights,
                (value.clamp(0.0, 1.0) * LEVELS).round() as u32,
            );
        }
    }
}

/// The paths of the visible walls that move, from the present state on; those that oscillate are
/// drawn from their motion. It runs a copy of the simulation.
fn wall_paths(
    simulation: &AnySimulation,
    part: Option<&VisibleRegion>,
    until: f64,
) -> Vec<WallPath> {
    let view = simulation.view();
    let oscillates = |body: &BodyView<'_>| view.oscillation(body.body.key()).is_some();
    let moves = |body: &BodyView<'_>| {
        body.body.is_wall() && (body.body.is_piston() || !body.motion.is_at_rest())
    };
    if !view.bodies().any(|body| moves(&body) && !oscillates(&body)) {
        return Vec::new();
    }
    let sides = view.bounds().sides();
    let mut paths: Vec<Vec<[f64; 4]>> = Vec::new();
    let mut twin = simulation.clone();
    let begins = view.time().to_f64();
    for sample in 0..=PATH_INTERVALS {
        let share = sample as f64 / PATH_INTERVALS as f64;
        // A failure of the copy is ignored: the run itself reports it.
        if sample > 0 && twin.run_until(begins + share * (until - begins)).is_err() {
            break;
        }
        let now = wall_ends(&twin.view(), part);
        paths.resize(now.len().max(paths.len()), Vec::new());
        for (path, ends) in paths.iter_mut().zip(now) {
            let ends = path
                .last()
                .map_or(ends, |last| nearest_image(ends, *last, sides));
            path.push(ends);
        }
    }
    let oscillating: Vec<bool> = shown(&view, part)
        .flat_map(|body| vec![oscillates(&body); body.wall_segments().count()])
        .collect();
    let is_sampled = |(wall, path): &(usize, Vec<[f64; 4]>)| {
        oscillating.get(*wall) != Some(&true) && path.iter().any(|ends| *ends != path[0])
    };
    let all = paths.into_iter().enumerate().filter(is_sampled);
    all.map(|(wall, ends)| WallPath { wall, ends }).collect()
}

/// The image of a wall whose first end is nearest to where it was.
fn nearest_image(ends: [f64; 4], last: [f64; 4], sides: DVec2) -> [f64; 4] {
    let boxes = [0, 1].map(|axis| ((last[axis] - ends[axis]) / sides[axis]).round());
    [0, 1, 2, 3].map(|place| ends[place] + boxes[place % 2] * sides[place % 2])
}

/// The bodies in the visible part.
fn shown<'a>(
    view: &'a View<'_>,
    part: Option<&'a VisibleRegion>,
) -> impl Iterator<Item = BodyView<'a>> {
    view.bodies()
        .filter(move |body| part.is_none_or(|part| part.has(body.body)))
}

/// The ends of each visible wall (length).
fn wall_ends(view: &View<'_>, part: Option<&VisibleRegion>) -> Vec<[f64; 4]> {
    let ends = |body: BodyView<'_>| {
        let segments = body.wall_segments();
        segments
            .map(|[from, to]| [from.x, from.y, to.x, to.y])
            .collect::<Vec<_>>()
    };
    shown(view, part).flat_map(ends).collect()
}

/// The ends of each visible wall, half its thickness (length), and its oscillation if it has one.
fn walls(view: &View<'_>, part: Option<&VisibleRegion>) -> Vec<Vec<f64>> {
    let walls = |body: BodyView<'_>| {
        let radius = body.body.molecule().wall_edge().map_or(0.0, Edge::radius);
        let oscillation = view.oscillation(body.body.key());
        let of_segment = move |[from, to]: [DVec2; 2]| {
            let mut numbers = vec![from.x, from.y, to.x, to.y, radius];
            if let Some(drive) = oscillation {
                let amplitude = drive.amplitude();
                numbers.extend([amplitude.x, amplitude.y]);
                numbers.extend([drive.frequency(), drive.phase().radians()]);
            }
            numbers
        };
        body.wall_segments().map(of_segment).collect::<Vec<_>>()
    };
    shown(view, part).flat_map(walls).collect()
}

/// The first moving body, if no other has its shape, and it is none of many different sizes of one
/// shape, as in a polydisperse gas.
fn watched(shapes: &[Shape], bodies: &[usize]) -> Option<usize> {
    let mut counts = vec![0_usize; shapes.len()];
    for &shape in bodies {
        counts[shape] += 1;
    }
    let first = bodies.iter().position(|&shape| !shapes[shape].fixed)?;
    let own = bodies[first];
    let is_alone = |shape: usize| counts[shape] == 1 && !shapes[shape].fixed;
    let is_size =
        |other: usize| other != own && is_alone(other) && shapes[other].is_scaled(&shapes[own]);
    (is_alone(own) && !(0..shapes.len()).any(is_size)).then_some(first)
}

/// Appends a number as three digits, the highest first.
fn push(text: &mut String, number: u32) {
    text.extend([12, 6, 0].map(|shift| char::from(DIGITS[(number >> shift & 63) as usize])));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::Existing;
    use carom::Scene;
    use serde_json::Value;

    /// Decodes numbers as `animation.js` does.
    fn numbers(text: &str) -> Vec<u32> {
        let digit = |byte: &u8| DIGITS.iter().position(|known| known == byte).unwrap() as u32;
        text.as_bytes()
            .chunks(3)
            .map(|three| three.iter().fold(0, |sum, byte| 64 * sum + digit(byte)))
            .collect()
    }

    #[test]
    fn bodies_with_edges_have_lines_beside_their_atoms() {
        let scene = Scene::from_toml(
            "[[molecule]]\nshape = \"square\"\nsize = 0.1\nmass = 1.0\nat = [0.5, 0.5]\n\
             velocity = [1.0, 0.0]\nangular_velocity = 2.0\n[[bumper]]\nradius = 0.05\nat = [0.8, 0.5]\n",
        );
        let simulation = AnySimulation::new(&scene.unwrap()).unwrap();
        let animation: Value = serde_json::from_str(&json(&simulation).unwrap()).unwrap();
        let shapes = animation["shapes"].as_array().unwrap();
        assert_eq!(shapes[0]["atoms"].as_array().unwrap().len(), 4);
        let line = shapes[0]["lines"][0].as_array().unwrap();
        let corners: Vec<[f64; 2]> = line
            .iter()
            .map(|corner| [0, 1].map(|axis| corner[axis].as_f64().unwrap()))
            .collect();
        assert_eq!(corners.len(), 4);
        for [x, y] in corners {
            assert!((x.abs() - 0.05).abs() < 1e-6 && (y.abs() - 0.05).abs() < 1e-6);
        }
        assert!(shapes[1].get("lines").is_none(), "a disc has none");
    }

    #[test]
    fn walls_and_pistons_are_drawn_where_they_are() {
        let of = |walls: &str| {
            let gas = "[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 20\n";
            let mut simulation =
                AnySimulation::new(&Scene::from_toml(&format!("{walls}{gas}")).unwrap()).unwrap();
            let animation: Value = serde_json::from_str(&json(&simulation).unwrap()).unwrap();
            let path = animation["wall_paths"][0]["ends"].as_array().unwrap();
            let until = animation["until"].as_f64().unwrap();
            assert_eq!(path.len(), PATH_INTERVALS + 1);
            for sample in [1, 333, 501, PATH_INTERVALS] {
                let time = until * sample as f64 / PATH_INTERVALS as f64;
                simulation.run_until(time).unwrap();
                let wall = animation["wall_paths"][0]["wall"].as_u64().unwrap() as usize;
                let there = wall_ends(&simulation.view(), None)[wall];
                for (place, drawn) in path[sample].as_array().unwrap().iter().enumerate() {
                    let apart = drawn.as_f64().unwrap() - there[place];
                    assert!((apart - apart.round()).abs() < 1e-12, "{walls}: {apart}");
                }
            }
        };
        of(
            "[[wall]]\nx = 0.0\n[[wall]]\nx = 0.5\nmotion = { times = [0.0, 0.1, 0.2], \
            places = [[0.0, 0.0], [0.05, 0.0], [0.0, 0.0]], repeat = true }\n",
        );
        of("[[wall]]\nfrom = [0.7, 0.5]\nto = [0.8, 0.5]\nmotion = { turn = 3.0 }\n");
        of(
            "[[piston]]\ny = 0.2\nmass = 10.0\nvelocity = 2.0\nspring = 100.0\nstops = [0.15, 0.25]\n",
        );
    }

    #[test]
    fn a_packed_flight_is_the_recorded_one_to_a_hundredth_of_a_pixel() {
        let scene = Scene::from_toml(
            "[[molecule]]\nshape = \"tee\"\natom_radius = 0.02\natom_mass = 1.0\nat = [0.5, 0.5]\n\
             [[bumper]]\nradius = 0.02\nat = [0.1, 0.1]\n[[wall]]\nx = 0.0\n\
             [[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100\n",
        )
        .unwrap();
        let root = tempfile::tempdir().unwrap();
        let folder = Folder::create(root.path(), Existing::Refuse).unwrap();
        let mut simulation = AnySimulation::new(&scene).unwrap();
        record(&simulation, &folder).unwrap();
        let until = end(&simulation.view());
        let animation: Value = serde_json::from_str(&folder.read(ANIMATION).unwrap()).unwrap();
        assert_eq!(animation["watched"], 0);
        assert_eq!(animation["walls"].as_array().unwrap().len(), 1);
        assert_eq!(animation["shapes"].as_array().unwrap().len(), 3);
        let (fastest, spin) = (
            animation["fastest"].as_f64().unwrap(),
            animation["fastest_spin"].as_f64().unwrap(),
        );
        let mut packed = numbers(animation["flights"].as_str().unwrap()).into_iter();
        let table = folder.read(FLIGHTS).unwrap();
        let mut flights = 0;
        for line in table.lines().skip(1) {
            let row: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
            if row[1] == 2.0 {
                // The wall follows the molecule and the bumper.
                continue;
            }
            let mut next = |scale: f64| f64::from(packed.next().unwrap()) / LEVELS * scale;
            let number = (next(LEVELS)).round();
            assert_eq!(number, if row[1] > 2.0 { row[1] - 1.0 } else { row[1] });
            assert!((next(until) - row[0]).abs() < 4e-6 * until);
            for place in &row[2..4] {
                assert!((next(1.0) - place.rem_euclid(1.0)).abs() < 4e-6);
            }
            for velocity in &row[4..6] {
                assert!((next(2.0 * fastest) - fastest - velocity).abs() < 4e-6 * fastest);
            }
            if number == 0.0 {
                let turn = row[6] / std::f64::consts::TAU;
                assert!((next(1.0) - turn.rem_euclid(1.0)).abs() < 4e-6);
                assert!((next(2.0 * spin) - spin - row[7]).abs() < 4e-6 * spin);
            }
            flights += 1;
        }
        assert_eq!(packed.next(), None);
        // The recorded run continues unchanged: it makes as many contacts, each of which begins two
        // flights.
        simulation.run_until(until).unwrap();
        let counters = simulation.view().counters();
        assert!(counters.collisions > 100);
        let expected = 102 + 2 * counters.collisions - counters.fixed_collisions;
        assert_eq!(flights, expected);
    }

    #[test]
    fn the_animation_of_a_large_system_stays_small_and_shows_only_recorded_bodies() {
        let scene = |count: u32| {
            let radius = 0.3 / f64::from(count).sqrt();
            let gas =
                format!("[[gas]]\nradius = {radius}\nmass = 1.0\nenergy = 1.0\ncount = {count}\n");
            AnySimulation::new(&Scene::from_toml(&gas).unwrap()).unwrap()
        };
        let root = tempfile::tempdir().unwrap();
        let folder = Folder::create(root.path(), Existing::Refuse).unwrap();
        let mut simulation = scene(40_000);
        record(&simulation, &folder).unwrap();
        let (text, table) = (
            folder.read(ANIMATION).unwrap(),
            folder.read(FLIGHTS).unwrap(),
        );
        assert!(text.len() < 800_000, "{}", text.len());
        let animation: Value = serde_json::from_str(&text).unwrap();
        let number = |value: &Value| value.as_f64().unwrap();
        let [left, bottom, wide, high] = [0, 1, 2, 3].map(|n| number(&animation["window"][n]));
        let until = number(&animation["until"]);
        // Final position of each body in the animation, from its last flight.
        let mut last = BTreeMap::new();
        for line in table.lines().skip(1) {
            let row: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
            let place = DVec2::new(row[2], row[3]) + (until - row[0]) * DVec2::new(row[4], row[5]);
            last.insert(row[1] as u64, place);
        }
        assert!(last.len() <= 10_000);
        simulation.run_until(until).unwrap();
        assert!(simulation.view().counters().collisions > 10_000);
        let mut seen = 0;
        for body in simulation.view().bodies() {
            let place = body.motion.position;
            let from_corner = (place - DVec2::new(left, bottom)).rem_euclid(DVec2::ONE);
            if from_corner.x < wide && from_corner.y < high {
                seen += 1;
                let recorded = last
                    .get(&body.body.id())
                    .expect("an unrecorded body is in view");
                let off = recorded - place;
                assert!((off - off.round()).length() < 1e-9, "{off}");
            }
        }
        assert!((3500..4500).contains(&seen), "{seen}");
    }

    #[test]
    fn a_scene_without_motion_has_an_animation() {
        let scene = Scene::from_toml("[[bumper]]\nradius = 0.02\nat = [0.1, 0.1]\n").unwrap();
        let root = tempfile::tempdir().unwrap();
        let folder = Folder::create(root.path(), Existing::Refuse).unwrap();
        record(&AnySimulation::new(&scene).unwrap(), &folder).unwrap();
        let animation: Value = serde_json::from_str(&folder.read(ANIMATION).unwrap()).unwrap();
        assert_eq!(animation["watched"], Value::Null);
        assert_eq!(animation["flights"].as_str().unwrap().len(), 18);
    }

    #[test]
    fn one_molecule_is_watched_but_none_of_a_gas_of_many_sizes() {
        let gas =
            "[[gas]]\nradius = { uniform = [0.01, 0.02] }\nmass = 1.0\nenergy = 1.0\ncount = 30\n";
        let shape = |name: &str| {
            format!(
                "[[molecule]]\nshape = \"{name}\"\natom_radius = 0.03\natom_mass = 1.0\nat = [0.5, 0.5]\n"
            )
        };
        let equal = "[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 30\n";
        for (scene, expected) in [
            (gas.to_owned(), None),
            (shape("tee") + gas, Some(0)),
            (shape("disc") + equal, Some(0)),
            (equal.to_owned(), None),
        ] {
            let simulation = AnySimulation::new(&Scene::from_toml(&scene).unwrap()).unwrap();
            assert_eq!(recorded(&simulation).1.watched, expected, "{scene}");
        }
    }
}
