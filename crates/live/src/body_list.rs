//! The list of bodies: what a page needs to know of each body besides its place, sent when bodies
//! change.
//!
//! Layout, little-endian: `u32` 2, `u32` version, `u32` length of the JSON, `u32` number of bodies
//! n; the JSON, with spaces to a multiple of four bytes; then `u32` n numbers of bodies, `f32` n
//! sizes, `u16` n shapes, `u16` n kinds. Walls are in the JSON and are not counted as bodies.

use std::{
    collections::{BTreeMap, HashMap},
    sync::Arc,
};

use carom::{
    Molecule, View,
    engine::BodyView,
    geometry::{Contour, Interior},
    observers::{colour, coloured_kinds, drawn_bonds, drawn_circles, drawn_contours},
};
use glam::DVec2;
use serde::Serialize;

use crate::triangles::triangles;

/// Steps of a length in a shape of size 1 that are distinguished: far below a pixel.
const STEPS: f64 = 1e6;

/// Largest number of shapes and of kinds that are distinguished.
const MAX_KINDS: usize = u16::MAX as usize;

/// The list at one time.
#[derive(Debug)]
pub struct BodyList {
    /// Its number: frames have that of the list that they belong to.
    pub version: u32,
    /// The message.
    pub bytes: Arc<Vec<u8>>,
    /// Whether a shape has an orientation.
    pub turns: bool,
    /// Ends of each wall when the list was made (length).
    pub walls: Vec<[DVec2; 2]>,
    /// Bounding radius of the largest body (length).
    pub reach: f64,
}

#[derive(Debug, Serialize)]
struct Head<'a> {
    scene: &'a str,
    sides: [f64; 2],
    /// The method, if it is not exact.
    method: Option<String>,
    /// Circles of each shape: place and radius, in units of the size of the body.
    shapes: Vec<Vec<[f64; 3]>>,
    /// How each shape with straight edges is drawn in place of its circles, by its number.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    outlines: BTreeMap<u16, ShapeOutline>,
    kinds: Vec<KindOfBody>,
    /// Ends, and half the thickness (length), of each wall when the list was made; its number, and
    /// whether it is heated. Once a wall has moved, frames have their ends.
    walls: Vec<([f64; 5], u64, bool)>,
    /// Bonds: two bodies by their places in the list, and the tied points of each in its frame
    /// (length).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    bonds: Vec<([u32; 2], [f64; 4])>,
}

#[derive(Debug, Serialize)]
struct KindOfBody {
    name: String,
    colour: &'static str,
    fixed: bool,
    count: usize,
}

impl BodyList {
    /// The list of the bodies of a view.
    pub fn new(version: u32, scene: &str, method: Option<String>, view: &View<'_>) -> Self {
        let mut head = Head {
            scene,
            sides: view.bounds().sides().to_array(),
            method,
            shapes: Vec::new(),
            outlines: BTreeMap::new(),
            kinds: Vec::new(),
            walls: Vec::new(),
            bonds: Vec::new(),
        };
        let (mut listed, mut known) = (ListedBodies::default(), KnownShapes::default());
        let mut reach = 0.0_f64;
        for (body, kind) in view.bodies().zip(coloured_kinds(view)) {
            let kind = kind.min(MAX_KINDS);
            while head.kinds.len() <= kind {
                head.kinds.push(KindOfBody::new(&body, kind, view));
            }
            head.kinds[kind].count += 1;
            let molecule = body.body.molecule();
            if let Some(edge) = molecule.wall_edge() {
                let is_heated = body.body.wall_temperature().is_some();
                for [from, to] in body.wall_segments() {
                    let drawn = [from.x, from.y, to.x, to.y, edge.radius()];
                    head.walls.push((drawn, body.body.id(), is_heated));
                }
                continue;
            }
            reach = reach.max(molecule.bounding_radius());
            let (shape, size) = known.find(molecule, &mut head);
            listed.ids.push(body.body.id() as u32);
            listed.sizes.push(size);
            listed.shapes.push(shape);
            listed.kinds.push(kind as u16);
        }
        head.bonds = drawn_bonds(view, |name| {
            let place = listed.ids.binary_search(&(name as u32));
            place.ok().map(|place| place as u32)
        });
        let walls = head
            .walls
            .iter()
            .map(|([x1, y1, x2, y2, _], ..)| [DVec2::new(*x1, *y1), DVec2::new(*x2, *y2)]);
        let walls = walls.collect();
        let turns = head.shapes.iter().any(|circles| circles.len() > 1);
        Self {
            version,
            bytes: Arc::new(listed.message(version, &head)),
            turns,
            walls,
            reach,
        }
    }
}

