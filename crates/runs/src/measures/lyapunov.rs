//! `lyapunov`: the Lyapunov exponents of the whole system.

use anyhow::{Result, bail};
use carom::{Scene, engine::ElasticitySpec, observers::LyapunovSpectrum};
use carom_tables::{BlockMean, Sums, Table};

use super::{
    Context, Default, MeasureKind, Measured, Of, Parameter, Results, Span, in_blocks, resumed,
};
use crate::schedule::stages;

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "lyapunov",
    summary: "the largest Lyapunov exponents, up to all: growth of small deviations by the exact derivative of \
              flights and contacts",
    of: Of::System,
    span: Span::Measurement,
    parameters: &[
        Parameter::up_to(
            "exponents",
            MAX_EXPONENTS,
            Default::FromScene("all, at most 256, in at most 256 MB"),
            "number of exponents, the largest first; each contact costs in proportion, the orthogonalisation as the \
             square",
        ),
        Parameter::positive(
            "transient",
            Default::Number(0.0),
            "time before the first average, in which the deviations turn to their directions",
        ),
    ],
    figures: &[FASTEST, ENTROPY, PAIR, SUM],
    start: |selection| {
        let view = selection.view;
        let exponents = selection.given("exponents").map_or_else(
            || default_exponents(LyapunovSpectrum::dimension_of(view)),
            |given| given as usize,
        );
        let transient = selection.given("transient").unwrap_or(0.0);
        Ok(in_blocks(LyapunovSpectrum::new(
            view, exponents, transient,
        )?))
    },
    resume: resumed::<LyapunovSpectrum>,
};

/// More take minutes for each orthogonalisation, and gigabytes.
const MAX_EXPONENTS: f64 = 4096.0;

/// Number of exponents without a wish: all of 64 discs, and of many bodies what 256 MB hold.
fn default_exponents(dimension: usize) -> usize {
    const MAX_NUMBERS: usize = 1 << 25;
    (MAX_NUMBERS / dimension.max(1)).clamp(1, 256)
}

const FASTEST: &str = "largest Lyapunov exponent";
const ENTROPY: &str = "Kolmogorov-Sinai entropy";
const PAIR: &str = "largest sum of a pair of Lyapunov exponents";
const SUM: &str = "sum of the Lyapunov exponents";
const RATE: &str = "1/time";

impl Measured for LyapunovSpectrum {
    const OF_INTERVALS: bool = true;

    /// The exponents, the sums λᵢ + λ_{D+1−i} if all are measured, then the sum of the
    /// larger half, the sum of all, and the contraction.
    fn sums(&self) -> Sums {
        let mut sums = self.sums();
        let (count, half) = (sums.len(), self.dimension() / 2);
        let total = |part: &[[f64; 2]], needed: usize| {
            let time = part
                .iter()
                .map(|[_, time]| *time)
                .fold(f64::INFINITY, f64::min);
            if part.len() < needed || time == 0.0 {
                return [0.0; 2];
            }
            [part.iter().map(|[growth, _]| growth).sum(), time]
        };
        let pair = |n: usize| {
            let [first, last] = [n, self.dimension() - 1 - n].map(|n| sums.get(n).copied());
            first
                .zip(last)
                .map_or([0.0; 2], |(first, last)| total(&[first, last], 2))
        };
        let pairs: Vec<[f64; 2]> = (0..half).map(pair).collect();
        let [larger, all] = [
            total(&sums[..half.min(count)], half),
            total(&sums, 2 * half),
        ];
        let contraction = [self.contraction(), all[1]];
        sums.extend(pairs);
        sums.extend([larger, all, contraction]);
        sums
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let half = self.dimension() / 2;
        let [exponents @ .., larger, all, contraction] = means else {
            return Results::default();
        };
        let (exponents, pairs) = exponents.split_at(exponents.len().saturating_sub(half));
        let count = exponents.len();
        let mut table = Table::new(context.table("lyapunov"), "Lyapunov exponents")
            .abscissa("number", "1", (1..=count).map(|n| n as f64).collect())
            .means("exponent", RATE, exponents)
            .caption(caption(self));
        let measured = pairs
            .iter()
            .filter_map(|pair| Some((pair.value?.abs(), pair)));
        let widest = measured.max_by(|(a, _), (b, _)| a.total_cmp(b));
        if widest.is_some() {
            let partner = |n: usize| pairs[n.min(self.dimension() - 1 - n)].value;
            table = table.derived(
                "sum with its partner",
                RATE,
                (0..count).map(partner).collect(),
            );
        }
        let fastest = exponents.first();
        let mut figures: Vec<_> = fastest
            .and_then(|mean| context.figure(FASTEST, RATE, mean))
            .into_iter()
            .collect();
        if context.is_elastic {
            figures.extend(context.figure(ENTROPY, RATE, larger));
            figures.extend(widest.and_then(|(_, pair)| context.figure(PAIR, RATE, pair)));
        } else {
            let sum = context.figure(SUM, RATE, all);
            figures.extend(sum.map(|sum| sum.predicted(contraction.value, CONTRACTION)));
        }
        Results {
            tables: vec![table],
            figures,
            ..Results::default()
        }
    }
}

/// What the table of exponents needs to be read.
fn caption(spectrum: &LyapunovSpectrum) -> String {
    let lost = match spectrum.replaced() {
        0 => String::new(),
        replaced => format!(
            " {replaced} times a contact flattened the deviations below rounding: the last exponents are smaller than \
             here."
        ),
    };
    let approximated = match spectrum.approximated() {
        0 => String::new(),
        contacts => format!(
            " {contacts} contacts at several points at once counted as one on the line of their resultant."
        ),
    };
    format!(
        "Growth of small deviations, the fastest first. Without losses the exponents pair, and each conserved quantity \
         makes two of them 0, which is approached as ln t / t. The time in which the deviations turn to their \
         directions is left out by `transient`.{lost}{approximated}"
    )
}

/// Source of the prediction of the sum.
const CONTRACTION: &str = "ln e² for each contact: the volume in the space of states";

/// Refuses scenes whose measured part has contacts or edits without a derivative here.
///
/// # Errors
/// The surfaces are rough, or give kicks, their elasticity depends on the speed, or velocities are
/// set while the exponents are measured.
pub(super) fn check(scene: &Scene) -> Result<()> {
    let what = if stages::has_elasticity(scene, ElasticitySpec::is_rough) {
        "rough surfaces or kicks"
    } else if stages::has_elasticity(scene, |elasticity| {
        elasticity
            .pair
            .iter()
            .any(|rule| rule.coefficient.number().is_none())
    }) {
        "an elasticity that depends on the speed"
    } else if stages::has_elasticity(scene, |elasticity| elasticity.least_coefficient() == 0.0) {
        "an elasticity of 0, after which nothing tells how fast bodies met"
    } else if stages::has_wells(scene) {
        "wells"
    } else if let Some(what) = stages::resets(scene) {
        what
    } else {
        return Ok(());
    };
    bail!(
        "'{}' needs smooth contacts of a constant elasticity between edits, and motions that nothing else sets: it cannot \
         be measured with {what}",
        KIND.name
    )
}
