//! One measure of a run: when it begins, and which samples it receives.

use anyhow::{Context as _, Result, bail, ensure};
use carom::{
    CollisionReport, Observer, Scene, View,
    engine::{Body, MeasureFrom, RunSpec},
};
use carom_tables::{Estimate, Figure, Stationarity, Sums, block_sums, blocking::MAX_BLOCKS};
use serde::{Deserialize, Serialize};

use crate::{record::MeasureRecord, sampling_times::sampling_count, schedule::stages};

use super::{
    Context, HardDiscs, Label, Measure, MeasureKind, Request, Results, Selection, Span,
    haff::CoolingDiscs,
    k_atic,
    kind::{FROM, MAX_LAG, Parameter, UNTIL},
    overlap,
    request::find,
};

/// Samples of the run after which it is judged for the first time whether it has settled. Fewer:
/// too few blocks to judge.
const FIRST_JUDGED: u64 = 64;

/// A sample counts as reached if its time is too early by this share: times of samples are rounded.
const ROUNDING: f64 = 1e-9;

/// Numbers of neighbouring blocks that are joined to judge an error. More: too few blocks remain
/// for an error of their own.
const JOINED: [usize; 2] = [2, 4];

/// Most decades of lags: longer ones than 10¹⁸ samples do not exist.
const MAX_DECADES: f64 = 18.0;

/// A measure in progress.
pub(super) struct Entry {
    pub(super) head: Head,
    pub(super) kind: &'static MeasureKind,
    pub(super) measure: Box<dyn Measure>,
    /// Decades of lags for which it keeps the samples of all bodies; 0 if it keeps none, or if it
    /// comes from a checkpoint.
    decades: u32,
}

/// What an entry needs besides its measure.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Head {
    kind: String,
    pub(super) label: Label,
    /// Whether the scene asks for its tables and files.
    pub(super) is_asked: bool,
    /// It begins at the first sample at or after this time, and ends with that at `until`.
    from: f64,
    until: f64,
    stage: Stage,
    /// Whether it receives the checks of the run, which have times of their own, and no samples.
    is_check: bool,
    /// It receives each sample of this number.
    pub(super) every: u64,
    /// Samples of the run since it began.
    seen: u64,
    /// The kind of its bodies in the numbering of pictures: its curves have their colour.
    kind_of_body: usize,
    /// Samples since it began after which it is judged whether the run has settled; `None` once the
    /// measurement proper has begun.
    judged_at: Option<u64>,
}

/// Whether a measure observes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
enum Stage {
    Waits,
    Observes,
    HasEnded,
}

/// Whether neither heated walls nor thermostats, a drag or a shear act on the bodies.
fn is_left_alone(scene: &Scene) -> bool {
    !scene.has_heated_walls()
        && !stages::is_dragged(scene)
        && !stages::is_sheared(scene)
        && scene.stage.iter().all(|stage| stage.thermostat.is_empty())
}

/// The decades of lags for which a measure keeps the samples of all bodies; 0 if it keeps none.
fn decades_of_lags(kind: &MeasureKind, selection: &Selection<'_>) -> u32 {
    let has_lags = |parameter: &Parameter| parameter.about == MAX_LAG.about;
    if !kind.parameters.iter().any(has_lags) {
        return 0;
    }
    let spacings = selection.longest_lag() / selection.interval();
    spacings.log10().clamp(0.0, MAX_DECADES) as u32 + 1
}

/// A figure judged by the blocks of its sums, which lie in this span of time.
fn judged(figure: Figure, blocks: &[Sums], span: [f64; 2]) -> Figure {
    let Some(quantity) = figure.quantity else {
        return figure.judged_by(blocks.len());
    };
    let runs = [block_sums::of_quantity(blocks, quantity)];
    Figure {
        stationarity: Stationarity::new(&runs, span),
        ..figure.judged_by_blocks(&runs)
    }
}

