//! What a scene asks for: the names in `run.observe` and the entries `[[measure]]`.

use std::collections::BTreeMap;

use anyhow::{Context as _, Error, Result, anyhow, bail, ensure};
use carom::Scene;
use carom::engine::{MeasureParameter, MeasureSpec, did_you_mean};

use super::{
    KINDS, MeasureKind, helfand,
    kind::{EVERY, INTERVAL, check_word},
    lyapunov,
};
use crate::{invalid_entries::refuse_all, schedule::stages};

/// The interval of a measure may differ from a multiple of the run's by this share: rounding.
const ROUNDING: f64 = 1e-9;

/// Measures that follow bodies between contacts on straight lines.
const STRAIGHT_FLIGHT: [&str; 12] = [
    "body-frame-diffusion",
    "correlation",
    "currents",
    "drift",
    "free-path",
    "heat-conductivity",
    "intermediate-scattering",
    "kicks",
    "relaxation",
    "van-hove",
    "van-hove-distinct",
    "viscosity",
];

/// Measures of bodies whose images move, or are displaced by an earlier shear: displacements are
/// relative to the flow, distances and wave vectors those of the displaced images.
const SHEARED: [&str; 28] = [
    "body-frame-diffusion",
    "bond-order-correlation",
    "bond-order-relaxation",
    "cage-displacement",
    "collision-rate",
    "correlation",
    "defects",
    "energy",
    "events",
    "hexatic-order",
    "impulses",
    "k-atic",
    "nematic",
    "numbers",
    "overlap",
    "pair-distribution",
    "pressure",
    "pressure-tensor",
    "profile",
    "relaxation",
    "structure-factor",
    "structure-factor-map",
    "temperature",
    "tetratic",
    "thermostat",
    "van-hove",
    "velocities",
    "voronoi",
];

/// A measure that a scene asks for.
#[derive(Debug, Clone)]
pub struct Request {
    /// Its place in the scene, for error messages.
    pub entry: String,
    /// What is measured.
    pub kind: &'static MeasureKind,
    /// The tags of the bodies.
    pub tags: Vec<String>,
    /// Its name in files and figures, if it has one.
    pub name: Option<String>,
    /// Samples of the run for each of its samples.
    pub every: u64,
    /// The parameters given.
    pub given: BTreeMap<String, MeasureParameter>,
}

impl Request {
    /// A measure with default parameters.
    pub fn plain(kind: &'static MeasureKind) -> Self {
        Self {
            entry: format!("the measure '{}'", kind.name),
            kind,
            tags: Vec::new(),
            name: None,
            every: 1,
            given: BTreeMap::new(),
        }
    }

    /// The tags as part of a name.
    pub fn tag(&self) -> Option<String> {
        (!self.tags.is_empty()).then(|| self.tags.join("-"))
    }

    /// What distinguishes its files from those of other measures of its kind. The file of impulses
    /// does not have the tag in its name.
    fn distinction(&self) -> Option<String> {
        let tag = if self.kind.name == super::impulses::NAME {
            None
        } else {
            self.tag()
        };
        self.name.clone().or(tag)
    }

    /// From `kind`, `kind:TAG` or `kind:TAG,TAG`.
    fn from_name(name: &str) -> Result<Self> {
        let entry = format!("run.observe: '{name}'");
        let (kind, tags) = name
            .split_once(':')
            .map_or((name, None), |(kind, tags)| (kind, Some(tags)));
        let Some(kind) = find(kind) else {
            bail!("unknown observer '{name}'{}", expected(kind));
        };
        let tags: Vec<&str> = tags.map_or_else(Vec::new, |tags| tags.split(',').collect());
        kind.check_tags(name, &tags)?;
        let tags = tags.into_iter().map(str::to_owned).collect();
        Ok(Self {
            entry,
            tags,
            ..Self::plain(kind)
        })
    }

