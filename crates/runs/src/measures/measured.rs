//! What makes an observer a measure: sums for errors, tables, figures, and files.

use anyhow::Result;
use carom::{
    CollisionReport, Observer, View,
    engine::Body,
    observers::{AdaptiveHistogram, Bins},
};
use carom_tables::{
    BlockMean, BlockSums, Blocking, Figure, RunSums, Sums, Table, Totals, block_sums,
};
use serde::{Deserialize, Serialize, de::DeserializeOwned};

use super::{HardDiscs, haff::CoolingDiscs};
use crate::{
    append_file::AppendFiles,
    checkpoint_file::{decode, encode},
    curves::{Coefficient, error_at_lag},
    finite::require_finite,
    output::Folder,
    record::{Drawing, MeasureRecord},
};

/// An observer whose results can be tabulated.
pub trait Measured: Observer + Serialize + DeserializeOwned + Send + 'static {
    /// Whether the sums belong to the intervals between samples, so that the first sample, which
    /// ends none, gives no record.
    const OF_INTERVALS: bool = false;

    /// Σx and Σw so far of each quantity whose mean is Σx / Σw; their order never changes. They are
    /// recorded at the borders of blocks and give the standard errors.
    fn sums(&self) -> Sums {
        Vec::new()
    }

    /// Memory that one more sample takes until the end of the run (bytes), in a checkpoint about as
    /// much; 0 if the state has a bounded size.
    fn bytes_per_sample(&self) -> usize {
        0
    }

    /// The distributions from the start up to now, those with common bins together; their order
    /// never changes. The density in each bin is a further quantity, after those of [`Self::sums`].
    fn distributions(&self) -> Vec<Vec<&AdaptiveHistogram>> {
        Vec::new()
    }

    /// Quantities of the last interval, by short names, for a table of the state of a run.
    fn present(&self) -> Vec<(&'static str, Option<f64>)> {
        Vec::new()
    }

    /// Tables and figures. `means` belong to [`Self::sums`] and to the bins of
    /// [`Self::distributions`].
    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results;

    /// Writes what is new to a file that grows with the run, after each sample; for a kind of
    /// [`Span::EveryContact`](super::Span), after each epoch too.
    ///
    /// # Errors
    /// A file cannot be written.
    fn append(&mut self, files: &mut AppendFiles, label: &Label) -> Result<()> {
        let _ = (files, label);
        Ok(())
    }
}

/// What distinguishes a measure from others of its kind.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Label {
    /// The tags of its bodies, if it has any.
    pub tag: Option<String>,
    /// Its name, if it has one; it replaces the tag.
    pub name: Option<String>,
}

impl Label {
    /// The name, or else the tag.
    pub fn word(&self) -> Option<&str> {
        self.name.as_deref().or(self.tag.as_deref())
    }

    /// The name of a file or table, with the label before the ending.
    pub fn file(&self, name: &str) -> String {
        let Some(word) = self.word() else {
            return name.to_owned();
        };
        match name.split_once('.') {
            Some((stem, ending)) => format!("{stem}-{word}.{ending}"),
            None => format!("{name}-{word}"),
        }
    }
}

/// What results depend on besides the observer.
#[derive(Debug, Clone, Copy)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "independent facts of the scene, each read by other measures"
)]
pub struct Context<'a> {
    /// What distinguishes the measure from others of its kind.
    pub label: &'a Label,
    /// Duration of a block (time).
    pub block: f64,
    /// The sums of each complete block of the run, in the order of time.
    pub blocks: &'a Vec<Sums>,
    /// Whether all contacts conserve energy.
    pub is_elastic: bool,
    /// Whether the measured part can be at equilibrium: all contacts conserve energy, and neither
    /// thermostats nor heated walls act.
    pub is_equilibrium: bool,
    /// Whether contacts lose energy that nothing gives back: the gas cools.
    pub is_cooling: bool,
    /// Whether bodies fall, so that the gas has no bulk of one density.
    pub falls: bool,
    /// A gas of equal discs that cools, whose law is known.
    pub(super) cooling_discs: Option<CoolingDiscs>,
    /// The gas to which theory applies, or why it does not.
    pub hard_discs: &'a Result<HardDiscs, String>,
}

