//! Independent kinematics: positions of bodies between reported events, and their gaps, with
//! double-double positions.
//!
//! Only plain data come from the layers under test: offsets and radii of atoms, the halves of
//! walls, and the states in reports. A state is propagated from its own time, not from the motions
//! that the engine stores.

use carom_geometry::Molecule;
use carom_kinematics::{EpochTime, Motion};
use carom_testkit::oracle::{DoubleDouble, Number as _};

pub use super::durations::duration;
pub use super::vectors::{BodyPair, along, cross, dot, length, rotated};
use super::{
    axis_motion::{AxisState, PistonSpring},
    convex::{ConvexPart, OutlineEllipse, farthest_tangents},
    oscillation::WallOscillation,
    stops::{PistonStops, ReflectedFlight},
    table_path::TablePath,
};

/// A body's state at some time.
#[derive(Debug, Clone, Copy)]
pub struct BodyState {
    /// The time.
    pub time: EpochTime,
    /// Position of the centre of mass (length).
    pub place: BodyPair,
    /// Its velocity (length per time).
    pub velocity: BodyPair,
    /// Orientation (turns).
    pub turns: f64,
    /// Angular velocity (radians per time).
    pub spin: f64,
    /// Drag γ, with which velocity and spin fall as exp(−γ t) (1 / time).
    pub drag: f64,
    /// Acceleration by gravity, and of a piston by its force, without that by its spring (length
    /// per time²); excludes a drag.
    pub gravity: BodyPair,
    /// The oscillation of a wall, from a time at which it was at `place`; excludes all others.
    pub oscillation: Option<WallOscillation>,
    /// The path of a wall with a table, from a time at which it was at `place`; excludes all
    /// others.
    pub table: Option<TablePath>,
    /// The stops of a piston.
    pub stops: Option<PistonStops>,
    /// The spring of a piston.
    pub spring: Option<PistonSpring>,
    /// When a piston has last left a stop that is not elastic.
    pub last_stop: Option<EpochTime>,
}

/// Placement of a body at one time.
#[derive(Debug, Clone, Copy)]
pub struct Placed {
    /// Position of the centre of mass, in the box (length).
    pub place: BodyPair,
    /// Cosine and sine of its orientation.
    pub rotation: BodyPair,
}

/// The parts of a shape that determine distances.
#[derive(Debug, Clone)]
pub struct BodyOutline {
    /// Offset and radius of each atom (length).
    pub atoms: Vec<(BodyPair, f64)>,
    /// The shape of each atom, if any is an ellipse; else empty.
    pub ellipses: Vec<OutlineEllipse>,
    /// Straight edges.
    pub edges: Vec<OutlineEdge>,
    /// Whether this is a wall: a single edge, about its centre or about a pivot.
    pub is_wall: bool,
    /// Largest distance of any point of the body from its centre (length).
    pub reach: f64,
    /// Largest distance from the centre or, for a wall, from its edge (length).
    pub thickness: f64,
}

/// A straight edge of a body.
#[derive(Debug, Clone, Copy)]
pub struct OutlineEdge {
    /// From the centre of mass to its middle (length).
    pub middle: BodyPair,
    /// From its middle to its second end (length).
    pub half: BodyPair,
    /// Half its thickness (length).
    pub radius: f64,
}

/// A part of a body: an atom, or an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BodyPart {
    /// An atom, by index.
    Atom(usize),
    /// An edge, by index.
    Edge(usize),
}

/// Relative speeds along the normal of the two points that touch.
#[derive(Debug, Clone, Copy)]
pub struct NormalSpeeds {
    /// Approach speed before the contact (length per time).
    pub approach: f64,
    /// Separation speed after it (length per time).
    pub parting: f64,
    /// Bound on the error of each (length per time).
    pub error: f64,
}

/// Relative placement of two parts.
#[derive(Debug, Clone, Copy)]
pub struct TouchedParts {
    /// Distance between their surfaces (length); negative if they overlap.
    pub gap: f64,
    /// Unit vector from the first to the second.
    pub normal: BodyPair,
    /// Distance between the centres of two atoms, or between a centre and the line of the edge; the
    /// least of it and of the sum of the radii of curvature where a part is an ellipse (length).
    pub distance: f64,
    /// Vectors from the centres of mass to the atoms, or to the foot on the edge, or to the point
    /// of contact on a body with ellipses (length).
    pub arms: [BodyPair; 2],
    /// The most that an arm moves if a place of the bodies is off by 1.
    pub arm_sensitivity: f64,
    /// Distances of the surfaces from the ends of the arms (length).
    pub radii: [f64; 2],
}

