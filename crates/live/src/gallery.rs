//! The scenes that a page offers: those of this repository, and a few for the laboratory alone.

use std::sync::OnceLock;

use anyhow::{Context, Result};
use carom::Scene;
use carom_runs::{examples::Example, picture_of, run::interactive::InteractiveRun};
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
    /// The name of its file.
    #[serde(skip)]
    pub example: &'static str,
}

/// All scenes.
pub const EXHIBITS: [Exhibit; 13] = [
    Exhibit {
        name: "tee",
        about: "The molecule of the thesis: a tee in a gas of discs, which push it about",
        measure: "drift:molecule",
        example: "tee",
    },
    Exhibit {
        name: "mixture",
        about: "Rings and rods in a gas of discs, with a bumper; rods lose energy when they meet",
        measure: "velocities:gas",
        example: "mixture",
    },
    Exhibit {
        name: "clustering",
        about: "Contacts that lose energy: the gas cools, and clusters form",
        measure: "temperature:gas",
        example: "clustering",
    },
    Exhibit {
        name: "two-temperatures",
        about: "Heat flows from hot discs to cold ones, each held at its temperature",
        measure: "temperature:cold",
        example: "two-temperatures",
    },
    Exhibit {
        name: "swimmers",
        about: "Discs that swim along axes of their own gather in clusters",
        measure: "structure-factor:swimmers",
        example: "swimmers",
    },
    Exhibit {
        name: "depletion",
        about: "Small discs push two big ones together",
        measure: "drift:left",
        example: "depletion",
    },
    Exhibit {
        name: "chains",
        about: "Chains, a ring and a star of discs, tied by bonds, in a bath of discs",
        measure: "chains:chain",
        example: "chains",
    },
    Exhibit {
        name: "wells",
        about: "Discs that attract each other gather in droplets",
        measure: "wells",
        example: "wells",
    },
    Exhibit {
        name: "sinai",
        about: "Sinai's billiard: one disc and one bumper; its flights are chaotic",
        measure: "free-path:particle",
        example: "sinai",
    },
    Exhibit {
        name: "walls",
        about: "Two kinds of molecules in a closed box of two chambers with a gap between them",
        measure: "pressure",
        example: "walls",
    },
    Exhibit {
        name: "piston",
        about: "A piston compresses a gas and returns, while a paddle stirs it",
        measure: "wall-work:piston",
        example: "piston",
    },
    Exhibit {
        name: "conduction",
        about: "A gas of many sizes conducts heat from a hot wall to a cold one",
        measure: "wall-heat:hot",
        example: "conduction",
    },
    Exhibit {
        name: "tracer",
        about: "A dumbbell among light and heavy discs at one temperature",
        measure: "velocities:light",
        example: "measures",
    },
];

/// The scene of this name, with the text of its file.
///
/// # Errors
/// There is none.
pub fn scene(name: &str) -> Result<(&'static str, Scene)> {
    let exhibit = EXHIBITS.iter().find(|exhibit| exhibit.name == name);
    let exhibit = exhibit.with_context(|| format!("the gallery has no scene {name:?}"))?;
    let text = Example::named(exhibit.example)?.text;
    let scene =
        Scene::from_toml(text).with_context(|| format!("the scene {name:?} of the gallery"))?;
    Ok((text, scene))
}

/// The longer side of a small picture (pixels).
const THUMBNAIL: u32 = 160;

/// The start of a scene of the gallery as a small picture (SVG), which is drawn once;
/// `None` if the gallery has no scene of this name.
///
/// # Errors
/// The scene cannot be placed.
pub fn thumbnail(name: &str) -> Result<Option<&'static str>> {
    static DRAWN: [OnceLock<String>; EXHIBITS.len()] = [const { OnceLock::new() }; EXHIBITS.len()];
    let Some(index) = EXHIBITS.iter().position(|exhibit| exhibit.name == name) else {
        return Ok(None);
    };
    if let Some(picture) = DRAWN[index].get() {
        return Ok(Some(picture));
    }
    let run = InteractiveRun::new(&scene(name)?.1)?;
    Ok(Some(
        DRAWN[index].get_or_init(|| picture_of(&run.view(), THUMBNAIL)),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::{EpochTime, engine::MeasureSpec};
    use carom_runs::measures::SingleMeasure;

    #[test]
    fn every_scene_runs_and_has_its_measure_and_a_small_picture() {
        for exhibit in EXHIBITS {
            let (_, scene) = scene(exhibit.name).unwrap();
            let mut run = InteractiveRun::new(&scene).unwrap();
            let (kind, of) = exhibit
                .measure
                .split_once(':')
                .map_or((exhibit.measure, None), |(k, t)| (k, Some(t)));
            let of = of.map(str::to_owned);
            let spec = MeasureSpec {
                kind: kind.to_owned(),
                of,
                ..MeasureSpec::default()
            };
            let interval = scene.run.sample_interval;
            SingleMeasure::new(&spec, interval, &scene, &run.view()).unwrap();
            run.advance(EpochTime::from(1e-3 * scene.run.until), &mut ())
                .unwrap();
            assert!(
                thumbnail(exhibit.name).unwrap().unwrap().len() < 500_000,
                "{}",
                exhibit.name
            );
        }
    }
}
