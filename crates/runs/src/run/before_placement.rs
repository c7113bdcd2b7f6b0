//! What can be refused before bodies are placed: measures of bodies that are not there, and a
//! figure that no measure has. A dense start may take minutes.

use anyhow::{Result, ensure};
use carom::{
    Scene,
    engine::{Placement, did_you_mean},
};
use carom_methods::AnySimulation;
use carom_tables::without_numbers;

use crate::measures::{FAR_DENSITY, Measures, requests};
use crate::schedule::{stage_edits, stages};

/// Molecules of each gas in the scene with which measures are tried.
const SAMPLE: usize = 2;

/// Refuses what the scene cannot measure.
///
/// # Errors
/// A measure cannot begin, or no measure has the figure of `[run.stop]`.
pub(super) fn refuse(scene: &Scene) -> Result<()> {
    refuse_unknown_figure(scene)?;
    // A scene without gases is placed at once, and the places of a frame are given.
    if scene.gas.is_empty() || scene.start.from.is_some() || scene.start.snapshot.is_some() {
        return Ok(());
    }
    // Tags of the first so many bodies, or of one by its number, are those of the whole scene.
    let counts = scene.stage.first().is_some_and(|stage| {
        stage
            .tag
            .iter()
            .chain(&stage.untag)
            .any(|relabel| relabel.count.is_some() || relabel.body.is_some())
    });
    if counts {
        return Ok(());
    }
    let Some(sample) = sample(scene) else {
        return Ok(());
    };
    // Other errors are reported where the whole scene is built.
    let Ok(mut simulation) = AnySimulation::new(&sample) else {
        return Ok(());
    };
    if stage_edits::prepare(&mut simulation, &sample, 0).is_err() {
        return Ok(());
    }
    Measures::new(&sample, &simulation.view()).map(drop)
}

/// The scene with at most two molecules of each gas; `None` if their number is not known.
fn sample(scene: &Scene) -> Option<Scene> {
    let mut sample = scene.clone();
    sample.start.placement = Some(Placement::Lattice);
    sample.start.relax = None;
    for index in 0..scene.gas.len() {
        let alone = Scene {
            gas: vec![scene.gas[index].clone()],
            bounds: scene.bounds.clone(),
            ..Scene::default()
        };
        let count = alone.expected_bodies().ok()?;
        (sample.gas[index].count, sample.gas[index].area_fraction) =
            (Some(count.min(SAMPLE)), None);
    }
    Some(sample)
}

/// Whether a figure of a measure cannot end the run of a scene.
fn is_unavailable(figure: &str, scene: &Scene) -> bool {
    // The first takes the theory of the gas, which is not asked while a run goes on.
    figure.starts_with("apparent diffusion coefficient, from lags")
        || figure == FAR_DENSITY && stages::falls(scene)
}

