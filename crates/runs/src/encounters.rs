//! The encounter file: pairs of freely moving molecules in the plane, one a line, with their first
//! contact where it is known.
//!
//! Columns, by name and in any order (others are ignored):
//!
//! | column | content |
//! | --- | --- |
//! | `class`, `id` | labels, passed through |
//! | `xA`, `yA`, `vxA`, `vyA` | position and velocity of A's centre of mass at time 0 |
//! | `thA`, `wA` | A's orientation (radians) and angular velocity, counter-clockwise |
//! | `atomsA` | A's atoms, `x:y:m:r` (offset in any frame, mass, radius) joined by `;` |
//! | `edgesA` | A's straight edges, `i:j:r` (atoms at its ends from 0, radius) joined by `;`; optional |
//! | `xB` to `edgesB` | B, as for A |
//! | `window_end` | end of the search (time); default: until the bounding circles separate |
//! | `t_first` | time of the first contact, or `none`; optional |
//! | `atomA`, `atomB` | its atoms; optional |
//!
//! Columns `ellipsesA` and `ellipsesB` list ellipses, `x:y:m:a:b:angle` joined by `;`, with the
//! half axes a and b and the direction of a in the frame of the body (radians). Bodies with edges
//! and ellipses, and those whose ellipses overlap, are not supported; their rows are listed as
//! such.

use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use carom_geometry::{Atom, Ellipse, GeometryError, Interior, MAX_MAGNITUDE, Molecule};
use carom_kinematics::{Motion, Orientation, RelativeMotion};
use csv::StringRecord;
use glam::DVec2;

/// Two moving molecules, and their first contact if it is known.
#[derive(Debug, Clone)]
pub struct EncounterRecord {
    /// Class of the case.
    pub class: String,
    /// Name within the class.
    pub id: String,
    /// The molecules A and B.
    pub molecules: [Molecule; 2],
    /// Their motions from time 0 on.
    pub motions: [Motion; 2],
    /// End of the search (time), if the file gives it.
    pub window_end: Option<f64>,
    /// The first contact up to the end of the window, if the file gives it.
    pub expected: Option<ExpectedAnswer>,
}

/// First contact given in the file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ExpectedAnswer {
    /// There is none up to the end of the window.
    Free,
    /// The molecules touch.
    Contact {
        /// Time of the contact.
        time: f64,
        /// Atoms of A and of B, from 0 in the order of the file, if the file gives them.
        atoms: Option<(u32, u32)>,
    },
}

impl EncounterRecord {
    /// Motion of B relative to A from `time`.
    pub fn pair_at(&self, time: f64) -> RelativeMotion {
        RelativeMotion::between(&self.motions[0], &self.motions[1], DVec2::ZERO, time)
    }
}

/// A row of an encounter file.
#[derive(Debug, Clone)]
pub enum EncounterRow {
    /// Two molecules of atoms and edges.
    Pair(Box<EncounterRecord>),
    /// A body has ellipses that overlap, or that have edges beside them.
    Unsupported {
        /// Class of the case.
        class: String,
        /// Name within the class.
        id: String,
    },
}

/// Reads the pairs of an encounter file that are supported.
///
/// # Errors
/// See [`rows`].
pub fn read(path: &Path) -> Result<Vec<EncounterRecord>> {
    let pair = |row| match row {
        EncounterRow::Pair(pair) => Some(*pair),
        EncounterRow::Unsupported { .. } => None,
    };
    Ok(rows(path)?.into_iter().filter_map(pair).collect())
}

/// Reads all rows of an encounter file.
///
/// # Errors
/// An entry is invalid; the message names its line and column.
pub fn rows(path: &Path) -> Result<Vec<EncounterRow>> {
    let name = || format!("encounter file {}", path.display());
    let mut reader = csv::Reader::from_path(path).with_context(name)?;
    let headers = reader.headers().with_context(name)?.clone();
    for column in COLUMNS_OF_A.iter().chain(&COLUMNS_OF_B) {
        ensure!(
            headers.iter().any(|header| header == *column),
            "{}: the column `{column}` is missing",
            name()
        );
    }
    let mut encounters = Vec::new();
    for record in reader.records() {
        let record = record.with_context(name)?;
        let line = record.position().map_or(0, csv::Position::line);
        let row = Row {
            headers: &headers,
            record: &record,
        };
        let row = row
            .row()
            .with_context(|| format!("{}, line {line}", name()))?;
        encounters.push(row);
    }
    Ok(encounters)
}

