//! Crossings of a segment by the centres of mass: flux through a door, first passages, a section of
//! the paths.
//!
//! In a gas at equilibrium n √(kT/2πm) bodies of mass m cross each unit of length per time to
//! either side (n per area). In an ergodic table of area A a particle of speed v finds a small door
//! of width w at the rate κ = v w/(π A): the share exp(−κ t) has not crossed it.

mod flight;

use std::collections::BTreeMap;

use carom_engine::{Body, BodyView, CollisionReport, Observer, View};
use carom_geometry::PeriodicBox;
use carom_kinematics::{DragClock, EpochTime, Motion};
use glam::DVec2;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::Group;
use flight::{FlightEnd, OpenPath, Segment};

/// Crossings of a segment, and of its images, by the centres of the free bodies of a group.
///
/// Nothing happens to the bodies. The crossings are exact to rounding: they are found on the path
/// between contacts, a straight line or with gravity a parabola, whenever a contact or a sample
/// ends a part of it. An edit that is not announced by [`Observer::pause`] loses the crossings
/// since the last contact of each body.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{Crossings, Group};
///
/// let scene = Scene::from_toml(r#"
///     [[molecule]]
///     shape = "disc"
///     atom_radius = 0.05
///     atom_mass = 1.0
///     at = [0.25, 0.5]
///     velocity = [2.0, 0.0]
/// "#)?;
/// let mut simulation = Simulation::new(&scene)?;
/// // Upwards across the middle of the box: to its left is x < 1/2.
/// let mut crossings = Crossings::new(Group::All, [[0.5, 0.0], [0.5, 1.0]])?.logged();
/// crossings.start(&simulation.view());
/// simulation.observe_until(1.0, &mut crossings)?;
/// crossings.sample(&simulation.view());
/// assert_eq!(crossings.counts(), [0, 2]);
/// let log = crossings.take();
/// assert_eq!((log[0].time, log[1].time), (0.125, 0.625));
/// assert_eq!((log[0].place, log[0].along, log[0].across), (0.5, 0.0, -2.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "door")]
#[doc(alias = "Poincare section")]
#[doc(alias = "first passage")]
pub struct Crossings {
    group: Group,
    segment: Segment,
    bounds: Option<PeriodicBox>,
    flights: BTreeMap<u64, OpenPath>,
    /// When each body was first seen; `None` once it has crossed or is gone.
    waiting: BTreeMap<u64, Option<EpochTime>>,
    /// Time until the first crossing, summed over the bodies that have crossed, and over all at the
    /// last sample.
    waited: [f64; 2],
    begun: Option<EpochTime>,
    counts: [u64; 2],
    /// Kinetic energy carried to the left less that carried to the right.
    energy: f64,
    first_passages: u64,
    left_out: u64,
    is_logged: bool,
    log: Vec<SegmentCrossing>,
    series: Vec<CrossingPoint>,
}

/// A crossing of the segment.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SegmentCrossing {
    /// Time of the crossing.
    pub time: f64,
    /// Number of the body, [`Body::id`].
    pub body: u64,
    /// Whether it crosses to the left of the direction of the segment.
    pub is_forward: bool,
    /// Distance of the place from the start of the segment (length).
    pub place: f64,
    /// Component of the velocity along the segment (length / time).
    pub along: f64,
    /// Component of the velocity across the segment, positive to the left (length / time).
    pub across: f64,
}

/// The crossings up to one sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct CrossingPoint {
    /// Time of the sample.
    pub time: f64,
    /// Crossings to the left and to the right so far.
    pub counts: [u64; 2],
    /// Bodies that have not crossed yet.
    pub waiting: u64,
}

/// The two points of a segment are one, or too far apart.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("a segment needs two different points of finite distance, but has {0:?}")]
pub struct SegmentError([[f64; 2]; 2]);

impl Crossings {
    /// Observes the segment from one point to another (length).
    ///
    /// # Errors
    /// [`SegmentError`]
    pub fn new(group: Group, points: [[f64; 2]; 2]) -> Result<Self, SegmentError> {
        let [start, end] = points.map(DVec2::from);
        Ok(Self {
            group,
            segment: Segment::new(start, end).ok_or(SegmentError(points))?,
            bounds: None,
            flights: BTreeMap::new(),
            waiting: BTreeMap::new(),
            waited: [0.0; 2],
            begun: None,
            counts: [0; 2],
            energy: 0.0,
            first_passages: 0,
            left_out: 0,
            is_logged: false,
            log: Vec::new(),
            series: Vec::new(),
        })
    }

    /// These crossings, each kept until it is [taken](Self::take).
    #[must_use]
    pub fn logged(self) -> Self {
        Self {
            is_logged: true,
            ..self
        }
    }

    /// Whether crossings are kept until they are taken.
    pub fn is_logged(&self) -> bool {
        self.is_logged
    }

    /// Length of the segment.
    pub fn length(&self) -> f64 {
        self.segment.length()
    }

    /// Crossings to the left and to the right of the direction of the segment up to the last
    /// sample.
    pub fn counts(&self) -> [u64; 2] {
        self.counts
    }

