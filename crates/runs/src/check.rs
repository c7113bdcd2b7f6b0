//! `carom check`: validates a scene file, lists its content, and estimates the duration of the run.

use std::{
    collections::BTreeMap,
    fmt::{self, Write as _},
    path::Path,
};

use anyhow::{Context, Result};
use carom::{
    Scene, View,
    engine::{Body, Tag},
};
use carom_methods::{AnySimulation, Method};
use carom_report::page::with_error;
use carom_tables::Verdict;
use clap::Args;
use cpu_time::ProcessTime;

use crate::{
    print_line,
    run::{SceneFile, continued, parent::Parent, schedule::What, stage_edits, stages},
    sampling_times::sampling_times,
};

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
    let parent = Parent::find(options.file.from.as_deref(), Path::new(""), false)?;
    let scene = options.file.read(parent.as_ref())?;
    let method = Method::try_from(&scene.method)?;
    let mut simulation = match &parent {
        None => AnySimulation::new(&scene).with_context(|| format!("scene {name}"))?,
        Some(parent) => continued(parent, &scene, &method)?,
    };
    stage_edits::prepare(&mut simulation, &scene, 0)?;
    crate::run::outcome::observers(&scene, &simulation.view())?;
    print_line(&format!("{name}: valid"));
    print_line(&contents(&scene, &simulation.view())?);
    let trial = Trial::of(&mut simulation, scene.run.until)?;
    print_line(&trial.to_string());
    if let Some(actions) = Actions::of(&simulation, &scene)? {
        print_line(&actions.words(&trial));
    }
    Ok(Verdict::Passed)
}

/// The content of the scene, one line for each kind of body.
fn contents(scene: &Scene, view: &View<'_>) -> Result<String> {
    let sides = view.bounds().sides();
    let mut text = format!("box      {} × {}, seed {}\n", sides.x, sides.y, scene.bounds.seed);
    let method = Method::try_from(&scene.method)?;
    if method != Method::default() {
        let warning = if method.is_exact() { "" } else { ": NOT EXACT" };
        writeln!(text, "method   {method}{warning}")?;
    }
    let mut kinds: BTreeMap<String, usize> = BTreeMap::new();
    let mut groups: BTreeMap<Group<'_>, BTreeMap<String, Vec<&Body>>> = BTreeMap::new();
    for body in view.bodies().map(|view| view.body) {
        let likeness =
            (body.tags(), body.is_wall(), body.molecule().atoms().len(), body.is_fixed(), body.is_locked());
        groups.entry(likeness).or_default().entry(kind(view, body)).or_default().push(body);
    }
    for group in groups.into_values() {
        let bodies: Vec<&Body> = group.values().flatten().copied().collect();
        if group.len() > MOST_KINDS {
            kinds.insert(range(view, &bodies), bodies.len());
        } else {
            kinds.extend(group.into_iter().map(|(kind, bodies)| (kind, bodies.len())));
        }
    }
    for (kind, count) in &kinds {
        writeln!(text, "{count:<8} {kind}")?;
    }
    let moving = || view.bodies().filter(|body| !body.body.is_fixed());
    let area: f64 = view.bodies().map(|body| body.body.molecule().area()).sum();
    let turning = moving().filter(|body| !body.body.is_locked() && !body.body.molecule().is_round());
    writeln!(
        text,
        "moving   {} bodies, {} of which turn; area fraction of all bodies {:.4}",
        moving().count(),
        turning.count(),
        area / (sides.x * sides.y)
    )?;
    let temperature =
        view.temperature().map_or_else(String::new, |kt| format!(", kT {}", with_error(kt, None)));
    let momentum = view.momentum();
    writeln!(
        text,
        "start    energy {}{temperature}, momentum ({:.3e}, {:.3e})",
        with_error(view.energy(), None),
        momentum.x,
        momentum.y
    )?;
    let run = &scene.run;
    let samples = sampling_times(0.0, run.until, run.sample_interval).count();
    write!(text, "run      to t = {}, {samples} samples", run.until)?;
    if !run.observe.is_empty() {
        write!(text, " of {}", run.observe.join(", "))?;
    }
    for (index, stage) in stages::describe(scene).iter().enumerate() {
        write!(text, "\nstage {:<2} {stage}", index + 1)?;
    }
    Ok(text)
}

/// What bodies on one line have in common: tags, wall or not, number of atoms, fixed or not, and
/// locked or not.
type Group<'a> = (&'a [Tag], bool, usize, bool, bool);

