//! Changes of entries of a scene file by their paths: `--set key.path=value`, and studies.

use std::str::FromStr;

use anyhow::{Context, Result, bail, ensure};
use toml::{Table, Value};

/// Renamed keys: table, old name (still read), and new name.
pub const RENAMED: [(&str, &str, &str); 1] = [("run", "standby", "sample_interval")];

/// A change of one entry: its path and its new value.
#[derive(Debug, Clone, PartialEq)]
pub struct Override {
    path: Vec<String>,
    value: Value,
}

impl FromStr for Override {
    type Err = anyhow::Error;

    /// Parses `key.path=value`. Entries of lists are numbers from 0: `gas.0.count=100`. A value
    /// that is not TOML becomes a string: `run.snapshots=extxyz`.
    fn from_str(text: &str) -> Result<Self> {
        let (path, value) = text
            .split_once('=')
            .with_context(|| format!("'{text}' is not of the form key.path=value"))?;
        let value = value.trim();
        let parsed = match format!("value = {value}").parse::<Table>() {
            Ok(mut table) if table.len() == 1 => table.remove("value"),
            _ => None,
        };
        Self::new(
            path,
            parsed.unwrap_or_else(|| Value::String(value.to_owned())),
        )
    }
}

impl Override {
    /// The change of the entry with this path, such as `gas.0.count`.
    ///
    /// # Errors
    /// The path has an empty key.
    pub fn new(path: &str, value: Value) -> Result<Self> {
        let keys: Vec<String> = path
            .trim()
            .split('.')
            .map(|key| key.trim().to_owned())
            .collect();
        ensure!(
            keys.iter().all(|key| !key.is_empty()),
            "'{path}' has an empty key in its path"
        );
        Ok(Self { path: keys, value })
    }

    /// Changes the entry in a scene and creates missing tables.
    ///
    /// # Errors
    /// The path leads through a value that is neither a table nor a list, or beyond the end of a
    /// list.
    pub fn apply(&self, scene: &mut Table) -> Result<()> {
        let mut path = self.path.clone();
        for (table, old, new) in RENAMED {
            if path == [table, old] {
                new.clone_into(&mut path[1]);
            }
            if let Some(Value::Table(entries)) = scene.get_mut(table)
                && let Some(value) = entries.remove(old)
            {
                ensure!(
                    !entries.contains_key(new),
                    "`{table}.{new}` is given twice, once as `{table}.{old}`"
                );
                entries.insert(new.to_owned(), value);
            }
        }
        let mut walked = String::new();
        let Some((last, above)) = path.split_last() else {
            bail!("an empty path")
        };
        let mut place = Place::Table(scene);
        for key in above {
            place = place.enter(key, &walked)?;
            if !walked.is_empty() {
                walked.push('.');
            }
            walked.push_str(key);
        }
        place.put(last, &walked, self.value.clone())
    }
}

/// A position in a scene file.
enum Place<'a> {
    Table(&'a mut Table),
    List(&'a mut Vec<Value>),
}

impl Place<'_> {
    fn enter(self, key: &str, walked: &str) -> Result<Self> {
        let value = match self {
            Self::Table(table) => table
                .entry(key)
                .or_insert_with(|| Value::Table(Table::new())),
            Self::List(list) => entry(list, key, walked)?,
        };
        match value {
            Value::Table(table) => Ok(Self::Table(table)),
            Value::Array(list) => Ok(Self::List(list)),
            other => bail!(
                "`{walked}.{key}` is a {}, which has no entries",
                other.type_str()
            ),
        }
    }

    fn put(self, key: &str, walked: &str, value: Value) -> Result<()> {
        match self {
            Self::Table(table) => {
                table.insert(key.to_owned(), value);
            }
            Self::List(list) => *entry(list, key, walked)? = value,
        }
        Ok(())
    }
}

fn entry<'a>(list: &'a mut [Value], key: &str, walked: &str) -> Result<&'a mut Value> {
    let count = list.len();
    let index: Option<usize> = key.parse().ok();
    let index = index.with_context(|| {
        format!(
            "`{walked}` is a list, whose entries are numbers from 0, not `{key}`; write `{walked}.0.{key}`"
        )
    })?;
    list.get_mut(index)
        .with_context(|| format!("`{walked}` has {count} entries; {index} is out of range"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changed(text: &str, set: &str) -> Result<String> {
        let mut scene: Table = text.parse().unwrap();
        set.parse::<Override>()?.apply(&mut scene)?;
        Ok(toml::to_string(&scene).unwrap())
    }

    #[test]
    fn entries_of_lists_and_tables_are_changed_or_made() {
        let scene = "[[gas]]\ncount = 3\n[[gas]]\ncount = 4\n";
        assert!(
            changed(scene, "gas.1.count=100")
                .unwrap()
                .contains("count = 100")
        );
        assert_eq!(
            changed("", "run.until = 2.5").unwrap(),
            "[run]\nuntil = 2.5\n"
        );
        assert_eq!(
            changed("", "run.snapshots=extxyz").unwrap(),
            "[run]\nsnapshots = \"extxyz\"\n"
        );
        assert_eq!(
            changed("", "box.sides=[2, 1.0]").unwrap(),
            "[box]\nsides = [2, 1.0]\n"
        );
        for set in ["run.sample_interval=2", "run.standby=2"] {
            assert_eq!(
                changed("[run]\nstandby = 1\n", set).unwrap(),
                "[run]\nsample_interval = 2\n"
            );
        }
        assert_eq!(changed("", "box.seed=7").unwrap(), "[box]\nseed = 7\n");
    }

    #[test]
    fn paths_that_lead_nowhere_are_refused_by_name() {
        let scene = "[[gas]]\ncount = 3\n";
        for (set, expected) in [
            ("gas.1.count=1", "1 entries"),
            ("gas.first.count=1", "`first`"),
            ("gas.0.count.x=1", "integer"),
            ("gas", "key.path=value"),
            ("gas..count=1", "empty key"),
        ] {
            let error = changed(scene, set).unwrap_err().to_string();
            assert!(error.contains(expected), "{set}: {error}");
        }
    }
}
