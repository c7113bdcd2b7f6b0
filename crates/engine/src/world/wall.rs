//! Walls in the box: the distance of a point from a wall, the cells along a wall, and the frame of
//! a contact.

use carom_detection::Part;
use carom_geometry::Edge;
use carom_kinematics::{Drive, Motion};
use carom_response::ContactFrame;
use glam::DVec2;

use crate::world::{
    World,
    body::Body,
    contact_event::{ContactEvent, TouchingParts},
    rounding_bound::rounding_bound,
};

/// Sides of the polygon that is drawn for a circle.
const SIDES_OF_CIRCLE: f64 = 180.0;

/// Share of a cell's length by which the reach of a wall is enlarged, so that no rounding leaves a
/// cell out.
const MARGIN: f64 = 1e-9;

/// A wall in its home image: the position of its edge, and the cells that it passes.
#[derive(Debug, Clone, Copy)]
pub struct StandingWall {
    /// The origin of its frame (length): the middle of a straight wall, the pivot about which it
    /// turns, or the centre of an arc.
    origin: DVec2,
    /// Its middle (length).
    centre: DVec2,
    /// Half of the length of a straight wall, from the middle to the second end (length).
    half: DVec2,
    edge: Edge,
    /// (cos, sin) of its orientation.
    rotation: DVec2,
}

impl StandingWall {
    /// The wall that a body with this motion is; `None` if it is none.
    pub fn new(body: &Body, motion: &Motion) -> Option<Self> {
        let edge = *body.molecule().wall_edge()?;
        let rotation = motion.orientation.cos_sin();
        let half = edge.half_length() * rotation.rotate(edge.along());
        let middle = edge.middle();
        let centre = if middle == DVec2::ZERO {
            motion.position
        } else {
            motion.position + rotation.rotate(middle)
        };
        Some(Self {
            origin: motion.position,
            centre,
            half,
            edge,
            rotation,
        })
    }

    /// The wall in the middle of a span of time (offsets in the epoch), and the distance (length)
    /// that no point of it exceeds from its place there during the span; `None` if the body is no
    /// wall. `drive` is that of the wall ([`World::drive`]).
    pub fn during(
        body: &Body,
        motion: &Motion,
        drive: Option<&Drive>,
        span: [f64; 2],
    ) -> Option<(Self, f64)> {
        let (middle, way) = place_during(body, motion, drive, span);
        Some((Self::new(body, &middle)?, way))
    }

    /// Half its thickness (length).
    pub(crate) fn radius(&self) -> f64 {
        self.edge.radius()
    }

    /// Its middle (length).
    pub(crate) fn middle(&self) -> DVec2 {
        self.centre
    }

    /// Both ends of a straight wall (length).
    pub fn ends(&self) -> [DVec2; 2] {
        [self.centre - self.half, self.centre + self.half]
    }

    /// The corners of a rectangle along the axes that holds its line (length): the smallest one of
    /// a straight wall, and that of the whole circle of an arc.
    pub fn extent(&self) -> [DVec2; 2] {
        if let Some(bend) = self.edge.bend() {
            return [self.origin - bend.radius(), self.origin + bend.radius()];
        }
        let [first, second] = self.ends();
        [first.min(second), first.max(second)]
    }

    /// Points along its line (length): both ends of a straight wall, and of an arc enough that a
    /// polygon through them looks like it.
    pub fn line(&self) -> Vec<DVec2> {
        match self.edge.bend() {
            None => self.ends().to_vec(),
            Some(bend) => {
                let pieces = (SIDES_OF_CIRCLE * bend.half_angle() / std::f64::consts::PI).ceil();
                let points = bend.points(pieces as u32);
                points
                    .map(|point| self.origin + self.rotation.rotate(point))
                    .collect()
            }
        }
    }

    /// Distance of a point from the surface of the wall (length); negative inside it.
    pub fn gap(&self, place: DVec2) -> f64 {
        let back = DVec2::new(self.rotation.x, -self.rotation.y);
        self.edge.nearest(back.rotate(place - self.origin)).distance - self.edge.radius()
    }

