//! The state of a run as lines of a table on the terminal while it continues: time, temperature,
//! energy, collisions, and the pressure where it is measured.

use std::time::Duration;

use carom::View;
use carom_tables::significant;

use crate::clock::Instant;
use crate::{measures::Measures, terminal::note};

/// Most lines in a run. More: they scroll out of sight.
const MAX_LINES: f64 = 20.0;

/// No line before this time: short runs end with the table of their figures.
const DELAY: Duration = Duration::from_secs(2);

/// Width of a column (characters).
const WIDTH: usize = 11;

/// The table of one run.
pub(super) struct StateTable {
    begun: Instant,
    /// Simulated time between two lines.
    interval: f64,
    next: f64,
    has_head: bool,
}

impl StateTable {
    /// The table of a run that continues from `now` to `until` (time).
    pub fn new(now: f64, until: f64) -> Self {
        let interval = until / MAX_LINES;
        Self {
            begun: Instant::now(),
            interval,
            next: now + interval,
            has_head: false,
        }
    }

    /// Writes a line, if it is time for one.
    pub fn sample(&mut self, view: &View<'_>, measures: &Measures) {
        let time = view.time().to_f64();
        if time < self.next || self.begun.elapsed() < DELAY {
            return;
        }
        self.next = time + self.interval;
        let row = row(view, measures);
        if !self.has_head {
            self.has_head = true;
            note(&line(row.iter().map(|(name, _)| (*name).to_owned())));
        }
        note(&line(row.into_iter().map(|(_, value)| {
            value.map_or_else(|| "-".to_owned(), |value| significant(value, 4))
        })));
    }
}

fn line(cells: impl Iterator<Item = String>) -> String {
    cells
        .map(|cell| format!("{cell:>WIDTH$}"))
        .collect::<Vec<_>>()
        .concat()
}

/// Names and values of the columns.
fn row(view: &View<'_>, measures: &Measures) -> Vec<(&'static str, Option<f64>)> {
    let moving = view.bodies().filter(|body| body.body.is_free()).count();
    let per_body =
        (moving > 0).then(|| view.counters().collisions_of_moving() as f64 / moving as f64);
    let mut row = vec![
        ("t", Some(view.time().to_f64())),
        ("kT", view.temperature()),
    ];
    row.extend(measures.present());
    row.extend([("E", Some(view.energy())), ("coll./body", per_body)]);
    row
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::{Observer as _, Scene};
    use carom_methods::AnySimulation;

    #[test]
    fn a_line_has_the_pressure_where_it_is_measured() {
        for (observe, expected) in [
            ("", vec!["t", "kT", "E", "coll./body"]),
            ("\"pressure\"", vec!["t", "kT", "p", "Z", "E", "coll./body"]),
        ] {
            let text = format!(
                "[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 50\n[run]\nobserve = [{observe}]\n"
            );
            let scene = Scene::from_toml(&text).unwrap();
            let mut simulation = AnySimulation::new(&scene).unwrap();
            let mut measures = Measures::new(&scene, &simulation.view()).unwrap();
            measures.sample(&simulation.view());
            simulation.observe_until(1.0, &mut measures).unwrap();
            measures.sample(&simulation.view());
            let row = row(&simulation.view(), &measures);
            assert_eq!(
                row.iter().map(|(name, _)| *name).collect::<Vec<_>>(),
                expected
            );
            assert!(
                row.iter()
                    .all(|(_, value)| value.is_some_and(|value| value > 0.0)),
                "{row:?}"
            );
            let (time, energy) = (row[0].1.unwrap(), row[row.len() - 2].1.unwrap());
            assert!((time - 1.0).abs() < 1e-12 && (energy - 50.0).abs() < 1e-9);
        }
    }
}
