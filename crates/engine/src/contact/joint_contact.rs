//! Contacts of two bodies at several points at one instant, such as a rod that falls flat on a
//! wall: which points touch, and the joint impulse.
//!
//! Contacts of one body with several others at one instant are not joined: they are resolved one
//! after the other, in the order of [`ContactEvent::in_order`].

use carom_detection::Part;
use carom_kinematics::{Inertia, Motion};
use carom_response::{ContactFrame, apply_impulse};
use glam::DVec2;
use smallvec::SmallVec;

use crate::{
    contact::contact_geometry::contact_geometry,
    world::{
        World,
        body::Body,
        contact_event::{ContactEvent, TouchingParts},
    },
};

/// Points whose gap is at most this many bounds on the rounding of a separation touch. Smaller: a
/// flat contact is taken for a contact of one point, and the next follows at the same instant.
/// Larger: points are joined whose contacts are farther apart than rounding.
const TOUCHING: f64 = 2.0;

/// A resultant smaller than this share of all impulses has no line of action: they cancel out.
const CANCELLED: f64 = 1e-9;

/// The outcome of a contact at several points.
#[derive(Debug, Clone, Copy)]
pub(crate) struct JointContact {
    /// A frame on the line of action of the resultant, which has the same effect.
    pub frame: ContactFrame,
    /// The resultant on the second body (mass × length / time).
    pub impulse: DVec2,
    /// The motions after it.
    pub after: [Motion; 2],
    /// Number of points that touch.
    pub points: u32,
}

/// Whether two bodies that touch at these parts may touch at others at the same instant: one of
/// them must consist of several atoms, and none of ellipses.
#[inline]
pub(crate) fn may_be_joint(pair: [&Body; 2], parts: TouchingParts) -> bool {
    let has_atoms = match parts {
        TouchingParts::Discs
        | TouchingParts::BoundingCircles
        | TouchingParts::Bond(..)
        | TouchingParts::Step(_) => false,
        TouchingParts::Atoms(..) => true,
        TouchingParts::EdgeOfA { part, .. } | TouchingParts::EdgeOfB { part, .. } => {
            matches!(part, Part::Atom(_))
        }
    };
    has_atoms
        && !pair.iter().any(|body| body.has_ellipses())
        && pair
            .iter()
            .any(|body| !body.is_wall() && body.molecule().atoms().len() > 1)
}

/// The outcome of a contact whose first point is `first`; `None` if the bodies touch at one point,
/// or if `impulses` has none for several. `bodies` are the motions just before, and the inertias;
/// `error` is the rounding of a separation (length).
pub(crate) fn joint_contact(
    world: &World,
    contact: &ContactEvent,
    bodies: (&[Motion; 2], [&Inertia; 2]),
    first: &ContactFrame,
    error: f64,
    impulses: impl FnOnce(&[ContactFrame]) -> Option<Vec<DVec2>>,
) -> Option<JointContact> {
    let (before, inertias) = bodies;
    let frames = touching(world, contact, before, first, TOUCHING * error);
    if frames.len() < 2 {
        return None;
    }
    let impulses = impulses(&frames)?;
    let mut after = *before;
    for (frame, &impulse) in frames.iter().zip(&impulses) {
        after = [
            apply_impulse(&after[0], inertias[0], frame.arms[0], -impulse),
            apply_impulse(&after[1], inertias[1], frame.arms[1], impulse),
        ];
    }
    let impulse = impulses.iter().sum();
    let frame = resultant(&frames, &impulses);
    Some(JointContact {
        frame,
        impulse,
        after,
        points: frames.len() as u32,
    })
}

/// The frames of all points whose gap is at most `tolerance` (length), that of the contact itself
/// first.
#[inline]
fn touching(
    world: &World,
    contact: &ContactEvent,
    before: &[Motion; 2],
    first: &ContactFrame,
    tolerance: f64,
) -> SmallVec<[ContactFrame; 4]> {
    let mut points = TouchingPoints {
        world,
        contact,
        before,
        pair: contact.bodies.map(|body| &world.bodies[body as usize]),
        tolerance,
        frames: SmallVec::from_slice(&[*first]),
    };
    match points.pair.iter().position(|body| body.is_wall()) {
        Some(wall) => points.add_on_wall(wall),
        None => points.add_between_molecules(),
    }
    points.frames
}

