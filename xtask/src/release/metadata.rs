//! The packages of the workspace and all their dependencies, as `cargo metadata` lists them.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::PathBuf,
};

use anyhow::{Context, Result, bail};
use serde::Deserialize;

use crate::repository::Shell;

/// What `cargo metadata` writes, as far as a release needs it.
#[derive(Debug, Deserialize)]
pub struct Metadata {
    packages: Vec<Package>,
    workspace_members: Vec<String>,
    resolve: Resolve,
    /// The folder of what cargo builds.
    pub target_directory: PathBuf,
}

/// A package.
#[derive(Debug, Clone, Deserialize)]
pub struct Package {
    id: String,
    /// Its name.
    pub name: String,
    /// Its version.
    pub version: String,
    /// Its licences (SPDX).
    pub license: Option<String>,
    /// Address of its sources.
    pub repository: Option<String>,
    /// Its manifest.
    pub manifest_path: PathBuf,
    /// Registries to which it may be published; empty: none.
    publish: Option<Vec<String>>,
    dependencies: Vec<Dependency>,
}

#[derive(Debug, Clone, Deserialize)]
struct Dependency {
    name: String,
    kind: Option<String>,
    /// The folder of a package of the workspace.
    path: Option<PathBuf>,
}

#[derive(Debug, Deserialize)]
struct Resolve {
    nodes: Vec<Node>,
}

#[derive(Debug, Deserialize)]
struct Node {
    id: String,
    deps: Vec<NodeDependency>,
}

#[derive(Debug, Deserialize)]
struct NodeDependency {
    pkg: String,
    dep_kinds: Vec<DependencyKind>,
}

#[derive(Debug, Deserialize)]
struct DependencyKind {
    kind: Option<String>,
}

impl Metadata {
    /// Reads the packages that are compiled for a machine, without the network: those of other
    /// machines alone need not be here.
    ///
    /// # Errors
    /// Cargo fails, or writes something else.
    pub fn read(shell: Shell<'_>, machine: &str) -> Result<Self> {
        let format = ["metadata", "--format-version", "1", "--locked", "--offline"];
        let words = [&format[..], &["--filter-platform", machine]].concat();
        let text = shell.output("cargo", &words)?;
        serde_json::from_str(&text).context("cargo metadata writes another format")
    }

    /// The packages that are published, each after those on which it depends.
    ///
    /// # Errors
    /// They depend on each other in a circle, or on one that is not published.
    pub fn published(&self) -> Result<Vec<&Package>> {
        let members = self.packages.iter().filter(|package| {
            self.workspace_members.contains(&package.id) && package.is_published()
        });
        let mut left: Vec<&Package> = members.collect();
        left.sort_by(|one, other| one.name.cmp(&other.name));
        let mut ordered: Vec<&Package> = Vec::new();
        while !left.is_empty() {
            let is_ready = |package: &&Package| {
                package
                    .needs()
                    .all(|need| ordered.iter().any(|before| before.name == need))
            };
            let Some(next) = left.iter().position(is_ready) else {
                let names: Vec<&str> = left.iter().map(|package| package.name.as_str()).collect();
                bail!(
                    "these packages depend on each other, or on one that is not published: {}",
                    names.join(", ")
                );
            };
            ordered.push(left.remove(next));
        }
        Ok(ordered)
    }

    /// All packages that are compiled into a program of the workspace, or build it, by name.
    ///
    /// # Errors
    /// There is no package of this name.
    pub fn compiled_into(&self, program: &str) -> Result<Vec<&Package>> {
        let first = self
            .packages
            .iter()
            .find(|package| package.name == program)
            .with_context(|| format!("the workspace has no package {program}"))?;
        let nodes: BTreeMap<&str, &Node> = self
            .resolve
            .nodes
            .iter()
            .map(|node| (node.id.as_str(), node))
            .collect();
        let mut found = BTreeSet::new();
        let mut open = vec![first.id.as_str()];
        while let Some(id) = open.pop() {
            if !found.insert(id) {
                continue;
            }
            let dependencies = nodes.get(id).map_or(&[][..], |node| &node.deps[..]);
            let compiled = dependencies.iter().filter(|needed| needed.is_compiled());
            open.extend(compiled.map(|dependency| dependency.pkg.as_str()));
        }
        let mut packages: Vec<&Package> = self
            .packages
            .iter()
            .filter(|package| found.contains(package.id.as_str()))
            .collect();
        packages
            .sort_by(|one, other| (&one.name, &one.version).cmp(&(&other.name, &other.version)));
        Ok(packages)
    }

