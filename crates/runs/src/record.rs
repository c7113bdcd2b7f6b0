//! The file `sums` of a run folder: what the runs of several replicas are merged from.

use std::{collections::BTreeMap, path::Path};

use anyhow::{Context, Result, bail, ensure};
use carom::Scene;
use carom_tables::{Column, Figure, Replica, Role, RunSums, Table, Totals};
use serde::{Deserialize, Serialize};

use crate::{
    checkpoint_file::{self, CheckpointBody},
    curves::Coefficient,
    finite::require_finite,
    other_run::refuse_other,
    output::Folder,
};

pub use crate::file_names::SUMS;

/// A picture that explains what a measure has measured.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Drawing {
    /// Name of its file.
    pub file: String,
    /// What the reader must know.
    pub caption: String,
    /// The picture.
    pub svg: String,
}

/// Runs of one scene that differ in their random numbers. Parts are merged by the keys of their
/// runs, so that no order of merging changes a digit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// The scene without seed and replica.
    pub what: String,
    /// The runs by seed and number of the replica.
    pub runs: BTreeMap<Replica, RunRecord>,
}

/// What is kept of one run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunRecord {
    /// Totals of the run, without its speed.
    pub totals: Totals,
    /// First note to the reader.
    pub note: String,
    /// Figures of the whole system, such as the temperature at the end.
    pub figures: Vec<Figure>,
    /// The measures, in the order of the run.
    pub measures: Vec<MeasureRecord>,
}

/// What is kept of one measure of one run.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct MeasureRecord {
    /// Begin and end of the blocks (time).
    pub span: [f64; 2],
    /// Sums over the run and over its blocks.
    pub sums: RunSums,
    /// Its tables.
    pub tables: Vec<Table>,
    /// Its figures, with the number of their sums.
    pub figures: Vec<(Figure, Option<usize>)>,
    /// Coefficients of its curves, and their figures in this run alone.
    pub(crate) coefficients: Vec<Coefficient>,
    pub(crate) of_curves: Vec<Figure>,
    /// Its drawings.
    pub drawings: Vec<Drawing>,
}

/// The scene as text with all options, without what distinguishes its replicas.
pub fn description(scene: &Scene) -> String {
    let mut any = scene.clone();
    (any.bounds.seed, any.bounds.replica) = (0, 0);
    // The animation changes no result.
    (any.run.animation, any.run.animation_from) = (true, 0.0);
    any.to_toml()
}

impl Record {
    /// The record of one run. Figures and predictions that are not finite, such as a mean of
    /// nothing, are left out.
    pub fn new(scene: &Scene, mut run: RunRecord) -> Self {
        run.leave_out_undefined();
        let replica = Replica {
            seed: scene.bounds.seed,
            number: scene.bounds.replica,
        };
        Self {
            what: description(scene),
            runs: BTreeMap::from([(replica, run)]),
        }
    }

    /// Adds the runs of another part of the same scene.
    ///
    /// # Errors
    /// The scenes differ, or a run is in both parts.
    pub fn merge(&mut self, other: Self) -> Result<()> {
        refuse_other(&self.what, &other.what)?;
        if let Some(Replica { seed, number }) =
            other.runs.keys().find(|key| self.runs.contains_key(key))
        {
            bail!("the run with seed {seed} and replica {number} is there twice");
        }
        self.runs.extend(other.runs);
        Ok(())
    }

