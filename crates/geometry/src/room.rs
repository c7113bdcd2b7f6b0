//! The room of a molecule: how far it can grow about its centre of mass before it touches another.

use glam::DVec2;

use crate::{
    Bend, Edge, Molecule,
    gap::{atom_tangents, edge_tangents},
};

/// A molecule, turned, and with all its lengths multiplied by a scale.
#[derive(Debug, Clone, Copy)]
pub struct Scaled<'a> {
    /// The molecule at scale 1.
    pub molecule: &'a Molecule,
    /// (cos θ, sin θ) of its orientation.
    pub rotation: DVec2,
    /// Factor of all its lengths; positive.
    pub scale: f64,
}

/// Returns the scale at which `b`, growing about its centre of mass from its present scale, comes
/// within `margin` (length, may be 0) of `a`, which keeps its scale.
///
/// The present scale of `b` if their surfaces are that close already; infinite if they never are.
/// Molecules in each other or across each other, with their surfaces apart, count as apart.
/// `separation` is the vector from the centre of `a` to the centre of the image of `b`. At a larger
/// scale the two may be apart again, since molecules have notches: the result is the first contact,
/// which a molecule that grows steadily cannot pass.
///
/// The surfaces of two atoms close as those of two discs that move on straight lines while their
/// contact distance grows steadily, so that the contact is a root of a quadratic equation; the
/// contact with a straight edge is a root of a linear one.
///
/// ```
/// use carom_geometry::{Molecule, Scaled, room};
/// use glam::DVec2;
///
/// let disc = Molecule::disc(0.5, 1.0)?;
/// let [a, b] = [2.0, 1.0].map(|scale| Scaled { molecule: &disc, rotation: DVec2::X, scale });
/// // Between centres 3 apart, a disc of radius 1 leaves 2 for a disc of radius 0.5.
/// assert_eq!(room(a, b, DVec2::new(3.0, 0.0), 0.0), 4.0);
/// # Ok::<(), carom_geometry::GeometryError>(())
/// ```
pub fn room(a: Scaled<'_>, b: Scaled<'_>, separation: DVec2, margin: f64) -> f64 {
    if !(a.molecule.ellipses().is_empty() && b.molecule.ellipses().is_empty()) {
        return b.scale + growth_of_ellipses(a, b, separation, margin);
    }
    let mut least = f64::INFINITY;
    for atom_a in a.molecule.atoms() {
        let place_a = a.scale * a.rotation.rotate(atom_a.offset());
        for atom_b in b.molecule.atoms() {
            let rate = b.rotation.rotate(atom_b.offset());
            let approach = Approach {
                place: separation + (b.scale * rate - place_a),
                place_rate: rate,
                reach: a.scale * atom_a.radius() + b.scale * atom_b.radius() + margin,
                reach_rate: atom_b.radius(),
            };
            least = least.min(approach.until_contact());
        }
    }
    let [to_a, to_b] = [a, b].map(|body| inverse(body.rotation));
    for edge in a.molecule.edges() {
        for atom in b.molecule.atoms() {
            let rate = to_a.rotate(b.rotation.rotate(atom.offset()));
            let approach = Approach {
                place: (to_a.rotate(separation) + b.scale * rate) - a.scale * origin_of(edge),
                place_rate: rate,
                reach: a.scale * edge.radius() + b.scale * atom.radius() + margin,
                reach_rate: atom.radius(),
            };
            let until = match edge.bend() {
                Some(bend) => approach.until_arc(bend, a.scale, 0.0),
                None => approach.until_edge(edge, a.scale * edge.half_length(), 0.0),
            };
            least = least.min(until);
        }
    }
    for edge in b.molecule.edges() {
        for atom in a.molecule.atoms() {
            let place = to_b.rotate(a.scale * a.rotation.rotate(atom.offset()) - separation);
            let approach = Approach {
                place: place - b.scale * origin_of(edge),
                place_rate: -origin_of(edge),
                reach: a.scale * atom.radius() + b.scale * edge.radius() + margin,
                reach_rate: edge.radius(),
            };
            let until = match edge.bend() {
                Some(bend) => approach.until_arc(bend, b.scale, 1.0),
                None => approach.until_edge(edge, b.scale * edge.half_length(), edge.half_length()),
            };
            least = least.min(until);
        }
    }
    b.scale + least
}

/// The point of an edge from which [`Approach`] counts: the middle of a straight one, the centre of
/// an arc.
fn origin_of(edge: &Edge) -> DVec2 {
    match edge.bend() {
        Some(_) => DVec2::ZERO,
        None => edge.middle(),
    }
}

