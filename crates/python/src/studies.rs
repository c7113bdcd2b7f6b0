//! Points of studies, by the rule of `carom sweep`.

use carom_sweeps::point;
use pyo3::{prelude::*, types::PyDict};
use toml::Value;

use crate::scene::value_of;

/// Label and seed of the point of a study with these values of its keys.
#[pyfunction]
pub fn study_point(seed: u64, values: &Bound<'_, PyDict>) -> PyResult<(String, u64)> {
    let mut keys: Vec<String> = Vec::with_capacity(values.len());
    let mut found: Vec<Value> = Vec::with_capacity(values.len());
    for (key, value) in values.iter() {
        keys.push(key.extract()?);
        found.push(value_of(&value, 0)?);
    }
    let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
    Ok((
        point::value_lines(&keys, &found).join(", "),
        point::seed(seed, &keys, &found),
    ))
}
