//! A frame of extended XYZ, from which bodies can start: places and velocities of atoms, as `carom
//! run` and other programs write them.
//!
//! The first line is the number of atoms. The second has `Lattice="..."`, the three vectors of the
//! box, and `Properties=...`, the names, types and numbers of the columns. One line per atom
//! follows. Without `Properties` the columns are a symbol and a place. Columns of these names are
//! used, all others are ignored:
//!
//! | column | meaning |
//! | --- | --- |
//! | `pos` | place (length) |
//! | `velo`, `vel`, `velocities`, `velocity` | velocity (length / time) |
//! | `momenta`, `momentum` | momentum (mass × length / time), with the masses of the scene |
//! | `angle` | orientation of the molecule (radians) |
//! | `angular_velocity` | of the molecule (radians / time) |
//! | `radius` | radius of the atom (length), which must be that of the scene |
//!
//! Places, velocities and momenta have two components, or three of which the third is 0. Every
//! problem names the line within the frame, from 1.

use std::ops::Range;

use glam::DVec2;

/// Most columns of a frame: more are most likely an error.
const MAX_COLUMNS: usize = 256;

/// One frame.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SnapshotFrame {
    /// Sides of the box (length), if the frame has them.
    pub sides: Option<[f64; 2]>,
    pub atoms: Vec<SnapshotAtom>,
}

/// One atom of a frame. Quantities without a column are `None`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SnapshotAtom {
    /// Number of the line in the frame, from 1.
    pub line: usize,
    pub place: DVec2,
    pub velocity: Option<DVec2>,
    pub momentum: Option<DVec2>,
    pub angle: Option<f64>,
    pub angular_velocity: Option<f64>,
    pub radius: Option<f64>,
}

/// Returns the text of one frame of a file of one or more: frame `requested`, counted from 0, or
/// the last.
///
/// # Errors
/// The problem, with the line of the file, if a frame is not complete or there is no such frame.
///
/// ```
/// use carom_engine::frame_of;
///
/// let text = "1\nfirst\nH 0 0 0\n1\nsecond\nH 0.5 0 0\n";
/// assert_eq!(frame_of(text, None)?, "1\nsecond\nH 0.5 0 0\n");
/// assert_eq!(frame_of(text, Some(0))?, "1\nfirst\nH 0 0 0\n");
/// assert!(frame_of(text, Some(2)).is_err());
/// # Ok::<(), String>(())
/// ```
pub fn frame_of(text: &str, requested: Option<usize>) -> Result<&str, String> {
    let (mut start, mut line, mut frames, mut last) = (0, 1, 0, None);
    // Each round consumes at least one line.
    while !text[start..].trim().is_empty() {
        let mut ends = text[start..]
            .match_indices('\n')
            .map(|(at, _)| start + at + 1);
        let first = ends.next().unwrap_or(text.len());
        let atoms = number_of_atoms(text[start..first].trim())
            .map_err(|problem| format!("line {line}: {problem}"))?;
        let body = &text[first..];
        let end = match body.match_indices('\n').nth(atoms) {
            Some((at, _)) => first + at + 1,
            // The last line may have no end.
            None if body.lines().count() == atoms + 1 => text.len(),
            None => {
                let found = body.lines().count().saturating_sub(1);
                return Err(format!(
                    "line {line}: the frame must have {atoms} atoms, but the file ends after {found}"
                ));
            }
        };
        if requested == Some(frames) {
            return Ok(&text[start..end]);
        }
        last = Some(start..end);
        (start, line, frames) = (end, line + atoms + 2, frames + 1);
    }
    match (last, requested) {
        (_, Some(requested)) => Err(format!(
            "the file has {frames} frames, numbered from 0; {requested} is out of range"
        )),
        (None, None) => Err("the file has no frame".to_owned()),
        (Some(range), None) => Ok(&text[range]),
    }
}

fn number_of_atoms(line: &str) -> Result<usize, String> {
    let count: u32 = line
        .parse()
        .map_err(|_| format!("the number of atoms is expected, not {:?}", shortened(line)))?;
    Ok(count as usize)
}

