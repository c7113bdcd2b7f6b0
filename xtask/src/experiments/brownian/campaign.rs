//! Execution of all requested runs in parallel, and their output.

use anyhow::{Context, Result, ensure};
use carom::Scene;
use carom_report::page::Page;
use carom_runs::{
    interruption::Signals,
    manifest::Manifest,
    output::Folder,
    progress::{Lines, Progress},
    resumable::{CHECKPOINT, Found, Task, without_end},
    say,
};
use carom_tables::{Check, Figure, OneRun, Summary, Totals, Verdict};
use rayon::prelude::*;
use serde::Serialize;

use super::{
    Options, Plan,
    distributions::{CONTACT_HEADER, Distributions, PROJECTION_HEADER, contact_rows, projection_rows},
    group::Group,
    measurement::{Measurement, measure},
    report::{self, Charts, DIRECTION_HEADER, direction_rows},
    system,
    verdict::Verdict as Equilibrium,
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

/// `summary.json`: the common summary and the verdicts.
#[derive(Debug, Serialize)]
struct Whole {
    #[serde(flatten)]
    summary: Summary,
    /// One verdict for each case and size.
    verdicts: Vec<Judged>,
}

/// Verdict on equilibrium for the runs of one case and size.
#[derive(Debug, Serialize)]
struct Judged {
    case: String,
    size: String,
    #[serde(flatten)]
    verdict: Equilibrium,
}

impl Judged {
    fn new(group: &Group<'_>, size: Size) -> Self {
        Self { case: group.case.name(), size: size.name(), verdict: Equilibrium::of(group) }
    }
}

/// A job and its stored results.
struct Run<'a> {
    job: &'a Job,
    task: &'a Task<'a>,
    found: Option<Found>,
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
            choices: &options.common.destination,
            signals,
        }
    }

    fn name(&self) -> String {
        format!("{}-{}-{}", self.case.name(), self.size.name(), self.replica)
    }

    fn title(&self) -> String {
        title(self.case, self.size)
    }
}

