//! A picture of the system as SVG: every atom a circle, every body with edges a filled path,
//! coloured by kind, every wall a line, with all periodic images that reach into the box.

use std::{collections::HashMap, fmt::Write};

use carom_engine::{Body, BodyView, View};
use carom_geometry::{Contour, Molecule, PeriodicBox};
use glam::DVec2;

use crate::{coarse_atoms::drawn_circles, drawn_contours::drawn_contours, kinds::few_kinds};

/// Colours that colour-blind readers can distinguish (Okabe & Ito 2008); fixed bodies are grey. In
/// charts the curves of a kind of bodies have its colour, and predictions the last one.
const COLOURS: [&str; 7] = [
    "#0072b2", "#009e73", "#e69f00", "#cc79a7", "#56b4e9", "#f0e442", "#d55e00",
];
const FIXED: &str = "#4d4d4d";
/// Line width of walls without thickness, in pixels.
const MIN_LINE_WIDTH: f64 = 1.5;

/// Returns the system as an SVG document whose longer side is `size` pixels; y points upwards.
///
/// Each atom is drawn with its centre in the box, and again for each periodic image that reaches
/// into it. A body with straight edges is drawn as one path, with its interior if that is solid.
/// Bodies of one kind (tags, number of atoms, and, if there are few kinds, size and mass)
/// share a colour and a group, whose title lists their tags. A molecule of very many atoms is drawn
/// coarsely (see [`drawn_circles`](crate::drawn_circles())). Bonds are lines over the bodies.
///
/// ```
/// use carom_engine::{Scene, Simulation};
/// use carom_observers::picture;
///
/// // A disc across the left border also appears at the right border.
/// let scene = Scene::from_toml("[[bumper]]\nradius = 0.1\nat = [0.05, 0.5]")?;
/// let simulation = Simulation::new(&scene)?;
/// assert_eq!(picture(&simulation.view(), 400).matches("<circle").count(), 2);
/// # Ok::<(), carom_engine::SceneError>(())
/// ```
#[doc(alias = "svg")]
pub fn picture(view: &View<'_>, size: u32) -> String {
    let sides = view.bounds().sides();
    draw(
        view,
        Window {
            low: DVec2::ZERO,
            high: sides,
        },
        f64::from(size.max(1)) / sides.max_element(),
    )
}

/// Returns a square part of the system, of side `side` (length) around `centre`, as an SVG document
/// of `size` × `size` pixels.
///
/// A side that is not positive, or longer than the shorter side of the box, is replaced by the
/// latter.
///
/// ```
/// use carom_engine::{Scene, Simulation};
/// use carom_observers::close_up;
/// use glam::DVec2;
///
/// let scene = Scene::from_toml("[[bumper]]\nradius = 0.1\nat = [0.05, 0.5]\n[[bumper]]\nradius = 0.1\nat = [0.5, 0.5]")?;
/// let simulation = Simulation::new(&scene)?;
/// // Around the corner of the box there is no circle.
/// assert_eq!(close_up(&simulation.view(), DVec2::ZERO, 0.5, 200).matches("<circle").count(), 0);
/// // Near the border the disc across it appears.
/// assert_eq!(close_up(&simulation.view(), DVec2::new(0.98, 0.5), 0.2, 200).matches("<circle").count(), 1);
/// # Ok::<(), carom_engine::SceneError>(())
/// ```
pub fn close_up(view: &View<'_>, centre: DVec2, side: f64, size: u32) -> String {
    let longest = view.bounds().sides().min_element();
    let side = if side > 0.0 {
        side.min(longest)
    } else {
        longest
    };
    let (low, high) = (centre - 0.5 * side, centre + 0.5 * side);
    draw(view, Window { low, high }, f64::from(size.max(1)) / side)
}

/// The visible part of the plane, between two corners.
#[derive(Clone, Copy)]
struct Window {
    low: DVec2,
    high: DVec2,
}

impl Window {
    /// The images, as shifts in boxes, of an object between two corners that can reach into the
    /// window.
    fn images(self, low: DVec2, high: DVec2, sides: DVec2) -> impl Iterator<Item = [i64; 2]> {
        let (first, last) = (
            ((self.low - high) / sides).ceil(),
            ((self.high - low) / sides).floor(),
        );
        (first.y as i64..=last.y as i64)
            .flat_map(move |row| (first.x as i64..=last.x as i64).map(move |column| [column, row]))
    }
}

