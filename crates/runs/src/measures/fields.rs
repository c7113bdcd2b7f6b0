//! `fields`: density, velocity, kT, stress and heat current in the cells of a grid over the box.

use anyhow::ensure;
use carom::observers::{FieldBins, Fields};
use carom_tables::{BlockMean, Sums, Table};

use super::{
    Context, Default, MeasureKind, Measured, Of, Parameter, Results, Selection, Span, in_blocks,
    resumed,
};

/// Cells along the longer side of the box, if the scene does not say.
const COLUMNS: f64 = 20.0;

/// Most cells of a grid. More: blocks of all fields take more than 200 MB.
const MAX_CELLS: usize = 10_000;

/// Columns and rows of the grid.
const KEYS: [&str; 2] = ["columns", "rows"];

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "fields",
    summary: "maps of density, area fraction, velocity, kT, spin, stress and heat current in the cells of a grid",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[
        Parameter::whole(
            KEYS[0],
            Default::FromScene("20 along the longer side"),
            "cells along x; columns × rows at most 10 000",
        ),
        Parameter::whole(
            KEYS[1],
            Default::FromScene("cells near to squares"),
            "cells along y",
        ),
    ],
    figures: &[],
    start: |selection| {
        let counts = counts(selection)?;
        let bins = FieldBins::grid(&selection.view.bounds(), counts)?;
        Ok(in_blocks(Fields::new(selection.group, bins)))
    },
    resume: resumed::<Fields>,
};

/// Columns and rows of the grid, with cells near to squares where one of them is not given.
fn counts(selection: &Selection<'_>) -> anyhow::Result<[usize; 2]> {
    let sides = selection.view.bounds().sides();
    let given = KEYS.map(|key| selection.given(key));
    let width = match given {
        [Some(columns), _] => sides.x / columns,
        [None, Some(rows)] => sides.y / rows,
        [None, None] => sides.max_element() / COLUMNS,
    };
    let count = |given: Option<f64>, side: f64| {
        given.unwrap_or_else(|| (side / width).round().clamp(1.0, MAX_CELLS as f64)) as usize
    };
    let counts = [count(given[0], sides.x), count(given[1], sides.y)];
    ensure!(
        counts[0] * counts[1] <= MAX_CELLS,
        "'columns' × 'rows' must be at most {MAX_CELLS}, but is {} × {}; give both",
        counts[0],
        counts[1]
    );
    Ok(counts)
}

impl Measured for Fields {
    const OF_INTERVALS: bool = true;

    /// All bins of the first quantity, then those of the next, in the order of `columns`.
    fn sums(&self) -> Sums {
        let bins = 0..self.bins().len();
        let of_bin: Vec<[[f64; 2]; COUNT]> = bins.map(|bin| of_bin(self, bin)).collect();
        let quantity = |quantity: usize| of_bin.iter().map(move |sums| sums[quantity]);
        (0..COUNT).flat_map(quantity).collect()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let middles: Vec<[f64; 2]> = (0..self.bins().len())
            .map(|bin| self.bins().middle(bin))
            .collect();
        let along = |axis: usize| middles.iter().map(|middle| middle[axis]).collect();
        let table = Table::new(context.table(KIND.name), "Fields")
            .abscissa("x", "length", along(0))
            .abscissa("y", "length", along(1));
        Results {
            tables: vec![columns(table, self, means).caption(CAPTION)],
            ..Results::default()
        }
    }
}

/// What the reader of a table of fields must know.
pub(super) const CAPTION: &str = "Means over time and bodies in each bin; kT is that about the mean velocity of the bin \
                                  at each sample. Stress ab is the flux along a of the momentum along b, in the frame \
                                  of the centre of mass, with the part that contacts carry.";

/// Number of quantities in a bin.
const COUNT: usize = 12;

/// The sums of each quantity in a bin.
fn of_bin(fields: &Fields, bin: usize) -> [[f64; 2]; COUNT] {
    let [velocity_1, velocity_2] = fields.velocity(bin);
    let [s11, s12, s21, s22] = fields.stress(bin);
    let [heat_1, heat_2] = fields.heat_current(bin);
    [
        fields.density(bin),
        fields.area_fraction(bin),
        velocity_1,
        velocity_2,
        fields.temperature(bin),
        fields.spin(bin),
        s11,
        s12,
        s21,
        s22,
        heat_1,
        heat_2,
    ]
}

/// The place of a quantity among those of a bin.
pub(super) const DENSITY: usize = 0;
pub(super) const KT: usize = 4;
pub(super) const HEAT_ALONG: usize = 10;

/// The means of one quantity in all bins.
pub(super) fn of_quantity(means: &[BlockMean], bins: usize, quantity: usize) -> &[BlockMean] {
    means
        .get(quantity * bins..(quantity + 1) * bins)
        .unwrap_or_default()
}

/// Adds the columns of all quantities.
pub(super) fn columns(table: Table, fields: &Fields, means: &[BlockMean]) -> Table {
    let bins = fields.bins().len();
    let [a, b] = fields.bins().axis_names();
    let names: [(String, &str); COUNT] = [
        ("density".to_owned(), "1/length²"),
        ("area_fraction".to_owned(), "1"),
        (format!("velocity_{a}"), "length/time"),
        (format!("velocity_{b}"), "length/time"),
        ("kT".to_owned(), "mass·length²/time²"),
        ("spin".to_owned(), "radian/time"),
        (format!("stress_{a}{a}"), "mass/time²"),
        (format!("stress_{a}{b}"), "mass/time²"),
        (format!("stress_{b}{a}"), "mass/time²"),
        (format!("stress_{b}{b}"), "mass/time²"),
        (format!("heat_{a}"), "mass·length/time³"),
        (format!("heat_{b}"), "mass·length/time³"),
    ];
    let counts = (0..bins).map(|bin| fields.count(bin)).collect();
    let all = names.iter().enumerate();
    all.fold(
        table.counts("bodies", counts),
        |table, (quantity, (name, unit))| {
            table.means(name, unit, of_quantity(means, bins, quantity))
        },
    )
}
