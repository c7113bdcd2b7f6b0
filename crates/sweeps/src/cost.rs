//! What a replica costs, from a formula: the expected collisions, weighted with the work that the
//! kinds of bodies make of each.
//!
//! No clock and no core of the machine enters, so that every process of a study computes the same
//! split. Costs are powers of 2^(1/8): a difference of rounding between two machines changes one of
//! them only if the logarithm lies within that rounding of the middle between two.

use std::ops::ControlFlow;

use anyhow::{Context, Result};
use carom::{Scene, View, engine::SceneError};
use carom_methods::{AnySimulation, Method};
use carom_runs::check::expected_collisions;

use crate::point::StudyPoint;

/// Work of a collision of molecules over that of discs, for one atom and for each further one:
/// measured with gases of dumbbells, tees and rods on one machine.
const OF_MOLECULE: f64 = 4.0;
const OF_FURTHER_ATOM: f64 = 1.0;

/// Work to place one body, in collisions.
const OF_PLACEMENT: f64 = 3.0;

/// Collisions a molecule until it has grown and relaxed.
const OF_GROWTH: f64 = 1000.0;

/// Steps of a cost in a factor of two.
const STEPS: f64 = 8.0;

/// The cost of one replica of a point, in collisions of discs; at least 1.
///
/// Places the bodies of the point, unless they have to be grown, and so finds every error of its
/// scene before anything runs.
///
/// # Errors
/// The scene cannot be built.
pub fn of_replica(point: &StudyPoint) -> Result<u64> {
    let scene = point.replica(1);
    let method = Method::try_from(&scene.method)?;
    let mut grown = None;
    let mut look = |growth: &carom::engine::Growth| {
        grown = Some(growth.molecules());
        ControlFlow::Break(())
    };
    let cost = match AnySimulation::with_progress(&scene, &method, &mut look) {
        Ok(simulation) => of_run(&scene, &simulation.view()),
        Err(SceneError::Interrupted) => OF_GROWTH * grown.unwrap_or(1) as f64,
        Err(error) => return Err(error).with_context(|| format!("point {}", point.label)),
    };
    Ok(stepped(cost))
}

fn of_run(scene: &Scene, view: &View<'_>) -> f64 {
    let stop = scene.run.stop.as_ref().and_then(|stop| stop.collisions);
    let collisions = expected_collisions(scene, view)
        .unwrap_or(0.0)
        .min(stop.unwrap_or(f64::INFINITY));
    let (mut work, mut count) = (0.0, 0.0);
    for body in view
        .bodies()
        .map(|view| view.body)
        .filter(|body| !body.is_fixed())
    {
        let molecule = body.molecule();
        let parts = molecule.atoms().len() + molecule.edges().len();
        let further = parts.saturating_sub(1) as f64;
        work += if molecule.is_round() {
            1.0
        } else {
            OF_MOLECULE + OF_FURTHER_ATOM * further
        };
        count += 1.0;
    }
    let weight = if count > 0.0 { work / count } else { 1.0 };
    collisions * weight + OF_PLACEMENT * view.len() as f64
}

/// The nearest power of 2^(1/8), as a whole number.
fn stepped(cost: f64) -> u64 {
    let steps = (STEPS * cost.clamp(1.0, 1e15).log2()).round();
    (steps / STEPS).exp2().round() as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::Study;
    use std::path::Path;

    fn costs(values: &str) -> Vec<u64> {
        let text = format!(
            "{values}\n[[scene.gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 50\n[scene.run]\nuntil = 2.0"
        );
        let study = Study::parse(&text, Path::new(""), crate::Size::default()).unwrap();
        study
            .points
            .iter()
            .map(|point| of_replica(point).unwrap())
            .collect()
    }

    #[test]
    fn a_longer_and_a_denser_run_cost_more() {
        let by_time = costs("[[vary]]\nkey = \"run.until\"\nvalues = [10.0, 20.0, 80.0]");
        let [a, b, c] = by_time[..] else {
            panic!("{by_time:?}")
        };
        assert!((b as f64 / a as f64 - 2.0).abs() < 0.2 && (c as f64 / a as f64 - 8.0).abs() < 0.8);
        let dense = costs("[[vary]]\nkey = \"gas.0.count\"\nvalues = [50, 100, 200]");
        assert!(dense.is_sorted() && dense[2] > 8 * dense[0], "{dense:?}");
    }

    #[test]
    fn a_stop_at_a_number_of_collisions_bounds_the_cost() {
        let bounded =
            costs("stop.collisions = 100\n[[vary]]\nkey = \"run.until\"\nvalues = [10.0, 1000.0]");
        assert_eq!(bounded[0], bounded[1]);
        // A gas that has to be grown is not placed.
        let grown = costs("[[vary]]\nkey = \"gas.0.count\"\nvalues = [660]");
        assert!(grown[0] > 500_000, "{grown:?}");
    }

    #[test]
    fn impossible_points_are_refused_before_anything_runs() {
        let text = "[[vary]]\nkey = \"gas.0.count\"\nvalues = [5000]\n[[scene.gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0";
        let study = Study::parse(text, Path::new(""), crate::Size::default()).unwrap();
        let error = format!("{:#}", of_replica(&study.points[0]).unwrap_err());
        assert!(error.contains("point gas.0.count = 5000"), "{error}");
    }
}
