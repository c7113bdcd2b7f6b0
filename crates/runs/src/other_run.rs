//! In what two descriptions of runs differ: the entries of their scenes by name, else a line.

use anyhow::{Result, bail};
use toml::{Table, Value};

/// Most entries that a message names.
const MAX_NAMED: usize = 6;

/// Returns an error that names the entries, or else the first line, in which two run descriptions
/// differ. A description is TOML, or a line, such as a command, that may have TOML below it.
///
/// # Errors
/// The descriptions differ.
pub fn refuse_other(there: &str, here: &str) -> Result<()> {
    if there == here {
        return Ok(());
    }
    if let Some(words) = differing_entries(there, here) {
        bail!("it belongs to another run: {words}");
    }
    let mut pairs = there.lines().zip(here.lines());
    match pairs.find(|(there, here)| there != here) {
        Some((there, here)) => {
            bail!("it belongs to another run: its line `{there}` differs from `{here}`")
        }
        None => bail!("it belongs to another run: one description has more lines than the other"),
    }
}

/// Returns an error like [`refuse_other`], but not for descriptions that differ in `run.units`
/// alone: the units of the page and the terminal change no result, so that a run can be resumed
/// with others.
///
/// # Errors
/// The descriptions differ in more than that.
pub fn refuse_other_run(there: &str, here: &str) -> Result<()> {
    let differs = refuse_other(there, here);
    let is_same = || without_units(there).is_some_and(|there| Some(there) == without_units(here));
    if differs.is_err() && is_same() {
        return Ok(());
    }
    differs
}

/// The lines before the scene of a description, and the scene without `run.units`; `None` if it has
/// no scene.
fn without_units(what: &str) -> Option<(Vec<&str>, String)> {
    let (command, text) = what.split_once('\n')?;
    let mut scene: Table = text.parse().ok()?;
    if let Some(Value::Table(run)) = scene.get_mut("run") {
        run.remove("units");
    }
    let comments = text.lines().take_while(|line| line.starts_with('#'));
    let before = std::iter::once(command).chain(comments).collect();
    // As text: 0.0 and -0.0 are different entries.
    Some((before, toml::to_string(&scene).ok()?))
}

/// The entries that differ; `None` if the scenes are equal, or one is not TOML.
fn differing_entries(there: &str, here: &str) -> Option<String> {
    let scene = |text: &str| {
        let below = || {
            text.split_once('\n')
                .and_then(|(_, scene)| scene.parse::<Table>().ok())
        };
        text.parse::<Table>().ok().or_else(below)
    };
    let mut found = Vec::new();
    compare(
        "",
        &Value::Table(scene(there)?),
        &Value::Table(scene(here)?),
        &mut found,
    );
    let more = found.len().saturating_sub(MAX_NAMED);
    found.truncate(MAX_NAMED);
    if more > 0 {
        found.push(format!("and {more} more entries"));
    }
    (!found.is_empty()).then(|| found.join("; "))
}

/// Adds the differences of two values below `path`.
fn compare(path: &str, there: &Value, here: &Value, found: &mut Vec<String>) {
    match (there, here) {
        (Value::Table(there), Value::Table(here)) => {
            let new = here.keys().filter(|key| !there.contains_key(*key));
            for key in there.keys().chain(new) {
                let dot = if path.is_empty() { "" } else { "." };
                let path = format!("{path}{dot}{key}");
                match (there.get(key), here.get(key)) {
                    (Some(there), Some(here)) => compare(&path, there, here, found),
                    (Some(there), None) => {
                        found.push(format!(
                            "it has {path} = {}, and this run has none",
                            short(there)
                        ));
                    }
                    (None, Some(here)) => {
                        found.push(format!(
                            "it has no {path}, and this run has {}",
                            short(here)
                        ));
                    }
                    (None, None) => {}
                }
            }
        }
        (Value::Array(all), Value::Array(others))
            if all.len() == others.len() && all.iter().all(Value::is_table) =>
        {
            for (index, (there, here)) in all.iter().zip(others).enumerate() {
                compare(&format!("{path}[{index}]"), there, here, found);
            }
        }
        _ if there == here => {}
        _ => found.push(format!(
            "its {path} = {} differs from {}",
            short(there),
            short(here)
        )),
    }
}

