//! Measures: observers by name, whose results become tables, charts and figures of the page.
//!
//! A measure is one file with an observer's [`Measured`] and a [`MeasureKind`], and a line in
//! [`KINDS`]. Its CSV file, chart with error band and prediction, figures and JSON follow from the
//! tables.

mod billiard;
mod body_frame_diffusion;
mod bond_order_correlation;
mod bond_order_relaxation;
mod cage_displacement;
mod chain_relaxation;
mod chains;
mod clusters;
mod collision_rate;
mod contact_density;
mod correlation;
mod crossings;
mod currents;
mod defects;
mod directions;
mod drift;
mod energy;
mod entry;
mod events;
mod fields;
mod free_path;
mod friction;
mod front;
mod haff;
mod hard_discs;
mod helfand;
mod hexatic_order;
mod impulses;
mod incidence;
mod intermediate_scattering;
mod intervals;
mod k_atic;
pub mod kicks;
mod kind;
mod known;
mod lyapunov;
mod measured;
mod numbers;
mod orientation;
mod overlap;
mod pair_distribution;
mod piston;
mod pressure;
mod pressure_tensor;
mod profile;
mod projections;
mod range;
mod relaxation;
mod request;
mod running_average;
mod selection;
mod single;
mod structure_factor;
mod structure_factor_map;
mod temperature;
mod thermal;
mod thermostat;
mod tracked;
mod van_hove;
mod van_hove_distinct;
mod velocities;
mod voronoi;
mod wall_energy;
mod wall_pressure;
mod wells;

use anyhow::Result;
use carom::{
    CollisionReport, Observer, Scene, View,
    engine::{Body, RunSpec},
};
use carom_tables::{Figure, Verdict, is_named};
use rayon::{ThreadPool, ThreadPoolBuilder, prelude::*};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error as _, ser::Error as _};
use serde_json::json;

use self::entry::{Entry, Head};
pub(crate) use self::helfand::{FREE_TIMES_FOR_TRANSPORT, is_transport};
pub(crate) use self::impulses::NAME as IMPULSES;
pub(crate) use self::k_atic::OF_AXES;
use self::kind::{Default, MAX_LAG};
use self::measured::{Measure, in_blocks, point_bytes, resumed};
pub(crate) use self::request::refuse_displaced;
pub(crate) use self::{collision_rate::FIGURE as COLLISION_RATE, wall_pressure::FAR_DENSITY};
pub use self::{
    hard_discs::{DiscMixture, ENSKOG, HardDiscs, LIU},
    kind::{MeasureKind, Of, Parameter, Span},
    measured::{Context, Label, Measured, Results, file_name},
    request::{Request, requests},
    selection::Selection,
    single::SingleMeasure,
    tracked::Tracked,
};
pub use crate::record::Drawing;
use crate::{append_file::AppendFiles, console::put, print_line};

/// All measures.
pub const KINDS: [MeasureKind; 56] = [
    energy::KIND,
    overlap::KIND,
    collision_rate::KIND,
    pressure::KIND,
    pressure_tensor::KIND,
    velocities::KIND,
    temperature::KIND,
    correlation::KIND,
    relaxation::KIND,
    cage_displacement::KIND,
    van_hove::KIND,
    van_hove_distinct::KIND,
    orientation::KIND,
    body_frame_diffusion::KIND,
    friction::KIND,
    pair_distribution::KIND,
    structure_factor::KIND,
    structure_factor_map::KIND,
    intermediate_scattering::KIND,
    currents::KIND,
    hexatic_order::KIND,
    bond_order_correlation::KIND,
    bond_order_relaxation::KIND,
    k_atic::NEMATIC,
    k_atic::TETRATIC,
    k_atic::K_ATIC,
    defects::KIND,
    clusters::KIND,
    clusters::BONDED,
    chains::KIND,
    chain_relaxation::KIND,
    voronoi::KIND,
    free_path::KIND,
    helfand::VISCOSITY,
    helfand::HEAT_CONDUCTIVITY,
    fields::KIND,
    profile::KIND,
    front::KIND,
    kicks::KIND,
    directions::KIND,
    projections::KIND,
    contact_density::KIND,
    drift::KIND,
    running_average::KIND,
    thermostat::KIND,
    wall_energy::HEAT,
    wall_pressure::KIND,
    wells::KIND,
    wall_energy::WORK,
    piston::KIND,
    numbers::KIND,
    crossings::KIND,
    incidence::KIND,
    lyapunov::KIND,
    impulses::KIND,
    events::KIND,
];

