//! Mean squared displacement and velocity autocorrelation of the bodies.
//!
//! ⟨|x(t₀ + t) − x(t₀)|²⟩ (length²), x without periodic jumps, and ⟨v(t₀ + t)·v(t₀)⟩ (length² /
//! time²), over bodies and origins t₀. In a dense gas of equal discs −d ln C/dt at t = 0 is the
//! collision rate Γ, and C ≈ C(0) exp(−Γt) (Enskog's theory in two dimensions). D(t) = ¼
//! d⟨|Δx|²⟩/dt has no limit, since the tail of C falls as 1/t (Alder & Wainwright 1970). Lags are
//! 1, 2, …, 9, 10, 20, …, 90, 100, … spacings.

use carom_engine::{Observer, View};
use carom_geometry::GeometryError;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{
    Group,
    lags::{Clock, LagSum, LaggedSample, Lags, PairSums},
    moving_frame::MovingFrame,
};

/// Mean squared displacement and velocity autocorrelation of the moving bodies.
///
/// Positions and velocities are relative to the centre of mass along each axis on which momentum is
/// conserved (see [`CentreOfMassFrame`](carom_engine::CentreOfMassFrame)). After an edit at a
/// sample call `start`, so that the frame moves on with its new velocity.
///
/// Samples must be one spacing apart. A body contributes while it exists and belongs to the group.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{Group, TimeCorrelation};
///
/// // A disc moves in a straight line, ten times through the box. The bumper fixes the frame.
/// let disc = r#"
///     [[molecule]]
///     atoms = [{ at = [0, 0], radius = 0.05, mass = 1 }]
///     at = [0.0, 0.0]
///     velocity = [2.0, 0.0]
///     [[bumper]]
///     radius = 0.05
///     at = [0.5, 0.5]
/// "#;
/// let mut simulation = Simulation::new(&Scene::from_toml(disc)?)?;
/// let mut correlation = TimeCorrelation::new(Group::All, 0.25, 5.0)?;
/// for sample in 0..=20 {
///     simulation.observe_until(0.25 * f64::from(sample), &mut correlation)?;
///     correlation.sample(&simulation.view());
/// }
/// let points = correlation.points();
/// assert_eq!(points.len(), 1 + 9 + 2);
/// let last = points[11];
/// assert_eq!((last.lag, last.pairs, last.mean_square_displacement), (5.0, 1, 100.0));
/// assert_eq!(last.autocorrelation, 4.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "MSD")]
#[doc(alias = "VACF")]
pub struct TimeCorrelation {
    group: Group,
    clock: Clock,
    frame: MovingFrame,
    lags: Lags<State, Sums>,
}

/// The averages at one lag.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct CorrelationPoint {
    /// The lag t (time).
    pub lag: f64,
    /// The number of pairs of one body at t₀ and at t₀ + t; they are not independent of each other.
    pub pairs: u64,
    /// ⟨|x(t₀ + t) − x(t₀)|²⟩ (length²).
    #[doc(alias = "MSD")]
    pub mean_square_displacement: f64,
    /// ⟨|x(t₀ + t) − x(t₀)|⁴⟩ (length⁴); twice the square of ⟨|Δx|²⟩ if displacements are Gaussian,
    /// as the solution of the diffusion equation is.
    pub mean_fourth_displacement: f64,
    /// ⟨v(t₀ + t)·v(t₀)⟩ (length² / time²); ⟨v²⟩ at lag 0.
    #[doc(alias = "VACF")]
    pub autocorrelation: f64,
}

/// One body at one time, relative to the frame of the centre of mass.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct State {
    place: DVec2,
    velocity: DVec2,
}

#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct Sums {
    squares: f64,
    fourths: f64,
    products: f64,
}

impl TimeCorrelation {
    /// Correlations up to the lag `longest` (time) of samples that are `spacing` (time) apart; a
    /// `longest` below one spacing is taken as one spacing.
    ///
    /// # Errors
    /// [`GeometryError::NotPositive`] if `spacing` or `longest` is not positive and finite.
    pub fn new(group: Group, spacing: f64, longest: f64) -> Result<Self, GeometryError> {
        let (clock, lags) = Lags::new(spacing, longest)?;
        Ok(Self {
            group,
            clock,
            frame: MovingFrame::default(),
            lags,
        })
    }

    /// The averages so far in ascending order of lag, from lag 0 on; lags without pairs are
    /// omitted.
    pub fn points(&self) -> Vec<CorrelationPoint> {
        let lags = self.lags.each(&self.clock).filter(|(_, sum)| sum.pairs > 0);
        lags.map(|(lag, sum)| point(lag, sum)).collect()
    }

    /// All lags (time) in ascending order, from lag 0 on, also those without pairs.
    pub fn lags(&self) -> Vec<f64> {
        self.lags.times(&self.clock)
    }

    /// [Σx, Σw] over all samples so far, w the number of pairs: the squared displacement at each of
    /// the [lags](Self::lags) (length²), then the product of velocities at each (length² / time²),
    /// then the fourth power of the displacement (length⁴).
    pub fn sums(&self) -> Vec<[f64; 2]> {
        self.lags.terms([
            |sums| sums.squares,
            |sums| sums.products,
            |sums| sums.fourths,
        ])
    }

    /// The number of samples that were not one spacing after the previous sample, to one part in a
    /// million.
    ///
    /// An early sample is skipped. After a late sample no lag crosses the gap; earlier averages are
    /// kept.
    pub fn uneven(&self) -> u64 {
        self.lags.uneven()
    }
}

impl Observer for TimeCorrelation {
    #[inline]
    fn watches_any(&self) -> bool {
        false
    }

    fn start(&mut self, view: &View<'_>) {
        self.frame.follow(view);
    }

    fn sample(&mut self, view: &View<'_>) {
        self.frame.follow(view);
        if !self.lags.is_due(&self.clock, view.time()) {
            return;
        }
        let now: Vec<LaggedSample<State>> = self
            .frame
            .places(view, self.group)
            .map(|(body, place)| {
                let velocity = body.motion.velocity - self.frame.velocity;
                LaggedSample {
                    id: body.body.id(),
                    state: State { place, velocity },
                }
            })
            .collect();
        self.lags.take(&mut self.clock, view.time(), &now);
    }
}

impl PairSums<State> for Sums {
    fn add(&mut self, before: &State, now: &State) {
        let square = (now.place - before.place).length_squared();
        self.squares += square;
        self.fourths += square * square;
        self.products += now.velocity.dot(before.velocity);
    }
}

fn point(lag: f64, sum: &LagSum<Sums>) -> CorrelationPoint {
    let pairs = sum.pairs as f64;
    CorrelationPoint {
        lag,
        pairs: sum.pairs,
        mean_square_displacement: sum.sums.squares / pairs,
        mean_fourth_displacement: sum.sums.fourths / pairs,
        autocorrelation: sum.sums.products / pairs,
    }
}
