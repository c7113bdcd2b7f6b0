//! Placement of gases: random with a given seed, without overlap, around the bodies already in the
//! box.
//!
//! Molecules of similar size share a triangular lattice of sites, as wide as possible for their
//! number. Sites at which they would touch bodies already placed are left out, the others are
//! occupied at random, and each molecule is displaced at random as far as its neighbours' sites
//! allow. A gas with a region has a lattice in it. Larger kinds are placed before smaller ones.
//! Orientations and velocities are random (`velocities.rs`); collisions complete the mixing.

use std::sync::Arc;

use carom_geometry::{Atom, GeometryError, Molecule, PeriodicBox};
use carom_kinematics::Motion;
use glam::DVec2;
use rand::{RngExt, seq::SliceRandom};
use rand_pcg::Pcg64;

use crate::{
    scene::{
        Scene,
        error::SceneError,
        random::{RandomStream, direction},
        region::Region,
    },
    start::{
        body_builder::geometry,
        chains,
        place::{Place, TRIALS},
        pockets::Pockets,
        selection::Remaining,
        sites::Sites,
        species::Species,
        velocities::ConservedMomentum,
    },
    world::{World, tags::TagNames},
};

/// Smallest gap, relative to the size of the molecules, at which they are placed: none starts in
/// contact.
const MIN_GAP: f64 = 1e-9;

/// Most sites of a lattice where fewer are needed: the check of each takes about a microsecond.
const MAX_SITES: usize = 1 << 22;

/// A lattice of touching sites, the last to be tried, is thinned out if it has more sites than
/// this: in a narrow box it may have any number of sites, even if few are needed.
const FEW_SITES: usize = 1 << 20;

/// Places all gases of the scene and sets them in motion.
pub(crate) fn fill(
    world: &mut World,
    names: &mut TagNames,
    scene: &Scene,
    species: &[Species],
) -> Result<(), SceneError> {
    let (seed, replica) = (scene.bounds.seed, scene.bounds.replica);
    let mut random = RandomStream::Placement.generator(seed, replica);
    let mut velocities = RandomStream::Velocities.generator(seed, replica);
    let places = place(world, species, &mut random, &mut Budget::unlimited())?;
    let conserved = ConservedMomentum::new(world, species);
    for (kind, places) in species.iter().zip(places) {
        let motions = kind
            .velocities(&conserved, &mut velocities)?
            .zip(places)
            .map(|((velocity, angular_velocity), place)| Motion {
                velocity,
                orientation: place.orientation(&mut random),
                angular_velocity,
                ..Motion::at_rest(place.at)
            });
        kind.insert(world, names, motions);
    }
    Ok(())
}

/// Places for the molecules of each kind, around the bodies of a world.
///
/// # Errors
/// [`SceneError::Full`] if they do not fit.
pub(crate) fn place(
    world: &World,
    species: &[Species],
    random: &mut Pcg64,
    budget: &mut Budget,
) -> Result<Vec<Vec<Place>>, SceneError> {
    // Chains first: the sites of a lattice leave no room for them.
    let chained = chains::place(world, species, random)?;
    let (world, of_chains) = match &chained {
        Some(chains) => (&chains.world, &chains.places[..]),
        None => (world, &[][..]),
    };
    let is_single = |gas: &&Species| gas.spec.chain.is_none();
    let singles = species.iter().filter(is_single);
    let kinds: Vec<Kind<'_>> = singles.flat_map(Kind::all_of).collect();
    let mut by_kind = place_kinds(world, &kinds, random, budget)?.into_iter();
    let any = |at| Place {
        at,
        orientation: None,
    };
    let places_of = |(index, gas): (usize, &Species)| {
        if gas.spec.chain.is_some() {
            return of_chains.get(index).cloned().unwrap_or_default();
        }
        let kinds = gas.groups().count();
        by_kind.by_ref().take(kinds).flatten().map(any).collect()
    };
    Ok(species.iter().enumerate().map(places_of).collect())
}

/// Equal molecules of a gas: all of them, or one of drawn size.
struct Kind<'a> {
    gas: &'a Species,
    molecule: &'a Arc<Molecule>,
    count: usize,
}

