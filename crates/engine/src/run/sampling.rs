//! Runs with samples at equal intervals of time.

use carom_detection::Detection;
use carom_kinematics::EpochTime;
use carom_response::Response;

use crate::{
    run::{observer::Observer, simulation::Simulation},
    scene::error::RunError,
    scheduler::Scheduler,
};

/// Largest number of samples of one run. Floating-point numbers cannot count more one by one.
const MAX_SAMPLES: f64 = (1u64 << 53) as f64;

/// Rounding of the end of a run and of the interval could lose a sample. A sample counts as reached
/// if at most this share of the interval is missing, and no more than that rounding. Larger: for
/// intervals as short as the rounding of the end, samples are taken too early.
const MAX_SHORTFALL: f64 = 0.25;

impl<D: Detection, R: Response, S: Scheduler> Simulation<D, R, S> {
    /// Runs to `until` (time) and takes a sample every `interval` (time, positive).
    ///
    /// [`Observer::start`] is called first, [`Observer::collision`] at each collision that the
    /// observer watches, and [`Observer::sample`] after each full interval from now on. A last
    /// interval that ends after `until` by rounding alone counts as full: its sample is taken at
    /// `until`. Samples change no bit of the trajectory.
    ///
    /// ```
    /// use carom_engine::{CollisionReport, Observer, Scene, Simulation, View};
    ///
    /// /// The number of collisions at each sample.
    /// #[derive(Default)]
    /// struct Collisions(Vec<u64>);
    ///
    /// impl Observer for Collisions {
    ///     fn sample(&mut self, view: &View<'_>) {
    ///         self.0.push(view.counters().collisions);
    ///     }
    /// }
    ///
    /// let gas = "[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 50";
    /// let scene = Scene::from_toml(gas)?;
    /// let mut collisions = Collisions::default();
    /// Simulation::new(&scene)?.sample_every(0.25, 2.0, &mut collisions)?;
    /// assert_eq!(collisions.0.len(), 8);
    /// assert!(collisions.0.is_sorted() && collisions.0[7] > 50);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`RunError::Interval`] if the interval is not positive and finite, or so short that more
    /// than 2^53 samples would be taken; otherwise those of [`Self::run_until`].
    pub fn sample_every(
        &mut self,
        interval: f64,
        until: f64,
        observer: &mut dyn Observer,
    ) -> Result<(), RunError> {
        if !(interval > 0.0 && interval.is_finite()) {
            return Err(RunError::Interval(interval));
        }
        let (start, end) = (self.time(), self.end_of_run(until)?);
        let samples = samples_between(start, end, interval);
        if samples > MAX_SAMPLES {
            return Err(RunError::Interval(interval));
        }
        observer.start(&self.view());
        for sample in 1..=samples as u64 {
            // Times are multiples of the interval, so that roundings do not add up.
            let time = start.after(sample as f64 * interval);
            self.observe_until_epoch_time(if time > end { end } else { time }, observer)?;
            observer.sample(&self.view());
        }
        self.observe_until(until, observer)
    }
}

/// Number of multiples of `interval` (time) between two times, to their rounding; 0 unless `end` is
/// later by at least one float.
fn samples_between(start: EpochTime, end: EpochTime, interval: f64) -> f64 {
    let until = end.to_f64();
    if until <= start.to_f64() {
        return 0.0;
    }
    let duration = end.since(start);
    let rounding = 4.0 * f64::EPSILON * duration + f64::EPSILON * until.abs();
    (duration / interval + (rounding / interval).min(MAX_SHORTFALL)).floor()
}
