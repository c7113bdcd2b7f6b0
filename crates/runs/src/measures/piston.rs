//! `piston`: place, velocity and energy of a piston at each sample.

use anyhow::{Context as _, ensure};
use carom::observers::{PistonPoint, PistonSeries};
use carom_tables::{BlockMean, Table};

use super::{Context, MeasureKind, Measured, Of, Results, Span, in_blocks, point_bytes, resumed};

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "piston",
    summary: "place, velocity and energy of the only piston, or of that with the tag, at each sample",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[],
    figures: &[
        "place of the piston",
        "velocity of the piston",
        "kT of the piston",
    ],
    start: |selection| {
        let view = selection.view;
        let mut pistons = view
            .bodies()
            .filter(|body| body.body.is_piston() && selection.group.contains(body.body));
        let (first, another) = (pistons.next(), pistons.next());
        let piston = first.context("no piston carries that tag")?;
        ensure!(
            another.is_none(),
            "there are several pistons; name the tag of one"
        );
        Ok(in_blocks(PistonSeries::new(piston.body.key())))
    },
    resume: resumed::<PistonSeries>,
};

const ENERGY: &str = "mass·length²/time²";

impl Measured for PistonSeries {
    /// Place, velocity and twice the energy.
    fn sums(&self) -> Vec<[f64; 2]> {
        self.sums()
    }

    fn bytes_per_sample(&self) -> usize {
        point_bytes(self.series())
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let points = self.series();
        let of = |part: fn(&PistonPoint) -> f64| points.iter().map(part).collect::<Vec<f64>>();
        let table = Table::new(context.table("piston"), "Piston")
            .abscissa("time", "time", of(|point| point.time))
            .value(
                "place",
                "length",
                points.iter().map(|point| Some(point.place)).collect(),
            )
            .undrawn("velocity", "length/time", of(|point| point.velocity))
            .undrawn("energy", ENERGY, of(|point| point.energy))
            .caption(
                "The kT of the piston is the mean of M V², twice its kinetic energy: at equilibrium that of the gases."
                    .to_owned(),
            );
        let names = [
            ("place of the piston", "length"),
            ("velocity of the piston", "length/time"),
            ("kT of the piston", ENERGY),
        ];
        let figures = names
            .into_iter()
            .zip(means)
            .filter_map(|((name, unit), mean)| context.figure(name, unit, mean));
        Results {
            tables: vec![table],
            figures: figures.collect(),
            ..Results::default()
        }
    }
}