/// A value in a line; of a table or a list of tables, its size.
fn short(value: &Value) -> String {
    match value {
        Value::Table(_) => "an entry".to_owned(),
        Value::Array(all) if matches!(all.as_slice(), [Value::Table(_)]) => "1 entry".to_owned(),
        Value::Array(all) if all.iter().any(Value::is_table) => format!("{} entries", all.len()),
        _ => value.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(there: &str, here: &str) -> String {
        refuse_other(there, here).unwrap_err().to_string()
    }

    #[test]
    fn entries_that_differ_are_named() {
        let scene = |radius: f64, side: f64| {
            format!(
                "carom run\n[box]\nsides = [\n    {side:?},\n    1.0,\n]\n[[gas]]\nradius = {radius:?}\n"
            )
        };
        assert!(refuse_other(&scene(0.1, 1.0), &scene(0.1, 1.0)).is_ok());
        assert_eq!(
            refused(&scene(0.1, 1.0), &scene(0.2, 2.0)),
            "it belongs to another run: its box.sides = [1.0, 1.0] differs from [2.0, 1.0]; its gas[0].radius = 0.1 \
             differs from 0.2"
        );
        // The scene first: the command follows from it.
        let other = scene(0.2, 1.0).replace("carom run", "carom run --from 3");
        assert!(
            refused(&scene(0.1, 1.0), &other)
                .ends_with("run: its gas[0].radius = 0.1 differs from 0.2")
        );
        let command = scene(0.1, 1.0).replace("carom run", "carom run --from 3");
        assert!(
            refused(&scene(0.1, 1.0), &command)
                .ends_with("`carom run` differs from `carom run --from 3`")
        );
        let two = format!("{}[[gas]]\nradius = 0.3\n", scene(0.1, 1.0));
        assert!(
            refused(&scene(0.1, 1.0), &two).ends_with("its gas = 1 entry differs from 2 entries")
        );
        let walled = format!("{}[[wall]]\nx = 0.0\n", scene(0.1, 1.0));
        assert!(
            refused(&scene(0.1, 1.0), &walled)
                .ends_with("it has no wall, and this run has 1 entry")
        );
        assert!(refused("a run", "another").ends_with("its line `a run` differs from `another`"));
        assert!(refused("a run", "a run\nlonger").contains("more lines"));
    }

    #[test]
    fn units_of_the_page_are_no_part_of_a_run() {
        let run = |comment: &str, radius: &str, units: &str| {
            format!("run\n{comment}[[gas]]\nradius = {radius}\n[run]\nuntil = 0.0\n{units}")
        };
        let reduced = run("", "0.1", "units = \"reduced\"\n");
        let given = run(
            "",
            "0.1",
            "[run.units]\nlength = 1.0\nmass = 1.0\nenergy = 2.0\n",
        );
        let plain = run("", "0.1", "");
        for (there, here) in [(&plain, &reduced), (&reduced, &plain), (&reduced, &given)] {
            assert!(refuse_other_run(there, here).is_ok());
            assert!(refuse_other(there, here).is_err(), "merged runs have one");
        }
        for other in [
            run("", "0.2", "units = \"reduced\"\n"),
            run("", "-0.1", ""),
            run("# from a\n", "0.1", ""),
            plain.replacen("run", "sweep", 1),
        ] {
            assert!(refuse_other_run(&plain, &other).is_err(), "{other}");
        }
        let [zero, minus] = ["0.0", "-0.0"].map(|x| run("", x, ""));
        assert!(refuse_other_run(&zero, &minus).is_err());
        // Both differences are named if there is another one.
        let words = refuse_other_run(&plain, &run("", "0.2", "units = \"reduced\"\n"));
        let words = words.unwrap_err().to_string();
        assert!(words.contains("gas[0].radius"), "{words}");
    }
}
