//! One step of growth: how far each molecule can grow before it touches a neighbour.
//!
//! Each molecule in turn grows by [`SHARE`] of the room that its neighbours leave it at their
//! present sizes, but not beyond a common front, which leads the smallest molecule by a few per
//! cent at most. Its neighbours therefore set its growth, not the closest pair of all, so that the
//! number of steps does not depend on the number of molecules. The front keeps single molecules
//! from staying far behind: it slows down when too many cannot follow.
//!
//! Whole molecules are scaled about their centres of mass, and stop at scale 1: a molecule made
//! smaller again could touch another in its notches, since unions of discs are not star-shaped.

use std::sync::Arc;

use carom_geometry::{Molecule, Scaled, room};
use carom_kinematics::Inertia;
use glam::DVec2;
use rand::seq::SliceRandom;
use rand_pcg::Pcg64;

use crate::{
    scene::error::SceneError,
    start::{body_builder::geometry, sites::Sites, species::Species},
    world::{
        World,
        body::{BodyKind, Rotation},
    },
};

/// Share of its room by which a molecule grows. At 1 molecules touch, and their neighbours cannot
/// move.
const SHARE: f64 = 0.9;

/// Gap that growth leaves between surfaces, as a share of the shorter side. Much larger than the
/// rounding of positions, so that no pair starts a run in contact; too small to cost density.
const MARGIN: f64 = 1e-10;

/// Least gap that growth leaves between surfaces, in roundings of the longer side. Pairs that turn
/// fast and start nearer may sink into each other by some thousand roundings.
const ROUNDINGS: f64 = 1e5;

/// Room that a molecule keeps, as a share of the lead of the front, unless it can grow to the
/// front. With less, molecules that hold each other by their notches collide within ever less room,
/// take all the collisions of a run, and never let go. Larger: growth takes longer.
const CLEARANCE: f64 = 0.1;

/// A molecule keeps the whole clearance from those that are at most this many times smaller. Many
/// small molecules leave a large one little room: among molecules of radius r that cover a share φ
/// of the area, the gap between a disc of radius R and the nearest of them is r²/(2 φ R) on
/// average. The clearance from still smaller molecules decreases in proportion to r²/R², so that
/// the large one grows at any ratio. Smaller: less room in mixtures of usual sizes. Larger: slower
/// growth among small molecules.
const UNLIKE: f64 = 12.0;

/// Largest lead of the front over the smallest molecule, as a share of its scale.
pub(super) const MAX_LEAD: f64 = 0.05;

/// Smallest lead of the front. With less, growth is given up in any case.
const MIN_LEAD: f64 = 1e-6;

/// The lead changes by this factor from step to step.
const CHANGE_OF_LEAD: f64 = 1.1;

/// The front advances faster if more than this share of the molecules stand at it, else more
/// slowly. Smaller: faster growth that jams at lower density. Larger: slower growth.
const FOLLOWERS: f64 = 0.95;

/// So many molecules may stay behind the front in any case: two that hold each other do not slow
/// down the growth of a few others.
const STRAGGLERS: usize = 2;

/// Molecules that grow among the other bodies of a world.
pub(super) struct Packing<'a> {
    /// Single bodies, and from `first` on the molecules of the gases.
    pub world: &'a World,
    pub first: usize,
    pub species: &'a [Species],
}

