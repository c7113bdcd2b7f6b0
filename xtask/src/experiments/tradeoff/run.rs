//! Execution of the experiment: states of the exact run, times, replays, physics, and output files.

use anyhow::{Context, Result};
use carom::{Checkpoint, kinematics::EpochTime};
use carom_methods::AnySimulation;
use carom_runs::{
    experiment::{Experiment, Opening, configuration},
    print_line,
    progress::Progress,
};
use carom_tables::{Check, Figure, Summary, Totals, Verdict};
use cpu_time::ThreadTime;
use rayon::prelude::*;

use super::{
    Options, charts,
    knobs::{self, MODEL, Setting},
    measures::{self, Physics},
    observers::Log,
    options::Plan,
    rapier,
    replay::{self, Tally},
    report,
    results::{SceneResult, SettingResult, TOLERANCE},
    reversal::{self},
    scenes::{self, Named},
    settle::settle,
};

/// Least time between the states from which contacts are replayed, and the longest replay, in mean
/// times between two collisions of a body.
const APART: f64 = 5.0;
const STRETCH: f64 = 2.0;

/// A replay ends when chaos has amplified rounding errors by e to this power. More: in a dilute
/// gas, where each collision amplifies them about a hundredfold, two exact runs differ by more than
/// the tolerance. Less: fewer contacts are judged.
const GROWTH: f64 = 3.0;

/// Runs the experiment and writes its folder.
///
/// # Errors
/// The folder is not empty or cannot be written, or an exact run fails.
pub fn run(options: &Options) -> Result<Verdict> {
    let plan = options.plan();
    let mut scenes = scenes::all(options.random.seed);
    scenes.retain(|named| named.name.starts_with(&options.scene));
    anyhow::ensure!(!scenes.is_empty(), "no scene has a name beginning with '{}'", options.scene);
    let scenes_of: Vec<&carom::Scene> = scenes.iter().map(|named| &named.scene).collect();
    let experiment = Experiment::begin(
        &options.common.destination,
        &Opening {
            folder: "out/tradeoff",
            note: &options.note(),
            command: &options.command(),
            configuration: configuration(&options.command(), &plan.configuration()),
            scenes: &scenes_of,
        },
    )?;
    let folder = &experiment.folder;
    let progress = Progress::new(2.0 * scenes.len() as f64);
    let mut totals = Totals::default();
    let mut results = Vec::new();
    for named in scenes {
        let mut result = of_scene(named, &plan, &progress, &mut totals)?;
        result.charts = charts::draw(&result)?;
        for (name, svg) in &result.charts {
            folder.write(name, svg)?;
        }
        for line in report::lines(&result) {
            print_line(&line);
        }
        results.push(result);
    }
    drop(progress);
    let mut compared = Vec::new();
    if options.rapier {
        print_line("rapier in closed boxes");
        for result in &results {
            let one = rapier::compare(&result.named, &plan)?;
            for line in rapier::lines(&one) {
                print_line(&line);
            }
            compared.push(one);
        }
        folder.write_table("rapier.csv", &rapier::HEADER, compared.iter().flat_map(rapier::rows))?;
    } else {
        print_line("rapier is not run; the option --rapier compiles and runs it");
    }
    let summary = Summary {
        title: "Cost of accuracy in whole simulations".to_owned(),
        note: options.note(),
        totals,
        checks: checks(&results),
        figures: figures(&results),
        runs: Vec::new(),
    };
    folder.write_table("settings.csv", &report::HEADER, results.iter().flat_map(report::rows))?;
    folder.write("report.html", report::page(&results, &compared, &summary, &options.command()).html())?;
    folder.write_json("summary.json", &summary)?;
    carom_runs::conclude(&experiment.complete()?, &summary);
    Ok(summary.verdict())
}

/// Continues the exact run to a state from which every setting can start.
fn state_at(simulation: &mut AnySimulation, time: f64) -> Result<Checkpoint> {
    while !simulation.observe_epoch(EpochTime::from(time), &mut ())? {}
    // The end of the epoch follows after a bounded number of contacts.
    loop {
        if let Some(state) = simulation.checkpoint() {
            return Ok(state);
        }
        simulation.observe_epoch(EpochTime::from(2.0 * time + 1e6), &mut ())?;
    }
}

