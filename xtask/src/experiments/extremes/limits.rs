//! Limits of the guarantees: one parameter grows by decades until a bound fails, and bisection
//! locates the limit.

use std::time::Duration;

use anyhow::{Result, ensure};
use carom::{
    Atom, Detection, Molecule, Orientation, Scene, detection::Outcome, engine::MoleculeSpec,
    kinematics::RelativeMotion,
};
use carom_runs::check::limits::tested;
use carom_testkit::extremes::{
    Engine, ExtremeFinding,
    bodies::{disc, named},
    engine::{gas, in_box},
    gases::{aged, later, mixture},
    lattice::packed,
    watch::{survey, velocity},
};
use glam::DVec2;

use super::trial::{Ending, attempt};

/// A parameter, and the goal up to which all bounds must hold.
pub struct LimitSearch {
    /// Name of the parameter.
    pub parameter: &'static str,
    /// Description of the scene.
    pub scene: &'static str,
    /// All bounds must hold up to this value.
    pub goal: f64,
    /// Range of the search (decades).
    decades: (f64, f64),
    engine: Engine,
    trial: Trial,
}

/// Trial of one value of a parameter, over a number of collisions.
type Trial = fn(Engine, f64, u64) -> Result<Vec<ExtremeFinding>>;

/// Location of the limit.
#[derive(Debug, Clone)]
pub struct FoundLimit {
    /// The largest value at which all bounds hold; NaN if there is none.
    pub holds_up_to: f64,
    /// The next value and its result; `None` if all bounds hold up to the end of the search.
    pub beyond: Option<(f64, Ending)>,
    /// All values tried beyond the limit, with their results.
    pub rest: Vec<(f64, Ending)>,
}

impl FoundLimit {
    /// Returns a value beyond the limit with an unreported failure: a panic or a hang.
    pub fn silent(&self) -> Option<&(f64, Ending)> {
        self.rest.iter().find(|(_, ending)| !ending.is_reported())
    }

    /// Results beyond the limit, from near to far.
    pub fn kinds(&self) -> String {
        let kind = |(value, ending): &(f64, Ending)| format!("{value:.1e} {}", ending.kind());
        self.rest.iter().map(kind).collect::<Vec<_>>().join(", ")
    }
}

/// Step of the first search (decades).
const STEP: f64 = 2.0;

impl LimitSearch {
    /// Searches the limit, and examines the values beyond it.
    pub fn find(&self, collisions: u64, halvings: u32, patience: Duration) -> FoundLimit {
        let attempt_at = |decade: f64| {
            let (engine, trial, value) = (self.engine, self.trial, 10f64.powf(decade));
            attempt(patience, move || trial(engine, value, collisions))
        };
        let (mut low, end) = self.decades;
        let first = attempt_at(low);
        if !first.holds() {
            let beyond = (10f64.powf(low), first);
            return FoundLimit {
                holds_up_to: f64::NAN,
                beyond: Some(beyond.clone()),
                rest: vec![beyond],
            };
        }
        // The goal itself is tested, not only its neighbours.
        if self.goal.log10() > low && attempt_at(self.goal.log10()).holds() {
            low = self.goal.log10();
        }
        // From the last value back to the limit.
        let mut failed = Vec::new();
        while failed.is_empty() && low < end {
            let next = (low + STEP).min(end);
            let ending = attempt_at(next);
            if ending.holds() {
                low = next;
            } else {
                failed.push((next, ending));
            }
        }
        if let Some(&(high, _)) = failed.first() {
            for decade in [end, 0.5 * (high + end)]
                .into_iter()
                .filter(|&decade| decade > high)
                .rev()
            {
                failed.insert(0, (decade, attempt_at(decade)));
            }
        }
        low = bisect(low, &mut failed, halvings, attempt_at);
        let rest: Vec<(f64, Ending)> = failed
            .into_iter()
            .rev()
            .map(|(decade, ending)| (10f64.powf(decade), ending))
            .collect();
        FoundLimit {
            holds_up_to: 10f64.powf(low),
            beyond: rest.first().cloned(),
            rest,
        }
    }
}

/// Bisects between `low`, which holds, and the last failure; returns the last decade that holds.
fn bisect(
    mut low: f64,
    failed: &mut Vec<(f64, Ending)>,
    halvings: u32,
    attempt_at: impl Fn(f64) -> Ending,
) -> f64 {
    for _ in 0..halvings {
        let Some((high, _)) = failed.last() else {
            break;
        };
        let middle = 0.5 * (low + high);
        let ending = attempt_at(middle);
        if ending.holds() {
            low = middle;
        } else {
            failed.push((middle, ending));
        }
    }
    low
}

/// All parameters.
pub fn limit_searches(engine: Engine) -> Vec<LimitSearch> {
    let search = |(parameter, scene, goal, decades, trial): ParameterRow| LimitSearch {
        parameter,
        scene,
        goal,
        decades,
        engine,
        trial,
    };
    PARAMETERS.into_iter().map(search).collect()
}

/// A parameter, its scene, its goal, the range of the search (decades), and the trial of a value.
type ParameterRow = (&'static str, &'static str, f64, (f64, f64), Trial);

