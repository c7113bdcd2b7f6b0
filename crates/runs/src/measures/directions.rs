//! `directions:TAG`: directions of the impulses on one body, in its own frame.

use carom::DirectionHistogram;
use carom_tables::{BlockMean, Table};

use super::{Context, Default, Kind, Measured, Of, Parameter, Results, Span, in_blocks, resumed};

pub(super) const KIND: Kind = Kind {
    name: "directions",
    summary: "directions of the impulses on the only body with the tag, in the frame of the body",
    of: Of::OneBody,
    span: Span::Measurement,
    parameters: &[Parameter::whole("bins", Default::Number(72.0), "sectors of the whole turn")],
    begin: |selection| {
        Ok(in_blocks(DirectionHistogram::new(selection.only_body()?.body.key(), selection.whole("bins"))))
    },
    resume: resumed::<DirectionHistogram>,
};

impl Measured for DirectionHistogram {
    /// The share of the contacts in each sector, then that of the impulse.
    fn sums(&self) -> Vec<[f64; 2]> {
        let (hits, impulse) = (self.hits() as f64, self.total_impulse());
        let by_count = self.counts().iter().map(|&count| [count as f64, hits]);
        by_count.chain(self.impulse().iter().map(|&sum| [sum, impulse])).collect()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        Results { tables: vec![table(self, means, context, None)], ..Results::default() }
    }
}

/// Predicted shares of the contacts and of the impulse in each sector.
pub(super) struct Shares {
    /// Of the contacts, then of the impulse.
    pub(super) parts: [Vec<f64>; 2],
    /// Name in the legend.
    pub(super) label: &'static str,
    /// Where they come from.
    pub(super) source: &'static str,
}

/// The table of the directions.
pub(super) fn table(
    histogram: &DirectionHistogram,
    means: &[BlockMean],
    context: &Context<'_>,
    predicted: Option<&Shares>,
) -> Table {
    let sectors = histogram.counts().len();
    let angle = |sector: usize| 360.0 * (sector as f64 + 0.5) / sectors as f64;
    let mut table = Table::new(context.table("directions"), "Directions of the impulses on the body")
        .abscissa("direction", "°", (0..sectors).map(angle).collect())
        .counts("contacts", histogram.counts().to_vec())
        .caption("In the frame of the body, counter-clockwise from its x′ axis.");
    let (by_count, by_impulse) = means.split_at(means.len() / 2);
    let columns = [("share_of_contacts", by_count), ("share_of_impulse", by_impulse)];
    for (index, (name, means)) in columns.into_iter().enumerate() {
        table = table.means(name, "1", means);
        if let Some(Shares { parts, label, source }) = predicted {
            table = table.prediction(label, parts[index].iter().copied().map(Some).collect(), source);
        }
    }
    table
}
