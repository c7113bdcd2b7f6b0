//! Processor time of a setting relative to the exact run: both run in turn from one state, and the
//! ratio of each round enters a median.

use std::{f64::consts::FRAC_PI_2, time::Duration};

use anyhow::Result;
use carom::Scene;
use serde::{Deserialize, Serialize};

use super::{Course, CourseState, Reached, Setting, course::contacts};
use crate::clock::{Instant, ThreadTime};

/// A turn is at most this many mean times between two collisions of a body.
const MAX_TURN: f64 = 1e4;

/// The first turn of a timed run is this share of a mean time between two collisions of a body.
/// Shorter: more turns until the length suits. Longer: large systems pass the limit of time.
const FIRST_TURN: f64 = 1.0 / 64.0;

/// Share of the time allowed in which the length of turns is sought.
const SOUGHT: f64 = 0.25;

/// A turn that the deadline cuts counts with this many contacts. Fewer: single contacts decide.
const ENOUGH: u64 = 200;

/// The exact run has this time for a turn (seconds), even where a slow setting has used up its own.
const EXACT_TURN: Duration = Duration::from_secs(5);

/// Mean range of 2, 3, …, 9 numbers from a normal distribution, over its standard deviation.
const MEAN_RANGES: [f64; 8] = [1.128, 1.693, 2.059, 2.326, 2.534, 2.704, 2.847, 2.970];

/// Processor time of a collision over that of the exact run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TimeRatio {
    /// Median over the rounds.
    pub median: f64,
    /// Smallest ratio of a round.
    pub least: f64,
    /// Largest ratio of a round.
    pub most: f64,
    /// Number of rounds.
    pub rounds: u32,
}

impl TimeRatio {
    /// From the ratios of the rounds; `None` without a round.
    pub fn new(mut ratios: Vec<f64>) -> Option<Self> {
        ratios.retain(|ratio| ratio.is_finite() && *ratio > 0.0);
        ratios.sort_by(f64::total_cmp);
        let median = *ratios.get(ratios.len() / 2)?;
        Some(Self {
            median,
            least: ratios[0],
            most: ratios[ratios.len() - 1],
            rounds: ratios.len() as u32,
        })
    }

    /// Standard error of the median, from the range of the rounds; `None` of a single round. The
    /// range covers outliers: on a busy machine the error is rather too large.
    pub fn standard_error(&self) -> Option<f64> {
        let index = (self.rounds as usize).checked_sub(2)?;
        let deviation = (self.most - self.least) / MEAN_RANGES[index.min(MEAN_RANGES.len() - 1)];
        // The variance of the median of normal numbers is π/2 times that of their mean.
        Some(deviation * (FRAC_PI_2 / f64::from(self.rounds)).sqrt())
    }
}

/// Limits of the timing of one setting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimingLimits {
    /// Number of rounds.
    pub rounds: u32,
    /// Processor time of a turn in a round (seconds).
    pub turn: f64,
    /// End of the timing.
    pub deadline: Instant,
}

/// A run that is timed, in turns.
#[derive(Debug)]
pub struct TimedRun<'a> {
    scene: &'a Scene,
    setting: Setting,
    state: &'a CourseState,
    course: Course<'a>,
    /// Simulated time of a turn.
    length: f64,
    /// Turns end here and begin again at the state.
    end: f64,
    /// Time of a turn on the clock, which other programs lengthen.
    wall: Duration,
}

/// One turn.
#[derive(Debug, Clone, Copy)]
pub struct Turn {
    /// Processor time (seconds).
    pub seconds: f64,
    /// Contacts.
    pub collisions: u64,
    /// Simulated time.
    pub simulated: f64,
    /// False if the deadline has cut it.
    pub is_whole: bool,
}

impl Turn {
    /// Whether its time can be compared: it is whole, or long enough without its end.
    fn counts(&self) -> bool {
        self.is_whole || self.collisions >= ENOUGH
    }

