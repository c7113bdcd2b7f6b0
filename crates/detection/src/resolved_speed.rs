//! The closing speed below which rounding hides whether two touching parts close or part.

use carom_geometry::{Circle, Outline};
use carom_kinematics::RelativeMotion;

use crate::{EdgeErrorBound, ErrorBound, Part, Touch, flight::bounding_circle};

/// A bound on the rounding of the closing speed of two parts that touch at time 0 (length per
/// time): E' of [`ErrorBound`] or [`EdgeErrorBound`].
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
/// let resolved = resolved_speed(disc.outline(), disc.outline(), &pair, Touch::Atoms(0, 0));
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
        EdgeErrorBound::new(motion, body, &circle, edge).of_rate(0.0)
    };
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
