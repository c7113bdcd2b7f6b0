//! Execution of all runs in parallel, and their output.

use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use carom::Scene;
use carom_methods::{AnySimulation, Method};
use carom_runs::{
    console::note,
    interruption::Signals,
    manifest::Manifest,
    output::Folder,
    print_line,
    progress::{Lines, Progress},
    resumable::{CHECKPOINT, FoundCheckpoint, Task, without_end},
};
use carom_tables::{Check, Figure, OVERLAPPING_PAIRS, OneRun, Summary, Totals, Verdict};
use rayon::prelude::*;
use serde::Serialize;

use super::{
    analysis::Analysis, campaign::Campaign, equilibrium::Equilibrium, measurement::measure, report,
    results::Measurement, setting::Setting,
};

/// One run.
#[derive(Debug)]
struct Job<'a> {
    setting: &'a Setting,
    replica: u64,
    scene: Scene,
}

/// `summary.json`: the common summary and the tests of equilibrium.
#[derive(Debug, Serialize)]
struct Whole {
    #[serde(flatten)]
    summary: Summary,
    /// One entry for each molecule.
    verdicts: Vec<GroupEquilibrium>,
}

/// Tests of equilibrium for the runs of one molecule.
#[derive(Debug, Serialize)]
struct GroupEquilibrium {
    name: String,
    verdict: String,
    #[serde(flatten)]
    equilibrium: Equilibrium,
}

impl GroupEquilibrium {
    fn of(Analysis { group, equilibrium, .. }: Analysis<'_>) -> Self {
        Self { name: group.setting.name.clone(), verdict: equilibrium.sentence(), equilibrium }
    }
}

/// A job and its stored results.
struct Run<'a> {
    job: &'a Job<'a>,
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

impl Job<'_> {
    fn task<'a>(
        &self,
        campaign: &Campaign<'a>,
        folder: &'a Folder,
        signals: &'a Signals,
    ) -> Result<Task<'a>> {
        let Campaign { program, plan, impulses, choices, .. } = campaign;
        let command = format!("{program} --from {} --impulses {impulses}", plan.from);
        Ok(Task {
            folder,
            what: without_end(&command, &self.scene),
            until: plan.until,
            samples: plan.settling().chain(plan.measuring()).count(),
            method: self.setting.method()?,
            threads: 1,
            choices,
            signals,
        })
    }

    fn name(&self) -> String {
        self.setting.run_name(self.replica)
    }
}

/// Runs the experiment and writes its folder.
///
/// # Errors
/// A scene is invalid, the folder is not empty, or a run fails.
pub fn run_campaign(campaign: &Campaign<'_>) -> Result<Verdict> {
    let signals = Signals::watch()?;
    let resumption = &campaign.choices.resumption;
    let path: PathBuf = resumption.folder(&campaign.usual_folder);
    let jobs = jobs(campaign);
    if !resumption.resume {
        refuse_impossible(&jobs)?;
    }
    let (folder, _alone) = Folder::claim(&path, resumption.existing())?;
    if resumption.resume {
        refuse_other_layout(&jobs, &folder)?;
    }
    let folders = match jobs.as_slice() {
        [_] => vec![folder.clone()],
        jobs => jobs.iter().map(|job| folder.inner(&job.name())).collect::<Result<_>>()?,
    };
    let tasks: Vec<Task<'_>> = jobs
        .iter()
        .zip(&folders)
        .map(|(job, folder)| job.task(campaign, folder, &signals))
        .collect::<Result<_>>()?;
    // All checkpoints are read before anything is written: a folder of another campaign stays
    // unchanged.
    let found = tasks.iter().map(Task::find).collect::<Result<Vec<_>>>()?;
    let runs: Vec<Run<'_>> =
        jobs.iter().zip(&tasks).zip(found).map(|((job, task), found)| Run { job, task, found }).collect();
    if !campaign.note.is_empty() {
        note(&campaign.note);
    }
    let scenes: Vec<&Scene> = jobs.iter().map(|job| &job.scene).collect();
    let manifest = Manifest::begin(&folder, &campaign.command, &scenes)?;
    let whole = match <[Run<'_>; 1]>::try_from(runs) {
        Ok([run]) => one(run, campaign, &Progress::new(campaign.plan.until))?.1,
        Err(runs) => several(&jobs, runs, campaign, &folder)?,
    };
    folder.write_json("summary.json", &whole)?;
    let summary = &whole.summary;
    manifest.complete(&folder, summary.totals.cpu_seconds())?;
    for verdict in &whole.verdicts {
        print_line(&format!("{}: {}", verdict.name, verdict.verdict));
    }
    carom_runs::conclude(&folder, summary);
    Ok(summary.verdict())
}

