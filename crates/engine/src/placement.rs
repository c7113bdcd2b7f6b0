//! Placement of gases: random with a given seed, without overlap, around the bodies already in the
//! box.
//!
//! Molecules of similar size share a triangular lattice of sites, as wide as possible for their
//! number. Sites at which they would touch bodies already placed are left out, the others are
//! occupied at random, and each molecule is displaced at random as far as its neighbours' sites
//! allow. Larger kinds are placed before smaller ones. Orientations and directions of motion are
//! random; collisions complete the mixing. Where momentum is conserved along an axis, directions
//! come in opposite pairs, so that each gas of two or more molecules starts with momentum 0.

use std::sync::Arc;

use carom_geometry::{Molecule, PeriodicBox, check_length};
use carom_kinematics::{Inertia, Motion, Orientation};
use glam::DVec2;
use rand::{RngExt, seq::SliceRandom};
use rand_pcg::Pcg64;

use crate::{
    GasSpec, Rotation, Scene, SceneError, TagNames, Tags, World,
    body_builder::{geometry, inertia, insert, molecule, tags},
    centre_of_mass::conserved_momentum,
    limits::refuse_slow,
    selection::Remaining,
    sites::Sites,
};

/// A stream of random numbers; each purpose has its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RandomStream {
    /// Positions and orientations of the molecules.
    Placement = 0,
    /// Directions of motion.
    Velocities = 1,
}

impl RandomStream {
    /// Returns the random generator of this stream: PCG-64 with the state `seed` and the stream
    /// number 16 × `replica` + this stream's number.
    pub fn generator(self, seed: u64, replica: u64) -> Pcg64 {
        Pcg64::new(u128::from(seed), 16 * u128::from(replica) + self as u128)
    }
}

/// Smallest gap, relative to the size of the molecules, at which they are placed: none starts in
/// contact.
const ROOM: f64 = 1e-9;

/// Most molecules of one kind. More exceed the memory and soon the range of their counters.
const MOST_MOLECULES: usize = 1 << 27;

/// Most sites of a lattice where fewer are needed: the check of each takes about a microsecond.
const MOST_SITES: usize = 1 << 22;

/// A lattice of touching sites, the last to be tried, is thinned out if it has more sites than
/// this: in a narrow box it may have any number of sites, even if few are needed.
const FEW_SITES: usize = 1 << 20;

/// One kind of molecule to be placed.
pub(crate) struct Species<'a> {
    entry: String,
    spec: &'a GasSpec,
    molecule: Arc<Molecule>,
    count: usize,
    places: Vec<DVec2>,
}

/// The kinds of molecules of the gases of a scene.
pub(crate) fn species<'a>(scene: &'a Scene, bounds: &PeriodicBox) -> Result<Vec<Species<'a>>, SceneError> {
    scene.gas.iter().enumerate().map(|(index, spec)| Species::new(spec, index, bounds)).collect()
}

