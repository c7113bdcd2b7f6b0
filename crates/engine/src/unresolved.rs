//! Contacts whose surfaces rounding alone separates: so many in so short a time are an inelastic collapse.

use carom_kinematics::Motion;
use serde::{Deserialize, Serialize};

use crate::Body;

/// Such contacts after which their rate is judged. Fewer: a pair that rests and turns for a moment
/// ends a run. More: a collapse costs more time before it has its name.
const MOST_UNRESOLVED: u32 = 100_000;

/// They count as a collapse if they have come within this share of a natural time of the pair,
/// (R_A + R_B)/L. Bodies that rest on each other and turn have some 10¹² of them in a natural time.
const COLLAPSE: f64 = 1e-4;

/// How many contacts rounding alone has separated, and since when they are counted.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct Unresolved {
    pub count: u32,
    /// Offset in the epoch (time).
    pub since: f64,
}

impl Unresolved {
    /// Counts a contact of two bodies at `time` (offset in the epoch). Returns the number of
    /// contacts if so many have come in so short a time that there would be no end of them.
    #[cold]
    pub fn count(&mut self, time: f64, bodies: [&Body; 2], motions: &[Motion; 2]) -> Option<u32> {
        if self.count == 0 {
            self.since = time;
        }
        self.count += 1;
        if self.count < MOST_UNRESOLVED {
            return None;
        }
        self.count = 0;
        let radii = bodies.map(|body| body.kind.molecule.bounding_radius());
        let rims: f64 = [0, 1].map(|n: usize| motions[n].angular_velocity.abs() * radii[n]).iter().sum();
        let speed = (motions[1].velocity - motions[0].velocity).length() + rims;
        // A wall may be of any length.
        let radius = [0, 1].map(|n: usize| if bodies[n].is_wall() { 0.0 } else { radii[n] });
        ((time - self.since) * speed < COLLAPSE * (radius[0] + radius[1])).then_some(MOST_UNRESOLVED)
    }

    /// Moves the origin of time by `offset`.
    pub fn rebase(&mut self, offset: f64) {
        self.since -= offset;
    }
}
