//! Contacts whose surfaces separate by rounding alone; a high rate of them is an inelastic
//! collapse.

use carom_kinematics::{DragClock, Motion};
use serde::{Deserialize, Serialize};

use crate::world::body::Body;

/// Number of such contacts after which their rate is checked. Smaller: a pair in lasting contact
/// that turns for a moment ends a run. Larger: a collapse takes longer to be reported.
const MAX_UNRESOLVED: u32 = 100_000;

/// They count as a collapse if they happen within this share of a natural time of the pair,
/// (R_A + R_B)/w with the relative speed w. Bodies that rest on each other and turn have about 10¹²
/// of them in a natural time.
const COLLAPSE: f64 = 1e-4;

/// Number of contacts that rounding alone has separated, and the start of the count.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct Unresolved {
    pub count: u32,
    /// Start of the count (offset in the epoch, time).
    pub since: f64,
}

impl Unresolved {
    /// Counts a contact of two bodies at `time` (offset in the epoch). Returns the number of
    /// contacts if so many in so short a time are a collapse.
    #[cold]
    pub fn count(&mut self, time: f64, bodies: [&Body; 2], motions: &[Motion; 2]) -> Option<u32> {
        if self.count == 0 {
            self.since = time;
        }
        self.count += 1;
        if self.count < MAX_UNRESOLVED {
            return None;
        }
        self.count = 0;
        let radii = bodies.map(|body| body.kind.molecule.bounding_radius());
        let rims: f64 = [0, 1]
            .map(|n: usize| motions[n].angular_velocity.abs() * radii[n])
            .iter()
            .sum();
        let speed = (motions[1].velocity - motions[0].velocity).length() + rims;
        // The length of a wall is unrelated to the contact.
        let radius = [0, 1].map(|n: usize| if bodies[n].is_wall() { 0.0 } else { radii[n] });
        ((time - self.since) * speed < COLLAPSE * (radius[0] + radius[1])).then_some(MAX_UNRESOLVED)
    }

    /// Moves the origin of time by `offset`.
    pub fn rebase(&mut self, offset: f64, clock: DragClock) {
        self.since = clock.restarted(self.since, offset);
    }
}
