//! A picture of the system at a standby, as SVG: every atom a circle, coloured by kind, every wall a line, also where they
//! reach across a border.

use std::fmt::Write;

use carom_engine::{Body, View};
use carom_geometry::PeriodicBox;
use glam::DVec2;

use crate::kinds::kinds;

/// Colours that colour-blind readers tell apart (Okabe & Ito 2008); fixed bodies are grey.
const COLOURS: [&str; 7] = ["#56b4e9", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#0072b2", "#f0e442"];
const FIXED: &str = "#4d4d4d";
/// Walls without thickness are drawn this wide, in pixels.
const THINNEST: f64 = 1.5;

/// The system as one SVG document whose longer side is `size` pixels; y points upwards.
///
/// Each atom is drawn with its centre in the box, and again for each periodic image that reaches into it. Bodies of one
/// kind (tags, number of atoms, size, mass) share a colour and a group, titled with their tags.
///
/// ```
/// use carom_engine::{Scene, Simulation};
/// use carom_observers::picture;
///
/// // A disc across the left border is seen at the right one too.
/// let scene = Scene::from_toml("[[bumper]]\nradius = 0.1\nat = [0.05, 0.5]")?;
/// let simulation = Simulation::new(&scene)?;
/// assert_eq!(picture(&simulation.view(), 400).matches("<circle").count(), 2);
/// # Ok::<(), carom_engine::SceneError>(())
/// ```
#[doc(alias = "svg")]
pub fn picture(view: &View<'_>, size: u32) -> String {
    let sides = view.bounds().sides();
    let scale = f64::from(size.max(1)) / sides.max_element();
    let DVec2 { x: width, y: height } = sides * scale;
    let mut groups: Vec<Group> = Vec::new();
    for (body, kind) in view.bodies().zip(kinds(view)) {
        if kind == groups.len() {
            groups.push(Group { open: open_group(view, body.body, kind), circles: String::new() });
        }
        if let (Some(ends), Some(face)) = (body.wall(), body.body.molecule().face()) {
            for [from, to] in images_of_wall(ends, face.radius(), *view.bounds()) {
                let [from, to] = [from, to].map(|end| DVec2::new(end.x * scale, height - end.y * scale));
                let stroke = (2.0 * face.radius() * scale).max(THINNEST);
                write_to(
                    &mut groups[kind].circles,
                    format_args!(
                        "<line x1=\"{:.3}\" y1=\"{:.3}\" x2=\"{:.3}\" y2=\"{:.3}\" stroke=\"{FIXED}\" \
                         stroke-width=\"{stroke:.3}\" stroke-linecap=\"round\"/>\n",
                        from.x, from.y, to.x, to.y
                    ),
                );
            }
            continue;
        }
        for (centre, radius) in body.atoms() {
            for place in images(centre, radius, *view.bounds()) {
                let (x, y, r) = (place.x * scale, height - place.y * scale, radius * scale);
                write_to(
                    &mut groups[kind].circles,
                    format_args!("<circle cx=\"{x:.3}\" cy=\"{y:.3}\" r=\"{r:.3}\"/>\n"),
                );
            }
        }
    }
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.3}\" height=\"{height:.3}\" \
         viewBox=\"0 0 {width:.3} {height:.3}\">\n<title>t = {}</title>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\" stroke=\"black\"/>\n",
        view.time()
    );
    for Group { open, circles } in &groups {
        write_to(&mut svg, format_args!("{open}\n{circles}</g>\n"));
    }
    svg.push_str("</svg>\n");
    svg
}

/// The bodies of one kind.
struct Group {
    open: String,
    circles: String,
}

fn open_group(view: &View<'_>, body: &Body, kind: usize) -> String {
    let colour = if body.is_fixed() { FIXED } else { COLOURS[kind % COLOURS.len()] };
    let tags: Vec<&str> = body.tags().iter().map(|&tag| view.tag_names().name(tag)).collect();
    let title = escaped(&tags.join(", "));
    format!("<g fill=\"{colour}\" stroke=\"black\" stroke-width=\"0.3\"><title>{title}</title>")
}

/// The places in or at the box at which a circle is seen in it: first that of its centre, then those across borders.
///
/// Images one box away are enough: the engine refuses a body whose radius is longer than a side.
fn images(centre: DVec2, radius: f64, bounds: PeriodicBox) -> impl Iterator<Item = DVec2> {
    let (home, sides) = (bounds.wrap(centre).0, bounds.sides());
    [0.0, -1.0, 1.0]
        .into_iter()
        .flat_map(|y| [0.0, -1.0, 1.0].map(|x| DVec2::new(x, y)))
        .map(move |image| home + image * sides)
        .filter(move |&place| {
            let nearest = place.clamp(DVec2::ZERO, sides);
            place == home || (place - nearest).length_squared() < radius * radius
        })
}

/// The places at which a wall is seen in the box: its own, and those of images that reach into it.
fn images_of_wall(ends: [DVec2; 2], radius: f64, bounds: PeriodicBox) -> Vec<[DVec2; 2]> {
    let sides = bounds.sides();
    let (low, high) = (ends[0].min(ends[1]) - radius, ends[0].max(ends[1]) + radius);
    let (first, last) = ((-high / sides).ceil(), ((sides - low) / sides).floor());
    let mut images = Vec::new();
    for row in first.y as i64..=last.y as i64 {
        for column in first.x as i64..=last.x as i64 {
            let shift = bounds.shift([column, row]);
            // What only ends at the border is not seen on the other side; what runs along it is.
            let is_seen = (0..2).all(|axis| {
                let (from, to, side) = (low[axis] + shift[axis], high[axis] + shift[axis], sides[axis]);
                if from < to { from < side && to > 0.0 } else { (0.0..=side).contains(&from) }
            });
            if is_seen {
                images.push(ends.map(|end| end + shift));
            }
        }
    }
    images
}

/// Text that may stand in XML, whatever a tag is called.
fn escaped(text: &str) -> String {
    let plain: String = text.chars().filter(|character| !character.is_control()).collect();
    plain.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

fn write_to(text: &mut String, arguments: std::fmt::Arguments<'_>) {
    text.write_fmt(arguments).expect("writing to a string cannot fail");
}
