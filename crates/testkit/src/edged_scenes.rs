//! Simulations of bodies with straight edges, made by exchanging the shapes of a scene of discs.

use anyhow::{Context as _, Result};
use carom::{Scene, engine::Checkpoint};
use carom_geometry::Molecule;
use carom_methods::{AnySimulation, Method};

use serde_json::json;

/// The simulation of a scene whose shapes, in order of appearance, are replaced by these; more
/// shapes than these are kept.
///
/// The bodies keep their places, orientations and velocities. Overlaps of the new shapes are not
/// checked.
///
/// # Errors
/// The scene is refused, or the shapes do not suit it.
pub fn with_shapes(scene: &str, shapes: &[Molecule]) -> Result<AnySimulation> {
    let simulation = AnySimulation::new(&Scene::from_toml(scene)?)?;
    let checkpoint = simulation.checkpoint().context("it has not begun")?;
    let mut value = serde_json::to_value(&checkpoint)?;
    let places = value["molecules"].as_array_mut().context("no molecules")?;
    for (place, shape) in places.iter_mut().zip(shapes) {
        *place = serde_json::to_value(shape)?;
    }
    // JSON has no infinite numbers.
    let times = value["last_contacts"].as_array_mut().context("no times")?;
    for time in times.iter_mut().filter(|time| time.is_null()) {
        *time = json!(f64::MIN);
    }
    let checkpoint: Checkpoint = serde_json::from_value(value)?;
    Ok(AnySimulation::resume(&checkpoint, &Method::default())?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_geometry::EdgedShape;

    #[test]
    fn squares_move_in_place_of_dumbbells() {
        let square = EdgedShape::Square.molecule(0.05, 1e-6, 2.0).unwrap();
        let scene = "[[gas]]\nshape = \"dumbbell\"\natom_radius = 0.02\natom_mass = 1.0\nenergy = 1.0\ncount = 20\n";
        let mut simulation = with_shapes(scene, std::slice::from_ref(&square)).unwrap();
        let is_square = |body: carom::engine::BodyView<'_>| *body.body.molecule() == square;
        assert!(simulation.view().bodies().all(is_square));
        let energy = simulation.view().energy();
        simulation.run_until(0.2).unwrap();
        assert!(simulation.view().counters().collisions > 0);
        assert!((simulation.view().energy() / energy - 1.0).abs() < 1e-12);
    }
}
