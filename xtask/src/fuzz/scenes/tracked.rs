//! A body as its last report describes it.

use std::borrow::Cow;

use carom::engine::{BodyKey, BodyView, ElasticitySpec, PistonSpec, WallMotionSpec};
use carom_kinematics::EpochTime;

use super::{
    axis_motion::PistonSpring,
    kinematics::{BodyOutline, BodyPair, BodyState, Placed, along, dot, rotated},
    stops::PistonStops,
};

/// Last reported state of a body; of a wall that oscillates, that at which it began to.
#[derive(Debug, Clone)]
pub(super) struct TrackedBody {
    pub(super) outline: BodyOutline,
    pub(super) state: BodyState,
    /// Epoch of the report.
    pub(super) epoch: u64,
    pub(super) fixed: bool,
    pub(super) tags: Vec<String>,
    pub(super) mass: f64,
    /// Time of the report.
    pub(super) reported: EpochTime,
    /// The piston that the body is; `None` for most.
    pub(super) piston: Option<TrackedPiston>,
    /// Number of reflections of a piston since the report, and its lowest speed at one (length per
    /// time).
    pub(super) reflections: (f64, f64),
}

/// The contact time of the guard of stops, which have one also where contacts have none.
pub(super) fn guard_of_stops(elasticity: &ElasticitySpec) -> f64 {
    if elasticity.contact_time > 0.0 {
        elasticity.contact_time
    } else {
        ElasticitySpec::default().contact_time
    }
}

/// The properties of a piston.
#[derive(Debug, Clone, Copy)]
pub(super) struct TrackedPiston {
    /// Mass.
    pub(super) mass: f64,
    /// Constant force along its axis (mass × length / time²).
    pub(super) force: f64,
    /// Its stops.
    pub(super) stops: PistonStops,
    /// Its spring, if it has one.
    pub(super) spring: Option<PistonSpring>,
}

impl TrackedPiston {
    /// The piston of a description; its stops are those that the engine has found if it gives
    /// none, and its spring is relaxed where it begins unless another place is given.
    pub(super) fn new(spec: &PistonSpec, found: [f64; 2], elasticity: &ElasticitySpec) -> Self {
        let relaxed_at = spec.relaxed_at.or(spec.x).or(spec.y);
        Self {
            mass: spec.mass,
            force: spec.force,
            stops: PistonStops {
                axis: usize::from(spec.x.is_none()),
                ends: spec.stops.unwrap_or(found),
                elasticity: spec.stop_elasticity,
                contact_time: guard_of_stops(elasticity),
            },
            spring: PistonSpring::new(spec.spring, spec.mass, relaxed_at.unwrap_or_default()),
        }
    }

    /// Acceleration by its force and by the component of gravity along its axis, without that by
    /// its spring (length per time²).
    pub(super) fn acceleration(&self, gravity: BodyPair) -> BodyPair {
        let axis = self.stops.axis;
        let mut acceleration = [0.0; 2];
        acceleration[axis] = gravity[axis] + self.force / self.mass;
        acceleration
    }
}

/// A bond of the scene.
#[derive(Debug, Clone)]
pub struct TrackedBond {
    /// The two bodies, the one inserted earlier first.
    pub bodies: [BodyKey; 2],
    /// The points, in the frames of the bodies (length).
    pub points: [BodyPair; 2],
    /// The shortest and the longest length.
    pub bounds: [f64; 2],
    /// The elasticity.
    pub elasticity: f64,
}

/// The shell of a pair, as far as it is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum KnownShell {
    /// Within this step, and not within that before.
    Within(usize),
    /// The distance is that of a border, to rounding.
    AtBorder,
}

/// The motion that a wall is given.
#[derive(Debug, Clone, Copy)]
pub(super) struct GivenMotion<'a> {
    pub(super) motion: &'a WallMotionSpec,
    /// The middle of the wall before; `None` if it is not known (length).
    pub(super) middle: Option<BodyPair>,
}

impl TrackedBody {
    /// Returns true for a fixed body and for a piston, which do not pass each other.
    pub(super) fn is_barrier(&self) -> bool {
        self.fixed || self.piston.is_some()
    }

    /// Returns true for a wall whose motion does not follow from its place and velocity alone.
    pub(super) fn has_path(&self) -> bool {
        self.state.oscillation.is_some() || self.state.table.is_some()
    }

    /// The middle of a wall (length).
    pub(super) fn middle(&self, placed: Placed) -> BodyPair {
        let middle = self.outline.edges.first().map(|edge| edge.middle);
        along(
            placed.place,
            1.0,
            rotated(middle.unwrap_or_default(), placed.rotation),
        )
    }
}

/// Kinetic energy of a body (mass × length² / time²).
pub(super) fn energy(body: &BodyView<'_>) -> f64 {
    let (motion, inertia) = (&body.motion, body.body.inertia());
    let of = |inverse: f64, squared: f64| {
        if inverse > 0.0 {
            0.5 * squared / inverse
        } else {
            0.0
        }
    };
    let velocity = motion.velocity.to_array();
    let spin = motion.angular_velocity;
    of(inertia.inverse_mass, dot(velocity, velocity)) + of(inertia.inverse_moment, spin * spin)
}

/// The outline with which a body touches others that it sees at this factor of the distance.
pub(super) fn outline_for(body: &TrackedBody, factor: f64) -> Cow<'_, BodyOutline> {
    if factor == 1.0 {
        Cow::Borrowed(&body.outline)
    } else {
        Cow::Owned(body.outline.scaled(factor))
    }
}
