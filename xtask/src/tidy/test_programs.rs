//! Checks that every file of tests is a module of its package's test program.

use std::path::Path;

use anyhow::Result;

use super::{Fault, files::sources, read};

/// Files beside a `tests/main.rs` that it does not name: their tests would never run.
pub fn faults(root: &Path) -> Result<Vec<Fault>> {
    let mut faults = Vec::new();
    for path in sources(root)? {
        let Some(folder) = path.parent().filter(|folder| folder.ends_with("tests")) else {
            continue;
        };
        let main = root.join(folder).join("main.rs");
        let Some(name) = path.file_stem().map(|name| name.to_string_lossy()) else {
            continue;
        };
        if name != "main" && main.is_file() && !names(&read(&main)?, &name) {
            faults.push(format!(
                "{}: its tests do not run: name it in main.rs beside it",
                path.display()
            ));
        }
    }
    Ok(faults)
}

fn names(main: &str, module: &str) -> bool {
    main.lines().any(|line| {
        line.strip_prefix("mod ")
            .and_then(|rest| rest.strip_suffix(';'))
            == Some(module)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_no_program_names_is_found() {
        let root = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| {
            let path = root.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        };
        write("crates/a/tests/main.rs", "mod named;\nmod other_one;\n");
        write("crates/a/tests/named.rs", "");
        write("crates/a/tests/one.rs", "");
        // A program of its own.
        write("crates/b/tests/alone.rs", "");
        let found = faults(root.path()).unwrap();
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].starts_with("crates/a/tests/one.rs"), "{found:?}");
    }
}
