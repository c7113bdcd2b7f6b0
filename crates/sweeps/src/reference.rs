//! `carom schema --study`: JSON Schema and reference page of study files.

use anyhow::Result;
use carom_runs::{
    reference::{self, page_of, print},
    schema::{scene_schema, schema_of},
};
use carom_tables::Verdict;
use clap::Args;
use serde_json::{Value, json};

use crate::study::StudyFile;

/// Head of the page.
const HEAD: &str = "\
# Study files

Every key of a study file, which `carom sweep` runs. The page is generated from the types of the
program. To change it, change their documentation, and run
`cargo run -p carom-cli -- schema --study --page > crates/book/src/study-keys.md`.
`carom schema --study` prints the JSON Schema.

A study file is TOML. The keys of its scene are those of a scene file, see
[Keys of a scene](keys.md).

Exit codes of `carom sweep` and `carom merge`:

| code | meaning |
| --- | --- |
| 0 | all replicas are there, and all checks passed |
| 1 | a check failed, or a replica ended with an error |
| 2 | invalid input; a file cannot be read or written |
| 3 | results are written, but replicas are missing or damaged; the page names them |
| 129, 130, 143 | a signal ended the program; the same command continues |

With `--json` the object lists `missing`, `damaged` and `notes`. Partial results while shards still
run are no error: `carom merge … --force` writes what is there and ends with code 3. The merge job
that the option `--slurm` writes then counts as failed in Slurm; `bash submit.sh` continues the
shards.
";

/// Options of `carom schema`.
#[derive(Debug, Clone, Args)]
#[group(id = "study_schema")]
pub struct StudyReferenceOptions {
    /// Schema or page.
    #[command(flatten)]
    pub form: reference::ReferenceOptions,
    /// The schema or page of study files instead of that of scene files
    #[arg(long)]
    pub study: bool,
}

/// Prints the schema or the page of scene files or of study files.
///
/// # Errors
/// Those of [`reference::run`].
pub fn run(options: &StudyReferenceOptions) -> Result<Verdict> {
    if !options.study {
        return reference::run(&options.form);
    }
    let schema = study_schema();
    print(&schema, options.form.page.then(|| page_of(HEAD, &schema)));
    Ok(Verdict::Passed)
}

/// Returns the JSON Schema (draft 7) of a study file, with that of the scene inside.
///
/// # Panics
/// Never: the names that it adds to are those of the types.
pub fn study_schema() -> Value {
    let mut schema = schema_of::<StudyFile>("Study of carom");
    let Value::Object(mut scene) = scene_schema() else {
        unreachable!("a schema is an object")
    };
    let definitions = scene.remove("definitions").unwrap_or_default();
    for (name, definition) in definitions.as_object().into_iter().flatten() {
        schema["definitions"][name] = definition.clone();
    }
    for key in ["$schema", "title"] {
        scene.remove(key);
    }
    schema["definitions"]["Scene"] = Value::Object(scene);
    let keys = &mut schema["properties"];
    keys["scene"]["anyOf"] = json!([{ "type": "string" }, { "$ref": "#/definitions/Scene" }]);
    keys["measure"]["items"] = json!({
        "anyOf": [{ "type": "string" }, { "$ref": "#/definitions/MeasureSpec" }]
    });
    schema
}

#[cfg(test)]
mod tests {
    use std::{fs, path::Path};

    use super::*;

    #[test]
    fn the_page_is_current_and_every_key_has_a_meaning() {
        let schema = study_schema();
        let page = page_of(HEAD, &schema);
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../book/src/study-keys.md");
        let renew =
            "run `cargo run -p carom-cli -- schema --study --page > crates/book/src/study-keys.md`";
        assert!(
            fs::read_to_string(path).unwrap_or_default() == page,
            "{renew}"
        );
        for (key, property) in schema["properties"].as_object().unwrap() {
            assert!(property["description"].is_string(), "{key}");
        }
        for name in ["VarySpec", "Expect", "Quick"] {
            for (key, property) in schema["definitions"][name]["properties"]
                .as_object()
                .unwrap()
            {
                assert!(property["description"].is_string(), "{name}.{key}");
                // A row, or a section of its own.
                let is_there = [format!("| `{key}` |"), format!(".{key}]`")]
                    .iter()
                    .any(|text| page.contains(text));
                assert!(is_there, "{name}.{key}");
            }
        }
    }

    /// All references of the schema lead somewhere.
    #[test]
    fn the_scene_inside_is_complete() {
        fn check(root: &Value, value: &Value) {
            if let Some(target) = value["$ref"].as_str() {
                assert!(
                    root.pointer(target.trim_start_matches('#')).is_some(),
                    "{target}"
                );
            }
            value
                .as_object()
                .into_iter()
                .flatten()
                .for_each(|(_, inner)| check(root, inner));
            value
                .as_array()
                .into_iter()
                .flatten()
                .for_each(|inner| check(root, inner));
        }
        let schema = study_schema();
        check(&schema, &schema);
        assert!(schema["definitions"]["Scene"]["properties"]["gas"].is_object());
    }
}
