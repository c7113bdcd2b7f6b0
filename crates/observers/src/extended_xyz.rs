//! Snapshots as frames of extended XYZ, one line per atom, readable by OVITO and ASE.
//!
//! Columns, in the user's units:
//!
//! | column | meaning |
//! | --- | --- |
//! | `species` | X for atoms of fixed bodies, H for all others: ASE accepts symbols of elements only |
//! | `pos` | centre of the atom |
//! | `velo` | velocity of the material point there |
//! | `molecule_id`, `atom` | number of the molecule, index of the atom in it |
//! | `radius` | radius of the atom |
//! | `angle`, `angular_velocity` | orientation of the molecule (radians), and its change per time |
//! | `mass` | mass of the atom |
//! | `kind` | kind of the molecule: 0, 1, … in order of appearance; one for a gas of drawn sizes |
//! | `momenta`, `masses` | `mass × velo` and `mass` again, from which ASE has velocities |
//! | `map_shift` | boxes that the molecule has crossed along x, y, z: `pos + map_shift × sides` has no jumps |
//!
//! Floats are written in the shortest form that is read back to the same bits. z is 0 in a cell
//! with a thickness of the largest diameter, periodic in x and y. Molecules are kept whole: an atom
//! may lie outside the cell that holds the centre of its molecule. The comment line names the kinds
//! by their tags, `Kinds="…"`. Walls have no line; the comment line lists them as `Walls="…"` with
//! five numbers each: x and y of one end, x and y of the other, and half the thickness.
//!
//! Straight edges of molecules are in the comment line, too, by kind: `Edges="…"` with four numbers
//! each, the kind, the two atoms at the ends, and the radius of the edge over the smaller one of
//! theirs. `Solid="…"` lists the kinds in which closed lines of edges are filled, and `Uniform="…"`
//! those whose mass is spread evenly over their area. `Bonds="…"` lists two atoms for each bond, by
//! the numbers of their lines from 0: of each body the one nearest to the tied point.

use std::{fmt::Write as _, io};

use carom_engine::{BodyView, View};
use carom_geometry::{Atom, Edge, Interior, Molecule};
use glam::DVec2;

use crate::kinds::{kinds_of_groups, names_of_kinds};

const PROPERTIES: &str = "species:S:1:pos:R:3:velo:R:3:molecule_id:I:1:atom:I:1:radius:R:1:angle:R:1:\
                          angular_velocity:R:1:mass:R:1:kind:I:1:momenta:R:3:masses:R:1:map_shift:I:3";

/// Writes one frame; successive frames form a trajectory.
///
/// # Errors
/// The errors of `out`.
///
/// ```
/// use carom_engine::{Scene, Simulation};
/// use carom_observers::write_extended_xyz;
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 3")?;
/// let simulation = Simulation::new(&scene)?;
/// let mut text = Vec::new();
/// write_extended_xyz(&simulation.view(), &mut text)?;
/// let text = String::from_utf8(text)?;
/// assert_eq!(text.lines().next(), Some("3"));
/// assert_eq!(text.lines().count(), 2 + 3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[doc(alias = "snapshot")]
pub fn write_extended_xyz(view: &View<'_>, out: &mut impl io::Write) -> io::Result<()> {
    let molecules = || view.bodies().filter(|view| !view.body.is_wall());
    let count: usize = molecules()
        .map(|view| view.body.molecule().atoms().len())
        .sum();
    let largest = molecules()
        .map(|view| thickest(view.body.molecule()))
        .fold(0.0, f64::max);
    let sides = view.bounds().sides();
    let thickness = if largest > 0.0 {
        2.0 * largest
    } else {
        sides.min_element()
    };
    let kinds = kinds_of_groups(view);
    writeln!(out, "{count}")?;
    writeln!(
        out,
        "Lattice=\"{:?} 0.0 0.0 {:?} {:?} 0.0 0.0 0.0 {thickness:?}\" Properties={PROPERTIES} pbc=\"T T F\" \
         Kinds=\"{}\" Time={:?}{}{}{}",
        sides.x,
        view.bounds().tilt() + 0.0,
        sides.y,
        names_of_kinds(view, &kinds).join(" "),
        view.time().to_f64(),
        walls(view),
        edges(view, &kinds),
        bonds(view)
    )?;
    let mut molecules = view
        .bodies()
        .zip(kinds)
        .filter(|(view, _)| !view.body.is_wall());
    molecules.try_for_each(|(body, kind)| write_molecule(&body, kind, out))
}

/// The entry of the comment line for the walls: x and y of both ends and half the thickness of
/// each; empty without walls.
fn walls(view: &View<'_>) -> String {
    let wall = |view: BodyView<'_>| {
        let radius = view.body.molecule().wall_edge().map_or(0.0, Edge::radius);
        let piece = move |[from, to]: [DVec2; 2]| {
            format!("{:?} {:?} {:?} {:?} {radius:?}", from.x, from.y, to.x, to.y)
        };
        view.wall_segments().map(piece)
    };
    let walls: Vec<String> = view.bodies().flat_map(wall).collect();
    if walls.is_empty() {
        String::new()
    } else {
        format!(" Walls=\"{}\"", walls.join(" "))
    }
}

/// The entry of the comment line for the bonds: the numbers of the lines of two atoms for each;
/// empty without bonds.
fn bonds(view: &View<'_>) -> String {
    if view.bonds().len() == 0 {
        return String::new();
    }
    let pairs = bonded_atoms(view);
    let lines: Vec<String> = pairs.iter().map(|[a, b]| format!("{a} {b}")).collect();
    format!(" Bonds=\"{}\"", lines.join(" "))
}

