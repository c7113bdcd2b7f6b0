//! Diffusion along and across the axis of a body, in its own frame.
//!
//! The displacement of a body in each interval between samples is resolved along its axis x′ at the
//! start of the interval and across it, and the components are summed: (X, Y). Then ⟨(X(t₀ + t) −
//! X(t₀))²⟩ (length²) grows as 2 D∥ t at long lags, and that of Y as 2 D⊥ t, however far the body
//! has turned (Y. Han et al., Science 314 (2006) 626). Likewise D∥ = ∫₀^∞ ⟨v∥(t) v∥(0)⟩ dt with the
//! components of the velocity in the body's frame of each time. Intervals must be short against the
//! time in which a body turns. In the frame of the box both mix: D = (D∥ + D⊥)/2 at long lags.

use carom_engine::{CollisionReport, Observer, View};
use carom_geometry::GeometryError;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{
    Group,
    body_frame::axis_of,
    lags::{Clock, LaggedSample, Lags, PairSums},
    moving_frame::MovingFrame,
};

/// Mean squared displacements and velocity autocorrelations along and across the axes of bodies.
///
/// Positions and velocities are relative to the centre of mass along each axis of the box on which
/// momentum is conserved, and under shear to the flow: it must then receive all contacts. Fixed
/// bodies do not count, nor those without an axis: round bodies that nothing drives. After an edit
/// at a sample call `start`, so that the frame moves on with its new velocity. Samples must be one
/// spacing apart.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{BodyFrameDiffusion, Group};
///
/// // A rod that moves along x at an angle of 30° with its axis. The bumper fixes the frame.
/// let scene = Scene::from_toml(r#"
///     [[molecule]]
///     shape = "rod:3"
///     atom_radius = 0.01
///     atom_mass = 1.0
///     at = [0.2, 0.2]
///     orientation = 0.5235987755982988
///     velocity = [0.2, 0.0]
///     [[bumper]]
///     radius = 0.05
///     at = [0.5, 0.8]
/// "#)?;
/// let mut simulation = Simulation::new(&scene)?;
/// let mut diffusion = BodyFrameDiffusion::new(Group::All, 0.5, 5.0)?;
/// for sample in 0..=10 {
///     simulation.observe_until(0.5 * f64::from(sample), &mut diffusion)?;
///     diffusion.sample(&simulation.view());
/// }
/// // (0.2 · 5 · cos 30°)² and (0.2 · 5 · sin 30°)².
/// let last = diffusion.points().pop().expect("lags");
/// assert!((last.along - 0.75).abs() < 1e-12 && (last.across - 0.25).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "anisotropic diffusion")]
pub struct BodyFrameDiffusion {
    group: Group,
    clock: Clock,
    frame: MovingFrame,
    tracks: Vec<Track>,
    lags: Lags<State, Sums>,
}

/// The averages at one lag.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct BodyFramePoint {
    /// The lag t (time).
    pub lag: f64,
    /// The number of pairs of one body at t₀ and at t₀ + t; they are not independent of each other.
    pub pairs: u64,
    /// ⟨(X(t₀ + t) − X(t₀))²⟩ along the axis (length²).
    pub along: f64,
    /// ⟨(Y(t₀ + t) − Y(t₀))²⟩ across the axis (length²).
    pub across: f64,
    /// ⟨v∥(t₀ + t) v∥(t₀)⟩ (length² / time²).
    pub velocity_along: f64,
    /// ⟨v⊥(t₀ + t) v⊥(t₀)⟩ (length² / time²).
    pub velocity_across: f64,
}

/// A body at the last sample, with the sum of its displacements in its own frame.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Track {
    id: u64,
    place: DVec2,
    axis: DVec2,
    sum: DVec2,
}

/// One body at one time, in its own frame.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct State {
    sum: DVec2,
    velocity: DVec2,
}

#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct Sums {
    squares: DVec2,
    products: DVec2,
}

