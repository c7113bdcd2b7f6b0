//! The single bodies of a scene: molecules, bumpers, walls and pistons at given places, with the
//! checks of every entry.

use std::sync::Arc;

use carom_geometry::{Bend, GeometryError, MAX_MAGNITUDE, Molecule, PeriodicBox, check_length};
use carom_kinematics::{Inertia, Motion, Orientation};
use glam::DVec2;

use crate::{
    contact::limits::refuse_slow,
    grid::Grid,
    scene::{
        ArcSpec, BumperSpec, MoleculeSpec, Scene, WallSpec,
        atom_spec::AtomSpec,
        container_spec::{Cavity, ContainerSpec},
        error::SceneError,
        piston_spec::PistonSpec,
    },
    start::{
        body_builder::{geometry, inertia, insert},
        sites::Sites,
    },
    world::{
        World,
        body::{BodyKind, Rotation},
        coincident_walls::coincident_wall,
        rounding_bound::rounding_bound,
        tags::TagNames,
    },
};

/// The single bodies of a scene: molecules, bumpers and walls, in this order.
#[derive(Debug, Clone)]
pub(crate) struct Singles {
    pub world: World,
    pub names: TagNames,
    /// The entry of each body.
    pub entries: Vec<String>,
}

impl Singles {
    /// Creates the single bodies; overlaps are refused by [`Self::refuse_overlaps`].
    pub fn new(scene: &Scene, bounds: PeriodicBox) -> Result<Self, SceneError> {
        let mut singles = Self {
            world: World::new(bounds),
            names: TagNames::default(),
            entries: Vec::new(),
        };
        singles.world.has_rough_contacts = scene.elasticity.is_rough();
        singles.add_molecules(&scene.molecule)?;
        singles.add_bumpers(&scene.bumper)?;
        singles.add_walls(&scene.wall)?;
        let cavities = singles.add_containers(&scene.container)?;
        singles.add_pistons(&scene.piston)?;
        singles.refuse_outside(&cavities)?;
        Ok(singles)
    }

    fn add_molecules(&mut self, specs: &[MoleculeSpec]) -> Result<(), SceneError> {
        for (index, spec) in specs.iter().enumerate() {
            let entry = format!("molecule[{index}]");
            add_molecule(&mut self.world, &mut self.names, spec, &entry)?;
            self.entries.push(entry);
        }
        Ok(())
    }

    /// Adds each bumper as a fixed molecule of one atom.
    fn add_bumpers(&mut self, specs: &[BumperSpec]) -> Result<(), SceneError> {
        for (index, spec) in specs.iter().enumerate() {
            let entry = format!("bumper[{index}]");
            let molecule = MoleculeSpec {
                tags: spec.tags.clone(),
                atoms: vec![AtomSpec {
                    at: [0.0; 2],
                    radius: spec.radius,
                    mass: 1.0,
                }],
                at: spec.at,
                fixed: true,
                ..MoleculeSpec::default()
            };
            add_molecule(&mut self.world, &mut self.names, &molecule, &entry)?;
            self.entries.push(entry);
        }
        Ok(())
    }

    fn add_walls(&mut self, specs: &[WallSpec]) -> Result<(), SceneError> {
        for (index, spec) in specs.iter().enumerate() {
            let entry = format!("wall[{index}]");
            add_wall(&mut self.world, &mut self.names, spec, &entry)?;
            self.entries.push(entry);
        }
        Ok(())
    }

    /// Adds the walls of each container, and returns the spaces that they enclose.
    fn add_containers(&mut self, specs: &[ContainerSpec]) -> Result<Vec<Cavity>, SceneError> {
        let mut cavities = Vec::new();
        for (index, spec) in specs.iter().enumerate() {
            let entry = format!("container[{index}]");
            let cavity = spec
                .cavity(self.world.bounds().sides())
                .map_err(|problem| SceneError::of_entry(&entry, problem))?;
            cavities.push(cavity);
            for wall in spec.walls(cavity) {
                add_wall(&mut self.world, &mut self.names, &wall, &entry)?;
                self.entries.push(entry.clone());
            }
        }
        Ok(cavities)
    }