/// The points of a contact that have been found to touch.
struct TouchingPoints<'a> {
    world: &'a World,
    contact: &'a ContactEvent,
    before: &'a [Motion; 2],
    pair: [&'a Body; 2],
    /// The largest gap of two points that touch (length).
    tolerance: f64,
    frames: SmallVec<[ContactFrame; 4]>,
}

impl TouchingPoints<'_> {
    /// Adds the point of these parts, if they touch and are not those of the contact itself.
    #[inline]
    fn add(&mut self, parts: TouchingParts) {
        if parts == self.contact.parts {
            return;
        }
        let contact = ContactEvent {
            parts,
            ..*self.contact
        };
        let (frame, depth) = contact_geometry(self.world, &contact, self.before);
        if depth >= -self.tolerance {
            self.frames.push(frame);
        }
    }

    /// Adds the points of the other body at a wall, which has this number in the pair.
    #[inline]
    fn add_on_wall(&mut self, wall: usize) {
        let body = 1 - wall;
        let touched = atom_at_wall(self.contact.parts, wall);
        let atoms = 0..self.pair[body].molecule().atoms().len() as u32;
        for atom in atoms.filter(|atom| Some(*atom) != touched) {
            self.add(on_edge(wall, 0, atom));
        }
        // A side that is wider than the wall rests on its ends.
        let shift = self.world.shift_of(self.contact);
        let shift = if wall == 1 { shift } else { -shift };
        let (before, pair) = (self.before, self.pair);
        let to_wall = (before[wall].position - before[body].position) + shift;
        let ends = placed(pair[wall], &before[wall]).collect::<SmallVec<[Placed; 8]>>();
        let beside = beside_edges(pair[body], &before[body], to_wall, &ends, self.tolerance);
        for [edge, end] in beside {
            self.add(on_edge(body, edge, end));
        }
    }

    /// Adds the points of two molecules.
    #[inline]
    fn add_between_molecules(&mut self) {
        let (before, pair, tolerance) = (self.before, self.pair, self.tolerance);
        let between = (before[1].position - before[0].position) + self.world.shift_of(self.contact);
        let towards_other = [between, -between];
        let [of_a, of_b] = [0, 1].map(|n| {
            let reach = pair[1 - n].molecule().bounding_radius() + tolerance;
            near(pair[n], &before[n], towards_other[n], reach)
        });
        let mut at_ends: SmallVec<[[u32; 2]; 4]> = SmallVec::new();
        for (edged, atoms) in [(0, &of_b), (1, &of_a)] {
            let (body, motion) = (pair[edged], &before[edged]);
            for [edge, atom] in beside_edges(body, motion, towards_other[edged], atoms, tolerance) {
                let ends = body.molecule().edges()[edge as usize].ends();
                let with = |end: u32| if edged == 0 { [end, atom] } else { [atom, end] };
                at_ends.extend(ends.into_iter().flatten().map(with));
                self.add(on_edge(edged, edge, atom));
            }
        }
        // A corner on an edge next to its end is one point; the normal of the edge is the exact
        // one.
        if let TouchingParts::Atoms(a, b) = self.contact.parts
            && at_ends.contains(&[a, b])
        {
            self.frames.remove(0);
        }
        for a in &of_a {
            for b in &of_b {
                if at_ends.contains(&[a.index, b.index]) {
                    continue;
                }
                let line_of_centres = between + (b.arm - a.arm);
                let reach = a.radius + b.radius + tolerance;
                let touches = line_of_centres.length_squared() <= reach * reach;
                if touches && self.contact.parts != TouchingParts::Atoms(a.index, b.index) {
                    self.frames.push(ContactFrame {
                        line_of_centres,
                        arms: [a.arm, b.arm],
                    });
                }
            }
        }
    }
}

