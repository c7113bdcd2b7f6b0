//! The kinds of molecules of the gases of a scene: shape, number, and the speeds that their energy
//! gives them.

use std::sync::Arc;

use carom_geometry::{MAX_MAGNITUDE, Molecule, PeriodicBox, Shape, check_length};
use carom_kinematics::{Inertia, Motion};
use glam::DVec2;

use crate::{
    contact::{elasticity_table::rough_gases, limits::refuse_slow},
    scene::{
        Scene,
        error::SceneError,
        gas_spec::{GasSpec, MAX_MOLECULES, TWO_ENERGIES},
    },
    start::{
        body_builder::{geometry, inertia, insert},
        drawn_molecules::{Described, DrawnMolecules},
    },
    world::{
        World,
        body::Rotation,
        tags::{TagNames, Tags},
    },
};

/// The molecules of one gas.
#[derive(Debug, Clone)]
pub(crate) struct Species {
    /// The entry of the scene.
    pub entry: String,
    pub spec: GasSpec,
    pub count: usize,
    /// Whether no molecule is placed in a pocket of another.
    pub avoids_pockets: bool,
    /// The tags of the molecules, if the scene has rules for pairs of tags; else none, since no
    /// placement reads them.
    pub pair_tags: Tags,
    /// Whether its molecules have rough contacts with any body of the scene at the start.
    is_rough: bool,
    molecules: Molecules,
}

/// The shapes of the molecules of a gas.
#[derive(Debug, Clone)]
enum Molecules {
    /// All have one shape and mass.
    Equal(Arc<Molecule>),
    /// Each has its own.
    Drawn(Vec<Arc<Molecule>>),
}

/// The kinds of molecules of the gases of a scene.
pub(crate) fn species(scene: &Scene, bounds: &PeriodicBox) -> Result<Vec<Species>, SceneError> {
    let rough = rough_gases(scene)?;
    let species = (0..).zip(rough).map(|(index, is_rough)| {
        Species::new(scene, index, bounds).map(|species| Species {
            is_rough,
            ..species
        })
    });
    species.collect()
}

/// A world of the bodies already placed and a few molecules of each kind, at rest at the origin,
/// and the number of molecules of each kind in it: at most two, or the two largest and the two
/// smallest. The largest and the smallest contact distance do not depend on the others.
pub(crate) fn sample(world: &World, species: &[Species]) -> (World, Vec<usize>) {
    let mut sample = world.clone();
    let mut counts = Vec::new();
    for kind in species {
        let extremes = kind.extremes();
        counts.push(extremes.len());
        for index in extremes {
            let motion = Motion::at_rest(DVec2::ZERO);
            insert(
                &mut sample,
                Arc::clone(kind.molecule(index)),
                kind.inertia(index),
                kind.pair_tags.clone(),
                motion,
            );
        }
    }
    (sample, counts)
}

impl Species {
    /// The molecules of a gas of a scene.
    ///
    /// # Errors
    /// Its entry is invalid.
    pub fn new(scene: &Scene, index: usize, bounds: &PeriodicBox) -> Result<Self, SceneError> {
        let entry = format!("gas[{index}]");
        let problem = |reason: String| SceneError::of_entry(&entry, reason);
        let spec = &scene.contained_gas(index, bounds).map_err(problem)?;
        let described = Described::new(scene, index, &entry)?;
        spec.check_fixed().map_err(problem)?;
        check_energy(&entry, spec)?;
        let (molecules, count) = match described {
            Described::Equal(molecule) => {
                let count = count(&entry, spec, bounds, &molecule)?;
                (Molecules::Equal(Arc::from(molecule)), count)
            }
            Described::Drawn(drawing) => {
                let drawn = drawn(&entry, spec, bounds, *drawing)?;
                let count = drawn.len();
                (Molecules::Drawn(drawn), count)
            }
        };
        if let Some(chain) = &spec.chain {
            chain.check(count).map_err(problem)?;
        }
        refuse_moving_single(&entry, spec, count)?;
        let avoids_pockets = scene.start.empty_pockets;
        let kind = Self {
            entry,
            spec: spec.clone(),
            molecules,
            count,
            avoids_pockets,
            pair_tags: Tags::default(),
            is_rough: false,
        };
        kind.check_speeds()?;
        Ok(kind)
    }