    /// Processor time of this turn over that of another one, for each contact; for each simulated
    /// time where one of them has no contact.
    pub fn over(&self, other: &Self) -> f64 {
        let work = if self.collisions.min(other.collisions) == 0 {
            self.simulated / other.simulated
        } else {
            self.collisions as f64 / other.collisions as f64
        };
        self.seconds / other.seconds.max(1e-9) / work
    }
}

impl<'a> TimedRun<'a> {
    /// A run with a setting from a state on, not longer than to the time `end`. Its first turns are
    /// not timed; they give the length of a turn.
    ///
    /// # Errors
    /// The bodies do not suit the setting, or the run fails.
    pub fn new(
        scene: &'a Scene,
        setting: Setting,
        state: &'a CourseState,
        end: f64,
        limits: &TimingLimits,
    ) -> Result<Self> {
        let course = Course::resume(scene, &setting, state)?;
        let length = (FIRST_TURN * state.tau).min(end - state.time());
        let mut run = Self {
            scene,
            setting,
            state,
            course,
            length,
            end,
            wall: Duration::ZERO,
        };
        let left = || limits.deadline.saturating_duration_since(Instant::now());
        let sought = left().mul_f64(1.0 - SOUGHT);
        // The first turn predicts all bodies.
        run.turn(limits.deadline)?;
        let longest = (MAX_TURN * state.tau).min(end - state.time());
        for _ in 0..32 {
            let clock = Instant::now();
            let seconds = run.turn(limits.deadline)?.seconds;
            run.wall = clock.elapsed();
            if seconds >= 0.5 * limits.turn || run.length >= longest || left() <= sought {
                break;
            }
            let factor = (limits.turn / seconds.max(1e-9)).clamp(1.5, 8.0);
            run.length = (factor * run.length).min(longest);
        }
        let share = share_that_fits(run.wall, left(), limits.rounds);
        run.length *= share;
        run.wall = run.wall.mul_f64(share);
        Ok(run)
    }

    /// Simulated time of a turn, in mean times between two collisions of a body.
    pub fn length(&self) -> f64 {
        self.length / self.state.tau
    }

    /// Runs one turn, which the deadline may cut.
    ///
    /// # Errors
    /// The run fails.
    pub fn turn(&mut self, deadline: Instant) -> Result<Turn> {
        // A last piece that rounding would leave.
        if self.course.time() + self.length > self.end * (1.0 + 4.0 * f64::EPSILON) {
            self.course = Course::resume(self.scene, &self.setting, self.state)?;
        }
        let (begin, before) = (self.course.time(), contacts(self.course.simulation())[0]);
        let interval = self
            .setting
            .sample_interval
            .map_or(self.length, |share| share * self.state.tau);
        let pieces = (self.length / interval).round().max(1.0) as u64;
        let clock = ThreadTime::now();
        let mut is_whole = true;
        for piece in 1..=pieces {
            let share = piece as f64 / pieces as f64;
            if self
                .course
                .run_to(begin + share * self.length, &mut (), deadline)?
                == Reached::Deadline
            {
                is_whole = false;
                break;
            }
        }
        Ok(Turn {
            seconds: clock.elapsed().as_secs_f64(),
            collisions: contacts(self.course.simulation())[0] - before,
            simulated: self.course.time() - begin,
            is_whole,
        })
    }
}

/// The share of a turn of which two in each round fit into the time that is left on the clock: on a
/// busy machine processor time is a small part of it.
fn share_that_fits(wall: Duration, left: Duration, rounds: u32) -> f64 {
    let needed = 2.0 * f64::from(rounds) * wall.as_secs_f64();
    if needed > 0.0 {
        (left.as_secs_f64() / needed).clamp(FIRST_TURN, 1.0)
    } else {
        1.0
    }
}