fn draw(view: &View<'_>, window: Window, scale: f64) -> String {
    let DVec2 {
        x: width,
        y: height,
    } = (window.high - window.low) * scale;
    let frame = PictureFrame {
        window,
        scale,
        bounds: view.bounds(),
    };
    let mut contours = KnownContours::default();
    let mut groups: Vec<Group> = Vec::new();
    for (body, kind) in view.bodies().zip(coloured_kinds(view)) {
        if kind == groups.len() {
            groups.push(Group {
                open: open_group(view, body.body, kind),
                elements: String::new(),
            });
        }
        let elements = &mut groups[kind].elements;
        let molecule = body.body.molecule();
        if body.body.is_wall() {
            frame.wall(&body, elements);
        } else if molecule.is_of_discs() {
            frame.circles(&body, elements);
        } else {
            frame.path(&body, contours.contours_of(molecule), elements);
        }
    }
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.3}\" height=\"{height:.3}\" \
         viewBox=\"0 0 {width:.3} {height:.3}\">\n<title>t = {}</title>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\" stroke=\"black\"/>\n",
        view.time()
    );
    for Group { open, elements } in &groups {
        write_to(&mut svg, format_args!("{open}\n{elements}</g>\n"));
    }
    let bonds = frame.bonds(view);
    if !bonds.is_empty() {
        let width = MIN_LINE_WIDTH;
        write_to(
            &mut svg,
            format_args!(
                "<g stroke=\"black\" stroke-width=\"{width}\" stroke-linecap=\"round\"><title>bonds</title>\n{bonds}</g>\n"
            ),
        );
    }
    svg.push_str("</svg>\n");
    svg
}

/// The kind of each body as pictures colour it: by tags, number of atoms, size and mass; where
/// these are more kinds than colours, bodies that differ only in size or mass are of one kind.
pub fn coloured_kinds(view: &View<'_>) -> Vec<usize> {
    few_kinds(view, COLOURS.len())
}

/// The colour of a body in CSS notation: grey if it is fixed, otherwise the colour of its kind in
/// the numbering of [`coloured_kinds`].
pub fn colour(body: &Body, kind: usize) -> &'static str {
    if body.is_fixed() {
        FIXED
    } else {
        COLOURS[kind % COLOURS.len()]
    }
}

/// The bodies of one kind.
struct Group {
    open: String,
    elements: String,
}

/// The visible part of a periodic box, and its scale (pixels / length).
#[derive(Clone, Copy)]
struct PictureFrame {
    window: Window,
    scale: f64,
    bounds: PeriodicBox,
}

impl PictureFrame {
    /// The pixel of a point; y points downwards.
    fn place_of(&self, point: DVec2) -> DVec2 {
        let place = (point - self.window.low) * self.scale;
        let height = (self.window.high - self.window.low).y * self.scale;
        DVec2::new(place.x, height - place.y)
    }

    /// Draws a wall as lines.
    fn wall(&self, body: &BodyView<'_>, elements: &mut String) {
        let Some(edge) = body.body.molecule().wall_edge() else {
            return;
        };
        let pieces = body
            .wall_segments()
            .flat_map(|ends| images_of_wall(ends, edge.radius(), self.window, self.bounds));
        for ends in pieces {
            let [from, to] = ends.map(|end| self.place_of(end));
            let stroke = (2.0 * edge.radius() * self.scale).max(MIN_LINE_WIDTH);
            write_to(
                elements,
                format_args!(
                    "<line x1=\"{:.3}\" y1=\"{:.3}\" x2=\"{:.3}\" y2=\"{:.3}\" stroke=\"{FIXED}\" \
                     stroke-width=\"{stroke:.3}\" stroke-linecap=\"round\"/>\n",
                    from.x, from.y, to.x, to.y
                ),
            );
        }
    }

    /// The bonds as lines between the tied points, over the bodies.
    fn bonds(&self, view: &View<'_>) -> String {
        let mut elements = String::new();
        for bond in view.bonds() {
            let ends = [bond.from, bond.from + bond.span];
            for ends in images_of_wall(ends, 0.0, self.window, self.bounds) {
                let [from, to] = ends.map(|end| self.place_of(end));
                write_to(
                    &mut elements,
                    format_args!(
                        "<line x1=\"{:.3}\" y1=\"{:.3}\" x2=\"{:.3}\" y2=\"{:.3}\"/>\n",
                        from.x, from.y, to.x, to.y
                    ),
                );
            }
        }
        elements
    }

