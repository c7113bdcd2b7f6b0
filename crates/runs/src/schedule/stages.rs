//! The stages of a run: their validation, the part that is measured, and their description.

use std::collections::BTreeSet;

use anyhow::{Context, Result, ensure};
use carom::{
    Scene,
    engine::{
        ElasticitySpec, ReactionSpec, StageSpec, ThermostatKind, ThermostatSpec, VelocitySpec,
        WallMotionSpec, did_you_mean,
    },
};

use super::{actions, spans};
use crate::sampling_times::sampling_times;

/// Largest number of actions of the thermostats of a run; more are refused as a mistake.
pub(crate) const MAX_ACTIONS: f64 = 1e7;

/// Rounding of the times of samples, as a share of the time.
const ROUNDING: f64 = 1e-9;

/// Validates the stages without their effect on the bodies, see
/// [`stage_edits`](super::stage_edits).
///
/// # Errors
/// A time or energy is out of range, a tag is carried by no body, or keys contradict each other.
pub fn check(scene: &Scene) -> Result<()> {
    let (run, stages) = (&scene.run, &scene.stage);
    let Some(last) = stages.last() else {
        return Ok(());
    };
    ensure!(
        run.until == last.until,
        "run.until = {} differs from the end of the last stage, {}",
        run.until,
        last.until
    );
    ensure!(
        run.measure_from.is_start(),
        "run.measure_from cannot be given with [[stage]]: give the first stages `measure = false` instead"
    );
    for (index, (stage, span)) in stages.iter().zip(spans(stages)).enumerate() {
        check_times(stage, span).with_context(|| format!("stage[{index}]"))?;
        let both = stage.lock.iter().find(|tag| stage.unlock.contains(tag));
        ensure!(
            both.is_none(),
            "stage[{index}]: the tag {:?} is in `lock` and in `unlock`",
            both.map_or("", String::as_str)
        );
        let relabels = [("tag", &stage.tag), ("untag", &stage.untag)];
        for (entry, list) in relabels {
            for (number, relabel) in list.iter().enumerate() {
                ensure!(
                    relabel.body.is_none() || relabel.of.is_empty() && relabel.count.is_none(),
                    "stage[{index}].{entry}[{number}]: `body` excludes `of` and `count`"
                );
            }
        }
        stage.drag_clock(&format!("stage[{index}]"))?;
        stage.gravity(&format!("stage[{index}]"))?;
        stage.check_shear_rate(&format!("stage[{index}]"))?;
        for (number, heat) in stage.set_energy.iter().enumerate() {
            heat.rule(&format!("stage[{index}].set_energy[{number}]"))?;
        }
        for (number, set) in stage.set_velocity.iter().enumerate() {
            check_velocity(set)
                .with_context(|| format!("stage[{index}].set_velocity[{number}]"))?;
        }
        for (number, thermostat) in stage.thermostat.iter().enumerate() {
            thermostat.rule(&format!("stage[{index}].thermostat[{number}]"))?;
        }
    }
    check_measured(scene)
}

/// Refuses a velocity of no body or of two kinds of bodies, and an entry that sets nothing.
fn check_velocity(set: &VelocitySpec) -> Result<()> {
    ensure!(
        set.tag.is_empty() == set.body.is_some(),
        "give either `tag` or `body`"
    );
    ensure!(
        set.velocity.is_some() || set.angular_velocity.is_some(),
        "give `velocity = [x, y]`, `angular_velocity` or both"
    );
    Ok(())
}

fn check_times(stage: &StageSpec, span: (f64, f64)) -> Result<()> {
    let (start, end) = span;
    ensure!(
        end.is_finite() && end > start,
        "`until` must be finite and later than the start of the stage, {start:?}, but is {end:?}"
    );
    for (index, thermostat) in stage.thermostat.iter().enumerate() {
        let every = thermostat.every;
        ensure!(
            every.is_finite() && every > 0.0,
            "thermostat[{index}].every must be positive and finite, but is {every:?}"
        );
        ensure!(
            (end - start) / every <= MAX_ACTIONS,
            "thermostat[{index}].every = {every} gives more than {MAX_ACTIONS:e} actions in this stage"
        );
    }
    Ok(())
}

