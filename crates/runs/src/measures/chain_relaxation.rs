//! `chain-relaxation`: displacement of the middle of chains, and the correlations of a Rouse mode
//! and of the end-to-end vector, with their relaxation times.

use anyhow::Result;
use carom::observers::{ChainLag, ChainRelaxation};
use carom_tables::{BlockMean, Table};

use crate::curves::{MIN_PAIRS, error_of_sum, joined_at};

use super::{
    Context, Default, MAX_LAG, MeasureKind, Measured, Of, Parameter, Results, Selection, Span,
    in_blocks, relaxation::time_figure, resumed, subscript,
};

/// The largest number of a mode. More: a wrong number.
const MAX_MODE: f64 = 1000.0;

/// The figures: lags at which a correlation falls to 1/e.
const TIME_OF_ENDS: &str = "relaxation time of the end-to-end vector";
const TIME_OF_MODE: &str = "relaxation time of the Rouse mode";

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "chain-relaxation",
    summary: "chains without branches against the lag: squared displacement of the middle, correlations of a \
              Rouse mode and of the end-to-end vector",
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
    figures: &[TIME_OF_ENDS, TIME_OF_MODE],
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
    /// Displacement, then correlation of the mode, then of the end-to-end vector, at each lag.
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
        let of_ends = context.at_lags(means, 2, all, &lags);
        let mode = subscript("X", self.mode());
        let time = |name: &str, correlation: &[BlockMean]| {
            time_figure(name, &lags, &by_first(correlation, &lags, context), context)
        };
        let times = [
            time(TIME_OF_ENDS, &of_ends),
            time(&format!("{TIME_OF_MODE} {mode}"), &correlation),
        ];
        let table = Table::new(context.table("chain-relaxation"), "Relaxation of chains")
            .abscissa("lag", "time", lags.clone())
            .counts("pairs", points.iter().map(|point| point.pairs).collect())
            .means("displacement", "length²", &displacement)
            .means("correlation", "length²", &correlation)
            .means("end_to_end", "length²", &of_ends)
            .logarithmic()
            .caption(format!(
                "Mean squared displacement of the middle of a chain without branches, ⟨{mode}(t₀ + t)·{mode}(t₀)⟩ of \
                 its Rouse mode (correlation), and ⟨R(t₀ + t)·R(t₀)⟩ of its end-to-end vector, from lags with at least \
                 {MIN_PAIRS} pairs."
            ));
        Results {
            tables: vec![table],
            figures: times.into_iter().flatten().collect(),
            ..Results::default()
        }
    }
}

/// A correlation by its value at the first lag, which is 0 (time); empty without a value above 0
/// there.
fn by_first(correlation: &[BlockMean], lags: &[f64], context: &Context<'_>) -> Vec<BlockMean> {
    let Some(first) = correlation.first().copied() else {
        return Vec::new();
    };
    let Some(square) = first.value.filter(|square| *square > 0.0) else {
        return Vec::new();
    };
    let of = |(mean, &lag): (&BlockMean, &f64)| {
        let ratio = mean.value.map(|value| value / square);
        let joined = joined_at(lag, context.block);
        let runs = std::slice::from_ref(context.blocks);
        // The derivatives of the ratio by both means. A lag as long as all joined blocks has no
        // error.
        let error = mean.standard_error.zip(ratio).and_then(|(_, ratio)| {
            let terms = [(*mean, 1.0 / square), (first, -ratio / square)];
            error_of_sum(runs, joined, terms)
        });
        BlockMean {
            value: ratio,
            standard_error: error,
            quantity: None,
        }
    };
    correlation.iter().zip(lags).map(of).collect()
}

#[cfg(test)]
mod tests {
    use carom_tables::Sums;

    use super::*;
    use crate::measures::Label;

    /// The correlation 4 exp(−t/1.7) by its value at lag 0, and its relaxation time, from 32 blocks
    /// with a factor of 1.1 or 0.9 on the lags that `is_disturbed` names.
    fn exponential(is_disturbed: fn(f64) -> bool) -> (Vec<BlockMean>, f64) {
        let lags: Vec<f64> = (0..12).map(|lag| 0.4 * f64::from(lag)).collect();
        let block = |number: i32| -> Sums {
            let random = 0x9e37_79b9_u32 >> number & 1;
            let sum = |&lag: &f64| {
                let factor = if is_disturbed(lag) {
                    0.9 + 0.2 * f64::from(random)
                } else {
                    1.0
                };
                [40.0 * factor * (-lag / 1.7).exp(), 10.0]
            };
            lags.iter().map(sum).collect()
        };
        let blocks: Vec<Sums> = (0..32).map(block).collect();
        let mean = |quantity: usize| {
            let sums: f64 = blocks.iter().map(|block| block[quantity][0]).sum();
            BlockMean {
                value: Some(sums / 320.0),
                standard_error: Some(0.1),
                quantity: Some(quantity),
            }
        };
        let means: Vec<BlockMean> = (0..lags.len()).map(mean).collect();
        let context = Context {
            label: &Label::default(),
            block: 100.0,
            blocks: &blocks,
            is_elastic: true,
            is_equilibrium: true,
            is_cooling: false,
            falls: false,
            cooling_discs: None,
            hard_discs: &Err("chains".to_owned()),
        };
        let ratios = by_first(&means, &lags, &context);
        let time = time_figure(TIME_OF_ENDS, &lags, &ratios, &context);
        (ratios, time.expect("a time").value)
    }

    #[test]
    fn the_time_of_an_exponential_is_exact_and_a_common_factor_makes_no_error() {
        let (ratios, time) = exponential(|_| true);
        assert!((time / 1.7 - 1.0).abs() < 1e-12, "{time}");
        for (ratio, lag) in ratios.iter().zip(0..) {
            let expected = (-0.4 * f64::from(lag) / 1.7).exp();
            assert!((ratio.value.unwrap() / expected - 1.0).abs() < 1e-12);
            assert!(ratio.standard_error.unwrap() < 1e-12, "{ratio:?}");
        }
    }

    /// The ratio of two means has the relative error of the one that varies.
    #[test]
    fn the_first_and_the_last_value_of_a_ratio_have_the_same_share_in_its_error() {
        let share = |is_disturbed: fn(f64) -> bool| {
            let ratio = exponential(is_disturbed).0[4];
            ratio.standard_error.unwrap() / ratio.value.unwrap()
        };
        let [of_first, of_others] = [share(|lag| lag == 0.0), share(|lag| lag > 0.0)];
        assert!(of_first > 1e-4 && of_first < 0.1, "{of_first}");
        assert!(
            (of_first / of_others - 1.0).abs() < 1e-9,
            "{of_first} {of_others}"
        );
    }
}
