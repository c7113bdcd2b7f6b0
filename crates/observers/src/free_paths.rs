//! The free paths of the bodies: path lengths between successive contacts (length).
//!
//! Between contacts a body moves in a straight line, so that its free path is |v| t, in the frame
//! of the box. For equal discs of diameter σ at equilibrium, n per area and with momentum 0, the
//! mean free path is the mean speed √(π kT / 2m) over the collision rate 2 n σ χ √(π kT / m):
//!
//! λ = 1 / (√8 n σ χ),
//!
//! with χ the pair distribution at contact, 1 in the dilute limit (Maxwell's mean free path in two
//! dimensions; Enskog's theory). With N discs n is (N − 1) / A, and λ is smaller by √(1 − 1/N),
//! because the speeds are those relative to the centre of mass. The distribution is not quite
//! exponential, since slow bodies have shorter paths. A body alone between fixed obstacles of
//! perimeter P in the accessible area A has λ = π A / P exactly, if its motion is ergodic
//! (Santaló's formula; Chernov 1997).

use std::collections::BTreeMap;

use carom_engine::{Body, CollisionReport, Observer, View};
use carom_geometry::{GeometryError, check_positive};
use carom_kinematics::{DragClock, EpochTime};
use glam::DVec2;
use serde::{Deserialize, Serialize};

use crate::{AdaptiveHistogram, Group};

/// Lengths of the flights of the bodies of a group from contact to contact, with any body.
///
/// A contact without impulse does not end a flight, and neither does an edit of the velocity, if
/// `start` is called after it. The mean free path is the path of all bodies since the first `start`
/// over their contacts: it includes the flights that the start or the end of the observation cuts,
/// and has no bias. The distribution has complete flights only, those that begin and end at an
/// observed contact. A flight much longer than the observation cannot be complete, so with n
/// contacts a body long ones are missing, which are a share of the order of 1/n.
///
/// ```
/// use carom_engine::{Observer, Scene, Simulation};
/// use carom_observers::{FreePaths, Group};
///
/// // A disc between the two sides of a wall: its centre moves from 0.1 to 0.9 and back.
/// let scene = Scene::from_toml(r"
///     [[wall]]
///     x = 0.0
///     [[molecule]]
///     atoms = [{ at = [0, 0], radius = 0.1, mass = 1 }]
///     at = [0.5, 0.5]
///     velocity = [2.0, 0.0]
/// ")?;
/// let mut simulation = Simulation::new(&scene)?;
/// let mut paths = FreePaths::new(Group::All, 1.0, 10)?;
/// paths.start(&simulation.view());
/// simulation.observe_until(10.0, &mut paths)?;
/// paths.sample(&simulation.view());
/// // A path of 20 and 25 contacts, with 24 complete flights between them.
/// assert!((paths.mean().expect("there are contacts") - 0.8).abs() < 1e-12);
/// assert_eq!((paths.flights(), paths.contacts()), (24, 25));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[doc(alias = "mean free path")]
pub struct FreePaths {
    group: Group,
    /// The flights that have begun, by the number of the body.
    open: BTreeMap<u64, OpenFlight>,
    /// Lengths of complete flights.
    lengths: AdaptiveHistogram,
    /// Path of the flights that have ended, also those cut by the start.
    ended: f64,
    /// Path of the open flights at the last sample.
    in_progress: f64,
    /// Number of contacts at which an observed flight ended.
    contacts: u64,
    interrupted: u64,
}

/// Largest rounding of a velocity that drag has slowed, relative to the velocity before. Larger:
/// edits of velocities are overlooked.
const SAME_VELOCITY: f64 = 1e-9;

/// A flight that has not ended.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct OpenFlight {
    /// Its length until the last change of velocity (length).
    length: f64,
    /// The time of the last change of velocity, and the velocity since.
    since: EpochTime,
    velocity: DVec2,
    /// The clock of the drag since then.
    clock: DragClock,
    /// Whether it began at an observed contact.
    has_begun: bool,
}

