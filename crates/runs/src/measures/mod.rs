//! Measures: observers by name, whose results become tables, charts and figures of the page.
//!
//! A measure is one file with an observer's [`Measured`] and a [`Kind`], and a line in [`KINDS`].
//! Its CSV file, chart with error band and prediction, figures and JSON follow from the tables.

mod contact_density;
mod correlation;
mod delayed;
mod directions;
mod drift;
mod free_path;
mod hard_discs;
mod hexatic_order;
mod orientation;
mod pair_distribution;
mod pressure_tensor;
mod projections;
mod running_average;
mod selection;
mod slope;
mod structure_factor;
mod temperature;
mod thermostat;
mod velocities;
mod viscosity;
mod wall_heat;

use anyhow::{Context as _, Result, bail, ensure};
use carom::{
    CollisionReport, Observer, Scene, View,
    engine::{Body, RunSpec, did_you_mean},
};
use carom_tables::{BlockMean, BlockSums, Figure, Table, Verdict};
use serde::{
    Deserialize, Deserializer, Serialize, Serializer, de::DeserializeOwned, de::Error as _, ser::Error as _,
};

pub use self::delayed::Delayed;
pub use self::hard_discs::{ENSKOG, HardDiscs, LIU};
pub use self::selection::Selection;
use crate::{
    checkpoint_file::{decode, encode},
    output::Folder,
    print_line,
};

/// All measures.
pub const KINDS: [Kind; 17] = [
    velocities::KIND,
    temperature::KIND,
    correlation::KIND,
    orientation::KIND,
    pair_distribution::KIND,
    structure_factor::KIND,
    hexatic_order::KIND,
    pressure_tensor::KIND,
    free_path::KIND,
    viscosity::KIND,
    directions::KIND,
    projections::KIND,
    contact_density::KIND,
    drift::KIND,
    running_average::KIND,
    thermostat::KIND,
    wall_heat::KIND,
];

/// A measure that can be asked for by name.
#[derive(Debug, Clone, Copy)]
pub struct Kind {
    /// Its name in `run.observe`.
    pub name: &'static str,
    /// What it measures, in a sentence.
    pub summary: &'static str,
    /// The bodies that it can be restricted to.
    pub of: Of,
    /// Starts it.
    begin: fn(&Selection<'_>) -> Result<Box<dyn Measure>>,
    /// Restores it from a checkpoint.
    resume: fn(&[u8]) -> Result<Box<dyn Measure>>,
}

/// The bodies of a measure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Of {
    /// All bodies, or those with the tag after the colon; each measure says whether fixed ones
    /// count.
    Group,
    /// The only body with the tag after the colon, which is required.
    OneBody,
    /// The whole system; no tag is allowed.
    System,
}

/// An observer whose results can be tabulated.
pub trait Measured: Observer + Serialize + DeserializeOwned + 'static {
    /// Σx and Σw so far of each quantity whose mean is Σx / Σw; their order never changes. They are
    /// recorded at each sample and give the standard errors.
    fn sums(&self) -> Vec<[f64; 2]> {
        Vec::new()
    }

    /// Tables and figures. `means` belong to [`Self::sums`].
    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results;
}

/// What results depend on besides the observer.
#[derive(Debug, Clone, Copy)]
pub struct Context<'a> {
    /// The tag in the name, with a hyphen before it; empty without a tag.
    pub suffix: &'a str,
    /// Duration of a block (time): means over longer times have no error.
    pub block: f64,
    /// Whether all contacts conserve energy.
    pub is_elastic: bool,
    /// The gas to which theory applies, or why it does not.
    pub hard_discs: &'a Result<HardDiscs, String>,
}