/// Most steps of the search for the scale at which two bodies touch.
const MAX_GROWTHS: u32 = 200;

/// By how much the scale of B can grow before it touches A, where one of them has ellipses.
///
/// In any fixed direction the distance of two facing tangents is linear in the scale. The gap, the
/// largest of them, is therefore convex, and Newton's method from below does not pass its zero.
fn growth_of_ellipses(a: Scaled<'_>, b: Scaled<'_>, separation: DVec2, margin: f64) -> f64 {
    let small = f64::EPSILON
        * (separation.length()
            + a.scale * a.molecule.bounding_radius()
            + b.scale * b.molecule.bounding_radius());
    let mut growth = 0.0;
    for _ in 0..MAX_GROWTHS {
        let now = Scaled {
            scale: b.scale + growth,
            ..b
        };
        let until = least_growth(a, now, separation, margin, 4.0 * small);
        growth += until;
        let is_small = until <= f64::EPSILON * (b.scale + growth);
        if is_small || growth == f64::INFINITY || growth.is_nan() {
            break;
        }
    }
    growth
}

/// A step of the scale of B within which it certainly does not come nearer to A than `margin`; 0
/// where a pair of parts is that near to within `error` (length).
fn least_growth(a: Scaled<'_>, b: Scaled<'_>, separation: DVec2, margin: f64, error: f64) -> f64 {
    let bodies = [a.molecule.scaled(a.scale), b.molecule.scaled(b.scale)];
    let [Ok(scaled_a), Ok(scaled_b)] = &bodies else {
        return 0.0;
    };
    let rotations = [a.rotation, b.rotation];
    let until = |gap: f64, closing: f64| {
        let gap = gap - margin;
        if gap <= error {
            0.0
        } else if closing > 0.0 {
            gap / closing
        } else {
            f64::INFINITY
        }
    };
    // What is linear in the scale of B, for a scale of 1.
    let rate = 1.0 / b.scale;
    let mut least = f64::INFINITY;
    for i in 0..scaled_a.atoms().len() {
        for (j, atom) in scaled_b.atoms().iter().enumerate() {
            let found = atom_tangents([scaled_a, scaled_b], [i, j], rotations, separation);
            let outwards = found.normal.dot(b.rotation.rotate(atom.offset()));
            let closing = rate * (found.points[1].distance - outwards);
            least = least.min(until(found.gap, closing));
        }
    }
    for edge in scaled_a.edges() {
        for (j, atom) in scaled_b.atoms().iter().enumerate() {
            let exchanged = [b.rotation, a.rotation];
            let found = edge_tangents(edge, scaled_b, j, exchanged, separation);
            let outwards = found.normal.dot(b.rotation.rotate(atom.offset()));
            let closing = rate * (found.point.distance - outwards);
            least = least.min(until(found.gap, closing));
        }
    }
    for edge in scaled_b.edges() {
        for i in 0..scaled_a.atoms().len() {
            let found = edge_tangents(edge, scaled_a, i, rotations, -separation);
            let to_b = inverse(b.rotation).rotate(found.normal);
            let along = edge.half_length() * to_b.dot(edge.along()).abs();
            let closing = rate * (to_b.dot(edge.middle()) + along + edge.radius());
            least = least.min(until(found.gap, closing));
        }
    }
    least
}

/// The inverse of a rotation is its conjugate.
fn inverse(rotation: DVec2) -> DVec2 {
    DVec2::new(rotation.x, -rotation.y)
}

/// A point that approaches the origin, and the distance at which they touch; both are linear in the
/// increase u of the scale.
#[derive(Clone, Copy)]
struct Approach {
    place: DVec2,
    place_rate: DVec2,
    reach: f64,
    reach_rate: f64,
}

impl Approach {
    /// The smallest u ≥ 0 with |place| ≤ reach; infinite if there is none.
    fn until_contact(self) -> f64 {
        let distance = self.place.length();
        if distance <= self.reach {
            return 0.0;
        }
        // A u² + 2 B u + C = 0, with C > 0 at the start.
        let a = self.place_rate.length_squared() - self.reach_rate * self.reach_rate;
        let b = self.place.dot(self.place_rate) - self.reach * self.reach_rate;
        let c = (distance - self.reach) * (distance + self.reach);
        let discriminant = b * b - a * c;
        if discriminant < 0.0 {
            return f64::INFINITY;
        }
        let root = discriminant.sqrt();
        // Each form of the root adds numbers of one sign.
        if b < 0.0 {
            c / (root - b)
        } else if a < 0.0 {
            (b + root) / -a
        } else {
            f64::INFINITY
        }
    }

