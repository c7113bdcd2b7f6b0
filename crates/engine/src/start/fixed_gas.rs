//! The molecules of fixed gases: obstacles at random places.
//!
//! Molecules that may overlap have independent places, uniform in the box: those of a Poisson
//! process with a given number of points. Others are added one by one, each at the first place of a
//! uniform sequence at which it overlaps none of the bodies placed before (random sequential
//! addition), which for equal discs ends near an area fraction of 0.547 (J. Feder, J. Theor. Biol.
//! 87 (1980) 237).

use std::sync::Arc;

use carom_geometry::PeriodicBox;
use carom_kinematics::{Inertia, Motion, Orientation};
use rand::RngExt;
use rand_pcg::Pcg64;

use crate::{
    scene::{BoxSpec, error::SceneError, random::RandomStream},
    start::{
        body_builder::insert, place::TRIALS, single_bodies::Singles, sites::Sites, species::Species,
    },
};

/// Adds the molecules of a fixed gas to the single bodies. `index` is that of the gas in the scene:
/// its places do not depend on the gases before it, unless they must not overlap.
///
/// # Errors
/// [`SceneError::Entry`] if the molecules do not fit.
pub(crate) fn place(
    singles: &mut Singles,
    gas: &Species,
    bounds: &BoxSpec,
    index: usize,
) -> Result<(), SceneError> {
    let mut random = RandomStream::Obstacles.generator(bounds.seed, bounds.replica);
    // A gas needs fewer than 2^64 numbers.
    random.advance((index as u128) << 64);
    let Singles {
        world,
        names,
        entries,
    } = singles;
    let tags = names.intern_all(&gas.spec.tags);
    let sizes = gas
        .groups()
        .map(|(index, count)| (gas.molecule(index).bounding_radius(), count));
    let mut sites = Sites::with_more(world, sizes);
    for body in 0..world.bodies.len() {
        if !(gas.spec.overlapping && world.bodies[body].is_fixed()) {
            sites.add(world, body);
        }
    }
    for molecule in 0..gas.count {
        let shape = gas.molecule(molecule);
        let is_free = |motion: &Motion| {
            let region = gas.spec.region.unwrap_or_default();
            region.contains(world.bounds(), motion.position)
                && sites
                    .nearest(world, shape, motion, &tags)
                    .is_none_or(|(_, gap)| gap > 0.0)
        };
        let place = std::iter::repeat_with(|| drawn(gas, world.bounds(), &mut random))
            .take(TRIALS)
            .find(is_free);
        let Some(motion) = place else {
            return Err(full(gas, molecule));
        };
        insert(
            world,
            Arc::clone(shape),
            Inertia::FIXED,
            tags.clone(),
            motion,
        );
        entries.push(gas.entry.clone());
        if !gas.spec.overlapping {
            sites.add(world, world.bodies.len() - 1);
        }
    }
    Ok(())
}

/// A molecule at rest at a uniform place in the region of its gas, of random orientation.
fn drawn(gas: &Species, bounds: &PeriodicBox, random: &mut Pcg64) -> Motion {
    let region = gas.spec.region.unwrap_or_default();
    let place = region.draw(bounds, random);
    Motion {
        orientation: Orientation::from_turns(random.random()),
        ..Motion::at_rest(place)
    }
}

fn full(gas: &Species, placed: usize) -> SceneError {
    let remedy = if gas.spec.overlapping {
        "a `[[molecule]]` that moves leaves them no place"
    } else {
        "equal discs added at random cover 0.547 of the area at most: give fewer, or `overlapping = true`"
    };
    let problem = format!(
        "only {placed} of {} fixed molecules find a place without overlap; {remedy}",
        gas.count
    );
    SceneError::Entry {
        entry: gas.entry.clone(),
        problem,
    }
}