    fn add_pistons(&mut self, specs: &[PistonSpec]) -> Result<(), SceneError> {
        for (index, spec) in specs.iter().enumerate() {
            let entry = format!("piston[{index}]");
            add_piston(&mut self.world, &mut self.names, spec, &entry)?;
            self.entries.push(entry);
        }
        Ok(())
    }

    /// Refuses free bodies outside the containers, if there are any: from outside, their arcs would
    /// be passed.
    fn refuse_outside(&self, cavities: &[Cavity]) -> Result<(), SceneError> {
        let world = &self.world;
        let is_outside = |index: &usize| {
            let place = world.motions[*index].position;
            let holds = |cavity: &Cavity| cavity.contains(world.bounds(), place);
            world.bodies[*index].is_free() && !cavities.iter().any(holds)
        };
        if let Some(body) = (0..world.bodies.len())
            .find(is_outside)
            .filter(|_| !cavities.is_empty())
        {
            return Err(SceneError::of_entry(
                &self.entries[body],
                "the molecule is outside the containers of the scene",
            ));
        }
        Ok(())
    }

    /// The entry of the scene that describes a body, if the gases have these numbers of molecules.
    pub fn entry_of(&self, body: usize, gases: &[usize]) -> String {
        self.entries.get(body).cloned().unwrap_or_else(|| {
            let mut before = self.entries.len();
            let within = |count: &usize| {
                before += count;
                body < before
            };
            format!(
                "gas[{}]",
                gases.iter().position(within).unwrap_or(gases.len())
            )
        })
    }

    /// Refuses overlaps between the single bodies; fixed bodies may overlap each other.
    pub fn refuse_overlaps(&self) -> Result<(), SceneError> {
        first_overlap(&self.world).map_or(Ok(()), |([one, other], depth)| {
            let entry = |index: usize| self.entries[index].clone();
            Err(SceneError::Overlap {
                first: entry(one),
                second: entry(other),
                depth,
            })
        })
    }
}

/// Largest distance of a molecule from the box, in boxes: farther out, the position in the box
/// loses half of its digits.
const MAX_DISTANCE_IN_BOXES: f64 = 2_147_483_648.0;

/// Adds a molecule of the scene; overlaps are checked by the caller.
pub(crate) fn add_molecule(
    world: &mut World,
    names: &mut TagNames,
    spec: &MoleculeSpec,
    entry: &str,
) -> Result<crate::BodyKey, SceneError> {
    let molecule = spec.molecule(entry)?;
    let motion = molecule_motion(spec, world.bounds().sides(), entry)?;
    refuse_impossible_motion(world, spec, &molecule, entry)?;
    let inertia = if spec.fixed {
        Inertia::FIXED
    } else {
        inertia(&molecule, spec.rotation)
    };
    refuse_slow(entry, &motion, molecule.bounding_radius())?;
    Grid::refuse_giant(molecule.bounding_radius(), world.bodies().len(), world)
        .map_err(|reason| reason.named(|_| entry.to_owned()))?;
    let tags = names.intern_all(&spec.tags);
    Ok(insert(world, Arc::new(molecule), inertia, tags, motion))
}

/// The motion of a molecule of the scene, whose numbers must be in range.
fn molecule_motion(spec: &MoleculeSpec, sides: DVec2, entry: &str) -> Result<Motion, SceneError> {
    let orientation = molecule_orientation(spec, entry)?;
    for number in [spec.at, spec.velocity].as_flattened() {
        check_length("a place or velocity", *number).map_err(geometry(entry))?;
    }
    if is_too_far(spec.at.into(), sides) {
        return Err(SceneError::of_entry(
            entry,
            "`at` must be at most 2^31 boxes away: farther out, rounding loses the position in the box",
        ));
    }
    check_length("angular_velocity", spec.angular_velocity).map_err(geometry(entry))?;
    Ok(Motion {
        velocity: DVec2::from(spec.velocity),
        orientation,
        angular_velocity: spec.angular_velocity,
        ..Motion::at_rest(DVec2::from(spec.at))
    })
}

