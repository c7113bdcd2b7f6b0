//! Tables: what each setting saves and gets wrong, in short for the page and in full for the files.

use carom_tables::{significant, with_error};

use super::{
    difference::Difference,
    knobs::FAMILIES,
    results::{Bound, KnobResult, SceneResult},
};

/// Columns of the table that leads the page.
pub const SHORT: [&str; 6] = [
    "setting",
    "time over exact",
    "wrong contacts per 1e6",
    "deepest overlap [diameters]",
    "effective error [sides]",
    "largest difference of a measure",
];

/// Columns of the full table.
pub const FULL: [&str; 16] = [
    "scene",
    "knob",
    "setting",
    "time over exact",
    "least of a round",
    "most of a round",
    "contacts judged",
    "missed per 1e6",
    "late or early per 1e6",
    "invented per 1e6",
    "wrong per 1e6 at most (95 %)",
    "largest |Δt| of the rest [τ]",
    "overlapping pairs",
    "deepest overlap [diameters]",
    "effective error [sides]",
    "remarks",
];

/// Columns of the table of measures.
pub const MEASURES: [&str; 8] = [
    "scene",
    "knob",
    "setting",
    "measure",
    "unit",
    "value",
    "value of the exact run",
    "difference",
];

/// An empty cell.
const NONE: &str = "–";

/// A difference below this many standard errors is not seen.
/// With thirty settings and several measures, one in a hundred pages shows a difference by chance.
pub const SEEN: f64 = 4.0;

/// A time ratio in the short table, with its standard error.
pub fn time(found: &KnobResult) -> String {
    let Some(time) = found.time else {
        return NONE.to_owned();
    };
    match time.standard_error().filter(|&error| error > 0.0) {
        Some(error) => with_error(time.median, Some(error.max(MIN_ERROR * time.median))),
        None => format!("{:.3}", time.median),
    }
}

/// Smallest relative error of a time that is shown: the clock has no more digits.
const MIN_ERROR: f64 = 1e-3;

/// A time ratio in the full table, without its error.
fn median(found: &KnobResult) -> String {
    found
        .time
        .map_or_else(|| NONE.to_owned(), |time| format!("{:.3}", time.median))
}

/// Wrong contacts in a million in the tables.
pub fn wrong(found: &KnobResult) -> String {
    found.wrong().map_or_else(|| NONE.to_owned(), million)
}

/// A number in a million, with two digits below ten.
fn million(bound: Bound) -> String {
    let sign = if bound.is_upper { "< " } else { "" };
    let digits = usize::from(bound.value < 10.0);
    format!("{sign}{:.digits$}", bound.value)
}

/// Depth of the deepest overlap in the tables, of the replays and of the measurement.
pub fn deepest(found: &KnobResult) -> String {
    if found.tally.intervals == 0 {
        return NONE.to_owned();
    }
    significant(found.tally.deepest.max(found.physics.deepest), 2)
}

/// Effective error in the tables.
pub fn effective(found: &KnobResult) -> String {
    found.effective.map_or_else(
        || NONE.to_owned(),
        |effective| {
            format!(
                "{}{:.0e}",
                if effective.at_least { "≥ " } else { "" },
                effective.value
            )
        },
    )
}

/// The cell on the effective error: the number, or why there is none.
fn effective_words(found: &KnobResult, result: &SceneResult) -> String {
    match found.effective {
        Some(_) => effective(found),
        None if result.irreversible.is_some() => "not reversible".to_owned(),
        None if found.knob.is_model() => "another model".to_owned(),
        None => NONE.to_owned(),
    }
}

/// A difference without an error: the run with the setting was too short for one, and runs that
/// differ by rounding alone are soon different.
const UNRESOLVED: &str = "too short";

/// The difference of a measure from the exact run, with its error; in per cent of the exact value
/// where that is not 0 within its error.
pub fn difference(difference: &Difference) -> String {
    match (difference.percent(), difference.standard_error) {
        (_, None) | (None, Some(0.0)) if difference.difference == 0.0 => "0".to_owned(),
        (_, None) => UNRESOLVED.to_owned(),
        (Some([value, error]), Some(_)) => format!("{value:+.2} ± {error:.2} %"),
        (None, Some(error)) => format!("{:+.2e} ± {error:.1e}", difference.difference),
    }
}

/// The measure that differs most from the exact run, in standard errors, if that is seen.
pub fn worst(found: &KnobResult, exact: &KnobResult) -> Option<Difference> {
    let differences = found.physics.differences(&exact.physics);
    let seen = differences
        .into_iter()
        .filter_map(|one| Some((one.in_errors()?, one)));
    let worst = seen.max_by(|a, b| a.0.total_cmp(&b.0));
    worst.filter(|worst| worst.0 > SEEN).map(|worst| worst.1)
}

