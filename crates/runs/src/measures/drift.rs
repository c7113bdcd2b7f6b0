//! `drift:TAG`: mean force, torque and velocities of one body in its own frame.

use carom::observers::Drift;
use carom_tables::{BlockMean, Figure};

use super::{Context, MeasureKind, Measured, Of, Results, Span, in_blocks, known::Known, resumed};

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "drift",
    summary: "mean force, torque, velocity and spin of the only body with the tag, in its own frame",
    of: Of::OneBody,
    span: Span::Measurement,
    parameters: &[],
    figures: &[
        "mean force",
        "mean torque",
        "mean velocity",
        "mean angular velocity",
    ],
    start: |selection| {
        let body = selection.only_body()?.body;
        Ok(in_blocks(Known {
            observer: Drift::new(body.key()),
            facts: body.is_fixed(),
        }))
    },
    resume: resumed::<Known<Drift, IsFixed>>,
};

/// Names and units of the means, in the order of the sums.
const MEANS: [(&str, &str); 6] = [
    ("mean force along x′", "mass·length/time²"),
    ("mean force along y′", "mass·length/time²"),
    ("mean torque", "mass·length²/time²"),
    ("mean velocity along x′", "length/time"),
    ("mean velocity along y′", "length/time"),
    ("mean angular velocity", "radian/time"),
];

/// Whether the body is fixed: near others it feels a mean force at equilibrium, such as depletion.
type IsFixed = bool;

impl Measured for Known<Drift, IsFixed> {
    /// Force, torque and velocities, each over the time.
    fn sums(&self) -> Vec<[f64; 2]> {
        let drift = &self.observer;
        let (impulse, path) = (drift.impulse(), drift.path());
        let sums = [
            impulse.x,
            impulse.y,
            drift.angular_impulse(),
            path.x,
            path.y,
            drift.turn(),
        ];
        sums.map(|sum| [sum, drift.duration()]).to_vec()
    }

    /// At equilibrium all means of a body that moves are 0, since the free energy of the whole
    /// system does not depend on its place and orientation. Held at its place, it may be pushed.
    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let is_zero = context.is_equilibrium && !self.facts;
        let names = MEANS.map(|(name, unit)| (name, unit, is_zero.then_some(0.0)));
        let (forces, velocities) = names.split_at(3);
        let of = |names: &[_], means: &[BlockMean]| {
            context.figures(names.to_vec(), means, "equilibrium")
        };
        let (means_of_forces, means_of_velocities) = means.split_at(means.len().min(3));
        let mut figures = of(forces, means_of_forces);
        // A steady force is balanced by friction: the velocities show it.
        figures.extend(
            of(velocities, means_of_velocities)
                .into_iter()
                .map(Figure::test),
        );
        Results {
            figures,
            ..Results::default()
        }
    }
}
