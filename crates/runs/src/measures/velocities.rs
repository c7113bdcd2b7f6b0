//! `velocities`: distributions of velocity components and speeds, and their approach to Maxwell's.

use carom::{
    Observer, VelocityDistribution, View,
    observers::{Histogram, VelocityPoint},
};
use carom_tables::{BlockMean, Figure, Table};
use serde::{Deserialize, Serialize};

use super::{Context, Default, Kind, Measured, Of, Parameter, Results, Selection, Span, in_blocks, resumed};

const MAXWELL: &str = "Maxwell's distribution";

pub(super) const KIND: Kind = Kind {
    name: "velocities",
    summary: "distributions of velocity components and speeds, kurtosis and Boltzmann's H",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[Parameter::whole(
        "bins",
        Default::Number(60.0),
        "bins of the speeds; components have twice as many",
    )],
    begin: |selection| Ok(in_blocks(Velocities::new(selection))),
    resume: resumed::<Velocities>,
};

/// The velocities of a group.
#[derive(Serialize, Deserialize)]
struct Velocities {
    distribution: VelocityDistribution,
    /// Sum of the kurtosis over the samples, and their number.
    kurtosis: [f64; 2],
    /// Whether all bodies have the same mass, so that Maxwell's distribution is one Gaussian.
    has_one_mass: bool,
}

impl Velocities {
    fn new(selection: &Selection<'_>) -> Self {
        let mut masses = selection.moving().map(|body| body.body.molecule().mass());
        let first = masses.next();
        Self {
            distribution: VelocityDistribution::adaptive(selection.group, selection.whole("bins")),
            kurtosis: [0.0; 2],
            has_one_mass: masses.all(|mass| Some(mass) == first),
        }
    }

    /// Why Maxwell's distribution does not apply.
    fn is_not_maxwellian(&self, context: &Context<'_>) -> Option<&'static str> {
        if !self.has_one_mass {
            return Some("the bodies have different masses");
        }
        (!context.is_elastic).then_some("contacts are not elastic")
    }
}

impl Observer for Velocities {
    fn watches_any(&self) -> bool {
        false
    }

    fn start(&mut self, view: &View<'_>) {
        self.distribution.start(view);
    }

    fn sample(&mut self, view: &View<'_>) {
        let before = self.distribution.series().len();
        self.distribution.sample(view);
        for point in &self.distribution.series()[before..] {
            self.kurtosis[0] += point.kurtosis;
            self.kurtosis[1] += 1.0;
        }
    }
}

impl Measured for Velocities {
    /// The kurtosis; then the density in each bin of x, y and the speeds.
    fn sums(&self) -> Vec<[f64; 2]> {
        let Some(([x, y], speeds)) = self.distribution.components().zip(self.distribution.speeds()) else {
            return vec![self.kurtosis];
        };
        let of = |histogram: &Histogram| {
            let (width, total) = (histogram.width(), histogram.total() as f64);
            histogram.counts().iter().map(|&count| [count as f64 / width, total]).collect::<Vec<_>>()
        };
        [vec![self.kurtosis], of(x), of(y), of(speeds)].concat()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let (kurtosis, densities) = means.split_at(means.len().min(1));
        let reason = self.is_not_maxwellian(context);
        let mut tables = vec![series(&self.distribution, reason, context)];
        if let Some(([x, _], speeds)) = self.distribution.components().zip(self.distribution.speeds()) {
            let bins = x.counts().len().min(densities.len() / 2);
            let (components, of_speeds) = densities.split_at(2 * bins);
            tables.push(self.components(x, [&components[..bins], &components[bins..]], reason, context));
            tables.push(self.speeds(speeds, of_speeds, reason, context));
        }
        let figures = kurtosis.iter().filter_map(|mean| self.kurtosis_figure(mean, context)).collect();
        Results { tables, figures, ..Results::default() }
    }
}

impl Velocities {
    /// Distribution of the components, with the Gaussian of their variance.
    fn components(
        &self,
        histogram: &Histogram,
        [x, y]: [&[BlockMean]; 2],
        reason: Option<&str>,
        context: &Context<'_>,
    ) -> Table {
        let variance = self.variance();
        let gaussian = |v: f64| (-v * v / (2.0 * variance)).exp() / (std::f64::consts::TAU * variance).sqrt();
        let name = context.table("velocity-components");
        let table = Table::new(name, "Distribution of velocity components")
            .abscissa("velocity", "length/time", centres(histogram))
            .means("density_x", "time/length", x)
            .means("density_y", "time/length", y);
        if let Some(reason) = reason {
            return table.caption(format!("No prediction: {reason}."));
        }
        let values = centres(histogram).into_iter().map(|v| Some(gaussian(v))).collect();
        table.prediction("Gaussian of the same variance", values, MAXWELL)
    }