fn title(case: Case, size: Size) -> String {
    format!("Brownian motion: {}, relative size {}", case.name(), size.name())
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
        say(&options.note());
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
    let runs = std::slice::from_ref(&measured);
    let group = Group::new(job.case, runs, plan.from).context("the run has no kicks")?;
    let (charts, more) = (Charts::draw(&group)?, Distributions::draw(&group)?);
    write_group(folder, "", &group, &charts, &more)?;
    let judged = Judged::new(&group, job.size);
    let mut checks = measured.totals.checks();
    checks.extend(group.checks());
    checks.extend(judged.verdict.checks());
    let summary = Summary {
        title: job.title(),
        note: options.note(),
        totals: measured.totals,
        checks,
        figures: group.figures(),
        runs: Vec::new(),
    };
    let mut page = Page::new(&job.title(), group.case.words());
    if !summary.note.is_empty() {
        page.note(&summary.note);
    }
    report::question(&mut page, options.area_fraction);
    page.heading("Runs");
    report::setting(&mut page, &group, job.size, plan);
    totals(&mut page, &summary);
    system::of_one_run(&mut page, &group, &charts, folder, plan)?;
    page.heading("Results");
    judged.verdict.show(&mut page);
    page.subheading("Figures");
    page.figures(&summary.figures);
    report::charts(&mut page, &group, &charts);
    more.show(&mut page, job.case);
    again(&mut page, &command);
    report::data(&mut page, group.kicks.hits(), options.impulses);
    page.links(["impulses.csv", "directions.csv", "kicks-along-axes.csv", "contact-density.csv"]);
    page.links(["running-average.csv", "energy.csv", "collision-rate.csv", "atoms.csv", "flights.csv"]);
    page.links(["start.extxyz", "end.extxyz", "summary.json", "manifest.json", "config.toml"]);
    folder.write("report.html", page.html())?;
    let verdicts = vec![judged];
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
    folder.write("config.toml", campaign_config(options, plan)?)?;
    let lines = Lines::default();
    let runs: Vec<(Run<'_>, Progress)> = runs
        .into_iter()
        .map(|run| {
            let line = lines.add(&run.job.name(), plan.until);
            (run, line)
        })
        .collect();
    let pool = options.threads.pool()?;
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
    // In the order of the jobs, so that the output does not depend on the threads.
    let measured: Vec<Measurement> =
        pool.install(|| runs.into_par_iter().map(run_one).collect::<Result<_>>())?;

    let all: Vec<Totals> = measured.iter().map(|run| run.totals).collect();
    let totals_of_all = Totals::of(&all);
    let mut summary = Summary {
        title: format!("Brownian motion: {} runs", jobs.len()),
        note: options.note(),
        checks: totals_of_all.checks(),
        totals: totals_of_all,
        figures: Vec::new(),
        runs: jobs.iter().zip(&all).map(|(job, totals)| OneRun::new(job.name(), totals)).collect(),
    };
    let mut sections = Page::section();
    let mut verdicts = Vec::new();
    let per_group = usize::try_from(options.replicas)?;
    for (jobs, runs) in jobs.chunks(per_group).zip(measured.chunks(per_group)) {
        let (case, size) = (jobs[0].case, jobs[0].size);
        let group = Group::new(case, runs, plan.from).context("the run has no kicks")?;
        let name = format!("{}-{}", case.name(), size.name());
        let (charts, more) = (Charts::draw(&group)?, Distributions::draw(&group)?);
        write_group(folder, &format!("{name}-"), &group, &charts, &more)?;
        let named = |text: &str| format!("{name}: {text}");
        let judged = Judged::new(&group, size);
        let checks = group.checks().into_iter().chain(judged.verdict.checks());
        summary.checks.extend(checks.map(|check| Check { name: named(&check.name), ..check }));
        let figures = group.figures();
        sections.heading(&title(case, size));
        report::setting(&mut sections, &group, size, plan);
        system::of_molecule(&mut sections, &group, &charts, &folder.inner(&jobs[0].name())?)?;
        judged.verdict.show(&mut sections);
        verdicts.push(judged);
        sections.subheading("Figures");
        sections.figures(&figures);
        report::charts(&mut sections, &group, &charts);
        more.show(&mut sections, case);
        let reports: Vec<String> = jobs.iter().map(|job| format!("{}/report.html", job.name())).collect();
        sections.links(reports.iter().map(String::as_str));
        summary
            .figures
            .extend(figures.into_iter().map(|figure| Figure { name: named(&figure.name), ..figure }));
    }
    let mut page = Page::new(&summary.title, "A T of five discs, and a disc, in a gas of discs.");
    if !summary.note.is_empty() {
        page.note(&summary.note);
    }
    report::question(&mut page, options.area_fraction);
    page.heading("Runs");
    totals(&mut page, &summary);
    page.heading("System");
    page.paragraph(&format!("Run {}; each run has its own page and animation.", jobs[0].name()));
    let first = folder.inner(&jobs[0].name())?;
    system::moving(&mut page, &first, plan)?;
    system::before_and_after(&mut page, &first, plan)?;
    page.append(&sections);
    again(&mut page, &command);
    page.links(["summary.json", "manifest.json", "config.toml"]);
    folder.write("report.html", page.html())?;
    Ok(Whole { summary, verdicts })
}

/// Writes the charts of a group and their data.
fn write_group(
    folder: &Folder,
    prefix: &str,
    group: &Group<'_>,
    charts: &Charts,
    more: &Distributions,
) -> Result<()> {
    for (file, picture) in charts.files().into_iter().chain(more.files()) {
        folder.write(&format!("{prefix}{file}"), picture)?;
    }
    let name = |table: &str| format!("{prefix}{table}.csv");
    folder.write_table(&name("directions"), &DIRECTION_HEADER, direction_rows(group))?;
    folder.write_table(&name("kicks-along-axes"), &PROJECTION_HEADER, projection_rows(group))?;
    folder.write_table(&name("contact-density"), &CONTACT_HEADER, contact_rows(group))
}

/// Totals and checks of the whole campaign.
fn totals(page: &mut Page, summary: &Summary) {
    page.totals(&summary.totals);
    if !summary.runs.is_empty() {
        page.runs(&summary.runs);
    }
    page.subheading("Checks");
    page.checks(&summary.checks);
}

fn again(page: &mut Page, command: &str) {
    page.heading("Reproduction");
    page.paragraph("The same seed gives the same figures to the last bit for any number of threads.");
    page.code(command);
}

/// `config.toml` of a campaign: its options; each run's folder holds its scene.
fn campaign_config(options: &Options, plan: &Plan) -> Result<String> {
    #[derive(Serialize)]
    struct Config {
        experiment: Experiment,
    }
    #[derive(Serialize)]
    struct Experiment {
        name: &'static str,
        case: String,
        size: String,
        seed: u64,
        replicas: u64,
        area_fraction: f64,
        from: f64,
        until: f64,
        sample_interval: f64,
        command: String,
    }
    let experiment = Experiment {
        name: "brownian",
        case: options.case().name(),
        size: options.size().name(),
        seed: options.random.seed,
        replicas: options.replicas,
        area_fraction: options.area_fraction,
        from: plan.from,
        until: plan.until,
        sample_interval: plan.sample_interval,
        command: options.command(plan),
    };
    Ok(toml::to_string_pretty(&Config { experiment })?)
}
