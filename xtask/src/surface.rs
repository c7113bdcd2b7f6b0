//! `cargo xtask surface`: the public items of the crates whose surface is kept, compared with the
//! list that is committed, so that a change of surface is seen in a diff. The list has the names,
//! not the types; fields without a name are not in it.
//!
//! The items come from the JSON of rustdoc, which the stable compiler writes on request
//! (`RUSTC_BOOTSTRAP`). Items marked `#[doc(hidden)]` are not in it.

use std::{
    collections::{BTreeSet, HashSet},
    fs,
    path::Path,
    process::Command,
};

use anyhow::{Context, Result, ensure};
use carom_runs::print_line;
use carom_tables::Verdict;
use clap::Args;
use serde_json::Value;

use crate::repository;

/// The crates of the stable tier: the facade and the six layers.
const STABLE: [&str; 7] = [
    "carom",
    "carom-geometry",
    "carom-kinematics",
    "carom-detection",
    "carom-response",
    "carom-engine",
    "carom-observers",
];

/// The list of their items, in the root of the repository.
const LIST: &str = "crates/surface.txt";

/// Most changed items that are printed.
const MAX_PRINTED: usize = 40;

/// Options of `cargo xtask surface`.
#[derive(Debug, Clone, Args)]
pub struct SurfaceOptions {
    /// Write the list anew
    #[arg(long)]
    pub write: bool,
}

/// Compares the public items with the committed list, or writes it.
///
/// # Errors
/// A crate cannot be documented, or the list cannot be read or written.
pub fn run(options: &SurfaceOptions) -> Result<Verdict> {
    let root = repository::root()?;
    let mut found = BTreeSet::new();
    for name in STABLE {
        let document = document(root, name)?;
        let items = Items::new(&document, name)?.list();
        print_line(&format!("{name}: {} items", items.len()));
        found.extend(items);
    }
    let path = root.join(LIST);
    if options.write {
        let lines: Vec<String> = found.into_iter().collect();
        fs::write(&path, lines.join("\n") + "\n")
            .with_context(|| format!("cannot write {LIST}"))?;
        return Ok(Verdict::Passed);
    }
    let text = fs::read_to_string(&path).with_context(|| format!("cannot read {LIST}"))?;
    let listed: BTreeSet<String> = text.lines().map(str::to_owned).collect();
    let gone = listed.difference(&found).map(|item| format!("- {item}"));
    let new = found.difference(&listed).map(|item| format!("+ {item}"));
    let changes: Vec<String> = gone.chain(new).collect();
    for change in changes.iter().take(MAX_PRINTED) {
        print_line(change);
    }
    if changes.is_empty() {
        print_line(&format!("surface: {} items, as listed", found.len()));
        return Ok(Verdict::Passed);
    }
    print_line(&format!(
        "surface: {} changes; if they are meant, run `cargo xtask surface --write` and commit {LIST}",
        changes.len()
    ));
    Ok(Verdict::Failed)
}

/// The JSON of rustdoc for the library of a package.
fn document(root: &Path, package: &str) -> Result<Value> {
    let status = Command::new(env!("CARGO"))
        .current_dir(root)
        .env("RUSTC_BOOTSTRAP", "1")
        .args(["rustdoc", "--quiet", "--lib", "--package", package, "--"])
        .args([
            "-Z",
            "unstable-options",
            "--output-format",
            "json",
            "--cap-lints",
            "allow",
        ])
        .status()
        .context("cannot start cargo")?;
    ensure!(status.success(), "rustdoc failed for {package}");
    let path = repository::target_folder()?
        .join("doc")
        .join(format!("{}.json", package.replace('-', "_")));
    let text =
        fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
    serde_json::from_str(&text).with_context(|| format!("{} is no JSON", path.display()))
}

/// The items of one crate.
struct Items<'a> {
    index: &'a Value,
    root: String,
    crate_name: String,
    found: BTreeSet<String>,
    /// Modules on the way, so that a module that contains itself ends the walk.
    seen: HashSet<String>,
}

impl<'a> Items<'a> {
    fn new(document: &'a Value, package: &str) -> Result<Self> {
        let root = document["root"]
            .as_u64()
            .context("the JSON of rustdoc has no root")?;
        Ok(Self {
            index: &document["index"],
            root: root.to_string(),
            crate_name: package.replace('-', "_"),
            found: BTreeSet::new(),
            seen: HashSet::new(),
        })
    }

    /// Every item with its path and kind.
    fn list(mut self) -> BTreeSet<String> {
        let (root, name) = (self.root.clone(), self.crate_name.clone());
        self.walk(&root, &name);
        self.found
    }

