//! Execution of the experiment: instructions, times, memory, and output files.

use anyhow::{Context as _, Result};
use carom_runs::{
    experiment::{Experiment, Opening, configuration},
    output::Folder,
    print_line,
    progress::Progress,
};
use carom_tables::{Summary, Totals, Verdict, averages};
use cpu_time::ThreadTime;
use rayon::prelude::*;

use super::{
    CapabilityCostOptions,
    callgrind::{self, Counted, Profile},
    capability::Variant,
    dependencies::{self},
    options::CostPlan,
    report,
    results::{CostResults, VariantResult},
    subject::{CostSubject, WARM_UP},
};

/// Runs one variant and prints its number of collisions; callgrind observes this process.
///
/// # Errors
/// There is no such variant, or the run fails.
pub fn work(variant: &str, intervals: u32) -> Result<Verdict> {
    let mut subject = CostSubject::new(variant.parse()?)?;
    subject.run(intervals)?;
    print_line(&subject.collisions().to_string());
    Ok(Verdict::Passed)
}

/// Runs the experiment and writes its folder.
///
/// # Errors
/// The folder is not empty or cannot be written, or a run fails.
pub fn run(options: &CapabilityCostOptions) -> Result<Verdict> {
    let plan = options.plan();
    let experiment = Experiment::start(
        &options.common.destination,
        &Opening {
            folder: "out/capability-cost",
            note: "",
            command: &options.command(),
            configuration: configuration(
                &options.command(),
                &format!(
                    "intervals_counted = {}\nrounds_of_times = {}\n",
                    plan.counted, plan.rounds
                ),
            ),
            scenes: &[],
        },
    )?;
    let folder = &experiment.folder;
    let variants = Variant::all();
    print_line("times");
    let (mut found, totals) = time(&variants, plan)?;
    let installed = callgrind::is_installed();
    let plain = if installed {
        Some(count(&mut found, plan, folder)?)
    } else {
        None
    };
    let results = CostResults {
        found,
        plain,
        needs: dependencies::needs(),
    };
    let note = if installed {
        String::new()
    } else {
        "The program valgrind is not installed: instructions are not counted, and nothing is checked."
            .to_owned()
    };
    let summary = Summary {
        title: "Cost of a capability that is absent, idle, or used".to_owned(),
        note,
        totals,
        checks: results.checks(),
        figures: results.figures(),
        runs: Vec::new(),
    };
    folder.write_table("costs.csv", &report::HEADER, report::rows(&results))?;
    experiment.finish(
        &report::page(&results, &summary, &options.command()),
        &summary,
        None,
    )
}

/// Counts the instructions of all variants in parallel; returns those of the plain gas by source.
fn count(found: &mut [VariantResult], plan: CostPlan, folder: &Folder) -> Result<Profile> {
    print_line("instructions");
    let progress = Progress::new(found.len() as f64);
    let profiles: Vec<Profile> = found
        .par_iter_mut()
        .map(|found| {
            let [short, long] = ends(found.variant, plan, folder)?;
            progress.advance(1.0, long.collisions);
            let instructions = callgrind::total(&long.profile) - callgrind::total(&short.profile);
            found.instructions =
                Some(instructions as f64 / (long.collisions - short.collisions) as f64);
            Ok(difference(&short.profile, &long.profile))
        })
        .collect::<Result<_>>()?;
    profiles.into_iter().next().context("there are no variants")
}

/// The counts of a short and a long run: their difference is the run alone, without the
/// construction of the scene.
fn ends(variant: Variant, plan: CostPlan, folder: &Folder) -> Result<[Counted; 2]> {
    let count = |intervals| callgrind::count(variant, intervals, folder.path());
    Ok([count(WARM_UP)?, count(WARM_UP + plan.counted)?])
}

fn difference(short: &Profile, long: &Profile) -> Profile {
    let less = |key: &[String; 2]| short.get(key).copied().unwrap_or(0);
    long.iter()
        .map(|(key, cost)| (key.clone(), cost.saturating_sub(less(key))))
        .collect()
}

/// Times all variants in turn in each round.
fn time(variants: &[Variant], plan: CostPlan) -> Result<(Vec<VariantResult>, Totals)> {
    let mut subjects = variants
        .iter()
        .map(|&variant| CostSubject::new(variant))
        .collect::<Result<Vec<_>>>()?;
    for subject in &mut subjects {
        subject.run(WARM_UP)?;
    }
    let mut rounds: Vec<Vec<f64>> = vec![Vec::new(); variants.len()];
    let mut totals = Totals::default();
    let mut spent = 0.0;
    for _ in 0..plan.rounds {
        for (subject, times) in subjects.iter_mut().zip(&mut rounds) {
            let before = subject.collisions();
            let begun = ThreadTime::now();
            subject.run(2)?;
            let seconds = begun.elapsed().as_secs_f64();
            let collisions = subject.collisions() - before;
            times.push(seconds / collisions as f64);
            totals.collisions += collisions;
            spent += seconds;
        }
    }
    totals.collisions_per_second = totals.collisions as f64 / spent;
    let found = variants
        .iter()
        .zip(&subjects)
        .zip(&rounds)
        .map(|((&variant, subject), times)| VariantResult {
            variant,
            instructions: None,
            nanoseconds: 1e9 * median(times.clone()),
            time_ratio: median(
                times
                    .iter()
                    .zip(&rounds[0])
                    .map(|(time, plain)| time / plain)
                    .collect(),
            ),
            bytes_per_body: subject.bytes_per_body(),
        });
    Ok((found.collect(), totals))
}

fn median(mut values: Vec<f64>) -> f64 {
    averages::median(&mut values).unwrap_or(f64::NAN)
}
