//! Charts of time against wrong answers, and against the error of contact times.

use anyhow::Result;
use carom_report::scatter::{Mark, Scatter, ScatterPoint};
use carom_testkit::oracle::OracleVerdict;

use super::{
    overall::{FAMILIES, Overall, overall},
    results::EncounterResults,
};

/// The two charts.
#[derive(Debug)]
pub struct EncounterCharts {
    /// Time against wrong answers.
    pub wrong: String,
    /// Time against the error of times.
    pub error: String,
}

/// Smaller errors are drawn at this value: they are below rounding (natural times).
const MIN_DRAWN: f64 = 1e-17;

impl EncounterCharts {
    /// Draws the charts.
    ///
    /// # Errors
    /// A value is not finite.
    pub fn draw(results: &EncounterResults) -> Result<Self> {
        let overall = overall(results);
        let x_label = "time of a query relative to Exact, geometric mean over the classes";
        let families: Vec<String> = FAMILIES.map(str::to_owned).to_vec();
        let wrong = overall.iter().filter_map(|of| {
            let none = of.wrong == 0.0;
            let y = if none {
                of.tally.upper_bound_of_none()
            } else {
                of.wrong
            };
            point(of, y, if none { Mark::AtMost } else { Mark::Measured })
        });
        let error = overall.iter().filter_map(|of| {
            let median = of.tally.quantile(0.5)?.max(MIN_DRAWN);
            point(
                of,
                median,
                Mark::UpTo(of.tally.quantile(0.999)?.max(median)),
            )
        });
        let chart = |title: &str, y_label: &str, points: Vec<ScatterPoint>| {
            Scatter {
                title: title.to_owned(),
                x_label: x_label.to_owned(),
                y_label: y_label.to_owned(),
                families: families.clone(),
                front: Vec::new(),
                points,
            }
            .svg()
        };
        Ok(Self {
            wrong: chart(
                "Time and wrong answers",
                "share of wrong answers",
                wrong.collect(),
            )?,
            error: chart(
                "Time and error",
                "|t − t*| in natural times: median, up to 99.9 %",
                error.collect(),
            )?,
        })
    }

    /// File names and contents of the charts.
    pub fn files(&self) -> [(&'static str, &str); 2] {
        [
            ("time-and-wrong-answers.svg", &self.wrong),
            ("time-and-error.svg", &self.error),
        ]
    }
}

/// The point of a detector at one setting; `None` if its time is not known.
fn point(of: &Overall, y: f64, mark: Mark) -> Option<ScatterPoint> {
    let undecided =
        of.tally.count(OracleVerdict::FreeUntil) as f64 / of.tally.judged().max(1) as f64;
    let label = if undecided > 0.001 {
        format!("{}, {:.1} % undecided", of.setting, 100.0 * undecided)
    } else {
        of.setting.clone()
    };
    Some(ScatterPoint {
        family: of.family,
        label,
        x: of.ratio?,
        y,
        mark,
    })
}