    /// Every cell that has a point within `reach` (length) of the wall's surface, and a few more at
    /// its corners, as column and row of a grid with cells of `side` (length, positive).
    ///
    /// Cell [0, 0] begins at the origin. Columns and rows beyond the box are those of its images.
    pub fn cells_within(&self, reach: f64, side: DVec2) -> Vec<[i64; 2]> {
        if self.edge.bend().is_some() {
            return self.cells_of_arc(reach, side);
        }
        let reach = self.edge.radius() + reach + MARGIN * side.max_element();
        let [first, second] = self.ends();
        let (low, high) = (first.min(second) - reach, first.max(second) + reach);
        let index = |x: f64, side: f64| (x / side).floor() as i64;
        let mut cells = Vec::new();
        for row in index(low.y, side.y)..=index(high.y, side.y) {
            let band = [
                row as f64 * side.y - reach,
                (row + 1) as f64 * side.y + reach,
            ];
            // The part of the wall within reach of this row of cells.
            let part = band.map(|y| {
                if self.half.y == 0.0 {
                    y - self.centre.y
                } else {
                    (y - self.centre.y) / self.half.y
                }
            });
            let [from, to] = if self.half.y == 0.0 {
                if part[0] > 0.0 || part[1] < 0.0 {
                    continue;
                }
                [-1.0, 1.0]
            } else {
                [
                    part[0].min(part[1]).max(-1.0),
                    part[0].max(part[1]).min(1.0),
                ]
            };
            if from > to {
                continue;
            }
            let (one, other) = (
                self.centre.x + from * self.half.x,
                self.centre.x + to * self.half.x,
            );
            for column in
                index(one.min(other) - reach, side.x)..=index(one.max(other) + reach, side.x)
            {
                cells.push([column, row]);
            }
        }
        cells
    }

    /// [`Self::cells_within`] of a curved wall: of each row of cells those between two circles
    /// about the centre, unless the arc is farther from them than their half diagonal.
    fn cells_of_arc(&self, reach: f64, side: DVec2) -> Vec<[i64; 2]> {
        let reach = self.edge.radius() + reach + MARGIN * side.max_element();
        let (outer, inner) = (self.edge.reach() + reach, self.edge.reach() - reach);
        let back = DVec2::new(self.rotation.x, -self.rotation.y);
        let half_diagonal = 0.5 * side.length();
        let index = |x: f64, side: f64| (x / side).floor() as i64;
        let mut cells = Vec::new();
        for row in index(self.origin.y - outer, side.y)..=index(self.origin.y + outer, side.y) {
            let [low, high] = [row, row + 1].map(|row| row as f64 * side.y - self.origin.y);
            let nearest = low.max(-high).max(0.0);
            let farthest = low.abs().max(high.abs());
            let half_width = (outer * outer - nearest * nearest).max(0.0).sqrt();
            let hole = if inner > farthest {
                (inner * inner - farthest * farthest).sqrt() * (1.0 - MARGIN)
            } else {
                0.0
            };
            let mut add = |from: f64, to: f64| {
                for column in
                    index(self.origin.x + from, side.x)..=index(self.origin.x + to, side.x)
                {
                    let middle = (DVec2::new(column as f64, row as f64) + 0.5) * side;
                    let nearest = self.edge.nearest(back.rotate(middle - self.origin));
                    if nearest.distance.abs() <= reach + half_diagonal {
                        cells.push([column, row]);
                    }
                }
            };
            if hole > side.x {
                add(-half_width, -hole);
                add(hole, half_width);
            } else {
                add(-half_width, half_width);
            }
        }
        cells
    }
}

/// The motion of a fixed body in the middle of a span of time (offsets in the epoch), and the
/// distance (length) that no point of it exceeds from its place there during the span.
pub(crate) fn place_during(
    body: &Body,
    motion: &Motion,
    drive: Option<&Drive>,
    [from, to]: [f64; 2],
) -> (Motion, f64) {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    match drive {
        None if motion.is_at_rest() => (*motion, 0.0),
        None => (motion.at(middle), wall_speed(body, motion) * half),
        Some(drive) => {
            let way = drive.max_displacement(half, to) + wall_speed(body, motion) * half;
            (drive.applied(motion, middle), way)
        }
    }
}

/// The largest speed of a point of a wall in uniform motion (length per time).
pub(crate) fn wall_speed(body: &Body, motion: &Motion) -> f64 {
    let rim = motion.angular_velocity.abs() * body.molecule().bounding_radius();
    motion.velocity.length() + rim
}

/// Every cell of any image that has a point in a square about `centre` with half the side `reach`
/// (lengths).
pub(crate) fn cells_about(centre: DVec2, reach: f64, side: DVec2) -> Vec<[i64; 2]> {
    let [low, high] = [centre - reach, centre + reach].map(|corner| (corner / side).floor());
    let columns = low.x as i64..=high.x as i64;
    let rows = low.y as i64..=high.y as i64;
    rows.flat_map(|row| columns.clone().map(move |column| [column, row]))
        .collect()
}

/// Wraps the index of a cell of any image into the box of `counts` cells, and returns the image in
/// boxes.
pub(crate) fn folded(cell: [i64; 2], counts: [i64; 2]) -> ([i64; 2], [i32; 2]) {
    let here = [0, 1].map(|axis| cell[axis].rem_euclid(counts[axis]));
    let image = [0, 1].map(|axis| cell[axis].div_euclid(counts[axis]) as i32);
    (here, image)
}

