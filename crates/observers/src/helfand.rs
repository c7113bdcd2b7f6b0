//! Shear viscosity (mass / time) and heat conductivity (1 / time) from Helfand moments.
//!
//! **Viscosity.**
//! G_xy(t) = ∫₀ᵗ dt' Σ m v_x v_y + Σ r_x J_y over the contacts until t: v relative to the centre of
//! mass, r from the first body's centre of mass to that of the touched image of the second, J the
//! impulse on the second. Both terms are exact for hard bodies, since the velocities are constant
//! between contacts. With M(t) = ⟨(G_xy(t₀ + t) − G_xy(t₀))²⟩,
//!
//! η = lim (t → ∞) M(t) / (2 A kT t)
//!
//! (Helfand 1960; Alder, Gass & Wainwright 1970). M / 2 A kT t approaches η as τ/t, with τ a few
//! times the time between two collisions of a body; dM/dt / (2 A kT) between two lags is η without
//! this term. In two dimensions the tail of the stress autocorrelation falls as 1/t, so that η(t)
//! grows with ln t for long t in a large system; for dilute gases this is small.
//!
//! Enskog's theory for discs of diameter σ at the area fraction φ (Gass 1971):
//! η = η₀ [1/χ + 2φ + 0.8729 (2φ)² χ], η₀ = 1.022 √(m kT / π) / 2σ, with χ the pair distribution at
//! contact.
//!
//! M is the mean over two shears, (G_xy + G_yx) / 2 and (G_xx − G_yy) / 2, which is the first in
//! axes turned by an eighth of a turn. Discs have G_xy = G_yx.
//!
//! **Heat conductivity.** G_λ(t) = ∫₀ᵗ dt' Σ e v + Σ r Δe over the contacts until t: e the kinetic
//! energy of a body, with its rotation, relative to the centre of mass, Δe the energy that the
//! second body of a contact gains. With M(t) the mean of ⟨(ΔG_λ)²⟩ over x and y,
//!
//! λ/k = lim (t → ∞) M(t) / (2 A (kT)² t)
//!
//! for bodies of one kind: total momentum 0 then makes the flux of enthalpy vanish (Helfand 1960).
//! Enskog's theory: λ = λ₀ [1/χ + 3φ + 0.8718 (2φ)² χ], λ₀ = 1.029 · 2 k √(kT / π m) / σ (Gass
//! 1971).

use carom_engine::{Body, CollisionReport, Observer, Side, View};
use carom_geometry::{GeometryError, PeriodicBox};
use carom_kinematics::{EpochTime, Motion, kinetic_energy};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::lags::{Clock, LagSum, LaggedSample, Lags, PairSums};

/// Mean squared displacement of a Helfand moment, over all bodies: that of the shear stress, or of
/// the energy.
///
/// Samples must be one spacing apart. Momentum must be conserved along both axes: a system with
/// fixed bodies has no viscosity of its own. The axes of a box that is not square, or of a crystal,
/// are not equivalent, and the mean over both shears then depends on them.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::HelfandMoment;
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100")?;
/// let mut simulation = Simulation::new(&scene)?;
/// simulation.run_until(3.0)?;
/// let mut moment = HelfandMoment::new(0.1, 1.0)?;
/// moment.start(&simulation.view());
/// moment.sample(&simulation.view());
/// for sample in 1..=200 {
///     simulation.observe_until(3.0 + 0.1 * f64::from(sample), &mut moment)?;
///     moment.sample(&simulation.view());
/// }
/// let viscosity = moment.points().last().expect("there are lags").viscosity(1.0, 1.0);
/// assert!(viscosity > 5.0 && viscosity < 40.0, "{viscosity}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "shear viscosity")]
#[doc(alias = "heat conductivity")]
pub struct HelfandMoment {
    current: Current,
    clock: Clock,
    lags: Lags<DVec2, Squares>,
    flow: Option<Flow>,
    /// Of momentum: (G_xy + G_yx) / 2 and (G_xx − G_yy) / 2 so far (mass × length² / time). Of
    /// energy: both components of G_λ (mass × length³ / time²).
    moment: DVec2,
}

