//! `tables.json`: what the columns of the measures' CSV files hold, with all that charts need.

use std::{collections::BTreeMap, fs};

use anyhow::{Context, Result};
use carom_report::page::DataChart;
use carom_tables::{Column, Level, Role, Spacing, Table};
use serde_json::{Value, json};

use super::read::{json, text};
use crate::{
    measures::{self, Drawing, Results},
    output::Folder,
};

/// Name of the file.
const TABLES: &str = "tables.json";

/// Writes what the columns of the measures' tables hold: units, sources of predictions, and what
/// charts need besides the CSV files.
///
/// # Errors
/// The file cannot be written.
pub fn write(results: &Results, folder: &Folder) -> Result<()> {
    let drawing =
        |drawing: &Drawing| json!({ "drawing": drawing.file, "caption": drawing.caption });
    let tables = results.tables.iter().map(head);
    let all: Vec<Value> = tables.chain(results.drawings.iter().map(drawing)).collect();
    folder.write_json(TABLES, &all)
}

/// The drawings of a folder from `tables.json` and their SVG files; those whose file is missing are
/// left out.
///
/// # Errors
/// A file is there and cannot be read.
pub(super) fn drawings(folder: &Folder) -> Result<Vec<DataChart>> {
    let heads = json(folder, TABLES)?.unwrap_or_default();
    let heads = heads.as_array().cloned().unwrap_or_default();
    let drawings = heads
        .iter()
        .filter_map(|head| head["drawing"].as_str().map(|file| (file, head)));
    let drawings = drawings.map(|(file, head)| {
        let svg = if file.contains(['/', '\\']) {
            None
        } else {
            text(folder, file)?
        };
        let caption = head["caption"].as_str().unwrap_or_default().to_owned();
        Ok(svg.map(|svg| DataChart {
            svg,
            caption,
            file: file.to_owned(),
        }))
    });
    drawings.filter_map(Result::transpose).collect()
}

fn head(table: &Table) -> Value {
    let column = |column: &Column| {
        let (role, source) = column.role.words();
        json!({
            "name": column.name, "label": column.label, "unit": column.unit, "role": role, "source": source
        })
    };
    let columns: Vec<Value> = table.in_file().map(column).collect();
    let levels = table.levels.iter().map(|level| {
        json!({ "of": level.column, "label": level.label, "value": level.value, "source": level.source })
    });
    // What is drawn but follows from other columns is not in the CSV file.
    let derived = table
        .columns
        .iter()
        .enumerate()
        .filter(|(_, column)| column.role == Role::Derived);
    let derived = derived.map(|(place, column)| {
        json!({ "place": place, "label": column.label, "unit": column.unit, "values": column.values })
    });
    json!({
        "file": measures::file_name(table),
        "title": table.title,
        "caption": table.caption,
        "spacing": if table.spacing == Spacing::Logarithmic { "logarithmic" } else { "linear" },
        "decades": table.decades,
        "relative": table.relative,
        "guides": table.guides,
        "polar": table.is_polar,
        "names": table.names,
        "colour": table.colour,
        "columns": columns,
        "levels": levels.collect::<Vec<Value>>(),
        "derived": derived.collect::<Vec<Value>>(),
    })
}

/// Reads the tables of a folder from `tables.json` and the CSV files; those whose file is missing
/// are left out. Files of earlier versions lack labels, levels and derived columns.
///
/// # Errors
/// A file is there and cannot be read.
pub(super) fn tables(folder: &Folder) -> Result<Vec<Table>> {
    let heads = json(folder, TABLES)?.unwrap_or_default();
    let heads = heads.as_array().cloned().unwrap_or_default();
    let tables = heads.iter().map(|head| {
        let name = head["file"].as_str().unwrap_or_default();
        // A name with a path would leave the folder.
        let path = folder.path().join(name);
        if name.is_empty() || name.contains(['/', '\\']) || !path.is_file() {
            return Ok(None);
        }
        let text =
            fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
        Ok(Some(table(head, name, &columns_of(&text))))
    });
    tables.filter_map(Result::transpose).collect()
}

/// The columns of a CSV file by their names. A cell that is no number is empty.
fn columns_of(text: &str) -> BTreeMap<&str, Vec<Option<f64>>> {
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let mut columns: Vec<Vec<Option<f64>>> = vec![Vec::new(); names.len()];
    for line in lines {
        let mut cells = line.split(',');
        for column in &mut columns {
            column.push(
                cells
                    .next()
                    .and_then(|cell| cell.parse().ok())
                    .filter(|value: &f64| value.is_finite()),
            );
        }
    }
    names.into_iter().zip(columns).collect()
}

