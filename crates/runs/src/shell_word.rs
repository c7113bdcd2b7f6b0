//! Words of a command line, quoted so that a shell reads them back unchanged.

use std::{ffi::OsStr, fmt::Write as _};

/// Returns a word as a POSIX shell reads it back: plain words unchanged, others in single quotes,
/// and words that are not UTF-8 in `$'…'` with octal escapes.
pub fn shell_word(word: &OsStr) -> String {
    let Some(text) = word.to_str() else { return escaped(word.as_encoded_bytes()) };
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        return text.to_owned();
    }
    format!("'{}'", text.replace('\'', "'\\''"))
}

/// Bytes in `$'…'`; all that are not letters or digits of ASCII are escaped.
fn escaped(bytes: &[u8]) -> String {
    let mut text = String::from("$'");
    for &byte in bytes {
        if byte.is_ascii_alphanumeric() || b"-_./".contains(&byte) {
            text.push(char::from(byte));
        } else {
            // Three octal digits: a hexadecimal escape would include digits that follow.
            let _ = write!(text, "\\{byte:03o}");
        }
    }
    text.push('\'');
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_that_a_shell_would_change_are_quoted() {
        for (word, quoted) in [
            ("out/live-gas/1", "out/live-gas/1"),
            ("", "''"),
            ("a b", "'a b'"),
            ("$(touch x)", "'$(touch x)'"),
            ("it's", "'it'\\''s'"),
        ] {
            assert_eq!(shell_word(OsStr::new(word)), quoted);
        }
    }

    #[cfg(unix)]
    #[test]
    fn words_that_are_not_utf_8_keep_their_bytes() {
        use std::os::unix::ffi::OsStrExt as _;
        assert_eq!(shell_word(OsStr::from_bytes(b"sv\xff1 x")), "$'sv\\3771\\040x'");
    }
}
