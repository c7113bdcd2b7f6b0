//! Starts from a snapshot: the bodies of a scene get the places of a file, and the velocities if it
//! has them.
//!
//! The atoms of the file belong to the bodies of the scene in order: single molecules, bumpers,
//! then the gases; walls have no atoms. Fixed bodies may be left out, and must have the place of
//! the scene otherwise. A molecule of several atoms has its orientation from `angle`, or else from
//! the places of its atoms by least squares; its velocity and angular velocity follow from those of
//! its atoms in the same way. What the file lacks is drawn as for a gas on a lattice.

use carom_geometry::{Atom, Molecule, PeriodicBox, check_length};
use carom_kinematics::{Motion, Orientation};
use glam::DVec2;
use rand::RngExt;

use crate::{
    contact::limits::refuse_slow,
    scene::{
        Scene,
        error::{SceneError, short},
        random::RandomStream,
    },
    start::{
        body_builder::geometry,
        contents::SceneContents,
        single_bodies::{Singles, first_overlap},
        snapshot::{SnapshotAtom, SnapshotFrame, read_frame},
        velocities::ConservedMomentum,
    },
    world::{World, body::Body},
};

/// Largest distance of an atom from its place in a rigid molecule, in bounding radii. Far above the
/// rounding of a file with seven digits, and far below a wrong assignment of atoms.
const MAX_OFF: f64 = 1e-5;

/// Largest relative difference between lengths in the file and in the scene.
const SAME_LENGTH: f64 = 1e-6;

/// The entry in messages.
const ENTRY: &str = "start.from";

fn problem(problem: String) -> SceneError {
    SceneError::Entry {
        entry: ENTRY.to_owned(),
        problem,
    }
}

/// Places all bodies of a scene as in its snapshot; returns the world and its contents.
///
/// # Errors
/// [`SceneError`] with the line of the frame.
pub(crate) fn fill(scene: &Scene) -> Result<(World, SceneContents), SceneError> {
    let start = &scene.start;
    if start.placement.is_some() || start.relax.is_some() || start.empty_pockets {
        return Err(problem(
            "give either `from`, or `placement`, `relax` and `empty_pockets`".to_owned(),
        ));
    }
    let text = start.snapshot.as_deref().ok_or_else(|| {
        problem(
            "the file has not been read: set `StartSpec::snapshot` to the text of its frame"
                .to_owned(),
        )
    })?;
    let mut contents = SceneContents::new(scene)?;
    let frame = read_frame(text).map_err(problem)?;
    refuse_box(&frame, contents.singles.world.bounds())?;
    let mut lines = vec![0; contents.singles.world.bodies().len()];
    let mut rows = Rows {
        rest: &frame.atoms,
        has_fixed: has_fixed(&frame, &contents)?,
    };
    move_singles(&mut contents.singles, &mut rows, &mut lines)?;
    let conserved = ConservedMomentum::new(&contents.singles.world, &contents.species);
    let (seed, replica) = (scene.bounds.seed, scene.bounds.replica);
    let mut random = RandomStream::Placement.generator(seed, replica);
    let mut velocities = RandomStream::Velocities.generator(seed, replica);
    let SceneContents { singles, species } = &mut contents;
    let bounds = *singles.world.bounds();
    for kind in species.iter() {
        let drawn = kind.velocities(&conserved, &mut velocities)?;
        let mut motions = Vec::new();
        for (index, (velocity, spin)) in drawn.enumerate() {
            let molecule = kind.molecule(index);
            let rows = rows.take(molecule.atoms().len());
            let drawn = Motion {
                velocity,
                angular_velocity: spin,
                orientation: Orientation::from_turns(random.random()),
                ..Motion::at_rest(DVec2::ZERO)
            };
            motions.push(motion(rows, molecule, kind.turns(), drawn, &bounds)?);
            lines.push(rows[0].line);
        }
        kind.insert(&mut singles.world, &mut singles.names, motions.into_iter());
    }
    refuse_overlaps(&contents, &lines)?;
    let world = std::mem::replace(&mut contents.singles.world, World::new(bounds));
    Ok((world, contents))
}

/// The rows of the atoms not yet assigned.
struct Rows<'a> {
    rest: &'a [SnapshotAtom],
    has_fixed: bool,
}

impl<'a> Rows<'a> {
    /// The rows of the next molecule; their number has been checked.
    fn take(&mut self, atoms: usize) -> &'a [SnapshotAtom] {
        let (first, rest) = self.rest.split_at(atoms);
        self.rest = rest;
        first
    }
}

