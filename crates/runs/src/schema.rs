//! JSON Schema of scene files: every key with its type, range, default and meaning, from the types.

use carom::{
    Scene, Shape,
    engine::{RunSpec, StartVelocities},
    geometry::EdgedShape,
};
use schemars::{JsonSchema, generate::SchemaSettings, transform::RecursiveTransform};
use serde_json::{Map, Value, json};

use crate::{
    measures::{KINDS, Of},
    overrides::RENAMED,
    run::EXTENDED_XYZ,
};

/// Letters of a tag in a name of `run.observe`.
const TAG: &str = r"[\w-]+";

/// Keys that a file must give in the tables of stages.
const REQUIRED_IN_STAGES: [(&str, &[&str]); 4] = [
    ("StageSpec", &["until"]),
    ("RelabelSpec", &["name"]),
    ("HeatSpec", &["tag"]),
    ("ThermostatSpec", &["tag", "every"]),
];

/// Returns the JSON Schema (draft 7) of a type that a TOML file holds, as its derivation gives it.
pub fn schema_of<T: JsonSchema>(title: &str) -> Value {
    let settings = SchemaSettings::draft07().with_transform(RecursiveTransform(clean));
    let mut schema = settings
        .into_generator()
        .into_root_schema_for::<T>()
        .to_value();
    schema["title"] = title.into();
    schema
}

/// Returns the JSON Schema (draft 7, which editors of TOML read) of a scene file.
///
/// # Panics
/// Never: the names that it adds to are those of the types.
pub fn scene_schema() -> Value {
    let mut schema = schema_of::<Scene>("Scene of carom");
    let types = &mut schema["definitions"];
    // A file must give these, although they have a default in code.
    types["MoleculeSpec"]["required"] = json!(["at"]);
    for (name, keys) in REQUIRED_IN_STAGES {
        types[name]["required"] = json!(keys);
        for key in keys {
            types[name]["properties"][key]
                .as_object_mut()
                .map(|entry| entry.remove("default"));
        }
    }
    types["StageSpec"]["properties"]["measure"]["default"] = true.into();
    for (name, key) in [("MoleculeSpec", "at"), ("GasSpec", "energy")] {
        types[name]["properties"][key]
            .as_object_mut()
            .map(|entry| entry.remove("default"));
    }
    for gas_or_molecule in ["MoleculeSpec", "GasSpec"] {
        add(
            &mut types[gas_or_molecule]["properties"]["shape"],
            one_of(Shape::NAMES.into_iter().chain(EdgedShape::NAMES)),
        );
    }
    add(
        &mut types["MeasureSpec"]["properties"]["kind"],
        one_of(KINDS.iter().map(|kind| kind.name)),
    );
    let run = &mut types["RunSpec"]["properties"];
    add(&mut run["snapshots"], json!({ "enum": [EXTENDED_XYZ] }));
    add(
        &mut run["observe"]["items"],
        one_of(observable().iter().map(String::as_str)),
    );
    // Defaults that are left out of a written scene.
    let default = RunSpec::default();
    run["measure_from"]["default"] = default.measure_from.time().into();
    run["animation"]["default"] = default.animation.into();
    run["animation_from"]["default"] = default.animation_from.into();
    types["GasSpec"]["properties"]["velocities"]["default"] = json!(StartVelocities::default());
    for (table, old, new) in RENAMED {
        let name = if table == "run" { "RunSpec" } else { table };
        let mut entry = types[name]["properties"][new].clone();
        entry["description"] = format!("Old name of `{new}`.").into();
        entry["deprecated"] = true.into();
        types[name]["properties"][old] = entry;
    }
    schema
}

/// Returns a schema as text, in which a number may also be an expression in quotes: scene files
/// have those, and editors should not mark them.
pub fn text(schema: &Value) -> String {
    let mut schema = schema.clone();
    admit_expressions(&mut schema);
    format!("{schema:#}\n")
}

fn admit_expressions(schema: &mut Value) {
    match schema {
        Value::Object(entry) => {
            if let Some(Value::String(name)) = entry.get("type")
                && ["number", "integer"].contains(&name.as_str())
            {
                let types = json!([name, "string"]);
                entry.insert("type".to_owned(), types);
            }
            entry.values_mut().for_each(admit_expressions);
        }
        Value::Array(list) => list.iter_mut().for_each(admit_expressions),
        _ => (),
    }
}