/// The cell on the measure that differs most.
pub fn worst_words(found: &KnobResult, exact: &KnobResult) -> String {
    if found.is_skipped || found.tally.judged == 0 && !found.notes.is_empty() {
        return found.notes.join("; ");
    }
    if found.knob == exact.knob {
        return NONE.to_owned();
    }
    match worst(found, exact) {
        Some(worst) => format!("{}: {}", worst.name, difference(&worst)),
        None if found
            .physics
            .differences(&exact.physics)
            .iter()
            .any(|one| one.in_errors().is_some()) =>
        {
            "none seen".to_owned()
        }
        None => NONE.to_owned(),
    }
}

/// The rows of the short table.
pub fn short(result: &SceneResult) -> Vec<Vec<String>> {
    let row = |found: &KnobResult| {
        vec![
            found.knob.title(),
            time(found),
            wrong(found),
            deepest(found),
            effective_words(found, result),
            worst_words(found, result.exact()),
        ]
    };
    result.found.iter().map(row).collect()
}

/// The rows of the full table.
pub fn full(result: &SceneResult) -> Vec<Vec<String>> {
    let row = |found: &KnobResult| {
        let tally = &found.tally;
        let mut cells = vec![
            result.name.clone(),
            FAMILIES[found.knob.family].to_owned(),
            found.knob.name.clone(),
            median(found),
        ];
        cells.extend(match found.time {
            Some(time) => [time.least, time.most].map(|ratio| format!("{ratio:.3}")),
            None => [NONE, NONE].map(str::to_owned),
        });
        if tally.judged == 0 {
            cells.extend(vec![NONE.to_owned(); 6]);
        } else {
            cells.push(tally.judged.to_string());
            cells.extend([tally.missed, tally.off, tally.invented].map(|count| {
                million(Bound {
                    value: tally.million(count),
                    is_upper: false,
                })
            }));
            let none = tally.wrong() == 0.0;
            cells.push(if none {
                format!("{:.1}", tally.upper_bound_of_none())
            } else {
                NONE.to_owned()
            });
            cells.push(significant(tally.largest, 2));
        }
        cells.push(if tally.intervals == 0 {
            NONE.to_owned()
        } else {
            tally.overlapping.max(found.physics.overlapping).to_string()
        });
        cells.extend([deepest(found), effective(found), found.notes.join("; ")]);
        cells
    };
    result.found.iter().map(row).collect()
}

/// The rows of the table of measures.
pub fn measures(result: &SceneResult) -> Vec<Vec<String>> {
    let rows = |found: &KnobResult| {
        let head = [
            result.name.clone(),
            FAMILIES[found.knob.family].to_owned(),
            found.knob.name.clone(),
        ];
        let differences = found.physics.differences(&result.exact().physics);
        differences.into_iter().map(move |one| {
            let numbers = [one.value, one.exact].map(|value| format!("{value:.6e}"));
            let words = [one.name.clone(), one.unit.clone()];
            head.clone()
                .into_iter()
                .chain(words)
                .chain(numbers)
                .chain([difference(&one)])
                .collect()
        })
    };
    result.found.iter().flat_map(rows).collect()
}

/// Most measures that the page shows; all are in the file.
const MAX_MEASURES: usize = 12;

/// Header and rows of the differences of all measures, a column each.
pub fn measure_columns(result: &SceneResult) -> (Vec<String>, Vec<Vec<String>>) {
    let exact = &result.exact().physics;
    let shown: Vec<_> = exact.figures.iter().take(MAX_MEASURES).collect();
    let mut header = vec!["setting".to_owned()];
    header.extend(
        shown
            .iter()
            .map(|figure| format!("{} [{}]", figure.name, figure.unit)),
    );
    let curves = exact.deviations(exact);
    header.extend(
        curves
            .iter()
            .map(|curve| format!("{}, at most of {} points", curve.name, curve.points)),
    );
    let row = |found: &KnobResult| {
        let differences = found.physics.differences(exact);
        let mut cells = vec![found.knob.title()];
        cells.extend(shown.iter().map(|figure| {
            if found.knob == result.exact().knob {
                return with_error(figure.value, figure.standard_error);
            }
            let own = differences.iter().find(|one| one.name == figure.name);
            own.map_or_else(|| NONE.to_owned(), difference)
        }));
        let own = found.physics.deviations(exact);
        cells.extend(curves.iter().map(|curve| {
            let own = own.iter().find(|own| own.name == curve.name);
            own.map_or_else(
                || NONE.to_owned(),
                |own| format!("{:.1} errors", own.largest),
            )
        }));
        cells
    };
    (header, result.found.iter().map(row).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_without_an_error_is_no_number() {
        let one = |difference, standard_error| Difference {
            name: "force".to_owned(),
            unit: "1".to_owned(),
            value: 4.0 + difference,
            exact: 4.0,
            difference,
            standard_error,
        };
        let cells = [
            one(-20.0, None),
            one(0.0, None),
            one(0.4, Some(0.2)),
            one(0.4, Some(8.0)),
        ];
        let cells = cells.map(|one| difference(&one));
        assert_eq!(
            cells,
            ["too short", "0", "+10.00 ± 5.00 %", "+4.00e-1 ± 8.0e0"]
        );
    }
}
