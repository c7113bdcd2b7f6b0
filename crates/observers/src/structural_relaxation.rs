//! How far bodies have moved after a lag: F_s(k, t), mean squared displacement, α₂(t), Q(t), χ₄(t).
//!
//! With the displacement Δ = x(t₀ + t) − x(t₀) of a body, averaged over bodies and origins t₀:
//!
//! * F_s(k, t) = ⟨½ (cos k Δ_x + cos k Δ_y)⟩, the self part of the intermediate scattering function
//!   with the wave vector along x and along y (Hansen & McDonald 2013, section 7.4).
//! * α₂(t) = ⟨|Δ|⁴⟩ / (2 ⟨|Δ|²⟩²) − 1, the non-Gaussian parameter in two dimensions (Rahman 1964).
//! * Q(t) = m/N, the overlap: m of the N bodies are at most the distance a from where they were at
//!   t₀. χ₄(t) = (⟨m²⟩ − ⟨m⟩²) / N, the susceptibility of dynamic heterogeneity (Lačević et al.,
//!   J. Chem. Phys. 119 (2003) 7372, without their factor V/(N kT)).
//!
//! At equilibrium and long before the first contact Δ is Gaussian with the variance kT t²/m along
//! each axis: F_s = exp(−k² kT t² / 2m), α₂ = 0 for equal masses, and Q = 1 − exp(−x) with x = m a²
//! / (2 kT t²). Independent bodies have χ₄ = Q (1 − Q); at fixed energy it is smaller by x²
//! exp(−2x) for bodies that do not turn (k T² (dQ/dT)² by their heat capacity; Lebowitz, Percus &
//! Verlet 1967).

use carom_engine::{CollisionReport, Observer, View};
use carom_geometry::{GeometryError, PeriodicBox, check_positive};
use carom_kinematics::Orientation;
use glam::DVec2;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::{
    Group,
    lags::{Clock, LagSum, LaggedSample, Lags, PairSums},
    moving_frame::MovingFrame,
};

/// The most waves along a side of the box. More: cos k x loses digits.
const MAX_WAVES: f64 = 1e9;

/// Self-intermediate scattering function, mean squared displacement, non-Gaussian parameter,
/// overlap and its susceptibility of the moving bodies of a group.
///
/// Positions are those of the centres of mass without periodic jumps, relative to the centre of
/// mass of all bodies along each axis on which momentum is conserved, and under shear to the flow:
/// it must then receive all contacts. After an edit at a sample call `start`, so that the frame
/// moves on with its new velocity. Samples must be one spacing apart. A body contributes while it
/// exists and belongs to the group.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{Group, RelaxationScales, StructuralRelaxation};
///
/// // A disc moves along x, ten times through the box. The bumper fixes the frame.
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
/// let scales = RelaxationScales { wave_number: 3.0, overlap: 0.6, spacing: 0.25, longest: 5.0 };
/// let bounds = simulation.view().bounds();
/// let mut relaxation = StructuralRelaxation::new(Group::All, &bounds, scales)?;
/// for sample in 0..=20 {
///     simulation.observe_until(0.25 * f64::from(sample), &mut relaxation)?;
///     relaxation.sample(&simulation.view());
/// }
/// let points = relaxation.points();
/// // It has moved by 0.5, 1, … 10.
/// assert!((points[1].self_scattering - 0.5 * (1.5f64.cos() + 1.0)).abs() < 1e-12);
/// assert_eq!((points[1].overlap, points[2].overlap), (1.0, 0.0));
/// assert_eq!((points[11].lag, points[11].mean_square_displacement), (5.0, 100.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "self-intermediate scattering function")]
#[doc(alias = "four-point susceptibility")]
#[doc(alias = "non-Gaussian parameter")]
pub struct StructuralRelaxation {
    group: Group,
    scales: RelaxationScales,
    clock: Clock,
    frame: MovingFrame,
    lags: Lags<State, Sums>,
}