    /// Writes the file.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(&self, folder: &Folder) -> Result<()> {
        checkpoint_file::write(&folder.file(SUMS)?, &[&checkpoint_file::encode(self)?])
    }

    /// Reads the file of a run folder.
    ///
    /// # Errors
    /// It cannot be read, another version of the program wrote it, or its numbers are invalid.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(SUMS);
        let read = || Self::take(&mut CheckpointBody::read(&path)?);
        read().with_context(|| format!("cannot merge {}", path.display()))
    }

    /// Decodes and verifies the next value of a file. All records pass through here when they are
    /// read.
    ///
    /// # Errors
    /// The value is no record, a number in it is not finite, a count is negative, or lengths
    /// differ.
    pub fn take(body: &mut CheckpointBody) -> Result<Self> {
        let record: Self = body.take()?;
        record.check()?;
        Ok(record)
    }

    /// Verifies what the encoding does not: sums are added without a further look.
    fn check(&self) -> Result<()> {
        require_finite(self)?;
        let first = self
            .runs
            .values()
            .next()
            .map_or(0, |run| run.measures.len());
        for (Replica { seed, number }, run) in &self.runs {
            let name = || format!("the run with seed {seed} and replica {number}");
            ensure!(
                run.measures.len() == first,
                "{} has {} measures, but the first has {first}",
                name(),
                run.measures.len()
            );
            ensure!(
                run.totals.simulated_time >= 0.0,
                "simulated_time must be at least 0, but is {}, in {}",
                run.totals.simulated_time,
                name()
            );
            for measure in &run.measures {
                measure.check().with_context(name)?;
            }
        }
        Ok(())
    }
}

impl RunRecord {
    /// Removes what is not finite: it says nothing, and makes every mean over runs undefined.
    fn leave_out_undefined(&mut self) {
        let keep = |figure: &mut Figure| {
            figure.standard_error = figure.standard_error.filter(|error| error.is_finite());
            figure.prediction = figure
                .prediction
                .filter(|prediction| prediction.is_finite());
            figure.smallest_difference =
                figure.smallest_difference.filter(|least| least.is_finite());
            figure.value.is_finite()
        };
        self.figures.retain_mut(keep);
        for measure in &mut self.measures {
            measure.figures.retain_mut(|(figure, _)| keep(figure));
            for table in &mut measure.tables {
                table.levels.retain(|level| level.value.is_finite());
                let cells = table
                    .columns
                    .iter_mut()
                    .flat_map(|column| &mut column.values);
                cells.for_each(|cell| *cell = cell.filter(|value| value.is_finite()));
            }
        }
    }
}

impl MeasureRecord {
    /// All its figures: those of curves, then those of sums.
    pub fn all_figures(&self) -> impl Iterator<Item = &Figure> {
        let of_sums = self.figures.iter().map(|(figure, _)| figure);
        self.of_curves.iter().chain(of_sums)
    }

