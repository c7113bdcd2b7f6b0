//! `wall-heat`: heat that a gas receives from walls with a temperature.

use anyhow::ensure;
use carom::observers::WallHeat;
use carom_tables::{BlockMean, Table};

use super::{Context, MeasureKind, Measured, Of, Results, Span, in_blocks, point_bytes, resumed};

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "wall-heat",
    summary: "heat received from walls that have a temperature, all or those with the tag",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[],
    figures: &["heat received from walls", "contacts with thermal walls"],
    start: |selection| {
        let is_wall = |body: carom::engine::BodyView<'_>| {
            body.body.wall_temperature().is_some() && selection.group.contains(body.body)
        };
        ensure!(
            selection.view.bodies().any(is_wall),
            "run.observe: 'wall-heat': no such wall has a temperature"
        );
        Ok(in_blocks(WallHeat::new(selection.group)))
    },
    resume: resumed::<WallHeat>,
};

impl Measured for WallHeat {
    const OF_INTERVALS: bool = true;

    /// Heat and contacts, both per time.
    fn sums(&self) -> Vec<[f64; 2]> {
        vec![
            [self.heat(), self.duration()],
            [self.contacts() as f64, self.duration()],
        ]
    }

    fn bytes_per_sample(&self) -> usize {
        point_bytes(self.series())
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let points = self.series();
        let heat = points.iter().map(|point| Some(point.heat)).collect();
        let table = Table::new(context.table("wall-heat"), "Heat received from walls")
            .abscissa(
                "time",
                "time",
                points.iter().map(|point| point.time).collect(),
            )
            .counts(
                "contacts",
                points.iter().map(|point| point.contacts).collect(),
            )
            .value("heat", "mass·length²/time²", heat)
            .caption(
                "Sums since the start of the measurement. Negative: the walls have cooled the gas.",
            );
        let names = [
            ("heat received from walls", "mass·length²/time³", None),
            ("contacts with thermal walls", "1/time", None),
        ];
        let figures = context.figures(names, means, "");
        Results {
            tables: vec![table],
            figures,
            ..Results::default()
        }
    }
}
