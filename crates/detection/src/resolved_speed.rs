//! The closing speed below which rounding hides whether two touching parts close or part.

use carom_geometry::{Circle, Ellipse, Outline, Support};
use carom_kinematics::RelativeMotion;
use glam::DVec2;

use crate::{
    EdgeErrorBound, ErrorBound, Part, Touch, arc_pair::rate_error_at_arc, flight::bounding_circle,
};

/// A bound on the rounding of the closing speed of two parts that touch at time 0 (length per
/// time): E' of [`ErrorBound`] or [`EdgeErrorBound`]. `normal` is the unit vector across which they
/// touch, from A to B; it matters for ellipses, whose curvature differs from point to point.
///
/// Parts that separate faster than this certainly separate. After a contact with a lower separation
/// speed, another contact may follow at once, or none while the parts sink into each other. The
/// lemmas on contact and sinking in the source of [`Exact`](crate::Exact) give the proof.
///
/// ```
/// use carom_detection::{Touch, resolved_speed};
/// use carom_geometry::Molecule;
/// use carom_kinematics::RelativeMotion;
/// use glam::DVec2;
///
/// let disc = Molecule::disc(0.5, 1.0)?;
/// let pair = RelativeMotion::exactly(DVec2::X, DVec2::NEG_X);
/// let outline = disc.outline();
/// let resolved = resolved_speed(outline, outline, &pair, Touch::Atoms(0, 0), DVec2::X);
/// assert!(resolved > 1e-16 && resolved < 1e-14);
/// # Ok::<(), carom_geometry::GeometryError>(())
/// ```
///
/// # Panics
/// If the bodies do not have the part that `touch` names.
pub fn resolved_speed(
    a: Outline<'_>,
    b: Outline<'_>,
    motion: &RelativeMotion,
    touch: Touch,
    normal: DVec2,
) -> f64 {
    let of_circles = |circles: [Circle; 2]| {
        let speed = motion.velocity.length();
        let bound = ErrorBound::of_circles(motion, speed, motion.angular_velocity, &circles);
        bound.of_rate(0.0, circles[0].radius + circles[1].radius)
    };
    let of_edge = |body: usize, edge: u32, part: Part| {
        let (outline, other) = if body == 0 { (a, b) } else { (b, a) };
        let circle = match part {
            Part::Atom(index) => Circle::from(&outline.atoms[index as usize]),
            Part::BoundingCircle => bounding_circle(outline),
        };
        let edge = &other.edges()[edge as usize];
        match edge.bend() {
            Some(bend) => rate_error_at_arc(motion, body, &circle, edge, bend),
            None => EdgeErrorBound::new(motion, body, &circle, edge).of_rate(0.0),
        }
    };
    if !(a.ellipses().is_empty() && b.ellipses().is_empty()) {
        return of_ellipses(a, b, motion, touch, normal);
    }
    match touch {
        Touch::Atoms(i, j) => of_circles([
            Circle::from(&a.atoms[i as usize]),
            Circle::from(&b.atoms[j as usize]),
        ]),
        Touch::BoundingCircles => of_circles([a, b].map(bounding_circle)),
        Touch::EdgeOfA { edge, part } => of_edge(1, edge, part),
        Touch::EdgeOfB { edge, part } => of_edge(0, edge, part),
    }
}

/// E' of two parts of which one may be an ellipse: also of the turn of the direction in which they
/// are nearest.
fn of_ellipses(
    a: Outline<'_>,
    b: Outline<'_>,
    motion: &RelativeMotion,
    touch: Touch,
    normal: DVec2,
) -> f64 {
    let spins = motion.angular_velocity.map(f64::abs);
    let touched = |body: usize, shape: &Ellipse| {
        let outwards = if body == 0 { normal } else { -normal };
        let DVec2 { x, y } = motion.orientation[body].cos_sin();
        shape.at(DVec2::new(x, -y).rotate(outwards))
    };
    let part = |outline: Outline<'_>, atom: u32| {
        let atom_of = &outline.atoms[atom as usize];
        let round = Ellipse::round(atom_of.radius());
        let shape = outline
            .ellipses()
            .get(atom as usize)
            .copied()
            .unwrap_or(round);
        let arm = atom_of.arm() + 2.0 * shape.reach();
        let circle = Circle {
            arm,
            radius: 0.0,
            ..Circle::from(atom_of)
        };
        (circle, shape)
    };
    let of_edge = |body: usize, edge: u32, part_of_body: Part| {
        let (outline, other) = if body == 0 { (a, b) } else { (b, a) };
        let (circle, shape) = match part_of_body {
            Part::Atom(index) => part(outline, index),
            Part::BoundingCircle => (bounding_circle(outline), Ellipse::round(0.0)),
        };
        let error = EdgeErrorBound::new(motion, body, &circle, &other.edges()[edge as usize]);
        let turning = (spins[0] + spins[1]) * touched(body, &shape).bend().abs();
        error.of_rate(0.0) + 8.0 * f64::EPSILON * turning
    };
    match touch {
        Touch::Atoms(i, j) => {
            let (parts, shapes) = {
                let ((one, shape), (other, second)) = (part(a, i), part(b, j));
                ([one, other], [shape, second])
            };
            let speed = motion.velocity.length();
            let bound = ErrorBound::of_circles(motion, speed, motion.angular_velocity, &parts);
            let error = bound.at(0.0);
            let points = [0, 1].map(|body| touched(body, &shapes[body]));
            let stiffness = points[0].curvature_radius + points[1].curvature_radius;
            let bending = spins[0] * points[0].bend().abs() + spins[1] * points[1].bend().abs();
            let fast = (bound.speed() + bending) / stiffness;
            bound.rate_terms(error)[0] + (8.0 * fast + spins[0] + spins[1]) * error
        }
        Touch::BoundingCircles => {
            let circles = [a, b].map(bounding_circle);
            let speed = motion.velocity.length();
            let bound = ErrorBound::of_circles(motion, speed, motion.angular_velocity, &circles);
            bound.of_rate(0.0, circles[0].radius + circles[1].radius)
        }
        Touch::EdgeOfA { edge, part } => of_edge(1, edge, part),
        Touch::EdgeOfB { edge, part } => of_edge(0, edge, part),
    }
}