/// The lengths and times of a [`StructuralRelaxation`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RelaxationScales {
    /// Wave number k of F_s (1 / length). It need not fit the box.
    pub wave_number: f64,
    /// Distance a of the overlap (length).
    pub overlap: f64,
    /// Time between samples.
    pub spacing: f64,
    /// Longest lag (time); below one spacing it is taken as one spacing.
    pub longest: f64,
}

/// The averages at one lag.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RelaxationPoint {
    /// The lag t (time).
    pub lag: f64,
    /// The number of pairs of one body at t₀ and at t₀ + t; they are not independent of each other.
    pub pairs: u64,
    /// The number of origins t₀.
    pub origins: u64,
    /// F_s(k, t), from −1 to 1; 1 at lag 0.
    pub self_scattering: f64,
    /// ⟨|Δ|²⟩ (length²).
    #[doc(alias = "MSD")]
    pub mean_square_displacement: f64,
    /// ⟨|Δ|⁴⟩ (length⁴).
    pub mean_fourth_displacement: f64,
    /// α₂(t), at least −1/2; `None` if no body has moved.
    pub non_gaussian: Option<f64>,
    /// Q(t), from 0 to 1; 1 at lag 0.
    pub overlap: f64,
    /// χ₄(t), at least 0 to rounding; 0 at lag 0. The variance is that among the origins, so that
    /// it is too small where the run is short against its correlation time. Bodies that join or
    /// leave the group during the run add to it.
    pub susceptibility: f64,
}

/// A scale of a [`StructuralRelaxation`] that is out of range.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ScalesError {
    /// A length or time is not positive and finite.
    #[error(transparent)]
    NotPositive(#[from] GeometryError),
    /// The wave is so short that its phase in the box has no digits.
    #[error("the wave number k must be at most {most} in this box, but is {wave_number}")]
    TooShort {
        /// The given k (1 / length).
        wave_number: f64,
        /// The largest k (1 / length).
        most: f64,
    },
}

/// One body at one time, relative to the frame of the centre of mass.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct State {
    place: DVec2,
    /// (cos k x, sin k x), and of y: cos k Δ is their scalar product at two times.
    waves: [DVec2; 2],
}

/// Sums over the pairs of one lag. Numbers of bodies are exact up to 2⁵³.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct Sums {
    /// a².
    reach: f64,
    /// Σ ½ (cos k Δ_x + cos k Δ_y).
    waves: f64,
    squares: f64,
    fourths: f64,
    origins: f64,
    /// m of the present origin.
    near: f64,
    /// Σ m and Σ m² over the origins.
    overlaps: [f64; 2],
}

impl PairSums<State> for Sums {
    #[inline]
    fn add(&mut self, before: &State, now: &State) {
        let [x, y] = [0, 1].map(|axis| before.waves[axis].dot(now.waves[axis]));
        self.waves += 0.5 * (x + y);
        let square = (now.place - before.place).length_squared();
        self.squares += square;
        self.fourths += square * square;
        self.near += f64::from(square <= self.reach);
    }

    fn end_origin(&mut self) {
        self.origins += 1.0;
        self.overlaps[0] += self.near;
        self.overlaps[1] += self.near * self.near;
        self.near = 0.0;
    }
}

