//! Checks that files of a crate import each other in one direction, and so do its rooms: the
//! modules of its root with all that is in them. Only a module and its children may form a cycle.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

use anyhow::Result;

use super::{Fault, files::with_extensions, read};

/// Arrows between rooms that run back up: folder, importing room, imported room. Reading a scene
/// needs the area of its molecules where it sets the box, and errors name bodies.
const BACK_UP: [(&str, &str, &str); 2] = [
    ("crates/engine/src", "scene", "start"),
    ("crates/engine/src", "scene", "world"),
];

/// Cycles of files and of rooms, one fault each.
pub fn faults(root: &Path) -> Result<Vec<Fault>> {
    let mut faults = Vec::new();
    let mut folders: Vec<String> = super::crates(root)?
        .iter()
        .map(|name| format!("crates/{name}/src"))
        .collect();
    folders.push("xtask/src".to_owned());
    for folder in folders {
        let mut sources = BTreeMap::new();
        for path in with_extensions(&root.join(&folder), &["rs"])? {
            let name = path
                .strip_prefix(root.join(&folder))
                .unwrap_or(&path)
                .display()
                .to_string();
            sources.insert(name, without_tests(&read(&path)?));
        }
        for cycle in cycles(&sources) {
            let files: Vec<String> = cycle
                .iter()
                .map(|file| format!("{folder}/{file}"))
                .collect();
            faults.push(format!(
                "files that import each other: {}",
                files.join(", ")
            ));
        }
        let of_crate = BACK_UP.iter().filter(|(place, ..)| *place == folder);
        let allowed: Vec<(&str, &str)> = of_crate.map(|&(_, from, to)| (from, to)).collect();
        for circle in circles_of_rooms(&sources, &allowed) {
            faults.push(format!(
                "{folder}: rooms that import each other: {}",
                circle.join(", ")
            ));
        }
    }
    Ok(faults)
}

/// The source before its unit tests, which may import anything.
fn without_tests(source: &str) -> String {
    let tests = [
        "#[cfg(test)]\nmod tests {",
        "#[cfg(test)]\npub(crate) mod tests {",
    ];
    let end = tests.iter().filter_map(|start| source.find(start)).min();
    source[..end.unwrap_or(source.len())].to_owned()
}

/// The module path of a file: `a/b.rs` and `a/b/mod.rs` are both `["a", "b"]`.
fn module(file: &str) -> Vec<String> {
    let path = file.trim_end_matches(".rs");
    let path = path.strip_suffix("/mod").unwrap_or(path);
    if matches!(path, "lib" | "main" | "mod") {
        Vec::new()
    } else {
        path.split('/').map(str::to_owned).collect()
    }
}

/// Groups of files that import each other, directly or indirectly, except parents and their
/// descendants.
fn cycles(sources: &BTreeMap<String, String>) -> Vec<Vec<String>> {
    circles(&imports(sources))
}

/// Groups of rooms, which are the modules of the root with all that is in them, that import each
/// other. The arrows in `allowed` do not count.
fn circles_of_rooms(
    sources: &BTreeMap<String, String>,
    allowed: &[(&str, &str)],
) -> Vec<Vec<String>> {
    let room = |file: &String| module(file).first().cloned();
    let mut arrows: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (file, targets) in imports(sources) {
        let Some(own) = room(&file) else { continue };
        // Tests may import anything.
        if module(&file).iter().any(|part| part == "tests") {
            continue;
        }
        let others = arrows.entry(own.clone()).or_default();
        for other in targets.iter().filter_map(room) {
            if other != own && !allowed.contains(&(own.as_str(), other.as_str())) {
                others.insert(other);
            }
        }
    }
    circles(&arrows)
}

