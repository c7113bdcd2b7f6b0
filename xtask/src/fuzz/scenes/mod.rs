//! Random scenes with edits, run by both schedulers and checked against independent kinematics.

pub mod axis_motion;
mod balance;
mod bonds;
mod bounds;
pub mod case;
pub mod contact;
pub mod convex;
pub mod draw;
pub mod durations;
pub mod kinematics;
pub mod laws;
pub mod motions;
pub mod oscillation;
mod overlaps;
pub mod pistons;
pub mod rough;
pub mod rules;
pub mod run;
pub mod schedulers;
pub mod sided;
mod states;
pub mod stops;
pub mod table_path;
mod tracked;
pub mod vectors;
pub mod watcher;
mod wells;

use anyhow::Result;
use carom::engine::{
    CellsPerSide, Checkpoint, CheckpointError, Instructions, Scene, SceneError, WallMotionSpec,
};
use carom_kinematics::EpochTime;
use carom_methods::{AnySimulation, Method, Order};

use self::{case::SceneCase, run::Seams, schedulers::Scales, table_path::TablePath};
use super::subject::{Report, Subject, read_toml, write_toml};

/// The fuzzer of the engine.
#[derive(Debug, Clone, Default)]
pub struct Scenes<P = Sound> {
    /// Builds the simulations under test.
    pub parts: P,
}

/// The exchangeable parts of a simulation: tests plant faults in them.
pub trait SceneParts {
    /// Builds a simulation of a scene with this scheduler.
    ///
    /// # Errors
    /// The scene is refused.
    fn start(&self, scene: &Scene, order: Order) -> Result<AnySimulation, SceneError>;

    /// Resumes a simulation with this scheduler.
    ///
    /// # Errors
    /// The checkpoint is refused.
    fn resume(
        &self,
        checkpoint: &Checkpoint,
        order: Order,
    ) -> Result<AnySimulation, CheckpointError>;
}

/// The detector and the response as they are.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sound;

impl SceneParts for Sound {
    fn start(&self, scene: &Scene, order: Order) -> Result<AnySimulation, SceneError> {
        AnySimulation::with(
            scene,
            &Method {
                order,
                ..Method::default()
            },
        )
    }

    fn resume(
        &self,
        checkpoint: &Checkpoint,
        order: Order,
    ) -> Result<AnySimulation, CheckpointError> {
        AnySimulation::resume(
            checkpoint,
            &Method {
                order,
                ..Method::default()
            },
        )
    }
}

impl<P: SceneParts> Subject for Scenes<P> {
    type Case = SceneCase;
    const NAME: &'static str = "scenes";
    const TIME_LIMIT: u64 = 60;

    fn draw(&self, seed: u64) -> SceneCase {
        draw::draw(seed)
    }

    fn check(&self, case: &SceneCase) -> Report {
        let instructions = [
            Instructions::Widest,
            Instructions::Avx2,
            Instructions::Portable,
        ];
        let [one, other] =
            [case.seed % 3, case.seed / 3 % 3].map(|index| instructions[index as usize]);
        let cells = Seams {
            parts: &self.parts,
            order: Order::Cells(one),
            resumed: Order::Cells(other),
        };
        let grid = Order::Heap(CellsPerSide::Automatic);
        let thesis = Seams {
            parts: &self.parts,
            order: grid,
            resumed: grid,
        };
        let (cells, thesis) = (run::run(case, &cells), run::run(case, &thesis));
        let mut report = Report::default();
        let (Some(cells), Some(thesis)) = (cells, thesis) else {
            report.count("refused", 1);
            return report;
        };
        for (name, outcome) in [("CellScheduler: ", &cells), ("HeapScheduler: ", &thesis)] {
            report.add(&outcome.report);
            if let Some(failure) = &outcome.report.failure {
                report.fail(&failure.kind, format!("{name}{}", failure.detail));
            }
        }
        if report.failure.is_none() {
            let scales = scales(&case.scene, case, cells.whole && thesis.whole);
            schedulers::compare(&cells.log, &thesis.log, &scales, &mut report);
        }
        report
    }

    fn simpler(&self, case: &SceneCase) -> Vec<SceneCase> {
        case.simpler()
    }

    fn write(&self, case: &SceneCase) -> (String, Vec<u8>) {
        write_toml(case)
    }

    fn read(&self, ending: &str, bytes: &[u8]) -> Result<SceneCase> {
        read_toml(ending, bytes)
    }
}

fn scales(scene: &Scene, case: &SceneCase, whole: bool) -> Scales {
    let duration: f64 = case.stretch.iter().map(|stretch| stretch.duration).sum();
    let side = scene.bounds.sides[0].max(scene.bounds.sides[1]);
    let speeds = scene
        .molecule
        .iter()
        .map(|molecule| molecule.velocity[0].hypot(molecule.velocity[1]));
    let of_walls = motions_of(scene).map(|motion| {
        let [way, velocity] = [motion.amplitude, motion.velocity].map(vectors::length);
        velocity + motion.turn.abs() * side + motion.frequency * way
    });
    let of_tables = motions_of(scene).filter_map(|motion| {
        let path = TablePath::new(motion, EpochTime::ZERO)?;
        Some(path.top_speed())
    });
    let of_pistons = scene.piston.iter().map(|piston| {
        // The squares of the speeds that it gains by its force on the way along the box, and by its
        // spring on the way to where that is relaxed, but at most along the box and back.
        let of_force = 2.0 * (piston.force / piston.mass).abs() * side;
        let place = piston.x.or(piston.y).unwrap_or_default();
        let stretched = (piston.relaxed_at.unwrap_or(place) - place).abs();
        let of_spring = piston.spring / piston.mass * stretched * stretched.min(2.0 * side);
        let gained = of_force + of_spring;
        piston.velocity.hypot(gained.sqrt())
    });
    let of_fall = (vectors::length(scene.gravity.acceleration) * side).sqrt();
    let of_walls = of_walls.chain(of_tables).chain(of_pistons);
    let fastest = speeds.chain(of_walls).fold(of_fall, f64::max);
    // In this scene bodies rotate without translation.
    let speed = if fastest > 0.0 {
        fastest
    } else {
        side / duration
    };
    // A run that ended early has contacts up to an unknown time.
    Scales {
        sides: scene.bounds.sides,
        speed,
        end: if whole { duration } else { 0.0 },
    }
}

/// The motions of the walls of a scene at its start.
fn motions_of(scene: &Scene) -> impl Iterator<Item = &WallMotionSpec> {
    scene.wall.iter().filter_map(|wall| wall.motion.as_ref())
}

#[cfg(test)]
mod tests;