impl TouchedParts {
    /// These parts with arms to the point of contact, on the surface of each.
    #[must_use]
    pub fn at_surfaces(&self) -> Self {
        let [a, b] = self.arms;
        let arms = [
            along(a, self.radii[0], self.normal),
            along(b, -self.radii[1], self.normal),
        ];
        Self { arms, ..*self }
    }

    /// The placement of the first part relative to the second.
    fn reversed(self) -> Self {
        Self {
            normal: [-self.normal[0], -self.normal[1]],
            arms: [self.arms[1], self.arms[0]],
            radii: [self.radii[1], self.radii[0]],
            ..self
        }
    }
}

/// exp(x) − 1: its series at x/2ᵏ, and k times E(2x) = E(x) (2 + E(x)), of which no term cancels
/// for x < 0.
fn exp_minus_one(x: &DoubleDouble) -> DoubleDouble {
    /// Terms of the series: (1/16)²⁰/20! is below 10⁻⁴².
    const TERMS: i32 = 20;
    let mut halvings = 0;
    let mut scale = 1.0;
    while x.value().abs() * scale > 1.0 / 16.0 && halvings < 64 {
        (scale, halvings) = (0.5 * scale, halvings + 1);
    }
    let x = x.times(&DoubleDouble::new(scale));
    let one = DoubleDouble::new(1.0);
    let sum = (2..=TERMS).rev().fold(one, |sum, n| {
        one.plus(&sum.times(&x).over(&DoubleDouble::new(f64::from(n))))
    });
    let double = |e: DoubleDouble, _| e.times(&e.plus(&DoubleDouble::new(2.0)));
    (0..halvings).fold(sum.times(&x), double)
}

impl BodyState {
    /// The state of a motion at `time`, for which it is valid, with a drag (1 / time).
    pub fn new(motion: &Motion, time: EpochTime, drag: f64) -> Self {
        Self {
            time,
            place: motion.position.to_array(),
            velocity: motion.velocity.to_array(),
            turns: motion.orientation.turns(),
            spin: motion.angular_velocity,
            drag,
            gravity: [0.0; 2],
            oscillation: None,
            table: None,
            stops: None,
            spring: None,
            last_stop: None,
        }
    }

    /// Returns true if velocity and spin do not change.
    pub fn is_uniform(&self) -> bool {
        let is_driven = self.oscillation.is_some() || self.table.is_some() || self.stops.is_some();
        self.drag == 0.0 && self.gravity == [0.0; 2] && !is_driven
    }

    /// The time that a body without drag needs for the path of this one until `time`:
    /// (1 − exp(−γ t))/γ.
    fn time_of_path(&self, time: EpochTime) -> DoubleDouble {
        let duration = duration(self.time, time);
        if self.drag == 0.0 {
            return duration;
        }
        let drag = DoubleDouble::new(self.drag);
        let zero = DoubleDouble::new(0.0);
        let exponent = zero.minus(&drag.times(&duration));
        zero.minus(&exp_minus_one(&exponent)).over(&drag)
    }

    /// Length of the path until `time` (length).
    pub fn path_until(&self, time: EpochTime) -> f64 {
        (length(self.velocity) * self.time_of_path(time).value()).abs()
    }

    /// The share of its velocity and spin that the body has left at `time`; 1 without drag.
    pub fn slowing(&self, time: EpochTime) -> f64 {
        libm::exp(-self.decay(time))
    }

    /// γ t until `time`.
    pub fn decay(&self, time: EpochTime) -> f64 {
        self.drag * duration(self.time, time).value()
    }

    /// The state at which the body returns on its path, at `time`.
    #[must_use]
    pub fn reversed(&self, time: EpochTime) -> Self {
        let back = |velocity: f64| -velocity;
        let reversed = Self {
            velocity: self.velocity.map(back),
            spin: -self.spin,
            oscillation: self.oscillation.map(|one| one.reversed(time)),
            ..*self
        };
        let Some(table) = &self.table else {
            return reversed;
        };
        // The path of a table goes on from here.
        let way = table.displacement(time).map(|way| way.value());
        Self {
            time,
            place: along(self.place, 1.0, way),
            table: Some(table.reversed(time)),
            ..reversed
        }
    }

