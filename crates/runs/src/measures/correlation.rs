//! `correlation`: mean squared displacement and velocity autocorrelation of a group.

use carom::TimeCorrelation;
use carom_tables::{BlockMean, Figure, Table, significant};

use super::{
    Context, MAX_LAG, MeasureKind, Measured, Of, Results, Span,
    hard_discs::SONINE,
    in_blocks, resumed,
    transport::{MIN_PAIRS, Plateau, Taken, TransportCurve, TransportValue},
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
        "diffusion coefficient, from lags … to …",
        "diffusion coefficient at long lags, … to …",
        "apparent diffusion coefficient at long lags, … to …, no plateau",
        "diffusion coefficient from velocities, up to lag …",
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
        let figures = coefficients(&lags, &squares, &products, context);
        Results {
            tables: vec![table],
            is_too_short: figures.is_empty(),
            figures,
            ..Results::default()
        }
    }
}

/// The diffusion coefficients from the mean squared displacement, and from the velocity
/// autocorrelation.
fn coefficients(
    lags: &[f64],
    squares: &[BlockMean],
    products: &[BlockMean],
    context: &Context<'_>,
) -> Vec<Figure> {
    let curve = |means| TransportCurve {
        lags,
        means,
        blocks: context.blocks,
        block: context.block,
        of: Taken::Itself,
    };
    let plateau = curve(squares)
        .plateau(products)
        .map(|plateau| at_long_lags(&plateau, context));
    let integral = curve(products)
        .integral()
        .map(|integral| of_velocities(integral, context));
    diffusion(&curve(squares), context)
        .into_iter()
        .chain(plateau)
        .chain(integral)
        .collect()
}

/// The diffusion coefficient from the mean squared displacement at long lags, where it grows in
/// proportion to the lag; in two dimensions it grows slowly with the lag and with the box.
fn at_long_lags(plateau: &Plateau, context: &Context<'_>) -> Figure {
    let TransportValue {
        value,
        standard_error,
    } = plateau.slope;
    let name = plateau.named("diffusion coefficient");
    Figure::new(context.named(&name), 0.25 * value, "length²/time").error(0.25 * standard_error)
}

/// The diffusion coefficient as half the integral of the velocity autocorrelation.
fn of_velocities((integral, until): (TransportValue, f64), context: &Context<'_>) -> Figure {
    let name = context.named(&format!(
        "diffusion coefficient from velocities, up to lag {}",
        significant(until, 3)
    ));
    Figure::new(name, 0.5 * integral.value, "length²/time").error(0.5 * integral.standard_error)
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

/// The diffusion coefficient from the slope of the mean squared displacement.
fn diffusion(squares: &TransportCurve<'_>, context: &Context<'_>) -> Option<Figure> {
    let gas = context.gas()?;
    let slope = squares.slope_between(BETWEEN.map(|times| times / gas.collision_rate()))?;
    let name = context.named(&slope.named("diffusion coefficient"));
    Some(
        Figure::new(name, 0.25 * slope.value, "length²/time")
            .error(slope.standard_error.map(|error| 0.25 * error))
            .predicted(gas.diffusion(), SONINE),
    )
}
