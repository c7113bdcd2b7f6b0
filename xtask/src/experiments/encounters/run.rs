//! Execution of the experiment: cases, answers, times, and output files.

use std::fmt::Write as _;

use anyhow::Result;
use carom_detection::{Answer, Outcome};
use carom_runs::{
    experiment::{Experiment, Opening, configuration},
    output::Folder,
    print_line,
    work_items::WorkItems,
};
use carom_tables::{Check, Summary, Verdict};
use rayon::{ThreadPool, prelude::*};
use serde::{Deserialize, Serialize};

use super::{
    Options,
    cases::{self, CaseGroup},
    charts::EncounterCharts,
    options::EncounterPlan,
    overall,
    parry::{Cast, ParryProcess},
    report,
    results::{ClassResult, EncounterResults, ParryResult},
    settings::{DetectorSetting, settings},
    tally::EncounterTally,
    timing,
};
use carom_methods::AnyDetector;

/// Largest number of violations that are printed in full.
const MAX_PRINTED: usize = 20;

/// Answers of all detectors for one class.
#[derive(Debug, Serialize, Deserialize)]
struct Answers {
    unresolved: usize,
    tallies: Vec<EncounterTally>,
}

/// Runs the experiment and writes its folder.
///
/// # Errors
/// The folder is not empty or cannot be written, or a recorded run fails.
pub fn run(options: &Options) -> Result<Verdict> {
    let (plan, command) = (EncounterPlan::new(options), options.command("encounters"));
    let note = options
        .common
        .note(": rates below about 1e-3 are not resolved. The full run is --paper.");
    let experiment = Experiment::start_resumable(
        &options.common.destination,
        command.clone(),
        &Opening {
            folder: "out/encounters",
            note: &note,
            command: &command,
            configuration: configuration(&command, &settings_of(options, &plan)),
            scenes: &[],
        },
    )?;
    let (folder, items) = (&experiment.folder, &experiment.items);
    let pool = options.threads.pool()?;
    let (groups, totals) = pool.install(|| cases::groups(options.random.seed, &plan))?;
    print_line(&format!(
        "{} cases of {} classes",
        groups.iter().map(|g| g.cases.len()).sum::<usize>(),
        groups.len()
    ));
    let results = measure(&groups, &plan, &pool, items)?;
    write_tables(folder, &results)?;
    let broken = violations(&results, &groups);
    if !broken.is_empty() {
        folder.write("violations.txt", &broken)?;
        print_line(&broken);
    }
    let summary = Summary {
        title: "Encounters: the cost of accuracy in the search for one contact".to_owned(),
        note,
        totals,
        checks: [checks(&results), totals.checks()].concat(),
        figures: overall::figures(&results),
        runs: Vec::new(),
    };
    let charts = EncounterCharts::draw(&results)?;
    for (name, svg) in charts.files() {
        folder.write(name, svg)?;
    }
    experiment.finish(
        &report::page(&results, &summary, &charts, &command),
        &summary,
        None,
    )
}

fn settings_of(options: &Options, plan: &EncounterPlan) -> String {
    format!(
        "seed = {}\ncases_of_each_class = {}\nmost_intervals_of_the_oracle = {}\n\
         most_evaluations_of_each_detector_in_a_class = {}\nrounds_of_times = {}\ncalls_of_parry_in_a_class = {}\n",
        options.random.seed,
        plan.cases,
        plan.most_intervals,
        plan.most_evaluations,
        plan.rounds,
        plan.parry_cases,
    )
}

/// Runs all detectors and parry on all cases, and measures the times of the detectors.
fn measure(
    groups: &[CaseGroup],
    plan: &EncounterPlan,
    pool: &ThreadPool,
    items: &WorkItems,
) -> Result<EncounterResults> {
    items.expect(2 * groups.len() + plan.parry_cases);
    let settings = settings();
    let answers = pool.install(|| search_all(groups, &settings, plan, items))?;
    print_line("answers judged; measuring times");
    let parries = search_with_parry(groups, plan, items)?;
    let mut classes = Vec::new();
    for ((group, answers), parry) in groups.iter().zip(answers).zip(parries) {
        let Answers {
            unresolved,
            tallies,
        } = answers;
        let detectors: Vec<(AnyDetector, &EncounterTally)> = settings
            .iter()
            .map(|setting| setting.detector)
            .zip(&tallies)
            .collect();
        let timings = items.finish(&format!("times of {}", group.name), || {
            Ok(timing::time(&detectors, &group.cases, plan.rounds))
        })?;
        classes.push(ClassResult {
            name: group.name.clone(),
            about: group.about.clone(),
            unresolved,
            tallies,
            timings,
            parry,
        });
    }
    Ok(EncounterResults { settings, classes })
}

/// Runs all detectors on all cases; for each group, the answers at each setting.
fn search_all(
    groups: &[CaseGroup],
    settings: &[DetectorSetting],
    plan: &EncounterPlan,
    items: &WorkItems,
) -> Result<Vec<Answers>> {
    let of_group = |group: &CaseGroup| {
        items.finish(&format!("answers about {}", group.name), || {
            group.solve();
            let of_setting = |setting: &DetectorSetting| {
                EncounterTally::new(setting.detector, &group.cases, plan)
            };
            let tallies = settings.par_iter().map(of_setting).collect();
            Ok(Answers {
                unresolved: group.unresolved(),
                tallies,
            })
        })
    };
    groups.par_iter().map(of_group).collect()
}

