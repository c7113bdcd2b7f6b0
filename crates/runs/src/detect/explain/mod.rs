//! `carom detect --explain`: a picture of how each detector searches the first contact of one pair.

mod curves;
mod picture;

use std::path::Path;

use anyhow::{Result, bail};
use carom::engine::DetectorName;
use carom_detection::{
    BoundingCircles, Exact, FixedStep, GoldenSecant, Outcome, SearchStep, SearchWindow, Touch,
    Trace,
};

use super::{Finding, search};
use crate::{
    encounters::{self, EncounterRecord},
    output::write_whole,
};

/// Most cases that an error message lists.
const MAX_LISTED: usize = 8;

/// The search of one detector; times count from the encounter's time 0.
struct Course {
    detector: DetectorName,
    finding: Finding,
    /// The time in which the bodies are within reach.
    window: Option<SearchWindow>,
    segments: Vec<SearchWindow>,
    steps: Vec<SearchStep>,
}

/// Draws the searches of all detectors for the case `case` of the encounter file `cases` and writes
/// the picture to `out` (SVG).
///
/// `case` is an `id`, or `class/id`.
///
/// Returns the answers as text, a line a detector.
///
/// # Errors
/// Invalid input, with file, line and column; no case or several cases of this name; a file that
/// cannot be written.
pub fn explain(cases: &Path, case: &str, out: &Path) -> Result<String> {
    let encounters = encounters::read(cases)?;
    let encounter = find(&encounters, case)?;
    let courses = courses(encounter);
    write_whole(out, picture::svg(encounter, &courses).as_bytes())?;
    Ok(courses
        .iter()
        .map(Course::sentence)
        .collect::<Vec<_>>()
        .join("\n"))
}

fn find<'a>(encounters: &'a [EncounterRecord], case: &str) -> Result<&'a EncounterRecord> {
    let name = |encounter: &EncounterRecord| format!("{}/{}", encounter.class, encounter.id);
    let matches = |encounter: &&EncounterRecord| encounter.id == case || name(encounter) == case;
    let found: Vec<&EncounterRecord> = encounters.iter().filter(matches).collect();
    let listed = |some: &[&EncounterRecord]| {
        let names: Vec<String> = some
            .iter()
            .take(MAX_LISTED)
            .map(|encounter| name(encounter))
            .collect();
        let more = if some.len() > MAX_LISTED { ", …" } else { "" };
        format!("{}{more}", names.join(", "))
    };
    match found[..] {
        [only] => Ok(only),
        [] => {
            let all: Vec<&EncounterRecord> = encounters.iter().collect();
            bail!(
                "no case '{case}' in the file: expected an id or class/id, such as {}",
                listed(&all)
            )
        }
        _ => bail!(
            "{} cases are named '{case}': expected one of {}",
            found.len(),
            listed(&found)
        ),
    }
}

/// The searches of all detectors, beginning with the exact one.
fn courses(encounter: &EncounterRecord) -> Vec<Course> {
    let (exact, golden, fixed) = (
        Exact::default(),
        GoldenSecant::default(),
        FixedStep::default(),
    );
    let names = [
        DetectorName::Exact,
        DetectorName::GoldenSecant,
        DetectorName::FixedStep,
        DetectorName::BoundingCircles,
    ];
    let course = |detector: DetectorName| {
        let mut pieces: Vec<(f64, Trace)> = Vec::new();
        let finding = search(encounter, |a, b, motion, time, horizon| {
            let trace = match detector {
                DetectorName::Exact => exact.trace(a, b, motion, horizon),
                DetectorName::GoldenSecant => golden.trace(a, b, motion, horizon),
                DetectorName::FixedStep => fixed.trace(a, b, motion, horizon),
                DetectorName::BoundingCircles => BoundingCircles.trace(a, b, motion, horizon),
            };
            let answer = trace.answer;
            pieces.push((time, trace));
            answer
        });
        Course::new(detector, finding, pieces)
    };
    names.into_iter().map(course).collect()
}

impl Course {
    /// Joins the traces of a search that was continued at these times.
    fn new(detector: DetectorName, finding: Finding, pieces: Vec<(f64, Trace)>) -> Self {
        let mut course = Self {
            detector,
            finding,
            window: None,
            segments: Vec::new(),
            steps: Vec::new(),
        };
        for (start, trace) in pieces {
            let later = |window: SearchWindow| SearchWindow {
                begin: window.begin + start,
                end: window.end + start,
            };
            course.window = course.window.or(trace.window.map(later));
            course
                .segments
                .extend(trace.segments.into_iter().map(later));
            course
                .steps
                .extend(trace.steps.into_iter().map(|step| SearchStep {
                    time: step.time + start,
                    free_until: step.free_until.map(|time| time + start),
                    ..step
                }));
        }
        course
    }

    fn contact(&self) -> Option<carom_detection::Contact> {
        self.finding.outcome.contact()
    }

