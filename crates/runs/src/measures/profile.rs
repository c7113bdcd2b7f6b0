//! `profile`: density, velocity, kT, stress and heat current along an axis, or over the distance
//! from a point or a wall.

use anyhow::{Result, ensure};
use carom::{
    Group, View,
    engine::BodyView,
    observers::{FieldBins, Fields, WallsAcross},
};
use carom_tables::{BlockMean, Figure, Sums, Table};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::curves::{Taken, TransportCurve};

use super::{
    Context, Default, HardDiscs, MeasureKind, Measured, Of, Parameter, Results, Selection, Span,
    fields::{CAPTION, DENSITY, HEAT_ALONG, KT, columns, of_quantity},
    hard_discs::SONINE,
    in_blocks,
    known::Known,
    resumed,
};

/// Bins of a profile.
const BINS: f64 = 50.0;

/// Most bins of a profile. More: blocks of all fields take more than 200 MB.
const MAX_BINS: usize = 10_000;

/// The heat conductivity is taken between walls, without this share of their distance at each: the
/// temperature jumps at a wall.
const AT_WALLS: f64 = 0.25;

/// Fewest bins of a slope.
const MIN_BINS: usize = 4;

/// The number of discs of a gas that counts as infinite.
const INFINITE: usize = 1_000_000_000;

/// The point of a profile or front.
pub(super) const POINT: Parameter = Parameter::point(
    "point",
    Default::FromScene("none"),
    "the profile is over the distance from this point (length)",
);

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "profile",
    summary: "density, area fraction, velocity, kT, spin, stress and heat current along an axis, or by the distance \
              from a point or a wall",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[
        Parameter::word(
            "axis",
            &["x", "y"],
            Default::FromScene("x"),
            "axis of the profile; excludes 'point' and 'wall'",
        ),
        POINT,
        Parameter::tag(
            "wall",
            Default::FromScene("none"),
            "the profile is over the distance from the wall across the box with this tag",
        ),
        Parameter::whole("bins", Default::Number(BINS), "bins, at most 10 000"),
        Parameter::positive(
            "max",
            Default::FromScene("half a side of the box"),
            "longest distance from the point or the wall (length)",
        ),
    ],
    figures: &["heat conductivity λ/k from the profile"],
    start: |selection| Ok(in_blocks(profile(selection)?)),
    resume: resumed::<Profile>,
};

/// Fields in bins, and what they are bins of.
type Profile = Known<Fields, Facts>;

/// What the table and the prediction of a profile depend on.
#[derive(Serialize, Deserialize)]
pub(super) struct Facts {
    /// Where the bins are, in words.
    place: String,
    /// The places along the profile between which heat flows from one wall to another.
    slab: Option<[f64; 2]>,
    /// Mass and diameter of equal discs.
    discs: Option<[f64; 2]>,
}

fn profile(selection: &Selection<'_>) -> Result<Profile> {
    let bins = selection.whole("bins");
    ensure!(
        bins <= MAX_BINS,
        "'bins' must be at most {MAX_BINS}, but is {bins}"
    );
    let (axis, point) = (selection.given_word("axis"), selection.given_point("point"));
    let wall = selection.given_group("wall")?;
    let given = usize::from(axis.is_some()) + usize::from(point.is_some());
    ensure!(
        given + usize::from(wall.is_some()) <= 1,
        "'axis', 'point' and 'wall' exclude each other: give one of them"
    );
    let layout = if let Some(point) = point {
        ProfileLayout::around_point(selection, point, bins)?
    } else if let Some(wall) = wall {
        ProfileLayout::beside_wall(selection, wall, bins)?
    } else {
        ProfileLayout::along_axis(selection, axis.unwrap_or("x"), bins)?
    };
    Ok(Known {
        observer: Fields::new(selection.group, layout.bins),
        facts: Facts {
            place: layout.place,
            slab: layout.slab,
            discs: equal_discs(selection),
        },
    })
}

/// Where the bins of a profile are.
struct ProfileLayout {
    bins: FieldBins,
    /// In words.
    place: String,
    /// The places along the profile between which heat flows from one wall to another (length).
    slab: Option<[f64; 2]>,
}

impl ProfileLayout {
    fn around_point(selection: &Selection<'_>, point: [f64; 2], bins: usize) -> Result<Self> {
        let bounds = selection.view.bounds();
        let longest = selection
            .given("max")
            .unwrap_or(0.5 * bounds.sides().min_element());
        let [x, y] = point;
        Ok(Self {
            bins: FieldBins::around_point(&bounds, DVec2::from(point), longest, bins)?,
            place: format!("by the distance from ({x}, {y})"),
            slab: None,
        })
    }

