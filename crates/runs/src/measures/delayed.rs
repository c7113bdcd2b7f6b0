//! Observation in a window of time, so that the approach to equilibrium is not averaged into the
//! results.

use carom::{CollisionReport, Observer, View, engine::Body};
use serde::{Deserialize, Serialize};

/// A sample counts as reached if its time is too early by this share: times of samples are rounded.
const ROUNDING: f64 = 1e-9;

/// An observer that begins at the first sample at or after a time, and ends with the last sample at
/// or before another.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Delayed<O> {
    from: f64,
    until: f64,
    begun: bool,
    ended: bool,
    /// The observer.
    pub observer: O,
}

impl<O> Delayed<O> {
    /// Begins at the first sample at or after `from` (time), and ends with that at `until` (time);
    /// `until` is infinite, or the time of a sample.
    pub fn new(from: f64, until: f64, observer: O) -> Self {
        Self { from, until, begun: false, ended: false, observer }
    }

    fn is_open(&self) -> bool {
        self.begun && !self.ended
    }
}

impl<O: Observer> Observer for Delayed<O> {
    fn watches_any(&self) -> bool {
        self.is_open() && self.observer.watches_any()
    }

    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.is_open() && self.observer.watches(bodies)
    }

    /// After an edit; the first start is at the first sample.
    fn start(&mut self, view: &View<'_>) {
        if self.is_open() {
            self.observer.start(view);
        }
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        if self.is_open() {
            self.observer.collision(report);
        }
    }

    fn sample(&mut self, view: &View<'_>) {
        if self.ended {
            return;
        }
        if !self.begun {
            if view.time().to_f64() < self.from * (1.0 - ROUNDING) {
                return;
            }
            self.begun = true;
            self.observer.start(view);
        }
        self.observer.sample(view);
        self.ended = view.time().to_f64() >= self.until * (1.0 - ROUNDING);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::{CollisionRate, Scene};
    use carom_methods::AnySimulation;

    #[test]
    fn the_time_before_and_after_is_not_observed() {
        let scene = Scene::from_toml("[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 50").unwrap();
        let mut simulation = AnySimulation::new(&scene).unwrap();
        let mut delayed = Delayed::new(0.45, 0.8, CollisionRate::default());
        delayed.start(&simulation.view());
        for sample in 0..=10 {
            simulation.observe_until(0.1 * f64::from(sample), &mut delayed).unwrap();
            delayed.sample(&simulation.view());
        }
        // The first sample at or after 0.45 is that at 0.5, so the first interval ends at 0.6, and
        // the last at 0.8.
        let series = delayed.observer.series();
        assert_eq!(series.len(), 3);
        assert!((series[0].time - 0.6).abs() < 1e-12);
    }
}
