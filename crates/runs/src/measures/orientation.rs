//! `orientation`: correlations of orientations and angular velocities of a group, and whether a
//! direction is preferred.

use carom::{CollisionReport, Observer, OrientationCorrelation, View, engine::Body, observers::Group};
use carom_tables::{BlockMean, Table};
use serde::{Deserialize, Serialize};

use super::{Context, Kind, LONGEST_LAG, Measured, Of, Results, Span, in_blocks, resumed};

pub(super) const KIND: Kind = Kind {
    name: "orientation",
    summary: "orientational correlations and angular velocity autocorrelation against the lag, and mean orientation",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[LONGEST_LAG],
    begin: |selection| {
        let (interval, longest) = (selection.interval(), selection.longest_lag());
        Ok(in_blocks(Orientations {
            correlation: OrientationCorrelation::new(selection.group, interval, longest)?,
            group: selection.group,
            harmonics: [0.0; HARMONICS],
            terms: 0,
            is_free: !selection.view.bodies().any(|body| body.body.is_fixed()),
        }))
    },
    resume: resumed::<Orientations>,
};

/// Harmonics of the orientation. The fourth is the first that a square box could favour.
const HARMONICS: usize = 4;

/// Correlations and harmonics of the orientations of a group.
#[derive(Serialize, Deserialize)]
struct Orientations {
    correlation: OrientationCorrelation,
    group: Group,
    /// Σ cos kθ over the samples and the bodies that turn, k = 1, 2, …
    harmonics: [f64; HARMONICS],
    /// Terms of each sum.
    terms: u64,
    /// Whether no body of the scene is fixed: fixed bodies may favour a direction.
    is_free: bool,
}

impl Observer for Orientations {
    fn watches_any(&self) -> bool {
        self.correlation.watches_any()
    }

    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.correlation.watches(bodies)
    }

    fn start(&mut self, view: &View<'_>) {
        self.correlation.start(view);
    }

    fn pause(&mut self, view: &View<'_>) {
        self.correlation.pause(view);
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.correlation.collision(report);
    }

    fn sample(&mut self, view: &View<'_>) {
        self.correlation.sample(view);
        for body in view.bodies().filter(|body| body.body.inertia().inverse_moment > 0.0) {
            if !self.group.contains(body.body) || body.body.molecule().is_round() {
                continue;
            }
            let turned = body.motion.orientation.cos_sin();
            let mut power = turned;
            for sum in &mut self.harmonics {
                *sum += power.x;
                power = turned.rotate(power);
            }
            self.terms += 1;
        }
    }
}

impl Measured for Orientations {
    /// C₁ at each lag, then C₂, then the autocorrelation, then the harmonics.
    fn sums(&self) -> Vec<[f64; 2]> {
        let count = self.terms as f64;
        self.correlation.sums().into_iter().chain(self.harmonics.map(|sum| [sum, count])).collect()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        // Lags without pairs are the longest.
        let lags = self.correlation.lags();
        let measured = self.correlation.points().len();
        let (means, harmonics) = means.split_at(means.len().saturating_sub(HARMONICS));
        let quantity = |index: usize| {
            let begin = (index * lags.len()).min(means.len());
            context.resolved(&means[begin..], &lags[..measured])
        };
        let table = Table::new(
            context.table("orientation"),
            "Correlation of orientations and of angular velocities",
        )
        .logarithmic()
        .abscissa("lag", "time", lags[..measured].to_vec())
        .counts("pairs", self.correlation.points().iter().map(|point| point.pairs).collect())
        .means("cos_Δθ", "1", &quantity(0))
        .means("cos_2Δθ", "1", &quantity(1))
        .means("angular_velocity_autocorrelation", "1/time²", &quantity(2))
        .caption(
            "⟨cos Δθ⟩ and ⟨cos 2Δθ⟩ of the bodies that turn: 1 at lag 0, 0 when orientations are forgotten.",
        );
        let isotropic = (context.is_equilibrium && self.is_free).then_some(0.0);
        let names = ["mean cos θ", "mean cos 2θ", "mean cos 3θ", "mean cos 4θ"];
        let figures = context.figures(names.map(|name| (name, "1", isotropic)), harmonics, "isotropy");
        Results { tables: vec![table], figures, ..Results::default() }
    }
}
