//! The report of a collision: the two bodies, the position, the time, and the changes.

use carom_kinematics::{EpochTime, Motion, angular_momentum, kinetic_energy, momentum};
use carom_response::Elasticity;
use glam::DVec2;

use crate::world::body::Body;

/// One body's part in a collision.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Side<'a> {
    /// The body.
    pub body: &'a Body,
    /// Index of the atom that touched; `None` in the model of bounding circles, and for an edge
    /// touched between its ends.
    pub atom: Option<u32>,
    /// Index of the edge that was touched between its ends.
    pub edge: Option<u32>,
    /// Arm from the centre of mass to the touching atom's centre; for an edge, to the touched point
    /// of its line (length). In a rough contact, to the point of contact. Where the bodies touch at
    /// several points, to a point on the line of action of the resultant.
    pub arm: DVec2,
    /// The motion at the instant of contact, before the impulse.
    pub before: Motion,
    /// The motion at the instant of contact, after the impulse.
    pub after: Motion,
}

impl Side<'_> {
    /// Change of velocity (length / time).
    pub fn velocity_change(&self) -> DVec2 {
        self.after.velocity - self.before.velocity
    }

    /// Change of momentum Δp (mass × length / time); 0 for a fixed body.
    pub fn momentum_change(&self) -> DVec2 {
        momentum(&self.after, &self.body.kind.inertia)
            - momentum(&self.before, &self.body.kind.inertia)
    }

    /// Change of angular velocity (radians / time).
    pub fn angular_velocity_change(&self) -> f64 {
        self.after.angular_velocity - self.before.angular_velocity
    }

    /// Change of the angular momentum about the body's own centre (mass × length² / time).
    pub fn angular_momentum_change(&self) -> f64 {
        let own =
            |motion: &Motion| angular_momentum(motion, &self.body.kind.inertia, motion.position);
        own(&self.after) - own(&self.before)
    }

    /// Change of kinetic energy (mass × length² / time²).
    pub fn energy_change(&self) -> f64 {
        kinetic_energy(&self.after, &self.body.kind.inertia)
            - kinetic_energy(&self.before, &self.body.kind.inertia)
    }
}

/// The data of a collision that an observer receives.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct CollisionReport<'a> {
    /// Time of the collision.
    pub time: EpochTime,
    /// The two bodies, the one inserted earlier first.
    pub sides: [Side<'a>; 2],
    /// Point of contact, in the frame of the first body's image (length); at a step of a well the
    /// centre of the first disc.
    pub point: DVec2,
    /// Unit vector from the first body to the second at the point of contact; of a bond at its
    /// longest, from the tied point of the second to that of the first, and of discs that leave a
    /// shell of their well from the second to the first.
    pub normal: DVec2,
    /// Impulse on the second body (mass × length / time); the first receives its opposite. Where
    /// the bodies touch at several points, the resultant.
    pub impulse: DVec2,
    /// The elasticity of the contact: that of the two bodies, or a higher one if the guard against
    /// inelastic collapse has raised it.
    pub elasticity: Elasticity,
    /// The image of the second body that was touched, in boxes relative to its position.
    pub image: [i64; 2],
    /// The shift of that image from the second body (length).
    pub shift: DVec2,
    /// Number of points at which the two bodies touch: 1, but for bodies that meet flat or in a
    /// notch.
    pub points: u32,
    /// The bond that reaches a bound, by its index in [`World::bonds`](crate::World::bonds); `None`
    /// where surfaces touch.
    pub bond: Option<u32>,
    /// Whether two discs are at the range of a step of their well
    /// ([`WellSpec`](crate::WellSpec)), not in contact.
    pub is_step: bool,
    /// Work of a wall that moves on the other body (mass × length² / time²); 0 without one.
    pub work: f64,
    /// The drag γ of all bodies (1/time): between contacts their velocities fall as exp(−γ t).
    pub drag: f64,
}

impl<'a> CollisionReport<'a> {
    /// Whether surfaces touch: not at a bound of a bond, nor at a step of a well.
    pub fn is_contact(&self) -> bool {
        self.bond.is_none() && !self.is_step
    }

    /// Returns the side of the body with this handle and the impulse on it (mass × length / time).
    pub fn side_of(&self, key: crate::BodyKey) -> Option<(&Side<'a>, DVec2)> {
        match &self.sides {
            [first, _] if first.body.key == key => Some((first, -self.impulse)),
            [_, second] if second.body.key == key => Some((second, self.impulse)),
            _ => None,
        }
    }

    /// Vector from the centre of the first body to the centre of the touched image of the second
    /// (length).
    pub fn separation(&self) -> DVec2 {
        let [first, second] = &self.sides;
        (second.before.position - first.before.position) + self.shift
    }
}
