//! Picture of a molecule in its body frame, with the boundary of the region excluded to the centre
//! of a gas disc.

use std::fmt::Write as _;

use carom_geometry::{ExcludedRegion, Molecule};
use glam::DVec2;

use crate::plot::colour;

/// Side of the picture (pixels).
const SIDE: f64 = 560.0;

/// Returns an SVG picture: the axes x′ and y′ of the body frame, the atoms with their letters, the
/// boundary for a probe of radius `probe` (length), and the probe touching the molecule from the
/// right.
pub fn svg(molecule: &Molecule, region: &ExcludedRegion, probe: f64) -> String {
    let reach = molecule.bounding_radius() + 2.0 * probe;
    let scale = 0.5 * SIDE / (1.06 * reach);
    let place = |point: DVec2| DVec2::new(0.5 * SIDE + point.x * scale, 0.5 * SIDE - point.y * scale);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {SIDE} {SIDE}\" font-family=\"sans-serif\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    axes(&mut svg);
    let hex =
        |colour: plotters::style::RGBColor| format!("#{:02x}{:02x}{:02x}", colour.0, colour.1, colour.2);
    let hidden = region.unreachable();
    for (index, atom) in molecule.atoms().iter().enumerate() {
        let letter = name(index);
        // The probe never touches this atom.
        let stroke = if hidden.contains(&index) {
            format!("{}\" stroke-width=\"3\" stroke-dasharray=\"6 4", hex(colour::PURPLE))
        } else {
            "#5b636d".to_owned()
        };
        let (centre, radius) = (place(atom.offset()), atom.radius() * scale);
        let size = 0.9 * radius;
        let _ = writeln!(
            svg,
            "<circle cx=\"{0:.2}\" cy=\"{1:.2}\" r=\"{radius:.2}\" fill=\"#d9dce0\" stroke=\"{stroke}\"/>\n\
             <text x=\"{0:.2}\" y=\"{1:.2}\" font-size=\"{size:.1}\" text-anchor=\"middle\" dy=\".35em\" \
             fill=\"#1d2126\">{letter}</text>",
            centre.x, centre.y
        );
    }
    for arc in region.arcs() {
        // Two halves: an SVG arc of a full turn has no direction.
        let ends = [arc.start, arc.start + 0.5 * arc.angle(), arc.end];
        let points = ends.map(|angle| place(arc.point(angle)));
        let radius = arc.radius * scale;
        let large = i32::from(0.5 * arc.angle() > std::f64::consts::PI);
        let _ = write!(svg, "<path d=\"M{:.2} {:.2}", points[0].x, points[0].y);
        for point in &points[1..] {
            let _ = write!(svg, " A{radius:.2} {radius:.2} 0 {large} 0 {:.2} {:.2}", point.x, point.y);
        }
        let _ = writeln!(svg, "\" fill=\"none\" stroke=\"{}\" stroke-width=\"3\"/>", hex(colour::VERMILLION));
    }
    if let Some(last) = molecule.atoms().last() {
        let centre = place(last.offset() + DVec2::new(last.radius() + probe, 0.0));
        let (radius, blue) = (probe * scale, hex(colour::BLUE));
        let _ = writeln!(
            svg,
            "<circle cx=\"{:.2}\" cy=\"{:.2}\" r=\"{radius:.2}\" fill=\"{blue}\" fill-opacity=\"0.12\" \
             stroke=\"{blue}\" stroke-dasharray=\"5 4\"/>",
            centre.x, centre.y
        );
    }
    svg.push_str("</svg>\n");
    svg
}

/// Letter of an atom by its index; its number beyond the alphabet.
pub fn name(index: usize) -> String {
    ('A'..='Z').chain('a'..='z').nth(index).map_or_else(|| index.to_string(), String::from)
}

/// Arrows along x′ and y′ through the centre of mass at the centre of the picture.
fn axes(svg: &mut String) {
    let (middle, end) = (0.5 * SIDE, SIDE - 14.0);
    let _ = writeln!(
        svg,
        "<g stroke=\"#5b636d\" fill=\"none\">\
         <polyline points=\"14,{middle} {end},{middle} {0},{1} {end},{middle} {0},{2}\"/>\
         <polyline points=\"{middle},{end} {middle},14 {1},23 {middle},14 {2},23\"/></g>\n\
         <g font-size=\"18\" font-style=\"italic\" text-anchor=\"middle\">\
         <text x=\"{0}\" y=\"{3}\">x′</text><text x=\"{3}\" y=\"24\">y′</text></g>",
        end - 9.0,
        middle - 5.0,
        middle + 5.0,
        middle + 22.0
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_geometry::Shape;

    #[test]
    fn every_atom_and_every_arc_is_drawn() {
        let tee = Molecule::named(Shape::Tee, 0.005, 2.0).unwrap();
        let region = ExcludedRegion::of(&tee, 0.01).unwrap();
        let picture = svg(&tee, &region, 0.01);
        assert_eq!(picture.matches("<circle").count(), 6);
        assert_eq!(picture.matches("<path").count(), region.arcs().len());
        assert!(picture.contains(">E</text>") && !picture.contains("NaN"));
        // The probe touches every atom; a larger probe would not touch the middle atom of the stem.
        // The probe is drawn with a dashed line.
        assert_eq!(picture.matches("dasharray").count(), 1);
        let small = Molecule::named(Shape::Tee, 0.0025, 2.0).unwrap();
        let picture = svg(&small, &ExcludedRegion::of(&small, 0.01).unwrap(), 0.01);
        assert_eq!(picture.matches("dasharray").count(), 2);
    }
}
