//! `impulses:TAG`: the log of all impulses on one body, written while the run goes on.

use anyhow::{Context, Result, ensure};
use carom::{View, engine::RunSpec, observers::ImpulseLog};

use crate::measures::{Of, Selection, check_tag};

/// Its name in `run.observe`.
pub const NAME: &str = "impulses";

/// Largest number of rows in the table of impulses (0.2 kB each).
const MOST_ROWS: u64 = 1_000_000;

/// The log that a run asks for.
///
/// # Errors
/// No body carries the tag, several do, or two logs are requested.
pub fn log(run: &RunSpec, view: &View<'_>) -> Result<Option<ImpulseLog>> {
    let mut log = None;
    for name in run.observe.iter().filter(|name| is_log(name)) {
        let tag = name.split_once(':').map(|(_, tag)| tag);
        let body = Selection::new(name, tag, run, view)?.only_body()?;
        ensure!(log.is_none(), "run.observe: '{name}': impulses can be logged for one body only");
        log = Some(ImpulseLog::new(body.body.key(), MOST_ROWS));
    }
    Ok(log)
}

/// Whether a name asks for a log.
pub fn is_log(name: &str) -> bool {
    name.split(':').next() == Some(NAME)
}

/// Validates a name that asks for a log.
///
/// # Errors
/// It has no valid tag.
pub fn check(name: &str) -> Result<()> {
    check_tag(name, Of::OneBody, name.split_once(':').map(|(_, tag)| tag)).context("run.observe")
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::Scene;
    use carom_methods::AnySimulation;

    #[test]
    fn a_log_needs_the_tag_of_one_body() {
        assert!(check("impulses:tee").is_ok());
        for (bad, said) in [("impulses", "impulses:TAG"), ("impulses:", "letters")] {
            let error = format!("{:#}", check(bad).unwrap_err());
            assert!(error.contains(said), "{error}");
        }
        let gas = "[[gas]]\ntags = [\"gas\"]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100";
        let simulation = AnySimulation::new(&Scene::from_toml(gas).unwrap()).unwrap();
        let run = RunSpec { observe: vec!["impulses:gas".to_owned()], ..RunSpec::default() };
        let error = format!("{:#}", log(&run, &simulation.view()).expect_err("an error"));
        assert!(error.contains("several bodies"), "{error}");
    }
}