    /// Refuses an energy or temperature with which a molecule moves too fast or too slowly to
    /// compute with.
    fn check_speeds(&self) -> Result<(), SceneError> {
        // Equal molecules are checked even if there is none.
        let checked = if self.is_equal() {
            vec![0]
        } else {
            self.extremes()
        };
        for index in checked {
            let freedom = self.degrees_of_freedom();
            let energy = self
                .spec
                .temperature
                .map_or(self.spec.energy, |temperature| 0.5 * freedom * temperature);
            let (speed, spin) = self.equal_shares(index, energy);
            self.check_motion(index, speed * DVec2::X, spin)?;
        }
        Ok(())
    }

    /// The shape of a molecule, by its index in the gas.
    pub fn molecule(&self, index: usize) -> &Arc<Molecule> {
        match &self.molecules {
            Molecules::Equal(molecule) => molecule,
            Molecules::Drawn(molecules) => &molecules[index],
        }
    }

    /// Whether all molecules have one shape and mass.
    pub fn is_equal(&self) -> bool {
        matches!(self.molecules, Molecules::Equal(_))
    }

    /// Runs of molecules of one shape: the index of the first and the number of each.
    pub fn groups(&self) -> impl Iterator<Item = (usize, usize)> {
        let size = if self.is_equal() { self.count } else { 1 };
        let groups = if self.is_equal() { 1 } else { self.count };
        (0..groups).map(move |group| (group * size, size))
    }

    /// This gas without molecules, which have been placed as single bodies.
    pub fn emptied(self) -> Self {
        let molecules = match self.molecules {
            Molecules::Equal(molecule) => Molecules::Equal(molecule),
            Molecules::Drawn(_) => Molecules::Drawn(Vec::new()),
        };
        Self {
            count: 0,
            molecules,
            ..self
        }
    }

    /// This gas with its molecules at another scale.
    ///
    /// # Errors
    /// [`SceneError`] with the name of the entry if a length is out of range.
    pub fn scaled(&self, scale: f64) -> Result<Self, SceneError> {
        let scaled = |molecule: &Arc<Molecule>| {
            molecule
                .scaled(scale)
                .map(Arc::new)
                .map_err(geometry(&self.entry))
        };
        let molecules = match &self.molecules {
            Molecules::Equal(molecule) => Molecules::Equal(scaled(molecule)?),
            Molecules::Drawn(molecules) => {
                Molecules::Drawn(molecules.iter().map(scaled).collect::<Result<_, _>>()?)
            }
        };
        let mut spec = self.spec.clone();
        if let Some(chain) = &mut spec.chain {
            chain.tether.max *= scale;
        }
        Ok(Self {
            spec,
            molecules,
            ..self.clone()
        })
    }

    /// The indices of at most two molecules; of drawn ones, of the two largest and the two
    /// smallest, in ascending order.
    fn extremes(&self) -> Vec<usize> {
        match &self.molecules {
            Molecules::Equal(_) => (0..self.count.min(2)).collect(),
            Molecules::Drawn(molecules) => {
                let mut by_size: Vec<usize> = (0..molecules.len()).collect();
                let radius = |index: usize| molecules[index].bounding_radius();
                by_size.sort_by(|&i, &j| radius(i).total_cmp(&radius(j)));
                let all = by_size.len();
                if all > 4 {
                    by_size.drain(2..all - 2);
                }
                by_size.sort_unstable();
                by_size
            }
        }
    }

    /// Speed and angular velocity of a molecule of this energy, shared equally over its degrees of
    /// freedom (length / time, radians per time).
    pub fn equal_shares(&self, index: usize, energy: f64) -> (f64, f64) {
        let (share, inertia) = (energy / self.degrees_of_freedom(), self.inertia(index));
        let speed = (4.0 * share * inertia.inverse_mass).sqrt();
        (
            speed,
            if self.turns() {
                (2.0 * share * inertia.inverse_moment).sqrt()
            } else {
                0.0
            },
        )
    }

