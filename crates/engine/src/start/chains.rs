//! Placement of chains: member by member at random, each at a free place within the bounds of the
//! tether to the one before, and so that no two bonds cross.
//!
//! Bonds that cross would stay so: discs cannot pass between two that are tied nearer to each other
//! than the diagonal of a square of discs.

use std::{collections::HashMap, f64::consts::PI, sync::Arc};

use carom_geometry::PeriodicBox;
use carom_kinematics::{Motion, Orientation};
use glam::DVec2;
use rand::RngExt;
use rand_pcg::Pcg64;

use crate::{
    scene::{bond_spec::ChainSpec, error::SceneError, random::direction},
    start::{
        body_builder::insert,
        bonds::{MAX_SHARE, contact_length},
        place::{Place, TRIALS},
        sites::Sites,
        species::Species,
    },
    world::World,
};

/// Places tried for a member before the members before it are taken back. Fewer: more dead ends.
/// More: each takes longer.
const TRIALS_OF_MEMBER: usize = 256;

/// Dead ends of a chain after which it is given up. Fewer: chains that would fit are refused. More:
/// a refusal takes longer.
const DEAD_ENDS: u32 = 4096;

/// (1 + √5)/2
const GOLDEN_RATIO: f64 = 1.618_033_988_749_895;

/// Share of the room of a tether that is left free at each of its bounds.
const MARGIN: f64 = 1e-3;

/// Chains that have places.
pub(crate) struct PlacedChains {
    /// A world that holds them, too.
    pub world: World,
    /// The places of the molecules of each gas; none of gases without chains.
    pub places: Vec<Vec<Place>>,
}

/// Places the gases of chains around the bodies of a world; `None` without chains.
///
/// # Errors
/// [`SceneError::Full`] if they do not fit.
pub(crate) fn place(
    world: &World,
    species: &[Species],
    random: &mut Pcg64,
) -> Result<Option<PlacedChains>, SceneError> {
    let chains = || {
        species
            .iter()
            .filter_map(|gas| Some((gas, gas.spec.chain.as_ref()?)))
    };
    let Some(longest) = chains().map(|(_, chain)| reach(chain)).reduce(f64::max) else {
        return Ok(None);
    };
    for (gas, chain) in chains() {
        refuse_long_tether(gas, chain, world)?;
    }
    let mut room = Room::new(world, species, longest);
    let mut places = vec![Vec::new(); species.len()];
    for (gas, places) in species.iter().zip(&mut places) {
        let Some(chain) = &gas.spec.chain else {
            continue;
        };
        refuse_impossible_members(gas, chain, world)?;
        for start in (0..gas.count).step_by(chain.members) {
            let motions = room.place_chain(gas, chain, start, random)?;
            places.extend(motions.iter().map(|motion| Place {
                at: motion.position,
                orientation: Some(motion.orientation),
            }));
        }
    }
    Ok(Some(PlacedChains {
        world: room.world,
        places,
    }))
}

/// The largest distance of the centres of two members that are tied (length).
fn reach(chain: &ChainSpec) -> f64 {
    let arms = chain.tether.points.map(|point| DVec2::from(point).length());
    chain.tether.max + arms[0] + arms[1]
}

/// Refuses tethers so long that two images of a member are equally near.
fn refuse_long_tether(gas: &Species, chain: &ChainSpec, world: &World) -> Result<(), SceneError> {
    let side = world.bounds().sides().min_element();
    if reach(chain) > MAX_SHARE * side {
        let problem = format!(
            "`chain.tether.max` lets the centres of members be {:?} apart (length), so that two images are equally near: \
             it must be less than half the shorter side, {:?}",
            reach(chain),
            0.5 * side
        );
        return Err(SceneError::of_entry(&gas.entry, problem));
    }
    Ok(())
}