impl Context<'_> {
    /// The name of a table, with the label.
    pub fn table(&self, name: &str) -> String {
        self.label.file(name)
    }

    /// The name of a figure, with the label.
    pub fn named(&self, name: &str) -> String {
        self.label
            .word()
            .map_or_else(|| name.to_owned(), |word| format!("{name}, {word}"))
    }

    /// The label and the duration of a block (time), which coefficients of curves have.
    pub(crate) fn of_curves(&self) -> (Option<&str>, f64) {
        (self.label.word(), self.block)
    }

    /// The gas to which theory applies.
    pub fn gas(&self) -> Option<&HardDiscs> {
        self.hard_discs.as_ref().ok()
    }

    /// A mean as a figure, with its error and the label; `None` without a mean.
    pub fn figure(&self, name: &str, unit: &str, mean: &BlockMean) -> Option<Figure> {
        let figure = Figure::new(self.named(name), mean.value?, unit).error(mean.standard_error);
        Some(Figure {
            quantity: mean.quantity,
            ..figure
        })
    }

    /// The means as figures by name, unit and prediction, whose source is the same; those without a
    /// value are left out.
    pub fn figures<'a>(
        &self,
        names: impl IntoIterator<Item = (&'a str, &'a str, Option<f64>)>,
        means: &[BlockMean],
        source: &str,
    ) -> Vec<Figure> {
        let named = names.into_iter().zip(means);
        let figure = |((name, unit, prediction), mean): ((&str, &str, Option<f64>), &BlockMean)| {
            Some(self.figure(name, unit, mean)?.predicted(prediction, source))
        };
        named.filter_map(figure).collect()
    }

    /// Means at these lags (time). The errors of lags as long as a block are those of joined
    /// blocks: a block holds pairs whose first sample lies before it. Still longer lags have none.
    pub fn resolved(&self, means: &[BlockMean], lags: &[f64]) -> Vec<BlockMean> {
        let runs = std::slice::from_ref(self.blocks);
        let of = |(mean, &lag): (&BlockMean, &f64)| BlockMean {
            standard_error: error_at_lag(mean, lag, self.block, runs),
            ..*mean
        };
        means.iter().zip(lags).map(of).collect()
    }

    /// The means of one quantity of several, each of which has a mean at each of `all` lags, at the
    /// first of them (time). Lags without pairs are the longest.
    pub fn at_lags(
        &self,
        means: &[BlockMean],
        quantity: usize,
        all: usize,
        lags: &[f64],
    ) -> Vec<BlockMean> {
        let begin = (quantity * all).min(means.len());
        self.resolved(&means[begin..], lags)
    }

    /// A sentence on the prediction for the caption.
    pub fn theory(&self, prediction: &str) -> String {
        match self.hard_discs {
            Ok(_) => prediction.to_owned(),
            Err(reason) => format!("No prediction: {reason}."),
        }
    }
}

/// Tables and figures of a measure.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Results {
    /// The tables, each a CSV file and one or more charts.
    pub tables: Vec<Table>,
    /// The figures.
    pub figures: Vec<Figure>,
    /// Drawings of what was measured.
    pub drawings: Vec<Drawing>,
    /// Data files that no table describes.
    pub files: Vec<String>,
    /// Energy drift and overlaps, from the measures that find them.
    pub totals: Totals,
    /// Number of samples at which overlaps were searched.
    pub overlap_checks: u64,
    /// Sums, tables and figures of each measure, for merging with other runs.
    pub records: Vec<MeasureRecord>,
    /// Coefficients of curves over the lag, which become figures.
    #[serde(skip)]
    pub(crate) coefficients: Vec<Coefficient>,
    /// Why a measure that the scene asks for has no figure, as sentences.
    pub reasons: Vec<String>,
    /// Measures that the scene asks for and that have no figure because the run was too short.
    pub silent: Vec<String>,
}

impl Results {
    /// Adds the results of another measure. Tables, figures and files are taken if `is_asked`
    /// requests them; what every run reports is always taken.
    pub(super) fn absorb(&mut self, other: Self) {
        self.tables.extend(other.tables);
        self.figures.extend(other.figures);
        self.drawings.extend(other.drawings);
        self.files.extend(other.files);
        let (totals, found) = (&mut self.totals, other.totals);
        totals.energy_drift = totals.energy_drift.max(found.energy_drift);
        totals.overlapping_pairs = totals.overlapping_pairs.max(found.overlapping_pairs);
        totals.max_overlap = totals.max_overlap.max(found.max_overlap);
        self.overlap_checks += other.overlap_checks;
        self.records.extend(other.records);
        self.silent.extend(other.silent);
        self.reasons.extend(other.reasons);
    }

    /// Writes the tables as CSV files.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(&self, folder: &Folder) -> Result<()> {
        self.drawings
            .iter()
            .try_for_each(|drawing| folder.write(&drawing.file, &drawing.svg))?;
        self.tables.iter().try_for_each(|table| {
            folder.write_table(&file_name(table), &table.header(), table.rows())
        })
    }

    /// Writes the tables as CSV files that a loss of power does not take away, except those that
    /// `is_written` names: they have grown with the run.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write_lasting(&self, folder: &Folder, is_written: impl Fn(&str) -> bool) -> Result<()> {
        self.drawings
            .iter()
            .try_for_each(|drawing| folder.write_lasting(&drawing.file, &drawing.svg))?;
        self.tables
            .iter()
            .filter(|table| !is_written(&file_name(table)))
            .try_for_each(|table| {
                folder.write_lasting_table(&file_name(table), &table.header(), table.rows())
            })
    }
}

/// Name of the file of a table.
pub fn file_name(table: &Table) -> String {
    format!("{}.csv", table.name)
}

/// Size of one point of a series (bytes).
pub(super) fn point_bytes<P>(_: &[P]) -> usize {
    size_of::<P>()
}

