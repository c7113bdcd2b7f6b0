//! `relaxation`: F_s(k, t), mean squared displacement, α₂(t), Q(t) and χ₄(t) of a group.

use std::f64::consts::{E, TAU};

use anyhow::{Result, ensure};
use carom::{
    StructuralRelaxation,
    observers::{RelaxationPoint, RelaxationScales},
};
use carom_tables::{BlockMean, Figure, Table};

use crate::curves::{MIN_PAIRS, error_of_sum, joined_at};

use super::{
    Context, Default, MAX_LAG, MeasureKind, Measured, Of, Parameter, Results, Selection, Span,
    in_blocks,
    known::Known,
    resumed,
    thermal::{FREE_FLIGHT, Thermal},
};

/// Distance of the overlap in diameters of the largest body: that of the cage in a dense liquid
/// (Lačević et al., J. Chem. Phys. 119 (2003) 7372).
const OVERLAP_DIAMETERS: f64 = 0.3;

/// The wave number of a scattering function.
pub(super) const WAVE_NUMBER: Parameter = Parameter::positive(
    "k",
    Default::FromScene("2π by the diameter of the largest body"),
    "wave number of the scattering function (1/length)",
);

const OVERLAP: Parameter = Parameter::positive(
    "a",
    Default::FromScene("0.3 diameters of the largest body"),
    "distance of the overlap Q (length)",
);

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "relaxation",
    summary: "structural relaxation against the lag: self-intermediate scattering function F_s(k, t), mean squared \
              displacement, non-Gaussian parameter α₂, overlap Q and its susceptibility χ₄",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[WAVE_NUMBER, OVERLAP, MAX_LAG],
    figures: &["relaxation time τ"],
    start: |selection| Ok(in_blocks(relaxation(selection)?)),
    resume: resumed::<Relaxation>,
};

/// Displacements, and the thermal velocities of the group.
type Relaxation = Known<StructuralRelaxation, Thermal>;

fn relaxation(selection: &Selection<'_>) -> Result<Relaxation> {
    let scales = RelaxationScales {
        wave_number: wave_number(selection)?,
        overlap: match selection.given(OVERLAP.name) {
            Some(distance) => distance,
            None => OVERLAP_DIAMETERS * diameter(selection, &OVERLAP)?,
        },
        spacing: selection.interval(),
        longest: selection.longest_lag(),
    };
    let bounds = selection.view.bounds();
    Ok(Known {
        observer: StructuralRelaxation::new(selection.group, &bounds, scales)?,
        facts: Thermal::new(selection),
    })
}

/// The wave number that the scene gives, or that of the largest body (1 / length).
pub(super) fn wave_number(selection: &Selection<'_>) -> Result<f64> {
    match selection.given(WAVE_NUMBER.name) {
        Some(wave_number) => Ok(wave_number),
        None => Ok(TAU / diameter(selection, &WAVE_NUMBER)?),
    }
}

/// The diameter of the largest body, from which a parameter that is not given follows (length).
pub(super) fn diameter(selection: &Selection<'_>, parameter: &Parameter) -> Result<f64> {
    let groups = selection.groups();
    let radii = groups.map(|group| selection.largest_radius(group));
    let diameter = 2.0 * radii[0].max(radii[1]);
    let name = parameter.name;
    ensure!(
        diameter > 0.0,
        "no body of it has a diameter: give '{name}', whose default is {}",
        parameter.default
    );
    Ok(diameter)
}

impl Measured for Relaxation {
    /// F_s at each lag, then ⟨|Δ|²⟩, ⟨|Δ|⁴⟩, Q, and ⟨m²⟩/N of the numbers m of bodies that count
    /// for Q.
    fn sums(&self) -> Vec<[f64; 2]> {
        self.observer.sums()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let mut points = self.observer.points();
        points.retain(|point| point.pairs >= MIN_PAIRS);
        if points.is_empty() {
            return Results::default();
        }
        let scales = self.observer.scales();
        let lags: Vec<f64> = points.iter().map(|point| point.lag).collect();
        let all = self.observer.lags().len();
        let [scattering, squares, fourths, overlaps, counts] =
            [0, 1, 2, 3, 4].map(|index| context.at_lags(means, index, all, &lags));
        let predicted = lags.iter().map(|&lag| {
            let thermal = context.is_equilibrium.then_some(&self.facts)?;
            thermal.scattering(scales.wave_number, lag)
        });
        let table = Table::new(context.table("relaxation"), "Structural relaxation")
            .abscissa("lag", "time", lags.clone())
            .counts("pairs", points.iter().map(|point| point.pairs).collect())
            .means("self_scattering", "1", &scattering)
            .prediction("exp(−k² kT t²/2m)", predicted.collect(), FREE_FLIGHT)
            .means("mean_square_displacement", "length²", &squares)
            .value("non_gaussian", "1", points.iter().map(|point| point.non_gaussian).collect())
            .errors(errors(&points, context, |place| {
                non_gaussian_terms(squares[place], fourths[place])
            }))
            .means("overlap", "1", &overlaps)
            .value("chi_4", "1", points.iter().map(susceptibility).collect())
            .errors(errors(&points, context, |place| {
                susceptibility_terms(&points[place], overlaps[place], counts[place])
            }))
            .logarithmic()
            .in_decades(&["mean_square_displacement"])
            .guide("mean_square_displacement", 2.0, "∝ t²", false)
            .guide("mean_square_displacement", 1.0, "∝ t", true)
            .caption(format!(
                "F_s(k, t) at k = {:.4} (self scattering), α₂ (non Gaussian), the share Q of the bodies that are at most \
                 a = {:.4} from where they were (overlap), and χ₄ = N (⟨Q²⟩ − ⟨Q⟩²), from lags with at least {MIN_PAIRS} \
                 origins.",
                scales.wave_number, scales.overlap
            ));
        let time = time_figure("relaxation time τ of F_s", &lags, &scattering, context);
        Results {
            tables: vec![table],
            figures: time.into_iter().collect(),
            ..Results::default()
        }
    }
}

