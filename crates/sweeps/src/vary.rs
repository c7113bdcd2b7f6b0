//! `[[vary]]`: the keys of a scene that a study changes, and their values.

use anyhow::{Context, Result, bail, ensure};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::Value;

/// Largest number of values of one entry; more are a mistake.
const MAX_VALUES: usize = 100_000;

/// Digits to which the values of a range are rounded, so that they are the numbers that a person
/// would write.
const DIGITS: usize = 12;

/// Distances of the values of a range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ValueSpacing {
    /// Equal differences.
    #[default]
    Linear,
    /// Equal ratios.
    Logarithmic,
}

/// Keys of the scene that change, with their values.
///
/// Either `key` with `values`, or `key` with `from`, `to`, `steps` and `spacing`, or `keys` with
/// `values` that are lists: keys that change together.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct VarySpec {
    /// Path of the key in the scene, such as `gas.0.area_fraction`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub key: Option<String>,
    /// Paths of keys that change together. Excludes `key`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub keys: Option<Vec<String>>,
    /// The values; with `keys` a list of values for each.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Vec<serde_json::Value>>")]
    pub values: Option<Vec<Value>>,
    /// A name for each of `values`, for charts and tables.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub names: Option<Vec<String>>,
    /// A name for the quantity that changes, such as `gap`, for charts and tables in place of the
    /// paths of the keys. `names` that are numbers are then its values.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// First value of a range: a number. Excludes `values`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<f64>")]
    pub from: Option<Value>,
    /// Last value of a range: a number.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<f64>")]
    pub to: Option<Value>,
    /// Number of values of a range, with both ends; from 2 to 100 000.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 2, max = 100_000))]
    pub steps: Option<usize>,
    /// Distances of the values of a range. Default: `linear`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spacing: Option<ValueSpacing>,
}

/// Keys that change together, with all their values.
#[derive(Debug, Clone, PartialEq)]
pub struct Vary {
    /// Paths of the keys.
    pub keys: Vec<String>,
    /// For each setting the values of all keys.
    pub settings: Vec<Vec<Value>>,
    /// The names of the settings, if they have names.
    pub names: Option<Vec<String>>,
    /// The name of the quantity that changes, if it has one.
    pub label: Option<String>,
    /// Distances of the values, for charts.
    pub spacing: ValueSpacing,
}

impl Vary {
    /// Reads an entry.
    ///
    /// # Errors
    /// Keys are missing or exclude each other, or a value is out of range.
    pub fn new(spec: &VarySpec) -> Result<Self> {
        let keys = match (&spec.key, &spec.keys) {
            (Some(key), None) => vec![key.clone()],
            (None, Some(keys)) if !keys.is_empty() => keys.clone(),
            (None, Some(_)) => bail!("`keys` is empty"),
            (Some(_), Some(_)) => bail!("`key` and `keys` exclude each other"),
            (None, None) => bail!("`key` is missing: the path of a key of the scene"),
        };
        let is_range = spec.from.is_some() || spec.to.is_some() || spec.steps.is_some();
        let settings = match &spec.values {
            Some(_) if is_range => bail!("`values` excludes `from`, `to` and `steps`"),
            Some(values) => listed(values, spec.key.is_some(), &keys)?,
            None if is_range => {
                ensure!(
                    spec.key.is_some(),
                    "a range needs one `key`; with `keys` give `values`"
                );
                range(spec)?.into_iter().map(|value| vec![value]).collect()
            }
            None => bail!("give `values`, or `from`, `to` and `steps`"),
        };
        let count = settings.len();
        ensure!(
            (1..=MAX_VALUES).contains(&count),
            "{count} values: allowed are 1 to {MAX_VALUES}"
        );
        for (index, setting) in settings.iter().enumerate() {
            let same = settings[..index].contains(setting);
            ensure!(!same, "the value {} is there twice", words(setting));
        }
        if let Some(names) = &spec.names {
            check_names(names, spec.values.is_some(), count)?;
        }
        if let Some(label) = &spec.label {
            ensure!(
                is_word(label),
                "`label` must be a word without commas, equals signs and line ends, but is '{label}'"
            );
            ensure!(
                keys.len() == 1 || spec.names.is_some(),
                "`label` of several keys needs `names`, the values of what it names"
            );
        }
        let (names, label) = (spec.names.clone(), spec.label.clone());
        Ok(Self {
            keys,
            settings,
            names,
            label,
            spacing: spec.spacing.unwrap_or_default(),
        })
    }

