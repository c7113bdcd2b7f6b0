//! `wells`: the energy of the wells of discs, and how many discs are within their ranges.

use carom::observers::{WellEnergy, WellPoint};
use carom_tables::{BlockMean, Table};

use super::{Context, MeasureKind, Measured, Of, Results, Span, in_blocks, point_bytes, resumed};

/// The figures, in the order of the sums, with their units.
const FIGURES: [(&str, &str); 3] = [
    ("energy of wells", "energy"),
    ("energy of wells by number of bodies", "energy"),
    ("bodies within the wells of a body", "1"),
];

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "wells",
    summary: "energy of the wells of discs, in all and for each body, and the mean number of bodies within the wells \
              of one",
    of: Of::System,
    span: Span::Measurement,
    parameters: &[],
    figures: &[FIGURES[0].0, FIGURES[1].0, FIGURES[2].0],
    start: |_| Ok(in_blocks(WellEnergy::default())),
    resume: resumed::<WellEnergy>,
};

impl Measured for WellEnergy {
    fn sums(&self) -> Vec<[f64; 2]> {
        self.sums()
    }

    fn bytes_per_sample(&self) -> usize {
        point_bytes(self.series())
    }

    fn present(&self) -> Vec<(&'static str, Option<f64>)> {
        vec![(
            "energy of wells",
            self.series().last().map(|point| point.energy),
        )]
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let figures = FIGURES.map(|(name, unit)| (name, unit, None));
        Results {
            tables: vec![series(self, context)],
            figures: context.figures(figures, means, ""),
            ..Results::default()
        }
    }
}

/// The energy and the pairs at each sample.
fn series(wells: &WellEnergy, context: &Context<'_>) -> Table {
    let points = wells.series();
    let energies = |point: &WellPoint| Some(point.energy);
    Table::new(context.table("wells"), "Energy of wells")
        .abscissa("time", "time", points.iter().map(|point| point.time).collect())
        .value("energy", "energy", points.iter().map(energies).collect())
        .counts("pairs", points.iter().map(|point| point.pairs).collect())
        .caption(
            "The energy of all pairs of discs within the ranges of their wells, and the number of these \
             pairs. Together with the kinetic energy it is constant where nothing else acts.",
        )
}