impl OpenFlight {
    fn length_until(&self, time: EpochTime) -> f64 {
        self.length + self.velocity.length() * self.clock.reading(time.since(self.since))
    }

    /// Whether this is its velocity at a time: to the bit, or with drag to rounding.
    fn goes_at(&self, velocity: DVec2, time: EpochTime) -> bool {
        if self.clock.is_free() {
            return self.velocity == velocity;
        }
        let slowing = self
            .clock
            .slowing(self.clock.reading(time.since(self.since)));
        let difference = (self.velocity * slowing - velocity).length();
        difference <= SAME_VELOCITY * self.velocity.length()
    }
}

impl FreePaths {
    /// Free paths with `bins` equal bins from 0 to `longest` (length); `bins` = 0 is taken as 1.
    ///
    /// # Errors
    /// [`GeometryError::NotPositive`] if `longest` is not positive and finite.
    pub fn new(group: Group, longest: f64, bins: usize) -> Result<Self, GeometryError> {
        let longest = check_positive("the longest free path of a histogram", longest)?;
        Ok(Self {
            lengths: AdaptiveHistogram::within(0.0, longest, bins),
            ..Self::adaptive(group, bins)
        })
    }

    /// Free paths in at least `bins` bins whose range follows their lengths, so that none is lost.
    pub fn adaptive(group: Group, bins: usize) -> Self {
        let lengths = AdaptiveHistogram::of_magnitudes(bins);
        Self {
            group,
            open: BTreeMap::new(),
            lengths,
            ended: 0.0,
            in_progress: 0.0,
            contacts: 0,
            interrupted: 0,
        }
    }

    /// Distribution of the lengths of the complete flights (length).
    pub fn lengths(&self) -> &AdaptiveHistogram {
        &self.lengths
    }

    /// The number of complete flights.
    pub fn flights(&self) -> u64 {
        self.lengths.total()
    }

    /// The number of contacts of the bodies at which an observed flight ended, complete or not.
    pub fn contacts(&self) -> u64 {
        self.contacts
    }

    /// The mean free path up to the last sample (length); `None` without contacts.
    #[doc(alias = "mean free path")]
    pub fn mean(&self) -> Option<f64> {
        let [path, contacts] = self.sums();
        (contacts > 0.0).then(|| path / contacts)
    }

    /// The path of all bodies up to the last sample (length) and the number of contacts that ended
    /// flights; their ratio is the mean free path.
    pub fn sums(&self) -> [f64; 2] {
        [self.ended + self.in_progress, self.contacts as f64]
    }

    /// The number of flights left out because an edit changed their velocity, and no `start`
    /// followed it.
    pub fn interrupted(&self) -> u64 {
        self.interrupted
    }

    /// The path of the open flights up to this time (length).
    fn open_until(&self, time: EpochTime) -> f64 {
        self.open
            .values()
            .map(|flight| flight.length_until(time))
            .sum()
    }

    fn measures(&self, body: &Body) -> bool {
        body.is_free() && self.group.contains(body)
    }
}

impl Observer for FreePaths {
    #[inline]
    fn watches(&self, bodies: [&Body; 2]) -> bool {
        bodies.into_iter().any(|body| self.measures(body))
    }

    /// Continues the flights with the velocities in the view, and begins those of other bodies.
    /// The flights of bodies that were removed or have left the group end.
    fn start(&mut self, view: &View<'_>) {
        let mut before = std::mem::take(&mut self.open);
        let mut open = BTreeMap::new();
        for body in view.bodies().filter(|view| self.measures(view.body)) {
            let (id, velocity) = (body.body.id(), body.motion.velocity);
            let clock = DragClock::new(view.drag());
            let begun = || OpenFlight {
                length: 0.0,
                since: view.time(),
                velocity,
                clock,
                has_begun: false,
            };
            let mut flight = before.remove(&id).unwrap_or_else(begun);
            if !flight.goes_at(velocity, view.time()) || flight.clock != clock {
                let length = flight.length_until(view.time());
                flight = OpenFlight {
                    length,
                    since: view.time(),
                    velocity,
                    clock,
                    ..flight
                };
            }
            open.insert(id, flight);
        }
        self.ended += before
            .values()
            .map(|flight| flight.length_until(view.time()))
            .sum::<f64>();
        self.open = open;
        self.in_progress = self.open_until(view.time());
    }

