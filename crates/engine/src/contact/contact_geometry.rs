//! Lever arms, normal and depth of a contact of any two bodies.

#![allow(
    clippy::inline_always,
    reason = "compiled with the instructions of the caller"
)]

use carom_kinematics::Motion;
use carom_response::ContactFrame;
use glam::DVec2;

use crate::world::{
    World,
    body::Body,
    contact_event::{ContactEvent, TouchingParts},
    wall::{arm, contact_frame},
};

/// Lever arms and normal of any contact, and the depth by which the two bodies overlap (length).
#[inline(always)]
pub(crate) fn contact_geometry(
    world: &World,
    contact: &ContactEvent,
    before: &[Motion; 2],
) -> (ContactFrame, f64) {
    let ContactEvent {
        bodies,
        image,
        parts,
        ..
    } = *contact;
    let pair = bodies.map(|body| &world.bodies[body as usize]);
    let arms = match parts {
        TouchingParts::Atoms(i, j) => [arm(pair[0], i, &before[0]), arm(pair[1], j, &before[1])],
        _ => [DVec2::ZERO; 2],
    };
    let mut d = (before[1].position - before[0].position) + (arms[1] - arms[0]);
    if image != [0, 0] {
        d += world.bounds.shift(image);
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
