//! Commands that the user can copy into a shell.

use std::{
    env,
    ffi::{OsStr, OsString},
};

/// The program as called on a command line: `carom`, or `cargo xtask` for the experiments.
pub fn program() -> &'static str {
    let path = env::current_exe().unwrap_or_default();
    if path.file_stem().is_some_and(|name| name == "xtask") {
        "cargo xtask"
    } else {
        "carom"
    }
}

/// The words after the name of the program, as given.
pub fn given() -> impl Iterator<Item = OsString> {
    env::args_os().skip(1)
}

/// A command of this program with quoted words.
pub fn command(words: impl IntoIterator<Item = impl AsRef<OsStr>>) -> String {
    let words = words.into_iter().map(|word| quoted(word.as_ref()));
    std::iter::once(program().to_owned())
        .chain(words)
        .collect::<Vec<_>>()
        .join(" ")
}

/// A word as a shell reads it. Of a word that is not UTF-8, the bytes are written as numbers.
pub fn quoted(word: impl AsRef<OsStr>) -> String {
    let word = word.as_ref();
    let Some(text) = word.to_str() else {
        return in_numbers(word);
    };
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+".contains(c);
    let is_plain = !text.is_empty() && text.chars().all(plain);
    if is_plain {
        text.to_owned()
    } else {
        format!("'{}'", text.replace('\'', "'\\''"))
    }
}

/// A word that is not UTF-8, in the form `$'…'`, which bash, zsh and ksh read.
fn in_numbers(word: &OsStr) -> String {
    let byte = |&byte: &u8| match byte {
        b'\'' | b'\\' => format!("\\{}", char::from(byte)),
        b' '..=b'~' => char::from(byte).to_string(),
        // Three digits: a letter or digit after it belongs to the word.
        _ => format!("\\{byte:03o}"),
    };
    let bytes: String = word.as_encoded_bytes().iter().map(byte).collect();
    format!("$'{bytes}'")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_where_a_shell_would_change_them() {
        for (word, expected) in [
            ("out/run-a_1.toml", "out/run-a_1.toml"),
            ("a b", "'a b'"),
            ("", "''"),
            ("$(touch x)", "'$(touch x)'"),
            ("it's", "'it'\\''s'"),
        ] {
            assert_eq!(quoted(word), expected);
        }
        assert!(command(["run", "a b"]).ends_with(" run 'a b'"));
    }

    #[cfg(unix)]
    #[test]
    fn a_shell_reads_every_word_as_it_was() {
        use std::{os::unix::ffi::OsStrExt as _, process::Command};
        for word in [
            &b"a\xff'1\\b"[..],
            b"\xff\xfe.toml",
            b"a 'b' \"c\" $d `e` \\f\n;g",
            b"*?~#",
        ] {
            let script = format!("printf %s {}", quoted(OsStr::from_bytes(word)));
            // Not every machine has bash.
            let Ok(output) = Command::new("bash").arg("-c").arg(&script).output() else {
                return;
            };
            assert_eq!(output.stdout, word, "{script}");
        }
    }
}
