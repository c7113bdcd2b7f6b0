//! `directions:TAG`: directions of the impulses on one body, in its own frame.

use carom::DirectionHistogram;
use carom_tables::{BlockMean, Figure, Table, chi_square::ChiSquare};

use super::{
    Context, Default, Kind, Measured, Of, Parameter, Results, Span,
    billiard::{ARCS, Billiard},
    in_blocks,
    known::Known,
    resumed,
};

pub(super) const KIND: Kind = Kind {
    name: "directions",
    summary: "directions of the impulses on the only body with the tag, in the frame of the body",
    of: Of::OneBody,
    span: Span::Measurement,
    parameters: &[Parameter::whole("bins", Default::Number(72.0), "sectors of the whole turn")],
    begin: |selection| {
        let body = selection.only_body()?.body;
        let facts = Billiard::of(selection.view).filter(|_| body.is_fixed());
        Ok(in_blocks(Known { observer: DirectionHistogram::new(body.key(), selection.whole("bins")), facts }))
    },
    resume: resumed::<Known<DirectionHistogram, Option<Billiard>>>,
};

impl Measured for Known<DirectionHistogram, Option<Billiard>> {
    /// The share of the contacts in each sector, then that of the impulse.
    fn sums(&self) -> Vec<[f64; 2]> {
        sums(&self.observer)
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let histogram = &self.observer;
        let exact = self.facts.as_ref().filter(|_| context.is_equilibrium);
        let shares = exact.and_then(|billiard| billiard.direction_shares(histogram.counts().len()));
        let chi = shares.as_ref().map(|shares| ChiSquare::of(histogram.counts(), shares));
        let predicted = shares.map(|shares| Shares {
            parts: [shares.clone(), shares],
            label: "exposed arcs",
            source: ARCS,
        });
        let figures = chi.and_then(|chi| chi_square("directions", chi, ARCS, context)).into_iter().collect();
        Results {
            tables: vec![table(histogram, means, context, predicted.as_ref())],
            figures,
            ..Results::default()
        }
    }
}

/// The share of the contacts in each sector, then that of the impulse.
pub(super) fn sums(histogram: &DirectionHistogram) -> Vec<[f64; 2]> {
    let (hits, impulse) = (histogram.hits() as f64, histogram.total_impulse());
    let by_count = histogram.counts().iter().map(|&count| [count as f64, hits]);
    by_count.chain(histogram.impulse().iter().map(|&sum| [sum, impulse])).collect()
}

/// χ² per degree of freedom of shares against their prediction; `None` without a degree of freedom.
pub(super) fn chi_square(what: &str, chi: ChiSquare, source: &str, context: &Context<'_>) -> Option<Figure> {
    let freedom = chi.freedom as f64;
    (chi.freedom > 0).then(|| {
        let name = context.named(&format!("{what}, χ² per degree of freedom"));
        Figure::new(name, chi.value / freedom, "1").error((2.0 / freedom).sqrt()).predicted(1.0, source)
    })
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