    /// Displacement until `time` (length).
    pub fn displacement(&self, time: EpochTime) -> [DoubleDouble; 2] {
        if let Some(oscillation) = &self.oscillation {
            return oscillation.displacement(time);
        }
        if let Some(table) = &self.table {
            return table.displacement(time);
        }
        if let Some((stops, state)) = self.along_axis() {
            let mut way = [DoubleDouble::new(0.0); 2];
            way[stops.axis] = stops.displacement(state, time);
            return way;
        }
        let duration = self.time_of_path(time);
        [0, 1].map(|axis| {
            let path = DoubleDouble::new(self.velocity[axis]).times(&duration);
            if self.gravity[axis] == 0.0 {
                return path;
            }
            let half = DoubleDouble::new(0.5 * self.gravity[axis]);
            path.plus(&half.times(&duration).times(&duration))
        })
    }

    /// Velocity at another time without events in between (length per time).
    pub fn velocity_at(&self, time: EpochTime) -> BodyPair {
        if let Some(oscillation) = &self.oscillation {
            return oscillation.velocity(time);
        }
        if let Some(table) = &self.table {
            return table.velocity(time);
        }
        if let Some((stops, state)) = self.along_axis() {
            let mut velocity = [0.0; 2];
            velocity[stops.axis] = stops.velocity(state, time);
            return velocity;
        }
        if self.drag != 0.0 {
            let left = self.slowing(time);
            return self.velocity.map(|velocity| left * velocity);
        }
        let duration = duration(self.time, time);
        [0, 1].map(|axis| {
            let gained = DoubleDouble::new(self.gravity[axis]).times(&duration);
            DoubleDouble::new(self.velocity[axis]).plus(&gained).value()
        })
    }

    /// The highest speed until `time` (length per time).
    pub fn top_speed(&self, time: EpochTime) -> f64 {
        if let Some(oscillation) = &self.oscillation {
            return oscillation.top_speed();
        }
        if let Some(table) = &self.table {
            return table.top_speed();
        }
        if let Some((stops, state)) = self.along_axis() {
            return state.top_speed(stops.ends);
        }
        length(self.velocity).max(length(self.velocity_at(time)))
    }

    /// The largest magnitude of the acceleration by gravity, and by the force and the spring of a
    /// piston anywhere between its stops (length per time²).
    pub fn top_acceleration(&self) -> f64 {
        match self.along_axis() {
            None => length(self.gravity),
            Some((stops, state)) => state.top_acceleration(stops.ends),
        }
    }

    /// The acceleration whose product with a displacement is the change of ½ v² on this way by
    /// gravity, and by the force and the spring of a piston (length per time²).
    pub fn mean_acceleration(&self, way: BodyPair) -> BodyPair {
        let mut mean = self.gravity;
        if let Some((PistonStops { axis, .. }, state)) = self.along_axis() {
            mean[axis] = state.mean_acceleration(self.place[axis] + way[axis]);
        }
        mean
    }

    /// The stops of a piston, and its motion along its axis; `None` for other bodies.
    pub fn along_axis(&self) -> Option<(PistonStops, AxisState)> {
        let stops = self.stops?;
        let axis = stops.axis;
        let state = AxisState {
            time: self.time,
            place: self.place[axis],
            velocity: self.velocity[axis],
            acceleration: self.gravity[axis],
            spring: self.spring,
            last_stop: self.last_stop,
        };
        Some((stops, state))
    }

    /// The state of a piston after its last reflection before a time, and the flight up to it;
    /// `None` for other bodies.
    pub fn reflected(&self, time: EpochTime) -> Option<(Self, ReflectedFlight)> {
        let (stops, state) = self.along_axis()?;
        let flight = stops.flight(state, time);
        let mut after = *self;
        after.time = flight.state.time;
        after.place[stops.axis] = flight.state.place;
        after.velocity[stops.axis] = flight.state.velocity;
        after.last_stop = flight.state.last_stop;
        Some((after, flight))
    }

    /// Placement at another time without events in between, in a box of these sides.
    pub fn at(&self, time: EpochTime, sides: BodyPair) -> Placed {
        let duration = self.time_of_path(time);
        let displacement = self.displacement(time);
        let coordinate = |axis: usize| {
            let place = DoubleDouble::new(self.place[axis]).plus(&displacement[axis]);
            let boxes = (place.value() / sides[axis]).floor();
            place
                .minus(&DoubleDouble::new(boxes).times(&DoubleDouble::new(sides[axis])))
                .value()
        };
        let rotation =
            DoubleDouble::cos_sin(self.turns, self.spin, &duration).map(|number| number.value());
        Placed {
            place: [coordinate(0), coordinate(1)],
            rotation,
        }
    }