/// Times a setting against the exact run, whose turns `exact` gives.
///
/// # Errors
/// The run fails.
pub fn time(
    exact: &mut TimedRun<'_>,
    setting: Setting,
    limits: &TimingLimits,
) -> Result<Option<TimeRatio>> {
    let mut other = TimedRun::new(exact.scene, setting, exact.state, exact.end, limits)?;
    let mut ratios = Vec::new();
    for round in 0..limits.rounds {
        // The order alternates, so that a drift of the processor's speed cancels.
        let base = if round % 2 == 0 {
            Some(exact.turn(Instant::now() + EXACT_TURN)?)
        } else {
            None
        };
        // The first round ends even if the search for its length has used up the time.
        let grace = if round == 0 {
            Instant::now() + 2 * other.wall
        } else {
            limits.deadline
        };
        let own = match other.turn(limits.deadline.max(grace)) {
            Ok(own) => own,
            // The rounds before a failure count.
            Err(error) if ratios.is_empty() => return Err(error),
            Err(_) => break,
        };
        let base = base.map_or_else(|| exact.turn(Instant::now() + EXACT_TURN), Ok)?;
        if own.counts() && base.counts() {
            ratios.push(own.over(&base));
        }
        if Instant::now() >= limits.deadline {
            break;
        }
    }
    Ok(TimeRatio::new(ratios))
}

#[cfg(test)]
mod tests {
    use rand::{RngExt as _, SeedableRng as _};

    use super::*;

    #[test]
    fn the_median_of_the_rounds_is_found_and_a_failed_round_is_left_out() {
        let ratio = TimeRatio::new(vec![3.0, 1.0, f64::NAN, 2.0]).unwrap();
        assert_eq!(
            (ratio.median, ratio.least, ratio.most, ratio.rounds),
            (2.0, 1.0, 3.0, 3)
        );
        assert_eq!(TimeRatio::new(vec![f64::INFINITY]), None);
    }

    #[test]
    fn the_error_of_the_median_is_its_scatter() {
        let mut random = rand_pcg::Pcg64::seed_from_u64(1);
        for rounds in [3, 5, 9] {
            let sets: Vec<TimeRatio> = (0..4000)
                .map(|_| {
                    // Nearly normal: a sum of twelve uniform numbers.
                    let mut normal = || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
                    TimeRatio::new((0..rounds).map(|_| 1.0 + 0.05 * normal()).collect()).unwrap()
                })
                .collect();
            let mean = |of: &dyn Fn(&TimeRatio) -> f64| {
                sets.iter().map(of).sum::<f64>() / sets.len() as f64
            };
            let scatter = mean(&|set| (set.median - 1.0).powi(2)).sqrt();
            let error = mean(&|set| set.standard_error().unwrap());
            assert!(
                (error / scatter - 1.0).abs() < 0.12,
                "{rounds} rounds: {error} for {scatter}"
            );
        }
        assert_eq!(TimeRatio::new(vec![1.0]).unwrap().standard_error(), None);
    }

    #[test]
    fn turns_become_shorter_only_where_the_rounds_do_not_fit_into_the_time() {
        let share = |wall, left, rounds| {
            share_that_fits(
                Duration::from_secs_f64(wall),
                Duration::from_secs_f64(left),
                rounds,
            )
        };
        assert_eq!([share(0.07, 1.8, 9), share(0.0, 0.0, 9)], [1.0, 1.0]);
        assert!((share(0.7, 1.8, 9) - 1.0 / 7.0).abs() < 1e-12);
        assert_eq!(share(0.7, 0.0, 9), FIRST_TURN);
    }

    #[test]
    fn turns_are_compared_by_contact_or_else_by_time() {
        let turn = |seconds, collisions, simulated| Turn {
            seconds,
            collisions,
            simulated,
            is_whole: true,
        };
        assert_eq!(turn(2.0, 10, 1.0).over(&turn(1.0, 20, 9.0)), 4.0);
        assert_eq!(turn(2.0, 0, 1.0).over(&turn(1.0, 20, 2.0)), 4.0);
    }
}
