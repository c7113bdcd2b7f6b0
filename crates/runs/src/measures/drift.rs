//! `drift:TAG`: mean force, torque and velocities of one body in its own frame.

use carom::{CollisionReport, Observer, View, engine::Body, observers::Drift};
use carom_tables::{BlockMean, Figure};
use serde::{Deserialize, Serialize};

use super::{Context, Kind, Measured, Of, Results, Span, in_blocks, resumed};

pub(super) const KIND: Kind = Kind {
    name: "drift",
    summary: "mean force, torque, velocity and spin of the only body with the tag, in its own frame",
    of: Of::OneBody,
    span: Span::Measurement,
    parameters: &[],
    begin: |selection| {
        let body = selection.only_body()?.body;
        Ok(in_blocks(OneDrift { drift: Drift::new(body.key()), is_fixed: body.is_fixed() }))
    },
    resume: resumed::<OneDrift>,
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

/// The drift of one body.
#[derive(Serialize, Deserialize)]
struct OneDrift {
    drift: Drift,
    /// A fixed body near others feels a mean force at equilibrium, such as depletion.
    is_fixed: bool,
}

impl Observer for OneDrift {
    fn watches_any(&self) -> bool {
        self.drift.watches_any()
    }

    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.drift.watches(bodies)
    }

    fn start(&mut self, view: &View<'_>) {
        self.drift.start(view);
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.drift.collision(report);
    }

    fn sample(&mut self, view: &View<'_>) {
        self.drift.sample(view);
    }
}

impl Measured for OneDrift {
    /// Force, torque and velocities, each over the time.
    fn sums(&self) -> Vec<[f64; 2]> {
        let drift = &self.drift;
        let (impulse, path) = (drift.impulse(), drift.path());
        let sums = [impulse.x, impulse.y, drift.angular_impulse(), path.x, path.y, drift.turn()];
        sums.map(|sum| [sum, drift.duration()]).to_vec()
    }

    /// At equilibrium all means of a body that moves are 0, since the free energy of the whole
    /// system does not depend on its place and orientation. Held at its place, it may be pushed.
    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let is_zero = context.is_equilibrium && !self.is_fixed;
        let names = MEANS.map(|(name, unit)| (name, unit, is_zero.then_some(0.0)));
        let (forces, velocities) = names.split_at(3);
        let of = |names: &[_], means: &[BlockMean]| context.figures(names.to_vec(), means, "equilibrium");
        let (means_of_forces, means_of_velocities) = means.split_at(means.len().min(3));
        let mut figures = of(forces, means_of_forces);
        // A steady force is balanced by friction: the velocities show it.
        figures.extend(of(velocities, means_of_velocities).into_iter().map(Figure::test));
        Results { figures, ..Results::default() }
    }
}
