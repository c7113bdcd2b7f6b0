//! Meetings of walls that move with other walls and with fixed bodies, at which a run ends.
//!
//! Two bodies of infinite mass have no impulse that keeps them apart, and a body between them would
//! have infinitely many contacts before they meet. Bodies that overlap at the start of an epoch, as
//! a piston and the wall along which it slides do, have no such meeting.

use carom_detection::{Detection, Exact, Outcome};
use carom_geometry::{Molecule, gap_between};
use carom_kinematics::{Drive, Motion, RelativeMotion};
use glam::DVec2;

use crate::world::{
    World,
    body::Body,
    rounding_bound::rounding_bound,
    wall::{StandingWall, wall_speed},
};

/// Time over which the rate of a gap is measured, in times in which the bodies travel the shorter
/// side of the box; and the distance at which walls of which one turns meet, in shorter sides.
/// Smaller: the rate is lost in the rounding of positions.
const PROBE: f64 = 1e-6;

/// A run ends so many roundings before two bodies meet, while they are still apart: bodies that
/// touch have met before or slide along each other.
const MARGIN: f64 = 4.0;

/// Steps of the search for the meeting of a driven wall. Smaller: a wall that passes another very
/// closely ends the run. Larger: such a run is slower.
const MAX_DRIVEN_STEPS: u32 = 100_000;

/// Continuations of a search that ends "certified free until".
const MAX_SEARCHES: u32 = 1000;

/// The first meeting of two bodies of infinite mass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct WallMeeting {
    /// When they meet, less a few roundings (offset in the epoch, time); 0 if they do so now.
    pub time: f64,
    /// Their indices in [`World::bodies`], of which the first moves.
    pub bodies: [usize; 2],
}

/// What is known of the meetings of bodies of infinite mass until some time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct WallMeetings {
    pub first: Option<WallMeeting>,
    /// True if bodies overlap now, which may part and then meet again: of these the search says
    /// nothing.
    pub some_overlap: bool,
}

/// The largest time in which no wall travels more than the shorter side of the box; infinite if
/// none moves.
pub(crate) fn longest_sweep(world: &World) -> f64 {
    // An oscillation is shorter than the box.
    let uniform = world
        .moving_walls()
        .filter(|&wall| world.oscillation(wall).is_none());
    let speeds = uniform.map(|wall| wall_speed(&world.bodies[wall], &world.motions[wall]));
    world.bounds.sides().min_element() / speeds.fold(0.0, f64::max)
}

/// The first meeting of a wall that moves with a fixed body until `horizon` (offset in the epoch,
/// time).
pub(crate) fn first_meeting(world: &World, horizon: f64) -> WallMeetings {
    let mut first: Option<WallMeeting> = None;
    let mut some_overlap = false;
    for wall in world.moving_walls() {
        for other in 0..world.bodies.len() {
            let moves_too =
                !world.motions[other].is_at_rest() || world.oscillation(other).is_some();
            if !world.bodies[other].is_fixed() || other == wall || (moves_too && other < wall) {
                continue;
            }
            let horizon = first.map_or(horizon, |first| first.time);
            let time = match meeting_of_pair(world, [wall, other], horizon) {
                PairMeeting::At(time) => time,
                PairMeeting::Never => continue,
                PairMeeting::Overlap => {
                    some_overlap = true;
                    continue;
                }
            };
            if first.is_none_or(|first| time < first.time) {
                let bodies = [wall, other];
                first = Some(WallMeeting { time, bodies });
            }
        }
    }
    WallMeetings {
        first,
        some_overlap,
    }
}

/// What is known of the first meeting of a pair until some time.
enum PairMeeting {
    /// Offset in the epoch (time).
    At(f64),
    Never,
    /// They slide along each other, or leave each other.
    Overlap,
}