impl<'a> Kind<'a> {
    fn all_of(gas: &'a Species) -> impl Iterator<Item = Self> {
        gas.groups().map(move |(index, count)| Self {
            gas,
            molecule: gas.molecule(index),
            count,
        })
    }

    fn region(&self) -> Option<Region> {
        self.gas.spec.region
    }
}

/// How many sites of lattices may still be tried.
#[derive(Debug)]
pub(crate) struct Budget(usize);

impl Budget {
    /// Any number: the lattices of one placement are few.
    pub(crate) fn unlimited() -> Self {
        Self(usize::MAX)
    }

    /// The number for repeated placements of so many molecules, of which one must succeed: a few
    /// seconds. Smaller: molecules that fit after some trials only are refused.
    pub(crate) fn of_repetitions(molecules: usize) -> Self {
        Self(molecules.saturating_mul(64).max(8 * MAX_SITES))
    }

    pub(crate) fn is_spent(&self) -> bool {
        self.0 == 0
    }
}

/// Positions for the molecules of each kind.
fn place_kinds(
    world: &World,
    kinds: &[Kind<'_>],
    random: &mut Pcg64,
    budget: &mut Budget,
) -> Result<Vec<Vec<DVec2>>, SceneError> {
    let mut by_size: Vec<usize> = (0..kinds.len()).collect();
    by_size.sort_by(|&i, &j| {
        let radius = |k: usize| kinds[k].molecule.bounding_radius();
        radius(j).total_cmp(&radius(i)).then(i.cmp(&j))
    });
    let mut placing = Placing::new(world, kinds);
    let mut rest = &by_size[..];
    while !rest.is_empty() {
        let (class, smaller) = rest.split_at(placing.place_similar(rest, random, budget)?);
        if !smaller.is_empty() {
            placing.add_to_sites(class);
        }
        rest = smaller;
    }
    Ok(placing.places)
}

/// The placement of all kinds, one class of kinds of similar size after another.
struct Placing<'a> {
    world: &'a World,
    kinds: &'a [Kind<'a>],
    /// The bodies of the world, and the molecules of the classes before.
    sites: Sites,
    /// The places of each kind.
    places: Vec<Vec<DVec2>>,
}

impl<'a> Placing<'a> {
    fn new(world: &'a World, kinds: &'a [Kind<'a>]) -> Self {
        let sizes = kinds
            .iter()
            .map(|kind| (kind.molecule.bounding_radius(), kind.count));
        let mut sites = Sites::with_more(world, sizes);
        for index in 0..world.bodies().len() {
            sites.add(world, index);
        }
        Self {
            world,
            kinds,
            sites,
            places: kinds
                .iter()
                .map(|kind| Vec::with_capacity(kind.count.min(1 << 24)))
                .collect(),
        }
    }

    /// Places the first of the kinds that are left, which are in the order of their size, and those
    /// of similar size, and returns the number of these kinds.
    fn place_similar(
        &mut self,
        rest: &[usize],
        random: &mut Pcg64,
        budget: &mut Budget,
    ) -> Result<usize, SceneError> {
        // Kinds of similar size share one lattice: around the larger ones a finer lattice might not
        // fit. If the shared lattice is too coarse for all of them, fewer share it.
        let first = &self.kinds[rest[0]];
        let largest = first.molecule.bounding_radius();
        let (mut placed, mut tried) = (Ok(0), 0);
        for share in [0.5, 0.75, 1.0] {
            let is_alike = |kind: &Kind<'_>| {
                kind.molecule.bounding_radius() >= share * largest
                    && kind.region() == first.region()
                    && kind.gas.pair_tags == first.gas.pair_tags
            };
            let alike = rest
                .iter()
                .take_while(|&&k| is_alike(&self.kinds[k]))
                .count();
            if alike == tried {
                continue;
            }
            tried = alike;
            let trial = &mut random.clone();
            placed = self
                .place_class(&rest[..alike], trial, budget)
                .map(|()| alike);
            if placed.is_ok() {
                *random = trial.clone();
                break;
            }
        }
        placed
    }

