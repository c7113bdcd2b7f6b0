//! A trajectory in the HOOMD schema of GSD: each atom is a particle in a box about the origin.
//!
//! Particles have the orientation of their molecule and its number as `body` (-1 for a molecule of
//! one atom), the kind as type with its name and shape, and the diameter of the atom. The image
//! counts the boxes that the molecule has crossed, so that displacements have no jumps. Time is
//! `log/time`; the step is the number of the frame. Walls are `log/walls`, five numbers each, in
//! the coordinates of the scene. What does not change is in the first frame only, as the schema
//! provides.
//!
//! Bonds are between the two atoms nearest to the tied points.
//!
//! A body with straight edges is a particle at its centre of mass, with the shape `Polygon`, its
//! mass, and twice its bounding radius as diameter. Its atoms follow it, with the number of the
//! molecule as `body` as well, and the type of the body with [`ATOMS`] at the end.

use std::io::{Seek, Write};

use anyhow::{Context, Result, ensure};

use super::{
    body_shapes::{FrameWithBodies, KnownBodies},
    frames::{AtomLine, TrajectoryFrame},
    gsd::{Data, Writer},
};

/// Name and version of the schema.
const SCHEMA: (&str, [u16; 2]) = ("hoomd", [1, 4]);

/// End of the name of the type of the atoms of bodies that are particles, too.
pub(crate) const ATOMS: &str = ".atom";

/// Most kinds of molecules. More: a wrong number in the input takes much memory.
const MAX_KINDS: u32 = 1 << 16;

/// A chunk: name, data, number of columns.
type Chunk = (&'static str, Data, usize);

/// A trajectory that is being written.
pub(super) struct Trajectory<'a, W> {
    file: Writer<'a, W>,
    step: u64,
    bodies: KnownBodies,
    /// Number of particles and constant chunks of the first frame.
    first: Option<(usize, Vec<Chunk>)>,
    /// Whether the first frame has bonds: frames without any must then say so.
    begins_with_bonds: bool,
}

impl<'a, W: Write + Seek> Trajectory<'a, W> {
    pub(super) fn new(out: &'a mut W) -> Result<Self> {
        Ok(Self {
            file: Writer::new(out)?,
            step: 0,
            bodies: KnownBodies::default(),
            first: None,
            begins_with_bonds: false,
        })
    }

    /// Appends a frame.
    ///
    /// # Errors
    /// A number is too large or too small for single precision, or the file cannot be written.
    pub(super) fn write(&mut self, frame: &TrajectoryFrame) -> Result<()> {
        let kinds = number_of_kinds(&frame.atoms)?;
        let bodies = self.bodies.of_frame(frame, kinds)?;
        let particles = &bodies.particles[..];
        let constant = constant(frame, &bodies, kinds)?;
        self.file
            .chunk("configuration/step", &Data::U64(vec![self.step]), 1)?;
        for (index, (name, data, columns)) in constant.iter().enumerate() {
            // The defaults of a later frame are those of the first one if the numbers of particles
            // are equal.
            let is_default = self
                .first
                .as_ref()
                .is_some_and(|(count, first)| *count == particles.len() && first[index].1 == *data);
            if !is_default {
                self.file.chunk(name, data, *columns)?;
            }
        }
        for (name, data, columns) in changing(frame, particles)? {
            self.file.chunk(name, &data, columns)?;
        }
        self.begins_with_bonds |= self.step == 0 && !frame.bonds.is_empty();
        if self.begins_with_bonds || !frame.bonds.is_empty() {
            for (name, data, columns) in bonds(frame, &bodies)? {
                self.file.chunk(name, &data, columns)?;
            }
        }
        self.file.end_frame();
        self.step += 1;
        self.first.get_or_insert((particles.len(), constant));
        Ok(())
    }

    /// Completes the file.
    pub(super) fn end(self) -> Result<()> {
        Ok(self.file.end(SCHEMA.0, SCHEMA.1)?)
    }
}

