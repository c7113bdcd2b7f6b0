//! `nematic`, `tetratic`, `k-atic`: the order of orientations with k-fold symmetry.

use anyhow::Result;
use carom::{CollisionReport, Observer};
use carom::{OrientationalOrder, View, engine::Body, observers::OrderRanges};
use carom_tables::{BlockMean, Table};
use serde::{Deserialize, Serialize};

use crate::curves::MIN_PAIRS;

use super::{
    Context, Default, MAX_LAG, Measure, MeasureKind, Measured, Of, Parameter, Results, Selection,
    Span, in_blocks, point_bytes, resumed, subscript,
};

/// Cutoff of the local order, and longest distance of g_k, in diameters of the largest body.
const NEAR_DIAMETERS: f64 = 1.5;
const FAR_DIAMETERS: f64 = 10.0;

/// Default number of bins.
const BINS: f64 = 100.0;

/// Largest k: no molecule has such a symmetry, and exp(kiθ) keeps its digits.
const MAX_K: f64 = 100.0;

/// Share of the shorter side that a distance may have: beyond half of it, periodic images would be
/// missed.
const MAX_SHARE: f64 = 0.499;

const CUTOFF: Parameter = Parameter::positive(
    "cutoff",
    Default::FromScene("1.5 diameters of the largest body"),
    "distance of the neighbours of the local order (length)",
);

const DISTANCE: Parameter = Parameter::positive(
    "distance",
    Default::FromScene("10 diameters of the largest body"),
    "longest distance of g_k(r) (length)",
);

const DISTANCE_BINS: Parameter =
    Parameter::whole("bins", Default::Number(BINS), "bins up to 'distance'");

/// Beginnings of the names of the figures.
const FIGURES: &[&str] = &["order S", "mean square order S", "local order cos "];

const K_ATIC_NAME: &str = "k-atic";

pub(super) const NEMATIC: MeasureKind = MeasureKind {
    name: "nematic",
    summary: "nematic order of orientations (k = 2): global, local, over distances and in time",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[CUTOFF, DISTANCE, DISTANCE_BINS, MAX_LAG],
    figures: FIGURES,
    start: |selection| start(selection, 2),
    resume: resumed::<KAtic>,
};

pub(super) const TETRATIC: MeasureKind = MeasureKind {
    name: "tetratic",
    summary: "tetratic order of orientations (k = 4): global, local, over distances and in time",
    start: |selection| start(selection, 4),
    ..NEMATIC
};

pub(super) const K_ATIC: MeasureKind = MeasureKind {
    name: K_ATIC_NAME,
    summary: "order of orientations with k-fold symmetry: global, local, over distances and in time",
    parameters: &[
        Parameter::up_to(
            "k",
            MAX_K,
            Default::Number(6.0),
            "k of cos kθ: 1 polar, 2 nematic, 4 tetratic",
        ),
        CUTOFF,
        DISTANCE,
        DISTANCE_BINS,
        MAX_LAG,
    ],
    start: |selection| start(selection, selection.whole("k")),
    ..NEMATIC
};

/// The measures of bodies with an axis.
pub(crate) const OF_AXES: [&str; 4] = [
    NEMATIC.name,
    TETRATIC.name,
    K_ATIC.name,
    super::body_frame_diffusion::KIND.name,
];

/// Orientational order under the name by which the scene asks for it.
#[derive(Serialize, Deserialize)]
struct KAtic {
    name: String,
    order: OrientationalOrder,
}

fn start(selection: &Selection<'_>, k: usize) -> Result<Box<dyn Measure>> {
    let bounds = selection.view.bounds();
    let diameter = 2.0 * selection.largest_radius(selection.group);
    let half = MAX_SHARE * bounds.sides().min_element();
    let length = |name: &str, diameters: f64| {
        let default = (diameters * diameter).min(half);
        selection
            .given(name)
            .unwrap_or(if default > 0.0 { default } else { half })
    };
    let ranges = OrderRanges {
        near: length(CUTOFF.name, NEAR_DIAMETERS),
        far: length(DISTANCE.name, FAR_DIAMETERS),
        bins: selection.whole(DISTANCE_BINS.name),
        spacing: selection.interval(),
        longest: selection.longest_lag(),
    };
    let order = OrientationalOrder::new(selection.group, k as u32, &bounds, ranges)?;
    let name = selection.kind_name().to_owned();
    Ok(in_blocks(KAtic { name, order }))
}