/// More sizes and masses than this in one group, as drawn from a distribution, share a line.
const MOST_KINDS: usize = 8;

/// Description of many bodies of different sizes and masses: tags, means and ranges, and the share
/// of the box that they cover.
fn range(view: &View<'_>, bodies: &[&Body]) -> String {
    let first = bodies[0];
    let tags: Vec<&str> = first.tags().iter().map(|&tag| view.tag_names().name(tag)).collect();
    let tags = if tags.is_empty() { "untagged".to_owned() } else { tags.join("+") };
    let spread = |of: fn(&Body) -> f64| {
        let (mut least, mut most, mut sum) = (f64::INFINITY, 0.0f64, 0.0);
        for value in bodies.iter().map(|body| of(body)) {
            (least, most, sum) = (least.min(value), most.max(value), sum + value);
        }
        let mean = sum / bodies.len() as f64;
        format!("mean {}, from {} to {}", figures(mean), figures(least), figures(most))
    };
    let sizes = spread(|body| body.molecule().bounding_radius());
    let shape = match first.molecule().atoms().len() {
        1 => format!("discs of radius {sizes}"),
        atoms => format!("molecules of {atoms} atoms, bounding radius {sizes}"),
    };
    let motion = match (first.is_fixed(), first.is_locked()) {
        (true, _) => "fixed".to_owned(),
        (false, locked) => {
            let turns = if locked && first.molecule().atoms().len() > 1 { ", do not turn" } else { "" };
            format!("mass {}{turns}", spread(|body| body.molecule().mass()))
        }
    };
    let area: f64 = bodies.iter().map(|body| body.molecule().area()).sum();
    format!("{tags}: {shape}; {motion}; area fraction {:.4}", area / view.bounds().area())
}

/// A number with five significant digits.
fn figures(number: f64) -> String {
    let digits = 4 - number.abs().log10().floor().clamp(-4.0, 4.0) as i32;
    if (1e-3..1e5).contains(&number) {
        format!("{number:.*}", digits.max(0) as usize)
    } else {
        format!("{number:.4e}")
    }
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
            format!(
                "molecule of {atoms} atoms, bounding radius {}",
                with_error(molecule.bounding_radius(), None)
            )
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
    /// Contacts, simulated time and processor time (seconds) of the trial without its first step.
    contacts: u64,
    simulated: f64,
    seconds: f64,
    /// Processor time of the first step, which predicts all bodies (seconds).
    first: f64,
    until: f64,
    is_whole: bool,
}

impl Trial {
    /// Runs until the end, for [`TRIAL_SECONDS`], or for [`TRIAL_CONTACTS`].
    fn of(simulation: &mut AnySimulation, until: f64) -> Result<Self> {
        // A step without a contact doubles the time of the next, so that rare contacts take no
        // longer than twice the limit.
        let mut stretch = until / f64::from(1 << 20);
        let mut step = |simulation: &mut AnySimulation| -> Result<bool> {
            let limit = until.min(simulation.time().to_f64() + stretch);
            let has_contact = simulation.step(limit, &mut ()).context("the run fails")?;
            stretch *= if has_contact { 1.0 } else { 2.0 };
            Ok(!has_contact && limit >= until)
        };
        let clock = ProcessTime::now();
        let mut is_whole = step(simulation)?;
        let first = clock.elapsed().as_secs_f64();
        let (clock, start) = (ProcessTime::now(), simulation.time().to_f64());
        let before = simulation.view().counters().collisions;
        let mut contacts = 0;
        while !is_whole && contacts < TRIAL_CONTACTS && clock.elapsed().as_secs_f64() < TRIAL_SECONDS {
            is_whole = step(simulation)?;
            contacts = simulation.view().counters().collisions - before;
        }
        let simulated = simulation.time().to_f64() - start;
        let contacts = if is_whole { simulation.view().counters().collisions } else { contacts };
        Ok(Self { contacts, simulated, seconds: clock.elapsed().as_secs_f64(), first, until, is_whole })
    }
}

impl Trial {
    /// The estimate for the whole run without thermostats (seconds).
    fn whole_seconds(&self) -> Option<f64> {
        let Self { simulated, seconds, first, until, is_whole, .. } = *self;
        match (is_whole, simulated > 0.0) {
            (true, _) => Some(first + seconds),
            (false, true) => Some(first + seconds * until / simulated),
            (false, false) => None,
        }
    }
}