/// The files that each file imports, without its parents and descendants.
fn imports(sources: &BTreeMap<String, String>) -> BTreeMap<String, BTreeSet<String>> {
    let modules: BTreeMap<Vec<String>, &String> =
        sources.keys().map(|file| (module(file), file)).collect();
    let exported = sources
        .get("lib.rs")
        .map(|root| exported(root))
        .unwrap_or_default();
    let mut imports: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (file, source) in sources {
        let own = module(file);
        let targets = imported(source, &own).into_iter().filter_map(|mut path| {
            if let Some(home) = path.first().and_then(|name| exported.get(name)) {
                path.clone_from(home);
            }
            // The longest prefix of the path that is a module; the rest are items in it.
            while !modules.contains_key(&path) {
                path.pop()?;
            }
            (path != own && !is_kin(&path, &own)).then(|| modules[&path].clone())
        });
        imports.insert(file.clone(), targets.collect());
    }
    imports
}

/// Groups of nodes of a graph that can reach each other.
fn circles(arrows: &BTreeMap<String, BTreeSet<String>>) -> Vec<Vec<String>> {
    let reach: BTreeMap<&String, BTreeSet<&String>> = arrows
        .keys()
        .map(|node| (node, reachable(node, arrows)))
        .collect();
    let mut found: BTreeSet<Vec<String>> = BTreeSet::new();
    for (&node, reached) in &reach {
        let is_reached_back =
            |other: &&&String| reach.get(*other).is_some_and(|back| back.contains(node));
        let group: BTreeSet<&&String> = reached.iter().filter(is_reached_back).collect();
        if group.len() > 1 {
            found.insert(group.into_iter().map(|name| (*name).clone()).collect());
        }
    }
    found.into_iter().collect()
}

/// Module of each name that the root re-exports.
fn exported(root: &str) -> BTreeMap<String, Vec<String>> {
    let mut found = BTreeMap::new();
    for (start, _) in root.match_indices("pub use ") {
        let Some(end) = root[start..].find(';') else {
            continue;
        };
        for path in expand(root[start + 8..start + end].trim()) {
            let parts: Vec<String> = path
                .split("::")
                .map(|part| part.trim().to_owned())
                .collect();
            if let Some((name, home)) = parts.split_last()
                && !home.is_empty()
            {
                found.insert(name.clone(), home.to_vec());
            }
        }
    }
    found
}

/// Returns true if one module lies inside the other.
fn is_kin(a: &[String], b: &[String]) -> bool {
    a.starts_with(b) || b.starts_with(a)
}

fn reachable<'a>(
    node: &'a String,
    arrows: &'a BTreeMap<String, BTreeSet<String>>,
) -> BTreeSet<&'a String> {
    let mut found = BTreeSet::new();
    let mut open = vec![node];
    while let Some(next) = open.pop() {
        for other in arrows.get(next).into_iter().flatten() {
            if found.insert(other) {
                open.push(other);
            }
        }
    }
    found
}

/// Paths of the imports of a source from its own crate, from the root of the crate.
fn imported(source: &str, own: &[String]) -> Vec<Vec<String>> {
    let code: String = source
        .lines()
        .flat_map(|line| [line.split("//").next().unwrap_or(line), "\n"])
        .collect();
    let mut found = Vec::new();
    for (start, _) in code.match_indices("use ") {
        let is_word = code[..start]
            .chars()
            .next_back()
            .is_none_or(char::is_whitespace);
        if let (true, Some(end)) = (is_word, code[start..].find(';')) {
            for path in expand(code[start + 4..start + end].trim()) {
                found.extend(from_root(&path, own));
            }
        }
    }
    // Paths in the code: `crate::a::b(…)`, `super::a::b(…)`.
    for root in ["crate::", "super::", "self::"] {
        for (start, _) in code.match_indices(root) {
            let is_start = code[..start]
                .chars()
                .next_back()
                .is_none_or(|c| !c.is_alphanumeric() && c != ':');
            let path: String = code[start..]
                .chars()
                .take_while(|c| c.is_alphanumeric() || matches!(c, '_' | ':'))
                .collect();
            if is_start {
                found.extend(from_root(path.trim_end_matches(':'), own));
            }
        }
    }
    found
}

