//! How far the flow of a sheared box has carried each body.
//!
//! Under shear by moving images (Lees and Edwards) the stationary flow is γ (y − Ly/2) along x. A
//! body without periodic jumps has the displacement relative to the flow, also called
//! *non-affine*,
//!
//! Δx = x(t) − x(s) − γ ∫ₛᵗ (y(t') − Ly/2) dt',  Δy = y(t) − y(s),
//!
//! which is the integral of its velocity relative to the flow. Between two contacts the path is
//! straight, so that ∫ y dt' over a flight of the duration τ is y τ + ½ v_y τ²: from the contacts
//! the integral is exact to rounding. Passages through the seam change neither y without jumps nor
//! v_y.

use carom_engine::{CollisionReport, View};
use carom_kinematics::{EpochTime, Motion};
use serde::{Deserialize, Serialize};

/// The flow of a sheared box, and how far it has carried each moving body since the shear began or
/// the body was added.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct FlowDisplacement {
    /// Shear rate γ (1 / time); 0 after the end of a shear.
    rate: f64,
    /// Place along y at which the flow is 0 (length).
    middle: f64,
    /// In ascending order of number.
    bodies: Vec<CarriedBody>,
}

/// A body on a straight path along y.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct CarriedBody {
    id: u64,
    /// The time of `y`.
    since: EpochTime,
    /// Place along y without periodic jumps (length).
    y: f64,
    /// Velocity along y (length / time).
    velocity: f64,
    /// γ ∫ (y − Ly/2) dt up to `since` (length).
    carried: f64,
}

impl CarriedBody {
    /// Moves on along the straight path.
    fn advance(&mut self, time: EpochTime, rate: f64, middle: f64) {
        let duration = time.since(self.since);
        let mean = (self.y - middle) + 0.5 * duration * self.velocity;
        self.carried += rate * duration * mean;
        self.y += duration * self.velocity;
        self.since = time;
    }
}

impl FlowDisplacement {
    /// Whether the flow carries bodies, so that [`Self::collide`] must receive their contacts.
    pub(crate) fn is_flowing(&self) -> bool {
        self.rate != 0.0
    }

    /// The flow at a place of the box along y (length / time).
    pub(crate) fn velocity_at(&self, y: f64) -> f64 {
        self.rate * (y - self.middle)
    }

    /// The displacement within a duration of what moves with this velocity relative to the flow,
    /// beyond velocity × duration (length): along y it gets into a flow of another velocity.
    pub(crate) fn change_by_drift(&self, velocity_along_y: f64, duration: f64) -> f64 {
        -0.5 * self.rate * velocity_along_y * duration * duration
    }

    /// Advances all bodies to the time of the view, with the rate that was in force until now, and
    /// takes over the places, velocities and rate of the view.
    pub(crate) fn follow(&mut self, view: &View<'_>) {
        let bounds = view.bounds();
        let before = std::mem::take(&mut self.bodies);
        let mut before = before.into_iter().peekable();
        let (rate, middle) = (self.rate, self.middle);
        let moving = view.bodies().filter(|body| body.body.is_free());
        let now = moving.map(|body| {
            let id = body.body.id();
            while before.next_if(|other| other.id < id).is_some() {}
            let carried = before.next_if(|other| other.id == id).map(|mut known| {
                known.advance(view.time(), rate, middle);
                known.carried
            });
            CarriedBody {
                id,
                since: view.time(),
                y: body.unwrapped(&bounds).y,
                velocity: body.motion.velocity.y,
                carried: carried.unwrap_or(0.0),
            }
        });
        self.bodies = now.collect();
        self.rate = view.shear_rate();
        self.middle = 0.5 * bounds.sides().y;
    }

    /// Takes the velocities after a contact.
    pub(crate) fn collide(&mut self, report: &CollisionReport<'_>) {
        let (rate, middle) = (self.rate, self.middle);
        for side in &report.sides {
            if let Some(place) = self.place_of(side.body.id()) {
                let body = &mut self.bodies[place];
                body.advance(report.time, rate, middle);
                body.velocity = side.after.velocity.y;
            }
        }
    }

    /// How far the flow has carried a body up to the last view (length); 0 for a body that was not
    /// in it, or does not move.
    pub(crate) fn carried(&self, id: u64) -> f64 {
        self.place_of(id)
            .map_or(0.0, |place| self.bodies[place].carried)
    }

    /// The velocity of a motion in the box relative to the flow along x (length / time).
    pub(crate) fn relative(&self, motion: &Motion) -> f64 {
        motion.velocity.x - self.velocity_at(motion.position.y)
    }

    /// The index in `bodies` of a body.
    fn place_of(&self, id: u64) -> Option<usize> {
        // Numbers are successive unless bodies have been removed.
        let first = self.bodies.first()?.id;
        let guess = usize::try_from(id.checked_sub(first)?).ok()?;
        if self.bodies.get(guess).is_some_and(|body| body.id == id) {
            return Some(guess);
        }
        self.bodies.binary_search_by_key(&id, |body| body.id).ok()
    }
}
