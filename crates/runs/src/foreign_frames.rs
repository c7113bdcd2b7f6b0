//! Frames of GSD files (HOOMD) and LAMMPS dumps as extended XYZ, so that bodies can start from
//! them.
//!
//! Of GSD the places, orientations and velocities of the particles are taken, without bodies whose
//! atoms are particles, too (see `convert/hoomd.rs`); of a dump the columns
//! `x y` (or `xs ys`, `xu yu`), `vx vy`, `radius`, `angle` and `omegaz`; atoms are sorted by `id`.
//! The lower left corner of their box becomes the origin.

use std::fmt::Write as _;

use anyhow::{Context as _, Result, bail, ensure};
use carom::engine::frame_of;

use crate::convert::hoomd::ATOMS;

/// The first eight bytes of a GSD file.
const GSD: [u8; 8] = 0x65DF_65DF_65DF_65DF_u64.to_le_bytes();

/// The first line of a LAMMPS dump.
const DUMP: &str = "ITEM: TIMESTEP";

/// Length of an entry of the index, and of the unit of the list of names (bytes).
const ENTRY: usize = 32;
const NAME: usize = 64;

/// Most atoms of a frame.
const MAX_ATOMS: usize = 1 << 27;

/// The text of one frame of a file, counted from 0, or of the last, as extended XYZ.
///
/// # Errors
/// The file is none of the three formats, is damaged, or has no such frame.
pub fn extended_xyz(bytes: &[u8], frame: Option<usize>) -> Result<String> {
    if bytes.starts_with(&GSD) {
        return Gsd::new(bytes)?.frame(frame);
    }
    let text = std::str::from_utf8(bytes)
        .ok()
        .context("it is neither text nor a GSD file")?;
    if text.trim_start().starts_with(DUMP) {
        return dump(text, frame);
    }
    Ok(frame_of(text, frame)
        .map_err(anyhow::Error::msg)?
        .to_owned())
}

/// One atom: columns of the frame that is written.
struct Atom {
    order: i64,
    place: [f64; 2],
    velocity: Option<[f64; 2]>,
    radius: Option<f64>,
    angle: Option<f64>,
    spin: Option<f64>,
}

/// Writes a frame; a column that not all atoms have is left out.
fn written(sides: [f64; 2], atoms: &[Atom]) -> String {
    let [x, y] = sides;
    let has = |of: fn(&Atom) -> bool| !atoms.is_empty() && atoms.iter().all(of);
    let velocities = has(|atom| atom.velocity.is_some());
    let radii = has(|atom| atom.radius.is_some());
    let angles = has(|atom| atom.angle.is_some());
    let spins = has(|atom| atom.spin.is_some());
    let mut columns = "species:S:1:pos:R:2".to_owned();
    for (is_there, name) in [
        (velocities, ":velo:R:2"),
        (radii, ":radius:R:1"),
        (angles, ":angle:R:1"),
        (spins, ":angular_velocity:R:1"),
    ] {
        columns.push_str(if is_there { name } else { "" });
    }
    let mut text = format!(
        "{}\nLattice=\"{x:?} 0 0 0 {y:?} 0 0 0 1\" Properties={columns}\n",
        atoms.len()
    );
    for atom in atoms {
        let mut numbers = atom.place.to_vec();
        numbers.extend(atom.velocity.filter(|_| velocities).into_iter().flatten());
        let rest = [
            (radii, atom.radius),
            (angles, atom.angle),
            (spins, atom.spin),
        ];
        numbers.extend(
            rest.into_iter()
                .filter(|(is_there, _)| *is_there)
                .filter_map(|(_, number)| number),
        );
        text.push('X');
        for number in numbers {
            // Writing to a string cannot fail.
            let _ = write!(text, " {number:?}");
        }
        text.push('\n');
    }
    text
}

/// A GSD file of the HOOMD schema.
struct Gsd<'a> {
    bytes: &'a [u8],
    names: Vec<&'a str>,
    /// Frame, rows, place, columns, number of the name, type.
    index: Vec<Chunk>,
}

#[derive(Clone, Copy)]
struct Chunk {
    frame: u64,
    rows: usize,
    at: usize,
    columns: usize,
    name: usize,
    kind: u8,
}

