//! The Lyapunov exponents: how fast neighbouring trajectories part.
//!
//! A small deviation of the state grows as exp(λ t). The growth of the largest of orthonormal
//! vectors gives λ₁, that of the area spanned by two λ₁ + λ₂, and so on (Benettin, Galgani,
//! Giorgilli and Strelcyn 1980). The vectors follow the exact derivative of the dynamics through
//! each flight and each contact (Dellago, Posch and Hoover 1996).
//!
//! In a system without losses the exponents pair, λᵢ + λ_{D+1−i} = 0 for D components, and each
//! conserved quantity makes two of them 0: six in a periodic gas of elastic discs. A contact with
//! the elasticity e shrinks the volume in the space of states by e², so that
//!
//! Σ λᵢ = ⟨Σ ln e²⟩ / t.

mod contact_map;
mod tangent_space;

use carom_engine::{Body, CollisionReport, Observer, View};
use carom_kinematics::EpochTime;
use glam::DVec2;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use contact_map::ContactMap;
use tangent_space::{TangentSpace, dimension};

/// The largest Lyapunov exponents of a system, up to all of them.
///
/// Free bodies are discs or molecules of discs and edges that may turn; fixed bodies, walls and
/// containers may stand among them, and gravity may act. The contacts are those of the rule of
/// restitution; rough ones, kicks, and contacts at several points at once are
/// [counted](Self::approximated). An edit of the motions leaves the vectors as they are; an edit of
/// the bodies begins anew, also with the sums.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::LyapunovSpectrum;
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.05\nmass = 1.0\nenergy = 1.0\ncount = 8")?;
/// let mut simulation = Simulation::new(&scene)?;
/// let mut spectrum = LyapunovSpectrum::new(&simulation.view(), 32, 0.0)?;
/// spectrum.start(&simulation.view());
/// simulation.observe_until(20.0, &mut spectrum)?;
/// spectrum.sample(&simulation.view());
/// let exponents: Vec<f64> = spectrum.sums().iter().map(|[x, t]| x / t).collect();
/// assert!(exponents[0] > 1.0);
/// assert!((exponents[0] + exponents[31]).abs() < 1e-8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "tangent vectors")]
#[doc(alias = "chaos")]
#[doc(alias = "Kolmogorov-Sinai entropy")]
pub struct LyapunovSpectrum {
    /// Number of exponents asked for.
    wanted: usize,
    dimension: usize,
    transient: f64,
    space: TangentSpace,
    gravity: DVec2,
    /// When the present vectors began; `None` before the start.
    begun: Option<EpochTime>,
    sampled: EpochTime,
    /// Σ ln of the growth of each vector in the measured intervals.
    growth: Vec<f64>,
    /// Σ ln e² of the contacts since the last sample, and in the measured intervals.
    contraction: [f64; 2],
    duration: f64,
    /// Contacts whose derivative was that of another rule.
    approximated: u64,
}

/// Largest number of components of all vectors together: 2 GB, and as much again while the vectors
/// are made orthonormal.
const MAX_NUMBERS: usize = 1 << 28;

/// Why a system has no Lyapunov exponents here.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum LyapunovError {
    /// No body moves freely.
    #[error("no body moves freely, so that no state can deviate")]
    NoFreeBody,
    /// The vectors would take more than 2 GB: take fewer exponents.
    #[error(
        "{exponents} exponents of {dimension} coordinates and velocities take more than 2 GB; ask for at most {most}"
    )]
    TooMany {
        /// Number of exponents asked for.
        exponents: usize,
        /// Number of coordinates and velocities.
        dimension: usize,
        /// Most that fit.
        most: usize,
    },
    /// The derivative of this is not known.
    #[error(
        "the derivative of the motion is known for discs, straight edges, arcs, and walls that stand, move uniformly or \
         turn, not for {0}"
    )]
    Unsupported(&'static str),
}