/// The chunks that mostly do not change from frame to frame.
fn constant(
    frame: &TrajectoryFrame,
    bodies: &FrameWithBodies<'_>,
    kinds: u32,
) -> Result<Vec<Chunk>> {
    let [x, y] = [single(frame.sides[0])?, single(frame.sides[1])?];
    ensure!(
        x > 0.0 && y > 0.0,
        "the box {:?} is too small for single precision",
        frame.sides
    );
    let atoms = &bodies.particles[..];
    let count = u32::try_from(atoms.len()).context("more than 2³² atoms")?;
    let name = |kind: u32| {
        frame
            .kinds
            .get(kind as usize)
            .cloned()
            .unwrap_or_else(|| format!("kind {kind}"))
    };
    let of_atoms = bodies
        .atom_kinds
        .keys()
        .map(|&kind| format!("{}{ATOMS}", name(kind)));
    let names: Vec<String> = (0..kinds).map(name).chain(of_atoms).collect();
    let positive = |value: f64| -> Result<f32> {
        let value_single = single(value)?;
        ensure!(
            value_single > 0.0,
            "{value:e} is too small for single precision"
        );
        Ok(value_single)
    };
    let floats = |of: &dyn Fn(&AtomLine) -> Result<f32>| -> Result<Data> {
        Ok(Data::F32(atoms.iter().map(of).collect::<Result<_>>()?))
    };
    Ok(vec![
        // A box of two dimensions has no thickness.
        (
            "configuration/box",
            Data::F32(vec![
                x,
                y,
                0.0,
                single(frame.tilt / frame.sides[1])?,
                0.0,
                0.0,
            ]),
            1,
        ),
        ("configuration/dimensions", Data::U8(vec![2]), 1),
        ("particles/N", Data::U32(vec![count]), 1),
        texts("particles/types", &names),
        texts(
            "particles/type_shapes",
            &shapes(bodies, &frame.ellipses, names.len()),
        ),
        (
            "particles/typeid",
            Data::U32(atoms.iter().map(|atom| atom.kind).collect()),
            1,
        ),
        ("particles/mass", floats(&|atom| positive(atom.mass))?, 1),
        (
            "particles/diameter",
            floats(&|atom| positive(2.0 * atom.radius))?,
            1,
        ),
        ("particles/body", Data::I32(molecules(atoms)?), 1),
    ])
}

/// The number of kinds of molecules: their numbers are below it.
fn number_of_kinds(atoms: &[AtomLine]) -> Result<u32> {
    let kinds = atoms
        .iter()
        .map(|atom| atom.kind.saturating_add(1))
        .max()
        .unwrap_or(1);
    ensure!(
        kinds <= MAX_KINDS,
        "kind {}: at most {MAX_KINDS} kinds have a name",
        kinds - 1
    );
    Ok(kinds)
}

/// Texts as rows of equal length, filled with zeros.
fn texts(name: &'static str, texts: &[String]) -> Chunk {
    let longest = texts.iter().map(String::len).max().unwrap_or(0) + 1;
    let mut bytes = Vec::with_capacity(longest * texts.len());
    for text in texts {
        bytes.extend(text.bytes());
        bytes.resize(bytes.len() + longest - text.len(), 0);
    }
    (name, Data::I8(bytes), longest)
}

/// The shape of each kind: of bodies with edges a polygon, of ellipses an ellipsoid, of atoms a
/// disc, which the schema calls a sphere in two dimensions; none for a kind of several sizes.
fn shapes(bodies: &FrameWithBodies<'_>, ellipses: &[[f64; 4]], kinds: usize) -> Vec<String> {
    // Molecules of several ellipses are bodies of their own kind, without a shape.
    let axes_of = |kind: u32| {
        let of_kind = |row: &&[f64; 4]| row[0] == f64::from(kind);
        let mut rows = ellipses.iter().filter(of_kind);
        let first = rows.next()?;
        (rows.next().is_none() && first[3] == 0.0).then_some(first[2])
    };
    let mut radii: Vec<Vec<f64>> = vec![Vec::new(); kinds];
    for atom in bodies.particles.iter() {
        let radii = &mut radii[atom.kind as usize];
        if radii.len() < 2 && !radii.contains(&atom.radius) {
            radii.push(atom.radius);
        }
    }
    let none = || "{}".to_owned();
    let shape = |(kind, radii): (u32, &Vec<f64>)| match (bodies.shapes.get(&kind), &radii[..]) {
        (Some(shape), _) => shape.clone().unwrap_or_else(none),
        (None, [radius]) if axes_of(kind).is_some() => {
            let [b, a] = [axes_of(kind).unwrap_or(1.0) * radius, *radius];
            format!("{{\"type\": \"Ellipsoid\", \"a\": {a:?}, \"b\": {b:?}, \"c\": {b:?}}}")
        }
        (None, [radius]) => format!("{{\"type\": \"Sphere\", \"diameter\": {:?}}}", 2.0 * radius),
        (None, _) => none(),
    };
    (0..).zip(&radii).map(shape).collect()
}

