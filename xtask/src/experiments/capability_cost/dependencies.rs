//! Dependencies of each layer when it is used alone.

use std::{collections::BTreeSet, process::Command};

/// The layers, from the lowest.
const LAYERS: [&str; 7] = [
    "carom-geometry",
    "carom-kinematics",
    "carom-detection",
    "carom-response",
    "carom-engine",
    "carom-observers",
    "carom",
];

/// Number of packages that a layer needs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Needs {
    /// The layer.
    pub layer: &'static str,
    /// Layers of carom below it.
    pub own: usize,
    /// Packages outside carom.
    pub foreign: usize,
    /// Of these, macros and their dependencies: they are not part of the program.
    pub when_compiling: usize,
}

/// Dependencies of each layer; empty if cargo cannot list them.
pub fn needs() -> Vec<Needs> {
    LAYERS.into_iter().filter_map(needs_of_layer).collect()
}

fn needs_of_layer(layer: &'static str) -> Option<Needs> {
    let list = |edges: &str| -> Option<BTreeSet<String>> {
        let output = Command::new(option_env!("CARGO").unwrap_or("cargo"))
            .args([
                "tree",
                "--offline",
                "--package",
                layer,
                "--edges",
                edges,
                "--prefix",
                "none",
            ])
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output()
            .ok()?;
        let text = String::from_utf8(output.stdout).ok()?;
        let names = text
            .lines()
            .filter_map(|line| line.split(' ').next())
            .filter(|name| !name.is_empty());
        output
            .status
            .success()
            .then(|| names.map(str::to_owned).collect())
    };
    let all = list("normal,build")?;
    let in_program = list("normal,no-proc-macro")?;
    let is_own = |name: &&String| LAYERS.contains(&name.as_str());
    let own = all.iter().filter(is_own).count();
    Some(Needs {
        layer,
        own: own.saturating_sub(1),
        foreign: all.len() - own,
        when_compiling: all.difference(&in_program).count(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_layer_needs_those_below_it() {
        let needs = needs();
        // Without cargo the list is empty and there is nothing to check.
        let own = |layer| {
            needs
                .iter()
                .find(|needs| needs.layer == layer)
                .map(|needs| needs.own)
        };
        assert!(matches!(own("carom-geometry"), None | Some(0)));
        assert!(matches!(own("carom-engine"), None | Some(4)));
    }
}
