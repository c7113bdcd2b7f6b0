//! `bond-order-relaxation`: the correlation of ψₙ of a body with itself against the lag, G₆(t).

use anyhow::Result;
use carom::{BondOrderRelaxation, observers::BondOrderLag};
use carom_tables::{BlockMean, Table};

use crate::curves::MIN_PAIRS;

use super::{
    Context, MAX_LAG, MeasureKind, Measured, Of, Results, Selection, Span, hexatic_order,
    in_blocks, resumed, subscript,
};

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "bond-order-relaxation",
    summary: "correlation G6(t) of the bond-orientational order ψ6, or of another ψn, of a body with itself against \
              the lag",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[
        hexatic_order::SYMMETRY,
        hexatic_order::NEIGHBOURS,
        hexatic_order::NEAREST,
        MAX_LAG,
    ],
    figures: &[],
    start: |selection| Ok(in_blocks(relaxation(selection)?)),
    resume: resumed::<BondOrderRelaxation>,
};

fn relaxation(selection: &Selection<'_>) -> Result<BondOrderRelaxation> {
    let rule = hexatic_order::rule(selection)?;
    let (interval, longest) = (selection.interval(), selection.longest_lag());
    Ok(BondOrderRelaxation::new(
        selection.group,
        rule,
        interval,
        longest,
    )?)
}

impl Measured for BondOrderRelaxation {
    /// Gₙ at each lag.
    fn sums(&self) -> Vec<[f64; 2]> {
        self.sums()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let mut points = self.points();
        points.retain(|point| point.pairs >= MIN_PAIRS);
        if points.is_empty() {
            return Results::default();
        }
        let of = |part: fn(&BondOrderLag) -> f64| -> Vec<f64> { points.iter().map(part).collect() };
        let lags = of(|point| point.lag);
        let correlation = context.at_lags(means, 0, self.lags().len(), &lags);
        let (g, psi) = (
            subscript("G", self.symmetry()),
            subscript("ψ", self.symmetry()),
        );
        let table = Table::new(
            context.table("bond-order-relaxation"),
            format!("Relaxation of the bond-orientational order {g}(t)"),
        )
        .abscissa("lag", "time", lags)
        .counts("pairs", points.iter().map(|point| point.pairs).collect())
        .means("correlation", "1", &correlation)
        .logarithmic()
        .caption(format!(
            "Re ⟨{psi}(t₀ + t) {psi}*(t₀)⟩ of each body with itself, from lags with at least {MIN_PAIRS} pairs; \
             ⟨|{psi}|²⟩ at lag 0. {psi} with {}.",
            hexatic_order::in_words((self.symmetry(), self.neighbours()))
        ));
        Results {
            tables: vec![table],
            ..Results::default()
        }
    }
}