    /// Bodies that have crossed up to the last sample.
    pub fn first_passages(&self) -> u64 {
        self.first_passages
    }

    /// The counts at each sample.
    pub fn series(&self) -> &[CrossingPoint] {
        &self.series
    }

    /// The logged crossings since the last call, in the order of time up to the last sample.
    pub fn take(&mut self) -> Vec<SegmentCrossing> {
        std::mem::take(&mut self.log)
    }

    /// [Σx, Σw] up to the last sample: of the crossings to the left, of those to the right, of
    /// their difference and of the kinetic energy that it carries, over the time; and of the first
    /// passages of all bodies over the time for which they waited.
    pub fn sums(&self) -> [[f64; 2]; 5] {
        let time = match (self.begun, self.series.last()) {
            (Some(begun), Some(last)) => last.time - begun.to_f64(),
            _ => 0.0,
        };
        let [left, right] = self.counts.map(|count| count as f64);
        let rates = [left, right, left - right, self.energy].map(|sum| [sum, time]);
        let passages = [self.first_passages as f64, self.waited[1]];
        [rates[0], rates[1], rates[2], rates[3], passages]
    }

    /// Flights left out because they pass more than a million boxes.
    pub fn left_out(&self) -> u64 {
        self.left_out
    }

    fn measures(&self, body: &Body) -> bool {
        body.is_free() && self.group.contains(body)
    }

    /// Counts the crossings of a body up to here, and begins its next flight.
    fn end_flight(&mut self, body: &Body, end: FlightEnd, next: OpenPath) {
        let id = body.id();
        let (Some(flight), Some(bounds)) = (self.flights.insert(id, next), self.bounds) else {
            return;
        };
        let Some(passages) = self.segment.passages(&flight, end, &bounds) else {
            self.left_out += 1;
            return;
        };
        let first = passages
            .iter()
            .map(|passage| passage.after)
            .min_by(f64::total_cmp);
        if let Some(after) = first
            && let Some(seen) = self.waiting.insert(id, None).flatten()
        {
            self.first_passages += 1;
            self.waited[0] += flight.since.after(after).since(seen);
        }
        for passage in passages {
            let [along, across] = passage.velocity;
            let energy = 0.5 * body.mass() * (along * along + across * across);
            self.energy += if passage.is_forward { energy } else { -energy };
            self.counts[usize::from(!passage.is_forward)] += 1;
            if !self.is_logged {
                continue;
            }
            self.log.push(SegmentCrossing {
                time: flight.since.after(passage.after).to_f64(),
                body: id,
                is_forward: passage.is_forward,
                place: passage.place,
                along,
                across,
            });
        }
    }

    /// Counts the crossings of all bodies up to the time of the view.
    fn end_flights(&mut self, view: &View<'_>) {
        let time = view.time();
        for seen in view.bodies() {
            if self.measures(seen.body) {
                let position = seen.motion.position;
                self.end_flight(
                    seen.body,
                    FlightEnd { position, time },
                    flight_of(view, &seen),
                );
            }
        }
        self.log.sort_by(|a, b| a.time.total_cmp(&b.time));
    }
}

/// The flight of a body from the time of a view on.
fn flight_of(view: &View<'_>, seen: &BodyView<'_>) -> OpenPath {
    OpenPath {
        position: seen.motion.position,
        velocity: seen.motion.velocity,
        since: view.time(),
        gravity: view.gravity(),
        clock: DragClock::new(view.drag()),
    }
}

impl Observer for Crossings {
    #[inline]
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        bodies.into_iter().any(|body| self.measures(body))
    }

    fn start(&mut self, view: &View<'_>) {
        self.bounds = Some(view.bounds());
        self.begun.get_or_insert(view.time());
        let seen = view.bodies().filter(|seen| self.measures(seen.body));
        self.flights = seen
            .map(|seen| (seen.body.id(), flight_of(view, &seen)))
            .collect();
        let time = view.time();
        for (id, seen) in &mut self.waiting {
            if !self.flights.contains_key(id)
                && let Some(seen) = seen.take()
            {
                self.waited[0] += time.since(seen);
            }
        }
        for id in self.flights.keys() {
            self.waiting.entry(*id).or_insert(Some(time));
        }
    }

    fn pause(&mut self, view: &View<'_>) {
        self.end_flights(view);
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        for side in &report.sides {
            if !self.measures(side.body) {
                continue;
            }
            let Motion { position, .. } = side.before;
            let Some(flight) = self.flights.get(&side.body.id()) else {
                continue;
            };
            let next = OpenPath {
                position,
                velocity: side.after.velocity,
                since: report.time,
                ..*flight
            };
            let time = report.time;
            self.end_flight(side.body, FlightEnd { position, time }, next);
        }
    }

    fn sample(&mut self, view: &View<'_>) {
        self.end_flights(view);
        let time = view.time();
        let open = || self.waiting.values().flatten();
        let of_open: f64 = open().map(|seen| time.since(*seen)).sum();
        self.waited[1] = self.waited[0] + of_open;
        let waiting = open().count() as u64;
        self.series.push(CrossingPoint {
            time: time.to_f64(),
            counts: self.counts,
            waiting,
        });
    }
}

#[cfg(test)]
mod tests;
