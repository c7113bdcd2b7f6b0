//! Execution of the experiment: flights, comparison with the prediction, and output files.

use anyhow::Result;
use carom_report::molecule_picture;
use carom_runs::{
    experiment::{Experiment, Opening, threads},
    say,
};
use carom_tables::{Check, Figure, Summary, Verdict, chi_square::ChiSquare};

use super::{
    Options, Setup,
    flights::{Hits, SECTORS, fly},
    report,
};

/// Largest allowed deviation of a mean from its prediction (standard errors): chance exceeds it
/// once in 16 000 runs.
const MOST_ERRORS: f64 = 4.0;

/// Largest allowed −log₁₀ p of a χ²: chance exceeds it once in 10 000 runs.
const MOST_LOG_P: f64 = 4.0;

/// Largest number of atoms with figures of their own; all atoms are in atoms.csv.
const MOST_ATOMS: usize = 16;

/// Hits compared with the prediction.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// Predicted share of each sector of directions.
    pub directions: Vec<f64>,
    /// Predicted share of each atom.
    pub atoms: Vec<f64>,
    /// χ² of the directions.
    pub of_directions: ChiSquare,
    /// χ² of the reachable atoms.
    pub of_atoms: ChiSquare,
    /// Hits on unreachable atoms.
    pub unreachable: u64,
}

impl Comparison {
    fn new(setup: &Setup, hits: &Hits) -> Self {
        let (directions, atoms) = (setup.region.direction_shares(SECTORS), setup.region.atom_shares());
        Self {
            of_directions: ChiSquare::of(&hits.directions, &directions),
            of_atoms: ChiSquare::of(&hits.atoms, &atoms),
            unreachable: setup.region.unreachable().iter().map(|&atom| hits.atoms[atom]).sum(),
            directions,
            atoms,
        }
    }

    fn checks(&self, setup: &Setup, hits: &Hits) -> Vec<Check> {
        let (path, error) = hits.mean_free_path();
        let log_p = |of: &ChiSquare| -of.p_value().log10();
        let mut checks = vec![
            Check::at_most(
                "mean free path, distance from prediction in standard errors",
                (path - setup.mean_free_path()).abs() / error,
                MOST_ERRORS,
            ),
            Check::at_most("directions of hits, −log10 p of χ²", log_p(&self.of_directions), MOST_LOG_P),
            Check::at_most("hits by atom, −log10 p of χ²", log_p(&self.of_atoms), MOST_LOG_P),
            Check::at_most("hits on atoms out of reach", self.unreachable as f64, 0.0),
        ];
        checks.extend(hits.totals.checks());
        checks
    }

    fn figures(&self, setup: &Setup, hits: &Hits) -> Vec<Figure> {
        let (path, error) = hits.mean_free_path();
        let total = hits.total() as f64;
        let of = &self.of_directions;
        let mut figures = vec![
            Figure::new("mean free path", path, "length")
                .error(error)
                .predicted(setup.mean_free_path(), "π (L² − A) / P (Santaló 1976)"),
            Figure::new("mean free path over prediction, less 1", path / setup.mean_free_path() - 1.0, "1")
                .error(error / setup.mean_free_path())
                .predicted(0.0, "integral geometry"),
            Figure::new("χ² of directions per degree of freedom", of.value / of.freedom.max(1) as f64, "1")
                .error((2.0 / of.freedom.max(1) as f64).sqrt())
                .predicted(1.0, "independent hits"),
            Figure::new("p-value of χ² of directions", of.p_value(), "1"),
            Figure::new("p-value of χ² of atoms", self.of_atoms.p_value(), "1"),
            Figure::new("perimeter of the excluded region", setup.region.perimeter(), "length"),
            Figure::new("area of the excluded region", setup.region.area(), "length²"),
        ];
        let shares = self.atoms.iter().zip(&hits.atoms).enumerate().take(MOST_ATOMS);
        figures.extend(shares.map(|(atom, (&predicted, &count))| {
            let share = count as f64 / total;
            Figure::new(format!("share of atom {}", molecule_picture::name(atom)), share, "1")
                .error((share * (1.0 - share) / total).sqrt())
                .predicted(predicted, "exposed arcs")
        }));
        figures
    }
}

/// Runs the experiment and writes its folder.
///
/// # Errors
/// An option is invalid, the folder is not empty, or a run fails.
pub fn run(options: &Options) -> Result<Verdict> {
    let setup = options.setup()?;
    let command = options.command(&setup);
    let scenes = (0..setup.flights()).map(|replica| setup.scene(replica)).collect::<Result<Vec<_>>>()?;
    let head = format!("# Written by `{command}`: the first of {} flights.\n\n", scenes.len());
    let experiment = Experiment::begin_in_pieces(
        &options.resumption,
        options.what(&setup),
        &Opening {
            folder: &options.usual_folder(),
            note: &options.note(),
            command: &command,
            configuration: head + &scenes[0].to_toml(),
            scenes: &scenes.iter().collect::<Vec<_>>(),
        },
    )?;
    let folder = &experiment.folder;
    let hits = threads(options.threads)?.install(|| fly(&setup, &experiment.pieces))?;
    let comparison = Comparison::new(&setup, &hits);
    let summary = Summary {
        title: format!("Billiard around a fixed {}", setup.shape),
        note: options.note(),
        totals: hits.totals,
        checks: comparison.checks(&setup, &hits),
        figures: comparison.figures(&setup, &hits),
        runs: Vec::new(),
    };
    report::write(folder, &setup, &hits, &comparison, &summary, &command)?;
    folder.write_json("summary.json", &summary)?;
    for figure in &summary.figures[..4] {
        say(&format!(
            "{}: {}",
            figure.name,
            carom_report::page::with_error(figure.value, figure.standard_error)
        ));
    }
    carom_runs::conclude(&experiment.complete_after(summary.totals.cpu_seconds())?, &summary);
    Ok(summary.verdict())
}
