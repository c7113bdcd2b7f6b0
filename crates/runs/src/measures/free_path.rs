//! `free-path`: lengths of the flights of a group between contacts.

use carom::observers::{AdaptiveHistogram, FreePaths};
use carom_tables::{BlockMean, Table};

use super::{
    Context, Default, HardDiscs, MeasureKind, Measured, Of, Parameter, Results, Selection, Span,
    billiard::{Billiard, SANTALO},
    hard_discs::ENSKOG,
    in_blocks,
    known::Known,
    range, resumed,
};

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "free-path",
    summary: "path lengths between successive contacts: their mean and distribution",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[
        Parameter::whole("bins", Default::Number(120.0), "bins of the histogram"),
        Parameter::positive(
            range::MAX,
            range::FOLLOWS,
            "longest path in the bins (length)",
        ),
    ],
    figures: &["mean free path", "share of the free paths"],
    start: |selection| {
        let facts = Billiard::new(selection.view).filter(|_| selection.moving().next().is_some());
        Ok(in_blocks(Known {
            observer: observer(selection)?,
            facts,
        }))
    },
    resume: resumed::<Known<FreePaths, Option<Billiard>>>,
};

fn observer(selection: &Selection<'_>) -> anyhow::Result<FreePaths> {
    let (group, bins) = (selection.group, selection.whole("bins"));
    Ok(match selection.given(range::MAX) {
        Some(longest) => FreePaths::new(group, longest, bins)?,
        None => FreePaths::adaptive(group, bins),
    })
}

impl Measured for Known<FreePaths, Option<Billiard>> {
    /// The mean, then the share of the complete flights outside the range.
    fn sums(&self) -> Vec<[f64; 2]> {
        vec![
            self.observer.sums(),
            range::outside(self.observer.lengths()),
        ]
    }

    fn distributions(&self) -> Vec<Vec<&AdaptiveHistogram>> {
        vec![vec![self.observer.lengths()]]
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let lengths = self.observer.lengths();
        let (means, densities) = means.split_at(means.len().min(2));
        let caption = format!(
            "Complete flights from contact to contact, in the frame of the box; the mean free path is \
             the path of all bodies over their contacts, with the flights that the start or the end cuts. {}",
            range::caption(&[lengths])
        );
        let table = Table::new(context.table("free-path"), "Distribution of free paths")
            .bins("length", "length", lengths.bins().edges())
            .means("density", "1/length", densities)
            .caption(caption);
        let exact = self
            .facts
            .as_ref()
            .and_then(Billiard::mean_free_path)
            .filter(|_| context.is_equilibrium);
        let prediction = context.gas().map(HardDiscs::mean_free_path);
        let figure = |mean: &BlockMean| {
            let figure = context.figure("mean free path", "length", mean)?;
            Some(match exact {
                Some(exact) => figure.predicted(exact, SANTALO).test(),
                None => figure.predicted(prediction, ENSKOG),
            })
        };
        let outside = range::share_outside(lengths, "free paths", means.get(1), context);
        let figures = means
            .first()
            .and_then(figure)
            .into_iter()
            .chain(outside)
            .collect();
        Results {
            tables: vec![table],
            figures,
            ..Results::default()
        }
    }
}
