//! Scenes from Python objects, text and files.

use std::path::PathBuf;

use carom::Scene;
use carom_runs::{
    measures::{KINDS, MeasureKind, Of},
    run::SceneFile,
};
use pyo3::{
    exceptions::PyTypeError,
    prelude::*,
    types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString},
};
use toml::{Table, Value};

use crate::errors;

/// Deepest nesting of a description; a scene needs less than half.
const MAX_DEPTH: usize = 16;

/// The text of a scene from nested dictionaries, lists, numbers and texts.
#[pyfunction]
pub fn scene_of(tables: &Bound<'_, PyDict>) -> PyResult<String> {
    let table = table_of(tables, 0)?;
    let text = toml::to_string(&table).map_err(errors::scene)?;
    scene_of_text(&text)
}

/// The text of a scene with all options, from the text of a scene file.
#[pyfunction]
pub fn scene_of_text(text: &str) -> PyResult<String> {
    Ok(Scene::from_toml(text).map_err(errors::scene)?.to_toml())
}

/// The text of a scene file with all options, and the frame from which its bodies start.
#[pyfunction]
pub fn scene_of_file(path: PathBuf) -> PyResult<(String, Option<String>)> {
    let file = SceneFile {
        path,
        until: None,
        seed: None,
        from: None,
        set: Vec::new(),
    };
    let scene = file.read(None).map_err(errors::scene)?;
    Ok((
        scene.to_toml(),
        scene.start.snapshot.as_deref().map(str::to_owned),
    ))
}

/// The tables of a scene file as nested dictionaries, lists, numbers and texts.
#[pyfunction]
pub fn tables_of<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyAny>> {
    let table: Table = text
        .parse()
        .map_err(|error: toml::de::Error| errors::scene(error))?;
    object_of(py, &Value::Table(table))
}

/// A scene from its text and the frame from which its bodies start.
pub fn parsed(text: &str, snapshot: Option<String>) -> PyResult<Scene> {
    let mut scene = Scene::from_toml(text).map_err(errors::scene)?;
    scene.start.snapshot = snapshot.map(Into::into);
    Ok(scene)
}

/// Name, meaning, bodies and parameters (name, meaning) of a measure.
type KindWords = (
    &'static str,
    &'static str,
    &'static str,
    Vec<(&'static str, &'static str)>,
);

/// All measures.
#[pyfunction]
pub fn measure_kinds() -> Vec<KindWords> {
    let of = |kind: &MeasureKind| match kind.of {
        Of::Group => "any",
        Of::TwoGroups => "any, or two tags",
        Of::OneBody => "one body",
        Of::Pair => "pairs",
        Of::System => "system",
    };
    let parameters = |kind: &MeasureKind| {
        kind.all_parameters()
            .map(|entry| (entry.name, entry.about))
            .collect()
    };
    KINDS
        .iter()
        .map(|kind| (kind.name, kind.summary, of(kind), parameters(kind)))
        .collect()
}

/// A table of the entries of a dictionary.
pub fn table_of(dictionary: &Bound<'_, PyDict>, depth: usize) -> PyResult<Table> {
    let mut table = Table::new();
    for (key, value) in dictionary.iter() {
        let Ok(key) = key.cast::<PyString>() else {
            return Err(PyTypeError::new_err(format!(
                "the keys of a scene are texts, but one is {key}"
            )));
        };
        if !value.is_none() {
            table.insert(key.to_string(), value_of(&value, depth + 1)?);
        }
    }
    Ok(table)
}

/// A value of a dictionary at a depth of nesting.
pub fn value_of(value: &Bound<'_, PyAny>, depth: usize) -> PyResult<Value> {
    if depth > MAX_DEPTH {
        return Err(errors::SceneError::new_err(format!(
            "a scene is nested at most {MAX_DEPTH} deep"
        )));
    }
    if let Ok(value) = value.cast::<PyBool>() {
        Ok(Value::Boolean(value.is_true()))
    } else if value.cast::<PyInt>().is_ok() {
        // Larger integers are read as numbers, which the entry then accepts or refuses.
        Ok(value.extract::<i64>().map_or(
            Value::Float(value.extract().unwrap_or(f64::INFINITY)),
            Value::Integer,
        ))
    } else if let Ok(value) = value.cast::<PyFloat>() {
        Ok(Value::Float(value.value()))
    } else if let Ok(value) = value.cast::<PyString>() {
        Ok(Value::String(value.to_cow()?.into_owned()))
    } else if let Ok(value) = value.cast::<PyDict>() {
        Ok(Value::Table(table_of(value, depth)?))
    } else if let Ok(list) = value.cast::<PyList>() {
        let entries: PyResult<Vec<Value>> = list
            .iter()
            .map(|entry| value_of(&entry, depth + 1))
            .collect();
        Ok(Value::Array(entries?))
    } else {
        let kind = value.get_type().name()?.to_string();
        Err(PyTypeError::new_err(format!(
            "a scene has numbers, texts, lists and dictionaries, but no {kind}"
        )))
    }
}

fn object_of<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::Boolean(value) => PyBool::new(py, *value).to_owned().into_any(),
        Value::Integer(value) => value.into_pyobject(py)?.into_any(),
        Value::Float(value) => PyFloat::new(py, *value).into_any(),
        Value::String(value) => PyString::new(py, value).into_any(),
        Value::Datetime(value) => PyString::new(py, &value.to_string()).into_any(),
        Value::Array(values) => {
            let list = PyList::empty(py);
            values
                .iter()
                .try_for_each(|value| list.append(object_of(py, value)?))?;
            list.into_any()
        }
        Value::Table(table) => {
            let dictionary = PyDict::new(py);
            table
                .iter()
                .try_for_each(|(key, value)| dictionary.set_item(key, object_of(py, value)?))?;
            dictionary.into_any()
        }
    })
}
