//! `carom detect`: the first contacts of the pairs in an encounter file, from a selected detector.

mod explain;

pub use explain::explain;

use std::{
    fmt,
    path::{Path, PathBuf},
};

use anyhow::Result;
use carom::engine::DetectorName;
use carom_detection::{
    Answer, BoundingCircles, Detection, Exact, FixedStep, GoldenSecant, Outcome, Part, Touch, skim,
};
use carom_geometry::Outline;
use carom_kinematics::RelativeMotion;
use carom_tables::Verdict;
use clap::Args;
use serde::Serialize;

use crate::{
    console::put,
    encounters::{self, EncounterRecord, EncounterRow},
    output::write_whole,
    print_line,
    progress::Progress,
};

/// Largest number of times that a search is continued after "certified free until".
const MAX_QUERIES: u32 = 1000;

/// Options of `carom detect`.
#[derive(Debug, Clone, Args)]
pub struct DetectOptions {
    /// Encounter file, one pair a line
    #[arg(value_name = "CASES.csv")]
    pub cases: PathBuf,
    /// Detector: exact, golden-secant, bounding-circles or fixed-step
    #[arg(long, default_value = "exact")]
    pub detector: DetectorName,
    /// Draw how each detector searches one pair, named by its id or by class/id, instead of
    /// searching all
    #[arg(long, value_name = "CASE", conflicts_with = "detector")]
    pub explain: Option<String>,
    /// Output file for the answers (CSV), or for the picture (SVG)
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
}

/// Runs the detector on the pairs of a file and prints how many searches ended in each way, or
/// draws the searches of one pair and prints their answers.
///
/// # Errors
/// See [`detect`] and [`explain`].
pub fn run(options: &DetectOptions) -> Result<Verdict> {
    if let Some(case) = &options.explain {
        print_line(&explain(&options.cases, case, &options.out)?);
        return Ok(Verdict::Passed);
    }
    let summary = detect(&options.cases, options.detector, &options.out)?;
    put("searches", &summary);
    print_line(&summary.to_string());
    Ok(Verdict::Passed)
}

/// Counts of the outcomes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct SearchSummary {
    /// Pairs searched.
    pub cases: u64,
    /// Pairs with a contact.
    pub contacts: u64,
    /// Pairs without a contact.
    pub free: u64,
    /// Pairs that the detector could not decide.
    pub unresolved: u64,
    /// Pairs with bodies that are not supported, which were not searched.
    pub unsupported: u64,
    /// Evaluations of the gap of an atom pair.
    pub evaluations: u64,
}

impl fmt::Display for SearchSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            cases,
            contacts,
            free,
            unresolved,
            unsupported,
            evaluations,
        } = self;
        write!(f, "{cases} encounters: {contacts} contacts, {free} free")?;
        if *unresolved > 0 {
            write!(f, ", {unresolved} unresolved")?;
        }
        if *unsupported > 0 {
            write!(f, ", {unsupported} not supported")?;
        }
        write!(f, "; {evaluations} evaluations")
    }
}

/// Searches the first contact of each encounter in the file `cases` with `detector` and writes the
/// answers to `out`.
///
/// Answers are CSV, `class,id,outcome,t,atomA,atomB,evaluations`, in the order of the cases. The
/// outcome is `contact`, `free`, `unsupported` for bodies with ellipses, or `unresolved` where the
/// search was given up; t is then the time
/// up to which it looked. The atoms are empty for a contact of bounding circles; where an atom
/// touches an edge, the edge is named in place of an atom, such as `edge2`.
///
/// # Errors
/// Invalid input, with file, line and column; an answer file that cannot be written.
pub fn detect(cases: &Path, detector: DetectorName, out: &Path) -> Result<SearchSummary> {
    let rows = encounters::rows(cases)?;
    let mut summary = SearchSummary::default();
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record([
        "class",
        "id",
        "outcome",
        "t",
        "atomA",
        "atomB",
        "evaluations",
    ])?;
    let progress = Progress::items("pairs", rows.len() as u64);
    for row in &rows {
        let encounter = match row {
            EncounterRow::Pair(encounter) => encounter,
            EncounterRow::Unsupported { class, id } => {
                summary.unsupported += 1;
                table.write_record([class, id, "unsupported", "", "", "", "0"])?;
                progress.count(1);
                continue;
            }
        };
        let finding = match detector {
            DetectorName::Exact => first_contact(&Exact::default(), encounter),
            DetectorName::GoldenSecant => first_contact(&GoldenSecant::default(), encounter),
            DetectorName::BoundingCircles => first_contact(&BoundingCircles, encounter),
            DetectorName::FixedStep => first_contact(&FixedStep::default(), encounter),
        };
        summary.add(&finding);
        let [time, atom_a, atom_b] = finding.cells();
        let evaluations = finding.evaluations.to_string();
        let (class, id) = (&encounter.class, &encounter.id);
        table.write_record([
            class,
            id,
            finding.word(),
            &time,
            &atom_a,
            &atom_b,
            &evaluations,
        ])?;
        progress.count(1);
    }
    write_whole(out, &table.into_inner()?)?;
    Ok(summary)
}