impl Packing<'_> {
    /// Increases the scales of the molecules, in random order; returns the number of them that are
    /// then still behind the front.
    pub fn grow(&self, scales: &mut [f64], lead: f64, random: &mut Pcg64) -> usize {
        let step = GrowthStep::new(self, scales, lead);
        let front = step.front;
        let mut order: Vec<usize> = (0..scales.len())
            .filter(|&index| scales[index] < front)
            .collect();
        order.shuffle(random);
        for index in order {
            scales[index] = step
                .room_left(self.first + index, scales)
                .scale_after(scales[index], front);
        }
        scales.iter().filter(|&&scale| scale < front).count()
    }

    fn see_each_other(&self, body: usize, other: usize) -> bool {
        let [a, b] = [body, other].map(|index| &self.world.bodies[index]);
        self.world.pairs.sees(&a.kind.tags, &b.kind.tags)
    }

    /// All bodies, listed with the radii that they may have at the end of the step.
    fn sites(&self, scales: &[f64], molecules: &[&Molecule], front: f64) -> Sites {
        let mut sites = Sites::new(self.world);
        (0..self.first).for_each(|index| sites.add(self.world, index));
        for (index, (molecule, &scale)) in molecules.iter().zip(scales).enumerate() {
            let radius = scale.max(front) * molecule.bounding_radius();
            sites.add_with_radius(self.world, self.first + index, radius);
        }
        sites
    }
}

/// A step of the growth.
struct GrowthStep<'a> {
    packing: &'a Packing<'a>,
    /// Molecules at scale 1.
    molecules: Vec<&'a Molecule>,
    /// Rotations of all bodies.
    rotations: Vec<DVec2>,
    sites: Sites,
    /// The scale beyond which no molecule grows.
    front: f64,
    /// Room that a molecule behind the front keeps, as a share of its size at scale 1.
    clearance: f64,
    /// Gap between surfaces (length).
    margin: f64,
}

impl<'a> GrowthStep<'a> {
    fn new(packing: &'a Packing<'a>, scales: &[f64], lead: f64) -> Self {
        let smallest = scales.iter().copied().fold(1.0, f64::min);
        let front = (smallest * (1.0 + lead)).min(1.0);
        let of = |kind: &'a Species| (0..kind.count).map(|index| &**kind.molecule(index));
        let molecules: Vec<&Molecule> = packing.species.iter().flat_map(of).collect();
        let motions = packing.world.motions.iter();
        let sides = packing.world.bounds.sides();
        Self {
            packing,
            rotations: motions.map(|motion| motion.orientation.cos_sin()).collect(),
            sites: packing.sites(scales, &molecules, front),
            molecules,
            front,
            clearance: CLEARANCE * (front - smallest),
            margin: (MARGIN * sides.min_element())
                .max(ROUNDINGS * f64::EPSILON * sides.max_element()),
        }
    }

    /// A body, of which the molecules have these scales.
    fn scaled(&self, body: usize, scales: &[f64]) -> Scaled<'a> {
        let rotation = self.rotations[body];
        match body.checked_sub(self.packing.first) {
            None => Scaled {
                molecule: self.packing.world.bodies[body].molecule(),
                rotation,
                scale: 1.0,
            },
            Some(gas) => Scaled {
                molecule: self.molecules[gas],
                rotation,
                scale: scales[gas],
            },
        }
    }

    /// The room that its neighbours leave a body.
    fn room_left(&self, body: usize, scales: &[f64]) -> Room {
        let (front, clearance, margin) = (self.front, self.clearance, self.margin);
        let world = self.packing.world;
        let (own, place) = (self.scaled(body, scales), world.motions[body].position);
        let mut room_left = Room {
            least: f64::INFINITY,
            kept: f64::INFINITY,
            is_free: true,
        };
        let reach = (front + clearance) * own.molecule.bounding_radius() + margin;
        let sites = &self.sites;
        sites.for_each_body_near(world, place, reach, |other, separation| {
            if other == body || !self.packing.see_each_other(body, other) {
                return;
            }
            let there = self.scaled(other, scales);
            let distance = reach + there.scale * there.molecule.bounding_radius();
            let is_near =
                there.molecule.is_wall() || separation.length_squared() <= distance * distance;
            if is_near {
                // Single bodies are held at their places: collisions do not make room there.
                let is_held = other < self.packing.first;
                let share = if is_held {
                    1.0
                } else {
                    clearance_share(there.molecule, own.molecule)
                };
                let touching = room(there, own, -separation, margin);
                room_left.reduce(touching, share * clearance, front);
            }
        });
        room_left
    }
}

