//! Analysis of the runs of one case and size: tests of equilibrium, charts, and their files.

use anyhow::{Context, Result};
use carom_runs::output::Folder;
use carom_tables::Check;

use super::{
    charts::{Charts, DIRECTION_HEADER, direction_rows},
    distributions::{CONTACT_HEADER, Distributions, PROJECTION_HEADER, contact_rows, projection_rows},
    equilibrium::Equilibrium,
    group::Group,
    results::{Measurement, run_name},
};
use crate::experiments::thesis_scene::{Case, Size};

/// The runs of one case and size, and what follows from them.
#[derive(Debug)]
pub struct Analysis<'a> {
    /// The runs.
    pub group: Group<'a>,
    /// Size of the molecule.
    pub size: Size,
    /// Tests of equilibrium.
    pub equilibrium: Equilibrium,
    /// Charts of the kicks and of the force.
    pub charts: Charts,
    /// Further charts.
    pub distributions: Distributions,
}

impl<'a> Analysis<'a> {
    /// Analyses the runs of a case and a size, measured from the time `from`.
    ///
    /// # Errors
    /// There are no runs, or a value in a chart is not finite.
    pub fn of(case: Case, size: Size, runs: &'a [Measurement], from: f64) -> Result<Self> {
        let group = Group::new(case, runs, from).context("the run has no kicks")?;
        let (charts, distributions) = (Charts::draw(&group)?, Distributions::draw(&group)?);
        Ok(Self { equilibrium: Equilibrium::of(&group), group, size, charts, distributions })
    }

    /// Names of the runs.
    pub fn run_names(&self) -> Vec<String> {
        (0..)
            .take(self.group.runs.len())
            .map(|replica| run_name(self.group.case, self.size, replica))
            .collect()
    }

    /// Checks of the runs together.
    pub fn checks(&self) -> Vec<Check> {
        self.group.checks().into_iter().chain(self.equilibrium.checks()).collect()
    }

    /// Writes the charts and their data; all names begin with `prefix`.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(&self, folder: &Folder, prefix: &str) -> Result<()> {
        for (file, picture) in self.charts.files().into_iter().chain(self.distributions.files()) {
            folder.write(&format!("{prefix}{file}"), picture)?;
        }
        let name = |table: &str| format!("{prefix}{table}.csv");
        folder.write_table(&name("directions"), &DIRECTION_HEADER, direction_rows(&self.group))?;
        folder.write_table(&name("kicks-along-axes"), &PROJECTION_HEADER, projection_rows(&self.group))?;
        folder.write_table(&name("contact-density"), &CONTACT_HEADER, contact_rows(&self.group))
    }
}
