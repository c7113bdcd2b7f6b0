//! Two molecules at one time, seen from the centre of the first, with their bounding circles.

use std::fmt::Write as _;

use carom_geometry::Contour;
use glam::DVec2;

use crate::{ink::Ink, panels::WIDTH};

/// A circle: centre and radius (length).
pub type Disc = (DVec2, f64);

/// Two molecules at one time.
#[derive(Debug, Clone)]
pub struct DrawnPose {
    /// What is shown, in a line or two.
    pub label: [String; 2],
    /// The atoms of A and B; none of a body that has contours.
    pub atoms: [Vec<Disc>; 2],
    /// The contours of A and B, if they have straight edges, in the frame of the body.
    pub contours: [Vec<Contour>; 2],
    /// Cosine and sine of the orientations of A and B, for their contours.
    pub rotations: [DVec2; 2],
    /// Their bounding circles.
    pub circles: [Disc; 2],
    /// Velocity of B relative to A; only its direction is drawn.
    pub velocity: DVec2,
}

/// Height of a row of pictures with their labels (pixels).
pub const HEIGHT: f64 = 252.0;

/// Side of a picture (pixels).
const SIDE: f64 = 200.0;

/// Space for the names of the bodies around the circles (pixels).
const NAME: f64 = 18.0;

/// Draws up to three poses side by side, each in a scale of its own, as SVG elements of the height
/// [`HEIGHT`].
pub fn row(poses: &[DrawnPose]) -> String {
    let pitch = (WIDTH - 32.0) / 3.0;
    let mut svg = String::new();
    for (index, pose) in poses.iter().enumerate() {
        let middle = 16.0 + pitch * (index as f64 + 0.5);
        draw(pose, DVec2::new(middle, 4.0 + 0.5 * SIDE), &mut svg);
        for (line, text) in pose.label.iter().enumerate() {
            let _ = writeln!(
                svg,
                "<text x=\"{middle:.1}\" y=\"{:.1}\" font-size=\"14\" text-anchor=\"middle\" \
                 {}>{text}</text>",
                SIDE + 22.0 + 18.0 * line as f64,
                Ink::Quiet.drawn("fill")
            );
        }
    }
    svg
}

fn draw(pose: &DrawnPose, middle: DVec2, svg: &mut String) {
    // The rectangle that holds both bounding circles.
    let [low, high] = pose.circles.iter().fold(
        [DVec2::INFINITY, DVec2::NEG_INFINITY],
        |[low, high], (centre, radius)| [low.min(*centre - *radius), high.max(*centre + *radius)],
    );
    let scale = (SIDE - 2.0 * NAME) / (high - low).max_element();
    let centre = 0.5 * (low + high);
    let place = |point: DVec2| middle + DVec2::new(point.x - centre.x, centre.y - point.y) * scale;
    for (body, (name, ink)) in [("A", Ink::Blue), ("B", Ink::Vermillion)]
        .into_iter()
        .enumerate()
    {
        let mut disc = |(point, radius): Disc, style: &str, least: f64| {
            let at = place(point);
            let _ = writeln!(
                svg,
                "<circle cx=\"{:.2}\" cy=\"{:.2}\" r=\"{:.2}\" {}/>",
                at.x,
                at.y,
                (radius * scale).max(least),
                ink.drawn(style)
            );
        };
        disc(pose.circles[body], "dashed", 0.0);
        for &atom in &pose.atoms[body] {
            disc(atom, "area", 1.0);
            disc(atom, "thin", 1.0);
        }
        let turned =
            |point: DVec2| place(pose.circles[body].0 + pose.rotations[body].rotate(point));
        let mut path = String::new();
        for contour in &pose.contours[body] {
            contour.append_to_path(&mut path, scale, turned);
        }
        for style in ["area", "thin"].iter().filter(|_| !path.is_empty()) {
            let _ = writeln!(svg, "<path d=\"{path}\" {}/>", ink.drawn(style));
        }
        let (at, radius) = (place(pose.circles[body].0), pose.circles[body].1 * scale);
        // Beside the circle, on the side away from the other body.
        let away = (at - place(pose.circles[1 - body].0)).normalize_or(DVec2::NEG_Y);
        let at = at + away * (radius + 0.6 * NAME);
        let _ = writeln!(
            svg,
            "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"15\" text-anchor=\"middle\" {}>{name}</text>",
            at.x,
            at.y + 5.0,
            ink.drawn("fill")
        );
    }
    arrow(place(pose.circles[1].0), pose.velocity, svg);
}

