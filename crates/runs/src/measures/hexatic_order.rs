//! `hexatic-order`: the bond-orientational order ψₙ of a group.

use anyhow::{Result, ensure};
use carom::{
    HexaticOrder,
    observers::{HexaticPoint, Neighbours},
};
use carom_tables::{BlockMean, Table};

use super::{
    Context, Default, MeasureKind, Measured, Of, Parameter, Results, Selection, Span, in_blocks,
    point_bytes, resumed, subscript,
};

/// Largest n, and largest number of nearest neighbours.
const MAX_SYMMETRY: f64 = 100.0;
const MAX_NEAREST: f64 = 100.0;

/// The rules of neighbours, in the order of [`Neighbours`].
const RULES: [&str; 3] = ["nearest", "delaunay", "voronoi"];

pub(super) const SYMMETRY: Parameter = Parameter::up_to(
    "n",
    MAX_SYMMETRY,
    Default::Number(6.0),
    "n of exp(niθ): 4 square, 6 hexagonal",
);

pub(super) const NEIGHBOURS: Parameter = Parameter::word(
    "neighbours",
    &RULES,
    Default::FromScene("nearest"),
    "the 'k' nearest; cells that share an edge; the same, weighted by its length",
);

pub(super) const NEAREST: Parameter = Parameter::up_to(
    "k",
    MAX_NEAREST,
    Default::Number(6.0),
    "nearest neighbours, with neighbours = \"nearest\" alone",
);

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "hexatic-order",
    summary: "bond-orientational order ψ6, or another ψn, local and global, at each sample",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[SYMMETRY, NEIGHBOURS, NEAREST],
    figures: &["mean |ψ", "|mean ψ"],
    start: |selection| Ok(in_blocks(observer(selection)?)),
    resume: resumed::<HexaticOrder>,
};

fn observer(selection: &Selection<'_>) -> Result<HexaticOrder> {
    let (symmetry, neighbours) = rule(selection)?;
    Ok(HexaticOrder::with_neighbours(
        selection.group,
        symmetry,
        neighbours,
    ))
}

/// n and the rule of the neighbours of a kind that has these parameters.
///
/// # Errors
/// The number of nearest neighbours is given beside another rule.
pub(super) fn rule(selection: &Selection<'_>) -> Result<(u32, Neighbours)> {
    let neighbours = match selection.given_word(NEIGHBOURS.name) {
        Some("delaunay") => Neighbours::Delaunay,
        Some("voronoi") => Neighbours::Voronoi,
        _ => Neighbours::Nearest(selection.whole(NEAREST.name)),
    };
    let is_nearest = matches!(neighbours, Neighbours::Nearest(_));
    ensure!(
        is_nearest || selection.given(NEAREST.name).is_none(),
        "'k' is the number of nearest neighbours: remove it, or set neighbours = \"nearest\""
    );
    Ok((selection.whole(SYMMETRY.name) as u32, neighbours))
}

impl Measured for HexaticOrder {
    /// Local order, its mean square, global order.
    fn sums(&self) -> Vec<[f64; 2]> {
        self.sums()
    }

    fn bytes_per_sample(&self) -> usize {
        point_bytes(self.series())
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let points = self.series();
        let psi = subscript("ψ", self.symmetry());
        let of =
            |part: fn(&HexaticPoint) -> f64| points.iter().map(|point| Some(part(point))).collect();
        let title = format!("Bond-orientational order {psi}");
        let table = Table::new(context.table("hexatic-order"), title)
            .abscissa(
                "time",
                "time",
                points.iter().map(|point| point.time).collect(),
            )
            .value("local", "1", of(|point| point.local))
            .value("global", "1", of(|point| point.global))
            .caption(format!(
                "Mean of |{psi}|, and |mean of {psi}|, with {}.",
                in_words((self.symmetry(), self.neighbours()))
            ));
        let names = [
            format!("mean |{psi}| of the bodies"),
            format!("mean |{psi}|² of the bodies"),
            format!("|mean {psi}|"),
        ];
        let named = names.iter().map(|name| (name.as_str(), "1", None));
        let figures = context.figures(named, means, "");
        Results {
            tables: vec![table],
            figures,
            ..Results::default()
        }
    }
}

/// The neighbours of ψₙ in words.
pub(super) fn in_words((symmetry, neighbours): (u32, Neighbours)) -> String {
    match neighbours {
        Neighbours::Nearest(6) if symmetry == 6 => {
            "the six nearest neighbours: 1 in a triangular lattice".to_owned()
        }
        Neighbours::Nearest(count) => format!("the {count} nearest neighbours"),
        Neighbours::Delaunay => "the neighbours of the Voronoi cells".to_owned(),
        _ => "the neighbours of the Voronoi cells, weighted by the common edge".to_owned(),
    }
}