/// Result of one search; times count from the encounter's time 0.
#[derive(Debug)]
pub struct Finding {
    /// How the search ended.
    pub outcome: Outcome,
    /// Number of evaluations of the gap of an atom pair.
    pub evaluations: u64,
}

impl Finding {
    fn word(&self) -> &'static str {
        match self.outcome {
            Outcome::Contact(_) => "contact",
            Outcome::Free => "free",
            Outcome::FreeUntil(_) | Outcome::Unresolved(_) => "unresolved",
            Outcome::OutOfRange => "out-of-range",
        }
    }

    /// t, atomA, atomB
    pub(crate) fn cells(&self) -> [String; 3] {
        match self.outcome {
            Outcome::Contact(contact) => {
                let [a, b] = cells(contact.touch);
                [contact.time.to_string(), a, b]
            }
            Outcome::FreeUntil(time) | Outcome::Unresolved(time) => {
                [time.to_string(), String::new(), String::new()]
            }
            Outcome::Free | Outcome::OutOfRange => Default::default(),
        }
    }
}

/// The part of A and the part of B: the number of an atom, or `edge` and the number of an edge;
/// empty for bounding circles.
pub(crate) fn cells(touch: Touch) -> [String; 2] {
    match touch {
        Touch::Atoms(a, b) => [a.to_string(), b.to_string()],
        Touch::BoundingCircles => Default::default(),
        Touch::EdgeOfA { edge, part } => [edge_cell(edge), part_cell(part)],
        Touch::EdgeOfB { edge, part } => [part_cell(part), edge_cell(edge)],
    }
}

fn edge_cell(edge: u32) -> String {
    format!("edge{edge}")
}

fn part_cell(part: Part) -> String {
    match part {
        Part::Atom(atom) => atom.to_string(),
        Part::BoundingCircle => String::new(),
    }
}

impl SearchSummary {
    fn add(&mut self, finding: &Finding) {
        self.cases += 1;
        self.evaluations += finding.evaluations;
        match finding.outcome {
            Outcome::Contact(_) => self.contacts += 1,
            Outcome::Free => self.free += 1,
            Outcome::FreeUntil(_) | Outcome::Unresolved(_) | Outcome::OutOfRange => {
                self.unresolved += 1;
            }
        }
    }
}

/// The first contact that a detector finds.
pub fn first_contact(detector: &impl Detection, encounter: &EncounterRecord) -> Finding {
    search(encounter, |a, b, motion, _, horizon| {
        detector.first_contact(a, b, motion, horizon)
    })
}

