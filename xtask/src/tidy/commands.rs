//! Checks that every `cargo xtask …` and `carom …` in a Markdown file is a valid command.

use std::path::Path;

use anyhow::Result;
use clap::{Parser as _, error::ErrorKind};

use super::{Fault, files::text_files, read};

/// Parses the words of a `cargo xtask` command.
pub type Parse = fn(&[String]) -> Result<(), clap::Error>;

/// Invalid commands in all Markdown files.
pub fn faults(root: &Path, parse: Parse) -> Result<Vec<Fault>> {
    let mut faults = Vec::new();
    for path in text_files(root)? {
        if path.extension().is_some_and(|extension| extension == "md") {
            let page = read(&root.join(&path))?;
            faults.extend(
                refused(&page, parse)
                    .into_iter()
                    .map(|fault| format!("{}: {fault}", path.display())),
            );
        }
    }
    Ok(faults)
}

/// Invalid commands in a page of Markdown, with the error.
fn refused(page: &str, parse: Parse) -> Vec<Fault> {
    let refused = |(program, command): (&str, String)| {
        let words = words(&command);
        let parsed = match program {
            "carom" => carom_cli::Cli::try_parse_from(words).map(|_| ()),
            _ => parse(&words),
        };
        let error = parsed.err().filter(clap::Error::use_stderr)?;
        // A command named without arguments, as in prose.
        let is_name = command.split(' ').count() == 1;
        if is_name && error.kind() == ErrorKind::MissingRequiredArgument {
            return None;
        }
        let error = error.to_string();
        Some(format!(
            "`{program} {command}`: {}",
            error.lines().next().unwrap_or("refused")
        ))
    };
    commands(page).into_iter().filter_map(refused).collect()
}

/// Programs and their arguments in code blocks or between backticks; a bare name is not a command.
fn commands(page: &str) -> Vec<(&'static str, String)> {
    let mut found = Vec::new();
    let mut block = String::new();
    let mut inside = false;
    for line in page.lines() {
        if line.trim_start().starts_with("```") {
            inside = !inside;
        } else if inside {
            let line = line.split(" #").next().unwrap_or(line).trim();
            block.push_str(line.trim_end_matches('\\'));
            block.push(if line.ends_with('\\') { ' ' } else { '\n' });
        } else {
            found.extend(line.split('`').skip(1).step_by(2).map(str::to_owned));
        }
    }
    found.extend(block.lines().map(str::to_owned));
    let command = |code: String| {
        // Redirections belong to the shell.
        let code = code.split(" > ").next().unwrap_or_default();
        let code = code.trim().trim_start_matches("$ ").to_owned();
        let (program, rest) = ["cargo xtask", "carom"].into_iter().find_map(|program| {
            Some((
                program,
                code.strip_prefix(program)?
                    .strip_prefix(' ')?
                    .trim()
                    .to_owned(),
            ))
        })?;
        (!rest.is_empty()).then_some((program, rest))
    };
    found.into_iter().filter_map(command).collect()
}

/// The command line as the program receives it: its name, then its words; quotes group words.
fn words(command: &str) -> Vec<String> {
    let mut words = vec!["program".to_owned()];
    let mut word = String::new();
    let mut quote = None;
    for character in command.chars() {
        match (character, quote) {
            ('"' | '\'', None) => quote = Some(character),
            (_, Some(open)) if character == open => quote = None,
            (' ', None) => {
                words.extend((!word.is_empty()).then(|| std::mem::take(&mut word)));
            }
            _ => word.push(character),
        }
    }
    words.extend((!word.is_empty()).then_some(word));
    words
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::parse;

    #[test]
    fn commands_are_found_in_blocks_and_between_backticks() {
        let page = "Say `cargo xtask tidy`, or `cargo xtask`.\n\
                    ```sh\n\
                    $ cargo xtask carom run a.toml --until 3   # short\n\
                    cargo test\n\
                    cargo xtask experiment spheres \\\n  --seed 2\n\
                    ```\n";
        let xtask = [
            "tidy",
            "carom run a.toml --until 3",
            "experiment spheres  --seed 2",
        ];
        let expected = xtask.map(|command| ("cargo xtask", command.to_owned()));
        assert_eq!(commands(page), expected);
        assert_eq!(
            commands("`carom check a.toml`, `carom`"),
            [("carom", "check a.toml".to_owned())]
        );
        assert_eq!(
            commands("`carom schema > a.json`"),
            [("carom", "schema".to_owned())]
        );
        // A name in prose.
        assert_eq!(refused("`carom run`", parse), Vec::<Fault>::new());
        assert_eq!(refused(page, parse), Vec::<Fault>::new());
    }

    #[test]
    fn unknown_commands_are_faults() {
        let page = "`cargo xtask fly` `cargo xtask carom run --seed 3` `cargo xtask carom run a.toml --untill 3` \
                    `cargo xtask experiment brownian --case 'no such'` `cargo xtask --help` \
                    `carom chek a.toml` `carom run a.toml`";
        assert_eq!(refused(page, parse).len(), 5, "{:?}", refused(page, parse));
    }

    #[test]
    fn quotes_hold_words_together() {
        assert_eq!(
            words("run 'a b.toml' --set \"x=1 2\""),
            ["program", "run", "a b.toml", "--set", "x=1 2"]
        );
    }
}
