//! The list of bodies: what a page needs to know of each body besides its place, sent when bodies
//! change.
//!
//! Layout, little-endian: `u32` 2, `u32` version, `u32` length of the JSON, `u32` number of bodies
//! n; the JSON, with spaces to a multiple of four bytes; then `u32` n numbers of bodies, `f32` n
//! sizes, `u16` n shapes, `u16` n kinds. Walls are in the JSON and are not counted as bodies.

use std::{collections::HashMap, sync::Arc};

use carom::{
    Molecule, View,
    engine::BodyView,
    observers::{colour, coloured_kinds, drawn_circles},
};
use serde::Serialize;

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
    kinds: Vec<KindOfBody>,
    /// Ends, and half the thickness (length), of each wall; its number, and whether it is heated.
    walls: Vec<([f64; 5], u64, bool)>,
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
            kinds: Vec::new(),
            walls: Vec::new(),
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
            if let (Some([from, to]), Some(face)) = (body.wall(), molecule.wall_edge()) {
                let drawn = [from.x, from.y, to.x, to.y, face.radius()];
                head.walls.push((
                    drawn,
                    body.body.id(),
                    body.body.wall_temperature().is_some(),
                ));
                continue;
            }
            reach = reach.max(molecule.bounding_radius());
            let (shape, size) = known.find(molecule, &mut head.shapes);
            listed.ids.push(body.body.id() as u32);
            listed.sizes.push(size);
            listed.shapes.push(shape);
            listed.kinds.push(kind as u16);
        }
        let turns = head.shapes.iter().any(|circles| circles.len() > 1);
        Self {
            version,
            bytes: Arc::new(listed.message(version, &head)),
            turns,
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

/// The shapes of the molecules so far.
#[derive(Debug, Default)]
struct KnownShapes {
    /// The shape and size of each molecule by its address: equal bodies share a molecule.
    of_molecule: HashMap<usize, (u16, f32)>,
    /// The number of each shape by its rounded circles.
    of_circles: HashMap<Vec<[i64; 3]>, u16>,
}

impl KnownShapes {
    /// The shape and size of a molecule; a new shape is added to the list of `shapes`.
    fn find(&mut self, molecule: &Molecule, shapes: &mut Vec<Vec<[f64; 3]>>) -> (u16, f32) {
        let address = std::ptr::from_ref(molecule).addr();
        *self.of_molecule.entry(address).or_insert_with(|| {
            let size = molecule.bounding_radius();
            let circles = drawn_circles(molecule).into_iter();
            let circles: Vec<[f64; 3]> = circles
                .map(|(at, radius)| [at.x / size, at.y / size, radius / size])
                .collect();
            let rounded = circles
                .iter()
                .map(|circle| circle.map(|x| (x * STEPS).round() as i64))
                .collect();
            let next = self.of_circles.len().min(MAX_KINDS) as u16;
            let shape = *self.of_circles.entry(rounded).or_insert(next);
            if usize::from(shape) == shapes.len() {
                shapes.push(circles);
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
