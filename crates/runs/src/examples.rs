//! `carom example`: scenes and studies to begin with, listed, printed or written to a file.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail, ensure};
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

/// Examples to begin with: scenes, then studies.
const BEGINNINGS: [Example; 18] = [
    example!("tee"),
    example!("mixture"),
    example!("clustering"),
    example!("two-temperatures"),
    example!("swimmers"),
    example!("depletion"),
    example!("chains"),
    example!("wells"),
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

/// Studies that are compared with theory and published values: all in the folder `examples/theory`
/// of this crate, with the names of their folders, such as `fields/blast`.
const THEORY: &[Example] = &include!(concat!(env!("OUT_DIR"), "/studies.rs"));

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
    /// All examples: scenes and studies to begin with, then studies compared with theory.
    pub fn all() -> impl Iterator<Item = &'static Self> {
        BEGINNINGS.iter().chain(THEORY)
    }

    /// The example of this name. The folder of a study may be left out where no other example has
    /// its name.
    ///
    /// # Errors
    /// There is none, or there are several.
    pub fn named(name: &str) -> Result<&'static Self> {
        let wanted = name.trim_end_matches(".toml");
        if let Some(example) = Self::all().find(|example| example.name == wanted) {
            return Ok(example);
        }
        let last = |example: &&Self| example.name.rsplit('/').next() == Some(wanted);
        match &Self::all().filter(last).collect::<Vec<_>>()[..] {
            [example] => Ok(*example),
            [] => bail!(
                "there is no example '{name}'{}; `carom example` lists all",
                did_you_mean(name, Self::all().map(|example| example.name))
            ),
            several => bail!(
                "several examples are called '{name}': give the folder, as in {}",
                several[0].name
            ),
        }
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
        words[..sentence_end(&words)]
            .split("  ")
            .next()
            .unwrap_or_default()
            .to_owned()
    }
}

/// Where the first sentence ends: at a full stop before a space, outside of parentheses, in which
/// sources have abbreviations.
fn sentence_end(words: &str) -> usize {
    let mut depth = 0_i32;
    for (at, letter) in words.char_indices() {
        match letter {
            '(' => depth += 1,
            ')' => depth -= 1,
            '.' if depth == 0 && words[at + 1..].starts_with(' ') => return at + 1,
            _ => (),
        }
    }
    words.len()
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
    put("examples", &Example::all().map(entry).collect::<Vec<_>>());
    for example in BEGINNINGS {
        print_line(&format!("{:<20}{}", example.name, example.about()));
    }
    print_line("\nStudies that are compared with theory and published values:");
    for example in THEORY {
        print_line(&format!("{:<34}{}", example.name, example.about()));
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
        for example in Example::all() {
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
        assert_eq!(Example::named("blast").unwrap().name, "fields/blast");
        assert_eq!(Example::named("conduction").unwrap().command, "run");
        let theory = Example::named("fields/conduction").unwrap();
        assert_eq!(theory.command, "sweep");
        let tables = Example::named("chaos/tables").unwrap().about();
        assert!(
            tables.ends_with("(Bunimovich, Commun. Math. Phys. 65 (1979) 295)."),
            "{tables}"
        );
        let unknown = Example::named("mixtur").unwrap_err().to_string();
        assert!(unknown.contains("did you mean `mixture`?"), "{unknown}");
    }
}