    /// Rotation up to `time` (radians).
    pub fn angle_until(&self, time: EpochTime) -> f64 {
        (self.spin * self.time_of_path(time).value()).abs()
    }
}

/// Length of a wall across the box, in sides of the box: more than 1, so that no contact is at an
/// end.
const WITHOUT_ENDS: f64 = 1.0 + 1.0 / 64.0;

impl BodyOutline {
    /// Outline of a molecule or a wall.
    pub fn new(molecule: &Molecule) -> Self {
        let atoms: Vec<(BodyPair, f64)> = molecule
            .atoms()
            .iter()
            .map(|atom| (atom.offset().to_array(), atom.radius()))
            .collect();
        let ellipses: Vec<OutlineEllipse> = molecule
            .ellipses()
            .iter()
            .map(|ellipse| OutlineEllipse {
                axes: ellipse.axes(),
                along: ellipse.along().to_array(),
            })
            .collect();
        // A wall across the box has no ends, where its next image begins.
        let longer = if molecule.is_wall() && molecule.atoms().is_empty() {
            WITHOUT_ENDS
        } else {
            1.0
        };
        let edges: Vec<OutlineEdge> = molecule
            .edges()
            .iter()
            .map(|edge| OutlineEdge {
                middle: edge.middle().to_array(),
                half: (longer * edge.half_length() * edge.along()).to_array(),
                radius: edge.radius(),
            })
            .collect();
        let of_atoms = atoms
            .iter()
            .map(|(offset, radius)| length(*offset) + radius)
            .fold(0.0, f64::max);
        let is_wall = molecule.is_wall();
        let (reach, thickness) = match edges[..] {
            [
                OutlineEdge {
                    middle,
                    half,
                    radius,
                },
            ] if is_wall => (length(middle) + length(half) + radius, radius),
            _ => (of_atoms, of_atoms),
        };
        Self {
            atoms,
            ellipses,
            edges,
            is_wall,
            reach,
            thickness,
        }
    }

    /// Outline of a disc that touches others at this multiple of its radius.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let mut scaled = self.clone();
        for (_, radius) in &mut scaled.atoms {
            *radius *= factor;
        }
        scaled.reach *= factor;
        scaled.thickness *= factor;
        scaled
    }

    /// Outline of a body with the ends of a wall across the box, on which two such walls meet.
    #[must_use]
    pub fn with_ends(&self) -> Self {
        let mut outline = self.clone();
        if self.is_wall && self.atoms.is_empty() {
            let ends = |edge: &OutlineEdge| {
                [-1.0, 1.0].map(|end| (along(edge.middle, end, edge.half), edge.radius))
            };
            outline.atoms = self.edges.iter().flat_map(ends).collect();
        }
        outline
    }

    /// Outline of a wall with a larger radius (length), or of another body as it is.
    #[must_use]
    pub fn thickened(&self, by: f64) -> Self {
        let mut outline = self.clone();
        if self.is_wall {
            let atoms = outline.atoms.iter_mut().map(|(_, radius)| radius);
            let edges = outline.edges.iter_mut().map(|edge| &mut edge.radius);
            let all = [&mut outline.reach, &mut outline.thickness];
            atoms
                .chain(edges)
                .chain(all)
                .for_each(|radius| *radius += by);
        }
        outline
    }

    /// Returns true for a single atom, which has no orientation.
    pub fn is_disc(&self) -> bool {
        self.atoms.len() == 1 && self.edges.is_empty() && self.ellipses.is_empty()
    }

    /// Radius of the smallest atom; infinite for a wall (length).
    pub fn smallest(&self) -> f64 {
        self.atoms
            .iter()
            .map(|(_, radius)| *radius)
            .fold(f64::INFINITY, f64::min)
    }

    /// A part at rest, with the centre of mass at `origin`.
    fn convex(&self, part: BodyPart, origin: BodyPair, rotation: BodyPair) -> ConvexPart {
        match part {
            BodyPart::Atom(index) => {
                let (offset, radius) = self.atoms[index];
                let centre = along(origin, 1.0, rotated(offset, rotation));
                match self.ellipses.get(index) {
                    Some(ellipse) => ellipse.placed(centre, rotation),
                    None => ConvexPart {
                        centre,
                        axis: rotation,
                        axes: [0.0; 2],
                        half: 0.0,
                        radius,
                    },
                }
            }
            BodyPart::Edge(index) => {
                let edge = self.edges[index];
                let half = length(edge.half);
                ConvexPart {
                    centre: along(origin, 1.0, rotated(edge.middle, rotation)),
                    axis: rotated([edge.half[0] / half, edge.half[1] / half], rotation),
                    axes: [0.0; 2],
                    half,
                    radius: edge.radius,
                }
            }
        }
    }

    fn parts(&self) -> impl Iterator<Item = BodyPart> + '_ {
        (0..self.atoms.len())
            .map(BodyPart::Atom)
            .chain((0..self.edges.len()).map(BodyPart::Edge))
    }
}

