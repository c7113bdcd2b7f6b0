//! Kinetic theory as studies: each experiment sweeps the scenes of `xtask/studies/theory` and
//! compares what they measure with `[[expect]]` of the study.
//!
//! `carom sweep` runs each study as well. An experiment of several studies has a folder for each,
//! and a page with their verdicts.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use carom_experiments::common::{Common, Threads};
use carom_report::page::{Page, Part};
use carom_runs::{
    console::put,
    manifest::Manifest,
    output::{Destination, Folder, Resumption},
    print_line,
    resumable::Choices,
};
use carom_sweeps::sweep;
use carom_tables::Verdict;
use clap::Args;
use cpu_time::ProcessTime;
use serde_json::{Value, json};

use super::json_checks::{checks, failures};

/// Options of an experiment that consists of studies.
#[derive(Debug, Clone, Args)]
#[command(
    mut_arg("quick", |arg| arg.help("The short form of each study, under two minutes (the default)")),
    mut_arg("paper", |arg| arg.help("The whole studies, for publication"))
)]
pub struct Options {
    /// Options of every experiment.
    #[command(flatten)]
    pub common: Common<Choices>,
    /// Threads.
    #[command(flatten)]
    pub threads: Threads,
}

/// A question, and the studies that answer it.
#[derive(Debug, Clone, Copy)]
pub struct Theory {
    /// Name of the experiment.
    pub name: &'static str,
    /// The question.
    pub question: &'static str,
    /// Names of the study files.
    pub studies: &'static [&'static str],
}

/// Pressure, velocities, equipartition and isotropy.
pub const EQUILIBRIUM: Theory = Theory {
    name: "equilibrium",
    question: "Do hard discs and mixtures of molecules reach the equilibrium of theory and of published pressures?",
    studies: &["equilibrium", "published-pressures", "walls", "mixture"],
};

/// The loop of the pressure between liquid and hexatic.
pub const FREEZING: Theory = Theory {
    name: "freezing",
    question: "Do hard discs freeze at the published pressures of equal number and box?",
    studies: &["freezing"],
};

/// Boltzmann's H-theorem.
pub const RELAXATION: Theory = Theory {
    name: "relaxation",
    question: "Does a gas of equal speeds become Maxwellian as fast as Boltzmann's equation predicts?",
    studies: &["relaxation", "mixing"],
};

/// Second virial coefficients of molecules.
pub const VIRIAL: Theory = Theory {
    name: "virial",
    question: "Is the pressure of thin gases of molecules that of their excluded areas?",
    studies: &["virial"],
};

/// Diffusion, Brownian motion and transport coefficients.
pub const DIFFUSION: Theory = Theory {
    name: "diffusion",
    question: "Do discs, a heavy disc, rods, momentum and heat spread as kinetic theory predicts?",
    studies: &["self-diffusion", "velocity-tail", "heavy-disc", "fixed-disc", "rods", "transport"],
};

/// Forces between big discs among small ones.
pub const DEPLETION: Theory = Theory {
    name: "depletion",
    question: "With which force do small discs push two big ones together?",
    studies: &["depletion", "depletion-wall", "depletion-plates", "depletion-free"],
};

/// Haff's law, and inelastic collapse.
pub const COOLING: Theory = Theory {
    name: "cooling",
    question: "Does an inelastic gas cool by Haff's law, and when do three discs collapse?",
    studies: &["cooling", "cooling-per-collision", "collapse"],
};

/// Haff's law above elasticity 1.
pub const HEATING: Theory = Theory {
    name: "heating",
    question: "Does a gas whose contacts gain energy heat up by Haff's law?",
    studies: &["heating"],
};

/// Two temperatures in one box.
pub const THERMOSTAT: Theory = Theory {
    name: "thermostat",
    question: "How much heat flows between groups at two temperatures?",
    studies: &["two-temperatures"],
};

/// Directed motion out of equilibrium.
pub const RATCHET: Theory = Theory {
    name: "ratchet",
    question: "Does an asymmetric molecule drift in a gas, in equilibrium and out of it?",
    studies: &["ratchet", "ratchet-resets", "motor"],
};

impl Theory {
    /// All experiments that consist of studies.
    pub const ALL: [Self; 10] = [
        EQUILIBRIUM,
        FREEZING,
        RELAXATION,
        VIRIAL,
        DIFFUSION,
        DEPLETION,
        COOLING,
        HEATING,
        THERMOSTAT,
        RATCHET,
    ];