    /// From an entry `[[measure]]` of a run with this sample interval (time).
    fn from_spec(spec: &MeasureSpec, sample_interval: f64) -> Result<Self> {
        let Some(kind) = find(&spec.kind) else {
            bail!("unknown kind '{}'{}", spec.kind, expected(&spec.kind));
        };
        let tags: Vec<&str> = spec
            .of
            .as_deref()
            .map_or_else(Vec::new, |of| of.split(',').map(str::trim).collect());
        kind.check_tags(&spec.kind, &tags)?;
        if let Some(name) = &spec.name {
            check_word(&spec.kind, "the name", name)?;
        }
        let mut given = BTreeMap::new();
        for (key, value) in &spec.parameters {
            let Some(parameter) = kind
                .all_parameters()
                .find(|parameter| parameter.name == key)
            else {
                let keys = || {
                    ["kind", "of", "name"]
                        .into_iter()
                        .chain(kind.all_parameters().map(|p| p.name))
                };
                let allowed: Vec<&str> = keys().collect();
                bail!(
                    "unknown key '{key}' of '{}'{}; expected one of {}",
                    kind.name,
                    did_you_mean(key, keys()),
                    allowed.join(", ")
                );
            };
            parameter.check(value)?;
            given.insert(key.clone(), value.clone());
        }
        let every = every(&given, sample_interval)?;
        let tags = tags.into_iter().map(str::to_owned).collect();
        Ok(Self {
            tags,
            name: spec.name.clone(),
            every,
            given,
            ..Self::plain(kind)
        })
    }
}

/// Samples of the run for each sample of a measure.
fn every(given: &BTreeMap<String, MeasureParameter>, sample_interval: f64) -> Result<u64> {
    let number = |name: &str| number(given.get(name)?);
    let (every, interval) = (number(EVERY.name), number(INTERVAL.name));
    ensure!(
        every.is_none() || interval.is_none(),
        "'every' and 'interval' exclude each other"
    );
    let Some(interval) = interval else {
        return Ok(every.map_or(1, |every| every as u64));
    };
    let ratio = interval / sample_interval;
    let whole = ratio.round().max(1.0);
    ensure!(
        (ratio - whole).abs() <= ROUNDING * whole,
        "'interval' must be a multiple of run.sample_interval = {sample_interval:?}, but is {interval:?}"
    );
    Ok(whole as u64)
}

/// The value of a parameter that is a number.
pub(super) fn number(value: &MeasureParameter) -> Option<f64> {
    match value {
        MeasureParameter::Number(value) => Some(*value),
        _ => None,
    }
}

/// All measures of a scene, validated: those of `run.observe` first.
///
/// # Errors
/// Names, tags, keys or values are invalid, all in one message; or else two measures would write
/// the same files, or one cannot be measured in this scene.
pub fn requests(scene: &Scene) -> Result<Vec<Request>> {
    let requests = of_scene(scene)?;
    refuse_unsuitable(scene, &requests)?;
    refuse_same_files(&requests)?;
    Ok(requests)
}

/// The measures of a scene: those of `run.observe` first.
fn of_scene(scene: &Scene) -> Result<Vec<Request>> {
    let (mut requests, mut faults): (Vec<Request>, Vec<Error>) = (Vec::new(), Vec::new());
    for (index, name) in scene.run.observe.iter().enumerate() {
        if scene.run.observe[..index].contains(name) {
            faults.push(anyhow!("run.observe: '{name}' is named twice"));
            continue;
        }
        match Request::from_name(name).context("run.observe") {
            Ok(request) => requests.push(request),
            Err(fault) => faults.push(fault),
        }
    }
    for (index, spec) in scene.measure.iter().enumerate() {
        let entry = format!("measure[{index}]");
        match Request::from_spec(spec, scene.run.sample_interval).context(entry.clone()) {
            Ok(request) => requests.push(Request { entry, ..request }),
            Err(fault) => faults.push(fault),
        }
    }
    refuse_all(faults)?;
    Ok(requests)
}

/// Refuses measures that cannot be taken in a scene.
fn refuse_unsuitable(scene: &Scene, requests: &[Request]) -> Result<()> {
    if stages::is_dragged(scene) {
        refuse_kinds(
            requests,
            &[helfand::VISCOSITY.name, helfand::HEAT_CONDUCTIVITY.name],
            "needs velocities that are constant between contacts, but a drag slows the bodies: remove it, or the drag",
        )?;
    }
    if stages::falls(scene) {
        refuse_kinds(
            requests,
            &STRAIGHT_FLIGHT,
            "needs bodies that fly straight between contacts, but gravity bends their paths: remove it, or the gravity",
        )?;
    }
    if stages::is_ever_sheared(scene) {
        refuse_sheared(requests)?;
    }
    if stages::has_wells(scene) {
        refuse_kinds(
            requests,
            &[helfand::HEAT_CONDUCTIVITY.name],
            "does not include the energy of wells: remove it, or the wells",
        )?;
    }
    match first_of_kinds(requests, &[lyapunov::KIND.name]) {
        Some(request) => lyapunov::check(scene).with_context(|| request.entry.clone()),
        None => Ok(()),
    }
}

