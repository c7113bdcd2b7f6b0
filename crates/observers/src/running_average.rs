//! Running averages of the force on a body and of its velocity, in its own frame (Montanari 2017,
//! section 3.2, item 3).
//!
//! J are the impulses on the body since t₀ and θ its orientation at each. F′(t) = Σ R(−θ) J / (t −
//! t₀) (mass × length / time²), and v̄′(t) is the mean of R(−θ) v over the samples so far (length /
//! time).

use carom_engine::{Body, BodyKey, CollisionReport, Observer, View};
use carom_kinematics::EpochTime;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::body_frame::in_body_frame;

/// Running averages of the force on one body and of its velocity, in its frame (x′, y′).
///
/// They begin at the first `start`. A later `start`, after an edit, changes nothing.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::RunningAverage;
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100")?;
/// let mut simulation = Simulation::new(&scene)?;
/// let watched = simulation.view().bodies().next().expect("there are a hundred").body.key();
/// let mut average = RunningAverage::new(watched);
/// average.start(&simulation.view());
/// for sample in 1..=3 {
///     simulation.observe_until(f64::from(sample), &mut average)?;
///     average.sample(&simulation.view());
/// }
/// assert_eq!(average.series().len(), 3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "progressive sum")]
pub struct RunningAverage {
    body: BodyKey,
    began: Option<EpochTime>,
    momentum: DVec2,
    velocity: DVec2,
    series: Vec<RunningPoint>,
}

/// The averages at one sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RunningPoint {
    /// Time of the sample.
    pub time: f64,
    /// Sum of all Δp in the body's frame, divided by the time since the start: the mean force (mass
    /// × length / time²); 0 before any time has passed.
    pub momentum: DVec2,
    /// Mean over the samples of the velocity in the body's frame (length / time).
    pub velocity: DVec2,
}

impl RunningAverage {
    /// Empty averages for one body.
    pub fn new(body: BodyKey) -> Self {
        Self {
            body,
            began: None,
            momentum: DVec2::ZERO,
            velocity: DVec2::ZERO,
            series: Vec::new(),
        }
    }

    /// The observed body.
    pub fn body(&self) -> BodyKey {
        self.body
    }

    /// The averages at each sample so far.
    pub fn series(&self) -> &[RunningPoint] {
        &self.series
    }
}

impl Observer for RunningAverage {
    #[inline]
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.body.is_among(bodies)
    }

    fn start(&mut self, view: &View<'_>) {
        self.began.get_or_insert(view.time());
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        let Some((side, impulse)) = report.side_of(self.body) else {
            return;
        };
        self.began.get_or_insert(report.time);
        self.momentum += in_body_frame(impulse, side.before.orientation);
    }

    fn sample(&mut self, view: &View<'_>) {
        let Some(watched) = view.body(self.body) else {
            return;
        };
        let elapsed = view.time().since(*self.began.get_or_insert(view.time()));
        self.velocity += in_body_frame(watched.motion.velocity, watched.motion.orientation);
        self.series.push(RunningPoint {
            time: view.time().to_f64(),
            momentum: if elapsed > 0.0 {
                self.momentum / elapsed
            } else {
                DVec2::ZERO
            },
            velocity: self.velocity / (self.series.len() + 1) as f64,
        });
    }
}