/// Relative placement of a part of A and a part of B at `separation` from A; `None` for two edges.
fn touch(
    (a, turn_a, part_a): (&BodyOutline, BodyPair, BodyPart),
    (b, turn_b, part_b): (&BodyOutline, BodyPair, BodyPart),
    separation: BodyPair,
) -> Option<TouchedParts> {
    let has_ellipses = !(a.ellipses.is_empty() && b.ellipses.is_empty());
    if has_ellipses
        && [part_a, part_b]
            .iter()
            .any(|part| matches!(part, BodyPart::Atom(_)))
    {
        let (at_a, at_b) = ((a, turn_a, part_a), (b, turn_b, part_b));
        return Some(touch_of_ellipses(at_a, at_b, separation));
    }
    match (part_a, part_b) {
        (BodyPart::Atom(i), BodyPart::Atom(j)) => {
            let circles = [(a.atoms[i], turn_a), (b.atoms[j], turn_b)];
            Some(touch_of_circles(circles, separation))
        }
        (BodyPart::Edge(i), BodyPart::Atom(j)) => {
            let (edge, circle) = ((a.edges[i], turn_a), (b.atoms[j], turn_b));
            Some(touch_of_edge(edge, circle, separation))
        }
        (BodyPart::Atom(i), BodyPart::Edge(j)) => {
            let (edge, circle) = ((b.edges[j], turn_b), (a.atoms[i], turn_a));
            let back = [-separation[0], -separation[1]];
            Some(touch_of_edge(edge, circle, back).reversed())
        }
        (BodyPart::Edge(_), BodyPart::Edge(_)) => None,
    }
}

/// Relative placement of two circles, each an offset and a radius with the rotation of its body.
fn touch_of_circles(
    [
        ((offset_a, radius_a), turn_a),
        ((offset_b, radius_b), turn_b),
    ]: [((BodyPair, f64), BodyPair); 2],
    separation: BodyPair,
) -> TouchedParts {
    let arms = [rotated(offset_a, turn_a), rotated(offset_b, turn_b)];
    let d = along(along(separation, 1.0, arms[1]), -1.0, arms[0]);
    let distance = length(d);
    TouchedParts {
        gap: distance - (radius_a + radius_b),
        normal: [d[0] / distance, d[1] / distance],
        distance,
        arms,
        arm_sensitivity: 1.0,
        radii: [radius_a, radius_b],
    }
}

/// Relative placement of an edge of A and a circle of B, each with the rotation of its body.
fn touch_of_edge(
    (edge, turn_a): (OutlineEdge, BodyPair),
    ((offset, radius), turn_b): ((BodyPair, f64), BodyPair),
    separation: BodyPair,
) -> TouchedParts {
    let arm = rotated(offset, turn_b);
    let place = along(separation, 1.0, arm);
    let from_middle = along(place, -1.0, rotated(edge.middle, turn_a));
    let (distance, normal) = from_edge(rotated(edge.half, turn_a), from_middle);
    TouchedParts {
        gap: distance - (edge.radius + radius),
        normal,
        distance,
        arms: [along(place, -distance, normal), arm],
        arm_sensitivity: 1.0,
        radii: [edge.radius, radius],
    }
}