    /// Places all kinds of one class.
    fn place_class(
        &mut self,
        class: &[usize],
        random: &mut Pcg64,
        budget: &mut Budget,
    ) -> Result<(), SceneError> {
        if class.iter().all(|&kind| self.kinds[kind].count == 0) {
            return Ok(());
        }
        let class = SimilarKinds::new(self, class)?;
        let (places, kinds) = if class.is_ideal {
            (class.independent_places(random)?, class.kind_of_each())
        } else {
            class.lattice_places(random, budget)?
        };
        for (place, kind) in places.into_iter().zip(kinds) {
            self.places[kind].push(place);
        }
        Ok(())
    }

    /// Makes the molecules of a class obstacles to those that follow.
    fn add_to_sites(&mut self, class: &[usize]) {
        for &kind in class {
            let Kind { molecule, gas, .. } = &self.kinds[kind];
            for &place in &self.places[kind] {
                self.sites
                    .add_circle(self.world.bounds(), place, molecule, &gas.pair_tags);
            }
        }
    }
}

/// Kinds of similar size with one region and the same tags in rules of pairs, which share one
/// lattice.
struct SimilarKinds<'a> {
    placing: &'a Placing<'a>,
    /// Indices of the kinds, the largest first.
    kinds: &'a [usize],
    /// Number of molecules of these kinds.
    requested: usize,
    /// The gas of the largest kind.
    gas: &'a Species,
    region: Region,
    pockets: Pockets,
    /// A disc as large as the largest molecule with the gap about it.
    probe: Molecule,
    /// Whether its molecules do not see each other.
    is_ideal: bool,
    /// Half the distance that the centres of two of its molecules must keep (length).
    radius: f64,
    /// The first corner of the region (length).
    corner: DVec2,
    /// A periodic box of the size of the region, for the lattice.
    field: PeriodicBox,
}

impl<'a> SimilarKinds<'a> {
    fn new(placing: &'a Placing<'a>, kinds: &'a [usize]) -> Result<Self, SceneError> {
        let (world, largest) = (placing.world, &placing.kinds[kinds[0]]);
        let gas = largest.gas;
        let own = largest.molecule.bounding_radius() * (1.0 + MIN_GAP);
        // All molecules of a class have the same tags where rules apply to pairs of them.
        let factor = world.pairs.factor_of_tags(&gas.pair_tags, &gas.pair_tags);
        let is_ideal = factor == 0.0;
        let radius = if is_ideal { own } else { factor * own };
        let region = largest.region().unwrap_or_default();
        let (corner, field) =
            field(world.bounds(), &region, radius).map_err(geometry(&gas.entry))?;
        let probe = Molecule::disc(own, 1.0).map_err(geometry(&gas.entry))?;
        let pockets = pockets(world, placing.kinds, kinds).map_err(geometry(&gas.entry))?;
        Ok(Self {
            placing,
            kinds,
            requested: kinds.iter().map(|&k| placing.kinds[k].count).sum(),
            gas,
            region,
            pockets,
            probe,
            is_ideal,
            radius,
            corner,
            field,
        })
    }

    fn bounds(&self) -> &PeriodicBox {
        self.placing.world.bounds()
    }

    /// The kind of each molecule, kind after kind.
    fn kind_of_each(&self) -> Vec<usize> {
        self.kinds
            .iter()
            .flat_map(|&k| std::iter::repeat_n(k, self.placing.kinds[k].count))
            .collect()
    }

    /// Whether a molecule of the class may be placed here, as far as the bodies and the classes
    /// before limit it.
    fn is_free(&self, place: DVec2) -> bool {
        let Placing { world, sites, .. } = self.placing;
        self.region.contains(self.bounds(), place)
            && !self.pockets.contain(self.bounds(), place)
            && sites
                .nearest(
                    world,
                    &self.probe,
                    &Motion::at_rest(place),
                    &self.gas.pair_tags,
                )
                .is_none_or(|(_, gap)| gap > 0.0)
    }

    /// The error of a class of which only this number of molecules fits.
    fn full(&self, placed: usize) -> SceneError {
        let Placing { kinds, places, .. } = self.placing;
        // Molecules of drawn sizes are counted with those of their gas that are already placed.
        let before = |k: usize| {
            if std::ptr::eq(kinds[k].gas, self.gas) {
                places[k].len()
            } else {
                0
            }
        };
        let (placed, requested) = if self.gas.is_equal() {
            (placed, self.requested)
        } else {
            (
                placed + (0..kinds.len()).map(before).sum::<usize>(),
                self.requested.max(self.gas.count),
            )
        };
        SceneError::Full {
            entry: self.gas.entry.clone(),
            placed,
            requested,
        }
    }