/// The time of the first meeting of a pair in any image.
fn meeting_of_pair(world: &World, pair: [usize; 2], horizon: f64) -> PairMeeting {
    let [a, b] = pair.map(|index| (&world.bodies[index], &world.motions[index]));
    let drives = pair.map(|index| world.oscillation(index));
    if drives[0].is_some() && drives[0] == drives[1] {
        return PairMeeting::Never;
    }
    let pair_of_body = [(a, drives[0]), (b, drives[1])];
    let speed = pair_of_body.map(|((body, motion), drive)| match drive {
        None => wall_speed(body, motion),
        Some(drive) => drive.max_speed(0.0),
    });
    let ways = [0, 1].map(|side| match drives[side] {
        None => speed[side] * horizon,
        Some(drive) => drive.max_displacement(horizon, 0.0),
    });
    let way = ways[0] + ways[1];
    let radii = a.0.molecule().bounding_radius() + b.0.molecule().bounding_radius();
    let separation = b.1.position - a.1.position;
    let sides = world.bounds.sides();
    let images = [0, 1].map(|axis| {
        let reach = radii + way;
        let low = ((-reach - separation[axis]) / sides[axis]).ceil() as i64;
        low..=((reach - separation[axis]) / sides[axis]).floor() as i64
    });
    let mut first: Option<f64> = None;
    for row in images[1].clone() {
        for column in images[0].clone() {
            let pair = FixedPair {
                bodies: [a.0, b.0],
                motions: [a.1, b.1],
                drives,
                top_speed: speed[0] + speed[1],
                shift: world.bounds.shift([column, row]),
                rounding: rounding_bound(sides, radii),
                thickness: PROBE * sides.min_element(),
                probe: PROBE * sides.min_element() / (speed[0] + speed[1]),
            };
            let gap = pair.gap(0.0);
            if gap <= pair.rounding {
                if pair.comes_back() {
                    return PairMeeting::At(0.0);
                }
                // Also where one is longer than the box and meets the other in several images.
                return PairMeeting::Overlap;
            }
            if gap <= way
                && let Some(time) = pair.meeting(first.unwrap_or(horizon))
            {
                first = Some(time);
            }
        }
    }
    first.map_or(PairMeeting::Never, PairMeeting::At)
}