/// The chunks of every frame.
fn changing(frame: &TrajectoryFrame, particles: &[AtomLine]) -> Result<Vec<Chunk>> {
    let (mut positions, mut images) = (Vec::new(), Vec::new());
    let (mut velocities, mut orientations) = (Vec::new(), Vec::new());
    for atom in particles {
        let [x, y] = atom.position;
        let (up, rows) = wrapped(y, frame.sides[1])?;
        // A tilted box is a parallelogram about the origin, which the row at height `up` shifts.
        let shift = frame.tilt * (y / frame.sides[1] - 0.5);
        let (across, columns) = wrapped(x - shift, frame.sides[0])?;
        let shift = shift - f64::from(rows) * frame.tilt;
        positions.extend([single(f64::from(across) + shift)?, up]);
        for (boxes, crossed) in [columns, rows].into_iter().zip(atom.image) {
            let image = boxes.checked_add(crossed);
            images.push(image.context("more than 2³¹ boxes crossed")?);
        }
        positions.push(0.0);
        images.push(0);
        velocities.extend([single(atom.velocity[0])?, single(atom.velocity[1])?, 0.0]);
        let (sine, cosine) = (0.5 * atom.angle).sin_cos();
        orientations.extend([cosine as f32, 0.0, 0.0, sine as f32]);
    }
    let mut chunks = vec![
        ("particles/position", Data::F32(positions), 3),
        ("particles/orientation", Data::F32(orientations), 4),
        ("particles/velocity", Data::F32(velocities), 3),
        ("particles/image", Data::I32(images), 3),
        ("log/time", Data::F64(vec![frame.time]), 1),
    ];
    if !frame.walls.is_empty() {
        chunks.push(("log/walls", Data::F64(frame.walls.clone()), 5));
    }
    Ok(chunks)
}

/// The chunks of the bonds, all of one type.
fn bonds(frame: &TrajectoryFrame, bodies: &FrameWithBodies<'_>) -> Result<Vec<Chunk>> {
    // A body with edges is a particle before its atoms.
    let is_atom = |particle: &AtomLine| !bodies.atom_kinds.contains_key(&particle.kind);
    let particles = (0..).zip(bodies.particles.iter());
    let atoms: Vec<u32> = particles
        .filter(|(_, particle)| is_atom(particle))
        .map(|(number, _)| number)
        .collect();
    let ends = frame.bonds.iter().flatten().map(|&atom| {
        let particle = atoms.get(atom as usize).copied();
        particle.with_context(|| format!("there is no atom {atom}"))
    });
    let ends: Vec<u32> = ends.collect::<Result<_>>()?;
    let count = u32::try_from(frame.bonds.len()).context("more than 2³² bonds")?;
    Ok(vec![
        ("bonds/N", Data::U32(vec![count]), 1),
        texts("bonds/types", &["tether".to_owned()]),
        ("bonds/typeid", Data::U32(vec![0; frame.bonds.len()]), 1),
        ("bonds/group", Data::U32(ends), 2),
    ])
}

/// The place of a particle in a box from −side/2 to side/2, and the number of boxes left behind,
/// for a place in a box from 0 to `side`.
fn wrapped(place: f64, side: f64) -> Result<(f32, i32)> {
    let mut image = (place / side).floor();
    let mut inside = single(place - image * side - 0.5 * side)?;
    if inside >= single(0.5 * side)? {
        (inside, image) = (single(-0.5 * side)?, image + 1.0);
    }
    ensure!(
        image.abs() < f64::from(i32::MAX),
        "the place {place} is too far from a box of side {side}"
    );
    Ok((inside, image as i32))
}

/// The number of the molecule of each atom; −1 for a molecule of one atom.
fn molecules(atoms: &[AtomLine]) -> Result<Vec<i32>> {
    let is_alone = |index: usize| {
        let same = |other: Option<&AtomLine>| {
            other.is_some_and(|other| other.molecule == atoms[index].molecule)
        };
        !same(index.checked_sub(1).and_then(|before| atoms.get(before)))
            && !same(atoms.get(index + 1))
    };
    let number = |(index, atom): (usize, &AtomLine)| {
        let number = i32::try_from(atom.molecule);
        let number =
            number.with_context(|| format!("the molecule {} is above 2³¹ − 1", atom.molecule))?;
        Ok(if is_alone(index) { -1 } else { number })
    };
    atoms.iter().enumerate().map(number).collect()
}

/// A number in single precision.
fn single(value: f64) -> Result<f32> {
    let single = value as f32;
    ensure!(
        single.is_finite(),
        "{value:e} is beyond single precision, which GSD stores; a .lammpstrj keeps every digit"
    );
    Ok(single)
}