/// Measures of every run, whose tables and files are written if the scene asks for them.
const ALWAYS: [&MeasureKind; 3] = [&energy::KIND, &overlap::KIND, &collision_rate::KIND];

/// The error of a figure is judged when it comes from at least this number of blocks. Fewer: the
/// error of the error exceeds 1/√(2 · 32) = 1/8, and runs end where it is small by chance.
const MIN_BLOCKS: usize = 32;

/// Fewest bodies whose samples are taken by several threads. Fewer: threads take longer to wake
/// than a sample takes.
const MIN_BODIES_FOR_THREADS: usize = 10_000;

/// The measures of a run: those of every run, then those of the scene in its order.
pub struct Measures {
    list: Vec<Entry>,
    /// The threads that take the samples of a large system; without them, the run does.
    threads: Option<ThreadPool>,
}

impl Measures {
    /// Starts the measures of a scene.
    ///
    /// # Errors
    /// A measure of the scene is invalid, no body carries a tag, or a body is not unique.
    pub fn new(scene: &Scene, view: &View<'_>) -> Result<Self> {
        let requests = requests(scene)?;
        let is_always =
            |request: &Request| ALWAYS.iter().any(|kind| kind.name == request.kind.name);
        let entry = |request: &Request| Entry::new(request, true, scene, view);
        let mut list = Vec::new();
        for kind in ALWAYS {
            let mut asked = requests
                .iter()
                .filter(|request| request.kind.name == kind.name)
                .peekable();
            if asked.peek().is_none() {
                list.push(Entry::new(&Request::plain(kind), false, scene, view)?);
            }
            for request in asked {
                list.push(entry(request)?);
            }
        }
        for request in requests.iter().filter(|request| !is_always(request)) {
            list.push(entry(request)?);
        }
        Ok(Self::from_list(list))
    }

    fn from_list(list: Vec<Entry>) -> Self {
        Self {
            list,
            threads: None,
        }
    }

    /// Lets several threads take the samples of a large system, each those of some measures: a
    /// result depends on its own measure alone, so their number changes no bit.
    pub(crate) fn run_on(&mut self, threads: usize) {
        let pool = (threads > 1).then(|| ThreadPoolBuilder::new().num_threads(threads).build());
        // If the system has no more threads, the run takes the samples.
        self.threads = pool.and_then(Result::ok);
    }

    /// Their number.
    pub(crate) fn len(&self) -> usize {
        self.list.len()
    }

    /// Memory that the series of all measures take at the end of the run (bytes), in a checkpoint
    /// about as much; logs of contacts go to files.
    pub(crate) fn bytes_at_end(&self, run: &RunSpec) -> u64 {
        self.list
            .iter()
            .map(|entry| entry.bytes_at_end(run))
            .fold(0, u64::saturating_add)
    }

    /// Memory that the sums of the blocks of all measures take at the end of the run (bytes), in a
    /// checkpoint about as much.
    pub(crate) fn bytes_of_blocks(&self, run: &RunSpec) -> u64 {
        self.list
            .iter()
            .map(|entry| entry.bytes_of_blocks(run))
            .sum()
    }

    /// The size of each measure in a checkpoint (bytes).
    ///
    /// # Errors
    /// A measure cannot be encoded.
    pub(crate) fn sizes(&self) -> Result<Vec<u64>> {
        let saved = self.list.iter().map(|entry| entry.measure.save());
        saved.map(|bytes| Ok(bytes?.len() as u64)).collect()
    }

    /// Memory that the samples of past times take at the end of the run (bytes), from the growth of
    /// each measure by its first sample (bytes).
    pub(crate) fn bytes_of_lags(&self, first: &[u64], run: &RunSpec) -> u64 {
        let entries = self.list.iter().zip(first);
        entries
            .map(|(entry, &first)| entry.bytes_of_lags(first, run))
            .sum()
    }

    /// The measures that the scene asks for and that watch contacts, by name and label.
    pub(crate) fn watching(&self) -> Vec<String> {
        let watching = self
            .list
            .iter()
            .filter(|entry| entry.head.is_asked && entry.measure.watches_any());
        watching.map(Entry::name).collect()
    }