impl KindOfBody {
    /// The kind of this number, with the name and the colour of its first body, and no bodies yet.
    fn new(body: &BodyView<'_>, number: usize, view: &View<'_>) -> Self {
        let names = body
            .body
            .tags()
            .iter()
            .map(|&tag| view.tag_names().name(tag));
        Self {
            name: names.collect::<Vec<_>>().join(", "),
            colour: colour(body.body, number),
            fixed: body.body.is_fixed(),
            count: 0,
        }
    }
}

/// Closed lines around a shape, and triangles that fill it, in units of the size of the body.
#[derive(Debug, Serialize)]
struct ShapeOutline {
    /// Corners of each line.
    lines: Vec<Vec<[f64; 2]>>,
    /// Corners of the triangles, three by three.
    triangles: Vec<[f64; 2]>,
}

/// Angle between two corners on a round part of an outline (radians). Larger: corners that can be
/// seen at the largest magnification of a body as wide as the page.
const ARC_STEP: f64 = 0.05;

impl ShapeOutline {
    /// The outline of a molecule of this size (length); `None` for a union of discs.
    fn new(molecule: &Molecule, size: f64) -> Option<Self> {
        let contours = drawn_contours(molecule);
        let unit = |points: Vec<DVec2>| points.into_iter().map(|at| at / size).collect();
        let lines: Vec<Vec<DVec2>> = contours
            .iter()
            .map(|contour: &Contour| unit(contour.points(ARC_STEP)))
            .collect();
        let short = |at: &DVec2| at.to_array().map(|x| (x * STEPS).round() / STEPS);
        (!lines.is_empty()).then(|| Self {
            triangles: triangles(&lines).iter().map(short).collect(),
            lines: lines
                .iter()
                .map(|line| line.iter().map(short).collect())
                .collect(),
        })
    }
}

/// The circles of a shape, rounded; of each of its edges the atoms at the ends and the radius,
/// rounded; and whether its interior is hollow.
type ShapeKey = (Vec<[i64; 3]>, Vec<([u32; 2], i64)>, bool);

/// The shapes of the molecules so far.
#[derive(Debug, Default)]
struct KnownShapes {
    /// The shape and size of each molecule by its address: equal bodies share a molecule.
    of_molecule: HashMap<usize, (u16, f32)>,
    /// The number of each shape.
    of_key: HashMap<ShapeKey, u16>,
}

impl KnownShapes {
    /// The shape and size of a molecule; a new shape is added to the `head`.
    fn find(&mut self, molecule: &Molecule, head: &mut Head<'_>) -> (u16, f32) {
        let address = std::ptr::from_ref(molecule).addr();
        *self.of_molecule.entry(address).or_insert_with(|| {
            let size = molecule.bounding_radius();
            let circles = drawn_circles(molecule).into_iter();
            let circles: Vec<[f64; 3]> = circles
                .map(|(at, radius)| [at.x / size, at.y / size, radius / size])
                .collect();
            let rounded = |x: f64| (x * STEPS).round() as i64;
            let edges = molecule.edges().iter();
            let key = (
                circles.iter().map(|circle| circle.map(rounded)).collect(),
                edges
                    .filter_map(|edge| Some((edge.ends()?, rounded(edge.radius() / size))))
                    .collect(),
                molecule.interior() == Interior::Hollow,
            );
            let next = self.of_key.len().min(MAX_KINDS) as u16;
            let shape = *self.of_key.entry(key).or_insert(next);
            if usize::from(shape) == head.shapes.len() {
                head.shapes.push(circles);
                let outline = ShapeOutline::new(molecule, size);
                head.outlines
                    .extend(outline.map(|outline| (shape, outline)));
            }
            (shape, size as f32)
        })
    }
}