    /// Runs the studies, and writes a page about them if there are several.
    ///
    /// # Errors
    /// Those of [`sweep::run`], and a file that cannot be written.
    pub fn run(&self, options: &Options) -> Result<Verdict> {
        let resumption = &options.common.destination.resumption;
        let folder = resumption.folder(&format!("out/{}", self.name));
        if let [study] = self.studies {
            return sweep::run(&sweep_options(study, folder, options));
        }
        let (folder, _lock) = Folder::claim(&folder, resumption.existing())?;
        let begun = ProcessTime::now();
        let manifest = Manifest::begin(&folder, &options.common.command(self.name), &[])?;
        let mut verdicts = Vec::new();
        // Each study has a folder inside.
        for study in self.studies {
            print_line(&format!("{}: {study}", self.name));
            verdicts.push(sweep::run(&sweep_options(study, folder.path().join(study), options))?);
        }
        self.write_results(&folder, options)?;
        manifest.complete(&folder, begun.elapsed().as_secs_f64())?;
        Ok(verdicts.into_iter().find(|verdict| *verdict == Verdict::Failed).unwrap_or(Verdict::Passed))
    }

    /// Page and summary of an experiment of several studies: the verdict of each, and what differs.
    fn write_results(&self, folder: &Folder, options: &Options) -> Result<()> {
        let mut page = Page::new(&format!("Experiment {}", self.name), self.question);
        let (mut rows, mut files, mut all, mut failed) = (Vec::new(), Vec::new(), Vec::new(), 0);
        let mut studies = Vec::new();
        for study in self.studies {
            let outcome = Outcome::read(&folder.path().join(study))?;
            let failures = failures(&outcome.checks);
            failed += failures.len();
            rows.push(vec![
                (*study).to_owned(),
                outcome.checks.len().to_string(),
                failures.len().to_string(),
                outcome.collisions.to_string(),
            ]);
            for failure in failures {
                page.error(&format!("{study}: {failure}"));
            }
            all.extend(outcome.checks);
            studies
                .push(json!({ "study": study, "collisions": outcome.collisions, "points": outcome.points }));
            files.push((format!("{study}/report.html"), format!("the page of the study {study}")));
        }
        page.verdict(&match failed {
            0 => "All quantities are as expected.".to_owned(),
            1 => "1 quantity is not as expected.".to_owned(),
            _ => format!("{failed} quantities are not as expected."),
        });
        page.part(Part::Answer);
        page.table(&["study", "checks", "failed", "collisions"], &rows);
        files.push(("summary.json".to_owned(), "what was expected and found in all studies".to_owned()));
        page.files(&files);
        page.code(&options.common.command(self.name));
        // Each study has put its own: the last one's would be taken for those of the experiment.
        put("folder", &folder.path());
        put("page", &folder.path().join("report.html"));
        put("checks", &all);
        let summary = json!({ "title": self.name, "note": self.question, "checks": all, "studies": studies });
        folder.write_json("summary.json", &summary)?;
        folder.write("report.html", page.html())
    }
}

/// The options of the sweep of a study in a folder of its own.
fn sweep_options(study: &str, folder: PathBuf, options: &Options) -> sweep::Options {
    let choices = &options.common.destination;
    let destination = Destination { out: Some(folder), ..choices.resumption.destination.clone() };
    sweep::Options {
        study: study_file(study),
        choices: Choices {
            resumption: Resumption { destination, ..choices.resumption.clone() },
            ..choices.clone()
        },
        replicas: None,
        quick: options.common.is_quick(),
        threads: options.threads.threads,
        shard: None,
        slurm: carom_sweeps::slurm::Options::default(),
    }
}

/// The file of a study in the repository.
pub fn study_file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/theory").join(format!("{name}.toml"))
}

/// What `summary.json` of a sweep says.
struct Outcome {
    checks: Vec<Value>,
    collisions: u64,
    /// Label and expected quantities of each point.
    points: Vec<Value>,
}

impl Outcome {
    fn read(folder: &Path) -> Result<Self> {
        let path = folder.join("summary.json");
        let shown = path.display();
        let text = std::fs::read_to_string(&path).with_context(|| format!("cannot read {shown}"))?;
        let summary: Value = serde_json::from_str(&text).with_context(|| format!("{shown}"))?;
        ensure!(summary["checks"].is_array(), "{shown} has no checks");
        let points = summary["points"].as_array().into_iter().flatten();
        let points = points.map(|point| json!({ "label": point["label"], "answers": point["answers"] }));
        Ok(Self {
            checks: checks(&summary),
            collisions: summary["collisions"].as_u64().unwrap_or(0),
            points: points.collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_sweeps::{Size, Study};

    #[test]
    fn all_studies_are_valid_in_both_forms_and_expect_something() {
        for study in Theory::ALL.iter().flat_map(|theory| theory.studies) {
            for is_quick in [false, true] {
                let read = Study::read(&study_file(study), Size { replicas: None, is_quick });
                let read = read.unwrap_or_else(|error| panic!("{study}: {error:#}"));
                let answers = (0..read.points.len()).flat_map(|point| read.answers(point, &[], &[]));
                assert!(answers.count() > 0, "{study}");
            }
        }
    }
}