fn refuse_box(frame: &SnapshotFrame, bounds: &PeriodicBox) -> Result<(), SceneError> {
    let Some(sides) = frame.sides else {
        return Ok(());
    };
    let differs = |axis: usize| (sides[axis] / bounds.sides()[axis] - 1.0).abs() > SAME_LENGTH;
    if differs(0) || differs(1) {
        let [x, y] = bounds.sides().to_array();
        let text = format!(
            "line 2: the box of the file is {} × {}, that of the scene {x} × {y}",
            sides[0], sides[1]
        );
        return Err(problem(text));
    }
    Ok(())
}

/// Whether the frame has the atoms of fixed bodies.
fn has_fixed(frame: &SnapshotFrame, contents: &SceneContents) -> Result<bool, SceneError> {
    let atoms = |fixed_too: bool| -> usize {
        let of = |body: &&Body| !body.is_wall() && (fixed_too || !body.is_fixed());
        contents
            .singles
            .world
            .bodies()
            .iter()
            .filter(of)
            .map(|body| body.molecule().atoms().len())
            .sum()
    };
    let of_gas = |kind: &crate::start::species::Species| match kind.count {
        0 => 0,
        count => count * kind.molecule(0).atoms().len(),
    };
    let gases: usize = contents.species.iter().map(of_gas).sum();
    let (all, moving, found) = (atoms(true) + gases, atoms(false) + gases, frame.atoms.len());
    if found != all && found != moving {
        return Err(problem(format!(
            "line 1: the file has {found} atoms, the bodies of the scene have {all}"
        )));
    }
    Ok(found == all)
}

/// Gives the single molecules that move the motions of the file, and compares the places of fixed
/// ones.
fn move_singles(
    singles: &mut Singles,
    rows: &mut Rows<'_>,
    lines: &mut [usize],
) -> Result<(), SceneError> {
    let World {
        bodies,
        motions,
        bounds,
        has_rough_contacts,
        ..
    } = &mut singles.world;
    for ((body, motion), line) in bodies.iter().zip(motions.iter_mut()).zip(lines) {
        if body.is_wall() || (body.is_fixed() && !rows.has_fixed) {
            continue;
        }
        let atoms = rows.take(body.molecule().atoms().len());
        *line = atoms[0].line;
        if body.is_fixed() {
            let arms = body
                .molecule()
                .atoms()
                .iter()
                .map(|atom| motion.orientation.cos_sin().rotate(atom.offset()));
            for (row, arm) in atoms.iter().zip(arms) {
                let off = bounds
                    .nearest_image(row.place - (motion.position + arm))
                    .length();
                if off > MAX_OFF * body.molecule().bounding_radius() {
                    let text = format!(
                        "line {}: a fixed body has another place, {off:e} away, in the scene",
                        row.line
                    );
                    return Err(problem(text));
                }
            }
        } else {
            let turns = body.can_turn() || (*has_rough_contacts && !body.is_locked());
            let moved = self::motion(atoms, body.molecule(), turns, *motion, bounds)?;
            *motion = Motion {
                position: bounds.wrap(moved.position).0,
                ..moved
            };
        }
    }
    Ok(())
}

/// The motion of a molecule with these atoms; what they lack is taken from `drawn`.
fn motion(
    rows: &[SnapshotAtom],
    molecule: &Molecule,
    turns: bool,
    drawn: Motion,
    bounds: &PeriodicBox,
) -> Result<Motion, SceneError> {
    refuse_other_atoms(rows, molecule, bounds)?;
    let FittedPlace {
        position,
        orientation,
        arms,
    } = FittedPlace::new(rows, molecule, drawn.orientation, bounds)?;
    let (velocity, angular_velocity) = velocities(rows, molecule, &arms, turns, &drawn);
    let entry = format!("{ENTRY}, line {}", rows[0].line);
    for component in velocity.to_array() {
        check_length("the velocity", component).map_err(geometry(&entry))?;
    }
    check_length("the angular velocity", angular_velocity).map_err(geometry(&entry))?;
    let motion = Motion {
        velocity,
        angular_velocity,
        orientation,
        ..Motion::at_rest(position)
    };
    refuse_slow(&entry, &motion, molecule.bounding_radius())?;
    Ok(motion)
}

