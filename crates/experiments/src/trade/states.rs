//! States along the exact run of a scene, from which all settings start.

use std::time::{Duration, Instant};

use anyhow::Result;
use carom::Scene;
use carom_runs::{
    price::{
        Course, CourseState, GROWTH, MAX_REPLAY, Reached, Setting, contacts, growth, mean_time,
    },
    run::measured_from,
};

use super::effective_error::{self, irreversible};

/// Time between two states of a run that continues, in mean times between two collisions of a body.
pub const TIME_BETWEEN_STATES: f64 = 5.0;

/// Time until the start is forgotten, in mean times between two collisions of a body; in a short
/// run, this share of it.
const WARM_UP: f64 = 50.0;
const WARM_UP_SHARE: f64 = 0.5;

/// The first estimate of the collision rate begins with this share of the run, which doubles until
/// each body has met this many others.
const FIRST_SHARE: f64 = 1.0 / (1u64 << 40) as f64;
const FIRST_CONTACTS: f64 = 4.0;

/// The course of a scene up to its first state, and what it costs.
#[derive(Debug)]
pub struct Along<'a> {
    /// The exact run at its present time.
    pub course: Course<'a>,
    /// Mean time between two collisions of a body (time).
    pub tau: f64,
    /// Processor time of a collision (seconds).
    pub seconds: f64,
    /// End of the run of the settings: that of the scene, or infinite where nothing changes after
    /// it.
    pub end: f64,
    /// What could not be reached in the time allowed.
    pub notes: Vec<String>,
}

impl<'a> Along<'a> {
    /// Runs to the start of the measured part of a scene, or until its start is forgotten.
    ///
    /// # Errors
    /// The run fails.
    pub fn settle(scene: &'a Scene, mut course: Course<'a>, deadline: Instant) -> Result<Self> {
        let until = scene.run.until;
        let moving = moving(&course);
        let clock = Instant::now();
        let mut length = FIRST_SHARE * until;
        // At most 40 doublings.
        while length < until {
            let reached = course.run_to(length, &mut (), deadline)?;
            if reached == Reached::Deadline
                || contacts(course.simulation())[0] as f64 >= FIRST_CONTACTS * moving
            {
                break;
            }
            length *= 2.0;
        }
        let mut notes = Vec::new();
        let met = mean_time(course.simulation(), [0, 0], course.time());
        let guess = met.unwrap_or(until);
        let from = measured_from(scene);
        let begin = if from > 0.0 {
            from
        } else {
            (course.time() + WARM_UP * guess).min((WARM_UP_SHARE * until).max(course.time()))
        };
        let (early, before) = (course.time(), contacts(course.simulation()));
        if course.run_to(begin, &mut (), deadline)? == Reached::Deadline {
            let time = course.time();
            notes.push(format!(
                "the time allowed ends the approach to t = {begin:.4} at t = {time:.4}: the states follow from there"
            ));
        }
        let collisions = contacts(course.simulation())[0];
        let tau = mean_time(course.simulation(), before, course.time() - early).unwrap_or(guess);
        if met.is_none() {
            notes.push("no body met another in the time allowed".to_owned());
        }
        let is_unchanged =
            scene.stage.is_empty() && scene.bounds.drag == 0.0 && scene.elasticity.is_elastic();
        Ok(Self {
            course,
            tau,
            seconds: clock.elapsed().as_secs_f64() / collisions.max(1) as f64,
            end: if is_unchanged { f64::MAX } else { until },
            notes,
        })
    }

    /// Takes at most so many states from now on, spread over the run as far as `seconds` of
    /// processor time reach. Every prefix of the list is spread.
    ///
    /// # Errors
    /// The run fails.
    pub fn take(&mut self, scene: &Scene, count: usize, seconds: f64) -> Result<Vec<CourseState>> {
        let begin = self.course.time();
        let last = self.end.min(
            scene
                .run
                .until
                .max(begin + TIME_BETWEEN_STATES * self.tau * count as f64),
        );
        let contacts_per_time = moving(&self.course) / (2.0 * self.tau);
        let affordable = 0.8 * seconds / (self.seconds * contacts_per_time).max(f64::MIN_POSITIVE);
        let left = (last - begin - MAX_REPLAY * self.tau)
            .max(0.0)
            .min(affordable);
        self.take_apart(count, left / count as f64, last, seconds)
            .map(spread)
    }

    /// Takes at most so many states from now on, one soon after another.
    ///
    /// # Errors
    /// The run fails.
    pub fn take_soon(&mut self, count: usize, seconds: f64) -> Result<Vec<CourseState>> {
        self.take_apart(count, 0.0, self.end, seconds)
    }

