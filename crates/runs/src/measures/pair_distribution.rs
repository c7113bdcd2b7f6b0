//! `pair-distribution`: g(r) of the centres of mass of a group, or of two, `A,B`.

use std::f64::consts::PI;

use carom::{Group, Observer, PairDistribution, View, engine::BodyView};
use carom_tables::{BlockMean, Figure, Table};
use serde::{Deserialize, Serialize};

use super::{
    Context, Default, MeasureKind, Measured, Of, Parameter, Results, Selection, Span,
    hard_discs::{DiscMixture, LIU, SANTOS},
    in_blocks, resumed,
};

/// Cutoff of distances in diameters, and bins for each diameter: the sum of the radii of the
/// largest bodies of both groups.
pub(super) const DIAMETERS: f64 = 5.0;
const BINS_PER_DIAMETER: f64 = 50.0;

/// Largest number of bins that the scene does not give.
const MAX_BINS: f64 = 1e5;

/// Bins beyond contact through which a line gives the contact value. Fewer: a larger error. More:
/// the curvature of ln g.
const CONTACT_BINS: usize = 5;

/// The number of bins of distances, with this default.
pub(super) const fn bins(default: &'static str) -> Parameter {
    Parameter::whole("bins", Default::FromScene(default), "bins up to 'max'")
}

/// The longest distance of pairs, with this default.
pub(super) const fn longest(default: &'static str) -> Parameter {
    Parameter::positive(
        "max",
        Default::FromScene(default),
        "longest distance (length)",
    )
}

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "pair-distribution",
    summary: "pair distribution function g(r) of the centres of mass; with two tags, of the pairs of both groups",
    of: Of::TwoGroups,
    span: Span::Measurement,
    parameters: &[
        bins("50 for each diameter"),
        longest("5 diameters of the largest bodies"),
    ],
    figures: &["g(r) at contact"],
    start: |selection| Ok(in_blocks(Pairs::new(selection)?)),
    resume: resumed::<Pairs>,
};

/// g(r) of two groups, with the distance at which their discs touch.
#[derive(Serialize, Deserialize)]
struct Pairs {
    distribution: PairDistribution,
    contact: Option<Contact>,
}

/// A pair of discs that touch.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Contact {
    /// Distance of the centres (length).
    distance: f64,
    /// g there in a mixture of elastic discs at equilibrium, where theory knows it.
    of_mixture: Option<f64>,
}

impl Pairs {
    fn new(selection: &Selection<'_>) -> anyhow::Result<Self> {
        let (cutoff, bins) = distances(selection, DIAMETERS, BINS_PER_DIAMETER);
        let (groups, view) = (selection.groups(), selection.view);
        let distribution = PairDistribution::new(groups, &view.bounds(), cutoff, bins)?;
        Ok(Self {
            distribution,
            contact: Contact::new(groups, view),
        })
    }
}

impl Contact {
    /// The contact of the discs of two groups; `None` unless each group has equal ones alone.
    fn new(groups: [Group; 2], view: &View<'_>) -> Option<Self> {
        // Diameters of pairs may be others than the mean of those of the bodies.
        if view.has_pair_rules() {
            return None;
        }
        let [one, other] = groups.map(|group| diameter_of_all(group, view));
        let diameters = [one?, other?];
        Some(Self {
            distance: 0.5 * (diameters[0] + diameters[1]),
            of_mixture: mixture(view).map(|mixture| mixture.contact_value(diameters)),
        })
    }
}

/// The diameter of the discs of a group, if all of it are equal discs (length).
fn diameter_of_all(group: Group, view: &View<'_>) -> Option<f64> {
    let mut members = view
        .bodies()
        .filter(|body| !body.body.is_wall() && group.contains(body.body));
    let diameter = diameter_of(&members.next()?)?;
    members
        .all(|body| diameter_of(&body) == Some(diameter))
        .then_some(diameter)
}

/// The diameter of a disc (length); `None` of other bodies.
fn diameter_of(body: &BodyView<'_>) -> Option<f64> {
    let molecule = body.body.molecule();
    molecule.is_disc().then(|| 2.0 * molecule.bounding_radius())
}

/// All bodies as a homogeneous fluid of discs, if they are one that is not too dense.
fn mixture(view: &View<'_>) -> Option<DiscMixture> {
    if view.bonds().len() > 0 || view.bodies().any(|body| !body.body.is_free()) {
        return None;
    }
    let diameters: Vec<f64> = view
        .bodies()
        .map(|body| diameter_of(&body))
        .collect::<Option<_>>()?;
    let count = diameters.len() as f64;
    let covered = diameters.iter().map(|d| 0.25 * PI * d * d).sum();
    let mean = diameters.iter().sum::<f64>() / count;
    let mixture = DiscMixture::new(count, mean, covered, view.bounds().area());
    mixture.is_known().then_some(mixture)
}