    /// The item with this number; `None` for one of another crate.
    fn item(&self, id: &str) -> Option<&'a Value> {
        self.index.get(id)
    }

    /// Lists what is inside a module, a type or a trait.
    fn walk(&mut self, id: &str, path: &str) {
        let Some(item) = self.item(id) else { return };
        let Some((kind, inner)) = item["inner"]
            .as_object()
            .and_then(|inner| inner.iter().next())
        else {
            return;
        };
        match kind.as_str() {
            "module" if self.seen.insert(path.to_owned()) => {
                self.add_all(&inner["items"], path);
            }
            "struct" => {
                self.add_all(&inner["kind"]["plain"]["fields"], path);
                self.add_methods(&inner["impls"], path);
            }
            "enum" => {
                self.add_all(&inner["variants"], path);
                self.add_methods(&inner["impls"], path);
            }
            "trait" => self.add_all(&inner["items"], path),
            _ => {}
        }
    }

    /// Lists items by their numbers.
    fn add_all(&mut self, ids: &Value, path: &str) {
        for id in ids
            .as_array()
            .into_iter()
            .flatten()
            .filter_map(Value::as_u64)
        {
            self.add(&id.to_string(), path);
        }
    }

    /// Lists an item below a path, and what is inside it.
    fn add(&mut self, id: &str, path: &str) {
        let Some(item) = self.item(id) else { return };
        // Variants and the items of traits have the visibility of their parents.
        if !["public", "default"].contains(&item["visibility"].as_str().unwrap_or_default()) {
            return;
        }
        let Some(kind) = item["inner"]
            .as_object()
            .and_then(|inner| inner.keys().next())
        else {
            return;
        };
        if kind == "use" {
            let target = &item["inner"]["use"];
            let name = target["name"].as_str().unwrap_or_default();
            let of_target = target["id"].as_u64().map(|id| id.to_string());
            let known = of_target.filter(|id| self.item(id).is_some());
            match known {
                Some(id) if target["is_glob"] == true => self.walk(&id, path),
                Some(id) => self.add_as(&id, &format!("{path}::{name}")),
                None => {
                    self.found.insert(format!("{path}::{name} use"));
                }
            }
            return;
        }
        if let Some(name) = item["name"].as_str() {
            self.add_as(id, &format!("{path}::{name}"));
        }
    }

    fn add_as(&mut self, id: &str, path: &str) {
        let Some(item) = self.item(id) else { return };
        let kind = item["inner"]
            .as_object()
            .and_then(|inner| inner.keys().next());
        self.found
            .insert(format!("{path} {}", kind.map_or("item", String::as_str)));
        self.walk(id, path);
    }

    /// Lists the public methods of a type, without those of traits.
    fn add_methods(&mut self, impls: &Value, path: &str) {
        for id in impls
            .as_array()
            .into_iter()
            .flatten()
            .filter_map(Value::as_u64)
        {
            let Some(item) = self.item(&id.to_string()) else {
                continue;
            };
            let inner = &item["inner"]["impl"];
            if inner["trait"].is_null() {
                self.add_all(&inner["items"], path);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn items_are_found_through_names_of_the_root_and_private_ones_are_not() {
        let item = |name: &str, visibility: &str, inner: Value| json!({ "name": name, "visibility": visibility, "inner": inner });
        let document = json!({
            "root": 0,
            "index": {
                "0": item("a", "public", json!({ "module": { "items": [1, 2] } })),
                "1": item("hidden", "crate", json!({ "module": { "items": [3] } })),
                "2": { "name": null, "visibility": "public",
                       "inner": { "use": { "name": "Body", "id": 3, "is_glob": false } } },
                "3": item("Body", "public", json!({ "struct": {
                    "kind": { "plain": { "fields": [4, 5] } }, "impls": [6, 7] } })),
                "4": item("mass", "public", json!({ "struct_field": {} })),
                "5": item("secret", "crate", json!({ "struct_field": {} })),
                "6": item("", "default", json!({ "impl": { "trait": null, "items": [8] } })),
                "7": item("", "default", json!({ "impl": { "trait": {}, "items": [9] } })),
                "8": item("key", "public", json!({ "function": {} })),
                "9": item("fmt", "default", json!({ "function": {} })),
            }
        });
        let list: Vec<String> = Items::new(&document, "a")
            .unwrap()
            .list()
            .into_iter()
            .collect();
        assert_eq!(
            list,
            [
                "a::Body struct",
                "a::Body::key function",
                "a::Body::mass struct_field"
            ]
        );
    }
}
