//! `velocities`: distributions of velocity components and speeds, and their approach to Maxwell's.

use carom::{
    Observer, VelocityDistribution, View,
    observers::{AdaptiveHistogram, Bins, VelocityPoint},
};
use carom_tables::{BlockMean, Estimate, Figure, Table, chi_square::ChiSquare};
use serde::{Deserialize, Serialize};

use super::{
    Context, Default, MeasureKind, Measured, Of, Parameter, Results, Selection, Span, in_blocks,
    point_bytes, range, resumed,
};

const MAXWELL: &str = "Maxwell's distribution";

/// Bins in which fewer speeds are expected are joined: χ² holds for many counts in each bin.
const MIN_EXPECTED: f64 = 10.0;

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "velocities",
    summary: "distributions of velocity components and speeds, kurtosis and Boltzmann's H",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[
        Parameter::whole(
            "bins",
            Default::Number(60.0),
            "bins of the speeds; components have twice as many",
        ),
        Parameter::positive(
            range::MAX,
            range::FOLLOWS,
            "largest speed and component in the bins (length/time)",
        ),
    ],
    figures: &[
        "kurtosis of the velocit",
        "largest rise of H_x",
        "χ² of the speeds",
        "share of the",
    ],
    start: |selection| Ok(in_blocks(Velocities::new(selection)?)),
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
    /// Degrees of freedom of the whole system at the start, if both components of the velocity of a
    /// body have one variance, and no wells exchange energy with them.
    freedom: Option<f64>,
}

/// Places of quantities among the sums.
const KURTOSIS: usize = 0;
const SQUARES: usize = 1;
const FOURTH_POWERS: usize = 2;
const COMPONENTS_OUTSIDE: usize = 3;
const SPEEDS_OUTSIDE: usize = 4;

impl Velocities {
    fn new(selection: &Selection<'_>) -> anyhow::Result<Self> {
        let mut masses = selection.moving().map(|body| body.body.molecule().mass());
        let first = masses.next();
        let (group, bins) = (selection.group, selection.whole("bins"));
        let distribution = match selection.given(range::MAX) {
            Some(largest) => VelocityDistribution::new(group, largest, bins)?,
            None => VelocityDistribution::adaptive(group, bins),
        };
        let frame = selection.view.centre_of_mass_frame();
        let [along_x, along_y] = frame.conserves_momentum();
        let freedom = frame.thermal(selection.view.bodies()).degrees_of_freedom;
        Ok(Self {
            distribution,
            kurtosis: [0.0; 2],
            has_one_mass: masses.all(|mass| Some(mass) == first),
            freedom: (along_x == along_y && !selection.view.has_wells()).then_some(freedom),
        })
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
            if let Some(kurtosis) = point.kurtosis {
                self.kurtosis[0] += kurtosis;
                self.kurtosis[1] += 1.0;
            }
        }
    }
}

impl Measured for Velocities {
    /// The kurtosis of a sample, v² and v⁴, the shares of components and speeds outside the range.
    fn sums(&self) -> Vec<[f64; 2]> {
        let moments = self.distribution.moments();
        let [x, y] = self
            .distribution
            .components()
            .each_ref()
            .map(range::outside);
        vec![
            self.kurtosis,
            [moments.squares, moments.count],
            [moments.fourth_powers, moments.count],
            [x[0] + y[0], x[1] + y[1]],
            range::outside(self.distribution.speeds()),
        ]
    }

    /// The components along x and y, then the speeds.
    fn distributions(&self) -> Vec<Vec<&AdaptiveHistogram>> {
        vec![
            self.distribution.components().iter().collect(),
            vec![self.distribution.speeds()],
        ]
    }

    fn bytes_per_sample(&self) -> usize {
        point_bytes(self.distribution.series())
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let (sums, densities) = means.split_at(means.len().min(SPEEDS_OUTSIDE + 1));
        let reason = self.is_not_maxwellian(context);
        let mut tables = vec![series(&self.distribution, reason, context)];
        let [x, y] = self.distribution.components();
        let (components, speeds) = (
            AdaptiveHistogram::common_bins(&[x, y]),
            self.distribution.speeds().bins(),
        );
        if densities.len() == 2 * components.count() + speeds.count() {
            let (of_components, of_speeds) = densities.split_at(2 * components.count());
            tables.push(self.components(&components, of_components, reason, context));
            tables.push(self.speeds(&speeds, of_speeds, reason, context));
        }
        let kurtosis = match self.bodies() {
            Some(1) => self.kurtosis_over_time(context),
            _ => sums
                .get(KURTOSIS)
                .and_then(|mean| self.kurtosis_figure(mean, context)),
        };
        let outside = [
            range::share_outside(
                x,
                "velocity components",
                sums.get(COMPONENTS_OUTSIDE),
                context,
            ),
            range::share_outside(
                self.distribution.speeds(),
                "speeds",
                sums.get(SPEEDS_OUTSIDE),
                context,
            ),
        ];
        let figures = kurtosis
            .into_iter()
            .chain(self.rise(context))
            .chain(self.speed_test(context));
        Results {
            tables,
            figures: figures.chain(outside.into_iter().flatten()).collect(),
            ..Results::default()
        }
    }
}

