//! Measurements in every run: overlaps, energy, momentum, and the consistency of each collision.

use anyhow::Result;
use carom::{CollisionReport, EpochTime, Observer, Scene};
use glam::DVec2;

use carom_methods::AnySimulation;

use super::{Engine, ExtremeFinding};

/// Observer that checks each collision.
#[derive(Debug, Clone)]
pub struct Watch {
    /// Times of the first collisions (time), for comparison with closed forms.
    pub times: Vec<f64>,
    /// Atoms of the first collisions.
    pub atoms: Vec<[Option<u32>; 2]>,
    /// Bodies of the first collisions.
    pub bodies: Vec<[u64; 2]>,
    begun: EpochTime,
    last: Option<EpochTime>,
    /// Smallest nonzero interval between consecutive collisions (time).
    pub smallest_interval: f64,
    /// Number of collisions at the same time as the previous one.
    pub at_once: usize,
    /// Number of collisions earlier than the previous one.
    pub backwards: usize,
    /// Largest deviation of the normal velocity after a collision from the value given by the
    /// elasticity, relative to the speeds.
    pub response_error: f64,
    /// Largest separation speed before a collision, relative to the speeds.
    pub parting: f64,
    /// Largest change of a body's angular momentum about the point of contact, relative to its spin
    /// angular momentum.
    pub angular_error: f64,
}

/// Number of collisions whose times and bodies are stored.
const KEPT: usize = 10_000;

impl Default for Watch {
    fn default() -> Self {
        Self::since(EpochTime::ZERO)
    }
}

impl Watch {
    /// Starts the measurement; times count from `begun`.
    pub fn since(begun: EpochTime) -> Self {
        Self {
            times: Vec::new(),
            atoms: Vec::new(),
            bodies: Vec::new(),
            begun,
            last: None,
            smallest_interval: f64::INFINITY,
            at_once: 0,
            backwards: 0,
            response_error: 0.0,
            parting: 0.0,
            angular_error: 0.0,
        }
    }
}

impl Observer for Watch {
    fn collision(&mut self, report: &CollisionReport<'_>) {
        if self.times.len() < KEPT {
            self.times.push(report.time.since(self.begun));
            self.atoms
                .push([report.sides[0].atom, report.sides[1].atom]);
            self.bodies
                .push([report.sides[0].body.id(), report.sides[1].body.id()]);
        }
        if let Some(last) = self.last {
            let interval = report.time.since(last);
            if interval > 0.0 {
                self.smallest_interval = self.smallest_interval.min(interval);
            }
            self.at_once += usize::from(interval == 0.0);
            self.backwards += usize::from(interval < 0.0);
        }
        self.last = Some(report.time);
        let [a, b] = &report.sides;
        let closing = |before: bool| {
            let [one, two] = [a, b].map(|side| if before { side.before } else { side.after });
            report
                .normal
                .dot(one.velocity_of(a.arm) - two.velocity_of(b.arm))
        };
        // Scale of the rounding of positions, arms and velocities.
        let speed = |side: &carom::engine::Side<'_>| {
            let of = |m: &carom::Motion| {
                m.velocity.length() + m.angular_velocity.abs() * side.arm.length()
            };
            of(&side.before) + of(&side.after)
        };
        let scale = speed(a) + speed(b);
        let [before, after] = [closing(true), closing(false)];
        self.parting = self.parting.max(-before / scale);
        let requested = -report.elasticity.coefficient() * before.max(0.0);
        if before > 0.0 {
            self.response_error = self.response_error.max((after - requested).abs() / scale);
        }
        for side in [a, b] {
            let (arm, impulse) = (side.arm, side.momentum_change());
            let size = arm.length() * impulse.length();
            if size > 0.0 && !side.body.is_locked() {
                let error = (arm.perp_dot(impulse) - side.angular_momentum_change()).abs();
                // The rounding error is relative to the whole spin, not to its change.
                let moment = 1.0 / side.body.inertia().inverse_moment;
                let spin = moment
                    * (side.before.angular_velocity.abs() + side.after.angular_velocity.abs());
                self.angular_error = self.angular_error.max(error / (size + spin));
            }
        }
    }
}

/// Results of a run.
#[derive(Debug, Clone)]
pub struct Survey {
    /// Measurements of the collisions.
    pub watch: Watch,
    /// Number of collisions.
    pub collisions: u64,
    /// Largest number of overlapping pairs at a sample.
    pub overlapping: usize,
    /// Largest relative difference between the energy and the ledger.
    pub energy: f64,
    /// Largest change of total momentum relative to the sum of momentum magnitudes; 0 if a body is
    /// fixed.
    pub momentum: f64,
}

/// Approximate number of samples in a survey.
const SAMPLES: u64 = 64;

/// Largest number of time slices, in case no collision occurs.
const MAX_SLICES: usize = 4096;

/// A slice ends early after this multiple of its intended number of collisions.
const EARLY_END_FACTOR: f64 = 8.0;