    /// The entry that gives these keys and values.
    pub fn spec(&self) -> VarySpec {
        let spacing = (self.spacing != ValueSpacing::default()).then_some(self.spacing);
        let (names, label) = (self.names.clone(), self.label.clone());
        if let [key] = self.keys.as_slice() {
            let values = self
                .settings
                .iter()
                .filter_map(|setting| setting.first().cloned());
            let (key, values) = (Some(key.clone()), Some(values.collect()));
            return VarySpec {
                key,
                values,
                names,
                label,
                spacing,
                ..VarySpec::default()
            };
        }
        let values = self
            .settings
            .iter()
            .map(|setting| Value::Array(setting.clone()))
            .collect();
        let keys = Some(self.keys.clone());
        VarySpec {
            keys,
            values: Some(values),
            names,
            label,
            spacing,
            ..VarySpec::default()
        }
    }

    /// A setting in words, such as `gas.0.area_fraction = 0.1`, or `molecule.0 = tee` of a setting
    /// with a name.
    pub fn words(&self, setting: usize) -> String {
        if let Some(name) = self.names.as_ref().and_then(|names| names.get(setting)) {
            return format!("{} = {name}", self.name());
        }
        if let Some(label) = &self.label {
            return format!("{label} = {}", words(&self.settings[setting]));
        }
        let words = self.keys.iter().zip(&self.settings[setting]);
        words
            .map(|(key, value)| format!("{key} = {value}"))
            .collect::<Vec<_>>()
            .join(", ")
    }

    /// The columns of a table: the label, or the path of each key, or the common path if the
    /// settings have names.
    pub fn columns(&self) -> Vec<String> {
        if self.names.is_some() || self.label.is_some() {
            vec![self.name()]
        } else {
            self.keys.clone()
        }
    }

    /// The values of the quantity with a label, if its names are numbers.
    pub fn values_of_names(&self) -> Option<Vec<f64>> {
        let number = |name: &String| {
            name.trim()
                .parse()
                .ok()
                .filter(|number: &f64| number.is_finite())
        };
        self.names
            .iter()
            .filter(|_| self.label.is_some())
            .flatten()
            .map(number)
            .collect::<Option<Vec<_>>>()
            .filter(|values| !values.is_empty())
    }

    /// A setting as the cells of a table.
    pub fn cells(&self, setting: usize) -> Vec<String> {
        match &self.names {
            Some(names) => vec![names[setting].clone()],
            None => self.settings[setting].iter().map(plain).collect(),
        }
    }

    /// The label, or the common path of the keys.
    fn name(&self) -> String {
        self.label.clone().unwrap_or_else(|| self.common_path())
    }

    /// The parts with which the paths of all keys begin; without such parts the first key.
    fn common_path(&self) -> String {
        let first = &self.keys[0];
        let is_common = |&end: &usize| {
            let path = &first[..end];
            self.keys.iter().all(|key| {
                key == path
                    || key
                        .strip_prefix(path)
                        .is_some_and(|rest| rest.starts_with('.'))
            })
        };
        let mut ends = first
            .match_indices('.')
            .map(|(end, _)| end)
            .chain([first.len()]);
        let longest = ends.rfind(is_common).unwrap_or(first.len());
        first[..longest].to_owned()
    }
}