/// The two atoms of each bond, which are the nearest to its points, by their numbers among the
/// atoms of all bodies that are no walls.
pub fn bonded_atoms(view: &View<'_>) -> Vec<[usize; 2]> {
    let bodies: Vec<BodyView<'_>> = view.bodies().collect();
    let mut atoms = 0;
    let first: Vec<usize> = bodies
        .iter()
        .map(|body| {
            let first = atoms;
            if !body.body.is_wall() {
                atoms += body.body.molecule().atoms().len();
            }
            first
        })
        .collect();
    let nearest = |body: u32, point: DVec2| {
        let atoms = bodies[body as usize].body.molecule().atoms().iter();
        let apart = |atom: &Atom| (atom.offset() - point).length_squared();
        let nearest = atoms
            .enumerate()
            .min_by(|(_, one), (_, other)| apart(one).total_cmp(&apart(other)));
        first[body as usize] + nearest.map_or(0, |(atom, _)| atom)
    };
    let bonds = view.bonds().map(|bond| {
        let ([a, b], [from, to]) = (bond.bond.bodies, bond.bond.tether.points());
        [nearest(a, from), nearest(b, to)]
    });
    bonds.collect()
}

/// The radius of the largest atom; of a body with edges, whose atoms may be tiny, that of its
/// bounding circle (length).
fn thickest(molecule: &Molecule) -> f64 {
    if molecule.is_of_discs() {
        molecule
            .atoms()
            .iter()
            .map(Atom::radius)
            .fold(0.0, f64::max)
    } else {
        molecule.bounding_radius()
    }
}

/// The entries of the comment line for the edges of molecules, by kind; empty without edges.
fn edges(view: &View<'_>, kinds: &[usize]) -> String {
    let (mut edges, mut solid, mut uniform) = (Vec::new(), Vec::new(), Vec::new());
    let mut known = 0;
    for (body, &kind) in view.bodies().map(|view| view.body).zip(kinds) {
        // Kinds are numbered in order of appearance.
        if kind < known {
            continue;
        }
        known = kind + 1;
        let molecule = body.molecule();
        if molecule.is_wall() || molecule.edges().is_empty() {
            continue;
        }
        edges.extend(edges_of_kind(molecule, kind));
        if molecule.interior() == Interior::Solid {
            solid.push(kind.to_string());
        }
        if molecule.is_uniform() {
            uniform.push(kind.to_string());
        }
    }
    let mut entries = String::new();
    let ellipses = ellipses(view, kinds);
    for (name, list) in [
        ("Edges", edges),
        ("Solid", solid),
        ("Uniform", uniform),
        ("Ellipses", ellipses),
    ] {
        if !list.is_empty() {
            // Writing to a string cannot fail.
            let _ = write!(entries, " {name}=\"{}\"", list.join(" "));
        }
    }
    entries
}

/// Four numbers for each ellipse of each kind: kind, atom, the shorter axis over the longer one,
/// and the direction of the longer one in the frame of the body (radians).
fn ellipses(view: &View<'_>, kinds: &[usize]) -> Vec<String> {
    let mut known = 0;
    let mut all = Vec::new();
    for (body, &kind) in view.bodies().map(|view| view.body).zip(kinds) {
        if kind < known {
            continue;
        }
        known = kind + 1;
        for (atom, ellipse) in body.molecule().ellipses().iter().enumerate() {
            let ([a, b], along) = (ellipse.axes(), ellipse.along());
            let turn = libm::atan2(along.y, along.x);
            all.push(format!("{kind} {atom} {:?} {turn:?}", b / a));
        }
    }
    all
}

/// Four numbers for each edge: kind, both atoms, and relative radius.
fn edges_of_kind(molecule: &Molecule, kind: usize) -> impl Iterator<Item = String> {
    let radius = |atom: u32| molecule.atoms()[atom as usize].radius();
    molecule.edges().iter().filter_map(move |edge| {
        let [first, second] = edge.ends()?;
        let share = edge.radius() / radius(first).min(radius(second));
        Some(format!("{kind} {first} {second} {share:?}"))
    })
}

fn write_molecule(view: &BodyView<'_>, kind: usize, out: &mut impl io::Write) -> io::Result<()> {
    let BodyView {
        body,
        motion,
        winding: [right, up],
        ..
    } = view;
    let species = if body.is_fixed() { "X" } else { "H" };
    let rotation = motion.orientation.cos_sin();
    let (id, angle, spin) = (
        body.id(),
        motion.orientation.radians(),
        motion.angular_velocity,
    );
    for (index, atom) in body.molecule().atoms().iter().enumerate() {
        let arm = rotation.rotate(atom.offset());
        let (place, velocity) = (motion.position + arm, motion.velocity_of(arm));
        let (radius, mass) = (atom.radius(), atom.mass());
        let momentum = velocity * mass;
        writeln!(
            out,
            "{species} {:?} {:?} 0.0 {:?} {:?} 0.0 {id} {index} {radius:?} {angle:?} {spin:?} {mass:?} {kind} {:?} \
             {:?} 0.0 {mass:?} {right} {up} 0",
            place.x, place.y, velocity.x, velocity.y, momentum.x, momentum.y
        )?;
    }
    Ok(())
}