    /// Refuses a molecule that moves or turns too fast or too slowly to compute with.
    pub fn check_motion(
        &self,
        index: usize,
        velocity: DVec2,
        angular_velocity: f64,
    ) -> Result<(), SceneError> {
        let [speed, spin] = if self.spec.temperature.is_some() {
            [
                "the speed that `temperature` gives",
                "the angular velocity that `temperature` gives",
            ]
        } else {
            [
                "the speed that `energy` gives",
                "the angular velocity that `energy` gives",
            ]
        };
        for component in velocity.to_array() {
            check_length(speed, component).map_err(geometry(&self.entry))?;
        }
        check_length(spin, angular_velocity).map_err(geometry(&self.entry))?;
        let motion = Motion {
            velocity,
            angular_velocity,
            ..Motion::at_rest(DVec2::ZERO)
        };
        refuse_slow(&self.entry, &motion, self.molecule(index).bounding_radius())
    }

    /// Mass and moment of inertia of a molecule.
    pub fn inertia(&self, index: usize) -> Inertia {
        inertia(self.molecule(index), self.spec.rotation)
    }

    /// Whether contacts change the angular velocity of the molecules. All have one shape.
    pub fn turns(&self) -> bool {
        let is_round = match &self.molecules {
            Molecules::Equal(molecule) => molecule.is_round(),
            Molecules::Drawn(molecules) => {
                molecules.first().is_none_or(|molecule| molecule.is_round())
            }
        };
        self.spec.rotation == Rotation::Free && (self.is_rough || !is_round)
    }

    /// Whether the molecules are discs whose spins rough contacts change.
    pub fn are_turning_discs(&self) -> bool {
        self.count > 0 && self.turns() && self.molecule(0).is_disc()
    }

    /// Degrees of freedom of one molecule that contacts change: 2, or 3 if it turns.
    pub fn degrees_of_freedom(&self) -> f64 {
        if self.turns() { 3.0 } else { 2.0 }
    }

    /// Number of molecules that contacts turn: all or none.
    pub fn turning(&self) -> usize {
        if self.turns() { self.count } else { 0 }
    }

    /// Mass of all molecules.
    pub fn mass(&self) -> f64 {
        self.groups()
            .map(|(index, count)| count as f64 / self.inertia(index).inverse_mass)
            .sum()
    }

    /// Area of all molecules (length²).
    pub fn area(&self) -> f64 {
        self.groups()
            .map(|(index, count)| count as f64 * self.molecule(index).area())
            .sum()
    }

    /// Adds the molecules with these motions to a world.
    pub fn insert(
        &self,
        world: &mut World,
        names: &mut TagNames,
        motions: impl Iterator<Item = Motion>,
    ) {
        let tags = names.intern_all(&self.spec.tags);
        let mut shared = None;
        for (index, motion) in motions.enumerate() {
            let inertia = match shared {
                Some(inertia) if self.is_equal() => inertia,
                _ => *shared.insert(self.inertia(index)),
            };
            insert(
                world,
                Arc::clone(self.molecule(index)),
                inertia,
                tags.clone(),
                motion,
            );
        }
    }
}

/// Refuses a single molecule that moves but is to have momentum 0.
fn refuse_moving_single(entry: &str, spec: &GasSpec, count: usize) -> Result<(), SceneError> {
    let moves = spec.energy > 0.0
        || spec
            .temperature
            .is_some_and(|temperature| temperature > 0.0);
    if spec.zero_momentum == Some(true) && count == 1 && moves {
        return Err(SceneError::of_entry(
            entry,
            "`zero_momentum` must not be true if `count` is 1: a molecule with `energy` or `temperature` above \
             0 cannot have momentum 0",
        ));
    }
    Ok(())
}

