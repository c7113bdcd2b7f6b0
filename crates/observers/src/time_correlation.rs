//! Mean squared displacement and velocity autocorrelation of the bodies.
//!
//! ⟨|x(t₀ + t) − x(t₀)|²⟩ (length²), x without periodic jumps, and ⟨v(t₀ + t)·v(t₀)⟩ (length² /
//! time²), over bodies and origins t₀. In a dense gas of equal discs −d ln C/dt at t = 0 is the
//! collision rate Γ, and C ≈ C(0) exp(−Γt) (Enskog's theory in two dimensions). D(t) = ¼
//! d⟨|Δx|²⟩/dt has no limit, since the tail of C falls as 1/t (Alder & Wainwright 1970). Lags are
//! 1, 2, …, 9, 10, 20, …, 90, 100, … spacings: level k keeps the last nine samples taken every 10ᵏ
//! samples (after Frenkel & Smit 2002, section 4.4.2), so that memory grows with the logarithm of
//! the longest lag.

use std::collections::VecDeque;

use carom_engine::{Observer, View};
use carom_geometry::{GeometryError, check_positive};
use carom_kinematics::EpochTime;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::Group;

/// The ratio of the sampling intervals of successive levels.
const RATIO: u64 = 10;

/// A limit on the number of spacings, larger than in any run: 10¹⁸.
const MOST_SPACINGS: u64 = RATIO.pow(18);

/// The largest relative deviation of an interval from the spacing, and so the accuracy of the lags.
const EVENNESS: f64 = 1e-6;

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
    spacing: f64,
    /// The time of the last sample taken.
    last: Option<EpochTime>,
    frame: MovingFrame,
    /// The number of samples taken since the last gap.
    taken: u64,
    uneven: u64,
    at_zero: LagSum,
    levels: Vec<Level>,
}

/// The averages at one lag.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CorrelationPoint {
    /// The lag t (time).
    pub lag: f64,
    /// The number of pairs of one body at t₀ and at t₀ + t; they are not independent of each other.
    pub pairs: u64,
    /// ⟨|x(t₀ + t) − x(t₀)|²⟩ (length²).
    #[doc(alias = "MSD")]
    pub mean_square_displacement: f64,
    /// ⟨v(t₀ + t)·v(t₀)⟩ (length² / time²); ⟨v²⟩ at lag 0.
    #[doc(alias = "VACF")]
    pub autocorrelation: f64,
}

/// The displacement of the frame of the centre of mass, integrated from its velocity between
/// samples.
///
/// The position Σ m x / M would jump when a body is added or removed.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct MovingFrame {
    /// The time from which the velocity is valid; `None` before the first sample.
    since: Option<EpochTime>,
    velocity: DVec2,
    displacement: DVec2,
}

/// One body at one time, relative to the frame of the centre of mass.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Sample {
    id: u64,
    place: DVec2,
    velocity: DVec2,
}

/// The samples taken every `stride` samples, the latest first, and the sums for the lags of 1, 2, …
/// strides.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Level {
    stride: u64,
    past: VecDeque<Vec<Sample>>,
    sums: Vec<LagSum>,
}

#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct LagSum {
    pairs: u64,
    squares: f64,
    products: f64,
}

impl TimeCorrelation {
    /// Correlations up to the lag `longest` (time) of samples that are `spacing` (time) apart; a
    /// `longest` below one spacing is taken as one spacing.
    ///
    /// # Errors
    /// [`GeometryError::NotPositive`] if `spacing` or `longest` is not positive and finite.
    pub fn new(group: Group, spacing: f64, longest: f64) -> Result<Self, GeometryError> {
        let spacing = check_positive("the spacing of samples", spacing)?;
        let longest = check_positive("the longest lag", longest)?;
        let spacings = ((longest / spacing * (1.0 + EVENNESS)) as u64).clamp(1, MOST_SPACINGS);
        let strides = (0..).map(|level| RATIO.pow(level)).take_while(|&stride| stride <= spacings);
        let level = |stride: u64| {
            let lags = (spacings / stride).min(RATIO - 1) as usize;
            Level { stride, past: VecDeque::new(), sums: vec![LagSum::default(); lags] }
        };
        let levels = strides.map(level).collect();
        let frame = MovingFrame::default();
        Ok(Self {
            group,
            spacing,
            last: None,
            frame,
            taken: 0,
            uneven: 0,
            at_zero: LagSum::default(),
            levels,
        })
    }