impl<'a> Gsd<'a> {
    fn new(bytes: &'a [u8]) -> Result<Self> {
        let [index_at, entries, names_at, names] =
            [8, 16, 24, 32].map(|at| number(bytes, at).unwrap_or(u64::MAX));
        let schema = bytes.get(112..176).unwrap_or_default();
        ensure!(
            schema.starts_with(b"hoomd\0"),
            "the GSD file has another schema than HOOMD's"
        );
        let part = |at: u64, count: u64, size: usize| -> Result<&'a [u8]> {
            let (at, count) = (usize::try_from(at)?, usize::try_from(count)?);
            let end = count
                .checked_mul(size)
                .and_then(|length| length.checked_add(at));
            end.and_then(|end| bytes.get(at..end))
                .context("the GSD file is cut or damaged")
        };
        let list = part(names_at, names, NAME)?.split(|byte| *byte == 0);
        let names = list
            .take_while(|name| !name.is_empty())
            .map(std::str::from_utf8)
            .collect::<Result<_, _>>()
            .context("the names in the GSD file are no text")?;
        let entry = |bytes: &[u8]| {
            let wide = |at: usize| number(bytes, at).unwrap_or(0);
            let half = |at: usize| {
                u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
            };
            Chunk {
                frame: wide(0),
                rows: wide(8) as usize,
                at: wide(16) as usize,
                columns: half(24) as usize,
                name: usize::from(u16::from_le_bytes([bytes[28], bytes[29]])),
                kind: bytes[30],
            }
        };
        let index = part(index_at, entries, ENTRY)?
            .chunks_exact(ENTRY)
            .map(entry);
        // Unused entries at the end have no place.
        let index = index.take_while(|chunk| chunk.at != 0).collect();
        Ok(Self {
            bytes,
            names,
            index,
        })
    }

    /// The chunk of this name in a frame, or else in the first frame, whose values are defaults.
    fn chunk(&self, name: &str, frame: u64) -> Option<Chunk> {
        let number = self.names.iter().position(|known| *known == name)?;
        let of = |frame: u64| {
            self.index
                .iter()
                .find(|chunk| chunk.name == number && chunk.frame == frame)
        };
        of(frame).or_else(|| of(0)).copied()
    }

    /// Rows of numbers; `None` if the chunk is absent.
    fn floats(&self, name: &str, frame: u64, columns: usize) -> Result<Option<Vec<Vec<f64>>>> {
        let Some(chunk) = self.chunk(name, frame) else {
            return Ok(None);
        };
        let size = match chunk.kind {
            9 => 4,
            10 => 8,
            other => bail!("'{name}' is no array of floating-point numbers, but of type {other}"),
        };
        ensure!(chunk.rows <= MAX_ATOMS, "'{name}' has {} rows", chunk.rows);
        let all = chunk
            .rows
            .checked_mul(chunk.columns)
            .and_then(|count| count.checked_mul(size));
        let end = all.and_then(|length| length.checked_add(chunk.at));
        let bytes = end.and_then(|end| self.bytes.get(chunk.at..end));
        let bytes = bytes.with_context(|| format!("'{name}' lies outside the file"))?;
        let value = |bytes: &[u8]| match *bytes {
            [a, b, c, d] => f64::from(f32::from_le_bytes([a, b, c, d])),
            [a, b, c, d, e, f, g, h] => f64::from_le_bytes([a, b, c, d, e, f, g, h]),
            _ => f64::NAN,
        };
        let numbers: Vec<f64> = bytes.chunks_exact(size).map(value).collect();
        ensure!(
            numbers.len().is_multiple_of(columns),
            "'{name}' has {} numbers, which are not rows of {columns}",
            numbers.len()
        );
        Ok(Some(
            numbers.chunks_exact(columns).map(<[f64]>::to_vec).collect(),
        ))
    }

    fn frame(&self, requested: Option<usize>) -> Result<String> {
        let frames = self
            .index
            .iter()
            .map(|chunk| chunk.frame.saturating_add(1))
            .max()
            .unwrap_or(0);
        let frame = requested.map_or(frames.saturating_sub(1), |requested| requested as u64);
        ensure!(
            frame < frames,
            "the file has {frames} frames, numbered from 0; {frame} is out of range"
        );
        let edges = self
            .floats("configuration/box", frame, 6)?
            .context("the file has no box")?;
        let edges = edges.first().context("the file has no box")?;
        let [x, y, xy] = [edges[0], edges[1], edges[3]];
        ensure!(
            xy == 0.0,
            "the box is sheared (xy = {xy}), but carom's is a rectangle"
        );
        let places = self
            .floats("particles/position", frame, 3)?
            .context("the file has no places")?;
        let count = places.len();
        let of_atoms = |name: &str, columns: usize| -> Result<Option<Vec<Vec<f64>>>> {
            Ok(self
                .floats(name, frame, columns)?
                .filter(|rows| rows.len() == count))
        };
        let velocities = of_atoms("particles/velocity", 3)?;
        let orientations = of_atoms("particles/orientation", 4)?;
        let atom = |(index, place): (usize, &Vec<f64>)| Atom {
            order: index as i64,
            place: [place[0] + 0.5 * x, place[1] + 0.5 * y],
            velocity: velocities
                .as_ref()
                .map(|rows| [rows[index][0], rows[index][1]]),
            radius: None,
            angle: orientations
                .as_ref()
                .map(|rows| 2.0 * rows[index][3].atan2(rows[index][0])),
            spin: None,
        };
        let is_body = self.bodies(frame);
        let atoms: Vec<Atom> = places
            .iter()
            .enumerate()
            .filter(|(index, _)| !is_body.get(*index).is_some_and(|&is_body| is_body))
            .map(atom)
            .collect();
        Ok(written([x, y], &atoms))
    }

    /// Whether each particle is a body whose atoms are particles, too; empty if there is none.
    fn bodies(&self, frame: u64) -> Vec<bool> {
        let Some(names) = self.chunk("particles/types", frame) else {
            return Vec::new();
        };
        let bytes = self.rows(names, 1).unwrap_or_default();
        let names: Vec<&[u8]> = bytes
            .chunks_exact(names.columns.max(1))
            .map(|row| row.split(|byte| *byte == 0).next().unwrap_or_default())
            .collect();
        let has_atoms = |name: &[u8]| names.contains(&&[name, ATOMS.as_bytes()].concat()[..]);
        let is_body: Vec<bool> = names.iter().map(|name| has_atoms(name)).collect();
        if !is_body.contains(&true) {
            return Vec::new();
        }
        let Some(types) = self.chunk("particles/typeid", frame) else {
            return Vec::new();
        };
        let numbers = self.rows(types, 4).unwrap_or_default();
        numbers
            .as_chunks::<4>()
            .0
            .iter()
            .map(|&bytes| is_body.get(u32::from_le_bytes(bytes) as usize) == Some(&true))
            .collect()
    }

    /// The bytes of a chunk of values of this size (bytes).
    fn rows(&self, chunk: Chunk, size: usize) -> Option<&'a [u8]> {
        let length = chunk.rows.checked_mul(chunk.columns)?.checked_mul(size)?;
        self.bytes.get(chunk.at..chunk.at.checked_add(length)?)
    }
}