/// Refuses members that overlap each other at any length of the tether.
fn refuse_impossible_members(
    gas: &Species,
    chain: &ChainSpec,
    world: &World,
) -> Result<(), SceneError> {
    let [shortest, longest] = gas.room_of_tether(chain, [0; 2], world);
    if gas.is_equal() && shortest >= longest {
        let problem = "the members of a chain, discs tied at their centres, touch each other beyond \
                       `chain.tether.max`: give a longer tether, or make them transparent to each other";
        return Err(SceneError::of_entry(&gas.entry, problem));
    }
    let most = gas.most_arms(chain, world);
    if chain.arms > most {
        let problem = format!(
            "a star of {} `chain.arms` does not fit: at most {most} discs have room around one within \
             `chain.tether.max`; give fewer arms or a longer tether",
            chain.arms
        );
        return Err(SceneError::of_entry(&gas.entry, problem));
    }
    Ok(())
}

/// The bodies of a world and the chains placed so far.
struct Room {
    world: World,
    sites: Sites,
    bonds: BondCells,
}

/// The bonds placed so far, by the cells of their first ends.
struct BondCells {
    bounds: PeriodicBox,
    /// Cells along each axis, each at least as long as two bonds.
    counts: [i64; 2],
    cells: HashMap<[i64; 2], Vec<[DVec2; 2]>>,
}

impl BondCells {
    fn new(bounds: PeriodicBox, longest: f64) -> Self {
        let counts = (bounds.sides() / (2.0 * longest)).floor();
        let counts = counts.clamp(DVec2::ONE, DVec2::splat(f64::from(1 << 20)));
        Self {
            bounds,
            counts: [counts.x as i64, counts.y as i64],
            cells: HashMap::new(),
        }
    }

    fn cell(&self, place: DVec2) -> [i64; 2] {
        let (place, _) = self.bounds.wrap(place);
        let share = place / self.bounds.sides();
        [0, 1].map(|axis| {
            ((share[axis] * self.counts[axis] as f64) as i64).min(self.counts[axis] - 1)
        })
    }

    fn add(&mut self, bond: [DVec2; 2]) {
        self.cells.entry(self.cell(bond[0])).or_default().push(bond);
    }

    fn remove_last(&mut self, from: DVec2) {
        if let Some(bonds) = self.cells.get_mut(&self.cell(from)) {
            bonds.pop();
        }
    }

    /// Whether a bond crosses one that is there, apart from those that end where it begins.
    fn cross(&self, [from, to]: [DVec2; 2]) -> bool {
        let [x, y] = self.cell(from);
        let mut around: Vec<[i64; 2]> = (-1..=1)
            .flat_map(|up| (-1..=1).map(move |across| [x + across, y + up]))
            .map(|cell| [0, 1].map(|axis| cell[axis].rem_euclid(self.counts[axis])))
            .collect();
        around.sort_unstable();
        around.dedup();
        let bonds = around
            .iter()
            .filter_map(|cell| self.cells.get(cell))
            .flatten();
        bonds.into_iter().any(|&[begin, end]| {
            let begin_here = from + self.bounds.nearest_image(begin - from);
            let end_here = begin_here + (end - begin);
            let is_next =
                begin_here == from || (end_here - from).length() < 1e-9 * (to - from).length();
            let side = |a: DVec2, b: DVec2, point: DVec2| (b - a).perp_dot(point - a);
            !is_next
                && side(from, to, begin_here) * side(from, to, end_here) < 0.0
                && side(begin_here, end_here, from) * side(begin_here, end_here, to) < 0.0
        })
    }
}

impl Room {
    /// The bodies of a world, with cells for all molecules of these gases and for bonds of this
    /// length.
    fn new(world: &World, species: &[Species], longest: f64) -> Self {
        let sizes = species.iter().flat_map(|gas| {
            let radius = |index| gas.molecule(index).bounding_radius();
            gas.groups()
                .map(move |(index, count)| (radius(index), count))
        });
        let mut room = Self {
            sites: Sites::with_more(world, sizes),
            world: world.clone(),
            bonds: BondCells::new(*world.bounds(), longest),
        };
        for body in 0..world.bodies().len() {
            room.sites.add(world, body);
        }
        room
    }