/// Two fixed bodies, of which one at least moves.
struct FixedPair<'a> {
    bodies: [&'a Body; 2],
    motions: [&'a Motion; 2],
    drives: [Option<Drive>; 2],
    /// A bound on their relative speed (length per time).
    top_speed: f64,
    /// Of the second body (length).
    shift: DVec2,
    /// The deepest overlap by rounding alone (length).
    rounding: f64,
    /// Time over which the rate of the gap is measured (time).
    probe: f64,
    /// Distance at which walls of which one turns count as touching (length).
    thickness: f64,
}

impl FixedPair<'_> {
    /// Distance of the surfaces at a time (length); not positive where they overlap.
    fn gap(&self, time: f64) -> f64 {
        let [a, b] = self.motions_at(time);
        let separation = (b.position - a.position) + self.shift;
        let placed = [(self.bodies[0], a), (self.bodies[1], b)];
        let [wall_a, wall_b] = placed.map(|(body, motion)| StandingWall::new(body, &motion));
        if let (Some(wall_a), Some(wall_b)) = (wall_a, wall_b) {
            let spans = [wall_a, wall_b].map(|wall| {
                let [from, to] = wall.ends();
                to - from
            });
            let along = spans.map(DVec2::normalize);
            let halves = spans.map(|span| 0.5 * span.length());
            let between = (wall_b.middle() - wall_a.middle()) + self.shift;
            let radii = self.radii();
            if let Some(depth) = self.crossing(between, along, halves) {
                return -(depth + radii);
            }
            // Two walls across the box have no end points. Along different axes they always cross.
            if self.is_across(0) && self.is_across(1) {
                return if along[0].perp_dot(along[1]) == 0.0 {
                    self.distance_of_lines(time)[0].abs() - radii
                } else {
                    f64::NEG_INFINITY
                };
            }
        }
        let [rotation_a, rotation_b] = [a, b].map(|motion| motion.orientation.cos_sin());
        let [a, b] = self.bodies.map(Body::molecule);
        gap_between(a, rotation_a, b, rotation_b, separation)
    }

    /// How far the lines of two walls that cross do so: the least distance of an end point of one
    /// from the line of the other (length); infinite if neither has an end. `None` if they do not
    /// cross or are parallel.
    fn crossing(&self, separation: DVec2, along: [DVec2; 2], halves: [f64; 2]) -> Option<f64> {
        let sine = along[0].perp_dot(along[1]);
        if sine == 0.0 {
            return None;
        }
        let mut depth = f64::INFINITY;
        for side in 0..2 {
            // Of the middle of this wall from the line of the other, along the normal of that.
            let distance = separation.perp_dot(along[1 - side]);
            let half = halves[side];
            if self.is_across(side) {
                // It meets its own images: the margin leaves no gap between them.
                if distance.abs() > half * sine.abs() * (1.0 + 1e-9) {
                    return None;
                }
            } else if distance.abs() <= half * sine.abs() {
                depth = depth.min(half * sine.abs() - distance.abs());
            } else {
                return None;
            }
        }
        Some(depth)
    }

    /// Half the thickness of both (length).
    fn radii(&self) -> f64 {
        self.bodies[0].reach() + self.bodies[1].reach()
    }

    /// Signed distance of the second body from the line of the first, a wall that does not turn
    /// (length), and its rate (length per time).
    fn distance_of_lines(&self, time: f64) -> [f64; 2] {
        let [a, b] = self.motions_at(time);
        let edge = self.bodies[0].molecule().wall_edge();
        let along = edge.map_or(DVec2::X, carom_geometry::Edge::along);
        let along = a.orientation.cos_sin().rotate(along);
        let separation = (b.position - a.position) + self.shift;
        [separation, b.velocity - a.velocity].map(|vector| along.perp_dot(vector))
    }

    /// The first time before `horizon` at which an end of one of two walls that do not turn touches
    /// the other wall.
    fn contact_of_ends(&self, horizon: f64) -> Option<f64> {
        let [a, b] = self.motions;
        let placed = [(self.bodies[0], a), (self.bodies[1], b)];
        let [Some(wall_a), Some(wall_b)] =
            placed.map(|(body, motion)| StandingWall::new(body, motion))
        else {
            return None;
        };
        let [ends_a, ends_b] = [wall_a.ends(), wall_b.ends()];
        let ends_b = ends_b.map(|end| end + self.shift);
        let velocity = b.velocity - a.velocity;
        let radii = self.radii();
        let mut first = f64::INFINITY;
        // The ends of the second wall in the frame of the first, and the other way round.
        for (wall, [from, to], ends, velocity) in [
            (0, ends_a, ends_b, velocity),
            (1, ends_b, ends_a, -velocity),
        ] {
            if self.is_across(1 - wall) {
                continue;
            }
            let (middle, half) = (0.5 * (from + to), 0.5 * (to - from).length());
            let along = (to - from).normalize();
            for end in ends {
                let place = end - middle;
                let [across, rate] = [place, velocity].map(|vector| along.perp_dot(vector));
                // The line at a distance of the radii, on the side of the end.
                let time = (across.abs() - radii) / (-across.signum() * rate);
                if time >= 0.0 && along.dot(place + time * velocity).abs() <= half {
                    first = first.min(time);
                }
                for other in [from, to] {
                    // The smaller root of |d + v t| = R.
                    let d = end - other;
                    let (towards, square) = (-d.dot(velocity), velocity.length_squared());
                    let beside = d.perp_dot(velocity);
                    let room = radii * radii * square - beside * beside;
                    if towards > 0.0 && room >= 0.0 && !self.is_across(wall) {
                        let time = (towards - room.sqrt()) / square;
                        first = if time >= 0.0 { first.min(time) } else { first };
                    }
                }
            }
        }
        (first <= horizon).then_some(first)
    }

    fn is_across(&self, side: usize) -> bool {
        let molecule = self.bodies[side].molecule();
        molecule.is_wall() && molecule.atoms().is_empty()
    }

    /// The normal of two parallel walls across the box.
    fn normal_of_parallels(&self) -> Option<DVec2> {
        if !(self.is_across(0) && self.is_across(1)) {
            return None;
        }
        let placed = [0, 1].map(|side| StandingWall::new(self.bodies[side], self.motions[side]));
        let spans = placed.map(|wall| {
            let [from, to] = wall.map_or([DVec2::ZERO; 2], |wall| wall.ends());
            to - from
        });
        (spans[0].perp_dot(spans[1]) == 0.0).then(|| spans[0].perp().normalize_or_zero())
    }

    /// The normal of a wall across the box; along it, such a wall changes no gap.
    fn normal_of_across(&self) -> Option<DVec2> {
        let side = (0..2).find(|&side| self.is_across(side))?;
        let wall = StandingWall::new(self.bodies[side], self.motions[side])?;
        let [from, to] = wall.ends();
        Some((to - from).perp().normalize_or_zero())
    }

    /// A bound on the relative speed of the surfaces along a direction (length per time).
    fn top_speed_along(&self, normal: DVec2) -> f64 {
        let speed = |side: usize| match self.drives[side] {
            None => {
                let motion = self.motions[side];
                let rim =
                    motion.angular_velocity.abs() * self.bodies[side].molecule().bounding_radius();
                motion.velocity.dot(normal).abs() + rim
            }
            Some(drive) => drive.amplitude().dot(normal).abs() * drive.frequency(),
        };
        speed(0) + speed(1)
    }

    /// Whether two parallel walls across the box that touch now oscillate towards each other later.
    fn comes_back(&self) -> bool {
        let is_driven = self.drives != [None; 2];
        let normal = self.normal_of_parallels().filter(|_| is_driven);
        normal.is_some_and(|normal| self.top_speed_along(normal) > 0.0)
    }

    fn motions_at(&self, time: f64) -> [Motion; 2] {
        [0, 1].map(|side| match self.drives[side] {
            None => self.motions[side].at(time),
            Some(drive) => drive.applied(self.motions[side], time),
        })
    }

    /// The time of the first meeting before `horizon` of two bodies of which one is driven: steps
    /// in which they cannot meet at their top speed.
    fn driven_meeting(&self, horizon: f64) -> Option<f64> {
        let mut time = 0.0;
        let top_speed = match self.normal_of_across() {
            // Along a wall across the box they may go on for ever.
            Some(normal) => self.top_speed_along(normal),
            None => self.top_speed,
        };
        for _ in 0..MAX_DRIVEN_STEPS {
            let gap = self.gap(time);
            if gap <= MARGIN * self.rounding {
                return Some(time);
            }
            // Half of the margin is left, so that they are still apart where the search ends.
            time += (gap - 0.5 * MARGIN * self.rounding) / top_speed;
            if time > horizon || time.is_nan() {
                return None;
            }
        }
        Some(time)
    }

    /// The time of the first meeting before `horizon`, less the time in which the bodies travel the
    /// last few roundings; 0 if that is over.
    fn meeting(&self, horizon: f64) -> Option<f64> {
        if self.drives != [None; 2] {
            return self.driven_meeting(horizon);
        }
        let time = self.first_contact(horizon)?;
        let rate = (self.gap(time - self.probe) - self.gap(time)) / self.probe;
        let margin = MARGIN * self.rounding / rate;
        if !(rate > 0.0 && margin <= self.probe) {
            // They touch without a measurable approach.
            return None;
        }
        // At the last look before the meeting, about `margin` is left.
        Some(if time <= 2.0 * margin {
            0.0
        } else {
            time - margin
        })
    }

    /// The first time before `horizon` at which the surfaces of bodies that are apart touch, or at
    /// which the search ends.
    fn first_contact(&self, horizon: f64) -> Option<f64> {
        if self.is_across(0) && self.is_across(1) {
            // They are parallel: the distance of their lines is linear in time.
            let [distance, rate] = self.distance_of_lines(0.0);
            let approach = -distance.signum() * rate;
            let time = (distance.abs() - self.radii()) / approach;
            return (approach > 0.0 && time <= horizon).then_some(time);
        }
        let turns = self
            .motions
            .iter()
            .any(|motion| motion.angular_velocity != 0.0);
        let are_walls = self.bodies.iter().all(|body| body.is_wall());
        if are_walls && !turns {
            return self.contact_of_ends(horizon);
        }
        let detector = Exact::default();
        // Two walls without thickness have no distance at which they touch.
        let thicker = self.bodies[0].molecule().wall_edge().filter(|_| are_walls);
        let thicker = thicker.and_then(|edge| {
            let span = 2.0 * edge.half_length() * edge.along();
            let radius = edge.radius() + self.thickness;
            if self.is_across(0) {
                Molecule::wall_without_ends(span, radius).ok()
            } else {
                Molecule::wall_about(span, edge.middle(), radius).ok()
            }
        });
        let [a, b] = self.bodies.map(Body::molecule);
        let [a, b] = [thicker.as_ref().unwrap_or(a), b].map(Molecule::outline);
        let mut now = 0.0;
        for _ in 0..MAX_SEARCHES {
            let [motion_a, motion_b] = self.motions;
            let relative = RelativeMotion::between(motion_a, motion_b, self.shift, now);
            let answer = detector.first_contact(a, b, &relative, horizon - now);
            match answer.outcome {
                // Out of range: far beyond all lengths of a scene.
                Outcome::Free | Outcome::OutOfRange => return None,
                Outcome::Contact(contact) => return Some(now + contact.time),
                Outcome::FreeUntil(time) => now = (now + time).max(f64::next_up(now)),
                Outcome::Unresolved(time) => return Some(now + time),
            }
        }
        Some(now)
    }
}

