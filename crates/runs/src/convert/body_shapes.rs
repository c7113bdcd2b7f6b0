//! Bodies with straight edges in a trajectory of atoms: their molecules, centres and shapes.

use std::{
    borrow::Cow,
    collections::{BTreeMap, btree_map::Entry},
    fmt::Write as _,
};

use anyhow::{Context, Result, ensure};
use carom_geometry::{Atom, Contour, Interior, Molecule};
use glam::DVec2;

use super::frames::{AtomLine, KindEdge, TrajectoryFrame};

/// Largest angle between two corners of a shape with round parts (radians). Smaller: longer texts.
/// Larger: areas that are off by more than 0.1 %.
const STEP: f64 = std::f64::consts::PI / 36.0;

/// A frame in which each body with edges has a particle of its own at its centre of mass, before
/// its atoms.
#[derive(Debug, Default)]
pub(super) struct FrameWithBodies<'a> {
    /// Bodies and atoms.
    pub(super) particles: Cow<'a, [AtomLine]>,
    /// The shape of the bodies of each kind with edges, if all have the same, as JSON; the atoms of
    /// these bodies have kinds of their own.
    pub(super) shapes: BTreeMap<u32, Option<String>>,
    /// The kind of the atoms of the bodies of each kind with edges.
    pub(super) atom_kinds: BTreeMap<u32, u32>,
}

/// The molecules so far, by kind and three lengths to six digits: the radius of the first atom, and
/// the distances of the second and the last atom from it.
#[derive(Debug, Default)]
pub(super) struct KnownBodies(BTreeMap<(u32, [u32; 3]), Molecule>);

impl KnownBodies {
    /// The bodies of a frame of `kinds` kinds; the kinds of their atoms follow after these.
    ///
    /// # Errors
    /// The edges do not suit the atoms.
    pub(super) fn of_frame<'a>(
        &mut self,
        frame: &'a TrajectoryFrame,
        kinds: u32,
    ) -> Result<FrameWithBodies<'a>> {
        if frame.edges.is_empty() {
            return Ok(FrameWithBodies {
                particles: Cow::Borrowed(&frame.atoms),
                ..FrameWithBodies::default()
            });
        }
        let mut edges: BTreeMap<u32, Vec<KindEdge>> = BTreeMap::new();
        for edge in &frame.edges {
            edges.entry(edge.kind).or_default().push(*edge);
        }
        let atom_kinds: BTreeMap<u32, u32> = edges.keys().copied().zip(kinds..).collect();
        let mut particles = Vec::with_capacity(2 * frame.atoms.len());
        let mut shapes: BTreeMap<u32, Option<String>> = BTreeMap::new();
        for atoms in frame
            .atoms
            .chunk_by(|one, other| one.molecule == other.molecule)
        {
            let kind = atoms[0].kind;
            let Some(edges) = edges.get(&kind) else {
                particles.extend(atoms);
                continue;
            };
            let molecule = self
                .molecule(frame, atoms, edges)
                .with_context(|| format!("molecule {}", atoms[0].molecule))?;
            particles.push(centre(atoms, molecule));
            let own = atom_kinds.get(&kind).copied().unwrap_or(kind);
            let of_body = |&atom: &AtomLine| AtomLine { kind: own, ..atom };
            particles.extend(atoms.iter().map(of_body));
            let shape = shape(molecule);
            let common = shapes.entry(kind).or_insert_with(|| Some(shape.clone()));
            if common.as_ref().is_some_and(|common| *common != shape) {
                *common = None;
            }
        }
        Ok(FrameWithBodies {
            particles: Cow::Owned(particles),
            shapes,
            atom_kinds,
        })
    }

    fn molecule(
        &mut self,
        frame: &TrajectoryFrame,
        atoms: &[AtomLine],
        edges: &[KindEdge],
    ) -> Result<&Molecule> {
        let from_first = |atom: Option<&AtomLine>| {
            let place = atom.map_or(atoms[0].position, |atom| atom.position);
            DVec2::from(place).distance(DVec2::from(atoms[0].position))
        };
        let lengths = [
            atoms[0].radius,
            from_first(atoms.get(1)),
            from_first(atoms.last()),
        ];
        // Without the last three bits: the distances are those of rounded places.
        let key = (
            atoms[0].kind,
            lengths.map(|length| (length as f32).to_bits() >> 3),
        );
        Ok(match self.0.entry(key) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => new.insert(molecule(frame, atoms, edges)?),
        })
    }
}