/// The orientation of a molecule of the scene, given in radians or in turns.
fn molecule_orientation(spec: &MoleculeSpec, entry: &str) -> Result<Orientation, SceneError> {
    let checked = |name, angle| check_length(name, angle).map_err(geometry(entry));
    match (spec.orientation, spec.orientation_turns) {
        (Some(_), Some(_)) => Err(SceneError::of_entry(
            entry,
            "give `orientation` or `orientation_turns`, not both",
        )),
        (Some(radians), None) => checked("orientation", radians).map(Orientation::from_radians),
        (None, Some(turns)) => checked("orientation_turns", turns).map(Orientation::from_turns),
        (None, None) => Ok(Orientation::default()),
    }
}

/// Whether a place is so far from the box that its position in the box cannot be computed.
fn is_too_far(place: DVec2, sides: DVec2) -> bool {
    (place / sides).abs().max_element() > MAX_DISTANCE_IN_BOXES
}

/// Refuses the velocities that a body of this kind cannot have.
fn refuse_impossible_motion(
    world: &World,
    spec: &MoleculeSpec,
    molecule: &Molecule,
    entry: &str,
) -> Result<(), SceneError> {
    let turns = spec.angular_velocity != 0.0;
    let moves = spec.velocity != [0.0; 2] || turns;
    if spec.fixed && moves {
        return Err(SceneError::of_entry(
            entry,
            "a fixed molecule must have no velocity and no angular velocity",
        ));
    }
    if turns && spec.rotation == Rotation::Locked {
        return Err(SceneError::of_entry(
            entry,
            "a molecule of locked rotation must have angular velocity 0",
        ));
    }
    if turns && molecule.is_disc() && !world.has_rough_contacts {
        return Err(SceneError::of_entry(
            entry,
            "a single disc must have angular velocity 0, which contacts without friction never change; give \
             `[elasticity]` or one of its pairs a `tangential` above -1",
        ));
    }
    Ok(())
}

/// Largest length of a wall along x and along y, in sides of the box: the wall is listed in that
/// many images of each cell that it passes. A longer wall is most likely an error.
const MAX_WALL_LENGTH: f64 = 16.0;

/// Largest ratio of the sides of a box with walls. In a narrower box the margin for rounding along
/// the longer side is many cells of the shorter one, and a wall would be listed in all of them.
const NARROWEST: f64 = 1e9;

/// Refuses a wall that crosses too many images of the box, or is so thick that no space is left
/// beside it.
pub(crate) fn refuse_large_wall(
    entry: &str,
    wall: &Molecule,
    sides: DVec2,
) -> Result<(), SceneError> {
    let Some(edge) = wall.wall_edge() else {
        return Ok(());
    };
    let problem = |problem: String| SceneError::Entry {
        entry: entry.to_owned(),
        problem,
    };
    if sides.max_element() > NARROWEST * sides.min_element() {
        return Err(problem(format!(
            "a wall needs a box whose sides differ by a factor of at most {NARROWEST:e}, but they are {:e} and {:e}",
            sides.x, sides.y
        )));
    }
    let is_wide = 2.0 * edge.reach() > sides.min_element() * (1.0 + 1e-9);
    if edge.bend().is_some() && is_wide {
        return Err(problem(format!(
            "the circle of an arc must fit into the box, whose shorter side is {:e}, but its diameter is {:e}",
            sides.min_element(),
            2.0 * edge.reach()
        )));
    }
    let is_straight = edge.bend().is_none();
    if is_straight && edge.middle().abs().cmpgt(sides).any() {
        return Err(problem(format!(
            "the pivot of a wall must be within a side of the box of its middle, {:e} and {:e}, but they are apart by \
             {:e} and {:e}",
            sides.x,
            sides.y,
            edge.middle().x.abs(),
            edge.middle().y.abs()
        )));
    }
    let extent = (2.0 * edge.half_length()) * edge.along().abs();
    for (axis, name) in ["x", "y"].into_iter().enumerate() {
        if extent[axis] > MAX_WALL_LENGTH * sides[axis] {
            return Err(problem(format!(
                "the wall must be at most 16 times as long as the box, but is {:e} along {name}, where the side is {:e}",
                extent[axis], sides[axis]
            )));
        }
    }
    let side = sides.min_element();
    if edge.radius() > side {
        return Err(problem(format!(
            "the radius of the wall must be at most the shorter side of the box, {side:e}, but is {:e}",
            edge.radius()
        )));
    }
    Ok(())
}

