//! `correlation`: mean squared displacement and velocity autocorrelation of a group.

use carom::TimeCorrelation;
use carom_tables::{BlockMean, Table};

use crate::curves::{Coefficient, MIN_PAIRS, Reading};

use super::{
    Context, Default, HardDiscs, MAX_LAG, MeasureKind, Measured, Of, Parameter, Results, Span,
    hard_discs::SONINE, in_blocks, resumed,
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
    summary: "mean squared displacement and velocity autocorrelation against the lag, under shear relative to the flow",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[
        MAX_LAG,
        Parameter::word(
            "axis",
            &["x", "y"],
            Default::FromScene("both"),
            "axis along which displacements and velocities count",
        ),
    ],
    figures: &[
        "diffusion coefficient at long lags, … to …",
        "apparent diffusion coefficient at long lags, … to …, no plateau",
        "diffusion coefficient from velocities, up to lag …",
        "apparent diffusion coefficient, from lags … to …",
        "diffusion coefficient along x at long lags, … to …",
        "apparent diffusion coefficient along x at long lags, … to …, no plateau",
        "diffusion coefficient along x from velocities, up to lag …",
        "apparent diffusion coefficient along x, from lags … to …",
        "diffusion coefficient along y at long lags, … to …",
        "apparent diffusion coefficient along y at long lags, … to …, no plateau",
        "diffusion coefficient along y from velocities, up to lag …",
        "apparent diffusion coefficient along y, from lags … to …",
    ],
    start: |selection| {
        let (interval, longest) = (selection.interval(), selection.longest_lag());
        let both = TimeCorrelation::new(selection.group, interval, longest)?;
        Ok(in_blocks(match selection.given_word("axis") {
            Some("x") => both.along(0),
            Some(_) => both.along(1),
            None => both,
        }))
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
        let counted = Counted::new(self.axis());
        let exponential: Vec<Option<f64>> = lags
            .iter()
            .map(|&lag| counted.exponential(lag, context))
            .collect();
        // ⟨Δ⁴⟩ / ⟨Δ²⟩² of a Gaussian is 3 in one dimension and 2 in two.
        let ratio = 1.0 + 2.0 / counted.components;
        let gaussian = squares
            .iter()
            .map(|mean| mean.value.map(|square| ratio * square * square))
            .collect();
        let [law, of_fourths] = if counted.components == 1.0 {
            ["kT/m exp(−Γt)", "3 ⟨Δ²⟩², Gaussian"]
        } else {
            ["2kT/m exp(−Γt)", "2 ⟨|Δr|²⟩², Gaussian"]
        };
        let table = Table::new(
            context.table("correlation"),
            format!(
                "Mean squared displacement and velocity autocorrelation{}",
                counted.along
            ),
        )
        .abscissa("lag", "time", lags.clone())
        .counts("pairs", points.iter().map(|point| point.pairs).collect())
        .means("mean_square_displacement", "length²", &squares)
        .means("velocity_autocorrelation", "length²/time²", &products)
        .prediction(law, exponential, SONINE)
        .means("mean_fourth_displacement", "length⁴", &fourths)
        .prediction(of_fourths, gaussian, DIFFUSION)
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
            coefficients: counted.coefficients(&self.lags(), context),
            ..Results::default()
        }
    }
}

/// The components that count.
#[derive(Debug, Clone, Copy)]
struct Counted {
    /// Their number, 1 or 2.
    components: f64,
    /// What the names of tables and figures have after the quantity.
    along: &'static str,
}

impl Counted {
    /// The component along one axis, or both.
    fn new(axis: Option<usize>) -> Self {
        let (components, along) = match axis {
            Some(0) => (1.0, " along x"),
            Some(_) => (1.0, " along y"),
            None => (2.0, ""),
        };
        Self { components, along }
    }

    /// The diffusion coefficients: from the mean squared displacement at the lags of theory, and at
    /// long lags, where it grows in proportion to the lag (in two dimensions it grows slowly with
    /// the lag and with the box), and as the integral of the velocity autocorrelation of each
    /// component. `lags` are all lags.
    fn coefficients(self, lags: &[f64], context: &Context<'_>) -> Vec<Coefficient> {
        let unit = "length²/time";
        let velocities = lags.len();
        let of = |name: &str, reading, curve| {
            Coefficient::new((name, unit), reading, curve, lags, context.of_curves())
        };
        let theory = context.gas().map(HardDiscs::diffusion);
        let named = format!("diffusion coefficient{}", self.along);
        let from_slope = 0.5 / self.components;
        let of_theory = context.gas().map(|gas| {
            let between = BETWEEN.map(|times| times / gas.collision_rate());
            let reading = (Reading::SlopeBetween(between), from_slope);
            of(&format!("apparent {named}"), reading, 0)
        });
        let plateau = (Reading::Plateau { memory: velocities }, from_slope);
        let integral = (Reading::Integral, 1.0 / self.components);
        [
            of(&named, plateau, 0),
            of(&format!("{named} from velocities"), integral, velocities),
        ]
        .into_iter()
        .chain(of_theory)
        .map(|coefficient| coefficient.predicted(theory, SONINE))
        .collect()
    }

    /// The autocorrelation of Enskog's theory at short lags.
    fn exponential(self, lag: f64, context: &Context<'_>) -> Option<f64> {
        let gas = context.gas()?;
        let rate = gas.collision_rate();
        let count = gas.count as f64;
        // ⟨v²⟩ relative to the centre of mass.
        let square = self.components * gas.temperature / gas.mass * (1.0 - 1.0 / count);
        (lag * rate < FREE_TIMES).then(|| square * (-rate * lag).exp())
    }
}