/// The molecule of these atoms and edges.
fn molecule(frame: &TrajectoryFrame, atoms: &[AtomLine], edges: &[KindEdge]) -> Result<Molecule> {
    let kind = atoms[0].kind;
    let unturned = DVec2::from_angle(-atoms[0].angle);
    let first = DVec2::from(atoms[0].position);
    let list: Vec<Atom> = atoms
        .iter()
        .map(|atom| {
            let arm = unturned.rotate(DVec2::from(atom.position) - first);
            Atom::new(arm, atom.radius, atom.mass)
        })
        .collect::<Result<_, _>>()?;
    let thick = |edge: &KindEdge| {
        let radii = edge
            .ends
            .map(|end| atoms.get(end as usize).map(|atom| atom.radius));
        let [Some(one), Some(other)] = radii else {
            anyhow::bail!("an edge between atoms {:?} of {}", edge.ends, atoms.len());
        };
        Ok((edge.ends, edge.share * one.min(other)))
    };
    let edges: Vec<_> = edges.iter().map(thick).collect::<Result<_>>()?;
    let interior = if frame.solid.contains(&kind) {
        Interior::Solid
    } else {
        Interior::Hollow
    };
    let mass: f64 = atoms.iter().map(|atom| atom.mass).sum();
    let molecule = if frame.uniform.contains(&kind) {
        Molecule::uniform(list, &edges, interior, mass)?
    } else {
        Molecule::with_edges(list, &edges, interior)?
    };
    ensure!(molecule.area() > 0.0, "its area is {}", molecule.area());
    Ok(molecule)
}

/// A particle at the centre of mass of a body, with its mass and bounding circle.
fn centre(atoms: &[AtomLine], molecule: &Molecule) -> AtomLine {
    let first = &atoms[0];
    let arm = DVec2::from_angle(first.angle).rotate(molecule.atoms()[0].offset());
    let position = DVec2::from(first.position) - arm;
    let velocity = DVec2::from(first.velocity) - first.angular_velocity * arm.perp();
    AtomLine {
        position: position.to_array(),
        velocity: velocity.to_array(),
        radius: molecule.bounding_radius(),
        mass: molecule.mass(),
        ..*first
    }
}

/// The shape of a body in its own frame, as GSD defines it: a polygon with round corners, or a
/// polygon along the boundary.
fn shape(molecule: &Molecule) -> String {
    let atoms = molecule.atoms();
    let radius = atoms[0].radius();
    let (corners, rounding) = match molecule.corners() {
        Some(corners) => (corners, radius),
        None => (boundary(&molecule.visible_contours()), 0.0),
    };
    let mut text =
        format!("{{\"type\": \"Polygon\", \"rounding_radius\": {rounding:?}, \"vertices\": [");
    for (index, corner) in corners.iter().enumerate() {
        let comma = if index > 0 { ", " } else { "" };
        // Writing to a string cannot fail. Seven digits: single precision.
        let _ = write!(
            text,
            "{comma}[{:?}, {:?}]",
            corner.x as f32, corner.y as f32
        );
    }
    text.push_str("]}");
    text
}

/// Twice the area of a closed polygon; positive if it is counter-clockwise.
fn doubled_area(corners: &[DVec2]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    corners
        .iter()
        .zip(next)
        .map(|(one, other)| one.perp_dot(*other))
        .sum()
}

/// One closed polygon along all contours: holes, and parts that are apart, are joined to the first
/// by a line there and back, between the nearest corners.
fn boundary(contours: &[Contour]) -> Vec<DVec2> {
    let mut lines: Vec<Vec<DVec2>> = contours
        .iter()
        .map(|contour| contour.points(STEP))
        .collect();
    lines.sort_by(|one, other| doubled_area(other).total_cmp(&doubled_area(one)));
    let mut lines = lines.into_iter();
    let mut joined = lines.next().unwrap_or_default();
    for line in lines {
        let pairs = (0..joined.len()).flat_map(|i| (0..line.len()).map(move |j| (i, j)));
        let apart = |&(i, j): &(usize, usize)| joined[i].distance_squared(line[j]);
        let Some((i, j)) = pairs.min_by(|a, b| apart(a).total_cmp(&apart(b))) else {
            continue;
        };
        let around = line.iter().cycle().skip(j).take(line.len() + 1).copied();
        let back = joined[i];
        let rest = joined.split_off(i + 1);
        joined.extend(around.chain([back]).chain(rest));
    }
    joined
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ring_with_a_disc_is_one_polygon_of_its_area() {
        let rim = (0..6).map(|k| {
            (
                DVec2::from_angle(std::f64::consts::FRAC_PI_3 * f64::from(k)),
                0.1,
            )
        });
        let atoms = rim.chain([(DVec2::ZERO, 0.3)]);
        let edges: Vec<_> = (0..6).map(|k| ([k, (k + 1) % 6], 0.1)).collect();
        let ring = Molecule::with_edges(
            atoms.map(|(at, radius)| Atom::new(at, radius, 1.0).unwrap()),
            &edges,
            Interior::Hollow,
        )
        .unwrap();
        let found = boundary(&ring.visible_contours());
        let area = 0.5 * doubled_area(&found);
        assert!((area / ring.area() - 1.0).abs() < 3e-3, "{area}");
    }
}