    /// The averages so far in ascending order of lag, from lag 0 on; lags without pairs are
    /// omitted.
    pub fn points(&self) -> Vec<CorrelationPoint> {
        let lags = self.levels.iter().flat_map(|level| {
            let strides = 1..;
            strides.zip(&level.sums).map(|(count, sum): (u64, _)| (count * level.stride, sum))
        });
        std::iter::once((0, &self.at_zero))
            .chain(lags)
            .filter(|(_, sum)| sum.pairs > 0)
            .map(|(spacings, sum)| sum.point(spacings as f64 * self.spacing))
            .collect()
    }

    /// The number of samples that were not one spacing after the previous sample, to one part in a
    /// million.
    ///
    /// An early sample is skipped. After a late sample no lag crosses the gap; earlier averages are
    /// kept.
    pub fn uneven(&self) -> u64 {
        self.uneven
    }

    /// Whether to take a sample now; clears the samples before a gap.
    fn is_due(&mut self, time: EpochTime) -> bool {
        let Some(last) = self.last else { return true };
        let late = time.since(last) - self.spacing;
        if late.abs() <= EVENNESS * self.spacing {
            return true;
        }
        self.uneven += 1;
        if late > 0.0 {
            self.taken = 0;
            self.levels.iter_mut().for_each(|level| level.past.clear());
        }
        late > 0.0
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
        if !self.is_due(view.time()) {
            return;
        }
        let (group, frame) = (self.group, self.frame);
        let moving = view.bodies().filter(|view| !view.body.is_fixed() && group.contains(view.body));
        let now: Vec<Sample> = moving
            .map(|body| Sample {
                id: body.body.id(),
                place: body.unwrapped(view.bounds()) - frame.displacement,
                velocity: body.motion.velocity - frame.velocity,
            })
            .collect();
        self.at_zero.add(&now, &now);
        for level in self.levels.iter_mut().take_while(|level| self.taken.is_multiple_of(level.stride)) {
            level.take(&now);
        }
        self.last = Some(view.time());
        self.taken += 1;
    }
}

impl MovingFrame {
    /// Advances to the time of the view. The velocity until then is that of the last view, because
    /// only an edit, which takes no time, changes it.
    fn follow(&mut self, view: &View<'_>) {
        if let Some(since) = self.since {
            self.displacement += view.time().since(since) * self.velocity;
        }
        self.since = Some(view.time());
        self.velocity = view.centre_of_mass_frame().velocity();
    }
}

impl Level {
    fn take(&mut self, now: &[Sample]) {
        for (sum, past) in self.sums.iter_mut().zip(&self.past) {
            sum.add(past, now);
        }
        // Reuses the memory of the oldest sample.
        let mut sample =
            if self.past.len() == self.sums.len() { self.past.pop_back() } else { None }.unwrap_or_default();
        sample.clear();
        sample.extend_from_slice(now);
        self.past.push_front(sample);
    }
}

impl LagSum {
    /// Adds the bodies that are in both samples; each sample is in ascending order of number.
    fn add(&mut self, past: &[Sample], now: &[Sample]) {
        let mut rest = past.iter().peekable();
        for sample in now {
            while rest.next_if(|before| before.id < sample.id).is_some() {}
            if let Some(before) = rest.next_if(|before| before.id == sample.id) {
                self.pairs += 1;
                self.squares += (sample.place - before.place).length_squared();
                self.products += sample.velocity.dot(before.velocity);
            }
        }
    }

    fn point(&self, lag: f64) -> CorrelationPoint {
        let pairs = self.pairs as f64;
        CorrelationPoint {
            lag,
            pairs: self.pairs,
            mean_square_displacement: self.squares / pairs,
            autocorrelation: self.products / pairs,
        }
    }
}
