//! The boundary of a molecule itself, as closed lines of arcs and straight sides, for drawing.

use std::fmt::Write as _;

use glam::DVec2;

use crate::{Ellipse, Molecule, boundary::Curve, excluded_region::closed_curves};

/// A piece of a [`Contour`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ContourPiece {
    /// A straight line to the next piece.
    Line {
        /// Its first point (length).
        from: DVec2,
        /// Its last point (length).
        to: DVec2,
    },
    /// An arc of a circle, counter-clockwise.
    Arc {
        /// Centre of the circle (length).
        centre: DVec2,
        /// Radius of the circle (length).
        radius: f64,
        /// Direction from the centre to the first point (radians).
        start: f64,
        /// Direction from the centre to the last point (radians, above `start`).
        end: f64,
    },
}

/// A closed line of the boundary of a molecule, in the molecule's frame.
///
/// It runs with the molecule on its left: counter-clockwise around the outside of each connected
/// part, clockwise around the holes. All contours of a molecule in one path, filled by the nonzero
/// or the even-odd rule, show the molecule.
#[derive(Debug, Clone, PartialEq)]
#[doc(alias = "outline")]
pub struct Contour {
    pieces: Vec<ContourPiece>,
}

/// Arcs with a smaller radius than this part of the bounding radius are drawn as a corner. Smaller:
/// longer pictures of polygons. Larger: roundings of corners that can be seen are lost.
const CORNER: f64 = 1e-4;

impl Molecule {
    /// The closed lines around the molecule and around its holes; none for a wall.
    ///
    /// ```
    /// use carom_geometry::{Molecule, ContourPiece};
    ///
    /// // Two half circles and two sides.
    /// let capsule = Molecule::capsule(2.0, 0.5, 1.0)?;
    /// let [contour] = &capsule.contours()[..] else { panic!("it has no holes") };
    /// let lines = contour.pieces().iter().filter(|piece| matches!(piece, ContourPiece::Line { .. }));
    /// assert_eq!((contour.pieces().len(), lines.count()), (4, 2));
    /// # Ok::<(), carom_geometry::GeometryError>(())
    /// ```
    pub fn contours(&self) -> Vec<Contour> {
        if self.is_wall() {
            return Vec::new();
        }
        if !self.ellipses().is_empty() {
            let parts = self.atoms().iter().zip(self.ellipses());
            return parts
                .map(|(atom, ellipse)| Contour::of_ellipse(atom.offset(), ellipse))
                .collect();
        }
        closed_curves(&self.union())
            .into_iter()
            .map(|line| Contour {
                pieces: line.iter().map(ContourPiece::from_curve).collect(),
            })
            .collect()
    }

    /// As [`Self::contours`], without the arcs of corners that are too small to be seen: a polygon
    /// with corners of a tiny radius has one straight line for each side.
    pub fn visible_contours(&self) -> Vec<Contour> {
        let least = CORNER * self.bounding_radius();
        let is_visible = |piece: &ContourPiece| match piece {
            ContourPiece::Line { .. } => true,
            ContourPiece::Arc { radius, .. } => *radius >= least,
        };
        let mut contours = self.contours();
        for contour in &mut contours {
            if contour.pieces.iter().any(is_visible) {
                contour.pieces.retain(is_visible);
            }
        }
        contours
    }
}

/// Sides of the polygon that is drawn for an ellipse.
const ELLIPSE_SIDES: u32 = 96;

impl Contour {
    /// A polygon through points of an ellipse.
    fn of_ellipse(centre: DVec2, ellipse: &Ellipse) -> Self {
        let points: Vec<DVec2> = ellipse
            .points(ELLIPSE_SIDES)
            .map(|point| centre + point)
            .collect();
        let next = points.iter().cycle().skip(1);
        Self {
            pieces: points
                .iter()
                .zip(next)
                .map(|(&from, &to)| ContourPiece::Line { from, to })
                .collect(),
        }
    }

    /// The pieces in order. Each begins where the one before it ends, but for corners that
    /// [`Molecule::visible_contours`] leaves out.
    pub fn pieces(&self) -> &[ContourPiece] {
        &self.pieces
    }