    /// Verifies that weights and counts are not negative, and that numbers of quantities are those
    /// of sums.
    fn check(&self) -> Result<()> {
        self.sums.check()?;
        let quantities = self.sums.total.len();
        let is_known = |quantity: &Option<usize>| quantity.is_none_or(|index| index < quantities);
        for (figure, quantity) in &self.figures {
            ensure!(
                is_known(quantity),
                "the figure '{}' has no sums",
                figure.name
            );
        }
        for table in &self.tables {
            let check = |column: &Column| {
                let (values, numbers) = (column.values.len(), column.quantities.len());
                ensure!(
                    numbers == 0 || numbers == values,
                    "{} has {values} rows and sums for {numbers}",
                    column.name
                );
                ensure!(
                    column.quantities.iter().all(is_known),
                    "{} has no sums",
                    column.name
                );
                let least = column.values.iter().flatten().copied().fold(0.0, f64::min);
                ensure!(
                    column.role != Role::Count || least >= 0.0,
                    "the count {} must be at least 0, but is {least}",
                    column.name
                );
                Ok(())
            };
            table
                .columns
                .iter()
                .try_for_each(check)
                .with_context(|| format!("table '{}'", table.name))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        checkpoint_file::encode,
        interruption::Signals,
        output::Existing,
        run::{outcome::in_memory, replica},
    };
    use carom_methods::Method;

    fn scene() -> Scene {
        Scene::from_toml(
            "[[gas]]\nradius = 0.04\nmass = 1.0\nenergy = 1.0\ncount = 12\n[run]\nuntil = 0.5\n\
             sample_interval = 0.05\nobserve = [\"pressure\", \"velocities\", \"correlation\"]\n",
        )
        .unwrap()
    }

    /// The refusal of a record after a change, which its checksum includes.
    fn refused(record: &Record, spoil: impl FnOnce(&mut RunRecord)) -> String {
        let mut forged = record.clone();
        spoil(forged.runs.values_mut().next().unwrap());
        let root = tempfile::tempdir().unwrap();
        let folder = Folder::create(root.path(), Existing::Refuse).unwrap();
        forged.write(&folder).unwrap();
        match Record::read(root.path()) {
            Err(error) => format!("{error:#}"),
            Ok(_) => "accepted".to_owned(),
        }
    }

    #[test]
    fn forged_numbers_with_a_right_checksum_are_refused_by_name() {
        replica::check(&scene()).unwrap();
        let outcome = in_memory(&scene(), &Signals::default()).unwrap();
        let record = outcome.record(&scene(), &Method::default());
        assert_eq!(refused(&record, |_| ()), "accepted");
        let measure = |run: &RunRecord| {
            let has_sums = |measure: &MeasureRecord| {
                measure.sums.blocks.len() > 1 && !measure.sums.total.is_empty()
            };
            run.measures
                .iter()
                .position(has_sums)
                .expect("sums of blocks")
        };
        let table = |run: &RunRecord| {
            let is_long = |table: &Table| {
                table
                    .columns
                    .iter()
                    .any(|column| column.role == Role::Count)
            };
            let place = |(index, measure): (usize, &MeasureRecord)| {
                measure
                    .tables
                    .iter()
                    .position(is_long)
                    .map(|table| (index, table))
            };
            run.measures
                .iter()
                .enumerate()
                .find_map(place)
                .expect("a table with counts")
        };
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let error = refused(&record, |run| run.totals.energy_drift = value);
            assert!(
                error.contains("totals.energy_drift must be finite, but is"),
                "{error}"
            );
            let error = refused(&record, |run| {
                let index = measure(run);
                run.measures[index].sums.total[0][0] = value;
            });
            assert!(
                error.contains(".sums.total[0][0] must be finite"),
                "{error}"
            );
            let error = refused(&record, |run| {
                let index = measure(run);
                run.measures[index].sums.blocks[1][0][1] = value;
            });
            assert!(
                error.contains(".sums.blocks[1][0][1] must be finite"),
                "{error}"
            );
            let error = refused(&record, |run| {
                let (measure, table) = table(run);
                run.measures[measure].tables[table].columns[0].values[0] = Some(value);
            });
            assert!(
                error.contains(".columns[0].values[0] must be finite"),
                "{error}"
            );
        }
        let error = refused(&record, |run| {
            let index = measure(run);
            run.measures[index].sums.total[0][1] = -1.0;
        });
        assert!(error.contains("weight") && error.contains("-1"), "{error}");
        let error = refused(&record, |run| {
            let index = measure(run);
            run.measures[index].sums.blocks[0].push([0.0; 2]);
        });
        assert!(error.contains("block 1 has"), "{error}");
        let error = refused(&record, |run| {
            let (measure, table) = table(run);
            let columns = &mut run.measures[measure].tables[table].columns;
            columns
                .iter_mut()
                .find(|column| column.role == Role::Count)
                .unwrap()
                .values[0] = Some(-3.0);
        });
        assert!(error.contains("must be at least 0, but is -3"), "{error}");
        let error = refused(&record, |run| run.totals.simulated_time = -1.0);
        assert!(
            error.contains("simulated_time must be at least 0, but is -1"),
            "{error}"
        );
    }

    #[test]
    fn figures_that_are_not_finite_are_not_recorded() {
        let outcome = in_memory(&scene(), &Signals::default()).unwrap();
        let record = outcome.record(&scene(), &Method::default());
        let mut run = record.runs.values().next().unwrap().clone();
        let before = run.figures.len();
        run.figures
            .push(Figure::new("a mean of nothing", f64::NAN, "1"));
        let again = Record::new(&scene(), run);
        assert_eq!(again.runs.values().next().unwrap().figures.len(), before);
        assert_eq!(encode(&again).unwrap(), encode(&record).unwrap());
    }
}