/// The scales to which a molecule can grow.
struct Room {
    /// The smallest scale at which it touches a neighbour.
    least: f64,
    /// The largest scale at which it keeps its clearance from all neighbours.
    kept: f64,
    /// Whether it can grow to the front and keep its clearance there.
    is_free: bool,
}

impl Room {
    /// Adds a neighbour that is touched at the scale `touching`.
    fn reduce(&mut self, touching: f64, clearance: f64, front: f64) {
        self.least = self.least.min(touching);
        self.kept = self.kept.min(touching - clearance);
        self.is_free &= touching >= front + clearance;
    }

    /// The scale after the step of a molecule of this scale.
    fn scale_after(&self, scale: f64, front: f64) -> f64 {
        if self.is_free {
            front
        } else {
            (scale + SHARE * (self.least - scale))
                .min(self.kept)
                .max(scale)
        }
    }
}

/// The share of the clearance that a molecule keeps from another; see [`UNLIKE`].
fn clearance_share(other: &Molecule, own: &Molecule) -> f64 {
    let ratio = UNLIKE * other.bounding_radius() / own.bounding_radius();
    if ratio < 1.0 { ratio * ratio } else { 1.0 }
}

/// The lead of the front in the next step, if this number of the molecules are behind the front.
pub(super) fn next_lead(lead: f64, behind: usize, molecules: usize) -> f64 {
    let is_followed =
        behind <= STRAGGLERS || (behind as f64) < (1.0 - FOLLOWERS) * molecules as f64;
    if is_followed {
        (lead * CHANGE_OF_LEAD).min(MAX_LEAD)
    } else {
        (lead / CHANGE_OF_LEAD).max(MIN_LEAD)
    }
}

/// Gives the molecules of the gases, the bodies from `first` on, these scales. Rotational energies
/// stay, so that the spin of a molecule changes in proportion to 1/scale.
pub(super) fn resize(
    world: &mut World,
    first: usize,
    species: &[Species],
    before: &[f64],
    scales: &[f64],
) -> Result<(), SceneError> {
    let World {
        bodies, motions, ..
    } = world;
    let mut index = 0;
    for kind in species {
        // Most molecules of a kind stand at the front: equal ones share a description.
        let mut last: Option<(f64, Arc<BodyKind>)> = None;
        for molecule in 0..kind.count {
            let (body, motion) = (&mut bodies[first + index], &mut motions[first + index]);
            if scales[index] != before[index] {
                motion.angular_velocity *= before[index] / scales[index];
                body.kind = match &last {
                    Some((scale, shared)) if kind.is_equal() && *scale == scales[index] => {
                        Arc::clone(shared)
                    }
                    _ => Arc::new(kind_at(kind, molecule, scales[index])?),
                };
                last = Some((scales[index], Arc::clone(&body.kind)));
            }
            index += 1;
        }
    }
    Ok(())
}

/// A molecule of a gas at a scale, of mass 1; at scale 1 its shape is that of the scene to the bit.
pub(super) fn kind_at(kind: &Species, index: usize, scale: f64) -> Result<BodyKind, SceneError> {
    let whole = kind.molecule(index);
    let molecule = if scale == 1.0 {
        Arc::clone(whole)
    } else {
        Arc::new(whole.scaled(scale).map_err(geometry(&kind.entry))?)
    };
    let inertia = match kind.spec.rotation {
        Rotation::Free => Inertia::free(1.0, gyration_squared(whole) * scale * scale),
        Rotation::Locked => Inertia::locked(1.0),
    };
    Ok(BodyKind {
        molecule,
        inertia,
        tags: kind.pair_tags.clone(),
        tag_class: 0,
        has_rough_contacts: false,
        temperature: None,
    })
}

/// Square of the radius of gyration of a molecule at scale 1 (length²).
pub(super) fn gyration_squared(molecule: &Molecule) -> f64 {
    molecule.moment_of_inertia() / molecule.mass()
}
