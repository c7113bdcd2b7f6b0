//! Reads the frames of an extended XYZ trajectory that a run has written, one after another.

use std::io::{BufRead, Read as _};

use anyhow::{Context, Result, bail, ensure};

/// The longest line (bytes). Smaller: scenes of many walls, which share a line, are refused.
const MAX_LINE: u64 = 1 << 26;

/// The columns that are read: name, type and number of values. The last may be absent.
const COLUMNS: [(&str, char, usize); 11] = [
    ("species", 'S', 1),
    ("pos", 'R', 3),
    ("velo", 'R', 3),
    ("molecule_id", 'I', 1),
    ("atom", 'I', 1),
    ("radius", 'R', 1),
    ("angle", 'R', 1),
    ("angular_velocity", 'R', 1),
    ("mass", 'R', 1),
    ("kind", 'I', 1),
    ("map_shift", 'I', 3),
];

/// The place of the first value of each of [`COLUMNS`] in a line.
type Places = [Option<usize>; COLUMNS.len()];

/// One frame.
#[derive(Debug, Default)]
pub(super) struct TrajectoryFrame {
    /// Time of the snapshot.
    pub(super) time: f64,
    /// Sides of the box along x and y (length).
    pub(super) sides: [f64; 2],
    /// Shift along x of the next box above (length).
    pub(super) tilt: f64,
    /// Thickness of the box along z (length).
    pub(super) thickness: f64,
    /// Five numbers a wall: x and y of one end, x and y of the other, half the thickness (length).
    pub(super) walls: Vec<f64>,
    /// Straight edges of the molecules.
    pub(super) edges: Vec<KindEdge>,
    /// Ellipses among the atoms: kind, atom, the shorter axis over the longer one, and the
    /// direction of the longer one in the frame of the body (radians).
    pub(super) ellipses: Vec<[f64; 4]>,
    /// Kinds in which closed lines of edges are filled.
    pub(super) solid: Vec<u32>,
    /// Kinds whose mass is spread evenly over their area.
    pub(super) uniform: Vec<u32>,
    /// Two atoms for each bond, by their numbers in `atoms`.
    pub(super) bonds: Vec<[u32; 2]>,
    /// Names of the kinds, as far as they are known.
    pub(super) kinds: Vec<String>,
    pub(super) atoms: Vec<AtomLine>,
}

/// A straight edge of all molecules of a kind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct KindEdge {
    pub(super) kind: u32,
    /// The atoms at its ends.
    pub(super) ends: [u32; 2],
    /// Its radius over the smaller one of those of the atoms.
    pub(super) share: f64,
}

/// One atom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AtomLine {
    pub(super) position: [f64; 2],
    /// Boxes that its molecule has crossed.
    pub(super) image: [i32; 2],
    pub(super) velocity: [f64; 2],
    /// Number of its molecule.
    pub(super) molecule: u64,
    /// Index in the molecule.
    pub(super) index: u64,
    pub(super) radius: f64,
    /// Orientation of the molecule (radians).
    pub(super) angle: f64,
    pub(super) angular_velocity: f64,
    pub(super) mass: f64,
    /// Kind of the molecule, from 0.
    pub(super) kind: u32,
    /// Whether the molecule is fixed.
    pub(super) is_fixed: bool,
}

/// The frames of a trajectory.
pub(super) struct Frames<R> {
    lines: R,
    /// Number of the last line read, from 1.
    number: u64,
    line: String,
}

impl<R: BufRead> Frames<R> {
    pub(super) fn new(lines: R) -> Self {
        Self {
            lines,
            number: 0,
            line: String::new(),
        }
    }

    /// Reads the next frame into `frame`; returns `false` at the end of the file.
    ///
    /// # Errors
    /// The file cannot be read or is not such a trajectory; the message names the line.
    pub(super) fn read(&mut self, frame: &mut TrajectoryFrame) -> Result<bool> {
        if !self.next_line()? {
            return Ok(false);
        }
        let first = self.number;
        let Ok(count) = self.line.trim().parse::<u64>() else {
            bail!(
                "line {first}: '{}' is not the number of atoms of a frame",
                shortened(&self.line)
            );
        };
        ensure!(
            self.next_line()?,
            "line {first}: the file ends within a frame"
        );
        let columns = self
            .comment(frame)
            .with_context(|| format!("line {}", self.number))?;
        frame.atoms.clear();
        for read in 0..count {
            ensure!(
                self.next_line()?,
                "line {first}: the file ends after {read} of the {count} atoms of this frame"
            );
            let atom = self
                .atom(&columns)
                .with_context(|| format!("line {}", self.number))?;
            frame.atoms.push(atom);
        }
        let beyond = frame
            .bonds
            .iter()
            .flatten()
            .find(|&&atom| u64::from(atom) >= count);
        if let Some(atom) = beyond {
            bail!("line {first}: Bonds: there is no atom {atom} among the {count} of this frame");
        }
        Ok(true)
    }

