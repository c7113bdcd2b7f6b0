//! `front`: how far from a point the momentum that leaves it has come, and its power of time.

use carom::{Group, Observer, View};
use carom_tables::{BlockMean, Figure, Table, power_law::PowerLaw};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::{
    Context, Default, MeasureKind, Measured, Of, Parameter, Results, Selection, Span, in_blocks,
    point_bytes, resumed,
};

/// The outward momentum is a flow if it exceeds that of a thermal motion of the same energy by this
/// factor.
const FLOWS: f64 = 4.0;

pub(super) const KIND: MeasureKind = MeasureKind {
    name: "front",
    summary: "mean distance of the outward momentum from a point, R = Σ p_r r / Σ p_r, and its power of time, as of \
              a blast",
    of: Of::Group,
    span: Span::Measurement,
    parameters: &[Parameter::point(
        "point",
        Default::FromScene("the middle of the box"),
        "the point from which the momentum comes (length)",
    )],
    figures: &["power of time of the front"],
    start: |selection| Ok(in_blocks(Front::new(selection))),
    resume: resumed::<Front>,
};

/// Time and mean distance of the outward momentum at each sample that has any.
#[derive(Serialize, Deserialize)]
struct Front {
    group: Group,
    point: DVec2,
    series: Vec<[f64; 2]>,
}

impl Front {
    fn new(selection: &Selection<'_>) -> Self {
        let middle = 0.5 * selection.view.bounds().sides();
        Self {
            group: selection.group,
            point: selection.given_point("point").map_or(middle, DVec2::from),
            series: Vec::new(),
        }
    }
}

impl Observer for Front {
    fn watches_any(&self) -> bool {
        false
    }

    fn sample(&mut self, view: &View<'_>) {
        let members = view
            .bodies()
            .filter(|member| member.body.is_free() && self.group.contains(member.body));
        let (mut outward, mut moment, mut thermal) = (0.0, 0.0, 0.0);
        for member in members {
            let away = view
                .bounds()
                .nearest_image(member.motion.position - self.point);
            let mass = member.body.molecule().mass();
            let distance = away.length();
            let along = if distance > 0.0 {
                member.motion.velocity.dot(away / distance)
            } else {
                0.0
            };
            outward += mass * along;
            moment += mass * along * distance;
            thermal += mass * mass * member.motion.velocity.length_squared();
        }
        // Σ p_r of independent directions has the variance Σ p²/2.
        if outward > FLOWS * (0.5 * thermal).sqrt() {
            let time = view.time().to_f64();
            self.series.push([time, moment / outward]);
        }
    }
}

impl Measured for Front {
    fn bytes_per_sample(&self) -> usize {
        point_bytes(&self.series)
    }

    fn results(&self, _: &[BlockMean], context: &Context<'_>) -> Results {
        if self.series.is_empty() {
            return Results::default();
        }
        let of = |part: usize| self.series.iter().map(move |point| point[part]);
        let table = Table::new(context.table(KIND.name), "Front")
            .logarithmic()
            .abscissa("time", "time", of(0).collect())
            .value("distance", "length", of(1).map(Some).collect())
            .in_decades(&["distance"])
            .guide("distance", 0.5, "t^½", true)
            .caption(
                "R = Σ p_r r / Σ p_r of the momenta away from the point, at samples where they are no thermal noise. \
                 A blast from a point in a gas of discs at rest has R ∝ t^½ (Sedov 1946; Taylor 1950).",
            );
        let points: Vec<(f64, f64)> = self
            .series
            .iter()
            .map(|point| (point[0], point[1]))
            .filter(|(time, distance)| *time > 0.0 && *distance > 0.0)
            .collect();
        // The points of one path are not independent: one run has no error, several have that of
        // their scatter.
        let figure = |law: PowerLaw| {
            Figure::new(
                context.named("power of time of the front"),
                law.exponent,
                "1",
            )
        };
        Results {
            tables: vec![table],
            figures: PowerLaw::through(&points).map(figure).into_iter().collect(),
            ..Results::default()
        }
    }
}