/// Refuses measured stages with others between them, or too short for a sample interval.
fn check_measured(scene: &Scene) -> Result<()> {
    let measured: Vec<usize> = (0..scene.stage.len())
        .filter(|&index| scene.stage[index].measure)
        .collect();
    let gap = measured.windows(2).find(|pair| pair[1] != pair[0] + 1);
    if let Some(pair) = gap {
        anyhow::bail!(
            "stage[{}]: stages that are measured must follow on one another, but stage[{}] before it is not \
             measured: use a run of its own for each, the second by `carom run --from`",
            pair[1],
            pair[1] - 1
        );
    }
    ensure!(
        measured.is_empty() || is_sampled(scene),
        "stage[{}]: the measured stages leave no interval of run.sample_interval = {}",
        measured[0],
        scene.run.sample_interval
    );
    Ok(())
}

/// Whether the part that is measured is as long as a sample interval.
pub fn is_sampled(scene: &Scene) -> bool {
    let (from, last) = window(scene);
    from + scene.run.sample_interval * (1.0 - ROUNDING) <= last.min(scene.run.until)
}

/// The time from which on a run is measured, and the time of the last sample that is measured; that
/// is infinite if the run is measured to its end.
pub fn window(scene: &Scene) -> (f64, f64) {
    if scene.stage.is_empty() {
        return (scene.run.measure_from.time().unwrap_or(0.0), f64::INFINITY);
    }
    let mut measured = scene
        .stage
        .iter()
        .zip(spans(&scene.stage))
        .filter(|(stage, _)| stage.measure);
    let Some((_, (from, first_end))) = measured.next() else {
        return (f64::INFINITY, f64::INFINITY);
    };
    let end = measured.last().map_or(first_end, |(_, (_, end))| end);
    if end >= scene.run.until {
        return (from, f64::INFINITY);
    }
    let times = sampling_times(0.0, scene.run.until, scene.run.sample_interval);
    (
        from,
        times
            .take_while(|time| *time <= end * (1.0 + ROUNDING))
            .last()
            .unwrap_or(0.0),
    )
}

/// The rules of elasticity in force in the measured part of a run.
pub fn measured_elasticities(scene: &Scene) -> Vec<&ElasticitySpec> {
    let mut in_force = &scene.elasticity;
    let mut measured = Vec::new();
    for stage in &scene.stage {
        in_force = stage.elasticity.as_ref().unwrap_or(in_force);
        if stage.measure {
            measured.push(in_force);
        }
    }
    if measured.is_empty() {
        vec![in_force]
    } else {
        measured
    }
}

/// Whether nothing changes the energy of the system but a start that is not yet in equilibrium.
pub fn is_equilibrium(scene: &Scene) -> bool {
    scene.elasticity.is_elastic() && !scene.has_heated_walls() && is_disturbed(scene).is_none()
}

/// The reason why no theory of a gas that is left alone predicts what is measured; `None` if
/// nothing changes the system after the start of the measured part.
pub fn is_disturbed(scene: &Scene) -> Option<&'static str> {
    if is_dragged(scene) {
        return Some("a drag slows the bodies");
    }
    if falls(scene) {
        return Some("bodies fall");
    }
    if moves_walls(scene) {
        return Some("walls move");
    }
    if is_sheared(scene) {
        return Some("the gas is sheared");
    }
    if reacts(scene) {
        return Some("bodies react");
    }
    if scene
        .piston
        .iter()
        .any(|piston| piston.stop_elasticity < 1.0)
    {
        return Some("stops of a piston take energy");
    }
    let first = scene.stage.iter().position(|stage| stage.measure)?;
    let stages = scene.stage.iter().enumerate().skip(first);
    let mut reasons = stages.filter_map(|(index, stage)| {
        let is_edited = index > first && has_edits(stage);
        let is_heated = !stage.thermostat.is_empty();
        is_edited
            .then_some("the system is edited after the start of the measurement")
            .or(is_heated.then_some("thermostats act after the start of the measurement"))
    });
    reasons.next()
}

/// Whether a drag acts in the measured part of a run.
pub fn is_dragged(scene: &Scene) -> bool {
    acts(
        scene,
        scene.bounds.drag,
        |stage| stage.drag,
        |drag| drag > 0.0,
    )
}

/// Whether a gravity acts in the measured part of a run.
pub fn falls(scene: &Scene) -> bool {
    let gravity = scene.gravity.acceleration;
    acts(
        scene,
        gravity,
        |stage| stage.gravity,
        |gravity| gravity != [0.0; 2],
    )
}

