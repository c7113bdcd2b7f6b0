//! The motions that walls are given, and their ranges.

use std::sync::Arc;

use carom_geometry::{Edge, MAX_MAGNITUDE, Molecule, PeriodicBox, check_length};
use carom_kinematics::{Drive, Motion, Orientation};
use glam::DVec2;

use crate::{
    contact::limits::refuse_slow,
    scene::{Scene, error::SceneError, wall_motion::WallMotionSpec},
    start::body_builder::geometry,
    world::{World, drives::Oscillation},
};

impl WallMotionSpec {
    /// The motion of a wall that is at `place` now, and the wall with its pivot at the origin;
    /// `None` if its shape remains. `entry` names the wall in errors.
    ///
    /// # Errors
    /// [`SceneError`] if a number is out of range, or if the wall cannot turn.
    pub(crate) fn of_wall(
        &self,
        entry: &str,
        wall: &Molecule,
        place: &Motion,
        bounds: &PeriodicBox,
    ) -> Result<(Motion, Option<Molecule>), SceneError> {
        self.check_numbers(entry)?;
        self.pieces(entry)?;
        self.oscillation(entry, bounds)?;
        let mut motion = Motion {
            velocity: DVec2::from(self.velocity),
            angular_velocity: self.turn,
            ..*place
        };
        let Some(edge) = wall.wall_edge().filter(|_| self.turn != 0.0) else {
            refuse_slow(entry, &motion, wall.bounding_radius())?;
            return Ok((motion, None));
        };
        refuse_turn(entry, wall, edge, bounds)?;
        let rotation = place.orientation.cos_sin();
        let middle = place.position + rotation.rotate(edge.middle());
        let to_pivot = self.about.map_or(DVec2::ZERO, |about| {
            bounds.nearest_image(DVec2::from(about) - middle)
        });
        let back = DVec2::new(rotation.x, -rotation.y);
        let span = wall.atoms()[1].offset() - wall.atoms()[0].offset();
        let turned = Molecule::wall_about(span, back.rotate(-to_pivot), edge.radius());
        let turned = turned.map_err(geometry(entry))?;
        motion.position = middle + to_pivot;
        refuse_slow(entry, &motion, turned.bounding_radius())?;
        Ok((motion, Some(turned)))
    }

    /// Refuses numbers out of range.
    fn check_numbers(&self, entry: &str) -> Result<(), SceneError> {
        let numbers = self
            .velocity
            .iter()
            .chain([&self.turn])
            .chain(self.about.iter().flatten())
            .chain(&self.amplitude)
            .chain([&self.frequency, &self.phase])
            .chain(&self.times)
            .chain(self.places.as_flattened());
        for &number in numbers {
            check_length("a number of the motion of a wall", number).map_err(geometry(entry))?;
        }
        Ok(())
    }

    /// What the wall does beside uniform motion; `None` unless it oscillates.
    fn oscillation(&self, entry: &str, bounds: &PeriodicBox) -> Result<Option<Drive>, SceneError> {
        let problem = |problem: String| Err(SceneError::of_entry(entry, problem));
        let amplitude = DVec2::from(self.amplitude);
        if amplitude == DVec2::ZERO && self.frequency == 0.0 && self.phase == 0.0 {
            return Ok(None);
        }
        if self.velocity != [0.0; 2] || self.turn != 0.0 || self.about.is_some() {
            return problem(
                "a motion has either an `amplitude` and a `frequency`, or `velocity` and `turn`"
                    .to_owned(),
            );
        }
        let (size, side) = (amplitude.x.hypot(amplitude.y), bounds.sides().min_element());
        if !(size > 0.0 && size < side) {
            return problem(format!(
                "`amplitude` must be longer than 0 and shorter than the shorter side of the box, {side:e}, but its length \
                 is {size:e}"
            ));
        }
        let frequency = self.frequency;
        let is_allowed = frequency > 0.0 && size * frequency * frequency <= MAX_MAGNITUDE;
        if !is_allowed {
            return problem(format!(
                "`frequency` must be above 0 and give an acceleration of at most {MAX_MAGNITUDE:e}, but is {frequency:e}"
            ));
        }
        let motion = Motion {
            velocity: frequency * amplitude,
            ..Motion::at_rest(DVec2::ZERO)
        };
        refuse_slow(entry, &motion, 0.0)?;
        let phase = Orientation::from_radians(self.phase);
        Ok(Some(Drive::oscillation(amplitude, frequency, phase)))
    }