impl Velocities {
    /// Distribution of the components, with the means over the bins of the Gaussian of their
    /// variance.
    fn components(
        &self,
        bins: &Bins,
        means: &[BlockMean],
        reason: Option<&str>,
        context: &Context<'_>,
    ) -> Table {
        let width = (2.0 * self.variance()).sqrt();
        let (x, y) = means.split_at(bins.count());
        let [along_x, along_y] = self.distribution.components();
        let words = range::caption(&[along_x, along_y]);
        let name = context.table("velocity-components");
        let table = Table::new(name, "Distribution of velocity components")
            .bins("velocity", "length/time", bins.edges())
            .means("density_x", "time/length", x)
            .means("density_y", "time/length", y);
        if let Some(reason) = reason {
            return table.caption(format!("No prediction: {reason}. {words}"));
        }
        let values = bins
            .means_of(|v| 0.5 * libm::erf(v / width))
            .into_iter()
            .map(Some)
            .collect();
        table
            .prediction("Gaussian of the same variance", values, MAXWELL)
            .caption(words)
    }

    /// Distribution of the speeds, with the means over the bins of Maxwell's of the same mean
    /// square.
    fn speeds(
        &self,
        bins: &Bins,
        means: &[BlockMean],
        reason: Option<&str>,
        context: &Context<'_>,
    ) -> Table {
        let variance = self.variance();
        let words = range::caption(&[self.distribution.speeds()]);
        let table = Table::new(context.table("speeds"), "Distribution of speeds")
            .bins("speed", "length/time", bins.edges())
            .means("density", "time/length", means);
        if let Some(reason) = reason {
            return table.caption(format!("No prediction: {reason}. {words}"));
        }
        let above = |v: f64| -libm::exp(-v * v / (2.0 * variance));
        let values = bins.means_of(above).into_iter().map(Some).collect();
        table
            .prediction("m v/kT exp(−m v²/2kT)", values, MAXWELL)
            .caption(words)
    }

    /// Number of bodies at the last sample.
    fn bodies(&self) -> Option<usize> {
        self.distribution.series().last().map(|point| point.bodies)
    }

    /// ⟨v⁴⟩/⟨v²⟩² of a single body, whose speeds at all times are one distribution. At equilibrium
    /// the squares of all f velocities of the system, weighted with their masses, have one sum, and
    /// the share of two of them has the density ∝ (1 − x)^(f/2 − 2): 2f/(f + 2).
    fn kurtosis_over_time(&self, context: &Context<'_>) -> Option<Figure> {
        let moments = self.distribution.moments();
        let kurtosis = moments.kurtosis()?;
        let mean_square = moments.squares / moments.count;
        // The first order of its change with both moments: K (1 + δ⟨v⁴⟩/⟨v⁴⟩ − 2 δ⟨v²⟩/⟨v²⟩).
        let of_block = |sums: &Vec<[f64; 2]>| {
            let [[squares, count], [fourth_powers, _]] =
                [SQUARES, FOURTH_POWERS].map(|place| sums.get(place).copied().unwrap_or_default());
            let change = fourth_powers / mean_square - 2.0 * kurtosis * squares;
            [change / mean_square + 2.0 * kurtosis * count, count]
        };
        let blocks: Vec<[f64; 2]> = context.blocks.iter().map(of_block).collect();
        let error = Estimate::of_runs(&[blocks]).map(|estimate| estimate.standard_error);
        let prediction = self
            .freedom
            .filter(|_| context.is_equilibrium)
            .map(|f| 2.0 * f / (f + 2.0));
        let name = context.named("kurtosis of the velocity over time ⟨v⁴⟩/⟨v²⟩²");
        let figure = Figure::new(name, kurtosis, "1").error(error);
        Some(figure.predicted(prediction, "Maxwell, at fixed energy of the whole system"))
    }

    /// Variance of one component over the whole run (length² / time²).
    fn variance(&self) -> f64 {
        let moments = self.distribution.moments();
        0.5 * moments.squares / moments.count.max(1.0)
    }