/// Lever arms and normal of a contact with an edge, and the distance of the touching centre from
/// its line (length). None if the contact is of another kind.
///
/// The normal is that of the edge, so that the rounding of the atom's position along it does not
/// tilt it.
pub(crate) fn contact_frame(
    world: &World,
    contact: &ContactEvent,
    motions: &[Motion; 2],
) -> Option<(ContactFrame, f64)> {
    let (edged, edge, part) = match contact.parts {
        TouchingParts::EdgeOfA { edge, part } => (0, edge, part),
        TouchingParts::EdgeOfB { edge, part } => (1, edge, part),
        TouchingParts::Discs
        | TouchingParts::Atoms(..)
        | TouchingParts::BoundingCircles
        | TouchingParts::Bond(..)
        | TouchingParts::Step(_) => {
            return None;
        }
    };
    let body = |side: usize| &world.bodies[contact.bodies[side] as usize];
    let edge = &body(edged).molecule().edges()[edge as usize];
    let arm = match part {
        Part::Atom(index) => arm(body(1 - edged), index, &motions[1 - edged]),
        Part::BoundingCircle => DVec2::ZERO,
    };
    // The second body is touched in this image.
    let shift = world.shift_of(contact);
    let shift = if edged == 1 { -shift } else { shift };
    let place = ((motions[1 - edged].position - motions[edged].position) + shift) + arm;
    let rotation = motions[edged].orientation.cos_sin();
    // Of a wall across the box an end is where its next image begins.
    let rounding = if edge.is_line() {
        f64::INFINITY
    } else {
        rounding_bound(world.bounds.sides(), body(1 - edged).reach())
    };
    let nearest =
        edge.nearest_to_rounding(DVec2::new(rotation.x, -rotation.y).rotate(place), rounding);
    let outwards = rotation.rotate(nearest.direction);
    let outwards = if nearest.distance > 0.0 {
        nearest.distance * outwards
    } else {
        outwards
    };
    let foot = place - nearest.distance * rotation.rotate(nearest.direction);
    let frame = if edged == 1 {
        ContactFrame {
            line_of_centres: -outwards,
            arms: [arm, foot],
        }
    } else {
        ContactFrame {
            line_of_centres: outwards,
            arms: [foot, arm],
        }
    };
    Some((frame, nearest.distance))
}

/// Arm from the centre of mass to an atom's centre (length).
pub(crate) fn arm(body: &Body, atom: u32, motion: &Motion) -> DVec2 {
    let atom = &body.kind.molecule.atoms()[atom as usize];
    if atom.arm() == 0.0 {
        DVec2::ZERO
    } else {
        motion.orientation.cos_sin().rotate(atom.offset())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_geometry::Molecule;
    use proptest::prelude::*;

    fn standing(from: DVec2, to: DVec2, radius: f64) -> StandingWall {
        let wall = Molecule::wall(to - from, radius).unwrap();
        let edge = wall.edges()[0];
        StandingWall {
            origin: 0.5 * (from + to),
            centre: 0.5 * (from + to),
            half: 0.5 * (to - from),
            edge,
            rotation: DVec2::X,
        }
    }

    proptest! {
        #[test]
        fn every_point_within_reach_is_in_a_listed_cell(
            x in -2.0..2.0f64, y in -2.0..2.0f64, u in -2.0..2.0f64, v in -2.0..2.0f64,
            reach in 0.0..0.5f64, radius in 0.0..0.1f64, straight in 0..3u8, t in -1.2..1.2f64, off in -0.7..0.7f64,
        ) {
            let from = DVec2::new(x, y);
            let to = match straight {
                0 => DVec2::new(x, v + 4.1),
                1 => DVec2::new(u + 4.1, y),
                _ => DVec2::new(u + 4.1, v),
            };
            let wall = standing(from, to, radius);
            let side = DVec2::new(0.13, 0.21);
            let cells = wall.cells_within(reach, side);
            let place = wall.centre + t * wall.half + off * wall.half.perp().normalize();
            if wall.gap(place) <= reach {
                let cell = (place / side).floor();
                prop_assert!(cells.contains(&[cell.x as i64, cell.y as i64]));
            }
            // Not many more than those: none is farther than a few cells.
            for cell in cells {
                let middle = (DVec2::new(cell[0] as f64, cell[1] as f64) + 0.5) * side;
                prop_assert!(wall.gap(middle) <= 2.0 * (reach + side.x + side.y));
            }
        }
    }
}