/// All parameters, in the order of the table.
const PARAMETERS: [ParameterRow; 11] = [
    (
        "mass ratio",
        "a heavy disc among 30 light ones",
        tested::MASS_RATIO,
        (2.0, 62.0),
        heavy,
    ),
    (
        "speed ratio",
        "a light and fast disc among 30",
        tested::SPEED_RATIO,
        (1.0, 32.0),
        fast,
    ),
    (
        "size ratio",
        "two small discs meet obliquely beside a large one",
        tested::SIZE_RATIO,
        (1.0, 18.0),
        small,
    ),
    (
        "turns per natural time",
        "a rotating rod hit by a gas disc at its rim",
        tested::TURNS,
        (1.0, 60.0),
        spinning,
    ),
    (
        "σ over depth of a graze",
        "two discs at 30 σ",
        tested::GRAZE,
        (3.0, 18.0),
        grazing,
    ),
    (
        "reach over depth of a sweep",
        "a rotating dumbbell and a disc",
        tested::SWEEP,
        (3.0, 18.0),
        sweeping,
    ),
    (
        "age in natural times",
        "36 discs added to a box at a late time",
        tested::AGE,
        (1.0, 40.0),
        old,
    ),
    (
        "1/(A/A₀ − 1)",
        "288 discs on the triangular lattice",
        tested::DENSITY,
        (2.0, 18.0),
        dense,
    ),
    (
        "1/contact time of the guard",
        "a gas of discs and dumbbells at e = 0",
        tested::CONTACT_TIME,
        (2.0, 18.0),
        inelastic,
    ),
    (
        "atoms of a ring",
        "a ring among 40 discs",
        tested::ATOMS,
        (1.0, 5.0),
        many_atoms,
    ),
    (
        "box over diameter",
        "two discs meet obliquely across half the box",
        tested::BOX,
        (1.0, 18.0),
        large_box,
    ),
];

/// Conditions that hold in any run, and that it reaches the requested number of collisions.
fn surveyed(engine: Engine, scene: &Scene, collisions: u64) -> Result<Vec<ExtremeFinding>> {
    let survey = survey(engine, scene, collisions)?;
    let missing = ExtremeFinding::never(
        "missing collisions",
        collisions.saturating_sub(survey.collisions) as usize,
    );
    Ok(survey.findings("").into_iter().chain([missing]).collect())
}

fn heavy(engine: Engine, ratio: f64, collisions: u64) -> Result<Vec<ExtremeFinding>> {
    surveyed(engine, &mixture(30, 0.03, 1.0, 0.1, ratio), collisions)
}

fn fast(engine: Engine, ratio: f64, collisions: u64) -> Result<Vec<ExtremeFinding>> {
    // Of the same energy as the others.
    surveyed(
        engine,
        &mixture(30, 0.03, 1.0, 0.05, 1.0 / (ratio * ratio)),
        collisions,
    )
}

/// An oblique collision with b = 3/5 σ: deviation of the final velocities from the closed form.
fn oblique(
    engine: Engine,
    radius: f64,
    side: f64,
    others: Vec<MoleculeSpec>,
) -> Result<Vec<ExtremeFinding>> {
    let sigma = 2.0 * radius;
    let at = [0.75 * side, 0.75 * side];
    let mut list = vec![
        disc(radius, 1.0, [0.25 * side, at[1] - 0.6 * sigma], [1.0, 0.0]),
        disc(radius, 1.0, at, [0.0; 2]),
    ];
    list.extend(others);
    let mut run = engine.simulate(&in_box([side, side], list))?;
    let hit = run.step(0.6 * side, &mut ())?;
    let normal = DVec2::new(0.8, 0.6);
    let error = (velocity(&run, 1) - 0.8 * normal).length();
    let overlaps = run.view().overlaps();
    Ok(vec![
        ExtremeFinding::never("missed hits", usize::from(!hit)),
        ExtremeFinding::never("overlapping pairs", overlaps.pairs),
        ExtremeFinding::new(
            "deepest overlap in diameters",
            overlaps.deepest_length / sigma,
            1e-3,
        ),
        ExtremeFinding::new("error of the velocity", error, 1e-3),
    ])
}

fn small(engine: Engine, ratio: f64, _: u64) -> Result<Vec<ExtremeFinding>> {
    oblique(
        engine,
        0.1 / ratio,
        1.0,
        vec![disc(0.1, 1.0, [0.5, 0.25], [0.0; 2])],
    )
}

fn large_box(engine: Engine, ratio: f64, _: u64) -> Result<Vec<ExtremeFinding>> {
    oblique(engine, 0.5, ratio.max(8.0), Vec::new())
}

