//! `free-path`: lengths of the flights of a group between contacts.

use carom::observers::FreePaths;
use carom_tables::{BlockMean, Table};

use super::{
    Context, Default, HardDiscs, Kind, Measured, Of, Parameter, Results, Selection, Span, hard_discs::ENSKOG,
    in_blocks, resumed,
};

/// Longest path in the histogram, in mean free paths of a dilute gas of the group's density.
const LONGEST: f64 = 6.0;

pub(super) const KIND: Kind = Kind {
    name: "free-path",
    summary: "distribution of the path lengths between successive contacts",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[
        Parameter::whole("bins", Default::Number(120.0), "bins of the histogram"),
        Parameter::positive(
            "max",
            Default::FromScene("6 mean free paths when dilute"),
            "longest path (length)",
        ),
    ],
    begin: |selection| {
        Ok(in_blocks(FreePaths::new(selection.group, longest(selection), selection.whole("bins"))?))
    },
    resume: resumed::<FreePaths>,
};

fn longest(selection: &Selection<'_>) -> f64 {
    if let Some(given) = selection.given("max") {
        return given;
    }
    let bounds = selection.view.bounds();
    let density = selection.moving().count().max(1) as f64 / bounds.area();
    let radii = selection.moving().map(|body| body.body.molecule().bounding_radius());
    let diameter = 2.0 * radii.fold(0.0, f64::max);
    let free_path = 1.0 / (8f64.sqrt() * density * diameter);
    // At most some sides of the box, for few or very small bodies.
    (LONGEST * free_path).min(LONGEST * bounds.sides().max_element())
}

impl Measured for FreePaths {
    /// The mean, then the density in each bin.
    fn sums(&self) -> Vec<[f64; 2]> {
        self.sums()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let (mean, densities) = means.split_at(means.len().min(1));
        let lengths = self.lengths();
        let table = Table::new(context.table("free-path"), "Distribution of free paths")
            .abscissa("length", "length", (0..densities.len()).map(|bin| lengths.centre(bin)).collect())
            .means("density", "1/length", densities)
            .caption("Flights from contact to contact, in the frame of the box.");
        let prediction = context.gas().map(HardDiscs::mean_free_path);
        let figure = |mean: &BlockMean| {
            Some(context.figure("mean free path", "length", mean)?.predicted(prediction, ENSKOG))
        };
        Results {
            tables: vec![table],
            figures: mean.iter().filter_map(figure).collect(),
            ..Results::default()
        }
    }
}
