//! `velocities`: distributions of velocity components and speeds, and their approach to Maxwell's.

use carom::VelocityDistribution;
use carom_tables::{BlockMean, Figure, Table};

use super::{Context, Kind, Measured, Of, Results, in_blocks, resumed};

/// Number of bins for speeds; components have twice as many.
const SPEED_BINS: usize = 60;

const MAXWELL: &str = "Maxwell's distribution";

pub(super) const KIND: Kind = Kind {
    name: "velocities",
    summary: "distributions of velocity components and speeds, kurtosis and Boltzmann's H",
    of: Of::Group,
    begin: |selection| Ok(in_blocks(VelocityDistribution::adaptive(selection.group, SPEED_BINS))),
    resume: resumed::<VelocityDistribution>,
};

impl Measured for VelocityDistribution {
    /// The kurtosis; then the density in each bin of x, y and the speeds.
    fn sums(&self) -> Vec<[f64; 2]> {
        let Some(([x, y], speeds)) = self.components().zip(self.speeds()) else { return Vec::new() };
        let of = |histogram: &carom::observers::Histogram| {
            let (width, total) = (histogram.width(), histogram.total() as f64);
            histogram.counts().iter().map(|&count| [count as f64 / width, total]).collect::<Vec<_>>()
        };
        let kurtosis = self.series().iter().map(|point| point.kurtosis).sum();
        [vec![[kurtosis, self.series().len() as f64]], of(x), of(y), of(speeds)].concat()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let (kurtosis, means) = means.split_at(means.len().min(1));
        let mut tables = vec![series(self, context.suffix)];
        if let Some(([x, _], speeds)) = self.components().zip(self.speeds()) {
            // kT/m of one component over the whole run.
            let count = self.series().len().max(1) as f64;
            let variance = self.series().iter().map(|point| 0.5 * point.mean_square).sum::<f64>() / count;
            let gaussian =
                |v: f64| (-v * v / (2.0 * variance)).exp() / (std::f64::consts::TAU * variance).sqrt();
            let rayleigh = |v: f64| v / variance * (-v * v / (2.0 * variance)).exp();
            let [in_x, rest] =
                [&means[..x.counts().len().min(means.len())], &means[x.counts().len().min(means.len())..]];
            let (in_y, of_speeds) = rest.split_at(x.counts().len().min(rest.len()));
            let values = |means: &[BlockMean]| means.iter().map(|mean| mean.value).collect();
            let errors = |means: &[BlockMean]| means.iter().map(|mean| mean.standard_error).collect();
            let centres = |histogram: &carom::observers::Histogram| -> Vec<f64> {
                (0..histogram.counts().len()).map(|bin| histogram.centre(bin)).collect()
            };
            let unit = "time/length";
            let predicted = centres(x).into_iter().map(|v| Some(gaussian(v))).collect();
            tables.push(
                Table::new(
                    format!("velocity-components{}", context.suffix),
                    "Distribution of velocity components",
                )
                .abscissa("velocity", "length/time", centres(x))
                .value("density_x", unit, values(in_x))
                .errors(errors(in_x))
                .value("density_y", unit, values(in_y))
                .errors(errors(in_y))
                .prediction("Gaussian of the same variance", predicted, MAXWELL),
            );
            let predicted = centres(speeds).into_iter().map(|v| Some(rayleigh(v))).collect();
            tables.push(
                Table::new(format!("speeds{}", context.suffix), "Distribution of speeds")
                    .abscissa("speed", "length/time", centres(speeds))
                    .value("density", unit, values(of_speeds))
                    .errors(errors(of_speeds))
                    .prediction("m v/kT exp(−m v²/2kT)", predicted, MAXWELL),
            );
        }
        let figures =
            kurtosis.iter().filter_map(|kurtosis| kurtosis_figure(self, kurtosis, context)).collect();
        Results { tables, figures }
    }
}

/// The mean kurtosis. Its prediction is that of fixed energy and momentum, 2 (N − 1)/N.
fn kurtosis_figure(
    velocities: &VelocityDistribution,
    kurtosis: &BlockMean,
    context: &Context<'_>,
) -> Option<Figure> {
    let name = context.named("kurtosis of the velocities ⟨v⁴⟩/⟨v²⟩²");
    let figure = Figure::new(name, kurtosis.value?, "1").error(kurtosis.standard_error);
    let bodies = velocities.series().last()?.bodies;
    let is_all = context.hard_discs.as_ref().is_ok_and(|gas| gas.count == bodies);
    let count = bodies as f64;
    let prediction = 2.0 * (count - 1.0) / count;
    Some(if is_all { figure.predicted(prediction, "Maxwell, at fixed energy and momentum") } else { figure })
}

/// Moments and Boltzmann's H at each sample.
fn series(velocities: &VelocityDistribution, suffix: &str) -> Table {
    let points = velocities.series();
    let of = |value: fn(&carom::observers::VelocityPoint) -> Option<f64>| -> Vec<Option<f64>> {
        points.iter().map(value).collect()
    };
    Table::new(format!("velocities{suffix}"), "Moments of the velocities and Boltzmann's H")
        .abscissa("time", "time", points.iter().map(|point| point.time).collect())
        .counts("bodies", points.iter().map(|point| point.bodies as u64).collect())
        .value("mean_square", "length²/time²", of(|point| Some(point.mean_square)))
        .value("kurtosis", "⟨v²⟩²", of(|point| Some(point.kurtosis)))
        .prediction("2, Maxwell", of(|_| Some(2.0)), MAXWELL)
        .value("h_x", "1", of(|point| point.h.map(|h| h.x)))
        .value("h_y", "1", of(|point| point.h.map(|h| h.y)))
        .prediction("at equilibrium", of(|point| Some(point.h_at_equilibrium())), "Boltzmann (1872)")
        .caption("H is too high by about the number of occupied bins over twice the number of bodies.")
}
