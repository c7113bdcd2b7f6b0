//! The hits of the billiard against integral geometry: comparison, checks and figures.

use carom_report::molecule_picture;
use carom_tables::{Check, Figure, chi_square::ChiSquare};

use super::{Hits, Setup};

/// Largest allowed deviation of a mean from its prediction (standard errors): chance exceeds it
/// once in 16 000 runs.
const MOST_ERRORS: f64 = 4.0;

/// Largest allowed −log₁₀ p of a χ²: chance exceeds it once in 10 000 runs.
const MOST_LOG_P: f64 = 4.0;

/// Largest number of atoms with figures of their own; all atoms are in atoms.csv.
const MOST_ATOMS: usize = 16;

/// The mean interval between hits: what it is called, and what predicts it.
struct Interval {
    name: &'static str,
    unit: &'static str,
    prediction: &'static str,
}

impl Interval {
    fn of(setup: &Setup) -> Self {
        let several = setup.obstacles.count > 1;
        let (name, unit, prediction) = match (setup.turns(), several) {
            (false, false) => ("mean free path", "length", "π (L² − A) / P (Santaló 1976)"),
            (false, true) => ("mean free path", "length", "π (box/obstacles − A) / P (Santaló 1976)"),
            (true, false) => ("mean free time", "time", "4 (L² − A) / ∮ √(1 + m (r × n)²/I) ds"),
            (true, true) => ("mean free time", "time", "4 (box/obstacles − A) / ∮ √(1 + m (r × n)²/I) ds"),
        };
        Self { name, unit, prediction }
    }
}

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
    pub fn new(setup: &Setup, hits: &Hits) -> Self {
        let (directions, atoms) = (setup.direction_shares(), setup.atom_shares());
        Self {
            of_directions: ChiSquare::of(&hits.directions, &directions),
            of_atoms: ChiSquare::of(&hits.atoms, &atoms),
            unreachable: setup.region.unreachable().iter().map(|&atom| hits.atoms[atom]).sum(),
            directions,
            atoms,
        }
    }

    pub fn checks(&self, setup: &Setup, hits: &Hits) -> Vec<Check> {
        let (interval, error) = hits.mean_interval();
        let log_p = |of: &ChiSquare| -of.p_value().log10();
        let mut checks = vec![
            Check::at_most(
                &format!("{}, distance from prediction in standard errors", Interval::of(setup).name),
                (interval - setup.mean_interval()).abs() / error,
                MOST_ERRORS,
            ),
            Check::at_most("directions of hits, −log10 p of χ²", log_p(&self.of_directions), MOST_LOG_P),
            Check::at_most("hits by atom, −log10 p of χ²", log_p(&self.of_atoms), MOST_LOG_P),
            Check::at_most("hits on atoms out of reach", self.unreachable as f64, 0.0),
        ];
        checks.extend(hits.totals.checks());
        checks
    }

    pub fn figures(&self, setup: &Setup, hits: &Hits) -> Vec<Figure> {
        let (value, error) = hits.mean_interval();
        let (interval, predicted) = (Interval::of(setup), setup.mean_interval());
        let total = hits.total() as f64;
        let of = &self.of_directions;
        let mut figures = vec![
            Figure::new(interval.name, value, interval.unit)
                .error(error)
                .predicted(predicted, interval.prediction),
            Figure::new(format!("{} over prediction, less 1", interval.name), value / predicted - 1.0, "1")
                .error(error / predicted)
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