impl StructuralRelaxation {
    /// Averages up to the lag `longest` of samples that are `spacing` apart.
    ///
    /// Lags are 0, 1, 2, …, 9, 10, 20, …, 90, 100, … spacings.
    ///
    /// # Errors
    /// [`ScalesError`] if one of the scales is not positive and finite, or more than 10⁹ waves lie
    /// along a side of the box.
    pub fn new(
        group: Group,
        bounds: &PeriodicBox,
        scales: RelaxationScales,
    ) -> Result<Self, ScalesError> {
        let wave_number = check_positive("the wave number k", scales.wave_number)?;
        let overlap = check_positive("the distance of the overlap", scales.overlap)?;
        let most = std::f64::consts::TAU * MAX_WAVES / bounds.sides().max_element();
        if wave_number > most {
            return Err(ScalesError::TooShort { wave_number, most });
        }
        let empty = Sums {
            reach: overlap * overlap,
            ..Sums::default()
        };
        let (clock, lags) = Lags::with_sums(scales.spacing, scales.longest, &empty)?;
        Ok(Self {
            group,
            scales,
            clock,
            frame: MovingFrame::default(),
            lags,
        })
    }

    /// The wave number, the distance of the overlap, and the times given to the constructor.
    pub fn scales(&self) -> &RelaxationScales {
        &self.scales
    }

    /// The averages so far in ascending order of lag, from lag 0 on; lags without pairs are
    /// omitted.
    pub fn points(&self) -> Vec<RelaxationPoint> {
        let lags = self.lags.each(&self.clock).filter(|(_, sum)| sum.pairs > 0);
        lags.map(|(lag, sum)| point(lag, sum)).collect()
    }

    /// All lags (time) in ascending order, from lag 0 on, also those without pairs.
    pub fn lags(&self) -> Vec<f64> {
        self.lags.times(&self.clock)
    }