#[cfg(test)]
mod tests {
    use crate::{Scene, Simulation, scene::error::RunError};

    /// The time at which a run ends because walls meet.
    fn end(walls: &str) -> Option<f64> {
        let mut simulation = Simulation::new(&Scene::from_toml(walls).unwrap()).unwrap();
        match simulation.run_until(10.0) {
            Ok(()) => None,
            Err(RunError::WallsMeet { time, .. }) => Some(time.to_f64()),
            Err(other) => panic!("{other}"),
        }
    }

    const PISTON: &str = "[[wall]]\nx = 0.25\nmotion = { velocity = [0.125, 0.0] }\n";

    #[test]
    fn a_piston_ends_the_run_where_it_meets_a_fixed_body() {
        // A wall across the box, a post and the tip of a flap.
        for (body, time) in [
            ("[[wall]]\nx = 0.75", 4.0),
            ("[[wall]]\nx = 0.75\nradius = 0.05", 3.6),
            ("[[bumper]]\nat = [0.75, 0.5]\nradius = 0.125", 3.0),
            ("[[wall]]\nfrom = [0.5, 0.2]\nto = [0.7, 0.4]", 2.0),
            (
                "[[wall]]\nx = 0.75\nmotion = { velocity = [-0.125, 0.0] }",
                2.0,
            ),
            // The nearest image is behind the border of the box.
            ("[[wall]]\nx = 0.125", 7.0),
        ] {
            let found = end(&format!("{PISTON}{body}"));
            assert!(
                found.is_some_and(|t| (t - time).abs() < 1e-11),
                "{body}: {found:?}"
            );
        }
    }

