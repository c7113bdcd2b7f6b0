//! `temperature`: translational and rotational temperature of a group.

use carom::TemperatureByTag;
use carom_tables::{BlockMean, Table};

use super::{Context, Kind, Measured, Of, Results, Span, in_blocks, point_bytes, resumed};

pub(super) const KIND: Kind = Kind {
    name: "temperature",
    summary: "kT of the translation and of the rotation of a group at each sample, and its mean velocity",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[],
    begin: |selection| Ok(in_blocks(TemperatureByTag::new(selection.group))),
    resume: resumed::<TemperatureByTag>,
};

/// Unit of kT.
const UNIT: &str = "mass·length²/time²";

impl Measured for TemperatureByTag {
    /// Translation, then rotation, then the velocity of the centre of mass.
    fn sums(&self) -> Vec<[f64; 2]> {
        [self.sums(), self.flow().to_vec()].concat()
    }

    fn bytes_per_sample(&self) -> usize {
        point_bytes(self.series())
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let points = self.series();
        let table = Table::new(context.table("temperature"), "Temperature")
            .abscissa("time", "time", points.iter().map(|point| point.time).collect())
            .counts("bodies", points.iter().map(|point| point.bodies as u64).collect())
            .value("translation", UNIT, points.iter().map(|point| point.translation).collect())
            .value("rotation", UNIT, points.iter().map(|point| point.rotation).collect())
            .caption("kT relative to the centre of mass; both have one mean at equilibrium (equipartition).");
        let names = [
            ("kT of the translation", UNIT, None),
            ("kT of the rotation", UNIT, None),
            ("mean velocity along x", "length/time", None),
            ("mean velocity along y", "length/time", None),
        ];
        let figures = context.figures(names, means, "");
        Results { tables: vec![table], figures, ..Results::default() }
    }
}