/// An arrow of fixed length from the centre of B.
fn arrow(from: DVec2, velocity: DVec2, svg: &mut String) {
    let Some(along) = DVec2::new(velocity.x, -velocity.y).try_normalize() else {
        return;
    };
    let to = from + 34.0 * along;
    let [left, right] = [along.perp(), -along.perp()].map(|side| to - 8.0 * along + 4.5 * side);
    let _ = writeln!(
        svg,
        "<path d=\"M{:.1} {:.1}L{:.1} {:.1}M{:.1} {:.1}L{2:.1} {3:.1}L{:.1} {:.1}\" {}/>",
        from.x,
        from.y,
        to.x,
        to.y,
        left.x,
        left.y,
        right.x,
        right.y,
        Ink::Text.drawn("thin")
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_square_is_a_path_through_its_corners() {
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(DVec2::from);
        let square = carom_geometry::Molecule::polygon(&corners, 1e-6, 1.0).unwrap();
        let reach = square.bounding_radius();
        let pose = DrawnPose {
            label: [String::new(), String::new()],
            atoms: [Vec::new(), vec![(DVec2::new(4.0 * reach, 0.0), 1.0)]],
            contours: [square.visible_contours(), Vec::new()],
            rotations: [DVec2::from_angle(std::f64::consts::FRAC_PI_4), DVec2::X],
            circles: [(DVec2::ZERO, reach), (DVec2::new(4.0 * reach, 0.0), reach)],
            velocity: DVec2::NEG_X,
        };
        let svg = row(&[pose]);
        // Two circles and the disc; the square with its corners on the axes.
        assert_eq!(
            (
                svg.matches("<circle").count(),
                svg.matches("blue area").count()
            ),
            (2 + 2, 1)
        );
        let path = svg.split("<path d=\"").nth(1).unwrap();
        let path = path.split('"').next().unwrap();
        assert_eq!(
            (path.matches('L').count(), path.matches('Z').count()),
            (4, 1)
        );
        let ys: Vec<f64> = path
            .trim_end_matches('Z')
            .split(['M', 'L'])
            .skip(1)
            .map(|corner| corner.split(' ').nth(1).unwrap().parse().unwrap())
            .collect();
        let extent = (SIDE - 2.0 * NAME) / 6.0;
        for y in ys {
            let off = (y - (4.0 + 0.5 * SIDE)).abs();
            assert!(off < 0.01 || (off - extent).abs() < 0.01, "{path}");
        }
    }

    #[test]
    fn all_atoms_and_circles_are_inside_the_row() {
        let pose = DrawnPose {
            label: ["start".to_owned(), "t = 0".to_owned()],
            atoms: [
                vec![(DVec2::ZERO, 1.0)],
                vec![(DVec2::new(1e6, 3.0), 1.0), (DVec2::new(1e6, 1.0), 1.0)],
            ],
            contours: [Vec::new(), Vec::new()],
            rotations: [DVec2::X; 2],
            circles: [(DVec2::ZERO, 1.0), (DVec2::new(1e6, 2.0), 2.0)],
            velocity: DVec2::NEG_X,
        };
        let svg = row(&[pose.clone(), pose.clone(), pose]);
        assert_eq!(svg.matches("<circle").count(), 3 * (2 + 2 * 3));
        assert!(!svg.contains("NaN"));
        for part in svg.split("cx=\"").skip(1) {
            let x: f64 = part.split('"').next().unwrap().parse().unwrap();
            assert!((0.0..WIDTH).contains(&x), "{x}");
        }
    }
}