impl Context<'_> {
    /// The name of a figure, with the tag.
    pub fn named(&self, name: &str) -> String {
        self.suffix.strip_prefix('-').map_or_else(|| name.to_owned(), |tag| format!("{name}, {tag}"))
    }

    /// A mean as a figure, with its error and the tag; `None` without a mean.
    pub fn figure(&self, name: &str, unit: &str, mean: &BlockMean) -> Option<Figure> {
        Some(Figure::new(self.named(name), mean.value?, unit).error(mean.standard_error))
    }

    /// Means at these lags (time), without the errors of lags as long as a block: such a block
    /// holds pairs whose first sample lies before it.
    pub fn resolved(&self, means: &[BlockMean], lags: &[f64]) -> Vec<BlockMean> {
        let of = |(mean, &lag): (&BlockMean, &f64)| BlockMean {
            standard_error: mean.standard_error.filter(|_| lag < self.block),
            ..*mean
        };
        means.iter().zip(lags).map(of).collect()
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
}

/// A measure in progress.
trait Measure: Observer {
    fn save(&self) -> Result<Vec<u8>>;
    fn results(&self, context: &Context<'_>) -> Results;
    fn records_per_block(&self) -> u64;
}

/// An observer with the sums of its blocks.
#[derive(Serialize, Deserialize)]
struct InBlocks<M> {
    measured: M,
    blocks: BlockSums,
}

fn in_blocks<M: Measured>(measured: M) -> Box<dyn Measure> {
    Box::new(InBlocks { measured, blocks: BlockSums::default() })
}

fn resumed<M: Measured>(bytes: &[u8]) -> Result<Box<dyn Measure>> {
    Ok(Box::new(decode::<InBlocks<M>>(bytes)?))
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

    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.measured.collision(report);
    }

    fn sample(&mut self, view: &View<'_>) {
        self.measured.sample(view);
        self.blocks.record(&self.measured.sums());
    }
}

impl<M: Measured> Measure for InBlocks<M> {
    fn save(&self) -> Result<Vec<u8>> {
        Ok(encode(self)?)
    }

    fn results(&self, context: &Context<'_>) -> Results {
        self.measured.results(&self.blocks.means(), context)
    }

    fn records_per_block(&self) -> u64 {
        self.blocks.records_per_block()
    }
}

/// The measures of a run, in the order of their names in the scene.
#[derive(Default)]
pub struct Measures(Vec<(String, Box<dyn Measure>)>);

impl Measures {
    /// Starts the measures that a run asks for; other names are skipped.
    ///
    /// # Errors
    /// No body carries a tag, or a body is not unique.
    pub fn begin(run: &RunSpec, view: &View<'_>) -> Result<Self> {
        let mut list = Vec::new();
        for name in &run.observe {
            let Some((kind, tag)) = find(name) else { continue };
            let selection = Selection::new(name, tag, run, view)?;
            let measure = (kind.begin)(&selection).with_context(|| format!("run.observe: '{name}'"))?;
            list.push((name.clone(), measure));
        }
        Ok(Self(list))
    }

    /// Tables and figures of all measures.
    pub fn results(&self, scene: &Scene, hard_discs: &Result<HardDiscs, String>) -> Results {
        let rules = scene.elasticity.pair.iter().map(|rule| rule.coefficient);
        let is_elastic = rules.chain([scene.elasticity.default]).all(|coefficient| coefficient == 1.0);
        let mut all = Results::default();
        for (name, measure) in &self.0 {
            let suffix = name.split_once(':').map_or(String::new(), |(_, tag)| format!("-{tag}"));
            let block = measure.records_per_block() as f64 * scene.run.sample_interval;
            let results = measure.results(&Context { suffix: &suffix, block, is_elastic, hard_discs });
            all.tables.extend(results.tables);
            all.figures.extend(results.figures);
        }
        all
    }
}

impl Results {
    /// Writes the tables as CSV files.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(&self, folder: &Folder) -> Result<()> {
        self.tables
            .iter()
            .try_for_each(|table| folder.write_table(&file_name(table), &table.header(), table.rows()))
    }
}

/// Name of the file of a table.
pub fn file_name(table: &Table) -> String {
    format!("{}.csv", table.name)
}

/// The names of all series and measures, without tags.
pub fn names() -> impl Iterator<Item = &'static str> {
    let series = SERIES.iter().map(|(name, _)| name.split(':').next().unwrap_or(name));
    series.chain(KINDS.iter().map(|kind| kind.name))
}