/// Names of the required columns of one molecule: x, y, vx, vy, orientation, angular velocity,
/// atoms.
type Columns = [&'static str; 7];
const COLUMNS_OF_A: Columns = ["xA", "yA", "vxA", "vyA", "thA", "wA", "atomsA"];
const COLUMNS_OF_B: Columns = ["xB", "yB", "vxB", "vyB", "thB", "wB", "atomsB"];

struct Row<'a> {
    headers: &'a StringRecord,
    record: &'a StringRecord,
}

impl Row<'_> {
    fn row(&self) -> Result<EncounterRow> {
        let has_both = |body: &str| {
            let is_given = |part: &str| self.given(&format!("{part}{body}")).is_some();
            is_given("ellipses") && is_given("edges")
        };
        if !(has_both("A") || has_both("B")) {
            match self.encounter() {
                Err(error) if overlaps(&error) => {}
                other => return Ok(EncounterRow::Pair(Box::new(other?))),
            }
        }
        Ok(EncounterRow::Unsupported {
            class: self.text("class")?.to_owned(),
            id: self.text("id")?.to_owned(),
        })
    }

    fn encounter(&self) -> Result<EncounterRecord> {
        let (molecule_a, motion_a) = self.body(COLUMNS_OF_A, "edgesA", "ellipsesA")?;
        let (molecule_b, motion_b) = self.body(COLUMNS_OF_B, "edgesB", "ellipsesB")?;
        Ok(EncounterRecord {
            class: self.text("class")?.to_owned(),
            id: self.text("id")?.to_owned(),
            molecules: [molecule_a, molecule_b],
            motions: [motion_a, motion_b],
            window_end: self.window_end()?,
            expected: self.expected()?,
        })
    }

    fn body(
        &self,
        [x, y, vx, vy, orientation, spin, atoms]: Columns,
        edges: &str,
        ellipses: &str,
    ) -> Result<(Molecule, Motion)> {
        let motion = Motion {
            position: DVec2::new(self.number(x)?, self.number(y)?),
            velocity: DVec2::new(self.number(vx)?, self.number(vy)?),
            orientation: Orientation::from_radians(self.number(orientation)?),
            angular_velocity: self.number(spin)?,
            time: 0.0,
        };
        if let Some(text) = self.given(ellipses) {
            let round = self.given(atoms).unwrap_or_default().split(';');
            let round = round.filter(|text| !text.is_empty()).map(round_part);
            let parts = text.split(';').map(ellipse).chain(round);
            let parts: Vec<(DVec2, Ellipse, f64)> = parts
                .collect::<Result<_>>()
                .with_context(|| format!("columns `{atoms}` and `{ellipses}`"))?;
            return Ok((Molecule::of_ellipses(parts)?, motion));
        }
        let column = || format!("column `{atoms}`");
        let list: Vec<Atom> = self
            .text(atoms)?
            .split(';')
            .map(atom)
            .collect::<Result<_>>()
            .with_context(column)?;
        let edges_given = self.given(edges).unwrap_or_default();
        let edge_list: Vec<([u32; 2], f64)> = edges_given
            .split(';')
            .filter(|text| !text.is_empty())
            .map(edge)
            .collect::<Result<_>>()
            .with_context(|| format!("column `{edges}`"))?;
        let molecule = Molecule::with_edges(list, &edge_list, Interior::Hollow)
            .with_context(|| format!("columns `{atoms}` and `{edges}`"))?;
        Ok((molecule, motion))
    }

    fn window_end(&self) -> Result<Option<f64>> {
        let Some(text) = self.given("window_end") else {
            return Ok(None);
        };
        let end: f64 = text
            .parse()
            .ok()
            .with_context(|| format!("column `window_end`: '{text}'"))?;
        ensure!(
            end.is_finite() && end >= 0.0,
            "column `window_end`: {end} is not a finite time of at least 0"
        );
        Ok(Some(end))
    }

    fn expected(&self) -> Result<Option<ExpectedAnswer>> {
        let Some(first) = self.given("t_first") else {
            return Ok(None);
        };
        if first == "none" {
            return Ok(Some(ExpectedAnswer::Free));
        }
        let atom = |name| -> Result<u32> {
            let text = self.text(name)?;
            text.parse()
                .ok()
                .with_context(|| format!("column `{name}`: '{text}' is not the index of an atom"))
        };
        Ok(Some(ExpectedAnswer::Contact {
            time: self.number("t_first")?,
            atoms: match ["atomA", "atomB"].map(|name| self.given(name)) {
                [Some(_), Some(_)] => Some((atom("atomA")?, atom("atomB")?)),
                _ => None,
            },
        }))
    }

    /// Parses a number of magnitude at most [`MAX_MAGNITUDE`].
    fn number(&self, name: &str) -> Result<f64> {
        number(self.text(name)?).with_context(|| format!("column `{name}`"))
    }

    /// Text of a column, unless it is missing or empty.
    fn given(&self, name: &str) -> Option<&str> {
        let index = self
            .headers
            .iter()
            .position(|header| header.trim() == name)?;
        self.record
            .get(index)
            .map(str::trim)
            .filter(|text| !text.is_empty())
    }

    fn text(&self, name: &str) -> Result<&str> {
        self.given(name)
            .with_context(|| format!("column `{name}` is missing or empty"))
    }
}

