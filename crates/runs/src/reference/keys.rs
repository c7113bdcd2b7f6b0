//! The keys of a scene file, a section for each table, from its JSON Schema.

use serde_json::{Map, Value};

use super::{table, wrapped};

/// Words of which a unit consists; a unit stands between parentheses in the documentation of a key.
const UNIT_WORDS: [&str; 11] = [
    "length", "length²", "mass", "time", "time²", "radians", "turns", "per", "/", "×", "area",
];

/// More alternatives than this are not listed in the table of keys.
const MAX_CHOICES: usize = 8;

/// A default in words with more characters stays in the sentence.
const MAX_DEFAULT: usize = 40;

/// Headings of the table of keys.
const HEADINGS: [&str; 6] = ["key", "type", "default", "range", "unit", "meaning"];

/// Returns a section of Markdown for each table of the file, in the order of the type.
pub fn sections(schema: &Value) -> Vec<String> {
    let mut sections = Vec::new();
    collect(schema, schema, "", &mut sections);
    merge(sections)
        .into_iter()
        .map(|section| section.text(schema))
        .collect()
}

/// Returns the table of the keys that stand in no table of the file; without such keys nothing.
pub fn outermost(schema: &Value) -> String {
    let section = Section {
        headings: Vec::new(),
        summary: "",
        entry: schema,
    };
    let keys = section.keys(schema);
    if keys.is_empty() {
        keys
    } else {
        format!("\n{keys}")
    }
}

/// A table of the file.
struct Section<'a> {
    /// Its headings in the file, such as `[[molecule]]`.
    headings: Vec<String>,
    /// Its description where it is a key of another table.
    summary: &'a str,
    entry: &'a Value,
}

/// Finds the tables among the properties of an entry, and those in them. `path` ends with a dot
/// unless it is empty.
fn collect<'a>(schema: &'a Value, entry: &'a Value, path: &str, sections: &mut Vec<Section<'a>>) {
    for (key, property) in properties(entry) {
        let is_list = resolved(schema, property).get("items").is_some();
        let inner = if is_list {
            resolved(schema, item(schema, property))
        } else {
            resolved(schema, property)
        };
        if inner.get("properties").is_none() {
            continue;
        }
        let name = format!("{path}{key}");
        let heading = if is_list {
            format!("[[{name}]]")
        } else {
            format!("[{name}]")
        };
        sections.push(Section {
            headings: vec![heading],
            summary: description(property),
            entry: inner,
        });
        collect(schema, inner, &format!("{name}."), sections);
    }
}

/// Joins tables of one type, at the place of the first.
fn merge(sections: Vec<Section<'_>>) -> Vec<Section<'_>> {
    let mut merged: Vec<Section<'_>> = Vec::new();
    for section in sections {
        match merged
            .iter_mut()
            .find(|known| std::ptr::eq(known.entry, section.entry))
        {
            Some(known) => known.headings.extend(section.headings),
            None => merged.push(section),
        }
    }
    merged
}

impl Section<'_> {
    fn text(&self, schema: &Value) -> String {
        let headings: Vec<String> = self
            .headings
            .iter()
            .map(|heading| format!("`{heading}`"))
            .collect();
        let mut text = format!("\n## {}\n\n", headings.join(", "));
        let own = description(self.entry);
        text += &paragraphs(if own.is_empty() { self.summary } else { own });
        text.push('\n');
        text + &self.keys(schema)
    }

    /// The table of its keys and the notes on them; without keys nothing.
    fn keys(&self, schema: &Value) -> String {
        let rows: Vec<Vec<String>> = properties(self.entry)
            .filter(|(key, property)| {
                !self.is_table(schema, key) && property.get("deprecated").is_none()
            })
            .map(|(key, property)| self.row(schema, key, property))
            .collect();
        if rows.is_empty() {
            return String::new();
        }
        let notes = properties(self.entry).map(|(key, property)| notes(schema, key, property));
        table(&HEADINGS, &rows) + &notes.collect::<String>()
    }

    /// Whether the key has a section of its own.
    fn is_table(&self, schema: &Value, key: &str) -> bool {
        let property = &self.entry["properties"][key];
        resolved(schema, item(schema, property))
            .get("properties")
            .is_some()
    }

    fn row(&self, schema: &Value, key: &str, property: &Value) -> Vec<String> {
        let required = self.entry["required"].as_array();
        let is_required = required.is_some_and(|keys| keys.iter().any(|required| required == key));
        let meaning = description(property).lines().next().unwrap_or_default();
        let (default, meaning) = match default_in_words(meaning) {
            Some((words, rest)) => (words, rest),
            None => (String::new(), meaning.to_owned()),
        };
        let default = match property.get("default") {
            _ if is_required => "required".to_owned(),
            Some(value) => format!("`{}`", value.to_string().replace(',', ", ")),
            None => default,
        };
        let (unit, range) = (unit(&meaning).to_owned(), range(schema, property));
        let meaning = without_columns(&meaning, &unit, &range);
        vec![
            format!("`{key}`"),
            type_of(schema, property),
            default,
            range,
            unit,
            meaning,
        ]
    }
}

