//! The price of the method of a run, measured at its end: intervals are replayed from states that
//! follow its last one, exactly and with the method.

use std::time::Duration;

use anyhow::Result;
use carom::{Scene, engine::TilesName};
use carom_methods::{AnySimulation, Method};
use carom_report::page::Page;
use carom_tables::{Figure, with_error};
use serde::{Deserialize, Serialize};

use super::{
    Course, CourseState, Reached, ReplayTally, Setting, TimeRatio, TimedRun, TimingLimits,
    course::{contacts, mean_time},
    growth, replay, time,
};
use crate::clock::Instant;

pub use crate::file_names::PRICE;

/// Contacts replayed, as a share of those of the run, and at least and at most. The number depends
/// on the run alone, so that the counts are the same each time. More: the price takes more of the
/// time of a run. Fewer: rare errors are not found.
const SHARE: f64 = 0.02;
const CONTACTS: [f64; 2] = [200.0, 20_000.0];

/// Most states from which intervals are replayed.
const MAX_STATES: u32 = 100;

/// Longest replay, in mean times between two collisions of a body.
pub const MAX_REPLAY: f64 = 2.0;

/// A replay ends when chaos has amplified rounding errors by e to this power. More: in a dilute
/// gas, where each collision amplifies them about a hundredfold, two exact runs differ by more than
/// the tolerance. Less: fewer contacts are judged.
pub const GROWTH: f64 = 3.0;

/// Rounds of time measurements.
const ROUNDS: u32 = 5;

/// Processor time of one turn as a share of that of the run, and at least and at most (seconds).
const TURN_SHARE: f64 = 2e-3;
const TURN: [f64; 2] = [1e-3, 5e-2];

/// Limit of the time measurements (seconds).
const MAX_SECONDS: f64 = 3.0;

/// What a method saves and gets wrong.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Price {
    /// The method in words.
    pub method: String,
    /// Processor time of a collision over that of the exact run; `None` if a run fails.
    pub time: Option<TimeRatio>,
    /// Counts of wrong contacts.
    pub tally: ReplayTally,
    /// Replays with the method that failed.
    pub failed: u64,
}

/// Measures the price of the method of a run at its end, which took `seconds` of processor time;
/// `None` for the default method, and without a contact. No bit of the run changes.
///
/// # Errors
/// The exact run fails from the last state of the run.
pub fn of_run(
    simulation: &AnySimulation,
    method: &Method,
    scene: &Scene,
    seconds: f64,
) -> Result<Option<Price>> {
    // Tiles change no bit, and their speed is that of all threads.
    let in_order = Method {
        tiles: TilesName::default(),
        ..*method
    };
    if in_order == Method::default() {
        return Ok(None);
    }
    let Some(tau) = mean_time(simulation, [0, 0], simulation.time().to_f64()) else {
        return Ok(None);
    };
    let (stretch, states) = replays(simulation, tau);
    let checkpoint = simulation.clone().end_epoch_here();
    let first = CourseState::undisturbed(checkpoint, tau);
    let mut price = Price {
        method: method.to_string(),
        time: None,
        tally: ReplayTally::default(),
        failed: 0,
    };
    let setting = Setting::from(*method);
    // The counts must not depend on the speed of the machine.
    let never = Instant::now() + Duration::from_secs(1 << 30);
    let exact = Setting::default();
    let mut course = Course::resume(scene, &exact, &first)?;
    for index in 0..states {
        let state = course.state(tau);
        let duration = stretch * tau;
        let Some(reference) = replay::interval(scene, &exact, &state, duration, never)? else {
            break;
        };
        match replay::interval(scene, &setting, &state, duration, never) {
            Ok(Some(log)) => replay::add(&reference, &log, duration, tau, &mut price.tally),
            Ok(None) => {}
            Err(_) => price.failed += 1,
        }
        let next = state.time() + duration;
        if index + 1 < states && course.run_to(next, &mut (), never)? == Reached::Deadline {
            break;
        }
    }
    let limits = TimingLimits {
        rounds: ROUNDS,
        turn: (TURN_SHARE * seconds).clamp(TURN[0], TURN[1]),
        deadline: Instant::now() + Duration::from_secs_f64(MAX_SECONDS),
    };
    let timed = TimedRun::new(scene, exact, &first, f64::MAX, &limits)
        .and_then(|mut exact| time(&mut exact, setting, &limits));
    price.time = timed.unwrap_or(None);
    Ok(Some(price))
}

/// The length of each replay in mean times `tau` between two collisions of a body, and the number
/// of states to replay from.
fn replays(simulation: &AnySimulation, tau: f64) -> (f64, u32) {
    let (collisions, age) = (contacts(simulation)[0], simulation.time().to_f64());
    let moving = simulation
        .view()
        .bodies()
        .filter(|body| body.body.is_free())
        .count() as f64;
    let requested = (SHARE * collisions as f64).clamp(CONTACTS[0], CONTACTS[1]);
    let of_tau = collisions as f64 * tau / age;
    let longest = MAX_REPLAY.min(GROWTH / growth(&simulation.view(), tau));
    let stretch = longest.min(requested / of_tau);
    let states = ((requested / (stretch * of_tau)).ceil() as u32).clamp(1, MAX_STATES);
    let states = states.min((requested / moving.max(1.0)).ceil() as u32 + 1);
    (stretch, states)
}

