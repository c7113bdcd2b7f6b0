//! Execution of all requested runs in parallel, and their output.

use anyhow::{Context, Result, ensure};
use carom::Scene;
use carom_methods::Method;
use carom_runs::{
    interruption::Signals,
    manifest::Manifest,
    output::Folder,
    print_line,
    progress::{Lines, Progress},
    resumable::{CHECKPOINT, FoundCheckpoint, Task, without_end},
};
use carom_tables::{Check, Figure, OneRun, Summary, Totals, Verdict};
use rayon::prelude::*;
use serde::Serialize;

use super::{
    Options, Plan,
    analysis::Analysis,
    equilibrium::Equilibrium,
    measurement::measure,
    report,
    results::{Measurement, group_name, run_name, title},
};
use crate::experiments::thesis_scene::{Case, Size, scene};

/// One run.
#[derive(Debug)]
struct Job {
    case: Case,
    size: Size,
    replica: u64,
    scene: Scene,
}

/// `summary.json`: the common summary and the tests of equilibrium.
#[derive(Debug, Serialize)]
struct Whole {
    #[serde(flatten)]
    summary: Summary,
    /// One entry for each case and size.
    verdicts: Vec<GroupEquilibrium>,
}

/// Tests of equilibrium for the runs of one case and size.
#[derive(Debug, Serialize)]
struct GroupEquilibrium {
    case: String,
    size: String,
    #[serde(flatten)]
    equilibrium: Equilibrium,
}

impl GroupEquilibrium {
    fn of(analysis: Analysis<'_>) -> Self {
        let Analysis { group, size, equilibrium, .. } = analysis;
        Self { case: group.case.name(), size: size.name(), equilibrium }
    }
}

/// A job and its stored results.
struct Run<'a> {
    job: &'a Job,
    task: &'a Task<'a>,
    found: Option<FoundCheckpoint>,
}

impl Run<'_> {
    /// Returns true if the run has ended and all its files are written.
    fn is_complete(&self) -> bool {
        let ended = self.found.as_ref().is_some_and(|found| found.has_ended(self.task.until));
        ended && Manifest::is_complete(self.task.folder)
    }
}

impl Job {
    fn task<'a>(
        &self,
        plan: &Plan,
        options: &'a Options,
        folder: &'a Folder,
        signals: &'a Signals,
    ) -> Task<'a> {
        let (from, impulses) = (plan.from, options.impulses);
        let command = format!("cargo xtask experiment brownian --from {from} --impulses {impulses}");
        Task {
            folder,
            what: without_end(&command, &self.scene),
            until: plan.until,
            samples: plan.settling().chain(plan.measuring()).count(),
            method: Method::default(),
            choices: &options.common.destination,
            signals,
        }
    }

    fn name(&self) -> String {
        run_name(self.case, self.size, self.replica)
    }
}

/// Runs the experiment and writes its folder.
///
/// # Errors
/// An option is invalid, the folder is not empty, or a run fails.
pub fn run(options: &Options) -> Result<Verdict> {
    let plan = options.plan()?;
    let signals = Signals::watch()?;
    let folder = Folder::create(&options.folder(), options.common.destination.resumption.existing())?;
    let _alone = folder.lock()?;
    let jobs = jobs(options, &plan);
    if options.common.destination.resumption.resume {
        refuse_other_layout(&jobs, &folder)?;
    }
    let folders = match jobs.as_slice() {
        [_] => vec![folder.clone()],
        jobs => jobs.iter().map(|job| folder.inner(&job.name())).collect::<Result<_>>()?,
    };
    let tasks: Vec<Task<'_>> =
        jobs.iter().zip(&folders).map(|(job, folder)| job.task(&plan, options, folder, &signals)).collect();
    // All checkpoints are read before anything is written: a folder of another campaign stays
    // unchanged.
    let found = tasks.iter().map(Task::find).collect::<Result<Vec<_>>>()?;
    let runs: Vec<Run<'_>> =
        jobs.iter().zip(&tasks).zip(found).map(|((job, task), found)| Run { job, task, found }).collect();
    let command = options.command(&plan);
    if !options.note().is_empty() {
        print_line(&options.note());
    }
    let scenes: Vec<&Scene> = jobs.iter().map(|job| &job.scene).collect();
    let manifest = Manifest::begin(&folder, &command, &scenes)?;
    let whole = match <[Run<'_>; 1]>::try_from(runs) {
        Ok([run]) => {
            let progress = Progress::new(plan.until);
            one(run, &plan, options, &progress)?.1
        }
        Err(runs) => several(&jobs, runs, &plan, options, &folder)?,
    };
    folder.write_json("summary.json", &whole)?;
    let summary = &whole.summary;
    manifest.complete(&folder, summary.totals.cpu_seconds())?;
    carom_runs::conclude(&folder, summary);
    Ok(summary.verdict())
}

/// Refuses to resume one run as a campaign of several, or the reverse: a single run is in the
/// folder itself, several are in subfolders.
fn refuse_other_layout(jobs: &[Job], folder: &Folder) -> Result<()> {
    let path = folder.path();
    match jobs {
        [job] => ensure!(
            !path.join(job.name()).join(CHECKPOINT).exists(),
            "{} holds a campaign of several runs: it cannot be resumed as one run",
            path.display()
        ),
        _ => ensure!(
            !path.join(CHECKPOINT).exists(),
            "{} holds one run: it cannot be resumed as a campaign of several",
            path.display()
        ),
    }
    Ok(())
}

