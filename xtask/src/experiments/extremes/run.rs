//! Execution of the experiment: scenes, limits, reversal, drift, and output files.

use std::fmt::Write as _;

use anyhow::Result;
use carom_runs::{
    experiment::{Experiment, Opening, configuration},
    output::Folder,
    print_line,
    progress::Progress,
};
use carom_tables::{Check, Figure, Summary, Totals, Verdict};
use carom_testkit::extremes::{Effort, Engine, ExtremeCase, ExtremeFinding, cases};
use rayon::prelude::*;

use super::{
    ExtremesOptions,
    drift::{EnergyDrift, drift, scenes as scenes_of_drift},
    gaps::MAX_ROUNDINGS,
    limits::{LimitSearch, limit_searches},
    options::ExtremesPlan,
    report,
    results::ExtremesResults,
    reversal::reversals,
    trial::{Ending, attempt},
};

/// Largest number of collisions for the engine of the thesis, which is slower and only for
/// comparison.
const MAX_OF_THESIS: u64 = 20_000;

/// Runs the experiment and writes its folder.
///
/// # Errors
/// The folder is not empty or cannot be written, or a run fails that must not.
pub fn run(options: &ExtremesOptions) -> Result<Verdict> {
    let plan = options.plan();
    let drifting = scenes_of_drift();
    let scenes_of: Vec<&carom::Scene> = drifting.iter().map(|(_, scene)| scene).collect();
    let experiment = Experiment::start(
        &options.common.destination,
        &Opening {
            folder: "out/extremes",
            note: &options.note(),
            command: &options.command(),
            configuration: configuration(&options.command(), &settings(&plan)),
            scenes: &scenes_of,
        },
    )?;
    let folder = &experiment.folder;
    let results = options
        .threads
        .pool()?
        .install(|| measure(&plan, &options.scene))?;
    write_tables(folder, &results)?;
    let broken = violations(&results);
    if !broken.is_empty() {
        folder.write("violations.txt", &broken)?;
        print_line(&broken);
    }
    let totals: Vec<Totals> = results.drifts.iter().map(|drift| drift.totals).collect();
    let summary = Summary {
        title: "Extremes: limits of the guarantees".to_owned(),
        note: options.note(),
        totals: Totals::sum(&totals),
        checks: checks(&results, &totals),
        figures: figures(&results),
        runs: Vec::new(),
    };
    let charts = report::charts(&results)?;
    for (name, svg) in &charts {
        folder.write(name, svg)?;
    }
    experiment.finish(
        &report::page(&results, &summary, &charts, &options.command()),
        &summary,
        None,
    )
}

fn settings(plan: &ExtremesPlan) -> String {
    format!(
        "collisions_of_each_gas = {}\ncollisions_of_each_trial_of_an_edge = {}\n\
         halvings_of_an_edge = {}\nstarts_of_the_reversal = {}\ncollisions_of_the_drift = {:?}\n\
         patience_seconds_of_processor_time = {}\npatience_seconds_of_a_trial_of_an_edge = {}\n",
        plan.collisions,
        plan.limit_collisions,
        plan.halvings,
        plan.reversals,
        plan.drift,
        plan.patience.as_secs(),
        plan.limit_patience.as_secs(),
    )
}