    fn beside_wall(selection: &Selection<'_>, wall: Group, bins: usize) -> Result<Self> {
        let bounds = selection.view.bounds();
        let WallsAcross { axis, places, .. } = WallsAcross::new(selection.view, wall)?;
        let [place] = places[..] else {
            anyhow::bail!(
                "'wall' must name a single wall, but {} carry its tag",
                places.len()
            );
        };
        let longest = selection.given("max").unwrap_or(0.5 * bounds.sides()[axis]);
        let name = selection.given_word("wall").unwrap_or_default();
        Ok(Self {
            bins: FieldBins::beside_wall(&bounds, axis, place, longest, bins)?,
            place: format!("by the distance from the wall {name}"),
            slab: None,
        })
    }

    fn along_axis(selection: &Selection<'_>, axis: &str, bins: usize) -> Result<Self> {
        ensure!(
            selection.given("max").is_none(),
            "'max' is the longest distance from a point or a wall; a profile along an axis covers the whole box: \
             leave 'max' out"
        );
        let along = usize::from(axis == "y");
        let counts = if along == 0 { [bins, 1] } else { [1, bins] };
        Ok(Self {
            slab: slab(selection.view, along),
            bins: FieldBins::grid(&selection.view.bounds(), counts)?,
            place: format!("along {axis}"),
        })
    }
}

/// The first two neighbouring walls across an axis that have different temperatures (length).
fn slab(view: &View<'_>, axis: usize) -> Option<[f64; 2]> {
    let heated = |body: &BodyView<'_>| body.body.wall_temperature().is_some();
    let place = |wall: BodyView<'_>| {
        let [from, to] = wall.wall()?;
        let is_across = from[axis] == to[axis];
        let side = view.bounds().sides()[axis];
        is_across.then_some((from[axis].rem_euclid(side), wall.body.wall_temperature()?))
    };
    let walls = view.bodies().filter(heated);
    let mut walls: Vec<(f64, f64)> = walls.map(place).collect::<Option<_>>()?;
    walls.sort_by(|one, other| one.0.total_cmp(&other.0));
    let mut pairs = walls.windows(2);
    let pair = pairs.find(|pair| pair[0].1 != pair[1].1 && pair[0].0 < pair[1].0)?;
    let between = [pair[0].0, pair[1].0];
    let is_between = |wall: BodyView<'_>| {
        let [low, high] = between;
        wall.wall().is_some_and(|ends| {
            let is_inside = |end: DVec2| low < end[axis] && end[axis] < high;
            ends.into_iter().any(is_inside)
        })
    };
    // A wall in between stops the heat, in part or altogether.
    (!view.bodies().any(is_between)).then_some(between)
}

/// Mass and diameter of the moving bodies, if they are equal discs and belong to the group, and no
/// rules for pairs of tags apply.
fn equal_discs(selection: &Selection<'_>) -> Option<[f64; 2]> {
    if selection.view.has_pair_rules() {
        return None;
    }
    let moving = || {
        let bodies = selection.view.bodies();
        bodies.filter(|body| body.body.is_free())
    };
    let facts = |body: BodyView<'_>| {
        let molecule = body.body.molecule();
        let is_member = selection.group == Group::All || selection.group.contains(body.body);
        (molecule.is_disc() && is_member)
            .then(|| [molecule.mass(), 2.0 * molecule.bounding_radius()])
    };
    let first = facts(moving().next()?)?;
    moving()
        .all(|body| facts(body) == Some(first))
        .then_some(first)
}

impl Measured for Profile {
    const OF_INTERVALS: bool = true;

    fn sums(&self) -> Sums {
        self.observer.sums()
    }

    fn results(&self, means: &[BlockMean], context: &Context<'_>) -> Results {
        let (fields, facts) = (&self.observer, &self.facts);
        let bins = fields.bins();
        let (name, axis) = match bins.counts() {
            None => ("distance", 0),
            Some([_, 1]) => ("x", 0),
            Some(_) => ("y", 1),
        };
        let places: Vec<f64> = (0..bins.len()).map(|bin| bins.middle(bin)[axis]).collect();
        let title = format!("Profile {}", facts.place);
        let table = Table::new(context.table(KIND.name), title)
            .abscissa(name, "length", places.clone())
            .undrawn(
                "area",
                "length²",
                (0..bins.len()).map(|bin| bins.area(bin)).collect(),
            );
        Results {
            tables: vec![columns(table, fields, means).caption(CAPTION)],
            figures: conductivity(facts, axis, &places, means, context)
                .into_iter()
                .collect(),
            ..Results::default()
        }
    }
}

