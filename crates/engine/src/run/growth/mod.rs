//! Dense starts: the molecules of the gases grow, each as far as its neighbours allow, while they
//! move and collide.
//!
//! The gases start dilute, on a lattice of small molecules. Then short runs of elastic collisions
//! alternate with steps of growth ([`packing`]) until every molecule has its size. The box does not
//! change, and neither do the walls, the bumpers and the single molecules of the scene, which are
//! held at their places. Growth does not heat the gases: at a step velocities and rotational
//! energies stay. During growth every molecule has mass 1, so that heavy molecules are as fast as
//! light ones.
//!
//! The velocities are drawn at the end, as for a gas on a lattice, and the gases relax
//! ([`relaxation`]).
//!
//! Growth of the molecules instead of compression by moving walls, and its rate set by the room
//! that is left, are due to Lubachevsky and Stillinger, J. Stat. Phys. 60 (1990) 561; here sizes
//! change between runs, not within, so that the run needs no detector of its own.

mod dilute;
mod packing;
mod relaxation;
mod saved;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use carom_detection::Exact;
use carom_kinematics::{EpochTime, Inertia, Motion};
use carom_response::Impact;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use self::{
    packing::{MAX_LEAD, Packing},
    relaxation::{RELAXATION_AFTER_GROWTH, real_kind},
    saved::SavedGrowth,
};
use crate::{
    cells::CellScheduler,
    contact::elasticity_table::ElasticityTable,
    run::simulation::Simulation,
    scene::{
        Scene,
        error::{RunError, SceneError},
        random::RandomStream,
    },
    scheduler::Scheduler,
    start::{
        bonds::tie,
        contents::SceneContents,
        single_bodies::{Singles, deepest_overlap},
        sites::Sites,
        species::Species,
    },
    world::{
        World, body::BodyKind, counters::Counters, tag_classes::sort_into_classes, tags::TagNames,
    },
};

/// Collisions a molecule before the first step of growth: they mix the lattice.
const MIXING: f64 = 20.0;

/// Collisions a molecule between two steps of growth. Fewer: the molecules jam at lower density,
/// since they have no time to make room. More: growth takes longer.
const COLLISIONS_PER_STEP: f64 = 2.0;

/// The gases have jammed if the smallest scale has risen by less than [`MIN_RISE`] in so many
/// steps. Smaller, or a larger rise: states near jamming are given up. Larger, or a smaller rise:
/// a jam is reported later.
const PATIENCE: u64 = 200;

/// Least rise of the smallest scale in [`PATIENCE`] steps.
const MIN_RISE: f64 = 1e-4;

/// Events of the scheduler for each collision requested, after which a run ends with fewer
/// collisions; at the start of an epoch each body has one. Gases of a usual scene need fewer than
/// ten; molecules in a long narrow box, or small ones in a large box, cross millions of cells from
/// one collision to the next, and those that turn fast need as many epochs. Smaller: dilute gases
/// are mixed less. Larger: their placement takes longer.
const EVENTS_PER_COLLISION: f64 = 1e3;

/// Time after which the events of a run are first counted, in times in which a molecule crosses the
/// mean distance between molecules. Larger: a run of many short epochs ends later.
const FIRST_COUNT: f64 = 1.0 / 1_048_576.0;

/// A start at high density in the making: the gases of a scene grow, then relax.
///
/// It can be stored between steps and continued with the same result to the bit. The result depends
/// on the scene alone. [`Simulation::new`] goes through the same steps where a scene needs them.
///
/// ```
/// use carom_engine::{Growth, Scene};
///
/// let scene = Scene::from_toml(r#"
///     [start]
///     relax = 20
///     [[gas]]
///     shape = "dumbbell"
///     atom_radius = 0.04
///     atom_mass = 1.0
///     energy = 1.0
///     area_fraction = 0.7
/// "#)?;
/// let mut growth = Growth::new(&scene)?;
/// while !growth.is_done() {
///     let progress = growth.step()?;
///     assert!(progress.area_fraction < 0.71);
/// }
/// let simulation = growth.finish()?;
/// assert_eq!(simulation.view().overlaps().pairs, 0);
/// // Two discs of radius 0.04 cover 1.005 % of the box.
/// assert_eq!(simulation.view().len(), 70);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(into = "SavedGrowth", try_from = "SavedGrowth")]
#[doc(alias = "compression")]
pub struct Growth {
    scene: Scene,
    contents: SceneContents,
    /// The single bodies, held at their places, and the gases at their present sizes.
    world: World,
    /// Scale of each molecule of the gases; 1 is the size in the scene.
    scales: Vec<f64>,
    state: State,
}

