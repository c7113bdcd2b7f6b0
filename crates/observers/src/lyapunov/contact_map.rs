//! What a contact does to small deviations of the two bodies: the derivative of the collision.
//!
//! A deviation of the state moves the contact in time, by δτ = −δg/u, with the deviation δg of the
//! gap and its rate u. The deviations are carried to the displaced contact, through the derivative
//! of the collision rule there, and back to the undisturbed time:
//!
//! δr' = δr + (v − v') δτ,  δv' = δv + δ(J n)/m,  δω' = δω + δ(J l)/I,
//!
//! J = −(1 + e) u / Σ(1/m + l²/I),
//!
//! with the lever arm l of the normal n about the centre of mass (for discs Dellago, Posch and
//! Hoover 1996). δn is the deviation of the line of centres over its length, or the
//! rotation of the body whose edge is touched.

use carom_engine::{CollisionReport, Side};
use carom_kinematics::Motion;
use glam::DVec2;

/// A deviation of the state of one body.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct BodyDeviation {
    /// Of the position (length).
    pub(super) position: DVec2,
    /// Of the orientation (radians).
    pub(super) angle: f64,
    /// Of the velocity (length / time).
    pub(super) velocity: DVec2,
    /// Of the angular velocity (radians / time).
    pub(super) spin: f64,
}

/// The derivative of one collision.
#[derive(Debug, Clone, Copy)]
pub(super) struct ContactMap {
    sides: [MapSide; 2],
    normal: DVec2,
    turning: NormalTurns,
    /// Velocity of the second anchor relative to the first (length / time).
    relative: DVec2,
    /// Rate of the gap, negative (length / time).
    gap_rate: f64,
    /// −(1 + e).
    factor: f64,
    /// 1 / Σ(1/m + l²/I) (mass).
    reduced_mass: f64,
    /// Acceleration of the second body relative to the first, along the normal (length / time²).
    acceleration: f64,
}

/// One body of a contact.
#[derive(Debug, Clone, Copy)]
struct MapSide {
    /// −1 for the first body, 1 for the second: the sign of the impulse.
    sign: f64,
    before: Motion,
    after: Motion,
    inverse_mass: f64,
    inverse_moment: f64,
    /// From the centre of mass to the anchor: the centre of the touching atom or arc; on the side
    /// of a straight edge, the point of the body that is now at the other anchor (length).
    anchor: DVec2,
    /// The lever arm of the normal (length).
    lever: f64,
}

/// How the normal follows the bodies.
#[derive(Debug, Clone, Copy)]
enum NormalTurns {
    /// It lies along the line from one anchor to the other, of this length, negative if the normal
    /// points against the line: inside an arc (length).
    WithLine(f64),
    /// It turns with one body, by its index: the normal of a straight edge.
    WithBody(usize),
}

/// r turned by a right angle counterclockwise, times an angle or a rate.
fn turned(rate: f64, r: DVec2) -> DVec2 {
    rate * r.perp()
}

/// The anchors of a collision, and how its normal follows the bodies.
fn anchors(report: &CollisionReport<'_>) -> ([DVec2; 2], NormalTurns) {
    let separation = report.separation();
    let is_bent = |side: &Side<'_>| {
        let edge = side
            .edge
            .map(|edge| &side.body.molecule().edges()[edge as usize]);
        edge.map(|edge| edge.bend().is_some())
    };
    let mut anchors = report.sides.map(|side| side.arm);
    for (anchor, side) in anchors.iter_mut().zip(&report.sides) {
        if is_bent(side) == Some(true) {
            // An arc is one about the origin of its body.
            *anchor = DVec2::ZERO;
        }
    }
    let straight = report
        .sides
        .iter()
        .position(|side| is_bent(side) == Some(false));
    let turning = if let Some(edged) = straight {
        anchors[edged] = if edged == 0 {
            separation + anchors[1]
        } else {
            anchors[0] - separation
        };
        NormalTurns::WithBody(edged)
    } else {
        NormalTurns::WithLine((separation + (anchors[1] - anchors[0])).dot(report.normal))
    };
    (anchors, turning)
}

