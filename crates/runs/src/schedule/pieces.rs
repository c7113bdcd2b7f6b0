//! Pieces of a run, short enough to look at the clock between them.
//!
//! A run in pieces makes the same contacts as in one, to the bit; the end of a piece costs the time
//! to store all motions.

use std::time::Duration;

use carom::{EpochTime, View, geometry::MAX_MAGNITUDE};

/// The first piece lasts this share of the time in which the fastest body crosses the box. Larger:
/// the first piece of a slow detector takes long. Smaller: more pieces until their length is right.
const FIRST_SHARE: f64 = 1e-4;

/// No piece is shorter than this share of the first, which bounds their number.
const MIN_SHARE: f64 = 1e-6;

/// The length of the next piece, by the durations of those before it.
#[derive(Debug, Clone, Copy)]
pub struct Pieces {
    length: f64,
    shortest: f64,
    wall: Duration,
}

impl Pieces {
    /// Pieces that shall take about `wall` by the clock, of a run in this state.
    pub fn new(view: &View<'_>, wall: Duration) -> Self {
        Self::with_first(first_length(view), wall)
    }

    /// Pieces that shall take about `wall` by the clock, and the length of the first (time).
    pub fn with_first(first: f64, wall: Duration) -> Self {
        Self {
            length: first,
            shortest: MIN_SHARE * first,
            wall,
        }
    }

    /// The length of the next piece (time).
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The end of the next piece, `until` at the latest.
    pub fn end(&self, now: EpochTime, until: EpochTime) -> EpochTime {
        let end = now.after(self.length);
        if end < until { end } else { until }
    }

    /// Learns from the duration of a piece that nothing else has cut short.
    pub fn has_taken(&mut self, wall: Duration) {
        if wall > 2 * self.wall {
            self.length = (0.5 * self.length).max(self.shortest);
        } else if 2 * wall < self.wall {
            self.length = (2.0 * self.length).min(MAX_MAGNITUDE);
        }
    }
}

/// A length in which little happens (time).
pub fn first_length(view: &View<'_>) -> f64 {
    let fastest = view
        .bodies()
        .map(|body| body.motion.velocity.length())
        .fold(0.0, f64::max);
    let length = FIRST_SHARE * view.bounds().sides().min_element() / fastest;
    // At rest any length does: nothing happens until a stage sets bodies moving, and then the first
    // length is found anew.
    if length > 0.0 && length.is_finite() {
        length.min(MAX_MAGNITUDE)
    } else {
        FIRST_SHARE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_follow_the_clock_and_end_with_the_run() {
        let second = Duration::from_secs(1);
        let mut pieces = Pieces::with_first(1.0, second);
        pieces.has_taken(second);
        assert_eq!(pieces.length(), 1.0);
        (0..3).for_each(|_| pieces.has_taken(second / 3));
        assert_eq!(pieces.length(), 8.0);
        (0..100).for_each(|_| pieces.has_taken(3 * second));
        assert_eq!(pieces.length(), 1e-6);
        let [now, soon, later] = [1.0, 1.0 + 1e-7, 2.0].map(EpochTime::from);
        assert_eq!(pieces.end(now, soon), soon);
        assert!(pieces.end(now, later) < later);
    }
}