    /// Distribution of the speeds, with Maxwell's of the same mean square.
    fn speeds(
        &self,
        histogram: &Histogram,
        means: &[BlockMean],
        reason: Option<&str>,
        context: &Context<'_>,
    ) -> Table {
        let variance = self.variance();
        let maxwell = |v: f64| v / variance * (-v * v / (2.0 * variance)).exp();
        let table = Table::new(context.table("speeds"), "Distribution of speeds")
            .abscissa("speed", "length/time", centres(histogram))
            .means("density", "time/length", means);
        if let Some(reason) = reason {
            return table.caption(format!("No prediction: {reason}."));
        }
        let values = centres(histogram).into_iter().map(|v| Some(maxwell(v))).collect();
        table.prediction("m v/kT exp(−m v²/2kT)", values, MAXWELL)
    }

    /// Variance of one component over the whole run (length² / time²).
    fn variance(&self) -> f64 {
        let series = self.distribution.series();
        let sum: f64 = series.iter().map(|point| 0.5 * point.mean_square).sum();
        sum / series.len().max(1) as f64
    }

    /// The mean kurtosis. Its prediction is that of fixed energy and momentum, 2 (N − 1)/N.
    fn kurtosis_figure(&self, kurtosis: &BlockMean, context: &Context<'_>) -> Option<Figure> {
        let figure = context.figure("kurtosis of the velocities ⟨v⁴⟩/⟨v²⟩²", "1", kurtosis)?;
        let bodies = self.distribution.series().last()?.bodies;
        let is_all = context.hard_discs.as_ref().is_ok_and(|gas| gas.count == bodies);
        let count = bodies as f64;
        let prediction = is_all.then(|| 2.0 * (count - 1.0) / count);
        Some(figure.predicted(prediction, "Maxwell, at fixed energy and momentum"))
    }
}

/// Moments and Boltzmann's H at each sample.
fn series(velocities: &VelocityDistribution, reason: Option<&str>, context: &Context<'_>) -> Table {
    let points = velocities.series();
    let of =
        |value: fn(&VelocityPoint) -> Option<f64>| -> Vec<Option<f64>> { points.iter().map(value).collect() };
    let name = context.table("velocities");
    let table = Table::new(name, "Moments of the velocities and Boltzmann's H")
        .abscissa("time", "time", points.iter().map(|point| point.time).collect())
        .counts("bodies", points.iter().map(|point| point.bodies as u64).collect())
        .value("mean_square", "length²/time²", of(|point| Some(point.mean_square)))
        .value("kurtosis", "1", of(|point| Some(point.kurtosis)));
    let table =
        if reason.is_some() { table } else { table.prediction("2, Maxwell", of(|_| Some(2.0)), MAXWELL) };
    // A unit of its own: a chart of its own.
    let table = table.value("h_x", "ln(time/length)", of(|point| point.h.map(|h| h.x))).value(
        "h_y",
        "ln(time/length)",
        of(|point| point.h.map(|h| h.y)),
    );
    match reason {
        Some(reason) => table.caption(format!("No prediction: {reason}.")),
        None => table
            .prediction("at equilibrium", of(|point| Some(point.h_at_equilibrium())), "Boltzmann (1872)")
            .caption("H is too high by about the number of occupied bins over twice the number of bodies."),
    }
}

fn centres(histogram: &Histogram) -> Vec<f64> {
    (0..histogram.counts().len()).map(|bin| histogram.centre(bin)).collect()
}
