//! How far the run goes before the engine looks at commands and sends frames again.

use std::time::Duration;

use carom::View;
use carom_runs::{clock::Instant, schedule::pieces::first_length};

/// Time between two frames.
pub const FRAME: Duration = Duration::from_micros(16_600);

/// Largest share of the time of a run at full speed that the frames of all pages together may take,
/// with the ends of the pieces of the run. More: a slower run. Less: fewer frames of large systems.
/// In WebAssembly a frame takes three times as long, and a page alone is there to be watched.
const SHARE_OF_FRAMES: f64 = if cfg!(target_arch = "wasm32") {
    0.15
} else {
    0.045
};

/// That share if several pages watch, whose frames leave less of the caches to the engine.
const SHARE_OF_SEVERAL: f64 = 0.03;

/// Duration of the end of a piece for each body (seconds): all motions are stored, and the caches
/// are refilled. That is 40 ns at 10⁵ discs (`goals`); the whole of it would leave fewer than the
/// 20 frames a second that they should have.
const END_OF_PIECE: f64 = 15e-9;

/// The shortest piece, as a share of the interval of frames: also how much earlier than due a frame
/// may be. Otherwise a piece that ends just before the time of its frame would delay it by a piece.
const MIN_PIECE: f64 = 0.1;

/// A run that is behind its clock by more than this continues from where it is.
const PATIENCE: Duration = Duration::from_millis(100);

/// Lengths of the pieces of a run.
#[derive(Debug, Clone)]
pub struct Pace {
    /// Simulated time for each second; `None` for as fast as it runs.
    speed: Option<f64>,
    /// Simulated time and clock at which the speed was set.
    since: (f64, Instant),
    /// Simulated time for each second of the clock while the engine runs, averaged.
    rate: f64,
    /// Duration of a round of frames, of all pages together, averaged.
    cost: Duration,
    /// Duration of the end of a piece.
    end: Duration,
    /// Largest share of the time that frames may take.
    share: f64,
}

impl Pace {
    /// A pace for a run at its present state.
    pub fn new(view: &View<'_>, speed: Option<f64>) -> Self {
        let rate = first_length(view) / FRAME.as_secs_f64();
        let since = (view.time().to_f64(), Instant::now());
        let end = Duration::from_secs_f64(END_OF_PIECE * view.len() as f64);
        Self {
            speed,
            since,
            rate,
            cost: Duration::ZERO,
            end,
            share: SHARE_OF_FRAMES,
        }
    }

    /// Begins again at the present state of a run, with the speed and the cost of frames so far.
    pub fn restart(&mut self, view: &View<'_>) {
        *self = Self {
            cost: self.cost,
            share: self.share,
            ..Self::new(view, self.speed)
        };
    }

    /// Sets the speed from now on.
    pub fn set_speed(&mut self, speed: Option<f64>, now: f64) {
        self.speed = speed;
        self.start(now);
    }

    /// The speed that was set.
    pub fn speed(&self) -> Option<f64> {
        self.speed
    }

    /// Starts the clock at this simulated time.
    pub fn start(&mut self, now: f64) {
        self.since = (now, Instant::now());
    }

    /// Time before which a frame is due (of the clock) from which on it may be sent.
    pub fn tolerance(&self) -> Duration {
        self.interval().mul_f64(MIN_PIECE)
    }

    /// The end of the next piece (time), for a frame that is due `left` from now; not after `now`
    /// if the run is ahead of its clock.
    pub fn target(&mut self, now: f64, left: Duration) -> f64 {
        let piece = self.rate * left.clamp(self.tolerance(), self.interval()).as_secs_f64();
        let end = (now + piece).max(now.next_up());
        let Some(speed) = self.speed else { return end };
        let due = self.since.0 + speed * self.since.1.elapsed().as_secs_f64();
        if due - end > speed * PATIENCE.as_secs_f64() {
            self.start(now);
        }
        due.min(end)
    }

    /// Learns from a piece of this simulated length and duration.
    pub fn has_taken(&mut self, length: f64, wall: Duration) {
        // Of a shorter piece most time is that of beginning and end.
        let is_whole = length >= self.rate * self.tolerance().as_secs_f64();
        if is_whole || wall > self.interval() {
            let factor = length / (self.rate * wall.as_secs_f64().max(1e-9));
            self.rate = (self.rate * factor.clamp(0.5, 2.0)).clamp(f64::MIN_POSITIVE, 1e60);
        }
    }

    /// Updates the average cost of a round of frames, summed over `pages` pages.
    pub fn has_sent(&mut self, cost: Duration, pages: usize) {
        self.share = if pages > 1 {
            SHARE_OF_SEVERAL
        } else {
            SHARE_OF_FRAMES
        };
        self.cost = (self.cost * 3 + cost) / 4;
    }

    /// Time between two frames: longer if they would take too large a share of the time.
    pub fn interval(&self) -> Duration {
        match self.speed {
            // The run waits for its clock in any case.
            Some(_) => FRAME.max(self.cost * 2),
            None => FRAME.max((self.cost + self.end).div_f64(self.share)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::{Scene, Simulation};

    #[test]
    fn pieces_end_with_the_time_of_a_frame_and_frames_keep_to_their_share() {
        let scene =
            Scene::from_toml("[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 10")
                .unwrap();
        let simulation = Simulation::new(&scene).unwrap();
        let mut pace = Pace::new(&simulation.view(), None);
        // A machine that simulates 5 units of time a second.
        for _ in 0..40 {
            let length = pace.target(0.0, FRAME);
            pace.has_taken(length, Duration::from_secs_f64(length / 5.0));
        }
        let ends_after = |pace: &mut Pace, left: Duration| pace.target(0.0, left) / 5.0;
        assert!((ends_after(&mut pace, FRAME) / FRAME.as_secs_f64() - 1.0).abs() < 1e-6);
        assert!((ends_after(&mut pace, FRAME / 4) / FRAME.as_secs_f64() - 0.25).abs() < 1e-6);
        assert!(
            ends_after(&mut pace, Duration::ZERO) > 0.0,
            "the run continues"
        );
        (0..40).for_each(|_| pace.has_sent(Duration::from_millis(4), 1));
        let share = 0.004 / pace.interval().as_secs_f64();
        assert!((share / SHARE_OF_FRAMES - 1.0).abs() < 0.01, "{share}");
        pace.set_speed(Some(1e-9), 3.0);
        assert!(pace.target(3.0, FRAME) < 3.0 + 1e-6, "slow motion");
        assert_eq!(pace.interval(), FRAME);
    }
}
