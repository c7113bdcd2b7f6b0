//! Who flies how from when on: all there is to know to draw a gas in motion, over a stretch of so many contacts.

use carom_engine::{Body, CollisionReport, Observer, View};
use carom_kinematics::{EpochTime, Motion};
use glam::DVec2;
use serde::{Deserialize, Serialize};

/// The beginning of one straight flight of one body; it lasts until the next of the same body.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Flight {
    /// When it begins (time).
    pub time: f64,
    /// Number of the body, [`Body::id`](carom_engine::Body::id).
    pub body: u64,
    /// Place of the centre then, in the box or in an image beside it (length).
    pub position: DVec2,
    /// Velocity from then on (length / time).
    pub velocity: DVec2,
    /// Orientation then (radians); 0 for a disc, which never turns.
    pub angle: f64,
    /// Angular velocity from then on (radians / time); 0 for a disc.
    pub angular_velocity: f64,
}

/// Keeps the flights of all bodies from its first `start` on, until `capacity` flights are kept: first one of each body, then
/// one of each body that moves for each contact.
///
/// Bodies fly straight and turn evenly between contacts, so that the place of each is known at any time in between, and not
/// only at frames. What has no room is left out, and with it all that comes later.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::FlightLog;
///
/// let scene = Scene::from_toml("[[gas]]\nradius = 0.02\nmass = 1.0\nenergy = 1.0\ncount = 100")?;
/// let mut simulation = Simulation::new(&scene)?;
/// let mut log = FlightLog::new(300);
/// log.start(&simulation.view());
/// while !log.is_full() && simulation.step(1.0, &mut log)? {}
/// assert_eq!(log.flights().len(), 300);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[doc(alias = "trajectory")]
#[doc(alias = "events")]
pub struct FlightLog {
    capacity: usize,
    /// Numbers of the bodies, in ascending order; all bodies if absent.
    among: Option<Vec<u64>>,
    flights: Vec<Flight>,
}

impl FlightLog {
    /// An empty log with room for so many flights. Where there are more bodies, it ends with the first of them.
    pub fn new(capacity: usize) -> Self {
        Self { capacity, among: None, flights: Vec::new() }
    }

    /// An empty log of the flights of these bodies only, by [`Body::id`](carom_engine::Body::id).
    pub fn among(capacity: usize, bodies: impl IntoIterator<Item = u64>) -> Self {
        let mut among: Vec<u64> = bodies.into_iter().collect();
        among.sort_unstable();
        Self { capacity, among: Some(among), flights: Vec::new() }
    }

    fn logs(&self, body: &Body) -> bool {
        self.among.as_ref().is_none_or(|among| among.binary_search(&body.id()).is_ok())
    }

    /// The flights, in the order in which they began.
    pub fn flights(&self) -> &[Flight] {
        &self.flights
    }

    /// Whether no contact more has room.
    pub fn is_full(&self) -> bool {
        self.flights.len() + 2 > self.capacity
    }
}

fn flight(time: EpochTime, body: u64, motion: &Motion) -> Flight {
    Flight {
        time: time.to_f64(),
        body,
        position: motion.position,
        velocity: motion.velocity,
        angle: motion.orientation.radians(),
        angular_velocity: motion.angular_velocity,
    }
}

impl Observer for FlightLog {
    #[inline]
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        !self.is_full() && bodies.into_iter().any(|body| self.logs(body))
    }

    fn start(&mut self, view: &View<'_>) {
        if self.flights.is_empty() {
            let bodies = view.bodies().filter(|body| self.logs(body.body)).take(self.capacity);
            self.flights = bodies.map(|body| flight(view.time(), body.body.id(), &body.motion)).collect();
        }
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        if self.is_full() {
            return;
        }
        for side in &report.sides {
            if !side.body.is_fixed() && self.logs(side.body) {
                self.flights.push(flight(report.time, side.body.id(), &side.after));
            }
        }
    }
}
