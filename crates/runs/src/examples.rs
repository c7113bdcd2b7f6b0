//! `carom example`: scenes and studies to begin with, listed, printed or written to a file.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use carom::engine::did_you_mean;
use carom_tables::Verdict;
use clap::Args;
use serde_json::json;

use crate::{command_line::command, console::put, print_line, whole_file::write_whole};

/// A scene or study file that the program carries.
#[derive(Debug, Clone, Copy)]
pub struct Example {
    /// Its name, without the ending `.toml`.
    pub name: &'static str,
    /// The command that runs it.
    pub command: &'static str,
    /// The file; its first comment says what it is about.
    pub text: &'static str,
}

/// The example of this name, whose file stands in the folder `examples` of this crate.
macro_rules! example {
    ($name:literal) => {
        example!($name, "run", concat!("../examples/", $name, ".toml"))
    };
    (study $name:literal) => {
        example!(
            $name,
            "sweep",
            concat!("../examples/studies/", $name, ".toml")
        )
    };
    ($name:expr, $command:literal, $path:expr) => {
        Example {
            name: $name,
            command: $command,
            text: include_str!($path),
        }
    };
}

/// All examples: scenes, then studies.
pub const EXAMPLES: [Example; 16] = [
    example!("tee"),
    example!("mixture"),
    example!("clustering"),
    example!("two-temperatures"),
    example!("swimmers"),
    example!("depletion"),
    example!("sinai"),
    example!("walls"),
    example!("piston"),
    example!("shaker"),
    example!("conduction"),
    example!("measures"),
    example!("hard-discs-870"),
    example!("quench"),
    example!(study "equation-of-state"),
    example!(study "shapes"),
];

/// Options of `carom example`.
#[derive(Debug, Clone, Args)]
pub struct ExamplesOptions {
    /// Name of the example; without it all are listed
    #[arg(value_name = "NAME")]
    pub name: Option<String>,
    /// Write it to this file instead of printing it; an existing file stays
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

impl Example {
    /// The example of this name.
    ///
    /// # Errors
    /// There is none.
    pub fn named(name: &str) -> Result<&'static Self> {
        let found = EXAMPLES
            .iter()
            .find(|example| example.name == name.trim_end_matches(".toml"));
        found.with_context(|| {
            let names = || EXAMPLES.iter().map(|example| example.name);
            let all: Vec<&str> = names().collect();
            format!(
                "there is no example '{name}'{}; they are {}",
                did_you_mean(name, names()),
                all.join(", ")
            )
        })
    }

    /// What it is about: its first sentence.
    pub fn about(&self) -> String {
        let comment = self
            .text
            .lines()
            .map_while(|line| line.strip_prefix('#'))
            .map(str::trim);
        let words = comment
            .take_while(|line| !line.is_empty())
            .collect::<Vec<_>>()
            .join(" ");
        let end = words.find(". ").map_or(words.len(), |end| end + 1);
        words[..end]
            .split("  ")
            .next()
            .unwrap_or_default()
            .to_owned()
    }
}

/// Lists the examples, or prints or writes one.
///
/// # Errors
/// There is no example of the name, or the file exists or cannot be written.
pub fn run(options: &ExamplesOptions) -> Result<Verdict> {
    let Some(name) = &options.name else {
        ensure!(options.out.is_none(), "--out needs the name of an example");
        list();
        return Ok(Verdict::Passed);
    };
    let example = Example::named(name)?;
    match &options.out {
        Some(path) => write(example, path)?,
        None => print_line(example.text.trim_end()),
    }
    Ok(Verdict::Passed)
}

fn list() {
    let entry = |example: &Example| json!({ "name": example.name, "about": example.about(), "command": example.command });
    put("examples", &EXAMPLES.iter().map(entry).collect::<Vec<_>>());
    for example in EXAMPLES {
        print_line(&format!("{:<20}{}", example.name, example.about()));
    }
    print_line(
        "\nTo begin with one: carom example mixture --out mixture.toml && carom run mixture.toml",
    );
}

fn write(example: &Example, path: &Path) -> Result<()> {
    ensure!(
        !path.exists(),
        "{} exists already: choose another file with --out",
        path.display()
    );
    write_whole(path, example.text.as_bytes())?;
    print_line(&command([
        example.command.into(),
        path.as_os_str().to_owned(),
    ]));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom::Scene;

    #[test]
    fn all_examples_are_valid_and_say_what_they_are_about() {
        for example in EXAMPLES {
            let about = example.about();
            assert!(
                about.len() > 20 && about.ends_with('.'),
                "{}: {about}",
                example.name
            );
            if example.command == "run" {
                Scene::from_toml(example.text).unwrap();
            }
            assert!(!example.text.contains("xtask"), "{}", example.name);
        }
    }

    #[test]
    fn an_example_is_found_by_its_name_or_file() {
        assert_eq!(Example::named("mixture.toml").unwrap().name, "mixture");
        let unknown = Example::named("mixtur").unwrap_err().to_string();
        assert!(unknown.contains("did you mean `mixture`?"), "{unknown}");
    }
}
