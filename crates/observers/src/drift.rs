//! Sums of the impulses and torques on a body, and its displacement and rotation, in its own frame:
//! whether it is driven.
//!
//! J are the impulses on the body, r the points of contact from its centre, v and ω its velocities
//! and θ its orientation. The sums are Σ R(−θ) J (mass × length / time), Σ r × J (mass × length² /
//! time), ∫ R(−θ) v dt (length) and ∫ ω dt (radians). At equilibrium the mean of each vanishes at
//! any density, for a free or locked body, since the free energy does not depend on its position
//! and orientation, and the mean of v does not depend on θ. For a body that does not turn, Σ J is
//! the change of its momentum; for a body that turns, Σ r × J is the change of its angular
//! momentum, except at walls that have a temperature: these draw the spin anew, and the body leaves
//! with a spin that is not the effect of r × J. These sums are bounded. The other sums diffuse.

use carom_engine::{Body, BodyKey, CollisionReport, Observer, View};
use carom_kinematics::{DragClock, EpochTime, Motion};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::body_frame::in_body_frame;

/// Sums of the forces on one body and of its displacement, in its frame (x′, y′).
///
/// The path is integrated from contact to contact, not from sample to sample. Contacts before the
/// first `start` or sample are not counted.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::Drift;
///
/// // A single disc moves half a box length.
/// let scene = Scene::from_toml(
///     "[[molecule]]\natoms = [{ at = [0, 0], radius = 0.05, mass = 1 }]\nat = [0.5, 0.5]\nvelocity = [2.0, 0.0]",
/// )?;
/// let mut simulation = Simulation::new(&scene)?;
/// let mut drift = Drift::new(simulation.view().bodies().next().expect("there is one").body.key());
/// drift.start(&simulation.view());
/// simulation.observe_until(0.25, &mut drift)?;
/// drift.sample(&simulation.view());
/// assert_eq!((drift.path().x, drift.path().y, drift.duration()), (0.5, 0.0, 0.25));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Drift {
    body: BodyKey,
    followed_until: Option<EpochTime>,
    duration: f64,
    impulse: DVec2,
    angular_impulse: f64,
    path: DVec2,
    turn: f64,
    samples: u64,
    velocity_squares: DVec2,
    spin_squares: f64,
}

impl Drift {
    /// Empty sums for one body.
    pub fn new(body: BodyKey) -> Self {
        Self {
            body,
            followed_until: None,
            duration: 0.0,
            impulse: DVec2::ZERO,
            angular_impulse: 0.0,
            path: DVec2::ZERO,
            turn: 0.0,
            samples: 0,
            velocity_squares: DVec2::ZERO,
            spin_squares: 0.0,
        }
    }

    /// The observed body.
    pub fn body(&self) -> BodyKey {
        self.body
    }

    /// The duration of the observation (time).
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Σ R(−θ) J (mass × length / time).
    pub fn impulse(&self) -> DVec2 {
        self.impulse
    }

    /// Σ r × J, counter-clockwise (mass × length² / time), also for a body that cannot turn.
    pub fn angular_impulse(&self) -> f64 {
        self.angular_impulse
    }

    /// ∫ R(−θ) v dt: the displacement along the body's own axes (length).
    pub fn path(&self) -> DVec2 {
        self.path
    }

    /// ∫ ω dt: the rotation, counter-clockwise (radians).
    pub fn turn(&self) -> f64 {
        self.turn
    }

    /// The number of samples of the velocities.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Sums of v_x′² and v_y′² over the samples (length² / time²).
    pub fn velocity_squares(&self) -> DVec2 {
        self.velocity_squares
    }

    /// Sum of ω² over the samples (1 / time²).
    pub fn spin_squares(&self) -> f64 {
        self.spin_squares
    }

    /// Adds the flight that ends with this motion.
    fn follow(&mut self, motion: &Motion, now: EpochTime, clock: DragClock) {
        let Some(before) = self.followed_until.replace(now) else {
            return;
        };
        let duration = now.since(before);
        // With drag, the time in which the body would have flown here at its last velocity.
        let time = -clock.reading(-duration);
        let half_turn = 0.5 * motion.angular_velocity * time;
        // ∫ R(ωs) ds over the flight is a rotation by half its angle, times the ratio of chord to
        // arc.
        let (sin, cos) = libm::sincos(half_turn);
        let shortened = if half_turn == 0.0 {
            1.0
        } else {
            sin / half_turn
        };
        let at_end = in_body_frame(motion.velocity, motion.orientation);
        self.path += DVec2::new(cos, sin).rotate(at_end) * (time * shortened);
        self.turn += 2.0 * half_turn;
        self.duration += duration;
    }
}

impl Observer for Drift {
    #[inline]
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        self.body.is_among(bodies)
    }

    fn start(&mut self, view: &View<'_>) {
        self.followed_until.get_or_insert(view.time());
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        let Some((side, impulse)) = report.side_of(self.body) else {
            return;
        };
        let clock = DragClock::new(report.drag);
        self.follow(&side.before, report.time, clock);
        self.impulse += in_body_frame(impulse, side.before.orientation);
        // The line of the impulse passes through the centre of the touched atom, so its arm gives
        // the torque.
        self.angular_impulse += side.arm.perp_dot(impulse);
    }

    fn sample(&mut self, view: &View<'_>) {
        let Some(watched) = view.body(self.body) else {
            return;
        };
        let clock = DragClock::new(view.drag());
        self.follow(&watched.motion, view.time(), clock);
        let velocity = in_body_frame(watched.motion.velocity, watched.motion.orientation);
        self.velocity_squares += velocity * velocity;
        self.spin_squares += watched.motion.angular_velocity * watched.motion.angular_velocity;
        self.samples += 1;
    }
}
