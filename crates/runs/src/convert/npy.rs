//! Structured arrays of NumPy, `.npy`: rows of 64-bit numbers with a name for each column.
//!
//! A file is a magic number, a version, the length of the header, the header as a literal of
//! Python, and the rows (NEP 1, <https://numpy.org/neps/nep-0001-npy-format.html>; version 3.0 has
//! headers in UTF-8). `numpy.load(file)["time"]` is a column.

use std::io::{BufRead, Seek, SeekFrom, Write};

use anyhow::{Context as _, Result, ensure};

use super::frames::TrajectoryFrame;

/// Digits that are left for the number of rows: any that fits into 64 bits.
const DIGITS: usize = 20;

/// The length of everything before the rows is a multiple of this (bytes).
const ALIGNED: usize = 64;

/// Bytes before the header.
const HEAD: usize = 12;

/// Most columns of a table.
const MAX_COLUMNS: usize = 4096;

/// Columns of a trajectory, of which each row is an atom in a frame.
pub(super) const ATOMS: [&str; 15] = [
    "frame",
    "time",
    "body",
    "atom",
    "x",
    "y",
    "image_x",
    "image_y",
    "velocity_x",
    "velocity_y",
    "angle",
    "angular_velocity",
    "radius",
    "mass",
    "kind",
];

/// An array that is being written.
pub(super) struct Array<'a, W> {
    out: &'a mut W,
    names: Vec<String>,
    rows: u64,
}

impl<'a, W: Write + Seek> Array<'a, W> {
    /// Begins an array with these columns.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(super) fn new(out: &'a mut W, names: &[&str]) -> Result<Self> {
        let names = names.iter().map(|name| (*name).to_owned()).collect();
        let array = Self {
            out,
            names,
            rows: 0,
        };
        let header = array.header();
        array.out.write_all(&header)?;
        Ok(array)
    }

    /// Appends a row; a number that is not there is NaN.
    ///
    /// # Errors
    /// The file cannot be written, or the row has another number of columns.
    pub(super) fn row(&mut self, numbers: &[f64]) -> Result<()> {
        ensure!(
            numbers.len() == self.names.len(),
            "a row has {} cells, but there are {} columns",
            numbers.len(),
            self.names.len()
        );
        for number in numbers {
            self.out.write_all(&number.to_le_bytes())?;
        }
        self.rows += 1;
        Ok(())
    }

    /// Appends the atoms of a frame, whose columns are [`ATOMS`].
    ///
    /// # Errors
    /// The file cannot be written.
    pub(super) fn frame(&mut self, frame: &TrajectoryFrame, number: u64) -> Result<()> {
        for atom in &frame.atoms {
            let [x, y] = atom.position;
            let [image_x, image_y] = atom.image.map(f64::from);
            let [velocity_x, velocity_y] = atom.velocity;
            self.row(&[
                number as f64,
                frame.time,
                atom.molecule as f64,
                atom.index as f64,
                x,
                y,
                image_x,
                image_y,
                velocity_x,
                velocity_y,
                atom.angle,
                atom.angular_velocity,
                atom.radius,
                atom.mass,
                f64::from(atom.kind),
            ])?;
        }
        Ok(())
    }

    /// Writes the number of rows into the header, and returns it.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(super) fn end(self) -> Result<u64> {
        let header = self.header();
        self.out.seek(SeekFrom::Start(0))?;
        self.out.write_all(&header)?;
        self.out.seek(SeekFrom::End(0))?;
        Ok(self.rows)
    }

    /// Everything before the rows; it has one length for any number of rows.
    fn header(&self) -> Vec<u8> {
        let quoted = |name: &String| name.replace('\\', "\\\\").replace('\'', "\\'");
        let columns: Vec<String> = self
            .names
            .iter()
            .map(|name| format!("('{}', '<f8')", quoted(name)))
            .collect();
        let literal = |rows: &str| {
            format!(
                "{{'descr': [{}], 'fortran_order': False, 'shape': ({rows},), }}",
                columns.join(", ")
            )
        };
        let longest = HEAD + literal(&"9".repeat(DIGITS)).len() + 1;
        let length = longest.next_multiple_of(ALIGNED) - HEAD;
        let mut header = literal(&self.rows.to_string());
        header.push_str(&" ".repeat(length - header.len() - 1));
        header.push('\n');
        let mut bytes = b"\x93NUMPY\x03\x00".to_vec();
        bytes.extend((length as u32).to_le_bytes());
        bytes.extend(header.bytes());
        bytes
    }
}

