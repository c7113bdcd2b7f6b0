//! `chain-relaxation`: displacement of the middle of chains, and the correlation of a Rouse mode.

use anyhow::Result;
use carom::observers::{ChainLag, ChainRelaxation};
use carom_tables::{BlockMean, Table};

use crate::curves::MIN_PAIRS;

use super::{
    Context, Default, MAX_LAG, MeasureKind, Measured, Of, Parameter, Results, Selection, Span,
    in_blocks, resumed, subscript,
};

/// The largest number of a mode. More: a wrong number.
const MAX_MODE: f64 = 1000.0;

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "chain-relaxation",
    summary: "chains without branches against the lag: squared displacement of the middle, and correlation of a \
              Rouse mode",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[
        Parameter::up_to(
            "mode",
            MAX_MODE,
            Default::Number(1.0),
            "number p of the Rouse mode; 1 is the slowest",
        ),
        MAX_LAG,
    ],
    figures: &[],
    start: |selection| Ok(in_blocks(relaxation(selection)?)),
    resume: resumed::<ChainRelaxation>,
};

fn relaxation(selection: &Selection<'_>) -> Result<ChainRelaxation> {
    let (interval, longest) = (selection.interval(), selection.longest_lag());
    let mode = selection.whole("mode") as u32;
    Ok(ChainRelaxation::new(
        selection.group,
        mode,
        interval,
        longest,
    )?)
}

impl Measured for ChainRelaxation {
    /// Displacement, then correlation, at each lag.
    fn sums(&self) -> Vec<[f64; 2]> {
        self.sums()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let mut points = self.points();
        points.retain(|point| point.pairs >= MIN_PAIRS);
        if points.is_empty() {
            return Results::default();
        }
        let of = |part: fn(&ChainLag) -> f64| -> Vec<f64> { points.iter().map(part).collect() };
        let (lags, all) = (of(|point| point.lag), self.lags().len());
        let displacement = context.at_lags(means, 0, all, &lags);
        let correlation = context.at_lags(means, 1, all, &lags);
        let mode = subscript("X", self.mode());
        let table = Table::new(context.table("chain-relaxation"), "Relaxation of chains")
            .abscissa("lag", "time", lags)
            .counts("pairs", points.iter().map(|point| point.pairs).collect())
            .means("displacement", "length²", &displacement)
            .means("correlation", "length²", &correlation)
            .logarithmic()
            .caption(format!(
                "Mean squared displacement of the middle of a chain without branches, and ⟨{mode}(t₀ + t)·{mode}(t₀)⟩ \
                 of its Rouse mode, from lags with at least {MIN_PAIRS} pairs."
            ));
        Results {
            tables: vec![table],
            ..Results::default()
        }
    }
}
