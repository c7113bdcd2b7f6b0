//! Pockets of the molecules of a scene, such as the hole of a ring: a body placed in one could
//! never leave it.

use carom_geometry::{ExcludedRegion, GeometryError, PeriodicBox};
use carom_kinematics::Motion;
use glam::DVec2;

use crate::world::World;

/// The pockets of all molecules of a world for discs of one radius.
#[derive(Debug, Default)]
pub(crate) struct Pockets(Vec<(Motion, ExcludedRegion)>);

impl Pockets {
    /// The pockets for discs of this radius (length).
    ///
    /// # Errors
    /// The radius is out of range.
    pub fn new(world: &World, radius: f64) -> Result<Self, GeometryError> {
        let mut pockets = Vec::new();
        for (body, motion) in world.bodies.iter().zip(&world.motions) {
            // A pocket has three atoms or more around it.
            if body.is_wall() || body.molecule().atoms().len() < 3 {
                continue;
            }
            let region = ExcludedRegion::new(body.molecule(), radius)?;
            if region.has_pockets() {
                pockets.push((*motion, region));
            }
        }
        Ok(Self(pockets))
    }

    /// Whether the centre of a disc that overlaps no molecule is in a pocket.
    pub fn contain(&self, bounds: &PeriodicBox, centre: DVec2) -> bool {
        self.0.iter().any(|(motion, region)| {
            let apart = bounds.nearest_image(centre - motion.position);
            // Into the frame of the molecule.
            region.contains((motion.orientation.cos_sin() * DVec2::new(1.0, -1.0)).rotate(apart))
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::{run::simulation::Simulation, scene::Scene};
    use glam::DVec2;

    const RING: &str = "[[molecule]]\nshape = \"ring:20\"\natom_radius = 0.02\natom_mass = 1.0\nat = [0.95, 0.5]\n\
                        orientation = 0.1\n";

    /// Bodies of a gas around a ring across the border of the box, and how many are in its hole.
    fn placed(gas: &str, start: &str) -> (usize, usize) {
        let simulation =
            Simulation::new(&Scene::from_toml(&format!("{start}{RING}{gas}")).unwrap()).unwrap();
        let view = simulation.view();
        let is_in = |at: DVec2| {
            view.bounds()
                .nearest_image(at - DVec2::new(0.95, 0.5))
                .length()
                < 0.12
        };
        let all = || view.bodies().skip(1);
        (
            all().count(),
            all().filter(|body| is_in(body.motion.position)).count(),
        )
    }

    #[test]
    fn nothing_is_placed_in_the_hole_of_a_ring_and_no_body_is_lost() {
        let start = "[start]\nempty_pockets = true\n";
        let discs = "[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 500\n";
        let drawn = "[[gas]]\nradius = { uniform = [0.006, 0.01] }\nmass = 1.0\nenergy = 1.0\ncount = 500\n";
        let pairs = "[[gas]]\nshape = \"dumbbell\"\natom_radius = 0.006\natom_mass = 1.0\nenergy = 1.0\ncount = 300\n";
        for (gas, count) in [(discs, 500), (drawn, 500), (pairs, 300)] {
            let (all, within) = placed(gas, "");
            assert!(all == count && within > 3, "{within}");
            assert_eq!(placed(gas, start), (count, 0));
        }
    }

    #[test]
    fn gases_that_grow_cannot_keep_out_of_pockets() {
        for (keys, count) in [("placement = \"grown\"\n", 100), ("", 2700)] {
            let gas =
                format!("[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = {count}\n");
            let text = format!("[start]\nempty_pockets = true\n{keys}{RING}{gas}");
            let refused = Simulation::new(&Scene::from_toml(&text).unwrap()).map(drop);
            let error = refused.unwrap_err().to_string();
            assert!(
                error.contains("empty_pockets") || error.contains("molecules can be placed"),
                "{error}"
            );
        }
    }
}
