//! Friction: the impulses on a body, squared, whose rate is its friction coefficient.
//!
//! A body whose force fluctuates fast has the friction coefficient γ = ∫ ⟨F(0)·F(t)⟩ dt / 2kT
//! (Kirkwood, J. Chem. Phys. 14 (1946) 180, in two dimensions). Of the impulses J that do not know
//! each other this leaves γ = Σ |J|² / 4kT t (mass / time), and for the rotation Σ (r × J)² / 2kT t
//! (mass × length² / time), r from the centre to the contact. At a wall that has a temperature the
//! spin is drawn anew: r × J is then not the change of angular momentum. For a body of mass M that
//! moves, the
//! velocity autocorrelation begins exactly with the slope −γ/M of its value, whatever the density:
//! half the mean square of the changes of velocity per time.

use carom_engine::{Body, CollisionReport, Observer, View};
use glam::{DVec2, DVec3};
use serde::{Deserialize, Serialize};

use crate::{Group, open_interval::OpenInterval};

/// Sums of the impulses on the bodies of a group, moving or fixed.
///
/// The sums grow at each sample; contacts before the first `start` or sample are not counted. kT is
/// that of all bodies that move, relative to their centre of mass.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{Friction, Group};
///
/// let scene = Scene::from_toml(
///     "[[gas]]\nradius = 0.01\nmass = 2.0\ntemperature = 1.0\ncount = 200\n[run]\nuntil = 20",
/// )?;
/// let mut simulation = Simulation::new(&scene)?;
/// let mut friction = Friction::new(Group::All);
/// friction.start(&simulation.view());
/// simulation.observe_until(20.0, &mut friction)?;
/// friction.sample(&simulation.view());
/// // A disc forgets its velocity at the rate of its collisions: γ = mΓ.
/// let collisions = 2.0 * simulation.view().counters().collisions as f64 / 200.0 / 20.0;
/// let [_, coefficient, rotational, decay] = friction.sums().map(|[sum, weight]| sum / weight);
/// assert!((coefficient / (2.0 * collisions) - 1.0).abs() < 0.1);
/// assert!((decay / collisions - 1.0).abs() < 0.1);
/// assert_eq!(rotational, 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "drag")]
pub struct Friction {
    group: Group,
    interval: Option<(OpenInterval<DVec3>, Impulses)>,
    impulses: Impulses,
    /// Integrals of the weights over the time of the closed intervals.
    weights: DVec3,
}

/// Sums over contacts.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
struct Impulses {
    /// Σ |J|.
    sizes: f64,
    /// Σ |J|².
    squares: f64,
    /// Σ (r × J)².
    turning: f64,
    /// Σ |Δv|².
    changes: f64,
}

impl Impulses {
    fn add(&mut self, body: &Body, arm: DVec2, impulse: DVec2) {
        let square = impulse.length_squared();
        self.sizes += impulse.length();
        self.squares += square;
        let torque = arm.perp_dot(impulse);
        self.turning += torque * torque;
        if body.is_free() {
            let mass = body.molecule().mass();
            self.changes += square / (mass * mass);
        }
    }

    fn absorb(&mut self, later: &Self) {
        self.sizes += later.sizes;
        self.squares += later.squares;
        self.turning += later.turning;
        self.changes += later.changes;
    }
}

impl Friction {
    /// Empty sums for the bodies of this group.
    pub fn new(group: Group) -> Self {
        Self {
            group,
            interval: None,
            impulses: Impulses::default(),
            weights: DVec3::ZERO,
        }
    }

    /// A sum and a weight, whose quotient is the mean, of: |J| per body and time (mass × length /
    /// time²); the friction coefficient (mass / time); that of the rotation (mass × length² /
    /// time); the initial decay of the velocity autocorrelation (1 / time), without fixed bodies.
    pub fn sums(&self) -> [[f64; 2]; 4] {
        let Impulses {
            sizes,
            squares,
            turning,
            changes,
        } = self.impulses;
        let DVec3 {
            x: bodies,
            y: heat,
            z: speeds,
        } = self.weights;
        [
            [sizes, bodies],
            [0.25 * squares, heat],
            [0.5 * turning, heat],
            [0.5 * changes, speeds],
        ]
    }

