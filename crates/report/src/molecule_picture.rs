//! Picture of a molecule in its body frame, with the boundary of the region excluded to the centre
//! of a gas disc.

use std::fmt::Write as _;

use carom_geometry::{ExcludedRegion, Molecule};
use glam::DVec2;

use crate::{
    ink::Ink,
    svg::{Anchor, Svg},
};

/// Side of the picture (pixels).
const SIDE: f64 = 560.0;

/// Returns an SVG picture: the axes x′ and y′ of the body frame, the atoms with their letters, the
/// boundary for a probe of radius `probe` (length), and the probe touching the molecule from the
/// right.
pub fn svg(molecule: &Molecule, region: &ExcludedRegion, probe: f64) -> String {
    let reach = molecule.bounding_radius() + 2.0 * probe;
    let scale = 0.5 * SIDE / (1.06 * reach);
    let place = |point: DVec2| (0.5 * SIDE + point.x * scale, 0.5 * SIDE - point.y * scale);
    let mut svg = Svg::default();
    axes(&mut svg);
    let hidden = region.unreachable();
    for (index, atom) in molecule.atoms().iter().enumerate() {
        let (centre, radius) = (place(atom.offset()), atom.radius() * scale);
        svg.circle(centre, radius, Ink::Quiet, "area");
        // The probe never touches this atom.
        let is_hidden = hidden.contains(&index);
        let (ink, style) = if is_hidden {
            (Ink::Purple, "dashed")
        } else {
            (Ink::Quiet, "thin")
        };
        svg.circle(centre, radius, ink, style);
        let size = 0.9 * radius;
        svg.text(
            (centre.0, centre.1 + 0.35 * size),
            Anchor::Middle,
            Ink::Text,
            size,
            &name(index),
        );
    }
    for arc in region.arcs() {
        // Two halves: an SVG arc of a full turn has no direction.
        let ends = [arc.start, arc.start + 0.5 * arc.angle(), arc.end];
        let points = ends.map(|angle| place(arc.point(angle)));
        let radius = arc.radius * scale;
        let large = i32::from(0.5 * arc.angle() > std::f64::consts::PI);
        let mut path = format!("M{:.2} {:.2}", points[0].0, points[0].1);
        for (x, y) in &points[1..] {
            let _ = write!(path, " A{radius:.2} {radius:.2} 0 {large} 0 {x:.2} {y:.2}");
        }
        svg.path(&path, Ink::Vermillion, "thick");
    }
    if let Some(last) = molecule.atoms().last() {
        let centre = place(last.offset() + DVec2::new(last.radius() + probe, 0.0));
        svg.circle(centre, probe * scale, Ink::Blue, "area");
        svg.circle(centre, probe * scale, Ink::Blue, "dashed");
    }
    svg.finish((SIDE, SIDE), false)
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