fn spinning(engine: Engine, turns: f64, _: u64) -> Result<Vec<ExtremeFinding>> {
    let (radius, speed) = (0.02, 1.0);
    let spin = std::f64::consts::TAU * turns * speed / (2.0 * radius);
    // The end of a rod of 6 atoms is 6 radii from its centre; the first disc reaches it after a
    // thousand turns.
    let gap = 1e3 * std::f64::consts::TAU / spin * speed;
    let rod = MoleculeSpec {
        angular_velocity: spin,
        ..named("rod:6", radius, 10.0, [0.5, 0.5])
    };
    let mut list = vec![
        rod,
        disc(
            radius,
            1.0,
            [0.5 + 7.0 * radius + gap.min(0.2), 0.5],
            [-speed, 0.0],
        ),
    ];
    list.extend((0..8).map(|k| disc(radius, 1.0, [0.06 + 0.12 * f64::from(k), 0.1], [0.3, 0.1])));
    surveyed(engine, &in_box([1.0, 1.0], list), 100)
}

fn grazing(engine: Engine, inverse: f64, _: u64) -> Result<Vec<ExtremeFinding>> {
    let half = Molecule::disc(0.5, 1.0)?;
    let motion =
        RelativeMotion::exactly(DVec2::new(30.0, 1.0 - 1.0 / inverse), DVec2::new(-1.0, 0.0));
    let answer = engine
        .detector()
        .first_contact(half.outline(), half.outline(), &motion, 100.0);
    let hit = matches!(answer.outcome, Outcome::Contact(_));
    Ok(vec![ExtremeFinding::never("missed", usize::from(!hit))])
}

fn sweeping(engine: Engine, inverse: f64, _: u64) -> Result<Vec<ExtremeFinding>> {
    let ends = [1.0, -1.0].map(|x| Atom::new(DVec2::new(x, 0.0), 1.0, 1.0));
    let [left, right] = ends;
    let (dumbbell, disc) = (Molecule::new([left?, right?])?, Molecule::disc(0.5, 1.0)?);
    let mut missed = 0;
    for start in [-0.3, -0.2, -0.1] {
        let motion = RelativeMotion {
            orientation: [Orientation::from_turns(start), Orientation::default()],
            angular_velocity: [1.0, 0.0],
            ..RelativeMotion::exactly(DVec2::new(2.5 * (1.0 - 1.0 / inverse), 0.0), DVec2::ZERO)
        };
        let answer =
            engine
                .detector()
                .first_contact(dumbbell.outline(), disc.outline(), &motion, 3.0);
        missed += usize::from(!matches!(answer.outcome, Outcome::Contact(_)));
    }
    Ok(vec![ExtremeFinding::never("missed", missed)])
}

fn old(engine: Engine, age: f64, _: u64) -> Result<Vec<ExtremeFinding>> {
    let path = |age: f64| -> Result<(u64, Vec<DVec2>, usize)> {
        let mut run = aged(engine, age, 36)?;
        let until = later(run.time(), 2.0);
        run.observe_until_epoch_time(until, &mut ())?;
        let view = run.view();
        let velocities = view.bodies().map(|body| body.motion.velocity).collect();
        Ok((
            view.counters().collisions,
            velocities,
            view.overlaps().pairs,
        ))
    };
    let (young, aged) = (path(0.0)?, path(age)?);
    ensure!(young.0 > 0, "no collisions occurred");
    Ok(vec![
        ExtremeFinding::never(
            "trajectories that differ from those at time 0",
            usize::from(young != aged),
        ),
        ExtremeFinding::never("overlapping pairs", aged.2),
    ])
}

fn dense(engine: Engine, inverse: f64, collisions: u64) -> Result<Vec<ExtremeFinding>> {
    let seen = packed(engine, 1.0 / inverse, collisions.max(10_000))?;
    Ok(vec![
        ExtremeFinding::never("overlapping pairs", seen.overlapping),
        ExtremeFinding::new("deepest overlap (σ)", seen.deepest, 1e-13),
        ExtremeFinding::new(
            "relative deviation from the free-volume pressure",
            seen.pressure,
            0.05,
        ),
        ExtremeFinding::new("energy drift, relative", seen.energy, 1e-12),
        ExtremeFinding::never("collisions out of time order", seen.backwards),
    ])
}

fn inelastic(engine: Engine, inverse: f64, collisions: u64) -> Result<Vec<ExtremeFinding>> {
    let mut scene = in_box([1.0, 1.0], Vec::new());
    scene.gas = vec![gas("disc", 0.02, 1.0, 200), gas("dumbbell", 0.015, 1.0, 20)];
    scene.elasticity.default = 0.0;
    scene.elasticity.contact_time = 1.0 / inverse;
    let survey = survey(engine, &scene, collisions.max(10_000))?;
    Ok(vec![
        ExtremeFinding::never("overlapping pairs", survey.overlapping),
        ExtremeFinding::never("collisions out of time order", survey.watch.backwards),
    ])
}

fn many_atoms(engine: Engine, count: f64, collisions: u64) -> Result<Vec<ExtremeFinding>> {
    let count = count.round();
    let radius = 0.2 * (std::f64::consts::PI / count).sin();
    let ring = MoleculeSpec {
        angular_velocity: 1.0,
        ..named(&format!("ring:{count}"), radius, 10.0 / count, [0.5, 0.5])
    };
    let mut scene = in_box([1.0, 1.0], vec![ring]);
    scene.gas = vec![gas("disc", 0.02, 1.0, 40)];
    surveyed(engine, &scene, collisions / 10)
}