    /// Whether the group is the whole of a gas to which theory applies.
    fn is_microcanonical(&self, context: &Context<'_>) -> bool {
        context
            .gas()
            .is_some_and(|gas| Some(gas.count) == self.bodies())
    }

    /// By how much H_x exceeds an earlier value at most.
    fn rise(&self, context: &Context<'_>) -> Option<Figure> {
        let mut values = self
            .distribution
            .series()
            .iter()
            .filter_map(|point| Some(point.h?.x));
        let first = values.next()?;
        let rise = |(lowest, rise): (f64, f64), h: f64| (h.min(lowest), rise.max(h - lowest));
        let (_, rise) = values.fold((first, 0.0), rise);
        Some(Figure::new(context.named("largest rise of H_x"), rise, "1"))
    }

    /// χ² of the speeds against their distribution at fixed energy and momentum, over its degrees
    /// of freedom: the number of bins less two, because the energy is fixed as well as the number.
    /// Samples are correlated, so that it is divided by the mean design effect of the bins: the
    /// variance of a share over that of independent samples (Rao and Scott, J. Am. Stat. Assoc. 76
    /// (1981) 221). Without errors of the shares there is no prediction.
    fn speed_test(&self, context: &Context<'_>) -> Option<Figure> {
        let speeds =
            Some(self.distribution.speeds()).filter(|_| self.is_microcanonical(context))?;
        let (bins, counts) = (speeds.bins(), speeds.counts());
        let edges = bins.edges();
        // Two bodies have one speed.
        let bodies = self
            .distribution
            .series()
            .last()
            .map(|point| point.bodies as f64)
            .filter(|n| *n > 2.0)?;
        let mean_square = 2.0 * self.variance();
        let above = |bin: usize| share_above(edges[bin] * edges[bin] / mean_square, bodies);
        let is_enough = |share: f64| speeds.total() as f64 * share >= MIN_EXPECTED;
        // Joins bins until they expect enough, here and behind; the last has no end.
        let mut starts = vec![0];
        for bin in 1..counts.len() {
            if is_enough(above(starts[starts.len() - 1]) - above(bin)) && is_enough(above(bin)) {
                starts.push(bin);
            }
        }
        let up_to: Vec<u64> = starts
            .iter()
            .map(|&bin| counts[..bin].iter().sum())
            .collect();
        let counts: Vec<u64> = differences(&up_to, speeds.total(), |from, to| to - from);
        let shares: Vec<f64> = starts.iter().map(|&bin| above(bin)).collect();
        let shares: Vec<f64> = differences(&shares, 0.0, |from, to| from - to);
        let test = ChiSquare::new(&counts, &shares);
        let freedom = test.freedom.checked_sub(1).filter(|freedom| *freedom > 0)? as f64;
        let name = context.named("χ² of the speeds over its degrees of freedom");
        let Some([effect, spread]) = self.design_effect(&starts, context) else {
            return Some(Figure::new(name, test.value / freedom, "1"));
        };
        let error = f64::sqrt(2.0 * (1.0 + spread) / freedom);
        let figure = Figure::new(name, test.value / (freedom * effect), "1").error(error);
        Some(figure.predicted(1.0, "Maxwell at fixed energy and momentum"))
    }

    /// Mean of the design effects of joined bins of the speeds, which begin at `starts`, and their
    /// relative variance.
    fn design_effect(&self, starts: &[usize], context: &Context<'_>) -> Option<[f64; 2]> {
        let [along_x, along_y] = self.distribution.components();
        let components = AdaptiveHistogram::common_bins(&[along_x, along_y]).count();
        let bins = self.distribution.speeds().bins();
        let first = SPEEDS_OUTSIDE + 1 + 2 * components;
        let widths: Vec<f64> = bins.edges().windows(2).map(|bin| bin[1] - bin[0]).collect();
        let ends = starts.iter().skip(1).copied().chain([widths.len()]);
        let samples = self.distribution.speeds().total() as f64;
        let effect = |(start, end): (usize, usize)| {
            // A block from before the first value in the later bins has fewer quantities.
            let of_block = |sums: &Vec<[f64; 2]>| {
                let of = |bin: usize| sums.get(first + bin).copied().unwrap_or_default();
                let count = (start..end).map(|bin| of(bin)[0] * widths[bin]).sum();
                [count, of(start)[1]]
            };
            let share = Estimate::of_runs(&[context.blocks.iter().map(of_block).collect()])?;
            // (1 − p) times the variance over p (1 − p)/n.
            let effect = share.standard_error * share.standard_error * samples / share.mean;
            Some(effect).filter(|effect| effect.is_finite() && *effect > 0.0)
        };
        // A bin without a value has no effect of its own.
        let effects: Vec<f64> = starts
            .iter()
            .copied()
            .zip(ends)
            .filter_map(effect)
            .collect();
        let count = effects.len() as f64;
        let mean = effects.iter().sum::<f64>() / (count - 1.0);
        let squares = effects.iter().map(|effect| effect * effect).sum::<f64>() / (count - 1.0);
        Some([mean, (squares / (mean * mean) - 1.0).max(0.0)]).filter(|_| count > 1.0)
    }