/// The values of a key with names, and what its documentation says after the first paragraph.
fn notes(schema: &Value, key: &str, property: &Value) -> String {
    let mut text = String::new();
    if let Some((_, rest)) = description(property).split_once('\n') {
        text.push('\n');
        text += &paragraphs(&format!("`{key}`: {rest}"));
    }
    let choices = choices(resolved(schema, property));
    let values: Vec<String> = choices
        .filter(|choice| !description(choice).is_empty())
        .filter_map(|choice| {
            Some(format!(
                "* `{}`: {}",
                constant(choice)?,
                description(choice).replace('\n', " ")
            ))
        })
        .collect();
    if !values.is_empty() {
        text.push('\n');
        text += &paragraphs(&format!("Values of `{key}`:\n{}", values.join("\n")));
    }
    text
}

/// Paragraphs and items of lists, one a line, as Markdown.
fn paragraphs(lines: &str) -> String {
    let mut text = String::new();
    let mut is_in_list = false;
    for line in lines.lines() {
        let item = line.strip_prefix("* ");
        let is_next_item = is_in_list && item.is_some();
        if !text.is_empty() && !is_next_item {
            text.push('\n');
        }
        is_in_list = item.is_some();
        text += &item.map_or_else(
            || wrapped(line, ""),
            |item| wrapped(&format!("- {item}"), "  "),
        );
        text.push('\n');
    }
    text
}

/// The type of a key in words.
fn type_of(schema: &Value, property: &Value) -> String {
    let entry = resolved(schema, property);
    if let Some(names) = entry["enum"].as_array() {
        return joined(names.iter().map(|name| format!("`{name}`")));
    }
    if choices(entry).count() > MAX_CHOICES {
        return "string".to_owned();
    }
    if choices(entry).next().is_some() {
        return joined(choices(entry).map(|choice| match constant(choice) {
            Some(value) => format!("`{value}`"),
            None => type_of(schema, choice),
        }));
    }
    // In the plural, of each alternative; entries of any type have no name.
    let of = || {
        let item = type_of(schema, &entry["items"]);
        match resolved(schema, &entry["items"])["type"].as_str() {
            Some("array") => format!("lists of {}", item.trim_start_matches("list of ")),
            _ if item.is_empty() => item,
            _ => format!("{}s", item.trim_end_matches('s').replace(", ", "s, ")),
        }
    };
    match entry["type"].as_str() {
        Some("array") => match (entry["minItems"].as_u64(), entry["maxItems"].as_u64()) {
            (Some(least), Some(most)) if least == most => format!("{most} {}", of()),
            (Some(least), Some(most)) => format!("{least} to {most} {}", of()),
            _ if of().is_empty() => "list".to_owned(),
            _ => format!("list of {}", of()),
        },
        Some("object") => "table".to_owned(),
        Some(name) => name.to_owned(),
        None => {
            let text = entry["pattern"]
                .as_str()
                .map(|pattern| format!("`\"{}\"`", readable(pattern)));
            match entry["type"].as_array() {
                Some(types) => types
                    .iter()
                    .filter_map(Value::as_str)
                    .map(|name| {
                        if name == "string" {
                            text.clone().unwrap_or_default()
                        } else {
                            name.to_owned()
                        }
                    })
                    .collect::<Vec<_>>()
                    .join(" or "),
                None => text.map_or_else(String::new, |text| text.replace('"', "")),
            }
        }
    }
}

/// A pattern of a name as it is written in the documentation.
fn readable(pattern: &str) -> String {
    pattern
        .trim_matches(['^', '$'])
        .replace(r"[0-9]*\.?[0-9]+(e-?[0-9]+)?", "X")
        .replace("[0-9]+", "N")
        .replace(r"[\w-]+", "TAG")
}