impl Entry {
    /// Starts what a scene asks for.
    ///
    /// # Errors
    /// No body carries a tag, or a body is not unique.
    pub(super) fn new(
        request: &Request,
        is_asked: bool,
        scene: &Scene,
        view: &View<'_>,
    ) -> Result<Self> {
        let selection = Selection::new(request, &scene.run, view)?;
        let measure = (request.kind.start)(&selection).with_context(|| request.entry.clone())?;
        ensure!(
            !k_atic::OF_AXES.contains(&request.kind.name)
                || selection.has_axes()
                || stages::drives_axes(scene),
            "{}: no body of it has an axis: discs have none, unless a thermostat 'active' of a stage drives them",
            request.entry
        );
        let is_measured = request.kind.span == Span::Measurement;
        let (from, until) = if is_measured {
            stages::window(scene)
        } else {
            (0.0, f64::INFINITY)
        };
        let given = [FROM, UNTIL].map(|key| selection.given(key.name));
        let (from, until) = (given[0].unwrap_or(from), given[1].unwrap_or(until));
        ensure!(
            from <= until,
            "{}: it begins at {from}, but ends at {until}: give an earlier 'from' or a later 'until'",
            request.entry
        );
        let head = Head {
            kind: request.kind.name.to_owned(),
            label: Label {
                tag: request.tag(),
                name: request.name.clone(),
            },
            is_asked,
            from,
            until,
            stage: Stage::Waits,
            is_check: request.kind.name == overlap::KIND.name && scene.run.check_interval.is_some(),
            every: request.every,
            seen: 0,
            kind_of_body: selection.kind_of_body(),
            judged_at: (is_measured
                && given == [None; 2]
                && scene.run.measure_from == MeasureFrom::Auto)
                .then_some(FIRST_JUDGED),
        };
        Ok(Self {
            head,
            kind: request.kind,
            measure,
            decades: decades_of_lags(request.kind, &selection),
        })
    }

    /// Restores a measure from a checkpoint.
    ///
    /// # Errors
    /// Its kind is unknown, or its state cannot be read.
    pub(super) fn resume(head: Head, bytes: &[u8]) -> Result<Self> {
        let Some(kind) = find(&head.kind) else {
            bail!("the measure '{}' is unknown", head.kind)
        };
        let measure = (kind.resume)(bytes)?;
        Ok(Self {
            head,
            kind,
            measure,
            decades: 0,
        })
    }

    /// Memory that its series takes at the end of the run (bytes).
    pub(super) fn bytes_at_end(&self, run: &RunSpec) -> u64 {
        let bytes = self.measure.bytes_per_sample() as u64;
        self.samples(run).saturating_mul(bytes)
    }

    /// Memory that the samples of past times take at the end of the run (bytes), from those of its
    /// first sample: a decade of lags keeps nine samples, and the first is kept in each decade.
    pub(super) fn bytes_of_lags(&self, first: u64, run: &RunSpec) -> u64 {
        let Some(of_sample) = first.checked_div(u64::from(self.decades)) else {
            return 0;
        };
        let samples = self.samples(run).max(1);
        let kept = |decade: u32| ((samples - 1) / 10_u64.pow(decade) + 1).min(9);
        (0..self.decades).map(kept).sum::<u64>() * of_sample
    }

    /// Memory that the sums of its blocks take at the end of the run (bytes).
    pub(super) fn bytes_of_blocks(&self, run: &RunSpec) -> u64 {
        let sums = self.measure.run_sums().total.len() * size_of::<[f64; 2]>();
        self.samples(run).min(MAX_BLOCKS as u64) * sums as u64
    }

    /// The number of its samples in a run.
    fn samples(&self, run: &RunSpec) -> u64 {
        let Head {
            from, until, every, ..
        } = self.head;
        sampling_count(from, until.min(run.until), run.sample_interval) / every.max(1) + 1
    }

    /// Gives the measure its last sample, if it lies between two of its own.
    pub(super) fn finish(&mut self, view: &View<'_>) {
        let is_between =
            self.head.seen > 0 && !(self.head.seen - 1).is_multiple_of(self.head.every);
        if self.is_open() && is_between {
            self.measure.finish(view);
        }
        self.head.stage = Stage::HasEnded;
    }

    /// Gives the measure a check of the run, if it receives them.
    pub(super) fn check(&mut self, view: &View<'_>) {
        if self.head.is_check {
            self.measure.sample(view);
        }
    }

    /// Whether the last sample of the run completed a block.
    pub(super) fn completes_a_block(&self) -> bool {
        let is_new =
            self.head.seen > 0 && (self.head.seen - 1).is_multiple_of(self.head.every.max(1));
        is_new && self.measure.is_whole()
    }

