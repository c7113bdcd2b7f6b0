//! Where and when the path of a body between two known positions crosses a segment.

use std::collections::BTreeSet;

use carom_geometry::PeriodicBox;
use carom_kinematics::{DragClock, EpochTime};
use glam::DVec2;
use serde::{Deserialize, Serialize};

/// A directed segment, and its images in all boxes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Segment {
    start: DVec2,
    /// Unit vector to the end.
    along: DVec2,
    length: f64,
}

/// A body whose path is known from here on: a straight line, or a parabola.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(super) struct OpenPath {
    pub(super) position: DVec2,
    pub(super) velocity: DVec2,
    pub(super) since: EpochTime,
    /// Acceleration (length / time²).
    pub(super) gravity: DVec2,
    /// The clock on which a path without gravity is uniform.
    pub(super) clock: DragClock,
}

/// The end of a flight: a position as the engine gives it, in whatever box, and the time.
#[derive(Debug, Clone, Copy)]
pub(super) struct FlightEnd {
    pub(super) position: DVec2,
    pub(super) time: EpochTime,
}

/// A passage of a body through the segment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Passage {
    /// From the start of the flight (time).
    pub(super) after: f64,
    pub(super) is_forward: bool,
    /// From the start of the segment (length).
    pub(super) place: f64,
    /// Along the segment and across it (length / time).
    pub(super) velocity: [f64; 2],
}

/// A flight through more boxes is left out.
const MAX_BOXES: f64 = 1e6;

impl Segment {
    /// `None` if the two points are one, or so far apart that their distance is infinite.
    pub(super) fn new(start: DVec2, end: DVec2) -> Option<Self> {
        let along = (end - start).try_normalize()?;
        let length = start.distance(end);
        length.is_finite().then_some(Self {
            start,
            along,
            length,
        })
    }

    pub(super) fn length(&self) -> f64 {
        self.length
    }

    /// Distance of a place from the line of the segment, shifted by a vector; positive to the left.
    fn distance(&self, place: DVec2, shift: DVec2) -> f64 {
        (place - (self.start + shift)).dot(self.along.perp())
    }

    /// All passages of a flight, in no order; `None` if it is too long to count them.
    ///
    /// The two sides of the line are those of the positions that the engine gives, found in the
    /// same way at the end of a flight as at the start of the next: no rounding of the path loses a
    /// passage or counts it twice.
    pub(super) fn passages(
        &self,
        flight: &OpenPath,
        end: FlightEnd,
        bounds: &PeriodicBox,
    ) -> Option<Vec<Passage>> {
        let path = Path::new(flight, end.time.since(flight.since));
        let sides = bounds.sides();
        let boxes = ((flight.position + path.place(path.duration) - end.position) / sides).round();
        let mut passages = Vec::new();
        for image in self.images(flight, &path, sides)? {
            let there = bounds.shift(image);
            let back = bounds.shift([0, 1].map(|axis| image[axis] - boxes[axis] as i64));
            let distances = [
                self.distance(flight.position, there),
                self.distance(end.position, back),
            ];
            self.through_image(flight.position - there, &path, distances, &mut passages);
        }
        Some(passages)
    }

    /// The boxes whose image of the segment may lie on the path, found piece by piece, each of
    /// which is about as long as a box.
    fn images(&self, flight: &OpenPath, path: &Path, sides: DVec2) -> Option<BTreeSet<[i64; 2]>> {
        let (low, high) = path.range(0.0, path.duration);
        let boxes = ((high - low) / sides).max_element().ceil().max(1.0);
        if boxes.is_nan() || boxes > MAX_BOXES {
            return None;
        }
        let ends = [self.start, self.start + self.length * self.along];
        let (near, far) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        let mut images = BTreeSet::new();
        for piece in 0..boxes as u32 {
            let [begin, end] = [piece, piece + 1].map(|n| path.duration * (f64::from(n) / boxes));
            let (low, high) = path.range(begin, end);
            // One more on both sides, for rounding.
            let first = ((flight.position + low - far) / sides).ceil() - 1.0;
            let last = ((flight.position + high - near) / sides).floor() + 1.0;
            for row in first.y as i64..=last.y as i64 {
                images.extend((first.x as i64..=last.x as i64).map(|column| [column, row]));
            }
        }
        Some(images)
    }

