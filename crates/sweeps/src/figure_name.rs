//! Names of figures that agree between points although the numbers in them depend on the data.

/// A name without its numbers, such as lags, which depend on the data.
pub(crate) fn without_numbers(name: &str) -> String {
    let word = |word: &str| {
        let end = word.trim_end_matches(',');
        if end.parse::<f64>().is_ok() {
            word.replacen(end, "…", 1)
        } else {
            word.to_owned()
        }
    };
    name.split(' ').map(word).collect::<Vec<_>>().join(" ")
}