/// The numbers that a growth needs besides its molecules.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct State {
    stage: Stage,
    /// Lead of the front over the smallest molecule, as a share of its scale.
    lead: f64,
    /// Share of the molecules at the front.
    at_front: f64,
    steps: u64,
    collisions: u64,
    /// Step and smallest scale at which the present period of [`PATIENCE`] has begun.
    period: (u64, f64),
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
enum Stage {
    Growing,
    Relaxing {
        /// Collisions a molecule, so far and in all.
        done: f64,
        all: f64,
        /// Energy and momentum of the gases as drawn.
        energy: f64,
        momentum: DVec2,
    },
    Done,
}

/// The progress of a [`Growth`] after a step.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct GrowthProgress {
    /// Area of the gases at their present sizes, as a share of the box.
    pub area_fraction: f64,
    /// Scale of the smallest molecule, from 0 to 1, the size in the scene.
    pub smallest_scale: f64,
    /// Share of the molecules at the front, the largest scale allowed in the last step; from 0 to
    /// 1. Below 0.95 growth slows down.
    pub at_front: f64,
    /// Collisions so far.
    pub collisions: u64,
    /// Share of the relaxation that is done; 0 during growth.
    pub relaxed: f64,
}

impl Growth {
    /// Begins to grow the gases of a scene, whatever its [`StartSpec::placement`].
    ///
    /// [`StartSpec::placement`]: crate::StartSpec::placement
    ///
    /// # Errors
    /// [`SceneError`], with the name of the entry, if the scene cannot be built at any density, or
    /// if the gases cover more than the box.
    pub fn new(scene: &Scene) -> Result<Self, SceneError> {
        Self::from_contents(scene, SceneContents::new(scene)?)
    }

    pub(crate) fn from_contents(
        scene: &Scene,
        contents: SceneContents,
    ) -> Result<Self, SceneError> {
        if contents.singles.world.pairs.has_diameters() {
            let problem = "gases with rules of `[[diameter]]` do not grow: give `placement` lattice and fewer \
                           molecules, or `from` a snapshot";
            return Err(SceneError::Entry {
                entry: "start".to_owned(),
                problem: problem.to_owned(),
            });
        }
        let is_rigid = |gas: &&Species| {
            let chain = gas.spec.chain.as_ref();
            chain
                .is_some_and(|chain| chain.tether.points != [[0.0; 2]; 2] || chain.tether.min > 0.0)
        };
        if let Some(gas) = contents.species.iter().find(is_rigid) {
            let problem = "chains tied at other points than their centres, or with a `min`, do not grow, and these do \
                           not fit: give fewer molecules, or a larger box";
            return Err(SceneError::of_entry(&gas.entry, problem));
        }
        dilute::refuse_impossible(&contents)?;
        let held = held(&contents.singles.world);
        let (scale, motions) = dilute::place(scene, &held, &contents.species)?;
        let scales = vec![scale; motions.len()];
        let state = State {
            stage: Stage::Growing,
            lead: MAX_LEAD,
            at_front: 1.0,
            steps: 0,
            collisions: 0,
            period: (0, scale),
        };
        Self::assemble(scene, contents, scales, &motions, state)
    }

    /// Begins to grow gases that do not fit on a lattice, or returns the error of the lattice if
    /// they cannot fit at all.
    pub(crate) fn after_lattice(
        scene: &Scene,
        contents: SceneContents,
        full: SceneError,
    ) -> Result<Self, SceneError> {
        if dilute::may_fit(&contents) {
            Self::from_contents(scene, contents)
        } else {
            Err(full)
        }
    }

    /// The relaxation of gases that have been placed on a lattice with these motions.
    pub(crate) fn relaxation(
        scene: &Scene,
        contents: SceneContents,
        motions: &[Motion],
    ) -> Result<Self, SceneError> {
        let state = State {
            stage: Stage::Done,
            lead: MAX_LEAD,
            at_front: 1.0,
            steps: 0,
            collisions: 0,
            period: (0, 1.0),
        };
        let mut growth = Self::assemble(scene, contents, vec![1.0; motions.len()], motions, state)?;
        growth.start_relaxation(0.0);
        Ok(growth)
    }

