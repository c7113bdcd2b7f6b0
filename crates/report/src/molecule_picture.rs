//! Picture of a molecule in its body frame, with the boundary of the region excluded to the centre
//! of a gas disc.

use std::fmt::Write as _;

use carom_geometry::{Atom, Contour, ExcludedRegion, ExposedArc, Molecule};
use glam::DVec2;

use crate::{
    ink::Ink,
    part_places::{PartPlaces, on_edge},
    svg::{Anchor, Svg},
};

/// Side of the picture (pixels).
const SIDE: f64 = 560.0;

/// Size of the names of atoms and edges that are too thin to hold them (pixels).
const SMALL: f64 = 13.0;

/// Most atoms of a body with edges whose atoms and edges are named. More: the names overlap.
const MAX_NAMED: usize = 32;

/// Returns an SVG picture: the axes x′ and y′ of the body frame, the atoms with their letters, the
/// boundary for a probe of radius `probe` (length), and the probe touching the molecule from the
/// right.
///
/// A molecule with straight edges is one filled area; its edges have their numbers, from 0.
pub fn svg(molecule: &Molecule, region: &ExcludedRegion, probe: f64) -> String {
    let reach = molecule.bounding_radius() + 2.0 * probe;
    let frame = BodyFrame {
        scale: 0.5 * SIDE / (1.06 * reach),
    };
    let mut svg = Svg::default();
    axes(&mut svg);
    let is_edged = !molecule.is_of_discs();
    if is_edged {
        frame.area(molecule, region, &mut svg);
        frame.names(molecule, &mut svg);
    } else {
        frame.discs(molecule, region, &mut svg);
    }
    frame.boundary(region, &mut svg);
    let touching = if is_edged {
        rightmost(region)
    } else {
        let beside = |last: &Atom| last.offset() + DVec2::new(last.radius() + probe, 0.0);
        molecule.atoms().last().map(beside)
    };
    if let Some(centre) = touching.map(|centre| frame.place(centre)) {
        svg.circle(centre, probe * frame.scale, Ink::Blue, "area");
        svg.circle(centre, probe * frame.scale, Ink::Blue, "dashed");
    }
    svg.finish((SIDE, SIDE), false)
}

/// The frame of the body, with the centre of mass at the centre of the picture.
#[derive(Clone, Copy)]
struct BodyFrame {
    /// Pixels / length.
    scale: f64,
}

impl BodyFrame {
    /// The pixel of a point.
    fn place(self, point: DVec2) -> (f64, f64) {
        (
            0.5 * SIDE + point.x * self.scale,
            0.5 * SIDE - point.y * self.scale,
        )
    }

    /// Draws a union of discs with the letters of its atoms.
    fn discs(self, molecule: &Molecule, region: &ExcludedRegion, svg: &mut Svg) {
        let hidden = region.unreachable();
        for (index, atom) in molecule.atoms().iter().enumerate() {
            let (centre, radius) = (self.place(atom.offset()), atom.radius() * self.scale);
            svg.circle(centre, radius, Ink::Quiet, "area");
            // The probe never touches this atom.
            let is_hidden = hidden.contains(&index);
            let (ink, style) = if is_hidden {
                (Ink::Purple, "dashed")
            } else {
                (Ink::Quiet, "thin")
            };
            svg.circle(centre, radius, ink, style);
            label(centre, 0.9 * radius, &name(index), svg);
        }
    }

    /// Draws a body with edges as one area, and the atoms that the probe never touches.
    fn area(self, molecule: &Molecule, region: &ExcludedRegion, svg: &mut Svg) {
        let mut path = String::new();
        for contour in molecule.visible_contours() {
            self.append(&contour, &mut path);
        }
        svg.path(&path, Ink::Quiet, "area");
        svg.path(&path, Ink::Quiet, "thin");
        for index in region.unreachable() {
            let atom = &molecule.atoms()[index];
            let radius = (atom.radius() * self.scale).max(3.0);
            svg.circle(self.place(atom.offset()), radius, Ink::Purple, "dashed");
        }
    }

    fn append(self, contour: &Contour, path: &mut String) {
        contour.append_to_path(path, self.scale, |point| self.place(point).into());
    }

    /// The letters of the atoms and the numbers of the edges of a body, in them if they are thick
    /// enough, else beside them.
    fn names(self, molecule: &Molecule, svg: &mut Svg) {
        if molecule.atoms().len() > MAX_NAMED {
            return;
        }
        let places = PartPlaces::new(molecule, 1.3 * SMALL / self.scale);
        let is_thick = |radius: f64| radius * self.scale > SMALL;
        for (index, atom) in molecule.atoms().iter().enumerate() {
            let place = if is_thick(atom.radius()) {
                atom.offset()
            } else {
                places.beside_atom(index)
            };
            let size = (0.9 * atom.radius() * self.scale).max(SMALL);
            label(self.place(place), size, &name(index), svg);
        }
        for (index, edge) in molecule.edges().iter().enumerate() {
            let place = if is_thick(edge.radius()) {
                on_edge(edge)
            } else {
                places.beside_edge(index)
            };
            label(self.place(place), SMALL, &index.to_string(), svg);
        }
    }

