//! The bonds of a scene: its lists, and those along the chains of its gases.

use carom_geometry::Molecule;
use carom_response::Elasticity;
use glam::DVec2;

use crate::{
    contact::elasticity_table::ElasticityTable,
    scene::{
        Scene,
        bond_spec::{BondSpec, TetherSpec},
        error::SceneError,
    },
    start::species::Species,
    world::{
        World,
        body::Body,
        rounding_bound::rounding_bound,
        tethers::{Bond, Tethers},
    },
};

/// Largest share of the side of the box that the centres of two tethered bodies, or of two discs in
/// a well, may be apart: at half a side, another image would be as near.
pub(crate) const MAX_SHARE: f64 = 0.5 - 1e-6;

/// Smallest room of a tether, and width of the step of a well, as a share of the longer side.
/// Smaller: positions are rounded by more than 10⁻⁵ of the room, and a run makes more events than
/// it can.
pub(crate) const MIN_ROOM: f64 = 1e-10;

/// Ties the bodies of a scene, of which the molecules of the gases begin at index `first`.
///
/// # Errors
/// A bond that cannot be, with its entry.
pub(crate) fn tie(
    world: &mut World,
    scene: &Scene,
    species: &[Species],
    first: usize,
) -> Result<(), SceneError> {
    let count = first + species.iter().map(|gas| gas.count).sum::<usize>();
    let mut bonds = Vec::new();
    for (index, spec) in scene.bond.iter().enumerate() {
        let entry = format!("bond[{index}]");
        for pair in &spec.pairs {
            let body = |number: u64| usize::try_from(number).ok().filter(|body| *body < count);
            bonds.push(bond(
                &entry,
                pair.map(|number| (number, body(number))),
                &spec.tether,
            )?);
        }
    }
    let mut begin = first;
    for gas in species {
        if let Some(chain) = &gas.spec.chain {
            let chained = |member: usize, other: usize| {
                let bodies = [member, other].map(|body| (body as u64, Some(body)));
                bond(&gas.entry, bodies, &chain.tether)
            };
            for start in (begin..begin + gas.count).step_by(chain.members) {
                for member in 1..chain.members {
                    bonds.push(chained(start + chain.before(member), start + member)?);
                }
                if chain.ring {
                    bonds.push(chained(start + chain.members - 1, start)?);
                }
            }
        }
        begin += gas.count;
    }
    world.tethers = Tethers::new(bonds);
    Ok(())
}

/// The bonds of an entry between bodies of which `index` gives the places, by the numbers of their
/// keys.
pub(crate) fn bonds_between(
    index: impl Fn(u64) -> Option<usize>,
    entry: &str,
    spec: &BondSpec,
) -> Result<Vec<Bond>, SceneError> {
    let of_pair = |pair: &[u64; 2]| {
        bond(
            entry,
            pair.map(|number| (number, index(number))),
            &spec.tether,
        )
    };
    spec.pairs.iter().map(of_pair).collect()
}

/// A bond of two bodies, given by their numbers, and by their indices if they are there.
fn bond(
    entry: &str,
    bodies: [(u64, Option<usize>); 2],
    spec: &TetherSpec,
) -> Result<Bond, SceneError> {
    let problem = |problem: String| SceneError::of_entry(entry, problem);
    for (number, body) in bodies {
        if body.is_none() {
            return Err(problem(format!("there is no body number {number}")));
        }
    }
    let [a, b] = bodies.map(|(_, body)| body.unwrap_or_default() as u32);
    if a == b {
        return Err(problem(format!("body number {a} cannot be tied to itself")));
    }
    let (tether, elasticity) = spec.checked().map_err(problem)?;
    Ok(Bond {
        bodies: [a.min(b), a.max(b)],
        tether: if a < b { tether } else { tether.exchanged() },
        elasticity,
    })
}

/// Refuses bonds that cannot be in this world, or that lose energy without a guard; `entry` names a
/// body.
///
/// # Errors
/// [`SceneError::Entry`] of the first of them.
pub(crate) fn refuse_bonds(
    world: &World,
    elasticity: &ElasticityTable,
    entry: impl Fn(usize) -> String,
) -> Result<(), SceneError> {
    refuse_impossible(world, &entry)?;
    let loses = |bond: &&Bond| bond.elasticity != Elasticity::ELASTIC;
    match world.bonds().iter().find(loses) {
        Some(bond) if elasticity.guard.contact_time == 0.0 => {
            let problem = "loses energy, and needs a guard against inelastic collapse, `elasticity.contact_time` above \
                           0: points that come to rest on a taut tether follow it by events without end";
            Err(problem_of(bond, &entry, problem))
        }
        _ => Ok(()),
    }
}