    /// Reads a line without its end; returns `false` at the end of the file.
    fn next_line(&mut self) -> Result<bool> {
        self.line.clear();
        self.number += 1;
        let line = || format!("line {}", self.number);
        let read = (&mut self.lines)
            .take(MAX_LINE)
            .read_line(&mut self.line)
            .with_context(line)?;
        ensure!(
            (read as u64) < MAX_LINE,
            "line {}: longer than {MAX_LINE} bytes",
            self.number
        );
        let length = self.line.trim_end_matches(['\n', '\r']).len();
        self.line.truncate(length);
        Ok(read > 0)
    }

    /// Parses the comment line and returns the places of the columns.
    fn comment(&self, frame: &mut TrajectoryFrame) -> Result<Places> {
        let entries = entries(&self.line)?;
        let entry = |name: &str| {
            entries
                .iter()
                .find(|(key, _)| *key == name)
                .map(|(_, value)| *value)
        };
        let needed =
            |name: &str| entry(name).with_context(|| format!("the entry {name}=… is missing"));
        let lattice = numbers(needed("Lattice")?).context("Lattice")?;
        let [x, 0.0, 0.0, tilt, y, 0.0, 0.0, 0.0, z] = lattice[..] else {
            bail!(
                "Lattice: expected nine numbers of a box with sides along x, y and z, of which the second may be \
                 shifted along x"
            );
        };
        for side in [x, y, z] {
            ensure!(side > 0.0, "Lattice: the side {side} is not positive");
        }
        ensure!(tilt.is_finite(), "Lattice: the shift {tilt} is not finite");
        (frame.sides, frame.tilt, frame.thickness) = ([x, y], tilt, z);
        frame.time = number(needed("Time")?).context("Time")?;
        frame.walls = entry("Walls")
            .map_or(Ok(Vec::new()), numbers)
            .context("Walls")?;
        ensure!(
            frame.walls.len().is_multiple_of(5),
            "Walls: expected five numbers a wall"
        );
        frame.edges = entry("Edges")
            .map_or(Ok(Vec::new()), edges)
            .context("Edges")?;
        let ellipses = entry("Ellipses").map_or(Ok(Vec::new()), numbers);
        let ellipses = ellipses.context("Ellipses")?;
        let (rows, rest) = ellipses.as_chunks::<4>();
        ensure!(
            rest.is_empty(),
            "Ellipses: expected four numbers an ellipse"
        );
        frame.ellipses = rows.to_vec();
        for (name, kinds) in [("Solid", &mut frame.solid), ("Uniform", &mut frame.uniform)] {
            let list = entry(name).map_or(Ok(Vec::new()), numbers);
            let list = list.and_then(|list| list.into_iter().map(whole).collect());
            *kinds = list.context(name)?;
        }
        let bonds = entry("Bonds").map_or(Ok(Vec::new()), numbers);
        let bonds = bonds.and_then(|list| {
            let (pairs, []) = list.as_chunks::<2>() else {
                bail!("expected two atoms a bond");
            };
            let pair = |&[a, b]: &[f64; 2]| Ok([whole(a)?, whole(b)?]);
            pairs.iter().map(pair).collect()
        });
        frame.bonds = bonds.context("Bonds")?;
        let kinds = entry("Kinds").unwrap_or_default();
        frame.kinds = kinds.split_ascii_whitespace().map(str::to_owned).collect();
        places(needed("Properties")?).context("Properties")
    }

    fn atom(&self, columns: &Places) -> Result<AtomLine> {
        let words = AtomWords {
            words: self.line.split_ascii_whitespace().collect(),
            columns,
        };
        let kind = words.whole(9)?;
        Ok(AtomLine {
            is_fixed: words.word(0, 0)? == "X",
            position: words.planar(1)?,
            image: [words.boxes(0)?, words.boxes(1)?],
            velocity: words.planar(2)?,
            molecule: words.whole(3)?,
            index: words.whole(4)?,
            radius: words.positive(5)?,
            angle: words.real(6, 0)?,
            angular_velocity: words.real(7, 0)?,
            mass: words.positive(8)?,
            kind: kind
                .try_into()
                .with_context(|| format!("column kind: {kind} is too large"))?,
        })
    }
}

/// The words of the line of an atom. A column is an index of [`COLUMNS`].
struct AtomWords<'a> {
    words: Vec<&'a str>,
    columns: &'a Places,
}