/// Reads one frame.
///
/// # Errors
/// The problem, with the line.
pub(crate) fn read_frame(text: &str) -> Result<SnapshotFrame, String> {
    let mut lines = text.lines().enumerate();
    let (_, first) = lines.next().ok_or("the frame is empty")?;
    let count = number_of_atoms(first.trim()).map_err(|problem| format!("line 1: {problem}"))?;
    let (_, comment) = lines.next().ok_or("line 2 is missing")?;
    let entries = entries(comment).map_err(|problem| format!("line 2: {problem}"))?;
    let entry = |key: &str| {
        entries
            .iter()
            .find(|(name, _)| name.eq_ignore_ascii_case(key))
            .map(|(_, value)| *value)
    };
    let sides = entry("Lattice")
        .map(lattice)
        .transpose()
        .map_err(|problem| format!("line 2: {problem}"))?;
    let columns = Columns::new(entry("Properties").unwrap_or("species:S:1:pos:R:3"))
        .map_err(|problem| format!("line 2: {problem}"))?;
    let mut atoms = Vec::new();
    for (index, line) in lines.by_ref().take(count) {
        atoms.push(
            columns
                .read(index + 1, line)
                .map_err(|problem| format!("line {}: {problem}", index + 1))?,
        );
    }
    if atoms.len() < count {
        return Err(format!(
            "the frame must have {count} atoms, but has {}",
            atoms.len()
        ));
    }
    Ok(SnapshotFrame { sides, atoms })
}

/// The entries `key=value` and `key="value with spaces"` of a comment line; words without `=` are
/// ignored.
fn entries(comment: &str) -> Result<Vec<(&str, &str)>, String> {
    let (mut rest, mut entries) = (comment.trim_start(), Vec::new());
    // Each round consumes at least one character.
    while !rest.is_empty() {
        let end = rest
            .find(|c: char| c == '=' || c.is_whitespace())
            .unwrap_or(rest.len());
        let (key, after) = rest.split_at(end);
        let Some(value) = after.strip_prefix('=') else {
            rest = after.trim_start();
            continue;
        };
        let (value, after) = match value.strip_prefix('"') {
            Some(quoted) => quoted
                .split_once('"')
                .ok_or_else(|| format!("the quotes of `{}` are not closed", shortened(key)))?,
            None => value.split_at(value.find(char::is_whitespace).unwrap_or(value.len())),
        };
        entries.push((key, value));
        rest = after.trim_start();
    }
    Ok(entries)
}

/// The sides of a rectangular box.
fn lattice(text: &str) -> Result<[f64; 2], String> {
    let numbers: Vec<f64> = text
        .split_whitespace()
        .map(number)
        .collect::<Result<_, _>>()?;
    let [x, a, b, c, y, d, e, f, _] = numbers[..] else {
        return Err(format!(
            "`Lattice` must have 9 numbers, but has {}",
            numbers.len()
        ));
    };
    if [a, b, c, d, e, f].iter().any(|&component| component != 0.0) {
        return Err("the box of `Lattice` must be rectangular, along the axes".to_owned());
    }
    Ok([x, y])
}

fn number(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!(
            "a finite number is expected, not {:?}",
            shortened(word)
        )),
    }
}

/// The vector of two numbers, or of three if the third is 0.
fn planar(words: &[&str]) -> Result<DVec2, String> {
    let numbers: Vec<f64> = words
        .iter()
        .map(|word| number(word))
        .collect::<Result<_, _>>()?;
    match numbers[..] {
        [x, y] | [x, y, 0.0] => Ok(DVec2::new(x, y)),
        _ => Err(format!(
            "there must be two numbers [x, y], or a third that is 0, but there is [{}]",
            words.join(", ")
        )),
    }
}

/// At most 40 characters of a text, for a message.
fn shortened(text: &str) -> String {
    text.chars().take(40).collect()
}

/// The columns of a frame in which the quantities are.
struct Columns {
    all: usize,
    place: Range<usize>,
    velocity: Option<Range<usize>>,
    momentum: Option<Range<usize>>,
    angle: Option<Range<usize>>,
    angular_velocity: Option<Range<usize>>,
    radius: Option<Range<usize>>,
}

