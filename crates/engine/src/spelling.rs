//! The known name nearest to a misspelt one, for error messages.

/// Letters of a name for each edit that a suggestion may need, rounded up. Smaller: unrelated names
/// are suggested. Larger: two slips in a short name find nothing.
const LETTERS_PER_EDIT: usize = 3;

/// Returns "; did you mean `name`?" with the known name nearest to `word`, as the end of an error
/// message, or nothing if no known name is near.
///
/// ```
/// use carom_engine::did_you_mean;
///
/// assert_eq!(did_you_mean("raduis", ["mass", "radius"]), "; did you mean `radius`?");
/// assert_eq!(did_you_mean("colour", ["mass", "radius"]), "");
/// ```
pub fn did_you_mean<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let most = word.chars().count().div_ceil(LETTERS_PER_EDIT);
    let near = known.into_iter().map(|name| (strsim::osa_distance(word, name), name));
    let nearest = near.filter(|(distance, _)| *distance <= most).min_by_key(|(distance, _)| *distance);
    nearest.map_or_else(String::new, |(_, name)| format!("; did you mean `{name}`?"))
}

/// A suggestion for an error message of serde, "unknown field `x`, expected one of `a`, `b`", or
/// nothing for another message.
pub(crate) fn suggestion(message: &str) -> String {
    let mut names = message.split('`').skip(1).step_by(2);
    match names.next() {
        Some(word) if message.starts_with("unknown ") => did_you_mean(word, names),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_of_serde_are_completed() {
        let text = "unknown field `sede`, expected one of `sides`, `seed`, `replica`";
        assert_eq!(suggestion(text), "; did you mean `seed`?");
        assert_eq!(
            suggestion("unknown variant `lokced`, expected `free` or `locked`"),
            "; did you mean `locked`?"
        );
        assert_eq!(suggestion("missing field `at`"), "");
        assert_eq!(suggestion("unknown field `xyz`, there are no fields"), "");
    }
}