/// Whether a shear acts in the measured part of a run.
pub fn is_sheared(scene: &Scene) -> bool {
    acts(
        scene,
        scene.bounds.shear_rate,
        |stage| stage.shear_rate,
        |rate| rate != 0.0,
    )
}

/// Whether a shear has acted before the end of a run: images are then displaced.
pub fn is_ever_sheared(scene: &Scene) -> bool {
    let of_stages = scene.stage.iter().filter_map(|stage| stage.shear_rate);
    of_stages
        .chain([scene.bounds.shear_rate])
        .any(|rate| rate != 0.0)
}

/// Whether discs have wells at some time of a run.
pub fn has_wells(scene: &Scene) -> bool {
    let of_stages = scene.stage.iter().flat_map(|stage| &stage.well);
    of_stages
        .chain([&scene.well])
        .any(|wells| !wells.is_empty())
}

/// Whether reactions are in force in the measured part of a run.
pub fn reacts(scene: &Scene) -> bool {
    let rules = |stage: &'_ StageSpec| stage.reaction.as_ref().map(|rules| !rules.is_empty());
    acts(scene, !scene.reaction.is_empty(), rules, |acts| acts)
}

/// Whether an elasticity of which this holds rules contacts in the measured part of a run.
pub fn has_elasticity(scene: &Scene, holds: impl Fn(&ElasticitySpec) -> bool) -> bool {
    acts(
        scene,
        &scene.elasticity,
        |stage| stage.elasticity.as_ref(),
        holds,
    )
}

/// What changes motions or bodies within the measured part of a run, besides contacts; `None` if
/// nothing does.
pub fn resets(scene: &Scene) -> Option<&'static str> {
    if reacts(scene) {
        return Some("reactions");
    }
    let mut measured = scene.stage.iter().filter(|stage| stage.measure);
    let first = measured.next()?;
    // What the first one sets of the free bodies is set before the measurement.
    driven(first).or_else(|| measured.find_map(|stage| driven(stage).or_else(|| edited(stage))))
}

/// What acts on bodies during a stage, or adds what may.
fn driven(stage: &StageSpec) -> Option<&'static str> {
    of_first_given([
        (!stage.thermostat.is_empty(), "a thermostat"),
        (!stage.move_wall.is_empty(), "move_wall"),
        (!stage.push_piston.is_empty(), "push_piston"),
        (!stage.add_wall.is_empty(), "add_wall"),
        (!stage.add.is_empty(), "add"),
        (stage.drag.is_some_and(|drag| drag > 0.0), "a drag"),
    ])
}

/// What changes the free bodies at the start of a stage.
fn edited(stage: &StageSpec) -> Option<&'static str> {
    of_first_given([
        (!stage.set_energy.is_empty(), "set_energy"),
        (!stage.set_velocity.is_empty(), "set_velocity"),
        (!stage.remove.is_empty(), "remove"),
        (!stage.lock.is_empty(), "lock"),
        (!stage.unlock.is_empty(), "unlock"),
    ])
}

