//! `temperature`: translational and rotational temperature of a group.

use carom::{TemperatureByTag, observers::TemperaturePoint};
use carom_tables::{BlockMean, Table};

use super::{
    Context, MeasureKind, Measured, Of, Results, Span, haff, in_blocks, point_bytes, resumed,
};

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "temperature",
    summary: "kT of the translation and of the rotation of a group at each sample, and its mean velocity",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[],
    figures: &[
        "kT of the translation",
        "kT of the rotation",
        "mean velocity along",
    ],
    start: |selection| Ok(in_blocks(TemperatureByTag::new(selection.group))),
    resume: resumed::<TemperatureByTag>,
};

/// Unit of kT.
const UNIT: &str = "mass·length²/time²";

/// The frame, and the mean velocities that it makes 0.
fn caption(flow_is_zero: [bool; 2], is_equilibrium: bool) -> String {
    let frame = "Relative to the centre of mass of all bodies along each axis on which momentum is conserved.";
    let frame = if is_equilibrium {
        format!("{frame} Both kT have one mean at equilibrium (equipartition).")
    } else {
        frame.to_owned()
    };
    let axes = match flow_is_zero {
        [true, true] => "x and y",
        [true, false] => "x",
        [false, true] => "y",
        [false, false] => return frame,
    };
    format!(
        "{frame} The mean velocity of all bodies along {axes} is conserved, and 0 in this frame."
    )
}

/// The table of a gas that cools, by logarithms, with its law if that is known; else with a line of
/// the power with which homogeneous cooling ends (Haff, J. Fluid Mech. 134 (1983) 401).
fn cooling(table: Table, is_known: bool) -> Table {
    let table = table.logarithmic().in_decades(&["translation", "rotation"]);
    if is_known {
        table
    } else {
        table.guide("translation", -2.0, "∝ t⁻², Haff (1983)", true)
    }
}

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
        let times: Vec<f64> = points.iter().map(|point| point.time).collect();
        let kt = |of: fn(&TemperaturePoint) -> Option<f64>| points.iter().map(of).collect();
        let mut table = Table::new(context.table("temperature"), "Temperature")
            .abscissa("time", "time", times.clone())
            .counts(
                "bodies",
                points.iter().map(|point| point.bodies as u64).collect(),
            )
            .value("translation", UNIT, kt(|point| point.translation));
        let start = points
            .iter()
            .find_map(|point| Some([point.time, point.translation?]));
        let law = context.cooling_discs.zip(start);
        if let Some((discs, start)) = law {
            let law = discs.temperatures(start, &times);
            table = table.prediction("Haff's law, homogeneous", law, haff::SOURCE);
        }
        table = table
            .value("rotation", UNIT, kt(|point| point.rotation))
            .caption(caption(self.flow_is_zero(), context.is_equilibrium));
        if context.is_cooling {
            table = cooling(table, law.is_some());
        }
        let names = [
            ("kT of the translation", UNIT),
            ("kT of the rotation", UNIT),
            ("mean velocity along x", "length/time"),
            ("mean velocity along y", "length/time"),
        ];
        let [zero_along_x, zero_along_y] = self.flow_is_zero();
        let is_measured = [true, true, !zero_along_x, !zero_along_y];
        let measured = names
            .into_iter()
            .zip(means)
            .zip(is_measured)
            .filter(|(_, is_measured)| *is_measured);
        let figures =
            measured.filter_map(|(((name, unit), mean), _)| context.figure(name, unit, mean));
        Results {
            tables: vec![table],
            figures: figures.collect(),
            ..Results::default()
        }
    }
}
