//! `incidence`: the angles at which a group meets fixed bodies and walls.

use carom::observers::{AdaptiveHistogram, Incidence};
use carom_tables::{BlockMean, Table};

use super::{
    Context, Default, MeasureKind, Measured, Of, Parameter, Results, Span, in_blocks, resumed,
};

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "incidence",
    summary: "sin φ of the angle from the normal at contacts with fixed bodies and walls: the law of the cosine, a \
              boundary map",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[Parameter::whole(
        "bins",
        Default::Number(40.0),
        "bins of sin φ from −1 to 1",
    )],
    figures: &[],
    start: |selection| {
        let bins = selection.whole("bins");
        Ok(in_blocks(Incidence::new(selection.group, bins)))
    },
    resume: resumed::<Incidence>,
};

impl Measured for Incidence {
    fn distributions(&self) -> Vec<Vec<&AdaptiveHistogram>> {
        vec![vec![self.sines()]]
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let sines = self.sines();
        let table = Table::new(context.table("incidence"), "Angles of incidence")
            .bins("sine", "1", sines.bins().edges())
            .means("density", "1", means)
            .caption(
                "sin φ of the velocity before contacts with fixed bodies and walls, φ from the normal. It is uniform, 1/2, \
                 where all directions are equally probable: in a gas at equilibrium, and over a long time in an ergodic \
                 table, of bodies that do not turn.",
            )
            .level("uniform", Some(0.5), "isotropy");
        Results {
            tables: vec![table],
            ..Results::default()
        }
    }
}
