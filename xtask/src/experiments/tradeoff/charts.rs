//! Charts of a scene: time for each collision against each error, with the settings that no other
//! dominates on both.

use anyhow::Result;
use carom_report::scatter::{Mark, Point, Scatter, pareto};

use super::{
    knobs::{FAMILIES, MODEL},
    measures::relative,
    results::{SceneResult, SettingResult},
};

/// Shallower overlaps are drawn at this value: they are rounding errors (diameters).
const SHALLOWEST: f64 = 1e-16;

/// A chart of one error: label, file name, and value for a setting.
type Price = (&'static str, &'static str, fn(&SettingResult, &SettingResult) -> Option<(f64, Mark)>);

const PRICES: [Price; 5] = [
    ("wrong contacts in a million", "wrong-contacts", |found, _| {
        if found.setting.family == MODEL || found.tally.judged == 0 {
            return None;
        }
        let wrong = found.tally.wrong();
        Some(if wrong > 0.0 {
            (wrong, Mark::Measured)
        } else {
            (found.tally.upper_bound_of_none(), Mark::AtMost)
        })
    }),
    ("deepest overlap in diameters", "deepest-overlap", |found, _| {
        (found.physics.blocks > 0).then(|| (found.physics.deepest.max(SHALLOWEST), Mark::Measured))
    }),
    ("effective error in box sides", "effective-error", |found, _| {
        found.effective.map(|effective| (effective.value.max(SHALLOWEST), Mark::Measured))
    }),
    ("|pressure − exact| / exact", "pressure", |found, exact| {
        beyond_error(relative(found.physics.pressure, exact.physics.pressure)?)
    }),
    ("|collision rate − exact| / exact", "collision-rate", |found, exact| {
        beyond_error(relative(found.physics.rate, exact.physics.rate)?)
    }),
];

/// A difference below two standard errors is drawn as an upper bound.
fn beyond_error(mean: super::measures::Mean) -> Option<(f64, Mark)> {
    let (value, bound) = (mean.value.abs(), 2.0 * mean.error);
    let sound = |x: f64| x.is_finite() && x > 0.0;
    if value > bound && sound(value) {
        Some((value, Mark::Measured))
    } else {
        sound(bound).then_some((bound, Mark::AtMost))
    }
}

/// Draws the charts: file names and SVG.
///
/// # Errors
/// A value is not finite.
pub fn draw(result: &SceneResult) -> Result<Vec<(String, String)>> {
    let exact = &result.found[0];
    let chart = |(y_label, file, price): &Price| {
        let points: Vec<Point> = result
            .found
            .iter()
            .filter_map(|found| {
                let (y, mark) = price(found, exact)?;
                let label = found.setting.name.clone();
                Some(Point { family: found.setting.family, label, x: found.time?, y, mark })
            })
            .collect();
        let scatter = Scatter {
            title: format!("{}: time and {y_label}", result.named.name),
            x_label: "processor time for each collision relative to the exact run".to_owned(),
            y_label: (*y_label).to_owned(),
            families: FAMILIES.map(str::to_owned).to_vec(),
            front: pareto(&points),
            points,
        };
        Ok((format!("{}-{file}.svg", result.named.name), scatter.svg()?))
    };
    PRICES.iter().map(chart).collect()
}
