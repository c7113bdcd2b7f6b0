//! Every `cargo xtask …` in the README is a command that there is.

use clap::Parser as _;

use super::Fault;
use crate::cli::Cli;

/// Commands in a page of Markdown that cannot be understood.
pub fn faults(page: &str) -> Vec<Fault> {
    let refused = |command: String| match Cli::try_parse_from(words(&command)) {
        Ok(_) => None,
        Err(error) if !error.use_stderr() => None,
        Err(error) => {
            let reason = error.to_string();
            Some(format!(
                "README.md: `cargo xtask {command}`: {}",
                reason.lines().next().unwrap_or("refused")
            ))
        }
    };
    commands(page).into_iter().filter_map(refused).collect()
}

/// What follows `cargo xtask` in code, on lines of a block or between backticks; the bare name is no command.
fn commands(page: &str) -> Vec<String> {
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
        let code = code.trim().trim_start_matches("$ ").to_owned();
        let rest = code.strip_prefix("cargo xtask ")?.trim().to_owned();
        (!rest.is_empty()).then_some(rest)
    };
    found.into_iter().filter_map(command).collect()
}

/// A command as the program sees it: its name first, then its words, where quotes hold words together.
fn words(command: &str) -> Vec<String> {
    let mut words = vec!["xtask".to_owned()];
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

    #[test]
    fn commands_stand_in_blocks_and_between_backticks() {
        let page = "Say `cargo xtask tidy`, or `cargo xtask`.\n\
                    ```sh\n\
                    $ cargo xtask run a.toml --until 3   # short\n\
                    cargo test\n\
                    cargo xtask experiment brownian \\\n  --seed 2\n\
                    ```\n";
        assert_eq!(commands(page), ["tidy", "run a.toml --until 3", "experiment brownian  --seed 2"]);
        assert_eq!(faults(page), Vec::<Fault>::new());
    }

    #[test]
    fn commands_that_there_are_not_are_faults() {
        let page = "`cargo xtask fly` `cargo xtask run` `cargo xtask run a.toml --untill 3` \
                    `cargo xtask experiment brownian --case 'no such'` `cargo xtask --help`";
        assert_eq!(faults(page).len(), 4, "{:?}", faults(page));
    }

    #[test]
    fn quotes_hold_words_together() {
        assert_eq!(words("run 'a b.toml' --set \"x=1 2\""), ["xtask", "run", "a b.toml", "--set", "x=1 2"]);
    }
}