fn number(bytes: &[u8], at: usize) -> Option<u64> {
    let eight: [u8; 8] = bytes.get(at..at + 8)?.try_into().ok()?;
    Some(u64::from_le_bytes(eight))
}

/// A frame of a LAMMPS dump.
fn dump(text: &str, requested: Option<usize>) -> Result<String> {
    let starts: Vec<usize> = text.match_indices(DUMP).map(|(at, _)| at).collect();
    let frame = requested.unwrap_or(starts.len() - 1);
    let begin = *starts.get(frame).with_context(|| {
        format!(
            "the file has {} frames, numbered from 0; {frame} is out of range",
            starts.len()
        )
    })?;
    let end = starts.get(frame + 1).copied().unwrap_or(text.len());
    let first = text[..begin].lines().count() + 1;
    let mut lines = text[begin..end]
        .lines()
        .enumerate()
        .map(|(index, line)| (first + index, line.trim()));
    let (mut count, mut bounds) = (None, Vec::new());
    while let Some((number, line)) = lines.next() {
        let line_of = || format!("line {number}");
        if line == "ITEM: NUMBER OF ATOMS" {
            let (number, line) = lines.next().context("the frame ends after its head")?;
            let found: usize = line
                .parse()
                .ok()
                .with_context(|| format!("line {number}: '{line:.40}'"))?;
            ensure!(
                found <= MAX_ATOMS,
                "line {number}: {found} atoms are more than {MAX_ATOMS}"
            );
            count = Some(found);
        } else if line.starts_with("ITEM: BOX BOUNDS") {
            ensure!(
                !line.contains("xy"),
                "line {number}: the box is sheared, but carom's is a rectangle"
            );
            for _ in 0..2 {
                let (number, line) = lines.next().context("the frame ends within its box")?;
                bounds.push(numbers(line).with_context(|| format!("line {number}"))?);
            }
        } else if let Some(names) = line.strip_prefix("ITEM: ATOMS") {
            let columns: Vec<&str> = names.split_whitespace().collect();
            let count = count.with_context(line_of)?;
            let [x, y] = &bounds[..] else {
                bail!("line {number}: the box is missing before the atoms")
            };
            let [&[left, right, ..], &[low, high, ..]] = [&x[..], &y[..]] else {
                bail!("line {number}: a bound of the box is no pair of numbers")
            };
            let (corner, sides) = ([left, low], [right - left, high - low]);
            let atoms = atoms(lines.by_ref().take(count), &columns, corner, sides)?;
            ensure!(
                atoms.len() == count,
                "the frame must have {count} atoms, but has {}",
                atoms.len()
            );
            return Ok(written(sides, &atoms));
        }
    }
    bail!("line {first}: the frame has no atoms")
}

