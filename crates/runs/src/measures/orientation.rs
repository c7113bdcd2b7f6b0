//! `orientation`: correlations of orientations and angular velocities of a group.

use carom::OrientationCorrelation;
use carom_tables::{BlockMean, Table};

use super::{Context, Kind, Measured, Of, Results, correlation::LONGEST_LAG, in_blocks, resumed};

pub(super) const KIND: Kind = Kind {
    name: "orientation",
    summary: "orientational correlations and angular velocity autocorrelation against the lag",
    of: Of::Group,
    begin: |selection| {
        let interval = selection.run.sample_interval;
        let longest = (interval * LONGEST_LAG).min(f64::MAX);
        Ok(in_blocks(OrientationCorrelation::new(selection.group, interval, longest)?))
    },
    resume: resumed::<OrientationCorrelation>,
};

impl Measured for OrientationCorrelation {
    /// C₁ at each lag, then C₂, then the autocorrelation.
    fn sums(&self) -> Vec<[f64; 2]> {
        self.sums()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        // Lags without pairs are the longest.
        let lags = self.lags();
        let measured = self.points().len();
        let column = |quantity: usize| -> (Vec<Option<f64>>, Vec<Option<f64>>) {
            let of = means.iter().skip(quantity * lags.len()).take(measured).zip(&lags);
            of.map(|(mean, &lag)| (mean.value, mean.standard_error.filter(|_| lag < context.block))).unzip()
        };
        let [(first, first_errors), (second, second_errors), (spin, spin_errors)] = [0, 1, 2].map(column);
        let table = Table::new(
            format!("orientation{}", context.suffix),
            "Correlation of orientations and of angular velocities",
        )
        .logarithmic()
        .abscissa("lag", "time", lags[..measured].to_vec())
        .counts("pairs", self.points().iter().map(|point| point.pairs).collect())
        .value("cos_Δθ", "1", first)
        .errors(first_errors)
        .value("cos_2Δθ", "1", second)
        .errors(second_errors)
        .value("angular_velocity_autocorrelation", "1/time²", spin)
        .errors(spin_errors)
        .caption(
            "⟨cos Δθ⟩ and ⟨cos 2Δθ⟩ of the bodies that turn: 1 at lag 0, 0 when orientations are forgotten.",
        );
        Results { tables: vec![table], figures: Vec::new() }
    }
}