fn of_scene(named: Named, plan: &Plan, progress: &Progress, totals: &mut Totals) -> Result<SceneResult> {
    let mut simulation = AnySimulation::new(&named.scene)?;
    let (first, tau) = settle(&mut simulation)?;
    let settings = knobs::settings(&simulation.view(), plan.finest_step);
    let mut state = |index| state_at(&mut simulation, first + f64::from(index) * APART * tau);
    let mut states = (0..plan.states).map(&mut state).collect::<Result<Vec<_>>>()?;
    let rate = reversal::returns(&settings[0], &states, tau, plan)?.rate();
    anyhow::ensure!(rate > 0.0, "{}: the distance does not grow in the exact run", named.name);
    let stretch = STRETCH.min(GROWTH / rate);
    // The total number of contacts is constant: shorter replays start from more states.
    let more = (f64::from(plan.states) * STRETCH / stretch).ceil() as u32;
    states.extend((plan.states..more).map(&mut state).collect::<Result<Vec<_>>>()?);
    let start = states.first().context("the plan has no states")?;
    let (times, nanoseconds) = time(&settings, start, tau, plan, totals)?;
    progress.advance(1.0, totals.collisions);
    let bodies = simulation.view().len() as f64;
    let exact: Vec<Log> = states
        .par_iter()
        .map(|state| replay::stretch(&settings[0], state, stretch * tau))
        .collect::<Result<_>>()?;
    let found = settings
        .into_par_iter()
        .zip(times)
        .map(|(setting, time)| {
            let tally = replays(&setting, &states, &exact, [stretch, tau], plan)?;
            // Settings too slow for a few blocks have times and replays only.
            let block = time.unwrap_or(0.0) * 1e-9 * nanoseconds * measures::BLOCK * bodies / 2.0;
            let affordable = block < 2.0 * plan.most_seconds;
            let physics =
                if affordable { measures::measure(&setting, start, tau, plan)? } else { Physics::default() };
            let effective = (setting.family != MODEL)
                .then(|| reversal::returns(&setting, &states, tau, plan).ok()?.effective_error(rate))
                .flatten();
            Ok(SettingResult { setting, time, tally, effective, physics })
        })
        .collect::<Result<Vec<_>>>()?;
    progress.advance(1.0, 0);
    let of_exact = &found[0].physics;
    totals.overlapping_pairs = totals.overlapping_pairs.max(of_exact.overlapping);
    totals.max_overlap = totals.max_overlap.max(of_exact.deepest);
    totals.simulated_time += simulation.time().to_f64();
    Ok(SceneResult { named, nanoseconds, rate, stretch, found, charts: Vec::new() })
}

/// Replays a setting from all states, or from as many as fit into its time limit. A replay that
/// fails is not counted; the failure is reported with the physics.
fn replays(
    setting: &Setting,
    states: &[Checkpoint],
    exact: &[Log],
    [stretch, tau]: [f64; 2],
    plan: &Plan,
) -> Result<Tally> {
    let mut tally = Tally::default();
    let clock = ThreadTime::now();
    let duration = stretch * tau;
    for (state, exact) in states.iter().zip(exact) {
        let reference = Setting { locked: setting.locked, ..knobs::exact() };
        let own = if setting.locked { Some(replay::stretch(&reference, state, duration)?) } else { None };
        if let Ok(log) = replay::stretch(setting, state, duration) {
            let exact = own.as_ref().unwrap_or(exact);
            replay::compare(exact, &log, duration, TOLERANCE * tau, &mut tally);
        }
        if clock.elapsed().as_secs_f64() > plan.most_seconds {
            break;
        }
    }
    tally.largest /= tau;
    Ok(tally)
}

/// One setting during the timing.
struct Timed {
    simulation: AnySimulation,
    now: f64,
    /// Simulated time of a turn.
    length: f64,
    /// Simulated time between samples; the whole turn if `None`.
    interval: Option<f64>,
    ratios: Vec<f64>,
    broke_off: bool,
}

impl Timed {
    /// One turn: processor seconds and collisions.
    fn turn(&mut self) -> (f64, u64) {
        let before = self.simulation.view().counters().collisions;
        let clock = ThreadTime::now();
        let end = self.now + self.length;
        let interval = self.interval.unwrap_or(self.length);
        let pieces = (self.length / interval).round().max(1.0) as u64;
        for piece in 1..=pieces {
            let until = if piece == pieces { end } else { self.now + interval * piece as f64 };
            self.broke_off |= self.simulation.run_until(until).is_err();
        }
        self.now = end;
        (clock.elapsed().as_secs_f64(), self.simulation.view().counters().collisions - before)
    }
}

