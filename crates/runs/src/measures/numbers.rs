//! `numbers`: how many bodies of each tag there are at each sample, and how 1/n grows.

use carom::observers::{BodyNumbers, NumberPoint};
use carom_tables::{BlockMean, Figure, Table};

use super::{
    Context, Default, MeasureKind, Measured, Of, Parameter, Results, Selection, Span, in_blocks,
    resumed,
};
use serde::{Deserialize, Serialize};

/// What is drawn over the time.
const DRAW: &str = "draw";

/// The power of the time drawn beside the curve.
const EXPONENT: &str = "exponent";

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "numbers",
    summary: "number of bodies of a group at each sample, and of each tag without one; 1/n of the number density \
              n, and its growth by time and by contact",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[
        Parameter::word(
            DRAW,
            &["number", "inverse"],
            Default::FromScene("number"),
            "the number, or 1/n beside its growth by the contacts",
        ),
        Parameter::positive(
            EXPONENT,
            Default::FromScene("none"),
            "ξ of a decay t^−ξ drawn beside the number, by logarithms",
        ),
    ],
    figures: &[
        "number of bodies at the end",
        "rate constant of 1/n",
        "rate constant of the contacts",
        "change of 1/n for each contact",
        "exponent of the decay",
    ],
    start: |selection| Ok(in_blocks(Numbers::new(selection))),
    resume: resumed::<Numbers>,
};

/// Numbers of bodies, and how they are drawn.
#[derive(Serialize, Deserialize)]
struct Numbers {
    observer: BodyNumbers,
    draws_inverse: bool,
    exponent: Option<f64>,
}

impl Numbers {
    fn new(selection: &Selection<'_>) -> Self {
        Self {
            observer: BodyNumbers::new(selection.group, selection.view),
            draws_inverse: selection.given_word(DRAW) == Some("inverse"),
            exponent: selection.given(EXPONENT),
        }
    }

    /// 1/n at each sample (length²); none without a body.
    fn inverse_densities(&self) -> Vec<Option<f64>> {
        let area = self.observer.area();
        let points = self.observer.series().iter();
        points
            .map(|point| (point.number > 0.0).then(|| area / point.number))
            .collect()
    }

    /// 1/n as it grows from the first sample on if a constant share of the contacts acts on it
    /// (length²).
    fn by_contacts(&self, share: f64) -> Vec<Option<f64>> {
        let points = self.observer.series();
        let mut value = self.inverse_densities().first().copied().flatten();
        let mut all = vec![value];
        for pair in points.windows(2) {
            let has_bodies = pair.iter().all(|point| point.number > 0.0);
            let integral = self.observer.contact_integral([&pair[0], &pair[1]]);
            value = value
                .filter(|_| has_bodies)
                .map(|before| before + share * integral);
            all.push(value);
        }
        all.truncate(points.len());
        all
    }

    fn table(&self, share: Option<f64>, context: &Context<'_>) -> Table {
        let points = self.observer.series();
        let of = |part: fn(&NumberPoint) -> f64| points.iter().map(part).collect::<Vec<f64>>();
        let mut table = Table::new(context.table("numbers"), "Number of bodies").abscissa(
            "time",
            "time",
            of(|point| point.time),
        );
        let numbers = of(|point| point.number);
        if self.draws_inverse {
            table = table.undrawn("number", "1", numbers).value(
                "inverse_density",
                "length²",
                self.inverse_densities(),
            );
            if let Some(share) = share {
                table = table.prediction(
                    "by the contacts",
                    self.by_contacts(share),
                    "the contacts between the samples, at the mean share",
                );
            }
        } else {
            table = table.value("number", "1", numbers.into_iter().map(Some).collect());
            for (name, numbers) in self.observer.by_tag() {
                let numbers = numbers.into_iter().map(Some).collect();
                table = table.value(&format!("number_{name}"), "1", numbers);
            }
        }
        table = table.counts(
            "contacts",
            points.iter().map(|p| p.contacts as u64).collect(),
        );
        if let Some(exponent) = self.exponent.filter(|_| !self.draws_inverse) {
            table = table.logarithmic().in_decades(&["number"]).guide(
                "number",
                -exponent,
                &format!("∝ t^−{exponent}"),
                true,
            );
        }
        table.caption(
            "Contacts are those between two bodies of the group since the first sample. n is the number by the area \
             of the box. Where both bodies leave at a share p of their contacts, 1/n grows by p for each contact of a \
             body: in proportion to time as long as the temperature is constant.",
        )
    }
}

impl carom::Observer for Numbers {
    fn watches(&self, bodies: [&carom::engine::Body; 2]) -> bool {
        self.observer.watches(bodies)
    }

    fn collision(&mut self, report: &carom::CollisionReport<'_>) {
        self.observer.collision(report);
    }

    fn sample(&mut self, view: &carom::View<'_>) {
        self.observer.sample(view);
    }
}

impl Measured for Numbers {
    fn sums(&self) -> Vec<[f64; 2]> {
        self.observer.sums()
    }

    fn bytes_per_sample(&self) -> usize {
        self.observer.bytes_per_sample()
    }

    fn present(&self) -> Vec<(&'static str, Option<f64>)> {
        let last = self.observer.series().last();
        vec![("number", last.map(|point| point.number))]
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let share = means.get(2).and_then(|mean| mean.value);
        let at_end = self.observer.series().last().map(|point| {
            let name = context.named("number of bodies at the end");
            Figure::new(name, point.number, "1")
        });
        let names = [
            ("rate constant of 1/n", "length²/time"),
            ("rate constant of the contacts", "length²/time"),
            ("change of 1/n for each contact of a body", "1"),
            ("exponent of the decay", "1"),
        ];
        let figures = names
            .into_iter()
            .zip(means)
            .filter_map(|((name, unit), mean)| context.figure(name, unit, mean));
        Results {
            tables: vec![self.table(share, context)],
            figures: at_end.into_iter().chain(figures).collect(),
            ..Results::default()
        }
    }
}