fn table(head: &Value, file: &str, cells: &BTreeMap<&str, Vec<Option<f64>>>) -> Table {
    let list = |key: &str| head[key].as_array().cloned().unwrap_or_default();
    let mut columns: Vec<Column> = Vec::new();
    for column in list("columns") {
        let name = string(&column["name"]);
        let label = column["label"]
            .as_str()
            .map_or_else(|| name.replace('_', " "), str::to_owned);
        let values = cells.get(name.as_str()).cloned().unwrap_or_default();
        let role = role(&column);
        columns.push(Column {
            label,
            unit: string(&column["unit"]),
            role,
            values,
            quantities: Vec::new(),
            name,
        });
    }
    for column in list("derived") {
        let label = string(&column["label"]);
        let values = column["values"].as_array().cloned().unwrap_or_default();
        let values = values.iter().map(Value::as_f64).collect();
        let place = column["place"].as_u64().unwrap_or(0) as usize;
        let (name, unit, role) = (label.clone(), string(&column["unit"]), Role::Derived);
        let column = Column {
            name,
            label,
            unit,
            role,
            values,
            quantities: Vec::new(),
        };
        columns.insert(place.min(columns.len()), column);
    }
    Table {
        name: file.trim_end_matches(".csv").to_owned(),
        title: string(&head["title"]),
        caption: string(&head["caption"]),
        spacing: if head["spacing"] == "logarithmic" {
            Spacing::Logarithmic
        } else {
            Spacing::Linear
        },
        decades: list("decades").iter().map(string).collect(),
        relative: list("relative").iter().map(string).collect(),
        guides: serde_json::from_value(head["guides"].clone()).unwrap_or_default(),
        is_polar: head["polar"] == true,
        names: list("names").iter().map(string).collect(),
        colour: head["colour"].as_u64().unwrap_or(0) as usize,
        columns,
        levels: list("levels").iter().filter_map(level).collect(),
    }
}

/// A text; empty if the value is none.
fn string(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_owned()
}

/// A level of a table; `None` if it has no value.
fn level(level: &Value) -> Option<Level> {
    let value = level["value"].as_f64()?;
    let [column, label, source] = ["of", "label", "source"].map(|key| string(&level[key]));
    Some(Level {
        column,
        label,
        value,
        source,
    })
}

/// The role of a column by its word, see [`Role::words`].
fn role(column: &Value) -> Role {
    match column["role"].as_str().unwrap_or_default() {
        "abscissa" => Role::Abscissa,
        "count" => Role::Count,
        "bin width" => Role::Width,
        "value" => Role::Value,
        "standard error" => Role::StandardError,
        "prediction" => Role::Prediction {
            source: column["source"].as_str().unwrap_or_default().to_owned(),
        },
        _ => Role::Undrawn,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::Existing;

    #[test]
    fn tables_are_read_as_they_were_written() {
        let written = vec![
            Table::new("one", "First")
                .caption("A caption.")
                .logarithmic()
                .abscissa("time", "time", vec![0.1, 0.2 + 0.1])
                .undrawn("total", "1", vec![5.0, 6.0])
                .derived("part of total", "1", vec![Some(1.0 / 3.0), None])
                .counts("events", vec![3, 4])
                .value("x_mean", "length", vec![Some(1e-300), None])
                .labelled("⟨x⟩")
                .errors(vec![Some(0.5), None])
                .prediction("theory", vec![Some(2.0), Some(3.0)], "a source")
                .level("level", Some(0.7), "another"),
            Table::new("two", "Second")
                .polar()
                .named(vec!["A".to_owned()])
                .in_decades(&["x"])
                .relative_to_first(&["y"])
                .guide("x", 2.0, "∝ t²", true),
        ];
        let root = tempfile::tempdir().unwrap();
        let folder = Folder::create(root.path(), Existing::Refuse).unwrap();
        let drawing = Drawing {
            file: "d.svg".to_owned(),
            caption: "A drawing.".to_owned(),
            svg: "<svg/>".to_owned(),
        };
        let results = Results {
            tables: written,
            drawings: vec![drawing],
            ..Results::default()
        };
        results.write(&folder).unwrap();
        write(&results, &folder).unwrap();
        let found = tables(&folder).unwrap();
        assert_eq!(found, results.tables);
        let [drawing] = &drawings(&folder).unwrap()[..] else {
            panic!("one drawing")
        };
        assert_eq!(
            (drawing.file.as_str(), drawing.svg.as_str()),
            ("d.svg", "<svg/>")
        );
        fs::remove_file(root.path().join("two.csv")).unwrap();
        assert_eq!(tables(&folder).unwrap().len(), 1);
    }
}
