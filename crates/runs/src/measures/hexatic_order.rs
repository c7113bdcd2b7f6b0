//! `hexatic-order`: the bond-orientational order ψ₆ of a group.

use carom::{HexaticOrder, observers::HexaticPoint};
use carom_tables::{BlockMean, Table};

use super::{Context, MeasureKind, Measured, Of, Results, Span, in_blocks, point_bytes, resumed};

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "hexatic-order",
    summary: "bond-orientational order ψ6, local and global, at each sample",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[],
    figures: &["mean |ψ₆|", "|mean ψ₆|"],
    start: |selection| Ok(in_blocks(HexaticOrder::new(selection.group))),
    resume: resumed::<HexaticOrder>,
};

impl Measured for HexaticOrder {
    /// Local order, its mean square, global order.
    fn sums(&self) -> Vec<[f64; 2]> {
        self.sums()
    }

    fn bytes_per_sample(&self) -> usize {
        point_bytes(self.series())
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let points = self.series();
        let of =
            |part: fn(&HexaticPoint) -> f64| points.iter().map(|point| Some(part(point))).collect();
        let table = Table::new(context.table("hexatic-order"), "Bond-orientational order ψ₆")
            .abscissa("time", "time", points.iter().map(|point| point.time).collect())
            .value("local", "1", of(|point| point.local))
            .value("global", "1", of(|point| point.global))
            .caption(
                "Mean of |ψ₆|, and |mean of ψ₆|, with the six nearest neighbours: 1 in a triangular lattice.",
            );
        let names = [
            "mean |ψ₆| of the bodies",
            "mean |ψ₆|² of the bodies",
            "|mean ψ₆|",
        ];
        let figures = context.figures(names.map(|name| (name, "1", None)), means, "");
        Results {
            tables: vec![table],
            figures,
            ..Results::default()
        }
    }
}