    /// All packages: those of the workspace, and all that they, their tests and their builds need.
    pub fn packages(&self) -> &[Package] {
        &self.packages
    }

    /// The packages that a package needs directly, without those of its tests alone, by name.
    pub fn dependencies(&self, package: &Package) -> Vec<&Package> {
        let nodes = self.resolve.nodes.iter();
        let needed: BTreeSet<&str> = nodes
            .filter(|node| node.id == package.id)
            .flat_map(|node| &node.deps)
            .filter(|dependency| dependency.is_compiled())
            .map(|dependency| dependency.pkg.as_str())
            .collect();
        let mut packages: Vec<&Package> = self
            .packages
            .iter()
            .filter(|package| needed.contains(package.id.as_str()))
            .collect();
        packages
            .sort_by(|one, other| (&one.name, &one.version).cmp(&(&other.name, &other.version)));
        packages
    }

    /// Whether a package belongs to the workspace.
    pub fn is_member(&self, package: &Package) -> bool {
        self.workspace_members.contains(&package.id)
    }
}

impl NodeDependency {
    /// Whether it is compiled into a program, or builds it: tests alone do not need it.
    fn is_compiled(&self) -> bool {
        let kinds = &self.dep_kinds;
        kinds.iter().any(|kind| kind.kind.as_deref() != Some("dev"))
    }
}

impl Package {
    fn is_published(&self) -> bool {
        self.publish
            .as_ref()
            .is_none_or(|registries| !registries.is_empty())
    }

    /// Packages of the workspace that must be published before; those of tests alone need not.
    fn needs(&self) -> impl Iterator<Item = &str> {
        self.dependencies
            .iter()
            .filter(|needed| needed.path.is_some() && needed.kind.as_deref() != Some("dev"))
            .map(|needed| needed.name.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn package(name: &str, needs: &[(&str, &str)], publish: &str) -> String {
        let needs: Vec<String> = needs
            .iter()
            .map(|(name, kind)| format!(r#"{{"name":"{name}","kind":{kind},"path":"/{name}"}}"#))
            .collect();
        format!(
            r#"{{"id":"{name}","name":"{name}","version":"1.0.0","license":null,"repository":null,
               "manifest_path":"/","publish":{publish},"dependencies":[{}]}}"#,
            needs.join(",")
        )
    }

    fn metadata(packages: &[String], members: &str) -> Metadata {
        let text = format!(
            r#"{{"packages":[{}],"workspace_members":{members},"resolve":{{"nodes":[]}},
               "target_directory":"/t"}}"#,
            packages.join(",")
        );
        serde_json::from_str(&text).unwrap()
    }

    #[test]
    fn packages_are_published_after_those_they_depend_on() {
        let packages = [
            package("a", &[("c", "null"), ("tests", "\"dev\"")], "null"),
            package("b", &[("a", "null")], "null"),
            package("c", &[], "null"),
            package("tests", &[("b", "null")], "[]"),
        ];
        let all = metadata(&packages, r#"["a","b","c","tests"]"#);
        let names: Vec<&str> = all
            .published()
            .unwrap()
            .iter()
            .map(|package| package.name.as_str())
            .collect();
        assert_eq!(names, ["c", "a", "b"]);
        let circle = [
            package("a", &[("b", "null")], "null"),
            package("b", &[("a", "null")], "null"),
        ];
        let error = metadata(&circle, r#"["a","b"]"#).published().unwrap_err();
        assert!(error.to_string().contains("a, b"), "{error}");
    }
}