    /// The figures of the measure, if the last sample of the run completed a block and there are at
    /// least `least` blocks. Their errors are the largest of those of the blocks, and of neighbours
    /// joined by two and by four.
    pub(super) fn figures_of_whole_blocks(&self, scene: &Scene, least: usize) -> Vec<Figure> {
        // What is not settled yet may still be dropped.
        let is_kept = self.is_open() && self.head.judged_at.is_none();
        let is_whole = is_kept && self.completes_a_block() && self.measure.blocks() >= least;
        if !is_whole {
            return Vec::new();
        }
        let blocks = self.measure.run_sums().blocks;
        let judged = |figure: Figure| {
            let standard_error = figure
                .standard_error
                .map(|error| error.max(error_of_joined(&blocks, &figure)));
            Figure {
                standard_error,
                ..figure
            }
            .resolved()
        };
        self.figures(scene).into_iter().map(judged).collect()
    }

    /// The figures of the measure at the last sample, without predictions.
    pub(super) fn figures(&self, scene: &Scene) -> Vec<Figure> {
        self.results(scene, &Err(String::new())).figures
    }

    /// Whether the measure has at least `least` blocks, or never will.
    pub(super) fn is_settled(&self, least: usize) -> bool {
        let is_kept = self.head.judged_at.is_none();
        self.head.is_check
            || self.head.stage == Stage::HasEnded
            || is_kept && self.measure.blocks() >= least
    }

    /// Tables and figures of the measure, with its record.
    pub(super) fn results(&self, scene: &Scene, hard_discs: &Result<HardDiscs, String>) -> Results {
        let Self { head, measure, .. } = self;
        let is_elastic = scene.elasticity.is_elastic();
        let loses = scene.elasticity.loses_energy();
        let block = (measure.records_per_block() * head.every) as f64 * scene.run.sample_interval;
        let is_equilibrium = stages::is_equilibrium(scene);
        let is_cooling = loses && is_left_alone(scene);
        let label = &head.label;
        let context = Context {
            label,
            block,
            blocks: &Vec::new(),
            is_elastic,
            is_equilibrium,
            is_cooling,
            falls: stages::falls(scene),
            cooling_discs: is_cooling.then(|| CoolingDiscs::new(scene)).flatten(),
            hard_discs,
        };
        let mut results = measure.results(&context);
        self.prepare_tables(&mut results);
        let sums = measure.run_sums();
        let coefficients = std::mem::take(&mut results.coefficients);
        let runs = std::slice::from_ref(&sums.blocks);
        let of_curves: Vec<Figure> = coefficients
            .iter()
            .filter_map(|coefficient| coefficient.figure(&sums.total, runs))
            .collect();
        let begin = if head.from.is_finite() {
            head.from
        } else {
            0.0
        };
        let span = [begin, begin + block * sums.blocks.len() as f64];
        let figures: Vec<Figure> = (results.figures.into_iter())
            .map(|figure| judged(figure, &sums.blocks, span))
            .collect();
        let lacks_figures = figures.is_empty() && of_curves.is_empty() && !coefficients.is_empty();
        if head.is_asked && lacks_figures {
            results.silent.push(self.name());
        }
        results.records.push(MeasureRecord {
            span,
            sums,
            tables: results.tables.clone(),
            figures: figures
                .iter()
                .map(|figure| (figure.clone(), figure.quantity))
                .collect(),
            coefficients,
            of_curves: of_curves.clone(),
            drawings: results.drawings.clone(),
        });
        results.figures = of_curves.into_iter().chain(figures).collect();
        results
    }

    /// Leaves out tables and files that the scene does not ask for, and gives the others the colour
    /// and the word of the group.
    fn prepare_tables(&self, results: &mut Results) {
        if !self.head.is_asked {
            results.tables.clear();
            results.files.clear();
            results.drawings.clear();
        }
        for table in &mut results.tables {
            table.colour = self.head.kind_of_body;
            // Charts of several groups stand side by side.
            if let Some(word) = self.head.label.word() {
                table.title = format!("{}, {word}", table.title);
            }
        }
    }

    /// Whether it takes part in the search for the time from which on the run has settled, and now
    /// is the sample at which that is judged.
    pub(super) fn is_judged_now(&self) -> bool {
        self.head.judged_at.is_some_and(|at| self.head.seen > at)
    }