/// A measure in progress, whatever it measures.
pub(super) trait Measure: Observer + Send {
    fn save(&self) -> Result<Vec<u8>>;
    fn results(&self, context: &Context<'_>) -> Results;
    fn append(&mut self, files: &mut AppendFiles, label: &Label) -> Result<()>;
    fn bytes_per_sample(&self) -> usize;
    fn present(&self) -> Vec<(&'static str, Option<f64>)>;
    fn records_per_block(&self) -> u64;
    /// Number of complete blocks.
    fn blocks(&self) -> usize;
    /// Whether the last record completed a block.
    fn is_whole(&self) -> bool;
    /// Samples without a record of the sums: the interval before may be shorter than the others.
    fn finish(&mut self, view: &View<'_>);
    fn run_sums(&self) -> RunSums;
}

/// An observer with the sums of its blocks.
#[derive(Serialize, Deserialize)]
struct InBlocks<M> {
    measured: M,
    blocks: BlockSums,
    /// The distributions from the start up to the end of each complete block.
    distributions: Blocking<Vec<AdaptiveHistogram>>,
    /// Whether it has received a sample.
    is_sampled: bool,
}

/// Starts a measure.
pub(super) fn in_blocks<M: Measured>(measured: M) -> Box<dyn Measure> {
    let (blocks, distributions) = (BlockSums::default(), Blocking::default());
    Box::new(InBlocks {
        measured,
        blocks,
        distributions,
        is_sampled: false,
    })
}

/// Restores a measure from a checkpoint.
///
/// # Errors
/// The state has another type, or a number in it is not finite.
pub(super) fn resumed<M: Measured>(bytes: &[u8]) -> Result<Box<dyn Measure>> {
    let measure = decode::<InBlocks<M>>(bytes)?;
    require_finite(&measure)?;
    Ok(Box::new(measure))
}

impl<M: Measured> Observer for InBlocks<M> {
    fn watches_any(&self) -> bool {
        self.measured.watches_any()
    }

    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.measured.watches(bodies)
    }

    fn start(&mut self, view: &View<'_>) {
        self.measured.start(view);
    }

    fn pause(&mut self, view: &View<'_>) {
        self.measured.pause(view);
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.measured.collision(report);
    }

    fn sample(&mut self, view: &View<'_>) {
        self.measured.sample(view);
        if self.is_sampled || !M::OF_INTERVALS {
            self.blocks.record(|| self.measured.sums());
            let copies = || {
                self.measured
                    .distributions()
                    .into_iter()
                    .flatten()
                    .cloned()
                    .collect()
            };
            self.distributions
                .record(copies, |earlier, later| *earlier = later);
        }
        self.is_sampled = true;
    }
}

impl<M: Measured> Measure for InBlocks<M> {
    fn save(&self) -> Result<Vec<u8>> {
        Ok(encode(self)?)
    }

    fn results(&self, context: &Context<'_>) -> Results {
        let sums = self.run_sums();
        let context = Context {
            blocks: &sums.blocks,
            ..*context
        };
        self.measured.results(&sums.means(), &context)
    }

    fn append(&mut self, files: &mut AppendFiles, label: &Label) -> Result<()> {
        self.measured.append(files, label)
    }

    fn bytes_per_sample(&self) -> usize {
        self.measured.bytes_per_sample()
    }

    fn present(&self) -> Vec<(&'static str, Option<f64>)> {
        self.measured.present()
    }

    fn records_per_block(&self) -> u64 {
        self.blocks.records_per_block()
    }

    fn blocks(&self) -> usize {
        self.blocks.complete()
    }

    fn is_whole(&self) -> bool {
        self.blocks.is_whole()
    }

    fn finish(&mut self, view: &View<'_>) {
        self.measured.sample(view);
    }

    fn run_sums(&self) -> RunSums {
        let distributions = self.measured.distributions();
        let common = |group: &Vec<&AdaptiveHistogram>| {
            vec![AdaptiveHistogram::common_bins(group); group.len()]
        };
        let bins: Vec<Bins> = distributions.iter().flat_map(common).collect();
        let at_border = |(sums, copies): (&Sums, &Vec<AdaptiveHistogram>)| {
            with_bins(sums.clone(), copies, &bins)
        };
        let borders: Vec<Sums> = self
            .blocks
            .borders()
            .iter()
            .zip(self.distributions.complete())
            .map(at_border)
            .collect();
        let total = with_bins(
            self.measured.sums(),
            distributions.into_iter().flatten(),
            &bins,
        );
        RunSums {
            total,
            blocks: block_sums::differences(&borders),
        }
    }
}

/// Sums followed by those of the bins of each distribution.
fn with_bins<'a>(
    mut sums: Sums,
    distributions: impl IntoIterator<Item = &'a AdaptiveHistogram>,
    bins: &[Bins],
) -> Sums {
    for (distribution, bins) in distributions.into_iter().zip(bins) {
        sums.extend(distribution.sums_in(bins));
    }
    sums
}