    /// Adds the passages through one image, relative to which the flight begins at `start`.
    ///
    /// Along a piece on which it nears the line or leaves it, it crosses once if it ends on the
    /// other side.
    fn through_image(
        &self,
        start: DVec2,
        path: &Path,
        distances: [f64; 2],
        passages: &mut Vec<Passage>,
    ) {
        let normal = self.along.perp();
        let from_start = |reading: f64| distances[0] + normal.dot(path.place(reading));
        let turn = path.turn(normal);
        let middle = turn.map(|reading| (reading, from_start(reading)));
        let ends = [(0.0, distances[0]), (path.duration, distances[1])];
        let knots = [Some(ends[0]), middle, Some(ends[1])];
        let knots: Vec<(f64, f64)> = knots.into_iter().flatten().collect();
        for piece in knots.windows(2) {
            let [(_, before), (_, after)] = [piece[0], piece[1]];
            if (before > 0.0) == (after > 0.0) {
                continue;
            }
            let reading = path.crossing([piece[0], piece[1]], normal, distances[0]);
            let place = (start + path.place(reading) - self.start).dot(self.along);
            if (0.0..self.length).contains(&place) {
                let velocity = path.velocity(reading);
                passages.push(Passage {
                    after: path.clock.duration(reading),
                    is_forward: after > 0.0,
                    place,
                    velocity: [velocity.dot(self.along), velocity.dot(normal)],
                });
            }
        }
    }
}

/// The path of a flight from its start, in the reading of its clock: v s + g s²/2.
struct Path {
    velocity: DVec2,
    gravity: DVec2,
    clock: DragClock,
    /// The reading at the end (time).
    duration: f64,
}

impl Path {
    fn new(flight: &OpenPath, duration: f64) -> Self {
        Self {
            velocity: flight.velocity,
            gravity: flight.gravity,
            clock: flight.clock,
            duration: flight.clock.reading(duration),
        }
    }

    fn place(&self, reading: f64) -> DVec2 {
        reading * (self.velocity + (0.5 * reading) * self.gravity)
    }

    fn velocity(&self, reading: f64) -> DVec2 {
        self.clock.slowing(reading) * self.velocity + reading * self.gravity
    }

    /// Where it turns back along a direction; `None` if it does not.
    fn turn(&self, direction: DVec2) -> Option<f64> {
        let reading = -self.velocity.dot(direction) / self.gravity.dot(direction);
        (reading > 0.0 && reading < self.duration).then_some(reading)
    }

    /// The lowest and the highest coordinates of its places from one reading to another.
    fn range(&self, begin: f64, end: f64) -> (DVec2, DVec2) {
        let turns = [DVec2::X, DVec2::Y].map(|axis| self.turn(axis));
        let inside = turns
            .into_iter()
            .flatten()
            .filter(|turn| (begin..end).contains(turn));
        let places = || {
            inside
                .clone()
                .chain([begin, end])
                .map(|reading| self.place(reading))
        };
        let low = places().fold(DVec2::INFINITY, DVec2::min);
        (low, places().fold(DVec2::NEG_INFINITY, DVec2::max))
    }

    /// The reading at which it crosses a line with this normal, on a piece of the path with the
    /// distances of the line at both ends, at the distance `start` at first.
    fn crossing(&self, piece: [(f64, f64); 2], normal: DVec2, start: f64) -> f64 {
        let [(begin, before), (end, after)] = piece;
        let (rate, curvature) = (self.velocity.dot(normal), self.gravity.dot(normal));
        let straight = begin + (end - begin) * (before / (before - after));
        if curvature == 0.0 {
            return straight.clamp(begin, end);
        }
        // The two roots of the parabola, without cancellation.
        let root = (rate * rate - 2.0 * curvature * start).max(0.0).sqrt();
        let sum = -(rate + root.copysign(rate));
        let off = |reading: &f64| (reading - reading.clamp(begin, end)).abs();
        let roots = [sum / curvature, 2.0 * start / sum];
        let nearest = roots.into_iter().filter(|root| root.is_finite());
        let nearest = nearest.min_by(|a, b| off(a).total_cmp(&off(b)));
        nearest.unwrap_or(straight).clamp(begin, end)
    }
}