    /// The pieces of the table, as duration (time) and velocity (length per time); none without a
    /// table.
    fn pieces(&self, entry: &str) -> Result<Vec<(f64, DVec2)>, SceneError> {
        let problem = |problem: String| Err(SceneError::of_entry(entry, problem));
        if self.times.is_empty() && self.places.is_empty() && !self.repeat {
            return Ok(Vec::new());
        }
        let is_other = self.velocity != [0.0; 2] || self.turn != 0.0 || self.about.is_some();
        if is_other || self.amplitude != [0.0; 2] {
            return problem(
                "a motion has either `times` and `places`, or `velocity` and `turn`, or an `amplitude`".to_owned(),
            );
        }
        let (times, places) = (self.times.len(), self.places.len());
        if times != places || times < 2 {
            return problem(format!(
                "a table of a motion needs as many `places` as `times`, at least two, but has {times} times and \
                 {places} places"
            ));
        }
        if self.times[0] != 0.0 {
            return problem(format!(
                "`times` must begin with 0, but begin with {}",
                self.times[0]
            ));
        }
        let mut pieces = Vec::with_capacity(times - 1);
        for (times, places) in self.times.windows(2).zip(self.places.windows(2)) {
            let duration = times[1] - times[0];
            let velocity = (DVec2::from(places[1]) - DVec2::from(places[0])) / duration;
            // False for NaN.
            if !(duration > 0.0 && velocity.abs().max_element() <= MAX_MAGNITUDE) {
                return problem(format!(
                    "`times` must ascend and give velocities of at most {MAX_MAGNITUDE:e}, but {} follows {}, and the \
                     velocity is {velocity}",
                    times[1], times[0]
                ));
            }
            let motion = Motion {
                velocity,
                ..Motion::at_rest(DVec2::ZERO)
            };
            refuse_slow(entry, &motion, 0.0)?;
            pieces.push((duration, velocity));
        }
        Ok(pieces)
    }

    /// Gives this motion to a wall of a world. `entry` names the wall in errors.
    ///
    /// # Errors
    /// Those of [`Self::of_wall`]; the wall is then unchanged.
    pub(crate) fn set(
        &self,
        world: &mut World,
        wall: usize,
        entry: &str,
    ) -> Result<(), SceneError> {
        let (kind, place) = (&mut world.bodies[wall].kind, &mut world.motions[wall]);
        let (motion, molecule) = self.of_wall(entry, &kind.molecule, place, &world.bounds)?;
        let drive = self.oscillation(entry, &world.bounds)?;
        if let Some(molecule) = molecule {
            Arc::make_mut(kind).molecule = Arc::new(molecule);
        }
        let (position, image) = world.bounds.wrap(motion.position);
        *place = Motion { position, ..motion };
        let winding = &mut world.windings[wall];
        *winding = [winding[0] + image[0], winding[1] + image[1]];
        world.set_oscillation(
            wall,
            drive.map(|drive| Oscillation {
                drive,
                centre: position - drive.oscillation_now()[0],
            }),
        );
        world.set_wall_table(wall, self.pieces(entry)?, self.repeat);
        world.advance_wall_tables();
        Ok(())
    }
}

/// Refuses a wall that cannot turn in this box.
fn refuse_turn(
    entry: &str,
    wall: &Molecule,
    edge: &Edge,
    bounds: &PeriodicBox,
) -> Result<(), SceneError> {
    if wall.atoms().is_empty() {
        return Err(SceneError::of_entry(
            entry,
            "a wall across the box cannot turn: give it end points (`from` and `to`)",
        ));
    }
    let (length, side) = (2.0 * edge.half_length(), bounds.sides().min_element());
    if length >= side {
        return Err(SceneError::of_entry(
            entry,
            format!(
                "a wall that turns must be shorter than the shorter side of the box, {side:e}, but its length is \
                 {length:e}: it would pass through its own image"
            ),
        ));
    }
    Ok(())
}

/// Gives the walls of a scene their motions, in a world whose first bodies are the single bodies of
/// the scene. They are at rest while the gases are placed and grow.
pub(crate) fn move_walls(world: &mut World, scene: &Scene) -> Result<(), SceneError> {
    let first = scene.molecule.len() + scene.bumper.len();
    for (index, spec) in scene.wall.iter().enumerate() {
        if let Some(motion) = &spec.motion {
            motion.set(world, first + index, &format!("wall[{index}]"))?;
        }
    }
    Ok(())
}

/// Refuses walls that move in a system with a drag.
///
/// In the clock of the drag all free bodies move uniformly ([`DragClock`]), but a wall of constant
/// velocity does not.
///
/// [`DragClock`]: carom_kinematics::DragClock
pub(crate) fn refuse_drag(world: &World, name: impl Fn(usize) -> String) -> Result<(), SceneError> {
    if world.clock.is_free() || !world.moves_walls() {
        return Ok(());
    }
    let of_table = world.wall_tables.first();
    let of_table = of_table.and_then(|table| world.index(table.key));
    let wall = world.moving_walls().next().or(of_table);
    Err(SceneError::Entry {
        entry: wall.map_or_else(|| "a wall".to_owned(), name),
        problem: format!(
            "a wall cannot move where bodies have a drag, which is {} (1/time): set the drag to 0, or leave out the \
             motion of the wall",
            world.clock.drag()
        ),
    })
}