/// The range of a number or of the numbers in a list.
fn range(schema: &Value, property: &Value) -> String {
    let entry = resolved(schema, property);
    if let Some(items) = entry.get("items").filter(|items| items.is_object()) {
        return range(schema, items);
    }
    let number = |key: &str| entry[key].as_f64().map(written);
    if let (Some(least), Some(most)) = (number("minimum"), number("maximum")) {
        return format!("{least} to {most}");
    }
    let low = number("minimum").map(|least| format!("≥ {least}"));
    let low = low.or_else(|| number("exclusiveMinimum").map(|least| format!("> {least}")));
    let high = number("exclusiveMaximum").map(|most| format!("< {most}"));
    let high = high.or_else(|| number("maximum").map(|most| format!("≤ {most}")));
    low.into_iter().chain(high).collect::<Vec<_>>().join(", ")
}

fn written(number: f64) -> String {
    if number == 0.0 || (1e-3..1e9).contains(&number.abs()) {
        number.to_string()
    } else {
        format!("{number:e}")
    }
}

/// The words of a short sentence `Default: …` and the text without it; `None` if there is none.
pub(super) fn default_in_words(meaning: &str) -> Option<(String, String)> {
    let (before, rest) = meaning.split_once(" Default: ")?;
    let (words, after) = rest.split_once('.').filter(|(words, after)| {
        words.chars().count() <= MAX_DEFAULT && !after.starts_with(|next: char| next != ' ')
    })?;
    Some((words.to_owned(), format!("{before}{after}")))
}

/// A text without what other columns of its row say: the unit between parentheses, and the range.
pub(super) fn without_columns(meaning: &str, unit: &str, range: &str) -> String {
    let mut text = meaning.to_owned();
    if !unit.is_empty() {
        text = text.replacen(&format!(" ({unit})"), "", 1);
    }
    if let Some((least, most)) = range.split_once(" to ") {
        for minus in ["-", "−"] {
            let [least, most] = [least, most].map(|number| number.replace('-', minus));
            for comma in [",", ";", ""] {
                let words = format!("{comma} from {least} to {most}");
                for end in [".", ",", ":", ";", ")"] {
                    text = text.replacen(&format!("{words}{end}"), end, 1);
                }
            }
        }
    }
    text
}

/// The first unit between parentheses; nothing for a pure number.
pub(super) fn unit(meaning: &str) -> &str {
    let is_unit = |text: &&str| {
        text.split_whitespace()
            .all(|word| UNIT_WORDS.contains(&word))
            && !text.is_empty()
    };
    let opened = meaning.split('(').skip(1);
    opened
        .filter_map(|rest| rest.split_once(')').map(|(inner, _)| inner))
        .find(is_unit)
        .unwrap_or_default()
}

fn joined(parts: impl Iterator<Item = String>) -> String {
    parts
        .filter(|part| !part.is_empty())
        .collect::<Vec<_>>()
        .join(", ")
}

fn description(entry: &Value) -> &str {
    entry["description"].as_str().unwrap_or_default()
}

fn constant(choice: &Value) -> Option<&Value> {
    choice.get("const").or_else(|| {
        choice["enum"]
            .as_array()
            .filter(|names| names.len() == 1)?
            .first()
    })
}

fn choices(entry: &Value) -> impl Iterator<Item = &Value> {
    ["oneOf", "anyOf"]
        .into_iter()
        .filter_map(|key| entry[key].as_array())
        .flatten()
}

fn properties(entry: &Value) -> impl Iterator<Item = (&String, &Value)> {
    entry["properties"]
        .as_object()
        .into_iter()
        .flat_map(Map::iter)
}

/// The entries of a list; what is no list is returned as it is.
fn item<'a>(schema: &'a Value, entry: &'a Value) -> &'a Value {
    let list = resolved(schema, entry);
    list.get("items").unwrap_or(list)
}

/// The definition that an entry refers to; an entry without a reference is returned as it is.
fn resolved<'a>(schema: &'a Value, entry: &'a Value) -> &'a Value {
    let reference = entry
        .get("$ref")
        .or_else(|| entry["allOf"].as_array()?.first()?.get("$ref"));
    let target = reference
        .and_then(Value::as_str)
        .and_then(|path| schema.pointer(path.trim_start_matches('#')));
    target.unwrap_or(entry)
}