/// The name of the first key that is given.
fn of_first_given<const N: usize>(keys: [(bool, &'static str); N]) -> Option<&'static str> {
    keys.into_iter()
        .find_map(|(is_given, name)| is_given.then_some(name))
}

/// Whether a quantity with this value at the start, which stages may replace, acts in the measured
/// part of a run.
fn acts<'a, T: Copy>(
    scene: &'a Scene,
    start: T,
    replaced: impl Fn(&'a StageSpec) -> Option<T>,
    is_active: impl Fn(T) -> bool,
) -> bool {
    if scene.stage.is_empty() {
        return is_active(start);
    }
    let mut value = start;
    scene.stage.iter().any(|stage| {
        value = replaced(stage).unwrap_or(value);
        stage.measure && is_active(value)
    })
}

/// Whether any wall moves at any time.
pub fn moves_walls(scene: &Scene) -> bool {
    let added = scene.stage.iter().flat_map(|stage| &stage.add_wall);
    let of_stages = scene.stage.iter().flat_map(|stage| &stage.move_wall);
    let walls = scene.wall.iter().chain(added);
    let motions = walls.filter_map(|wall| wall.motion.as_ref());
    motions
        .chain(of_stages.map(|set| &set.motion))
        .any(|motion| *motion != WallMotionSpec::default())
}

/// Whether a thermostat drives bodies along axes of their own.
pub fn drives_axes(scene: &Scene) -> bool {
    let mut thermostats = scene.stage.iter().flat_map(|stage| &stage.thermostat);
    thermostats.any(|thermostat| thermostat.kind == ThermostatKind::Active)
}

fn has_edits(stage: &StageSpec) -> bool {
    let StageSpec {
        name,
        until,
        measure,
        thermostat,
        ..
    } = StageSpec::default();
    StageSpec {
        name,
        until,
        measure,
        thermostat,
        ..stage.clone()
    } != StageSpec::default()
}

/// Refuses tags that no body carries when a stage needs them: a misspelt tag would change the
/// physics. `carried` are the tags of the bodies at the start.
///
/// # Errors
/// A tag is not carried, with its entry.
pub fn refuse_unknown_tags(scene: &Scene, carried: impl IntoIterator<Item = String>) -> Result<()> {
    let mut carried: BTreeSet<String> = carried.into_iter().collect();
    let given = scene.reaction.iter().flat_map(ReactionSpec::given_tags);
    carried.extend(given.cloned());
    refuse_unknown_rules("elasticity", &scene.elasticity, &carried)?;
    for (index, stage) in scene.stage.iter().enumerate() {
        CarriedTags {
            stage: index,
            tags: &mut carried,
        }
        .follow(stage)?;
    }
    Ok(())
}

/// The tags that bodies carry in a stage.
struct CarriedTags<'a> {
    /// Index of the stage.
    stage: usize,
    tags: &'a mut BTreeSet<String>,
}

impl CarriedTags<'_> {
    /// Adds the tags that the stage gives, and refuses those that it needs but no body carries, in
    /// the order of its edits.
    fn follow(&mut self, stage: &StageSpec) -> Result<()> {
        let reactions = stage.reaction.iter().flatten();
        self.add(reactions.flat_map(ReactionSpec::given_tags));
        self.require_all("remove", &stage.remove)?;
        self.add(stage.add.iter().flat_map(|molecule| &molecule.tags));
        self.add(stage.add_wall.iter().flat_map(|wall| &wall.tags));
        self.require_each("move_wall", stage.move_wall.iter().map(|set| &set.tag))?;
        self.require_each("push_piston", stage.push_piston.iter().map(|set| &set.tag))?;
        for (number, relabel) in stage.tag.iter().enumerate() {
            self.require_if_given(&format!("tag[{number}]"), &relabel.of)?;
            self.add([&relabel.name]);
        }
        for (number, relabel) in stage.untag.iter().enumerate() {
            let entry = format!("untag[{number}]");
            self.require_if_given(&entry, &relabel.of)?;
            self.require(&entry, &relabel.name)?;
        }
        if let Some(elasticity) = &stage.elasticity {
            let entry = format!("stage[{}].elasticity", self.stage);
            refuse_unknown_rules(&entry, elasticity, self.tags)?;
        }
        self.require_all("unbond", &stage.unbond)?;
        self.require_all("lock", &stage.lock)?;
        self.require_all("unlock", &stage.unlock)?;
        self.require_each("set_energy", stage.set_energy.iter().map(|heat| &heat.tag))?;
        for (number, set) in stage.set_velocity.iter().enumerate() {
            self.require_if_given(&format!("set_velocity[{number}]"), &set.tag)?;
        }
        self.require_each("thermostat", stage.thermostat.iter().map(|one| &one.tag))
    }

    fn add<'a>(&mut self, tags: impl IntoIterator<Item = &'a String>) {
        self.tags.extend(tags.into_iter().cloned());
    }

    /// Refuses a tag that no body carries.
    fn require(&self, entry: &str, tag: &str) -> Result<()> {
        ensure!(
            self.tags.contains(tag),
            "stage[{}].{entry}: no body carries the tag {tag:?} at that time{}",
            self.stage,
            did_you_mean(tag, self.tags.iter().map(String::as_str))
        );
        Ok(())
    }

    /// Refuses a tag that no body carries; an empty one stands for all bodies.
    fn require_if_given(&self, entry: &str, tag: &str) -> Result<()> {
        if tag.is_empty() {
            return Ok(());
        }
        self.require(entry, tag)
    }

    fn require_all(&self, entry: &str, tags: &[String]) -> Result<()> {
        tags.iter().try_for_each(|tag| self.require(entry, tag))
    }

    /// Refuses tags that no body carries, of which each has an entry of its own.
    fn require_each<'a>(
        &self,
        entry: &str,
        tags: impl IntoIterator<Item = &'a String>,
    ) -> Result<()> {
        for (number, tag) in tags.into_iter().enumerate() {
            self.require(&format!("{entry}[{number}]"), tag)?;
        }
        Ok(())
    }
}