    /// The smallest u ≥ 0 at which the point touches an arc about the origin, whose scale grows at
    /// `rate` from `scale`; infinite if there is none.
    ///
    /// A point may touch an arc from inside, where its distance from the centre reaches S − r, or
    /// from outside; a point that leaves the arc's directions first is held by an end of the arc.
    fn until_arc(self, bend: &Bend, scale: f64, rate: f64) -> f64 {
        let (radius, radius_rate) = (scale * bend.radius(), rate * bend.radius());
        let is_inside = self.place.length() < radius;
        let along_arc = if is_inside {
            self.until_outside(radius - self.reach, radius_rate - self.reach_rate)
        } else {
            let from_outside = Self {
                reach: self.reach + radius,
                reach_rate: self.reach_rate + radius_rate,
                ..self
            };
            from_outside.until_contact()
        };
        let there = self.place + along_arc * self.place_rate;
        if along_arc.is_finite() && bend.faces(there, 0.0) {
            return along_arc;
        }
        if bend.is_circle() {
            return f64::INFINITY;
        }
        let ends = bend.ends().map(|end| {
            let end = Self {
                place: self.place - scale * end,
                place_rate: self.place_rate - rate * end,
                ..self
            };
            end.until_contact()
        });
        ends[0].min(ends[1])
    }

    /// The smallest u ≥ 0 at which the point is `room` + `room_rate` u from the origin, from
    /// inside; 0 if it is farther already.
    fn until_outside(self, room: f64, room_rate: f64) -> f64 {
        let c = room * room - self.place.length_squared();
        if room <= 0.0 || c <= 0.0 {
            return 0.0;
        }
        let a = room_rate * room_rate - self.place_rate.length_squared();
        let b = room * room_rate - self.place.dot(self.place_rate);
        // c + 2 b u + a u² = 0, and the room must not have vanished before.
        let discriminant = b * b - a * c;
        if discriminant < 0.0 {
            return f64::INFINITY;
        }
        let root = discriminant.sqrt();
        let met = if b < root {
            c / (root - b)
        } else {
            f64::INFINITY
        };
        if room_rate < 0.0 {
            met.min(room / -room_rate)
        } else {
            met
        }
    }

    /// The smallest u ≥ 0 at which the point touches an edge about the origin; infinite if there is
    /// none. `half` and `half_rate` are half the length of the edge and its rate of growth.
    fn until_edge(self, edge: &Edge, half: f64, half_rate: f64) -> f64 {
        let ends = [-1.0, 1.0].map(|side| {
            let end = Self {
                place: self.place - side * half * edge.along(),
                place_rate: self.place_rate - side * half_rate * edge.along(),
                ..self
            };
            end.until_contact()
        });
        let side = if edge.is_solid_behind() {
            1.0
        } else {
            edge.normal().dot(self.place).signum()
        };
        let gap = side * edge.normal().dot(self.place) - self.reach;
        let closing = self.reach_rate - side * edge.normal().dot(self.place_rate);
        let until = if gap <= 0.0 { 0.0 } else { gap / closing };
        // Beyond its ends the edge is touched there first.
        let is_beside = |u: f64| {
            edge.along().dot(self.place + u * self.place_rate).abs() <= half + u * half_rate
        };
        let beside = if until >= 0.0 && is_beside(until) {
            until
        } else {
            f64::INFINITY
        };
        ends[0].min(ends[1]).min(beside)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Atom, gap_between};
    use proptest::prelude::*;

