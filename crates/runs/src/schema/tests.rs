//! Tests of the schema: scenes of the repository conform to it, and numbers out of its ranges are
//! refused.

use std::{
    fs,
    path::{Path, PathBuf},
};

use carom_methods::AnySimulation;
use regex::Regex;

use super::*;

/// Violations of a schema by a value; only the keywords that occur in it are checked.
#[expect(clippy::too_many_lines, reason = "one rule for each keyword")]
fn faults(root: &Value, schema: &Value, value: &Value, path: &str) -> Vec<String> {
    let mut faults = Vec::new();
    if let Some(target) = schema["$ref"].as_str() {
        let target = root
            .pointer(target.trim_start_matches('#'))
            .expect("a definition");
        faults.extend(self::faults(root, target, value, path));
    }
    for part in schema["allOf"].as_array().into_iter().flatten() {
        faults.extend(self::faults(root, part, value, path));
    }
    for choices in ["anyOf", "oneOf"]
        .iter()
        .filter_map(|key| schema[key].as_array())
    {
        if choices
            .iter()
            .all(|choice| !self::faults(root, choice, value, path).is_empty())
        {
            faults.push(format!("{path}: {value} is none of the choices"));
        }
    }
    let mut require = |holds: bool, what: &str| {
        if !holds {
            faults.push(format!("{path}: {value} violates {what}"));
        }
    };
    match schema["type"].as_str() {
        Some("number") => require(value.is_number(), "number"),
        Some("integer") => require(value.is_u64(), "integer"),
        Some("string") => require(value.is_string(), "string"),
        Some("boolean") => require(value.is_boolean(), "boolean"),
        Some("array") => require(value.is_array(), "array"),
        Some("object") => require(value.is_object(), "object"),
        _ => {}
    }
    if let Some(number) = value.as_f64() {
        require(
            schema["minimum"]
                .as_f64()
                .is_none_or(|least| number >= least),
            "minimum",
        );
        require(
            schema["maximum"].as_f64().is_none_or(|most| number <= most),
            "maximum",
        );
        require(
            schema["exclusiveMinimum"]
                .as_f64()
                .is_none_or(|least| number > least),
            "exclusiveMinimum",
        );
        require(
            schema["exclusiveMaximum"]
                .as_f64()
                .is_none_or(|most| number < most),
            "exclusiveMaximum",
        );
    }
    require(
        schema["enum"]
            .as_array()
            .is_none_or(|names| names.contains(value)),
        "enum",
    );
    require(
        schema.get("const").is_none_or(|name| name == value),
        "const",
    );
    if let (Some(pattern), Some(text)) = (schema["pattern"].as_str(), value.as_str()) {
        let pattern = Regex::new(pattern).expect("a regular expression");
        require(pattern.is_match(text), "pattern");
    }
    let list = value.as_array().map_or(&[][..], Vec::as_slice);
    let count = list.len() as u64;
    require(
        schema["minItems"]
            .as_u64()
            .is_none_or(|least| count >= least),
        "minItems",
    );
    require(
        schema["maxItems"].as_u64().is_none_or(|most| count <= most),
        "maxItems",
    );
    for (index, item) in list.iter().enumerate() {
        faults.extend(self::faults(
            root,
            &schema["items"],
            item,
            &format!("{path}[{index}]"),
        ));
    }
    for key in schema["required"]
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(Value::as_str)
    {
        if value.get(key).is_none() {
            faults.push(format!("{path}: {key} is missing"));
        }
    }
    for (key, inner) in value.as_object().into_iter().flatten() {
        let path = format!("{path}.{key}");
        match schema["properties"].get(key) {
            Some(property) => faults.extend(self::faults(root, property, inner, &path)),
            None if schema["additionalProperties"] == false => {
                faults.push(format!("{path}: unknown key"));
            }
            None => {}
        }
    }
    faults
}

fn of_scene(text: &str) -> Vec<String> {
    let schema = scene_schema();
    let table: toml::Table = text.parse().unwrap();
    faults(&schema, &schema, &serde_json::to_value(table).unwrap(), "")
}

/// All scene files, and the scenes in the README and in the book.
fn scenes() -> Vec<(PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let files = |folder: &str, ending: &str| -> Vec<PathBuf> {
        let entries = fs::read_dir(root.join(folder)).unwrap();
        let paths = entries.map(|entry| entry.unwrap().path());
        paths
            .filter(|path| path.extension().is_some_and(|found| found == ending))
            .collect()
    };
    let mut scenes = Vec::new();
    for path in files("crates/runs/examples", "toml") {
        let text = fs::read_to_string(&path).unwrap();
        scenes.push((path, text));
    }
    let mut pages = files("crates/book/src", "md");
    pages.push(root.join("README.md"));
    for path in pages {
        let page = fs::read_to_string(&path).unwrap();
        for rest in page.split("```toml\n").skip(1) {
            let block = rest.split("```").next().unwrap_or_default();
            // Studies are tested where they are read.
            if !block.contains("[[vary]]") {
                scenes.push((path.clone(), block.to_owned()));
            }
        }
    }
    scenes
}

