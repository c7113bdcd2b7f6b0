//! The points of a study as settings: the same molecule, or another, in another gas at each point.

use anyhow::{Context, Result, ensure};
use carom::Scene;
use carom_sweeps::Study;

use super::{
    plan::Plan,
    setting::{Setting, words},
};

/// A setting for each point of the study; `body_of` finds the molecule of a scene, by its index.
///
/// Replicas have the seed of the command, not those of `carom sweep`.
///
/// # Errors
/// A scene lacks the molecule, or is without equilibrium; the message names the point.
pub fn settings_of(study: &Study, body_of: impl Fn(&Scene) -> Result<usize>) -> Result<Vec<Setting>> {
    let mut settings: Vec<Setting> = Vec::new();
    for (index, point) in study.points.iter().enumerate() {
        let setting = || -> Result<Setting> {
            let scene = point.scene.clone();
            let body = body_of(&scene)?;
            let spec = &scene.molecule[body];
            let words = words(&spec.molecule("molecule")?, spec);
            let of_scene = || "the scene".to_owned();
            let is_one = study.vary.is_empty();
            let name = file_name(&if is_one { of_scene() } else { study.name(index) });
            let title = if is_one { of_scene() } else { title(study, index) };
            let setting = Setting { name, title, words, scene, body };
            setting.check()?;
            Ok(setting)
        };
        let setting = setting().with_context(|| format!("point {}", point.label))?;
        if let Some(same) = settings.iter().find(|other| other.name == setting.name) {
            anyhow::bail!(
                "the points {} and {} would have the same folder, {}: give the values `names`",
                same.title,
                setting.title,
                setting.name
            );
        }
        settings.push(setting);
    }
    Ok(settings)
}

/// The times of all settings.
///
/// # Errors
/// They differ.
pub fn common_plan(settings: &[Setting]) -> Result<Plan> {
    let mut plans = settings.iter().map(|setting| Plan::of(&setting.scene.run));
    let plan = plans.next().context("the study has no points")?;
    ensure!(
        plans.all(|other| other == plan),
        "run.until, run.sample_interval and run.measure_from must be the same at all points of the study"
    );
    Ok(plan)
}

/// The point in words, such as `tee, atom_mass 0.2`: names and other texts stand for themselves, a
/// number has the name of its key before it.
fn title(study: &Study, point: usize) -> String {
    let words = |entry: usize| -> Vec<String> {
        let vary = &study.vary[entry];
        let cells = vary.cells(study.setting(point, entry));
        if vary.names.is_some() {
            return cells;
        }
        let key = |path: &String| path.rsplit('.').next().unwrap_or(path).to_owned();
        let with_key = |(path, cell): (&String, String)| match cell.parse::<f64>() {
            Ok(_) => format!("{} {cell}", key(path)),
            Err(_) => cell,
        };
        vary.keys.iter().zip(cells).map(with_key).collect()
    };
    (0..study.vary.len()).flat_map(words).collect::<Vec<_>>().join(", ")
}

/// The name of a folder: letters, digits, dots, hyphens and underscores.
fn file_name(title: &str) -> String {
    let words = title.split(|c: char| !(c.is_alphanumeric() || ".-_".contains(c)));
    words.filter(|word| !word.is_empty()).collect::<Vec<_>>().join("-")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    const STUDY: &str = "[[vary]]\nkeys = [\"molecule.0.shape\", \"molecule.0.atom_mass\"]\n\
                         values = [[\"tee\", 0.2], [\"rod:4\", 0.25]]\n\
                         [[vary]]\nkey = \"gas.0.area_fraction\"\nvalues = [0.1, 0.2]\n\
                         [[scene.molecule]]\ntags = [\"probe\"]\nshape = \"tee\"\natom_radius = 0.01\n\
                         atom_mass = 1.0\nat = [0.5, 0.5]\n[[scene.gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\n\
                         [[scene.bumper]]\nradius = 0.01\nat = [0.1, 0.1]\n\
                         [scene.run]\nuntil = 4.0\nsample_interval = 0.5\nmeasure_from = 1.0\n";

    fn settings(text: &str) -> Result<Vec<Setting>> {
        settings_of(&Study::parse(text, Path::new(""), carom_sweeps::Size::default())?, |_| Ok(0))
    }

    #[test]
    fn each_point_is_a_setting_with_a_folder_of_its_own() {
        let settings = settings(STUDY).unwrap();
        let names: Vec<&str> = settings.iter().map(|setting| setting.name.as_str()).collect();
        assert_eq!(names, ["tee-0.2-0.1", "tee-0.2-0.2", "rod-4-0.25-0.1", "rod-4-0.25-0.2"]);
        // A number alone would say nothing in a title.
        assert_eq!(settings[1].title, "tee, atom_mass 0.2, area_fraction 0.2");
        let named = self::settings(&STUDY.replace("[0.1, 0.2]", "[0.1, 0.2]\nnames = [\"1\", \"dense\"]"));
        assert_eq!(named.unwrap()[2].title, "rod:4, atom_mass 0.25, 1");
        assert_eq!(settings[3].scene.gas[0].area_fraction, Some(0.2));
        assert_eq!(settings[2].words, "rod:4, 4 discs of mass 1, rotating freely");
        assert_eq!(common_plan(&settings).unwrap(), Plan { from: 1.0, until: 4.0, sample_interval: 0.5 });
    }

    #[test]
    fn a_study_without_equilibrium_or_with_several_times_is_refused() {
        let error = |text: &str| {
            let plan = settings(text).and_then(|settings| common_plan(&settings));
            format!("{:#}", plan.unwrap_err())
        };
        let times = STUDY.replace("gas.0.area_fraction", "run.until").replace("[0.1, 0.2]", "[2.0, 3.0]");
        assert!(error(&times).contains("run.until"));
        let inelastic = format!("{STUDY}[scene.elasticity]\ndefault = 0.9\n");
        assert!(error(&inelastic).contains("elasticity: it must be 1"), "{}", error(&inelastic));
        let same = STUDY.replace("[\"rod:4\", 0.25]", "[\"tee\", 0.3]").replace(
            "[0.1, 0.2]",
            "[0.1, 0.2]\n[[vary]]\nkey = \"molecule.0.tags\"\nvalues = [[\"a b\"], [\"a,b\"]]",
        );
        assert!(error(&same).contains("give the values `names`"), "{}", error(&same));
    }
}