impl Columns {
    /// Reads `Properties`: name, type and number of columns of each quantity.
    fn new(properties: &str) -> Result<Self, String> {
        let words: Vec<&str> = properties.split(':').collect();
        let mut named: Vec<(String, Range<usize>)> = Vec::new();
        let mut all = 0;
        for triple in words.chunks(3) {
            let [name, kind, count] = triple else {
                return Err("`Properties` must be a list of name:type:columns".to_owned());
            };
            let count: usize = count
                .parse()
                .ok()
                .filter(|count| (1..=MAX_COLUMNS).contains(count))
                .ok_or_else(|| {
                    format!(
                        "`Properties`: {:?} is no number of columns from 1 to {MAX_COLUMNS}",
                        shortened(count)
                    )
                })?;
            if !["S", "R", "I", "L"].contains(kind) {
                return Err(format!(
                    "`Properties`: the type must be S, R, I or L, not {:?}",
                    shortened(kind)
                ));
            }
            named.push((name.to_ascii_lowercase(), all..all + count));
            all += count;
            if all > MAX_COLUMNS {
                return Err(format!(
                    "`Properties` must have at most {MAX_COLUMNS} columns"
                ));
            }
        }
        let find = |names: &[&str], least: usize| {
            let found = named
                .iter()
                .find(|(name, _)| names.contains(&name.as_str()));
            match found {
                Some((name, range))
                    if range.len() < least
                        || range.len() > 3
                        || (least == 1 && range.len() > 1) =>
                {
                    Err(format!("`Properties`: {name} has {} columns", range.len()))
                }
                found => Ok(found.map(|(_, range)| range.clone())),
            }
        };
        Ok(Self {
            all,
            place: find(&["pos", "positions"], 2)?.ok_or("`Properties` must have `pos`")?,
            velocity: find(&["velo", "vel", "velocities", "velocity"], 2)?,
            momentum: find(&["momenta", "momentum"], 2)?,
            angle: find(&["angle"], 1)?,
            angular_velocity: find(&["angular_velocity"], 1)?,
            radius: find(&["radius", "radii"], 1)?,
        })
    }