/// A world of the bodies already placed and at most two molecules of each kind, at rest at the
/// origin, and the number of molecules of each kind. The largest and the smallest contact distance
/// do not depend on that number.
pub(crate) fn sample(world: &World, species: &[Species<'_>]) -> (World, Vec<usize>) {
    let mut sample = world.clone();
    let counts: Vec<usize> = species.iter().map(|kind| kind.count.min(2)).collect();
    for (kind, &count) in species.iter().zip(&counts) {
        for _ in 0..count {
            let inertia = inertia(&kind.molecule, kind.spec.rotation);
            let motion = Motion::at_rest(DVec2::ZERO);
            insert(&mut sample, Arc::clone(&kind.molecule), inertia, Tags::default(), motion);
        }
    }
    (sample, counts)
}

/// Places all gases of the scene and sets them in motion; returns the number of bodies of each.
pub(crate) fn fill(
    world: &mut World,
    names: &mut TagNames,
    scene: &Scene,
    mut species: Vec<Species<'_>>,
) -> Result<Vec<usize>, SceneError> {
    let (seed, replica) = (scene.bounds.seed, scene.bounds.replica);
    let mut places = RandomStream::Placement.generator(seed, replica);
    let mut velocities = RandomStream::Velocities.generator(seed, replica);
    let mut by_size: Vec<usize> = (0..species.len()).collect();
    by_size.sort_by(|&i, &j| {
        let radius = |k: usize| species[k].molecule.bounding_radius();
        radius(j).total_cmp(&radius(i)).then(i.cmp(&j))
    });
    let kinds = species.iter().map(|kind| (kind.molecule.bounding_radius(), kind.count));
    let mut sites = Sites::with_more(world, kinds);
    for index in 0..world.bodies().len() {
        sites.add(world, index);
    }
    let mut rest = &by_size[..];
    while let Some(&first) = rest.first() {
        // Kinds of similar size share one lattice: around the larger ones a finer lattice might not
        // fit. If the shared lattice is too coarse for all of them, fewer share it.
        let largest = species[first].molecule.bounding_radius();
        let (mut placed, mut tried) = (Ok(0), 0);
        for share in [0.5, 0.75, 1.0] {
            let alike = rest
                .iter()
                .take_while(|&&k| species[k].molecule.bounding_radius() >= share * largest)
                .count();
            if alike == tried {
                continue;
            }
            tried = alike;
            let random = &mut places.clone();
            placed = place_class(world, &sites, &mut species, &rest[..alike], random).map(|()| alike);
            if placed.is_ok() {
                places = random.clone();
                break;
            }
        }
        let class = &rest[..placed?];
        rest = &rest[class.len()..];
        if !rest.is_empty() {
            for kind in class.iter().map(|&kind| &species[kind]) {
                kind.places.iter().for_each(|&place| sites.add_circle(world.bounds(), place, &kind.molecule));
            }
        }
    }
    // Opposite pairs by default where the whole system would otherwise drift forever.
    let keeps_momentum = conserved_momentum(world).any();
    for kind in &species {
        let directions = if kind.spec.zero_momentum.unwrap_or(keeps_momentum) {
            opposite_directions(kind.count, &mut velocities)
        } else {
            (0..kind.count).map(|_| direction(&mut velocities)).collect()
        };
        set_in_motion(world, names, kind, &directions, &mut places, &mut velocities);
    }
    Ok(species.iter().map(|kind| kind.count).collect())
}

impl<'a> Species<'a> {
    fn new(spec: &'a GasSpec, index: usize, bounds: &PeriodicBox) -> Result<Self, SceneError> {
        let entry = format!("gas[{index}]");
        let problem = |problem: &str| SceneError::Entry { entry: entry.clone(), problem: problem.to_owned() };
        let one = |first: Option<f64>, second: Option<f64>, problem_text: &str| match (first, second) {
            (Some(_), Some(_)) => Err(problem(problem_text)),
            _ => Ok(first.or(second)),
        };
        let radius = one(spec.radius, spec.atom_radius, "give either `radius` or `atom_radius`, not both")?;
        let mass = one(spec.mass, spec.atom_mass, "give either `mass` or `atom_mass`, not both")?;
        let shape = if spec.atoms.is_empty() {
            Some(spec.shape.as_deref().unwrap_or("disc"))
        } else {
            spec.shape.as_deref()
        };
        let molecule = molecule(&entry, shape, &spec.atoms, radius, mass)?;
        check_length("energy", spec.energy).map_err(geometry(&entry))?;
        if spec.energy < 0.0 {
            return Err(problem("`energy` must not be negative"));
        }
        let count = match (spec.area_fraction, spec.count) {
            (None, Some(count)) => count,
            (Some(fraction), None) if (0.0..1.0).contains(&fraction) => {
                let (one, all) = (molecule.area(), bounds.area());
                let count = (fraction * all / one).round() as usize;
                if fraction > 0.0 && count == 0 {
                    return Err(problem(&format!(
                        "`area_fraction` = {fraction} of the box's area {all} is less than half of one \
                         molecule's area {one}: it rounds to 0 molecules"
                    )));
                }
                count
            }
            (Some(_), None) => return Err(problem("`area_fraction` must be at least 0 and below 1")),
            _ => return Err(problem("give either `area_fraction` or `count`")),
        };
        if count > MOST_MOLECULES {
            return Err(problem("there must be at most 2^27 molecules of one kind"));
        }
        if spec.zero_momentum == Some(true) && count == 1 && spec.energy > 0.0 {
            return Err(problem(
                "`zero_momentum` must not be true if `count` is 1: a molecule with `energy` above 0 cannot have momentum 0",
            ));
        }
        let inertia = inertia(&molecule, spec.rotation);
        let motion = Motion {
            velocity: speed(share(spec, &molecule), &inertia) * DVec2::X,
            angular_velocity: if turns(spec, &molecule) {
                spin(share(spec, &molecule), &inertia)
            } else {
                0.0
            },
            ..Motion::at_rest(DVec2::ZERO)
        };
        check_length("the speed that `energy` gives", motion.velocity.x).map_err(geometry(&entry))?;
        check_length("the angular velocity that `energy` gives", motion.angular_velocity)
            .map_err(geometry(&entry))?;
        if spec.energy > 0.0 {
            refuse_slow(&entry, &motion, molecule.bounding_radius())?;
        }
        Ok(Self {
            entry,
            spec,
            molecule: Arc::new(molecule),
            count,
            places: Vec::with_capacity(count.min(1 << 24)),
        })
    }
}

/// Places all kinds of one class on one lattice.
fn place_class(
    world: &World,
    sites: &Sites,
    species: &mut [Species<'_>],
    class: &[usize],
    random: &mut Pcg64,
) -> Result<(), SceneError> {
    let wanted: usize = class.iter().map(|&k| species[k].count).sum();
    if wanted == 0 {
        return Ok(());
    }
    let radius = species[class[0]].molecule.bounding_radius() * (1.0 + ROOM);
    let full = |placed: usize| SceneError::Full { entry: species[class[0]].entry.clone(), placed, wanted };
    // More molecules than fit in any case are refused before a lattice is built.
    let densest = world.bounds().area() / (3f64.sqrt() * 2.0 * radius * radius);
    if wanted as f64 > 1.1 * densest + 2.0 {
        return Err(full(densest as usize));
    }
    let probe = Molecule::disc(radius, 1.0).map_err(geometry(&species[class[0]].entry))?;
    let free_at =
        |place: DVec2| sites.nearest(world, &probe, &Motion::at_rest(place)).is_none_or(|(_, gap)| gap > 0.0);
    let mut most = 0;
    let (lattice, free) = 'found: {
        for attempt in attempts(world.bounds(), wanted, radius) {
            let lattice = match attempt {
                Attempt::Spacing(spacing) => Lattice::new(world.bounds(), spacing, radius, random),
                Attempt::Sites(sites) => Lattice::thinned(world.bounds(), sites, radius, random),
            };
            let Some(lattice) = lattice else { continue };
            if lattice.capacity() < wanted {
                most = most.max(lattice.capacity());
                continue;
            }
            let free: Vec<DVec2> =
                (0..lattice.capacity()).map(|k| lattice.site(k)).filter(|&place| free_at(place)).collect();
            most = most.max(free.len());
            if free.len() >= wanted {
                break 'found (lattice, free);
            }
        }
        return Err(full(most));
    };
    // A random choice in the order of the lattice: neighbours in space remain neighbours in memory.
    let free = choose(free, wanted, random);
    let mut kinds: Vec<usize> =
        class.iter().flat_map(|&k| std::iter::repeat_n(k, species[k].count)).collect();
    kinds.shuffle(random);
    for (site, kind) in free.into_iter().zip(kinds) {
        let moved = site + lattice.slack * random.random::<f64>().sqrt() * direction(random);
        let place = if free_at(moved) { moved } else { site };
        species[kind].places.push(place);
    }
    Ok(())
}

/// Chooses `wanted` sites at random and keeps their order, by dropping single sites.
fn choose(mut sites: Vec<DVec2>, wanted: usize, random: &mut Pcg64) -> Vec<DVec2> {
    while sites.len() > wanted {
        let mut remaining = Remaining::all(sites.len());
        while remaining.len() > wanted {
            remaining.take(random.random_range(0..remaining.len()));
            if remaining.len() > 4 * wanted {
                break;
            }
        }
        remaining.keep(&mut sites);
        if sites.len() > 4 * wanted {
            sites = thin(sites, wanted, random);
        }
    }
    sites
}

/// Chooses about twice the number wanted at random and keeps their order; returns all if fewer than
/// wanted would be chosen.
fn thin(sites: Vec<DVec2>, wanted: usize, random: &mut Pcg64) -> Vec<DVec2> {
    let keep = 2.0 * wanted as f64 / sites.len() as f64;
    let chosen: Vec<DVec2> = sites.iter().copied().filter(|_| random.random::<f64>() < keep).collect();
    if chosen.len() >= wanted { chosen } else { sites }
}

/// A lattice to try.
#[derive(Clone, Copy)]
enum Attempt {
    /// A lattice of this spacing (length).
    Spacing(f64),
    /// A lattice of touching sites, thinned out to about this number.
    Sites(usize),
}

/// Lattices to try, from a wide spacing down to touching sites. A lattice of very many touching
/// sites is first tried thinned out, with more and more sites.
fn attempts(bounds: &PeriodicBox, wanted: usize, radius: f64) -> impl Iterator<Item = Attempt> {
    let (sides, touching) = (bounds.sides(), 2.0 * radius);
    let roomy = (2.0 * bounds.area() / (3f64.sqrt() * 1.1 * wanted as f64)).sqrt();
    let most = MOST_SITES.max(8 * wanted);
    let sites = move |spacing: f64| Counts::new(sides, spacing, radius).map_or(0.0, Counts::sites);
    let all = sites(touching);
    // The last one is the whole lattice, unless that is too large.
    let thinned = std::iter::successors(Some((FEW_SITES / 16).max(4 * wanted)), |sites| Some(8 * sites))
        .take_while(move |&sites| all > FEW_SITES as f64 && sites <= most && (sites as f64) < all);
    (0..64)
        .map(move |step| roomy * 0.98f64.powi(step))
        .take_while(move |&spacing| spacing > touching)
        // Skip a lattice with far more sites than wanted: the box is so narrow that it holds one
        // row of them.
        .filter(move |&spacing| sites(spacing) <= FEW_SITES.max(64 * wanted) as f64)
        .map(Attempt::Spacing)
        .chain(thinned.map(Attempt::Sites))
        .chain((all <= most as f64).then_some(Attempt::Spacing(touching)))
}

/// Columns and rows of a triangular lattice.
#[derive(Clone, Copy)]
struct Counts {
    columns: f64,
    rows: f64,
}

impl Counts {
    /// Counts for a lattice of this spacing (length) and discs of this radius; `None` if not even
    /// one disc fits.
    fn new(sides: DVec2, spacing: f64, radius: f64) -> Option<Self> {
        let columns = (sides.x / spacing).floor();
        if columns == 0.0 || sides.y < 2.0 * radius {
            return None;
        }
        let across = sides.x / columns;
        // The distance of rows is limited by diagonal neighbours and by the second next row.
        let diagonal = (spacing * spacing - 0.25 * across * across).max(0.0).sqrt();
        let up = diagonal.max(0.5 * spacing);
        Some(Self { columns, rows: even((sides.y / up).floor()) })
    }

    fn sites(self) -> f64 {
        self.columns * self.rows
    }
}

/// This number of rows, or one less: each row is shifted relative to its neighbours on both sides,
/// so the number must be even, unless it is 1.
fn even(rows: f64) -> f64 {
    if rows <= 1.0 { 1.0 } else { rows - rows % 2.0 }
}

/// A triangular lattice that fits the periodic box.
struct Lattice {
    columns: usize,
    rows: usize,
    step: DVec2,
    origin: DVec2,
    /// How far the molecule at each site may be displaced without touching another (length).
    slack: f64,
}

impl Lattice {
    fn new(bounds: &PeriodicBox, spacing: f64, radius: f64, random: &mut Pcg64) -> Option<Self> {
        let origin = bounds.sides() * DVec2::new(random.random(), random.random());
        let counts = Counts::new(bounds.sides(), spacing, radius)?;
        Self::of(bounds, counts, radius, origin)
    }

    /// The lattice of touching sites without some columns and rows, so that about this number of
    /// sites is left, spread evenly: distances between neighbours only increase.
    fn thinned(bounds: &PeriodicBox, sites: usize, radius: f64, random: &mut Pcg64) -> Option<Self> {
        let origin = bounds.sides() * DVec2::new(random.random(), random.random());
        let Counts { columns, rows } = Counts::new(bounds.sides(), 2.0 * radius, radius)?;
        let sites = sites as f64;
        let shorter = columns.min(rows).min(sites.sqrt().floor());
        let longer = (sites / shorter).floor();
        let counts = if columns < rows {
            Counts { columns: shorter, rows: even(longer.min(rows)) }
        } else {
            Counts { columns: longer.min(columns), rows: even(shorter) }
        };
        Self::of(bounds, counts, radius, origin)
    }

    fn of(bounds: &PeriodicBox, counts: Counts, radius: f64, origin: DVec2) -> Option<Self> {
        let (sides, touching) = (bounds.sides(), 2.0 * radius);
        let Counts { columns, rows } = counts;
        let step = sides / DVec2::new(columns, rows);
        let nearest = [
            step.x,
            if rows > 1.0 { DVec2::new(0.5 * step.x, step.y).length() } else { sides.y },
            if rows > 2.0 { 2.0 * step.y } else { sides.y },
        ];
        let nearest = nearest.into_iter().fold(f64::INFINITY, f64::min);
        (nearest >= touching).then_some(Self {
            columns: columns as usize,
            rows: rows as usize,
            step,
            origin,
            slack: 0.5 * (nearest - touching),
        })
    }

    /// Number of sites.
    fn capacity(&self) -> usize {
        self.columns.saturating_mul(self.rows)
    }

    fn site(&self, index: usize) -> DVec2 {
        let (row, column) = (index / self.columns, index % self.columns);
        let shifted = column as f64 + 0.5 * (row % 2) as f64;
        self.origin + DVec2::new(shifted * self.step.x, row as f64 * self.step.y)
    }
}

/// Adds the molecules of one kind with random orientations and the given directions of motion.
fn set_in_motion(
    world: &mut World,
    names: &mut TagNames,
    kind: &Species<'_>,
    directions: &[DVec2],
    places: &mut Pcg64,
    velocities: &mut Pcg64,
) {
    let inertia = inertia(&kind.molecule, kind.spec.rotation);
    let tags = tags(names, &kind.spec.tags);
    let (turning, share) = (turns(kind.spec, &kind.molecule), share(kind.spec, &kind.molecule));
    for (&place, &direction) in kind.places.iter().zip(directions) {
        let motion = Motion {
            velocity: speed(share, &inertia) * direction,
            orientation: Orientation::from_turns(places.random()),
            angular_velocity: if turning { either_way(spin(share, &inertia), velocities) } else { 0.0 },
            ..Motion::at_rest(place)
        };
        insert(world, Arc::clone(&kind.molecule), inertia, tags.clone(), motion);
    }
}

fn direction(random: &mut Pcg64) -> DVec2 {
    Orientation::from_turns(random.random()).cos_sin()
}

/// Random directions with sum 0, in random order: opposite pairs, and for an odd number three
/// directions at a third of a turn. A single one has any direction.
fn opposite_directions(count: usize, random: &mut Pcg64) -> Vec<DVec2> {
    let mut directions = Vec::with_capacity(count);
    if count % 2 == 1 && count > 1 {
        let turns: f64 = random.random();
        let thirds = [0.0, 1.0 / 3.0, 2.0 / 3.0];
        directions.extend(thirds.map(|third| Orientation::from_turns(turns + third).cos_sin()));
    }
    while directions.len() + 1 < count {
        let one = direction(random);
        directions.extend([one, -one]);
    }
    if directions.len() < count {
        directions.push(direction(random));
    }
    // Neighbours in the list are neighbours in space; the shuffle separates the pairs.
    directions.shuffle(random);
    directions
}

/// Whether contacts change the angular velocity of the molecules of a gas.
fn turns(spec: &GasSpec, molecule: &Molecule) -> bool {
    spec.rotation == Rotation::Free && !molecule.is_round()
}

/// The energy of each degree of freedom of a molecule (mass × length² / time²).
fn share(spec: &GasSpec, molecule: &Molecule) -> f64 {
    spec.energy / if turns(spec, molecule) { 3.0 } else { 2.0 }
}

/// The speed at which each of the two directions of motion has this energy (length / time).
fn speed(energy: f64, inertia: &Inertia) -> f64 {
    (4.0 * energy * inertia.inverse_mass).sqrt()
}

/// The angular velocity with this energy (radians per time).
fn spin(energy: f64, inertia: &Inertia) -> f64 {
    (2.0 * energy * inertia.inverse_moment).sqrt()
}

fn either_way(spin: f64, random: &mut Pcg64) -> f64 {
    if random.random() { spin } else { -spin }
}
