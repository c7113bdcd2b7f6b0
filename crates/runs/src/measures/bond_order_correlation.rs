//! `bond-order-correlation`: the correlation of ψₙ of two bodies by their distance, g₆(r).

use anyhow::Result;
use carom::{BondOrderCorrelation, observers::BondOrderPoint};
use carom_tables::{BlockMean, Table};

use super::{
    Context, MeasureKind, Measured, Of, Results, Selection, Span, hexatic_order, in_blocks,
    pair_distribution::{self, distances},
    resumed, subscript,
};

/// Default of the longest distance in diameters: that over which phases differ.
const DIAMETERS: f64 = 20.0;

/// Bins for each diameter.
const BINS_PER_DIAMETER: f64 = 10.0;

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "bond-order-correlation",
    summary: "correlation g6(r) of the bond-orientational order ψ6, or of another ψn, of two bodies by their distance",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[
        hexatic_order::SYMMETRY,
        hexatic_order::NEIGHBOURS,
        hexatic_order::NEAREST,
        pair_distribution::bins("10 for each diameter"),
        pair_distribution::longest("20 diameters of the largest body"),
    ],
    figures: &[],
    start: |selection| Ok(in_blocks(correlation(selection)?)),
    resume: resumed::<BondOrderCorrelation>,
};

fn correlation(selection: &Selection<'_>) -> Result<BondOrderCorrelation> {
    let rule = hexatic_order::rule(selection)?;
    let (cutoff, bins) = distances(selection, DIAMETERS, BINS_PER_DIAMETER);
    let bounds = selection.view.bounds();
    Ok(BondOrderCorrelation::new(
        selection.group,
        rule,
        &bounds,
        cutoff,
        bins,
    )?)
}

impl Measured for BondOrderCorrelation {
    /// ⟨|ψₙ|²⟩, then gₙ in each bin.
    fn sums(&self) -> Vec<[f64; 2]> {
        self.sums()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let points = self.points();
        let Some((square, means)) = means.split_first() else {
            return Results::default();
        };
        let of = |part: fn(&BondOrderPoint) -> f64| points.iter().map(part).collect();
        let g = subscript("g", self.symmetry());
        let psi = subscript("ψ", self.symmetry());
        let by_square = means
            .iter()
            .map(|mean| Some(mean.value? / square.value.filter(|square| *square > 0.0)?));
        let table = Table::new(
            context.table("bond-order-correlation"),
            format!("Correlation of the bond-orientational order {g}(r)"),
        )
        .abscissa("distance", "length", of(|point| point.distance))
        .counts("pairs", points.iter().map(|point| point.pairs).collect())
        .means("correlation", "1", means)
        .derived(&format!("{g}(r)/⟨|{psi}|²⟩"), "1", by_square.collect())
        .caption(format!(
            "Re ⟨{psi}(i) {psi}*(j)⟩ of the bodies i and j at the distance r, and by ⟨|{psi}|²⟩, its value at distance 0. \
             {psi} with {}.",
            hexatic_order::in_words((self.symmetry(), self.neighbours()))
        ));
        Results {
            tables: vec![table],
            ..Results::default()
        }
    }
}