    fn read(&self, line: usize, text: &str) -> Result<SnapshotAtom, String> {
        let words: Vec<&str> = text.split_whitespace().take(MAX_COLUMNS + 1).collect();
        if words.len() != self.all {
            return Err(format!(
                "there must be {} columns, but there are {}",
                self.all,
                words.len()
            ));
        }
        let vector = |range: &Range<usize>| planar(&words[range.clone()]);
        let scalar = |range: &Option<Range<usize>>| {
            range
                .as_ref()
                .map(|range| number(words[range.start]))
                .transpose()
        };
        Ok(SnapshotAtom {
            line,
            place: vector(&self.place)?,
            velocity: self.velocity.as_ref().map(vector).transpose()?,
            momentum: self.momentum.as_ref().map(vector).transpose()?,
            angle: scalar(&self.angle)?,
            angular_velocity: scalar(&self.angular_velocity)?,
            radius: scalar(&self.radius)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_of_another_program_is_read() {
        let text = "2\nLattice=\"2.0 0.0 0.0 0.0 1.0 0.0 0.0 0.0 1.0\" Properties=species:S:1:pos:R:3:momenta:R:3 \
                    pbc=\"T T F\" energy=-1.5 converged\nAr 0.5 0.25 0.0 1.0 -2.0 0.0\nAr 1e0 2.5E-1 0.0 0 0 0\n";
        let frame = read_frame(text).unwrap();
        assert_eq!(frame.sides, Some([2.0, 1.0]));
        assert_eq!(frame.atoms[0].place, DVec2::new(0.5, 0.25));
        assert_eq!(frame.atoms[0].momentum, Some(DVec2::new(1.0, -2.0)));
        assert_eq!((frame.atoms[1].line, frame.atoms[1].velocity), (4, None));
        let plain = read_frame("1\n\nHe 0.5 0.5 0\n").unwrap();
        assert_eq!((plain.sides, plain.atoms.len()), (None, 1));
    }

    #[test]
    fn problems_name_their_line() {
        let good = "1\nLattice=\"1 0 0 0 1 0 0 0 1\" Properties=species:S:1:pos:R:3:vel:R:3\nH 0 0 0 1 1 0\n";
        assert!(read_frame(good).is_ok());
        for (from, to, expected) in [
            (
                "1\nL",
                "one\nL",
                "line 1: the number of atoms is expected, not \"one\"",
            ),
            ("1\nL", "-1\nL", "line 1: the number of atoms"),
            ("1\nL", "2\nL", "must have 2 atoms, but has 1"),
            (
                "1 0 0 0 1",
                "1 0 0.5 0 1",
                "line 2: the box of `Lattice` must be rectangular",
            ),
            (
                "1 0 0 0 1",
                "1",
                "line 2: `Lattice` must have 9 numbers, but has 5",
            ),
            (
                "0 1\" P",
                "0 1 P",
                "line 2: the quotes of `Lattice` are not closed",
            ),
            (
                "pos:R:3:vel",
                "place:R:3:vel",
                "line 2: `Properties` must have `pos`",
            ),
            (
                "pos:R:3",
                "pos:R:1",
                "line 2: `Properties`: pos has 1 columns",
            ),
            ("pos:R:3", "pos:R:x", "no number of columns"),
            ("pos:R:3", "pos:R:300", "no number of columns"),
            ("pos:R:3", "pos:Q:3", "the type must be S, R, I or L"),
            ("vel:R:3", "vel:R", "name:type:columns"),
            (
                "H 0 0 0 1 1 0",
                "H 0 0 0 1 1",
                "line 3: there must be 7 columns, but there are 6",
            ),
            (
                "H 0 0 0 1 1 0",
                "H nan 0 0 1 1 0",
                "line 3: a finite number is expected, not \"nan\"",
            ),
            (
                "H 0 0 0 1 1 0",
                "H 0 0 0 1 inf 0",
                "line 3: a finite number is expected",
            ),
            (
                "H 0 0 0 1 1 0",
                "H 0 0 0.5 1 1 0",
                "line 3: there must be two numbers [x, y], or a third that is 0",
            ),
            (
                "H 0 0 0 1 1 0",
                "H 0 0 -0.0 1 1 1e-9",
                "but there is [1, 1, 1e-9]",
            ),
            (
                "H 0 0 0 1 1 0",
                "H 0 0 nan 1 1 0",
                "line 3: a finite number is expected",
            ),
        ] {
            let problem = read_frame(&good.replacen(from, to, 1)).unwrap_err();
            assert!(problem.contains(expected), "{to}: {problem}");
        }
        assert!(
            frame_of("3\n\nH 0 0 0\n", None)
                .unwrap_err()
                .contains("3 atoms, but the file ends after 1")
        );
        assert!(
            frame_of("1\n\nH 0 0 0\nrest\n", None)
                .unwrap_err()
                .starts_with("line 4: the number")
        );
        assert!(frame_of(" \n", None).unwrap_err().contains("no frame"));
        assert_eq!(
            frame_of("0\n", None).unwrap_err(),
            "line 1: the frame must have 0 atoms, but the file ends after 0"
        );
        assert!(frame_of("4294967295\n", None).is_err());
    }

    #[test]
    fn texts_cut_or_changed_anywhere_cause_no_panic() {
        let good = "1\nLattice=\"1 0 0 0 1 0 0 0 1\" Properties=species:S:1:pos:R:3:vel:R:3\nH 0 0 0 1 1 0\n";
        for at in 0..good.len() {
            for piece in ["", "\n", "\"", "=", ":", "9", "é", "-", "\0", "1e999"] {
                let changed = format!("{}{piece}{}", &good[..at], &good[at + 1..]);
                let _ = frame_of(&changed, None).map(read_frame);
                let _ = read_frame(&good[..at]);
            }
        }
    }
}
