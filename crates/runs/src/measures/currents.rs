//! `currents`: longitudinal and transverse current correlations C_L(k, t) and C_T(k, t) of a group.

use anyhow::Result;
use carom::CurrentCorrelation;
use carom_tables::{BlockMean, Table};

use crate::curves::MIN_PAIRS;

use super::{
    Context, MAX_LAG, MeasureKind, Measured, Of, Results, Selection, Span, in_blocks,
    intermediate_scattering::{scales, shells_near},
    known::Known,
    relaxation::WAVE_NUMBER,
    resumed,
    thermal::{FREE_FLIGHT, Thermal},
};

/// Default number of shells: at small k the correlations of different |k| differ much.
const SHELLS: f64 = 1.0;

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "currents",
    summary: "longitudinal and transverse current correlations C_L(k, t) and C_T(k, t) against the lag",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[WAVE_NUMBER, shells_near(SHELLS), MAX_LAG],
    figures: &[],
    start: |selection| Ok(in_blocks(currents(selection)?)),
    resume: resumed::<Currents>,
};

/// Currents, and the thermal velocities of the group.
type Currents = Known<CurrentCorrelation, Thermal>;

fn currents(selection: &Selection<'_>) -> Result<Currents> {
    let bounds = selection.view.bounds();
    Ok(Known {
        observer: CurrentCorrelation::new(selection.group, &bounds, scales(selection)?)?,
        facts: Thermal::new(selection),
    })
}

impl Measured for Currents {
    /// C_L at each lag, then C_T.
    fn sums(&self) -> Vec<[f64; 2]> {
        self.observer.sums()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let mut points = self.observer.points();
        points.retain(|point| point.pairs >= MIN_PAIRS);
        let wave_numbers = self.observer.wave_numbers();
        let (Some(first), Some(last)) = (wave_numbers.first(), wave_numbers.last()) else {
            return Results::default();
        };
        if points.is_empty() {
            return Results::default();
        }
        let lags: Vec<f64> = points.iter().map(|point| point.lag).collect();
        let all = self.observer.lags().len();
        let [longitudinal, transverse] =
            [0, 1].map(|component| context.at_lags(means, component, all, &lags));
        let thermal = context.is_equilibrium.then_some(&self.facts);
        let predicted = |component: usize| {
            let at_lag = |&lag: &f64| Some(thermal?.currents(wave_numbers, lag)?[component]);
            lags.iter().map(at_lag).collect()
        };
        let table = Table::new(context.table("currents"), "Current correlations")
            .abscissa("lag", "time", lags.clone())
            .counts("pairs", points.iter().map(|point| point.pairs).collect())
            .means("longitudinal", "length²/time²", &longitudinal)
            .prediction("free flight, C_L", predicted(0), FREE_FLIGHT)
            .means("transverse", "length²/time²", &transverse)
            .prediction("free flight, C_T", predicted(1), FREE_FLIGHT)
            .logarithmic()
            .caption(format!(
                "⟨j(k, t) j*(k, 0)⟩/N of the components of j = Σ v exp(ik·x) along k and across it, with {} wave vectors \
                 of length {first:.4} to {last:.4}; kT/m at lag 0 for equal masses m at equilibrium. Free flight: (kT/m) \
                 exp(−x/2) across k, times 1 − x along k, x = k² kT t²/m.",
                wave_numbers.len()
            ));
        Results {
            tables: vec![table],
            ..Results::default()
        }
    }
}
