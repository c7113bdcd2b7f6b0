//! `chains`: the lengths of bonds, and the sizes and shapes of the chains that they make.

use carom::observers::{ChainPoint, ChainShapes};
use carom_tables::{BlockMean, Table};

use super::{Context, MeasureKind, Measured, Of, Results, Span, in_blocks, point_bytes, resumed};

/// The figures, in the order of the sums, with their units.
const FIGURES: [(&str, &str); 6] = [
    ("length of a bond", "length"),
    ("squared length of a bond", "length²"),
    ("squared end-to-end distance", "length²"),
    (
        "squared end-to-end distance by that of independent bonds",
        "1",
    ),
    ("squared radius of gyration", "length²"),
    ("asphericity of chains", "1"),
];

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "chains",
    summary: "chains of bodies tied by bonds: bond lengths, end-to-end distance, radius of gyration, asphericity",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[],
    figures: &[
        FIGURES[0].0,
        FIGURES[1].0,
        FIGURES[2].0,
        FIGURES[3].0,
        FIGURES[4].0,
        FIGURES[5].0,
    ],
    start: |selection| Ok(in_blocks(ChainShapes::new(selection.group))),
    resume: resumed::<ChainShapes>,
};

impl Measured for ChainShapes {
    fn sums(&self) -> Vec<[f64; 2]> {
        self.sums()
    }

    fn bytes_per_sample(&self) -> usize {
        point_bytes(self.series())
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        if self.series().is_empty() {
            return Results::default();
        }
        let figures = FIGURES.map(|(name, unit)| (name, unit, None));
        Results {
            tables: vec![series(self, context)],
            figures: context.figures(figures, means, ""),
            ..Results::default()
        }
    }
}

/// The chains at each sample.
fn series(shapes: &ChainShapes, context: &Context<'_>) -> Table {
    let points = shapes.series();
    let drawn = |part: fn(&ChainPoint) -> Option<f64>| points.iter().map(part).collect();
    Table::new(context.table("chains"), "Chains")
        .abscissa("time", "time", points.iter().map(|point| point.time).collect())
        .counts("chains", points.iter().map(|point| point.chains).collect())
        .value("end_to_end_squared", "length²", drawn(|point| point.end_to_end_squared))
        .value("gyration_squared", "length²", drawn(|point| Some(point.gyration_squared)))
        .value("bond_squared", "length²", drawn(|point| Some(point.bond_squared)))
        .caption(
            "Chains of bodies that bonds connect: the mean squared distance of the two ends of chains \
             without branches, the mean squared radius of gyration, and the mean squared distance of \
             the tied points.",
        )
}