/// Continues a search that ended "certified free until" from there, as the engine does, at most
/// [`MAX_QUERIES`] times. A query has A, B, their motion from a time on, that time, and the
/// horizon from there.
pub(crate) fn search(
    encounter: &EncounterRecord,
    mut query: impl FnMut(Outline<'_>, Outline<'_>, &RelativeMotion, f64, f64) -> Answer,
) -> Finding {
    let [a, b] = [0, 1].map(|body| encounter.molecules[body].outline());
    let window_end = encounter.window_end.unwrap_or_else(|| {
        let reach = a.bounding_radius + b.bounding_radius;
        skim(&encounter.pair_at(0.0), reach, f64::MAX).map_or(0.0, |window| window.end)
    });
    let mut time = 0.0;
    let mut evaluations = 0;
    for _ in 0..MAX_QUERIES {
        let answer = query(a, b, &encounter.pair_at(time), time, window_end - time);
        evaluations += u64::from(answer.evaluations);
        let outcome = match answer.outcome {
            Outcome::FreeUntil(later) => {
                time = (time + later).max(time.next_up());
                if time <= window_end {
                    continue;
                }
                Outcome::Free
            }
            Outcome::Contact(mut contact) => {
                contact.time += time;
                Outcome::Contact(contact)
            }
            Outcome::Unresolved(later) => Outcome::Unresolved(time + later),
            outcome @ (Outcome::Free | Outcome::OutOfRange) => outcome,
        };
        return Finding {
            outcome,
            evaluations,
        };
    }
    Finding {
        outcome: Outcome::FreeUntil(time),
        evaluations,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    const COLUMNS: &str = "class,id,xA,yA,vxA,vyA,thA,wA,atomsA,xB,yB,vxB,vyB,thB,wB,atomsB";

    /// Answers to a case file with these lines.
    fn answers(lines: &[&str], detector: DetectorName) -> Result<String> {
        let folder = tempfile::tempdir()?;
        let (cases, out) = (
            folder.path().join("cases.csv"),
            folder.path().join("answers.csv"),
        );
        fs::write(&cases, lines.join("\n"))?;
        detect(&cases, detector, &out)?;
        assert_eq!(
            fs::read_dir(folder.path())?.count(),
            2,
            "nothing else is left behind"
        );
        Ok(fs::read_to_string(out)?)
    }

    #[test]
    fn cases_without_answers_are_answered() {
        // Discs of radius 1/2, 3 apart: one pair approaches head-on at speed 1, the other
        // separates.
        let meets = "discs,meet,0,0,0,0,0,0,0:0:1:0.5,3,0,-1,0,0,0,7:7:1:0.5";
        let parts = "discs,part,0,0,0,0,0,0,0:0:1:0.5,3,0,1,0,0,0,7:7:1:0.5";
        let found = answers(&[COLUMNS, meets, parts], DetectorName::Exact).unwrap();
        assert_eq!(
            found,
            "class,id,outcome,t,atomA,atomB,evaluations\ndiscs,meet,contact,2,0,0,1\ndiscs,part,free,,,,0\n"
        );
        let circles = answers(&[COLUMNS, meets], DetectorName::BoundingCircles).unwrap();
        assert!(circles.contains("discs,meet,contact,2,,,1"));
    }

    #[test]
    fn a_window_ends_the_search() {
        let columns = format!("{COLUMNS},window_end");
        let line = "discs,1,0,0,0,0,0,0,0:0:1:0.5,3,0,-1,0,0,0,0:0:1:0.5";
        for (window_end, word) in [("2", "contact"), ("1.9", "free"), ("", "contact")] {
            let found = answers(
                &[&columns, &format!("{line},{window_end}")],
                DetectorName::Exact,
            )
            .unwrap();
            assert!(found.contains(word), "{window_end}: {found}");
        }
    }

    #[test]
    fn bad_input_is_refused_by_line_and_column() {
        let good = "c,1,0,0,0,0,0,0,0:0:1:0.5,3,0,-1,0,0,0,0:0:1:0.5";
        for (bad, column) in [
            ("c,2,0,0,x,0,0,0,0:0:1:0.5,3,0,-1,0,0,0,0:0:1:0.5", "vxA"),
            ("c,2,0,0,0,0,0,NaN,0:0:1:0.5,3,0,-1,0,0,0,0:0:1:0.5", "wA"),
            ("c,2,0,0,0,0,0,0,0:0:1:0.5,inf,0,-1,0,0,0,0:0:1:0.5", "xB"),
            (
                "c,2,0,0,0,0,0,0,0:0:1:-0.5,3,0,-1,0,0,0,0:0:1:0.5",
                "atomsA",
            ),
            ("c,2,0,0,0,0,0,0,0:0:1:0.5,3,0,-1,0,0,0,0:0:1", "atomsB"),
            (
                "c,2,0,0,0,0,0,0,0:0:1:0.5;0:0:1:0.5,3,0,-1,0,0,0,0:0:1:0.5",
                "atomsA",
            ),
            ("c,2,,0,0,0,0,0,0:0:1:0.5,3,0,-1,0,0,0,0:0:1:0.5", "xA"),
        ] {
            let error = format!(
                "{:#}",
                answers(&[COLUMNS, good, bad], DetectorName::Exact).unwrap_err()
            );
            assert!(
                error.contains("line 3") && error.contains(&format!("`{column}`")),
                "{error}"
            );
        }
        assert!(answers(&[COLUMNS, "c,2,0"], DetectorName::Exact).is_err());
        let error = format!(
            "{:#}",
            answers(&["class,id", "c,1"], DetectorName::Exact).unwrap_err()
        );
        assert!(error.contains("the column `xA` is missing"), "{error}");
    }

    #[test]
    fn detectors_are_parsed_by_name() {
        assert_eq!(
            "golden-secant".parse::<DetectorName>().unwrap(),
            DetectorName::GoldenSecant
        );
        let error = "fixed-stop"
            .parse::<DetectorName>()
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("golden-secant") && error.ends_with("did you mean `fixed-step`?"),
            "{error}"
        );
    }
}
