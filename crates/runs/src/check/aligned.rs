//! Short tables of text with aligned columns.

use carom_tables::significant;

/// Space between two columns.
const SPACE: &str = "  ";

/// Rows of cells as lines of text, each indented; all columns but the last have the width of their
/// widest cell. Ends without a line break.
pub(super) fn table<const N: usize>(rows: impl IntoIterator<Item = [String; N]>) -> String {
    let rows: Vec<[String; N]> = rows.into_iter().collect();
    let width = |column: usize| {
        rows.iter()
            .map(|row| row[column].chars().count())
            .max()
            .unwrap_or(0)
    };
    let widths: Vec<usize> = (0..N).map(width).collect();
    let line = |row: &[String; N]| {
        let cells = row
            .iter()
            .zip(&widths)
            .map(|(cell, width)| format!("{cell:<width$}"));
        format!("{SPACE}{}", cells.collect::<Vec<_>>().join(SPACE))
            .trim_end()
            .to_owned()
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// A number with four significant digits.
pub(crate) fn short(number: f64) -> String {
    significant(number, 4)
}

/// A number of bytes with its unit.
pub(super) fn bytes(count: u64) -> String {
    let count = count as f64;
    let (unit, name) = match count {
        _ if count < 1e3 => (1.0, "bytes"),
        _ if count < 1e6 => (1e3, "kB"),
        _ if count < 1e9 => (1e6, "MB"),
        _ => (1e9, "GB"),
    };
    let digits = usize::from(count >= 1e3 && count / unit < 10.0);
    format!("{:.digits$} {name}", count / unit)
}

/// A time of a computer, from nanoseconds to years.
pub(super) fn duration(seconds: f64) -> String {
    let units = [
        (1e-6, 1e-9, "ns"),
        (1e-3, 1e-6, "µs"),
        (1.0, 1e-3, "ms"),
        (120.0, 1.0, "s"),
        (7200.0, 60.0, "minutes"),
        (172_800.0, 3600.0, "hours"),
        (63_115_200.0, 86_400.0, "days"),
    ];
    let found = units.iter().find(|(below, ..)| seconds < *below);
    let (unit, name) = found.map_or((31_557_600.0, "years"), |&(_, unit, name)| (unit, name));
    let number = seconds / unit;
    let digits = usize::from(number < 10.0);
    if number < 1e6 {
        format!("{number:.digits$} {name}")
    } else {
        format!("{number:.1e} {name}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned_by_characters() {
        let rows = [["π", "a", "last"], ["two", "bcd", ""]].map(|row| row.map(str::to_owned));
        assert_eq!(table(rows), "  π    a    last\n  two  bcd");
    }

    #[test]
    fn bytes_and_durations_have_units() {
        assert_eq!(
            [bytes(12), bytes(4_200_000), bytes(325_000_000)],
            ["12 bytes", "4.2 MB", "325 MB"]
        );
        assert_eq!(
            [duration(3e-7), duration(0.0123), duration(90.0)],
            ["300 ns", "12 ms", "90 s"]
        );
        assert_eq!([duration(600.0), duration(1e9)], ["10 minutes", "32 years"]);
    }
}