#[test]
fn all_scenes_of_the_repository_conform() {
    assert!(scenes().len() > 18);
    for (path, text) in scenes() {
        assert_eq!(of_scene(&text), Vec::<String>::new(), "{}", path.display());
    }
}

#[test]
fn wrong_scenes_do_not_conform() {
    for (text, words) in [
        ("[box]\nsize = [1.0, 1.0]", "size"),
        ("[box]\nsides = [1.0]", "minItems"),
        ("[box]\nsides = [1.0, -1.0]", "minimum"),
        ("[[molecule]]\nshape = \"disc\"", "at is missing"),
        ("[[molecule]]\nat = [0, 0]\nshape = \"tea\"", "choices"),
        ("[[molecule]]\nat = [0, 0]\nshape = \"rod\"", "choices"),
        ("[[molecule]]\nat = [0, 0]\nrotation = \"none\"", "rotation"),
        ("[[gas]]\narea_fraction = 1.0", "exclusiveMaximum"),
        ("[run]\nobserve = [\"drift\"]", "observe[0]"),
        ("[run]\nsnapshots = \"gsd\"", "enum"),
    ] {
        let faults = of_scene(text);
        assert!(
            faults.iter().any(|fault| fault.contains(words)),
            "{text}: {faults:?}"
        );
    }
    assert!(of_scene("[run]\nstandby = 0.5\nobserve = [\"drift:tee\", \"velocities\"]").is_empty());
}

/// A valid entry of each table.
const VALID: &str = "
box = { sides = [1.0, 1.0] }
molecule = [{ atom_radius = 0.01, atom_mass = 1.0, shape = \"tee\", at = [0.9, 0.9] }]
bumper = [{ radius = 0.01, at = [0.1, 0.1] }]
wall = [{ x = 0.5 }]
gas = [{ radius = 0.01, mass = 1.0, energy = 1.0, count = 10 }]
stage = [{ until = 1.0 }]
elasticity = { pair = [{ between = [\"a\"], coefficient = 1.0 }] }
";

#[test]
fn numbers_outside_their_ranges_are_refused() {
    let schema = scene_schema();
    let mut tested = 0;
    for (table, property) in schema["properties"].as_object().unwrap() {
        let is_list = property["type"] == "array";
        let entry = if is_list {
            &property["items"]
        } else {
            &property["allOf"][0]
        };
        let reference = entry["$ref"]
            .as_str()
            .or_else(|| property["$ref"].as_str())
            .unwrap();
        let definition = schema.pointer(reference.trim_start_matches('#')).unwrap();
        for (key, property) in definition["properties"].as_object().unwrap() {
            for bad in outside(property) {
                tested += 1;
                let path = if is_list {
                    format!("{table}.0.{key}")
                } else {
                    format!("{table}.{key}")
                };
                assert!(
                    is_refused(table, &format!("{path}={bad}")),
                    "{path} = {bad}"
                );
            }
        }
    }
    assert!(tested > 30, "{tested}");
}

/// Numbers outside the range of a property.
fn outside(property: &Value) -> Vec<f64> {
    let bound = |key: &str| property[key].as_f64();
    let below = bound("minimum").map(|least| match least {
        0.0 => -1.0,
        least if least < 0.0 => 2.0 * least,
        least => 0.5 * least,
    });
    let above = bound("maximum").map(|most| 2.0 * most);
    let integer = property["type"] == "integer";
    let numbers = [
        below,
        above,
        bound("exclusiveMinimum"),
        bound("exclusiveMaximum"),
    ];
    numbers
        .into_iter()
        .flatten()
        .map(|number| if integer { number.floor() } else { number })
        .collect()
}

/// Whether a scene with one changed entry is refused.
fn is_refused(table: &str, change: &str) -> bool {
    let mut scene: toml::Table = VALID.parse().unwrap();
    if table == "method" {
        let owner = match change {
            _ if change.contains("cells") => "scheduler = \"heap\"",
            _ if change.contains("step") => "detector = \"fixed-step\"",
            _ => "detector = \"golden-secant\"",
        };
        scene.extend(format!("[method]\n{owner}").parse::<toml::Table>().unwrap());
    }
    change
        .parse::<crate::overrides::Override>()
        .unwrap()
        .apply(&mut scene)
        .unwrap();
    let Ok(scene) = Scene::from_toml(&toml::to_string(&scene).unwrap()) else {
        return true;
    };
    crate::run::check(&scene).is_err() || AnySimulation::new(&scene).is_err()
}

#[test]
fn documentation_becomes_plain_text() {
    let text = "A [`View`](crate::View) of [`X`].\nMore\n\n* one\n  two\n\n```\ncode\n```\n`[[gas]]` stays.";
    assert_eq!(
        plain(text),
        "A `View` of `X`. More\n* one two\n`[[gas]]` stays."
    );
}
