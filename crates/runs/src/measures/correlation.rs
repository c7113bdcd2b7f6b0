//! `correlation`: mean squared displacement and velocity autocorrelation of a group.

use carom::TimeCorrelation;
use carom_tables::{BlockMean, Table};

use crate::curves::{Coefficient, MIN_PAIRS, Reading};

use super::{
    Context, HardDiscs, MAX_LAG, MeasureKind, Measured, Of, Results, Span, hard_discs::SONINE,
    in_blocks, resumed,
};

/// The autocorrelation is compared with its exponential up to this many mean free times; later the
/// tail that falls as 1/t (Alder and Wainwright, Phys. Rev. A 1 (1970) 18) dominates.
const FREE_TIMES: f64 = 5.0;

/// The diffusion coefficient of theory is the slope of the mean squared displacement between these
/// lags (mean free times). It grows slowly with them.
const BETWEEN: [f64; 2] = [10.0, 40.0];

/// Source of the fourth moment: at short lags the displacements are not Gaussian.
const DIFFUSION: &str = "approximation, long lags: diffusion equation";

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "correlation",
    summary: "mean squared displacement and velocity autocorrelation against the lag",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[MAX_LAG],
    figures: &[
        "diffusion coefficient at long lags, … to …",
        "apparent diffusion coefficient at long lags, … to …, no plateau",
        "diffusion coefficient from velocities, up to lag …",
        "apparent diffusion coefficient, from lags … to …",
    ],
    start: |selection| {
        let (interval, longest) = (selection.interval(), selection.longest_lag());
        Ok(in_blocks(TimeCorrelation::new(
            selection.group,
            interval,
            longest,
        )?))
    },
    resume: resumed::<TimeCorrelation>,
};

impl Measured for TimeCorrelation {
    /// The squared displacement at each lag, then the product of velocities, then the fourth power
    /// of the displacement.
    fn sums(&self) -> Vec<[f64; 2]> {
        self.sums()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let points: Vec<_> = self
            .points()
            .into_iter()
            .filter(|point| point.pairs >= MIN_PAIRS)
            .collect();
        let lags: Vec<f64> = points.iter().map(|point| point.lag).collect();
        let all = self.lags().len();
        let [squares, products, fourths] =
            [0, 1, 2].map(|index| context.at_lags(means, index, all, &lags));
        let exponential: Vec<Option<f64>> =
            lags.iter().map(|&lag| exponential(lag, context)).collect();
        let gaussian = squares
            .iter()
            .map(|mean| mean.value.map(|square| 2.0 * square * square))
            .collect();
        let table = Table::new(
            context.table("correlation"),
            "Mean squared displacement and velocity autocorrelation",
        )
        .abscissa("lag", "time", lags.clone())
        .counts("pairs", points.iter().map(|point| point.pairs).collect())
        .means("mean_square_displacement", "length²", &squares)
        .means("velocity_autocorrelation", "length²/time²", &products)
        .prediction("2kT/m exp(−Γt)", exponential, SONINE)
        .means("mean_fourth_displacement", "length⁴", &fourths)
        .prediction("2 ⟨|Δr|²⟩², Gaussian", gaussian, DIFFUSION)
        .logarithmic()
        .in_decades(&["mean_square_displacement", "mean_fourth_displacement"])
        .relative_to_first(&["velocity_autocorrelation"])
        .guide("mean_square_displacement", 2.0, "∝ t²", false)
        .guide("mean_square_displacement", 1.0, "∝ t", true)
        .caption(context.theory(
            "The slope of the autocorrelation at lag 0 is exactly minus its value times the collision rate Γ.",
        ));
        Results {
            tables: vec![table],
            coefficients: coefficients(&self.lags(), context),
            ..Results::default()
        }
    }
}

/// The diffusion coefficients: from the mean squared displacement at the lags of theory, and at
/// long lags, where it grows in proportion to the lag (in two dimensions it grows slowly with the
/// lag and with the box), and as half the integral of the velocity autocorrelation. `lags` are all
/// lags.
fn coefficients(lags: &[f64], context: &Context<'_>) -> Vec<Coefficient> {
    let unit = "length²/time";
    let velocities = lags.len();
    let of = |name, reading, curve| {
        Coefficient::new((name, unit), reading, curve, lags, context.of_curves())
    };
    let theory = context.gas().map(HardDiscs::diffusion);
    let of_theory = context.gas().map(|gas| {
        let between = BETWEEN.map(|times| times / gas.collision_rate());
        let reading = (Reading::SlopeBetween(between), 0.25);
        of("apparent diffusion coefficient", reading, 0)
    });
    let plateau = (Reading::Plateau { memory: velocities }, 0.25);
    let integral = (Reading::Integral, 0.5);
    let from_velocities = "diffusion coefficient from velocities";
    [
        of("diffusion coefficient", plateau, 0),
        of(from_velocities, integral, velocities),
    ]
    .into_iter()
    .chain(of_theory)
    .map(|coefficient| coefficient.predicted(theory, SONINE))
    .collect()
}

/// The autocorrelation of Enskog's theory at short lags.
fn exponential(lag: f64, context: &Context<'_>) -> Option<f64> {
    let gas = context.gas()?;
    let rate = gas.collision_rate();
    let count = gas.count as f64;
    // ⟨v²⟩ relative to the centre of mass.
    let square = 2.0 * gas.temperature / gas.mass * (1.0 - 1.0 / count);
    (lag * rate < FREE_TIMES).then(|| square * (-rate * lag).exp())
}