/// χ₄, where there are enough origins for a variance among them.
fn susceptibility(point: &RelaxationPoint) -> Option<f64> {
    (point.origins >= MIN_PAIRS).then_some(point.susceptibility)
}

/// The standard errors of a function of means at each lag from its derivatives by them.
fn errors(
    points: &[RelaxationPoint],
    context: &Context<'_>,
    terms: impl Fn(usize) -> Option<[(BlockMean, f64); 2]>,
) -> Vec<Option<f64>> {
    let error = |place: usize| {
        let terms = terms(place)?;
        // A lag as long as all joined blocks has no error.
        terms[0].0.standard_error?;
        let joined = joined_at(points[place].lag, context.block);
        error_of_sum(std::slice::from_ref(context.blocks), joined, terms)
    };
    (0..points.len()).map(error).collect()
}

/// The derivatives of α₂ = ⟨|Δ|⁴⟩ / (2 ⟨|Δ|²⟩²) − 1.
fn non_gaussian_terms(square: BlockMean, fourth: BlockMean) -> Option<[(BlockMean, f64); 2]> {
    let (mean, mean_of_fourth) = (square.value.filter(|mean| *mean > 0.0)?, fourth.value?);
    Some([
        (square, -mean_of_fourth / mean.powi(3)),
        (fourth, 0.5 / (mean * mean)),
    ])
}

/// The derivatives of χ₄ = ⟨m²⟩/N − N Q², with the mean number N of bodies.
fn susceptibility_terms(
    point: &RelaxationPoint,
    overlap: BlockMean,
    square: BlockMean,
) -> Option<[(BlockMean, f64); 2]> {
    susceptibility(point)?;
    let bodies = point.pairs as f64 / point.origins as f64;
    Some([(overlap, -2.0 * bodies * overlap.value?), (square, 1.0)])
}

/// The lag at which a correlation that is 1 at lag 0 falls to 1/e, as a figure of this name; `None`
/// if it does not fall so far.
pub(super) fn time_figure(
    name: &str,
    lags: &[f64],
    correlation: &[BlockMean],
    context: &Context<'_>,
) -> Option<Figure> {
    let [time, error] = relaxation_time(lags, correlation)?;
    let figure = Figure::new(context.named(name), time, "time");
    Some(figure.error((error > 0.0).then_some(error)))
}

/// The lag at which F_s falls to 1/e, and its standard error; the error is 0 if it has none. `None`
/// if it does not fall so far.
///
/// Between two lags F_s is taken as exp(−(t/τ)^β), which is exact in free flight (β = 2) and in
/// diffusion (β = 1). Then dF_s/d ln t = −β/e at τ.
fn relaxation_time(lags: &[f64], scattering: &[BlockMean]) -> Option<[f64; 2]> {
    let value = |place: usize| scattering.get(place)?.value;
    let after = (0..scattering.len()).find(|&place| value(place).is_some_and(|f| f * E <= 1.0))?;
    let before = after.checked_sub(1).filter(|before| lags[*before] > 0.0)?;
    let [begin, end] = [before, after].map(|place| {
        let value = value(place)?;
        (value > 0.0 && value < 1.0).then(|| (lags[place].ln(), (-value.ln()).ln()))
    });
    let ((first, low), (last, high)) = (begin?, end?);
    let exponent = (high - low) / (last - first);
    let time = (first - low / exponent).exp();
    let error = [before, after]
        .iter()
        .filter_map(|&place| scattering[place].standard_error)
        .fold(0.0, f64::max);
    (exponent > 0.0 && time.is_finite()).then(|| [time, time * E * error / exponent])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stretched exponentials, whose relaxation time and its error are exact.
    #[test]
    fn the_relaxation_time_of_a_stretched_exponential_is_exact() {
        let lags: Vec<f64> = (0..10).map(|place| 0.3 * f64::from(place)).collect();
        for (time, exponent) in [(1.7, 2.0), (1.0, 1.0), (0.62, 0.5)] {
            let mean = |&lag: &f64| BlockMean {
                value: Some((-f64::powf(lag / time, exponent)).exp()),
                standard_error: Some(0.01),
                quantity: None,
            };
            let means: Vec<BlockMean> = lags.iter().map(mean).collect();
            let [found, error] = relaxation_time(&lags, &means).unwrap();
            assert!((found / time - 1.0).abs() < 1e-12, "{found}");
            assert!((error / (0.01 * E * time / exponent) - 1.0).abs() < 1e-12);
        }
        let constant = [BlockMean {
            value: Some(0.9),
            ..BlockMean::default()
        }; 10];
        assert_eq!(relaxation_time(&lags, &constant), None);
        assert_eq!(relaxation_time(&[], &[]), None);
    }
}
