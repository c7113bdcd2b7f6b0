//! Results of a run: series, figures, and page.

use anyhow::{Error, Result};
use carom::{
    Observer, Scene, View,
    engine::{BodyView, MeasureFrom, ReactionCounts, RunSpec, TileCounters},
};
use carom_methods::{AnySimulation, Method};
use carom_tables::{
    Check, Figure, OVERLAPPING_PAIRS, Summary, Table, Totals, stationarity::MIN_JUDGED,
};
use serde::{Deserialize, Serialize};

use super::{
    measured_before::{earlier_series, put_before, remove_earlier_series},
    steps::{self, Output},
};
use crate::schedule::{stage_edits, stages};
use crate::{
    animation,
    clock::ThreadTime,
    file_names::PICTURES,
    folder_lock::Ousted,
    interruption::{Interrupted, Signals},
    measures::{HardDiscs, Measures, Results},
    memory::{self, Demand},
    price::{self, Price},
    progress::Progress,
    record::{Record, RunRecord},
    report::{
        FIXED_BODIES, MEASURED_FROM, NOT_EXACT, few_samples_in_words, is_rate_of_kicks, judged,
    },
    resumable::{FoundCheckpoint, Resumable, Start, Task},
    run_totals::allowed_drift_now,
    visible_region::picture_of,
    whole_box::maps_of,
};

/// Longer side of a picture of the system (pixels).
pub(super) const PICTURE: u32 = 720;

/// Figures of contacts at one instant, which are not shown where they are 0.
pub const AT_ONCE: [&str; 2] = [
    "contacts at several points at once",
    "contacts at one instant with another of the same body",
];

/// Number of events of bonds.
pub const OF_BONDS: &str = "events of bonds";
/// Name of the number of steps of wells.
pub const OF_WELLS: &str = "steps of wells";

/// A run ends at its end to this share of it: rounding of the clock.
const END: f64 = 1e-12;

/// Results of a run.
#[derive(Debug, Serialize, Deserialize)]
pub struct RunOutcome {
    /// Tables and figures of the measures.
    pub results: Results,
    totals: Totals,
    /// Number of bodies; walls do not count, pistons do.
    bodies: usize,
    /// Number of those that cannot move: bumpers and fixed molecules.
    fixed: usize,
    /// kT at the end (mass × length² / time²); `None` without thermal motion.
    temperature: Option<f64>,
    /// Number of contacts whose elasticity the guard against inelastic collapse raised, and the
    /// energy that it spared divided by the energy lost; `None` if there was none.
    guarded: Option<(u64, f64)>,
    /// Contacts of two bodies at several points at one instant, and contacts that follow another
    /// one of the same body at the same instant.
    at_once: [u64; 2],
    /// Events of bonds, if there are any bonds.
    of_bonds: Option<u64>,
    /// Steps of wells, if discs have wells or have had them.
    of_wells: Option<u64>,
    /// The time from which on the run was measured, if the run has found it.
    measured_from: Option<f64>,
    /// Number of bodies at rest that thermostats have left out, summed over their actions, by tag.
    left_at_rest: Vec<(String, u64)>,
    /// The reactions that are or have been in force, in a line each, and what they have done.
    reactions: Vec<(String, ReactionCounts)>,
    /// What the method saves and gets wrong, if it is not the default.
    price: Option<Price>,
}

/// Whether the price of a method that is not the default is measured at the end of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pricing {
    /// It is measured.
    Measured,
    /// It is left out.
    LeftOut,
}

/// A simulation at the start of a run, its measures, and the number of draws of random numbers by
/// the first stage.
pub type Begun = (AnySimulation, Measures, u64);

/// The results of a run: to its end, or to the error that ended it.
#[derive(Debug)]
pub struct RunEnd {
    /// What was measured.
    pub outcome: RunOutcome,
    /// The error, if the run could not continue.
    pub error: Option<Error>,
    /// Errors after that one, which it may have caused.
    pub later: Vec<Error>,
    /// Work in tiles since the run was started or last resumed.
    pub tiles: TileCounters,
}