/// Refuses atoms far from the box, and those whose radius is not that of the molecule.
fn refuse_other_atoms(
    rows: &[SnapshotAtom],
    molecule: &Molecule,
    bounds: &PeriodicBox,
) -> Result<(), SceneError> {
    for (row, atom) in rows.iter().zip(molecule.atoms()) {
        if !(row.place / bounds.sides() - 0.5)
            .abs()
            .cmple(DVec2::splat(1.5))
            .all()
        {
            let text = format!(
                "line {}: {} is more than a side of the box away from it",
                row.line, row.place
            );
            return Err(problem(text));
        }
        let differs = |radius: f64| (radius / atom.radius() - 1.0).abs() > SAME_LENGTH;
        if let Some(radius) = row.radius.filter(|&radius| differs(radius)) {
            let text = format!(
                "line {}: the radius is {radius}, in the scene {}",
                row.line,
                atom.radius()
            );
            return Err(problem(text));
        }
    }
    Ok(())
}

/// Where a molecule with given atoms is.
struct FittedPlace {
    /// The centre of mass (length).
    position: DVec2,
    orientation: Orientation,
    /// From the centre of mass to each atom (length).
    arms: Vec<DVec2>,
}

impl FittedPlace {
    /// The place at which a molecule has these atoms; `drawn` is the orientation of a disc without
    /// one in the file.
    ///
    /// # Errors
    /// [`SceneError`] if the atoms are not placed like those of the molecule.
    fn new(
        rows: &[SnapshotAtom],
        molecule: &Molecule,
        drawn: Orientation,
        bounds: &PeriodicBox,
    ) -> Result<Self, SceneError> {
        let atoms = molecule.atoms();
        // The atoms around the first one, in case they have been wrapped into the box.
        let places: Vec<DVec2> = rows
            .iter()
            .map(|row| rows[0].place + bounds.nearest_image(row.place - rows[0].place))
            .collect();
        let orientation = match rows[0].angle {
            Some(angle) => {
                Orientation::from_radians(check_length("angle", angle).map_err(geometry(ENTRY))?)
            }
            None if atoms.len() > 1 => fitted(&places, molecule),
            None => drawn,
        };
        let rotation = orientation.cos_sin();
        let arms: Vec<DVec2> = atoms
            .iter()
            .map(|atom| rotation.rotate(atom.offset()))
            .collect();
        // The atom nearest to the centre of mass gives its place with the least rounding.
        let central = (0..atoms.len())
            .min_by(|&i, &j| atoms[i].arm().total_cmp(&atoms[j].arm()))
            .unwrap_or(0);
        let position = places[central] - arms[central];
        for ((place, arm), row) in places.iter().zip(&arms).zip(rows) {
            let off = (*place - (position + *arm)).length();
            if off > MAX_OFF * molecule.bounding_radius() {
                let text = format!(
                    "line {}: the atom is {off:e} away from its place in the molecule of line {}",
                    row.line, rows[0].line
                );
                return Err(problem(text));
            }
        }
        Ok(Self {
            position,
            orientation,
            arms,
        })
    }
}

/// The mean of vectors of the atoms, with their masses as weights.
fn mean_of_atoms(atoms: &[Atom], vectors: impl Iterator<Item = DVec2>) -> DVec2 {
    let mass: f64 = atoms.iter().map(Atom::mass).sum();
    let weighted = atoms
        .iter()
        .zip(vectors)
        .map(|(atom, vector)| atom.mass() * vector);
    weighted.sum::<DVec2>() / mass
}

/// The centre of mass of the atoms relative to that of the molecule: 0 unless the mass is spread
/// over the molecule, as in a polygon.
fn centre_of_atoms(molecule: &Molecule, arms: impl Iterator<Item = DVec2>) -> DVec2 {
    if molecule.is_uniform() {
        mean_of_atoms(molecule.atoms(), arms)
    } else {
        DVec2::ZERO
    }
}

/// The orientation at which the molecule fits these places best: the angle of Σ m a · q and Σ m a ×
/// q over its atoms, with a and q relative to the centre of mass of the atoms.
fn fitted(places: &[DVec2], molecule: &Molecule) -> Orientation {
    let atoms = molecule.atoms();
    let centre = mean_of_atoms(atoms, places.iter().copied());
    let own = centre_of_atoms(molecule, atoms.iter().map(Atom::offset));
    let sums = atoms
        .iter()
        .zip(places)
        .fold(DVec2::ZERO, |sums, (atom, &place)| {
            let (arm, there) = (atom.offset() - own, place - centre);
            sums + atom.mass() * DVec2::new(arm.dot(there), arm.perp_dot(there))
        });
    Orientation::from_radians(libm::atan2(sums.y, sums.x))
}

