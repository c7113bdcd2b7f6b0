//! The number of bodies of a scene before they are placed.

use carom_geometry::PeriodicBox;
use glam::DVec2;

use crate::{
    scene::{Scene, error::SceneError},
    start::{body_builder::geometry, species::expected_count},
};

impl Scene {
    /// Number of bodies at the start, walls and fixed bodies too, found without placing them and
    /// without the memory that they need. For a gas of drawn sizes with an area fraction, the
    /// expected number, to 15 %.
    ///
    /// ```
    /// use carom_engine::Scene;
    ///
    /// let gas = "[[gas]]\nradius = 1e-5\nmass = 1.0\nenergy = 1.0\ncount = 100000000\n";
    /// assert_eq!(Scene::from_toml(gas)?.expected_bodies()?, 100_000_000);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`SceneError`], with the name of the entry, if the box or the molecules of a gas are
    /// invalid, or are more than 2^27 of one kind.
    pub fn expected_bodies(&self) -> Result<usize, SceneError> {
        let bounds = PeriodicBox::new(DVec2::from(self.bounds.sides)).map_err(geometry("box"))?;
        let singles = self.molecule.len() + self.bumper.len() + self.wall_count();
        (0..self.gas.len()).try_fold(singles, |sum, index| {
            expected_count(self, index, &bounds).map(|count| sum.saturating_add(count))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::simulation::Simulation;

    #[test]
    fn the_expected_number_is_that_placed() {
        let scene = Scene::from_toml(
            "[box]\nsides = [2.0, 1.0]\n[[wall]]\nx = 0.0\n[[bumper]]\nradius = 0.02\nat = [0.5, 0.5]\n\
             [[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\narea_fraction = 0.1\n\
             [[gas]]\nshape = \"dumbbell\"\natom_radius = { uniform = [0.004, 0.006] }\natom_mass = 1.0\n\
             energy = 1.0\ncount = 30\n",
        )
        .unwrap();
        let placed = Simulation::new(&scene).unwrap().view().len();
        assert_eq!(scene.expected_bodies().unwrap(), placed);
        let mut drawn = scene;
        (drawn.gas[1].count, drawn.gas[1].area_fraction) = (None, Some(0.2));
        let placed = Simulation::new(&drawn).unwrap().view().len() as f64;
        assert!((drawn.expected_bodies().unwrap() as f64 / placed - 1.0).abs() < 0.05);
    }

    #[test]
    fn more_molecules_than_allowed_are_refused_with_their_number() {
        for size in ["radius = 1e-5", "radius = { uniform = [1e-5, 2e-5] }"] {
            let text = format!("[[gas]]\n{size}\nmass = 1.0\nenergy = 1.0\ncount = 1000000000\n");
            let scene = Scene::from_toml(&text).unwrap();
            for error in [
                scene.expected_bodies().map(drop),
                Simulation::new(&scene).map(drop),
            ] {
                let said = error.unwrap_err().to_string();
                assert!(
                    said.contains("at most 2^27") && said.contains("but 1000000000 are requested"),
                    "{said}"
                );
            }
        }
    }
}