    fn assemble(
        scene: &Scene,
        contents: SceneContents,
        scales: Vec<f64>,
        motions: &[Motion],
        state: State,
    ) -> Result<Self, SceneError> {
        let mut world = held(&contents.singles.world);
        let molecules = contents
            .species
            .iter()
            .flat_map(|kind| (0..kind.count).map(move |index| (kind, index)));
        for (((kind, index), &scale), &motion) in molecules.zip(&scales).zip(motions) {
            let kind = match state.stage {
                Stage::Growing => packing::kind_at(kind, index, scale)?,
                Stage::Relaxing { .. } | Stage::Done => real_kind(kind, index),
            };
            world.insert(kind, motion);
        }
        let first = contents.singles.world.bodies.len();
        tie_at_scale(&mut world, scene, &contents.species, (first, &scales))?;
        Ok(Self {
            scene: scene.clone(),
            contents,
            world,
            scales,
            state,
        })
    }

    /// Takes one step: a step of growth and a short run, or a part of the relaxation. Nothing if
    /// all is done.
    ///
    /// # Errors
    /// [`SceneError::Jammed`] if the gases cannot grow to their size. [`SceneError::Growth`] if a
    /// run ends early: sizes in the scene are too far apart. Further steps may give another error.
    pub fn step(&mut self) -> Result<GrowthProgress, SceneError> {
        match self.state.stage {
            Stage::Growing => self.grow()?,
            Stage::Relaxing { .. } => self.relax()?,
            Stage::Done => {}
        }
        Ok(self.progress())
    }

    pub(crate) fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Whether all steps have been taken.
    pub fn is_done(&self) -> bool {
        self.state.stage == Stage::Done
    }

    /// Number of molecules that grow.
    pub fn molecules(&self) -> usize {
        self.scales.len()
    }

    /// The present progress.
    pub fn progress(&self) -> GrowthProgress {
        let relaxed = match self.state.stage {
            Stage::Growing => 0.0,
            Stage::Relaxing { done, all, .. } => done / all,
            Stage::Done => 1.0,
        };
        GrowthProgress {
            area_fraction: self.area_fraction(),
            smallest_scale: self.smallest(),
            at_front: self.state.at_front,
            collisions: self.state.collisions,
            relaxed,
        }
    }

    /// Takes all steps that are left and returns the world of the scene, with every molecule as in
    /// the scene, and the contents from which it is built.
    pub(crate) fn into_world(mut self) -> Result<(World, SceneContents), SceneError> {
        while !self.is_done() {
            self.step()?;
        }
        let mut contents = self.contents;
        let first = contents.singles.world.bodies.len();
        let Singles { world, names, .. } = &mut contents.singles;
        let mut motions = self.world.motions[first..].iter().copied();
        for kind in &contents.species {
            kind.insert(world, names, motions.by_ref().take(kind.count));
        }
        refuse_overlaps(&contents, first)?;
        let world = std::mem::replace(&mut contents.singles.world, World::new(self.world.bounds));
        Ok((world, contents))
    }

    fn grow(&mut self) -> Result<(), SceneError> {
        if self.state.steps == 0 {
            self.state.steps = 1;
            return self.run(MIXING);
        }
        self.state.steps += 1;
        if self.smallest() < 1.0 {
            self.grow_molecules()?;
            self.refuse_jam()?;
        }
        if self.smallest() < 1.0 {
            return self.run(COLLISIONS_PER_STEP);
        }
        self.draw_velocities()?;
        self.start_relaxation(RELAXATION_AFTER_GROWTH);
        Ok(())
    }

    fn grow_molecules(&mut self) -> Result<(), SceneError> {
        let (first, species) = (
            self.contents.singles.world.bodies.len(),
            &self.contents.species,
        );
        let mut random = self.random();
        let before = self.scales.clone();
        let packing = Packing {
            world: &self.world,
            first,
            species,
        };
        let state = &mut self.state;
        let behind = packing.grow(&mut self.scales, state.lead, &mut random);
        let molecules = self.scales.len();
        state.lead = packing::next_lead(state.lead, behind, molecules);
        state.at_front = 1.0 - behind as f64 / molecules as f64;
        packing::resize(&mut self.world, first, species, &before, &self.scales)?;
        tie_at_scale(&mut self.world, &self.scene, species, (first, &self.scales))
    }

