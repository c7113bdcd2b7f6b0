//! Collisions per body and time, from the counters at each sample.
//!
//! Γ = (2 C + F) / (N t) (1 / time), with C contacts of two moving bodies, which count for both, F
//! contacts with a fixed body, which count for the moving one, and N moving bodies, averaged over
//! the time t. For hard discs at equilibrium Γ = 2 n σ χ √(π kT / m) (Enskog's theory in two
//! dimensions; n bodies per area, χ the pair distribution at contact).

use carom_engine::{Counters, Observer, View};
use carom_tables::block_sums::mean_of_series;
use serde::{Deserialize, Serialize};

use crate::open_interval::OpenInterval;

/// Collisions per body and unit time, for each interval between samples. An edit within an interval
/// divides it if it is announced by [`Observer::pause`]; the interval begins anew if it is not.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::CollisionRate;
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100")?;
/// let mut simulation = Simulation::new(&scene)?;
/// let mut rate = CollisionRate::default();
/// rate.start(&simulation.view());
/// for sample in 1..=10 {
///     simulation.observe_until(f64::from(sample), &mut rate)?;
///     rate.sample(&simulation.view());
/// }
/// let (mean, standard_error) = rate.mean().expect("there are ten intervals");
/// assert!(mean > 0.0 && standard_error < 0.1 * mean);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct CollisionRate {
    /// The open interval with the number of moving bodies, and the counters at its beginning.
    interval: Option<(OpenInterval<f64>, Counters)>,
    series: Vec<RatePoint>,
}

/// The collisions in the interval that ends at one sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RatePoint {
    /// Time of the sample.
    pub time: f64,
    /// Contacts in the interval, including those with fixed bodies.
    pub collisions: u64,
    /// Collisions per moving body and time (1 / time); 0 if no body moves.
    pub rate: f64,
}

impl CollisionRate {
    /// The intervals so far. The first begins at `start`, or at the first sample without one.
    /// Intervals of length 0 are omitted.
    pub fn series(&self) -> &[RatePoint] {
        &self.series
    }

    /// Mean rate over the intervals and its standard error from blocks (1 / time); `None` with
    /// fewer than two intervals. They count equally: it holds for intervals of equal length.
    pub fn mean(&self) -> Option<(f64, f64)> {
        mean_of_series(self.series.iter().map(|point| point.rate))
    }
}

impl Observer for CollisionRate {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn start(&mut self, view: &View<'_>) {
        let (time, moving) = (view.time(), moving(view));
        let continues = self
            .interval
            .as_mut()
            .is_some_and(|(interval, _)| interval.proceed(time, moving));
        if !continues {
            self.interval = Some((OpenInterval::new(time, moving), *view.counters()));
        }
    }

    fn pause(&mut self, view: &View<'_>) {
        if let Some((interval, _)) = &mut self.interval {
            interval.pause(view.time(), moving(view));
        }
    }

    fn sample(&mut self, view: &View<'_>) {
        let (time, counters) = (view.time(), *view.counters());
        let moving = moving(view);
        let next = (OpenInterval::new(time, moving), counters);
        let Some((interval, before)) = self.interval.replace(next) else {
            return;
        };
        let duration = interval.duration(time);
        if duration <= 0.0 {
            return;
        }
        // In an edited checkpoint these counts may be later than those of the simulation.
        let collisions = counters.collisions.saturating_sub(before.collisions);
        let suffered = counters
            .collisions_of_moving()
            .saturating_sub(before.collisions_of_moving());
        let moving = interval.mean(time, moving);
        let rate = if moving == 0.0 {
            0.0
        } else {
            suffered as f64 / (moving * duration)
        };
        self.series.push(RatePoint {
            time: time.to_f64(),
            collisions,
            rate,
        });
    }
}

/// Number of moving bodies.
fn moving(view: &View<'_>) -> f64 {
    view.bodies().filter(|view| view.body.is_free()).count() as f64
}
