//! A point of a study: the scene with one choice of all varied values, its key, and its seed.

use std::fmt;

use anyhow::{Context, Result, ensure};
use carom::Scene;
use carom_runs::{overrides::Override, record::description, run::replica};
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use crate::hash::{fnv1a, mixed};

/// The name of a point: FNV-1a of its scene as text with all options, without seed and replica.
///
/// The text includes what ends its runs. Points of different studies with the same scene have the
/// same key.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct Key(u64);

impl Key {
    fn new(scene: &Scene) -> Self {
        Self(fnv1a(description(scene).as_bytes()))
    }
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}

impl From<Key> for String {
    fn from(key: Key) -> Self {
        key.to_string()
    }
}

impl TryFrom<String> for Key {
    type Error = String;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        let number = u64::from_str_radix(&text, 16)
            .ok()
            .filter(|_| text.len() == 16);
        number
            .map(Self)
            .ok_or_else(|| format!("'{text}' is not a key of 16 hexadecimal digits"))
    }
}

/// A point of a study.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyPoint {
    /// Its key.
    pub key: Key,
    /// The values of all varied keys, in the order of the study.
    pub values: Vec<Value>,
    /// Its values in words, such as `gas.0.area_fraction = 0.1`.
    pub label: String,
    /// Its scene; seed and replica are those of no run.
    pub scene: Scene,
    /// The seed of its replicas.
    seed: u64,
}

impl StudyPoint {
    /// Applies values to a scene.
    ///
    /// # Errors
    /// A path leads nowhere, or the scene is invalid.
    pub(crate) fn new(
        base: &Table,
        keys: &[&str],
        values: Vec<Value>,
        label: String,
    ) -> Result<Self> {
        let mut scene = scene_of(base, keys, &values).with_context(|| format!("point {label}"))?;
        let seed = seed(scene.bounds.seed, keys, &values);
        (scene.bounds.seed, scene.bounds.replica) = (0, 0);
        // Only sums are kept: neither pictures nor snapshots.
        (scene.run.animation, scene.run.animation_from) = (true, 0.0);
        (scene.run.snapshots, scene.run.snapshot_interval) = (None, None);
        Ok(Self {
            key: Key::new(&scene),
            values,
            label,
            scene,
            seed,
        })
    }

    /// Validates the scene, without placing its bodies.
    ///
    /// # Errors
    /// An entry is invalid, or a measure keeps more than sums.
    pub(crate) fn check(&self) -> Result<()> {
        replica::check(&self.scene).with_context(|| format!("point {}", self.label))
    }

    /// The values in words, with the last part of each path.
    pub fn short_label(&self) -> String {
        short_label(&self.label)
    }

    /// The scene of a replica, with numbers from 1. Its random numbers depend on the seed of the
    /// study, the values of the point, and the number.
    pub fn replica(&self, number: u64) -> Scene {
        let mut scene = self.scene.clone();
        (scene.bounds.seed, scene.bounds.replica) = (self.seed, number);
        scene
    }
}

/// A label whose paths are their last parts.
pub(crate) fn short_label(label: &str) -> String {
    parts(label)
        .into_iter()
        .map(short)
        .collect::<Vec<_>>()
        .join(", ")
}

/// The entries of a label. A comma in brackets or quotation marks is part of a value.
pub(crate) fn parts(label: &str) -> Vec<&str> {
    let (mut depth, mut is_quoted) = (0_i32, false);
    let is_separator = |letter: char| {
        match letter {
            '"' => is_quoted = !is_quoted,
            '[' | '{' if !is_quoted => depth += 1,
            ']' | '}' if !is_quoted => depth -= 1,
            _ => {}
        }
        letter == ',' && depth == 0 && !is_quoted
    };
    label.split(is_separator).map(str::trim).collect()
}

/// The last part of a path that is no index, with its value if there is one: `radius = 0.1` of
/// `gas.0.radius = 0.1`. A default alone says nothing: `elasticity.default` remains.
pub(crate) fn short(path: &str) -> &str {
    let key = path.split(" = ").next().unwrap_or(path);
    let name = key
        .rsplit('.')
        .find(|part| part.parse::<usize>().is_err())
        .filter(|part| *part != "default")
        .unwrap_or(key);
    let begin = key.rfind(name).unwrap_or(0);
    &path[begin..]
}

fn scene_of(base: &Table, keys: &[&str], values: &[Value]) -> Result<Scene> {
    let mut table = base.clone();
    for (key, value) in keys.iter().zip(values) {
        ensure!(
            !["box.seed", "box.replica"].contains(key),
            "`{key}` cannot vary: `replicas` gives runs with different random numbers"
        );
        Override::new(key, value.clone())?.apply(&mut table)?;
    }
    let scene = Scene::from_toml(&toml::to_string(&table)?)?;
    ensure!(
        scene.start.from.is_none(),
        "start.from: a study must be self-contained, so its scene cannot start from a file"
    );
    Ok(scene)
}