    /// The random numbers of the present step.
    fn random(&self) -> rand_pcg::Pcg64 {
        let bounds = &self.scene.bounds;
        let mut random = RandomStream::Growth.generator(bounds.seed, bounds.replica);
        // A step needs fewer than 2^64 numbers.
        random.advance(u128::from(self.state.steps) << 64);
        random
    }

    fn refuse_jam(&mut self) -> Result<(), SceneError> {
        let (begun, scale) = self.state.period;
        if self.state.steps - begun < PATIENCE {
            return Ok(());
        }
        let smallest = self.smallest();
        if smallest - scale < MIN_RISE && smallest < 1.0 {
            return Err(self.jam());
        }
        self.state.period = (self.state.steps, smallest);
        Ok(())
    }

    fn jam(&self) -> SceneError {
        let requested = self.contents.species.iter().map(Species::area).sum::<f64>();
        let molecules = self.contents.species.iter().flat_map(|kind| {
            let equal = kind.is_equal().then(|| kind.molecule(0).area());
            (0..kind.count).map(move |index| equal.unwrap_or_else(|| kind.molecule(index).area()))
        });
        let smaller = molecules
            .zip(&self.scales)
            .filter(|&(_, &scale)| scale < 1.0);
        let (count, area) =
            smaller.fold((0, 0.0), |(count, sum), (area, _)| (count + 1, sum + area));
        SceneError::Jammed {
            reached: self.area_fraction(),
            requested: requested / self.world.bounds.area(),
            smaller: count,
            molecules: self.scales.len(),
            area_share: (area / requested).min(1.0),
            smallest_scale: self.smallest(),
        }
    }

    /// Runs for so many collisions a molecule, with elastic contacts, but at most for the time in
    /// which a molecule at the root mean square speed crosses the longer side as many times, and at
    /// most until [`EVENTS_PER_COLLISION`] are exceeded.
    fn run(&mut self, collisions: f64) -> Result<(), SceneError> {
        let first = self.contents.singles.world.bodies.len();
        let gases = &self.world.motions[first..];
        let speeds = gases
            .iter()
            .map(|motion| motion.velocity.length_squared())
            .sum::<f64>();
        let speed = (speeds / gases.len() as f64).sqrt();
        // NaN without molecules.
        if speed.is_nan() || speed == 0.0 {
            return Ok(());
        }
        let most = (0.5 * collisions * gases.len() as f64).ceil().max(1.0) as u64;
        let time = collisions * self.world.bounds.sides().max_element() / speed;
        if self.world.pairs.has_rules() {
            let classes = sort_into_classes(&mut self.world, &[]);
            self.world.pairs.look_up(&classes, &self.world.bodies)?;
        }
        // Contacts are smooth here, and discs keep the spins that rough contacts will change.
        self.world.keeps_spins = self.contents.species.iter().any(Species::are_turning_discs);
        let options = <CellScheduler as Scheduler>::Options::default();
        let scheduler = CellScheduler::new(&options, &self.world).map_err(|reason| {
            let counts = self.contents.counts();
            reason.named(|body| self.contents.singles.entry_of(body, &counts))
        })?;
        let empty = World::new(self.world.bounds);
        let world = std::mem::replace(&mut self.world, empty);
        let parts = ((Exact::default(), Impact), (scheduler, options));
        let (elasticity, names) = (ElasticityTable::default(), TagNames::default());
        let mut simulation = Simulation::assemble(world, parts.0, parts.1, elasticity, names);
        let spacing = (self.world.bounds.area() / self.scales.len() as f64).sqrt();
        let ended = collide(&mut simulation, most, time, FIRST_COUNT * spacing / speed).and_then(
            |contacts| {
                // No run ends with a contact: the pair would touch when it next grows or is set in
                // motion.
                let pause = 0.5 * simulation.time().to_f64() / contacts.max(1) as f64;
                simulation.advance(simulation.time().after(pause), u64::MAX, &mut ())
            },
        );
        simulation.end_epoch(simulation.offset);
        self.state.collisions += simulation.counters.collisions;
        self.world = simulation.world;
        self.world.epoch = EpochTime::ZERO;
        ended
            .map_err(|error: RunError| SceneError::Growth(Box::new(error)))
            .map(|_| ())
    }

    fn smallest(&self) -> f64 {
        self.scales.iter().copied().fold(1.0, f64::min)
    }

