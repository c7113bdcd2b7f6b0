//! The squared gap f(t) = |d|² − s² of two atoms in flight, or of an atom and an edge: positive
//! while they are apart.

use carom_geometry::{Atom, Circle, Edge, Outline};
use carom_kinematics::RelativeMotion;
use glam::DVec2;

use crate::{EdgeErrorBound, ErrorBound, Part, Touch};

/// Two parts whose centres are d apart and touch at the distance s: an atom of A and an atom of B,
/// or an atom and the nearest point of an edge.
pub(crate) struct SquaredGap<'a> {
    motion: &'a RelativeMotion,
    offsets: [DVec2; 2],
    /// The body with the edge, if there is one.
    edge: Option<(usize, &'a Edge)>,
    /// Sum of the radii, s.
    contact_distance: f64,
    error: Bound,
}

#[derive(Clone, Copy)]
enum Bound {
    Atoms(ErrorBound),
    Edge(EdgeErrorBound),
}

impl Bound {
    fn at(&self, time: f64) -> f64 {
        match self {
            Self::Atoms(bound) => bound.at(time),
            Self::Edge(bound) => bound.at(time),
        }
    }
}

/// All pairs of parts of two bodies: atoms with atoms, then atoms with edges.
pub(crate) fn all_pairs<'a>(
    a: Outline<'a>,
    b: Outline<'a>,
    motion: &'a RelativeMotion,
) -> impl Iterator<Item = (Touch, SquaredGap<'a>)> {
    let indexed = |atoms: &'a [Atom]| (0u32..).zip(atoms);
    let atoms = indexed(a.atoms).flat_map(move |(i, atom_a)| {
        indexed(b.atoms)
            .map(move |(j, atom_b)| (Touch::Atoms(i, j), SquaredGap::new(motion, atom_a, atom_b)))
    });
    let edges = [(0, a, b), (1, b, a)]
        .into_iter()
        .flat_map(move |(body, outline, other)| {
            (0..).zip(other.edges()).flat_map(move |(number, edge)| {
                indexed(outline.atoms).map(move |(index, atom)| {
                    let touch = Touch::edge(body, number, Part::Atom(index));
                    (touch, SquaredGap::of_edge(motion, body, atom, edge))
                })
            })
        });
    atoms.chain(edges)
}

impl<'a> SquaredGap<'a> {
    fn new(motion: &'a RelativeMotion, a: &Atom, b: &Atom) -> Self {
        Self {
            motion,
            offsets: [a.offset(), b.offset()],
            edge: None,
            contact_distance: a.radius() + b.radius(),
            error: Bound::Atoms(ErrorBound::new(motion, a, b)),
        }
    }

    /// An atom of body number `body` and an edge of the other body.
    fn of_edge(motion: &'a RelativeMotion, body: usize, atom: &Atom, edge: &'a Edge) -> Self {
        let mut offsets = [DVec2::ZERO; 2];
        offsets[body] = atom.offset();
        let error = EdgeErrorBound::new(motion, body, &Circle::from(atom), edge);
        Self {
            motion,
            offsets,
            edge: Some((1 - body, edge)),
            contact_distance: atom.radius() + edge.radius(),
            error: Bound::Edge(error),
        }
    }

    /// f at `time` (length²).
    pub(crate) fn at(&self, time: f64) -> f64 {
        let [arm_a, arm_b] = self.arms(time);
        let d = self.between_centres(time, arm_a, arm_b);
        let squared = match self.edge {
            Some(edge) => {
                let (distance, _) = self.to_edge(edge, d, time);
                distance * distance.abs()
            }
            None => d.length_squared(),
        };
        squared - self.contact_distance * self.contact_distance
    }

    /// The value of f at a gap of E (length²); parts with a smaller value touch.
    pub(crate) fn touching(&self, time: f64) -> f64 {
        2.0 * self.contact_distance * self.error.at(time)
    }

    /// Whether parts that touch or overlap at `time` close.
    ///
    /// They close if d·d' is below −|d| E', with the bound E' on the rounding of the closing speed
    /// that [`Exact`](crate::Exact) uses. For parts that overlap by more than E, the error of the
    /// velocities takes the place of E'.
    pub(crate) fn closes(&self, time: f64) -> bool {
        let motion = self.motion;
        let [spin_a, spin_b] = motion.angular_velocity;
        let [arm_a, arm_b] = self.arms(time);
        let d = self.between_centres(time, arm_a, arm_b);
        let of_centres = motion.velocity + (spin_b * arm_b.perp() - spin_a * arm_a.perp());
        let (distance, direction, velocity) = match self.edge {
            Some((body, edge)) => {
                let (distance, direction) = self.to_edge((body, edge), d, time);
                // The edge turns about the centre of its body.
                let turning = motion.angular_velocity[body] * d.perp();
                (distance, direction, of_centres - turning)
            }
            None => (d.length(), d, of_centres),
        };
        let overlaps = distance - self.contact_distance < -self.error.at(time);
        let resolved = match self.error {
            _ if overlaps => motion.velocity_error,
            Bound::Atoms(bound) => bound.of_rate(time, distance),
            Bound::Edge(bound) => bound.of_rate(time),
        };
        // The vector between atoms has the length of their distance, that to an edge length 1.
        let length = if self.edge.is_some() { 1.0 } else { distance };
        direction.dot(velocity) < -(length * resolved)
    }

    /// The distance to the edge of a body at `time`, and the direction from A's part to B's along
    /// the shortest line.
    fn to_edge(&self, (body, edge): (usize, &Edge), d: DVec2, time: f64) -> (f64, DVec2) {
        let spin = self.motion.angular_velocity[body];
        let rotation = self.motion.orientation[body].turned(spin, time).cos_sin();
        // From the body with the edge to the atom.
        let sign = if body == 0 { 1.0 } else { -1.0 };
        let nearest = edge.nearest(DVec2::new(rotation.x, -rotation.y).rotate(sign * d));
        (nearest.distance, sign * rotation.rotate(nearest.direction))
    }

    fn arms(&self, time: f64) -> [DVec2; 2] {
        [0, 1].map(|body| {
            let offset = self.offsets[body];
            if offset == DVec2::ZERO {
                return offset;
            }
            let spin = self.motion.angular_velocity[body];
            self.motion.orientation[body]
                .turned(spin, time)
                .cos_sin()
                .rotate(offset)
        })
    }

    fn between_centres(&self, time: f64, arm_a: DVec2, arm_b: DVec2) -> DVec2 {
        (self.motion.separation + self.motion.velocity * time) + (arm_b - arm_a)
    }
}