fn refuse_unknown_rules(
    entry: &str,
    elasticity: &ElasticitySpec,
    carried: &BTreeSet<String>,
) -> Result<()> {
    for (index, rule) in elasticity.pair.iter().enumerate() {
        for name in &rule.between {
            ensure!(
                carried.contains(name),
                "{entry}.pair[{index}]: no body in the scene carries the tag {name:?}{}",
                did_you_mean(name, carried.iter().map(String::as_str))
            );
        }
    }
    Ok(())
}

/// Each stage in words.
pub fn describe(scene: &Scene) -> Vec<String> {
    let counts = action_counts(scene);
    let stages = scene.stage.iter().zip(spans(&scene.stage)).zip(&counts);
    stages
        .map(|((stage, (start, end)), counts)| words(stage, (start, end), counts))
        .collect()
}

fn words(stage: &StageSpec, (start, end): (f64, f64), counts: &[u64]) -> String {
    let name = stage
        .name
        .as_deref()
        .map_or_else(String::new, |name| format!("{name}, "));
    let measured = if stage.measure { "" } else { ", not measured" };
    let mut parts = vec![format!("{name}t = {start} to {end}{measured}")];
    let edits = [
        ("remove", stage.remove.len()),
        ("add", stage.add.len()),
        ("add_wall", stage.add_wall.len()),
        ("move_wall", stage.move_wall.len()),
        ("push_piston", stage.push_piston.len()),
        ("tag", stage.tag.len() + stage.untag.len()),
        ("elasticity", usize::from(stage.elasticity.is_some())),
        ("drag", usize::from(stage.drag.is_some())),
        ("gravity", usize::from(stage.gravity.is_some())),
        ("shear_rate", usize::from(stage.shear_rate.is_some())),
        ("transparent", usize::from(stage.transparent.is_some())),
        ("well", usize::from(stage.well.is_some())),
        ("reaction", usize::from(stage.reaction.is_some())),
        ("unbond", stage.unbond.len()),
        ("bond", stage.bond.len()),
        ("lock", stage.lock.len()),
        ("unlock", stage.unlock.len()),
        ("set_energy", stage.set_energy.len()),
        ("set_velocity", stage.set_velocity.len()),
    ];
    let edits: Vec<&str> = edits
        .iter()
        .filter(|edit| edit.1 > 0)
        .map(|edit| edit.0)
        .collect();
    if !edits.is_empty() {
        parts.push(format!("edits at its start: {}", edits.join(", ")));
    }
    for (thermostat, count) in stage.thermostat.iter().zip(counts) {
        parts.push(format!(
            "thermostat of {} {count} times",
            thermostat_words(thermostat)
        ));
    }
    parts.join("; ")
}

/// The bodies and the rule of a thermostat.
fn thermostat_words(thermostat: &ThermostatSpec) -> String {
    let tag = &thermostat.tag;
    let to = match (thermostat.energy, thermostat.temperature) {
        (Some(energy), _) => format!("energy {energy}"),
        (None, kt) => format!("kT {}", kt.unwrap_or(f64::NAN)),
    };
    match thermostat.kind {
        ThermostatKind::EnergyReset => format!("{tag} to {to} (energy reset)"),
        ThermostatKind::Maxwell => format!("{tag} to {to} (Maxwell)"),
        ThermostatKind::Langevin => format!("{tag} to {to} (Langevin)"),
        ThermostatKind::Active => format!("{tag} (self-propulsion)"),
        ThermostatKind::Rotate => format!("{tag} (random directions)"),
        ThermostatKind::Kick => format!("{tag} (kicks)"),
        ThermostatKind::Rescale => format!("{tag} to {to} (one factor for all)"),
    }
}

/// Number of actions of each thermostat of each stage.
pub fn action_counts(scene: &Scene) -> Vec<Vec<u64>> {
    let counts = scene.stage.iter().zip(spans(&scene.stage));
    let of_stage = |(stage, span): (&StageSpec, (f64, f64))| {
        stage
            .thermostat
            .iter()
            .map(|thermostat| actions(span, thermostat.every))
            .collect()
    };
    counts.map(of_stage).collect()
}
