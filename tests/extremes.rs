//! The extreme scenes of `cargo xtask experiment extremes`, in short runs: numerical extremes, and
//! cases with analytic solutions.

use carom_testkit::extremes::{Effort, Engine, ExtremeCase, cases};

/// Long enough for all lists, cells and epochs to be used many times.
const EFFORT: Effort = Effort { collisions: 4000 };

fn check(case: &ExtremeCase) -> Vec<String> {
    match (case.run)(Engine::Default, EFFORT) {
        Err(error) => vec![format!("{} {}: {error:#}", case.id, case.name)],
        Ok(findings) => findings
            .iter()
            .filter(|finding| !finding.holds())
            .map(|finding| {
                let (id, what, found, allowed) =
                    (case.id, &finding.what, finding.found, finding.allowed);
                format!(
                    "{id} {}: {what} is {found:e}, allowed is {allowed:e}",
                    case.name
                )
            })
            .collect(),
    }
}

#[test]
fn all_scenes_hold() {
    let failures: Vec<String> = cases().iter().flat_map(check).collect();
    assert!(failures.is_empty(), "{failures:#?}");
}