/// Lowest temperature of a wall: bodies that leave it must be fast enough to compute with.
const MIN_TEMPERATURE: f64 = 1e-60;

/// Whether a wall may have this temperature.
pub(crate) fn is_wall_temperature(temperature: f64) -> bool {
    (MIN_TEMPERATURE..=MAX_MAGNITUDE).contains(&temperature)
}

/// A wall along an axis through the whole box, without end points: it meets its own images.
fn wall_across(sides: DVec2, axis: DVec2, radius: f64) -> Result<Molecule, GeometryError> {
    Molecule::wall_without_ends(axis * sides, radius)
}

/// A curved wall about the origin.
fn arc_wall(arc: &ArcSpec, radius: f64) -> Result<Molecule, GeometryError> {
    let bend = Bend::new(arc.radius, [arc.from, arc.to])?;
    let bend = if arc.one_sided {
        bend.one_sided()
    } else {
        bend
    };
    Molecule::arc(bend, radius)
}

/// Whether a wall has no end points although it does not meet its own images in a box of these
/// sides. Detection would let bodies enter such a wall where it ends.
pub(crate) fn is_open_wall(wall: &Molecule, orientation: Orientation, sides: DVec2) -> bool {
    let Some(edge) = wall.wall_edge().filter(|_| wall.atoms().is_empty()) else {
        return false;
    };
    if edge.bend().is_some() {
        return false;
    }
    let is_across =
        |axis| wall_across(sides, axis, edge.radius()).is_ok_and(|across| across == *wall);
    orientation.turns() != 0.0 || !(is_across(DVec2::X) || is_across(DVec2::Y))
}

/// Adds a wall of the scene, at rest; overlaps are checked by the caller.
pub(crate) fn add_wall(
    world: &mut World,
    names: &mut TagNames,
    spec: &WallSpec,
    entry: &str,
) -> Result<crate::BodyKey, SceneError> {
    let (centre, wall) = wall_shape(spec, world.bounds().sides(), entry)?;
    let molecule = Arc::new(wall);
    refuse_large_wall(entry, &molecule, world.bounds().sides())?;
    if let Some(temperature) = spec
        .temperature
        .filter(|&temperature| !is_wall_temperature(temperature))
    {
        return Err(SceneError::of_entry(
            entry,
            format!(
                "`temperature` of a wall must be from {MIN_TEMPERATURE:e} to {MAX_MAGNITUDE:e} (mass × length² / time²), \
                 but is {temperature}"
            ),
        ));
    }
    if let Some(other) = coincident_wall(world, &molecule, centre, spec.temperature) {
        let temperatures = [spec.temperature, world.bodies[other].wall_temperature()];
        let problem = coincidence_of(temperatures, world.bounds().sides());
        return Err(SceneError::of_entry(entry, problem));
    }
    if let Some(motion) = &spec.motion {
        motion.of_wall(entry, &molecule, &Motion::at_rest(centre), world.bounds())?;
    }
    let tags = names.intern_all(&spec.tags);
    let kind = BodyKind {
        molecule,
        inertia: Inertia::FIXED,
        tags,
        tag_class: 0,
        has_rough_contacts: false,
        temperature: spec.temperature,
    };
    Ok(world.insert(kind, Motion::at_rest(centre)))
}

