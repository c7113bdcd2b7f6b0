//! `van-hove`: the distribution of the displacements of a group at logarithmic lags, G_s(r, t).

use anyhow::Result;
use carom::{SelfVanHove, observers::DisplacementBins};
use carom_tables::{BlockMean, Sums, Table, significant};

use crate::curves::MIN_PAIRS;

use super::{
    Context, Default, MAX_LAG, MeasureKind, Measured, Of, Parameter, Results, Selection, Span,
    in_blocks,
    known::Known,
    relaxation::diameter,
    resumed,
    thermal::{FREE_FLIGHT, Thermal},
};

/// Default of the largest displacement, in diameters of the largest body.
const DIAMETERS: f64 = 5.0;

/// Lags of a decade, of which each has a place in the list of lags after lag 0.
const LAGS_PER_DECADE: usize = 9;

/// The lags of a decade that are shown, in units of its first: nearly equal steps of the logarithm.
const SHOWN: [usize; 2] = [1, 3];

const DISTANCE: Parameter = Parameter::positive(
    "distance",
    Default::FromScene("5 diameters of the largest body"),
    "largest displacement in the bins (length)",
);

const BINS: Parameter = Parameter::up_to(
    "bins",
    1e4,
    Default::Number(100.0),
    "bins of the displacement",
);

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "van-hove",
    summary: "distribution of displacements at lags of 1, 3, 10, 30, … samples: the self part G_s(r, t) of the van Hove \
              function",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[DISTANCE, BINS, MAX_LAG],
    figures: &[],
    start: |selection| Ok(in_blocks(van_hove(selection)?)),
    resume: resumed::<VanHove>,
};

/// Distributions, and the thermal velocities of the group.
type VanHove = Known<SelfVanHove, Thermal>;

fn van_hove(selection: &Selection<'_>) -> Result<VanHove> {
    let bins = DisplacementBins {
        distance: match selection.given(DISTANCE.name) {
            Some(distance) => distance,
            None => DIAMETERS * diameter(selection, &DISTANCE)?,
        },
        bins: selection.whole(BINS.name),
        spacing: selection.interval(),
        longest: selection.longest_lag(),
    };
    Ok(Known {
        observer: SelfVanHove::new(selection.group, bins)?,
        facts: Thermal::new(selection),
    })
}

/// The places of the lags that are shown, in a list of so many.
fn shown(lags: usize) -> impl Iterator<Item = usize> {
    (1..lags).filter(|place| SHOWN.contains(&((place - 1) % LAGS_PER_DECADE + 1)))
}

impl Measured for VanHove {
    /// G_s in each bin at the first of the lags shown, then at the next.
    fn sums(&self) -> Sums {
        shown(self.observer.lags().len())
            .flat_map(|place| self.observer.sums_at(place))
            .collect()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let (lags, distances) = (self.observer.lags(), self.observer.distances());
        let (curves, bins) = (self.observer.curves(), distances.len());
        let edges: Vec<f64> = (0..=bins)
            .map(|bin| bin as f64 * self.observer.width())
            .collect();
        let thermal = context.is_equilibrium.then_some(&self.facts);
        let mut table = Table::new(
            context.table("van-hove"),
            "Distribution of displacements G_s(r, t)",
        )
        .bins("displacement", "length", &edges);
        let mut is_empty = true;
        for (place, means) in shown(lags.len()).zip(means.chunks(bins)) {
            // Lags without pairs are the longest.
            let Some(curve) = curves.get(place).filter(|curve| curve.pairs >= MIN_PAIRS) else {
                break;
            };
            let lag = significant(curve.lag, 6);
            let gaussian = edges.windows(2).map(|edges| {
                let [low, high] = [edges[0], edges[1]];
                thermal?.displacements([low, high], curve.lag)
            });
            table = table
                .means(
                    &format!("density_at_{lag}"),
                    "1/length²",
                    &context.resolved(means, &vec![curve.lag; bins]),
                )
                .labelled(&format!("lag {lag}"))
                .prediction(
                    &format!("free flight, {lag}"),
                    gaussian.collect(),
                    FREE_FLIGHT,
                );
            is_empty = false;
        }
        table = table.caption(
            "Probability by area of the displacement of a body after a lag; ∫ G_s 2πr dr = 1 with the larger displacements. \
             Free flight: m/(2πkT t²) exp(−m r²/2kT t²).",
        );
        Results {
            tables: if is_empty { Vec::new() } else { vec![table] },
            ..Results::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lags_of_one_and_three_of_each_decade_are_shown() {
        let spacings: Vec<u64> = std::iter::once(0)
            .chain((0..4).flat_map(|decade| (1..=9).map(move |count| count * 10_u64.pow(decade))))
            .collect();
        let found: Vec<u64> = shown(spacings.len()).map(|place| spacings[place]).collect();
        assert_eq!(found, [1, 3, 10, 30, 100, 300, 1000, 3000]);
        assert_eq!(shown(0).count() + shown(1).count(), 0);
    }
}