/// Writes a CSV file of numbers as an array, and returns the number of its rows. Empty cells are
/// NaN.
///
/// # Errors
/// The file cannot be read or written, or a cell is no number; the message names the line.
pub(super) fn of_table(input: impl BufRead, out: &mut (impl Write + Seek)) -> Result<u64> {
    let mut lines = input.lines();
    let head = lines
        .next()
        .context("the file is empty")?
        .context("line 1")?;
    let names: Vec<&str> = head.split(',').map(str::trim).collect();
    ensure!(
        names.len() <= MAX_COLUMNS,
        "line 1: {} columns are more than {MAX_COLUMNS}",
        names.len()
    );
    let is_good =
        |index: usize| !names[index].is_empty() && !names[..index].contains(&names[index]);
    ensure!(
        (0..names.len()).all(is_good),
        "line 1: the columns must have different names"
    );
    let mut array = Array::new(out, &names)?;
    let mut row = Vec::with_capacity(names.len());
    for (index, line) in lines.enumerate() {
        let number = index + 2;
        let line = line.with_context(|| format!("line {number}"))?;
        row.clear();
        for cell in line.split(',').map(str::trim) {
            let value = if cell.is_empty() {
                Ok(f64::NAN)
            } else {
                cell.parse()
            };
            row.push(
                value
                    .ok()
                    .with_context(|| format!("line {number}: '{cell:.40}' is no number"))?,
            );
        }
        array.row(&row).with_context(|| format!("line {number}"))?;
    }
    array.end()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    #[test]
    fn a_table_is_an_array_with_its_names() {
        let mut out = Cursor::new(Vec::new());
        assert_eq!(
            of_table("time,cos_Δθ\n0.5,1\n1,\n".as_bytes(), &mut out).unwrap(),
            2
        );
        let bytes = out.into_inner();
        assert!(bytes.starts_with(b"\x93NUMPY\x03\x00"));
        let length = u32::from_le_bytes([bytes[8], bytes[9], bytes[10], bytes[11]]) as usize;
        assert_eq!((HEAD + length) % ALIGNED, 0);
        let header = std::str::from_utf8(&bytes[HEAD..HEAD + length]).unwrap();
        let expected = "{'descr': [('time', '<f8'), ('cos_Δθ', '<f8')], 'fortran_order': False, 'shape': (2,), }";
        assert_eq!(header.trim_end(), expected);
        let numbers: Vec<f64> = bytes[HEAD + length..]
            .chunks_exact(8)
            .map(|eight| f64::from_le_bytes(eight.try_into().unwrap()))
            .collect();
        assert_eq!((numbers.len(), &numbers[..3]), (4, &[0.5, 1.0, 1.0][..]));
        assert!(numbers[3].is_nan());
    }

    #[test]
    fn what_is_no_table_is_refused_with_its_line() {
        for (text, expected) in [
            ("", "empty"),
            ("a,a\n1,2\n", "different names"),
            (
                "a,b\n1,2\n1\n",
                "line 3: a row has 1 cells, but there are 2 columns",
            ),
            ("a\nx\n", "line 2: 'x' is no number"),
        ] {
            let error = of_table(text.as_bytes(), &mut Cursor::new(Vec::new())).unwrap_err();
            assert!(format!("{error:#}").contains(expected), "{error:#}");
        }
    }
}