    /// Whether it takes part in that search.
    pub(super) fn may_begin_anew(&self) -> bool {
        self.head.judged_at.is_some()
    }

    /// Ends the search: what has been measured counts.
    pub(super) fn settle(&mut self) {
        self.head.judged_at = None;
    }

    /// Begins the measurement anew with the present sample, to be judged when it has twice as many
    /// samples as this one.
    pub(super) fn start_anew(&mut self, mut fresh: Self, view: &View<'_>) {
        fresh.head.from = view.time().to_f64();
        fresh.head.judged_at = self.head.judged_at.map(|at| 2 * at);
        *self = fresh;
        self.sample(view);
    }

    /// The time from which on it has measured; `None` before.
    pub(super) fn measured_from(&self) -> Option<f64> {
        (self.kind.span == Span::Measurement && self.head.from.is_finite() && self.head.seen > 0)
            .then_some(self.head.from)
    }

    /// Its kind and label, as in `run.observe`.
    pub(super) fn name(&self) -> String {
        match self.head.label.word() {
            Some(word) => format!("{}:{word}", self.kind.name),
            None => self.kind.name.to_owned(),
        }
    }

    fn is_open(&self) -> bool {
        self.head.stage == Stage::Observes
    }
}

/// The largest error of a mean from joined neighbours of its blocks: larger than that of the blocks
/// themselves where these are shorter than the correlation time. 0 for a figure that is no mean.
fn error_of_joined(blocks: &[Sums], figure: &Figure) -> f64 {
    let Some(quantity) = figure.quantity else {
        return 0.0;
    };
    let of = |block: &Sums| block.get(quantity).copied().unwrap_or_default();
    let sum = |blocks: &[Sums]| {
        blocks.iter().map(of).fold([0.0; 2], |sum, block| {
            [sum[0] + block[0], sum[1] + block[1]]
        })
    };
    let joined = |count: usize| -> Vec<[f64; 2]> { blocks.chunks_exact(count).map(sum).collect() };
    let estimates = JOINED
        .iter()
        .filter_map(|&count| Estimate::of_runs(&[joined(count)]));
    estimates
        .map(|estimate| estimate.standard_error)
        .fold(0.0, f64::max)
}

impl Observer for Entry {
    fn watches_any(&self) -> bool {
        self.is_open() && self.measure.watches_any()
    }

    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.is_open() && self.measure.watches(bodies)
    }

    fn start(&mut self, view: &View<'_>) {
        if self.is_open() {
            self.measure.start(view);
        }
    }

    fn pause(&mut self, view: &View<'_>) {
        if self.is_open() {
            self.measure.pause(view);
        }
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.measure.collision(report);
    }

    fn sample(&mut self, view: &View<'_>) {
        let head = &mut self.head;
        if head.stage == Stage::HasEnded || head.is_check {
            return;
        }
        if head.stage == Stage::Waits {
            if view.time().to_f64() < head.from * (1.0 - ROUNDING) {
                return;
            }
            head.stage = Stage::Observes;
            self.measure.start(view);
        }
        if head.seen.is_multiple_of(head.every.max(1)) {
            self.measure.sample(view);
        }
        head.seen += 1;
        if view.time().to_f64() >= head.until * (1.0 - ROUNDING) {
            self.finish(view);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn correlated_blocks_are_found_by_joining_them() {
        let figure = Figure {
            quantity: Some(0),
            ..Figure::new("x", 0.0, "1")
        };
        let error = |values: &dyn Fn(usize) -> f64| {
            let blocks: Vec<Sums> = (0..32).map(|index| vec![[values(index), 1.0]]).collect();
            let plain: Vec<[f64; 2]> = blocks.iter().map(|block| block[0]).collect();
            error_of_joined(&blocks, &figure) / Estimate::of_runs(&[plain]).unwrap().standard_error
        };
        // A slow wave: neighbours are equal, and each block says nothing new.
        assert!(error(&|index| (0.2 * index as f64).sin()) > 1.3);
        // Blocks of alternating signs cancel.
        assert!(error(&|index| if index % 2 == 0 { 1.0 } else { -1.0 }) < 1e-12);
        assert_eq!(error_of_joined(&[], &Figure::new("x", 0.0, "1")), 0.0);
    }
}