impl RunEnd {
    /// The results of a run that has reached its end.
    fn new(outcome: RunOutcome, tiles: TileCounters) -> Self {
        Self {
            outcome,
            error: None,
            later: Vec::new(),
            tiles,
        }
    }
}

/// Runs to the end, from the beginning (`start`) or from a checkpoint, and writes series and
/// snapshots. A run that cannot continue gives what was measured until then, with the error.
///
/// # Errors
/// The run cannot begin, a file cannot be written, or a signal has been received.
pub fn simulate(
    task: &Task<'_>,
    found: Option<FoundCheckpoint>,
    scene: &Scene,
    pricing: Pricing,
    start: impl FnOnce() -> Result<Begun>,
) -> Result<RunEnd> {
    let run = &scene.run;
    let progress = Progress::new(run.until);
    let mut earlier = Vec::new();
    let mut going = match task.start::<Measures, RunOutcome>(found)? {
        Start::Ended(outcome) => return Ok(RunEnd::new(outcome, TileCounters::default())),
        Start::From(going) => {
            // The picture is needed at the end; a missing one is an error now rather than then.
            task.folder.read(PICTURES[0])?;
            if run.animation && going.simulation.time().to_f64() > run.animation_from {
                task.folder.read(animation::ANIMATION)?;
            }
            earlier = earlier_series(task.folder.path())?;
            *going
        }
        Start::Anew => first_steps(task, start()?, run)?,
    };
    going.observers.run_on(task.threads);
    progress.skip(going.simulation.time().to_f64());
    let error = steps::proceed(&mut going, task, scene, Output::Files, &progress).err();
    drop(progress);
    if let Some(error) = error {
        if error
            .chain()
            .any(|cause| cause.is::<Interrupted>() || cause.is::<Ousted>())
        {
            return Err(error);
        }
        return Ok(failed_end(error, &mut going, task, scene, &earlier));
    }
    going.observers.finish(&going.simulation.view());
    let mut outcome = outcome_so_far(&going, scene, &earlier);
    write_results(&outcome, &going, task)?;
    if pricing == Pricing::Measured {
        // A run whose last state is of no use for an exact run is not at fault.
        outcome.price =
            price::of_run(&going.simulation, &task.method, scene, going.seconds()).unwrap_or(None);
    }
    let tiles = going.simulation.tile_counters();
    going.end(task, &outcome)?;
    Ok(RunEnd::new(outcome, tiles))
}

/// Writes what was measured until the error that ends a run, and returns both.
fn failed_end(
    error: Error,
    going: &mut Resumable<Measures>,
    task: &Task<'_>,
    scene: &Scene,
    earlier: &[Table],
) -> RunEnd {
    let outcome = outcome_so_far(going, scene, earlier);
    let flushed = going.files.lengths().map(drop);
    let later = [flushed, write_results(&outcome, going, task)]
        .into_iter()
        .filter_map(Result::err);
    let (later, tiles) = (later.collect(), going.simulation.tile_counters());
    RunEnd {
        outcome,
        error: Some(error),
        later,
        tiles,
    }
}

/// The outcome of a run up to now, with the rows that were measured before it was saved.
fn outcome_so_far(going: &Resumable<Measures>, scene: &Scene, earlier: &[Table]) -> RunOutcome {
    let view = going.simulation.view();
    let mut outcome = outcome_of(&view, &going.observers, going.seconds(), scene);
    put_before(earlier, &mut outcome.results.tables);
    outcome
}

/// Writes the tables of an outcome, and the last picture.
fn write_results(outcome: &RunOutcome, going: &Resumable<Measures>, task: &Task<'_>) -> Result<()> {
    task.folder
        .write_lasting(PICTURES[1], picture_of(&going.simulation.view(), PICTURE))?;
    for (file, map) in maps_of(&going.simulation.view()) {
        task.folder.write_lasting(file, map)?;
    }
    // A run that has ended is not run again: its tables must be as lasting as its last checkpoint.
    outcome
        .results
        .write_lasting(task.folder, |name| going.files.holds(name))
}

