//! A run with samples at equal intervals of time.

use carom_detection::Detection;
use carom_kinematics::EpochTime;
use carom_response::Response;

use crate::{Observer, RunError, Scheduler, Simulation};

/// Samples of one run. More could not be counted one by one in floating point.
const MOST_SAMPLES: f64 = (1u64 << 53) as f64;

/// Rounding of the end of a run and of the interval may lose a sample. A sample counts as reached if
/// at most this share of the interval is missing, and no more than that rounding. Larger: of
/// intervals as short as the rounding of the end, samples are taken before their time.
const LARGEST_SHORTFALL: f64 = 0.25;

impl<D: Detection, R: Response, S: Scheduler> Simulation<D, R, S> {
    /// Runs to `until` (time) and takes a sample every `interval` (time, positive).
    ///
    /// [`Observer::start`] is called first, [`Observer::collision`] at each collision that the
    /// observer watches, and [`Observer::sample`] after each full interval from now on. A last
    /// interval that ends later than `until` by rounding alone counts as full: its sample is taken
    /// at `until`. Samples change no bit of the trajectory. A time that has passed already changes
    /// nothing.
    ///
    /// ```
    /// use carom_engine::{CollisionReport, Observer, Scene, Simulation, View};
    ///
    /// /// Collisions so far at each sample.
    /// #[derive(Default)]
    /// struct Collisions(Vec<u64>);
    ///
    /// impl Observer for Collisions {
    ///     fn sample(&mut self, view: &View<'_>) {
    ///         self.0.push(view.counters().collisions);
    ///     }
    /// }
    ///
    /// let scene = Scene::from_toml("[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 50")?;
    /// let mut collisions = Collisions::default();
    /// Simulation::new(&scene)?.sample_every(0.25, 2.0, &mut collisions)?;
    /// assert_eq!(collisions.0.len(), 8);
    /// assert!(collisions.0.is_sorted() && collisions.0[7] > 50);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`RunError::Interval`] if the interval is not positive and finite, or so short that more
    /// than 2^53 samples would be taken; else as [`Self::run_until`].
    pub fn sample_every<O: Observer + ?Sized>(
        &mut self,
        interval: f64,
        until: f64,
        observer: &mut O,
    ) -> Result<(), RunError> {
        if !(interval > 0.0 && interval.is_finite()) {
            return Err(RunError::Interval(interval));
        }
        if !until.is_finite() {
            return Err(RunError::Time(until));
        }
        let (start, end) = (self.time(), EpochTime::from(until));
        let samples = samples_between(start, end, interval);
        if samples > MOST_SAMPLES {
            return Err(RunError::Interval(interval));
        }
        observer.start(&self.view());
        for sample in 1..=samples as u64 {
            // Times are multiples of the interval, so that no rounding adds up.
            let time = start.after(sample as f64 * interval);
            self.observe_until_instant(if time > end { end } else { time }, observer)?;
            observer.sample(&self.view());
        }
        self.observe_until(until, observer)
    }
}

/// How many multiples of `interval` (time) lie between two instants, as far as the rounding of the
/// three tells; 0 if `end` is not later by a float.
fn samples_between(start: EpochTime, end: EpochTime, interval: f64) -> f64 {
    let until = end.to_f64();
    if until <= start.to_f64() {
        return 0.0;
    }
    let duration = end.since(start);
    let rounding = 4.0 * f64::EPSILON * duration + f64::EPSILON * until.abs();
    (duration / interval + (rounding / interval).min(LARGEST_SHORTFALL)).floor()
}