    fn area_fraction(&self) -> f64 {
        let mut scales = self.scales.iter();
        let area = self.contents.species.iter().map(|kind| {
            let of_group = |(index, count): (usize, usize)| {
                let squares: f64 = scales.by_ref().take(count).map(|scale| scale * scale).sum();
                squares * kind.molecule(index).area()
            };
            kind.groups().map(of_group).sum::<f64>()
        });
        area.sum::<f64>() / self.world.bounds.area()
    }
}

/// Runs through so many contacts, but at most for this time, and at most until the events of the
/// scheduler exceed [`EVENTS_PER_COLLISION`]; returns the number of contacts. Events are counted
/// after pieces of the run, the first as long as `piece` and each later one as long as all before.
fn collide(simulation: &mut Simulation, most: u64, time: f64, piece: f64) -> Result<u64, RunError> {
    let mut contacts = 0;
    let mut until = piece;
    loop {
        let end = until.min(time);
        contacts += simulation.advance(EpochTime::from(end), most - contacts, &mut ())?;
        let Counters {
            epochs,
            scheduler: work,
            ..
        } = simulation.counters;
        let predicted = epochs.saturating_mul(simulation.world.bodies.len() as u64);
        let events = (predicted + work.crossings + work.stale + work.rechecks + work.pairs) as f64;
        let is_slow = events > EVENTS_PER_COLLISION * most as f64;
        // A piece too short for its end to differ from its start ends the loop, too.
        if contacts == most || is_slow || end >= time || 2.0 * until <= until {
            return Ok(contacts);
        }
        until *= 2.0;
    }
}

/// Ties the molecules of a scene while the gases, which begin at index `first`, have these scales.
/// Tethers have the scale of the sum of the two radii: two discs that cannot pass between two tied
/// ones at the end cannot do so before.
fn tie_at_scale(
    world: &mut World,
    scene: &Scene,
    species: &[Species],
    (first, scales): (usize, &[f64]),
) -> Result<(), SceneError> {
    tie(world, scene, species, first)?;
    let of_gas = |pair: &[u64; 2]| pair.iter().any(|&number| number >= first as u64);
    let mut listed = scene.bond.iter().enumerate();
    if let Some((index, _)) = listed.find(|(_, spec)| spec.pairs.iter().any(of_gas)) {
        return Err(SceneError::of_entry(
            &format!("bond[{index}]"),
            "molecules of gases that grow or relax have no places yet: tie them by `chain`",
        ));
    }
    if world.is_tethered() {
        let radii: Vec<[f64; 2]> = (world.bodies.iter().enumerate())
            .map(|(index, body)| {
                let scale = index.checked_sub(first).map_or(1.0, |gas| scales[gas]);
                let radius = body.molecule().bounding_radius();
                [radius, radius / scale]
            })
            .collect();
        let factor = |bodies: [u32; 2]| {
            let [a, b] = bodies.map(|body| radii[body as usize]);
            (a[0] + b[0]) / (a[1] + b[1])
        };
        let grown = world.tethers.grown(factor);
        world.tethers =
            grown.map_err(|reason| SceneError::of_entry("start", reason.to_string()))?;
    }
    Ok(())
}

/// A copy of a world in which no body moves.
fn held(world: &World) -> World {
    let mut held = world.clone();
    for (body, motion) in held.bodies.iter_mut().zip(&mut held.motions) {
        if !body.is_fixed() {
            body.kind = Arc::new(BodyKind {
                inertia: Inertia::FIXED,
                ..(*body.kind).clone()
            });
            *motion = Motion {
                orientation: motion.orientation,
                ..Motion::at_rest(motion.position)
            };
        }
    }
    held
}

/// Refuses overlaps of the molecules of the gases, which are the bodies from `first` on.
fn refuse_overlaps(contents: &SceneContents, first: usize) -> Result<(), SceneError> {
    let world = &contents.singles.world;
    let mut sites = Sites::new(world);
    (0..first).for_each(|index| sites.add(world, index));
    for index in first..world.bodies.len() {
        if let Some((other, depth)) = deepest_overlap(world, &sites, index) {
            let counts = contents.counts();
            let entry = |body: usize| contents.singles.entry_of(body, &counts);
            return Err(SceneError::Overlap {
                first: entry(other),
                second: entry(index),
                depth,
            });
        }
        sites.add(world, index);
    }
    Ok(())
}