    /// [Σx, Σw] over all samples so far, w the number of pairs: F_s at each of the
    /// [lags](Self::lags), then ⟨|Δ|²⟩ at each (length²), then ⟨|Δ|⁴⟩ (length⁴), then Q, then
    /// ⟨m²⟩/N.
    pub fn sums(&self) -> Vec<[f64; 2]> {
        self.lags.terms([
            |sums| sums.waves,
            |sums| sums.squares,
            |sums| sums.fourths,
            |sums| sums.overlaps[0],
            |sums| sums.overlaps[1],
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

impl Observer for StructuralRelaxation {
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
        let turns_per_length = self.scales.wave_number / std::f64::consts::TAU;
        let now: Vec<LaggedSample<State>> = self
            .frame
            .places(view, self.group)
            .map(|(body, place)| {
                let waves = (place * turns_per_length)
                    .to_array()
                    .map(|turns| Orientation::from_turns(turns).cos_sin());
                LaggedSample {
                    id: body.body.id(),
                    state: State { place, waves },
                }
            })
            .collect();
        self.lags.take(&mut self.clock, view.time(), &now);
    }
}

fn point(lag: f64, sum: &LagSum<Sums>) -> RelaxationPoint {
    let (sums, pairs) = (&sum.sums, sum.pairs as f64);
    let [first, second] = sums.overlaps;
    let square = sums.squares / pairs;
    let fourth = sums.fourths / pairs;
    RelaxationPoint {
        lag,
        pairs: sum.pairs,
        origins: sums.origins as u64,
        self_scattering: sums.waves / pairs,
        mean_square_displacement: square,
        mean_fourth_displacement: fourth,
        non_gaussian: (square > 0.0).then(|| 0.5 * fourth / (square * square) - 1.0),
        overlap: first / pairs,
        // (⟨m²⟩ − ⟨m⟩²) / N with N = pairs / origins.
        susceptibility: (second - first * first / sums.origins) / pairs,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_engine::{Scene, Simulation};

    const GAS: &str = "[box]\nsides = [1.0, 1.3]\nseed = 8\n[[gas]]\nradius = 0.03\nmass = 1.0\nenergy = 1.0\n\
                       count = 60\ntags = [\"gas\"]\n";

    fn scales(spacing: f64, longest: f64) -> RelaxationScales {
        RelaxationScales {
            wave_number: 20.0,
            overlap: 0.05,
            spacing,
            longest,
        }
    }

    /// The places of the moving bodies at each sample, in the frame of the centre of mass.
    fn frames(scene: &str, samples: u32, relaxation: &mut StructuralRelaxation) -> Vec<Vec<DVec2>> {
        let mut simulation = Simulation::new(&Scene::from_toml(scene).unwrap()).unwrap();
        let drift = simulation.view().centre_of_mass_frame().velocity();
        let spacing = relaxation.scales.spacing;
        (0..samples)
            .map(|sample| {
                let time = spacing * f64::from(sample);
                simulation.observe_until(time, relaxation).unwrap();
                let view = simulation.view();
                relaxation.sample(&view);
                let moving = view.bodies().filter(|body| body.body.is_free());
                moving
                    .map(|body| body.unwrapped(&view.bounds()) - time * drift)
                    .collect()
            })
            .collect()
    }

    /// All averages from the stored places, with cosines of displacements and sums over all pairs
    /// of frames that the lags use: origins at multiples of the stride of the level.
    #[test]
    fn averages_are_those_of_stored_frames() {
        let bounds = PeriodicBox::new(DVec2::new(1.0, 1.3)).unwrap();
        let mut relaxation =
            StructuralRelaxation::new(Group::All, &bounds, scales(0.01, 1.2)).unwrap();
        let frames = frames(GAS, 261, &mut relaxation);
        let points = relaxation.points();
        assert_eq!(points.len(), 1 + 9 + 9 + 1);
        assert!(
            points
                .iter()
                .any(|point| (0.2..0.8).contains(&point.overlap))
        );
        for point in &points {
            let lag = (point.lag / 0.01).round() as usize;
            let stride = 10_usize.pow(lag.max(1).ilog10());
            let origins: Vec<usize> = (0..frames.len() - lag).step_by(stride).collect();
            let count = (origins.len() * 60) as f64;
            let [mut waves, mut squares, mut fourths] = [0.0; 3];
            let mut overlaps = Vec::new();
            for &origin in &origins {
                let mut near = 0.0;
                for (before, now) in frames[origin].iter().zip(&frames[origin + lag]) {
                    let moved = *now - *before;
                    waves += 0.5 * ((20.0 * moved.x).cos() + (20.0 * moved.y).cos());
                    squares += moved.length_squared();
                    fourths += moved.length_squared().powi(2);
                    near += f64::from(moved.length() <= 0.05);
                }
                overlaps.push(near / 60.0);
            }
            let mean = overlaps.iter().sum::<f64>() / overlaps.len() as f64;
            let variance =
                overlaps.iter().map(|q| (q - mean).powi(2)).sum::<f64>() / overlaps.len() as f64;
            let near = |found: f64, expected: f64| {
                let error = (found - expected).abs();
                assert!(
                    error < 1e-12 * expected.abs().max(1.0),
                    "{found} {expected} {point:?}"
                );
            };
            assert_eq!(
                (point.pairs, point.origins),
                (count as u64, origins.len() as u64)
            );
            near(point.self_scattering, waves / count);
            near(point.mean_square_displacement, squares / count);
            near(point.mean_fourth_displacement, fourths / count);
            near(point.overlap, mean);
            near(point.susceptibility, 60.0 * variance);
            if lag > 0 {
                let expected = 0.5 * fourths * count / (squares * squares) - 1.0;
                near(point.non_gaussian.unwrap(), expected);
            }
        }
        let sums = relaxation.sums();
        assert_eq!(sums.len(), 5 * relaxation.lags().len());
        assert_eq!(relaxation.uneven(), 0);
    }

    /// Bodies that pass through each other stay Gaussian: F_s, α₂, Q and χ₄ at all times, up to the
    /// correlations of order 1/N by the conserved energy and momentum.
    #[test]
    fn a_transparent_gas_is_gaussian() {
        let count = 20_000.0;
        let scene = format!(
            "[box]\nsides = [9.0, 9.0]\nseed = 3\n[[transparent]]\nbetween = [\"gas\"]\n[[gas]]\nradius = 0.001\n\
             mass = 2.0\ntemperature = 3.0\nvelocities = \"maxwell\"\ncount = {count}\ntags = [\"gas\"]\n"
        );
        let simulation = Simulation::new(&Scene::from_toml(&scene).unwrap()).unwrap();
        let variance = simulation.view().temperature().unwrap() / 2.0;
        let bounds = simulation.view().bounds();
        let given = RelaxationScales {
            wave_number: 5.0,
            overlap: 0.2,
            ..scales(0.04, 0.36)
        };
        let mut relaxation = StructuralRelaxation::new(Group::All, &bounds, given).unwrap();
        frames(&scene, 10, &mut relaxation);
        // Five standard errors of the mean of so many independent bodies.
        let bound = 5.0 / f64::sqrt(count);
        for point in &relaxation.points()[1..] {
            let square = variance * point.lag * point.lag;
            let scattering = f64::exp(-0.5 * 25.0 * square);
            assert!(
                (point.self_scattering - scattering).abs() < 0.5 * bound,
                "{point:?}"
            );
            assert!(point.non_gaussian.unwrap().abs() < 3.0 * bound, "{point:?}");
            let overlap = 1.0 - f64::exp(-0.5 * 0.04 / square);
            assert!((point.overlap - overlap).abs() < 0.5 * bound, "{point:?}");
        }
        let last = relaxation.points().pop().unwrap();
        assert!(last.self_scattering < 0.1 && last.overlap < 0.2, "{last:?}");
    }

    #[test]
    fn planted_steps_have_a_known_susceptibility() {
        // One disc moves by more than a in an interval, the other rests: m = 1 of 2 at all lags.
        let disc = |y: f64, speed: f64| {
            format!(
                "[[molecule]]\natoms = [{{ at = [0, 0], radius = 0.01, mass = 1 }}]\nat = [0.1, {y}]\n\
                 velocity = [{speed}, 0.0]\n"
            )
        };
        let scene = format!(
            "{}{}[[bumper]]\nradius = 0.01\nat = [0.5, 0.5]",
            disc(0.2, 1.0),
            disc(0.8, 0.0)
        );
        let bounds = PeriodicBox::new(DVec2::ONE).unwrap();
        let mut relaxation =
            StructuralRelaxation::new(Group::All, &bounds, scales(0.1, 1.0)).unwrap();
        frames(&scene, 30, &mut relaxation);
        for point in &relaxation.points()[1..] {
            assert_eq!((point.overlap, point.susceptibility), (0.5, 0.0));
            // ⟨|Δ|²⟩ = s²/2 and ⟨|Δ|⁴⟩ = s⁴/2: α₂ = 0.
            assert!(point.non_gaussian.unwrap().abs() < 1e-12);
            let expected = 0.25 * (3.0 + f64::cos(20.0 * point.lag));
            assert!((point.self_scattering - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn scales_out_of_range_are_refused_with_their_values() {
        let bounds = PeriodicBox::new(DVec2::new(1.0, 2.0)).unwrap();
        let error = |change: fn(&mut RelaxationScales)| {
            let mut given = scales(0.1, 1.0);
            change(&mut given);
            StructuralRelaxation::new(Group::All, &bounds, given)
                .err()
                .map_or_else(String::new, |error| error.to_string())
        };
        assert_eq!(error(|_| {}), "");
        assert!(error(|given| given.wave_number = 1e11).contains("but is 100000000000"));
        for refused in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(
                StructuralRelaxation::new(
                    Group::All,
                    &bounds,
                    RelaxationScales {
                        overlap: refused,
                        ..scales(0.1, 1.0)
                    }
                )
                .is_err()
            );
        }
        assert!(!error(|given| given.wave_number = f64::NAN).is_empty());
        assert!(!error(|given| given.spacing = 0.0).is_empty());
        assert!(!error(|given| given.longest = -1.0).is_empty());
    }
}
