//! `hexatic-order`: the bond-orientational order ψₙ of a group.

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

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "hexatic-order",
    summary: "bond-orientational order ψ6, or another ψn, local and global, at each sample",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[
        Parameter::up_to(
            "n",
            MAX_SYMMETRY,
            Default::Number(6.0),
            "n of exp(niθ): 4 square, 6 hexagonal",
        ),
        Parameter::word(
            "neighbours",
            &RULES,
            Default::FromScene("nearest"),
            "the 'k' nearest; cells that share an edge; the same, weighted by its length",
        ),
        Parameter::up_to(
            "k",
            MAX_NEAREST,
            Default::Number(6.0),
            "nearest neighbours, with neighbours = \"nearest\" alone",
        ),
    ],
    figures: &["mean |ψ", "|mean ψ"],
    start: |selection| Ok(in_blocks(observer(selection)?)),
    resume: resumed::<HexaticOrder>,
};

fn observer(selection: &Selection<'_>) -> anyhow::Result<HexaticOrder> {
    let neighbours = match selection.given_word("neighbours") {
        Some("delaunay") => Neighbours::Delaunay,
        Some("voronoi") => Neighbours::Voronoi,
        _ => Neighbours::Nearest(selection.whole("k")),
    };
    let is_nearest = matches!(neighbours, Neighbours::Nearest(_));
    anyhow::ensure!(
        is_nearest || selection.given("k").is_none(),
        "'k' is the number of nearest neighbours: remove it, or set neighbours = \"nearest\""
    );
    let symmetry = selection.whole("n") as u32;
    Ok(HexaticOrder::with_neighbours(
        selection.group,
        symmetry,
        neighbours,
    ))
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
                rule(self)
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

/// The neighbours in words.
fn rule(order: &HexaticOrder) -> String {
    match order.neighbours() {
        Neighbours::Nearest(6) if order.symmetry() == 6 => {
            "the six nearest neighbours: 1 in a triangular lattice".to_owned()
        }
        Neighbours::Nearest(count) => format!("the {count} nearest neighbours"),
        Neighbours::Delaunay => "the neighbours of the Voronoi cells".to_owned(),
        _ => "the neighbours of the Voronoi cells, weighted by the common edge".to_owned(),
    }
}