/// What is sent of each body that is no wall.
#[derive(Debug, Default)]
struct ListedBodies {
    ids: Vec<u32>,
    sizes: Vec<f32>,
    shapes: Vec<u16>,
    kinds: Vec<u16>,
}

impl ListedBodies {
    /// The message with these bodies, in the layout that is described above.
    fn message(&self, version: u32, head: &Head<'_>) -> Vec<u8> {
        let mut text = serde_json::to_vec(head).unwrap_or_default();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut bytes = Vec::with_capacity(16 + text.len() + 12 * self.ids.len());
        for number in [2, version, text.len() as u32, self.ids.len() as u32] {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend(text);
        bytes.extend(self.ids.iter().flat_map(|id| id.to_le_bytes()));
        bytes.extend(self.sizes.iter().flat_map(|size| size.to_le_bytes()));
        let numbers = self.shapes.iter().chain(&self.kinds);
        bytes.extend(numbers.flat_map(|number| number.to_le_bytes()));
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::Scene;
    use carom_methods::AnySimulation;
    use serde_json::Value;

    /// The JSON of the list of a scene's bodies.
    fn head(scene: &str) -> Value {
        let simulation = AnySimulation::new(&Scene::from_toml(scene).unwrap()).unwrap();
        let list = BodyList::new(1, "two", None, &simulation.view());
        let length = u32::from_le_bytes(list.bytes[8..12].try_into().unwrap()) as usize;
        serde_json::from_slice(&list.bytes[16..16 + length]).unwrap()
    }

    const DISC: &str =
        "[[molecule]]\nshape = \"disc\"\natom_radius = 0.02\natom_mass = 1.0\nat = [0.7, 0.2]\n";

    #[test]
    fn shapes_with_edges_have_outlines_and_triangles() {
        let square = "[[molecule]]\nshape = \"square\"\nsize = 0.1\nmass = 1.0\nat = [0.3, 0.5]\n";
        let head = head(&format!("{square}{DISC}"));
        let outlines = head["outlines"].as_object().unwrap();
        assert_eq!(outlines.len(), 1);
        let lines = &outlines["0"]["lines"][0];
        assert_eq!(lines.as_array().unwrap().len(), 4);
        let half = 0.5f64.sqrt();
        for corner in lines.as_array().unwrap() {
            for axis in 0..2 {
                assert!((corner[axis].as_f64().unwrap().abs() - half).abs() < 1e-5);
            }
        }
        assert_eq!(outlines["0"]["triangles"].as_array().unwrap().len(), 2 * 3);
    }

    #[test]
    fn bonds_name_bodies_by_their_places_in_the_list() {
        let bonds = "[[wall]]\nx = 0.0\n[[bond]]\npairs = [[1, 0]]\ntether = { max = 0.3 }\n";
        let other = DISC.replace("0.7, 0.2", "0.6, 0.2");
        let listed = head(&format!("{bonds}{DISC}{other}"))["bonds"].clone();
        assert_eq!(listed, serde_json::json!([[[0, 1], [0.0, 0.0, 0.0, 0.0]]]));
        assert!(head(DISC).get("bonds").is_none());
    }

    #[test]
    fn a_solid_and_a_hollow_body_of_the_same_corners_are_two_shapes_and_discs_have_no_outline() {
        let atom = |x: f64, y: f64| format!("{{ at = [{x}, {y}], radius = 0.01, mass = 1.0 }}");
        let atoms = [(0.0, 0.0), (0.2, 0.0), (0.2, 0.2), (0.0, 0.2)]
            .map(|(x, y)| atom(x, y))
            .join(", ");
        let ring =
            format!("[[molecule]]\natoms = [{atoms}]\nedges = [[0, 1], [1, 2], [2, 3], [3, 0]]\n");
        let both = head(&format!(
            "{ring}at = [0.3, 0.5]\n{ring}hollow = true\nat = [0.7, 0.5]\n"
        ));
        let lines = |shape: &str| both["outlines"][shape]["lines"].as_array().unwrap().len();
        assert_eq!([lines("0"), lines("1")], [1, 2]);
        assert!(head(DISC).get("outlines").is_none());
    }
}
