//! Where a molecule of a gas is placed, and how often a place is tried.

use carom_kinematics::Orientation;
use glam::DVec2;
use rand::RngExt;
use rand_pcg::Pcg64;

/// Where a molecule is placed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    /// Its centre of mass (length).
    pub at: DVec2,
    /// Its orientation, if that matters for its place.
    pub orientation: Option<Orientation>,
}

impl Place {
    /// The orientation of the molecule, at random where any will do.
    pub(crate) fn orientation(&self, random: &mut Pcg64) -> Orientation {
        self.orientation
            .unwrap_or_else(|| Orientation::from_turns(random.random()))
    }
}

/// Places tried for a molecule whose place is drawn at random. Fewer: places among many obstacles
/// are not found, and arrays that fit are refused. More: a refusal takes longer.
pub(crate) const TRIALS: usize = 100_000;