/// Refuses scenes whose bodies cannot be placed, before a folder is made.
fn refuse_impossible(jobs: &[Job<'_>]) -> Result<()> {
    jobs.par_iter().filter(|job| job.replica == 0).try_for_each(|job| {
        let placed = AnySimulation::with(&job.scene, &job.setting.method()?);
        placed.map(drop).with_context(|| format!("run {}", job.name()))
    })
}

/// Refuses to resume one run as a campaign of several, or the reverse: a single run is in the
/// folder itself, several are in subfolders.
fn refuse_other_layout(jobs: &[Job<'_>], folder: &Folder) -> Result<()> {
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

fn jobs<'a>(campaign: &'a Campaign<'_>) -> Vec<Job<'a>> {
    let job = |setting: &'a Setting, replica| {
        let mut scene = setting.scene.clone();
        (scene.bounds.seed, scene.bounds.replica) = (campaign.seed, replica);
        scene.run = campaign.plan.run(scene.run);
        Job { setting, replica, scene }
    };
    let of_setting = |setting| (0..campaign.replicas).map(move |replica| job(setting, replica));
    campaign.settings.iter().flat_map(of_setting).collect()
}

/// Executes one run in its folder; the caller writes manifest and summary.
fn one(
    Run { job, task, found }: Run<'_>,
    campaign: &Campaign<'_>,
    progress: &Progress,
) -> Result<(Measurement, Whole)> {
    let (folder, plan) = (task.folder, &campaign.plan);
    let head = format!(
        "# Written by `{}`, replica {}.\n# The full scene; the measurement starts at t = {}.\n\n",
        campaign.command, job.replica, plan.from
    );
    folder.write("config.toml", head + &job.scene.to_toml())?;
    let measured = measure(task, found, (job.setting, &job.scene), plan, campaign.impulses, progress)
        .with_context(|| format!("run {}", job.name()))?;
    folder.write_table("atoms.csv", &["atom", "kicks"], measured.kicks.by_atom.iter().enumerate())?;
    let analysis = Analysis::of(job.setting, std::slice::from_ref(&measured), plan.from)?;
    analysis.write(folder, "")?;
    let mut checks = run_checks(&measured.totals, &task.method);
    checks.extend(analysis.checks());
    let summary = Summary {
        title: title(job.setting),
        note: campaign.note.clone(),
        totals: measured.totals,
        checks,
        figures: analysis.group.figures(),
        runs: Vec::new(),
    };
    let page = report::page_of_one_run(&analysis, &summary, campaign, folder)?;
    folder.write("report.html", page.html())?;
    let verdicts = vec![GroupEquilibrium::of(analysis)];
    Ok((measured, Whole { summary, verdicts }))
}

/// Checks of energy and overlaps; a method that is not exact may let bodies overlap.
fn run_checks(totals: &Totals, method: &Method) -> Vec<Check> {
    let mut checks = totals.checks();
    checks.retain(|check| method.is_exact() || check.name != OVERLAPPING_PAIRS);
    checks
}

/// Title of the runs of a molecule.
fn title(setting: &Setting) -> String {
    format!("Brownian motion: {}", setting.title)
}

/// Executes all runs, each in its own folder, and writes a common page.
fn several(jobs: &[Job<'_>], runs: Vec<Run<'_>>, campaign: &Campaign<'_>, folder: &Folder) -> Result<Whole> {
    folder.write("config.toml", &campaign.configuration)?;
    let measured = measure_all(runs, campaign)?;
    let all: Vec<Totals> = measured.iter().map(|run| run.totals).collect();
    let totals = Totals::of(&all);
    let mut summary = Summary {
        title: campaign.title.clone(),
        note: campaign.note.clone(),
        checks: run_checks(&totals, &campaign.settings[0].method()?),
        totals,
        figures: Vec::new(),
        runs: jobs.iter().zip(&all).map(|(job, totals)| OneRun::new(job.name(), totals)).collect(),
    };
    let mut analyses = Vec::new();
    let per_group = usize::try_from(campaign.replicas)?;
    for (setting, runs) in campaign.settings.iter().zip(measured.chunks(per_group)) {
        let analysis = Analysis::of(setting, runs, campaign.plan.from)?;
        let name = &setting.name;
        analysis.write(folder, &format!("{name}-"))?;
        let named = |text: &str| format!("{name}: {text}");
        let checks = analysis.checks().into_iter();
        summary.checks.extend(checks.map(|check| Check { name: named(&check.name), ..check }));
        let figures = analysis.group.figures().into_iter();
        summary.figures.extend(figures.map(|figure| Figure { name: named(&figure.name), ..figure }));
        analyses.push(analysis);
    }
    let page = report::page_of_all_runs(&analyses, &summary, campaign, folder)?;
    folder.write("report.html", page.html())?;
    Ok(Whole { summary, verdicts: analyses.into_iter().map(GroupEquilibrium::of).collect() })
}

/// Measures all runs in parallel; the results are in the order of the runs, so that the output does
/// not depend on the threads.
fn measure_all(runs: Vec<Run<'_>>, campaign: &Campaign<'_>) -> Result<Vec<Measurement>> {
    let lines = Lines::default();
    let runs: Vec<(Run<'_>, Progress)> = runs
        .into_iter()
        .map(|run| {
            let line = lines.add(&run.job.name(), campaign.plan.until);
            (run, line)
        })
        .collect();
    let run_one = |(run, progress): (Run<'_>, Progress)| -> Result<Measurement> {
        let inner = run.task.folder;
        if run.is_complete() {
            let scene = (run.job.setting, &run.job.scene);
            return measure(run.task, run.found, scene, &campaign.plan, campaign.impulses, &progress);
        }
        let manifest = Manifest::begin(inner, &campaign.command, &[&run.job.scene])?;
        let (measured, whole) = one(run, campaign, &progress)?;
        inner.write_json("summary.json", &whole)?;
        manifest.complete(inner, whole.summary.totals.cpu_seconds())?;
        Ok(measured)
    };
    campaign.threads.pool()?.install(|| runs.into_par_iter().map(run_one).collect())
}