/// Runs everything, or only the scenes whose number begins with `number` if it is not empty.
fn measure(plan: &ExtremesPlan, number: &str) -> Result<ExtremesResults> {
    print_line("scenes");
    let attempt_case = |case: &ExtremeCase, engine: Engine, collisions: u64| {
        let run = case.run;
        attempt(plan.patience, move || run(engine, Effort { collisions }))
    };
    let scenes = cases()
        .into_par_iter()
        .filter(|case| case.id.starts_with(number))
        .map(|case| {
            let endings = [
                attempt_case(&case, Engine::Default, plan.collisions),
                attempt_case(&case, Engine::Thesis, plan.collisions.min(MAX_OF_THESIS)),
            ];
            (case, endings)
        })
        .collect();
    if !number.is_empty() {
        return Ok(ExtremesResults {
            scenes,
            limits: Vec::new(),
            reversals: Default::default(),
            drifts: Vec::new(),
        });
    }
    let drifting = scenes_of_drift();
    let progress = Progress::new(plan.drift.iter().sum::<u64>() as f64);
    print_line("reversal");
    let reversals = [
        reversals(Engine::Default, plan.reversals)?,
        reversals(Engine::Thesis, plan.reversals)?,
    ];
    print_line("drift");
    let drifts: Result<Vec<EnergyDrift>> = drifting
        .par_iter()
        .zip(plan.drift)
        .map(|((name, scene), collisions)| {
            drift(Engine::Default, name, scene, collisions, &progress)
        })
        .collect();
    // The limits are last, because trials that hang continue in the background.
    print_line("limits of the parameters");
    let find = |search: &LimitSearch| {
        search.find(plan.limit_collisions, plan.halvings, plan.limit_patience)
    };
    let limits = limit_searches(Engine::Default)
        .into_par_iter()
        .zip(limit_searches(Engine::Thesis))
        .map(|(ours, theses)| {
            let found = [find(&ours), find(&theses)];
            (ours, found)
        })
        .collect();
    Ok(ExtremesResults {
        scenes,
        limits,
        reversals,
        drifts: drifts?,
    })
}

/// Names of both engines, in the order of their results.
const ENGINES: [&str; 2] = [Engine::Default.name(), Engine::Thesis.name()];

fn write_tables(folder: &Folder, results: &ExtremesResults) -> Result<()> {
    write_scenes(folder, results)?;
    write_findings(folder, results)?;
    write_limits(folder, results)?;
    let rows = results.reversals.iter().flatten().flat_map(|reversal| {
        let of = |&(n, distance): &(f64, f64)| (reversal.engine, reversal.fraction, n, distance);
        reversal.points.iter().map(of)
    });
    folder.write_table(
        "reversal.csv",
        &["engine", "area_fraction", "collisions_per_disc", "distance"],
        rows,
    )?;
    let rows = results.drifts.iter().flat_map(|drift| {
        drift
            .points
            .iter()
            .map(|point| (drift.name, point.0, point.1))
    });
    folder.write_table("drift.csv", &["scene", "collisions", "energy_change"], rows)
}

/// Writes whether all bounds hold in each scene.
fn write_scenes(folder: &Folder, results: &ExtremesResults) -> Result<()> {
    let rows = results.scenes.iter().flat_map(|(case, endings)| {
        endings.iter().zip(ENGINES).map(|(ending, engine)| {
            (
                case.id,
                case.name,
                case.must,
                engine,
                ending.holds(),
                ending.seen(),
            )
        })
    });
    folder.write_table(
        "scenes.csv",
        &["id", "scene", "must_hold", "engine", "holds", "seen"],
        rows,
    )
}

/// Writes every finding of each scene with its bound.
fn write_findings(folder: &Folder, results: &ExtremesResults) -> Result<()> {
    let rows = results.scenes.iter().flat_map(|(case, endings)| {
        let id = case.id;
        endings
            .iter()
            .zip(ENGINES)
            .flat_map(move |(ending, engine)| {
                let none: &[ExtremeFinding] = &[];
                let findings = if let Ending::Findings(findings) = ending {
                    findings
                } else {
                    none
                };
                findings
                    .iter()
                    .map(move |f| (id, engine, f.what.as_str(), f.found, f.allowed, f.holds()))
            })
    });
    folder.write_table(
        "findings.csv",
        &["id", "engine", "what", "found", "allowed", "holds"],
        rows,
    )
}

/// Writes the limit of each parameter, and what happens beyond it.
fn write_limits(folder: &Folder, results: &ExtremesResults) -> Result<()> {
    let rows = results.limits.iter().flat_map(|(limit, found)| {
        found.iter().zip(ENGINES).map(|(found, engine)| {
            let beyond = found.beyond.as_ref();
            let (value, seen) = (
                beyond.map(|beyond| beyond.0),
                beyond.map(|beyond| beyond.1.seen()),
            );
            (
                limit.parameter,
                limit.scene,
                limit.goal,
                engine,
                found.holds_up_to,
                value,
                seen,
                found.kinds(),
            )
        })
    });
    let header = [
        "parameter",
        "scene",
        "goal",
        "engine",
        "holds_up_to",
        "beyond",
        "seen_beyond",
        "ends_beyond",
    ];
    folder.write_table("edges.csv", &header, rows)
}