    /// Places of molecules that do not see each other.
    fn independent_places(&self, random: &mut Pcg64) -> Result<Vec<DVec2>, SceneError> {
        let mut drawn = std::iter::repeat_with(|| self.region.draw(self.bounds(), random));
        let mut found = Vec::with_capacity(self.requested.min(1 << 24));
        while found.len() < self.requested {
            let place = drawn
                .by_ref()
                .take(TRIALS)
                .find(|&place| self.is_free(place));
            found.push(place.ok_or_else(|| self.full(found.len()))?);
        }
        Ok(found)
    }

    /// Places about free sites of a lattice, and the kind of the molecule at each.
    fn lattice_places(
        &self,
        random: &mut Pcg64,
        budget: &mut Budget,
    ) -> Result<(Vec<DVec2>, Vec<usize>), SceneError> {
        self.refuse_too_many()?;
        let (lattice, free) = self.free_sites(random, budget)?;
        // A random choice in the order of the lattice: neighbours in space remain neighbours in
        // memory.
        let free = choose(free, self.requested, random);
        let mut kinds = self.kind_of_each();
        kinds.shuffle(random);
        let displaced = |site: DVec2| {
            let moved = site + lattice.slack * random.random::<f64>().sqrt() * direction(random);
            if self.is_free(moved) { moved } else { site }
        };
        Ok((free.into_iter().map(displaced).collect(), kinds))
    }

    /// Refuses more molecules than fit in any case, before a lattice is built.
    fn refuse_too_many(&self) -> Result<(), SceneError> {
        let (bounds, radius) = (self.bounds(), self.radius);
        let reach = (self.region.extent(bounds) + 2.0 * radius).min(bounds.sides());
        let densest = reach.x * reach.y / (3f64.sqrt() * 2.0 * radius * radius);
        if self.requested as f64 > 1.1 * densest + 2.0 {
            return Err(self.full(densest as usize));
        }
        Ok(())
    }

    /// The first lattice with enough free sites, and these.
    fn free_sites(
        &self,
        random: &mut Pcg64,
        budget: &mut Budget,
    ) -> Result<(Lattice, Vec<DVec2>), SceneError> {
        let mut most = 0;
        for attempt in attempts(&self.field, self.requested, self.radius) {
            let lattice = match attempt {
                Attempt::Spacing(spacing) => {
                    Lattice::new(&self.field, spacing, self.radius, random)
                }
                Attempt::Sites(sites) => Lattice::thinned(&self.field, sites, self.radius, random),
            };
            let Some(lattice) = lattice else { continue };
            if lattice.capacity() < self.requested {
                most = most.max(lattice.capacity());
                continue;
            }
            if budget.is_spent() {
                break;
            }
            budget.0 = budget.0.saturating_sub(lattice.capacity());
            let free = self.free_sites_of(&lattice);
            most = most.max(free.len());
            if free.len() >= self.requested {
                return Ok((lattice, free));
            }
        }
        Err(self.full(most))
    }

    fn free_sites_of(&self, lattice: &Lattice) -> Vec<DVec2> {
        // Sites beyond a part of the box are those at its other side.
        let is_part = self.field != *self.bounds();
        let in_region = |site: DVec2| {
            if is_part {
                self.corner + self.field.wrap(site).0
            } else {
                site
            }
        };
        (0..lattice.capacity())
            .map(|k| in_region(lattice.site(k)))
            .filter(|&place| self.is_free(place))
            .collect()
    }
}

