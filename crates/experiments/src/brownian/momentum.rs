//! Momentum along axes on which nothing fixed stands in the way: it is conserved, and equipartition
//! holds relative to the centre of mass.
//!
//! Of N bodies of total mass m whose momentum along an axis is 0, one of mass M has ⟨M v²⟩ = kT (1
//! − M/m) along it, since its velocity is that relative to the centre of mass of all.

use anyhow::{Result, ensure};
use carom::Scene;
use glam::DVec2;

/// Whether the momentum of a scene is conserved along x and along y.
fn conserved(scene: &Scene) -> [bool; 2] {
    let mut conserved = [scene.bumper.is_empty() && scene.molecule.iter().all(|entry| !entry.fixed); 2];
    for wall in &scene.wall {
        let is_whole = wall.from.is_none() && wall.to.is_none();
        conserved[0] &= is_whole && wall.y.is_some();
        conserved[1] &= is_whole && wall.x.is_some();
    }
    conserved
}

/// Refuses a scene that drifts as a whole: the mean velocity of its molecule would not be 0.
///
/// # Errors
/// The momentum along an axis is conserved and not 0; the message names the entry.
pub fn refuse_drift(scene: &Scene) -> Result<()> {
    let axes = conserved(scene);
    if axes == [false; 2] {
        return Ok(());
    }
    for (index, entry) in scene.molecule.iter().enumerate() {
        let drifts = axes.iter().zip(entry.velocity).any(|(&conserved, speed)| conserved && speed != 0.0);
        ensure!(
            !drifts,
            "molecule[{index}]: `velocity` {:?} makes all bodies drift, because no fixed body takes up momentum; \
             make it 0 or add a [[bumper]]",
            entry.velocity
        );
    }
    for (index, gas) in scene.gas.iter().enumerate() {
        ensure!(
            gas.zero_momentum != Some(false) && gas.count != Some(1),
            "gas[{index}]: its momentum makes all bodies drift, because no fixed body takes it up; add a [[bumper]]"
        );
    }
    Ok(())
}

/// The shares of kT that a molecule with this part of the mass of all bodies has along x′ and along
/// y′: 1, or less where momentum is conserved.
pub fn thermal_shares(scene: &Scene, body: usize, turns: bool, part: f64) -> DVec2 {
    let [x, y] = conserved(scene).map(|conserved| if conserved { part } else { 0.0 });
    if turns {
        // All orientations are equally frequent.
        return DVec2::splat(1.0 - 0.5 * (x + y));
    }
    let entry = &scene.molecule[body];
    let turned = entry.orientation_turns.map(|turns| std::f64::consts::TAU * turns);
    let along = DVec2::from_angle(entry.orientation.or(turned).unwrap_or(0.0));
    let squares = along * along;
    DVec2::new(1.0 - squares.x * x - squares.y * y, 1.0 - squares.y * x - squares.x * y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::engine::WallSpec;

    /// A tee among discs, and a fixed disc.
    fn scene() -> Scene {
        Scene::from_toml(
            "[[molecule]]\nshape = \"tee\"\natom_radius = 0.01\natom_mass = 1.0\nat = [0.5, 0.5]\n\
             [[bumper]]\nradius = 0.01\nat = [0.1, 0.1]\n\
             [[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 50\n",
        )
        .unwrap()
    }

    #[test]
    fn the_share_of_kt_follows_the_axes_without_fixed_bodies() {
        let mut scene = scene();
        let shares = |scene: &Scene, turns| thermal_shares(scene, 0, turns, 0.2);
        assert_eq!(shares(&scene, false), DVec2::ONE);
        scene.bumper.clear();
        assert_eq!(shares(&scene, true), DVec2::splat(0.8));
        scene.wall.push(WallSpec { x: Some(0.0), ..WallSpec::default() });
        assert_eq!(shares(&scene, true), DVec2::splat(0.9));
        assert_eq!(shares(&scene, false), DVec2::new(1.0, 0.8));
        scene.molecule[0].orientation_turns = Some(0.25);
        assert!(shares(&scene, false).distance(DVec2::new(0.8, 1.0)) < 1e-15);
        scene.wall.push(WallSpec { y: Some(0.0), ..WallSpec::default() });
        assert_eq!(shares(&scene, true), DVec2::ONE);
    }

    #[test]
    fn scenes_that_drift_are_refused_by_name() {
        let mut scene = scene();
        scene.molecule[0].velocity = [0.0, 1.0];
        assert!(refuse_drift(&scene).is_ok());
        scene.bumper.clear();
        assert!(refuse_drift(&scene).unwrap_err().to_string().contains("molecule[0]"));
        scene.wall.push(WallSpec { y: Some(0.0), ..WallSpec::default() });
        assert!(refuse_drift(&scene).is_ok());
        scene.wall.clear();
        scene.molecule[0].velocity = [0.0; 2];
        assert!(refuse_drift(&scene).is_ok());
        scene.gas[0].zero_momentum = Some(false);
        assert!(refuse_drift(&scene).unwrap_err().to_string().contains("gas[0]"));
    }
}
