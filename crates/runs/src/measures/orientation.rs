//! `orientation`: correlations of orientations and angular velocities of a group.

use carom::OrientationCorrelation;
use carom_tables::{BlockMean, Table};

use super::{Context, Kind, LONGEST_LAG, Measured, Of, Results, Span, in_blocks, resumed};

pub(super) const KIND: Kind = Kind {
    name: "orientation",
    summary: "orientational correlations and angular velocity autocorrelation against the lag",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[LONGEST_LAG],
    begin: |selection| {
        let (interval, longest) = (selection.interval(), selection.longest_lag());
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
        let quantity = |index: usize| {
            let begin = (index * lags.len()).min(means.len());
            context.resolved(&means[begin..], &lags[..measured])
        };
        let table = Table::new(
            context.table("orientation"),
            "Correlation of orientations and of angular velocities",
        )
        .logarithmic()
        .abscissa("lag", "time", lags[..measured].to_vec())
        .counts("pairs", self.points().iter().map(|point| point.pairs).collect())
        .means("cos_Δθ", "1", &quantity(0))
        .means("cos_2Δθ", "1", &quantity(1))
        .means("angular_velocity_autocorrelation", "1/time²", &quantity(2))
        .caption(
            "⟨cos Δθ⟩ and ⟨cos 2Δθ⟩ of the bodies that turn: 1 at lag 0, 0 when orientations are forgotten.",
        );
        Results { tables: vec![table], ..Results::default() }
    }
}