    /// Checks for overlaps, if the run has times of their own for that.
    pub fn check(&mut self, view: &View<'_>) {
        self.list.iter_mut().for_each(|entry| entry.check(view));
    }

    /// Ends the run: measures whose last sample is earlier receive this one.
    pub fn finish(&mut self, view: &View<'_>) {
        self.list.iter_mut().for_each(|entry| entry.finish(view));
    }

    /// Tables and figures of all measures.
    pub fn results(&self, scene: &Scene, hard_discs: &Result<HardDiscs, String>) -> Results {
        let mut all = Results::default();
        self.list
            .iter()
            .for_each(|entry| all.absorb(entry.results(scene, hard_discs)));
        all
    }

    /// The figure of this name, if the last sample completed a block of its measure and there are
    /// enough blocks to judge its error.
    pub(crate) fn figure_of_whole_blocks(&self, name: &str, scene: &Scene) -> Option<Figure> {
        let figures = self
            .list
            .iter()
            .flat_map(|entry| entry.figures_of_whole_blocks(scene, MIN_BLOCKS));
        figures
            .into_iter()
            .find(|figure| is_named(&figure.name, name) && figure.standard_error.is_some())
    }

    /// Whether the last sample completed a block of a measure: errors change only then.
    pub(crate) fn complete_a_block(&self) -> bool {
        self.list.iter().any(Entry::completes_a_block)
    }

    /// Whether all measures have enough blocks to judge errors.
    pub(crate) fn are_settled(&self) -> bool {
        self.list.iter().all(|entry| entry.is_settled(MIN_BLOCKS))
    }

    /// The names of all figures that have a standard error at the last sample.
    pub(crate) fn figures_with_errors(&self, scene: &Scene) -> Vec<String> {
        let figures = self.list.iter().flat_map(|entry| entry.figures(scene));
        figures
            .filter(|figure| figure.standard_error.is_some())
            .map(|figure| figure.name)
            .collect()
    }

    /// With `run.measure_from = "auto"`: drops what has been measured so far if a mean changed, and
    /// begins anew with the present sample; likewise if bodies have had few collisions since a
    /// start that was placed, since a slow change is lost in the errors of few samples. That is
    /// judged after 64 samples, and then after twice as many as before, until no mean has changed.
    /// It depends on the samples alone, so that a run that is extended measures the same as a long
    /// one. Call it after each sample.
    ///
    /// # Errors
    /// A measure cannot be begun.
    pub(crate) fn start_anew_unless_settled(
        &mut self,
        scene: &Scene,
        view: &View<'_>,
    ) -> Result<()> {
        if !self.list.iter().any(Entry::is_judged_now) {
            return Ok(());
        }
        let judged: Vec<Figure> = self
            .list
            .iter()
            .filter(|entry| entry.may_begin_anew())
            .flat_map(|entry| entry.figures(scene))
            .collect();
        let is_forgotten = scene.start.from.is_some() || has_forgotten_its_start(view);
        if is_forgotten && carom_tables::are_stationary(&judged) == Some(true) {
            self.list.iter_mut().for_each(Entry::settle);
            return Ok(());
        }
        let fresh = Self::new(scene, view)?.list;
        for (entry, fresh) in self.list.iter_mut().zip(fresh) {
            if entry.may_begin_anew() {
                entry.start_anew(fresh, view);
            }
        }
        Ok(())
    }

    /// Values of the last interval, by short names, from the measures that have them.
    pub(crate) fn present(&self) -> Vec<(&'static str, Option<f64>)> {
        self.list
            .iter()
            .flat_map(|entry| entry.measure.present())
            .collect()
    }

    /// The time from which on the run is measured; `None` if nothing has been measured.
    pub(crate) fn measured_from(&self) -> Option<f64> {
        self.list.iter().find_map(Entry::measured_from)
    }