/// Relative placement of two parts of bodies of which one has ellipses. The arm of such a body ends
/// at the point of contact.
fn touch_of_ellipses(
    (a, turn_a, part_a): (&BodyOutline, BodyPair, BodyPart),
    (b, turn_b, part_b): (&BodyOutline, BodyPair, BodyPart),
    separation: BodyPair,
) -> TouchedParts {
    let parts = [
        a.convex(part_a, [0.0; 2], turn_a),
        b.convex(part_b, separation, turn_b),
    ];
    let found = farthest_tangents(&parts[0], &parts[1]);
    let [radius_a, radius_b] = found.curvature_radii;
    let (mut arms, mut radii) = ([[0.0; 2]; 2], [0.0; 2]);
    let from = [[0.0; 2], separation];
    for (side, outline) in [a, b].into_iter().enumerate() {
        let outwards = if side == 0 { 1.0 } else { -1.0 };
        radii[side] = if outline.ellipses.is_empty() {
            parts[side].radius
        } else {
            0.0
        };
        // The arm of an edge ends across the normal from the point of the other part.
        let is_edge = parts[side].half > 0.0;
        let point = if is_edge {
            along(found.points[1 - side], -outwards * found.gap, found.normal)
        } else {
            found.points[side]
        };
        let end = along(point, -outwards * radii[side], found.normal);
        arms[side] = along(end, -1.0, from[side]);
    }
    let flattest = (radius_a / a.reach).max(radius_b / b.reach);
    TouchedParts {
        gap: found.gap,
        normal: found.normal,
        distance: (found.gap + radius_a + radius_b).min(length(along(
            parts[1].centre,
            -1.0,
            parts[0].centre,
        ))),
        arms,
        arm_sensitivity: 2.0 + 2.0 * flattest,
        radii,
    }
}

/// Distance of a point from a segment centred at the origin, and the unit vector from the segment
/// to it.
fn from_edge(half: BodyPair, point: BodyPair) -> (f64, BodyPair) {
    let size = length(half);
    let direction = [half[0] / size, half[1] / size];
    let (way, height) = (dot(direction, point), cross(direction, point));
    if way.abs() <= size {
        let normal = [-direction[1], direction[0]];
        return (
            height.abs(),
            [normal[0] * height.signum(), normal[1] * height.signum()],
        );
    }
    let off = along(point, -size * way.signum(), direction);
    let distance = length(off);
    (distance, [off[0] / distance, off[1] / distance])
}

/// Calls `visit` with the separation of every image of B within reach of A.
pub fn for_each_image(
    (a, at_a): (&BodyOutline, &Placed),
    (b, at_b): (&BodyOutline, &Placed),
    sides: BodyPair,
    mut visit: impl FnMut(BodyPair),
) {
    let d = along(at_b.place, -1.0, at_a.place);
    // The extent of a wall along an axis is that of its half.
    let extent = |outline: &BodyOutline, placed: &Placed, axis: usize| match outline.edges[..] {
        [
            OutlineEdge {
                middle,
                half,
                radius,
            },
        ] if outline.is_wall => {
            let [middle, half] = [middle, half].map(|one| rotated(one, placed.rotation)[axis]);
            middle.abs() + half.abs() + radius
        }
        _ => outline.reach,
    };
    let range = |axis: usize| {
        let reach =
            (extent(a, at_a, axis) + extent(b, at_b, axis)) * (1.0 + 1e-9) + 1e-9 * sides[axis];
        let low = ((-reach - d[axis]) / sides[axis]).ceil() as i64;
        let high = ((reach - d[axis]) / sides[axis]).floor() as i64;
        low..=high
    };
    let reach = a.reach + b.reach;
    let squared = reach * reach * (1.0 + 1e-9);
    for column in range(0) {
        for row in range(1) {
            let separation = [
                d[0] + column as f64 * sides[0],
                d[1] + row as f64 * sides[1],
            ];
            if dot(separation, separation) <= squared {
                visit(separation);
            }
        }
    }
}

/// Smallest gap between two bodies in any image (length); infinite if their bounding circles do not
/// meet.
pub fn smallest_gap(
    (a, at_a): (&BodyOutline, &Placed),
    (b, at_b): (&BodyOutline, &Placed),
    sides: BodyPair,
) -> f64 {
    let mut least = f64::INFINITY;
    for_each_image((a, at_a), (b, at_b), sides, |separation| {
        for i in a.parts() {
            for j in b.parts() {
                if let Some(found) = touch((a, at_a.rotation, i), (b, at_b.rotation, j), separation)
                {
                    least = least.min(found.gap);
                }
            }
        }
        let depth = depth_of_crossings((a, at_a.rotation), (b, at_b.rotation), separation);
        if depth > 0.0 {
            least = least.min(-depth);
        }
    });
    least
}