/// Refuses bonds that are beyond their bounds by more than rounding; `entry` names a body.
///
/// # Errors
/// [`SceneError::Entry`] of the first of them.
pub(crate) fn refuse_stretched(
    world: &World,
    entry: impl Fn(usize) -> String,
) -> Result<(), SceneError> {
    let sides = world.bounds().sides();
    for bond in world.bonds() {
        let excess = world.excess_of_bond(bond);
        if excess > rounding_bound(sides, bond.tether.reach()) {
            let [shortest, longest] = bond.tether.bounds();
            let problem =
                format!("is {excess:?} (length) beyond its bounds, {shortest:?} and {longest:?}");
            return Err(problem_of(bond, &entry, problem));
        }
    }
    Ok(())
}

/// An error of a bond.
pub(crate) fn problem_of(
    bond: &Bond,
    entry: impl Fn(usize) -> String,
    problem: impl Into<String>,
) -> SceneError {
    let [a, b] = bond.bodies.map(|body| entry(body as usize));
    SceneError::of_entry(&format!("the bond of {a} and {b}"), problem)
}

/// The length below which two discs tied at their centres overlap; 0 for other bodies, which may
/// overlap at any length. `factor` is that of the pair on the distance at contact.
pub(crate) fn contact_length(points: [DVec2; 2], molecules: [&Molecule; 2], factor: f64) -> f64 {
    if points == [DVec2::ZERO; 2] && molecules.iter().all(|molecule| molecule.is_disc()) {
        let [a, b] = molecules.map(Molecule::bounding_radius);
        factor * (a + b)
    } else {
        0.0
    }
}

/// Refuses bonds of bodies that cannot be tied, and where images are ambiguous.
fn refuse_impossible(world: &World, entry: impl Fn(usize) -> String) -> Result<(), SceneError> {
    for bond in world.bonds() {
        let problem = problem_of_lengths(world, bond).or_else(|| problem_of_bodies(world, bond));
        if let Some(problem) = problem {
            return Err(problem_of(bond, &entry, problem));
        }
    }
    Ok(())
}

/// What is wrong with the bounds of a bond in this box, if anything.
fn problem_of_lengths(world: &World, bond: &Bond) -> Option<String> {
    let sides = world.bounds.sides();
    let reach = bond.tether.reach();
    if reach > MAX_SHARE * sides.min_element() {
        return Some(format!(
            "lets their centres be {reach:?} apart (length), so that two images are equally near: it must \
             be less than half the shorter side, {:?}",
            0.5 * sides.min_element()
        ));
    }
    let bodies = bond.bodies.map(|body| &world.bodies[body as usize]);
    let [shortest, longest] = bond.tether.bounds();
    let factor = world.pairs.factor(bodies[0], bodies[1]);
    let molecules = bodies.map(Body::molecule);
    let shortest = shortest.max(contact_length(bond.tether.points(), molecules, factor));
    let least = MIN_ROOM * sides.max_element();
    (longest - shortest < least).then(|| {
        format!(
            "leaves its length a room of {:?}: it must be at least 1e-10 of the longer side, {least:?} (length)",
            longest - shortest
        )
    })
}

/// What forbids to tie the bodies of a bond, if anything.
fn problem_of_bodies(world: &World, bond: &Bond) -> Option<String> {
    let bodies = bond.bodies.map(|body| &world.bodies[body as usize]);
    let beside = bond.tether.points().map(|point| point != DVec2::ZERO);
    let is_held = |n: usize| {
        let body = bodies[n];
        let turns = body.inertia().inverse_moment > 0.0;
        beside[n] && body.molecule().is_round() && turns && !body.can_turn()
    };
    let problem = if bodies.iter().any(|body| body.is_wall()) {
        "ties a wall: tie bodies to bumpers instead"
    } else if bodies.iter().all(|body| !body.is_free()) {
        "ties two fixed bodies"
    } else if world.has_gravity() && bodies.iter().any(|body| !body.is_free()) {
        "ties a fixed body, which does not go with gravity"
    } else if is_held(0) || is_held(1) {
        "ties a disc beside its centre, but its contacts are smooth, so that it does not turn: tie it at its \
         centre, lock it, or make its contacts rough (`elasticity.tangential`)"
    } else if world.is_sheared() {
        "does not go with a shear"
    } else {
        return None;
    };
    Some(problem.to_owned())
}