/// Refuses measures of these kinds, for a reason that follows their name.
fn refuse_kinds(requests: &[Request], kinds: &[&str], reason: &str) -> Result<()> {
    match first_of_kinds(requests, kinds) {
        Some(Request { entry, kind, .. }) => bail!("{entry}: '{}' {reason}", kind.name),
        None => Ok(()),
    }
}

fn first_of_kinds<'a>(requests: &'a [Request], kinds: &[&str]) -> Option<&'a Request> {
    requests
        .iter()
        .find(|request| kinds.contains(&request.kind.name))
}

/// Refuses two measures that would write the same files.
fn refuse_same_files(requests: &[Request]) -> Result<()> {
    // Also of different kinds: `van-hove` of the tag `distinct`, and `van-hove-distinct`.
    let key = |request: &Request| {
        let name = request.kind.name;
        match request.distinction() {
            Some(of) => format!("{name}-{of}"),
            None => name.to_owned(),
        }
    };
    for (index, request) in requests.iter().enumerate() {
        let mut before = requests[..index].iter();
        if let Some(same) = before.find(|other| key(other) == key(request)) {
            bail!(
                "{} and {} would write the same files: give one of them, as [[measure]], a 'name'",
                same.entry,
                request.entry
            );
        }
    }
    Ok(())
}

/// Refuses the measures of a scene that take images for fixed, in a box in which an earlier shear
/// has displaced them.
///
/// # Errors
/// The first such measure, or one that is not known.
pub fn refuse_displaced(scene: &Scene) -> Result<()> {
    refuse_sheared(&requests(scene)?)
}

/// Refuses the measures that take images for fixed, where a shear displaces them.
fn refuse_sheared(requests: &[Request]) -> Result<()> {
    for request in requests {
        let name = request.kind.name;
        ensure!(
            SHEARED.contains(&name),
            "{}: '{name}' takes images above and below for fixed, but a shear moves them: remove it, or the shear; \
             measures under shear are {}",
            request.entry,
            SHEARED.join(", ")
        );
        let along_y = Some(&MeasureParameter::Text("y".to_owned()));
        ensure!(
            name != "profile" || request.given.get("axis") == along_y,
            "{}: under shear a profile has `axis = \"y\"`: the box moves along x",
            request.entry
        );
    }
    Ok(())
}

/// Other names of measures, as in the literature and in other programs.
const ALIASES: [(&str, &str); 19] = [
    ("msd", "correlation"),
    ("mean-square-displacement", "correlation"),
    ("diffusion", "correlation"),
    ("vacf", "correlation"),
    ("rdf", "pair-distribution"),
    ("g(r)", "pair-distribution"),
    ("s(k)", "structure-factor"),
    ("diffraction", "structure-factor-map"),
    ("psi6", "hexatic-order"),
    ("bond-order", "hexatic-order"),
    ("g6", "bond-order-correlation"),
    ("g6(t)", "bond-order-relaxation"),
    ("katic", "k-atic"),
    ("disclinations", "defects"),
    ("stress", "pressure-tensor"),
    ("maps", "fields"),
    ("lyapunov-spectrum", "lyapunov"),
    ("door", "crossings"),
    ("potential-energy", "wells"),
];

/// The kind of measure with this name.
pub(super) fn find(kind: &str) -> Option<&'static MeasureKind> {
    let alias = ALIASES
        .iter()
        .find(|(alias, _)| kind.eq_ignore_ascii_case(alias));
    let name = alias.map_or(kind, |(_, name)| name);
    KINDS.iter().find(|known| known.name == name)
}

fn names() -> impl Iterator<Item = &'static str> {
    KINDS.iter().map(|kind| kind.name)
}

/// The kind nearest to an unknown one, or else all of them, as the end of a message.
fn expected(kind: &str) -> String {
    let near = did_you_mean(kind, names());
    if near.is_empty() {
        let names: Vec<_> = names().collect();
        format!("; expected one of {}", names.join(", "))
    } else {
        format!("{near} `carom measures` lists all")
    }
}