impl PairSums<State> for Sums {
    fn add(&mut self, before: &State, now: &State) {
        let moved = now.sum - before.sum;
        self.squares += moved * moved;
        self.products += now.velocity * before.velocity;
    }
}

/// The components of a vector along an axis and a quarter turn further.
fn resolved(vector: DVec2, axis: DVec2) -> DVec2 {
    DVec2::new(axis.dot(vector), axis.perp_dot(vector))
}

impl BodyFrameDiffusion {
    /// Displacements up to the lag `longest` (time) of samples that are `spacing` (time) apart; a
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
            tracks: Vec::new(),
            lags,
        })
    }

    /// The averages so far in ascending order of lag, from lag 0 on; lags without pairs are
    /// omitted.
    pub fn points(&self) -> Vec<BodyFramePoint> {
        let lags = self.lags.each(&self.clock).filter(|(_, sum)| sum.pairs > 0);
        lags.map(|(lag, sum)| {
            let [squares, products] =
                [sum.sums.squares, sum.sums.products].map(|total| total / sum.pairs as f64);
            BodyFramePoint {
                lag,
                pairs: sum.pairs,
                along: squares.x,
                across: squares.y,
                velocity_along: products.x,
                velocity_across: products.y,
            }
        })
        .collect()
    }

    /// All lags (time) in ascending order, from lag 0 on, also those without pairs.
    pub fn lags(&self) -> Vec<f64> {
        self.lags.times(&self.clock)
    }

    /// [Σx, Σw] over all samples so far, w the number of pairs: the squared displacement along the
    /// axis at each of the [lags](Self::lags), then that across it, then the products of the
    /// velocities along it, and across it.
    pub fn sums(&self) -> Vec<[f64; 2]> {
        self.lags.terms([
            |sums| sums.squares.x,
            |sums| sums.squares.y,
            |sums| sums.products.x,
            |sums| sums.products.y,
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

impl Observer for BodyFrameDiffusion {
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
        let mut tracks = Vec::with_capacity(self.tracks.len());
        let mut now = Vec::new();
        // Both are in ascending order of number. All moving bodies are followed, because a body may
        // leave the group and come back.
        let mut before = self.tracks.iter().peekable();
        for body in view.bodies().filter(|body| body.body.is_free()) {
            let Some(axis) = axis_of(view, &body) else {
                continue;
            };
            let id = body.body.id();
            let place = self.frame.place(&body, &view.bounds());
            while before.next_if(|track| track.id < id).is_some() {}
            let earlier = before.next_if(|track| track.id == id);
            let sum = earlier.map_or(DVec2::ZERO, |track| {
                track.sum + resolved(place - track.place, track.axis)
            });
            tracks.push(Track {
                id,
                place,
                axis,
                sum,
            });
            if self.group.contains(body.body) {
                let velocity = resolved(self.frame.relative(&body.motion), axis);
                let state = State { sum, velocity };
                now.push(LaggedSample { id, state });
            }
        }
        self.tracks = tracks;
        self.lags.take(&mut self.clock, view.time(), &now);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_engine::{Scene, Simulation};

    /// A rod in a box with a fixed disc, which fixes the frame.
    fn observe(rod: &str, samples: u32, spacing: f64) -> BodyFrameDiffusion {
        let scene = format!(
            "[box]\nsides = [10.0, 10.0]\n[[molecule]]\nshape = \"rod:3\"\natom_radius = 0.01\n\
             atom_mass = 1.0\nat = [1.0, 1.0]\n{rod}\n[[bumper]]\nradius = 0.05\nat = [9.0, 9.0]"
        );
        let mut simulation = Simulation::new(&Scene::from_toml(&scene).unwrap()).unwrap();
        let mut diffusion = BodyFrameDiffusion::new(Group::All, spacing, 1e3).unwrap();
        for sample in 0..=samples {
            simulation
                .observe_until(spacing * f64::from(sample), &mut diffusion)
                .unwrap();
            diffusion.sample(&simulation.view());
        }
        diffusion
    }

    #[test]
    fn a_rod_that_turns_has_the_sum_of_its_steps_in_its_own_frame() {
        // After step k the axis has turned by k ω Δt: the steps form a polygon in its frame.
        let (speed, turning, spacing) = (0.3, 0.5, 0.01);
        let diffusion = observe(
            "velocity = [0.3, 0.0]\nangular_velocity = 0.5",
            400,
            spacing,
        );
        let points = diffusion.points();
        assert_eq!(points[0].pairs, 401);
        let last = points.last().unwrap();
        assert_eq!((last.lag, last.pairs), (4.0, 1));
        let steps = (0..400).map(|k| {
            let angle = turning * spacing * f64::from(k);
            speed * spacing * DVec2::new(angle.cos(), -angle.sin())
        });
        let expected: DVec2 = steps.sum();
        assert!((last.along - expected.x.powi(2)).abs() < 1e-12, "{last:?}");
        assert!((last.across - expected.y.powi(2)).abs() < 1e-12, "{last:?}");
        // v∥ = v cos ωt.
        let product = speed * speed * (turning * 4.0_f64).cos();
        assert!((last.velocity_along - product).abs() < 1e-12, "{last:?}");
        assert!(last.velocity_across.abs() < 1e-12, "{last:?}");
        assert_eq!(diffusion.sums().len(), 4 * diffusion.lags().len());
        assert_eq!(diffusion.uneven(), 0);
    }

    #[test]
    fn discs_have_no_axis_and_a_body_across_the_border_moves_on() {
        let rod = "orientation = 1.0\nvelocity = [3.0, 0.0]";
        let last = observe(rod, 100, 0.1).points().pop().unwrap();
        let moved = 30.0 * DVec2::new(1.0_f64.cos(), -1.0_f64.sin());
        assert!((last.along - moved.x.powi(2)).abs() < 1e-9, "{last:?}");
        assert!((last.across - moved.y.powi(2)).abs() < 1e-9, "{last:?}");
        let disc = "[[gas]]\nradius = 0.1\nmass = 1.0\nenergy = 1.0\ncount = 2";
        let simulation = Simulation::new(&Scene::from_toml(disc).unwrap()).unwrap();
        let mut diffusion = BodyFrameDiffusion::new(Group::All, 1.0, 1.0).unwrap();
        diffusion.sample(&simulation.view());
        assert!(diffusion.points().is_empty());
    }

    /// Two rods that do not turn, with opposite velocities relative to a flow, each along itself at
    /// first: along x they fall behind the flow into which they rise.
    #[test]
    fn displacements_of_rods_in_a_flow_are_relative_to_it() {
        let rod = |at: [f64; 2], velocity: [f64; 2]| {
            format!(
                "[[molecule]]\nshape = \"rod:3\"\natom_radius = 0.01\natom_mass = 1.0\nat = {at:?}\n\
                 velocity = {velocity:?}\n"
            )
        };
        let rods = [rod([0.2, 0.6], [0.5, 0.25]), rod([0.7, 1.6], [-0.5, -0.25])].concat();
        let text = format!("[box]\nsides = [8.0, 2.0]\nshear_rate = 0.8\n{rods}");
        let mut simulation = Simulation::new(&Scene::from_toml(&text).unwrap()).unwrap();
        let mut diffusion = BodyFrameDiffusion::new(Group::All, 1.0, 9.0).unwrap();
        for sample in 0..=9 {
            simulation
                .observe_until(f64::from(sample), &mut diffusion)
                .unwrap();
            diffusion.sample(&simulation.view());
        }
        assert_eq!(simulation.view().counters().collisions, 0);
        let points = diffusion.points();
        let last = points.last().unwrap();
        // 0.5 t − ½ γ v t² and v t at t = 9.
        let (along, across) = (4.5 - 0.5 * 0.8 * 0.25 * 81.0, 2.25);
        assert_eq!((last.lag, last.pairs), (9.0, 2));
        assert!((last.along - along * along).abs() < 1e-10, "{last:?}");
        assert!((last.across - across * across).abs() < 1e-10, "{last:?}");
    }
}
