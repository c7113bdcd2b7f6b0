//! Charts of a scene: time for each collision against each error, with the settings that no other
//! dominates on both.

use anyhow::Result;
use carom_report::scatter::{Mark, Scatter, ScatterPoint, pareto};

use super::{
    knobs::FAMILIES,
    results::{KnobResult, SceneResult},
    table,
};

/// Shallower overlaps are drawn at this value: they are rounding errors (diameters).
const SHALLOWEST: f64 = 1e-16;

/// A chart of one error: label, file name, and value for a setting.
type Price = (
    &'static str,
    &'static str,
    fn(&KnobResult, &KnobResult) -> Option<(f64, Mark)>,
);

/// The error that leads the page first.
const PRICES: [Price; 4] = [
    (
        "wrong contacts in a million",
        "wrong-contacts",
        |found, _| {
            let wrong = found.wrong()?;
            Some((
                wrong.value,
                if wrong.is_upper {
                    Mark::AtMost
                } else {
                    Mark::Measured
                },
            ))
        },
    ),
    (
        "deepest overlap in diameters",
        "deepest-overlap",
        |found, _| {
            let deepest = found
                .tally
                .deepest
                .max(found.physics.deepest)
                .max(SHALLOWEST);
            (found.tally.intervals > 0).then_some((deepest, Mark::Measured))
        },
    ),
    (
        "effective error in box sides",
        "effective-error",
        |found, _| {
            found
                .effective
                .map(|effective| (effective.value.max(SHALLOWEST), Mark::Measured))
        },
    ),
    (
        "largest difference of a measure, relative",
        "measures",
        |found, exact| {
            let worst = table::worst(found, exact)?.percent()?;
            Some((1e-2 * worst[0].abs(), Mark::Measured)).filter(|worst| worst.0 > 0.0)
        },
    ),
];

/// What a chart shows.
pub const CAPTION: &str = "One point for each setting; fast settings are left, accurate ones are low. Rings with \
                           downward lines are upper bounds (no wrong contact was found, drawn at the 95 % bound). \
                           A line joins the settings that no other dominates in both, if there are several.";

/// Draws the charts that have points: file names and SVG.
///
/// # Errors
/// A value is not finite.
pub fn draw(result: &SceneResult) -> Result<Vec<(String, String)>> {
    let exact = result.exact();
    let mut charts = Vec::new();
    for (y_label, file, price) in &PRICES {
        let point = |found: &KnobResult| {
            let (y, mark) = price(found, exact)?;
            let label = found.knob.name.clone();
            Some(ScatterPoint {
                family: found.knob.family,
                label,
                x: found.time?.median,
                y,
                mark,
            })
        };
        let points: Vec<ScatterPoint> = result.found.iter().filter_map(point).collect();
        if points.is_empty() {
            continue;
        }
        let scatter = Scatter {
            title: format!("{}: time and {y_label}", result.name),
            x_label: "processor time for each collision relative to the exact run".to_owned(),
            y_label: (*y_label).to_owned(),
            families: FAMILIES.map(str::to_owned).to_vec(),
            front: pareto(&points),
            points,
        };
        charts.push((format!("{}-{file}.svg", result.name), scatter.svg()?));
    }
    Ok(charts)
}
