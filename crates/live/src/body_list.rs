//! The list of bodies: what a page needs to know of each body besides its place, sent when bodies
//! change.
//!
//! Layout, little-endian: `u32` 2, `u32` version, `u32` length of the JSON, `u32` number of bodies
//! n; the JSON, with spaces to a multiple of four bytes; then `u32` n numbers of bodies, `f32` n
//! sizes, `u16` n shapes, `u16` n kinds. Walls are in the JSON and are not counted as bodies.

use std::{collections::HashMap, sync::Arc};

use carom::{
    View,
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
        let (mut ids, mut sizes, mut shapes, mut kinds) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        // The shape and size of each molecule by its address: equal bodies share a molecule.
        let mut known: HashMap<usize, (u16, f32)> = HashMap::new();
        let mut shape_of: HashMap<Vec<[i64; 3]>, u16> = HashMap::new();
        let mut reach = 0.0_f64;
        for (body, kind) in view.bodies().zip(coloured_kinds(view)) {
            let kind = kind.min(MAX_KINDS);
            while head.kinds.len() <= kind {
                let names = body
                    .body
                    .tags()
                    .iter()
                    .map(|&tag| view.tag_names().name(tag));
                let name = names.collect::<Vec<_>>().join(", ");
                let (colour, fixed) = (colour(body.body, kind), body.body.is_fixed());
                head.kinds.push(KindOfBody {
                    name,
                    colour,
                    fixed,
                    count: 0,
                });
            }
            head.kinds[kind].count += 1;
            let molecule = body.body.molecule();
            if let (Some([from, to]), Some(face)) = (body.wall(), molecule.face()) {
                let drawn = [from.x, from.y, to.x, to.y, face.radius()];
                head.walls.push((
                    drawn,
                    body.body.id(),
                    body.body.wall_temperature().is_some(),
                ));
                continue;
            }
            let size = molecule.bounding_radius();
            reach = reach.max(size);
            let (shape, size) = *known
                .entry(std::ptr::from_ref(molecule).addr())
                .or_insert_with(|| {
                    let circles = drawn_circles(molecule).into_iter();
                    let circles: Vec<[f64; 3]> = circles
                        .map(|(at, radius)| [at.x / size, at.y / size, radius / size])
                        .collect();
                    let rounded = circles
                        .iter()
                        .map(|circle| circle.map(|x| (x * STEPS).round() as i64))
                        .collect();
                    let next = shape_of.len().min(MAX_KINDS) as u16;
                    let shape = *shape_of.entry(rounded).or_insert(next);
                    if usize::from(shape) == head.shapes.len() {
                        head.shapes.push(circles);
                    }
                    (shape, size as f32)
                });
            ids.push(body.body.id() as u32);
            sizes.push(size);
            shapes.push(shape);
            kinds.push(kind as u16);
        }
        let mut text = serde_json::to_vec(&head).unwrap_or_default();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut bytes = Vec::with_capacity(16 + text.len() + 12 * ids.len());
        for number in [2, version, text.len() as u32, ids.len() as u32] {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend(text);
        bytes.extend(ids.iter().flat_map(|id: &u32| id.to_le_bytes()));
        bytes.extend(sizes.iter().flat_map(|size: &f32| size.to_le_bytes()));
        bytes.extend(
            shapes
                .iter()
                .chain(&kinds)
                .flat_map(|number: &u16| number.to_le_bytes()),
        );
        let turns = head.shapes.iter().any(|circles| circles.len() > 1);
        Self {
            version,
            bytes: Arc::new(bytes),
            turns,
            reach,
        }
    }
}