impl ContactMap {
    /// The derivative of a reported collision, with the acceleration of free bodies (length /
    /// time²). `None` where there is none: a contact without approach.
    pub(super) fn new(report: &CollisionReport<'_>, gravity: DVec2) -> Option<Self> {
        let normal = report.normal;
        let (anchors, turning) = anchors(report);
        let side = |n: usize| {
            let side = &report.sides[n];
            let inertia = side.body.inertia();
            MapSide {
                sign: [-1.0, 1.0][n],
                before: side.before,
                after: side.after,
                inverse_mass: inertia.inverse_mass,
                inverse_moment: inertia.inverse_moment,
                anchor: anchors[n],
                lever: anchors[n].perp_dot(normal),
            }
        };
        let sides = [side(0), side(1)];
        let relative = sides[1].anchor_velocity() - sides[0].anchor_velocity();
        let gap_rate = relative.dot(normal);
        let inverse: f64 = sides.iter().map(MapSide::inverse_reduced_mass).sum();
        let of_gravity = |side: &Side<'_>| {
            if side.body.is_free() {
                gravity
            } else {
                DVec2::ZERO
            }
        };
        let acceleration = of_gravity(&report.sides[1]) - of_gravity(&report.sides[0]);
        (gap_rate < 0.0).then_some(Self {
            sides,
            normal,
            turning,
            relative,
            gap_rate,
            factor: -(1.0 + report.elasticity.coefficient()),
            reduced_mass: 1.0 / inverse,
            acceleration: acceleration.dot(normal),
        })
    }

    /// The share of the relative velocity of the anchors that is along the normal, 0 to 1.
    pub(super) fn approach(&self) -> f64 {
        -self.gap_rate / self.relative.length()
    }

    /// The deviations of both bodies after the contact, from those before it.
    pub(super) fn apply(&self, before: [BodyDeviation; 2]) -> [BodyDeviation; 2] {
        let Self { sides, normal, .. } = self;
        let of_anchor = |n: usize| before[n].position + turned(before[n].angle, sides[n].anchor);
        let gap = of_anchor(1) - of_anchor(0);
        let delay = -gap.dot(*normal) / self.gap_rate;
        // At the displaced contact.
        let angles = [0, 1].map(|n| before[n].angle + sides[n].before.angular_velocity * delay);
        let (normal_change, anchor_changes) = match self.turning {
            NormalTurns::WithLine(length) => (
                (gap + delay * self.relative) / length,
                [0, 1].map(|n| turned(angles[n], sides[n].anchor)),
            ),
            NormalTurns::WithBody(edged) => {
                let other = 1 - edged;
                let place = |n: usize| before[n].position + delay * sides[n].before.velocity;
                let of_other = turned(angles[other], sides[other].anchor);
                let mut changes = [of_other; 2];
                changes[edged] += place(other) - place(edged);
                (turned(angles[edged], *normal), changes)
            }
        };
        let velocity_change = |n: usize| {
            let (deviation, side) = (&before[n], &sides[n]);
            deviation.velocity
                + turned(deviation.spin, side.anchor)
                + turned(side.before.angular_velocity, anchor_changes[n])
        };
        let rate_change = normal_change.dot(self.relative)
            + normal.dot(velocity_change(1) - velocity_change(0))
            + self.acceleration * delay;
        let lever_changes = [0, 1]
            .map(|n| anchor_changes[n].perp_dot(*normal) + sides[n].anchor.perp_dot(normal_change));
        let inverse_change: f64 = [0, 1]
            .map(|n| 2.0 * sides[n].lever * lever_changes[n] * sides[n].inverse_moment)
            .iter()
            .sum();
        let mass = self.reduced_mass;
        let impulse = self.factor * mass * self.gap_rate;
        let impulse_change =
            self.factor * mass * (rate_change - mass * inverse_change * self.gap_rate);
        [0, 1].map(|n| {
            let (side, deviation) = (&sides[n], &before[n]);
            let push = impulse_change * *normal + impulse * normal_change;
            let torque = impulse_change * side.lever + impulse * lever_changes[n];
            let slip = side.before.velocity - side.after.velocity;
            let turn = side.before.angular_velocity - side.after.angular_velocity;
            BodyDeviation {
                position: deviation.position + delay * slip,
                angle: deviation.angle + delay * turn,
                velocity: deviation.velocity + (side.sign * side.inverse_mass) * push,
                spin: deviation.spin + (side.sign * side.inverse_moment) * torque,
            }
        })
    }
}

impl MapSide {
    fn anchor_velocity(&self) -> DVec2 {
        self.before.velocity + turned(self.before.angular_velocity, self.anchor)
    }

    fn inverse_reduced_mass(&self) -> f64 {
        self.inverse_mass + self.lever * self.lever * self.inverse_moment
    }
}