/// Runs parry on the first cases of all groups in turn, until too many calls have not returned.
fn search_with_parry(
    groups: &[CaseGroup],
    plan: &EncounterPlan,
    items: &WorkItems,
) -> Result<Vec<ParryResult>> {
    let mut worker = None;
    let mut rounds: Vec<Vec<ParryResult>> = Vec::new();
    let mut hung = 0;
    for index in 0..plan.parry_cases {
        let round: Vec<ParryResult> = items.finish(&format!("parry about case {index}"), || {
            let worker = match &mut worker {
                Some(worker) => worker,
                none => none.insert(ParryProcess::start()?),
            };
            let mut hung = hung;
            groups
                .iter()
                .map(|group| search_once_with_parry(worker, group, index, plan, &mut hung))
                .collect()
        })?;
        hung += round.iter().map(|result| result.hung).sum::<usize>();
        rounds.push(round);
    }
    let of_group = |group| ParryResult::sum(rounds.iter().map(move |round| &round[group]));
    Ok((0..groups.len()).map(of_group).collect())
}

/// Runs parry on one case, unless too many calls have not returned.
fn search_once_with_parry(
    worker: &mut ParryProcess,
    group: &CaseGroup,
    index: usize,
    plan: &EncounterPlan,
    hung: &mut usize,
) -> Result<ParryResult> {
    let mut result = ParryResult::default();
    let Some(case) = group.cases.get(index).filter(|_| *hung < plan.most_hung) else {
        return Ok(result);
    };
    result.calls = 1;
    let answer = match worker.search(&case.encounter)? {
        Cast::Hung => {
            *hung += 1;
            result.hung = 1;
            Answer {
                outcome: Outcome::Unresolved(0.0),
                evaluations: 0,
            }
        }
        Cast::Returned { answer, ratio } => {
            result.ratios.push(ratio);
            answer
        }
    };
    result.tally.add(
        index,
        case,
        case.reference().judge(&case.encounter, &answer),
    );
    Ok(result)
}

fn write_tables(folder: &Folder, results: &EncounterResults) -> Result<()> {
    let rows = results.classes.iter().flat_map(|class| {
        let own = results.settings.iter().zip(&class.tallies);
        own.map(|(setting, tally)| tally.row(&class.name, setting.detector.name(), &setting.name))
    });
    folder.write_records("answers.csv", rows)?;
    let times = results.classes.iter().flat_map(|class| {
        let own = results.settings.iter().zip(&class.timings);
        own.filter_map(|(setting, timing)| {
            let timing = (*timing)?;
            let (detector, name) = (setting.detector.name(), setting.name.clone());
            Some((
                class.name.clone(),
                detector,
                name,
                timing.cases,
                timing.ratio,
                timing.exact * 1e9,
            ))
        })
    });
    let header = [
        "class",
        "detector",
        "setting",
        "cases",
        "time_over_exact",
        "exact_ns",
    ];
    folder.write_table("times.csv", &header, times)?;
    let parry = results.classes.iter().map(|class| {
        class
            .parry
            .tally
            .row(&class.name, "parry", "nonlinear cast")
    });
    folder.write_records("parry.csv", parry)
}

/// Checks of the guarantees of [`carom_detection::Exact`] over all classes.
fn checks(results: &EncounterResults) -> Vec<Check> {
    use carom_testkit::oracle::OracleVerdict::{Early, False, Late, Missed};
    let exact = results
        .settings
        .iter()
        .map(|setting| matches!(setting.detector, AnyDetector::Exact(_)));
    let exact: Vec<usize> = exact
        .enumerate()
        .filter(|(_, is)| *is)
        .map(|(index, _)| index)
        .collect();
    let count = |verdict| -> u64 {
        let of_class = |class: &ClassResult| {
            exact
                .iter()
                .map(|&index| class.tallies[index].count(verdict))
                .sum::<u64>()
        };
        results.classes.iter().map(of_class).sum()
    };
    [
        ("missed", Missed),
        ("late", Late),
        ("early", Early),
        ("false", False),
    ]
    .map(|(name, verdict)| {
        Check::at_most(
            &format!("contacts {name} by Exact"),
            count(verdict) as f64,
            0.0,
        )
    })
    .to_vec()
}

/// Full description of the cases that violate the guarantees of [`carom_detection::Exact`].
fn violations(results: &EncounterResults, groups: &[CaseGroup]) -> String {
    let mut text = String::new();
    let mut printed = 0;
    for (class, group) in results.classes.iter().zip(groups) {
        for (setting, tally) in results.settings.iter().zip(&class.tallies) {
            if !matches!(setting.detector, AnyDetector::Exact(_)) {
                continue;
            }
            for (index, judgement) in tally
                .violations
                .iter()
                .take(MAX_PRINTED.saturating_sub(printed))
            {
                printed += 1;
                let case = &group.cases[*index];
                let (encounter, reference) = (&case.encounter, case.reference());
                let answer = encounter.first_contact(&setting.detector);
                let _ = writeln!(
                    text,
                    "{} {index}, Exact with {}: {judgement:?}\n  {answer:?}\n  {reference:?}\n  {encounter:?}",
                    class.name, setting.name
                );
            }
        }
    }
    text
}