/// The largest depth to which an edge of A crosses one of B, 0 if none does (length): the smallest
/// distance of an end of one from the line of the other, and their radii.
fn depth_of_crossings(
    (a, turn_a): (&BodyOutline, BodyPair),
    (b, turn_b): (&BodyOutline, BodyPair),
    separation: BodyPair,
) -> f64 {
    let mut deepest = 0.0f64;
    for one in &a.edges {
        let (middle, half) = (rotated(one.middle, turn_a), rotated(one.half, turn_a));
        for other in &b.edges {
            let place = along(separation, 1.0, rotated(other.middle, turn_b));
            let between = along(place, -1.0, middle);
            let half_of_other = rotated(other.half, turn_b);
            // Heights of the ends of each above the line of the other.
            let heights = |line: BodyPair, from: BodyPair, half: BodyPair| {
                [-1.0, 1.0].map(|end| cross(line, along(from, end, half)) / length(line))
            };
            let of_other = heights(half, between, half_of_other);
            let of_one = heights(half_of_other, [-between[0], -between[1]], half);
            let is_split = |[low, high]: [f64; 2]| low * high < 0.0;
            if is_split(of_other) && is_split(of_one) {
                let ends = of_other.into_iter().chain(of_one);
                let nearest = ends.map(f64::abs).fold(f64::INFINITY, f64::min);
                deepest = deepest.max(nearest + one.radius + other.radius);
            }
        }
    }
    deepest
}

/// Relative placement of two given parts, in the image of B whose centre relative to A's is nearest
/// to `towards`; `None` if no image is within reach.
pub fn touch_in_image(
    (a, at_a, i): (&BodyOutline, &Placed, BodyPart),
    (b, at_b, j): (&BodyOutline, &Placed, BodyPart),
    sides: BodyPair,
    towards: BodyPair,
) -> Option<TouchedParts> {
    let mut best: Option<(f64, TouchedParts)> = None;
    for_each_image((a, at_a), (b, at_b), sides, |separation| {
        if let Some(found) = touch((a, at_a.rotation, i), (b, at_b.rotation, j), separation)
            && best.is_none_or(|(off, _)| length(along(separation, -1.0, towards)) < off)
        {
            best = Some((length(along(separation, -1.0, towards)), found));
        }
    });
    best.map(|(_, touch)| touch)
}

/// Distance between two positions across the periodic borders (length).
pub fn distance_in_box(a: BodyPair, b: BodyPair, sides: BodyPair) -> f64 {
    length(shortest_way(a, b, sides))
}