    /// A closed polygon through points of this contour, the next at least `apart` (length) from the
    /// one before.
    #[must_use]
    pub fn coarse(&self, apart: f64) -> Self {
        let mut kept: Vec<DVec2> = Vec::new();
        for point in self.points(1.0) {
            if kept.last().is_none_or(|last| last.distance(point) >= apart) {
                kept.push(point);
            }
        }
        let next = kept.iter().cycle().skip(1);
        let pieces = kept.iter().zip(next);
        Self {
            pieces: pieces
                .map(|(&from, &to)| ContourPiece::Line { from, to })
                .collect(),
        }
    }

    /// A closed polygon along the contour: its corners, and points of the arcs at most `step`
    /// radians apart.
    pub fn points(&self, step: f64) -> Vec<DVec2> {
        let mut points = Vec::new();
        for piece in &self.pieces {
            match *piece {
                ContourPiece::Line { from, .. } => points.push(from),
                ContourPiece::Arc { start, end, .. } => {
                    let count = ((end - start) / step).ceil().max(1.0) as usize;
                    let share = |index: usize| index as f64 / count as f64;
                    points.extend((0..count).map(|index| piece.point(share(index))));
                    // The next piece may begin elsewhere.
                    points.push(piece.point(1.0));
                }
            }
        }
        points.dedup();
        points
    }

    /// Appends the contour to the data of an SVG path.
    ///
    /// `place` moves a point of the molecule to the picture (pixels) by a rotation, a shift, a
    /// mirror that lets y point downwards, and a factor `scale` (pixels / length).
    pub fn append_to_path(&self, path: &mut String, scale: f64, place: impl Fn(DVec2) -> DVec2) {
        let mut pen = Pen { path, at: None };
        for piece in &self.pieces {
            let [from, to] = [0.0, 1.0].map(|share| place(piece.point(share)));
            pen.line_to(from);
            match piece {
                ContourPiece::Line { .. } => pen.line_to(to),
                ContourPiece::Arc { radius, .. } => {
                    // Two halves: an SVG arc of a full turn has no direction.
                    for end in [place(piece.point(0.5)), to] {
                        pen.arc_to(scale * radius, end);
                    }
                }
            }
        }
        if pen.at.is_some() {
            path.push('Z');
        }
    }
}

impl ContourPiece {
    fn from_curve(curve: &Curve) -> Self {
        match curve {
            Curve::Side(side) => Self::Line {
                from: side.start,
                to: side.end,
            },
            Curve::Arc(arc) => Self::Arc {
                centre: arc.centre,
                radius: arc.radius,
                start: arc.start,
                end: arc.end,
            },
        }
    }

    /// The point at a share of the way from the first to the last one, from 0 to 1 (length).
    pub fn point(&self, share: f64) -> DVec2 {
        match *self {
            Self::Line { from, to } => from.lerp(to, share),
            Self::Arc {
                centre,
                radius,
                start,
                end,
            } => {
                let (sin, cos) = libm::sincos(start + share * (end - start));
                centre + radius * DVec2::new(cos, sin)
            }
        }
    }
}

/// A pen that writes the data of a path to a thousandth of a pixel.
struct Pen<'a> {
    path: &'a mut String,
    /// Where it is, in thousandths of a pixel.
    at: Option<[i64; 2]>,
}

