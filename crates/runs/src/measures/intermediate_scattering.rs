//! `intermediate-scattering`: F(k, t) of the centres of mass of a group, or of two, `A,B`.

use anyhow::Result;
use carom::{IntermediateScattering, observers::ScatteringScales};
use carom_tables::{BlockMean, Table};

use crate::curves::MIN_PAIRS;

use super::{
    Context, Default, MAX_LAG, MeasureKind, Measured, Of, Parameter, Results, Selection, Span,
    in_blocks,
    relaxation::{WAVE_NUMBER, wave_number},
    resumed,
};

/// Default number of shells: 40 to 80 wave vectors in a square box.
const SHELLS: f64 = 8.0;

const SHELLS_NEAR: Parameter = shells_near(SHELLS);

/// The number of shells nearest to k, with this default.
pub(super) const fn shells_near(default: f64) -> Parameter {
    Parameter::up_to(
        "shells",
        1000.0,
        Default::Number(default),
        "shells of wave vectors of the box nearest to k",
    )
}

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "intermediate-scattering",
    summary: "intermediate scattering function F(k, t) against the lag; with two tags, the partial F of both groups",
    of: Of::TwoGroups,
    span: Span::Measurement,
    parameters: &[WAVE_NUMBER, SHELLS_NEAR, MAX_LAG],
    figures: &[],
    start: |selection| Ok(in_blocks(scattering(selection)?)),
    resume: resumed::<IntermediateScattering>,
};

fn scattering(selection: &Selection<'_>) -> Result<IntermediateScattering> {
    let bounds = selection.view.bounds();
    Ok(IntermediateScattering::new(
        selection.groups(),
        &bounds,
        scales(selection)?,
    )?)
}

/// The wave number, shells and lags of a kind that has these parameters.
pub(super) fn scales(selection: &Selection<'_>) -> Result<ScatteringScales> {
    Ok(ScatteringScales {
        wave_number: wave_number(selection)?,
        shells: selection.whole(SHELLS_NEAR.name),
        spacing: selection.interval(),
        longest: selection.longest_lag(),
    })
}

impl Measured for IntermediateScattering {
    fn sums(&self) -> Vec<[f64; 2]> {
        self.sums()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let mut points = self.points();
        points.retain(|point| point.pairs >= MIN_PAIRS);
        let (Some(first), Some(last)) = (self.wave_numbers().first(), self.wave_numbers().last())
        else {
            return Results::default();
        };
        let lags: Vec<f64> = points.iter().map(|point| point.lag).collect();
        let scattering = context.at_lags(means, 0, self.lags().len(), &lags);
        let table = Table::new(
            context.table("intermediate-scattering"),
            "Intermediate scattering function F(k, t)",
        )
        .abscissa("lag", "time", lags)
        .counts("pairs", points.iter().map(|point| point.pairs).collect())
        .means("scattering", "1", &scattering)
        .logarithmic()
        .caption(format!(
            "Of the centres of mass, with {} wave vectors of length {first:.4} to {last:.4}; S(k) at lag 0, and k² kT t²/2m \
             less at short lags for equal masses m at equilibrium.",
            self.wave_numbers().len()
        ));
        Results {
            tables: if points.is_empty() {
                Vec::new()
            } else {
                vec![table]
            },
            ..Results::default()
        }
    }
}
