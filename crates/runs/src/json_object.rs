//! The JSON object that a program writes instead of text if it is called with `--json`: what the
//! command was, and how it ended.

use std::sync::{Mutex, MutexGuard, PoisonError};

use carom_tables::Verdict;
use serde::Serialize;
use serde_json::{Map, Value, json};

/// The parts of the object so far; `None` if text is written.
static OBJECT: Mutex<Option<Map<String, Value>>> = Mutex::new(None);

/// Begins the object of a command.
pub(crate) fn start(command: &str) {
    *object() = Some(Map::from_iter([("command".to_owned(), command.into())]));
}

/// Whether the program writes a JSON object instead of text.
pub fn is_json() -> bool {
    object().is_some()
}

/// Adds a value to the object, under a key of the command's own. Does nothing where text is
/// written, or if the value cannot be written as JSON.
pub fn put(key: &str, value: &impl Serialize) {
    if let Some(all) = object().as_mut()
        && let Ok(value) = serde_json::to_value(value)
    {
        all.insert(key.to_owned(), value);
    }
}

/// Adds a line to the array `text`; returns `false` where no object is written.
pub(crate) fn takes_line(text: &str) -> bool {
    let mut object = object();
    let Some(all) = object.as_mut() else {
        return false;
    };
    if let Value::Array(lines) = all.entry("text").or_insert_with(|| json!([])) {
        lines.push(text.into());
    }
    true
}

/// Completes the object with the verdict, or with the words of an error. Returns its text; `None`
/// where no object is written.
pub(crate) fn end(end: Result<Verdict, String>, exit_code: u8) -> Option<String> {
    let mut all = object().take()?;
    match end {
        Ok(verdict) => {
            let word = verdict.word();
            all.insert("verdict".to_owned(), word.into());
            for (key, default) in [
                ("folder", Value::Null),
                ("totals", Value::Null),
                ("checks", json!([])),
            ] {
                all.entry(key).or_insert(default);
            }
        }
        Err(words) => {
            all.insert(
                "error".to_owned(),
                words.strip_prefix("error: ").unwrap_or(&words).into(),
            );
        }
    }
    all.insert("exit_code".to_owned(), exit_code.into());
    Some(Value::Object(all).to_string())
}

fn object() -> MutexGuard<'static, Option<Map<String, Value>>> {
    OBJECT.lock().unwrap_or_else(PoisonError::into_inner)
}