    /// Places the chain of a gas whose first member has the index `start`.
    fn place_chain(
        &mut self,
        gas: &Species,
        chain: &ChainSpec,
        start: usize,
        random: &mut Pcg64,
    ) -> Result<Vec<Motion>, SceneError> {
        let full = || SceneError::Full {
            entry: gas.entry.clone(),
            placed: start,
            requested: gas.count,
        };
        if chain.ring {
            return self.place_ring(gas, chain, start, random).ok_or_else(full);
        }
        let mut motions: Vec<Motion> = Vec::with_capacity(chain.members);
        let mut dead_ends = 0;
        while motions.len() < chain.members {
            let member = motions.len();
            let index = start + member;
            let found = if member == 0 {
                std::iter::repeat_with(|| self.anywhere(gas, random))
                    .take(TRIALS)
                    .find(|motion| self.is_free(gas, index, motion))
            } else {
                let before = motions[chain.before(member)];
                let bodies = [start + chain.before(member), index];
                (0..TRIALS_OF_MEMBER)
                    .map(|_| self.next(gas, chain, (&before, bodies), random))
                    .find(|motion| {
                        self.is_free(gas, index, motion)
                            && !self.bonds.cross([before.position, motion.position])
                    })
            };
            if let Some(motion) = found {
                self.take(gas, index, motion);
                if member > 0 {
                    let before = motions[chain.before(member)];
                    self.bonds.add([before.position, motion.position]);
                }
                motions.push(motion);
                continue;
            }
            dead_ends += 1;
            if member == 0 || dead_ends > DEAD_ENDS {
                return Err(full());
            }
            // Further back each time, since the way out may have been missed long before.
            let back = 1 << (dead_ends % 12);
            for _ in 0..member.min(back) {
                motions.pop();
                self.give_back();
                if !motions.is_empty() {
                    let before = motions[chain.before(motions.len())];
                    self.bonds.remove_last(before.position);
                }
            }
        }
        Ok(motions)
    }

    /// Places the ring of a gas whose first member has the index `start`, as a regular polygon.
    fn place_ring(
        &mut self,
        gas: &Species,
        chain: &ChainSpec,
        start: usize,
        random: &mut Pcg64,
    ) -> Option<Vec<Motion>> {
        let spacing = gas.spacing_of_ring(chain, start, &self.world)?;
        let radius = 0.5 * spacing / (PI / chain.members as f64).sin();
        for _ in 0..TRIALS {
            let at = self.anywhere(gas, random);
            let member = |number: usize| {
                let turns = at.orientation.turns() + number as f64 / chain.members as f64;
                let outwards = Orientation::from_turns(turns.fract()).cos_sin();
                Motion {
                    position: at.position + radius * outwards,
                    ..at
                }
            };
            let motions: Vec<Motion> = (0..chain.members).map(member).collect();
            let ends = motions.iter().zip(motions.iter().cycle().skip(1));
            let sides: Vec<_> = ends.map(|(a, b)| [a.position, b.position]).collect();
            let mut numbered = (start..).zip(&motions);
            if numbered.all(|(index, motion)| self.is_free(gas, index, motion))
                && !sides.iter().any(|side| self.bonds.cross(*side))
            {
                for (index, motion) in (start..).zip(&motions) {
                    self.take(gas, index, *motion);
                }
                for side in sides {
                    self.bonds.add(side);
                }
                return Some(motions);
            }
        }
        None
    }

    /// A molecule at rest, at random in the region of its gas.
    fn anywhere(&self, gas: &Species, random: &mut Pcg64) -> Motion {
        let region = gas.spec.region.unwrap_or_default();
        Motion {
            orientation: Orientation::from_turns(random.random()),
            ..Motion::at_rest(region.draw(self.world.bounds(), random))
        }
    }

