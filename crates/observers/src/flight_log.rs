//! The flights of all bodies over a number of contacts, from which the motion of the gas can be
//! drawn exactly.

use carom_engine::{Body, CollisionReport, Observer, View};
use carom_kinematics::{EpochTime, Motion};
use glam::DVec2;
use serde::{Deserialize, Serialize};

/// The begin of one free flight of a body; it lasts until the next flight of the same body.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct LoggedFlight {
    /// Begin of the flight (time).
    pub time: f64,
    /// Number of the body, [`Body::id`](carom_engine::Body::id).
    pub body: u64,
    /// Position of the centre then, in the box or in an adjacent image (length).
    pub position: DVec2,
    /// Velocity during the flight (length / time).
    pub velocity: DVec2,
    /// Orientation then (radians); 0 for a disc, which never turns.
    pub angle: f64,
    /// Angular velocity during the flight (radians / time); 0 for a disc.
    pub angular_velocity: f64,
}

/// Records the flights of all bodies from its first `start` on, up to `capacity` flights: first one
/// of each body, then one of each moving body for each contact.
///
/// Bodies move uniformly between contacts, so their positions are known at all times, and not only
/// at frames. When the capacity is reached, all later flights are omitted.
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
    flights: Vec<LoggedFlight>,
}

impl FlightLog {
    /// An empty log with a capacity of that many flights. If there are more bodies, it holds only
    /// the first ones.
    pub fn new(capacity: usize) -> Self {
        Self {
            capacity,
            among: None,
            flights: Vec::new(),
        }
    }

    /// An empty log of the flights of these bodies only, by [`Body::id`](carom_engine::Body::id).
    pub fn among(capacity: usize, bodies: impl IntoIterator<Item = u64>) -> Self {
        let mut among: Vec<u64> = bodies.into_iter().collect();
        among.sort_unstable();
        Self {
            capacity,
            among: Some(among),
            flights: Vec::new(),
        }
    }

    fn logs(&self, body: &Body) -> bool {
        self.among
            .as_ref()
            .is_none_or(|among| among.binary_search(&body.id()).is_ok())
    }

    /// The flights in order of their begin.
    pub fn flights(&self) -> &[LoggedFlight] {
        &self.flights
    }

    /// Whether there is no capacity for another contact.
    pub fn is_full(&self) -> bool {
        self.flights.len() + 2 > self.capacity
    }
}

fn flight(time: EpochTime, body: u64, motion: &Motion) -> LoggedFlight {
    LoggedFlight {
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
            let bodies = view
                .bodies()
                .filter(|body| self.logs(body.body))
                .take(self.capacity);
            self.flights = bodies
                .map(|body| flight(view.time(), body.body.id(), &body.motion))
                .collect();
        }
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        if self.is_full() {
            return;
        }
        for side in &report.sides {
            if !side.body.is_fixed() && self.logs(side.body) {
                self.flights
                    .push(flight(report.time, side.body.id(), &side.after));
            }
        }
    }
}