impl fmt::Display for Trial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { contacts, simulated, seconds, first, until, is_whole } = *self;
        if is_whole {
            let seconds = first + seconds;
            write!(f, "cost     {contacts} collisions, {seconds:.2} s of processor time (the whole run)")
        } else if simulated > 0.0 {
            let (more, all) = (until / simulated, first + seconds * until / simulated);
            write!(
                f,
                "cost     about {:.1e} collisions and {all:.1e} s of processor time, ",
                contacts as f64 * more
            )?;
            write!(f, "from {contacts} collisions in a time of {simulated:.3e}")
        } else {
            write!(
                f,
                "cost     no estimate: {contacts} collisions in {seconds:.1} s without progress in time"
            )
        }
    }
}

/// The cost of the actions of all thermostats.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Actions {
    count: u64,
    /// Number of motions set, if the tags keep their bodies.
    motions: u64,
    /// Processor time (seconds), including the prediction of all bodies after each action.
    seconds: f64,
}

impl Actions {
    /// Measures one action of each thermostat on a copy; `None` without thermostats.
    fn of(simulation: &AnySimulation, scene: &Scene) -> Result<Option<Self>> {
        let mut all = Self::default();
        for (stage, counts) in stages::action_counts(scene).iter().enumerate() {
            for (index, &count) in counts.iter().enumerate() {
                let mut copy = simulation.clone();
                let tag = copy.find_tag(&scene.stage[stage].thermostat[index].tag);
                let members = tag.map_or(0, |tag| copy.view().tagged(tag).count());
                let clock = ProcessTime::now();
                stage_edits::change(&mut copy, scene, What::Thermostat { stage, index }, 0)?;
                copy.run_until(copy.time().to_f64()).context("the run fails")?;
                all.seconds += count as f64 * clock.elapsed().as_secs_f64();
                all.count += count;
                all.motions += count * members as u64;
            }
        }
        Ok((all.count > 0).then_some(all))
    }

    fn words(&self, trial: &Trial) -> String {
        let Self { count, motions, seconds } = *self;
        let mut text =
            format!("actions  {count} of thermostats on {motions} bodies in all, about {seconds:.1e} s");
        if let Some(run) = trial.whole_seconds() {
            let share = 100.0 * seconds / (seconds + run).max(f64::MIN_POSITIVE);
            let _ = write!(text, ", {share:.1} % of the time");
        }
        text
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
             [[molecule]]\nshape = \"tee\"\natom_radius = 0.02\natom_mass = 1.0\nat = [0.5, 0.5]\n\
             [[bumper]]\nradius = 0.05\nat = [0.1, 0.1]\n[run]\nuntil = 2.0\nsample_interval = 0.5\n",
        );
        let simulation = AnySimulation::new(&scene).unwrap();
        let text = contents(&scene, &simulation.view()).unwrap();
        assert!(text.contains("100      gas: disc of radius 0.01, mass 1\n"), "{text}");
        assert!(text.contains("molecule of 5 atoms") && text.contains("fixed"), "{text}");
        assert!(text.contains("101 bodies, 1 of which turn"), "{text}");
        assert!(text.contains("to t = 2, 4 samples"), "{text}");
        // π (100 · 0.01² + 5 · 0.02² + 0.05²)
        assert!(text.contains("area fraction of all bodies 0.0456"), "{text}");
    }

    #[test]
    fn drawn_sizes_share_a_line_with_their_range() {
        let gas = "[[gas]]\nradius = { uniform = [0.01, 0.02] }\ndensity = 1.0\nenergy = 1.0\narea_fraction = 0.2\n";
        let scene = scene(gas);
        let simulation = AnySimulation::new(&scene).unwrap();
        let text = contents(&scene, &simulation.view()).unwrap();
        assert!(text.contains("untagged: discs of radius mean 0.01"), "{text}");
        assert!(text.contains("area fraction 0.2"), "{text}");
        assert!(text.lines().count() < 8, "{text}");
    }

    #[test]
    fn a_short_run_is_counted_in_full_and_a_long_run_is_extrapolated() {
        let scene = scene("[box]\nseed = 5\n[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 200\n");
        let short = Trial::of(&mut AnySimulation::new(&scene).unwrap(), 0.5).unwrap();
        let mut run = AnySimulation::new(&scene).unwrap();
        run.run_until(0.5).unwrap();
        assert_eq!(short.contacts, run.view().counters().collisions);
        assert!(short.to_string().contains("the whole run"));
        let long = Trial::of(&mut AnySimulation::new(&scene).unwrap(), 1e9).unwrap();
        assert!(long.contacts <= TRIAL_CONTACTS && long.simulated < 1e9);
        assert!(long.to_string().contains("about"));
    }
}