/// The seed of the replicas of a point: that of the study, mixed with the hash of its
/// [lines](value_lines). It has 63 bits, which TOML can hold.
pub fn seed(study: u64, keys: &[&str], values: &[Value]) -> u64 {
    let text = value_lines(keys, values).join("\n");
    mixed(mixed(study) ^ fnv1a(text.as_bytes())) >> 1
}

/// The values of a point as lines `key = value` in the order of the keys' names, so that neither
/// the order of the entries of a study nor its other points change them. 1 and 1.0 are the same.
pub fn value_lines(keys: &[&str], values: &[Value]) -> Vec<String> {
    let mut lines: Vec<String> = keys
        .iter()
        .zip(values)
        .map(|(key, value)| format!("{key} = {}", plain(value)))
        .collect();
    lines.sort();
    lines
}

/// A value as text, in which 1 and 1.0 are the same.
fn plain(value: &Value) -> String {
    match value {
        Value::Integer(whole) => (*whole as f64).to_string(),
        Value::Float(number) => number.to_string(),
        Value::Array(list) => format!(
            "[{}]",
            list.iter().map(plain).collect::<Vec<_>>().join(", ")
        ),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(keys: &[&str], values: &[f64]) -> Result<StudyPoint> {
        let base =
            "[box]\nseed = 5\n[[gas]]\nradius = 0.01\nmass = 1.0\nenergy = 1.0\ncount = 10\n";
        let values = values.iter().map(|&value| Value::Float(value)).collect();
        StudyPoint::new(&base.parse().unwrap(), keys, values, format!("of {keys:?}"))
    }

    #[test]
    fn keys_and_seeds_depend_on_values_and_not_on_their_order() {
        let one = point(&["gas.0.radius", "gas.0.mass"], &[0.02, 3.0]).unwrap();
        let other = point(&["gas.0.mass", "gas.0.radius"], &[3.0, 0.02]).unwrap();
        assert_eq!((one.key, one.seed), (other.key, other.seed));
        let third = point(&["gas.0.radius", "gas.0.mass"], &[0.02, 4.0]).unwrap();
        assert!(third.key != one.key && third.seed != one.seed);
        let scene = one.replica(3);
        assert_eq!((scene.bounds.seed, scene.bounds.replica), (one.seed, 3));
        assert!(i64::try_from(one.seed).is_ok());
    }

    #[test]
    fn lines_of_values_are_sorted_and_have_no_exponents() {
        let list = Value::Array(vec![Value::Integer(1), Value::Float(2.5e-7)]);
        let values = [list, Value::String("rod:3".to_owned()), Value::Float(3.0)];
        assert_eq!(
            value_lines(&["b", "a.0", "c"], &values),
            ["a.0 = \"rod:3\"", "b = [1, 0.00000025]", "c = 3"]
        );
    }

    #[test]
    fn the_last_word_of_a_key_names_it_unless_it_says_nothing() {
        assert_eq!(short("gas.0.radius = 0.1"), "radius = 0.1");
        assert_eq!(short("box.sides.0"), "sides.0");
        assert_eq!(
            short("elasticity.default = 0.9"),
            "elasticity.default = 0.9"
        );
    }

    #[test]
    fn a_comma_in_an_array_does_not_divide_a_label() {
        let label = "box.sides = [1.0, 2.0], gas.0.shape = \"a, b\", gas.0.radius = 0.1";
        assert_eq!(
            short_label(label),
            "sides = [1.0, 2.0], shape = \"a, b\", radius = 0.1"
        );
    }

    /// Pinned: otherwise replicas that earlier versions have finished are run again.
    #[test]
    fn keys_are_stable() {
        let point = point(&["gas.0.radius"], &[0.02]).unwrap();
        assert_eq!(
            (point.key.to_string().as_str(), point.seed),
            ("ddf153efee77c5b1", 1_378_381_359_289_797_912)
        );
        assert_eq!(Key::try_from(point.key.to_string()), Ok(point.key));
        assert!(Key::try_from("12".to_owned()).is_err());
    }

    #[test]
    fn values_that_do_not_fit_are_refused_with_the_point() {
        let error = format!("{:#}", point(&["gas.1.radius"], &[0.02]).unwrap_err());
        assert!(
            error.contains("point of [\"gas.1.radius\"]") && error.contains("1 entries"),
            "{error}"
        );
        let error = format!("{:#}", point(&["gas.0.raduis"], &[0.02]).unwrap_err());
        assert!(error.contains("did you mean `radius`?"), "{error}");
        let error = format!("{:#}", point(&["box.seed"], &[1.0]).unwrap_err());
        assert!(error.contains("`replicas`"), "{error}");
    }
}