/// Times all settings in turn in each round.
fn time(
    settings: &[Setting],
    state: &Checkpoint,
    tau: f64,
    plan: &Plan,
    totals: &mut Totals,
) -> Result<(Vec<Option<f64>>, f64)> {
    let mut timed = settings
        .iter()
        .map(|setting| {
            Ok(Timed {
                simulation: setting.resume(state)?,
                now: state.time().to_f64(),
                length: tau,
                interval: setting.sample_interval.map(|share| share * tau),
                ratios: Vec::new(),
                broke_off: false,
            })
        })
        .collect::<Result<Vec<_>>>()?;
    for one in &mut timed {
        // A first turn of one mean collision time determines the length of the next.
        let (seconds, _) = one.turn();
        one.length = tau * (plan.turn / seconds.max(1e-9)).clamp(1.0, 1e4).round();
        if seconds < plan.most_seconds {
            one.turn();
        }
    }
    let mut exact = Vec::new();
    for _ in 0..plan.rounds {
        let mut base = f64::NAN;
        for (index, one) in timed.iter_mut().enumerate() {
            // Slow settings are timed once.
            let slow = one.ratios.len() * usize::from(one.length <= tau) >= 2;
            if one.broke_off || slow && index > 0 {
                continue;
            }
            let (seconds, collisions) = one.turn();
            let of_one = seconds / collisions.max(1) as f64;
            if index == 0 {
                base = of_one;
                exact.push(of_one);
                totals.collisions += collisions;
                totals.collisions_per_second = 1.0 / of_one;
            }
            one.ratios.push(of_one / base);
        }
    }
    let times = timed.into_iter().map(|one| if one.broke_off { None } else { median(one.ratios) });
    Ok((times.collect(), 1e9 * median(exact).unwrap_or(f64::NAN)))
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// Checks that the exact detector misses no contact and lets no bodies overlap, with every setting
/// that affects speed only.
fn checks(results: &[SceneResult]) -> Vec<Check> {
    let check = |result: &SceneResult| {
        let safe = result.found.iter().filter(|found| found.setting.is_exact());
        let wrong = safe.clone().map(|found| found.tally.wrong()).fold(0.0, f64::max);
        let overlapping = safe.map(|found| found.physics.overlapping).max().unwrap_or(0);
        [
            Check::at_most(
                &format!("{}: wrong contacts in a million, exact settings", result.named.name),
                wrong,
                0.0,
            ),
            Check::at_most(
                &format!("{}: overlapping pairs, exact settings", result.named.name),
                overlapping as f64,
                0.0,
            ),
        ]
    };
    results.iter().flat_map(check).collect()
}

fn figures(results: &[SceneResult]) -> Vec<Figure> {
    let of = |result: &SceneResult, found: &SettingResult| {
        let what = format!("{}, {}", result.named.name, found.setting.title());
        let wrong = (found.setting.family != MODEL)
            .then(|| Figure::new(format!("wrong contacts in a million: {what}"), found.tally.wrong(), "1"));
        let time = found.time.map(|time| Figure::new(format!("time over Exact: {what}"), time, "1"));
        let deepest = Figure::new(format!("deepest overlap: {what}"), found.physics.deepest, "diameter");
        let effective = found
            .effective
            .map(|effective| Figure::new(format!("effective error: {what}"), effective.value, "side"));
        wrong.into_iter().chain(time).chain([deepest]).chain(effective).collect::<Vec<_>>()
    };
    results.iter().flat_map(|result| result.found.iter().flat_map(move |found| of(result, found))).collect()
}

#[cfg(test)]
mod tests {
    use super::{super::settle::tau, *};
    use carom::CellsPerSide;
    use carom_methods::{Method, Order};

    #[test]
    fn too_fine_a_grid_misses_contacts_and_the_exact_one_misses_none() {
        let scene = carom::Scene::from_toml(
            "[box]\nseed = 1\n[[gas]]\nradius = 0.05\nmass = 1.0\nenergy = 1.0\ncount = 50",
        )
        .unwrap();
        let mut simulation = AnySimulation::new(&scene).unwrap();
        let tau = tau(&mut simulation, 1.0, 5.0).unwrap();
        let states: Vec<Checkpoint> =
            (0..20).map(|index| state_at(&mut simulation, 5.0 + f64::from(index) * tau).unwrap()).collect();
        let exact: Vec<Log> = states
            .iter()
            .map(|state| replay::stretch(&knobs::exact(), state, STRETCH * tau).unwrap())
            .collect();
        let plan = Plan { rounds: 1, turn: 0.01, states: 20, blocks: 20, most_seconds: 60.0, finest_step: 2 };
        let wrong = |setting: &Setting| {
            let tally = replays(setting, &states, &exact, [STRETCH, tau], &plan).unwrap();
            let physics = measures::measure(setting, &states[0], tau, &plan).unwrap();
            // Bodies with a wrong contact are excluded afterwards.
            assert!(tally.judged > 100, "{tally:?}");
            (tally.missed, tally.off + tally.invented, physics.overlapping)
        };
        // Ten cells a side are the finest safe grid.
        let grid = |cells| {
            let method = Method { order: Order::Heap(CellsPerSide::Unchecked(cells)), ..Method::default() };
            Setting { method, ..knobs::exact() }
        };
        assert_eq!(wrong(&grid(10)), (0, 0, 0));
        assert_eq!(wrong(&Setting { contacts_per_epoch: Some(8), ..knobs::exact() }), (0, 0, 0));
        let (missed, other, overlapping) = wrong(&grid(20));
        assert!(missed > 10 && overlapping > 0, "{missed} {other} {overlapping}");
    }
}