impl Observer for Pairs {
    fn watches_any(&self) -> bool {
        self.distribution.watches_any()
    }

    fn sample(&mut self, view: &View<'_>) {
        self.distribution.sample(view);
    }
}

/// The diameter of the largest bodies: the sum of the radii of both groups (length).
fn diameter(selection: &Selection<'_>) -> f64 {
    let [one, other] = selection
        .groups()
        .map(|group| selection.largest_radius(group));
    one + other
}

/// The longest distance of pairs, if the scene does not give it: so many diameters, but less than
/// half the shorter side (length).
pub(super) fn longest_distance(selection: &Selection<'_>, diameters: f64) -> f64 {
    // Slightly less than half: beyond it, periodic images would be missed.
    let half = 0.499 * selection.view.bounds().sides().min_element();
    (diameters * diameter(selection)).min(half)
}

/// The longest distance `max` of pairs and the number of `bins` up to it, as given, or so many
/// diameters with so many bins each.
pub(super) fn distances(
    selection: &Selection<'_>,
    diameters: f64,
    bins_per_diameter: f64,
) -> (f64, usize) {
    // A whole number of bins, so that contact is the edge of a bin.
    let width = diameter(selection) / bins_per_diameter;
    let longest = selection
        .given("max")
        .unwrap_or_else(|| longest_distance(selection, diameters));
    let bins = (longest / width).floor().clamp(1.0, MAX_BINS);
    match selection.given("bins") {
        Some(bins) => (longest, bins as usize),
        None => (bins * width, bins as usize),
    }
}

impl Measured for Pairs {
    fn sums(&self) -> Vec<[f64; 2]> {
        self.distribution.sums()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let points = self.distribution.points();
        let table = Table::new(context.table("pair-distribution"), "Pair distribution g(r)")
            .abscissa("distance", "length", points.iter().map(|point| point.distance).collect())
            .counts("pairs", points.iter().map(|point| point.pairs).collect())
            .means("g", "1", means)
            .derived("−ln g", "1", means.iter().map(|mean| potential(mean.value?)).collect())
            .caption(
                "Of the centres of mass; 1 where positions are independent. −ln g is the potential of mean force, by kT.",
            );
        let distances: Vec<f64> = points.iter().map(|point| point.distance).collect();
        Results {
            tables: vec![table],
            figures: self
                .contact
                .and_then(|contact| contact.value(&distances, means, context))
                .into_iter()
                .collect(),
            ..Results::default()
        }
    }
}

/// −ln g, where g is not 0.
fn potential(g: f64) -> Option<f64> {
    (g > 0.0).then(|| -g.ln())
}

impl Contact {
    /// g by a line through the logarithms of the first bins beyond the contact.
    fn value(
        &self,
        distances: &[f64],
        means: &[BlockMean],
        context: &Context<'_>,
    ) -> Option<Figure> {
        // Centres of bins that begin at contact, to rounding, or beyond.
        let [first, second] = distances.first_chunk()?;
        let begin = self.distance + 0.49 * (second - first);
        let beyond = distances
            .iter()
            .zip(means)
            .filter(|(distance, _)| **distance > begin);
        let near: Vec<(f64, f64, f64)> = beyond
            .take(CONTACT_BINS)
            .map(|(distance, mean)| {
                Some((distance - self.distance, mean.value?, mean.standard_error?))
            })
            .collect::<Option<_>>()?;
        if near.iter().any(|point| point.1 <= 0.0) {
            return None;
        }
        // ln g falls nearly in proportion: Σ c_i ln g_i with the weights c_i of the least-squares
        // line at distance 0.
        let count = near.len() as f64;
        let centre = near.iter().map(|point| point.0).sum::<f64>() / count;
        let spread: f64 = near.iter().map(|point| (point.0 - centre).powi(2)).sum();
        let weight = |x: f64| 1.0 / count - centre * (x - centre) / spread;
        let value = near
            .iter()
            .map(|&(x, g, _)| weight(x) * g.ln())
            .sum::<f64>()
            .exp();
        let error = value
            * near
                .iter()
                .map(|&(x, g, error)| (weight(x) * error / g).powi(2))
                .sum::<f64>()
                .sqrt();
        let figure = Figure::new(context.named("g(r) at contact"), value, "1").error(error);
        (near.len() == CONTACT_BINS).then(|| self.predicted(figure, context))
    }

    /// A figure with the value that theory expects, if it does.
    fn predicted(&self, figure: Figure, context: &Context<'_>) -> Figure {
        match (context.gas(), self.of_mixture) {
            (Some(gas), _) => figure.predicted(gas.contact_value(), LIU),
            (None, Some(value)) if context.is_equilibrium => figure.predicted(value, SANTOS),
            _ => figure,
        }
    }
}
