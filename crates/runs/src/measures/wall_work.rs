//! `wall-work`: work of walls that move.

use anyhow::ensure;
use carom::observers::WallWork;
use carom_tables::{BlockMean, Table};

use super::{Context, MeasureKind, Measured, Of, Results, Span, in_blocks, point_bytes, resumed};

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "wall-work",
    summary: "work of walls that move on the bodies that touch them, all walls or those with the tag",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[],
    figures: &["power of walls", "contacts with walls"],
    start: |selection| {
        let is_wall = |body: carom::engine::BodyView<'_>| {
            body.body.is_wall() && selection.group.contains(body.body)
        };
        ensure!(
            selection.view.bodies().any(is_wall),
            "run.observe: 'wall-work': there is no such wall"
        );
        Ok(in_blocks(WallWork::new(selection.group)))
    },
    resume: resumed::<WallWork>,
};

impl Measured for WallWork {
    const OF_INTERVALS: bool = true;

    /// Work and contacts, both per time.
    fn sums(&self) -> Vec<[f64; 2]> {
        vec![
            [self.work(), self.duration()],
            [self.contacts() as f64, self.duration()],
        ]
    }

    fn bytes_per_sample(&self) -> usize {
        point_bytes(self.series())
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let points = self.series();
        let work = points.iter().map(|point| Some(point.work)).collect();
        let table = Table::new(context.table("wall-work"), "Work of walls")
            .abscissa(
                "time",
                "time",
                points.iter().map(|point| point.time).collect(),
            )
            .counts(
                "contacts",
                points.iter().map(|point| point.contacts).collect(),
            )
            .value("work", "mass·length²/time²", work)
            .caption(
                "Sums since the start of the measurement. Negative: the gas has done work on the walls.",
            );
        let names = [
            ("power of walls", "mass·length²/time³", None),
            ("contacts with walls", "1/time", None),
        ];
        let figures = context.figures(names, means, "");
        Results {
            tables: vec![table],
            figures,
            ..Results::default()
        }
    }
}