    /// Draws the boundary of the region: arcs, then straight sides.
    fn boundary(self, region: &ExcludedRegion, svg: &mut Svg) {
        for arc in region.arcs() {
            svg.path(&self.arc(arc), Ink::Vermillion, "thick");
        }
        for side in region.sides() {
            let ends = [side.start, side.end].map(|end| self.place(end));
            svg.line(ends, Ink::Vermillion, "thick");
        }
    }

    /// The data of a path along an arc.
    fn arc(self, arc: &ExposedArc) -> String {
        // Two halves: an SVG arc of a full turn has no direction.
        let ends = [arc.start, arc.start + 0.5 * arc.angle(), arc.end];
        let points = ends.map(|angle| self.place(arc.point(angle)));
        let radius = arc.radius * self.scale;
        let large = i32::from(0.5 * arc.angle() > std::f64::consts::PI);
        let mut path = format!("M{:.2} {:.2}", points[0].0, points[0].1);
        for (x, y) in &points[1..] {
            let _ = write!(path, " A{radius:.2} {radius:.2} 0 {large} 0 {x:.2} {y:.2}");
        }
        path
    }
}

/// A text with its middle at a place.
fn label((x, y): (f64, f64), size: f64, text: &str, svg: &mut Svg) {
    svg.text((x, y + 0.35 * size), Anchor::Middle, Ink::Text, size, text);
}

/// Of the middles of all arcs and sides, the one farthest to the right.
fn rightmost(region: &ExcludedRegion) -> Option<DVec2> {
    let arcs = region
        .arcs()
        .iter()
        .map(|arc| arc.point(arc.start + 0.5 * arc.angle()));
    let sides = region
        .sides()
        .iter()
        .map(|side| side.start.midpoint(side.end));
    arcs.chain(sides).max_by(|a, b| a.x.total_cmp(&b.x))
}

/// Letter of an atom by its index; its number beyond the alphabet.
pub fn name(index: usize) -> String {
    ('A'..='Z')
        .chain('a'..='z')
        .nth(index)
        .map_or_else(|| index.to_string(), String::from)
}

/// Arrows along x′ and y′ through the centre of mass at the centre of the picture.
fn axes(svg: &mut Svg) {
    let (middle, end) = (0.5 * SIDE, SIDE - 14.0);
    let along = [
        (14.0, middle),
        (end, middle),
        (end - 9.0, middle - 5.0),
        (end, middle),
        (end - 9.0, middle + 5.0),
    ];
    svg.line(along, Ink::Quiet, "thin");
    svg.line(along.map(|(x, y)| (y, SIDE - x)), Ink::Quiet, "thin");
    for (place, name) in [
        ((end - 9.0, middle + 22.0), "x′"),
        ((middle + 22.0, 24.0), "y′"),
    ] {
        svg.text(place, Anchor::Middle, Ink::Text, 18.0, name);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_geometry::Shape;

    #[test]
    fn a_polygon_is_one_area_with_straight_sides_around_it() {
        let corners = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)].map(DVec2::from);
        let square = Molecule::polygon(&corners, 1e-6, 1.0).unwrap();
        let region = ExcludedRegion::new(&square, 0.5).unwrap();
        let picture = svg(&square, &region, 0.5);
        let scale = 0.5 * SIDE / (1.06 * (square.bounding_radius() + 1.0));
        let [low, high] = [280.0 - scale, 280.0 + scale];
        // Area and outline.
        for corner in [[low, low], [low, high], [high, low], [high, high]] {
            let corner = format!("{:.3} {:.3}", corner[0], corner[1]);
            assert!(
                picture.matches(&corner).count() >= 2,
                "{corner} in {picture}"
            );
        }
        let sides = region.sides().len();
        assert_eq!(
            (sides, picture.matches("vermillion thick").count()),
            (4, 4 + 4)
        );
        // The probe, but no atom.
        assert_eq!(picture.matches("<circle").count(), 2);
        assert!(picture.contains(">D</text>") && picture.contains(">3</text>"));
    }

    #[test]
    fn every_atom_and_every_arc_is_drawn() {
        let tee = Molecule::named(Shape::Tee, 0.005, 2.0).unwrap();
        let region = ExcludedRegion::new(&tee, 0.01).unwrap();
        let picture = svg(&tee, &region, 0.01);
        let drawn = |picture: &str, element: &str| {
            picture[picture.find("</style>").unwrap()..]
                .matches(element)
                .count()
        };
        // An area and an outline for each of five atoms and for the probe.
        assert_eq!(drawn(&picture, "<circle"), 12);
        assert_eq!(drawn(&picture, " A"), 2 * region.arcs().len());
        assert!(picture.contains(">E</text>") && !picture.contains("NaN"));
        // The probe touches every atom; a larger probe would not touch the middle atom of the stem.
        assert_eq!(drawn(&picture, "dashed"), 1);
        let small = Molecule::named(Shape::Tee, 0.0025, 2.0).unwrap();
        let picture = svg(&small, &ExcludedRegion::new(&small, 0.01).unwrap(), 0.01);
        assert_eq!(drawn(&picture, "dashed"), 2);
    }
}
