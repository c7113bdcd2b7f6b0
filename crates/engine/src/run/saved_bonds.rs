//! The bonds in a checkpoint.

use carom_detection::Tether;
use carom_response::Elasticity;
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::world::tethers::{Bond, Tethers};

/// A bond.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct SavedBond {
    bodies: [u32; 2],
    points: [DVec2; 2],
    /// The shortest and the longest length.
    bounds: [f64; 2],
    elasticity: f64,
}

impl From<&Bond> for SavedBond {
    fn from(bond: &Bond) -> Self {
        Self {
            bodies: bond.bodies,
            points: bond.tether.points(),
            bounds: bond.tether.bounds(),
            elasticity: bond.elasticity.coefficient(),
        }
    }
}

impl SavedBond {
    fn bond(&self, bodies: usize) -> Option<Bond> {
        let [a, b] = self.bodies;
        let elasticity = Some(self.elasticity).filter(|share| (0.0..=1.0).contains(share))?;
        (a < b && (b as usize) < bodies).then_some(Bond {
            bodies: self.bodies,
            tether: Tether::new(self.points, self.bounds).ok()?,
            elasticity: Elasticity::new(elasticity).ok()?,
        })
    }
}

/// The bonds of a world of so many bodies.
///
/// # Errors
/// The number of the first that cannot be.
pub(crate) fn tethers(saved: &[SavedBond], bodies: usize) -> Result<Tethers, usize> {
    let bonds = saved
        .iter()
        .enumerate()
        .map(|(number, bond)| bond.bond(bodies).ok_or(number));
    Ok(Tethers::new(bonds.collect::<Result<_, _>>()?))
}