/// The names of `run.observe`: `name`, `name:TAG`, or both for a measure of any group.
fn observable() -> Vec<String> {
    let measures = KINDS.iter().flat_map(|kind| match kind.of {
        Of::Group => vec![kind.name.to_owned(), format!("{}:TAG", kind.name)],
        Of::OneBody => vec![format!("{}:TAG", kind.name)],
        Of::TwoGroups | Of::Pair => ["", ":TAG", ":TAG,:TAG"]
            .map(|tags| format!("{}{tags}", kind.name))
            .to_vec(),
        Of::System => vec![kind.name.to_owned()],
    });
    measures.collect()
}

/// A schema of a string with one of these names, where `:N` stands for a number and `:TAG` for a
/// tag.
/// A colon and a positive number, in patterns.
const NUMBER: &str = ":[0-9]*\\.?[0-9]+(e-?[0-9]+)?";

fn one_of<'a>(names: impl Iterator<Item = &'a str>) -> Value {
    let (open, fixed): (Vec<&str>, Vec<&str>) = names.partition(|name| name.contains(':'));
    let pattern = |name: &str| {
        format!(
            "^{}$",
            name.replace(":N", ":[0-9]+")
                .replace(":L", NUMBER)
                .replace(":A,B", &format!("{NUMBER},{}", &NUMBER[1..]))
                .replace(":A", NUMBER)
                .replace(",:TAG", &format!(",{TAG}"))
                .replace(":TAG", &format!(":{TAG}"))
        )
    };
    let patterns = open
        .into_iter()
        .map(|name| json!({ "pattern": pattern(name) }));
    let choices: Vec<Value> = [json!({ "enum": fixed })]
        .into_iter()
        .chain(patterns)
        .collect();
    json!({ "anyOf": choices })
}

fn add(entry: &mut Value, more: Value) {
    if let (Value::Object(entry), Value::Object(more)) = (entry, more) {
        entry.extend(more);
    }
}

/// Adapts the schema of a Rust type to TOML, which has no null, and turns its documentation to
/// plain text.
fn clean(schema: &mut schemars::Schema) {
    let Some(entry) = schema.as_object_mut() else {
        return;
    };
    entry.remove("format");
    if entry.get("default") == Some(&Value::Null) {
        entry.remove("default");
    }
    if let Some(Value::Array(types)) = entry.get_mut("type") {
        types.retain(|name| name != "null");
        if let [only] = types.as_slice() {
            let only = only.clone();
            entry.insert("type".to_owned(), only);
        }
    }
    without_null(entry);
    if let Some(Value::String(text)) = entry.get_mut("description") {
        *text = plain(text);
    }
}

/// Replaces a choice between a schema and null by the schema.
fn without_null(entry: &mut Map<String, Value>) {
    let Some(Value::Array(choices)) = entry.get_mut("anyOf") else {
        return;
    };
    choices.retain(|choice| choice["type"] != "null");
    if choices.len() == 1 {
        let only = choices.remove(0);
        entry.remove("anyOf");
        entry.insert("allOf".to_owned(), json!([only]));
    }
}

/// Returns documentation without code examples and links, a line for each paragraph or item of a
/// list.
fn plain(documentation: &str) -> String {
    let mut paragraphs = vec![String::new()];
    let mut is_code = false;
    for line in documentation.lines().map(str::trim) {
        is_code ^= line.starts_with("```");
        if is_code || line.starts_with("```") {
            continue;
        }
        if line.is_empty() || line.starts_with("* ") {
            paragraphs.push(String::new());
        }
        if let Some(paragraph) = paragraphs.last_mut() {
            *paragraph += if paragraph.is_empty() { "" } else { " " };
            *paragraph += line;
        }
    }
    paragraphs.retain(|paragraph| !paragraph.is_empty());
    without_links(&paragraphs.join("\n"))
}

/// Replaces `[text](target)` and ``[`item`]`` by their text; `[[key]]` and other brackets stay.
fn without_links(text: &str) -> String {
    let mut plain = String::new();
    let mut rest = text;
    while let Some(open) = rest.find("[`") {
        let (before, link) = rest.split_at(open);
        plain += before;
        let Some(close) = link.find("`]") else { break };
        plain += &link[1..=close];
        rest = &link[close + 2..];
        if rest.starts_with('(')
            && let Some(end) = rest.find(')')
        {
            rest = &rest[end + 1..];
        }
    }
    plain + rest
}

#[cfg(test)]
mod tests;
