//! A text dump of LAMMPS, one frame after another.

use std::io::{self, Write};

use super::frames::TrajectoryFrame;

/// Writes a frame with its number, from 0, as the time step.
///
/// Columns: number of the atom in the frame, number of its molecule, type (the kind, from 1), x y
/// z, ix iy iz, vx vy vz, radius, mass, orientation of the molecule (radians), its angular
/// velocity, and the time of the frame, named as LAMMPS names a column of a variable. Every digit
/// is kept. Molecules are whole: an atom may lie outside the box. The image numbers ix iy are the
/// boxes that its molecule has crossed: x + ix · lx has no jumps.
///
/// There is no column of names (`typelabel`): ASE and OVITO take each column for numbers. The
/// names of the kinds stand in the data file of LAMMPS and in GSD.
///
/// The head of a frame has the nine lines that all readers know. MDAnalysis counts them, so that
/// the optional section `ITEM: TIME` of LAMMPS would shift its frames.
pub(super) fn write(frame: &TrajectoryFrame, step: u64, out: &mut impl Write) -> io::Result<()> {
    let [x, y] = frame.sides;
    let half = 0.5 * frame.thickness;
    writeln!(out, "ITEM: TIMESTEP\n{step}")?;
    writeln!(out, "ITEM: NUMBER OF ATOMS\n{}", frame.atoms.len())?;
    writeln!(out, "{}", box_bounds([x, y], frame.tilt, half))?;
    writeln!(
        out,
        "ITEM: ATOMS id mol type x y z ix iy iz vx vy vz radius mass angle omegaz v_time"
    )?;
    for (index, atom) in frame.atoms.iter().enumerate() {
        let ([x, y], [ix, iy], [vx, vy]) = (atom.position, atom.image, atom.velocity);
        writeln!(
            out,
            "{} {} {} {x:?} {y:?} 0.0 {ix} {iy} 0 {vx:?} {vy:?} 0.0 {:?} {:?} {:?} {:?} {:?}",
            index + 1,
            atom.molecule,
            u64::from(atom.kind) + 1,
            atom.radius,
            atom.mass,
            atom.angle,
            atom.angular_velocity,
            frame.time
        )?;
    }
    Ok(())
}

/// The lines of a box with these sides, tilt and half its thickness (length). Of a tilted one
/// LAMMPS has the bounds of the parallelogram.
fn box_bounds([x, y]: [f64; 2], tilt: f64, half: f64) -> String {
    let along_z = format!("{:?} {half:?}", -half);
    if tilt == 0.0 {
        return format!("ITEM: BOX BOUNDS pp pp pp\n0.0 {x:?}\n0.0 {y:?}\n{along_z}");
    }
    let (low, high) = (tilt.min(0.0), x + tilt.max(0.0));
    format!(
        "ITEM: BOX BOUNDS xy xz yz pp pp pp\n{low:?} {high:?} {tilt:?}\n0.0 {y:?} 0.0\n{along_z} 0.0"
    )
}