/// What flows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
enum Current {
    Momentum,
    Energy,
}

/// The change of G between contacts.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Flow {
    /// The time until which G is known.
    until: EpochTime,
    bounds: PeriodicBox,
    /// Velocity of the frame of the centre of mass.
    drift: DVec2,
    /// Σ m v_x v_y and Σ m (v_x² − v_y²) / 2 (mass × length² / time²), or Σ e v (mass × length³ /
    /// time³).
    rate: DVec2,
}

/// Σ (ΔG)², the mean over both components.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct Squares(f64);

/// The mean square at one lag.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct HelfandPoint {
    /// The lag t (time).
    pub lag: f64,
    /// The number of origins t₀; they are not independent of each other.
    pub origins: u64,
    /// M(t) (mass² × length⁴ / time², of energy mass² × length⁶ / time⁴).
    pub mean_square: f64,
}

impl HelfandPoint {
    /// M(t) / (2 A kT t), η for long lags (mass / time), at the temperature `kt` (mass × length² /
    /// time²) in a box of the given area (length²); NaN at lag 0.
    pub fn viscosity(&self, kt: f64, area: f64) -> f64 {
        self.mean_square / (2.0 * area * kt * self.lag)
    }

    /// M(t) / (2 A (kT)² t) of the energy, λ/k for long lags (1 / time), at the temperature `kt`
    /// (mass × length² / time²) in a box of the given area (length²); NaN at lag 0.
    pub fn heat_conductivity(&self, kt: f64, area: f64) -> f64 {
        self.mean_square / (2.0 * area * kt * kt * self.lag)
    }
}

impl HelfandMoment {
    /// M of the shear stress up to the lag `longest` (time) of samples that are `spacing` (time)
    /// apart; a `longest` below one spacing is taken as one spacing.
    ///
    /// Lags are 0, 1, 2, …, 9, 10, 20, …, 90, 100, … spacings.
    ///
    /// # Errors
    /// [`GeometryError::NotPositive`] if `spacing` or `longest` is not positive and finite.
    pub fn new(spacing: f64, longest: f64) -> Result<Self, GeometryError> {
        Self::with_current(Current::Momentum, spacing, longest)
    }

    /// M of the energy, with lags as in [`Self::new`].
    ///
    /// ```
    /// use carom_engine::{Observer, Scene, Simulation};
    /// use carom_observers::HelfandMoment;
    ///
    /// let scene = Scene::from_toml("[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100")?;
    /// let mut simulation = Simulation::new(&scene)?;
    /// simulation.run_until(3.0)?;
    /// let mut moment = HelfandMoment::of_energy(0.1, 1.0)?;
    /// moment.start(&simulation.view());
    /// moment.sample(&simulation.view());
    /// for sample in 1..=200 {
    ///     simulation.observe_until(3.0 + 0.1 * f64::from(sample), &mut moment)?;
    ///     moment.sample(&simulation.view());
    /// }
    /// let conductivity = moment.points().last().expect("there are lags").heat_conductivity(1.0, 1.0);
    /// assert!(conductivity > 20.0 && conductivity < 160.0, "{conductivity}");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`GeometryError::NotPositive`] if `spacing` or `longest` is not positive and finite.
    pub fn of_energy(spacing: f64, longest: f64) -> Result<Self, GeometryError> {
        Self::with_current(Current::Energy, spacing, longest)
    }

    fn with_current(current: Current, spacing: f64, longest: f64) -> Result<Self, GeometryError> {
        let (clock, lags) = Lags::new(spacing, longest)?;
        Ok(Self {
            current,
            clock,
            lags,
            flow: None,
            moment: DVec2::ZERO,
        })
    }

