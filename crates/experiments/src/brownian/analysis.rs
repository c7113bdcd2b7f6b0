//! Analysis of the runs of one molecule: tests of equilibrium, charts, and their files.

use anyhow::Result;
use carom::geometry::ExcludedRegion;
use carom_runs::output::Folder;
use carom_tables::Check;

use super::{
    charts::{Charts, DIRECTION_HEADER, direction_rows},
    distributions::{CONTACT_HEADER, Distributions, PROJECTION_HEADER, contact_rows, projection_rows},
    equilibrium::Equilibrium,
    group::Group,
    results::Measurement,
    setting::Setting,
};

/// The runs of one molecule, and what follows from them.
#[derive(Debug)]
pub struct Analysis<'a> {
    /// The runs.
    pub group: Group<'a>,
    /// Tests of equilibrium.
    pub equilibrium: Equilibrium,
    /// Charts of the kicks and of the force.
    pub charts: Charts,
    /// Further charts.
    pub distributions: Distributions,
}

impl<'a> Analysis<'a> {
    /// Analyses the runs of a setting, measured from the time `from`.
    ///
    /// # Errors
    /// There are no runs, or a value in a chart is not finite.
    pub fn of(setting: &'a Setting, runs: &'a [Measurement], from: f64) -> Result<Self> {
        let group = Group::new(setting, runs, from)?;
        let (charts, distributions) = (Charts::draw(&group)?, Distributions::draw(&group)?);
        Ok(Self { equilibrium: Equilibrium::of(&group), group, charts, distributions })
    }

    /// Names of the runs.
    pub fn run_names(&self) -> Vec<String> {
        (0..).take(self.group.runs.len()).map(|replica| self.group.setting.run_name(replica)).collect()
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
        if !self.group.is_mixed() {
            folder.write_table(&name("contact-density"), &CONTACT_HEADER, contact_rows(&self.group))?;
        }
        folder.write_table(&name("exposed-arcs"), &ARC_HEADER, arc_rows(&self.group.prediction.boundary))
    }
}

/// Header of the table of exposed arcs; the names of the atoms are those of their list, from 0.
const ARC_HEADER: [&str; 7] =
    ["atom", "centre_x", "centre_y", "radius", "from_degrees", "to_degrees", "length"];

/// The exposed arcs in the body frame, with directions of the normal.
fn arc_rows(region: &ExcludedRegion) -> impl Iterator<Item = (usize, f64, f64, f64, f64, f64, f64)> {
    region.arcs().iter().map(|arc| {
        let [from, to] = [arc.start, arc.end].map(f64::to_degrees);
        (arc.atom, arc.centre.x, arc.centre.y, arc.radius, from, to, arc.length())
    })
}