/// The place of a wall of the scene, and its shape about that place.
fn wall_shape(spec: &WallSpec, sides: DVec2, entry: &str) -> Result<(DVec2, Molecule), SceneError> {
    let of_arc = spec.arc.map(|arc| [arc.at[0], arc.at[1], arc.from, arc.to]);
    let numbers = [spec.from, spec.to]
        .into_iter()
        .flatten()
        .flatten()
        .chain(spec.x)
        .chain(spec.y)
        .chain(of_arc.into_iter().flatten());
    for number in numbers {
        check_length("a place of a wall", number).map_err(geometry(entry))?;
    }
    let (centre, wall) = match (spec.from, spec.to, spec.x, spec.y, spec.arc) {
        (None, None, None, None, Some(arc)) => (DVec2::from(arc.at), arc_wall(&arc, spec.radius)),
        (Some(from), Some(to), None, None, None) => {
            let (from, to) = (DVec2::from(from), DVec2::from(to));
            (
                0.5 * from + 0.5 * to,
                Molecule::wall(to - from, spec.radius),
            )
        }
        (None, None, Some(x), None, None) => (
            DVec2::new(x, 0.5 * sides.y),
            wall_across(sides, DVec2::Y, spec.radius),
        ),
        (None, None, None, Some(y), None) => (
            DVec2::new(0.5 * sides.x, y),
            wall_across(sides, DVec2::X, spec.radius),
        ),
        _ => {
            return Err(SceneError::of_entry(
                entry,
                "give a wall `from` and `to`, or `x`, or `y`, or `arc`",
            ));
        }
    };
    if is_too_far(centre, sides) {
        return Err(SceneError::of_entry(
            entry,
            "the wall must be at most 2^31 boxes away: farther out, rounding loses the position in the box",
        ));
    }
    Ok((centre, wall.map_err(geometry(entry))?))
}

/// The problem of two walls in the same place with these temperatures.
fn coincidence_of(temperatures: [Option<f64>; 2], sides: DVec2) -> String {
    let [own, other] = temperatures.map(|temperature| {
        temperature.map_or_else(
            || "no temperature".to_owned(),
            |value| format!("temperature {value}"),
        )
    });
    format!(
        "the wall has {own}, but lies in the same place as another wall with {other}; the box is periodic, so that its \
         sides {} and {} are the same lines as 0, and a wall acts on both sides: for a gas between unlike walls, \
         place one of them elsewhere, such as in the middle of the box",
        sides.x, sides.y
    )
}

/// Adds the wall of a piston, at rest and of infinite mass; overlaps are checked by the caller.
pub(crate) fn add_piston(
    world: &mut World,
    names: &mut TagNames,
    spec: &PistonSpec,
    entry: &str,
) -> Result<crate::BodyKey, SceneError> {
    let (x, y) = (spec.x, spec.y);
    if x.is_some() == y.is_some() {
        return Err(SceneError::of_entry(entry, "give a piston `x` or `y`"));
    }
    let wall = WallSpec {
        tags: spec.tags.clone(),
        x,
        y,
        radius: spec.radius,
        ..WallSpec::default()
    };
    add_wall(world, names, &wall, entry)
}

/// Two bodies of a world that overlap beyond rounding, in the order of insertion, and the depth
/// (length); two fixed bodies may overlap.
pub(crate) fn first_overlap(world: &World) -> Option<([usize; 2], f64)> {
    let mut sites = Sites::new(world);
    let is_fixed = |&index: &usize| world.bodies[index].is_fixed();
    (0..world.bodies.len())
        .filter(is_fixed)
        .for_each(|index| sites.add(world, index));
    for index in (0..world.bodies.len()).filter(|index| !is_fixed(index)) {
        if let Some((other, depth)) = deepest_overlap(world, &sites, index) {
            return Some(([other.min(index), other.max(index)], depth));
        }
        sites.add(world, index);
    }
    None
}

/// The body with the deepest overlap with this one beyond rounding, and the depth (length); two
/// fixed bodies may overlap.
pub(crate) fn deepest_overlap(world: &World, sites: &Sites, index: usize) -> Option<(usize, f64)> {
    let body = &world.bodies[index];
    let (other, gap) = sites.nearest_to_body(world, index)?;
    let reach = body.reach() + world.bodies[other].reach();
    (gap < -rounding_bound(world.bounds.sides(), reach)).then_some((other, -gap))
}