    /// Number of bodies n, n kT, and Σ |v|² of those that move.
    fn weights_now(&self, view: &View<'_>) -> DVec3 {
        let frame = view.centre_of_mass_frame();
        let temperature = frame.thermal(view.bodies()).temperature().unwrap_or(0.0);
        let mut weights = DVec3::ZERO;
        for body in view.bodies().filter(|body| self.group.contains(body.body)) {
            let velocity = body.motion.velocity - frame.velocity();
            let square = if body.body.is_free() {
                velocity.length_squared()
            } else {
                0.0
            };
            weights += DVec3::new(1.0, temperature, square);
        }
        weights
    }
}

impl Observer for Friction {
    #[inline]
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        bodies.into_iter().any(|body| self.group.contains(body))
    }

    fn start(&mut self, view: &View<'_>) {
        let (time, now) = (view.time(), self.weights_now(view));
        if !self
            .interval
            .as_mut()
            .is_some_and(|(interval, _)| interval.proceed(time, now))
        {
            self.interval = Some((OpenInterval::new(time, now), Impulses::default()));
        }
    }

    fn pause(&mut self, view: &View<'_>) {
        let now = self.weights_now(view);
        if let Some((interval, _)) = &mut self.interval {
            interval.pause(view.time(), now);
        }
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        let Some((_, impulses)) = &mut self.interval else {
            return;
        };
        for (side, impulse) in report.sides.iter().zip([-report.impulse, report.impulse]) {
            if self.group.contains(side.body) {
                impulses.add(side.body, side.arm, impulse);
            }
        }
    }

    fn sample(&mut self, view: &View<'_>) {
        let (time, now) = (view.time(), self.weights_now(view));
        if let Some((interval, impulses)) = &self.interval {
            self.impulses.absorb(impulses);
            self.weights += interval.mean(time, now) * interval.duration(time);
        }
        self.interval = Some((OpenInterval::new(time, now), Impulses::default()));
    }
}

#[cfg(test)]
mod tests {
    use carom_engine::{Scene, Simulation};

    use super::*;

    #[test]
    fn a_contact_of_known_impulse() {
        // Two unequal discs head on: relative velocity 3, reduced mass 0.75, impulse 2 · 0.75 · 3.
        let scene = Scene::from_toml(
            "[[molecule]]\ntags = [\"light\"]\nshape = \"disc\"\natom_radius = 0.1\natom_mass = 1.0\nat = [0.2, \
             0.5]\nvelocity = [2.0, 0.0]\n[[molecule]]\ntags = [\"heavy\"]\nshape = \"disc\"\natom_radius = 0.1\n\
             atom_mass = 3.0\nat = [0.7, 0.5]\nvelocity = [-1.0, 0.0]",
        )
        .unwrap();
        let mut simulation = Simulation::new(&scene).unwrap();
        let of = |name| Friction::new(simulation.find_tag(name).unwrap().into());
        let mut both = (of("light"), of("heavy"), Friction::new(Group::All));
        both.start(&simulation.view());
        simulation.observe_until(0.12, &mut both).unwrap();
        both.sample(&simulation.view());
        let close = |found: f64, expected: f64| {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        };
        // The energy relative to the centre of mass, ½ · 0.75 · 9, has two degrees of freedom.
        let heat = 0.75 * 9.0 / 2.0;
        for (friction, bodies) in [(&both.0, 1.0), (&both.1, 1.0), (&both.2, 2.0)] {
            let [sizes, squares, turning, _] = friction.sums();
            close(sizes[0], bodies * 4.5);
            close(sizes[1], bodies * 0.12);
            close(squares[0], bodies * 4.5 * 4.5 / 4.0);
            close(squares[1], bodies * heat * 0.12);
            assert_eq!(turning[0], 0.0);
        }
        // The velocity of the centre of mass is −0.25.
        let [change, square] = both.0.sums()[3];
        close(change, 0.5 * 4.5 * 4.5);
        close(square, 2.25 * 2.25 * 0.12);
        close(both.1.sums()[3][0], 0.5 * 1.5 * 1.5);
    }
}