    /// Draws a union of discs as circles.
    fn circles(&self, body: &BodyView<'_>, elements: &mut String) {
        let (position, rotation) = (body.motion.position, body.motion.orientation.cos_sin());
        for (offset, radius) in drawn_circles(body.body.molecule()) {
            let centre = position + rotation.rotate(offset);
            for place in images(centre, radius, self.window, self.bounds) {
                let (DVec2 { x, y }, r) = (self.place_of(place), radius * self.scale);
                write_to(
                    elements,
                    format_args!("<circle cx=\"{x:.3}\" cy=\"{y:.3}\" r=\"{r:.3}\"/>\n"),
                );
            }
        }
    }

    /// Draws a body with edges as one path.
    fn path(&self, body: &BodyView<'_>, contours: &[Contour], elements: &mut String) {
        let (position, rotation) = (body.motion.position, body.motion.orientation.cos_sin());
        let reach = body.body.molecule().bounding_radius();
        for centre in images(position, reach, self.window, self.bounds) {
            let place = |point: DVec2| self.place_of(centre + rotation.rotate(point));
            let mut path = String::new();
            for contour in contours {
                contour.append_to_path(&mut path, self.scale, place);
            }
            write_to(elements, format_args!("<path d=\"{path}\"/>\n"));
        }
    }
}

/// The contours of the molecules so far, by address: equal bodies share a molecule.
#[derive(Default)]
struct KnownContours(HashMap<usize, Vec<Contour>>);

impl KnownContours {
    fn contours_of(&mut self, molecule: &Molecule) -> &[Contour] {
        let address = std::ptr::from_ref(molecule).addr();
        self.0
            .entry(address)
            .or_insert_with(|| drawn_contours(molecule))
    }
}

fn open_group(view: &View<'_>, body: &Body, kind: usize) -> String {
    let colour = colour(body, kind);
    let tags: Vec<&str> = body
        .tags()
        .iter()
        .map(|&tag| view.tag_names().name(tag))
        .collect();
    let title = escaped(&tags.join(", "));
    format!("<g fill=\"{colour}\" stroke=\"black\" stroke-width=\"0.3\"><title>{title}</title>")
}

/// The positions of the images of a circle that are visible in the window.
fn images(
    centre: DVec2,
    radius: f64,
    window: Window,
    bounds: PeriodicBox,
) -> impl Iterator<Item = DVec2> {
    let images = window.images(centre - radius, centre + radius, bounds.sides());
    images
        .map(move |image| centre + bounds.shift(image))
        .filter(move |&place| {
            let nearest = place.clamp(window.low, window.high);
            (place - nearest).length_squared() < radius * radius
        })
}

/// The end points of the images of a wall that are visible in the window.
fn images_of_wall(
    ends: [DVec2; 2],
    radius: f64,
    window: Window,
    bounds: PeriodicBox,
) -> impl Iterator<Item = [DVec2; 2]> {
    let (low, high) = (ends[0].min(ends[1]) - radius, ends[0].max(ends[1]) + radius);
    window
        .images(low, high, bounds.sides())
        .filter_map(move |image| {
            let shift = bounds.shift(image);
            // A wall that only ends at the border is not drawn on the other side; a wall along the
            // border is.
            let is_seen = (0..2).all(|axis| {
                let (from, to) = (low[axis] + shift[axis], high[axis] + shift[axis]);
                let (first, last) = (window.low[axis], window.high[axis]);
                if from < to {
                    from < last && to > first
                } else {
                    (first..=last).contains(&from)
                }
            });
            is_seen.then(|| ends.map(|end| end + shift))
        })
}

/// Escapes arbitrary text for XML.
fn escaped(text: &str) -> String {
    let plain: String = text
        .chars()
        .filter(|character| !character.is_control())
        .collect();
    plain
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

fn write_to(text: &mut String, arguments: std::fmt::Arguments<'_>) {
    text.write_fmt(arguments)
        .expect("writing to a string cannot fail");
}