/// A value as a cell: text without quotes.
fn plain(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

fn words(setting: &[Value]) -> String {
    setting
        .iter()
        .map(ToString::to_string)
        .collect::<Vec<_>>()
        .join(", ")
}

/// Whether a text can stand in a list of settings.
fn is_word(text: &str) -> bool {
    !text.trim().is_empty() && !text.contains([',', '=', '\n'])
}

fn check_names(names: &[String], has_values: bool, count: usize) -> Result<()> {
    ensure!(
        has_values,
        "`names` needs `values`; the values of a range are its names"
    );
    ensure!(
        names.len() == count,
        "`names` must have a name for each of the {count} values, but has {}",
        names.len()
    );
    for (index, name) in names.iter().enumerate() {
        ensure!(
            is_word(name),
            "`names` must be words without commas, equals signs and line ends, but one is '{name}'"
        );
        ensure!(
            !names[..index].contains(name),
            "the name {name} is there twice"
        );
    }
    Ok(())
}

fn listed(values: &[Value], is_one_key: bool, keys: &[String]) -> Result<Vec<Vec<Value>>> {
    if is_one_key {
        return Ok(values.iter().map(|value| vec![value.clone()]).collect());
    }
    let setting = |value: &Value| match value {
        Value::Array(list) if list.len() == keys.len() => Ok(list.clone()),
        other => bail!(
            "each of `values` must be a list with a value for each of the {} keys, but one is {other}",
            keys.len()
        ),
    };
    values.iter().map(setting).collect()
}

fn range(spec: &VarySpec) -> Result<Vec<Value>> {
    let number = |key: &str, value: &Option<Value>| -> Result<(f64, bool)> {
        let found = match value {
            Some(Value::Integer(whole)) => (*whole as f64, true),
            Some(Value::Float(number)) => (*number, false),
            Some(other) => bail!("`{key}` must be a number, but is {other}"),
            None => bail!("`{key}` is missing: a range has `from`, `to` and `steps`"),
        };
        ensure!(
            found.0.is_finite(),
            "`{key}` must be finite, but is {}",
            found.0
        );
        Ok(found)
    };
    let ((from, is_whole), (to, ends_whole)) =
        (number("from", &spec.from)?, number("to", &spec.to)?);
    let steps = spec
        .steps
        .context("`steps` is missing: the number of values of the range")?;
    ensure!(
        (2..=MAX_VALUES).contains(&steps),
        "`steps` must be from 2 to {MAX_VALUES}, but is {steps}"
    );
    let is_logarithmic = spec.spacing == Some(ValueSpacing::Logarithmic);
    ensure!(
        !is_logarithmic || (from > 0.0 && to > 0.0),
        "a logarithmic range needs positive ends, but has {from} and {to}"
    );
    let value = |index: usize| {
        let share = index as f64 / (steps - 1) as f64;
        let value = if is_logarithmic {
            // The powers of libm have the same bits on every machine.
            from * libm::pow(to / from, share)
        } else {
            from + (to - from) * share
        };
        rounded(value)
    };
    let values: Vec<f64> = (0..steps).map(value).collect();
    let all_whole = is_whole && ends_whole && values.iter().all(|value| value.fract() == 0.0);
    let value = |&value: &f64| {
        if all_whole {
            Value::Integer(value as i64)
        } else {
            Value::Float(value)
        }
    };
    Ok(values.iter().map(value).collect())
}

/// The number nearest to `value` with [`DIGITS`] digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.*e}", DIGITS - 1).parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vary(text: &str) -> Result<Vary> {
        Vary::new(&toml::from_str(text).unwrap())
    }

    fn numbers(text: &str) -> Vec<Value> {
        vary(text).unwrap().settings.into_iter().flatten().collect()
    }

    #[test]
    fn ranges_have_their_ends_and_the_numbers_that_a_person_would_write() {
        let tenths = numbers("key = \"x\"\nfrom = 0.1\nto = 0.5\nsteps = 5");
        assert_eq!(tenths, [0.1, 0.2, 0.3, 0.4, 0.5].map(Value::Float));
        let decades =
            numbers("key = \"x\"\nfrom = 10\nto = 1000\nsteps = 3\nspacing = \"logarithmic\"");
        assert_eq!(decades, [10, 100, 1000].map(Value::Integer));
        let down =
            numbers("key = \"x\"\nfrom = 1e-3\nto = 1e-5\nsteps = 3\nspacing = \"logarithmic\"");
        assert_eq!(down, [1e-3, 1e-4, 1e-5].map(Value::Float));
        assert_eq!(
            numbers("key = \"x\"\nfrom = 1\nto = 2\nsteps = 3")[1],
            Value::Float(1.5)
        );
    }

    #[test]
    fn zipped_keys_change_together_and_an_entry_can_be_written_again() {
        let zipped = vary("keys = [\"a\", \"b.0.c\"]\nvalues = [[1, \"x\"], [2, \"y\"]]").unwrap();
        assert_eq!(
            zipped.settings[1],
            [Value::Integer(2), Value::String("y".to_owned())]
        );
        assert_eq!(Vary::new(&zipped.spec()).unwrap(), zipped);
        let one = vary("key = \"box.sides\"\nvalues = [[1, 1], [2, 1]]").unwrap();
        assert_eq!(one.settings.len(), 2);
        assert_eq!(Vary::new(&one.spec()).unwrap(), one);
    }

    #[test]
    fn named_settings_are_called_by_their_names() {
        let text = "keys = [\"gas.0.shape\", \"gas.0.atom_mass\"]\nvalues = [[\"tee\", 0.2], [\"disc\", 1.0]]\n";
        let plain = vary(text).unwrap();
        assert_eq!(
            plain.words(0),
            "gas.0.shape = \"tee\", gas.0.atom_mass = 0.2"
        );
        assert_eq!(
            (plain.columns().len(), plain.cells(1)),
            (2, vec!["disc".to_owned(), "1.0".to_owned()])
        );
        let named = vary(&format!("{text}names = [\"five discs\", \"one\"]")).unwrap();
        assert_eq!(
            (named.words(0), named.columns()),
            ("gas.0 = five discs".to_owned(), vec!["gas.0".to_owned()])
        );
        assert_eq!(named.cells(1), ["one"]);
        assert_eq!(Vary::new(&named.spec()).unwrap(), named);
        // Other paths have the first key as their name.
        let apart =
            "keys = [\"gas.0.mass\", \"box.sides\"]\nvalues = [[1, [1, 1]]]\nnames = [\"a\"]";
        assert_eq!(vary(apart).unwrap().words(0), "gas.0.mass = a");
    }

    #[test]
    fn a_label_stands_for_the_keys() {
        let text = "keys = [\"molecule.0.at\", \"molecule.1.at\"]\nvalues = [[[0, 0], [5, 0]], [[0, 0], [6, 0]]]\n";
        let gap = vary(&format!("{text}names = [\"0\", \"0.5\"]\nlabel = \"gap\"")).unwrap();
        assert_eq!(
            (gap.words(1), gap.columns()),
            ("gap = 0.5".to_owned(), vec!["gap".to_owned()])
        );
        assert_eq!(gap.values_of_names(), Some(vec![0.0, 0.5]));
        assert_eq!(Vary::new(&gap.spec()).unwrap(), gap);
        let one =
            vary("key = \"gas.0.count\"\nfrom = 1\nto = 2\nsteps = 2\nlabel = \"discs\"").unwrap();
        assert_eq!(
            (one.words(1), one.columns()),
            ("discs = 2".to_owned(), vec!["discs".to_owned()])
        );
        assert_eq!(
            (one.values_of_names(), one.cells(0)),
            (None, vec!["1".to_owned()])
        );
        let words = vary(&format!(
            "{text}names = [\"near\", \"far\"]\nlabel = \"gap\""
        ))
        .unwrap();
        assert_eq!(words.values_of_names(), None);
    }

    #[test]
    fn contradictory_entries_are_refused() {
        for (text, expected) in [
            (
                "key = \"a\"\nvalues = [1]\nlabel = \"x = 1\"",
                "`label` must be a word",
            ),
            (
                "keys = [\"a\", \"b\"]\nvalues = [[1, 2]]\nlabel = \"x\"",
                "needs `names`",
            ),
            ("values = [1]", "`key` is missing"),
            (
                "key = \"a\"\nkeys = [\"b\"]\nvalues = [1]",
                "exclude each other",
            ),
            ("keys = []\nvalues = [[]]", "empty"),
            ("key = \"a\"", "give `values`"),
            ("key = \"a\"\nvalues = []", "0 values"),
            (
                "key = \"a\"\nvalues = [1, 2, 1]",
                "the value 1 is there twice",
            ),
            ("key = \"a\"\nvalues = [1]\nsteps = 2", "excludes"),
            ("key = \"a\"\nfrom = 1\nsteps = 2", "`to` is missing"),
            (
                "key = \"a\"\nfrom = 1\nto = \"b\"\nsteps = 2",
                "must be a number",
            ),
            ("key = \"a\"\nfrom = 1\nto = 2", "`steps` is missing"),
            (
                "key = \"a\"\nfrom = 1\nto = 2\nsteps = 1",
                "from 2 to 100000, but is 1",
            ),
            (
                "key = \"a\"\nfrom = 0\nto = 2\nsteps = 3\nspacing = \"logarithmic\"",
                "positive ends",
            ),
            (
                "keys = [\"a\", \"b\"]\nvalues = [[1, 2], [3]]",
                "each of the 2 keys",
            ),
            (
                "keys = [\"a\", \"b\"]\nfrom = 1\nto = 2\nsteps = 2",
                "one `key`",
            ),
            (
                "key = \"a\"\nfrom = 1\nto = 2\nsteps = 2\nnames = [\"x\", \"y\"]",
                "needs `values`",
            ),
            (
                "key = \"a\"\nvalues = [1, 2]\nnames = [\"x\"]",
                "each of the 2 values, but has 1",
            ),
            (
                "key = \"a\"\nvalues = [1, 2]\nnames = [\"x\", \"x\"]",
                "x is there twice",
            ),
            (
                "key = \"a\"\nvalues = [1]\nnames = [\"x = 1\"]",
                "words without",
            ),
        ] {
            let error = vary(text).unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
