//! A data file of LAMMPS with the atoms of one frame and the bonds between them.

use std::io::{self, Write};

use super::frames::{AtomLine, TrajectoryFrame};

/// Writes a frame in the atom style `bond`, with its velocities.
///
/// The type of an atom is the kind of its molecule, from 1, with the mass of the first atom of that
/// type; comments have the names of the kinds. Molecules of LAMMPS are the chains. Every digit is
/// kept. The image numbers are the boxes that the molecule has crossed.
pub(super) fn write(frame: &TrajectoryFrame, out: &mut impl Write) -> io::Result<()> {
    let (atoms, bonds) = (&frame.atoms, &frame.bonds);
    let types = atoms.iter().map(|atom| atom.kind + 1).max().unwrap_or(1);
    let ([x, y], half) = (frame.sides, 0.5 * frame.thickness);
    writeln!(out, "carom, time {:?}\n", frame.time)?;
    writeln!(out, "{} atoms\n{types} atom types", atoms.len())?;
    if !bonds.is_empty() {
        writeln!(out, "{} bonds\n1 bond types", bonds.len())?;
    }
    writeln!(
        out,
        "\n0.0 {x:?} xlo xhi\n0.0 {y:?} ylo yhi\n{:?} {half:?} zlo zhi",
        -half
    )?;
    if frame.tilt != 0.0 {
        writeln!(out, "{:?} 0.0 0.0 xy xz yz", frame.tilt)?;
    }
    writeln!(out, "\nMasses\n")?;
    for kind in 0..types {
        let of_kind = |atom: &&AtomLine| atom.kind == kind;
        let mass = atoms.iter().find(of_kind).map_or(1.0, |atom| atom.mass);
        // A mass must be positive.
        let mass = if mass > 0.0 { mass } else { 1.0 };
        let name = frame
            .kinds
            .get(kind as usize)
            .filter(|name| !name.is_empty());
        let name = name.map_or_else(String::new, |name| format!(" # {name}"));
        writeln!(out, "{} {mass:?}{name}", kind + 1)?;
    }
    let chains = chains(frame);
    writeln!(out, "\nAtoms # bond\n")?;
    for (number, atom) in (1_u32..).zip(atoms) {
        let ([x, y], [ix, iy]) = (atom.position, atom.image);
        let (molecule, kind) = (chains[number as usize - 1] + 1, atom.kind + 1);
        writeln!(
            out,
            "{number} {molecule} {kind} {x:?} {y:?} 0.0 {ix} {iy} 0"
        )?;
    }
    writeln!(out, "\nVelocities\n")?;
    for (number, atom) in (1..).zip(atoms) {
        let [vx, vy] = atom.velocity;
        writeln!(out, "{number} {vx:?} {vy:?} 0.0")?;
    }
    if !bonds.is_empty() {
        writeln!(out, "\nBonds\n")?;
    }
    for (number, [a, b]) in (1..).zip(bonds) {
        writeln!(out, "{number} 1 {} {}", a + 1, b + 1)?;
    }
    Ok(())
}

/// The number of the chain of each atom, from 0: the atoms of one molecule, and all that bonds
/// connect, have one number.
fn chains(frame: &TrajectoryFrame) -> Vec<usize> {
    let mut parents: Vec<usize> = (0..frame.atoms.len()).collect();
    let same = |pair: &&[AtomLine]| pair[0].molecule == pair[1].molecule;
    let neighbours = frame.atoms.windows(2).enumerate();
    let of_molecules = neighbours
        .filter(|(_, pair)| same(pair))
        .map(|(atom, _)| [atom, atom + 1]);
    let of_bonds = frame
        .bonds
        .iter()
        .map(|bond| bond.map(|atom| atom as usize));
    for [a, b] in of_molecules.chain(of_bonds) {
        let (a, b) = (root(&mut parents, a), root(&mut parents, b));
        parents[a.max(b)] = a.min(b);
    }
    let mut numbers = vec![0; parents.len()];
    let mut count = 0;
    for atom in 0..parents.len() {
        let first = root(&mut parents, atom);
        if first == atom {
            numbers[atom] = count;
            count += 1;
        } else {
            numbers[atom] = numbers[first];
        }
    }
    numbers
}

/// The first atom of the chain of an atom, as far as it is known.
fn root(parents: &mut [usize], mut atom: usize) -> usize {
    while parents[atom] != atom {
        parents[atom] = parents[parents[atom]];
        atom = parents[atom];
    }
    atom
}