/// The bins of a profile in the middle between two walls, through which a line is fitted by least
/// squares.
struct MiddleBins<'a> {
    /// The places of all bins (length).
    places: &'a [f64],
    /// The means of all quantities in all bins.
    means: &'a [BlockMean],
    inside: Vec<usize>,
    /// The mean of the places inside (length).
    centre: f64,
    /// The sum of the squares of the distances from it (length²).
    spread: f64,
}

impl<'a> MiddleBins<'a> {
    /// The bins between walls at these places; `None` if they are too few for a slope.
    fn new([low, high]: [f64; 2], places: &'a [f64], means: &'a [BlockMean]) -> Option<Self> {
        let margin = AT_WALLS * (high - low);
        let is_inside = |place: f64| (low + margin..high - margin).contains(&place);
        let inside: Vec<usize> = (0..places.len())
            .filter(|&bin| is_inside(places[bin]))
            .collect();
        if inside.len() < MIN_BINS {
            return None;
        }
        let centre = inside.iter().map(|&bin| places[bin]).sum::<f64>() / inside.len() as f64;
        let spread = inside
            .iter()
            .map(|&bin| (places[bin] - centre).powi(2))
            .sum();
        Some(Self {
            places,
            means,
            inside,
            centre,
            spread,
        })
    }

    /// The mean of a quantity over the bins.
    fn mean(&self, quantity: usize) -> Option<f64> {
        let all = of_quantity(self.means, self.places.len(), quantity);
        let values = self.inside.iter().map(|&bin| all.get(bin)?.value);
        Some(values.sum::<Option<f64>>()? / self.inside.len() as f64)
    }

    /// The weight of a bin in the slope (1/length).
    fn weight(&self, bin: usize) -> f64 {
        (self.places[bin] - self.centre) / self.spread
    }

    /// The slope of a quantity along the profile.
    fn slope(&self, quantity: usize) -> Option<f64> {
        let all = of_quantity(self.means, self.places.len(), quantity);
        let terms = self.inside.iter();
        terms
            .map(|&bin| Some(self.weight(bin) * all.get(bin)?.value?))
            .sum()
    }
}

/// The heat conductivity by Boltzmann's constant, −q / (dkT/dx) in the middle between two walls
/// with a temperature.
///
/// q is the mean heat current, and dkT/dx = Σ c_i kT_i with the weights of a line by least squares.
/// The error is that of the linear combination of all bins, λ ∝ −Σ q_i/(n s) + q Σ c_i kT_i/s².
fn conductivity(
    facts: &Facts,
    axis: usize,
    places: &[f64],
    means: &[BlockMean],
    context: &Context<'_>,
) -> Option<Figure> {
    let middle = MiddleBins::new(facts.slab?, places, means)?;
    let count = middle.inside.len() as f64;
    let along = HEAT_ALONG + axis;
    let (slope, current) = (middle.slope(KT)?, middle.mean(along)?);
    let factors = middle.inside.iter().flat_map(|&bin| {
        [
            (along * places.len() + bin, -1.0 / (count * slope)),
            (
                KT * places.len() + bin,
                current * middle.weight(bin) / (slope * slope),
            ),
        ]
    });
    let factors: Vec<(usize, f64)> = factors.collect();
    let curve = TransportCurve {
        lags: places,
        means,
        runs: std::slice::from_ref(context.blocks),
        block: f64::INFINITY,
        of: Taken::Itself,
    };
    // The combination of the deviations; its value is 0, since both terms are equal.
    let error = curve
        .combination(&factors)
        .map(|value| value.standard_error);
    let gas = || {
        let [mass, diameter] = facts.discs.filter(|_| context.is_elastic)?;
        let density = middle.mean(DENSITY)?;
        Some(HardDiscs {
            count: INFINITE,
            diameter,
            mass,
            temperature: middle.mean(KT)?,
            area: INFINITE as f64 / density,
        })
    };
    let name = context.named("heat conductivity λ/k from the profile");
    let figure = Figure::new(name, -current / slope, "1/time").error(error);
    let prediction = gas()
        .filter(HardDiscs::is_known)
        .map(|gas| gas.heat_conductivity());
    slope
        .is_normal()
        .then(|| figure.predicted(prediction, SONINE))
}
