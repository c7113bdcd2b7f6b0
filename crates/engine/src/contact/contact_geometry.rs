//! Lever arms, normal and depth of a contact of any two bodies.

#![allow(
    clippy::inline_always,
    reason = "compiled with the instructions of the caller"
)]

use carom_detection::{Part, TetherBound};
use carom_geometry::{SupportPoint, atom_tangents, edge_tangents};
use carom_kinematics::Motion;
use carom_response::ContactFrame;
use glam::DVec2;

use crate::world::{
    World,
    body::Body,
    contact_event::{ContactEvent, TouchingParts},
    wall::{arm, contact_frame},
};

/// The length of a line of centres that is shorter, in bounding radii. Only its direction counts;
/// smaller: its square may vanish.
const MIN_SEPARATION: f64 = 1e-6;

/// Lever arms and normal of any contact, and the depth by which the two bodies overlap (length).
#[inline(always)]
pub(crate) fn contact_geometry(
    world: &World,
    contact: &ContactEvent,
    before: &[Motion; 2],
) -> (ContactFrame, f64) {
    let ContactEvent {
        bodies,
        time,
        image,
        parts,
        ..
    } = *contact;
    if let TouchingParts::Bond(bond, bound) = parts {
        return bond_frame(world, contact, (bond, bound), before);
    }
    let pair = bodies.map(|body| &world.bodies[body as usize]);
    if pair.iter().any(|body| body.has_ellipses())
        && let Some(found) = ellipse_frame(world, contact, before)
    {
        return found;
    }
    let arms = match parts {
        TouchingParts::Atoms(i, j) => [arm(pair[0], i, &before[0]), arm(pair[1], j, &before[1])],
        _ => [DVec2::ZERO; 2],
    };
    let mut d = (before[1].position - before[0].position) + (arms[1] - arms[0]);
    if image != [0, 0] {
        d += world.bounds_at(time).shift(image);
    }
    let between_centres = ContactFrame {
        line_of_centres: d,
        arms,
    };
    let (frame, distance) =
        contact_frame(world, contact, before).unwrap_or_else(|| (between_centres, d.length()));
    let factor = world.pairs.factor(pair[0], pair[1]);
    (
        frame,
        factor * parts.contact_distance(pair.map(Body::molecule)) - distance,
    )
}

/// Lever arms, normal and excess of a bond at one of its bounds. At its longest, the points pull
/// each other: the normal is turned.
#[cold]
#[inline(never)]
fn bond_frame(
    world: &World,
    contact: &ContactEvent,
    (bond, bound): (u32, TetherBound),
    before: &[Motion; 2],
) -> (ContactFrame, f64) {
    let bond = &world.bonds()[bond as usize];
    let (between, arms) =
        World::span_of_bond(bond, [&before[0], &before[1]], world.shift_of(contact));
    let [shortest, longest] = bond.tether.bounds();
    let (line_of_centres, depth) = match bound {
        TetherBound::Longest => (-between, between.length() - longest),
        TetherBound::Shortest => (between, shortest - between.length()),
    };
    let frame = ContactFrame {
        line_of_centres,
        arms,
    };
    (frame, depth)
}

/// Lever arms, normal and depth of a contact in which a part may be an ellipse; `None` where that
/// does not depend on the shapes of the atoms.
///
/// The arm of an ellipse ends at the point of contact, that of a disc at its centre.
#[cold]
#[inline(never)]
fn ellipse_frame(
    world: &World,
    contact: &ContactEvent,
    before: &[Motion; 2],
) -> Option<(ContactFrame, f64)> {
    let bodies = contact.bodies.map(|body| &world.bodies[body as usize]);
    let molecules = bodies.map(Body::molecule);
    let rotations = before.map(|motion| motion.orientation.cos_sin());
    let separation = (before[1].position - before[0].position) + world.shift_of(contact);
    let arm = |side: usize, atom: u32, normal: DVec2, point: &SupportPoint| {
        let centre = arm(bodies[side], atom, &before[side]);
        if molecules[side].ellipses().is_empty() {
            centre
        } else {
            centre + point.place(normal)
        }
    };
    let (edged, edge, atom) = match contact.parts {
        TouchingParts::Atoms(i, j) => {
            let atoms = [i as usize, j as usize];
            let found = atom_tangents(molecules, atoms, rotations, separation);
            let arms = [
                arm(0, i, found.normal, &found.points[0]),
                arm(1, j, -found.normal, &found.points[1]),
            ];
            // Centres of mass may coincide, where a body is inside a hollow of the other.
            let least = MIN_SEPARATION * molecules[0].bounding_radius();
            let length = separation.length().max(least);
            let frame = ContactFrame {
                line_of_centres: length * found.normal,
                arms,
            };
            return Some((frame, -found.gap));
        }
        TouchingParts::EdgeOfA {
            edge,
            part: Part::Atom(atom),
        } => (0, edge, atom),
        TouchingParts::EdgeOfB {
            edge,
            part: Part::Atom(atom),
        } => (1, edge, atom),
        _ => return None,
    };
    let other = 1 - edged;
    if molecules[other].ellipses().is_empty() {
        return None;
    }
    let edge = &molecules[edged].edges()[edge as usize];
    let sign = if edged == 0 { 1.0 } else { -1.0 };
    let to_part = sign * separation;
    let turned = [rotations[other], rotations[edged]];
    let found = edge_tangents(edge, molecules[other], atom as usize, turned, to_part);
    let of_part = arm(other, atom, -found.normal, &found.point);
    let of_edge = to_part + of_part - (edge.radius() + found.gap) * found.normal;
    let arms = if edged == 0 {
        [of_edge, of_part]
    } else {
        [of_part, of_edge]
    };
    let frame = ContactFrame {
        line_of_centres: sign * molecules[other].bounding_radius() * found.normal,
        arms,
    };
    Some((frame, -found.gap))
}