/// Runs a scene in memory and writes nothing.
///
/// # Errors
/// The scene is invalid or does not fit into the memory, the run fails, or a signal has been
/// received.
pub fn in_memory(scene: &Scene, signals: &Signals) -> Result<RunOutcome> {
    let clock = ThreadTime::now();
    stages::check(scene)?;
    Demand::new(scene)?.refuse_unless_fits(memory::available())?;
    let mut simulation = AnySimulation::new(scene)?;
    let actions = stage_edits::prepare(&mut simulation, scene, 0)?;
    let mut measures = Measures::new(scene, &simulation.view())?;
    measures.start(&simulation.view());
    measures.sample(&simulation.view());
    measures.check(&simulation.view());
    steps::take_all(&mut simulation, &mut measures, scene, actions, signals)?;
    measures.finish(&simulation.view());
    Ok(outcome_of(
        &simulation.view(),
        &measures,
        clock.elapsed().as_secs_f64(),
        scene,
    ))
}

/// Starts a run: initial picture, and the sample at time 0.
fn first_steps(
    task: &Task<'_>,
    (simulation, measures, actions): Begun,
    run: &RunSpec,
) -> Result<Resumable<Measures>> {
    task.folder.remove_earlier_results()?;
    remove_earlier_series(task.folder.path())?;
    task.folder
        .write_lasting(PICTURES[0], picture_of(&simulation.view(), PICTURE))?;
    let mut going = Resumable::new(task, simulation, measures);
    going.actions = actions;
    steps::take_first(&mut going, run, Output::Files)?;
    Ok(going)
}

/// The outcome of a run that has reached its end.
pub(super) fn outcome_of(
    view: &View<'_>,
    measures: &Measures,
    seconds: f64,
    scene: &Scene,
) -> RunOutcome {
    let (hard_discs, judged) = theory(view, scene);
    let results = measures.results(&judged, &hard_discs);
    let collisions = view.counters().collisions;
    let is_fixed = |body: &BodyView<'_>| body.body.is_fixed();
    let is_wall = |body: &BodyView<'_>| body.body.is_wall() && is_fixed(body);
    let bodies = || view.bodies().filter(|body| !is_wall(body));
    RunOutcome {
        totals: Totals {
            collisions,
            simulated_time: simulated_time(view, scene),
            collisions_per_second: collisions as f64 / seconds.max(1e-9),
            allowed_drift: allowed_drift_now(view),
            ..results.totals
        },
        results,
        bodies: bodies().count(),
        fixed: bodies().filter(is_fixed).count(),
        temperature: view.temperature(),
        left_at_rest: left_at_rest(view),
        at_once: [
            view.counters().joint_collisions,
            view.counters().simultaneous_collisions,
        ],
        of_bonds: Some(view.counters().bond_collisions)
            .filter(|&count| count > 0 || view.bonds().len() > 0),
        of_wells: Some(view.counters().step_collisions)
            .filter(|&count| count > 0 || view.has_wells()),
        measured_from: measures
            .measured_from()
            .filter(|_| scene.run.measure_from == MeasureFrom::Auto),
        price: None,
        reactions: reactions(view),
        guarded: (view.ledger().spared > 0.0).then(|| {
            let ledger = view.ledger();
            (
                view.counters().guarded_collisions,
                ledger.spared / ledger.lost.max(ledger.spared),
            )
        }),
    }
}

/// The end of the run, or the time at which it failed; their difference is more than rounding.
fn simulated_time(view: &View<'_>, scene: &Scene) -> f64 {
    let (now, until) = (view.time().to_f64(), scene.run.until);
    if (until - now).abs() <= END * until {
        until
    } else {
        now
    }
}

/// The gas to which theory applies in the measured part of a run, or why there is none; and the
/// scene with the elasticity in force there.
fn theory(view: &View<'_>, scene: &Scene) -> (Result<HardDiscs, String>, Scene) {
    let in_force = stages::measured_elasticities(scene);
    let judged = in_force
        .iter()
        .find(|spec| !spec.is_elastic())
        .unwrap_or(&in_force[0]);
    let hard_discs = match stages::is_disturbed(scene) {
        Some(reason) => Err(reason.to_owned()),
        None => HardDiscs::new(view, judged),
    };
    (
        hard_discs,
        Scene {
            elasticity: (*judged).clone(),
            ..scene.clone()
        },
    )
}