impl Observer for KAtic {
    fn watches_any(&self) -> bool {
        self.order.watches_any()
    }

    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.order.watches(bodies)
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.order.collision(report);
    }

    fn sample(&mut self, view: &View<'_>) {
        self.order.sample(view);
    }
}

impl KAtic {
    fn table(&self, part: &str, context: &Context<'_>) -> String {
        context.table(&format!("{}{part}", self.name))
    }

    /// The order at each sample.
    fn series(&self, context: &Context<'_>) -> Table {
        let (points, k) = (self.order.series(), self.order.symmetry());
        let times = points.iter().map(|point| point.time).collect();
        let global = points.iter().map(|point| Some(point.global)).collect();
        let director = points.iter().map(|point| Some(point.director)).collect();
        let local = points.iter().map(|point| point.local).collect();
        let s = subscript("S", k);
        Table::new(
            self.table("", context),
            format!("Order of orientations {s}"),
        )
        .abscissa("time", "time", times)
        .value("order", "1", global)
        .value("local", "1", local)
        .value("director", "radian", director)
        .caption(format!(
            "{s} = |mean of exp({k}iθ)|; local: cos {k}Δθ with the neighbours up to {:.4} away; director: the common \
             direction, up to multiples of a turn by {k}.",
            self.order.near()
        ))
    }

    /// g_k(r).
    fn distances(&self, means: &[BlockMean], context: &Context<'_>) -> Table {
        let (points, k) = (self.order.pair_points(), self.order.symmetry());
        Table::new(
            self.table("-distance", context),
            format!("Order of pairs {}(r)", subscript("g", k)),
        )
        .abscissa("distance", "length", points.iter().map(|point| point.distance).collect())
        .counts("pairs", points.iter().map(|point| point.pairs).collect())
        .means("g", "1", means)
        .caption(format!(
            "⟨cos {k}Δθ⟩ of the bodies at a distance of their centres: 1 for aligned bodies, 0 without order."
        ))
    }

    /// The correlations in time, of a body and of the group.
    fn lags(&self, means: [&[BlockMean]; 2], context: &Context<'_>) -> Table {
        let (points, k) = (self.order.lag_points(), self.order.symmetry());
        let points: Vec<_> = points
            .iter()
            .filter(|point| point.pairs >= MIN_PAIRS)
            .collect();
        let lags: Vec<f64> = points.iter().map(|point| point.lag).collect();
        let [of_body, of_group] = means.map(|means| context.resolved(means, &lags));
        Table::new(
            self.table("-lag", context),
            format!("Order of orientations {} over the lag", subscript("S", k)),
        )
        .logarithmic()
        .abscissa("lag", "time", lags)
        .counts("pairs", points.iter().map(|point| point.pairs).collect())
        .means("of_body", "1", &of_body)
        .means("of_group", "1", &of_group)
        .caption(format!(
            "⟨cos {k}(θ(t) − θ(0))⟩ of a body, and Re ⟨Z(t) Z*(0)⟩ of the group, Z = mean of exp({k}iθ)."
        ))
    }
}

impl Measured for KAtic {
    fn sums(&self) -> Vec<[f64; 2]> {
        self.order.sums()
    }

    fn bytes_per_sample(&self) -> usize {
        point_bytes(self.order.series())
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        if self.order.series().is_empty() {
            return Results::default();
        }
        let k = self.order.symmetry();
        let (scalars, rest) = means.split_at(means.len().min(3));
        let (bins, rest) = rest.split_at(self.order.pair_points().len().min(rest.len()));
        let (of_body, of_group) = rest.split_at(rest.len() / 2);
        let s = subscript("S", k);
        let names = [
            format!("order {s}"),
            format!("mean square order {s}²"),
            format!("local order cos {k}Δθ"),
        ];
        let named = names.iter().map(|name| (name.as_str(), "1", None));
        let mut tables = vec![self.series(context), self.distances(bins, context)];
        let lags = self.lags([of_body, of_group], context);
        tables.extend((!lags.rows().is_empty()).then_some(lags));
        Results {
            tables,
            figures: context.figures(named, scalars, ""),
            ..Results::default()
        }
    }
}