    /// The mean kurtosis. Its prediction is that of fixed energy and momentum, 2 (N − 1)/N.
    fn kurtosis_figure(&self, kurtosis: &BlockMean, context: &Context<'_>) -> Option<Figure> {
        let figure = context.figure("kurtosis of the velocities ⟨v⁴⟩/⟨v²⟩²", "1", kurtosis)?;
        let count = self.bodies()? as f64;
        let prediction = self
            .is_microcanonical(context)
            .then(|| 2.0 * (count - 1.0) / count);
        Some(figure.predicted(prediction, "Maxwell, at fixed energy and momentum"))
    }
}

/// The share of N equal bodies with a larger speed than one whose square is `square` times the
/// mean.
///
/// At fixed energy and momentum all states of 2 (N − 1) velocity components with one sum of squares
/// are equally likely, so that the share of one body in that sum has the density ∝ (1 − x)^(N − 3).
fn share_above(square: f64, bodies: f64) -> f64 {
    (1.0 - square / (bodies - 1.0)).max(0.0).powf(bodies - 2.0)
}

/// The differences of neighbours, the last from `end`.
fn differences<T: Copy>(values: &[T], end: T, difference: impl Fn(T, T) -> T) -> Vec<T> {
    let next = values.iter().skip(1).copied().chain([end]);
    values
        .iter()
        .zip(next)
        .map(|(&from, to)| difference(from, to))
        .collect()
}

/// Moments and Boltzmann's H at each sample; the mean square alone for a single body.
fn series(velocities: &VelocityDistribution, reason: Option<&str>, context: &Context<'_>) -> Table {
    let points = velocities.series();
    let of = |value: fn(&VelocityPoint) -> Option<f64>| -> Vec<Option<f64>> {
        points.iter().map(value).collect()
    };
    let name = context.table("velocities");
    let table = Table::new(name, "Moments of the velocities and Boltzmann's H")
        .abscissa(
            "time",
            "time",
            points.iter().map(|point| point.time).collect(),
        )
        .counts(
            "bodies",
            points.iter().map(|point| point.bodies as u64).collect(),
        )
        .value(
            "mean_square",
            "length²/time²",
            of(|point| Some(point.mean_square)),
        );
    if points.iter().all(|point| point.bodies == 1) {
        return table.caption("A single body has no kurtosis and no H at one time.");
    }
    let table = table.value("kurtosis", "1", of(|point| point.kurtosis));
    let table = if reason.is_some() {
        table
    } else {
        table.prediction("2, Maxwell", of(|_| Some(2.0)), MAXWELL)
    };
    // A unit of its own: a chart of its own.
    let table = table
        .value("h_x", "ln(time/length)", of(|point| point.h.map(|h| h.x)))
        .value("h_y", "ln(time/length)", of(|point| point.h.map(|h| h.y)));
    match reason {
        Some(reason) => table.caption(format!("No prediction: {reason}.")),
        None => table
            .prediction("at equilibrium", of(|point| Some(point.h_at_equilibrium())), "Boltzmann (1872)")
            .caption("H is too high by about the number of occupied bins over twice the number of bodies."),
    }
}

#[cfg(test)]
mod tests {
    use super::share_above;

    /// The mean of the square is 1 and that of its square 2 (N − 1)/N, the kurtosis.
    #[test]
    fn speeds_of_few_bodies_have_their_moments() {
        for bodies in [3.0, 5.0, 400.0] {
            let steps = 400_000;
            let width = (bodies - 1.0) / f64::from(steps);
            let squares = (0..steps).map(|step| (f64::from(step) + 0.5) * width);
            // ⟨x⟩ = ∫ P(> x) dx and ⟨x²⟩ = ∫ 2x P(> x) dx.
            let moments = squares.fold([0.0; 2], |[first, second], square| {
                let above = share_above(square, bodies) * width;
                [first + above, second + 2.0 * square * above]
            });
            assert!((moments[0] - 1.0).abs() < 1e-6, "{bodies}: {moments:?}");
            assert!(
                (moments[1] - 2.0 * (bodies - 1.0) / bodies).abs() < 1e-6,
                "{bodies}: {moments:?}"
            );
        }
        assert!((share_above(2.0, 1e9) - f64::exp(-2.0)).abs() < 1e-7);
    }
}