fn check_energy(entry: &str, spec: &GasSpec) -> Result<(), SceneError> {
    let problem = |problem: &str| SceneError::Entry {
        entry: entry.to_owned(),
        problem: problem.to_owned(),
    };
    check_length("energy", spec.energy).map_err(geometry(entry))?;
    if spec.energy < 0.0 {
        return Err(problem("`energy` must not be negative"));
    }
    let Some(temperature) = spec.temperature else {
        return Ok(());
    };
    if spec.energy != 0.0 {
        return Err(problem(TWO_ENERGIES));
    }
    if !(0.0..=MAX_MAGNITUDE).contains(&temperature) {
        return Err(problem(&format!(
            "`temperature` must be from 0 to {MAX_MAGNITUDE:e} (mass × length² / time²), but is {temperature:?}"
        )));
    }
    Ok(())
}

/// The number of equal molecules: of an area, the one that covers the nearest to it in whole
/// chains.
fn count(
    entry: &str,
    spec: &GasSpec,
    bounds: &PeriodicBox,
    molecule: &Molecule,
) -> Result<usize, SceneError> {
    let count = match requested(entry, spec, bounds)? {
        Requested::Count(count) => count,
        Requested::Area(area) => {
            let members = spec.chain.as_ref().map_or(1, |chain| chain.members.max(1));
            let chains = (area / (members as f64 * molecule.area())).round() as usize;
            let count = chains.saturating_mul(members);
            if area > 0.0 && count == 0 {
                return Err(too_small(entry, spec, bounds, molecule.area()));
            }
            count
        }
    };
    if count > MAX_MOLECULES {
        Err(too_many(entry, count as f64))
    } else {
        Ok(count)
    }
}

/// The number of molecules of a gas, without drawing them: of drawn sizes that cover an area, the
/// expected one.
///
/// # Errors
/// Those of [`Species::new`] in the description and the number of its molecules.
pub(crate) fn expected_count(
    scene: &Scene,
    index: usize,
    bounds: &PeriodicBox,
) -> Result<usize, SceneError> {
    let entry = format!("gas[{index}]");
    let spec = scene.contained_gas(index, bounds);
    let spec = &spec.map_err(|problem| SceneError::Entry {
        entry: entry.clone(),
        problem,
    })?;
    match Described::new(scene, index, &entry)? {
        Described::Equal(molecule) => count(&entry, spec, bounds, &molecule),
        Described::Drawn(drawing) => {
            let expected = expected(&entry, spec, bounds, &drawing)?;
            refuse_too_many(&entry, spec, expected)?;
            Ok(expected.round() as usize)
        }
    }
}

/// The expected number of drawn molecules, to 15 %.
fn expected(
    entry: &str,
    spec: &GasSpec,
    bounds: &PeriodicBox,
    drawing: &DrawnMolecules,
) -> Result<f64, SceneError> {
    match requested(entry, spec, bounds)? {
        Requested::Count(count) => Ok(count as f64),
        Requested::Area(area) => Ok(area / drawing.mean_area()?),
    }
}

/// Refuses drawn molecules before they take memory. For an area, from twice the limit on, since the
/// mean area is known to 15 % only.
fn refuse_too_many(entry: &str, spec: &GasSpec, expected: f64) -> Result<(), SceneError> {
    let tolerance = if spec.count.is_some() { 1.0 } else { 2.0 };
    let is_too_much = expected > tolerance * MAX_MOLECULES as f64;
    if is_too_much {
        Err(too_many(entry, expected))
    } else {
        Ok(())
    }
}

/// Draws molecules, up to their number, or until their area is nearest to that requested.
fn drawn(
    entry: &str,
    spec: &GasSpec,
    bounds: &PeriodicBox,
    mut drawing: DrawnMolecules,
) -> Result<Vec<Arc<Molecule>>, SceneError> {
    let requested = requested(entry, spec, bounds)?;
    let expected = expected(entry, spec, bounds, &drawing)?;
    refuse_too_many(entry, spec, expected)?;
    let (mut molecules, mut covered) = (Vec::new(), 0.0);
    while molecules.len() <= MAX_MOLECULES {
        match requested {
            Requested::Count(count) if molecules.len() >= count => return Ok(molecules),
            Requested::Area(area) if covered >= area => return Ok(molecules),
            Requested::Count(_) | Requested::Area(_) => {}
        }
        let molecule = drawing.next()?;
        let with_it = covered + molecule.area();
        if let Requested::Area(area) = requested
            && with_it - area > area - covered
        {
            // Nearer without this one.
            return if molecules.is_empty() {
                Err(too_small(entry, spec, bounds, molecule.area()))
            } else {
                Ok(molecules)
            };
        }
        covered = with_it;
        molecules.push(Arc::new(molecule));
    }
    Err(too_many(entry, expected))
}