    fn collision(&mut self, report: &CollisionReport<'_>) {
        // A contact without impulse bends no path.
        if report.impulse == DVec2::ZERO {
            return;
        }
        for side in &report.sides {
            if !self.measures(side.body) {
                continue;
            }
            let velocity = side.after.velocity;
            let flight = OpenFlight {
                length: 0.0,
                since: report.time,
                velocity,
                clock: DragClock::new(report.drag),
                has_begun: true,
            };
            let Some(ended) = self.open.insert(side.body.id(), flight) else {
                continue;
            };
            if ended.goes_at(side.before.velocity, report.time) {
                let length = ended.length_until(report.time);
                self.ended += length;
                self.contacts += 1;
                if ended.has_begun {
                    self.lengths.add(length);
                }
            } else {
                self.interrupted += 1;
            }
        }
    }

    fn sample(&mut self, view: &View<'_>) {
        self.in_progress = self.open_until(view.time());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Estimate;
    use carom_engine::{Scene, Simulation};

    /// Both bumpers are images of one; the disc's centre moves over 1 − 2 (0.1 + 0.05).
    const ONE_PATH: &str = r"
        [[bumper]]
        radius = 0.1
        at = [0.0, 0.5]
        [[molecule]]
        atoms = [{ at = [0, 0], radius = 0.05, mass = 1 }]
        at = [0.3, 0.5]
        velocity = [1.0, 0.0]
    ";

    #[test]
    fn a_disc_between_two_bumpers_has_one_path() {
        let mut simulation = Simulation::new(&Scene::from_toml(ONE_PATH).unwrap()).unwrap();
        let mut paths = FreePaths::new(Group::All, 1.0, 10).unwrap();
        simulation.observe_until(7.3, &mut paths).unwrap();
        // The first contact, at 0.55, ends no complete flight: 0.55 + 9 × 0.7 = 6.85.
        assert_eq!((paths.flights(), paths.interrupted()), (9, 0));
        assert_eq!(paths.lengths().counts().iter().sum::<u64>(), 9);
        assert!((paths.mean().unwrap() - 0.7).abs() < 1e-12);
        let density: f64 = paths
            .lengths()
            .sums_in(&paths.lengths().bins())
            .iter()
            .map(|[x, w]| x / w * 0.1)
            .sum();
        assert!((density - 1.0).abs() < 1e-12);
    }

    /// A path of 7.3 with contacts at 0.55, 1.25, …, 6.85.
    #[test]
    fn flights_that_the_start_and_the_end_cut_count_in_the_mean() {
        let mut simulation = Simulation::new(&Scene::from_toml(ONE_PATH).unwrap()).unwrap();
        let mut paths = FreePaths::adaptive(Group::All, 10);
        paths.start(&simulation.view());
        for sample in 1..=73 {
            simulation
                .observe_until(0.1 * f64::from(sample), &mut paths)
                .unwrap();
            paths.sample(&simulation.view());
        }
        assert_eq!((paths.flights(), paths.contacts()), (9, 10));
        assert!(
            (paths.sums()[0] - 7.3).abs() < 1e-12 && (paths.mean().unwrap() - 0.73).abs() < 1e-12
        );
    }

    /// With some five contacts a body, complete flights alone would give a fifth less.
    #[test]
    fn the_mean_free_path_of_a_short_run_has_no_bias() {
        let (count, radius) = (200.0, 0.004);
        let mut sums = Vec::new();
        for seed in 1..=40 {
            let scene = format!(
                "[box]\nseed = {seed}\n[[gas]]\nradius = {radius}\nmass = 1.0\nenergy = 1.0\n\
                 velocities = \"maxwell\"\ncount = {count}"
            );
            let mut simulation = Simulation::new(&Scene::from_toml(&scene).unwrap()).unwrap();
            simulation.run_until(1.0).unwrap();
            let mut paths = FreePaths::adaptive(Group::All, 20);
            paths.start(&simulation.view());
            simulation.observe_until(2.0, &mut paths).unwrap();
            paths.sample(&simulation.view());
            let [path, contacts] = paths.sums();
            sums.push((path, contacts));
        }
        let estimate = Estimate::of_ratio(sums).unwrap();
        let expected = enskog(count, radius);
        assert!(
            (estimate.mean - expected).abs() < 4.0 * estimate.standard_error,
            "{estimate:?} {expected}"
        );
        assert!(estimate.standard_error < 0.01 * expected, "{estimate:?}");
    }

    /// The mean free path with χ at contact of Henderson (1975).
    fn enskog(count: f64, radius: f64) -> f64 {
        let eta = count * std::f64::consts::PI * radius * radius;
        let chi = (1.0 - 7.0 / 16.0 * eta) / ((1.0 - eta) * (1.0 - eta));
        (1.0 - 1.0 / count).sqrt() / (8f64.sqrt() * (count - 1.0) * 2.0 * radius * chi)
    }

    #[test]
    fn edits_of_the_energy_do_not_end_a_flight() {
        let mut simulation = Simulation::new(&Scene::from_toml(ONE_PATH).unwrap()).unwrap();
        let disc = simulation
            .view()
            .bodies()
            .find(|view| view.body.is_free())
            .unwrap()
            .body
            .key();
        let mut paths = FreePaths::new(Group::All, 0.9, 10).unwrap();
        paths.start(&simulation.view());
        for (edit, energy) in (1..=20).zip([0.5, 2.0].into_iter().cycle()) {
            simulation
                .observe_until(0.3 * f64::from(edit), &mut paths)
                .unwrap();
            simulation.reset_energy(disc, energy).unwrap();
            paths.start(&simulation.view());
        }
        let seen = paths.flights();
        let mean = |paths: &FreePaths| {
            let bins = paths.lengths().bins();
            let occupied = paths
                .lengths()
                .counts()
                .iter()
                .filter(|&&count| count > 0)
                .count();
            (occupied, bins.count())
        };
        assert!(seen > 5 && mean(&paths) == (1, 10), "{paths:?}");
        // Without `start` the flight is left out.
        simulation.reset_energy(disc, 8.0).unwrap();
        simulation.observe_until(7.0, &mut paths).unwrap();
        assert_eq!(paths.interrupted(), 1);
        assert!(paths.flights() > seen && mean(&paths) == (1, 10));
        simulation.remove(disc).unwrap();
        paths.start(&simulation.view());
        assert!(paths.open.is_empty());
    }

    #[test]
    fn a_dilute_gas_has_maxwells_mean_free_path() {
        let (count, radius) = (200.0, 0.004);
        let scene = format!(
            "[box]\nseed = 8\n[[gas]]\nradius = {radius}\nmass = 1.0\nenergy = 1.0\ncount = {count}"
        );
        let mut simulation = Simulation::new(&Scene::from_toml(&scene).unwrap()).unwrap();
        simulation.run_until(5.0).unwrap();
        let mut paths = FreePaths::new(Group::All, 2.0, 20).unwrap();
        simulation.observe_until(10.0, &mut paths).unwrap();
        let mut blocks = Vec::new();
        paths.start(&simulation.view());
        for block in 1..=40 {
            let before = paths.sums();
            simulation
                .observe_until(10.0 + 2.0 * f64::from(block), &mut paths)
                .unwrap();
            paths.sample(&simulation.view());
            let after = paths.sums();
            blocks.push((after[0] - before[0], after[1] - before[1]));
        }
        let estimate = Estimate::of_ratio(blocks).unwrap();
        let expected = enskog(count, radius);
        assert!(
            (estimate.mean - expected).abs() < 5.0 * estimate.standard_error,
            "{estimate:?} {expected}"
        );
        assert!(estimate.standard_error < 0.01 * expected);
    }
}