/// Prints all names that `run.observe` accepts, with what they measure.
pub fn list() -> Verdict {
    for (name, summary) in SERIES {
        print_line(&format!("{name:<24}{summary}"));
    }
    for kind in KINDS {
        let tag = match kind.of {
            Of::Group => "[:TAG]",
            Of::OneBody => ":TAG",
            Of::System => "",
        };
        print_line(&format!("{:<24}{}", format!("{}{tag}", kind.name), kind.summary));
    }
    Verdict::Passed
}

/// The series that every run can record, besides the measures.
pub const SERIES: [(&str, &str); 5] = [
    ("energy", "energy, ledger and momentum at each sample"),
    ("collision-rate", "collisions per body in each interval between samples"),
    ("pressure", "pressure from the virial of the contacts in each interval"),
    ("overlap", "overlapping pairs at each sample; always checked"),
    ("impulses:TAG", "every impulse on the only body with the tag, as a table"),
];

/// The kind of measure that a name asks for, and its tag.
fn find(name: &str) -> Option<(&'static Kind, Option<&str>)> {
    let (kind, tag) = name.split_once(':').map_or((name, None), |(kind, tag)| (kind, Some(tag)));
    KINDS.iter().find(|known| known.name == kind).map(|kind| (kind, tag))
}

/// Validates a name and its tag.
///
/// # Errors
/// The name is unknown, a required tag is missing, or the tag is not allowed.
pub fn check(name: &str) -> Result<()> {
    let Some((kind, tag)) = find(name) else {
        let word = name.split(':').next().unwrap_or(name);
        bail!("unknown observer '{name}'{}", did_you_mean(word, names()))
    };
    check_tag(name, kind.of, tag)
}

/// Validates the tag of a name.
pub(crate) fn check_tag(name: &str, of: Of, tag: Option<&str>) -> Result<()> {
    match (of, tag) {
        (Of::OneBody, None) => bail!("'{name}' needs the tag of a body: {name}:TAG"),
        (Of::System, Some(_)) => bail!("'{name}': it covers the whole system and takes no tag"),
        // The tag becomes part of a file name.
        (_, Some(tag)) => ensure!(
            !tag.is_empty() && tag.chars().all(|c| c.is_alphanumeric() || "-_".contains(c)),
            "'{name}': the tag may contain letters, digits, - and _ only"
        ),
        _ => {}
    }
    Ok(())
}

impl Observer for Measures {
    fn watches_any(&self) -> bool {
        self.0.iter().any(|(_, measure)| measure.watches_any())
    }

    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.0.iter().any(|(_, measure)| measure.watches(bodies))
    }

    fn start(&mut self, view: &View<'_>) {
        self.0.iter_mut().for_each(|(_, measure)| measure.start(view));
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        let bodies = report.sides.each_ref().map(|side| side.body);
        let watching = self.0.iter_mut().filter(|(_, measure)| measure.watches(bodies));
        watching.for_each(|(_, measure)| measure.collision(report));
    }

    fn sample(&mut self, view: &View<'_>) {
        self.0.iter_mut().for_each(|(_, measure)| measure.sample(view));
    }
}

/// In a checkpoint each measure is its name and its encoded state.
impl Serialize for Measures {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let encoded = self.0.iter().map(|(name, measure)| Ok((name, measure.save()?)));
        let encoded: Vec<(&String, Vec<u8>)> = encoded.collect::<Result<_>>().map_err(S::Error::custom)?;
        encoded.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Measures {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let encoded = Vec::<(String, Vec<u8>)>::deserialize(deserializer)?;
        let restored = encoded.into_iter().map(|(name, bytes)| {
            let Some((kind, _)) = find(&name) else { bail!("the measure '{name}' is unknown") };
            let measure = (kind.resume)(&bytes)?;
            Ok((name, measure))
        });
        restored.collect::<Result<_>>().map(Self).map_err(D::Error::custom)
    }
}

#[cfg(test)]
mod tests;