/// The atoms of numbered lines, in their order, in a box with this lower left corner.
fn atoms<'a>(
    lines: impl Iterator<Item = (usize, &'a str)>,
    columns: &[&str],
    corner: [f64; 2],
    sides: [f64; 2],
) -> Result<Vec<Atom>> {
    let mut atoms = Vec::new();
    for (number, line) in lines {
        let values = numbers(line).with_context(|| format!("line {number}"))?;
        let atom = atom(columns, &values, corner, sides);
        atoms.push(atom.with_context(|| format!("line {number}"))?);
    }
    atoms.sort_by_key(|atom| atom.order);
    Ok(atoms)
}

/// The numbers of a line; a word, such as an element, counts as NaN.
fn numbers(line: &str) -> Result<Vec<f64>> {
    let numbers: Vec<f64> = line
        .split_whitespace()
        .map(|word| word.parse().unwrap_or(f64::NAN))
        .collect();
    ensure!(!numbers.is_empty(), "it is empty");
    Ok(numbers)
}

fn atom(columns: &[&str], values: &[f64], corner: [f64; 2], sides: [f64; 2]) -> Result<Atom> {
    let of = |name: &str| {
        let place = columns.iter().position(|column| *column == name)?;
        values.get(place).copied().filter(|value| value.is_finite())
    };
    let both = |[x, y]: [&str; 2]| of(x).zip(of(y)).map(|(x, y)| [x, y]);
    let absolute = both(["x", "y"]).or_else(|| both(["xu", "yu"]));
    let absolute = absolute.map(|place| [place[0] - corner[0], place[1] - corner[1]]);
    let scaled = both(["xs", "ys"]).map(|share| [share[0] * sides[0], share[1] * sides[1]]);
    Ok(Atom {
        order: of("id").map_or(0, |id| id as i64),
        place: absolute
            .or(scaled)
            .context("the atom has no columns x y, xu yu or xs ys")?,
        velocity: both(["vx", "vy"]),
        radius: of("radius"),
        angle: of("angle"),
        spin: of("omegaz"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::convert::convert;
    use carom::{Scene, engine::Simulation, observers::write_extended_xyz};

    const TWO_FRAMES: &str = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n-1.0 1.0\n\
        -2.0 2.0\n-0.5 0.5\nITEM: ATOMS id type x y z vx vy\n2 1 0.5 0.5 0 1.0 2.0\n1 1 -0.5 -1.5 0 3.0 4.0\n\
        ITEM: TIMESTEP\n10\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS pp pp pp\n0 1\n0 1\n0 1\n\
        ITEM: ATOMS id element xs ys\n1 Ar 0.25 0.75\n";

    /// A body with edges is a particle of its own in GSD, which is left out when its atoms are
    /// read.
    #[test]
    fn atoms_of_a_body_with_edges_are_read_back_from_gsd() {
        let scene = "[[molecule]]\nshape = \"square\"\nsize = 0.2\nmass = 1.0\nat = [0.3, 0.4]\norientation = 0.7\n";
        let simulation = Simulation::new(&Scene::from_toml(scene).unwrap()).unwrap();
        let mut original = Vec::new();
        write_extended_xyz(&simulation.view(), &mut original).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let paths = ["in.extxyz", "out.gsd"].map(|name| folder.path().join(name));
        std::fs::write(&paths[0], &original).unwrap();
        convert(&paths[0], &paths[1]).unwrap();
        let back = extended_xyz(&std::fs::read(&paths[1]).unwrap(), None).unwrap();
        let original = String::from_utf8(original).unwrap();
        assert_eq!(back.lines().next(), Some("4"));
        let place = |line: &str| -> Vec<f64> {
            let words = line.split_whitespace().skip(1).take(2);
            words.map(|word| word.parse().unwrap()).collect()
        };
        for (back, line) in back.lines().zip(original.lines()).skip(2) {
            for (found, expected) in place(back).iter().zip(place(line)) {
                assert!((found - expected).abs() < 1e-6, "{back}\n{line}");
            }
        }
    }

    #[test]
    fn atoms_of_a_dump_are_sorted_and_shifted() {
        let first = extended_xyz(TWO_FRAMES.as_bytes(), Some(0)).unwrap();
        assert_eq!(
            first,
            "2\nLattice=\"2.0 0 0 0 4.0 0 0 0 1\" Properties=species:S:1:pos:R:2:velo:R:2\n\
             X 0.5 0.5 3.0 4.0\nX 1.5 2.5 1.0 2.0\n"
        );
        let last = extended_xyz(TWO_FRAMES.as_bytes(), None).unwrap();
        assert!(last.ends_with("pos:R:2\nX 0.25 0.75\n"), "{last}");
        for (text, expected) in [
            (
                TWO_FRAMES.replace("1 Ar 0.25", "1 Ar what"),
                "no columns x y",
            ),
            (TWO_FRAMES.replace("0 1\n0 1\n0 1", "0 1\n0"), "pair"),
            (
                TWO_FRAMES.replace("ATOMS\n1\n", "ATOMS\n7\n"),
                "must have 7 atoms, but has 1",
            ),
        ] {
            let error = format!("{:#}", extended_xyz(text.as_bytes(), None).unwrap_err());
            assert!(error.contains(expected), "{error}");
        }
        assert!(extended_xyz(TWO_FRAMES.as_bytes(), Some(2)).is_err());
    }

    /// A gas of dumbbells starts again from what `convert` has written of it.
    #[test]
    fn a_gas_starts_from_its_own_frames_in_other_formats() {
        let text = "[box]\nsides = [3.0, 2.0]\n[[gas]]\nshape = \"dumbbell\"\natom_radius = 0.05\natom_mass = 1.0\n\
                    temperature = 1.0\ncount = 20\n";
        let scene = Scene::from_toml(text).unwrap();
        let simulation = Simulation::new(&scene).unwrap();
        let root = tempfile::tempdir().unwrap();
        let path = |name: &str| root.path().join(name);
        let mut frame = Vec::new();
        write_extended_xyz(&simulation.view(), &mut frame).unwrap();
        std::fs::write(path("a.extxyz"), frame).unwrap();
        for (name, tolerance) in [("a.gsd", 1e-6), ("a.lammpstrj", 1e-14)] {
            convert(&path("a.extxyz"), &path(name)).unwrap();
            let read = extended_xyz(&std::fs::read(path(name)).unwrap(), None).unwrap();
            let mut again = scene.clone();
            again.start.from = Some(name.to_owned());
            again.start.snapshot = Some(read.into());
            let again = Simulation::new(&again).unwrap();
            for (one, other) in simulation.view().bodies().zip(again.view().bodies()) {
                let (one, other) = (one.motion, other.motion);
                let away = (one.position - other.position).length();
                assert!(away < 2.0 * tolerance, "{name}: {one:?} {other:?}");
                assert!(
                    (one.velocity - other.velocity).length() < 10.0 * tolerance,
                    "{name}"
                );
                let turned = one.orientation.cos_sin() - other.orientation.cos_sin();
                assert!(
                    turned.length() < 10.0 * tolerance,
                    "{name}: {one:?} {other:?}"
                );
            }
        }
    }

    #[test]
    fn damaged_files_are_refused_or_read_without_a_panic() {
        let whole = TWO_FRAMES.as_bytes();
        for at in 0..whole.len() {
            for byte in [0, b'\n', b'9', b'-', 255] {
                let mut changed = whole.to_vec();
                changed[at] = byte;
                let _ = extended_xyz(&changed, None);
            }
            let _ = extended_xyz(&whole[..at], None);
            let mut gsd = GSD.to_vec();
            gsd.extend(&whole[..at]);
            assert!(extended_xyz(&gsd, None).is_err());
        }
    }
}
