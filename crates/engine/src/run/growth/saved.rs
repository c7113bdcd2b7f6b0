//! The stored form of a growth: the scene, and the motion and the scale of each molecule.

use carom_geometry::{MAX_MAGNITUDE, PeriodicBox};
use carom_kinematics::Motion;
use serde::{Deserialize, Serialize};

use super::{Growth, Stage, State, packing::MAX_LEAD};
use crate::{
    scene::{Scene, error::SceneError},
    start::contents::SceneContents,
};

/// The state on which a growth depends between two steps. All bits survive in any format that keeps
/// those of an `f64`.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct SavedGrowth {
    /// As the text of a scene file, since formats that do not name fields cannot leave any out.
    scene: String,
    motions: Vec<Motion>,
    scales: Vec<f64>,
    state: State,
}

impl From<Growth> for SavedGrowth {
    fn from(growth: Growth) -> Self {
        let first = growth.contents.singles.world.bodies.len();
        Self {
            motions: growth.world.motions[first..].to_vec(),
            scene: growth.scene.to_toml(),
            scales: growth.scales,
            state: growth.state,
        }
    }
}

impl TryFrom<SavedGrowth> for Growth {
    type Error = SceneError;

    fn try_from(saved: SavedGrowth) -> Result<Self, SceneError> {
        let SavedGrowth {
            scene,
            motions,
            scales,
            state,
        } = saved;
        let scene = Scene::from_toml(&scene)?;
        let contents = SceneContents::new(&scene)?;
        let molecules: usize = contents.species.iter().map(|kind| kind.count).sum();
        if motions.len() != molecules || scales.len() != molecules {
            return Err(SceneError::GrowthState(
                "has another number of molecules than its scene",
            ));
        }
        let is_whole = state.stage != Stage::Growing;
        if scales
            .iter()
            .any(|&scale| !(scale > 0.0 && scale <= 1.0) || (is_whole && scale < 1.0))
        {
            return Err(SceneError::GrowthState(
                "has a scale outside of its range, above 0 to 1",
            ));
        }
        let bounds = contents.singles.world.bounds();
        if !motions.iter().all(|motion| is_in_range(motion, bounds)) {
            return Err(SceneError::GrowthState(
                "has a molecule out of the box or with a motion out of range",
            ));
        }
        if !state.is_in_range() {
            return Err(SceneError::GrowthState("has a number out of range"));
        }
        Self::assemble(&scene, contents, scales, &motions, state)
    }
}

/// Whether a molecule in these bounds can have this motion.
fn is_in_range(motion: &Motion, bounds: &PeriodicBox) -> bool {
    let numbers = [
        motion.velocity.x,
        motion.velocity.y,
        motion.angular_velocity,
    ];
    numbers.iter().all(|number| number.abs() <= MAX_MAGNITUDE)
        && motion.time == 0.0
        && motion.orientation.turns().abs() <= 0.5
        && bounds.contains(motion.position)
}

impl State {
    /// Whether a growth can have this state.
    fn is_in_range(&self) -> bool {
        let stage_is_in_range = match self.stage {
            Stage::Growing => self.lead > 0.0 && self.lead <= MAX_LEAD && self.period.1.is_finite(),
            Stage::Relaxing {
                done,
                all,
                energy,
                momentum,
            } => {
                done >= 0.0
                    && all > 0.0
                    && energy.is_finite()
                    && momentum.is_finite()
                    && all.is_finite()
            }
            Stage::Done => true,
        };
        stage_is_in_range && self.period.0 <= self.steps && self.steps != u64::MAX
    }
}
