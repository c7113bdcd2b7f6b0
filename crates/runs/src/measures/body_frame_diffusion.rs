//! `body-frame-diffusion`: diffusion along and across the axis of a body, in its own frame.

use carom::BodyFrameDiffusion;
use carom_tables::{BlockMean, Table};

use crate::curves::{Coefficient, MIN_PAIRS, Reading};

use super::{Context, MAX_LAG, MeasureKind, Measured, Of, Results, Span, in_blocks, resumed};

/// The two coefficients.
const NAMES: [[&str; 2]; 2] = [["D∥", "along"], ["D⊥", "across"]];

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "body-frame-diffusion",
    summary: "displacements along and across the axis of a body, summed in its own frame, against the lag",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[MAX_LAG],
    figures: &["D∥", "D⊥", "apparent D∥", "apparent D⊥"],
    start: |selection| {
        let (interval, longest) = (selection.interval(), selection.longest_lag());
        Ok(in_blocks(BodyFrameDiffusion::new(
            selection.group,
            interval,
            longest,
        )?))
    },
    resume: resumed::<BodyFrameDiffusion>,
};

impl Measured for BodyFrameDiffusion {
    /// The squared displacements along the axis at each lag, then across it, then the products of
    /// the velocities along it, and across it.
    fn sums(&self) -> Vec<[f64; 2]> {
        self.sums()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let points = self.points();
        if points.is_empty() {
            return Results::default();
        }
        let lags: Vec<f64> = points.iter().map(|point| point.lag).collect();
        let quantity = |index: usize| -> Vec<BlockMean> {
            let mut found = context.at_lags(means, index, self.lags().len(), &lags);
            let few = points.iter().map(|point| point.pairs < MIN_PAIRS);
            for (mean, _) in found.iter_mut().zip(few).filter(|(_, few)| *few) {
                *mean = BlockMean::default();
            }
            found
        };
        let squares = [quantity(0), quantity(1)];
        let products = [quantity(2), quantity(3)];
        let table = Table::new(
            context.table("body-frame-diffusion"),
            "Displacements and velocities along and across the axis of the body",
        )
        .abscissa("lag", "time", lags.clone())
        .counts("pairs", points.iter().map(|point| point.pairs).collect())
        .means("square_along", "length²", &squares[0])
        .means("square_across", "length²", &squares[1])
        .means("velocity_along", "length²/time²", &products[0])
        .means("velocity_across", "length²/time²", &products[1])
        .logarithmic()
        .in_decades(&["square_along", "square_across"])
        .relative_to_first(&["velocity_along", "velocity_across"])
        .guide("square_along", 2.0, "∝ t²", false)
        .guide("square_along", 1.0, "∝ t", true)
        .caption(
            "Mean squares of the displacement, resolved in each interval along the axis x′ at its start and summed, \
             and autocorrelations of the velocity in the frame of the body. At long lags 2 D∥ t and 2 D⊥ t. Lags with fewer than \
             30 pairs have no value.",
        );
        Results {
            tables: vec![table],
            coefficients: coefficients(&self.lags(), context),
            ..Results::default()
        }
    }
}

/// The diffusion coefficients along and across the axis: half the slope of the mean squared
/// displacement at long lags, and the integral of the autocorrelation of the velocity.
fn coefficients(lags: &[f64], context: &Context<'_>) -> Vec<Coefficient> {
    let unit = "length²/time";
    let of_axis = |(axis, [symbol, direction]): (usize, &[&str; 2])| {
        let (squares, memory) = (axis * lags.len(), (2 + axis) * lags.len());
        let name = format!("{symbol} {direction} the axis");
        let of_velocities = format!("{name} from velocities");
        let plateau = (Reading::Plateau { memory }, 0.5);
        [
            Coefficient::new((&name, unit), plateau, squares, lags, context.of_curves()),
            Coefficient::new(
                (&of_velocities, unit),
                (Reading::Integral, 1.0),
                memory,
                lags,
                context.of_curves(),
            ),
        ]
    };
    NAMES.iter().enumerate().flat_map(of_axis).collect()
}