    /// M so far in ascending order of lag, from lag 0 on, where it is 0; lags without origins are
    /// omitted.
    pub fn points(&self) -> Vec<HelfandPoint> {
        let lags = self.lags.each(&self.clock).filter(|(_, sum)| sum.pairs > 0);
        let point = |(lag, sum): (f64, &LagSum<Squares>)| {
            let mean_square = sum.sums.0 / sum.pairs as f64;
            HelfandPoint {
                lag,
                origins: sum.pairs,
                mean_square,
            }
        };
        lags.map(point).collect()
    }

    /// All lags (time) in ascending order, from lag 0 on, also those without origins.
    pub fn lags(&self) -> Vec<f64> {
        self.lags.times(&self.clock)
    }

    /// [Σx, Σw] at each of the [lags](Self::lags) over all samples so far: x is the square of the
    /// displacement of G (mass² × length⁴ / time², of energy mass² × length⁶ / time⁴), and w is 1
    /// for each origin.
    pub fn sums(&self) -> Vec<[f64; 2]> {
        self.lags.terms([|sums| sums.0])
    }

    /// The number of samples that were not one spacing after the previous sample, to one part in a
    /// million.
    ///
    /// An early sample is skipped. After a late sample no lag crosses the gap; earlier averages are
    /// kept.
    pub fn uneven(&self) -> u64 {
        self.lags.uneven()
    }

    /// Integrates the flow up to a time at which it has not changed yet.
    fn advance(&mut self, time: EpochTime) {
        if let Some(flow) = &mut self.flow {
            self.moment += time.since(flow.until) * flow.rate;
            flow.until = time;
        }
    }
}

impl Observer for HelfandMoment {
    fn start(&mut self, view: &View<'_>) {
        self.advance(view.time());
        let drift = view.centre_of_mass_frame().velocity();
        let moving = view.bodies().filter(|view| view.body.is_free());
        let rates = moving.map(|body| self.current.flux(body.body, &body.motion, drift));
        let (until, bounds) = (view.time(), view.bounds());
        self.flow = Some(Flow {
            until,
            bounds,
            drift,
            rate: rates.sum(),
        });
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        self.advance(report.time);
        let Some(flow) = &mut self.flow else { return };
        for side in report.sides.iter().filter(|side| side.body.is_free()) {
            let [before, after] = [&side.before, &side.after]
                .map(|motion| self.current.flux(side.body, motion, flow.drift));
            flow.rate += after - before;
        }
        self.moment += self
            .current
            .transfer(report, report.separation(), flow.drift);
    }

    fn sample(&mut self, view: &View<'_>) {
        // Sums the flow anew, so that its rounding does not grow.
        self.start(view);
        if self.lags.is_due(&self.clock, view.time()) {
            let now = [LaggedSample {
                id: 0,
                state: self.moment,
            }];
            self.lags.take(&mut self.clock, view.time(), &now);
        }
    }
}

impl Current {
    /// What a body that moves carries along, relative to a frame of this velocity.
    fn flux(self, body: &Body, motion: &Motion, drift: DVec2) -> DVec2 {
        let velocity = motion.velocity - drift;
        match self {
            Self::Momentum => shears(velocity, velocity / body.inertia().inverse_mass),
            Self::Energy => energy(body, motion, drift) * velocity,
        }
    }

    /// What a contact carries over the distance of the two centres.
    fn transfer(self, report: &CollisionReport<'_>, separation: DVec2, drift: DVec2) -> DVec2 {
        match self {
            Self::Momentum => shears(separation, report.impulse),
            Self::Energy => {
                let gain = |side: &Side<'_>| {
                    energy(side.body, &side.after, drift) - energy(side.body, &side.before, drift)
                };
                // Half the difference: in an elastic contact both gains are opposite.
                0.5 * (gain(&report.sides[1]) - gain(&report.sides[0])) * separation
            }
        }
    }
}

