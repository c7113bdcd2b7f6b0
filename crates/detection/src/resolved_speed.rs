//! The closing speed below which rounding hides whether two touching parts close or part.

use carom_geometry::{Circle, Ellipse, Outline, Support, SupportPoint};
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
        let ellipses = EllipseTouch {
            bodies: [a, b],
            motion,
            normal,
            spins: motion.angular_velocity.map(f64::abs),
        };
        return ellipses.rate_error(touch);
    }
    match touch {
        Touch::Atoms(i, j) => {
            let atoms = [&a.atoms[i as usize], &b.atoms[j as usize]];
            of_circles(motion, atoms.map(Circle::from))
        }
        Touch::BoundingCircles => of_circles(motion, [a, b].map(bounding_circle)),
        Touch::EdgeOfA { edge, part } => of_edge(1, edge, part),
        Touch::EdgeOfB { edge, part } => of_edge(0, edge, part),
    }
}

/// E' of two circles.
fn of_circles(motion: &RelativeMotion, circles: [Circle; 2]) -> f64 {
    let speed = motion.velocity.length();
    let bound = ErrorBound::of_circles(motion, speed, motion.angular_velocity, &circles);
    bound.of_rate(0.0, circles[0].radius + circles[1].radius)
}

/// Two bodies that touch, of which one has ellipses: E' is also that of the turn of the direction
/// in which two parts are nearest.
struct EllipseTouch<'a> {
    bodies: [Outline<'a>; 2],
    motion: &'a RelativeMotion,
    /// From A to B.
    normal: DVec2,
    /// Magnitudes of the angular velocities (radians per time).
    spins: [f64; 2],
}

impl EllipseTouch<'_> {
    fn rate_error(&self, touch: Touch) -> f64 {
        match touch {
            Touch::Atoms(i, j) => self.of_atoms([i, j]),
            Touch::BoundingCircles => of_circles(self.motion, self.bodies.map(bounding_circle)),
            Touch::EdgeOfA { edge, part } => self.of_edge(1, edge, part),
            Touch::EdgeOfB { edge, part } => self.of_edge(0, edge, part),
        }
    }

    fn of_atoms(&self, atoms: [u32; 2]) -> f64 {
        let [(one, first), (other, second)] = [0, 1].map(|body| self.atom(body, atoms[body]));
        let (motion, spins) = (self.motion, self.spins);
        let speed = motion.velocity.length();
        let bound = ErrorBound::of_circles(motion, speed, motion.angular_velocity, &[one, other]);
        let error = bound.at(0.0);
        let points = [self.touched(0, &first), self.touched(1, &second)];
        let stiffness = points[0].curvature_radius + points[1].curvature_radius;
        let bending = spins[0] * points[0].bend().abs() + spins[1] * points[1].bend().abs();
        let fast = (bound.speed() + bending) / stiffness;
        bound.rate_terms(error)[0] + (8.0 * fast + spins[0] + spins[1]) * error
    }

    /// E' of a part of one body and an edge of the other.
    fn of_edge(&self, body: usize, edge: u32, part: Part) -> f64 {
        let (circle, shape) = match part {
            Part::Atom(index) => self.atom(body, index),
            Part::BoundingCircle => (bounding_circle(self.bodies[body]), Ellipse::round(0.0)),
        };
        let edge = &self.bodies[1 - body].edges()[edge as usize];
        let error = EdgeErrorBound::new(self.motion, body, &circle, edge);
        let turning = (self.spins[0] + self.spins[1]) * self.touched(body, &shape).bend().abs();
        error.of_rate(0.0) + 8.0 * f64::EPSILON * turning
    }

    /// An atom as the point at its centre, with the lever of all its points, and its shape.
    fn atom(&self, body: usize, atom: u32) -> (Circle, Ellipse) {
        let outline = self.bodies[body];
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
    }

    /// The point of a shape of a body that touches the other body.
    fn touched(&self, body: usize, shape: &Ellipse) -> SupportPoint {
        let outwards = if body == 0 { self.normal } else { -self.normal };
        let DVec2 { x, y } = self.motion.orientation[body].cos_sin();
        shape.at(DVec2::new(x, -y).rotate(outwards))
    }
}