/// Names of tags with bodies that thermostats have left out because they were at rest, with their
/// number.
fn left_at_rest(view: &View<'_>) -> Vec<(String, u64)> {
    let heats = view
        .heat()
        .all()
        .iter()
        .filter(|heat| heat.counts.at_rest > 0);
    heats
        .map(|heat| {
            (
                view.tag_names().name(heat.tag).to_owned(),
                heat.counts.at_rest,
            )
        })
        .collect()
}

/// Whether it was judged if means change, or no figure has an error. The collision rate of all
/// bodies, which every run measures, does not stand for the kicks on one of them.
fn is_judged(figures: &[Figure]) -> bool {
    let with_errors = || {
        figures
            .iter()
            .filter(|figure| figure.standard_error.is_some())
    };
    let is_judged = |figure: &Figure| judged(figure).is_some();
    let mut kicks = with_errors().filter(|figure| is_rate_of_kicks(figure));
    kicks.all(is_judged) && (with_errors().next().is_none() || with_errors().any(is_judged))
}

/// The reactions that are or have been in force, by names that differ, and what they have done.
fn reactions(view: &View<'_>) -> Vec<(String, ReactionCounts)> {
    let mut named: Vec<(String, ReactionCounts)> = Vec::new();
    for record in view.reactions() {
        let equation = record.spec.equation();
        let begins = |(name, _): &&(String, ReactionCounts)| name.starts_with(&equation);
        let name = match named.iter().filter(begins).count() {
            0 => equation,
            earlier => format!("{equation} ({})", earlier + 1),
        };
        named.push((name, record.counts));
    }
    named
}

/// The figures of a reaction: their number, their share of the contacts, and their energy.
fn reaction_figures((name, counts): &(String, ReactionCounts)) -> Vec<Figure> {
    let contacts = counts.contacts as f64;
    let share = counts.reactions as f64 / contacts;
    let of = |quantity: &str| format!("{quantity}, {name}");
    let number = Figure::new(of("reactions"), counts.reactions as f64, "1");
    let energy = Figure::new(
        of("energy put in by reactions"),
        counts.energy,
        "mass·length²/time²",
    );
    let mut figures = vec![number, energy];
    if contacts > 0.0 {
        // Each contact decides by itself.
        let error = (share * (1.0 - share) / contacts).sqrt();
        let figure = Figure::new(of("share of contacts that react"), share, "1");
        figures.push(figure.error(Some(error)));
    }
    if counts.blocked > 0 {
        let name = of("reactions without room for the product");
        figures.push(Figure::new(name, counts.blocked as f64, "1"));
    }
    figures
}

/// Whether a figure is shown: contacts at one instant are, where there are any.
pub fn is_shown(figure: &Figure) -> bool {
    figure.value != 0.0 || !AT_ONCE.contains(&figure.name.as_str())
}

impl RunOutcome {
    /// What the method saves and gets wrong, if it is not the default.
    pub fn price(&self) -> Option<&Price> {
        self.price.as_ref()
    }

    /// Figures of the whole system at the end.
    fn system_figures(&self) -> Vec<Figure> {
        let bodies = Figure::new("bodies", self.bodies as f64, "1");
        let temperature =
            |kt: f64| Figure::new("temperature kT at the end", kt, "mass·length²/time²");
        let fixed = (self.fixed > 0).then(|| Figure::new(FIXED_BODIES, self.fixed as f64, "1"));
        let from = |time: f64| Figure::new(MEASURED_FROM, time, "time");
        let [joint, simultaneous] = self.at_once;
        // Also where there are none: a mean over replicas needs all of them.
        let several = Some(Figure::new(AT_ONCE[0], joint as f64, "1"));
        let at_once = Some(Figure::new(AT_ONCE[1], simultaneous as f64, "1"));
        let of_bonds = self
            .of_bonds
            .map(|count| Figure::new(OF_BONDS, count as f64, "1"));
        let of_wells = self
            .of_wells
            .map(|count| Figure::new(OF_WELLS, count as f64, "1"));
        let optional = [
            fixed,
            self.temperature.map(temperature),
            self.measured_from.map(from),
            several,
            at_once,
            of_bonds,
            of_wells,
        ];
        std::iter::once(bodies)
            .chain(optional.into_iter().flatten())
            .chain(self.reactions.iter().flat_map(reaction_figures))
            .collect()
    }