    #[test]
    fn walls_that_slide_along_each_other_or_recede_do_not_meet() {
        for body in [
            // The piston slides along the sides of its cylinder, across the box and of length 2.
            "[[wall]]\ny = 0.0\n[[wall]]\nfrom = [-0.5, 0.5]\nto = [1.5, 0.5]",
            "[[wall]]\ny = 0.4",
            "[[wall]]\nx = 0.75\nmotion = { velocity = [0.125, 0.0] }",
            "",
        ] {
            assert_eq!(end(&format!("{PISTON}{body}")), None, "{body}");
        }
        // A short piston whose ends touch the sides.
        let short = "[[wall]]\ny = 0.2\n[[wall]]\ny = 0.7\n\
                     [[wall]]\nfrom = [0.1, 0.2]\nto = [0.1, 0.7]\nmotion = { velocity = [0.25, 0.0] }";
        assert_eq!(end(short), None);
        // One that leaves the place where it touches a wall.
        let leaving = "[[wall]]\nx = 0.5\n[[wall]]\nfrom = [0.5, 0.2]\nto = [0.5, 0.7]\n\
                       motion = { velocity = [0.02, 0.0] }";
        assert_eq!(end(leaving), None);
    }

    /// A wall that oscillates along itself, at a distance of 10⁻¹² from a disc that it never meets.
    #[test]
    fn a_wall_that_oscillates_along_itself_meets_nothing() {
        let beside = "[[bumper]]\nradius = 0.125\nat = [0.625000000001, 0.5]\n\
            [[wall]]\nx = 0.5\nmotion = { amplitude = [0.0, 0.1], frequency = 8.0 }";
        assert_eq!(end(beside), None);
        let across = beside.replace("[0.0, 0.1]", "[0.1, 0.0]");
        assert!(end(&across).is_some_and(|time| time < 1e-10));
    }

    #[test]
    fn a_meeting_names_both_walls_and_stays_where_it_is() {
        let walls = format!("{PISTON}tags = [\"piston\"]\n[[wall]]\nx = 0.75\ntags = [\"stop\"]");
        let mut simulation = Simulation::new(&Scene::from_toml(&walls).unwrap()).unwrap();
        for _ in 0..3 {
            let words = simulation.run_until(10.0).unwrap_err().to_string();
            assert!(
                words.contains("(tag piston)") && words.contains("(tag stop)"),
                "{words}"
            );
            assert!((simulation.time().to_f64() - 4.0).abs() < 1e-11);
        }
    }
}
