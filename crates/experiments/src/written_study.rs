//! A study that a command writes for the user: its parts, and the study that they give.

use std::path::Path;

use anyhow::Result;
use carom::Scene;
use carom_sweeps::{Size, Study};
use serde::Serialize;
use toml::{Table, Value};

/// A study file by its parts.
#[derive(Debug, Clone, Default, Serialize)]
pub struct WrittenStudy {
    /// Title of the page.
    pub title: String,
    /// The question that the study answers.
    pub question: String,
    /// Number of replicas of each point.
    pub replicas: u64,
    /// Measures besides those of the scene.
    pub measure: Vec<Value>,
    /// The keys that vary.
    pub vary: Vec<Varied>,
    /// Names of figures that are compared with their predictions.
    pub expect: Vec<ExpectedFigures>,
    /// The scene.
    pub scene: Table,
}

/// A key that varies, with a name for each of its values.
#[derive(Debug, Clone, Serialize)]
pub struct Varied {
    /// Its path in the scene.
    pub key: String,
    /// What varies.
    pub label: String,
    /// A name for each value.
    pub names: Vec<String>,
    /// The values.
    pub values: Vec<Value>,
}

/// A figure that is compared with its prediction.
#[derive(Debug, Clone, Serialize)]
pub struct ExpectedFigures {
    /// Its name.
    pub figure: String,
}

impl WrittenStudy {
    /// The study, with another number of replicas if one is given.
    ///
    /// # Errors
    /// The scene is invalid.
    pub fn read(&self, replicas: Option<u64>) -> Result<Study> {
        let size = Size {
            replicas,
            is_quick: false,
        };
        Study::parse(&toml::to_string(self)?, Path::new(""), size)
    }
}

/// An entry of `measure`: a measure of the bodies with a tag, with this number of bins.
pub fn measure(kind: &str, tag: &str, bins: i64) -> Value {
    let keys = [
        ("kind", kind.into()),
        ("of", tag.into()),
        ("bins", bins.into()),
    ];
    Value::Table(
        keys.map(|(key, value): (&str, Value)| (key.to_owned(), value))
            .into_iter()
            .collect(),
    )
}

/// A scene as the table of a study.
///
/// # Errors
/// Never: a scene is plain data.
pub fn table_of(scene: &Scene) -> Result<Table> {
    Ok(scene.to_toml().parse()?)
}

/// The options that a command line without its command gives, for tests.
#[cfg(test)]
pub fn options<T: clap::Args>(words: &[&str]) -> T {
    let command = T::augment_args(clap::Command::new("carom"));
    let matches = command
        .try_get_matches_from([&["carom"], words].concat())
        .unwrap();
    T::from_arg_matches(&matches).unwrap()
}