/// Largest effective error of the exact engine, in units of ε × side. Smaller: the fit over a few
/// starts might fail by chance. Larger: a root found only to 1e-13 would pass.
const MAX_EFFECTIVE_ERROR: f64 = 32.0;

fn checks(results: &ExtremesResults, totals: &[Totals]) -> Vec<Check> {
    let failed = |endings: &[Ending; 2]| f64::from(u8::from(!endings[0].holds()));
    let scenes = results.scenes.iter().map(|(case, endings)| {
        Check::at_most(
            &format!("{} {}: broken", case.id, case.name),
            failed(endings),
            0.0,
        )
    });
    let limits = results.limits.iter().map(|(limit, [found, _])| {
        // NaN, if the bounds never hold, exceeds every limit of a check.
        Check::at_most(
            &format!("goal over limit of the {}", limit.parameter),
            limit.goal / found.holds_up_to,
            1.0 + 1e-9,
        )
    });
    let ends = results.limits.iter().map(|(limit, [found, _])| {
        let name = format!("panic or hang beyond the limit of the {}", limit.parameter);
        Check::at_most(&name, f64::from(u8::from(found.silent().is_some())), 0.0)
    });
    let reversals = results.reversals[0].iter().map(|reversal| {
        let name = format!(
            "effective error at area fraction {} (eps × side)",
            reversal.fraction
        );
        Check::at_most(&name, reversal.effective_error, MAX_EFFECTIVE_ERROR)
    });
    let drifts = totals.iter().flat_map(Totals::checks);
    let gaps = results.drifts.iter().flat_map(|drift| {
        [
            ("deepest", drift.gaps.deepest),
            ("farthest", drift.gaps.farthest),
        ]
        .map(|(which, gap)| {
            let name = format!("{which} contact, {} (eps × side)", drift.name);
            Check::at_most(&name, gap, MAX_ROUNDINGS)
        })
    });
    scenes
        .chain(limits)
        .chain(ends)
        .chain(reversals)
        .chain(drifts)
        .chain(gaps)
        .collect()
}

fn figures(results: &ExtremesResults) -> Vec<Figure> {
    let limits = results.limits.iter().map(|(limit, [found, _])| {
        Figure::new(
            format!("holds up to: {}", limit.parameter),
            found.holds_up_to,
            "1",
        )
    });
    let reversals = results
        .reversals
        .iter()
        .flatten()
        .zip(super::reversal::DENSITIES.iter().cycle())
        .flat_map(|(reversal, (_, rate))| {
            let of = format!("{} at area fraction {}", reversal.engine, reversal.fraction);
            [
                Figure::new(
                    format!("effective error, {of}"),
                    reversal.effective_error,
                    "eps × side",
                ),
                Figure::new(
                    format!("growth per collision of each disc, {of}"),
                    reversal.rate,
                    "1",
                )
                .predicted(*rate, "λ₁/Γ by two trajectories, 64 discs"),
            ]
        });
    let drifts = results.drifts.iter().map(|drift| {
        Figure::new(
            format!("exponent of the drift, {}", drift.name),
            drift.exponent,
            "1",
        )
        .predicted(0.5, "random walk of roundings")
    });
    limits.chain(reversals).chain(drifts).collect()
}

/// All violations of the exact engine.
fn violations(results: &ExtremesResults) -> String {
    let mut text = String::new();
    for (case, [ours, _]) in results
        .scenes
        .iter()
        .filter(|(_, endings)| !endings[0].holds())
    {
        let _ = writeln!(text, "{} {}: {}", case.id, case.name, ours.seen());
        if let Ending::Findings(findings) = ours {
            for finding in findings.iter().filter(|finding| !finding.holds()) {
                let _ = writeln!(
                    text,
                    "  {}: {:e}, allowed {:e}",
                    finding.what, finding.found, finding.allowed
                );
            }
        }
    }
    for (limit, [ours, _]) in &results.limits {
        if let Some((at, ending)) = ours.silent() {
            let _ = writeln!(
                text,
                "beyond the limit of the {}: at {at:e} {}",
                limit.parameter,
                ending.seen()
            );
        }
    }
    text
}
