//! `chains`: the lengths of bonds, and the sizes and shapes of the chains that they make.

use carom::observers::{ChainPoint, ChainShapes};
use carom_tables::{BlockMean, Table};

use super::{Context, MeasureKind, Measured, Of, Results, Span, in_blocks, point_bytes, resumed};

/// The figures, in the order of the sums, with their units.
const FIGURES: [(&str, &str); 13] = [
    ("length of a bond", "length"),
    ("squared length of a bond", "length²"),
    ("squared end-to-end distance", "length²"),
    (
        "squared end-to-end distance by that of independent bonds",
        "1",
    ),
    ("squared radius of gyration", "length²"),
    ("asphericity of chains", "1"),
    ("larger eigenvalue of the tensor of gyration", "length²"),
    ("smaller eigenvalue of the tensor of gyration", "length²"),
    ("ratio of the eigenvalues of the tensor of gyration", "1"),
    ("tensor of gyration S_xx", "length²"),
    ("tensor of gyration S_yy", "length²"),
    ("tensor of gyration S_xy", "length²"),
    (
        "squared radius of gyration by that of independent bonds",
        "1",
    ),
];

/// The names of the figures.
const NAMES: [&str; FIGURES.len()] = {
    let mut names = [""; FIGURES.len()];
    let mut number = 0;
    while number < names.len() {
        names[number] = FIGURES[number].0;
        number += 1;
    }
    names
};

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "chains",
    summary: "chains of bodies tied by bonds: bond lengths, end-to-end distance, radius and tensor of gyration, \
              asphericity",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[],
    figures: &NAMES,
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