    fn molecules() -> impl Strategy<Value = Molecule> {
        let atom = (-1.0..1.0, -1.0..1.0, 0.01..0.5, 0.1..10.0);
        let atoms = prop::collection::vec(atom, 1..6).prop_map(|list| {
            let atom = |(x, y, r, m)| Atom::new(DVec2::new(x, y), r, m).unwrap();
            Molecule::new(list.into_iter().map(atom)).unwrap()
        });
        let wall =
            (-1.0..1.0f64, 0.1..1.0f64, 0.0..0.2f64, any::<bool>()).prop_map(|(x, y, r, ends)| {
                let span = DVec2::new(x, y);
                if ends {
                    Molecule::wall(span, r).unwrap()
                } else {
                    Molecule::wall_without_ends(span, r).unwrap()
                }
            });
        let polygon = (3..9u32, 0.1..1.0f64, 0.3..1.0f64, 1e-3..0.2f64).prop_map(
            |(count, size, notch, radius)| {
                // Regular, or a star.
                let corner = |index: u32| {
                    let size = if index.is_multiple_of(2) {
                        size
                    } else {
                        notch * size
                    };
                    let turn = f64::from(index) / f64::from(2 * count);
                    size * DVec2::from_angle(std::f64::consts::TAU * turn)
                };
                let corners: Vec<DVec2> = (0..2 * count).map(corner).collect();
                Molecule::polygon(&corners, radius * size, 1.0).unwrap()
            },
        );
        let capsule = (0.1..2.0f64, 1e-6..0.5f64)
            .prop_map(|(length, radius)| Molecule::capsule(length, radius, 1.0).unwrap());
        let ellipse = (0.05..0.5f64, 1.0..8.0f64)
            .prop_map(|(b, ratio)| Molecule::ellipse([b * ratio, b], 1.0).unwrap());
        prop_oneof![3 => atoms, 1 => wall, 2 => polygon, 1 => capsule, 2 => ellipse]
    }

    proptest! {
        #[test]
        fn the_first_contact_is_that_of_the_gap(
            a in molecules(), b in molecules(), turns in prop::array::uniform2(-3.2..3.2f64),
            scales in prop::array::uniform2(0.2..2.0f64), x in -4.0..4.0f64, y in -4.0..4.0f64,
            margin in prop_oneof![Just(0.0), Just(0.05)],
        ) {
            prop_assume!(!a.is_wall() || !b.is_wall());
            // A line without end points may cross an edge beyond its end.
            let is_open = |m: &Molecule| m.atoms().is_empty();
            prop_assume!(!is_open(&a) || b.edges().is_empty());
            prop_assume!(!is_open(&b) || a.edges().is_empty());
            let (separation, rotations) = (DVec2::new(x, y), turns.map(DVec2::from_angle));
            let scaled_a = a.scaled(scales[0]).unwrap();
            let gap = |scale: f64| {
                let scaled_b = b.scaled(scale).unwrap();
                gap_between(&scaled_a, rotations[0], &scaled_b, rotations[1], separation) - margin
            };
            let scaled = |index: usize, molecule| {
                Scaled { molecule, rotation: rotations[index], scale: scales[index] }
            };
            let room = room(scaled(0, &a), scaled(1, &b), separation, margin);
            let from = scales[1];
            prop_assert!(room >= from);
            // Molecules in each other or across each other, with their surfaces apart.
            prop_assume!(gap(from) > 0.0 || room == from);
            // Steps of the scale, and bisection in the first in which the gap changes its sign.
            let most = if room.is_finite() { 1.1 * room } else { 40.0 * from };
            let steps = 400;
            let at = |step: i32| from + (most - from) * f64::from(step) / f64::from(steps);
            let change = (0..=steps).find(|&step| gap(at(step)) <= 0.0);
            let Some(change) = change else {
                // Two surfaces may overlap for less than a step.
                prop_assert!(room.is_infinite() || gap(room).abs() < 1e-12 * (1.0 + room));
                return Ok(());
            };
            let (mut apart, mut touching) = (at((change - 1).max(0)), at(change));
            for _ in 0..200 {
                let middle = 0.5 * (apart + touching);
                if gap(middle) <= 0.0 { touching = middle } else { apart = middle }
            }
            prop_assert!(room <= touching * (1.0 + 1e-12), "{room} after {touching}");
            let is_first = gap(room).abs() < 1e-12 * (1.0 + room) || change == 0;
            prop_assert!(is_first, "{room}, where the gap is {}, for {touching}", gap(room));
        }

        #[test]
        fn a_molecule_scaled_up_and_down_keeps_its_shape(molecule in molecules(), scale in 0.01..100.0f64) {
            prop_assert_eq!(&molecule.scaled(1.0).unwrap(), &molecule);
            let scaled = molecule.scaled(scale).unwrap();
            let close = |one: f64, other: f64| one == other || (one / other - 1.0).abs() < 1e-13;
            prop_assert!(close(scaled.mass(), molecule.mass()));
            prop_assert!(close(scaled.area(), scale * scale * molecule.area()));
            prop_assert!(close(scaled.moment_of_inertia(), scale * scale * molecule.moment_of_inertia()));
            prop_assert!(close(scaled.bounding_radius(), scale * molecule.bounding_radius()));
        }
    }
}
