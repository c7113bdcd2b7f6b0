//! The dilute state from which gases grow: small molecules on a lattice, in motion.

use std::f64::consts::PI;

use carom_kinematics::Motion;

use super::packing::gyration_squared;
use crate::{
    grid::{CellsPerSide, Grid},
    scene::{Scene, error::SceneError, random::RandomStream},
    start::{
        contents::SceneContents,
        placement::{self, Budget},
        species::{Species, sample},
        velocities::{either_way, opposite_directions},
    },
    world::World,
};

/// Share of the box that the bounding circles cover at the start, at most. Smaller: more steps.
/// Larger: rods and other long molecules start in the order of the lattice, and may not fit around
/// other bodies.
const DILUTE: f64 = 0.3;

/// Factor from one start that does not fit to the next, and the number of starts tried; the last
/// has molecules a million times smaller than in the scene.
const SMALLER: f64 = 0.8;
const TRIALS: usize = 64;

/// Refuses gases that cannot fit at any arrangement: those that cover more than the box, equal
/// discs above the density of the hexagonal lattice (A. Thue 1910; L. Fejes Tóth 1940), and
/// molecules larger than the box.
pub(super) fn refuse_impossible(contents: &SceneContents) -> Result<(), SceneError> {
    let (species, pairs) = (&contents.species, &contents.singles.world.pairs);
    let area = contents.singles.world.bounds().area();
    let covered = species.iter().map(Species::area).sum::<f64>() / area;
    let mut kinds = species.iter().filter(|kind| kind.count > 0);
    let first = kinds.next();
    // Molecules that do not see each other may cover the box any number of times.
    if let Some(first) = first
        && !pairs.has_rules()
        && covered > densest(first, kinds)
    {
        let requested: usize = species.iter().map(|kind| kind.count).sum();
        let placed = (requested as f64 / covered) as usize;
        return Err(SceneError::Full {
            entry: first.entry.clone(),
            placed,
            requested,
        });
    }
    let (sample, counts) = sample(&contents.singles.world, species);
    Grid::counts_for(&sample, CellsPerSide::Automatic)
        .map(|_| ())
        .map_err(|reason| reason.named(|body| contents.singles.entry_of(body, &counts)))
}

/// An upper bound on the share of the box that these kinds can cover.
fn densest<'a>(first: &Species, mut others: impl Iterator<Item = &'a Species>) -> f64 {
    let radius = first.molecule(0).bounding_radius();
    let is_equal = |kind: &Species| {
        kind.is_equal()
            && kind.molecule(0).is_disc()
            && kind.molecule(0).bounding_radius() == radius
    };
    if is_equal(first) && others.all(is_equal) {
        PI / 12f64.sqrt()
    } else {
        1.0
    }
}

/// Whether gases that do not fit on a lattice may fit if they grow.
pub(super) fn may_fit(contents: &SceneContents) -> bool {
    refuse_impossible(contents).is_ok()
}

/// A scale at which the gases fit around the bodies of a world, and the motions of their molecules:
/// positions and orientations at random, and the same energy for each direction of motion of each
/// molecule, at mass 1.
pub(super) fn place(
    scene: &Scene,
    world: &World,
    species: &[Species],
) -> Result<(f64, Vec<Motion>), SceneError> {
    let bounds = &scene.bounds;
    let circle = |kind: &Species, index| PI * kind.molecule(index).bounding_radius().powi(2);
    let circles = |kind: &Species| -> f64 {
        kind.groups()
            .map(|(index, count)| count as f64 * circle(kind, index))
            .sum()
    };
    let circles: f64 = species.iter().map(circles).sum();
    let mut scale = (DILUTE * world.bounds().area() / circles).sqrt().min(1.0);
    let mut random = RandomStream::Placement.generator(bounds.seed, bounds.replica);
    let mut trial = 1;
    let mut budget = Budget::of_repetitions(species.iter().map(|kind| kind.count).sum());
    let places = loop {
        let small: Result<Vec<Species>, SceneError> =
            species.iter().map(|kind| kind.scaled(scale)).collect();
        match placement::place(world, &small?, &mut random, &mut budget) {
            Err(SceneError::Full { .. }) if trial < TRIALS && !budget.is_spent() => {}
            ended => break ended?,
        }
        scale *= SMALLER;
        trial += 1;
    };
    let mut motion = RandomStream::Growth.generator(bounds.seed, bounds.replica);
    // The molecules cross the box in a unit of time.
    let speed = world.bounds().sides().min_element();
    let mut motions = Vec::new();
    for (kind, places) in species.iter().zip(places) {
        let spin =
            |index: usize| speed / (scale * (2.0 * gyration_squared(kind.molecule(index))).sqrt());
        let spin = |index| if kind.turns() { spin(index) } else { 0.0 };
        let directions = opposite_directions(kind.count, &mut motion);
        motions.extend(places.into_iter().zip(directions).enumerate().map(
            |(index, (place, direction))| Motion {
                velocity: speed * direction,
                orientation: place.orientation(&mut random),
                angular_velocity: if spin(index) > 0.0 {
                    either_way(spin(index), &mut motion)
                } else {
                    0.0
                },
                ..Motion::at_rest(place.at)
            },
        ));
    }
    Ok((scale, motions))
}
