//! Names of figures that agree between runs although the numbers in them depend on the data.

/// A name without its numbers, such as lags, which depend on the data: … stands for each.
///
/// ```
/// use carom_tables::without_numbers;
///
/// let name = "diffusion coefficient at long lags, 4 to 40, gas";
/// assert_eq!(without_numbers(name), "diffusion coefficient at long lags, … to …, gas");
/// ```
pub fn without_numbers(name: &str) -> String {
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

/// Whether a figure has this name, with its numbers or with … for each of them.
///
/// ```
/// use carom_tables::is_named;
///
/// assert!(is_named("shear viscosity, from lags 2 to 8", "shear viscosity, from lags … to …"));
/// assert!(!is_named("shear viscosity, from lags 2 to 8", "shear viscosity"));
/// ```
pub fn is_named(figure: &str, name: &str) -> bool {
    figure == name || without_numbers(figure) == name
}
