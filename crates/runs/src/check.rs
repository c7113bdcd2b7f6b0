//! `carom check`: validates a scene file, lists its content, and estimates the duration of the run.

use std::{
    collections::BTreeMap,
    fmt::{self, Write as _},
};

use anyhow::{Context, Result};
use carom::{Scene, Simulation, View, engine::Body};
use carom_tables::Verdict;
use clap::Args;
use cpu_time::ProcessTime;

use crate::{run::SceneFile, sampling_times::sampling_times, say};

/// Processor time of the trial run for the estimate (seconds).
const TRIAL_SECONDS: f64 = 1.0;

/// The trial run ends after this many contacts at the latest.
const TRIAL_CONTACTS: u64 = 200_000;

/// Options of `carom check`.
#[derive(Debug, Clone, Args)]
pub struct Options {
    /// The scene file and changes to it
    #[command(flatten)]
    pub file: SceneFile,
}

/// Reads a scene, places its molecules, runs it for about a second, and prints its content and
/// cost.
///
/// # Errors
/// The scene is invalid, with the entry concerned.
pub fn run(options: &Options) -> Result<Verdict> {
    let name = options.file.path.display();
    let scene = options.file.read()?;
    let mut simulation = Simulation::new(&scene).with_context(|| format!("scene {name}"))?;
    crate::run::gas::observers(&scene.run, &simulation.view())?;
    say(&format!("{name}: valid"));
    say(&contents(&scene, &simulation.view())?);
    say(&Trial::of(&mut simulation, scene.run.until)?.to_string());
    Ok(Verdict::Passed)
}

/// The content of the scene, one line for each kind of body.
fn contents(scene: &Scene, view: &View<'_>) -> Result<String> {
    let sides = view.bounds().sides();
    let mut text = format!("box      {} × {}, seed {}\n", sides.x, sides.y, scene.bounds.seed);
    let mut kinds: BTreeMap<String, usize> = BTreeMap::new();
    for body in view.bodies() {
        *kinds.entry(kind(view, body.body)).or_default() += 1;
    }
    for (kind, count) in &kinds {
        writeln!(text, "{count:<8} {kind}")?;
    }
    let moving = || view.bodies().filter(|body| !body.body.is_fixed());
    let area: f64 = view.bodies().map(|body| body.body.molecule().area()).sum();
    let turning = moving().filter(|body| !body.body.is_locked() && body.body.molecule().atoms().len() > 1);
    writeln!(
        text,
        "moving   {} bodies, {} of which turn; area fraction of all bodies {:.4}",
        moving().count(),
        turning.count(),
        area / (sides.x * sides.y)
    )?;
    let temperature = view.temperature().map_or_else(String::new, |kt| format!(", kT {kt:.6}"));
    let momentum = view.momentum();
    writeln!(
        text,
        "start    energy {:.6}{temperature}, momentum ({:.3e}, {:.3e})",
        view.energy(),
        momentum.x,
        momentum.y
    )?;
    let run = &scene.run;
    let samples = sampling_times(0.0, run.until, run.sample_interval).count();
    write!(text, "run      to t = {}, {samples} samples", run.until)?;
    if !run.observe.is_empty() {
        write!(text, " of {}", run.observe.join(", "))?;
    }
    Ok(text)
}

/// Description of a kind of body: tags, shape, size, mass, and whether it moves and turns.
fn kind(view: &View<'_>, body: &Body) -> String {
    let molecule = body.molecule();
    let tags: Vec<&str> = body.tags().iter().map(|&tag| view.tag_names().name(tag)).collect();
    let tags = if tags.is_empty() { "untagged".to_owned() } else { tags.join("+") };
    let shape = match (body.is_wall(), molecule.atoms().len()) {
        (true, _) => "wall".to_owned(),
        (false, 1) => format!("disc of radius {}", molecule.bounding_radius()),
        (false, atoms) => {
            format!("molecule of {atoms} atoms, bounding radius {:.6}", molecule.bounding_radius())
        }
    };
    let motion = match (body.is_fixed(), body.is_locked()) {
        (true, _) => "fixed".to_owned(),
        (false, true) => format!("mass {}, does not turn", molecule.mass()),
        (false, false) => format!("mass {}", molecule.mass()),
    };
    format!("{tags}: {shape}, {motion}")
}

/// A trial run and the estimate for the whole run.
#[derive(Debug, Clone, Copy)]
struct Trial {
    contacts: u64,
    simulated: f64,
    seconds: f64,
    until: f64,
}

impl Trial {
    /// Runs until the end, for [`TRIAL_SECONDS`], or for [`TRIAL_CONTACTS`].
    fn of(simulation: &mut Simulation, until: f64) -> Result<Self> {
        let begun = ProcessTime::now();
        let seconds = || begun.elapsed().as_secs_f64();
        while simulation.view().counters().collisions < TRIAL_CONTACTS && seconds() < TRIAL_SECONDS {
            if !simulation.step(until, &mut ()).context("the run fails")? {
                break;
            }
        }
        let contacts = simulation.view().counters().collisions;
        Ok(Self { contacts, simulated: simulation.time().to_f64(), seconds: seconds(), until })
    }
}

impl fmt::Display for Trial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { contacts, simulated, seconds, until } = *self;
        if simulated >= until {
            return write!(
                f,
                "cost     {contacts} collisions, {seconds:.2} s of processor time (the whole run)"
            );
        }
        let more = until / simulated;
        write!(
            f,
            "cost     about {:.1e} collisions and {:.1e} s of processor time, from {contacts} collisions to t = {simulated:.3e}",
            contacts as f64 * more,
            seconds * more
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(text: &str) -> Scene {
        Scene::from_toml(text).unwrap()
    }

    #[test]
    fn kinds_are_counted_and_their_areas_are_summed() {
        let scene = scene(
            "[[gas]]\ntags = [\"gas\"]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 100\n\
             [[molecule]]\nshape = \"tee\"\natom_radius = 0.02\nat = [0.5, 0.5]\n\
             [[bumper]]\nradius = 0.05\nat = [0.1, 0.1]\n[run]\nuntil = 2.0\nsample_interval = 0.5\n",
        );
        let simulation = Simulation::new(&scene).unwrap();
        let text = contents(&scene, &simulation.view()).unwrap();
        assert!(text.contains("100      gas: disc of radius 0.01, mass 1\n"), "{text}");
        assert!(text.contains("molecule of 5 atoms") && text.contains("fixed"), "{text}");
        assert!(text.contains("101 bodies, 1 of which turn"), "{text}");
        assert!(text.contains("to t = 2, 4 samples"), "{text}");
        // π (100 · 0.01² + 5 · 0.02² + 0.05²)
        assert!(text.contains("area fraction of all bodies 0.0456"), "{text}");
    }

    #[test]
    fn a_short_run_is_counted_in_full_and_a_long_run_is_extrapolated() {
        let scene = scene("[box]\nseed = 5\n[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 200\n");
        let short = Trial::of(&mut Simulation::new(&scene).unwrap(), 0.5).unwrap();
        let mut run = Simulation::new(&scene).unwrap();
        run.run_until(0.5).unwrap();
        assert_eq!(short.contacts, run.view().counters().collisions);
        assert!(short.to_string().contains("the whole run"));
        let long = Trial::of(&mut Simulation::new(&scene).unwrap(), 1e9).unwrap();
        assert!(long.contacts <= TRIAL_CONTACTS && long.simulated < 1e9);
        assert!(long.to_string().contains("about"));
    }
}
