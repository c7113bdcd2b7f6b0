//! `directions`: directions of the impulses on bodies, in their own frames.

use carom::DirectionHistogram;
use carom_report::molecule_picture::name;
use carom_tables::{BlockMean, Figure, Table, chi_square::ChiSquare};

use super::{
    Context, Default, MeasureKind, Measured, Of, Parameter, Results, Span,
    billiard::{ARCS, Billiard},
    in_blocks,
    known::Known,
    resumed,
};

/// Most atoms and edges whose shares are figures of their own.
const MAX_PARTS: usize = 16;

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "directions",
    summary: "directions of the impulses on the bodies of a group, each in its own frame",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[Parameter::whole(
        "bins",
        Default::Number(72.0),
        "sectors of the whole turn",
    )],
    figures: &["share of contacts", "directions", "contacts by atom"],
    start: |selection| {
        let group = selection.group;
        let facts = Billiard::new(selection.view).filter(|billiard| {
            let members = selection
                .view
                .bodies()
                .filter(|body| group.contains(body.body));
            members
                .into_iter()
                .all(|body| body.body.is_fixed() == billiard.molecule_is_fixed)
        });
        Ok(in_blocks(Known {
            observer: DirectionHistogram::of_group(group, selection.whole("bins")),
            facts,
        }))
    },
    resume: resumed::<Known<DirectionHistogram, Option<Billiard>>>,
};

impl Measured for Known<DirectionHistogram, Option<Billiard>> {
    /// The share of the contacts in each sector, then that of the impulse, and the share of the
    /// contacts of each atom and each edge.
    fn sums(&self) -> Vec<[f64; 2]> {
        let hits = self.observer.hits() as f64;
        let parts = part_counts(&self.observer)
            .into_iter()
            .map(|count| [count as f64, hits]);
        sums(&self.observer).into_iter().chain(parts).collect()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let histogram = &self.observer;
        let exact = self.facts.as_ref().filter(|_| context.is_equilibrium);
        let parts = exact.and_then(|billiard| billiard.direction_shares(histogram.counts().len()));
        let of_parts = exact.and_then(Billiard::part_shares);
        let counts = part_counts(histogram);
        let atoms = histogram.atom_counts().len();
        let by_part = if histogram.edge_counts().is_empty() {
            "contacts by atom"
        } else {
            "contacts by atom and edge"
        };
        let chi = [
            (
                "directions",
                histogram.counts(),
                parts.as_ref().map(|parts| &parts[0]),
            ),
            (by_part, &counts, of_parts.as_ref()),
        ];
        let chi = chi.into_iter().filter_map(|(what, counts, shares)| {
            chi_square(what, ChiSquare::new(counts, shares?), ARCS, context)
        });
        let chi: Vec<Figure> = chi.collect();
        let predicted = parts.map(|parts| Shares {
            parts,
            label: "exposed boundary",
            source: ARCS,
        });
        let (directions, parts) = means.split_at(means.len().min(2 * histogram.counts().len()));
        let share = |(part, mean): (usize, &BlockMean)| {
            let name = format!("share of contacts on {}", part_name(part, atoms));
            let figure = context.figure(&name, "1", mean)?;
            let predicted = of_parts
                .as_ref()
                .and_then(|shares| shares.get(part).copied());
            Some(figure.predicted(predicted, ARCS))
        };
        let count = if parts.len() > 1 { MAX_PARTS } else { 0 };
        let shares = parts.iter().enumerate().take(count).filter_map(share);
        Results {
            tables: vec![table(histogram, directions, context, predicted.as_ref())],
            figures: chi.into_iter().chain(shares).collect(),
            ..Results::default()
        }
    }
}

/// The number of contacts of each atom, and then of each straight edge.
pub(super) fn part_counts(histogram: &DirectionHistogram) -> Vec<u64> {
    [histogram.atom_counts(), histogram.edge_counts()].concat()
}

/// The name of an atom, or of an edge if the number is not below that of the `atoms`.
pub(super) fn part_name(part: usize, atoms: usize) -> String {
    match part.checked_sub(atoms) {
        None => format!("atom {}", name(part)),
        Some(edge) => format!("edge {edge}"),
    }
}

/// The share of the contacts in each sector, then that of the impulse.
pub(super) fn sums(histogram: &DirectionHistogram) -> Vec<[f64; 2]> {
    let (hits, impulse) = (histogram.hits() as f64, histogram.total_impulse());
    let by_count = histogram.counts().iter().map(|&count| [count as f64, hits]);
    by_count
        .chain(histogram.impulse().iter().map(|&sum| [sum, impulse]))
        .collect()
}

/// χ² per degree of freedom of shares against their prediction; `None` without a degree of freedom.
pub(super) fn chi_square(
    what: &str,
    chi: ChiSquare,
    source: &str,
    context: &Context<'_>,
) -> Option<Figure> {
    let freedom = chi.freedom as f64;
    (chi.freedom > 0).then(|| {
        let name = context.named(&format!("{what}, χ² per degree of freedom"));
        Figure::new(name, chi.value / freedom, "1")
            .error((2.0 / freedom).sqrt())
            .predicted(1.0, source)
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
    let mut table = Table::new(context.table("directions"), "Directions of the impulses")
        .abscissa("direction", "°", (0..sectors).map(angle).collect())
        .counts("contacts", histogram.counts().to_vec())
        .caption("In the frame of the body, counter-clockwise from its x′ axis.")
        .polar();
    let (by_count, by_impulse) = means.split_at(means.len() / 2);
    let columns = [
        ("share_of_contacts", by_count),
        ("share_of_impulse", by_impulse),
    ];
    for (index, (name, means)) in columns.into_iter().enumerate() {
        table = table.means(name, "1", means);
        if let Some(Shares {
            parts,
            label,
            source,
        }) = predicted
        {
            table = table.prediction(
                label,
                parts[index].iter().copied().map(Some).collect(),
                source,
            );
        }
    }
    table
}
