//! The nearest spelling of a word that is not allowed, for error messages.

/// A suggestion differs from the word by at most this many letters, and by fewer than half of them.
const MOST_EDITS: usize = 3;

/// The allowed word that differs from `word` by the fewest letters inserted, removed or changed;
/// `None` if none is near.
pub fn nearest<'a>(word: &str, allowed: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let near = allowed.into_iter().map(|other| (edits(word, other), other));
    let (count, other) = near.min_by_key(|(count, _)| *count)?;
    (count <= MOST_EDITS && 2 * count < other.chars().count().max(2)).then_some(other)
}

/// `; did you mean 'WORD'?`, or nothing.
pub fn suggestion<'a>(word: &str, allowed: impl IntoIterator<Item = &'a str>) -> String {
    nearest(word, allowed).map_or_else(String::new, |other| format!("; did you mean '{other}'?"))
}

/// The number of letters inserted, removed or changed between two words (Levenshtein 1966).
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, letter) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &other) in b.iter().enumerate() {
            let changed = diagonal + usize::from(letter != other);
            diagonal = row[j + 1];
            row[j + 1] = changed.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_words_are_suggested_and_far_ones_are_not() {
        let allowed = ["bins", "every", "interval"];
        assert_eq!(nearest("bin", allowed), Some("bins"));
        assert_eq!(nearest("intreval", allowed), Some("interval"));
        assert_eq!(nearest("colour", allowed), None);
        assert_eq!(edits("kitten", "sitting"), 3);
        assert_eq!(suggestion("evrey", allowed), "; did you mean 'every'?");
    }
}