    /// Name of the detector in scenes and on the command line.
    fn name(&self) -> &'static str {
        match self.detector {
            DetectorName::Exact => "exact",
            DetectorName::GoldenSecant => "golden-secant",
            DetectorName::FixedStep => "fixed-step",
            DetectorName::BoundingCircles => "bounding-circles",
        }
    }

    /// The answer in words.
    fn sentence(&self) -> String {
        let [time, a, b] = self.finding.cells();
        let answer = match self.finding.outcome {
            Outcome::Contact(_) if a.is_empty() => {
                format!("contact of the bounding circles at t = {time}")
            }
            Outcome::Contact(contact) => match contact.touch {
                Touch::EdgeOfA { .. } => {
                    format!("contact at t = {time}, {a} of A and atom {b} of B")
                }
                _ => format!("contact at t = {time}, atom {a} of A and {b} of B"),
            },
            Outcome::Free => "no contact".to_owned(),
            Outcome::FreeUntil(_) => {
                format!("certified free up to t = {time}, not searched further")
            }
            Outcome::Unresolved(_) => format!("not resolved after t = {time}"),
            Outcome::OutOfRange => "numbers out of range".to_owned(),
        };
        let plural = if self.finding.evaluations == 1 {
            ""
        } else {
            "s"
        };
        format!(
            "{}: {answer}, {} evaluation{plural}",
            self.name(),
            self.finding.evaluations
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detect::first_contact;
    use std::{fs, path::PathBuf};

    fn cases() -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/encounters.csv")
    }

    #[test]
    fn the_course_of_a_search_ends_with_the_answer_of_the_detector() {
        let encounters = encounters::read(&cases()).unwrap();
        let mut contacts = 0;
        for encounter in encounters.iter().step_by(4) {
            let courses = courses(encounter);
            let answers = [
                first_contact(&Exact::default(), encounter),
                first_contact(&GoldenSecant::default(), encounter),
                first_contact(&FixedStep::default(), encounter),
                first_contact(&BoundingCircles, encounter),
            ];
            for (course, answer) in courses.iter().zip(answers) {
                assert_eq!(
                    format!("{:?}", course.finding),
                    format!("{answer:?}"),
                    "{}",
                    encounter.id
                );
            }
            let Some(contact) = courses[0].contact() else {
                continue;
            };
            let parts = carom_detection::Parts::Pair(contact.touch);
            let last = courses[0]
                .steps
                .iter()
                .rfind(|step| step.parts == parts)
                .unwrap();
            assert_eq!(last.free_until, Some(contact.time));
            contacts += 1;
        }
        assert!(contacts > 40, "{contacts}");
    }

    #[test]
    fn every_case_can_be_drawn() {
        let encounters = encounters::read(&cases()).unwrap();
        // Every class, and cases with and without a contact.
        for encounter in encounters.iter().step_by(23) {
            let svg = picture::svg(encounter, &courses(encounter));
            assert!(
                svg.starts_with("<svg") && svg.ends_with("</svg>\n"),
                "{}",
                encounter.id
            );
            assert!(
                !svg.contains("NaN") && !svg.contains("inf"),
                "{}",
                encounter.id
            );
            assert!(svg.len() < 400_000, "{}: {} bytes", encounter.id, svg.len());
        }
    }

    /// A disc that falls on the middle of the upper side of a square.
    const EDGED: &str = "class,id,xA,yA,vxA,vyA,thA,wA,atomsA,edgesA,xB,yB,vxB,vyB,thB,wB,atomsB,edgesB,t_first,window_end\n\
        square_disc,0,0,0,0,0,0,0,-1:-1:1:1e-6;1:-1:1:1e-6;1:1:1:1e-6;-1:1:1:1e-6,0:1:1e-6;1:2:1e-6;2:3:1e-6;3:0:1e-6,\
        0.3,3,0,-1,0,0,0:0:1:0.5,,1.499999,5\n";

    #[test]
    fn a_contact_with_an_edge_is_drawn_and_named() {
        let folder = tempfile::tempdir().unwrap();
        let [cases, out] = ["cases.csv", "out.svg"].map(|name| folder.path().join(name));
        fs::write(&cases, EDGED).unwrap();
        let text = explain(&cases, "square_disc/0", &out).unwrap();
        assert!(
            text.contains("exact: contact at t = 1.49999")
                && text.contains("edge2 of A and atom 0 of B"),
            "{text}"
        );
        let svg = fs::read_to_string(&out).unwrap();
        assert!(
            svg.contains("exact, edge2 and 0") && svg.contains("least gap of the atoms and edges")
        );
        // Three poses with the square as an area and its line, around a hollow interior.
        assert_eq!(svg.matches("blue area").count(), 3);
        assert!(!svg.contains("NaN"));
    }

    #[test]
    fn a_name_must_belong_to_one_case() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("picture.svg");
        let error = explain(&cases(), "0", &out).unwrap_err().to_string();
        assert!(
            error.contains("10 cases are named '0'") && error.contains("disc_t1/0"),
            "{error}"
        );
        let error = explain(&cases(), "disc/0", &out).unwrap_err().to_string();
        assert!(
            error.contains("no case 'disc/0'") && error.contains("disc_t1/0"),
            "{error}"
        );
        assert!(!out.exists());
        let text = explain(&cases(), "disc_t1/0", &out).unwrap();
        assert!(
            text.starts_with("exact: contact at t = 0.0928570959091") && text.lines().count() == 4
        );
        assert!(fs::read_to_string(&out).unwrap().contains("golden-secant"));
    }
}