impl<'a> AtomWords<'a> {
    /// A word of a column, from 0.
    fn word(&self, column: usize, offset: usize) -> Result<&'a str> {
        let name = COLUMNS[column].0;
        let place = self.columns[column].map(|first| first + offset);
        place
            .and_then(|place| self.words.get(place).copied())
            .with_context(|| format!("the column {name} is missing"))
    }

    /// A number of a column, from 0.
    fn real(&self, column: usize, offset: usize) -> Result<f64> {
        number(self.word(column, offset)?).with_context(|| format!("column {}", COLUMNS[column].0))
    }

    /// The vector of a column, which must lie in the plane.
    fn planar(&self, column: usize) -> Result<[f64; 2]> {
        let [x, y, z] = [
            self.real(column, 0)?,
            self.real(column, 1)?,
            self.real(column, 2)?,
        ];
        let name = COLUMNS[column].0;
        ensure!(
            z == 0.0,
            "column {name}: there must be two numbers [x, y] and a third that is 0, but there is [{x:?}, {y:?}, {z:?}]"
        );
        Ok([x, y])
    }

    /// The natural number of a column.
    fn whole(&self, column: usize) -> Result<u64> {
        let text = self.word(column, 0)?;
        text.parse().ok().with_context(|| {
            format!(
                "column {}: '{text}' is not a number from 0",
                COLUMNS[column].0
            )
        })
    }

    /// The positive number of a column.
    fn positive(&self, column: usize) -> Result<f64> {
        let value = self.real(column, 0)?;
        ensure!(
            value > 0.0,
            "column {}: {value} is not positive",
            COLUMNS[column].0
        );
        Ok(value)
    }

    /// Boxes that the molecule has crossed along an axis.
    fn boxes(&self, axis: usize) -> Result<i32> {
        if self.columns[10].is_none() {
            return Ok(0);
        }
        let text = self.word(10, axis)?;
        text.parse()
            .ok()
            .with_context(|| format!("column map_shift: '{text}' is not a number of boxes"))
    }
}

/// The entries `key=value` or `key="value"` of a comment line.
fn entries(line: &str) -> Result<Vec<(&str, &str)>> {
    let mut entries = Vec::new();
    let mut rest = line.trim_start();
    while !rest.is_empty() {
        let (key, after) = rest
            .split_once('=')
            .with_context(|| format!("'{}' is not key=value", shortened(rest)))?;
        let (value, after) = match after.strip_prefix('"') {
            Some(quoted) => quoted
                .split_once('"')
                .with_context(|| format!("{key}: no closing quote"))?,
            None => after.split_once(' ').unwrap_or((after, "")),
        };
        entries.push((key, value));
        rest = after.trim_start();
    }
    Ok(entries)
}

/// The places of the columns in a line.
fn places(properties: &str) -> Result<Places> {
    let words: Vec<&str> = properties.split(':').collect();
    let (columns, []) = words.as_chunks::<3>() else {
        bail!("expected name:type:count, repeated");
    };
    let mut found = [None; COLUMNS.len()];
    let mut place = 0usize;
    for [name, kind, count] in columns {
        let count: usize = count
            .parse()
            .ok()
            .with_context(|| format!("{name}: '{count}' is not a count"))?;
        if let Some(index) = COLUMNS.iter().position(|column| column.0 == *name) {
            let (_, expected, values) = COLUMNS[index];
            let fits = *kind == expected.to_string() && count == values;
            ensure!(
                fits,
                "{name}: {kind}:{count} instead of {expected}:{values}"
            );
            found[index] = Some(place);
        }
        place = place
            .checked_add(count)
            .with_context(|| format!("{name}: {count} values"))?;
    }
    for (place, (name, ..)) in found.iter().zip(COLUMNS).take(COLUMNS.len() - 1) {
        ensure!(
            place.is_some(),
            "the column {name} is missing; a run writes it"
        );
    }
    Ok(found)
}

/// The edges of the comment line, four numbers each.
fn edges(text: &str) -> Result<Vec<KindEdge>> {
    let numbers = numbers(text)?;
    let (rows, []) = numbers.as_chunks::<4>() else {
        bail!("expected four numbers an edge: kind, two atoms, relative radius");
    };
    let edge = |&[kind, first, second, share]: &[f64; 4]| {
        ensure!(
            share > 0.0 && share <= 1.0,
            "the relative radius {share} is not between 0 and 1"
        );
        Ok(KindEdge {
            kind: whole(kind)?,
            ends: [whole(first)?, whole(second)?],
            share,
        })
    };
    rows.iter().map(edge).collect()
}

/// A number without fraction.
fn whole(value: f64) -> Result<u32> {
    let number = value as u32;
    ensure!(f64::from(number) == value, "{value} is not a number from 0");
    Ok(number)
}

fn numbers(text: &str) -> Result<Vec<f64>> {
    text.split_ascii_whitespace().map(number).collect()
}

fn number(text: &str) -> Result<f64> {
    let value: f64 = text
        .parse()
        .ok()
        .with_context(|| format!("'{}' is not a number", shortened(text)))?;
    ensure!(value.is_finite(), "{value} is not finite");
    Ok(value)
}

/// The beginning of a text, for messages.
fn shortened(text: &str) -> String {
    text.chars().take(40).collect()
}