/// The atom of the other body that touches a wall, at its edge or at an end.
fn atom_at_wall(parts: TouchingParts, wall: usize) -> Option<u32> {
    match parts {
        TouchingParts::Atoms(a, b) => Some(if wall == 0 { b } else { a }),
        TouchingParts::EdgeOfA {
            part: Part::Atom(atom),
            ..
        } if wall == 0 => Some(atom),
        TouchingParts::EdgeOfB {
            part: Part::Atom(atom),
            ..
        } if wall == 1 => Some(atom),
        _ => None,
    }
}

/// An edge of body number `edged` of a pair, and an atom of the other.
fn on_edge(edged: usize, edge: u32, atom: u32) -> TouchingParts {
    let part = Part::Atom(atom);
    if edged == 0 {
        TouchingParts::EdgeOfA { edge, part }
    } else {
        TouchingParts::EdgeOfB { edge, part }
    }
}

/// Edges of a body and atoms of another, `to_other` from it, that are beside them, not beyond their
/// ends, at a gap of at most `tolerance` (length).
fn beside_edges<'a>(
    body: &'a Body,
    motion: &Motion,
    to_other: DVec2,
    atoms: &'a [Placed],
    tolerance: f64,
) -> impl Iterator<Item = [u32; 2]> + 'a {
    let rotation = motion.orientation.cos_sin();
    let back = DVec2::new(rotation.x, -rotation.y);
    let edges = (0..).zip(body.molecule().edges());
    edges.flat_map(move |(number, edge)| {
        let is_beside = move |atom: &&Placed| {
            let place = back.rotate(to_other + atom.arm) - edge.middle();
            let reach = edge.radius() + atom.radius + tolerance;
            edge.along().dot(place).abs() <= edge.half_length()
                && edge.normal().dot(place).abs() <= reach
        };
        let touching = atoms.iter().filter(is_beside);
        touching.map(move |atom| [number, atom.index])
    })
}

/// An atom of a body in its present orientation.
#[derive(Debug, Clone, Copy)]
struct Placed {
    index: u32,
    /// From the centre of mass (length).
    arm: DVec2,
    radius: f64,
}

/// The atoms of a body within `reach` of the centre of the other (length).
fn near(body: &Body, motion: &Motion, to_other: DVec2, reach: f64) -> SmallVec<[Placed; 8]> {
    let is_near = |atom: &Placed| {
        let most = reach + atom.radius;
        (to_other - atom.arm).length_squared() <= most * most
    };
    placed(body, motion).filter(is_near).collect()
}

/// All atoms of a body in its present orientation.
fn placed<'a>(body: &'a Body, motion: &Motion) -> impl Iterator<Item = Placed> + 'a {
    let rotation = motion.orientation.cos_sin();
    let atoms = body.molecule().atoms().iter().enumerate();
    atoms.map(move |(index, atom)| Placed {
        index: index as u32,
        arm: rotation.rotate(atom.offset()),
        radius: atom.radius(),
    })
}

/// A frame on the line of action of the resultant of these impulses on the second body. Where they
/// cancel out, there is no such line, and the frame is that of the first point.
fn resultant(frames: &[ContactFrame], impulses: &[DVec2]) -> ContactFrame {
    let all: f64 = impulses.iter().map(|impulse| impulse.length()).sum();
    let force: DVec2 = impulses.iter().sum();
    if force.length() <= CANCELLED * all {
        return frames[0];
    }
    let on_line = |n: usize| {
        let arms = || frames.iter().map(|frame| frame.arms[n]).zip(impulses);
        let mean = arms()
            .map(|(arm, impulse)| impulse.length() * arm)
            .sum::<DVec2>()
            / all;
        let torque: f64 = arms().map(|(arm, impulse)| arm.perp_dot(*impulse)).sum();
        mean + (mean.perp_dot(force) - torque) / force.length_squared() * force.perp()
    };
    let line_of_centres = frames[0].line_of_centres.length() * force.normalize();
    ContactFrame {
        line_of_centres,
        arms: [on_line(0), on_line(1)],
    }
}