    /// Takes states at least `apart` from each other (time), before `last`.
    fn take_apart(
        &mut self,
        count: usize,
        apart: f64,
        last: f64,
        seconds: f64,
    ) -> Result<Vec<CourseState>> {
        let deadline = Instant::now() + Duration::from_secs_f64(seconds.max(0.0));
        // Replays do not overlap.
        let apart = apart.max(MAX_REPLAY * self.tau);
        let mut states = Vec::new();
        while states.len() < count && self.course.time() < self.end {
            let mut state = self.course.state(self.tau);
            let (time, before) = (state.time(), contacts(self.course.simulation()));
            let next = time + apart;
            let is_last = states.len() + 1 == count || next > last - MAX_REPLAY * self.tau;
            // The rate after a state may differ from that before.
            let look = if is_last {
                (time + MAX_REPLAY * self.tau).min(self.end)
            } else {
                next
            };
            let reached = self.course.run_to(look, &mut (), deadline)?;
            let tau = mean_time(self.course.simulation(), before, self.course.time() - time);
            state.tau = tau.unwrap_or(self.tau);
            self.tau = state.tau;
            states.push(state);
            if is_last || reached == Reached::Deadline {
                break;
            }
        }
        Ok(states)
    }
}

/// Number of bodies that move.
fn moving(course: &Course<'_>) -> f64 {
    let view = course.simulation().view();
    view.bodies()
        .filter(|body| body.body.is_free())
        .count()
        .max(1) as f64
}

/// Items in an order in which every prefix is spread over the list: by the reversed bits of the
/// index.
fn spread<T>(items: Vec<T>) -> Vec<T> {
    let mut numbered: Vec<(usize, T)> = items.into_iter().enumerate().collect();
    numbered.sort_by_key(|(index, _)| index.reverse_bits());
    numbered.into_iter().map(|(_, item)| item).collect()
}

/// How errors grow in a scene, and how long replays may be.
#[derive(Debug, Clone, PartialEq)]
pub struct Chaos {
    /// E-foldings of rounding errors for each collision of a body.
    pub rate: f64,
    /// Length of a replay, in mean times between two collisions of a body.
    pub stretch: f64,
    /// Why no run can be reversed, if that is so.
    pub irreversible: Option<String>,
}

/// Measures the growth by reversal of the exact run, or estimates it where no run can be reversed.
///
/// # Errors
/// The exact run fails.
pub fn chaos(scene: &Scene, states: &[CourseState], deadline: Instant) -> Result<Chaos> {
    let Some(first) = states.first() else {
        anyhow::bail!("the run has no state to start from")
    };
    let simulation = Setting::default().resume(first.checkpoint())?;
    let view = simulation.view();
    let irreversible = irreversible(scene, &view);
    let estimate = growth(&view, first.tau);
    let rate = if irreversible.is_some() {
        estimate
    } else {
        let found = effective_error::returns(&Setting::default(), states, deadline)?;
        // Where nothing scatters, as between flat walls, errors do not grow.
        if found.has_rate() {
            found.rate().max(0.0)
        } else {
            estimate
        }
    };
    let stretch = if rate > 0.0 {
        MAX_REPLAY.min(GROWTH / rate)
    } else {
        MAX_REPLAY
    };
    Ok(Chaos {
        rate,
        stretch,
        irreversible,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_runs::price::build;

    #[test]
    fn every_prefix_of_a_spread_list_covers_it() {
        assert_eq!(spread((0..8).collect::<Vec<_>>()), [0, 4, 2, 6, 1, 5, 3, 7]);
        assert_eq!(spread(vec![0]), [0]);
    }

    #[test]
    fn states_lie_in_the_measured_part_and_have_the_rate_of_their_time() {
        // The gas is heated a hundredfold in the second stage: ten times the rate.
        let scene = Scene::from_toml(
            "[box]\nseed = 2\n[[gas]]\ntags = [\"gas\"]\nradius = 0.03\nmass = 1.0\nenergy = 1.0\ncount = 60\n\
             [run]\nuntil = 8.0\n[[stage]]\nuntil = 1.0\nmeasure = false\n[[stage]]\nuntil = 4.0\n\
             [[stage]]\nuntil = 8.0\nset_energy = [{ tag = \"gas\", energy = 100.0 }]\n",
        )
        .unwrap();
        let soon = Instant::now() + Duration::from_mins(1);
        let course = Course::new(&scene, build(&scene, soon).unwrap().unwrap()).unwrap();
        let mut along = Along::settle(&scene, course, soon).unwrap();
        assert!((along.course.time() - 1.0).abs() < 1e-9 && along.end == 8.0);
        let mut states = along.take(&scene, 6, 60.0).unwrap();
        states.sort_by(|a, b| a.time().total_cmp(&b.time()));
        assert_eq!(states.len(), 6);
        assert!(states[0].time() == 1.0 && states[5].time() < 8.0);
        let ratio = states[0].tau / states[4].tau;
        assert!((7.0..14.0).contains(&ratio), "{ratio}");
    }
}