/// Shortest vector from a position to another across the periodic borders (length).
pub fn shortest_way(from: BodyPair, to: BodyPair, sides: BodyPair) -> BodyPair {
    [0, 1].map(|axis| {
        let d = to[axis] - from[axis];
        d - (d / sides[axis]).round() * sides[axis]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use carom_geometry::{Shape, gap_between};
    use glam::DVec2;

    fn placed(x: f64, y: f64, angle: f64) -> Placed {
        Placed {
            place: [x, y],
            rotation: [angle.cos(), angle.sin()],
        }
    }

    #[test]
    fn gaps_agree_with_those_of_the_library() {
        let tee = Molecule::named(Shape::Tee, 0.02, 1.0).unwrap();
        let wall = Molecule::wall(DVec2::new(0.5, 0.1), 0.01).unwrap();
        let outlines = [BodyOutline::new(&tee), BodyOutline::new(&wall)];
        for index in 0..200 {
            let t = f64::from(index);
            let (a, b) = (
                placed(0.5, 0.5, t),
                placed(0.5 + 0.1 * t.sin(), 0.5 + 0.1 * (3.0 * t).cos(), 2.0 * t),
            );
            let ours = smallest_gap((&outlines[0], &a), (&outlines[1], &b), [10.0; 2]);
            let turn = |at: &Placed| DVec2::from(at.rotation);
            let separation = DVec2::from(b.place) - DVec2::from(a.place);
            let theirs = gap_between(&tee, turn(&a), &wall, turn(&b), separation);
            // No gap is computed if the bounding circles do not meet.
            let apart = ours == f64::INFINITY && theirs > 0.0;
            assert!(apart || (ours - theirs).abs() < 1e-15, "{ours} {theirs}");
        }
    }

    #[test]
    fn needles_that_cross_overlap() {
        let needle = Molecule::capsule(0.2, 1e-9, 1.0).unwrap();
        let outline = BodyOutline::new(&needle);
        let gap = |x: f64| {
            let (a, b) = (
                placed(0.5, 0.5, 0.0),
                placed(0.5 + x, 0.5, std::f64::consts::FRAC_PI_2),
            );
            smallest_gap((&outline, &a), (&outline, &b), [10.0; 2])
        };
        // The end of one is 0.03 beyond, or before, the line of the other.
        assert!((gap(0.07) + (0.03 + 2e-9)).abs() < 1e-15);
        assert!((gap(0.13) - (0.03 - 2e-9)).abs() < 1e-15);
    }

    #[test]
    fn bodies_meet_through_the_border() {
        let disc = BodyOutline::new(&Molecule::disc(0.1, 1.0).unwrap());
        let (a, b) = (placed(0.05, 0.5, 0.0), placed(0.95, 0.5, 0.0));
        let gap = smallest_gap((&disc, &a), (&disc, &b), [1.0, 1.0]);
        assert!((gap + 0.1).abs() < 1e-15);
        let touch = touch_in_image(
            (&disc, &a, BodyPart::Atom(0)),
            (&disc, &b, BodyPart::Atom(0)),
            [1.0, 1.0],
            [-0.1, 0.0],
        )
        .unwrap();
        assert_eq!(touch.normal, [-1.0, 0.0]);
    }

    #[test]
    fn a_state_is_propagated_without_loss() {
        let state = BodyState {
            time: EpochTime::from(1e12),
            place: [0.25, 0.5],
            velocity: [1.0, -0.5],
            turns: 0.0,
            spin: std::f64::consts::TAU,
            drag: 0.0,
            gravity: [0.0; 2],
            oscillation: None,
            table: None,
            stops: None,
            spring: None,
            last_stop: None,
        };
        let later = state.at(
            EpochTime::from(1e12).new_epoch(1e6).after(0.125),
            [1.0, 1.0],
        );
        assert_eq!(later.place, [0.375, 0.4375]);
        assert!((later.rotation[0] - 0.5f64.sqrt()).abs() < 1e-9);
    }

    #[test]
    fn a_drag_shortens_the_path() {
        let state = |drag| BodyState {
            time: EpochTime::from(1.0),
            place: [0.0, 0.5],
            velocity: [1.0, 0.0],
            turns: 0.0,
            spin: 0.25,
            drag,
            gravity: [0.0; 2],
            oscillation: None,
            table: None,
            stops: None,
            spring: None,
            last_stop: None,
        };
        for decay in [1e-9, 1e-3, 0.3, 2.0, 9.0f64] {
            let state = state(0.5 * decay);
            let later = EpochTime::from(3.0);
            let path = -(-decay).exp_m1() / (0.5 * decay);
            let sides = [64.0, 1.0];
            assert!((state.at(later, sides).place[0] - path).abs() < 4e-16 * path);
            assert!((state.path_until(later) - path).abs() < 4e-16 * path);
            assert!((state.angle_until(later) - 0.25 * path).abs() < 4e-16 * path);
            assert!((state.slowing(later) - (-decay).exp()).abs() < 4e-16);
        }
    }

    #[test]
    fn a_body_falls_on_a_parabola() {
        let state = BodyState {
            gravity: [0.0, -2.0],
            ..BodyState::new(&Motion::at_rest(DVec2::new(0.5, 3.5)), EpochTime::ZERO, 0.0)
        };
        let state = BodyState {
            velocity: [0.25, 1.0],
            ..state
        };
        let later = EpochTime::ZERO.new_epoch(1.0).after(0.5);
        assert_eq!(state.at(later, [4.0, 4.0]).place, [0.875, 2.75]);
        assert_eq!(state.velocity_at(later), [0.25, -2.0]);
        assert_eq!(state.top_speed(later), 0.25f64.hypot(2.0));
    }

    #[test]
    fn a_wall_turns_about_its_pivot() {
        // A flap with its hinge at (0.25, 0.25), after a quarter of a turn.
        let flap = Molecule::wall_about(DVec2::new(0.5, 0.0), DVec2::new(0.25, 0.0), 0.0).unwrap();
        let (flap, disc) = (
            BodyOutline::new(&flap),
            BodyOutline::new(&Molecule::disc(0.0625, 1.0).unwrap()),
        );
        assert_eq!(flap.reach, 0.5);
        let hinge = Motion {
            angular_velocity: std::f64::consts::TAU,
            ..Motion::at_rest(DVec2::splat(0.25))
        };
        let sides = [4.0, 4.0];
        let turned = BodyState::new(&hinge, EpochTime::ZERO, 0.0).at(0.25.into(), sides);
        let gap = |x, y| smallest_gap((&flap, &turned), (&disc, &placed(x, y, 0.0)), sides);
        assert!((gap(0.3, 0.5) + 0.0125).abs() < 1e-15);
        assert!((gap(0.25, 0.8) + 0.0125).abs() < 1e-15);
    }
}
