//! `crossings`: how many centres cross a segment, how often, for the first time, and where.

use std::f64::consts::TAU;

use anyhow::Result;
use carom::observers::{CrossingPoint, Crossings};
use carom_tables::{BlockMean, Sums, Table};

use super::{
    Context, Default, Label, MeasureKind, Measured, Of, Parameter, Results, Selection, Span,
    in_blocks, known::Known, point_bytes, resumed,
};
use crate::{
    append_file::AppendFiles,
    curves::{Coefficient, Reading},
    series::CROSSINGS,
};

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "crossings",
    summary: "crossings of a segment by the centres of a group: flux to both sides, energy, first passages; on request \
              each of them",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[
        Parameter::point(
            START,
            Default::FromScene("the middle of the lower side of the box"),
            "where the segment begins (length)",
        ),
        Parameter::point(
            END,
            Default::FromScene("the middle of the upper side of the box"),
            "where the segment ends (length); forward is to the left of its direction",
        ),
        Parameter::word(
            RECORD,
            &["none", "all"],
            Default::FromScene("none"),
            "all: writes each crossing to a file (0.1 kB), with its place and velocity: a Poincaré section",
        ),
    ],
    figures: &[
        "crossings forward",
        "crossings backward",
        "net crossings",
        "net energy through the segment",
        "rate of first passages",
    ],
    start: |selection| {
        Ok(in_blocks(Known {
            observer: observer(selection)?,
            facts: share(selection),
        }))
    },
    resume: resumed::<CrossingsOfGroup>,
};

/// The crossings, and the share of the group in the moving bodies; `None` if they drift as a whole.
type CrossingsOfGroup = Known<Crossings, Option<f64>>;

/// The mean velocity of a gas at rest, in units of the root of the mean square.
const AT_REST: f64 = 1e-9;

fn share(selection: &Selection<'_>) -> Option<f64> {
    let view = selection.view;
    let moving = || view.bodies().filter(|body| body.body.is_free());
    let count = moving().count() as f64;
    let square: f64 = moving()
        .map(|body| body.motion.velocity.length_squared())
        .sum();
    let drift = view.centre_of_mass_frame().velocity().length();
    (drift * drift * count <= AT_REST * AT_REST * square)
        .then(|| selection.moving().count() as f64 / count)
}

const START: &str = "start";
const END: &str = "end";
const RECORD: &str = "record";

fn observer(selection: &Selection<'_>) -> Result<Crossings> {
    let sides = selection.view.bounds().sides();
    let points = [
        selection.given_point(START).unwrap_or([0.5 * sides.x, 0.0]),
        selection
            .given_point(END)
            .unwrap_or([0.5 * sides.x, sides.y]),
    ];
    let crossings = Crossings::new(selection.group, points)?;
    Ok(match selection.given_word(RECORD) {
        Some("all") => crossings.logged(),
        _ => crossings,
    })
}

/// The place of the first passages among the sums.
const FIRST_PASSAGES: usize = 4;

/// The rate of first passages, which merged runs have from the sums of all.
fn rate_of_first_passages(context: &Context<'_>) -> Coefficient {
    Coefficient::new(
        ("rate of first passages", "1/time"),
        (Reading::EventRate, 1.0),
        FIRST_PASSAGES,
        &[],
        context.of_curves(),
    )
}

/// Source of the flux.
const KINETIC: &str = "kinetic theory: n √(kT/2πm) for each unit of length";

impl Measured for CrossingsOfGroup {
    const OF_INTERVALS: bool = true;

    fn sums(&self) -> Sums {
        self.observer.sums().to_vec()
    }

    fn bytes_per_sample(&self) -> usize {
        point_bytes(self.observer.series())
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let crossings = &self.observer;
        // Velocities relative to the centre of mass have the variance (1 − 1/N) kT/m.
        let flux = context.gas().zip(self.facts).map(|(gas, share)| {
            let count = gas.count as f64;
            let variance = (1.0 - 1.0 / count) * gas.temperature / gas.mass;
            share * crossings.length() * count / gas.area * (variance / TAU).sqrt()
        });
        let zero = flux.map(|_| 0.0);
        let rows = [
            ("crossings forward", "1/time", flux),
            ("crossings backward", "1/time", flux),
            ("net crossings", "1/time", zero),
            ("net energy through the segment", "mass·length²/time³", zero),
        ];
        let figures = rows
            .into_iter()
            .zip(means)
            .filter_map(|((name, unit, prediction), mean)| {
                Some(
                    context
                        .figure(name, unit, mean)?
                        .predicted(prediction, KINETIC),
                )
            });
        let is_recorded = crossings.is_logged();
        Results {
            tables: vec![series(crossings, context)],
            figures: figures.collect(),
            coefficients: vec![rate_of_first_passages(context)],
            files: is_recorded
                .then(|| context.label.file(CROSSINGS.name))
                .into_iter()
                .collect(),
            ..Results::default()
        }
    }

    fn append(&mut self, files: &mut AppendFiles, label: &Label) -> Result<()> {
        let crossings = &mut self.observer;
        if !crossings.is_logged() {
            return Ok(());
        }
        files.append_new_to(&label.file(CROSSINGS.name), &CROSSINGS, &crossings.take())
    }
}

/// The crossings up to each sample.
fn series(crossings: &Crossings, context: &Context<'_>) -> Table {
    let points = crossings.series();
    let of = |part: fn(&CrossingPoint) -> u64| {
        let counts = points.iter().map(|point| Some(part(point) as f64));
        counts.collect()
    };
    Table::new(context.table("crossings"), "Crossings of the segment")
        .abscissa(
            "time",
            "time",
            points.iter().map(|point| point.time).collect(),
        )
        .value("forward", "1", of(|point| point.counts[0]))
        .value("backward", "1", of(|point| point.counts[1]))
        .value("waiting", "1", of(|point| point.waiting))
        .caption(caption(crossings))
}

/// What the table of crossings needs to be read.
fn caption(crossings: &Crossings) -> String {
    let left_out = match crossings.left_out() {
        0 => String::new(),
        flights => format!(" {flights} flights through more than a million boxes are left out."),
    };
    format!(
        "Crossings so far by centres of mass, to the left of the direction of the segment and to the right, and the \
         bodies that have not crossed yet. The rate of first passages is their number over the time that all bodies \
         waited.{left_out}"
    )
}