/// Velocity and angular velocity of a molecule: ω = Σ m a × v / Σ m a², unless the file has ω,
/// with a relative to the centre of mass c of the atoms, and V = Σ m v / Σ m − ω × c; those drawn
/// if the file has no velocities.
fn velocities(
    rows: &[SnapshotAtom],
    molecule: &Molecule,
    arms: &[DVec2],
    turns: bool,
    drawn: &Motion,
) -> (DVec2, f64) {
    let atoms = molecule.atoms();
    let of = |row: &SnapshotAtom, atom: &Atom| {
        row.velocity
            .or(row.momentum.map(|momentum| momentum / atom.mass()))
    };
    let Some(first) = of(&rows[0], &atoms[0]) else {
        return (drawn.velocity, drawn.angular_velocity);
    };
    if let [row] = rows {
        let spin = row.angular_velocity.unwrap_or(drawn.angular_velocity);
        return (first, if turns { spin } else { 0.0 });
    }
    let (mut mass, mut momentum, mut spin, mut inertia) = (0.0, DVec2::ZERO, 0.0, 0.0);
    let own = centre_of_atoms(molecule, arms.iter().copied());
    for ((row, atom), arm) in rows.iter().zip(atoms).zip(arms) {
        let arm = *arm - own;
        let velocity = of(row, atom).unwrap_or(first);
        mass += atom.mass();
        momentum += atom.mass() * velocity;
        spin += atom.mass() * arm.perp_dot(velocity);
        inertia += atom.mass() * arm.length_squared();
    }
    let angular_velocity = match (turns, rows[0].angular_velocity) {
        (false, _) => 0.0,
        (true, Some(given)) => given,
        (true, None) => spin / inertia,
    };
    let velocity = momentum / mass;
    if own == DVec2::ZERO {
        return (velocity, angular_velocity);
    }
    (velocity - angular_velocity * own.perp(), angular_velocity)
}

fn refuse_overlaps(contents: &SceneContents, lines: &[usize]) -> Result<(), SceneError> {
    let Some((pair, depth)) = first_overlap(&contents.singles.world) else {
        return Ok(());
    };
    let counts = contents.counts();
    let [first, second] = pair.map(|body| {
        let entry = contents.singles.entry_of(body, &counts);
        if lines[body] == 0 {
            entry
        } else {
            format!("{entry} of line {}", lines[body])
        }
    });
    let depth = short(depth);
    Err(problem(format!("{first} and {second} overlap by {depth}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The corners of an L are not spread evenly about its centre of mass.
    #[test]
    fn the_motion_of_a_polygon_follows_from_its_corners() {
        let corners = [
            (0.0, 0.0),
            (0.3, 0.0),
            (0.3, 0.1),
            (0.1, 0.1),
            (0.1, 0.3),
            (0.0, 0.3),
        ];
        let ell = Molecule::polygon(&corners.map(DVec2::from), 1e-6, 5.0).unwrap();
        let expected = Motion {
            velocity: DVec2::new(0.4, -0.7),
            angular_velocity: 3.0,
            orientation: Orientation::from_radians(0.7),
            ..Motion::at_rest(DVec2::new(0.5, 0.4))
        };
        let row = |atom: &Atom| {
            let arm = expected.orientation.cos_sin().rotate(atom.offset());
            SnapshotAtom {
                line: 3,
                place: expected.position + arm,
                velocity: Some(expected.velocity_of(arm)),
                momentum: None,
                angle: None,
                angular_velocity: None,
                radius: None,
            }
        };
        let rows: Vec<SnapshotAtom> = ell.atoms().iter().map(row).collect();
        let drawn = Motion::at_rest(DVec2::ZERO);
        let bounds = PeriodicBox::new(DVec2::ONE).unwrap();
        let found = motion(&rows, &ell, true, drawn, &bounds).unwrap();
        assert!((found.position - expected.position).length() < 1e-14);
        assert!((found.velocity - expected.velocity).length() < 1e-14);
        assert!((found.angular_velocity - 3.0).abs() < 1e-13);
        assert!((found.orientation.radians() - 0.7).abs() < 1e-14);
    }
}
