//! Amount of work, and its division over the time allowed.

use carom_runs::price::TimingLimits;
use std::time::{Duration, Instant};

/// Shares of the time that is left after the start: states, times, replays, reversals, and
/// measures. The rest is for the files.
const STATES: f64 = 0.12;
const TIMES: f64 = 0.25;
const REPLAYS: f64 = 0.25;
const REVERSALS: f64 = 0.1;
const PHYSICS: f64 = 0.2;

/// Most states, and most bodies in all of them: more would fill the memory.
const MAX_STATES: f64 = 2000.0;
const MAX_BODIES: f64 = 4e6;

/// Longest measurement, in mean times between two collisions of a body.
const MAX_PHYSICS: f64 = 1e5;

/// A replay takes at most this share of the time for replays of a setting, but is at least so long
/// (mean times between two collisions of a body).
const REPLAY: f64 = 0.3;
const MIN_REPLAY: f64 = 0.01;

/// A turn of the timing is at least and at most this long (seconds).
const TURN: [f64; 2] = [2e-4, 0.2];

/// Amount of work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TradePlan {
    /// Rounds of time measurements; the median is reported.
    pub rounds: u32,
    /// Processor time of one turn in a round (seconds).
    pub turn: f64,
    /// Time after which the timing of a setting ends early (seconds).
    pub timing_seconds: f64,
    /// States of the exact run from which contacts are replayed.
    pub states: usize,
    /// Length of a replay, in mean times between two collisions of a body.
    pub stretch: f64,
    /// Time for the states (seconds).
    pub state_seconds: f64,
    /// Time after which the replays of a setting end early (seconds).
    pub replay_seconds: f64,
    /// Time after which the reversals of a setting end early (seconds).
    pub reversal_seconds: f64,
    /// Time after which the measures of a setting end early (seconds).
    pub physics_seconds: f64,
    /// Length of the measures, in mean times between two collisions of a body.
    pub physics: f64,
}

/// What a scene costs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnobCost {
    /// Time of the exact run for each mean time between two collisions of a body (seconds).
    pub tau: f64,
    /// Time to resume from a state and to predict all bodies (seconds).
    pub resume: f64,
    /// Number of bodies.
    pub bodies: usize,
    /// Number of settings.
    pub settings: usize,
    /// Length of a replay, in mean times between two collisions of a body.
    pub stretch: f64,
    /// Number of threads.
    pub threads: usize,
}

impl TradePlan {
    /// The work that fits into a time (seconds), estimated from the costs of the exact run.
    pub fn within(seconds: f64, cost: &KnobCost) -> Self {
        let settings = cost.settings as f64;
        let each = |share: f64| share * seconds / settings;
        let parallel = |share: f64| each(share) * cost.threads as f64;
        let timing_seconds = each(TIMES);
        let rounds = if timing_seconds > 0.5 {
            9
        } else if timing_seconds > 0.05 {
            5
        } else {
            3
        };
        // Two runs, and the turns that give their length.
        let turns = 2.0 * f64::from(rounds) + 6.0;
        let turn = ((timing_seconds - 2.0 * cost.resume) / turns).clamp(TURN[0], TURN[1]);
        let replay_seconds = parallel(REPLAYS);
        // In a large system a replay of the exact run takes at most a part of the time.
        let longest = (REPLAY * replay_seconds - cost.resume) / cost.tau;
        let stretch = cost.stretch.min(longest.max(MIN_REPLAY));
        let affordable = replay_seconds / (cost.resume + 1.5 * stretch * cost.tau);
        let most = MAX_STATES.min((MAX_BODIES / cost.bodies as f64).max(2.0));
        let physics_seconds = parallel(PHYSICS);
        Self {
            rounds,
            turn,
            timing_seconds,
            states: affordable.clamp(1.0, most) as usize,
            stretch,
            state_seconds: STATES * seconds,
            replay_seconds,
            reversal_seconds: parallel(REVERSALS),
            physics_seconds,
            physics: (0.8 * physics_seconds / cost.tau).min(MAX_PHYSICS),
        }
    }

    /// The limits of the timing of a setting that begins now.
    pub fn timing(&self) -> TimingLimits {
        TimingLimits {
            rounds: self.rounds,
            turn: self.turn,
            deadline: from_now(1.3 * self.timing_seconds),
        }
    }
}

/// The instant so many seconds from now.
pub fn from_now(seconds: f64) -> Instant {
    Instant::now() + Duration::from_secs_f64(seconds.clamp(0.0, 1e9))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plan_fits_into_the_time_for_small_and_large_scenes() {
        for (tau, resume, bodies) in [
            (1e-7, 1e-6, 1),
            (3e-4, 1e-3, 1000),
            (0.1, 0.2, 100_000),
            (2.0, 3.0, 1_000_000),
        ] {
            let cost = KnobCost {
                tau,
                resume,
                bodies,
                settings: 25,
                stretch: 2.0,
                threads: 2,
            };
            let plan = TradePlan::within(100.0, &cost);
            let settings = 25.0;
            let timing = settings * 2.0 * (f64::from(plan.rounds) * plan.turn + resume);
            let replays = settings * plan.states as f64 * (resume + 2.0 * tau) / 2.0;
            assert!(replays < 40.0 || plan.states == 1, "{bodies}: {replays}");
            assert!(timing < 40.0 || resume > 0.5, "{bodies}: {timing}");
            assert!(plan.states * bodies <= 8_000_000 && plan.physics <= MAX_PHYSICS);
        }
    }
}
