//! The geometry of a contact, and the speed at which its surfaces approach.

#![allow(
    clippy::inline_always,
    reason = "compiled with the instructions of the caller"
)]

use carom_kinematics::Motion;
use glam::DVec2;

/// The geometry of a contact: the direction of the normal and the lever arms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactFrame {
    /// Vector from the centre of the touching part of A to that of B, or any other vector along the
    /// normal with a length other than 0.
    pub line_of_centres: DVec2,
    /// Vectors from each centre of mass to the point of contact, in a contact whose impulse may
    /// have a tangential part ([`Response::is_rough`](crate::Response::is_rough)); in others to the
    /// centre of the touching atom, because the remaining vector to the point of contact is along
    /// the normal and has no moment (length).
    pub arms: [DVec2; 2],
}

impl ContactFrame {
    /// This frame with arms that are longer along the normal by these distances of the surfaces
    /// from the ends of the arms (length): from the centres of the touching atoms to the point of
    /// contact.
    #[must_use]
    pub fn extended_to_surfaces(&self, distances: [f64; 2]) -> Self {
        let normal = self.normal();
        let [a, b] = self.arms;
        Self {
            arms: [a + distances[0] * normal, b - distances[1] * normal],
            ..*self
        }
    }

    /// Unit vector from A to B at the point of contact.
    ///
    /// This uses the square root of the standard library, which compiles to an instruction of the
    /// same generation as the surrounding ones. glam's own uses an older instruction (SSE) in any
    /// case, for which code compiled for AVX waits hundreds of cycles.
    #[inline(always)]
    pub fn normal(&self) -> DVec2 {
        let d = self.line_of_centres;
        let inverse = 1.0 / d.length_squared().sqrt();
        if inverse.is_finite() && inverse > 0.0 {
            d * inverse
        } else {
            DVec2::X
        }
    }
}

/// Speed u at which the two surfaces approach each other along the normal (length / time); negative
/// if they separate.
pub fn approach_speed(frame: &ContactFrame, motions: [&Motion; 2]) -> f64 {
    scaled_approach(frame, motions) / frame.line_of_centres.length()
}

/// u |d|
pub(crate) fn scaled_approach(frame: &ContactFrame, [a, b]: [&Motion; 2]) -> f64 {
    let d = frame.line_of_centres;
    let [arm_a, arm_b] = frame.arms;
    // The rotation enters as ω (r × d), which is exactly 0 for a disc.
    let translation = (a.velocity - b.velocity).dot(d);
    let rotation = a.angular_velocity * arm_a.perp_dot(d) - b.angular_velocity * arm_b.perp_dot(d);
    translation + rotation
}

/// Returns d·d (1/m_A + 1/m_B).
///
/// The sum of the inverse masses is not computed first, since for two given masses it always has
/// the same rounding error. Neither is d·d/m_A + d·d/m_B, since with 1/m_B = 1/3 the last digits of
/// the two terms depend on each other, so that ties are always rounded to the same side.
#[inline]
pub(crate) fn scaled_inverse_masses(d: DVec2, [a, b]: [f64; 2]) -> f64 {
    let (x, y) = (d.x * d.x, d.y * d.y);
    (x * a + y * b) + (y * a + x * b)
}