    /// Notes on the trajectory.
    fn note_on_dynamics(&self, method: &Method) -> Vec<String> {
        let mut notes = Vec::new();
        if !method.is_exact() {
            notes.push(format!(
                "{NOT_EXACT}. Method: {method}. Contacts may be missed, late or invented, so overlaps are a \
                 result here and not a fault."
            ));
        }
        if self.at_once[1] > 0 {
            notes.push(
                "Some contacts followed another one of the same body at the same instant. They were resolved one after \
                 the other, in the order of the numbers of their bodies, on which the result depends."
                    .to_owned(),
            );
        }
        notes
    }

    /// Notes on this run alone, where data are few.
    fn note_on_data(&self) -> Vec<String> {
        let mut notes = self.results.reasons.clone();
        if !self.results.silent.is_empty() {
            notes.push(format!(
                "Too little data for a figure of {}: run longer, or sample more often.",
                self.results.silent.join(", ")
            ));
        }
        notes.extend(few_samples_in_words(&self.results.figures));
        if !is_judged(&self.results.figures) {
            notes.push(format!(
                "Whether the means change was not judged: it takes {MIN_JUDGED} samples of a measure or more."
            ));
        }
        notes
    }

    /// Figures and checks.
    pub fn summary(&self, title: String, method: &Method) -> Summary {
        let mut figures = self.system_figures();
        figures.retain(is_shown);
        figures.extend(self.results.figures.iter().map(|figure| Figure {
            stationarity: judged(figure),
            ..figure.clone()
        }));
        if let Some((guarded, share)) = self.guarded {
            figures.push(Figure::new(
                "contacts that the guard against collapse raised",
                guarded as f64,
                "1",
            ));
            figures.push(Figure::new(
                "energy that it spared, by energy lost",
                share,
                "1",
            ));
        }
        for (tag, count) in &self.left_at_rest {
            let name = format!("bodies at rest that thermostats left out, {tag}");
            figures.push(Figure::new(name, *count as f64, "1"));
        }
        let mut checks = self.totals.checks();
        if !method.is_exact() {
            checks.retain(|check| check.name != OVERLAPPING_PAIRS);
            figures.extend(self.overlap_figures());
        }
        figures.extend(self.price.iter().flat_map(Price::figures));
        let notes = [self.note_on_dynamics(method), self.note_on_data()];
        let note = notes.concat().join(" ");
        checks.extend(figures.iter().filter_map(Figure::check));
        Summary {
            title,
            note,
            totals: self.totals,
            checks,
            figures,
            runs: Vec::new(),
        }
    }

    /// Figures of the overlaps at the samples, which a method that is not exact allows.
    fn overlap_figures(&self) -> [Figure; 2] {
        let pairs = self.totals.overlapping_pairs as f64;
        let depth = self.totals.max_overlap;
        [
            Figure::new("overlapping pairs at a sample, at most", pairs, "1"),
            Figure::new(
                "deepest overlap at a sample, by the smaller diameter",
                depth,
                "1",
            ),
        ]
    }

    /// The summary of a run that ended with an error before its end at `until`.
    pub fn summary_of_failed(&self, title: String, method: &Method, until: f64) -> Summary {
        let mut summary = self.summary(title, method);
        let left = until - self.totals.simulated_time;
        summary.checks.insert(
            0,
            Check {
                passed: false,
                ..Check::at_most("time_left", left, 0.0)
            },
        );
        summary
    }

    /// What other runs of the scene are merged with.
    pub fn record(&self, scene: &Scene, method: &Method) -> Record {
        let note = self.note_on_dynamics(method).join(" ");
        let run = RunRecord {
            // The speed differs between runs of the same bits.
            totals: Totals {
                collisions_per_second: 0.0,
                ..self.totals
            },
            note,
            figures: self.system_figures(),
            measures: self.results.records.clone(),
        };
        Record::new(scene, run)
    }
}
