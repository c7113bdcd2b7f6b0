//! Mean squared displacement and velocity autocorrelation of the bodies.
//!
//! ⟨|x(t₀ + t) − x(t₀)|²⟩ (length²), x without periodic jumps, and ⟨v(t₀ + t)·v(t₀)⟩ (length² /
//! time²), over bodies and origins t₀. In a dense gas of equal discs −d ln C/dt at t = 0 is the
//! collision rate Γ, and C ≈ C(0) exp(−Γt) (Enskog's theory in two dimensions). D(t) = ¼
//! d⟨|Δx|²⟩/dt has no limit, since the tail of C falls as 1/t (Alder & Wainwright 1970). Lags are
//! 1, 2, …, 9, 10, 20, …, 90, 100, … spacings.
//!
//! Under shear both are relative to the flow γ (y − Ly/2): the displacement is the integral of the
//! velocity relative to it, Δx = x(t₀ + t) − x(t₀) − γ ∫ (y − Ly/2) dt', exact to rounding. In a
//! stationary flow the relation of the two of free space holds, ½ d⟨Δx²⟩/dt = ∫ ⟨v_x v_x⟩ dt; the
//! coefficients along x and y differ (`along`).

use carom_engine::{CollisionReport, Observer, View};
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
/// conserved (see [`CentreOfMassFrame`](carom_engine::CentreOfMassFrame)), under shear also to the
/// flow. After an edit at a sample call `start`, so that the frame moves on with its new velocity.
/// Under shear it must receive all contacts from the first sample on.
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
    /// 1 for each component that counts, 0 for the other.
    components: DVec2,
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
    /// ⟨|x(t₀ + t) − x(t₀)|⁴⟩ (length⁴); twice the square of ⟨|Δx|²⟩, three times that of one
    /// component, if displacements are Gaussian, as the solution of the diffusion equation is.
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
            components: DVec2::ONE,
            lags,
        })
    }

    /// Restricts displacements and velocities to one axis, 0 for x and 1 for y. Call it before the
    /// first sample.
    ///
    /// ```
    /// use carom_engine::{Observer, Scene, Simulation};
    /// use carom_observers::{Group, TimeCorrelation};
    ///
    /// let scene = Scene::from_toml(r#"
    ///     [box]
    ///     shear_rate = 2.0
    ///     [[gas]]
    ///     radius = 0.02
    ///     mass = 1.0
    ///     energy = 1.0
    ///     count = 100
    /// "#)?;
    /// let mut simulation = Simulation::new(&scene)?;
    /// let along = |axis| TimeCorrelation::new(Group::All, 0.1, 1.0).map(|all| all.along(axis));
    /// let mut both = (along(0)?, along(1)?);
    /// for sample in 0..=20 {
    ///     simulation.observe_until(0.1 * f64::from(sample), &mut both)?;
    ///     both.sample(&simulation.view());
    /// }
    /// assert_eq!(both.0.points().len(), 1 + 9 + 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn along(self, axis: usize) -> Self {
        let components = if axis == 0 { DVec2::X } else { DVec2::Y };
        Self { components, ..self }
    }

    /// The axis to which it is restricted, 0 for x and 1 for y; `None` for both.
    pub fn axis(&self) -> Option<usize> {
        let counted = self.components.to_array().map(|component| component != 0.0);
        match counted {
            [true, false] => Some(0),
            [false, true] => Some(1),
            _ => None,
        }
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
        self.frame.is_flowing()
    }

    fn start(&mut self, view: &View<'_>) {
        self.frame.follow(view);
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.frame.collide(report);
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
                let velocity = self.components * self.frame.relative(&body.motion);
                let place = self.components * place;
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

#[cfg(test)]
mod tests {
    use super::*;
    use carom_engine::{Scene, Simulation};

    const RATE: f64 = 1.7;

    /// Two pairs of discs that pass through each other, with opposite velocities relative to the
    /// flow at the start.
    fn transparent() -> Scene {
        let disc = |[x, y]: [f64; 2], [u, v]: [f64; 2]| {
            format!(
                "[[molecule]]\ntags = [\"disc\"]\natoms = [{{ at = [0, 0], radius = 0.01, mass = 1 }}]\n\
                 at = [{x:?}, {y:?}]\nvelocity = [{u:?}, {v:?}]\n"
            )
        };
        let discs = [
            disc([0.2, 0.95], [0.3, 0.8]),
            disc([0.7, 0.3], [-0.3, -0.8]),
            disc([0.4, 0.6], [0.0, 0.0]),
            disc([0.5, 0.1], [0.0, 0.0]),
        ];
        let text = format!(
            "[box]\nsides = [1.0, 1.25]\nshear_rate = {RATE:?}\n[[transparent]]\nbetween = [\"disc\"]\n{}",
            discs.concat()
        );
        Scene::from_toml(&text).unwrap()
    }

    /// A free body of velocity (u, v) relative to the flow at the start has u − γ v t later, and is
    /// displaced by u t − γ v t²/2 along x: over many passages through the seam, and 0 for bodies
    /// that move with the flow. From an origin t₀ the velocity is that at t₀.
    #[test]
    fn free_bodies_in_a_flow_have_their_displacements_by_hand() {
        let mut simulation = Simulation::new(&transparent()).unwrap();
        let new = || TimeCorrelation::new(Group::All, 0.25, 5.0).unwrap();
        let mut all = (new(), new().along(0), new().along(1));
        for sample in 0..=20 {
            simulation
                .observe_until(0.25 * f64::from(sample), &mut all)
                .unwrap();
            all.sample(&simulation.view());
        }
        let windings = simulation.view().bodies().map(|body| body.winding[1].abs());
        assert!(windings.max() >= Some(3));
        assert_eq!(
            (all.0.axis(), all.1.axis(), all.2.axis()),
            (None, Some(0), Some(1))
        );
        let points = [all.0.points(), all.1.points(), all.2.points()];
        let lags = points[0]
            .iter()
            .map(|point| (point.lag / 0.25).round() as u64);
        for (index, lag) in lags.enumerate() {
            // Half of the bodies move. Origins are at multiples of the stride of the level.
            let stride = 10_u64.pow(lag.max(1).ilog10());
            let (mut squares, mut products, mut origins) = (DVec2::ZERO, DVec2::ZERO, 0.0);
            for origin in (0..=20 - lag).step_by(stride as usize) {
                let [t, s] = [lag, origin].map(|samples| 0.25 * samples as f64);
                let [before, after] =
                    [s, s + t].map(|time| DVec2::new(0.3 - RATE * 0.8 * time, 0.8));
                let moved = 0.5 * t * (before + after);
                squares += 0.5 * moved * moved;
                products += 0.5 * before * after;
                origins += 1.0;
            }
            let near = |found: f64, expected: f64| {
                let error = (found - expected).abs();
                assert!(
                    error < 1e-10 * expected.abs().max(1.0),
                    "{lag}: {found} {expected}"
                );
            };
            let [of_all, of_x, of_y] = [0, 1, 2].map(|place| points[place][index]);
            near(of_x.mean_square_displacement, squares.x / origins);
            near(of_y.mean_square_displacement, squares.y / origins);
            near(
                of_all.mean_square_displacement,
                squares.element_sum() / origins,
            );
            near(of_x.autocorrelation, products.x / origins);
            near(of_y.autocorrelation, products.y / origins);
        }
        // Bodies that move with the flow rest relative to it.
        let mut still = TimeCorrelation::new(Group::All, 0.5, 5.0).unwrap();
        let mut scene = transparent();
        scene.molecule.drain(..2);
        let mut simulation = Simulation::new(&scene).unwrap();
        for sample in 0..=10 {
            simulation
                .observe_until(0.5 * f64::from(sample), &mut still)
                .unwrap();
            still.sample(&simulation.view());
        }
        let points = still.points();
        assert_eq!(points.last().unwrap().lag, 5.0);
        assert!(
            points
                .iter()
                .all(|point| point.mean_square_displacement < 1e-24)
        );
        assert!(points.iter().all(|point| point.autocorrelation < 1e-24));
    }

    /// A drift along y carries all bodies into faster flows: relative to their centre of mass they
    /// move as without it.
    #[test]
    fn a_drift_across_the_flow_is_that_of_the_frame() {
        let mut scene = transparent();
        for molecule in &mut scene.molecule {
            molecule.velocity = [molecule.velocity[0] + 0.2, molecule.velocity[1] + 0.7];
        }
        let [drifting, resting] = [scene, transparent()].map(|scene| {
            let mut simulation = Simulation::new(&scene).unwrap();
            let mut correlation = TimeCorrelation::new(Group::All, 0.25, 4.0).unwrap();
            for sample in 0..=16 {
                simulation
                    .observe_until(0.25 * f64::from(sample), &mut correlation)
                    .unwrap();
                correlation.sample(&simulation.view());
            }
            correlation.points()
        });
        for (one, other) in drifting.iter().zip(&resting) {
            let apart = one.mean_square_displacement - other.mean_square_displacement;
            assert!(
                apart.abs() < 1e-10 * (1.0 + other.mean_square_displacement),
                "{one:?} {other:?}"
            );
            assert!((one.autocorrelation - other.autocorrelation).abs() < 1e-10);
        }
    }

    const GAS: &str = "[box]\nsides = [1.0, 1.2]\nseed = 5\nshear_rate = 1.7\n[elasticity]\ndefault = 0.9\n\
                       [[gas]]\nradius = 0.04\nmass = 1.0\ntemperature = 1.0\ncount = 50\n";

    /// The integral of y from the contacts against the trapezoidal rule over many short steps.
    #[test]
    fn displacements_between_contacts_are_those_of_short_steps() {
        let mut simulation = Simulation::new(&Scene::from_toml(GAS).unwrap()).unwrap();
        let mut correlation = TimeCorrelation::new(Group::All, 1.0, 1.0).unwrap();
        let states = |simulation: &Simulation| -> Vec<[f64; 3]> {
            let view = simulation.view();
            let bounds = view.bounds();
            view.bodies()
                .map(|body| {
                    let place = body.unwrapped(&bounds);
                    [place.x, place.y, body.motion.velocity.y]
                })
                .collect()
        };
        correlation.sample(&simulation.view());
        let frame = simulation.view().centre_of_mass_frame().velocity();
        let first = states(&simulation);
        let mut carried = vec![0.0; first.len()];
        let (mut before, steps) = (first.clone(), 8000);
        for step in 1..=steps {
            simulation
                .observe_until(f64::from(step) / f64::from(steps), &mut correlation)
                .unwrap();
            let now = states(&simulation);
            for ((sum, one), other) in carried.iter_mut().zip(&before).zip(&now) {
                *sum += RATE * (0.5 * (one[1] + other[1]) - 0.6) / f64::from(steps);
            }
            before = now;
        }
        assert!(simulation.view().counters().collisions > 200);
        correlation.sample(&simulation.view());
        let moved = |index: usize| {
            let [x, y] = [0, 1].map(|axis| before[index][axis] - first[index][axis]);
            DVec2::new(x - carried[index] - frame.x, y - frame.y).length_squared()
        };
        let expected = (0..first.len()).map(moved).sum::<f64>() / first.len() as f64;
        let found = correlation.points()[1].mean_square_displacement;
        // The trapezoidal rule errs by the change of velocity times the square of the step.
        assert!(
            (found - expected).abs() < 1e-5 * expected,
            "{found} {expected}"
        );
    }

    /// A shear that begins, ends and begins again at edits: the displacement relative to the flow
    /// counts the flow of each stage, and has no jumps.
    #[test]
    fn a_shear_that_ends_carries_no_longer() {
        let mut scene = transparent();
        scene.bounds.shear_rate = 0.0;
        let mut simulation = Simulation::new(&scene).unwrap();
        let mut correlation = TimeCorrelation::new(Group::All, 0.5, 3.0).unwrap().along(0);
        assert!(!correlation.watches_any());
        correlation.start(&simulation.view());
        for sample in 0..=6 {
            simulation
                .observe_until(0.5 * f64::from(sample), &mut correlation)
                .unwrap();
            correlation.sample(&simulation.view());
            if [2, 4].contains(&sample) {
                correlation.pause(&simulation.view());
                let rate = if sample == 2 { RATE } else { 0.0 };
                simulation.set_shear_rate(rate).unwrap();
                correlation.start(&simulation.view());
                assert_eq!(correlation.watches_any(), sample == 2);
            }
        }
        // At t = 1 a body is at y in the box. Up to t = 2 its velocity relative to the flow is
        // u − γ (y + v (t − 1) − Ly/2); later it is that in the box, which `rows` passages through
        // the seam have changed.
        let height = 1.25;
        let bodies = [
            [0.95, 0.3, 0.8],
            [0.3, -0.3, -0.8],
            [0.6, 0.0, 0.0],
            [0.1, 0.0, 0.0],
        ];
        let moved = bodies.map(|[a, u, v]: [f64; 3]| {
            let y = (a + v).rem_euclid(height);
            let rows = ((y + v) / height).floor();
            3.0 * u - RATE * (y + 0.5 * v - 0.5 * height) - RATE * height * rows
        });
        let mean = moved.iter().sum::<f64>() / 4.0;
        let expected = moved.map(|x| (x - mean).powi(2)).iter().sum::<f64>() / 4.0;
        let point = *correlation.points().last().unwrap();
        assert_eq!(point.lag, 3.0);
        assert!(
            (point.mean_square_displacement - expected).abs() < 1e-10,
            "{point:?} {expected}"
        );
    }
}
