//! `friction`: mean force and friction coefficient of the bodies of a group, from their impulses.

use carom::observers::Friction;
use carom_tables::BlockMean;

use super::{
    Context, MeasureKind, Measured, Of, Results, Span, hard_discs::ENSKOG, in_blocks, resumed,
};

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "friction",
    summary: "impulses on a group: their mean size per time, and from their squares the short-time (Enskog) friction \
              coefficient, which is not kT/D: the flow around a body returns",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[],
    figures: &["impulses per body", "short-time", "initial decay"],
    start: |selection| Ok(in_blocks(Friction::new(selection.group))),
    resume: resumed::<Friction>,
};

/// Names and units of the means, in the order of the sums.
const MEANS: [(&str, &str); 4] = [
    ("impulses per body and time Σ|J|/t", "mass·length/time²"),
    (
        "short-time (Enskog) friction coefficient Σ|J|²/4kTt",
        "mass/time",
    ),
    (
        "short-time rotational friction coefficient Σ(r×J)²/2kTt",
        "mass·length²/time",
    ),
    ("initial decay of the velocity autocorrelation", "1/time"),
];

impl Measured for Friction {
    const OF_INTERVALS: bool = true;

    fn sums(&self) -> Vec<[f64; 2]> {
        self.sums().to_vec()
    }

    /// In a gas of equal discs γ = mΓ, and ⟨v²⟩ is (1 − 1/N) 2kT/m.
    ///
    /// The impulses go with the third power of the relative velocity, which at fixed energy and
    /// momentum has a smaller mean.
    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let predictions = context.gas().map_or([None; 4], |gas| {
            let (rate, count) = (gas.collision_rate(), gas.count as f64);
            let rate = rate * third_moment(2.0 * (count - 1.0));
            [
                None,
                Some(gas.mass * rate),
                Some(0.0),
                Some(rate * count / (count - 1.0)),
            ]
        });
        let names = MEANS.into_iter().zip(predictions);
        let names = names.map(|((name, unit), prediction)| (name, unit, prediction));
        Results {
            figures: context.figures(names, means, ENSKOG),
            ..Results::default()
        }
    }
}

/// ⟨|x|³⟩ of a component of a vector with so many components and a fixed sum of squares, over that
/// of a Gaussian of the same variance: (D/2)^(3/2) Γ(D/2)/Γ(D/2 + 3/2), about 1 − 3/4D.
fn third_moment(components: f64) -> f64 {
    let half = 0.5 * components;
    (1.5 * half.ln() + libm::lgamma(half) - libm::lgamma(half + 1.5)).exp()
}

#[cfg(test)]
mod tests {
    use super::third_moment;

    #[test]
    fn the_third_moment_approaches_that_of_a_gaussian() {
        // Two components: x = √2 cos φ, and ⟨|x|³⟩ = 2^(3/2) · 4/3π; of a Gaussian √(8/π).
        let two =
            8f64.sqrt() * 4.0 / (3.0 * std::f64::consts::PI) / (8.0 / std::f64::consts::PI).sqrt();
        assert!((third_moment(2.0) - two).abs() < 1e-12);
        assert!((third_moment(2000.0) - (1.0 - 0.75 / 2000.0)).abs() < 1e-6);
    }
}