/// All paths of `a::{b, c::{d}}`, without renames.
fn expand(tree: &str) -> Vec<String> {
    let tree = tree.trim();
    let Some(open) = tree.find('{') else {
        return vec![tree.split(" as ").next().unwrap_or(tree).to_owned()];
    };
    let inner = tree[open + 1..].trim_end().trim_end_matches('}');
    let (mut depth, mut begun, mut parts) = (0, 0, Vec::new());
    for (index, character) in inner.char_indices() {
        match character {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&inner[begun..index]);
                begun = index + 1;
            }
            _ => {}
        }
    }
    parts.push(&inner[begun..]);
    let prefix = &tree[..open];
    let parts = parts
        .into_iter()
        .map(str::trim)
        .filter(|part| !part.is_empty());
    parts
        .flat_map(|part| {
            expand(part)
                .into_iter()
                .map(|path| format!("{prefix}{path}"))
                .collect::<Vec<_>>()
        })
        .collect()
}

/// A path from the root of the crate; `None` for another crate.
fn from_root(path: &str, own: &[String]) -> Option<Vec<String>> {
    let mut parts = path
        .split("::")
        .map(str::trim)
        .map(str::to_owned)
        .peekable();
    let mut root = match parts.peek()?.as_str() {
        "crate" => Vec::new(),
        "self" | "super" => own.to_vec(),
        _ => return None,
    };
    while let Some(part) = parts.next_if(|part| matches!(part.as_str(), "crate" | "self" | "super"))
    {
        if part == "super" {
            root.pop()?;
        }
    }
    root.extend(parts.filter(|part| part != "self" && part != "*"));
    Some(root)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sources(files: &[(&str, &str)]) -> BTreeMap<String, String> {
        files
            .iter()
            .map(|&(name, text)| (name.to_owned(), text.to_owned()))
            .collect()
    }

    #[test]
    fn a_cycle_through_any_form_of_import_is_found() {
        let files = sources(&[
            ("lib.rs", "mod a; mod b; mod c;\nuse crate::{a::A, c};"),
            ("a.rs", "use crate::{\n    b::{self, B},\n};"),
            ("b/mod.rs", "mod inner;\nfn f() { crate::c::g() }"),
            ("b/inner.rs", "use super::B;"),
            ("c.rs", "#[cfg(test)]\nmod tests;\nfn g() { super::a::h() }"),
        ]);
        assert_eq!(cycles(&files), [["a.rs", "b/mod.rs", "c.rs"]]);
    }

    #[test]
    fn neither_a_module_with_its_children_nor_a_chain_is_a_cycle() {
        let files = sources(&[
            ("lib.rs", "mod a; mod b;"),
            ("a/mod.rs", "mod x; use self::x::X; use crate::b::B;"),
            ("a/x.rs", "use super::Y; use crate::b::B;"),
            ("b.rs", "use std::fmt; // crate::a"),
        ]);
        assert!(cycles(&files).is_empty(), "{:?}", cycles(&files));
    }

    #[test]
    fn a_cycle_through_the_names_of_the_root_is_found() {
        let files = sources(&[
            ("lib.rs", "mod a; mod b;\npub use a::A;\npub use b::{B, C};"),
            ("a.rs", "use crate::C;"),
            ("b.rs", "use crate::A;"),
        ]);
        assert_eq!(cycles(&files), [["a.rs", "b.rs"]]);
    }

    #[test]
    fn a_circle_through_a_parent_is_found_unless_its_arrow_is_allowed() {
        let files = sources(&[
            ("lib.rs", "mod cli; mod tidy;"),
            ("cli.rs", "use crate::tidy;"),
            ("tidy/mod.rs", "mod commands; use commands::faults;"),
            ("tidy/commands.rs", "use crate::cli::Cli;"),
        ]);
        assert!(cycles(&files).is_empty());
        assert_eq!(circles_of_rooms(&files, &[]), [["cli", "tidy"]]);
        assert!(circles_of_rooms(&files, &[("tidy", "cli")]).is_empty());
    }

    #[test]
    fn trees_of_imports_are_expanded() {
        assert_eq!(
            expand("a::{b, c::{d as e, f}, g}"),
            ["a::b", "a::c::d", "a::c::f", "a::g"]
        );
    }
}