    /// Writes the last sample to the files that grow with the run.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn append(&mut self, files: &mut AppendFiles) -> Result<()> {
        let asked = self.list.iter_mut().filter(|entry| entry.head.is_asked);
        asked
            .into_iter()
            .try_for_each(|entry| entry.measure.append(files, &entry.head.label))
    }

    /// Writes the contacts of the last epoch to the files that hold every contact, so that memory
    /// does not grow with the time between samples.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn append_contacts(&mut self, files: &mut AppendFiles) -> Result<()> {
        let logs = self
            .list
            .iter_mut()
            .filter(|entry| entry.kind.span == Span::EveryContact);
        logs.into_iter()
            .try_for_each(|entry| entry.measure.append(files, &entry.head.label))
    }
}

/// A symbol with a whole number as its index, such as ψ₆.
fn subscript(symbol: &str, index: u32) -> String {
    let digits = index.to_string();
    let lowered = digits.chars().filter_map(|digit| {
        let value = digit.to_digit(10)?;
        char::from_u32(u32::from('₀') + value)
    });
    symbol.chars().chain(lowered).collect()
}

/// Collisions of each body after which the start is forgotten, in a fluid that is not near its
/// transition.
pub(crate) const COLLISIONS_TO_FORGET: f64 = 50.0;

/// Whether the bodies have had so many collisions that their placement is forgotten. What cannot
/// move has nothing to forget.
fn has_forgotten_its_start(view: &View<'_>) -> bool {
    let moving = view.bodies().filter(|body| body.body.is_free()).count();
    view.counters().collisions_of_moving() as f64 >= COLLISIONS_TO_FORGET * moving as f64
}

/// Prints all measures with their parameters.
pub fn list() -> Verdict {
    put(
        "measures",
        &KINDS
            .iter()
            .map(|kind| json!({ "name": kind.name, "usage": kind.usage(), "about": kind.summary }))
            .collect::<Vec<_>>(),
    );
    print_line(
        "Names for run.observe, and with parameters for [[measure]] (kind = NAME, of = TAG):\n",
    );
    for kind in KINDS {
        print_line(&format!("{}\n    {}", kind.usage(), kind.summary));
        print_parameters(kind.parameters);
    }
    print_line("\nParameters of all measures that take samples:");
    print_parameters(Span::Measurement.parameters());
    Verdict::Passed
}

/// A line for each parameter, with the names in a column.
fn print_parameters(parameters: &[Parameter]) {
    let lengths = parameters.iter().map(|parameter| parameter.name.len());
    let width = lengths.max().unwrap_or(0);
    for Parameter {
        name,
        about,
        default,
        ..
    } in parameters
    {
        print_line(&format!(
            "      {name:<width$}  {about}; default: {default}"
        ));
    }
}

impl Observer for Measures {
    fn watches_any(&self) -> bool {
        self.list.iter().any(Observer::watches_any)
    }

    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.list.iter().any(|entry| entry.watches(bodies))
    }

    fn start(&mut self, view: &View<'_>) {
        self.list.iter_mut().for_each(|entry| entry.start(view));
    }

    fn pause(&mut self, view: &View<'_>) {
        self.list.iter_mut().for_each(|entry| entry.pause(view));
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        let bodies = report.sides.each_ref().map(|side| side.body);
        let watching = self.list.iter_mut().filter(|entry| entry.watches(bodies));
        watching.for_each(|entry| entry.collision(report));
    }

    fn sample(&mut self, view: &View<'_>) {
        let list = &mut self.list;
        match &self.threads {
            Some(threads) if view.bodies().len() >= MIN_BODIES_FOR_THREADS => {
                threads.install(|| list.par_iter_mut().for_each(|entry| entry.sample(view)));
            }
            _ => list.iter_mut().for_each(|entry| entry.sample(view)),
        }
    }
}

/// In a checkpoint each measure is its head and its encoded state.
impl Serialize for Measures {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let encoded = self
            .list
            .iter()
            .map(|entry| Ok((&entry.head, entry.measure.save()?)));
        let encoded: Vec<(&Head, Vec<u8>)> =
            encoded.collect::<Result<_>>().map_err(S::Error::custom)?;
        encoded.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Measures {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let encoded = Vec::<(Head, Vec<u8>)>::deserialize(deserializer)?;
        let restored = encoded
            .into_iter()
            .map(|(head, bytes)| Entry::resume(head, &bytes));
        restored
            .collect::<Result<_>>()
            .map(Self::from_list)
            .map_err(D::Error::custom)
    }
}

#[cfg(test)]
mod tests;