impl Pen<'_> {
    /// Draws a line to a place, or begins there.
    fn line_to(&mut self, place: DVec2) {
        let letter = if self.at.is_some() { "L" } else { "M" };
        self.move_with(letter, place);
    }

    /// Draws an arc of at most half a turn, counter-clockwise as the picture is seen.
    fn arc_to(&mut self, radius: f64, place: DVec2) {
        self.move_with(&format!("A{radius:.3} {radius:.3} 0 0 0 "), place);
    }

    fn move_with(&mut self, command: &str, place: DVec2) {
        let rounded = place.to_array().map(|x| (1000.0 * x).round() as i64);
        if self.at != Some(rounded) {
            // Writing to a string cannot fail.
            let _ = write!(self.path, "{command}{:.3} {:.3}", place.x, place.y);
            self.at = Some(rounded);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Atom, Interior};
    use std::f64::consts::PI;

    fn square(rounding: f64) -> Molecule {
        let corners = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)].map(DVec2::from);
        Molecule::polygon(&corners, rounding, 1.0).unwrap()
    }

    /// A hexagon of edges, and a disc in its middle.
    fn ring_with_disc() -> Molecule {
        let rim = (0..6).map(|k| (DVec2::from_angle(PI / 3.0 * f64::from(k)), 0.1));
        let atoms = rim.chain([(DVec2::ZERO, 0.3)]);
        let edges: Vec<_> = (0..6).map(|k| ([k, (k + 1) % 6], 0.1)).collect();
        Molecule::with_edges(
            atoms.map(|(at, radius)| Atom::new(at, radius, 1.0).unwrap()),
            &edges,
            Interior::Hollow,
        )
        .unwrap()
    }

    /// The area inside closed polygons; holes are negative.
    fn area(contours: &[Contour], step: f64) -> f64 {
        let twice = |points: Vec<DVec2>| -> f64 {
            let next = points.iter().cycle().skip(1);
            points.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum()
        };
        0.5 * contours
            .iter()
            .map(|contour| twice(contour.points(step)))
            .sum::<f64>()
    }

    #[test]
    fn contours_enclose_the_area() {
        let ell = [
            (0.0, 0.0),
            (3.0, 0.0),
            (3.0, 1.0),
            (1.0, 1.0),
            (1.0, 3.0),
            (0.0, 3.0),
        ]
        .map(DVec2::from);
        for (molecule, lines) in [
            (square(1e-6), 1),
            (square(0.2), 1),
            (Molecule::polygon(&ell, 0.1, 1.0).unwrap(), 1),
            (Molecule::capsule(2.0, 0.5, 1.0).unwrap(), 1),
            (ring_with_disc(), 3),
            (Molecule::disc(0.7, 1.0).unwrap(), 1),
        ] {
            let contours = molecule.visible_contours();
            assert_eq!(contours.len(), lines);
            let found = area(&contours, 0.002);
            assert!(
                (found / molecule.area() - 1.0).abs() < 5e-6,
                "{found} {}",
                molecule.area()
            );
        }
        let wall = Molecule::wall(DVec2::X, 0.1).unwrap();
        assert!(wall.contours().is_empty());
    }

    #[test]
    fn a_coarse_contour_has_few_points_and_nearly_the_area() {
        let gon: crate::EdgedShape = "polygon:1000".parse().unwrap();
        let gon = gon.molecule(0.001, 1e-6, 1.0).unwrap();
        let coarse: Vec<Contour> = gon
            .visible_contours()
            .iter()
            .map(|contour| contour.coarse(0.01))
            .collect();
        assert!((90..=100).contains(&coarse[0].pieces().len()));
        assert!((area(&coarse, 1.0) / gon.area() - 1.0).abs() < 2e-3);
    }

    #[test]
    fn a_path_has_the_corners_of_a_polygon_and_the_arcs_of_a_capsule() {
        let path = |molecule: &Molecule| {
            let mut path = String::new();
            for contour in molecule.visible_contours() {
                contour.append_to_path(&mut path, 10.0, |at| {
                    DVec2::new(20.0 + 10.0 * at.x, 20.0 - 10.0 * at.y)
                });
            }
            path
        };
        assert_eq!(
            path(&square(1e-6)),
            "M10.000 30.000L30.000 30.000L30.000 10.000L10.000 10.000L10.000 30.000Z"
        );
        assert_eq!(
            path(&Molecule::capsule(2.0, 0.5, 1.0).unwrap()),
            "M10.000 15.000A5.000 5.000 0 0 0 5.000 20.000A5.000 5.000 0 0 0 10.000 25.000\
             L30.000 25.000A5.000 5.000 0 0 0 35.000 20.000A5.000 5.000 0 0 0 30.000 15.000\
             L10.000 15.000Z"
        );
        assert_eq!(path(&ring_with_disc()).matches('Z').count(), 3);
    }
}