fn number(text: &str) -> Result<f64> {
    let value: f64 = text
        .trim()
        .parse()
        .ok()
        .with_context(|| format!("'{text}' is not a number"))?;
    ensure!(
        value.abs() <= MAX_MAGNITUDE,
        "{value} is not between −1e60 and 1e60"
    );
    Ok(value)
}

/// Parses an atom from `x:y:m:r`.
fn atom(text: &str) -> Result<Atom> {
    let numbers: Vec<f64> = text.split(':').map(number).collect::<Result<_>>()?;
    let [x, y, mass, radius] = numbers[..] else {
        bail!("'{text}' is not an atom, x:y:m:r")
    };
    Ok(Atom::new(DVec2::new(x, y), radius, mass)?)
}

/// Parses an atom from `x:y:m:r` as an ellipse of equal axes.
fn round_part(text: &str) -> Result<(DVec2, Ellipse, f64)> {
    let atom = atom(text)?;
    Ok((atom.offset(), Ellipse::round(atom.radius()), atom.mass()))
}

/// Parses an ellipse from `x:y:m:a:b:angle`.
fn ellipse(text: &str) -> Result<(DVec2, Ellipse, f64)> {
    let numbers: Vec<f64> = text.split(':').map(number).collect::<Result<_>>()?;
    let [x, y, mass, a, b, angle] = numbers[..] else {
        bail!("'{text}' is not an ellipse, x:y:m:a:b:angle")
    };
    let along = DVec2::from_angle(angle);
    let ellipse = if a >= b {
        Ellipse::new([a, b], along)?
    } else {
        Ellipse::new([b, a], along.perp())?
    };
    Ok((DVec2::new(x, y), ellipse, mass))
}

/// Whether a body is refused because its ellipses overlap.
fn overlaps(error: &anyhow::Error) -> bool {
    matches!(
        error.downcast_ref(),
        Some(GeometryError::EllipsesOverlap { .. })
    )
}

/// Parses an edge from `i:j:r`.
fn edge(text: &str) -> Result<([u32; 2], f64)> {
    let parts: Vec<&str> = text.split(':').map(str::trim).collect();
    let [first, second, radius] = parts[..] else {
        bail!("'{text}' is not an edge, i:j:r")
    };
    let index = |end: &str| -> Result<u32> {
        end.parse()
            .ok()
            .with_context(|| format!("'{end}' in '{text}' is not the index of an atom"))
    };
    Ok(([index(first)?, index(second)?], number(radius)?))
}
