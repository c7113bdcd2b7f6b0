//! `defects`: disclinations, the bodies whose number of neighbours is not six.

use carom::{
    Disclinations,
    observers::{CountedBody, DefectPoint},
};
use carom_tables::{BlockMean, Table};

use super::{
    Context, Drawing, MeasureKind, Measured, Of, Results, Span, in_blocks, point_bytes, resumed,
};

/// Longer side of the drawing (pixels), and the largest number of bodies without defect in it.
const SIZE: f64 = 700.0;
const MAX_DRAWN: usize = 20_000;

/// Least radius of a circle in mean distances: points are seen, too.
const MIN_RADIUS: f64 = 0.2;

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "defects",
    summary: "disclinations: bodies without six neighbours of their Voronoi cells, counted and drawn",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[],
    figures: &[
        "share of disclinations",
        "mean square charge",
        "share of bodies with ",
    ],
    start: |selection| Ok(in_blocks(Disclinations::new(selection.group))),
    resume: resumed::<Disclinations>,
};

impl Measured for Disclinations {
    /// The share of bodies with each number of neighbours, that without six, the squared charge.
    fn sums(&self) -> Vec<[f64; 2]> {
        self.sums()
    }

    fn bytes_per_sample(&self) -> usize {
        point_bytes(self.series())
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        if self.series().is_empty() {
            return Results::default();
        }
        let numbers: Vec<f64> = Self::neighbours().map(|number| number as f64).collect();
        let (shares, rest) = means.split_at(means.len().min(numbers.len()));
        let table = Table::new(
            context.table("defects-neighbours"),
            "Numbers of neighbours",
        )
        .abscissa("neighbours", "1", numbers)
        .means("share", "1", shares)
        .caption("Share of the bodies with so many neighbours; the first and the last hold those beyond.");
        let names = ["share of disclinations", "mean square charge (6 − z)²"];
        let mut figures = context.figures(names.map(|name| (name, "1", None)), rest, "");
        let of_five = Self::neighbours()
            .zip(shares)
            .filter(|(number, _)| [5, 7].contains(number));
        figures.extend(of_five.filter_map(|(number, mean)| {
            context.figure(
                &format!("share of bodies with {number} neighbours"),
                "1",
                mean,
            )
        }));
        Results {
            tables: [series(self.series(), context), table]
                .into_iter()
                .chain(list(self.last(), context))
                .collect(),
            figures,
            drawings: vec![drawing(self, context)],
            ..Results::default()
        }
    }
}

/// The numbers of disclinations at each sample.
fn series(points: &[DefectPoint], context: &Context<'_>) -> Table {
    let of = |part: fn(&DefectPoint) -> u64| points.iter().map(part).collect();
    let charges = points
        .iter()
        .map(|point| Some(point.charge as f64))
        .collect();
    Table::new(context.table("defects"), "Disclinations")
        .abscissa("time", "time", points.iter().map(|point| point.time).collect())
        .counts("five", of(|point| point.five))
        .counts("seven", of(|point| point.seven))
        .counts("others", of(|point| point.others))
        .counts("counted", of(|point| point.counted))
        .value("charge", "1", charges)
        .caption(
            "Bodies with five, seven and other numbers of neighbours than six, out of those counted, which excludes \
             bodies next to walls; the charge is the sum of 6 − z, 0 in a box without walls.",
        )
}

/// The disclinations at the last sample; `None` without any.
fn list(last: &[CountedBody], context: &Context<'_>) -> Option<Table> {
    let found: Vec<&CountedBody> = last.iter().filter(|body| body.charge() != 0).collect();
    let of = |part: fn(&CountedBody) -> f64| found.iter().map(|body| part(body)).collect();
    let table = Table::new(
        context.table("defects-list"),
        "Disclinations at the last sample",
    )
    .abscissa("body", "1", of(|body| body.id as f64))
    .undrawn("x", "length", of(|body| body.place.x))
    .undrawn("y", "length", of(|body| body.place.y))
    .undrawn(
        "neighbours",
        "1",
        of(|body| body.neighbours.unwrap_or(0) as f64),
    )
    .undrawn("charge", "1", of(|body| body.charge() as f64))
    .caption("The number of each body, its centre of mass, its neighbours z, and 6 − z.");
    (!found.is_empty()).then_some(table)
}

/// The bodies at the last sample, with the disclinations by colour.
fn drawing(defects: &Disclinations, context: &Context<'_>) -> Drawing {
    let [width, height] = defects.sides().to_array();
    let scale = SIZE / width.max(height);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.3}\" height=\"{1:.3}\" viewBox=\"0 0 {0:.3} \
         {1:.3}\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\" stroke=\"black\"/>\n",
        width * scale,
        height * scale
    );
    let least = MIN_RADIUS * (width * height / defects.last().len().max(1) as f64).sqrt();
    let is_drawn = |body: &&CountedBody| body.charge() != 0 || defects.last().len() <= MAX_DRAWN;
    for body in defects.last().iter().filter(is_drawn) {
        let (x, y) = (body.place.x * scale, (height - body.place.y) * scale);
        let (radius, colour) = (body.radius.max(least) * scale, colour(body));
        let circle =
            format!("<circle cx=\"{x:.3}\" cy=\"{y:.3}\" r=\"{radius:.3}\" fill=\"{colour}\"/>\n");
        svg.push_str(&circle);
    }
    for [from, to] in defects
        .walls()
        .iter()
        .map(|ends| ends.map(|end| end * scale))
    {
        let [low, high] = [from.y, to.y].map(|y| height * scale - y);
        let line = format!(
            "<line x1=\"{:.3}\" y1=\"{low:.3}\" x2=\"{:.3}\" y2=\"{high:.3}\" stroke=\"black\"/>\n",
            from.x, to.x
        );
        svg.push_str(&line);
    }
    svg.push_str("</svg>\n");
    Drawing {
        file: context.label.file("defects.svg"),
        caption: "The bodies at the last sample by the number of their neighbours: five red, seven blue, fewer \
                  purple, more green, six light grey, and dark grey next to walls."
            .to_owned(),
        svg,
    }
}

/// The colour of a body by its number of neighbours (colours that colour-blind readers can
/// distinguish, Okabe & Ito 2008).
fn colour(body: &CountedBody) -> &'static str {
    match body.neighbours {
        None => "#4d4d4d",
        Some(0..=4) => "#cc79a7",
        Some(5) => "#d55e00",
        Some(6) => "#dddddd",
        Some(7) => "#0072b2",
        Some(_) => "#009e73",
    }
}