    /// A place at random for a member that is tied to the one before.
    fn next(
        &self,
        gas: &Species,
        chain: &ChainSpec,
        (before, bodies): (&Motion, [usize; 2]),
        random: &mut Pcg64,
    ) -> Motion {
        let [of_before, of_next] = chain.tether.points.map(DVec2::from);
        let [shortest, longest] = gas.room_of_tether(chain, bodies, &self.world);
        let share: f64 = random.random();
        // Uniform over the area between the bounds.
        let squared = shortest * shortest + share * (longest * longest - shortest * shortest);
        let orientation = Orientation::from_turns(random.random());
        let from = before.position + before.orientation.cos_sin().rotate(of_before);
        let to = from + squared.max(0.0).sqrt() * direction(random);
        Motion {
            orientation,
            ..Motion::at_rest(to - orientation.cos_sin().rotate(of_next))
        }
    }

    fn is_free(&self, gas: &Species, index: usize, motion: &Motion) -> bool {
        let molecule = gas.molecule(index);
        let (position, _) = self.world.bounds().wrap(motion.position);
        let wrapped = Motion {
            position,
            ..*motion
        };
        let region = gas.spec.region.unwrap_or_default();
        region.contains(self.world.bounds(), position)
            && self
                .sites
                .nearest(&self.world, molecule, &wrapped, &gas.pair_tags)
                .is_none_or(|(_, gap)| gap > 0.0)
    }

    /// Adds a molecule.
    fn take(&mut self, gas: &Species, index: usize, motion: Motion) {
        let molecule = Arc::clone(gas.molecule(index));
        let tags = gas.pair_tags.clone();
        insert(&mut self.world, molecule, gas.inertia(index), tags, motion);
        self.sites.add(&self.world, self.world.bodies.len() - 1);
    }

    /// Removes the molecule added last.
    fn give_back(&mut self) {
        self.sites.remove(&self.world, self.world.bodies.len() - 1);
        self.world.take_back_last();
    }
}

impl Species {
    /// The lengths between which a tether of two neighbours in a chain starts: those at which discs
    /// tied at their centres do not overlap.
    fn room_of_tether(&self, chain: &ChainSpec, bodies: [usize; 2], world: &World) -> [f64; 2] {
        let tether = &chain.tether;
        let factor = world.pairs.factor_of_tags(&self.pair_tags, &self.pair_tags);
        let molecules = bodies.map(|body| &**self.molecule(body));
        let points = tether.points.map(DVec2::from);
        let shortest = contact_length(points, molecules, factor).max(tether.min);
        let margin = MARGIN * (tether.max - shortest);
        [shortest + margin, tether.max - margin]
    }

    /// The largest number of arms of a star: where the members are equal discs tied at their
    /// centres, as many of them as touch each other at the longest distance from the first. Where
    /// that is longer than the golden ratio times the distance at contact, more have room at
    /// different distances (x³ − 2x² + 1 > 0 for the ratio x), and there is no bound.
    fn most_arms(&self, chain: &ChainSpec, world: &World) -> usize {
        let disc = self.molecule(0);
        if !self.is_equal() || !disc.is_disc() || chain.tether.points != [[0.0; 2]; 2] {
            return usize::MAX;
        }
        let factor = world.pairs.factor_of_tags(&self.pair_tags, &self.pair_tags);
        let share = factor * disc.bounding_radius() / chain.tether.max;
        if 0.5 / share > GOLDEN_RATIO {
            return usize::MAX;
        }
        (PI / libm::asin(share)) as usize
    }

    /// The distance of neighbours in a ring of equal sides; `None` if there is none that all
    /// tethers allow.
    fn spacing_of_ring(&self, chain: &ChainSpec, start: usize, world: &World) -> Option<f64> {
        let rooms = (0..chain.members).map(|member| {
            let next = (member + 1) % chain.members;
            self.room_of_tether(chain, [start + member, start + next], world)
        });
        let [shortest, longest] = rooms.fold([0.0, f64::INFINITY], |[low, high], [from, to]| {
            [f64::max(low, from), f64::min(high, to)]
        });
        (shortest < longest).then_some(0.5 * (shortest + longest))
    }
}