impl LyapunovSpectrum {
    /// The `exponents` largest of the system in this view, at most as many as it has coordinates
    /// and velocities. In the time `transient` after the start the vectors turn to their
    /// directions, and nothing is measured.
    ///
    /// # Errors
    /// [`LyapunovError`]
    pub fn new(view: &View<'_>, exponents: usize, transient: f64) -> Result<Self, LyapunovError> {
        let dimension = dimension(view);
        let count = exponents.min(dimension);
        if count == 0 {
            return Err(LyapunovError::NoFreeBody);
        }
        if let Some(what) = unsupported(view) {
            return Err(LyapunovError::Unsupported(what));
        }
        let most = MAX_NUMBERS / dimension;
        if count > most {
            return Err(LyapunovError::TooMany {
                exponents: count,
                dimension,
                most,
            });
        }
        Ok(Self {
            wanted: exponents,
            dimension,
            transient,
            space: TangentSpace::new(view, count),
            gravity: view.gravity(),
            begun: None,
            sampled: view.time(),
            growth: vec![0.0; count],
            contraction: [0.0; 2],
            duration: 0.0,
            approximated: 0,
        })
    }

    /// The number of all exponents of the system in this view, as [`Self::dimension`].
    pub fn dimension_of(view: &View<'_>) -> usize {
        dimension(view)
    }

    /// The number of all exponents, which is that of the coordinates and velocities of all free
    /// bodies: four for a body, six for one that turns.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// [Σx, Σw] of each exponent up to the last sample, the largest first: x is ln of the growth,
    /// w is the time.
    pub fn sums(&self) -> Vec<[f64; 2]> {
        let of = |growth: &f64| [*growth, self.duration];
        self.growth.iter().map(of).collect()
    }

    /// How often a vector was rounding alone, after a contact that stretched the deviations by more
    /// than 10⁶, or one with elasticity 0. If it happened, the smallest exponents are smaller than
    /// they seem.
    pub fn replaced(&self) -> u64 {
        self.space.replaced()
    }

    /// Contacts so far that counted as smooth ones at one point, although they were rough, gave a
    /// kick, or touched at several points at once: of these no derivative is known here.
    pub fn approximated(&self) -> u64 {
        self.approximated
    }

    /// Σ ln e² of the contacts in the measured time: that of the volume in the space of states.
    pub fn contraction(&self) -> f64 {
        self.contraction[1]
    }
}

/// What in a system has no derivative here; `None` if all has.
fn unsupported(view: &View<'_>) -> Option<&'static str> {
    if view.drag() != 0.0 {
        return Some("a drag");
    }
    if view.has_wells() {
        return Some("wells");
    }
    view.bodies().find_map(|view_of| {
        let body = view_of.body;
        if body.is_piston() {
            Some("pistons")
        } else if !body.molecule().ellipses().is_empty() {
            Some("ellipses")
        } else if body.wall_temperature().is_some() {
            Some("walls with a temperature")
        } else if view.oscillation(body.key()).is_some() {
            Some("walls that oscillate")
        } else {
            None
        }
    })
}

impl Observer for LyapunovSpectrum {
    #[inline]
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        bodies.into_iter().any(Body::is_free)
    }

    fn start(&mut self, view: &View<'_>) {
        self.gravity = view.gravity();
        if self.begun.is_some() && self.space.matches(view) {
            return;
        }
        self.dimension = dimension(view);
        self.space = TangentSpace::new(view, self.wanted);
        self.growth = vec![0.0; self.wanted.min(self.dimension)];
        self.begun = Some(view.time());
        self.sampled = view.time();
        self.contraction = [0.0; 2];
        self.duration = 0.0;
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        if self.begun.is_none() || report.impulse == DVec2::ZERO {
            return;
        }
        if report.points > 1 || !report.elasticity.is_smooth() {
            self.approximated += 1;
        }
        if let Some(map) = ContactMap::new(report, self.gravity) {
            let bodies = report.sides.map(|side| side.body.id());
            self.space.apply_contact(bodies, report.time, &map);
            let elasticity = report.elasticity.coefficient().max(f64::MIN_POSITIVE);
            self.contraction[0] += 2.0 * elasticity.ln();
        }
    }

    fn sample(&mut self, view: &View<'_>) {
        let Some(begun) = self.begun else {
            return;
        };
        let time = view.time();
        let growth = self.space.take_growth(time);
        let contraction = std::mem::take(&mut self.contraction[0]);
        let duration = time.since(std::mem::replace(&mut self.sampled, time));
        // The interval counts if all of it lies behind the transient.
        if time.since(begun) - duration < self.transient {
            return;
        }
        for (sum, term) in self.growth.iter_mut().zip(growth) {
            *sum += term;
        }
        self.contraction[1] += contraction;
        self.duration += duration;
    }
}

#[cfg(test)]
mod tests;