fn jobs(options: &Options, plan: &Plan) -> Vec<Job> {
    let mut jobs = Vec::new();
    for case in options.case().list() {
        for size in options.size().list() {
            for replica in 0..options.replicas {
                let mut scene = scene(case, size, options.random.seed, replica, plan.run());
                for gas in &mut scene.gas {
                    gas.area_fraction = Some(options.area_fraction);
                }
                jobs.push(Job { case, size, replica, scene });
            }
        }
    }
    jobs
}

/// Executes one run in its folder; the caller writes manifest and summary.
fn one(
    Run { job, task, found }: Run<'_>,
    plan: &Plan,
    options: &Options,
    progress: &Progress,
) -> Result<(Measurement, Whole)> {
    let folder = task.folder;
    let command = options.command(plan);
    let head = format!(
        "# Written by `{command}`, replica {}.\n# The full scene; the measurement starts at t = {}.\n\n",
        job.replica, plan.from
    );
    folder.write("config.toml", head + &job.scene.to_toml())?;
    let measured = measure(task, found, &job.scene, plan, options.impulses, progress)
        .with_context(|| format!("run {}", job.name()))?;
    folder.write_table("atoms.csv", &["atom", "kicks"], measured.kicks.by_atom.iter().enumerate())?;
    let analysis = Analysis::of(job.case, job.size, std::slice::from_ref(&measured), plan.from)?;
    analysis.write(folder, "")?;
    let mut checks = measured.totals.checks();
    checks.extend(analysis.checks());
    let summary = Summary {
        title: title(job.case, job.size),
        note: options.note(),
        totals: measured.totals,
        checks,
        figures: analysis.group.figures(),
        runs: Vec::new(),
    };
    let page = report::page_of_one_run(&analysis, &summary, plan, options, folder)?;
    folder.write("report.html", page.html())?;
    let verdicts = vec![GroupEquilibrium::of(analysis)];
    Ok((measured, Whole { summary, verdicts }))
}

/// Executes all runs, each in its own folder, and writes a common page.
fn several(
    jobs: &[Job],
    runs: Vec<Run<'_>>,
    plan: &Plan,
    options: &Options,
    folder: &Folder,
) -> Result<Whole> {
    folder.write("config.toml", options.configuration(plan)?)?;
    let measured = measure_all(runs, plan, options)?;
    let all: Vec<Totals> = measured.iter().map(|run| run.totals).collect();
    let totals = Totals::of(&all);
    let mut summary = Summary {
        title: format!("Brownian motion: {} runs", jobs.len()),
        note: options.note(),
        checks: totals.checks(),
        totals,
        figures: Vec::new(),
        runs: jobs.iter().zip(&all).map(|(job, totals)| OneRun::new(job.name(), totals)).collect(),
    };
    let mut analyses = Vec::new();
    let per_group = usize::try_from(options.replicas)?;
    for (jobs, runs) in jobs.chunks(per_group).zip(measured.chunks(per_group)) {
        let (case, size) = (jobs[0].case, jobs[0].size);
        let analysis = Analysis::of(case, size, runs, plan.from)?;
        let name = group_name(case, size);
        analysis.write(folder, &format!("{name}-"))?;
        let named = |text: &str| format!("{name}: {text}");
        let checks = analysis.checks().into_iter();
        summary.checks.extend(checks.map(|check| Check { name: named(&check.name), ..check }));
        let figures = analysis.group.figures().into_iter();
        summary.figures.extend(figures.map(|figure| Figure { name: named(&figure.name), ..figure }));
        analyses.push(analysis);
    }
    let page = report::page_of_all_runs(&analyses, &summary, plan, options, folder)?;
    folder.write("report.html", page.html())?;
    Ok(Whole { summary, verdicts: analyses.into_iter().map(GroupEquilibrium::of).collect() })
}

/// Measures all runs in parallel; the results are in the order of the runs, so that the output does
/// not depend on the threads.
fn measure_all(runs: Vec<Run<'_>>, plan: &Plan, options: &Options) -> Result<Vec<Measurement>> {
    let lines = Lines::default();
    let runs: Vec<(Run<'_>, Progress)> = runs
        .into_iter()
        .map(|run| {
            let line = lines.add(&run.job.name(), plan.until);
            (run, line)
        })
        .collect();
    let command = options.command(plan);
    let run_one = |(run, progress): (Run<'_>, Progress)| -> Result<Measurement> {
        let inner = run.task.folder;
        if run.is_complete() {
            return measure(run.task, run.found, &run.job.scene, plan, options.impulses, &progress);
        }
        let manifest = Manifest::begin(inner, &command, &[&run.job.scene])?;
        let (measured, whole) = one(run, plan, options, &progress)?;
        inner.write_json("summary.json", &whole)?;
        manifest.complete(inner, whole.summary.totals.cpu_seconds())?;
        Ok(measured)
    };
    options.threads.pool()?.install(|| runs.into_par_iter().map(run_one).collect())
}