/// Runs until `collisions` more contacts have occurred and calls `look` between slices of time.
///
/// # Errors
/// The run fails.
pub fn run_collisions(
    run: &mut AnySimulation,
    collisions: u64,
    observer: &mut dyn Observer,
    mut look: impl FnMut(&AnySimulation),
) -> Result<()> {
    let begun = run.view().counters().collisions;
    let fastest = run
        .view()
        .bodies()
        .map(|body| body.motion.velocity.length())
        .fold(0.0, f64::max);
    let spin = run
        .view()
        .bodies()
        .map(|body| body.motion.angular_velocity.abs())
        .fold(0.0, f64::max);
    let side = run.view().bounds().sides().min_element();
    // Discs packed to 1e-9 of their size would have millions of contacts in a longer first slice.
    let mut slice = 1e-14 * (side / fastest).min(1e3 / spin);
    for _ in 0..MAX_SLICES {
        let before = run.view().counters().collisions;
        if before - begun >= collisions || !slice.is_finite() {
            break;
        }
        let until = run.time().after(slice);
        // The intended number of collisions of a slice; its duration changes by at most a factor of
        // 4.
        let requested = (collisions / SAMPLES).max(1) as f64;
        let so_far = |run: &AnySimulation| run.view().counters().collisions - before;
        while !run.observe_epoch(until, observer)? {
            // A molecule of extreme spin heats a cold gas suddenly: the rest of the slice would
            // have millions of contacts.
            if so_far(run) as f64 > EARLY_END_FACTOR * requested {
                break;
            }
        }
        look(run);
        let new = so_far(run);
        slice *= if new == 0 {
            4.0
        } else {
            (requested / new as f64).clamp(0.25, 4.0)
        };
    }
    Ok(())
}

/// Builds a scene and runs it for `collisions` contacts.
///
/// # Errors
/// The scene cannot be built, or the run fails.
pub fn survey(engine: Engine, scene: &Scene, collisions: u64) -> Result<Survey> {
    let mut run = engine.simulate(scene)?;
    survey_of(&mut run, collisions)
}

/// Continues a run for `collisions` contacts.
///
/// # Errors
/// The run fails.
pub fn survey_of(run: &mut AnySimulation, collisions: u64) -> Result<Survey> {
    let mut watch = Watch::since(run.time());
    let (mut overlapping, mut energy, mut momentum) = (0, 0.0f64, 0.0f64);
    let free = run.view().bodies().all(|body| !body.body.is_fixed());
    let start = run.view().momentum();
    run_collisions(run, collisions, &mut watch, |run| {
        let view = run.view();
        let overlaps = view.overlaps();
        overlapping = overlapping.max(overlaps.pairs);
        energy = energy.max((view.energy() / view.ledger().booked() - 1.0).abs());
        if free {
            let size: f64 = view
                .bodies()
                .map(|body| body.body.molecule().mass() * body.motion.velocity.length())
                .sum();
            momentum = momentum.max((view.momentum() - start).length() / size);
        }
    })?;
    let collisions = run.view().counters().collisions;
    Ok(Survey {
        watch,
        collisions,
        overlapping,
        energy,
        momentum,
    })
}

impl Survey {
    /// Conditions that hold in every run.
    pub fn findings(&self, name: &str) -> Vec<ExtremeFinding> {
        self.findings_to(name, 1e-13)
    }

    /// These conditions, with the largest relative change that is allowed of the angular momentum
    /// about a contact.
    pub fn findings_to(&self, name: &str, angular: f64) -> Vec<ExtremeFinding> {
        let named = |what: &str| {
            if name.is_empty() {
                what.to_owned()
            } else {
                format!("{name}: {what}")
            }
        };
        let watch = &self.watch;
        vec![
            ExtremeFinding::never(named("overlapping pairs"), self.overlapping),
            ExtremeFinding::new(named("energy drift, relative"), self.energy, 1e-12),
            ExtremeFinding::new(
                named("drift of the momentum, relative"),
                self.momentum,
                1e-12,
            ),
            ExtremeFinding::never(named("collisions out of time order"), watch.backwards),
            ExtremeFinding::new(
                named("separation speed before a contact, relative"),
                watch.parting,
                1e-6,
            ),
            ExtremeFinding::new(
                named("speed after a contact, relative error"),
                watch.response_error,
                1e-13,
            ),
            ExtremeFinding::new(
                named("angular momentum about a contact, relative error"),
                watch.angular_error,
                angular,
            ),
            ExtremeFinding::never(
                named("runs without collisions"),
                usize::from(self.collisions == 0),
            ),
        ]
    }
}

/// Velocity of the body that was added as number `index`.
pub fn velocity(run: &AnySimulation, index: usize) -> DVec2 {
    run.view()
        .bodies()
        .nth(index)
        .map_or(DVec2::NAN, |body| body.motion.velocity)
}

/// Position in the box of the body that was added as number `index`.
pub fn place(run: &AnySimulation, index: usize) -> DVec2 {
    run.view()
        .bodies()
        .nth(index)
        .map_or(DVec2::NAN, |body| body.motion.position)
}
