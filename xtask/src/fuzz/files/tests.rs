//! Tests of the file fuzzer: it finds planted faults, and its cases include refused files and
//! successful runs.

use super::*;
use crate::fuzz::{
    random::case_seed,
    subject::check_and_catch,
    worker::{InProcess, Runner as _},
};

/// Readers that panic on files with a certain line.
#[derive(Clone)]
struct Panics;

impl Subject for Panics {
    type Case = FileCase;
    const NAME: &'static str = "files";
    const TIME_LIMIT: u64 = 1;

    fn draw(&self, seed: u64) -> FileCase {
        Mutations.draw(seed)
    }

    fn check(&self, case: &FileCase) -> Report {
        let planted = b"count = -1";
        let found = case
            .bytes
            .windows(planted.len())
            .any(|window| window == planted);
        assert!(!found, "planted");
        Report::default()
    }

    fn simpler(&self, case: &FileCase) -> Vec<FileCase> {
        Mutations.simpler(case)
    }

    fn write(&self, case: &FileCase) -> (String, Vec<u8>) {
        Mutations.write(case)
    }

    fn read(&self, ending: &str, bytes: &[u8]) -> Result<FileCase> {
        Mutations.read(ending, bytes)
    }
}

#[test]
fn a_panic_on_a_file_is_found_and_the_file_minimised() {
    let mut runner = InProcess(Panics);
    let seed = (0..20_000)
        .map(|index| case_seed(1, index))
        .find(|&seed| runner.run_seed(seed).unwrap().failure.is_some())
        .expect("a mutation contains the line");
    let failure = runner.run_seed(seed).unwrap().failure.unwrap();
    assert_eq!(failure.kind, "panic");
    let time = std::time::Duration::from_secs(20);
    let (case, _) =
        crate::fuzz::minimise::minimise(&Panics, &mut runner, Panics.draw(seed), failure, time);
    assert!(
        case.bytes.len() <= 12,
        "{}",
        String::from_utf8_lossy(&case.bytes)
    );
}

#[test]
fn an_overlap_in_a_file_is_found() {
    // A checkpoint of two overlapping discs, which no scene may contain.
    let scene = carom::engine::Scene::from_toml(
        "[[molecule]]\nshape = \"disc\"\natom_radius = 0.1\natom_mass = 1.0\nat = [0.25, 0.5]\n\
         [[molecule]]\nshape = \"disc\"\natom_radius = 0.1\natom_mass = 1.0\nat = [0.75, 0.5]\n",
    )
    .unwrap();
    let simulation = carom::engine::Simulation::new(&scene).unwrap();
    let body = carom_runs::checkpoint_file::encode(&simulation.checkpoint().unwrap()).unwrap();
    let report = |bytes: &[u8]| {
        let case = FileCase {
            kind: FileKind::Body,
            bytes: bytes.to_vec(),
        };
        check_and_catch(|| Mutations.check(&case))
    };
    assert_eq!(report(&body).failure, None);
    assert!(
        report(&body)
            .counts
            .contains(&("checkpoints resumed".to_owned(), 1))
    );
    let place = 0.75f64.to_le_bytes();
    let at = body.windows(8).position(|window| window == place).unwrap();
    let mut overlapping = body.clone();
    overlapping[at..at + 8].copy_from_slice(&0.3f64.to_le_bytes());
    let found = report(&overlapping);
    // Refused or counted by name.
    let is_counted = |name: &str| found.counts.contains(&(name.to_owned(), 1));
    assert!(is_counted("checkpoints refused") || is_counted("checkpoints of overlapping bodies"));
}

#[test]
fn cases_of_all_kinds_are_refused_and_run() {
    let mut total = Report::default();
    for index in 0..150 {
        let case = Mutations.draw(case_seed(5, index));
        let (ending, bytes) = Mutations.write(&case);
        assert_eq!(Mutations.read(&ending, &bytes).unwrap(), case);
        // Scenes run in the separate process only, which can be killed.
        if case.kind != FileKind::Scene {
            total.add(&check_and_catch(|| Mutations.check(&case)));
        }
    }
    for name in [
        "encounter files refused",
        "encounter files answered",
        "checkpoints refused",
    ] {
        assert!(
            total
                .counts
                .iter()
                .any(|(known, count)| known == name && *count > 0),
            "{name}: {total:?}"
        );
    }
}