/// Kinetic energy in a frame of this velocity; 0 for a fixed body (mass × length² / time²).
pub(crate) fn energy(body: &Body, motion: &Motion, drift: DVec2) -> f64 {
    let relative = Motion {
        velocity: motion.velocity - drift,
        ..*motion
    };
    kinetic_energy(&relative, body.inertia())
}

impl PairSums<DVec2> for Squares {
    fn add(&mut self, before: &DVec2, now: &DVec2) {
        self.0 += 0.5 * (*now - *before).length_squared();
    }
}

/// (a_x b_y + a_y b_x) / 2 and (a_x b_x − a_y b_y) / 2.
fn shears(a: DVec2, b: DVec2) -> DVec2 {
    0.5 * DVec2::new(a.x * b.y + a.y * b.x, a.x * b.x - a.y * b.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Estimate;
    use carom_engine::{Scene, Simulation};
    use std::f64::consts::PI;

    #[test]
    fn two_discs_on_a_diagonal_by_hand() {
        // They meet head-on, at (0.5, 0.5) and across the borders, three times: each contact makes
        // deviations from the diagonal ten times larger. The whole system drifts.
        let scene = r"
            [[molecule]]
            atoms = [{ at = [0, 0], radius = 0.1, mass = 2 }]
            at = [0.3, 0.3]
            velocity = [1.5, 1.0]
            [[molecule]]
            atoms = [{ at = [0, 0], radius = 0.1, mass = 2 }]
            at = [0.7, 0.7]
            velocity = [-0.5, -1.0]
        ";
        let mut simulation = Simulation::new(&Scene::from_toml(scene).unwrap()).unwrap();
        let mut moment = HelfandMoment::new(1.0, 1.0).unwrap();
        moment.start(&simulation.view());
        moment.sample(&simulation.view());
        simulation.observe_until(1.0, &mut moment).unwrap();
        moment.sample(&simulation.view());
        // Relative to the drift (0.5, 0) both have the velocity ±(1, 1). They approach at 2√2,
        // first over 0.4 √2 − σ, then over √2 − 2σ between contacts.
        let (sigma, speed, root) = (0.2, 8f64.sqrt(), 2f64.sqrt());
        let contacts = ((speed - (0.4 * root - sigma)) / (root - 2.0 * sigma)).floor() + 1.0;
        assert_eq!(simulation.view().counters().collisions as f64, contacts);
        // Σ m v_x v_y = 4; at each contact r = σ (1, 1) / √2 and J = 4 (1, 1).
        let expected = 4.0 + contacts * 4.0 * sigma / root;
        let point = moment.points()[1];
        assert!(
            (point.mean_square / (0.5 * expected * expected) - 1.0).abs() < 1e-11,
            "{point:?}"
        );
        assert_eq!((moment.sums().len(), moment.lags()), (2, vec![0.0, 1.0]));
        assert_eq!(moment.sums()[1], [point.mean_square, 1.0]);
        assert!((point.viscosity(2.0, 1.0) - point.mean_square / 4.0).abs() < 1e-9);
    }

    /// Three equal discs on a line exchange their velocities at contacts, as rods do: relative to
    /// the drift v/3 one moves at 2v/3 and two at −v/3, so that Σ e v = v³/9 always, and each
    /// contact of the fast one carries the energy v²/6 over one diameter.
    #[test]
    fn energy_that_is_handed_on_along_a_line_by_hand() {
        let disc = |x: f64, v: f64| {
            format!(
                "[[molecule]]\natoms = [{{ at = [0, 0], radius = 0.05, mass = 1 }}]\nat = [{x}, 0.5]\n\
                 velocity = [{v}, 0.0]\n"
            )
        };
        let scene = [disc(0.2, 3.0), disc(0.5, 0.0), disc(0.8, 0.0)].concat();
        let mut simulation = Simulation::new(&Scene::from_toml(&scene).unwrap()).unwrap();
        let mut moment = HelfandMoment::of_energy(1.0, 1.0).unwrap();
        moment.start(&simulation.view());
        moment.sample(&simulation.view());
        simulation.observe_until(1.0, &mut moment).unwrap();
        moment.sample(&simulation.view());
        let contacts = simulation.view().counters().collisions as f64;
        assert!(contacts > 8.0, "{contacts}");
        let expected = 27.0 / 9.0 + contacts * 0.1 * 9.0 / 6.0;
        let point = moment.points()[1];
        assert!(
            (point.mean_square / (0.5 * expected * expected) - 1.0).abs() < 1e-9,
            "{point:?}"
        );
    }

    /// The slope of M in a gas of 150 discs of mass 1 at this area fraction, in a box of area 1;
    /// kT; and the radius.
    fn slope(
        fraction: f64,
        moment: fn(f64, f64) -> Result<HelfandMoment, GeometryError>,
    ) -> (Estimate, f64, f64) {
        let count = 150.0;
        let radius = f64::sqrt(fraction / (count * PI));
        let scene = format!(
            "[box]\nseed = 4\n[[gas]]\nradius = {radius}\nmass = 1.0\nenergy = 1.0\ncount = {count}"
        );
        let mut simulation = Simulation::new(&Scene::from_toml(&scene).unwrap()).unwrap();
        simulation.run_until(5.0).unwrap();
        let kt = simulation.view().temperature().unwrap();
        // About 6 and 12 collisions a body: the slope between both is free of the initial rise.
        let (early, late, spacing) = (3, 6, 0.12);
        let mut moment = moment(spacing, 6.0 * spacing).unwrap();
        moment.start(&simulation.view());
        let mut blocks = Vec::new();
        let mut samples = 0;
        for _ in 0..30 {
            let before = moment.sums();
            for _ in 0..300 {
                samples += 1;
                simulation
                    .observe_until(5.0 + spacing * f64::from(samples), &mut moment)
                    .unwrap();
                moment.sample(&simulation.view());
            }
            let after = moment.sums();
            let mean =
                |lag: usize| (after[lag][0] - before[lag][0]) / (after[lag][1] - before[lag][1]);
            blocks.push((
                (mean(late) - mean(early)) / ((late - early) as f64 * spacing),
                1.0,
            ));
        }
        assert_eq!(moment.uneven(), 0);
        (Estimate::of_ratio(blocks).unwrap(), kt, radius)
    }

    fn agree(slope: Estimate, scale: f64, expected: f64) {
        let (found, error) = (slope.mean / scale, slope.standard_error / scale);
        assert!(
            (found - expected).abs() < 5.0 * error,
            "{found} {error} {expected}"
        );
        assert!(error < 0.04 * expected, "{found} {error} {expected}");
    }

    /// χ = (1 − 7φ/16)/(1 − φ)² (Henderson, Mol. Phys. 30 (1975) 971).
    fn chi(fraction: f64) -> f64 {
        (1.0 - 7.0 / 16.0 * fraction) / ((1.0 - fraction) * (1.0 - fraction))
    }

    #[test]
    fn a_gas_of_discs_has_enskogs_viscosity() {
        let fraction = 0.1;
        let (slope, kt, radius) = slope(fraction, HelfandMoment::new);
        let (chi, covered) = (chi(fraction), 2.0 * fraction);
        let dilute = 1.022 * f64::sqrt(kt / PI) / (4.0 * radius);
        let expected = dilute * (1.0 / chi + covered + 0.8729 * covered * covered * chi);
        agree(slope, 2.0 * kt, expected);
    }

    #[test]
    fn a_gas_of_discs_has_enskogs_heat_conductivity() {
        let fraction = 0.1;
        let (slope, kt, radius) = slope(fraction, HelfandMoment::of_energy);
        let (chi, covered) = (chi(fraction), 2.0 * fraction);
        let dilute = 1.029 * 2.0 * f64::sqrt(kt / PI) / (2.0 * radius);
        let expected = dilute * (1.0 / chi + 1.5 * covered + 0.8718 * covered * covered * chi);
        agree(slope, 2.0 * kt * kt, expected);
    }
}