/// Refuses the name of a figure in `[run.stop]` that no measure of the scene can have.
fn refuse_unknown_figure(scene: &Scene) -> Result<()> {
    let Some(name) = scene
        .run
        .stop
        .as_ref()
        .and_then(|stop| stop.figure.as_ref())
    else {
        return Ok(());
    };
    let requests = requests(scene)?;
    let rate = crate::measures::COLLISION_RATE.to_owned();
    let mut known = vec![(rate.clone(), rate)];
    for request in &requests {
        let label = request.name.clone().or_else(|| request.tag());
        let end = label.map_or_else(String::new, |label| format!(", {label}"));
        known.extend(
            request
                .kind
                .figures
                .iter()
                .filter(|begin| !is_unavailable(begin, scene))
                .map(|begin| ((*begin).to_owned(), format!("{begin}{end}"))),
        );
    }
    let is_known = known.iter().any(|(begin, whole)| {
        let end = whole.strip_prefix(begin.as_str()).unwrap_or_default();
        // The heat of a thermostat is named by the tag that it heats.
        let begins = name.starts_with(begin) || without_numbers(name).starts_with(begin);
        begins && (name.ends_with(end) || begin.starts_with("heat given"))
    });
    let begins: Vec<String> = known
        .iter()
        .map(|(begin, _)| format!("'{begin}'"))
        .collect();
    ensure!(
        is_known,
        "run.stop.figure: no measure of this scene has a figure '{name}', but those that begin with {}{}",
        begins.join(", "),
        did_you_mean(name, known.iter().map(|(_, whole)| whole.as_str()))
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const GAS: &str =
        "[[gas]]\ntags = [\"gas\"]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\narea_fraction = 0.7\n";

    fn refused(more: &str) -> String {
        let scene = Scene::from_toml(&format!("{GAS}{more}")).unwrap();
        refuse(&scene).map_or_else(|error| format!("{error:#}"), |()| String::new())
    }

    #[test]
    fn figures_of_lags_are_named_without_them() {
        let stop = |figure: &str| {
            format!(
                "[run]\nobserve = [\"msd:gas\"]\n[run.stop]\nfigure = \"{figure}\"\nrelative_error = 0.1\n"
            )
        };
        for figure in [
            "diffusion coefficient at long lags, … to …, gas",
            "diffusion coefficient at long lags, 4 to 40, gas",
        ] {
            assert_eq!(refused(&stop(figure)), "");
        }
        let problem = refused(&stop("diffusion coefficient, gas"));
        assert!(
            problem.contains("'diffusion coefficient at long lags, … to …'"),
            "{problem}"
        );
    }

    #[test]
    fn measures_of_what_is_not_there_are_refused_without_placing_anything() {
        for (observe, expected) in [
            ("drift:gas", "several bodies carry that tag"),
            ("velocities:gass", "did you mean `gas`?"),
            ("contact-density:rod", "no gas of discs"),
        ] {
            let rods = "[[molecule]]\ntags = [\"rod\"]\nshape = \"rod:3\"\natom_radius = 0.01\natom_mass = 1.0\nat = [0.5, 0.5]\n";
            let more = if observe.ends_with(":rod") {
                let gas = "[[gas]]\nshape = \"rod:3\"\natom_radius = 0.003\natom_mass = 1.0\nenergy = 1.0\ncount = 5\n";
                let text = format!("{rods}{gas}[run]\nobserve = [\"{observe}\"]\n");
                format!(
                    "{:#}",
                    refuse(&Scene::from_toml(&text).unwrap()).unwrap_err()
                )
            } else {
                refused(&format!("[run]\nobserve = [\"{observe}\"]\n"))
            };
            assert!(more.contains(expected), "{observe}: {more}");
        }
        assert_eq!(
            refused("[run]\nobserve = [\"velocities:gas\", \"pressure\"]\n"),
            ""
        );
    }

    #[test]
    fn a_figure_that_no_measure_has_is_refused() {
        let stop = |observe: &str, figure: &str| {
            refused(&format!(
                "[run]\nobserve = [{observe}]\n[run.stop]\nfigure = \"{figure}\"\nrelative_error = 0.01\n"
            ))
        };
        let misspelt = stop("\"pressure\"", "presure");
        assert!(misspelt.contains("did you mean `pressure`?"), "{misspelt}");
        assert!(
            stop(
                "\"velocities:gas\"",
                "kurtosis of the velocities ⟨v⁴⟩/⟨v²⟩²"
            )
            .contains("no measure")
        );
        for (observe, figure) in [
            ("\"pressure\"", "compressibility factor βpA/N"),
            ("", "collisions per body that moves"),
            (
                "\"velocities:gas\"",
                "kurtosis of the velocities ⟨v⁴⟩/⟨v²⟩², gas",
            ),
            (
                "\"correlation:gas\"",
                "diffusion coefficient from velocities, up to lag 3.000, gas",
            ),
        ] {
            assert_eq!(stop(observe, figure), "", "{figure}");
        }
        // A gas that falls has no density of its bulk.
        let wall = |gravity: &str| {
            let scene = "[[wall]]\ny = 0.0\n[run]\nobserve = [\"wall-pressure\"]\n[run.stop]\n\
                         figure = \"density far from the walls\"\nrelative_error = 0.01\n";
            refused(&format!("{gravity}{scene}"))
        };
        assert_eq!(wall(""), "");
        assert!(wall("[gravity]\nacceleration = [0.0, -1.0]\n").contains("no measure"));
    }
}