/// The amount of a gas.
#[derive(Clone, Copy)]
enum Requested {
    /// This number of molecules.
    Count(usize),
    /// As many as cover this area (length²).
    Area(f64),
}

/// Area fraction of the closest packing of equal discs, π/√12 (Lagrange 1773 for lattices, Thue
/// 1910 for all packings).
const CLOSEST_PACKING: f64 = 0.906_899_682_117_109;

/// Whether all molecules of a gas are discs of one size.
fn is_of_equal_discs(spec: &GasSpec) -> bool {
    let is_disc = match spec.shape.as_deref() {
        Some(shape) => shape.parse() == Ok(Shape::Disc),
        None => spec.atoms.len() < 2 && spec.ellipses.is_empty() && spec.polygon.is_empty(),
    };
    is_disc && !spec.has_drawn_sizes()
}

fn requested(entry: &str, spec: &GasSpec, bounds: &PeriodicBox) -> Result<Requested, SceneError> {
    let problem = |problem: &str| SceneError::Entry {
        entry: entry.to_owned(),
        problem: problem.to_owned(),
    };
    spec.region
        .map_or(Ok(()), |region| region.check(bounds))
        .map_err(|reason| problem(&reason))?;
    match (spec.area_fraction, spec.count) {
        (None, Some(count)) => Ok(Requested::Count(count)),
        // In a region discs may cover places outside it.
        (Some(fraction), None)
            if (CLOSEST_PACKING..1.0).contains(&fraction)
                && spec.region.is_none()
                && !spec.overlapping
                && is_of_equal_discs(spec) =>
        {
            Err(problem(&format!(
                "equal discs cover at most {CLOSEST_PACKING:.4} of the box, but `area_fraction` is {fraction}"
            )))
        }
        (Some(fraction), None) if (0.0..1.0).contains(&fraction) => Ok(Requested::Area(
            spec.sum_of_areas(fraction) * spec.region.unwrap_or_default().area(bounds),
        )),
        (Some(fraction), None) => {
            let share = fraction / 100.0;
            let hint = if fraction > 1.0 && share < 1.0 {
                format!(" (a share and no percentage: {share}?)")
            } else {
                String::new()
            };
            Err(problem(&format!(
                "`area_fraction` must be at least 0 and below 1, but is {fraction}{hint}"
            )))
        }
        _ => Err(problem("give either `area_fraction` or `count`")),
    }
}

fn too_many(entry: &str, requested: f64) -> SceneError {
    let number = if requested < 1e15 {
        format!("{requested:.0}")
    } else {
        format!("{requested:.3e}")
    };
    let problem = format!(
        "there must be at most 2^27 molecules of one kind, {MAX_MOLECULES}, but {number} are requested"
    );
    SceneError::Entry {
        entry: entry.to_owned(),
        problem,
    }
}

fn too_small(entry: &str, spec: &GasSpec, bounds: &PeriodicBox, one: f64) -> SceneError {
    let region = spec.region.unwrap_or_default();
    let (fraction, all) = (spec.area_fraction.unwrap_or(0.0), region.area(bounds));
    let whose = if spec.region.is_some() {
        "region"
    } else {
        "box"
    };
    let problem = format!(
        "`area_fraction` = {fraction} of the {whose}'s area {all} is less than half of one molecule's area {one}: it \
         rounds to 0 molecules"
    );
    SceneError::Entry {
        entry: entry.to_owned(),
        problem,
    }
}
