//! The scenes that a page offers: those of this repository, and a few for the laboratory alone.

use anyhow::{Context, Result};
use carom::Scene;
use serde::Serialize;

/// A scene of the gallery.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Exhibit {
    /// Its name.
    pub name: &'static str,
    /// What happens in it, in a sentence.
    pub about: &'static str,
    /// A measure that shows it, by name.
    pub measure: &'static str,
    #[serde(skip)]
    text: &'static str,
}

/// All scenes.
pub const EXHIBITS: [Exhibit; 9] = [
    Exhibit {
        name: "tee",
        about: "The molecule of the thesis: a tee in a gas of discs, which push it about",
        measure: "drift:molecule",
        text: include_str!("../scenes/tee.toml"),
    },
    Exhibit {
        name: "mixture",
        about: "Rings and rods in a gas of discs, with a bumper; rods lose energy when they meet",
        measure: "velocities:gas",
        text: include_str!("../../../xtask/scenes/mixture.toml"),
    },
    Exhibit {
        name: "clustering",
        about: "Contacts that lose energy: the gas cools, and clusters form",
        measure: "temperature:gas",
        text: include_str!("../scenes/clustering.toml"),
    },
    Exhibit {
        name: "two-temperatures",
        about: "Heat flows from hot discs to cold ones, each held at its temperature",
        measure: "temperature:cold",
        text: include_str!("../../../xtask/scenes/two-temperatures.toml"),
    },
    Exhibit {
        name: "depletion",
        about: "Small discs push two big ones together",
        measure: "drift:left",
        text: include_str!("../scenes/depletion.toml"),
    },
    Exhibit {
        name: "sinai",
        about: "Sinai's billiard: one disc and one bumper; its flights are chaotic",
        measure: "free-path:particle",
        text: include_str!("../scenes/sinai.toml"),
    },
    Exhibit {
        name: "walls",
        about: "Two kinds of molecules in a closed box of two chambers with a gap between them",
        measure: "pressure",
        text: include_str!("../../../xtask/scenes/walls.toml"),
    },
    Exhibit {
        name: "conduction",
        about: "A gas of many sizes conducts heat from a hot wall to a cold one",
        measure: "wall-heat:hot",
        text: include_str!("../../../xtask/scenes/conduction.toml"),
    },
    Exhibit {
        name: "tracer",
        about: "A dumbbell among light and heavy discs at one temperature",
        measure: "velocities:light",
        text: include_str!("../../../xtask/scenes/measures.toml"),
    },
];

/// The scene of this name.
///
/// # Errors
/// There is none.
pub fn scene(name: &str) -> Result<Scene> {
    let exhibit = EXHIBITS.iter().find(|exhibit| exhibit.name == name);
    let exhibit = exhibit.with_context(|| format!("the gallery has no scene {name:?}"))?;
    Scene::from_toml(exhibit.text).with_context(|| format!("the scene {name:?} of the gallery"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::{EpochTime, engine::MeasureSpec};
    use carom_runs::{measures::SingleMeasure, run::interactive::InteractiveRun};

    #[test]
    fn every_scene_runs_and_has_its_measure() {
        for exhibit in EXHIBITS {
            let scene = scene(exhibit.name).unwrap();
            let mut run = InteractiveRun::begin(&scene).unwrap();
            let (kind, of) =
                exhibit.measure.split_once(':').map_or((exhibit.measure, None), |(k, t)| (k, Some(t)));
            let of = of.map(str::to_owned);
            let spec = MeasureSpec { kind: kind.to_owned(), of, ..MeasureSpec::default() };
            let interval = scene.run.sample_interval;
            SingleMeasure::begin(&spec, interval, &scene, &run.view()).unwrap();
            run.advance(EpochTime::from(1e-3 * scene.run.until), &mut ()).unwrap();
        }
    }
}