impl Price {
    /// Figures of the summary.
    pub fn figures(&self) -> Vec<Figure> {
        let ReplayTally {
            judged,
            missed,
            off,
            invented,
            deepest,
            ..
        } = self.tally;
        let million = |count| self.tally.million(count);
        let time = self.time.map(|time| {
            Figure::new(
                "price of the method: processor time over that of the exact run",
                time.median,
                "1",
            )
        });
        let counts = [
            ("contacts judged", judged as f64),
            ("contacts missed in a million", million(missed)),
            ("contacts late or early in a million", million(off)),
            ("contacts invented in a million", million(invented)),
            ("deepest overlap, in diameters", deepest),
        ];
        let counts = counts
            .map(|(name, value)| Figure::new(format!("price of the method: {name}"), value, "1"));
        time.into_iter().chain(counts).collect()
    }

    /// The sentence and the row of the page.
    pub fn show(&self, page: &mut Page) {
        page.heading("Price of the method");
        page.paragraph(&self.sentence());
        let header = [
            "method",
            "time over exact",
            "contacts judged",
            "missed per 1e6",
            "late or early per 1e6",
            "invented per 1e6",
            "deepest overlap [diameters]",
        ];
        let ReplayTally {
            judged,
            missed,
            off,
            invented,
            deepest,
            ..
        } = self.tally;
        let million = |count| with_error(self.tally.million(count).round(), None);
        let time = self
            .time
            .map_or_else(|| "–".to_owned(), |time| format!("{:.3}", time.median));
        page.table(
            &header,
            &[vec![
                self.method.clone(),
                time,
                judged.to_string(),
                million(missed),
                million(off),
                million(invented),
                with_error(deepest, None),
            ]],
        );
        page.paragraph(
            "Measured at the end of this run, without a change of it: short intervals were run twice from the \
             same states, exactly and with the method, and compared contact by contact. `carom trade` compares \
             all methods on this scene.",
        );
    }

    /// What the method saves and gets wrong, in one sentence.
    pub fn sentence(&self) -> String {
        let time = self.time.map_or_else(
            || "its time could not be compared".to_owned(),
            |time| {
                format!(
                    "it takes {:.2} times the processor time of the exact run",
                    time.median
                )
            },
        );
        let failed = match self.failed {
            0 => String::new(),
            failed => format!("; {failed} replays failed"),
        };
        format!(
            "Against the exact run from the same states, {time}; {}{failed}.",
            self.tally.words()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GAS: &str =
        "[box]\nseed = 4\n[[gas]]\nradius = 0.03\nmass = 1.0\nenergy = 1.0\ncount = 100\n";

    fn price(method: &str) -> Option<Price> {
        let scene = Scene::from_toml(&format!("{GAS}[method]\n{method}")).unwrap();
        let mut simulation = AnySimulation::new(&scene).unwrap();
        simulation.run_until(2.0).unwrap();
        let method = Method::try_from(&scene.method).unwrap();
        let before = simulation.clone();
        let price = of_run(&simulation, &method, &scene, 0.1).unwrap();
        // The run itself does not change.
        let [mut one, mut two] = [before, simulation];
        for run in [&mut one, &mut two] {
            run.run_until(2.5).unwrap();
        }
        let places = |run: &AnySimulation| {
            run.view()
                .bodies()
                .map(|body| body.motion.position)
                .collect::<Vec<_>>()
        };
        assert_eq!(places(&one), places(&two));
        price
    }

    #[test]
    fn the_default_method_has_no_price_and_other_exact_ones_get_nothing_wrong() {
        assert_eq!(price(""), None);
        for method in ["scheduler = \"heap\"", "instructions = \"portable\""] {
            let found = price(method).unwrap();
            assert!(found.tally.judged > 100, "{found:?}");
            assert_eq!(found.tally.wrong(), 0.0, "{found:?}");
            assert!(
                found.time.is_some() && found.sentence().contains("none of"),
                "{}",
                found.sentence()
            );
        }
    }

    #[test]
    fn a_grid_that_is_too_fine_misses_contacts() {
        let found = price("scheduler = \"heap\"\nunchecked_cells_per_side = 40").unwrap();
        assert!(found.tally.missed > 0, "{found:?}");
        assert!(
            found
                .figures()
                .iter()
                .any(|figure| figure.name.ends_with("missed in a million"))
        );
        let mut page = Page::new("", "");
        found.show(&mut page);
        assert!(page.html().contains("missed per 1e6"));
        assert_eq!(
            price("scheduler = \"heap\"\nunchecked_cells_per_side = 40")
                .unwrap()
                .tally,
            found.tally
        );
    }
}
