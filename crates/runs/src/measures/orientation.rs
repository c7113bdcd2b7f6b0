//! `orientation`: correlations of orientations and angular velocities of a group, and whether a
//! direction is preferred.

use carom::{
    CollisionReport, Observer, OrientationCorrelation, View, engine::Body, observers::Group,
};
use carom_tables::{BlockMean, Table};
use serde::{Deserialize, Serialize};

use crate::curves::{Coefficient, MIN_PAIRS, Reading};

use super::{Context, MAX_LAG, MeasureKind, Measured, Of, Results, Span, in_blocks, resumed};

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "orientation",
    summary: "orientational correlations and angular velocity autocorrelation against the lag, and mean orientation",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[MAX_LAG],
    figures: &[
        "mean cos",
        "rotational diffusion coefficient D_r at long lags, … to …",
        "apparent rotational diffusion coefficient D_r at long lags, … to …, no plateau",
        "rotational diffusion coefficient D_r from angular velocities, up to lag …",
    ],
    start: |selection| {
        let (interval, longest) = (selection.interval(), selection.longest_lag());
        Ok(in_blocks(Orientations {
            correlation: OrientationCorrelation::new(selection.group, interval, longest)?,
            group: selection.group,
            harmonics: [0.0; HARMONICS],
            terms: 0,
            is_free: selection.view.bodies().all(|body| body.body.is_free()),
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
        for body in view
            .bodies()
            .filter(|body| body.body.inertia().inverse_moment > 0.0)
        {
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
        self.correlation
            .sums()
            .into_iter()
            .chain(self.harmonics.map(|sum| [sum, count]))
            .collect()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let lags = self.correlation.lags();
        let points = self.correlation.points();
        let measured = points.len();
        let (means, harmonics) = means.split_at(means.len().saturating_sub(HARMONICS));
        let quantity = |index: usize| {
            let mut found = context.at_lags(means, index, lags.len(), &lags[..measured]);
            for (mean, _) in found
                .iter_mut()
                .zip(&points)
                .filter(|(_, point)| point.pairs < MIN_PAIRS)
            {
                *mean = BlockMean::default();
            }
            found
        };
        let table = Table::new(
            context.table("orientation"),
            "Correlation of orientations and of angular velocities",
        )
        .logarithmic()
        .abscissa("lag", "time", lags[..measured].to_vec())
        .counts("pairs", points.iter().map(|point| point.pairs).collect())
        .means("cos_Δθ", "1", &quantity(0))
        .means("cos_2Δθ", "1", &quantity(1))
        .means("angular_velocity_autocorrelation", "1/time²", &quantity(2))
        .relative_to_first(&["angular_velocity_autocorrelation"])
        .caption(
            "⟨cos Δθ⟩ and ⟨cos 2Δθ⟩ of the bodies that turn: 1 at lag 0, 0 when orientations are forgotten. Lags with \
             fewer than 30 pairs have no value.",
        );
        let isotropic = (context.is_equilibrium && self.is_free).then_some(0.0);
        let names = ["mean cos θ", "mean cos 2θ", "mean cos 3θ", "mean cos 4θ"];
        let figures = context.figures(
            names.map(|name| (name, "1", isotropic)),
            harmonics,
            "isotropy",
        );
        Results {
            tables: vec![table],
            coefficients: coefficients(&lags, context),
            figures,
            ..Results::default()
        }
    }
}

/// The rotational diffusion coefficient D_r, with ⟨cos Δθ⟩ ∝ exp(−D_r t) at long lags: from that
/// decay, and as the integral of the autocorrelation of the angular velocity.
fn coefficients(lags: &[f64], context: &Context<'_>) -> Vec<Coefficient> {
    // After C₁ and C₂.
    let memory = 2 * lags.len();
    let of = |name, reading, curve| {
        Coefficient::new(
            (name, "1/time"),
            (reading, 1.0),
            curve,
            lags,
            context.of_curves(),
        )
    };
    let name = "rotational diffusion coefficient D_r";
    let of_velocities = format!("{name} from angular velocities");
    vec![
        of(name, Reading::Decay { memory }, 0),
        of(&of_velocities, Reading::Integral, memory),
    ]
}