/// The pockets in which no molecule of a class is placed: those for its smallest atom, which are
/// the largest.
fn pockets(world: &World, species: &[Kind<'_>], class: &[usize]) -> Result<Pockets, GeometryError> {
    if !species[class[0]].gas.avoids_pockets {
        return Ok(Pockets::default());
    }
    let atoms = class
        .iter()
        .flat_map(|&kind| species[kind].molecule.atoms());
    Pockets::new(world, atoms.map(Atom::radius).fold(f64::INFINITY, f64::min))
}

/// The first corner of a region (length), and a periodic box of its size for a lattice: at least of
/// that of a molecule.
fn field(
    bounds: &PeriodicBox,
    region: &Region,
    radius: f64,
) -> Result<(DVec2, PeriodicBox), GeometryError> {
    let least = DVec2::splat(2.0 * radius).min(bounds.sides());
    Ok((
        region.corner(),
        PeriodicBox::new(region.extent(bounds).max(least))?,
    ))
}

/// Chooses `requested` sites at random and keeps their order, by dropping single sites.
fn choose(mut sites: Vec<DVec2>, requested: usize, random: &mut Pcg64) -> Vec<DVec2> {
    while sites.len() > requested {
        let mut remaining = Remaining::all(sites.len());
        while remaining.len() > requested {
            remaining.take(random.random_range(0..remaining.len()));
            if remaining.len() > 4 * requested {
                break;
            }
        }
        remaining.keep(&mut sites);
        if sites.len() > 4 * requested {
            sites = thin(sites, requested, random);
        }
    }
    sites
}

/// Chooses about twice the number requested at random and keeps their order; returns all if fewer
/// than requested would be chosen.
fn thin(sites: Vec<DVec2>, requested: usize, random: &mut Pcg64) -> Vec<DVec2> {
    let keep = 2.0 * requested as f64 / sites.len() as f64;
    let chosen: Vec<DVec2> = sites
        .iter()
        .copied()
        .filter(|_| random.random::<f64>() < keep)
        .collect();
    if chosen.len() >= requested {
        chosen
    } else {
        sites
    }
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
fn attempts(bounds: &PeriodicBox, requested: usize, radius: f64) -> impl Iterator<Item = Attempt> {
    let (sides, touching) = (bounds.sides(), 2.0 * radius);
    let roomy = (2.0 * bounds.area() / (3f64.sqrt() * 1.1 * requested as f64)).sqrt();
    let most = MAX_SITES.max(8 * requested);
    let sites = move |spacing: f64| Counts::new(sides, spacing, radius).map_or(0.0, Counts::sites);
    let all = sites(touching);
    // The last one is the whole lattice, unless that is too large.
    let thinned = std::iter::successors(Some((FEW_SITES / 16).max(4 * requested)), |sites| {
        Some(8 * sites)
    })
    .take_while(move |&sites| all > FEW_SITES as f64 && sites <= most && (sites as f64) < all);
    (0..64)
        .map(move |step| roomy * 0.98f64.powi(step))
        .take_while(move |&spacing| spacing > touching)
        // Skip a lattice with far more sites than requested: the box is so narrow that it holds one
        // row of them.
        .filter(move |&spacing| sites(spacing) <= FEW_SITES.max(64 * requested) as f64)
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
        Some(Self {
            columns,
            rows: even((sides.y / up).floor()),
        })
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
        Self::with_counts(bounds, counts, radius, origin)
    }

    /// The lattice of touching sites without some columns and rows, so that about this number of
    /// sites is left, spread evenly: distances between neighbours only increase.
    fn thinned(
        bounds: &PeriodicBox,
        sites: usize,
        radius: f64,
        random: &mut Pcg64,
    ) -> Option<Self> {
        let origin = bounds.sides() * DVec2::new(random.random(), random.random());
        let Counts { columns, rows } = Counts::new(bounds.sides(), 2.0 * radius, radius)?;
        let sites = sites as f64;
        let shorter = columns.min(rows).min(sites.sqrt().floor());
        let longer = (sites / shorter).floor();
        let counts = if columns < rows {
            Counts {
                columns: shorter,
                rows: even(longer.min(rows)),
            }
        } else {
            Counts {
                columns: longer.min(columns),
                rows: even(shorter),
            }
        };
        Self::with_counts(bounds, counts, radius, origin)
    }

    fn with_counts(
        bounds: &PeriodicBox,
        counts: Counts,
        radius: f64,
        origin: DVec2,
    ) -> Option<Self> {
        let (sides, touching) = (bounds.sides(), 2.0 * radius);
        let Counts { columns, rows } = counts;
        let step = sides / DVec2::new(columns, rows);
        let nearest = [
            step.x,
            if rows > 1.0 {
                DVec2::new(0.5 * step.x, step.y).length()
            } else {
                sides.y
            },
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
