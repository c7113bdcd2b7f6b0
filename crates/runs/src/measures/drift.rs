//! `drift:TAG`: mean force, torque and velocities of one body in its own frame.

use carom::observers::Drift;
use carom_tables::BlockMean;

use super::{Context, Kind, Measured, Of, Results, Span, in_blocks, resumed};

pub(super) const KIND: Kind = Kind {
    name: "drift",
    summary: "mean force, torque, velocity and spin of the only body with the tag, in its own frame",
    of: Of::OneBody,
    span: Span::Measurement,
    parameters: &[],
    begin: |selection| Ok(in_blocks(Drift::new(selection.only_body()?.body.key()))),
    resume: resumed::<Drift>,
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

impl Measured for Drift {
    /// Force, torque and velocities, each over the time.
    fn sums(&self) -> Vec<[f64; 2]> {
        let (impulse, path) = (self.impulse(), self.path());
        let sums = [impulse.x, impulse.y, self.angular_impulse(), path.x, path.y, self.turn()];
        sums.map(|sum| [sum, self.duration()]).to_vec()
    }

    /// At equilibrium all are 0 on average, if the system has no elasticity below 1.
    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let figure = |((name, unit), mean): (&(&str, &str), &BlockMean)| {
            let prediction = context.is_elastic.then_some(0.0);
            Some(context.figure(name, unit, mean)?.predicted(prediction, "equilibrium"))
        };
        Results { figures: MEANS.iter().zip(means).filter_map(figure).collect(), ..Results::default() }
    }
}
